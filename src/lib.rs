#![doc = "placeholder"]
pub mod cell;
pub mod netlist;
pub mod value;
pub use value::{Logic, Value};
