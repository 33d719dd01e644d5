//! Shifts, products and quotients of vectors of more than one word, from operations on words, as the cell room has them;
//! and powers.

use crate::cell::{DivideOp, ShiftOp};
use crate::compiled::ir::graph::{Graph, Id};
use crate::compiled::lower::four::{Bits, Two};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

/// Bits of a shifter, and of the product of a multiplier, up to which it is compiled.
pub(crate) const MOST_BITS: u32 = 1024;
/// Bits of a divider up to which it is compiled: each is a step.
pub(crate) const MOST_DIVIDED: u32 = 128;

/// How far a shift goes, an id each a number or a truth.
struct Amount {
    unknown: Id,
    /// To the left: a shift to the left, or to the right by a negative number.
    left: Id,
    /// The low word.
    by: Id,
    /// More than a word can say.
    beyond: Id,
}

fn amount(g: &mut Graph, op: ShiftOp, b_width: u32, b: &[Two]) -> Amount {
    let n = words(b_width);
    let (zero, ones) = (g.constant(0), g.constant(u64::MAX));
    let signed = matches!(op, ShiftOp::Both | ShiftOp::PartSigned);
    let left = match signed {
        true => g.bits(b[n - 1].v, (b_width - 1) % 64, 1),
        false => g.constant(u64::from(op == ShiftOp::Left)),
    };
    let number: Vec<Id> = (0..n)
        .map(|i| match signed && i + 1 == n {
            true => g.extend(b[i].v, (b_width - 1) % 64 + 1),
            false => b[i].v,
        })
        .collect();
    let negative = if signed { left } else { zero };
    let minus = g.sub(zero, number[0]);
    // what is negative has all ones above, and a low word that is not 0
    let fill = g.select(negative, ones, zero);
    let above = number[1..].iter().fold(zero, |all, &w| {
        let other = g.xor(w, fill);
        g.or(all, other)
    });
    let mut beyond = g.any(above);
    if n > 1 && signed {
        let none = g.eq(number[0], zero);
        let whole = g.and(none, negative);
        beyond = g.or(beyond, whole);
    }
    Amount { unknown: g.any_unknown(&b[..n]), left, by: g.select(negative, minus, number[0]), beyond }
}

/// `a`, in one plane, moved by `by` bits, which are below 64 times the number of words or beyond them all; what comes in
/// are bits of `fill`, which are all alike.
fn moved(g: &mut Graph, to_left: bool, a: &[Id], by: Id, beyond: Id, fill: Id, n: usize) -> Vec<Id> {
    let mut from = a.to_vec();
    if to_left {
        from.truncate(n);
    }
    let levels = (from.len().max(n) + 1).next_power_of_two().trailing_zeros();
    let at = |from: &[Id], i: usize, k: usize| match to_left {
        true => i.checked_sub(k).map_or(fill, |i| from.get(i).copied().unwrap_or(fill)),
        false => from.get(i + k).copied().unwrap_or(fill),
    };
    for level in 0..levels {
        let s = g.bits(by, 6 + level, 1);
        from = (0..if to_left { n } else { from.len() })
            .map(|i| {
                let (far, here) = (at(&from, i, 1 << level), at(&from, i, 0));
                g.select(s, far, here)
            })
            .collect();
    }
    let more = g.shr(by, 6 + levels);
    let more = g.any(more);
    let beyond = g.or(beyond, more);
    let bits = g.bits(by, 0, 6);
    let rest = g.constant(63);
    let rest = g.sub(rest, bits);
    (0..n)
        .map(|i| {
            let (here, next) = (at(&from, i, 0), at(&from, i, 1));
            let y = if to_left {
                let (high, low) = (g.shl_by(here, bits), g.shr(next, 1));
                let low = g.shr_by(low, rest);
                g.or(high, low)
            } else {
                let (low, high) = (g.shr_by(here, bits), g.shl(next, 1));
                let high = g.shl_by(high, rest);
                g.or(high, low)
            };
            g.select(beyond, fill, y)
        })
        .collect()
}

