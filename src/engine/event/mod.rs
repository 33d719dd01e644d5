//! The event engine: the reference. Four-valued, any clocking, feedback, delays.
//!
//! Operations stand in evaluation order and a change marks its readers in a bit set, so within a phase every
//! operation outside a feedback loop runs at most once and after all that it reads. Loops are iterated in steps in
//! which all members see the values before the step, so no result depends on the order of cells. `program` holds
//! the netlist in arrays; `build`, `operands`, `stores` and `link` make it; `eval` runs one operation, `settle` one
//! evaluation phase, `queue` keeps what is to come; `force` holds nets,
//! `snapshot` saves and restores; `memory` is what memories need of all of these; `size` counts
//! bytes.

mod build;
mod eval;
mod force;
mod link;
mod memory;
#[cfg(test)]
mod memory_tests;
mod operands;
mod program;
mod queue;
mod settle;
mod sites;
mod size;
mod snapshot;
mod stores;
#[cfg(test)]
mod tests;

use super::{Engine, Refused, Snapshot, SnapshotError, UnknownControl, Unsettled};
use crate::Value;
use crate::cell::Clock;
use crate::netlist::{CellId, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::words;

use eval::State;
use program::{Program, flag};
use queue::Queue;

/// The reference engine; see [`Engine`].
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod engine { pub use discreta_engine::*; }
/// # }
/// use discreta::engine::{Engine, EventEngine};
/// use discreta::netlist::Builder;
/// use discreta::value::Word;
/// let mut b = Builder::new("top");
/// let (a, y) = (b.input("a", 1), b.output("y", 1));
/// let inverted = b.not("not1", &a);
/// let clk = b.input("clk", 1);
/// b.dff("ff", &clk, &inverted, &y);
/// let netlist = b.finish().unwrap();
/// let net = |name| netlist.bits(netlist.find(name).unwrap())[0].net;
/// let mut engine = EventEngine::new(&netlist);
/// engine.drive(net("a"), &[Word::known(0)]);
/// for level in [0, 1] {
///     engine.drive(net("clk"), &[Word::known(level)]);
///     engine.settle().unwrap();
/// }
/// assert_eq!(engine.read(net("y")), [Word::known(1)]);
/// ```
#[derive(Debug)]
pub struct EventEngine {
    program: Program,
    state: State,
    queue: Queue,
    now: u64,
    started: bool,
    netlist: Netlist,
    widths: Vec<u32>,
    cells: usize,
}

impl EventEngine {
    /// An engine at tick 0, with nothing settled yet.
    #[must_use]
    pub fn new(netlist: &Netlist) -> EventEngine {
        let program = build::build(netlist);
        let state = State::new(&program);
        let queue = Queue::new(&program);
        let widths = netlist.nets().iter().map(|n| n.width).collect();
        let cells = netlist.cells().len();
        let mut engine =
            EventEngine { program, state, queue, now: 0, started: false, netlist: netlist.clone(), widths, cells };
        for i in 0..engine.program.clock_cells.len() {
            let (slot, clock) = engine.program.clock_cells[i];
            engine.start_clock(slot, clock);
        }
        engine
    }

    /// Back to the state of a new engine, keeping clocks, observed nets and no events.
    pub fn reset(&mut self) {
        let observed: Vec<NetId> = self.observed().collect();
        let clocks = self.queue.clocks();
        self.state = State::new(&self.program);
        self.queue = Queue::new(&self.program);
        (self.now, self.started) = (0, false);
        for net in observed {
            self.observe(net);
        }
        for (slot, clock) in clocks {
            self.start_clock(slot, clock);
        }
    }

    /// How many net changes there have been.
    #[must_use]
    pub fn net_changes(&self) -> u64 {
        self.state.events
    }

    fn observed(&self) -> impl Iterator<Item = NetId> + '_ {
        let first = |net: usize| self.state.meta[self.program.net_slot[net] as usize];
        (0..self.widths.len()).filter(move |&n| first(n).flags & flag::OBSERVED != 0).map(NetId::new)
    }

    fn start_clock(&mut self, slot: u32, clock: Clock) {
        let high = self.queue.add_clock(slot, clock);
        self.state.put(&self.program, slot, Word::known(u64::from(high)));
    }

    /// One evaluation phase, and what it leaves to the future.
    fn wave(&mut self) -> Result<(), Unsettled> {
        self.started = true;
        self.state.settle(&self.program).map_err(|loop_| self.unsettled(loop_))?;
        self.queue.schedule(&self.program, &mut self.state, self.now);
        self.state.check_controls(&self.program, self.now);
        Ok(())
    }

    fn unsettled(&self, found: settle::Oscillation) -> Unsettled {
        let mut nets: Vec<NetId> = Vec::new();
        for slot in found.slots {
            let net = self.program.slot_net[slot as usize];
            if net != u32::MAX && self.program.used[net as usize] && !nets.contains(&NetId(net)) {
                nets.push(NetId(net));
            }
        }
        Unsettled { time: self.now, nets, clocked: found.clocked }
    }
}

