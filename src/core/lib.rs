//! The heart that everything of discreta stands on: four-valued values, what cells compute, and netlists.
//!
//! This crate is an inner part: use the crate `discreta`, which shows what of it may be relied on. It knows no files, no
//! engines and no waveforms.

pub mod cell;
pub mod digest;
pub mod files;
pub mod guard;
pub mod netlist;
pub mod random;
pub mod safe;
mod timescale;
pub mod value;

pub use timescale::{Timescale, Unit};
pub use value::{Logic, Value};
