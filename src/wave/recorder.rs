//! What all formats have in common: the values as a file has them and as they are now, and which of them a tick has
//! changed.
//!
//! A [`Format`] only says how a time and a value are written; here is decided which are. What is kept is two values a
//! variable, so memory does not grow with the run.

use std::io;

use super::{Layout, Sink};
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
    touched: Vec<u32>,
    now: Option<u64>,
    /// The last time that the file has; none before the first values.
    stamped: Option<u64>,
}

struct Slot {
    start: usize,
    width: u32,
    touched: bool,
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
            touched: Vec::new(),
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
            for (i, slot) in self.slots.iter_mut().enumerate() {
                slot.touched = false;
                self.format.value(i, slot.width, &self.current[slot.words()])?;
            }
            self.format.first_done()?;
            self.written.copy_from_slice(&self.current);
            self.stamped = Some(now);
            self.touched.clear();
            return Ok(());
        }
        // In the order of the layout, whatever the order in which the engine came to them.
        self.touched.sort_unstable();
        for &i in &self.touched {
            let slot = &mut self.slots[i as usize];
            slot.touched = false;
            let range = slot.words();
            // nearly all are of one word, for which a comparison of slices costs more than it compares
            let unchanged = match slot.width {
                ..=64 => self.written[range.start] == self.current[range.start],
                _ => self.written[range.clone()] == self.current[range.clone()],
            };
            if unchanged {
                continue;
            }
            if self.stamped != Some(now) {
                self.format.time(now)?;
                self.stamped = Some(now);
            }
            self.format.value(i as usize, slot.width, &self.current[range.clone()])?;
            match slot.width {
                ..=64 => self.written[range.start] = self.current[range.start],
                _ => self.written[range.clone()].copy_from_slice(&self.current[range]),
            }
        }
        self.touched.clear();
        Ok(())
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
            self.slots.push(Slot { start: self.current.len(), width: var.width, touched: false });
            self.current.extend((0..word::words(var.width)).map(|i| Word::x(word::word_mask(var.width, i))));
        }
        self.written = self.current.clone();
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
        let slot = &mut self.slots[index as usize];
        if slot.width <= 64 {
            self.current[slot.start] = value[0];
        } else {
            self.current[slot.words()].copy_from_slice(&value[..word::words(slot.width)]);
        }
        if !slot.touched {
            slot.touched = true;
            self.touched.push(index);
        }
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

fn backwards(before: u64, now: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("time goes back from {before} to {now}"))
}
