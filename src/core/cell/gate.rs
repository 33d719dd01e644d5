//! Gates of any width and fan-in, and the AND-OR multiplexer made of them. Bitwise, four-valued.

use super::element::{Arguments, Element, Kind, Parameter, Port};
use super::{CellKind, word_of};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

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

    /// Two inputs joined, before any inversion.
    #[inline(always)]
    #[must_use]
    pub const fn join(self, a: Word, b: Word) -> Word {
        match self {
            GateOp::And | GateOp::Nand => a.and(b),
            GateOp::Xor | GateOp::Xnor => a.xor(b),
            GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => a.or(b),
        }
    }

    /// What joining starts from: 1 for AND, 0 for the others.
    #[inline(always)]
    #[must_use]
    pub const fn identity(self, mask: u64) -> Word {
        match self {
            GateOp::And | GateOp::Nand => Word::known(mask),
            _ => Word::ZERO,
        }
    }

    /// The output: the joined inputs, inverted where the gate inverts, limited to `mask`.
    #[inline(always)]
    #[must_use]
    pub const fn finish(self, joined: Word, mask: u64) -> Word {
        if self.inverts() {
            joined.not(mask)
        } else {
            let w = joined.read();
            Word { v: w.v & mask, u: w.u & mask }
        }
    }

    /// All bits of `w` within `mask` joined into one.
    #[inline(always)]
    #[must_use]
    pub const fn reduce(self, w: Word, mask: u64) -> Word {
        let (ones, unknown) = (w.ones() & mask, w.u & mask);
        let zeros = mask & !(ones | unknown);
        match self {
            GateOp::And | GateOp::Nand => {
                Word { v: (zeros | unknown == 0) as u64, u: (zeros == 0 && unknown != 0) as u64 }
            }
            GateOp::Xor | GateOp::Xnor => {
                let u = (unknown != 0) as u64;
                Word { v: (ones.count_ones() as u64 & 1) & !u, u }
            }
            _ => Word { v: (ones != 0) as u64, u: (ones == 0 && unknown != 0) as u64 },
        }
    }
}

/// `inputs` vectors of `width` bits, one after another in `ins`, through a gate into `y`.
pub fn gate(op: GateOp, width: u32, inputs: u32, ins: &[Word], y: &mut [Word]) {
    if width == 1 {
        let joined =
            (0..words(inputs)).fold(op.identity(1), |acc, i| op.join(acc, op.reduce(ins[i], word_mask(inputs, i))));
        y[0] = op.finish(joined, 1);
        return;
    }
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        let m = word_mask(width, i);
        let joined = (0..inputs).fold(op.identity(m), |acc, k| op.join(acc, word_of(ins, k * width, width, i)));
        *y = op.finish(joined, m);
    }
}

/// The AND-OR multiplexer: `y = (in[0] & sel[0]) | (in[1] & sel[1]) | …`.
pub fn and_or(width: u32, inputs: u32, ins: &[Word], sel: &[Word], y: &mut [Word]) {
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        let m = word_mask(width, i);
        *y = (0..inputs).fold(Word::ZERO, |acc, k| {
            let gate = word_of(sel, k, 1, 0).splat(m);
            acc.or(word_of(ins, k * width, width, i).and(gate))
        });
    }
}

/// 1 where no bit is 1, x where that depends on an unknown bit.
#[must_use]
pub fn is_zero(width: u32, a: &[Word]) -> Word {
    let any = (0..words(width)).fold(Word::ZERO, |acc, i| acc.or(GateOp::Or.reduce(a[i], word_mask(width, i))));
    any.not(mask(1))
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
