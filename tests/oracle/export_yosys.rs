//! Circuits written as Yosys netlists: what is read back gives the same value on every net at every tick, and Yosys
//! takes what is written.

use crate::designs::catalogue;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::designs::harness::Level;
use crate::support::engines::{self, simulator};
use crate::support::program::run;
use crate::support::{Rng, folder, repository};
use discreta::cell::samples::{Sort, sample};
use discreta::cell::{CellKind, Counter, Edge, Role};
use discreta::export::yosys::{Extra, write};
use discreta::netlist::{Builder, Bus, Direction, Netlist, ScopeId};
use discreta::{Probe, Value, circuit};
use needs::needs;

// ---- random circuits

/// Every kind of cell that a netlist may hold, in a random shape. What resolves a bus comes with its drivers, and memories
/// have tests of their own.
fn kind(rng: &mut Rng) -> CellKind {
    loop {
        let (sort, width) = match *rng.pick(Sort::ALL) {
            Sort::Memory | Sort::Resolve => continue,
            sort @ (Sort::Power | Sort::Demux) => (sort, *rng.pick(&[1, 2, 4, 9])),
            sort => (sort, *rng.pick(&[1, 1, 1, 2, 4, 9, 64, 70])),
        };
        return sample(sort, width, &mut |n| rng.below(n));
    }
}

struct Design {
    netlist: Netlist,
    /// Names and widths of the inputs; the first are clocks, the next controls.
    inputs: Vec<(String, u32)>,
    kinds: Vec<&'static str>,
}

const CLOCKS: usize = 2;

/// Cells between which nothing goes round but through a clock, in a hierarchy of modules and blocks.
fn design(rng: &mut Rng, cells: usize) -> Design {
    let mut b = Builder::new("top");
    let mut scopes: Vec<ScopeId> = vec![b.top()];
    for i in 0..rng.below(5) {
        let parent = *rng.pick(&scopes);
        let block = rng.one_in(3);
        scopes.push(if block {
            b.scope(parent, &format!("blk[{i}]"))
        } else {
            b.instance(parent, &format!("u{i}"), "m")
        });
    }
    let mut inputs: Vec<(String, u32)> = ["c0", "c1", "r", "s", "e"].map(|n| (n.to_string(), 1)).into();
    inputs.extend([("a".to_string(), 4), ("b".to_string(), 9), ("w".to_string(), 70)]);
    let mut buses: Vec<Bus> = inputs.iter().map(|(name, width)| b.input(name, *width)).collect();
    let top = b.top();
    if rng.one_in(3) {
        let (_, bus) = b.declare(top, "io", 4, false, Some(Direction::Inout));
        buses.push(bus);
        inputs.push(("io".into(), 4));
    }
    let first = buses.len();
    // all outputs first, so that what waits for a clock may read any
    let mut plan: Vec<(CellKind, ScopeId, Vec<usize>)> = Vec::new();
    for i in 0..cells {
        let kind = kind(rng);
        let scope = *rng.pick(&scopes);
        let mut outputs = Vec::new();
        for (pin, name) in kind.outputs().iter().enumerate() {
            outputs.push(buses.len());
            // a net may have the name of its cell, as in many circuits
            let name = if pin == 0 && rng.one_in(3) { format!("cell{i}") } else { format!("n{i}_{name}") };
            buses.push(b.declare(scope, &name, kind.output_width(pin), rng.one_in(4), None).1);
        }
        plan.push((kind, scope, outputs));
    }
    let shared = rng.one_in(2).then(|| b.net("shared", 4));
    let kinds = plan.iter().map(|(kind, ..)| kind.element()).collect();
    for (i, (kind, scope, outputs)) in plan.into_iter().enumerate() {
        let open: Vec<bool> = (0..kind.inputs().len()).map(|pin| !kind.requires(pin) && !rng.one_in(3)).collect();
        let mut ins = Vec::new();
        for (pin, spec) in kind.inputs().iter().enumerate() {
            let width = kind.input_width(pin);
            if open[pin] {
                ins.push(Bus::default());
            } else if spec.role == Role::Clock && !rng.one_in(4) {
                ins.push(rng.pick(&buses[..CLOCKS]).clone());
            } else {
                let clocked = kind.edge().is_some() && spec.role != Role::Clock && spec.role != Role::Trigger;
                let later = clocked && !kind.acts_at_once(pin, |p| !open[p]) || spec.role == Role::Delayed;
                // what a counter holds goes straight to its other output
                let end = if later { buses.len() } else { outputs.first().copied().unwrap_or(first) };
                ins.push(operand(rng, &mut b, &buses[..end], width));
            }
        }
        let outs = outputs.iter().map(|&o| buses[o].clone()).collect();
        b.cell(scope, &format!("cell{i}"), kind, ins, outs);
    }
    let io = inputs.iter().position(|i| i.0 == "io").map(|i| buses[i].clone());
    for (i, bus) in shared.iter().chain(&io).enumerate() {
        for k in 0..1 + rng.below(2) {
            let (scope, lines) = (*rng.pick(&scopes), [operand(rng, &mut b, &buses[..8], 4), buses[2 + i].clone()]);
            b.cell(
                scope,
                &format!("driver{i}_{k}"),
                CellKind::Tristate { width: 4 },
                lines.to_vec(),
                vec![bus.clone()],
            );
        }
    }
    Design { netlist: b.finish().unwrap_or_else(|faults| panic!("{faults:?}")), inputs, kinds }
}

