//! Multiplexers, comparators and tri-state drivers.

use super::element::{Element, Kind, Parameter, Port};
use super::{CellKind, word_of};
use crate::value::Word;
use crate::value::word::{any_unknown, word_mask, words};

/// Which comparison a comparator makes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum CompareOp {
    /// `a == b`.
    Eq,
    /// `a != b`.
    Ne,
    /// `a < b`.
    Lt,
    /// `a <= b`.
    Le,
    /// `a > b`.
    Gt,
    /// `a >= b`.
    Ge,
    /// `a === b`: every bit is the same of 0, 1, x and z; never x.
    Same,
    /// `a !== b`.
    Differs,
}

/// The bits of the select of a multiplexer of `inputs` inputs.
#[must_use]
pub const fn select_width(inputs: u32) -> u32 {
    if inputs <= 2 { 1 } else { 32 - (inputs - 1).leading_zeros() }
}

/// Input number `s` of `inputs` into `y`. An x in `s` gives the bits on which all inputs that it could mean agree;
/// a number beyond the inputs gives x.
pub fn mux(width: u32, inputs: u32, ins: &[Word], s: Word, y: &mut [Word]) {
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        *y = mux_word(inputs, word_mask(width, i), s, |k| word_of(ins, k * width, width, i));
    }
}

/// The same for one machine word of each input, of which the bits of `mask` are in use.
#[inline(always)]
pub fn mux_word(inputs: u32, mask: u64, s: Word, input: impl Fn(u32) -> Word) -> Word {
    let input = |k: u64| if k < u64::from(inputs) { input(k as u32) } else { Word::x(mask) };
    if s.u == 0 {
        return input(s.v);
    }
    let meant = (0..1u64 << select_width(inputs)).filter(|k| (k ^ s.ones()) & !s.u == 0);
    let all = meant.fold(None, |all: Option<Word>, k| Some(input(k).merge(all.unwrap_or(input(k)))));
    all.unwrap_or(Word::x(mask))
}

/// A comparison. Sameness is always decided. Equality is decided as soon as one bit is certainly different; an order needs every bit.
#[must_use]
#[inline(always)]
pub fn compare(op: CompareOp, width: u32, signed: bool, a: &[Word], b: &[Word]) -> Word {
    let n = a.len();
    if matches!(op, CompareOp::Same | CompareOp::Differs) {
        let same = (0..n).all(|i| a[i] == b[i]);
        return Word::known(u64::from(same == (op == CompareOp::Same)));
    }
    let equality = matches!(op, CompareOp::Eq | CompareOp::Ne);
    let holds = if equality {
        let differs = (0..n).any(|i| (a[i].v ^ b[i].v) & !(a[i].u | b[i].u) != 0);
        if !differs && (any_unknown(a) || any_unknown(b)) {
            return Word::x(1);
        }
        differs == (op == CompareOp::Ne)
    } else {
        if any_unknown(a) || any_unknown(b) {
            return Word::x(1);
        }
        // with the sign bits inverted, two's complement is ordered as the unsigned numbers are
        let sign = if signed { 1 << ((width - 1) % 64) } else { 0 };
        let order = (0..n).rev().map(|i| {
            let flip = if i == n - 1 { sign } else { 0 };
            (a[i].v ^ flip).cmp(&(b[i].v ^ flip))
        });
        let order = order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then);
        match op {
            CompareOp::Lt => order.is_lt(),
            CompareOp::Le => order.is_le(),
            CompareOp::Gt => order.is_gt(),
            _ => order.is_ge(),
        }
    };
    Word::known(u64::from(holds))
}

/// `a` where `en` is 1, z where it is 0, x where it is unknown.
pub fn tristate(width: u32, a: &[Word], en: Word, y: &mut [Word]) {
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        let m = word_mask(width, i);
        *y = if en.is_one() {
            a[i]
        } else if en.is_zero() {
            Word::z(m)
        } else {
            Word::x(m)
        };
    }
}

/// What `inputs` drivers of one bus, one after another in `ins`, make of it.
pub fn resolve(width: u32, inputs: u32, ins: &[Word], y: &mut [Word]) {
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        let none = Word::z(word_mask(width, i));
        *y = (0..inputs).fold(none, |acc, k| acc.resolve(word_of(ins, k * width, width, i)));
    }
}

const Y: Port = Port::output("y", "the result");
const WIDTH: Parameter = Parameter { name: "width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `a` and `b`" };
const SIGNED: Parameter =
    Parameter { name: "signed", kind: Kind::FLAG, default: Some("0"), doc: "1: two's complement" };

