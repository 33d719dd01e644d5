//! What a cell of each kind does with its pins: the families' functions, called for the whole cell.

use super::{AddOp, CellKind, Flop};
use super::{arith, carry, choose, counter, divide, gate, select, shift, storage};
use crate::value::Word;
use crate::value::word::{extract, words};

/// Word `i` of the `width` bits of `from` that begin at bit `lo`.
#[inline(always)]
pub(super) fn word_of(from: &[Word], lo: u32, width: u32, i: usize) -> Word {
    let mut w = [Word::ZERO];
    let start = lo + i as u32 * 64;
    extract(&mut w, from, start, (width - i as u32 * 64).min(64));
    w[0]
}

/// What a cell does without a clock edge. `ins` and `outs` are its pins in order, all present, each of its full width;
/// `outs` hold the present values on entry, of which only storage cells make use.
///
/// Clocks and delays act by time, and memories have words that are no pins; they are not evaluated: their outputs stay.
pub fn evaluate(kind: &CellKind, ins: &[&[Word]], outs: &mut [&mut [Word]]) {
    match kind {
        CellKind::Gate { op, width, inputs } => gate::gate(*op, *width, *inputs, ins[0], outs[0]),
        CellKind::AndOr { width, inputs } => gate::and_or(*width, *inputs, ins[0], ins[1], outs[0]),
        CellKind::Mux { width, inputs } => select::mux(*width, *inputs, ins[0], ins[1][0], outs[0]),
        CellKind::HalfAdder => (outs[0][0], outs[1][0]) = arith::half_adder(ins[0][0], ins[1][0]),
        CellKind::FullAdder => (outs[0][0], outs[1][0]) = arith::full_adder(ins[0][0], ins[1][0], ins[2][0]),
        CellKind::Adder { op, width } => {
            let sub = match op {
                AddOp::Add => Word::ZERO,
                AddOp::Sub => Word::known(1),
                AddOp::AddSub => ins[3][0],
            };
            outs[1][0] = arith::add(*width, ins[0], ins[1], ins[2][0], sub, outs[0]);
        }
        CellKind::Multiply { a_width, b_width, signed } => {
            arith::multiply(*a_width, *b_width, *signed, ins[0], ins[1], outs[0])
        }
        CellKind::Compare { op, width, signed } => outs[0][0] = select::compare(*op, *width, *signed, ins[0], ins[1]),
        CellKind::Shift { op, a_width, b_width, width } => {
            shift::shift(*op, *a_width, *b_width, *width, ins[0], ins[1], outs[0]);
        }
        CellKind::Divide { op, width, signed } => divide::divide(*op, *width, *signed, ins[0], ins[1], outs[0]),
        CellKind::Power { width, b_width, a_signed, b_signed } => {
            divide::power(*width, *b_width, (*a_signed, *b_signed), ins[0], ins[1], outs[0]);
        }
        CellKind::OneHotMux { width, .. } => choose::one_hot(*width, ins[0], ins[1], ins[2], outs[0]),
        CellKind::Demux { width, select } => choose::demux(*width, *select, ins[0], ins[1][0], outs[0]),
        CellKind::BitMux { width } => choose::bit_mux(*width, ins[0], ins[1], ins[2], outs[0]),
        CellKind::BitSame { width } => choose::bit_same(*width, ins[0], ins[1], outs[0]),
        CellKind::Products { width, table } => outs[0][0] = choose::products(*width, table, ins[0]),
        CellKind::CarrySave { width } => {
            let [x, y] = outs else { unreachable!("two outputs") };
            carry::carry_save(*width, ins[0], ins[1], ins[2], x, y);
        }
        CellKind::Carry { width } => carry::chain(*width, ins[0], ins[1], ins[2][0], outs[0]),
        CellKind::Alu(alu) => {
            let [x, y, co] = outs else { unreachable!("three outputs") };
            alu.add(ins, [x, y, co]);
        }
        CellKind::IsZero { width } => outs[0][0] = gate::is_zero(*width, ins[0]),
        CellKind::Tristate { width } => select::tristate(*width, ins[0], ins[1][0], outs[0]),
        CellKind::Resolve { width, inputs } => select::resolve(*width, *inputs, ins[0], outs[0]),
        CellKind::Sr { set_dominates, .. } => {
            outs[0][0] = storage::sr(outs[0][0], ins[0][0], ins[1][0], *set_dominates);
            invert(1, outs);
        }
        CellKind::Latch(f) => {
            level(f, ins[1], ins[2][0], ins[3][0], ins[0][0], outs[0]);
            invert(f.init.width(), outs);
        }
        CellKind::Flop(f) => {
            level(f, ins[1], ins[3][0], ins[4][0], ins[2][0], outs[0]);
            invert(f.init.width(), outs);
        }
        CellKind::Counter(c) => {
            counter::level(outs[0], ins[1], ins[2][0], ins[3][0]);
            outs[1][0] = gate::is_zero(c.init.width(), outs[0]);
        }
        CellKind::Accumulator(a) => {
            counter::level(outs[0], ins[1], Word::ZERO, ins[3][0]);
            outs[1][0] = counter::carry(a.init.width(), outs[0], ins[1], ins[2][0]);
        }
        CellKind::Constant(value) => {
            for (y, w) in outs[0].iter_mut().zip(value.words()) {
                *y = w;
            }
        }
        CellKind::EdgeFlop(_)
        | CellKind::Memory(_)
        | CellKind::Clock(_)
        | CellKind::Delay { .. }
        | CellKind::RcDelay(_) => {}
    }
}

