//! Carries as Yosys' arithmetic cells have them: three numbers to two, a carry chain, an adder with all its carries.

use crate::value::Word;
use crate::value::word::{any_unknown, word_mask, words};

/// Bit by bit `a + b + c`: the sums into `y`, the carries into `x`; both x where one of the three is unknown.
pub fn carry_save(width: u32, a: &[Word], b: &[Word], c: &[Word], x: &mut [Word], y: &mut [Word]) {
    for i in 0..words(width) {
        let u = a[i].u | b[i].u | c[i].u;
        let (av, bv, cv) = (a[i].v & !u, b[i].v & !u, c[i].v & !u);
        y[i] = Word { v: av ^ bv ^ cv, u };
        x[i] = Word { v: av & bv | cv & (av ^ bv), u };
    }
}

/// The carries of a chain that generates at `g` and propagates at `p`; all x where anything is unknown.
pub fn chain(width: u32, p: &[Word], g: &[Word], ci: Word, co: &mut [Word]) {
    let n = words(width);
    if any_unknown(&p[..n]) || any_unknown(&g[..n]) || ci.u & 1 != 0 {
        (0..n).for_each(|i| co[i] = Word::x(word_mask(width, i)));
        return;
    }
    let mut carry = ci.v & 1;
    for i in 0..n {
        let mut all = 0;
        for k in 0..word_mask(width, i).count_ones() {
            carry = g[i].v >> k & 1 | p[i].v >> k & carry;
            all |= carry << k;
        }
        co[i] = Word::known(all);
    }
}

/// Shape of an adder with all its carries.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub struct Alu {
    /// Bits of `a`.
    pub a_width: u32,
    /// Bits of `b`.
    pub b_width: u32,
    /// Bits of the result.
    pub width: u32,
    /// The operands are extended by their sign.
    pub signed: bool,
}

impl Alu {
    /// Word `i` of an operand of `from` bits, extended or cut to the width of the result.
    fn operand(&self, a: &[Word], from: u32, i: usize) -> Word {
        let w = a.get(i).copied().filter(|_| i < words(from)).unwrap_or_default();
        let m = word_mask(self.width, i);
        if i + 1 < words(from) || from >= self.width {
            return Word { v: w.v & m, u: w.u & m };
        }
        let last = a[words(from) - 1];
        let sign = Word { v: last.v >> ((from - 1) % 64), u: last.u >> ((from - 1) % 64) };
        let high = if self.signed { sign.splat(u64::MAX) } else { Word::ZERO };
        let own = if i < words(from) { word_mask(from, i) } else { 0 };
        Word { v: (w.v & own | high.v & !own) & m, u: (w.u & own | high.u & !own) & m }
    }

    /// `a + (b ^ bi) + ci`: the bitwise exclusive or into `x`, the sum into `y`, the carries into `co`. Sum and carries
    /// are all x where anything is unknown.
    pub fn add(&self, ins: &[&[Word]], [x, y, co]: [&mut [Word]; 3]) {
        let [a, b, ci, bi] = ins else { unreachable!("four pins") };
        let (ci, bi) = (ci[0], bi[0]);
        let unknown =
            any_unknown(&a[..words(self.a_width)]) || any_unknown(&b[..words(self.b_width)]) || (ci.u | bi.u) & 1 != 0;
        let mut carry = ci.v & 1;
        for i in 0..words(self.width) {
            let m = word_mask(self.width, i);
            let (a, b) = (self.operand(a, self.a_width, i), self.operand(b, self.b_width, i).xor(bi.splat(m)));
            x[i] = a.xor(b);
            if unknown {
                (y[i], co[i]) = (Word::x(m), Word::x(m));
                continue;
            }
            let (sum, c1) = a.v.overflowing_add(b.v);
            let (sum, c2) = sum.overflowing_add(carry);
            y[i] = Word::known(sum & m);
            // a bit of the sum differs from that of the exclusive or where a carry comes in from below
            let into = sum ^ a.v ^ b.v;
            co[i] = Word::known((a.v & b.v | into & (a.v | b.v)) & m);
            carry = u64::from(c1 | c2);
        }
    }
}
