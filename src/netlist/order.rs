//! The order in which cells can be evaluated, each after those it reads, and the feedback loops in which there is none.

use std::collections::{HashMap, VecDeque};

use super::graph::Graph;
use super::{CellId, Driver, Netlist};

/// An evaluation order.
#[derive(Clone, Debug, Default)]
pub struct Order {
    /// Every cell once, each after all that it reads at once, except within a group.
    pub sequence: Vec<CellId>,
    /// Ranges of `sequence` whose cells read each other in a circle.
    pub groups: Vec<std::ops::Range<usize>>,
}

/// A circle of cells, each of which the next reads.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Loop {
    /// The cells.
    pub cells: Vec<CellId>,
}

impl Netlist {
    /// From each net to the cells that read it.
    pub(super) fn readers_of_nets(&self) -> Graph {
        Graph::new(self.nets.len(), |f| {
            for to in self.cell_ids() {
                for pin in 0..self.cell(to).kind.inputs().len() {
                    self.input(to, pin).iter().for_each(|s| f(s.net.0, to.0));
                }
            }
        })
    }

    /// From each cell to those that a change of it can change at once.
    fn readers_at_once(&self) -> Graph {
        let constants = self.constants();
        Graph::new(self.cells.len(), |f| {
            for to in self.cell_ids() {
                let kind = &self.cell(to).kind;
                for pin in 0..kind.inputs().len() {
                    if !kind.acts_at_once(pin, |p| !self.input(to, p).iter().all(|s| constants.is_zero(s))) {
                        continue;
                    }
                    for slice in self.input(to, pin).iter().filter(|s| !constants.covers(s)) {
                        if let Driver::Cell(from, _) = self.net(slice.net).driver {
                            f(from.0, to.0);
                        }
                    }
                }
            }
        })
    }

    /// An evaluation order; found once, when it is first asked for.
    #[must_use]
    pub fn order(&self) -> &Order {
        self.order.get_or_init(|| {
            let sorted = self.readers_at_once().sorted();
            Order { sequence: sorted.sequence.into_iter().map(CellId).collect(), groups: sorted.groups }
        })
    }

    /// One shortest circle for each group of cells that feed back on each other.
    #[must_use]
    pub fn loops(&self) -> Vec<Loop> {
        let order = self.order();
        if order.groups.is_empty() {
            return Vec::new();
        }
        let readers = self.readers_at_once();
        order.groups.iter().filter_map(|g| self.circle_among(&readers, &order.sequence[g.clone()])).collect()
    }

    /// A shortest circle among some cells, if they feed back on each other.
    #[must_use]
    pub fn circle(&self, cells: &[CellId]) -> Option<Loop> {
        self.circle_among(&self.readers_at_once(), cells)
    }

    /// The shortest circle through the member that comes first by name of those that lie on one, which does not depend
    /// on the order of cells.
    fn circle_among(&self, readers: &Graph, members: &[CellId]) -> Option<Loop> {
        let mut starts: Vec<CellId> = members.to_vec();
        starts.sort_by_cached_key(|&c| self.cell_path(c));
        let rank: HashMap<CellId, usize> = starts.iter().enumerate().map(|(rank, &c)| (c, rank)).collect();
        starts.iter().find_map(|&start| shortest_circle(readers, start, &rank))
    }
}

/// The shortest circle from a cell through others back to it; of several the one whose cells come first by `rank`.
fn shortest_circle(readers: &Graph, start: CellId, rank: &HashMap<CellId, usize>) -> Option<Loop> {
    let mut from: HashMap<CellId, CellId> = HashMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(cell) = queue.pop_front() {
        let mut next: Vec<CellId> = readers.after(cell.0).iter().map(|&to| CellId(to)).collect();
        next.sort_by_key(|to| rank.get(to));
        for to in next {
            if to == start {
                let mut cells = vec![cell];
                while let Some(&previous) = cells.last().and_then(|last| from.get(last)) {
                    cells.push(previous);
                }
                cells.reverse();
                return Some(Loop { cells });
            }
            if rank.contains_key(&to) && !from.contains_key(&to) {
                from.insert(to, cell);
                queue.push_back(to);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::cell::GateOp;
    use crate::netlist::{Builder, Netlist};

    fn names(netlist: &Netlist) -> Vec<String> {
        netlist.order().sequence.iter().map(|&c| netlist.cell(c).name.clone()).collect()
    }

    #[test]
    fn cells_come_after_what_they_read() {
        let mut b = Builder::new("top");
        let (a, y) = (b.input("a", 1), b.output("y", 1));
        let (m, n) = (b.net("m", 1), b.net("n", 1));
        let not = |op| crate::cell::CellKind::Gate { op, width: 1, inputs: 1 };
        let top = b.top();
        b.cell(top, "third", not(GateOp::Not), vec![n.clone()], vec![y]);
        b.cell(top, "second", not(GateOp::Not), vec![m.clone()], vec![n]);
        b.cell(top, "first", not(GateOp::Not), vec![a], vec![m]);
        let netlist = b.finish().unwrap();
        assert_eq!(names(&netlist), ["first", "second", "third"]);
        assert!(netlist.order().groups.is_empty());
    }

    #[test]
    fn a_flip_flop_breaks_a_loop_and_a_latch_pair_does_not() {
        let mut b = Builder::new("top");
        let (s, r) = (b.input("s", 1), b.input("r", 1));
        let (q, qn) = (b.output("q", 1), b.output("qn", 1));
        let top = b.top();
        let nor = crate::cell::CellKind::Gate { op: GateOp::Nor, width: 1, inputs: 2 };
        b.cell(top, "b", nor.clone(), vec![crate::netlist::Bus::concat([&r, &qn])], vec![q.clone()]);
        b.cell(top, "a", nor, vec![crate::netlist::Bus::concat([&s, &q])], vec![qn]);
        let not_q = b.not("inv", &q);
        let toggled = b.net("toggled", 1);
        b.dff("ff", &s, &not_q, &toggled);
        let netlist = b.finish().unwrap();
        assert_eq!(netlist.order().groups.len(), 1);
        let loops = netlist.loops();
        let path: Vec<_> = loops[0].cells.iter().map(|&c| netlist.cell(c).name.as_str()).collect();
        assert_eq!(path, ["a", "b"]);
    }

    #[test]
    fn a_chain_of_a_million_cells_does_not_overflow_the_stack() {
        let mut b = Builder::new("top");
        let mut bus = b.input("a", 1);
        for _ in 0..1_000_000 {
            bus = b.not("n", &bus);
        }
        let netlist = b.finish().unwrap();
        assert_eq!(netlist.order().sequence.len(), 1_000_000);
    }
}
