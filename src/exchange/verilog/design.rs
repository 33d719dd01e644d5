//! Modules: ports, wires, what is one wire by two names, cells, instances, blocks.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt::Write as _;

use super::names::{Taken, identifier};
use super::text::{literal, range};
use super::{cells, memory, storage};
use crate::cell::CellKind;
use crate::netlist::graph::Graph;
use crate::netlist::hierarchy::circles::{circular, shows};
use crate::netlist::hierarchy::{Cell, Hierarchy, Module, Piece};
use crate::netlist::{Direction, NetId, Netlist};

/// A netlist as Verilog.
#[must_use]
pub fn design(netlist: &Netlist) -> String {
    written(netlist).text
}

/// The design, and what is called how in it.
pub(super) struct Written {
    pub text: String,
    pub hierarchy: Hierarchy,
    /// The identifiers of the modules.
    pub modules: Vec<String>,
    pub names: Vec<Identifiers>,
}

/// The identifiers in one module.
pub(super) struct Identifiers {
    pub wires: Vec<String>,
    pub blocks: Vec<String>,
    pub instances: Vec<String>,
}

pub(super) fn written(netlist: &Netlist) -> Written {
    let hierarchy = Hierarchy::of(netlist);
    let mut used = BTreeSet::new();
    let mut names = Taken::default();
    let modules: Vec<String> =
        hierarchy.modules().iter().map(|m| names.fresh(&[0], &super::names::readable(&m.name))).collect();
    let feedback = feedback(netlist, &hierarchy);
    let clocks = storage::clocks(netlist);
    let mut identifiers = Vec::new();
    let bodies: Vec<String> = (0..modules.len())
        .map(|m| {
            let mut writer = Writer::new(netlist, &hierarchy, &modules, &clocks, m);
            writer.circular = feedback[m].clone();
            writer.module();
            used.append(&mut writer.support);
            let Writer { wires, blocks, instances, text, .. } = writer;
            identifiers.push(Identifiers { wires, blocks, instances });
            text
        })
        .collect();
    let mut text = format!("// {}: written by discreta {}\n", names_of(&modules), env!("CARGO_PKG_VERSION"));
    text += "\n/* verilator lint_off DECLFILENAME */ // all modules are in this file\n";
    let _ = writeln!(text, "`timescale {0} / {0}", bench_timescale(netlist));
    for body in bodies {
        text.push('\n');
        text += &body;
    }
    for module in used {
        let _ = write!(text, "\n{}\n", support(module).trim_end());
    }
    let modules = modules.iter().map(|m| identifier(m)).collect();
    Written { text, hierarchy, modules, names: identifiers }
}

/// Which wires of each module are part of a circle in any instance.
fn feedback(netlist: &Netlist, hierarchy: &Hierarchy) -> Vec<Vec<bool>> {
    let nets = circular(netlist);
    let mut found: Vec<Vec<bool>> = hierarchy.modules().iter().map(|m| vec![false; m.wires.len()]).collect();
    if !nets.contains(&true) {
        return found;
    }
    // by name, for every instance
    let mut names: BTreeSet<(usize, &str)> = BTreeSet::new();
    for id in netlist.signal_ids().filter(|&id| shows(netlist, id, &nets)) {
        let signal = netlist.signal(id);
        let mut scope = signal.scope;
        let module = loop {
            match (hierarchy.module_of(scope), netlist.scopes()[scope.index()].parent) {
                (Some(module), _) => break module,
                (None, Some(parent)) => scope = parent,
                (None, None) => break 0,
            }
        };
        names.insert((module, &signal.name));
    }
    for (m, module) in hierarchy.modules().iter().enumerate() {
        for (w, wire) in module.wires.iter().enumerate() {
            let of_cell = |c: &Cell| {
                let drives = |p: &Piece| matches!(p, Piece::Wire { wire, .. } if *wire == w);
                (0..c.outputs.len())
                    .any(|pin| c.outputs[pin].iter().any(drives) && nets[netlist.output(c.id, pin).index()])
            };
            found[m][w] = match wire.signal {
                Some(signal) => names.contains(&(m, &netlist.signal(signal).name)),
                None => module.cells.iter().any(of_cell),
            };
        }
    }
    found
}

