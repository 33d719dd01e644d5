//! What all formats have in common: the values as a file has them and as they are now, and which of them a tick has
//! changed.
//!
//! A [`Format`] only says how a time and a value are written; here is decided which are. What is kept is two values a
//! variable, so memory does not grow with the run.

use std::io;

use super::fields::{Fields, Touched};
use super::{Batch, Batches, Layout, Sink};
use crate::value::changes;
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

    /// The same for a slot of 64 bits at most, which nearly all are.
    ///
    /// # Errors
    /// The destination's.
    fn word(&mut self, slot: usize, width: u32, value: Word) -> io::Result<()> {
        self.value(slot, width, std::slice::from_ref(&value))
    }

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
    /// Whether the file has the first values, and the last time that it has.
    begun: bool,
    stamped: u64,
}

struct Slot {
    start: usize,
    width: u32,
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
            begun: false,
            stamped: 0,
        }
    }

    #[cfg(test)]
    pub(super) fn format(&mut self) -> &mut F {
        &mut self.format
    }

    /// Writes what this tick has changed.
    fn settle(&mut self) -> io::Result<()> {
        let Some(now) = self.now else { return Ok(()) };
        if !self.begun {
            self.format.first(now)?;
            for (i, slot) in self.slots.iter().enumerate() {
                self.format.value(i, slot.width, &self.current[slot.words()])?;
            }
            self.format.first_done()?;
            self.written.copy_from_slice(&self.current);
            (self.begun, self.stamped) = (true, now);
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
        if width > 64 {
            return self.write_wide(slot, now);
        }
        let (value, written) = (self.current[start], &mut self.written[start]);
        if *written == value {
            return Ok(());
        }
        *written = value;
        if self.stamped != now {
            self.stamp(now)?;
        }
        self.format.word(slot, width, value)
    }

    fn write_wide(&mut self, slot: usize, now: u64) -> io::Result<()> {
        let (width, range) = (self.slots[slot].width, self.slots[slot].words());
        if self.written[range.clone()] == self.current[range.clone()] {
            return Ok(());
        }
        self.written[range.clone()].copy_from_slice(&self.current[range.clone()]);
        if self.stamped != now {
            self.stamp(now)?;
        }
        self.format.value(slot, width, &self.current[range])
    }

    #[inline(always)]
    fn stamp(&mut self, now: u64) -> io::Result<()> {
        self.stamped = now;
        self.format.time(now)
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
        if self.stamped != end {
            self.format.time(end)?;
        }
        self.format.finish()
    }
}

impl<F: Format> Batches for Recorder<F> {
    fn batch(&mut self, batch: Batch) -> io::Result<Vec<u64>> {
        for shape in &batch.shapes[self.shapes.len()..] {
            self.shapes.push(Fields::new(shape, |var| {
                let slot = self.slot_of[var as usize];
                (slot, self.slots[slot as usize].start as u32)
            }));
        }
        changes::read(&batch.words, self)?;
        Ok(batch.words)
    }
}

impl<F: Format> changes::Reader for Recorder<F> {
    type Error = io::Error;

    #[inline(always)]
    fn fields(&self, shape: usize) -> usize {
        self.shapes[shape].len()
    }

    #[inline(always)]
    fn record(&mut self, shape: usize, time: u64, bits: &[u64], values: &[u64]) -> io::Result<usize> {
        self.time(time)?;
        Ok(self.shapes[shape].put(bits, values, &mut self.current, &mut self.touched))
    }
}

fn backwards(before: u64, now: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("time goes back from {before} to {now}"))
}
