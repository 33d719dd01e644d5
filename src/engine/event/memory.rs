//! Memories: how they are laid out and run. Their words are in the state, beside the nets.
//!
//! A read port that does something without a clock is an operation, and so are all write ports without one together.
//! What ports with a clock do at an instant is computed once all edges of the instant are known.

use std::collections::HashSet;

use super::build::{BLANK, Build};
use super::eval::State;
use super::operands::part;
use super::program::{
    Code, ControlPin, MemoryCell, MemoryRead, MemoryWrite, ONE, Op, Operand, Pool, Program, Store, StoreCode, ZERO,
};
use crate::cell::memory::{ReadControls, Written, merged};
use crate::cell::pin::memory::{RD_ADDR, RD_ARST, RD_CLK, RD_EN, RD_SRST, WR_ADDR, WR_CLK, WR_DATA, WR_EN};
use crate::cell::{Edge, Memory};
use crate::netlist::{CellId, Slice};
use crate::value::Word;
use crate::value::word::{extract, mask, words};

impl Build<'_> {
    /// What a port has of a pin of which every port has `width` bits.
    fn port(&self, cell: CellId, pin: usize, port: usize, width: u32) -> Vec<Slice> {
        part(self.netlist.input(cell, pin), port as u32 * width, width)
    }

    /// At most 64 bits that a port has of a pin.
    fn port_operand(&mut self, cell: CellId, pin: usize, port: usize, width: u32) -> Operand {
        let slices = self.port(cell, pin, port, width);
        if slices.iter().all(|s| self.constants.is_zero(s)) { ZERO } else { self.operand(&slices) }
    }

    /// All that a port has of a pin, in words.
    fn port_words(&mut self, cell: CellId, pin: usize, port: usize, width: u32) -> Pool {
        let slices = self.port(cell, pin, port, width);
        let list: Vec<(Operand, u32)> = (0..width)
            .step_by(64)
            .map(|lo| {
                let n = (width - lo).min(64);
                (self.operand(&part(&slices, lo, n)), n)
            })
            .collect();
        let start = self.program.pool.len();
        self.program.pool.extend(list);
        start..self.program.pool.len()
    }

    /// Adds a memory, or only some read ports of one that may be there already, with operations for what they do without a
    /// clock.
    pub(super) fn memory(&mut self, cell: CellId, memory: &Memory, port: Option<u32>) {
        let first = !self.memories.contains_key(&cell);
        let number = match self.memories.get(&cell) {
            Some(&known) => known,
            None => self.add_memory(cell, memory),
        };
        let ext = number as u32;
        if first && memory.writes.iter().any(|w| w.clock.is_none()) {
            self.push(Op { code: Code::MemoryWrite, ext, ..BLANK });
        }
        for (at, spec) in memory.reads.iter().enumerate() {
            let now = spec.clock.is_none();
            // a port with a clock stands for all of them
            let is = |p: u32| if now { p == at as u32 } else { memory.reads[p as usize].clock.is_some() };
            let here = port.is_none_or(is);
            if !here {
                continue;
            }
            let arst = self.port_operand(cell, RD_ARST, at, 1);
            let address = if now { self.port_operand(cell, RD_ADDR, at, memory.abits) } else { ZERO };
            let read = &mut self.program.memories[number].reads[at];
            (read.arst, read.address) = (arst, address);
            if now || arst != ZERO {
                self.push(Op { code: Code::MemoryRead, ext, count: at as u32, ..BLANK });
            }
        }
    }

    /// A memory of which only what writes without a clock is connected.
    fn add_memory(&mut self, cell: CellId, memory: &Memory) -> usize {
        let number = self.program.memories.len();
        self.memories.insert(cell, number);
        let contents = self.program.initial.len() as u32;
        self.program.initial.extend([Word::ZERO; 2]);
        self.program.slot_net.extend([u32::MAX; 2]);
        let output = self.output(cell, 0);
        let read = |port: usize| {
            let at = port as u32 * memory.width;
            MemoryRead { en: ONE, arst: ZERO, srst: ZERO, address: ZERO, slot: output + at / 64, shift: at % 64 }
        };
        let reads = (0..memory.reads.len()).map(read).collect();
        let mut writes = Vec::new();
        for (port, spec) in memory.writes.iter().enumerate() {
            writes.push(match spec.clock {
                None => self.write_port(cell, memory, port),
                Some(_) => MemoryWrite { address: ZERO, data: 0..0, enable: 0..0 },
            });
        }
        self.program.memories.push(MemoryCell { cell, kind: Box::new(memory.clone()), contents, reads, writes });
        number
    }

    fn write_port(&mut self, cell: CellId, memory: &Memory, port: usize) -> MemoryWrite {
        MemoryWrite {
            address: self.port_operand(cell, WR_ADDR, port, memory.abits),
            data: self.port_words(cell, WR_DATA, port, memory.width),
            enable: self.port_words(cell, WR_EN, port, memory.width),
        }
    }

    /// The pins of a memory that only a clock edge reads, and the clocks themselves.
    pub(super) fn sampled_memory(&mut self, cell: CellId, number: usize) {
        let memory = self.program.memories[number].kind.clone();
        for (port, spec) in memory.reads.iter().enumerate() {
            let Some(edge) = spec.clock else { continue };
            let address = self.port_operand(cell, RD_ADDR, port, memory.abits);
            let (en, srst) = (self.port_operand(cell, RD_EN, port, 1), self.port_operand(cell, RD_SRST, port, 1));
            let read = &mut self.program.memories[number].reads[port];
            (read.address, read.en, read.srst) = (address, en, srst);
            self.memory_clock(cell, RD_CLK, port, edge, number, port);
        }
        for (port, spec) in memory.writes.iter().enumerate() {
            let Some(edge) = spec.clock else { continue };
            self.program.memories[number].writes[port] = self.write_port(cell, &memory, port);
            self.memory_clock(cell, WR_CLK, port, edge, number, memory.reads.len() + port);
        }
    }

    fn memory_clock(&mut self, cell: CellId, pin: usize, bit: usize, edge: Edge, number: usize, port: usize) {
        let Some(at) = self.direct(&self.port(cell, pin, bit, 1)) else { return };
        let store = self.program.stores.len() as u32;
        self.program.stores.push(Store::of_memory(number as u32, port as u32));
        let clock = self.clock(at, false);
        if edge == Edge::Rising { &mut clock.rising } else { &mut clock.falling }.push(store);
    }

    /// The bits of a memory's pins whose unknown values are reported.
    pub(super) fn memory_controls(&mut self, cell: CellId, memory: &Memory) {
        let mut seen = HashSet::new();
        for pin in [RD_CLK, RD_EN, RD_ARST, RD_SRST, WR_CLK, WR_EN] {
            let slices = self.netlist.input(cell, pin);
            let bits = slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| Slice { lo, width: 1, ..*s }));
            for (bit, slice) in bits.enumerate() {
                let watched = match pin {
                    RD_ARST | WR_EN => true,
                    WR_CLK => memory.writes[bit].clock.is_some(),
                    _ => memory.reads[bit].clock.is_some(),
                };
                if let Some(o) = self.direct(&[slice]).filter(|o| watched && seen.insert((pin, o.slot, o.shift))) {
                    let pin = self.netlist.cell(cell).kind.inputs()[pin].name;
                    let control = ControlPin { slot: o.slot, shift: o.shift, cell, pin, net: slice.net };
                    self.program.controls.push(control);
                }
            }
        }
    }
}

