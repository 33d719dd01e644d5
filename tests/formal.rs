//! Gates against words, proven by Yosys for every input and every sequence of inputs, through the export to it.
//!
//! Both forms stand in one circuit and read the same inputs. A SAT solver shows that their outputs cannot differ;
//! where there are flip-flops, by induction over time: `clk2fflogic` makes of every flip-flop, its clock and its
//! asynchronous controls logic between steps of time, so that nothing is assumed about clocks. State begins at 0.

mod support;

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use discreta::circuit::Circuit;
use discreta::exchange::yosys::{Extra, write};
use needs::needs;
use serde_json::{Value as Json, json};
use support::pairs::*;
use support::{folder, load, repository};

/// Two forms in one circuit, and the names of what has to be the same.
struct Claim {
    name: String,
    circuit: Circuit,
    same: Vec<(String, String)>,
    /// Whether SR flip-flops take a step of time.
    late: bool,
}

impl Claim {
    fn of(pair: &Pair) -> Claim {
        let same = pair.outputs.iter().map(|(n, _)| (format!("gates_{n}"), format!("element_{n}"))).collect();
        let settings = pair.parameters.as_object().unwrap().iter().map(|(name, value)| format!(" {name}={value}"));
        let name = format!("{}{}", pair.module, settings.collect::<String>());
        Claim { name, circuit: pair.circuit(), same, late: false }
    }

    /// A circuit of words and its form of gates: all nets that both have are the same.
    fn circuits(path: &str, words: &str, gates: &str, parameters: Json) -> Claim {
        let files = [path.to_owned(), format!("{path}_gates")].map(|f| repository(&format!("circuits/{f}.json")));
        let alone = discreta::circuit::load_with(&files[0], &settings(&parameters)).unwrap_or_else(|e| panic!("{e}"));
        let mut ports = serde_json::Map::new();
        let mut cells = [serde_json::Map::new(), serde_json::Map::new()];
        for id in alone.netlist.ports() {
            let signal = alone.netlist.signal(id);
            let input = signal.port == Some(discreta::netlist::Direction::Input);
            for (cell, of) in cells.iter_mut().zip(["words_", "gates_"]) {
                let name = if input { signal.name.clone() } else { format!("{of}{}", signal.name) };
                let way = if input { "input" } else { "output" };
                ports.insert(name.clone(), json!({ "direction": way, "width": signal.width }));
                cell.insert(signal.name.clone(), json!(name));
            }
        }
        let [w, g] = cells;
        let file = json!({ "import": files, "modules": { "pair": { "ports": ports, "cells": {
            "words": { "type": words, "parameters": parameters, "connections": w },
            "gates": { "type": gates, "parameters": parameters, "connections": g } } } } });
        let name = format!("{path}{parameters}").replace(|c: char| !c.is_alphanumeric(), "_");
        let circuit = load(&folder("formal"), &name, &file).unwrap_or_else(|e| panic!("{path}: {e}"));
        let netlist = &circuit.netlist;
        let nets = netlist.signal_ids().map(|id| (netlist.signal_path(id), netlist.signal(id).width));
        let nets: std::collections::BTreeMap<String, u32> = nets.collect();
        let inner = nets.iter().filter_map(|(name, width)| {
            let other = format!("gates.{}", name.strip_prefix("words.")?);
            (!name.trim_start_matches("words.").contains('.') && nets.get(&other) == Some(width))
                .then(|| (name.clone(), other))
        });
        let same = inner.collect();
        Claim { name: format!("{path} {parameters}"), circuit, same, late: true }
    }
}

fn settings(parameters: &Json) -> Vec<(&str, i64)> {
    parameters.as_object().unwrap().iter().map(|(name, value)| (name.as_str(), value.as_i64().unwrap())).collect()
}

