//! The values of all lanes: for each bit of the netlist a plane of values and a plane that says which are unknown, one
//! bit a lane.
//!
//! Everything here is inlined into the functions that are compiled for each vector extension.

use std::cell::Cell;
use std::ops::{BitAnd, BitOr, BitOrAssign, BitXor, Not};

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

/// A four-valued bit of each of 512 lanes; the planes mean what they mean in [`Word`], and the operators are its.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Four {
    pub v: Chunk,
    pub u: Chunk,
}

impl Four {
    pub const X: Four = Four { v: Chunk::ZERO, u: Chunk::ONES };
    pub const Z: Four = Four { v: Chunk::ONES, u: Chunk::ONES };

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

    #[inline(always)]
    pub fn and(self, o: Four) -> Four {
        let (a, b) = (self.ones(), o.ones());
        Four { v: a & b, u: (self.u | o.u) & (self.u | a) & (o.u | b) }
    }

    #[inline(always)]
    pub fn or(self, o: Four) -> Four {
        let v = self.ones() | o.ones();
        Four { v, u: (self.u | o.u) & !v }
    }

    #[inline(always)]
    pub fn xor(self, o: Four) -> Four {
        let u = self.u | o.u;
        Four { v: (self.v ^ o.v) & !u, u }
    }

    #[inline(always)]
    pub fn not(self) -> Four {
        Four { v: self.zeros(), u: self.u }
    }

    #[inline(always)]
    pub fn merge(self, o: Four) -> Four {
        let u = self.u | o.u | (self.v ^ o.v);
        Four { v: self.v & !u, u }
    }

    #[inline(always)]
    pub fn resolve(self, o: Four) -> Four {
        let (za, zb) = (self.v & self.u, o.v & o.u);
        let both = !za & !zb;
        let conflict = both & (self.u | o.u | (self.v ^ o.v));
        Four {
            v: (za & o.v) | (zb & self.v) | (both & self.v & o.v & !conflict),
            u: (za & o.u) | (zb & self.u) | conflict,
        }
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

    /// What a multiplexer gives whose select is `self`.
    #[inline(always)]
    pub fn choose(self, a: Four, b: Four) -> Four {
        let both = a.merge(b);
        a.within(self.zeros()).join(b.within(self.ones())).join(both.within(self.u))
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
    fn put(&self, c: usize, new: Four) -> Chunk {
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

    /// All lanes of a bit have become known.
    #[inline(never)]
    fn clear_unknown(&self, bit: u32) -> bool {
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
