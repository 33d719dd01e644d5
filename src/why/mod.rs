//! From a value back to what made it: the cell that drives a net, what that cell read, and which of that mattered; tick by
//! tick back to a register that nothing ever set, a net that nothing drives, an input, or a division by zero.
//!
//! [`History`] keeps what a run's nets were, [`explain`] takes one step back, [`chain`] follows them, [`differ`] looks for the
//! first net that is not as another waveform has it. What a cell does is asked of the cell itself, with one bit of what it
//! reads changed at a time. This room knows no files and no command line.

mod chain;
mod differ;
mod explain;
mod history;
mod memory;

pub use chain::{End, Link, chain};
pub use differ::{Culprit, Seen, differ};
pub use explain::{Cause, Control, Read, Step, explain};
pub use history::{History, cone};
