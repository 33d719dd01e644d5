//! `discreta diff`, and what every command has from `cli`: exit status, pipes, full disks, colours.

use std::fs::File;
use std::path::PathBuf;
use std::process::Stdio;

use crate::support::program::{discreta, ended, run};

const COUNTER: &str = "tests/waves/counter.vcd";
const COUNTER_FST: &str = "tests/waves/counter.fst";

/// The counter with one value changed, in a directory that lives as long as the test.
fn changed(dir: &tempfile::TempDir) -> PathBuf {
    let text = std::fs::read_to_string(COUNTER).unwrap();
    let at = text.find("#45\n").unwrap();
    let (before, after) = text.split_at(at);
    let wrong = after.replacen("b1111 \"", "b11111 \"", 1);
    assert_ne!(wrong, after);
    let path = dir.path().join("wrong.vcd");
    std::fs::write(&path, format!("{before}{wrong}")).unwrap();
    path
}

#[test]
fn the_same_is_0() {
    assert_eq!(run(&["diff", COUNTER, COUNTER_FST]), (0, "The same: 8 signals until 112 ns.\n".into(), String::new()));
}

#[test]
fn a_scope_around_one_of_them() {
    let dir = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(COUNTER).unwrap();
    let around = dir.path().join("around.vcd");
    let at = text.find("$scope").unwrap();
    let end = text.find("$enddefinitions").unwrap();
    let (head, scopes, rest) = (&text[..at], &text[at..end], &text[end..]);
    std::fs::write(&around, format!("{head}$scope module bench $end\n{scopes}$upscope $end\n{rest}")).unwrap();
    let around = around.to_str().unwrap();
    let same = (0, "The same: 8 signals until 112 ns.\n".to_owned(), String::new());
    assert_eq!(run(&["diff", COUNTER, around, "--scope", "bench"]), same);
    assert_eq!(run(&["diff", around, COUNTER, "--scope", "bench"]), same);
    // where the circuit stands, and for each of the two
    assert_eq!(run(&["diff", around, COUNTER, "--scope", "bench.top"]), same);
    assert_eq!(run(&["diff", COUNTER, around, "--scope", "bench.top"]), same);
    assert_eq!(run(&["diff", around, COUNTER, "--scope", "bench.top", "--scope", "top"]), same);
    assert_eq!(run(&["diff", COUNTER, around, "--scope", "top", "--scope", "bench.\\top"]), same);
    let (status, _, told) = run(&["diff", around, COUNTER]);
    assert_eq!(status, 2, "{told}");
    for text in ["have no signal of the same name", "it has `bench`, `bench.top`", "it has `top`", "--scope"] {
        assert!(told.contains(text), "no `{text}` in {told}");
    }
    for scope in [&["--scope", "bench.tob"][..], &["--scope", "bench.tob", "--scope", "top"]] {
        let (status, _, told) = run(&[&["diff", around, COUNTER][..], scope].concat());
        assert!(status == 2 && told.contains("has no scope `bench.tob`") && told.contains("`bench.top`"), "{told}");
    }
    let (status, _, told) = run(&["diff", around, COUNTER, "--scope", "bench", "--scope", ""]);
    assert_eq!(status, 0, "{told}");
}

/// An instance of another name than its module: what a bench recorded, and what the module alone does.
#[test]
fn an_instance_is_its_module() {
    let dir = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(COUNTER).unwrap();
    let instance = dir.path().join("instance.vcd");
    let bench = text.replacen("$scope module top $end", "$scope module tb $end $scope module dut $end", 1);
    let bench = bench.replacen("$enddefinitions", "$upscope $end $enddefinitions", 1);
    std::fs::write(&instance, bench).unwrap();
    let instance = instance.to_str().unwrap();
    for args in [["diff", COUNTER, instance, "--scope", "tb.dut"], ["diff", instance, COUNTER, "--scope", "tb.dut"]] {
        assert_eq!(run(&args), (0, "The same: 8 signals until 112 ns.\n".to_owned(), String::new()));
    }
    // one meaning everywhere
    let (status, out, err) = run(&["wave", instance, "--scope", "tb.dut", "-s", "q"]);
    assert!(status == 0 && out.contains("dut") && !out.contains("tb"), "{out}{err}");
    let (status, out, err) =
        run(&["view", instance, "--scope", "tb.dut", "-o", dir.path().join("p.html").to_str().unwrap()]);
    assert!(status == 0 && out.contains("signals"), "{out}{err}");
    for command in ["wave", "view", "plot"] {
        let (status, _, told) = run(&[command, instance, "--scope", "tb.duty"]);
        assert!(status == 2 && told.contains("has no scope `tb.duty`: it has `tb`, `tb.dut`"), "{told}");
    }
}

