//! The engine as it runs: the memory, its variants in machine code, and what calls them.

mod clock;
mod contents;
pub(crate) mod feedback;
mod narrow;
pub(crate) mod on_demand;
mod report;
mod settle;
pub(crate) mod tracing;
pub(crate) mod variants;

use crate::cell::{CellKind, Clock};
use crate::compiled::CompileError;
use crate::compiled::codegen;
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::lower::{layout, support};
use crate::netlist::{NetId, Netlist};
use crate::value::Word;
use crate::value::word::words;
use crate::{Engine, EventEngine, Log, UnknownControl, Unsettled};

use crate::compiled::codegen::Shared;
use crate::compiled::lower::layout::Kept;
use crate::compiled::lower::layout::Wiring;
use crate::compiled::runtime::tracing::Tracing;
use crate::compiled::runtime::variants::{DEFAULT_CHUNK, Form};
use feedback::Steps;
use narrow::Looks;
use on_demand::{Held, Keeps, Peeked};
pub use report::EngineReport;

/// Ticks that were left before they did anything after which they are no longer tried.
pub(crate) const ABORTS: u32 = 64;
/// Runs of a loop's chunk after which it is looked at step by step.
pub(crate) const STEPS_COMPILED: u32 = 64;
/// Waves in a form after which ticks are made in one piece, and nodes for which it is one more.
pub(crate) const WARM: u64 = 16;
pub(crate) const WARM_NODES: usize = 64;
/// Waves in the four-valued form after which one is made that takes all to be known that is.
pub(crate) const PATIENCE: u64 = 64;
pub(crate) const NEVER: u64 = u64::MAX;

/// The engine that compiles; see [`Engine`] and `docs/engines.md`.
#[derive(Debug)]
pub struct CompiledEngine<'n> {
    netlist: &'n Netlist,
    wiring: Wiring,
    memory: Vec<Word>,
    kept: Vec<Kept>,
    observed: Vec<Option<u32>>,
    observed_nets: Vec<NetId>,
    /// Whether a change of each of these is listed, and not only written down.
    stops: Vec<bool>,
    tracing: Tracing,
    /// Where the bits of observed nets that have changed begin; set when a form is made.
    shared: Shared,
    /// Whether everything that is observed has a place, and the variants were made for it.
    prepared: bool,
    forms: Vec<Form>,
    current: Option<usize>,
    /// The state holds what the current form takes to be known, and is not.
    alarmed: bool,
    /// Ticks in one piece have run, which do not keep what chunks leave each other.
    stale: bool,
    /// An input of one bit that changes at the next wave.
    pending: Option<(Slot, bool)>,
    /// How often in turn a tick could not be made in one piece.
    aborted: u32,
    /// Something has been written since the last wave.
    touched: bool,
    chunk: usize,
    /// Each clock pin when edges were last looked for.
    watches: Vec<Word>,
    /// Whether the circuit has not settled yet: what nets become until then is no edge.
    first: bool,
    /// Slot and shift of each clock pin and of each control bit.
    pin_places: Vec<(Slot, u32)>,
    control_places: Vec<(Slot, u32)>,
    control_seen: Vec<bool>,
    reported: Vec<bool>,
    unknown_controls: Vec<UnknownControl>,
    active: Vec<u32>,
    changes: Vec<NetId>,
    listed: Vec<bool>,
    peeked: Peeked,
    /// How often the chunk of each loop has run since all was settled.
    loop_runs: Vec<u32>,
    steps: Steps,
    /// Nets of loops that never settle.
    endless: Vec<NetId>,
    clocks: Vec<Source>,
    next_clock: u64,
    now: u64,
    started: bool,
    /// A slot that was unknown when last looked for, and how long that has gone on.
    last_unknown: Slot,
    patience: u64,
    looks: Looks,
    report: EngineReport,
}

#[derive(Debug)]
struct Source {
    slot: Slot,
    clock: Clock,
    high: bool,
    next: u64,
}

