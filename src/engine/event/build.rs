//! From a netlist to a [`Program`].

use std::collections::HashMap;

use super::link::link;
use super::program::{
    ClockPin, Code, ControlPin, DelayCell, General, ONE, Op, Operand, Part, Program, Store, StoreCode, ZERO,
};
use crate::cell::{AddOp, CellKind, Edge, GateOp, Role};
use crate::netlist::{CellId, Constants, Direction, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

pub(super) struct Build<'n> {
    pub netlist: &'n Netlist,
    pub program: Program,
    /// Slots that gather the same pieces.
    gathers: HashMap<Vec<Slice>, u32>,
    /// (slot, operation that reads it).
    reads: Vec<(u32, u32)>,
    clock_of: HashMap<(u32, u8, bool), u32>,
    /// Whether anything reads or shows a net.
    used: Vec<bool>,
    /// Memories with their numbers.
    pub memories: HashMap<CellId, usize>,
    group: u32,
    pub constants: &'n Constants,
}

pub(super) const BLANK: Op =
    Op { code: Code::Buf, group: 0, a: ZERO, b: ZERO, c: ZERO, y: 0, y2: 0, mask: 1, ext: 0, count: 0 };

pub(super) fn build(netlist: &Netlist) -> Program {
    let mut b = Build {
        netlist,
        program: Program::default(),
        gathers: HashMap::new(),
        reads: Vec::new(),
        clock_of: HashMap::new(),
        used: used(netlist),
        memories: HashMap::new(),
        group: 0,
        constants: netlist.constants(),
    };
    b.lay_out_state();
    let order = netlist.order();
    let mut stores = Vec::new();
    let mut groups = order.groups.iter().peekable();
    let mut first_op = 0;
    for (at, &cell) in order.sequence.iter().enumerate() {
        if groups.peek().is_some_and(|g| g.start == at) {
            first_op = b.program.ops.len();
            b.group = b.program.groups.len() as u32 + 1;
        }
        b.cell(cell, order.ports.get(&at).copied(), &mut stores);
        if groups.peek().is_some_and(|g| g.end == at + 1) {
            groups.next();
            b.close_group(first_op);
            b.group = 0;
        }
    }
    for (cell, store) in stores {
        b.sampled(cell, store);
    }
    let mut memories: Vec<(CellId, usize)> = b.memories.drain().collect();
    memories.sort_unstable_by_key(|m| m.1);
    for (cell, number) in memories {
        b.sampled_memory(cell, number);
    }
    b.controls();
    link(&mut b.program, b.reads);
    b.program
}

fn used(netlist: &Netlist) -> Vec<bool> {
    let mut used = vec![false; netlist.nets().len()];
    for cell in netlist.cell_ids() {
        for pin in 0..netlist.cell(cell).kind.inputs().len() {
            for s in netlist.input(cell, pin) {
                used[s.net.index()] = true;
            }
        }
    }
    for signal in netlist.signal_ids() {
        for s in netlist.bits(signal) {
            used[s.net.index()] = true;
        }
    }
    used
}

/// The slots that an operation writes.
fn written(program: &Program, op: &Op) -> Vec<u32> {
    match op.code {
        Code::General => program.generals[op.ext as usize]
            .outputs
            .iter()
            .flat_map(|&(slot, width)| slot..slot + words(width) as u32)
            .collect(),
        Code::MemoryRead => {
            let cell = &program.memories[op.ext as usize];
            let port = &cell.reads[op.count as usize];
            (port.slot..=port.slot + (port.shift + cell.kind.width - 1) / 64).collect()
        }
        Code::MemoryWrite => vec![program.memories[op.ext as usize].contents],
        Code::HalfAdder | Code::FullAdder | Code::Add | Code::Sub | Code::Sr { .. } | Code::Level => vec![op.y, op.y2],
        _ => vec![op.y],
    }
}

