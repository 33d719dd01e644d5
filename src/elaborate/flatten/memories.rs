//! Memories: contents that are given beside the files, and pins that may be left open.

use super::super::Name;
use super::{Elaboration, Here};
use crate::Value;
use crate::cell::{CellKind, Memory};
use crate::diag::{Code, Diagnostic};
use crate::import::readmem::{self, Shape};
use crate::netlist::Bus;

impl Elaboration<'_> {
    /// Fills a memory from the text that was given for it, and connects the pins that it leaves open.
    pub(super) fn memory(&mut self, here: &Here<'_>, name: &Name, kind: &mut CellKind, pins: &mut [Bus]) {
        for (index, pin) in pins.iter_mut().enumerate().filter(|(_, pin)| pin.width() == 0) {
            if kind.input_width(index) > 0 && !kind.requires(index) {
                let level = if kind.inputs()[index].default { crate::Logic::One } else { crate::Logic::Zero };
                *pin = self.builder.constant(&Value::repeat(level, kind.input_width(index)));
            }
        }
        let CellKind::Memory(memory) = kind else { return };
        let path = self.builder.path(here.scope, name);
        let shape = Shape { width: memory.width, size: memory.size, offset: memory.offset };
        if let Some(given) = self.memories.iter_mut().find(|given| given.0.value == path) {
            given.2 = true;
            let mut init = memory.init.to_vec();
            readmem::read(self.sources.text(given.1), given.1, shape, &mut self.diagnostics, |index, value| {
                Memory::set_word(shape.width, &mut init, index, value, |_| true);
            });
            memory.init = init.into();
        }
        self.memory_paths.push(path);
    }

    /// Complains of contents for memories that are not there.
    pub(super) fn unknown_memories(&mut self) {
        for (name, ..) in self.memories.iter().filter(|given| !given.2) {
            let fault = Diagnostic::new(Code::UnknownMemory, format!("the circuit has no memory `{}`", name.value));
            let fault = fault.at(name.span, "not in the circuit");
            let fault = fault.did_you_mean(name, self.memory_paths.iter().map(String::as_str));
            self.diagnostics.push(fault.help("a memory is named by its path below the top module, as in `u1.mem`"));
        }
    }
}
