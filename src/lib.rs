#![doc = "placeholder"]
pub mod cell;
pub mod engine;
pub mod netlist;
pub mod value;
pub use value::{Logic, Value};
