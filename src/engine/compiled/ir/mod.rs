//! The intermediate representation: a graph of operations on machine words, what is stored of it, and what is known about
//! it. It knows no netlist and no machine code.

pub(crate) mod facts;
pub(crate) mod graph;
#[cfg(test)]
pub(crate) mod interpreter;
pub(crate) mod places;
pub(crate) mod record;
pub(crate) mod schedule;
pub(crate) mod simplify;
pub(crate) mod stores;
#[cfg(test)]
mod tests;
