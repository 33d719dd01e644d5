//! Runs a scenario: drives the engine from instant to instant, records what is traced, watches for the end, checks what
//! is expected.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use super::check::{CheckReport, Checker};
use super::record::Recording;
use super::replay::Feed;
use super::resolve::{Rule, Scenario};
use crate::Value;
use crate::engine::{Engine, UnknownControl, Unsettled, read_bits};
use crate::import::yosys::Monitor;
use crate::import::yosys::monitor::{Seen, When};
use crate::netlist::{NetId, Netlist, SignalId};
use crate::value::Word;
use crate::value::word::words;
use crate::wave::Sink;

/// Why a run ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stop {
    /// Its stop condition came true.
    Until,
    /// It came to its last tick.
    Limit,
    /// Nothing can change any more.
    Idle,
    /// What observes the run has seen enough.
    Observed,
    /// It was asked to stop.
    Interrupted,
    /// An x or z reached a control, which was to be an error.
    UnknownControl,
}

/// An expectation that did not come true.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Failure {
    /// Its number in the scenario.
    pub expectation: usize,
    /// What there was instead.
    pub found: Found,
}

/// What there was instead of what was expected.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Found {
    /// Another value.
    Value(Value),
    /// Another number of pulses.
    Pulses(u64),
    /// Other violations of a timing check: how many, and the tick of the first.
    Violations(u64, Option<u64>),
    /// The run ended before the time.
    EndedBefore,
}

/// How a run went.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Why the run ended.
    pub stop: Stop,
    /// The tick at which it ended.
    pub time: u64,
    /// Net changes, if the engine counts them.
    pub events: Option<u64>,
    /// Which engine ran, and how.
    pub engine: String,
    /// Expectations that did not come true.
    pub failures: Vec<Failure>,
    /// How the timing checks went, in the order of the scenario.
    pub checks: Vec<CheckReport>,
    /// Where x or z reached a control.
    pub unknown_controls: Vec<UnknownControl>,
    /// How often an assertion or assumption of the circuit failed.
    pub assertions_failed: u64,
    /// The first of these.
    pub assertions: Vec<AssertionFailure>,
    /// The numbers, among the monitors, of what was to happen and did not.
    pub uncovered: Vec<usize>,
    /// The last values of the circuit's outputs, in order.
    pub outputs: Vec<(SignalId, Value)>,
}

/// An assertion or assumption of the circuit that failed.
#[derive(Clone, Debug)]
pub struct AssertionFailure {
    /// The tick at which it was noticed.
    pub time: u64,
    /// Its number among the monitors.
    pub monitor: usize,
    /// What it says.
    pub text: String,
    /// What its condition is made of.
    pub operands: Vec<(String, Value)>,
}

/// Assertions that are kept one by one.
pub const MAX_ASSERTIONS: usize = 100;

/// Why a run broke off.
#[derive(Debug)]
pub enum RunError {
    /// Something never settles.
    Unsettled(Unsettled),
    /// The waveform cannot be written.
    Wave(io::Error),
}

impl From<Unsettled> for RunError {
    fn from(e: Unsettled) -> Self {
        RunError::Unsettled(e)
    }
}

impl From<io::Error> for RunError {
    fn from(e: io::Error) -> Self {
        RunError::Wave(e)
    }
}

/// What a run is told from outside.
pub struct Control<'c> {
    /// Set to stop it.
    pub interrupt: &'c AtomicBool,
    /// Called now and then with the present tick.
    pub progress: &'c mut dyn FnMut(u64),
    /// Called with what the circuit itself says: the tick, the number of the monitor, its message.
    pub message: &'c mut dyn FnMut(u64, usize, &str),
    /// Whether an x or z at a control ends it.
    pub unknown_control_ends: bool,
    /// Look at the values too.
    pub observers: Vec<&'c mut dyn Observer>,
}

/// What looks at values while a scenario runs, beside what the scenario itself wants.
pub trait Observer {
    /// The nets whose changes it wants to see.
    fn nets(&self) -> Vec<NetId>;

    /// Looks at the values at the end of a tick: of the first, and of each at which a net changed that anyone observes.
    /// The [changes](Engine::changes) are those since it last looked. Returns whether the run is to end here.
    fn look(&mut self, engine: &dyn Engine) -> bool;
}

/// Ticks between looks at the interrupt when nothing observed changes.
const STRIDE: u64 = 1 << 16;

/// A signal whose pulses are counted.
struct Count {
    signal: SignalId,
    /// Whether bit 0 was 0 when last seen.
    low: bool,
    pulses: u64,
}

