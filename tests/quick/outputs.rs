//! Where results go: never over an input or another output, whole even with two writers, and with the exit status of
//! the command whoever reads; nothing in a name reaches a terminal.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::json;

use crate::support::folder;

const LINE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/circuits/evaluation/line.json");

/// A folder of its own, empty.
fn empty(name: &str) -> PathBuf {
    let folder = folder(name);
    fs::remove_dir_all(&folder).unwrap();
    fs::create_dir_all(folder.join("below")).unwrap();
    folder
}

fn discreta(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.args(line.split_whitespace()).current_dir(folder);
    command
}

fn ran(folder: &Path, line: &str) -> (i32, String) {
    let Output { status, stdout, stderr } = discreta(folder, line).output().unwrap();
    let text = [stdout, stderr].concat();
    (status.code().expect("no signal"), String::from_utf8_lossy(&text).into_owned())
}

/// A circuit that needs no library.
fn counter() -> String {
    json!({ "modules": { "count": {
        "ports": { "clk": { "direction": "input" }, "d": { "direction": "input", "width": 4 },
                   "q": { "direction": "output", "width": 4 } },
        "cells": { "r": { "type": "register", "parameters": { "width": 4 },
                          "connections": { "clk": "clk", "d": "d", "q": "q" } } } } },
        "simulation": { "clocks": { "clk": { "period": 10 } }, "limit": { "cycles": 3 } } })
    .to_string()
}

#[cfg(unix)]
#[test]
fn no_output_takes_the_place_of_an_input() {
    let folder = empty("outputs_inputs");
    let text = counter();
    // a waveform's name, so that `run` takes it for an output too
    for name in ["a.vcd", "a.csv"] {
        fs::write(folder.join(name), &text).unwrap();
    }
    std::os::unix::fs::symlink("a.vcd", folder.join("link.vcd")).unwrap();
    fs::hard_link(folder.join("a.vcd"), folder.join("hard.vcd")).unwrap();
    let whole = folder.join("a.vcd").display().to_string();
    for to in ["a.vcd", "./a.vcd", "below/../a.vcd", "link.vcd", "hard.vcd", &whole] {
        for line in [
            "export a.vcd --to verilog -o",
            "export a.vcd --to yosys-json -o",
            "export a.vcd --to dot -o",
            "export a.vcd --to verilog -o design.v --testbench",
            "draw a.vcd -o",
            "run a.vcd -o",
            "run a.vcd -o other.vcd -o",
        ] {
            let (status, told) = ran(&folder, &format!("{line} {to}"));
            assert!(status == 2 && told.contains("it is an input of this command"), "{line} {to}: {status}, {told}");
            assert_eq!(fs::read_to_string(folder.join("a.vcd")).unwrap(), text, "{line} {to}");
        }
    }
    for line in ["sweep a.csv --over d=0..3 -o ./a.csv", "view a.csv -o ./a.csv"] {
        let (status, told) = ran(&folder, line);
        assert!(status == 2 && told.contains("it is an input of this command"), "{line}: {told}");
        assert_eq!(fs::read_to_string(folder.join("a.csv")).unwrap(), text, "{line}");
    }
    // standard output is a file like others
    let onto = fs::OpenOptions::new().append(true).open(folder.join("a.vcd")).unwrap();
    let done = discreta(&folder, "export a.vcd --to verilog").stdout(onto).output().unwrap();
    assert_eq!(done.status.code(), Some(2));
    assert_eq!(fs::read_to_string(folder.join("a.vcd")).unwrap(), text);
}

#[test]
fn two_outputs_are_two_files() {
    let folder = empty("outputs_twice");
    fs::write(folder.join("c.json"), counter()).unwrap();
    let (status, told) = ran(&folder, "run c.json -o w.vcd -o ./w.vcd");
    assert!(status == 2 && told.contains("another output of this command goes there"), "{told}");
    // design and bench may share one, however it is called
    assert_eq!(ran(&folder, "export c.json --to verilog -o q.v --testbench ./q.v").0, 0);
    let text = fs::read_to_string(folder.join("q.v")).unwrap();
    assert!(text.contains("module count") && text.contains("module testbench"), "{text}");
}

