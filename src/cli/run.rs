//! `discreta run`: a circuit, its scenario, a summary, a waveform.

use std::path::PathBuf;

use super::args::{Format, RunArgs};
use super::loading::{faults, loader};
use super::prepare::{Changes, prepare};
use super::report::Report;
use super::simulate::simulate;
use super::{CliError, Out, Status, interrupt, save, waveforms};
use crate::wave::Sink;
use crate::wave::select::Tee;

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, a circuit that does not settle, a waveform that cannot be written.
pub fn run(args: &RunArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut loader = loader(&args.elaboration, &args.more)?;
    let changes = Changes {
        wave: args.wave.stimulus.is_some().then_some(&args.wave),
        ..Changes::of(&args.elaboration, &args.scenario, &args.trace)
    };
    let files = waveforms::places(args)?;
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let mut prepared = faults(&mut loader, prepared)?;

    // nothing before this looks whether it was interrupted, so until here one signal ends it
    interrupt::watch();
    let mut writers = waveforms::open(&files)?;
    let mut sinks = Tee(writers.iter_mut().map(|w| &mut **w as &mut dyn Sink).collect());
    let sink: Option<&mut dyn Sink> = if files.is_empty() { None } else { Some(&mut sinks) };
    let (outcome, difference) = simulate(&mut prepared, &loader, &args.engine, sink, "running")?;
    let mut files: Vec<PathBuf> = files.into_iter().map(|place| place.path).collect();
    if args.save {
        files.extend(save::beside(&prepared, &files, outcome.time)?);
    }

    let difference = difference.as_ref();
    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &files, difference };
    report.warnings(args.verbose);
    // a waveform on standard output has it to itself
    if files.iter().any(|o| o.as_os_str() == "-") {
        report.stderr();
    } else if args.format.format == Format::Json {
        out.json(&report.json())?;
    } else {
        out.write_fmt(format_args!("{}", report.text(args.verbose)))?;
        if let Some(difference) = difference.filter(|d| !d.same) {
            out.write_fmt(format_args!("\n{difference}"))?;
        }
    }
    report.notes(args.engine.x_control);
    out.incomplete(prepared.replay.as_ref().is_some_and(crate::scenario::replay::Replay::is_cut));
    Ok(report.status())
}
