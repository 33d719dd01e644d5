//! The flat netlist: nets, cells, and the scopes and names through which people see them.
//!
//! A netlist is immutable once built, and every net has exactly one driver. All that follows (checks, engines, waves)
//! reads it and nothing upstream of it: it knows neither files nor engines.

mod bits;
mod builder;
mod bus;
mod constant;
pub mod depth;
mod fault;
mod fingerprint;
pub mod graph;
pub mod hierarchy;
mod id;
mod join;
mod order;
mod region;
pub mod stats;
mod wires;

use std::sync::{Arc, OnceLock};

use crate::cell::{CellKind, Edge, GateOp, Role};
use crate::timescale::Timescale;

pub use crate::value::ValueNames;
pub use builder::{Builder, Mem, Reg};
pub use bus::Bus;
pub use constant::Constants;
pub use depth::Depth;
pub use fault::{BuildError, Fault};
pub use hierarchy::Hierarchy;
pub use id::{CellId, NetId, ScopeId, SignalId};
pub use order::{Loop, Order};
pub use region::{Bit, Region};
pub use stats::Stats;

/// The name of the constants that stand for what nothing drives.
const UNDRIVEN: &str = "undriven";

/// `width` bits of a net from bit `lo` up.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Slice {
    /// The net that it is cut from.
    pub net: NetId,
    /// The net's bit that is bit 0 of the slice.
    pub lo: u32,
    /// How many bits, at least one; `lo + width` is at most the net's width.
    pub width: u32,
}

/// What drives a net.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Driver {
    /// Output pin `.1` of a cell.
    Cell(CellId, u8),
    /// The circuit's input of this name.
    Input(SignalId),
}

/// A net: a vector of bits with exactly one driver.
#[derive(Clone, Copy, Debug)]
pub struct Net {
    /// How many bits, at least one.
    pub width: u32,
    /// The output pin or input that all its bits come from.
    pub driver: Driver,
}

/// A cell of the netlist; its pins are read through [`Netlist`].
#[derive(Clone, Debug)]
pub struct Cell {
    /// What it computes, with its widths and edges.
    pub kind: CellKind,
    /// The element as which it was drawn: a `register` and a `dff` are of one kind.
    pub element: &'static str,
    /// The name within its scope.
    pub name: String,
    /// The instance or block that it is in.
    pub scope: ScopeId,
    first_pin: u32,
    first_output: NetId,
}

/// A scope: an instance of a module, or a block within one.
#[derive(Clone, Debug)]
pub struct Scope {
    /// The name within the parent.
    pub name: String,
    /// The scope around it; none around the top.
    pub parent: Option<ScopeId>,
    /// The module that it is an instance of; none for a block.
    pub module: Option<String>,
    /// The values of the module's parameters, where they are known.
    pub parameters: Vec<(String, i64)>,
}

/// Which way a port of a module goes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Direction {
    /// Driven from outside.
    Input,
    /// Driven by the module.
    Output,
    /// Driven by the module's tri-state cells.
    Inout,
}

/// A named vector of bits, most of them a whole net.
#[derive(Clone, Debug)]
pub struct Signal {
    /// The name within its scope.
    pub name: String,
    /// The scope in which it is declared.
    pub scope: ScopeId,
    /// How many bits; at least one.
    pub width: u32,
    /// Whether people read it in two's complement.
    pub signed: bool,
    /// Its lowest index where it was declared, as 5 of `[12:5]`.
    pub offset: i64,
    /// Whether it was declared with indices that rise towards the least significant bit, as in `[0:7]`.
    pub upto: bool,
    /// What people call its values, where they have names.
    pub values: Option<Arc<ValueNames>>,
    /// Which way it goes, for a port of the module of its scope.
    pub port: Option<Direction>,
    /// Whether a tool made it up: it can be asked for, but is not shown among the others.
    pub hidden: bool,
    /// The net through which it is driven from outside, for an input or inout of the top module.
    pub drive: Option<NetId>,
    first_slice: u32,
    slices: u32,
}

impl Signal {
    /// The index of its least significant bit where it was declared.
    #[must_use]
    pub fn lsb(&self) -> i64 {
        if self.upto { self.offset.saturating_add(i64::from(self.width) - 1) } else { self.offset }
    }

    /// The index of a bit where it was declared.
    #[must_use]
    pub fn index(&self, bit: u32) -> i64 {
        if self.upto { self.lsb().saturating_sub(i64::from(bit)) } else { self.lsb().saturating_add(i64::from(bit)) }
    }

    /// The bit of an index, if it has one.
    #[must_use]
    pub fn bit(&self, index: i64) -> Option<u32> {
        let bit = if self.upto { self.lsb().checked_sub(index)? } else { index.checked_sub(self.lsb())? };
        u32::try_from(bit).ok().filter(|&bit| bit < self.width)
    }

