//! That all engines give the same values, whatever the circuit, the order of its cells and the form of the code.

#[path = "../support/mod.rs"]
mod support;

mod batch;
mod compiled;
mod force;
mod lingering;
mod mutation;
mod narrowed;
mod order;
mod packed;
mod sweep;
mod traced;
