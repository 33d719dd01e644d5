//! What a cell is made of, and how deep its logic is: the one definition of what counts as a gate, a flip-flop, an adder.
//!
//! | what | counts as |
//! |---|---|
//! | AND, OR, NAND, NOR, XOR, XNOR | one gate a bit, whatever its fan-in; n inputs are n − 1 gates of two inputs |
//! | NOT, BUF | inverters and buffers, one a bit, apart from the gates |
//! | `and_or` of n inputs | n AND gates of two inputs and one OR gate of n, a bit |
//! | `majority` | two AND gates and two OR gates, a bit |
//! | `is_zero` of n bits | one NOR gate of n inputs |
//! | flip-flops, registers, counters, accumulators | one flip-flop a bit |
//! | memories | themselves, with the bits of their words; what their read ports keep is part of them |
//! | adders, comparators, multiplexers, … | themselves, with their bits; they are not broken up into gates |
//! | constants, and what joins the drivers of a bus | nothing |

use std::iter::Sum;
use std::ops::AddAssign;

use serde::Serialize;

use super::{CellKind, GateOp, pin};

/// How many there are of a word-level element, and how many bits they have together.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize)]
pub struct Parts {
    /// How many cells.
    pub number: u64,
    /// How many bits all of them have together; what a bit is depends on the element.
    pub bits: u64,
}

impl Parts {
    fn one(bits: u32) -> Parts {
        Parts { number: 1, bits: bits.into() }
    }
}

impl AddAssign for Parts {
    fn add_assign(&mut self, other: Parts) {
        self.number += other.number;
        self.bits += other.bits;
    }
}

/// What some cells are made of.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize)]
pub struct Equipment {
    /// Gates as they are drawn, of any fan-in, without inverters and buffers.
    pub gates: u64,
    /// The same in gates of two inputs. An inversion at the output (NAND, NOR, XNOR) costs nothing.
    pub two_input_gates: u64,
    /// NOT gates, one a bit; not among `gates`.
    pub inverters: u64,
    /// BUF gates, one a bit; not among `gates`.
    pub buffers: u64,
    /// Bits clocked by an edge: flip-flops, registers, and those within counters and accumulators.
    pub flip_flops: u64,
    /// Bits of transparent latches.
    pub latches: u64,
    /// SR flip-flops (the element; those made of gates are gates here).
    pub sr_flip_flops: u64,
    /// Memories; the bits are those of all words.
    pub memories: Parts,
    /// The elements `half_adder`; those made of gates are gates here.
    pub half_adders: u64,
    /// The elements `full_adder`; those made of gates are gates here.
    pub full_adders: u64,
    /// Adders and subtractors; the bits are those of an operand.
    pub adders: Parts,
    /// Multipliers; the bits are those of the product.
    pub multipliers: Parts,
    /// Comparators; the bits are those of an operand.
    pub comparators: Parts,
    /// Multiplexers with a binary select; the bits are those of the output.
    pub multiplexers: Parts,
    /// Counters. Their bits are among the flip-flops.
    pub counters: Parts,
    /// Accumulators, each with an adder of its own. Their bits are among the flip-flops.
    pub accumulators: Parts,
    /// Shifters; the bits are those of the result.
    pub shifters: Parts,
    /// Dividers and powers; the bits are those of the result.
    pub dividers: Parts,
    /// Tri-state drivers; the bits are those of the output.
    pub tristates: Parts,
    /// Delays and RC nodes; the bits are those of the output.
    pub delays: Parts,
    /// Free-running clocks.
    pub clocks: u64,
}

