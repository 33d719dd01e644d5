//! Bits that nothing drives: what is told of them, and what they are.

use super::super::bus::{Bus, Part};
use super::super::join::Join;
use super::super::{CellId, Direction, Driver, Fault, NetId, ScopeId, SignalId};
use super::{Builder, Draft};
use crate::cell::CellKind;
use crate::netlist::UNDRIVEN;
use crate::{Logic, Value};

impl Builder {
    /// Reports bits that are read but not driven, and signals that are not read; ties bits that nothing drives to x.
    pub(super) fn tie_undriven(&mut self, join: &mut Join, faults: &mut Vec<Fault>) {
        let mut read = vec![false; self.bits as usize];
        let outputs = self.signals.iter().filter(|n| n.signal.is_top_port() && n.signal.port != Some(Direction::Input));
        for bit in self.cells.iter().flat_map(|c| &c.inputs).chain(outputs.map(|n| &n.bus)).flat_map(Bus::bits) {
            read[bit as usize] = true;
        }
        let mut ties = Vec::new();
        if self.verilog {
            self.tie_floating(join, &mut read);
            return;
        }
        for (i, named) in self.signals.iter().enumerate().filter(|(_, n)| n.owner) {
            let signal = SignalId::new(i);
            let bits: Vec<u32> = named.bus.bits().collect();
            if !bits.iter().any(|&b| read[b as usize]) {
                let driven = bits.iter().any(|&b| join.is_driven(b));
                faults.push(Fault::Unread { signal, driven });
            }
            let mut at = 0;
            while at < bits.len() {
                let kind = |b: u32| (join.is_driven(b), read[b as usize]);
                let run = bits[at..].iter().take_while(|&&b| kind(b) == kind(bits[at])).count();
                if !join.is_driven(bits[at]) {
                    let (lo, width) = (at as u32, run as u32);
                    if read[bits[at] as usize] {
                        faults.push(Fault::Undriven { signal, lo, width });
                    }
                    ties.push((named.signal.scope, named.bus.slice(lo, width)));
                }
                at += run;
            }
        }
        for (scope, bus) in ties {
            self.tie(join, scope, bus, Logic::X);
        }
        join.cells = self.cells.len();
    }

    /// Lets bits that are read or shown and that nothing drives float.
    fn tie_floating(&mut self, join: &mut Join, used: &mut [bool]) {
        for bit in self.signals.iter().flat_map(|n| n.bus.bits()) {
            used[bit as usize] = true;
        }
        let floats = |join: &Join, bit: u32| used[bit as usize] && !join.is_driven(bit);
        let mut at = 0;
        while at < self.bits {
            let from = at;
            while at < self.bits && floats(join, at) {
                at += 1;
            }
            if at > from {
                let bus = Bus { parts: vec![Part { bit: from, width: at - from }] };
                self.tie(join, ScopeId(0), bus, Logic::Z);
            }
            at += 1;
        }
        join.cells = self.cells.len();
    }

    /// Drives bits that nothing else does.
    fn tie(&mut self, join: &mut Join, scope: ScopeId, bus: Bus, bit: Logic) {
        let kind = CellKind::Constant(Box::new(Value::repeat(bit, bus.width())));
        join.first_outputs.push(NetId::new(join.nets.len()));
        join.drive(&bus, bus.width(), Driver::Cell(CellId::new(self.cells.len()), 0), false);
        let element = kind.element();
        self.cells.push(Draft { kind, element, name: UNDRIVEN.into(), scope, inputs: vec![], outputs: vec![bus] });
    }
}
