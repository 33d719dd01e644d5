//! The circuit file: its types with places, expressions, signals, limits, and its JSON Schema.
//!
//! [`read_file`] takes a file into [`Sources`](crate::diag::Sources), [`CircuitFile::parse`] makes it a
//! [`CircuitFile`]. Whether names in it mean anything is for elaboration to say. This room does not know engines.

pub mod expr;
mod expr_parser;
pub mod file;
#[cfg(test)]
mod file_tests;
pub mod limits;
pub mod reference;
pub mod schema;
pub mod source;

pub use expr::{Expr, Names};
pub use expr_parser::is_name;
pub use file::{
    Block, Cell, CircuitFile, Direction, Module, Name, Net, Parameter, ParameterText, ParameterValue, Port, Repeat,
};
pub use limits::Limits;
pub use reference::{Constant, Signal};
pub use source::read_file;