#[test]
fn different_is_1_and_the_report_says_where() {
    let dir = tempfile::tempdir().unwrap();
    let wrong = changed(&dir);
    let (status, stdout, stderr) = run(&["diff", COUNTER, wrong.to_str().unwrap(), "--context", "2"]);
    assert_eq!((status, stderr.as_str()), (1, ""));
    let stdout = stdout.replace(wrong.to_str().unwrap(), "wrong.vcd");
    let (head, rest) = stdout.split_once("\n\n").unwrap();
    assert!(head.contains(COUNTER) && head.contains("wrong.vcd"), "{head}");
    let expected = "\
First difference at 55 ns: top.q (after 6 rising edges of top.clk)

    time  top.clk  a              b
   45 ns  1        00001100 (12)  00001100 (12)
   50 ns  0        00001100 (12)  00001100 (12)
 > 55 ns  1        00001111 (15)  00011111 (31)
   60 ns  0        00001111 (15)  00011111 (31)
   65 ns  1        00010010 (18)  00010010 (18)

1 of 8 signals differ:
     time  signal  a              b
    55 ns  top.q   00001111 (15)  00011111 (31)
";
    let squeeze = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (lists, picture) = rest.rsplit_once("\n\n").unwrap();
    assert_eq!(squeeze(lists), squeeze(expected), "{rest}");
    // the two values stand one above the other, and an arrow points at them
    let expected = "
           ├45 ns────├50───────├55───────├60───────├65──────────
top.clk    ▔▔▔▔▔▔▔▔▔▔╲▁▁▁▁▁▁▁▁▁╱▔▔▔▔▔▔▔▔▔╲▁▁▁▁▁▁▁▁▁╱▔▔▔▔▔▔▔▔▔▔▔▔
top.q (a)   12                 ╳ 15                ╳ 18
top.q (b)   12                 ╳ 31                ╳ 18
                               ▲ first difference
";
    assert_eq!(picture, &expected[1..]);
}

#[test]
fn json_is_for_programs() {
    let dir = tempfile::tempdir().unwrap();
    let wrong = changed(&dir);
    let (status, stdout, _) = run(&["diff", COUNTER, wrong.to_str().unwrap(), "--format", "json"]);
    assert_eq!(status, 1);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json["same"], &json["first"], &json["timescale"]), (&false.into(), &55.into(), &"1ns".into()));
    assert_eq!(json["a"]["name"], COUNTER);
    let (status, stdout, _) = run(&["diff", COUNTER, COUNTER, "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((status, &json["same"]), (0, &true.into()));
}

#[test]
fn what_cannot_be_read_is_2() {
    let (status, stdout, stderr) = run(&["diff", COUNTER, "no/such.vcd"]);
    assert_eq!((status, stdout.as_str()), (2, ""));
    let expected = "error: cannot read the waveform `no/such.vcd`: no such file or directory\n  \
                    help: check the spelling of the path\n";
    assert_eq!(stderr, expected);
    for other in ["tests", "Cargo.toml"] {
        assert_eq!(run(&["diff", COUNTER, other]).0, 2, "{other}");
    }
}

#[test]
fn a_damaged_file_is_2_and_one_message() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bad.fst");
    std::fs::write(&path, &std::fs::read("tests/waves/counter.fst").unwrap()[..400]).unwrap();
    let (status, stdout, stderr) = run(&["diff", COUNTER, path.to_str().unwrap()]);
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.starts_with("error: cannot read the waveform"), "{stderr}");
    assert_eq!(stderr.lines().count(), 2, "{stderr}");
}

/// What is doubtful is told and read; a file that breaks off is read up to there, and the exit status says so.
#[test]
fn odd_and_cut_files_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(COUNTER).unwrap();
    let given = |text: &str| {
        let path = dir.path().join("other.vcd");
        std::fs::write(&path, text).unwrap();
        let (status, stdout, stderr) = run(&["diff", COUNTER, path.to_str().unwrap()]);
        (status, stdout.starts_with("The same: 8 signals"), stderr)
    };
    let (status, same, stderr) = given(&text.replace("#12\n", "#12\n1unknown\n"));
    assert_eq!((status, same), (0, true), "{stderr}");
    assert!(stderr.contains("the value of `unknown` is passed over") && stderr.lines().count() == 1, "{stderr}");
    let (status, same, stderr) = given(text.trim_end());
    assert!((status, same) == (0, true) && stderr.contains("its last line"), "{stderr}");
    let (status, same, stderr) = given(&format!("{text}b101"));
    assert!((status, same) == (2, true) && stderr.contains("it is cut off"), "{stderr}");
}

