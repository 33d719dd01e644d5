//! `discreta run`: a circuit, its scenario, a summary, a waveform.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use super::args::{Assignment, ElaborationArgs, EngineArgs, EngineChoice, Format, RunArgs, XControl};
use super::monitor::Speech;
use super::prepare::{Changes, Prepared, prepare, typed};
use super::progress::Progress;
use super::report::{Report, time};
use super::{CliError, Out, Status, interrupt, replay, save, waveforms};
use crate::circuit::{Limits, Loader};
use crate::diag::{Code, Diagnostic, Diagnostics, Sources};
#[cfg(feature = "compiled")]
use crate::engine::{AutoEngine, CompiledEngine};
use crate::engine::{Engine, EventEngine, Unsettled};
use crate::netlist::{Driver, Netlist};
use crate::scenario::{Control, Outcome, Replay, RunError, Scenario};
use crate::wave::Sink;
use crate::wave::diff::Difference;
use crate::wave::select::Tee;

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, a circuit that does not settle, a waveform that cannot be written.
pub fn run(args: &RunArgs, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let mut loader = loader(&args.elaboration)?;
    let changes = Changes {
        wave: args.wave.stimulus.is_some().then_some(&args.wave),
        ..Changes::of(&args.elaboration, &args.scenario, &args.trace)
    };
    let files = waveforms::places(args)?;
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let mut prepared = faults(&mut loader, prepared)?;

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

/// The limits as raised on the command line.
fn limits(changes: &[super::args::Assignment]) -> Result<Limits, CliError> {
    let mut limits = Limits::default();
    for a in changes {
        limits.set(&format!("{}={}", a.name, a.value)).map_err(CliError::usage)?;
    }
    Ok(limits)
}

/// A loader as the command line wants it.
pub(super) fn loader(args: &ElaborationArgs) -> Result<Loader, CliError> {
    let mut loader = Loader::new(limits(&args.limit)?);
    if let Some(top) = &args.top {
        loader.set_top(top);
    }
    // of several for one memory the last counts
    for Assignment { name, value } in args.memory.iter().rev() {
        let (name, place) = typed(&mut loader, "--memory", name, value);
        loader.fill_memory(name, Path::new(value), place);
    }
    Ok(loader)
}

/// What was prepared, if it may be run.
pub(super) fn faults<T>(loader: &mut Loader, prepared: Option<T>) -> Result<T, CliError> {
    match prepared {
        Some(prepared) if !loader.diagnostics.has_errors() => Ok(prepared),
        _ => {
            loader.diagnostics.drop_warnings(|_| true);
            loader.diagnostics.sort();
            Err(CliError::Input(rendered(&loader.diagnostics, loader)))
        }
    }
}

/// Diagnostics as they are printed to standard error.
pub(super) fn rendered(diagnostics: &Diagnostics, loader: &Loader) -> String {
    rendered_from(diagnostics, &loader.sources)
}

/// The same with the texts that they point into.
pub(super) fn rendered_from(diagnostics: &Diagnostics, sources: &Sources) -> String {
    let color = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    diagnostics.render(sources, color)
}

/// The engine that the options choose.
fn choose<'n>(netlist: &'n Netlist, choice: EngineChoice) -> Result<Box<dyn Engine + 'n>, CliError> {
    match choice {
        EngineChoice::Event => Ok(Box::new(EventEngine::new(netlist))),
        #[cfg(feature = "compiled")]
        EngineChoice::Auto => Ok(Box::new(AutoEngine::new(netlist))),
        #[cfg(not(feature = "compiled"))]
        EngineChoice::Auto => Ok(Box::new(EventEngine::new(netlist))),
        #[cfg(feature = "compiled")]
        EngineChoice::Compiled => match CompiledEngine::new(netlist) {
            Ok(engine) => Ok(Box::new(engine)),
            Err(why) => Err(CliError::usage(format!("the circuit cannot be compiled: {why}"))
                .with_hint("leave out --engine, or give --engine event: the results are the same")),
        },
    }
}

/// Runs a scenario on the engine that the options choose, with progress. Where a waveform drives it that it is to be
/// compared with, also says how it compares.
pub(super) fn simulate(
    prepared: &mut Prepared,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    label: &str,
) -> Result<(Outcome, Option<Difference>), CliError> {
    replay::compared(prepared, sink, |prepared, scenario, sink| {
        engine(prepared, scenario, loader, options, sink, label)
    })
}

fn engine(
    prepared: &Prepared,
    scenario: &Scenario,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    label: &str,
) -> Result<Outcome, CliError> {
    let netlist = &prepared.circuit.netlist;
    let feed = prepared.replay.as_ref().map(Replay::feed);
    let mut engine = choose(netlist, options.engine)?;
    let total = (scenario.limit != u64::MAX).then_some(scenario.limit);
    let mut progress = Progress::new(label, "ticks", total);
    let mut asked = 0u32;
    let mut tell = |now: u64| {
        asked = asked.wrapping_add(1);
        if asked.is_multiple_of(1024) {
            progress.set(now);
        }
    };
    let mut speech = Speech::new(netlist);
    let mut message = |now: u64, number: usize, text: &str| speech.say(&scenario.monitors[number], now, text);
    let mut control = Control {
        message: &mut message,
        interrupt: interrupt::flag(),
        progress: &mut tell,
        unknown_control_ends: options.x_control == XControl::Error,
    };
    let outcome = crate::scenario::run_with(netlist, scenario, &mut *engine, feed, sink, &mut control);
    progress.clear();
    speech.end_line();
    outcome.map_err(|e| match e {
        RunError::Unsettled(u) => {
            let mut told = Diagnostics::new();
            told.push(unsettled(prepared, &u));
            CliError::Input(rendered(&told, loader))
        }
        RunError::Wave(e) => e.into(),
    })
}

/// The loop of nets that keeps changing, with the places of the cells that drive them.
fn unsettled(prepared: &Prepared, u: &Unsettled) -> Diagnostic {
    const SHOWN: usize = 16;
    const PLACES: usize = 4;
    let netlist = &prepared.circuit.netlist;
    let nets = u.loop_nets(netlist);
    let mut names: Vec<String> = nets.iter().take(SHOWN).map(|&n| netlist.net_name(n)).collect();
    if nets.len() > SHOWN {
        names.push(format!("({} more)", nets.len() - SHOWN));
    } else if !u.clocked {
        names.extend(names.first().cloned());
    }
    let time = time(netlist, u.time);
    let d = Diagnostic::new(Code::Unsettled, format!("at {time} the circuit never settles"));
    let d = match u.clocked {
        false => d.note(format!("the loop is {}", names.join(" → "))),
        true => d.note(format!("these nets keep clocking each other: {}", names.join(", "))),
    };
    let placed = nets.iter().filter_map(|&net| match netlist.net(net).driver {
        Driver::Cell(cell, _) => Some((prepared.circuit.cell_place(cell)?, netlist.net_name(net))),
        Driver::Input(_) => None,
    });
    let d = placed.take(PLACES).enumerate().fold(d, |d, (i, (place, name))| {
        let text = format!("drives `{name}`");
        if i == 0 { d.at(place, text) } else { d.also(place, text) }
    });
    d.help("break the loop by a flip-flop or a `delay`, or do not release its inputs at the same time")
}
