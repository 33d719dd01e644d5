//! The values of all lanes: for each bit of the netlist a plane of values and a plane that says which are unknown, one
//! bit a lane.
//!
//! Everything here is inlined into the functions that are compiled for each vector extension.

use std::cell::Cell;
use std::ops::{BitAnd, BitOr, BitOrAssign, BitXor, Not};

use crate::cell::Algebra;
use crate::value::Word;

/// Lanes of a [`Chunk`].
pub(super) const LANES: usize = 512;
const WORDS: usize = LANES / 64;

/// One bit of each of 512 lanes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(align(64))]
pub(super) struct Chunk(pub [u64; WORDS]);

macro_rules! bitwise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Chunk {
            type Output = Chunk;

            #[inline(always)]
            fn $method(self, o: Chunk) -> Chunk {
                let mut y = [0; WORDS];
                for i in 0..WORDS {
                    y[i] = self.0[i] $op o.0[i];
                }
                Chunk(y)
            }
        }
    };
}

bitwise!(BitAnd, bitand, &);
bitwise!(BitOr, bitor, |);
bitwise!(BitXor, bitxor, ^);

impl Not for Chunk {
    type Output = Chunk;

    #[inline(always)]
    fn not(self) -> Chunk {
        let mut y = [0; WORDS];
        for i in 0..WORDS {
            y[i] = !self.0[i];
        }
        Chunk(y)
    }
}

impl BitOrAssign for Chunk {
    #[inline(always)]
    fn bitor_assign(&mut self, o: Chunk) {
        *self = *self | o;
    }
}

impl Chunk {
    pub const ZERO: Chunk = Chunk([0; WORDS]);
    pub const ONES: Chunk = Chunk([!0; WORDS]);

    #[inline(always)]
    pub fn splat(bit: bool) -> Chunk {
        if bit { Chunk::ONES } else { Chunk::ZERO }
    }

    #[inline(always)]
    pub fn any(self) -> bool {
        let mut all = 0;
        for i in 0..WORDS {
            all |= self.0[i];
        }
        all != 0
    }
}

/// A four-valued bit of each of 512 lanes; the planes mean what they mean in [`Word`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Four {
    pub v: Chunk,
    pub u: Chunk,
}

impl Four {
    #[inline(always)]
    pub fn known(v: Chunk) -> Four {
        Four { v, u: Chunk::ZERO }
    }

    #[inline(always)]
    pub fn splat(bit: Word) -> Four {
        Four { v: Chunk::splat(bit.v & 1 != 0), u: Chunk::splat(bit.u & 1 != 0) }
    }

    #[inline(always)]
    pub fn ones(self) -> Chunk {
        self.v & !self.u
    }

    #[inline(always)]
    pub fn zeros(self) -> Chunk {
        !(self.v | self.u)
    }

    #[inline(always)]
    pub fn read(self) -> Four {
        Four { v: self.v & !self.u, u: self.u }
    }

    /// These bits, as they are, in the lanes of a mask, 0 in the others.
    #[inline(always)]
    pub fn within(self, mask: Chunk) -> Four {
        Four { v: self.v & mask, u: self.u & mask }
    }

    /// The bits of both, which share no lane.
    #[inline(always)]
    pub fn join(self, o: Four) -> Four {
        Four { v: self.v | o.v, u: self.u | o.u }
    }
}

/// The [algebra](crate::cell::Algebra) of lanes: a word is one bit of a vector, in all lanes of a chunk.
pub(super) struct Lanes;

impl Algebra for Lanes {
    type Plane = Chunk;
    type Word = Four;
    const BITS: u32 = 1;

    #[inline(always)]
    fn word(v: Chunk, u: Chunk) -> Four {
        Four { v, u }
    }

    #[inline(always)]
    fn planes(w: Four) -> (Chunk, Chunk) {
        (w.v, w.u)
    }

    #[inline(always)]
    fn constant(&mut self, bits: u64) -> Chunk {
        Chunk::splat(bits & 1 != 0)
    }