/// Bits of signals and at times constants, in as many pieces as it takes.
fn operand(rng: &mut Rng, b: &mut Builder, from: &[Bus], width: u32) -> Bus {
    let mut all = Bus::default();
    while all.width() < width {
        let left = width - all.width();
        if rng.one_in(12) {
            let run = 1 + rng.below(u64::from(left)) as u32;
            let value = rng.four_valued(run, 6);
            all.append(&b.constant(&value));
            continue;
        }
        let bus = rng.pick(from);
        let take = 1 + rng.below(u64::from(bus.width().min(left))) as u32;
        let lo = rng.below(u64::from(bus.width() - take + 1)) as u32;
        all.append(&bus.slice(lo, take));
    }
    all
}

/// Values of inputs at a tick.
type Vector = (u64, Vec<(String, Value)>);

fn stimulus(rng: &mut Rng, inputs: &[(String, u32)], count: u64) -> Vec<Vector> {
    let mut list = Vec::new();
    for n in 0..count {
        let mut values = Vec::new();
        for (i, (name, width)) in inputs.iter().enumerate() {
            if n == 0 || rng.one_in(if i < CLOCKS + 3 { 3 } else { 2 }) {
                // clocks and controls often change between known values
                let unknown = if i < CLOCKS + 3 { 8 } else { *rng.pick(&[4, 30, u64::MAX]) };
                values.push((name.clone(), rng.four_valued(*width, unknown)));
            }
        }
        list.push((n * 2, values));
    }
    list
}

/// Every net of `a` has the value of the net of this name in `b` at every tick. How many values were compared.
fn same(label: &str, a: &Netlist, b: &Netlist, stimulus: &[Vector]) -> usize {
    let mut sims = [simulator(a), simulator(b)];
    let mut names: Vec<String> = a.signal_ids().filter(|&s| !a.signal(s).hidden).map(|s| a.signal_path(s)).collect();
    names.sort();
    let mut shown: Vec<String> = b.signal_ids().filter(|&s| !b.signal(s).hidden).map(|s| b.signal_path(s)).collect();
    shown.sort();
    assert_eq!(names, shown, "{label}");
    for name in &names {
        let of = |n: &Netlist| {
            let signal = n.signal(n.find(name).unwrap());
            (signal.width, signal.signed, signal.scope.index() == 0 && signal.port.is_some())
        };
        assert_eq!(of(a), of(b), "{label}: {name}");
    }
    let probes: Vec<[Probe; 2]> =
        names.iter().map(|n| [sims[0].probe(n).unwrap(), sims[1].probe(n).unwrap()]).collect();
    let mut compared = 0;
    for (time, values) in stimulus {
        for sim in &mut sims {
            sim.run_to(*time).unwrap_or_else(|e| panic!("{label}: {e}"));
            for (name, value) in values {
                let input = sim.input(name).unwrap();
                sim.set_value(input, value);
            }
            sim.settle().unwrap_or_else(|e| panic!("{label}: {e}"));
        }
        for (name, [one, two]) in names.iter().zip(&probes) {
            let (one, two) = (sims[0].value(one), sims[1].value(two));
            assert_eq!(one, two, "{label}: {name} at {time}, {values:?}");
            compared += 1;
        }
    }
    compared
}

