//! From a graph to partitions: which nodes are computed together, what they leave in memory, and which partitions a change
//! wakes.
//!
//! Nodes stand in the order of a walk from the roots, so a partition holds whole cones where it can. What one leaves for a
//! later one is stored and compared; only a change wakes the later one.
//!
//! Sound: after all woken partitions have run in order, every root has in memory what its node is there. That holds since an
//! operand is computed in the same partition before its use, or is stored by an earlier one that wakes this one; and since
//! state and contents of memories wake whatever loads them. What a combinational loop needs stays in one partition.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::schedule::{Partition, Root, Schedule};
use crate::compiled::ir::stores::Store;

const NONE: u32 = u32::MAX;

struct Walk<'g> {
    graph: &'g Graph,
    /// The partition of each node.
    partition_of: Vec<u32>,
    schedule: Schedule,
    limit: usize,
    /// The loop that is being laid out.
    group: Option<u32>,
}

impl Walk<'_> {
    fn current(&mut self) -> u32 {
        let full = self.schedule.partitions.last().is_none_or(|c| match (c.group, self.group) {
            (None, None) => c.nodes.len() >= self.limit,
            (None, Some(_)) => false,
            (had, now) => had != now,
        });
        if full {
            self.schedule.partitions.push(Partition::default());
        }
        let number = self.schedule.partitions.len() - 1;
        let partition = &mut self.schedule.partitions[number];
        partition.group = partition.group.or(self.group);
        number as u32
    }

    /// Gives a node and all that it needs a partition.
    fn visit(&mut self, root: Id, stack: &mut Vec<(Id, bool)>) {
        stack.push((root, false));
        while let Some((node, ready)) = stack.pop() {
            if self.partition_of[node.index()] != NONE || self.graph.op(node).is_leaf() {
                continue;
            }
            if ready {
                let partition = self.current();
                self.partition_of[node.index()] = partition;
                self.schedule.partitions[partition as usize].nodes.push(node);
                continue;
            }
            stack.push((node, true));
            let op = self.graph.op(node);
            op.operands().for_each(|o| stack.push((o, false)));
        }
    }
}

/// Plans partitions of at most `limit` nodes. `fresh` gives places in memory.
pub(crate) fn partition(
    graph: &Graph,
    settling: &[Root],
    sampled: &[Root],
    limit: usize,
    mut fresh: impl FnMut() -> PlaneWord,
) -> Schedule {
    let mut w =
        Walk { graph, partition_of: vec![NONE; graph.len()], schedule: Schedule::default(), limit, group: None };
    let mut stack = Vec::new();
    let mut placed = Vec::new();
    for (late, roots) in [(false, settling), (true, sampled)] {
        if late {
            w.schedule.settling = w.schedule.partitions.len();
            // nodes of the two kinds do not share a partition
            w.schedule.partitions.push(Partition::default());
        }
        for root in roots {
            // what a loop holds is no constant: an edge may put something else there, which its other cells see for a step
            if let Some(n) = graph.value(root.node).filter(|_| root.group.is_none()) {
                w.schedule.constants.push((*root, n));
                continue;
            }
            w.group = root.group;
            w.visit(root.node, &mut stack);
            let partition = match w.partition_of[root.node.index()] {
                NONE => w.current(),
                // what was computed for settling may be wanted again before an edge
                partition if late && (partition as usize) < w.schedule.settling => w.current(),
                partition => partition,
            };
            placed.push((partition, *root));
        }
    }
    let Walk { partition_of, mut schedule, .. } = w;
    // what is used in a later partition, and by which
    let mut uses: Map<Id, Vec<u32>> = Map::default();
    let mut used = |node: Id, by: u32, readers: &mut Map<Slot, Vec<u32>>| {
        let list = match graph.op(node) {
            Op::Const(_) => return,
            Op::Load(plane) => readers.entry(plane.slot()).or_default(),
            _ if partition_of[node.index()] == by => return,
            _ => uses.entry(node).or_default(),
        };
        if list.last() != Some(&by) {
            list.push(by);
        }
    };
    for (number, partition) in schedule.partitions.iter().enumerate() {
        for &node in &partition.nodes {
            let op = graph.op(node);
            op.operands().for_each(|o| used(o, number as u32, &mut schedule.readers));
            if let Op::Element { slot, .. } = op {
                let list = schedule.readers.entry(slot).or_default();
                if list.last() != Some(&(number as u32)) {
                    list.push(number as u32);
                }
            }
        }
    }
    for (partition, root) in &placed {
        used(root.node, *partition, &mut schedule.readers);
        if root.state {
            schedule.readers.entry(root.plane.slot()).or_default().push(*partition);
        }
    }
    for list in uses.values_mut().chain(schedule.readers.values_mut()) {
        list.sort_unstable();
        list.dedup();
    }
    for (partition, root) in placed {
        let own = partition_of[root.node.index()] == partition;
        let mut wakes = Vec::new();
        if root.shared && own && !schedule.place.contains_key(&root.node) {
            schedule.place.insert(root.node, root.plane);
            wakes = uses.get(&root.node).cloned().unwrap_or_default();
        }
        // state that a control changes at once is read as state too
        for &reader in schedule.readers.get(&root.plane.slot()).map_or(&[][..], Vec::as_slice) {
            if !wakes.contains(&reader) {
                wakes.push(reader);
            }
        }
        let compared = root.observed.is_some() || !wakes.is_empty();
        let Root { node, plane, observed, guard, again, .. } = root;
        schedule.partitions[partition as usize].stores.push(Store {
            node,
            plane,
            observed,
            guard,
            compared,
            wakes,
            again,
        });
    }
    let mut rest: Vec<(Id, Vec<u32>)> =
        uses.into_iter().filter(|(node, _)| !schedule.place.contains_key(node)).collect();
    rest.sort_unstable_by_key(|(node, _)| *node);
    for (node, wakes) in rest {
        let plane = fresh();
        schedule.place.insert(node, plane);
        let store = Store { compared: true, wakes, ..Store::plain(node, plane) };
        schedule.partitions[partition_of[node.index()] as usize].stores.push(store);
    }
    schedule
}

#[cfg(test)]
mod tests;
