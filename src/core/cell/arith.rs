//! Adders, subtractors and multipliers. Any x or z among the operands makes every result bit x, except in the half
//! and full adder, which are the gates that they are drawn as.

use super::CellKind;
use super::element::{Element, Kind, Parameter, Port};
use crate::value::Word;
use crate::value::word::{any_unknown, mask, word_mask, words};

/// Which way an adder counts.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum AddOp {
    /// `a + b + ci`.
    Add,
    /// `a - b - bi`.
    Sub,
    /// One of the two, chosen by pin `sub`.
    AddSub,
}

/// `a + b + ci`, or `a - b - ci` where `sub` is 1, into `y`; returns the carry, or the borrow.
#[inline(always)]
pub fn add(width: u32, a: &[Word], b: &[Word], ci: Word, sub: Word, y: &mut [Word]) -> Word {
    if any_unknown(a) || any_unknown(b) || (ci.u | sub.u) & 1 != 0 {
        for (i, y) in y.iter_mut().enumerate() {
            *y = Word::x(word_mask(width, i));
        }
        return Word::x(1);
    }
    let invert = (sub.v & 1).wrapping_neg();
    let mut carry = (ci.v ^ sub.v) & 1 != 0;
    for (i, y) in y.iter_mut().enumerate() {
        let m = word_mask(width, i);
        let (sum, c1) = a[i].v.overflowing_add((b[i].v ^ invert) & m);
        let (sum, c2) = sum.overflowing_add(u64::from(carry));
        carry = c1 | c2 | (sum & !m != 0);
        *y = Word::known(sum & m);
    }
    Word::known(u64::from(carry) ^ (sub.v & 1))
}

/// The half adder of an XOR and an AND: (sum, carry), bit 0 only.
#[inline(always)]
#[must_use]
pub fn half_adder(a: Word, b: Word) -> (Word, Word) {
    (bit(a.xor(b)), bit(a.and(b)))
}

/// The full adder of two half adders and an OR: (sum, carry), bit 0 only.
#[inline(always)]
#[must_use]
pub fn full_adder(a: Word, b: Word, ci: Word) -> (Word, Word) {
    let half = a.xor(b);
    (bit(half.xor(ci)), bit(a.and(b).or(half.and(ci))))
}

#[inline(always)]
const fn bit(w: Word) -> Word {
    Word { v: w.v & 1, u: w.u & 1 }
}

/// The product, `a_width + b_width` bits, by schoolbook multiplication of 64-bit digits.
pub fn multiply(a_width: u32, b_width: u32, signed: bool, a: &[Word], b: &[Word], y: &mut [Word]) {
    let width = a_width + b_width;
    let n = words(width);
    if any_unknown(a) || any_unknown(b) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = Word::x(word_mask(width, i));
        }
        return;
    }
    let digit = |from: &[Word], from_width: u32, i: usize| {
        let negative = signed && from[words(from_width) - 1].v >> ((from_width - 1) % 64) & 1 == 1;
        let high = if negative { u64::MAX } else { 0 };
        match from.get(i) {
            Some(w) if i < words(from_width) => w.v | (high & !word_mask(from_width, i)),
            _ => high,
        }
    };
    y[..n].fill(Word::ZERO);
    for i in 0..n {
        let mut carry = 0u128;
        for j in 0..n - i {
            let product = u128::from(digit(a, a_width, i)) * u128::from(digit(b, b_width, j));
            let sum = product + u128::from(y[i + j].v) + carry;
            y[i + j].v = sum as u64;
            carry = sum >> 64;
        }
    }
    y[n - 1].v &= mask(width - (n as u32 - 1) * 64);
}

