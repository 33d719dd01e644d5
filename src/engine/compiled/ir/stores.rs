//! What is written to memory: values of nodes into plane words, and into elements of what memories hold.

use super::graph::Id;
use super::places::{PlaneWord, Slot};

/// What a partition stores.
#[derive(Clone, Debug)]
pub(crate) struct Store {
    pub node: Id,
    pub plane: PlaneWord,
    pub observed: Option<u32>,
    pub guard: bool,
    /// Whether a change has to be found out.
    pub compared: bool,
    /// Partitions that a change wakes.
    pub wakes: Vec<u32>,
    /// Wakes its partition again while it is not 0.
    pub again: bool,
}

impl Store {
    /// One of which nobody is told anything.
    pub fn plain(node: Id, plane: PlaneWord) -> Store {
        let (observed, wakes) = (None, Vec::new());
        Store { node, plane, observed, guard: false, compared: false, wakes, again: false }
    }
}

/// What one port writes into one element; only the bits of `mask` count.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Put {
    /// Where the contents begin.
    pub slot: Slot,
    pub size: u8,
    /// Below the number of elements, whatever is written.
    pub index: Id,
    pub mask: Id,
    pub v: Id,
    pub u: Id,
}

impl Put {
    /// What it takes.
    pub fn nodes(&self) -> [Id; 4] {
        [self.index, self.mask, self.v, self.u]
    }
}
