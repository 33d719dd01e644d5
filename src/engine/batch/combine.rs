//! What operations do to all lanes of a block: the meaning of cells, in the algebra of [`Lanes`]; and, for cells that are
//! larger than that is good for, in machine words, lane by lane.

use super::lanes::{Four, LANES, Lanes, Planes};
use super::program::{Code, Op, Program, Store, Wake};
use super::state::State;
use crate::cell::{Algebra, GateOp, Site, act, at_edge, derived, evaluate, gate, level};
use crate::value::Word;
use crate::value::word::words;

/// An operation in one chunk of lanes. With `K` nothing that it reads is unknown, and nothing that it gives.
struct Place<'s, const K: bool> {
    p: &'s Program,
    op: &'s Op,
    planes: &'s Planes,
    /// The first bit of the state that it reads, and of each output.
    q: u32,
    outs: [u32; 3],
    c: usize,
    /// What has been seen of each bit that it gives, those of the second output after those of the first.
    seen: &'s mut [Seen],
    /// By output: whether it has been given in any chunk, and whether it has been held in any.
    given: [bool; 3],
    held: bool,
    /// What is held is to be copied to the output, which is another bit than the state.
    copies: bool,
}

/// What has been seen of a bit in the chunks so far.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Seen {
    changed: bool,
    unknown: bool,
}

impl<const K: bool> Place<'_, K> {
    #[inline(always)]
    fn read(&self, bit: u32) -> Four {
        self.planes.plane::<K>(bit).get(self.c)
    }

    #[inline(always)]
    fn write(&mut self, output: usize, i: usize, c: usize, new: Four) {
        let bit = self.outs[output] + i as u32;
        let seen = &mut self.seen[output * self.op.width as usize + i];
        let changed =
            if K { self.planes.plane::<true>(bit).put(c, new) } else { self.planes.plane::<false>(bit).put(c, new) };
        seen.changed |= changed.any();
        if !K {
            seen.unknown |= new.u.any();
        }
    }

    /// Copies the state to the output in a chunk.
    #[inline(always)]
    fn keep(&mut self, c: usize) {
        for i in 0..self.op.width {
            let held = self.planes.plane::<K>(self.q + i).get(c);
            self.write(0, i as usize, c, held);
        }
    }

    /// Goes to a chunk.
    #[inline(always)]
    fn at(&mut self, c: usize) {
        self.c = c;
    }
}

impl<const K: bool> Site<Lanes> for Place<'_, K> {
    #[inline(always)]
    fn get(&self, pin: usize, i: usize) -> Four {
        self.read(self.p.pool[self.op.pins[pin] as usize + i])
    }

    #[inline(always)]
    fn state(&self, i: usize) -> Four {
        self.read(self.q + i as u32)
    }

    #[inline(always)]
    fn put(&mut self, output: usize, i: usize, w: Four) {
        if !self.given[output] {
            self.given[output] = true;
            if output == 0 && self.copies {
                // the chunks before
                (0..self.c).for_each(|c| self.keep(c));
            }
        }
        self.write(output, i, self.c, w);
    }

    #[inline(always)]
    fn hold(&mut self) {
        if !self.copies {
            self.held = true;
        } else if self.given[0] {
            self.keep(self.c);
        }
    }
}

impl State {
    /// Marks what reads a bit.
    #[inline(always)]
    pub fn wake(&mut self, p: &Program, bit: u32) {
        for wake in p.woken(bit) {
            match *wake {
                Wake::Op(number) => {
                    let word = number as usize / 64;
                    self.dirty[word] |= 1 << (number % 64);
                    self.lowest = self.lowest.min(word);
                }
                Wake::Watch(number) => {
                    if !std::mem::replace(&mut self.watched[number as usize].pending, true) {
                        self.pending.push(number);
                    }
                }
            }
        }
    }

    /// Marks what reads a bit, if any lane of it has changed.
    #[inline(always)]
    pub fn tell(&mut self, p: &Program, bit: u32, changed: bool) {
        if changed {
            self.wake(p, bit);
        }
    }

    /// Runs one operation; nothing that it reads is unknown with `K`.
    #[inline(always)]
    pub fn run<const K: bool>(&mut self, p: &Program, op: &Op) {
        match op.code {
            Code::Gate(gate) => match gate {
                GateOp::And | GateOp::Nand => self.gate::<K>(p, op, GateOp::And, gate.inverts()),
                GateOp::Xor | GateOp::Xnor => self.gate::<K>(p, op, GateOp::Xor, gate.inverts()),
                GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => {
                    self.gate::<K>(p, op, GateOp::Or, gate.inverts());
                }
            },
            Code::Mux2 => self.mux::<K>(p, op),
            Code::Cell => self.cell::<K>(p, op),
            Code::Storage => self.storage::<K>(p, op),
            Code::General => self.general(p, op),
        }
    }

