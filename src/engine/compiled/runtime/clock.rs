//! Ticks in one piece of code, and what they leave to the waves.

use crate::Unsettled;
use crate::compiled::ir::places::Slot;
use crate::compiled::passes::cycle::SHORT;
use crate::compiled::runtime::tracing::Times;
use crate::compiled::runtime::variants::{PIECE, Wanted};
use crate::compiled::runtime::{ABORTS, CompiledEngine, NEVER, PATIENCE, bit_of};
use crate::value::Word;

impl CompiledEngine<'_> {
    /// Changes an input of one bit to and fro, up to `most` times (which is odd, or it goes back to where it was), until
    /// an observed net changes, in one piece. `at` is when it does so first and how long it then stays 0 and 1. How many
    /// times it did, and whether it can do so at all.
    pub(crate) fn ticks(&mut self, slot: Slot, level: bool, most: u64, at: Times) -> Option<u64> {
        let number = self.current.filter(|_| !self.alarmed && !self.touched && self.prepared)?;
        if self.memory[slot.index()] != Word::known((!level).into()) {
            return None;
        }
        let form = &mut self.forms[number];
        if form.waves < form.warm || !form.doubtful.is_empty() || self.first {
            return None;
        }
        // where some state is unknown, that may become less
        let most = match &form.unknown {
            Some(list) if !list.is_empty() => most.min(2 * (self.looks.next / 2).max(PATIENCE / 2) + most % 2),
            _ => most,
        };
        // borrows less than `wanted` does
        let shapes = self.tracing.log.shapes.len();
        let wanted = Wanted { wiring: &self.wiring, kept: &self.kept, shared: self.shared, chunk: self.chunk, shapes };
        let buses = form.buses.clone();
        let mut end = self.memory.len() as u32;
        let made = form.ticks(self.netlist, &wanted, slot, &mut end)?;
        self.memory.resize(end as usize, Word::ZERO);
        self.tracing.log.shapes.append(&mut made.shapes);
        let net = self.wiring.leaf_net[(slot - self.wiring.leaves.start) as usize];
        let observed = self.observed[net.index()].filter(|&bit| self.stops[bit as usize]);
        let room = self.tracing.begin(&mut self.memory, self.shared.log, made.longest, at);
        let done = if level && most >= 2 && observed.is_none() {
            let rounds = room.min(most / 2);
            let packed = match rounds {
                // what is traced is written down by the ticks
                SHORT.. if self.shared.log.is_none() => {
                    made.period(&buses, self.chunk * PIECE, &mut end).map_or(0, |p| {
                        self.memory.resize(end as usize, Word::ZERO);
                        p.run(&mut self.memory, rounds)
                    })
                }
                _ => 0,
            };
            self.report.packed += 2 * packed;
            2 * packed + if packed < rounds { made.circle.run(&mut self.memory, rounds - packed) } else { 0 }
        } else {
            made.single[usize::from(level)].run(&mut self.memory, 1)
        };
        if done == 0 {
            // what it met it cannot do in one piece
            self.aborted += 1;
            if self.aborted > ABORTS {
                form.forget_ticks(slot);
                self.aborted = 0;
            }
            return None;
        }
        self.aborted = 0;
        self.peeked.clear();
        let level = level ^ (done % 2 == 0);
        self.memory[slot.index()] = Word::known(level.into());
        self.stale = true;
        for (watch, &(slot, shift)) in self.watches.iter_mut().zip(&self.pin_places) {
            *watch = bit_of(self.memory[slot.index()], shift);
        }
        if observed.is_some() {
            self.list_change(net);
        }
        self.list_changes();
        self.count(done);
        if self.memory[0].v != 0 {
            self.memory[0].v = 0;
            self.alarmed = true;
        }
        Some(done)
    }

    /// One wave after an input of one bit has changed.
    pub(crate) fn tick(&mut self, slot: Slot, level: bool) -> Result<(), Unsettled> {
        let at = Times { first: self.now, low: 0, high: 0 };
        if self.ticks(slot, level, 1, at).is_none() {
            self.put_input(slot, Word::known(level.into()));
            return self.wave();
        }
        self.after_ticks()
    }

    /// Goes on from ticks: what they made unknown is seen to.
    pub(crate) fn after_ticks(&mut self) -> Result<(), Unsettled> {
        if self.alarmed {
            return self.wave();
        }
        self.improve();
        Ok(())
    }

    /// Whether the one clock that is due next is the only one there is, and runs in one piece; then it does, up to tick
    /// `until`.
    pub(crate) fn run_clock(&mut self, until: u64) -> Result<bool, Unsettled> {
        let due = self.clocks.iter().filter(|c| c.next == self.next_clock).count();
        if due != 1 || self.pending.is_some() {
            return Ok(false);
        }
        let Some(c) = self.clocks.iter().find(|c| c.next == self.next_clock) else { return Ok(false) };
        let (slot, level, clock, next) = (c.slot, !c.high, c.clock, c.next);
        // whole periods from the rising edge on, as long as no other clock is due
        let end = match self.clocks.len() {
            1 => until,
            _ => next,
        };
        let most =
            if level && end - next >= clock.high { 2 * ((end - next - clock.high) / clock.period + 1) } else { 1 };
        let at = Times { first: next, low: clock.period - clock.high, high: clock.high };
        let Some(done) = self.ticks(slot, level, most.min(1 << 20), at) else { return Ok(false) };
        // the last of them
        let last = match (level, done) {
            (true, n) if n % 2 == 0 => next + (n / 2 - 1) * clock.period + clock.high,
            (true, n) => next + n / 2 * clock.period,
            (false, _) => next,
        };
        self.now = last;
        let high = level ^ (done % 2 == 0);
        let wait = if high { clock.high } else { clock.period - clock.high };
        for c in self.clocks.iter_mut().filter(|c| c.slot == slot) {
            (c.high, c.next) = (high, last.saturating_add(wait));
        }
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        self.after_ticks()?;
        Ok(true)
    }

    /// Makes the clock edges of tick `now`.
    pub(crate) fn fire(&mut self) {
        self.next_clock = NEVER;
        for i in 0..self.clocks.len() {
            let c = &mut self.clocks[i];
            if c.next == self.now {
                c.high = !c.high;
                let wait = if c.high { c.clock.high } else { c.clock.period - c.clock.high };
                c.next = self.now.saturating_add(wait);
                let (slot, level) = (c.slot, Word::known(u64::from(c.high)));
                self.put_input(slot, level);
            }
            self.next_clock = self.next_clock.min(self.clocks[i].next);
        }
    }
}
