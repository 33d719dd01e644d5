//! What Yosys' `write_json` writes, as it stands in the file: modules, ports, cells, nets, their bits.
//!
//! Strings are borrowed from the text, and what many cells share (types, ports, parameters, places) is kept once; bits
//! and connections lie in one list a module. So memory is proportional to the file and below its size. Fields that
//! are not known are skipped: newer versions add some.

mod read;

use std::borrow::Cow;
use std::collections::HashMap;

use serde::de::DeserializeSeed;

use super::fields::Object;
use crate::diag::{Code, Diagnostic, FileId, Span};
use crate::{Logic, Value};

/// A string that is kept once: an index into [`File::terms`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Term(u32);

/// Strings kept once each.
#[derive(Default, Debug)]
pub struct Terms<'a> {
    list: Vec<Cow<'a, str>>,
    numbers: HashMap<Cow<'a, str>, u32>,
}

impl<'a> Terms<'a> {
    fn add(&mut self, text: Cow<'a, str>) -> Term {
        if let Some(&number) = self.numbers.get(&text) {
            return Term(number);
        }
        let number = self.list.len() as u32;
        self.list.push(text.clone());
        self.numbers.insert(text, number);
        Term(number)
    }

    /// The string.
    #[must_use]
    pub fn text(&self, term: Term) -> &Cow<'a, str> {
        &self.list[term.0 as usize]
    }

    /// The number of a string, if the file has it.
    #[must_use]
    pub fn find(&self, text: &str) -> Option<Term> {
        self.numbers.get(text).map(|&n| Term(n))
    }
}

/// A bit: one of a net, by its number in the module, or a constant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Bit(u32);

impl Bit {
    const CONSTANTS: [Logic; 4] = [Logic::Zero, Logic::One, Logic::X, Logic::Z];
    const FIRST_CONSTANT: u32 = u32::MAX - 3;

    /// The number of a net's bit.
    #[must_use]
    pub fn number(self) -> Option<u32> {
        (self.0 < Bit::FIRST_CONSTANT).then_some(self.0)
    }

    /// The constant, if it is one.
    #[must_use]
    pub fn constant(self) -> Option<Logic> {
        (self.0 >= Bit::FIRST_CONSTANT).then(|| Bit::CONSTANTS[(self.0 - Bit::FIRST_CONSTANT) as usize])
    }
}

/// Some of the bits of a module.
#[derive(Clone, Copy, Default, Debug)]
pub struct Range {
    start: u32,
    end: u32,
}

impl Range {
    /// How many there are.
    #[must_use]
    pub fn len(self) -> u32 {
        self.end - self.start
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.start == self.end
    }
}

/// The value of a parameter or attribute.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Setting {
    /// As a string: bits, or text that ends in a space where it could be taken for bits.
    Text(Term),
    /// As a number, which `write_json -compat-int` writes.
    Number(i64),
}

/// A port of a module.
#[derive(Debug)]
pub struct Port<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// `input`, `output` or `inout`.
    pub direction: Option<Term>,
    /// Its bits, the least significant first.
    pub bits: Range,
    /// Whether the file says which bits, even if none.
    pub has_bits: bool,
    /// Two's complement.
    pub signed: bool,
    /// The lowest index.
    pub offset: i64,
    /// Whether indices rise towards the least significant bit.
    pub upto: bool,
}

/// A cell.
#[derive(Debug)]
pub struct Cell<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// What it is: a cell type of Yosys or a module.
    pub kind: Term,
    /// Whether a tool made the name up.
    pub hidden: bool,
    /// Where it comes from in the source that Yosys read.
    pub source: Option<Term>,
    /// Its path before the hierarchy was flattened, the names separated by spaces.
    pub path: Option<Term>,
    /// What of it is not as Yosys has it: the attribute `discreta`.
    pub own: Option<Term>,
    parameters: Range,
    connections: Range,
}

/// A named vector of bits.
#[derive(Debug)]
pub struct Net<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// Its bits, the least significant first.
    pub bits: Range,
    /// Whether a tool made the name up.
    pub hidden: bool,
    /// Two's complement.
    pub signed: bool,
    /// The lowest index.
    pub offset: i64,
    /// Whether indices rise towards the least significant bit.
    pub upto: bool,
    /// What its storage cells hold at the start.
    pub init: Option<Setting>,
    /// Its path before the hierarchy was flattened, the names separated by spaces.
    pub path: Option<Term>,
    /// Where it comes from in the source that Yosys read.
    pub source: Option<Term>,
    /// The values of its enumeration, bit by bit, and their names: the attributes `enum_value_…`.
    pub values: Vec<(Term, Term)>,
}

/// A memory whose ports are cells of their own.
#[derive(Debug)]
pub struct Declared<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// Bits of a word.
    pub width: u32,
    /// Words.
    pub size: u32,
    /// The address of the first.
    pub offset: i32,
}

/// A module.
#[derive(Default, Debug)]
pub struct Module<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// Whether Yosys took it for the top.
    pub top: bool,
    /// Whether only its ports are known.
    pub black_box: bool,
    /// Where it comes from in the source that Yosys read.
    pub source: Option<Term>,
    /// The element of ours that it stands for: the attribute `discreta`.
    pub own: Option<Term>,
    /// What goes with the circuit that it is the top of: how long a tick is, its parameters, its default scenario.
    pub circuit: [Option<Term>; 3],
    /// What parameters it was made with.
    pub defaults: Vec<(Term, Setting)>,
    /// Its ports.
    pub ports: Vec<Port<'a>>,
    /// Its cells.
    pub cells: Vec<Cell<'a>>,
    /// Its nets.
    pub nets: Vec<Net<'a>>,
    /// Its memories, as far as they are no cells.
    pub memories: Vec<Declared<'a>>,
    /// One more than the highest number of a bit.
    pub bit_end: u32,
    bits: Vec<Bit>,
    parameters: Vec<(Term, Setting)>,
    connections: Vec<(Term, Range)>,
}

