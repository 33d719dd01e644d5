//! From changes of nets to a waveform: which variables a net is part of, and what they are now.
//!
//! A signal may be made of many nets and have many names. Each change of a net is put into the variables that it is part
//! of, and each variable that has changed is given to the sink once, whatever its width and its names.

use std::io;
use std::sync::Arc;

use crate::engine::{Engine, Field};
use crate::netlist::{NetId, Netlist, SignalId};
use crate::value::Word;
use crate::value::changes;
use crate::value::word::{copy, words};
use crate::wave::batch::{Part, Shape};
use crate::wave::{Batch, Layout, Sink};

/// Words of an engine's log that are worth being handed on.
const BATCH: usize = 1 << 12;

/// Some bits of a net that are some bits of a variable.
#[derive(Clone, Copy)]
struct Piece {
    var: u32,
    /// The lowest bit in the net, and in the variable.
    from: u32,
    to: u32,
    width: u32,
}

struct Var {
    /// Where its words begin.
    start: u32,
    words: u32,
    changed: bool,
}

/// The signals that are recorded.
pub(crate) struct Recording {
    layout: Layout,
    /// For each net the first of its pieces, and one past the last.
    start: Vec<u32>,
    pieces: Vec<Piece>,
    vars: Vec<Var>,
    values: Vec<Word>,
    changed: Vec<u32>,
    /// What the shapes of an engine's records are to the waveform.
    shapes: Arc<Vec<Arc<Shape>>>,
}

impl Recording {
    /// One variable for each signal, in the same order.
    pub fn new(netlist: &Netlist, traced: &[SignalId]) -> Recording {
        let layout = layout(netlist, traced);
        let originals = || traced.iter().enumerate().filter(|(i, _)| layout.vars[*i].alias_of.is_none());
        let mut start = vec![0u32; netlist.nets().len() + 1];
        for (_, &signal) in originals() {
            netlist.bits(signal).iter().for_each(|s| start[s.net.index() + 1] += 1);
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut free = start.clone();
        let mut pieces = vec![Piece { var: 0, from: 0, to: 0, width: 0 }; start[netlist.nets().len()] as usize];
        for (i, &signal) in originals() {
            let mut to = 0;
            for s in netlist.bits(signal) {
                let at = &mut free[s.net.index()];
                pieces[*at as usize] = Piece { var: i as u32, from: s.lo, to, width: s.width };
                *at += 1;
                to += s.width;
            }
        }
        let mut size = 0;
        let var = |&signal: &SignalId| {
            let var = Var { start: size, words: words(netlist.signal(signal).width) as u32, changed: false };
            size += var.words;
            var
        };
        let vars: Vec<Var> = traced.iter().map(var).collect();
        let values = vec![Word::ZERO; size as usize];
        Recording { layout, start, pieces, vars, values, changed: Vec::new(), shapes: Arc::default() }
    }

    /// What the waveform is about.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Takes the present value of a net.
    fn take(&mut self, engine: &dyn Engine, net: NetId) {
        let range = self.start[net.index()] as usize..self.start[net.index() + 1] as usize;
        if range.is_empty() {
            return;
        }
        let value = engine.read(net);
        for p in &self.pieces[range] {
            let var = &mut self.vars[p.var as usize];
            copy(&mut self.values[var.start as usize..(var.start + var.words) as usize], p.to, value, p.from, p.width);
            if !std::mem::replace(&mut var.changed, true) {
                self.changed.push(p.var);
            }
        }
    }

    /// Gives the sink what has changed, or everything if it is the first time: what has a value from the start never
    /// changes to it.
    pub fn record(&mut self, engine: &mut dyn Engine, first: bool, sink: &mut dyn Sink) -> io::Result<()> {
        if first {
            // which is all that the log can tell
            if let Some(log) = engine.log() {
                log.words.clear();
            }
            (0..self.start.len() - 1).for_each(|net| self.take(engine, NetId::new(net)));
        } else if engine.logs() {
            if engine.log().is_none_or(|log| log.words.len() < BATCH) {
                return Ok(());
            }
            return self.hand_on(engine, sink);
        } else if engine.changes().is_empty() {
            return Ok(());
        } else {
            // what it logged before it began to list changes comes first
            self.hand_on(engine, sink)?;
            engine.changes().iter().for_each(|&net| self.take(engine, net));
        }
        self.give(engine.now(), sink)
    }

    /// Gives the sink what the engine's log still has. Where a tick was not completed, it is left out.
    pub fn finish(&mut self, engine: &mut dyn Engine, broken: bool, sink: &mut dyn Sink) -> io::Result<()> {
        let now = engine.now();
        if let Some(log) = engine.log().filter(|_| broken) {
            let shapes = &log.shapes;
            let whole =
                changes::before(&log.words, |shape, field| shapes[shape][field].written, |s| shapes[s].len(), now);
            log.words.truncate(whole);
        }
        self.hand_on(engine, sink)
    }

    /// Gives the sink the variables that have changed.
    fn give(&mut self, now: u64, sink: &mut dyn Sink) -> io::Result<()> {
        sink.time(now)?;
        for &i in &self.changed {
            let var = &mut self.vars[i as usize];
            var.changed = false;
            sink.change(i as usize, &self.values[var.start as usize..(var.start + var.words) as usize]);
        }
        self.changed.clear();
        Ok(())
    }

    /// Gives the sink the engine's log: as it is if it takes that, so that it is read on the sink's thread.
    fn hand_on(&mut self, engine: &mut dyn Engine, sink: &mut dyn Sink) -> io::Result<()> {
        let Some(log) = engine.log().filter(|log| !log.words.is_empty()) else { return Ok(()) };
        let known = self.shapes.len();
        if known < log.shapes.len() {
            let new: Vec<Arc<Shape>> = log.shapes[known..].iter().map(|fields| Arc::new(self.shape(fields))).collect();
            Arc::make_mut(&mut self.shapes).extend(new);
        }
        let words = std::mem::take(&mut log.words);
        let mut words = match sink.batches() {
            Some(sink) => sink.batch(Batch { words, shapes: Arc::clone(&self.shapes) })?,
            None => {
                let mut play = Play { shapes: Arc::clone(&self.shapes), recording: self, sink, now: None };
                changes::read(&words, &mut play)?;
                play.settle()?;
                words
            }
        };
        words.clear();
        if let Some(log) = engine.log() {
            log.words = words;
        }
        Ok(())
    }

    /// What some fields of an engine's records are to the waveform.
    fn shape(&self, fields: &[Field]) -> Shape {
        let mut shape = Shape::default();
        for field in fields {
            shape.fields.push((field.written, shape.parts.len() as u32));
            let (first, last) = (field.word * 64, field.word * 64 + 63);
            for p in &self.pieces[self.start[field.net.index()] as usize..self.start[field.net.index() + 1] as usize] {
                // what of the piece is in this word, cut where a word of the variable ends
                let (mut at, end) = (p.from.max(first), (p.from + p.width).min(last + 1));
                while at < end {
                    let to = p.to + (at - p.from);
                    let width = (end - at).min(64 - to % 64);
                    let (from, bit) = ((at - first) as u8, (to % 64) as u8);
                    shape.parts.push(Part { var: p.var, word: to / 64, from, to: bit, width: width as u8 });
                    at += width;
                }
            }
        }
        shape
    }
}

/// Reads records for a sink that takes one change after the other.
struct Play<'p> {
    shapes: Arc<Vec<Arc<Shape>>>,
    recording: &'p mut Recording,
    sink: &'p mut dyn Sink,
    now: Option<u64>,
}

