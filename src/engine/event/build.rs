//! From a netlist to a [`Program`].

use std::collections::HashMap;

use super::link::link;
use super::operands::{part, written};
use super::program::{Code, DelayCell, General, Narrow, Op, Operand, Part, Program, ZERO};
use crate::cell::{AddOp, CellKind, GateOp};
use crate::netlist::{CellId, Constants, Direction, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

pub(super) struct Build<'n> {
    pub netlist: &'n Netlist,
    pub program: Program,
    /// Slots that gather the same pieces.
    pub gathers: HashMap<Vec<Slice>, u32>,
    /// (slot, operation that reads it).
    pub reads: Vec<(u32, u32)>,
    pub clock_of: HashMap<(u32, u8, bool), u32>,
    /// Whether anything reads or shows a net.
    pub used: Vec<bool>,
    /// Memories with their numbers.
    pub memories: HashMap<CellId, usize>,
    pub group: u32,
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
        used: netlist.used(),
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
    b.program.used = b.used;
    b.program
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
        let bits = |slot: u32| match p.slot_net.get(slot as usize) {
            Some(&net) if net != u32::MAX => {
                let word = slot - p.net_slot[net as usize];
                word_mask(self.netlist.nets()[net as usize].width, word as usize)
            }
            _ => 0,
        };
        let slots = p.ops[ops.clone()].iter().flat_map(|op| written(p, op));
        let slots = slots.map(|slot| (slot, bits(slot))).collect();
        p.group_slots.push(slots);
        let gathers = ops.clone().filter(|&i| p.ops[i].code == Code::Gather);
        p.group_gathers.push(gathers.map(|i| i as u32).collect());
        p.groups.push(ops);
    }

    pub(super) fn general(&mut self, cell: CellId) -> u32 {
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
            CellKind::Mux { width, inputs } if narrow(width) => {
                let c = self.pin(cell, 1);
                let inputs: Vec<_> = (0..inputs).map(|k| part(netlist.input(cell, 0), k * width, width)).collect();
                self.many(Op { code: Code::Mux, c, y, mask: mask(width), ..BLANK }, &inputs, width);
            }
            CellKind::OneHotMux { width, inputs } if narrow(width) && narrow(inputs) => {
                let (a, c) = (self.pin(cell, 0), self.pin(cell, 2));
                let lines: Vec<_> = (0..inputs).map(|k| part(netlist.input(cell, 1), k * width, width)).collect();
                self.many(Op { code: Code::OneHotMux, a, c, y, mask: mask(width), ..BLANK }, &lines, width);
            }
            CellKind::Compare { op, width, signed } if narrow(width) => {
                let (a, b) = (self.pin(cell, 0), self.pin(cell, 1));
                let code = Code::Compare { op, signed };
                self.push(Op { code, a, b, y, mask: mask(width), count: width, ..BLANK });
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
            _ => {
                let pins = 0..kind.inputs().len();
                let outputs = 0..kind.outputs().len();
                let all_narrow = pins.clone().all(|pin| narrow(kind.input_width(pin)))
                    && outputs.clone().all(|pin| narrow(kind.output_width(pin)));
                if kind.init().is_some() || !all_narrow {
                    return self.push_general(cell);
                }
                let pool: Vec<_> = pins.map(|pin| (self.pin(cell, pin), kind.input_width(pin))).collect();
                let (ext, count) = (self.program.narrows.len() as u32, pool.len() as u32);
                let start = self.program.pool.len();
                self.program.pool.extend(pool);
                let outputs = outputs.map(|pin| self.output(cell, pin)).collect();
                let pins = start..self.program.pool.len();
                self.program.narrows.push(Narrow { kind: kind.clone(), pins, outputs });
                self.push(Op { code: Code::Narrow, ext, count, ..BLANK });
            }
        }
    }

    /// An operation with as many inputs of `width` bits as there are.
    fn many(&mut self, op: Op, inputs: &[Vec<Slice>], width: u32) {
        let inputs: Vec<_> = inputs.iter().map(|input| (self.operand(input), width)).collect();
        let (ext, count) = (self.program.pool.len() as u32, inputs.len() as u32);
        self.program.pool.extend(inputs);
        self.push(Op { ext, count, ..op });
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
        let inputs: Vec<_> = (0..inputs).map(|k| part(slices, k * width, width)).collect();
        self.many(Op { code: Code::GateN(op), y, mask: mask(width), ..BLANK }, &inputs, width);
    }
}
