//! The present values, one operation, one change.

use super::super::UnknownControl;
use super::memory::Memories;
use super::program::{Code, General, Meta, ONE, Op, Operand, Part, Program, Store, StoreCode, flag};
use crate::cell::choose::{self, Line};
use crate::cell::{GateOp, arith, clocked, counter, evaluate, select, storage};
use crate::netlist::NetId;
use crate::value::Word;
use crate::value::word::{copy, mask, words};

/// More pins than any cell has.
const PINS: usize = 8;

/// Edge detection at one clock pin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    /// The bit when edges were last looked for.
    pub old: Word,
    /// Whether it is listed among the pending.
    pub pending: bool,
}

#[derive(Debug)]
pub(super) struct State {
    pub slots: Vec<Word>,
    /// What a change of each slot wakes.
    pub meta: Vec<Meta>,
    /// Operations to run, a bit each, and a bit for each word of them that is not 0.
    pub dirty: Vec<u64>,
    pub summary: Vec<u64>,
    pub watches: Vec<Watch>,
    /// Whether the circuit has not settled yet: what nets become until then is no edge.
    pub first: bool,
    /// Clock pins whose slot has changed since edges were last looked for.
    pub pending: Vec<u32>,
    /// Values that wait until all of a step have been computed.
    pub staged: Vec<(u32, Word)>,
    pub changes: Vec<NetId>,
    /// Delays whose input has changed.
    pub delayed: Vec<u32>,
    /// Slots of controls that changed from or to unknown.
    pub doubtful: Vec<u32>,
    pub control_seen: Vec<bool>,
    /// By cell, so that each is reported once.
    pub reported: Vec<bool>,
    pub unknown_controls: Vec<UnknownControl>,
    pub events: u64,
    /// Operations of a feedback step.
    pub batch: Vec<u32>,
    scratch_in: Vec<Word>,
    scratch_out: Vec<Word>,
    pub memories: Memories,
}

impl State {
    pub fn new(p: &Program) -> State {
        // at least one, for the slots that wake nothing
        let dirty_words = p.ops.len().div_ceil(64).max(1);
        let mut dirty = vec![u64::MAX; dirty_words];
        dirty[dirty_words - 1] = mask((p.ops.len() - (dirty_words - 1) * 64) as u32);
        let mut summary = vec![0u64; dirty_words.div_ceil(64)];
        for word in 0..dirty_words {
            summary[word / 64] |= 1 << (word % 64);
        }
        let bit = |slot: u32, shift: u8| bit_of(p.initial[slot as usize], shift);
        let most = |f: &dyn Fn(&General) -> usize| p.generals.iter().map(f).max().unwrap_or(0);
        let cells = p.controls.iter().map(|c| c.cell.index() + 1).max().unwrap_or(0);
        let watches = p.clocks.iter().map(|c| {
            let first = bit(c.slot, c.shift);
            let acts = c.level && first.is_one();
            Watch { old: if acts { Word::x(1) } else { first }, pending: acts }
        });
        let watches: Vec<Watch> = watches.collect();
        let pending = (0..watches.len() as u32).filter(|&i| watches[i as usize].pending).collect();
        State {
            slots: p.initial.clone(),
            meta: p.meta.clone(),
            dirty,
            summary,
            watches,
            first: true,
            pending,
            staged: Vec::with_capacity(p.stores.len() + p.ops.len().min(1 << 16)),
            changes: Vec::with_capacity(64),
            delayed: (0..p.delays.len() as u32).collect(),
            doubtful: Vec::new(),
            control_seen: p.controls.iter().map(|c| bit(c.slot, c.shift).is_known()).collect(),
            reported: vec![false; cells],
            unknown_controls: Vec::new(),
            events: 0,
            batch: Vec::with_capacity(p.groups.iter().map(ExactSizeIterator::len).max().unwrap_or(0)),
            scratch_in: vec![Word::ZERO; most(&|g| (0..g.pins.len()).map(|pin| words(g.kind.input_width(pin))).sum())],
            scratch_out: vec![Word::ZERO; 2 * most(&|g| g.outputs.iter().map(|o| words(o.1)).sum())],
            memories: Memories::new(p),
        }
    }

    #[inline(always)]
    pub fn read(&self, o: Operand, m: u64) -> Word {
        let w = self.slots[o.slot as usize];
        if o.part == Part::Whole { w } else { part_of(w, o, m) }
    }

