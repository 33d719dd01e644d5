//! The proofs and the golden traces can fail: each circuit is changed in one place, many times, and they have to notice.
//!
//! A change is a gate or element that becomes its opposite, two connections that change places, or a constant that
//! becomes another. They are drawn with a fixed seed from all that are possible. One that the checks of circuit files
//! refuse is no mutant. What the proof does not notice has to be explained in `SURVIVORS`. (A golden trace holds the pins
//! of every cell, so it also notices what is no fault.)

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::proofs::{PROOFS, Proof};
use crate::support::{Rng, folder, repository};
use discreta::circuit::load_with;
use serde_json::{Value, json};

/// Mutants of each circuit.
const EACH: usize = 12;

/// Mutants that no proof can notice: circuit, change, and why it is no fault.
const SURVIVORS: &[(&str, &str, &str)] = &[
    (
        "dda/line.json",
        "/modules/line/cells/and_x/connections/in/1 <-> /modules/line/cells/p2/connections/clk",
        "a line's carries are never more than its increment, so allow_x holds none back; p2 loads by start, not by clk",
    ),
    (
        "quadrant/line.json",
        "/modules/quadrant_line/cells/core/connections/yh: 0 -> 1",
        "where the interpolator itself begins is not looked at: the coordinates are counted outside",
    ),
    ("quadrant/fast_line.json", "/modules/quadrant_fast_line/cells/core/connections/xh: 0 -> 1", "as in line.json"),
    ("quadrant/dda_line.json", "/modules/quadrant_dda_line/cells/core/connections/xh: 0 -> 1", "as in line.json"),
    ("quadrant/dda_line.json", "/modules/quadrant_dda_line/cells/core/connections/yh: 0 -> 1", "as in line.json"),
    ("quadrant/line_3d.json", "/modules/quadrant_line_3d/cells/core/connections/yh: 0 -> 1", "as in line.json"),
];

/// Files that are mutated as well, each with the circuits that use it and whose proofs are to notice.
const LIBRARIES: &[(&str, &[&str])] = &[("lib/quadrant.json", &["quadrant/line.json", "quadrant/circle.json"])];

/// What an element, edge or priority becomes.
const OPPOSITES: &[(&str, &str)] = &[
    ("and", "or"),
    ("or", "and"),
    ("nand", "and"),
    ("nor", "or"),
    ("xor", "xnor"),
    ("not", "buf"),
    ("buf", "not"),
    ("eq", "ne"),
    ("lt", "ge"),
    ("gt", "le"),
    ("le", "gt"),
    ("ge", "lt"),
    ("adder", "subtractor"),
    ("rising", "falling"),
    ("falling", "rising"),
    ("ripple_adder", "ripple_subtractor"),
];

/// A change of a file: what stands at a place becomes something else, at several places for an exchange.
#[derive(Clone, Debug)]
struct Mutant {
    changes: Vec<(String, Value)>,
    name: String,
}

/// Every change of one place of a constant: a literal's lowest bit, a number.
fn other_constants(value: &Value) -> Option<Value> {
    match value {
        Value::Number(n) => n.as_i64().map(|n| json!(if n == 0 { 1 } else { n - 1 })),
        Value::String(text) => {
            if let Some((_, opposite)) = OPPOSITES.iter().find(|(word, _)| word == text) {
                return Some(json!(opposite));
            }
            let (_, digits) = text.split_once("'b")?;
            let last = match digits.chars().last()? {
                '0' => '1',
                _ => '0',
            };
            Some(json!(format!("{}{last}", &text[..text.len() - 1])))
        }
        _ => None,
    }
}

/// Whether two pins are those of a gate or adder whose inputs may change places without a change of meaning.
fn commute(a: &str, b: &str) -> bool {
    let (cell_a, pin_a) = a.rsplit_once("/connections/").unwrap();
    let (cell_b, pin_b) = b.rsplit_once("/connections/").unwrap();
    cell_a == cell_b && (pin_a.starts_with("in/") && pin_b.starts_with("in/") || [pin_a, pin_b] == ["a", "b"])
}

/// The mutants of the cells that stand in a module or block.
fn of_cells(place: &str, body: &Value, all: &mut Vec<Mutant>) {
    let mut pins: Vec<(String, Value)> = Vec::new();
    for (name, cell) in body["cells"].as_object().into_iter().flatten() {
        let place = format!("{place}/cells/{name}");
        let mut constant = |at: String, value: &Value| {
            if let Some(other) = other_constants(value) {
                all.push(Mutant { name: format!("{at}: {value} -> {other}"), changes: vec![(at, other)] });
            }
        };
        constant(format!("{place}/type"), &cell["type"]);
        for (parameter, value) in cell["parameters"].as_object().into_iter().flatten() {
            constant(format!("{place}/parameters/{parameter}"), value);
        }
        for (pin, value) in cell["connections"].as_object().into_iter().flatten() {
            let at = format!("{place}/connections/{pin}");
            constant(at.clone(), value);
            for (i, member) in value.as_array().into_iter().flatten().enumerate() {
                constant(format!("{at}/{i}"), member);
                pins.push((format!("{at}/{i}"), member.clone()));
            }
            pins.push((at, value.clone()));
        }
    }
    for (i, (a, at_a)) in pins.iter().enumerate() {
        for (b, at_b) in &pins[i + 1..] {
            // an array and its own members do not change places
            let nested = b.starts_with(a.as_str()) || a.starts_with(b.as_str());
            if at_a != at_b && !nested && !commute(a, b) {
                let name = format!("{a} <-> {b}");
                all.push(Mutant { name, changes: vec![(a.clone(), at_b.clone()), (b.clone(), at_a.clone())] });
            }
        }
    }
    for (name, block) in body["blocks"].as_object().into_iter().flatten() {
        of_cells(&format!("{place}/blocks/{name}"), block, all);
    }
}

