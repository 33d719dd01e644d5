//! Sweeps: every row against a run of its own on the event engine, and `discreta sweep` as a user sees it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use crate::support::program::run;
use crate::support::{folder, load, repository};
use discreta::Value;
use discreta::circuit::{Circuit, load_with};
use discreta::diag::Diagnostics;
use discreta::engine::EventEngine;
use discreta::netlist::{Direction, NetId};
use discreta::scenario::{self, Control, RunError, Scenario, Stop};
use discreta::sweep::run::{Row, Shown};
use discreta::sweep::{Ended, Over, Plan, Sweep};

/// Every row of a sweep, by the batch engine with few lanes, so that lanes take row after row, and by the event engine.
fn same(label: &str, circuit: &Circuit, change: impl Fn(&mut Scenario), overs: &[&str]) -> Vec<Row> {
    let netlist = &circuit.netlist;
    let mut faults = Diagnostics::new();
    let mut scenario = Scenario::resolve(circuit, circuit.simulation.as_ref().unwrap(), &mut faults);
    assert!(!faults.has_errors(), "{label}");
    change(&mut scenario);
    let overs: Vec<Over> = overs.iter().map(|o| o.parse().unwrap()).collect();
    let signals: Vec<_> = overs.iter().map(|o| netlist.find(&o.net).unwrap()).collect();
    let nets: Vec<NetId> = signals.iter().map(|&s| netlist.signal(s).drive.unwrap()).collect();
    let axes =
        overs.iter().zip(&signals).map(|(o, &s)| o.values(netlist.signal(s).width, netlist.signal(s).signed).unwrap());
    let plan = Plan::new(axes.collect()).unwrap();
    let outputs: Vec<_> = netlist.ports().filter(|&s| netlist.signal(s).port == Some(Direction::Output)).collect();
    let mut sweep = Sweep { netlist, scenario: &scenario, nets, plan, outputs, against: None, threads: 1, lanes: 0 };
    let rows = |sweep: &Sweep| {
        let rows = Mutex::new(Vec::new());
        let mut next = 0;
        let keep = |row: &Row| {
            rows.lock().unwrap().push(row.clone());
            row.number.to_string()
        };
        let mut sink = |number: u64, text: &str| {
            assert_eq!((number, text), (next, number.to_string().as_str()), "{label}: the order of rows");
            next += 1;
            Ok(())
        };
        sweep.run(0, &AtomicBool::new(false), &keep, &mut sink).unwrap();
        let mut rows = rows.into_inner().unwrap();
        rows.sort_by_key(|r: &Row| r.number);
        assert_eq!(rows.len() as u64, sweep.plan.total(), "{label}");
        rows
    };
    let found = rows(&sweep);
    for (threads, lanes) in [(1, 512), (3, 512), (2, 1024)] {
        (sweep.threads, sweep.lanes) = (threads, lanes);
        assert_eq!(rows(&sweep), found, "{label}: {threads} threads, {lanes} lanes");
    }
    let mut engine = EventEngine::new(netlist);
    for row in &found {
        let mut one = scenario.clone();
        for (net, value) in sweep.nets.iter().zip(sweep.plan.values(row.number)) {
            let input = one.inputs.iter_mut().find(|i| i.0 == *net).unwrap();
            input.1 = Value::from_words(&[value], input.1.width());
        }
        engine.reset();
        let mut control = Control {
            interrupt: &AtomicBool::new(false),
            progress: &mut |_| {},
            message: &mut |_, _, _| {},
            unknown_control_ends: false,
            observers: Vec::new(),
        };
        let (ended, time, outputs) = match scenario::run(netlist, &one, &mut engine, None, &mut control) {
            Ok(o) => {
                let ended = match o.stop {
                    Stop::Until => Ended::Until,
                    Stop::Limit => Ended::Limit,
                    Stop::Idle => Ended::Idle,
                    other => panic!("{label}: {other:?}"),
                };
                (ended, o.time, o.outputs.into_iter().map(|o| Shown::of(o.1)).collect())
            }
            Err(RunError::Unsettled(u)) => (Ended::Unsettled, u.time, Vec::new()),
            Err(e) => panic!("{label}: {e:?}"),
        };
        let expected = Row { number: row.number, ended, time, outputs, verdict: None };
        assert_eq!(*row, expected, "{label}, row {}", row.number);
    }
    found
}

