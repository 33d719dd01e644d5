//! Signals over time, packed: what changes is told once, as bytes in base64.
//!
//! All times at which anything changes are one table, as differences. A signal is a list of changes, each a number of
//! seven bits a byte, the low first: how many entries of the table since the last change (since entry 0 for the first),
//! times 4, plus for one bit its value (0, 1, x, z), else 1 if a second plane follows. Then come, for wider signals, as
//! many bytes as their bits need, the low first: a plane of values and, if so, one of bits that are unknown, where a value
//! of 0 is x and 1 is z. What is no bits is a length, then UTF-8.

use std::collections::{BTreeMap, HashMap};

use serde::Serialize;

use crate::wave::read::{ReadError, ValueKind, Waves, logic};

/// More changes than this make a page that no browser likes.
pub const MAX_CHANGES: usize = 4_000_000;

/// What is known of a signal besides its values.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct About {
    /// People read it in two's complement.
    pub signed: bool,
    /// It is a port of the top module: `in`, `out`, `inout`.
    pub port: &'static str,
    /// It is a clock.
    pub clock: bool,
    /// A tool made it up: it is there for the schematic, and not listed.
    pub hidden: bool,
    /// Its values, as bits, that have names.
    pub values: BTreeMap<String, String>,
}

/// The signals of a waveform.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Signals {
    /// The first tick.
    pub start: u64,
    /// The last tick.
    pub end: u64,
    /// The times of the table.
    pub times: String,
    /// The signals in the order of the file.
    pub signals: Vec<Signal>,
    /// The changes of those that are not another's.
    pub changes: Vec<String>,
}

/// A signal by one of its names.
#[derive(Clone, Debug, Serialize)]
pub struct Signal {
    /// The full name.
    pub name: String,
    /// How much of the name is its scopes.
    pub scope: usize,
    /// `bits`, `real`, `text` or `event`.
    pub kind: &'static str,
    /// Bits, if it is bits.
    pub width: u32,
    /// The number of its changes in the list.
    pub of: usize,
    /// Whether it is read in two's complement.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub signed: bool,
    /// `in`, `out`, `inout`, or nothing.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub port: &'static str,
    /// Whether it is a clock.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub clock: bool,
    /// Whether it is not listed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub hidden: bool,
    /// Its values, as bits, that have names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, String>,
}

/// Why there is no page.
#[derive(Debug)]
pub enum PackError {
    /// The waveform is damaged.
    Read(ReadError),
    /// It has more changes than [`MAX_CHANGES`].
    TooMany,
}

impl From<ReadError> for PackError {
    fn from(error: ReadError) -> PackError {
        PackError::Read(error)
    }
}

impl Signals {
    /// All signals of a waveform; `about` tells more of one by its full name.
    ///
    /// # Errors
    /// Values that are damaged, or too many.
    pub fn of(waves: &mut Waves, about: impl Fn(&str) -> About) -> Result<Signals, PackError> {
        let originals = waves.originals();
        let mut firsts: Vec<usize> = originals.clone();
        firsts.sort_unstable();
        firsts.dedup();
        let kinds: Vec<ValueKind> = firsts.iter().map(|&var| waves.vars()[var].kind).collect();
        let mut lists = Vec::new();
        let mut count = 0;
        for (series, kind) in waves.load_all(&firsts)?.iter().zip(kinds) {
            let list: Vec<(u64, String)> = series.changes().collect();
            count += list.len();
            if count > MAX_CHANGES {
                return Err(PackError::TooMany);
            }
            lists.push((kind, list));
        }
        let numbers: HashMap<usize, usize> = firsts.iter().enumerate().map(|(i, &var)| (var, i)).collect();
        let mut signals = Vec::new();
        for (var, original) in originals.into_iter().enumerate() {
            let of = numbers[&original];
            let var = &waves.vars()[var];
            let (kind, width) = match var.kind {
                ValueKind::Bits(width) => ("bits", width),
                ValueKind::Real => ("real", 0),
                ValueKind::Text => ("text", 0),
                ValueKind::Event => ("event", 0),
            };
            let About { signed, port, clock, hidden, values } = about(&var.name);
            let scope = var.scope().len();
            let name = var.name.clone();
            signals.push(Signal { name, scope, kind, width, of, signed, port, clock, hidden, values });
        }
        let mut times: Vec<u64> = lists.iter().flat_map(|(_, list)| list.iter().map(|(time, _)| *time)).collect();
        times.sort_unstable();
        times.dedup();
        let mut bytes = Vec::new();
        let mut before = 0;
        for &time in &times {
            number(&mut bytes, time - before);
            before = time;
        }
        let changes = lists.iter().map(|(kind, list)| base64(&packed(*kind, list, &times))).collect();
        Ok(Signals { start: waves.start(), end: waves.end(), times: base64(&bytes), signals, changes })
    }
}

