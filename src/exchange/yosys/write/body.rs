//! The body of a module, from the netlist's cells and names to Yosys' cells and nets.

use std::collections::HashMap;

use super::cells;
use super::draw::Draw;
use super::model::{Bit, Bits, Module, Net, Port};
use super::own::Owns;
use crate::cell::CellKind;
use crate::netlist::Direction;

/// A name within a module: the blocks around it, then its own.
pub type Path = Vec<String>;

/// A module as the netlist has it. Bits have numbers from 2 on.
pub struct Body<'n> {
    pub name: String,
    pub ports: Vec<BodyPort>,
    pub nets: Vec<BodyNet>,
    pub cells: Vec<BodyCell<'n>>,
    pub instances: Vec<Instance>,
    /// One more than the highest number of a bit.
    pub end: u32,
}

/// A port.
pub struct BodyPort {
    pub name: String,
    pub direction: Direction,
    pub bits: Bits,
    pub signed: bool,
}

/// A named vector of bits that is no port.
pub struct BodyNet {
    pub path: Path,
    pub bits: Bits,
    pub hidden: bool,
    pub signed: bool,
}

/// A cell; pins that are not connected have no bits.
pub struct BodyCell<'n> {
    pub path: Path,
    pub kind: &'n CellKind,
    pub element: &'static str,
    pub inputs: Vec<Bits>,
    pub outputs: Vec<Bits>,
    pub source: Option<String>,
}

/// An instance of another module.
pub struct Instance {
    pub path: Path,
    pub module: String,
    pub ports: Vec<(String, Direction, Bits)>,
}

fn joined(path: &[String]) -> String {
    path.join(".")
}

/// The path of a name that blocks are in, as Yosys keeps those that it flattened.
fn hdl_name(path: &[String]) -> String {
    let parts: Vec<String> =
        path.iter().map(|p| p.chars().map(|c| if c.is_whitespace() { '_' } else { c }).collect()).collect();
    parts.join(" ")
}

/// How often each bit is read or shown.
fn uses(body: &Body<'_>) -> Vec<u32> {
    let mut uses = vec![0u32; body.end as usize];
    let shown = body.ports.iter().map(|p| &p.bits).chain(body.nets.iter().map(|n| &n.bits));
    let read = body.cells.iter().flat_map(|c| &c.inputs);
    let bound = body.instances.iter().flat_map(|i| i.ports.iter().map(|p| &p.2));
    for bit in shown.chain(read).chain(bound).flatten() {
        if let Bit::Net(n) = bit {
            uses[*n as usize] += 1;
        }
    }
    uses
}

/// Puts the cells that drive a bus right onto it. Those are left that something reads by itself, and states that begin
/// with a value, which Yosys has with the net: they drive it through a wire of their own.
fn share(body: &mut Body<'_>, draw: &mut Draw<'_>) {
    if !body.cells.iter().any(|c| matches!(c.kind, CellKind::Resolve { .. })) {
        return;
    }
    let mut states = vec![false; body.end as usize];
    for cell in body.cells.iter().filter(|c| c.kind.init().is_some() || matches!(c.kind, CellKind::Delay { .. })) {
        for bit in cell.outputs.iter().flatten() {
            if let Bit::Net(n) = bit {
                states[*n as usize] = true;
            }
        }
    }
    let mut onto: HashMap<u32, Bit> = HashMap::new();
    let mut wires: Vec<(String, Bit, Bit)> = Vec::new();
    let uses = &draw.uses;
    body.cells.retain(|cell| {
        let CellKind::Resolve { width, .. } = cell.kind else { return true };
        let drivers: Vec<&[Bit]> = cell.inputs[0].chunks(*width as usize).collect();
        // read elsewhere too
        let alone = |bit: &Bit| matches!(bit, Bit::Net(n) if uses[*n as usize] > 1);
        if drivers.iter().any(|bits| bits.iter().any(alone)) {
            return true;
        }
        for (&driver, &bus) in drivers.iter().flat_map(|bits| bits.iter().zip(&cell.outputs[0])) {
            match driver {
                Bit::Net(n) if !states[n as usize] => _ = onto.insert(n, bus),
                _ => wires.push((joined(&cell.path), driver, bus)),
            }
        }
        false
    });
    let moved = |bits: &mut Bits| {
        for bit in bits {
            if let Bit::Net(n) = bit {
                *bit = onto.get(n).copied().unwrap_or(*bit);
            }
        }
    };
    body.ports.iter_mut().for_each(|p| moved(&mut p.bits));
    body.nets.iter_mut().for_each(|n| moved(&mut n.bits));
    body.cells.iter_mut().flat_map(|c| c.inputs.iter_mut().chain(&mut c.outputs)).for_each(moved);
    body.instances.iter_mut().flat_map(|i| &mut i.ports).for_each(|p| moved(&mut p.2));
    for (name, driver, bus) in wires {
        draw.name = name;
        draw.unary("wire", "$pos", &[driver], vec![bus]);
    }
}

/// Draws a module.
pub fn module(mut body: Body<'_>, owns: &mut Owns) -> Module {
    let mut module = Module::new(&body.name, body.end);
    module.names = body.ports.iter().map(|p| p.name.clone()).collect();
    let mut names = Vec::new();
    for net in &body.nets {
        names.push(module.unique(&joined(&net.path)));
    }
    // cells after nets: whoever runs the circuit sees nets
    let mut instances = Vec::new();
    for instance in &body.instances {
        let name = joined(&instance.path);
        let free = if module.names.contains(&name) { format!("{name}${}", instance.module) } else { name };
        instances.push(module.unique(&free));
    }
    let mut draw = Draw::new(module, owns);
    draw.uses = uses(&body);
    share(&mut body, &mut draw);
    for port in body.ports {
        let BodyPort { name, direction, bits, signed } = port;
        draw.module.nets.push(Net {
            name: name.clone(),
            bits: bits.clone(),
            hidden: false,
            signed,
            attributes: vec![],
        });
        draw.module.ports.push(Port { name, direction, bits, signed });
    }
    for (net, name) in body.nets.into_iter().zip(names) {
        let BodyNet { path, bits, hidden, signed } = net;
        let attributes = if path.len() > 1 { vec![("hdlname", hdl_name(&path))] } else { vec![] };
        draw.module.nets.push(Net { name, bits, hidden, signed, attributes });
    }
    for cell in body.cells {
        draw.name = joined(&cell.path);
        draw.source = cell.source;
        let mut outputs = cell.outputs;
        for (pin, output) in outputs.iter_mut().enumerate() {
            let width = cell.kind.output_width(pin);
            if output.len() != width as usize {
                let first = draw.module.free;
                draw.module.free += width;
                draw.uses.resize((first + width) as usize, 0);
                *output = (first..first + width).map(Bit::Net).collect();
            }
        }
        cells::draw(&mut draw, cell.kind, cell.element, &cell.inputs, &outputs);
    }
    draw.source = None;
    for (instance, name) in body.instances.into_iter().zip(instances) {
        let renamed = name != joined(&instance.path) || instance.path.len() > 1;
        let attributes = if renamed { vec![("hdlname", hdl_name(&instance.path))] } else { vec![] };
        draw.module.cells.push(super::model::Cell {
            name,
            kind: instance.module,
            hidden: false,
            attributes,
            parameters: vec![],
            connections: instance.ports,
        });
    }
    draw.finish()
}
