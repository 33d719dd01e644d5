//! On-demand evaluation: the value of a net that memory does not hold, computed from inputs and state when somebody asks.

use std::cell::{OnceCell, RefCell};

use crate::cell::pin::memory::{RD_ADDR, RD_ARST};
use crate::cell::{CellKind, Memory, evaluate};
use crate::compiled::lower::layout::StateLayout;
use crate::compiled::lower::part;
use crate::netlist::{CellId, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{copy, words};

/// What is kept: inputs and state, what memories hold, and further nets.
pub(crate) struct StateView<'a> {
    pub netlist: &'a Netlist,
    pub layout: &'a StateLayout,
    pub memory: &'a [Word],
    pub keeps: Keeps<'a>,
}

/// Which of the nets that have a place are kept there beside inputs and state.
#[derive(Clone, Copy)]
pub(crate) enum Keeps<'a> {
    Nothing,
    All,
    These(&'a [bool]),
}

impl<'a> StateView<'a> {
    /// Inputs and state alone.
    pub fn state(netlist: &'a Netlist, layout: &'a StateLayout, memory: &'a [Word]) -> StateView<'a> {
        StateView { netlist, layout, memory, keeps: Keeps::Nothing }
    }

    pub fn net(&self, net: NetId) -> Option<&'a [Word]> {
        let slot = self.layout.slot[net.index()]?;
        let keeps = match self.keeps {
            Keeps::Nothing => false,
            Keeps::All => true,
            Keeps::These(list) => list[net.index()],
        };
        if !keeps && !self.layout.leaves.contains(slot) {
            return None;
        }
        Some(&self.memory[slot.index()..][..words(self.netlist.net(net).width)])
    }

    /// The cell that drives a net, which is no input.
    fn driver(&self, net: NetId) -> CellId {
        let Driver::Cell(cell, _) = self.netlist.net(net).driver else { unreachable!("inputs are kept") };
        cell
    }

    /// The memory that drives a net.
    fn memory(&self, net: NetId) -> Option<(CellId, &'a Memory)> {
        let Driver::Cell(cell, _) = self.netlist.net(net).driver else { return None };
        let CellKind::Memory(memory) = &self.netlist.cell(cell).kind else { return None };
        Some((cell, memory))
    }
}

/// What is computed.
#[derive(Clone, Copy, Debug)]
enum Want {
    Net(NetId),
    /// What a read port of a memory gives.
    Port(CellId, u32),
}

/// What has been asked for since anything changed.
#[derive(Debug)]
pub(crate) struct OnDemand {
    /// Of nets, and then of the read ports of memories.
    values: Vec<OnceCell<Box<[Word]>>>,
    nets: usize,
    filled: RefCell<Vec<usize>>,
}

impl OnDemand {
    pub fn new(netlist: &Netlist, layout: &StateLayout) -> OnDemand {
        let nets = netlist.nets().len();
        let ports: usize = layout.memories.iter().map(|m| m.ports.len()).sum();
        OnDemand { values: vec![OnceCell::new(); nets + ports], nets, filled: RefCell::default() }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        for number in self.filled.get_mut().drain(..) {
            self.values[number].take();
        }
    }

    fn number(&self, h: &StateView<'_>, want: Want) -> usize {
        match want {
            Want::Net(net) => net.index(),
            Want::Port(cell, port) => {
                let place = &h.layout.memories[h.layout.memory_of[&cell]];
                self.nets + (place.first_port + port) as usize
            }
        }
    }

    fn value(&self, h: &StateView<'_>, want: Want) -> Option<&[Word]> {
        self.values[self.number(h, want)].get().map(AsRef::as_ref)
    }

    fn keep(&self, h: &StateView<'_>, want: Want, value: Vec<Word>) {
        let number = self.number(h, want);
        if self.values[number].set(value.into()).is_ok() {
            self.filled.borrow_mut().push(number);
        }
    }

    /// The value of a net.
    pub fn read<'a>(&'a self, h: &StateView<'a>, net: NetId) -> &'a [Word] {
        if let Some(value) = h.net(net) {
            return value;
        }
        // cells, each after those that it reads
        let mut stack = vec![(Want::Net(net), false)];
        while let Some((want, ready)) = stack.pop() {
            if matches!(want, Want::Net(net) if h.net(net).is_some()) || self.value(h, want).is_some() {
                continue;
            }
            if ready {
                self.evaluate(h, want);
                continue;
            }
            stack.push((want, true));
            self.needs(h, want, &mut |w| stack.push((w, false)));
        }
        self.value(h, Want::Net(net)).expect("it has been evaluated")
    }

