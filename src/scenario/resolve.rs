//! A scenario with its names resolved: what drives which net when, what is watched, when it ends (`end`), what is expected
//! (`expect`).

mod end;
mod expect;

use std::collections::HashSet;

use super::check::TimingCheck;
use super::glob::{DOT, glob_path, glob_set};
use super::replay::Replay;
use crate::Value;
use crate::diag::{Code, Diagnostic, Diagnostics, Span};
use crate::elaborate::Circuit;
use crate::import::yosys::Monitor;
use crate::json::{Recover, Spanned};
use crate::netlist::{CellId, Driver, NetId, Netlist, SignalId};
use crate::syntax::scenario::{Clock, Edge, Simulation, Stimulus, ValueText};
use crate::syntax::stimulus::Stimuli;
use crate::syntax::{Expr, Name};

/// Cycles that a run takes at most if nothing is said.
pub const DEFAULT_CYCLES: u64 = 1_000_000;

/// Changes of inputs at one tick.
#[derive(Clone, Debug)]
pub struct Event {
    /// The tick at which they change, after the clocks of that tick.
    pub time: u64,
    /// Inputs and their new values; of two for one input, the later wins.
    pub sets: Vec<(NetId, Value)>,
}

/// What must hold.
#[derive(Clone, Debug)]
pub enum Rule {
    /// The signal has this value at a tick, or at the end.
    Value(Option<u64>, Value),
    /// Bit 0 rose from 0 to 1 so many times.
    Pulses(u64),
    /// A timing check was violated.
    Violated {
        /// Its number in [`Scenario::checks`]; the signal of the expectation is its net.
        check: usize,
        /// How many times; none: at least once.
        count: Option<u64>,
        /// The tick of the first violation, if that matters.
        first: Option<u64>,
    },
}

/// An expectation.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// The signal that it is about.
    pub signal: SignalId,
    /// What must hold of it.
    pub rule: Rule,
    /// Where it is written.
    pub span: Span,
}

/// A clock of the scenario.
#[derive(Clone, Debug)]
pub struct DrivenClock {
    /// The input's name, as the scenario writes it.
    pub name: String,
    /// The net that it drives.
    pub net: NetId,
    /// Period, high time and phase in ticks.
    pub clock: crate::cell::Clock,
}

/// A scenario ready to run on one netlist.
#[derive(Clone, Debug, Default)]
pub struct Scenario {
    /// Inputs that are clocks, the first of which counts the cycles.
    pub clocks: Vec<DrivenClock>,
    /// Inputs held from tick 0.
    pub inputs: Vec<(NetId, Value)>,
    /// What changes when, in order of time.
    pub stimulus: Vec<Event>,
    /// Stop when the signal has the value.
    pub until: Option<(SignalId, Value)>,
    /// The last tick that runs.
    pub limit: u64,
    /// Whether the last tick was asked for, rather than being the default.
    pub limit_given: bool,
    /// Whether a run that gets to the last tick has failed: there is an `until`, and no `--cycles` or `--time`.
    pub limit_fails: bool,
    /// The signals that a waveform holds, in the order of the netlist.
    pub trace: Vec<SignalId>,
    /// Timing checks: what must hold at every tick.
    pub checks: Vec<TimingCheck>,
    /// What must hold at the end or at one tick.
    pub expect: Vec<Expectation>,
    /// What the circuit itself says and asserts.
    pub monitors: Vec<Monitor>,
}

impl Simulation {
    /// This scenario where it says something, `base` where it does not.
    #[must_use]
    pub fn over(&self, base: &Simulation) -> Simulation {
        let mut merged = base.clone();
        if self.wave().is_some() {
            // a waveform is what happens, from beginning to end; what must hold at all times stays
            let violated = |name: &Name| {
                base.expect.iter().flatten().filter_map(Recover::as_ref).any(|e| e.check.as_ref() == Some(name))
            };
            merged.checks.retain(|name, _| !violated(name));
            let Simulation { trace, checks, .. } = merged;
            merged = Simulation { trace, checks, ..Simulation::default() };
        }
        // what was a clock may be held, and the other way round
        merged.clocks.retain(|name, _| !self.inputs.contains_key(name));
        merged.inputs.retain(|name, _| !self.clocks.contains_key(name));
        merged.clocks.extend(self.clocks.clone());
        merged.inputs.extend(self.inputs.clone());
        merged.checks.extend(self.checks.clone());
        let Simulation { stimulus, until, limit, trace, expect, .. } = self.clone();
        merged.stimulus = stimulus.or(merged.stimulus);
        merged.until = until.or(merged.until);
        merged.limit = limit.or(merged.limit);
        merged.trace = trace.or(merged.trace);
        merged.expect = expect.or(merged.expect);
        merged
    }
}

