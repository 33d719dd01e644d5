//! What all formats have in common: the values as a file has them and as they are now, and which of them a tick has
//! changed.
//!
//! A [`Format`] only says how a time and a value are written; here is decided which are. What is kept is two values a
//! variable, so memory does not grow with the run.

use std::io;

use super::batch::{Part, Shape};
use super::{Batch, Batches, Layout, Sink};
use crate::value::changes::{self, Change, Written};
use crate::value::{Word, word};

/// How a waveform is written. Variables that are aliases have the slot of what they are an alias of; slots are numbered
/// in the order of the layout.
///
/// # Errors
/// Every method passes on what the destination says.
pub trait Format {
    /// Starts the file. `slot_of` gives each variable's slot.
    ///
    /// # Errors
    /// The destination's.
    fn header(&mut self, layout: &Layout, slot_of: &[u32]) -> io::Result<()>;

    /// The values that follow, one of each slot in order, are the first ones, at tick `now`.
    ///
    /// # Errors
    /// The destination's.
    fn first(&mut self, now: u64) -> io::Result<()>;

    /// All first values were given.
    ///
    /// # Errors
    /// The destination's.
    fn first_done(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// The values that follow are those at tick `now`, later than the last.
    ///
    /// # Errors
    /// The destination's.
    fn time(&mut self, now: u64) -> io::Result<()>;

    /// A slot of so many bits has this value.
    ///
    /// # Errors
    /// The destination's.
    fn value(&mut self, slot: usize, width: u32, value: &[Word]) -> io::Result<()>;

    /// Nothing follows: complete the destination.
    ///
    /// # Errors
    /// The destination's.
    fn finish(&mut self) -> io::Result<()>;
}

/// A [`Sink`] that gives a [`Format`] what has changed by the end of each tick, in the order of the layout.
pub struct Recorder<F> {
    format: F,
    /// What holds a value: the variables that are no alias, in the order of the layout.
    slots: Vec<Slot>,
    /// Variable to slot.
    slot_of: Vec<u32>,
    /// The values as the file has them, slot after slot, and as they are now.
    written: Vec<Word>,
    current: Vec<Word>,
    /// The slots that were changed in this tick.
    touched: Touched,
    /// What batches are made of, as far as they have come.
    shapes: Vec<Fields>,
    now: Option<u64>,
    /// The last time that the file has; none before the first values.
    stamped: Option<u64>,
}

struct Slot {
    start: usize,
    width: u32,
}

/// The fields of a shape.
#[derive(Default)]
struct Fields {
    /// Where each is to be put, if it is one part; what has several begins among the others.
    places: Vec<Place>,
    others: Vec<Place>,
    /// For each word of a record's bits those of fields that have a value, and those that have two.
    valued: Vec<[u64; 2]>,
    /// Whether each field is a variable of its own, in the order of the layout.
    direct: bool,
}

/// Where some bits of a field belong.
#[derive(Clone, Copy)]
struct Place {
    slot: u32,
    /// The word among the values of all slots.
    at: u32,
    mask: u64,
    from: u8,
    to: u8,
    width: u8,
    written: Written,
    /// Whether it is among the others that the parts of a field are, the first of which is `at`, `slot` many.
    several: bool,
}

impl Fields {
    fn new(shape: &Shape, slot_of: &[u32], slots: &[Slot]) -> Fields {
        let mut fields = Fields::default();
        for (number, &(written, _)) in shape.fields.iter().enumerate() {
            let place = |part: &Part| {
                let slot = slot_of[part.var as usize];
                let at = slots[slot as usize].start as u32 + part.word;
                let Part { from, to, width, .. } = *part;
                Place { slot, at, mask: part.mask(), from, to, width, written, several: false }
            };
            let place = match shape.parts(number) {
                [part] => place(part),
                parts => {
                    let at = fields.others.len() as u32;
                    fields.others.extend(parts.iter().map(place));
                    Place { slot: parts.len() as u32, at, mask: 0, from: 0, to: 0, width: 0, written, several: true }
                }
            };
            fields.places.push(place);
        }
        fields.valued = vec![[0; 2]; fields.places.len().div_ceil(64)];
        for (i, place) in fields.places.iter().enumerate() {
            let bit = 1 << 63 >> (i % 64);
            fields.valued[i / 64][0] |= if place.written == Written::Toggled { 0 } else { bit };
            fields.valued[i / 64][1] |= if place.written == Written::Both { bit } else { 0 };
        }
        let whole = |p: &Place| !p.several && u32::from(p.width) == slots[p.slot as usize].width;
        fields.direct = fields.places.iter().all(whole) && fields.places.is_sorted_by(|a, b| a.slot < b.slot);
        fields
    }

