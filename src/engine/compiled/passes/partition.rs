//! From a graph to chunks: which nodes are computed together, what they leave in memory, and who is to look again when
//! that changes.
//!
//! Nodes stand in the order of a walk from what is wanted, so a chunk holds whole cones where it can. What a chunk leaves
//! for a later one is stored and compared; only a change wakes the later one.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::plan::{Chunk, Plan, Root};
use crate::compiled::ir::stores::Store;

const NONE: u32 = u32::MAX;

struct Walk<'g> {
    graph: &'g Graph,
    /// The chunk of each node.
    chunk_of: Vec<u32>,
    plan: Plan,
    limit: usize,
    /// The loop that is being laid out.
    group: Option<u32>,
}

impl Walk<'_> {
    fn current(&mut self) -> u32 {
        let full = self.plan.chunks.last().is_none_or(|c| match (c.group, self.group) {
            (None, None) => c.nodes.len() >= self.limit,
            (None, Some(_)) => false,
            (had, now) => had != now,
        });
        if full {
            self.plan.chunks.push(Chunk::default());
        }
        let number = self.plan.chunks.len() - 1;
        let chunk = &mut self.plan.chunks[number];
        chunk.group = chunk.group.or(self.group);
        number as u32
    }

    /// Gives a node and all that it needs a chunk.
    fn visit(&mut self, root: Id, stack: &mut Vec<(Id, bool)>) {
        stack.push((root, false));
        while let Some((node, ready)) = stack.pop() {
            if self.chunk_of[node.index()] != NONE || self.graph.op(node).is_leaf() {
                continue;
            }
            if ready {
                let chunk = self.current();
                self.chunk_of[node.index()] = chunk;
                self.plan.chunks[chunk as usize].nodes.push(node);
                continue;
            }
            stack.push((node, true));
            let op = self.graph.op(node);
            op.operands().for_each(|o| stack.push((o, false)));
        }
    }
}

/// Plans chunks of at most `limit` nodes. `fresh` gives places in memory.
pub(crate) fn partition(
    graph: &Graph,
    settling: &[Root],
    sampled: &[Root],
    limit: usize,
    mut fresh: impl FnMut() -> PlaneWord,
) -> Plan {
    let mut w = Walk { graph, chunk_of: vec![NONE; graph.len()], plan: Plan::default(), limit, group: None };
    let mut stack = Vec::new();
    let mut placed = Vec::new();
    for (late, roots) in [(false, settling), (true, sampled)] {
        if late {
            w.plan.settling = w.plan.chunks.len();
            // nodes of the two kinds do not share a chunk
            w.plan.chunks.push(Chunk::default());
        }
        for root in roots {
            // what a loop holds is no constant: an edge may put something else there, which its other cells see for a step
            if let Some(n) = graph.value(root.node).filter(|_| root.group.is_none()) {
                w.plan.constants.push((*root, n));
                continue;
            }
            w.group = root.group;
            w.visit(root.node, &mut stack);
            let chunk = match w.chunk_of[root.node.index()] {
                NONE => w.current(),
                // what was computed for settling may be wanted again before an edge
                chunk if late && (chunk as usize) < w.plan.settling => w.current(),
                chunk => chunk,
            };
            placed.push((chunk, *root));
        }
    }
    let Walk { chunk_of, mut plan, .. } = w;
    // what is used in a later chunk, and by which
    let mut uses: Map<Id, Vec<u32>> = Map::default();
    let mut used = |node: Id, by: u32, readers: &mut Map<Slot, Vec<u32>>| {
        let list = match graph.op(node) {
            Op::Const(_) => return,
            Op::Load(plane) => readers.entry(plane.slot()).or_default(),
            _ if chunk_of[node.index()] == by => return,
            _ => uses.entry(node).or_default(),
        };
        if list.last() != Some(&by) {
            list.push(by);
        }
    };
    for (number, chunk) in plan.chunks.iter().enumerate() {
        for &node in &chunk.nodes {
            let op = graph.op(node);
            op.operands().for_each(|o| used(o, number as u32, &mut plan.readers));
            if let Op::Element { slot, .. } = op {
                let list = plan.readers.entry(slot).or_default();
                if list.last() != Some(&(number as u32)) {
                    list.push(number as u32);
                }
            }
        }
    }
    for (chunk, root) in &placed {
        used(root.node, *chunk, &mut plan.readers);
        if root.state {
            plan.readers.entry(root.plane.slot()).or_default().push(*chunk);
        }
    }
    for list in uses.values_mut().chain(plan.readers.values_mut()) {
        list.sort_unstable();
        list.dedup();
    }
    for (chunk, root) in placed {
        let own = chunk_of[root.node.index()] == chunk;
        let mut wakes = Vec::new();
        if root.shared && own && !plan.place.contains_key(&root.node) {
            plan.place.insert(root.node, root.plane);
            wakes = uses.get(&root.node).cloned().unwrap_or_default();
        }
        // state that a control changes at once is read as state too
        for &reader in plan.readers.get(&root.plane.slot()).map_or(&[][..], Vec::as_slice) {
            if !wakes.contains(&reader) {
                wakes.push(reader);
            }
        }
        let compared = root.observed.is_some() || !wakes.is_empty();
        let Root { node, plane, observed, alarm, again, .. } = root;
        plan.chunks[chunk as usize].stores.push(Store { node, plane, observed, alarm, compared, wakes, again });
    }
    let mut rest: Vec<(Id, Vec<u32>)> = uses.into_iter().filter(|(node, _)| !plan.place.contains_key(node)).collect();
    rest.sort_unstable_by_key(|(node, _)| *node);
    for (node, wakes) in rest {
        let plane = fresh();
        plan.place.insert(node, plane);
        let store = Store { compared: true, wakes, ..Store::plain(node, plane) };
        plan.chunks[chunk_of[node.index()] as usize].stores.push(store);
    }
    plan
}

#[cfg(test)]
mod tests;
