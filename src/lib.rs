#![doc = "placeholder"]
pub mod cell;
pub mod circuit;
pub mod diag;
pub mod engine;
pub mod interpolate;
pub mod json;
pub mod netlist;
pub mod scenario;
mod simulator;
pub mod value;
pub use simulator::{Input, Probe, Simulator, SimulatorError};
pub use value::{Logic, Value};
pub mod cli;
pub mod wave;
