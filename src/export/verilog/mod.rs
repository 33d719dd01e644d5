//! Verilog-2005 out: one module for each module of the circuit, and a test bench.
//!
//! The text is for people and for tools: what is an operator in Verilog is written as one, names stay, modules stay
//! modules. Elements that no operator has are modules of their own (`support.v`), added where they are used.

mod bench;
mod body;
mod cells;
mod design;
mod feedback;
mod memory;
mod names;
mod start;
mod storage;
mod text;
mod writer;

use std::fmt;

pub use bench::Bench;
pub use design::Design;

/// What Verilog, or this way of writing it, cannot say.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Refused(String);

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}