    /// How many values a record with such bits has.
    fn values(&self, bits: &[u64]) -> usize {
        let count = |(bits, [one, two]): (&u64, &[u64; 2])| (bits & one).count_ones() + (bits & two).count_ones();
        bits.iter().zip(&self.valued).map(count).sum::<u32>() as usize
    }
}

/// Numbers of slots, each once: a bit for each slot, and one for each word of these.
#[derive(Default)]
struct Touched {
    bits: Vec<u64>,
    summary: Vec<u64>,
}

impl Touched {
    fn new(slots: usize) -> Touched {
        let words = slots.div_ceil(64);
        Touched { bits: vec![0; words], summary: vec![0; words.div_ceil(64)] }
    }

    #[inline(always)]
    fn insert(&mut self, slot: usize) {
        self.bits[slot / 64] |= 1 << (slot % 64);
        self.summary[slot / 4096] |= 1 << (slot / 64 % 64);
    }
}

impl Slot {
    fn words(&self) -> std::ops::Range<usize> {
        self.start..self.start + word::words(self.width)
    }
}

impl<F: Format> Recorder<F> {
    /// Nothing is written before [`Sink::begin`].
    pub(super) fn with(format: F) -> Recorder<F> {
        Recorder {
            format,
            slots: Vec::new(),
            slot_of: Vec::new(),
            written: Vec::new(),
            current: Vec::new(),
            touched: Touched::default(),
            shapes: Vec::new(),
            now: None,
            stamped: None,
        }
    }

    #[cfg(test)]
    pub(super) fn format(&mut self) -> &mut F {
        &mut self.format
    }

    /// Writes what this tick has changed.
    fn settle(&mut self) -> io::Result<()> {
        let Some(now) = self.now else { return Ok(()) };
        if self.stamped.is_none() {
            self.format.first(now)?;
            for (i, slot) in self.slots.iter().enumerate() {
                self.format.value(i, slot.width, &self.current[slot.words()])?;
            }
            self.format.first_done()?;
            self.written.copy_from_slice(&self.current);
            self.stamped = Some(now);
            self.touched = Touched::new(self.slots.len());
            return Ok(());
        }
        // In the order of the layout, whatever the order in which the engine came to them.
        for i in 0..self.touched.summary.len() {
            let mut words = std::mem::take(&mut self.touched.summary[i]);
            while words != 0 {
                let word = i * 64 + words.trailing_zeros() as usize;
                words &= words - 1;
                let mut bits = std::mem::take(&mut self.touched.bits[word]);
                while bits != 0 {
                    self.write(word * 64 + bits.trailing_zeros() as usize, now)?;
                    bits &= bits - 1;
                }
            }
        }
        Ok(())
    }

