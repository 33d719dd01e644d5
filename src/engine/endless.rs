//! When a loop counts as oscillating, and which of its bits keep changing. All engines use these numbers, so that all of
//! them name the same nets (docs/meaning.md, Feedback).

use crate::value::Word;

/// Rounds of clock edges within one evaluation phase after which it counts as endless.
pub(super) const ROUNDS: usize = 1_000_008;
/// Rounds after which it is looked whether the state comes back to what it was: no honest circuit has so many.
pub(super) const HONEST_ROUNDS: usize = 1024;
/// The most rounds in which the nets that clocked cells keep changing are looked for.
pub(super) const SHOWN_ROUNDS: usize = 4096;
/// Steps that an x has to get round an endless group.
pub(super) const SPREADING: usize = 64;

/// Steps after which a combinational loop counts as oscillating although its values have not come back, as those of a
/// counter within it: many more than a value needs to go round all the words that it drives.
pub(super) fn steps(words: usize) -> usize {
    16_384 + words
}

/// Looks for a state that has been there before, by Brent's algorithm: the state of a round that is a power of two is kept
/// and compared with those after it.
#[derive(Debug)]
pub(super) struct Return<T> {
    kept: Option<T>,
    round: usize,
    next: usize,
}

impl<T> Return<T> {
    pub fn new() -> Return<T> {
        Return { kept: None, round: 0, next: 1 }
    }

    /// Whether the present state, made by `now`, is one that was kept before; `is` compares it.
    pub fn has(&mut self, is: impl FnOnce(&T) -> bool, now: impl FnOnce() -> T) -> bool {
        if self.kept.as_ref().is_some_and(is) {
            return true;
        }
        self.round += 1;
        if self.round == self.next {
            (self.kept, self.next) = (Some(now()), 2 * self.next);
        }
        false
    }
}

/// The bits that keep changing of an oscillating loop whose values have come back: those that do while it goes round once
/// more; `step` makes a step and gives its words after it.
pub(super) fn changing(start: &[Word], mut step: impl FnMut() -> Vec<Word>) -> Vec<u64> {
    let mut changing = vec![0; start.len()];
    let mut before = start.to_vec();
    loop {
        let after = step();
        for (bits, (old, new)) in changing.iter_mut().zip(before.iter().zip(&after)) {
            *bits |= old.difference(*new);
        }
        if after == start {
            return changing;
        }
        before = after;
    }
}
