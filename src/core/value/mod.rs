//! Four-valued bit vectors: `0`, `1`, `x`, `z`, of any width.
//!
//! [`Value`] is what crosses the API: backed by [`mod@bitvec`], written and read as Verilog literals. [`word`] is the
//! same meaning in machine words, which is what the engines compute with. This room knows of nothing else.

pub mod changes;
mod literal;
mod value_names;
pub mod word;

use std::fmt;

use bitvec::prelude::*;

pub use literal::LiteralError;
pub use value_names::ValueNames;
pub use word::Word;

/// One four-valued bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum Logic {
    /// Low.
    Zero,
    /// High.
    One,
    /// Unknown.
    X,
    /// Not driven.
    Z,
}

impl Logic {
    /// `0`, `1`, `x` or `z`.
    #[must_use]
    pub const fn char(self) -> char {
        match self {
            Logic::Zero => '0',
            Logic::One => '1',
            Logic::X => 'x',
            Logic::Z => 'z',
        }
    }
}

impl fmt::Display for Logic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Write::write_char(f, self.char())
    }
}

/// A four-valued vector of a fixed width; bit 0 is the least significant.
///
/// ```
/// # use discreta_core as discreta;
/// use discreta::Value;
/// let v: Value = "4'b10x1".parse().unwrap();
/// assert_eq!(v.width(), 4);
/// assert_eq!(v.to_string(), "4'b10x1");
/// assert_eq!(v.to_u64(), None);
/// assert_eq!(Value::from_u64(9, 4).to_u64(), Some(9));
/// ```
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Value {
    v: BitVec<u64, Lsb0>,
    u: BitVec<u64, Lsb0>,
}

impl Value {
    /// `width` bits, all `bit`.
    #[must_use]
    pub fn repeat(bit: Logic, width: u32) -> Value {
        let (v, u) = match bit {
            Logic::Zero => (false, false),
            Logic::One => (true, false),
            Logic::X => (false, true),
            Logic::Z => (true, true),
        };
        let plane = |bit| {
            let mut p = BitVec::repeat(bit, width as usize);
            p.set_uninitialized(false);
            p
        };
        Value { v: plane(v), u: plane(u) }
    }

    /// `width` bits, all x: what nothing has set.
    #[must_use]
    pub fn unknown(width: u32) -> Value {
        Value::repeat(Logic::X, width)
    }

    /// The low `width` bits of `n`; bits above 64 are 0.
    #[must_use]
    pub fn from_u64(n: u64, width: u32) -> Value {
        let mut value = Value::repeat(Logic::Zero, width);
        if let Some(first) = value.v.as_raw_mut_slice().first_mut() {
            *first = n & word::mask(width);
        }
        value
    }

    /// `n` in two's complement in `width` bits, its sign extended.
    #[must_use]
    pub fn from_i64(n: i64, width: u32) -> Value {
        let mut value = Value::repeat(if n < 0 { Logic::One } else { Logic::Zero }, width);
        if let Some(first) = value.v.as_raw_mut_slice().first_mut() {
            *first = n as u64 & word::mask(width);
        }
        value
    }

    /// The first `width` bits of a word vector.
    ///
    /// # Panics
    /// If there are fewer words than the width needs.
    #[must_use]
    pub fn from_words(words: &[Word], width: u32) -> Value {
        assert!(words.len() >= word::words(width), "{width} bits need {} words", word::words(width));
        let mut value = Value::repeat(Logic::Zero, width);
        for (i, w) in words.iter().enumerate().take(word::words(width)) {
            let m = word::word_mask(width, i);
            value.v.as_raw_mut_slice()[i] = w.v & m;
            value.u.as_raw_mut_slice()[i] = w.u & m;
        }
        value
    }

