//! Four-valued operators on nodes, a node each plane, as [`Word`] has them on words; and what cuts vectors and joins them.

use crate::cell::GateOp;
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

/// Four-valued operators on nodes, as [`Word`] has them on words.
impl Graph {
    pub fn two(&mut self, w: Word) -> Two {
        Two { v: self.constant(w.v), u: self.constant(w.u) }
    }

    pub fn known(&mut self, v: Id) -> Two {
        Two { v, u: self.constant(0) }
    }

    /// The bits that are certainly 1.
    pub fn ones(&mut self, a: Two) -> Id {
        self.and_not(a.v, a.u)
    }

    pub fn read4(&mut self, a: Two) -> Two {
        Two { v: self.ones(a), u: a.u }
    }

    pub fn mask4(&mut self, a: Two, m: u64) -> Two {
        let m = self.constant(m);
        Two { v: self.and(a.v, m), u: self.and(a.u, m) }
    }

    pub fn bits4(&mut self, a: Two, lo: u32, width: u32) -> Two {
        Two { v: self.bits(a.v, lo, width), u: self.bits(a.u, lo, width) }
    }

    pub fn and4(&mut self, a: Two, b: Two) -> Two {
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.and(x, y);
        let either = self.or(a.u, b.u);
        let (a1, b1) = (self.or(a.u, a.v), self.or(b.u, b.v));
        let u = self.and(either, a1);
        Two { v, u: self.and(u, b1) }
    }

    pub fn or4(&mut self, a: Two, b: Two) -> Two {
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.or(x, y);
        let u = self.or(a.u, b.u);
        Two { v, u: self.and_not(u, v) }
    }

    pub fn xor4(&mut self, a: Two, b: Two) -> Two {
        let u = self.or(a.u, b.u);
        let v = self.xor(a.v, b.v);
        Two { v: self.and_not(v, u), u }
    }

    pub fn not4(&mut self, a: Two, m: u64) -> Two {
        let one = self.or(a.v, a.u);
        let all = self.constant(m);
        let v = self.and_not(all, one);
        Two { v, u: self.and(a.u, all) }
    }

    pub fn merge4(&mut self, a: Two, b: Two) -> Two {
        let differ = self.xor(a.v, b.v);
        let u = self.or(a.u, b.u);
        let u = self.or(u, differ);
        Two { v: self.and_not(a.v, u), u }
    }

    pub fn resolve4(&mut self, a: Two, b: Two, m: u64) -> Two {
        let (za, zb) = (self.and(a.v, a.u), self.and(b.v, b.u));
        let all = self.constant(m);
        let both = self.and_not(all, za);
        let both = self.and_not(both, zb);
        let differ = self.xor(a.v, b.v);
        let conflict = self.or(a.u, b.u);
        let conflict = self.or(conflict, differ);
        let conflict = self.and(both, conflict);
        let same = self.and(a.v, b.v);
        let same = self.and(both, same);
        let same = self.and_not(same, conflict);
        let (av, bv) = (self.and(zb, a.v), self.and(za, b.v));
        let (au, bu) = (self.and(zb, a.u), self.and(za, b.u));
        let v = self.or(av, bv);
        let u = self.or(au, bu);
        Two { v: self.or(v, same), u: self.or(u, conflict) }
    }

    /// `a` where `s`, a node of 0 or 1, is 1.
    pub fn pick4(&mut self, s: Id, a: Two, b: Two) -> Two {
        Two { v: self.select(s, a.v, b.v), u: self.select(s, a.u, b.u) }
    }

    /// A multiplexer of two with a four-valued select.
    pub fn mux4(&mut self, s: Two, one: Two, zero: Two) -> Two {
        let chosen = self.pick4(s.v, one, zero);
        if self.is(s.u, 0) {
            return chosen;
        }
        let merged = self.merge4(zero, one);
        self.pick4(s.u, merged, chosen)
    }

    pub fn join(&mut self, op: GateOp, a: Two, b: Two) -> Two {
        match op {
            GateOp::And | GateOp::Nand => self.and4(a, b),
            GateOp::Xor | GateOp::Xnor => self.xor4(a, b),
            GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => self.or4(a, b),
        }
    }

    pub fn finish(&mut self, op: GateOp, a: Two, m: u64) -> Two {
        if op.inverts() {
            return self.not4(a, m);
        }
        let a = self.read4(a);
        self.mask4(a, m)
    }

