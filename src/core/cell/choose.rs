//! What chooses between inputs otherwise than by a binary number: a line for each input, bit by bit, one of many
//! outputs, products of literals.

use smallvec::SmallVec;

use super::algebra::{Algebra, Append, Site, input, unknown};
use super::pin::{binary, chosen, demux, unary};
use crate::value::Word;
use crate::value::word::{mask, words};

/// Which of the lines of a select is 1.
pub struct Lines<A: Algebra> {
    /// Whether several are, or one is unknown.
    pub unclear: A::Plane,
    /// Whether it is known that one is, and one alone.
    one: bool,
}

/// Looks at `inputs` lines, a bit each.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn lines<A: Algebra>(l: &mut A, inputs: u32, word: impl Fn(usize) -> A::Word) -> Lines<A> {
    let n = A::words(inputs);
    let (mut unknown, mut several, mut before) = (l.constant(0), l.constant(0), l.constant(0));
    let own: SmallVec<[A::Plane; 4]> = match inputs {
        // what an instance knows of lines it knows of few
        2..=64 if l.known(A::planes(word(0)).0).is_none() => (0..inputs).map(|k| line(l, &word, k)).collect(),
        _ => SmallVec::new(),
    };
    let exclusive = !own.is_empty() && l.exclusive(&own);
    for i in 0..n {
        let w = word(i);
        unknown = l.or(unknown, A::planes(w).1);
        if exclusive {
            continue;
        }
        // more than one line of this word, or one here and one before
        let ones = l.ones(w);
        let (more, some) = (l.several(ones), l.any(ones));
        let both = l.and(before, some);
        several = l.or(several, more);
        several = l.or(several, both);
        before = l.or(before, some);
    }
    let unknown = l.any(unknown);
    let unclear = l.or(unknown, several);
    // what holds while none is active does not matter where one always is
    let one = exclusive && l.known(unclear) == Some(0) && l.exhaustive(&own);
    Lines { unclear, one }
}

/// Whether line `k` is 1.
#[inline(always)]
fn line<A: Algebra>(l: &mut A, word: &impl Fn(usize) -> A::Word, k: u32) -> A::Plane {
    let ones = l.ones(word((k / A::BITS) as usize));
    l.bits(ones, k % A::BITS, 1)
}

/// One word of `a` where no line is 1, of input k where line k alone is; x where several are or one is unknown.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn one_hot_word<A: Algebra>(
    l: &mut A,
    inputs: u32,
    mask: u64,
    lines: &Lines<A>,
    word: impl Fn(usize) -> A::Word,
    a: A::Word,
    input: impl Fn(&mut A, u32) -> A::Word,
) -> A::Word {
    let mut y = if lines.one { input(l, 0) } else { a };
    for i in 0..A::words(inputs) {
        let ones = l.ones(word(i));
        let first = i as u32 * A::BITS;
        if let Some(mut ones) = l.known(ones) {
            // only those that are 1
            while ones != 0 {
                y = input(l, first + ones.trailing_zeros());
                ones &= ones - 1;
            }
            continue;
        }
        let from = if i == 0 { u32::from(lines.one) } else { 0 };
        for k in from..A::BITS.min(inputs - first) {
            let one = input(l, first + k);
            let s = l.bits(ones, k, 1);
            y = l.pick(s, one, y);
        }
    }
    let x = l.literal(Word::x(mask));
    l.pick(lines.unclear, x, y)
}

/// A multiplexer with a line for each input.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn one_hot<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, inputs: u32) {
    let lines = lines(l, inputs, |i| s.get(chosen::S, i));
    for i in 0..A::words(width) {
        let word = |i: usize| s.get(chosen::S, i);
        let y = one_hot_word(l, inputs, A::mask(width, i), &lines, word, s.get(chosen::A, i), |l, k| {
            input(l, s, chosen::B, width, k, i)
        });
        s.put(0, i, y);
    }
}

/// Output number `s` is `a`, the others 0. Where `s` is unknown, an output that it may mean has the bits on which `a` and
/// 0 agree.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn demux<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, select: u32) {
    let unknown = unknown(l, s, demux::S, select);
    let none = l.literal(Word::ZERO);
    let mut all = Append::new(l, 0);
    for k in 0..1u64 << select {
        let mut differ = l.constant(0);
        for i in 0..A::words(select) {
            let (v, u) = A::planes(s.get(demux::S, i));
            let number = l.constant(k >> (i as u32 * A::BITS) & mask(A::BITS));
            let here = l.xor(v, number);
            let here = l.and_not(here, u);
            differ = l.or(differ, here);
        }
        let differ = l.any(differ);
        for i in 0..A::words(width) {
            let a = s.get(demux::A, i);
            let merged = l.merge4(a, none);
            let passed = l.pick(unknown, merged, a);
            let y = l.pick(differ, none, passed);
            all.push(l, s, y, A::mask(width, i).count_ones());
        }
    }
    all.finish(s);
}

/// Of three planes the bits that three masks pick.
#[inline(always)]
fn blend<A: Algebra>(l: &mut A, [a, b, c]: [A::Plane; 3], [of_a, of_b, of_c]: [A::Plane; 3]) -> A::Plane {
    let (a, b, c) = (l.and(a, of_a), l.and(b, of_b), l.and(c, of_c));
    let ab = l.or(a, b);
    l.or(ab, c)
}

