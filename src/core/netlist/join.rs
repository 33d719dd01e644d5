//! Which pin drives which bit: joins the bits that one output pin drives into one net, and resolves shared ones.

use std::collections::BTreeMap;

use super::bus::Bus;
use super::{CellId, Driver, Net, NetId, Slice};

/// No net.
pub(super) const NONE: u32 = u32::MAX;

/// The nets, each with the bit of it, that drive one bit.
pub(super) type Sharers = Vec<(NetId, u32)>;

/// Which net, and which bit of it, drives each bit.
pub(super) struct Join {
    net: Vec<u32>,
    offset: Vec<u32>,
    pub(super) nets: Vec<Net>,
    tristate: Vec<bool>,
    pub(super) first_outputs: Vec<NetId>,
    /// Bits with several tri-state drivers.
    shared: BTreeMap<u32, Sharers>,
    /// Bits with several drivers that cannot share.
    pub(super) conflicts: BTreeMap<u32, Sharers>,
    pub(super) cells: usize,
}

impl Join {
    pub(super) fn new(bits: u32) -> Join {
        Join {
            net: vec![NONE; bits as usize],
            offset: vec![0; bits as usize],
            nets: Vec::new(),
            tristate: Vec::new(),
            first_outputs: Vec::new(),
            shared: BTreeMap::new(),
            conflicts: BTreeMap::new(),
            cells: 0,
        }
    }

    pub(super) fn is_driven(&self, bit: u32) -> bool {
        self.net[bit as usize] != NONE
    }

    /// A new net that drives the bits of a bus.
    pub(super) fn drive(&mut self, bus: &Bus, width: u32, driver: Driver, tristate: bool) -> NetId {
        let net = NetId::new(self.nets.len());
        self.nets.push(Net { width, driver });
        self.tristate.push(tristate);
        for (offset, bit) in bus.bits().enumerate() {
            let (at, offset) = (bit as usize, offset as u32);
            if self.net[at] == NONE {
                self.net[at] = net.0;
                self.offset[at] = offset;
                continue;
            }
            let other = (NetId(self.net[at]), self.offset[at]);
            let list = if tristate && self.tristate[other.0.index()] { &mut self.shared } else { &mut self.conflicts };
            list.entry(bit).or_insert_with(|| vec![other]).push((net, offset));
        }
        net
    }

    /// Gives runs of shared bits a net of their own; returns, for each, its width and the drivers' nets and offsets.
    pub(super) fn resolve(&mut self) -> Vec<(u32, Sharers)> {
        let mut runs: Vec<(u32, u32, Sharers)> = Vec::new();
        for (bit, drivers) in std::mem::take(&mut self.shared) {
            if let Some((first, width, before)) = runs.last_mut() {
                let next = before.len() == drivers.len()
                    && before.iter().zip(&drivers).all(|(a, b)| a.0 == b.0 && a.1 + *width == b.1);
                if *first + *width == bit && next {
                    *width += 1;
                    continue;
                }
            }
            runs.push((bit, 1, drivers));
        }
        let first_cell = self.cells;
        for (i, (first, width, _)) in runs.iter().enumerate() {
            let net = NetId::new(self.nets.len());
            self.nets.push(Net { width: *width, driver: Driver::Cell(CellId::new(first_cell + i), 0) });
            for offset in 0..*width {
                self.net[(first + offset) as usize] = net.0;
                self.offset[(first + offset) as usize] = offset;
            }
        }
        runs.into_iter().map(|(_, width, drivers)| (width, drivers)).collect()
    }

    /// The bits of a bus as slices of nets.
    pub(super) fn slices(&self, bus: &Bus, out: &mut Vec<Slice>) {
        let start = out.len();
        for bit in bus.bits() {
            let (net, lo) = (NetId(self.net[bit as usize]), self.offset[bit as usize]);
            debug_assert_ne!(net.0, NONE, "every bit is driven or tied");
            match out[start..].last_mut() {
                Some(last) if last.net == net && last.lo + last.width == lo => last.width += 1,
                _ => out.push(Slice { net, lo, width: 1 }),
            }
        }
    }
}
