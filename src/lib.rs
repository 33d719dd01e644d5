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

#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))] // some of what rooms offer only the command uses

pub mod circuit;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compare;
pub mod diag;
pub mod draw;
pub mod elaborate;
pub mod export;
pub mod import;
pub mod json;
pub mod machine;
pub mod plot;
pub mod scenario;
pub mod simulator;
mod svg;
pub mod sweep;
pub mod syntax;
pub mod view;
pub mod why;

#[cfg(feature = "draw")]
pub(crate) use discreta_core::guard;
#[doc(hidden)] // for the tests, which draw by the same numbers
pub use discreta_core::random;
pub use discreta_core::{Logic, Timescale, Unit, Value, cell, netlist, value};
pub(crate) use discreta_core::{files, safe};
pub use discreta_engine as engine;
pub use discreta_interpolate as interpolate;
pub use discreta_wave as wave;
pub use engine::EngineKind;
pub use simulator::{Input, Lockstep, MemoryHandle, Probe, Simulator, SimulatorError, State, Trace};
