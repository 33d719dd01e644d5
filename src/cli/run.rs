//! `discreta run`: a circuit, its scenario, a summary, a waveform.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use super::args::{EngineArgs, Format, RunArgs, XControl};
use super::prepare::{Changes, Prepared, cycles, prepare};
use super::progress::Progress;
use super::{CliError, Out, Status, interrupt};
use crate::Value;
use crate::circuit::{Limits, Loader};
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::engine::{EventEngine, Unsettled};
use crate::netlist::{Netlist, SignalId};
use crate::scenario::{Control, Found, Outcome, Rule, RunError, Scenario, Stop};
use crate::wave::Sink;
use crate::wave::output::{Destination, Output};
use crate::wave::vcd::VcdWriter;

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, a circuit that does not settle, a waveform that cannot be written.
pub fn run(args: &RunArgs, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let mut loader = Loader::new(limits(&args.elaboration.limit)?);
    let changes = Changes {
        parameters: &args.elaboration.parameter,
        sets: &args.set,
        cycles: args.cycles,
        time: args.time.as_deref(),
        until: args.until.as_ref(),
        trace: &args.trace,
    };
    for file in &args.output {
        if file.as_os_str() != "-" && file.extension().is_some_and(|e| e != "vcd") && !is_special(file) {
            let kind = file.extension().unwrap_or_default().to_string_lossy().into_owned();
            return Err(CliError::usage(format!(
                "cannot write `{}`: waveforms are written as VCD, not as {kind}",
                file.display()
            ))
            .with_hint("end the name in .vcd"));
        }
    }
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let prepared = faults(&mut loader, prepared)?;
    let Prepared { circuit, scenario, .. } = &prepared;

    let mut sinks = Sinks(Vec::new());
    for path in &args.output {
        sinks.0.push(VcdWriter::new(Box::new(Output::create(path)?)));
    }
    let sink: Option<&mut dyn Sink> = if sinks.0.is_empty() { None } else { Some(&mut sinks) };
    let outcome = simulate(&circuit.netlist, scenario, &args.engine, sink, "running")?;

    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &args.output };
    // a waveform on standard output has it to itself
    if args.output.iter().any(|o| o.as_os_str() == "-") {
        report.stderr();
    } else if args.format.format == Format::Json {
        out.json(&report.json())?;
    } else {
        out.write_fmt(format_args!("{}", report.text(args.verbose)))?;
    }
    report.notes(args.engine.x_control);
    Ok(report.status())
}

/// Whether a path leads to what is no regular file.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file())
}

/// The limits as raised on the command line.
pub(super) fn limits(changes: &[super::args::Assignment]) -> Result<Limits, CliError> {
    let mut limits = Limits::default();
    for a in changes {
        limits.set(&format!("{}={}", a.name, a.value)).map_err(CliError::usage)?;
    }
    Ok(limits)
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

/// Several waveforms at once.
struct Sinks(Vec<VcdWriter<Box<dyn Destination>>>);

impl Sink for Sinks {
    fn begin(&mut self, layout: &crate::wave::Layout) -> std::io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.begin(layout))
    }

    fn time(&mut self, now: u64) -> std::io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.time(now))
    }

    fn change(&mut self, var: usize, value: &[crate::value::Word]) {
        self.0.iter_mut().for_each(|s| s.change(var, value));
    }

    fn finish(&mut self, end: u64) -> std::io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.finish(end))
    }
}

/// Runs a scenario on the engine that the options choose, with progress.
pub(super) fn simulate(
    netlist: &Netlist,
    scenario: &Scenario,
    options: &EngineArgs,
    sink: Option<&mut dyn Sink>,
    label: &str,
) -> Result<Outcome, CliError> {
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
    let mut control = Control {
        interrupt: interrupt::flag(),
        progress: &mut tell,
        unknown_control_ends: options.x_control == XControl::Error,
    };
    let outcome = crate::scenario::run(netlist, scenario, &mut engine, sink, &mut control);
    progress.clear();
    outcome.map_err(|e| match e {
        RunError::Unsettled(u) => CliError::Input(unsettled(netlist, &u)),
        RunError::Wave(e) => e.into(),
    })
}

fn unsettled(netlist: &Netlist, u: &Unsettled) -> String {
    const SHOWN: usize = 16;
    let mut names = crate::simulator::loop_names(netlist, u);
    let more = names.len().saturating_sub(SHOWN);
    names.truncate(SHOWN);
    let path = names.join(if u.clocked { ", " } else { " → " });
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let around = if u.clocked { "these nets keep clocking each other" } else { "the loop" };
    format!(
        "error[unsettled]: at {} the circuit never settles\n  {around}: {path}{more}\n  help: break the loop by a flip-flop or a `delay`, or do not release its inputs at the same time\n",
        time(netlist, u.time)
    )
}

/// A tick with its unit.
fn time(netlist: &Netlist, ticks: u64) -> String {
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
        Status::of(self.reason_is_good() && self.outcome.failures.is_empty())
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
                    "{kind}[unknown-control]: at {} an unknown value reaches `{}` of `{}` by the net `{}`",
                    time(netlist, u.time),
                    u.pin,
                    netlist.cell_path(u.cell),
                    netlist.net_name(u.net)
                );
            }
            let more = self.outcome.unknown_controls.len().saturating_sub(SHOWN);
            if more > 0 {
                let _ = writeln!(to, "{kind}[unknown-control]: and {more} more");
            }
        }
        if self.outcome.stop == Stop::Interrupted {
            let held = if self.files.is_empty() { "" } else { "; the waveform holds everything up to there" };
            let _ = writeln!(to, "interrupted at {}{held}", time(&self.prepared.circuit.netlist, self.outcome.time));
        }
    }

    /// Failed expectations with their places.
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
                (Rule::Pulses(expected), Found::Pulses(found)) => {
                    (format!("`{name}` has {found} pulses, not {expected}"), "expected here")
                }
                (Rule::Value(Some(t), _), _) => (
                    format!(
                        "the run ended at {}, before `{name}` could be looked at, {}",
                        time(netlist, self.outcome.time),
                        time(netlist, *t)
                    ),
                    "expected here",
                ),
                _ => continue,
            };
            told.push(Diagnostic::new(Code::Expectation, message).at(e.span, label));
        }
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
            "failures": self.diagnostics().to_json(&self.loader.sources),
            "unknown_controls": unknown,
            "events": self.outcome.events,
            "files": self.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
        })
    }
}
