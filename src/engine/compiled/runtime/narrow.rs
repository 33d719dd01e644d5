//! Which state is unknown, and when a variant is compiled for less of it.
//!
//! At the start registers fill one after another, so a variant for what is unknown at some moment would soon assume too
//! little. It is compiled when the unknown set has not shrunk for a while, and again when it has shrunk after all. The time
//! between two looks doubles, so that looks and variants cost little of a long run.

use crate::compiled::ir::places::{Slot, Slots};
use crate::compiled::runtime::{CompiledEngine, PATIENCE};

/// A variant is compiled anew when the unknown set has shrunk by at least one part in this many.
const FEWER: usize = 8;
/// The most phases between two looks at which state is unknown.
const FARTHEST: u64 = 1 << 22;

/// When state is looked at for what has become known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Looks {
    /// The phase from which on phases are counted, and after how many it is looked at next.
    pub from: u64,
    pub next: u64,
    /// How many words of state were unknown at the last look.
    pub unknown: usize,
}

impl Looks {
    pub fn from(wave: u64, next: u64) -> Looks {
        Looks { from: wave, next, unknown: usize::MAX }
    }
}

impl CompiledEngine {
    /// The first unknown slot of state from a place on, round to it.
    pub(crate) fn find_unknown(&self) -> Option<Slot> {
        let Slots { start, end } = self.layout.leaves;
        let is = |&slot: &Slot| self.memory[slot.index()].u != 0;
        let find = |start, end| Slots { start, end }.iter().find(is);
        find(self.variants.last_unknown, end).or_else(|| find(start, self.variants.last_unknown))
    }

    /// All unknown slots of state.
    pub(crate) fn all_unknown(&self) -> Vec<Slot> {
        self.layout.leaves.iter().filter(|&slot| self.memory[slot.index()].u != 0).collect()
    }

    /// Goes over to a faster variant if there is one for what has become known.
    pub(crate) fn improve(&mut self) {
        let Some(number) =
            self.variants.current.filter(|&n| self.variants.list[n].unknown.as_ref().is_none_or(|u| !u.is_empty()))
        else {
            return;
        };
        match self.find_unknown() {
            None => {
                let number = self.variant(Some(Vec::new()));
                self.enter(number);
            }
            Some(slot) => {
                self.variants.last_unknown = slot;
                self.narrow(number);
            }
        }
    }

    /// Now and then goes over to a variant that takes all to be known that is, as soon as that does not become more.
    fn narrow(&mut self, number: usize) {
        let phases = self.diagnostics.report.phases() - self.variants.looks.from;
        if phases < self.variants.looks.next {
            return;
        }
        let mut unknown = self.all_unknown();
        let fewer = unknown.len() < self.variants.looks.unknown;
        self.variants.looks = Looks { next: (2 * phases).min(FARTHEST), unknown: unknown.len(), ..self.variants.looks };
        if fewer {
            return;
        }
        match &self.variants.list[number].unknown {
            Some(list) if unknown.len() + unknown.len() / FEWER >= list.len() => return,
            Some(_) => {}
            None => {
                if let Some(old) = self.variants.list.iter().filter_map(|f| f.unknown.as_ref()).max_by_key(|u| u.len())
                {
                    // what was unknown before may be so again
                    unknown.extend(old);
                    unknown.sort_unstable();
                    unknown.dedup();
                }
            }
        }
        if unknown.len() < self.layout.leaves.len() {
            self.variants.list.retain(|f| f.unknown.as_ref().is_none_or(Vec::is_empty));
            self.variants.current = None;
            let number = self.variant(Some(unknown));
            self.enter(number);
            self.variants.looks = Looks::from(self.diagnostics.report.phases(), PATIENCE);
        }
    }
}
