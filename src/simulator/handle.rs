//! Signals found by name, once, and the values that they are given.

use crate::Value;
use crate::netlist::{CellId, NetId, Slice};

/// An input of a circuit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Input {
    /// The netlist that it is of.
    pub(super) of: u64,
    pub(super) net: NetId,
    pub(super) width: u32,
}

/// A net, port or other named signal whose value can be read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Probe {
    /// The netlist that it is of.
    pub(super) of: u64,
    pub(super) name: String,
    pub(super) bits: Vec<Slice>,
    pub(super) width: u32,
}

/// A memory whose words can be read and written.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MemoryHandle {
    /// The netlist that it is of.
    pub(super) of: u64,
    pub(super) name: String,
    pub(super) cell: CellId,
    pub(super) width: u32,
    pub(super) size: u32,
    pub(super) offset: i64,
}

impl Input {
    /// How many bits it has.
    #[must_use]
    pub fn width(self) -> u32 {
        self.width
    }
}

impl Probe {
    /// The name by which it was found.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many bits it has.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }
}

impl MemoryHandle {
    /// How many bits a word has.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The addresses of its words.
    #[must_use]
    pub fn addresses(&self) -> std::ops::Range<i64> {
        self.offset..self.offset + i64::from(self.size)
    }
}

/// What can be given to a signal by name: whole numbers, [`Value`]s and their texts (`"4'b10x1"`, `"8'hff"`, `"12"`).
/// A number that does not fit the signal is an error; negative ones are in two's complement.
pub trait IntoValue: sealed::Sealed {
    /// The value for a signal of `width` bits.
    ///
    /// # Errors
    /// Why it is none for that.
    fn into_value(self, width: u32) -> Result<Value, String>;
}

mod sealed {
    pub trait Sealed {}
}

fn unsigned(n: u64, width: u32) -> Result<Value, String> {
    if width < 64 && n >> width != 0 {
        return Err(format!("{n} needs more than its {width} bits"));
    }
    Ok(Value::from_u64(n, width))
}

fn signed(n: i64, width: u32) -> Result<Value, String> {
    if n >= 0 {
        return unsigned(n as u64, width);
    }
    if width < 64 && (width == 0 || n >> (width - 1) != -1) {
        return Err(format!("{n} needs more than its {width} bits"));
    }
    Ok(Value::from_i64(n, width))
}

macro_rules! numbers {
    ($($kind:ty: $by:ident as $wide:ty),*) => {
        $(
            impl sealed::Sealed for $kind {}
            impl IntoValue for $kind {
                fn into_value(self, width: u32) -> Result<Value, String> {
                    $by(self as $wide, width)
                }
            }
        )*
    };
}

numbers!(u8: unsigned as u64, u16: unsigned as u64, u32: unsigned as u64, u64: unsigned as u64, usize: unsigned as u64,
    i8: signed as i64, i16: signed as i64, i32: signed as i64, i64: signed as i64, bool: unsigned as u64);

impl sealed::Sealed for &Value {}
impl IntoValue for &Value {
    fn into_value(self, width: u32) -> Result<Value, String> {
        if self.width() != width {
            return Err(format!("it has {} bits, the value {}", width, self.width()));
        }
        Ok(self.clone())
    }
}

impl sealed::Sealed for Value {}
impl IntoValue for Value {
    fn into_value(self, width: u32) -> Result<Value, String> {
        (&self).into_value(width)
    }
}

impl sealed::Sealed for &str {}
impl IntoValue for &str {
    fn into_value(self, width: u32) -> Result<Value, String> {
        Value::given(self, width, false).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_or_are_refused() {
        assert_eq!(15.into_value(4), Ok(Value::from_u64(15, 4)));
        assert!(16.into_value(4).is_err());
        assert_eq!((-8).into_value(4), Ok(Value::from_u64(8, 4)));
        assert!((-9).into_value(4).is_err());
        assert_eq!((-1i64).into_value(65).unwrap().bit_string(), "1".repeat(65));
        assert_eq!(u64::MAX.into_value(64), Ok(Value::from_u64(u64::MAX, 64)));
        assert_eq!(true.into_value(1), Ok(Value::from_u64(1, 1)));
        assert_eq!("4'b10x1".into_value(4).unwrap().bit_string(), "10x1");
        assert!(Value::from_u64(1, 3).into_value(4).is_err());
    }
}