    /// Writes the value that a slot has, if the file has another.
    #[inline(always)]
    fn write(&mut self, slot: usize, now: u64) -> io::Result<()> {
        let Slot { start, width } = self.slots[slot];
        // nearly all are of one word, for which a comparison of slices costs more than it compares
        if width <= 64 {
            let value = self.current[start];
            if self.written[start] == value {
                return Ok(());
            }
            self.written[start] = value;
        } else {
            let range = start..start + word::words(width);
            if self.written[range.clone()] == self.current[range.clone()] {
                return Ok(());
            }
            self.written[range.clone()].copy_from_slice(&self.current[range]);
        }
        if self.stamped != Some(now) {
            self.format.time(now)?;
            self.stamped = Some(now);
        }
        self.format.value(slot, width, &self.current[start..start + word::words(width)])
    }
}

impl<F: Format> Sink for Recorder<F> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        layout.check().map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        for var in &layout.vars {
            if let Some(of) = var.alias_of {
                self.slot_of.push(self.slot_of[of]);
                continue;
            }
            self.slot_of.push(self.slots.len() as u32);
            self.slots.push(Slot { start: self.current.len(), width: var.width });
            self.current.extend((0..word::words(var.width)).map(|i| Word::x(word::word_mask(var.width, i))));
        }
        self.written = self.current.clone();
        self.touched = Touched::new(self.slots.len());
        self.format.header(layout, &self.slot_of)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        match self.now {
            Some(before) if before == now => return Ok(()),
            Some(before) if before > now => return Err(backwards(before, now)),
            _ => {}
        }
        self.settle()?;
        self.now = Some(now);
        Ok(())
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        assert!(self.now.is_some(), "a change before any time");
        let index = self.slot_of[var];
        let slot = &self.slots[index as usize];
        if slot.width <= 64 {
            self.current[slot.start] = value[0];
        } else {
            self.current[slot.words()].copy_from_slice(&value[..word::words(slot.width)]);
        }
        self.touched.insert(index as usize);
    }

    fn batches(&mut self) -> Option<&mut dyn Batches> {
        Some(self)
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        match self.now {
            None => self.now = Some(0),
            Some(before) if before > end => return Err(backwards(before, end)),
            Some(_) => {}
        }
        self.settle()?;
        if self.stamped != Some(end) {
            self.format.time(end)?;
        }
        self.format.finish()
    }
}

impl<F: Format> Batches for Recorder<F> {
    fn batch(&mut self, batch: Batch) -> io::Result<Vec<u64>> {
        for shape in &batch.shapes[self.shapes.len()..] {
            self.shapes.push(Fields::new(shape, &self.slot_of, &self.slots));
        }
        changes::read(&batch.words, self)?;
        Ok(batch.words)
    }
}

impl<F: Format> changes::Reader for Recorder<F> {
    type Error = io::Error;

    #[inline(always)]
    fn fields(&self, shape: usize) -> usize {
        self.shapes[shape].places.len()
    }

    #[inline(always)]
    fn record(&mut self, shape: usize, time: u64, bits: &[u64], values: &[u64]) -> io::Result<usize> {
        let again = self.now == Some(time);
        self.time(time)?;
        let fields = &self.shapes[shape];
        if fields.direct && !again && self.stamped.is_some() {
            // the tick is this record, if the next is of another
            let next = values.get(fields.values(bits) + 1);
            if next.is_some_and(|&next| next != time) {
                return self.write_at_once(shape, time, bits, values);
            }
        }
        let Fields { places, others, .. } = fields;
        let (current, touched) = (&mut self.current[..], &mut self.touched);
        let mut put = |place: &Place, change: Change| {
            change.put(&mut current[place.at as usize], place.from, place.to, place.mask);
            touched.insert(place.slot as usize);
        };
        let used = changes::each(
            bits,
            values,
            |field| places[field].written,
            |field, change| {
                let place = &places[field];
                if !place.several {
                    return put(place, change);
                }
                others[place.at as usize..][..place.slot as usize].iter().for_each(|place| put(place, change));
            },
        );
        Ok(used)
    }
}

impl<F: Format> Recorder<F> {
    /// Writes what a record has changed that is all of its tick, in the order of the layout.
    #[inline(always)]
    fn write_at_once(&mut self, shape: usize, now: u64, bits: &[u64], values: &[u64]) -> io::Result<usize> {
        let places = &self.shapes[shape].places[..];
        let Recorder { format, written, current, stamped, .. } = self;
        let mut told = Ok(());
        let used = changes::each(
            bits,
            values,
            |field| places[field].written,
            |field, change| {
                let Place { slot, at, width, from, to, mask, .. } = places[field];
                let value = &mut current[at as usize];
                // a field may be wider than what is written of it
                change.put(value, from, to, mask);
                if written[at as usize] == *value || told.is_err() {
                    return;
                }
                written[at as usize] = *value;
                if *stamped != Some(now) {
                    *stamped = Some(now);
                    told = format.time(now);
                }
                if told.is_ok() {
                    told = format.value(slot as usize, width.into(), std::slice::from_ref(value));
                }
            },
        );
        told.map(|()| used)
    }
}

fn backwards(before: u64, now: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("time goes back from {before} to {now}"))
}
