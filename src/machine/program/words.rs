//! A line cut into words: a letter and a number each. Spaces and tabs may stand anywhere, letters in either case.

use std::ops::Range;

use super::decimal::Decimal;
use super::expression::{self, Parameters};
use super::fault::Fault;
use crate::diag::Code;

/// A letter and its number.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Word {
    /// The letter, in upper case.
    pub letter: u8,
    /// The number.
    pub value: Decimal,
    /// Digits that were written behind the point; the most there may be, where it was computed.
    pub decimals: u32,
    /// Its bytes of the line.
    pub at: Range<usize>,
}

/// What a line has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Item {
    /// A word.
    Word(Word),
    /// `#… = value`.
    Assignment(expression::Name, Decimal),
    /// `/`: the line may be left out.
    Optional,
    /// `%`.
    Percent,
}

/// A line as it is being read.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// Begins at the start of a line.
    pub const fn new(text: &'a [u8]) -> Self {
        Cursor { text, at: 0 }
    }

    /// The byte that comes next, in upper case, past spaces and tabs.
    pub fn peek(&mut self) -> Option<u8> {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self.text.get(self.at).map(u8::to_ascii_uppercase)
    }

    /// Takes the byte that comes next.
    pub fn next(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.at += 1;
        Some(byte)
    }

    /// Takes the byte that comes next, if it is this one.
    pub fn take(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    /// Takes these letters, if they come next.
    pub fn word(&mut self, word: &str) -> bool {
        let mut ahead = self.clone();
        let there = word.bytes().all(|b| ahead.take(b));
        if there {
            *self = ahead;
        }
        there
    }

    /// Where it is.
    pub const fn at(&self) -> usize {
        self.at
    }

    /// A fault from `start` up to here, one byte at least.
    pub fn fault(&self, start: usize, message: impl Into<String>) -> Fault {
        let end = self.at.max(start + 1).min(self.text.len().max(start));
        Fault::new(Code::BadWord, start..end, message)
    }

    /// Skips a comment in parentheses, whose `(` comes next.
    fn comment(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let inner = &self.text[start + 1..];
        match inner.iter().position(|&b| b == b'(' || b == b')') {
            Some(n) if inner[n] == b')' => {
                self.at = start + n + 2;
                Ok(())
            }
            Some(n) => {
                let at = start + 1 + n;
                Err(Fault::new(Code::BadWord, at..at + 1, "a comment within a comment")
                    .help("write the inner one without parentheses"))
            }
            None => Err(Fault::new(Code::BadWord, start..self.text.len(), "this comment is not closed")
                .help("put a `)` at its end; a comment ends on its line")),
        }
    }

    /// A number as it is written: digits with a point and a sign at most, and how many digits stand behind the point.
    pub fn number(&mut self) -> Result<(Decimal, u32), Fault> {
        self.peek();
        let start = self.at;
        let negative = match self.peek() {
            Some(b'-') => self.take(b'-'),
            _ => {
                self.take(b'+');
                false
            }
        };
        let (mut digits, mut decimals, mut point, mut any) = (0_i128, 0_u32, false, 0_u32);
        while let Some(byte) = self.peek() {
            match byte {
                b'0'..=b'9' => {
                    digits = digits.saturating_mul(10).saturating_add(i128::from(byte - b'0'));
                    decimals += u32::from(point);
                    any += 1;
                }
                b'.' if !point => point = true,
                b'.' => {
                    let at = self.at;
                    return Err(Fault::new(Code::BadWord, at..at + 1, "a second point in a number")
                        .help("a number has one point at most: 1.5"));
                }
                _ => break,
            }
            self.at += 1;
        }
        if any == 0 {
            let found = match self.text.get(self.at) {
                Some(&b) if b.is_ascii_graphic() => format!("here is `{}`", char::from(b)),
                Some(_) => "here is something else".to_owned(),
                None => "here the line ends".to_owned(),
            };
            return Err(self
                .fault(start, "a number is missing")
                .label(found)
                .help("a word is a letter and its number, such as X12.5"));
        }
        let value = Decimal::scaled(if negative { -digits } else { digits }, decimals);
        let value = value.ok_or_else(|| {
            let most = (Decimal::WHOLE, Decimal::WRITTEN);
            self.fault(start, format!("a number of {any} digits is more than this machine reads"))
                .help(format!("at most {} digits may stand before the point and {} behind it", most.0, most.1))
        })?;
        if self.text[..self.at].last().is_some_and(u8::is_ascii_digit)
            && matches!(self.text.get(self.at), Some(b'e' | b'E'))
        {
            let at = self.at;
            return Err(
                Fault::new(Code::BadWord, at..at + 1, "a number with an exponent").help("write it out: 0.001 for 1e-3")
            );
        }
        Ok((value, decimals))
    }

    /// What comes next on the line; nothing at its end.
    pub fn item(&mut self, parameters: &Parameters) -> Result<Option<Item>, Fault> {
        loop {
            let Some(byte) = self.peek() else { return Ok(None) };
            let start = self.at;
            match byte {
                b'(' => self.comment()?,
                b';' => {
                    self.at = self.text.len();
                    return Ok(None);
                }
                b'%' => {
                    self.at += 1;
                    return Ok(Some(Item::Percent));
                }
                b'/' => {
                    self.at += 1;
                    return Ok(Some(Item::Optional));
                }
                b'#' => {
                    self.at += 1;
                    let name = expression::name(self, parameters)?;
                    if !self.take(b'=') {
                        return Err(self.fault(start, "a parameter stands alone").help("give it a value: #1 = 2.5"));
                    }
                    let (value, _) = expression::value(self, parameters)?;
                    return Ok(Some(Item::Assignment(name, value)));
                }
                b'A'..=b'Z' => {
                    self.at += 1;
                    if byte == b'O' {
                        self.at = self.text.len();
                        return Err(self.fault(start, "O-words (subroutines, loops) are not read").help(
                            "post-process the program without them, or expand it: every move must be written out",
                        ));
                    }
                    let (value, decimals) = expression::value(self, parameters)?;
                    return Ok(Some(Item::Word(Word { letter: byte, value, decimals, at: start..self.at })));
                }
                b')' => {
                    return Err(self.fault(start, "a `)` without its `(`").help("a comment stands between ( and )"));
                }
                _ => {
                    let text = String::from_utf8_lossy(&self.text[start..]);
                    let shown =
                        if byte.is_ascii() { char::from(self.text[start]) } else { text.chars().next().unwrap_or('?') };
                    let width = if byte.is_ascii() { 1 } else { shown.len_utf8() };
                    let at = start..(start + width).min(self.text.len());
                    return Err(Fault::new(Code::BadWord, at, format!("`{shown}` begins no word"))
                        .help("a word is a letter and a number, such as X12.5; comments stand in ( ) or behind ;"));
                }
            }
        }
    }
}
