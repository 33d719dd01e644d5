//! Going through several signals together, each of any file, and comparing what they are.

use std::iter::Peekable;

use super::diff::Side;
use super::read::ValueKind;
use super::read::signal::{Bits, Value};

pub(super) trait Point<'a>: Iterator<Item = (u64, Value<'a>)> {}
impl<'a, I: Iterator<Item = (u64, Value<'a>)>> Point<'a> for I {}

/// Goes through the changes of several signals together, in order of time.
pub(super) struct Walk<'a, I: Point<'a>> {
    pub(super) sources: Vec<Source<'a, I>>,
    pub(super) now: u64,
}

pub(super) struct Source<'a, I: Point<'a>> {
    /// What is to come.
    pub(super) points: Peekable<I>,
    /// When it last changed, and to what.
    pub(super) last: Option<(u64, Value<'a>)>,
}

/// The value of a signal at one time.
#[derive(Clone, Copy)]
pub(super) enum Sample<'a> {
    /// Nothing said so far: these bits are x.
    Unknown(u32),
    Nothing,
    Value(Value<'a>),
}

impl<'a, I: Point<'a>> Walk<'a, I> {
    /// The next time at which any of them changes.
    pub(super) fn next(&mut self) -> Option<u64> {
        let next = self.sources.iter_mut().filter_map(|source| source.points.peek()).map(|&(time, _)| time).min()?;
        for source in &mut self.sources {
            if let Some(point) = source.points.next_if(|&(time, _)| time == next) {
                source.last = Some(point);
            }
        }
        self.now = next;
        Some(next)
    }

    pub(super) fn value(&self, source: usize, kind: ValueKind) -> Sample<'a> {
        match (self.sources[source].last, kind) {
            // An event is there only when it happens.
            (Some((time, _)), ValueKind::Event) if time != self.now => Sample::Nothing,
            (Some((_, value)), _) => Sample::Value(value),
            (None, ValueKind::Bits(width)) => Sample::Unknown(width),
            (None, _) => Sample::Nothing,
        }
    }

    pub(super) fn text(&self, source: usize, kind: ValueKind) -> String {
        match self.value(source, kind) {
            Sample::Unknown(width) => "x".repeat(width as usize),
            Sample::Nothing => String::new(),
            Sample::Value(Value::Event) => "event".to_owned(),
            Sample::Value(value) => value.to_string(),
        }
    }
}

pub(super) fn same(a: Sample<'_>, b: Sample<'_>, dont_care: Option<Side>) -> bool {
    match (a, b) {
        (Sample::Value(Value::Real(a)), Sample::Value(Value::Real(b))) => a == b || a.is_nan() && b.is_nan(),
        (Sample::Value(a), Sample::Value(b)) if a == b => true,
        // of different widths only the lower bits are common to both
        (Sample::Value(Value::Bits(a)), Sample::Value(Value::Bits(b))) => match dont_care {
            None => a.agrees(&b, false),
            Some(Side::A) => a.agrees(&b, true),
            Some(Side::B) => b.agrees(&a, true),
        },
        (Sample::Unknown(_), Sample::Unknown(_)) | (Sample::Nothing, Sample::Nothing) => true,
        (Sample::Unknown(width), Sample::Value(Value::Bits(bits))) => unknown(bits, width, dont_care == Some(Side::A)),
        (Sample::Value(Value::Bits(bits)), Sample::Unknown(width)) => unknown(bits, width, dont_care == Some(Side::B)),
        _ => false,
    }
}

/// Whether bits are the same as so many of which nothing is said, unless these agree with anything.
fn unknown(bits: Bits<'_>, width: u32, any: bool) -> bool {
    any || bits.is_x(width)
}
