//! What chooses between inputs otherwise than by a binary number: a line for each input, bit by bit, one of many
//! outputs, products of literals.

use super::word_of;
use crate::value::Word;
use crate::value::word::{copy, word_mask, words};

/// `a` where no line is 1, input k of `b` where line k alone is; x where several are or one is unknown.
pub fn one_hot(width: u32, a: &[Word], b: &[Word], s: &[Word], y: &mut [Word]) {
    let line = line(s);
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        *y = match line {
            Line::None => a[i],
            Line::One(k) => word_of(b, k * width, width, i),
            Line::Unclear => Word::x(word_mask(width, i)),
        };
    }
}

/// Which of many lines is 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Line {
    /// None is.
    None,
    /// This one alone is.
    One(u32),
    /// Several are, or one is unknown.
    Unclear,
}

/// Which of the bits of `s` is 1.
#[inline(always)]
#[must_use]
pub fn line(s: &[Word]) -> Line {
    let mut found = Line::None;
    for (w, i) in s.iter().zip(0..) {
        found = match (w.v, found) {
            _ if w.u != 0 => return Line::Unclear,
            (0, _) => found,
            (v, Line::None) if v.is_power_of_two() => Line::One(i * 64 + v.trailing_zeros()),
            _ => return Line::Unclear,
        };
    }
    found
}

/// Output number `s` is `a`, the others 0. Where `s` is unknown, an output that it may mean has the bits on which `a` and
/// 0 agree.
pub fn demux(width: u32, select: u32, a: &[Word], s: Word, y: &mut [Word]) {
    y.fill(Word::ZERO);
    for k in (0..1u32 << select).filter(|&k| (u64::from(k) ^ s.v) & !s.u & ((1 << select) - 1) == 0) {
        for (i, &a) in a.iter().enumerate().take(words(width)) {
            let one = [if s.u == 0 { a } else { a.merge(Word::ZERO) }];
            let n = (width - i as u32 * 64).min(64);
            copy(y, k * width + i as u32 * 64, &one, 0, n);
        }
    }
}

/// Bit by bit `b` where `s` is 1 and `a` where it is 0; where it is unknown, the value on which both agree.
pub fn bit_mux(width: u32, a: &[Word], b: &[Word], s: &[Word], y: &mut [Word]) {
    for i in 0..words(width) {
        let both = a[i].merge(b[i]);
        let pick = |a: u64, b: u64, both: u64| (a & s[i].zeros()) | (b & s[i].ones()) | (both & s[i].u);
        let m = word_mask(width, i);
        y[i] = Word { v: pick(a[i].v, b[i].v, both.v) & m, u: pick(a[i].u, b[i].u, both.u) & m };
    }
}

/// Bit by bit 1 where both are the same of 0, 1, x and z, else 0.
pub fn bit_same(width: u32, a: &[Word], b: &[Word], y: &mut [Word]) {
    for i in 0..words(width) {
        y[i] = Word::known(!(a[i].v ^ b[i].v | a[i].u ^ b[i].u) & word_mask(width, i));
    }
}

/// Whether all bits of some product are as it wants them. `table` has two bits for each input of each product: it wants
/// a 0, it wants a 1. An unknown input is as either wants it: so Yosys' model has it.
#[must_use]
pub fn products(width: u32, table: &[(u64, u64)], a: &[Word]) -> Word {
    let n = words(width);
    let holds = table
        .chunks_exact(n)
        .any(|product| product.iter().zip(a).all(|(&(zero, one), a)| zero & a.ones() == 0 && one & a.zeros() == 0));
    Word::known(u64::from(holds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;

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
