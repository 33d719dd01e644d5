//! From a file to a netlist: the modules, one within another, bit by bit.
//!
//! Each bit of a module's instance becomes a bit of the builder; a bit of a port is the bit outside that it is connected
//! to. Cells are lowered in [`cells`](super::cells). All faults are told at once, each with the place in the file and
//! in the source that Yosys read.

mod bits;
mod memories;
mod top;

use std::collections::{BTreeMap, HashMap};

use indexmap::IndexMap;

use super::cells::{self, Type};
use super::file::{self, Cell, File, Module, Net, Port, Term};
use super::monitor::{Monitor, ordered};
use super::origin::Origins;
use crate::Value;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Span};
use crate::netlist::{Builder, Bus, Direction, ScopeId, SignalId, ValueNames};
use crate::syntax::Limits;

pub(super) use bits::Here;
use bits::Plan;

/// How deep modules may be in one another, whatever the limit: each takes some of the stack.
const DEEPEST: u64 = 300;

/// No bit of the builder yet.
const NONE: u32 = u32::MAX;

/// What a memory is to hold at first, in place of what the file says.
#[derive(Clone, Copy)]
pub struct Contents<'t> {
    /// The memory, by its path.
    pub name: &'t str,
    /// Where it is named.
    pub span: Span,
    /// The words, as `$readmemh` reads them.
    pub text: &'t str,
    /// Where they stand.
    pub file: FileId,
}

/// A netlist made of a file, and what goes with it.
pub struct Imported {
    /// The netlist under construction.
    pub builder: Builder,
    /// Where its cells and signals stand.
    pub origins: Origins,
    /// What its `$print`, `$assert` and like cells do.
    pub monitors: Vec<Monitor>,
    /// Where the top module's name stands.
    pub span: Span,
    /// The parameters that it was made with, where we wrote it.
    pub parameters: IndexMap<String, i64>,
    /// Its default scenario as JSON, where we wrote it.
    pub simulation: Option<String>,
}

pub(super) struct Import<'f, 'a> {
    pub file: &'f File<'a>,
    text: &'f str,
    source: FileId,
    limits: &'f Limits,
    pub builder: Builder,
    pub diagnostics: Diagnostics,
    pub monitors: Vec<Monitor>,
    origins: Origins,
    plans: Vec<Option<Plan>>,
    /// The modules by their names; of several of one name the first.
    modules: HashMap<&'f str, usize>,
    /// What each type is, by its term.
    types: HashMap<Term, Type>,
    /// Inverted bits, by the instance that asks for one and the bit.
    pub inverted: HashMap<(ScopeId, u32), Bus>,
    parameters: IndexMap<String, i64>,
    simulation: Option<String>,
    scopes: HashMap<(ScopeId, String), ScopeId>,
    /// Cells that are left out, by type.
    pub ignored: BTreeMap<String, (u32, &'static str)>,
    /// Whether constants are for wires, which must not change those of others.
    pub own_constants: bool,
    /// How many cells, nets and instances there are so far.
    made: u64,
    /// What memories are to hold.
    contents: &'f [Contents<'f>],
    /// Modules whose contents are left out.
    black_boxes: &'f [String],
    /// The paths of all memories.
    memories: Vec<String>,
    /// How many bits memories hold so far.
    memory_bits: u64,
    /// Whether a limit was passed.
    full: bool,
    /// The cell that is being lowered, among the origins.
    at: u32,
}

