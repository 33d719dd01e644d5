//! What each combinational cell is in Yosys' cells: those that give the same for every one of the four values.

use super::draw::{Draw, ONE, ZERO, repeat};
use super::model::{Bit, Bits, Setting, constant};
use super::own::Own;
use super::{memory, storage};
use crate::cell::select::select_width;
use crate::cell::{AddOp, CellKind, CompareOp, DivideOp, GateOp, ShiftOp};
use crate::{Logic, Value};

/// Draws a cell. Pins that are not connected have no bits; outputs have theirs.
pub fn draw(d: &mut Draw, kind: &CellKind, element: &'static str, ins: &[Bits], outs: &[Bits]) {
    match kind {
        CellKind::Gate { op, width, inputs } => gate(d, *op, *width as usize, *inputs, &ins[0], &outs[0]),
        CellKind::AndOr { width, .. } => and_or(d, *width as usize, &ins[0], &ins[1], &outs[0]),
        CellKind::Majority { width } => majority(d, *width as usize, ins, &outs[0]),
        CellKind::Mux { width, inputs } => mux(d, *width, *inputs, &ins[0], &ins[1], &outs[0]),
        CellKind::HalfAdder => {
            d.binary("", "$xor", &ins[0], &ins[1], outs[0].clone());
            d.binary("co", "$and", &ins[0], &ins[1], outs[1].clone());
        }
        CellKind::FullAdder => full_adder(d, ins, outs),
        CellKind::Adder { op, .. } => adder(d, *op, ins, outs),
        CellKind::Multiply { signed, .. } => {
            d.signed("", "$mul", (*signed, &ins[0]), (*signed, &ins[1]), outs[0].clone());
        }
        CellKind::Compare { op, signed, .. } => {
            let kind = match op {
                CompareOp::Eq => "$eq",
                CompareOp::Ne => "$ne",
                CompareOp::Lt => "$lt",
                CompareOp::Le => "$le",
                CompareOp::Gt => "$gt",
                CompareOp::Ge => "$ge",
                CompareOp::Same => "$eqx",
                CompareOp::Differs => "$nex",
            };
            d.signed("", kind, (*signed, &ins[0]), (*signed, &ins[1]), outs[0].clone());
        }
        CellKind::Shift { op, .. } => {
            let (kind, a_signed, b_signed) = match op {
                ShiftOp::Left => ("$shl", false, false),
                ShiftOp::Right => ("$shr", false, false),
                ShiftOp::RightSigned => ("$sshr", true, false),
                ShiftOp::Both => ("$shift", false, true),
                ShiftOp::Part => ("$shiftx", false, false),
                ShiftOp::PartSigned => ("$shiftx", false, true),
            };
            d.signed("", kind, (a_signed, &ins[0]), (b_signed, &ins[1]), outs[0].clone());
        }
        CellKind::Divide { op, signed, .. } => {
            let kind = match op {
                DivideOp::Quotient => "$div",
                DivideOp::Remainder => "$mod",
                DivideOp::Floor => "$divfloor",
                DivideOp::Modulo => "$modfloor",
            };
            d.signed("", kind, (*signed, &ins[0]), (*signed, &ins[1]), outs[0].clone());
        }
        CellKind::Power { a_signed, b_signed, .. } => {
            d.signed("", "$pow", (*a_signed, &ins[0]), (*b_signed, &ins[1]), outs[0].clone());
        }
        CellKind::OneHotMux { width, inputs } => {
            let sizes = vec![("WIDTH", Setting::Number(*width)), ("S_WIDTH", Setting::Number(*inputs))];
            plain(d, "$pmux", sizes, &["A", "B", "S"], ins, &["Y"], outs);
        }
        CellKind::Demux { width, select } => {
            let sizes = vec![("WIDTH", Setting::Number(*width)), ("S_WIDTH", Setting::Number(*select))];
            plain(d, "$demux", sizes, &["A", "S"], ins, &["Y"], outs);
        }
        CellKind::BitMux { width } => {
            plain(d, "$bwmux", vec![("WIDTH", Setting::Number(*width))], &["A", "B", "S"], ins, &["Y"], outs);
        }
        CellKind::BitSame { width } => {
            plain(d, "$bweqx", vec![("WIDTH", Setting::Number(*width))], &["A", "B"], ins, &["Y"], outs);
        }
        CellKind::Products { width, table } => products(d, *width, table, ins, outs),
        CellKind::CarrySave { width } => {
            plain(d, "$fa", vec![("WIDTH", Setting::Number(*width))], &["A", "B", "C"], ins, &["X", "Y"], outs);
        }
        CellKind::Carry { width } => {
            plain(d, "$lcu", vec![("WIDTH", Setting::Number(*width))], &["P", "G", "CI"], ins, &["CO"], outs);
        }
        CellKind::Alu(alu) => {
            let sign = u32::from(alu.signed);
            let sizes = vec![
                ("A_SIGNED", Setting::Number(sign)),
                ("B_SIGNED", Setting::Number(sign)),
                ("A_WIDTH", Setting::Number(alu.a_width)),
                ("B_WIDTH", Setting::Number(alu.b_width)),
                ("Y_WIDTH", Setting::Number(alu.width)),
            ];
            plain(d, "$alu", sizes, &["A", "B", "CI", "BI"], ins, &["X", "Y", "CO"], outs);
        }
        CellKind::IsZero { .. } => _ = d.unary("", "$logic_not", &ins[0], outs[0].clone()),
        CellKind::Tristate { width } => {
            plain(d, "$tribuf", vec![("WIDTH", Setting::Number(*width))], &["A", "EN"], ins, &["Y"], outs);
        }
        // whatever drives a wire is connected to it
        CellKind::Resolve { .. } => {}
        CellKind::Constant(value) => _ = d.unary("", "$pos", &constant(value), outs[0].clone()),
        CellKind::Memory(m) => memory::draw(d, m, ins, outs),
        CellKind::Sr { set_dominates, init } => storage::sr(d, *set_dominates, init, ins, outs),
        CellKind::Latch(flop) => storage::latch(d, flop, element, ins, outs),
        CellKind::Flop(flop) => storage::flop(d, flop, element, ins, outs),
        CellKind::EdgeFlop(flop) => storage::edge_flop(d, flop, element, ins, outs),
        CellKind::Delay { ticks: 1, init: Some(init), width } => {
            let q = d.state(&outs[0], init);
            plain(d, "$ff", vec![("WIDTH", Setting::Number(*width))], &["D"], ins, &["Q"], &[q]);
        }
        CellKind::Counter(_)
        | CellKind::Accumulator(_)
        | CellKind::Clock(_)
        | CellKind::Delay { .. }
        | CellKind::RcDelay(_) => Own::of(kind, element, ins, outs, d).put(d, kind, ins, outs),
    }
}

