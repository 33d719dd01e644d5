//! Carries as Yosys' arithmetic cells have them: three numbers to two, a carry chain, an adder with all its carries.

use super::algebra::{Algebra, Site, unknown};
use super::pin::{alu, carry, ternary};

/// Bit by bit `a + b + c`: the sums into `y`, the carries into `x`; both x where one of the three is unknown.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn carry_save<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    for i in 0..A::words(width) {
        let ((a, au), (b, bu)) = (A::planes(s.get(ternary::A, i)), A::planes(s.get(ternary::B, i)));
        let (c, cu) = A::planes(s.get(ternary::C, i));
        let u = l.or(au, bu);
        let u = l.or(u, cu);
        let (a, b, c) = (l.and_not(a, u), l.and_not(b, u), l.and_not(c, u));
        let half = l.xor(a, b);
        let sum = l.xor(half, c);
        let (both, passed) = (l.and(a, b), l.and(c, half));
        let carries = l.or(both, passed);
        s.put(0, i, A::word(carries, u));
        s.put(1, i, A::word(sum, u));
    }
}

/// The carries of a chain that generates at `g` and propagates at `p`; all x where anything is unknown.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn chain<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let (p, g) = (unknown(l, s, carry::P, width), unknown(l, s, carry::G, width));
    let (mut carry, u) = A::planes(s.get(carry::CI, 0));
    let unknown = l.or(p, g);
    let unknown = l.or(unknown, u);
    for i in 0..A::words(width) {
        let (p, g) = (A::planes(s.get(carry::P, i)).0, A::planes(s.get(carry::G, i)).0);
        let m = A::mask(width, i);
        let mut all = l.constant(0);
        for k in 0..m.count_ones() {
            let (p, g) = (l.bits(p, k, 1), l.bits(g, k, 1));
            let passed = l.and(p, carry);
            carry = l.or(g, passed);
            let placed = l.shl(carry, k);
            all = l.or(all, placed);
        }
        let y = l.unless(unknown, all, m);
        s.put(0, i, y);
    }
}

/// Shape of an adder with all its carries.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub struct Alu {
    /// Bits of `a`.
    pub a_width: u32,
    /// Bits of `b`.
    pub b_width: u32,
    /// Bits of the result.
    pub width: u32,
    /// The operands are extended by their sign.
    pub signed: bool,
}

impl Alu {
    /// Word `i` of an operand of `from` bits, extended or cut to the width of the result.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn operand<A: Algebra>(&self, l: &mut A, s: &impl Site<A>, pin: usize, from: u32, i: usize) -> A::Word {
        let (n, m) = (A::words(from), A::mask(self.width, i));
        let (mut v, mut u) = if i < n {
            let own = l.low4(s.get(pin, i), m.count_ones());
            A::planes(own)
        } else {
            (l.constant(0), l.constant(0))
        };
        let above = m & !if i < n { A::mask(from, i) } else { 0 };
        if self.signed && above != 0 {
            let (sign_v, sign_u) = A::planes(s.get(pin, n - 1));
            let at = (from - 1) % A::BITS;
            let (sign_v, sign_u) = (l.bits(sign_v, at, 1), l.bits(sign_u, at, 1));
            let (high_v, high_u) = (l.splat(sign_v, above), l.splat(sign_u, above));
            (v, u) = (l.or(v, high_v), l.or(u, high_u));
        }
        A::word(v, u)
    }

    /// `a + (b ^ bi) + ci`: the bitwise exclusive or into `x`, the sum into `y`, the carries into `co`. Sum and carries
    /// are all x where anything is unknown.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn add<A: Algebra>(&self, l: &mut A, s: &mut impl Site<A>) {
        let (a, b) = (unknown(l, s, alu::A, self.a_width), unknown(l, s, alu::B, self.b_width));
        let ((ci, ci_u), (bi, bi_u)) = (A::planes(s.get(alu::CI, 0)), A::planes(s.get(alu::BI, 0)));
        let unknown = l.or(a, b);
        let controls = l.or(ci_u, bi_u);
        let unknown = l.or(unknown, controls);
        let mut carry = ci;
        for i in 0..A::words(self.width) {
            let m = A::mask(self.width, i);
            let a = self.operand(l, s, alu::A, self.a_width, i);
            let b = self.operand(l, s, alu::B, self.b_width, i);
            let invert = A::word(l.splat(bi, m), l.splat(bi_u, m));
            let b = l.xor4(b, invert);
            let x = l.xor4(a, b);
            s.put(0, i, x);
            let (a, b) = (A::planes(a).0, A::planes(b).0);
            let (sum, out) = l.add(a, b, carry, m.count_ones());
            // a bit of the sum differs from that of the exclusive or where a carry comes in from below
            let into = l.xor(sum, a);
            let into = l.xor(into, b);
            let (both, some) = (l.and(a, b), l.or(a, b));
            let passed = l.and(into, some);
            let carries = l.or(both, passed);
            let (y, co) = (l.unless(unknown, sum, m), l.unless(unknown, carries, m));
            s.put(1, i, y);
            s.put(2, i, co);
            carry = out;
        }
    }
}
