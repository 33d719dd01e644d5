//! The weakly connected components of an edge: parts of a circuit that at most read each other's state.
//!
//! Sound: two nodes are in one component if one uses the other, or if both read or write one memory.

use crate::compiled::ir::graph::{Id, Map, Op};
use crate::compiled::ir::places::Slot;
use crate::compiled::passes::edge::EdgeCode;

/// How many parts of one size are worth having apart.
const LIKE: usize = 4;

/// What is wanted of a part of an edge that has no node in common with the others.
#[derive(Default)]
pub(crate) struct Part {
    nodes: usize,
    /// What it stores, writes and bails out for, by their numbers in the edge.
    pub stores: Vec<usize>,
    pub puts: Vec<usize>,
    pub bail_outs: Vec<usize>,
}

/// The parts of an edge: the first is all that is not apart, then come those of at least some nodes of which there are
/// several of one size.
pub(crate) fn parts(edge: &EdgeCode, least: usize) -> Vec<Part> {
    let EdgeCode { graph, partition, .. } = edge;
    let mut of = Joined { next: graph.ids().collect() };
    // what reads and writes a memory belongs together
    let mut memories: Map<Slot, Id> = Map::default();
    let inner = |node: &Id| !graph.op(*node).is_leaf();
    for &node in &partition.nodes {
        graph.op(node).operands().filter(inner).for_each(|o| of.join(node, o));
        if let Op::Element { slot, .. } = graph.op(node) {
            of.join(node, *memories.entry(slot).or_insert(node));
        }
    }
    for put in &partition.puts {
        for node in put.nodes().into_iter().filter(inner) {
            of.join(node, *memories.entry(put.slot).or_insert(node));
        }
    }
    let mut all = vec![Part::default()];
    let mut numbers: Map<Id, usize> = Map::default();
    let mut part = |all: &mut Vec<Part>, node: Option<Id>| {
        let Some(node) = node else { return 0 };
        *numbers.entry(of.first(node)).or_insert_with(|| {
            all.push(Part::default());
            all.len() - 1
        })
    };
    for (i, store) in partition.stores.iter().enumerate() {
        let at = part(&mut all, Some(store.node).filter(inner));
        all[at].stores.push(i);
    }
    for (i, put) in partition.puts.iter().enumerate() {
        let at = part(&mut all, put.nodes().into_iter().find(inner).or(memories.get(&put.slot).copied()));
        all[at].puts.push(i);
    }
    for (i, &bail_out) in partition.bail_outs.iter().enumerate() {
        let at = part(&mut all, Some(bail_out).filter(inner));
        all[at].bail_outs.push(i);
    }
    for &node in &partition.nodes {
        let at = part(&mut all, Some(node));
        all[at].nodes += 1;
    }
    let size = |part: &Part| (part.nodes, part.stores.len(), part.puts.len(), part.bail_outs.len());
    let mut alike: Map<_, usize> = Map::default();
    all[1..].iter().for_each(|part| *alike.entry(size(part)).or_default() += 1);
    let apart = |part: &Part| part.nodes >= least && alike[&size(part)] >= LIKE;
    let (apart, rest): (Vec<Part>, Vec<Part>) = all.split_off(1).into_iter().partition(apart);
    let first = &mut all[0];
    for part in rest {
        first.stores.extend(part.stores);
        first.puts.extend(part.puts);
        first.bail_outs.extend(part.bail_outs);
    }
    [&mut first.stores, &mut first.puts, &mut first.bail_outs].into_iter().for_each(|list| list.sort_unstable());
    all.extend(apart);
    all
}

/// Sets of nodes.
struct Joined {
    next: Vec<Id>,
}

impl Joined {
    /// The first of the nodes that one is joined with.
    fn first(&mut self, mut node: Id) -> Id {
        while self.next[node.index()] != node {
            self.next[node.index()] = self.next[self.next[node.index()].index()];
            node = self.next[node.index()];
        }
        node
    }

    fn join(&mut self, a: Id, b: Id) {
        let (a, b) = (self.first(a), self.first(b));
        self.next[a.max(b).index()] = a.min(b);
    }
}
