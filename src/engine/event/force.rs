//! Nets held at a value, and state that is set from outside.

use super::EventEngine;
use super::operands::written;
use super::program::{Program, flag};
use crate::Value;
use crate::cell::Memory;
use crate::cell::memory::merged;
use crate::event::eval::State;
use crate::force::{Held, Refused, is_state, may_deposit, may_force, spread};
use crate::netlist::{CellId, Driver, Slice};
use crate::value::Word;
use crate::value::word::words;

impl State {
    /// What a slot becomes that its driver makes `new`.
    #[cold]
    pub fn forced(&mut self, slot: u32, new: Word) -> Word {
        if self.meta[slot as usize].flags & flag::FORCED == 0 {
            return new;
        }
        let Some(held) = self.forces.get_mut(&slot) else { return new };
        held.driver = new;
        merged(new, held.mask, held.value)
    }

    /// Has the operations that write a slot run again: what acts by its level does so.
    fn act_again(&mut self, p: &Program, slot: u32) {
        for (number, _) in p.ops.iter().enumerate().filter(|(_, op)| written(p, op).contains(&slot)) {
            self.dirty[number / 64] |= 1 << (number % 64);
            self.summary[number / 64 / 64] |= 1 << (number / 64 % 64);
        }
    }
}

impl EventEngine {
    fn slot_of(&self, bits: Slice, word: usize) -> u32 {
        self.program.net_slot[bits.net.index()] + word as u32
    }

    pub(super) fn force_bits(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        may_force(&self.netlist, bits)?;
        for (word, mask, value) in spread(bits, value) {
            let slot = self.slot_of(bits, word);
            let now = self.state.slots[slot as usize];
            let held = self.state.forces.entry(slot).or_insert(Held { mask: 0, value: Word::ZERO, driver: now });
            held.value = merged(held.value, mask, value);
            held.mask |= mask;
            let driver = held.driver;
            self.state.meta[slot as usize].flags |= flag::FORCED;
            self.state.forcing = true;
            self.state.put(&self.program, slot, driver);
        }
        Ok(())
    }

    pub(super) fn release_bits(&mut self, bits: Slice) {
        let state = is_state(&self.netlist, bits.net);
        for (word, mask, _) in spread(bits, &vec![Word::ZERO; words(bits.width)]) {
            let slot = self.slot_of(bits, word);
            let Some(held) = self.state.forces.get_mut(&slot) else { continue };
            let released = held.mask & mask;
            held.mask &= !mask;
            let driver = if state { merged(held.driver, released, held.value) } else { held.driver };
            if held.mask == 0 {
                self.state.forces.remove(&slot);
                self.state.meta[slot as usize].flags &= !flag::FORCED;
                self.state.forcing = !self.state.forces.is_empty();
            }
            self.state.put(&self.program, slot, driver);
            if state {
                self.state.act_again(&self.program, slot);
            }
        }
    }

    /// An input that is driven while it is forced: what it is driven to is what it has afterwards.
    #[cold]
    pub(super) fn drive_forced(&mut self, slot: u32, value: &[Word]) {
        for (slot, &word) in (slot..).zip(value) {
            if let Some(held) = self.state.forces.get_mut(&slot) {
                held.driver = word;
            }
        }
    }

    pub(super) fn deposit_bits(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        may_deposit(&self.netlist, bits)?;
        for (word, mask, value) in spread(bits, value) {
            let slot = self.slot_of(bits, word);
            let new = merged(self.state.slots[slot as usize], mask, value);
            self.state.put(&self.program, slot, new);
            if !matches!(self.netlist.net(bits.net).driver, Driver::Input(_)) {
                self.state.act_again(&self.program, slot);
            }
        }
        Ok(())
    }

    pub(super) fn put_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool {
        let Some(number) = self.program.memories.iter().position(|m| m.cell == cell) else { return false };
        let memory = &self.program.memories[number];
        if index >= memory.kind.size {
            return false;
        }
        let contents = self.state.memories.contents_mut(number);
        Memory::set_word(memory.kind.width, contents, index, value, |_| true);
        self.state.wake(&self.program, memory.contents);
        self.state.wake(&self.program, memory.contents + 1);
        true
    }
}
