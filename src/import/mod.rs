//! Other tools' formats in: netlists of Yosys, memory contents in hexadecimal.
//!
//! This room makes netlists and says what is wrong with what it reads; it knows nothing of engines and scenarios.

pub mod readmem;
pub mod yosys;
