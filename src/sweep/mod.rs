//! Sweeps: one scenario run once for every combination of values of some inputs.
//!
//! [`plan`] says which combinations there are, in which order, and which of them a shard or a sample takes; [`run`] runs
//! them on the batch engine, on all cores, and hands the rows on in order; [`against`] compares every lane with an
//! interpolation algorithm; [`table`] puts rows into CSV and JSON, [`part`] the parts of a sweep together. This room knows
//! scenarios, engines and algorithms; files are the caller's.

pub mod against;
mod ahead;
mod judge;
mod lanes;
mod model;
pub mod part;
pub mod plan;
pub mod run;
pub mod table;
mod time;
mod worker;

pub use against::{Against, AgainstError};
pub use plan::{Over, Plan, PlanError, Shard};
pub use run::{Ended, Row, Sweep, SweepError};
pub use table::{Form, Table};
