//! Wires that go round in circles without a clock, a vector taken as one: what tools for words warn of.

use super::super::graph::Graph;
use super::super::{Driver, NetId, Netlist, SignalId};
use crate::cell::CellKind;

/// For each net whether it, or a vector that shows some of it, is part of a circle.
pub fn circular(netlist: &Netlist) -> Vec<bool> {
    // nets that one signal shows are one
    let mut root: Vec<u32> = (0..netlist.nets().len() as u32).collect();
    let find = |root: &mut [u32], mut at: u32| {
        while root[at as usize] != at {
            root[at as usize] = root[root[at as usize] as usize];
            at = root[at as usize];
        }
        at
    };
    let constant = |net: NetId| match netlist.net(net).driver {
        Driver::Cell(cell, _) => matches!(netlist.cell(cell).kind, CellKind::Constant(_)),
        Driver::Input(_) => false,
    };
    for id in netlist.signal_ids() {
        let mut first = None;
        for slice in netlist.bits(id).iter().filter(|s| !constant(s.net)) {
            let at = find(&mut root, slice.net.0);
            match first {
                None => first = Some(at),
                Some(first) => {
                    let first = find(&mut root, first);
                    root[at as usize] = first;
                }
            }
        }
    }
    let root: Vec<u32> = (0..root.len() as u32).map(|net| find(&mut root, net)).collect();
    let graph = Graph::new(root.len(), |edge| {
        for cell in netlist.cell_ids() {
            let kind = &netlist.cell(cell).kind;
            let connected = |pin: usize| !netlist.input(cell, pin).is_empty();
            for pin in (0..kind.inputs().len()).filter(|&pin| kind.acts_at_once(pin, connected)) {
                for slice in netlist.input(cell, pin) {
                    for output in 0..kind.outputs().len() {
                        edge(root[slice.net.index()], root[netlist.output(cell, output).index()]);
                    }
                }
            }
        }
    });
    let sorted = graph.sorted();
    let mut round = vec![false; root.len()];
    for group in &sorted.groups {
        sorted.sequence[group.clone()].iter().for_each(|&net| round[net as usize] = true);
    }
    root.iter().map(|&net| round[net as usize]).collect()
}

/// Whether a signal shows any of some nets.
pub fn shows(netlist: &Netlist, signal: SignalId, nets: &[bool]) -> bool {
    netlist.bits(signal).iter().any(|s| nets[s.net.index()])
}
