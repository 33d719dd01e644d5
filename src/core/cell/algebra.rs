//! The algebra in which the meaning of cells is written, once for all engines.
//!
//! A vector is a row of *words*, the least significant first, each with [`BITS`](Algebra::BITS) bits of it in two planes:
//! value and unknown, as [`Word`] has them. What a word is, the instance says:
//!
//! | instance | word | for |
//! |---|---|---|
//! | `Words` | 64 bits in two machine words | the event engine, constant folding |
//! | graph of the compiled engine | 64 bits in two nodes | machine code |
//! | lanes of the batch engine | one bit, in 512 lanes at once | sweeps |
//! | 3-LUT network of the batch engine | one bit, as a function | sweeps without x and z |
//!
//! An instance gives the operations on planes, which know two values only. The operators of four-valued logic are made of
//! them here, the meaning of cells of those in the files beside this one. A *truth* is a plane of which bit 0 alone may
//! be 1. What an instance knows of a plane it may tell ([`known`](Algebra::known)), so that one that computes takes the
//! short way; an answer of `None` is right in every case.
//!
//! Bits above the width of a vector are 0 in both planes, in what is given and in what is made.

use crate::Value;
use crate::value::Word;
use crate::value::word::mask;

/// Planes and words of an instance, and what can be computed of them.
pub trait Algebra {
    /// Some bits in one plane.
    type Plane: Copy;
    /// The same bits in both planes.
    type Word: Copy;
    /// How many bits of a vector a word has: 64, or 1.
    const BITS: u32;

    /// A word of its value plane and its unknown plane.
    fn word(v: Self::Plane, u: Self::Plane) -> Self::Word;
    /// The value plane and the unknown plane of a word.
    fn planes(w: Self::Word) -> (Self::Plane, Self::Plane);

