//! That every instance of the algebra gives what machine words give: for every kind, many shapes, all four values.

use super::samples::{Sort, sample};
use super::{CellKind, clocked, evaluate};
use crate::random;
use crate::value::Word;
use crate::value::word::{word_mask, words};

/// A cell with values at its pins.
pub struct Case {
    /// The cell.
    pub kind: CellKind,
    /// By pin its words.
    pub ins: Vec<Vec<Word>>,
    /// Of a cell with a state.
    pub state: Vec<Word>,
}

/// What machine words give.
pub struct Expected {
    /// By output, without a clock edge; of a state what its levels make of it.
    pub outputs: Vec<Vec<Word>>,
    /// What the state becomes at an edge.
    pub next: Vec<Word>,
}

/// Widths up to which everything is tried.
pub const NARROW: std::ops::RangeInclusive<u32> = 1..=6;
/// Widths at which words end.
pub const EDGES: [u32; 7] = [31, 32, 63, 64, 65, 127, 130];

impl Case {
    /// One by chance; with `known` nothing in it is x or z.
    #[must_use]
    pub fn new(sort: Sort, width: u32, known: bool, seed: &mut u64) -> Case {
        let kind = sample(sort, width, &mut |n| random::next(seed) % n);
        let density = random::next(seed) % 4;
        let mut vector = |width: u32| -> Vec<Word> {
            // numbers that are small, numbers of all ones, any
            let shape = random::next(seed) % 4;
            (0..words(width).max(1))
                .map(|i| {
                    let m = if width == 0 { 0 } else { word_mask(width, i) };
                    let v = match shape {
                        0 if i == 0 => random::next(seed) & 7,
                        0 => 0,
                        1 => random::next(seed) | random::next(seed) | random::next(seed),
                        _ => random::next(seed),
                    };
                    let u = match density {
                        _ if known => 0,
                        0 => 0,
                        1 => random::next(seed) & random::next(seed) & random::next(seed) & random::next(seed),
                        2 => random::next(seed) & random::next(seed),
                        _ => random::next(seed),
                    };
                    Word { v: v & m, u: u & m }
                })
                .collect()
        };
        let ins = (0..kind.inputs().len()).map(|pin| vector(kind.input_width(pin))).collect();
        let state = if kind.init().is_some() { vector(kind.output_width(0)) } else { Vec::new() };
        Case { kind, ins, state }
    }

    /// What machine words give.
    #[must_use]
    pub fn expected(&self) -> Expected {
        let ins: Vec<&[Word]> = self.ins.iter().map(Vec::as_slice).collect();
        let widths = (0..self.kind.outputs().len()).map(|pin| self.kind.output_width(pin));
        let mut outputs: Vec<Vec<Word>> = widths.map(|w| vec![Word::ZERO; words(w)]).collect();
        if !self.state.is_empty() {
            outputs[0].clone_from(&self.state);
        }
        let mut views: Vec<&mut [Word]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
        evaluate(&self.kind, &ins, &mut views);
        let mut next = self.state.clone();
        clocked(&self.kind, &ins, &self.state, &mut next);
        Expected { outputs, next }
    }

    /// Whether it is one that an algebra gives a meaning to: time and memory are not.
    #[must_use]
    #[expect(unreachable_patterns, reason = "what acts by time keeps no state either")]
    pub fn has_meaning(&self) -> bool {
        match self.kind {
            CellKind::Memory(_) | CellKind::Clock(_) | CellKind::Delay { .. } | CellKind::RcDelay(_) => false,
            CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Accumulator(_) => true,
            stateless!() => true,
        }
    }
}

/// Cases of every kind: of narrow ones many, of those at the ends of words some.
pub fn cases(known: bool, widest: u32) -> impl Iterator<Item = Case> {
    let mut seed = 1;
    let narrow = NARROW.flat_map(|width| std::iter::repeat_n(width, 60));
    let wide = EDGES.into_iter().filter(move |&w| w <= widest).flat_map(|width| std::iter::repeat_n(width, 12));
    let widths: Vec<u32> = narrow.chain(wide).collect();
    let all = Sort::ALL.iter().flat_map(move |&sort| widths.clone().into_iter().map(move |width| (sort, width)));
    all.map(move |(sort, width)| Case::new(sort, width, known, &mut seed)).filter(Case::has_meaning)
}

/// One bit of a vector.
#[must_use]
pub fn bit(words: &[Word], at: u32) -> Word {
    let (word, shift) = ((at / 64) as usize, at % 64);
    Word { v: words[word].v >> shift & 1, u: words[word].u >> shift & 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::word::mask;

    /// What is said to keep known bits known does.
    #[test]
    fn what_keeps_bits_known_gives_no_x() {
        for case in cases(true, 130).filter(|case| case.kind.keeps_known(|_| true)) {
            let expected = case.expected();
            let all = expected.outputs.iter().chain([&expected.next]).flatten();
            assert!(all.into_iter().all(|w| w.is_known()), "{:?} of {:?}", case.kind, case.ins);
        }
    }

    /// No instance has bits above the width of a vector.
    #[test]
    fn nothing_is_above_the_width() {
        for case in cases(false, 130) {
            let expected = case.expected();
            for (pin, words) in expected.outputs.iter().enumerate() {
                let width = case.kind.output_width(pin);
                let last = words.last().map_or(0, |w| w.v | w.u);
                assert_eq!(last & !mask(width - (width - 1) / 64 * 64), 0, "{:?} output {pin}", case.kind);
            }
        }
    }
}
