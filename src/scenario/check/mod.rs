//! Timing checks: what must hold of pulses, edges and steps at every tick of a run, after the timing checks of IEEE
//! 1364-2005, clause 15.
//!
//! [`Check`] is what an author writes, [`TimingCheck`] the same with its names resolved, [`Checker`] follows the nets of
//! a run. Times are whole ticks, and only what a net is at the end of a tick counts.

mod resolve;
mod watch;

use serde::Serialize;

use crate::syntax::{Check, CheckRule, Level};
pub(super) use watch::Checker;

use super::Edge;
use crate::diag::Span;
use crate::netlist::SignalId;

/// Violations of one check that are kept with their times; more are only counted.
pub const MAX_KEPT: usize = 4;

/// A timing check with its names resolved.
#[derive(Clone, Debug)]
pub struct TimingCheck {
    /// Its name in the scenario.
    pub name: String,
    /// The rule as it is called in the file.
    pub rule: CheckRule,
    /// The net that the rule is about.
    pub net: SignalId,
    /// What must hold of it.
    pub timing: Timing,
    /// Where its rule is written.
    pub span: Span,
}

/// What a timing check demands. Times are in ticks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Timing {
    /// How long the net stays at a level.
    Width {
        /// 1 or 0.
        level: bool,
        /// The shortest pulse allowed.
        min: Option<u64>,
        /// The longest pulse allowed.
        max: Option<u64>,
    },
    /// How long it is from one edge to the next in the same direction.
    Period {
        /// The direction.
        edge: Edge,
        /// The shortest period allowed.
        min: Option<u64>,
        /// The longest period allowed.
        max: Option<u64>,
    },
    /// How far changes of the net stay away from the edges of another one.
    Window {
        /// On which side of the edge.
        side: Side,
        /// The changes that count; none: all.
        edge: Option<Edge>,
        /// The other net.
        on: SignalId,
        /// Its edges that count.
        on_edge: Edge,
        /// The shortest distance allowed.
        min: u64,
    },
    /// Every pulse of one net gives one pulse of the checked net, later, through a store.
    Steps {
        /// Where the steps come from.
        of: SignalId,
        /// How many steps the store holds; none: any number.
        depth: Option<u64>,
    },
}

/// The side of an edge on which a net must be at rest, and whether the tick of the edge belongs to it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Side {
    /// `setup`: before the edge, without its tick.
    Setup,
    /// `recovery`: before the edge, with its tick.
    Recovery,
    /// `hold`: after the edge, with its tick.
    Hold,
}

/// How a timing check was violated.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// A pulse or period was too short.
    TooShort,
    /// A pulse or period was too long.
    TooLong,
    /// The net changed too late before the edge.
    TooLate,
    /// The net changed too soon after the edge.
    TooSoon,
    /// A step came out that had not gone in.
    Doubled,
    /// More steps went in than the store holds.
    Overfull,
    /// At the end fewer steps had come out than gone in.
    Lost,
    /// At the end more steps had come out than gone in.
    Gained,
}

/// One violation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The tick at which it was seen.
    pub time: u64,
    /// What was wrong.
    pub fault: Fault,
    /// What there was: ticks, or steps.
    pub measured: u64,
    /// What the check demands: the least or the most allowed, or the number of steps that went in.
    pub required: u64,
}

/// How a timing check went.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct CheckReport {
    /// The first violations, at most [`MAX_KEPT`].
    pub first: Vec<Violation>,
    /// How many there were.
    pub count: u64,
}

impl CheckReport {
    fn tell(&mut self, violation: Violation) {
        self.count += 1;
        if self.first.len() < MAX_KEPT {
            self.first.push(violation);
        }
    }
}

#[cfg(test)]
mod tests;
