//! The order in which cells can be evaluated, each after those it reads, and the feedback loops in which there is none.

use std::collections::{HashMap, VecDeque};
use std::ops::Range;

use super::graph::Graph;
use super::{CellId, Driver, Netlist};
use crate::cell::CellKind;

/// An evaluation order.
#[derive(Clone, Debug, Default)]
pub struct Order {
    /// Every cell once, each after all that it reads at once, except within a group; but a memory once for each port that
    /// reads without a clock, unless one writes so, and once for those with a clock. Whoever evaluates a memory as a whole
    /// at each of its places is right, too.
    pub sequence: Vec<CellId>,
    /// For each place in `sequence` the read port that is meant, where the cell stands at several; one with a clock stands
    /// for all of them.
    pub ports: HashMap<usize, u32>,
    /// Ranges of `sequence` that are combinational loops (strongly connected components), stepped as one.
    pub groups: Vec<std::ops::Range<usize>>,
}

/// A combinational loop: cells that read each other without a clock between them.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Loop {
    /// The cells, each of which reads the one before it, and the first the last.
    pub cells: Vec<CellId>,
}

impl Netlist {
    /// From each net to the cells that read it.
    pub(super) fn readers_of_nets(&self) -> Graph {
        Graph::new(self.nets().len(), |f| {
            for to in self.cell_ids() {
                for pin in 0..self.cell(to).kind.inputs().len() {
                    self.input(to, pin).iter().for_each(|s| f(s.net.0, to.0));
                }
            }
        })
    }

    /// From each node to those that a change of it can change at once.
    fn readers_at_once(&self, nodes: &Nodes) -> Graph {
        let constants = self.constants();
        Graph::new(nodes.len(), |f| {
            for to in self.cell_ids() {
                let kind = &self.cell(to).kind;
                for pin in 0..kind.inputs().len() {
                    if !kind.acts_at_once(pin, |p| !self.input(to, p).iter().all(|s| constants.is_zero(s))) {
                        continue;
                    }
                    let mut at = 0;
                    for slice in self.input(to, pin) {
                        let bits = at..at + slice.width;
                        at = bits.end;
                        if constants.covers(slice) || !reads_at_once(kind, pin, &bits) {
                            continue;
                        }
                        let Driver::Cell(from, _) = self.net(slice.net).driver else { continue };
                        for &from in nodes.of_output(self, &from, &(slice.lo..slice.lo + slice.width)) {
                            nodes.of_input(self, &to, pin, &bits).iter().for_each(|&to| f(from, to));
                        }
                    }
                }
            }
        })
    }

    /// An evaluation order; found once, when it is first asked for.
    #[must_use]
    pub fn order(&self) -> &Order {
        self.content.order.get_or_init(|| {
            let nodes = Nodes::new(self);
            let sorted = self.readers_at_once(&nodes).sorted();
            let ports = sorted.sequence.iter().enumerate();
            let ports = ports.filter_map(|(at, &node)| Some((at, nodes.port(node)?))).collect();
            let sequence = sorted.sequence.iter().map(|&node| nodes.cell(node)).collect();
            Order { sequence, ports, groups: sorted.groups }
        })
    }

    /// One shortest circle for each group of cells that feed back on each other.
    #[must_use]
    pub fn loops(&self) -> Vec<Loop> {
        let order = self.order();
        if order.groups.is_empty() {
            return Vec::new();
        }
        let nodes = Nodes::new(self);
        let readers = self.readers_at_once(&nodes);
        let groups = order.groups.iter();
        groups.filter_map(|g| self.circle_among(&nodes, &readers, &order.sequence[g.clone()])).collect()
    }

    /// A shortest circle among some cells, if they feed back on each other.
    #[must_use]
    pub fn circle(&self, cells: &[CellId]) -> Option<Loop> {
        let nodes = Nodes::new(self);
        self.circle_among(&nodes, &self.readers_at_once(&nodes), cells)
    }

    /// The shortest circle through the member that comes first by name of those that lie on one, which does not depend
    /// on the order of cells.
    fn circle_among(&self, nodes: &Nodes, readers: &Graph, members: &[CellId]) -> Option<Loop> {
        let mut starts: Vec<CellId> = members.to_vec();
        starts.sort_by_cached_key(|&c| self.cell_path(c));
        starts.dedup();
        let starts: Vec<u32> = starts.into_iter().flat_map(|cell| nodes.of(cell)).collect();
        let rank: HashMap<u32, usize> = starts.iter().enumerate().map(|(rank, &node)| (node, rank)).collect();
        let circle = starts.iter().find_map(|&start| shortest_circle(readers, start, &rank))?;
        Some(Loop { cells: circle.into_iter().map(|node| nodes.cell(node)).collect() })
    }
}

