//! Random netlists, before any order is chosen for their cells.

use discreta::Value;
use discreta::cell::samples::{Sort, sample};
use discreta::cell::{Accumulator, AddOp, CellKind, Clock, CompareOp, Counter, Edge, Flop, GateOp, Rc};
use discreta::netlist::{Builder, Bus, Netlist};

use super::Rng;

/// Bits of signals, the least significant first.
pub type Operand = Vec<(usize, u32, u32)>;

#[derive(Clone)]
pub struct Cell {
    pub kind: CellKind,
    pub inputs: Vec<Operand>,
    pub outputs: Vec<usize>,
}

/// A netlist before any order is chosen for it.
#[derive(Clone)]
pub struct Design {
    /// Name and width; the first `inputs` are the circuit's inputs.
    pub signals: Vec<(String, u32)>,
    pub inputs: usize,
    pub cells: Vec<Cell>,
    /// Whether what acts at once reads only what comes before it.
    ordered: bool,
    /// Whether signals and cells are built in the order in which they are here.
    laid_out: bool,
}

/// The signals that are clocks.
pub const CLOCKS: std::ops::Range<usize> = 0..3;

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

/// Any kind but those that act by time, those that the netlist builder adds, and those that share a net.
fn any_kind(rng: &mut Rng) -> CellKind {
    loop {
        // gates and flip-flops more often than the rest
        if rng.one_in(3) {
            match kind(rng) {
                CellKind::Delay { .. } | CellKind::RcDelay(_) => continue,
                kind => return kind,
            }
        }
        let sort = *rng.pick(Sort::ALL);
        let width = match sort {
            Sort::Memory | Sort::Clock | Sort::Delay | Sort::RcDelay | Sort::Resolve | Sort::Tristate => continue,
            // the compiler takes no larger ones
            Sort::Power => *rng.pick(&[1, 3, 8, 31, 64]),
            Sort::Divide if rng.one_in(3) => *rng.pick(&[65, 100, 128]),
            Sort::Multiply if rng.one_in(3) => *rng.pick(&[65, 70, 130]),
            _ => *rng.pick(&[1, 1, 1, 4, 4, 8, 64, 70]),
        };
        return sample(sort, width, &mut |n| rng.below(n));
    }
}

