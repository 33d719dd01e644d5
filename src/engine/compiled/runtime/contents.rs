//! What memories hold, where partitions run: read and write ports whose clock has made its edge act by `cell::memory`.

use crate::Snapshot;
use crate::cell::memory::{ReadControls, Written, merged};
use crate::cell::{CellKind, Memory};
use crate::compiled::runtime::{CompiledEngine, word_of};
use crate::netlist::{CellId, NetId, Netlist};
use crate::value::Word;
use crate::value::word::{extract, words};

use crate::compiled::lower::layout::{Part, Stored};

/// The memory that a cell is.
fn memory_of(netlist: &Netlist, cell: CellId) -> &Memory {
    let CellKind::Memory(memory) = &netlist.cell(cell).kind else { unreachable!("only memories have ports") };
    memory
}

impl CompiledEngine {
    /// What the read ports among those that have made their edge take, and then what the write ports write.
    pub(crate) fn commit_ports(&mut self) {
        let mut ports: Vec<u32> = self.settling.active.iter().copied().filter(|&n| self.is_port(n)).collect();
        ports.sort_unstable();
        ports.dedup();
        let netlist = self.netlist.clone();
        let mut rest = &ports[..];
        while let Some(&first) = rest.first() {
            let cell = self.stored(first).cell;
            let (of_one, after) = rest.split_at(rest.partition_point(|&n| self.stored(n).cell <= cell));
            rest = after;
            let memory = memory_of(&netlist, cell);
            let reads = of_one.iter().copied().filter(|&n| matches!(self.stored(n).part, Part::Read(_)));
            let taken: Vec<(Stored, Vec<Word>)> =
                reads.map(|n| (self.stored(n), self.port_reads(self.stored(n), of_one))).collect();
            let mut puts = Vec::new();
            for w in self.written(memory, of_one) {
                memory.write(w.address, w.data, w.enable, |at, bits, word| puts.push((at, bits, word)));
            }
            for (s, new) in taken {
                for (slot, word) in s.slot.up().zip(new) {
                    let word = self.fixed(slot, word);
                    self.put(slot, s.net, word);
                }
            }
            self.write(cell, &puts);
        }
    }

    pub(crate) fn stored(&self, number: u32) -> Stored {
        self.layout.stored[number as usize]
    }

    pub(crate) fn is_port(&self, number: u32) -> bool {
        self.stored(number).part != Part::Whole
    }

    /// What a read port that has made its edge has after it, where `ports` are all of its memory that have.
    pub(crate) fn port_reads(&self, s: Stored, ports: &[u32]) -> Vec<Word> {
        let memory = memory_of(&self.netlist, s.cell);
        let Part::Read(port) = s.part else { unreachable!("it reads") };
        let stage = &self.memory[s.stage.index()..];
        let c = ReadControls { en: stage[0], arst: stage[1], srst: stage[2] };
        let mut q = self.memory[s.slot.index()..][..s.words as usize].to_vec();
        let contents = self.held_contents(s.cell).expect("it is a memory");
        memory.clocked(port as usize, contents, c, stage[3], self.written(memory, ports), &mut q);
        q
    }

    /// Goes on from what memories held in a saved state, and from what their read ports had; `net` has the value of a net.
    pub(crate) fn take_contents<'s>(&mut self, from: &Snapshot, net: impl Fn(NetId) -> &'s [Word]) {
        for i in 0..self.layout.memories.len() {
            let place = &self.layout.memories[i];
            let memory = memory_of(&self.netlist, place.cell);
            if let Some((_, given)) = from.contents.iter().find(|c| c.0 == place.cell) {
                self.memory[place.contents.index()..][..place.len as usize].copy_from_slice(given);
            }
            let q = net(self.netlist.output(place.cell, 0));
            for (port, slot) in (0..).zip(&place.ports) {
                let Some(slot) = *slot else { continue };
                let to = &mut self.memory[slot.index()..][..words(memory.width)];
                extract(to, q, port * memory.width, memory.width);
            }
        }
    }

    /// What a memory holds, laid out as [`Memory::contents`]; none of a cell that is no memory.
    pub(crate) fn held_contents(&self, cell: CellId) -> Option<&[Word]> {
        let place = &self.layout.memories[*self.layout.memory_of.get(&cell)?];
        Some(&self.memory[place.contents.index()..][..place.len as usize])
    }

    /// What the write ports among some of a memory write.
    fn written<'a>(&'a self, memory: &Memory, ports: &'a [u32]) -> impl Iterator<Item = Written<'a>> {
        let n = words(memory.width);
        ports.iter().filter_map(move |&number| {
            let s = self.stored(number);
            let Part::Write(port) = s.part else { return None };
            let stage = &self.memory[s.stage.index()..][..1 + 2 * n];
            let (data, enable) = stage[1..].split_at(n);
            Some(Written { port: port as usize, address: stage[0], data, enable })
        })
    }

    /// Changes words of the contents of a memory; wakes what reads them.
    fn write(&mut self, cell: CellId, puts: &[(usize, u64, Word)]) {
        let number = self.layout.memory_of[&cell];
        let first = self.layout.memories[number].contents.index();
        let mut changed = false;
        for &(at, bits, new) in puts {
            let to = &mut self.memory[first + at];
            let new = merged(*to, bits, new);
            changed |= std::mem::replace(to, new) != new;
        }
        if let Some(variant) = self.variants.current.filter(|_| changed).map(|n| &self.variants.list[n]) {
            for &(word, bits) in &variant.memory_wakes[number] {
                *word_of(&mut self.memory, variant.dirty + word) |= bits;
            }
        }
    }
}
