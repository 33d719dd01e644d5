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
mod log;
mod unsettled;

use std::fmt;

#[cfg(test)]
pub(crate) use discreta_core::{Logic, random};
pub(crate) use discreta_core::{Value, cell, netlist, value};

use crate::cell::Clock;
use crate::netlist::{CellId, NetId};
use crate::value::Word;

#[cfg(feature = "compiled")]
pub use auto::AutoEngine;
#[cfg(feature = "compiled")]
pub use compiled::{CompileError, CompiledEngine, EngineReport};
pub use event::EventEngine;
pub use log::{Field, Log};
pub use unsettled::Unsettled;

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

    /// The changes of traced nets since the log was last cleared, phase after phase, if the engine keeps a log.
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

    /// Which engine it is and how it has gone, in a line for people.
    fn summary(&self) -> String;
}
