//! What made what a port of a memory reads: its address, and of the writes to that word the last.

use super::History;
use super::explain::{Cause, Read, Step, chosen, is_edge};
use crate::Logic;
use crate::cell::pin::memory;
use crate::cell::{self, Edge};
use crate::netlist::{CellId, Netlist, Slice};

/// The part of a pin of a memory that is one port's.
fn port(netlist: &Netlist, cell: CellId, pin: usize, number: usize) -> Vec<Slice> {
    let kind = &netlist.cell(cell).kind;
    let ports = kind.inputs_of(pin).max(1);
    let width = kind.input_width(pin) / ports;
    let matter: Vec<bool> = (0..kind.input_width(pin)).map(|bit| bit / width.max(1) == number as u32).collect();
    chosen(netlist.input(cell, pin), &matter)
}

/// The latest edge of one port's clock, of those at which `takes` holds.
fn port_edge(history: &History, clock: &[Slice], edge: Edge, until: u64, takes: impl Fn(u64) -> bool) -> Option<u64> {
    let bit = *clock.first()?;
    let times = history.times(bit.net).rev().filter(|time| *time <= until);
    times.filter(|time| is_edge(history, bit, *time, edge)).find(|time| takes(*time))
}

/// What made what a memory's port reads.
pub(super) fn memory_read(netlist: &Netlist, history: &History, cell: CellId, m: &cell::Memory, step: &mut Step) {
    let number = (step.slice.lo / m.width) as usize;
    let spec = &m.reads[number];
    let pin = |pin: usize| port(netlist, cell, pin, number);
    let mut then = step.time;
    if let Some(edge) = spec.clock {
        let enable = pin(memory::RD_EN);
        let takes = |at: u64| history.joined(&enable, at - 1).bit(0) == Logic::One;
        match port_edge(history, &pin(memory::RD_CLK), edge, step.time, takes) {
            Some(at) => then = at - 1,
            None => {
                step.cause = Cause::Start(cell);
                return;
            }
        }
    }
    let slices = pin(memory::RD_ADDR);
    let address = history.joined(&slices, then);
    step.cause = Cause::Gate(cell);
    let unknown = !address.is_known();
    step.reads.push(Read { pin: "rd_addr", slices, value: address.clone(), time: then, matters: unknown });
    let Some(at) = address.to_u64().filter(|_| !unknown) else { return };
    // of the writes to this word the last
    let low = step.slice.lo % m.width;
    let mut last: Option<(u64, usize)> = None;
    for (number, write) in m.writes.iter().enumerate() {
        let pin = |pin: usize| port(netlist, cell, pin, number);
        let (address, enable) = (pin(memory::WR_ADDR), pin(memory::WR_EN));
        let writes = |time: u64| {
            let enabled = history.joined(&enable, time);
            history.joined(&address, time).to_u64() == Some(at)
                && (low..low + step.slice.width).any(|bit| enabled.bit(bit) == Logic::One)
        };
        let found = match write.clock {
            Some(edge) => port_edge(history, &pin(memory::WR_CLK), edge, then, |at| writes(at - 1)),
            None => history
                .times(enable.first().map_or(step.slice.net, |s| s.net))
                .rev()
                .find(|time| *time <= then && writes(*time)),
        };
        last = last.max(found.map(|time| (time, number)));
    }
    let word = at.wrapping_sub(m.offset as u64);
    match last {
        Some((time, number)) => {
            let clocked = m.writes[number].clock.is_some();
            let before = if clocked { time - 1 } else { time };
            step.cause = Cause::Written { cell, time, word };
            for (pin, name) in [(memory::WR_DATA, "wr_data"), (memory::WR_EN, "wr_en"), (memory::WR_ADDR, "wr_addr")] {
                let mut slices = port(netlist, cell, pin, number);
                if pin == memory::WR_DATA {
                    let matter: Vec<bool> =
                        (0..m.width).map(|bit| (low..low + step.slice.width).contains(&bit)).collect();
                    slices = chosen(&slices, &matter);
                }
                let value = history.joined(&slices, before);
                step.reads.push(Read { pin: name, slices, value, time: before, matters: pin == memory::WR_DATA });
            }
        }
        None if word < u64::from(m.size) => step.cause = Cause::Unwritten { cell, word },
        // beyond the memory: x of a known address
        None => {}
    }
}
