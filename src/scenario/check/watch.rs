//! Follows the nets of timing checks from instant to instant.

use super::{CheckReport, Fault, Side, Timing, TimingCheck, Violation};
use crate::engine::Engine;
use crate::netlist::{Netlist, SignalId};
use crate::scenario::Edge;
use crate::scenario::run::read;
use crate::value::Word;

/// The timing checks of a run.
#[derive(Debug)]
pub(in crate::scenario) struct Checker<'s> {
    checks: &'s [TimingCheck],
    states: Vec<State>,
    reports: Vec<CheckReport>,
}

/// What a check remembers.
#[derive(Debug)]
struct State {
    net: Follower,
    /// The other net, of those that have one.
    other: Option<Follower>,
    /// The last tick that matters: when a pulse began, of the last edge or change.
    since: Option<u64>,
    /// Steps that went in, and that came out.
    put: u64,
    taken: u64,
}

/// A net and what it was.
#[derive(Debug)]
struct Follower {
    signal: SignalId,
    last: Vec<Word>,
    /// It has been known: what comes first is no change.
    begun: bool,
}

/// What a net did at an instant.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    changed: bool,
    /// Bit 0 became 1.
    rose: bool,
    /// Bit 0 became 0.
    fell: bool,
    /// Bit 0 is not 1 any more, or not 0 any more.
    left_one: bool,
    left_zero: bool,
}

impl Seen {
    fn edge(self, edge: Edge) -> bool {
        match edge {
            Edge::Rising => self.rose,
            Edge::Falling => self.fell,
        }
    }
}

impl Follower {
    fn new(signal: SignalId) -> Follower {
        Follower { signal, last: Vec::new(), begun: false }
    }

    fn look(&mut self, now: &[Word]) -> Seen {
        let seen = match self.last.first() {
            Some(&last) if self.begun => Seen {
                changed: self.last != now,
                rose: !last.is_one() && now[0].is_one(),
                fell: !last.is_zero() && now[0].is_zero(),
                left_one: last.is_one() && !now[0].is_one(),
                left_zero: last.is_zero() && !now[0].is_zero(),
            },
            _ => Seen::default(),
        };
        self.begun |= now.iter().all(|w| w.u == 0);
        if self.last != now {
            self.last.clear();
            self.last.extend_from_slice(now);
        }
        seen
    }
}

impl<'s> Checker<'s> {
    pub fn new(checks: &'s [TimingCheck]) -> Checker<'s> {
        let state = |check: &TimingCheck| {
            let other = match check.timing {
                Timing::Window { on, .. } => Some(on),
                Timing::Steps { of, .. } => Some(of),
                Timing::Width { .. } | Timing::Period { .. } => None,
            };
            let other = other.map(Follower::new);
            State { net: Follower::new(check.net), other, since: None, put: 0, taken: 0 }
        };
        let reports = vec![CheckReport::default(); checks.len()];
        Checker { checks, states: checks.iter().map(state).collect(), reports }
    }

    /// The signals whose changes have to be looked at.
    pub fn signals(&self) -> impl Iterator<Item = SignalId> + '_ {
        self.states.iter().flat_map(|s| [Some(s.net.signal), s.other.as_ref().map(|o| o.signal)]).flatten()
    }

    /// Looks at the values that the nets have at the end of the present tick; `buffer` holds the widest of them.
    pub fn look(&mut self, netlist: &Netlist, engine: &dyn Engine, buffer: &mut [Word]) {
        let now = engine.now();
        for ((check, state), report) in self.checks.iter().zip(&mut self.states).zip(&mut self.reports) {
            let mut look = |net: &mut Follower| net.look(read(netlist, engine, net.signal, buffer));
            let net = look(&mut state.net);
            let other = state.other.as_mut().map(look).unwrap_or_default();
            let mut tell = |fault, measured, required| report.tell(Violation { time: now, fault, measured, required });
            match check.timing {
                Timing::Width { level, min, max } => {
                    let (began, ended) = if level { (net.rose, net.left_one) } else { (net.fell, net.left_zero) };
                    if ended && let Some(since) = state.since.take() {
                        distance(now - since, min, max, &mut tell);
                    }
                    if began {
                        state.since = Some(now);
                    }
                }
                Timing::Period { edge, min, max } => {
                    if net.edge(edge)
                        && let Some(since) = state.since.replace(now)
                    {
                        distance(now - since, min, max, &mut tell);
                    }
                }
                Timing::Window { side, edge, on_edge, min, .. } => {
                    let changed = edge.map_or(net.changed, |e| net.edge(e));
                    let struck = other.edge(on_edge);
                    // what is measured from is remembered before the look if its own tick counts
                    let (from, to) = if side == Side::Hold { (struck, changed) } else { (changed, struck) };
                    if from && side != Side::Setup {
                        state.since = Some(now);
                    }
                    if let Some(measured) = state.since.map(|s| now - s).filter(|&d| to && d < min) {
                        tell(if side == Side::Hold { Fault::TooSoon } else { Fault::TooLate }, measured, min);
                    }
                    if from {
                        state.since = Some(now);
                    }
                }
                Timing::Steps { depth, .. } => {
                    state.put += u64::from(other.rose);
                    state.taken += u64::from(net.rose);
                    let (put, taken) = (state.put, state.taken);
                    if net.rose && taken > put {
                        tell(Fault::Doubled, taken, put);
                    }
                    if let Some(depth) = depth.filter(|&d| other.rose && put.saturating_sub(taken) > d) {
                        tell(Fault::Overfull, put - taken, depth);
                    }
                }
            }
        }
    }

    /// The reports, when the run has ended at tick `now`: pulses and periods that are too long already, steps that are
    /// missing or too many.
    pub fn finish(mut self, now: u64) -> Vec<CheckReport> {
        for ((check, state), report) in self.checks.iter().zip(&self.states).zip(&mut self.reports) {
            let mut tell = |fault, measured, required| report.tell(Violation { time: now, fault, measured, required });
            match check.timing {
                Timing::Width { max, .. } | Timing::Period { max, .. } => {
                    if let Some(since) = state.since {
                        distance(now - since, None, max, &mut tell);
                    }
                }
                Timing::Steps { .. } if state.taken < state.put => tell(Fault::Lost, state.taken, state.put),
                Timing::Steps { .. } if state.taken > state.put => tell(Fault::Gained, state.taken, state.put),
                Timing::Steps { .. } | Timing::Window { .. } => {}
            }
        }
        self.reports
    }
}

/// Tells of a time that is out of bounds.
fn distance(measured: u64, min: Option<u64>, max: Option<u64>, tell: &mut impl FnMut(Fault, u64, u64)) {
    if let Some(min) = min.filter(|&min| measured < min) {
        tell(Fault::TooShort, measured, min);
    }
    if let Some(max) = max.filter(|&max| measured > max) {
        tell(Fault::TooLong, measured, max);
    }
}
