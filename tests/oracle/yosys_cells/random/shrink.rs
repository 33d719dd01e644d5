//! Makes a netlist on which the two differ small enough to be understood, and writes it down.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use discreta::Logic;
use serde_json::{Map, Value as Json, json};

use super::compare::{Difference, bench, compare};
use super::design::{Bit, Design, Item};

/// How many times it is tried with less.
const TRIES: usize = 150;

/// What still differs when the cells and changes of inputs that do not matter are gone.
pub fn shrink(folder: &Path, design: &Design, found: &Difference, models: &str) -> (Design, Difference) {
    let (mut design, mut found) = (cut(design, found.tick), found.clone());
    let mut tries = 0;
    let mut differs = |candidate: &Design| {
        tries += 1;
        let told =
            (tries <= TRIES).then(|| compare(folder, std::slice::from_ref(candidate), models).differences.remove(0));
        told.flatten()
    };
    // what the net depends on first, in one step
    let cone = tied(Design { items: cone(&design.items, found.wire), ..design.clone() });
    if let Some(other) = differs(&cone) {
        (design, found) = (cut(&cone, other.tick), other);
    }
    let mut size = design.items.len().div_ceil(2);
    while size > 0 {
        let (mut at, mut less) = (0, false);
        while at < design.items.len() {
            let mut candidate = design.clone();
            candidate.items.drain(at..(at + size).min(design.items.len()));
            let candidate = tied(candidate);
            match differs(&candidate) {
                Some(other) => {
                    (design, found, less) = (cut(&candidate, other.tick), other, true);
                }
                None => at += size,
            }
        }
        size = if size == 1 && !less { 0 } else { (size / 2).max(1) };
    }
    for input in 0..design.inputs.len() {
        let mut candidate = design.clone();
        candidate.inputs[input].values.truncate(1);
        if let Some(other) = differs(&candidate) {
            (design, found) = (cut(&candidate, other.tick), other);
        }
    }
    let flat =
        Design { items: design.items.iter().map(|i| Item { group: 0, ..i.clone() }).collect(), ..design.clone() };
    let flat = Design { groups: vec![0], ..flat };
    match differs(&flat) {
        Some(other) => (compact(&flat), other),
        None => (compact(&design), found),
    }
}

/// With x in place of what nothing drives any more: of a gate that reads such nets alone Icarus makes z.
pub fn tied(mut design: Design) -> Design {
    let mut driven: BTreeSet<usize> = design.items.iter().flat_map(|i| i.outputs.iter().flatten()).copied().collect();
    driven.extend(design.inputs.iter().map(|i| i.wire));
    for bit in design.items.iter_mut().flat_map(|i| i.inputs.iter_mut().flatten()) {
        if wire(bit).is_some_and(|w| !driven.contains(&w)) {
            *bit = Bit::Constant(Logic::X);
        }
    }
    design
}

/// Without what comes after a tick.
fn cut(design: &Design, tick: u64) -> Design {
    let mut design = design.clone();
    design.end = design.end.min(tick);
    for input in &mut design.inputs {
        input.values.retain(|v| v.0 <= tick);
    }
    design
}

/// Without the inputs that nothing reads.
fn compact(design: &Design) -> Design {
    let mut design = design.clone();
    let read: BTreeSet<usize> = design.items.iter().flat_map(|i| i.inputs.iter().flatten()).filter_map(wire).collect();
    if design.inputs.iter().any(|i| read.contains(&i.wire)) {
        design.inputs.retain(|i| read.contains(&i.wire));
    }
    design
}

fn wire(bit: &Bit) -> Option<usize> {
    match *bit {
        Bit::Wire(wire, _) => Some(wire),
        Bit::Constant(_) => None,
    }
}

/// The cells on which a wire depends.
fn cone(items: &[Item], from: usize) -> Vec<Item> {
    let (mut wires, mut open) = (BTreeSet::from([from]), vec![from]);
    while let Some(next) = open.pop() {
        for item in items.iter().filter(|i| i.outputs.iter().flatten().any(|w| *w == next)) {
            open.extend(item.inputs.iter().flatten().filter_map(wire).filter(|w| wires.insert(*w)));
        }
    }
    items.iter().filter(|i| i.outputs.iter().flatten().any(|w| wires.contains(w))).cloned().collect()
}

/// Writes a netlist with its stimulus for both simulators; the folder.
pub fn write(folder: &Path, design: &Design, found: &Difference, models: &str) -> PathBuf {
    let folder = folder.join(format!("seed_{}", design.seed));
    std::fs::create_dir_all(&folder).unwrap();
    let (mut clocks, mut inputs, mut stimulus) = (Map::new(), Map::new(), Vec::new());
    for input in &design.inputs {
        let name = format!("w{}", input.wire);
        let literal = |v: &discreta::Value| format!("{}'b{}", v.width(), v.bit_string());
        if let Some(clock) = input.clock {
            clocks.insert(name, json!({ "period": clock.period, "high": clock.high, "phase": clock.phase }));
        } else if let Some((first, rest)) = input.values.split_first() {
            inputs.insert(name.clone(), json!(literal(&first.1)));
            for (at, value) in rest {
                stimulus.push((*at, json!({ "at": at, "set": { name.as_str(): literal(value) } })));
            }
        }
    }
    stimulus.sort_by_key(|s| s.0);
    let stimulus: Vec<Json> = stimulus.into_iter().map(|s| s.1).collect();
    let scenario = json!({ "circuit": "netlist.json", "simulation": { "clocks": clocks, "inputs": inputs,
        "stimulus": stimulus, "limit": { "time": design.end } } });
    let (text, rows) = bench(std::slice::from_ref(design));
    let mut told = format!("seed {}, {} cells\n", design.seed, design.items.len());
    writeln!(told, "{} at tick {} (10 units of time later in Icarus):", found.net, found.tick).unwrap();
    writeln!(told, "  discreta {}\n  Icarus   {}", found.ours, found.theirs).unwrap();
    told += "discreta run scenario.json -o discreta.vcd\n\
             iverilog -g2012 -s bench -o bench.vvp models.v bench.v && vvp -n bench.vvp\n";
    for (name, text) in [
        ("netlist.json", serde_json::to_string_pretty(&design.json()).unwrap()),
        ("scenario.json", serde_json::to_string_pretty(&scenario).unwrap()),
        ("bench.v", text),
        ("stimulus.txt", rows),
        ("models.v", models.into()),
        ("README", told),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    folder
}