const A: Port = Port::input("a", "first operand");
const B: Port = Port::input("b", "second operand");
const CI: Port = Port::optional("ci", "carry in");
const WIDTH: Parameter =
    Parameter { name: "width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `a`, `b` and `y`" };

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    Element {
        name: "half_adder",
        summary: "half adder",
        ports: &[A, B, Port::output("s", "sum"), Port::output("co", "carry")],
        parameters: &[],
        meaning: "`s = a ^ b`, `co = a & b`, by the tables of XOR and AND.\n\n| a b | 00 | 01 | 10 | 11 |\n|---|---|---|---|---|\n| **co s** | 00 | 01 | 01 | 10 |",
        source: "documents A, B: суматор",
        example: r#"{ "type": "half_adder", "connections": { "a": "a", "b": "b", "s": "s", "co": "c" } }"#,
        build: |_| Ok(CellKind::HalfAdder),
    },
    Element {
        name: "full_adder",
        summary: "full adder",
        ports: &[A, B, Port::input("ci", "carry in"), Port::output("s", "sum"), Port::output("co", "carry")],
        parameters: &[],
        meaning: "`s = a ^ b ^ ci`, `co = (a & b) | ((a ^ b) & ci)`, by the tables of the gates: an x need not reach both outputs.\n\n| a b ci | 000 | 001 | 010 | 011 | 100 | 101 | 110 | 111 |\n|---|---|---|---|---|---|---|---|---|\n| **co s** | 00 | 01 | 01 | 10 | 01 | 10 | 10 | 11 |",
        source: "documents A, B: суматор; Yosys `$fa`",
        example: r#"{ "type": "full_adder", "repeat": { "i": "W" }, "connections": { "a": "a[i]", "b": "b[i]", "ci": "c[i]", "s": "s[i]", "co": "c[i+1]" } }"#,
        build: |_| Ok(CellKind::FullAdder),
    },
    Element {
        name: "adder",
        summary: "adder with carry in and out",
        ports: &[A, B, CI, Port::output("y", "sum"), Port::output("co", "carry out")],
        parameters: &[WIDTH],
        meaning: "`{co, y} = a + b + ci`, modulo 2^width; any x or z among the inputs gives all x.",
        source: "documents A, B, C: суматор; IEEE 1364-2005, 5.1.5",
        example: r#"{ "type": "adder", "parameters": { "width": "W" }, "connections": { "a": "f", "b": "increment", "y": "sum" } }"#,
        build: |a| Ok(CellKind::Adder { op: AddOp::Add, width: a.width("width") }),
    },
    Element {
        name: "subtractor",
        summary: "subtractor with borrow in and out",
        ports: &[
            A,
            B,
            Port::optional("bi", "borrow in"),
            Port::output("y", "difference"),
            Port::output("bo", "borrow out"),
        ],
        parameters: &[WIDTH],
        meaning: "`y = a - b - bi` modulo 2^width, `bo = 1` where `a < b + bi`; any x or z among the inputs gives all x.",
        source: "document A: изваждане; IEEE 1364-2005, 5.1.5",
        example: r#"{ "type": "subtractor", "parameters": { "width": "W" }, "connections": { "a": 0, "b": "dy", "y": "minus_dy" } }"#,
        build: |a| Ok(CellKind::Adder { op: AddOp::Sub, width: a.width("width") }),
    },
    Element {
        name: "add_sub",
        summary: "adder and subtractor, chosen by an input",
        ports: &[
            A,
            B,
            CI,
            Port::input("sub", "0 adds, 1 subtracts"),
            Port::output("y", "result"),
            Port::output("co", "carry or borrow out"),
        ],
        parameters: &[WIDTH],
        meaning: "`sub = 0`: as `adder`; `sub = 1`: as `subtractor`, with `ci` the borrow in and `co` the borrow out; modulo 2^width; any x or z among the inputs gives all x.",
        source: "documents A, B: реверсивен брояч; IEEE 1364-2005, 5.1.5",
        example: r#"{ "type": "add_sub", "parameters": { "width": "W" }, "connections": { "a": "x", "b": "step", "sub": "back", "y": "next" } }"#,
        build: |a| Ok(CellKind::Adder { op: AddOp::AddSub, width: a.width("width") }),
    },
    Element {
        name: "multiplier",
        summary: "multiplier",
        ports: &[A, B, Port::output("y", "product, `a_width + b_width` bits")],
        parameters: &[
            Parameter { name: "a_width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `a`" },
            Parameter { name: "b_width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `b`" },
            Parameter {
                name: "signed",
                kind: Kind::FLAG,
                default: Some("0"),
                doc: "1: operands and product in two's complement",
            },
        ],
        meaning: "`y = a * b`, exact; any x or z among the inputs gives all x.",
        source: "document A: мащабен преобразувател; IEEE 1364-2005, 5.1.5",
        example: r#"{ "type": "multiplier", "parameters": { "a_width": 4, "b_width": 8 }, "connections": { "a": "k", "b": "x", "y": "kx" } }"#,
        build: |a| {
            Ok(CellKind::Multiply {
                a_width: a.width("a_width"),
                b_width: a.width("b_width"),
                signed: a.flag("signed"),
            })
        },
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn number(n: u128) -> [Word; 2] {
        [Word::known(n as u64), Word::known((n >> 64) as u64)]
    }

    proptest! {
        /// Against the host's 128-bit integers.
        #[test]
        fn adds_and_subtracts_at_any_width(width in 1u32..=128, a: u128, b: u128, ci: bool, sub: bool) {
            let m = if width == 128 { u128::MAX } else { (1 << width) - 1 };
            let (a, b) = (a & m, b & m);
            let n = words(width);
            let mut y = [Word::ZERO; 2];
            let c = add(width, &number(a)[..n], &number(b)[..n], Word::known(ci.into()), Word::known(sub.into()), &mut y[..n]);
            let y = u128::from(y[0].v) | u128::from(y[1].v) << 64;
            let ci = u128::from(ci);
            if sub {
                prop_assert_eq!(y, a.wrapping_sub(b).wrapping_sub(ci) & m);
                prop_assert_eq!(c.v == 1, a < b || a - b < ci);
            } else {
                prop_assert_eq!(y, a.wrapping_add(b).wrapping_add(ci) & m);
                prop_assert_eq!(c.v == 1, m - a < b || m - a - b < ci);
            }
        }

        #[test]
        fn multiplies_at_any_width(wa in 1u32..=64, wb in 1u32..=64, a: u64, b: u64, signed: bool) {
            let (a, b) = (a & mask(wa), b & mask(wb));
            let mut y = [Word::ZERO; 2];
            multiply(wa, wb, signed, &[Word::known(a)], &[Word::known(b)], &mut y[..words(wa + wb)]);
            let y = u128::from(y[0].v) | u128::from(y[1].v) << 64;
            let extend = |n: u64, w: u32| if signed { i128::from((n << (64 - w)) as i64 >> (64 - w)) } else { i128::from(n) };
            let m = if wa + wb == 128 { u128::MAX } else { (1u128 << (wa + wb)) - 1 };
            prop_assert_eq!(y, extend(a, wa).wrapping_mul(extend(b, wb)) as u128 & m);
        }
    }
}
