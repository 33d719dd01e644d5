//! What guards learn: which state is unknown now and then, and which variant runs therefore.
//!
//! A guard that fails costs a phase in partitions, and the state that failed it is *learned*: the next variant that is
//! compiled takes it as possibly unknown; after some of them one is that takes all so that x can get to from there, and
//! has no guard that can fail but those of inputs. A variant that fails soon after it was entered is barred, each time twice as
//! long, so that x that comes and goes stays in the variant that allows it.
//!
//! State is looked at in windows, several times in each. At the end of one a variant is compiled for what was unknown at
//! any of these looks, if that is less than what the running one allows. At the start registers fill one after another,
//! so there a window is prolonged as long as what is unknown becomes less. The next window is twice as long, so that looks
//! and variants cost little of a long run.

use crate::compiled::ir::graph::Map;
use crate::compiled::ir::places::{Slot, Slots};
use crate::compiled::runtime::variants::{Variant, reach};
use crate::compiled::runtime::{CompiledEngine, PATIENCE};

/// A variant is compiled anew when it would allow less by at least one part in this many.
const FEWER: usize = 8;
/// The longest window, in phases.
const FARTHEST: u64 = 1 << 22;
/// Looks at the state in a window.
const LOOKS: u64 = 16;
/// The shortest window after which a mixed variant is narrowed: what can be gained is to be worth the code.
const WORTH: u64 = 1 << 14;
/// Up to which length a window is prolonged.
const PROLONGED: u64 = 1 << 12;
/// How often a run may fall back to the four-valued variant before the next one allows all that x can get to.
const FALLS: u32 = 3;
/// Phases for which a variant that has failed is barred at first.
const BARRED: u64 = 64;
/// A variant that has run as long without a failure is as good as a new one.
const LONG: u64 = 1 << 16;
/// Mixed variants that are kept.
const MOST: usize = 4;

/// See the head of this file.
#[derive(Debug)]
pub(crate) struct Guards {
    /// State that was unknown when a guard failed, in order.
    learned: Vec<Slot>,
    /// How often no variant was left but the four-valued one.
    falls: u32,
    /// How often each slot has failed a guard.
    pub failures: Map<Slot, u64>,
    /// The phase at which the window began, its length, and the phase of the next look.
    from: u64,
    length: u64,
    next: u64,
    /// State that was unknown at any look of the window, in order, and how much was at the last.
    seen: Vec<Slot>,
    last: usize,
}

impl Guards {
    pub fn new() -> Guards {
        let (learned, failures, seen) = (Vec::new(), Map::default(), Vec::new());
        Guards { learned, falls: 0, failures, from: 0, length: PATIENCE / 2, next: 0, seen, last: usize::MAX }
    }

    /// Begins a window.
    fn begin(&mut self, now: u64, length: u64) {
        self.length = length.min(FARTHEST);
        (self.from, self.next) = (now, now);
        self.seen.clear();
        self.last = usize::MAX;
    }

    /// The most phases until state is to be looked at.
    pub fn pause(&self) -> u64 {
        (self.length / LOOKS).max(PATIENCE / 2)
    }
}

