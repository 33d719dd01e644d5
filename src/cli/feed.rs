//! `discreta feed`: for which times the system of interpolator, synchronisers and speed block works, and its greatest feed.

use serde_json::json;

use super::args::{FeedArgs, Format};
use super::{CliError, Out, Status};
use crate::interpolate::feed::Margins;

/// Runs the command.
///
/// # Errors
/// A step pulse that is as long as its period, output that cannot be written.
pub fn run(args: &FeedArgs, out: &mut Out) -> Result<Status, CliError> {
    let FeedArgs { step, step_high: high, tau, hold, tick, high: dt_high, .. } = *args;
    if high >= step {
        let fault = CliError::usage(format!("a step pulse of {high} ns in a period of {step} ns never ends"));
        return Err(fault.with_hint("--step-high has to be below --step"));
    }
    let margins = Margins { step, high, tau, hold, tick, dt_high };
    let unsafe_margin = margins.check().err();
    let ticks = margins.least_ticks();
    let period = ticks.saturating_mul(tick);
    // a step of an axis with every pulse of dt
    let feed = 1e9 / period as f64;
    let mm = args.blu.map(|blu| feed * blu.to_f64() * 60.0);
    match args.format.format {
        Format::Json => out.json(&json!({
            "kept": unsafe_margin.is_none(),
            "margin": unsafe_margin.map(|e| e.to_string()),
            "wait_ns": margins.least_wait(),
            "rise_again_ns": margins.rise_again(),
            "least_ticks": ticks,
            "least_period_ns": period,
            "greatest_feed_blu_s": feed,
            "greatest_feed_mm_min": mm,
        }))?,
        Format::Text => {
            match unsafe_margin {
                Some(margin) => out.write_fmt(format_args!("steps may be lost or gained, at any feed: {margin}\n"))?,
                None => out.write_fmt(format_args!("no step is lost or gained, up to this feed:\n"))?,
            }
            out.write_fmt(format_args!("shortest period of dt: {ticks} ticks, {period} ns\n"))?;
            let mm = mm.map_or(String::new(), |mm| format!(", {mm:.3} mm/min"));
            out.write_fmt(format_args!("greatest feed: {feed:.3} BLU/s{mm}\n"))?;
        }
    }
    out.flush()?;
    Ok(Status::of(unsafe_margin.is_none()))
}
