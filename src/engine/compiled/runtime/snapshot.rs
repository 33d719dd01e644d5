//! The whole state in the netlist's numbers, and back.

use super::state::Source;
use super::{CompiledEngine, bit_of};
use crate::Engine;
use crate::netlist::NetId;
use crate::snapshot::{RunningClock, Snapshot, SnapshotError};
use crate::value::Word;
use crate::value::word::words;

/// The values of nets in a saved state.
struct Nets<'s> {
    start: Vec<usize>,
    words: &'s [Word],
}

impl<'s> Nets<'s> {
    fn get(&self, net: NetId) -> &'s [Word] {
        &self.words[self.start[net.index()]..self.start[net.index() + 1]]
    }
}

impl CompiledEngine {
    pub(crate) fn snapshot(&self) -> Snapshot {
        let settled = !self.settling.touched && self.clocks.pending.is_none();
        let mut nets: Vec<Word> = Vec::new();
        for net in self.netlist.net_ids() {
            // before the first phase, and where something waits for one, what is not held is computed anew anyhow
            nets.extend_from_slice(self.read(net));
        }
        let start = self.starts();
        if let Some((slot, level)) = self.clocks.pending {
            let net = self.layout.leaf_net[(slot - self.layout.leaves.start) as usize];
            nets[start[net.index()]] = Word::known(level.into());
        }
        let clock = |c: &Source| RunningClock {
            net: self.layout.leaf_net[(c.slot - self.layout.leaves.start) as usize],
            clock: c.clock,
            high: c.high,
            next: c.next,
        };
        let edge = |(pin, &old): (&crate::compiled::lower::layout::ClockPin, &Word)| {
            let word = nets[start[pin.bit.net.index()] + pin.bit.lo as usize / 64];
            (bit_of(word, pin.bit.lo % 64) != old).then_some((pin.bit.net, pin.bit.lo, old))
        };
        let mut control_seen = vec![false; self.layout.control_pins.len()];
        for (&seen, (_, pins)) in self.diagnostics.seen.iter().zip(&self.layout.controls) {
            pins.iter().for_each(|&pin| control_seen[pin as usize] = seen);
        }
        let contents = self.layout.memories.iter().filter_map(|m| Some((m.cell, self.held_contents(m.cell)?.to_vec())));
        Snapshot {
            netlist: self.netlist.fingerprint(),
            now: self.clocks.now,
            started: self.settling.started,
            settled: settled && self.settling.started,
            edges: match self.settling.started {
                true => self.layout.pins.iter().zip(&self.settling.pins_before).filter_map(edge).collect(),
                false => Vec::new(),
            },
            contents: contents.collect(),
            clocks: self.clocks.sources.iter().map(clock).collect(),
            delays: Vec::new(),
            control_seen,
            reported: self.diagnostics.reported.clone(),
            forces: Vec::new(),
            nets,
        }
    }

    /// Where the words of each net begin in a saved state, and after the last where they end.
    fn starts(&self) -> Vec<usize> {
        let mut end = 0;
        let mut start = vec![0];
        start.extend(self.netlist.nets().iter().map(|net| {
            end += words(net.width);
            end
        }));
        start
    }

    /// Goes on from a saved state; see [`Engine::restore`].
    pub(crate) fn take_up(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        from.check(&self.netlist)?;
        let before: Vec<(NetId, Vec<Word>)> =
            self.observation.nets.iter().map(|&net| (net, self.read(net).to_vec())).collect();
        self.reference.rest();
        if !from.forces.is_empty() || !from.settled {
            // the event engine takes what is under way
            self.reference().restore(from)?;
        } else {
            self.load(from);
        }
        for (number, (net, before)) in before.into_iter().enumerate() {
            if from.started && self.read(net) != &before[..] {
                match self.reference.active_mut() {
                    Some(engine) => engine.list_change(net),
                    None => self.observation.note(number),
                }
            }
        }
        Ok(())
    }

    /// Goes on from a saved state in which nothing is forced, of this netlist.
    pub(crate) fn load(&mut self, from: &Snapshot) {
        let nets = Nets { start: self.starts(), words: &from.nets };
        self.on_demand.clear();
        for net in self.netlist.net_ids() {
            // of what has no place of its own there is nothing to keep
            let Some(slot) = self.layout.slot[net.index()] else { continue };
            let value = nets.get(net);
            self.memory[slot.index()..][..value.len()].copy_from_slice(value);
        }
        self.take_contents(from, |net| nets.get(net));
        self.memory[0] = Word::ZERO;
        self.variants.current = None;
        self.variants.guard_failed = false;
        self.variants.stale = false;
        self.clocks.now = from.now;
        self.clocks.pending = None;
        self.settling.touched = !from.settled;
        self.settling.active.clear();
        self.settling.endless.clear();
        self.settling.started = from.started;
        self.settling.first = !from.started;
        for (pin, before) in self.layout.pins.iter().zip(&mut self.settling.pins_before) {
            *before = bit_of(nets.get(pin.bit.net)[pin.bit.lo as usize / 64], pin.bit.lo % 64);
        }
        for (seen, (_, pins)) in self.diagnostics.seen.iter_mut().zip(&self.layout.controls) {
            *seen = pins.first().is_some_and(|&pin| from.control_seen.get(pin as usize) == Some(&true));
        }
        self.diagnostics.reported.fill(false);
        let n = from.reported.len().min(self.diagnostics.reported.len());
        self.diagnostics.reported[..n].copy_from_slice(&from.reported[..n]);
        self.clocks.sources.clear();
        for c in &from.clocks {
            let slot = self.layout.slot[c.net.index()].expect("an input has a place");
            self.clocks.sources.push(Source { slot, clock: c.clock, high: c.high, next: c.next });
        }
        self.clocks.schedule();
        self.observation.clear();
    }
}