    /// A control pin of a store, most of which are not connected.
    #[inline(always)]
    fn control(&self, o: Operand) -> Word {
        if o.slot <= ONE.slot { Word::known(o.slot.into()) } else { self.read(o, 1) }
    }

    /// Writes a slot; if that changes it, wakes what reads it.
    #[inline(always)]
    pub fn put(&mut self, p: &Program, slot: u32, new: Word) {
        let at = &mut self.slots[slot as usize];
        let old = *at;
        if (old.v ^ new.v) | (old.u ^ new.u) == 0 {
            return;
        }
        *at = new;
        self.events += 1;
        self.wake(p, slot);
        if self.meta[slot as usize].flags != 0 {
            self.notify(p, slot, old, new);
        }
    }

    /// Marks the operations that read a slot.
    #[inline(always)]
    pub fn wake(&mut self, p: &Program, slot: u32) {
        let meta = &self.meta[slot as usize];
        if meta.mask != 0 {
            let word = meta.word as usize;
            self.dirty[word] |= meta.mask;
            self.summary[word / 64] |= 1 << (word % 64);
        }
        if meta.more_start != meta.more_end {
            for wake in &p.wakes[meta.more_start as usize..meta.more_end as usize] {
                self.dirty[wake.word as usize] |= wake.mask;
                self.summary[wake.word as usize / 64] |= 1 << (wake.word % 64);
            }
        }
    }

    /// What a change means beyond the operations that read it.
    fn notify(&mut self, p: &Program, slot: u32, old: Word, new: Word) {
        let meta = &mut self.meta[slot as usize];
        if meta.flags & (flag::OBSERVED | flag::CHANGED) == flag::OBSERVED {
            let net = NetId(p.slot_net[slot as usize]);
            // the mark of a net of several words is on its first
            let first = &mut self.meta[p.net_slot[net.index()] as usize];
            if first.flags & flag::CHANGED == 0 {
                first.flags |= flag::CHANGED;
                self.changes.push(net);
            }
        }
        let meta = self.meta[slot as usize];
        if meta.flags & (flag::CLOCK | flag::CONTROL | flag::DELAY) == 0 {
            return;
        }
        let hook = &p.hooks[meta.hook as usize];
        if meta.flags & flag::CLOCK != 0 {
            for &number in &p.hooked[hook.clocks.clone()] {
                let watch = &mut self.watches[number as usize];
                if !watch.pending {
                    watch.pending = true;
                    watch.old = bit_of(old, p.clocks[number as usize].shift);
                    self.pending.push(number);
                }
            }
        }
        if meta.flags & flag::CONTROL != 0 && (old.u | new.u) != 0 {
            self.doubtful.push(slot);
        }
        if meta.flags & flag::DELAY != 0 {
            self.delayed.extend(&p.hooked[hook.delays.clone()]);
        }
    }

    /// Writes a slot, at once or after the step.
    #[inline(always)]
    fn out<const STAGED: bool>(&mut self, p: &Program, slot: u32, new: Word) {
        if STAGED {
            self.staged.push((slot, new));
        } else {
            self.put(p, slot, new);
        }
    }

