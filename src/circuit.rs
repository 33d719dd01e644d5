//! Circuit files: the way from a path to a netlist.
//!
//! What an author writes is in [`syntax`](crate::syntax), what becomes of it in [`elaborate`](crate::elaborate); here is
//! what most programs need of both.

pub use crate::elaborate::{
    BUILT_IN, Circuit, FileHandle, LoadError, Loader, Synthesis, built_in, load, load_sources, load_text, load_with,
    read_file,
};
pub use crate::syntax::{
    Block, Cell, CircuitFile, Constant, Direction, Expr, Limits, Module, Name, Names, Net, Parameter, ParameterText,
    ParameterValue, Port, Repeat, Signal, Words, is_name, limits, schema,
};
