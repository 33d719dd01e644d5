//! The format strings of `$print` and `$check`: text with `{…}` for the arguments, as Yosys' manual describes them under
//! debugging cells.

use crate::{Logic, Value};

/// A part of a message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Piece {
    /// As it stands.
    Text(String),
    /// An argument.
    Argument(Argument),
}

/// How an argument is shown.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Argument {
    /// Its bits.
    pub width: u32,
    kind: Kind,
    justify: Justify,
    padding: char,
    columns: u32,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Justify {
    Left,
    Right,
    /// Right, with what fills up behind the sign.
    Numeric,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Integer { base: u32, upper: bool, sign: char, prefix: bool, group: bool, signed: bool },
    Letters,
    Unicode,
    Time,
}

/// Most columns of one argument.
const MOST: u32 = 1 << 16;

/// Takes a format string apart.
///
/// # Errors
/// What is wrong with it.
pub fn parse(text: &str) -> Result<Vec<Piece>, String> {
    let mut pieces = Vec::new();
    let mut plain = String::new();
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '{' | '}' if chars.peek() == Some(&c) => {
                chars.next();
                plain.push(c);
            }
            '{' => {
                if !plain.is_empty() {
                    pieces.push(Piece::Text(std::mem::take(&mut plain)));
                }
                let inside: String = chars.by_ref().take_while(|&c| c != '}').collect();
                // a brace may be what fills up
                let argument = argument(&inside).ok_or_else(|| format!("its format has `{{{inside}}}`"))?;
                pieces.push(Piece::Argument(argument));
            }
            '}' => return Err("its format has a `}` without a `{`".into()),
            c => plain.push(c),
        }
    }
    if !plain.is_empty() {
        pieces.push(Piece::Text(plain));
    }
    Ok(pieces)
}

/// `size:U`, or `size:` justification, padding, columns, base or kind, options.
fn argument(text: &str) -> Option<Argument> {
    let (width, rest) = match text.split_once(':') {
        Some((width, rest)) => (width.parse().ok()?, rest),
        None => (32, text),
    };
    let plain = |kind| Argument { width, kind, justify: Justify::Right, padding: ' ', columns: 0 };
    if rest == "U" {
        return Some(plain(Kind::Unicode));
    }
    let mut chars = rest.chars();
    let justify = match chars.next()? {
        '<' => Justify::Left,
        '>' => Justify::Right,
        '=' => Justify::Numeric,
        _ => return None,
    };
    let padding = chars.next()?;
    let rest = chars.as_str();
    let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let columns = if digits == 0 { 0 } else { rest[..digits].parse().ok().filter(|&n| n <= MOST)? };
    let mut chars = rest[digits..].chars();
    let (base, upper) = match chars.next()? {
        'b' => (2, false),
        'o' => (8, false),
        'd' => (10, false),
        'h' => (16, false),
        'H' => (16, true),
        letter => {
            let kind = match letter {
                'c' => Kind::Letters,
                't' | 'r' => Kind::Time,
                _ => return None,
            };
            return chars.next().is_none().then(|| Argument { justify, padding, columns, ..plain(kind) });
        }
    };
    let mut options = chars.as_str();
    let mut take = |wanted: &[char]| {
        let found = options.chars().next().filter(|c| wanted.contains(c));
        options = &options[usize::from(found.is_some())..];
        found
    };
    let sign = take(&['-', '+', ' ']).unwrap_or('-');
    let (prefix, group) = (take(&['#']).is_some(), take(&['_']).is_some());
    let signed = take(&['u', 's'])? == 's';
    options.is_empty().then(|| Argument {
        justify,
        padding,
        columns,
        ..plain(Kind::Integer { base, upper, sign, prefix, group, signed })
    })
}

/// The message that the pieces make of their arguments, which lie one after another, at a tick.
#[must_use]
pub fn render(pieces: &[Piece], arguments: &Value, time: u64) -> String {
    let mut text = String::new();
    let mut at = 0;
    for piece in pieces {
        match piece {
            Piece::Text(plain) => text += plain,
            Piece::Argument(argument) => {
                let mut value = Value::unknown(argument.width);
                let there = arguments.width().saturating_sub(at).min(argument.width);
                (0..there).for_each(|i| value.set_bit(i, arguments.bit(at + i)));
                at += argument.width;
                text += &argument.show(&value, time);
            }
        }
    }
    text
}

impl Argument {
    fn show(&self, value: &Value, time: u64) -> String {
        let (sign, digits) = match self.kind {
            Kind::Time => (String::new(), time.to_string()),
            Kind::Unicode => {
                let letter = value.to_u64().and_then(|n| char::from_u32(n as u32));
                (String::new(), letter.unwrap_or(char::REPLACEMENT_CHARACTER).to_string())
            }
            Kind::Letters => (String::new(), letters(value)),
            Kind::Integer { base, upper, sign, prefix, group, signed } => {
                let negative =
                    signed && value.is_known() && value.width() > 0 && value.bit(value.width() - 1) == Logic::One;
                let mut digits = if base == 10 { decimal(value, negative) } else { by_bits(value, base, negative) };
                if upper {
                    digits = digits.to_uppercase().replace('X', "x").replace('Z', "z");
                }
                if group {
                    digits = grouped(&digits, if base == 10 { 3 } else { 4 });
                }
                let mut before = match (negative, sign) {
                    (true, _) => "-".to_owned(),
                    (false, '-') => String::new(),
                    (false, c) => c.to_string(),
                };
                if prefix {
                    before += match (base, upper) {
                        (2, _) => "0b",
                        (8, _) => "0o",
                        (10, _) => "0d",
                        (_, false) => "0x",
                        (_, true) => "0X",
                    };
                }
                (before, digits)
            }
        };
        let missing = (self.columns as usize).saturating_sub(sign.chars().count() + digits.chars().count());
        let fill: String = std::iter::repeat_n(self.padding, missing).collect();
        match self.justify {
            Justify::Left => format!("{sign}{digits}{fill}"),
            Justify::Right => format!("{fill}{sign}{digits}"),
            Justify::Numeric => format!("{sign}{fill}{digits}"),
        }
    }
}