/// Writes a netlist and reads it back.
fn back(folder: &Path, name: &str, netlist: &Netlist) -> Netlist {
    let path = folder.join(format!("{name}.json"));
    std::fs::write(&path, write(netlist, &Extra::default())).unwrap();
    circuit::load(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).netlist
}

#[test]
fn random_circuits_come_back_as_they_were() {
    let folder = folder("export_yosys_random");
    let (mut cells, mut values) = (BTreeMap::<&str, usize>::new(), 0);
    for seed in 0..600 {
        let mut rng = Rng::new(seed);
        let size = if seed < 400 { 1 } else { 30 };
        let design = design(&mut rng, size);
        let label = format!("seed {seed}, {:?}", &design.kinds[..design.kinds.len().min(3)]);
        let other = back(&folder, "random", &design.netlist);
        values += same(&label, &design.netlist, &other, &stimulus(&mut rng, &design.inputs, 60));
        design.kinds.iter().for_each(|kind| *cells.entry(kind).or_default() += 1);
    }
    let all: usize = cells.values().sum();
    println!("600 circuits, {all} cells of {} elements, {values} values of nets compared: {cells:?}", cells.len());
    assert!(cells.len() >= 40 && cells.values().all(|&n| n >= 20), "{cells:?}");
    engines::ran(0, 0);
}

// ---- what is shipped

/// The JSON files below a folder of the repository, in order.
fn files(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::from(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(repository("").join(&folder)).unwrap() {
            let path = folder.join(entry.unwrap().file_name());
            if repository("").join(&path).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "json") {
                found.push(path.to_str().unwrap().to_owned());
            }
        }
    }
    found.sort();
    found
}

/// The circuits that are run by themselves.
fn circuits() -> Vec<String> {
    let library = |name: &String| name.starts_with("circuits/lib/") || name.ends_with(".schema.json");
    files("circuits").into_iter().filter(|name| !library(name)).collect()
}

/// Writes what `path` names as a netlist.
fn exported(folder: &Path, path: &str) -> String {
    let to = folder.join(path.replace(['/', '.'], "_") + ".json").to_str().unwrap().to_owned();
    let (status, _, told) = run(&["export", path, "--to", "yosys-json", "-o", &to]);
    assert_eq!(status, 0, "{path}: {told}");
    to
}

/// The waveform of every net and how the run ended.
fn waves(folder: &Path, path: &str, more: &[&str], name: &str) -> (PathBuf, i32, String) {
    let vcd = folder.join(name);
    let (status, out, told) = run(&[&["run", path, "--trace", "**", "-o", vcd.to_str().unwrap()], more].concat());
    assert!(status < 2, "{path}: {told}");
    (vcd, status, out.lines().take_while(|l| !l.contains(".vcd")).collect::<Vec<_>>().join("\n"))
}

fn nets(vcd: &Path) -> usize {
    std::fs::read_to_string(vcd).unwrap().lines().filter(|l| l.starts_with("$var")).count()
}

/// Circuits with their own scenario and with other inputs, and every scenario of the golden traces.
#[test]
fn shipped_circuits_run_as_before() {
    let folder = folder("export_yosys_shipped");
    let with: &[(&str, &[&str])] = &[
        ("circuits/evaluation/line.json", &["-s", "dx=9", "-s", "dy=4"]),
        ("circuits/evaluation/line_gates.json", &["-s", "dx=3", "-s", "dy=8'hxx", "--cycles", "20"]),
        ("circuits/dda/line.json", &["-s", "dx=100", "-s", "dy=77"]),
        ("circuits/evaluation/fast_line.json", &["-s", "dx=5", "-s", "dy=5", "-s", "xh=8'b1z"]),
    ];
    let plain = circuits().into_iter().chain(files("traces")).map(|path| (path, &[][..]));
    let runs: Vec<(String, &[&str])> =
        plain.chain(with.iter().map(|(path, more)| ((*path).to_owned(), *more))).collect();
    let mut signals = 0;
    for (path, more) in &runs {
        let netlist = exported(&folder, path);
        let (one, ended, _) = waves(&folder, path, more, "one.vcd");
        let (two, ended_too, _) = waves(&folder, &netlist, more, "two.vcd");
        assert_eq!((ended, nets(&one)), (ended_too, nets(&two)), "{path} {more:?}");
        let (differs, told, _) = run(&["diff", one.to_str().unwrap(), two.to_str().unwrap()]);
        assert_eq!(differs, 0, "{path} {more:?}: {told}");
        signals += nets(&one);
    }
    assert!(runs.len() > 140, "{}", runs.len());
    println!("{} runs of circuits and scenarios, {signals} nets: the same waveforms", runs.len());
}

