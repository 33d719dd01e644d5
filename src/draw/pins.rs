//! The pins of a cell as they are drawn: a vector that stands for several inputs is taken apart.

use super::scene::{End, Node, Pin, Shape, Side, What};
use crate::Value;
use crate::cell::{AddOp, CellKind, CompareOp, DivideOp, Edge, GateOp, Role, ShiftOp};
use crate::netlist::Netlist;
use crate::netlist::hierarchy::{Cell, Piece};

/// A node, and what its pins are connected to, in the order of the pins.
pub(super) type Drawn = (Node, Vec<Vec<Piece>>);

/// So many of the bits from bit `lo` up.
pub(super) fn slice(pieces: &[Piece], lo: u32, width: u32) -> Vec<Piece> {
    let (mut at, end) = (0, lo + width);
    let mut part = Vec::new();
    for piece in pieces {
        let (from, to) = (lo.max(at), end.min(at + piece.width()));
        if from < to {
            part.push(match piece {
                Piece::Wire { wire, lo, .. } => Piece::Wire { wire: *wire, lo: lo + from - at, width: to - from },
                Piece::Constant(value) => {
                    let mut part = Value::unknown(to - from);
                    (from..to).for_each(|i| part.set_bit(i - from, value.bit(i - at)));
                    Piece::Constant(part)
                }
                Piece::Open(_) => Piece::Open(to - from),
            });
        }
        at += piece.width();
    }
    part
}

/// The cell as a node.
pub(super) fn cell(netlist: &Netlist, cell: &Cell, name: String) -> Drawn {
    let flat = netlist.cell(cell.id);
    let kind = &flat.kind;
    let (shape, header, inverts) = look(kind, flat.element);
    let mut pins = Vec::new();
    let mut ends = Vec::new();
    for (index, (spec, pieces)) in kind.inputs().iter().zip(&cell.inputs).enumerate() {
        if pieces.is_empty() {
            continue;
        }
        let total = kind.input_width(index);
        let count = kind.inputs_of(index).max(1).min(total.max(1));
        for part in 0..count {
            let width = total / count;
            let single = count == 1 && !numbered(kind, index);
            let at = |name: &str| if single { name.to_owned() } else { format!("{name}[{part}]") };
            let text = match (shape, index) {
                (Shape::Mux, 0) => part.to_string(),
                (Shape::Mux, _) => String::new(),
                _ => at(spec.name),
            };
            let side = if south(shape, index) { Side::South } else { Side::West };
            let clock = match spec.role {
                Role::Clock => kind.edge_at(index, part).map(|e| e == Edge::Falling),
                _ => None,
            };
            pins.push(Pin { name: at(spec.name), text, side, reads: true, clock, end: End::Open });
            ends.push(slice(pieces, part * width, width));
        }
    }
    for (index, (spec, pieces)) in kind.outputs().iter().zip(&cell.outputs).enumerate() {
        let total = kind.output_width(index);
        let count = kind.outputs_of(index).max(1).min(total.max(1));
        for part in 0..count {
            let pieces = slice(pieces, part * (total / count), total / count);
            if pieces.iter().all(|p| matches!(p, Piece::Open(_))) && (index > 0 || count > 1) {
                continue;
            }
            let name = if count == 1 { (*spec).to_owned() } else { format!("{spec}[{part}]") };
            let text = if shape == Shape::Demux { part.to_string() } else { name.clone() };
            pins.push(Pin { name, text, side: Side::East, reads: false, clock: None, end: End::Open });
            ends.push(pieces);
        }
    }
    let stores = kind.init().is_some();
    let title = title(kind, flat.element, &name);
    let ordered = stores || matches!(shape, Shape::Mux | Shape::Demux | Shape::Tristate);
    let what = What::Cell(flat.element.to_owned());
    (Node { what, shape, name, header, title, inverts, ordered, stores, pins }, ends)
}

fn south(shape: Shape, index: usize) -> bool {
    matches!(shape, Shape::Mux | Shape::Demux | Shape::Tristate) && index == 1
}

/// Whether the inputs of a pin are numbered even if there is one alone.
fn numbered(kind: &CellKind, index: usize) -> bool {
    index == 0 && matches!(kind, CellKind::Mux { .. })
}

