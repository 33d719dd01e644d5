//! Elaboration: a module with its parameters becomes a netlist, its instances and blocks becoming scopes.

mod cells;
mod memories;

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::library::{Library, ModuleId};
use super::report::{Place, Places};
use super::scope::{Declared, Nets, eval};
use super::value_names;
use super::{Block, Cell, Direction, Limits, Module, Name, Net, ParameterValue, Repeat};
use crate::Timescale;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};
use crate::json::Recover;
use crate::netlist::{self, Builder, Bus, ScopeId, SignalId};

/// Parameters and indices with their values.
type Values = IndexMap<String, i64>;
/// Makes one copy of a cell or block.
type Make<'m, 'e> = dyn FnMut(&mut Elaboration<'e>, &Name, &mut Values) + 'm;

/// What an instance's port is bound to.
struct Binding {
    width: u32,
    /// The parent's bits, or none if the port is left open.
    bus: Option<Bus>,
    /// Whether faults of its wiring have been told already.
    muted: bool,
}

/// An instance still to be filled.
struct Instance {
    module: ModuleId,
    scope: ScopeId,
    values: Values,
    ports: HashMap<String, Binding>,
    depth: u64,
}

/// One place where cells are made.
struct Here<'a> {
    module: ModuleId,
    scope: ScopeId,
    nets: Nets<'a>,
    depth: u64,
}

pub(super) struct Elaboration<'a> {
    library: &'a Library,
    sources: &'a Sources,
    limits: &'a Limits,
    /// What memories are to hold whatever the files say: their paths, the texts, and whether there is such a memory.
    memories: Vec<(&'a Name, FileId, bool)>,
    /// The paths of all memories.
    memory_paths: Vec<String>,
    builder: Builder,
    diagnostics: Diagnostics,
    places: Places,
    work: Vec<Instance>,
    /// Seconds in a tick.
    tick: f64,
    /// Cells, nets, ports and copies made so far.
    made: u64,
    /// Bits of outputs that are left open, and pieces that connections are made of.
    unnamed: u64,
    overflow: bool,
    /// How many instances of a module had faults of their own.
    faulty: HashMap<ModuleId, u32>,
    filled: HashSet<ModuleId>,
}

/// Copies of a cell, block or module tell the same faults again: after so many that have some, no more are made.
const FAULTY_COPIES: u32 = 8;

/// A netlist, where its parts stand in the files, and what was found wrong.
pub(super) struct Elaborated {
    pub builder: Builder,
    pub places: Places,
    pub diagnostics: Diagnostics,
    pub values: Values,
    /// The modules that there is an instance of.
    pub filled: HashSet<ModuleId>,
}

/// Elaborates a module as the top of a netlist. Faults of wiring are left for [`Builder::finish_with`].
pub(super) fn elaborate(
    library: &Library,
    sources: &Sources,
    limits: &Limits,
    top: ModuleId,
    overrides: &[(Name, ParameterValue)],
    memories: &[(Name, FileId)],
) -> Elaborated {
    let (name, module) = library.module(top);
    let mut builder = Builder::new(name);
    let timescale = library.file(top.file).timescale.as_ref().map_or_else(Timescale::default, |t| t.value.0);
    builder.set_timescale(timescale);
    let tick = timescale.femtoseconds() as f64 / 1e15;
    let mut e = Elaboration {
        library,
        sources,
        limits,
        memories: memories.iter().map(|(name, file)| (name, *file, false)).collect(),
        memory_paths: Vec::new(),
        builder,
        diagnostics: Diagnostics::new(),
        places: Places::default(),
        work: Vec::new(),
        tick,
        made: 0,
        unnamed: 0,
        overflow: false,
        faulty: HashMap::new(),
        filled: HashSet::new(),
    };
    let mut values = IndexMap::new();
    if let Some(module) = module {
        let given: IndexMap<Name, ParameterValue> = overrides.iter().cloned().collect();
        if let Some(v) = e.parameters(name, module, &given, &IndexMap::new()) {
            values = v;
            let scope = e.builder.top();
            e.work.push(Instance { module: top, scope, values: values.clone(), ports: HashMap::new(), depth: 1 });
        }
    }
    while let Some(instance) = e.work.pop() {
        if e.overflow {
            break;
        }
        e.fill(instance);
    }
    e.unknown_memories();
    Elaborated { builder: e.builder, places: e.places, diagnostics: e.diagnostics, values, filled: e.filled }
}

