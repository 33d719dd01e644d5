//! When a run ends.

use super::{DEFAULT_CYCLES, Resolver, Scenario};
use crate::Value;
use crate::cell::{CellKind, Clock};
use crate::diag::{Code, Diagnostic};
use crate::netlist::SignalId;
use crate::scenario::replay::Replay;
use crate::syntax::Expr;
use crate::syntax::scenario::{Limit, Until};

/// The last tick of so many cycles: they end with the falling edge of the last, or before the first rising one.
fn last_of(cycles: u64, c: Clock) -> u64 {
    match cycles.checked_sub(1) {
        Some(before) => before.saturating_mul(c.period).saturating_add(c.phase).saturating_add(c.high),
        None => c.phase.saturating_sub(1),
    }
}

impl Resolver<'_> {
    pub(super) fn until(&mut self, until: &Until) -> Option<(SignalId, Value)> {
        let signal = self.signal(&until.net)?;
        let width = self.netlist.signal(signal).width;
        let value = match &until.value {
            Some(value) => self.value(value, width)?,
            None => Value::from_u64(1, width),
        };
        Some((signal, value))
    }

    /// The last tick. `clock` is the first clock, if it has no fault; `clocked` whether the scenario has one.
    pub(super) fn limit(&mut self, limit: Option<&Limit>, clock: Option<crate::cell::Clock>, clocked: bool) -> u64 {
        let own = self.netlist.cells().iter().find_map(|c| match c.kind {
            CellKind::Clock(clock) => Some(clock),
            _ => None,
        });
        let clock = clock.or(own);
        let mut last = None;
        if let Some(time) = limit.and_then(|l| l.time.as_ref()) {
            last = self.ticks(time);
        }
        if let Some(cycles) = limit.and_then(|l| l.cycles.as_ref())
            && let Some(n) = self.ok(cycles.eval(&self.circuit.parameters))
        {
            match (u64::try_from(n), clock) {
                (Ok(n), Some(clock)) => last = Some(last.unwrap_or(u64::MAX).min(last_of(n, clock))),
                (Err(_), _) => self.no_cycles(n, cycles),
                // its fault is told
                (_, None) if clocked => {}
                (_, None) => {
                    let clock = Resolver::clocked_by_inputs(self.netlist)
                        .next()
                        .map(|(_, input)| &self.netlist.signal(input).name);
                    let help = match clock {
                        Some(name) => format!("drive one: `--clock {name}=10ns`; or limit the run with `time`"),
                        None => "limit the run with `time`".to_owned(),
                    };
                    self.diagnostics.push(
                        Diagnostic::new(Code::BadScenario, "there is no clock whose cycles could be counted")
                            .at(cycles.span(), "")
                            .help(help),
                    );
                }
            }
        }
        last.unwrap_or_else(|| clock.map_or(DEFAULT_CYCLES, |c| last_of(DEFAULT_CYCLES, c)))
    }

    /// The last tick where a waveform drives the inputs: its own, or an earlier one that was asked for.
    pub(super) fn limit_of(&mut self, replay: &Replay, limit: Option<&Limit>, scenario: &Scenario) -> u64 {
        let timescale = self.netlist.timescale();
        let end = replay.end();
        let mut last = end;
        if let Some(text) = limit.and_then(|l| l.time.as_ref())
            && let Some(time) = self.ticks(text)
        {
            if time > end {
                let fault = format!("the waveform ends at {}, before {}", timescale.time(end), timescale.time(time));
                self.diagnostics.push(
                    Diagnostic::new(Code::BadScenario, fault)
                        .at(text.span(), "there is nothing to drive the inputs then")
                        .help("leave this out to run to its end"),
                );
            }
            last = last.min(time);
        }
        if let Some(cycles) = limit.and_then(|l| l.cycles.as_ref())
            && let Some(n) = self.ok(cycles.eval(&self.circuit.parameters))
        {
            let Ok(count) = u64::try_from(n) else {
                self.no_cycles(n, cycles);
                return last;
            };
            let found = match scenario.clocks.first() {
                Some(c) => Some(last_of(count, c.clock)).filter(|&t| t <= end).ok_or((c.name.as_str(), None)),
                None => match replay.clock() {
                    Some(clock) => replay.last_of(clock, count).map_err(|had| (clock.name.as_str(), Some(had))),
                    None => {
                        self.diagnostics.push(
                            Diagnostic::new(Code::BadScenario, "there is no clock whose cycles could be counted")
                                .at(cycles.span(), "")
                                .help("limit the run with `time`"),
                        );
                        return last;
                    }
                },
            };
            match found {
                Ok(time) => last = last.min(time),
                Err((name, had)) => {
                    let had = had.map_or(String::new(), |n| format!(", after {n} whole cycles of it"));
                    let fault = format!("the waveform ends before {count} cycles of `{name}`{had}");
                    self.diagnostics.push(
                        Diagnostic::new(Code::BadScenario, fault)
                            .at(cycles.span(), "")
                            .help("leave this out to run to its end"),
                    );
                }
            }
        }
        last
    }

    fn no_cycles(&mut self, n: i64, cycles: &Expr) {
        let fault = Diagnostic::new(Code::BadScenario, format!("a run cannot take {n} cycles"));
        self.diagnostics.push(fault.at(cycles.span(), ""));
    }
}
