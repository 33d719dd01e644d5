//! Files that are no JSON by their names: Verilog where no Yosys is, waveforms, pipes.

use std::io::Write as _;
use std::process::{Command, Stdio};

const AND: &str = r#"{ "modules": { "t": { "ports": { "a": { "direction": "input" }, "y": { "direction": "output" } },
    "cells": { "b": { "type": "buf", "connections": { "a": "a", "y": "y" } } } } }, "simulation": { "limit": { "time": 3 } } }"#;

fn run(folder: &std::path::Path, line: &str) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.current_dir(folder).args(line.split(' ')).env("PATH", "").env("XDG_CACHE_HOME", folder);
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn without_yosys_the_line_to_type_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.v", "b b.sv", "c.vhd", "d.v"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let cases = [
        (
            "run a.v d.v -I inc -D X=1",
            "yosys -p 'read_verilog -Iinc -DX=1 a.v; read_verilog -Iinc -DX=1 d.v; \
          hierarchy -check -auto-top; proc; tribuf; prep; write_json a.json'",
        ),
        ("view a.v --top t -G W=8", "hierarchy -check -top t -chparam W 8; proc"),
        ("check c.vhd", "yosys -m ghdl -p 'ghdl --std=08 c.vhd -e; "),
        ("stats a.v -G W=8", "name of the top module for TOP"),
    ];
    for (line, part) in cases {
        let (status, told) = run(folder.path(), line);
        assert_eq!(status, if line.starts_with("check") { 1 } else { 2 }, "{line}: {told}");
        assert!(told.contains("there is no Yosys here") && told.contains(part), "{line}: {told}");
    }
}

#[test]
fn what_is_something_else_is_called_so() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.json"), AND).unwrap();
    std::fs::write(folder.path().join("y.v"), "").unwrap();
    for (line, part) in [
        ("run x.vcd", "`x.vcd` is a waveform, not a circuit"),
        ("run x.fst", "--stimulus x.fst"),
        ("draw x.ghw", "`discreta wave x.ghw`"),
        ("run x.blif", "read_blif x.blif"),
        ("run x.vh", "included by Verilog"),
        ("run x.json y.v", "only Verilog takes several files"),
        ("run y.v x.json", "`x.json` is no Verilog"),
    ] {
        let (status, told) = run(folder.path(), line);
        assert_eq!(status, 2, "{line}: {told}");
        assert!(told.contains(part) && !told.contains("JSON"), "{line}: {told}");
    }
}

#[test]
fn a_circuit_comes_through_a_pipe() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.args(["run", "-", "-s", "a=1"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(AND.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8(output.stdout).unwrap().contains("y = 1\n"));
}