fn mutants(file: &Value) -> Vec<Mutant> {
    let mut all = Vec::new();
    let mut file = file.clone();
    file.sort_all_objects();
    for (name, module) in file["modules"].as_object().unwrap() {
        of_cells(&format!("/modules/{name}"), module, &mut all);
    }
    all
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let to = to.join(path.file_name().unwrap());
        if path.is_dir() { copy(&path, &to) } else { assert!(std::fs::copy(&path, &to).is_ok()) }
    }
}

/// The scenarios of the golden traces of a circuit.
fn scenarios(root: &Path, circuit: &str) -> Vec<PathBuf> {
    let (group, _) = circuit.split_once('/').unwrap();
    let mut all = Vec::new();
    for entry in std::fs::read_dir(root.join("traces").join(group)).unwrap() {
        let path = entry.unwrap().path();
        let is_scenario = path.extension().is_some_and(|e| e == "json");
        if is_scenario && std::fs::read_to_string(&path).unwrap().contains(&format!("circuits/{circuit}\"")) {
            all.push(path);
        }
    }
    all
}

/// What noticed a mutant.
#[derive(Clone, Copy, Default, Debug)]
struct Count {
    mutants: usize,
    proof: usize,
    golden: usize,
}

/// Mutates a file: a circuit, which has a proof for each choice of its parameters, or what several circuits use. What
/// noticed, and the names of those that nothing did.
fn hunt(mutated: &str, proofs: &[&Proof], survivors: &mut Vec<(String, String)>) -> Count {
    let root = folder("mutation").join(mutated.replace('/', "_"));
    for part in ["circuits", "traces"] {
        copy(&repository(part), &root.join(part));
    }
    let path = root.join("circuits").join(mutated);
    let load = |proof: &Proof| load_with(root.join("circuits").join(proof.path), proof.parameters);
    let text = std::fs::read_to_string(&path).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let mut all = mutants(&file);
    Rng::named(mutated).shuffle(&mut all);
    for proof in proofs {
        let right = load(proof).unwrap_or_else(|e| panic!("{e}"));
        proof.run(&right).unwrap_or_else(|fault| panic!("{}: {fault}", proof.path));
    }
    let mut circuits: Vec<_> = proofs.iter().map(|proof| proof.path).collect();
    circuits.dedup();
    let scenarios: Vec<_> = circuits.iter().flat_map(|circuit| scenarios(&root, circuit)).collect();
    let mut count = Count::default();
    for mutant in all {
        if count.mutants == EACH {
            break;
        }
        let mut changed = file.clone();
        for (place, value) in &mutant.changes {
            *changed.pointer_mut(place).unwrap() = value.clone();
        }
        std::fs::write(&path, serde_json::to_string(&changed).unwrap()).unwrap();
        let loaded: Result<Vec<_>, _> = proofs.iter().map(|proof| load(proof)).collect();
        let Ok(loaded) = loaded else { continue };
        count.mutants += 1;
        let by_proof = proofs.iter().zip(&loaded).any(|(proof, circuit)| proof.run(circuit).is_err());
        let by_golden = !scenarios.is_empty() && {
            let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
            !command.arg("test").args(&scenarios).output().unwrap().status.success()
        };
        count.proof += usize::from(by_proof);
        count.golden += usize::from(by_golden);
        if !by_proof {
            survivors.push((mutated.to_owned(), mutant.name));
        }
    }
    std::fs::write(&path, text).unwrap();
    count
}

/// Hunts every n-th circuit, for the threads of the test runner.
fn part(n: usize, of: usize) -> BTreeMap<&'static str, Count> {
    let mut survivors = Vec::new();
    let mut counts = BTreeMap::new();
    let mut files: BTreeMap<&str, Vec<&Proof>> = BTreeMap::new();
    for proof in PROOFS {
        files.entry(proof.path).or_default().push(proof);
        for (file, _) in LIBRARIES.iter().filter(|(_, users)| users.contains(&proof.path)) {
            files.entry(file).or_default().push(proof);
        }
    }
    for (file, proofs) in files.into_iter().skip(n).step_by(of) {
        let count = hunt(file, &proofs, &mut survivors);
        println!(
            "{file}: {} mutants, {} caught by the proof, {} by the golden traces",
            count.mutants, count.proof, count.golden
        );
        counts.insert(file, count);
    }
    let explained =
        |(circuit, mutant): &(String, String)| SURVIVORS.iter().any(|(c, m, _)| c == circuit && m == mutant);
    let unexplained: Vec<_> = survivors.iter().filter(|s| !explained(s)).collect();
    assert!(unexplained.is_empty(), "no proof notices these:\n{unexplained:#?}");
    counts
}

#[test]
fn mutants_of_the_first_half() {
    part(0, 2);
}

#[test]
fn mutants_of_the_second_half() {
    part(1, 2);
}
