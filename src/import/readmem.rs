//! Contents of memories as `$readmemh` reads them (IEEE 1364-2005, 17.2.8): numbers in hex with x, z and `_`, addresses
//! behind `@`, comments of both kinds.

use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Span};
use crate::{Logic, Value};

/// The memory that is to be filled.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Bits of a word.
    pub width: u32,
    /// Words.
    pub size: u32,
    /// The address of the first.
    pub offset: i32,
}

/// Faults that are told of one file.
const TOLD: usize = 20;

struct Reader<'t> {
    text: &'t str,
    file: FileId,
    shape: Shape,
    at: usize,
    faults: Vec<Diagnostic>,
}

/// Reads a text; calls `put` with each word's place, counted from 0, and value. Words that the text does not have are
/// left alone. Every fault is told, up to a number.
pub fn read(text: &str, file: FileId, shape: Shape, diagnostics: &mut Diagnostics, mut put: impl FnMut(u32, &Value)) {
    let mut reader = Reader { text, file, shape, at: 0, faults: Vec::new() };
    let (first, end) = (i128::from(shape.offset), i128::from(shape.offset) + i128::from(shape.size));
    let mut address = first;
    // so that what follows an address outside is not complained of word by word
    let mut outside = false;
    while let Some((start, token)) = reader.token() {
        if reader.faults.len() >= TOLD {
            let fault = reader.faults.pop().map(|f| f.note("there may be more; reading stopped here"));
            reader.faults.extend(fault);
            break;
        }
        if let Some(digits) = token.strip_prefix('@') {
            match address_of(digits) {
                Some(to) => {
                    (address, outside) = (to, !(first..end).contains(&to));
                    if outside {
                        let range = format!("its addresses are {first:#x} to {:#x}", end - 1);
                        reader.fault(start, token, &format!("the memory has no address {to:#x}"), &range);
                    }
                }
                None => reader.fault(start, token, "this is no address", "write @ and hex digits, as in @1f0"),
            }
            continue;
        }
        match reader.word(token) {
            Err(message) => reader.fault(start, token, &message, ""),
            Ok(_) if outside => {}
            Ok(_) if address >= end => {
                outside = true;
                let words = format!("the memory has {} words of {} bits", shape.size, shape.width);
                reader.fault(start, token, "there are more words than the memory has", &words);
            }
            Ok(value) => put((address - first) as u32, &value),
        }
        address += 1;
    }
    diagnostics.extend(reader.faults);
}

fn address_of(digits: &str) -> Option<i128> {
    let digits = digits.replace('_', "");
    u64::from_str_radix(&digits, 16).ok().filter(|_| !digits.starts_with('+')).map(i128::from)
}

impl<'t> Reader<'t> {
    fn fault(&mut self, start: usize, token: &str, message: &str, label: &str) {
        let span = Span::new(self.file, start as u32, (start + token.len()) as u32);
        self.faults.push(Diagnostic::new(Code::BadContents, message).at(span, label));
    }

    /// The next word or address, and where it begins.
    fn token(&mut self) -> Option<(usize, &'t str)> {
        loop {
            let rest = self.text[self.at..].trim_start_matches(|c: char| c.is_ascii_whitespace() || c == '\x0b');
            self.at = self.text.len() - rest.len();
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if let Some(comment) = rest.strip_prefix("/*") {
                match comment.find("*/") {
                    Some(end) => self.at += end + 4,
                    None => {
                        self.fault(self.at, "/*", "this comment has no end", "it begins here");
                        self.at = self.text.len();
                    }
                }
            } else if rest.is_empty() {
                return None;
            } else {
                let ends = |c: char| c.is_ascii_whitespace() || c == '\x0b';
                let end = rest.find(ends).unwrap_or(rest.len());
                let end = ["//", "/*"].iter().filter_map(|c| rest[..end].find(c)).min().unwrap_or(end);
                let start = self.at;
                self.at += end;
                return Some((start, &rest[..end]));
            }
        }
    }