    /// All bits of `w` within `m` joined into one.
    pub fn reduce(&mut self, op: GateOp, w: Two, m: u64) -> Two {
        let w = self.mask4(w, m);
        if m == 1 {
            return self.read4(w);
        }
        let ones = self.ones(w);
        let (all, unknown) = (self.constant(m), self.any(w.u));
        match op {
            GateOp::And | GateOp::Nand => {
                let v = self.eq(ones, all);
                let one = self.or(w.v, w.u);
                let no_zero = self.eq(one, all);
                Two { v, u: self.and(no_zero, unknown) }
            }
            GateOp::Xor | GateOp::Xnor => {
                let n = self.count(ones);
                let v = self.bits(n, 0, 1);
                Two { v: self.and_not(v, unknown), u: unknown }
            }
            _ => {
                let v = self.any(ones);
                Two { v, u: self.and_not(unknown, v) }
            }
        }
    }

    /// Whether bit 0 is 1.
    pub fn is_one(&mut self, a: Two) -> Id {
        let one = self.ones(a);
        self.bits(one, 0, 1)
    }

    pub fn is_zero4(&mut self, a: Two) -> Id {
        let some = self.or(a.v, a.u);
        let some = self.bits(some, 0, 1);
        self.not(some, 1)
    }

    pub fn any_unknown(&mut self, a: &[Two]) -> Id {
        let zero = self.constant(0);
        let all = a.iter().fold(zero, |all, w| self.or(all, w.u));
        self.any(all)
    }

    /// `a`, or all x where `unknown`, a node of 0 or 1, is 1.
    pub fn unless(&mut self, unknown: Id, a: Id, m: u64) -> Two {
        let none = self.constant(0);
        Two { v: self.select(unknown, none, a), u: self.splat(unknown, m) }
    }

    /// Two's complement of `width` bits in all 64.
    pub fn extend(&mut self, a: Id, width: u32) -> Id {
        if width >= 64 {
            return a;
        }
        let sign = self.constant(1 << (width - 1));
        let flipped = self.xor(a, sign);
        self.sub(flipped, sign)
    }

    /// `a + b + ci`, or `a - b - ci` where `sub` is 1, modulo 2^width, and the carry or borrow.
    pub fn sum(&mut self, width: u32, a: &[Two], b: &[Two], ci: Two, sub: Two) -> (Bits, Two) {
        let (x, y) = (self.any_unknown(a), self.any_unknown(b));
        let controls = self.or(ci.u, sub.u);
        let unknown = self.or(x, y);
        let unknown = self.or(unknown, controls);
        let n = words(width);
        let mut out = Vec::with_capacity(n);
        let subtracts = self.is(sub.v, 1) && self.is(sub.u, 0);
        let adds = self.is(sub.v, 0) && self.is(sub.u, 0);
        let mut carry = if subtracts || adds { ci.v } else { self.xor(ci.v, sub.v) };
        for i in 0..n {
            let m = word_mask(width, i);
            let w = m.count_ones();
            if subtracts {
                let d = self.sub(a[i].v, b[i].v);
                let y = self.sub(d, carry);
                carry = if w < 64 {
                    self.bits(y, 63, 1)
                } else {
                    let (c1, c2) = (self.less(a[i].v, b[i].v), self.less(d, carry));
                    self.or(c1, c2)
                };
                let y = self.bits(y, 0, w);
                out.push(self.unless(unknown, y, m));
                continue;
            }
            let invert = self.splat(sub.v, m);
            let other = self.xor(b[i].v, invert);
            let s = self.add(a[i].v, other);
            let y = self.add(s, carry);
            carry = if w < 64 {
                self.bits(y, w, 1)
            } else {
                let (c1, c2) = (self.less(s, a[i].v), self.less(y, s));
                self.or(c1, c2)
            };
            let y = self.bits(y, 0, w);
            out.push(self.unless(unknown, y, m));
        }
        let carry = if subtracts { carry } else { self.xor(carry, sub.v) };
        (out, self.unless(unknown, carry, 1))
    }

    pub fn x(&mut self, width: u32) -> Bits {
        (0..words(width)).map(|i| self.two(Word::x(word_mask(width, i)))).collect()
    }

    pub fn literal(&mut self, value: &crate::Value) -> Bits {
        value.words().map(|w| self.two(w)).collect()
    }

    pub fn zeros(&mut self, width: u32) -> Bits {
        (0..words(width)).map(|_| self.two(Word::ZERO)).collect()
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
                return g.bits4(low, shift, w);
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
    let none = g.two(Word::ZERO);
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
