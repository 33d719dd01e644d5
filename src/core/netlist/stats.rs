//! What a netlist is made of, counted: equipment, elements, modules, nets, clocks, logic depth.
//!
//! What a cell counts as stands beside the cells ([`equipment`](crate::cell::equipment)). Here they are summed up.

use std::collections::BTreeMap;

use serde::Serialize;

use super::bits::{BitNames, Bits};
use super::{CellId, Depth, Direction, Netlist, ScopeId};
use crate::cell::{CellKind, Edge, Equipment, Parts};

/// The counts of a netlist. Constants are counted nowhere, and neither is what joins the drivers of a bus.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Stats {
    /// The name of the top module.
    pub module: String,
    /// Inputs of the circuit and their bits.
    pub inputs: Parts,
    /// Outputs of the circuit, and what is both input and output.
    pub outputs: Parts,
    /// What all cells are made of.
    pub equipment: Equipment,
    /// Gates whose output never changes, because constants decide it. They are among the gates of `equipment` too.
    pub constant_gates: u64,
    /// Cells, by element, in the order of their names.
    pub elements: Vec<Elements>,
    /// Instances of each module, by name, without the top.
    pub modules: Vec<Instances>,
    /// Nets: what one pin drives and something reads or names.
    pub nets: Parts,
    /// The bit that most inputs of cells read, of several the first by name.
    pub fan_out: Option<FanOut>,
    /// What clocks flip-flops and memories, by name.
    pub clocks: Vec<ClockDomain>,
    /// The longest path through the logic.
    pub depth: Depth,
}

/// Cells of one element, width and fan-in.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
pub struct Elements {
    /// The element, as the circuit file names it.
    pub element: &'static str,
    /// Bits of its first output.
    pub width: u32,
    /// Inputs, for an element that takes any number of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inputs: Option<u32>,
    /// How many cells there are of this element, width and fan-in.
    pub number: u64,
}

/// Instances of a module.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Instances {
    /// The name of the module.
    pub module: String,
    /// How many instances the whole circuit has, at any depth.
    pub number: u64,
}

/// A bit and how many inputs read it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct FanOut {
    /// The bit, as `net` or `net[i]`.
    pub net: String,
    /// Bits of input pins of cells that are connected to it.
    pub inputs: u64,
}

/// Flip-flops and memories with a common clock.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct ClockDomain {
    /// The bit from which the clock comes, through buffers and inverters at most.
    pub net: String,
    /// The edge of that bit at which they sample.
    pub edge: Edge,
    /// How many bits of flip-flops it clocks; memories do not count.
    pub flip_flops: u64,
}

/// What stands in a scope and the scopes within it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct ScopeStats {
    /// The path below the top; empty for the top itself.
    pub scope: String,
    /// How many scopes are around it.
    pub level: u32,
    /// The module that it is an instance of; none for a block.
    pub module: Option<String>,
    /// Cells.
    pub cells: u64,
    /// What they are made of.
    pub equipment: Equipment,
}

impl Stats {
    /// Counts a netlist.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// use discreta::netlist::{Builder, Stats};
    /// let mut b = Builder::new("top");
    /// let (clk, a, sum) = (b.input("clk", 1), b.input("a", 4), b.output("sum", 4));
    /// let (next, _carry) = b.adder("add", &a, &sum);
    /// b.dff("sum", &clk, &next, &sum);
    /// let stats = Stats::of(&b.finish().unwrap());
    /// assert_eq!((stats.equipment.flip_flops, stats.equipment.adders.number, stats.equipment.adders.bits), (4, 1, 4));
    /// ```
    #[must_use]
    pub fn of(netlist: &Netlist) -> Stats {
        let bits = Bits::new(netlist);
        let names = BitNames::new(netlist, &bits);
        let ports = |is: fn(Direction) -> bool| {
            let mut all = Parts::default();
            for signal in netlist.ports().map(|id| netlist.signal(id)).filter(|s| s.port.is_some_and(is)) {
                all += Parts { number: 1, bits: signal.width.into() };
            }
            all
        };
        let (nets, fan_out) = nets(netlist, &bits, &names);
        Stats {
            module: netlist.scopes().first().map_or_else(String::new, |top| top.name.clone()),
            inputs: ports(|d| d == Direction::Input),
            outputs: ports(|d| d != Direction::Input),
            equipment: netlist.cells().iter().map(|c| c.kind.equipment()).sum(),
            constant_gates: netlist.cell_ids().map(|c| constant_gates(netlist, &bits, c)).sum(),
            elements: elements(netlist),
            modules: modules(netlist),
            nets,
            fan_out,
            clocks: clocks(netlist, &bits, &names),
            depth: Depth::with(&bits, &names, netlist),
        }
    }

    /// How many cells there are.
    #[must_use]
    pub fn cells(&self) -> u64 {
        self.elements.iter().map(|e| e.number).sum()
    }
}

fn counts(kind: &CellKind) -> bool {
    !matches!(kind, CellKind::Constant(_) | CellKind::Resolve { .. })
}

