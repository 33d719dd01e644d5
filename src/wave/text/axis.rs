//! Which time stands in which column.

use super::Trace;
use crate::{Timescale, Unit};

/// Columns for the usual distance of two changes: no more, where all of it fits.
const WIDEST: u64 = 10;
/// Columns for it where not all of it fits.
const NARROWEST: u64 = 5;

/// Columns behind the last tick.
const END: usize = 6;

/// A window of time in columns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Axis {
    /// The first tick.
    pub from: u64,
    /// The last tick.
    pub to: u64,
    /// How many columns.
    pub columns: usize,
    /// Ticks of a column; 1 where a tick has several columns.
    ticks: u64,
    /// Columns of a tick; 1 where a column has several ticks.
    per_tick: u64,
}

/// Whether a window may be shortened to what can be read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Legible {
    /// It is shown as a whole, however coarse that is.
    Whole,
    /// It ends where the columns do, if it cannot be read as a whole.
    Begin,
}

impl Axis {
    /// The window in at most so many columns, at a scale that suits what the traces do in it.
    #[must_use]
    pub fn new(traces: &[Trace], from: u64, to: u64, columns: usize, legible: Legible) -> Axis {
        let columns = columns.max(1);
        let to = to.max(from);
        let gap = usual_gap(traces, from, to).unwrap_or_else(|| (to - from).max(1));
        let made = |(ticks, per_tick): (u64, u64)| {
            let axis = Axis { from, to, columns, ticks, per_tick };
            Axis { columns: usize::try_from(axis.offset(to)).map_or(usize::MAX, |n| n.saturating_add(1)), ..axis }
        };
        let width = |(ticks, per_tick): (u64, u64)| gap.saturating_mul(per_tick) / ticks;
        let fine = scales().find(|&scale| width(scale) <= WIDEST && made(scale).columns <= columns);
        let fine = fine.unwrap_or((u64::MAX, 1));
        let narrow = scales().find(|&scale| width(scale) <= NARROWEST).unwrap_or((u64::MAX, 1));
        if legible == Legible::Begin && width(fine) < 2 && narrow != fine {
            let whole = made(narrow);
            let axis = Axis { columns, ..whole };
            return Axis { to: axis.last(columns - 1).min(to), columns: columns.min(whole.columns), ..axis };
        }
        made(fine)
    }

    /// With some columns behind the last tick, where there are so many, so that what it brings can be read.
    #[must_use]
    pub fn with_end(self, columns: usize) -> Axis {
        Axis { columns: (self.columns + END).min(columns.max(self.columns)), ..self }
    }

    /// Columns from the first to that of a time.
    fn offset(&self, time: u64) -> u64 {
        (u128::from(time - self.from) * u128::from(self.per_tick) / u128::from(self.ticks)) as u64
    }

    /// The column of a time, if it is in the window.
    #[must_use]
    pub fn column(&self, time: u64) -> Option<usize> {
        let inside = (self.from..=self.to).contains(&time);
        inside.then(|| self.offset(time) as usize).filter(|&column| column < self.columns)
    }

    /// The last tick that is not after a column.
    pub(super) fn last(&self, column: usize) -> u64 {
        let end = (column as u128 + 1) * u128::from(self.ticks);
        let last = (end - 1) / u128::from(self.per_tick);
        self.from.saturating_add(u64::try_from(last).unwrap_or(u64::MAX)).min(self.to)
    }

    /// The line of times above the rows.
    pub(super) fn ruler(&self, timescale: Option<Timescale>, ascii: bool) -> String {
        let (tick, line) = if ascii { ('|', '-') } else { ('├', '─') };
        let (step, label) = self.labels(timescale);
        let mut ruler = vec![line; self.columns];
        let mut time = self.from.div_ceil(step).saturating_mul(step);
        let mut first = true;
        while let Some(column) = self.column(time) {
            let text: Vec<char> = format!("{tick}{}", label(time, first)).chars().collect();
            if column + text.len() <= self.columns || first {
                ruler.resize(ruler.len().max(column + text.len()), ' ');
                ruler[column..column + text.len()].copy_from_slice(&text);
            } else {
                ruler[column] = tick;
            }
            first = false;
            match time.checked_add(step) {
                Some(next) => time = next,
                None => break,
            }
        }
        ruler.into_iter().collect()
    }