fn names_of(modules: &[String]) -> &str {
    modules.first().map_or("", String::as_str)
}

pub(super) fn bench_timescale(netlist: &Netlist) -> String {
    netlist.timescale().to_string()
}

/// A module of `support.v`.
fn support(name: &str) -> &'static str {
    let all = include_str!("support.v");
    let mut parts = all.split("\n\n\n").map(str::trim_start);
    parts.find(|part| part.contains(&format!("module {name} "))).unwrap_or_default()
}

pub(super) struct Writer<'h> {
    pub netlist: &'h Netlist,
    hierarchy: &'h Hierarchy,
    modules: &'h [String],
    /// The nets that are clocks.
    pub clocks: &'h HashSet<NetId>,
    module: &'h Module,
    number: usize,
    names: Taken,
    /// The identifiers of the wires.
    wires: Vec<String>,
    /// The identifiers of the blocks and instances.
    blocks: Vec<String>,
    instances: Vec<String>,
    /// How often each wire is driven.
    drivers: Vec<u32>,
    /// Which of its bits are read.
    read: Vec<Vec<bool>>,
    /// Which wires go round in circles.
    circular: Vec<bool>,
    /// The cells whose outputs close a circle, by their place.
    closing: Vec<bool>,
    pub text: String,
    indent: usize,
    /// What is assigned to in place of a cell's output.
    instead: Option<String>,
    /// The modules of `support.v` that are needed.
    pub support: BTreeSet<&'static str>,
}