impl<'e> Elaboration<'e> {
    /// The values of a module's parameters, where some are given in terms of the names around the cell.
    fn parameters(
        &mut self,
        of: &Name,
        module: &Module,
        given: &IndexMap<Name, ParameterValue>,
        around: &Values,
    ) -> Option<Values> {
        let mut ok = true;
        for name in given.keys().filter(|n| !module.parameters.contains_key(n.value.as_str())) {
            let names: Vec<&str> = module.parameters.keys().map(|n| n.value.as_str()).collect();
            let fault =
                Diagnostic::new(Code::UnknownParameter, format!("`{}` has no parameter `{}`", of.value, name.value))
                    .at(name.span, "not a parameter")
                    .did_you_mean(name, names.iter().copied());
            self.diagnostics.push(if names.is_empty() {
                fault.note("it has none")
            } else {
                fault.note(format!("it has {}", names.join(", ")))
            });
            ok = false;
        }
        let mut values = IndexMap::new();
        for (name, parameter) in &module.parameters {
            let Some(parameter) = parameter.as_ref() else {
                ok = false;
                continue;
            };
            let (value, span) = match given.get(name.value.as_str()) {
                Some(text) => match text.expr() {
                    Ok(expr) => (eval(&expr, around, &mut self.diagnostics), text.span),
                    Err(d) => {
                        self.diagnostics.push(d);
                        (None, text.span)
                    }
                },
                None => (eval(&parameter.default, &values, &mut self.diagnostics), parameter.default.span()),
            };
            let Some(value) = value else {
                ok = false;
                continue;
            };
            for (bound, word, out) in
                [(&parameter.min, "at least", i64::lt as fn(&i64, &i64) -> bool), (&parameter.max, "at most", i64::gt)]
            {
                let Some(bound) = bound else { continue };
                let Some(limit) = eval(bound, &values, &mut self.diagnostics) else {
                    ok = false;
                    continue;
                };
                if out(&value, &limit) {
                    let fault = Diagnostic::new(
                        Code::BadParameter,
                        format!("`{}` of `{}` must be {word} {limit}, not {value}", name.value, of.value),
                    );
                    self.diagnostics
                        .push(fault.at(span, format!("this is {value}")).also(bound.span(), "the bound is here"));
                    ok = false;
                }
            }
            values.insert(name.value.clone(), value);
        }
        ok.then_some(values)
    }

    /// A width, checked against the limits.
    fn width(&mut self, width: Option<&super::Expr>, name: &Name, values: &Values) -> Option<u32> {
        let Some(expr) = width else { return Some(1) };
        let n = eval(expr, values, &mut self.diagnostics)?;
        if n < 1 {
            self.diagnostics.push(
                Diagnostic::new(Code::BadValue, format!("`{}` has a width of {n} bits", name.value))
                    .at(expr.span(), format!("this is {n}"))
                    .help("a net has at least one bit; `if` leaves a part out"),
            );
            return None;
        }
        if n as u64 > self.limits.width {
            self.diagnostics.push(
                Diagnostic::new(
                    Code::TooLarge,
                    format!("`{}` has a width of {n} bits, the limit is {}", name.value, self.limits.width),
                )
                .at(expr.span(), format!("this is {n}"))
                .help("if you need that, raise the limit: `--limit width=BITS`"),
            );
            return None;
        }
        self.bits(n as u64, name.span).then_some(n as u32)
    }

    /// Whether there is room for so many bits more; tells it if not.
    fn bits(&mut self, more: u64, span: Span) -> bool {
        let room = u64::from(self.builder.bit_count()) + self.unnamed + more <= self.limits.bits;
        if !room {
            self.too_large("bits", "bits of all nets and connections together", self.limits.bits, span);
        }
        room
    }

    /// Counts what is made; whether there is room for it.
    fn make(&mut self, more: usize, span: Span) -> bool {
        self.made += more as u64;
        let room = self.made <= self.limits.cells;
        if !room {
            self.too_large("cells", "cells, nets and copies of the whole circuit", self.limits.cells, span);
        }
        room
    }