fn shipped(path: &str, bits: i64) -> Circuit {
    load_with(repository("circuits").join(path), &[("W", bits)]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn rows_of_shipped_circuits_are_runs_of_the_event_engine() {
    same("lines", &shipped("evaluation/line.json", 6), |_| {}, &["dx=0..63", "dy=0..63..2"]);
    same("gates", &shipped("evaluation/line_gates.json", 4), |_| {}, &["dx=0..15", "dy=0..15", "xh=0,9,4'bx01z"]);
    same("dda", &shipped("dda/line.json", 3), |_| {}, &["dx=0..7", "dy=0..7", "yh=0..7", "xh=0..3"]);
    // a limit that some reach before the end
    let rows = same("limit", &shipped("evaluation/line.json", 5), |s| s.limit = 777, &["dx=0..31", "dy=0..31"]);
    let limits = rows.iter().filter(|r| r.ended == Ended::Limit && r.time == 777).count();
    assert!((100..1000).contains(&limits), "{limits} rows reached the limit");
}

/// Two clocks, stimulus while they run, a latch that may race, and an end that may not come.
fn mixed() -> Circuit {
    let file = serde_json::json!({
        "timescale": "1ns",
        "top": "mixed",
        "modules": { "mixed": {
            "ports": {
                "clk": { "direction": "input" }, "clk2": { "direction": "input" },
                "n": { "direction": "input", "width": 4 }, "m": { "direction": "input", "width": 2 },
                "s": { "direction": "input" }, "r": { "direction": "input" }, "go": { "direction": "input" },
                "q": { "direction": "output", "width": 4 }, "p": { "direction": "output", "width": 3 },
                "hit": { "direction": "output" }, "latch": { "direction": "output" }
            },
            "nets": { "other": 1, "held": 1 },
            "cells": {
                "count": { "type": "counter", "parameters": { "width": 4, "init": 0 },
                           "connections": { "clk": "clk", "en": "go", "q": "q" } },
                "count2": { "type": "counter", "parameters": { "width": 3, "edge": "falling", "init": 0 },
                            "connections": { "clk": "clk2", "down": "m[0]", "q": "p" } },
                "same": { "type": "eq", "parameters": { "width": 4 }, "connections": { "a": "q", "b": "n", "y": "hit" } },
                "hold": { "type": "or", "connections": { "in": ["r", "m[1]"], "y": "held" } },
                "nor1": { "type": "nor", "connections": { "in": ["held", "other"], "y": "latch" } },
                "nor2": { "type": "nor", "connections": { "in": ["s", "latch"], "y": "other" } }
            }
        } },
        "simulation": {
            "clocks": { "clk": { "period": 7, "high": 3, "phase": 2 }, "clk2": { "period": 10, "high": 4, "phase": 0 } },
            "inputs": { "n": 0, "m": 0, "s": 0, "r": 0, "go": 0 },
            "stimulus": [
                { "at": 0, "set": { "s": 1 } }, { "at": 4, "set": { "s": 0 } }, { "at": 16, "set": { "go": 1 } },
                { "at": 44, "set": { "s": 1, "r": 1 } }, { "at": 51, "set": { "s": 0, "r": 0 } }
            ],
            "until": { "net": "hit" },
            "limit": { "time": 90 }
        }
    });
    load(&folder("sweep"), "mixed", &file).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn two_clocks_late_stimulus_races_and_ends_that_do_not_come() {
    let circuit = mixed();
    let overs = ["n=0..15", "m=0..3", "r=0,1", "go=0,1,1'bx", "s=0,1"];
    let rows = same("mixed", &circuit, |_| {}, &overs);
    for ended in [Ended::Until, Ended::Limit, Ended::Unsettled] {
        assert!(rows.iter().any(|r| r.ended == ended), "no row ended with {ended:?}");
    }
    same("no end", &circuit, |s| s.until = None, &overs);
    let late = |s: &mut Scenario| {
        s.stimulus.truncate(3);
        s.limit = 400;
    };
    same("long", &circuit, late, &overs);
    let still = |s: &mut Scenario| {
        for clock in s.clocks.drain(..).collect::<Vec<_>>() {
            s.inputs.push((clock.net, Value::from_u64(0, 1)));
        }
        s.limit_given = false;
    };
    let rows = same("without clocks", &circuit, still, &overs);
    assert!(rows.iter().any(|r| r.ended == Ended::Idle && r.time == 51));
}

const LINE: &str = "circuits/evaluation/line.json";

fn words<'a>(head: &[&'a str], tail: &[&'a str]) -> Vec<&'a str> {
    let all = ["sweep"].iter().chain(head).chain(tail);
    all.copied().collect()
}

fn file(name: &str) -> (PathBuf, String) {
    let path = folder("sweep").join(name);
    let _ = fs::remove_file(&path);
    let text = path.display().to_string();
    (path, text)
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn a_sweep_is_a_table() {
    let (status, stdout, stderr) =
        run(&words(&[LINE, "--over", "dx=4..5", "--over", "dy=3,8'b1x"], &["--cycles", "9"]));
    // the lines (4, 3) and (5, 3) take 7 and 8 clocks, the last of which falls at 20·clocks + 10
    let expected = "dx,dy,stop,time,cycles,x,y,xt,yt,end\n4,3,until,150,7,0,0,4,3,1\n";
    assert!(stdout.starts_with(expected), "{stdout}");
    assert!(stdout.contains("\n5,3,until,170,8,0,0,5,3,1\n"), "{stdout}");
    assert!(stdout.contains("\n5,8'b0000001x,limit,190,9,"), "{stdout}");
    assert_eq!(stderr, "4 runs: 2 until, 2 limit\n");
    assert_eq!(status, 0, "who asks for so many cycles is content to get them");
    let (path, name) = file("table.json");
    let (status, stdout, _) = run(&words(&[LINE, "--over", "dx=5,8'bx", "--show", "ko?"], &["-o", &name]));
    assert_eq!((status, stdout), (1, format!("2 runs: 1 until, 1 limit\nwrote {name}\n")));
    let json: serde_json::Value = serde_json::from_str(&read(&path)).unwrap();
    assert_eq!(json["columns"], serde_json::json!(["dx", "stop", "time", "cycles", "kox", "koy"]));
    assert_eq!(json["rows"][0], serde_json::json!([5, "until", 170, 8, 0, 0]));
    assert_eq!(json["rows"][1][0], "8'bxxxxxxxx");
    assert!(!path.with_extension("json.part").exists());
}

#[test]
fn the_outputs_are_those_of_the_top_module() {
    let (_, stdout, _) = run(&words(&["circuits/evaluation/line_gates.json"], &["--over", "dx=5"]));
    assert_eq!(stdout, "dx,stop,time,cycles,x,y,xt,yt,end\n5,until,170,8,0,0,5,3,1\n");
}

#[test]
fn the_first_difference_is_a_command() {
    let over = ["--over", "dx=0..7", "--over", "dy=0..7"];
    let (path, name) = file("same.csv");
    let (status, stdout, _) = run(&words(&[LINE, "--against", "ef-line", "-o", &name], &over));
    assert_eq!((status, stdout), (0, format!("64 runs: 64 until; none differs from ef-line\nwrote {name}\n")));
    assert!(read(&path).lines().skip(1).all(|line| line.ends_with(",1,")));
    // the accelerated line differs from the other wherever it steps along both axes at once, or x leads and F is 0
    for threads in ["1", "3"] {
        let (_, name) = file(&format!("differ{threads}.csv"));
        let against = ["--against", "ef-line-fast", "--threads", threads, "-o", &name];
        let (status, stdout, _) = run(&words(&[LINE, "-s", "xh=1"], &[&over[..], &against[..]].concat()));
        assert_eq!(status, 1);
        let command = "  discreta run circuits/evaluation/line.json -s xh=1 -s dx=0 -s dy=1 -o difference.vcd\n";
        assert!(stdout.contains("\nfirst difference, clock 1: y shows 0, expected 1, while dt = 1:\n"), "{stdout}");
        assert!(stdout.contains(command), "{stdout}");
    }
    let (status, _, stderr) =
        run(&words(&["circuits/feed/synchroniser.json", "--against", "ef-line"], &["--over", "step=0,1"]));
    assert!(status == 2 && stderr.contains("the circuit has no input `xh`"), "{stderr}");
    let (status, _, stderr) = run(&words(&[LINE, "--against", "dda-line"], &over));
    assert_eq!(status, 2);
    assert!(
        stderr.contains("the circuit has no net `sx`") && stderr.contains("needs the inputs `start`, `dt`"),
        "{stderr}"
    );
}

#[test]
fn every_method_agrees_with_its_circuit_and_not_with_a_mutant() {
    let sweeps = [
        ("evaluation/line_gates.json", "ef-line", "W=3", &["dx=0..7", "dy=0..7", "xh=0..7..3"][..]),
        ("evaluation/fast_line.json", "ef-line-fast", "W=3", &["dx=0..7", "dy=0..7"]),
        ("evaluation/circle.json", "ef-circle", "W=4", &["xh=0..15", "yh=0..15", "dx=0..5", "dy=0..5"]),
        ("evaluation/circle.json", "grossman", "CLOCKWISE=1", &["xh=0..9", "yh=3..12", "dx=0..5", "dy=0..5"]),
        ("evaluation/karibsky.json", "karibsky", "W=4", &["xh=1..9", "dx=0..9", "dy=0..9"]),
        ("evaluation/fast_circle.json", "ef-circle-fast", "W=4", &["xh=1..9", "dx=0..9", "dy=0..9"]),
        ("dda/line.json", "dda-line", "HALF_PRELOAD=1", &["dx=0..9", "dy=0..9"]),
        ("dda/circle.json", "dda-circle", "W=4", &["xh=1..9", "dx=0..5", "dy=0..5"]),
        ("three_axis/line.json", "ef-line-3d", "W=3", &["dx=0..7", "dy=0..7", "dz=0..7"]),
        ("three_axis/dda_line.json", "dda-line-3d", "W=3", &["dx=0..7", "dy=0..7", "dz=0..7"]),
        ("quadrant/line.json", "ef-line", "W=3", &["dx=-7..7", "dy=-7..7"]),
        ("quadrant/circle.json", "ef-circle", "W=4", &["xh=3..5", "xk=-5..5", "yk=-5..5", "cw=0,1"]),
    ];
    for (path, method, parameter, overs) in sweeps {
        let circuit = format!("circuits/{path}");
        let mut args = vec!["sweep", &circuit, "--against", method, "-p", parameter];
        overs.iter().for_each(|o| args.extend(["--over", o]));
        let (status, _, stderr) = run(&args);
        assert!(stderr.contains(&format!("; none differs from {method}")), "{path}: {stderr}");
        assert!(status == 0 || stderr.contains("refuses"), "{path}: {stderr}");
    }
    // an adder that adds one too much
    let text = read(&repository(LINE));
    let mutant =
        text.replace(r#""a": "f", "b": "addend", "y": "sum""#, r#""a": "f", "b": "addend", "ci": "1'b1", "y": "sum""#);
    assert_ne!(text, mutant);
    let (path, name) = file("mutant.json");
    fs::write(&path, mutant).unwrap();
    let (status, _, stderr) = run(&["sweep", &name, "--over", "dx=0..9", "--over", "dy=0..9", "--against", "ef-line"]);
    assert_eq!(status, 1);
    assert!(stderr.contains("first difference, clock 1: f shows 0, expected 511, while dt = 0"), "{stderr}");
}

#[test]
fn shards_join_to_the_whole() {
    for form in ["csv", "json"] {
        let over = ["--over", "dx=0..30", "--over", "dy=0..9"];
        let (whole, name) = file(&format!("whole.{form}"));
        assert_eq!(run(&words(&[LINE, "-o", &name], &over)).0, 0);
        let mut parts = Vec::new();
        for i in [2, 3, 1] {
            let (_, name) = file(&format!("part{i}.{form}"));
            let shard = format!("{i}/3");
            assert_eq!(run(&words(&[LINE, "--shard", &shard, "-o", &name], &over)).0, 0);
            parts.push(name);
        }
        let (joined, name) = file(&format!("joined.{form}"));
        let join = |parts: &[String]| {
            let mut args = vec!["sweep", "-o", &name, "--join"];
            args.extend(parts.iter().map(String::as_str));
            run(&args)
        };
        assert_eq!(join(&parts), (0, format!("310 runs of 3 parts\nwrote {name}\n"), String::new()));
        assert_eq!(read(&joined), read(&whole));
        for (parts, fault) in [
            (&parts[..2], "the rows 0 to 102 before it are missing"),
            (&[parts[0].clone(), parts[2].clone()], "the rows 206 to 309 behind it are missing"),
            (&[parts[0].clone(), parts[2].clone(), parts[2].clone()], "its row 0 is in another part too"),
            (&[whole.display().to_string()][..], if form == "csv" { "this is no part of a sweep" } else { "wrote" }),
        ] {
            let (_, stdout, stderr) = join(parts);
            assert!(format!("{stdout}{stderr}").contains(fault), "{form}: {stdout}{stderr}");
        }
        let (_, other) = file(&format!("other.{form}"));
        run(&words(&[LINE, "--shard", "3/3", "-s", "xh=1", "-o", &other], &over));
        let (status, _, stderr) = join(&[parts[0].clone(), parts[2].clone(), other]);
        assert!(status == 2 && stderr.contains("it belongs to another sweep than the first"), "{stderr}");
    }
}

#[test]
fn a_sweep_goes_on_where_it_was_left() {
    for form in ["csv", "json"] {
        let over = ["--over", "dx=0..15", "--over", "dy=0..15", "--against", "ef-line-fast"];
        let (whole, name) = file(&format!("left.{form}"));
        let args = words(&[LINE, "-o", &name], &over);
        let (_, first, _) = run(&args);
        let expected = read(&whole);
        // what stays of an interrupted sweep: its description, and rows up to any byte
        let rows: Vec<&str> = match form {
            "csv" => expected.lines().skip(1).collect(),
            _ => expected.lines().skip(3).take(256).map(|l| l.strip_suffix(',').unwrap_or(l)).collect(),
        };
        let (part, _) = file(&format!("left.{form}.part"));
        let id = {
            let (shard, name) = file(&format!("id.{form}"));
            run(&words(&[LINE, "--shard", "1/2", "-o", &name], &over));
            let text = read(&shard);
            let start = text.find("\"id\":\"").unwrap() + 6;
            text[start..start + 16].to_owned()
        };
        let head = format!(
            r#"{{"circuit":"{LINE}","over":["dx=0..15","dy=0..15"],"inputs":[[8,false],[8,false]],"id":"{id}","form":"{form}","rows":[0,256,256]}}"#
        );
        for (kept, broken) in [(0, ""), (1, "0,2,un"), (100, ""), (255, "1"), (256, "")] {
            let lines: String = rows[..kept].iter().map(|row| format!("{row}\n")).collect();
            fs::write(&part, format!("{head}\n{lines}{broken}")).unwrap();
            fs::remove_file(&whole).unwrap();
            let (_, stdout, stderr) = run(&[&args[..], &["--resume"]].concat());
            assert_eq!((stdout, stderr), (first.clone(), String::new()), "{form}, {kept} rows kept");
            assert_eq!(read(&whole), expected, "{form}, {kept} rows kept");
            assert!(!part.exists());
        }
        fs::write(&part, format!("{}\n", head.replace(&id, "0000000000000000"))).unwrap();
        let (status, _, stderr) = run(&[&args[..], &["--resume"]].concat());
        assert!(status == 2 && stderr.contains("is of another sweep"), "{stderr}");
    }
}

#[test]
fn faults_of_the_command_line_are_told() {
    for (args, fault) in [
        (&[LINE, "--over", "dx=5..3"][..], "the range is empty: 3 is below 5"),
        (&[LINE, "--over", "dx=0..256"], "`256`"),
        (&[LINE, "--over", "du=0..1"], "the circuit has no net `du`"),
        (&[LINE, "--over", "xt=0..1"], "`xt` is not an input of the circuit"),
        (&[LINE, "--over", "dx=0..1", "--over", "dx=2..3"], "`dx` is given twice"),
        (&[LINE, "--over", "dx=0..1", "-s", "dx=2"], "`dx` is given twice"),
        (&[LINE, "--over", "dx=0..1", "-o", "lines.txt"], "end the name in .csv or .json"),
        (&[LINE, "--over", "dx=0..1", "--shard", "1/2"], "--shard needs --output"),
        (&[LINE, "--over", "dx=0..1", "--shard", "3/2", "-o", "x.csv"], "from 1/N to N/N"),
        (&[LINE, "--over", "dx=0..1", "--resume"], "--output"),
        (&[LINE], "--over"),
        (&["--join", "missing.csv"], "cannot read `missing.csv`"),
    ] {
        let (status, _, stderr) = run(&words(args, &[]));
        assert!(status == 2 && stderr.contains(fault), "{args:?}: {stderr}");
    }
}

#[test]
fn a_circuit_with_delays_is_swept_on_the_event_engine() {
    let (status, stdout, stderr) = run(&words(&["circuits/feed/synchroniser.json", "-v"], &["--over", "step=0,1"]));
    assert_eq!(status, 0, "{stderr}");
    // a step that is held all the time is a new one as soon as one has been made
    assert_eq!(stdout, "step,stop,time,drive,stop,waiting\n0,limit,460,0,0,0\n1,limit,460,0,1,1\n");
    assert!(stderr.starts_with("note: a sweep does not check expectations, timing checks"), "{stderr}");
    assert!(stderr.contains("engine event, 1 threads: the batch engine does not take "), "{stderr}");
    assert!(stderr.ends_with("2 runs: 2 limit\n"), "{stderr}");
}