impl Scenario {
    /// Whether an expectation says that a timing check is violated.
    #[must_use]
    pub fn expects(&self, check: usize) -> bool {
        self.expect.iter().any(|e| matches!(e.rule, Rule::Violated { check: c, .. } if c == check))
    }

    /// Resolves a scenario against a circuit; every fault goes into `diagnostics`. What is faulty is left out.
    #[must_use]
    pub fn resolve(circuit: &Circuit, simulation: &Simulation, diagnostics: &mut Diagnostics) -> Scenario {
        Scenario::resolve_with(circuit, simulation, None, diagnostics)
    }

    /// The same for a scenario that a waveform drives.
    #[must_use]
    pub fn resolve_with(
        circuit: &Circuit,
        simulation: &Simulation,
        replay: Option<&Replay>,
        diagnostics: &mut Diagnostics,
    ) -> Scenario {
        let before = diagnostics.errors();
        let mut r = Resolver { circuit, netlist: &circuit.netlist, diagnostics };
        let mut scenario = Scenario { monitors: circuit.monitors.clone(), ..Scenario::default() };
        for (name, clock) in &simulation.clocks {
            let Some(clock) = clock.as_ref() else { continue };
            if let (Some((net, _)), Some(clock)) = (r.input(name), r.clock(name, clock)) {
                scenario.clocks.push(DrivenClock { name: name.value.clone(), net, clock });
            }
        }
        for (name, value) in &simulation.inputs {
            if simulation.clocks.contains_key(name.value.as_str()) {
                r.diagnostics.push(
                    Diagnostic::new(
                        Code::BadScenario,
                        format!("`{}` is both a clock and an input with a value", name.value),
                    )
                    .at(name.span, "leave one of them out"),
                );
                continue;
            }
            let value = value.as_ref();
            if let (Some((net, signal)), Some(value)) = (r.input(name), value) {
                scenario.inputs.extend(r.given(value, signal).map(|v| (net, v)));
            }
        }
        for stimulus in simulation.changes() {
            let sets = r.sets(stimulus, simulation);
            if let Some(time) = r.when(stimulus, simulation) {
                scenario.stimulus.push(Event { time, sets });
            }
        }
        scenario.stimulus.sort_by_key(|e| e.time);
        if let Some(until) = simulation.until.as_ref().and_then(Recover::as_ref) {
            scenario.until = r.until(until);
        }
        let limit = simulation.limit.as_ref().and_then(Recover::as_ref);
        scenario.limit = match replay {
            Some(replay) => r.limit_of(replay, limit, &scenario),
            None => r.limit(limit, scenario.clocks.first().map(|c| c.clock), !simulation.clocks.is_empty()),
        };
        scenario.limit_given = limit.is_some() || replay.is_some();
        scenario.limit_fails = scenario.until.is_some();
        scenario.trace = r.trace(simulation.trace.as_deref());
        for (name, check) in &simulation.checks {
            let Some(check) = check.as_ref() else { continue };
            scenario.checks.extend(TimingCheck::resolve(&mut r, name, check));
        }
        for expect in simulation.expect.iter().flatten().filter_map(Recover::as_ref) {
            let expectation = r.expect(expect, simulation, &scenario);
            scenario.expect.extend(expectation);
        }
        // what is faulty may be what drives them
        let all_whole = |s: &Stimuli| s.changes().iter().all(|s| s.as_ref().is_some());
        let whole = simulation.clocks.values().all(|c| c.as_ref().is_some())
            && simulation.stimulus.as_ref().is_none_or(|s| s.as_ref().is_some_and(all_whole));
        if whole && r.diagnostics.errors() == before {
            r.undriven_clocks(&scenario, replay);
        }
        scenario
    }
}

/// Looks names up and computes times, telling of what is faulty.
pub(super) struct Resolver<'a> {
    circuit: &'a Circuit,
    netlist: &'a Netlist,
    diagnostics: &'a mut Diagnostics,
}