#[test]
fn no_changed_row_is_joined() {
    let folder = empty("outputs_join");
    for form in ["csv", "json"] {
        for i in 1..=3 {
            let line = format!("sweep {LINE} --over dx=0..9 --over dy=-0..9 --shard {i}/3 -o p{i}.{form}");
            assert_eq!(ran(&folder, &line.replace("-0", "0")).0, 0);
        }
        let part = fs::read_to_string(folder.join(format!("p2.{form}"))).unwrap();
        let lines: Vec<&str> = part.lines().collect();
        let joined = |changed: &[String]| {
            let text: String = changed.iter().map(|l| format!("{l}\n")).collect();
            fs::write(folder.join(format!("bad.{form}")), text).unwrap();
            ran(&folder, &format!("sweep --join p1.{form} bad.{form} p3.{form} -o all.{form}"))
        };
        let owned = || lines.iter().map(|l| (*l).to_owned()).collect::<Vec<String>>();
        assert_eq!(joined(&owned()).0, 0);
        // the fourth row of the part, and where its fields are
        let at = lines.iter().position(|l| l.trim_start_matches('[').starts_with("3,6,")).unwrap();
        let with = |line: String| {
            let mut all = owned();
            all[at] = line;
            all
        };
        let swapped = {
            let mut all = owned();
            all.swap(at, at + 1);
            all
        };
        let (missing, twice) = {
            let (mut missing, mut twice) = (owned(), owned());
            missing.remove(at);
            twice.insert(at, twice[at].clone());
            (missing, twice)
        };
        let place = format!("line {}:", at + 1);
        let row = lines[at];
        for (changed, told) in [
            (with("hello".into()), &*place),
            (with(row.replacen("3,6", "3,7", 1)), &place),
            (with(row.replace("until", "later")), &place),
            (with(row.replacen(",1", "", 1)), &place),
            (with(row[..row.len() / 2].to_owned()), &place),
            (swapped, &place),
            (missing, &place),
            (twice, &format!("line {}:", at + 2)),
            // a value of an output, which only what all rows come to can tell
            (with(row.replacen(",0,0,", ",0,1,", 1)), "one of them was changed"),
            (owned()[..lines.len() - 1].to_vec(), "it breaks off before its end"),
        ] {
            let (status, found) = joined(&changed);
            assert!(status == 2 && found.contains(told) && found.contains("bad."), "{form}: {told}: {found}");
        }
    }
}

