//! Engines: what turns a netlist and stimulus into values over time.
//!
//! Every engine keeps the meaning that `docs/meaning.md` fixes, bit for bit; [`EventEngine`] is the reference. This room
//! reads netlists and knows neither files nor waveforms.

#[cfg(feature = "compiled")]
mod auto;
pub mod batch;
#[cfg(feature = "compiled")]
mod compiled;
mod endless;
mod event;
mod force;
mod log;
mod snapshot;
mod unsettled;

use std::fmt;

#[cfg(test)]
pub(crate) use discreta_core::{Logic, random};
pub(crate) use discreta_core::{Value, cell, digest, netlist, value};

use crate::cell::Clock;
use crate::netlist::{CellId, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{copy, word_mask, words};

#[cfg(feature = "compiled")]
pub use auto::AutoEngine;
#[cfg(feature = "compiled")]
pub use compiled::{CompileError, CompiledEngine, EngineReport};
pub use event::EventEngine;
pub use force::Refused;
pub use log::{Field, Log};
pub use snapshot::{Snapshot, SnapshotError};
pub use unsettled::Unsettled;

/// Which engine runs a circuit: a choice of speed, never of result.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[non_exhaustive]
pub enum EngineKind {
    /// The event engine at first, then machine code if the run turns out to be long.
    #[default]
    Auto,
    /// The reference: computes what has changed, cell by cell.
    Event,
    /// Machine code made for the circuit.
    Compiled,
}

/// Why an engine cannot run a circuit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EngineError(String);

impl fmt::Display for EngineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for EngineError {}

impl EngineKind {
    /// An engine of this kind, at tick 0, with nothing settled yet.
    ///
    /// # Errors
    /// What the netlist has that is not compiled; [`Auto`](EngineKind::Auto) and [`Event`](EngineKind::Event) run all.
    pub fn engine(self, netlist: &Netlist) -> Result<Box<dyn Engine>, EngineError> {
        match self {
            #[cfg(feature = "compiled")]
            EngineKind::Auto => Ok(Box::new(AutoEngine::new(netlist))),
            #[cfg(feature = "compiled")]
            EngineKind::Compiled => match CompiledEngine::new(netlist) {
                Ok(engine) => Ok(Box::new(engine)),
                Err(why) => Err(EngineError(format!("the circuit cannot be compiled: {why}"))),
            },
            #[cfg(not(feature = "compiled"))]
            EngineKind::Auto => Ok(Box::new(EventEngine::new(netlist))),
            #[cfg(not(feature = "compiled"))]
            EngineKind::Compiled => Err(EngineError("discreta was built without the feature `compiled`".to_owned())),
            EngineKind::Event => Ok(Box::new(EventEngine::new(netlist))),
        }
    }
}

/// Reads the bits of a signal, the least significant slice first, into as many words as they need.
pub fn read_bits(engine: &dyn Engine, bits: &[Slice], to: &mut [Word]) {
    let mut at = 0;
    // what is above the signal's width counts where words are compared
    to.fill(Word::ZERO);
    for s in bits {
        let from = engine.read(s.net);
        if let ([only], true) = (bits, s.lo == 0) {
            to.copy_from_slice(&from[..words(only.width)]);
            let last = words(only.width) - 1;
            let m = word_mask(only.width, last);
            to[last] = Word { v: to[last].v & m, u: to[last].u & m };
            return;
        }
        copy(to, at, from, s.lo, s.width);
        at += s.width;
    }
}

/// An x or z that reached a clock or control of a storage cell after a known value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct UnknownControl {
    /// The tick at which it arrived.
    pub time: u64,
    /// The storage cell whose control it is.
    pub cell: CellId,
    /// The name of its pin.
    pub pin: &'static str,
    /// The net that the pin reads.
    pub net: NetId,
}

/// Steps a netlist through time.
///
/// An instant has two evaluation phases. [`advance`](Engine::advance) runs the first of each, in which clocks and delays
/// change; [`drive`](Engine::drive) and [`settle`](Engine::settle) run the second at the present tick.
pub trait Engine: fmt::Debug + Send {
    /// The present tick.
    fn now(&self) -> u64;

