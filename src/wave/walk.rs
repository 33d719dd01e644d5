//! Going through several signals together, each of any file, and comparing what they are.

use std::iter::Peekable;

use wellen::SignalValueRef;

use super::diff::Side;
use super::read::ValueKind;

pub(super) trait Point<'a>: Iterator<Item = (u64, SignalValueRef<'a>)> {}
impl<'a, I: Iterator<Item = (u64, SignalValueRef<'a>)>> Point<'a> for I {}

/// Goes through the changes of several signals together, in order of time.
pub(super) struct Walk<'a, I: Point<'a>> {
    pub(super) sources: Vec<Source<'a, I>>,
    pub(super) now: u64,
}

pub(super) struct Source<'a, I: Point<'a>> {
    /// What is to come.
    pub(super) points: Peekable<I>,
    /// When it last changed, and to what.
    pub(super) last: Option<(u64, SignalValueRef<'a>)>,
}

/// The value of a signal at one time.
#[derive(Clone, Copy)]
pub(super) enum Sample<'a> {
    /// Nothing said so far: these bits are x.
    Unknown(u32),
    Nothing,
    Value(SignalValueRef<'a>),
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
            Sample::Value(SignalValueRef::Event) => "event".to_owned(),
            Sample::Value(value) => value.to_string(),
        }
    }
}

pub(super) fn same(a: Sample<'_>, b: Sample<'_>, dont_care: Option<Side>) -> bool {
    match (a, b) {
        (Sample::Value(SignalValueRef::Real(a)), Sample::Value(SignalValueRef::Real(b))) => {
            a == b || a.is_nan() && b.is_nan()
        }
        (Sample::Value(SignalValueRef::BitVec(a)), Sample::Value(SignalValueRef::BitVec(b)))
            if a.width() != b.width() =>
        {
            // only the lower bits are common to both
            let any = |bit: char, side| dont_care == Some(side) && bit == 'x';
            let mut bits = a.iter_lsb_to_msb().zip(b.iter_lsb_to_msb()).map(|(a, b)| (a.as_ascii(), b.as_ascii()));
            bits.all(|(a, b)| any(a, Side::A) || any(b, Side::B) || a == b)
        }
        (Sample::Value(a), Sample::Value(b)) if a == b => true,
        (Sample::Value(SignalValueRef::BitVec(a)), Sample::Value(SignalValueRef::BitVec(b))) => match dont_care {
            None => false,
            Some(Side::A) => agrees(a, b),
            Some(Side::B) => agrees(b, a),
        },
        (Sample::Unknown(_), Sample::Unknown(_)) | (Sample::Nothing, Sample::Nothing) => true,
        (Sample::Unknown(width), Sample::Value(SignalValueRef::BitVec(value))) => {
            dont_care == Some(Side::A) || all_x(value, width)
        }
        (Sample::Value(SignalValueRef::BitVec(value)), Sample::Unknown(width)) => {
            dont_care == Some(Side::B) || all_x(value, width)
        }
        _ => false,
    }
}

fn all_x(value: wellen::BitVecRef<'_>, width: u32) -> bool {
    value.iter_lsb_to_msb().take(width as usize).all(|bit| bit.as_ascii() == 'x')
}

/// Whether every bit that is not x in the first is the same in the second.
fn agrees(loose: wellen::BitVecRef<'_>, strict: wellen::BitVecRef<'_>) -> bool {
    loose
        .iter_lsb_to_msb()
        .zip(strict.iter_lsb_to_msb())
        .all(|(loose, strict)| loose.as_ascii() == 'x' || loose.as_ascii() == strict.as_ascii())
}
