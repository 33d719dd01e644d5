//! Feedback: what Verilator is told of, so that it knows that it is meant.

use std::collections::{BTreeSet, HashMap};

use crate::cell::CellKind;
use crate::netlist::Netlist;
use crate::netlist::graph::Graph;
use crate::netlist::hierarchy::circles::{circular, shows};
use crate::netlist::hierarchy::{Cell, Hierarchy, Module, Piece};

/// Which wires of each module are part of a circle in any instance.
pub(super) fn wires(netlist: &Netlist, hierarchy: &Hierarchy) -> Vec<Vec<bool>> {
    let nets = circular(netlist);
    let mut found: Vec<Vec<bool>> = hierarchy.modules().iter().map(|m| vec![false; m.wires.len()]).collect();
    if !nets.contains(&true) {
        return found;
    }
    // by name, for every instance
    let mut names: BTreeSet<(usize, &str)> = BTreeSet::new();
    for id in netlist.signal_ids().filter(|&id| shows(netlist, id, &nets)) {
        let signal = netlist.signal(id);
        let mut scope = signal.scope;
        let module = loop {
            match (hierarchy.module_of(scope), netlist.scopes()[scope.index()].parent) {
                (Some(module), _) => break module,
                (None, Some(parent)) => scope = parent,
                (None, None) => break 0,
            }
        };
        names.insert((module, &signal.name));
    }
    for (m, module) in hierarchy.modules().iter().enumerate() {
        for (w, wire) in module.wires.iter().enumerate() {
            found[m][w] = wire.signal.is_some_and(|signal| names.contains(&(m, &netlist.signal(signal).name)));
        }
        let outputs = |c: &Cell| (0..c.outputs.len()).filter(|&pin| nets[netlist.output(c.id, pin).index()]).collect();
        for cell in &module.cells {
            let round: Vec<usize> = outputs(cell);
            for piece in round.into_iter().flat_map(|pin| &cell.outputs[pin]) {
                if let Piece::Wire { wire, .. } = piece {
                    found[m][*wire] |= module.wires[*wire].signal.is_none();
                }
            }
        }
    }
    found
}

/// The cells whose outputs close circles within a module, by their place.
pub(super) fn closing(netlist: &Netlist, module: &Module) -> Vec<bool> {
    let mut closing = vec![false; module.cells.len()];
    let mut driver: HashMap<(usize, u32), u32> = HashMap::new();
    let bits = |pieces: &[Piece]| -> Vec<(usize, u32)> {
        let one = |p: &Piece| match *p {
            Piece::Wire { wire, lo, width } => (lo..lo + width).map(|b| (wire, b)).collect::<Vec<_>>(),
            _ => vec![],
        };
        pieces.iter().flat_map(one).collect()
    };
    let plain = |c: &Cell| {
        matches!(
            netlist.cell(c.id).kind,
            CellKind::Gate { .. } | CellKind::AndOr { .. } | CellKind::Majority { .. } | CellKind::Mux { .. }
        )
    };
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| plain(c)) {
        for bit in bits(&cell.outputs[0]) {
            driver.insert(bit, c as u32);
        }
    }
    // another name for a bit is that bit already, so cells and wires are all there is
    for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| plain(c)) {
        let from: BTreeSet<u32> =
            cell.inputs.iter().flat_map(|p| bits(p)).filter_map(|b| driver.get(&b).copied()).collect();
        edges.extend(from.into_iter().map(|f| (f, c as u32)));
    }
    let whole = |c: u32| !module.cells[c as usize].outputs[0].iter().any(|p| matches!(p, Piece::Open(_)));
    back_edges(module.cells.len(), &edges, |c| closing[c as usize] |= whole(c));
    // what is left goes round through cells that cannot close it alone
    loop {
        let open = edges.iter().filter(|e| !closing[e.0 as usize]);
        let open: Vec<(u32, u32)> = open.copied().collect();
        let graph = Graph::new(module.cells.len(), |f| open.iter().for_each(|&(a, b)| f(a, b)));
        let sorted = graph.sorted();
        if sorted.groups.is_empty() {
            return closing;
        }
        for group in &sorted.groups {
            let members = sorted.sequence[group.clone()].iter();
            match members.filter(|&&c| whole(c)).min() {
                Some(&first) => closing[first as usize] = true,
                None => return closing,
            }
        }
    }
}

/// Finds a node on every circle: where a walk against the edges, each node's least neighbours first, comes back to a node
/// that it is still at.
fn back_edges(nodes: usize, edges: &[(u32, u32)], mut found: impl FnMut(u32)) {
    let against = Graph::new(nodes, |f| edges.iter().for_each(|&(from, to)| f(to, from)));
    #[derive(Clone, Copy, PartialEq)]
    enum Seen {
        No,
        Still,
        Done,
    }
    let mut seen = vec![Seen::No; nodes];
    let mut way: Vec<(u32, usize)> = Vec::new();
    for root in 0..nodes as u32 {
        if seen[root as usize] != Seen::No {
            continue;
        }
        seen[root as usize] = Seen::Still;
        way.push((root, 0));
        while let Some((node, next)) = way.last_mut() {
            let Some(&to) = against.after(*node).get(*next) else {
                seen[*node as usize] = Seen::Done;
                way.pop();
                continue;
            };
            *next += 1;
            match seen[to as usize] {
                Seen::No => {
                    seen[to as usize] = Seen::Still;
                    way.push((to, 0));
                }
                Seen::Still => found(to),
                Seen::Done => {}
            }
        }
    }
}
