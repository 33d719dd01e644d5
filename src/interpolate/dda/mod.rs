//! Interpolation by differential increments (document A): the carries of accumulators are the steps.
