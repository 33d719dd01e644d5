//! The engine as it runs: the memory, its variants in machine code, and what calls them.

mod clock;
mod contents;
pub(crate) mod cycle;
pub(crate) mod feedback;
mod guards;
pub(crate) mod on_demand;
mod reference;
mod report;
mod settle;
mod snapshot;
mod state;
pub(crate) mod tracing;
pub(crate) mod variants;

use crate::cell::{CellKind, Clock};
use crate::compiled::CompileError;
use crate::compiled::codegen;
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::lower::{layout, support};
use crate::netlist::{CellId, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::words;
use crate::{Engine, EventEngine, Log, Refused, Snapshot, SnapshotError, UnknownControl, Unsettled, Value};

use crate::compiled::lower::layout::Kept;
use crate::compiled::lower::layout::StateLayout;
use crate::compiled::runtime::variants::PARTITION_SIZE;
use on_demand::{Keeps, OnDemand, StateView};
use reference::Reference;
pub use report::EngineReport;
use state::{Clocks, Diagnostics, Observation, Settling, Source, Variants};

/// After this many bail-outs the straight code of an input is made anew, if controls have told of themselves meanwhile.
pub(crate) const BAIL_OUTS: u32 = 8;
/// The most edges that straight code sits out after it has bailed out again and again.
pub(crate) const MOST_WAITING: u32 = 256;
/// Runs of the unrolled iteration of a loop in one phase after which it is iterated step by step.
pub(crate) const MOST_LOOP_RUNS: u32 = 64;
/// Nets that the summary names.
const SHOWN: usize = 3;
/// Phases in a variant after which edges are compiled as straight code, and nodes for which it is one phase more.
pub(crate) const WARM: u64 = 16;
pub(crate) const WARM_NODES: usize = 64;
/// Phases in the four-valued variant after which one may be compiled that assumes known all that is.
pub(crate) const PATIENCE: u64 = 64;
pub(crate) const NEVER: u64 = u64::MAX;

/// The engine that compiles; see [`Engine`] and `docs/engines.md`.
#[derive(Debug)]
pub struct CompiledEngine {
    netlist: Netlist,
    layout: StateLayout,
    /// What every slot holds: inputs and state, the contents of memories, nets that are kept, and what generated code
    /// keeps for itself.
    memory: Vec<Word>,
    observation: Observation,
    variants: Variants,
    clocks: Clocks,
    settling: Settling,
    diagnostics: Diagnostics,
    on_demand: OnDemand,
    reference: Reference,
}

impl CompiledEngine {
    /// Whether the engine can run a netlist, and if not, why.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn supports(netlist: &Netlist) -> Result<(), CompileError> {
        support::check(netlist)?;
        codegen::available()
    }

    /// An engine at tick 0, with nothing settled yet. Code is made at the first phase, when it is known what is observed.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn new(netlist: &Netlist) -> Result<CompiledEngine, CompileError> {
        CompiledEngine::with_partition_size(netlist, PARTITION_SIZE)
    }

    /// The same with at most `partition` operations computed together.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn with_partition_size(netlist: &Netlist, partition: usize) -> Result<CompiledEngine, CompileError> {
        CompiledEngine::supports(netlist)?;
        // slot 0 has the guard
        let layout = StateLayout::new(netlist, 1);
        let memory = layout.initial.clone();
        let bit = |b: layout::Bit| {
            let w = layout::initial(netlist, b.net)[b.lo as usize / 64];
            bit_of(w, b.lo % 64)
        };
        // a control that acts when it becomes active does if it is from the start
        let watch = |p: &layout::ClockPin| Some(bit(p.bit)).filter(|_| !p.level).unwrap_or(Word::x(1));
        let watches = layout.pins.iter().map(watch).collect();
        let control_seen = layout.controls.iter().map(|c| bit(c.0).is_known()).collect();
        let mut engine = CompiledEngine {
            netlist: netlist.clone(),
            memory,
            observation: Observation::new(netlist),
            variants: Variants::new(&layout, partition),
            clocks: Clocks::new(),
            settling: Settling::new(&layout, watches),
            diagnostics: Diagnostics::new(netlist, control_seen),
            on_demand: OnDemand::new(netlist, &layout),
            reference: Reference::default(),
            layout,
        };
        for cell in netlist.cell_ids() {
            if let CellKind::Clock(clock) = netlist.cell(cell).kind {
                engine.add_clock(netlist.output(cell, 0), clock);
            }
        }
        Ok(engine)
    }

    /// An engine that goes on from where the event engine is, with everything settled and no changes untold.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub(crate) fn resume(
        netlist: &Netlist,
        from: &EventEngine,
        observed: &[NetId],
        traced: &[NetId],
    ) -> Result<CompiledEngine, CompileError> {
        let mut engine = CompiledEngine::new(netlist)?;
        engine.load(&from.save());
        observed.iter().for_each(|&net| engine.observe(net));
        traced.iter().for_each(|&net| engine.trace(net));
        Ok(engine)
    }

    /// How the run has gone.
    #[must_use]
    pub fn report(&self) -> EngineReport {
        self.diagnostics.report
    }

    /// What is kept in memory: clock pins, controls, observed nets. Code made for other nets goes.
    fn prepare(&mut self) {
        let observed = self.observation.nets.iter().map(|&net| (net, true));
        let pins = self.layout.pins.iter().map(|p| (p.bit.net, true));
        let controls = self.layout.controls.iter().map(|c| (c.0.net, false));
        let mut nets: Vec<(NetId, bool)> = Vec::new();
        let mut seen = vec![false; self.netlist.nets().len()];
        for (net, always) in observed.chain(pins).chain(controls) {
            if !std::mem::replace(&mut seen[net.index()], true) {
                nets.push((net, always));
            }
        }
        // places of what was kept before stay; those of old code are not used again
        for &(net, _) in &nets {
            self.place(net);
        }
        self.variants.shared.changed = Slot::at(self.memory.len()).value();
        self.memory.extend((0..self.observation.nets.len().div_ceil(128)).map(|_| Word::ZERO));
        self.prepare_log();
        let kept = |(net, always): (NetId, bool)| {
            let observed = self.observation.number[net.index()];
            let is = |list: &[bool]| observed.is_some_and(|bit| list[bit as usize]);
            Kept {
                net,
                observed,
                stops: is(&self.observation.stops),
                traced: is(&self.observation.tracing.nets),
                always,
            }
        };
        self.observation.kept = nets.into_iter().map(kept).collect();
        let place =
            |b: layout::Bit, slot: &[Option<Slot>]| (slot[b.net.index()].expect("it is kept") + b.lo / 64, b.lo % 64);
        self.settling.pins = self.layout.pins.iter().map(|p| place(p.bit, &self.layout.slot)).collect();
        self.diagnostics.places = self.layout.controls.iter().map(|c| place(c.0, &self.layout.slot)).collect();
        self.variants.list.clear();
        self.variants.current = None;
        self.observation.prepared = true;
    }

    /// The number of a net whose changes are to be found out. Code is made anew for it at the next phase.
    fn watch(&mut self, net: NetId) -> usize {
        self.observation.prepared = false;
        if let Some(bit) = self.observation.number[net.index()] {
            return bit as usize;
        }
        let bit = self.observation.nets.len();
        self.observation.number[net.index()] = Some(bit as u32);
        self.observation.nets.push(net);
        self.observation.stops.push(false);
        self.observation.tracing.nets.push(false);
        if self.settling.started {
            self.place(net);
        }
        bit
    }

    /// Gives a net a place with its present value, if it has none.
    fn place(&mut self, net: NetId) {
        if self.layout.slot[net.index()].is_none() {
            let now = if self.settling.started { self.read(net).to_vec() } else { layout::initial(&self.netlist, net) };
            self.layout.slot[net.index()] = Some(Slot::at(self.memory.len()));
            self.memory.extend(now);
        }
    }

    fn has_news(&self) -> bool {
        !(self.observation.changes.is_empty() && self.diagnostics.unknown_controls.is_empty())
    }

    fn put_input(&mut self, slot: Slot, new: Word) {
        self.settling.touched = true;
        let net = self.layout.leaf_net[(slot - self.layout.leaves.start) as usize];
        self.put(slot, net, new);
    }
}