    /// Runs one operation.
    #[inline(always)]
    pub fn run<const STAGED: bool>(&mut self, p: &Program, op: &Op) {
        let m = op.mask;
        // a macro, so that each gate is a branch of this match and none within it
        macro_rules! two {
            ($gate:ident) => {
                GateOp::$gate.finish(GateOp::$gate.join(self.read(op.a, m), self.read(op.b, m)), m)
            };
        }
        let y = match op.code {
            // these join to known bits and x alone, so there is nothing to finish
            Code::And2 => GateOp::And.join(self.read(op.a, m), self.read(op.b, m)),
            Code::Or2 => GateOp::Or.join(self.read(op.a, m), self.read(op.b, m)),
            Code::Xor2 => GateOp::Xor.join(self.read(op.a, m), self.read(op.b, m)),
            Code::Nand2 => two!(Nand),
            Code::Nor2 => two!(Nor),
            Code::Xnor2 => two!(Xnor),
            Code::Buf => GateOp::Buf.finish(self.read(op.a, m), m),
            Code::Not => GateOp::Not.finish(self.read(op.a, m), m),
            Code::Reduce(gate) => gate.finish(gate.reduce(self.read(op.a, m), m), 1),
            Code::GateN(gate) => {
                let inputs = &p.pool[op.ext as usize..(op.ext + op.count) as usize];
                gate.finish(inputs.iter().fold(gate.identity(m), |acc, i| gate.join(acc, self.read(i.0, m))), m)
            }
            Code::AndOrN => {
                let pairs = &p.pool[op.ext as usize..(op.ext + 2 * op.count) as usize];
                pairs
                    .chunks_exact(2)
                    .fold(Word::ZERO, |acc, pair| acc.or(self.read(pair[0].0, m).and(self.read(pair[1].0, m))))
            }
            Code::Mux2 => {
                let s = self.read(op.c, 1);
                match (s.u, s.v) {
                    (0, 0) => self.read(op.a, m),
                    (0, _) => self.read(op.b, m),
                    _ => self.read(op.a, m).merge(self.read(op.b, m)),
                }
            }
            Code::Mux => {
                let inputs = &p.pool[op.ext as usize..];
                select::mux_word(op.count, m, self.read(op.c, mask(select::select_width(op.count))), |k| {
                    self.read(inputs[k as usize].0, m)
                })
            }
            Code::OneHotMux => match choose::line(&[self.read(op.c, mask(op.count))]) {
                Line::None => self.read(op.a, m),
                Line::One(k) => self.read(p.pool[(op.ext + k) as usize].0, m),
                Line::Unclear => Word::x(m),
            },
            Code::Compare { op: compare, signed } => {
                select::compare(compare, op.count, signed, &[self.read(op.a, m)], &[self.read(op.b, m)])
            }
            Code::HalfAdder | Code::FullAdder => {
                let (a, b) = (self.read(op.a, 1), self.read(op.b, 1));
                let (s, co) = if op.code == Code::HalfAdder {
                    arith::half_adder(a, b)
                } else {
                    arith::full_adder(a, b, self.read(op.c, 1))
                };
                self.out::<STAGED>(p, op.y2, co);
                s
            }
            Code::Add | Code::Sub => {
                let sub = Word::known(u64::from(op.code == Code::Sub));
                let mut y = [Word::ZERO];
                let co =
                    arith::add(op.count, &[self.read(op.a, m)], &[self.read(op.b, m)], self.read(op.c, 1), sub, &mut y);
                self.out::<STAGED>(p, op.y2, co);
                y[0]
            }
            Code::Sr { set_dominates } => {
                let q = storage::sr(self.read(op.c, 1), self.read(op.a, 1), self.read(op.b, 1), set_dominates);
                self.out::<STAGED>(p, op.y2, q.not(1));
                q
            }
            Code::SetReset => {
                let s = &p.stores[op.ext as usize];
                let (set, reset) = (self.read(op.a, 1), self.read(op.b, 1));
                let q = self.slots[op.y as usize];
                storage::level(q, Word::ZERO, set, reset, Word::ZERO, s.set_value, s.reset_value)
            }
            Code::Level => {
                let (q, derived) = self.level(&p.stores[op.ext as usize], m);
                if op.count != 0 {
                    self.out::<STAGED>(p, op.y2, derived);
                }
                q
            }
            Code::Gather => {
                let pieces = &p.pool[op.ext as usize..(op.ext + op.count) as usize];
                let mut at = 0;
                pieces.iter().fold(Word::ZERO, |acc, &(o, width)| {
                    let w = self.read(o, mask(width));
                    let y = Word { v: acc.v | w.v << at, u: acc.u | w.u << at };
                    at += width;
                    y
                })
            }
            Code::MemoryRead => return self.memory_read::<STAGED>(p, op),
            Code::MemoryWrite => return self.memory_write::<STAGED>(p, op),
            Code::Narrow => return self.narrow::<STAGED>(p, op),
            Code::General => return self.general::<STAGED>(p, op),
        };
        self.out::<STAGED>(p, op.y, y);
    }

    /// The state of a store after its asynchronous controls, and the output made from it.
    #[inline(always)]
    fn level(&self, s: &Store, m: u64) -> (Word, Word) {
        let q = self.slots[s.q as usize];
        let (d, load, reset) = (self.read(s.d, m), self.control(s.aload), self.control(s.reset));
        match s.code {
            StoreCode::Counter => {
                let mut q = [q];
                counter::level(&mut q, &[d], load, reset);
                (q[0], GateOp::Nor.finish(GateOp::Nor.reduce(q[0], m), 1))
            }
            StoreCode::Accumulator => {
                let mut q = [q];
                counter::level(&mut q, &[d], Word::ZERO, reset);
                (q[0], counter::carry(s.width, &q, &[d], self.control(s.extra)))
            }
            _ => {
                let q = storage::level(q, d, self.control(s.set), reset, load, s.set_value, s.reset_value);
                (q, q.not(m))
            }
        }
    }