/// A variable that cannot be read is named where it is wanted, and only there; the others are shown.
#[test]
fn an_odd_variable_is_named_where_it_is_wanted() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("odd.vcd");
    let text = "$scope module t $end $var real 64 r odd $end $var wire 1 ! good $end $upscope $end $enddefinitions $end\n\
                #0\nshigh r\n1!\n#5\n0!\n";
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    for (signals, warned) in [(&[][..], true), (&["--signals", "good"], false), (&["-s", "t.*"], true)] {
        let (status, stdout, stderr) = run(&[&["wave", path], signals].concat());
        assert!(status == 0 && stdout.contains("good"), "{signals:?}: {stdout}{stderr}");
        assert_eq!(
            stderr.contains("`t.odd` is left out: line 3: `high` is not a real number"),
            warned,
            "{signals:?}: {stderr}"
        );
        assert_eq!(stderr.is_empty(), !warned, "{stderr}");
    }
}

/// The nine values of VHDL are four on either side.
#[test]
fn nine_values_are_compared_as_four() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, values: &str| {
        let path = dir.path().join(name);
        let header = "$timescale 1 ns $end $var wire 9 ! v $end $enddefinitions $end\n#0\n";
        std::fs::write(&path, format!("{header}b{values} !\n#9\n")).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (nine, four, other) =
        (write("nine.vcd", "UX01ZWLH-"), write("four.vcd", "xx01zx01x"), write("other.vcd", "xx01zx011"));
    assert_eq!(run(&["diff", &nine, &four]).0, 0);
    assert_eq!(run(&["diff", &nine, &other]).0, 1);
    assert_eq!(
        [run(&["diff", "--ignore-x", "a", &nine, &other]).0, run(&["diff", "--ignore-x", "b", &nine, &other]).0],
        [0, 1]
    );
}

#[test]
fn usage_is_2() {
    for args in [&[][..], &["diff", COUNTER], &["diff", COUNTER, COUNTER, "--format", "xml"], &["nonsense"]] {
        let (status, stdout, stderr) = run(args);
        assert_eq!((status, stdout.as_str()), (2, ""), "{args:?}");
        assert!(stderr.contains("--help"), "{stderr}");
    }
    assert_eq!(run(&["--help"]).0, 0);
    assert_eq!(run(&["man", "nonsense"]).0, 2);
}

#[test]
fn a_closed_pipe_is_no_error() {
    for args in [&["completions", "bash"][..], &["man", "run"], &["--help"], &["diff", COUNTER, COUNTER]] {
        let mut child = discreta(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let (status, _, stderr) = ended(child.wait_with_output().unwrap());
        assert_eq!((status, stderr.as_str()), (0, ""), "{args:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_2() {
    for args in [&["completions", "bash"][..], &["man"], &["--help"], &["diff", COUNTER, COUNTER]] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let (status, _, stderr) = ended(discreta(args).stdout(full).output().unwrap());
        let expected = "error: cannot write to standard output: no space left on device\n";
        assert_eq!((status, stderr.as_str()), (2, expected), "{args:?}");
    }
}

#[test]
fn colours_only_where_they_are_wanted() {
    let coloured = |key: &str| {
        let output = discreta(&["diff", COUNTER, "no.vcd"]).env(key, "1").output().unwrap();
        ended(output).2.contains('\x1b')
    };
    assert!(coloured("CLICOLOR_FORCE"));
    assert!(!coloured("NO_COLOR"));
    assert!(!coloured("OTHER"));
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    for command in ["run", "check", "test", "diff", "interpolate", "schema", "completions", "man"] {
        let (status, page, _) = run(&["man", command]);
        assert_eq!(status, 0);
        assert!(page.contains(&format!(".TH discreta-{command} 1")), "{page}");
    }
    assert!(run(&["man"]).1.contains("discreta\\-interpolate"));
}

#[test]
fn there_are_completions_for_every_shell() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let (status, script, _) = run(&["completions", shell]);
        assert!(status == 0 && script.contains("ignore-x"), "{shell}");
    }
}
