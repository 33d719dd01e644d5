//! Samples of every kind of cell, for tests: a kind that is added does not compile here until it has some.

use std::sync::Arc;

use super::memory::{Memory, ReadPort, WritePort};
use super::{Accumulator, AddOp, Alu, CellKind, Clock, CompareOp, Counter, DivideOp, Edge, Flop, GateOp, Rc, ShiftOp};
use crate::Value;
use crate::value::Logic;

/// A list of the kinds without their shapes, and which of them a cell is.
macro_rules! sorts {
    ($($name:ident),* $(,)?) => {
        /// A kind of cell without its shape.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        #[allow(missing_docs)]
        pub enum Sort { $($name),* }

        impl Sort {
            /// All of them.
            pub const ALL: &'static [Sort] = &[$(Sort::$name),*];

            /// That of a kind.
            #[must_use]
            pub fn of(kind: &CellKind) -> Sort {
                match kind { $(CellKind::$name { .. } => Sort::$name),* }
            }
        }
    };
}

sorts! {
    Gate, AndOr, Majority, Mux, HalfAdder, FullAdder, Adder, Multiply, Compare, Shift, Divide, Power, OneHotMux, Demux,
    BitMux, BitSame, Products, CarrySave, Carry, Alu, IsZero, Tristate, Resolve, Constant, Sr, Latch, Flop, EdgeFlop,
    Counter, Accumulator, Memory, Clock, Delay, RcDelay,
}

/// Choices, made by a function that gives a number below another.
struct Choice<'c>(&'c mut dyn FnMut(u64) -> u64);

impl Choice<'_> {
    fn below(&mut self, n: u32) -> u32 {
        (self.0)(n.into()) as u32
    }

    fn flag(&mut self) -> bool {
        self.below(2) == 1
    }

    fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    /// A value of which one bit in so many is x or z; none of them for 0.
    fn value(&mut self, width: u32, unknown: u32) -> Value {
        let mut value = Value::from_u64(0, width);
        for i in 0..width {
            let bit = match unknown {
                0 => [Logic::Zero, Logic::One][self.below(2) as usize],
                n if self.below(n) == 0 => [Logic::X, Logic::Z][self.below(2) as usize],
                _ => [Logic::Zero, Logic::One][self.below(2) as usize],
            };
            value.set_bit(i, bit);
        }
        value
    }

    fn state(&mut self, width: u32) -> Value {
        if self.flag() { Value::unknown(width) } else { self.value(width, 0) }
    }

    fn edge(&mut self) -> Edge {
        self.one_of(&[Edge::Rising, Edge::Falling])
    }

    fn flop(&mut self, width: u32) -> Box<Flop> {
        let unknown = self.one_of(&[0, 0, 4]);
        Box::new(Flop {
            edge: self.edge(),
            set_value: self.value(width, unknown),
            reset_value: self.value(width, unknown),
            init: self.state(width),
        })
    }
}