/// Whether some bits of a pin of which a change acts at once do so: of a memory's addresses those without a clock.
fn reads_at_once(kind: &CellKind, pin: usize, bits: &Range<u32>) -> bool {
    match kind {
        CellKind::Memory(m) if pin == crate::cell::pin::memory::RD_ADDR => {
            let ports = (bits.start / m.abits) as usize..=((bits.end - 1) / m.abits) as usize;
            m.reads[ports].iter().any(|r| r.clock.is_none())
        }
        _ => true,
    }
}

/// What is put in order: cells, of memories their read ports, those with a clock together. The first node of a cell has
/// its number.
struct Nodes {
    cells: u32,
    /// The further nodes, in order: the memory and the port.
    more: Vec<(CellId, u32)>,
    /// For each memory with several nodes that of each port.
    of_ports: HashMap<CellId, Vec<u32>>,
}

impl Nodes {
    fn new(netlist: &Netlist) -> Nodes {
        let cells = netlist.cells().len() as u32;
        let mut nodes = Nodes { cells, more: Vec::new(), of_ports: HashMap::new() };
        for cell in netlist.cell_ids() {
            let CellKind::Memory(memory) = &netlist.cell(cell).kind else { continue };
            let now = memory.reads.iter().filter(|r| r.clock.is_none()).count();
            let clocked = now < memory.reads.len();
            // what writes by level is before all that reads
            if now + usize::from(clocked) < 2 || memory.writes.iter().any(|w| w.clock.is_none()) {
                continue;
            }
            let mut first = !clocked;
            let list = memory.reads.iter().enumerate().map(|(port, read)| {
                if read.clock.is_some() || std::mem::take(&mut first) {
                    return cell.0;
                }
                nodes.more.push((cell, port as u32));
                cells + nodes.more.len() as u32 - 1
            });
            let list = list.collect();
            nodes.of_ports.insert(cell, list);
        }
        nodes
    }

    fn len(&self) -> usize {
        self.cells as usize + self.more.len()
    }

    fn cell(&self, node: u32) -> CellId {
        match node.checked_sub(self.cells) {
            Some(more) => self.more[more as usize].0,
            None => CellId(node),
        }
    }

    /// The port that a node is, of a memory with several.
    fn port(&self, node: u32) -> Option<u32> {
        match node.checked_sub(self.cells) {
            Some(more) => Some(self.more[more as usize].1),
            None => Some(self.of_ports.get(&CellId(node))?.iter().position(|&n| n == node)? as u32),
        }
    }

    /// All nodes of a cell.
    fn of(&self, cell: CellId) -> Vec<u32> {
        let mut list = self.of_ports.get(&cell).cloned().unwrap_or_else(|| vec![cell.0]);
        list.sort_unstable();
        list.dedup();
        list
    }

    /// The nodes that give some bits of the output of a cell.
    fn of_output<'a>(&'a self, netlist: &Netlist, cell: &'a CellId, bits: &Range<u32>) -> &'a [u32] {
        self.ports(cell, bits, || netlist.cell(*cell).kind.output_width(0))
    }

    /// The nodes that read some bits of an input pin.
    fn of_input<'a>(&'a self, netlist: &Netlist, cell: &'a CellId, pin: usize, bits: &Range<u32>) -> &'a [u32] {
        self.ports(cell, bits, || netlist.cell(*cell).kind.input_width(pin))
    }

    /// The nodes of the ports that have some bits of a pin that has `width` bits of all read ports.
    fn ports<'a>(&'a self, cell: &'a CellId, bits: &Range<u32>, width: impl Fn() -> u32) -> &'a [u32] {
        match self.of_ports.get(cell) {
            Some(list) => {
                let each = width() / list.len() as u32;
                &list[(bits.start / each) as usize..=((bits.end - 1) / each) as usize]
            }
            None => std::slice::from_ref(&cell.0),
        }
    }
}

/// The shortest circle from a node through others back to it; of several the one whose nodes come first by `rank`.
fn shortest_circle(readers: &Graph, start: u32, rank: &HashMap<u32, usize>) -> Option<Vec<u32>> {
    let mut from: HashMap<u32, u32> = HashMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        let mut next: Vec<u32> = readers.after(node).to_vec();
        next.sort_by_key(|to| rank.get(to));
        for to in next {
            if to == start {
                let mut circle = vec![node];
                while let Some(&previous) = circle.last().and_then(|last| from.get(last)) {
                    circle.push(previous);
                }
                circle.reverse();
                return Some(circle);
            }
            if rank.contains_key(&to) && !from.contains_key(&to) {
                from.insert(to, node);
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
