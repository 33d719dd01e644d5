//! The circuit file: its types with places, expressions, signals, limits, and its JSON Schema.
//!
//! [`read_file`] takes a file into [`Sources`](crate::diag::Sources), [`CircuitFile::parse`] makes it a
//! [`CircuitFile`]. Whether names in it mean anything is for elaboration to say. This room does not know engines.

mod arguments;
mod elaborate;
pub mod expr;
mod expr_parser;
pub mod file;
#[cfg(test)]
mod file_tests;
mod library;
pub mod limits;
mod load;
pub mod reference;
mod report;
pub mod schema;
mod scope;
pub mod source;
pub mod value_names;

pub use expr::{Expr, Names};
pub use expr_parser::is_name;
pub use file::{
    Block, Cell, CircuitFile, Direction, Module, Name, Net, Parameter, ParameterText, ParameterValue, Port, Repeat,
};
pub use limits::Limits;
pub use load::{Circuit, FileHandle, LoadError, Loader, load, load_with};
pub use reference::{Constant, Signal};
pub use source::read_file;
pub(crate) use source::{normal, size};
