//! The waveform around the first difference of two: what one of them has above what the other has.

use super::{Axis, Legible, Picture, Radix, Style, Trace, margin};
use crate::diff::Difference;
use crate::read::{ReadError, Waves};

/// Signals that are shown, at most.
const SIGNALS: usize = 4;

/// Draws the signals that differ, as each waveform has them, with their clock, around the first difference. Nothing where
/// no value differs.
///
/// # Errors
/// Values that are damaged.
pub fn around(
    a: &mut Waves,
    b: &mut Waves,
    difference: &Difference,
    names: [&str; 2],
    width: usize,
    style: Style,
) -> Result<Option<String>, ReadError> {
    let (Some(first), Some(context)) = (difference.first, &difference.context) else { return Ok(None) };
    let mut traces = Vec::new();
    if let Some(clock) = context.clock.as_deref().and_then(|name| a.find(name)) {
        traces.push(load(a, clock, difference, "")?);
    }
    // the signal of the context first, which is the first to differ
    for signal in difference.signals.iter().take(SIGNALS) {
        for (waves, side) in [(&mut *a, names[0]), (&mut *b, names[1])] {
            if let Some(var) = find(waves, &signal.name) {
                traces.push(load(waves, var, difference, side)?);
            }
        }
    }
    for trace in &mut traces {
        trace.name =
            if trace.scope.is_empty() { trace.name.clone() } else { format!("{}.{}", trace.scope, trace.name) };
        trace.scope.clear();
    }
    let rows = context.rows.iter().map(|row| row.time);
    let (from, to) = (rows.clone().min().unwrap_or(first), rows.max().unwrap_or(first));
    let end = difference.a.end.min(difference.b.end);
    let (from, to) = (from.min(first), to.max(first).saturating_add((to - from) / 8 + 1).min(end.max(first)));
    let columns = width.saturating_sub(margin(&traces));
    let axis = Axis::new(&traces, from, to, columns, Legible::Whole).with_end(columns);
    let mark = Some((first, "first difference".to_owned()));
    let picture = Picture { traces: &traces, timescale: difference.timescale, axis, mark, style };
    Ok(Some(picture.to_string()))
}

/// The variable of a name, which is that of the other waveform: there a scope may stand around it, or here.
fn find(waves: &Waves, name: &str) -> Option<usize> {
    let ends = |long: &str, short: &str| long.strip_suffix(short).is_some_and(|scopes| scopes.ends_with('.'));
    waves.find(name).or_else(|| waves.vars().iter().position(|v| ends(&v.name, name) || ends(name, &v.name)))
}

/// A variable in ticks of the comparison.
fn load(waves: &mut Waves, var: usize, difference: &Difference, side: &str) -> Result<Trace, ReadError> {
    let mut trace = Trace::load(waves, var, Radix::Auto)?;
    let common = difference.timescale.map(crate::Timescale::exponent);
    if let (Some(own), Some(common)) = (waves.exponent(), common) {
        let factor = 10u64.saturating_pow(own.abs_diff(common));
        trace.changes.iter_mut().for_each(|(time, _)| *time = time.saturating_mul(factor));
    }
    if !side.is_empty() {
        trace.name = format!("{} ({side})", trace.name);
    }
    Ok(trace)
}
