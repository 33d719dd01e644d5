//! Sixty-four four-valued bits in two machine words, and the operators on them.
//!
//! This is the form in which the engines keep all state. It knows nothing of nets or cells; a vector wider
//! than 64 bits is a slice of words, the least significant first, its unused high bits all zero.

/// Up to 64 four-valued bits in two planes.
///
/// | value | `v` | `u` |
/// |-------|-----|-----|
/// | 0     | 0   | 0   |
/// | 1     | 1   | 0   |
/// | x     | 0   | 1   |
/// | z     | 1   | 1   |
///
/// Where no bit is unknown, `v` is the number itself. Every operator reads z as x and never returns z
/// (IEEE 1364-2005, 5.1.10, tables 5-6 to 5-10).
#[derive(Clone, Copy, PartialEq, Eq, Default, Hash)]
#[repr(C)]
pub struct Word {
    /// The value plane: the bit's value where the unknown plane has 0; tells z (1) from x (0) where it has 1.
    pub v: u64,
    /// The unknown plane: a set bit is x or z.
    pub u: u64,
}

/// The `width` (0 to 64) low bits set.
#[inline(always)]
#[must_use]
pub const fn mask(width: u32) -> u64 {
    if width >= 64 { u64::MAX } else { (1 << width) - 1 }
}

/// The number of words that hold `width` bits.
#[inline(always)]
#[must_use]
pub const fn words(width: u32) -> usize {
    (width as usize).div_ceil(64)
}

/// The bits in use of word `index` of a vector of `width` bits.
#[inline(always)]
#[must_use]
pub const fn word_mask(width: u32, index: usize) -> u64 {
    mask(width - index as u32 * 64)
}

impl Word {
    /// All bits 0.
    pub const ZERO: Word = Word { v: 0, u: 0 };

    /// The low 64 bits of a known number.
    #[inline(always)]
    #[must_use]
    pub const fn known(v: u64) -> Word {
        Word { v, u: 0 }
    }

    /// Every bit of `mask` x, the others 0.
    #[inline(always)]
    #[must_use]
    pub const fn x(mask: u64) -> Word {
        Word { v: 0, u: mask }
    }

    /// Every bit of `mask` z, the others 0.
    #[inline(always)]
    #[must_use]
    pub const fn z(mask: u64) -> Word {
        Word { v: mask, u: mask }
    }

    /// With some bits x.
    #[inline(always)]
    #[must_use]
    pub const fn with_x(self, bits: u64) -> Word {
        let x = Word::x(bits);
        Word { v: self.v & !bits | x.v, u: self.u & !bits | x.u }
    }

    /// The bits in which it is another than `o`.
    #[inline(always)]
    #[must_use]
    pub const fn difference(self, o: Word) -> u64 {
        (self.v ^ o.v) | (self.u ^ o.u)
    }

    /// Bit 0 in every bit of `mask`, as `{n{bit}}` does.
    #[inline(always)]
    #[must_use]
    pub const fn splat(self, mask: u64) -> Word {
        Word { v: (self.v & 1).wrapping_neg() & mask, u: (self.u & 1).wrapping_neg() & mask }
    }

    /// The bits that are certainly 1.
    #[inline(always)]
    #[must_use]
    pub const fn ones(self) -> u64 {
        self.v & !self.u
    }

    /// The bits that are certainly 0; bits beyond the width count as 0.
    #[inline(always)]
    #[must_use]
    pub const fn zeros(self) -> u64 {
        !(self.v | self.u)
    }

    /// Whether no bit is x or z.
    #[inline(always)]
    #[must_use]
    pub const fn is_known(self) -> bool {
        self.u == 0
    }

    /// Whether bit 0 is 1 (x and z are not).
    #[inline(always)]
    #[must_use]
    pub const fn is_one(self) -> bool {
        self.ones() & 1 == 1
    }

    /// Whether bit 0 is 0 (x and z are not).
    #[inline(always)]
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.zeros() & 1 == 1
    }

    /// These bits with z read as x.
    #[inline(always)]
    #[must_use]
    pub const fn read(self) -> Word {
        Word { v: self.v & !self.u, u: self.u }
    }

    /// Bitwise AND: 0 where either is 0, 1 where both are 1, else x.
    #[inline(always)]
    #[must_use]
    pub const fn and(self, o: Word) -> Word {
        let (a, b) = (self.ones(), o.ones());
        Word { v: a & b, u: (self.u | o.u) & (self.u | a) & (o.u | b) }
    }

    /// Bitwise OR: 1 where either is 1, 0 where both are 0, else x.
    #[inline(always)]
    #[must_use]
    pub const fn or(self, o: Word) -> Word {
        let v = self.ones() | o.ones();
        Word { v, u: (self.u | o.u) & !v }
    }

    /// Bitwise exclusive OR: x where either is unknown.
    #[inline(always)]
    #[must_use]
    pub const fn xor(self, o: Word) -> Word {
        let u = self.u | o.u;
        Word { v: (self.v ^ o.v) & !u, u }
    }

    /// Bitwise NOT of the bits of `mask`: x where unknown.
    #[inline(always)]
    #[must_use]
    pub const fn not(self, mask: u64) -> Word {
        Word { v: !self.v & !self.u & mask, u: self.u & mask }
    }

    /// What a multiplexer with an x select gives: the bits on which both agree as 0 or 1, else x
    /// (IEEE 1364-2005, 5.1.13, table 5-21).
    #[inline(always)]
    #[must_use]
    pub const fn merge(self, o: Word) -> Word {
        let u = self.u | o.u | (self.v ^ o.v);
        Word { v: self.v & !u, u }
    }

    /// What two drivers of one wire give: z yields to the other, equal values stay, a conflict is x
    /// (IEEE 1364-2005, 4.6.1, table 4-2).
    #[inline(always)]
    #[must_use]
    pub const fn resolve(self, o: Word) -> Word {
        let (za, zb) = (self.v & self.u, o.v & o.u);
        let both = !za & !zb;
        let conflict = both & (self.u | o.u | (self.v ^ o.v));
        Word {
            v: (za & o.v) | (zb & self.v) | (both & self.v & o.v & !conflict),
            u: (za & o.u) | (zb & self.u) | conflict,
        }
    }
}

