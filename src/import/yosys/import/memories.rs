//! The memories of a circuit: how much they hold, and what they are given to hold at first.

use super::Import;
use crate::cell::Memory;
use crate::diag::{Code, Diagnostic};
use crate::import::readmem::{self, Shape};
use crate::value::Word;

impl Import<'_, '_> {
    /// Complains of contents for memories that are not there.
    pub(super) fn unknown_memories(&mut self) {
        for c in self.contents.iter().filter(|c| !self.memories.iter().any(|m| m == c.name)) {
            let fault = Diagnostic::new(Code::UnknownMemory, format!("the circuit has no memory `{}`", c.name));
            let fault = fault.at(c.span, "not in the circuit");
            let fault = match &self.memories[..] {
                [] => fault.help("there is none at all: Yosys may have made flip-flops of them (`memory_map`)"),
                all => fault.did_you_mean(c.name, all.iter().map(String::as_str)),
            };
            self.diagnostics.push(fault.help("a memory is named by its path below the top module, as in `u1.mem`"));
        }
    }

    /// Registers a memory, and puts what it is to hold in place of what it holds at first.
    pub fn fill_memory(&mut self, path: String, shape: Shape, init: &mut [Word]) {
        let contents = self.contents;
        for c in contents.iter().filter(|c| c.name == path) {
            readmem::read(c.text, c.file, shape, &mut self.diagnostics, |index, value| {
                Memory::set_word(shape.width, init, index, value, |_| true);
            });
        }
        self.memories.push(path);
    }

    /// Counts the bits of a memory; returns whether there is room for them.
    pub fn take_memory(&mut self, cell: &str, bits: u64) -> bool {
        self.memory_bits = self.memory_bits.saturating_add(bits);
        if self.memory_bits > self.limits.bits {
            self.too_large("bits", "bits in memories", self.limits.bits, self.span_of(cell));
        }
        self.memory_bits <= self.limits.bits
    }
}
