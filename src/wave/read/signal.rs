//! What a variable does over time, as it is kept in memory: its changes one behind the other, packed.
//!
//! A change is a number of seven bits a byte, the lowest first: how many entries of the table of times lie between it and
//! the last one, and in the low bits what follows. For one bit these two bits are its value; for a vector one of them says
//! whether a second plane follows the first. Values are four-valued whatever the file has: [`logic`] is the one place that
//! says what the nine values of VHDL mean.

use std::fmt;

use super::ValueKind;
use crate::value::Word;
use crate::value::word::words;

/// What a value of a file means to us: bit 0 is the value plane, bit 1 the unknown plane, as in [`Word`].
///
/// Weak values are as strong as others (`L` is 0, `H` is 1); what is neither 0, 1 nor z is x (`U`, `W`, `-`, and `?` of
/// some simulators). None for what is no value.
#[must_use]
pub const fn logic(byte: u8) -> Option<u8> {
    match byte {
        b'0' | b'l' | b'L' => Some(0),
        b'1' | b'h' | b'H' => Some(1),
        b'x' | b'X' | b'u' | b'U' | b'w' | b'W' | b'-' | b'?' => Some(2),
        b'z' | b'Z' => Some(3),
        _ => None,
    }
}

/// The changes of one variable. An equal value that follows is none.
#[derive(Clone, Debug)]
pub struct Signal {
    kind: ValueKind,
    bytes: Vec<u8>,
    /// The entry of the table of times at which it last changed.
    now: u64,
    /// Where the last value begins in `bytes`; for one bit the value itself.
    last: usize,
    /// Whether the last value has two planes.
    unknown: bool,
    count: usize,
}

impl Signal {
    /// A variable that does nothing.
    pub fn new(kind: ValueKind) -> Signal {
        Signal { kind, bytes: Vec::new(), now: 0, last: 0, unknown: false, count: 0 }
    }

    /// What its values are.
    pub fn kind(&self) -> ValueKind {
        self.kind
    }

    /// How many changes it has.
    pub fn len(&self) -> usize {
        self.count
    }

    fn gap(&mut self, at: u64, shift: u32, low: u64) {
        let gap = at - self.now;
        self.now = at;
        self.count += 1;
        // a gap of 62 bits or more would be a table of times that no memory holds
        number(&mut self.bytes, gap << shift | low);
    }

    /// One bit changes at an entry of the table of times, which is none before the last.
    pub fn bit(&mut self, at: u64, code: u8) {
        if self.count == 0 || self.last != usize::from(code) {
            self.last = usize::from(code);
            self.gap(at, 2, u64::from(code));
        }
    }

    /// A vector changes; `code` gives each of its bits, the least significant first.
    pub fn bits(&mut self, at: u64, width: u32, code: impl Fn(usize) -> u8) {
        if width == 1 {
            return self.bit(at, code(0));
        }
        let width = width as usize;
        let unknown = (0..width).any(|i| code(i) > 1);
        let plane = |to: &mut Vec<u8>, plane: u8| {
            for low in (0..width).step_by(8) {
                let octet = (low..width.min(low + 8)).rev().fold(0, |byte, i| byte << 1 | code(i) >> plane & 1);
                to.push(octet);
            }
        };
        self.put(at, unknown, |to| {
            plane(to, 0);
            if unknown {
                plane(to, 1);
            }
        });
    }

    /// The same from words.
    pub fn words(&mut self, at: u64, width: u32, value: &[Word]) {
        let code = |i: usize| {
            let (word, shift) = (value[i / 64], i % 64);
            (word.v >> shift & 1 | (word.u >> shift & 1) << 1) as u8
        };
        self.bits(at, width, code);
    }

    /// Adds the value that `write` appends, unless the last is the same.
    fn put(&mut self, at: u64, unknown: bool, write: impl FnOnce(&mut Vec<u8>)) {
        let (now, from, count) = (self.now, self.bytes.len(), self.count);
        self.gap(at, 1, u64::from(unknown));
        let start = self.bytes.len();
        write(&mut self.bytes);
        let before = &self.bytes[self.last..from];
        if count > 0 && self.unknown == unknown && *before == self.bytes[start..] {
            self.bytes.truncate(from);
            (self.now, self.count) = (now, count);
        } else {
            (self.last, self.unknown) = (start, unknown);
        }
    }

    /// A real number changes.
    pub fn real(&mut self, at: u64, value: f64) {
        self.put(at, false, |to| to.extend(value.to_le_bytes()));
    }

    /// A text changes.
    pub fn text(&mut self, at: u64, value: &str) {
        self.put(at, false, |to| {
            number(to, value.len() as u64);
            to.extend(value.as_bytes());
        });
    }

