//! Multiplexers, comparators and tri-state drivers.

use smallvec::SmallVec;

use super::CellKind;
use super::algebra::{Algebra, Site, input, part};
use super::element::{Element, Kind, Parameter, Port};
use super::pin::{binary, mux, several, tristate};
use crate::value::Word;

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

/// The number that `width` bits of a pin are, if that is decided; none if any of them is x or z.
#[inline(always)]
pub(super) fn number<A: Algebra>(l: &A, s: &impl Site<A>, pin: usize, width: u32) -> Option<u64> {
    let mut number = 0;
    for i in 0..A::words(width) {
        let (v, u) = A::planes(s.get(pin, i));
        if l.known(u)? != 0 {
            return None;
        }
        number |= l.known(v)?.checked_shl(i as u32 * A::BITS).unwrap_or(0);
    }
    Some(number)
}

/// One word of input number `s` of `inputs`. An x in `s` gives the bits on which all inputs that it could mean agree; a
/// number beyond the inputs gives x. `number` is that of the select, if it is decided.
#[inline(always)]
pub fn mux_word<A: Algebra>(
    l: &mut A,
    inputs: u32,
    mask: u64,
    number: Option<u64>,
    select: impl Fn(&mut A, u32) -> A::Word,
    input: impl Fn(&mut A, u32) -> A::Word,
) -> A::Word {
    let input = |l: &mut A, k: u64| match u32::try_from(k) {
        Ok(k) if k < inputs => input(l, k),
        _ => l.literal(Word::x(mask)),
    };
    if let Some(k) = number {
        return input(l, k);
    }
    let bits = select_width(inputs);
    if bits == 1 {
        let (zero, one) = (input(l, 0), input(l, 1));
        let s = select(l, 0);
        return l.mux4(s, one, zero);
    }
    // in pairs by the lowest bit of the select, what is chosen in pairs by the next: as a binary counter carries
    let mut chosen: SmallVec<[A::Word; 8]> = SmallVec::new();
    for k in 0..1u64 << bits {
        let mut one = input(l, k);
        for bit in 0..k.trailing_ones().min(bits) {
            let zero = chosen.pop().unwrap_or(one);
            let s = select(l, bit);
            one = l.mux4(s, one, zero);
        }
        chosen.push(one);
    }
    chosen[0]
}

/// A multiplexer.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn mux<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, inputs: u32) {
    let number = number(l, s, mux::S, select_width(inputs));
    for i in 0..A::words(width) {
        let m = A::mask(width, i);
        let select = |l: &mut A, bit: u32| part(l, s, mux::S, bit, 1);
        let y = mux_word(l, inputs, m, number, select, |l, k| input(l, s, mux::IN, width, k, i));
        s.put(0, i, y);
    }
}

/// A comparison. Sameness is always decided. Equality is decided as soon as one bit is certainly different; an order
/// needs every bit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn compare<A: Algebra>(l: &mut A, s: &mut impl Site<A>, op: CompareOp, width: u32, signed: bool) {
    let n = A::words(width);
    let (mut differs, mut unknown) = (l.constant(0), l.constant(0));
    let y = match op {
        CompareOp::Same | CompareOp::Differs => {
            for i in 0..n {
                let ((av, au), (bv, bu)) = (A::planes(s.get(binary::A, i)), A::planes(s.get(binary::B, i)));
                let (v, u) = (l.xor(av, bv), l.xor(au, bu));
                let here = l.or(v, u);
                differs = l.or(differs, here);
            }
            let differs = l.any(differs);
            let y = if op == CompareOp::Differs { differs } else { l.not(differs, 1) };
            l.sure(y)
        }
        CompareOp::Eq | CompareOp::Ne => {
            for i in 0..n {
                let ((av, au), (bv, bu)) = (A::planes(s.get(binary::A, i)), A::planes(s.get(binary::B, i)));
                let (v, u) = (l.xor(av, bv), l.or(au, bu));
                let certain = l.and_not(v, u);
                differs = l.or(differs, certain);
                unknown = l.or(unknown, u);
            }
            let (differs, unknown) = (l.any(differs), l.any(unknown));
            let y = if op == CompareOp::Ne { differs } else { l.not(differs, 1) };
            let unknown = l.and_not(unknown, differs);
            l.unless(unknown, y, 1)
        }
        CompareOp::Lt | CompareOp::Le | CompareOp::Gt | CompareOp::Ge => {
            let swapped = matches!(op, CompareOp::Gt | CompareOp::Le);
            let (a, b) = if swapped { (binary::B, binary::A) } else { (binary::A, binary::B) };
            let mut less = l.constant(0);
            for i in 0..n {
                let ((mut av, au), (mut bv, bu)) = (A::planes(s.get(a, i)), A::planes(s.get(b, i)));
                unknown = l.or(unknown, au);
                unknown = l.or(unknown, bu);
                if signed && i == n - 1 {
                    // with the sign bits inverted, two's complement is ordered as the unsigned numbers are
                    let sign = l.constant(1 << ((width - 1) % A::BITS));
                    (av, bv) = (l.xor(av, sign), l.xor(bv, sign));
                }
                let (here, same) = (l.less(av, bv), l.equal(av, bv));
                let below = l.and(same, less);
                less = l.or(here, below);
            }
            let unknown = l.any(unknown);
            let inverted = matches!(op, CompareOp::Le | CompareOp::Ge);
            let y = if inverted { l.not(less, 1) } else { less };
            l.unless(unknown, y, 1)
        }
    };
    s.put(0, 0, y);
}

/// `a` where `en` is 1, z where it is 0, x where it is unknown.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn tristate<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let en = s.get(tristate::EN, 0);
    let (one, zero) = (l.is_one(en), l.is_zero(en));
    for i in 0..A::words(width) {
        let m = A::mask(width, i);
        let (z, x) = (l.literal(Word::z(m)), l.literal(Word::x(m)));
        let off = l.pick(zero, z, x);
        let y = l.pick(one, s.get(tristate::A, i), off);
        s.put(0, i, y);
    }
}

/// What `inputs` drivers of one bus, one after another, make of it.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn resolve<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, inputs: u32) {
    for i in 0..A::words(width) {
        let m = A::mask(width, i);
        let mut y = l.literal(Word::z(m));
        for k in 0..inputs {
            let one = input(l, s, several::IN, width, k, i);
            y = l.resolve4(y, one, m);
        }
        s.put(0, i, y);
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
    use crate::cell::evaluate;

    fn mux(width: u32, inputs: u32, ins: &[Word], s: Word, y: &mut [Word]) {
        evaluate(&CellKind::Mux { width, inputs }, &[ins, &[s]], &mut [y]);
    }

    fn compare(op: CompareOp, width: u32, signed: bool, a: &[Word], b: &[Word]) -> Word {
        let mut y = [Word::ZERO];
        evaluate(&CellKind::Compare { op, width, signed }, &[a, b], &mut [&mut y]);
        y[0]
    }

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
