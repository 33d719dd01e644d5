//! `discreta stats` as a user meets it.

use crate::support::program;

use serde_json::Value;

const LINE: &str = "circuits/evaluation/line.json";
const GATES: &str = "circuits/evaluation/line_gates.json";

/// A toggle flip-flop behind an exclusive OR, and an inverter for its clock.
const TOGGLE: &str = r#"{
  "modules": {
    "toggle": {
      "parameters": { "W": { "default": 2 } },
      "ports": {
        "clk": { "direction": "input" },
        "t": { "direction": "input", "width": "W" },
        "q": { "direction": "output", "width": "W" }
      },
      "nets": { "late": 1 },
      "cells": {
        "not1": { "type": "not", "connections": { "a": "clk", "y": "late" } },
        "bit": { "type": "bit", "repeat": { "i": "W" }, "connections": { "clk": "late", "t": "t[i]", "q": "q[i]" } }
      }
    },
    "bit": {
      "ports": { "clk": { "direction": "input" }, "t": { "direction": "input" }, "q": { "direction": "output" } },
      "nets": { "d": 1 },
      "cells": {
        "xor1": { "type": "xor", "connections": { "in": ["t", "q"], "y": "d" } },
        "ff": { "type": "dff", "connections": { "clk": "clk", "d": "d", "q": "q" } }
      }
    }
  }
}"#;

/// Exit status, standard output, standard error.
fn stats(args: &[&str]) -> (i32, String, String) {
    program::run(&[&["stats"], args].concat())
}

fn toggle() -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("toggle.json");
    std::fs::write(&path, TOGGLE).unwrap();
    (dir, path.display().to_string())
}

#[test]
fn text_is_aligned_and_complete() {
    let (_dir, path) = toggle();
    let (status, stdout, stderr) = stats(&[&path, "-p", "W=3", "--depth", "1"]);
    let expected = format!(
        "\
{path}: toggle with W = 3

equipment
  gates       3  as drawn; 3 of two inputs
  inverters   1
  flip-flops  3

netlist
  cells            7
  nets             9  11 bits
  inputs           2  4 bits
  outputs          1  3 bits
  fan-out at most  3  inputs read late

clocks
  clk falling  3  flip-flops

elements
  dff  3  1 bit
  not  1  1 bit
  xor  3  1 bit, 2 inputs

modules
  bit  3

logic depth: 1 gate
  from  clk (input)
     1  late  not not1
  to    late (bit[0].ff.clk)

scope     module  cells  gates  inverters  storage
(top)     toggle      7      3          1        3
  bit[0]  bit         2      1          0        1
  bit[1]  bit         2      1          0        1
  bit[2]  bit         2      1          0        1
"
    );
    assert_eq!((status, stdout.as_str(), stderr.as_str()), (0, expected.as_str(), ""));
}

#[test]
fn json_has_the_same_for_programs() {
    let (status, stdout, stderr) = stats(&[LINE, GATES, "-p", "W=4", "--format", "json"]);
    assert_eq!((status, stderr.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json[0]["circuit"], &json[0]["module"]), (&LINE.into(), &"line".into()));
    assert_eq!(json[1]["parameters"]["W"], 4);
    assert_eq!(json[0]["equipment"]["counters"], serde_json::json!({ "number": 4, "bits": 16 }));
    assert_eq!(json[0]["equipment"]["flip_flops"], json[1]["equipment"]["flip_flops"]);
    assert_eq!((&json[0]["depth"]["unit"], &json[1]["depth"]["unit"]), (&"elements".into(), &"gates".into()));
    assert_eq!(json[0]["clocks"][0], serde_json::json!({ "net": "dt", "edge": "falling", "flip_flops": 15 }));
    assert_eq!(json[1]["depth"]["path"]["end"]["pin"], "memory.bit[4].ff_falling.d");
    assert_eq!(json[1]["scopes"], serde_json::json!([]));
    let adders = json[1]["modules"].as_array().unwrap().iter().find(|m| m["module"] == "full_adder_gates").unwrap();
    assert_eq!(adders["number"], 5);
}

#[test]
fn a_scenario_is_counted_as_its_circuit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("narrow.json");
    let circuit = format!("{}/{LINE}", env!("CARGO_MANIFEST_DIR"));
    std::fs::write(&path, format!(r#"{{ "circuit": "{circuit}", "parameters": {{ "W": 3 }} }}"#)).unwrap();
    let (status, stdout, stderr) = stats(&[path.to_str().unwrap(), "--format", "json"]);
    assert_eq!((status, stderr.as_str()), (0, ""));
    let json: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json[0]["parameters"]["W"], &json[0]["inputs"]["bits"]), (&3.into(), &14.into()));
}

#[test]
fn faults_are_told_as_check_tells_them_and_the_others_are_counted() {
    let (status, stdout, stderr) = stats(&["tests/bad/unknown_port.json", LINE]);
    assert_eq!(status, 2);
    assert!(stdout.starts_with("circuits/evaluation/line.json: line with W = 8, CENTRED = 0\n"), "{stdout}");
    assert!(stderr.contains("error[unknown-port]: `dff` has no port `Q`"), "{stderr}");
    assert!(stderr.contains("tests/bad/unknown_port.json:8:74"), "{stderr}");

    let (status, stdout, stderr) = stats(&["missing.json"]);
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.contains("cannot read `missing.json`"), "{stderr}");
    let (status, _, stderr) = stats(&[LINE, "-p", "V=1"]);
    assert_eq!(status, 2);
    assert!(stderr.contains("has no parameter `V`"), "{stderr}");
    assert_eq!(stats(&[]).0, 2);
}

#[test]
fn help_names_the_options_and_the_page() {
    let (status, stdout, _) = stats(&["--help"]);
    assert_eq!(status, 0);
    for part in ["--depth <N>", "--format", "--parameter", "docs/stats.md", "Exit status: 0 counted"] {
        assert!(stdout.contains(part), "no {part} in\n{stdout}");
    }
}
