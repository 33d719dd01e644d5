//! The command line as a user meets it: what is printed where, what is written, and how it ends.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::program::{discreta, ended, run};
use serde_json::Value;

const LINE: &str = "circuits/evaluation/line.json";

/// A counter that needs 2^63 clocks to come to its end.
const LONG: &str = r#"{
  "modules": {
    "long": {
      "ports": { "clk": { "direction": "input" }, "reset": { "direction": "input" }, "q": { "direction": "output", "width": 64 } },
      "cells": {
        "count": { "type": "counter", "parameters": { "width": 64 }, "connections": { "clk": "clk", "reset": "reset", "q": "q" } }
      }
    }
  },
  "simulation": {
    "clocks": { "clk": { "period": 2 } },
    "stimulus": [{ "at": 0, "set": { "reset": 1 } }, { "at": 1, "set": { "reset": 0 } }],
    "until": { "net": "q", "value": 9223372036854775807 },
    "limit": { "time": "9000000000s" }
  }
}"#;

/// What a command must print to standard error when it ends with 2.
#[track_caller]
fn refused(args: &[&str], parts: &[&str]) {
    let (status, stdout, stderr) = run(args);
    assert_eq!((status, stdout.as_str()), (2, ""), "{args:?}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{args:?} does not say {part:?} but\n{stderr}");
    }
}

fn entries(dir: &Path) -> Vec<String> {
    let names = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// A directory with the circuit [`LONG`], and the circuit's path.
fn long() -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("long.json");
    std::fs::write(&path, LONG).unwrap();
    (dir, path.display().to_string())
}

