//! What of a netlist the waves need beside its functions: where state lies, clock pins with the cells that they clock,
//! controls that may become unknown.

use std::collections::HashMap;

use super::lower::Places;
use crate::cell::{CellKind, Edge, Role};
use crate::netlist::{CellId, Direction, Driver, NetId, Netlist};
use crate::value::Word;
use crate::value::word::{word_mask, words};

/// One bit of a net.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Bit {
    pub net: NetId,
    pub lo: u32,
}

/// A bit at which edges are looked for, and the storage cells, by number, that sample there.
#[derive(Clone, Debug)]
pub(super) struct ClockPin {
    pub bit: Bit,
    /// Whether being 1 from the start is an edge: the control is one that acts.
    pub level: bool,
    pub rising: Vec<u32>,
    pub falling: Vec<u32>,
    /// Cells that sample when this asynchronous control goes from 0 to unknown.
    pub unknown: Vec<u32>,
}

/// A control pin.
#[derive(Clone, Copy, Debug)]
pub(super) struct ControlPin {
    pub cell: CellId,
    pub pin: &'static str,
    pub net: NetId,
}

/// A storage cell with a clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub cell: CellId,
    pub net: NetId,
    /// First slot of its state, and of what it takes at the next edge.
    pub slot: u32,
    pub stage: u32,
    pub words: u32,
}

/// See the head of this file.
#[derive(Debug, Default)]
pub(super) struct Wiring {
    /// The width of each net.
    pub widths: Vec<u32>,
    /// First slot of each net that has one.
    pub slot: Vec<Option<u32>>,
    /// Inputs and state, which have slots from the start: the slots, those of the inputs first.
    pub leaves: std::ops::Range<u32>,
    /// The net of each of these slots.
    pub leaf_net: Vec<NetId>,
    /// The bits of each of these slots that are in use.
    pub leaf_mask: Vec<u64>,
    /// The present values of all slots before anything has run.
    pub initial: Vec<Word>,
    pub stored: Vec<Stored>,
    /// The cells of each loop.
    pub loops: Vec<Vec<CellId>>,
    /// For each loop a slot that tells whether it has settled.
    pub unsettled: Vec<u32>,
    pub pins: Vec<ClockPin>,
    /// Control pins by the bit that they read.
    pub controls: Vec<(Bit, Vec<u32>)>,
    pub control_pins: Vec<ControlPin>,
}

/// The value that a net has before anything has run, as the event engine has it.
pub(super) fn initial(netlist: &Netlist, net: NetId) -> Vec<Word> {
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

impl Wiring {
    /// Lays out the state of a netlist from slot `first` on.
    pub fn new(netlist: &Netlist, first: u32) -> Wiring {
        let widths = netlist.nets().iter().map(|n| n.width).collect();
        let mut w = Wiring { widths, slot: vec![None; netlist.nets().len()], ..Wiring::default() };
        w.initial = vec![Word::ZERO; first as usize];
        for input in [true, false] {
            for net in netlist.net_ids() {
                let is = match netlist.net(net).driver {
                    Driver::Input(_) => input,
                    Driver::Cell(cell, 0) => {
                        let kind = &netlist.cell(cell).kind;
                        if input { matches!(kind, CellKind::Clock(_)) } else { kind.init().is_some() }
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
        w.leaves = first..w.initial.len() as u32;
        for _ in &w.loops {
            w.unsettled.push(w.initial.len() as u32);
            w.initial.push(Word::ZERO);
        }
        for cell in netlist.cell_ids() {
            let kind = &netlist.cell(cell).kind;
            if kind.edge().is_some() {
                let net = netlist.output(cell, 0);
                let n = words(netlist.net(net).width) as u32;
                let stage = w.initial.len() as u32;
                w.initial.extend((0..n).map(|_| Word::ZERO));
                let slot = w.slot[net.index()].expect("state has a place");
                w.stored.push(Stored { cell, net, slot, stage, words: n });
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

    /// Gives a net slots, if it has none; the first.
    pub fn place(&mut self, netlist: &Netlist, net: NetId) -> u32 {
        if let Some(slot) = self.slot[net.index()] {
            return slot;
        }
        let slot = self.initial.len() as u32;
        self.initial.extend(initial(netlist, net));
        self.slot[net.index()] = Some(slot);
        slot
    }

    fn clocks(&mut self, netlist: &Netlist) {
        let mut known: HashMap<(Bit, bool), usize> = HashMap::new();
        for (number, stored) in self.stored.iter().enumerate() {
            let kind = &netlist.cell(stored.cell).kind;
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

/// A connected pin of one bit.
fn bit(netlist: &Netlist, cell: CellId, pin: usize) -> Option<Bit> {
    let slices = netlist.input(cell, pin);
    let one = netlist.cell(cell).kind.input_width(pin) == 1;
    slices.first().filter(|_| one).map(|s| Bit { net: s.net, lo: s.lo })
}

/// Where state lies, and what of it may be unknown.
pub(super) struct StatePlaces<'w> {
    pub wiring: &'w Wiring,
    pub unknown: &'w dyn Fn(u32) -> bool,
}

impl Places for StatePlaces<'_> {
    fn slot(&self, net: NetId) -> u32 {
        self.wiring.slot[net.index()].expect("inputs and state have places")
    }

    fn may_be_unknown(&self, slot: u32) -> bool {
        (self.unknown)(slot)
    }
}
