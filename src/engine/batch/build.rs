//! Lays a netlist out for the batch engine: numbers its bits, puts its operations in evaluation order, links what each
//! bit wakes.

use std::collections::HashMap;

use super::program::{Code, Group, ONE, Op, Program, Store, Wake, Watch, ZERO};
use crate::cell::{CellKind, Edge, GateOp, Role};
use crate::netlist::{CellId, Direction, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::word_mask;

/// Steps of a cell up to which it is evaluated for all lanes at once.
const MOST_STEPS: u64 = 1 << 12;

/// What a cell is to lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanewise {
    /// About how many operations on lanes it is.
    pub steps: u64,
    /// Whether it is one of known bits most of the time: what drives z is not.
    pub known: bool,
}

/// What a kind is to lanes; none if the batch engine has no place for it.
pub(super) fn lanewise(kind: &CellKind) -> Option<Lanewise> {
    let n = u64::from;
    let of = |steps| Some(Lanewise { steps, known: true });
    match kind {
        CellKind::Mux { width, inputs } | CellKind::OneHotMux { width, inputs } | CellKind::AndOr { width, inputs } => {
            of(n(*width) * n(*inputs))
        }
        CellKind::Demux { width, select } => of(n(*width) << select),
        CellKind::Multiply { a_width, b_width, .. } => of(n(a_width + b_width) * n(a_width + b_width)),
        CellKind::Divide { width, .. } => of(4 * n(*width) * n(*width)),
        CellKind::Shift { a_width, width, b_width, .. } => of(n(*a_width.max(width)) * n(*b_width.min(&32))),
        CellKind::Products { width, table } => of(n(*width) * (table.len() as u64)),
        // a few a bit
        CellKind::Gate { .. }
        | CellKind::Majority { .. }
        | CellKind::HalfAdder
        | CellKind::FullAdder
        | CellKind::Adder { .. }
        | CellKind::Compare { .. }
        | CellKind::BitMux { .. }
        | CellKind::BitSame { .. }
        | CellKind::CarrySave { .. }
        | CellKind::Carry { .. }
        | CellKind::Alu(_)
        | CellKind::IsZero { .. }
        | CellKind::Constant(_)
        | CellKind::Clock(_)
        | CellKind::Sr { .. }
        | CellKind::Latch(_)
        | CellKind::Flop(_)
        | CellKind::EdgeFlop(_)
        | CellKind::Counter(_)
        | CellKind::Accumulator(_) => of(1),
        CellKind::Tristate { .. } => Some(Lanewise { steps: 1, known: false }),
        CellKind::Resolve { width, inputs } => Some(Lanewise { steps: n(*width) * n(*inputs), known: false }),
        CellKind::Power { width, b_width, .. } => {
            Some(Lanewise { steps: n(*width) * n(*width) * n(*b_width), known: false })
        }
        CellKind::Memory(_) | CellKind::Delay { .. } | CellKind::RcDelay(_) => None,
    }
}

/// A program in the making.
pub(super) struct Build<'n> {
    netlist: &'n Netlist,
    program: Program,
    group: u32,
    /// Whether anything reads or shows a net.
    used: Vec<bool>,
    watch_of: HashMap<(u32, bool), usize>,
}