impl AddAssign for Equipment {
    fn add_assign(&mut self, o: Equipment) {
        self.gates += o.gates;
        self.two_input_gates += o.two_input_gates;
        self.inverters += o.inverters;
        self.buffers += o.buffers;
        self.flip_flops += o.flip_flops;
        self.latches += o.latches;
        self.sr_flip_flops += o.sr_flip_flops;
        self.memories += o.memories;
        self.half_adders += o.half_adders;
        self.full_adders += o.full_adders;
        self.adders += o.adders;
        self.multipliers += o.multipliers;
        self.comparators += o.comparators;
        self.multiplexers += o.multiplexers;
        self.counters += o.counters;
        self.accumulators += o.accumulators;
        self.shifters += o.shifters;
        self.dividers += o.dividers;
        self.tristates += o.tristates;
        self.delays += o.delays;
        self.clocks += o.clocks;
    }
}

impl Sum for Equipment {
    fn sum<I: Iterator<Item = Equipment>>(all: I) -> Equipment {
        all.fold(Equipment::default(), |mut sum, one| {
            sum += one;
            sum
        })
    }
}

/// Which bits of an output can change in the instant in which an input changes. Storage and delays are a boundary: what
/// they do at once (a set, an asynchronous load) is no flow.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Flow {
    /// None.
    None,
    /// Bit i of the output with bit i of each input of the pin.
    Bitwise,
    /// Every bit with every bit.
    Whole,
    /// Every bit of a port with every bit of its own, for the ports of a memory that read without a clock.
    Port,
}

/// What lies before an output.
enum Depth {
    /// No logic: a state, time, a joining of names.
    None,
    /// So many levels of gates.
    Gates(u32),
    /// An element of words, which counts as one level.
    Element,
}

impl CellKind {
    /// What the cell is made of.
    #[must_use]
    pub fn equipment(&self) -> Equipment {
        let none = Equipment::default();
        let bits = u64::from(self.output_width(0));
        match *self {
            CellKind::Shift { width, .. } => Equipment { shifters: Parts::one(width), ..none },
            CellKind::Divide { width, .. } | CellKind::Power { width, .. } => {
                Equipment { dividers: Parts::one(width), ..none }
            }
            CellKind::OneHotMux { .. } | CellKind::Demux { .. } | CellKind::BitMux { .. } => {
                Equipment { multiplexers: Parts::one(self.output_width(0)), ..none }
            }
            CellKind::BitSame { width } => Equipment { comparators: Parts::one(width), ..none },
            // an AND for each product and an OR of them
            CellKind::Products { ref table, width } => {
                let n = crate::value::word::words(width);
                let literals = |p: &[(u64, u64)]| p.iter().map(|t| t.0.count_ones() + t.1.count_ones()).sum::<u32>();
                let products: u64 = table.chunks_exact(n).map(|p| joins(literals(p))).sum();
                let number = table.len() / n;
                Equipment { gates: number as u64 + 1, two_input_gates: products + joins(number as u32), ..none }
            }
            CellKind::CarrySave { width } => Equipment { full_adders: width.into(), ..none },
            CellKind::Carry { .. } | CellKind::Alu(_) => Equipment { adders: Parts::one(self.output_width(0)), ..none },
            CellKind::EdgeFlop(_) => Equipment { flip_flops: bits, ..none },
            CellKind::Gate { op: GateOp::Not, .. } => Equipment { inverters: bits, ..none },
            CellKind::Gate { op: GateOp::Buf, .. } => Equipment { buffers: bits, ..none },
            CellKind::Gate { inputs, .. } => Equipment { gates: bits, two_input_gates: bits * joins(inputs), ..none },
            CellKind::AndOr { inputs, .. } => Equipment {
                gates: bits * (u64::from(inputs) + 1),
                two_input_gates: bits * (u64::from(inputs) + joins(inputs)),
                ..none
            },
            // two ANDs and two ORs, as its meaning has them
            CellKind::Majority { .. } => Equipment { gates: bits * 4, two_input_gates: bits * 4, ..none },
            CellKind::IsZero { width } => Equipment { gates: 1, two_input_gates: joins(width), ..none },
            CellKind::Mux { width, .. } => Equipment { multiplexers: Parts::one(width), ..none },
            CellKind::HalfAdder => Equipment { half_adders: 1, ..none },
            CellKind::FullAdder => Equipment { full_adders: 1, ..none },
            CellKind::Adder { width, .. } => Equipment { adders: Parts::one(width), ..none },
            CellKind::Multiply { .. } => Equipment { multipliers: Parts::one(self.output_width(0)), ..none },
            CellKind::Compare { width, .. } => Equipment { comparators: Parts::one(width), ..none },
            CellKind::Tristate { width } => Equipment { tristates: Parts::one(width), ..none },
            CellKind::Sr { .. } => Equipment { sr_flip_flops: bits, ..none },
            CellKind::Latch(_) => Equipment { latches: bits, ..none },
            CellKind::Flop(_) => Equipment { flip_flops: bits, ..none },
            CellKind::Memory(ref m) => {
                Equipment { memories: Parts { number: 1, bits: u64::from(m.width) * u64::from(m.size) }, ..none }
            }
            CellKind::Counter(_) => Equipment { flip_flops: bits, counters: Parts::one(self.output_width(0)), ..none },
            CellKind::Accumulator(_) => {
                Equipment { flip_flops: bits, accumulators: Parts::one(self.output_width(0)), ..none }
            }
            CellKind::Clock(_) => Equipment { clocks: 1, ..none },
            CellKind::Delay { width, .. } => Equipment { delays: Parts::one(width), ..none },
            CellKind::RcDelay(_) => Equipment { delays: Parts::one(1), ..none },
            CellKind::Constant(_) | CellKind::Resolve { .. } => none,
        }
    }