    /// Tells that a limit of the whole netlist is passed; nothing more is made.
    fn too_large(&mut self, limit: &str, what: &str, value: u64, span: Span) {
        if !std::mem::replace(&mut self.overflow, true) {
            self.diagnostics.push(
                Diagnostic::new(Code::TooLarge, format!("the circuit passes the limit of {value} {what}"))
                    .at(span, "with this")
                    .help(format!("if you need that, raise the limit: `--limit {limit}=VALUE`")),
            );
        }
    }

    /// Gives the values of a port or net their names.
    fn name_values(&mut self, signal: SignalId, written: &value_names::Written, width: Option<u32>) {
        let names = width.and_then(|width| value_names::read(written, width, &mut self.diagnostics));
        if let Some(names) = names {
            self.builder.set_values(signal, names);
        }
    }

    /// Makes the nets and cells of an instance.
    fn fill(&mut self, instance: Instance) {
        let library = self.library;
        let (_, Some(module)) = library.module(instance.module) else { return };
        let Instance { module: id, scope, values, mut ports, depth } = instance;
        self.filled.insert(id);
        if self.faulty.get(&id).is_some_and(|&n| n >= FAULTY_COPIES) {
            for binding in ports.values().filter_map(|b| b.bus.as_ref()) {
                self.mute_bits(binding);
            }
            return;
        }
        let before = self.diagnostics.errors();
        if !self.make(module.ports.len(), library.module(id).0.span) {
            return;
        }
        let mut own = HashMap::new();
        for (name, port) in &module.ports {
            let Some(port) = port.as_ref() else { continue };
            let bound = ports.remove(name.value.as_str());
            let width = match &bound {
                Some(binding) => Some(binding.width),
                None => self.width(port.width.as_ref(), name, &values),
            };
            let muted = bound.as_ref().is_some_and(|b| b.muted) || width.is_none();
            let place = Place { span: name.span, module: id, port: true, muted };
            let direction = match port.direction.value {
                Direction::Input => netlist::Direction::Input,
                Direction::Output => netlist::Direction::Output,
                Direction::Inout => netlist::Direction::Inout,
            };
            let (signal, bus) = match bound.and_then(|b| b.bus) {
                Some(bus) => (self.builder.alias(scope, name, &bus, port.signed), bus),
                None => self.builder.declare(scope, name, width.unwrap_or(1), port.signed, None),
            };
            self.builder.set_port(signal, direction);
            self.name_values(signal, &port.values, width);
            self.places.signal(signal, place);
            own.insert(name.value.clone(), Declared { signal, bus, span: name.span, faulty: width.is_none() });
        }
        let mut here = Here { module: id, scope, nets: Nets { own, outer: None }, depth };
        let mut values = values;
        self.body(&mut here, &mut values, &module.nets, &module.cells, &module.blocks);
        if self.diagnostics.errors() > before {
            *self.faulty.entry(id).or_default() += 1;
        }
    }

    fn body(
        &mut self,
        here: &mut Here<'_>,
        values: &mut Values,
        nets: &IndexMap<Name, Recover<Net>>,
        cells: &IndexMap<Name, Recover<Cell>>,
        blocks: &IndexMap<Name, Recover<Block>>,
    ) {
        for (name, net) in nets {
            if !self.make(1, name.span) {
                return;
            }
            let net = net.as_ref();
            let width = net.and_then(|n| self.width(n.width.as_ref(), name, values));
            if let Some(other) = here.nets.own.get(name.value.as_str()) {
                let fault = Diagnostic::new(Code::DuplicateName, format!("`{}` is a port already", name.value));
                self.diagnostics.push(fault.at(name.span, "a net needs another name").also(other.span, "the port"));
                continue;
            }
            let (signal, bus) =
                self.builder.declare(here.scope, name, width.unwrap_or(1), net.is_some_and(|n| n.signed), None);
            if let Some(net) = net {
                self.name_values(signal, &net.values, width);
            }
            self.places
                .signal(signal, Place { span: name.span, module: here.module, port: false, muted: width.is_none() });
            here.nets
                .own
                .insert(name.value.clone(), Declared { signal, bus, span: name.span, faulty: width.is_none() });
        }
        for (name, cell) in cells {
            let whole = cell.as_ref().is_some_and(|cell| {
                self.copies(cell.repeat.as_ref(), cell.condition.as_ref(), name, values, &mut |e, name, values| {
                    e.cell(here, values, name, cell)
                })
            });
            if !whole {
                self.mute_here(&here.nets);
            }
        }
        for (name, block) in blocks {
            let Some(block) = block.as_ref() else {
                self.mute_here(&here.nets);
                continue;
            };
            let outer = &*here;
            if outer.depth >= self.limits.depth {
                self.too_large("depth", "modules and blocks inside one another", self.limits.depth, name.span);
                return;
            }
            let whole =
                self.copies(block.repeat.as_ref(), block.condition.as_ref(), name, values, &mut |e, name, values| {
                    let scope = e.builder.scope(outer.scope, name);
                    let nets = Nets { own: HashMap::new(), outer: Some(&outer.nets) };
                    let mut inner = Here { module: outer.module, scope, nets, depth: outer.depth + 1 };
                    e.body(&mut inner, values, &block.nets, &block.cells, &block.blocks);
                });
            if !whole {
                self.mute_here(&here.nets);
            }
        }
    }

