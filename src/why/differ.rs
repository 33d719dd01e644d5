//! The first net in the cone of another that is not as another waveform has it.

use std::collections::{HashMap, HashSet, VecDeque};

use super::History;
use crate::cell::{CellKind, Role};
use crate::netlist::{CellId, Driver, NetId, Netlist, SignalId, Slice};
use crate::scenario::replay::Golden;
use crate::{Logic, Value};

/// A signal that differs.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The signal.
    pub signal: SignalId,
    /// The first tick of the time in which it differs.
    pub time: u64,
    /// What the other waveform has.
    pub expected: Value,
    /// What the run has.
    pub found: Value,
}

/// Where a difference comes from.
#[derive(Clone, Debug)]
pub struct Culprit {
    /// From the signal that was asked for, one differing signal after the other; the last is the first net that differs.
    pub way: Vec<Seen>,
    /// The cells between the last of them and signals that are as expected: what they make is wrong.
    pub cells: Vec<CellId>,
    /// The signals that those read, which are as expected.
    pub equal: Vec<SignalId>,
    /// Whether no cell is between: the signal is wired to those.
    pub wired: bool,
}

/// Looks values up in both.
struct Both<'b> {
    netlist: &'b Netlist,
    history: &'b History,
    golden: &'b Golden,
    /// Whether x in the other waveform, or in the run, agrees with anything.
    loose: [bool; 2],
    /// For each net the signals of the other waveform that show bits of it.
    of_net: HashMap<NetId, Vec<SignalId>>,
}

fn agree(expected: Logic, found: Logic, loose: [bool; 2]) -> bool {
    expected == found || loose[0] && expected == Logic::X || loose[1] && found == Logic::X
}

impl Both<'_> {
    fn expected(&self, signal: SignalId, time: u64) -> Option<&Value> {
        let list = self.golden.get(&signal)?;
        let at = list.partition_point(|(when, _)| *when <= time);
        list.get(at.checked_sub(1)?).map(|(_, value)| value)
    }

    fn differs(&self, signal: SignalId, time: u64) -> bool {
        let Some(expected) = self.expected(signal, time) else { return false };
        let found = self.history.joined(self.netlist.bits(signal), time);
        (0..expected.width().min(found.width())).any(|bit| !agree(expected.bit(bit), found.bit(bit), self.loose))
    }

    /// Whether bits of a signal that are of one net differ.
    fn net_differs(&self, signal: SignalId, net: NetId, time: u64) -> bool {
        let parts = self.netlist.bits(signal).iter().filter(|part| part.net == net);
        parts.into_iter().any(|part| part_differs(self, signal, *part, time))
    }

    /// The ticks at which a signal may begin or end to differ.
    fn times(&self, signal: SignalId) -> Vec<u64> {
        let own = self.netlist.bits(signal).iter().flat_map(|s| self.history.times(s.net));
        let theirs = self.golden.get(&signal).into_iter().flatten().map(|(time, _)| *time);
        let mut times: Vec<u64> = own.chain(theirs).collect();
        times.sort_unstable();
        times.dedup();
        times
    }

    /// The first tick of the time in which a signal differs, of that which a tick lies in.
    fn begins(&self, signal: SignalId, time: u64) -> u64 {
        let times = self.times(signal);
        let mut first = time;
        for &when in times.iter().rev().filter(|when| **when <= time) {
            if !self.differs(signal, when) {
                break;
            }
            first = when;
        }
        first
    }

    fn seen(&self, signal: SignalId, time: u64) -> Seen {
        let time = self.begins(signal, time);
        let found = self.history.joined(self.netlist.bits(signal), time);
        let expected = self.expected(signal, time).cloned().unwrap_or_else(|| Value::unknown(found.width()));
        Seen { signal, time, expected, found }
    }
}

/// The pins of a cell with the ticks at which they count for what it shows at a tick.
fn looks(netlist: &Netlist, cell: CellId, time: u64) -> Vec<(Slice, u64)> {
    let kind = &netlist.cell(cell).kind;
    let before = time.saturating_sub(1);
    let stored = kind.storage().is_some() || matches!(kind, CellKind::Memory(_));
    let mut found = Vec::new();
    for (pin, what) in kind.inputs().iter().enumerate() {
        let at: &[u64] = match what.role {
            Role::Clock | Role::Level | Role::Trigger => &[time, before],
            Role::Delayed => &[time],
            // data may pass at once, or be what was there before the edge
            _ if stored && matches!(kind, CellKind::Latch(_) | CellKind::Memory(_)) => &[before, time],
            _ if stored => &[before],
            _ => &[time],
        };
        found.extend(netlist.input(cell, pin).iter().flat_map(|slice| at.iter().map(|&at| (*slice, at))));
    }
    found
}