impl Engine for EventEngine {
    fn now(&self) -> u64 {
        self.now
    }

    fn read(&self, net: NetId) -> &[Word] {
        let slots = &self.program.net_slot;
        &self.state.slots[slots[net.index()] as usize..slots[net.index() + 1] as usize]
    }

    fn observe(&mut self, net: NetId) {
        let slots = &self.program.net_slot;
        for slot in slots[net.index()]..slots[net.index() + 1] {
            self.state.meta[slot as usize].flags |= flag::OBSERVED;
        }
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        let slot = self.program.net_slot[net.index()];
        self.start_clock(slot, clock);
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        let slot = self.program.net_slot[net.index()];
        if self.state.forcing {
            self.drive_forced(slot, value);
        }
        for (i, &word) in value.iter().enumerate().take(words(self.widths[net.index()])) {
            self.state.put(&self.program, slot + i as u32, word);
        }
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        self.wave()
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        if !self.started {
            self.wave()?;
            if self.state.has_news() {
                return Ok(true);
            }
        }
        while let Some(time) = self.queue.next().filter(|&t| t <= until) {
            self.now = time;
            self.queue.fire(&self.program, &mut self.state, time);
            self.wave()?;
            if self.state.has_news() {
                return Ok(true);
            }
        }
        self.now = until;
        Ok(false)
    }

    fn next_event(&self) -> Option<u64> {
        self.queue.next()
    }

    fn changes(&self) -> &[NetId] {
        &self.state.changes
    }

    fn clear_changes(&mut self) {
        for net in self.state.changes.drain(..) {
            let slot = self.program.net_slot[net.index()];
            self.state.meta[slot as usize].flags &= !flag::CHANGED;
        }
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        std::mem::take(&mut self.state.unknown_controls)
    }

    fn events(&self) -> Option<u64> {
        Some(self.state.events)
    }

    fn force(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.force_bits(bits, value)
    }

    fn release(&mut self, bits: Slice) {
        self.release_bits(bits);
    }

    fn is_forced(&self) -> bool {
        self.state.forcing
    }

    fn deposit(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.deposit_bits(bits, value)
    }

    fn contents(&self, cell: CellId) -> Option<&[Word]> {
        let number = self.program.memories.iter().position(|m| m.cell == cell)?;
        Some(self.state.memories.contents(number))
    }

    fn set_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool {
        self.put_contents(cell, index, value)
    }

    fn save(&self) -> Snapshot {
        self.snapshot()
    }

    fn restore(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        self.resume(from)
    }

    fn summary(&self) -> String {
        let bytes = self.bytes() / self.cells.max(1);
        format!("engine event, {} net changes, {bytes} bytes a cell", self.state.events)
    }
}