/// Imports a text. `top` is the module that was asked for, and where it was.
pub fn import(
    text: &str,
    source: FileId,
    top: Option<(&str, Span)>,
    contents: &[Contents<'_>],
    black_boxes: &[String],
    limits: &Limits,
    diagnostics: &mut Diagnostics,
) -> Option<Imported> {
    let file = File::parse(text, source).map_err(|fault| diagnostics.push(fault)).ok()?;
    let mut import = Import {
        file: &file,
        text,
        source,
        limits,
        builder: Builder::new(""),
        diagnostics: Diagnostics::new(),
        monitors: Vec::new(),
        origins: Origins::new(source),
        plans: file.modules.iter().map(|_| None).collect(),
        modules: file.modules.iter().enumerate().rev().map(|(i, m)| (m.name.as_ref(), i)).collect(),
        types: HashMap::new(),
        inverted: HashMap::new(),
        parameters: IndexMap::new(),
        simulation: None,
        scopes: HashMap::new(),
        ignored: BTreeMap::new(),
        own_constants: false,
        made: 0,
        contents,
        black_boxes,
        memories: Vec::new(),
        memory_bits: 0,
        full: false,
        at: NONE,
    };
    let result = import.run(top);
    let (parameters, simulation) = (std::mem::take(&mut import.parameters), import.simulation.take());
    let Import { builder, diagnostics: told, monitors, origins, full, .. } = import;
    diagnostics.append(told);
    let monitors = ordered(monitors);
    result.filter(|_| !full).map(|span| Imported { builder, origins, monitors, span, parameters, simulation })
}

impl<'f, 'a> Import<'f, 'a> {
    fn run(&mut self, top: Option<(&str, Span)>) -> Option<Span> {
        let number = self.top(top)?;
        self.cycles(number)?;
        let module = &self.file.modules[number];
        self.builder = Builder::new(&module.name);
        self.builder.set_verilog();
        self.circuit(module);
        let mut here = self.here(number, self.builder.top(), 1);
        self.top_ports(&mut here);
        self.fill(&mut here);
        self.body(&here);
        self.unknown_memories();
        for (kind, (n, why)) in std::mem::take(&mut self.ignored) {
            let cells = if n == 1 { "cell is" } else { "cells are" };
            let message = format!("{n} `{kind}` {cells} left out: {why}");
            self.diagnostics.push(Diagnostic::new(Code::IgnoredCell, message).at(self.span_of(&module.name), ""));
        }
        Some(self.span_of(&module.name))
    }

    /// What we wrote of the circuit beside its netlist.
    fn circuit(&mut self, module: &Module<'_>) {
        let [timescale, parameters, simulation] = module.circuit.map(|t| t.map(|t| self.file.terms.text(t).as_ref()));
        match timescale.map(str::parse) {
            Some(Ok(timescale)) => self.builder.set_timescale(timescale),
            Some(Err(_)) => {
                let message = format!("a tick cannot be `{}`", timescale.unwrap_or_default());
                let fault = Diagnostic::new(Code::WrongType, message).at(self.span_of(&module.name), "of this module");
                self.diagnostics.push(fault.help("write 1, 10 or 100 of a unit, as in `10ps`"));
            }
            None => {}
        }
        let pairs = parameters.unwrap_or_default().split(' ').filter_map(|p| p.split_once('='));
        self.parameters = pairs.filter_map(|(name, value)| Some((name.to_owned(), value.parse().ok()?))).collect();
        self.simulation = simulation.map(str::to_owned);
    }

    /// Where a string of the file stands.
    pub fn span_of(&self, part: &str) -> Span {
        file::place(self.text, self.source, part).unwrap_or(Span::new(self.source, 0, 1))
    }

    fn term_span(&self, term: Option<Term>) -> Option<Span> {
        file::place(self.text, self.source, self.file.terms.text(term?))
    }

    /// What a type is.
    pub fn kind(&mut self, term: Term) -> &Type {
        let file = self.file;
        self.types.entry(term).or_insert_with(|| {
            let name = file.terms.text(term);
            match self.modules.get(name.as_ref()) {
                Some(&number) => Type::Module(number),
                None => cells::builtin(name),
            }
        })
    }

    /// Which way a port goes, if it is said.
    fn direction(&self, port: &Port<'_>) -> Option<Direction> {
        match self.file.terms.text(port.direction?).as_ref() {
            "input" => Some(Direction::Input),
            "output" => Some(Direction::Output),
            "inout" => Some(Direction::Inout),
            _ => None,
        }
    }

    /// Says which ports of a module are not whole.
    fn check_ports(&mut self, module: &'f Module<'a>) {
        for port in &module.ports {
            if self.direction(port).is_none() {
                let message = match port.direction.map(|d| self.file.terms.text(d)) {
                    Some(found) => format!("port `{}` of `{}` cannot go `{found}`", port.name, module.name),
                    None => format!("port `{}` of `{}` has no `direction`", port.name, module.name),
                };
                let fault = Diagnostic::new(Code::WrongType, message);
                self.diagnostics.push(fault.at(self.span_of(&port.name), "input, output or inout"));
            }
            if !port.has_bits {
                let message = format!("port `{}` of `{}` has no `bits`", port.name, module.name);
                let fault = Diagnostic::new(Code::MissingField, message).at(self.span_of(&port.name), "");
                self.diagnostics.push(fault.help("list its bits: `\"bits\": [ 2 ]`"));
            }
        }
    }

    fn top_ports(&mut self, here: &mut Here<'f, 'a>) {
        let named = here.module.nets.iter().filter(|net| !net.values.is_empty());
        let named: HashMap<&str, &Net<'a>> = named.map(|net| (net.name.as_ref(), net)).collect();
        for port in here.module.ports.iter().filter(|p| !p.bits.is_empty()) {
            let way = match self.direction(port) {
                Some(way @ (Direction::Input | Direction::Inout)) => way,
                _ => continue,
            };
            let scope = here.scope;
            let (signal, bus) = self.builder.declare(scope, &port.name, port.bits.len(), port.signed, Some(way));
            self.builder.set_indices(signal, port.offset, port.upto);
            self.name_values(signal, named.get(port.name.as_ref()).copied());
            self.origins.signal(self.span_of(&port.name));
            for (bit, to) in here.module.bits(port.bits).to_vec().into_iter().zip(bus.bits()) {
                self.bind(here, bit, to);
            }
        }
        self.fill(here);
        for port in here.module.ports.iter().filter(|p| !p.bits.is_empty()) {
            match self.direction(port) {
                Some(Direction::Input | Direction::Inout) => continue,
                // one that goes nowhere is told of already
                Some(Direction::Output) | None => {}
            }
            self.own_constants = false;
            let bus = self.bus(here, here.module.bits(port.bits));
            let way = Some(Direction::Output);
            let signal = self.builder.name(here.scope, &port.name, bus, port.signed, false, way);
            self.builder.set_indices(signal, port.offset, port.upto);
            self.name_values(signal, named.get(port.name.as_ref()).copied());
            self.origins.signal(self.span_of(&port.name));
        }
    }

    fn too_large(&mut self, limit: &str, what: &str, most: u64, span: Span) {
        if !std::mem::replace(&mut self.full, true) {
            let fault = Diagnostic::new(Code::TooLarge, format!("the circuit has more than {most} {what}"));
            let help = format!("if you need that, raise the limit: `--limit {limit}=NUMBER`");
            self.diagnostics.push(fault.at(span, "while building this").help(help));
        }
    }

    /// Gives the values of a signal the names of its enumeration. What no viewer can show is left out.
    fn name_values(&mut self, signal: SignalId, net: Option<&Net<'a>>) {
        let Some(net) = net else { return };
        let named = net.values.iter().filter_map(|&(bits, name)| {
            let [bits, name] = [bits, name].map(|term| self.file.terms.text(term).as_ref());
            let name = name.strip_prefix('\\').unwrap_or(name).trim_end();
            let value: Value = format!("{}'b{bits}", bits.len()).parse().ok()?;
            let fits = bits.len() == net.bits.len() as usize && ValueNames::unfit(name).is_none();
            fits.then(|| (value, name.to_owned()))
        });
        let named: Vec<_> = named.collect();
        if !named.is_empty() {
            self.builder.set_values(signal, ValueNames::new(named));
        }
    }

    /// Says where the last signal stands: with a cell.
    pub fn place_signal(&mut self, cell: &str) {
        self.origins.signal(self.span_of(cell));
    }

    /// The scope of a path below another.
    fn inner_scope(&mut self, scope: ScopeId, name: &str) -> ScopeId {
        if let Some(&known) = self.scopes.get(&(scope, name.to_owned())) {
            return known;
        }
        let id = self.builder.scope(scope, name);
        self.scopes.insert((scope, name.to_owned()), id);
        id
    }

    /// The nets and cells of an instance whose bits are there.
    fn body(&mut self, here: &Here<'f, 'a>) {
        let top = here.depth == 1;
        let ports: HashMap<&str, Option<Direction>> =
            here.module.ports.iter().map(|p| (p.name.as_ref(), self.direction(p))).collect();
        for net in here.module.nets.iter().filter(|n| !n.bits.is_empty()) {
            let port = ports.get(net.name.as_ref());
            if top && port.is_some() {
                continue;
            }
            let (mut scope, mut name) = (here.scope, net.name.as_ref());
            if let Some(mut parts) = self.path_of(net.path, &net.name, false) {
                name = parts.pop().unwrap_or(name);
                scope = parts.iter().fold(scope, |scope, part| self.inner_scope(scope, part));
            }
            let bus = self.bus(here, here.module.bits(net.bits));
            let way = port.copied().flatten().filter(|_| scope == here.scope);
            let signal = self.builder.name(scope, name, bus, net.signed, net.hidden, way);
            self.builder.set_indices(signal, net.offset, net.upto);
            self.name_values(signal, Some(net));
            self.origins.signal(self.span_of(&net.name));
        }
        let origin = self.plan(here.number).origin;
        self.made += 1 + (here.module.nets.len() + here.module.cells.len()) as u64;
        let mut parts = Vec::new();
        for (i, cell) in here.module.cells.iter().enumerate() {
            if self.full {
                return;
            }
            if self.made.max(self.builder.cell_count() as u64) > self.limits.cells {
                return self.too_large("cells", "cells", self.limits.cells, self.span_of(&cell.name));
            }
            self.at = origin + i as u32;
            if self.is_stub(cell) {
                self.stub(here, cell);
            } else if let Type::Module(number) = *self.kind(cell.kind) {
                self.instance(here, cell, number);
            } else if let Type::MemoryPart = self.kind(cell.kind) {
                parts.push(i);
            } else if let Err(why) = cells::lower(self, here, cell) {
                self.tell(cell, why);
            }
            self.origins.fill(self.builder.cell_count(), self.at);
        }
        if !parts.is_empty() {
            cells::memory::parts(self, here, &parts, Self::tell);
            self.origins.fill(self.builder.cell_count(), self.at);
        }
    }

    /// Says why a cell cannot be taken.
    fn tell(&mut self, cell: &Cell<'a>, why: cells::Fault) {
        let kind = self.file.terms.text(cell.kind);
        let fault = Diagnostic::new(why.code, format!("`{}`, a `{kind}`: {}", cell.name, why.message));
        let fault = self.with_source(fault.at(self.span_of(&cell.name), "this cell"), cell);
        self.diagnostics.push(why.help.into_iter().fold(fault, Diagnostic::help));
    }

    /// What is lowered from now on comes from cell `at` of a module, as far as what has been is told of.
    pub fn at_cell(&mut self, here: &Here<'f, 'a>, at: usize) {
        self.origins.fill(self.builder.cell_count(), self.at);
        self.at = self.plan(here.number).origin + at as u32;
    }

    /// The blocks around a name that a flattened one had, and that name; only where it is the name indeed, so that no two
    /// become one. An instance may have got a suffix.
    fn path_of(&self, path: Option<Term>, name: &str, suffix: bool) -> Option<Vec<&'f str>> {
        let parts: Vec<&str> = self.file.terms.text(path?).split(' ').filter(|p| !p.is_empty()).collect();
        let rest = name.strip_prefix(&parts.join("."))?;
        let same = if rest.is_empty() { parts.len() > 1 || suffix } else { suffix && rest.starts_with('$') };
        (same && !parts.is_empty()).then_some(parts)
    }

    /// Says where a cell comes from.
    fn with_source(&self, fault: Diagnostic, cell: &Cell<'a>) -> Diagnostic {
        match cell.source {
            Some(source) => fault.note(format!("it comes from {}", self.file.terms.text(source))),
            None => fault,
        }
    }

    /// An instance of a module that stands for an element of ours.
    fn element(&mut self, here: &Here<'f, 'a>, cell: &Cell<'a>, own: Term) {
        if let Err(why) = cells::element(self, here, cell, own) {
            let fault = Diagnostic::new(why.code, format!("`{}`: {}", cell.name, why.message));
            let fault = self.with_source(fault.at(self.span_of(&cell.name), "this cell"), cell);
            self.diagnostics.push(why.help.into_iter().fold(fault, Diagnostic::help));
        }
    }

    /// Whether a cell is an instance of a module whose contents are to be left out.
    fn is_stub(&self, cell: &Cell<'a>) -> bool {
        let kind = self.file.terms.text(cell.kind).as_ref();
        self.black_boxes.iter().any(|name| name == kind || top::original(kind) == Some(name))
    }

    /// An instance of such a module: its outputs are x, as far as the file says which ports are outputs.
    fn stub(&mut self, here: &Here<'f, 'a>, cell: &Cell<'a>) {
        let Type::Module(number) = *self.kind(cell.kind) else { return };
        let inner = &self.file.modules[number];
        for &(term, range) in here.module.connections(cell) {
            let name = self.file.terms.text(term);
            let port = inner.ports.iter().find(|p| p.name == *name);
            if port.is_some_and(|p| self.direction(p) == Some(Direction::Output)) && !range.is_empty() {
                self.own_constants = true;
                let outer = self.bus(here, here.module.bits(range));
                let unknown = self.builder.own_constant(&Value::unknown(range.len()));
                self.builder.join(&outer, &unknown);
            }
        }
    }

    fn instance(&mut self, here: &Here<'f, 'a>, cell: &Cell<'a>, number: usize) {
        let inner = &self.file.modules[number];
        let fault = |code, message: String| Diagnostic::new(code, message);
        if let Some(own) = inner.own {
            return self.element(here, cell, own);
        }
        let mut told = None;
        if inner.black_box {
            let message = format!("`{}` is a black box: the file has no contents for `{}`", cell.name, inner.name);
            told = Some(fault(Code::UnsupportedCell, message).help(format!(
                "read its Verilog too before `write_json`, or give `--blackbox {}`: what it drives is x",
                inner.name
            )));
        } else if here.depth >= self.limits.depth.min(DEEPEST) {
            let message = format!("modules are more than {} deep in one another", self.limits.depth.min(DEEPEST));
            told = Some(fault(Code::TooLarge, message).help("flatten it: `prep -flatten`"));
        }
        let parameters = here.module.parameters(cell);
        if told.is_none() && parameters.iter().any(|p| !inner.defaults.contains(p)) {
            let message = format!("`{}` sets parameters that `{}` was not made with", cell.name, inner.name);
            told = Some(fault(Code::UnsupportedCell, message).help("let Yosys resolve them: `hierarchy` or `prep`"));
        }
        if let Some(fault) = told {
            let fault = fault.at(self.span_of(&cell.name), "this cell");
            let fault = self.with_source(fault, cell);
            return self.diagnostics.push(fault);
        }
        let (mut around, mut name) = (here.scope, cell.name.as_ref());
        if let Some(mut parts) = self.path_of(cell.path, &cell.name, true) {
            name = parts.pop().unwrap_or(name);
            around = parts.iter().fold(around, |scope, part| self.inner_scope(scope, part));
        }
        let scope = self.builder.instance(around, name, &inner.name);
        let mut inside = self.here(number, scope, here.depth + 1);
        for &(term, range) in here.module.connections(cell) {
            let name = self.file.terms.text(term);
            let Some(port) = inner.ports.iter().find(|p| p.name == *name) else {
                let message = format!("`{}` connects `{name}`, which `{}` does not have", cell.name, inner.name);
                let fault = fault(Code::UnknownPort, message).at(self.span_of(&cell.name), "this cell");
                let fault = fault.did_you_mean(name, inner.ports.iter().map(|p| p.name.as_ref()));
                let fault = self.with_source(fault, cell);
                self.diagnostics.push(fault);
                continue;
            };
            let (outer, inner_bits) = (here.module.bits(range), inner.bits(port.bits));
            // `.port()`: connected to nothing
            if outer.is_empty() {
                continue;
            }
            if outer.len() != inner_bits.len() {
                let message =
                    format!("`{}` connects {} bits to `{name}` of {}", cell.name, outer.len(), inner_bits.len());
                let fault = fault(Code::WidthMismatch, message).at(self.span_of(&cell.name), "this cell");
                let fault = self.with_source(fault, cell);
                self.diagnostics.push(fault);
                continue;
            }
            self.own_constants = true;
            let bus = self.bus(here, outer);
            for (&bit, to) in inner_bits.iter().zip(bus.bits()) {
                self.bind(&mut inside, bit, to);
            }
        }
        self.fill(&mut inside);
        let at = self.at;
        self.body(&inside);
        self.at = at;
    }
}
