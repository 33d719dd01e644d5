//! `discreta run`: a circuit, its scenario, a summary, a waveform.

use std::io::IsTerminal;
use std::path::PathBuf;

use serde_json::{Value as Json, json};

use super::args::{ElaborationArgs, EngineArgs, Format, RunArgs, XControl};
use super::monitor::{SAID, say};
use super::prepare::{Changes, Prepared, cycles, prepare};
use super::progress::Progress;
use super::{CliError, Out, Status, interrupt, timing, waveforms};
use crate::Value;
use crate::circuit::{Limits, Loader};
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::engine::{EventEngine, Unsettled};
use crate::netlist::{CellId, Driver, Netlist, SignalId};
use crate::scenario::{Control, Found, Outcome, Rule, RunError, Stop};
use crate::simulator::loop_nets;
use crate::wave::Sink;

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, a circuit that does not settle, a waveform that cannot be written.
pub fn run(args: &RunArgs, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let mut loader = loader(&args.elaboration)?;
    let changes = Changes {
        parameters: &args.elaboration.parameter,
        sets: &args.set,
        clocks: &args.clock,
        cycles: args.cycles,
        time: args.time.as_deref(),
        until: args.until.as_ref(),
        trace: &args.trace,
        checking: false,
    };
    let files = waveforms::places(&args.output, &args.circuit)?;
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let prepared = faults(&mut loader, prepared)?;

    let mut sink = waveforms::open(&files)?;
    let outcome = simulate(&prepared, &loader, &args.engine, sink.as_mut().map(|s| s as &mut dyn Sink), "running")?;
    let files: Vec<PathBuf> = files.into_iter().map(|place| place.path).collect();

    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &files };
    report.warnings(args.verbose);
    // a waveform on standard output has it to itself
    if files.iter().any(|o| o.as_os_str() == "-") {
        report.stderr();
    } else if args.format.format == Format::Json {
        out.json(&report.json())?;
    } else {
        out.write_fmt(format_args!("{}", report.text(args.verbose)))?;
    }
    report.notes(args.engine.x_control);
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
    let color = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    diagnostics.render(&loader.sources, color)
}

/// Runs a scenario on the engine that the options choose, with progress.
pub(super) fn simulate(
    prepared: &Prepared,
    loader: &Loader,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    label: &str,
) -> Result<Outcome, CliError> {
    let Prepared { circuit, scenario, .. } = prepared;
    let netlist = &circuit.netlist;
    let mut engine = EventEngine::new(netlist);
    let total = (scenario.limit != u64::MAX).then_some(scenario.limit);
    let mut progress = Progress::new(label, "ticks", total);
    let mut asked = 0u32;
    let mut tell = |now: u64| {
        asked = asked.wrapping_add(1);
        if asked.is_multiple_of(1024) {
            progress.set(now);
        }
    };
    let mut said = 0u32;
    let mut message =
        |now: u64, number: usize, text: &str| say(netlist, &scenario.monitors[number], now, text, &mut said);
    let mut control = Control {
        message: &mut message,
        interrupt: interrupt::flag(),
        progress: &mut tell,
        unknown_control_ends: options.x_control == XControl::Error,
    };
    let outcome = crate::scenario::run(netlist, scenario, &mut engine, sink, &mut control);
    progress.clear();
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
    let nets = loop_nets(netlist, u);
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

/// A tick with its unit.
pub(super) fn time(netlist: &Netlist, ticks: u64) -> String {
    let t = netlist.timescale();
    format!("{} {}", u128::from(ticks) * u128::from(t.count()), t.unit().as_str())
}

/// A value as people read it: a number, signed where the circuit says so, else a literal.
pub(super) fn shown(netlist: &Netlist, signal: SignalId, value: &Value) -> String {
    let number = if netlist.signal(signal).signed {
        value.to_i64().map(|n| n.to_string())
    } else {
        value.to_u64().map(|n| n.to_string())
    };
    number.unwrap_or_else(|| value.to_string())
}

/// What there is to tell of a run.
pub(super) struct Report<'a> {
    pub prepared: &'a Prepared,
    pub loader: &'a Loader,
    pub outcome: &'a Outcome,
    pub files: &'a [PathBuf],
}

