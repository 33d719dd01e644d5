//! Interpolation by differential increments (document A): the carries of accumulators are the steps.

pub mod line_3d;