/// Two ordered lists as one.
fn join(to: &mut Vec<Slot>, more: &[Slot]) {
    if !more.iter().all(|slot| to.binary_search(slot).is_ok()) {
        to.extend(more);
        to.sort_unstable();
        to.dedup();
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

    /// The number of the variant to go on in: at the start, or after a guard has failed.
    pub(crate) fn choose(&mut self) -> usize {
        let unknown = self.all_unknown();
        let now = self.diagnostics.report.phases();
        if let Some(number) = self.variants.current {
            let variant = &mut self.variants.list[number];
            for &slot in unknown.iter().filter(|&&slot| !variant.allows(slot)) {
                *self.variants.guards.failures.entry(slot).or_default() += 1;
            }
            variant.failures = if now - variant.entered < LONG { variant.failures + 1 } else { 1 };
            variant.barred = now + (BARRED << variant.failures.min(24));
            self.diagnostics.report.guards += 1;
            join(&mut self.variants.guards.learned, &unknown);
        }
        let length = self.variants.guards.length;
        let known = self.variants.list.iter().find(|v| v.breadth() == 0);
        if unknown.is_empty() && known.is_none_or(|v| v.barred <= now) {
            self.variants.guards.begin(now, length);
            return self.variant(Some(Vec::new()));
        }
        // between two that fail in turns a run would go to and fro
        let learned = &self.variants.guards.learned;
        let stays = |v: &&Variant| v.unknown.is_none() || v.barred <= now || v.allows_all(learned);
        let fits = self.variants.list.iter().filter(|v| v.breadth() > 0 && v.allows_all(&unknown)).filter(stays);
        let fits = fits.min_by_key(|v| (v.unknown.is_none(), v.breadth()));
        let fits = fits.map(|v| v.unknown.clone());
        // each time that nothing but the four-valued variant is left it stays for longer
        let falls = &mut self.variants.guards.falls;
        let four_valued = !fits.as_ref().is_some_and(Option::is_some);
        *falls += u32::from(four_valued);
        let length = if four_valued { (PATIENCE / 4) << (*falls).min(16) } else { length };
        self.variants.guards.begin(now, length);
        self.variant(fits.unwrap_or(None))
    }

    /// Goes over to a faster variant if there is one for what has become known.
    pub(crate) fn improve(&mut self) {
        let Some(number) = self.variants.current.filter(|&n| self.variants.list[n].breadth() > 0) else { return };
        let now = self.diagnostics.report.phases();
        match self.find_unknown() {
            None => {
                let known = self.variants.list.iter().find(|v| v.breadth() == 0);
                if known.is_none_or(|v| v.barred <= now) {
                    let number = self.variant(Some(Vec::new()));
                    return self.enter(number);
                }
            }
            Some(slot) => self.variants.last_unknown = slot,
        }
        if now >= self.variants.guards.next {
            self.look(number, now);
        }
    }

    /// Looks at the state, and at the end of a window goes over to a variant that takes all to be known that was.
    fn look(&mut self, number: usize, now: u64) {
        let unknown = self.all_unknown();
        let guards = &mut self.variants.guards;
        guards.next = now + (guards.length / LOOKS).max(1);
        join(&mut guards.seen, &unknown);
        if now - guards.from < guards.length {
            return;
        }
        let fewer = unknown.len() < guards.last;
        guards.last = unknown.len();
        let list = &self.variants.list[number].unknown;
        if list.is_none() && fewer && guards.length < PROLONGED {
            // it may become less still
            (guards.length, guards.seen) = ((2 * guards.length).min(FARTHEST), unknown);
            return;
        }
        let mut wanted = std::mem::take(&mut guards.seen);
        let length = guards.length;
        guards.begin(now, if list.is_some() { 4 * length } else { 2 * length });
        let worth = match list {
            Some(list) => length >= WORTH && wanted.len() + wanted.len() / FEWER < list.len(),
            None => {
                // what was unknown before may be so again
                join(&mut wanted, &guards.learned);
                let leaves = self.layout.leaves.len();
                let less = |wanted: &[Slot]| wanted.len() + wanted.len() / (2 * FEWER) < leaves;
                if guards.falls > FALLS {
                    let all = reach(&self.netlist, &self.layout, wanted.clone());
                    if less(&all) {
                        wanted = all;
                    } else if length < WORTH {
                        return;
                    }
                }
                less(&wanted)
            }
        };
        if !worth || wanted.is_empty() {
            return;
        }
        self.variants.guards.learned.clone_from(&wanted);
        self.forget();
        let number = self.variant(Some(wanted));
        self.enter(number);
    }

    /// Drops the mixed variant that was entered longest ago, if there are many.
    fn forget(&mut self) {
        let mixed = |v: &Variant| v.unknown.as_ref().is_some_and(|list| !list.is_empty());
        if self.variants.list.iter().filter(|v| mixed(v)).count() < MOST {
            return;
        }
        let current = self.variants.current;
        let oldest = (0..self.variants.list.len()).filter(|&n| mixed(&self.variants.list[n]) && current != Some(n));
        if let Some(oldest) = oldest.min_by_key(|&n| self.variants.list[n].entered) {
            self.variants.list.remove(oldest);
            self.variants.current = None;
        }
    }
}