/// Eight bits a letter, the first in the highest; bytes of 0 are left out.
fn letters(value: &Value) -> String {
    let byte = |lo: u32| {
        let bits = (lo..(lo + 8).min(value.width())).filter(|&i| value.bit(i) == Logic::One);
        bits.fold(0u8, |b, i| b | 1 << (i - lo))
    };
    let bytes: Vec<u8> = (0..value.width()).step_by(8).map(byte).filter(|&b| b != 0).collect();
    String::from_utf8_lossy(&bytes.into_iter().rev().collect::<Vec<u8>>()).into_owned()
}

/// A letter for bits of which some are unknown: small if all are the same.
fn unknown(bits: &[Logic]) -> char {
    let all = |l| bits.iter().all(|&b| b == l);
    match () {
        () if all(Logic::X) => 'x',
        () if all(Logic::Z) => 'z',
        () if bits.contains(&Logic::X) => 'X',
        () => 'Z',
    }
}

/// The magnitude of a known number as words.
fn magnitude(value: &Value, negative: bool) -> Vec<u64> {
    let mut words: Vec<u64> = value.words().map(|w| w.v).collect();
    if negative {
        let mut carry = true;
        for (i, w) in words.iter_mut().enumerate() {
            let (n, c) = (!*w).overflowing_add(u64::from(carry));
            carry = c;
            *w = n & crate::value::word::word_mask(value.width(), i);
        }
    }
    words
}

fn decimal(value: &Value, negative: bool) -> String {
    if !value.is_known() {
        return unknown(&value.bits().collect::<Vec<Logic>>()).to_string();
    }
    let mut words = magnitude(value, negative);
    let mut digits = Vec::new();
    while words.iter().any(|&w| w != 0) {
        let rest = words.iter_mut().rev().fold(0u128, |rest, w| {
            let n = rest << 64 | u128::from(*w);
            *w = (n / 10) as u64;
            n % 10
        });
        digits.push(b'0' + rest as u8);
    }
    if digits.is_empty() {
        digits.push(b'0');
    }
    digits.into_iter().rev().map(char::from).collect()
}

/// Digits of some bits each, without leading zeros.
fn by_bits(value: &Value, base: u32, negative: bool) -> String {
    let mut shown = value.clone();
    if negative {
        for (i, w) in magnitude(value, true).into_iter().enumerate() {
            let lo = i as u32 * 64;
            let bit = |k: u32| if w >> k & 1 == 1 { Logic::One } else { Logic::Zero };
            (lo..value.width().min(lo + 64)).for_each(|k| shown.set_bit(k, bit(k - lo)));
        }
    }
    let size = base.trailing_zeros();
    let digit = |lo: u32| {
        let bits: Vec<Logic> = (lo..(lo + size).min(shown.width())).map(|i| shown.bit(i)).collect();
        if bits.iter().any(|b| matches!(b, Logic::X | Logic::Z)) {
            return unknown(&bits);
        }
        let n = bits.iter().rev().fold(0, |n, &b| n << 1 | u32::from(b == Logic::One));
        char::from_digit(n, 16).unwrap_or('?')
    };
    let all: String = (0..shown.width().div_ceil(size)).rev().map(|i| digit(i * size)).collect();
    match all.trim_start_matches('0') {
        "" => "0".to_owned(),
        rest => rest.to_owned(),
    }
}

fn grouped(digits: &str, size: usize) -> String {
    let letters: Vec<char> = digits.chars().collect();
    let mut text = String::new();
    for (i, c) in letters.iter().enumerate() {
        if i > 0 && (letters.len() - i).is_multiple_of(size) {
            text.push('_');
        }
        text.push(*c);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn show(format: &str, arguments: &str) -> String {
        render(&parse(format).unwrap(), &arguments.parse().unwrap(), 42)
    }

    #[test]
    fn integers() {
        assert_eq!(show("{8:> 4d-s}|", "8'hfe"), "  -2|");
        assert_eq!(show("{8:< 4d+s}|", "8'h05"), "+5  |");
        assert_eq!(show("{8:=04d-s}", "8'hfe"), "-002");
        assert_eq!(show("{12:> h#u} {4:>04bu}", "16'h3abc"), "0xabc 0011");
        assert_eq!(show("{12:> H#_u}", "12'habc"), "0XABC");
        assert_eq!(show("{20:> d_u}", "20'd1000000"), "1_000_000");
        assert_eq!(show("{70:> du}", &format!("70'b1{}", "0".repeat(69))), "590295810358705651712");
        assert_eq!(show("q={8:> 3du}!", "8'd7"), "q=  7!");
        // the first argument is the lowest
        assert_eq!(show("{8:> hu} {4:> du} {4:>04bu}", "16'bx01z_zzzz_xxxx_0z11"), "xZ z x01z");
    }

    #[test]
    fn letters_time_and_braces() {
        assert_eq!(show("{{{16:> c}}} at {0:> t}", "16'h6869"), "{hi} at 42");
        assert_eq!(show("{32:U}", "32'd8364"), "€");
        assert!(parse("{").is_err() && parse("}").is_err() && parse("{8:> q}").is_err() && parse("{8:>").is_err());
    }
}
