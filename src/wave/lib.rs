//! Waveforms: writing them while a run goes on, reading them back, and comparing two.
//!
//! A [`Layout`] describes the variables, a [`Sink`] takes their changes in order of time ([`vcd`] and [`fst`] are two,
//! [`background`] does what another does on a thread of its own), [`output`] decides where the bytes go and that no half
//! file takes the place of a whole one. [`read`] and [`diff`] go the other way, [`play`] hands on what is read. This room
//! knows scopes, names, widths and times; it knows nothing of circuits, nets or engines.

pub mod background;
pub mod batch;
pub mod behind;
pub mod diff;
mod fields;
mod file;
pub mod fst;
pub mod layout;
pub mod output;
pub mod play;
pub mod read;
pub mod recorder;
mod report;
#[cfg(test)]
mod samples;
pub mod save;
pub mod scopes;
mod section;
pub mod select;
pub mod text;
mod thread;
pub mod vcd;
mod walk;
pub mod window;

use std::io;

#[cfg(test)]
pub(crate) use discreta_core::Value;
pub(crate) use discreta_core::{Timescale, Unit, files, safe, value};

use crate::value::Word;
pub use batch::{Batch, Batches};
pub use file::{Kind, open};
pub use layout::{Layout, LayoutError, ScopeDecl, ScopeKind, VarDecl, VarKind};

/// What takes a waveform: [`begin`](Sink::begin) once, then times and the changes at each, then
/// [`finish`](Sink::finish) once.
///
/// The value that a variable has when its time is over is what counts: a sink writes no change that is undone within
/// one tick, none that changes nothing, and the changes of one tick in the order of the layout. So the bytes do not
/// depend on the order in which an engine reports them.
///
/// # Errors
/// Every method passes on what the destination says. One that names a file holds an
/// [`OutputError`](output::OutputError) inside.
pub trait Sink {
    /// Starts the waveform.
    ///
    /// # Errors
    /// Also [`InvalidInput`](io::ErrorKind::InvalidInput) with a [`LayoutError`] inside, before anything is written.
    fn begin(&mut self, layout: &Layout) -> io::Result<()>;

    /// The changes that follow happen at tick `now`, which is not before the last one. The values given at the first
    /// time are the initial ones; a variable without is x.
    ///
    /// # Errors
    /// [`InvalidInput`](io::ErrorKind::InvalidInput) if time goes back.
    fn time(&mut self, now: u64) -> io::Result<()>;

    /// Variable `var` (its index in [`Layout::vars`]) now has this value: as many words as its width needs, the least
    /// significant first. Changing an alias changes what it is an alias of.
    ///
    /// # Panics
    /// If there is no such variable, or no time yet.
    fn change(&mut self, var: usize, value: &[Word]);

    /// What takes changes by the batch, for a sink that can.
    fn batches(&mut self) -> Option<&mut dyn Batches> {
        None
    }

    /// Ends the waveform at tick `end`, and has the destination [complete](output::Destination::complete) it.
    ///
    /// # Errors
    /// [`InvalidInput`](io::ErrorKind::InvalidInput) if `end` is before the last time.
    fn finish(&mut self, end: u64) -> io::Result<()>;
}
