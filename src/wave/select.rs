//! Sinks made of sinks: one that hands everything on to several, and one that hands on a selection.

use std::io;

use super::{Batch, Batches, Layout, Sink};
use crate::value::Word;
use crate::value::word::{copy, words};

/// Hands everything on to each of several sinks.
pub struct Tee<'s>(pub Vec<&'s mut dyn Sink>);

impl Sink for Tee<'_> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.begin(layout))
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.time(now))
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        self.0.iter_mut().for_each(|s| s.change(var, value));
    }

    fn batches(&mut self) -> Option<&mut dyn Batches> {
        let all = self.0.iter_mut().all(|s| s.batches().is_some());
        all.then_some(self)
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.finish(end))
    }
}

impl Batches for Tee<'_> {
    fn batch(&mut self, batch: Batch) -> io::Result<Vec<u64>> {
        let Some((last, rest)) = self.0.split_last_mut() else { return Ok(batch.words) };
        let give = |sink: &mut &mut dyn Sink, batch| match sink.batches() {
            Some(sink) => sink.batch(batch),
            None => Err(io::Error::other("given a batch, which it does not take")),
        };
        rest.iter_mut().try_for_each(|sink| give(sink, batch.clone()).map(drop))?;
        give(last, batch)
    }
}

/// Bits of a variable that are a variable elsewhere.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pick {
    /// The index of the variable in its waveform.
    pub var: usize,
    /// The lowest bit.
    pub lo: u32,
    /// How many.
    pub width: u32,
}

/// Hands on some variables, or parts of them, as the variables of another layout.
pub struct Select<'s> {
    sink: &'s mut dyn Sink,
    layout: Layout,
    /// For each variable that comes, what it is there.
    picks: Vec<Vec<Pick>>,
    buffer: Vec<Word>,
}

impl<'s> Select<'s> {
    /// A sink that hands on to another, which has `layout`, for each variable `picks` of it.
    pub fn new(sink: &'s mut dyn Sink, layout: Layout, picks: Vec<Vec<Pick>>) -> Select<'s> {
        Select { sink, layout, picks, buffer: Vec::new() }
    }
}

impl Sink for Select<'_> {
    fn begin(&mut self, from: &Layout) -> io::Result<()> {
        // what comes is what has a value of its own; its other names change with it
        for var in (0..self.picks.len()).filter(|&var| from.vars[var].alias_of.is_some()) {
            let picks = std::mem::take(&mut self.picks[var]);
            self.picks[from.origin(var)].extend(picks);
        }
        self.sink.begin(&self.layout)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.sink.time(now)
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        for pick in &self.picks[var] {
            self.buffer.clear();
            self.buffer.resize(words(pick.width), Word::ZERO);
            copy(&mut self.buffer, 0, value, pick.lo, pick.width);
            self.sink.change(pick.var, &self.buffer);
        }
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.sink.finish(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vcd::VcdWriter;

    #[test]
    fn parts_of_variables_go_elsewhere() {
        let (mut from, mut to) = (Layout::default(), Layout::default());
        let (outer, inner) = (from.scope("a", None), to.scope("b", None));
        from.var(outer, "wide", 70);
        from.var(outer, "unused", 1);
        from.alias(outer, "again", 0);
        to.var(inner, "high", 6);
        to.var(inner, "whole", 70);
        let mut bytes = Vec::new();
        let mut writer = VcdWriter::new(&mut bytes);
        let picks = vec![vec![Pick { var: 0, lo: 64, width: 6 }], vec![], vec![Pick { var: 1, lo: 0, width: 70 }]];
        let mut select = Select::new(&mut writer, to, picks);
        let mut tee = Tee(vec![&mut select]);
        tee.begin(&from).unwrap();
        tee.time(0).unwrap();
        tee.change(0, &[Word::known(1), Word::known(0b10_0001)]);
        tee.change(1, &[Word::known(1)]);
        tee.finish(3).unwrap();
        drop(writer);
        let text = String::from_utf8(bytes).unwrap();
        let zeros = "0".repeat(63);
        assert!(text.contains(&format!("b100001 !\nb100001{zeros}1 \"\n")), "{text}");
    }
}