/// Whether Yosys proves it; `change` may change the netlist before.
fn proves(claim: &Claim, change: impl FnOnce(&mut Json)) -> bool {
    static FILES: AtomicUsize = AtomicUsize::new(0);
    let folder = folder("formal");
    let text = write(&claim.circuit.netlist, &Extra::default());
    let mut file: Json = serde_json::from_str(&text).unwrap();
    hold_state(&mut file);
    if claim.late {
        take_time(&mut file);
    }
    change(&mut file);
    let path = format!("claim_{}.json", FILES.fetch_add(1, Ordering::Relaxed));
    std::fs::write(folder.join(&path), serde_json::to_string(&file).unwrap()).unwrap();
    let state = claim.circuit.netlist.cells().iter().any(|c| c.kind.init().is_some());
    let steps = if state { "clk2fflogic; opt_clean; " } else { "" };
    let induct = if state { "-tempinduct -set-init-zero" } else { "" };
    let same: Vec<String> = claim.same.iter().map(|(a, b)| format!("-prove {a} {b}")).collect();
    let script = format!(
        "read_json {path}; hierarchy -check -top pair; flatten; opt_clean; {steps}sat -verify -timeout 60 {induct} {}",
        same.join(" ")
    );
    yosys(&folder, &claim.name, &script)
}

/// Whether a proof succeeds; it is an error if Yosys fails otherwise.
fn yosys(folder: &Path, name: &str, script: &str) -> bool {
    let told = Command::new("yosys").current_dir(folder).args(["-Q", "-T", "-p", script]).output();
    let told = told.unwrap_or_else(|e| panic!("yosys: {e}; install it"));
    let (out, err) = (String::from_utf8_lossy(&told.stdout), String::from_utf8_lossy(&told.stderr));
    let proven = out.contains("Induction step proven: SUCCESS!") || out.contains("no model found: SUCCESS!");
    let refuted = out.contains("proof did fail") || err.contains("proof did fail");
    assert!(proven != refuted && proven == told.status.success(), "{name}: {script}\n{out}\n{err}");
    proven
}

fn pins(list: &[(&str, &str, Json)]) -> (Json, Json) {
    let ways = list.iter().map(|(name, way, _)| ((*name).to_owned(), json!(way)));
    let bits = list.iter().map(|(name, _, bits)| ((*name).to_owned(), bits.clone()));
    (ways.collect::<serde_json::Map<_, _>>().into(), bits.collect::<serde_json::Map<_, _>>().into())
}

fn cell(kind: &str, parameters: Json, list: &[(&str, &str, Json)]) -> Json {
    let (ways, bits) = pins(list);
    json!({ "hide_name": 0, "type": kind, "attributes": {}, "parameters": parameters,
        "port_directions": ways, "connections": bits })
}

const ONE: &str = "00000000000000000000000000000001";

/// Gates that hold a state in a circle have no meaning to a SAT solver. The flip-flop of NOR gates is the SR element that
/// `tests/gate_modules.rs` shows it to be in every sequence; while both inputs are 1 both of its outputs are 0.
fn hold_state(file: &mut Json) {
    let modules = file["modules"].as_object_mut().unwrap();
    let Some(module) = modules.get_mut("sr_nor") else { return };
    let port = |name: &str| module["ports"][name]["bits"].clone();
    let (s, r, q, qn) = (port("s"), port("r"), port("q"), port("qn"));
    let one_bit = json!({ "WIDTH": ONE, "SET_POLARITY": "1", "CLR_POLARITY": "1" });
    let state = cell("$sr", one_bit, &[("SET", "input", s.clone()), ("CLR", "input", r), ("Q", "output", q.clone())]);
    let nor = cell("$_NOR_", json!({}), &[("A", "input", s), ("B", "input", q), ("Y", "output", qn)]);
    module["cells"] = json!({ "state": state, "nor2": nor });
}

/// A trigger stops the clock of the counter that resets it: a circle, in which a step of time has to pass somewhere. Here
/// each SR flip-flop takes one.
fn take_time(file: &mut Json) {
    for module in file["modules"].as_object_mut().unwrap().values_mut() {
        let Some(cells) = module["cells"].as_object_mut() else { continue };
        let mut late = Vec::new();
        for (i, (name, sr)) in cells.iter_mut().filter(|(_, c)| c["type"] == "$sr").enumerate() {
            let bit = json!([1_000_000 + i]);
            let q = std::mem::replace(&mut sr["connections"]["Q"], bit.clone());
            late.push((
                format!("{name}$late"),
                cell("$ff", json!({ "WIDTH": ONE }), &[("D", "input", bit), ("Q", "output", q)]),
            ));
        }
        cells.extend(late);
    }
}

