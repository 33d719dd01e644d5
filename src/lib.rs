#![doc = "placeholder"]
pub mod value;
pub use value::{Logic, Value};
