//! Gates of any width and fan-in, and the AND-OR multiplexer made of them. Bitwise, four-valued.

use super::CellKind;
use super::algebra::{Algebra, Site, input, part};
use super::element::{Arguments, Element, Kind, Parameter, Port};
use super::pin::several::IN;
use super::pin::{and_or, ternary};
use crate::value::Word;

/// What a gate does to each bit of its inputs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum GateOp {
    /// All are 1.
    And,
    /// Any is 1.
    Or,
    /// An odd number are 1.
    Xor,
    /// Not all are 1.
    Nand,
    /// None is 1.
    Nor,
    /// An even number are 1.
    Xnor,
    /// The input (z becomes x).
    Buf,
    /// The input inverted.
    Not,
}

impl GateOp {
    /// Whether the result is inverted at the end.
    #[inline(always)]
    #[must_use]
    pub const fn inverts(self) -> bool {
        matches!(self, GateOp::Nand | GateOp::Nor | GateOp::Xnor | GateOp::Not)
    }

    /// What joining starts from: 1 for AND, 0 for the others.
    #[must_use]
    pub const fn identity(self, mask: u64) -> Word {
        match self {
            GateOp::And | GateOp::Nand => Word::known(mask),
            _ => Word::ZERO,
        }
    }
}

/// Two inputs joined, before any inversion.
#[inline(always)]
pub fn join<A: Algebra>(l: &mut A, op: GateOp, a: A::Word, b: A::Word) -> A::Word {
    match op {
        GateOp::And | GateOp::Nand => l.and4(a, b),
        GateOp::Xor | GateOp::Xnor => l.xor4(a, b),
        GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => l.or4(a, b),
    }
}

/// The output of the joined inputs: inverted where the gate inverts, never z.
#[inline(always)]
pub fn finish<A: Algebra>(l: &mut A, op: GateOp, joined: A::Word, mask: u64) -> A::Word {
    if op.inverts() { l.not4(joined, mask) } else { l.read4(joined) }
}

/// All bits of `w`, which has those of `mask`, joined into one.
#[inline(always)]
pub fn reduce<A: Algebra>(l: &mut A, op: GateOp, w: A::Word, mask: u64) -> A::Word {
    if mask == 1 {
        return l.read4(w);
    }
    let (ones, (v, u)) = (l.ones(w), A::planes(w));
    let unknown = l.any(u);
    match op {
        GateOp::And | GateOp::Nand => {
            let some = l.or(v, u);
            let (all, no_zero) = (l.all(ones, mask), l.all(some, mask));
            A::word(all, l.and(no_zero, unknown))
        }
        GateOp::Xor | GateOp::Xnor => {
            let odd = l.parity(ones);
            A::word(l.and_not(odd, unknown), unknown)
        }
        GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => {
            let any = l.any(ones);
            A::word(any, l.and_not(unknown, any))
        }
    }
}

/// One word of the output of a gate with these inputs, of which there is at least one.
#[inline(always)]
pub fn gate_word<A: Algebra>(
    l: &mut A,
    op: GateOp,
    inputs: usize,
    mask: u64,
    input: impl Fn(&mut A, usize) -> A::Word,
) -> A::Word {
    let mut joined = input(l, 0);
    for k in 1..inputs {
        let one = input(l, k);
        joined = join(l, op, joined, one);
    }
    finish(l, op, joined, mask)
}

/// `inputs` vectors of `width` bits, one after another, through a gate.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn gate<A: Algebra>(l: &mut A, s: &mut impl Site<A>, op: GateOp, width: u32, inputs: u32) {
    if width == 1 {
        let y = gate_word(l, op, A::words(inputs), 1, |l, i| reduce(l, op, s.get(IN, i), A::mask(inputs, i)));
        return s.put(0, 0, y);
    }
    for i in 0..A::words(width) {
        let y = gate_word(l, op, inputs as usize, A::mask(width, i), |l, k| input(l, s, IN, width, k as u32, i));
        s.put(0, i, y);
    }
}