    /// Computes what a store takes at its active edge, for [`State::take`] to write.
    #[inline(always)]
    pub fn sample(&mut self, p: &Program, number: u32) {
        let s = &p.stores[number as usize];
        let m = mask(s.width);
        match s.code {
            StoreCode::General => return self.sample_general(p, s.general),
            StoreCode::Memory => return self.memories.edges.push((s.general, s.q)),
            _ => {}
        }
        let q = self.slots[s.q as usize];
        let en = self.control(s.en);
        let mut next = [Word::ZERO];
        match s.code {
            StoreCode::Plain => next[0] = if en.is_one() { self.read(s.d, m) } else { q },
            StoreCode::SetReset => {
                let c = storage::Controls {
                    set: self.control(s.set),
                    reset: self.control(s.reset),
                    en: Word::known(1),
                    aload: Word::ZERO,
                    sync_set: Word::ZERO,
                    sync_reset: Word::ZERO,
                };
                next[0] = storage::clocked(q, self.read(s.d, m), &c, s.set_value, s.reset_value);
            }
            StoreCode::Flop => {
                let c = storage::Controls {
                    aload: self.control(s.aload),
                    set: self.control(s.set),
                    reset: self.control(s.reset),
                    en,
                    sync_set: self.control(s.extra),
                    sync_reset: self.control(s.extra2),
                };
                next[0] = storage::clocked(q, self.read(s.d, m), &c, s.set_value, s.reset_value);
            }
            StoreCode::Counter => {
                let c = counter::Controls {
                    en,
                    down: self.control(s.extra),
                    load: self.control(s.extra2),
                    aload: self.control(s.aload),
                    reset: self.control(s.reset),
                };
                counter::count(s.width, &[q], &[self.read(s.d, m)], &[s.set_value], &c, &mut next);
            }
            _ => counter::accumulate(
                s.width,
                &[q],
                &[self.read(s.d, m)],
                self.control(s.extra),
                en,
                self.control(s.reset),
                &mut next,
            ),
        }
        if next[0] != q {
            self.staged.push((s.q, next[0]));
        }
    }

    /// Writes all that was staged.
    #[inline(always)]
    pub fn take(&mut self, p: &Program) {
        for i in 0..self.staged.len() {
            let (slot, word) = self.staged[i];
            self.put(p, slot, word);
        }
        self.staged.clear();
        if self.memories.is_waiting() {
            self.take_memories(p);
        }
    }

    /// Fills the input scratch with the pins of a general cell; returns where each begins and ends.
    fn gather_pins(&mut self, g: &General) -> [(usize, usize); PINS] {
        let mut bounds = [(0, 0); PINS];
        let mut at = 0;
        for (pin, pieces) in g.pins.iter().enumerate() {
            let end = at + words(g.kind.input_width(pin));
            let to = &mut self.scratch_in[at..end];
            to.fill(Word::ZERO);
            if pieces.is_empty() {
                to[0] = Word::known(u64::from(g.kind.inputs()[pin].default));
            }
            let mut lo = 0;
            for &(slot, from, width) in pieces {
                copy(to, lo, &self.slots[slot as usize..], from, width);
                lo += width;
            }
            bounds[pin] = (at, end);
            at = end;
        }
        bounds
    }

    fn narrow<const STAGED: bool>(&mut self, p: &Program, op: &Op) {
        let cell = &p.narrows[op.ext as usize];
        let mut ins = [Word::ZERO; PINS];
        for (to, &(o, width)) in ins.iter_mut().zip(&p.pool[cell.pins.clone()]) {
            *to = self.read(o, mask(width));
        }
        let [mut y, mut y2, mut y3] = [[Word::ZERO]; 3];
        let ins = ins.each_ref().map(std::slice::from_ref);
        let mut outs: [&mut [Word]; 3] = [&mut y, &mut y2, &mut y3];
        evaluate(&cell.kind, &ins[..cell.pins.len()], &mut outs[..cell.outputs.len()]);
        for (&slot, y) in cell.outputs.iter().zip([y, y2, y3]) {
            self.out::<STAGED>(p, slot, y[0]);
        }
    }