impl Design {
    pub fn new(rng: &mut Rng) -> Design {
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
        let mut design = Design { signals, inputs, cells, ordered: false, laid_out: false };
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

    /// A netlist of cells of all kinds but delays, without feedback through gates.
    pub fn ordered(rng: &mut Rng) -> Design {
        let mut signals: Vec<(String, u32)> =
            ["clk0", "clk1", "clk2", "s", "r", "p", "q"].map(|n| (n.into(), 1)).into();
        signals.extend([("a".to_string(), 4), ("b".to_string(), 4), ("w".to_string(), 70)]);
        let inputs = signals.len();
        let mut cells = Vec::new();
        if rng.one_in(2) {
            let bus = signals.len();
            signals.push(("bus".into(), 4));
            let driver = || Cell { kind: CellKind::Tristate { width: 4 }, inputs: vec![], outputs: vec![bus] };
            cells.extend((0..1 + rng.below(3)).map(|_| driver()));
        }
        for i in 0..5 + rng.below(50) {
            let kind = if i == 0 { CellKind::Clock(Clock { period: 7, high: 3, phase: 2 }) } else { any_kind(rng) };
            let mut outputs = Vec::new();
            for (pin, name) in kind.outputs().iter().enumerate() {
                outputs.push(signals.len());
                signals.push((format!("n{i}_{name}"), kind.output_width(pin)));
            }
            cells.push(Cell { kind, inputs: vec![], outputs });
        }
        let mut design = Design { signals, inputs, cells, ordered: true, laid_out: false };
        for c in 0..design.cells.len() {
            let operands = design.operands(rng, c, u64::MAX);
            design.cells[c].inputs = operands;
        }
        design
    }

    /// Storage of all kinds whose asynchronous controls and clocks are each other's outputs, their own, or the same input:
    /// feedback through controls, and edges that coincide.
    pub fn tangled(rng: &mut Rng) -> Design {
        use CellKind as K;
        let mut signals: Vec<(String, u32)> = ["clk0", "clk1", "clk2", "s", "r"].map(|n| (n.into(), 1)).into();
        signals.extend([("a".to_string(), 4), ("w".to_string(), 70)]);
        let inputs = signals.len();
        let wide = rng.one_in(3);
        let mut cells = Vec::new();
        for i in 0..1 + rng.below(8) {
            let width = if wide { *rng.pick(&[1, 2, 63, 64, 65, 70]) } else { *rng.pick(&[1, 1, 1, 2, 4]) };
            let state = flop(rng, width);
            let init = if rng.one_in(2) { Value::unknown(1) } else { rng.known(1) };
            let gate = *rng.pick(&[GateOp::And, GateOp::Or, GateOp::Xor, GateOp::Nand, GateOp::Nor]);
            let kind = match rng.below(16) {
                0..=4 => K::Flop(Box::new(state)),
                5 | 6 => K::EdgeFlop(Box::new(state)),
                7 => K::Latch(Box::new(state)),
                8 => K::Sr { set_dominates: rng.one_in(2), init },
                9 | 10 => K::Counter(Box::new(Counter {
                    edge: state.edge,
                    step: if rng.one_in(2) { Value::from_u64(1, width) } else { rng.known(width) },
                    init: state.init,
                })),
                11 => K::Accumulator(Box::new(Accumulator { edge: state.edge, init: state.init })),
                12 => K::Gate { op: GateOp::Not, width: 1, inputs: 1 },
                13 if i == 0 => K::Clock(Clock { period: 6, high: 3, phase: rng.below(3) }),
                _ => K::Gate { op: gate, width: 1, inputs: 2 },
            };
            let mut outputs = Vec::new();
            for (pin, name) in kind.outputs().iter().enumerate() {
                outputs.push(signals.len());
                signals.push((format!("n{i}_{name}"), kind.output_width(pin)));
            }
            cells.push(Cell { kind, inputs: vec![], outputs });
        }
        let mut design = Design { signals, inputs, cells, ordered: false, laid_out: false };
        for c in 0..design.cells.len() {
            let Cell { kind, outputs, .. } = design.cells[c].clone();
            for (pin, spec) in kind.inputs().iter().enumerate() {
                let optional = kind.init().is_some() && !matches!(spec.name, "clk" | "d" | "s" | "r");
                let optional = optional && !(matches!(kind, K::Latch(_)) && spec.name == "en");
                let operand = match kind.input_width(pin) {
                    _ if optional && rng.one_in(2) => vec![],
                    1 => {
                        let signal = match rng.below(6) {
                            0 if kind.init().is_some() => *rng.pick(&outputs),
                            0..=2 => rng.below(design.signals.len() as u64) as usize,
                            _ => rng.below(5) as usize,
                        };
                        vec![(signal, rng.below(u64::from(design.signals[signal].1)) as u32, 1)]
                    }
                    width => design.operand(rng, width, design.signals.len()),
                };
                design.cells[c].inputs.push(operand);
            }
        }
        design
    }

    /// The same several times over, on the same inputs, with other values in the registers and other constants. At times
    /// one reads a register of another, or is not quite as they are.
    pub fn repeated(&self, rng: &mut Rng, times: usize) -> Design {
        let own = self.signals.len() - self.inputs;
        let mut design = Design {
            signals: self.signals[..self.inputs].to_vec(),
            inputs: self.inputs,
            cells: Vec::new(),
            ordered: self.ordered,
            laid_out: true,
        };
        let registers: Vec<usize> =
            self.cells.iter().filter(|c| c.kind.edge().is_some()).map(|c| c.outputs[0]).collect();
        let neighbours = rng.one_in(3);
        for copy in 0..times {
            let signals = &self.signals[self.inputs..];
            design.signals.extend(signals.iter().map(|(name, width)| (format!("{name}_{copy}"), *width)));
            let odd = rng.one_in(6);
            for cell in &self.cells {
                let mut cell = cell.clone();
                let moved = |signal: usize, copy| if signal < self.inputs { signal } else { signal + copy * own };
                for operand in &mut cell.inputs {
                    for piece in operand {
                        let other = neighbours && registers.contains(&piece.0) && rng.one_in(4);
                        piece.0 = moved(piece.0, if other { (copy + 1) % times } else { copy });
                    }
                }
                cell.outputs.iter_mut().for_each(|signal| *signal = moved(*signal, copy));
                let new = |rng: &mut Rng, value: &mut Value| *value = rng.known(value.width());
                match &mut cell.kind {
                    CellKind::Flop(flop) => {
                        new(rng, &mut flop.init);
                        new(rng, &mut flop.set_value);
                        new(rng, &mut flop.reset_value);
                    }
                    // one clock is enough
                    CellKind::Clock(_) => cell.kind = CellKind::Constant(Box::new(Value::from_u64(0, 1))),
                    CellKind::Constant(value) if value.width() > 1 => new(rng, value),
                    CellKind::Counter(counter) => new(rng, &mut counter.init),
                    CellKind::Gate { op, inputs: 2, .. } if odd && rng.one_in(3) => *op = GateOp::Nor,
                    _ => {}
                }
                design.cells.push(cell);
            }
        }
        design
    }

    fn operands(&self, rng: &mut Rng, c: usize, feedback: u64) -> Vec<Operand> {
        let Cell { kind, outputs, .. } = &self.cells[c];
        let stores = kind.edge().is_some();
        let mut operands = Vec::new();
        for (pin, spec) in kind.inputs().iter().enumerate() {
            let width = kind.input_width(pin);
            let optional = (kind.init().is_some() || matches!(kind, CellKind::Adder { .. }))
                && !matches!(spec.name, "clk" | "d" | "in" | "a" | "b" | "s" | "r" | "sel" | "sub" | "en")
                || (spec.name == "en" && stores);
            if optional && !rng.one_in(3) {
                operands.push(vec![]);
            } else if spec.name == "clk" && !rng.one_in(4) {
                operands.push(vec![(rng.below(CLOCKS.end as u64) as usize, 0, 1)]);
            } else if let Some(same) = self.used_before(rng, c, width).filter(|o| self.allows(c, pin, o)) {
                operands.push(same);
            } else if self.ordered {
                let end = if kind.acts_at_once(pin, |_| true) { self.before(c) } else { self.signals.len() };
                operands.push(self.operand(rng, width, end));
            } else {
                let anything = stores || matches!(kind, CellKind::Delay { .. } | CellKind::RcDelay(_));
                let end = if anything || rng.one_in(feedback) { self.signals.len() } else { outputs[0] };
                operands.push(self.operand(rng, width, end));
            }
        }
        operands
    }

    /// The signals that what acts at once in a cell may read: those of the cells before it.
    fn before(&self, c: usize) -> usize {
        if matches!(self.cells[c].kind, CellKind::Tristate { .. }) { self.inputs } else { self.cells[c].outputs[0] }
    }

    fn allows(&self, c: usize, pin: usize, operand: &Operand) -> bool {
        !self.ordered || !self.cells[c].kind.acts_at_once(pin, |_| true) || operand.iter().all(|p| p.0 < self.before(c))
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

    /// The netlist with signals and cells in random order, unless they are laid out.
    pub fn build(&self, rng: &mut Rng) -> Netlist {
        let mut b = Builder::new("top");
        let mut order: Vec<usize> = (0..self.signals.len()).collect();
        if !self.laid_out {
            rng.shuffle(&mut order);
        }
        let mut buses = vec![Bus::default(); self.signals.len()];
        for i in order {
            let (name, width) = &self.signals[i];
            buses[i] = if i < self.inputs { b.input(name, *width) } else { b.net(name, *width) };
        }
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        if !self.laid_out {
            rng.shuffle(&mut order);
        }
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
}
