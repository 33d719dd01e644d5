//! Verilog literals in and out: `8'hff`, `4'b10x1`, `12`, `-3` (IEEE 1364-2005, 3.5.1).

use std::fmt;
use std::str::FromStr;

use super::{Logic, Value};

/// Why a text is not a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LiteralError {
    reason: String,
}

impl fmt::Display for LiteralError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl std::error::Error for LiteralError {}

fn err<T>(reason: impl Into<String>) -> Result<T, LiteralError> {
    Err(LiteralError { reason: reason.into() })
}

/// The plural ending.
fn s(n: u32) -> &'static str {
    if n == 1 { "" } else { "s" }
}

/// The widest literal that is read.
const MAX_WIDTH: u32 = 1 << 20;

impl Value {
    /// Reads a value for a net of `width` bits: a sized literal of that width or a plain number that fits
    /// (`5`, `-5` in two's complement, `0x1f`, `0b101`, or `x` and `z` for all bits).
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// use discreta::Value;
    /// assert_eq!(Value::for_width("-1", 4).unwrap().to_string(), "4'd15");
    /// assert!(Value::for_width("16", 4).unwrap_err().to_string().contains("does not fit"));
    /// ```
    ///
    /// # Errors
    /// If the text is not a literal, or does not fit the width.
    pub fn for_width(text: &str, width: u32) -> Result<Value, LiteralError> {
        let text = text.trim();
        if text.contains('\'') {
            let value: Value = text.parse()?;
            if value.width() != width {
                return err(format!("'{text}' is {} bit{} wide, not {width}", value.width(), s(value.width())));
            }
            return Ok(value);
        }
        match text {
            "x" | "X" => return Ok(Value::repeat(Logic::X, width)),
            "z" | "Z" => return Ok(Value::repeat(Logic::Z, width)),
            _ => {}
        }
        let (negative, digits) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let lower = digits.to_ascii_lowercase();
        let (base, digits) = match lower.get(..2) {
            Some("0x") => (16, &lower[2..]),
            Some("0b") => (2, &lower[2..]),
            Some("0o") => (8, &lower[2..]),
            _ => (10, &lower[..]),
        };
        let Ok(n) = u64::from_str_radix(&digits.replace('_', ""), base) else {
            return err(format!(
                "'{text}' is not a value: write a number, or a literal such as {width}'b{}",
                "x".repeat(width.min(4) as usize)
            ));
        };
        let value = if negative {
            let fits = n == 0 || width > 64 || (width > 0 && n <= 1 << (width - 1));
            if !fits || n > 1 << 63 {
                let range = if (1..=64).contains(&width) {
                    format!(" (at least {})", -1i128 << (width - 1))
                } else {
                    String::new()
                };
                return err(format!("{text} does not fit {width} bit{} in two's complement{range}", s(width)));
            }
            Value::from_i64((n as i64).wrapping_neg(), width)
        } else {
            if width < 64 && n >> width != 0 {
                return err(format!(
                    "{text} does not fit {width} bit{} (at most {})",
                    s(width),
                    super::word::mask(width)
                ));
            }
            Value::from_u64(n, width)
        };
        Ok(value)
    }
}

impl Value {
    /// Reads a value that is given to a net of `width` bits, as [`for_width`](Value::for_width) does; one that has no sign
    /// takes no negative number.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// use discreta::Value;
    /// assert_eq!(Value::given("-7", 8, true).unwrap().to_i64(), Some(-7));
    /// let told = Value::given("-7", 8, false).unwrap_err().to_string();
    /// assert_eq!(told, "-7 is negative, and this takes numbers without a sign (0 to 255)");
    /// ```
    ///
    /// # Errors
    /// If the text is not a literal, does not fit the width, or is negative where there is no sign.
    pub fn given(text: &str, width: u32, signed: bool) -> Result<Value, LiteralError> {
        let value = Value::for_width(text, width)?;
        let negative = text.trim().starts_with('-') && value.bits().any(|bit| bit == Logic::One);
        if signed || !negative {
            return Ok(value);
        }
        let most = match width {
            ..=64 => super::word::mask(width).to_string(),
            _ => format!("2^{width} - 1"),
        };
        err(format!("{} is negative, and this takes numbers without a sign (0 to {most})", text.trim()))
    }
}

/// Reads a sized Verilog literal: `<width>'<b|o|d|h><digits>`, with `_` between digits, `x`, `z` and `?` (z).
/// Missing high digits are 0, or x or z if the first digit is.
impl FromStr for Value {
    type Err = LiteralError;