    /// Whether it is a port of the top module.
    pub fn is_top_port(&self) -> bool {
        self.port.is_some() && self.scope == ScopeId(0)
    }
}

/// A netlist. Build one with [`Builder`] or load a circuit file. A clone is the same netlist, not a copy of it: simulators
/// on several threads share one.
#[derive(Clone, Debug, Default)]
pub struct Netlist {
    timescale: Timescale,
    content: Arc<Content>,
}

/// What all clones of a netlist share.
#[derive(Debug, Default)]
struct Content {
    nets: Vec<Net>,
    cells: Vec<Cell>,
    /// End of each pin's slices in `slices`, for all pins of all cells in order; the first entry is 0.
    pin_ends: Vec<u32>,
    slices: Vec<Slice>,
    scopes: Vec<Scope>,
    signals: Vec<Signal>,
    signal_slices: Vec<Slice>,
    constants: OnceLock<Constants>,
    order: OnceLock<Order>,
    fingerprint: OnceLock<u64>,
    /// No two netlists that were built have the same; a clone has that of its original.
    identity: u64,
}

impl Netlist {
    /// What a tick is.
    #[must_use]
    pub fn timescale(&self) -> Timescale {
        self.timescale
    }

    /// Makes a tick something else, where nothing but convention said what it is.
    pub fn set_timescale(&mut self, timescale: Timescale) {
        self.timescale = timescale;
    }

    /// A number that tells it from every other netlist of this program; a clone has that of its original.
    #[must_use]
    pub fn identity(&self) -> u64 {
        self.content.identity
    }

    /// The nets.
    #[must_use]
    pub fn nets(&self) -> &[Net] {
        &self.content.nets
    }

