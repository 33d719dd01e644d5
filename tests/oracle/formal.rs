//! Gates against words, proven by Yosys for every input and every sequence of inputs, through the export to it.
//!
//! Both forms stand in one circuit and read the same inputs. A SAT solver shows that their outputs cannot differ;
//! where there are flip-flops, by induction over time: `clk2fflogic` makes of every flip-flop, its clock and its
//! asynchronous controls logic between steps of time, so that nothing is assumed about clocks. State begins at 0.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::support::pairs::*;
use crate::support::{folder, load, repository};
use discreta::circuit::Circuit;
use discreta::export::verilog;
use discreta::export::yosys::{Extra, write};
use needs::needs;
use serde_json::{Value as Json, json};

/// Two forms in one circuit, and the names of what has to be the same.
struct Claim {
    name: String,
    circuit: Circuit,
    same: Vec<(String, String)>,
    /// Whether what holds a state takes a step of time.
    late: bool,
    /// The cell of `tests/formal_words.v` that stands beside the gates, if it does.
    words: Option<Json>,
}

impl Claim {
    fn of(pair: &Pair) -> Claim {
        let same = pair.outputs.iter().map(|(n, _)| (format!("gates_{n}"), format!("element_{n}"))).collect();
        let settings = pair.parameters.as_object().unwrap().iter().map(|(name, value)| format!(" {name}={value}"));
        let name = format!("{}{}", pair.module, settings.collect::<String>());
        Claim { name, circuit: pair.circuit(), same, late: false, words: None }
    }

    /// A module of the library beside what `tests/formal_words.v` says of it.
    fn words(file: &str, module: &str, parameters: Json) -> Claim {
        let library = repository(&format!("circuits/lib/{file}.json"));
        let text: Json = serde_json::from_str(&std::fs::read_to_string(&library).unwrap()).unwrap();
        let mut pair = json!({ "ports": text["modules"][module]["ports"], "cells": {
            "gates": { "type": module, "parameters": {}, "connections": {} } } });
        let ports = pair["ports"].as_object().unwrap().clone();
        let connections: serde_json::Map<_, _> = ports.keys().map(|n| (n.clone(), json!(n))).collect();
        pair["cells"]["gates"]["connections"] = connections.into();
        let own = parameters.as_object().unwrap().iter();
        pair["parameters"] = own.map(|(n, value)| (n.clone(), json!({ "default": value }))).collect::<Json>();
        let own = parameters.as_object().unwrap().keys();
        pair["cells"]["gates"]["parameters"] = own.map(|n| (n.clone(), json!(n))).collect::<Json>();
        let name = format!("{module} {parameters}");
        let path = folder("formal").join(format!("words_{name}.json").replace(['"', ':', ',', '{', '}', ' '], "_"));
        let file = json!({ "import": [library], "top": "pair", "modules": { "pair": pair } });
        std::fs::write(&path, file.to_string()).unwrap();
        let circuit = discreta::circuit::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let (mut ways, mut bits, mut same) = (serde_json::Map::new(), serde_json::Map::new(), Vec::new());
        for (port, spec) in &ports {
            ways.insert(port.clone(), spec["direction"].clone());
            bits.insert(port.clone(), json!(port));
            if spec["direction"] == "output" {
                same.push((port.clone(), format!("words_{port}")));
            }
        }
        if ASKED.contains(&module) {
            ways.insert("asked".to_owned(), json!("output"));
        }
        let settings = circuit.parameters.iter().map(|(n, v)| (n.clone(), json!(format!("{v:032b}"))));
        let settings: serde_json::Map<_, _> = settings.collect();
        let words = json!({ "type": format!("{module}_words"), "parameters": settings, "attributes": {},
            "port_directions": ways, "connections": bits });
        Claim { name, circuit, same, late: false, words: Some(words) }
    }

