//! What storage cells do to all lanes of a block: at once by their levels, and at a clock edge.

use super::combine::bit_of;
use super::lanes::{Chunk, Four, LANES};
use super::program::{Code, Op, Program, Store};
use super::state::State;
use crate::Value;
use crate::cell::{CellKind, clocked};
use crate::value::Word;
use crate::value::word::words;

/// Bit `at` of a value.
fn value_bit(value: &Value, at: u32) -> Word {
    let whole = value.words().nth(at as usize / 64).unwrap_or_default();
    Word { v: whole.v >> (at % 64) & 1, u: whole.u >> (at % 64) & 1 }
}

/// The set and the reset value of a cell, as far as it has them.
fn values(kind: &CellKind, bit: u32) -> (Word, Word) {
    match kind {
        CellKind::Flop(f) | CellKind::Latch(f) | CellKind::EdgeFlop(f) => {
            (value_bit(&f.set_value, bit), value_bit(&f.reset_value, bit))
        }
        _ => (Word::ZERO, Word::ZERO),
    }
}

impl State {
    /// What a storage cell does without a clock, and the output made from its state.
    #[inline(always)]
    pub fn level<const K: bool>(&mut self, p: &Program, op: &Op) {
        let pin = |pin: usize| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize];
        let q = pin(op.pin_count as usize - 1);
        let kind = &p.cells[op.cell as usize];
        // reset, set, load, and what is loaded
        let (reset, set, load, d) = match op.code {
            Code::Sr { .. } => (pin(1)[0], pin(0)[0], 0, &[][..]),
            Code::Latch => (pin(3)[0], pin(2)[0], pin(0)[0], pin(1)),
            Code::Flop => (pin(4)[0], pin(3)[0], pin(2)[0], pin(1)),
            Code::Counter => (pin(3)[0], 0, pin(2)[0], pin(1)),
            _ => (pin(3)[0], 0, 0, &[][..]),
        };
        let [resets, sets, loads] = [reset, set, load].map(|bit| self.planes.plane::<K>(bit));
        let set_dominates = matches!(op.code, Code::Sr { set_dominates: true });
        let mut any = Chunk::ZERO;
        for c in 0..self.planes.chunks {
            let (mut reset, mut set, load) = (resets.get(c).ones(), sets.get(c).ones(), loads.get(c).ones());
            if set_dominates {
                reset = reset & !set;
            } else {
                set = set & !reset;
            }
            any |= reset | set | load;
            self.masks[0][c] = reset;
            self.masks[1][c] = set;
            self.masks[2][c] = load & !reset & !set;
        }
        // in a feedback group the outputs are copies, which have to be written in any case
        if any.any() || op.group != 0 {
            for i in 0..op.width {
                let (set, reset) = match op.code {
                    Code::Sr { .. } => (Word::known(1), Word::ZERO),
                    _ => values(kind, i),
                };
                let d = d.get(i as usize).copied().unwrap_or(0);
                self.take::<K>(p, q[i as usize], d, op.outs[0] + i, set, reset);
            }
        }
        if op.derived {
            self.derive::<K>(p, op);
        }
    }

    /// A bit of state where `masks` say what becomes of it: reset, set, loaded, or kept.
    #[inline(always)]
    fn take<const K: bool>(&mut self, p: &Program, q: u32, d: u32, y: u32, set: Word, reset: Word) {
        let [q, d] = [q, d].map(|bit| self.planes.plane::<K>(bit));
        let (set, reset) = (Four::splat(set), Four::splat(reset));
        let [to_reset, to_set, to_load] = &self.masks;
        let changed = self.planes.write::<K>(y, |c| {
            let keep = !(to_reset[c] | to_set[c] | to_load[c]);
            let held = q.get(c).within(keep).join(d.get(c).within(to_load[c]));
            held.join(set.within(to_set[c])).join(reset.within(to_reset[c]))
        });
        self.tell(p, y, changed);
    }

    /// The output made from the state.
    #[inline(always)]
    fn derive<const K: bool>(&mut self, p: &Program, op: &Op) {
        let q = |i: u32| op.outs[0] + i;
        let y = op.outs[1];
        match op.code {
            Code::Counter => {
                let planes = &self.planes;
                let changed = planes.write::<K>(y, |c| {
                    (0..op.width).fold(Four::default(), |all, i| all.or(planes.plane::<K>(q(i)).get(c))).not()
                });
                self.tell(p, y, changed);
            }
            Code::Accumulator => {
                let pin = |pin: usize| &p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize];
                let (d, ci) = (pin(1), pin(2)[0]);
                if !K {
                    self.find_unknown(d.iter().copied().chain([ci]).chain((0..op.width).map(q)));
                }
                let (planes, bad) = (&self.planes, &self.bad);
                let changed = planes.write::<K>(y, |c| {
                    let carry = (0..op.width).fold(planes.plane::<K>(ci).get(c).v, |carry, i| {
                        let (a, b) = (planes.plane::<K>(q(i)).get(c).v, planes.plane::<K>(d[i as usize]).get(c).v);
                        (a & b) | ((a ^ b) & carry)
                    });
                    if K { Four::known(carry) } else { Four { v: carry & !bad[c], u: bad[c] } }
                });
                self.tell(p, y, changed);
            }
            _ => {
                for i in 0..op.width {
                    let q = self.planes.plane::<K>(q(i));
                    let changed = self.planes.write::<K>(y + i, |c| q.get(c).not());
                    self.tell(p, y + i, changed);
                }
            }
        }
    }

    /// Computes what a store takes in the lanes of its trigger mask, for the commit to write. Returns whether any lane
    /// may change.
    #[inline(always)]
    pub fn sample<const K: bool>(&mut self, p: &Program, store: &Store, number: usize) -> bool {
        let op = &store.op;
        let pin = |pin: usize| p.pool[op.pins[pin] as usize];
        let data = |pin: usize| op.pins[pin];
        // reset, set, load, then the synchronous ones and the enable; 0 where there is none
        let (controls, d) = match (op.code, &p.cells[op.cell as usize]) {
            (Code::Flop, _) => ([pin(4), pin(3), pin(2), pin(7), pin(6), pin(5)], data(1)),
            (Code::Counter, _) => ([pin(3), 0, pin(2), 0, 0, pin(4)], data(1)),
            (Code::Accumulator, _) => ([pin(3), 0, 0, 0, 0, pin(4)], data(1)),
            (_, CellKind::EdgeFlop(_)) => ([pin(5), pin(4), 0, 0, 0, 0], data(1)),
            _ => unreachable!("no other cell has a clock"),
        };
        let late_load = if op.code == Code::Counter { pin(6) } else { 0 };
        let planes = controls.map(|bit| self.planes.plane::<K>(bit));
        let late = self.planes.plane::<K>(late_load);
        let mut any = Chunk::ZERO;
        for c in 0..self.planes.chunks {
            let [reset, set, load, sync_reset, sync_set, en] = planes.map(|plane| plane.get(c).ones());
            let mut rest = self.triggers[number][c];
            let mut pick = |control: Chunk| {
                let picked = rest & control;
                rest = rest & !control;
                picked
            };
            let mut reset = pick(reset);
            let mut set = pick(set);
            let mut load = pick(load | late.get(c).ones());
            reset |= pick(sync_reset);
            set |= pick(sync_set);
            let counts = pick(en);
            let flop = op.code == Code::Flop;
            if flop {
                load |= counts;
            }
            self.masks[0][c] = reset;
            self.masks[1][c] = set;
            self.masks[2][c] = load;
            self.counts[c] = if flop { Chunk::ZERO } else { counts };
            any |= reset | set | load | counts;
        }
        if !any.any() {
            return false;
        }
        match op.code {
            Code::Flop => {}
            Code::Counter if K && store.by_one => {
                self.count_by_one(p, store, pin(5));
                return true;
            }
            _ => self.add::<K>(p, store),
        }
        let kind = &p.cells[op.cell as usize];
        for i in 0..op.width {
            let (set, reset) = values(kind, i);
            let (from, d) = if op.code == Code::Flop {
                (store.q + i, p.pool[(d + i) as usize])
            } else {
                (store.next + i, p.pool[(d + i) as usize])
            };
            let d = if op.code == Code::Accumulator { 0 } else { d };
            let [q, d] = [from, d].map(|bit| self.planes.plane::<K>(bit));
            let (set, reset) = (Four::splat(set), Four::splat(reset));
            let [to_reset, to_set, to_load] = &self.masks;
            self.planes.write::<K>(store.next + i, |c| {
                let keep = !(to_reset[c] | to_set[c] | to_load[c]);
                let held = q.get(c).within(keep).join(d.get(c).within(to_load[c]));
                held.join(set.within(to_set[c])).join(reset.within(to_reset[c]))
            });
        }
        true
    }

    /// A counter that goes by 1, all of whose bits are known.
    #[inline(always)]
    fn count_by_one(&mut self, p: &Program, store: &Store, down: u32) {
        let op = &store.op;
        for i in 0..op.width {
            let [q, d, down] =
                [store.q + i, p.pool[(op.pins[1] + i) as usize], down].map(|b| self.planes.plane::<true>(b));
            let carries = &mut self.counts;
            let [to_reset, _, to_load] = &self.masks;
            self.planes.write::<true>(store.next + i, |c| {
                let q = q.get(c).v;
                let carry = carries[c];
                carries[c] = carry & (q ^ down.get(c).v);
                let kept = (q ^ carry) & !(to_reset[c] | to_load[c]);
                Four::known(kept | (d.get(c).v & to_load[c]))
            });
        }
    }

    /// The state plus or minus what is added, where `counts` say so, into the next state.
    #[inline(always)]
    fn add<const K: bool>(&mut self, p: &Program, store: &Store) {
        let op = &store.op;
        let counter = op.code == Code::Counter;
        let kind = &p.cells[op.cell as usize];
        let pin = |pin: usize| p.pool[op.pins[pin] as usize];
        let (ci, sub) = if counter { (0, pin(5)) } else { (pin(2), 0) };
        let state = store.q..store.q + op.width;
        if !K {
            if counter {
                self.find_unknown(state.chain([sub]));
            } else {
                let d = &p.pool[op.pins[1] as usize..op.pins[2] as usize];
                self.find_unknown(state.chain([ci]).chain(d.iter().copied()));
            }
            if matches!(kind, CellKind::Counter(k) if !k.step.is_known()) {
                self.bad.fill(Chunk::ONES);
            }
        }
        let [carry_in, minus] = [ci, sub].map(|bit| self.planes.plane::<K>(bit));
        for (c, carry) in self.carry.iter_mut().enumerate() {
            *carry = carry_in.get(c).v ^ minus.get(c).v;
        }
        for i in 0..op.width {
            let step = match kind {
                CellKind::Counter(k) => Chunk::splat(value_bit(&k.step, i).v != 0),
                _ => Chunk::ZERO,
            };
            let added = if counter { 0 } else { p.pool[(op.pins[1] + i) as usize] };
            let [q, d, sub] = [store.q + i, added, sub].map(|bit| self.planes.plane::<K>(bit));
            let (carries, bad, counts) = (&mut self.carry, &self.bad, &self.counts);
            self.planes.write::<K>(store.next + i, |c| {
                let (old, carry) = (q.get(c), carries[c]);
                let (a, b) = (old.v, (d.get(c).v | step) ^ sub.get(c).v);
                carries[c] = (a & b) | ((a ^ b) & carry);
                let sum = a ^ b ^ carry;
                let sum = if K { Four::known(sum) } else { Four { v: sum & !bad[c], u: bad[c] } };
                sum.within(counts[c]).join(old.within(!counts[c]))
            });
        }
    }

    /// The same for any cell, lane by lane.
    pub fn sample_lanes(&mut self, p: &Program, store: &Store, number: usize) {
        let op = &store.op;
        let kind = &p.cells[op.cell as usize];
        let pins = op.pin_count as usize;
        let mut ins: Vec<Vec<Word>> = vec![Vec::new(); pins];
        let mut next = vec![Word::ZERO; words(op.width)];
        for i in 0..op.width {
            self.planes.copy(store.q + i, store.next + i);
        }
        for lane in 0..self.lanes() {
            if self.triggers[number][lane / LANES].0[lane % LANES / 64] >> (lane % 64) & 1 == 0 {
                continue;
            }
            for (pin, words) in ins.iter_mut().enumerate() {
                self.gather(&p.pool[op.pins[pin] as usize..op.pins[pin + 1] as usize], lane, words);
            }
            let slices: Vec<&[Word]> = ins[..pins - 1].iter().map(Vec::as_slice).collect();
            clocked(kind, &slices, &ins[pins - 1], &mut next);
            for i in 0..op.width {
                self.planes.set_lane(store.next + i, lane, bit_of(&next, i));
            }
        }
    }
}