impl Store {
    /// The clock of a port of a memory.
    fn of_memory(number: u32, port: u32) -> Store {
        Store { code: StoreCode::Memory, q: port, general: number, ..Store::BLANK }
    }
}

/// A change of some bits of a machine word of some contents, at the end of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Put {
    memory: u32,
    at: u32,
    bits: u64,
    word: Word,
    /// Whether a port with a clock wrote it.
    clocked: bool,
}

/// What memories hold and what is to become of it.
#[derive(Debug)]
pub(super) struct Memories {
    /// The contents of each.
    contents: Vec<Vec<Word>>,
    /// (memory, port) of the clocks that have made their edge, those that write after those that read.
    pub edges: Vec<(u32, u32)>,
    puts: Vec<Put>,
    /// Some bits of a slot that wait until all of a step have been computed.
    pub parts: Vec<(u32, u64, Word)>,
    /// What a port reads, and what all ports of a memory write.
    word: Vec<Word>,
    data: Vec<Word>,
    enable: Vec<Word>,
    addresses: Vec<Word>,
}

impl Memories {
    pub fn new(p: &Program) -> Memories {
        let most = |f: fn(&MemoryCell) -> usize| p.memories.iter().map(f).max().unwrap_or(0);
        let written = most(|m| words(m.kind.width) * m.writes.len());
        let ports: usize = p.memories.iter().map(|m| m.reads.len() + m.writes.len()).sum();
        Memories {
            contents: p.memories.iter().map(|m| m.kind.init.to_vec()).collect(),
            edges: Vec::with_capacity(ports),
            puts: Vec::with_capacity(p.memories.iter().map(|m| words(m.kind.width) * m.writes.len()).sum()),
            parts: Vec::with_capacity(p.memories.iter().map(|m| (words(m.kind.width) + 1) * m.reads.len()).sum()),
            word: vec![Word::ZERO; most(|m| words(m.kind.width))],
            data: vec![Word::ZERO; written],
            enable: vec![Word::ZERO; written],
            addresses: vec![Word::ZERO; most(|m| m.writes.len())],
        }
    }
}

