//! Values as numbers.

use std::str::FromStr;

use crate::read::ValueKind;
use crate::report::hexadecimal;

/// Up to so many bits are a decimal number where nothing else was asked for.
const DECIMAL: u32 = 16;

/// How numbers are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Hash)]
pub enum Radix {
    /// Decimal up to 16 bits, hexadecimal above.
    #[default]
    Auto,
    /// Bit by bit.
    Binary,
    /// Decimal.
    Decimal,
    /// Decimal, in two's complement.
    Signed,
    /// Hexadecimal.
    Hexadecimal,
}

impl Radix {
    /// A value as text, as short as this radix allows. Where it has no number for it, since bits are x or z, the bits
    /// themselves or hexadecimal digits.
    #[must_use]
    pub fn text(self, bits: &str, kind: ValueKind) -> String {
        let ValueKind::Bits(width) = kind else { return bits.to_owned() };
        let wide = if width > DECIMAL { Radix::Hexadecimal } else { Radix::Decimal };
        let radix = if self == Radix::Auto { wide } else { self };
        let known = bits.bytes().all(|b| matches!(b, b'0' | b'1'));
        let number = match radix {
            Radix::Decimal if known => u128::from_str_radix(bits, 2).ok().map(|n| n.to_string()),
            Radix::Signed if known => signed(bits).map(|n| n.to_string()),
            Radix::Hexadecimal => hexadecimal(bits),
            _ => None,
        };
        match number {
            Some(number) => number,
            None if width > DECIMAL && radix != Radix::Binary => hexadecimal(bits).unwrap_or_else(|| bits.to_owned()),
            None => bits.to_owned(),
        }
    }
}

/// The number that bits are in two's complement.
fn signed(bits: &str) -> Option<i128> {
    let value = i128::from_str_radix(bits, 2).ok()?;
    Some(if bits.starts_with('1') { value - (1i128 << bits.len()) } else { value })
}

impl FromStr for Radix {
    type Err = String;

    fn from_str(text: &str) -> Result<Radix, String> {
        match text {
            "auto" => Ok(Radix::Auto),
            "bin" => Ok(Radix::Binary),
            "dec" => Ok(Radix::Decimal),
            "signed" => Ok(Radix::Signed),
            "hex" => Ok(Radix::Hexadecimal),
            _ => Err(format!("`{text}` is no radix: auto, bin, dec, signed or hex")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_by_hand() {
        let text = |radix: Radix, bits: &str| radix.text(bits, ValueKind::Bits(bits.len() as u32));
        assert_eq!(text(Radix::Auto, "0101"), "5");
        assert_eq!(text(Radix::Auto, "00010010001101000101"), "12345");
        assert_eq!(text(Radix::Signed, "1011"), "-5");
        assert_eq!(text(Radix::Signed, "1000"), "-8");
        assert_eq!(text(Radix::Hexadecimal, "101111"), "2f");
        assert_eq!(text(Radix::Hexadecimal, "xxxx1111"), "xf");
        assert_eq!(text(Radix::Binary, "0101"), "0101");
        // no number: the bits, and where they are many digits that lose nothing
        assert_eq!([text(Radix::Auto, "01x1"), text(Radix::Decimal, "z1")], ["01x1", "z1"]);
        assert_eq!(text(Radix::Decimal, "zzzz0000111100001111"), "z0f0f");
        assert_eq!(text(Radix::Decimal, &"1".repeat(127)), (u128::MAX >> 1).to_string());
        assert_eq!(text(Radix::Signed, &"1".repeat(200)), "f".repeat(50));
        assert_eq!(Radix::Hexadecimal.text("2.5", ValueKind::Real), "2.5");
    }
}
