//! What `$print`, `$check`, `$assert`, `$assume` and `$cover` do in a run.

/// A cell that says something while a circuit runs.
#[derive(Clone, Debug)]
pub struct Check {}
