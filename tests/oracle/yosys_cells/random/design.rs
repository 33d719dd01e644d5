//! A netlist of many cells, and the two forms in which it is written.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use discreta::cell::Clock;
use discreta::{Logic, Value};
use serde_json::{Map, Value as Json, json};

use crate::yosys_cells::batch::{Cell, module};

/// What a bit of a pin is connected to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Bit {
    /// A wire, and which bit of it.
    Wire(usize, u32),
    Constant(Logic),
}

/// A cell with its connections.
#[derive(Clone)]
pub struct Item {
    pub cell: Cell,
    /// In the order of the cell's inputs, lowest bit first.
    pub inputs: Vec<Vec<Bit>>,
    /// In the order of the cell's outputs: the wires of each, lowest first.
    pub outputs: Vec<Vec<usize>>,
    /// The module that it is in.
    pub group: usize,
    /// Whether the bench gives it its first state.
    pub preset: bool,
}

/// How an input of the top is driven.
#[derive(Clone)]
pub struct Input {
    pub wire: usize,
    pub clock: Option<Clock>,
    /// What it is at which tick, from 0 on; nothing for a clock.
    pub values: Vec<(u64, Value)>,
}

/// A netlist with its stimulus.
#[derive(Clone)]
pub struct Design {
    pub seed: u64,
    /// The width of each wire.
    pub wires: Vec<u32>,
    pub items: Vec<Item>,
    /// The module in which each module is used; the first is the top.
    pub groups: Vec<usize>,
    pub inputs: Vec<Input>,
    /// The last tick.
    pub end: u64,
}

/// How a wire enters a module.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Port {
    Inside,
    Input,
    Output,
    Inout,
}

impl Port {
    fn word(self) -> &'static str {
        ["wire", "input", "output", "inout"][self as usize]
    }
}

/// Which wires each module has, and how.
pub struct Shape(Vec<Vec<(usize, Port)>>);

impl Design {
    fn is_within(&self, mut group: usize, of: usize) -> bool {
        while group != of && group != 0 {
            group = self.groups[group];
        }
        group == of
    }

    /// The path of a module below the top.
    pub fn path(&self, group: usize) -> String {
        if group == 0 { String::new() } else { format!("{}g{group}.", self.path(self.groups[group])) }
    }

    /// Where each wire is seen.
    pub fn shape(&self) -> Shape {
        let mut users: Vec<(BTreeSet<usize>, BTreeSet<usize>)> = vec![Default::default(); self.wires.len()];
        for input in &self.inputs {
            users[input.wire].0.insert(0);
        }
        for item in &self.items {
            for &wire in item.outputs.iter().flatten() {
                users[wire].0.insert(item.group);
            }
            for bit in item.inputs.iter().flatten() {
                if let Bit::Wire(wire, _) = *bit {
                    users[wire].1.insert(item.group);
                }
            }
        }
        let mut shape = vec![Vec::new(); self.groups.len()];
        for (wire, (drivers, readers)) in users.iter().enumerate() {
            let all: BTreeSet<usize> = drivers.union(readers).copied().collect();
            for (group, wires) in shape.iter_mut().enumerate() {
                let inside = |g: &usize| self.is_within(*g, group);
                if !all.iter().any(inside) {
                    continue;
                }
                let input = self.inputs.iter().any(|i| i.wire == wire);
                let port = match (all.iter().all(inside), drivers.iter().any(inside), drivers.iter().all(inside)) {
                    (true, ..) if group == 0 && input => Port::Input,
                    (true, ..) => Port::Inside,
                    (false, true, true) => Port::Output,
                    (false, true, false) => Port::Inout,
                    (false, false, _) => Port::Input,
                };
                // a module around all that have it does not have it
                let lower = (1..self.groups.len())
                    .any(|g| g != group && self.groups[g] == group && all.iter().all(|a| self.is_within(*a, g)));
                if !lower {
                    wires.push((wire, port));
                }
            }
        }
        Shape(shape)
    }