/// The `width` bits from bit `lo` up of what some slices make together.
pub(super) fn part(slices: &[Slice], lo: u32, width: u32) -> Vec<Slice> {
    let (mut skip, mut left, mut out) = (lo, width, Vec::new());
    for s in slices {
        if left == 0 {
            break;
        }
        if skip >= s.width {
            skip -= s.width;
            continue;
        }
        let take = (s.width - skip).min(left);
        out.push(Slice { net: s.net, lo: s.lo + skip, width: take });
        left -= take;
        skip = 0;
    }
    out
}

impl Build<'_> {
    fn lay_out_state(&mut self) {
        let p = &mut self.program;
        // bits that never change have their values from the start: the order does not wait for them
        let constants = &self.constants;
        p.initial = vec![Word::ZERO, Word::known(1)];
        p.slot_net = vec![u32::MAX; 2];
        for (i, net) in self.netlist.nets().iter().enumerate() {
            p.net_slot.push(p.initial.len() as u32);
            let init = match net.driver {
                Driver::Cell(cell, 0) => match &self.netlist.cell(cell).kind {
                    CellKind::Constant(value) => Some((**value).clone()),
                    CellKind::Delay { init, .. } => init.as_deref().cloned(),
                    kind => kind.init().cloned(),
                },
                _ => None,
            };
            let floats =
                matches!(net.driver, Driver::Input(s) if self.netlist.signal(s).port == Some(Direction::Inout));
            for w in 0..words(net.width) {
                let m = word_mask(net.width, w);
                let unset = if floats { Word::z(m) } else { constants.net(NetId::new(i))[w] };
                p.initial.push(init.as_ref().map_or(unset, |v| v.words().nth(w).unwrap_or_default()));
                p.slot_net.push(i as u32);
            }
        }
        p.net_slot.push(p.initial.len() as u32);
    }

    /// Makes a feedback group of the operations from `first` on.
    fn close_group(&mut self, first: usize) {
        let p = &mut self.program;
        let ops = first..p.ops.len();
        p.group_slots.push(p.ops[ops.clone()].iter().flat_map(|op| written(p, op)).collect());
        let gathers = ops.clone().filter(|&i| p.ops[i].code == Code::Gather);
        p.group_gathers.push(gathers.map(|i| i as u32).collect());
        p.groups.push(ops);
    }

    fn slot(&self, net: NetId) -> u32 {
        self.program.net_slot[net.index()]
    }

    pub(super) fn output(&self, cell: CellId, pin: usize) -> u32 {
        self.slot(self.netlist.output(cell, pin))
    }

    /// The pieces of a pin as (first slot of the net, lowest bit, width).
    fn pieces(&self, slices: &[Slice]) -> Vec<(u32, u32, u32)> {
        slices.iter().map(|s| (self.slot(s.net), s.lo, s.width)).collect()
    }

    /// One word that holds these bits, if a slot does as it is.
    pub(super) fn direct(&self, slices: &[Slice]) -> Option<Operand> {
        let first = slices.first()?;
        let operand = |part| Operand { slot: self.slot(first.net) + first.lo / 64, shift: (first.lo % 64) as u8, part };
        let held = |s: &Slice| (self.netlist.net(s.net).width - s.lo / 64 * 64).min(64);
        match slices {
            [s] if s.lo % 64 == 0 && s.width == held(s) => Some(operand(Part::Whole)),
            [s] if s.lo / 64 == (s.lo + s.width - 1) / 64 => Some(operand(Part::Bits)),
            [_, ..] if slices.iter().all(|s| s == first && s.width == 1) => Some(operand(Part::Splat)),
            _ => None,
        }
    }

    /// At most 64 bits as an operand, gathered into a slot of their own if need be.
    pub(super) fn operand(&mut self, slices: &[Slice]) -> Operand {
        if let Some(direct) = self.direct(slices) {
            return direct;
        }
        if let Some(&slot) = self.gathers.get(slices) {
            return Operand { slot, ..ZERO };
        }
        let y = self.program.initial.len() as u32;
        let ext = self.program.pool.len() as u32;
        for s in slices {
            let mut at = s.lo;
            while at < s.lo + s.width {
                let width = (64 - at % 64).min(s.lo + s.width - at);
                let slot = self.slot(s.net) + at / 64;
                self.program.pool.push((Operand { slot, shift: (at % 64) as u8, part: Part::Bits }, width));
                at += width;
            }
        }
        let count = self.program.pool.len() as u32 - ext;
        let width: u32 = slices.iter().map(|s| s.width).sum();
        self.program.initial.push(Word::x(mask(width)));
        self.program.slot_net.push(u32::MAX);
        self.gathers.insert(slices.to_vec(), y);
        self.push(Op { code: Code::Gather, y, mask: mask(width), ext, count, ..BLANK });
        Operand { slot: y, ..ZERO }
    }

    /// Whether a pin is connected to anything but constant 0.
    fn acts(&self, cell: CellId, pin: usize) -> bool {
        !self.netlist.input(cell, pin).iter().all(|s| self.constants.is_zero(s))
    }

    /// Pin `pin`, which is at most 64 bits wide, or what it reads unconnected.
    fn pin(&mut self, cell: CellId, pin: usize) -> Operand {
        let netlist = self.netlist;
        let slices = netlist.input(cell, pin);
        if slices.is_empty() {
            return if netlist.cell(cell).kind.inputs()[pin].default { ONE } else { ZERO };
        }
        if slices.iter().all(|s| self.constants.is_zero(s)) {
            return ZERO;
        }
        self.operand(slices)
    }

    pub(super) fn push(&mut self, op: Op) {
        let number = self.program.ops.len() as u32;
        let op = Op { group: self.group, ..op };
        let mut read = |slot| self.reads.push((slot, number));
        match op.code {
            Code::GateN(_) | Code::AndOrN | Code::Gather => {
                let pool = &self.program.pool[op.ext as usize..];
                let pairs = if op.code == Code::AndOrN { op.count * 2 } else { op.count };
                pool[..pairs as usize].iter().for_each(|(o, _)| read(o.slot));
            }
            Code::General => {
                let general = &self.program.generals[op.ext as usize];
                for (pin, pieces) in general.pins.iter().enumerate() {
                    if general.kind.acts_at_once(pin, |p| !general.pins[p].is_empty()) {
                        pieces.iter().for_each(|&(slot, lo, width)| {
                            (slot + lo / 64..=slot + (lo + width - 1) / 64).for_each(&mut read)
                        });
                    }
                }
                if general.kind.init().is_some() {
                    let (slot, width) = general.outputs[0];
                    (slot..slot + words(width) as u32).for_each(read);
                }
            }
            Code::Level => {
                let s = &self.program.stores[op.ext as usize];
                [s.set, s.reset, s.aload].iter().for_each(|o| read(o.slot));
                if s.aload != ZERO {
                    read(s.d.slot);
                }
                // the state changes at edges too, but they regard the controls
                if op.count != 0 {
                    read(s.q);
                    if s.code == StoreCode::Accumulator {
                        [s.d, s.extra].iter().for_each(|o| read(o.slot));
                    }
                }
            }
            Code::MemoryRead => {
                let memory = &self.program.memories[op.ext as usize];
                let port = &memory.reads[op.count as usize];
                read(port.arst.slot);
                if memory.kind.reads[op.count as usize].clock.is_none() {
                    [port.address.slot, memory.contents].into_iter().for_each(read);
                }
            }
            Code::MemoryWrite => {
                let memory = &self.program.memories[op.ext as usize];
                read(memory.contents + 1);
                for (_, port) in memory.kind.writes.iter().zip(&memory.writes).filter(|p| p.0.clock.is_none()) {
                    read(port.address.slot);
                    for words in [&port.data, &port.enable] {
                        self.program.pool[words.clone()].iter().for_each(|(o, _)| read(o.slot));
                    }
                }
            }
            // its own state, in `c`, changes through it alone, or at an edge that regards its controls
            Code::Sr { .. } | Code::SetReset => [op.a, op.b].iter().for_each(|o| read(o.slot)),
            _ => [op.a, op.b, op.c].iter().for_each(|o| read(o.slot)),
        }
        self.program.ops.push(op);
    }

    fn general(&mut self, cell: CellId) -> u32 {
        let netlist = self.netlist;
        let kind = netlist.cell(cell).kind.clone();
        let pins = (0..kind.inputs().len()).map(|pin| self.pieces(netlist.input(cell, pin))).collect();
        let outputs = (0..kind.outputs().len()).map(|pin| (self.output(cell, pin), kind.output_width(pin))).collect();
        self.program.generals.push(General { kind, pins, outputs });
        self.program.generals.len() as u32 - 1
    }

    fn push_general(&mut self, cell: CellId) {
        let ext = self.general(cell);
        self.push(Op { code: Code::General, ext, ..BLANK });
    }

    /// Adds a cell, or the read port of a memory that has several places in the order.
    fn cell(&mut self, cell: CellId, port: Option<u32>, stores: &mut Vec<(CellId, usize)>) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let narrow = |w: u32| w <= 64;
        let y = self.output(cell, 0);
        match *kind {
            CellKind::Constant(_) => {}
            CellKind::Clock(clock) => self.program.clock_cells.push((y, clock)),
            CellKind::Delay { .. } | CellKind::RcDelay(_) => {
                let input = self.pieces(netlist.input(cell, 0));
                self.program.delays.push(DelayCell { kind: kind.clone(), input, y, width: kind.output_width(0) });
            }
            CellKind::Gate { op, width, inputs } if narrow(width) => self.gate(cell, op, width, inputs),
            CellKind::IsZero { width } => self.gate(cell, GateOp::Nor, 1, width),
            CellKind::AndOr { width, inputs } if narrow(width) => {
                let mut pairs = Vec::new();
                for k in 0..inputs {
                    let input = self.operand(&part(netlist.input(cell, 0), k * width, width));
                    let select = self.operand(&part(netlist.input(cell, 1), k, 1));
                    let select = if width == 1 { select } else { Operand { part: Part::Splat, ..select } };
                    pairs.extend([(input, width), (select, width)]);
                }
                let ext = self.program.pool.len() as u32;
                self.program.pool.extend(pairs);
                self.push(Op { code: Code::AndOrN, y, mask: mask(width), ext, count: inputs, ..BLANK });
            }
            CellKind::Mux { width, inputs: 2 } if narrow(width) => {
                let a = self.operand(&part(netlist.input(cell, 0), 0, width));
                let b = self.operand(&part(netlist.input(cell, 0), width, width));
                let c = self.pin(cell, 1);
                self.push(Op { code: Code::Mux2, a, b, c, y, mask: mask(width), ..BLANK });
            }
            CellKind::HalfAdder | CellKind::FullAdder => {
                let code = if *kind == CellKind::HalfAdder { Code::HalfAdder } else { Code::FullAdder };
                let (a, b) = (self.pin(cell, 0), self.pin(cell, 1));
                let c = if *kind == CellKind::HalfAdder { ZERO } else { self.pin(cell, 2) };
                self.push(Op { code, a, b, c, y, y2: self.output(cell, 1), ..BLANK });
            }
            CellKind::Adder { op: op @ (AddOp::Add | AddOp::Sub), width } if narrow(width) => {
                let code = if op == AddOp::Add { Code::Add } else { Code::Sub };
                let (a, b, c) = (self.pin(cell, 0), self.pin(cell, 1), self.pin(cell, 2));
                self.push(Op { code, a, b, c, y, y2: self.output(cell, 1), mask: mask(width), count: width, ..BLANK });
            }
            CellKind::Sr { set_dominates, .. } => {
                let (a, b) = (self.pin(cell, 0), self.pin(cell, 1));
                self.push(Op {
                    code: Code::Sr { set_dominates },
                    a,
                    b,
                    c: Operand { slot: y, ..ZERO },
                    y,
                    y2: self.output(cell, 1),
                    ..BLANK
                });
            }
            CellKind::Flop(_) | CellKind::EdgeFlop(_) | CellKind::Counter(_) | CellKind::Accumulator(_) => {
                stores.push((cell, self.program.stores.len()));
                self.store(cell);
            }
            CellKind::Memory(ref m) => self.memory(cell, m, port),
            _ => self.push_general(cell),
        }
    }

    fn gate(&mut self, cell: CellId, op: GateOp, width: u32, inputs: u32) {
        let netlist = self.netlist;
        let slices = netlist.input(cell, 0);
        let y = self.output(cell, 0);
        let two = match op {
            GateOp::And => Code::And2,
            GateOp::Or => Code::Or2,
            GateOp::Xor => Code::Xor2,
            GateOp::Nand => Code::Nand2,
            GateOp::Nor => Code::Nor2,
            GateOp::Xnor => Code::Xnor2,
            GateOp::Buf => Code::Buf,
            GateOp::Not => Code::Not,
        };
        if width == 1
            && inputs > 1
            && inputs <= 64
            && let Some(a) = self.direct(slices).filter(|a| a.part != Part::Splat)
        {
            self.push(Op { code: Code::Reduce(op), a, y, mask: mask(inputs), ..BLANK });
            return;
        }
        if inputs == 1 && matches!(op, GateOp::Buf | GateOp::Not) || inputs == 2 {
            let a = self.operand(&part(slices, 0, width));
            let b = if inputs == 2 { self.operand(&part(slices, width, width)) } else { ZERO };
            self.push(Op { code: two, a, b, y, mask: mask(width), ..BLANK });
            return;
        }
        let operands: Vec<_> = (0..inputs).map(|k| (self.operand(&part(slices, k * width, width)), width)).collect();
        let ext = self.program.pool.len() as u32;
        self.program.pool.extend(operands);
        self.push(Op { code: Code::GateN(op), y, mask: mask(width), ext, count: inputs, ..BLANK });
    }

    /// A clocked cell: its store, and an operation for what it does without a clock, if it does anything.
    fn store(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let width = kind.output_width(0);
        let derives = kind.outputs().len() > 1;
        let derived_used = derives && self.used[netlist.output(cell, 1).index()];
        let acts = |pin: usize| self.acts(cell, pin);
        let level = derived_used || kind.inputs().iter().enumerate().any(|(i, p)| p.role == Role::Level && acts(i));
        let mut store = Store {
            q: self.output(cell, 0),
            derived: if derives { self.output(cell, 1) } else { 0 },
            width,
            ..Store::BLANK
        };
        if width > 64 || matches!(kind, CellKind::EdgeFlop(_)) {
            store.general = self.general(cell);
            let ext = store.general;
            self.program.stores.push(store);
            if level {
                self.push(Op { code: Code::General, ext, ..BLANK });
            }
            return;
        }
        let word = |v: &crate::Value| v.words().next().unwrap_or_default();
        match kind {
            CellKind::Flop(f) => {
                store.code = match [2, 6, 7].into_iter().any(acts) {
                    false if ![3, 4].into_iter().any(acts) => StoreCode::Plain,
                    false if netlist.input(cell, 5).is_empty() => StoreCode::SetReset,
                    _ => StoreCode::Flop,
                };
                (store.set_value, store.reset_value) = (word(&f.set_value), word(&f.reset_value));
                (store.aload, store.set, store.reset) = (self.pin(cell, 2), self.pin(cell, 3), self.pin(cell, 4));
                if self.acts(cell, 2) {
                    store.d = self.pin(cell, 1);
                }
            }
            CellKind::Counter(c) => {
                store.code = StoreCode::Counter;
                store.set_value = word(&c.step);
                (store.aload, store.reset) = (self.pin(cell, 2), self.pin(cell, 3));
                if self.acts(cell, 2) {
                    store.d = self.pin(cell, 1);
                }
            }
            _ => {
                store.code = StoreCode::Accumulator;
                (store.d, store.extra, store.reset) = (self.pin(cell, 1), self.pin(cell, 2), self.pin(cell, 3));
            }
        }
        let (y, y2, a, b) = (store.q, store.derived, store.set, store.reset);
        let code = match store.code {
            StoreCode::SetReset if !derived_used => Code::SetReset,
            _ => Code::Level,
        };
        self.program.stores.push(store);
        if level {
            let ext = self.program.stores.len() as u32 - 1;
            let op = Op { y, y2, mask: mask(width), ext, count: derived_used.into(), ..BLANK };
            self.push(if code == Code::SetReset { Op { code, a, b, ..op } } else { Op { code, ..op } });
        }
    }

    /// The pins of a store that only a clock edge reads, and the clock itself.
    fn sampled(&mut self, cell: CellId, number: usize) {
        let kind = &self.netlist.cell(cell).kind;
        if self.program.stores[number].code != StoreCode::General {
            match kind {
                CellKind::Flop(_) => {
                    let (d, en, extra, extra2) =
                        (self.pin(cell, 1), self.pin(cell, 5), self.pin(cell, 6), self.pin(cell, 7));
                    let s = &mut self.program.stores[number];
                    (s.d, s.en, s.extra, s.extra2) = (d, en, extra, extra2);
                }
                CellKind::Counter(_) => {
                    let (d, en, down, load) =
                        (self.pin(cell, 1), self.pin(cell, 4), self.pin(cell, 5), self.pin(cell, 6));
                    let s = &mut self.program.stores[number];
                    (s.d, s.en, s.extra, s.extra2) = (d, en, down, load);
                }
                _ => self.program.stores[number].en = self.pin(cell, 4),
            }
        }
        for (pin, spec) in kind.inputs().iter().enumerate() {
            let Some(operand) = self.bit(cell, pin) else { continue };
            let number = number as u32;
            match spec.role {
                Role::Clock => {
                    let rising = kind.edge() == Some(Edge::Rising);
                    let clock = self.clock(operand, false);
                    if rising { &mut clock.rising } else { &mut clock.falling }.push(number);
                }
                Role::Level => self.clock(operand, false).unknown.push(number),
                Role::Trigger => self.clock(operand, true).rising.push(number),
                _ => {}
            }
        }
    }

    /// A connected pin of one bit.
    fn bit(&self, cell: CellId, pin: usize) -> Option<Operand> {
        let slices = self.netlist.input(cell, pin);
        if self.netlist.cell(cell).kind.input_width(pin) == 1 { self.direct(slices) } else { None }
    }

    pub(super) fn clock(&mut self, at: Operand, level: bool) -> &mut ClockPin {
        let clocks = &mut self.program.clocks;
        let number = *self.clock_of.entry((at.slot, at.shift, level)).or_insert_with(|| {
            let (rising, falling, unknown) = (vec![], vec![], vec![]);
            clocks.push(ClockPin { slot: at.slot, shift: at.shift, level, rising, falling, unknown });
            clocks.len() as u32 - 1
        });
        &mut clocks[number as usize]
    }

    /// The pins whose unknown values are reported.
    fn controls(&mut self) {
        for cell in self.netlist.cell_ids() {
            let kind = &self.netlist.cell(cell).kind;
            if kind.init().is_none() {
                continue;
            }
            if let CellKind::Memory(memory) = kind {
                self.memory_controls(cell, memory);
                continue;
            }
            for (pin, spec) in kind.inputs().iter().enumerate() {
                let watched = matches!(spec.role, Role::Clock | Role::Level | Role::Trigger | Role::Enable);
                if let Some(o) = self.bit(cell, pin).filter(|_| watched) {
                    let net = self.netlist.input(cell, pin)[0].net;
                    self.program.controls.push(ControlPin { slot: o.slot, shift: o.shift, cell, pin: spec.name, net });
                }
            }
        }
    }
}
