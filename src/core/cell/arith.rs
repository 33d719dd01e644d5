//! Adders, subtractors and multipliers. Any x or z among the operands makes every result bit x, except in the half
//! and full adder, which are the gates that they are drawn as.

use smallvec::SmallVec;

use super::CellKind;
use super::algebra::{Algebra, Site, unknown, value_bit};
use super::element::{Element, Kind, Parameter, Port};
use super::pin::{add, add_sub, binary};
use crate::value::Word;
use crate::value::word::mask;

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

/// `a + b + ci`, or `a - b - ci` where `sub` is 1, word by word from the lowest.
pub struct Sum<A: Algebra> {
    unknown: A::Plane,
    carry: A::Plane,
    sub: A::Plane,
}

impl<A: Algebra> Sum<A> {
    /// One of operands that are as `unknown` says, a plane that is not 0 where any of them is x or z.
    #[inline(always)]
    pub fn new(l: &mut A, unknown: A::Plane, ci: A::Word, sub: A::Word) -> Sum<A> {
        let ((ci, ci_u), (sub, sub_u)) = (A::planes(ci), A::planes(sub));
        let controls = l.or(ci_u, sub_u);
        let unknown = l.or(unknown, controls);
        let unknown = l.any(unknown);
        let carry = if l.known(sub).is_some() { ci } else { l.xor(ci, sub) };
        Sum { unknown, carry, sub }
    }

    /// The next word of the result, of `mask` bits.
    #[inline(always)]
    pub fn step(&mut self, l: &mut A, a: A::Word, b: A::Word, mask: u64) -> A::Word {
        let (a, b, bits) = (A::planes(a).0, A::planes(b).0, mask.count_ones());
        let (y, carry) = match l.known(self.sub) {
            Some(0) => l.add(a, b, self.carry, bits),
            Some(_) => l.sub(a, b, self.carry, bits),
            None => {
                let invert = l.splat(self.sub, mask);
                let b = l.xor(b, invert);
                l.add(a, b, self.carry, bits)
            }
        };
        self.carry = carry;
        l.unless(self.unknown, y, mask)
    }

    /// The carry or the borrow.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn carry(self, l: &mut A) -> A::Word {
        let carry = if l.known(self.sub).is_some() { self.carry } else { l.xor(self.carry, self.sub) };
        l.unless(self.unknown, carry, 1)
    }
}

/// Adder, subtractor, or both.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn adder<A: Algebra>(l: &mut A, s: &mut impl Site<A>, op: AddOp, width: u32) {
    let sub = match op {
        AddOp::Add => l.literal(Word::ZERO),
        AddOp::Sub => l.literal(Word::known(1)),
        AddOp::AddSub => s.get(add_sub::SUB, 0),
    };
    let mut unknown = l.constant(0);
    for i in 0..A::words(width) {
        let (a, b) = (A::planes(s.get(add::A, i)).1, A::planes(s.get(add::B, i)).1);
        unknown = l.or(unknown, a);
        unknown = l.or(unknown, b);
    }
    let mut sum = Sum::new(l, unknown, s.get(add::CI, 0), sub);
    for i in 0..A::words(width) {
        let y = sum.step(l, s.get(add::A, i), s.get(add::B, i), A::mask(width, i));
        s.put(0, i, y);
    }
    let carry = sum.carry(l);
    s.put(1, 0, carry);
}

/// The half adder of an XOR and an AND.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn half_adder<A: Algebra>(l: &mut A, s: &mut impl Site<A>) {
    let (a, b) = (s.get(binary::A, 0), s.get(binary::B, 0));
    let (sum, carry) = (l.xor4(a, b), l.and4(a, b));
    s.put(0, 0, sum);
    s.put(1, 0, carry);
}