    /// The names of each wire that something drives, one for each module that has it.
    pub fn names(&self) -> Vec<(String, usize)> {
        let mut driven: BTreeSet<usize> = self.items.iter().flat_map(|i| i.outputs.iter().flatten()).copied().collect();
        driven.extend(self.inputs.iter().map(|i| i.wire));
        let mut names = Vec::new();
        for (group, wires) in self.shape().0.into_iter().enumerate() {
            let path = self.path(group);
            names.extend(wires.iter().filter(|w| driven.contains(&w.0)).map(|w| (format!("{path}w{}", w.0), w.0)));
        }
        names
    }

    /// As Yosys writes it.
    pub fn json(&self) -> Json {
        let (shape, mut modules) = (self.shape(), Map::new());
        for (group, wires) in shape.0.iter().enumerate() {
            let mut next = 2;
            let mut first = vec![0; self.wires.len()];
            let (mut ports, mut names, mut cells) = (Map::new(), Map::new(), Map::new());
            for &(wire, port) in wires {
                first[wire] = next;
                let bits: Vec<u32> = (next..next + self.wires[wire]).collect();
                next += self.wires[wire];
                if port != Port::Inside {
                    ports.insert(format!("w{wire}"), json!({ "direction": port.word(), "bits": bits }));
                }
                names.insert(format!("w{wire}"), json!({ "hide_name": 0, "bits": bits, "attributes": {} }));
            }
            let all = |wire: usize| (0..self.wires[wire]).map(move |i| Bit::Wire(wire, i));
            let bits = |bits: &mut dyn Iterator<Item = Bit>| -> Vec<Json> {
                let bit = |bit| match bit {
                    Bit::Wire(wire, i) => json!(first[wire] + i),
                    Bit::Constant(level) => json!(level.to_string()),
                };
                bits.map(bit).collect()
            };
            for (i, item) in self.items.iter().enumerate().filter(|i| i.1.group == group) {
                let mut connections = Map::new();
                for ((port, _), to) in item.cell.inputs.iter().zip(&item.inputs) {
                    connections.insert((*port).into(), bits(&mut to.iter().copied()).into());
                }
                for ((port, _), to) in item.cell.outputs.iter().zip(&item.outputs) {
                    connections.insert((*port).into(), bits(&mut to.iter().flat_map(|w| all(*w))).into());
                    if let Some(init) = &item.cell.init {
                        let (bits, mut end) = (init.bit_string(), init.width() as usize);
                        for wire in to {
                            let begin = end - self.wires[*wire] as usize;
                            names[&format!("w{wire}")]["attributes"]["init"] = json!(bits[begin..end]);
                            end = begin;
                        }
                    }
                }
                let parameters = item.cell.parameters.iter().map(|(n, v)| ((*n).to_owned(), json!(v.bit_string())));
                let parameters: Map<String, Json> = parameters.collect();
                let body = json!({ "hide_name": 0, "type": item.cell.kind, "parameters": parameters, "attributes": {},
                    "connections": connections });
                cells.insert(format!("c{i}"), body);
            }
            for child in (1..self.groups.len()).filter(|g| self.groups[*g] == group) {
                let ports = shape.0[child].iter().filter(|p| p.1 != Port::Inside);
                let ports: Map<String, Json> =
                    ports.map(|&(w, _)| (format!("w{w}"), bits(&mut all(w)).into())).collect();
                cells.insert(format!("g{child}"), json!({ "type": format!("m{child}"), "connections": ports }));
            }
            let attributes = if group == 0 { json!({ "top": "1" }) } else { json!({}) };
            let body = json!({ "attributes": attributes, "ports": ports, "cells": cells, "netnames": names });
            modules.insert(format!("m{group}"), body);
        }
        json!({ "creator": "Yosys test", "modules": modules })
    }

    /// As Verilog: a module `d<number>_m0` and those in it. Constants are nets of the bench.
    pub fn verilog(&self, number: usize) -> String {
        self.text(&format!("d{number}_"), false)
    }

