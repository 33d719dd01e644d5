//! Running the program on what other simulators recorded.

#![allow(dead_code, reason = "each test file uses some of it")]

use std::path::Path;

use serde_json::Value as Json;

use super::program::{discreta, ended};
use super::tool::tool;

/// How the program ends in a folder, with a line of arguments split at spaces.
pub fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let words: Vec<&str> = line.split_whitespace().collect();
    ended(discreta(&words).current_dir(folder).output().unwrap())
}

/// The same with the report of a run for programs.
pub fn report(folder: &Path, line: &str) -> (i32, Json) {
    let (status, out, err) = run(folder, &format!("{line} --format json"));
    (status, serde_json::from_str(&out).unwrap_or_else(|e| panic!("{line}: {e}\n{out}{err}")))
}

/// Runs a refused line; every text must be in what it says.
pub fn refused(folder: &Path, line: &str, texts: &[&str]) {
    let (status, out, err) = run(folder, line);
    assert_eq!(status, 2, "{line}:\n{out}{err}");
    for text in texts {
        assert!(err.contains(text), "{line}: no `{text}` in\n{err}");
    }
}

/// A netlist by Yosys of a design, after some passes.
pub fn netlist(folder: &Path, design: &Path, passes: &str, name: &str) {
    let script = format!("read_verilog {}; {passes}; write_json {name}.json", design.display());
    tool(folder, "yosys", &["-q", "-p", &script]);
}

/// What Icarus records of a bench and a design: `icarus.vcd`, and the same as `icarus.fst`.
pub fn icarus(folder: &Path, bench: &Path, design: &Path) {
    let [bench, design] = [bench, design].map(|path| path.to_str().unwrap());
    tool(folder, "iverilog", &["-g2012", "-o", "bench.vvp", bench, design]);
    tool(folder, "vvp", &["-n", "bench.vvp"]);
    tool(folder, "vcd2fst", &["icarus.vcd", "icarus.fst"]);
}