#[test]
fn two_sweeps_into_one_file_exclude_each_other() {
    let folder = empty("outputs_lock");
    let held = File::create(folder.join("l.csv.part")).unwrap();
    held.lock().unwrap();
    let line = format!("sweep {LINE} --over dx=0..9 -o l.csv");
    let (status, told) = ran(&folder, &line);
    assert!(status == 2 && told.contains("another sweep is writing it"), "{told}");
    drop(held);
    assert_eq!(ran(&folder, &line).0, 0);
    assert!(!folder.join("l.csv.part").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn the_exit_status_stays_whoever_reads() {
    let folder = empty("outputs_status");
    fs::write(folder.join("good.json"), counter()).unwrap();
    fs::write(folder.join("bad.json"), counter().replace("\"clk\":\"clk\"", "\"clk\":\"none\"")).unwrap();
    let fails = counter().replace("\"limit\"", "\"expect\":[{\"net\":\"q\",\"value\":3}],\"limit\"");
    fs::write(folder.join("fails.json"), fails).unwrap();
    let over = "--over d=0..3";
    for (line, status) in [
        ("run good.json", 0),
        ("run fails.json", 1),
        ("run bad.json", 2),
        ("check good.json", 0),
        ("check bad.json", 1),
        ("stats good.json", 0),
        (&format!("sweep good.json {over}"), 0),
    ] {
        let closed = || {
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            Stdio::from(writer)
        };
        let full = || Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
        let (to, from): ([fn() -> Stdio; 2], _) = ([Stdio::null, Stdio::null], [closed(), closed()]);
        let [out, err] = from;
        let ended = |mut command: Command| command.status().unwrap().code();
        let with = |out: Stdio, err: Stdio| {
            let mut command = discreta(&folder, line);
            command.stdout(out).stderr(err);
            ended(command)
        };
        assert_eq!(with(to[0](), to[1]()), Some(status), "{line}");
        assert_eq!(with(out, Stdio::null()), Some(status), "{line}: standard output closed");
        assert_eq!(with(Stdio::null(), err), Some(status), "{line}: standard error closed");
        assert_eq!(with(Stdio::null(), full()), Some(status), "{line}: standard error full");
        assert_eq!(with(closed(), closed()), Some(status), "{line}: both closed");
        if status == 0 {
            assert_eq!(with(full(), Stdio::null()), Some(2), "{line}: standard output full");
        }
    }
    assert_eq!(discreta(&folder, "run good.json -o -").stderr(Stdio::null()).output().unwrap().status.code(), Some(0));
}

/// Names with what terminals act on, in netlists and waveforms, through every command that prints them, as on a terminal.
#[test]
fn no_name_acts_on_a_terminal() {
    let folder = empty("outputs_terminal");
    let acts = "n\u{1b}[31m\u{1b}]0;t\u{7}\u{9b}2J\u{202e}";
    let name = |name: &str| format!("{name}{acts}");
    let netlist = json!({ "creator": "Yosys", "modules": { (name("top")): {
        "attributes": { "top": "1" },
        "ports": { "clk": { "direction": "input", "bits": [2] }, (name("a")): { "direction": "input", "bits": [3] },
                   (name("o")): { "direction": "output", "bits": [4] } },
        "cells": {
            (name("g")): { "type": "$_NOT_", "attributes": { "src": format!("{acts}.v:1") },
                           "connections": { "A": [3], "Y": [5] } },
            (name("f")): { "type": "$_DFF_P_", "connections": { "C": [2], "D": [5], "Q": [4] } },
            (name("p")): { "type": "$print", "attributes": { "src": format!("{acts}.v:1") },
                "parameters": { "ARGS_WIDTH": "0", "FORMAT": format!("hi{acts}\n"), "PRIORITY": "0", "TRG_ENABLE": "1",
                                "TRG_POLARITY": "1", "TRG_WIDTH": "00000000000000000000000000000001" },
                "connections": { "ARGS": [], "EN": ["1"], "TRG": [2] } } },
        "netnames": { "clk": { "bits": [2] }, (name("a")): { "bits": [3] }, (name("o")): { "bits": [4] },
                      (name("w")): { "bits": [5] } } } } });
    fs::write(folder.join("t.json"), netlist.to_string()).unwrap();
    let wave = |value: &str| {
        format!(
            "$timescale 1ns $end\n$scope module top{acts} $end\n$var wire 4 ! a{acts} $end\n$var string 1 \" s $end\n\
             $upscope $end\n$enddefinitions $end\n#0\nb0 !\nsx{acts} \"\n#5\n{value} !\n#9\n"
        )
    };
    fs::write(folder.join("t.vcd"), wave("b11")).unwrap();
    fs::write(folder.join("u.vcd"), wave("b10")).unwrap();
    for line in [
        "check t.json",
        "stats t.json",
        "stats t.json --format json",
        "run t.json --clock clk=10 --cycles 3 -v",
        "run t.json --clock clk=10 --cycles 3 --format json",
        "run t.json --clock clk=10 --cycles 3 -s q=1",
        "run t.json --stimulus t.vcd --expect",
        "export t.json --to verilog",
        "export t.json --to dot",
        "export t.json --to yosys-json",
        "wave t.vcd",
        "wave t.vcd --signals q",
        "wave t.vcd --scope q",
        "diff t.vcd u.vcd",
        "diff t.vcd u.vcd --format json",
        "view t.vcd -o -",
        "plot t.vcd -o -",
    ] {
        let Output { status, stdout, stderr } = discreta(&folder, line).env("CLICOLOR_FORCE", "1").output().unwrap();
        assert!(status.code().is_some(), "{line}: {status}");
        let text = String::from_utf8([stdout, stderr].concat()).unwrap();
        assert!(!text.contains("n\u{1b}[31m"), "{line}: {text:?}");
        // our own colours end with `m`
        let bare = text.split("\u{1b}[").enumerate().map(|(i, part)| match i {
            0 => part,
            _ => {
                part.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').strip_prefix('m').unwrap_or("\u{1b}")
            }
        });
        let bare: String = bare.collect();
        let bad = bare.chars().find(|c| matches!(c, '\u{1b}' | '\u{7}' | '\u{9b}' | '\u{202e}'));
        assert_eq!(bad, None, "{line}: {text:?}");
    }
}

/// Two inputs that the netlist makes one net cannot be told apart any more, and are told by name.
#[test]
fn inputs_that_are_one_net_are_told() {
    let folder = empty("outputs_shorted");
    let flat = json!({ "creator": "Yosys", "modules": { "t": {
        "ports": { "a": { "direction": "input", "bits": [2] }, "b": { "direction": "input", "bits": [2] },
                   "y": { "direction": "output", "bits": [2] }, "na": { "direction": "output", "bits": [3] } },
        "cells": { "n": { "type": "$_NOT_", "connections": { "A": [2], "Y": [3] } } } } } });
    let wire =
        json!({ "ports": { "a": { "direction": "input", "bits": [2] }, "y": { "direction": "output", "bits": [2] } } });
    let instance = |a: u32| json!({ "type": "wire_through", "connections": { "a": [a], "y": [4] } });
    let deep = json!({ "creator": "Yosys", "modules": { "wire_through": wire, "t": {
        "attributes": { "top": "1" },
        "ports": { "a": { "direction": "input", "bits": [2] }, "b": { "direction": "input", "bits": [3] },
                   "y": { "direction": "output", "bits": [4] }, "na": { "direction": "output", "bits": [5] } },
        "cells": { "u": instance(2), "v": instance(3), "n": { "type": "$_NOT_", "connections": { "A": [2], "Y": [5] } } } } } });
    for (name, netlist) in [("flat.json", flat), ("deep.json", deep.clone())] {
        fs::write(folder.join(name), netlist.to_string()).unwrap();
        for command in ["check", "stats", "run --time 5"] {
            let (status, told) = ran(&folder, &format!("{command} {name}"));
            assert!(status != 0 && told.contains("the inputs `a` and `b` are one net"), "{name}: {status} {told}");
        }
    }
    // one of them alone is another name of the output
    let mut one = deep;
    one["modules"]["t"]["cells"].as_object_mut().unwrap().remove("v");
    fs::write(folder.join("one.json"), one.to_string()).unwrap();
    let (status, told) = ran(&folder, "run one.json -s a=1 -s b=0 --time 5 --format json");
    assert!(status == 0 && told.contains("\"y\": \"1\"") && told.contains("\"na\": \"0\""), "{told}");
}