/// Shifts of vectors of any number of words.
pub(crate) fn shift(
    g: &mut Graph,
    op: ShiftOp,
    (a_width, b_width, width): (u32, u32, u32),
    a: &[Two],
    b: &[Two],
) -> Bits {
    let Amount { unknown, left, by, beyond } = amount(g, op, b_width, b);
    let (zero, top) = (g.constant(0), words(a_width) - 1);
    let outside = match op {
        ShiftOp::Left | ShiftOp::Right | ShiftOp::Both => g.two(Word::ZERO),
        ShiftOp::RightSigned => {
            let sign = g.bits4(a[top], (a_width - 1) % 64, 1);
            Two { v: g.splat(sign.v, u64::MAX), u: g.splat(sign.u, u64::MAX) }
        }
        ShiftOp::Part | ShiftOp::PartSigned => g.two(Word::x(u64::MAX)),
    };
    let n = words(width);
    let plane = |g: &mut Graph, of: fn(&Two) -> Id| {
        let fill = of(&outside);
        let mut from: Vec<Id> = a[..=top].iter().map(of).collect();
        let unused = g.constant(!word_mask(a_width, top));
        let unused = g.and(fill, unused);
        from[top] = g.or(from[top], unused);
        match op {
            ShiftOp::Left => moved(g, true, &from, by, beyond, fill, n),
            ShiftOp::Right | ShiftOp::RightSigned | ShiftOp::Part => moved(g, false, &from, by, beyond, fill, n),
            ShiftOp::Both | ShiftOp::PartSigned => {
                let (l, r) = (moved(g, true, &from, by, beyond, fill, n), moved(g, false, &from, by, beyond, fill, n));
                l.into_iter().zip(r).map(|(l, r)| g.select(left, l, r)).collect()
            }
        }
    };
    let (v, u) = (plane(g, |w| w.v), plane(g, |w| w.u));
    v.into_iter()
        .zip(u)
        .enumerate()
        .map(|(i, (v, u))| {
            let m = word_mask(width, i);
            let all = g.constant(m);
            let (v, u, x) = (g.and(v, all), g.and(u, all), g.splat(unknown, m));
            Two { v: g.select(unknown, zero, v), u: g.or(u, x) }
        })
        .collect()
}

/// A vector's value plane in `n` words, extended by its sign or by zeros.
fn extended(g: &mut Graph, a: &[Two], width: u32, signed: bool, n: usize) -> Vec<Id> {
    let top = words(width) - 1;
    let mut out: Vec<Id> = a[..=top].iter().map(|w| w.v).collect();
    let mut fill = g.constant(0);
    if signed {
        out[top] = g.extend(out[top], (width - 1) % 64 + 1);
        let sign = g.bits(out[top], 63, 1);
        fill = g.splat(sign, u64::MAX);
    }
    out.resize(n, fill);
    out
}

/// Adds to the words of a number, from the lowest on; what is carried beyond them is lost.
fn add(g: &mut Graph, to: &mut [Id], n: Id) {
    let mut carry = n;
    for word in to {
        *word = g.add(*word, carry);
        carry = g.less(*word, carry);
    }
}

/// The product of vectors of any number of words.
pub(crate) fn multiply(g: &mut Graph, (a_width, b_width): (u32, u32), signed: bool, ins: &[Bits]) -> Bits {
    let width = a_width + b_width;
    let n = words(width);
    let (x, y) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(x, y);
    let (a, b) = (extended(g, &ins[0], a_width, signed, n), extended(g, &ins[1], b_width, signed, n));
    let mut product = vec![g.constant(0); n];
    for (i, &a) in a.iter().enumerate() {
        for (k, &b) in b.iter().enumerate().take(n - i) {
            let (low, high) = (g.mul(a, b), g.mul_high(a, b, false));
            add(g, &mut product[i + k..], low);
            add(g, &mut product[i + k + 1..], high);
        }
    }
    finish(g, width, unknown, &product)
}

fn finish(g: &mut Graph, width: u32, unknown: Id, y: &[Id]) -> Bits {
    y.iter()
        .enumerate()
        .map(|(i, &y)| {
            let m = word_mask(width, i);
            let all = g.constant(m);
            let y = g.and(y, all);
            g.unless(unknown, y, m)
        })
        .collect()
}

/// `a - b` by words, and whether that is below zero.
fn subtract(g: &mut Graph, a: &[Id], b: &[Id]) -> (Vec<Id>, Id) {
    let mut borrow = g.constant(0);
    let difference = a
        .iter()
        .zip(b)
        .map(|(&a, &b)| {
            let (d, below) = (g.sub(a, b), g.less(a, b));
            let (y, again) = (g.sub(d, borrow), g.less(d, borrow));
            borrow = g.or(below, again);
            y
        })
        .collect();
    (difference, borrow)
}

fn select(g: &mut Graph, s: Id, a: &[Id], b: &[Id]) -> Vec<Id> {
    a.iter().zip(b).map(|(&a, &b)| g.select(s, a, b)).collect()
}