    /// Puts the cell of words into a netlist.
    fn add_words(&self, file: &mut Json) {
        let Some(words) = &self.words else { return };
        let pair = &mut file["modules"]["pair"];
        let (mut words, mut next) = (words.clone(), 2_000_000);
        for (port, way) in words["port_directions"].as_object().unwrap().clone() {
            let mut bits = pair["ports"][&port]["bits"].clone();
            if way == "output" {
                let width = bits.as_array().map_or(1, Vec::len);
                bits = json!((next..next + width).collect::<Vec<_>>());
                next += width;
                pair["ports"][format!("words_{port}")] = json!({ "direction": "output", "bits": bits });
            }
            words["connections"][&port] = bits;
        }
        pair["cells"]["words"] = words;
    }

    /// A circuit of words and its form of gates: all nets that both have are the same.
    fn circuits(path: &str, parameters: Json) -> Claim {
        let files = [path.to_owned(), format!("{path}_gates")].map(|f| repository(&format!("circuits/{f}.json")));
        let [words, gates] = files.each_ref().map(|file| {
            let file: Json = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
            file["top"].as_str().unwrap().to_owned()
        });
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
        Claim { name: format!("{path} {parameters}"), circuit, same, late: true, words: None }
    }
}

fn settings(parameters: &Json) -> Vec<(&str, i64)> {
    parameters.as_object().unwrap().iter().map(|(name, value)| (name.as_str(), value.as_i64().unwrap())).collect()
}

/// Modules of which something is asked only where their words say so.
const ASKED: [&str; 2] = ["quadrant_of", "arc_end"];

static FILES: AtomicUsize = AtomicUsize::new(0);

/// Whether Yosys proves it; `change` may change the netlist before.
fn proves(claim: &Claim, change: impl FnOnce(&mut Json)) -> bool {
    let folder = folder("formal");
    let text = write(&claim.circuit.netlist, &Extra::default());
    let mut file: Json = serde_json::from_str(&text).unwrap();
    hold_state(&mut file);
    if claim.late {
        take_time(&mut file);
    }
    claim.add_words(&mut file);
    change(&mut file);
    let path = format!("claim_{}.json", FILES.fetch_add(1, Ordering::Relaxed));
    std::fs::write(folder.join(&path), serde_json::to_string(&file).unwrap()).unwrap();
    let words = repository("tests/formal_words.v");
    let words =
        if claim.words.is_some() { format!("read_verilog -defer {}; ", words.display()) } else { String::new() };
    yosys(&folder, claim, &format!("{words}read_json {path}"))
}

/// Whether Yosys proves it of our Verilog.
fn proves_of_verilog(claim: &Claim) -> bool {
    let folder = folder("formal");
    let path = format!("claim_{}.v", FILES.fetch_add(1, Ordering::Relaxed));
    std::fs::write(folder.join(&path), verilog::Design::of(&claim.circuit.netlist).text()).unwrap();
    yosys(&folder, claim, &format!("read_verilog {path}"))
}

