//! In which order inputs that change at one time take effect, so that what is clocked sees what was there before.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::{CellId, Driver, NetId, Netlist, Slice};
use crate::cell::Role;

/// When, among the inputs that change at one time, one takes effect.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash)]
pub enum Turn {
    /// First: clocks.
    Clock,
    /// What is a clock to some cells, and what cells of another clock sample as data: with the data if a clock changes
    /// too, which has then made it; else first.
    Strobe,
    /// Then all others.
    Data,
}

impl Turn {
    /// Every turn.
    pub const ALL: [Turn; 3] = [Turn::Clock, Turn::Strobe, Turn::Data];
}

/// A bit of a net.
type Bit = (NetId, u32);

/// The turns of a netlist's inputs, bit by bit.
#[derive(Clone, Debug, Default)]
pub struct Turns {
    early: HashMap<Bit, Turn>,
}

impl Turns {
    /// The turn of a bit of an input's net.
    #[must_use]
    pub fn of(&self, net: NetId, bit: u32) -> Turn {
        self.early.get(&(net, bit)).copied().unwrap_or(Turn::Data)
    }
}

impl Netlist {
    /// When each input takes effect. A clock is what clocks a storage cell through buffers and inverters at most. Where
    /// a cell is clocked through other gates, those of their inputs are clocks that are so elsewhere; if none is, all of
    /// them.
    #[must_use]
    pub fn turns(&self) -> Turns {
        let (direct, through) = self.clock_inputs();
        let mut clocks: BTreeSet<Bit> = direct.clone();
        for inputs in &through {
            if inputs.is_disjoint(&direct) {
                clocks.extend(inputs);
            }
        }
        let several = clocks.len() > 1;
        let turn = |bit| if several && self.is_sampled_by_another(bit) { Turn::Strobe } else { Turn::Clock };
        Turns { early: clocks.into_iter().map(|bit| (bit, turn(bit))).collect() }
    }

    /// The same if these inputs, given by their nets, are the clocks, whatever they do, and no others.
    #[must_use]
    pub fn turns_with(&self, first: &[NetId]) -> Turns {
        let bits = first.iter().flat_map(|&net| (0..self.net(net).width).map(move |bit| (net, bit)));
        Turns { early: bits.map(|bit| (bit, Turn::Clock)).collect() }
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

    /// Whether an input reaches, through gates, what a cell samples at the edge of a clock that this input has no part
    /// in.
    fn is_sampled_by_another(&self, input: Bit) -> bool {
        let readers = self.readers_of_nets();
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
                let own = |clock: Bit| clock == input || self.inputs_behind(clock.0).contains(&input);
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
    use crate::cell::GateOp;
    use crate::netlist::{Builder, Bus};

    fn drive(netlist: &Netlist, name: &str) -> NetId {
        netlist.signal(netlist.find(name).unwrap()).drive.unwrap()
    }

    fn turns<const N: usize>(netlist: &Netlist, names: [&str; N]) -> [Turn; N] {
        let turns = netlist.turns();
        names.map(|name| turns.of(drive(netlist, name), 0))
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
        assert_eq!(turns(&netlist, ["clk", "d"]), [Turn::Clock, Turn::Data]);
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
        let of = |netlist: &Netlist| turns(netlist, ["clk", "en", "d"]);
        assert_eq!(of(&gated(true)), [Turn::Clock, Turn::Data, Turn::Data]);
        assert_eq!(of(&gated(false)), [Turn::Clock, Turn::Clock, Turn::Data]);
    }

    #[test]
    fn a_clock_that_another_samples_comes_after_it() {
        let mut b = Builder::new("top");
        let (clk, strobe, d) = (b.input("clk", 1), b.input("strobe", 1), b.input("d", 1));
        flop(&mut b, "counter", &strobe, &d);
        let mixed = b.gate("and1", GateOp::And, &[&strobe, &d]);
        flop(&mut b, "sampler", &clk, &mixed);
        let netlist = b.finish().unwrap();
        assert_eq!(turns(&netlist, ["clk", "strobe", "d"]), [Turn::Clock, Turn::Strobe, Turn::Data]);
        let named = netlist.turns_with(&[drive(&netlist, "strobe")]);
        assert_eq!(
            ["clk", "strobe", "d"].map(|name| named.of(drive(&netlist, name), 0)),
            [Turn::Data, Turn::Clock, Turn::Data]
        );
    }
}
