//! The values of some nets over a run, as they were at the end of each tick.

use std::collections::{HashMap, HashSet};

use crate::engine::Engine;
use crate::netlist::{Driver, NetId, Netlist, Slice};
use crate::scenario::Observer;
use crate::value::Word;
use crate::{Logic, Value};

/// Bytes that a history keeps at most.
const MOST: usize = 1 << 30;

/// The changes of a net: each tick at which it changed, and what it became.
type Changes = Vec<(u64, Box<[Word]>)>;

/// Each change of some nets.
#[derive(Debug, Default)]
pub struct History {
    changes: HashMap<NetId, Changes>,
    bytes: usize,
    begun: bool,
    /// Whether there was no room for all of it.
    pub full: bool,
}

/// All nets that some depend on, through storage and back to the inputs; they themselves too.
#[must_use]
pub fn cone(netlist: &Netlist, from: &[Slice]) -> HashSet<NetId> {
    let mut found: HashSet<NetId> = HashSet::new();
    let mut open: Vec<NetId> = from.iter().map(|slice| slice.net).collect();
    while let Some(net) = open.pop() {
        if !found.insert(net) {
            continue;
        }
        if let Driver::Cell(cell, _) = netlist.net(net).driver {
            let pins = 0..netlist.cell(cell).kind.inputs().len();
            open.extend(pins.flat_map(|pin| netlist.input(cell, pin)).map(|slice| slice.net));
            // a state is seen on its first output
            open.push(netlist.output(cell, 0));
        }
    }
    found
}

impl History {
    /// A history of these nets.
    #[must_use]
    pub fn of(nets: HashSet<NetId>) -> History {
        History { changes: nets.into_iter().map(|net| (net, Vec::new())).collect(), ..History::default() }
    }

    fn words(&self, net: NetId, time: u64) -> &[Word] {
        let Some(list) = self.changes.get(&net) else { return &[] };
        let at = list.partition_point(|(when, _)| *when <= time);
        list.get(at.saturating_sub(1)).map_or(&[], |(_, value)| value)
    }

    /// The value of some bits at the end of a tick.
    #[must_use]
    pub fn at(&self, slice: Slice, time: u64) -> Value {
        let words = self.words(slice.net, time);
        let mut value = Value::unknown(slice.width);
        for i in 0..slice.width {
            let bit = slice.lo + i;
            let Some(word) = words.get(bit as usize / 64) else { continue };
            let (v, u) = (word.v >> (bit % 64) & 1, word.u >> (bit % 64) & 1);
            let logic = match (v, u) {
                (0, 0) => Logic::Zero,
                (1, 0) => Logic::One,
                (0, _) => Logic::X,
                _ => Logic::Z,
            };
            value.set_bit(i, logic);
        }
        value
    }

    /// The value of several slices, the least significant first.
    #[must_use]
    pub fn joined(&self, slices: &[Slice], time: u64) -> Value {
        let mut value = Value::unknown(slices.iter().map(|s| s.width).sum());
        let mut at = 0;
        for slice in slices {
            let part = self.at(*slice, time);
            (0..slice.width).for_each(|i| value.set_bit(at + i, part.bit(i)));
            at += slice.width;
        }
        value
    }

    /// The ticks at which a net changed, the first of the run among them.
    pub fn times(&self, net: NetId) -> impl DoubleEndedIterator<Item = u64> + '_ {
        self.changes.get(&net).into_iter().flatten().map(|(time, _)| *time)
    }

    /// Since when some bits have had the value that they have at a tick.
    #[must_use]
    pub fn since(&self, slice: Slice, time: u64) -> u64 {
        let value = self.at(slice, time);
        let mut since = time;
        for when in self.times(slice.net).rev().filter(|when| *when <= time) {
            if self.at(slice, when) != value {
                break;
            }
            since = when;
        }
        since
    }
}

impl Observer for History {
    fn nets(&self) -> Vec<NetId> {
        self.changes.keys().copied().collect()
    }

    fn look(&mut self, engine: &dyn Engine) -> bool {
        let now = engine.now();
        let changed: Vec<NetId> = if self.begun { engine.changes().to_vec() } else { self.nets() };
        self.begun = true;
        for net in changed {
            let Some(list) = self.changes.get_mut(&net) else { continue };
            let value: Box<[Word]> = engine.read(net).into();
            if let Some(last) = list.last_mut().filter(|last| last.0 == now) {
                last.1 = value;
                continue;
            }
            if list.last().is_some_and(|last| last.1 == value) {
                continue;
            }
            self.bytes += 32 + size_of_val(&*value);
            list.push((now, value));
        }
        self.full |= self.bytes > MOST;
        self.full
    }
}