/// Waits until something holds, but not for ever.
#[track_caller]
fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(30), "waited for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A run of [`LONG`] that has begun to write its waveform.
fn running(dir: &Path, circuit: &str) -> Child {
    let target = dir.join("long.vcd");
    let mut command = discreta(&["run", circuit, "-o", target.to_str().unwrap()]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("a waveform", || {
        std::fs::read_dir(dir).unwrap().any(|e| {
            let e = e.unwrap();
            e.file_name().to_string_lossy().ends_with(".part") && e.metadata().is_ok_and(|m| m.len() > 1 << 16)
        })
    });
    assert!(!target.exists(), "a file at its place before it is complete");
    child
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn a_run_says_in_two_lines_how_it_went() {
    let (status, stdout, stderr) = run(&["run", LINE]);
    let expected = "\
circuits/evaluation/line.json: stopped at end = 1, 170 ns, 8 clocks of dt
  x = 0  y = 0  xt = 5  yt = 3  end = 1
";
    assert_eq!((status, stdout.as_str(), stderr.as_str()), (0, expected, ""));

    let (status, stdout, _) = run(&["run", LINE, "-s", "dx=2", "-s", "dy=0", "-v"]);
    assert_eq!(status, 0);
    assert!(stdout.contains("xt = 2  yt = 0  end = 1") && stdout.contains("engine event"), "{stdout}");
}

#[test]
fn a_scenario_runs_the_circuit_that_it_names() {
    let (status, stdout, _) = run(&["run", "traces/evaluation/line_0_3.json"]);
    assert_eq!(status, 0);
    assert!(stdout.starts_with("circuits/evaluation/line.json: stopped at end = 1"), "{stdout}");
    assert!(stdout.contains("xt = 0  yt = 3"), "{stdout}");
}

#[test]
fn json_has_the_same_for_programs() {
    let (status, stdout, stderr) = run(&["run", LINE, "-s", "dx=1", "-s", "dy=1", "--format", "json"]);
    assert_eq!((status, stderr.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["circuit"], LINE);
    assert_eq!(json["ok"], true);
    assert_eq!(json["stop"], "until");
    assert_eq!(json["time"], 50);
    assert_eq!(json["timescale"], "1ns");
    assert_eq!(json["clocks"]["dt"], 2);
    assert_eq!(json["outputs"]["xt"], "1");
    assert_eq!(json["failures"], Value::Array(vec![]));
    assert!(json["events"].as_u64().unwrap() > 0);

    let (status, stdout, _) = run(&["check", "tests/bad/unknown_port.json", LINE, "--format", "json"]);
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((status, &json[0]["errors"], &json[1]["errors"]), (1, &2.into(), &0.into()));
    let first = &json[0]["diagnostics"][0];
    assert_eq!((&first["code"], &first["line"], &first["column"]), (&"unknown-port".into(), &8.into(), &74.into()));
}

#[test]
fn a_waveform_goes_to_a_file_or_has_standard_output_to_itself() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("line.vcd");
    let (status, stdout, stderr) = run(&["run", LINE, "-o", path.to_str().unwrap()]);
    assert_eq!((status, stderr.as_str()), (0, ""));
    assert!(stdout.ends_with(&format!("  wrote {}\n", path.display())), "{stdout}");
    let written = std::fs::read_to_string(&path).unwrap();
    assert!(written.starts_with("$version") && written.contains("$dumpvars"), "{written}");
    let last = written.lines().rfind(|l| l.starts_with('#'));
    assert_eq!(last, Some("#170"));
    assert_eq!(entries(dir.path()), ["line.vcd"]);

    let (status, stdout, stderr) = run(&["run", LINE, "-o", "-"]);
    assert_eq!((status, stdout.as_str()), (0, written.as_str()));
    assert!(stderr.starts_with(LINE) && stderr.contains("stopped at end = 1"), "{stderr}");

    // once, even if it is named twice
    let twice = ["run", LINE, "-o", "-", "-o", "-"];
    assert_eq!(run(&twice).1, written);
}

/// The same waveform in both formats at once; what reads FST is a crate of its own.
#[test]
fn a_waveform_is_fst_if_its_name_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).display().to_string();
    let (vcd, fst) = (at("a.vcd"), at("a.fst"));
    for circuit in [LINE, "circuits/evaluation/line_gates.json", "circuits/feed/system.json"] {
        assert_eq!(run(&["run", circuit, "-o", &vcd, "-o", &fst]).0, 0);
        assert!(std::fs::metadata(&fst).unwrap().len() < std::fs::metadata(&vcd).unwrap().len());
        let (status, stdout, stderr) = run(&["diff", &vcd, &fst]);
        assert_eq!((status, stderr.as_str()), (0, ""));
        assert!(stdout.starts_with("The same: ") && !stdout.contains(" 0 signals"), "{stdout}");
    }
    #[cfg(unix)]
    {
        let device = at("device.fst");
        std::os::unix::fs::symlink("/dev/stdout", &device).unwrap();
        let (status, _, stderr) = run(&["run", LINE, "-o", &device]);
        assert_eq!(status, 2);
        assert!(stderr.contains("FST can only go to a file; write VCD here"), "{stderr}");
    }
}

#[test]
fn only_what_is_asked_for_is_recorded() {
    let (status, stdout, stderr) = run(&["run", LINE, "--trace", "k*", "--trace", "adder.*", "-o", "-"]);
    assert_eq!(status, 0);
    let vars: Vec<&str> = stdout.lines().filter_map(|l| l.trim().strip_prefix("$var ")).collect();
    assert!(!vars.is_empty() && vars.iter().all(|v| v.split(' ').nth(3).unwrap().starts_with('k')), "{vars:?}");
    assert!(stderr.contains("warning[no-match]: `adder.*` matches no net\n --> --trace:1:1"), "{stderr}");

    let (status, _, stderr) = run(&["run", LINE, "--trace", "kxo"]);
    assert_eq!(status, 0);
    assert!(stderr.contains("did you mean `kox`?"), "{stderr}");
    refused(&["run", LINE, "--trace", "k\\"], &["error[bad-glob]", "it ends in `\\`"]);
}

