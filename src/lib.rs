#![doc = "placeholder"]
pub mod cell;
pub mod value;
pub use value::{Logic, Value};
