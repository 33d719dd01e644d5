//! What each element does: its meaning, its pins and its documentation, one file a family.
//!
//! The functions here are the only definition of a cell's behaviour; engines call them (or are tested against them),
//! circuit files name the [elements](element::Element). This room does not know who calls it: no netlist, no time
//! queue, no files.

/// The pattern of all kinds that keep no state.
macro_rules! stateless {
    () => {
        CellKind::Gate { .. }
            | CellKind::AndOr { .. }
            | CellKind::Majority { .. }
            | CellKind::Mux { .. }
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
            | CellKind::Products { .. }
            | CellKind::CarrySave { .. }
            | CellKind::Carry { .. }
            | CellKind::Alu(_)
            | CellKind::IsZero { .. }
            | CellKind::Tristate { .. }
            | CellKind::Resolve { .. }
            | CellKind::Constant(_)
            | CellKind::Clock(_)
            | CellKind::Delay { .. }
            | CellKind::RcDelay(_)
    };
}

#[doc(hidden)]
pub mod agree;
pub mod algebra;
pub mod arith;
pub mod carry;
pub mod choose;
pub mod counter;
pub mod divide;
pub mod element;
pub mod equipment;
mod evaluate;
pub mod gate;
pub mod memory;
pub mod pin;
#[doc(hidden)]
pub mod samples;
pub mod select;
pub mod shift;
pub mod storage;
pub mod time;
mod words;

use crate::Value;

pub use algebra::{Algebra, Site};
pub use arith::AddOp;
pub use carry::Alu;
pub use counter::{Accumulator, Counter};
pub use divide::DivideOp;
pub use element::{Argument, Arguments, Element, element, elements};
pub use equipment::{Equipment, Flow, Parts};
pub use evaluate::{act, at_edge, clocked, derived, evaluate, evaluate_held, level};
pub use gate::GateOp;
pub use memory::Memory;
pub use pin::{Pin, Role};
pub use select::CompareOp;
pub use shift::ShiftOp;
pub use storage::{Edge, Flop};
pub use time::{Clock, Rc};
pub use words::Words;

