//! Circuits as Verilog: every shipped one runs on Icarus Verilog as it does here, passes Verilator, Icarus and Yosys
//! without a warning, and comes back through Yosys with the same waveform.

#[allow(dead_code)]
use crate::designs::catalogue;
#[allow(dead_code)]
use crate::designs::harness;
use crate::support::program;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::designs::harness::Level;
use crate::support::tool::complaints;
use crate::support::{folder, repository};
use discreta::Value;
use discreta::wave::read::Waves;
use needs::needs;

fn discreta(arguments: &[&str]) {
    let (status, _, told) = program::run(arguments);
    assert_eq!(status, 0, "discreta {}: {told}", arguments.join(" "));
}

/// Every file of these folders that is JSON.
fn files(below: &str, folders: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for folder in folders {
        for entry in std::fs::read_dir(repository(below).join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".json") {
                found.push(format!("{below}/{folder}/{name}"));
            }
        }
    }
    found.sort();
    found
}

const FOLDERS: [&str; 5] = ["evaluation", "dda", "feed", "quadrant", "three_axis"];

fn circuits() -> Vec<String> {
    files("circuits", &FOLDERS)
}

/// With other parameters and inputs than their own.
const VARIANTS: &[&str] = &[
    "circuits/evaluation/line.json -p W=13 -s dx=11 -s dy=7 -s xh=3",
    "circuits/evaluation/line_gates.json -p W=5 -s dx=7 -s dy=7",
    "circuits/evaluation/line_gates.json -p CENTRED=1 -s dx=7 -s dy=2",
    "circuits/evaluation/circle.json -p W=10",
    "circuits/dda/line.json -p W=4",
    "circuits/three_axis/line.json -p W=6 -s dx=9 -s dy=5 -s dz=3",
    "circuits/feed/system.json -s dx=3 -s dy=4",
    "circuits/evaluation/line.json --cycles 3",
    "circuits/evaluation/line.json --time 77ns -s dx=200",
    "circuits/evaluation/line.json --until xt=3 -s dy=x",
    "circuits/evaluation/line.json --trace f --trace k*",
];

/// The name of a net and its changes.
type Changes = (String, Vec<(u64, String)>);

/// The end of a waveform, and all that it holds in the order of its variables.
fn waves(path: &Path, scope: &str) -> (u64, Vec<Changes>) {
    let mut waves = Waves::open(path).unwrap_or_else(|e| panic!("{e}"));
    let names: Vec<String> = waves.vars().iter().map(|v| v.name.clone()).collect();
    let all = names.into_iter().enumerate().map(|(i, name)| {
        let changes = waves.load(i).unwrap().changes().collect();
        (name.strip_prefix(scope).unwrap_or(&name).to_owned(), changes)
    });
    let all = all.collect();
    (waves.end(), all)
}

#[derive(Default)]
struct Counts {
    runs: usize,
    nets: usize,
    changes: usize,
}

/// Runs something here and on Icarus, and compares every net at every time.
fn compare(folder: &Path, line: &str, counts: &mut Counts) {
    let words: Vec<&str> = line.split_whitespace().collect();
    let name = line.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let at = |kind: &str| folder.join(format!("{name}{kind}"));
    let text = |path: &PathBuf| path.to_str().unwrap().to_owned();
    let (ours, design, bench) = (text(&at(".vcd")), text(&at(".v")), text(&at("_tb.v")));
    let run = [&["run"], &words[..], &["-o", &ours, "--x-control", "ignore"]].concat();
    // a run may end at a limit, or with an expectation that is not met with other inputs
    let (status, _, told) = program::run(&run);
    assert_ne!(status, 2, "{line}: {told}");
    discreta(&[&["export"], &words[..], &["--to", "verilog", "-o", &design, "--testbench", &bench]].concat());
    let compiled = text(&at(".vvp"));
    let told = complaints(folder, "iverilog", &["-g2005", "-Wall", "-Wno-timescale", "-o", &compiled, &design, &bench]);
    assert_eq!(told, "", "{line}");
    complaints(folder, "vvp", &["-n", &compiled]);
    let (end, ours) = waves(Path::new(&ours), "");
    let (their_end, theirs) = waves(&at("_tb.vcd"), "testbench.");
    assert_eq!(end, their_end, "{line}: the end");
    assert_eq!(ours.len(), theirs.len(), "{line}: how many nets");
    // an instance that is called as a net is gets another name
    let mut renamed = 0;
    let by_name: HashMap<&str, usize> = theirs.iter().enumerate().map(|(i, t)| (t.0.as_str(), i)).collect();
    let plain: HashMap<String, usize> = theirs.iter().enumerate().map(|(i, t)| (t.0.replace("_2.", "."), i)).collect();
    for ours in &ours {
        let found = by_name.get(ours.0.as_str()).or_else(|| {
            renamed += 1;
            plain.get(&ours.0)
        });
        let theirs = &theirs[*found.unwrap_or_else(|| panic!("{line}: {} is not there", ours.0))];
        assert_eq!(ours.1, theirs.1, "{line}: {}", ours.0);
        counts.changes += ours.1.len();
    }
    assert!(renamed * 2 < ours.len(), "{line}: {renamed} nets have other names");
    // START at 0 may be the end of it
    assert!(end == 0 || ours.iter().any(|net| net.1.len() > 1), "{line}: nothing happens");
    counts.runs += 1;
    counts.nets += ours.len();
}