    /// The value as words, the least significant first.
    pub fn words(&self) -> impl ExactSizeIterator<Item = Word> + '_ {
        let pairs = self.v.as_raw_slice().iter().zip(self.u.as_raw_slice());
        pairs.map(|(&v, &u)| Word { v, u })
    }

    /// The width in bits.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.v.len() as u32
    }

    /// Bit `index`, where 0 is the least significant.
    ///
    /// # Panics
    /// If `index` is not below the width.
    #[must_use]
    pub fn bit(&self, index: u32) -> Logic {
        match (self.v[index as usize], self.u[index as usize]) {
            (false, false) => Logic::Zero,
            (true, false) => Logic::One,
            (false, true) => Logic::X,
            (true, true) => Logic::Z,
        }
    }

    /// Sets bit `index`.
    ///
    /// # Panics
    /// If `index` is not below the width.
    pub fn set_bit(&mut self, index: u32, bit: Logic) {
        self.v.set(index as usize, matches!(bit, Logic::One | Logic::Z));
        self.u.set(index as usize, matches!(bit, Logic::X | Logic::Z));
    }

    /// The bits from the most significant down.
    pub fn bits(&self) -> impl Iterator<Item = Logic> + '_ {
        (0..self.width()).rev().map(|i| self.bit(i))
    }

    /// Whether no bit is x or z.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.u.not_any()
    }

    /// The number, if all bits are known and it fits.
    #[must_use]
    pub fn to_u64(&self) -> Option<u64> {
        let words = self.v.as_raw_slice();
        let fits = words.iter().skip(1).all(|&w| w == 0);
        (self.is_known() && fits).then(|| words.first().copied().unwrap_or(0))
    }

    /// The number in two's complement, if all bits are known and it fits.
    #[must_use]
    pub fn to_i64(&self) -> Option<i64> {
        if !self.is_known() || self.width() == 0 {
            return None;
        }
        let negative = self.v[self.v.len() - 1];
        let low = self.v.as_raw_slice()[0];
        if self.width() <= 64 {
            let unused = 64 - self.width();
            return Some(((low << unused) as i64) >> unused);
        }
        let high = &self.v[64..];
        let fits = if negative { high.all() } else { high.not_any() };
        (fits && (low >> 63 == 1) == negative).then_some(low as i64)
    }

    /// The bits as text, most significant first, without width or base.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// assert_eq!(discreta::Value::from_u64(5, 4).bit_string(), "0101");
    /// ```
    #[must_use]
    pub fn bit_string(&self) -> String {
        self.bits().map(Logic::char).collect()
    }
}

/// A Verilog literal: decimal where all bits are known and 64 bits hold it, binary otherwise.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.to_u64() {
            Some(n) => write!(f, "{}'d{n}", self.width()),
            None => write!(f, "{}'b{}", self.width(), self.bit_string()),
        }
    }
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_in_and_come_out() {
        assert_eq!(Value::from_i64(-1, 70).to_i64(), Some(-1));
        assert_eq!(Value::from_i64(-1, 70).to_u64(), None);
        assert_eq!(Value::from_u64(u64::MAX, 70).to_u64(), Some(u64::MAX));
        assert_eq!(Value::from_u64(u64::MAX, 70).to_i64(), None);
        assert_eq!(Value::from_u64(0x1ff, 8).to_u64(), Some(0xff));
        assert_eq!(Value::from_u64(0x80, 8).to_i64(), Some(-128));
        assert_eq!(Value::unknown(3).to_u64(), None);
        assert_eq!(Value::unknown(70).bit_string(), "x".repeat(70));
    }

    #[test]
    fn equal_values_are_equal_whatever_their_history() {
        let mut v = Value::repeat(Logic::Z, 70);
        for i in 0..70 {
            v.set_bit(i, Logic::Zero);
        }
        assert_eq!(v, Value::from_u64(0, 70));
        let words: Vec<Word> = vec![Word { v: u64::MAX, u: u64::MAX }; 2];
        assert_eq!(Value::from_words(&words, 70), Value::repeat(Logic::Z, 70));
    }
}