/// What an AND-OR multiplexer has of its inputs so far, and one more with its select in all bits.
#[inline(always)]
pub fn and_or_step<A: Algebra>(l: &mut A, before: A::Word, input: A::Word, select: A::Word) -> A::Word {
    let one = l.and4(input, select);
    l.or4(before, one)
}

/// The AND-OR multiplexer: `y = (in[0] & sel[0]) | (in[1] & sel[1]) | …`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn and_or<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, inputs: u32) {
    for i in 0..A::words(width) {
        let mut y = l.literal(Word::ZERO);
        for k in 0..inputs {
            let (v, u) = A::planes(part(l, s, and_or::SEL, k, 1));
            let m = A::mask(width, i);
            let select = A::word(l.splat(v, m), l.splat(u, m));
            let one = input(l, s, and_or::IN, width, k, i);
            y = and_or_step(l, y, one, select);
        }
        s.put(0, i, y);
    }
}

/// Whether no bit of what has been joined by OR is 1; x where that depends on an unknown one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn is_zero<A: Algebra>(l: &mut A, width: u32, word: impl Fn(&mut A, usize) -> A::Word) -> A::Word {
    gate_word(l, GateOp::Nor, A::words(width), 1, |l, i| {
        let w = word(l, i);
        reduce(l, GateOp::Or, w, A::mask(width, i))
    })
}

/// Bit by bit what two of three are.
#[inline(always)]
pub fn majority_word<A: Algebra>(l: &mut A, a: A::Word, b: A::Word, c: A::Word) -> A::Word {
    let (both, some) = (l.and4(a, b), l.or4(a, b));
    let with = l.and4(some, c);
    l.or4(both, with)
}

/// Bit by bit 1 where two or three of the inputs are.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn majority<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    for i in 0..A::words(width) {
        let (a, b, c) = (s.get(ternary::A, i), s.get(ternary::B, i), s.get(ternary::C, i));
        let y = majority_word(l, a, b, c);
        s.put(0, i, y);
    }
}

const WIDTH: Parameter =
    Parameter { name: "width", kind: Kind::WIDTH, default: Some("1"), doc: "bits of each input and of `y`" };
const UNARY: &[Port] = &[Port::input("a", "the input"), Y];
const SEVERAL: Port = Port::several("in", "the inputs, two or more");
const Y: Port = Port::output("y", "the result");

const fn several(
    name: &'static str,
    summary: &'static str,
    build: fn(&Arguments) -> Result<CellKind, String>,
    meaning: &'static str,
) -> Element {
    Element {
        name,
        summary,
        ports: &[SEVERAL, Y],
        parameters: &[WIDTH],
        meaning,
        source: "IEEE 1364-2005, 7.2; documents A, B, C: И, ИЛИ",
        example: r#"{ "type": "NAME", "parameters": { "width": 4 }, "connections": { "in": ["a", "b", "c"], "y": "y" } }"#,
        build,
    }
}

const fn single(
    name: &'static str,
    summary: &'static str,
    build: fn(&Arguments) -> Result<CellKind, String>,
    meaning: &'static str,
) -> Element {
    Element {
        name,
        summary,
        ports: UNARY,
        parameters: &[WIDTH],
        meaning,
        source: "IEEE 1364-2005, 7.3; documents A, B, C: НЕ",
        example: r#"{ "type": "NAME", "connections": { "a": "sign", "y": "not_sign" } }"#,
        build,
    }
}