    fn word(&self, token: &str) -> Result<Value, String> {
        let width = self.shape.width;
        let mut value = Value::from_u64(0, width);
        let mut lo = 0;
        let mut digits = 0;
        for c in token.chars().rev().filter(|&c| c != '_') {
            let bit: &dyn Fn(u32) -> Logic = match c {
                'x' | 'X' => &|_| Logic::X,
                'z' | 'Z' | '?' => &|_| Logic::Z,
                _ => {
                    let digit = c.to_digit(16).ok_or_else(|| format!("`{}` is no hex digit", c.escape_debug()))?;
                    &move |i| if digit >> i & 1 == 1 { Logic::One } else { Logic::Zero }
                }
            };
            for i in 0..4 {
                match bit(i) {
                    bit if lo + i < width => value.set_bit(lo + i, bit),
                    Logic::Zero => {}
                    // a digit of which the word has some bits
                    Logic::X | Logic::Z if lo < width => {}
                    _ => return Err(format!("it does not fit into the {width} bits of a word")),
                }
            }
            (lo, digits) = (lo.saturating_add(4), digits + 1);
        }
        if digits == 0 { Err("this is no number".into()) } else { Ok(value) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Sources;

    fn contents(text: &str, width: u32, size: u32, offset: i32) -> Result<String, String> {
        let mut sources = Sources::new();
        let file = sources.add("m.hex", text.to_owned());
        let mut all = vec!["-".to_owned(); size as usize];
        let mut diagnostics = Diagnostics::new();
        read(sources.text(file), file, Shape { width, size, offset }, &mut diagnostics, |i, value| {
            all[i as usize] = value.bit_string();
        });
        if diagnostics.has_errors() {
            let told = diagnostics.iter().map(|d| {
                let span = d.place().unwrap();
                format!("{}: {}", sources.slice(span), d.message)
            });
            return Err(told.collect::<Vec<_>>().join("; "));
        }
        Ok(all.join(" "))
    }

    /// What Icarus Verilog 11 reads from the same text, but for words that are too wide, which it cuts.
    #[test]
    fn words_addresses_and_comments() {
        let text = "x\n_02\nzz 0ff @5 a // c\n/* q\n*/ 7";
        assert_eq!(contents(text, 8, 8, 0), Ok("0000xxxx 00000010 zzzzzzzz 11111111 - 00001010 00000111 -".into()));
        assert_eq!(contents("x z0 1", 6, 4, 2), Ok("00xxxx zz0000 000001 -".into()));
        assert_eq!(contents("@3 1//a\n@2 /**/2/* * / */@4 3", 4, 3, 2), Ok("0010 0001 0011".into()));
        assert_eq!(contents("", 4, 1, 0), Ok("-".into()));
        assert_eq!(contents("fedcba9876543210F", 68, 1, 0), Ok(format!("{:068b}", 0x000f_edcb_a987_6543_210f_u128)));
    }

    #[test]
    fn faults_are_told_together() {
        assert_eq!(
            contents("1 g 20 @", 4, 9, 0).unwrap_err(),
            "g: `g` is no hex digit; 20: it does not fit into the 4 bits of a word; @: this is no address"
        );
        assert_eq!(contents("1 2 3 4", 4, 2, 0).unwrap_err(), "3: there are more words than the memory has");
        assert_eq!(
            contents("@9 1 2 @1 3 @-1", 4, 2, 0).unwrap_err(),
            "@9: the memory has no address 0x9; @-1: this is no address"
        );
        assert_eq!(contents("@1 1", 4, 2, 2).unwrap_err(), "@1: the memory has no address 0x1");
        assert_eq!(contents("1 /* 2", 4, 2, 2).unwrap_err(), "/*: this comment has no end");
        assert_eq!(contents("_ é", 4, 2, 2).unwrap_err(), "_: this is no number; é: `é` is no hex digit");
        assert_eq!(contents(&"q ".repeat(1000), 4, 2, 2).unwrap_err().matches(';').count(), TOLD - 1);
    }
}
