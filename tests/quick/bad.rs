//! Every fault that a circuit or scenario can have, and what the user is told.
//!
//! `tests/bad/NAME.json` is broken; `tests/bad/NAME.txt` holds the command, its exit status and all that it prints. The
//! command is `check NAME.json`, or what stands in `NAME.cmd`. Files too large to be kept are made by [`MADE`]. With
//! `BLESS=1` the snapshots are written anew: read what changed before you commit it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// No broken file may take longer.
const PATIENCE: Duration = Duration::from_secs(30);

type Made = (&'static str, &'static str, fn() -> String);

/// Files that are too large to be kept or to be read by anyone: name, command, contents.
const MADE: &[Made] = &[
    ("made_brackets", "check made_brackets.json", || "[".repeat(50 << 20)),
    ("made_spaces", "check made_spaces.json --limit file-size=1000000", || " ".repeat(1_000_001)),
    ("made_deep_hierarchy", "check made_deep_hierarchy.json", || hierarchy(1000, 1)),
    ("made_yosys_doubling", "check made_yosys_doubling.json", || {
        let level = |i: u32| {
            let cell = |n| format!(r#""c{n}": {{ "type": "m{}", "connections": {{}} }}"#, i + 1);
            let cells = if i < 60 { format!("{}, {}", cell(0), cell(1)) } else { String::new() };
            format!(r#""m{i}": {{ "ports": {{}}, "cells": {{ {cells} }} }}"#)
        };
        let modules: Vec<String> = (0..=60).map(level).collect();
        format!(r#"{{ "creator": "Yosys", "modules": {{ {} }} }}"#, modules.join(", "))
    }),
    ("made_yosys_wide_table", "check made_yosys_wide_table.json", || {
        let bits = vec!["2"; 40].join(", ");
        let cell = |kind: &str, port: &str| {
            format!(
                r#""{kind}": {{ "type": "{kind}", "parameters": {{ "WIDTH": 40, "DEPTH": 400000000, "S_WIDTH": 40 }},
                "connections": {{ "{port}": [ {bits} ], "Y": [ 3 ] }} }}"#
            )
        };
        let cells = [cell("$lut", "A"), cell("$sop", "A"), cell("$bmux", "S"), cell("$demux", "S")].join(",\n");
        format!(r#"{{ "creator": "Yosys", "modules": {{ "m": {{ "ports": {{}}, "cells": {{ {cells} }} }} }} }}"#)
    }),
    ("made_deep_allowed", "check made_deep_allowed.json --limit depth=2000", || hierarchy(1000, 1)),
    ("made_doubling", "check made_doubling.json", || hierarchy(60, 2)),
    ("made_deep_blocks", "check made_deep_blocks.json", || {
        let (open, close) = (r#"{ "blocks": { "b": "#.repeat(100_000), " } }".repeat(100_000));
        format!(r#"{{ "modules": {{ "m": {open}{{}}{close} }} }}"#)
    }),
    ("made_wide_concatenation", "check made_wide_concatenation.json", || {
        let parts = vec![r#""65536{a}""#; 70_000].join(", ");
        in_module(&format!(r#""g": {{ "type": "buf", "connections": {{ "a": [{parts}] }} }}"#))
    }),
    ("made_many_inputs", "check made_many_inputs.json", || {
        let parts = vec![r#""65536{a}""#; 70_000].join(", ");
        let parameters = r#""parameters": { "width": 65536 }"#;
        in_module(&format!(r#""g": {{ "type": "and", {parameters}, "connections": {{ "in": [{parts}] }} }}"#))
    }),
    ("made_long_expression", "check made_long_expression.json", || {
        let (sum, deep) = (vec!["1"; 100_000].join("+"), "(".repeat(100_000));
        in_module(&format!(r#""g": {{ "type": "buf", "repeat": {{ "i": "{sum}" }}, "if": "{deep}" }}"#))
    }),
    ("made_long_name", "check made_long_name.json", || {
        in_module(&format!(r#""{}": {{ "type": "{}" }}"#, "n".repeat(1_000_000), "t".repeat(1_000_000)))
    }),
    ("made_many_faults", "check made_many_faults.json", || {
        let cell = |i| format!(r#""c{i}": {{ "type": "buf", "connections": {{ "a": "n{i}" }} }}"#);
        in_module(&(0..100_000).map(cell).collect::<Vec<_>>().join(", "))
    }),
    ("made_many_faulty_copies", "check made_many_faulty_copies.json", || {
        in_module(r#""g": { "type": "buf", "repeat": { "i": 1000000 }, "connections": { "a": "n[i]", "y": "a[i]" } }"#)
    }),
    ("made_long_chain", "check made_long_chain.json", || {
        let nets: Vec<String> = (0..=100_000).map(|i| format!(r#""n{i}": 1"#)).collect();
        let cell = |i| format!(r#""c{i}": {{ "type": "not", "connections": {{ "a": "n{i}", "y": "n{}" }} }}"#, i + 1);
        let cells: Vec<String> = (0..100_000).map(cell).collect();
        let back = r#""back": { "type": "buf", "connections": { "a": "n100000", "y": "n0" } }"#;
        format!(
            r#"{{ "modules": {{ "m": {{ "nets": {{ {} }}, "cells": {{ {}, {back} }} }} }} }}"#,
            nets.join(", "),
            cells.join(", ")
        )
    }),
];

/// A module with the input `a` and these cells.
fn in_module(cells: &str) -> String {
    format!(
        r#"{{ "modules": {{ "m": {{ "ports": {{ "a": {{ "direction": "input" }} }}, "cells": {{ {cells} }} }} }} }}"#
    )
}

/// Modules of which each has some cells of the next.
fn hierarchy(depth: usize, cells: usize) -> String {
    let port = r#""ports": { "a": { "direction": "input" } }"#;
    let cell = |i, k| format!(r#""c{k}": {{ "type": "m{}", "connections": {{ "a": "a" }} }}"#, i + 1);
    let module = |i| {
        let cells: Vec<String> = if i + 1 == depth { vec![] } else { (0..cells).map(|k| cell(i, k)).collect() };
        format!(r#""m{i}": {{ {port}, "cells": {{ {} }} }}"#, cells.join(", "))
    };
    format!("{{ \"modules\": {{\n{}\n}} }}\n", (0..depth).map(module).collect::<Vec<_>>().join(",\n"))
}

/// A command, its exit status, and what it prints.
fn told(command: &str, dir: &Path) -> String {
    let started = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_discreta"))
        .args(command.split_whitespace())
        .current_dir(dir)
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("discreta runs");
    // what is printed is bounded, but may be more than a pipe holds
    let drain = |mut from: Box<dyn std::io::Read + Send>| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            from.read_to_end(&mut bytes).expect("a pipe can be read");
            String::from_utf8(bytes).expect("what is printed is UTF-8")
        })
    };
    let stderr = drain(Box::new(child.stderr.take().unwrap()));
    let stdout = drain(Box::new(child.stdout.take().unwrap()));
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child can be waited for") {
            break status;
        }
        if started.elapsed() > PATIENCE {
            child.kill().expect("a child can be killed");
            child.wait().expect("a child can be waited for");
            return format!("$ discreta {command}\nstill running after {PATIENCE:?}\n");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let status = status.code().map_or("killed".to_owned(), |code| code.to_string());
    let (stderr, stdout) = (stderr.join().unwrap(), stdout.join().unwrap());
    format!("$ discreta {command}\nexit status {status}\n\n{stderr}{stdout}")
}

/// The first lines in which two texts differ.
fn difference(expected: &str, found: &str) -> String {
    let (expected, found): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let same = expected.iter().zip(&found).take_while(|(a, b)| a == b).count();
    let part = |lines: &[&str], mark: &str| -> String {
        lines.iter().skip(same).take(12).map(|line| format!("  {mark} {line}\n")).collect()
    };
    format!("  from line {}\n{}{}", same + 1, part(&expected, "-"), part(&found, "+"))
}

#[test]
fn every_fault_is_told() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad");
    let mut cases: Vec<(String, String, PathBuf)> = Vec::new();
    for entry in std::fs::read_dir(&dir).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let command = std::fs::read_to_string(path.with_extension("cmd"));
            cases.push((name.clone(), command.unwrap_or(format!("check {name}.json")).trim().to_owned(), dir.clone()));
        }
    }
    cases.sort();
    let made = tempfile::tempdir().unwrap();
    for (name, command, contents) in MADE {
        std::fs::write(made.path().join(format!("{name}.json")), contents()).unwrap();
        cases.push(((*name).to_owned(), (*command).to_owned(), made.path().to_path_buf()));
    }
    assert!(cases.len() > 80, "only {} files", cases.len());

    let bless = std::env::var_os("BLESS").is_some();
    let mut report = String::new();
    for (name, command, cwd) in &cases {
        let found = told(command, cwd);
        let snapshot = dir.join(format!("{name}.txt"));
        let expected = std::fs::read_to_string(&snapshot).unwrap_or_default();
        if found.contains("panicked at") || found.contains("still running") || found.contains("status killed") {
            report += &format!("{name}: {found}\n");
        } else if bless {
            std::fs::write(&snapshot, &found).unwrap();
        } else if expected != found {
            report += &format!("{name}\n{}\n", difference(&expected, &found));
        }
    }
    for entry in std::fs::read_dir(&dir).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_some_and(|e| e == "txt") && !cases.iter().any(|c| c.0 == name) {
            report += &format!("{name}.txt: there is no such case\n");
        }
    }
    assert!(report.is_empty(), "\n{report}BLESS=1 writes the snapshots anew\n");
}
