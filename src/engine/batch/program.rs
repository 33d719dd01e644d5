//! A netlist laid out for the batch engine: its bits numbered, its operations in evaluation order, what each bit wakes.

use std::collections::HashMap;
use std::ops::Range;

use super::build::{Build, lanewise};
use super::known::Layout;
use crate::cell::{CellKind, Clock, GateOp};
use crate::netlist::{CellId, NetId, Netlist, Slice};
use crate::value::Word;

/// The bits that pins which are not connected read.
pub(super) const ZERO: u32 = 0;
pub(super) const ONE: u32 = 1;

/// What an operation does to all lanes at once.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Code {
    Gate(GateOp),
    /// A multiplexer of two inputs.
    Mux2,
    /// Any other cell without a state.
    Cell,
    /// What a storage cell does without a clock.
    Storage,
    /// Lane by lane, through the functions of the cell room.
    General,
}

/// One operation.
#[derive(Clone, Debug)]
pub(super) struct Op {
    pub code: Code,
    /// 0, or the number of its feedback group plus one.
    pub group: u32,
    /// Bits of the first output, and inputs of the cell where it says so.
    pub width: u32,
    pub inputs: u32,
    /// Where the bits of each pin begin in the pool; the last is one past the end. The state of a storage cell is the
    /// last pin.
    pub pins: [u32; 10],
    pub pin_count: u8,
    /// The first bit of each output: of a copy of it in a feedback group.
    pub outs: [u32; 3],
    /// Number among the cells that are kept whole, where the code needs one.
    pub cell: u32,
    /// Whether the second output, made from the state, is read or shown.
    pub derived: bool,
    /// Whether it gives known bits where all that it reads is known.
    pub keeps_known: bool,
}

/// A storage cell with a clock.
#[derive(Clone, Debug)]
pub(super) struct Store {
    pub op: Op,
    /// First bit of the state, and of what it takes at an edge.
    pub q: u32,
    pub next: u32,
}

/// A bit at which edges are looked for.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    pub bit: u32,
    /// Whether being 1 from the start is an edge: the control is one that acts.
    pub level: bool,
    pub rising: Vec<u32>,
    pub falling: Vec<u32>,
    /// Stores that sample when this asynchronous control goes from 0 to unknown.
    pub unknown: Vec<u32>,
}

/// What a change of a bit wakes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Wake {
    Op(u32),
    Watch(u32),
}

/// A feedback group: its operations, and its outputs with their copies.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub ops: Range<usize>,
    /// By operation: (copy, bit) pairs.
    pub outputs: Vec<Vec<(u32, u32)>>,
}

/// A netlist as the batch engine runs it; shared by all blocks and threads.
#[derive(Debug)]
pub struct Program {
    pub(super) ops: Vec<Op>,
    pub(super) pool: Vec<u32>,
    pub(super) cells: Vec<CellKind>,
    pub(super) groups: Vec<Group>,
    pub(super) stores: Vec<Store>,
    pub(super) watches: Vec<Watch>,
    pub(super) clock_cells: Vec<(NetId, Clock)>,
    /// First bit and width of each net.
    pub(super) nets: Vec<(u32, u32)>,
    /// By bit, copies included.
    pub(super) initial: Vec<Word>,
    /// Whether a bit is for ever what it is at the start.
    pub(super) constant: Vec<bool>,
    /// The first bit and the width of what is driven from outside, and its number by net.
    pub(super) inputs: Vec<(u32, u32)>,
    pub(super) input_of: HashMap<NetId, usize>,
    /// How it runs while all is known, if it can.
    pub(super) known: Option<Layout>,
    /// Where the wakes of each bit begin.
    pub(super) wake_start: Vec<u32>,
    pub(super) wakes: Vec<Wake>,
}

impl Program {
    /// Lays out a netlist, to show all its nets.
    ///
    /// # Errors
    /// As [`Program::showing`].
    pub fn new(netlist: &Netlist) -> Result<Program, CellId> {
        Program::lay_out(netlist, None)
    }

    /// Lays out a netlist to show these bits alone: the others need not be kept.
    ///
    /// # Errors
    /// The first cell that the batch engine cannot evaluate: a delay or a memory.
    pub fn showing(netlist: &Netlist, bits: &[Slice]) -> Result<Program, CellId> {
        Program::lay_out(netlist, Some(bits))
    }

    /// The first cell of a netlist that the batch engine cannot evaluate, if there is one.
    #[must_use]
    pub fn foreign(netlist: &Netlist) -> Option<CellId> {
        netlist.cell_ids().find(|&c| lanewise(&netlist.cell(c).kind).is_none())
    }

    fn lay_out(netlist: &Netlist, shown: Option<&[Slice]>) -> Result<Program, CellId> {
        if let Some(cell) = Program::foreign(netlist) {
            return Err(cell);
        }
        let mut program = Build::new(netlist).finish();
        let mut kept = vec![shown.is_none(); program.bits()];
        for s in shown.into_iter().flatten() {
            let first = (program.nets[s.net.index()].0 + s.lo) as usize;
            kept[first..first + s.width as usize].fill(true);
        }
        program.known = Layout::new(&program, &kept);
        Ok(program)
    }

    /// Whether there is a form of it for what is all known, without x and z.
    #[must_use]
    pub fn has_known_form(&self) -> bool {
        self.known.is_some()
    }

    /// The free-running clocks among the cells, and the nets that they drive.
    #[must_use]
    pub fn clock_cells(&self) -> &[(NetId, Clock)] {
        &self.clock_cells
    }

    /// How many bits there are.
    #[must_use]
    pub fn bits(&self) -> usize {
        self.initial.len()
    }

    /// The operations, a bit of each output once: what is evaluated when everything changes.
    #[must_use]
    pub fn gates(&self) -> usize {
        self.ops.iter().map(|op| op.width as usize).sum()
    }

    #[inline(always)]
    pub(super) fn woken(&self, bit: u32) -> &[Wake] {
        &self.wakes[self.wake_start[bit as usize] as usize..self.wake_start[bit as usize + 1] as usize]
    }
}
