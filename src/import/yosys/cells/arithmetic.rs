//! Adders, multipliers, dividers, shifters.

use super::{Fault, Lower, Site};
use crate::cell::{AddOp, Alu, CellKind, DivideOp, ShiftOp};
use crate::netlist::Bus;
use crate::{Logic, Value};

/// The widest power: its time grows with the third power of that.
const MOST_POWER: u32 = 4096;

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$neg" => |s| {
            let (a, y) = (s.operand("A"), s.output("Y"));
            let a = s.extend(&a, s.flag("A_SIGNED"), a.width().max(y.width()));
            let zero = s.constant(Logic::Zero, a.width());
            add(s, AddOp::Sub, zero, a)
        },
        "$add" => |s| sum(s, AddOp::Add),
        "$sub" => |s| sum(s, AddOp::Sub),
        "$mul" => multiply,
        "$div" => |s| divide(s, DivideOp::Quotient),
        "$mod" => |s| divide(s, DivideOp::Remainder),
        "$divfloor" => |s| divide(s, DivideOp::Floor),
        "$modfloor" => |s| divide(s, DivideOp::Modulo),
        "$pow" => |s| {
            let (a, b) = (s.operand("A"), s.operand("B"));
            let (a_signed, b_signed) = (s.flag("A_SIGNED"), s.flag("B_SIGNED"));
            let width = a.width().max(s.written("Y").len() as u32);
            if width > MOST_POWER {
                return Err(format!("it is {width} bits wide, of {MOST_POWER} at most").into());
            }
            let (a, b_width, y) = (s.extend(&a, a_signed, width), b.width(), s.result(width));
            s.cell(CellKind::Power { width, b_width, a_signed, b_signed }, vec![a, b], vec![y]);
            Ok(())
        },
        "$shl" | "$sshl" => |s| shift(s, ShiftOp::Left),
        "$shr" => |s| shift(s, ShiftOp::Right),
        "$sshr" => |s| shift(s, if s.flag("A_SIGNED") { ShiftOp::RightSigned } else { ShiftOp::Right }),
        "$shift" => |s| shift(s, if s.flag("B_SIGNED") { ShiftOp::Both } else { ShiftOp::Right }),
        "$shiftx" => |s| shift(s, if s.flag("B_SIGNED") { ShiftOp::PartSigned } else { ShiftOp::Part }),
        "$fa" => |s| {
            let (a, b, c, x, y) = (s.input("A"), s.input("B"), s.input("C"), s.output("X"), s.output("Y"));
            let width = a.width();
            for (port, found) in [("B", b.width()), ("C", c.width()), ("X", x.width()), ("Y", y.width())] {
                s.expect_width(port, found, width)?;
            }
            if width > 0 {
                s.cell(CellKind::CarrySave { width }, vec![a, b, c], vec![x, y]);
            }
            Ok(())
        },
        "$lcu" => |s| {
            let (p, g, ci, co) = (s.input("P"), s.input("G"), s.bit("CI")?, s.output("CO"));
            let width = p.width();
            s.expect_width("G", g.width(), width)?;
            s.expect_width("CO", co.width(), width)?;
            if width > 0 {
                s.cell(CellKind::Carry { width }, vec![p, g, ci], vec![co]);
            }
            Ok(())
        },
        "$alu" => |s| {
            let (a, b, ci, bi) = (s.operand("A"), s.operand("B"), s.bit("CI")?, s.bit("BI")?);
            let (x, y, co) = (s.output("X"), s.output("Y"), s.output("CO"));
            let width = [&x, &y, &co].iter().map(|b| b.width()).max().unwrap_or(0);
            if width == 0 {
                return Ok(());
            }
            let full = |s: &mut Site, port, bus: Bus| match bus.width() {
                0 => Ok(s.spare(width)),
                n => s.expect_width(port, n, width).map(|()| bus),
            };
            let outs = vec![full(s, "X", x)?, full(s, "Y", y)?, full(s, "CO", co)?];
            let signed = s.flag("A_SIGNED") && s.flag("B_SIGNED");
            let alu = Alu { a_width: a.width(), b_width: b.width(), width, signed };
            s.cell(CellKind::Alu(alu), vec![a, b, ci, bi], outs);
            Ok(())
        },
        "$macc" => macc,
        "$macc_v2" => macc_v2,
        _ => return None,
    })
}

