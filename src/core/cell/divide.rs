//! Division, remainder and power. Any x or z among the operands, and a divisor of zero, make every bit x
//! (IEEE 1364-2005, 5.1.5).

use smallvec::SmallVec;

use super::algebra::{Algebra, Site, put_x, unknown, value_bit};
use super::arith::put_number;
use super::pin::binary;
use crate::value::word::mask;

/// What a divider gives.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum DivideOp {
    /// The quotient, rounded towards zero.
    Quotient,
    /// The remainder of that, with the sign of the dividend.
    Remainder,
    /// The quotient, rounded down.
    Floor,
    /// The remainder of that, with the sign of the divisor.
    Modulo,
}

type Number<A> = SmallVec<[<A as Algebra>::Plane; 2]>;

/// The value plane of a pin.
#[inline(always)]
fn number<A: Algebra>(s: &impl Site<A>, pin: usize, width: u32) -> Number<A> {
    (0..A::words(width)).map(|i| A::planes(s.get(pin, i)).0).collect()
}

/// Whether any bit of a number is 1.
#[inline(always)]
fn any<A: Algebra>(l: &mut A, a: &[A::Plane]) -> A::Plane {
    let mut all = l.constant(0);
    for &w in a {
        all = l.or(all, w);
    }
    l.any(all)
}

/// `a - b` in whole words, and whether that is below 0.
#[cfg_attr(not(debug_assertions), inline(always))]
fn subtract<A: Algebra>(l: &mut A, a: &[A::Plane], b: &[A::Plane]) -> (Number<A>, A::Plane) {
    let mut borrow = l.constant(0);
    let difference = a.iter().zip(b).map(|(&a, &b)| {
        let (y, below) = l.sub(a, b, borrow, A::BITS);
        borrow = below;
        y
    });
    (difference.collect(), borrow)
}

#[inline(always)]
fn select<A: Algebra>(l: &mut A, s: A::Plane, a: &[A::Plane], b: &[A::Plane]) -> Number<A> {
    a.iter().zip(b).map(|(&a, &b)| l.select(s, a, b)).collect()
}

/// The negative of a number of `width` bits where `s` is 1.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn negated_if<A: Algebra>(l: &mut A, s: A::Plane, a: &[A::Plane], width: u32) -> Number<A> {
    if l.never(s) {
        return a.iter().copied().collect();
    }
    let zero = l.constant(0);
    let none: Number<A> = SmallVec::from_elem(zero, a.len());
    let (mut minus, _) = subtract(l, &none, a);
    for (i, w) in minus.iter_mut().enumerate() {
        *w = l.bits(*w, 0, A::mask(width, i).count_ones());
    }
    select(l, s, &minus, a)
}

/// Quotient and remainder of numbers without a sign, a bit at a time; the divisor is not 0.
#[cfg_attr(not(debug_assertions), inline(always))]
fn divide_unsigned<A: Algebra>(l: &mut A, width: u32, a: &[A::Plane], b: &[A::Plane]) -> (Number<A>, Number<A>) {
    if a.len() == 1
        && let Some((q, r)) = l.quotient(a[0], b[0])
    {
        return (SmallVec::from_elem(q, 1), SmallVec::from_elem(r, 1));
    }
    let zero = l.constant(0);
    let mut q: Number<A> = SmallVec::from_elem(zero, a.len());
    let mut r = q.clone();
    for bit in (0..width).rev() {
        let (at, shift) = ((bit / A::BITS) as usize, bit % A::BITS);
        let mut carry = l.bits(a[at], shift, 1);
        for w in &mut r {
            let out = l.bits(*w, A::BITS - 1, 1);
            let up = if A::BITS == 1 { zero } else { l.shl(*w, 1) };
            *w = l.or(up, carry);
            carry = out;
        }
        let (difference, below) = subtract(l, &r, b);
        // a remainder that a shift pushes out of its words is above any divisor
        let below = l.and_not(below, carry);
        let fits = l.not(below, 1);
        r = select(l, fits, &difference, &r);
        let one = l.shl(fits, shift);
        q[at] = l.or(q[at], one);
    }
    (q, r)
}