/// The negative of a number of `width` bits where `s` is 1.
fn negated_if(g: &mut Graph, s: Id, a: &[Id], width: u32) -> Vec<Id> {
    let none = vec![g.constant(0); a.len()];
    let (minus, _) = subtract(g, &none, a);
    let minus: Vec<Id> = minus
        .into_iter()
        .enumerate()
        .map(|(i, w)| {
            let m = g.constant(word_mask(width, i));
            g.and(w, m)
        })
        .collect();
    select(g, s, &minus, a)
}

/// Quotients and remainders of vectors of several words, a step a bit.
pub(crate) fn divide(g: &mut Graph, op: DivideOp, width: u32, signed: bool, ins: &[Bits]) -> Bits {
    let n = words(width);
    let zero = g.constant(0);
    let value = |of: &Bits| of[..n].iter().map(|w| w.v).collect::<Vec<Id>>();
    let (a, b) = (value(&ins[0]), value(&ins[1]));
    let some = b.iter().fold(zero, |all, &w| g.or(all, w));
    let by_zero = g.eq(some, zero);
    let (x, y) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(x, y);
    let unknown = g.or(unknown, by_zero);
    let sign = |g: &mut Graph, a: &[Id]| if signed { g.bits(a[n - 1], (width - 1) % 64, 1) } else { zero };
    let (a_negative, b_negative) = (sign(g, &a), sign(g, &b));
    let (a, b) = (negated_if(g, a_negative, &a, width), negated_if(g, b_negative, &b, width));
    let (mut q, mut r) = (vec![zero; n], vec![zero; n]);
    for bit in (0..width).rev() {
        let (at, shift) = (bit as usize / 64, bit % 64);
        let mut carry = g.bits(a[at], shift, 1);
        for w in &mut r {
            let (up, out) = (g.shl(*w, 1), g.bits(*w, 63, 1));
            *w = g.or(up, carry);
            carry = out;
        }
        let (difference, below) = subtract(g, &r, &b);
        // a remainder that is pushed out of its words is above any divisor
        let below = g.and_not(below, carry);
        let fits = g.not(below, 1);
        r = select(g, fits, &difference, &r);
        let one = g.shl(fits, shift);
        q[at] = g.or(q[at], one);
    }
    let differ = g.xor(a_negative, b_negative);
    let rest = r.iter().fold(zero, |all, &w| g.or(all, w));
    let inexact = g.any(rest);
    let down = g.and(differ, inexact);
    let result = match op {
        DivideOp::Quotient => negated_if(g, differ, &q, width),
        DivideOp::Floor => {
            let truncated = negated_if(g, differ, &q, width);
            let ones = g.constant(u64::MAX);
            let floored: Vec<Id> = q.iter().map(|&w| g.xor(w, ones)).collect();
            select(g, down, &floored, &truncated)
        }
        DivideOp::Remainder => negated_if(g, a_negative, &r, width),
        DivideOp::Modulo => {
            let same = negated_if(g, a_negative, &r, width);
            let (rest, _) = subtract(g, &b, &r);
            let rest = negated_if(g, b_negative, &rest, width);
            select(g, down, &rest, &same)
        }
    };
    finish(g, width, unknown, &result)
}

/// Powers of one word to one word, by squares.
pub(crate) fn power(
    g: &mut Graph,
    (width, b_width): (u32, u32),
    (a_signed, b_signed): (bool, bool),
    a: Two,
    b: Two,
) -> Two {
    let (zero, one, all) = (g.constant(0), g.constant(1), g.constant(mask(width)));
    let (mut result, mut square) = (one, a.v);
    for i in 0..b_width {
        let bit = g.bits(b.v, i, 1);
        let product = g.mul(result, square);
        result = g.select(bit, product, result);
        square = g.mul(square, square);
    }
    let unknown = g.or(a.u, b.u);
    let mut unknown = g.any(unknown);
    if b_signed {
        // to a negative power: 0 is unknown, 1 is 1, -1 is what an odd or even number of it is, and all else is 0
        let negative = g.bits(b.v, b_width - 1, 1);
        let (is_zero, is_one, is_minus_one) = (g.eq(a.v, zero), g.eq(a.v, one), g.eq(a.v, all));
        let is_minus_one = if a_signed { is_minus_one } else { zero };
        let odd = g.bits(b.v, 0, 1);
        let of_minus_one = g.select(odd, all, one);
        let of_others = g.select(is_one, one, zero);
        let inverse = g.select(is_minus_one, of_minus_one, of_others);
        result = g.select(negative, inverse, result);
        let none = g.and(negative, is_zero);
        unknown = g.or(unknown, none);
    }
    let result = g.and(result, all);
    g.unless(unknown, result, mask(width))
}
