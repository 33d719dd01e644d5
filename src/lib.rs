#![doc = "placeholder"]
pub mod interpolate;
pub mod value;
pub use value::{Logic, Value};
