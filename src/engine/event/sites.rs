//! Where operations stand, as the meaning of cells sees them: operands of one word each.

use super::eval::State;
use super::program::Store;
use crate::cell::pin::flop;
use crate::cell::{Site, Words};
use crate::value::Word;

/// The operands of an operation, read before, with a state if it has one.
pub(super) struct Operation {
    ins: [Word; 3],
    pub q: Word,
    pub outs: [Word; 2],
}

impl Operation {
    #[inline(always)]
    pub fn new(ins: [Word; 3], q: Word) -> Operation {
        Operation { ins, q, outs: [Word::ZERO; 2] }
    }
}

impl Site<Words> for Operation {
    #[inline(always)]
    fn get(&self, pin: usize, _: usize) -> Word {
        self.ins[pin]
    }

    #[inline(always)]
    fn state(&self, _: usize) -> Word {
        self.q
    }

    #[inline(always)]
    fn put(&mut self, output: usize, _: usize, w: Word) {
        self.outs[output] = w;
    }

    #[inline(always)]
    fn hold(&mut self) {
        self.outs[0] = self.q;
    }
}

/// All pins of a store.
pub(super) const EVERY: u32 = u32::MAX;

/// A store, of whose pins those of `PINS` are looked at; the others are a flip-flop's that are not connected.
pub(super) struct Stored<'s, const PINS: u32> {
    state: &'s State,
    store: &'s Store,
    mask: u64,
    pub q: Word,
    pub next: Word,
    pub derived: Word,
}

impl<'s, const PINS: u32> Stored<'s, PINS> {
    #[inline(always)]
    pub fn new(state: &'s State, store: &'s Store, mask: u64) -> Stored<'s, PINS> {
        let q = state.slots[store.q as usize];
        Stored { state, store, mask, q, next: q, derived: Word::ZERO }
    }
}

impl<const PINS: u32> Site<Words> for Stored<'_, PINS> {
    #[inline(always)]
    fn get(&self, pin: usize, _: usize) -> Word {
        // data has the same place in all of them
        match pin {
            _ if PINS >> pin & 1 == 0 => Word::known(u64::from(pin == flop::EN)),
            flop::D => self.state.read(self.store.pins[flop::D], self.mask),
            pin => self.state.control(self.store.pins[pin]),
        }
    }

    #[inline(always)]
    fn state(&self, _: usize) -> Word {
        self.q
    }

    #[inline(always)]
    fn put(&mut self, output: usize, _: usize, w: Word) {
        if output == 0 {
            self.next = w;
        } else {
            self.derived = w;
        }
    }

    #[inline(always)]
    fn hold(&mut self) {
        self.next = self.q;
    }
}

// the data pin of all stores is that of a flip-flop
const _: () = assert!(crate::cell::pin::counter::D == flop::D && crate::cell::pin::accumulator::D == flop::D);
