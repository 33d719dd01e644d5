//! `discreta run`: a circuit, its scenario, a summary, a waveform.

use std::path::{Path, PathBuf};

use super::args::{Assignment, Format, Print, RunArgs};
use super::loading::{faults, loader};
use super::prepare::{Changes, prepare, ticks, typed};
use super::report::{Report, time as time_of};
use super::simulate::{Extras, observed};
use super::stop::Stop;
use super::told::tell;
use super::{CliError, Out, Status, contents, interrupt, save, waveforms};
use crate::Value;
use crate::circuit::Loader;
use crate::netlist::{Netlist, SignalId};
use crate::scenario::ValueText;
use crate::wave::Sink;
use crate::wave::select::Tee;
use crate::wave::window::Window;

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
    let time = |text: &Option<String>, option: &str, loader: &mut Loader| {
        text.as_deref().map(|text| ticks(&prepared.circuit, loader, option, text)).transpose()
    };
    let from = time(&args.from, "--from", &mut loader)?;
    let to = time(&args.to, "--to", &mut loader)?;
    if from.unwrap_or(0) > to.unwrap_or(u64::MAX) {
        return Err(CliError::usage("--from is after --to"));
    }
    let netlist = prepared.circuit.netlist.clone();
    let mut stop = Stop::new(&netlist, &args.stop_on)?;
    let memories = contents::memories(&netlist, &args.dump)?;
    let mut extras = Extras {
        observers: if args.stop_on.is_empty() { Vec::new() } else { vec![&mut stop] },
        forced: forced(&mut loader, &netlist, &args.force)?,
        memories: memories.into_iter().map(|cell| (cell, None)).collect(),
        raw: args.print == Print::Raw,
    };
    let mut writers = waveforms::open(&files)?;
    let mut sinks = Tee(writers.iter_mut().map(|w| &mut **w as &mut dyn Sink).collect());
    let windowed = from.is_some() || to.is_some();
    let (outcome, difference) = if files.is_empty() {
        observed(&mut prepared, &loader, &args.engine, None, &mut extras, "running")?
    } else if windowed {
        let mut window = Window::new(sinks, from.unwrap_or(0), to.unwrap_or(u64::MAX));
        observed(&mut prepared, &loader, &args.engine, Some(&mut window), &mut extras, "running")?
    } else {
        observed(&mut prepared, &loader, &args.engine, Some(&mut sinks), &mut extras, "running")?
    };
    let dumped = std::mem::take(&mut extras.memories);
    drop(extras);
    for ((cell, held), Assignment { value, .. }) in dumped.iter().zip(&args.dump) {
        contents::write(&netlist, *cell, held.as_deref(), Path::new(value))?;
    }
    if let Some((text, signal)) = &stop.hit {
        let name = signal.map_or_else(String::new, |signal| {
            let path = netlist.signal_path(signal);
            let at = time_of(&netlist, outcome.time);
            format!(
                ": `{path}` is x at {at} (`discreta why … {path} --at {at}` tells where it comes from)",
                at = at.replace(' ', "")
            )
        });
        tell!("stopped on {text}{name}\n");
    }
    let mut files: Vec<PathBuf> = files.into_iter().map(|place| place.path).collect();
    if args.save {
        files.extend(save::beside(&prepared, &files, outcome.time)?);
    }

    let difference = difference.as_ref();
    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &files, difference };
    report.warnings(args.verbose);
    // a waveform on standard output has it to itself
    if files.iter().any(|o| o.as_os_str() == "-") || args.print == Print::Raw {
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

/// The nets to hold, with their values.
fn forced(loader: &mut Loader, netlist: &Netlist, asked: &[Assignment]) -> Result<Vec<(SignalId, Value)>, CliError> {
    let mut forced = Vec::new();
    for Assignment { name, value } in asked {
        let (name, span) = typed(loader, "--force", name, value);
        let Some(signal) = netlist.find(name.value.trim_start_matches('\\')) else {
            let all: Vec<String> = netlist.signal_ids().map(|s| netlist.signal_path(s)).collect();
            let error = CliError::usage(format!("the circuit has no net `{}`", name.value));
            return Err(match crate::diag::nearest(&name.value, all.iter().map(String::as_str)) {
                Some(near) => error.with_hint(format!("did you mean `{near}`?")),
                None => error,
            });
        };
        let found = ValueText::new(value.as_str(), span).value(netlist.signal(signal).width);
        let value = found.map_err(|fault| CliError::Input(fault.render(&loader.sources, false)))?;
        forced.push((signal, value));
    }
    Ok(forced)
}