#[needs(iverilog)]
#[test]
fn icarus_runs_every_circuit_as_we_do() {
    let folder = folder("export_verilog");
    let mut counts = Counts::default();
    for line in circuits().iter().map(String::as_str).chain(VARIANTS.iter().copied()) {
        compare(&folder, line, &mut counts);
    }
    println!("circuits: {} runs, {} nets, {} changes equal", counts.runs, counts.nets, counts.changes);
    assert!(counts.runs > 45 && counts.changes > 100_000);
}

#[needs(iverilog)]
#[test]
fn icarus_runs_every_scenario_as_we_do() {
    let folder = folder("export_verilog_traces");
    let mut counts = Counts::default();
    for line in files("traces", &FOLDERS) {
        compare(&folder, &line, &mut counts);
    }
    println!("scenarios: {} runs, {} nets, {} changes equal", counts.runs, counts.nets, counts.changes);
    assert!(counts.runs > 90 && counts.changes > 100_000);
}

/// What Yosys makes of designs of our own in Verilog, memories among them, in Verilog again.
#[needs(iverilog, verilator, yosys)]
#[test]
fn icarus_runs_netlists_of_yosys_as_we_do() {
    let begun = std::time::Instant::now();
    let mut counts = Counts::default();
    // Yosys' latch with a clear has an enable and data that change together, which is a race in Verilog
    for design in catalogue::all().into_iter().filter(|d| d.name != "latches") {
        // the processor need not end its program
        let design = harness::Design { end: design.end.min(60_000), ..design };
        let folder = design.folder("_again");
        design.synthesise(&folder, &design.source(), &[Level::Words]);
        design.discreta(&folder, Level::Words);
        compare(&folder, folder.join("Words.scenario.json").to_str().unwrap(), &mut counts);
        // what was one memory is one again
        if ["cpu", "fifo"].contains(&design.name) {
            let netlist = folder.join("Words.json");
            let again = folder.join("again.v");
            discreta(&["export", netlist.to_str().unwrap(), "--to", "verilog", "-o", again.to_str().unwrap()]);
            assert_eq!(complaints(&folder, "verilator", &["--lint-only", "-Wall", "again.v"]), "", "{}", design.name);
            let passes = "proc; opt; memory -nomap; flatten; opt_clean; check -assert";
            let memories = if design.name == "cpu" { 2 } else { 1 };
            let script = format!(
                "read_verilog again.v; hierarchy -auto-top; {passes}; select -assert-count {memories} t:$mem_v2; \
                 select -assert-none t:$memrd* t:$memwr*"
            );
            complaints(&folder, "yosys", &["-q", "-p", &script]);
        }
    }
    let Counts { runs, nets, changes } = counts;
    println!("netlists: {runs} runs, {nets} nets, {changes} changes equal, {:?}", begun.elapsed());
    assert!(runs == 11 && changes > 200_000);
}