fn build(op: GateOp, a: &Arguments) -> Result<CellKind, String> {
    let (width, inputs) = (a.width("width"), a.inputs);
    if inputs < 2 {
        return Err("a gate needs at least two inputs; for one use `buf` or `not`".into());
    }
    Ok(CellKind::Gate { op, width, inputs })
}

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    several(
        "and",
        "AND gate",
        |a| build(GateOp::And, a),
        "| AND | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 0 | 0 | 0 | 0 |\n| **1** | 0 | 1 | x | x |\n| **x** | 0 | x | x | x |\n| **z** | 0 | x | x | x |",
    ),
    several(
        "or",
        "OR gate",
        |a| build(GateOp::Or, a),
        "| OR | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 0 | 1 | x | x |\n| **1** | 1 | 1 | 1 | 1 |\n| **x** | x | 1 | x | x |\n| **z** | x | 1 | x | x |",
    ),
    several(
        "nand",
        "NAND gate",
        |a| build(GateOp::Nand, a),
        "| NAND | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 1 | 1 | 1 | 1 |\n| **1** | 1 | 0 | x | x |\n| **x** | 1 | x | x | x |\n| **z** | 1 | x | x | x |",
    ),
    several(
        "nor",
        "NOR gate",
        |a| build(GateOp::Nor, a),
        "| NOR | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 1 | 0 | x | x |\n| **1** | 0 | 0 | 0 | 0 |\n| **x** | x | 0 | x | x |\n| **z** | x | 0 | x | x |",
    ),
    several(
        "xor",
        "exclusive OR gate",
        |a| build(GateOp::Xor, a),
        "| XOR | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 0 | 1 | x | x |\n| **1** | 1 | 0 | x | x |\n| **x** | x | x | x | x |\n| **z** | x | x | x | x |",
    ),
    several(
        "xnor",
        "exclusive NOR gate",
        |a| build(GateOp::Xnor, a),
        "| XNOR | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **0** | 1 | 0 | x | x |\n| **1** | 0 | 1 | x | x |\n| **x** | x | x | x | x |\n| **z** | x | x | x | x |",
    ),
    single(
        "buf",
        "buffer",
        |a| Ok(CellKind::Gate { op: GateOp::Buf, width: a.width("width"), inputs: 1 }),
        "| a | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **y** | 0 | 1 | x | x |",
    ),
    single(
        "not",
        "inverter",
        |a| Ok(CellKind::Gate { op: GateOp::Not, width: a.width("width"), inputs: 1 }),
        "| a | 0 | 1 | x | z |\n|---|---|---|---|---|\n| **y** | 1 | 0 | x | x |",
    ),
    Element {
        name: "and_or",
        summary: "AND-OR bus multiplexer with one select line for each input",
        ports: &[SEVERAL, Port::input("sel", "select lines; bit k belongs to input k"), Y],
        parameters: &[WIDTH],
        meaning: "`y = (in[0] & sel[0]) | (in[1] & sel[1]) | …`, bit by bit, by the tables of AND and OR. No line active gives 0.",
        source: "document B, магистрален мултиплексор (И1, И2, ИЛИ)",
        example: r#"{ "type": "and_or", "parameters": { "width": "W" }, "connections": { "in": ["a", "b"], "sel": ["take_b", "take_a"], "y": "y" } }"#,
        build: |a| Ok(CellKind::AndOr { width: a.width("width"), inputs: a.inputs }),
    },
    Element {
        name: "majority",
        summary: "majority gate of three inputs",
        ports: &[Port::input("a", "first input"), Port::input("b", "second input"), Port::input("c", "third input"), Y],
        parameters: &[WIDTH],
        meaning: "`y = (a & b) | ((a | b) & c)`, bit by bit, by the tables of AND and OR: what two of three are is known whatever the third is.\n\n| a b c | 000 | 001 | 010 | 011 | 100 | 101 | 110 | 111 | 00x | 01x | 11x | 0xx | 1xx | xxx |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n| **y** | 0 | 0 | 0 | 1 | 0 | 1 | 1 | 1 | 0 | x | 1 | x | x | x |",
        source: "the carry of a full adder; the voter of triple modular redundancy",
        example: r#"{ "type": "majority", "parameters": { "width": "W" }, "connections": { "a": "x1", "b": "x2", "c": "x3", "y": "x" } }"#,
        build: |a| Ok(CellKind::Majority { width: a.width("width") }),
    },
    Element {
        name: "is_zero",
        summary: "zero detector",
        ports: &[Port::input("a", "the number"), Y],
        parameters: &[Parameter { name: "width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `a`" }],
        meaning: "`y = 1` where every bit of `a` is 0, `0` where any bit is 1, otherwise `x`: the NOR of its bits.",
        source: "documents A, B, C: counters КОХ, КОУ",
        example: r#"{ "type": "is_zero", "parameters": { "width": "W" }, "connections": { "a": "kox", "y": "kox_zero" } }"#,
        build: |a| Ok(CellKind::IsZero { width: a.width("width") }),
    },
];