/// Divides numbers of `width` bits.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn divide<A: Algebra>(l: &mut A, s: &mut impl Site<A>, op: DivideOp, width: u32, signed: bool) {
    let (a, b) = (number(s, binary::A, width), number(s, binary::B, width));
    let some = any(l, &b);
    let by_zero = l.not(some, 1);
    let (x, y) = (unknown(l, s, binary::A, width), unknown(l, s, binary::B, width));
    let unknown = l.or(x, y);
    let unknown = l.or(unknown, by_zero);
    if l.known(unknown).is_some_and(|n| n != 0) {
        return put_x(l, s, 0, width);
    }
    let sign = |l: &mut A, pin| if signed { value_bit(l, s, pin, width - 1) } else { l.constant(0) };
    let (a_negative, b_negative) = (sign(l, binary::A), sign(l, binary::B));
    let (a, mut b) = (negated_if(l, a_negative, &a, width), negated_if(l, b_negative, &b, width));
    let one = l.constant(1);
    b[0] = l.select(by_zero, one, b[0]);
    let (q, r) = divide_unsigned(l, width, &a, &b);
    let differ = l.xor(a_negative, b_negative);
    let inexact = any(l, &r);
    let down = l.and(differ, inexact);
    let result = match op {
        DivideOp::Quotient => negated_if(l, differ, &q, width),
        DivideOp::Floor => {
            let truncated = negated_if(l, differ, &q, width);
            // -q - 1 is !q
            let below: Number<A> = q.iter().map(|&w| l.not(w, mask(A::BITS))).collect();
            select(l, down, &below, &truncated)
        }
        DivideOp::Remainder => negated_if(l, a_negative, &r, width),
        DivideOp::Modulo => {
            // of the magnitudes: b - r, with the sign of b
            let same = negated_if(l, a_negative, &r, width);
            let (rest, _) = subtract(l, &b, &r);
            let rest = negated_if(l, b_negative, &rest, width);
            select(l, down, &rest, &same)
        }
    };
    put_number(l, s, width, unknown, &result);
}

/// The low words of a product.
#[cfg_attr(not(debug_assertions), inline(always))]
fn times<A: Algebra>(l: &mut A, a: &[A::Plane], b: &[A::Plane]) -> Number<A> {
    let (n, zero) = (a.len(), l.constant(0));
    let mut y: Number<A> = SmallVec::from_elem(zero, n);
    for i in 0..n {
        let mut carry = zero;
        for k in 0..n - i {
            (y[i + k], carry) = l.mul_add(a[i], b[k], y[i + k], carry);
        }
    }
    y
}

/// Whether a number is this small one.
#[inline(always)]
fn is<A: Algebra>(l: &mut A, a: &[A::Plane], small: u64) -> A::Plane {
    let small = l.constant(small);
    let first = l.equal(a[0], small);
    let above = any(l, &a[1..]);
    l.and_not(first, above)
}

