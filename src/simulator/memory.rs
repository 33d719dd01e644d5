//! Memories by name, word by word.

use super::{IntoValue, MemoryHandle, Simulator, SimulatorError};
use crate::Value;
use crate::cell::{CellKind, Memory};
use crate::netlist::CellId;

impl Simulator {
    /// The memories of the circuit, by their paths.
    pub fn memories(&self) -> impl Iterator<Item = String> + '_ {
        self.memory_cells().map(|cell| self.netlist.cell_path(cell))
    }

    fn memory_cells(&self) -> impl Iterator<Item = CellId> + '_ {
        self.netlist.cell_ids().filter(|&cell| matches!(self.netlist.cell(cell).kind, CellKind::Memory(_)))
    }

    /// The memory of a name, which is its path below the top module.
    ///
    /// # Errors
    /// If the circuit has no such memory.
    pub fn memory(&self, name: &str) -> Result<MemoryHandle, SimulatorError> {
        let found = self.memory_cells().find(|&cell| self.netlist.cell_path(cell) == name);
        let Some((cell, CellKind::Memory(m))) = found.map(|cell| (cell, &self.netlist.cell(cell).kind)) else {
            return Err(SimulatorError::NoMemory { name: name.to_owned(), memories: self.memories().collect() });
        };
        Ok(MemoryHandle {
            of: self.netlist.identity(),
            name: name.to_owned(),
            cell,
            width: m.width,
            size: m.size,
            offset: m.offset.into(),
        })
    }

    /// The number of a word, if the memory is of this circuit and has one at the address.
    fn word_of(&self, memory: &MemoryHandle, address: i64) -> Result<u32, SimulatorError> {
        if memory.of != self.netlist.identity() {
            return Err(SimulatorError::Foreign(format!("memory `{}`", memory.name)));
        }
        let index = address.checked_sub(memory.offset).and_then(|index| u32::try_from(index).ok());
        index.filter(|&index| index < memory.size).ok_or_else(|| {
            let addresses = memory.addresses();
            let addresses = (addresses.start, addresses.end - 1);
            SimulatorError::NoWord { memory: memory.name.clone(), address, addresses }
        })
    }

    fn unread(memory: &MemoryHandle) -> SimulatorError {
        SimulatorError::Refused(format!("nothing reads memory `{}`, so it is not simulated", memory.name))
    }

    /// The word of a memory at an address.
    ///
    /// # Errors
    /// If there is no word at it, or nothing in the circuit reads the memory.
    pub fn read_memory(&self, memory: &MemoryHandle, address: i64) -> Result<Value, SimulatorError> {
        let index = self.word_of(memory, address)?;
        let contents = self.engine.contents(memory.cell).ok_or_else(|| Simulator::unread(memory))?;
        Ok(Memory::word(memory.width, contents, index))
    }

    /// Sets the word of a memory at an address. It takes effect at the next [`settle`](Simulator::settle) or
    /// [`tick`](Simulator::tick).
    ///
    /// # Errors
    /// If there is no word at it, the value does not fit, or nothing in the circuit reads the memory.
    pub fn write_memory(
        &mut self,
        memory: &MemoryHandle,
        address: i64,
        value: impl IntoValue,
    ) -> Result<(), SimulatorError> {
        let index = self.word_of(memory, address)?;
        let value = value.into_value(memory.width);
        let value = value.map_err(|why| SimulatorError::BadValue { name: memory.name.clone(), why })?;
        match self.engine.set_contents(memory.cell, index, &value) {
            true => Ok(()),
            false => Err(Simulator::unread(memory)),
        }
    }
}