/// The signals that are watched, and those that each net is part of.
struct Watch<'n> {
    netlist: &'n Netlist,
    /// The timing checks, if there are any.
    checker: Option<Checker<'n>>,
    /// What goes into the waveform, if there is one.
    recording: Option<Recording>,
    counts: Vec<Count>,
    buffer: Vec<Word>,
    seen: Vec<Seen>,
    /// Nothing has been recorded yet.
    first: bool,
    /// An observer wants the run to end.
    enough: bool,
}

impl<'n> Watch<'n> {
    fn new(netlist: &'n Netlist, scenario: &'n Scenario, tracing: bool, engine: &mut dyn Engine) -> Watch<'n> {
        let traced: &[SignalId] = if tracing { &scenario.trace } else { &[] };
        let recording = tracing.then(|| Recording::new(netlist, traced));
        let mut counts: Vec<Count> = Vec::new();
        for e in &scenario.expect {
            if matches!(e.rule, Rule::Pulses(_)) && !counts.iter().any(|c| c.signal == e.signal) {
                counts.push(Count { signal: e.signal, low: false, pulses: 0 });
            }
        }
        let checker = (!scenario.checks.is_empty()).then(|| Checker::new(&scenario.checks));
        for &signal in traced {
            netlist.bits(signal).iter().for_each(|s| engine.trace(s.net));
        }
        let watched = scenario.until.iter().map(|u| u.0);
        let watched = watched.chain(counts.iter().map(|c| c.signal)).chain(checker.iter().flat_map(Checker::signals));
        let of_monitor = |m: &Monitor| {
            let counter = if let When::Edge(counter) = m.when { Some(counter) } else { None };
            std::iter::once(m.signal).chain(counter)
        };
        let watched: Vec<SignalId> = watched.chain(scenario.monitors.iter().flat_map(of_monitor)).collect();
        for signal in watched {
            netlist.bits(signal).iter().for_each(|s| engine.observe(s.net));
        }
        let widest = netlist.signals().iter().map(|s| words(s.width)).max().unwrap_or(1);
        Watch {
            netlist,
            checker,
            recording,
            counts,
            buffer: vec![Word::ZERO; widest],
            seen: vec![Seen::default(); scenario.monitors.len()],
            first: true,
            enough: false,
        }
    }

    fn read(&mut self, engine: &dyn Engine, signal: SignalId) -> &[Word] {
        read(self.netlist, engine, signal, &mut self.buffer)
    }

    fn value(&mut self, engine: &dyn Engine, signal: SignalId) -> Value {
        let width = self.netlist.signal(signal).width;
        Value::from_words(self.read(engine, signal), width)
    }

    /// Lets the circuit's own monitors look at the present values, if anything has changed.
    fn look(&mut self, engine: &dyn Engine, monitors: &[Monitor], outcome: &mut Outcome, control: &mut Control<'_>) {
        if monitors.is_empty() || engine.changes().is_empty() && !self.first {
            return;
        }
        for (i, monitor) in monitors.iter().enumerate() {
            let mut seen = std::mem::take(&mut self.seen[i]);
            let said = monitor.look(&mut seen, engine.now(), |signal| self.value(engine, signal));
            self.seen[i] = seen;
            if let Some(text) = said {
                let mut text = text;
                if monitor.fails() {
                    outcome.assertions_failed += 1;
                    let operands = self.seen[i].operands(monitor);
                    let shown: Vec<String> = operands.iter().map(|(name, value)| format!("{name} = {value}")).collect();
                    let said = text.trim_end().to_owned();
                    if !shown.is_empty() {
                        let gap = if said.is_empty() { "" } else { " " };
                        text = format!("{said}{gap}[{}]", shown.join(", "));
                    }
                    if outcome.assertions.len() < MAX_ASSERTIONS {
                        outcome.assertions.push(AssertionFailure {
                            time: engine.now(),
                            monitor: i,
                            text: said,
                            operands,
                        });
                    }
                }
                (control.message)(engine.now(), i, &text);
            }
        }
    }

    /// Records the changes since the last time, and regards what else watches them.
    fn record(
        &mut self,
        engine: &mut dyn Engine,
        sink: &mut Option<&mut dyn Sink>,
        observers: &mut [&mut dyn Observer],
    ) -> io::Result<()> {
        let first = std::mem::replace(&mut self.first, false);
        for observer in observers {
            if first || !engine.changes().is_empty() {
                self.enough |= observer.look(engine);
            }
        }
        if let (Some(sink), Some(recording)) = (sink, &mut self.recording) {
            recording.record(engine, first, *sink)?;
        }
        if engine.changes().is_empty() && !first {
            return Ok(());
        }
        for i in 0..self.counts.len() {
            let bit = self.read(engine, self.counts[i].signal)[0];
            let count = &mut self.counts[i];
            // a pulse is from a known 0 to a known 1
            count.pulses += u64::from(count.low && bit.is_one());
            count.low = bit.is_zero();
        }
        if let Some(checker) = &mut self.checker {
            checker.look(self.netlist, engine, &mut self.buffer);
        }
        engine.clear_changes();
        Ok(())
    }
}

