//! A whole cycle of a clock: its two edges composed into one step, on state in recovered words while the loop runs.
//!
//! Sound: all that either edge bails out for, each guard, and each change of an observed net is a bail-out of the cycle, looked
//! at before anything is stored; the edges then do that cycle one by one. What the first edge writes into memories the second
//! would have to see, so no cycle is made where the second reads or writes any after it.

use crate::compiled::codegen::machine::EdgeLoop;
use crate::compiled::codegen::{self, Shared};
use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::record::Record;
use crate::compiled::ir::schedule::Partition;
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;
use crate::compiled::passes::edge::EdgeCode;
use crate::compiled::passes::word_recovery::{LEAST, Place, Recovered, Step, TRIALS, recover};
use crate::value::Word;

/// A cycle in machine code.
#[derive(Debug)]
pub(crate) struct Cycle {
    edge_loop: EdgeLoop,
    places: Vec<Place>,
    /// Whether each of the places changes.
    changing: Vec<bool>,
    /// Periods to sit out after it was left at once, and how many of these are to come.
    patience: u32,
    waiting: u32,
}

/// Periods up to which going in and out costs more than it gains.
pub(crate) const SHORT: u64 = 32;

impl Cycle {
    /// Makes a cycle of its edges. `groups` are the lanes that single bits of state get.
    pub fn new(edges: &[&EdgeCode], groups: &[Vec<(u8, PlaneWord)>], piece: usize, end: &mut u32) -> Option<Cycle> {
        let mut step = compose(edges)?;
        let plain = step.cost();
        let mut next = 2 * *end;
        let mut fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let Recovered { step, places, .. } = recover(&mut step, groups, LEAST, TRIALS, &mut fresh)?;
        // What does not lie in words is better left as it is. Long edges come in pieces, which share code where they are
        // alike; a cycle, which is left before anything is stored, does so less well.
        let least = if edges.iter().any(|edge| codegen::is_long(&edge.partition, piece)) { plain / 8 } else { 0 };
        if step.cost() + least >= plain {
            return None;
        }
        let nodes = step.needed();
        let changes: Map<PlaneWord, ()> = step.stores.iter().map(|s| (s.0, ())).collect();
        let changing = places.iter().map(|p| changes.contains_key(&p.word)).collect();
        let stores = step.stores.iter().map(|&(plane, node)| Store::plain(node, plane)).collect();
        let partition = Partition { nodes, stores, puts: step.puts, bail_outs: step.bail_outs, ..Partition::default() };
        let edge = EdgeCode { partition, graph: step.graph, record: Record::default() };
        let edge_loop = codegen::compile_loop(&[&edge], piece, Shared::default(), &mut fresh).ok()?;
        *end = next.div_ceil(2);
        Some(Cycle { edge_loop, places, changing, patience: 1, waiting: 0 })
    }

    /// Goes round up to `rounds` times; how many times it did.
    pub fn run(&mut self, memory: &mut [Word], rounds: u64) -> u64 {
        if self.waiting > 0 {
            self.waiting -= 1;
            return 0;
        }
        for Place { word, lanes } in &self.places {
            *word_of(memory, *word) = lanes.iter().fold(0, |all, &(lane, h)| all | (*word_of(memory, h) & 1) << lane);
        }
        let done = self.edge_loop.run(memory, rounds);
        for (Place { word, lanes }, _) in self.places.iter().zip(&self.changing).filter(|p| *p.1) {
            let value = *word_of(memory, *word);
            lanes.iter().for_each(|&(lane, h)| *word_of(memory, h) = value >> lane & 1);
        }
        if done < SHORT {
            self.patience = (self.patience * 2).min(1 << 12);
            self.waiting = self.patience;
        } else {
            self.patience = 1;
        }
        done
    }
}

/// Edges one after another as one step of what they read and leave.
fn compose(edges: &[&EdgeCode]) -> Option<Step> {
    let mut out = Graph::factoring();
    let mut now: Map<PlaneWord, Id> = Map::default();
    let mut order: Vec<PlaneWord> = Vec::new();
    let mut bail_outs: Vec<Id> = Vec::new();
    let mut puts: Vec<Put> = Vec::new();
    for edge in edges {
        let g = &edge.graph;
        // what one has written into memories the next would have to see
        let reads = edge.partition.nodes.iter().any(|&n| matches!(g.op(n), Op::Element { .. }));
        if !puts.is_empty() && (reads || !edge.partition.puts.is_empty()) {
            return None;
        }
        let mut map: Map<Id, Id> = Map::default();
        let at = |out: &mut Graph, node: Id, map: &Map<Id, Id>| match g.op(node) {
            Op::Const(n) => out.constant(n),
            Op::Load(plane) => match now.get(&plane) {
                Some(&node) => node,
                None => out.load(plane, g.possible_bits(node)),
            },
            _ => map[&node],
        };
        for &node in &edge.partition.nodes {
            let operands: Vec<(Id, Id)> = g.op(node).operands().map(|o| (o, at(&mut out, o, &map))).collect();
            let made = out.rebuild(g.op(node), g.possible_bits(node), |o| {
                operands.iter().find(|p| p.0 == o).expect("it is an operand").1
            });
            map.insert(node, made);
        }
        let mut bail_out = |out: &Graph, node: Id| {
            if !out.is(node, 0) && !bail_outs.contains(&node) {
                bail_outs.push(node);
            }
        };
        for &node in &edge.partition.bail_outs {
            let node = at(&mut out, node, &map);
            bail_out(&out, node);
        }
        for put in &edge.partition.puts {
            let [index, mask, v, u] = [put.index, put.mask, put.v, put.u].map(|node| at(&mut out, node, &map));
            puts.push(Put { index, mask, v, u, ..*put });
        }
        let mut made = Vec::new();
        for store in &edge.partition.stores {
            if store.guard {
                let node = at(&mut out, store.node, &map);
                bail_out(&out, node);
            }
            made.push((store.plane, at(&mut out, store.node, &map), store.compared));
        }
        let mut compared = Vec::new();
        for (plane, node, observed) in made {
            if observed {
                let old = match now.get(&plane) {
                    Some(&node) => node,
                    None => out.load(plane, u64::MAX),
                };
                compared.push((plane, old, node));
            }
            if now.insert(plane, node).is_none() {
                order.push(plane);
            }
        }
        for (_, old, node) in compared {
            let differs = out.xor(old, node);
            if !out.is(differs, 0) && !bail_outs.contains(&differs) {
                bail_outs.push(differs);
            }
        }
    }
    let stores = order.into_iter().map(|plane| (plane, now[&plane]));
    let stores = stores.filter(|&(plane, node)| out.op(node) != Op::Load(plane)).collect();
    Some(Step { graph: out, stores, puts, bail_outs })
}

fn word_of(memory: &mut [Word], plane: PlaneWord) -> &mut u64 {
    let word = &mut memory[plane.slot().index()];
    if plane.is_value() { &mut word.v } else { &mut word.u }
}

#[cfg(test)]
mod tests;
