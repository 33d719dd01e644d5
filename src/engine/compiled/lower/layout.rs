//! What of a netlist the phases need beside its functions: where state lies, clock pins with the cells that they clock,
//! controls that may become unknown.

use crate::compiled::ir::places::{Slot, Slots};
use std::collections::{HashMap, HashSet};

use crate::cell::pin::memory::{RD_ARST, RD_CLK, RD_EN, RD_SRST, WR_CLK, WR_EN};
use crate::cell::{CellKind, Edge, Memory, Role};
use crate::compiled::lower::Places;
use crate::netlist::{CellId, Direction, Driver, NetId, Netlist};
use crate::value::Word;
use crate::value::word::{extract, word_mask, words};

/// One bit of a net.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Bit {
    pub net: NetId,
    pub lo: u32,
}

/// A bit at which edges are looked for, and the storage cells, by number, that sample there.
#[derive(Clone, Debug)]
pub(crate) struct ClockPin {
    pub bit: Bit,
    /// Whether being 1 from the start is an edge: the control is one that acts.
    pub level: bool,
    pub rising: Vec<u32>,
    pub falling: Vec<u32>,
    /// Cells that sample when this asynchronous control goes from 0 to unknown.
    pub unknown: Vec<u32>,
}

/// A net whose value is kept in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    pub net: NetId,
    /// The bit that tells of a change, if it is observed.
    pub observed: Option<u32>,
    /// Whether a change is listed, and whether it is written down.
    pub stops: bool,
    pub traced: bool,
    /// Whether it is kept in any variant, not only where it is a control that may be unknown.
    pub always: bool,
}

/// A control pin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ControlPin {
    pub cell: CellId,
    pub pin: &'static str,
    pub net: NetId,
}

/// What of a cell a clock makes act.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Part {
    /// All of it.
    Whole,
    /// A read port of a memory.
    Read(u32),
    /// A write port of a memory.
    Write(u32),
}

/// The parts of a cell that have a clock.
pub(crate) fn clocked_parts(kind: &CellKind) -> Vec<Part> {
    let CellKind::Memory(m) = kind else {
        return kind.edge().map(|_| Part::Whole).into_iter().collect();
    };
    let reads = (0..).zip(&m.reads).filter(|r| r.1.clock.is_some()).map(|r| Part::Read(r.0));
    let writes = (0..).zip(&m.writes).filter(|w| w.1.clock.is_some()).map(|w| Part::Write(w.0));
    reads.chain(writes).collect()
}

/// A storage cell with a clock, or a port of a memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored {
    pub cell: CellId,
    pub part: Part,
    pub net: NetId,
    /// First slot of its state, and of what is sampled for the next edge.
    pub slot: Slot,
    pub stage: Slot,
    /// How many words its state has, and how many are sampled.
    pub words: u32,
    pub sampled: u32,
}

/// Where a memory lies.
#[derive(Clone, Debug)]
pub(crate) struct MemoryPlace {
    pub cell: CellId,
    /// The first slot of its contents, and how many there are.
    pub contents: Slot,
    pub len: u32,
    /// For each read port with a clock the first slot of what it has.
    pub ports: Vec<Option<Slot>>,
    /// The number of its first read port among those of all memories.
    pub first_port: u32,
}

/// See the head of this file.
#[derive(Debug, Default)]
pub(crate) struct StateLayout {
    /// The width of each net.
    pub widths: Vec<u32>,
    /// First slot of each net that has one.
    pub slot: Vec<Option<Slot>>,
    /// Inputs and state, which have slots from the start: the slots, those of the inputs first.
    pub leaves: Slots,
    /// The net of each of these slots.
    pub leaf_net: Vec<NetId>,
    /// The bits of each of these slots that are in use.
    pub leaf_mask: Vec<u64>,
    /// The present values of all slots before anything has run.
    pub initial: Vec<Word>,
    pub stored: Vec<Stored>,
    pub memories: Vec<MemoryPlace>,
    pub memory_of: HashMap<CellId, usize>,
    /// The cells of each loop.
    pub loops: Vec<Vec<CellId>>,
    /// For each loop a slot that tells whether it has settled.
    pub unsettled: Vec<Slot>,
    pub pins: Vec<ClockPin>,
    /// Control pins by the bit that they read.
    pub controls: Vec<(Bit, Vec<u32>)>,
    pub control_pins: Vec<ControlPin>,
}

