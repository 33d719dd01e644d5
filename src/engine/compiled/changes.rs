//! What has changed, written down by the ticks themselves: a run whose nets are traced stays in the loop of its clock.
//!
//! A tick appends a record (see [`value::changes`](crate::value::changes)) to a list in memory: each value goes where the
//! next one belongs, and only if it is another than before does the next one go behind it. So there is no branch, and
//! nothing is left to be compared. Waves that are made in chunks have their changes written down here.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{InstBuilder, Value, types};

use super::emit::{Emit, offset, trusted};
use super::form::Wanted;
use super::graph::{Id, Map};
use super::plan::{Half, Store};
use super::{CompiledEngine, half};
use crate::engine::{Field, Log};
use crate::netlist::NetId;
use crate::value::Word;
use crate::value::changes::{self, Written};
use crate::value::word::words;

/// How many words of records generated code has room for.
pub(super) const ROOM: usize = 1 << 15;
/// Words with which the log counts as long.
const LONG: usize = ROOM / 2;

/// What lies before the records: the bytes from the beginning of the memory to the end of the records, the tick of the
/// next one, how long the input then stays 0, and how long 1.
const END: Half = 0;
const TIME: Half = 1;
const WAIT: Half = 2;
const RECORDS: Half = 4;

/// When ticks happen that follow each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    pub first: u64,
    /// How long the input stays 0.
    pub low: u64,
    /// How long it stays 1.
    pub high: u64,
}

/// Numbers of observed nets, each once.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    bits: Vec<u64>,
    any: bool,
}

impl Numbers {
    #[inline(always)]
    pub fn insert(&mut self, number: usize) {
        if self.bits.len() <= number / 64 {
            self.bits.resize(number / 64 + 1, 0);
        }
        self.bits[number / 64] |= 1 << (number % 64);
        self.any = true;
    }
}

/// What is traced, and what was written down.
#[derive(Debug, Default)]
pub(super) struct Tracing {
    /// Whether each of the observed nets is traced.
    pub nets: Vec<bool>,
    /// Those that have changed in this wave, except in ticks.
    pub changed: Numbers,
    pub log: Log,
    /// The shape of what is written down after a wave, and its first field for each of the observed nets.
    shape: usize,
    first: Vec<u32>,
    /// Where generated code puts its records.
    place: Option<Half>,
}

impl Tracing {
    pub fn is_long(&self) -> bool {
        self.log.words.len() >= LONG
    }

    /// Moves the records of generated code into the log.
    fn take(&mut self, memory: &mut [Word]) {
        let Some(place) = self.place else { return };
        let first = place + RECORDS;
        let count = (*half(memory, place + END) / 8) as usize - first as usize;
        if count == 0 {
            return;
        }
        *half(memory, place + END) = u64::from(first) * 8;
        let from = &memory[first as usize / 2..][..count.div_ceil(2)];
        let before = self.log.words.len();
        self.log.words.resize(before + 2 * from.len(), 0);
        for (to, word) in self.log.words[before..].chunks_exact_mut(2).zip(from) {
            to.copy_from_slice(&[word.v, word.u]);
        }
        self.log.words.truncate(before + count);
    }

    /// Before ticks: makes room for at least one round, says when they happen; returns for how many rounds there is room.
    pub fn begin(&mut self, memory: &mut [Word], place: Half, longest: usize, at: Times) -> u64 {
        if place == 0 {
            return u64::MAX;
        }
        let room =
            |memory: &mut [Word]| ROOM - ((*half(memory, place + END) / 8) as usize - (place + RECORDS) as usize);
        if room(memory) < longest.max(ROOM / 4) {
            self.take(memory);
        }
        *half(memory, place + TIME) = at.first;
        *half(memory, place + WAIT) = at.low;
        *half(memory, place + WAIT + 1) = at.high;
        (room(memory) / longest) as u64
    }
}

