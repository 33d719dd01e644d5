//! What the known form of a netlist needs to know of it: what depends on what, and what has to be stored.

use super::cells::has_form;
use super::{Events, logic::Lit};
use crate::batch::program::{Op, Program, ZERO};
use crate::cell::{CellKind, Role};

/// The bits of the pins that are 0 and 1.
const ONE: u32 = 1;

/// Which sets of events there are, and where planes of the known form stand behind those of the bits.
#[derive(Debug)]
pub(in super::super) struct Layout {
    /// By bit: what changes it.
    pub(super) events: Vec<Events>,
    /// By bit: whether it has to be stored.
    pub(super) stored: Vec<bool>,
    /// Inputs and states.
    pub(super) sources: Vec<u32>,
    /// What may be x for known operands.
    pub(super) blurred: Vec<u32>,
    /// The edges at which any store samples.
    pub(super) clocking: Events,
    /// By store: its edges, each the plane of its lanes and the event.
    pub(super) clocks: Vec<Vec<(u32, Events)>>,
    watches: usize,
    first: u32,
    /// The plane of lanes in which something is x.
    pub(super) guard: u32,
    /// The first plane that is free for what nothing keeps.
    pub(super) scratch: u32,
}

impl Program {
    pub(super) fn pins(&self, op: &Op, pin: usize) -> &[u32] {
        &self.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]
    }

    fn all_pins(&self, op: &Op) -> &[u32] {
        &self.pool[op.pins[0] as usize..op.pins[op.pin_count as usize] as usize]
    }
}

/// Whether a cell without a state may give x for known operands.
fn may_blur(kind: &CellKind) -> bool {
    kind.init().is_none() && !kind.keeps_known(|_| true)
}

impl Layout {
    /// Of a program; none if there is no known form of it.
    pub fn new(p: &Program, kept: &[bool]) -> Option<Layout> {
        let mut ops = p.ops.iter().chain(p.stores.iter().map(|store| &store.op));
        if !ops.all(|op| has_form(&p.cells[op.cell as usize], |pin| p.pins(op, pin)[0] != ZERO)) {
            return None;
        }
        let bits = p.bits();
        let watches = p.watches.len();
        let mut layout = Layout {
            events: vec![0; bits],
            stored: kept.to_vec(),
            sources: Vec::new(),
            blurred: Vec::new(),
            clocking: 0,
            clocks: vec![Vec::new(); p.stores.len()],
            watches,
            first: bits as u32,
            guard: bits as u32 + 3 * watches as u32,
            scratch: bits as u32 + 3 * watches as u32 + 1,
        };
        for (number, &(first, width)) in p.inputs.iter().enumerate() {
            for bit in first..first + width {
                layout.events[bit as usize] = layout.input(number);
                layout.sources.push(bit);
            }
        }
        for (number, watch) in p.watches.iter().enumerate() {
            for (stores, rising) in [(&watch.rising, true), (&watch.falling, false)] {
                let event = layout.event(number, rising);
                for &store in stores {
                    layout.clocking |= event;
                    let lanes = layout.trigger(number, rising);
                    layout.clocks[store as usize].push((lanes, event));
                }
            }
        }
        for (number, store) in p.stores.iter().enumerate() {
            let events = layout.clocks[number].iter().fold(0, |all, c| all | c.1);
            for bit in store.q..store.q + store.op.width {
                layout.events[bit as usize] |= events;
                layout.sources.push(bit);
            }
        }
        layout.spread(p)?;
        layout.sources.sort_unstable();
        layout.sources.dedup();
        layout.store(p);
        Some(layout)
    }