/// Whether a proof succeeds of the design that is read so; it is an error if Yosys fails otherwise.
fn yosys(folder: &Path, claim: &Claim, read: &str) -> bool {
    let name = &claim.name;
    let state = claim.circuit.netlist.cells().iter().any(|c| c.kind.init().is_some())
        || claim.circuit.netlist.scopes().iter().any(|s| s.module.as_deref() == Some("sr_nor"));
    let steps = if state { "clk2fflogic; opt_clean; " } else { "" };
    let induct = if state { "-tempinduct -set-init-zero" } else { "" };
    let asked = claim.words.as_ref().is_some_and(|w| w["port_directions"].get("asked").is_some());
    let asked = if asked { "-set words_asked 1" } else { "" };
    let same: Vec<String> = claim.same.iter().map(|(a, b)| format!("-prove {a} {b}")).collect();
    let script = format!(
        "{read}; hierarchy -check -top pair; proc -noopt; flatten; opt_clean; {steps}sat -verify -timeout 60 {asked} {induct} {}",
        same.join(" ")
    );
    let told = Command::new("yosys").current_dir(folder).args(["-Q", "-T", "-p", &script]).output();
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
/// `tests/proofs/gate_modules.rs` shows it to be in every sequence; while both inputs are 1 both of its outputs are 0.
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

/// Circuits have circles that only time breaks: a trigger stops the clock of the counter that resets it, a counter that
/// has become 0 makes the pulse that another counts. Here whatever holds a state takes a step of time to show it.
fn take_time(file: &mut Json) {
    for module in file["modules"].as_object_mut().unwrap().values_mut() {
        let Some(cells) = module["cells"].as_object_mut() else { continue };
        let (mut late, mut next) = (Vec::new(), 1_000_000);
        for (name, state) in cells.iter_mut().filter(|(_, c)| HOLD.contains(&c["type"].as_str().unwrap())) {
            let width = state["connections"]["Q"].as_array().unwrap().len();
            let bits = json!((next..next + width).collect::<Vec<_>>());
            next += width;
            let q = std::mem::replace(&mut state["connections"]["Q"], bits.clone());
            let pins = [("D", "input", bits), ("Q", "output", q)];
            late.push((format!("{name}$late"), cell("$ff", json!({ "WIDTH": format!("{width:032b}") }), &pins)));
        }
        cells.extend(late);
    }
}

const HOLD: &[&str] = &[
    "$sr",
    "$dlatch",
    "$adlatch",
    "$dlatchsr",
    "$dff",
    "$dffe",
    "$adff",
    "$adffe",
    "$sdff",
    "$sdffe",
    "$aldff",
    "$aldffe",
    "$dffsr",
    "$dffsre",
];

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

fn combinational() -> Vec<Pair> {
    let mut pairs = vec![half_adder(), full_adder()];
    for w in [1, 8, 32] {
        pairs.extend([adder(w), subtractor(w), negate(w), decrement(w), zero_detect(w), bus_mux(w)]);
    }
    pairs.extend([(1, 1), (3, 4), (5, 5)].map(|(a, b)| multiplier(a, b)));
    pairs.extend([(1, 2), (4, 3), (4, 4)].map(|(a, b)| signed_multiplier(a, b)));
    pairs
}

fn sequential() -> Vec<Pair> {
    let mut pairs = vec![sr_held(), latch(4)];
    for falling in [0, 1] {
        pairs.extend([dff(falling), register(8, falling), accumulator(8, falling)]);
        pairs.extend([counter(8, 0, falling), counter(8, 1, falling)]);
    }
    pairs.push(summator(8));
    pairs
}

/// File and module of those that no element does the same as, and the parameters that they are proven with.
fn in_words() -> Vec<(&'static str, &'static str, Vec<Json>)> {
    let widths = |list: &[u32]| list.iter().map(|w| json!({ "W": w })).collect::<Vec<_>>();
    vec![
        ("normalise", "normalise", widths(&[2, 3, 6, 8, 16])),
        (
            "normalise",
            "shift_left",
            [(2, 1), (6, 3), (8, 2), (8, 3), (16, 4)].map(|(w, s)| json!({ "W": w, "S": s })).into(),
        ),
        ("increments", "uu", vec![json!({})]),
        ("quadrant", "magnitude", widths(&[1, 8, 16])),
        ("quadrant", "exchange", widths(&[1, 8, 16])),
        ("quadrant", "line_axis", widths(&[1, 8])),
        ("quadrant", "quadrant_of", widths(&[1, 8])),
        ("quadrant", "arc_end", widths(&[1, 8])),
        ("quadrant", "crossings", widths(&[1, 8])),
    ]
}

/// Modules of the library that are not proven to be words, and why.
const NOT_PROVEN: &[(&str, &str)] =
    &[("quadrants", "what it does shows in whole arcs only, with a core around which it stands: tests/quadrant.rs")];

#[test]
fn every_module_of_the_library_is_proven_or_says_why_not() {
    let mut modules = Vec::new();
    for file in std::fs::read_dir(repository("circuits/lib")).unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        let file: Json = serde_json::from_str(&text).unwrap();
        modules.extend(file["modules"].as_object().unwrap().keys().cloned());
    }
    let pairs = combinational().into_iter().chain(sequential()).map(|p| p.module);
    let mut named: Vec<&str> = pairs.chain(in_words().iter().map(|w| w.1)).collect();
    named.sort_unstable();
    named.dedup();
    named.extend(NOT_PROVEN.iter().map(|n| n.0));
    named.sort_unstable();
    modules.sort_unstable();
    assert_eq!(modules, named, "a module of the library, and what is proven or has a reason not to be");
}

