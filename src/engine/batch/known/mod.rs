//! The known form: what a block runs in while nothing in it is x or z.
//!
//! An instant is rounds: inputs have changed, or stores have been clocked; then all that depends on them is computed by
//! straight code, whether it changes or not, and edges are looked for. What a round computes depends on what set it off
//! alone, so it is made once. Nets that nobody asks for and that no other round reads are not stored at all.
//!
//! What cells do is in `cells`, as functions of `logic`; `tape` makes code of them and `machine` runs it. Where x comes
//! of known operands a guard says so, before anything has been clocked: the form is left, and the general one goes on.

mod cells;
mod layout;
mod logic;
mod machine;
mod registers;
mod round;
mod tape;

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::Arc;

use pulp::Arch;

use super::compaction::Compaction;
use super::lanes::{Chunk, Four, LANES};
use super::program::Program;
use super::state::State;
use crate::netlist::NetId;

pub(super) use layout::Layout;
pub use logic::{Lit, Logic};
pub use registers::{Bits, Registers, Rules};
use round::Round;

/// Rounds of an instant after which the general form decides.
const PATIENCE: usize = 256;
/// Kinds of rounds that are kept. Beyond them one does for all.
const KINDS: usize = 128;

/// Things that set off rounds: edges at the bits that are watched, and changes of inputs.
pub(super) type Events = u128;

/// A block in the known form, or not.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// Whether it is.
    pub on: bool,
    /// The inputs that have changed.
    pub pending: Events,
    rounds: HashMap<Events, Arc<Round>>,
    /// Instants that ran so to their end.
    pub instants: u64,
}

impl Known {
    /// An input may have changed.
    pub fn change(&mut self, p: &Program, net: NetId, changed: bool) {
        if let (Some(layout), Some(&number), true) = (&p.known, p.input_of.get(&net), changed) {
            self.pending |= layout.input(number);
        }
    }
}

impl State {
    /// Takes the known form if all lanes that run are known.
    pub fn enter(&mut self, p: &Program) {
        let Some(layout) = &p.known else { return };
        let unknown = |&bit: &u32| {
            self.planes.may_be_unknown(bit) && {
                let plane = self.planes.plane::<false>(bit);
                self.active.iter().enumerate().any(|(c, &active)| (plane.get(c).u & active).any())
            }
        };
        if layout.sources.iter().chain(&layout.blurred).any(unknown) {
            return;
        }
        // What lanes hold that do not run is of no account. Constants that are x stay so: nothing here reads them.
        for bit in 0..p.bits() as u32 {
            if !p.constant[bit as usize] && self.planes.may_be_unknown(bit) {
                let plane = self.planes.plane::<false>(bit);
                self.planes.write::<false>(bit, |c| Four::known(plane.get(c).ones()));
            }
        }
        self.planes.reserve(layout.scratch as usize);
        self.settle_watches(p, layout);
        self.known.on = true;
        self.known.pending = 0;
    }

    /// Watched bits are from now on as they stand.
    fn settle_watches(&mut self, p: &Program, layout: &Layout) {
        for (number, watch) in p.watches.iter().enumerate() {
            for c in 0..self.planes.chunks {
                let now = self.planes.raw(watch.bit, c).get();
                self.planes.raw(layout.old(number), c).set(now);
            }
        }
    }

    /// Goes on in the general form: everything that is computed is to be computed anew.
    pub fn leave(&mut self, p: &Program) {
        let Some(layout) = p.known.as_ref().filter(|_| self.known.on) else { return };
        self.known.on = false;
        self.pending.clear();
        for number in 0..p.watches.len() {
            self.watched[number].pending = true;
            self.pending.push(number as u32);
            for c in 0..self.planes.chunks {
                let old = self.planes.raw(layout.old(number), c).get();
                self.watched[number].recall(c, old);
            }
        }
        self.run_all(p);
    }

