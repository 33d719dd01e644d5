//! A netlist laid out for the event engine: dense arrays of operations in evaluation order, and what each word of state
//! wakes when it changes. Built once; the run only reads it.

use std::ops::Range;

use crate::cell::{CellKind, CompareOp, GateOp, Memory};
use crate::netlist::{CellId, NetId};
use crate::value::Word;

/// Which bits of a word of state an operand is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Part {
    /// All that the word holds: nothing to shift, nothing to cut off.
    Whole,
    /// From bit `shift` up.
    Bits,
    /// Bit `shift` repeated.
    Splat,
}

/// Bits of one word of state.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Operand {
    pub slot: u32,
    pub shift: u8,
    pub part: Part,
}

/// The slots that hold constant 0 and constant 1 for pins that are not connected.
pub(super) const ZERO: Operand = Operand { slot: 0, shift: 0, part: Part::Whole };
pub(super) const ONE: Operand = Operand { slot: 1, shift: 0, part: Part::Whole };

/// What an operation does. All but the last have operands of at most 64 bits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Code {
    Buf,
    Not,
    And2,
    Or2,
    Xor2,
    Nand2,
    Nor2,
    Xnor2,
    /// `count` operands from the pool.
    GateN(GateOp),
    /// The bits of `a` within `mask` joined into one.
    Reduce(GateOp),
    /// `count` pairs of input and select from the pool.
    AndOrN,
    Mux2,
    /// Of `count` operands from the pool the one that `c` says.
    Mux,
    /// Of `count` operands from the pool the one whose bit of `c` is 1, or `a`.
    OneHotMux,
    /// `a` and `b` of `count` bits.
    Compare {
        op: CompareOp,
        signed: bool,
    },
    HalfAdder,
    FullAdder,
    Add,
    Sub,
    /// s, r → q, qn.
    Sr {
        set_dominates: bool,
    },
    /// Set `a` and reset `b` of store number `ext`, of which only the state is used.
    SetReset,
    /// Asynchronous controls of store number `ext`, and the output made from its state if `count` is not 0.
    Level,
    /// `count` pieces from the pool, with their widths, one above another.
    Gather,
    /// Read port `count` of memory number `ext`: what it does without a clock.
    MemoryRead,
    /// The write ports of memory number `ext` that have no clock.
    MemoryWrite,
    /// Cell number `ext` of the narrow ones.
    Narrow,
    /// Cell number `ext` of the general ones.
    General,
}

/// One combinational operation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Op {
    pub code: Code,
    /// 0, or the number of its feedback group plus one.
    pub group: u32,
    pub a: Operand,
    pub b: Operand,
    pub c: Operand,
    pub y: u32,
    pub y2: u32,
    pub mask: u64,
    pub ext: u32,
    pub count: u32,
}

/// What a clocked cell does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum StoreCode {
    /// Only `d` and `en`.
    Plain,
    /// Only `d`, `set` and `reset`.
    SetReset,
    Flop,
    Counter,
    Accumulator,
    /// Port `q` of memory number `general`, those that write after those that read.
    Memory,
    General,
}

/// A storage cell with a clock; of at most 64 bits unless general.
#[derive(Clone, Debug)]
pub(super) struct Store {
    pub code: StoreCode,
    pub q: u32,
    /// `qn`, `zero` or `co`.
    pub derived: u32,
    pub width: u32,
    /// The pins, by their numbers: those of the clock are not looked at.
    pub pins: [Operand; 8],
    /// The set value; the step of a counter.
    pub set_value: Word,
    pub reset_value: Word,
    /// Number among the general cells.
    pub general: u32,
}

impl Store {
    /// One of which no control is connected.
    pub const BLANK: Store = Store {
        code: StoreCode::General,
        q: 0,
        derived: 0,
        width: 1,
        pins: [ZERO; 8],
        set_value: Word::ZERO,
        reset_value: Word::ZERO,
        general: 0,
    };
}

/// A cell without state and with no pin of more than 64 bits, evaluated through the reference functions.
#[derive(Clone, Debug)]
pub(super) struct Narrow {
    pub kind: CellKind,
    pub pins: Pool,
    /// The slot of each output.
    pub outputs: Vec<u32>,
}

/// A cell of any kind and width, evaluated through the reference functions of the cell room.
#[derive(Clone, Debug)]
pub(super) struct General {
    pub kind: CellKind,
    /// For each pin its pieces (low first); none if it is not connected.
    pub pins: Vec<Vec<(u32, u32, u32)>>,
    /// First slot and width of each output.
    pub outputs: Vec<(u32, u32)>,
}

