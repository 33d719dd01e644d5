//! The present values, one operation, one change.

use std::collections::HashMap;

use super::super::UnknownControl;
use super::memory::Memories;
use super::program::{Code, General, Meta, ONE, Op, Operand, Part, Program, Store, StoreCode, flag};
use super::sites::{EVERY, Operation, Stored};
use crate::cell::memory::merged;
use crate::cell::pin::flop;
use crate::cell::{
    AddOp, GateOp, Words, arith, choose, clocked, counter, evaluate, evaluate_held, gate, select, storage,
};
use crate::force::Held;
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
    /// Words that are held at something, by slot, and whether there are any.
    pub forces: HashMap<u32, Held>,
    pub forcing: bool,
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
            forces: HashMap::new(),
            forcing: false,
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
    pub fn control(&self, o: Operand) -> Word {
        if o.slot <= ONE.slot { Word::known(o.slot.into()) } else { self.read(o, 1) }
    }

    /// Writes a slot; if that changes it, wakes what reads it.
    #[inline(always)]
    pub fn put(&mut self, p: &Program, slot: u32, new: Word) {
        let new = if self.forcing { self.forced(slot, new) } else { new };
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
        let l = &mut Words;
        // a macro, so that each gate is a branch of this match and none within it
        macro_rules! two {
            ($gate:ident) => {
                gate::gate_word(l, GateOp::$gate, 2, m, |_, k| self.read(if k == 0 { op.a } else { op.b }, m))
            };
        }
        let y = match op.code {
            // these join to known bits and x alone, so there is nothing to finish
            Code::And2 => gate::join(l, GateOp::And, self.read(op.a, m), self.read(op.b, m)),
            Code::Or2 => gate::join(l, GateOp::Or, self.read(op.a, m), self.read(op.b, m)),
            Code::Xor2 => gate::join(l, GateOp::Xor, self.read(op.a, m), self.read(op.b, m)),
            Code::Nand2 => two!(Nand),
            Code::Nor2 => two!(Nor),
            Code::Xnor2 => two!(Xnor),
            Code::Buf => gate::finish(l, GateOp::Buf, self.read(op.a, m), m),
            Code::Not => gate::finish(l, GateOp::Not, self.read(op.a, m), m),
            Code::Reduce(gate) => {
                let joined = gate::reduce(l, gate, self.read(op.a, m), m);
                gate::finish(l, gate, joined, 1)
            }
            Code::GateN(gate) => {
                let inputs = &p.pool[op.ext as usize..(op.ext + op.count) as usize];
                gate::gate_word(l, gate, inputs.len(), m, |_, k| self.read(inputs[k].0, m))
            }
            Code::AndOrN => {
                let pairs = &p.pool[op.ext as usize..(op.ext + 2 * op.count) as usize];
                pairs.chunks_exact(2).fold(Word::ZERO, |all, pair| {
                    gate::and_or_step(l, all, self.read(pair[0].0, m), self.read(pair[1].0, m))
                })
            }
            Code::Mux2 => {
                let s = self.read(op.c, 1);
                let number = s.is_known().then_some(s.v);
                select::mux_word(l, 2, m, number, |_, _| s, |_, k| self.read(if k == 0 { op.a } else { op.b }, m))
            }
            Code::Mux => {
                let inputs = &p.pool[op.ext as usize..];
                let s = self.read(op.c, mask(select::select_width(op.count)));
                let number = s.is_known().then_some(s.v);
                let input = |_: &mut Words, k: u32| self.read(inputs[k as usize].0, m);
                select::mux_word(l, op.count, m, number, |_, bit| bit_of(s, bit as u8), input)
            }
            Code::OneHotMux => {
                let s = self.read(op.c, mask(op.count));
                let lines = choose::lines(l, op.count, |_| s);
                choose::one_hot_word(
                    l,
                    op.count,
                    m,
                    &lines,
                    |_| s,
                    self.read(op.a, m),
                    |_, k| self.read(p.pool[(op.ext + k) as usize].0, m),
                )
            }
            Code::Compare { op: compare, signed } => {
                let mut site = Operation::new([self.read(op.a, m), self.read(op.b, m), Word::ZERO], Word::ZERO);
                select::compare(l, &mut site, compare, op.count, signed);
                site.outs[0]
            }
            Code::HalfAdder => {
                let mut site = Operation::new([self.read(op.a, 1), self.read(op.b, 1), Word::ZERO], Word::ZERO);
                arith::half_adder(l, &mut site);
                self.out::<STAGED>(p, op.y2, site.outs[1]);
                site.outs[0]
            }
            Code::FullAdder => {
                let ins = [self.read(op.a, 1), self.read(op.b, 1), self.read(op.c, 1)];
                let mut site = Operation::new(ins, Word::ZERO);
                arith::full_adder(l, &mut site);
                self.out::<STAGED>(p, op.y2, site.outs[1]);
                site.outs[0]
            }
            Code::Add | Code::Sub => {
                let way = if op.code == Code::Sub { AddOp::Sub } else { AddOp::Add };
                let ins = [self.read(op.a, m), self.read(op.b, m), self.read(op.c, 1)];
                let mut site = Operation::new(ins, Word::ZERO);
                arith::adder(l, &mut site, way, op.count);
                self.out::<STAGED>(p, op.y2, site.outs[1]);
                site.outs[0]
            }
            Code::Sr { set_dominates } => {
                let ins = [self.read(op.a, 1), self.read(op.b, 1), Word::ZERO];
                let mut site = Operation::new(ins, self.read(op.c, 1));
                storage::sr(l, &mut site, set_dominates);
                site.q = if self.forcing { self.forced(op.y, site.outs[0]) } else { site.outs[0] };
                storage::inverse(l, &mut site, 1);
                self.out::<STAGED>(p, op.y2, site.outs[1]);
                site.q
            }
            Code::SetReset => {
                let s = &p.stores[op.ext as usize];
                let ins = [self.read(op.a, 1), self.read(op.b, 1), Word::ZERO];
                let mut site = Operation::new(ins, self.slots[op.y as usize]);
                let pins = storage::Asynchronous { d: 2, load: 2, set: 0, reset: 1 };
                storage::level(l, &mut site, pins, 1, |_, _| (s.set_value, s.reset_value));
                site.outs[0]
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
        let mut site = Stored::<EVERY>::new(self, s, m);
        let l = &mut Words;
        match s.code {
            StoreCode::Counter => counter::level(l, &mut site, s.width),
            StoreCode::Accumulator => counter::clear(l, &mut site, s.width),
            StoreCode::Plain | StoreCode::SetReset | StoreCode::Flop | StoreCode::Memory | StoreCode::General => {
                storage::level(l, &mut site, storage::OF_FLOP, 1, |_, _| (s.set_value, s.reset_value));
            }
        }
        site.q = site.next;
        if let Some(held) = self.forces.get(&s.q).filter(|_| self.forcing) {
            site.q = merged(site.q, held.mask, held.value);
        }
        match s.code {
            StoreCode::Counter => counter::zero(l, &mut site, s.width),
            StoreCode::Accumulator => counter::carry(l, &mut site, s.width),
            StoreCode::Plain | StoreCode::SetReset | StoreCode::Flop | StoreCode::Memory | StoreCode::General => {
                storage::inverse(l, &mut site, s.width)
            }
        }
        (site.q, site.derived)
    }

    /// Computes what a store takes at its active edge, for [`State::take`] to write.
    #[inline(always)]
    pub fn sample(&mut self, p: &Program, number: u32) {
        let s = &p.stores[number as usize];
        let m = mask(s.width);
        let q = self.slots[s.q as usize];
        let next = match s.code {
            StoreCode::General => return self.sample_general(p, s.general),
            StoreCode::Memory => return self.memories.edges.push((s.general, s.q)),
            StoreCode::Plain => self.sample_flop::<{ 1 << flop::D | 1 << flop::EN }>(s, m),
            StoreCode::SetReset => self.sample_flop::<{ 1 << flop::D | 1 << flop::SET | 1 << flop::RESET }>(s, m),
            StoreCode::Flop => self.sample_flop::<EVERY>(s, m),
            StoreCode::Counter => {
                let mut site = Stored::<EVERY>::new(self, s, m);
                counter::count(&mut Words, &mut site, s.width, None, |_, _| s.set_value);
                site.next
            }
            StoreCode::Accumulator => {
                let mut site = Stored::<EVERY>::new(self, s, m);
                counter::accumulate(&mut Words, &mut site, s.width, None);
                site.next
            }
        };
        if next != q {
            self.staged.push((s.q, next));
        }
    }

    /// What a flip-flop takes of which these pins alone are connected.
    #[inline(always)]
    fn sample_flop<const PINS: u32>(&self, s: &Store, m: u64) -> Word {
        let mut site = Stored::<PINS>::new(self, s, m);
        storage::flop_edge(&mut Words, &mut site, 1, None, |_, _| (s.set_value, s.reset_value));
        site.next
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
            2 if self.forcing && g.kind.init().is_some() => {
                let slot = g.outputs[0].0;
                evaluate_held(&g.kind, ins, &mut [y, &mut rest[..n(1)]], |i, word| {
                    let held = self.forces.get(&(slot + i as u32));
                    held.map_or(word, |held| merged(word, held.mask, held.value))
                });
            }
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