/// Yosys takes them, finds nothing wrong but the flip-flops made of gates in a circle, and writes Verilog that Icarus
/// takes.
#[needs(iverilog, yosys)]
#[test]
fn yosys_takes_shipped_circuits() {
    let folder = folder("export_yosys_check");
    let (mut cells, mut loops) = (0, 0);
    for path in circuits() {
        let netlist = exported(&folder, &path);
        let script = format!("read_json {netlist}; hierarchy -check; check; stat; write_verilog -noattr again.v");
        let told = Command::new("yosys").current_dir(&folder).args(["-Q", "-T", "-p", &script]).output();
        let told = told.unwrap_or_else(|e| panic!("yosys: {e}; install it"));
        let out = String::from_utf8_lossy(&told.stdout);
        assert!(told.status.success(), "{path}: {}", String::from_utf8_lossy(&told.stderr));
        let warnings: Vec<&str> = out.lines().filter(|l| l.starts_with("Warning: ")).collect();
        let wrong: Vec<&&str> =
            warnings.iter().filter(|w| **w != "Warning: found logic loop in module sr_nor:").collect();
        assert!(wrong.is_empty(), "{path}: {wrong:?}");
        loops += warnings.len();
        let count =
            out.lines().rev().find_map(|l| l.trim().strip_prefix("Number of cells:")?.trim().parse::<u64>().ok());
        cells += count.unwrap();
        let told =
            Command::new("iverilog").current_dir(&folder).args(["-g2005", "-o", "again.vvp", "again.v"]).output();
        let told = told.unwrap_or_else(|e| panic!("iverilog: {e}; install it"));
        let blackbox = std::fs::read_to_string(&netlist).unwrap().contains("\"blackbox\"");
        assert!(blackbox || told.status.success(), "{path}: {}", String::from_utf8_lossy(&told.stderr));
    }
    println!("{} circuits of {cells} cells, {loops} of them with flip-flops of gates", circuits().len());
}

/// The designs of Verilog come back as words and gates: the same waveform of every net, under their own test benches.
#[needs(yosys)]
#[test]
fn netlists_of_yosys_come_back() {
    let (mut runs, mut signals) = (0, 0);
    for design in catalogue::all() {
        let (folder, again) = (design.folder("_exported"), design.folder("_come_back"));
        // gates of the processor are many, and take Yosys longer than all the others
        let levels = if design.name == "cpu" { &[Level::Words][..] } else { &[Level::Words, Level::Gates] };
        design.synthesise(&folder, &design.source(), levels);
        for &level in levels {
            let [from, to] = [&folder, &again].map(|f| f.join(format!("{level:?}.json")).to_str().unwrap().to_owned());
            let (status, _, told) = run(&["export", &from, "--top", design.name, "--to", "yosys-json", "-o", &to]);
            assert_eq!(status, 0, "{} {level:?}: {told}", design.name);
            design.discreta(&folder, level);
            design.discreta(&again, level);
            let [one, two] = [&folder, &again].map(|f| f.join(format!("{level:?}.vcd")));
            let (differs, told, _) = run(&["diff", one.to_str().unwrap(), two.to_str().unwrap()]);
            assert_eq!(differs, 0, "{} {level:?}: {told}", design.name);
            let count = nets(&one);
            assert!(count == nets(&two) && count >= 10, "{} {level:?}: {count} nets", design.name);
            signals += count;
            runs += 1;
        }
    }
    println!("{runs} netlists of Yosys, {signals} nets: the same waveforms");
}

