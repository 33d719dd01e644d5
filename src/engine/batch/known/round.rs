//! A round: the stores that sample, and all that depends on what has changed, as two tapes.

use std::collections::HashMap;

use super::Events;
use super::cells;
use super::layout::Layout;
use super::logic::{Lit, Logic};
use super::tape::{Part, Tape, emit};
use crate::batch::program::{Op, Program};

/// The code of what some events set off.
#[derive(Debug)]
pub(super) struct Round {
    /// What stores take.
    pub sampled: Tape,
    /// The planes of the edges that set it off, which are done with then.
    pub triggers: Vec<u32>,
    /// What depends on it.
    pub settled: Tape,
    /// Whether something may turn out to be x.
    pub guarded: bool,
    /// The watches at which edges may have come of it.
    pub watches: Vec<u32>,
}

/// The bits of a netlist as functions, while a tape is made.
struct Bits<'p> {
    p: &'p Program,
    logic: Logic,
    /// The bits that have been computed.
    now: HashMap<u32, Lit>,
}

impl Bits<'_> {
    fn get(&mut self, bit: u32) -> Lit {
        let computed = self.now.get(&bit).copied().or_else(|| Layout::constant(self.p, bit));
        computed.unwrap_or_else(|| self.logic.source(bit))
    }

    fn pins(&mut self, op: &Op) -> Vec<Vec<Lit>> {
        (0..op.pin_count as usize).map(|pin| self.p.pins(op, pin).iter().map(|&bit| self.get(bit)).collect()).collect()
    }
}

impl Round {
    pub fn new(p: &Program, layout: &Layout, events: Events) -> Round {
        let (sampled, triggers) = sampled(p, layout, events);
        let (settled, guarded) = settled(p, layout, events);
        let watches = p.watches.iter().enumerate();
        let watches = watches.filter(|(_, w)| layout.events[w.bit as usize] & events != 0).map(|w| w.0 as u32);
        Round { sampled, triggers, settled, guarded, watches: watches.collect() }
    }

    /// Planes that it needs for itself.
    pub fn scratch(&self) -> u32 {
        self.sampled.scratch.max(self.settled.scratch)
    }
}

fn sampled(p: &Program, layout: &Layout, events: Events) -> (Tape, Vec<u32>) {
    let mut bits = Bits { p, logic: Logic::default(), now: HashMap::new() };
    let mut roots = Vec::new();
    let mut triggers = Vec::new();
    for (store, clocks) in p.stores.iter().zip(&layout.clocks) {
        let mine: Vec<u32> = clocks.iter().filter(|c| c.1 & events != 0).map(|c| c.0).collect();
        if mine.is_empty() {
            continue;
        }
        let lanes: Vec<Lit> = mine.iter().map(|&plane| bits.logic.source(plane)).collect();
        let lanes = bits.logic.any(&lanes);
        let pins = bits.pins(&store.op);
        let q: Vec<Lit> = (0..store.op.width).map(|i| bits.get(store.q + i)).collect();
        let next = cells::sampled(&mut bits.logic, &p.cells[store.op.cell as usize], &pins, &q, lanes);
        roots.extend(next.into_iter().zip(store.q..));
        triggers.extend(mine);
    }
    triggers.sort_unstable();
    triggers.dedup();
    let end = bits.logic.nodes.len();
    (emit(&bits.logic, vec![Part { end, roots, pairs: None }], true, layout.scratch), triggers)
}

fn settled(p: &Program, layout: &Layout, events: Events) -> (Tape, bool) {
    let mut bits = Bits { p, logic: Logic::default(), now: HashMap::new() };
    let mut parts = Vec::new();
    let mut guard = Lit::FALSE;
    // what is stored at the end of a part
    let mut roots: Vec<(Lit, u32)> = Vec::new();
    let mut at = 0;
    while at < p.ops.len() {
        let op = &p.ops[at];
        if op.group != 0 {
            let group = &p.groups[op.group as usize - 1];
            at = group.ops.end;
            let outputs = || group.outputs.iter().flatten().copied();
            if outputs().all(|(_, bit)| layout.events[bit as usize] & events == 0) {
                continue;
            }
            parts.push(Part { end: bits.logic.nodes.len(), roots: std::mem::take(&mut roots), pairs: None });
            for op in &p.ops[group.ops.clone()] {
                let results = evaluated(&mut bits, op, &mut guard);
                for (bit, lit) in results {
                    roots.push((lit, bit));
                }
            }
            let pairs = Some(outputs().collect());
            parts.push(Part { end: bits.logic.nodes.len(), roots: std::mem::take(&mut roots), pairs });
            continue;
        }
        at += 1;
        let kind = &p.cells[op.cell as usize];
        let mut keep = |bits: &mut Bits<'_>, bit: u32, lit: Lit| {
            bits.now.insert(bit, lit);
            if layout.stored[bit as usize] {
                roots.push((lit, bit));
            }
        };
        if kind.init().is_some() {
            if layout.level_events(p, op) & events != 0 {
                let pins = bits.pins(op);
                let q = pins.last().cloned().unwrap_or_default();
                let q = cells::after_levels(&mut bits.logic, kind, &pins, &q);
                (op.outs[0]..).zip(q).for_each(|(bit, lit)| keep(&mut bits, bit, lit));
            }
            if op.derived && layout.derived_events(p, op) & events != 0 {
                let pins = bits.pins(op);
                let q = pins.last().cloned().unwrap_or_default();
                let y = cells::from_state(&mut bits.logic, kind, &pins, &q);
                (op.outs[1]..).zip(y).for_each(|(bit, lit)| keep(&mut bits, bit, lit));
            }
        } else if layout.events[op.outs[0] as usize] & events != 0 {
            for (bit, lit) in evaluated(&mut bits, op, &mut guard) {
                keep(&mut bits, bit, lit);
            }
        }
    }
    let guarded = guard != Lit::FALSE;
    if guarded {
        roots.push((guard, layout.guard));
    }
    parts.push(Part { end: bits.logic.nodes.len(), roots, pairs: None });
    (emit(&bits.logic, parts, false, layout.scratch), guarded)
}

/// All outputs of an operation.
fn evaluated(bits: &mut Bits<'_>, op: &Op, guard: &mut Lit) -> Vec<(u32, Lit)> {
    let kind = &bits.p.cells[op.cell as usize];
    let pins = bits.pins(op);
    let l = &mut bits.logic;
    let outputs = match pins.last() {
        Some(q) if kind.init().is_some() => {
            let q = cells::after_levels(l, kind, &pins, q);
            let derived = if op.derived { cells::from_state(l, kind, &pins, &q) } else { Vec::new() };
            vec![q, derived]
        }
        _ => cells::outputs(l, kind, &pins, guard),
    };
    op.outs.iter().zip(outputs).flat_map(|(&first, bits)| (first..).zip(bits)).collect()
}