/// The value that a net has before anything has run, as the event engine has it.
pub(crate) fn initial(netlist: &Netlist, net: NetId) -> Vec<Word> {
    let n = netlist.net(net);
    let init = match n.driver {
        Driver::Cell(cell, 0) => match &netlist.cell(cell).kind {
            CellKind::Constant(value) => Some((**value).clone()),
            kind => kind.init().cloned(),
        },
        _ => None,
    };
    let floats = matches!(n.driver, Driver::Input(s) if netlist.signal(s).port == Some(Direction::Inout));
    let constant = netlist.constants().net(net);
    (0..words(n.width))
        .map(|w| {
            let m = word_mask(n.width, w);
            let unset = if floats { Word::z(m) } else { constant[w] };
            init.as_ref().map_or(unset, |v| v.words().nth(w).unwrap_or_default())
        })
        .collect()
}

impl StateLayout {
    /// Lays out the state of a netlist from slot `first` on.
    pub fn new(netlist: &Netlist, first: u32) -> StateLayout {
        let widths = netlist.nets().iter().map(|n| n.width).collect();
        let mut w = StateLayout { widths, slot: vec![None; netlist.nets().len()], ..StateLayout::default() };
        w.initial = vec![Word::ZERO; first as usize];
        for input in [true, false] {
            for net in netlist.net_ids() {
                let is = match netlist.net(net).driver {
                    Driver::Input(_) => input,
                    Driver::Cell(cell, 0) => {
                        let kind = &netlist.cell(cell).kind;
                        if input { matches!(kind, CellKind::Clock(_)) } else { is_state(kind) }
                    }
                    Driver::Cell(..) => false,
                };
                if is {
                    w.leaf(netlist, net, first);
                }
            }
        }
        // what loops have is state
        for group in &netlist.order().groups {
            let cells = &netlist.order().sequence[group.clone()];
            for &cell in cells {
                for pin in 0..netlist.cell(cell).kind.outputs().len() {
                    w.leaf(netlist, netlist.output(cell, pin), first);
                }
            }
            w.loops.push(cells.to_vec());
        }
        for cell in netlist.cell_ids() {
            if let CellKind::Memory(memory) = &netlist.cell(cell).kind {
                w.read_ports(netlist, cell, memory, first);
            }
        }
        w.leaves = Slots { start: Slot::at(first as usize), end: w.end() };
        for place in &mut w.memories {
            let CellKind::Memory(memory) = &netlist.cell(place.cell).kind else { unreachable!("it is a memory") };
            place.contents = Slot::at(w.initial.len());
            place.len = memory.init.len() as u32;
            // what lies between words is 0
            let used = Memory::contents(memory.width, memory.size);
            w.initial.extend(memory.init.iter().zip(used).map(|(w, used)| Word { v: w.v & used.u, u: w.u & used.u }));
        }
        for _ in &w.loops {
            w.unsettled.push(w.end());
            w.initial.push(Word::ZERO);
        }
        for cell in netlist.cell_ids() {
            let kind = &netlist.cell(cell).kind;
            for part in clocked_parts(kind) {
                let net = netlist.output(cell, 0);
                let stage = w.end();
                let place = || &w.memories[w.memory_of[&cell]];
                let (slot, n, sampled) = match (kind, part) {
                    (CellKind::Memory(m), Part::Read(port)) => {
                        let slot = place().ports[port as usize].expect("it has a clock");
                        (slot, words(m.width), 4)
                    }
                    (CellKind::Memory(m), _) => (place().contents, 0, 1 + 2 * words(m.width)),
                    _ => {
                        let n = words(netlist.net(net).width);
                        (w.slot[net.index()].expect("state has a place"), n, n)
                    }
                };
                w.initial.extend((0..sampled).map(|_| Word::ZERO));
                w.stored.push(Stored { cell, part, net, slot, stage, words: n as u32, sampled: sampled as u32 });
            }
        }
        w.clocks(netlist);
        w.watch_controls(netlist);
        w
    }

