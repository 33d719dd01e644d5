//! From clocked cells to stores, the clocks that they look at, and the controls whose unknown values are reported.

use super::build::{BLANK, Build};
use super::program::{ClockPin, Code, ControlPin, Op, Operand, Store, StoreCode};
use crate::cell::pin::{accumulator, counter, flop};
use crate::cell::{CellKind, Edge, Role, Storage};
use crate::netlist::CellId;
use crate::value::word::mask;

impl Build<'_> {
    /// A clocked cell: its store, and an operation for what it does without a clock, if it does anything.
    pub(super) fn store(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let width = kind.output_width(0);
        let derives = kind.outputs().len() > 1;
        let derived_used = derives && self.used[netlist.output(cell, 1).index()];
        let acts = |pin: usize| self.acts(cell, pin);
        let level = derived_used || kind.inputs().iter().enumerate().any(|(i, p)| p.role == Role::Level && acts(i));
        let mut store = Store {
            q: self.output(cell, 0),
            derived: if derives { self.output(cell, 1) } else { 0 },
            width,
            ..Store::BLANK
        };
        let word = |v: &crate::Value| v.words().next().unwrap_or_default();
        let narrow = kind.storage().filter(|_| width <= 64);
        // what it does without a clock comes before it samples, and so do its pins
        let at_once: &[usize] = match narrow {
            Some(Storage::Flop(f)) => {
                store.code = match [flop::ALOAD, flop::SYNC_SET, flop::SYNC_RESET].into_iter().any(acts) {
                    false if ![flop::SET, flop::RESET].into_iter().any(acts) => StoreCode::Plain,
                    false if netlist.input(cell, flop::EN).is_empty() => StoreCode::SetReset,
                    _ => StoreCode::Flop,
                };
                (store.set_value, store.reset_value) = (word(&f.set_value), word(&f.reset_value));
                match acts(flop::ALOAD) {
                    true => &[flop::ALOAD, flop::SET, flop::RESET, flop::D],
                    false => &[flop::ALOAD, flop::SET, flop::RESET],
                }
            }
            Some(Storage::Counter(c)) => {
                store.code = StoreCode::Counter;
                store.set_value = word(&c.step);
                match acts(counter::ALOAD) {
                    true => &[counter::ALOAD, counter::RESET, counter::D],
                    false => &[counter::ALOAD, counter::RESET],
                }
            }
            Some(Storage::Accumulator(_)) => {
                store.code = StoreCode::Accumulator;
                &[accumulator::D, accumulator::CI, accumulator::RESET]
            }
            Some(Storage::EdgeFlop(_) | Storage::Sr { .. } | Storage::Latch(_)) | None => {
                store.general = self.general(cell);
                let ext = store.general;
                self.program.stores.push(store);
                if level {
                    self.push(Op { code: Code::General, ext, ..BLANK });
                }
                return;
            }
        };
        at_once.iter().for_each(|&pin| store.pins[pin] = self.pin(cell, pin));
        let (y, y2, a, b) = (store.q, store.derived, store.pins[flop::SET], store.pins[flop::RESET]);
        let code = match store.code {
            StoreCode::SetReset if !derived_used => Code::SetReset,
            _ => Code::Level,
        };
        self.program.stores.push(store);
        if level {
            let ext = self.program.stores.len() as u32 - 1;
            let op = Op { y, y2, mask: mask(width), ext, count: derived_used.into(), ..BLANK };
            self.push(if code == Code::SetReset { Op { code, a, b, ..op } } else { Op { code, ..op } });
        }
    }

    /// The pins of a store that only a clock edge reads, and the clock itself.
    pub(super) fn sampled(&mut self, cell: CellId, number: usize) {
        let kind = &self.netlist.cell(cell).kind;
        if self.program.stores[number].code != StoreCode::General {
            for (pin, spec) in kind.inputs().iter().enumerate().filter(|p| p.1.role != Role::Clock) {
                // the others are there
                if spec.role != Role::Level {
                    self.program.stores[number].pins[pin] = self.pin(cell, pin);
                }
            }
        }
        for (pin, spec) in kind.inputs().iter().enumerate() {
            let Some(operand) = self.bit(cell, pin) else { continue };
            let number = number as u32;
            match spec.role {
                Role::Clock => {
                    let rising = kind.edge() == Some(Edge::Rising);
                    let clock = self.clock(operand, false);
                    if rising { &mut clock.rising } else { &mut clock.falling }.push(number);
                }
                Role::Level => self.clock(operand, false).unknown.push(number),
                Role::Trigger => self.clock(operand, true).rising.push(number),
                _ => {}
            }
        }
    }

    /// A connected pin of one bit.
    fn bit(&self, cell: CellId, pin: usize) -> Option<Operand> {
        let slices = self.netlist.input(cell, pin);
        if self.netlist.cell(cell).kind.input_width(pin) == 1 { self.direct(slices) } else { None }
    }

    pub(super) fn clock(&mut self, at: Operand, level: bool) -> &mut ClockPin {
        let clocks = &mut self.program.clocks;
        let number = *self.clock_of.entry((at.slot, at.shift, level)).or_insert_with(|| {
            let (rising, falling, unknown) = (vec![], vec![], vec![]);
            clocks.push(ClockPin { slot: at.slot, shift: at.shift, level, rising, falling, unknown });
            clocks.len() as u32 - 1
        });
        &mut clocks[number as usize]
    }

    /// The pins whose unknown values are reported.
    pub(super) fn controls(&mut self) {
        for cell in self.netlist.cell_ids() {
            let kind = &self.netlist.cell(cell).kind;
            if kind.init().is_none() {
                continue;
            }
            if let CellKind::Memory(memory) = kind {
                self.memory_controls(cell, memory);
                continue;
            }
            for (pin, spec) in kind.inputs().iter().enumerate() {
                let watched = matches!(spec.role, Role::Clock | Role::Level | Role::Trigger | Role::Enable);
                if let Some(o) = self.bit(cell, pin).filter(|_| watched) {
                    let net = self.netlist.input(cell, pin)[0].net;
                    self.program.controls.push(ControlPin { slot: o.slot, shift: o.shift, cell, pin: spec.name, net });
                }
            }
        }
    }
}
