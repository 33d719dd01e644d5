//! Verilog-2005 out: one module for each module of the circuit, and a test bench.
//!
//! The text is for people and for tools: what is an operator in Verilog is written as one, names stay, modules stay
//! modules. Elements that no operator has are modules of their own (`support.v`), added where they are used.

mod bench;
mod cells;
mod design;
mod names;
mod storage;
mod text;

pub use bench::{Bench, Refused};
pub use design::design;