    /// Takes lanes of another block, which is in the known form too, as they stand: those that run there run here.
    pub fn adopt(&mut self, p: &Program, arch: Arch, from: &State, compaction: &Compaction) -> bool {
        let Some(layout) = &p.known else { return false };
        if !self.known.on {
            self.enter(p);
        }
        if !self.known.on || !from.known.on {
            return false;
        }
        let chunks = self.planes.chunks;
        for &bit in &layout.sources {
            carry(compaction, from.planes.values(bit), self.planes.values(bit));
        }
        let runs = |word: usize| from.active.get(word / WORDS).map_or(0, |chunk| chunk.0[word % WORDS]);
        compaction.carry(runs, |word, mask, bits| {
            let active = &mut self.active[word / WORDS].0[word % WORDS];
            *active = *active & !mask | bits;
            self.unsettled[word / WORDS].0[word % WORDS] &= !mask;
        });
        let round = self.round(p, layout, Events::MAX);
        let settles = machine::play(arch, &round.settled, self.planes.all(), chunks, &self.active);
        self.settle_watches(p, layout);
        if !settles {
            self.leave(p);
        }
        true
    }

    /// An instant in the known form. False if it has been left before the end.
    pub fn settle_known(&mut self, p: &Program, arch: Arch) -> bool {
        let Some(layout) = &p.known else { return false };
        for _ in 0..PATIENCE {
            let events = std::mem::take(&mut self.known.pending);
            if events == 0 {
                self.known.instants += 1;
                return true;
            }
            let round = self.round(p, layout, events);
            let (planes, chunks) = (&self.planes, self.planes.chunks);
            let mut settles = machine::play(arch, &round.sampled, planes.all(), chunks, &self.active);
            for &trigger in &round.triggers {
                (0..chunks).for_each(|c| planes.raw(trigger, c).set(Chunk::ZERO));
            }
            settles &= machine::play(arch, &round.settled, planes.all(), chunks, &self.active);
            self.evaluated += round.sampled.functions + round.settled.functions;
            let guarded =
                round.guarded && (0..chunks).any(|c| (planes.raw(layout.guard, c).get() & self.active[c]).any());
            if !settles || guarded {
                break;
            }
            for &number in &round.watches {
                let bit = p.watches[number as usize].bit;
                let (mut rose, mut fell) = (Chunk::ZERO, Chunk::ZERO);
                let [rising, falling] = [true, false].map(|rising| layout.trigger(number as usize, rising));
                for c in 0..chunks {
                    let now = planes.raw(bit, c).get();
                    let moved = (now ^ planes.raw(layout.old(number as usize), c).replace(now)) & self.active[c];
                    planes.raw(rising, c).set(moved & now);
                    planes.raw(falling, c).set(moved & !now);
                    rose |= moved & now;
                    fell |= moved & !now;
                }
                for (any, rising) in [(rose, true), (fell, false)] {
                    if any.any() {
                        self.known.pending |= layout.event(number as usize, rising);
                    }
                }
            }
            self.known.pending &= layout.clocking;
        }
        self.leave(p);
        false
    }

    fn round(&mut self, p: &Program, layout: &Layout, events: Events) -> Arc<Round> {
        let events = match self.known.rounds.contains_key(&events) || self.known.rounds.len() < KINDS {
            true => events,
            false => Events::MAX,
        };
        let round = self.known.rounds.entry(events).or_insert_with(|| Arc::new(Round::new(p, layout, events)));
        self.planes.reserve((layout.scratch + round.scratch()) as usize);
        round.clone()
    }
}

const WORDS: usize = LANES / 64;

/// Moves lanes of a plane to another.
fn carry(compaction: &Compaction, from: &[Cell<Chunk>], to: &[Cell<Chunk>]) {
    let word = |word: usize| from.get(word / WORDS).map_or(0, |chunk| chunk.get().0[word % WORDS]);
    compaction.carry(word, |word, mask, bits| {
        let place = &to[word / WORDS];
        let mut chunk = place.get();
        chunk.0[word % WORDS] = chunk.0[word % WORDS] & !mask | bits;
        place.set(chunk);
    });
}
