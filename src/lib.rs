//! *discreta* simulates digital circuits clock by clock: gates, flip-flops, registers and adders, four-valued, wired in a
//! circuit file or in Rust.
//!
//! Load a circuit, poke, tick and peek:
//!
//! ```
//! use discreta::{Simulator, circuit};
//!
//! let line = circuit::load_with("circuits/evaluation/line.json", &[("W", 4)])?;
//! let mut sim = Simulator::new(&line);
//! for (name, value) in [("dt", 0), ("start", 1), ("dx", 5), ("dy", 3), ("xh", 0), ("yh", 0)] {
//!     sim.poke(name, value)?;
//! }
//! sim.settle()?;
//! sim.poke("start", 0)?;
//! sim.ticks("dt", 8)?; // a step each
//! assert_eq!(sim.peek("xt")?.to_u64(), Some(5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | for | look at |
//! |---|---|
//! | a circuit from a file, a text, Verilog; its faults | [`circuit`], [`Circuit`](circuit::Circuit), [`LoadError`](circuit::LoadError) |
//! | a circuit from code | [`netlist::Builder`], [`cell::CellKind`] |
//! | driving it, waveforms, forces, memories, saved states | [`Simulator`], [`Trace`], [`State`], [`SimulatorError`] |
//! | two side by side | [`Lockstep`] |
//! | values of four states | [`Value`], [`Logic`] |
//! | a scenario with stimulus, expectations and checks | [`scenario`] |
//! | thousands of runs at once | [`sweep`], [`engine::batch`] |
//! | waveforms: writing, reading, comparing | [`wave`] |
//! | an engine of one's own hand | [`engine::Engine`], [`EngineKind`] |
//! | other tools, pictures, algorithms | [`export`], [`import`], [`draw`], [`plot`], [`interpolate`], [`machine`] |
//!
//! `docs/embedding.md` says more, `docs/meaning.md` what a circuit means, `docs/architecture.md` which room is for what. What is not
//! in this table serves the command and may change with it.

#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))] // some of what rooms offer only the command uses

pub mod circuit;
// what is hidden serves the command and its tests, and nobody else is to rely on it
#[cfg(feature = "cli")]
#[doc(hidden)]
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
#[doc(hidden)]
pub mod view;
pub mod why;

pub(crate) use discreta_core::digest;
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
