//! The path in a waveform: coordinates as they stand at the end of each clock.

use std::cmp::Ordering;

use super::CliError;
use super::args::CoordinateArgs;
use super::wave::declared;
use crate::circuit::Circuit;
use crate::view::route::Reached;
use crate::wave::read::{ValueKind, Waves};

/// No interpolator goes further along an axis in a clock, BLU.
const LONGEST_STEP: u64 = 8;

/// The coordinates before the first clock and at the end of each, just before the leading edge of the next, with the
/// time since when they stand so.
///
/// # Errors
/// Nets that are not there or no coordinates, or that become unknown.
pub(super) fn sampled(waves: &mut Waves, args: &CoordinateArgs) -> Result<Vec<Reached>, CliError> {
    Ok(readings(waves, args)?.swap_remove(0))
}

/// The same, and where the path may as well be one of numbers without a sign as of numbers with one, both, without
/// first. A path goes in small steps: where one reading has more leaps than the other, it is the wrong one.
///
/// # Errors
/// As [`sampled`].
pub(super) fn readings(waves: &mut Waves, args: &CoordinateArgs) -> Result<Vec<Vec<Reached>>, CliError> {
    let mut edges = edges(waves, args)?;
    edges.push(u64::MAX);
    let nets = nets(waves, args)?;
    if args.signed {
        return Ok(vec![points(&nets, edges.into_iter(), true)?]);
    }
    let plain = points(&nets, edges.iter().copied(), false)?;
    let signed = points(&nets, edges.into_iter(), true)?;
    let width = nets.iter().flatten().map(|(_, bits)| bits.len()).max().unwrap_or(1);
    Ok(match leaps(&plain, width).cmp(&leaps(&signed, width)) {
        _ if plain == signed => vec![plain],
        Ordering::Less => vec![plain],
        Ordering::Greater => vec![signed],
        Ordering::Equal => vec![plain, signed],
    })
}

/// The leading edges of the clock.
///
/// # Errors
/// As [`sampled`].
pub(super) fn edges(waves: &mut Waves, args: &CoordinateArgs) -> Result<Vec<u64>, CliError> {
    let clock = changes(waves, args.dt.as_deref().unwrap_or("dt"), "--dt")?;
    Ok(clock.windows(2).filter(|pair| pair[1].1 == "1" && pair[0].1 != "1").map(|pair| pair[1].0).collect())
}

/// How often a path of coordinates so wide goes further along an axis than an interpolator steps.
fn leaps(points: &[Reached], width: usize) -> usize {
    let step = LONGEST_STEP.min((1 << (width - 1)) - 1);
    let leap = |pair: &&[Reached]| (0..3).any(|axis| pair[0].at[axis].abs_diff(pair[1].at[axis]) > step);
    points.windows(2).filter(leap).count()
}

/// The coordinates after each of their changes, whatever clocks them.
///
/// # Errors
/// As [`sampled`].
pub(super) fn moved(waves: &mut Waves, args: &CoordinateArgs) -> Result<Vec<Reached>, CliError> {
    let nets = nets(waves, args)?;
    let mut times: Vec<u64> = nets.iter().flatten().map(|(time, _)| time.saturating_add(1)).collect();
    times.sort_unstable();
    times.dedup();
    let width = nets.iter().flatten().map(|(_, bits)| bits.len()).max().unwrap_or(1);
    let plain = points(&nets, times.iter().copied(), args.signed)?;
    let signed = points(&nets, times.into_iter(), true)?;
    let mut points = if leaps(&signed, width) < leaps(&plain, width) { signed } else { plain };
    points.dedup_by_key(|point| point.at);
    Ok(points)
}

/// A net over time.
pub(super) type Changes = Vec<(u64, String)>;

fn nets(waves: &mut Waves, args: &CoordinateArgs) -> Result<Vec<Changes>, CliError> {
    let mut nets = Vec::new();
    for (name, default, option) in [(&args.x, Some("xt"), "--x"), (&args.y, Some("yt"), "--y"), (&args.z, None, "--z")]
    {
        if let Some(name) = name.as_deref().or(default) {
            nets.push(changes(waves, name, option)?);
        }
    }
    Ok(nets)
}