impl<'n> Build<'n> {
    pub fn new(netlist: &'n Netlist) -> Build<'n> {
        let mut initial = vec![Word::ZERO, Word::known(1)];
        let mut constant = vec![true; 2];
        let (mut inputs, mut input_of) = (Vec::new(), HashMap::new());
        let mut nets = Vec::new();
        let constants = netlist.constants();
        for (i, net) in netlist.nets().iter().enumerate() {
            nets.push((initial.len() as u32, net.width));
            let init = match net.driver {
                Driver::Cell(cell, 0) => match &netlist.cell(cell).kind {
                    CellKind::Constant(value) => Some(&**value),
                    kind => kind.init(),
                },
                _ => None,
            };
            let floats = matches!(net.driver, Driver::Input(s) if netlist.signal(s).port == Some(Direction::Inout));
            let known = constants.net(NetId::new(i));
            let cell = if let Driver::Cell(cell, _) = net.driver { Some(&netlist.cell(cell).kind) } else { None };
            if matches!(cell, None | Some(CellKind::Clock(_))) {
                input_of.insert(NetId::new(i), inputs.len());
                inputs.push((initial.len() as u32, net.width));
            }
            let for_ever = matches!(cell, Some(CellKind::Constant(_)));
            for bit in 0..net.width {
                let (word, shift) = (bit as usize / 64, bit % 64);
                let whole = match init {
                    Some(value) => value.words().nth(word).unwrap_or_default(),
                    None if floats => Word::z(word_mask(net.width, word)),
                    None => known[word],
                };
                let first = Word { v: whole.v >> shift & 1, u: whole.u >> shift & 1 };
                initial.push(first);
                constant.push(for_ever || cell.is_some() && init.is_none() && first.is_known());
            }
        }
        let mut used = vec![false; nets.len()];
        for cell in netlist.cell_ids() {
            for pin in 0..netlist.cell(cell).kind.inputs().len() {
                netlist.input(cell, pin).iter().for_each(|s| used[s.net.index()] = true);
            }
        }
        for signal in netlist.signal_ids() {
            netlist.bits(signal).iter().for_each(|s| used[s.net.index()] = true);
        }
        let program = Program {
            ops: Vec::new(),
            pool: Vec::new(),
            cells: Vec::new(),
            groups: Vec::new(),
            stores: Vec::new(),
            watches: Vec::new(),
            clock_cells: Vec::new(),
            nets,
            initial,
            constant,
            inputs,
            input_of,
            known: None,
            wake_start: Vec::new(),
            wakes: Vec::new(),
        };
        Build { netlist, program, group: 0, used, watch_of: HashMap::new() }
    }

    pub fn finish(mut self) -> Program {
        let order = self.netlist.order();
        let mut groups = order.groups.iter().peekable();
        let mut first = 0;
        let mut stores = Vec::new();
        for (at, &cell) in order.sequence.iter().enumerate() {
            if groups.peek().is_some_and(|g| g.start == at) {
                first = self.program.ops.len();
                self.group = self.program.groups.len() as u32 + 1;
            }
            self.cell(cell, &mut stores);
            if groups.peek().is_some_and(|g| g.end == at + 1) {
                groups.next();
                self.close_group(first);
                self.group = 0;
            }
        }
        for (number, cell) in stores.into_iter().enumerate() {
            self.clocks(cell, number as u32);
        }
        self.link();
        self.program.constant.resize(self.program.bits(), false);
        self.program
    }

    /// Gives the operations of a group, from number `first` on, copies of their outputs to write to.
    fn close_group(&mut self, first: usize) {
        let ops = first..self.program.ops.len();
        let mut outputs = Vec::new();
        for i in ops.clone() {
            let mut pairs = Vec::new();
            for (pin, width) in self.output_widths(i).into_iter().enumerate() {
                let bit = self.program.ops[i].outs[pin];
                let copy = self.program.initial.len() as u32;
                self.program.ops[i].outs[pin] = copy;
                for k in 0..width {
                    self.program.initial.push(self.program.initial[(bit + k) as usize]);
                    pairs.push((copy + k, bit + k));
                }
            }
            outputs.push(pairs);
        }
        self.program.groups.push(Group { ops, outputs });
    }

    /// The width of each output that an operation writes.
    fn output_widths(&self, op: usize) -> Vec<u32> {
        let op = &self.program.ops[op];
        let kind = &self.program.cells[op.cell as usize];
        let outputs = if kind.init().is_some() && !op.derived { 1 } else { kind.outputs().len() };
        (0..outputs).map(|pin| kind.output_width(pin)).collect()
    }

    fn bits(&self, slices: &[Slice]) -> impl Iterator<Item = u32> + use<> {
        let bases: Vec<(u32, u32)> =
            slices.iter().map(|s| (self.program.nets[s.net.index()].0 + s.lo, s.width)).collect();
        bases.into_iter().flat_map(|(from, width)| from..from + width)
    }

    fn output(&self, cell: CellId, pin: usize) -> u32 {
        self.program.nets[self.netlist.output(cell, pin).index()].0
    }

    fn acts(&self, cell: CellId, pin: usize) -> bool {
        let constants = self.netlist.constants();
        !self.netlist.input(cell, pin).iter().all(|s| constants.is_zero(s))
    }

    /// An operation of this code with all pins of the cell, and its state behind them.
    fn op(&mut self, cell: CellId, code: Code) -> Op {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let inputs = kind.inputs();
        let mut pins = [0; 10];
        for (pin, spec) in inputs.iter().enumerate() {
            pins[pin] = self.program.pool.len() as u32;
            let slices = netlist.input(cell, pin);
            if !self.acts(cell, pin) {
                // not connected, or to what is 0 for ever
                let one = slices.is_empty() && spec.default;
                let rest = kind.input_width(pin) as usize - 1;
                self.program.pool.push(if one { ONE } else { ZERO });
                self.program.pool.extend(std::iter::repeat_n(ZERO, rest));
            } else {
                let bits = self.bits(slices);
                self.program.pool.extend(bits);
            }
        }
        let mut pin_count = inputs.len();
        if kind.init().is_some() {
            pins[pin_count] = self.program.pool.len() as u32;
            let q = self.output(cell, 0);
            self.program.pool.extend(q..q + kind.output_width(0));
            pin_count += 1;
        }
        pins[pin_count] = self.program.pool.len() as u32;
        let outputs = kind.outputs().len();
        let mut outs = [0; 3];
        (0..outputs).for_each(|pin| outs[pin] = self.output(cell, pin));
        let derived = outputs > 1 && self.used[netlist.output(cell, 1).index()];
        let keeps_known = kind.keeps_known(|pin| self.acts(cell, pin));
        // of a gate, what it joins
        let count = match code {
            Code::Gate(_) => kind.input_width(0) / kind.output_width(0),
            Code::Mux2 | Code::Cell | Code::Storage | Code::General => 1,
        };
        self.program.cells.push(kind.clone());
        Op {
            code,
            group: self.group,
            width: kind.output_width(0),
            inputs: count,
            pins,
            pin_count: pin_count as u8,
            outs,
            cell: self.program.cells.len() as u32 - 1,
            derived,
            keeps_known,
        }
    }

    fn cell(&mut self, cell: CellId, stores: &mut Vec<CellId>) {
        let kind = &self.netlist.cell(cell).kind;
        let code = match *kind {
            CellKind::Constant(_) => return,
            CellKind::Clock(clock) => {
                self.program.clock_cells.push((self.netlist.output(cell, 0), clock));
                return;
            }
            CellKind::Gate { op, .. } => Code::Gate(op),
            CellKind::IsZero { .. } => Code::Gate(GateOp::Nor),
            CellKind::Mux { inputs: 2, .. } => Code::Mux2,
            _ if kind.init().is_some() => Code::Storage,
            _ if lanewise(kind).is_some_and(|cell| cell.steps <= MOST_STEPS) => Code::Cell,
            _ => Code::General,
        };
        if kind.edge().is_some() {
            stores.push(cell);
            let op = self.op(cell, code);
            let next = self.program.initial.len() as u32;
            for k in 0..op.width {
                self.program.initial.push(self.program.initial[(op.outs[0] + k) as usize]);
            }
            let levels = kind.inputs().iter().enumerate().any(|(i, p)| p.role == Role::Level && self.acts(cell, i));
            let acts = levels || op.derived;
            self.program.stores.push(Store { op: op.clone(), q: op.outs[0], next });
            if acts {
                self.program.ops.push(op);
            }
            return;
        }
        let op = self.op(cell, code);
        self.program.ops.push(op);
    }

    fn clocks(&mut self, cell: CellId, number: u32) {
        let kind = &self.netlist.cell(cell).kind;
        for (pin, spec) in kind.inputs().iter().enumerate() {
            if kind.input_width(pin) != 1 {
                continue;
            }
            let Some(bit) = self.bits(self.netlist.input(cell, pin)).next() else { continue };
            match spec.role {
                Role::Clock => {
                    let rising = kind.edge() == Some(Edge::Rising);
                    let watch = self.watch(bit, false);
                    if rising { &mut watch.rising } else { &mut watch.falling }.push(number);
                }
                Role::Level => self.watch(bit, false).unknown.push(number),
                Role::Trigger => self.watch(bit, true).rising.push(number),
                _ => {}
            }
        }
    }

    fn watch(&mut self, bit: u32, level: bool) -> &mut Watch {
        let watches = &mut self.program.watches;
        let at = *self.watch_of.entry((bit, level)).or_insert_with(|| {
            watches.push(Watch { bit, level, rising: vec![], falling: vec![], unknown: vec![] });
            watches.len() - 1
        });
        &mut watches[at]
    }

    /// Fills in what each bit wakes.
    fn link(&mut self) {
        let p = &mut self.program;
        let mut pairs = Vec::new();
        for (number, op) in p.ops.iter().enumerate() {
            let kind = &p.cells[op.cell as usize];
            let inputs = kind.inputs().len();
            for pin in 0..op.pin_count as usize {
                let bits = &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize];
                let connected = |pin: usize| p.pool[op.pins[pin] as usize] > ONE;
                let reads = if pin < inputs { kind.acts_at_once(pin, connected) } else { op.derived };
                if reads {
                    pairs.extend(bits.iter().filter(|&&b| b > ONE).map(|&b| (b, Wake::Op(number as u32))));
                }
            }
        }
        pairs.extend(p.watches.iter().enumerate().map(|(number, w)| (w.bit, Wake::Watch(number as u32))));
        pairs.sort_unstable();
        pairs.dedup();
        p.wake_start = vec![0; p.initial.len() + 1];
        for &(bit, _) in &pairs {
            p.wake_start[bit as usize + 1] += 1;
        }
        for i in 1..p.wake_start.len() {
            p.wake_start[i] += p.wake_start[i - 1];
        }
        p.wakes = pairs.into_iter().map(|p| p.1).collect();
    }
}
