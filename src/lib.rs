#![doc = "placeholder"]
pub mod value;
pub use value::{Logic, Value};
pub mod cli;
pub mod wave;
