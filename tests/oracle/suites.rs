//! Peers' own designs, from a checkout that the user fetched: Yosys makes words and gates of each, and what Icarus Verilog makes
//! of the same netlist, and of the source, under random inputs is replayed on both engines and compared at every time.
//!
//!     DISCRETA_YOSYS=~/yosys DISCRETA_SUITE_LIMIT=100 cargo test --test oracle suites -- --ignored --nocapture
//!
//! `DISCRETA_ICARUS` and `DISCRETA_VERILATOR` name the other checkouts; without a limit every design is taken.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::folder;
use crate::support::rng::Rng;
use serde_json::Value as Json;

/// Where each peer keeps designs.
const SUITES: [(&str, &[&str]); 3] = [
    ("DISCRETA_YOSYS", &["tests/simple", "tests/various", "tests/memories", "tests/opt", "tests/proc"]),
    ("DISCRETA_ICARUS", &["ivtest/ivltests"]),
    ("DISCRETA_VERILATOR", &["test_regress/t"]),
];

/// What Yosys makes of a design.
const LEVELS: [(&str, &str); 2] = [("words", "prep -flatten -auto-top"), ("gates", "synth -flatten -auto-top")];

/// Input changes in a run, one per tick, so that no two of them race.
const CHANGES: u64 = 300;

/// A tool that may fail, and may not take longer than a minute.
fn attempt(folder: &Path, program: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new("timeout");
    command.current_dir(folder).args(["60", program]).args(arguments).output().unwrap()
}

fn designs(variable: &str, folders: &[&str]) -> Vec<PathBuf> {
    let Some(root) = std::env::var_os(variable) else { return Vec::new() };
    let list = |name: &&str| {
        let folder = Path::new(&root).join(name);
        let files = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{variable}: {}: {e}", folder.display()));
        files.map(|f| std::fs::canonicalize(f.unwrap().path()).unwrap()).collect::<Vec<_>>()
    };
    let mut found: Vec<_> = folders.iter().flat_map(list).collect();
    found.retain(|f| f.extension().is_some_and(|e| e == "v" || e == "sv"));
    found.sort();
    // one order for all limits, not the first letters alone
    Rng::new(1).shuffle(&mut found);
    found
}

/// A bench for the top of a netlist; none where there is nothing to drive or to see.
fn bench(netlist: &Json, seed: &str) -> Result<String, &'static str> {
    let modules = netlist["modules"].as_object().ok_or("no module")?;
    let top = modules.iter().find(|m| m.1["attributes"].get("top").is_some()).or(modules.iter().next());
    let (name, top) = top.ok_or("no module")?;
    let ports = top["ports"].as_object().ok_or("no port")?;
    let of = |direction: &str| {
        let ports = ports.iter().filter(|p| p.1["direction"] == *direction);
        ports.map(|(name, port)| (name, port["bits"].as_array().unwrap())).collect::<Vec<_>>()
    };
    let (inputs, outputs) = (of("input"), of("output"));
    if !of("inout").is_empty() {
        return Err("inout port");
    } else if inputs.is_empty() || outputs.is_empty() {
        return Err("no input or no output");
    }
    let cells = top["cells"].as_object().into_iter().flatten();
    let clocks: Vec<_> = cells
        .flat_map(|(_, cell)| ["CLK", "C", "RD_CLK", "WR_CLK"].map(|pin| &cell["connections"][pin]))
        .flat_map(|bits| bits.as_array().into_iter().flatten())
        .filter(|bit| bit.is_number())
        .collect();
    let (clock, data): (Vec<_>, Vec<_>) = inputs.iter().partition(|(_, bits)| bits.iter().any(|b| clocks.contains(&b)));
    let (mut text, mut rng) = ("`timescale 1ns/1ns\nmodule discreta_bench;\n".to_owned(), Rng::named(seed));
    for (kind, nets) in [("reg", &inputs), ("wire", &outputs)] {
        nets.iter().for_each(|(n, bits)| writeln!(text, "  {kind} [{}:0] \\{n} ;", bits.len() - 1).unwrap());
    }
    let pins: Vec<_> = inputs.iter().chain(&outputs).map(|(n, _)| format!(".\\{n} (\\{n} )")).collect();
    writeln!(text, "  \\{name} dut({});\n  initial begin", pins.join(", ")).unwrap();
    text += "    $dumpfile(\"icarus.vcd\"); $dumpvars(0, discreta_bench);\n";
    let mut changes: Vec<_> = inputs.iter().collect();
    for _ in 0..CHANGES {
        let ticks = data.is_empty() || !clock.is_empty() && rng.one_in(2);
        changes.push(*rng.pick(if ticks { &clock } else { &data }));
    }
    for (name, bits) in changes {
        let value = rng.known(bits.len() as u32).bit_string();
        writeln!(text, "    #1 \\{name} = {}'b{value};", bits.len()).unwrap();
    }
    Ok(text + "    #1 $finish;\n  end\nendmodule\n")
}

