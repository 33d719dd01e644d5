//! Division, remainder and power. Any x or z among the operands, and a divisor of zero, make every bit x
//! (IEEE 1364-2005, 5.1.5).

use crate::value::Word;
use crate::value::word::{any_unknown, word_mask, words};

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

fn all_x(width: u32, y: &mut [Word]) {
    y.iter_mut().enumerate().for_each(|(i, y)| *y = Word::x(word_mask(width, i)));
}

fn is_negative(width: u32, a: &[u64]) -> bool {
    a[words(width) - 1] >> ((width - 1) % 64) & 1 == 1
}

fn negate(width: u32, a: &mut [u64]) {
    let mut carry = true;
    for (i, w) in a.iter_mut().enumerate() {
        let (n, c) = (!*w).overflowing_add(u64::from(carry));
        carry = c;
        *w = n & word_mask(width, i);
    }
}

/// `a - b`, and whether it does not go below zero.
fn subtract(a: &[u64], b: &[u64], into: &mut [u64]) -> bool {
    let mut borrow = false;
    for i in 0..a.len() {
        let (d, b1) = a[i].overflowing_sub(b[i]);
        let (d, b2) = d.overflowing_sub(u64::from(borrow));
        into[i] = d;
        borrow = b1 | b2;
    }
    !borrow
}

/// Quotient and remainder of unsigned numbers, into `q` and `r`; `b` is not zero.
fn divide_unsigned(width: u32, a: &[u64], b: &[u64], q: &mut [u64], r: &mut [u64]) {
    if a.len() == 1 {
        (q[0], r[0]) = (a[0] / b[0], a[0] % b[0]);
        return;
    }
    // one bit at a time; a remainder that a shift pushes out of its words is above any divisor
    let mut difference = vec![0; a.len()];
    for bit in (0..width).rev() {
        let (at, shift) = (bit as usize / 64, bit % 64);
        let mut carry = a[at] >> shift & 1;
        for w in r.iter_mut() {
            (*w, carry) = (*w << 1 | carry, *w >> 63);
        }
        if subtract(r, b, &mut difference) || carry == 1 {
            r.copy_from_slice(&difference);
            q[at] |= 1 << shift;
        }
    }
}

/// Divides numbers of `width` bits.
pub fn divide(op: DivideOp, width: u32, signed: bool, a: &[Word], b: &[Word], y: &mut [Word]) {
    let n = words(width);
    if any_unknown(a) || any_unknown(b) || b.iter().all(|w| w.v == 0) {
        return all_x(width, y);
    }
    let known = |from: &[Word]| from.iter().map(|w| w.v).collect::<Vec<u64>>();
    let (mut a, mut b) = (known(a), known(b));
    let (a_negative, b_negative) = (signed && is_negative(width, &a), signed && is_negative(width, &b));
    if a_negative {
        negate(width, &mut a);
    }
    if b_negative {
        negate(width, &mut b);
    }
    let (mut q, mut r) = (vec![0; n], vec![0; n]);
    divide_unsigned(width, &a, &b, &mut q, &mut r);
    let inexact = r.iter().any(|&w| w != 0);
    let down = a_negative != b_negative && inexact;
    let quotient = matches!(op, DivideOp::Quotient | DivideOp::Floor);
    let result = if quotient { &mut q } else { &mut r };
    match op {
        // -q - 1 is !q
        DivideOp::Floor if down => result.iter_mut().enumerate().for_each(|(i, w)| *w = !*w & word_mask(width, i)),
        DivideOp::Quotient | DivideOp::Floor if a_negative != b_negative => negate(width, result),
        // of the magnitudes: b - r, with the sign of b
        DivideOp::Modulo if down => {
            let rest = result.clone();
            subtract(&b, &rest, result);
            if b_negative {
                negate(width, result);
            }
        }
        DivideOp::Remainder | DivideOp::Modulo if a_negative => negate(width, result),
        _ => {}
    }
    for (y, &w) in y.iter_mut().zip(result.iter()) {
        *y = Word::known(w);
    }
}

/// The low words of a product.
fn times(width: u32, a: &[u64], b: &[u64]) -> Vec<u64> {
    let n = a.len();
    let mut y = vec![0u64; n];
    for i in 0..n {
        let mut carry = 0u128;
        for j in 0..n - i {
            let sum = u128::from(a[i]) * u128::from(b[j]) + u128::from(y[i + j]) + carry;
            y[i + j] = sum as u64;
            carry = sum >> 64;
        }
    }
    y[n - 1] &= word_mask(width, n - 1);
    y
}

/// `a` to the power of `b`, the low `width` bits. Below zero the power of a number other than 1 and -1 is 0, that of 0
/// is x (IEEE 1364-2005, 5.1.5, table 5-6).
pub fn power(width: u32, b_width: u32, (a_signed, b_signed): (bool, bool), a: &[Word], b: &[Word], y: &mut [Word]) {
    if any_unknown(a) || any_unknown(b) {
        return all_x(width, y);
    }
    let base: Vec<u64> = a.iter().map(|w| w.v).collect();
    let is = |from: &[u64], low: u64| from[0] == low && from[1..].iter().all(|&w| w == 0);
    let odd = b[0].v & 1 == 1;
    let mut result = vec![0u64; base.len()];
    let exponent: Vec<u64> = b.iter().map(|w| w.v).collect();
    if b_signed && is_negative(b_width, &exponent) {
        let minus_one = a_signed && base.iter().enumerate().all(|(i, &w)| w == word_mask(width, i));
        if is(&base, 0) {
            return all_x(width, y);
        } else if minus_one && odd {
            result.clone_from(&base);
        } else if minus_one || is(&base, 1) {
            result[0] = 1;
        }
    } else {
        result[0] = 1;
        let mut square = base;
        let top = (0..b_width).rev().find(|&i| exponent[i as usize / 64] >> (i % 64) & 1 == 1);
        for i in 0..top.map_or(0, |top| top + 1) {
            if exponent[i as usize / 64] >> (i % 64) & 1 == 1 {
                result = times(width, &result, &square);
            }
            square = times(width, &square, &square);
        }
    }
    for (y, w) in y.iter_mut().zip(result) {
        *y = Word::known(w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
