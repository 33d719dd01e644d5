//! Passes over the graph, one a file. They know no netlist but for its state layout, and no machine code.

pub(crate) mod components;
pub(crate) mod cycle;
pub(crate) mod edge;
pub(crate) mod merge;
pub(crate) mod outline;
pub(crate) mod partition;
pub(crate) mod word_recovery;
