//! No result depends on the order in which a circuit is written: the same circuit with its cells, nets, ports and modules
//! shuffled gives the same values at every instant, and the same error where it never settles.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::support::design::{CLOCKS, Design};
use crate::support::engines::{self, Sim, simulator};
use crate::support::{Rng, folder, repository};
use discreta::circuit::load_with;
use discreta::netlist::Netlist;
use discreta::{Logic, Probe, SimulatorError, Value};

/// All that can be seen of a circuit, by name.
struct Watch {
    sim: Sim,
    names: Vec<String>,
    probes: Vec<Probe>,
}

impl Watch {
    fn new(netlist: &Netlist) -> Watch {
        let mut names: Vec<String> = netlist.signal_ids().map(|s| netlist.signal_path(s)).collect();
        names.sort();
        let sim = simulator(netlist);
        let probes = names.iter().map(|n| sim.probe(n).unwrap()).collect();
        Watch { sim, names, probes }
    }

    /// Sets inputs and settles, or runs on.
    fn step(&mut self, step: &Step) -> Result<(), SimulatorError> {
        match step {
            Step::Set(values) => {
                for (name, value) in values {
                    let input = self.sim.input(name).unwrap();
                    self.sim.set_value(input, value);
                }
                self.sim.settle()
            }
            Step::RunTo(time) => self.sim.run_to(*time),
        }
    }

    fn values(&self) -> Vec<(&str, Value)> {
        self.names.iter().zip(&self.probes).map(|(n, p)| (n.as_str(), self.sim.value(p))).collect()
    }
}

#[derive(Debug)]
enum Step {
    Set(Vec<(String, Value)>),
    RunTo(u64),
}

/// Runs two forms of a circuit side by side. Returns the steps made, and the error that both ended with.
fn same(label: &str, a: &Netlist, b: &Netlist, steps: &[Step]) -> (usize, Option<SimulatorError>) {
    let (mut a, mut b) = (Watch::new(a), Watch::new(b));
    assert_eq!(a.names, b.names, "{label}");
    for (n, step) in steps.iter().enumerate() {
        let (first, second) = (a.step(step), b.step(step));
        assert_eq!(first, second, "{label}, step {n}: {step:?}");
        if let Err(e) = first {
            return (n, Some(e));
        }
        assert_eq!(a.values(), b.values(), "{label}, step {n}: {step:?}");
        let events = (a.sim.events(), b.sim.events());
        assert!(events.0.abs_diff(events.1) <= events.0 / 2 + 100, "{label}: {events:?} events");
    }
    (steps.len(), None)
}

// ---- shuffled files

/// A JSON text with the members of each object in random order, but for parameters, which may use those before them.
fn shuffled(value: &serde_json::Value, rng: &mut Rng, keep: bool) -> String {
    match value {
        serde_json::Value::Object(map) => {
            let mut members: Vec<_> = map.iter().collect();
            if !keep {
                rng.shuffle(&mut members);
            }
            let mut text = String::new();
            for (i, (key, value)) in members.into_iter().enumerate() {
                let comma = if i > 0 { "," } else { "" };
                let value = shuffled(value, rng, key == "parameters");
                write!(text, "{comma}\n{}: {value}", serde_json::Value::from(key.as_str())).unwrap();
            }
            format!("{{{text}}}")
        }
        serde_json::Value::Array(list) => {
            let members: Vec<String> = list.iter().map(|v| shuffled(v, rng, false)).collect();
            format!("[{}]", members.join(", "))
        }
        other => other.to_string(),
    }
}

/// A copy of the circuits with every file shuffled.
fn shuffled_circuits(seed: u64) -> PathBuf {
    let mut rng = Rng::new(seed);
    let root = folder(&format!("shuffled_{seed}"));
    for path in ["lib/arithmetic", "lib/multiplexers", "lib/storage", "evaluation/line", "evaluation/line_gates"] {
        let text = std::fs::read_to_string(repository(&format!("circuits/{path}.json"))).unwrap();
        let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
        if let Some(imports) = file.get_mut("import").and_then(|i| i.as_array_mut()) {
            rng.shuffle(imports);
        }
        let to = root.join(format!("{path}.json"));
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::write(to, shuffled(&file, &mut rng, false)).unwrap();
    }
    root
}