/// A primitive cell: what it does and how wide it is.
///
/// Pins are numbered; [`inputs`](CellKind::inputs) and [`outputs`](CellKind::outputs) name them in order. Where a pin
/// takes several inputs they are one vector, the first input in the low bits.
#[derive(Clone, PartialEq, Debug)]
pub enum CellKind {
    /// A gate of any width and fan-in.
    Gate {
        /// What it does.
        op: GateOp,
        /// Bits of each input and of the output.
        width: u32,
        /// Fan-in.
        inputs: u32,
    },
    /// AND-OR multiplexer.
    AndOr {
        /// Bits of each input.
        width: u32,
        /// Number of inputs.
        inputs: u32,
    },
    /// Majority gate of three inputs.
    Majority {
        /// Bits of each input.
        width: u32,
    },
    /// Multiplexer with a binary select.
    Mux {
        /// Bits of each input.
        width: u32,
        /// Number of inputs.
        inputs: u32,
    },
    /// Half adder.
    HalfAdder,
    /// Full adder.
    FullAdder,
    /// Adder, subtractor or both.
    Adder {
        /// Which way it counts.
        op: AddOp,
        /// Bits of the operands and of the result.
        width: u32,
    },
    /// Multiplier.
    Multiply {
        /// Bits of `a`.
        a_width: u32,
        /// Bits of `b`.
        b_width: u32,
        /// Two's complement.
        signed: bool,
    },
    /// Comparator.
    Compare {
        /// Which comparison.
        op: CompareOp,
        /// Bits of the operands.
        width: u32,
        /// Two's complement.
        signed: bool,
    },
    /// Shifter by a variable amount, or selector of a part.
    Shift {
        /// What it does.
        op: ShiftOp,
        /// Bits of `a`.
        a_width: u32,
        /// Bits of `b`, the amount.
        b_width: u32,
        /// Bits of the result.
        width: u32,
    },
    /// Divider.
    Divide {
        /// What it gives.
        op: DivideOp,
        /// Bits of the operands and of the result.
        width: u32,
        /// Two's complement.
        signed: bool,
    },
    /// Power.
    Power {
        /// Bits of the base and of the result.
        width: u32,
        /// Bits of the exponent.
        b_width: u32,
        /// The base is in two's complement.
        a_signed: bool,
        /// The exponent is in two's complement.
        b_signed: bool,
    },
    /// Multiplexer with a select line for each input and one that holds while none is active.
    OneHotMux {
        /// Bits of each input.
        width: u32,
        /// Number of select lines.
        inputs: u32,
    },
    /// Demultiplexer.
    Demux {
        /// Bits of the input and of each output.
        width: u32,
        /// Bits of the select; there are 2^select outputs.
        select: u32,
    },
    /// Multiplexer with a select for each bit.
    BitMux {
        /// Bits.
        width: u32,
    },
    /// Whether bits are the same of 0, 1, x and z, bit by bit.
    BitSame {
        /// Bits.
        width: u32,
    },
    /// Sum of products.
    Products {
        /// Bits of the input.
        width: u32,
        /// For each product, for each 64 inputs, those that it wants to be 0 and those that it wants to be 1.
        table: Box<[(u64, u64)]>,
    },
    /// Full adders side by side.
    CarrySave {
        /// Bits.
        width: u32,
    },
    /// Carry chain.
    Carry {
        /// Bits.
        width: u32,
    },
    /// Adder and subtractor with all its carries.
    Alu(Alu),
    /// Zero detector.
    IsZero {
        /// Bits of the operand.
        width: u32,
    },
    /// Tri-state buffer.
    Tristate {
        /// Bits.
        width: u32,
    },
    /// The resolution of several tri-state drivers of one bus; the netlist builder adds it.
    Resolve {
        /// Bits of the bus.
        width: u32,
        /// Number of drivers.
        inputs: u32,
    },
    /// A constant.
    Constant(Box<Value>),
    /// SR flip-flop.
    Sr {
        /// Set wins over reset.
        set_dominates: bool,
        /// The state before anything has set it.
        init: Value,
    },
    /// Transparent latch.
    Latch(Box<Flop>),
    /// D flip-flop or register.
    Flop(Box<Flop>),
    /// D flip-flop whose asynchronous controls act when they become active, as an `always` block does that waits for
    /// their edges: what is loaded does not follow `ad` afterwards, and a set does not act when a reset ends.
    EdgeFlop(Box<Flop>),
    /// Counter.
    Counter(Box<Counter>),
    /// Accumulator.
    Accumulator(Box<Accumulator>),
    /// Memory. Its words are no pins: whoever runs it keeps them.
    Memory(Box<Memory>),
    /// Free-running clock.
    Clock(Clock),
    /// Transport delay.
    Delay {
        /// Bits.
        width: u32,
        /// Ticks.
        ticks: u64,
        /// What comes out before anything has got through; x if nothing is said.
        init: Option<Box<Value>>,
    },
    /// RC node with a threshold.
    RcDelay(Rc),
}

