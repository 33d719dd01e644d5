//! In which order inputs that change at one time take effect, so that what is clocked sees what was there before.

use std::collections::{BTreeSet, HashSet};

use super::graph::Graph;
use super::{CellId, Driver, NetId, Netlist, Slice};
use crate::cell::{CellKind, Role};

/// A scheduling region: when, among the inputs that change at one time, one takes effect.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash)]
pub enum Region {
    /// First: clocks.
    Clock,
    /// What is a clock to some cells, and what cells of another clock sample as data: with the data if a clock changes
    /// too, which has then made it; else first.
    Strobe,
    /// Then all others.
    Data,
}

impl Region {
    /// Every region, in the order in which they take effect.
    pub const ALL: [Region; 3] = [Region::Clock, Region::Strobe, Region::Data];
}

/// A bit of a net.
pub type Bit = (NetId, u32);

impl Netlist {
    /// The bits of inputs that are clocks: what clocks a storage cell through buffers and inverters at most. Where a cell
    /// is clocked through other gates, those of their inputs are clocks that are so elsewhere; if none is, all of them.
    #[must_use]
    pub fn clocks(&self) -> BTreeSet<Bit> {
        let (direct, through) = self.clock_inputs();
        let mut clocks: BTreeSet<Bit> = direct.clone();
        for inputs in &through {
            if inputs.is_disjoint(&direct) {
                clocks.extend(inputs);
            }
        }
        clocks
    }

    /// For each net that gates a latch the bits of inputs from which gates lead there.
    #[must_use]
    pub fn latch_gates(&self) -> Vec<BTreeSet<Bit>> {
        let mut found = Vec::new();
        let mut seen = HashSet::new();
        for cell in self.cell_ids() {
            let kind = &self.cell(cell).kind;
            let is_gate = |pin: &usize| matches!(kind, CellKind::Latch(_)) && kind.inputs()[*pin].name == "en";
            let gates = (0..kind.inputs().len()).filter(is_gate).flat_map(|pin| self.input(cell, pin));
            for bit in
                gates.flat_map(|s| (s.lo..s.lo + s.width).map(|bit| (s.net, bit))).filter(|bit| seen.insert(*bit))
            {
                found.push(match self.net(bit.0).driver {
                    Driver::Input(_) => BTreeSet::from([bit]),
                    Driver::Cell(..) => self.inputs_behind(bit.0),
                });
            }
        }
        found
    }

    /// The input bits that clock a cell through buffers and inverters at most, and, for each net behind other gates that
    /// clocks one, those that lead there.
    fn clock_inputs(&self) -> (BTreeSet<Bit>, Vec<BTreeSet<Bit>>) {
        let (mut direct, mut through) = (BTreeSet::new(), Vec::new());
        let mut seen = HashSet::new();
        for cell in self.cell_ids() {
            for bit in self.clock_bits(cell) {
                match self.net(bit.0).driver {
                    Driver::Input(_) => _ = direct.insert(bit),
                    Driver::Cell(from, _) if self.is_combinational(from) && seen.insert(bit.0) => {
                        through.push(self.inputs_behind(bit.0));
                    }
                    Driver::Cell(..) => {}
                }
            }
        }
        (direct, through)
    }

