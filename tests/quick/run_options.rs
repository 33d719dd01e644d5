//! What `run` does beside its scenario: stop on a condition, record a part, hold nets, print as the circuit prints.

use crate::support::folder;
use crate::support::program::{command, run};

const LINE: &str = "circuits/evaluation/line.json -s dx=5 -s dy=3";

#[test]
fn a_run_stops_on_a_condition() {
    // the line goes to (5, 3); on its way xt and yt take each value from 0 on
    for (condition, outputs) in [
        ("xt==3", "xt = 3"),
        ("xt==4&&yt>=2", "xt = 4  yt = 2"),
        ("xt+yt==8'h05", "xt = 3  yt = 2"),
        ("yt==0x3", "yt = 3"),
    ] {
        let (status, text, told) = command("run", &format!("{LINE} --stop-on {condition}"));
        assert_eq!(status, 0, "{told}");
        assert!(text.contains("stopped where it was to") && text.contains(outputs), "{condition}: {text}");
        assert!(told.contains(&format!("stopped on {condition}\n")), "{told}");
    }
    let (_, text, _) = command("run", &format!("{LINE} --stop-on xt==99"));
    assert!(text.contains("stopped at end = 1"), "a condition that never holds changes nothing: {text}");
    for (condition, part) in [
        ("xq==3", "the circuit has no net `xq`"),
        ("xt=3", "cannot be read"),
        ("x:nothing*", "matches no net"),
        ("x:[", "matches no net"),
    ] {
        let (status, _, told) = command("run", &format!("{LINE} --stop-on {condition}"));
        assert_eq!(status, 2, "{condition}");
        assert!(told.contains(part), "{condition}: {told}");
    }
}

#[test]
fn a_known_net_that_becomes_x_stops_it() {
    let forced = format!("{LINE} --force running=x --stop-on x:running");
    let (_, text, _) = command("run", &forced);
    assert!(!text.contains("stopped where it was to"), "what was never known does not become x: {text}");
    let (status, text, told) = command("run", "circuits/evaluation/line.json -s dx=x -s dy=3 --stop-on x:f");
    assert_eq!(status, 0, "{told}");
    assert!(text.contains("stopped where it was to") && told.contains("discreta why … f --at"), "{text}{told}");
}

#[test]
fn a_waveform_may_be_a_part_in_time() {
    let path = folder("run_options").join("part.vcd");
    let path = path.to_str().unwrap();
    let (status, _, told) = command("run", &format!("{LINE} -o {path} --from 50ns --to 90"));
    assert_eq!(status, 0, "{told}");
    let text = std::fs::read_to_string(path).unwrap();
    let times: Vec<u64> = text.lines().filter_map(|l| l.strip_prefix('#')?.parse().ok()).collect();
    assert_eq!((times.first(), times.last()), (Some(&50), Some(&90)), "{times:?}");
    assert!(text.split_once("#60").unwrap().0.contains("$dumpvars"), "it begins with all values");
    let (status, _, told) = command("run", &format!("{LINE} -o {path} --from 90 --to 50"));
    assert!(status == 2 && told.contains("--from is after --to"), "{told}");
    let (status, _, told) = command("run", &format!("{LINE} --from 90"));
    assert!(status == 2 && told.contains("--output"), "{told}");
}

#[test]
fn a_net_is_held_whatever_drives_it() {
    // `f` is not stored without `running`, so that its sign lets x step for ever, as far as dx goes, and never y; with the
    // same `force` in the bench of its export, Icarus Verilog comes to xt = 5, yt = 0 too
    let (status, text, _) = command("run", &format!("{LINE} --force running=0"));
    assert_eq!(status, 1, "{text}");
    assert!(text.contains("xt = 5  yt = 0"), "{text}");
    for (force, part) in [("runing=0", "did you mean `running`?"), ("f=999", "does not fit"), ("f", "NAME=VALUE")] {
        let (status, _, told) = command("run", &format!("{LINE} --force {force}"));
        assert!(status == 2 && told.contains(part), "{force}: {told}");
    }
}

/// A circuit that says `tick` without a line's end, then the number of the clock, at each edge.
#[test]
fn a_console_is_read_raw() {
    let print = |format: &str, args: &[u32], priority: &str| {
        serde_json::json!({ "type": "$print", "parameters": { "FORMAT": format, "ARGS_WIDTH": args.len(), "PRIORITY": priority,
            "TRG_ENABLE": 1, "TRG_WIDTH": 1, "TRG_POLARITY": "1" }, "connections": { "EN": ["1"], "TRG": [2], "ARGS": args } })
    };
    let file = serde_json::json!({ "creator": "Yosys 0.70", "modules": { "t": {
        "ports": { "clk": { "direction": "input", "bits": [2] }, "d": { "direction": "input", "bits": [3, 4, 5, 6] } },
        "cells": { "a": print("tick\u{1b}[2J ", &[], &"1".repeat(32)),
                   "b": print("{4:> du}\n", &[3, 4, 5, 6], &format!("{}0", "1".repeat(31))) }, "netnames": {} } } });
    let path = folder("run_options").join("print.json");
    std::fs::write(&path, file.to_string()).unwrap();
    let path = path.to_str().unwrap();
    let line = ["run", path, "--clock", "clk=10", "-s", "d=7", "--cycles", "2", "--print", "raw"];
    let (status, text, told) = run(&line);
    assert_eq!(status, 0, "{told}");
    // as it is, and nothing else on standard output
    assert!(text.lines().count() == 2 && text.starts_with("tick\u{1b}[2J ") && text.ends_with("7\n"), "{text:?}");
    assert!(told.contains("ran to the end"), "{told}");
}