impl CompiledEngine<'_> {
    pub(super) fn wanted(&self) -> Wanted<'_> {
        let shapes = self.tracing.log.shapes.len();
        Wanted { wiring: &self.wiring, kept: &self.kept, shared: self.shared, chunk: self.chunk, shapes }
    }

    /// Gives the log its place, and what waves write down its shape.
    pub(super) fn prepare_log(&mut self) {
        let t = &mut self.tracing;
        if !t.nets.contains(&true) {
            return;
        }
        let memory = &mut self.memory;
        let place = *t.place.get_or_insert_with(|| {
            let place = memory.len() as Half * 2;
            memory.resize(memory.len() + (RECORDS as usize + ROOM) / 2, Word::ZERO);
            *half(memory, place + END) = u64::from(place + RECORDS) * 8;
            place
        });
        self.shared.log = place;
        let mut fields: Vec<Field> = Vec::new();
        t.first.clear();
        for (&net, _) in self.observed_nets.iter().zip(&t.nets) {
            t.first.push(fields.len() as u32);
            let count = words(self.wiring.widths[net.index()]) as u32;
            fields.extend((0..count).map(|word| Field { net, word, written: Written::Both }));
        }
        t.shape = t.log.shapes.len();
        t.log.shapes.push(fields.into());
    }

    /// Has what generated code has written down in the log.
    pub(super) fn take_log(&mut self) {
        self.tracing.take(&mut self.memory);
    }

    /// Writes down the traced nets that have changed in this wave.
    #[inline(always)]
    pub(super) fn write_down(&mut self) {
        if self.tracing.changed.any {
            self.write_wave();
        }
    }

    fn write_wave(&mut self) {
        self.take_log();
        let t = &mut self.tracing;
        t.changed.any = false;
        let (fields, memory) = (&t.log.shapes[t.shape], &self.memory);
        let mut changed = Vec::new();
        for (i, word) in t.changed.bits.iter_mut().enumerate() {
            let mut bits = std::mem::take(word);
            while bits != 0 {
                let number = i * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let first = t.first[number] as usize;
                let net = self.observed_nets[number];
                let slot = self.wiring.slot[net.index()].expect("what is traced has a place") as usize;
                let count = words(self.wiring.widths[net.index()]);
                changed.extend((0..count).map(|k| (first + k, memory[slot + k], Written::Both)));
            }
        }
        changes::write(&mut t.log.words, t.shape, self.now, fields.len(), changed.into_iter());
    }
}

/// A word of a traced net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traced {
    pub net: NetId,
    pub word: u32,
    pub slot: u32,
    /// Whether all of it is always known.
    pub known: bool,
    /// Whether the net is one bit.
    pub bit: bool,
}

/// What a tick writes down.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub shape: usize,
    /// What the input becomes.
    level: bool,
    fields: Vec<Part>,
}

#[derive(Debug)]
struct Part {
    field: Field,
    slot: u32,
    /// The nodes that it becomes; where there is none, it stays.
    v: Option<Id>,
    u: Option<Id>,
    /// Whether it is the input, which always changes.
    input: bool,
}

impl Record {
    /// What a tick writes down that stores this.
    pub fn new(traced: Vec<Traced>, stores: &[Store], input: u32, level: bool) -> Record {
        let stored: Map<Half, Id> = stores.iter().map(|s| (s.half, s.node)).collect();
        let part = |t: Traced| {
            let (v, u) = (stored.get(&(2 * t.slot)).copied(), stored.get(&(2 * t.slot + 1)).copied());
            let input = t.slot == input;
            let written = match (t.known, t.bit) {
                (true, true) => Written::Toggled,
                (true, false) => Written::Known,
                (false, _) => Written::Both,
            };
            let written = if input { Written::Toggled } else { written };
            let field = Field { net: t.net, word: t.word, written };
            (input || v.is_some() || u.is_some()).then_some(Part { field, slot: t.slot, v, u, input })
        };
        Record { shape: 0, level, fields: traced.into_iter().filter_map(part).collect() }
    }

    pub fn fields(&self) -> Box<[Field]> {
        self.fields.iter().map(|p| p.field).collect()
    }