    /// The bits from which the clocks of a cell come, through buffers and inverters at most.
    fn clock_bits(&self, cell: CellId) -> impl Iterator<Item = Bit> + '_ {
        self.clock_sources(cell).map(|(source, _, _)| (source.net, source.lo))
    }

    /// Whether all that a cell does it does at once.
    fn is_combinational(&self, cell: CellId) -> bool {
        self.cell(cell).kind.inputs().iter().all(|pin| pin.role == Role::Data)
    }

    /// The inputs from which gates lead to a net.
    fn inputs_behind(&self, net: NetId) -> BTreeSet<Bit> {
        let mut found = BTreeSet::new();
        let mut seen = HashSet::from([net]);
        let mut open = vec![net];
        while let Some(net) = open.pop() {
            let Driver::Cell(cell, _) = self.net(net).driver else { continue };
            if !self.is_combinational(cell) {
                continue;
            }
            for pin in 0..self.cell(cell).kind.inputs().len() {
                for s in self.input(cell, pin) {
                    if let Driver::Input(_) = self.net(s.net).driver {
                        found.extend((s.lo..s.lo + s.width).map(|bit| (s.net, bit)));
                    } else if seen.insert(s.net) {
                        open.push(s.net);
                    }
                }
            }
        }
        found
    }

    /// Whether one of these input bits reaches, through gates, what a cell samples at the edge of a clock that none of
    /// them has a part in.
    #[must_use]
    pub fn sampled_by_another(&self, inputs: &BTreeSet<Bit>) -> bool {
        let readers = self.readers_of_nets();
        inputs.iter().any(|&input| self.is_sampled_by_another(input, inputs, &readers))
    }

    fn is_sampled_by_another(&self, input: Bit, own: &BTreeSet<Bit>, readers: &Graph) -> bool {
        let mut seen = HashSet::from([input.0]);
        let mut open = vec![input.0];
        while let Some(net) = open.pop() {
            for &cell in readers.after(net.0) {
                let cell = CellId(cell);
                let kind = &self.cell(cell).kind;
                let reads = |pin: usize| {
                    let here =
                        |s: &Slice| s.net == net && (net != input.0 || (s.lo..s.lo + s.width).contains(&input.1));
                    self.input(cell, pin).iter().any(here)
                };
                let pins = || kind.inputs().iter().enumerate().filter(|(pin, _)| reads(*pin));
                if self.is_combinational(cell) {
                    if pins().next().is_some() {
                        let outputs = (0..kind.outputs().len()).map(|pin| self.output(cell, pin));
                        open.extend(outputs.filter(|&net| seen.insert(net)));
                    }
                    continue;
                }
                let sampled = pins().any(|(_, pin)| !matches!(pin.role, Role::Clock | Role::Delayed));
                let own = |clock: Bit| own.contains(&clock) || !self.inputs_behind(clock.0).is_disjoint(own);
                let mut clocks = self.clock_bits(cell).peekable();
                if sampled && clocks.peek().is_some() && !clocks.any(own) {
                    return true;
                }
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::{Edge, Flop, GateOp};
    use crate::netlist::{Builder, Bus};

    fn drive(netlist: &Netlist, name: &str) -> NetId {
        netlist.signal(netlist.find(name).unwrap()).drive.unwrap()
    }

    fn are_clocks<const N: usize>(netlist: &Netlist, names: [&str; N]) -> [bool; N] {
        let clocks = netlist.clocks();
        names.map(|name| clocks.contains(&(drive(netlist, name), 0)))
    }

    fn flop(b: &mut Builder, name: &str, clk: &Bus, d: &Bus) {
        let q = b.output(&format!("{name}_q"), 1);
        b.dff(name, clk, d, &q);
    }

    #[test]
    fn clocks_come_first_inverted_or_not() {
        let mut b = Builder::new("top");
        let (clk, d) = (b.input("clk", 1), b.input("d", 1));
        let not_clk = b.not("not1", &clk);
        flop(&mut b, "ff", &not_clk, &d);
        let netlist = b.finish().unwrap();
        assert_eq!(are_clocks(&netlist, ["clk", "d"]), [true, false]);
    }

    #[test]
    fn an_enable_of_a_clock_is_data_if_the_clock_can_be_told() {
        let gated = |also_direct: bool| {
            let mut b = Builder::new("top");
            let (clk, en, d) = (b.input("clk", 1), b.input("en", 1), b.input("d", 1));
            let gated = b.gate("and1", GateOp::And, &[&clk, &en]);
            flop(&mut b, "ff", &gated, &d);
            if also_direct {
                flop(&mut b, "other", &clk, &d);
            }
            b.finish().unwrap()
        };
        let of = |netlist: &Netlist| are_clocks(netlist, ["clk", "en", "d"]);
        assert_eq!(of(&gated(true)), [true, false, false]);
        assert_eq!(of(&gated(false)), [true, true, false]);
    }

    #[test]
    fn a_clock_that_another_samples_comes_after_it() {
        let mut b = Builder::new("top");
        let (clk, strobe, d) = (b.input("clk", 1), b.input("strobe", 1), b.input("d", 1));
        flop(&mut b, "counter", &strobe, &d);
        let mixed = b.gate("and1", GateOp::And, &[&strobe, &d]);
        flop(&mut b, "sampler", &clk, &mixed);
        let netlist = b.finish().unwrap();
        assert_eq!(are_clocks(&netlist, ["clk", "strobe", "d"]), [true, true, false]);
        let sampled =
            |names: &[&str]| netlist.sampled_by_another(&names.iter().map(|name| (drive(&netlist, name), 0)).collect());
        assert!(sampled(&["strobe"]) && !sampled(&["clk"]));
        // not by another if they are one
        assert!(!sampled(&["clk", "strobe"]));
    }

    #[test]
    fn a_latch_has_a_gate() {
        let mut b = Builder::new("top");
        let (open, mask, d) = (b.input("open", 1), b.input("mask", 1), b.input("d", 1));
        let (gate, q) = (b.gate("and1", GateOp::And, &[&open, &mask]), b.output("q", 1));
        let one = crate::Value::from_u64(1, 1);
        let latch = Flop { edge: Edge::Rising, set_value: one.clone(), reset_value: one.clone(), init: one };
        let top = b.top();
        b.cell(top, "l", CellKind::Latch(Box::new(latch)), vec![gate, d, Bus::default(), Bus::default()], vec![q]);
        let netlist = b.finish().unwrap();
        let gates = ["open", "mask"].map(|name| (drive(&netlist, name), 0));
        assert_eq!(netlist.latch_gates(), [BTreeSet::from(gates)]);
        assert!(netlist.clocks().is_empty());
    }
}
