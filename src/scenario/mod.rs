//! Scenarios: what happens to a circuit: clocks, stimulus, when to stop, what to record, what must hold.
//!
//! [`Simulation`] is what an author writes, [`Scenario`] the same with its names resolved, [`run`](run()) runs it on any engine
//! into any waveform. This room does not know how an engine works inside.

mod check;
mod glob;
mod record;
pub mod replay;
mod resolve;
mod run;

pub use crate::syntax::{
    Check, CheckRule, Clock, Edge, EdgeOf, Expect, Level, Limit, Loose, NetEdge, Percent, ScenarioFile, Simulation,
    Stimuli, Stimulus, TimeText, Until, ValueText, WaveStimulus,
};
pub use check::{CheckReport, Fault, MAX_KEPT, Side, Timing, TimingCheck, Violation};
pub(crate) use glob::{glob_path, glob_set};
pub(crate) use record::{Recording, layout};
pub use replay::Replay;
pub use resolve::{DEFAULT_CYCLES, DrivenClock, Event, Expectation, Rule, Scenario};
pub use run::{AssertionFailure, Control, Failure, Found, Observer, Outcome, RunError, Stop, run, run_with};

pub(crate) use run::value;
