//! Logic depth: the longest way, in levels, that a change can take through the combinational cells of a netlist in one
//! instant, bit by bit.
//!
//! A way begins at an input of the circuit or an output of a storage cell, and ends at an output of the circuit or an
//! input of a storage cell. Delays are such a boundary too. What counts as a level is said beside the cells
//! ([`levels`](crate::cell::CellKind::levels)). Bits that constants decide carry no change and are on no way.
//!
//! Feedback without a clock has no depth. Two NOR gates, or NAND gates, that read each other are an SR flip-flop and a
//! boundary like any other storage. Any other loop is taken as a whole: one level, and it is reported.

use serde::Serialize;

use super::bits::{BitNames, Bits};
use super::graph::{Graph, Sorted};
use super::{CellId, Direction, Driver, Netlist, SignalId};
use crate::cell::{CellKind, Flow, GateOp};

/// What levels are counted in.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Gates: all logic of the netlist is gates.
    Gates,
    /// Elements: a word-level element, such as an adder, is one level as a whole.
    Elements,
}

/// The logic depth of a netlist.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Depth {
    /// Levels on the longest way.
    pub levels: u32,
    /// What they are counted in.
    pub unit: Level,
    /// The longest way, of several one that does not depend on the order of cells; none if nothing leads anywhere.
    pub path: Option<Path>,
    /// SR flip-flops made of two gates that read each other.
    pub sr_of_gates: u64,
    /// The cells of every other loop, sorted by name.
    pub loops: Vec<Vec<String>>,
}

/// A path through the logic.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Path {
    /// An input of the circuit or an output of a storage cell.
    pub start: End,
    /// The cells that it goes through, in order.
    pub steps: Vec<Step>,
    /// An output of the circuit or an input of a storage cell.
    pub end: End,
}

/// An end of a path.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
pub struct End {
    /// The pin of the storage cell; none at a port of the circuit.
    pub pin: Option<String>,
    /// The bit, as `net` or `net[i]`.
    pub net: String,
}

/// A cell on a path.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Step {
    /// The cell's path; of a loop that of one of its cells.
    pub cell: String,
    /// The element that it is, or `loop`.
    pub element: &'static str,
    /// The bit that comes out of it.
    pub net: String,
    /// Levels from the start of the path up to and including this cell.
    pub level: u32,
    /// Where the cell comes from in the source of the tool that made the netlist, if whoever shows this knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

impl Depth {
    /// Measures a netlist.
    #[must_use]
    pub fn of(netlist: &Netlist) -> Depth {
        let bits = Bits::new(netlist);
        Depth::with(&bits, &BitNames::new(netlist, &bits), netlist)
    }

    pub(super) fn with(bits: &Bits, names: &BitNames<'_>, netlist: &Netlist) -> Depth {
        let gates = netlist.cells().iter().all(|c| c.kind.is_gates());
        let measured = Measured::new(netlist, bits, names);
        let end = measured.end();
        Depth {
            levels: end.as_ref().map_or(0, |&(bit, _)| measured.depth[bit as usize]),
            unit: if gates { Level::Gates } else { Level::Elements },
            path: end.map(|(bit, end)| measured.path(bit, end)),
            sr_of_gates: measured.groups.iter().filter(|g| g.is_sr).count() as u64,
            loops: measured.loops(),
        }
    }
}

/// Nodes that follow each other in a circle.
struct Group {
    members: Vec<u32>,
    /// Whether it is an SR flip-flop made of two gates.
    is_sr: bool,
}

/// A netlist with the depth of every node. The nodes are the bits, and after them one for each cell: the place where
/// the bits that all bits of an output follow come together.
struct Measured<'n> {
    netlist: &'n Netlist,
    bits: &'n Bits,
    names: &'n BitNames<'n>,
    before: Graph,
    depth: Vec<u32>,
    groups: Vec<Group>,
    /// The number of each node's group, plus one; 0 for none.
    group: Vec<u32>,
}