    /// Gives a net that is state its slots, the first of all being `first`.
    fn leaf(&mut self, netlist: &Netlist, net: NetId, first: u32) {
        if self.slot[net.index()].is_some() {
            return;
        }
        self.place(netlist, net);
        self.leaf_net.resize(self.initial.len() - first as usize, net);
        let width = netlist.net(net).width;
        self.leaf_mask.extend((0..words(width)).map(|i| word_mask(width, i)));
    }

    /// Gives the read ports of a memory that have a clock their slots.
    fn read_ports(&mut self, netlist: &Netlist, cell: CellId, memory: &Memory, first: u32) {
        let net = netlist.output(cell, 0);
        let start: Vec<Word> = memory.start.words().collect();
        let n = words(memory.width);
        let ports = (0..).zip(&memory.reads).map(|(port, spec)| {
            spec.clock?;
            let slot = self.initial.len();
            self.initial.resize(slot + n, Word::ZERO);
            extract(&mut self.initial[slot..], &start, port * memory.width, memory.width);
            self.leaf_net.resize(slot + n - first as usize, net);
            self.leaf_mask.extend((0..n).map(|i| word_mask(memory.width, i)));
            Some(Slot::at(slot))
        });
        let ports = ports.collect();
        self.memory_of.insert(cell, self.memories.len());
        let first_port = self.memories.last().map_or(0, |m| m.first_port + m.ports.len() as u32);
        self.memories.push(MemoryPlace { cell, contents: Slot::default(), len: 0, ports, first_port });
    }

    /// The first slot that nothing has.
    fn end(&self) -> Slot {
        Slot::at(self.initial.len())
    }

    /// Gives a net slots, if it has none; the first.
    pub fn place(&mut self, netlist: &Netlist, net: NetId) -> Slot {
        if let Some(slot) = self.slot[net.index()] {
            return slot;
        }
        let slot = self.end();
        self.initial.extend(initial(netlist, net));
        self.slot[net.index()] = Some(slot);
        slot
    }

    fn clocks(&mut self, netlist: &Netlist) {
        let mut known: HashMap<(Bit, bool), usize> = HashMap::new();
        for (number, stored) in self.stored.iter().enumerate() {
            let kind = &netlist.cell(stored.cell).kind;
            let clock = match stored.part {
                Part::Whole => None,
                Part::Read(port) => Some((RD_CLK, port)),
                Part::Write(port) => Some((WR_CLK, port)),
            };
            if let Some((pin, port)) = clock {
                let bit = bit_at(netlist, stored.cell, pin, port);
                let at = *known.entry((bit, false)).or_insert_with(|| {
                    let (rising, falling, unknown) = (vec![], vec![], vec![]);
                    self.pins.push(ClockPin { bit, level: false, rising, falling, unknown });
                    self.pins.len() - 1
                });
                let rising = kind.edge_at(pin, port) == Some(Edge::Rising);
                let clock = &mut self.pins[at];
                if rising { &mut clock.rising } else { &mut clock.falling }.push(number as u32);
                continue;
            }
            for (pin, spec) in kind.inputs().iter().enumerate() {
                let Some(bit) = bit(netlist, stored.cell, pin) else { continue };
                let level = spec.role == Role::Trigger;
                if !matches!(spec.role, Role::Clock | Role::Level | Role::Trigger) {
                    continue;
                }
                let at = *known.entry((bit, level)).or_insert_with(|| {
                    let (rising, falling, unknown) = (vec![], vec![], vec![]);
                    self.pins.push(ClockPin { bit, level, rising, falling, unknown });
                    self.pins.len() - 1
                });
                let clock = &mut self.pins[at];
                let list = match spec.role {
                    Role::Clock if kind.edge() == Some(Edge::Rising) => &mut clock.rising,
                    Role::Clock => &mut clock.falling,
                    Role::Level => &mut clock.unknown,
                    _ => &mut clock.rising,
                };
                list.push(number as u32);
            }
        }
    }