    fn general<const STAGED: bool>(&mut self, p: &Program, op: &Op) {
        let g = &p.generals[op.ext as usize];
        let bounds = self.gather_pins(g);
        let mut out = std::mem::take(&mut self.scratch_out);
        let mut ins: [&[Word]; PINS] = [&[]; PINS];
        for (pin, b) in bounds.iter().enumerate().take(g.pins.len()) {
            ins[pin] = &self.scratch_in[b.0..b.1];
        }
        let mut at = 0;
        for &(slot, width) in &g.outputs {
            let n = words(width);
            out[at..at + n].copy_from_slice(&self.slots[slot as usize..slot as usize + n]);
            at += n;
        }
        let ins = &ins[..g.pins.len()];
        let n = |k: usize| words(g.outputs[k].1);
        let (y, rest) = out.split_at_mut(n(0));
        match g.outputs.len() {
            1 => evaluate(&g.kind, ins, &mut [y]),
            2 => evaluate(&g.kind, ins, &mut [y, &mut rest[..n(1)]]),
            _ => {
                let (y2, rest) = rest.split_at_mut(n(1));
                evaluate(&g.kind, ins, &mut [y, y2, &mut rest[..n(2)]]);
            }
        }
        at = 0;
        for k in 0..g.outputs.len() {
            let (slot, width) = p.generals[op.ext as usize].outputs[k];
            for i in 0..words(width) {
                self.out::<STAGED>(p, slot + i as u32, out[at + i]);
            }
            at += words(width);
        }
        self.scratch_out = out;
    }

    fn sample_general(&mut self, p: &Program, number: u32) {
        let g = &p.generals[number as usize];
        let bounds = self.gather_pins(g);
        let mut ins: [&[Word]; PINS] = [&[]; PINS];
        for (pin, b) in bounds.iter().enumerate().take(g.pins.len()) {
            ins[pin] = &self.scratch_in[b.0..b.1];
        }
        let (slot, width) = g.outputs[0];
        let n = words(width);
        let q = &self.slots[slot as usize..slot as usize + n];
        let next = &mut self.scratch_out[..n];
        clocked(&g.kind, &ins[..g.pins.len()], q, next);
        self.staged.extend(next.iter().enumerate().map(|(i, &w)| (slot + i as u32, w)));
    }

    /// Whether there is anything that whoever advances the engine should look at.
    #[inline(always)]
    pub fn has_news(&self) -> bool {
        !(self.changes.is_empty() && self.unknown_controls.is_empty())
    }

    /// Reports controls that have become unknown, those of cells that come first in the netlist first.
    #[inline(always)]
    pub fn check_controls(&mut self, p: &Program, now: u64) {
        if !self.doubtful.is_empty() {
            self.check_doubtful(p, now);
        }
    }

    #[inline(never)]
    fn check_doubtful(&mut self, p: &Program, now: u64) {
        let mut unknown = Vec::new();
        while let Some(slot) = self.doubtful.pop() {
            let hook = &p.hooks[self.meta[slot as usize].hook as usize];
            for &number in &p.hooked[hook.controls.clone()] {
                let pin = &p.controls[number as usize];
                if bit_of(self.slots[slot as usize], pin.shift).is_known() {
                    self.control_seen[number as usize] = true;
                } else if self.control_seen[number as usize] {
                    unknown.push(number);
                }
            }
        }
        unknown.sort_unstable();
        for number in unknown {
            let pin = &p.controls[number as usize];
            if !std::mem::replace(&mut self.reported[pin.cell.index()], true) {
                let (cell, pin, net) = (pin.cell, pin.pin, pin.net);
                self.unknown_controls.push(UnknownControl { time: now, cell, pin, net });
            }
        }
    }
}

/// Bits of a word of which the operand is not the whole; a call, so that whole words cost a branch and no more.
#[inline(never)]
fn part_of(w: Word, o: Operand, m: u64) -> Word {
    let w = Word { v: w.v >> o.shift, u: w.u >> o.shift };
    if o.part == Part::Splat { w.splat(m) } else { Word { v: w.v & m, u: w.u & m } }
}

#[inline(always)]
pub(super) fn bit_of(w: Word, shift: u8) -> Word {
    Word { v: w.v >> shift & 1, u: w.u >> shift & 1 }
}
