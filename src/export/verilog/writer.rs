//! The text of one module as it grows: its identifiers, what stands for a net, what is assigned.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Write as _;

use super::design::STARTED;
use super::names::{Taken, identifier};
use super::text::{literal, range};
use super::{feedback, memory};
use crate::cell::CellKind;
use crate::netlist::hierarchy::{Cell, Hierarchy, Module, Piece};
use crate::netlist::{Direction, NetId, Netlist};

pub(super) struct Writer<'h> {
    pub netlist: &'h Netlist,
    pub hierarchy: &'h Hierarchy,
    pub modules: &'h [String],
    /// The nets that are clocks.
    pub clocks: &'h HashSet<NetId>,
    pub module: &'h Module,
    pub number: usize,
    pub names: Taken,
    /// The identifiers of the wires.
    pub wires: Vec<String>,
    /// The identifiers of the blocks and instances.
    pub blocks: Vec<String>,
    pub instances: Vec<String>,
    /// How often each wire is driven.
    pub drivers: Vec<u32>,
    /// Which of its bits are read.
    pub read: Vec<Vec<bool>>,
    /// Which wires go round in circles.
    pub circular: Vec<bool>,
    /// The cells whose outputs close a circle, by their place.
    pub closing: Vec<bool>,
    pub text: String,
    pub indent: usize,
    /// What is assigned to in place of a cell's output.
    pub instead: Option<String>,
    /// Whether what is clocked waits until the circuit has first settled, and the wire that says so, once anything reads it.
    pub waits: bool,
    pub started: Option<String>,
    /// The modules of `support.v` that are needed.
    pub support: BTreeSet<&'static str>,
}

