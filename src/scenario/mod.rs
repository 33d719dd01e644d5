//! Scenarios: what happens to a circuit. Here so far: the file as it is written, times and values.

pub mod file;
pub mod time;

pub use file::{Clock, Edge, EdgeOf, Expect, Limit, ScenarioFile, Simulation, Stimulus, Until, ValueText};
pub use time::{Percent, TimeText, Timescale, Unit};
