//! The compiled engine: the same values as the event engine, by machine code made for the circuit.
//!
//! The folders are the stages, in order, and each knows only those before it:
//!
//! | `ir` | operations on machine words, hash-consed and simplified; what is stored of them; what follows from a condition |
//! | `lower` | the netlist as such a graph, two nodes for each four-valued word; where its state lies in memory |
//! | `passes` | partitions; one clock edge as straight code; a whole cycle; outlined and merged functions; word recovery |
//! | `codegen` | machine code, through Cranelift, and the one place that calls it |
//! | `runtime` | the engine: variants, settling, clocks, what is traced |
//!
//! A *variant* is the circuit compiled under an assumption about which words of state hold no x or z: none, all, or all but
//! a list. Where that is assumed, unknown planes are the constant 0, and the graph folds to two-valued logic by itself. What
//! can become unknown all the same (a division by zero, a select out of range) is computed exactly; when that reaches state
//! a *guard* fails, and another variant goes on before anything reads it.
//!
//! In an evaluation phase, partitions of which an input has changed run in order; storage cells whose clock made its edge take
//! what was computed for them; and so on, one delta cycle after another, until no clock makes an edge.

mod codegen;
mod error;
mod ir;
mod lower;
mod passes;
mod runtime;

pub use error::CompileError;
pub use runtime::{CompiledEngine, EngineReport};