    /// How many inputs it has, for an element that takes any number of them.
    #[must_use]
    #[expect(unreachable_patterns, reason = "those that take any number are stateless too")]
    pub fn fan_in(&self) -> Option<u32> {
        match *self {
            CellKind::Gate { op: GateOp::Buf | GateOp::Not, .. } => None,
            CellKind::Gate { inputs, .. } | CellKind::AndOr { inputs, .. } | CellKind::Mux { inputs, .. } => {
                Some(inputs)
            }
            // what only other formats make, or what has so many inputs as it always has
            CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Accumulator(_)
            | CellKind::Memory(_)
            | stateless!() => None,
        }
    }

    /// Whether its logic, if it has any, is gates, so that its levels are levels of gates and not of elements.
    #[must_use]
    pub fn is_gates(&self) -> bool {
        (0..self.outputs().len()).all(|pin| matches!(self.logic(pin), Depth::Gates(_) | Depth::None))
    }

    /// Levels of logic before output pin `index`: one a gate, whatever its fan-in; none for a buffer, which joins names;
    /// one for a word-level element as a whole, and for what a counter or accumulator makes of its state.
    #[must_use]
    pub fn levels(&self, index: usize) -> u32 {
        match self.logic(index) {
            Depth::None => 0,
            Depth::Gates(levels) => levels,
            Depth::Element => 1,
        }
    }

    /// The logic before output pin `index`.
    fn logic(&self, index: usize) -> Depth {
        match self {
            CellKind::Gate { op: GateOp::Buf, .. } => Depth::None,
            CellKind::Gate { .. } | CellKind::IsZero { .. } => Depth::Gates(1),
            CellKind::AndOr { .. } | CellKind::Products { .. } => Depth::Gates(2),
            // (a & b) | ((a | b) & c)
            CellKind::Majority { .. } => Depth::Gates(3),
            CellKind::Mux { .. }
            | CellKind::HalfAdder
            | CellKind::FullAdder
            | CellKind::Adder { .. }
            | CellKind::Multiply { .. }
            | CellKind::Compare { .. }
            | CellKind::Shift { .. }
            | CellKind::Divide { .. }
            | CellKind::Power { .. }
            | CellKind::OneHotMux { .. }
            | CellKind::Demux { .. }
            | CellKind::BitMux { .. }
            | CellKind::BitSame { .. }
            | CellKind::CarrySave { .. }
            | CellKind::Carry { .. }
            | CellKind::Alu(_)
            | CellKind::Tristate { .. } => Depth::Element,
            CellKind::Counter(_) | CellKind::Accumulator(_) if index == 1 => Depth::Element,
            CellKind::Memory(m) if m.reads.iter().any(|r| r.clock.is_none()) => Depth::Element,
            CellKind::Counter(_)
            | CellKind::Accumulator(_)
            | CellKind::Memory(_)
            | CellKind::Resolve { .. }
            | CellKind::Constant(_)
            | CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Clock(_)
            | CellKind::Delay { .. }
            | CellKind::RcDelay(_) => Depth::None,
        }
    }