/// The full adder of two half adders and an OR.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn full_adder<A: Algebra>(l: &mut A, s: &mut impl Site<A>) {
    let (a, b, ci) = (s.get(add::A, 0), s.get(add::B, 0), s.get(add::CI, 0));
    let (half, both) = (l.xor4(a, b), l.and4(a, b));
    let (sum, passed) = (l.xor4(half, ci), l.and4(half, ci));
    s.put(0, 0, sum);
    let carry = l.or4(both, passed);
    s.put(1, 0, carry);
}

/// The value plane of a pin in `n` words, extended by its sign or by zeros.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn extended<A: Algebra>(
    l: &mut A,
    s: &impl Site<A>,
    pin: usize,
    width: u32,
    signed: bool,
    n: usize,
) -> SmallVec<[A::Plane; 2]> {
    let own = A::words(width);
    let mut all: SmallVec<[A::Plane; 2]> = (0..own.min(n)).map(|i| A::planes(s.get(pin, i)).0).collect();
    let sign = if signed { value_bit(l, s, pin, width - 1) } else { l.constant(0) };
    if own <= n {
        let above = mask(A::BITS) & !A::mask(width, own - 1);
        let high = l.splat(sign, above);
        all[own - 1] = l.or(all[own - 1], high);
    }
    let fill = l.splat(sign, mask(A::BITS));
    all.resize(n, fill);
    all
}

/// Gives numbers, or x where `unknown` is 1.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn put_number<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    width: u32,
    unknown: A::Plane,
    number: &[A::Plane],
) {
    for (i, &y) in number.iter().enumerate() {
        let m = A::mask(width, i);
        let y = l.bits(y, 0, m.count_ones());
        let y = l.unless(unknown, y, m);
        s.put(0, i, y);
    }
}

/// The product, `a_width + b_width` bits.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn multiply<A: Algebra>(l: &mut A, s: &mut impl Site<A>, (a_width, b_width): (u32, u32), signed: bool) {
    let width = a_width + b_width;
    let n = A::words(width);
    let (a, b) = (unknown(l, s, binary::A, a_width), unknown(l, s, binary::B, b_width));
    let unknown = l.or(a, b);
    let (a, b) = (extended(l, s, binary::A, a_width, signed, n), extended(l, s, binary::B, b_width, signed, n));
    if signed
        && n == 2
        && a_width.max(b_width) <= A::BITS
        && let Some((low, high)) = l.mul_signed(a[0], b[0])
    {
        return put_number(l, s, width, unknown, &[low, high]);
    }
    let zero = l.constant(0);
    let mut product: SmallVec<[A::Plane; 2]> = SmallVec::from_elem(zero, n);
    for i in 0..n {
        // without a sign there is nothing but zeros above the operands
        if !signed && i >= A::words(a_width) {
            break;
        }
        let mut carry = zero;
        for k in 0..n - i {
            (product[i + k], carry) = l.mul_add(a[i], b[k], product[i + k], carry);
        }
    }
    put_number(l, s, width, unknown, &product);
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
    use crate::cell::evaluate;
    use crate::value::word::words;
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
            let mut c = [Word::ZERO];
            let ins = [number(a), number(b)];
            let ins = [&ins[0][..n], &ins[1][..n], &[Word::known(ci.into())], &[Word::known(sub.into())]];
            evaluate(&CellKind::Adder { op: AddOp::AddSub, width }, &ins, &mut [&mut y[..n], &mut c]);
            let c = c[0];
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
            let kind = CellKind::Multiply { a_width: wa, b_width: wb, signed };
            evaluate(&kind, &[&[Word::known(a)], &[Word::known(b)]], &mut [&mut y[..words(wa + wb)]]);
            let y = u128::from(y[0].v) | u128::from(y[1].v) << 64;
            let extend = |n: u64, w: u32| if signed { i128::from((n << (64 - w)) as i64 >> (64 - w)) } else { i128::from(n) };
            let m = if wa + wb == 128 { u128::MAX } else { (1u128 << (wa + wb)) - 1 };
            prop_assert_eq!(y, extend(a, wa).wrapping_mul(extend(b, wb)) as u128 & m);
        }
    }
}
