//! Single bits of nets: a dense number and a name for each.

use super::{CellId, NetId, Netlist, SignalId, Slice};

/// Numbers the bits of all nets.
pub(super) struct Bits {
    /// The number of each net's bit 0, and after the last how many there are.
    start: Vec<u32>,
    constant: Vec<bool>,
}

impl Bits {
    pub(super) fn new(netlist: &Netlist) -> Bits {
        let constants = netlist.constants();
        let mut start = vec![0u32];
        let mut constant = Vec::new();
        for (i, net) in netlist.nets().iter().enumerate() {
            let end = start[i].checked_add(net.width);
            start.push(end.expect("a netlist has fewer than 2^32 bits: the limits are far below"));
            let tied = netlist.is_tied(NetId::new(i));
            let bit = |lo| Slice { net: NetId::new(i), lo, width: 1 };
            constant.extend((0..net.width).map(|lo| tied || constants.covers(&bit(lo))));
        }
        Bits { start, constant }
    }

    /// How many there are.
    pub(super) fn len(&self) -> u32 {
        self.start[self.start.len() - 1]
    }

    /// The numbers of a slice's bits.
    pub(super) fn of(&self, slice: &Slice) -> std::ops::Range<u32> {
        let first = self.start[slice.net.index()] + slice.lo;
        first..first + slice.width
    }

    /// The numbers of a net's bits.
    pub(super) fn of_net(&self, net: NetId) -> std::ops::Range<u32> {
        self.start[net.index()]..self.start[net.index() + 1]
    }

    /// A bit as a slice.
    pub(super) fn slice(&self, bit: u32) -> Slice {
        let net = NetId::new(self.start.partition_point(|&s| s <= bit) - 1);
        Slice { net, lo: bit - self.start[net.index()], width: 1 }
    }

    /// The numbers of what an input pin is connected to, the least significant first.
    pub(super) fn input<'a>(
        &'a self,
        netlist: &'a Netlist,
        cell: CellId,
        pin: usize,
    ) -> impl Iterator<Item = u32> + use<'a> {
        netlist.input(cell, pin).iter().flat_map(|s| self.of(s))
    }

    /// Whether a bit never changes: a constant, or what constants decide, or what nothing drives.
    pub(super) fn is_constant(&self, bit: u32) -> bool {
        self.constant[bit as usize]
    }
}

/// A name for each bit: that of the signal that shows it, of several the one nearest to the top and then the first by
/// name, as [`Netlist::net_name`] has it.
pub(super) struct BitNames<'n> {
    netlist: &'n Netlist,
    bits: &'n Bits,
    shown: Vec<Option<(SignalId, u32)>>,
}

impl<'n> BitNames<'n> {
    pub(super) fn new(netlist: &'n Netlist, bits: &'n Bits) -> BitNames<'n> {
        let mut signals: Vec<SignalId> = netlist.signal_ids().collect();
        signals.sort_by_cached_key(|&id| {
            let signal = netlist.signal(id);
            (signal.hidden, netlist.depth(signal.scope), netlist.signal_path(id))
        });
        let mut shown = vec![None; bits.len() as usize];
        for id in signals {
            for (at, bit) in netlist.bits(id).iter().flat_map(|s| bits.of(s)).enumerate() {
                shown[bit as usize].get_or_insert((id, at as u32));
            }
        }
        BitNames { netlist, bits, shown }
    }

    /// Whether any signal shows a bit.
    pub(super) fn is_shown(&self, bit: u32) -> bool {
        self.shown[bit as usize].is_some()
    }

    /// The name of a bit: `dt`, `f[3]`; of one that no signal shows, the pin that drives it.
    pub(super) fn of(&self, bit: u32) -> String {
        let indexed = |name: String, width: u32, at: u32| if width == 1 { name } else { format!("{name}[{at}]") };
        if let Some((id, at)) = self.shown[bit as usize] {
            return indexed(self.netlist.signal_path(id), self.netlist.signal(id).width, at);
        }
        let Slice { net, lo, .. } = self.bits.slice(bit);
        let net = self.netlist.net(net);
        indexed(self.netlist.driver_name(net.driver), net.width, lo)
    }
}
