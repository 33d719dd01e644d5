//! Bits that never change, because constants decide them: a gate of an unused load, a tied carry.
//!
//! Knowing them keeps loops that cannot carry anything out of the evaluation order.

use super::{CellId, Netlist, Slice};
use crate::cell::{CellKind, evaluate};
use crate::value::Word;
use crate::value::word::{copy, mask, word_mask, words};

/// For each net the bits that are constant, the others x.
#[derive(Clone, Debug)]
pub struct Constants {
    start: Vec<u32>,
    words: Vec<Word>,
}

impl Constants {
    /// Propagates constants through the combinational cells of a netlist. What is known of an output while all that is
    /// not constant is x stays so whatever the inputs become.
    fn new(netlist: &Netlist) -> Constants {
        let mut start = vec![0u32];
        let mut all = Vec::new();
        for net in netlist.nets() {
            all.extend((0..words(net.width)).map(|i| Word::x(word_mask(net.width, i))));
            start.push(all.len() as u32);
        }
        let mut constants = Constants { start, words: all };
        // cells to look at: at first the constants, then whatever reads a bit that has become constant
        let mut work: Vec<CellId> =
            netlist.cell_ids().filter(|&c| matches!(netlist.cell(c).kind, CellKind::Constant(_))).collect();
        let readers = netlist.readers_of_nets();
        let mut buffer = (Vec::new(), Vec::new());
        while let Some(cell) = work.pop() {
            for net in constants.visit(netlist, cell, &mut buffer) {
                let kind = |c: CellId| &netlist.cell(c).kind;
                work.extend(readers.after(net.0).iter().map(|&c| CellId(c)).filter(|&c| kind(c).is_pure()));
            }
        }
        constants
    }

    /// The constant bits of a net, the others x.
    #[must_use]
    pub fn net(&self, net: super::NetId) -> &[Word] {
        &self.words[self.start[net.index()] as usize..self.start[net.index() + 1] as usize]
    }

    /// Whether every bit of a slice is constant.
    #[must_use]
    pub fn covers(&self, slice: &Slice) -> bool {
        let net = self.net(slice.net);
        (slice.lo / 64..=(slice.lo + slice.width - 1) / 64).all(|i| {
            let low = slice.lo.max(i * 64) - i * 64;
            let high = (slice.lo + slice.width).min((i + 1) * 64) - i * 64;
            net[i as usize].u & mask(high) & !mask(low) == 0
        })
    }

    /// Whether every bit of a slice is constant 0.
    #[must_use]
    pub fn is_zero(&self, slice: &Slice) -> bool {
        let net = self.net(slice.net);
        let bit = |i: u32| Word { v: net[i as usize / 64].v >> (i % 64), u: net[i as usize / 64].u >> (i % 64) };
        (slice.lo..slice.lo + slice.width).all(|i| bit(i).is_zero())
    }

    /// Evaluates a cell; returns the nets of which more bits have become constant.
    fn visit(
        &mut self,
        netlist: &Netlist,
        cell: CellId,
        (ins, outs): &mut (Vec<Vec<Word>>, Vec<Vec<Word>>),
    ) -> Vec<super::NetId> {
        let kind = &netlist.cell(cell).kind;
        let pins = kind.inputs();
        ins.resize_with(ins.len().max(pins.len()), Vec::new);
        for (pin, spec) in pins.iter().enumerate() {
            let width = kind.input_width(pin);
            ins[pin].clear();
            ins[pin].resize(words(width), Word::ZERO);
            let slices = netlist.input(cell, pin);
            if slices.is_empty() {
                ins[pin][0] = Word::known(u64::from(spec.default));
            }
            let mut at = 0;
            for s in slices {
                copy(&mut ins[pin], at, self.net(s.net), s.lo, s.width);
                at += s.width;
            }
        }
        let count = kind.outputs().len();
        outs.resize_with(outs.len().max(count), Vec::new);
        for (pin, out) in outs.iter_mut().enumerate().take(count) {
            out.clear();
            out.extend_from_slice(self.net(netlist.output(cell, pin)));
        }
        let ins: Vec<&[Word]> = ins[..pins.len()].iter().map(Vec::as_slice).collect();
        let mut views: Vec<&mut [Word]> = outs[..count].iter_mut().map(Vec::as_mut_slice).collect();
        evaluate(kind, &ins, &mut views);
        let mut changed = Vec::new();
        for (pin, out) in outs[..count].iter().enumerate() {
            let net = netlist.output(cell, pin);
            let held = &mut self.words[self.start[net.index()] as usize..self.start[net.index() + 1] as usize];
            // a literal x or z is no knowledge of what a reader makes of it
            let known = held.iter().zip(out).any(|(old, new)| old.u & !new.u != 0);
            if known {
                for (held, new) in held.iter_mut().zip(out) {
                    *held = Word { v: new.v & !new.u, u: new.u };
                }
                changed.push(net);
            }
        }
        changed
    }
}

impl Netlist {
    /// The bits that never change; found once, when they are first asked for.
    #[must_use]
    pub fn constants(&self) -> &Constants {
        self.content.constants.get_or_init(|| Constants::new(self))
    }
}

#[cfg(test)]
mod tests {
    use crate::Value;
    use crate::cell::GateOp;
    use crate::netlist::{Builder, Bus};

    #[test]
    fn a_constant_decides_a_gate_and_opens_a_loop() {
        let mut b = Builder::new("top");
        let (a, off) = (b.input("a", 4), b.constant(&Value::from_u64(0b0101, 4)));
        let masked = b.gate("and1", GateOp::And, &[&a, &off]);
        let y = b.output("y", 4);
        let top = b.top();
        // y = (y & 0) | masked would be a loop but for the constant
        let zero = b.constant(&Value::from_u64(0, 4));
        let back = b.gate("and2", GateOp::And, &[&y, &zero]);
        let or = crate::cell::CellKind::Gate { op: GateOp::Or, width: 4, inputs: 2 };
        b.cell(top, "or1", or, vec![Bus::concat([&back, &masked])], vec![y]);
        let netlist = b.finish().unwrap();
        let constants = netlist.constants();
        let net = |name: &str| netlist.bits(netlist.find(name).unwrap())[0];
        let bits = |n: super::super::NetId| Value::from_words(constants.net(n), 4).bit_string();
        assert_eq!(bits(net("y").net), "0x0x");
        assert!(!constants.covers(&net("y")));
        assert!(netlist.order().groups.is_empty());
    }
}
