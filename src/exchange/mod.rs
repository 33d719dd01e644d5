//! Other tools' formats. This room knows netlists and diagnostics, nothing of engines.

pub mod dot;
pub mod readmem;
pub mod verilog;
pub mod yosys;