/// Some machine words of a pin, as a range of `Program::pool`.
pub(super) type Pool = Range<usize>;

/// A port of a memory that reads.
#[derive(Clone, Debug)]
pub(super) struct MemoryRead {
    pub en: Operand,
    pub arst: Operand,
    pub srst: Operand,
    pub address: Operand,
    /// Where what it gives begins: a slot and a bit of it.
    pub slot: u32,
    pub shift: u32,
}

/// A port of a memory that writes.
#[derive(Clone, Debug)]
pub(super) struct MemoryWrite {
    pub address: Operand,
    pub data: Pool,
    pub enable: Pool,
}

/// A memory.
#[derive(Clone, Debug)]
pub(super) struct MemoryCell {
    pub cell: CellId,
    pub kind: Box<Memory>,
    /// A slot without a net whose readers are what a change of the contents wakes. Those of the next are what a change
    /// by a port with a clock wakes.
    pub contents: u32,
    pub reads: Vec<MemoryRead>,
    pub writes: Vec<MemoryWrite>,
}

/// A bit at which edges are looked for.
#[derive(Clone, Debug)]
pub(super) struct ClockPin {
    pub slot: u32,
    pub shift: u8,
    /// Whether being 1 from the start is an edge: the control is one that acts.
    pub level: bool,
    /// Stores that sample at the rising edge.
    pub rising: Vec<u32>,
    /// Stores that sample at the falling edge.
    pub falling: Vec<u32>,
    /// Stores that sample when this asynchronous control goes from 0 to unknown.
    pub unknown: Vec<u32>,
}

/// A control pin of a storage cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct ControlPin {
    pub slot: u32,
    pub shift: u8,
    pub cell: CellId,
    pub pin: &'static str,
    pub net: NetId,
}

/// A delay.
#[derive(Clone, Debug)]
pub(super) struct DelayCell {
    pub kind: CellKind,
    pub input: Vec<(u32, u32, u32)>,
    pub y: u32,
    pub width: u32,
}

/// What a change of a slot wakes.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Meta {
    /// The first dirty bits that it sets; most have no others.
    pub mask: u64,
    pub word: u32,
    /// The others, in `Program::wakes`.
    pub more_start: u32,
    pub more_end: u32,
    /// Number among the hooks, where a flag says that it has one.
    pub hook: u32,
    pub flags: u8,
}

/// Bits of [`Meta::flags`].
pub(super) mod flag {
    pub const CLOCK: u8 = 1;
    pub const CONTROL: u8 = 2;
    pub const DELAY: u8 = 4;
    pub const OBSERVED: u8 = 8;
    pub const CHANGED: u8 = 16;
    pub const FORCED: u8 = 32;
}

/// Clock pins, control pins and delays that a slot is read by, as ranges of `Program::hooked`.
#[derive(Clone, Debug, Default)]
pub(super) struct Hook {
    pub clocks: Range<usize>,
    pub controls: Range<usize>,
    pub delays: Range<usize>,
}

/// Further dirty bits that a change sets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wake {
    pub word: u32,
    pub mask: u64,
}

#[derive(Debug, Default)]
pub(super) struct Program {
    pub ops: Vec<Op>,
    /// Operands of operations with many, each with its width.
    pub pool: Vec<(Operand, u32)>,
    pub groups: Vec<Range<usize>>,
    /// Slots written in each group, and the bits of each that are a net's.
    pub group_slots: Vec<Vec<(u32, u64)>>,
    /// Operations of each group that only bring bits together.
    pub group_gathers: Vec<Vec<u32>>,
    pub stores: Vec<Store>,
    pub narrows: Vec<Narrow>,
    pub generals: Vec<General>,
    pub memories: Vec<MemoryCell>,
    pub clocks: Vec<ClockPin>,
    pub controls: Vec<ControlPin>,
    pub delays: Vec<DelayCell>,
    pub wakes: Vec<Wake>,
    pub hooks: Vec<Hook>,
    pub hooked: Vec<u32>,
    /// First slot of each net, and one past the last.
    pub net_slot: Vec<u32>,
    /// Net of each slot.
    pub slot_net: Vec<u32>,
    /// By net: whether anything reads it or it has a name.
    pub used: Vec<bool>,
    /// Clock cells: slot and parameters.
    pub clock_cells: Vec<(u32, crate::cell::Clock)>,
    /// The readers of each slot.
    pub meta: Vec<Meta>,
    pub initial: Vec<Word>,
}