/// The kinds that keep a state and are no memory.
#[derive(Clone, Copy, Debug)]
pub enum Storage<'k> {
    /// SR flip-flop.
    Sr {
        /// Set wins over reset.
        set_dominates: bool,
        /// The state before anything has set it.
        init: &'k Value,
    },
    /// Transparent latch.
    Latch(&'k Flop),
    /// D flip-flop or register.
    Flop(&'k Flop),
    /// D flip-flop whose asynchronous controls act at their edges.
    EdgeFlop(&'k Flop),
    /// Counter.
    Counter(&'k Counter),
    /// Accumulator.
    Accumulator(&'k Accumulator),
}

/// What the pins of a kind are, in order.
struct Shape {
    inputs: &'static [Pin],
    outputs: &'static [&'static str],
}

impl CellKind {
    fn shape(&self) -> Shape {
        let (inputs, outputs): (_, &[&str]) = match self {
            CellKind::Gate { op: GateOp::Buf | GateOp::Not, .. } | CellKind::IsZero { .. } => {
                (pin::unary::PINS, &["y"])
            }
            CellKind::Gate { .. } | CellKind::Resolve { .. } => (pin::several::PINS, &["y"]),
            CellKind::AndOr { .. } => (pin::and_or::PINS, &["y"]),
            CellKind::Majority { .. } => (pin::ternary::PINS, &["y"]),
            CellKind::Mux { .. } => (pin::mux::PINS, &["y"]),
            CellKind::HalfAdder => (pin::binary::PINS, &["s", "co"]),
            CellKind::FullAdder => (pin::full_adder::PINS, &["s", "co"]),
            CellKind::Adder { op: AddOp::Add, .. } => (pin::add::PINS, &["y", "co"]),
            CellKind::Adder { op: AddOp::Sub, .. } => (pin::sub::PINS, &["y", "bo"]),
            CellKind::Adder { op: AddOp::AddSub, .. } => (pin::add_sub::PINS, &["y", "co"]),
            CellKind::Multiply { .. }
            | CellKind::Compare { .. }
            | CellKind::Shift { .. }
            | CellKind::Divide { .. }
            | CellKind::Power { .. }
            | CellKind::BitSame { .. } => (pin::binary::PINS, &["y"]),
            CellKind::OneHotMux { .. } | CellKind::BitMux { .. } => (pin::chosen::PINS, &["y"]),
            CellKind::Demux { .. } => (pin::demux::PINS, &["y"]),
            CellKind::Products { .. } => (pin::unary::PINS, &["y"]),
            CellKind::CarrySave { .. } => (pin::ternary::PINS, &["x", "y"]),
            CellKind::Carry { .. } => (pin::carry::PINS, &["co"]),
            CellKind::Alu(_) => (pin::alu::PINS, &["x", "y", "co"]),
            CellKind::Tristate { .. } => (pin::tristate::PINS, &["y"]),
            CellKind::Constant(_) | CellKind::Clock(_) => (pin::none::PINS, &["y"]),
            CellKind::Sr { .. } => (pin::sr::PINS, &["q", "qn"]),
            CellKind::Latch(_) => (pin::latch::PINS, &["q", "qn"]),
            CellKind::Flop(_) => (pin::flop::PINS, &["q", "qn"]),
            CellKind::EdgeFlop(_) => (pin::edge_flop::PINS, &["q"]),
            CellKind::Counter(_) => (pin::counter::PINS, &["q", "zero"]),
            CellKind::Accumulator(_) => (pin::accumulator::PINS, &["q", "co"]),
            CellKind::Memory(_) => (pin::memory::PINS, &["rd_data"]),
            CellKind::Delay { .. } | CellKind::RcDelay(_) => (pin::delay::PINS, &["y"]),
        };
        Shape { inputs, outputs }
    }

    /// The input pins in order.
    #[must_use]
    pub fn inputs(&self) -> &'static [Pin] {
        self.shape().inputs
    }

    /// The names of the output pins in order. The first is the state of a storage cell.
    #[must_use]
    pub fn outputs(&self) -> &'static [&'static str] {
        self.shape().outputs
    }

    /// The width in bits of each pin: of the inputs in order, and of the outputs.
    fn widths(&self) -> Widths {
        let w = |inputs: &[u32], outputs: &[u32]| Widths::new(inputs, outputs);
        match self {
            CellKind::Gate { width, inputs, .. } | CellKind::Resolve { width, inputs } => {
                w(&[width * inputs], &[*width])
            }
            CellKind::AndOr { width, inputs } => w(&[width * inputs, *inputs], &[*width]),
            CellKind::Majority { width } => w(&[*width; 3], &[*width]),
            CellKind::Mux { width, inputs } => w(&[width * inputs, select::select_width(*inputs)], &[*width]),
            CellKind::HalfAdder => w(&[1; 2], &[1; 2]),
            CellKind::FullAdder => w(&[1; 3], &[1; 2]),
            CellKind::Adder { width, .. } => w(&[*width, *width, 1, 1], &[*width, 1]),
            CellKind::Multiply { a_width, b_width, .. } => w(&[*a_width, *b_width], &[a_width + b_width]),
            CellKind::Compare { width, .. } => w(&[*width; 2], &[1]),
            CellKind::Shift { a_width, b_width, width, .. } => w(&[*a_width, *b_width], &[*width]),
            CellKind::Divide { width, .. } => w(&[*width; 2], &[*width]),
            CellKind::Power { width, b_width, .. } => w(&[*width, *b_width], &[*width]),
            CellKind::OneHotMux { width, inputs } => w(&[*width, width * inputs, *inputs], &[*width]),
            CellKind::Demux { width, select } => w(&[*width, *select], &[width << select]),
            CellKind::BitMux { width } => w(&[*width; 3], &[*width]),
            CellKind::BitSame { width } => w(&[*width; 2], &[*width]),
            CellKind::Products { width, .. } => w(&[*width], &[1]),
            CellKind::CarrySave { width } => w(&[*width; 3], &[*width; 2]),
            CellKind::Carry { width } => w(&[*width, *width, 1], &[*width]),
            CellKind::Alu(alu) => w(&[alu.a_width, alu.b_width, 1, 1], &[alu.width; 3]),
            CellKind::IsZero { width } => w(&[*width], &[1]),
            CellKind::Tristate { width } => w(&[*width, 1], &[*width]),
            CellKind::Constant(value) => w(&[], &[value.width()]),
            CellKind::Sr { init, .. } => w(&[1; 2], &[init.width(); 2]),
            CellKind::Latch(f) => w(&[1, f.init.width(), 1, 1], &[f.init.width(); 2]),
            CellKind::Flop(f) => w(&[1, f.init.width(), 1, 1, 1, 1, 1, 1], &[f.init.width(); 2]),
            CellKind::EdgeFlop(f) => w(&[1, f.init.width(), f.init.width(), 1, 1, 1, 1], &[f.init.width()]),
            CellKind::Counter(c) => w(&[1, c.init.width(), 1, 1, 1, 1, 1], &[c.init.width(), 1]),
            CellKind::Accumulator(a) => w(&[1, a.init.width(), 1, 1, 1], &[a.init.width(), 1]),
            CellKind::Memory(m) => {
                let (reads, writes) = (m.reads.len() as u32, m.writes.len() as u32);
                let data = writes * m.width;
                w(
                    &[reads, reads, reads, reads, reads * m.abits, writes, data, writes * m.abits, data],
                    &[m.start.width()],
                )
            }
            CellKind::Clock(_) => w(&[], &[1]),
            CellKind::Delay { width, .. } => w(&[*width], &[*width]),
            CellKind::RcDelay(_) => w(&[1], &[1]),
        }
    }

    /// Whether input pin `index` must be connected: one of no bits need not be, nor a clock that no port has.
    #[must_use]
    pub fn requires(&self, index: usize) -> bool {
        let clocks = match self {
            CellKind::Memory(m) => match index {
                pin::memory::RD_CLK => m.reads.iter().any(|port| port.clock.is_some()),
                pin::memory::WR_CLK => m.writes.iter().any(|port| port.clock.is_some()),
                _ => true,
            },
            _ => true,
        };
        self.inputs()[index].required && self.input_width(index) > 0 && clocks
    }

    /// How many vectors one above another input pin `index` takes: more than one where it stands for several inputs.
    #[must_use]
    #[expect(unreachable_patterns, reason = "those that take several inputs are stateless too")]
    pub fn inputs_of(&self, index: usize) -> u32 {
        match (self, index) {
            (CellKind::Gate { inputs, .. } | CellKind::Resolve { inputs, .. } | CellKind::AndOr { inputs, .. }, _) => {
                *inputs
            }
            (CellKind::Mux { inputs, .. }, pin::mux::IN)
            | (CellKind::OneHotMux { inputs, .. }, pin::chosen::B | pin::chosen::S) => *inputs,
            (CellKind::Memory(m), pin::memory::RD_CLK..=pin::memory::RD_ADDR) => m.reads.len() as u32,
            (CellKind::Memory(m), _) => m.writes.len() as u32,
            (
                CellKind::Sr { .. }
                | CellKind::Latch(_)
                | CellKind::Flop(_)
                | CellKind::EdgeFlop(_)
                | CellKind::Counter(_)
                | CellKind::Accumulator(_)
                | stateless!(),
                _,
            ) => 1,
        }
    }

    /// How many vectors one above another output pin `index` gives.
    #[must_use]
    pub fn outputs_of(&self, index: usize) -> u32 {
        match self {
            CellKind::Demux { select, .. } if index == 0 => 1 << select,
            CellKind::Memory(m) => m.reads.len() as u32,
            CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Accumulator(_)
            | stateless!() => 1,
        }
    }

    /// Whether what constants decide of the outputs stays so whatever the other inputs become. Tri-state drivers make z,
    /// which the bus resolves; some see whether an x is one.
    #[must_use]
    pub fn is_pure(&self) -> bool {
        match self {
            CellKind::Tristate { .. }
            | CellKind::Resolve { .. }
            | CellKind::BitSame { .. }
            | CellKind::Products { .. }
            | CellKind::Compare { op: CompareOp::Same | CompareOp::Differs, .. }
            | CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Accumulator(_)
            | CellKind::Memory(_)
            | CellKind::Clock(_)
            | CellKind::Delay { .. }
            | CellKind::RcDelay(_) => false,
            CellKind::Gate { .. }
            | CellKind::AndOr { .. }
            | CellKind::Majority { .. }
            | CellKind::Mux { .. }
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
            | CellKind::CarrySave { .. }
            | CellKind::Carry { .. }
            | CellKind::Alu(_)
            | CellKind::IsZero { .. }
            | CellKind::Constant(_) => true,
        }
    }

    /// The width in bits of input pin `index`.
    #[must_use]
    pub fn input_width(&self, index: usize) -> u32 {
        self.widths().inputs[index]
    }

    /// The width in bits of output pin `index`.
    #[must_use]
    pub fn output_width(&self, index: usize) -> u32 {
        self.widths().outputs[index]
    }

    /// Whether a change of input pin `index` can change an output at once, where `connected` tells which pins are.
    #[must_use]
    pub fn acts_at_once(&self, index: usize, connected: impl Fn(usize) -> bool) -> bool {
        let own = matches!(self.inputs()[index].role, Role::Data | Role::Level);
        match (self, index) {
            // `d` of a flip-flop or counter passes at once only through an asynchronous load
            (CellKind::Flop(_), pin::flop::D) => connected(pin::flop::ALOAD),
            (CellKind::Counter(_), pin::counter::D) => connected(pin::counter::ALOAD),
            (CellKind::Memory(m), pin::memory::RD_ADDR) => m.reads.iter().any(|r| r.clock.is_none()),
            (CellKind::Memory(m), pin::memory::WR_EN | pin::memory::WR_ADDR | pin::memory::WR_DATA) => {
                m.writes.iter().any(|w| w.clock.is_none())
            }
            // all others as their pins say
            (_, _) => own,
        }
    }

    /// Whether it gives known bits where all that it reads, its state among it, is known; `acts` tells whether a pin may
    /// ever be other than 0.
    #[must_use]
    pub fn keeps_known(&self, acts: impl Fn(usize) -> bool) -> bool {
        let known = |value: &Value, pins: &[usize]| value.is_known() || !pins.iter().any(|&pin| acts(pin));
        match self {
            CellKind::Gate { .. }
            | CellKind::AndOr { .. }
            | CellKind::Majority { .. }
            | CellKind::HalfAdder
            | CellKind::FullAdder
            | CellKind::Adder { .. }
            | CellKind::Multiply { .. }
            | CellKind::Compare { .. }
            | CellKind::Demux { .. }
            | CellKind::BitMux { .. }
            | CellKind::BitSame { .. }
            | CellKind::Products { .. }
            | CellKind::CarrySave { .. }
            | CellKind::Carry { .. }
            | CellKind::Alu(_)
            | CellKind::IsZero { .. }
            | CellKind::Sr { .. }
            | CellKind::Accumulator(_)
            | CellKind::Clock(_) => true,
            // of one input 0 alone is a number of it
            CellKind::Mux { inputs, .. } => *inputs > 1 && inputs.is_power_of_two(),
            CellKind::Shift { op, .. } => !matches!(op, ShiftOp::Part | ShiftOp::PartSigned),
            CellKind::Constant(value) => value.is_known(),
            CellKind::Flop(f) => {
                known(&f.set_value, &[pin::flop::SET, pin::flop::SYNC_SET])
                    && known(&f.reset_value, &[pin::flop::RESET, pin::flop::SYNC_RESET])
            }
            CellKind::EdgeFlop(f) => {
                known(&f.set_value, &[pin::edge_flop::SET]) && known(&f.reset_value, &[pin::edge_flop::RESET])
            }
            CellKind::Latch(f) => {
                known(&f.set_value, &[pin::latch::SET]) && known(&f.reset_value, &[pin::latch::RESET])
            }
            CellKind::Counter(c) => c.step.is_known(),
            // a divisor of 0, a power of 0, several lines, what nothing drives, a word that is not there, the past
            CellKind::Divide { .. }
            | CellKind::Power { .. }
            | CellKind::OneHotMux { .. }
            | CellKind::Tristate { .. }
            | CellKind::Resolve { .. }
            | CellKind::Memory(_)
            | CellKind::Delay { .. }
            | CellKind::RcDelay(_) => false,
        }
    }

    /// What keeps a state that is no memory; none for all others.
    #[must_use]
    pub fn storage(&self) -> Option<Storage<'_>> {
        match self {
            CellKind::Sr { set_dominates, init } => Some(Storage::Sr { set_dominates: *set_dominates, init }),
            CellKind::Latch(f) => Some(Storage::Latch(f)),
            CellKind::Flop(f) => Some(Storage::Flop(f)),
            CellKind::EdgeFlop(f) => Some(Storage::EdgeFlop(f)),
            CellKind::Counter(c) => Some(Storage::Counter(c)),
            CellKind::Accumulator(a) => Some(Storage::Accumulator(a)),
            CellKind::Memory(_) | stateless!() => None,
        }
    }

    /// The pin that a level of a storage cell lets through at once, and the control that does so.
    #[must_use]
    pub fn loads(&self) -> Option<(usize, usize)> {
        match self {
            CellKind::Latch(_) => Some((pin::latch::D, pin::latch::EN)),
            CellKind::Flop(_) => Some((pin::flop::D, pin::flop::ALOAD)),
            CellKind::Counter(_) => Some((pin::counter::D, pin::counter::ALOAD)),
            CellKind::Sr { .. }
            | CellKind::EdgeFlop(_)
            | CellKind::Accumulator(_)
            | CellKind::Memory(_)
            | stateless!() => None,
        }
    }

    /// The pins that the output made of a state reads besides it.
    #[must_use]
    pub fn derived_pins(&self) -> &'static [usize] {
        match self {
            CellKind::Accumulator(_) => &[pin::accumulator::D, pin::accumulator::CI],
            CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::EdgeFlop(_)
            | CellKind::Counter(_)
            | CellKind::Memory(_)
            | stateless!() => &[],
        }
    }

    /// The clock edge, for a cell that has one clock.
    #[must_use]
    pub fn edge(&self) -> Option<Edge> {
        match self {
            CellKind::Flop(f) | CellKind::EdgeFlop(f) => Some(f.edge),
            CellKind::Counter(c) => Some(c.edge),
            CellKind::Accumulator(a) => Some(a.edge),
            CellKind::Sr { .. } | CellKind::Latch(_) | CellKind::Memory(_) | stateless!() => None,
        }
    }

    /// The edge at which bit `bit` of input pin `pin` clocks the cell; none if it is no clock.
    #[must_use]
    pub fn edge_at(&self, pin: usize, bit: u32) -> Option<Edge> {
        if self.inputs()[pin].role != Role::Clock {
            return None;
        }
        let CellKind::Memory(m) = self else { return self.edge() };
        match pin {
            pin::memory::RD_CLK => m.reads.get(bit as usize).and_then(|port| port.clock),
            _ => m.writes.get(bit as usize).and_then(|port| port.clock),
        }
    }

    /// The state before anything has set it, for a cell that holds one.
    #[must_use]
    pub fn init(&self) -> Option<&Value> {
        match self {
            CellKind::Sr { init, .. } => Some(init),
            CellKind::Latch(f) | CellKind::Flop(f) | CellKind::EdgeFlop(f) => Some(&f.init),
            CellKind::Counter(c) => Some(&c.init),
            CellKind::Accumulator(a) => Some(&a.init),
            CellKind::Memory(m) => Some(&m.start),
            stateless!() => None,
        }
    }
}

/// The widths of the pins of a cell.
struct Widths {
    inputs: [u32; 9],
    outputs: [u32; 3],
}

impl Widths {
    fn new(inputs: &[u32], outputs: &[u32]) -> Widths {
        let mut all = Widths { inputs: [0; 9], outputs: [0; 3] };
        all.inputs[..inputs.len()].copy_from_slice(inputs);
        all.outputs[..outputs.len()].copy_from_slice(outputs);
        all
    }
}