    pub fn longest(&self) -> usize {
        changes::longest(self.fields.iter().map(|p| p.field.written))
    }
}

/// Emits the code that writes a record down, before anything is stored.
pub(super) fn emit(emit: &mut Emit<'_, '_>, record: &Record, log: Half) {
    if log == 0 {
        return;
    }
    let base = emit.base;
    let load = |emit: &mut Emit<'_, '_>, half| emit.builder.ins().load(types::I64, trusted(), base, offset(half));
    let time = load(emit, log + TIME);
    let wait = load(emit, log + WAIT + u32::from(record.level));
    let next = emit.builder.ins().iadd(time, wait);
    emit.builder.ins().store(trusted(), next, base, offset(log + TIME));
    if record.fields.is_empty() {
        return;
    }
    let end = load(emit, log + END);
    let start = emit.builder.ins().iadd(base, end);
    let shape = emit.builder.ins().iconst(types::I64, record.shape as i64);
    emit.builder.ins().store(trusted(), shape, start, 0);
    emit.builder.ins().store(trusted(), time, start, 8);
    let head = changes::HEAD + record.fields.len().div_ceil(64);
    let mut at = emit.builder.ins().iadd_imm_s(start, 8 * head as i64);
    let mut any: Option<Value> = None;
    for (number, parts) in record.fields.chunks(64).enumerate() {
        let mut mask: Option<Value> = None;
        for part in parts {
            let bit = changed(emit, part, &mut at);
            mask = Some(match mask {
                None => bit,
                Some(mask) => {
                    let moved = emit.builder.ins().ishl_imm_u(mask, 1);
                    emit.builder.ins().iadd(moved, bit)
                }
            });
        }
        let Some(mask) = mask else { continue };
        let mask = emit.builder.ins().ishl_imm_u(mask, 64 - parts.len() as i64);
        emit.builder.ins().store(trusted(), mask, start, 8 * (changes::HEAD + number) as i32);
        any = Some(any.map_or(mask, |any| emit.builder.ins().bor(any, mask)));
    }
    let mut new = emit.builder.ins().isub(at, base);
    if let Some(any) = any.filter(|_| !record.fields.iter().any(|p| p.input)) {
        new = emit.builder.ins().select(any, new, end);
    }
    emit.builder.ins().store(trusted(), new, base, offset(log + END));
}

/// Puts a value at `at`, which is moved behind it if it has changed; whether it has.
fn changed(emit: &mut Emit<'_, '_>, part: &Part, at: &mut Value) -> Value {
    if part.input {
        return emit.builder.ins().iconst(types::I64, 1);
    }
    let base = emit.base;
    let mut plane = |half: Half, node: Option<Id>| {
        let old = emit.builder.ins().load(types::I64, trusted(), base, offset(half));
        (old, node.map_or(old, |node| emit.value(node)))
    };
    let (old, v) = plane(2 * part.slot, part.v);
    let (differs, bytes) = match part.field.written {
        Written::Toggled => return emit.builder.ins().bxor(old, v),
        Written::Known => {
            emit.builder.ins().store(trusted(), v, *at, 0);
            (emit.builder.ins().icmp(IntCC::NotEqual, old, v), 3)
        }
        Written::Both => {
            let (before, u) = plane(2 * part.slot + 1, part.u);
            emit.builder.ins().store(trusted(), v, *at, 0);
            emit.builder.ins().store(trusted(), u, *at, 8);
            let (x, y) = (emit.builder.ins().bxor(old, v), emit.builder.ins().bxor(before, u));
            let either = emit.builder.ins().bor(x, y);
            (emit.builder.ins().icmp_imm_u(IntCC::NotEqual, either, 0), 4)
        }
    };
    let bit = emit.builder.ins().uextend(types::I64, differs);
    let moved = emit.builder.ins().ishl_imm_u(bit, bytes);
    *at = emit.builder.ins().iadd(*at, moved);
    bit
}
