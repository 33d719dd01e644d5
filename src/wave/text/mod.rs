//! A waveform as text: a row a signal, a column a span of time, for terminals, logs and mails.
//!
//! [`Trace`] is what one row shows, [`Picture`] all of them over a window of time. Levels are lines (`▁╱▔╲`, or `_/"\`
//! in ASCII), a bus shows its values between `╳` (`|`), x and z are letters. What is too quick for a column is `╫` (`#`):
//! nothing that changes is left out in silence.

pub mod around;
mod axis;
mod radix;

use std::fmt::{self, Write as _};
use std::sync::Arc;

pub use axis::{Axis, Legible};
pub use radix::Radix;

use super::read::{ReadError, ValueKind, Waves};
use crate::Timescale;
use crate::safe;
use crate::value::ValueNames;

/// Columns between a name and its row.
const GAP: usize = 2;
/// Longer names lose their middle.
const MAX_NAME: usize = 40;

/// One signal over time.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Trace {
    /// The scopes around it, joined by dots; rows of one scope stand together under its name.
    pub scope: String,
    /// Its name in its scope.
    pub name: String,
    /// What its values are.
    pub kind: ValueKind,
    /// How its numbers are written.
    pub radix: Radix,
    /// What its values are called, where they have names.
    pub values: Option<Arc<ValueNames>>,
    /// The times at which it changes, and its bits from then on; before the first it is unknown.
    pub changes: Vec<(u64, String)>,
}

impl Trace {
    /// What a variable of a waveform does.
    ///
    /// # Errors
    /// Its values are damaged.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load(waves: &mut Waves, var: usize, radix: Radix) -> Result<Trace, ReadError> {
        let changes = waves.load(var)?.changes().collect();
        Ok(Trace { radix, ..Trace::of(waves, var, changes) })
    }

    /// What several variables do, in one pass over the file.
    ///
    /// # Errors
    /// Their values are damaged.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load_all(waves: &mut Waves, vars: &[usize]) -> Result<Vec<Trace>, ReadError> {
        let loaded: Vec<Vec<(u64, String)>> =
            waves.load_all(vars)?.iter().map(|series| series.changes().collect()).collect();
        Ok(vars.iter().zip(loaded).map(|(&var, changes)| Trace::of(waves, var, changes)).collect())
    }

    fn of(waves: &Waves, var: usize, changes: Vec<(u64, String)>) -> Trace {
        let var = &waves.vars()[var];
        let scope = var.scope().to_owned();
        let name = if scope.is_empty() { var.name.clone() } else { var.name[scope.len() + 1..].to_owned() };
        Trace { scope, name, kind: var.kind, radix: Radix::Auto, values: None, changes }
    }

    /// The value at a time, as bits.
    fn at(&self, time: u64) -> Option<&str> {
        let next = self.changes.partition_point(|(t, _)| *t <= time);
        next.checked_sub(1).map(|i| self.changes[i].1.as_str())
    }
}

/// Which signs the rows are drawn with.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Style {
    /// ASCII alone.
    pub ascii: bool,
    /// Colours, as escape sequences.
    pub color: bool,
}

/// Rows of traces over a window of time.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The rows; those of one scope together.
    pub traces: &'a [Trace],
    /// How long a tick is, if that is known.
    pub timescale: Option<Timescale>,
    /// The columns of the window.
    pub axis: Axis,
    /// A time that is pointed at from beneath, and what is to be said of it.
    pub mark: Option<(u64, String)>,
    /// The signs.
    pub style: Style,
}

/// What a column of a row holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ink {
    Plain,
    Unknown,
    Floating,
    Scope,
    Mark,
}

impl Ink {
    const fn code(self) -> &'static str {
        match self {
            Ink::Plain => "",
            Ink::Unknown => "\x1b[31m",
            Ink::Floating => "\x1b[33m",
            Ink::Scope => "\x1b[1m",
            Ink::Mark => "\x1b[1;31m",
        }
    }
}

/// The signs for edges, levels and the borders of values.
struct Signs {
    low: char,
    high: char,
    rise: char,
    fall: char,
    border: char,
    quick: char,
    event: char,
    cut: char,
    mark: char,
}

const UNICODE: Signs =
    Signs {
        low: '▁', high: '▔', rise: '╱', fall: '╲', border: '╳', quick: '╫', event: '↑', cut: '…', mark: '▲'
    };
const ASCII: Signs =
    Signs { low: '_', high: '"', rise: '/', fall: '\\', border: '|', quick: '#', event: '!', cut: '~', mark: '^' };

impl Style {
    fn signs(self) -> &'static Signs {
        if self.ascii { &ASCII } else { &UNICODE }
    }
}

/// How wide the names of traces are, with the gap behind them: what is left of a line is for the [`Axis`].
#[must_use]
pub fn margin(traces: &[Trace]) -> usize {
    let indent = |t: &Trace| if t.scope.is_empty() { 0 } else { 2 };
    traces.iter().map(|t| indent(t) + safe::name(&t.name).chars().count().min(MAX_NAME)).max().unwrap_or(0) + GAP
}

