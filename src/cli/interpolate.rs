//! `discreta interpolate`: the documents' algorithms, clock by clock.

use serde_json::{Map, Value, json};

use super::args::{InterpolateArgs, StepsFormat};
use super::{CliError, Out, Status};
use crate::interpolate::{Clock, Columns, Drawing, Method, Options, Request, UnknownMethod};

/// Runs the command.
///
/// # Errors
/// A method that there is not, or a drawing that it cannot do.
pub fn run(args: &InterpolateArgs, out: &mut Out) -> Result<Status, CliError> {
    let method: Method = args.method.parse().map_err(|e: UnknownMethod| CliError::usage(e.to_string()))?;
    let request = Request {
        from: [args.from.x, args.from.y, 0],
        options: Options { as_printed: args.as_printed, ..Options::default() },
        ..Request::new(method, [args.to.x, args.to.y, 0])
    };
    let drawing = request.draw().map_err(|e| CliError::usage(e.to_string()))?;
    print(args.format, out, method, drawing)
}

/// Prints the clocks as they come; a run that stops without its end is a failure.
fn print(format: StepsFormat, out: &mut Out, method: Method, drawing: Drawing) -> Result<Status, CliError> {
    let mut interpolator = drawing.interpolator;
    let columns = interpolator.columns();
    let mut listed = Vec::new();
    match format {
        StepsFormat::Table => {
            let mut header = format!("{:>6}  {:>4}", "clock", "step");
            for name in names(&columns) {
                header += &format!("  {:>8}", name.to_uppercase());
            }
            out.write_fmt(format_args!("{header}  end\n"))?;
            row(out, &columns, 0, &interpolator.state())?;
        }
        StepsFormat::Csv => {
            let axes: Vec<&str> = ["x", "y", "z"].into_iter().take(columns.at.len()).chain(names(&columns)).collect();
            out.write_fmt(format_args!("clock,step,{},end\n", axes.join(",")))?;
        }
        StepsFormat::Json | StepsFormat::Steps => {}
    }
    for (i, c) in interpolator.by_ref().enumerate() {
        match format {
            StepsFormat::Table => row(out, &columns, i + 1, &c)?,
            StepsFormat::Csv => {
                let steps = c.step.iter().take(columns.at.len()).map(|&s| i64::from(s));
                let cells: Vec<String> = steps.chain(values(&columns, &c)).map(|v| v.to_string()).collect();
                out.write_fmt(format_args!("{},{},{},{}\n", i + 1, c.letter(), cells.join(","), u8::from(c.end)))?;
            }
            StepsFormat::Json => {
                let mut clock = Map::new();
                clock.insert("clock".to_owned(), json!(i + 1));
                clock.insert("step".to_owned(), json!(c.letter().to_string()));
                let cells = names(&columns).zip(values(&columns, &c));
                clock.extend(cells.map(|(name, value)| (name.to_owned(), json!(value))));
                clock.insert("end".to_owned(), json!(c.end));
                listed.push(Value::Object(clock));
            }
            StepsFormat::Steps => out.write_fmt(format_args!("{}", c.letter()))?,
        }
    }
    let finished = interpolator.state().end;
    match format {
        StepsFormat::Steps => out.write_fmt(format_args!("\n"))?,
        StepsFormat::Json => {
            out.json(&json!({ "method": method.name(), "finished": finished, "clocks": listed }))?;
        }
        _ => {}
    }
    out.flush()?;
    if let Some(stopped) = interpolator.stopped() {
        eprintln!("error: {stopped}");
    }
    Ok(Status::of(finished))
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

fn row(out: &mut Out, columns: &Columns, clock: usize, c: &Clock) -> Result<(), CliError> {
    let step = if clock == 0 { ' ' } else { c.letter() };
    let mut line = format!("{clock:>6}  {step:>4}");
    for value in values(columns, c) {
        line += &format!("  {value:>8}");
    }
    if c.end {
        line += "  end";
    }
    out.write_fmt(format_args!("{line}\n"))
}
