//! Circuits for other tools: Verilog with a test bench, Yosys' JSON, graphs.
//!
//! This room reads netlists and scenarios; it knows nothing of engines.

pub mod dot;
pub mod verilog;
pub mod yosys;
