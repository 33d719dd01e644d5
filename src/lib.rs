#![doc = "placeholder"]
pub mod cell;
pub mod circuit;
pub mod cli;
pub mod diag;
pub mod engine;
pub mod interpolate;
pub mod json;
pub mod netlist;
pub mod scenario;
mod simulator;
pub mod value;
pub mod wave;
pub use simulator::{Input, Probe, Simulator, SimulatorError};
pub use value::{Logic, Value};
