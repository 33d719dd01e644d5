//! Modules recovered from the flat netlist: each distinct body once, with ports, local wires, cells and instances.
//!
//! What stands in the scope of an instance, and in the blocks within it, is a module's body. Bodies that are equal are
//! one module. Within a module every bit has one wire that stands for it; all else that shows it is another name for it.
//! The cells that resolve several drivers are gone: here they drive one wire together. Nothing here knows of a format.

mod alike;
mod body;
pub mod circles;
mod flat;
mod names;

use super::{CellId, Direction, Netlist, ScopeId, SignalId};
use crate::Value;

/// The modules that a netlist is made of.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    modules: Vec<Module>,
    /// The module of each scope that is an instance.
    of_scope: Vec<Option<u32>>,
}

/// A module.
#[derive(Clone, Debug)]
pub struct Module {
    /// The name, which no other module has.
    pub name: String,
    /// The name that the circuit has for it, which its variants share.
    pub origin: String,
    /// The instance that it was read from.
    pub scope: ScopeId,
    /// How many instances of it there are in all.
    pub uses: usize,
    /// Itself, then the blocks within it, each after the one around it.
    pub blocks: Vec<Block>,
    /// The ports, then the named nets, then those that only tools need a name for.
    pub wires: Vec<Wire>,
    /// The cells.
    pub cells: Vec<Cell>,
    /// The instances of other modules.
    pub instances: Vec<Instance>,
}

/// A part of a module with names of its own, which is no instance: `fa[3]`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Block {
    /// The name within the parent; that of the instance for the module itself.
    pub name: String,
    /// The block around it, by its place among the module's blocks; none around the module itself.
    pub parent: Option<usize>,
    /// Its scope in the instance that the module was read from.
    pub scope: ScopeId,
}

/// A vector of bits with a name.
#[derive(Clone, Debug)]
pub struct Wire {
    /// The name within its block; two wires of a block have one only if two signals of a scope have.
    pub name: String,
    /// The block, by its place among the module's blocks.
    pub block: usize,
    /// Bits.
    pub width: u32,
    /// Whether people read it in two's complement.
    pub signed: bool,
    /// Whether a tool made the name up: the signal is hidden, or there is none.
    pub hidden: bool,
    /// Which way it goes, for a port.
    pub port: Option<Direction>,
    /// What it shows, the least significant first: bits of its own where it stands for them, of others where it is
    /// another name for them. An input or inout stands for all its bits.
    pub bits: Vec<Piece>,
    /// The signal in the instance that the module was read from; none for a wire that no signal shows.
    pub signal: Option<SignalId>,
    /// For a wire without a signal: where it is read from.
    source: Option<Source>,
}

impl Wire {
    /// What it shows of other bits, in runs, each with the place of its lowest bit; `this` is its own place among the
    /// module's wires. Others may be bits of its own that stand elsewhere in it: an output may repeat a bit.
    #[must_use]
    pub fn shown_of_others(&self, this: usize) -> Vec<(u32, Vec<Piece>)> {
        let mut runs: Vec<(u32, Vec<Piece>)> = Vec::new();
        let (mut at, mut follows) = (0, false);
        for piece in &self.bits {
            let stands = matches!(piece, Piece::Wire { wire, lo, .. } if (*wire, *lo) == (this, at));
            match runs.last_mut().filter(|_| follows && !stands) {
                Some((_, run)) => run.push(piece.clone()),
                None if !stands => runs.push((at, vec![piece.clone()])),
                None => {}
            }
            follows = !stands;
            at += piece.width();
        }
        runs
    }
}

/// A cell.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cell {
    /// The cell in the instance that the module was read from: its kind, element and name.
    pub id: CellId,
    /// The block, by its place among the module's blocks.
    pub block: usize,
    /// What each input pin is connected to, the least significant first; empty if to nothing.
    pub inputs: Vec<Vec<Piece>>,
    /// What each output pin drives.
    pub outputs: Vec<Vec<Piece>>,
}

/// An instance of a module.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instance {
    /// The name within its block.
    pub name: String,
    /// The block, by its place among the module's blocks.
    pub block: usize,
    /// The module, by its place in [`Hierarchy::modules`].
    pub module: usize,
    /// Its scope in the instance that the module was read from.
    pub scope: ScopeId,
    /// What each port of the module is connected to, in the order of [`Module::ports`].
    pub ports: Vec<Vec<Piece>>,
}

/// Some adjacent bits within a module.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Piece {
    /// `width` bits of a wire from bit `lo` up.
    Wire {
        /// The wire, by its place among the module's wires.
        wire: usize,
        /// The lowest bit.
        lo: u32,
        /// How many.
        width: u32,
    },
    /// A constant.
    Constant(Value),
    /// So many bits of an output that nothing needs: nobody reads them, or they only pass on what came in elsewhere.
    Open(u32),
}

/// Where the bits of a wire without a signal are found: in a cell or an instance by its place, from this bit up.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Source {
    Output { cell: usize, pin: usize, lo: u32 },
    Instance { instance: usize, port: usize, lo: u32 },
    Port(usize),
}

impl Piece {
    /// Bits.
    #[must_use]
    pub fn width(&self) -> u32 {
        match self {
            Piece::Wire { width, .. } | Piece::Open(width) => *width,
            Piece::Constant(value) => value.width(),
        }
    }
}

impl Wire {
    /// Whether nothing but a tool's need made it: it shows no signal of the circuit.
    #[must_use]
    pub fn is_made(&self) -> bool {
        self.signal.is_none()
    }
}

impl Module {
    /// The ports, by their place among the wires, which they come first of.
    #[must_use]
    pub fn ports(&self) -> &[Wire] {
        let ports = self.wires.iter().take_while(|w| w.port.is_some()).count();
        &self.wires[..ports]
    }

    /// The path of a block below the module, with a dot after it unless it is the module: `fa[3].`.
    #[must_use]
    pub fn prefix(&self, block: usize) -> String {
        match self.blocks[block].parent {
            None => String::new(),
            Some(parent) => format!("{}{}.", self.prefix(parent), self.blocks[block].name),
        }
    }
}

impl Hierarchy {
    /// The modules of a netlist; the same whenever the netlist is.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// use discreta::cell::{CellKind, GateOp};
    /// use discreta::netlist::{Builder, Hierarchy};
    /// let mut b = Builder::new("top");
    /// let (top, a, y) = (b.top(), b.input("a", 1), b.output("y", 1));
    /// let inverter = b.instance(top, "u", "inverter");
    /// b.cell(inverter, "not", CellKind::Gate { op: GateOp::Not, inputs: 1, width: 1 }, vec![a], vec![y]);
    /// let netlist = b.finish().unwrap();
    /// let origins: Vec<_> = Hierarchy::of(&netlist).modules().iter().map(|m| m.origin.clone()).collect();
    /// assert_eq!(origins, ["top", "inverter"]);
    /// ```
    #[must_use]
    pub fn of(netlist: &Netlist) -> Hierarchy {
        body::recover(netlist)
    }

    /// The modules: the top first, every other after one that has an instance of it.
    #[must_use]
    pub fn modules(&self) -> &[Module] {
        &self.modules
    }

    /// The top module.
    #[must_use]
    pub fn top(&self) -> &Module {
        &self.modules[0]
    }

    /// The module of a scope, by its place; none for a block.
    #[must_use]
    pub fn module_of(&self, scope: ScopeId) -> Option<usize> {
        self.of_scope[scope.index()].map(|m| m as usize)
    }
}
