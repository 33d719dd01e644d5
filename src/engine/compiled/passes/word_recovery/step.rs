//! What is packed: state that becomes something else, and the words in which its bits are to lie.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::stores::Put;

/// A word of memory that has single bits of state in its lanes while packed code runs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Place {
    pub word: PlaneWord,
    pub lanes: Vec<(u8, PlaneWord)>,
}

/// State that becomes something else, all at once, as long as some nodes are 0.
#[derive(Debug)]
pub(crate) struct Step {
    pub graph: Graph,
    pub stores: Vec<(PlaneWord, Id)>,
    /// What is written into memories.
    pub puts: Vec<Put>,
    pub bail_outs: Vec<Id>,
}

impl Step {
    /// The nodes that count, in order.
    pub(crate) fn needed(&self) -> Vec<Id> {
        self.graph.needed(self.roots())
    }

    /// The nodes that are stored, written or looked at.
    fn roots(&self) -> impl Iterator<Item = Id> {
        let puts = self.puts.iter().flat_map(Put::nodes);
        self.stores.iter().map(|s| s.1).chain(self.bail_outs.iter().copied()).chain(puts)
    }

    /// How often each node is used by what counts.
    pub(crate) fn uses(&self) -> Vec<u32> {
        let mut uses = vec![0; self.graph.len()];
        self.roots().for_each(|n| uses[n.index()] += 1);
        for node in self.needed() {
            self.graph.op(node).operands().for_each(|o| uses[o.index()] += 1);
        }
        uses
    }

    /// The node of each state that is read.
    pub(crate) fn loads(&self) -> Map<PlaneWord, Id> {
        let load = |n| if let Op::Load(plane) = self.graph.op(n) { Some((plane, n)) } else { None };
        self.graph.ids().filter_map(load).collect()
    }

    /// Words for the single bits of groups that become something.
    pub(crate) fn places(&self, groups: &[Vec<(u8, PlaneWord)>], fresh: &mut dyn FnMut() -> PlaneWord) -> Vec<Place> {
        let loads = self.loads();
        let becomes: Map<PlaneWord, Id> = self.stores.iter().copied().collect();
        let single = |h: &PlaneWord| loads.get(h).is_none_or(|&n| self.graph.possible_bits(n) == 1);
        let mut places: Vec<Place> = Vec::new();
        let mut taken: Map<PlaneWord, ()> = Map::default();
        for group in groups {
            let lanes: Vec<(u8, PlaneWord)> = group.iter().copied().filter(|l| becomes.contains_key(&l.1)).collect();
            if lanes.len() < 2 || lanes.iter().any(|(_, h)| !single(h) || taken.contains_key(h)) {
                continue;
            }
            lanes.iter().for_each(|l| _ = taken.insert(l.1, ()));
            places.push(Place { word: fresh(), lanes });
        }
        places
    }

    /// About how much work it is.
    pub(crate) fn cost(&self) -> usize {
        self.needed().len() + 2 * self.stores.len()
    }
}