/// What it looks like, what is written in it, and whether its output is inverted.
fn look(kind: &CellKind, element: &str) -> (Shape, String, bool) {
    let block = |text: &str| (Shape::Block, text.to_owned(), false);
    let sign = |text: &str| (Shape::Sign, text.to_owned(), false);
    match kind {
        CellKind::Gate { op, .. } => {
            let shape = match op {
                GateOp::And | GateOp::Nand => Shape::And,
                GateOp::Or | GateOp::Nor => Shape::Or,
                GateOp::Xor | GateOp::Xnor => Shape::Xor,
                GateOp::Buf | GateOp::Not => Shape::Triangle,
            };
            (shape, String::new(), op.inverts())
        }
        CellKind::Mux { .. } => (Shape::Mux, String::new(), false),
        CellKind::Demux { .. } => (Shape::Demux, String::new(), false),
        CellKind::Tristate { .. } => (Shape::Tristate, String::new(), false),
        CellKind::HalfAdder | CellKind::FullAdder => sign("Σ"),
        CellKind::Adder { op: AddOp::Add, .. } => sign("+"),
        CellKind::Adder { op: AddOp::Sub, .. } => sign("−"),
        CellKind::Adder { op: AddOp::AddSub, .. } => sign("±"),
        CellKind::Multiply { .. } => sign("×"),
        CellKind::Divide { op, .. } => match op {
            DivideOp::Quotient | DivideOp::Floor => sign("÷"),
            DivideOp::Remainder | DivideOp::Modulo => sign("mod"),
        },
        CellKind::Power { .. } => sign("aᵇ"),
        CellKind::Compare { op, .. } => sign(match op {
            CompareOp::Eq => "=",
            CompareOp::Ne => "≠",
            CompareOp::Lt => "<",
            CompareOp::Le => "≤",
            CompareOp::Gt => ">",
            CompareOp::Ge => "≥",
            CompareOp::Same => "≡",
            CompareOp::Differs => "≢",
        }),
        CellKind::IsZero { .. } => sign("= 0"),
        CellKind::Shift { op, .. } => match op {
            ShiftOp::Left => sign("<<"),
            ShiftOp::Right => sign(">>"),
            ShiftOp::RightSigned => sign(">>>"),
            ShiftOp::Both | ShiftOp::Part | ShiftOp::PartSigned => block(element),
        },
        CellKind::Majority { .. } => block("≥ 2"),
        CellKind::AndOr { .. } => block("AND-OR"),
        CellKind::RcDelay(_) => block("RC"),
        CellKind::Delay { ticks, .. } => block(&format!("Δt {ticks}")),
        CellKind::Clock(clock) => block(&format!("clock {}", clock.period)),
        CellKind::Sr { .. } => block("SR"),
        CellKind::Constant(value) => sign(&constant(value)),
        CellKind::OneHotMux { .. }
        | CellKind::BitMux { .. }
        | CellKind::BitSame { .. }
        | CellKind::Products { .. }
        | CellKind::CarrySave { .. }
        | CellKind::Carry { .. }
        | CellKind::Alu(_)
        | CellKind::Resolve { .. }
        | CellKind::Latch(_)
        | CellKind::Flop(_)
        | CellKind::EdgeFlop(_)
        | CellKind::Counter(_)
        | CellKind::Accumulator(_)
        | CellKind::Memory(_) => block(element),
    }
}

/// A constant as it is written: in decimal if it is short and known, else its bits.
pub(super) fn constant(value: &Value) -> String {
    match value.to_u64() {
        Some(n) if value.width() == 1 || n < 10 => n.to_string(),
        Some(n) => format!("{}'h{n:x}", value.width()),
        None => format!("{}'b{}", value.width(), value.bit_string()),
    }
}

/// What is said of a cell to whoever points at it.
fn title(kind: &CellKind, element: &str, name: &str) -> String {
    let width = kind.output_width(0);
    let bits = if width == 1 { "1 bit".to_owned() } else { format!("{width} bits") };
    let more = match kind {
        CellKind::RcDelay(rc) => format!(", τ = {}", rc.tau),
        CellKind::Clock(c) => format!(", period {} ticks, high {}, phase {}", c.period, c.high, c.phase),
        CellKind::Delay { ticks, .. } => format!(", {ticks} ticks"),
        CellKind::Memory(m) => format!(", {} words of {} bits", m.size, m.width),
        kind => match kind.edge() {
            Some(Edge::Rising) => ", rising edge".to_owned(),
            Some(Edge::Falling) => ", falling edge".to_owned(),
            None => String::new(),
        },
    };
    let bits = if matches!(kind, CellKind::Memory(_)) { String::new() } else { format!(", {bits}") };
    format!("{name}: {element}{bits}{more}")
}
