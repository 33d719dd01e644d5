//! A seeded source of numbers and values.

use discreta::{Logic, Value};

/// SplitMix64: the same numbers everywhere for the same seed.
#[derive(Clone)]
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Rng {
        Rng(seed)
    }

    /// Seeded by a name, so that a new case does not change the others.
    pub fn named(name: &str) -> Rng {
        Rng(name.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)))
    }

    pub fn word(&mut self) -> u64 {
        discreta::random::next(&mut self.0)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.word() % n
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len() as u64) as usize]
    }

    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.below(i as u64 + 1) as usize);
        }
    }

    /// Known bits.
    pub fn known(&mut self, width: u32) -> Value {
        let mut value = Value::from_u64(0, width);
        for i in 0..width {
            value.set_bit(i, if self.word() & 1 == 1 { Logic::One } else { Logic::Zero });
        }
        value
    }

    /// Bits of which each is x or z once in `n` times.
    pub fn four_valued(&mut self, width: u32, n: u64) -> Value {
        let mut value = self.known(width);
        for i in 0..width {
            if self.one_in(n) {
                value.set_bit(i, *self.pick(&[Logic::X, Logic::Z]));
            }
        }
        value
    }
}
