//! Many cells in one netlist and in one Verilog module, driven alike.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use discreta::circuit::Circuit;
use discreta::{Logic, Value};
use serde_json::{Map, Value as Json, json};

use crate::support::engines::simulator;
use crate::support::{Rng, folder};

/// A bit of an input, or 0, or 1 where the input is called so.
pub type Tap = Option<(&'static str, u32)>;

/// A cell with its parameters.
#[derive(Clone)]
pub struct Cell {
    pub kind: String,
    pub parameters: Vec<(&'static str, Value)>,
    pub inputs: Vec<(&'static str, u32)>,
    pub outputs: Vec<(&'static str, u32)>,
    /// Inputs of which one bit changes at a time, with the value that they begin with; none for what has no state.
    pub controls: Vec<(&'static str, Value)>,
    /// What the state is at the start.
    pub init: Option<Value>,
    /// The module of `models.v` that it is compared with, and parameters of it that are 1.
    pub model: Option<&'static str>,
    /// Values that an input is given more often than by chance.
    pub likely: Vec<(&'static str, Value)>,
    /// Ports whose bits are those of inputs. An input of which they are bits is no port itself.
    pub taps: Vec<(&'static str, Vec<Tap>)>,
    /// Whether several controls change at one instant. Their levels are known then.
    pub together: bool,
    /// Whether controls are never x or z.
    pub known: bool,
    /// Whether the netlist has it in parts.
    pub in_parts: bool,
}

impl Cell {
    pub fn new(kind: &str, inputs: &[(&'static str, u32)], outputs: &[(&'static str, u32)]) -> Cell {
        Cell {
            kind: kind.into(),
            parameters: vec![],
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            controls: vec![],
            init: None,
            model: None,
            likely: vec![],
            taps: vec![],
            together: false,
            known: false,
            in_parts: false,
        }
    }

    pub fn with(mut self, name: &'static str, value: Value) -> Cell {
        self.parameters.push((name, value));
        self
    }

    /// Whether an input is a port of the cell.
    pub fn is_port(&self, input: &str) -> bool {
        !self.taps.iter().flat_map(|t| &t.1).flatten().any(|t| t.0 == input)
    }

    /// A parameter that is a number.
    pub fn number(self, name: &'static str, n: u64) -> Cell {
        self.with(name, Value::from_u64(n, 32))
    }

    pub fn flag(self, name: &'static str, set: bool) -> Cell {
        self.with(name, Value::from_u64(set.into(), 1))
    }
}

/// The folder of Yosys' Verilog models: `YOSYS_DATDIR`, or that of the Yosys that is installed.
pub fn library() -> PathBuf {
    let told = Command::new("yosys-config").arg("--datdir").output().ok().filter(|o| o.status.success());
    let told = told.map(|o| PathBuf::from(String::from_utf8_lossy(&o.stdout).trim()));
    let told = std::env::var_os("YOSYS_DATDIR").map(PathBuf::from).or(told);
    // Debian has that program in a package of its own
    let folder = told.unwrap_or_else(|| "/usr/share/yosys".into());
    assert!(folder.join("simlib.v").is_file(), "Yosys' models are not in {}: install yosys", folder.display());
    folder
}

/// Runs so many vectors through all cells in both; prints how many values were compared.
pub fn compare(name: &str, cells: &[Cell], vectors: usize) {
    let mut rng = Rng::named(name);
    let stimulus: Vec<Vec<Vec<Value>>> = cells.iter().map(|c| inputs(c, vectors, &mut rng)).collect();
    let folder = folder(&format!("yosys_cells_{name}"));
    let theirs = icarus(&folder, cells, &stimulus, vectors);
    let ours = discreta(&folder, cells, &stimulus, vectors);
    let mut wrong = Vec::new();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, cell) in cells.iter().enumerate() {
        *counts.entry(&cell.kind).or_default() += vectors;
        for v in 0..vectors {
            if ours[v][i] != theirs[v][i] {
                wrong.push((i, v));
                break;
            }
        }
    }
    for &(i, v) in wrong.iter().take(8) {
        let cell = &cells[i];
        eprintln!("{} {:?}", cell.kind, cell.parameters);
        let from = v.saturating_sub(if cell.controls.is_empty() { 0 } else { 3 });
        for (step, values) in stimulus[i].iter().enumerate().take(v + 1).skip(from) {
            let ins = cell.inputs.iter().zip(values).map(|(p, v)| format!("{}={}", p.0, v.bit_string()));
            eprintln!("  {step}: {}", ins.collect::<Vec<_>>().join(" "));
        }
        eprintln!("  discreta {:?}\n  icarus   {:?}", ours[v][i], theirs[v][i]);
    }
    let kinds: BTreeMap<&str, usize> = wrong.iter().fold(BTreeMap::new(), |mut k, &(i, _)| {
        *k.entry(cells[i].kind.as_str()).or_default() += 1;
        k
    });
    assert!(wrong.is_empty(), "{} of {} cells differ: {kinds:?}", wrong.len(), cells.len());
    let (total, least) = (counts.values().sum::<usize>(), counts.values().min().copied().unwrap_or(0));
    println!("{name}: {} types, {} cells, {total} cases, at least {least} of each type", counts.len(), cells.len());
}

/// A value of some of the ways in which cells go wrong.
fn value(width: u32, cell: &Cell, port: &str, rng: &mut Rng) -> Value {
    let likely: Vec<&Value> = cell.likely.iter().filter(|l| l.0 == port).map(|l| &l.1).collect();
    if !likely.is_empty() && rng.one_in(3) {
        return (*rng.pick(&likely)).clone();
    }
    match rng.below(10) {
        0 => Value::from_u64(rng.below(4), width),
        1 => Value::from_i64(-(rng.below(4) as i64), width),
        2 => rng.four_valued(width, 2),
        3 | 4 => rng.four_valued(width, 6),
        5 => rng.four_valued(width, u64::from(width) * 2),
        _ => rng.known(width),
    }
}

/// What each input is in each vector.
fn inputs(cell: &Cell, vectors: usize, rng: &mut Rng) -> Vec<Vec<Value>> {
    let first = cell.inputs.iter().map(|&(port, width)| {
        let control = cell.controls.iter().find(|c| c.0 == port);
        control.map_or_else(|| value(width, cell, port, rng), |c| c.1.clone())
    });
    let mut list = vec![first.collect::<Vec<Value>>()];
    while list.len() < vectors {
        let mut next = list[list.len() - 1].clone();
        let turn = !cell.controls.is_empty() && !rng.one_in(3);
        if turn {
            // one bit alone, so that no race decides what Verilog gives
            for _ in 0..if cell.together { 1 + rng.below(3) } else { 1 } {
                let (port, _) = rng.pick(&cell.controls);
                let at = cell.inputs.iter().position(|i| i.0 == *port).unwrap();
                let bit = rng.below(next[at].width().into()) as u32;
                let levels = [Logic::Zero, Logic::One, Logic::Zero, Logic::One, Logic::X, Logic::Z];
                let level = *rng.pick(if cell.known { &levels[..4] } else { &levels });
                next[at].set_bit(bit, level);
            }
        } else {
            for (to, &(port, width)) in next.iter_mut().zip(&cell.inputs) {
                if !cell.controls.iter().any(|c| c.0 == port) {
                    *to = value(width, cell, port, rng);
                }
            }
        }
        list.push(next);
    }
    list
}

/// Cells with a model in `models.v`.
pub const OWN: &str = include_str!("models.v");

/// The module that models a cell, with its parameters.
pub fn module(cell: &Cell) -> String {
    let parameters = cell.parameters.iter().map(|(name, v)| match v.to_u64() {
        // as Yosys' own parameters are: numbers, or bits
        Some(n) if v.width() == 32 && n < 1 << 31 => format!(".{name}({n})"),
        _ => format!(".{name}({}'b{})", v.width(), v.bit_string()),
    });
    let own = format!("own_{}", &cell.kind[1..]);
    let mut parameters: Vec<String> = parameters.collect();
    let module = match cell.model {
        Some(model) => {
            let (module, more) = model.split_once(' ').unwrap_or((model, ""));
            parameters.extend(more.split_whitespace().map(|p| format!(".{p}(1)")));
            module.to_owned()
        }
        None if OWN.contains(&format!("module {own} ")) => own,
        None => format!("\\{} ", cell.kind),
    };
    if parameters.is_empty() { module } else { format!("{module} #({})", parameters.join(", ")) }
}

/// The outputs of each cell in each vector, as Icarus has them.
fn icarus(folder: &Path, cells: &[Cell], stimulus: &[Vec<Vec<Value>>], vectors: usize) -> Vec<Vec<String>> {
    let total: u32 = cells.iter().flat_map(|c| &c.inputs).map(|p| p.1).sum();
    let mut text = format!("module bench;\nreg [{total}-1:0] in; reg [{total}-1:0] all [0:{vectors}-1]; integer v;\n");
    let mut show = String::new();
    let mut at = 0;
    for (i, cell) in cells.iter().enumerate() {
        let mut ports = Vec::new();
        let mut first = BTreeMap::new();
        for (port, width) in &cell.inputs {
            first.insert(*port, at);
            if cell.is_port(port) {
                ports.push(format!(".{port}(in[{at} +: {width}])"));
            }
            at += width;
        }
        for (port, taps) in &cell.taps {
            let bits = taps.iter().rev().map(|t| match *t {
                None => "1'b0".into(),
                Some(("1", _)) => "1'b1".into(),
                Some((input, bit)) => format!("in[{}]", first[input] + bit),
            });
            ports.push(format!(".{port}({{{}}})", bits.collect::<Vec<_>>().join(", ")));
        }
        for (port, width) in &cell.outputs {
            writeln!(text, "wire [{width}-1:0] y{i}_{port};").unwrap();
            ports.push(format!(".{port}(y{i}_{port})"));
            writeln!(show, "    $write(\"%b \", y{i}_{port});").unwrap();
        }
        writeln!(text, "{} c{i} ({});", module(cell), ports.join(", ")).unwrap();
        if let Some(init) = &cell.init {
            writeln!(text, "initial c{i}.Q = {}'b{};", init.width(), init.bit_string()).unwrap();
        }
    }
    write!(
        text,
        "initial begin\n  $readmemb(\"stimulus.txt\", all);\n  for (v = 0; v < {vectors}; v = v + 1) begin\n    \
         in = all[v]; #1;\n{show}    $write(\"\\n\");\n  end\nend\nendmodule\n"
    )
    .unwrap();
    let mut lines = String::new();
    for v in 0..vectors {
        // the first input is the lowest
        for values in stimulus.iter().rev() {
            values[v].iter().rev().for_each(|value| lines += &value.bit_string());
        }
        lines.push('\n');
    }
    std::fs::write(folder.join("bench.v"), text).unwrap();
    std::fs::write(folder.join("models.v"), OWN).unwrap();
    std::fs::write(folder.join("stimulus.txt"), lines).unwrap();
    let library = library();
    let sources = [library.join("simlib.v"), library.join("simcells.v"), "models.v".into(), "bench.v".into()];
    let mut compiler = Command::new("iverilog");
    let compiler = compiler.current_dir(folder).args(["-g2012", "-s", "bench", "-o", "bench.vvp"]).args(&sources);
    let told = compiler.output().unwrap_or_else(|e| panic!("iverilog: {e}; install Icarus Verilog"));
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let told = Command::new("vvp").current_dir(folder).args(["-n", "bench.vvp"]).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let text = String::from_utf8(told.stdout).unwrap();
    let lines = text.lines().filter(|l| !l.starts_with("WARNING"));
    let table: Vec<Vec<String>> = lines
        .map(|line| {
            let mut words = line.split_whitespace();
            let mut take = |c: &Cell| (0..c.outputs.len()).map(|_| words.next().unwrap()).collect::<Vec<_>>().join(" ");
            cells.iter().map(&mut take).collect()
        })
        .collect();
    assert_eq!(table.len(), vectors, "vvp said: {}", &text[..text.len().min(400)]);
    table
}

/// The netlist of all cells as Yosys writes it.
pub fn netlist(cells: &[Cell]) -> Json {
    let (mut ports, mut all, mut names, mut memories) = (Map::new(), Map::new(), Map::new(), Map::new());
    let mut next = 2u32;
    for (i, cell) in cells.iter().enumerate() {
        let mut connections = Map::new();
        let mut bits_of = BTreeMap::new();
        let inputs = cell.inputs.iter().map(|p| (p, "input"));
        for (&(port, width), direction) in inputs.chain(cell.outputs.iter().map(|p| (p, "output"))) {
            let bits: Vec<u32> = (next..next + width).collect();
            next += width;
            let name = format!("c{i}_{port}");
            ports.insert(name.clone(), json!({ "direction": direction, "bits": bits }));
            if cell.is_port(port) {
                connections.insert(port.to_owned(), json!(bits));
            }
            bits_of.insert(port, bits.clone());
            let mut attributes = Map::new();
            if let Some(init) = cell.init.as_ref().filter(|_| direction == "output") {
                attributes.insert("init".into(), json!(init.bit_string()));
            }
            names.insert(name, json!({ "hide_name": 0, "bits": bits, "attributes": attributes }));
        }
        for (port, taps) in &cell.taps {
            let bits = taps.iter().map(|t| match *t {
                None => json!("0"),
                Some(("1", _)) => json!("1"),
                Some((input, bit)) => json!(bits_of[input][bit as usize]),
            });
            connections.insert((*port).to_owned(), bits.collect());
        }
        if cell.in_parts {
            super::memory::parts(&format!("m{i}"), cell, &connections, &mut all, &mut memories);
            continue;
        }
        let parameters = cell.parameters.iter().map(|(n, v)| ((*n).to_owned(), json!(v.bit_string())));
        let parameters: Map<String, Json> = parameters.collect();
        let body = json!({ "hide_name": 0, "type": cell.kind, "parameters": parameters,
            "attributes": { "src": format!("bench.v:{i}") }, "connections": connections });
        all.insert(format!("c{i}"), body);
    }
    json!({ "creator": "Yosys test", "modules": { "bench": {
        "attributes": { "top": "1" }, "ports": ports, "cells": all, "memories": memories,
        "netnames": names } } })
}

/// The outputs of each cell in each vector, as they are here.
fn discreta(folder: &Path, cells: &[Cell], stimulus: &[Vec<Vec<Value>>], vectors: usize) -> Vec<Vec<String>> {
    let path = folder.join("bench.json");
    std::fs::write(&path, serde_json::to_string(&netlist(cells)).unwrap()).unwrap();
    let circuit = discreta::circuit::load(&path).unwrap_or_else(|e| panic!("{e}"));
    let values = run(&circuit, cells, stimulus, vectors);
    // written and read again it is the same
    let path = folder.join("again.json");
    std::fs::write(&path, discreta::export::yosys::write(&circuit.netlist, &Default::default())).unwrap();
    let again = discreta::circuit::load(&path).unwrap_or_else(|e| panic!("{e}"));
    let again = run(&again, cells, stimulus, vectors);
    for (v, (first, second)) in values.iter().zip(&again).enumerate() {
        for (i, cell) in cells.iter().enumerate() {
            assert_eq!(first[i], second[i], "{} written and read again, vector {v} of cell {i}", cell.kind);
        }
    }
    values
}

/// The outputs of each cell after each vector.
fn run(circuit: &Circuit, cells: &[Cell], stimulus: &[Vec<Vec<Value>>], vectors: usize) -> Vec<Vec<String>> {
    let mut sim = simulator(&circuit.netlist);
    let ports = |list: &dyn Fn(&Cell) -> Vec<&'static str>| -> Vec<Vec<String>> {
        cells.iter().enumerate().map(|(i, c)| list(c).iter().map(|p| format!("c{i}_{p}")).collect()).collect()
    };
    let inputs = ports(&|c| c.inputs.iter().map(|p| p.0).collect());
    let inputs: Vec<Vec<_>> = inputs.iter().map(|l| l.iter().map(|n| sim.input(n).unwrap()).collect()).collect();
    let outputs = ports(&|c| c.outputs.iter().map(|p| p.0).collect());
    let outputs: Vec<Vec<_>> = outputs.iter().map(|l| l.iter().map(|n| sim.probe(n).unwrap()).collect()).collect();
    (0..vectors)
        .map(|v| {
            for (values, inputs) in stimulus.iter().zip(&inputs) {
                values[v].iter().zip(inputs).for_each(|(value, &input)| sim.set_value(input, value));
            }
            sim.settle().unwrap();
            let shown = |o: &Vec<_>| o.iter().map(|p| sim.value(p).bit_string()).collect::<Vec<_>>().join(" ");
            let row = outputs.iter().map(shown).collect();
            sim.run_to(sim.now() + 1).unwrap();
            row
        })
        .collect()
}