impl<'n> Measured<'n> {
    fn new(netlist: &'n Netlist, bits: &'n Bits, names: &'n BitNames<'n>) -> Measured<'n> {
        let nodes = bits.len() as usize + netlist.cells().len();
        let after = Graph::new(nodes, |f| {
            for cell in netlist.cell_ids() {
                follow(netlist, bits, cell, f);
            }
        });
        let Sorted { sequence, groups } = after.sorted();
        let before = after.reversed();
        let mut m =
            Measured { netlist, bits, names, before, depth: vec![0; nodes], groups: Vec::new(), group: vec![0; nodes] };
        let mut groups = groups.into_iter().peekable();
        let mut at = 0;
        while at < sequence.len() {
            let range = groups.next_if(|g| g.start == at);
            let members = &sequence[range.clone().unwrap_or(at..at + 1)];
            at += members.len();
            let entry = members.iter().map(|&n| m.depth[n as usize]).max().unwrap_or(0);
            let depth = if range.is_some() {
                m.groups.push(Group { members: members.to_vec(), is_sr: m.is_sr(members) });
                members.iter().for_each(|&n| m.group[n as usize] = m.groups.len() as u32);
                if m.groups.last().is_some_and(|g| g.is_sr) { 0 } else { entry + 1 }
            } else {
                entry + m.levels(members[0])
            };
            for &n in members {
                m.depth[n as usize] = depth;
                for &to in
                    after.after(n).iter().filter(|&&to| range.is_none() || m.group[to as usize] != m.group[n as usize])
                {
                    m.depth[to as usize] = m.depth[to as usize].max(depth);
                }
            }
        }
        m
    }

    /// The cell that drives a node and the number of its output; none for an input of the circuit and where bits of a
    /// cell's inputs come together.
    fn driver(&self, node: u32) -> Option<(CellId, usize)> {
        if node >= self.bits.len() {
            return None;
        }
        match self.netlist.net(self.bits.slice(node).net).driver {
            Driver::Cell(cell, pin) => Some((cell, pin as usize)),
            Driver::Input(_) => None,
        }
    }

    fn kind(&self, cell: CellId) -> &'n CellKind {
        &self.netlist.cell(cell).kind
    }

    fn levels(&self, node: u32) -> u32 {
        self.driver(node).map_or(0, |(cell, pin)| match self.kind(cell) {
            // a port with a clock keeps what it has read
            CellKind::Memory(m) if m.reads[(self.bits.slice(node).lo / m.width) as usize].clock.is_some() => 0,
            kind => kind.levels(pin),
        })
    }

    /// The cell that a node belongs to; none for an input of the circuit.
    fn cell(&self, node: u32) -> Option<CellId> {
        match node.checked_sub(self.bits.len()) {
            Some(cell) => Some(CellId(cell)),
            None => self.driver(node).map(|(cell, _)| cell),
        }
    }

    /// A name for a node, by which those of the same depth are told apart.
    fn name(&self, node: u32) -> String {
        match node.checked_sub(self.bits.len()) {
            Some(cell) => self.netlist.cell_path(CellId(cell)),
            None => self.names.of(node),
        }
    }

    /// Whether the members of a group are the outputs of two NOR gates, or two NAND gates.
    fn is_sr(&self, members: &[u32]) -> bool {
        let op = |node: u32| match *self.kind(self.driver(node)?.0) {
            CellKind::Gate { op, .. } => Some(op),
            _ => None,
        };
        let &[a, b] = members else { return false };
        op(a) == op(b) && matches!(op(a), Some(GateOp::Nor | GateOp::Nand))
    }

    fn group_of(&self, node: u32) -> Option<&Group> {
        Some(&self.groups[self.group[node as usize].checked_sub(1)? as usize])
    }

    fn loops(&self) -> Vec<Vec<String>> {
        let cells = |g: &Group| {
            let mut cells: Vec<CellId> = g.members.iter().filter_map(|&n| self.cell(n)).collect();
            cells.sort_unstable();
            cells.dedup();
            let mut paths: Vec<String> = cells.into_iter().map(|c| self.netlist.cell_path(c)).collect();
            paths.sort_unstable();
            paths
        };
        let mut loops: Vec<_> = self.groups.iter().filter(|g| !g.is_sr).map(cells).collect();
        loops.sort_unstable();
        loops
    }

    /// Calls what it is given with every bit at which a way can end, and the pin or port there.
    fn ends(&self, f: &mut dyn FnMut(u32, Place)) {
        let (netlist, bits) = (self.netlist, self.bits);
        let changes = |bit: &u32| !bits.is_constant(*bit);
        for cell in netlist.cell_ids() {
            let kind = self.kind(cell);
            // the gates of an SR flip-flop may be some bits of wide ones
            let outputs = bits.of_net(netlist.output(cell, 0));
            let is_sr = |bit: u32| self.group_of(bit).is_some_and(|g| g.is_sr);
            if !kind.is_boundary() && !outputs.clone().any(is_sr) {
                continue;
            }
            for pin in 0..kind.inputs().len() {
                for (at, bit) in bits.input(netlist, cell, pin).enumerate().filter(|(_, bit)| changes(bit)) {
                    let out = outputs.start + at as u32 % outputs.len() as u32;
                    let within = self.group[bit as usize] == self.group[out as usize];
                    if kind.is_boundary() || is_sr(out) && !within {
                        f(bit, Place::Pin(cell, pin, at as u32));
                    }
                }
            }
        }
        for port in netlist.ports() {
            if matches!(netlist.signal(port).port, Some(Direction::Output | Direction::Inout)) {
                let all = netlist.bits(port).iter().flat_map(|s| bits.of(s)).enumerate();
                all.filter(|(_, bit)| changes(bit)).for_each(|(at, bit)| f(bit, Place::Port(port, at as u32)));
            }
        }
    }

    /// The end of the longest way; of several the first by name, ports before pins.
    fn end(&self) -> Option<(u32, End)> {
        let mut most = None;
        self.ends(&mut |bit, _| most = most.max(Some(self.depth[bit as usize])));
        let mut found: Option<(u32, End)> = None;
        self.ends(&mut |bit, place| {
            if Some(self.depth[bit as usize]) == most {
                let end = self.describe(bit, place);
                if found.as_ref().is_none_or(|(_, first)| end < *first) {
                    found = Some((bit, end));
                }
            }
        });
        found
    }

    fn describe(&self, bit: u32, place: Place) -> End {
        let indexed = |name: String, width: u32, at: u32| if width == 1 { name } else { format!("{name}[{at}]") };
        match place {
            Place::Pin(cell, pin, at) => {
                let kind = self.kind(cell);
                let name = format!("{}.{}", self.netlist.cell_path(cell), kind.inputs()[pin].name);
                End { pin: Some(indexed(name, kind.input_width(pin), at)), net: self.names.of(bit) }
            }
            Place::Port(port, at) => {
                let signal = self.netlist.signal(port);
                End { pin: None, net: indexed(signal.name.clone(), signal.width, at) }
            }
        }
    }

    /// The deepest node before some nodes that is none of them; of several the first by name.
    fn deepest_before(&self, nodes: &[u32], group: u32) -> Option<u32> {
        let outside = |&n: &u32| group == 0 || self.group[n as usize] != group;
        let before = || nodes.iter().flat_map(|&n| self.before.after(n)).copied().filter(outside);
        let most = before().map(|n| self.depth[n as usize]).max()?;
        before().filter(|&n| self.depth[n as usize] == most).min_by_key(|&n| self.name(n))
    }

    fn path(&self, last: u32, end: End) -> Path {
        let mut steps = Vec::new();
        let mut node = last;
        let start = loop {
            let group = self.group_of(node);
            let before = match group {
                Some(g) if g.is_sr => None,
                Some(g) => self.deepest_before(&g.members, self.group[node as usize]),
                None => self.deepest_before(&[node], 0),
            };
            let is_loop = group.is_some_and(|g| !g.is_sr);
            let level = self.depth[node as usize];
            let logic = before.is_some() || level > 0;
            if let Some(cell) = self.cell(node).filter(|_| logic && (is_loop || node < self.bits.len())) {
                let element = if is_loop { "loop" } else { self.netlist.cell(cell).element };
                let (cell, net) = (self.netlist.cell_path(cell), self.name(node));
                steps.push(Step { cell, element, net, level, source: None });
            }
            match before {
                Some(n) => node = n,
                None => break node,
            }
        };
        steps.reverse();
        let pin = self.driver(start).map(|(cell, pin)| {
            let kind = self.kind(cell);
            let name = format!("{}.{}", self.netlist.cell_path(cell), kind.outputs()[pin]);
            if kind.output_width(pin) == 1 { name } else { format!("{name}[{}]", self.bits.slice(start).lo) }
        });
        Path { start: End { pin, net: self.name(start) }, steps, end }
    }
}