/// Runs a scenario on an engine that is at its start, writing a waveform into `sink` if there is one.
///
/// # Errors
/// If something never settles, or the waveform cannot be written. What was recorded before an unsettled instant is
/// completed as a waveform up to there.
pub fn run(
    netlist: &Netlist,
    scenario: &Scenario,
    engine: &mut dyn Engine,
    sink: Option<&mut dyn Sink>,
    control: &mut Control<'_>,
) -> Result<Outcome, RunError> {
    run_with(netlist, scenario, engine, None, sink, control)
}

/// The same where a waveform drives inputs.
///
/// # Errors
/// As [`run`].
pub fn run_with(
    netlist: &Netlist,
    scenario: &Scenario,
    engine: &mut dyn Engine,
    mut feed: Option<Feed<'_>>,
    mut sink: Option<&mut dyn Sink>,
    control: &mut Control<'_>,
) -> Result<Outcome, RunError> {
    let mut watch = Watch::new(netlist, scenario, sink.is_some(), engine);
    if let (Some(sink), Some(recording)) = (&mut sink, &watch.recording) {
        sink.begin(recording.layout())?;
    }
    control.observers.iter().flat_map(|o| o.nets()).for_each(|net| engine.observe(net));
    for c in &scenario.clocks {
        engine.add_clock(c.net, c.clock);
    }
    for (net, value) in &scenario.inputs {
        drive(engine, *net, value);
    }
    let mut outcome = Outcome {
        stop: Stop::Limit,
        time: 0,
        events: None,
        engine: String::new(),
        failures: Vec::new(),
        checks: Vec::new(),
        unknown_controls: Vec::new(),
        assertions_failed: 0,
        assertions: Vec::new(),
        uncovered: Vec::new(),
        outputs: Vec::new(),
    };
    let end = instants(scenario, engine, &mut feed, &mut watch, &mut sink, &mut outcome, control);
    outcome.time = engine.now();
    outcome.events = engine.events();
    outcome.engine = engine.summary();
    if let Err(RunError::Wave(e)) = end {
        return Err(e.into());
    }
    if let Some(sink) = sink {
        if let Some(recording) = &mut watch.recording {
            recording.finish(engine, end.is_err(), sink)?;
        }
        sink.finish(outcome.time)?;
    }
    outcome.stop = end?;
    outcome.checks = watch.checker.take().map_or_else(Vec::new, |c| c.finish(outcome.time));
    for (i, e) in scenario.expect.iter().enumerate() {
        let found = match &e.rule {
            Rule::Value(None, expected) => {
                Some(watch.value(engine, e.signal)).filter(|v| v != expected).map(Found::Value)
            }
            Rule::Value(Some(time), _) => (*time > outcome.time).then_some(Found::EndedBefore),
            Rule::Pulses(expected) => {
                let pulses = watch.counts.iter().find(|c| c.signal == e.signal).map_or(0, |c| c.pulses);
                (pulses != *expected).then_some(Found::Pulses(pulses))
            }
            Rule::Violated { check, count, first } => {
                let report = &outcome.checks[*check];
                let found = report.first.first().map(|v| v.time);
                let as_expected =
                    count.map_or(report.count > 0, |n| report.count == n) && (first.is_none() || found == *first);
                (!as_expected).then_some(Found::Violations(report.count, found))
            }
        };
        outcome.failures.extend(found.map(|found| Failure { expectation: i, found }));
    }
    outcome.failures.sort_by_key(|f| f.expectation);
    let uncovered = scenario.monitors.iter().zip(&watch.seen).enumerate();
    outcome.uncovered = uncovered.filter(|(_, (c, seen))| c.is_uncovered(seen)).map(|(i, _)| i).collect();
    let outputs = netlist.ports().filter(|&s| netlist.signal(s).port != Some(crate::netlist::Direction::Input));
    outcome.outputs = outputs.map(|s| (s, watch.value(engine, s))).collect();
    Ok(outcome)
}