    /// How far apart times are written, in ticks, and how.
    fn labels(&self, timescale: Option<Timescale>) -> (u64, impl Fn(u64, bool) -> String + use<>) {
        // the greatest unit in which all of them are whole numbers
        let label = move |time: u64, step: u64, with_unit: bool| {
            let Some(timescale) = timescale else {
                return if with_unit { format!("tick {time}") } else { time.to_string() };
            };
            let femtoseconds = |ticks: u64| u128::from(ticks) * u128::from(timescale.femtoseconds());
            let whole = |unit: &&Unit| femtoseconds(step).is_multiple_of(u128::from(unit.femtoseconds()));
            let unit = Unit::ALL.iter().rev().find(whole).copied().unwrap_or(Unit::Fs);
            let number = femtoseconds(time) / u128::from(unit.femtoseconds());
            if with_unit { format!("{number} {unit}") } else { number.to_string() }
        };
        let fits = |&step: &u64| {
            let longest = label(self.to, step, false).len().max(label(self.from, step, true).len()) as u64;
            u128::from(step) * u128::from(self.per_tick) / u128::from(self.ticks) >= u128::from(longest) + 3
        };
        let step = nice().find(fits).unwrap_or(u64::MAX);
        (step, move |time, with_unit| label(time, step, with_unit))
    }
}

/// 1, 2, 5, 10, …
fn nice() -> impl Iterator<Item = u64> {
    (0..20u32).flat_map(|n| [1u64, 2, 5].into_iter().filter_map(move |m| m.checked_mul(10u64.checked_pow(n)?)))
}

/// Ticks and columns, the finest first.
fn scales() -> impl Iterator<Item = (u64, u64)> {
    [10, 8, 5, 4, 3, 2].into_iter().map(|per_tick| (1, per_tick)).chain(nice().map(|ticks| (ticks, 1)))
}

/// The median distance of the times at which something changes.
fn usual_gap(traces: &[Trace], from: u64, to: u64) -> Option<u64> {
    let times = traces.iter().flat_map(|t| t.changes.iter().map(|(time, _)| *time));
    let mut times: Vec<u64> = times.filter(|t| (from..=to).contains(t)).collect();
    times.sort_unstable();
    times.dedup();
    let mut gaps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::ValueKind;
    use crate::text::Radix;

    fn clock(period: u64, edges: u64) -> Trace {
        let changes = (0..edges).map(|n| (n * period / 2, (n % 2).to_string())).collect();
        Trace {
            scope: String::new(),
            name: "clk".into(),
            kind: ValueKind::Bits(1),
            radix: Radix::Auto,
            values: None,
            changes,
        }
    }

    #[test]
    fn what_fits_is_shown_as_a_whole() {
        let axis = Axis::new(&[clock(20, 17)], 0, 170, 90, Legible::Begin);
        assert_eq!((axis.ticks, axis.per_tick, axis.columns, axis.to), (2, 1, 86, 170));
        assert_eq!(
            (axis.column(0), axis.column(41), axis.column(170), axis.column(171)),
            (Some(0), Some(20), Some(85), None)
        );
        assert_eq!((axis.last(0), axis.last(20)), (1, 41));
        // a tick may have several columns
        let axis = Axis::new(&[clock(2, 11)], 0, 10, 90, Legible::Begin);
        assert_eq!((axis.ticks, axis.per_tick, axis.columns), (1, 8, 81));
        assert_eq!((axis.last(7), axis.last(8), axis.column(1)), (0, 1, Some(8)));
    }

    #[test]
    fn what_is_long_begins_at_a_scale_that_can_be_read() {
        let long = [clock(20, 10_000)];
        let axis = Axis::new(&long, 40, 100_000, 100, Legible::Begin);
        assert_eq!((axis.ticks, axis.from, axis.to, axis.columns), (2, 40, 239, 100));
        let axis = Axis::new(&long, 40, 100_000, 100, Legible::Whole);
        // 99,960 ticks in 100 columns
        assert_eq!((axis.ticks, axis.to, axis.columns), (1000, 100_000, 100));
        // no time is out of reach
        for legible in [Legible::Begin, Legible::Whole] {
            let axis = Axis::new(&[], 0, u64::MAX, 10, legible);
            assert!(axis.columns <= 10 && axis.ruler(None, true).len() > 5);
            assert!(Axis::new(&[], u64::MAX, u64::MAX, 1, legible).columns == 1);
        }
    }

    #[test]
    fn times_are_written_in_the_unit_that_is_whole() {
        let axis = Axis::new(&[clock(2000, 20)], 0, 20_000, 60, Legible::Whole);
        let ps: Timescale = "1ps".parse().unwrap();
        // 500 ps a column
        assert_eq!(axis.ruler(Some(ps), true), "|0 ns-----|5--------|10-------|15-------|");
        assert_eq!(axis.ruler(None, true), "|tick 0---|5000-----|10000----|15000----|");
    }
}
