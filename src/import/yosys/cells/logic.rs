//! Bitwise and logical cells, reductions, comparisons, wiring.

use super::{Fault, Lower, Site, own};
use crate::Value;
use crate::cell::{CellKind, CompareOp, GateOp};
use crate::netlist::Bus;

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$not" => |s| {
            let (a, y) = (s.operand("A"), s.output("Y"));
            let a = s.extend(&a, s.flag("A_SIGNED"), y.width());
            gate(s, GateOp::Not, &[&a], y)
        },
        "$pos" | "$buf" | "$barrier" => |s| {
            let gated = s.is_own(own::BUFFER);
            s.import.own_constants = !gated;
            let (a, y) = (s.operand("A"), s.output("Y"));
            let a = s.extend(&a, s.flag("A_SIGNED"), y.width());
            if gated {
                return gate(s, GateOp::Buf, &[&a], y);
            }
            s.wire(&y, &a);
            Ok(())
        },
        "$slice" => |s| {
            s.import.own_constants = true;
            let (a, y, offset) = (s.input("A"), s.output("Y"), s.number("OFFSET")?);
            if offset.checked_add(y.width()).is_none_or(|end| end > a.width()) {
                return Err(format!("bits {offset} and on of {} are no {}", a.width(), y.width()).into());
            }
            s.wire(&y, &a.slice(offset, y.width()));
            Ok(())
        },
        "$concat" => |s| {
            s.import.own_constants = true;
            let (a, b, y) = (s.input("A"), s.input("B"), s.output("Y"));
            s.expect_width("Y", y.width(), a.width() + b.width())?;
            s.wire(&y, &Bus::concat([&a, &b]));
            Ok(())
        },
        "$and" => |s| bitwise(s, GateOp::And),
        "$or" => |s| bitwise(s, GateOp::Or),
        "$xor" => |s| bitwise(s, GateOp::Xor),
        "$xnor" => |s| bitwise(s, GateOp::Xnor),
        "$reduce_and" => |s| reduce(s, GateOp::And),
        "$reduce_or" | "$reduce_bool" => |s| reduce(s, GateOp::Or),
        "$reduce_xor" => |s| reduce(s, GateOp::Xor),
        "$reduce_xnor" => |s| reduce(s, GateOp::Xnor),
        "$logic_not" => |s| reduce(s, GateOp::Nor),
        "$logic_and" => |s| logic(s, GateOp::And),
        "$logic_or" => |s| logic(s, GateOp::Or),
        "$eq" => |s| compare(s, CompareOp::Eq),
        "$ne" => |s| compare(s, CompareOp::Ne),
        "$eqx" => |s| compare(s, CompareOp::Same),
        "$nex" => |s| compare(s, CompareOp::Differs),
        "$lt" => |s| compare(s, CompareOp::Lt),
        "$le" => |s| compare(s, CompareOp::Le),
        "$gt" => |s| compare(s, CompareOp::Gt),
        "$ge" => |s| compare(s, CompareOp::Ge),
        "$bweqx" => |s| {
            let (a, b, y) = (s.input("A"), s.input("B"), s.output("Y"));
            s.expect_width("B", b.width(), a.width())?;
            s.expect_width("Y", y.width(), a.width())?;
            if y.width() > 0 {
                s.cell(CellKind::BitSame { width: y.width() }, vec![a, b], vec![y]);
            }
            Ok(())
        },
        "$sop" => sop,
        _ => return None,
    })
}

fn gate(s: &mut Site, op: GateOp, inputs: &[&Bus], y: Bus) -> Result<(), Fault> {
    if y.width() > 0 {
        let kind = CellKind::Gate { op, width: y.width(), inputs: inputs.len() as u32 };
        s.cell(kind, vec![Bus::concat(inputs.iter().copied())], vec![y]);
    }
    Ok(())
}

fn bitwise(s: &mut Site, op: GateOp) -> Result<(), Fault> {
    let y = s.output("Y");
    let (a, b, _) = s.operands(y.width());
    gate(s, op, &[&a.slice(0, y.width()), &b.slice(0, y.width())], y)
}

/// All bits joined into one, by a gate; of one bit there is nothing to join.
fn reduction(op: GateOp, inputs: u32) -> CellKind {
    let op = match op {
        _ if inputs > 1 => op,
        op if op.inverts() => GateOp::Not,
        _ => GateOp::Buf,
    };
    CellKind::Gate { op, width: 1, inputs }
}

fn reduce(s: &mut Site, op: GateOp) -> Result<(), Fault> {
    let (a, y) = (s.operand("A"), s.one_bit());
    s.cell(reduction(op, a.width()), vec![a], vec![y]);
    Ok(())
}

fn logic(s: &mut Site, op: GateOp) -> Result<(), Fault> {
    let (a, b, y) = (s.operand("A"), s.operand("B"), s.one_bit());
    let truth = |s: &mut Site, part, bus: Bus| {
        if bus.width() == 1 {
            return bus;
        }
        let any = s.spare(1);
        s.helper(part, reduction(GateOp::Or, bus.width()), vec![bus], vec![any.clone()]);
        any
    };
    let (a, b) = (truth(s, "A", a), truth(s, "B", b));
    gate(s, op, &[&a, &b], y)
}

fn compare(s: &mut Site, op: CompareOp) -> Result<(), Fault> {
    let (a, b, signed) = s.operands(1);
    let y = s.one_bit();
    s.cell(CellKind::Compare { op, width: a.width(), signed }, vec![a, b], vec![y]);
    Ok(())
}

/// A sum of products of inputs and inverted inputs.
fn sop(s: &mut Site) -> Result<(), Fault> {
    let (a, y) = (s.input("A"), s.one_bit());
    let depth = s.number("DEPTH")?;
    if a.width() == 0 || depth == 0 {
        // an empty product is 1, an empty sum 0
        s.tie(&y, &Value::from_u64(u64::from(depth > 0), 1));
        return Ok(());
    }
    let bits = u64::from(a.width()) * 2 * u64::from(depth);
    let have = s.value("TABLE").map_or(0, |t| t.width());
    if bits > u64::from(have).max(1 << 16) {
        return Err(format!("its parameter `TABLE` has {have} of {bits} bits").into());
    }
    let table = s.sized("TABLE", bits as u32);
    let wants = |product: u32, word: u32, one: u32| {
        let inputs = (word * 64..a.width().min(word * 64 + 64)).enumerate();
        inputs.fold(0, |all, (k, i)| {
            let set = table.bit(2 * a.width() * product + 2 * i + one) == crate::Logic::One;
            all | u64::from(set) << k
        })
    };
    let words = a.width().div_ceil(64);
    let products = (0..depth).flat_map(|p| (0..words).map(move |w| (p, w)));
    let table = products.map(|(p, w)| (wants(p, w, 0), wants(p, w, 1))).collect();
    s.cell(CellKind::Products { width: a.width(), table }, vec![a], vec![y]);
    Ok(())
}