    /// What something is computed from.
    fn needs(&self, h: &StateView<'_>, want: Want, push: &mut dyn FnMut(Want)) {
        let mut slices = |slices: &[Slice]| {
            for s in slices.iter().filter(|s| !h.netlist.constants().covers(s) && h.net(s.net).is_none()) {
                match h.memory(s.net) {
                    Some((cell, m)) => {
                        (s.lo / m.width..=(s.lo + s.width - 1) / m.width).for_each(|port| push(Want::Port(cell, port)));
                    }
                    None => push(Want::Net(s.net)),
                }
            }
        };
        let net = match want {
            Want::Net(net) => net,
            Want::Port(cell, port) => {
                let CellKind::Memory(m) = &h.netlist.cell(cell).kind else { unreachable!("only memories have ports") };
                slices(&part(h.netlist.input(cell, RD_ARST), port, 1));
                if m.reads[port as usize].clock.is_none() {
                    slices(&part(h.netlist.input(cell, RD_ADDR), port * m.abits, m.abits));
                }
                return;
            }
        };
        if let Some((cell, m)) = h.memory(net) {
            return (0..m.reads.len() as u32).for_each(|port| push(Want::Port(cell, port)));
        }
        let cell = h.driver(net);
        let kind = &h.netlist.cell(cell).kind;
        for pin in 0..kind.inputs().len() {
            // a storage cell is asked for what follows from its state, which does not depend on its clock
            if kind.acts_at_once(pin, |p| !h.netlist.input(cell, p).is_empty()) {
                slices(h.netlist.input(cell, pin));
            }
        }
    }

    /// Some bits of nets; those of which only a clock edge reads need not be there.
    fn gather(&self, h: &StateView<'_>, slices: &[Slice], to: &mut [Word]) {
        let mut at = 0;
        for s in slices {
            let constant = h.netlist.constants().covers(s).then(|| h.netlist.constants().net(s.net));
            let from = constant.or_else(|| h.net(s.net)).or_else(|| self.value(h, Want::Net(s.net)));
            match (from, h.memory(s.net)) {
                (Some(from), _) => copy(to, at, from, s.lo, s.width),
                (None, Some((cell, m))) => {
                    let mut done = 0;
                    while done < s.width {
                        let (port, lo) = ((s.lo + done) / m.width, (s.lo + done) % m.width);
                        let n = (s.width - done).min(m.width - lo);
                        if let Some(from) = self.value(h, Want::Port(cell, port)) {
                            copy(to, at + done, from, lo, n);
                        }
                        done += n;
                    }
                }
                (None, None) => {}
            }
            at += s.width;
        }
    }

    fn evaluate(&self, h: &StateView<'_>, want: Want) {
        let net = match want {
            Want::Net(net) => net,
            Want::Port(cell, port) => return self.keep(h, want, self.port(h, cell, port)),
        };
        if let Some((cell, m)) = h.memory(net) {
            let mut all = vec![Word::ZERO; words(h.netlist.net(net).width)];
            for port in 0..m.reads.len() as u32 {
                let from = self.value(h, Want::Port(cell, port)).expect("it has been evaluated");
                copy(&mut all, port * m.width, from, 0, m.width);
            }
            return self.keep(h, want, all);
        }
        let cell = h.driver(net);
        for (pin, value) in self.outputs(h, cell).into_iter().enumerate() {
            let net = h.netlist.output(cell, pin);
            if h.net(net).is_none() {
                self.keep(h, Want::Net(net), value);
            }
        }
    }

    /// What a read port of a memory gives.
    fn port(&self, h: &StateView<'_>, cell: CellId, port: u32) -> Vec<Word> {
        let CellKind::Memory(m) = &h.netlist.cell(cell).kind else { unreachable!("only memories have ports") };
        let place = &h.layout.memories[h.layout.memory_of[&cell]];
        let one = |pin, width: u32| {
            let mut to = [Word::ZERO];
            self.gather(h, &part(h.netlist.input(cell, pin), port * width, width), &mut to);
            to[0]
        };
        let mut q = vec![Word::ZERO; words(m.width)];
        match place.ports[port as usize] {
            Some(slot) => q.copy_from_slice(&h.memory[slot.index()..][..words(m.width)]),
            None => m.read(&h.memory[place.contents.index()..][..place.len as usize], one(RD_ADDR, m.abits), &mut q),
        }
        m.reset(port as usize, one(RD_ARST, 1), &mut q);
        q
    }

    /// The outputs of a cell, what it reads being there.
    pub fn outputs(&self, h: &StateView<'_>, cell: CellId) -> Vec<Vec<Word>> {
        let kind = &h.netlist.cell(cell).kind;
        let ins: Vec<Vec<Word>> = (0..kind.inputs().len())
            .map(|pin| {
                let slices = h.netlist.input(cell, pin);
                let mut all = vec![Word::ZERO; words(kind.input_width(pin).max(1))];
                if slices.is_empty() {
                    all[0] = Word::known(u64::from(kind.inputs()[pin].default));
                }
                self.gather(h, slices, &mut all);
                all
            })
            .collect();
        let ins: Vec<&[Word]> = ins.iter().map(Vec::as_slice).collect();
        let mut outs: Vec<Vec<Word>> = (0..kind.outputs().len())
            .map(|pin| match h.net(h.netlist.output(cell, pin)) {
                Some(value) => value.to_vec(),
                None => vec![Word::ZERO; words(kind.output_width(pin))],
            })
            .collect();
        let mut views: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
        evaluate(kind, &ins, &mut views);
        outs
    }
}
