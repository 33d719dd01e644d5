//! A long edge in several outlined functions, since the time that the code generator takes grows faster than a function does.
//!
//! What one leaves for a later one lies in memory. Parts of a circuit that have no logic in common (`components`) get functions of
//! their own where there are several of a kind, so that these come out alike and are merged (`merge`).
//!
//! Sound: all functions together see the state as it was before the edge. A store waits for the last function that loads what it
//! overwrites, writes to one memory keep their order, and nothing is stored to state before the last function that may bail out.

use crate::compiled::ir::graph::{Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::schedule::{Partition, Schedule};
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;
use crate::compiled::passes::components::parts;
use crate::compiled::passes::edge::EdgeCode;

const NONE: u32 = u32::MAX;
/// What may be a piece of its own has at least this part of the nodes of a whole one: a call costs something.
const APART: usize = 16;

struct Split<'t> {
    edge: &'t EdgeCode,
    limit: usize,
    /// The piece of each node.
    piece: Vec<u32>,
    pieces: Vec<Partition>,
}

/// Pieces of an edge, of about `limit` nodes each, and where what they leave each other lies. `fresh` gives places.
pub(crate) fn outline(edge: &EdgeCode, limit: usize, mut fresh: impl FnMut() -> PlaneWord) -> Schedule {
    let mut s = Split { edge, limit, piece: vec![NONE; edge.graph.len()], pieces: vec![Partition::default()] };
    let (stores, puts, bail_outs) = (&edge.partition.stores, &edge.partition.puts, &edge.partition.bail_outs);
    let parts = parts(edge, limit / APART);
    for part in parts.iter().filter(|part| !part.bail_outs.is_empty()) {
        part.bail_outs.iter().for_each(|&i| _ = s.assign(&[bail_outs[i]], true));
        s.close();
    }
    // what comes before this is left where the edge bails out
    let first = if bail_outs.is_empty() { 0 } else { s.open() };
    let (mut store_at, mut put_at) = (vec![0; stores.len()], vec![0; puts.len()]);
    for part in &parts {
        part.stores.iter().for_each(|&i| store_at[i] = s.assign(&[stores[i].node], true).max(first));
        part.puts.iter().for_each(|&i| put_at[i] = s.assign(&puts[i].nodes(), false).max(first));
        s.close();
    }
    s.wait(&mut store_at, &mut put_at);
    let Split { piece, mut pieces, .. } = s;
    // what is used in a later piece than its own
    let mut place: Map<Id, PlaneWord> = Map::default();
    let mut lay = |node: Id, by: u32, pieces: &mut Vec<Partition>| {
        if edge.graph.op(node).is_leaf() || piece[node.index()] == by || place.contains_key(&node) {
            return;
        }
        let plane = fresh();
        place.insert(node, plane);
        pieces[piece[node.index()] as usize].stores.push(Store::plain(node, plane));
    };
    for by in 0..pieces.len() as u32 {
        let nodes = std::mem::take(&mut pieces[by as usize].nodes);
        for &node in &nodes {
            edge.graph.op(node).operands().for_each(|o| lay(o, by, &mut pieces));
        }
        pieces[by as usize].nodes = nodes;
        pieces[by as usize].nodes.sort_unstable();
    }
    for &bail_out in bail_outs {
        // what is a leaf has no piece
        let at = if piece[bail_out.index()] == NONE { 0 } else { piece[bail_out.index()] };
        pieces[at as usize].bail_outs.push(bail_out);
    }
    for (store, &at) in stores.iter().zip(&store_at) {
        lay(store.node, at, &mut pieces);
        pieces[at as usize].stores.push(store.clone());
    }
    for (put, &at) in puts.iter().zip(&put_at) {
        put.nodes().into_iter().for_each(|node| lay(node, at, &mut pieces));
        pieces[at as usize].puts.push(*put);
    }
    Schedule { partitions: pieces, place, ..Schedule::default() }
}

impl Split<'_> {
    /// Begins a piece; its number, which is not 0.
    fn open(&mut self) -> u32 {
        self.close();
        if self.pieces.len() == 1 {
            self.pieces.push(Partition::default());
        }
        self.pieces.len() as u32 - 1
    }

    /// Ends the present piece, if there is anything in it.
    fn close(&mut self) {
        if self.pieces.last().is_none_or(|last| !last.nodes.is_empty()) {
            self.pieces.push(Partition::default());
        }
    }

    /// Gives all that some nodes need a piece: the present one, or the first that comes after all that is there already.
    /// The piece after which they are there.
    fn assign(&mut self, roots: &[Id], present: bool) -> u32 {
        let last = self.pieces.len() as u32 - 1;
        let (mut stack, mut new, mut seen) = (roots.to_vec(), Vec::new(), Map::default());
        let mut at = if present { last } else { 0 };
        let mut there = 0;
        while let Some(node) = stack.pop() {
            if self.edge.graph.op(node).is_leaf() || seen.insert(node, ()).is_some() {
                continue;
            }
            match self.piece[node.index()] {
                NONE => {
                    new.push(node);
                    stack.extend(self.edge.graph.op(node).operands());
                }
                piece => there = there.max(piece),
            }
        }
        at = at.max(there);
        if new.is_empty() {
            return there;
        }
        let nodes = &mut self.pieces[at as usize].nodes;
        new.iter().for_each(|&node| self.piece[node.index()] = at);
        nodes.extend(new);
        if at == last && nodes.len() >= self.limit {
            self.pieces.push(Partition::default());
        }
        at
    }

    /// Puts off what is written until all that reads it has run.
    fn wait(&self, store_at: &mut [u32], put_at: &mut [u32]) {
        let mut loads: Map<PlaneWord, u32> = Map::default();
        let mut elements: Map<Slot, u32> = Map::default();
        let graph = &self.edge.graph;
        let note = |loads: &mut Map<PlaneWord, u32>, node: Id, at: u32| match graph.op(node) {
            Op::Load(plane) => {
                let last = loads.entry(plane).or_default();
                let later = at > *last;
                *last = at.max(*last);
                later
            }
            _ => false,
        };
        for (at, piece) in (0..).zip(&self.pieces) {
            for &node in &piece.nodes {
                graph.op(node).operands().for_each(|o| _ = note(&mut loads, o, at));
                if let Op::Element { slot, .. } = graph.op(node) {
                    let last = elements.entry(slot).or_default();
                    *last = at.max(*last);
                }
            }
        }
        loop {
            let mut moved = false;
            for (put, at) in self.edge.partition.puts.iter().zip(put_at.iter_mut()) {
                let Put { slot, index, mask, v, u, .. } = *put;
                // of several that write to a memory the later ones come after the earlier
                let last = elements.entry(slot).or_default();
                moved |= *at < *last;
                *at = (*at).max(*last);
                *last = *at;
                for node in [index, mask, v, u] {
                    moved |= note(&mut loads, node, *at);
                }
            }
            for (store, at) in self.edge.partition.stores.iter().zip(store_at.iter_mut()) {
                let last = loads.get(&store.plane).copied().unwrap_or_default();
                moved |= *at < last;
                *at = (*at).max(last);
                moved |= note(&mut loads, store.node, *at);
            }
            if !moved {
                return;
            }
        }
    }
}