impl Resolver<'_> {
    fn ok<T>(&mut self, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|d| self.diagnostics.push(d)).ok()
    }

    /// Tells of a fault, where a result was wanted.
    pub fn fault<T>(&mut self, fault: Diagnostic) -> Option<T> {
        self.diagnostics.push(fault);
        None
    }

    /// The bits of a signal.
    pub fn width(&self, signal: SignalId) -> u32 {
        self.netlist.signal(signal).width
    }

    /// The value of an expression.
    pub fn number(&mut self, expr: &Expr) -> Option<i64> {
        self.ok(expr.eval(&self.circuit.parameters))
    }

    /// The signal of a name.
    pub fn signal(&mut self, name: &Name) -> Option<SignalId> {
        let found = self.netlist.find(name);
        if found.is_none() {
            let all: Vec<String> = self.netlist.signal_ids().map(|s| self.netlist.signal_path(s)).collect();
            let fault = Diagnostic::new(Code::UnknownNet, format!("the circuit has no net `{}`", name.value))
                .at(name.span, "not in the circuit");
            self.diagnostics.push(
                fault
                    .did_you_mean(name, all.iter().map(String::as_str))
                    .help("a net is named by its path below the top module, as in `adder.fa[3].s`"),
            );
        }
        found
    }

    /// The net that drives an input, and its signal.
    fn input(&mut self, name: &Name) -> Option<(NetId, SignalId)> {
        let id = self.signal(name)?;
        let signal = self.netlist.signal(id);
        if signal.drive.is_none() {
            let inputs: Vec<&str> =
                self.netlist.signals().iter().filter(|s| s.drive.is_some()).map(|s| s.name.as_str()).collect();
            let fault = Diagnostic::new(Code::BadScenario, format!("`{}` is not an input of the circuit", name.value))
                .at(name.span, "the circuit drives it itself");
            self.diagnostics.push(fault.note(format!("the inputs are {}", inputs.join(", "))));
        }
        Some((signal.drive?, id))
    }

    /// A value that an input is set to.
    fn given(&mut self, text: &ValueText, signal: SignalId) -> Option<Value> {
        let signal = self.netlist.signal(signal);
        self.ok(text.given(signal.width, signal.signed))
    }

    fn value(&mut self, text: &ValueText, width: u32) -> Option<Value> {
        self.ok(text.value(width))
    }

    /// A time in ticks.
    pub fn ticks(&mut self, time: &super::TimeText) -> Option<u64> {
        self.ok(time.ticks(self.netlist.timescale(), &self.circuit.parameters))
    }

    fn clock(&mut self, name: &Name, clock: &Clock) -> Option<crate::cell::Clock> {
        let period = self.ticks(&clock.period)?;
        let fault = |message: String, span| Diagnostic::new(Code::BadScenario, message).at(span, "");
        if period < 2 {
            self.diagnostics.push(
                fault(
                    format!(
                        "the clock `{}` has a period of {period} tick{}; it needs two or more",
                        name.value,
                        if period == 1 { "" } else { "s" }
                    ),
                    clock.period.span(),
                )
                .help("choose a finer `timescale`"),
            );
            return None;
        }
        let (high, span) = match (&clock.high, &clock.duty) {
            (Some(high), _) => (self.ticks(high)?, high.span()),
            (None, Some(duty)) => (self.ok(duty.of(period))?, duty.span()),
            (None, None) => (period / 2, clock.period.span()),
        };
        if high == 0 || high >= period {
            self.diagnostics.push(
                fault(format!("the clock `{}` would be high for {high} of {period} ticks", name.value), span)
                    .help("it must be high for at least one tick, and low for at least one"),
            );
            return None;
        }
        let phase = match &clock.phase {
            Some(phase) => self.ticks(phase)?,
            None => period - high,
        };
        Some(crate::cell::Clock { period, high, phase })
    }

    fn sets(&mut self, stimulus: &Stimulus, simulation: &Simulation) -> Vec<(NetId, Value)> {
        let mut sets = Vec::new();
        for (name, value) in &stimulus.set {
            if simulation.clocks.contains_key(name.value.as_str()) {
                self.diagnostics.push(
                    Diagnostic::new(Code::BadScenario, format!("`{}` is a clock", name.value))
                        .at(name.span, "a stimulus cannot set it"),
                );
            } else if let Some((net, signal)) = self.input(name) {
                sets.extend(self.given(value, signal).map(|v| (net, v)));
            }
        }
        sets
    }

    fn when(&mut self, stimulus: &Stimulus, simulation: &Simulation) -> Option<u64> {
        if let Some(at) = &stimulus.at {
            return self.ticks(at);
        }
        let on = stimulus.on.as_ref()?;
        let Some(clock) = simulation.clocks.get(on.clock.value.as_str()) else {
            let names = simulation.clocks.keys().map(|n| n.value.as_str());
            let fault = Diagnostic::new(Code::UnknownClock, format!("the scenario has no clock `{}`", on.clock.value))
                .at(on.clock.span, "not among its `clocks`");
            self.diagnostics.push(fault.did_you_mean(&on.clock, names));
            return None;
        };
        let clock = self.clock(&on.clock, clock.as_ref()?)?;
        let (count, span) = match &on.count {
            Some(count) => (self.ok(count.eval(&self.circuit.parameters))?, count.span()),
            None => (1, on.clock.span),
        };
        let edge = on.edge.as_ref().map_or(Edge::Rising, |e| e.value);
        let offset = if edge == Edge::Falling { clock.high } else { 0 };
        let time = u64::try_from(count - 1)
            .ok()
            .and_then(|n| n.checked_mul(clock.period)?.checked_add(clock.phase)?.checked_add(offset));
        if time.is_none() {
            self.diagnostics.push(
                Diagnostic::new(Code::BadScenario, format!("there is no edge number {count}"))
                    .at(span, "edges count from 1"),
            );
        }
        time
    }

    fn trace(&mut self, globs: Option<&[Spanned<String>]>) -> Vec<SignalId> {
        let all = self.netlist.signal_ids();
        let Some(globs) = globs else { return all.filter(|&s| !self.netlist.signal(s).hidden).collect() };
        let paths: Vec<String> = all.map(|s| glob_path(self.netlist, s)).collect();
        let mut chosen = HashSet::new();
        for glob in globs {
            match glob_set(glob) {
                Ok(set) => {
                    let before = chosen.len();
                    // names that a tool made up have a `$`, and so has a pattern that asks for them
                    let asked = glob.value.contains('$');
                    let shown = |i: usize| asked || !self.netlist.signals()[i].hidden;
                    let matching: Vec<usize> =
                        (0..paths.len()).filter(|&i| shown(i) && set.is_match(&paths[i])).collect();
                    let none = matching.is_empty();
                    chosen.extend(matching);
                    if none && before == chosen.len() {
                        let names: Vec<String> = paths.iter().map(|p| p.replace(['/', DOT], ".")).collect();
                        let fault = Diagnostic::new(Code::NoMatch, format!("`{}` matches no net", glob.value))
                            .at(glob.span, "");
                        self.diagnostics.push(fault.did_you_mean(glob, names.iter().map(String::as_str)));
                    }
                }
                Err(why) => self.diagnostics.push(
                    Diagnostic::new(Code::BadGlob, format!("`{}` is not a pattern for nets: {why}", glob.value))
                        .at(glob.span, ""),
                ),
            }
        }
        self.netlist.signal_ids().filter(|s| chosen.contains(&s.index())).collect()
    }

    /// Clocked cells and the inputs that clock them, through buffers and inverters at most.
    fn clocked_by_inputs(netlist: &Netlist) -> impl Iterator<Item = (CellId, SignalId)> + '_ {
        let clocks = netlist.cell_ids().flat_map(|cell| netlist.clock_sources(cell).map(move |c| (cell, c.0)));
        clocks.filter_map(|(cell, clock)| match netlist.net(clock.net).driver {
            Driver::Input(input) => Some((cell, input)),
            Driver::Cell(..) => None,
        })
    }

    /// Tells of inputs that clock something and that the scenario never drives.
    fn undriven_clocks(&mut self, scenario: &Scenario, replay: Option<&Replay>) {
        let driven: HashSet<NetId> = scenario
            .clocks
            .iter()
            .map(|c| c.net)
            .chain(scenario.inputs.iter().map(|i| i.0))
            .chain(scenario.stimulus.iter().flat_map(|e| &e.sets).map(|s| s.0))
            .chain(replay.into_iter().flat_map(Replay::driven))
            .collect();
        let mut told = HashSet::new();
        let netlist = self.netlist;
        for (cell, input) in Resolver::clocked_by_inputs(netlist) {
            if netlist.signal(input).drive.is_some_and(|net| driven.contains(&net)) || !told.insert(input) {
                continue;
            }
            let name = &self.netlist.signal(input).name;
            let fault = Diagnostic::new(
                Code::UndrivenClock,
                format!("nothing drives `{name}`, the clock of `{}`", self.netlist.cell_path(cell)),
            );
            let fault = fault.at(self.circuit.place(input), "an input that the scenario leaves alone");
            let help = format!("\"simulation\": {{ \"clocks\": {{ \"{name}\": {{ \"period\": 20 }} }} }}");
            let help = format!("add it to the scenario: {help}; or run with `--clock {name}=20`");
            self.diagnostics.push(fault.help(help));
        }
    }
}
