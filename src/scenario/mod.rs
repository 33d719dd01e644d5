//! Scenarios: what happens to a circuit: clocks, stimulus, when to stop, what to record, what must hold.
//!
//! [`mod@file`] is what an author writes, [`Scenario`] the same with its names resolved, [`run`](run()) runs it on any engine
//! into any waveform. This room does not know how an engine works inside.

mod check;
pub mod file;
mod glob;
mod record;
pub mod replay;
mod resolve;
mod run;
pub mod stimulus;
pub mod time;

pub use check::{Check, CheckReport, CheckRule, Fault, Level, MAX_KEPT, NetEdge, Side, Timing, TimingCheck, Violation};
pub use file::{Clock, Edge, EdgeOf, Expect, Limit, ScenarioFile, Simulation, Stimulus, Until, ValueText};
pub(crate) use glob::glob_set;
pub(crate) use record::layout;
pub use replay::Replay;
pub use resolve::{DEFAULT_CYCLES, DrivenClock, Event, Expectation, Rule, Scenario};
pub use run::{Control, Failure, Found, Outcome, RunError, Stop, run, run_with};
pub use stimulus::{Loose, Stimuli, WaveStimulus};
pub use time::{Percent, TimeText};

pub(crate) use run::value;
