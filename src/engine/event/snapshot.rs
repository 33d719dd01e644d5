//! The whole state in the netlist's numbers, and back.

use super::EventEngine;
use super::eval::{State, Watch, bit_of};
use super::program::{ClockPin, Code, Program, flag};
use crate::netlist::NetId;
use crate::snapshot::{RunningClock, Snapshot, SnapshotError};
use crate::value::Word;
use crate::value::word::{mask, words};

impl State {
    /// Computes the slots that only bring bits together, which are of no net.
    fn gather(&mut self, p: &Program) {
        for op in p.ops.iter().filter(|op| op.code == Code::Gather) {
            let (mut at, mut all) = (0, Word::ZERO);
            for &(o, width) in &p.pool[op.ext as usize..(op.ext + op.count) as usize] {
                let w = self.read(o, mask(width));
                all = Word { v: all.v | w.v << at, u: all.u | w.u << at };
                at += width;
            }
            self.slots[op.y as usize] = all;
        }
    }

    /// Whether nothing is under way.
    fn is_settled(&self) -> bool {
        self.summary.iter().all(|&word| word == 0) && self.pending.is_empty() && self.delayed.is_empty()
    }

    /// Goes on after the first phase. If all has settled nothing is under way; if not, everything is looked at again.
    fn go_on(&mut self, p: &Program, settled: bool) {
        self.first = false;
        self.pending.clear();
        if settled {
            self.dirty.fill(0);
            self.summary.fill(0);
            self.delayed.clear();
        } else {
            self.doubtful.extend(p.controls.iter().map(|c| c.slot));
        }
        for (watch, pin) in self.watches.iter_mut().zip(&p.clocks) {
            watch.old = bit_of(self.slots[pin.slot as usize], pin.shift);
            watch.pending = false;
        }
        self.memories.forget();
    }
}

impl EventEngine {
    pub(super) fn snapshot(&self) -> Snapshot {
        let nets = self.program.net_slot[0]..self.program.net_slot[self.widths.len()];
        let net = |slot: u32| NetId(self.program.slot_net[slot as usize]);
        let clock = |(slot, clock, high, next)| RunningClock { net: net(slot), clock, high, next };
        let memories = self.program.memories.iter().enumerate();
        let force = |(&slot, &held): (&u32, &_)| {
            let net = net(slot);
            (net, slot - self.program.net_slot[net.index()], held)
        };
        let pending = self.state.pending.iter().map(|&number| {
            let pin = &self.program.clocks[number as usize];
            let net = net(pin.slot);
            let bit = (pin.slot - self.program.net_slot[net.index()]) * 64 + u32::from(pin.shift);
            (net, bit, self.state.watches[number as usize].old)
        });
        let mut forces: Vec<_> = self.state.forces.iter().map(force).collect();
        forces.sort_unstable_by_key(|f| (f.0, f.1));
        Snapshot {
            netlist: self.netlist.fingerprint(),
            now: self.now,
            started: self.started,
            settled: self.state.is_settled(),
            edges: pending.collect(),
            nets: self.state.slots[nets.start as usize..nets.end as usize].to_vec(),
            contents: memories.map(|(i, m)| (m.cell, self.state.memories.contents(i).to_vec())).collect(),
            clocks: self.queue.sources().map(clock).collect(),
            delays: self.queue.save(),
            control_seen: self.state.control_seen.clone(),
            reported: self.state.reported.clone(),
            forces,
        }
    }

    pub(super) fn resume(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        from.check(&self.netlist)?;
        let first = self.program.net_slot[0] as usize;
        let observed: Vec<NetId> = self.observed().collect();
        let old = |state: &State, net: NetId| {
            let slot = self.program.net_slot[net.index()] as usize;
            state.slots[slot..slot + words(self.widths[net.index()])].to_vec()
        };
        let before: Vec<Vec<Word>> = observed.iter().map(|&net| old(&self.state, net)).collect();
        let events = self.state.events;
        self.state = State::new(&self.program);
        self.queue = super::queue::Queue::new(&self.program);
        (self.now, self.started) = (from.now, from.started);
        if from.started {
            self.state.slots[first..first + from.nets.len()].copy_from_slice(&from.nets);
            self.state.gather(&self.program);
            self.state.go_on(&self.program, from.settled);
            for &(net, bit, old) in &from.edges {
                let slot = self.program.net_slot[net.index()] + bit / 64;
                let at = |p: &ClockPin| p.slot == slot && u32::from(p.shift) == bit % 64;
                for (number, _) in self.program.clocks.iter().enumerate().filter(|(_, p)| at(p)) {
                    self.state.watches[number] = Watch { old, pending: true };
                    self.state.pending.push(number as u32);
                }
            }
        } else {
            // what has been driven so far; the rest is computed when the circuit first settles
            for (slot, &word) in (first as u32..).zip(&from.nets) {
                self.state.put(&self.program, slot, word);
            }
        }
        for (cell, held) in &from.contents {
            if let Some(number) = self.program.memories.iter().position(|m| m.cell == *cell) {
                self.state.memories.contents_mut(number).clone_from(held);
            }
        }
        let clock = |c: &RunningClock| (self.program.net_slot[c.net.index()], c.clock, c.high, c.next);
        let clocks = from.clocks.iter().map(clock).collect();
        self.queue.restore(clocks, &from.delays);
        let n = self.state.control_seen.len().min(from.control_seen.len());
        self.state.control_seen[..n].copy_from_slice(&from.control_seen[..n]);
        let n = self.state.reported.len().min(from.reported.len());
        self.state.reported[..n].copy_from_slice(&from.reported[..n]);
        for &(net, word, held) in &from.forces {
            let slot = self.program.net_slot[net.index()] + word;
            self.state.forces.insert(slot, held);
            self.state.meta[slot as usize].flags |= flag::FORCED;
            self.state.forcing = true;
        }
        self.state.events = events;
        for (net, before) in observed.into_iter().zip(before) {
            crate::Engine::observe(self, net);
            let slot = self.program.net_slot[net.index()] as usize;
            if self.state.slots[slot..slot + before.len()] != before[..] && from.started {
                self.list_change(net);
            }
        }
        Ok(())
    }

    /// Lists an observed net as changed.
    pub(crate) fn list_change(&mut self, net: NetId) {
        let first = &mut self.state.meta[self.program.net_slot[net.index()] as usize];
        if first.flags & flag::CHANGED == 0 {
            first.flags |= flag::CHANGED;
            self.state.changes.push(net);
        }
    }

    /// Tells of these unknown controls first.
    #[cfg(feature = "compiled")]
    pub(crate) fn add_unknown_controls(&mut self, controls: Vec<crate::UnknownControl>) {
        self.state.unknown_controls = controls;
    }

    /// Whether another engine may go on: nothing is forced, under way, or waits to be looked at.
    #[cfg(feature = "compiled")]
    pub(crate) fn is_quiet(&self) -> bool {
        !self.state.forcing && self.started && self.state.is_settled() && !self.state.has_news()
    }
}
