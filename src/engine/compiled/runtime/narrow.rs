//! Which state is unknown, and when a form is made for less of it.
//!
//! At the start registers fill one after another, so a form for what is unknown at some moment would soon be too wide. It
//! is made when what is unknown has not become less for a while, and made anew when that is less after all: looks for it
//! are twice as far from each other each time, so that they and the forms cost little of a long run.

use crate::compiled::ir::places::{Slot, Slots};
use crate::compiled::runtime::{CompiledEngine, PATIENCE};

/// The part of what a form takes to be unknown, as one in so many, for which a narrower form is made.
const FEWER: usize = 8;
/// The most waves between two looks.
const FARTHEST: u64 = 1 << 22;

/// When state is looked at for what has become known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Looks {
    /// The wave from which on waves are counted, and after how many it is looked at next.
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

impl CompiledEngine<'_> {
    /// The first unknown slot of state from a place on, round to it.
    pub(crate) fn find_unknown(&self) -> Option<Slot> {
        let Slots { start, end } = self.wiring.leaves;
        let is = |&slot: &Slot| self.memory[slot.index()].u != 0;
        let find = |start, end| Slots { start, end }.iter().find(is);
        find(self.last_unknown, end).or_else(|| find(start, self.last_unknown))
    }

    /// All unknown slots of state.
    pub(crate) fn all_unknown(&self) -> Vec<Slot> {
        self.wiring.leaves.iter().filter(|&slot| self.memory[slot.index()].u != 0).collect()
    }

    /// Goes over to a faster form if there is one for what has become known.
    pub(crate) fn improve(&mut self) {
        let Some(number) = self.current.filter(|&n| self.forms[n].unknown.as_ref().is_none_or(|u| !u.is_empty()))
        else {
            return;
        };
        match self.find_unknown() {
            None => {
                let number = self.form(Some(Vec::new()));
                self.enter(number);
            }
            Some(slot) => {
                self.last_unknown = slot;
                self.narrow(number);
            }
        }
    }

    /// Now and then goes over to a form that takes all to be known that is, as soon as that does not become more.
    fn narrow(&mut self, number: usize) {
        let waves = self.report.waves() - self.looks.from;
        if waves < self.looks.next {
            return;
        }
        let mut unknown = self.all_unknown();
        let fewer = unknown.len() < self.looks.unknown;
        self.looks = Looks { next: (2 * waves).min(FARTHEST), unknown: unknown.len(), ..self.looks };
        if fewer {
            return;
        }
        match &self.forms[number].unknown {
            Some(list) if unknown.len() + unknown.len() / FEWER >= list.len() => return,
            Some(_) => {}
            None => {
                if let Some(old) = self.forms.iter().filter_map(|f| f.unknown.as_ref()).max_by_key(|u| u.len()) {
                    // what was unknown before may be so again
                    unknown.extend(old);
                    unknown.sort_unstable();
                    unknown.dedup();
                }
            }
        }
        if unknown.len() < self.wiring.leaves.len() {
            self.forms.retain(|f| f.unknown.as_ref().is_none_or(Vec::is_empty));
            self.current = None;
            let number = self.form(Some(unknown));
            self.enter(number);
            self.looks = Looks::from(self.report.waves(), PATIENCE);
        }
    }
}