    /// A plane with these bits.
    fn constant(&mut self, bits: u64) -> Self::Plane;
    /// `a & b`.
    fn and(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// `a | b`.
    fn or(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// `a ^ b`.
    fn xor(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// `a & !b`.
    fn and_not(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// `a` towards the most significant bit, `n` below [`BITS`](Algebra::BITS).
    fn shl(&mut self, a: Self::Plane, n: u32) -> Self::Plane;
    /// `a` towards the least significant bit, `n` below [`BITS`](Algebra::BITS).
    fn shr(&mut self, a: Self::Plane, n: u32) -> Self::Plane;
    /// [`shl`](Algebra::shl) by a number that is below [`BITS`](Algebra::BITS).
    fn shl_by(&mut self, a: Self::Plane, n: Self::Plane) -> Self::Plane;
    /// [`shr`](Algebra::shr) by a number that is below [`BITS`](Algebra::BITS).
    fn shr_by(&mut self, a: Self::Plane, n: Self::Plane) -> Self::Plane;
    /// Whether any bit is 1.
    fn any(&mut self, a: Self::Plane) -> Self::Plane;
    /// Whether an odd number of bits is 1.
    fn parity(&mut self, a: Self::Plane) -> Self::Plane;
    /// Whether more than one bit is 1.
    fn several(&mut self, a: Self::Plane) -> Self::Plane;
    /// Whether both are the same.
    fn equal(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// Whether `a` is less, as numbers without a sign.
    fn less(&mut self, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// `a` where the truth `s` is 1, else `b`.
    fn select(&mut self, s: Self::Plane, a: Self::Plane, b: Self::Plane) -> Self::Plane;
    /// The truth `s` in every bit of `mask`.
    fn splat(&mut self, s: Self::Plane, mask: u64) -> Self::Plane;
    /// The low `bits` bits of `a + b + carry`, and the bit above them.
    fn add(&mut self, a: Self::Plane, b: Self::Plane, carry: Self::Plane, bits: u32) -> (Self::Plane, Self::Plane);
    /// The low `bits` bits of `a - b - borrow`, and whether that is below 0.
    #[inline(always)]
    fn sub(&mut self, a: Self::Plane, b: Self::Plane, borrow: Self::Plane, bits: u32) -> (Self::Plane, Self::Plane) {
        let (b, carry) = (self.not(b, mask(bits)), self.not(borrow, 1));
        let (y, carry) = self.add(a, b, carry, bits);
        (y, self.not(carry, 1))
    }
    /// The low and the high word of `a * b + c + d`.
    fn mul_add(&mut self, a: Self::Plane, b: Self::Plane, c: Self::Plane, d: Self::Plane)
    -> (Self::Plane, Self::Plane);
    /// The low and the high word of `a * b` in two's complement, if that takes fewer operations than digits do.
    #[inline(always)]
    fn mul_signed(&mut self, a: Self::Plane, b: Self::Plane) -> Option<(Self::Plane, Self::Plane)> {
        let _ = (a, b);
        None
    }
    /// The quotient and the remainder of words, if the instance divides them; the divisor is not 0.
    #[inline(always)]
    fn quotient(&mut self, a: Self::Plane, b: Self::Plane) -> Option<(Self::Plane, Self::Plane)> {
        let _ = (a, b);
        None
    }

    /// What a plane is, if that is decided.
    #[inline(always)]
    fn known(&self, a: Self::Plane) -> Option<u64> {
        let _ = a;
        None
    }
    /// Whether no bit of a plane is 1, if it costs little to know.
    #[inline(always)]
    fn never(&self, a: Self::Plane) -> bool {
        self.known(a) == Some(0)
    }
    /// Whether no two of some truths can be 1 at once, if that is known.
    #[inline(always)]
    fn exclusive(&self, truths: &[Self::Plane]) -> bool {
        let _ = truths;
        false
    }
    /// Whether one of some truths is always 1, if that is known.
    #[inline(always)]
    fn exhaustive(&self, truths: &[Self::Plane]) -> bool {
        let _ = truths;
        false
    }

    // what all instances have

    /// The words of a vector.
    #[inline(always)]
    #[must_use]
    fn words(width: u32) -> usize {
        width.div_ceil(Self::BITS) as usize
    }

    /// The bits in use of word `i` of a vector.
    #[inline(always)]
    #[must_use]
    fn mask(width: u32, i: usize) -> u64 {
        mask((width - i as u32 * Self::BITS).min(Self::BITS))
    }

    /// The bits of `mask` inverted, which are all that `a` may have.
    #[inline(always)]
    fn not(&mut self, a: Self::Plane, mask: u64) -> Self::Plane {
        let all = self.constant(mask);
        self.xor(a, all)
    }

    /// `n` bits from bit `lo` up.
    #[inline(always)]
    fn bits(&mut self, a: Self::Plane, lo: u32, n: u32) -> Self::Plane {
        let a = self.shr(a, lo);
        if lo + n >= Self::BITS {
            return a;
        }
        let all = self.constant(mask(n));
        self.and(a, all)
    }

    /// Whether all bits of `mask` are 1, which are all that `a` may have.
    #[inline(always)]
    fn all(&mut self, a: Self::Plane, mask: u64) -> Self::Plane {
        let all = self.constant(mask);
        self.equal(a, all)
    }

    /// A word that is always the same.
    #[inline(always)]
    fn literal(&mut self, w: Word) -> Self::Word {
        Self::word(self.constant(w.v), self.constant(w.u))
    }

    /// Word `i` of a value.
    #[inline(always)]
    fn word_of(&mut self, value: &Value, i: usize) -> Self::Word {
        let bit = i as u32 * Self::BITS;
        let w = value.words().nth((bit / 64) as usize).unwrap_or_default();
        let (shift, m) = (bit % 64, mask(Self::BITS));
        self.literal(Word { v: w.v >> shift & m, u: w.u >> shift & m })
    }

    /// A word without x and z.
    #[inline(always)]
    fn sure(&mut self, v: Self::Plane) -> Self::Word {
        let none = self.constant(0);
        Self::word(v, none)
    }

    /// The bits that are certainly 1.
    #[inline(always)]
    fn ones(&mut self, a: Self::Word) -> Self::Plane {
        let (v, u) = Self::planes(a);
        self.and_not(v, u)
    }

    /// The bits of `mask` that are certainly 0.
    #[inline(always)]
    fn zeros(&mut self, a: Self::Word, mask: u64) -> Self::Plane {
        let (v, u) = Self::planes(a);
        let (some, all) = (self.or(v, u), self.constant(mask));
        self.and_not(all, some)
    }

    /// Whether bit 0 is 1: x and z are not.
    #[inline(always)]
    fn is_one(&mut self, a: Self::Word) -> Self::Plane {
        let ones = self.ones(a);
        self.bits(ones, 0, 1)
    }

    /// Whether bit 0 is 0: x and z are not.
    #[inline(always)]
    fn is_zero(&mut self, a: Self::Word) -> Self::Plane {
        let (v, u) = Self::planes(a);
        let some = self.or(v, u);
        let some = self.bits(some, 0, 1);
        self.not(some, 1)
    }

    /// z read as x.
    #[inline(always)]
    fn read4(&mut self, a: Self::Word) -> Self::Word {
        let (_, u) = Self::planes(a);
        Self::word(self.ones(a), u)
    }

    /// Bitwise AND: 0 where either is 0, 1 where both are 1, else x.
    #[inline(always)]
    fn and4(&mut self, a: Self::Word, b: Self::Word) -> Self::Word {
        let ((av, au), (bv, bu)) = (Self::planes(a), Self::planes(b));
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.and(x, y);
        let either = self.or(au, bu);
        let (a, b) = (self.or(au, av), self.or(bu, bv));
        let u = self.and(either, a);
        Self::word(v, self.and(u, b))
    }

    /// Bitwise OR: 1 where either is 1, 0 where both are 0, else x.
    #[inline(always)]
    fn or4(&mut self, a: Self::Word, b: Self::Word) -> Self::Word {
        let (au, bu) = (Self::planes(a).1, Self::planes(b).1);
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.or(x, y);
        let u = self.or(au, bu);
        Self::word(v, self.and_not(u, v))
    }

    /// Bitwise exclusive OR: x where either is unknown.
    #[inline(always)]
    fn xor4(&mut self, a: Self::Word, b: Self::Word) -> Self::Word {
        let ((av, au), (bv, bu)) = (Self::planes(a), Self::planes(b));
        let u = self.or(au, bu);
        let v = self.xor(av, bv);
        Self::word(self.and_not(v, u), u)
    }

    /// The bits of `mask` inverted: x where unknown.
    #[inline(always)]
    fn not4(&mut self, a: Self::Word, mask: u64) -> Self::Word {
        let (_, u) = Self::planes(a);
        let v = self.zeros(a, mask);
        let all = self.constant(mask);
        Self::word(v, self.and(u, all))
    }

    /// The bits on which both agree as 0 or 1, else x (IEEE 1364-2005, 5.1.13, table 5-21).
    #[inline(always)]
    fn merge4(&mut self, a: Self::Word, b: Self::Word) -> Self::Word {
        let ((av, au), (bv, bu)) = (Self::planes(a), Self::planes(b));
        let differ = self.xor(av, bv);
        let u = self.or(au, bu);
        let u = self.or(u, differ);
        Self::word(self.and_not(av, u), u)
    }

    /// What two drivers of one wire give (IEEE 1364-2005, 4.6.1, table 4-2).
    #[inline(always)]
    fn resolve4(&mut self, a: Self::Word, b: Self::Word, mask: u64) -> Self::Word {
        let ((av, au), (bv, bu)) = (Self::planes(a), Self::planes(b));
        let (za, zb) = (self.and(av, au), self.and(bv, bu));
        let all = self.constant(mask);
        let both = self.and_not(all, za);
        let both = self.and_not(both, zb);
        let differ = self.xor(av, bv);
        let conflict = self.or(au, bu);
        let conflict = self.or(conflict, differ);
        let conflict = self.and(both, conflict);
        let same = self.and(av, bv);
        let same = self.and(both, same);
        let same = self.and_not(same, conflict);
        let (av, bv) = (self.and(zb, av), self.and(za, bv));
        let (au, bu) = (self.and(zb, au), self.and(za, bu));
        let v = self.or(av, bv);
        let u = self.or(au, bu);
        Self::word(self.or(v, same), self.or(u, conflict))
    }

    /// `a` where the truth `s` is 1, else `b`.
    #[inline(always)]
    fn pick(&mut self, s: Self::Plane, a: Self::Word, b: Self::Word) -> Self::Word {
        let ((av, au), (bv, bu)) = (Self::planes(a), Self::planes(b));
        Self::word(self.select(s, av, bv), self.select(s, au, bu))
    }

    /// `one` where the select is 1, `zero` where it is 0, what both agree on where it is unknown.
    #[inline(always)]
    fn mux4(&mut self, s: Self::Word, one: Self::Word, zero: Self::Word) -> Self::Word {
        let (v, u) = Self::planes(s);
        let chosen = self.pick(v, one, zero);
        if self.known(u) == Some(0) {
            return chosen;
        }
        let merged = self.merge4(zero, one);
        self.pick(u, merged, chosen)
    }

    /// The low `bits` bits.
    #[inline(always)]
    fn low4(&mut self, a: Self::Word, bits: u32) -> Self::Word {
        let (v, u) = Self::planes(a);
        Self::word(self.bits(v, 0, bits), self.bits(u, 0, bits))
    }

    /// `v`, or all x of `mask` where the truth `unknown` is 1.
    #[inline(always)]
    fn unless(&mut self, unknown: Self::Plane, v: Self::Plane, mask: u64) -> Self::Word {
        let none = self.constant(0);
        Self::word(self.select(unknown, none, v), self.splat(unknown, mask))
    }
}

/// Where a cell stands: what it reads and what it gives.
pub trait Site<A: Algebra> {
    /// Word `i` of an input pin.
    fn get(&self, pin: usize, i: usize) -> A::Word;
    /// Word `i` of the state, of a cell that has one.
    fn state(&self, i: usize) -> A::Word;
    /// Gives word `i` of an output. Each is given once, in order; of a state it is what that becomes.
    fn put(&mut self, output: usize, i: usize, w: A::Word);
    /// Says, instead of giving its words, that the state stays as it is.
    fn hold(&mut self);
}

/// At most [`BITS`](Algebra::BITS) bits of a pin, from bit `lo` up.
#[inline(always)]
pub(super) fn part<A: Algebra, S: Site<A>>(l: &mut A, s: &S, pin: usize, lo: u32, n: u32) -> A::Word {
    let (at, shift) = ((lo / A::BITS) as usize, lo % A::BITS);
    let (low_v, low_u) = A::planes(s.get(pin, at));
    if shift + n <= A::BITS {
        return A::word(l.bits(low_v, shift, n), l.bits(low_u, shift, n));
    }
    let (high_v, high_u) = A::planes(s.get(pin, at + 1));
    let mut plane = |low: A::Plane, high: A::Plane| {
        let (low, high) = (l.shr(low, shift), l.shl(high, A::BITS - shift));
        let both = l.or(low, high);
        l.bits(both, 0, n)
    };
    A::word(plane(low_v, high_v), plane(low_u, high_u))
}

/// Word `i` of input `k` of a pin that has several, each of `width` bits.
#[inline(always)]
pub(super) fn input<A: Algebra, S: Site<A>>(l: &mut A, s: &S, pin: usize, width: u32, k: u32, i: usize) -> A::Word {
    let n = (width - i as u32 * A::BITS).min(A::BITS);
    part(l, s, pin, k * width + i as u32 * A::BITS, n)
}

/// Whether any bit of a pin of `width` bits is x or z.
#[inline(always)]
pub(super) fn unknown<A: Algebra, S: Site<A>>(l: &mut A, s: &S, pin: usize, width: u32) -> A::Plane {
    let mut all = l.constant(0);
    for i in 0..A::words(width) {
        all = l.or(all, A::planes(s.get(pin, i)).1);
    }
    l.any(all)
}

/// Bit `i` of a pin, as a truth of its value plane.
#[inline(always)]
pub(super) fn value_bit<A: Algebra, S: Site<A>>(l: &mut A, s: &S, pin: usize, i: u32) -> A::Plane {
    let v = A::planes(s.get(pin, (i / A::BITS) as usize)).0;
    l.bits(v, i % A::BITS, 1)
}

/// All x.
#[inline(always)]
pub(super) fn put_x<A: Algebra, S: Site<A>>(l: &mut A, s: &mut S, output: usize, width: u32) {
    for i in 0..A::words(width) {
        let x = l.literal(Word::x(A::mask(width, i)));
        s.put(output, i, x);
    }
}

/// Parts of a vector one above another, given as soon as a word is full.
pub(super) struct Append<A: Algebra> {
    output: usize,
    words: usize,
    word: A::Word,
    filled: u32,
}

impl<A: Algebra> Append<A> {
    #[inline(always)]
    pub fn new(l: &mut A, output: usize) -> Append<A> {
        Append { output, words: 0, word: l.literal(Word::ZERO), filled: 0 }
    }

    /// Puts `n` bits above those that are there.
    #[inline(always)]
    pub fn push(&mut self, l: &mut A, s: &mut impl Site<A>, w: A::Word, n: u32) {
        let ((av, au), (bv, bu)) = (A::planes(self.word), A::planes(w));
        let (v, u) = (l.shl(bv, self.filled), l.shl(bu, self.filled));
        self.word = A::word(l.or(av, v), l.or(au, u));
        self.filled += n;
        if self.filled >= A::BITS {
            s.put(self.output, self.words, self.word);
            self.words += 1;
            self.filled -= A::BITS;
            // what did not fit
            self.word = if self.filled == 0 {
                l.literal(Word::ZERO)
            } else {
                A::word(l.shr(bv, n - self.filled), l.shr(bu, n - self.filled))
            };
        }
    }

    /// Gives the last word, if it is not full.
    #[inline(always)]
    pub fn finish(self, s: &mut impl Site<A>) {
        if self.filled > 0 {
            s.put(self.output, self.words, self.word);
        }
    }
}
