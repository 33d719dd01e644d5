//! A part program: text in, canonical moves out, each with its place.
//!
//! The language is that of RS274/NGC as LinuxCNC reads it, cut to what moves three axes; docs/machine.md lists its words.
//! A program of any length is read in bounded memory, line by line; every fault names its line and column, and nothing
//! that is not understood is skipped.

mod arc;
mod block;
mod canon;
mod decimal;
mod expression;
mod fault;
mod lines;
mod modes;
mod words;

use std::collections::BTreeMap;
use std::io::BufRead;

pub(in crate::machine) use crate::diag::Code;
pub use arc::{Arc, Tolerance};
pub use canon::{Canon, Feed, Move, Path, Plane, Units};
pub use decimal::Decimal;
pub use fault::{Fault, readable};
pub use lines::LONGEST;

use self::block::Block;
use self::expression::Parameters;
use self::lines::{Broken, Lines};
use self::modes::Modes;
use crate::diag::{Diagnostic, Diagnostics, Severity, Sources};

/// After so many errors reading stops.
const MOST_ERRORS: usize = 100;

/// How a program is read.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Options {
    /// Lines that begin with `/` are left out.
    pub skip_optional: bool,
    /// Which radii of an arc are too different.
    pub tolerance: Tolerance,
}

/// A line as others see it.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// Its number, from 1.
    pub number: u64,
    /// Its text.
    pub text: &'a [u8],
    /// The bytes of the words that make it move: the first, and the one behind the last.
    pub place: (usize, usize),
    /// Bytes of the program up to here.
    pub bytes: u64,
}

impl Line<'_> {
    /// The place of the words that make it move.
    #[must_use]
    pub const fn at(&self) -> std::ops::Range<usize> {
        self.place.0..self.place.1
    }
}

/// Why reading goes no further.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Refusal {
    /// This move cannot be made; reading goes on for more faults.
    Fault(Fault),
    /// The user has interrupted.
    Stop,
}

impl From<Fault> for Refusal {
    fn from(fault: Fault) -> Refusal {
        Refusal::Fault(fault)
    }
}

/// What a program has.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    /// Lines.
    pub lines: u64,
    /// Lines with at least a word.
    pub blocks: u64,
    /// Lines with `/` that were left out.
    pub skipped: u64,
    /// M codes, which are not simulated.
    pub recorded: u64,
}

/// The faults of a program, with the lines that they are in.
#[derive(Debug, Default)]
pub struct Faults {
    /// The lines.
    pub sources: Sources,
    /// The faults, in their order.
    pub diagnostics: Diagnostics,
    /// The first warning of each kind, and how many more there are.
    warnings: BTreeMap<String, (usize, u64)>,
    first: Vec<Diagnostic>,
}

impl Faults {
    /// One more, in this line.
    pub fn push(&mut self, name: &str, line: Line<'_>, fault: Fault) {
        if fault.code.severity() == Severity::Warning {
            if let Some((_, more)) = self.warnings.get_mut(&fault.message) {
                *more += 1;
                return;
            }
            self.warnings.insert(fault.message.clone(), (self.first.len(), 0));
            self.first.push(fault.locate(&mut self.sources, name, line.number, line.text));
            return;
        }
        let fault = fault.locate(&mut self.sources, name, line.number, line.text);
        self.diagnostics.push(fault);
    }

    /// Puts all into their order.
    fn finish(&mut self) {
        let mut first: Vec<Option<Diagnostic>> = self.first.drain(..).map(Some).collect();
        for (index, more) in std::mem::take(&mut self.warnings).into_values() {
            let Some(fault) = first[index].take() else { continue };
            let more = match more {
                0 => None,
                1 => Some("so is one more block".to_owned()),
                n => Some(format!("so are {n} more blocks")),
            };
            self.diagnostics.push(match more {
                Some(more) => fault.note(more),
                None => fault,
            });
        }
        self.diagnostics.sort();
    }
}