/// The coordinates just before each of some times.
fn points(nets: &[Changes], times: impl Iterator<Item = u64>, signed: bool) -> Result<Vec<Reached>, CliError> {
    let mut points = Vec::new();
    let mut before = vec![0; nets.len()];
    for edge in times {
        let mut at = [Some(0); 3];
        let mut time = 0;
        for ((axis, net), before) in nets.iter().enumerate().zip(&mut before) {
            while net.get(*before).is_some_and(|(time, _)| *time < edge) {
                *before += 1;
            }
            let change = before.checked_sub(1).map(|i| &net[i]);
            at[axis] = change.and_then(|(_, bits)| coordinate(bits, signed));
            time = time.max(change.map_or(0, |(time, _)| *time));
        }
        match at {
            [Some(x), Some(y), Some(z)] => points.push(Reached { time, at: [x, y, z] }),
            // not yet known; once they are, a gap would show a path that there is not
            _ if points.is_empty() => {}
            _ => {
                return Err(CliError::usage(format!("a coordinate is unknown before the edge of the clock at {edge}")));
            }
        }
    }
    Ok(points)
}

/// The changes of the net of a name.
pub(super) fn changes(waves: &mut Waves, name: &str, option: &str) -> Result<Changes, CliError> {
    let found = found(waves, name, option)?;
    if !matches!(waves.vars()[found].kind, ValueKind::Bits(1..=63)) {
        return Err(CliError::usage(format!("`{name}` is {}, not 1 to 63 bits", waves.vars()[found].kind)));
    }
    Ok(waves.load(found)?.changes().collect())
}

/// The net of a name: the full name, or else the only one nearest to the top that ends in it.
fn found(waves: &Waves, name: &str, option: &str) -> Result<usize, CliError> {
    let path = waves.path().display().to_string();
    match waves.find(name) {
        Some(found) => Ok(found),
        None => {
            let inner = format!(".{name}");
            let vars = || waves.vars().iter().enumerate().filter(|(_, v)| v.name.ends_with(&inner));
            let depth = |name: &str| name.matches('.').count();
            let least = vars().map(|(_, v)| depth(&v.name)).min();
            let nearest: Vec<usize> = vars().filter(|(_, v)| Some(depth(&v.name)) == least).map(|(i, _)| i).collect();
            match nearest[..] {
                [one] => Ok(one),
                [] => {
                    let fault = CliError::usage(format!("`{path}` has no net `{name}`"));
                    Err(fault.with_hint(format!("name another with {option}")))
                }
                [a, b, ..] => {
                    let [a, b] = [a, b].map(|i| waves.vars()[i].name.clone());
                    let fault = CliError::usage(format!("`{path}` has several nets `{name}`"));
                    Err(fault.with_hint(format!("name one in full with {option}, such as {a} or {b}")))
                }
            }
        }
    }
}

/// Whether a circuit has the coordinates signed.
///
/// # Errors
/// As [`sampled`].
pub(super) fn signed(circuit: &Circuit, waves: &Waves, args: &CoordinateArgs) -> Result<bool, CliError> {
    let nets = [(args.x.as_deref().unwrap_or("xt"), "--x"), (args.y.as_deref().unwrap_or("yt"), "--y")];
    let mut any = false;
    for (name, option) in nets {
        any |= declared(circuit, waves, found(waves, name, option)?).is_some_and(|signal| signal.signed);
    }
    Ok(any)
}

/// The number that bits are; none if one of them is unknown.
fn coordinate(bits: &str, signed: bool) -> Option<i64> {
    let value = i64::from_str_radix(bits, 2).ok()?;
    let negative = signed && bits.starts_with('1');
    Some(if negative { value - (1 << bits.len()) } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates() {
        assert_eq!(
            [coordinate("0101", false), coordinate("1111", false), coordinate("1x11", false)],
            [Some(5), Some(15), None]
        );
        assert_eq!(
            [coordinate("0101", true), coordinate("1111", true), coordinate("1000", true)],
            [Some(5), Some(-1), Some(-8)]
        );
    }
}
