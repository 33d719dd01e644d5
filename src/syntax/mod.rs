//! What an author writes: circuit files and scenarios as types with places, expressions, signals, times, limits, and the
//! JSON Schema of it all.
//!
//! [`CircuitFile::parse`] and [`ScenarioFile::parse`] read a text. Whether the names in it mean anything is for
//! `elaborate` and `scenario` to say; this room knows neither netlists nor engines.

pub mod check;
pub mod circuit;
#[cfg(test)]
mod circuit_tests;
pub mod expr;
mod expr_parser;
pub mod limits;
pub mod reference;
pub mod scenario;
pub mod schema;
pub mod stimulus;
pub mod time;
pub mod value_names;

pub use check::{Check, CheckRule, Level, NetEdge};
pub use circuit::{
    Block, Cell, CircuitFile, Direction, Module, Name, Net, Parameter, ParameterText, ParameterValue, Port, Repeat,
    Words,
};
pub use expr::{Expr, Names};
pub use expr_parser::is_name;
pub use limits::Limits;
pub use reference::{Constant, Signal};
pub use scenario::{Clock, Edge, EdgeOf, Expect, Limit, ScenarioFile, Simulation, Stimulus, Until, ValueText};
pub use stimulus::{Loose, Stimuli, WaveStimulus};
pub use time::{Percent, TimeText};