/// From a signal back through signals that are not as `golden` has them, to the first that differs though all that makes it is as it
/// should be. None if the signal does not differ at the tick or, without one, ever.
#[must_use]
pub fn differ(
    netlist: &Netlist,
    history: &History,
    golden: &Golden,
    loose: [bool; 2],
    signal: SignalId,
    at: Option<u64>,
) -> Option<Culprit> {
    let mut of_net: HashMap<NetId, Vec<SignalId>> = HashMap::new();
    for &known in golden.keys() {
        netlist.bits(known).iter().for_each(|slice| of_net.entry(slice.net).or_default().push(known));
    }
    of_net.values_mut().for_each(|list| list.sort_unstable());
    let both = Both { netlist, history, golden, loose, of_net };
    let first = match at {
        Some(time) => Some(time).filter(|&time| both.differs(signal, time)),
        None => both.times(signal).into_iter().find(|&time| both.differs(signal, time)),
    }?;
    let mut way = vec![both.seen(signal, first)];
    let mut passed: HashSet<SignalId> = HashSet::from([signal]);
    loop {
        let (here, time) = way.last().map(|seen| (seen.signal, seen.time))?;
        let found = behind(&both, here, time);
        let next = found.differing.iter().filter(|(signal, _)| !passed.contains(signal));
        let Some(&(next, then)) = next.min_by_key(|(signal, time)| (both.begins(*signal, *time), *signal)) else {
            return Some(Culprit { way, cells: found.cells, equal: found.equal, wired: found.wired });
        };
        passed.insert(next);
        way.push(both.seen(next, then));
    }
}

/// What stands behind a signal, up to signals that the other waveform has.
struct Behind {
    differing: Vec<(SignalId, u64)>,
    equal: Vec<SignalId>,
    cells: Vec<CellId>,
    wired: bool,
}

fn behind(both: &Both<'_>, signal: SignalId, time: u64) -> Behind {
    let netlist = both.netlist;
    let mut found = Behind { differing: Vec::new(), equal: Vec::new(), cells: Vec::new(), wired: false };
    let mut open: VecDeque<(Slice, u64)> = VecDeque::new();
    let mut visited: HashSet<(NetId, u64)> = HashSet::new();
    // the nets of the signal are where it begins: the same net under another name is no step
    let mut own: HashSet<NetId> = HashSet::new();
    for slice in netlist.bits(signal) {
        // the same net is right under another name: what is wrong is which net it is
        let others = both.of_net.get(&slice.net).into_iter().flatten().filter(|other| **other != signal);
        let right: Vec<SignalId> =
            others.filter(|other| !both.net_differs(**other, slice.net, time)).copied().collect();
        if part_differs(both, signal, *slice, time) && !right.is_empty() {
            found.wired = true;
            found.equal.extend(right);
        }
        // only bits that differ
        if own.insert(slice.net) && part_differs(both, signal, *slice, time) {
            open.push_back((*slice, time));
        }
    }
    if found.wired {
        found.equal.sort_unstable();
        found.equal.dedup();
        return found;
    }
    while let Some((slice, time)) = open.pop_front() {
        let Driver::Cell(cell, _) = netlist.net(slice.net).driver else { continue };
        if !found.cells.contains(&cell) {
            found.cells.push(cell);
        }
        for (input, at) in looks(netlist, cell, time) {
            let same = own.contains(&input.net) && at == time;
            let known = both.of_net.get(&input.net).filter(|_| !same);
            match known {
                Some(list) => {
                    let wrong = list.iter().find(|known| both.net_differs(**known, input.net, at));
                    match wrong {
                        Some(&wrong) if wrong != signal => found.differing.push((wrong, at)),
                        // its own earlier value
                        Some(_) => {}
                        None => found.equal.push(list[0]),
                    }
                }
                None => {
                    if visited.insert((input.net, at)) {
                        open.push_back((input, at));
                    }
                }
            }
        }
    }
    found.equal.sort_unstable();
    found.equal.dedup();
    found
}

/// Whether the bits of a signal that are a slice of it differ.
fn part_differs(both: &Both<'_>, signal: SignalId, slice: Slice, time: u64) -> bool {
    let Some(expected) = both.expected(signal, time) else { return false };
    let mut at = 0;
    for part in both.netlist.bits(signal) {
        if *part == slice {
            let found = both.history.at(slice, time);
            return (0..slice.width)
                .any(|bit| at + bit < expected.width() && !agree(expected.bit(at + bit), found.bit(bit), both.loose));
        }
        at += part.width;
    }
    false
}