/// A cell of a kind, made for words of `width` bits; `below` gives a number below another, from 1 up.
#[must_use]
pub fn sample(sort: Sort, width: u32, below: &mut dyn FnMut(u64) -> u64) -> CellKind {
    use CompareOp::{Differs, Eq, Ge, Gt, Le, Lt, Ne, Same};
    use DivideOp::{Floor, Modulo, Quotient, Remainder};
    use ShiftOp::{Both, Left, Part, PartSigned, Right, RightSigned};
    let c = &mut Choice(below);
    let signed = c.flag();
    match sort {
        Sort::Gate => {
            use GateOp::{And, Buf, Nand, Nor, Not, Or, Xnor, Xor};
            match c.one_of(&[And, Or, Xor, Nand, Nor, Xnor, Buf, Not]) {
                op @ (Buf | Not) => CellKind::Gate { op, width, inputs: 1 },
                op => CellKind::Gate { op, width, inputs: 2 + c.below(if width == 1 { 70 } else { 4 }) },
            }
        }
        Sort::AndOr => CellKind::AndOr { width, inputs: 1 + c.below(5) },
        Sort::Majority => CellKind::Majority { width },
        Sort::Mux => CellKind::Mux { width, inputs: 2 + c.below(8) },
        Sort::HalfAdder => CellKind::HalfAdder,
        Sort::FullAdder => CellKind::FullAdder,
        Sort::Adder => CellKind::Adder { op: c.one_of(&[AddOp::Add, AddOp::Sub, AddOp::AddSub]), width },
        Sort::Multiply => CellKind::Multiply { a_width: width, b_width: 1 + c.below(width), signed },
        Sort::Compare => CellKind::Compare { op: c.one_of(&[Eq, Ne, Lt, Le, Gt, Ge, Same, Differs]), width, signed },
        Sort::Shift => CellKind::Shift {
            op: c.one_of(&[Left, Right, RightSigned, Both, Part, PartSigned]),
            a_width: width,
            b_width: c.one_of(&[1, 2, 3, 5, 8, 70]),
            width: 1 + c.below(2 * width),
        },
        Sort::Divide => CellKind::Divide { op: c.one_of(&[Quotient, Remainder, Floor, Modulo]), width, signed },
        Sort::Power => CellKind::Power { width, b_width: 1 + c.below(6), a_signed: signed, b_signed: c.flag() },
        Sort::OneHotMux => CellKind::OneHotMux { width, inputs: c.one_of(&[1, 2, 3, 5, 66]) },
        Sort::Demux => CellKind::Demux { width, select: 1 + c.below(4) },
        Sort::BitMux => CellKind::BitMux { width },
        Sort::BitSame => CellKind::BitSame { width },
        Sort::Products => {
            let words = width.div_ceil(64) * (1 + c.below(3));
            let own = crate::value::word::mask(width.min(64));
            let table = (0..words).map(|_| ((c.0)(u64::MAX) & (c.0)(u64::MAX) & own, (c.0)(u64::MAX) & own & 0x1111));
            let table: Box<[(u64, u64)]> = table.map(|(zero, one)| (zero & !one, one)).collect();
            let last = crate::value::word::mask(width - (width - 1) / 64 * 64);
            let n = width.div_ceil(64) as usize;
            let cut = |(i, (zero, one)): (usize, &(u64, u64))| match (i + 1).is_multiple_of(n) {
                true => (zero & last, one & last),
                false => (*zero, *one),
            };
            CellKind::Products { width, table: table.iter().enumerate().map(cut).collect() }
        }
        Sort::CarrySave => CellKind::CarrySave { width },
        Sort::Carry => CellKind::Carry { width },
        Sort::Alu => {
            CellKind::Alu(Alu { a_width: width, b_width: 1 + c.below(width), width: 1 + c.below(2 * width), signed })
        }
        Sort::IsZero => CellKind::IsZero { width },
        Sort::Tristate => CellKind::Tristate { width },
        Sort::Resolve => CellKind::Resolve { width, inputs: 2 + c.below(3) },
        Sort::Constant => CellKind::Constant(Box::new(c.value(width, 4))),
        Sort::Sr => CellKind::Sr { set_dominates: c.flag(), init: c.state(1) },
        Sort::Latch => CellKind::Latch(c.flop(width)),
        Sort::Flop => CellKind::Flop(c.flop(width)),
        Sort::EdgeFlop => CellKind::EdgeFlop(c.flop(width)),
        Sort::Counter => {
            let step = if c.flag() { Value::from_u64(1, width) } else { c.value(width, 0) };
            CellKind::Counter(Box::new(Counter { edge: c.edge(), step, init: c.state(width) }))
        }
        Sort::Accumulator => CellKind::Accumulator(Box::new(Accumulator { edge: c.edge(), init: c.state(width) })),
        Sort::Memory => {
            let size = 1 + c.below(9);
            let clock = if c.flag() { Some(c.edge()) } else { None };
            let read = ReadPort {
                clock,
                wide: false,
                transparent: [clock.is_some() && c.flag()].into(),
                collides: [false].into(),
                arst_value: c.value(width, 0),
                srst_value: c.value(width, 0),
                enable_first: c.flag(),
            };
            let write = WritePort { clock: Some(c.edge()), wide: false, priority: [].into() };
            CellKind::Memory(Box::new(Memory {
                width,
                size,
                offset: 0,
                abits: 4,
                init: Arc::from(Memory::contents(width, size)),
                start: Value::unknown(width),
                reads: vec![read],
                writes: vec![write],
            }))
        }
        Sort::Clock => {
            let period = 2 + c.below(9);
            CellKind::Clock(Clock {
                period: period.into(),
                high: (1 + c.below(period - 1)).into(),
                phase: c.below(5).into(),
            })
        }
        Sort::Delay => {
            let init = if c.flag() { Some(Box::new(c.value(width, 4))) } else { None };
            CellKind::Delay { width, ticks: (1 + c.below(35)).into(), init }
        }
        Sort::RcDelay => CellKind::RcDelay(Rc { tau: 1.0 + f64::from(c.below(300)) / 10.0, rise: 0.6, fall: 0.4 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_of_its_kind_and_has_the_pins_that_it_says() {
        let mut state = 7;
        for &sort in Sort::ALL {
            for width in [1, 2, 63, 64, 65, 130] {
                let kind = sample(sort, width, &mut |n| crate::random::next(&mut state) % n);
                assert_eq!(Sort::of(&kind), sort);
                for pin in 0..kind.inputs().len() {
                    assert!(kind.input_width(pin) > 0, "{kind:?} pin {pin}");
                }
                for pin in 0..kind.outputs().len() {
                    assert!(kind.output_width(pin) > 0, "{kind:?} output {pin}");
                }
            }
        }
    }
}
