//! What a cell of each kind does with its pins: the one place that knows for every kind, in every [`Algebra`].
//!
//! The functions of a kind are inlined into whoever runs it, for lanes are compiled anew for each vector extension. A build
//! with debug assertions leaves that to the compiler: without optimisation the variables of all kinds would lie side by side
//! on the stack.

use super::algebra::{Algebra, Site};
use super::pin::unary;
use super::words::{Clocked, Pins, Words};
use super::{CellKind, Flop, arith, carry, choose, counter, divide, gate, select, shift, storage};
use crate::value::Word;

/// What a cell does without a clock edge: its outputs, or what its state becomes by its levels and the output made of
/// that.
///
/// Clocks and delays act by time, and memories have words that are no pins: they do nothing here.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn act<A: Algebra>(l: &mut A, kind: &CellKind, s: &mut impl Site<A>) {
    match *kind {
        CellKind::Gate { op, width, inputs } => gate::gate(l, s, op, width, inputs),
        CellKind::AndOr { width, inputs } => gate::and_or(l, s, width, inputs),
        CellKind::Majority { width } => gate::majority(l, s, width),
        CellKind::Mux { width, inputs } => select::mux(l, s, width, inputs),
        CellKind::HalfAdder => arith::half_adder(l, s),
        CellKind::FullAdder => arith::full_adder(l, s),
        CellKind::Adder { op, width } => arith::adder(l, s, op, width),
        CellKind::Multiply { a_width, b_width, signed } => arith::multiply(l, s, (a_width, b_width), signed),
        CellKind::Compare { op, width, signed } => select::compare(l, s, op, width, signed),
        CellKind::Shift { op, a_width, b_width, width } => shift::shift(l, s, op, (a_width, b_width, width)),
        CellKind::Divide { op, width, signed } => divide::divide(l, s, op, width, signed),
        CellKind::Power { width, b_width, a_signed, b_signed } => {
            divide::power(l, s, (width, b_width), (a_signed, b_signed));
        }
        CellKind::OneHotMux { width, inputs } => choose::one_hot(l, s, width, inputs),
        CellKind::Demux { width, select } => choose::demux(l, s, width, select),
        CellKind::BitMux { width } => choose::bit_mux(l, s, width),
        CellKind::BitSame { width } => choose::bit_same(l, s, width),
        CellKind::Products { width, ref table } => choose::products(l, s, width, table),
        CellKind::CarrySave { width } => carry::carry_save(l, s, width),
        CellKind::Carry { width } => carry::chain(l, s, width),
        CellKind::Alu(alu) => alu.add(l, s),
        CellKind::IsZero { width } => {
            let y = gate::is_zero(l, width, |_, i| s.get(unary::A, i));
            s.put(0, 0, y);
        }
        CellKind::Tristate { width } => select::tristate(l, s, width),
        CellKind::Resolve { width, inputs } => select::resolve(l, s, width, inputs),
        CellKind::Constant(ref value) => {
            for i in 0..A::words(value.width()) {
                let w = l.word_of(value, i);
                s.put(0, i, w);
            }
        }
        CellKind::Sr { .. }
        | CellKind::Latch(_)
        | CellKind::Flop(_)
        | CellKind::Counter(_)
        | CellKind::Accumulator(_) => {
            level(l, kind, s);
            derived(l, kind, s);
        }
        CellKind::EdgeFlop(_)
        | CellKind::Memory(_)
        | CellKind::Clock(_)
        | CellKind::Delay { .. }
        | CellKind::RcDelay(_) => {}
    }
}

/// The set value and the reset value, word by word.
#[cfg_attr(not(debug_assertions), inline(always))]
fn values<A: Algebra>(f: &Flop) -> impl Fn(&mut A, usize) -> (A::Word, A::Word) {
    |l, i| (l.word_of(&f.set_value, i), l.word_of(&f.reset_value, i))
}

/// What the levels of a storage cell make of its state, as output 0.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn level<A: Algebra>(l: &mut A, kind: &CellKind, s: &mut impl Site<A>) {
    match kind {
        CellKind::Sr { set_dominates, .. } => storage::sr(l, s, *set_dominates),
        CellKind::Latch(f) => storage::level(l, s, storage::OF_LATCH, f.init.width(), values(f)),
        CellKind::Flop(f) => storage::level(l, s, storage::OF_FLOP, f.init.width(), values(f)),
        CellKind::Counter(c) => counter::level(l, s, c.init.width()),
        CellKind::Accumulator(a) => counter::clear(l, s, a.init.width()),
        CellKind::EdgeFlop(_) => s.hold(),
        // its ports have states of their own
        CellKind::Memory(_) | stateless!() => {}
    }
}

/// The output made of a state, as output 1; the state is that after its levels.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn derived<A: Algebra>(l: &mut A, kind: &CellKind, s: &mut impl Site<A>) {
    match kind {
        CellKind::Sr { init, .. } => storage::inverse(l, s, init.width()),
        CellKind::Latch(f) | CellKind::Flop(f) => storage::inverse(l, s, f.init.width()),
        CellKind::Counter(c) => counter::zero(l, s, c.init.width()),
        CellKind::Accumulator(a) => counter::carry(l, s, a.init.width()),
        CellKind::EdgeFlop(_) | CellKind::Memory(_) | stateless!() => {}
    }
}

/// The state that a clocked cell takes at its active edge, as output 0; where `when` is given and not 1 the state stays.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn at_edge<A: Algebra>(l: &mut A, kind: &CellKind, when: Option<A::Plane>, s: &mut impl Site<A>) {
    match kind {
        CellKind::Flop(f) => storage::flop_edge(l, s, f.init.width(), when, values(f)),
        CellKind::EdgeFlop(f) => storage::edge_flop_edge(l, s, f, when),
        CellKind::Counter(c) => counter::count(l, s, c.init.width(), when, |l, i| l.word_of(&c.step, i)),
        CellKind::Accumulator(a) => counter::accumulate(l, s, a.init.width(), when),
        CellKind::Sr { .. } | CellKind::Latch(_) => s.hold(),
        CellKind::Memory(_) | stateless!() => {}
    }
}

/// What a cell does without a clock edge, in machine words. `ins` and `outs` are its pins in order, all present, each of
/// its full width; `outs` hold the present values on entry, of which only storage cells make use.
///
/// Clocks and delays act by time, and memories have words that are no pins; they are not evaluated: their outputs stay.
pub fn evaluate(kind: &CellKind, ins: &[&[Word]], outs: &mut [&mut [Word]]) {
    act(&mut Words, kind, &mut Pins { ins, outs });
}

/// The same of a storage cell whose state is held at something: `hold` says of each word of it what it stays.
pub fn evaluate_held(
    kind: &CellKind,
    ins: &[&[Word]],
    outs: &mut [&mut [Word]],
    mut hold: impl FnMut(usize, Word) -> Word,
) {
    level(&mut Words, kind, &mut Pins { ins, outs });
    outs[0].iter_mut().enumerate().for_each(|(i, word)| *word = hold(i, *word));
    derived(&mut Words, kind, &mut Pins { ins, outs });
}

/// The state that a clocked cell takes at its active edge, from its pins and its present state `q`, into `next`.
/// Cells without a clock keep their state.
pub fn clocked(kind: &CellKind, ins: &[&[Word]], q: &[Word], next: &mut [Word]) {
    at_edge(&mut Words, kind, None, &mut Clocked { ins, q, next });
}