#[needs(yosys)]
#[test]
fn combinational_modules_are_their_elements() {
    prove(&combinational().iter().map(Claim::of).collect::<Vec<_>>());
}

#[needs(yosys)]
#[test]
fn sequential_modules_are_their_elements() {
    prove(&sequential().iter().map(Claim::of).collect::<Vec<_>>());
}

/// What no element does is said in words of Verilog.
#[needs(yosys)]
#[test]
fn modules_are_what_words_say() {
    let all = in_words();
    let claims = all.iter().flat_map(|(file, module, list)| list.iter().map(|p| Claim::words(file, module, p.clone())));
    prove(&claims.collect::<Vec<_>>());
}

/// The other way to Yosys gives the same proofs.
#[needs(yosys)]
#[test]
fn combinational_modules_are_their_elements_in_our_verilog() {
    let pairs = combinational();
    for claim in pairs.iter().map(Claim::of) {
        assert!(proves_of_verilog(&claim), "{} is refuted", claim.name);
    }
    println!("{} proofs", pairs.len());
    // the sum of one is not the carry of the other
    let crossed = Claim { same: vec![("gates_s".into(), "element_co".into())], ..Claim::of(&full_adder()) };
    assert!(!proves_of_verilog(&crossed));
}

/// Its `qn` is another one while both inputs are 1.
fn sr_held() -> Pair {
    Pair { outputs: vec![("q", 1)], ..sr() }
}

/// Their inputs may do what they like: no order of clock and start is assumed.
#[needs(yosys)]
#[test]
fn circuits_of_gates_are_those_of_words() {
    let claims: Vec<Claim> = CIRCUITS
        .iter()
        .map(|(path, parameters)| Claim::circuits(path, serde_json::from_str(parameters).unwrap()))
        .collect();
    prove(&claims);
}

const CIRCUITS: &[(&str, &str)] = &[
    ("evaluation/line", r#"{ "W": 8, "CENTRED": 0 }"#),
    ("evaluation/line", r#"{ "W": 4, "CENTRED": 1 }"#),
    ("evaluation/fast_line", r#"{ "W": 4 }"#),
    ("evaluation/circle", r#"{ "W": 4, "CLOCKWISE": 0 }"#),
    ("evaluation/circle", r#"{ "W": 4, "CLOCKWISE": 1 }"#),
    ("evaluation/karibsky", r#"{ "W": 4 }"#),
    ("evaluation/fast_circle", r#"{ "W": 4 }"#),
    ("dda/line", r#"{ "W": 4 }"#),
    ("dda/circle", r#"{ "W": 4 }"#),
];

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
    for (file, module, wrong, parameters) in [
        ("normalise", "normalise", "normalise", json!({ "W": 8 })),
        ("normalise", "shift_left", "bus_mux", json!({ "W": 8, "S": 3 })),
        ("increments", "uu", "uu", json!({})),
        ("quadrant", "quadrant_of", "quadrant_of", json!({ "W": 8 })),
        ("quadrant", "arc_end", "arc_end", json!({ "W": 8 })),
        ("quadrant", "crossings", "crossings", json!({ "W": 8 })),
    ] {
        let claim = Claim::words(file, module, parameters);
        // the lowest bits of the numbers, in the first gate of `normalise`, change nothing: 1 takes as many shifts as 0
        let nth = usize::from(module == "normalise");
        assert!(!proves(&claim, |file| mutate(file, wrong, nth)), "{module}: a wrong gate is not found");
        refuted += 1;
    }
    println!("{refuted} of {refuted} wrong modules refuted");
}