/// A place where a way can end.
enum Place {
    /// A bit of an input pin of a cell.
    Pin(CellId, usize, u32),
    /// A bit of a port.
    Port(SignalId, u32),
}

/// The edges through a cell.
fn follow(netlist: &Netlist, bits: &Bits, cell: CellId, f: &mut dyn FnMut(u32, u32)) {
    let kind = &netlist.cell(cell).kind;
    let together = bits.len() + cell.0;
    let outputs = kind.outputs().len();
    let mut meets = vec![false; outputs];
    for pin in 0..kind.inputs().len() {
        for (at, bit) in bits.input(netlist, cell, pin).enumerate() {
            if bits.is_constant(bit) {
                continue;
            }
            for (output, meets) in meets.iter_mut().enumerate() {
                match kind.flow(pin, output) {
                    Flow::None => {}
                    Flow::Bitwise => {
                        let out = bits.of_net(netlist.output(cell, output));
                        f(bit, out.start + at as u32 % kind.output_width(output));
                    }
                    Flow::Whole => *meets = true,
                    Flow::Port => {
                        let CellKind::Memory(m) = kind else { continue };
                        let port = at as u32 / m.abits;
                        if m.reads[port as usize].clock.is_none() {
                            let out = bits.of_net(netlist.output(cell, output)).start + port * m.width;
                            (out..out + m.width).for_each(|out| f(bit, out));
                        }
                    }
                }
            }
            if (0..outputs).any(|output| kind.flow(pin, output) == Flow::Whole) {
                f(bit, together);
            }
        }
    }
    for (output, _) in meets.iter().enumerate().filter(|(_, meets)| **meets) {
        bits.of_net(netlist.output(cell, output)).for_each(|out| f(together, out));
    }
}