    /// What depends on what. None if an x could come to state that levels change, or if anything reads what is x for
    /// ever.
    fn spread(&mut self, p: &Program) -> Option<()> {
        let mut blurred: Vec<bool> = (0..p.bits()).map(|bit| p.constant[bit] && !p.initial[bit].is_known()).collect();
        let mut at = 0;
        while at < p.ops.len() {
            let group = p.ops[at].group;
            let end = match group {
                0 => at + 1,
                _ => p.groups[group as usize - 1].ops.end,
            };
            let ops = &p.ops[at..end];
            let (mut events, mut blurs) = (0, false);
            for op in ops {
                let kind = &p.cells[op.cell as usize];
                let reads = p.all_pins(op);
                events |= reads.iter().fold(0, |all, &b| all | self.events[b as usize]);
                blurs |= reads.iter().any(|&b| blurred[b as usize]);
                let blur = may_blur(kind);
                if blurs && (group != 0 || kind.init().is_some()) || blur && group != 0 {
                    return None;
                }
                blurs |= blur;
            }
            for op in ops {
                let kind = &p.cells[op.cell as usize];
                if group != 0 {
                    continue;
                }
                if kind.init().is_some() {
                    // only what acts at once counts for the state
                    let events = self.level_events(p, op);
                    for bit in op.outs[0]..op.outs[0] + op.width {
                        self.events[bit as usize] |= events;
                        self.sources.push(bit);
                    }
                    if op.derived {
                        let events = self.derived_events(p, op);
                        for bit in op.outs[1]..op.outs[1] + kind.output_width(1) {
                            self.events[bit as usize] = events;
                        }
                    }
                    continue;
                }
                for pin in 0..kind.outputs().len() {
                    for bit in op.outs[pin]..op.outs[pin] + kind.output_width(pin) {
                        self.events[bit as usize] = events;
                        blurred[bit as usize] = blurs;
                        if may_blur(kind) {
                            self.blurred.push(bit);
                        }
                    }
                }
            }
            if group != 0 {
                for &(copy, bit) in p.groups[group as usize - 1].outputs.iter().flatten() {
                    for bit in [copy, bit] {
                        self.events[bit as usize] |= events;
                        self.stored[bit as usize] = true;
                    }
                    self.sources.push(bit);
                }
            }
            at = end;
        }
        let constant_x = |bit: &u32| p.constant[*bit as usize] && !p.initial[*bit as usize].is_known();
        (!p.pool.iter().any(constant_x)).then_some(())
    }

    /// What changes the state of a cell by its levels.
    pub(super) fn level_events(&self, p: &Program, op: &Op) -> Events {
        let kind = &p.cells[op.cell as usize];
        let of = |pin: usize| p.pins(op, pin).iter().fold(0, |all, &b| all | self.events[b as usize]);
        let loads = kind.loads().filter(|&(_, level)| p.pins(op, level)[0] > ONE).map_or(0, |(d, _)| of(d));
        let levels = kind.inputs().iter().enumerate().filter(|(_, pin)| pin.role == Role::Level);
        levels.fold(loads, |all, (pin, _)| all | of(pin))
    }

    /// What changes the output that is made from the state.
    pub(super) fn derived_events(&self, p: &Program, op: &Op) -> Events {
        let kind = &p.cells[op.cell as usize];
        let of = |pin: usize| p.pins(op, pin).iter().fold(0, |all, &b| all | self.events[b as usize]);
        let state = self.events[op.outs[0] as usize];
        kind.derived_pins().iter().fold(state, |all, &pin| all | of(pin))
    }

    /// What other rounds may read has to be stored.
    fn store(&mut self, p: &Program) {
        for &bit in &self.sources {
            self.stored[bit as usize] = true;
        }
        for watch in &p.watches {
            self.stored[watch.bit as usize] = true;
        }
        for store in &p.stores {
            for &bit in p.all_pins(&store.op) {
                self.stored[bit as usize] = true;
            }
        }
        for op in &p.ops {
            let kind = &p.cells[op.cell as usize];
            let own = match kind.init() {
                _ if op.group != 0 => None,
                // of a state its levels and its outputs are computed each for itself
                Some(_) => None,
                None => Some(self.events[op.outs[0] as usize]),
            };
            for &bit in p.all_pins(op) {
                if own != Some(self.events[bit as usize]) {
                    self.stored[bit as usize] = true;
                }
            }
        }
    }

    /// The plane of a watched bit as it was.
    pub fn old(&self, watch: usize) -> u32 {
        self.first + watch as u32
    }

    /// The plane of the lanes in which a watched bit has made an edge.
    pub fn trigger(&self, watch: usize, rising: bool) -> u32 {
        self.first + self.watches as u32 + 2 * watch as u32 + u32::from(rising)
    }

    /// The event of an edge. There are only so many: the last stand for several.
    pub fn event(&self, watch: usize, rising: bool) -> Events {
        1 << (2 * watch + usize::from(rising)).min(126)
    }

    /// The event of a change of an input.
    pub fn input(&self, number: usize) -> Events {
        1 << (2 * self.watches + number).min(127)
    }

    /// A bit as it is read: what it is for ever, or else none.
    pub(super) fn constant(p: &Program, bit: u32) -> Option<Lit> {
        match bit {
            0 | 1 => Some(Lit::constant(bit == 1)),
            _ if p.constant[bit as usize] => Some(Lit::constant(p.initial[bit as usize].v == 1)),
            _ => None,
        }
    }
}
