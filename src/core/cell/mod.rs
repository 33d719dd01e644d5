//! What each element does: its meaning, its pins and its documentation, one file a family.
//!
//! The functions here are the only definition of a cell's behaviour; engines call them (or are tested against them),
//! circuit files name the [elements](element::Element). This room does not know who calls it: no netlist, no time
//! queue, no files.

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
pub mod select;
pub mod shift;
pub mod storage;
pub mod time;

use crate::Value;

pub use arith::AddOp;
pub use carry::Alu;
pub use counter::{Accumulator, Counter};
pub use divide::DivideOp;
pub use element::{Argument, Arguments, Element, element, elements};
pub use equipment::{Equipment, Flow, Parts};
use evaluate::word_of;
pub use evaluate::{clocked, evaluate};
pub use gate::GateOp;
pub use memory::Memory;
pub use select::CompareOp;
pub use shift::ShiftOp;
pub use storage::{Edge, Flop};
pub use time::{Clock, Rc};

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

/// What an input pin is to its cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// Its change can change an output at once.
    Data,
    /// Read only at a clock edge.
    Sampled,
    /// The clock.
    Clock,
    /// A control that acts at once: set, reset, asynchronous load, enable of a latch.
    Level,
    /// A control that is read at the clock edge.
    Enable,
    /// A control that acts when it becomes active, as the clock does at its rising edge.
    Trigger,
    /// The input of a delay: its change changes an output later.
    Delayed,
}

/// An input pin.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pin {
    /// The name.
    pub name: &'static str,
    /// What it is to its cell.
    pub role: Role,
    /// What it reads when it is not connected, in every bit.
    pub default: bool,
}

const fn pin(name: &'static str, role: Role) -> Pin {
    Pin { name, role, default: false }
}

const fn high(name: &'static str, role: Role) -> Pin {
    Pin { name, role, default: true }
}

use Role::{Data, Delayed, Enable, Level, Sampled, Trigger};
const CLK: Pin = pin("clk", Role::Clock);
const UNARY: &[Pin] = &[pin("a", Data)];
const BINARY: &[Pin] = &[pin("a", Data), pin("b", Data)];
const SEVERAL: &[Pin] = &[pin("in", Data)];
const AND_OR: &[Pin] = &[pin("in", Data), pin("sel", Data)];
const MUX: &[Pin] = &[pin("in", Data), pin("s", Data)];
const TRISTATE: &[Pin] = &[pin("a", Data), pin("en", Data)];
const SR: &[Pin] = &[pin("s", Level), pin("r", Level)];
const DELAY: &[Pin] = &[pin("a", Delayed)];
const ADD: &[Pin] = &[pin("a", Data), pin("b", Data), pin("ci", Data)];
const SUB: &[Pin] = &[pin("a", Data), pin("b", Data), pin("bi", Data)];
const ADD_SUB: &[Pin] = &[pin("a", Data), pin("b", Data), pin("ci", Data), pin("sub", Data)];
/// The order of a flip-flop's pins is that of `storage::Controls` after clock and data.
const FLOP: &[Pin] = &[
    CLK,
    pin("d", Data),
    pin("aload", Level),
    pin("set", Level),
    pin("reset", Level),
    high("en", Enable),
    pin("sync_set", Enable),
    pin("sync_reset", Enable),
];
const LATCH: &[Pin] = &[pin("en", Level), pin("d", Data), pin("set", Level), pin("reset", Level)];
const ONE_HOT: &[Pin] = &[pin("a", Data), pin("b", Data), pin("s", Data)];
const DEMUX: &[Pin] = &[pin("a", Data), pin("s", Data)];
const CARRY_SAVE: &[Pin] = &[pin("a", Data), pin("b", Data), pin("c", Data)];
const CARRY: &[Pin] = &[pin("p", Data), pin("g", Data), pin("ci", Data)];
const ALU: &[Pin] = &[pin("a", Data), pin("b", Data), pin("ci", Data), pin("bi", Data)];
const EDGE_FLOP: &[Pin] = &[
    CLK,
    pin("d", Sampled),
    pin("ad", Sampled),
    pin("aload", Trigger),
    pin("set", Trigger),
    pin("reset", Trigger),
    high("en", Enable),
];
const COUNTER: &[Pin] = &[
    CLK,
    pin("d", Data),
    pin("aload", Level),
    pin("reset", Level),
    high("en", Enable),
    pin("down", Sampled),
    pin("load", Enable),
];
/// Each pin is that of all ports.
const MEMORY: &[Pin] = &[
    pin("rd_clk", Role::Clock),
    pin("rd_en", Enable),
    pin("rd_arst", Level),
    pin("rd_srst", Enable),
    pin("rd_addr", Data),
    pin("wr_clk", Role::Clock),
    pin("wr_en", Enable),
    pin("wr_addr", Data),
    pin("wr_data", Data),
];
const ACCUMULATOR: &[Pin] = &[CLK, pin("d", Data), pin("ci", Data), pin("reset", Level), high("en", Enable)];