/// From instant to instant until something ends the run.
fn instants(
    scenario: &Scenario,
    engine: &mut dyn Engine,
    feed: &mut Option<Feed<'_>>,
    watch: &mut Watch<'_>,
    sink: &mut Option<&mut dyn Sink>,
    outcome: &mut Outcome,
    control: &mut Control<'_>,
) -> Result<Stop, RunError> {
    let mut stimulus = scenario.stimulus.iter().peekable();
    let mut checks: Vec<(u64, usize)> = Vec::new();
    for (i, e) in scenario.expect.iter().enumerate() {
        if let Rule::Value(Some(time), _) = e.rule {
            checks.push((time, i));
        }
    }
    checks.sort_unstable();
    let mut checks = checks.iter().peekable();
    let mut first = true;
    loop {
        let due = stimulus.peek().map_or(u64::MAX, |e| e.time).min(checks.peek().map_or(u64::MAX, |c| c.0));
        let fed = feed.as_ref().and_then(Feed::due);
        let due = due.min(fed.unwrap_or(u64::MAX));
        let stride = engine.now().saturating_add(STRIDE).max(engine.next_event().unwrap_or(0));
        let mut target = if first { 0 } else { due.min(scenario.limit).min(stride) };
        let mut fed = feed.as_mut().filter(|_| fed == Some(target));
        if fed.is_some() && engine.next_event().is_some_and(|event| event < target) {
            // what comes before it
            target -= 1;
            fed = None;
        }
        if let Some(feed) = &mut fed {
            // clocks change together with the other clocks and the delays of this tick; at first all
            feed.step();
            feed.drive_first(engine, first);
        }
        engine.advance(target)?;
        let now = engine.now();
        if let Some(feed) = fed {
            engine.settle()?;
            if feed.drive_rest(engine) {
                engine.settle()?;
            }
        }
        first = false;
        let mut stimulated = false;
        while let Some(event) = stimulus.next_if(|e| e.time <= now) {
            event.sets.iter().for_each(|(net, value)| drive(engine, *net, value));
            stimulated = true;
        }
        if stimulated {
            engine.settle()?;
        }
        watch.look(engine, &scenario.monitors, outcome, control);
        watch.record(engine, sink, &mut control.observers)?;
        while let Some(&(_, i)) = checks.next_if(|c| c.0 <= now) {
            let Rule::Value(_, expected) = &scenario.expect[i].rule else { continue };
            let found = watch.value(engine, scenario.expect[i].signal);
            if found != *expected {
                outcome.failures.push(Failure { expectation: i, found: Found::Value(found) });
            }
        }
        let unknown = engine.take_unknown_controls();
        let ended = control.unknown_control_ends && !unknown.is_empty();
        outcome.unknown_controls.extend(unknown);
        if ended {
            return Ok(Stop::UnknownControl);
        }
        if let Some((signal, value)) = &scenario.until
            && watch.read(engine, *signal).iter().copied().eq(value.words())
        {
            return Ok(Stop::Until);
        }
        if watch.enough {
            return Ok(Stop::Observed);
        }
        if now >= scenario.limit {
            return Ok(Stop::Limit);
        }
        if engine.next_event().is_none()
            && stimulus.peek().is_none()
            && checks.peek().is_none()
            && feed.as_ref().is_none_or(|f| f.due().is_none())
        {
            if scenario.limit_given && scenario.until.is_none() {
                engine.advance(scenario.limit)?;
                return Ok(Stop::Limit);
            }
            return Ok(Stop::Idle);
        }
        if control.interrupt.load(Ordering::Relaxed) {
            return Ok(Stop::Interrupted);
        }
        (control.progress)(now);
    }
}

/// The present value of a signal, in a buffer that holds the widest.
pub(super) fn read<'b>(netlist: &Netlist, engine: &dyn Engine, signal: SignalId, buffer: &'b mut [Word]) -> &'b [Word] {
    let n = words(netlist.signal(signal).width);
    read_bits(engine, netlist.bits(signal), &mut buffer[..n]);
    &buffer[..n]
}

/// The present value of a signal.
pub(crate) fn value(netlist: &Netlist, engine: &dyn Engine, signal: SignalId) -> Value {
    let width = netlist.signal(signal).width;
    let mut buffer = vec![Word::ZERO; words(width)];
    Value::from_words(read(netlist, engine, signal, &mut buffer), width)
}

fn drive(engine: &mut dyn Engine, net: NetId, value: &Value) {
    // inputs change seldom: this may allocate
    let all: Vec<Word> = value.words().collect();
    engine.drive(net, &all);
}

#[cfg(test)]
#[path = "run_tests.rs"]
mod tests;
