//! A prepared scenario on the engine that the options choose, with progress; what is said of one that never settles.

use super::args::{EngineArgs, EngineChoice, XControl};
use super::loading::rendered;
use super::monitor::Speech;
use super::prepare::Prepared;
use super::progress::Progress;
use super::report::time;
use super::{CliError, interrupt, replay};
use crate::Value;
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::elaborate::Loader;
use crate::engine::{Engine, EngineKind, Unsettled};
use crate::netlist::{CellId, Driver, Netlist, SignalId};
use crate::scenario::{Control, Observer, Outcome, Replay, RunError, Scenario};
use crate::value::Word;
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
    observed(prepared, loader, options, sink, &mut Extras::default(), label)
}

/// What else a run is to do.
#[derive(Default)]
pub(super) struct Extras<'e> {
    /// What looks at values.
    pub observers: Vec<&'e mut dyn Observer>,
    /// Nets to hold.
    pub forced: Vec<(SignalId, Value)>,
    /// Memories whose contents are wanted, and what they are at the end.
    pub memories: Vec<(CellId, Option<Vec<Word>>)>,
    /// Whether what the circuit prints goes to standard output as it is.
    pub raw: bool,
}

/// The same with extras.
pub(super) fn observed(
    prepared: &mut Prepared,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    extras: &mut Extras<'_>,
    label: &str,
) -> Result<(Outcome, Option<Difference>), CliError> {
    replay::compared(prepared, sink, |prepared, scenario, sink| {
        engine(prepared, scenario, loader, options, sink, extras, label)
    })
}

fn engine(
    prepared: &Prepared,
    scenario: &Scenario,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    extras: &mut Extras<'_>,
    label: &str,
) -> Result<Outcome, CliError> {
    let netlist = &prepared.circuit.netlist;
    let feed = prepared.replay.as_ref().map(Replay::feed);
    let mut engine = choose(netlist, options.engine)?;
    for (signal, value) in &extras.forced {
        let mut at = 0;
        for slice in netlist.bits(*signal) {
            let mut part = Value::unknown(slice.width);
            (0..slice.width).for_each(|bit| part.set_bit(bit, value.bit(at + bit)));
            at += slice.width;
            let words: Vec<Word> = part.words().collect();
            engine.force(*slice, &words).map_err(|why| CliError::usage(why.text(netlist)))?;
        }
    }
    let total = (scenario.limit != u64::MAX).then_some(scenario.limit);
    let mut progress = Progress::new(label, "ticks", total);
    let mut asked = 0u32;
    let mut tell = |now: u64| {
        asked = asked.wrapping_add(1);
        if asked.is_multiple_of(1024) {
            progress.set(now);
        }
    };
    let mut speech = Speech::new(netlist, extras.raw);
    let mut message = |now: u64, number: usize, text: &str| speech.say(&scenario.monitors[number], now, text);
    let mut control = Control {
        message: &mut message,
        interrupt: interrupt::flag(),
        progress: &mut tell,
        unknown_control_ends: options.x_control == XControl::Error,
        observers: extras.observers.iter_mut().map(|observer| &mut **observer as &mut dyn Observer).collect(),
    };
    let outcome = crate::scenario::run_with(netlist, scenario, &mut *engine, feed, sink, &mut control);
    for (cell, contents) in &mut extras.memories {
        *contents = engine.contents(*cell).map(<[Word]>::to_vec);
    }
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