/// A gate of another kind in place of one of the gate form's.
fn mutate(file: &mut Json, module: &str, nth: usize) {
    let others = [("$and", "$or"), ("$or", "$and"), ("$xor", "$xnor"), ("$logic_not", "$reduce_or")];
    let cells = file["modules"][module]["cells"].as_object_mut().unwrap();
    let kinds = cells.values_mut().filter_map(|cell| {
        let kind = cell["type"].as_str()?;
        let (_, to) = others.into_iter().find(|o| o.0 == kind)?;
        Some((cell, to))
    });
    let (cell, to) = kinds.collect::<Vec<_>>().into_iter().nth(nth).unwrap();
    cell["type"] = json!(to);
}

/// Proves claims and says how large they are.
fn prove(claims: &[Claim]) {
    let mut cells = 0;
    for claim in claims {
        let start = Instant::now();
        assert!(proves(claim, |_| ()), "{} is refuted", claim.name);
        let n = claim.circuit.netlist.cells().len();
        cells += n;
        println!("{}: proven, {n} cells, {:.1} s", claim.name, start.elapsed().as_secs_f64());
    }
    println!("{} proofs, {cells} cells", claims.len());
}

#[needs(yosys)]
#[test]
fn combinational_modules_are_their_elements() {
    let mut pairs = vec![half_adder(), full_adder()];
    for w in [1, 8, 32] {
        pairs.extend([adder(w), subtractor(w), negate(w), decrement(w), zero_detect(w), bus_mux(w)]);
    }
    pairs.extend([(1, 1), (3, 4), (5, 5)].map(|(a, b)| multiplier(a, b)));
    pairs.extend([(1, 2), (4, 3), (4, 4)].map(|(a, b)| signed_multiplier(a, b)));
    prove(&pairs.iter().map(Claim::of).collect::<Vec<_>>());
}

#[needs(yosys)]
#[test]
fn sequential_modules_are_their_elements() {
    let mut pairs = vec![sr_held(), latch(4)];
    for falling in [0, 1] {
        pairs.extend([dff(falling), register(8, falling), accumulator(8, falling)]);
        pairs.extend([counter(8, 0, falling), counter(8, 1, falling)]);
    }
    pairs.push(summator(8));
    prove(&pairs.iter().map(Claim::of).collect::<Vec<_>>());
}

/// Its `qn` is another one while both inputs are 1.
fn sr_held() -> Pair {
    Pair { outputs: vec![("q", 1)], ..sr() }
}

/// Their inputs may do what they like: no order of clock and start is assumed.
#[needs(yosys)]
#[test]
fn circuits_of_gates_are_those_of_words() {
    let claims = [
        Claim::circuits("evaluation/line", "line", "line_gates", json!({ "W": 4 })),
        Claim::circuits("evaluation/line", "line", "line_gates", json!({ "W": 8 })),
        Claim::circuits("evaluation/fast_line", "fast_line", "fast_line_gates", json!({ "W": 4 })),
    ];
    prove(&claims);
}

/// What is not the same is refuted: a gate is exchanged in each module.
#[needs(yosys)]
#[test]
fn wrong_gates_are_refuted() {
    let mut refuted = 0;
    for (pair, module) in [
        (half_adder(), "half_adder_gates"),
        (full_adder(), "full_adder_gates"),
        (adder(8), "full_adder_gates"),
        (bus_mux(8), "bus_mux"),
        (register(8, 0), "register_gates"),
        (counter(8, 1, 1), "counter_gates"),
        (accumulator(8, 0), "full_adder_gates"),
    ] {
        let claim = Claim::of(&pair);
        assert!(!proves(&claim, |file| mutate(file, module, 0)), "{module}: a wrong gate is not found");
        refuted += 1;
    }
    println!("{refuted} of {refuted} wrong modules refuted");
}
