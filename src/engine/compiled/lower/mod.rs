//! From a netlist to a [`Graph`]: what every net is, and what every storage cell takes, as a function of inputs and state.
//!
//! The functions of the cell room once more, on nodes in place of words. Four-valued throughout: that an unknown plane is
//! constant 0 is for the graph to make use of.

mod algebra;
pub(crate) mod four;
pub(crate) mod layout;
pub(crate) mod memory;
pub(crate) mod support;

use crate::compiled::ir::places::Slot;
use std::collections::HashMap;

use self::algebra::Place;
use self::four::{Bits, Two, append, slice};
use self::layout::{MemoryPlace, Part, clocked_parts, is_state};
use crate::cell::pin::memory::{RD_ADDR, RD_ARST, RD_EN, RD_SRST, WR_ADDR, WR_DATA, WR_EN};
use crate::cell::{Algebra, CellKind, GateOp, Memory, Role, act, at_edge, derived, gate, level};
use crate::compiled::ir::graph::{Graph, Id};
use crate::netlist::{CellId, Constants, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{word_mask, words};

/// Where state lies and how much is known of it.
pub(crate) trait Places {
    /// The first slot of a net that is an input or a state.
    fn slot(&self, net: NetId) -> Slot;
    /// Where a memory lies.
    fn memory(&self, cell: CellId) -> &MemoryPlace;
    /// Whether the word of state in a slot may hold x or z.
    fn may_be_unknown(&self, slot: Slot) -> bool;
}

/// State that asynchronous controls may change at once.
#[derive(Debug)]
pub(crate) struct Level {
    /// Where it lies.
    pub slot: Slot,
    /// The net that it is the value of; none for what a port of a memory has.
    pub net: Option<NetId>,
    /// What it becomes.
    pub value: Bits,
    /// The controls and the data on which that depends beside the state itself.
    pub needs: Vec<Id>,
    /// For a net of a loop the number of the loop.
    pub group: Option<u32>,
}

/// What a storage cell takes at its active edge; what a port of a memory is told: of a read port enable, resets and
/// address, of a write port address, data and enable.
#[derive(Debug)]
pub(crate) struct Next {
    pub cell: CellId,
    pub value: Bits,
}

/// A circuit as functions of its inputs and state.
#[derive(Debug, Default)]
pub(crate) struct Lowered {
    pub graph: Graph,
    /// For each net its words; empty where the netlist was not lowered up to it.
    pub nets: Vec<Bits>,
    /// State that asynchronous controls may change at once.
    pub levels: Vec<Level>,
    /// For each loop a node that is not 0 where it has not settled after the steps that are followed.
    pub unsettled: Vec<Id>,
    pub next: Vec<Next>,
}

struct Lower<'n, P> {
    netlist: &'n Netlist,
    constants: &'n Constants,
    places: &'n P,
    /// What each port of a memory gives, as far as it is known.
    ports: HashMap<CellId, Vec<Bits>>,
    out: Lowered,
}

/// Lowers a netlist, every cell of which is supported.
pub(crate) fn lower(netlist: &Netlist, places: &impl Places) -> Lowered {
    let out = Lowered { nets: vec![Vec::new(); netlist.nets().len()], ..Lowered::default() };
    let mut l = Lower { netlist, constants: netlist.constants(), places, ports: HashMap::new(), out };
    for net in netlist.net_ids() {
        let state = match netlist.net(net).driver {
            Driver::Input(_) => true,
            Driver::Cell(cell, 0) => {
                let kind = &netlist.cell(cell).kind;
                if let CellKind::Memory(memory) = kind {
                    l.start_memory(cell, memory);
                }
                is_state(kind) || matches!(kind, CellKind::Clock(_))
            }
            Driver::Cell(..) => false,
        };
        if state {
            l.out.nets[net.index()] = l.state(net);
        }
    }
    let order = netlist.order();
    let mut groups = order.groups.iter().peekable();
    for (at, &cell) in order.sequence.iter().enumerate() {
        match groups.peek() {
            Some(group) if group.end == at + 1 => {
                l.feedback(&order.sequence[(*group).clone()]);
                groups.next();
            }
            Some(group) if group.start <= at => {}
            _ => match &netlist.cell(cell).kind {
                CellKind::Memory(memory) => l.memory(cell, memory, order.ports.get(&at).copied()),
                _ => l.cell(cell),
            },
        }
    }
    for cell in netlist.cell_ids() {
        for part in clocked_parts(&netlist.cell(cell).kind) {
            match part {
                Part::Whole => l.next(cell),
                part => l.next_of_port(cell, part),
            }
        }
    }
    l.out
}

