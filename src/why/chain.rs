//! Step after step back, always to what mattered.

use std::collections::HashMap;

use super::History;
use super::explain::{Cause, Step, explain};
use crate::netlist::{CellId, NetId, Netlist, SignalId, Slice};
use crate::{Logic, Value};

/// A step, and which of its reads is the next one's value.
#[derive(Clone, Debug)]
pub struct Link {
    /// The step.
    pub step: Step,
    /// The read that is followed.
    pub followed: Option<usize>,
}

/// Where a chain ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum End {
    /// An input of the circuit.
    Input(SignalId),
    /// A constant.
    Constant,
    /// A net that nothing drives.
    Undriven,
    /// A storage cell that nothing has set.
    Uninitialised(CellId),
    /// A word of a memory that nothing has written.
    Unwritten(CellId),
    /// A cell that makes x of known values: a division by zero, an index that does not exist.
    MakesUnknown(CellId),
    /// A clock of the circuit itself.
    Clock,
    /// The values of a loop make one another.
    Loop,
    /// A delay through which nothing has come yet.
    Delayed,
    /// There is more, but so many steps were wanted.
    Limit,
}

fn unknown(value: &Value) -> bool {
    value.bits().any(|bit| matches!(bit, Logic::X | Logic::Z))
}

/// From some bits of a net at a tick back to where their value comes from, in at most `most` steps. What is x is followed by
/// what is x; what is known by what changed last of that which mattered.
#[must_use]
pub fn chain(netlist: &Netlist, history: &History, slice: Slice, time: u64, most: usize) -> (Vec<Link>, End) {
    let mut links: Vec<Link> = Vec::new();
    let mut seen: HashMap<(NetId, u32), u32> = HashMap::new();
    let (mut slice, mut time) = (slice, time);
    loop {
        if links.len() >= most {
            return (links, End::Limit);
        }
        let lost = unknown(&history.at(slice, time));
        if lost {
            let visits = seen.entry((slice.net, slice.lo)).or_default();
            *visits += 1;
            match *visits {
                1 => {}
                // round a loop of registers: back to when it began
                2 => time = history.since(slice, time),
                _ => return (links, End::Loop),
            }
        }
        let step = explain(netlist, history, slice, time);
        let end = match &step.cause {
            Cause::Input(signal) => Some(End::Input(*signal)),
            Cause::Constant(_) => Some(End::Constant),
            Cause::Undriven => Some(End::Undriven),
            Cause::Clock(_) => Some(End::Clock),
            Cause::Start(cell) => Some(End::Uninitialised(*cell)),
            Cause::Unwritten { cell, .. } => Some(End::Unwritten(*cell)),
            Cause::Delayed(_) if step.reads.is_empty() => Some(End::Delayed),
            _ => None,
        };
        if let Some(end) = end {
            links.push(Link { step, followed: None });
            return (links, end);
        }
        let candidates = step.reads.iter().enumerate().filter(|(_, read)| read.matters);
        let candidates = candidates.flat_map(|(i, read)| read.slices.iter().map(move |s| (i, *s, read.time)));
        let mut candidates: Vec<(usize, Slice, u64)> = candidates.collect();
        if lost {
            candidates.retain(|(_, slice, time)| unknown(&history.at(*slice, *time)));
        }
        let since = |&(_, slice, time): &(usize, Slice, u64)| history.since(slice, time);
        let next = if lost {
            candidates.iter().min_by_key(|c| (seen.contains_key(&(c.1.net, c.1.lo)), since(c)))
        } else {
            candidates.iter().rev().max_by_key(|c| since(c))
        };
        let Some(&(read, next, then)) = next else {
            let end = match step.cause.cell() {
                Some(cell) if lost => End::MakesUnknown(cell),
                _ => End::Constant,
            };
            links.push(Link { step, followed: None });
            return (links, end);
        };
        links.push(Link { step, followed: Some(read) });
        (slice, time) = (next, then);
    }
}
