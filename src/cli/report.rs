//! What is told of a run: a summary for people or for programs, and what went wrong on standard error.

use std::path::PathBuf;

use serde_json::{Value as Json, json};

use super::args::XControl;
use super::loading::rendered;
use super::monitor::SAID;
use super::prepare::{Prepared, cycles};
use super::told::{styled, tell};
use super::{Status, timing};
use crate::Value;
use crate::circuit::Loader;
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::netlist::{CellId, Netlist, SignalId};
use crate::scenario::{AssertionFailure, Found, Outcome, Replay, Rule, Stop};
use crate::wave::diff::Difference;

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

/// The same, and what the circuit calls it.
fn named(netlist: &Netlist, signal: SignalId, value: &Value) -> String {
    let number = shown(netlist, signal, value);
    match netlist.signal(signal).values.as_ref().and_then(|names| names.of(value)) {
        Some(name) => format!("{number} ({name})"),
        None => number,
    }
}

/// What there is to tell of a run.
pub(super) struct Report<'a> {
    pub prepared: &'a Prepared,
    pub loader: &'a Loader,
    pub outcome: &'a Outcome,
    pub files: &'a [PathBuf],
    /// How it compares with the waveform that drove it, if that was asked for.
    pub difference: Option<&'a Difference>,
}