impl<'h> Writer<'h> {
    fn new(
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
            closing: vec![false; module.cells.len()],
            text: String::new(),
            indent: 0,
            instead: None,
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
        writer.find_closing();
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
            let other = |p: &Piece| !matches!(p, Piece::Wire { wire, .. } if *wire == w);
            let others: Vec<Piece> = wire.bits.iter().filter(|p| other(p)).cloned().collect();
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
    fn select(&self, wire: usize, lo: u32, width: u32) -> String {
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
    fn own_wire(&self, pieces: &[Piece]) -> Option<usize> {
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
        let comment = format!("  // {}", self.netlist.cell(cell.id).name.replace(['\n', '\r'], " "));
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

    fn module(&mut self) {
        let (module, netlist) = (self.module, self.netlist);
        let variables = self.variables();
        let name = identifier(&self.modules[self.number]);
        let mut head = String::new();
        let ports = module.ports();
        for (w, port) in ports.iter().enumerate() {
            let way = match port.port {
                Some(Direction::Output) => "output",
                Some(Direction::Inout) => "inout ",
                _ => "input ",
            };
            let kind = if variables[w] { "reg " } else { "wire" };
            let comma = if w + 1 < ports.len() { "," } else { "" };
            let declared = format!("    {way} {kind} {}{}{comma}\n", range(port.width), self.wires[w]);
            let unread = port.port == Some(Direction::Input) && self.read[w].contains(&false);
            let lints = [(unread, "UNUSED", "not all is read"), (self.circular[w], "UNOPTFLAT", "feedback")];
            for (_, lint, why) in lints.iter().filter(|l| l.0) {
                head += &format!("    /* verilator lint_off {lint} */ // {why}\n");
            }
            head += &declared;
            for (_, lint, _) in lints.iter().filter(|l| l.0) {
                head += &format!("    /* verilator lint_on {lint} */\n");
            }
        }
        let _ = netlist;
        match ports.is_empty() {
            true => self.line(format!("module {name};")),
            false => {
                self.text += &format!("module {name}(\n{head});\n");
            }
        }
        self.indent = 4;
        self.block(0, &variables);
        self.indent = 0;
        self.line("endmodule");
    }

    /// Which wires are variables: those that one storage cell alone drives.
    fn variables(&self) -> Vec<bool> {
        let mut variables = vec![false; self.module.wires.len()];
        for cell in &self.module.cells {
            let kind = &self.netlist.cell(cell.id).kind;
            for state in storage::variables(cell, kind) {
                if let Some(wire) = self.own_wire(&state) {
                    variables[wire] = true;
                }
            }
        }
        variables
    }

    fn block(&mut self, block: usize, variables: &[bool]) {
        let module = self.module;
        let ports = module.ports().len();
        let of_block = |w: &usize| module.wires[*w].block == block && *w >= ports;
        // by what Verilator is not to tell of them
        let class = |w: usize| (self.read[w].contains(&false), self.circular[w]);
        let mut classes: Vec<((bool, bool), usize)> =
            (0..module.wires.len()).filter(of_block).map(|w| (class(w), w)).collect();
        classes.sort_by_key(|c| c.0);
        for group in classes.chunk_by(|a, b| a.0 == b.0) {
            let (unread, circular) = group[0].0;
            let lints = [(unread, "UNUSED", "to be looked at; not all is read"), (circular, "UNOPTFLAT", "feedback")];
            for (_, lint, why) in lints.iter().filter(|l| l.0) {
                self.line(format!("/* verilator lint_off {lint} */ // {why}"));
            }
            group.iter().for_each(|&(_, w)| self.declare(w, variables[w]));
            for (_, lint, _) in lints.iter().filter(|l| l.0) {
                self.line(format!("/* verilator lint_on {lint} */"));
            }
        }
        for (w, wire) in module.wires.iter().enumerate().filter(|(_, wire)| wire.block == block) {
            self.alias(w, &wire.bits);
        }
        for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| c.block == block) {
            match self.closing[c] {
                true => self.closing(cell),
                false => cells::write(self, cell),
            }
        }
        for (i, _) in module.instances.iter().enumerate().filter(|(_, x)| x.block == block) {
            self.instance(i);
        }
        for inner in (0..module.blocks.len()).filter(|&b| module.blocks[b].parent == Some(block)) {
            let name = self.fresh(block, &module.blocks[inner].name);
            self.blocks[inner] = name.clone();
            self.line(format!("if (1) begin : {name}"));
            self.indent += 4;
            self.block(inner, variables);
            self.indent -= 4;
            self.line("end");
        }
    }

    /// A cell that closes a circle: its output goes through a module, so that tools see that it is meant.
    fn closing(&mut self, cell: &Cell) {
        self.support.insert("discreta_feedback");
        let width = self.kind(cell).output_width(0);
        let out = self.helper(cell, "out");
        self.line("/* verilator lint_off UNOPTFLAT */ // feedback");
        self.line(format!("wire {}{out};", range(width)));
        self.line("/* verilator lint_on UNOPTFLAT */");
        self.instead = Some(out.clone());
        cells::write(self, cell);
        self.instead = None;
        let q = self.text_of(&cell.outputs[0]);
        let name = self.helper(cell, "feedback");
        self.line(format!("discreta_feedback #(.WIDTH({width})) {name} (.a({out}), .q({q}));"));
    }

    /// Finds the cells whose outputs close circles within the module.
    fn find_closing(&mut self) {
        let module = self.module;
        let mut driver: HashMap<(usize, u32), u32> = HashMap::new();
        let bits = |pieces: &[Piece]| -> Vec<(usize, u32)> {
            let one = |p: &Piece| match *p {
                Piece::Wire { wire, lo, width } => (lo..lo + width).map(|b| (wire, b)).collect::<Vec<_>>(),
                _ => vec![],
            };
            pieces.iter().flat_map(one).collect()
        };
        let plain =
            |c: &Cell| matches!(self.kind(c), CellKind::Gate { .. } | CellKind::AndOr { .. } | CellKind::Mux { .. });
        let mut edges: Vec<(u32, u32)> = Vec::new();
        for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| plain(c)) {
            for bit in bits(&cell.outputs[0]) {
                driver.insert(bit, c as u32);
            }
        }
        // another name for a bit is that bit already, so cells and wires are all there is
        for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| plain(c)) {
            let from: BTreeSet<u32> =
                cell.inputs.iter().flat_map(|p| bits(p)).filter_map(|b| driver.get(&b).copied()).collect();
            edges.extend(from.into_iter().map(|f| (f, c as u32)));
        }
        loop {
            let open = edges.iter().filter(|e| !self.closing[e.0 as usize]);
            let open: Vec<(u32, u32)> = open.copied().collect();
            let graph = Graph::new(module.cells.len(), |f| open.iter().for_each(|&(a, b)| f(a, b)));
            let sorted = graph.sorted();
            if sorted.groups.is_empty() {
                return;
            }
            for group in &sorted.groups {
                let members = sorted.sequence[group.clone()].iter();
                let whole =
                    |&&c: &&u32| !module.cells[c as usize].outputs[0].iter().any(|p| matches!(p, Piece::Open(_)));
                match members.filter(whole).min() {
                    Some(&first) => self.closing[first as usize] = true,
                    None => return,
                }
            }
        }
    }