    /// The cells.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.content.cells
    }

    /// The scopes; the first is the top, and a parent comes before its children.
    #[must_use]
    pub fn scopes(&self) -> &[Scope] {
        &self.content.scopes
    }

    /// The signals in the order of declaration.
    #[must_use]
    pub fn signals(&self) -> &[Signal] {
        &self.content.signals
    }

    /// The ports of the top module in the order of declaration.
    pub fn ports(&self) -> impl Iterator<Item = SignalId> + '_ {
        self.signal_ids().filter(|&id| self.signal(id).is_top_port())
    }

    /// Every cell's number.
    pub fn cell_ids(&self) -> impl ExactSizeIterator<Item = CellId> + use<> {
        (0..self.content.cells.len() as u32).map(CellId)
    }

    /// Every net's number.
    pub fn net_ids(&self) -> impl ExactSizeIterator<Item = NetId> + use<> {
        (0..self.content.nets.len() as u32).map(NetId)
    }

    /// For each net whether any cell reads it or it has a name. What has neither nobody can see.
    #[must_use]
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.content.nets.len()];
        let pins = |cell: CellId| (0..self.cell(cell).kind.inputs().len()).map(move |pin| (cell, pin));
        let read = self.cell_ids().flat_map(pins).flat_map(|(cell, pin)| self.input(cell, pin));
        let named = self.signal_ids().flat_map(|signal| self.bits(signal));
        read.chain(named).for_each(|slice| used[slice.net.index()] = true);
        used
    }

    /// Every signal's number.
    pub fn signal_ids(&self) -> impl ExactSizeIterator<Item = SignalId> + use<> {
        (0..self.content.signals.len() as u32).map(SignalId)
    }

    /// A cell.
    #[must_use]
    pub fn cell(&self, id: CellId) -> &Cell {
        &self.content.cells[id.index()]
    }

    /// A net.
    #[must_use]
    pub fn net(&self, id: NetId) -> Net {
        self.content.nets[id.index()]
    }

    /// A signal.
    #[must_use]
    pub fn signal(&self, id: SignalId) -> &Signal {
        &self.content.signals[id.index()]
    }

    /// The bits of a signal, the least significant slice first.
    #[must_use]
    pub fn bits(&self, id: SignalId) -> &[Slice] {
        let s = self.signal(id);
        &self.content.signal_slices[s.first_slice as usize..(s.first_slice + s.slices) as usize]
    }

    /// What input pin `index` of a cell is connected to, the least significant slice first; empty if to nothing.
    #[must_use]
    pub fn input(&self, cell: CellId, index: usize) -> &[Slice] {
        let pin = self.cell(cell).first_pin as usize + index;
        &self.content.slices[self.content.pin_ends[pin] as usize..self.content.pin_ends[pin + 1] as usize]
    }

    /// The net that output pin `index` of a cell drives.
    #[must_use]
    pub fn output(&self, cell: CellId, index: usize) -> NetId {
        NetId(self.cell(cell).first_output.0 + index as u32)
    }

    /// For each clock of a cell the bit from which it comes, through buffers and inverters at most, whether it arrives
    /// inverted, and the edge of the pin.
    pub fn clock_sources(&self, cell: CellId) -> impl Iterator<Item = (Slice, bool, Edge)> + '_ {
        let kind = &self.cell(cell).kind;
        let clocks = (0..kind.inputs().len()).filter(|&pin| kind.inputs()[pin].role == Role::Clock);
        clocks.flat_map(move |pin| {
            let bits = self.input(cell, pin).iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| (s.net, lo)));
            bits.enumerate().filter_map(move |(bit, (net, lo))| {
                let edge = kind.edge_at(pin, bit as u32)?;
                let (source, inverted) = self.clock_source(Slice { net, lo, width: 1 });
                Some((source, inverted, edge))
            })
        })
    }

    fn clock_source(&self, mut bit: Slice) -> (Slice, bool) {
        let mut inverted = false;
        // inverters may stand in a circle
        for _ in 0..self.content.cells.len() {
            let Driver::Cell(from, _) = self.net(bit.net).driver else { break };
            let CellKind::Gate { op: op @ (GateOp::Buf | GateOp::Not), width: 1, .. } = self.cell(from).kind else {
                break;
            };
            let Some(&slice) = self.input(from, 0).first() else { break };
            bit = slice;
            inverted ^= op == GateOp::Not;
        }
        (bit, inverted)
    }

    /// The path of a scope below the top, with a dot after it unless it is the top: `adder.fa[3].`.
    fn prefix(&self, scope: ScopeId) -> String {
        let scope = &self.content.scopes[scope.index()];
        match scope.parent {
            None => String::new(),
            Some(parent) => format!("{}{}.", self.prefix(parent), scope.name),
        }
    }

    /// The path of a scope below the top module: `adder.fa[3]`, nothing for the top.
    #[must_use]
    pub fn scope_path(&self, scope: ScopeId) -> String {
        let mut path = self.prefix(scope);
        path.pop();
        path
    }

    /// Whether a constant drives a net.
    fn is_tied(&self, net: NetId) -> bool {
        matches!(self.net(net).driver, Driver::Cell(cell, _) if matches!(self.cell(cell).kind, CellKind::Constant(_)))
    }

    /// Whether nothing drives a net of another tool's netlist: it is z.
    #[must_use]
    pub fn is_undriven(&self, net: NetId) -> bool {
        matches!(self.net(net).driver, Driver::Cell(cell, _)
            if self.cell(cell).name == UNDRIVEN && matches!(self.cell(cell).kind, CellKind::Constant(_)))
    }

    /// The path of a signal below the top module: `f`, `adder.fa[3].s`.
    #[must_use]
    pub fn signal_path(&self, id: SignalId) -> String {
        let s = self.signal(id);
        format!("{}{}", self.prefix(s.scope), s.name)
    }

    /// The path of a cell below the top module.
    #[must_use]
    pub fn cell_path(&self, id: CellId) -> String {
        let c = self.cell(id);
        format!("{}{}", self.prefix(c.scope), c.name)
    }

    /// The signal of a path below the top module.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<SignalId> {
        // a scope's name may itself hold dots, so compare whole paths; used at set-up only
        let name = path.rsplit('.').next()?;
        let simple = self.signal_ids().find(|&id| self.signal(id).name == name && self.signal_path(id) == path);
        simple.or_else(|| {
            self.signal_ids().find(|&id| path.ends_with(&self.signal(id).name) && self.signal_path(id) == path)
        })
    }

    /// How many scopes there are around a scope.
    fn depth(&self, scope: ScopeId) -> usize {
        self.content.scopes[scope.index()].parent.map_or(0, |parent| 1 + self.depth(parent))
    }

    /// A name for a net: the signal that shows it, of several one that no tool made up, the one nearest to the top and
    /// then the first by name, or the pin that drives it.
    #[must_use]
    pub fn net_name(&self, net: NetId) -> String {
        let shown = self.signal_ids().filter(|&id| self.bits(id).iter().any(|s| s.net == net));
        let shown =
            shown.min_by_key(|&id| (self.signal(id).hidden, self.depth(self.signal(id).scope), self.signal_path(id)));
        match (shown, self.net(net).driver) {
            (Some(id), _) => {
                let whole = self.bits(id).len() == 1;
                let name = self.signal_path(id);
                if whole {
                    return name;
                }
                let mut at = 0;
                for s in self.bits(id) {
                    if s.net == net {
                        return if s.width == 1 {
                            format!("{name}[{at}]")
                        } else {
                            format!("{name}[{}:{at}]", at + s.width - 1)
                        };
                    }
                    at += s.width;
                }
                name
            }
            (None, driver) => self.driver_name(driver),
        }
    }

    /// A name for what drives a net: a pin or an input.
    fn driver_name(&self, driver: Driver) -> String {
        match driver {
            Driver::Cell(cell, pin) => {
                format!("{}.{}", self.cell_path(cell), self.cell(cell).kind.outputs()[pin as usize])
            }
            Driver::Input(signal) => self.signal_path(signal),
        }
    }
}