    /// Which bits of output pin `output` can change at once with input pin `input`.
    #[must_use]
    pub fn flow(&self, input: usize, output: usize) -> Flow {
        let bitwise = |is: bool| if is { Flow::Bitwise } else { Flow::Whole };
        match self {
            CellKind::Gate { .. }
            | CellKind::Majority { .. }
            | CellKind::Resolve { .. }
            | CellKind::BitMux { .. }
            | CellKind::BitSame { .. }
            | CellKind::CarrySave { .. } => Flow::Bitwise,
            CellKind::AndOr { .. } => bitwise(input == pin::and_or::IN),
            CellKind::Mux { .. } => bitwise(input == pin::mux::IN),
            CellKind::Tristate { .. } => bitwise(input == pin::tristate::A),
            // of the inputs that are chosen from all bits, for `b` is all of them in one
            CellKind::OneHotMux { .. } => bitwise(input == pin::chosen::A),
            CellKind::HalfAdder
            | CellKind::FullAdder
            | CellKind::Adder { .. }
            | CellKind::Multiply { .. }
            | CellKind::Compare { .. }
            | CellKind::IsZero { .. }
            | CellKind::Shift { .. }
            | CellKind::Divide { .. }
            | CellKind::Power { .. }
            | CellKind::Demux { .. }
            | CellKind::Products { .. }
            | CellKind::Carry { .. }
            | CellKind::Alu(_) => Flow::Whole,
            // of a port of its own, which is all that it can say
            CellKind::Memory(_) if input == pin::memory::RD_ADDR => Flow::Port,
            // the carry of q + d + ci
            CellKind::Accumulator(_) if output == 1 && matches!(input, pin::accumulator::D | pin::accumulator::CI) => {
                Flow::Whole
            }
            CellKind::Memory(_)
            | CellKind::Accumulator(_)
            | CellKind::Constant(_)
            | CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Clock(_)
            | CellKind::Delay { .. }
            | CellKind::RcDelay(_) => Flow::None,
        }
    }

    /// Whether logic ends at its inputs: it keeps a state or acts by time.
    #[must_use]
    pub fn is_boundary(&self) -> bool {
        self.init().is_some() || matches!(self, CellKind::Delay { .. } | CellKind::RcDelay(_))
    }
}

/// The gates of two inputs that join so many.
fn joins(inputs: u32) -> u64 {
    u64::from(inputs.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_gate_is_as_many_as_its_bits() {
        let and = CellKind::Gate { op: GateOp::And, width: 9, inputs: 3 };
        let made = and.equipment();
        assert_eq!((made.gates, made.two_input_gates), (9, 18));
        let not = CellKind::Gate { op: GateOp::Not, width: 9, inputs: 1 };
        assert_eq!(not.equipment(), Equipment { inverters: 9, ..Equipment::default() });
    }

    /// For each of 4 bits: 3 ANDs and an OR of three; the OR is two of two inputs.
    #[test]
    fn an_and_or_multiplexer_is_its_gates() {
        let made = CellKind::AndOr { width: 4, inputs: 3 }.equipment();
        assert_eq!((made.gates, made.two_input_gates), (16, 20));
        assert_eq!(CellKind::AndOr { width: 4, inputs: 3 }.levels(0), 2);
    }
}