/// A cell of which each pin is a port.
fn plain(
    d: &mut Draw,
    kind: &str,
    parameters: Vec<(&'static str, Setting)>,
    in_ports: &[&'static str],
    ins: &[Bits],
    out_ports: &[&'static str],
    outs: &[Bits],
) {
    let pins = |names: &[&'static str], bits: &[Bits]| names.iter().copied().zip(bits.iter().cloned()).collect();
    d.put("", kind, parameters, pins(in_ports, ins), pins(out_ports, outs));
}

/// A gate of one kind in Yosys' words, and whether an inverter is to follow.
fn gate(d: &mut Draw, op: GateOp, width: usize, inputs: u32, ins: &[Bit], y: &[Bit]) {
    let (word, reduce) = match op {
        GateOp::And | GateOp::Nand => ("$and", "$reduce_and"),
        GateOp::Or | GateOp::Nor => ("$or", "$reduce_or"),
        GateOp::Xor => ("$xor", "$reduce_xor"),
        GateOp::Xnor => ("$xor", "$reduce_xnor"),
        GateOp::Buf | GateOp::Not => ("", ""),
    };
    let parts: Vec<&[Bit]> = ins.chunks(width).collect();
    if inputs == 1 {
        if op.inverts() {
            d.unary("", "$not", ins, y.to_vec());
        } else {
            // to all others it is a wire; to us a gate, which makes x of z
            d.unary("", "$pos", ins, y.to_vec()).attributes.push(("discreta", "buf".into()));
        }
        return;
    }
    if inputs == 2 && op == GateOp::Xnor {
        return d.binary("", "$xnor", parts[0], parts[1], y.to_vec());
    }
    if inputs == 2 && width == 1 && matches!(op, GateOp::Nand | GateOp::Nor) {
        let kind = if op == GateOp::Nand { "$_NAND_" } else { "$_NOR_" };
        d.put("", kind, vec![], vec![("A", vec![ins[0]]), ("B", vec![ins[1]])], vec![("Y", y.to_vec())]);
        return;
    }
    if inputs > 2 && width == 1 && op != GateOp::Nand {
        let kind = if op == GateOp::Nor { "$logic_not" } else { reduce };
        d.unary("", kind, ins, y.to_vec());
        return;
    }
    if !op.inverts() {
        return d.chain("", word, &parts, y.to_vec());
    }
    let joined = d.fresh("joined", width);
    if width == 1 && inputs > 2 {
        d.unary("joined", reduce, ins, joined.clone());
    } else {
        d.chain("joined", word, &parts, joined.clone());
    }
    d.unary("", "$not", &joined, y.to_vec());
}

fn and_or(d: &mut Draw, width: usize, ins: &[Bit], select: &[Bit], y: &[Bit]) {
    if width == 1 {
        let gated = d.fresh("and", ins.len());
        d.binary("and", "$and", ins, select, gated.clone());
        d.unary("", "$reduce_or", &gated, y.to_vec());
        return;
    }
    let mut parts = Vec::new();
    for (i, (input, &line)) in ins.chunks(width).zip(select).enumerate() {
        let gated = d.fresh(&format!("and{i}"), width);
        d.binary(&format!("and{i}"), "$and", input, &repeat(line, width), gated.clone());
        parts.push(gated);
    }
    let parts: Vec<&[Bit]> = parts.iter().map(Vec::as_slice).collect();
    d.chain("", "$or", &parts, y.to_vec());
}

/// `(a & b) | ((a | b) & c)`, as its meaning is written.
fn majority(d: &mut Draw, width: usize, ins: &[Bits], y: &[Bit]) {
    let [both, some, with] = ["both", "some", "with"].map(|name| d.fresh(name, width));
    d.binary("both", "$and", &ins[0], &ins[1], both.clone());
    d.binary("some", "$or", &ins[0], &ins[1], some.clone());
    d.binary("with", "$and", &some, &ins[2], with.clone());
    d.binary("", "$or", &both, &with, y.to_vec());
}

fn mux(d: &mut Draw, width: u32, inputs: u32, ins: &[Bit], select: &[Bit], y: &[Bit]) {
    if inputs == 2 {
        let (a, b) = ins.split_at(width as usize);
        return d.mux("", a, b, select[0], y.to_vec());
    }
    let lines = select_width(inputs);
    let mut all = ins.to_vec();
    // what the select may say beyond the inputs
    all.resize((width << lines) as usize, Bit::Constant(Logic::X));
    let sizes = vec![("WIDTH", Setting::Number(width)), ("S_WIDTH", Setting::Number(lines))];
    d.put("", "$bmux", sizes, vec![("A", all), ("S", select.to_vec())], vec![("Y", y.to_vec())]);
}

fn full_adder(d: &mut Draw, ins: &[Bits], outs: &[Bits]) {
    let (half, both, carried) = (d.fresh("half", 1), d.fresh("both", 1), d.fresh("carried", 1));
    d.binary("half", "$xor", &ins[0], &ins[1], half.clone());
    d.binary("", "$xor", &half, &ins[2], outs[0].clone());
    d.binary("both", "$and", &ins[0], &ins[1], both.clone());
    d.binary("carried", "$and", &half, &ins[2], carried.clone());
    d.binary("co", "$or", &both, &carried, outs[1].clone());
}

/// With its carry, which Yosys has as one more bit of the result.
fn adder(d: &mut Draw, op: AddOp, ins: &[Bits], outs: &[Bits]) {
    let (a, b, carry) = (&ins[0], &ins[1], Draw::active(&ins[2]));
    if op == AddOp::AddSub {
        return add_sub(d, ins, outs);
    }
    let kind = if op == AddOp::Add { "$add" } else { "$sub" };
    let mut y = outs[0].clone();
    if d.is_used(&outs[1]) {
        y.extend(&outs[1]);
    }
    let Some(carry) = carry else { return d.binary("", kind, a, b, y) };
    let first = d.fresh("sum", y.len());
    d.binary("sum", kind, a, b, first.clone());
    // of the first result the highest bit is a borrow, by which the second goes on
    d.binary("", kind, &first, &[carry], y);
}

/// An adder that may invert what it adds. Of `$alu` not all that read such netlists know.
fn add_sub(d: &mut Draw, ins: &[Bits], outs: &[Bits]) {
    let sub = ins[3][0];
    let carry = match Draw::active(&ins[2]) {
        None => sub,
        Some(carry) => {
            let y = d.fresh("ci", 1);
            d.binary("ci", "$xor", &[carry], &[sub], y.clone());
            y[0]
        }
    };
    let mut y = outs[0].clone();
    let borrows = d.is_used(&outs[1]);
    let carried = if borrows { d.fresh("carry", 1) } else { Bits::new() };
    y.extend(&carried);
    add_inverted(d, "", &ins[0], &ins[1], (sub, carry), y);
    if borrows {
        d.binary("co", "$xor", &carried, &[sub], outs[1].clone());
    }
}

/// `a` plus `b`, inverted while `invert` is 1, plus a carry.
fn add_inverted(d: &mut Draw, part: &str, a: &[Bit], b: &[Bit], (invert, carry): (Bit, Bit), y: Bits) {
    let (inverted, first) = (d.fresh("b", b.len()), d.fresh("sum", y.len()));
    d.binary("b", "$xor", b, &repeat(invert, b.len()), inverted.clone());
    d.binary("sum", "$add", a, &inverted, first.clone());
    d.binary(part, "$add", &first, &[carry], y);
}

fn products(d: &mut Draw, width: u32, table: &[(u64, u64)], ins: &[Bits], outs: &[Bits]) {
    let words = width.div_ceil(64) as usize;
    let depth = table.len() / words;
    let mut bits = Value::from_u64(0, 2 * width * depth as u32);
    for (product, wants) in table.chunks(words).enumerate() {
        for i in 0..width {
            let (zero, one) = wants[i as usize / 64];
            for (k, want) in [zero, one].into_iter().enumerate() {
                if want >> (i % 64) & 1 == 1 {
                    bits.set_bit(2 * width * product as u32 + 2 * i + k as u32, Logic::One);
                }
            }
        }
    }
    let parameters = vec![
        ("WIDTH", Setting::Number(width)),
        ("DEPTH", Setting::Number(depth as u32)),
        ("TABLE", Setting::Value(bits)),
    ];
    plain(d, "$sop", parameters, &["A"], ins, &["Y"], outs);
}

/// `a` plus or minus a step, as `down` says.
pub fn stepped(d: &mut Draw, q: &[Bit], step: &Value, down: &[Bit]) -> Bits {
    let next = d.fresh("next", q.len());
    let step = constant(step);
    match down.first() {
        None | Some(&ZERO) => d.binary("next", "$add", q, &step, next.clone()),
        Some(&ONE) => d.binary("next", "$sub", q, &step, next.clone()),
        Some(&down) => add_inverted(d, "next", q, &step, (down, down), next.clone()),
    }
    next
}
