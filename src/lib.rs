#![doc = "placeholder"]
pub mod diag;
pub mod value;
pub use value::{Logic, Value};