impl<'n> CompiledEngine<'n> {
    /// Whether the engine can run a netlist, and if not, why.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn supports(netlist: &Netlist) -> Result<(), CompileError> {
        support::check(netlist)?;
        codegen::available()
    }

    /// An engine at tick 0, with nothing settled yet. Code is made at the first wave, when it is known what is observed.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn new(netlist: &'n Netlist) -> Result<CompiledEngine<'n>, CompileError> {
        CompiledEngine::with_chunk(netlist, DEFAULT_CHUNK)
    }

    /// The same with at most `chunk` operations computed together.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn with_chunk(netlist: &'n Netlist, chunk: usize) -> Result<CompiledEngine<'n>, CompileError> {
        CompiledEngine::supports(netlist)?;
        // slot 0 has the alarm
        let wiring = Wiring::new(netlist, 1);
        let memory = wiring.initial.clone();
        let bit = |b: layout::Bit| {
            let w = layout::initial(netlist, b.net)[b.lo as usize / 64];
            bit_of(w, b.lo % 64)
        };
        // a control that acts when it becomes active does if it is from the start
        let watch = |p: &layout::ClockPin| Some(bit(p.bit)).filter(|_| !p.level).unwrap_or(Word::x(1));
        let watches = wiring.pins.iter().map(watch).collect();
        let control_seen = wiring.controls.iter().map(|c| bit(c.0).is_known()).collect();
        let mut engine = CompiledEngine {
            netlist,
            memory,
            kept: Vec::new(),
            observed: vec![None; netlist.nets().len()],
            observed_nets: Vec::new(),
            stops: Vec::new(),
            tracing: Tracing::default(),
            shared: Shared::default(),
            prepared: false,
            forms: Vec::new(),
            current: None,
            alarmed: false,
            stale: false,
            pending: None,
            aborted: 0,
            touched: true,
            chunk,
            watches,
            first: true,
            pin_places: Vec::new(),
            control_places: Vec::new(),
            control_seen,
            reported: vec![false; netlist.cells().len()],
            unknown_controls: Vec::new(),
            active: Vec::new(),
            changes: Vec::new(),
            listed: vec![false; netlist.nets().len()],
            peeked: Peeked::new(netlist, &wiring),
            loop_runs: vec![0; wiring.loops.len()],
            steps: Steps::default(),
            endless: Vec::new(),
            clocks: Vec::new(),
            next_clock: NEVER,
            now: 0,
            started: false,
            last_unknown: wiring.leaves.start,
            patience: PATIENCE,
            looks: Looks::from(0, PATIENCE / 2),
            report: EngineReport::default(),
            wiring,
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
        netlist: &'n Netlist,
        from: &EventEngine,
        observed: &[NetId],
        traced: &[NetId],
    ) -> Result<CompiledEngine<'n>, CompileError> {
        let mut engine = CompiledEngine::new(netlist)?;
        let given = from.hand_over();
        for i in 0..engine.wiring.leaf_net.len() {
            let net = engine.wiring.leaf_net[i];
            let slot = engine.wiring.leaves.start + i as u32;
            let Some(first) = engine.wiring.slot[net.index()] else { continue };
            engine.memory[slot.index()] = from.read(net)[(slot - first) as usize];
        }
        engine.take_contents(from);
        engine.now = from.now();
        engine.started = true;
        engine.first = false;
        for (pin, watch) in engine.wiring.pins.iter().zip(&mut engine.watches) {
            let word = from.read(pin.bit.net)[pin.bit.lo as usize / 64];
            *watch = bit_of(word, pin.bit.lo % 64);
        }
        for (control, (_, pins)) in engine.control_seen.iter_mut().zip(&engine.wiring.controls) {
            *control = given.control_seen[pins[0] as usize];
        }
        engine.reported[..given.reported.len()].copy_from_slice(&given.reported);
        engine.clocks.clear();
        for (net, clock, high, next) in given.clocks {
            let slot = engine.wiring.slot[net.index()].expect("an input has a place");
            engine.clocks.push(Source { slot, clock, high, next });
        }
        engine.next_clock = engine.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        engine.changes.clear();
        engine.listed.fill(false);
        observed.iter().for_each(|&net| engine.observe(net));
        traced.iter().for_each(|&net| engine.trace(net));
        Ok(engine)
    }

    /// How the run has gone.
    #[must_use]
    pub fn report(&self) -> EngineReport {
        self.report
    }

    /// What is kept in memory: clock pins, controls, observed nets. Code made for other nets goes.
    fn prepare(&mut self) {
        let observed = self.observed_nets.iter().map(|&net| (net, true));
        let pins = self.wiring.pins.iter().map(|p| (p.bit.net, true));
        let controls = self.wiring.controls.iter().map(|c| (c.0.net, false));
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
        self.shared.changed = Slot::at(self.memory.len()).value();
        self.memory.extend((0..self.observed_nets.len().div_ceil(128)).map(|_| Word::ZERO));
        self.prepare_log();
        let kept = |(net, always): (NetId, bool)| {
            let observed = self.observed[net.index()];
            let is = |list: &[bool]| observed.is_some_and(|bit| list[bit as usize]);
            Kept { net, observed, stops: is(&self.stops), traced: is(&self.tracing.nets), always }
        };
        self.kept = nets.into_iter().map(kept).collect();
        let place =
            |b: layout::Bit, slot: &[Option<Slot>]| (slot[b.net.index()].expect("it is kept") + b.lo / 64, b.lo % 64);
        self.pin_places = self.wiring.pins.iter().map(|p| place(p.bit, &self.wiring.slot)).collect();
        self.control_places = self.wiring.controls.iter().map(|c| place(c.0, &self.wiring.slot)).collect();
        self.forms.clear();
        self.current = None;
        self.prepared = true;
    }

    /// The number of a net whose changes are to be found out. Code is made anew for it at the next wave.
    fn watch(&mut self, net: NetId) -> usize {
        self.prepared = false;
        if let Some(bit) = self.observed[net.index()] {
            return bit as usize;
        }
        let bit = self.observed_nets.len();
        self.observed[net.index()] = Some(bit as u32);
        self.observed_nets.push(net);
        self.stops.push(false);
        self.tracing.nets.push(false);
        if self.started {
            self.place(net);
        }
        bit
    }

    /// Gives a net a place with its present value, if it has none.
    fn place(&mut self, net: NetId) {
        if self.wiring.slot[net.index()].is_none() {
            let now = if self.started { self.read(net).to_vec() } else { layout::initial(self.netlist, net) };
            self.wiring.slot[net.index()] = Some(Slot::at(self.memory.len()));
            self.memory.extend(now);
        }
    }

    fn has_news(&self) -> bool {
        !(self.changes.is_empty() && self.unknown_controls.is_empty())
    }

    fn put_input(&mut self, slot: Slot, new: Word) {
        self.touched = true;
        let net = self.wiring.leaf_net[(slot - self.wiring.leaves.start) as usize];
        self.put(slot, net, new);
    }
}