impl Memories {
    /// The bytes of all contents.
    pub fn bytes(&self) -> usize {
        self.contents.iter().map(|words| size_of_val(&**words)).sum()
    }

    /// What the memory of a number holds.
    pub fn contents(&self, number: usize) -> &[Word] {
        &self.contents[number]
    }

    /// What the memory of a number is to hold.
    pub fn contents_mut(&mut self, number: usize) -> &mut Vec<Word> {
        &mut self.contents[number]
    }

    /// Forgets what was staged.
    pub fn forget(&mut self) {
        self.edges.clear();
        self.puts.clear();
        self.parts.clear();
    }

    /// Whether any contents are to change.
    pub fn writes(&self) -> bool {
        !self.puts.is_empty()
    }

    /// Whether anything was staged.
    #[inline(always)]
    pub fn is_waiting(&self) -> bool {
        !(self.puts.is_empty() && self.parts.is_empty())
    }
}

impl State {
    /// What a read port does without a clock.
    pub(super) fn memory_read<const STAGED: bool>(&mut self, p: &Program, op: &Op) {
        let (cell, port) = (&p.memories[op.ext as usize], op.count as usize);
        let (memory, read) = (&cell.kind, &cell.reads[port]);
        let n = words(memory.width);
        let mut word = std::mem::take(&mut self.memories.word);
        let q = &mut word[..n];
        match memory.reads[port].clock {
            None => {
                let address = self.read(read.address, mask(memory.abits));
                memory.read(&self.memories.contents[op.ext as usize], address, q);
            }
            Some(_) => self.held(read, memory.width, q),
        }
        memory.reset(port, self.read(read.arst, 1), q);
        self.give::<STAGED>(p, read, memory.width, q);
        self.memories.word = word;
    }

    /// What a read port gives now.
    fn held(&self, read: &MemoryRead, width: u32, q: &mut [Word]) {
        extract(q, &self.slots[read.slot as usize..], read.shift, width);
    }

    /// Writes what a read port gives to its slots, of which other ports may have some bits.
    fn give<const STAGED: bool>(&mut self, p: &Program, read: &MemoryRead, width: u32, q: &[Word]) {
        let mut done = 0;
        while done < width {
            let (at, shift) = ((read.shift + done) / 64, (read.shift + done) % 64);
            let n = (width - done).min(64 - shift);
            let mut w = [Word::ZERO];
            extract(&mut w, q, done, n);
            let (slot, bits) = (read.slot + at, mask(n) << shift);
            let new = Word { v: w[0].v << shift, u: w[0].u << shift };
            if STAGED {
                self.memories.parts.push((slot, bits, new));
            } else {
                self.put(p, slot, merged(self.slots[slot as usize], bits, new));
            }
            done += n;
        }
    }

    /// Reads what a port writes into the place of number `k`.
    fn gather_write(&self, p: &Program, write: &MemoryWrite, k: usize, data: &mut [Word], enable: &mut [Word]) {
        for (words, to) in [(&write.data, data), (&write.enable, enable)] {
            let n = words.len();
            let list = p.pool[words.clone()].iter();
            list.zip(&mut to[k * n..]).for_each(|(&(o, width), to)| *to = self.read(o, mask(width)));
        }
    }

