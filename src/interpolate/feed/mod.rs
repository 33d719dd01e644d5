//! From steps to movement in time: document B, «Блок за задаване на скоростта».
//!
//! [`Speed`] computes the period of the feed clock Δt from the commanded speed, [`Generator`] makes its pulses, longer
//! ones after steps of several axes, [`Stores`] is the synchroniser's memory of steps, and [`Margins`] says for which
//! delays and periods the whole system neither loses nor gains a step. What the circuits of `circuits/feed` do is
//! compared with what is computed here.

mod generator;
mod margins;
mod pace;
mod speed;
mod stores;

pub use generator::{Generator, PeriodError, factor};
pub use margins::{Margins, UnsafeMargin};
pub use pace::pace;
pub use speed::{Speed, SpeedError};
pub use stores::{Feed, Stores};