impl<'h> Writer<'h> {
    pub fn new(
        netlist: &'h Netlist,
        hierarchy: &'h Hierarchy,
        modules: &'h [String],
        clocks: &'h HashSet<NetId>,
        number: usize,
    ) -> Writer<'h> {
        let module = &hierarchy.modules()[number];
        let mut writer = Writer {
            netlist,
            hierarchy,
            modules,
            clocks,
            module,
            number,
            names: Taken::default(),
            wires: Vec::new(),
            blocks: vec![String::new(); module.blocks.len()],
            instances: vec![String::new(); module.instances.len()],
            drivers: vec![0; module.wires.len()],
            read: module.wires.iter().map(|w| vec![false; w.width as usize]).collect(),
            circular: vec![false; module.wires.len()],
            closing: feedback::closing(netlist, module),
            text: String::new(),
            indent: 0,
            instead: None,
            waits: false,
            started: None,
            support: BTreeSet::new(),
        };
        // signals keep their names; others give way
        let mut order: Vec<usize> = (0..module.wires.len()).collect();
        order.sort_by_key(|&w| (module.wires[w].is_made(), module.wires[w].block, w));
        writer.wires = vec![String::new(); module.wires.len()];
        for w in order {
            let wire = &module.wires[w];
            writer.wires[w] = writer.fresh(wire.block, &wire.name);
        }
        writer.count();
        writer
    }

    /// Counts what drives each wire, and finds those that are read.
    fn count(&mut self) {
        let module = self.module;
        let (drivers, read) = (&mut self.drivers, &mut self.read);
        let mut each = |pieces: &[Piece], drives: bool| {
            for piece in pieces {
                if let Piece::Wire { wire, lo, width } = piece {
                    drivers[*wire] += u32::from(drives);
                    if !drives {
                        read[*wire][*lo as usize..(lo + width) as usize].fill(true);
                    }
                }
            }
        };
        for cell in &module.cells {
            match &self.netlist.cell(cell.id).kind {
                CellKind::Memory(m) => memory::reads(cell, m).iter().for_each(|p| each(p, false)),
                _ => cell.inputs.iter().for_each(|p| each(p, false)),
            }
            cell.outputs.iter().for_each(|p| each(p, true));
        }
        for instance in &module.instances {
            for (port, pieces) in self.hierarchy.modules()[instance.module].ports().iter().zip(&instance.ports) {
                if port.port != Some(Direction::Output) {
                    each(pieces, false);
                }
                if port.port != Some(Direction::Input) {
                    // what an instance drives cannot be a variable
                    each(pieces, true);
                    each(pieces, true);
                }
            }
        }
        for (w, wire) in module.wires.iter().enumerate() {
            let others: Vec<Piece> = wire.shown_of_others(w).into_iter().flat_map(|(_, run)| run).collect();
            each(&others, false);
            if !others.is_empty() {
                let this = Piece::Wire { wire: w, lo: 0, width: 1 };
                each(&[this.clone(), this], true);
            }
        }
    }

    /// The blocks around one, itself first.
    fn around(&self, block: usize) -> Vec<usize> {
        let mut all = vec![block];
        while let Some(up) = self.module.blocks[all[all.len() - 1]].parent {
            all.push(up);
        }
        all
    }

    /// A new identifier in a block.
    pub fn fresh(&mut self, block: usize, base: &str) -> String {
        let around = self.around(block);
        let clean = base.replace(char::is_whitespace, "_");
        identifier(&self.names.fresh(&around, &clean))
    }

    /// A new identifier for something that a cell needs: its name and what it is.
    pub fn helper(&mut self, cell: &Cell, what: &str) -> String {
        let name = self.name_of(cell);
        self.fresh(cell.block, &format!("{name}_{what}"))
    }

    /// The name of a cell, without what would have to be escaped.
    pub fn name_of(&self, cell: &Cell) -> String {
        let name = &self.netlist.cell(cell.id).name;
        let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let name = name.trim_end_matches('_').to_owned();
        if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() { format!("c{name}") } else { name }
    }

    /// A line at the present depth.
    pub fn line(&mut self, text: impl AsRef<str>) {
        for line in text.as_ref().lines() {
            let indent = if line.starts_with('`') || line.is_empty() { 0 } else { self.indent };
            let _ = writeln!(self.text, "{:indent$}{}", "", line.trim_end());
        }
    }

    /// Some bits of a wire.
    pub fn select(&self, wire: usize, lo: u32, width: u32) -> String {
        let name = &self.wires[wire];
        match self.module.wires[wire].width {
            whole if whole == width => {
                name.trim_end_matches(if name.starts_with('\\') { '\0' } else { ' ' }).to_owned()
            }
            _ if width == 1 => format!("{name}[{lo}]"),
            _ => format!("{name}[{}:{lo}]", lo + width - 1),
        }
    }

    /// Pieces as an expression, or as what is assigned to.
    pub fn text_of(&self, pieces: &[Piece]) -> String {
        let one = |piece: &Piece| match piece {
            Piece::Wire { wire, lo, width } => self.select(*wire, *lo, *width),
            Piece::Constant(value) => literal(value),
            Piece::Open(width) => format!("{width}'bx"),
        };
        if let [piece] = pieces {
            return one(piece);
        }
        let mut all: Vec<String> = Vec::new();
        let mut at = pieces.len();
        while at > 0 {
            let piece = &pieces[at - 1];
            let same = pieces[..at].iter().rev().take_while(|p| *p == piece).count();
            all.push(if same == 1 { one(piece) } else { format!("{{{same}{{{}}}}}", one(piece)) });
            at -= same;
        }
        match all.as_slice() {
            [all] => all.clone(),
            all => format!("{{{}}}", all.join(", ")),
        }
    }

    /// An input pin of a cell as an expression; what it reads when it is open.
    pub fn input(&self, cell: &Cell, pin: usize) -> String {
        let kind = &self.netlist.cell(cell.id).kind;
        match cell.inputs[pin].as_slice() {
            [] => {
                let bit = if kind.inputs()[pin].default { "1" } else { "0" };
                let width = kind.input_width(pin);
                format!("{width}'b{}", bit.repeat(width as usize))
            }
            pieces => self.text_of(pieces),
        }
    }

    /// The wire that is nothing but an output pin's, and may be a variable.
    pub fn own_wire(&self, pieces: &[Piece]) -> Option<usize> {
        match pieces {
            [Piece::Wire { wire, lo: 0, width }] => {
                let found = &self.module.wires[*wire];
                let only = self.drivers[*wire] == 1 && found.width == *width;
                (only && !matches!(found.port, Some(Direction::Input | Direction::Inout))).then_some(*wire)
            }
            _ => None,
        }
    }

    /// The name of the wire that pieces are the whole of.
    pub fn whole_wire(&self, pieces: &[Piece]) -> Option<String> {
        match pieces {
            [Piece::Wire { wire, lo: 0, width }] if self.module.wires[*wire].width == *width => {
                Some(self.select(*wire, 0, *width))
            }
            _ => None,
        }
    }

    /// Whether nothing needs an output pin.
    pub fn is_open(cell: &Cell, pin: usize) -> bool {
        cell.outputs[pin].iter().all(|p| matches!(p, Piece::Open(_)))
    }

    /// The wire that an output of a storage cell is, if it is one.
    pub fn state_wire(&self, pieces: &[Piece]) -> Option<String> {
        self.own_wire(pieces).map(|w| self.wires[w].clone())
    }

    /// What an expression for an output pin is assigned to; where some of its bits are open, a wire of its own.
    pub fn assign(&mut self, cell: &Cell, pin: usize, expression: &str) {
        let pieces = &cell.outputs[pin];
        let comment = format!("  // {}", crate::safe::name(&self.netlist.cell(cell.id).name));
        if let Some(instead) = self.instead.clone() {
            return self.line(format!("assign {instead} = {expression};{comment}"));
        }
        if Self::is_open(cell, pin) {
            return;
        }
        if !pieces.iter().any(|p| matches!(p, Piece::Open(_))) {
            let to = self.text_of(pieces);
            return self.line(format!("assign {to} = {expression};{comment}"));
        }
        let kind = &self.netlist.cell(cell.id).kind;
        let all = self.helper(cell, kind.outputs()[pin]);
        self.unused(&format!("wire {}{all} = {expression};{comment}", range(kind.output_width(pin))));
        self.connect(cell, pin, &all);
    }

    /// Takes an output pin's bits from a vector that holds them.
    pub fn connect(&mut self, cell: &Cell, pin: usize, all: &str) {
        self.connect_to(&cell.outputs[pin], all);
    }

    /// Takes bits from a vector that holds them.
    pub fn connect_to(&mut self, pieces: &[Piece], all: &str) {
        let width = super::text::width(pieces);
        let mut at = 0;
        for piece in pieces {
            if let Piece::Wire { wire, lo, width: own } = piece {
                let to = self.select(*wire, *lo, *own);
                let from = match *own {
                    own if own == width => all.to_owned(),
                    1 => format!("{all}[{at}]"),
                    own => format!("{all}[{}:{at}]", at + own - 1),
                };
                self.line(format!("assign {to} = {from};"));
            }
            at += piece.width();
        }
    }

    /// A declaration of which some bits may be needed by nobody.
    pub fn unused(&mut self, declaration: &str) {
        self.line("/* verilator lint_off UNUSED */ // some of it is not needed");
        self.line(declaration);
        self.line("/* verilator lint_on UNUSED */");
    }

    /// What is 1 once the circuit has first settled, where that has to be waited for.
    pub fn started(&mut self) -> Option<String> {
        if self.waits && self.started.is_none() {
            self.support.insert(STARTED);
            self.started = Some(self.fresh(0, "started"));
        }
        self.started.clone()
    }

    /// The kind of a cell.
    pub fn kind(&self, cell: &Cell) -> &'h CellKind {
        &self.netlist.cell(cell.id).kind
    }
}
