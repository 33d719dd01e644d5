#![doc = "placeholder"]
pub mod circuit;
pub mod diag;
pub mod json;
pub mod scenario;
pub mod value;
pub use value::{Logic, Value};
