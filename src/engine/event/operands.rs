//! From pins to operands, and what each operation reads and writes.

use super::build::{BLANK, Build};
use super::program::{Code, ONE, Op, Operand, Part, Program, StoreCode, ZERO};
use crate::cell::pin::{accumulator, counter, flop};
use crate::netlist::{CellId, NetId, Slice};
use crate::value::Word;
use crate::value::word::{mask, words};

/// The slots that an operation writes.
pub(super) fn written(program: &Program, op: &Op) -> Vec<u32> {
    match op.code {
        Code::General => program.generals[op.ext as usize]
            .outputs
            .iter()
            .flat_map(|&(slot, width)| slot..slot + words(width) as u32)
            .collect(),
        Code::Narrow => program.narrows[op.ext as usize].outputs.clone(),
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
    pub(super) fn slot(&self, net: NetId) -> u32 {
        self.program.net_slot[net.index()]
    }

    pub(super) fn output(&self, cell: CellId, pin: usize) -> u32 {
        self.slot(self.netlist.output(cell, pin))
    }

    /// The pieces of a pin as (first slot of the net, lowest bit, width).
    pub(super) fn pieces(&self, slices: &[Slice]) -> Vec<(u32, u32, u32)> {
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
    pub(super) fn acts(&self, cell: CellId, pin: usize) -> bool {
        !self.netlist.input(cell, pin).iter().all(|s| self.constants.is_zero(s))
    }

    /// Pin `pin`, which is at most 64 bits wide, or what it reads unconnected.
    pub(super) fn pin(&mut self, cell: CellId, pin: usize) -> Operand {
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
            Code::GateN(_) | Code::AndOrN | Code::Gather | Code::Mux | Code::OneHotMux => {
                let pool = &self.program.pool[op.ext as usize..];
                let pairs = if op.code == Code::AndOrN { op.count * 2 } else { op.count };
                pool[..pairs as usize].iter().for_each(|(o, _)| read(o.slot));
                [op.a, op.c].iter().for_each(|o| read(o.slot));
            }
            Code::Narrow => {
                let pins = self.program.narrows[op.ext as usize].pins.clone();
                self.program.pool[pins].iter().for_each(|(o, _)| read(o.slot));
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
                let at_once: &[usize] = match s.code {
                    StoreCode::Counter => &[counter::ALOAD, counter::RESET],
                    StoreCode::Accumulator => &[accumulator::RESET],
                    StoreCode::Plain
                    | StoreCode::SetReset
                    | StoreCode::Flop
                    | StoreCode::Memory
                    | StoreCode::General => &[flop::ALOAD, flop::SET, flop::RESET],
                };
                at_once.iter().for_each(|&pin| read(s.pins[pin].slot));
                // what an accumulator has there is its carry
                if s.code != StoreCode::Accumulator && s.pins[flop::ALOAD] != ZERO {
                    read(s.pins[flop::D].slot);
                }
                // the state changes at edges too, but they regard the controls
                if op.count != 0 {
                    read(s.q);
                    if s.code == StoreCode::Accumulator {
                        [accumulator::D, accumulator::CI].iter().for_each(|&pin| read(s.pins[pin].slot));
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
}

// the place of the asynchronous load is the same in a flip-flop and in a counter
const _: () = assert!(counter::ALOAD == flop::ALOAD);
