//! A tick that is too long for one function in pieces, each of which does its part of the work on memory.
//!
//! What a piece leaves for a later one lies in memory. Nothing is written over before the last piece that reads it has
//! run: a store waits for that, so all pieces together see the state as it was before the tick. Where the tick may be left
//! before it has done anything, all state waits for the last piece that tells.
//!
//! What has nothing to do with the rest (`parts`) gets pieces of its own where there are several of the kind, so that these
//! come out alike and share their code (`same`).

use crate::compiled::ir::graph::{Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::plan::{Chunk, Plan};
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;
use crate::compiled::passes::components::parts;
use crate::compiled::passes::edge::Tick;

const NONE: u32 = u32::MAX;
/// What may be a piece of its own has at least this part of the nodes of a whole one: a call costs something.
const APART: usize = 16;

struct Split<'t> {
    tick: &'t Tick,
    limit: usize,
    /// The piece of each node.
    piece: Vec<u32>,
    pieces: Vec<Chunk>,
}

/// Pieces of a tick, of about `limit` nodes each, and where what they leave each other lies. `fresh` gives places.
pub(crate) fn split(tick: &Tick, limit: usize, mut fresh: impl FnMut() -> PlaneWord) -> Plan {
    let mut s = Split { tick, limit, piece: vec![NONE; tick.graph.len()], pieces: vec![Chunk::default()] };
    let (stores, puts, aborts) = (&tick.chunk.stores, &tick.chunk.puts, &tick.chunk.aborts);
    let parts = parts(tick, limit / APART);
    for part in parts.iter().filter(|part| !part.aborts.is_empty()) {
        part.aborts.iter().for_each(|&i| _ = s.assign(&[aborts[i]], true));
        s.close();
    }
    // what comes before this is left where the tick is
    let first = if aborts.is_empty() { 0 } else { s.open() };
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
    let mut lay = |node: Id, by: u32, pieces: &mut Vec<Chunk>| {
        if tick.graph.op(node).is_leaf() || piece[node.index()] == by || place.contains_key(&node) {
            return;
        }
        let plane = fresh();
        place.insert(node, plane);
        pieces[piece[node.index()] as usize].stores.push(Store::plain(node, plane));
    };
    for by in 0..pieces.len() as u32 {
        let nodes = std::mem::take(&mut pieces[by as usize].nodes);
        for &node in &nodes {
            tick.graph.op(node).operands().for_each(|o| lay(o, by, &mut pieces));
        }
        pieces[by as usize].nodes = nodes;
        pieces[by as usize].nodes.sort_unstable();
    }
    for &abort in aborts {
        // what is a leaf has no piece
        let at = if piece[abort.index()] == NONE { 0 } else { piece[abort.index()] };
        pieces[at as usize].aborts.push(abort);
    }
    for (store, &at) in stores.iter().zip(&store_at) {
        lay(store.node, at, &mut pieces);
        pieces[at as usize].stores.push(store.clone());
    }
    for (put, &at) in puts.iter().zip(&put_at) {
        put.nodes().into_iter().for_each(|node| lay(node, at, &mut pieces));
        pieces[at as usize].puts.push(*put);
    }
    Plan { chunks: pieces, place, ..Plan::default() }
}

impl Split<'_> {
    /// Begins a piece; its number, which is not 0.
    fn open(&mut self) -> u32 {
        self.close();
        if self.pieces.len() == 1 {
            self.pieces.push(Chunk::default());
        }
        self.pieces.len() as u32 - 1
    }

    /// Ends the present piece, if there is anything in it.
    fn close(&mut self) {
        if self.pieces.last().is_none_or(|last| !last.nodes.is_empty()) {
            self.pieces.push(Chunk::default());
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
            if self.tick.graph.op(node).is_leaf() || seen.insert(node, ()).is_some() {
                continue;
            }
            match self.piece[node.index()] {
                NONE => {
                    new.push(node);
                    stack.extend(self.tick.graph.op(node).operands());
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
            self.pieces.push(Chunk::default());
        }
        at
    }

    /// Puts off what is written until all that reads it has run.
    fn wait(&self, store_at: &mut [u32], put_at: &mut [u32]) {
        let mut loads: Map<PlaneWord, u32> = Map::default();
        let mut elements: Map<Slot, u32> = Map::default();
        let graph = &self.tick.graph;
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
            for (put, at) in self.tick.chunk.puts.iter().zip(put_at.iter_mut()) {
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
            for (store, at) in self.tick.chunk.stores.iter().zip(store_at.iter_mut()) {
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