/// Bit by bit `b` where `s` is 1 and `a` where it is 0; where it is unknown, the value on which both agree.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn bit_mux<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    for i in 0..A::words(width) {
        let (a, b, select) = (s.get(chosen::A, i), s.get(chosen::B, i), s.get(chosen::S, i));
        let (one, zero, (_, u)) = (l.ones(select), l.zeros(select, A::mask(width, i)), A::planes(select));
        let both = l.merge4(a, b);
        let ((av, au), (bv, bu), (v, both_u)) = (A::planes(a), A::planes(b), A::planes(both));
        let y = A::word(blend(l, [av, bv, v], [zero, one, u]), blend(l, [au, bu, both_u], [zero, one, u]));
        s.put(0, i, y);
    }
}

/// Bit by bit 1 where both are the same of 0, 1, x and z, else 0.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn bit_same<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    for i in 0..A::words(width) {
        let ((av, au), (bv, bu)) = (A::planes(s.get(binary::A, i)), A::planes(s.get(binary::B, i)));
        let (v, u) = (l.xor(av, bv), l.xor(au, bu));
        let differ = l.or(v, u);
        let same = l.not(differ, A::mask(width, i));
        let y = l.sure(same);
        s.put(0, i, y);
    }
}

/// Whether all bits of some product are as it wants them. `table` has two bits for each input of each product: it wants
/// a 0, it wants a 1. An unknown input is as either wants it: so Yosys' model has it.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn products<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, table: &[(u64, u64)]) {
    let mut holds = l.constant(0);
    for product in table.chunks_exact(words(width)) {
        let mut against = l.constant(0);
        for i in 0..A::words(width) {
            let (at, shift) = (i as u32 * A::BITS / 64, i as u32 * A::BITS % 64);
            let (zero, one) = product[at as usize];
            let wanted = |plane: u64| plane >> shift & mask(A::BITS);
            if wanted(zero) | wanted(one) == 0 {
                continue;
            }
            let (zero, one) = (l.constant(wanted(zero)), l.constant(wanted(one)));
            let a = s.get(unary::A, i);
            let (v, u) = A::planes(a);
            let (ones, some) = (l.ones(a), l.or(v, u));
            let (not_zero, not_one) = (l.and(zero, ones), l.and_not(one, some));
            let here = l.or(not_zero, not_one);
            against = l.or(against, here);
        }
        let against = l.any(against);
        let this = l.not(against, 1);
        holds = l.or(holds, this);
    }
    let y = l.sure(holds);
    s.put(0, 0, y);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;
    use crate::cell::{CellKind, evaluate};

    fn one_hot(width: u32, a: &[Word], b: &[Word], s: &[Word], y: &mut [Word]) {
        evaluate(&CellKind::OneHotMux { width, inputs: 3 }, &[a, b, s], &mut [y]);
    }

    fn demux(width: u32, select: u32, a: &[Word], s: Word, y: &mut [Word]) {
        evaluate(&CellKind::Demux { width, select }, &[a, &[s]], &mut [y]);
    }

    fn bit_mux(width: u32, a: &[Word], b: &[Word], s: &[Word], y: &mut [Word]) {
        evaluate(&CellKind::BitMux { width }, &[a, b, s], &mut [y]);
    }

    fn bit_same(width: u32, a: &[Word], b: &[Word], y: &mut [Word]) {
        evaluate(&CellKind::BitSame { width }, &[a, b], &mut [y]);
    }

    fn products(width: u32, table: &[(u64, u64)], a: &[Word]) -> Word {
        let mut y = [Word::ZERO];
        evaluate(&CellKind::Products { width, table: table.into() }, &[a], &mut [&mut y]);
        y[0]
    }

    fn words_of(text: &str) -> Vec<Word> {
        text.parse::<Value>().unwrap().words().collect()
    }

    #[test]
    fn of_several_lines_nothing_is_known() {
        let pick = |s: &str| {
            let mut y = [Word::ZERO];
            one_hot(2, &words_of("2'b01"), &words_of("6'b11_10_0z"), &words_of(s), &mut y);
            Value::from_words(&y, 2).bit_string()
        };
        assert_eq!(["3'b000", "3'b001", "3'b010", "3'b100"].map(pick), ["01", "0z", "10", "11"]);
        assert_eq!(["3'b011", "3'bx00", "3'b01x", "3'b0z0"].map(pick), ["xx"; 4]);
    }

    #[test]
    fn one_of_many_outputs() {
        let out = |s: &str| {
            let mut y = [Word::ZERO];
            demux(2, 2, &words_of("2'b01"), words_of(s)[0], &mut y);
            Value::from_words(&y, 8).bit_string()
        };
        assert_eq!(out("2'b10"), "00010000");
        assert_eq!(out("2'b1x"), "0x0x0000");
    }

    #[test]
    fn bit_by_bit() {
        let mut y = [Word::ZERO];
        bit_mux(5, &words_of("5'b01100"), &words_of("5'b10101"), &words_of("5'b01xxx"), &mut y);
        assert_eq!(Value::from_words(&y, 5).bit_string(), "0010x");
        bit_same(5, &words_of("5'b01xz0"), &words_of("5'b00xxz"), &mut y);
        assert_eq!(Value::from_words(&y, 5).bit_string(), "10100");
    }

    #[test]
    fn a_product_ignores_what_it_does_not_name() {
        // a[0] & !a[2]
        let table = [(0b100, 0b001)];
        let y = |a: &str| products(3, &table, &words_of(a)).v;
        assert_eq!([y("3'b001"), y("3'b011"), y("3'b101"), y("3'b000"), y("3'bx01")], [1, 1, 0, 0, 1]);
    }
}