impl Engine for CompiledEngine<'_> {
    fn now(&self) -> u64 {
        self.now
    }

    fn read(&self, net: NetId) -> &[Word] {
        let keeps = self.current.map_or(Keeps::All, |n| Keeps::These(&self.forms[n].keeps));
        let held = Held { netlist: self.netlist, wiring: &self.wiring, memory: &self.memory, keeps };
        match held.net(net) {
            Some(value) => value,
            None => self.peeked.read(&held, net),
        }
    }

    fn observe(&mut self, net: NetId) {
        let bit = self.watch(net);
        self.stops[bit] = true;
    }

    fn trace(&mut self, net: NetId) {
        let bit = self.watch(net);
        self.tracing.nets[bit] = true;
    }

    fn log(&mut self) -> Option<&mut Log> {
        self.tracing.nets.contains(&true).then(|| {
            self.take_log();
            &mut self.tracing.log
        })
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        let slot = self.wiring.slot[net.index()].expect("an input has a place");
        self.clocks.retain(|c| c.slot != slot);
        let high = clock.phase == 0;
        let next = if high { clock.high } else { clock.phase };
        self.clocks.push(Source { slot, clock, high, next });
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        self.put_input(slot, Word::known(u64::from(high)));
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        self.peeked.clear();
        let slot = self.wiring.slot[net.index()].expect("an input has a place");
        if let Some((before, level)) = self.pending.take() {
            self.put_input(before, Word::known(level.into()));
        }
        // an input of one bit that changes alone may be a tick
        if let (false, 1, &[new]) = (self.touched, self.netlist.net(net).width, value)
            && new.is_known()
            && self.memory[slot.index()] == Word::known(new.v ^ 1)
        {
            self.pending = Some((slot, new.v == 1));
            return;
        }
        for (i, &word) in (0..).zip(value).take(words(self.netlist.net(net).width)) {
            self.put_input(slot + i, word);
        }
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        match self.pending.take() {
            Some((slot, level)) => self.tick(slot, level),
            None => self.wave(),
        }
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        if !self.started {
            self.wave()?;
            if self.has_news() {
                return Ok(true);
            }
        }
        while self.next_clock <= until && self.next_clock != NEVER {
            if !self.run_clock(until)? {
                self.now = self.next_clock;
                self.fire();
                self.wave()?;
            }
            if self.has_news() || self.tracing.is_long() {
                return Ok(true);
            }
        }
        self.now = until;
        Ok(false)
    }

    fn next_event(&self) -> Option<u64> {
        (self.next_clock != NEVER).then_some(self.next_clock)
    }

    fn changes(&self) -> &[NetId] {
        &self.changes
    }

    fn clear_changes(&mut self) {
        for net in self.changes.drain(..) {
            self.listed[net.index()] = false;
        }
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        std::mem::take(&mut self.unknown_controls)
    }

    fn events(&self) -> Option<u64> {
        None
    }

    fn summary(&self) -> String {
        self.report.to_string()
    }
}

/// Half a slot.
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