impl Report<'_> {
    /// Whether the run did what it should.
    pub fn status(&self) -> Status {
        let held = timing::hold(self.prepared, self.outcome) && self.outcome.assertions_failed == 0;
        Status::of(self.reason_is_good() && self.outcome.failures.is_empty() && held)
    }

    fn reason_is_good(&self) -> bool {
        match self.outcome.stop {
            Stop::Until => true,
            Stop::Limit => !self.prepared.scenario.limit_fails,
            Stop::Idle => self.prepared.scenario.until.is_none(),
            Stop::Interrupted | Stop::UnknownControl => false,
        }
    }

    fn until(&self) -> Option<String> {
        let netlist = &self.prepared.circuit.netlist;
        let (signal, value) = self.prepared.scenario.until.as_ref()?;
        Some(format!("{} = {}", netlist.signal_path(*signal), shown(netlist, *signal, value)))
    }

    fn reason(&self) -> String {
        let until = self.until();
        match (self.outcome.stop, until) {
            (Stop::Until, Some(until)) => format!("stopped at {until}"),
            (Stop::Limit, Some(until)) if self.prepared.scenario.limit_fails => format!("limit reached before {until}"),
            (Stop::Idle, Some(until)) => format!("nothing can change any more, and {until} has not come"),
            (Stop::Idle, None) => "nothing can change any more".into(),
            (Stop::Interrupted, _) => "interrupted".into(),
            (Stop::UnknownControl, _) => "an unknown value reached a control".into(),
            (Stop::Limit | Stop::Until, _) => "ran to the end".into(),
        }
    }

    /// A short summary.
    pub fn text(&self, verbose: bool) -> String {
        let netlist = &self.prepared.circuit.netlist;
        let clocks: Vec<String> = cycles(&self.prepared.scenario, self.outcome.time)
            .iter()
            .map(|(name, n)| format!("{n} clock{} of {name}", if *n == 1 { "" } else { "s" }))
            .collect();
        let after = if clocks.is_empty() { String::new() } else { format!(", {}", clocks.join(", ")) };
        let mut text = format!(
            "{}: {}, {}{after}\n",
            self.prepared.path.display(),
            self.reason(),
            time(netlist, self.outcome.time)
        );
        const SHOWN: usize = 24;
        let shown_outputs = if verbose { usize::MAX } else { SHOWN };
        let outputs: Vec<String> = self
            .outcome
            .outputs
            .iter()
            .take(shown_outputs)
            .map(|(s, v)| format!("{} = {}", netlist.signal(*s).name, shown(netlist, *s, v)))
            .collect();
        if !outputs.is_empty() {
            text += &format!("  {}\n", outputs.join("  "));
        }
        let more = self.outcome.outputs.len().saturating_sub(outputs.len());
        if more > 0 {
            text += &format!("  and {more} more outputs (-v shows them)\n");
        }
        if let Some(line) = timing::summary(self.prepared, self.outcome) {
            text += &format!("  {line}\n");
        }
        if verbose {
            text += &format!(
                "  engine event, {} cells, {} nets, {} net changes\n",
                netlist.cells().len(),
                netlist.nets().len(),
                self.outcome.events
            );
        }
        for file in self.files {
            text += &format!("  wrote {}\n", file.display());
        }
        text
    }

    /// Tells the summary where it is in nobody's way.
    fn stderr(&self) {
        eprint!("{}", self.text(false).replace("  wrote -\n", ""));
    }

    /// What is doubtful in the circuit and its scenario, to standard error; of the circuit only if asked for.
    fn warnings(&self, verbose: bool) {
        use std::io::Write;
        let mut told = Diagnostics::new();
        told.extend(self.loader.diagnostics.iter().filter(|d| verbose || d.code == Code::NoMatch).cloned());
        told.sort();
        let _ = write!(anstream::stderr().lock(), "{}", rendered(&told, self.loader));
    }

    /// Failed expectations and doubtful controls, to standard error.
    fn notes(&self, x_control: XControl) {
        use std::io::Write;
        let told = self.diagnostics();
        let mut to = anstream::stderr().lock();
        let _ = write!(to, "{}", rendered(&told, self.loader));
        if x_control != XControl::Ignore {
            let netlist = &self.prepared.circuit.netlist;
            const SHOWN: usize = 20;
            let kind = if x_control == XControl::Error { "error" } else { "warning" };
            for u in self.outcome.unknown_controls.iter().take(SHOWN) {
                let _ = writeln!(
                    to,
                    "{kind}[unknown-control]: at {} an unknown value reaches `{}` of `{}` by the net `{}`{}",
                    time(netlist, u.time),
                    u.pin,
                    netlist.cell_path(u.cell),
                    netlist.net_name(u.net),
                    self.place(u.cell),
                );
            }
            let more = self.outcome.unknown_controls.len().saturating_sub(SHOWN);
            if more > 0 {
                let _ = writeln!(to, "{kind}[unknown-control]: and {more} more");
            }
        }
        let failed = self.outcome.assertions_failed;
        if failed > u64::from(SAID) {
            let _ = writeln!(to, "error[assertion]: and {} more", failed - u64::from(SAID));
        }
        for &i in &self.outcome.uncovered {
            let check = &self.prepared.scenario.monitors[i];
            let source = check.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
            let _ = writeln!(to, "cover: `{}` was never reached{source}", check.name);
        }
        if self.outcome.stop == Stop::Interrupted {
            let held = if self.files.is_empty() { "" } else { "; the waveform holds everything up to there" };
            let _ = writeln!(to, "interrupted at {}{held}", time(&self.prepared.circuit.netlist, self.outcome.time));
        }
    }

    /// Where a cell stands, in brackets.
    fn place(&self, cell: CellId) -> String {
        let place = self.prepared.circuit.cell_place(cell);
        if let Some(source) = self.prepared.circuit.cell_source(cell, &self.loader.sources) {
            return format!(" ({source})");
        }
        place.map_or_else(String::new, |span| {
            let (line, column) = self.loader.sources.line_col(span);
            format!(" ({}:{line}:{column})", self.loader.sources.name(span.file))
        })
    }

    /// Failed expectations and violated timing checks with their places.
    pub fn diagnostics(&self) -> Diagnostics {
        let netlist = &self.prepared.circuit.netlist;
        let mut told = Diagnostics::new();
        for failure in &self.outcome.failures {
            let e = &self.prepared.scenario.expect[failure.expectation];
            let name = netlist.signal_path(e.signal);
            let (message, label) = match (&e.rule, &failure.found) {
                (Rule::Value(at, expected), Found::Value(found)) => {
                    let when = at.map_or_else(
                        || format!("at the end ({})", time(netlist, self.outcome.time)),
                        |t| format!("at {}", time(netlist, t)),
                    );
                    (
                        format!(
                            "`{name}` is {} {when}, not {}",
                            shown(netlist, e.signal, found),
                            shown(netlist, e.signal, expected)
                        ),
                        "expected here",
                    )
                }
                (Rule::Pulses(expected), Found::Pulses(found)) => (
                    format!("`{name}` had {found} pulse{}, not {expected}", if *found == 1 { "" } else { "s" }),
                    "expected here",
                ),
                (Rule::Value(Some(t), _), _) => (
                    format!(
                        "the run ended at {}, but `{name}` was to be looked at at {}",
                        time(netlist, self.outcome.time),
                        time(netlist, *t)
                    ),
                    "expected here",
                ),
                (Rule::Violated { check, count, first }, Found::Violations(n, found)) => {
                    let check = &self.prepared.scenario.checks[*check];
                    let at = |t: &Option<u64>| t.map_or(String::new(), |t| format!(", first at {}", time(netlist, t)));
                    let found = match n {
                        0 => "never violated".to_owned(),
                        n => format!("violated {}{}", timing::times(*n), at(found)),
                    };
                    let expected = count.map_or_else(|| "at least once".to_owned(), timing::times);
                    (
                        format!("the timing check `{}` was {found}; expected: {expected}{}", check.name, at(first)),
                        "expected here",
                    )
                }
                _ => continue,
            };
            told.push(Diagnostic::new(Code::Expectation, message).at(e.span, label));
        }
        told.extend(timing::diagnostics(self.prepared, self.outcome));
        told
    }

    /// The same for programs.
    pub fn json(&self) -> Json {
        let netlist = &self.prepared.circuit.netlist;
        let stop = match self.outcome.stop {
            Stop::Until => "until",
            Stop::Limit => "limit",
            Stop::Idle => "idle",
            Stop::Interrupted => "interrupted",
            Stop::UnknownControl => "unknown-control",
        };
        let outputs: serde_json::Map<String, Json> = self
            .outcome
            .outputs
            .iter()
            .map(|(s, v)| (netlist.signal(*s).name.clone(), json!(shown(netlist, *s, v))))
            .collect();
        let unknown: Vec<Json> = self.outcome.unknown_controls.iter().map(|u| json!({ "time": u.time, "cell": netlist.cell_path(u.cell), "pin": u.pin, "net": netlist.net_name(u.net) })).collect();
        json!({
            "circuit": self.prepared.path.display().to_string(),
            "ok": self.status() == Status::Done,
            "stop": stop,
            "time": self.outcome.time,
            "timescale": netlist.timescale().to_string(),
            "clocks": cycles(&self.prepared.scenario, self.outcome.time),
            "outputs": outputs,
            "checks": timing::to_json(self.prepared, self.outcome, &self.loader.sources),
            "failures": self.diagnostics().to_json(&self.loader.sources),
            "unknown_controls": unknown,
            "assertions_failed": self.outcome.assertions_failed,
            "uncovered": self.outcome.uncovered.iter().map(|&i| &self.prepared.scenario.monitors[i].name).collect::<Vec<_>>(),
            "events": self.outcome.events,
            "files": self.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
        })
    }
}
