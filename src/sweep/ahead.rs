//! Algorithms lane by lane: each runs some clocks ahead, and what they expect of 64 lanes is put into planes, so that
//! one comparison is one of all lanes.

use super::against::{Against, Field, WORDS};
use super::judge::each;
use super::model::What;
use crate::engine::batch::{BatchEngine, LaneSet};
use crate::interpolate::{Clock, Interpolator, Packing};
use crate::netlist::Slice;
use crate::value::word::mask;

/// Clocks that an algorithm runs ahead of its lane.
const AHEAD: usize = 16;

/// One lane's algorithm.
struct Course {
    algorithm: Box<dyn Interpolator>,
    /// Its registers after the clocks that it has run ahead, and whether there are no more.
    registers: Clock,
    over: bool,
    /// Clocks of the lane.
    clocks: u64,
}

/// The algorithms of the lanes of a block.
pub(super) struct Ahead<'a> {
    against: &'a Against,
    packings: Vec<Packing>,
    courses: Vec<Option<Course>>,
    /// What the lanes are to show for some clocks ahead: for each 64 lanes, each clock and each word of it.
    ahead: Vec<[u64; 64]>,
    /// At which of these clocks each 64 lanes are.
    at: Vec<usize>,
    /// What they are to show now as planes, by word and bit.
    planes: Vec<LaneSet>,
    zeros: LaneSet,
}

impl<'a> Ahead<'a> {
    pub fn new(against: &'a Against, lanes: usize) -> Ahead<'a> {
        let set = || vec![0u64; lanes / 64];
        Ahead {
            against,
            packings: against.packings(),
            courses: (0..lanes).map(|_| None).collect(),
            ahead: vec![[0; 64]; lanes / 64 * AHEAD * against.words],
            at: vec![0; lanes / 64],
            planes: vec![set(); against.words * 64],
            zeros: set(),
        }
    }

    /// A lane begins.
    pub fn begin(&mut self, lane: usize, algorithm: Option<Box<dyn Interpolator>>) {
        self.courses[lane] = algorithm.map(|algorithm| {
            let registers = algorithm.state();
            Course { algorithm, registers, over: false, clocks: 0 }
        });
    }

    /// Clocks that a lane has made.
    pub fn clocks(&self, lane: usize) -> u64 {
        self.courses[lane].as_ref().map_or(0, |c| c.clocks)
    }

    /// What some of 64 lanes are to show: of those that begin, and after a clock of those that have `clocked`; with
    /// `all` there are no others.
    pub fn advance(&mut self, word: usize, fresh: u64, clocked: u64, all: bool) {
        if fresh != 0 {
            self.run_ahead(word, fresh, self.at[word], AHEAD);
        }
        if clocked != 0 {
            if all {
                self.at[word] += 1;
                if self.at[word] == AHEAD {
                    self.at[word] = 0;
                    self.run_ahead(word, clocked, 0, AHEAD);
                }
                self.count(word, clocked);
            } else {
                self.step_alone(word, clocked);
            }
        }
        if fresh | clocked != 0 {
            self.turn(word);
        }
    }

    /// Adds to a set the lanes that show something else.
    pub fn compare(&self, engine: &BatchEngine, pulses: bool, differ: &mut LaneSet) {
        for field in &self.against.fields {
            let step = matches!(field.what, What::Step(_));
            let mut at = field.word * 64 + field.shift as usize;
            for slice in &field.bits {
                for i in 0..slice.width {
                    let bit = Slice { lo: slice.lo + i, width: 1, ..*slice };
                    let expected = if step && !pulses { &self.zeros } else { &self.planes[at] };
                    engine.differ(bit, expected, differ);
                    at += 1;
                }
            }
        }
    }

    /// What a lane is to show.
    pub fn expected(&self, field: &Field, lane: usize) -> u64 {
        let all = self.ahead[self.place(lane / 64, self.at[lane / 64], field.word)][lane % 64];
        all >> field.shift & mask(field.width)
    }

    /// The place of a clock and a word in `ahead`.
    fn place(&self, group: usize, clock: usize, word: usize) -> usize {
        (group * AHEAD + clock) * self.against.words + word
    }

    fn count(&mut self, group: usize, set: u64) {
        each(set, |lane| {
            if let Some(course) = &mut self.courses[group * 64 + lane] {
                course.clocks += 1;
            }
        });
    }

    /// Lets the algorithms of some of 64 lanes fill their clocks ahead, of these numbers.
    fn run_ahead(&mut self, group: usize, set: u64, from: usize, to: usize) {
        let words = self.against.words;
        let mut buffer = [0u64; AHEAD * WORDS];
        let buffer = &mut buffer[..(to - from) * words];
        each(set, |lane| {
            let Some(course) = &mut self.courses[group * 64 + lane] else { return };
            course.algorithm.ahead(&mut course.registers, &mut course.over, &self.packings, buffer);
            let first = (group * AHEAD + from) * words;
            for (to, value) in self.ahead[first..].iter_mut().zip(&*buffer) {
                to[lane] = *value;
            }
        });
    }

    /// A clock of some of 64 lanes while the others rest.
    fn step_alone(&mut self, group: usize, set: u64) {
        let words = self.against.words;
        for clock in self.at[group] + 1..AHEAD {
            for word in 0..words {
                let (from, to) = (self.place(group, clock, word), self.place(group, clock - 1, word));
                each(set, |lane| self.ahead[to][lane] = self.ahead[from][lane]);
            }
        }
        self.run_ahead(group, set, AHEAD - 1, AHEAD);
        self.count(group, set);
    }

    /// Puts what 64 lanes are to show now into the planes.
    fn turn(&mut self, group: usize) {
        for word in 0..self.against.words {
            let mut square = self.ahead[self.place(group, self.at[group], word)];
            transpose(&mut square);
            for (plane, bits) in self.planes[word * 64..].iter_mut().zip(square) {
                plane[group] = bits;
            }
        }
    }
}

/// Bit `i` of word `k` becomes bit `k` of word `i`.
fn transpose(a: &mut [u64; 64]) {
    let mut width = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while width != 0 {
        let mut k = 0;
        while k < 64 {
            let t = (a[k] >> width ^ a[k + width]) & mask;
            a[k] ^= t << width;
            a[k + width] ^= t;
            k = (k + width + 1) & !width;
        }
        width >>= 1;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_bits_is_turned() {
        let mut state = 1u64;
        let original: [u64; 64] = std::array::from_fn(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state ^ state >> 29
        });
        let mut turned = original;
        transpose(&mut turned);
        for (i, row) in turned.iter().enumerate() {
            for (k, old) in original.iter().enumerate() {
                assert_eq!(row >> k & 1, old >> i & 1);
            }
        }
    }
}