    /// As Verilog for `read_verilog -icells`: a module `m0` and those in it, of Yosys' own cells.
    pub fn verilog_for_yosys(&self) -> String {
        self.text("", true)
    }

    fn text(&self, prefix: &str, yosys: bool) -> String {
        let mut init: Vec<Option<String>> = vec![None; self.wires.len()];
        for (cell, wires) in self.items.iter().flat_map(|i| i.outputs.iter().map(move |o| (&i.cell, o))) {
            let Some(value) = cell.init.as_ref().filter(|_| yosys) else { continue };
            let (bits, mut end) = (value.bit_string(), value.width() as usize);
            for &wire in wires {
                let begin = end - self.wires[wire] as usize;
                init[wire] = Some(format!("(* init = {}'b{} *) ", self.wires[wire], &bits[begin..end]));
                end = begin;
            }
        }
        let mut text = String::new();
        let shape = self.shape();
        for (group, wires) in shape.0.iter().enumerate() {
            let ports = wires.iter().filter(|p| p.1 != Port::Inside).map(|p| format!("w{}", p.0));
            writeln!(text, "module {prefix}m{group} ({});", ports.collect::<Vec<_>>().join(", ")).unwrap();
            for &(wire, port) in wires {
                let here =
                    self.items.iter().any(|i| i.group == group && i.outputs.iter().flatten().any(|w| *w == wire));
                let init = init[wire].as_deref().filter(|_| here).unwrap_or_default();
                writeln!(text, "  {init}{} [{}:0] w{wire};", port.word(), self.wires[wire] - 1).unwrap();
            }
            for (i, item) in self.items.iter().enumerate().filter(|i| i.1.group == group) {
                let inputs =
                    item.cell.inputs.iter().zip(&item.inputs).map(|(p, to)| format!(".{}({})", p.0, joined(to, yosys)));
                let outputs = item.cell.outputs.iter().zip(&item.outputs).map(|(p, to)| {
                    let wires: Vec<String> = to.iter().rev().map(|w| format!("w{w}")).collect();
                    format!(".{}({{{}}})", p.0, wires.join(", "))
                });
                let pins: Vec<String> = inputs.chain(outputs).collect();
                let kind = if yosys { plain(&item.cell) } else { module(&item.cell) };
                writeln!(text, "  {kind} c{i} ({});", pins.join(", ")).unwrap();
            }
            for child in (1..self.groups.len()).filter(|g| self.groups[*g] == group) {
                let ports = shape.0[child].iter().filter(|p| p.1 != Port::Inside).map(|p| format!(".w{0}(w{0})", p.0));
                writeln!(text, "  {prefix}m{child} g{child} ({});", ports.collect::<Vec<_>>().join(", ")).unwrap();
            }
            text += "endmodule\n";
        }
        text
    }
}

/// A cell of Yosys with its parameters, without those that only our model of it has.
fn plain(cell: &Cell) -> String {
    let own = cell.parameters.iter().filter(|p| !p.0.ends_with("_TOTAL"));
    let list: Vec<String> = own.map(|(n, v)| format!(".{n}({}'b{})", v.width(), v.bit_string())).collect();
    if list.is_empty() { format!("\\{} ", cell.kind) } else { format!("\\{} #({})", cell.kind, list.join(", ")) }
}

/// Bits as Verilog joins them, the highest first.
fn joined(bits: &[Bit], yosys: bool) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut i = 0;
    while i < bits.len() {
        match bits[i] {
            Bit::Constant(level) => {
                let same = bits[i..].iter().take_while(|b| **b == bits[i]).count();
                let constant = if yosys { format!("1'b{level}") } else { format!("bench.k{level}") };
                parts.push(format!("{{{same}{{{constant}}}}}"));
                i += same;
            }
            Bit::Wire(wire, low) => {
                let run = (low..).zip(&bits[i..]).take_while(|(n, b)| **b == Bit::Wire(wire, *n)).count();
                parts.push(format!("w{wire}[{}:{low}]", low as usize + run - 1));
                i += run;
            }
        }
    }
    parts.reverse();
    format!("{{{}}}", parts.join(", "))
}
