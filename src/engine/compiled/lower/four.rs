//! Vectors of nodes, a node each plane of a word; what cuts them and joins them.

use crate::cell::Algebra;
use crate::compiled::ir::graph::{Graph, Id};
use crate::value::Word;
use crate::value::word::{word_mask, words};

/// The two planes of a machine word.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Two {
    pub v: Id,
    pub u: Id,
}

/// A vector, the least significant word first.
pub(crate) type Bits = Vec<Two>;

impl Graph {
    pub fn literals(&mut self, value: &crate::Value) -> Bits {
        value.words().map(|w| self.literal(w)).collect()
    }

    pub fn zeros(&mut self, width: u32) -> Bits {
        (0..words(width)).map(|_| self.literal(Word::ZERO)).collect()
    }
}

/// `width` bits of a vector from bit `lo` up.
pub(crate) fn slice(g: &mut Graph, from: &[Two], lo: u32, width: u32) -> Bits {
    let (skip, shift) = (lo as usize / 64, lo % 64);
    (0..words(width))
        .map(|i| {
            let m = word_mask(width, i);
            let w = m.count_ones();
            let low = from[skip + i];
            if shift + w <= 64 {
                return Two { v: g.bits(low.v, shift, w), u: g.bits(low.u, shift, w) };
            }
            let high = from[skip + i + 1];
            let mut plane = |l: Id, h: Id| {
                let (l, h) = (g.shr(l, shift), g.shl(h, 64 - shift));
                let both = g.or(l, h);
                g.bits(both, 0, w)
            };
            Two { v: plane(low.v, high.v), u: plane(low.u, high.u) }
        })
        .collect()
}

/// Puts `width` bits above the `at` bits that a vector has.
pub(crate) fn append(g: &mut Graph, to: &mut Bits, at: u32, from: &[Two], width: u32) {
    let none = g.literal(Word::ZERO);
    to.resize(words(at + width), none);
    for (i, &w) in from.iter().enumerate().take(words(width)) {
        let (lo, n) = (at + i as u32 * 64, (width - i as u32 * 64).min(64));
        let (word, shift) = (lo as usize / 64, lo % 64);
        let (low, high) = if shift == 0 {
            (w, none)
        } else {
            let low = Two { v: g.shl(w.v, shift), u: g.shl(w.u, shift) };
            (low, Two { v: g.shr(w.v, 64 - shift), u: g.shr(w.u, 64 - shift) })
        };
        to[word] = Two { v: g.or(to[word].v, low.v), u: g.or(to[word].u, low.u) };
        if shift + n > 64 {
            to[word + 1] = Two { v: g.or(to[word + 1].v, high.v), u: g.or(to[word + 1].u, high.u) };
        }
    }
}