impl Play<'_> {
    fn settle(&mut self) -> io::Result<()> {
        self.now.take().map_or(Ok(()), |now| self.recording.give(now, self.sink))
    }
}

impl changes::Reader for Play<'_> {
    type Error = io::Error;

    fn fields(&self, shape: usize) -> usize {
        self.shapes[shape].fields.len()
    }

    fn record(&mut self, shape: usize, time: u64, bits: &[u64], values: &[u64]) -> io::Result<usize> {
        if self.now != Some(time) {
            self.settle()?;
        }
        self.now = Some(time);
        let Recording { vars, values: all, changed, .. } = &mut *self.recording;
        let shape = &self.shapes[shape];
        let used = changes::each(
            bits,
            values,
            |field| shape.fields[field].0,
            |field, change| {
                for part in shape.parts(field) {
                    let var = &mut vars[part.var as usize];
                    change.put(&mut all[(var.start + part.word) as usize], part.from, part.to, part.mask());
                    if !std::mem::replace(&mut var.changed, true) {
                        changed.push(part.var);
                    }
                }
            },
        );
        Ok(used)
    }
}

/// The waveform's scopes and variables: one variable for each traced signal, in the same order.
pub(crate) fn layout(netlist: &Netlist, traced: &[SignalId]) -> Layout {
    let mut layout = Layout { timescale: netlist.timescale(), ..Layout::default() };
    let mut used = vec![false; netlist.scopes().len()];
    used[0] = true;
    for &signal in traced {
        let mut scope = Some(netlist.signal(signal).scope);
        while let Some(s) = scope.filter(|s| !std::mem::replace(&mut used[s.index()], true)) {
            scope = netlist.scopes()[s.index()].parent;
        }
    }
    let mut number = vec![0; netlist.scopes().len()];
    for (i, scope) in netlist.scopes().iter().enumerate().filter(|(i, _)| used[*i]) {
        number[i] = layout.scope(&scope.name, scope.parent.map(|p| number[p.index()]));
    }
    let mut same = std::collections::HashMap::new();
    for &id in traced {
        let signal = netlist.signal(id);
        let scope = number[signal.scope.index()];
        match same.get(netlist.bits(id)) {
            Some(&of) => _ = layout.alias(scope, &signal.name, of),
            None => {
                same.insert(netlist.bits(id), layout.var(scope, &signal.name, signal.width));
            }
        }
    }
    layout
}