    /// Calls `make` for each copy of a cell or block that exists, with its name and the index among the values. Whether
    /// it could be told which those are, and all were made.
    fn copies(
        &mut self,
        repeat: Option<&Repeat>,
        condition: Option<&super::Expr>,
        name: &Name,
        values: &mut Values,
        make: &mut Make<'_, 'e>,
    ) -> bool {
        let exists = |e: &mut Self, values: &Values| {
            condition.map_or(Some(true), |c| eval(c, values, &mut e.diagnostics).map(|n| n != 0))
        };
        let Some(repeat) = repeat else {
            if !self.make(1, name.span) {
                return false;
            }
            let exists = exists(self, values);
            if exists == Some(true) {
                make(self, name, values);
            }
            return exists.is_some();
        };
        let from = repeat.from.as_ref().map_or(Some(0), |e| eval(e, values, &mut self.diagnostics));
        let (Some(from), Some(to)) = (from, eval(&repeat.to, values, &mut self.diagnostics)) else { return false };
        let count = (i128::from(to) - i128::from(from)).max(0);
        if repeat.from.is_none() && to < 0 {
            self.diagnostics.push(
                Diagnostic::new(Code::BadRepeat, format!("`{}` is repeated {to} times", name.value))
                    .at(repeat.to.span(), format!("this is {to}"))
                    .help("0 makes none; a range may begin below 0, as in [-4, 4]"),
            );
            return false;
        }
        if count > i128::from(self.limits.repeat) {
            self.diagnostics.push(
                Diagnostic::new(
                    Code::TooLarge,
                    format!("`{}` is repeated {count} times, the limit is {}", name.value, self.limits.repeat),
                )
                .at(repeat.to.span(), format!("this is {to}"))
                .help("if you need that, raise the limit: `--limit repeat=COUNT`"),
            );
            return false;
        }
        let index = repeat.index.value.as_str();
        if values.contains_key(index) {
            self.diagnostics.push(
                Diagnostic::new(Code::DuplicateName, format!("`{index}` is a parameter or index already"))
                    .at(repeat.index.span, "an index needs another name"),
            );
            return false;
        }
        let (mut whole, mut faulty) = (true, 0);
        for i in from..to {
            if !self.make(1, name.span) {
                whole = false;
                break;
            }
            let before = self.diagnostics.errors();
            values.insert(index.to_owned(), i);
            match exists(self, values) {
                Some(true) => make(self, &Name::new(format!("{}[{i}]", name.value), name.span), values),
                Some(false) => {}
                None => whole = false,
            }
            faulty += u32::from(self.diagnostics.errors() > before);
            if self.overflow || faulty >= FAULTY_COPIES {
                whole = false;
                break;
            }
        }
        values.shift_remove(index);
        whole
    }
}

/// The modules of a file that no other of its modules uses.
pub(super) fn roots(library: &Library, file: usize) -> Vec<ModuleId> {
    let used: HashSet<ModuleId> = library.modules(file).flat_map(|m| library.uses(m)).map(|u| u.0).collect();
    library.modules(file).filter(|m| !used.contains(m)).collect()
}
