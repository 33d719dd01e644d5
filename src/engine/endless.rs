//! When something counts as endless, and what of it keeps changing. All engines go by these numbers, so that all of them
//! name the same nets (docs/meaning.md, Feedback).

use crate::value::Word;

/// Steps of a feedback group after which it counts as endless.
pub(super) const STEPS: usize = 1_000_000;
/// Rounds of clock edges within one wave after which it counts as endless.
pub(super) const ROUNDS: usize = STEPS + 8;
/// Rounds in which the nets that clocked cells keep changing are looked for.
pub(super) const SHOWN_ROUNDS: usize = 64;
/// Steps that an x has to get round an endless group.
pub(super) const SPREADING: usize = 64;
/// Steps in which the bits of an endless group that keep changing are looked for.
const SHOWN_STEPS: usize = 4096;

/// The bits that change while a group goes round once more; `step` makes a step and gives its words after it.
pub(super) fn changing(start: &[Word], mut step: impl FnMut() -> Vec<Word>) -> Vec<u64> {
    let mut changing = vec![0; start.len()];
    let mut before = start.to_vec();
    for _ in 0..SHOWN_STEPS {
        let after = step();
        for (bits, (old, new)) in changing.iter_mut().zip(before.iter().zip(&after)) {
            *bits |= old.difference(*new);
        }
        if after == start {
            break;
        }
        before = after;
    }
    changing
}
