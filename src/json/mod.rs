//! Strict JSON with places: text to serde types, every fault told at once.
//!
//! [`parse`] reads a text held by [`Sources`](crate::diag::Sources). Types say what they need by [`Spanned`] (keeps the place) and
//! [`Recover`] (a fault inside does not end the reading), by [`every`] and [`or_default`] on fields, by [`fault`]
//! when their own reading of a text fails, and by an enum whose serde name starts with [`KIND`] when they may be
//! written in several ways. This room knows JSON and diagnostics, nothing of circuits.

mod access;
mod de;
mod fault;
mod spanned;
mod syntax;
#[cfg(test)]
mod tests;

pub use de::{KIND, every, or_default, parse};
pub use fault::fault;
pub use spanned::{Recover, Spanned};
pub use syntax::MAX_NESTING;