    /// An event happens.
    pub fn event(&mut self, at: u64) {
        self.gap(at, 0, 0);
    }

    /// All changes, each with its entry in the table of times.
    pub fn all(&self) -> All<'_> {
        All { kind: self.kind, bytes: &self.bytes, at: 0 }
    }

    /// Each entry of the table of times at which it changes, with the value that it has when that time is over.
    pub fn changes(&self) -> impl Iterator<Item = (u64, Value<'_>)> {
        let mut all = self.all().peekable();
        std::iter::from_fn(move || {
            let mut change = all.next()?;
            while let Some(later) = all.next_if(|(at, _)| *at == change.0) {
                change = later;
            }
            Some(change)
        })
    }
}

/// See [`Signal::all`].
#[derive(Clone, Debug)]
pub struct All<'a> {
    kind: ValueKind,
    bytes: &'a [u8],
    at: u64,
}

impl<'a> All<'a> {
    fn take(&mut self, n: usize) -> &'a [u8] {
        let (taken, rest) = self.bytes.split_at(n);
        self.bytes = rest;
        taken
    }

    fn number(&mut self) -> u64 {
        let mut number = 0;
        let mut shift = 0;
        loop {
            let byte = self.take(1)[0];
            number |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                return number;
            }
        }
    }
}

impl<'a> Iterator for All<'a> {
    type Item = (u64, Value<'a>);

    fn next(&mut self) -> Option<(u64, Value<'a>)> {
        const BIT: [&[u8]; 2] = [&[0], &[1]];
        if self.bytes.is_empty() {
            return None;
        }
        let code = self.number();
        let (gap, value) = match self.kind {
            ValueKind::Bits(1) => {
                let unknown: &[u8] = if code & 2 == 0 { &[] } else { BIT[1] };
                (code >> 2, Value::Bits(Bits { width: 1, value: BIT[(code & 1) as usize], unknown }))
            }
            ValueKind::Bits(width) => {
                let octets = width.div_ceil(8) as usize;
                let value = self.take(octets);
                let unknown = if code & 1 == 1 { self.take(octets) } else { &[] };
                (code >> 1, Value::Bits(Bits { width, value, unknown }))
            }
            ValueKind::Real => {
                let bytes = self.take(8);
                (code >> 1, Value::Real(f64::from_le_bytes(*bytes.first_chunk().expect("eight were taken"))))
            }
            ValueKind::Text => {
                let length = self.number() as usize;
                (code >> 1, Value::Text(std::str::from_utf8(self.take(length)).unwrap_or_default()))
            }
            ValueKind::Event => (code, Value::Event),
        };
        self.at += gap;
        Some((self.at, value))
    }
}

/// A value of a variable.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Value<'a> {
    /// Bits.
    Bits(Bits<'a>),
    /// A number.
    Real(f64),
    /// A text.
    Text(&'a str),
    /// It happens.
    Event,
}

/// The bits of a variable.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Bits<'a> {
    width: u32,
    /// Eight bits a byte, the least significant first.
    value: &'a [u8],
    /// Which of them are x or z; empty if none is.
    unknown: &'a [u8],
}

impl Bits<'_> {
    /// A bit as [`logic`] has it.
    fn code(&self, i: usize) -> u8 {
        let bit = |plane: &[u8]| plane.get(i / 8).map_or(0, |octet| octet >> (i % 8) & 1);
        bit(self.value) | bit(self.unknown) << 1
    }

    /// Whether so many of the lowest bits are x.
    pub(crate) fn is_x(&self, width: u32) -> bool {
        (0..self.width.min(width) as usize).all(|i| self.code(i) == 2)
    }

    /// Whether the lowest bits, as many as both have, are the same; `loose` has x here agree with anything.
    pub(crate) fn agrees(&self, other: &Bits<'_>, loose: bool) -> bool {
        let same = |i: usize| self.code(i) == other.code(i) || loose && self.code(i) == 2;
        (0..self.width.min(other.width) as usize).all(same)
    }

    /// A bit as a word of one.
    #[must_use]
    pub fn bit(&self, i: u32) -> Word {
        let code = u64::from(self.code(i as usize));
        Word { v: code & 1, u: code >> 1 }
    }

    /// Writes `width` of them over those of a vector from bit `at` up, the least significant first, or all,
    /// `reversed`, the most significant first.
    pub fn write(&self, to: &mut [Word], at: u32, width: u32, reversed: bool) {
        for i in 0..width.min(self.width) {
            let Word { v, u } = self.bit(if reversed { self.width - 1 - i } else { i });
            let at = at + i;
            let (word, shift) = (&mut to[at as usize / 64], at % 64);
            word.v = word.v & !(1 << shift) | v << shift;
            word.u = word.u & !(1 << shift) | u << shift;
        }
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bits(bits) => {
                let text = (0..bits.width as usize).rev().map(|i| b"01xz"[bits.code(i) as usize] as char);
                f.write_str(&text.collect::<String>())
            }
            Value::Real(value) => write!(f, "{value}"),
            Value::Text(text) => f.write_str(text),
            Value::Event => Ok(()),
        }
    }
}

