//! Multiplexers, look-up tables, tri-state buffers.

use super::{Fault, Lower, Site};
use crate::cell::CellKind;
use crate::netlist::Bus;

/// Inputs that a table may be asked for by.
const MOST_SELECT: u32 = 24;

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$mux" => |s| {
            let (a, b, select, y) = (s.input("A"), s.input("B"), s.bit("S")?, s.output("Y"));
            s.expect_width("A", a.width(), y.width())?;
            s.expect_width("B", b.width(), y.width())?;
            mux(s, Bus::concat([&a, &b]), select, y)
        },
        "$bmux" => |s| {
            // without a select it is a wire
            s.import.own_constants = s.written("S").is_empty();
            let (a, select, y) = (s.input("A"), s.input("S"), s.output("Y"));
            mux(s, a, select, y)
        },
        "$lut" => |s| {
            let (a, y) = (s.input("A"), s.one_bit());
            check_select(a.width())?;
            let table = s.sized("LUT", 1 << a.width());
            let table =
                if a.width() == 0 { s.import.builder.own_constant(&table) } else { s.import.builder.constant(&table) };
            mux(s, table, a, y)
        },
        "$pmux" => |s| {
            s.import.own_constants = s.written("S").is_empty();
            let (a, b, select, y) = (s.input("A"), s.input("B"), s.input("S"), s.output("Y"));
            let (width, inputs) = (y.width(), select.width());
            s.expect_width("A", a.width(), width)?;
            s.expect_width("B", b.width(), width.saturating_mul(inputs))?;
            match (width, inputs) {
                (0, _) => {}
                // nothing to choose from
                (_, 0) => s.wire(&y, &a),
                _ => s.cell(CellKind::OneHotMux { width, inputs }, vec![a, b, select], vec![y]),
            }
            Ok(())
        },
        "$bwmux" => |s| {
            let (a, b, select, y) = (s.input("A"), s.input("B"), s.input("S"), s.output("Y"));
            let width = y.width();
            for (port, found) in [("A", a.width()), ("B", b.width()), ("S", select.width())] {
                s.expect_width(port, found, width)?;
            }
            if width > 0 {
                s.cell(CellKind::BitMux { width }, vec![a, b, select], vec![y]);
            }
            Ok(())
        },
        "$demux" => |s| {
            s.import.own_constants = s.written("S").is_empty();
            let (a, select, y) = (s.input("A"), s.input("S"), s.output("Y"));
            check_select(select.width())?;
            s.expect_width("Y", y.width(), a.width().checked_shl(select.width()).unwrap_or(0))?;
            match (a.width(), select.width()) {
                (0, _) => {}
                (_, 0) => s.wire(&y, &a),
                (width, n) => s.cell(CellKind::Demux { width, select: n }, vec![a, select], vec![y]),
            }
            Ok(())
        },
        "$tribuf" => |s| {
            let (a, enable, y) = (s.input("A"), s.bit("EN")?, s.output("Y"));
            s.expect_width("A", a.width(), y.width())?;
            if y.width() > 0 {
                s.cell(CellKind::Tristate { width: y.width() }, vec![a, enable], vec![y]);
            }
            Ok(())
        },
        _ => return None,
    })
}

fn check_select(width: u32) -> Result<(), Fault> {
    if width <= MOST_SELECT {
        Ok(())
    } else {
        Err(format!("it chooses by {width} bits, of {MOST_SELECT} at most").into())
    }
}

/// One of the inputs that lie one after another in `ins`, as many as the select can mean.
pub(super) fn mux(s: &mut Site, ins: Bus, select: Bus, y: Bus) -> Result<(), Fault> {
    check_select(select.width())?;
    let (width, inputs) = (y.width(), 1 << select.width());
    let needed = u64::from(width) * u64::from(inputs);
    if needed != u64::from(ins.width()) {
        return Err(format!("it chooses {width} of {} bits by {}", ins.width(), select.width()).into());
    }
    match (width, inputs) {
        (0, _) => {}
        (_, 1) => s.wire(&y, &ins),
        _ => s.cell(CellKind::Mux { width, inputs }, vec![ins, select], vec![y]),
    }
    Ok(())
}
