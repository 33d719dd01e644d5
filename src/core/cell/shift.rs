//! Shifts by an amount that is itself a value, and the selection of a part at such an offset.

use smallvec::SmallVec;

use super::algebra::{Algebra, Site, part, put_x, unknown, value_bit};
use super::divide::negated_if;
use super::pin::binary;
use crate::value::Word;
use crate::value::word::{mask, word_mask};

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

impl ShiftOp {
    /// Whether the amount is in two's complement.
    fn is_signed(self) -> bool {
        matches!(self, ShiftOp::Both | ShiftOp::PartSigned)
    }
}

/// The amount as a number of bits to the right, if it is decided; beyond `limit` all amounts are alike.
#[cfg_attr(not(debug_assertions), inline(always))]
fn decided<A: Algebra>(l: &A, s: &impl Site<A>, op: ShiftOp, b_width: u32, limit: i64) -> Option<i64> {
    let mut words: SmallVec<[u64; 2]> = SmallVec::from_elem(0, b_width.div_ceil(64) as usize);
    for i in 0..A::words(b_width) {
        let (v, u) = A::planes(s.get(binary::B, i));
        if l.known(u)? != 0 {
            return None;
        }
        let bit = i as u32 * A::BITS;
        words[(bit / 64) as usize] |= l.known(v)? << (bit % 64);
    }
    let top = words.len() - 1;
    let negative = op.is_signed() && words[top] >> ((b_width - 1) % 64) & 1 == 1;
    let fill = if negative { u64::MAX } else { 0 };
    words[top] |= fill & !word_mask(b_width, top);
    // bit 63 is the sign only where the number is negative
    let fits = words[1..].iter().all(|&w| w == fill) && (words[0] >> 63 == 1) == negative;
    let right = match (fits, negative) {
        (true, _) => (words[0] as i64).clamp(-limit, limit),
        (false, true) => -limit,
        (false, false) => limit,
    };
    Some(if op == ShiftOp::Left { -right } else { right })
}

/// A row of words and what lies on both sides of it.
struct Row<A: Algebra> {
    words: SmallVec<[A::Word; 2]>,
    fill: A::Word,
}

impl<A: Algebra> Row<A> {
    #[inline(always)]
    fn at(&self, i: i64) -> A::Word {
        usize::try_from(i).ok().and_then(|i| self.words.get(i).copied()).unwrap_or(self.fill)
    }

    /// The row as it stands `bits` further down, in `n` words.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn moved(&self, l: &mut A, bits: i64, n: usize) -> SmallVec<[A::Word; 2]> {
        let (by, shift) = (bits.div_euclid(A::BITS.into()), bits.rem_euclid(A::BITS.into()) as u32);
        (0..n as i64)
            .map(|i| {
                let low = self.at(i + by);
                if shift == 0 {
                    return low;
                }
                let ((lv, lu), (hv, hu)) = (A::planes(low), A::planes(self.at(i + by + 1)));
                let mut plane = |low: A::Plane, high: A::Plane| {
                    let (low, high) = (l.shr(low, shift), l.shl(high, A::BITS - shift));
                    l.or(low, high)
                };
                A::word(plane(lv, hv), plane(lu, hu))
            })
            .collect()
    }

    /// The row moved by a number of bits that is not decided, `amount`, in `n` words.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn moved_by(&self, l: &mut A, left: bool, amount: &[A::Plane], b_width: u32, n: usize) -> SmallVec<[A::Word; 2]> {
        let log = A::BITS.trailing_zeros();
        let mut row = Row::<A> { words: self.words.clone(), fill: self.fill };
        let most = row.words.len().max(n);
        if left {
            row.words.truncate(n);
        }
        // beyond so many words all is what comes in
        let levels = if most == 1 { 0 } else { usize::BITS - most.leading_zeros() };
        let bit = |l: &mut A, j: u32| match j < b_width {
            true => l.bits(amount[(j / A::BITS) as usize], j % A::BITS, 1),
            false => l.constant(0),
        };
        for level in 0..levels {
            let s = bit(l, log + level);
            let far = if left { -(1i64 << level) } else { 1 << level };
            let len = if left { n } else { row.words.len() };
            row.words = (0..len as i64).map(|i| l.pick(s, row.at(i + far), row.at(i))).collect();
        }
        let mut beyond = l.constant(0);
        for (i, &w) in amount.iter().enumerate() {
            let first = i as u32 * A::BITS;
            if first + A::BITS > log + levels {
                let own = (log + levels).saturating_sub(first);
                let above = l.shr(w, own);
                beyond = l.or(beyond, above);
            }
        }
        let beyond = l.any(beyond);
        let by = l.bits(amount[0], 0, log);
        let most = l.constant(u64::from(A::BITS) - 1);
        let none = l.constant(0);
        let (rest, _) = l.sub(most, by, none, A::BITS);
        (0..n as i64)
            .map(|i| {
                let here = row.at(i);
                let moved = if A::BITS == 1 {
                    here
                } else {
                    let next = row.at(if left { i - 1 } else { i + 1 });
                    let ((hv, hu), (nv, nu)) = (A::planes(here), A::planes(next));
                    let mut plane = |here: A::Plane, next: A::Plane| {
                        let (here, next) = if left {
                            let next = l.shr(next, 1);
                            (l.shl_by(here, by), l.shr_by(next, rest))
                        } else {
                            let next = l.shl(next, 1);
                            (l.shr_by(here, by), l.shl_by(next, rest))
                        };
                        l.or(here, next)
                    };
                    A::word(plane(hv, nv), plane(hu, nu))
                };
                l.pick(beyond, self.fill, moved)
            })
            .collect()
    }
}

