//! How an element appears in a circuit file: its name, ports, parameters and documentation. The reference page
//! `docs/elements.md` is made from these descriptions.

use std::sync::Arc;

use super::{AddOp, CellKind, CompareOp, GateOp};
use crate::Value;
use crate::value::Word;

/// An element that a circuit file can name as the `type` of a cell.
#[derive(Debug)]
pub struct Element {
    /// What a cell's `type` says, in lower case.
    pub name: &'static str,
    /// A few words that say what it is, for lists.
    pub summary: &'static str,
    /// The ports as the file names them.
    pub ports: &'static [Port],
    /// The parameters that a circuit file may set.
    pub parameters: &'static [Parameter],
    /// The truth table or formula, in Markdown.
    pub meaning: &'static str,
    /// Where the meaning comes from: a document, an IEEE clause, a Yosys cell.
    pub source: &'static str,
    /// A cell as a circuit file writes it; `NAME` stands for the element's name.
    pub example: &'static str,
    /// Makes the cell from its arguments, or says what is wrong with them.
    pub build: fn(&Arguments) -> Result<CellKind, String>,
}

/// A port of an element.
#[derive(Debug, Clone, Copy)]
pub struct Port {
    /// The name in a cell's `connections`.
    pub name: &'static str,
    /// The pin of the cell that it is; most have the same name.
    pub pin: &'static str,
    /// Whether the cell drives it.
    pub output: bool,
    /// Whether it must be connected.
    pub required: bool,
    /// Whether it takes an array with one member for each input.
    pub several: bool,
    /// What it is for.
    pub doc: &'static str,
}

impl Port {
    /// An input that must be connected.
    #[must_use]
    pub const fn input(name: &'static str, doc: &'static str) -> Port {
        Port { name, pin: name, output: false, required: true, several: false, doc }
    }

    /// An input that has a default.
    #[must_use]
    pub const fn optional(name: &'static str, doc: &'static str) -> Port {
        Port { required: false, ..Port::input(name, doc) }
    }

    /// A port that takes several inputs.
    #[must_use]
    pub const fn several(name: &'static str, doc: &'static str) -> Port {
        Port { several: true, ..Port::input(name, doc) }
    }

    /// An output; it may be left open.
    #[must_use]
    pub const fn output(name: &'static str, doc: &'static str) -> Port {
        Port { output: true, required: false, ..Port::input(name, doc) }
    }

    /// The same port for a pin of another name.
    #[must_use]
    pub const fn of_pin(self, pin: &'static str) -> Port {
        Port { pin, ..self }
    }
}

/// What a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// An integer expression within bounds.
    Integer {
        /// The least.
        min: i64,
        /// The greatest.
        max: i64,
    },
    /// One of some words.
    Word(&'static [&'static str]),
    /// A value of `width` bits: a number or a literal; `all-ones` and `x` too.
    Value,
    /// A positive quantity with an SI prefix, such as `10k` or `100p`.
    Quantity,
    /// What a memory holds at the start, of `words` words of `width` bits: one value for all of them, an array of values,
    /// or the name of a file as `$readmemh` reads it.
    Contents,
}

impl Kind {
    /// A width in bits.
    pub const WIDTH: Kind = Kind::Integer { min: 1, max: 1 << 20 };
    /// 0 or 1.
    pub const FLAG: Kind = Kind::Integer { min: 0, max: 1 };
}

/// A parameter of an element.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// The name in a cell's `parameters`.
    pub name: &'static str,
    /// Which values it takes.
    pub kind: Kind,
    /// The text that stands for it when it is not given; without one it must be given.
    pub default: Option<&'static str>,
    /// What it is, with the unit.
    pub doc: &'static str,
}

/// One argument, read as its parameter's kind says.
#[derive(Debug, Clone, PartialEq)]
pub enum Argument {
    /// Of [`Kind::Integer`].
    Integer(i64),
    /// Of [`Kind::Word`].
    Word(String),
    /// Of [`Kind::Value`].
    Value(Value),
    /// Of [`Kind::Quantity`], in the unit of the parameter.
    Quantity(f64),
    /// Of [`Kind::Contents`], laid out as [`Memory::contents`](super::Memory::contents) says.
    Contents(Arc<[Word]>),
}

/// The arguments of one cell: every parameter of its element has a value.
#[derive(Debug, Clone)]
pub struct Arguments {
    /// Name and value, checked against the parameter's kind.
    pub values: Vec<(&'static str, Argument)>,
    /// How many inputs the port that takes several has (0 if there is none).
    pub inputs: u32,
    /// Seconds in a tick.
    pub tick: f64,
}

impl Arguments {
    fn get(&self, name: &str) -> &Argument {
        let found = self.values.iter().find(|(n, _)| *n == name);
        &found.expect("an element asks only for its own parameters").1
    }

    /// An integer.
    pub(super) fn integer(&self, name: &str) -> i64 {
        match self.get(name) {
            Argument::Integer(n) => *n,
            other => unreachable!("{name} is {other:?}"),
        }
    }