impl std::fmt::Debug for Word {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.u == 0 { write!(f, "{:#x}", self.v) } else { write!(f, "v={:#x} u={:#x}", self.v, self.u) }
    }
}

/// Whether any bit of the vector is x or z.
#[inline(always)]
#[must_use]
pub fn any_unknown(words: &[Word]) -> bool {
    words.iter().any(|w| w.u != 0)
}

/// Copies `width` bits from bit `lo` of `from` to bit 0 of `to`, clearing the bits above them.
#[inline]
pub fn extract(to: &mut [Word], from: &[Word], lo: u32, width: u32) {
    let (skip, shift) = (lo as usize / 64, lo % 64);
    for (i, t) in to.iter_mut().enumerate().take(words(width)) {
        let low = from[skip + i];
        let high = if shift == 0 { Word::ZERO } else { from.get(skip + i + 1).copied().unwrap_or_default() };
        let m = word_mask(width, i);
        let join = |l: u64, h: u64| if shift == 0 { l } else { (l >> shift) | (h << (64 - shift)) };
        *t = Word { v: join(low.v, high.v) & m, u: join(low.u, high.u) & m };
    }
}

/// Copies the low `width` bits of `from` (bits above them must be zero) to bit `lo` of `to`.
#[inline]
pub fn insert(to: &mut [Word], lo: u32, from: &[Word], width: u32) {
    let mut done = 0;
    while done < width {
        let (at, shift) = (((lo + done) / 64) as usize, (lo + done) % 64);
        let n = (width - done).min(64 - shift);
        let mut w = [Word::ZERO];
        extract(&mut w, from, done, n);
        let m = mask(n) << shift;
        to[at].v = (to[at].v & !m) | (w[0].v << shift);
        to[at].u = (to[at].u & !m) | (w[0].u << shift);
        done += n;
    }
}

/// Copies `width` bits from bit `lo` of `from` to bit `at` of `to`, leaving its other bits.
#[inline]
pub fn copy(to: &mut [Word], at: u32, from: &[Word], lo: u32, width: u32) {
    if lo % 64 + width <= 64 && at % 64 + width <= 64 && width > 0 {
        // within one word of each, as nearly all are
        let (w, m) = (from[lo as usize / 64], mask(width));
        let to = &mut to[at as usize / 64];
        let put = |old: u64, new: u64| old & !(m << (at % 64)) | (new >> (lo % 64) & m) << (at % 64);
        *to = Word { v: put(to.v, w.v), u: put(to.u, w.u) };
        return;
    }
    for done in (0..width).step_by(64) {
        let n = (width - done).min(64);
        let mut w = [Word::ZERO];
        extract(&mut w, from, lo + done, n);
        insert(to, at + done, &w, n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BITS: [Word; 4] = [Word::known(0), Word::known(1), Word::x(1), Word::z(1)];

    fn table(op: impl Fn(Word, Word) -> Word) -> String {
        let mut s = String::new();
        for a in BITS {
            for b in BITS {
                let y = op(a, b);
                s.push(['0', '1', 'x', 'z'][((y.v & 1) | ((y.u & 1) << 1)) as usize]);
                assert_eq!((y.v | y.u) & !1, 0);
            }
            s.push(' ');
        }
        // the index above reads x as 2 (v=0,u=1) and z as 3 (v=1,u=1)
        s.trim_end().to_string()
    }

    /// Rows a = 0 1 x z, columns b = 0 1 x z, typed in from IEEE 1364-2005.
    #[test]
    fn operators_follow_the_ieee_tables() {
        assert_eq!(table(Word::and), "0000 01xx 0xxx 0xxx");
        assert_eq!(table(Word::or), "01xx 1111 x1xx x1xx");
        assert_eq!(table(Word::xor), "01xx 10xx xxxx xxxx");
        assert_eq!(table(Word::merge), "0xxx x1xx xxxx xxxx");
        assert_eq!(table(Word::resolve), "0xx0 x1x1 xxxx 01xz");
        assert_eq!(table(|a, _| a.not(1)), "1111 0000 xxxx xxxx");
    }

    #[test]
    fn extract_and_insert_cross_words() {
        let from = [Word { v: 0xf000_0000_0000_000f, u: 1 << 63 }, Word { v: 0x5, u: 0x2 }];
        let mut out = [Word::ZERO; 1];
        extract(&mut out, &from, 60, 8);
        assert_eq!(out[0], Word { v: 0x5f, u: 0x28 });
        let mut back = [Word::ZERO; 2];
        insert(&mut back, 60, &out, 8);
        assert_eq!(back, [Word { v: 0xf << 60, u: 1 << 63 }, Word { v: 5, u: 2 }]);
        let mut whole = [Word::ZERO; 3];
        copy(&mut whole, 3, &from, 0, 128);
        assert_eq!(whole[1], Word { v: 5 << 3 | 0b111, u: 2 << 3 | 0b100 });
        let mut again = [Word::ZERO; 2];
        copy(&mut again, 0, &whole, 3, 128);
        assert_eq!(again, from);
    }
}
