//! *discreta* simulates digital circuits clock by clock: gates, flip-flops, registers and adders, four-valued, wired in a
//! circuit file or in Rust.
//!
//! Load a circuit, look its nets up once, poke, step and peek:
//!
//! ```
//! use discreta::{Simulator, circuit};
//!
//! let line = circuit::load_with("circuits/evaluation/line.json", &[("W", 4)])?;
//! let mut sim = Simulator::new(&line.netlist);
//! let [start, dt] = ["start", "dt"].map(|name| sim.input(name).unwrap());
//! for (name, value) in [("dt", 0), ("start", 1), ("dx", 5), ("dy", 3), ("xh", 0), ("yh", 0)] {
//!     sim.set(sim.input(name)?, value);
//! }
//! sim.settle()?;
//! sim.set(start, 0);
//! for level in [1, 0] {
//!     sim.set(dt, level); // one clock: an x step, counted at its trailing edge
//!     sim.settle()?;
//! }
//! assert_eq!(sim.number(&sim.probe("xt")?), Some(1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Or build a netlist with [`netlist::Builder`], run a [`scenario`] into a [`wave`], drive an [`engine`] yourself.
//! `docs/architecture.md` tells which room is for what, `docs/meaning.md` what a circuit means.

pub mod cell;
pub mod circuit;
pub mod cli;
pub mod compare;
pub mod diag;
pub mod draw;
pub mod engine;
pub mod exchange;
mod guard;
pub mod interpolate;
pub mod json;
pub mod netlist;
pub mod plot;
mod random;
pub mod scenario;
mod simulator;
mod svg;
pub mod sweep;
mod timescale;
pub mod value;
pub mod view;
pub mod wave;

pub use simulator::{Input, Probe, Simulator, SimulatorError};
pub use timescale::{Timescale, Unit};
pub use value::{Logic, Value};