/// How a replay on one engine ended: `None` if equal.
fn replay(folder: &Path, netlist: &str, engine: &str) -> Option<String> {
    let line = ["run", netlist, "--stimulus", "icarus.vcd", "--scope", "discreta_bench.dut", "--expect", "--engine"];
    let done = attempt(folder, env!("CARGO_BIN_EXE_discreta"), &[&line[..], &[engine]].concat());
    let told = String::from_utf8_lossy(&done.stderr);
    let error = told.lines().find(|l| l.starts_with("error")).unwrap_or_default();
    match done.status.code() {
        Some(0) => None,
        Some(1) => Some("different".to_owned()),
        Some(2) => {
            // counted by kind: without the names and numbers in it
            let quoted = error.split('`').step_by(2).collect::<Vec<_>>().join("…");
            Some(format!("refused: {}", quoted.replace(|c: char| c.is_ascii_digit(), "")))
        }
        other => Some(format!("different (ended with {other:?})")),
    }
}

/// Icarus' waveform of a source; false where it does not compile or end.
fn icarus(folder: &Path, source: &str) -> bool {
    _ = std::fs::remove_file(folder.join("icarus.vcd"));
    let standard = ["-g2012", "-s", "discreta_bench", "-o", "bench.vvp", "bench.v", source];
    attempt(folder, "iverilog", &standard).status.success()
        && attempt(folder, "vvp", &["-n", "bench.vvp"]).status.success()
        && folder.join("icarus.vcd").exists()
}

/// One design at one level, in a word or two.
fn verdict(folder: &Path, file: &Path, level: &str, passes: &str) -> String {
    let file = file.to_str().unwrap();
    let script = format!("read_verilog -sv {file}; {passes}; write_json {level}.json; write_verilog -noattr {level}.v");
    if !attempt(folder, "yosys", &["-q", "-p", &script]).status.success() {
        return "left out: not read by Yosys".to_owned();
    }
    let netlist = std::fs::read(folder.join(format!("{level}.json"))).unwrap();
    match bench(&serde_json::from_slice(&netlist).unwrap(), file) {
        Ok(text) => std::fs::write(folder.join("bench.v"), text).unwrap(),
        Err(why) => return format!("left out: {why}"),
    }
    if !icarus(folder, &format!("{level}.v")) {
        return "left out: Icarus does not run the netlist".to_owned();
    }
    let netlist = format!("{level}.json");
    let engines = if cfg!(feature = "compiled") { &["event", "compiled"][..] } else { &["event"] };
    for engine in engines {
        if let Some(told) = replay(folder, &netlist, engine) {
            return format!("{told}, {engine}");
        }
    }
    match icarus(folder, file) && replay(folder, &netlist, "event").is_none() {
        true => "equal".to_owned(),
        false => "equal on the netlist only".to_owned(),
    }
}

#[test]
#[ignore = "by hand: needs a checkout of a peer, DISCRETA_YOSYS=…, DISCRETA_ICARUS=… or DISCRETA_VERILATOR=…"]
fn suites_of_peers() {
    let limit = std::env::var("DISCRETA_SUITE_LIMIT").map_or(usize::MAX, |n| n.parse().expect("DISCRETA_SUITE_LIMIT"));
    let (mut different, mut tried) = (Vec::new(), 0);
    for (variable, folders) in SUITES {
        let (mut table, mut messages) = (BTreeMap::<_, usize>::new(), 0);
        for file in designs(variable, folders).iter().take(limit) {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            let folder = folder(&format!("suites/{variable}/{name}"));
            for (level, passes) in LEVELS {
                let found = verdict(&folder, file, level, passes);
                if found.starts_with("different") {
                    different.push(format!("{level} of {}: {found}, see {}", file.display(), folder.display()));
                }
                messages += 1;
                *table.entry(format!("{level}: {found}")).or_default() += 1;
            }
            if !different.last().is_some_and(|d| d.contains(&format!("/{name}:"))) {
                std::fs::remove_dir_all(&folder).unwrap();
            }
        }
        tried += messages;
        table.iter().for_each(|(found, n)| println!("{variable}: {n:5}  {found}"));
    }
    assert!(tried > 0, "name a checkout: DISCRETA_YOSYS=…, DISCRETA_ICARUS=… or DISCRETA_VERILATOR=…");
    assert!(different.is_empty(), "{} different:\n{}", different.len(), different.join("\n"));
}