/// What it says of itself in a file that somebody else changed.
#[test]
fn what_is_wrong_with_an_element_is_told() {
    let folder = folder("export_yosys_wrong");
    let text = write(&counter(), &Extra::default());
    assert!(text.contains("\"discreta\": \"counter edge=falling step="), "{text}");
    for (from, to, expected) in [
        ("counter edge=falling", "counter edge=sideways", "there is no such element"),
        ("step=4'b0001", "step=5'b00001", "there is no such element"),
        ("step=4'b0001 init=4'bxxxx", "step=3'b001 init=3'bxxx", "is connected to 4 bits, and is 3"),
        ("\"en\": [", "\"enable\": [", "it connects `enable`, which a `counter` does not have"),
        ("\"top\": \"", "\"discreta_timescale\": \"3ns\", \"top\": \"", "a tick cannot be `3ns`"),
        ("\"top\": \"", "\"discreta_simulation\": \"{}}\", \"top\": \"", "discreta_simulation"),
    ] {
        assert!(text.contains(from), "{from}: {text}");
        let path = folder.join("wrong.json");
        std::fs::write(&path, text.replacen(from, to, 8)).unwrap();
        let told = circuit::load(&path).expect_err(to).to_string();
        assert!(told.contains(expected), "{to}: {told}");
    }
}

/// A counter with an enable.
fn counter() -> Netlist {
    let mut b = Builder::new("top");
    let (clk, en, q) = (b.input("clk", 1), b.input("en", 1), b.output("q", 4));
    let (step, init) = (Value::from_u64(1, 4), Value::unknown(4));
    let kind = CellKind::Counter(Box::new(Counter { edge: Edge::Falling, step, init }));
    let (top, open) = (b.top(), Bus::default);
    b.cell(top, "counter", kind, vec![clk, open(), open(), open(), en], vec![q]);
    b.finish().unwrap()
}

/// Ticks, parameters and scenario stay with the netlist.
#[needs(yosys)]
#[test]
fn a_circuit_keeps_what_goes_with_it() {
    let folder = folder("export_yosys_extra");
    let file = folder.join("slow.json");
    let text = r#"{ "timescale": "100ps", "modules": { "slow": {
        "parameters": { "N": { "default": 5 } },
        "ports": { "clk": { "direction": "input" }, "q": { "direction": "output", "width": 4 } },
        "nets": { "late": 1 },
        "cells": {
          "rc": { "type": "rc_delay", "parameters": { "r": "1k", "c": "1p" }, "connections": { "a": "clk", "y": "late" } },
          "k": { "type": "counter", "parameters": { "width": 4, "init": 0 }, "connections": { "clk": "late", "q": "q" } } } } },
      "simulation": { "clocks": { "clk": { "period": "20ns" } }, "limit": { "cycles": "N+1" } } }"#;
    std::fs::write(&file, text).unwrap();
    let netlist = folder.join("netlist.json");
    let export = ["export", file.to_str().unwrap(), "--to", "yosys-json", "-p", "N=7", "-o", netlist.to_str().unwrap()];
    let (status, _, told) = run(&export);
    assert_eq!(status, 0, "{told}");
    let back = circuit::load(&netlist).unwrap();
    assert_eq!(back.netlist.timescale().to_string(), "100ps");
    assert_eq!(back.parameters.get("N"), Some(&7));
    let (status, out, told) = run(&["run", netlist.to_str().unwrap()]);
    assert!(status == 0 && out.contains("8 clocks"), "{out}{told}");
    // so they do when Yosys has read and written it
    let again = folder.join("again.json");
    let script = format!("read_json {}; write_json {}", netlist.display(), again.display());
    assert!(Command::new("yosys").args(["-q", "-p", &script]).status().unwrap().success());
    let (status, again, told) = run(&["run", again.to_str().unwrap()]);
    assert!(status == 0 && again.contains("8 clocks"), "{again}{told}");
}

/// Graphviz takes the graphs; the same circuit gives the same text.
#[needs(dot)]
#[test]
fn graphs_of_shipped_circuits() {
    for path in circuits().iter().filter(|p| p.contains("evaluation/")) {
        for depth in ["0", "1"] {
            let graph = || run(&["export", path, "--to", "dot", "--depth", depth]);
            let (status, text, told) = graph();
            assert_eq!((status, &graph().1), (0, &text), "{path}: {told}");
            if depth == "0" {
                let file = folder("export_dot").join("graph.dot");
                std::fs::write(&file, &text).unwrap();
                let drawn = Command::new("dot").args(["-Tsvg", file.to_str().unwrap()]).output().unwrap();
                assert!(drawn.status.success() && drawn.stderr.is_empty(), "{path}: {:?}", drawn.stderr);
                let shapes = String::from_utf8_lossy(&drawn.stdout).matches("class=\"node\"").count();
                assert!(shapes > 10, "{path}: {shapes} nodes");
            }
        }
    }
}
