//! The start of a run. What nets become while the circuit first settles is no edge here (`docs/meaning.md`), while in Verilog
//! it is one of whoever waits for it by then. Where a clock may become active so, the blocks that it clocks hold until
//! `started` is 1: the output of the module `discreta_started`.

use crate::cell::{CellKind, Edge, Role};
use crate::netlist::hierarchy::Hierarchy;
use crate::netlist::{Driver, NetId, Netlist, Slice};
use crate::scenario::Scenario;
use crate::{Logic, Value};

/// Rounds of nonblocking assignments that one wave is given at most.
const MOST_ROUNDS: usize = 1000;

/// Rounds of nonblocking assignments that a wave may take.
pub(super) fn rounds(netlist: &Netlist) -> usize {
    (netlist.cells().iter().filter(|c| c.kind.init().is_some()).count() + 4).min(MOST_ROUNDS)
}

/// What an input has while the circuit first settles. Where nobody says, benches have their inputs begin with 0.
pub(super) fn first(scenario: Option<&Scenario>, net: NetId, lo: u32) -> Logic {
    let Some(scenario) = scenario else { return Logic::Zero };
    let given = |(_, value): &(NetId, Value)| value.bit(lo);
    let held = scenario.inputs.iter().find(|i| i.0 == net).map(given);
    let clock = scenario.clocks.iter().find(|c| c.net == net);
    let level = clock.map(|c| if c.clock.phase == 0 { Logic::One } else { Logic::Zero });
    held.or(level).unwrap_or(Logic::X)
}

/// For each module whether it has a block whose clock may make an edge while the circuit first settles.
pub(super) fn waiting(netlist: &Netlist, hierarchy: &Hierarchy, scenario: Option<&Scenario>) -> Vec<bool> {
    let mut waiting = vec![false; hierarchy.modules().len()];
    for id in netlist.cell_ids() {
        let active = netlist.clock_sources(id).any(|(source, inverted, edge)| {
            let edge = if inverted { edge.opposite() } else { edge };
            begins_with(netlist, source, edge, scenario)
        });
        if active {
            let mut scope = netlist.cell(id).scope;
            let module = loop {
                match (hierarchy.module_of(scope), netlist.scopes()[scope.index()].parent) {
                    (Some(module), _) => break module,
                    (None, Some(around)) => scope = around,
                    (None, None) => break 0,
                }
            };
            waiting[module] = true;
        }
    }
    waiting
}

/// Whether a bit may come to the level that an edge leads to while the circuit first settles.
fn begins_with(netlist: &Netlist, bit: Slice, edge: Edge, scenario: Option<&Scenario>) -> bool {
    let active = if edge == Edge::Rising { Logic::One } else { Logic::Zero };
    let Driver::Cell(cell, _) = netlist.net(bit.net).driver else {
        return first(scenario, bit.net, bit.lo) == active;
    };
    let kind = &netlist.cell(cell).kind;
    match kind {
        CellKind::Constant(_) => false,
        CellKind::Clock(clock) => (clock.phase == 0) == (edge == Edge::Rising),
        // what nothing changes but its own clock begins as it is initialised
        _ if kind.edge().is_some() && netlist.output(cell, 0) == bit.net => {
            let acts = |pin: usize| {
                let role = kind.inputs()[pin].role;
                let open = netlist.input(cell, pin).iter().all(|s| netlist.constants().is_zero(s));
                matches!(role, Role::Level | Role::Trigger) && !open
            };
            let init = kind.init().map_or(Logic::X, |init| init.bit(bit.lo));
            init == active || (0..kind.inputs().len()).any(acts)
        }
        _ => true,
    }
}
