//! A whole cycle of a clock: its two edges composed into one step, on state in recovered words while the loop runs.
//!
//! Sound: all that either edge bails out for, each guard, and each change of an observed net is a bail-out of the cycle, looked
//! at before anything is stored; the edges then do that cycle one by one. What the first edge writes into memories the second
//! would have to see, so no cycle is made where the second reads or writes any after it.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::stores::Put;
use crate::compiled::passes::edge::EdgeCode;
use crate::compiled::passes::word_recovery::Step;

/// Edges one after another as one step of what they read and leave.
pub(crate) fn compose(edges: &[&EdgeCode]) -> Option<Step> {
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

#[cfg(test)]
mod tests;