    #[inline(always)]
    fn and(&mut self, a: Chunk, b: Chunk) -> Chunk {
        a & b
    }

    #[inline(always)]
    fn or(&mut self, a: Chunk, b: Chunk) -> Chunk {
        a | b
    }

    #[inline(always)]
    fn xor(&mut self, a: Chunk, b: Chunk) -> Chunk {
        a ^ b
    }

    #[inline(always)]
    fn and_not(&mut self, a: Chunk, b: Chunk) -> Chunk {
        a & !b
    }

    #[inline(always)]
    fn shl(&mut self, a: Chunk, _: u32) -> Chunk {
        a
    }

    #[inline(always)]
    fn shr(&mut self, a: Chunk, _: u32) -> Chunk {
        a
    }

    #[inline(always)]
    fn shl_by(&mut self, a: Chunk, _: Chunk) -> Chunk {
        a
    }

    #[inline(always)]
    fn shr_by(&mut self, a: Chunk, _: Chunk) -> Chunk {
        a
    }

    #[inline(always)]
    fn any(&mut self, a: Chunk) -> Chunk {
        a
    }

    #[inline(always)]
    fn parity(&mut self, a: Chunk) -> Chunk {
        a
    }

    #[inline(always)]
    fn several(&mut self, _: Chunk) -> Chunk {
        Chunk::ZERO
    }

    #[inline(always)]
    fn equal(&mut self, a: Chunk, b: Chunk) -> Chunk {
        !(a ^ b)
    }

    #[inline(always)]
    fn less(&mut self, a: Chunk, b: Chunk) -> Chunk {
        !a & b
    }

    #[inline(always)]
    fn select(&mut self, s: Chunk, a: Chunk, b: Chunk) -> Chunk {
        (a & s) | (b & !s)
    }

    #[inline(always)]
    fn splat(&mut self, s: Chunk, mask: u64) -> Chunk {
        if mask & 1 == 1 { s } else { Chunk::ZERO }
    }

    #[inline(always)]
    fn add(&mut self, a: Chunk, b: Chunk, carry: Chunk, _: u32) -> (Chunk, Chunk) {
        let half = a ^ b;
        (half ^ carry, (a & b) | (half & carry))
    }

    #[inline(always)]
    fn mul_add(&mut self, a: Chunk, b: Chunk, c: Chunk, d: Chunk) -> (Chunk, Chunk) {
        self.add(a & b, c, d, 1)
    }

    #[inline(always)]
    fn never(&self, a: Chunk) -> bool {
        !a.any()
    }
}

/// The planes of all bits. A block has `chunks` chunks of lanes.
#[derive(Debug)]
pub(super) struct Planes {
    pub chunks: usize,
    v: Vec<Cell<Chunk>>,
    u: Vec<Cell<Chunk>>,
    /// Whether a bit may be unknown in some lane.
    unknown: Vec<Cell<bool>>,
}

/// The two planes of one bit. With `K` nothing is unknown and the second is not looked at.
#[derive(Clone, Copy)]
pub(super) struct Plane<'p, const K: bool> {
    v: &'p [Cell<Chunk>],
    u: &'p [Cell<Chunk>],
}

impl<const K: bool> Plane<'_, K> {
    #[inline(always)]
    pub fn get(&self, c: usize) -> Four {
        Four { v: self.v[c].get(), u: if K { Chunk::ZERO } else { self.u[c].get() } }
    }

    /// Writes; returns the lanes that change.
    #[inline(always)]
    pub fn put(&self, c: usize, new: Four) -> Chunk {
        let mut changed = self.v[c].get() ^ new.v;
        self.v[c].set(new.v);
        if !K {
            changed |= self.u[c].get() ^ new.u;
            self.u[c].set(new.u);
        }
        changed
    }
}

impl Planes {
    pub fn new(bits: usize, chunks: usize) -> Planes {
        let empty = || vec![Cell::new(Chunk::ZERO); bits * chunks];
        Planes { chunks, v: empty(), u: empty(), unknown: vec![Cell::new(false); bits] }
    }

