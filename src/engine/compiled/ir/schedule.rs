//! Nodes divided into partitions, each computed as one, in the order in which they run.

use super::graph::{Id, Map};
use super::places::{PlaneWord, Slot};
use super::stores::{Put, Store};

/// Something wanted in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub node: Id,
    pub plane: PlaneWord,
    /// The bit that a change sets, for a net that is observed.
    pub observed: Option<u32>,
    /// Whether it is the unknown plane of state that this variant takes to be known.
    pub guard: bool,
    /// Whether later partitions may take it from there.
    pub shared: bool,
    /// The loop that it is of: nothing that comes after it is in its partition.
    pub group: Option<u32>,
    /// Whether its partition is to run again while it is not 0.
    pub again: bool,
    /// Whether it is state, which edges change too: then it is to become this again, even where the node, as folded, does
    /// not read the state.
    pub state: bool,
}

/// Nodes that are computed together, in order, and what they store.
#[derive(Default, Debug)]
pub(crate) struct Partition {
    pub nodes: Vec<Id>,
    pub stores: Vec<Store>,
    /// The loop that is stepped in it.
    pub group: Option<u32>,
    /// Nodes that are 0 where it may be run.
    pub bail_outs: Vec<Id>,
    /// What it writes into memories, in order.
    pub puts: Vec<Put>,
}

/// Partitions in order, each after those that it reads.
#[derive(Default, Debug)]
pub(crate) struct Schedule {
    pub partitions: Vec<Partition>,
    /// How many of the partitions are needed for a circuit to be settled; the others only before an edge.
    pub settling: usize,
    /// Where nodes lie that one partition computes and another uses.
    pub place: Map<Id, PlaneWord>,
    /// The partitions that read each slot of state.
    pub readers: Map<Slot, Vec<u32>>,
    /// Roots that are constant.
    pub constants: Vec<(Root, u64)>,
}
