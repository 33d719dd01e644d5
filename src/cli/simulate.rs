//! A prepared scenario on the engine that the options choose, with progress; what is said of one that never settles.

use super::args::{EngineArgs, EngineChoice, XControl};
use super::loading::rendered;
use super::monitor::Speech;
use super::prepare::Prepared;
use super::progress::Progress;
use super::report::time;
use super::{CliError, interrupt, replay};
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::elaborate::Loader;
use crate::engine::{Engine, EngineKind, Unsettled};
use crate::netlist::{Driver, Netlist};
use crate::scenario::{Control, Observer, Outcome, Replay, RunError, Scenario};
use crate::wave::Sink;
use crate::wave::diff::Difference;

/// The engine that the options choose.
fn choose(netlist: &Netlist, choice: EngineChoice) -> Result<Box<dyn Engine>, CliError> {
    let kind = match choice {
        EngineChoice::Auto => EngineKind::Auto,
        EngineChoice::Event => EngineKind::Event,
        #[cfg(feature = "compiled")]
        EngineChoice::Compiled => EngineKind::Compiled,
    };
    kind.engine(netlist).map_err(|why| {
        CliError::usage(why.to_string())
            .with_hint("leave out --engine, or give --engine event: the results are the same")
    })
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
    observed(prepared, loader, options, sink, &mut [], label)
}

/// The same under the eyes of observers.
pub(super) fn observed(
    prepared: &mut Prepared,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    observers: &mut [&mut dyn Observer],
    label: &str,
) -> Result<(Outcome, Option<Difference>), CliError> {
    replay::compared(prepared, sink, |prepared, scenario, sink| {
        engine(prepared, scenario, loader, options, sink, observers, label)
    })
}

fn engine(
    prepared: &Prepared,
    scenario: &Scenario,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    observers: &mut [&mut dyn Observer],
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
        observers: observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer).collect(),
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
