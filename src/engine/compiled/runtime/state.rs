//! What the engine holds beside memory, by what it is for.

use super::feedback::Fixpoint;
use super::guards::Guards;
use super::tracing::Tracing;
use super::variants::Variant;
use super::{EngineReport, NEVER};
use crate::UnknownControl;
use crate::cell::Clock;
use crate::compiled::codegen::Shared;
use crate::compiled::ir::places::Slot;
use crate::compiled::lower::layout::{Kept, StateLayout};
use crate::netlist::{NetId, Netlist};
use crate::value::Word;

/// Which nets somebody looks at, and what of them has changed.
#[derive(Debug)]
pub(crate) struct Observation {
    /// The number of each net that is observed or traced.
    pub number: Vec<Option<u32>>,
    /// These nets, by number.
    pub nets: Vec<NetId>,
    /// Whether a change of each stops a run: of one that is only traced it is written down, and the run goes on.
    pub stops: Vec<bool>,
    pub tracing: Tracing,
    /// The nets whose values lie in memory: observed ones, clock pins, controls.
    pub kept: Vec<Kept>,
    /// Whether these have their places, and the variants were compiled for them.
    pub prepared: bool,
    /// Nets that stop a run and have changed since they were last asked for, each once.
    pub changes: Vec<NetId>,
    /// Whether each net is among them.
    pub listed: Vec<bool>,
}

impl Observation {
    pub fn new(netlist: &Netlist) -> Observation {
        let nets = netlist.nets().len();
        Observation {
            number: vec![None; nets],
            nets: Vec::new(),
            stops: Vec::new(),
            tracing: Tracing::default(),
            kept: Vec::new(),
            prepared: false,
            changes: Vec::new(),
            listed: vec![false; nets],
        }
    }

    /// Lists a net as changed.
    pub fn list(&mut self, net: NetId) {
        if !std::mem::replace(&mut self.listed[net.index()], true) {
            self.changes.push(net);
        }
    }

    /// Sees to it that a change of an observed or traced net becomes known.
    #[inline(always)]
    pub fn note(&mut self, number: usize) {
        if self.stops[number] {
            self.list(self.nets[number]);
        }
        if self.tracing.nets[number] {
            self.tracing.changed.insert(number);
        }
    }

    /// Forgets all changes.
    pub fn clear(&mut self) {
        for net in self.changes.drain(..) {
            self.listed[net.index()] = false;
        }
    }
}

/// The variants that have been compiled, and which one runs.
#[derive(Debug)]
pub(crate) struct Variants {
    pub list: Vec<Variant>,
    pub current: Option<usize>,
    /// Some state is unknown that the current variant assumes to be known: before anything reads it, another is to run.
    pub guard_failed: bool,
    /// Straight code has run, which does not keep what partitions leave each other.
    pub stale: bool,
    /// The most operations in a partition.
    pub partition_size: usize,
    /// Where all variants find what they share with the engine.
    pub shared: Shared,
    /// A slot of state that was unknown when one was last looked for: it is where the next search begins.
    pub last_unknown: Slot,
    pub guards: Guards,
}

impl Variants {
    pub fn new(layout: &StateLayout, partition_size: usize) -> Variants {
        Variants {
            list: Vec::new(),
            current: None,
            guard_failed: false,
            stale: false,
            partition_size,
            shared: Shared::default(),
            last_unknown: layout.leaves.start,
            guards: Guards::new(),
        }
    }

    /// The variant that runs.
    #[inline(always)]
    pub fn running(&self) -> &Variant {
        &self.list[self.current.expect("a phase has chosen one")]
    }

    #[inline(always)]
    pub fn running_mut(&mut self) -> &mut Variant {
        &mut self.list[self.current.expect("a phase has chosen one")]
    }
}

/// A clock that the engine drives itself.
#[derive(Debug)]
pub(crate) struct Source {
    pub slot: Slot,
    pub clock: Clock,
    pub high: bool,
    /// The tick of its next edge.
    pub next: u64,
}

/// Time, the clocks, and the input that changes next.
#[derive(Debug)]
pub(crate) struct Clocks {
    /// The present tick.
    pub now: u64,
    pub sources: Vec<Source>,
    /// The tick of the next edge of any of them; [`NEVER`] if there is none.
    pub next: u64,
    /// An input of one bit that was driven alone, and what to: its edge may be straight code.
    pub pending: Option<(Slot, bool)>,
}

impl Clocks {
    pub fn new() -> Clocks {
        Clocks { now: 0, sources: Vec::new(), next: NEVER, pending: None }
    }

    /// Works out anew when the next edge is.
    pub fn schedule(&mut self) {
        self.next = self.sources.iter().map(|c| c.next).min().unwrap_or(NEVER);
    }
}

/// What settling a phase needs to remember.
#[derive(Debug)]
pub(crate) struct Settling {
    /// Slot and shift of each clock pin, and its bit when edges were last looked for.
    pub pins: Vec<(Slot, u32)>,
    pub pins_before: Vec<Word>,
    /// Storage cells, by number, whose clock has made its edge.
    pub active: Vec<u32>,
    /// How many times the partition of each combinational loop has run since all was settled.
    pub loop_runs: Vec<u32>,
    pub fixpoint: Fixpoint,
    /// Nets of loops that never settle.
    pub endless: Vec<NetId>,
    /// Something has been written since the last phase.
    pub touched: bool,
    /// There has been a phase, so memory holds values.
    pub started: bool,
    /// The circuit has not settled yet: what nets become until then is no edge.
    pub first: bool,
}

impl Settling {
    pub fn new(layout: &StateLayout, pins_before: Vec<Word>) -> Settling {
        Settling {
            pins: Vec::new(),
            pins_before,
            active: Vec::new(),
            loop_runs: vec![0; layout.loops.len()],
            fixpoint: Fixpoint::default(),
            endless: Vec::new(),
            touched: true,
            started: false,
            first: true,
        }
    }
}

/// What is reported beside values.
#[derive(Debug)]
pub(crate) struct Diagnostics {
    /// Slot and shift of each control bit.
    pub places: Vec<(Slot, u32)>,
    /// Whether each control bit has had a known value: only after that is an unknown one reported.
    pub seen: Vec<bool>,
    /// Whether a control of each cell has been reported.
    pub reported: Vec<bool>,
    pub unknown_controls: Vec<UnknownControl>,
    pub report: EngineReport,
}

impl Diagnostics {
    pub fn new(netlist: &Netlist, seen: Vec<bool>) -> Diagnostics {
        Diagnostics {
            places: Vec::new(),
            seen,
            reported: vec![false; netlist.cells().len()],
            unknown_controls: Vec::new(),
            report: EngineReport::default(),
        }
    }
}
