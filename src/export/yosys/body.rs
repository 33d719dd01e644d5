//! The body of a module, from the hierarchy's wires, cells and instances to Yosys' nets and cells.

use super::cells;
use super::draw::Draw;
use super::model::{Bit, Bits, Cell, Module, Net, Port, constant};
use super::own::Owns;
use super::{Extra, flag};
use crate::netlist::hierarchy::{self, Hierarchy, Piece};
use crate::netlist::{Direction, Netlist};

/// The bits of a module's wires, by wire.
struct Wires {
    bits: Vec<Bits>,
    /// The first number that no bit has.
    free: u32,
}

impl Wires {
    fn new(module: &hierarchy::Module) -> Wires {
        let mut free = 2;
        let mut own = Vec::new();
        for wire in &module.wires {
            own.push(free);
            free += wire.width;
        }
        let mut wires = Wires { bits: Vec::new(), free };
        for wire in &module.wires {
            // an alias is made of bits that other wires stand for
            let mut bits = Bits::new();
            for piece in &wire.bits {
                match piece {
                    Piece::Wire { wire, lo, width } => bits.extend((*lo..lo + width).map(|i| Bit::Net(own[*wire] + i))),
                    Piece::Constant(value) => bits.extend(constant(value)),
                    Piece::Open(width) => bits.extend(wires.fresh(*width)),
                }
            }
            wires.bits.push(bits);
        }
        wires
    }

    fn fresh(&mut self, width: u32) -> Bits {
        self.free += width;
        (self.free - width..self.free).map(Bit::Net).collect()
    }

    fn of(&mut self, pieces: &[Piece]) -> Bits {
        let mut bits = Bits::new();
        for piece in pieces {
            match piece {
                Piece::Wire { wire, lo, width } => {
                    let shown = &self.bits[*wire][*lo as usize..(lo + width) as usize];
                    bits.extend(shown.to_vec());
                }
                Piece::Constant(value) => bits.extend(constant(value)),
                Piece::Open(width) => bits.extend(self.fresh(*width)),
            }
        }
        bits
    }
}

/// The path of a name that blocks are in, as Yosys keeps those that it flattened: with spaces.
fn hdl_name(module: &hierarchy::Module, block: usize, name: &str) -> String {
    let plain = |text: &str| text.chars().map(|c| if c.is_whitespace() { '_' } else { c }).collect::<String>();
    match module.blocks[block].parent {
        None => plain(name),
        Some(parent) => format!("{} {}", hdl_name(module, parent, &module.blocks[block].name), plain(name)),
    }
}

/// Draws a module.
pub fn module(netlist: &Netlist, hierarchy: &Hierarchy, at: usize, owns: &mut Owns, extra: &Extra<'_>) -> Module {
    let of = &hierarchy.modules()[at];
    let mut wires = Wires::new(of);
    let pins: Vec<(Vec<Bits>, Vec<Bits>)> = of
        .cells
        .iter()
        .map(|cell| {
            let mut all = |pins: &[Vec<Piece>]| pins.iter().map(|p| wires.of(p)).collect();
            (all(&cell.inputs), all(&cell.outputs))
        })
        .collect();
    let bound: Vec<Vec<Bits>> = of.instances.iter().map(|i| i.ports.iter().map(|p| wires.of(p)).collect()).collect();

    let mut draw = Draw::new(Module::new(&of.name, wires.free), owns);
    draw.count(wires.free, &wires.bits, &pins, &bound);
    for (wire, bits) in of.wires.iter().zip(&wires.bits) {
        let name = draw.module.unique(&format!("{}{}", of.prefix(wire.block), wire.name));
        let in_block = of.blocks[wire.block].parent.is_some();
        let attributes = if in_block { vec![("hdlname", hdl_name(of, wire.block, &wire.name))] } else { vec![] };
        if let Some(direction) = wire.port {
            draw.module.ports.push(Port { name: name.clone(), direction, bits: bits.clone(), signed: wire.signed });
        }
        let values = wire.signal.and_then(|signal| netlist.signal(signal).values.clone());
        let net = Net { name, bits: bits.clone(), hidden: wire.hidden, signed: wire.signed, values, attributes };
        draw.module.nets.push(net);
    }
    for (instance, bits) in of.instances.iter().zip(bound) {
        let inner = &hierarchy.modules()[instance.module];
        let plain = format!("{}{}", of.prefix(instance.block), instance.name);
        let taken = draw.module.names.contains(&plain);
        let name = draw.module.unique(&if taken { format!("{plain}${}", inner.name) } else { plain.clone() });
        let renamed = name != plain || of.blocks[instance.block].parent.is_some();
        let attributes = if renamed { vec![("hdlname", hdl_name(of, instance.block, &instance.name))] } else { vec![] };
        let ports = inner.ports().iter().zip(bits);
        let connections = ports.map(|(p, bits)| (p.name.clone(), p.port.unwrap_or(Direction::Inout), bits)).collect();
        let kind = inner.name.clone();
        draw.module.cells.push(Cell { name, kind, hidden: false, attributes, parameters: vec![], connections });
    }
    for (cell, (inputs, outputs)) in of.cells.iter().zip(pins) {
        let drawn = netlist.cell(cell.id);
        draw.name = format!("{}{}", of.prefix(cell.block), drawn.name);
        draw.source = extra.source.and_then(|source| source(cell.id));
        cells::draw(&mut draw, &drawn.kind, drawn.element, &inputs, &outputs);
    }
    let mut module = draw.finish();
    if at == 0 {
        module.attributes.push(("top", flag()));
    }
    module
}