/// Reads a program to its end. What happens goes to `each`, which may refuse it; `name` is how the file is called.
///
/// # Errors
/// The file cannot be read. What is wrong with the program goes to `faults`, all of it, up to 100 errors.
pub fn read<R: BufRead>(
    from: R,
    name: &str,
    options: Options,
    faults: &mut Faults,
    mut each: impl FnMut(Line<'_>, &Canon) -> Result<(), Refusal>,
) -> std::io::Result<Summary> {
    let mut lines = Lines::new(from);
    let mut modes = Modes::new(options.tolerance);
    let (mut block, mut parameters) = (Block::default(), Parameters::default());
    let (mut happens, mut warnings) = (Vec::new(), Vec::new());
    let mut summary = Summary::default();
    let mut begun = false;
    let mut ended: Option<&str> = None;
    let mut left = 0_u64;
    loop {
        match lines.advance() {
            Ok(true) => {}
            Ok(false) => break,
            Err(Broken::Io(error)) => return Err(error),
            Err(broken) => {
                let line =
                    Line { number: lines.number().max(1), text: lines.text(), place: (0, 0), bytes: lines.bytes() };
                faults.push(name, line, unreadable(&broken));
                break;
            }
        }
        summary.lines = lines.number();
        let line = Line { number: lines.number(), text: lines.text(), place: (0, 0), bytes: lines.bytes() };
        if let Some(end) = ended {
            let blank = line.text.iter().position(|b| !b.is_ascii_whitespace());
            if let Some(at) = blank.filter(|&at| !b"%(;".contains(&line.text[at])) {
                left += 1;
                if left == 1 {
                    let message = format!("what follows {end} is not read");
                    let fault = Fault::new(Code::DoubtfulBlock, at..line.text.len(), message);
                    faults.push(name, line, fault.help("take the rest out, or the end that comes before it"));
                }
            }
            continue;
        }
        if let Err(fault) = block.read(line.text, &parameters) {
            modes.lose();
            faults.push(name, line, fault);
            if faults.diagnostics.errors() >= MOST_ERRORS {
                break;
            }
            continue;
        }
        if block.percent {
            if begun || summary.blocks > 0 {
                ended = Some("the %");
            }
            begun = true;
            continue;
        }
        if block.optional && options.skip_optional {
            summary.skipped += 1;
            continue;
        }
        summary.blocks += u64::from(block.any);
        happens.clear();
        let lost = modes.is_lost();
        let done = modes.execute(&block, &mut happens, &mut warnings);
        let place = block.place();
        let line = Line { place: (place.start, place.end), ..line };
        for fault in warnings.drain(..) {
            faults.push(name, line, fault);
        }
        for canon in &happens {
            summary.recorded += u64::from(matches!(canon, Canon::Recorded(_)));
            match each(line, canon) {
                Ok(()) => {}
                Err(Refusal::Fault(fault)) => faults.push(name, line, fault),
                Err(Refusal::Stop) => return Ok(summary),
            }
        }
        if let Err(fault) = done {
            // nobody knows where an arc begins once a block is not understood
            if !(lost && fault.code == Code::BadArc) {
                faults.push(name, line, fault);
            }
        }
        block.assign(&mut parameters);
        if block.m(2) || block.m(30) {
            ended = Some(if block.m(2) { "M2" } else { "M30" });
        }
        if faults.diagnostics.errors() >= MOST_ERRORS {
            break;
        }
    }
    faults.finish();
    Ok(summary)
}

fn unreadable(broken: &Broken) -> Fault {
    match broken {
        Broken::Binary(at, byte) => Fault::new(
            Code::BadWord,
            *at..at + 1,
            format!("a control character, 0x{byte:02x}: this is no part program"),
        )
        .help("a part program is plain text in ASCII or UTF-8"),
        Broken::Long | Broken::Io(_) => {
            Fault::new(Code::TooLarge, 0..1, format!("a line of more than {LONGEST} bytes"))
                .help("a block stands on a line of its own: is this a part program?")
        }
    }
}