/// Lines begun, left and begun again, with some inputs unknown at times.
fn line_steps(rng: &mut Rng, steps: usize) -> Vec<Step> {
    let set = |name: &str, value: Value| (name.to_string(), value);
    let mut list = Vec::new();
    let mut dt = 0;
    for n in 0..steps {
        dt ^= 1;
        let mut values = vec![set("dt", Value::from_u64(dt, 1))];
        if n == 0 || rng.one_in(40) {
            let unknown = if rng.one_in(6) { 8 } else { u64::MAX };
            values.extend(["dx", "dy", "xh", "yh"].map(|i| set(i, rng.four_valued(4, unknown))));
            values.push(set("start", Value::from_u64(1, 1)));
        } else {
            values.push(set("start", Value::from_u64(u64::from(rng.one_in(60)), 1)));
        }
        list.push(Step::Set(values));
    }
    list
}

#[test]
fn the_line_interpolators_do_not_depend_on_the_order_of_their_files() {
    for file in ["evaluation/line.json", "evaluation/line_gates.json"] {
        let load = |path: PathBuf| load_with(path, &[("W", 4)]).unwrap_or_else(|e| panic!("{e}"));
        let original = load(repository("circuits").join(file));
        let (mut instants, mut errors) = (0, 0);
        for seed in 0..12 {
            let other = load(shuffled_circuits(seed).join(file));
            let steps = line_steps(&mut Rng::new(seed), 600);
            let (n, error) = same(&format!("{file}, seed {seed}"), &original.netlist, &other.netlist, &steps);
            (instants, errors) = (instants + n, errors + usize::from(error.is_some()));
        }
        println!("{file}: 12 orders, {instants} instants, {errors} ended unsettled");
    }
    engines::all_ran();
}

// ---- random netlists

/// Inputs set at random, and time that passes.
fn random_steps(design: &Design, rng: &mut Rng, count: u64) -> Vec<Step> {
    let mut steps = Vec::new();
    let unknown = *rng.pick(&[u64::MAX, u64::MAX, 20, 6]);
    for n in 0..count {
        let mut values = Vec::new();
        for (i, (name, width)) in design.signals[..design.inputs].iter().enumerate() {
            let rest = ["s", "r"].contains(&name.as_str()) && !rng.one_in(4);
            if n == 0 || rest {
                values.push((name.clone(), Value::repeat(Logic::Zero, *width)));
            } else if rng.one_in(2) {
                values.push((
                    name.clone(),
                    rng.four_valued(*width, if CLOCKS.contains(&i) { u64::MAX } else { unknown }),
                ));
            }
        }
        steps.push(Step::Set(values));
        if rng.one_in(2) {
            steps.push(Step::RunTo(n * 3));
        }
    }
    steps
}

#[test]
fn random_netlists_do_not_depend_on_the_order_of_their_cells() {
    let (mut instants, mut settled, mut unsettled) = (0, 0, 0);
    for seed in 0..800 {
        let mut rng = Rng::new(seed);
        let design = Design::new(&mut rng);
        let steps = random_steps(&design, &mut rng, 40);
        let first = design.build(&mut rng);
        for order in 0..2 {
            let second = design.build(&mut rng);
            let (n, error) = same(&format!("seed {seed}, order {order}"), &first, &second, &steps);
            instants += n;
            match error {
                None => settled += 1,
                Some(_) => unsettled += 1,
            }
        }
    }
    println!("{instants} instants; {settled} runs settled, {unsettled} did not");
    assert!(settled > 400 && unsettled > 100, "{settled} settled, {unsettled} did not");
    engines::ran(100, 100);
}
