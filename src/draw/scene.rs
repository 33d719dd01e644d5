//! What is to be drawn of one module's body: nodes with pins, and the nets between them. No coordinates yet.

use crate::netlist::Direction;

/// One module's body.
#[derive(Default)]
pub(super) struct Scene {
    pub nodes: Vec<Node>,
    pub nets: Vec<Net>,
}

/// What a node looks like.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    And,
    Or,
    Xor,
    /// Buffer or inverter.
    Triangle,
    /// A buffer with an enable from below.
    Tristate,
    /// A box with the names of its pins.
    Block,
    /// A box with a sign alone, as an adder.
    Sign,
    /// A trapezoid, wide on the left.
    Mux,
    /// A trapezoid, wide on the right.
    Demux,
    /// A bar at which bits are put together.
    Join,
    /// A bar at which bits are taken apart.
    Split,
    Port(Direction),
    /// An instance with its inside.
    Frame,
}

/// What a node stands for.
pub(super) enum What {
    /// A cell of this element.
    Cell(String),
    /// An instance of the module of this name and place.
    Instance(String, usize),
    Port,
    /// `join`, `split` or `repeat`.
    Bar(&'static str),
}

pub(super) struct Node {
    pub what: What,
    pub shape: Shape,
    /// The path below the module; empty for a bar.
    pub name: String,
    /// What is written in it: the element, the module, a sign.
    pub header: String,
    /// For whoever points at it.
    pub title: String,
    /// Whether the output is inverted.
    pub inverts: bool,
    /// Whether the order of the pins on a side is part of the symbol.
    pub ordered: bool,
    /// Whether it holds a state: feedback runs back from it.
    pub stores: bool,
    pub pins: Vec<Pin>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Side {
    West,
    East,
    South,
}

pub(super) struct Pin {
    pub name: String,
    /// What is written beside it.
    pub text: String,
    pub side: Side,
    /// The node reads it.
    pub reads: bool,
    /// The edge, for a clock: whether it is the falling one.
    pub clock: Option<bool>,
    pub end: End,
}

/// What a pin is connected to.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum End {
    Open,
    /// As it is written, and how wide it is.
    Constant(String, u32),
    Net(usize),
}

/// A wire of so many bits.
pub(super) struct Net {
    /// The path below the module of the signal that shows it.
    pub name: Option<String>,
    /// The cell and the pin that drive it.
    pub driver: String,
    /// Which bits of the signal.
    pub lo: u32,
    pub width: u32,
    /// The bits of the signal.
    pub whole: u32,
    pub drivers: Vec<(usize, usize)>,
    pub readers: Vec<(usize, usize)>,
    /// Drawn by its name at every end.
    pub labelled: bool,
}

impl Net {
    /// Which bits of how many: `[3]`, `[7:4]`, nothing if all.
    pub fn bits(&self) -> String {
        if self.width == self.whole { String::new() } else { range(self.lo, self.width) }
    }

    /// The name that is written.
    pub fn label(&self) -> Option<String> {
        self.name.as_ref().map(|name| format!("{name}{}", self.bits()))
    }
}

/// `[3]`, `[7:4]`.
pub(super) fn range(lo: u32, width: u32) -> String {
    if width == 1 { format!("[{lo}]") } else { format!("[{}:{lo}]", lo + width - 1) }
}
