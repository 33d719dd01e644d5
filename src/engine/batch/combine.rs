//! What operations without a state do to all lanes of a block. Bit for bit the functions of the cell room.

use super::lanes::{Chunk, Four, LANES};
use super::program::{Code, ONE, Op, Program, Wake, ZERO};
use super::state::State;
use crate::cell::{AddOp, CompareOp, GateOp, evaluate};
use crate::value::Word;
use crate::value::word::words;

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
                GateOp::And | GateOp::Nand => self.gate::<K>(p, op, gate.inverts(), Four::and),
                GateOp::Xor | GateOp::Xnor => self.gate::<K>(p, op, gate.inverts(), Four::xor),
                _ => self.gate::<K>(p, op, gate.inverts(), Four::or),
            },
            Code::AndOr => self.and_or::<K>(p, op),
            Code::Mux => self.mux::<K>(p, op),
            Code::HalfAdder => self.full_adder::<K>(p, op, ZERO),
            Code::FullAdder => self.full_adder::<K>(p, op, p.pool[op.pins[2] as usize]),
            Code::Adder(add) => {
                let sub = match add {
                    AddOp::Add => ZERO,
                    AddOp::Sub => ONE,
                    AddOp::AddSub => p.pool[op.pins[3] as usize],
                };
                self.adder::<K>(p, op, sub);
            }
            Code::Compare(compare, signed) => self.compare::<K>(p, op, compare, signed),
            Code::BitMux => self.bit_mux::<K>(p, op),
            Code::OneHotMux => self.one_hot(p, op),
            Code::CarrySave => self.carry_save::<K>(p, op),
            Code::Tristate => self.tristate(p, op),
            Code::Resolve => self.resolve(p, op),
            Code::Sr { .. } | Code::Latch | Code::Flop | Code::Counter | Code::Accumulator => {
                self.level::<K>(p, op);
            }
            Code::General => self.general(p, op),
        }
    }

    #[inline(always)]
    fn gate<const K: bool>(&mut self, p: &Program, op: &Op, inverts: bool, join: impl Fn(Four, Four) -> Four) {
        let ins = &p.pool[op.pins[0] as usize..op.pins[1] as usize];
        let (width, inverted) = (op.width as usize, Chunk::splat(inverts));
        let finish = |w: Four| Four { v: (w.v ^ inverted) & !w.u, u: w.u };
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let [a, b] = [0, width].map(|at| self.planes.plane::<K>(*ins.get(i + at).unwrap_or(&0)));
            let changed = match op.inputs {
                1 => self.planes.write::<K>(y, |c| finish(a.get(c).read())),
                2 => self.planes.write::<K>(y, |c| finish(join(a.get(c), b.get(c)))),
                3 => {
                    let d = self.planes.plane::<K>(ins[i + 2 * width]);
                    self.planes.write::<K>(y, |c| finish(join(join(a.get(c), b.get(c)), d.get(c))))
                }
                _ => self.planes.write::<K>(y, |c| {
                    let mut all = join(a.get(c), b.get(c));
                    for &bit in ins[i..].iter().step_by(width).skip(2) {
                        all = join(all, self.planes.plane::<K>(bit).get(c));
                    }
                    finish(all)
                }),
            };
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn and_or<const K: bool>(&mut self, p: &Program, op: &Op) {
        let [ins, sel] = [0, 1].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        let width = op.width as usize;
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let changed = self.planes.write::<K>(y, |c| {
                let pairs = ins[i..].iter().step_by(width).zip(sel);
                pairs.fold(Four::default(), |all, (&a, &s)| {
                    all.or(self.planes.plane::<K>(a).get(c).and(self.planes.plane::<K>(s).get(c)))
                })
            });
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn mux<const K: bool>(&mut self, p: &Program, op: &Op) {
        let [ins, sel] = [0, 1].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        let (width, inputs) = (op.width as usize, op.inputs as usize);
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let changed = if inputs == 2 {
                let [a, b, s] = [ins[i], ins[i + width], sel[0]].map(|bit| self.planes.plane::<K>(bit));
                self.planes.write::<K>(y, |c| s.get(c).choose(a.get(c), b.get(c)))
            } else {
                let tree = &mut self.tree;
                let planes = &self.planes;
                planes.write::<K>(y, |c| {
                    // the inputs in pairs by the lowest bit of the select, what is chosen by the next; x beyond them
                    for k in 0..1 << sel.len() {
                        let input = ins.get(k * width + i);
                        tree[k] = input.map_or(Four::X, |&bit| planes.plane::<K>(bit).get(c));
                    }
                    for (j, &s) in sel.iter().enumerate() {
                        let s = planes.plane::<K>(s).get(c);
                        for k in 0..1 << (sel.len() - j - 1) {
                            tree[k] = s.choose(tree[2 * k], tree[2 * k + 1]);
                        }
                    }
                    tree[0]
                })
            };
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn full_adder<const K: bool>(&mut self, p: &Program, op: &Op, ci: u32) {
        let [a, b] = [0, 1].map(|pin| p.pool[op.pins[pin] as usize]);
        let [pa, pb, pc] = [a, b, ci].map(|bit| self.planes.plane::<K>(bit));
        let s = self.planes.write::<K>(op.outs[0], |c| pa.get(c).xor(pb.get(c)).xor(pc.get(c)));
        let co = self.planes.write::<K>(op.outs[1], |c| {
            let (a, b) = (pa.get(c), pb.get(c));
            a.and(b).or(a.xor(b).and(pc.get(c)))
        });
        for (bit, changed) in [(op.outs[0], s), (op.outs[1], co)] {
            self.tell(p, bit, changed);
        }
    }

    /// The lanes in which any of some bits is unknown, into the first scratch.
    #[inline(always)]
    pub fn find_unknown(&mut self, bits: impl Iterator<Item = u32>) {
        self.bad.fill(Chunk::ZERO);
        for bit in bits {
            if self.planes.may_be_unknown(bit) {
                let plane = self.planes.plane::<false>(bit);
                for (c, bad) in self.bad.iter_mut().enumerate() {
                    *bad |= plane.get(c).u;
                }
            }
        }
    }

    #[inline(always)]
    fn adder<const K: bool>(&mut self, p: &Program, op: &Op, sub: u32) {
        let [a, b, ci] = [0, 1, 2].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        if !K {
            self.find_unknown(a.iter().chain(b).chain([&ci[0], &sub]).copied());
        }
        let [ci, minus] = [ci[0], sub].map(|bit| self.planes.plane::<K>(bit));
        for (c, carry) in self.carry.iter_mut().enumerate() {
            *carry = ci.get(c).v ^ minus.get(c).v;
        }
        for i in 0..op.width as usize {
            let y = op.outs[0] + i as u32;
            let [a, b, sub] = [a[i], b[i], sub].map(|bit| self.planes.plane::<K>(bit));
            let (carries, bad) = (&mut self.carry, &self.bad);
            let changed = self.planes.write::<K>(y, |c| {
                let (a, b, carry) = (a.get(c).v, b.get(c).v ^ sub.get(c).v, carries[c]);
                let half = a ^ b;
                carries[c] = (a & b) | (half & carry);
                if K { Four::known(half ^ carry) } else { Four { v: (half ^ carry) & !bad[c], u: bad[c] } }
            });
            self.tell(p, y, changed);
        }
        if op.derived || op.group != 0 {
            let sub = self.planes.plane::<K>(sub);
            let (carries, bad) = (&self.carry, &self.bad);
            let changed = self.planes.write::<K>(op.outs[1], |c| {
                let co = carries[c] ^ sub.get(c).v;
                if K { Four::known(co) } else { Four { v: co & !bad[c], u: bad[c] } }
            });
            self.tell(p, op.outs[1], changed);
        }
    }

    #[inline(always)]
    fn compare<const K: bool>(&mut self, p: &Program, op: &Op, compare: CompareOp, signed: bool) {
        let [a, b] = [0, 1].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        let planes = &self.planes;
        let pair = |i: usize, c: usize| (planes.plane::<K>(a[i]).get(c), planes.plane::<K>(b[i]).get(c));
        let y = op.outs[0];
        let changed = match compare {
            CompareOp::Same | CompareOp::Differs => planes.write::<K>(y, |c| {
                let differs = (0..a.len()).fold(Chunk::ZERO, |all, i| {
                    let (a, b) = pair(i, c);
                    all | (a.v ^ b.v) | (a.u ^ b.u)
                });
                Four::known(differs ^ Chunk::splat(compare == CompareOp::Same))
            }),
            CompareOp::Eq | CompareOp::Ne => planes.write::<K>(y, |c| {
                let (mut differs, mut unknown) = (Chunk::ZERO, Chunk::ZERO);
                for i in 0..a.len() {
                    let (a, b) = pair(i, c);
                    differs |= (a.v ^ b.v) & !(a.u | b.u);
                    unknown |= a.u | b.u;
                }
                let u = unknown & !differs;
                Four { v: (differs ^ Chunk::splat(compare == CompareOp::Eq)) & !u, u }
            }),
            _ => {
                let swapped = matches!(compare, CompareOp::Gt | CompareOp::Le);
                let inverted = Chunk::splat(matches!(compare, CompareOp::Le | CompareOp::Ge));
                planes.write::<K>(y, |c| {
                    let (mut less, mut u) = (Chunk::ZERO, Chunk::ZERO);
                    for i in 0..a.len() {
                        let (a, b) = pair(i, c);
                        u |= a.u | b.u;
                        // of sign bits the one that is set is the less
                        let (a, b) = if swapped != (signed && i + 1 == op.inputs as usize) { (b, a) } else { (a, b) };
                        less = (!a.v & b.v) | (!(a.v ^ b.v) & less);
                    }
                    Four { v: (less ^ inverted) & !u, u }
                })
            }
        };
        self.tell(p, y, changed);
    }

    #[inline(always)]
    fn bit_mux<const K: bool>(&mut self, p: &Program, op: &Op) {
        for i in 0..op.width {
            let y = op.outs[0] + i;
            let [a, b, s] = [0, 1, 2].map(|pin| self.planes.plane::<K>(p.pool[(op.pins[pin] + i) as usize]));
            let changed = self.planes.write::<K>(y, |c| s.get(c).choose(a.get(c), b.get(c)));
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn carry_save<const K: bool>(&mut self, p: &Program, op: &Op) {
        for i in 0..op.width {
            let planes = [0, 1, 2].map(|pin| self.planes.plane::<K>(p.pool[(op.pins[pin] + i) as usize]));
            let known = |c: usize| {
                let all = planes.map(|plane| plane.get(c));
                let u = all[0].u | all[1].u | all[2].u;
                (all.map(|w| w.v & !u), u)
            };
            let (x, y) = (op.outs[0] + i, op.outs[1] + i);
            let carries = self.planes.write::<K>(x, |c| {
                let ([a, b, d], u) = known(c);
                Four { v: (a & b) | (d & (a ^ b)), u }
            });
            let sums = self.planes.write::<K>(y, |c| {
                let ([a, b, d], u) = known(c);
                Four { v: (a ^ b ^ d) & !u, u }
            });
            self.tell(p, x, carries);
            self.tell(p, y, sums);
        }
    }

    #[inline(always)]
    fn one_hot(&mut self, p: &Program, op: &Op) {
        let [a, b, s] = [0, 1, 2].map(|pin| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize]);
        let width = op.width as usize;
        for c in 0..self.planes.chunks {
            let (mut one, mut bad) = (Chunk::ZERO, Chunk::ZERO);
            for &line in s {
                let line = self.planes.plane::<false>(line).get(c);
                bad |= line.u | (one & line.ones());
                one |= line.ones();
            }
            (self.carry[c], self.bad[c]) = (one, bad);
        }
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let held = self.planes.plane::<false>(a[i]);
            let changed = self.planes.write::<false>(y, |c| {
                let (one, bad) = (self.carry[c], self.bad[c]);
                let chosen = s.iter().enumerate().fold(held.get(c).within(!one), |all, (k, &line)| {
                    let line = self.planes.plane::<false>(line).get(c).ones();
                    all.join(self.planes.plane::<false>(b[k * width + i]).get(c).within(line))
                });
                chosen.within(!bad).join(Four::X.within(bad))
            });
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn tristate(&mut self, p: &Program, op: &Op) {
        for i in 0..op.width {
            let en = self.planes.plane::<false>(p.pool[op.pins[1] as usize]);
            let (a, y) = (self.planes.plane::<false>(p.pool[(op.pins[0] + i) as usize]), op.outs[0] + i);
            let changed = self.planes.write::<false>(y, |c| {
                let en = en.get(c);
                a.get(c).within(en.ones()).join(Four::Z.within(en.zeros())).join(Four::X.within(en.u))
            });
            self.tell(p, y, changed);
        }
    }

    #[inline(always)]
    fn resolve(&mut self, p: &Program, op: &Op) {
        let ins = &p.pool[op.pins[0] as usize..op.pins[1] as usize];
        let width = op.width as usize;
        for i in 0..width {
            let y = op.outs[0] + i as u32;
            let changed = self.planes.write::<false>(y, |c| {
                let drivers = ins[i..].iter().step_by(width);
                drivers.fold(Four::Z, |all, &bit| all.resolve(self.planes.plane::<false>(bit).get(c)))
            });
            self.tell(p, y, changed);
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

/// Whether bit `at` of a known value is 1.
pub(super) fn bit_of_value(value: &crate::Value, at: u32) -> bool {
    value.words().nth(at as usize / 64).is_some_and(|w| w.v >> (at % 64) & 1 == 1)
}

/// Bit `at` of a vector.
pub(super) fn bit_of(words: &[Word], at: u32) -> Word {
    let (word, shift) = (at as usize / 64, at % 64);
    Word { v: words[word].v >> shift & 1, u: words[word].u >> shift & 1 }
}