fn level(f: &Flop, d: &[Word], set: Word, reset: Word, load: Word, q: &mut [Word]) {
    for (i, (set_value, reset_value)) in f.set_value.words().zip(f.reset_value.words()).enumerate() {
        q[i] = storage::level(q[i], d[i], set, reset, load, set_value, reset_value);
    }
}

fn invert(width: u32, outs: &mut [&mut [Word]]) {
    let [q, qn] = outs else { return };
    for i in 0..words(width) {
        qn[i] = q[i].not(crate::value::word::word_mask(width, i));
    }
}

/// The state that a clocked cell takes at its active edge, from its pins and its present state `q`, into `next`.
/// Cells without a clock keep their state.
pub fn clocked(kind: &CellKind, ins: &[&[Word]], q: &[Word], next: &mut [Word]) {
    match kind {
        CellKind::Flop(f) => {
            let [_, d, aload, set, reset, en, sync_set, sync_reset] = ins else {
                unreachable!("a flip-flop has eight pins")
            };
            let c = storage::Controls {
                aload: aload[0],
                set: set[0],
                reset: reset[0],
                en: en[0],
                sync_set: sync_set[0],
                sync_reset: sync_reset[0],
            };
            for (i, (set_value, reset_value)) in f.set_value.words().zip(f.reset_value.words()).enumerate() {
                next[i] = storage::clocked(q[i], d[i], &c, set_value, reset_value);
            }
        }
        CellKind::EdgeFlop(f) => {
            let [_, d, ad, aload, set, reset, en] = ins else { unreachable!("it has seven pins") };
            for (i, (set_value, reset_value)) in f.set_value.words().zip(f.reset_value.words()).enumerate() {
                next[i] = match () {
                    () if reset[0].is_one() => reset_value,
                    () if set[0].is_one() => set_value,
                    () if aload[0].is_one() => ad[i],
                    () if en[0].is_one() => d[i],
                    () => q[i],
                };
            }
        }
        CellKind::Counter(k) => {
            let [_, d, aload, reset, en, down, load] = ins else { unreachable!("a counter has seven pins") };
            let c = counter::Controls { en: en[0], down: down[0], load: load[0], aload: aload[0], reset: reset[0] };
            let width = k.init.width();
            let mut step = [Word::ZERO; 1];
            if words(width) == 1 {
                step[0] = k.step.words().next().unwrap_or_default();
                counter::count(width, q, d, &step, &c, next);
            } else {
                let step: Vec<Word> = k.step.words().collect();
                counter::count(width, q, d, &step, &c, next);
            }
        }
        CellKind::Accumulator(a) => {
            let [_, d, ci, reset, en] = ins else { unreachable!("an accumulator has five pins") };
            counter::accumulate(a.init.width(), q, d, ci[0], en[0], reset[0], next);
        }
        _ => next.copy_from_slice(q),
    }
}
