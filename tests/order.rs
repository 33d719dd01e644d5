//! No result depends on the order in which a circuit is written: the same circuit with its cells, nets, ports and modules
//! shuffled gives the same values at every instant, and the same error where it never settles.

mod support;

use std::fmt::Write as _;
use std::path::PathBuf;

use discreta::cell::{Accumulator, AddOp, CellKind, Clock, CompareOp, Counter, Edge, Flop, GateOp, Rc};
use discreta::circuit::load_with;
use discreta::netlist::{Builder, Bus, Netlist};
use discreta::{Logic, Probe, Simulator, SimulatorError, Value};
use support::{Rng, folder, repository};

/// All that can be seen of a circuit, by name.
struct Watch<'n> {
    sim: Simulator<'n>,
    names: Vec<String>,
    probes: Vec<Probe>,
}

impl<'n> Watch<'n> {
    fn new(netlist: &'n Netlist) -> Watch<'n> {
        let mut names: Vec<String> = netlist.signal_ids().map(|s| netlist.signal_path(s)).collect();
        names.sort();
        let sim = Simulator::new(netlist);
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
}

// ---- random netlists

/// Bits of signals, the least significant first.
type Operand = Vec<(usize, u32, u32)>;

struct Cell {
    kind: CellKind,
    inputs: Vec<Operand>,
    outputs: Vec<usize>,
}

/// A netlist before any order is chosen for it.
struct Design {
    /// Name and width; the first `inputs` are the circuit's inputs.
    signals: Vec<(String, u32)>,
    inputs: usize,
    cells: Vec<Cell>,
}

const CLOCKS: std::ops::Range<usize> = 0..3;

fn flop(rng: &mut Rng, width: u32) -> Flop {
    Flop {
        edge: *rng.pick(&[Edge::Rising, Edge::Falling]),
        set_value: rng.known(width),
        reset_value: rng.known(width),
        init: if rng.one_in(2) { Value::unknown(width) } else { rng.known(width) },
    }
}

fn kind(rng: &mut Rng) -> CellKind {
    use CellKind as K;
    let width = *rng.pick(&[1, 1, 1, 4, 4, 70]);
    let gate = *rng.pick(&[GateOp::And, GateOp::Or, GateOp::Xor, GateOp::Nand, GateOp::Nor, GateOp::Xnor]);
    let state = flop(rng, width);
    match rng.below(20) {
        0..=5 => K::Gate { op: gate, width, inputs: 2 + rng.below(3) as u32 },
        6 => K::Gate { op: *rng.pick(&[GateOp::Not, GateOp::Buf]), width, inputs: 1 },
        7 => K::Mux { width, inputs: 2 + rng.below(3) as u32 },
        8 => K::AndOr { width, inputs: 2 },
        9 => K::FullAdder,
        10 => K::Adder { op: *rng.pick(&[AddOp::Add, AddOp::Sub, AddOp::AddSub]), width },
        11 => K::Compare { op: *rng.pick(&[CompareOp::Eq, CompareOp::Lt]), width, signed: rng.one_in(2) },
        12 => K::Sr { set_dominates: rng.one_in(2), init: Value::unknown(1) },
        13 => K::Latch(Box::new(state)),
        14..=16 => K::Flop(Box::new(state)),
        17 => K::Counter(Box::new(Counter { edge: state.edge, step: Value::from_u64(1, width), init: state.init })),
        18 => K::Accumulator(Box::new(Accumulator { edge: state.edge, init: state.init })),
        _ if rng.one_in(2) => K::Delay { width, ticks: 1 + rng.below(5), init: None },
        _ => K::RcDelay(Rc { tau: 2.5, rise: 0.6, fall: 0.4 }),
    }
}

impl Design {
    fn new(rng: &mut Rng) -> Design {
        let mut signals: Vec<(String, u32)> =
            ["clk0", "clk1", "clk2", "s", "r", "p", "q"].map(|n| (n.into(), 1)).into();
        signals.extend([("a".to_string(), 4), ("b".to_string(), 4), ("w".to_string(), 70)]);
        let inputs = signals.len();
        let mut cells = Vec::new();
        for i in 0..5 + rng.below(50) {
            let kind = if i == 0 { CellKind::Clock(Clock { period: 7, high: 3, phase: 2 }) } else { kind(rng) };
            let mut outputs = Vec::new();
            for (pin, name) in kind.outputs().iter().enumerate() {
                outputs.push(signals.len());
                signals.push((format!("n{i}_{name}"), kind.output_width(pin)));
            }
            cells.push(Cell { kind, inputs: vec![], outputs });
        }
        if rng.one_in(2) {
            let bus = signals.len();
            signals.push(("bus".into(), 4));
            let driver = || Cell { kind: CellKind::Tristate { width: 4 }, inputs: vec![], outputs: vec![bus] };
            cells.extend((0..1 + rng.below(3)).map(|_| driver()));
        }
        let mut rings = Vec::new();
        if rng.one_in(8) {
            // gates that feed back on themselves, and do not settle once `p` and a signal of the circuit let them
            for name in ["ring_b", "ring_a"] {
                let kind = CellKind::Gate { op: GateOp::Nand, width: 1, inputs: 3 };
                let (y, other) = (signals.len(), rng.below(signals.len() as u64) as usize);
                rings.push((cells.len(), vec![vec![(5, 0, 1), (other, 0, 1), (y, 0, 1)]]));
                signals.push((name.into(), 1));
                cells.push(Cell { kind, inputs: vec![], outputs: vec![y] });
            }
        }
        let mut design = Design { signals, inputs, cells };
        // how often a gate reads what comes after it
        let feedback = *rng.pick(&[u64::MAX, 60, 20, 8, 3]);
        for c in 0..design.cells.len() {
            let operands = design.operands(rng, c, feedback);
            design.cells[c].inputs = operands;
        }
        for (c, inputs) in rings {
            design.cells[c].inputs = inputs;
        }
        design
    }

    fn operands(&self, rng: &mut Rng, c: usize, feedback: u64) -> Vec<Operand> {
        let Cell { kind, outputs, .. } = &self.cells[c];
        let stores = kind.edge().is_some();
        let mut operands = Vec::new();
        for (pin, spec) in kind.inputs().iter().enumerate() {
            let width = kind.input_width(pin);
            let optional = *kind != CellKind::FullAdder
                && !matches!(spec.name, "clk" | "d" | "in" | "a" | "b" | "s" | "r" | "sel" | "sub" | "en")
                || (spec.name == "en" && stores);
            if optional && !rng.one_in(3) {
                operands.push(vec![]);
            } else if spec.name == "clk" && !rng.one_in(4) {
                operands.push(vec![(rng.below(CLOCKS.end as u64) as usize, 0, 1)]);
            } else if let Some(same) = self.used_before(rng, c, width) {
                operands.push(same);
            } else {
                let anything = stores || matches!(kind, CellKind::Delay { .. } | CellKind::RcDelay(_));
                let end = if anything || rng.one_in(feedback) { self.signals.len() } else { outputs[0] };
                operands.push(self.operand(rng, width, end));
            }
        }
        operands
    }

    /// At times what a cell before this one reads, so that both read the same bits brought together.
    fn used_before(&self, rng: &mut Rng, c: usize, width: u32) -> Option<Operand> {
        let wide = |o: &&Operand| o.len() > 1 && o.iter().map(|p| p.2).sum::<u32>() == width;
        let before: Vec<&Operand> = self.cells[..c].iter().flat_map(|cell| &cell.inputs).filter(wide).collect();
        (!before.is_empty() && rng.one_in(3)).then(|| (*rng.pick(&before)).clone())
    }

    /// `width` bits of signals below `end`, in as many pieces as it takes.
    fn operand(&self, rng: &mut Rng, width: u32, end: usize) -> Operand {
        let mut operand = Vec::new();
        let mut left = width;
        while left > 0 {
            let signal = rng.below(end as u64) as usize;
            let available = self.signals[signal].1;
            let take =
                if rng.one_in(3) { 1 + rng.below(u64::from(available.min(left))) as u32 } else { available.min(left) };
            operand.push((signal, rng.below(u64::from(available - take + 1)) as u32, take));
            left -= take;
        }
        operand
    }

    /// The netlist with signals and cells in random order.
    fn build(&self, rng: &mut Rng) -> Netlist {
        let mut b = Builder::new("top");
        let mut order: Vec<usize> = (0..self.signals.len()).collect();
        rng.shuffle(&mut order);
        let mut buses = vec![Bus::default(); self.signals.len()];
        for i in order {
            let (name, width) = &self.signals[i];
            buses[i] = if i < self.inputs { b.input(name, *width) } else { b.net(name, *width) };
        }
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        rng.shuffle(&mut order);
        for i in order {
            let cell = &self.cells[i];
            let pin = |operand: &Operand| {
                let parts: Vec<Bus> = operand.iter().map(|&(s, lo, width)| buses[s].slice(lo, width)).collect();
                Bus::concat(&parts)
            };
            let (inputs, outputs) =
                (cell.inputs.iter().map(pin).collect(), cell.outputs.iter().map(|&s| buses[s].clone()).collect());
            let top = b.top();
            b.cell(top, &format!("cell{i}"), cell.kind.clone(), inputs, outputs);
        }
        b.finish().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    fn steps(&self, rng: &mut Rng, count: u64) -> Vec<Step> {
        let mut steps = Vec::new();
        let unknown = *rng.pick(&[u64::MAX, u64::MAX, 20, 6]);
        for n in 0..count {
            let mut values = Vec::new();
            for (i, (name, width)) in self.signals[..self.inputs].iter().enumerate() {
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
}

#[test]
fn random_netlists_do_not_depend_on_the_order_of_their_cells() {
    let (mut instants, mut settled, mut unsettled) = (0, 0, 0);
    for seed in 0..800 {
        let mut rng = Rng::new(seed);
        let design = Design::new(&mut rng);
        let steps = design.steps(&mut rng, 40);
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
}
