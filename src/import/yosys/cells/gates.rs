//! The combinational gates of `simcells.v`, one bit each.

use super::select::mux;
use super::{Fault, Lower, Site};
use crate::cell::{CellKind, GateOp};
use crate::netlist::Bus;

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$_BUF_" => |s| {
            s.import.own_constants = true;
            let (a, y) = (s.bit("A")?, s.one_bit());
            s.wire(&y, &a);
            Ok(())
        },
        "$_NOT_" => |s| gate(s, GateOp::Not, &["A"]),
        "$_AND_" => |s| gate(s, GateOp::And, &["A", "B"]),
        "$_NAND_" => |s| gate(s, GateOp::Nand, &["A", "B"]),
        "$_OR_" => |s| gate(s, GateOp::Or, &["A", "B"]),
        "$_NOR_" => |s| gate(s, GateOp::Nor, &["A", "B"]),
        "$_XOR_" => |s| gate(s, GateOp::Xor, &["A", "B"]),
        "$_XNOR_" => |s| gate(s, GateOp::Xnor, &["A", "B"]),
        "$_ANDNOT_" => |s| with_inverted(s, GateOp::And),
        "$_ORNOT_" => |s| with_inverted(s, GateOp::Or),
        "$_MUX_" => |s| choose(s, &["A", "B"], &["S"]),
        "$_NMUX_" => |s| {
            let (ins, select) = (inputs(s, &["A", "B"])?, s.bit("S")?);
            let chosen = s.spare(1);
            s.helper("mux", CellKind::Mux { width: 1, inputs: 2 }, vec![ins, select], vec![chosen.clone()]);
            finish(s, GateOp::Not, &[&chosen])
        },
        "$_MUX4_" => |s| choose(s, &["A", "B", "C", "D"], &["S", "T"]),
        "$_MUX8_" => |s| choose(s, &["A", "B", "C", "D", "E", "F", "G", "H"], &["S", "T", "U"]),
        "$_MUX16_" => |s| {
            let ports = ["A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "K", "L", "M", "N", "O", "P"];
            choose(s, &ports, &["S", "T", "U", "V"])
        },
        "$_AOI3_" => |s| of_two_levels(s, GateOp::And, GateOp::Nor, false),
        "$_OAI3_" => |s| of_two_levels(s, GateOp::Or, GateOp::Nand, false),
        "$_AOI4_" => |s| of_two_levels(s, GateOp::And, GateOp::Nor, true),
        "$_OAI4_" => |s| of_two_levels(s, GateOp::Or, GateOp::Nand, true),
        "$_TBUF_" => |s| {
            let (a, enable, y) = (s.bit("A")?, s.bit("E")?, s.one_bit());
            s.cell(CellKind::Tristate { width: 1 }, vec![a, enable], vec![y]);
            Ok(())
        },
        _ => return None,
    })
}

fn inputs(s: &mut Site, ports: &[&str]) -> Result<Bus, Fault> {
    let mut all = Bus::default();
    for port in ports {
        all.append(&s.bit(port)?);
    }
    Ok(all)
}

fn finish(s: &mut Site, op: GateOp, ins: &[&Bus]) -> Result<(), Fault> {
    let y = s.one_bit();
    let kind = CellKind::Gate { op, width: 1, inputs: ins.len() as u32 };
    s.cell(kind, vec![Bus::concat(ins.iter().copied())], vec![y]);
    Ok(())
}

fn gate(s: &mut Site, op: GateOp, ports: &[&str]) -> Result<(), Fault> {
    let (ins, y) = (inputs(s, ports)?, s.one_bit());
    s.cell(CellKind::Gate { op, width: 1, inputs: ports.len() as u32 }, vec![ins], vec![y]);
    Ok(())
}

fn with_inverted(s: &mut Site, op: GateOp) -> Result<(), Fault> {
    let (a, b) = (s.bit("A")?, s.bit("B")?);
    let b = s.invert(&b);
    finish(s, op, &[&a, &b])
}

fn choose(s: &mut Site, ports: &[&str], selects: &[&str]) -> Result<(), Fault> {
    let (ins, select, y) = (inputs(s, ports)?, inputs(s, selects)?, s.one_bit());
    mux(s, ins, select, y)
}

fn of_two_levels(s: &mut Site, first: GateOp, last: GateOp, four: bool) -> Result<(), Fault> {
    let (a, b, c) = (s.bit("A")?, s.bit("B")?, s.bit("C")?);
    let left = s.gate("AB", first, 1, &[&a, &b]);
    let right = if four {
        let d = s.bit("D")?;
        s.gate("CD", first, 1, &[&c, &d])
    } else {
        c
    };
    finish(s, last, &[&left, &right])
}
