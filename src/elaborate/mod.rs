//! From what an author wrote to a netlist: files and imports, parameters and repetition, modules laid flat.
//!
//! A netlist of Yosys goes the same way from here on ([`import`](crate::import)). This room does not know what runs the
//! netlist, nor with what stimulus.

mod arguments;
mod builtin;
mod contents;
mod flatten;
mod library;
mod load;
mod report;
mod scope;
mod source;
mod synthesis;

use crate::syntax::{
    Block, Cell, CircuitFile, Direction, Expr, Limits, Module, Name, Names, Net, ParameterText, ParameterValue, Repeat,
    Signal, value_names,
};

pub(crate) use builtin::import as built_in_import;
pub use builtin::{PREFIX as BUILT_IN, circuits as built_in};
pub use load::{Circuit, FileHandle, LoadError, Loader, load, load_sources, load_text, load_with};
pub use source::read_file;
pub(crate) use source::{normal, not_a_circuit, size};
pub use synthesis::{Language, PROGRAMS, Synthesis};