    /// What write ports without a clock do.
    pub(super) fn memory_write<const STAGED: bool>(&mut self, p: &Program, op: &Op) {
        let cell = &p.memories[op.ext as usize];
        let n = words(cell.kind.width);
        let (mut data, mut enable) =
            (std::mem::take(&mut self.memories.data), std::mem::take(&mut self.memories.enable));
        for (_, write) in cell.kind.writes.iter().zip(&cell.writes).filter(|w| w.0.clock.is_none()) {
            self.gather_write(p, write, 0, &mut data, &mut enable);
            let address = self.read(write.address, mask(cell.kind.abits));
            let puts = &mut self.memories.puts;
            cell.kind.write(address, &data[..n], &enable[..n], |at, bits, word| {
                puts.push(Put { memory: op.ext, at: at as u32, bits, word, clocked: false });
            });
        }
        (self.memories.data, self.memories.enable) = (data, enable);
        if !STAGED {
            self.take_memories(p);
        }
    }

    /// Computes what the ports whose clocks have made their edge read and write, for [`State::take`].
    pub(super) fn sample_memories(&mut self, p: &Program) {
        let mut edges = std::mem::take(&mut self.memories.edges);
        let (mut data, mut enable) =
            (std::mem::take(&mut self.memories.data), std::mem::take(&mut self.memories.enable));
        let mut word = std::mem::take(&mut self.memories.word);
        let mut addresses = std::mem::take(&mut self.memories.addresses);
        edges.sort_unstable();
        edges.dedup();
        for ports in edges.chunk_by(|a, b| a.0 == b.0) {
            let number = ports[0].0;
            let cell = &p.memories[number as usize];
            let (memory, n) = (&cell.kind, words(cell.kind.width));
            let (reads, writes) = ports.split_at(ports.partition_point(|e| (e.1 as usize) < cell.reads.len()));
            let port = |e: &(u32, u32)| e.1 as usize - cell.reads.len();
            for (k, e) in writes.iter().enumerate() {
                let write = &cell.writes[port(e)];
                self.gather_write(p, write, k, &mut data, &mut enable);
                addresses[k] = self.read(write.address, mask(memory.abits));
            }
            let written = |(k, e): (usize, &(u32, u32))| Written {
                port: port(e),
                address: addresses[k],
                data: &data[k * n..(k + 1) * n],
                enable: &enable[k * n..(k + 1) * n],
            };
            for w in writes.iter().enumerate().map(written) {
                let puts = &mut self.memories.puts;
                memory.write(w.address, w.data, w.enable, |at, bits, word| {
                    puts.push(Put { memory: number, at: at as u32, bits, word, clocked: true });
                });
            }
            for e in reads {
                let read = &cell.reads[e.1 as usize];
                let q = &mut word[..n];
                self.held(read, memory.width, q);
                let c = ReadControls {
                    en: self.read(read.en, 1),
                    arst: self.read(read.arst, 1),
                    srst: self.read(read.srst, 1),
                };
                let contents = &self.memories.contents[number as usize];
                let at = self.read(read.address, mask(memory.abits));
                memory.clocked(e.1 as usize, contents, c, at, writes.iter().enumerate().map(written), q);
                self.give::<true>(p, read, memory.width, q);
            }
        }
        edges.clear();
        self.memories.edges = edges;
        (self.memories.data, self.memories.enable) = (data, enable);
        (self.memories.word, self.memories.addresses) = (word, addresses);
    }

    /// Writes what was staged for memories.
    pub(super) fn take_memories(&mut self, p: &Program) {
        for i in 0..self.memories.parts.len() {
            let (slot, bits, new) = self.memories.parts[i];
            self.put(p, slot, merged(self.slots[slot as usize], bits, new));
        }
        self.memories.parts.clear();
        for i in 0..self.memories.puts.len() {
            let Put { memory, at, bits, word, clocked } = self.memories.puts[i];
            let to = &mut self.memories.contents[memory as usize][at as usize];
            let new = merged(*to, bits, word);
            if *to != new {
                *to = new;
                let slot = p.memories[memory as usize].contents;
                // so that a loop through the contents is not taken for one that has come back to where it was
                self.slots[slot as usize].v = self.slots[slot as usize].v.wrapping_add(1);
                self.wake(p, slot);
                if clocked {
                    self.wake(p, slot + 1);
                }
            }
        }
        self.memories.puts.clear();
    }
}