/// Each bit of a cell that is a gate and never changes is one.
fn constant_gates(netlist: &Netlist, bits: &Bits, cell: CellId) -> u64 {
    let made = netlist.cell(cell).kind.equipment();
    if made.gates == 0 {
        return 0;
    }
    bits.of_net(netlist.output(cell, 0)).filter(|&bit| bits.is_constant(bit)).count() as u64
}

fn elements(netlist: &Netlist) -> Vec<Elements> {
    let mut found: BTreeMap<(&'static str, u32, Option<u32>), u64> = BTreeMap::new();
    for cell in netlist.cells().iter().filter(|c| counts(&c.kind)) {
        *found.entry((cell.element, cell.kind.output_width(0), cell.kind.fan_in())).or_default() += 1;
    }
    found.into_iter().map(|((element, width, inputs), number)| Elements { element, width, inputs, number }).collect()
}

fn modules(netlist: &Netlist) -> Vec<Instances> {
    let mut found: BTreeMap<&str, u64> = BTreeMap::new();
    for module in netlist.scopes().iter().skip(1).filter_map(|s| s.module.as_deref()) {
        *found.entry(module).or_default() += 1;
    }
    found.into_iter().map(|(module, number)| Instances { module: module.to_owned(), number }).collect()
}

fn nets(netlist: &Netlist, bits: &Bits, names: &BitNames<'_>) -> (Parts, Option<FanOut>) {
    let mut read = vec![0u64; bits.len() as usize];
    for cell in netlist.cell_ids() {
        for pin in 0..netlist.cell(cell).kind.inputs().len() {
            bits.input(netlist, cell, pin).for_each(|bit| read[bit as usize] += 1);
        }
    }
    let mut nets = Parts::default();
    for (id, net) in netlist.net_ids().zip(netlist.nets()) {
        let known = bits.of_net(id).any(|bit| read[bit as usize] > 0 || names.is_shown(bit));
        if known && !netlist.is_tied(id) {
            nets += Parts { number: 1, bits: net.width.into() };
        }
    }
    let changing = || (0..bits.len()).filter(|&bit| !bits.is_constant(bit) && read[bit as usize] > 0);
    let most = changing().map(|bit| read[bit as usize]).max();
    let first = changing().filter(|&bit| Some(read[bit as usize]) == most).map(|bit| names.of(bit)).min();
    (nets, first.zip(most).map(|(net, inputs)| FanOut { net, inputs }))
}

fn clocks(netlist: &Netlist, bits: &Bits, names: &BitNames<'_>) -> Vec<ClockDomain> {
    let mut found: BTreeMap<(u32, Edge), u64> = BTreeMap::new();
    for cell in netlist.cell_ids() {
        let kind = &netlist.cell(cell).kind;
        for (source, inverted, edge) in netlist.clock_sources(cell) {
            let edge = if inverted { edge.opposite() } else { edge };
            *found.entry((bits.of(&source).start, edge)).or_default() += kind.equipment().flip_flops;
        }
    }
    let domain = |((bit, edge), flip_flops)| ClockDomain { net: names.of(bit), edge, flip_flops };
    let mut domains: Vec<ClockDomain> = found.into_iter().map(domain).collect();
    domains.sort_by(|a, b| (&a.net, a.edge).cmp(&(&b.net, b.edge)));
    domains
}

impl Netlist {
    /// The counts of each scope, down to so many levels below the top, each with what stands in the scopes within it and
    /// followed by those.
    #[must_use]
    pub fn scope_stats(&self, levels: u32) -> Vec<ScopeStats> {
        // a parent comes before its children
        let mut rows: Vec<ScopeStats> = Vec::new();
        let mut row: Vec<usize> = Vec::with_capacity(self.scopes().len());
        let mut parents: Vec<Option<usize>> = Vec::new();
        for (i, scope) in self.scopes().iter().enumerate() {
            let parent = scope.parent.map(|p| row[p.index()]);
            let level = parent.map_or(0, |p| rows[p].level + 1);
            // what is deeper counts for the row around it
            let own = match parent {
                Some(p) if rows[p].level == levels => p,
                _ => {
                    rows.push(ScopeStats {
                        scope: self.scope_path(ScopeId::new(i)),
                        level,
                        module: scope.module.clone(),
                        cells: 0,
                        equipment: Equipment::default(),
                    });
                    parents.push(parent);
                    rows.len() - 1
                }
            };
            row.push(own);
        }
        for cell in self.cells().iter().filter(|c| counts(&c.kind)) {
            let row = &mut rows[row[cell.scope.index()]];
            row.cells += 1;
            row.equipment += cell.kind.equipment();
        }
        let mut inner: Vec<Vec<usize>> = vec![Vec::new(); rows.len()];
        for i in (1..rows.len()).rev() {
            if let Some(parent) = parents[i] {
                let (cells, equipment) = (rows[i].cells, rows[i].equipment);
                rows[parent].cells += cells;
                rows[parent].equipment += equipment;
                inner[parent].push(i);
            }
        }
        let mut sorted = Vec::with_capacity(rows.len());
        let mut next: Vec<usize> = (0..rows.len().min(1)).collect();
        while let Some(i) = next.pop() {
            sorted.push(rows[i].clone());
            next.append(&mut inner[i]); // the last comes first out
        }
        sorted
    }
}
