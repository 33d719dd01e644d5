//! `discreta interpolate`: the documents' algorithms, clock by clock.

use serde_json::json;

use super::args::{InterpolateArgs, StepsFormat};
use super::{CliError, Out, Status};
use crate::interpolate::ef_line::Clock;
use crate::interpolate::{EfLine, EfLineInput, EfLinePrinted, MAX_BITS, Method, Overrun};

/// Runs the command.
///
/// # Errors
/// A method that there is not, or a line that it cannot do.
pub fn run(args: &InterpolateArgs, out: &mut Out) -> Result<Status, CliError> {
    let Method::EfLine =
        args.method.parse().map_err(|e: crate::interpolate::UnknownMethod| CliError::usage(e.to_string()))?;
    let (from, to) = ((args.from.x, args.from.y), (args.to.x, args.to.y));
    let line = |bits| EfLineInput::between(from, to, bits);
    // the narrowest registers that hold the line, from 8 bits up
    let input = (8..=MAX_BITS).find_map(|bits| line(bits).ok().filter(|i| EfLine::new(*i).is_ok()));
    let input = match input {
        Some(input) => input,
        None => {
            let fault = line(MAX_BITS).and_then(|i| EfLine::new(i).map(|_| ())).err();
            return Err(CliError::usage(
                fault.map_or_else(|| "the line cannot be interpolated".to_owned(), |e| e.to_string()),
            ));
        }
    };
    if args.as_printed {
        let algorithm = EfLinePrinted::new(input).map_err(|e| CliError::usage(e.to_string()))?;
        let start = algorithm.state();
        print(args.format, out, start, algorithm)
    } else {
        let algorithm = EfLine::new(input).map_err(|e| CliError::usage(e.to_string()))?;
        let start = algorithm.state();
        print(args.format, out, start, algorithm.map(Ok))
    }
}

/// Prints the clocks as they come; a run that the watchdog ends is a failure.
fn print(
    format: StepsFormat,
    out: &mut Out,
    start: Clock,
    clocks: impl Iterator<Item = Result<Clock, Overrun>>,
) -> Result<Status, CliError> {
    let mut overrun = None;
    let mut listed = Vec::new();
    match format {
        StepsFormat::Table => {
            out.write_fmt(format_args!(
                "{:>6}  {:>4}  {:>8} {:>8}  {:>8} {:>8}  {:>10}  end\n",
                "clock", "step", "XT", "YT", "KOX", "KOY", "F"
            ))?;
            row(out, 0, &start)?;
        }
        StepsFormat::Csv => out.write_fmt(format_args!("clock,step,x,y,xt,yt,kox,koy,f,end\n"))?,
        StepsFormat::Json | StepsFormat::Steps => {}
    }
    for (i, clock) in clocks.enumerate() {
        let c = match clock {
            Ok(clock) => clock,
            Err(e) => {
                overrun = Some(e);
                break;
            }
        };
        match format {
            StepsFormat::Table => row(out, i + 1, &c)?,
            StepsFormat::Csv => {
                let bit = u8::from;
                out.write_fmt(format_args!("{},{},{},{},{},{},{},{},{},{}\n", i + 1, c.letter(), bit(c.x), bit(c.y), c.xt, c.yt, c.kox, c.koy, c.f, bit(c.end)))?;
            }
            StepsFormat::Json => listed.push(json!({ "clock": i + 1, "step": c.letter().to_string(), "xt": c.xt, "yt": c.yt, "kox": c.kox, "koy": c.koy, "f": c.f, "end": c.end })),
            StepsFormat::Steps => out.write_fmt(format_args!("{}", c.letter()))?,
        }
    }
    match format {
        StepsFormat::Steps => out.write_fmt(format_args!("\n"))?,
        StepsFormat::Json => {
            out.json(&json!({ "method": Method::EfLine.name(), "finished": overrun.is_none(), "clocks": listed }))?
        }
        _ => {}
    }
    out.flush()?;
    if let Some(e) = &overrun {
        eprintln!("error: {e}");
    }
    Ok(Status::of(overrun.is_none()))
}

fn row(out: &mut Out, clock: usize, c: &Clock) -> Result<(), CliError> {
    let step = if clock == 0 { ' ' } else { c.letter() };
    let end = if c.end { "end" } else { "" };
    let line = format!("{clock:>6}  {step:>4}  {:>8} {:>8}  {:>8} {:>8}  {:>10}  {end}", c.xt, c.yt, c.kox, c.koy, c.f);
    out.write_fmt(format_args!("{}\n", line.trim_end()))
}
