//! What is wrong with a line of a program, before it is known which file the line is of.

use std::ops::Range;

use crate::diag::{Code, Diagnostic, Sources, Span};

/// A fault at a place of one line.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Fault {
    /// What kind of fault it is.
    pub code: Code,
    /// What is wrong, in one line.
    pub message: String,
    /// Bytes of the line, from 0.
    pub at: Range<usize>,
    /// A few words for the place; may be empty.
    pub label: String,
    /// What to do.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at these bytes of the line.
    pub fn new(code: Code, at: Range<usize>, message: impl Into<String>) -> Fault {
        Fault { code, message: message.into(), at, label: String::new(), help: None }
    }

    /// A few words for the place.
    #[must_use]
    pub fn label(self, text: impl Into<String>) -> Fault {
        Fault { label: text.into(), ..self }
    }

    /// What to do.
    #[must_use]
    pub fn help(self, text: impl Into<String>) -> Fault {
        Fault { help: Some(text.into()), ..self }
    }

    /// The fault in line `number` of the file `name`; the line goes to `sources`.
    #[must_use]
    pub fn locate(self, sources: &mut Sources, name: &str, number: u64, line: &[u8]) -> Diagnostic {
        let file = sources.add_excerpt(name, readable(line), usize::try_from(number).unwrap_or(usize::MAX));
        let offset = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        let span = Span::new(file, offset(self.at.start), offset(self.at.end));
        let fault = Diagnostic::new(self.code, self.message).at(span, self.label);
        match self.help {
            Some(help) => fault.help(help),
            None => fault,
        }
    }
}

/// The line as text, byte for byte where it is not UTF-8.
#[must_use]
pub fn readable(line: &[u8]) -> String {
    match std::str::from_utf8(line) {
        Ok(text) => text.to_owned(),
        Err(_) => line.iter().map(|&b| if b.is_ascii() { char::from(b) } else { '?' }).collect(),
    }
}