#[test]
fn a_place_that_cannot_be_written_is_found_and_named() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).display().to_string();
    refused(
        &["run", LINE, "-o", &at("no/a.vcd")],
        &["cannot write `", "no such file", "help: make the directory first"],
    );
    refused(&["run", LINE, "-o", &at("")], &["is a directory", "name a file in it"]);
    refused(&["run", LINE, "-o", &at("a.ghw")], &["written as VCD or FST, not as ghw", "end the name in .vcd or .fst"]);
    refused(&["run", LINE, "-o", ""], &["a value is required"]);
    refused(&["run", LINE, "-o", LINE], &["waveforms are written as VCD or FST"]);
    std::fs::write(dir.path().join("circuit"), LONG).unwrap();
    refused(&["run", &at("circuit"), "-o", &at("circuit")], &["it is an input of this command"]);
    assert_eq!(std::fs::read_to_string(dir.path().join("circuit")).unwrap(), LONG);
    assert_eq!(entries(dir.path()), ["circuit"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    refused(&["run", LINE, "-o", "/dev/full"], &["cannot write `/dev/full`: no space left on device", "make room"]);
    for args in [&["run", LINE][..], &["interpolate", "ef-line", "--to", "5,3"], &["schema"], &["man"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let (status, _, stderr) = ended(discreta(args).stdout(full).output().unwrap());
        assert_eq!(status, 2, "{args:?}");
        assert!(stderr.contains("cannot write to standard output: no space left on device"), "{stderr}");
    }
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let (status, _, stderr) = ended(discreta(&["run", LINE, "-o", "-"]).stdout(full).output().unwrap());
    assert_eq!(status, 2, "{stderr}");
    assert!(stderr.contains("no space left on device"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn who_reads_enough_may_close_the_pipe() {
    let (_dir, circuit) = long();
    let endless = ["run", circuit.as_str(), "-o", "-"];
    let steps = ["interpolate", "ef-line", "--to", "100000,100000"];
    for args in [&endless[..], &steps[..]] {
        let mut child = discreta(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut first = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
        assert!(!first.is_empty());
        wait_for("an end", || child.try_wait().unwrap().is_some());
        let (status, _, stderr) = ended(child.wait_with_output().unwrap());
        assert_eq!((status, stderr.as_str()), (0, ""), "{args:?}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_whole_waveform_up_to_there() {
    let (dir, circuit) = long();
    let mut child = running(dir.path(), &circuit);
    interrupt(&child);
    wait_for("an end", || child.try_wait().unwrap().is_some());
    let (status, stdout, stderr) = ended(child.wait_with_output().unwrap());
    assert_eq!(status, 1, "{stderr}");
    assert!(stdout.contains(": interrupted, "), "{stdout}");
    let time = stderr
        .strip_prefix("interrupted at ")
        .and_then(|s| s.strip_suffix(" ns; the waveform holds everything up to there\n"));
    let time: u64 = time.unwrap_or_else(|| panic!("{stderr}")).parse().unwrap();
    assert_eq!(entries(dir.path()), ["long.json", "long.vcd"]);

    // by another reader: q counts the rising edges at 3, 5, … after the reset and the last time is the one that was told
    let file = std::fs::File::open(dir.path().join("long.vcd")).unwrap();
    let mut parser = vcd::Parser::new(BufReader::new(file));
    let header = parser.parse_header().unwrap();
    let q = header.find_var(&["long", "q"]).unwrap().code;
    let (mut now, mut last) = (0, 0);
    for command in parser {
        match command.unwrap() {
            vcd::Command::Timestamp(t) => now = t,
            vcd::Command::ChangeVector(id, value) if id == q && now > 1 => {
                last = value.iter().fold(0u64, |n, bit| n << 1 | u64::from(bit == vcd::Value::V1));
                assert_eq!(last, now / 2);
            }
            _ => {}
        }
    }
    assert!(last > 100);
    assert!(now == time || now + 1 == time, "{now} {time}");
}

#[cfg(unix)]
#[test]
fn killed_it_leaves_nothing_that_looks_whole() {
    let (dir, circuit) = long();
    let mut child = running(dir.path(), &circuit);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!dir.path().join("long.vcd").exists());
}

#[test]
fn a_limit_before_the_stop_condition_is_a_failure() {
    let (status, stdout, _) = run(&["run", LINE, "--cycles", "3", "--until", "end"]);
    assert_eq!(status, 1);
    assert!(stdout.contains("limit reached before end = 1, 70 ns, 3 clocks of dt"), "{stdout}");
    // who asks for so many clocks is content to get them
    let (status, stdout, _) = run(&["run", LINE, "--cycles", "3"]);
    assert_eq!(status, 0);
    assert!(stdout.contains("ran to the end, 70 ns, 3 clocks of dt"), "{stdout}");
    let (status, stdout, _) = run(&["run", LINE, "--cycles", "0"]);
    assert!(status == 0 && stdout.contains("0 clocks of dt"), "{stdout}");
    let (status, stdout, _) = run(&["run", LINE, "--time", "0.05us"]);
    assert!(status == 0 && stdout.contains("ran to the end, 50 ns, 2 clocks of dt"), "{stdout}");
    let (status, stdout, _) = run(&["run", LINE, "--until", "xt=3"]);
    assert!(status == 0 && stdout.contains("stopped at xt = 3, 110 ns"), "{stdout}");
    let (status, stdout, _) = run(&["run", LINE, "--cycles", &u64::MAX.to_string()]);
    assert!(status == 0 && stdout.contains("stopped at end = 1"), "{stdout}");
}

#[test]
fn parameters_and_inputs_of_the_command_line() {
    let (status, stdout, _) = run(&["run", LINE, "-p", "W=4", "-s", "dx=4'b1111", "-s", "dy=8"]);
    assert!(status == 0 && stdout.contains("xt = 15  yt = 8"), "{stdout}");
    refused(&["run", LINE, "-p", "w=4"], &["`line` has no parameter `w`", " --> -p:1:1", "did you mean `W`?"]);
    refused(&["run", LINE, "-p", "W=33"], &["must be at most 32, not 33", " ::: circuits/evaluation/line.json:10:"]);
    refused(&["run", LINE, "-p", "W"], &["write it as NAME=VALUE"]);
    refused(&["run", LINE, "-s", "xd=1"], &["has no net `xd`", " --> -s:1:1", "did you mean `dx`?"]);
    refused(&["run", LINE, "-s", "dx="], &["write it as NAME=VALUE"]);
    refused(&["run", LINE, "-s", "dx=256"], &["256 does not fit 8 bits (at most 255)"]);
    refused(
        &["run", LINE, "-s", "dy=-8"],
        &[" --> -s:1:", "without a sign", "declare the port with `\"signed\": true`"],
    );
    refused(&["run", LINE, "-s", "xt=1"], &["`xt` is not an input", "the inputs are start, dx, dy, xh, yh, dt"]);
    refused(&["run", LINE, "--until", "and=1"], &["has no net `and`", " --> --until:1:1"]);
    refused(&["run", LINE, "--time", "5parsec"], &["`parsec` is not a unit of time"]);
    refused(&["run", LINE, "--time", "1fs"], &["not a whole number of ticks of 1ns"]);
    refused(&["run", LINE, "--time", "1us", "--cycles", "3"], &["cannot be used with"]);
    refused(&["run", LINE, "--limit", "wdth=3"], &["there is no limit `wdth`; did you mean `width`?"]);
    refused(&["run", "circuits/lib/arithmetic.json"], &["several modules that no other uses", "name one"]);
    refused(&["run", "circuits/evaluation/lin.json"], &["there is no such file", "did you mean `line.json`?"]);
    refused(&["run", "circuits"], &["it is a directory"]);
    refused(&["run", ""], &["a value is required"]);
}

#[test]
fn an_unknown_value_at_a_control_is_told() {
    let unknown = ["run", LINE, "-s", "dx=x", "--cycles", "20", "--x-control"];
    let with = |what| run(&[&unknown[..], &[what]].concat());
    let (status, _, stderr) = with("warn");
    assert_eq!(status, 0);
    let first = "warning[unknown-control]: at 60 ns an unknown value reaches `clk` of `kox` by the net `x` (circuits/";
    assert!(stderr.starts_with(first), "{stderr}");
    let (status, stdout, stderr) = with("error");
    assert_eq!(status, 1);
    assert!(stdout.contains("an unknown value reached a control, 60 ns"), "{stdout}");
    assert!(stderr.starts_with(&first.replace("warning", "error")), "{stderr}");
    let (status, _, stderr) = with("ignore");
    assert_eq!((status, stderr.as_str()), (0, ""));
}

#[test]
fn a_failed_expectation_is_told_with_its_place() {
    let dir = tempfile::tempdir().unwrap();
    let circuit = Path::new(env!("CARGO_MANIFEST_DIR")).join(LINE);
    let path = dir.path().join("s.json");
    let simulation = r#""simulation": { "expect": [ { "net": "xt", "value": 4 } ] }"#;
    std::fs::write(&path, format!("{{\n  \"circuit\": \"{}\",\n  {simulation}\n}}\n", circuit.display())).unwrap();
    let (status, _, stderr) = run(&["run", path.to_str().unwrap()]);
    assert_eq!(status, 1);
    assert!(stderr.starts_with("error[expectation]: `xt` is 5 at the end (170 ns), not 4\n"), "{stderr}");
    assert!(stderr.contains("s.json:3:55"), "{stderr}");
}

#[test]
fn check_looks_at_every_file() {
    let library = "circuits/lib/storage.json";
    let (status, stdout, stderr) = run(&["check", LINE, library, "traces/evaluation/line_5_3.json"]);
    let expected = format!("{LINE}: no faults\n{library}: no faults\ntraces/evaluation/line_5_3.json: no faults\n");
    assert_eq!((status, stdout, stderr.as_str()), (0, expected, ""));

    let (status, stdout, stderr) =
        run(&["check", "tests/bad/loop.json", "tests/bad/unknown_top.json", "nothing.json", LINE]);
    let expected = format!(
        "tests/bad/loop.json: 1 warning\ntests/bad/unknown_top.json: 1 error\nnothing.json: 1 error\n{LINE}: no faults\n"
    );
    assert_eq!((status, stdout), (2, expected), "a file that is not there is more than a fault");
    for part in ["combinational-loop", "no module `cuont`", "there is no such file"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    let (status, ..) = run(&["check", "tests/bad/loop.json"]);
    assert_eq!(status, 0, "warnings are no errors");
}

/// A directory with a circuit, and a scenario of it below `traces`.
fn project() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("traces")).unwrap();
    let scenario = r#"{ "circuit": "../long.json", "simulation": { "until": { "net": "q", "value": 5 } } }"#;
    std::fs::write(dir.path().join("long.json"), LONG).unwrap();
    std::fs::write(dir.path().join("traces/to_five.json"), scenario).unwrap();
    dir
}

fn test_in(dir: &Path, args: &[&str]) -> (i32, String, String) {
    ended(discreta(&[&["test"], args].concat()).current_dir(dir).output().unwrap())
}

#[test]
fn test_compares_with_golden_traces_and_blesses_them() {
    let dir = project();
    let (status, stdout, _) = test_in(dir.path(), &[]);
    assert_eq!(status, 0);
    assert_eq!(stdout, "traces/to_five.json: ok (no golden trace; --bless makes one)\n\n1 passed, 0 failed\n");
    assert_eq!(entries(&dir.path().join("traces")), ["to_five.json"]);

    let (status, stdout, _) = test_in(dir.path(), &["--bless"]);
    assert_eq!((status, stdout.as_str()), (0, "traces/to_five.json: blessed\n\n1 passed, 0 failed\n"));
    assert_eq!(entries(&dir.path().join("traces")), ["to_five.json", "to_five.vcd"]);
    let (status, stdout, _) = test_in(dir.path(), &["traces/to_five.json"]);
    assert_eq!((status, stdout.as_str()), (0, "traces/to_five.json: ok\n\n1 passed, 0 failed\n"));

    // the circuit changes: the first difference is told with both values and what is around
    std::fs::write(
        dir.path().join("long.json"),
        LONG.replace(r#""width": 64 }, "conn"#, r#""width": 64, "edge": "falling" }, "conn"#),
    )
    .unwrap();
    let (status, stdout, _) = test_in(dir.path(), &[]);
    assert_eq!(status, 1, "{stdout}");
    assert!(
        stdout.starts_with("traces/to_five.json: FAILED\n") && stdout.ends_with("\n0 passed, 1 failed\n"),
        "{stdout}"
    );
    for part in ["golden (traces/to_five.vcd)", "this run", "q", "1 ns", "2 ns"] {
        assert!(stdout.contains(part), "{part}: {stdout}");
    }
    let (status, stdout, _) = test_in(dir.path(), &["--format", "json"]);
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((status, &json["failed"], &json["scenarios"][0]["verdict"]), (1, &1.into(), &"FAILED".into()));
    assert!(json["scenarios"][0]["difference"].is_object(), "{stdout}");

    let (status, ..) = test_in(dir.path(), &["--bless"]);
    assert_eq!((status, test_in(dir.path(), &[]).0), (0, 0));
}

#[test]
fn test_tells_a_failed_from_a_broken_scenario_and_goes_on() {
    let dir = project();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join("traces").join(name), text).unwrap();
    write("a_broken.json", r#"{ "circuit": "../long.json", "simulation": { "until": { "net": "Q" } } }"#);
    write(
        "b_fails.json",
        r#"{ "circuit": "../long.json", "simulation": { "limit": { "cycles": 3 }, "expect": [ { "net": "q", "value": 3 } ] } }"#,
    );
    write("no_scenario.json", "{}");
    let (status, stdout, _) = test_in(dir.path(), &[]);
    assert_eq!(status, 1);
    assert!(
        stdout.starts_with("traces/a_broken.json: BROKEN\n    error[unknown-net]: the circuit has no net `Q`\n"),
        "{stdout}"
    );
    assert!(
        stdout.contains("traces/b_fails.json: FAILED\n") && stdout.contains("limit reached before q = "),
        "{stdout}"
    );
    assert!(
        stdout.ends_with("traces/to_five.json: ok (no golden trace; --bless makes one)\n\n1 passed, 2 failed\n"),
        "{stdout}"
    );

    // what a service shows: the failure at its line, and the same as XML
    let (status, stdout, _) = test_in(dir.path(), &["--format", "github", "-q"]);
    assert_eq!(status, 1);
    let shown: Vec<&str> = stdout.lines().filter(|l| l.starts_with("::error ")).collect();
    assert_eq!(
        shown,
        [
            "::error file=traces/a_broken.json,line=1,col=65,title=traces/a_broken.json::the circuit has no net `Q`",
            "::error file=traces/b_fails.json,line=1,col=107,title=traces/b_fails.json::`q` is 2 at the end (6 ns), not 3",
        ]
    );
    assert!(!stdout.contains("to_five"), "{stdout}");
    let (status, stdout, _) = test_in(dir.path(), &["--format", "junit"]);
    assert_eq!(status, 1);
    for part in [
        "<testsuites name=\"discreta\" tests=\"3\" failures=\"1\" errors=\"1\"",
        "<testcase classname=\"traces\" name=\"a_broken\" file=\"traces/a_broken.json\"",
        "<error message=\"the circuit has no net `Q`\">",
        "<failure message=\"`q` is 2 at the end (6 ns), not 3\">",
    ] {
        assert!(stdout.contains(part), "{part}: {stdout}");
    }
    assert_eq!(stdout.matches("<testcase ").count(), 3);
    let (status, stdout, _) = test_in(dir.path(), &["--fail-fast", "--format", "json"]);
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((status, &json["failed"], &json["not_run"]), (1, &1.into(), &2.into()));
    assert_eq!(json["scenarios"][0]["places"][0]["line"], 1);
    let (status, stdout, _) = test_in(dir.path(), &["--filter", "to_five", "-q"]);
    assert_eq!((status, stdout.as_str()), (0, "\n1 passed, 0 failed\n"));
    let (status, stdout, _) = test_in(dir.path(), &["--filter", "b_", "--filter", "five", "--list"]);
    assert_eq!((status, stdout.as_str()), (0, "traces/b_fails.json\ntraces/to_five.json\n"));
    let (status, stdout, stderr) = test_in(dir.path(), &["--filter", "zz", "--format", "json"]);
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((status, &json["ok"]), (2, &false.into()), "{stderr}");
    assert!(json["error"]["message"].as_str().unwrap().contains("has zz in its path"), "{stdout}");

    let (status, stdout, stderr) = test_in(dir.path(), &["nowhere"]);
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.contains("cannot read `nowhere`"), "{stderr}");
    std::fs::create_dir(dir.path().join("none")).unwrap();
    let (status, _, stderr) = test_in(dir.path(), &["none"]);
    assert!(status == 2 && stderr.contains("there are no scenarios in none"), "{stderr}");
}

#[test]
fn circuits_without_ports_or_clocks_run() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("c.json");
    let path = path.to_str().unwrap();
    std::fs::write(path, r#"{ "modules": { "nothing": {} } }"#).unwrap();
    let (status, stdout, _) = run(&["run", path]);
    assert!(status == 0 && stdout.contains("nothing can change any more, 0 ns"), "{stdout}");
    let (status, stdout, _) = run(&["run", path, "-o", "-"]);
    assert_eq!(status, 0);
    assert!(vcd::Parser::new(stdout.as_bytes()).parse_header().is_ok(), "{stdout}");

    let inverter = r#"{ "modules": { "m": { "ports": { "a": { "direction": "input" }, "y": { "direction": "output" } },
        "cells": { "n": { "type": "not", "connections": { "a": "a", "y": "y" } } } } } }"#;
    std::fs::write(path, inverter).unwrap();
    let (status, stdout, _) = run(&["run", path]);
    assert!(status == 0 && stdout.contains("y = 1'bx"), "{stdout}");
    let (status, stdout, _) = run(&["run", path, "-s", "a=0"]);
    assert!(status == 0 && stdout.contains("y = 1"), "{stdout}");
    refused(
        &["run", path, "--cycles", "3"],
        &["there is no clock whose cycles could be counted", "limit the run with `time`"],
    );
}

#[test]
fn colour_is_for_terminals_and_no_color_is_honoured() {
    let bad = ["check", "tests/bad/unknown_port.json"];
    assert!(!run(&bad).2.contains('\x1b'), "a pipe is no terminal");
    // a terminal, made by script(1)
    let on_terminal = |no_color: bool| {
        let mut command = Command::new("script");
        let line = format!("{} {}", env!("CARGO_BIN_EXE_discreta"), bad.join(" "));
        command.args(["-qec", &line, "/dev/null"]).current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
        command.env("TERM", "xterm").env_remove("NO_COLOR");
        if no_color {
            command.env("NO_COLOR", "1");
        }
        command.output().ok().filter(|o| !o.stdout.is_empty()).map(|o| String::from_utf8_lossy(&o.stdout).into_owned())
    };
    if let (Some(with), Some(without)) = (on_terminal(false), on_terminal(true)) {
        assert!(with.contains("\x1b[") && with.contains("has no port `Q`"), "{with}");
        assert!(!without.contains("\x1b[") && without.contains("has no port `Q`"), "{without}");
    }
}

#[test]
fn every_command_has_help_with_an_example() {
    let (status, stdout, _) = run(&["--help"]);
    assert_eq!(status, 0);
    let list = stdout.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let commands: Vec<&str> = list.lines().map(|l| l.split_whitespace().next().unwrap()).collect();
    assert!(commands.len() >= 8 && commands.contains(&"run"), "{commands:?}");
    for command in commands {
        let (status, stdout, stderr) = run(&[command, "--help"]);
        assert_eq!((status, stderr.as_str()), (0, ""), "{command}");
        assert!(stdout.contains(&format!("Examples:\n  discreta {command}")), "{stdout}");
        assert!(stdout.contains("Usage: discreta "), "{stdout}");
        let (status, page, _) = run(&["man", command]);
        assert!(status == 0 && page.contains(".SH NAME") && page.contains(command), "{page}");
    }
    let (status, page, _) = run(&["man"]);
    assert!(status == 0 && page.contains(".TH discreta 1"), "{page}");
    refused(&["man", "nothing"], &["there is no command `nothing`", "one of run, check"]);
    refused(&["nothing"], &["unrecognized subcommand 'nothing'"]);
    let (status, stdout, _) = run(&["--version"]);
    assert_eq!((status, stdout), (0, format!("discreta {}\n", env!("CARGO_PKG_VERSION"))));
}

#[test]
fn every_shell_gets_completions() {
    for (shell, part) in [
        ("bash", "complete -F"),
        ("zsh", "#compdef discreta"),
        ("fish", "complete -c discreta"),
        ("powershell", "Register-ArgumentCompleter"),
    ] {
        let (status, stdout, stderr) = run(&["completions", shell]);
        assert_eq!((status, stderr.as_str()), (0, ""));
        assert!(stdout.contains(part) && stdout.contains("x-control"), "{shell}");
    }
}

#[test]
fn schemas_are_json() {
    for of in [&["schema"][..], &["schema", "scenario"]] {
        let (status, stdout, _) = run(of);
        let json: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(status, 0);
        assert!(json["$schema"].is_string() && json["properties"].is_object(), "{of:?}");
    }
}

/// What the command line gives an input holds for the whole run, whatever the circuit's own stimulus says.
#[test]
fn what_the_command_line_sets_holds() {
    let dir = tempfile::tempdir().unwrap();
    let own = dir.path().join("own.json");
    // a counter of 4 bits, reset until 12 ns: after 12 clocks, 11 of which count, bit 3 of 11 is 1
    std::fs::write(
        &own,
        r#"{ "modules": { "blink": {
            "ports": { "clk": { "direction": "input" }, "rst": { "direction": "input" }, "led": { "direction": "output" } },
            "nets": { "q": 4 },
            "cells": {
                "c": { "type": "counter", "parameters": { "width": 4 }, "connections": { "clk": "clk", "reset": "rst", "q": "q" } },
                "b": { "type": "buf", "connections": { "a": "q[3]", "y": "led" } } } } },
          "simulation": { "clocks": { "clk": { "period": "10ns" } }, "limit": { "cycles": 12 },
            "stimulus": [ { "at": 0, "set": { "rst": 1 } }, { "at": "12ns", "set": { "rst": 0 } } ] } }"#,
    )
    .unwrap();
    let own = own.to_str().unwrap();
    let scenario = dir.path().join("s.json");
    std::fs::write(&scenario, r#"{ "circuit": "own.json" }"#).unwrap();
    for circuit in [own, scenario.to_str().unwrap()] {
        for (options, led) in [
            (&[][..], "1"),
            (&["-s", "rst=1"], "0"),
            // never reset, it never knows what it counts
            (&["-s", "rst=0"], "1'bx"),
            (&["--clock", "rst=1us,high=995ns,phase=0"], "0"),
        ] {
            let (status, out, err) = run(&[&["run", circuit][..], options].concat());
            assert!(status == 0 && out.contains(&format!("led = {led}\n")), "{options:?}: {out}{err}");
        }
    }
    let (status, out, err) = run(&["sweep", own, "--over", "rst=0,1"]);
    assert_eq!(
        (status, out.as_str()),
        (0, "rst,stop,time,cycles,led\n0,limit,120,12,1'bx\n1,limit,120,12,0\n"),
        "{err}"
    );
}

/// `help COMMAND` is `COMMAND --help`, and what the help of `draw` names is there.
#[test]
fn help_is_given_as_it_is_asked_for() {
    for command in [&["run"][..], &["draw"], &[]] {
        let help = run(&[command, &["--help"]].concat());
        assert_eq!((help.0, help.2.as_str()), (0, ""));
        assert_eq!(run(&[&["help"], command].concat()), help);
    }
    assert_eq!(run(&["help", "rum"]).0, 2);
    let (_, help, _) = run(&["draw", "--help"]);
    let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  discreta draw ")).collect();
    assert!(examples.len() >= 4, "{help}");
    for example in examples {
        let line = example.trim().trim_start_matches("discreta ").split(" -o ").next().unwrap();
        let (status, out, err) = run(&line.split(' ').collect::<Vec<_>>());
        assert!(status == 0 && out.contains("<svg"), "{example}: {err}");
    }
}