    fn declare(&mut self, w: usize, variable: bool) {
        let wire = &self.module.wires[w];
        let kind = if variable { "reg " } else { "wire" };
        let text = format!("{kind} {}{};", range(wire.width), self.wires[w]);
        self.line(text);
    }

    /// What a wire shows of others.
    fn alias(&mut self, w: usize, bits: &[Piece]) {
        let mut at = 0;
        let mut run: Vec<Piece> = Vec::new();
        let mut runs: Vec<(u32, Vec<Piece>)> = Vec::new();
        for piece in bits {
            if matches!(piece, Piece::Wire { wire, .. } if *wire == w) {
                if !run.is_empty() {
                    runs.push((at - super::text::width(&run), std::mem::take(&mut run)));
                }
            } else {
                run.push(piece.clone());
            }
            at += piece.width();
        }
        if !run.is_empty() {
            runs.push((at - super::text::width(&run), run));
        }
        for (lo, run) in runs {
            let to = self.select(w, lo, super::text::width(&run));
            let from = self.text_of(&run);
            self.line(format!("assign {to} = {from};"));
        }
    }

    fn instance(&mut self, i: usize) {
        let instance = &self.module.instances[i];
        let inner = &self.hierarchy.modules()[instance.module];
        let name = self.fresh(instance.block, &instance.name);
        self.instances[i] = name.clone();
        let mut taken = Taken::default();
        let mut connections = Vec::new();
        for (port, pieces) in inner.ports().iter().zip(&instance.ports) {
            let port_name = identifier(&taken.fresh(&[0], &port.name.replace(char::is_whitespace, "_")));
            let open = pieces.iter().filter(|p| matches!(p, Piece::Open(_))).count();
            let to = if open == pieces.len() {
                String::new()
            } else if open == 0 {
                self.text_of(pieces)
            } else {
                // some of an output's bits are needed, others not
                let mut filled = Vec::new();
                for piece in pieces {
                    filled.push(match piece {
                        Piece::Open(width) => {
                            let spare = self.fresh(instance.block, &format!("{}_open", port.name));
                            self.unused(&format!("wire {}{spare};", range(*width)));
                            spare
                        }
                        piece => self.text_of(std::slice::from_ref(piece)),
                    });
                }
                filled.reverse();
                format!("{{{}}}", filled.join(", "))
            };
            connections.push((port_name, to));
        }
        let module = identifier(&self.modules[instance.module]);
        let open = connections.iter().any(|c| c.1.is_empty());
        if open {
            self.line("/* verilator lint_off PINCONNECTEMPTY */ // not needed here");
        }
        let list: Vec<String> = connections.iter().map(|(port, to)| format!(".{port}({to})")).collect();
        let gap = if name.ends_with(' ') { "" } else { " " };
        let short = format!("{module} {name}{gap}({});", list.join(", "));
        if short.len() + self.indent <= 116 {
            self.line(short);
        } else {
            self.line(format!("{module} {name}{gap}("));
            self.line(list.iter().map(|l| format!("    {l}")).collect::<Vec<_>>().join(",\n"));
            self.line(");");
        }
        if open {
            self.line("/* verilator lint_on PINCONNECTEMPTY */");
        }
    }

    /// The kind of a cell.
    pub fn kind(&self, cell: &Cell) -> &'h CellKind {
        &self.netlist.cell(cell.id).kind
    }
}