impl Engine for CompiledEngine {
    fn now(&self) -> u64 {
        if let Some(engine) = self.reference.active() {
            return engine.now();
        }
        self.clocks.now
    }

    fn read(&self, net: NetId) -> &[Word] {
        if let Some(engine) = self.reference.active() {
            return engine.read(net);
        }
        let keeps = self.variants.current.map_or(Keeps::All, |n| Keeps::These(&self.variants.list[n].keeps));
        let held = StateView { netlist: &self.netlist, layout: &self.layout, memory: &self.memory, keeps };
        match held.net(net) {
            Some(value) => value,
            None => self.on_demand.read(&held, net),
        }
    }

    fn observe(&mut self, net: NetId) {
        self.reference.observe(net);
        let bit = self.watch(net);
        self.observation.stops[bit] = true;
    }

    fn trace(&mut self, net: NetId) {
        self.reference.observe(net);
        let bit = self.watch(net);
        self.observation.tracing.nets[bit] = true;
    }

    fn logs(&self) -> bool {
        self.reference.active().is_none() && self.observation.tracing.nets.contains(&true)
    }

    fn log(&mut self) -> Option<&mut Log> {
        if self.reference.active().is_some() {
            self.take_log();
            return Some(&mut self.observation.tracing.log).filter(|log| !log.words.is_empty());
        }
        self.observation.tracing.nets.contains(&true).then(|| {
            self.take_log();
            &mut self.observation.tracing.log
        })
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        if let Some(engine) = self.by_reference() {
            return engine.add_clock(net, clock);
        }
        let slot = self.layout.slot[net.index()].expect("an input has a place");
        self.clocks.sources.retain(|c| c.slot != slot);
        let high = clock.phase == 0;
        let next = if high { clock.high } else { clock.phase };
        self.clocks.sources.push(Source { slot, clock, high, next });
        self.clocks.schedule();
        self.put_input(slot, Word::known(u64::from(high)));
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        if let Some(engine) = self.by_reference() {
            return engine.drive(net, value);
        }
        self.on_demand.clear();
        let slot = self.layout.slot[net.index()].expect("an input has a place");
        if let Some((before, level)) = self.clocks.pending.take() {
            self.put_input(before, Word::known(level.into()));
        }
        // an input of one bit that changes alone may be an edge
        if let (false, 1, &[new]) = (self.settling.touched, self.netlist.net(net).width, value)
            && new.is_known()
            && self.memory[slot.index()] == Word::known(new.v ^ 1)
        {
            self.clocks.pending = Some((slot, new.v == 1));
            return;
        }
        for (i, &word) in (0..).zip(value).take(words(self.netlist.net(net).width)) {
            self.put_input(slot + i, word);
        }
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        if let Some(engine) = self.reference.active_mut() {
            return engine.settle();
        }
        match self.clocks.pending.take() {
            Some((slot, level)) => self.run_edge(slot, level),
            None => self.phase(),
        }
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        if let Some(engine) = self.by_reference() {
            return engine.advance(until);
        }
        if !self.settling.started {
            self.phase()?;
            if self.has_news() {
                return Ok(true);
            }
        }
        while self.clocks.next <= until && self.clocks.next != NEVER {
            if !self.run_clock(until)? {
                self.clocks.now = self.clocks.next;
                self.fire();
                self.phase()?;
            }
            if self.has_news() || self.observation.tracing.is_long() {
                return Ok(true);
            }
        }
        self.clocks.now = until;
        Ok(false)
    }

