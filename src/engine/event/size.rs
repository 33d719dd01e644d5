//! How much memory the event engine takes.

use std::mem::size_of_val;

use super::EventEngine;
use super::eval::State;
use super::program::{MemoryCell, Program};

impl EventEngine {
    /// The bytes of what grows with the netlist: the program and the present values, without what is to come.
    pub(super) fn bytes(&self) -> usize {
        program(&self.program) + state(&self.state) + size_of_val(&*self.widths)
    }
}

fn program(p: &Program) -> usize {
    let general = p.generals.iter().map(|g| {
        size_of_val(g)
            + size_of_val(&*g.pins)
            + g.pins.iter().map(|pin| size_of_val(&**pin)).sum::<usize>()
            + size_of_val(&*g.outputs)
    });
    let memory = |m: &MemoryCell| size_of_val(m) + size_of_val(&*m.reads) + size_of_val(&*m.writes);
    let clocks = p.clocks.iter().map(|c| {
        size_of_val(c) + [&c.rising, &c.falling, &c.unknown].into_iter().map(|list| size_of_val(&**list)).sum::<usize>()
    });
    let narrow = p.narrows.iter().map(|n| size_of_val(n) + size_of_val(&*n.outputs));
    let groups = p.group_slots.iter().map(|list| size_of_val(&**list));
    let groups = groups.chain(p.group_gathers.iter().map(|list| size_of_val(&**list)));
    let operations = size_of_val(&*p.ops) + size_of_val(&*p.pool) + size_of_val(&*p.stores) + size_of_val(&*p.wakes);
    let nets = size_of_val(&*p.net_slot)
        + size_of_val(&*p.slot_net)
        + size_of_val(&*p.used)
        + size_of_val(&*p.meta)
        + size_of_val(&*p.initial);
    let hooks = size_of_val(&*p.hooks) + size_of_val(&*p.hooked) + size_of_val(&*p.controls) + size_of_val(&*p.delays);
    operations
        + nets
        + hooks
        + size_of_val(&*p.groups)
        + general.chain(clocks).chain(narrow).chain(groups).sum::<usize>()
        + p.memories.iter().map(memory).sum::<usize>()
}

fn state(s: &State) -> usize {
    let reported = size_of_val(&*s.control_seen) + size_of_val(&*s.reported);
    let wakes = size_of_val(&*s.meta) + size_of_val(&*s.dirty) + size_of_val(&*s.summary);
    size_of_val(&*s.slots) + wakes + size_of_val(&*s.watches) + reported + s.memories.bytes()
}
