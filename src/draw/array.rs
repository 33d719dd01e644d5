//! Cells of one kind side by side, a bit each (`memory[0]`, `memory[1]`, …), are drawn as one cell of as many bits: what
//! they all read alike goes in once, the rest as a bus.

use std::collections::BTreeMap;

use super::pins::{self, Drawn};
use crate::netlist::Netlist;
use crate::netlist::hierarchy::{Cell, Module, Piece};

/// So many cells make it worth while.
const FEW: usize = 3;

/// The cells of a module, those that make an array as one.
pub(super) fn cells(netlist: &Netlist, module: &Module) -> Vec<Drawn> {
    let mut groups: BTreeMap<(usize, &str), Vec<(u32, usize)>> = BTreeMap::new();
    for (c, cell) in module.cells.iter().enumerate() {
        if let Some((base, index)) = indexed(&netlist.cell(cell.id).name) {
            groups.entry((cell.block, base)).or_default().push((index, c));
        }
    }
    let mut first: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut within = vec![false; module.cells.len()];
    for mut members in groups.into_values() {
        members.sort_unstable();
        let in_a_row = members.iter().enumerate().all(|(i, m)| m.0 as usize == i);
        let members: Vec<usize> = members.into_iter().map(|m| m.1).collect();
        if members.len() >= FEW && in_a_row && alike(netlist, module, &members) {
            members.iter().for_each(|&m| within[m] = true);
            first.insert(members.iter().copied().min().unwrap_or_default(), members);
        }
    }
    let name = |cell: &Cell| format!("{}{}", module.prefix(cell.block), netlist.cell(cell.id).name);
    let mut drawn = Vec::new();
    for (c, cell) in module.cells.iter().enumerate() {
        let array = first.get(&c).and_then(|members| {
            let all = members.iter().map(|&m| pins::cell(netlist, &module.cells[m], name(&module.cells[m])));
            together(all.collect())
        });
        match (array, first.get(&c)) {
            (Some(array), _) => drawn.push(array),
            (None, Some(members)) => {
                let each = members.iter().map(|&m| &module.cells[m]);
                drawn.extend(each.map(|cell| pins::cell(netlist, cell, name(cell))));
            }
            (None, None) if within[c] => {}
            (None, None) => drawn.push(pins::cell(netlist, cell, name(cell))),
        }
    }
    drawn
}

/// A name with a number: `memory[3]`.
fn indexed(name: &str) -> Option<(&str, u32)> {
    let (base, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((base, index.parse().ok()?))
}

/// Whether cells are of one kind and none reads what another drives.
fn alike(netlist: &Netlist, module: &Module, members: &[usize]) -> bool {
    let kind = |m: usize| &netlist.cell(module.cells[m].id).kind;
    let wires = |pins: &[Vec<Piece>]| -> Vec<(usize, u32, u32)> {
        let pieces = pins.iter().flatten().filter_map(|p| match *p {
            Piece::Wire { wire, lo, width } => Some((wire, lo, lo + width)),
            _ => None,
        });
        pieces.collect()
    };
    let driven: Vec<_> = members.iter().flat_map(|&m| wires(&module.cells[m].outputs)).collect();
    members.iter().all(|&m| {
        let reads = wires(&module.cells[m].inputs);
        let own = reads.iter().any(|r| driven.iter().any(|d| d.0 == r.0 && d.1 < r.2 && r.1 < d.2));
        // what it holds at the start is no matter of the drawing
        let same = std::mem::discriminant(kind(m)) == std::mem::discriminant(kind(members[0]))
            && kind(m).edge() == kind(members[0]).edge()
            && kind(m).output_width(0) == 1;
        same && !own && netlist.cell(module.cells[m].id).element == netlist.cell(module.cells[members[0]].id).element
    })
}

/// One node for several, if their pins are the same.
fn together(all: Vec<Drawn>) -> Option<Drawn> {
    let count = all.len();
    let mut each = Vec::new();
    let mut one = None;
    for (node, ends) in all {
        let pins: Vec<String> = node.pins.iter().map(|p| p.name.clone()).collect();
        each.push((pins, node.shape, node.inverts, ends));
        one.get_or_insert(node);
    }
    let mut node = one?;
    if each.iter().any(|e| (&e.0, e.1, e.2) != (&each[0].0, each[0].1, each[0].2)) {
        return None;
    }
    let mut ends = Vec::new();
    for (p, pin) in node.pins.iter().enumerate() {
        let alike = each.iter().all(|e| e.3[p] == each[0].3[p]);
        if alike && pin.reads {
            ends.push(each[0].3[p].clone());
            continue;
        }
        // a clock of several bits is no clock of one symbol
        if pin.clock.is_some() {
            return None;
        }
        let mut pieces = Vec::new();
        each.iter().flat_map(|e| &e.3[p]).for_each(|piece| push(&mut pieces, piece.clone()));
        ends.push(pieces);
    }
    let base = node.name.rsplit_once('[').map_or("", |n| n.0).to_owned();
    node.title = format!("{base}[{}:0]: {count} of{}", count - 1, node.title.split_once(':').map_or("", |t| t.1));
    node.name = format!("{base}[{}:0]", count - 1);
    Some((node, ends))
}

/// Adds a piece above others.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match (pieces.last_mut(), &piece) {
        (Some(Piece::Wire { wire, lo, width }), Piece::Wire { wire: w, lo: at, width: more })
            if wire == w && *lo + *width == *at =>
        {
            *width += more;
        }
        (Some(Piece::Open(width)), Piece::Open(more)) => *width += more,
        (Some(Piece::Constant(value)), Piece::Constant(more)) => {
            let mut both = crate::Value::unknown(value.width() + more.width());
            (0..value.width()).for_each(|i| both.set_bit(i, value.bit(i)));
            (0..more.width()).for_each(|i| both.set_bit(value.width() + i, more.bit(i)));
            *value = both;
        }
        _ => pieces.push(piece),
    }
}