/// Vectors joined to one, given the most significant first, each with its width.
pub fn joined(parts: &[(&Signal, u32)]) -> Signal {
    let width: u32 = parts.iter().map(|(_, width)| width).sum();
    let mut signal = Signal::new(ValueKind::Bits(width));
    let mut value = vec![Word::x(u64::MAX); words(width)];
    let mut changes = Vec::new();
    let mut low = width;
    for (signal, width) in parts {
        low -= width;
        changes.extend(signal.changes().map(|(at, value)| (at, low, *width, value)));
    }
    changes.sort_by_key(|(at, ..)| *at);
    for at in changes.chunk_by(|a, b| a.0 == b.0) {
        for (_, low, width, part) in at {
            if let Value::Bits(bits) = part {
                bits.write(&mut value, *low, *width, false);
            }
        }
        signal.words(at[0].0, width, &value);
    }
    signal
}

/// Seven bits a byte, the lowest first.
fn number(to: &mut Vec<u8>, mut n: u64) {
    while n > 0x7f {
        to.push(n as u8 | 0x80);
        n >>= 7;
    }
    to.push(n as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// IEEE 1164's nine values, and what IEEE 1364 has.
    #[test]
    fn nine_values_are_four() {
        let means =
            |bytes: &[u8]| bytes.iter().map(|&b| logic(b).map(|code| b"01xz"[code as usize])).collect::<Vec<_>>();
        assert_eq!(
            means(b"0L1HlhZz"),
            b"00110 1zz".iter().filter(|b| **b != b' ').map(|b| Some(*b)).collect::<Vec<_>>()
        );
        assert_eq!(means(b"UuXxWw-?"), [Some(b'x'); 8]);
        assert_eq!(means(b"2k _b"), [None; 5]);
    }

    fn text(signal: &Signal) -> Vec<(u64, String)> {
        signal.changes().map(|(at, value)| (at, value.to_string())).collect()
    }

    #[test]
    fn what_is_put_in_comes_out() {
        for width in [1, 2, 7, 8, 9, 63, 64, 65, 127, 128, 129, 65_535] {
            let mut signal = Signal::new(ValueKind::Bits(width));
            let mut expected = Vec::new();
            for (n, at) in [0, 0, 1, 2, 300, 301, 1 << 40].into_iter().enumerate() {
                let code = |i: usize| if n % 2 == 0 { (i * (n + 3) % 7 % 2) as u8 } else { ((i + n) % 4) as u8 };
                signal.bits(at, width, code);
                let value: String = (0..width as usize).rev().map(|i| ['0', '1', 'x', 'z'][code(i) as usize]).collect();
                if expected.last().is_none_or(|(_, last)| *last != value) {
                    if expected.last().is_some_and(|(last, _)| *last == at) {
                        expected.pop();
                    }
                    expected.push((at, value));
                }
            }
            assert_eq!(text(&signal), expected, "{width}");
        }
    }

    #[test]
    fn other_kinds() {
        let mut real = Signal::new(ValueKind::Real);
        [(0, 1.5), (1, 1.5), (2, -0.25)].into_iter().for_each(|(at, value)| real.real(at, value));
        assert_eq!(text(&real), [(0, "1.5".into()), (2, "-0.25".into())]);
        let mut words = Signal::new(ValueKind::Text);
        [(0, ""), (1, "é"), (1, "b"), (9, "b")].into_iter().for_each(|(at, value)| words.text(at, value));
        assert_eq!(text(&words), [(0, "".into()), (1, "b".into())]);
        let mut event = Signal::new(ValueKind::Event);
        [3, 3, 4].into_iter().for_each(|at| event.event(at));
        assert_eq!((event.len(), event.changes().map(|(at, _)| at).collect::<Vec<_>>()), (3, vec![3, 4]));
    }

    #[test]
    fn parts_are_joined() {
        let (mut high, mut low) = (Signal::new(ValueKind::Bits(1)), Signal::new(ValueKind::Bits(3)));
        high.bit(2, 1);
        low.bits(1, 3, |i| i as u8);
        low.bits(2, 3, |_| 0);
        assert_eq!(text(&joined(&[(&high, 1), (&low, 3)])), [(1, "xx10".into()), (2, "1000".into())]);
    }
}