impl CellKind {
    /// The input pins in order.
    #[must_use]
    pub fn inputs(&self) -> &'static [Pin] {
        match self {
            CellKind::Gate { op: GateOp::Buf | GateOp::Not, .. } | CellKind::IsZero { .. } => UNARY,
            CellKind::Gate { .. } | CellKind::Resolve { .. } => SEVERAL,
            CellKind::AndOr { .. } => AND_OR,
            CellKind::Mux { .. } => MUX,
            CellKind::FullAdder | CellKind::Adder { op: AddOp::Add, .. } => ADD,
            CellKind::Adder { op: AddOp::Sub, .. } => SUB,
            CellKind::Adder { op: AddOp::AddSub, .. } => ADD_SUB,
            CellKind::HalfAdder | CellKind::Multiply { .. } | CellKind::Compare { .. } => BINARY,
            CellKind::Shift { .. } | CellKind::Divide { .. } | CellKind::Power { .. } | CellKind::BitSame { .. } => {
                BINARY
            }
            CellKind::OneHotMux { .. } | CellKind::BitMux { .. } => ONE_HOT,
            CellKind::Demux { .. } => DEMUX,
            CellKind::Products { .. } => UNARY,
            CellKind::CarrySave { .. } => CARRY_SAVE,
            CellKind::Carry { .. } => CARRY,
            CellKind::Alu(_) => ALU,
            CellKind::EdgeFlop(_) => EDGE_FLOP,
            CellKind::Tristate { .. } => TRISTATE,
            CellKind::Constant(_) | CellKind::Clock(_) => &[],
            CellKind::Sr { .. } => SR,
            CellKind::Latch(_) => LATCH,
            CellKind::Flop(_) => FLOP,
            CellKind::Counter(_) => COUNTER,
            CellKind::Accumulator(_) => ACCUMULATOR,
            CellKind::Memory(_) => MEMORY,
            CellKind::Delay { .. } | CellKind::RcDelay(_) => DELAY,
        }
    }

    /// The names of the output pins in order. The first is the state of a storage cell.
    #[must_use]
    pub fn outputs(&self) -> &'static [&'static str] {
        match self {
            CellKind::HalfAdder | CellKind::FullAdder => &["s", "co"],
            CellKind::Adder { op: AddOp::Sub, .. } => &["y", "bo"],
            CellKind::Adder { .. } => &["y", "co"],
            CellKind::CarrySave { .. } => &["x", "y"],
            CellKind::Carry { .. } => &["co"],
            CellKind::Alu(_) => &["x", "y", "co"],
            CellKind::EdgeFlop(_) => &["q"],
            CellKind::Memory(_) => &["rd_data"],
            CellKind::Sr { .. } | CellKind::Latch(_) | CellKind::Flop(_) => &["q", "qn"],
            CellKind::Counter(_) => &["q", "zero"],
            CellKind::Accumulator(_) => &["q", "co"],
            _ => &["y"],
        }
    }

    /// Whether a change of input pin `index` can change an output at once, where `connected` tells which pins are.
    #[must_use]
    pub fn acts_at_once(&self, index: usize, connected: impl Fn(usize) -> bool) -> bool {
        match (self, index) {
            // `d` of a flip-flop or counter passes at once only through an asynchronous load
            (CellKind::Flop(_) | CellKind::Counter(_), 1) => connected(2),
            (CellKind::Memory(m), 4) => m.reads.iter().any(|r| r.clock.is_none()),
            (CellKind::Memory(m), 6..) => m.writes.iter().any(|w| w.clock.is_none()),
            _ => matches!(self.inputs()[index].role, Role::Data | Role::Level),
        }
    }

    /// The width in bits of input pin `index`.
    #[must_use]
    pub fn input_width(&self, index: usize) -> u32 {
        match (self, index) {
            (CellKind::Gate { width, inputs, .. } | CellKind::Resolve { width, inputs }, _) => width * inputs,
            (CellKind::AndOr { width, inputs } | CellKind::Mux { width, inputs }, 0) => width * inputs,
            (CellKind::AndOr { inputs, .. }, _) => *inputs,
            (CellKind::Mux { inputs, .. }, _) => select::select_width(*inputs),
            (CellKind::Adder { width, .. }, 0 | 1) => *width,
            (CellKind::Multiply { a_width, .. }, 0) => *a_width,
            (CellKind::Multiply { b_width, .. }, _) => *b_width,
            (CellKind::Compare { width, .. } | CellKind::IsZero { width } | CellKind::Delay { width, .. }, _) => *width,
            (CellKind::Tristate { width }, 0) => *width,
            (CellKind::Shift { a_width, .. }, 0) => *a_width,
            (CellKind::Shift { b_width, .. }, _) | (CellKind::Power { b_width, .. }, 1) => *b_width,
            (CellKind::Divide { width, .. } | CellKind::Power { width, .. }, _) => *width,
            (CellKind::OneHotMux { width, .. } | CellKind::Demux { width, .. }, 0) => *width,
            (CellKind::OneHotMux { width, inputs }, 1) => width * inputs,
            (CellKind::OneHotMux { inputs, .. }, _) => *inputs,
            (CellKind::Demux { select, .. }, _) => *select,
            (CellKind::BitMux { width } | CellKind::BitSame { width } | CellKind::Products { width, .. }, _) => *width,
            (CellKind::CarrySave { width }, _) | (CellKind::Carry { width }, 0 | 1) => *width,
            (CellKind::Alu(alu), 0) => alu.a_width,
            (CellKind::Alu(alu), 1) => alu.b_width,
            (CellKind::EdgeFlop(f), 1 | 2) => f.init.width(),
            (CellKind::Latch(f) | CellKind::Flop(f), 1) => f.init.width(),
            (CellKind::Counter(c), 1) => c.init.width(),
            (CellKind::Accumulator(a), 1) => a.init.width(),
            (CellKind::Memory(m), 0..=3) => m.reads.len() as u32,
            (CellKind::Memory(m), 4) => m.reads.len() as u32 * m.abits,
            (CellKind::Memory(m), 5) => m.writes.len() as u32,
            (CellKind::Memory(m), 7) => m.writes.len() as u32 * m.abits,
            (CellKind::Memory(m), _) => m.writes.len() as u32 * m.width,
            _ => 1,
        }
    }

    /// The width in bits of output pin `index`.
    #[must_use]
    pub fn output_width(&self, index: usize) -> u32 {
        match (self, index) {
            (
                CellKind::Gate { width, .. }
                | CellKind::AndOr { width, .. }
                | CellKind::Mux { width, .. }
                | CellKind::Tristate { width }
                | CellKind::Resolve { width, .. }
                | CellKind::Delay { width, .. }
                | CellKind::Adder { width, .. }
                | CellKind::Shift { width, .. }
                | CellKind::Divide { width, .. }
                | CellKind::Power { width, .. }
                | CellKind::OneHotMux { width, .. }
                | CellKind::BitMux { width }
                | CellKind::BitSame { width }
                | CellKind::Carry { width },
                0,
            ) => *width,
            (CellKind::CarrySave { width }, _) => *width,
            (CellKind::Demux { width, select }, _) => width << select,
            (CellKind::Alu(alu), _) => alu.width,
            (CellKind::EdgeFlop(f), _) => f.init.width(),
            (CellKind::Multiply { a_width, b_width, .. }, _) => a_width + b_width,
            (CellKind::Constant(v), _) => v.width(),
            (CellKind::Latch(f) | CellKind::Flop(f), _) => f.init.width(),
            (CellKind::Counter(c), 0) => c.init.width(),
            (CellKind::Accumulator(a), 0) => a.init.width(),
            (CellKind::Memory(m), _) => m.start.width(),
            _ => 1,
        }
    }

    /// The clock edge, for a cell that has one clock.
    #[must_use]
    pub fn edge(&self) -> Option<Edge> {
        match self {
            CellKind::Flop(f) | CellKind::EdgeFlop(f) => Some(f.edge),
            CellKind::Counter(c) => Some(c.edge),
            CellKind::Accumulator(a) => Some(a.edge),
            _ => None,
        }
    }

    /// The edge at which bit `bit` of input pin `pin` clocks the cell; none if it is no clock.
    #[must_use]
    pub fn edge_at(&self, pin: usize, bit: u32) -> Option<Edge> {
        match (self, pin) {
            // without ports the pin has no bits
            (CellKind::Memory(m), 0) => m.reads.get(bit as usize)?.clock,
            (CellKind::Memory(m), 5) => m.writes.get(bit as usize)?.clock,
            _ => self.edge().filter(|_| self.inputs()[pin].role == Role::Clock),
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
            _ => None,
        }
    }
}