/// `a` and `b`, of one width, of which the port may take less.
fn add(s: &mut Site, op: AddOp, a: Bus, b: Bus) -> Result<(), Fault> {
    let width = a.width();
    let y = s.result(width);
    s.cell(CellKind::Adder { op, width }, vec![a, b], vec![y]);
    Ok(())
}

fn sum(s: &mut Site, op: AddOp) -> Result<(), Fault> {
    let (a, b, _) = s.operands(s.written("Y").len() as u32);
    add(s, op, a, b)
}

fn multiply(s: &mut Site) -> Result<(), Fault> {
    let (a, b, y) = (s.operand("A"), s.operand("B"), s.output("Y"));
    let signed = s.flag("A_SIGNED") && s.flag("B_SIGNED");
    let (a_width, b_width) = (a.width(), b.width());
    let kind = CellKind::Multiply { a_width, b_width, signed };
    let width = a_width + b_width;
    if y.width() <= width {
        let mut full = y;
        let more = width - full.width();
        full.append(&s.spare(more));
        s.cell(kind, vec![a, b], vec![full]);
        return Ok(());
    }
    // the product has no more bits; those above are its sign or 0, unless it is unknown
    let product = y.slice(0, width);
    s.cell(kind, vec![a, b], vec![product.clone()]);
    let high = y.slice(width, y.width() - width);
    let top = product.bit(width - 1);
    if signed {
        let fill = Bus::concat((0..high.width()).map(|_| &top));
        s.wire(&high, &fill);
    } else {
        // 0, or x where the product is: top & 0 would be 0, top ^ top is what is wanted
        let fill = s.gate("high", crate::cell::GateOp::Xor, 1, &[&top, &top]);
        s.wire(&high, &Bus::concat((0..high.width()).map(|_| &fill)));
    }
    Ok(())
}

fn divide(s: &mut Site, op: DivideOp) -> Result<(), Fault> {
    let (a, b, signed) = s.operands(s.written("Y").len() as u32);
    let y = s.result(a.width());
    s.cell(CellKind::Divide { op, width: a.width(), signed }, vec![a, b], vec![y]);
    Ok(())
}

fn shift(s: &mut Site, op: ShiftOp) -> Result<(), Fault> {
    let (a, b, y) = (s.operand("A"), s.operand("B"), s.output("Y"));
    let width = y.width();
    if width == 0 {
        return Ok(());
    }
    let part = matches!(op, ShiftOp::Part | ShiftOp::PartSigned);
    let a = if part { a } else { s.extend(&a, s.flag("A_SIGNED"), a.width().max(width)) };
    let kind = CellKind::Shift { op, a_width: a.width(), b_width: b.width(), width };
    s.cell(kind, vec![a, b], vec![y]);
    Ok(())
}

/// A number to add up.
struct Term {
    a: Bus,
    /// What to multiply it by.
    b: Option<Bus>,
    /// Whether each is in two's complement.
    signed: (bool, bool),
    subtract: bool,
}

/// Adds terms up, one adder each.
fn accumulate(s: &mut Site, terms: Vec<Term>) -> Result<(), Fault> {
    let y = s.output("Y");
    let width = y.width();
    if width == 0 {
        return Ok(());
    }
    let mut sum = s.constant(Logic::Zero, width);
    let last = terms.len().saturating_sub(1);
    if terms.is_empty() {
        s.tie(&y, &Value::from_u64(0, width));
    }
    for (i, term) in terms.into_iter().enumerate() {
        let mut addend = s.extend(&term.a, term.signed.0, width);
        if let Some(b) = term.b {
            let b = s.extend(&b, term.signed.1, width);
            let product = s.spare(2 * width);
            let kind = CellKind::Multiply { a_width: width, b_width: width, signed: false };
            s.helper(&format!("product{i}"), kind, vec![addend, b], vec![product.clone()]);
            addend = product.slice(0, width);
        }
        let next = if i == last { y.clone() } else { s.spare(width) };
        let op = if term.subtract { AddOp::Sub } else { AddOp::Add };
        let kind = CellKind::Adder { op, width };
        if i == last {
            s.cell(kind, vec![sum, addend], vec![next.clone()]);
        } else {
            s.helper(&format!("sum{i}"), kind, vec![sum, addend], vec![next.clone()]);
        }
        sum = next;
    }
    Ok(())
}

