//! The log of traced nets, to which generated code itself appends: a traced run stays in the loop of its clock.
//!
//! An edge appends a record (see [`value::changes`](crate::value::changes)): each value is stored where the next one belongs,
//! and only if it has changed does that place move on. So there is no branch, and nothing is compared afterwards. Changes of
//! phases that run in partitions are appended here.

use crate::compiled::codegen::trace::{END, RECORDS, ROOM, TIME, WAIT};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::runtime::variants::Request;
use crate::compiled::runtime::{CompiledEngine, word_of};
use crate::value::Word;
use crate::value::changes::{self, Written};
use crate::value::word::words;
use crate::{Field, Log};

/// Words with which the log counts as long.
const LONG: usize = ROOM / 2;

/// When edges happen that follow each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times {
    pub first: u64,
    /// How long the input stays 0.
    pub low: u64,
    /// How long it stays 1.
    pub high: u64,
}

/// Numbers of observed nets, each once.
#[derive(Debug, Default)]
pub(crate) struct Numbers {
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

impl Numbers {
    pub fn contains(&self, number: usize) -> bool {
        self.bits.get(number / 64).is_some_and(|word| word >> (number % 64) & 1 == 1)
    }

    pub fn clear(&mut self) {
        self.bits.fill(0);
        self.any = false;
    }
}

/// What is traced, and what was written down.
#[derive(Debug, Default)]
pub(crate) struct Tracing {
    /// Whether each of the observed nets is traced.
    pub nets: Vec<bool>,
    /// Those that have changed in this phase, except in edges.
    pub changed: Numbers,
    pub log: Log,
    /// The shape of what is written down after a phase, and its first field for each of the observed nets.
    shape: usize,
    first: Vec<u32>,
    /// Where generated code puts its records.
    place: Option<PlaneWord>,
}

impl Tracing {
    pub fn is_long(&self) -> bool {
        self.log.words.len() >= LONG
    }

    /// Moves the records of generated code into the log.
    fn take(&mut self, memory: &mut [Word]) {
        let Some(place) = self.place else { return };
        let first = place + RECORDS;
        let count = (*word_of(memory, place + END) / 8) as usize - first.index();
        if count == 0 {
            return;
        }
        *word_of(memory, place + END) = first.index() as u64 * 8;
        let from = &memory[first.slot().index()..][..count.div_ceil(2)];
        let before = self.log.words.len();
        self.log.words.resize(before + 2 * from.len(), 0);
        for (to, word) in self.log.words[before..].chunks_exact_mut(2).zip(from) {
            to.copy_from_slice(&[word.v, word.u]);
        }
        self.log.words.truncate(before + count);
    }

    /// Before edges: makes room for at least one round, says when they happen; returns for how many rounds there is room.
    pub fn begin(&mut self, memory: &mut [Word], place: Option<PlaneWord>, longest: usize, at: Times) -> u64 {
        let Some(place) = place else { return u64::MAX };
        let room =
            |memory: &mut [Word]| ROOM - ((*word_of(memory, place + END) / 8) as usize - (place + RECORDS).index());
        if room(memory) < longest.max(ROOM / 4) {
            self.take(memory);
        }
        *word_of(memory, place + TIME) = at.first;
        *word_of(memory, place + WAIT) = at.low;
        *word_of(memory, place + WAIT + 1) = at.high;
        (room(memory) / longest) as u64
    }
}

impl CompiledEngine {
    pub(crate) fn request(&self) -> Request<'_> {
        let shapes = self.observation.tracing.log.shapes.len();
        Request {
            layout: &self.layout,
            kept: &self.observation.kept,
            shared: self.variants.shared,
            partition: self.variants.partition_size,
            shapes,
        }
    }

    /// Gives the log its place, and what phases write down its shape.
    pub(crate) fn prepare_log(&mut self) {
        let t = &mut self.observation.tracing;
        if !t.nets.contains(&true) {
            return;
        }
        let memory = &mut self.memory;
        let place = *t.place.get_or_insert_with(|| {
            let place = Slot::at(memory.len()).value();
            memory.resize(memory.len() + (RECORDS as usize + ROOM) / 2, Word::ZERO);
            *word_of(memory, place + END) = (place + RECORDS).index() as u64 * 8;
            place
        });
        self.variants.shared.log = Some(place);
        let mut fields: Vec<Field> = Vec::new();
        t.first.clear();
        for (&net, _) in self.observation.nets.iter().zip(&t.nets) {
            t.first.push(fields.len() as u32);
            let count = words(self.layout.widths[net.index()]) as u32;
            fields.extend((0..count).map(|word| Field { net, word, written: Written::Both }));
        }
        t.shape = t.log.shapes.len();
        t.log.shapes.push(fields.into());
    }

    /// Has what generated code has written down in the log.
    pub(crate) fn take_log(&mut self) {
        self.observation.tracing.take(&mut self.memory);
    }

    /// Writes down the traced nets that have changed in this phase.
    #[inline(always)]
    pub(crate) fn write_down(&mut self) {
        if self.observation.tracing.changed.any {
            self.write_phase();
        }
    }

    fn write_phase(&mut self) {
        self.take_log();
        let t = &mut self.observation.tracing;
        t.changed.any = false;
        let (fields, memory) = (&t.log.shapes[t.shape], &self.memory);
        let mut changed = Vec::new();
        for (i, word) in t.changed.bits.iter_mut().enumerate() {
            let mut bits = std::mem::take(word);
            while bits != 0 {
                let number = i * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let first = t.first[number] as usize;
                let net = self.observation.nets[number];
                let slot = self.layout.slot[net.index()].expect("what is traced has a place").index();
                let count = words(self.layout.widths[net.index()]);
                changed.extend((0..count).map(|k| (first + k, memory[slot + k], Written::Both)));
            }
        }
        changes::write(&mut t.log.words, t.shape, self.clocks.now, fields.len(), changed.into_iter());
    }
}
