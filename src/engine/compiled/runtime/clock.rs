//! Edges of inputs as straight code, and the loop of a clock; what they leave to evaluation phases.

use crate::Unsettled;
use crate::compiled::ir::places::Slot;
use crate::compiled::lower::layout::StateLayout;
use crate::compiled::passes::edge::Watched;
use crate::compiled::runtime::cycle::SHORT;
use crate::compiled::runtime::state::Diagnostics;
use crate::compiled::runtime::tracing::Times;
use crate::compiled::runtime::variants::{FUNCTION_SIZE, Request};
use crate::compiled::runtime::{BAIL_OUTS, CompiledEngine, MOST_WAITING, NEVER, bit_of};
use crate::value::Word;

/// The controls among those that may be unknown that have something to tell yet.
fn watched(layout: &StateLayout, seen: &[bool], reported: &[bool], doubtful: &[u32]) -> Vec<Watched> {
    let all = doubtful.iter().map(|&number| (number as usize, &layout.controls[number as usize]));
    let silent = |pins: &[u32]| pins.iter().all(|&p| reported[layout.control_pins[p as usize].cell.index()]);
    let all = all.filter(|(_, control)| !silent(&control.1));
    all.map(|(number, control)| Watched { bit: control.0, seen: seen[number] }).collect()
}

impl CompiledEngine {
    /// Changes an input of one bit to and fro, up to `most` times (which is odd, or it goes back to where it was), until
    /// an observed net changes, as straight code. `at` is when it does so first and how long it then stays 0 and 1. How many
    /// times it did, and whether it can do so at all.
    pub(crate) fn run_edges(&mut self, slot: Slot, level: bool, most: u64, at: Times) -> Option<u64> {
        let number = self
            .variants
            .current
            .filter(|_| !self.variants.guard_failed && !self.settling.touched && self.observation.prepared)?;
        if self.memory[slot.index()] != Word::known((!level).into()) {
            return None;
        }
        let variant = &mut self.variants.list[number];
        if variant.phases < variant.warm || self.settling.first {
            return None;
        }
        // where some state is unknown, that may become less
        let most = match variant.breadth() {
            0 => most,
            _ => most.min(self.variants.guards.pause() / 2 * 2 + most % 2),
        };
        // borrows less than `wanted` does
        let shapes = self.observation.tracing.log.shapes.len();
        let request = Request {
            layout: &self.layout,
            kept: &self.observation.kept,
            shared: self.variants.shared,
            partition: self.variants.partition_size,
            shapes,
        };
        let buses = variant.buses.clone();
        let mut end = self.memory.len() as u32;
        let Diagnostics { seen, reported, report, .. } = &mut self.diagnostics;
        let watched = |doubtful: &[u32]| watched(&self.layout, seen, reported, doubtful);
        let made = variant.edge_loops(&self.netlist, &request, slot, &watched, &mut end)?;
        if made.waiting > 0 {
            made.waiting -= 1;
            return None;
        }
        self.memory.resize(end as usize, Word::ZERO);
        self.observation.tracing.log.shapes.append(&mut made.shapes);
        let net = self.layout.leaf_net[(slot - self.layout.leaves.start) as usize];
        let observed = self.observation.number[net.index()].filter(|&bit| self.observation.stops[bit as usize]);
        let room = self.observation.tracing.begin(&mut self.memory, self.variants.shared.log, made.longest, at);
        let done = if level && most >= 2 && observed.is_none() {
            let rounds = room.min(most / 2);
            let packed = match rounds {
                // what is traced is written down by the edges
                SHORT.. if self.variants.shared.log.is_none() => {
                    made.cycle(&buses, self.variants.partition_size * FUNCTION_SIZE, &mut end).map_or(0, |p| {
                        self.memory.resize(end as usize, Word::ZERO);
                        p.run(&mut self.memory, rounds)
                    })
                }
                _ => 0,
            };
            report.packed += 2 * packed;
            2 * packed + if packed < rounds { made.edge_loop.run(&mut self.memory, rounds - packed) } else { 0 }
        } else {
            made.single[usize::from(level)].run(&mut self.memory, 1)
        };
        if done == 0 {
            // what it met it cannot do as straight code
            report.bail_outs += 1;
            made.bail_outs += 1;
            made.patience = (2 * made.patience + 1).min(MOST_WAITING);
            made.waiting = made.patience / 2;
            if made.bail_outs >= BAIL_OUTS {
                made.bail_outs = 0;
                let old = made.watched.clone();
                if watched(&variant.doubtful) != old {
                    variant.renew_edges(slot);
                }
            }
            return None;
        }
        made.patience = 0;
        report.straight += done;
        self.on_demand.clear();
        let level = level ^ (done % 2 == 0);
        self.memory[slot.index()] = Word::known(level.into());
        self.variants.stale = true;
        for (watch, &(slot, shift)) in self.settling.pins_before.iter_mut().zip(&self.settling.pins) {
            *watch = bit_of(self.memory[slot.index()], shift);
        }
        if observed.is_some() {
            self.observation.list(net);
        }
        self.list_changes();
        self.count(done);
        if self.memory[0].v != 0 {
            self.memory[0].v = 0;
            self.variants.guard_failed = true;
        }
        Some(done)
    }