impl<'a> Module<'a> {
    /// Some of its bits.
    #[must_use]
    pub fn bits(&self, range: Range) -> &[Bit] {
        &self.bits[range.start as usize..range.end as usize]
    }

    /// All of its bits as they are written, one after another.
    #[must_use]
    pub fn all_bits(&self) -> &[Bit] {
        &self.bits
    }

    /// The parameters of a cell.
    #[must_use]
    pub fn parameters(&self, cell: &Cell<'a>) -> &[(Term, Setting)] {
        &self.parameters[cell.parameters.start as usize..cell.parameters.end as usize]
    }

    /// What the ports of a cell are connected to.
    #[must_use]
    pub fn connections(&self, cell: &Cell<'a>) -> &[(Term, Range)] {
        &self.connections[cell.connections.start as usize..cell.connections.end as usize]
    }
}

/// A file.
#[derive(Default, Debug)]
pub struct File<'a> {
    /// The version of Yosys that wrote it.
    pub creator: Option<Cow<'a, str>>,
    /// The modules in their order.
    pub modules: Vec<Module<'a>>,
    /// The strings that are kept once.
    pub terms: Terms<'a>,
}

impl<'a> File<'a> {
    /// Reads a text.
    ///
    /// # Errors
    /// Where it is not JSON, or a field is of another type than Yosys gives it.
    pub fn parse(text: &'a str, source: FileId) -> Result<File<'a>, Diagnostic> {
        let mut file = File::default();
        let mut json = serde_json::Deserializer::from_str(text);
        let read = Object(&mut file).deserialize(&mut json).and_then(|()| json.end());
        match read {
            Ok(()) => Ok(file),
            Err(error) => Err(fault(&error, text, source)),
        }
    }

    /// What a parameter or attribute says as bits; `None` if it is text.
    #[must_use]
    pub fn value(&self, setting: Setting) -> Option<Value> {
        match setting {
            Setting::Number(n) => Some(Value::from_i64(n, 32.max(65 - n.unsigned_abs().leading_zeros()))),
            Setting::Text(term) => {
                let text = self.terms.text(term);
                let width = u32::try_from(text.len()).ok()?;
                let mut value = Value::repeat(Logic::Zero, width);
                for (i, c) in text.bytes().rev().enumerate() {
                    let bit = match c {
                        b'0' => Logic::Zero,
                        b'1' => Logic::One,
                        b'z' => Logic::Z,
                        // what does not matter, and marks
                        b'x' | b'-' | b'm' => Logic::X,
                        _ => return None,
                    };
                    value.set_bit(i as u32, bit);
                }
                Some(value)
            }
        }
    }

    /// What a parameter or attribute says as text; bits are eight to a letter.
    #[must_use]
    pub fn string(&self, setting: Setting) -> Option<Cow<'_, str>> {
        if let Some(value) = self.value(setting) {
            let bytes = (0..value.width()).step_by(8).map(|lo| {
                (lo..(lo + 8).min(value.width()))
                    .filter(|&i| value.bit(i) == Logic::One)
                    .fold(0, |b, i| b | 1 << (i - lo))
            });
            let bytes: Vec<u8> = bytes.filter(|&b: &u8| b != 0).collect();
            return String::from_utf8(bytes.into_iter().rev().collect()).ok().map(Cow::Owned);
        }
        let Setting::Text(term) = setting else { return None };
        let text: &str = self.terms.text(term);
        let letters = text.trim_end_matches(' ');
        // a space keeps it from being taken for bits
        let guarded = letters.len() < text.len() && letters.bytes().all(|b| b"01xz".contains(&b));
        Some(Cow::Borrowed(if guarded { &text[..text.len() - 1] } else { text }))
    }
}

/// Where a string stands in the text that it was read from; nowhere if it had escapes and was copied.
#[must_use]
pub fn place(text: &str, source: FileId, part: &str) -> Option<Span> {
    let start = (part.as_ptr() as usize).checked_sub(text.as_ptr() as usize)?;
    (start + part.len() <= text.len()).then(|| Span::new(source, start as u32, (start + part.len()) as u32))
}

fn fault(error: &serde_json::Error, text: &str, source: FileId) -> Diagnostic {
    let line_start = |line: usize| match line {
        0 | 1 => 0,
        _ => text.bytes().enumerate().filter(|b| b.1 == b'\n').nth(line - 2).map_or(text.len(), |b| b.0 + 1),
    };
    let mut at = (line_start(error.line()) + error.column().saturating_sub(1)).min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    let end = at + text[at..].chars().next().map_or(0, char::len_utf8);
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |m| m.0);
    let (code, what) = match error.classify() {
        serde_json::error::Category::Data => (Code::WrongType, "the file is not what Yosys writes"),
        serde_json::error::Category::Eof => (Code::JsonSyntax, "the file ends too early"),
        _ => (Code::JsonSyntax, "the file is not JSON"),
    };
    let fault = Diagnostic::new(code, format!("{what}: {message}"));
    fault.at(Span::new(source, at as u32, end as u32), "found here").help("write it again: `write_json FILE`")
}