impl<P: Places> Lower<'_, P> {
    fn state(&mut self, net: NetId) -> Bits {
        self.load(self.places.slot(net), self.netlist.net(net).width)
    }

    fn load(&mut self, slot: Slot, width: u32) -> Bits {
        (0..words(width) as u32)
            .map(|i| {
                let m = word_mask(width, i as usize);
                let (plane, g) = ((slot + i).value(), &mut self.out.graph);
                let unknown = self.places.may_be_unknown(slot + i);
                Two { v: g.load(plane, m), u: if unknown { g.load(plane + 1, m) } else { g.constant(0) } }
            })
            .collect()
    }

    /// Some bits of nets, one above another.
    fn signals(&mut self, slices: &[Slice]) -> Bits {
        let mut all = Vec::new();
        let mut at = 0;
        let mut rest = slices;
        while let Some((s, after)) = rest.split_first() {
            rest = after;
            // one bit many times, as an extended sign is
            let times = 1 + after.iter().take_while(|next| s.width == 1 && *next == s).count();
            if times > 1 {
                let bit = self.signals(&slices[slices.len() - rest.len() - 1..][..1])[0];
                let g = &mut self.out.graph;
                let width = times as u32;
                let part: Bits = (0..words(width))
                    .map(|i| {
                        let m = word_mask(width, i);
                        Two { v: g.splat(bit.v, m), u: g.splat(bit.u, m) }
                    })
                    .collect();
                append(g, &mut all, at, &part, width);
                at += width;
                rest = &after[times - 1..];
                continue;
            }
            let g = &mut self.out.graph;
            let part = if self.constants.covers(s) {
                let mut constant = vec![Word::ZERO; words(s.width)];
                crate::value::word::extract(&mut constant, self.constants.net(s.net), s.lo, s.width);
                constant.into_iter().map(|w| g.literal(w)).collect()
            } else {
                slice(g, &self.out.nets[s.net.index()], s.lo, s.width)
            };
            append(g, &mut all, at, &part, s.width);
            at += s.width;
        }
        all
    }

    fn pin(&mut self, cell: CellId, pin: usize) -> Bits {
        let kind = &self.netlist.cell(cell).kind;
        let slices = self.netlist.input(cell, pin);
        if slices.is_empty() {
            let mut all = self.out.graph.zeros(kind.input_width(pin).max(1));
            all[0] = self.out.graph.literal(Word::known(u64::from(kind.inputs()[pin].default)));
            return all;
        }
        self.signals(slices)
    }

    fn acts(&self, cell: CellId, pin: usize) -> bool {
        !self.netlist.input(cell, pin).iter().all(|s| self.constants.is_zero(s))
    }

    fn set(&mut self, cell: CellId, pin: usize, value: Bits) {
        self.out.nets[self.netlist.output(cell, pin).index()] = value;
    }

    fn cell(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        match kind {
            CellKind::Gate { op, width: 1, inputs } => {
                let y = self.gate_of_bits(*op, netlist.input(cell, 0), *inputs);
                self.set(cell, 0, vec![y]);
            }
            CellKind::IsZero { width } => {
                let y = self.gate_of_bits(GateOp::Nor, netlist.input(cell, 0), *width);
                self.set(cell, 0, vec![y]);
            }
            CellKind::Clock(_) | CellKind::EdgeFlop(_) => {}
            kind if kind.init().is_some() => self.storage(cell),
            kind => {
                let ins: Vec<Bits> = (0..kind.inputs().len()).map(|pin| self.pin(cell, pin)).collect();
                let mut place = Place::new(&ins, &[]);
                act(&mut self.out.graph, kind, &mut place);
                for (pin, value) in place.outs.into_iter().enumerate() {
                    self.set(cell, pin, value);
                }
            }
        }
    }

    /// Cells that read each other in a loop, stepped: in each step all compute from the values before it. What they had
    /// is state, so that the steps go on from there.
    fn feedback(&mut self, cells: &[CellId]) {
        let netlist = self.netlist;
        let outputs: Vec<NetId> = cells
            .iter()
            .flat_map(|&c| (0..netlist.cell(c).kind.outputs().len()).map(move |pin| netlist.output(c, pin)))
            .collect();
        for &net in &outputs {
            self.out.nets[net.index()] = self.state(net);
        }
        // what they hold may change at a clock edge too
        let held = outputs.iter().flat_map(|net| self.out.nets[net.index()].iter().flat_map(|two| [two.v, two.u]));
        let mut needs: Vec<Id> = held.collect();
        for &cell in cells {
            for pin in 0..netlist.cell(cell).kind.inputs().len() {
                for s in netlist.input(cell, pin).iter().filter(|s| !outputs.contains(&s.net)) {
                    needs.extend(self.out.nets[s.net.index()].iter().flat_map(|two| [two.v, two.u]));
                }
            }
        }
        let levels = self.out.levels.len();
        for _ in 0..=cells.len() {
            let new = self.step(cells, &outputs);
            outputs.iter().zip(new).for_each(|(net, value)| self.out.nets[net.index()] = value);
        }
        let beyond = self.step(cells, &outputs);
        let mut differs = self.out.graph.constant(0);
        for (net, new) in outputs.iter().zip(beyond) {
            for (i, new) in new.into_iter().enumerate() {
                let (g, old) = (&mut self.out.graph, self.out.nets[net.index()][i]);
                let (v, u) = (g.xor(old.v, new.v), g.xor(old.u, new.u));
                differs = g.or(differs, v);
                differs = g.or(differs, u);
            }
        }
        self.out.levels.truncate(levels);
        let group = Some(self.out.unsettled.len() as u32);
        let differs = self.out.graph.any(differs);
        self.out.unsettled.push(differs);
        for &net in &outputs {
            let value = self.out.nets[net.index()].clone();
            let slot = self.places.slot(net);
            self.out.levels.push(Level { slot, net: Some(net), value, needs: needs.clone(), group });
        }
    }

    /// What the nets of a loop become in a step.
    fn step(&mut self, cells: &[CellId], outputs: &[NetId]) -> Vec<Bits> {
        let before: Vec<Bits> = outputs.iter().map(|net| self.out.nets[net.index()].clone()).collect();
        let mut new = Vec::new();
        for &cell in cells {
            self.cell(cell);
            for pin in 0..self.netlist.cell(cell).kind.outputs().len() {
                let net = self.netlist.output(cell, pin).index();
                new.push(self.out.nets[net].clone());
            }
            outputs.iter().zip(&before).for_each(|(net, old)| self.out.nets[net.index()].clone_from(old));
        }
        new
    }

    /// A gate of one bit, of inputs that may lie together in words.
    fn gate_of_bits(&mut self, op: GateOp, slices: &[Slice], inputs: u32) -> Two {
        if inputs == 1 {
            let a = self.signals(slices)[0];
            return gate::finish(&mut self.out.graph, op, a, 1);
        }
        let mut joined: Option<Two> = None;
        for s in slices {
            let words = self.signals(&[*s]);
            for (i, &w) in words.iter().enumerate() {
                let g = &mut self.out.graph;
                let one = gate::reduce(g, op, w, word_mask(s.width, i));
                joined = Some(joined.map_or(one, |all| gate::join(g, op, all, one)));
            }
        }
        let g = &mut self.out.graph;
        // a pin that is not connected reads 0
        let joined = joined.unwrap_or_else(|| g.literal(Word::ZERO));
        gate::finish(g, op, joined, 1)
    }

    /// The outputs of a storage cell, after its asynchronous controls.
    fn storage(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let net = netlist.output(cell, 0);
        let before = self.out.nets[net.index()].clone();
        // the others may come later in the order
        let at_once = |l: &Self, pin: usize| kind.acts_at_once(pin, |pin| l.acts(cell, pin));
        let ins: Vec<Bits> = (0..kind.inputs().len())
            .map(|pin| if at_once(self, pin) { self.pin(cell, pin) } else { Bits::new() })
            .collect();
        let mut place = Place::new(&ins, &before);
        level(&mut self.out.graph, kind, &mut place);
        let q = place.outs.swap_remove(0);
        if q != before {
            let loads = kind.loads().filter(|&(_, control)| self.acts(cell, control)).map(|(data, _)| data);
            let read = |pin: usize| loads == Some(pin) || kind.inputs()[pin].role == Role::Level;
            let pins = ins.iter().enumerate().filter(|&(pin, _)| read(pin));
            let needs = pins.flat_map(|(_, words)| words).flat_map(|two| [two.v, two.u]).collect();
            let slot = self.places.slot(net);
            self.out.levels.push(Level { slot, net: Some(net), value: q.clone(), needs, group: None });
        }
        let mut place = Place::new(&ins, &q);
        derived(&mut self.out.graph, kind, &mut place);
        if let Some(value) = place.outs.into_iter().nth(1) {
            self.set(cell, 1, value);
        }
        self.set(cell, 0, q);
    }

    /// What read ports with a clock have, before anything else is known of a memory.
    fn start_memory(&mut self, cell: CellId, memory: &Memory) {
        let ports: Vec<Option<Slot>> = self.places.memory(cell).ports.clone();
        let list: Vec<Bits> = ports
            .into_iter()
            .map(|slot| match slot {
                Some(slot) => self.load(slot, memory.width),
                None => self.out.graph.zeros(memory.width),
            })
            .collect();
        self.give_ports(cell, memory, list);
    }

    fn give_ports(&mut self, cell: CellId, memory: &Memory, ports: Vec<Bits>) {
        let mut all = Vec::new();
        for (k, value) in (0..).zip(&ports) {
            append(&mut self.out.graph, &mut all, k * memory.width, value, memory.width);
        }
        self.set(cell, 0, all);
        self.ports.insert(cell, ports);
    }

    /// What of a pin a port of a memory has, of which each has `width` bits.
    fn port_pin(&mut self, cell: CellId, pin: usize, port: usize, width: u32) -> Bits {
        let slices = part(self.netlist.input(cell, pin), port as u32 * width, width);
        if slices.is_empty() {
            return self.out.graph.zeros(1);
        }
        self.signals(&slices)
    }

    /// What one read port without a clock gives, or all that have one; or all ports.
    fn memory(&mut self, cell: CellId, memory: &Memory, port: Option<u32>) {
        let place = self.places.memory(cell);
        let (contents, slots) = (place.contents, &place.ports);
        let mut ports = self.ports.remove(&cell).expect("it has been begun");
        for (at, spec) in memory.reads.iter().enumerate() {
            let here = port.is_none_or(|p| match spec.clock {
                None => p == at as u32,
                Some(_) => memory.reads[p as usize].clock.is_some(),
            });
            if !here {
                continue;
            }
            let arst = self.port_pin(cell, RD_ARST, at, 1)[0];
            match slots[at] {
                None => {
                    let address = self.port_pin(cell, RD_ADDR, at, memory.abits)[0];
                    let g = &mut self.out.graph;
                    let value = memory::read(g, memory, contents, address, &mut memory::fetch);
                    ports[at] = memory::reset(g, memory, at, arst, &value);
                }
                Some(slot) => {
                    let held = ports[at].clone();
                    let value = memory::reset(&mut self.out.graph, memory, at, arst, &held);
                    if value != held {
                        let needs = vec![arst.v, arst.u];
                        self.out.levels.push(Level { slot, net: None, value: value.clone(), needs, group: None });
                    }
                    ports[at] = value;
                }
            }
        }
        self.give_ports(cell, memory, ports);
    }

    fn next_of_port(&mut self, cell: CellId, part: Part) {
        let CellKind::Memory(memory) = &self.netlist.cell(cell).kind else { unreachable!("only memories have ports") };
        let pins: &[(usize, u32)] = match part {
            Part::Read(_) => &[(RD_EN, 1), (RD_ARST, 1), (RD_SRST, 1), (RD_ADDR, memory.abits)],
            _ => &[(WR_ADDR, memory.abits), (WR_DATA, memory.width), (WR_EN, memory.width)],
        };
        let (Part::Read(port) | Part::Write(port)) = part else { unreachable!("it is a port") };
        let value = pins.iter().flat_map(|&(pin, width)| self.port_pin(cell, pin, port as usize, width)).collect();
        self.out.next.push(Next { cell, value });
    }

    /// What a clocked cell takes at its edge.
    fn next(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let q = self.out.nets[netlist.output(cell, 0).index()].clone();
        let ins: Vec<Bits> = (0..kind.inputs().len()).map(|pin| self.pin(cell, pin)).collect();
        let mut place = Place::new(&ins, &q);
        at_edge(&mut self.out.graph, kind, None, &mut place);
        let value = place.outs.swap_remove(0);
        self.out.next.push(Next { cell, value });
    }
}

/// `width` bits of some slices from bit `lo` up.
pub(crate) fn part(slices: &[Slice], mut lo: u32, mut width: u32) -> Vec<Slice> {
    let mut out = Vec::new();
    for s in slices {
        if lo >= s.width {
            lo -= s.width;
            continue;
        }
        let n = width.min(s.width - lo);
        out.extend((n > 0).then_some(Slice { net: s.net, lo: s.lo + lo, width: n }));
        (lo, width) = (0, width - n);
    }
    out
}
