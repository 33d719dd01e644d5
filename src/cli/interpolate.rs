//! `discreta interpolate`: the documents' algorithms, clock by clock.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::args::{InterpolateArgs, StepsFormat};
use super::{CliError, Out, Status, drawing};
use crate::interpolate::{Clock, Columns, Drawing, Interpolator, Request};

/// Runs the command: clocks are printed as they come, and none is kept.
///
/// # Errors
/// A drawing that the method cannot do, or output that cannot be written.
pub fn run(args: &InterpolateArgs, out: &mut Out) -> Result<Status, CliError> {
    let (request, drawing) = drawing::draw(args.method, &args.drawing)?;
    let state = match args.format {
        StepsFormat::Table => table(out, &request, drawing)?,
        StepsFormat::Csv => csv(out, drawing)?,
        StepsFormat::Json => json(out, &request, drawing)?,
        StepsFormat::Steps => steps(out, drawing)?,
    };
    out.flush()?;
    if let Some(stopped) = state.stopped() {
        CliError::usage(stopped.to_string()).print();
    }
    Ok(Status::of(state.state().end))
}

type Finished = Box<dyn Interpolator>;

/// Columns that are wide enough for whatever the registers can hold.
fn table(out: &mut Out, request: &Request, drawing: Drawing) -> Result<Finished, CliError> {
    let mut interpolator = drawing.interpolator;
    let columns = interpolator.columns();
    let width = widest(request, drawing.bits).max(columns_width(&columns));
    let mut line = format!("{:>width$}  step", "clock");
    for name in names(&columns) {
        let _ = write!(line, "  {:>width$}", name.to_uppercase());
    }
    out.write_fmt(format_args!("{line}  end\n"))?;
    let mut row = |clock: u64, step: char, c: &Clock| {
        line.clear();
        let _ = write!(line, "{clock:>width$}  {step:>4}");
        for value in values(&columns, c) {
            let _ = write!(line, "  {value:>width$}");
        }
        out.write_fmt(format_args!("{line}{}\n", if c.end { "  end" } else { "" }))
    };
    row(0, ' ', &interpolator.state())?;
    for (clock, c) in (1..).zip(interpolator.by_ref()) {
        row(clock, c.letter(), &c)?;
    }
    Ok(interpolator)
}

/// The least width of a column, so that small drawings look alike.
fn columns_width(columns: &Columns) -> usize {
    names(columns).map(str::len).max().unwrap_or(0).max(6)
}

/// Digits of the greatest number that a drawing can show: a sum has at most three bits more than a coordinate, and no
/// watchdog waits longer than 16 times the greatest coordinate; a point is where it was asked for, or that much off.
fn widest(request: &Request, bits: u32) -> usize {
    let points = request.from.iter().chain(&request.to).map(|v| v.unsigned_abs()).max().unwrap_or(0);
    let most = points.saturating_add(1 << (bits + 4));
    most.to_string().len() + 1
}

fn csv(out: &mut Out, drawing: Drawing) -> Result<Finished, CliError> {
    let mut interpolator = drawing.interpolator;
    let columns = interpolator.columns();
    let header: Vec<&str> = axes(&columns).iter().copied().chain(names(&columns)).collect();
    out.write_fmt(format_args!("clock,step,{},end\n", header.join(",")))?;
    let mut line = String::new();
    for (clock, c) in (1u64..).zip(interpolator.by_ref()) {
        line.clear();
        let _ = write!(line, "{clock},{}", c.letter());
        let steps = c.step.iter().take(columns.at.len()).map(|&s| i64::from(s));
        for value in steps.chain(values(&columns, &c)) {
            let _ = write!(line, ",{value}");
        }
        out.write_fmt(format_args!("{line},{}\n", u8::from(c.end)))?;
    }
    Ok(interpolator)
}

fn steps(out: &mut Out, drawing: Drawing) -> Result<Finished, CliError> {
    let mut interpolator = drawing.interpolator;
    for c in interpolator.by_ref() {
        out.write_fmt(format_args!("{}", c.letter()))?;
    }
    out.write_fmt(format_args!("\n"))?;
    Ok(interpolator)
}

/// Written by hand around the clocks, which may be more than memory holds. `docs/drawing.md` has its shape.
fn json(out: &mut Out, request: &Request, drawing: Drawing) -> Result<Finished, CliError> {
    let Drawing { mut interpolator, ideal, bits } = drawing;
    let columns = interpolator.columns();
    let axes = axes(&columns).len();
    let start = interpolator.state();
    let head = [
        ("method", json!(request.method.name())),
        ("from", json!(request.from[..axes])),
        ("to", json!(request.to[..axes])),
        ("offset", json!(request.offset.map(|o| json!({ "radius": o.radius, "side": o.side.to_string() })))),
        ("bits", json!(bits)),
        ("columns", names(&columns).collect::<Value>()),
    ];
    out.write_fmt(format_args!("{{\n"))?;
    for (name, value) in head {
        out.write_fmt(format_args!("  \"{name}\": {value},\n"))?;
    }
    out.write_fmt(format_args!("  \"start\": {{{}}},\n  \"clocks\": [", registers(&columns, &start)))?;
    let away = |c: &Clock| ideal.deviation(c.at.map(|v| v as f64)).abs();
    let (mut clocks, mut greatest) = (0u64, (away(&start), 0));
    for c in interpolator.by_ref() {
        clocks += 1;
        let comma = if clocks == 1 { "" } else { "," };
        let steps = json!(c.step[..axes]);
        out.write_fmt(format_args!(
            "{comma}\n    {{\"clock\":{clocks},\"step\":\"{}\",\"steps\":{steps},",
            c.letter()
        ))?;
        out.write_fmt(format_args!("{}}}", registers(&columns, &c)))?;
        if away(&c) > greatest.0 {
            greatest = (away(&c), clocks);
        }
    }
    let tail = [
        ("finished", json!(interpolator.state().end)),
        ("stopped", json!(interpolator.stopped().map(|s| s.to_string()))),
        ("deviation", json!({ "greatest": greatest.0, "clock": greatest.1 })),
    ];
    out.write_fmt(format_args!("{}]", if clocks == 0 { "" } else { "\n  " }))?;
    for (name, value) in tail {
        out.write_fmt(format_args!(",\n  \"{name}\": {value}"))?;
    }
    out.write_fmt(format_args!("\n}}\n"))?;
    Ok(interpolator)
}

/// The registers by name, and whether the end is reached: what stands between the braces of an object.
fn registers(columns: &Columns, c: &Clock) -> String {
    let mut all = String::new();
    for (name, value) in names(columns).zip(values(columns, c)) {
        let _ = write!(all, "\"{name}\":{value},");
    }
    let _ = write!(all, "\"end\":{}", c.end);
    all
}

/// The axes that there are.
fn axes(columns: &Columns) -> &'static [&'static str] {
    &["x", "y", "z"][..columns.at.len()]
}

/// The names of the registers, in the order in which they are printed.
fn names(columns: &Columns) -> impl Iterator<Item = &'static str> {
    columns.at.iter().chain(columns.left).chain(columns.sum).copied()
}

/// Their values in the same order.
fn values(columns: &Columns, c: &Clock) -> impl Iterator<Item = i64> {
    let at = c.at.into_iter().take(columns.at.len());
    let left = c.left.into_iter().take(columns.left.len()).map(|v| v as i64);
    at.chain(left).chain(c.sum.into_iter().take(columns.sum.len()))
}