/// Shifts `a` and gives the low `width` bits; an x or z in `b` makes all of them x (IEEE 1364-2005, 5.1.12), bits of
/// `a` move as they are.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn shift<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    op: ShiftOp,
    (a_width, b_width, width): (u32, u32, u32),
) {
    let limit = i64::from(a_width.max(width)) + 1;
    let unknown = unknown(l, s, binary::B, b_width);
    if l.known(unknown).is_some_and(|n| n != 0) {
        return put_x(l, s, 0, width);
    }
    let top = A::words(a_width) - 1;
    let whole = mask(A::BITS);
    let fill = match op {
        ShiftOp::Left | ShiftOp::Right | ShiftOp::Both => l.literal(Word::ZERO),
        ShiftOp::RightSigned => {
            let (v, u) = A::planes(part(l, s, binary::A, a_width - 1, 1));
            A::word(l.splat(v, whole), l.splat(u, whole))
        }
        ShiftOp::Part | ShiftOp::PartSigned => l.literal(Word::x(whole)),
    };
    let mut row = Row::<A> { words: (0..=top).map(|i| s.get(binary::A, i)).collect(), fill };
    // above the operand too there is what comes in
    let unused = l.constant(whole & !A::mask(a_width, top));
    let ((v, u), (fill_v, fill_u)) = (A::planes(row.words[top]), A::planes(fill));
    let (high_v, high_u) = (l.and(fill_v, unused), l.and(fill_u, unused));
    row.words[top] = A::word(l.or(v, high_v), l.or(u, high_u));
    let n = A::words(width);
    let y = match decided(l, s, op, b_width, limit) {
        Some(right) => row.moved(l, right, n),
        None => {
            let amount: SmallVec<[A::Plane; 2]> =
                (0..A::words(b_width)).map(|i| A::planes(s.get(binary::B, i)).0).collect();
            match op {
                ShiftOp::Left => row.moved_by(l, true, &amount, b_width, n),
                ShiftOp::Right | ShiftOp::RightSigned | ShiftOp::Part => row.moved_by(l, false, &amount, b_width, n),
                ShiftOp::Both | ShiftOp::PartSigned => {
                    let negative = value_bit(l, s, binary::B, b_width - 1);
                    let minus = negated_if(l, negative, &amount, b_width);
                    let left = row.moved_by(l, true, &minus, b_width, n);
                    let right = row.moved_by(l, false, &amount, b_width, n);
                    left.into_iter().zip(right).map(|(left, right)| l.pick(negative, left, right)).collect()
                }
            }
        }
    };
    for (i, y) in y.into_iter().enumerate() {
        let m = A::mask(width, i);
        let (y, x) = (l.low4(y, m.count_ones()), l.literal(Word::x(m)));
        let y = l.pick(unknown, x, y);
        s.put(0, i, y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;
    use crate::cell::{CellKind, evaluate};
    use crate::value::word::words;
    use proptest::prelude::*;

    fn run(op: ShiftOp, a: &str, b: &str, width: u32) -> String {
        let (a, b): (Value, Value) = (a.parse().unwrap(), b.parse().unwrap());
        let mut y = vec![Word::ZERO; words(width)];
        let (aw, bw): (Vec<Word>, Vec<Word>) = (a.words().collect(), b.words().collect());
        let kind = CellKind::Shift { op, a_width: a.width(), b_width: b.width(), width };
        evaluate(&kind, &[&aw, &bw], &mut [&mut y]);
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
