//! The compiled engine: the same values as the event engine, by machine code made for the circuit.
//!
//! The way of a circuit: `lower` makes a `graph` of operations on machine words of it, two planes for each four-valued
//! word; `plan` cuts that into chunks; `codegen` makes a function of each, which `machine` calls. A `form` is the result
//! for what is taken to be known: where state and inputs hold no x or z, their unknown planes are 0, and the graph folds
//! to two-valued logic by itself. What that can make unknown nevertheless (a division by zero, a select out of range) is
//! still computed exactly; only where it reaches state is the form left, before anything is computed from it.
//! `wiring` knows clocks and controls, `peek` evaluates what nobody keeps.
//!
//! A wave here: chunks of which an input has changed run in order; storage cells whose clock made its edge take what was
//! computed for them; and again until no clock makes an edge.

mod codegen;
mod error;
mod ir;
mod lower;
mod passes;
mod runtime;

pub use error::CompileError;
pub use runtime::{CompiledEngine, EngineReport};