/// `a` to the power of `b`, the low `width` bits. Below zero the power of a number other than 1 and -1 is 0, that of 0
/// is x (IEEE 1364-2005, 5.1.5, table 5-6).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn power<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    (width, b_width): (u32, u32),
    (a_signed, b_signed): (bool, bool),
) {
    let (x, y) = (unknown(l, s, binary::A, width), unknown(l, s, binary::B, b_width));
    let mut unknown = l.or(x, y);
    if l.known(unknown).is_some_and(|n| n != 0) {
        return put_x(l, s, 0, width);
    }
    let base = number(s, binary::A, width);
    let (zero, one) = (l.constant(0), l.constant(1));
    let mut unit: Number<A> = SmallVec::from_elem(zero, base.len());
    unit[0] = one;
    let (mut result, mut square) = (unit.clone(), base.clone());
    // no further than the highest bit that is 1, as far as that is known
    let known_zero = |l: &mut A, i: u32| {
        let bit = value_bit(l, s, binary::B, i);
        l.never(bit)
    };
    let mut top = (0..b_width).rev().find(|&i| !known_zero(l, i)).map_or(0, |top| top + 1);
    let last = value_bit(l, s, binary::B, b_width - 1);
    if b_signed && l.known(last) == Some(1) {
        top = 0;
    }
    for i in 0..top {
        let bit = value_bit(l, s, binary::B, i);
        if !l.never(bit) {
            let product = times(l, &result, &square);
            result = select(l, bit, &product, &result);
        }
        if i + 1 < top {
            square = times(l, &square, &square);
        }
    }
    if b_signed {
        // to a negative power: 0 is unknown, 1 is 1, -1 is what an odd or even number of it is, and all else is 0
        let negative = value_bit(l, s, binary::B, b_width - 1);
        let (is_zero, is_one) = (is(l, &base, 0), is(l, &base, 1));
        let mut minus_one = if a_signed { one } else { zero };
        for (i, &w) in base.iter().enumerate() {
            let all = l.all(w, A::mask(width, i));
            minus_one = l.and(minus_one, all);
        }
        let odd = value_bit(l, s, binary::B, 0);
        let of_minus_one = select(l, odd, &base, &unit);
        let none: Number<A> = SmallVec::from_elem(zero, base.len());
        let of_others = select(l, is_one, &unit, &none);
        let inverse = select(l, minus_one, &of_minus_one, &of_others);
        result = select(l, negative, &inverse, &result);
        let none = l.and(negative, is_zero);
        unknown = l.or(unknown, none);
    }
    put_number(l, s, width, unknown, &result);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::{CellKind, evaluate};
    use crate::value::Word;
    use crate::value::word::{word_mask, words};
    use proptest::prelude::*;

    fn divide(op: DivideOp, width: u32, signed: bool, a: &[Word], b: &[Word], y: &mut [Word]) {
        evaluate(&CellKind::Divide { op, width, signed }, &[a, b], &mut [y]);
    }

    fn power(width: u32, b_width: u32, signed: (bool, bool), a: &[Word], b: &[Word], y: &mut [Word]) {
        let kind = CellKind::Power { width, b_width, a_signed: signed.0, b_signed: signed.1 };
        evaluate(&kind, &[a, b], &mut [y]);
    }

    fn number(n: i128, width: u32) -> Vec<Word> {
        (0..words(width)).map(|i| Word::known((n >> (64 * i)) as u64 & word_mask(width, i))).collect()
    }

    fn value(words_of: &[Word], width: u32, signed: bool) -> i128 {
        let low = words_of.iter().enumerate().fold(0u128, |n, (i, w)| n | u128::from(w.v) << (64 * i));
        let shift = 128 - width;
        if signed { ((low << shift) as i128) >> shift } else { low as i128 }
    }

    proptest! {
        /// Against the host's integers; 100 bits leave room for the sign and for MIN / -1.
        #[test]
        fn as_the_host_divides(a: i64, b: i64, small in -9i64..10, wide: bool, signed: bool) {
            let width = if wide { 100 } else { 65 };
            for b in [b, small] {
                if b == 0 || (!signed && (a < 0 || b < 0)) { continue; }
                let (wa, wb) = (number(a.into(), width), number(b.into(), width));
                let run = |op| {
                    let mut y = vec![Word::ZERO; words(width)];
                    divide(op, width, signed, &wa, &wb, &mut y);
                    value(&y, width, signed)
                };
                let (a, b) = (i128::from(a), i128::from(b));
                let floor = a.div_euclid(b) - i128::from(b < 0 && a.rem_euclid(b) != 0);
                prop_assert_eq!(run(DivideOp::Quotient), a / b);
                prop_assert_eq!(run(DivideOp::Remainder), a % b);
                prop_assert_eq!(run(DivideOp::Floor), floor);
                prop_assert_eq!(run(DivideOp::Modulo), a - b * floor);
            }
        }

        #[test]
        fn powers_wrap(a: u64, b in 0u32..200) {
            let mut y = [Word::ZERO];
            power(64, 8, (false, false), &[Word::known(a)], &[Word::known(b.into())], &mut y);
            prop_assert_eq!(y[0].v, a.wrapping_pow(b));
        }
    }

    #[test]
    fn a_divisor_of_zero_and_negative_powers() {
        let mut y = [Word::ZERO];
        divide(DivideOp::Quotient, 4, false, &[Word::known(3)], &[Word::known(0)], &mut y);
        assert_eq!(y[0], Word::x(15));
        let mut of = |a: u64| {
            power(4, 4, (true, true), &[Word::known(a)], &[Word::known(13)], &mut y);
            y[0]
        };
        assert_eq!([of(0), of(1), of(15), of(2)], [Word::x(15), Word::known(1), Word::known(15), Word::known(0)]);
    }
}