    /// The present value of a net; z and x bits as in [`Word`].
    fn read(&self, net: NetId) -> &[Word];

    /// Lists the net's changes in [`changes`](Engine::changes), and lets them end an [`advance`](Engine::advance).
    fn observe(&mut self, net: NetId);

    /// Has the net's changes written into the [`log`](Engine::log), which ends no advance; an engine without one
    /// [observes](Engine::observe) the net.
    fn trace(&mut self, net: NetId) {
        self.observe(net);
    }

    /// Whether the changes of traced nets go into the log, rather than being listed as those of observed ones.
    fn logs(&self) -> bool {
        false
    }

    /// The changes of traced nets since the log was last cleared, phase after phase, if the engine keeps a log, or has
    /// kept one of which something is left.
    fn log(&mut self) -> Option<&mut Log> {
        None
    }

    /// Drives an input by a clock from now on.
    fn add_clock(&mut self, net: NetId, clock: Clock);

    /// Changes an input; it takes effect at the next [`settle`](Engine::settle).
    fn drive(&mut self, net: NetId, value: &[Word]);

    /// Runs an evaluation phase at the present tick: delta cycles until nothing changes.
    ///
    /// # Errors
    /// If something never stops changing.
    fn settle(&mut self) -> Result<(), Unsettled>;

    /// Runs the first phase of each instant up to tick `until`. It stops early after an instant at which an observed net
    /// changed or an unknown value reached a control, or when the log has become long. Afterwards [`now`](Engine::now)
    /// is `until` or that instant. Returns whether it stopped early.
    ///
    /// # Errors
    /// If something never stops changing.
    fn advance(&mut self, until: u64) -> Result<bool, Unsettled>;

    /// The tick of the next clock edge or delayed change, if there is one.
    fn next_event(&self) -> Option<u64>;

    /// The observed nets that changed since the last [`clear_changes`](Engine::clear_changes), each once.
    fn changes(&self) -> &[NetId];

    /// Forgets the changes.
    fn clear_changes(&mut self);

    /// The x and z that have reached controls since the last call, each cell once in its life.
    fn take_unknown_controls(&mut self) -> Vec<UnknownControl>;

    /// How many net changes there have been, if the engine counts them.
    fn events(&self) -> Option<u64>;

    /// Holds some bits of a net at `value`, whose bit 0 is the lowest of them, whatever drives them, until they are
    /// [released](Engine::release). It takes effect at the next [`settle`](Engine::settle).
    ///
    /// # Errors
    /// If constants decide one of the bits. Nothing is forced then.
    fn force(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused>;

    /// Lets go of bits that were forced, and does nothing with others. At the next [`settle`](Engine::settle) they have what
    /// drives them; the state of a storage cell stays what it was held at until it samples again.
    fn release(&mut self, bits: Slice);

    /// Whether any bits are forced.
    fn is_forced(&self) -> bool;

    /// Sets an input, or the state of a storage cell, once: it is what it would be if it had come to that by itself. It
    /// takes effect at the next [`settle`](Engine::settle).
    ///
    /// # Errors
    /// If the net is neither. Nothing is set then.
    fn deposit(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused>;

    /// What a memory holds, laid out as [`Memory::contents`](crate::cell::Memory::contents); none of a cell that is no
    /// memory, or one that nothing reads.
    fn contents(&self, cell: CellId) -> Option<&[Word]>;

    /// Sets word `index`, counted from 0, of a memory; returns whether there is such a word. It takes effect at the next
    /// [`settle`](Engine::settle).
    fn set_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool;

    /// The whole state, for this or another engine of the netlist, with what waits for the next
    /// [`settle`](Engine::settle).
    fn save(&self) -> Snapshot;

    /// Goes back, or on, to a saved state. What is observed and traced stays so; observed nets that are another than they
    /// were count as changed.
    ///
    /// # Errors
    /// If it is of another netlist. Nothing has happened then.
    fn restore(&mut self, from: &Snapshot) -> Result<(), SnapshotError>;

    /// Which engine it is and how it has gone, in a line for people.
    fn summary(&self) -> String;
}