    fn watch_controls(&mut self, netlist: &Netlist) {
        let mut known: HashMap<Bit, usize> = HashMap::new();
        for cell in netlist.cell_ids() {
            let kind = &netlist.cell(cell).kind;
            if kind.init().is_none() {
                continue;
            }
            if let CellKind::Memory(memory) = kind {
                self.watch_memory(netlist, cell, memory, &mut known);
                continue;
            }
            for (pin, spec) in kind.inputs().iter().enumerate() {
                let watched = matches!(spec.role, Role::Clock | Role::Level | Role::Trigger | Role::Enable);
                let Some(bit) = bit(netlist, cell, pin).filter(|_| watched) else { continue };
                let at = *known.entry(bit).or_insert_with(|| {
                    self.controls.push((bit, Vec::new()));
                    self.controls.len() - 1
                });
                self.controls[at].1.push(self.control_pins.len() as u32);
                self.control_pins.push(ControlPin { cell, pin: spec.name, net: bit.net });
            }
        }
    }
}

/// Whether the first output of a cell is all that it holds.
pub(crate) fn is_state(kind: &CellKind) -> bool {
    kind.init().is_some() && !matches!(kind, CellKind::Memory(_))
}

/// One bit of a connected pin.
fn bit_at(netlist: &Netlist, cell: CellId, pin: usize, at: u32) -> Bit {
    let mut lo = at;
    for s in netlist.input(cell, pin) {
        if lo < s.width {
            return Bit { net: s.net, lo: s.lo + lo };
        }
        lo -= s.width;
    }
    unreachable!("pins of memories are connected")
}

impl StateLayout {
    /// The bits of a memory's pins whose unknown values are reported.
    fn watch_memory(&mut self, netlist: &Netlist, cell: CellId, memory: &Memory, known: &mut HashMap<Bit, usize>) {
        let kind = &netlist.cell(cell).kind;
        let mut seen: HashSet<(usize, Bit)> = HashSet::new();
        for pin in [RD_CLK, RD_EN, RD_ARST, RD_SRST, WR_CLK, WR_EN] {
            let slices = netlist.input(cell, pin);
            let bits = slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| Bit { net: s.net, lo }));
            for (number, bit) in bits.enumerate() {
                let watched = match pin {
                    RD_ARST | WR_EN => true,
                    WR_CLK => memory.writes[number].clock.is_some(),
                    _ => memory.reads[number].clock.is_some(),
                };
                if !watched || !seen.insert((pin, bit)) {
                    continue;
                }
                let at = *known.entry(bit).or_insert_with(|| {
                    self.controls.push((bit, Vec::new()));
                    self.controls.len() - 1
                });
                self.controls[at].1.push(self.control_pins.len() as u32);
                self.control_pins.push(ControlPin { cell, pin: kind.inputs()[pin].name, net: bit.net });
            }
        }
    }
}

/// A connected pin of one bit.
fn bit(netlist: &Netlist, cell: CellId, pin: usize) -> Option<Bit> {
    let slices = netlist.input(cell, pin);
    let one = netlist.cell(cell).kind.input_width(pin) == 1;
    slices.first().filter(|_| one).map(|s| Bit { net: s.net, lo: s.lo })
}

/// Where state lies, and what of it may be unknown.
pub(crate) struct StatePlaces<'w> {
    pub layout: &'w StateLayout,
    pub unknown: &'w dyn Fn(Slot) -> bool,
}

impl Places for StatePlaces<'_> {
    fn slot(&self, net: NetId) -> Slot {
        self.layout.slot[net.index()].expect("inputs and state have places")
    }

    fn memory(&self, cell: CellId) -> &MemoryPlace {
        &self.layout.memories[self.layout.memory_of[&cell]]
    }

    fn may_be_unknown(&self, slot: Slot) -> bool {
        (self.unknown)(slot)
    }
}