    /// One phase after an input of one bit has changed.
    pub(crate) fn run_edge(&mut self, slot: Slot, level: bool) -> Result<(), Unsettled> {
        let at = Times { first: self.clocks.now, low: 0, high: 0 };
        if self.run_edges(slot, level, 1, at).is_none() {
            self.put_input(slot, Word::known(level.into()));
            return self.phase();
        }
        self.after_edges()
    }

    /// Goes on from edges: what they made unknown is seen to.
    pub(crate) fn after_edges(&mut self) -> Result<(), Unsettled> {
        if self.variants.guard_failed {
            return self.phase();
        }
        self.improve();
        Ok(())
    }

    /// Whether the one clock that is due next is the only one there is, and runs as straight code; then it does, up to edge
    /// `until`.
    pub(crate) fn run_clock(&mut self, until: u64) -> Result<bool, Unsettled> {
        let due = self.clocks.sources.iter().filter(|c| c.next == self.clocks.next).count();
        if due != 1 || self.clocks.pending.is_some() {
            return Ok(false);
        }
        let Some(c) = self.clocks.sources.iter().find(|c| c.next == self.clocks.next) else { return Ok(false) };
        let (slot, level, clock, next) = (c.slot, !c.high, c.clock, c.next);
        // whole periods from the rising edge on, as long as no other clock is due
        let end = match self.clocks.sources.len() {
            1 => until,
            _ => next,
        };
        let most =
            if level && end - next >= clock.high { 2 * ((end - next - clock.high) / clock.period + 1) } else { 1 };
        let at = Times { first: next, low: clock.period - clock.high, high: clock.high };
        let Some(done) = self.run_edges(slot, level, most.min(1 << 20), at) else { return Ok(false) };
        // the last of them
        let last = match (level, done) {
            (true, n) if n % 2 == 0 => next + (n / 2 - 1) * clock.period + clock.high,
            (true, n) => next + n / 2 * clock.period,
            (false, _) => next,
        };
        self.clocks.now = last;
        let high = level ^ (done % 2 == 0);
        let wait = if high { clock.high } else { clock.period - clock.high };
        for c in self.clocks.sources.iter_mut().filter(|c| c.slot == slot) {
            (c.high, c.next) = (high, last.saturating_add(wait));
        }
        self.clocks.schedule();
        self.after_edges()?;
        Ok(true)
    }

    /// Makes the clock edges of edge `now`.
    pub(crate) fn fire(&mut self) {
        self.clocks.next = NEVER;
        for i in 0..self.clocks.sources.len() {
            let c = &mut self.clocks.sources[i];
            if c.next == self.clocks.now {
                c.high = !c.high;
                let wait = if c.high { c.clock.high } else { c.clock.period - c.clock.high };
                c.next = self.clocks.now.saturating_add(wait);
                let (slot, level) = (c.slot, Word::known(u64::from(c.high)));
                self.put_input(slot, level);
            }
            self.clocks.next = self.clocks.next.min(self.clocks.sources[i].next);
        }
    }
}
