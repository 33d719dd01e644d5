//! Shifts by an amount that is itself a value, and the selection of a part at such an offset.

use crate::value::Word;
use crate::value::word::{any_unknown, mask, word_mask, words};

/// What a shifter does with its first operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum ShiftOp {
    /// Towards the most significant bit; zeros come in.
    Left,
    /// Towards the least significant bit; zeros come in.
    Right,
    /// Towards the least significant bit; the sign comes in.
    RightSigned,
    /// Right by a number in two's complement; left where it is negative. Zeros come in.
    Both,
    /// Right by an unsigned number; what comes in is x: the part `a[b +: width]`.
    Part,
    /// The same by a number in two's complement; where it is negative x comes in from below.
    PartSigned,
}

/// The amount as a number of bits to the right, and whether it is known; beyond `limit` all amounts are alike.
fn amount(op: ShiftOp, b_width: u32, b: &[Word], limit: i64) -> Option<i64> {
    let n = words(b_width);
    if any_unknown(&b[..n]) {
        return None;
    }
    let signed = matches!(op, ShiftOp::Both | ShiftOp::PartSigned);
    let negative = signed && b[n - 1].v >> ((b_width - 1) % 64) & 1 == 1;
    let fill = if negative { u64::MAX } else { 0 };
    let beyond = b[1..n].iter().enumerate().any(|(i, w)| w.v != fill & word_mask(b_width, i + 1));
    let low = b[0].v | fill & !mask(b_width.min(64));
    // bit 63 is the sign only where the number is negative
    let fits = !beyond && (low >> 63 == 1) == negative;
    let right = match (fits, negative) {
        (true, _) => (low as i64).clamp(-limit, limit),
        (false, true) => -limit,
        (false, false) => limit,
    };
    Some(if op == ShiftOp::Left { -right } else { right })
}

/// Shifts `a` and gives the low `width` bits; an x or z in `b` makes all of them x (IEEE 1364-2005, 5.1.12), bits of
/// `a` move as they are.
pub fn shift(op: ShiftOp, a_width: u32, b_width: u32, width: u32, a: &[Word], b: &[Word], y: &mut [Word]) {
    let limit = i64::from(a_width.max(width)) + 1;
    let Some(right) = amount(op, b_width, b, limit) else {
        y.iter_mut().enumerate().for_each(|(i, y)| *y = Word::x(word_mask(width, i)));
        return;
    };
    let bit = |i: i64| {
        let (w, s) = ((i / 64) as usize, i % 64);
        Word { v: a[w].v >> s & 1, u: a[w].u >> s & 1 }
    };
    let inside = |i: i64| (0..i64::from(a_width)).contains(&i);
    let outside = match op {
        ShiftOp::Left | ShiftOp::Right | ShiftOp::Both => Word::ZERO,
        ShiftOp::RightSigned => bit(i64::from(a_width) - 1),
        ShiftOp::Part | ShiftOp::PartSigned => Word::x(1),
    };
    for (i, y) in y.iter_mut().enumerate().take(words(width)) {
        let from = right + i as i64 * 64;
        let m = word_mask(width, i);
        let n = i64::from(m.count_ones());
        if inside(from) && inside(from + n - 1) {
            let (w, s) = ((from / 64) as usize, (from % 64) as u32);
            let high = a.get(w + 1).copied().filter(|_| s > 0).unwrap_or_default();
            let join = |l: u64, h: u64| if s == 0 { l } else { l >> s | h << (64 - s) };
            *y = Word { v: join(a[w].v, high.v) & m, u: join(a[w].u, high.u) & m };
            continue;
        }
        *y = Word::ZERO;
        for k in 0..n {
            let one = if inside(from + k) { bit(from + k) } else { outside };
            y.v |= one.v << k;
            y.u |= one.u << k;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;
    use proptest::prelude::*;

    fn run(op: ShiftOp, a: &str, b: &str, width: u32) -> String {
        let (a, b): (Value, Value) = (a.parse().unwrap(), b.parse().unwrap());
        let mut y = vec![Word::ZERO; words(width)];
        let (aw, bw): (Vec<Word>, Vec<Word>) = (a.words().collect(), b.words().collect());
        shift(op, a.width(), b.width(), width, &aw, &bw, &mut y);
        Value::from_words(&y, width).bit_string()
    }

    #[test]
    fn by_hand() {
        assert_eq!(run(ShiftOp::Left, "4'b10x1", "2'd1", 4), "0x10");
        assert_eq!(run(ShiftOp::Right, "4'b10x1", "2'd1", 4), "010x");
        assert_eq!(run(ShiftOp::RightSigned, "4'b10x1", "3'd7", 4), "1111");
        assert_eq!(run(ShiftOp::Both, "4'b0011", "2'b11", 4), "0110");
        assert_eq!(run(ShiftOp::Part, "4'b0011", "2'd3", 3), "xx0");
        assert_eq!(run(ShiftOp::PartSigned, "4'b0011", "2'b11", 3), "11x");
        assert_eq!(run(ShiftOp::Left, "4'b0011", "2'bx0", 4), "xxxx");
        // an amount of more than 64 bits
        assert_eq!(run(ShiftOp::Right, "4'b1111", &format!("70'b1{}", "0".repeat(69)), 4), "0000");
        assert_eq!(run(ShiftOp::PartSigned, "4'b1111", &format!("70'b1{}", "0".repeat(69)), 4), "xxxx");
    }

    proptest! {
        /// Against the host's 128-bit integers.
        #[test]
        fn as_the_host_shifts(a: u128, b in 0u32..140, width in 1u32..=128) {
            let text = |n: u128| format!("128'b{n:0128b}");
            let expect = |n: u128| format!("{n:0128b}")[(128 - width) as usize..].to_string();
            let b_text = format!("8'd{b}");
            prop_assert_eq!(run(ShiftOp::Left, &text(a), &b_text, width), expect(a.checked_shl(b).unwrap_or(0)));
            prop_assert_eq!(run(ShiftOp::Right, &text(a), &b_text, width), expect(a.checked_shr(b).unwrap_or(0)));
            let signed = (a as i128) >> b.min(127);
            prop_assert_eq!(run(ShiftOp::RightSigned, &text(a), &b_text, width), expect(signed as u128));
        }
    }
}