impl fmt::Display for Picture<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let margin = margin(self.traces);
        let ruler = self.axis.ruler(self.timescale, self.style.ascii);
        writeln!(f, "{:margin$}{}", "", ruler.trim_end())?;
        let mut scope = "";
        for trace in self.traces {
            if trace.scope != scope {
                scope = &trace.scope;
                self.ink(f, Ink::Scope, &safe::name(scope))?;
                f.write_char('\n')?;
            }
            let indent = if scope.is_empty() { "" } else { "  " };
            let name = format!("{indent}{}", shorten(&safe::name(&trace.name), MAX_NAME, self.style.signs().cut));
            let mut line = format!("{name:margin$}");
            let mut row = self.row(trace);
            while row.pop_if(|(sign, _)| *sign == ' ').is_some() {}
            let mut rest = row.as_slice();
            while let Some(&(_, ink)) = rest.first() {
                let run = rest.iter().take_while(|cell| cell.1 == ink).count();
                // values of strings hold anything; a column stays one
                let shown = |&(sign, _): &(char, Ink)| if safe::is_plain(sign) { sign } else { '?' };
                let text: String = rest[..run].iter().map(shown).collect();
                self.put(&mut line, ink, &text);
                rest = &rest[run..];
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        if let Some((time, text)) = &self.mark
            && let Some(column) = self.axis.column(*time)
        {
            let arrow = format!("{} {}", self.style.signs().mark, safe::name(text));
            write!(f, "{:1$}", "", margin + column)?;
            self.ink(f, Ink::Mark, &arrow)?;
            f.write_char('\n')?;
        }
        Ok(())
    }
}

impl Picture<'_> {
    fn ink(&self, f: &mut fmt::Formatter<'_>, ink: Ink, text: &str) -> fmt::Result {
        let mut inked = String::new();
        self.put(&mut inked, ink, text);
        f.write_str(&inked)
    }

    fn put(&self, to: &mut String, ink: Ink, text: &str) {
        if self.style.color && ink != Ink::Plain {
            let _ = write!(to, "{}{text}\x1b[0m", ink.code());
        } else {
            to.push_str(text);
        }
    }

    /// The columns of one trace.
    fn row(&self, trace: &Trace) -> Vec<(char, Ink)> {
        let Axis { from, to, .. } = self.axis;
        // how many changes each column has; what stands at the left edge is none
        let mut changes = vec![0u32; self.axis.columns];
        let mut before = trace.at(from);
        for (time, value) in trace.changes.iter().filter(|(t, _)| (from + 1..=to).contains(t)) {
            if (before != Some(value) || trace.kind == ValueKind::Event)
                && let Some(column) = self.axis.column(*time)
            {
                changes[column] += 1;
            }
            before = Some(value);
        }
        match trace.kind {
            ValueKind::Bits(1) => self.levels(trace, &changes),
            ValueKind::Event => self.events(&changes),
            _ => self.values(trace, &changes),
        }
    }

    fn levels(&self, trace: &Trace, changes: &[u32]) -> Vec<(char, Ink)> {
        let signs = self.style.signs();
        let mut before = trace.at(self.axis.from).unwrap_or("x");
        let row = changes.iter().enumerate().map(|(column, &count)| {
            let now = trace.at(self.axis.last(column)).unwrap_or("x");
            let was = std::mem::replace(&mut before, now);
            match (count, was, now) {
                (2.., ..) => (signs.quick, Ink::Plain),
                (1, "0", "1") => (signs.rise, Ink::Plain),
                (1, "1", "0") => (signs.fall, Ink::Plain),
                (_, _, "0") => (signs.low, Ink::Plain),
                (_, _, "1") => (signs.high, Ink::Plain),
                (_, _, other) => (other.chars().next().unwrap_or('x'), ink(other)),
            }
        });
        row.collect()
    }

    fn events(&self, changes: &[u32]) -> Vec<(char, Ink)> {
        let signs = self.style.signs();
        changes.iter().map(|&n| ([' ', signs.event, signs.quick][n.min(2) as usize], Ink::Plain)).collect()
    }

    fn values(&self, trace: &Trace, changes: &[u32]) -> Vec<(char, Ink)> {
        let signs = self.style.signs();
        let mut row = Vec::with_capacity(changes.len());
        while row.len() < changes.len() {
            let start = row.len();
            match changes[start] {
                0 => {}
                1 => row.push((signs.border, Ink::Plain)),
                _ => row.push((signs.quick, Ink::Plain)),
            }
            let room = changes[row.len()..].iter().take_while(|&&n| n == 0).count();
            let unknown = "x".repeat(if let ValueKind::Bits(n) = trace.kind { n as usize } else { 1 });
            let bits = trace.at(self.axis.last(start)).unwrap_or(&unknown);
            let ink = ink(bits);
            let fill = match bits.chars().next() {
                Some(c @ ('x' | 'z')) if bits.chars().all(|b| b == c) => c,
                _ => ' ',
            };
            let called = trace.values.as_ref().and_then(|names| names.of_bits(bits));
            let fill = if called.is_some() { ' ' } else { fill };
            let text = called.map_or_else(|| trace.radix.text(bits, trace.kind), str::to_owned);
            let text = if fill == ' ' { fitted(&text, room, signs.cut) } else { fill.to_string().repeat(room) };
            row.extend(text.chars().chain(std::iter::repeat(fill)).take(room).map(|c| (c, ink)));
        }
        row
    }
}

fn ink(bits: &str) -> Ink {
    if bits.contains('x') {
        Ink::Unknown
    } else if bits.contains('z') {
        Ink::Floating
    } else {
        Ink::Plain
    }
}

/// A text where there is so much room for it; with space before it if there is enough.
fn fitted(text: &str, room: usize, cut: char) -> String {
    let length = text.chars().count();
    match room {
        _ if room >= length + 2 => format!(" {text}"),
        _ if room >= length => text.to_owned(),
        0 => String::new(),
        _ => text.chars().take(room - 1).chain([cut]).collect(),
    }
}

fn shorten(text: &str, max: usize, cut: char) -> String {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() <= max {
        return text.to_owned();
    }
    let half = max / 2;
    chars[..max - half - 1].iter().chain([&cut]).chain(&chars[chars.len() - half..]).collect()
}

#[cfg(test)]
mod tests;