impl Report<'_> {
    /// Whether the run did what it should.
    pub fn status(&self) -> Status {
        let held = timing::hold(self.prepared, self.outcome) && self.outcome.assertions_failed == 0;
        let same = self.difference.is_none_or(|d| d.same);
        Status::of(self.reason_is_good() && self.outcome.failures.is_empty() && held && same)
    }

    fn reason_is_good(&self) -> bool {
        match self.outcome.stop {
            Stop::Until | Stop::Observed => true,
            Stop::Limit => !self.prepared.scenario.limit_fails,
            Stop::Idle => self.prepared.scenario.until.is_none(),
            Stop::Interrupted | Stop::UnknownControl => false,
        }
    }

    fn until(&self) -> Option<String> {
        let netlist = &self.prepared.circuit.netlist;
        let (signal, value) = self.prepared.scenario.until.as_ref()?;
        Some(format!("{} = {}", netlist.signal_path(*signal), named(netlist, *signal, value)))
    }

    fn reason(&self) -> String {
        let until = self.until();
        match (self.outcome.stop, until) {
            (Stop::Until, Some(until)) => format!("stopped at {until}"),
            (Stop::Limit, Some(until)) if self.prepared.scenario.limit_fails => format!("limit reached before {until}"),
            (Stop::Idle, Some(until)) => format!("nothing can change any more, and {until} has not come"),
            (Stop::Idle, None) => "nothing can change any more".into(),
            (Stop::Observed, _) => "stopped where it was to".into(),
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
            .map(|(s, v)| format!("{} = {}", netlist.signal(*s).name, named(netlist, *s, v)))
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
                "  {} cells, {} nets\n  {}\n",
                netlist.cells().len(),
                netlist.nets().len(),
                self.outcome.engine
            );
        }
        if let Some(replay) = &self.prepared.replay {
            text += &compared(replay, self.difference);
        }
        for file in self.files {
            text += &format!("  wrote {}\n", file.display());
        }
        text
    }

    /// Tells the summary where it is in nobody's way.
    pub fn stderr(&self) {
        tell!("{}", self.text(false).replace("  wrote -\n", ""));
    }

    /// What is doubtful in the circuit and its scenario, to standard error; of the circuit only if asked for.
    pub fn warnings(&self, verbose: bool) {
        let mut told = Diagnostics::new();
        told.extend(
            self.loader
                .diagnostics
                .iter()
                .filter(|d| verbose || matches!(d.code, Code::NoMatch | Code::AmbiguousOrder | Code::DoubtfulWave))
                .cloned(),
        );
        told.sort();
        styled(&rendered(&told, self.loader));
    }

    /// Failed expectations and doubtful controls, to standard error.
    pub fn notes(&self, x_control: XControl) {
        let told = self.diagnostics();
        styled(&rendered(&told, self.loader));
        if x_control != XControl::Ignore {
            let netlist = &self.prepared.circuit.netlist;
            const SHOWN: usize = 20;
            let kind = if x_control == XControl::Error { "error" } else { "warning" };
            for u in self.outcome.unknown_controls.iter().take(SHOWN) {
                tell!(
                    "{kind}[unknown-control]: at {} an unknown value reaches `{}` of `{}` by the net `{}`{}\n",
                    time(netlist, u.time),
                    u.pin,
                    netlist.cell_path(u.cell),
                    netlist.net_name(u.net),
                    self.place(u.cell),
                );
            }
            let more = self.outcome.unknown_controls.len().saturating_sub(SHOWN);
            if more > 0 {
                tell!("{kind}[unknown-control]: and {more} more\n");
            }
        }
        let failed = self.outcome.assertions_failed;
        if failed > u64::from(SAID) {
            tell!("error[assertion]: and {} more\n", failed - u64::from(SAID));
        }
        for &i in &self.outcome.uncovered {
            let check = &self.prepared.scenario.monitors[i];
            let source = check.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
            tell!("cover: `{}` was never reached{source}\n", check.name);
        }
        if self.outcome.stop == Stop::Interrupted {
            let held = if self.files.is_empty() { "" } else { "; the waveform holds everything up to there" };
            tell!("interrupted at {}{held}\n", time(&self.prepared.circuit.netlist, self.outcome.time));
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
                            named(netlist, e.signal, found),
                            named(netlist, e.signal, expected)
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
                        "the run ended at {}, but `{name}` was to be checked at {}",
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

    /// The assertions that failed, for programs.
    fn assertions(&self) -> Vec<Json> {
        let one = |failed: &AssertionFailure| {
            let monitor = &self.prepared.scenario.monitors[failed.monitor];
            let values: serde_json::Map<String, Json> =
                failed.operands.iter().map(|(name, value)| (name.clone(), json!(value.to_string()))).collect();
            json!({ "time": failed.time, "name": monitor.name, "message": failed.text, "values": values,
                    "source": monitor.source })
        };
        self.outcome.assertions.iter().map(one).collect()
    }

    /// Where they stand in the source, as far as that is known.
    pub fn assertion_places(&self) -> Vec<super::test::Place> {
        let lines = self.failed_assertions();
        let place = |(failed, line): (&AssertionFailure, &str)| {
            let source = self.prepared.scenario.monitors[failed.monitor].source.as_ref()?;
            let (file, rest) = source.split('|').next()?.rsplit_once(':')?;
            let (line_number, column) = rest.split('-').next()?.split_once('.').unwrap_or((rest, "1"));
            Some(super::test::Place {
                file: file.to_owned(),
                line: line_number.parse().ok()?,
                column: column.parse().ok()?,
                message: line.to_owned(),
            })
        };
        self.outcome.assertions.iter().zip(lines.lines()).filter_map(place).collect()
    }

    /// The same for people, a line each.
    pub fn failed_assertions(&self) -> String {
        let netlist = &self.prepared.circuit.netlist;
        let mut text = String::new();
        for failed in &self.outcome.assertions {
            let monitor = &self.prepared.scenario.monitors[failed.monitor];
            let values: Vec<String> = failed.operands.iter().map(|(name, value)| format!("{name} = {value}")).collect();
            let values = if values.is_empty() { String::new() } else { format!(" [{}]", values.join(", ")) };
            let colon = if failed.text.is_empty() { "" } else { ": " };
            let source = monitor.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
            let at = time(netlist, failed.time);
            text += &format!("assertion `{}` fails at {at}{colon}{}{values}{source}\n", monitor.name, failed.text);
        }
        text
    }

    /// The same for programs.
    pub fn json(&self) -> Json {
        let netlist = &self.prepared.circuit.netlist;
        let stop = match self.outcome.stop {
            Stop::Until => "until",
            Stop::Limit => "limit",
            Stop::Idle => "idle",
            Stop::Observed => "observed",
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
        let stimulus = self.prepared.replay.as_ref().map(|replay| {
            let inputs: Vec<&str> = replay.inputs().map(|s| netlist.signal(s).name.as_str()).collect();
            json!({ "wave": replay.path().display().to_string(), "scope": replay.scope(), "inputs": inputs })
        });
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
            "assertions": self.assertions(),
            "uncovered": self.outcome.uncovered.iter().map(|&i| &self.prepared.scenario.monitors[i].name).collect::<Vec<_>>(),
            "events": self.outcome.events,
            "engine": self.outcome.engine,
            "stimulus": stimulus,
            "difference": self.difference,
            "files": self.files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
        })
    }
}

/// The waveform that drove a run, and how the two compare, for the summary.
fn compared(replay: &Replay, difference: Option<&Difference>) -> String {
    let place = match replay.scope() {
        "" => replay.path().display().to_string(),
        scope => format!("{scope} in {}", replay.path().display()),
    };
    let count = |n: u64, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    match difference {
        None => format!("  inputs as {place}\n"),
        Some(d) => {
            let verdict = if d.same { "the same as" } else { "not the same as" };
            let (nets, values) = (count(d.compared as u64, "net"), count(d.values, "value"));
            format!("  {verdict} {place}: {nets}, {values} compared\n")
        }
    }
}
