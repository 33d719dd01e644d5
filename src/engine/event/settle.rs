//! One evaluation phase: combinational operations settle, then storage cells whose clock made its edge sample
//! together, and again until nothing changes.

use super::eval::{State, bit_of};
use super::program::Program;
use crate::cell::memory::merged;
use crate::endless;
use crate::value::Word;

/// An evaluation phase that does not end.
#[derive(Debug, Default)]
pub(super) struct Oscillation {
    /// Slots that keep changing.
    pub slots: Vec<u32>,
    pub clocked: bool,
}

/// The state, what is to become of it, and of parts of it.
type Sampled = (Vec<Word>, Vec<(u32, Word)>, Vec<(u32, u64, Word)>);

/// Steps of a feedback group before cycles are looked for. Honest feedback settles in about as many as the loop is long.
const PATIENCE: usize = 64;

impl State {
    pub fn settle(&mut self, p: &Program) -> Result<(), Oscillation> {
        let mut rounds = 0;
        let mut back = endless::Return::new();
        loop {
            self.combinational(p)?;
            if self.pending.is_empty() {
                self.first = false;
                return Ok(());
            }
            self.edges(p);
            rounds += 1;
            if rounds > endless::HONEST_ROUNDS
                && (rounds >= endless::ROUNDS || back.has(|kept| self.is_sampled(kept), || self.sampled()))
            {
                return Err(self.clock_oscillation(p));
            }
            self.take(p);
        }
    }

    /// Runs dirty operations in order until there are none. Feedback that never settles is reported after all others
    /// have run, so that what is reported does not depend on which loop comes first; to those after it what keeps
    /// changing is x.
    #[inline(always)]
    fn combinational(&mut self, p: &Program) -> Result<(), Oscillation> {
        let mut found: Option<Oscillation> = None;
        while let Some(s) = self.summary.iter().position(|&word| word != 0) {
            while self.summary[s] != 0 {
                let word = s * 64 + self.summary[s].trailing_zeros() as usize;
                loop {
                    let bits = self.dirty[word];
                    if bits == 0 {
                        break;
                    }
                    let op = &p.ops[word * 64 + bits.trailing_zeros() as usize];
                    match op.group {
                        0 => {
                            self.dirty[word] = bits & (bits - 1);
                            self.run::<false>(p, op);
                        }
                        group => {
                            if let Err(one) = self.feedback(p, group as usize - 1) {
                                found.get_or_insert_default().slots.extend(one.slots);
                            }
                        }
                    }
                }
                self.summary[s] &= !(1 << (word % 64));
            }
        }
        found.map_or(Ok(()), Err)
    }