    fn next_event(&self) -> Option<u64> {
        if let Some(engine) = self.reference.active() {
            return engine.next_event();
        }
        (self.clocks.next != NEVER).then_some(self.clocks.next)
    }

    fn changes(&self) -> &[NetId] {
        if let Some(engine) = self.reference.active() {
            return engine.changes();
        }
        &self.observation.changes
    }

    fn clear_changes(&mut self) {
        if let Some(engine) = self.reference.active_mut() {
            return engine.clear_changes();
        }
        self.observation.clear();
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        if let Some(engine) = self.reference.active_mut() {
            return engine.take_unknown_controls();
        }
        std::mem::take(&mut self.diagnostics.unknown_controls)
    }

    fn events(&self) -> Option<u64> {
        None
    }

    fn force(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.reference().force(bits, value)
    }

    fn release(&mut self, bits: Slice) {
        if let Some(engine) = self.reference.active_mut() {
            engine.release(bits);
        }
    }

    fn is_forced(&self) -> bool {
        self.reference.active().is_some_and(Engine::is_forced)
    }

    fn deposit(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.reference().deposit(bits, value)
    }

    fn contents(&self, cell: CellId) -> Option<&[Word]> {
        match self.reference.active() {
            Some(engine) => engine.contents(cell),
            None => self.held_contents(cell),
        }
    }

    fn set_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool {
        self.reference().set_contents(cell, index, value)
    }

    fn save(&self) -> Snapshot {
        match self.reference.active() {
            Some(engine) => engine.save(),
            None => self.snapshot(),
        }
    }

    fn restore(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        self.take_up(from)
    }

    fn summary(&self) -> String {
        let mut summary = self.diagnostics.report.to_string();
        let mut failed: Vec<(NetId, u64)> = Vec::new();
        for (&slot, &count) in &self.variants.guards.failures {
            let net = self.layout.leaf_net[(slot - self.layout.leaves.start) as usize];
            match failed.iter_mut().find(|f| f.0 == net) {
                Some(found) => found.1 += count,
                None => failed.push((net, count)),
            }
        }
        failed.sort_by_key(|&(net, count)| (std::cmp::Reverse(count), net));
        for (number, &(net, count)) in failed.iter().take(SHOWN).enumerate() {
            let before = if number == 0 { "; unknown against expectation: " } else { ", " };
            summary += &format!("{before}{} {count} times", self.netlist.net_name(net));
        }
        if failed.len() > SHOWN {
            summary += &format!(", and {} more nets", failed.len() - SHOWN);
        }
        summary
    }
}

/// A plane word.
#[inline(always)]
pub(crate) fn word_of(memory: &mut [Word], plane: PlaneWord) -> &mut u64 {
    let word = &mut memory[plane.slot().index()];
    if plane.is_value() { &mut word.v } else { &mut word.u }
}

pub(crate) fn set_bit(memory: &mut [Word], first: PlaneWord, bit: u32) {
    *word_of(memory, first + bit / 64) |= 1 << (bit % 64);
}

#[inline(always)]
pub(crate) fn bit_of(w: Word, shift: u32) -> Word {
    Word { v: w.v >> shift & 1, u: w.u >> shift & 1 }
}

/// An engine can be made in one thread and run in another: whoever embeds it may need that.
const _: fn() = || {
    fn moves<T: Send>() {}
    moves::<CompiledEngine>();
};
