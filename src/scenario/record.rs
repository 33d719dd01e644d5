//! From changes of nets to a waveform: which variables a net is part of, and what they are now.
//!
//! A signal may be made of many nets and have many names. Each change of a net is put into the variables that it is part
//! of, and each variable that has changed is given to the sink once, whatever its width and its names.

use std::io;

use crate::engine::Engine;
use crate::netlist::{NetId, Netlist, SignalId};
use crate::value::Word;
use crate::value::word::{copy, words};
use crate::wave::{Layout, Sink};

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
pub(super) struct Recording {
    layout: Layout,
    /// For each net the first of its pieces, and one past the last.
    start: Vec<u32>,
    pieces: Vec<Piece>,
    vars: Vec<Var>,
    values: Vec<Word>,
    changed: Vec<u32>,
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
        Recording { layout, start, pieces, vars, values: vec![Word::ZERO; size as usize], changed: Vec::new() }
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
    pub fn record(&mut self, engine: &dyn Engine, first: bool, sink: &mut dyn Sink) -> io::Result<()> {
        if first {
            (0..self.start.len() - 1).for_each(|net| self.take(engine, NetId::new(net)));
        } else {
            engine.changes().iter().for_each(|&net| self.take(engine, net));
        }
        sink.time(engine.now())?;
        for &i in &self.changed {
            let var = &mut self.vars[i as usize];
            var.changed = false;
            sink.change(i as usize, &self.values[var.start as usize..(var.start + var.words) as usize]);
        }
        self.changed.clear();
        Ok(())
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