#[needs(iverilog, verilator, yosys)]
#[test]
fn no_tool_has_a_warning() {
    let folder = folder("export_verilog_lint");
    let lines: Vec<String> = circuits().into_iter().chain(VARIANTS[..6].iter().map(|v| (*v).to_owned())).collect();
    for line in &lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let words: Vec<&str> = words.split(|w| *w == "-s").next().unwrap().to_vec();
        let name = line.replace(|c: char| !c.is_ascii_alphanumeric(), "_") + ".v";
        let design = folder.join(&name).to_str().unwrap().to_owned();
        discreta(&[&["export"], &words[..], &["--to", "verilog", "-o", &design]].concat());
        for (program, arguments) in [
            ("iverilog", &["-Wall", "-g2005", "-o", "/dev/null", &design][..]),
            ("verilator", &["--lint-only", "-Wall", &design]),
            ("yosys", &["-q", "-p", &format!("read_verilog {name}; hierarchy -check; proc; check -assert")]),
        ] {
            assert_eq!(complaints(&folder, program, arguments), "", "{line}: {program}");
        }
    }
    println!("{} designs without a warning", lines.len());
}

/// Through Yosys and back: every net that is still there has the same value at every time.
#[needs(yosys)]
#[test]
fn what_comes_back_from_yosys_is_the_same() {
    let folder = folder("export_verilog_back");
    let (mut counts, mut gone) = (Counts::default(), 0);
    let synth = ["circuits/evaluation/line.json", "circuits/evaluation/line_gates.json", "circuits/dda/line.json"];
    let levels = circuits().into_iter().map(|c| (c, "hierarchy -auto-top; proc"));
    let levels = levels.chain(synth.map(|c| (c.to_owned(), "prep -auto-top -flatten")));
    for (circuit, level) in levels.chain(synth.map(|c| (c.to_owned(), "synth -auto-top"))) {
        // Yosys makes wires of delays and has no clocks
        if circuit.contains("feed/sy") {
            continue;
        }
        let name = format!("{circuit} {level}").replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let at = |kind: &str| folder.join(format!("{name}{kind}")).to_str().unwrap().to_owned();
        let (ours, design, back) = (at(".vcd"), at(".v"), at(".json"));
        discreta(&["run", &circuit, "-o", &ours, "--x-control", "ignore"]);
        discreta(&["export", &circuit, "--to", "verilog", "-o", &design]);
        complaints(&folder, "yosys", &["-q", "-p", &format!("read_verilog {name}.v; {level}; write_json {name}.json")]);
        // the circuit's own scenario, on the netlist
        let file: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(repository(&circuit)).unwrap()).unwrap();
        let mut simulation = file["simulation"].clone();
        let (end, ours) = waves(Path::new(&ours), "");
        for gone in ["expect", "checks", "until", "limit", "trace"] {
            simulation.as_object_mut().unwrap().remove(gone);
        }
        // Verilog of ours has no signed ports: negative numbers are given as their bits
        let netlist = discreta::circuit::load(repository(&circuit)).unwrap().netlist;
        for (name, value) in simulation["inputs"].as_object_mut().into_iter().flatten() {
            if let Some(number) = value.as_i64().filter(|n| *n < 0) {
                let width = netlist.signal(netlist.find(name).unwrap()).width;
                *value = Value::from_u64(number.cast_unsigned(), width).to_string().into();
            }
        }
        simulation["limit"] = serde_json::json!({ "time": end });
        simulation["trace"] = serde_json::json!(["**"]);
        let scenario = serde_json::json!({ "circuit": back, "simulation": simulation });
        let path = at("_scenario.json");
        std::fs::write(&path, scenario.to_string()).unwrap();
        let theirs = at("_back.vcd");
        discreta(&["run", &path, "-o", &theirs, "--x-control", "ignore"]);
        let (_, theirs) = waves(Path::new(&theirs), "");
        let theirs: HashMap<&str, &Vec<(u64, String)>> = theirs.iter().map(|(n, c)| (n.as_str(), c)).collect();
        let before = counts.nets;
        for (net, changes) in &ours {
            // a name that stays, without what drove it: nothing needed it
            let undriven =
                |found: &&&Vec<(u64, String)>| level != "hierarchy -auto-top; proc" && found[0].1.contains('z');
            let Some(found) = theirs.get(net.as_str()).filter(|found| !undriven(found)) else {
                gone += 1;
                continue;
            };
            assert_eq!(changes, *found, "{circuit} by {level}: {net}");
            counts.nets += 1;
            counts.changes += changes.len();
        }
        assert!(counts.nets - before > 10, "{circuit} by {level}: hardly a net is left");
        counts.runs += 1;
    }
    println!(
        "round trips: {} runs, {} nets, {} changes equal; {gone} nets not there any more",
        counts.runs, counts.nets, counts.changes
    );
}
