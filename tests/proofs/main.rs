//! That the circuits of the sources are their algorithms, on every clock; and mutants, which show that this can fail.

#[path = "../support/mod.rs"]
mod support;

mod circle_interpolator;
mod curve_interpolator;
mod dda_facts;
mod dda_interpolator;
mod dda_modules;
mod fast_interpolator;
mod feed;
mod feed_pace;
mod gate_modules;
mod line_interpolator;
mod mutants;
mod quadrant;
mod three_axis;