fn packed(kind: ValueKind, list: &[(u64, String)], times: &[u64]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let (mut before, mut from) = (0, 0);
    for (time, value) in list {
        // the table holds every time, and times of a list grow
        from += times[from..].partition_point(|t| t < time);
        let gap = 4 * (from - before) as u64;
        before = from;
        match kind {
            ValueKind::Bits(1) => number(&mut bytes, gap + code(value.as_bytes().first().copied().unwrap_or(b'x'))),
            ValueKind::Bits(width) => {
                let codes: Vec<u64> = value.bytes().rev().map(code).collect();
                let unknown = codes.iter().any(|&c| c > 1);
                number(&mut bytes, gap + u64::from(unknown));
                let mut plane = |bit: &dyn Fn(u64) -> bool| {
                    let octets = (0..width as usize).step_by(8).map(|lo| {
                        let bits = codes.iter().skip(lo).take(8).enumerate();
                        bits.fold(0, |octet, (i, &c)| octet | u8::from(bit(c)) << i)
                    });
                    bytes.extend(octets);
                };
                plane(&|c| c & 1 == 1);
                if unknown {
                    plane(&|c| c > 1);
                }
            }
            _ => {
                number(&mut bytes, gap);
                number(&mut bytes, value.len() as u64);
                bytes.extend(value.bytes());
            }
        }
    }
    bytes
}

/// 0, 1, x is 2, z is 3.
fn code(bit: u8) -> u64 {
    u64::from(logic(bit).unwrap_or(2))
}

/// Seven bits a byte, the low first.
fn number(to: &mut Vec<u8>, mut n: u64) {
    while n >= 0x80 {
        to.push(n as u8 | 0x80);
        n >>= 7;
    }
    to.push(n as u8);
}

/// As RFC 4648 has it.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let n = chunk.iter().fold(0u32, |n, &b| n << 8 | u32::from(b)) << (8 * (3 - chunk.len()));
        for digit in 0..4 {
            let known = digit <= chunk.len();
            text.push(if known { DIGITS[(n >> (18 - 6 * digit)) as usize & 63] as char } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        let all = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|t| base64(t.as_bytes()));
        assert_eq!(all, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
    }

    /// By hand from the description above.
    #[test]
    fn bytes_of_changes() {
        let times = [0, 5, 10];
        let list = |values: &[(u64, &str)]| values.iter().map(|(t, v)| (*t, (*v).to_owned())).collect::<Vec<_>>();
        assert_eq!(packed(ValueKind::Bits(1), &list(&[(0, "x"), (10, "1")]), &times), [2, 4 * 2 + 1]);
        let wide = list(&[(5, "0100000001"), (10, "1xz0000010")]);
        // the second: value bits 9, 7 (z) and 1, unknown bits 8 and 7
        let expected = [4, 0b0000_0001, 0b01, 4 + 1, 0b1000_0010, 0b10, 0b1000_0000, 0b01];
        assert_eq!(packed(ValueKind::Bits(10), &wide, &times), expected);
        assert_eq!(packed(ValueKind::Real, &list(&[(5, "2.5")]), &times), [4, 3, b'2', b'.', b'5']);
        let mut bytes = Vec::new();
        number(&mut bytes, 300);
        assert_eq!(bytes, [0xac, 0x02]);
    }
}
