//! The [algebra](super::algebra) of machine words: it computes. The event engine and constant folding run it.

use super::algebra::{Algebra, Site};
use crate::value::Word;
use crate::value::word::mask;

/// Planes are numbers of 64 bits.
#[derive(Clone, Copy, Debug)]
pub struct Words;

impl Algebra for Words {
    type Plane = u64;
    type Word = Word;
    const BITS: u32 = 64;

    #[inline(always)]
    fn word(v: u64, u: u64) -> Word {
        Word { v, u }
    }

    #[inline(always)]
    fn planes(w: Word) -> (u64, u64) {
        (w.v, w.u)
    }

    #[inline(always)]
    fn constant(&mut self, bits: u64) -> u64 {
        bits
    }

    #[inline(always)]
    fn and(&mut self, a: u64, b: u64) -> u64 {
        a & b
    }

    #[inline(always)]
    fn or(&mut self, a: u64, b: u64) -> u64 {
        a | b
    }

    #[inline(always)]
    fn xor(&mut self, a: u64, b: u64) -> u64 {
        a ^ b
    }

    #[inline(always)]
    fn and_not(&mut self, a: u64, b: u64) -> u64 {
        a & !b
    }

    #[inline(always)]
    fn shl(&mut self, a: u64, n: u32) -> u64 {
        a << n
    }

    #[inline(always)]
    fn shr(&mut self, a: u64, n: u32) -> u64 {
        a >> n
    }

    #[inline(always)]
    fn shl_by(&mut self, a: u64, n: u64) -> u64 {
        a << n
    }

    #[inline(always)]
    fn shr_by(&mut self, a: u64, n: u64) -> u64 {
        a >> n
    }

    #[inline(always)]
    fn any(&mut self, a: u64) -> u64 {
        u64::from(a != 0)
    }

    #[inline(always)]
    fn parity(&mut self, a: u64) -> u64 {
        u64::from(a.count_ones() & 1)
    }

    #[inline(always)]
    fn several(&mut self, a: u64) -> u64 {
        u64::from(a & a.wrapping_sub(1) != 0)
    }

    #[inline(always)]
    fn equal(&mut self, a: u64, b: u64) -> u64 {
        u64::from(a == b)
    }

    #[inline(always)]
    fn less(&mut self, a: u64, b: u64) -> u64 {
        u64::from(a < b)
    }

    #[inline(always)]
    fn select(&mut self, s: u64, a: u64, b: u64) -> u64 {
        if s == 0 { b } else { a }
    }

    #[inline(always)]
    fn splat(&mut self, s: u64, mask: u64) -> u64 {
        s.wrapping_neg() & mask
    }

    #[inline(always)]
    fn add(&mut self, a: u64, b: u64, carry: u64, bits: u32) -> (u64, u64) {
        let m = mask(bits);
        let (sum, c1) = a.overflowing_add(b);
        let (sum, c2) = sum.overflowing_add(carry);
        (sum & m, u64::from(c1 | c2 | (sum & !m != 0)))
    }

    #[inline(always)]
    fn sub(&mut self, a: u64, b: u64, borrow: u64, bits: u32) -> (u64, u64) {
        let (y, b1) = a.overflowing_sub(b);
        let (y, b2) = y.overflowing_sub(borrow);
        (y & mask(bits), u64::from(b1 | b2))
    }

    #[inline(always)]
    fn mul_add(&mut self, a: u64, b: u64, c: u64, d: u64) -> (u64, u64) {
        let y = u128::from(a) * u128::from(b) + u128::from(c) + u128::from(d);
        (y as u64, (y >> 64) as u64)
    }

    #[inline(always)]
    fn quotient(&mut self, a: u64, b: u64) -> Option<(u64, u64)> {
        Some((a / b, a % b))
    }

    #[inline(always)]
    fn known(&self, a: u64) -> Option<u64> {
        Some(a)
    }
}

/// The pins of a cell as slices. The first output is its state too, in place.
pub(super) struct Pins<'s, 'w> {
    pub ins: &'s [&'s [Word]],
    pub outs: &'s mut [&'w mut [Word]],
}

impl Site<Words> for Pins<'_, '_> {
    #[inline(always)]
    fn get(&self, pin: usize, i: usize) -> Word {
        self.ins[pin][i]
    }

    #[inline(always)]
    fn state(&self, i: usize) -> Word {
        self.outs[0][i]
    }

    #[inline(always)]
    fn put(&mut self, output: usize, i: usize, w: Word) {
        self.outs[output][i] = w;
    }

    #[inline(always)]
    fn hold(&mut self) {}
}

/// The pins of a clocked cell, its state, and what that becomes.
pub(super) struct Clocked<'s> {
    pub ins: &'s [&'s [Word]],
    pub q: &'s [Word],
    pub next: &'s mut [Word],
}

impl Site<Words> for Clocked<'_> {
    #[inline(always)]
    fn get(&self, pin: usize, i: usize) -> Word {
        self.ins[pin][i]
    }

    #[inline(always)]
    fn state(&self, i: usize) -> Word {
        self.q[i]
    }

    #[inline(always)]
    fn put(&mut self, _: usize, i: usize, w: Word) {
        self.next[i] = w;
    }

    #[inline(always)]
    fn hold(&mut self) {
        self.next.copy_from_slice(self.q);
    }
}
