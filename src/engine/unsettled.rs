//! What an engine says of a circuit that never settles.

use crate::netlist::{Driver, NetId, Netlist};

/// A run that cannot go on: some nets never settle.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Unsettled {
    /// The tick in which the circuit kept changing.
    pub time: u64,
    /// The nets that keep changing and have a name or a reader, in the order of the loop if it is one of gates.
    pub nets: Vec<NetId>,
    /// Whether the loop goes through clock edges rather than through gates alone.
    pub clocked: bool,
}

impl Unsettled {
    /// The nets of the loop: going round it where it is one of gates, else in the order of their names.
    #[must_use]
    pub fn loop_nets(&self, netlist: &Netlist) -> Vec<NetId> {
        let cells: Vec<_> = self
            .nets
            .iter()
            .filter_map(|&net| match netlist.net(net).driver {
                Driver::Cell(cell, _) => Some(cell),
                Driver::Input(_) => None,
            })
            .collect();
        if let Some(circle) = netlist.circle(&cells).filter(|_| !self.clocked) {
            return circle.cells.into_iter().map(|cell| netlist.output(cell, 0)).collect();
        }
        let mut nets = self.nets.clone();
        nets.sort_by_cached_key(|&net| netlist.net_name(net));
        nets
    }

    /// The names of [`loop_nets`](Unsettled::loop_nets), as paths below the top module.
    #[must_use]
    pub fn names(&self, netlist: &Netlist) -> Vec<String> {
        self.loop_nets(netlist).into_iter().map(|net| netlist.net_name(net)).collect()
    }
}