    fn from_str(text: &str) -> Result<Value, LiteralError> {
        let Some((size, rest)) = text.trim().split_once('\'') else {
            return err(format!("'{text}' has no width: write it as 8'd12 or 4'b10x1"));
        };
        let width: u32 = match size.trim().replace('_', "").parse() {
            Ok(0) => return err(format!("'{text}' has width 0")),
            Ok(w) if w > MAX_WIDTH => return err(format!("'{text}' is wider than {MAX_WIDTH} bits")),
            Ok(w) => w,
            Err(_) => return err(format!("'{size}' is not a width in '{text}'")),
        };
        let rest = rest.trim_start_matches(['s', 'S']);
        let mut chars = rest.chars();
        let base = chars.next().map(|c| c.to_ascii_lowercase());
        let digits: Vec<char> = chars.filter(|&c| c != '_').map(|c| c.to_ascii_lowercase()).collect();
        if digits.is_empty() {
            return err(format!("'{text}' has no digits"));
        }
        let bits_per_digit = match base {
            Some('b') => 1,
            Some('o') => 3,
            Some('h') => 4,
            Some('d') => return decimal(text, &digits, width),
            _ => return err(format!("'{text}' needs a base: b, o, d or h after the quote")),
        };
        let mut value = Value::repeat(Logic::Zero, width);
        let mut at = 0;
        for &c in digits.iter().rev() {
            let digit = match c {
                'x' => Err(Logic::X),
                'z' | '?' => Err(Logic::Z),
                _ => match c.to_digit(1 << bits_per_digit) {
                    Some(d) => Ok(d),
                    None => return err(format!("'{c}' is not a digit of '{text}'")),
                },
            };
            for i in 0..bits_per_digit {
                let bit = match digit {
                    Err(unknown) => unknown,
                    Ok(d) if d >> i & 1 == 1 => Logic::One,
                    Ok(_) => Logic::Zero,
                };
                if at < width {
                    value.set_bit(at, bit);
                } else if bit == Logic::One || bits_per_digit == 1 {
                    return err(format!("'{text}' has more than {width} bit{}", s(width)));
                }
                at += 1;
            }
        }
        let fill = match digits[0] {
            'x' => Logic::X,
            'z' | '?' => Logic::Z,
            _ => Logic::Zero,
        };
        for i in at..width {
            value.set_bit(i, fill);
        }
        Ok(value)
    }
}

fn decimal(text: &str, digits: &[char], width: u32) -> Result<Value, LiteralError> {
    match digits {
        ['x'] => return Ok(Value::repeat(Logic::X, width)),
        ['z' | '?'] => return Ok(Value::repeat(Logic::Z, width)),
        _ => {}
    }
    let digits: String = digits.iter().collect();
    match digits.parse::<u64>() {
        Ok(n) if width >= 64 || n >> width == 0 => Ok(Value::from_u64(n, width)),
        Ok(_) => err(format!("'{text}' does not fit {width} bits")),
        Err(_) => err(format!("'{digits}' is not a decimal number of at most 64 bits in '{text}'")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(text: &str) -> String {
        text.parse::<Value>().map_or_else(|e| e.to_string(), |v| v.bit_string())
    }

    #[test]
    fn literals() {
        assert_eq!(bits("4'b10x1"), "10x1");
        assert_eq!(bits("8'hxF"), "xxxx1111");
        assert_eq!(bits("8'bx1"), "xxxxxxx1");
        assert_eq!(bits("6'o7z"), "111zzz");
        assert_eq!(bits("8'd1_0"), "00001010");
        assert_eq!(bits("3'h7"), "111");
        assert_eq!(bits("3'h8"), "'3'h8' has more than 3 bits");
        assert_eq!(bits("2'b100"), "'2'b100' has more than 2 bits");
        assert_eq!(bits("2'd4"), "'2'd4' does not fit 2 bits");
        assert_eq!(bits("4'b12"), "'2' is not a digit of '4'b12'");
        assert_eq!(bits("0'b1"), "'0'b1' has width 0");
    }

    #[test]
    fn plain_numbers_take_the_width_of_the_net() {
        assert_eq!(Value::for_width("0xff", 8).unwrap().to_u64(), Some(255));
        assert_eq!(Value::for_width("-128", 8).unwrap().to_i64(), Some(-128));
        assert!(Value::for_width("-129", 8).is_err());
        assert!(Value::for_width("256", 8).is_err());
        assert!(Value::for_width("é", 8).is_err());
        assert!(Value::for_width("9'd1", 8).unwrap_err().to_string().contains("9 bits"));
    }
}
