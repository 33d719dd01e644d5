//! The value of a net that nothing keeps: computed when it is asked for, by the functions of the cell room, from inputs
//! and state.

use std::cell::{OnceCell, RefCell};

use super::wiring::Wiring;
use crate::cell::evaluate;
use crate::netlist::{CellId, Driver, NetId, Netlist};
use crate::value::Word;
use crate::value::word::{copy, words};

/// What has been asked for since anything changed.
#[derive(Debug)]
pub(super) struct Peeked {
    values: Vec<OnceCell<Box<[Word]>>>,
    filled: RefCell<Vec<NetId>>,
}

impl Peeked {
    pub fn new(nets: usize) -> Peeked {
        Peeked { values: vec![OnceCell::new(); nets], filled: RefCell::default() }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        for net in self.filled.get_mut().drain(..) {
            self.values[net.index()].take();
        }
    }

    /// The value of a net. `held` gives those that are kept.
    pub fn read<'a>(
        &'a self,
        netlist: &Netlist,
        held: &impl Fn(NetId) -> Option<&'a [Word]>,
        net: NetId,
    ) -> &'a [Word] {
        if let Some(value) = held(net) {
            return value;
        }
        // cells, each after those that it reads
        let mut stack = vec![(net, false)];
        while let Some((at, ready)) = stack.pop() {
            if held(at).is_some() || self.values[at.index()].get().is_some() {
                continue;
            }
            let Driver::Cell(cell, _) = netlist.net(at).driver else { unreachable!("inputs are kept") };
            if ready {
                self.evaluate(netlist, held, cell);
                continue;
            }
            stack.push((at, true));
            let kind = &netlist.cell(cell).kind;
            for pin in 0..kind.inputs().len() {
                for s in netlist.input(cell, pin).iter().filter(|s| !netlist.constants().covers(s)) {
                    // a storage cell is asked for what follows from its state, which does not depend on its clock
                    if kind.acts_at_once(pin, |p| !netlist.input(cell, p).is_empty()) {
                        stack.push((s.net, false));
                    }
                }
            }
        }
        self.values[net.index()].get().expect("it has been evaluated")
    }

    fn pins<'a>(
        &'a self,
        netlist: &Netlist,
        held: &impl Fn(NetId) -> Option<&'a [Word]>,
        cell: CellId,
    ) -> Vec<Vec<Word>> {
        let kind = &netlist.cell(cell).kind;
        (0..kind.inputs().len())
            .map(|pin| {
                let slices = netlist.input(cell, pin);
                let mut all = vec![Word::ZERO; words(kind.input_width(pin).max(1))];
                if slices.is_empty() {
                    all[0] = Word::known(u64::from(kind.inputs()[pin].default));
                }
                let mut at = 0;
                for s in slices {
                    let from = if netlist.constants().covers(s) {
                        Some(netlist.constants().net(s.net))
                    } else {
                        held(s.net).or_else(|| self.values[s.net.index()].get().map(AsRef::as_ref))
                    };
                    // what only a clock edge reads need not be there
                    if let Some(from) = from {
                        copy(&mut all, at, from, s.lo, s.width);
                    }
                    at += s.width;
                }
                all
            })
            .collect()
    }

    fn evaluate<'a>(&'a self, netlist: &Netlist, held: &impl Fn(NetId) -> Option<&'a [Word]>, cell: CellId) {
        for (pin, value) in self.present(netlist, held, cell).into_iter().enumerate() {
            let net = netlist.output(cell, pin);
            if held(net).is_none() && self.values[net.index()].set(value.into()).is_ok() {
                self.filled.borrow_mut().push(net);
            }
        }
    }

    /// The outputs of a cell, whose inputs are there.
    fn present<'a>(
        &'a self,
        netlist: &Netlist,
        held: &impl Fn(NetId) -> Option<&'a [Word]>,
        cell: CellId,
    ) -> Vec<Vec<Word>> {
        let kind = &netlist.cell(cell).kind;
        let ins = self.pins(netlist, held, cell);
        let ins: Vec<&[Word]> = ins.iter().map(Vec::as_slice).collect();
        let mut outs: Vec<Vec<Word>> = (0..kind.outputs().len())
            .map(|pin| match held(netlist.output(cell, pin)) {
                Some(value) => value.to_vec(),
                None => vec![Word::ZERO; words(kind.output_width(pin))],
            })
            .collect();
        let mut views: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
        evaluate(kind, &ins, &mut views);
        outs
    }

    /// Computes what some cells read that is no state.
    pub fn fill(&mut self, netlist: &Netlist, wiring: &Wiring, memory: &[Word], cells: &[CellId]) {
        let held = |net: NetId| leaf(netlist, wiring, memory, net);
        let mut found: Vec<(NetId, Box<[Word]>)> = Vec::new();
        {
            let scratch = Peeked::new(netlist.nets().len());
            for &cell in cells {
                for pin in 0..netlist.cell(cell).kind.inputs().len() {
                    for s in netlist.input(cell, pin).iter().filter(|s| !netlist.constants().covers(s)) {
                        if held(s.net).is_none() {
                            found.push((s.net, scratch.read(netlist, &held, s.net).into()));
                        }
                    }
                }
            }
        }
        for (net, value) in found {
            _ = self.values[net.index()].set(value);
        }
    }

    /// The outputs of a cell whose inputs are state or were filled in.
    pub fn outputs(&self, netlist: &Netlist, wiring: &Wiring, memory: &[Word], cell: CellId) -> Vec<Vec<Word>> {
        let held = |net: NetId| leaf(netlist, wiring, memory, net);
        let kind = &netlist.cell(cell).kind;
        let mut ins: Vec<Vec<Word>> = Vec::new();
        for pin in 0..kind.inputs().len() {
            let slices = netlist.input(cell, pin);
            let mut all = vec![Word::ZERO; words(kind.input_width(pin).max(1))];
            if slices.is_empty() {
                all[0] = Word::known(u64::from(kind.inputs()[pin].default));
            }
            let mut at = 0;
            for s in slices {
                let constant = netlist.constants().covers(s).then(|| netlist.constants().net(s.net));
                let from = constant.or_else(|| held(s.net));
                if let Some(from) = from.or_else(|| self.values[s.net.index()].get().map(AsRef::as_ref)) {
                    copy(&mut all, at, from, s.lo, s.width);
                }
                at += s.width;
            }
            ins.push(all);
        }
        let ins: Vec<&[Word]> = ins.iter().map(Vec::as_slice).collect();
        let mut outs: Vec<Vec<Word>> = (0..kind.outputs().len())
            .map(|pin| held(netlist.output(cell, pin)).expect("what loops have is kept").to_vec())
            .collect();
        let mut views: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
        evaluate(kind, &ins, &mut views);
        outs
    }
}

/// The value of a net that is state.
fn leaf<'m>(netlist: &Netlist, wiring: &Wiring, memory: &'m [Word], net: NetId) -> Option<&'m [Word]> {
    let slot = wiring.slot[net.index()].filter(|slot| wiring.leaves.contains(slot))? as usize;
    Some(&memory[slot..slot + words(netlist.net(net).width)])
}