    #[inline(always)]
    pub fn plane<const K: bool>(&self, bit: u32) -> Plane<'_, K> {
        let (start, n) = (bit as usize * self.chunks, self.chunks);
        Plane { v: &self.v[start..][..n], u: if K { &[] } else { &self.u[start..][..n] } }
    }

    /// All planes of values.
    #[inline(always)]
    pub fn all(&self) -> &[Cell<Chunk>] {
        &self.v
    }

    /// The plane of values of a bit.
    pub fn values(&self, bit: u32) -> &[Cell<Chunk>] {
        &self.v[bit as usize * self.chunks..][..self.chunks]
    }

    /// A chunk of a plane of values, be it of a bit or behind those.
    #[inline(always)]
    pub fn raw(&self, plane: u32, c: usize) -> &Cell<Chunk> {
        &self.v[plane as usize * self.chunks + c]
    }

    /// Writes a bit that is known in some lanes; returns whether any changes.
    pub fn merge(&self, bit: u32, new: Chunk, lanes: &[u64]) -> bool {
        let mut changed = 0;
        for (c, lanes) in lanes.chunks_exact(WORDS).enumerate() {
            let plane = self.raw(bit, c);
            let mut chunk = plane.get();
            for (i, &lanes) in lanes.iter().enumerate() {
                let moved = (chunk.0[i] ^ new.0[i]) & lanes;
                chunk.0[i] ^= moved;
                changed |= moved;
            }
            plane.set(chunk);
        }
        changed != 0
    }

    /// Makes sure that there are so many planes of values.
    pub fn reserve(&mut self, planes: usize) {
        if self.v.len() < planes * self.chunks {
            self.v.resize(planes * self.chunks, Cell::new(Chunk::ZERO));
        }
    }

    /// Whether all of some bits are known in all lanes.
    #[inline(always)]
    pub fn all_known(&self, bits: &[u32]) -> bool {
        bits.iter().all(|&b| !self.unknown[b as usize].get())
    }

    #[inline(always)]
    pub fn may_be_unknown(&self, bit: u32) -> bool {
        self.unknown[bit as usize].get()
    }

    /// Writes a bit chunk by chunk; returns whether any lane changes.
    #[inline(always)]
    pub fn write<const K: bool>(&self, bit: u32, mut new: impl FnMut(usize) -> Four) -> bool {
        let mut changed = Chunk::ZERO;
        if K {
            let plane = self.plane::<true>(bit);
            for c in 0..plane.v.len() {
                changed |= plane.put(c, new(c));
            }
            let cleared = self.may_be_unknown(bit) && self.clear_unknown(bit);
            changed.any() || cleared
        } else {
            let plane = self.plane::<false>(bit);
            let mut unknown = Chunk::ZERO;
            for c in 0..self.chunks {
                let new = new(c);
                unknown |= new.u;
                changed |= plane.put(c, new);
            }
            self.unknown[bit as usize].set(unknown.any());
            changed.any()
        }
    }

    /// Says whether a bit may be unknown in some lane.
    #[inline(always)]
    pub fn set_unknown(&self, bit: u32, unknown: bool) {
        self.unknown[bit as usize].set(unknown);
    }

    /// All lanes of a bit have become known.
    #[inline(never)]
    pub fn clear_unknown(&self, bit: u32) -> bool {
        self.unknown[bit as usize].set(false);
        let plane = self.plane::<false>(bit);
        let mut changed = Chunk::ZERO;
        for u in plane.u {
            changed |= u.replace(Chunk::ZERO);
        }
        changed.any()
    }

    /// Copies a bit to another; returns whether any lane changes.
    #[inline(always)]
    pub fn copy(&self, from: u32, to: u32) -> bool {
        if self.may_be_unknown(from) {
            let from = self.plane::<false>(from);
            self.write::<false>(to, |c| from.get(c))
        } else {
            let from = self.plane::<true>(from);
            self.write::<true>(to, |c| from.get(c))
        }
    }

    /// A bit of one lane.
    #[inline]
    pub fn lane(&self, bit: u32, lane: usize) -> Word {
        let at = bit as usize * self.chunks + lane / LANES;
        let (word, shift) = (lane % LANES / 64, lane % 64);
        Word { v: self.v[at].get().0[word] >> shift & 1, u: self.u[at].get().0[word] >> shift & 1 }
    }

    /// Writes a bit of one lane; returns whether it changes.
    #[inline]
    pub fn set_lane(&self, bit: u32, lane: usize, new: Word) -> bool {
        let at = bit as usize * self.chunks + lane / LANES;
        let (word, shift) = (lane % LANES / 64, lane % 64);
        let mut changed = false;
        for (plane, new) in [(&self.v[at], new.v), (&self.u[at], new.u)] {
            let mut chunk = plane.get();
            let old = chunk.0[word];
            chunk.0[word] = old & !(1 << shift) | (new & 1) << shift;
            changed |= chunk.0[word] != old;
            plane.set(chunk);
        }
        if new.u & 1 != 0 {
            self.unknown[bit as usize].set(true);
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::agree::{bit, cases};
    use crate::cell::{Site, act, at_edge, derived, level};

    /// The pins of a cell as bits, the same in all lanes.
    struct Place<'s> {
        ins: &'s [Vec<Four>],
        q: &'s [Four],
        outs: Vec<Vec<Four>>,
    }

    impl Site<Lanes> for Place<'_> {
        fn get(&self, pin: usize, i: usize) -> Four {
            self.ins[pin][i]
        }

        fn state(&self, i: usize) -> Four {
            self.q[i]
        }

        fn put(&mut self, output: usize, i: usize, w: Four) {
            assert_eq!(self.outs[output].len(), i, "words come in order");
            self.outs[output].push(w);
        }

        fn hold(&mut self) {
            self.outs[0] = self.q.to_vec();
        }
    }

    #[test]
    fn lanes_are_as_machine_words() {
        for case in cases(false, 65) {
            let kind = &case.kind;
            let expected = case.expected();
            let vector = |words: &[Word], width: u32| (0..width).map(|i| Four::splat(bit(words, i))).collect();
            let ins = (0..kind.inputs().len()).map(|pin| vector(&case.ins[pin], kind.input_width(pin)));
            let ins: Vec<Vec<Four>> = ins.collect();
            let place = |q| Place { ins: &ins, q, outs: vec![Vec::new(); 3] };
            let check = |found: &[Four], wanted: &[Word]| {
                for (i, &found) in found.iter().enumerate() {
                    let wanted = Four::splat(bit(wanted, i as u32));
                    assert_eq!(found, wanted, "bit {i} of {kind:?} of {:?}, {:?}", case.ins, case.state);
                }
            };
            let width = kind.output_width(0) as usize;
            if case.state.is_empty() {
                let mut all = place(&[]);
                act(&mut Lanes, kind, &mut all);
                for (pin, wanted) in expected.outputs.iter().enumerate() {
                    assert_eq!(all.outs[pin].len(), kind.output_width(pin) as usize);
                    check(&all.outs[pin], wanted);
                }
                continue;
            }
            let q: Vec<Four> = vector(&case.state, width as u32);
            let (mut at_once, mut next) = (place(&q), place(&q));
            level(&mut Lanes, kind, &mut at_once);
            check(&at_once.outs[0], &expected.outputs[0]);
            let mut second = place(&at_once.outs[0]);
            derived(&mut Lanes, kind, &mut second);
            if let Some(wanted) = expected.outputs.get(1) {
                check(&second.outs[1], wanted);
            }
            at_edge(&mut Lanes, kind, None, &mut next);
            assert_eq!(next.outs[0].len(), width);
            check(&next.outs[0], &expected.next);
        }
    }
}