/// Reads numbers from a parameter, the least significant first.
struct Reader {
    bits: Value,
    at: u32,
}

impl Reader {
    fn take(&mut self, width: u32) -> u32 {
        let bit = |i: u32| u32::from(i < self.bits.width() && self.bits.bit(i) == Logic::One);
        let number = (0..width.min(32)).fold(0, |n, k| n | bit(self.at + k) << k);
        self.at = self.at.saturating_add(width);
        number
    }
}

/// So many bits of a bus from `at` on.
fn piece(bus: &Bus, at: &mut u32, width: u32, port: &str) -> Result<Bus, Fault> {
    let end = at.checked_add(width).filter(|&end| end <= bus.width());
    let end = end.ok_or_else(|| Fault::from(format!("`{port}` has fewer bits than its parameters say")))?;
    let piece = bus.slice(*at, width);
    *at = end;
    Ok(piece)
}

fn macc(s: &mut Site) -> Result<(), Fault> {
    let (a, b) = (s.input("A"), s.input("B"));
    let width = s.number("CONFIG_WIDTH")?.min(s.value("CONFIG").map_or(0, |c| c.width()));
    let mut config = Reader { bits: s.sized("CONFIG", width), at: 0 };
    let size = config.take(4).max(1);
    let count = width.saturating_sub(4) / (2 + 2 * size);
    let (mut terms, mut at) = (Vec::new(), 0);
    for _ in 0..count {
        let (signed, subtract) = (config.take(1) == 1, config.take(1) == 1);
        let (a_width, b_width) = (config.take(size), config.take(size));
        let first = piece(&a, &mut at, a_width, "A")?;
        let second = piece(&a, &mut at, b_width, "A")?;
        let b = (b_width > 0).then_some(second);
        terms.push(Term { a: first, b, signed: (signed, signed), subtract });
    }
    let bits = (0..b.width()).map(|i| Term { a: b.bit(i), b: None, signed: (false, false), subtract: false });
    terms.extend(bits);
    accumulate(s, terms)
}

fn macc_v2(s: &mut Site) -> Result<(), Fault> {
    let (a, b, c) = (s.input("A"), s.input("B"), s.input("C"));
    let reader = |s: &Site, name: &str| Reader { bits: s.value(name).unwrap_or_else(|| Value::from_u64(0, 1)), at: 0 };
    let [mut a_widths, mut b_widths, mut c_widths] = ["A_WIDTHS", "B_WIDTHS", "C_WIDTHS"].map(|n| reader(s, n));
    let [mut a_signs, mut b_signs, mut c_signs] = ["A_SIGNED", "B_SIGNED", "C_SIGNED"].map(|n| reader(s, n));
    let [mut product_signs, mut addend_signs] = ["PRODUCT_NEGATED", "ADDEND_NEGATED"].map(|n| reader(s, n));
    let (mut terms, mut at) = (Vec::new(), [0; 3]);
    for _ in 0..s.number("NPRODUCTS")?.min(a.width().max(b.width())) {
        let first = piece(&a, &mut at[0], a_widths.take(16), "A")?;
        let second = piece(&b, &mut at[1], b_widths.take(16), "B")?;
        let signed = (a_signs.take(1) == 1, b_signs.take(1) == 1);
        terms.push(Term { a: first, b: Some(second), signed, subtract: product_signs.take(1) == 1 });
    }
    for _ in 0..s.number("NADDENDS")?.min(c.width()) {
        let first = piece(&c, &mut at[2], c_widths.take(16), "C")?;
        let signed = c_signs.take(1) == 1;
        terms.push(Term { a: first, b: None, signed: (signed, signed), subtract: addend_signs.take(1) == 1 });
    }
    accumulate(s, terms)
}