macro_rules! comparator {
    ($name:literal, $sign:literal, $op:ident, $x:literal) => {
        Element {
            name: $name,
            summary: concat!("comparator, `a ", $sign, " b`"),
            ports: &[Port::input("a", "first number"), Port::input("b", "second number"), Y],
            parameters: &[WIDTH, SIGNED],
            meaning: concat!("`y = a ", $sign, " b` as 1 or 0. ", $x),
            source: "IEEE 1364-2005, 5.1.7 and 5.1.8",
            example: concat!(
                r#"{ "type": ""#,
                $name,
                r#"", "parameters": { "width": "W" }, "connections": { "a": "a", "b": "b", "y": "y" } }"#
            ),
            build: |a| Ok(CellKind::Compare { op: CompareOp::$op, width: a.width("width"), signed: a.flag("signed") }),
        }
    };
}

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    Element {
        name: "mux",
        summary: "multiplexer with a binary select",
        ports: &[
            Port::several("in", "the inputs, two or more; member k is chosen by `s = k`"),
            Port::input("s", "select, clog2 of the number of inputs bits wide"),
            Y,
        ],
        parameters: &[Parameter {
            name: "width",
            kind: Kind::WIDTH,
            default: Some("1"),
            doc: "bits of each input and of `y`",
        }],
        meaning: "`y = in[s]`. An x or z in `s` gives, bit by bit, the value on which every input that it could mean agrees, else x. `s` beyond the last input gives x. A z of the chosen input passes.\n\n| s | 0 | 1 | x, z |\n|---|---|---|---|\n| **y** | in[0] | in[1] | in[0] where in[0] = in[1], else x |",
        source: "IEEE 1364-2005, 5.1.13, table 5-21; Yosys `$mux`",
        example: r#"{ "type": "mux", "parameters": { "width": "W" }, "connections": { "in": ["a", "b"], "s": "take_b", "y": "y" } }"#,
        build: |a| {
            if a.inputs < 2 {
                return Err("a multiplexer needs at least two inputs".into());
            }
            Ok(CellKind::Mux { width: a.width("width"), inputs: a.inputs })
        },
    },
    comparator!("eq", "==", Eq, "0 as soon as one bit is certainly different, else x if any bit is x or z."),
    comparator!("ne", "!=", Ne, "1 as soon as one bit is certainly different, else x if any bit is x or z."),
    comparator!("lt", "<", Lt, "x if any bit is x or z."),
    comparator!("le", "<=", Le, "x if any bit is x or z."),
    comparator!("gt", ">", Gt, "x if any bit is x or z."),
    comparator!("ge", ">=", Ge, "x if any bit is x or z."),
    Element {
        name: "tristate",
        summary: "tri-state buffer",
        ports: &[
            Port::input("a", "data"),
            Port::input("en", "enable"),
            Port::output("y", "may share its net with other tri-state buffers"),
        ],
        parameters: &[Parameter { name: "width", kind: Kind::WIDTH, default: Some("1"), doc: "bits of `a` and `y`" }],
        meaning: "| en | 0 | 1 | x, z |\n|---|---|---|---|\n| **y** | z | a | x |\n\nOn a net with several drivers z yields, equal values stay, different ones give x.",
        source: "Yosys `$tribuf`; IEEE 1364-2005, 4.6.1, table 4-2",
        example: r#"{ "type": "tristate", "parameters": { "width": 8 }, "connections": { "a": "data", "en": "select", "y": "bus" } }"#,
        build: |a| Ok(CellKind::Tristate { width: a.width("width") }),
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;

    fn words_of(text: &str) -> Vec<Word> {
        text.parse::<Value>().unwrap().words().collect()
    }

    #[test]
    fn an_unknown_select_keeps_what_all_agree_on() {
        // four inputs of two bits: in[0]=00 in[1]=01 in[2]=00 in[3]=11
        let ins = words_of("8'b11_00_01_00");
        let pick = |s: &str| {
            let mut y = [Word::ZERO];
            mux(2, 4, &ins, words_of(s)[0], &mut y);
            Value::from_words(&y, 2).bit_string()
        };
        assert_eq!(pick("2'b01"), "01");
        assert_eq!(pick("2'bx0"), "00"); // 0 or 2
        assert_eq!(pick("2'b0x"), "0x"); // 0 or 1
        assert_eq!(pick("2'bx1"), "x1"); // 1 or 3
        assert_eq!(pick("2'bxx"), "xx");
        let mut y = [Word::ZERO];
        mux(2, 3, &ins, Word::known(3), &mut y);
        assert_eq!(y[0], Word::x(3));
    }

    #[test]
    fn comparisons_across_words_and_signs() {
        let is = |op, signed, a: i64, b: i64| {
            let w = |n| Value::from_i64(n, 70).words().collect::<Vec<_>>();
            compare(op, 70, signed, &w(a), &w(b)).v == 1
        };
        for (a, b) in [(-1, 0), (0, -1), (5, 7), (7, 5), (3, 3), (i64::MIN, i64::MAX)] {
            assert_eq!(is(CompareOp::Lt, true, a, b), a < b);
            assert_eq!(is(CompareOp::Ge, true, a, b), a >= b);
            assert_eq!(is(CompareOp::Le, false, a, b), (a as u64) <= b as u64);
            assert_eq!(is(CompareOp::Gt, false, a, b), (a as u64) > b as u64);
            assert_eq!(is(CompareOp::Eq, false, a, b), a == b);
            assert_eq!(is(CompareOp::Ne, true, a, b), a != b);
        }
        let c = |op, a: &str, b: &str| compare(op, 4, false, &words_of(a), &words_of(b));
        assert_eq!(c(CompareOp::Eq, "4'b1x00", "4'b0000"), Word::known(0));
        assert_eq!(c(CompareOp::Ne, "4'b1x00", "4'b0000"), Word::known(1));
        assert_eq!(c(CompareOp::Eq, "4'b0x00", "4'b0000"), Word::x(1));
        assert_eq!(c(CompareOp::Lt, "4'b1x00", "4'b0000"), Word::x(1));
    }
}
