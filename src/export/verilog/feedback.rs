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
            let of_cell = |c: &Cell| {
                let drives = |p: &Piece| matches!(p, Piece::Wire { wire, .. } if *wire == w);
                (0..c.outputs.len())
                    .any(|pin| c.outputs[pin].iter().any(drives) && nets[netlist.output(c.id, pin).index()])
            };
            found[m][w] = match wire.signal {
                Some(signal) => names.contains(&(m, &netlist.signal(signal).name)),
                None => module.cells.iter().any(of_cell),
            };
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
            let whole = |&&c: &&u32| !module.cells[c as usize].outputs[0].iter().any(|p| matches!(p, Piece::Open(_)));
            match members.filter(whole).min() {
                Some(&first) => closing[first as usize] = true,
                None => return closing,
            }
        }
    }
}