    /// A width in bits.
    pub(super) fn width(&self, name: &str) -> u32 {
        self.integer(name) as u32
    }

    /// A 0 or 1.
    pub(super) fn flag(&self, name: &str) -> bool {
        self.integer(name) != 0
    }

    /// A word.
    pub(super) fn word(&self, name: &str) -> &str {
        match self.get(name) {
            Argument::Word(w) => w,
            other => unreachable!("{name} is {other:?}"),
        }
    }

    /// A value.
    pub(super) fn value(&self, name: &str) -> Value {
        match self.get(name) {
            Argument::Value(v) => v.clone(),
            other => unreachable!("{name} is {other:?}"),
        }
    }

    /// A quantity.
    pub(super) fn quantity(&self, name: &str) -> f64 {
        match self.get(name) {
            Argument::Quantity(q) => *q,
            other => unreachable!("{name} is {other:?}"),
        }
    }

    /// The contents of a memory.
    pub(super) fn contents(&self, name: &str) -> Arc<[Word]> {
        match self.get(name) {
            Argument::Contents(words) => words.clone(),
            other => unreachable!("{name} is {other:?}"),
        }
    }
}

/// Every element, family by family.
pub fn elements() -> impl Iterator<Item = &'static Element> {
    [
        super::gate::ELEMENTS,
        super::arith::ELEMENTS,
        super::select::ELEMENTS,
        super::storage::ELEMENTS,
        super::counter::ELEMENTS,
        super::memory::ELEMENTS,
        super::time::ELEMENTS,
    ]
    .into_iter()
    .flatten()
}

/// The element of a name.
#[must_use]
pub fn element(name: &str) -> Option<&'static Element> {
    elements().find(|e| e.name == name)
}

impl CellKind {
    /// The name of the element that makes such a cell; of `dff` and `register`, which are of one kind, `dff`. What joins
    /// the drivers of a bus is no element, and a `resolve`; nor are the kinds that only other formats make.
    #[must_use]
    pub fn element(&self) -> &'static str {
        match self {
            CellKind::Gate { op: GateOp::And, .. } => "and",
            CellKind::Gate { op: GateOp::Or, .. } => "or",
            CellKind::Gate { op: GateOp::Xor, .. } => "xor",
            CellKind::Gate { op: GateOp::Nand, .. } => "nand",
            CellKind::Gate { op: GateOp::Nor, .. } => "nor",
            CellKind::Gate { op: GateOp::Xnor, .. } => "xnor",
            CellKind::Gate { op: GateOp::Buf, .. } => "buf",
            CellKind::Gate { op: GateOp::Not, .. } => "not",
            CellKind::AndOr { .. } => "and_or",
            CellKind::Majority { .. } => "majority",
            CellKind::IsZero { .. } => "is_zero",
            CellKind::HalfAdder => "half_adder",
            CellKind::FullAdder => "full_adder",
            CellKind::Adder { op: AddOp::Add, .. } => "adder",
            CellKind::Adder { op: AddOp::Sub, .. } => "subtractor",
            CellKind::Adder { op: AddOp::AddSub, .. } => "add_sub",
            CellKind::Multiply { .. } => "multiplier",
            CellKind::Mux { .. } => "mux",
            CellKind::Compare { op: CompareOp::Eq, .. } => "eq",
            CellKind::Compare { op: CompareOp::Ne, .. } => "ne",
            CellKind::Compare { op: CompareOp::Lt, .. } => "lt",
            CellKind::Compare { op: CompareOp::Le, .. } => "le",
            CellKind::Compare { op: CompareOp::Gt, .. } => "gt",
            CellKind::Compare { op: CompareOp::Ge, .. } => "ge",
            CellKind::Compare { op: CompareOp::Same, .. } => "same",
            CellKind::Compare { op: CompareOp::Differs, .. } => "differs",
            CellKind::Shift { .. } => "shift",
            CellKind::Divide { .. } => "divider",
            CellKind::Power { .. } => "power",
            CellKind::OneHotMux { .. } => "one_hot_mux",
            CellKind::Demux { .. } => "demux",
            CellKind::BitMux { .. } => "bit_mux",
            CellKind::BitSame { .. } => "bit_same",
            CellKind::Products { .. } => "products",
            CellKind::CarrySave { .. } => "carry_save",
            CellKind::Carry { .. } => "carry",
            CellKind::Alu(_) => "alu",
            CellKind::EdgeFlop(_) => "edge_dff",
            CellKind::Memory(_) => "memory",
            CellKind::Tristate { .. } => "tristate",
            CellKind::Resolve { .. } => "resolve",
            CellKind::Sr { .. } => "sr",
            CellKind::Flop(_) => "dff",
            CellKind::Latch(_) => "latch",
            CellKind::Counter(_) => "counter",
            CellKind::Accumulator(_) => "accumulator",
            CellKind::Constant(_) => "constant",
            CellKind::Clock(_) => "clock",
            CellKind::Delay { .. } => "delay",
            CellKind::RcDelay(_) => "rc_delay",
        }
    }
}