    /// Collects and clears the dirty operations of a group.
    fn collect(&mut self, p: &Program, group: usize) {
        self.batch.clear();
        let range = &p.groups[group];
        for word in range.start / 64..=(range.end - 1) / 64 {
            let low = if word == range.start / 64 { !0 << (range.start % 64) } else { !0 };
            let high = if word == (range.end - 1) / 64 { !0 >> (63 - (range.end - 1) % 64) } else { !0 };
            let mut bits = self.dirty[word] & low & high;
            self.dirty[word] &= !bits;
            while bits != 0 {
                self.batch.push((word * 64) as u32 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
    }

    /// One step of a group; all its operations see the values before it. Returns whether there was anything to do.
    fn step(&mut self, p: &Program, group: usize) -> bool {
        // bringing bits together is wiring and takes no step
        for &number in &p.group_gathers[group] {
            let (word, bit) = (number as usize / 64, 1 << (number % 64));
            if self.dirty[word] & bit != 0 {
                self.dirty[word] &= !bit;
                self.run::<false>(p, &p.ops[number as usize]);
            }
        }
        self.collect(p, group);
        for i in 0..self.batch.len() {
            self.run::<true>(p, &p.ops[self.batch[i] as usize]);
        }
        self.take(p);
        !self.batch.is_empty()
    }

    /// Iterates a feedback group until it settles, or until its state repeats (Brent's cycle detection), which is proof
    /// that it never will.
    fn feedback(&mut self, p: &Program, group: usize) -> Result<(), Oscillation> {
        for _ in 0..PATIENCE {
            if !self.step(p, group) {
                return Ok(());
            }
        }
        let slots = &p.group_slots[group];
        let mut back = endless::Return::new();
        let mut came_back = false;
        for _ in 1..endless::steps(slots.len()) {
            if !self.step(p, group) {
                return Ok(());
            }
            let is = |kept: &Vec<Word>| slots.iter().zip(kept).all(|(at, w)| self.slots[at.0 as usize] == *w);
            if back.has(is, || slots.iter().map(|at| self.slots[at.0 as usize]).collect()) {
                // the last step before it has settled changes nothing either, and leaves nothing to do
                if !self.step(p, group) {
                    return Ok(());
                }
                came_back = true;
                break;
            }
        }
        Err(self.gate_oscillation(p, group, came_back))
    }

    /// The slots of a group that keep changing. Where it stands depends on how long it was looked at, and nothing that comes
    /// after may see that: the bits that keep changing become x, all of them if it has only taken too many steps.
    fn gate_oscillation(&mut self, p: &Program, group: usize, came_back: bool) -> Oscillation {
        let slots = &p.group_slots[group];
        let now = |s: &State| -> Vec<Word> { slots.iter().map(|at| s.slots[at.0 as usize]).collect() };
        let changing = if came_back {
            endless::changing(&now(self), || {
                self.step(p, group);
                now(self)
            })
        } else {
            slots.iter().map(|at| at.1).collect()
        };
        for (&(slot, _), &bits) in slots.iter().zip(&changing) {
            self.put(p, slot, self.slots[slot as usize].with_x(bits));
        }
        for _ in 0..endless::SPREADING {
            if !self.step(p, group) {
                break;
            }
        }
        self.collect(p, group);
        let slots = slots.iter().zip(changing).filter(|(_, bits)| *bits != 0).map(|(at, _)| at.0).collect();
        Oscillation { slots, clocked: false }
    }

    /// All that decides how a phase goes on once the cells have sampled.
    fn sampled(&self) -> Sampled {
        (self.slots.clone(), self.staged.clone(), self.memories.parts.clone())
    }

    /// Whether it is this. Contents of memories that have changed since make it another: a slot counts their changes.
    fn is_sampled(&self, (slots, staged, parts): &Sampled) -> bool {
        self.slots == *slots && self.staged == *staged && self.memories.parts == *parts && !self.memories.writes()
    }

    /// The slots that clocked cells keep changing, until all is as it was.
    fn clock_oscillation(&mut self, p: &Program) -> Oscillation {
        let mut slots = Vec::new();
        let start = self.sampled();
        for _ in 0..endless::SHOWN_ROUNDS {
            slots.extend(self.staged.iter().filter(|(slot, new)| self.slots[*slot as usize] != *new).map(|s| s.0));
            let read = self.memories.parts.iter();
            slots.extend(
                read.filter(|r| merged(self.slots[r.0 as usize], r.1, r.2) != self.slots[r.0 as usize]).map(|r| r.0),
            );
            self.take(p);
            if self.combinational(p).is_err() {
                break;
            }
            self.edges(p);
            if self.is_sampled(&start) {
                break;
            }
        }
        slots.sort_unstable();
        slots.dedup();
        Oscillation { slots, clocked: true }
    }

    /// Finds the edges made since the last time, and stages what the cells clocked by them take.
    #[inline(always)]
    fn edges(&mut self, p: &Program) {
        for i in 0..self.pending.len() {
            let number = self.pending[i] as usize;
            let pin = &p.clocks[number];
            let new = bit_of(self.slots[pin.slot as usize], pin.shift);
            let watch = &mut self.watches[number];
            watch.pending = false;
            let old = std::mem::replace(&mut watch.old, new).read();
            let new = new.read();
            if self.first {
                // nothing has been there before it; a control that acts when it becomes active does if it is from the start
                if pin.level && !old.is_one() && new.is_one() {
                    for &store in &pin.rising {
                        self.sample(p, store);
                    }
                }
                continue;
            }
            let list = if old == new {
                continue;
            } else if old.is_zero() || new.is_one() {
                &pin.rising
            } else {
                &pin.falling
            };
            for &store in list {
                self.sample(p, store);
            }
            if old.is_zero() && new.u != 0 {
                for &store in &pin.unknown {
                    self.sample(p, store);
                }
            }
        }
        self.pending.clear();
        if !self.memories.edges.is_empty() {
            self.sample_memories(p);
        }
    }
}
