//! The engine for whoever does not want to choose: the event engine at first, which is there at once, and the compiled
//! one for a run that turns out to be long enough for code to be made.
//!
//! When that is depends on the run alone, not on the machine. Both give the same values, so nobody can tell.

use super::{
    CompileError, CompiledEngine, Engine, EventEngine, Log, Refused, Snapshot, SnapshotError, UnknownControl, Unsettled,
};
use crate::Value;
use crate::cell::Clock;
use crate::netlist::{CellId, NetId, Netlist, Slice};
use crate::value::Word;

/// Net changes of the event engine, and those for each cell, in about as long as code takes to be made.
const PATIENCE: u64 = 20_000;
const PATIENCE_PER_CELL: u64 = 400;

#[derive(Debug)]
enum Running {
    Event(Box<EventEngine>),
    Compiled(Box<CompiledEngine>),
}

/// The event engine, and after a while the compiled one; see [`Engine`].
#[derive(Debug)]
pub struct AutoEngine {
    netlist: Netlist,
    running: Running,
    observed: Vec<NetId>,
    traced: Vec<NetId>,
    /// Why the circuit is not compiled.
    refused: Option<CompileError>,
    /// Net changes after which it is.
    patience: u64,
    /// How many net changes there were before it was.
    before: u64,
    /// Nothing has been driven since all has settled.
    settled: bool,
}

impl AutoEngine {
    /// An engine at tick 0, with nothing settled yet.
    #[must_use]
    pub fn new(netlist: &Netlist) -> AutoEngine {
        AutoEngine::with_patience(netlist, PATIENCE + PATIENCE_PER_CELL * netlist.cells().len() as u64)
    }

    /// The same, compiled after `patience` net changes.
    #[must_use]
    pub fn with_patience(netlist: &Netlist, patience: u64) -> AutoEngine {
        let running = Running::Event(Box::new(EventEngine::new(netlist)));
        let (observed, traced) = (Vec::new(), Vec::new());
        AutoEngine {
            netlist: netlist.clone(),
            running,
            observed,
            traced,
            refused: None,
            patience,
            before: 0,
            settled: false,
        }
    }

    fn engine(&self) -> &dyn Engine {
        match &self.running {
            Running::Event(engine) => &**engine,
            Running::Compiled(engine) => &**engine,
        }
    }

    fn engine_mut(&mut self) -> &mut dyn Engine {
        match &mut self.running {
            Running::Event(engine) => &mut **engine,
            Running::Compiled(engine) => &mut **engine,
        }
    }

    /// Goes over to the compiled engine if it is time.
    #[inline(always)]
    fn consider(&mut self) {
        if let Running::Event(engine) = &self.running
            && self.settled
            && self.refused.is_none()
            && !engine.is_forced()
            && engine.net_changes() >= self.patience
            && engine.changes().is_empty()
        {
            self.before = engine.net_changes();
            match CompiledEngine::resume(&self.netlist, engine, &self.observed, &self.traced) {
                Ok(compiled) => self.running = Running::Compiled(Box::new(compiled)),
                Err(why) => self.refused = Some(why),
            }
        }
    }
}

impl Engine for AutoEngine {
    fn now(&self) -> u64 {
        self.engine().now()
    }

    fn read(&self, net: NetId) -> &[Word] {
        self.engine().read(net)
    }

    fn observe(&mut self, net: NetId) {
        self.observed.push(net);
        self.engine_mut().observe(net);
    }

    fn trace(&mut self, net: NetId) {
        self.traced.push(net);
        self.engine_mut().trace(net);
    }

    fn logs(&self) -> bool {
        self.engine().logs()
    }

    fn log(&mut self) -> Option<&mut Log> {
        self.engine_mut().log()
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        self.settled = false;
        self.engine_mut().add_clock(net, clock);
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        self.consider();
        self.settled = false;
        self.engine_mut().drive(net, value);
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        self.settled = true;
        self.engine_mut().settle()
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        loop {
            self.consider();
            let Running::Event(engine) = &mut self.running else { return self.engine_mut().advance(until) };
            // event by event: that a run is long is seen while it is under way
            let next = engine.next_event().filter(|&next| next <= until && self.refused.is_none());
            let stopped = engine.advance(next.unwrap_or(until))?;
            // without a phase on the way, what was driven still waits
            self.settled |= stopped || next.is_some();
            if stopped || engine.now() >= until {
                return Ok(stopped);
            }
        }
    }

    fn next_event(&self) -> Option<u64> {
        self.engine().next_event()
    }

    fn changes(&self) -> &[NetId] {
        self.engine().changes()
    }

    fn clear_changes(&mut self) {
        self.engine_mut().clear_changes();
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        self.engine_mut().take_unknown_controls()
    }

    fn events(&self) -> Option<u64> {
        self.engine().events()
    }

    fn force(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.settled = false;
        self.engine_mut().force(bits, value)
    }

    fn release(&mut self, bits: Slice) {
        self.settled = false;
        self.engine_mut().release(bits);
    }

    fn is_forced(&self) -> bool {
        self.engine().is_forced()
    }

    fn deposit(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.settled = false;
        self.engine_mut().deposit(bits, value)
    }

    fn contents(&self, cell: CellId) -> Option<&[Word]> {
        self.engine().contents(cell)
    }

    fn set_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool {
        self.settled = false;
        self.engine_mut().set_contents(cell, index, value)
    }

    fn save(&self) -> Snapshot {
        self.engine().save()
    }

    fn restore(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        self.engine_mut().restore(from)?;
        self.settled = from.settled;
        Ok(())
    }

    fn summary(&self) -> String {
        let summary = self.engine().summary();
        match (&self.running, &self.refused) {
            (Running::Compiled(_), _) => format!("{summary}; engine event before that, {} net changes", self.before),
            (_, Some(why)) => format!("{summary}; not compiled: {why}"),
            (_, None) => match CompiledEngine::supports(&self.netlist) {
                Ok(()) => format!("{summary}; too short to be compiled"),
                Err(why) => format!("{summary}; not compiled: {why}"),
            },
        }
    }
}