    /// A gate, bit by bit in all chunks: what most of a netlist is.
    #[inline(always)]
    fn gate<const K: bool>(&mut self, p: &Program, op: &Op, join: GateOp, inverts: bool) {
        let ins = &p.pool[op.pins[0] as usize..op.pins[1] as usize];
        let width = op.width as usize;
        let l = &mut Lanes;
        let last = if inverts { GateOp::Not } else { GateOp::Buf };
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let [a, b] = [0, width].map(|at| self.planes.plane::<K>(*ins.get(i + at).unwrap_or(&0)));
            let changed = match op.inputs {
                1 => self.planes.write::<K>(y, |c| gate::finish(l, last, a.get(c), 1)),
                2 => self.planes.write::<K>(y, |c| {
                    let all = gate::join(l, join, a.get(c), b.get(c));
                    gate::finish(l, last, all, 1)
                }),
                3 => {
                    let d = self.planes.plane::<K>(ins[i + 2 * width]);
                    self.planes.write::<K>(y, |c| {
                        let all = gate::join(l, join, a.get(c), b.get(c));
                        let all = gate::join(l, join, all, d.get(c));
                        gate::finish(l, last, all, 1)
                    })
                }
                _ => self.planes.write::<K>(y, |c| {
                    let mut all = gate::join(l, join, a.get(c), b.get(c));
                    for &bit in ins[i..].iter().step_by(width).skip(2) {
                        all = gate::join(l, join, all, self.planes.plane::<K>(bit).get(c));
                    }
                    gate::finish(l, last, all, 1)
                }),
            };
            self.tell(p, y, changed);
        }
    }

    /// A multiplexer of two inputs, bit by bit in all chunks.
    #[inline(always)]
    fn mux<const K: bool>(&mut self, p: &Program, op: &Op) {
        let [ins, sel] = [0, 1].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        let width = op.width as usize;
        let l = &mut Lanes;
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let [a, b, s] = [ins[i], ins[i + width], sel[0]].map(|bit| self.planes.plane::<K>(bit));
            let changed = self.planes.write::<K>(y, |c| l.mux4(s.get(c), b.get(c), a.get(c)));
            self.tell(p, y, changed);
        }
    }

    /// Any cell without a state, chunk by chunk.
    #[inline(always)]
    fn cell<const K: bool>(&mut self, p: &Program, op: &Op) {
        let kind = &p.cells[op.cell as usize];
        let mut seen = std::mem::take(&mut self.seen);
        let mut place = Place::<K> {
            p,
            op,
            planes: &self.planes,
            q: 0,
            outs: op.outs,
            c: 0,
            seen: &mut seen,
            given: [false; 3],
            held: false,
            copies: false,
        };
        for c in 0..self.planes.chunks {
            place.at(c);
            act(&mut Lanes, kind, &mut place);
        }
        let given = place.given;
        self.report::<K>(p, op, op.outs, &mut seen, given, false, true);
        self.seen = seen;
    }

    /// What a storage cell does without a clock, and the output made from its state.
    #[inline(always)]
    fn storage<const K: bool>(&mut self, p: &Program, op: &Op) {
        let kind = &p.cells[op.cell as usize];
        let mut seen = std::mem::take(&mut self.seen);
        let q = p.pool[op.pins[op.pin_count as usize - 1] as usize];
        // in a feedback group the outputs are copies, which have to be written in any case
        let copies = op.group != 0;
        let mut place = Place::<K> {
            p,
            op,
            planes: &self.planes,
            q,
            outs: op.outs,
            c: 0,
            seen: &mut seen,
            given: [copies, false, false],
            held: false,
            copies,
        };
        for c in 0..self.planes.chunks {
            place.at(c);
            level(&mut Lanes, kind, &mut place);
        }
        place.q = op.outs[0];
        if op.derived {
            for c in 0..self.planes.chunks {
                place.at(c);
                derived(&mut Lanes, kind, &mut place);
            }
        }
        let (given, held) = (place.given, place.held);
        self.report::<K>(p, op, op.outs, &mut seen, given, held, true);
        self.seen = seen;
    }

    /// Computes what a store takes in the lanes of its trigger mask, for the commit to write. Returns whether any lane
    /// may change.
    #[inline(always)]
    pub fn sample<const K: bool>(&mut self, p: &Program, store: &Store, number: usize) -> bool {
        let kind = &p.cells[store.op.cell as usize];
        let mut seen = std::mem::take(&mut self.seen);
        let outs = [store.next, 0, 0];
        let mut place = Place::<K> {
            p,
            op: &store.op,
            planes: &self.planes,
            q: store.q,
            outs,
            c: 0,
            seen: &mut seen,
            given: [false; 3],
            held: false,
            copies: true,
        };
        for c in 0..self.planes.chunks {
            place.at(c);
            at_edge(&mut Lanes, kind, Some(self.triggers[number][c]), &mut place);
        }
        let given = place.given;
        // nobody reads what waits to be committed
        self.report::<K>(p, &store.op, outs, &mut seen, given, false, false);
        self.seen = seen;
        given[0]
    }

    /// Notes which bits may be unknown, and tells of those that have changed; clears what has been seen.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what a place has seen, one by one")]
    fn report<const K: bool>(
        &mut self,
        p: &Program,
        op: &Op,
        outs: [u32; 3],
        seen: &mut [Seen],
        given: [bool; 3],
        held: bool,
        tells: bool,
    ) {
        let kind = &p.cells[op.cell as usize];
        for output in 0..3 {
            if !given[output] {
                continue;
            }
            for i in 0..kind.output_width(output) {
                let bit = outs[output] + i;
                let seen = std::mem::take(&mut seen[output * op.width as usize + i as usize]);
                let mut changed = seen.changed;
                if K {
                    changed |= self.planes.may_be_unknown(bit) && self.planes.clear_unknown(bit);
                } else {
                    let before = output == 0 && held && self.planes.may_be_unknown(bit);
                    self.planes.set_unknown(bit, seen.unknown || before);
                }
                if tells {
                    self.tell(p, bit, changed);
                }
            }
        }
    }

    /// Any cell, in the lanes that run, one by one.
    fn general(&mut self, p: &Program, op: &Op) {
        let kind = &p.cells[op.cell as usize];
        let pins = kind.inputs().len();
        let outputs = kind.outputs().len();
        let widths: Vec<u32> = (0..outputs).map(|pin| kind.output_width(pin)).collect();
        let mut outs: Vec<Vec<Word>> = widths.iter().map(|&w| vec![Word::ZERO; words(w)]).collect();
        let mut ins: Vec<Vec<Word>> = vec![Vec::new(); pins];
        let mut changed: Vec<Vec<bool>> = widths.iter().map(|&w| vec![false; w as usize]).collect();
        for lane in 0..self.lanes() {
            // the others begin anew before anything is read of them
            if self.active[lane / LANES].0[lane % LANES / 64] >> (lane % 64) & 1 == 0 {
                continue;
            }
            for (pin, words) in ins.iter_mut().enumerate() {
                self.gather(&p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize], lane, words);
            }
            let slices: Vec<&[Word]> = ins.iter().map(Vec::as_slice).collect();
            let mut views: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
            evaluate(kind, &slices, &mut views);
            for (pin, out) in outs.iter().enumerate() {
                for bit in 0..widths[pin] {
                    changed[pin][bit as usize] |= self.planes.set_lane(op.outs[pin] + bit, lane, bit_of(out, bit));
                }
            }
        }
        for (pin, changed) in changed.iter().enumerate() {
            for bit in changed.iter().enumerate().filter(|c| *c.1).map(|c| op.outs[pin] + c.0 as u32) {
                self.wake(p, bit);
            }
        }
    }

    /// Some bits of one lane as words.
    pub fn gather(&self, bits: &[u32], lane: usize, to: &mut Vec<Word>) {
        to.clear();
        to.resize(words(bits.len() as u32).max(1), Word::ZERO);
        for (i, &bit) in bits.iter().enumerate() {
            let w = self.planes.lane(bit, lane);
            to[i / 64].v |= w.v << (i % 64);
            to[i / 64].u |= w.u << (i % 64);
        }
    }
}

/// Bit `at` of a vector.
pub(super) fn bit_of(words: &[Word], at: u32) -> Word {
    let (word, shift) = (at as usize / 64, at % 64);
    Word { v: words[word].v >> shift & 1, u: words[word].u >> shift & 1 }
}
