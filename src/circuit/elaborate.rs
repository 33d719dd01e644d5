//! Elaboration: a module with its parameters becomes a netlist, its instances and blocks becoming scopes.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use super::library::{Library, ModuleId};
use super::report::{Place, Places};
use super::scope::{Declared, Faulty, Nets, Reader, constant_in, eval, nets_of, s};
use super::{Block, Cell, Direction, Limits, Module, Name, Net, ParameterValue, Repeat, Signal, arguments};
use crate::cell::element::{Arguments, Element};
use crate::cell::{element, elements};
use crate::diag::{Code, Diagnostic, Diagnostics, Span, nearest};
use crate::json::Recover;
use crate::netlist::{self, Builder, Bus, ScopeId};

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
    limits: &'a Limits,
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
    limits: &Limits,
    top: ModuleId,
    overrides: &[(Name, ParameterValue)],
) -> Elaborated {
    let (name, module) = library.module(top);
    let mut builder = Builder::new(name);
    let timescale = library.file(top.file).timescale.as_ref().map_or_else(Default::default, |t| t.value);
    builder.set_timescale(timescale);
    let tick = timescale.femtoseconds() as f64 / 1e15;
    let mut e = Elaboration {
        library,
        limits,
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
                .help("if it is meant to be, raise the limit by `--limit width=BITS`"),
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
                    .help(format!("if it is meant to be, raise the limit by `--limit {limit}=VALUE`")),
            );
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
            let is_top = depth == 1;
            let bound = ports.remove(name.value.as_str());
            let width = match &bound {
                Some(binding) => Some(binding.width),
                None => self.width(port.width.as_ref(), name, &values),
            };
            let muted = bound.as_ref().is_some_and(|b| b.muted) || width.is_none();
            let place = Place { span: name.span, module: id, port: true, muted };
            let (signal, bus) = match bound.and_then(|b| b.bus) {
                Some(bus) => (self.builder.alias(scope, name, &bus, port.signed), bus),
                None => {
                    let direction = match port.direction.value {
                        Direction::Input => netlist::Direction::Input,
                        Direction::Output => netlist::Direction::Output,
                        Direction::Inout => netlist::Direction::Inout,
                    };
                    self.builder.declare(scope, name, width.unwrap_or(1), port.signed, is_top.then_some(direction))
                }
            };
            self.places.signal(signal, place);
            own.insert(name.value.clone(), Declared { signal, bus, span: name.span });
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
            self.places
                .signal(signal, Place { span: name.span, module: here.module, port: false, muted: width.is_none() });
            here.nets.own.insert(name.value.clone(), Declared { signal, bus, span: name.span });
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
                .help("if it is meant to be, raise the limit by `--limit repeat=COUNT`"),
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

    fn cell(&mut self, here: &Here<'_>, values: &Values, name: &Name, cell: &Cell) {
        let library = self.library;
        if let Some(element) = element(&cell.kind) {
            self.element(here, values, name, cell, element);
        } else if let Some(module) = library.find(here.module.file, &cell.kind) {
            self.instance(here, values, name, cell, module);
        } else {
            let names = elements().map(|e| e.name).chain(library.visible(here.module.file));
            let fault =
                Diagnostic::new(Code::UnknownType, format!("there is no element or module `{}` here", cell.kind.value));
            let fault = fault.at(cell.kind.span, "unknown type");
            self.diagnostics.push(if library.misses(here.module.file) {
                fault.did_you_mean(&cell.kind, names).note("it may be in a file that could not be imported")
            } else {
                let fault = fault.did_you_mean(&cell.kind, names);
                match fault.helps.is_empty() {
                    true => {
                        fault.help("the elements are in docs/elements.md; a module of another file needs an `import`")
                    }
                    false => fault,
                }
            });
            self.mute_all(here, cell);
        }
    }

    /// Nothing more is to be told of the nets of a faulty signal.
    fn mute(&mut self, here: &Here<'_>, signal: &Signal) {
        let mut names = Vec::new();
        nets_of(signal, &mut names);
        for name in names {
            // a misspelt name leaves the net alone that was meant
            let net = here.nets.get(name).or_else(|| here.nets.get(nearest(name, here.nets.names())?));
            if let Some(net) = net {
                self.places.mute(net.signal);
                self.mute_bits(&net.bus);
            }
        }
    }

    /// Nor of the nets that some bits are declared as, be it in a module around this one.
    fn mute_bits(&mut self, bus: &Bus) {
        self.builder.owners(bus).into_iter().for_each(|signal| self.places.mute(signal));
    }

    /// Nor of any net that can be seen from a part that could not be made.
    fn mute_here(&mut self, nets: &Nets<'_>) {
        for net in nets.own.values() {
            self.places.mute(net.signal);
            self.mute_bits(&net.bus);
        }
        if let Some(outer) = nets.outer {
            self.mute_here(outer);
        }
    }

    fn mute_all(&mut self, here: &Here<'_>, cell: &Cell) {
        cell.connections.values().for_each(|signal| self.mute(here, signal));
    }

    fn reader<'b>(&'b mut self, here: &'b Here<'_>, values: &'b Values) -> Reader<'b> {
        Reader {
            nets: &here.nets,
            values,
            builder: &mut self.builder,
            diagnostics: &mut self.diagnostics,
            most_bits: self.limits.width,
            most_in_all: self.limits.bits,
        }
    }

    /// Tells of connections to ports that there are not.
    fn check_ports(&mut self, here: &Here<'_>, cell: &Cell, ports: &[&str]) {
        for (port, signal) in &cell.connections {
            if !ports.contains(&port.value.as_str()) {
                let fault =
                    Diagnostic::new(Code::UnknownPort, format!("`{}` has no port `{}`", cell.kind.value, port.value))
                        .at(port.span, "not a port");
                self.diagnostics.push(
                    fault.did_you_mean(port, ports.iter().copied()).note(format!("its ports are {}", ports.join(", "))),
                );
                self.mute(here, signal);
            }
        }
    }

    fn open_port(&mut self, name: &Name, cell: &Cell, port: &str, doc: &str) {
        let fault = Diagnostic::new(Code::UnconnectedPort, format!("`{port}` of `{}` is not connected", base(name)));
        let fault = fault.at(name.span, format!("`{}` needs its `{port}`", cell.kind.value));
        let fault = if doc.is_empty() { fault } else { fault.note(format!("`{port}`: {doc}")) };
        self.diagnostics.push(fault.help("connect it to a net, or to a constant such as \"1'b0\""));
    }

    fn element(&mut self, here: &Here<'_>, values: &Values, name: &Name, cell: &Cell, element: &'static Element) {
        let ports: Vec<&str> = element.ports.iter().map(|p| p.name).collect();
        self.check_ports(here, cell, &ports);
        let arguments =
            arguments::read(element, name, &cell.parameters, values, self.limits.width, &mut self.diagnostics);
        let width = arguments.as_ref().and_then(|a| a.iter().find(|(n, _)| *n == "width"));
        let width = width.map_or(1, |(_, w)| if let crate::cell::Argument::Integer(w) = w { *w as u32 } else { 1 });

        // the inputs of a port that takes several tell how many there are, which the other widths depend on
        let mut inputs = 0;
        let mut several = None;
        let mut faulty = arguments.is_none();
        for port in element.ports.iter().filter(|p| p.several) {
            if let (Some(signal), false) = (cell.connections.get(port.name), faulty) {
                let why = |fault: Diagnostic| because(fault, element, cell, port, width, 0);
                match self.reader(here, values).several(port, signal, width, &why) {
                    Ok((bus, n)) => {
                        inputs = n;
                        several = Some(bus);
                    }
                    Err(Faulty) => {
                        faulty = true;
                        self.mute(here, signal);
                    }
                }
            }
        }
        for port in element.ports.iter().filter(|p| p.required && !cell.connections.contains_key(p.name)) {
            self.open_port(name, cell, port.name, port.doc);
            faulty |= port.several;
        }
        let kind = match arguments {
            Some(values) if !faulty => (element.build)(&Arguments { values, inputs, tick: self.tick }).map_err(|why| {
                let place = element.ports.iter().find(|p| p.several).and_then(|p| cell.connections.get(p.name));
                let place = place.map_or(cell.kind.span, Signal::span);
                self.diagnostics.push(Diagnostic::new(Code::BadParameter, why).at(place, ""));
            }),
            _ => Err(()),
        };
        let Ok(kind) = kind else {
            self.mute_all(here, cell);
            return;
        };
        let mut pins = (vec![Bus::default(); kind.inputs().len()], vec![Bus::default(); kind.outputs().len()]);
        for port in element.ports {
            let Some(signal) = cell.connections.get(port.name) else { continue };
            let (expected, slot) = if port.output {
                let pin = kind
                    .outputs()
                    .iter()
                    .position(|&n| n == port.pin)
                    .expect("an element's ports are pins of its cell");
                (kind.output_width(pin), &mut pins.1[pin])
            } else {
                let pin = kind
                    .inputs()
                    .iter()
                    .position(|p| p.name == port.pin)
                    .expect("an element's ports are pins of its cell");
                (kind.input_width(pin), &mut pins.0[pin])
            };
            if port.several {
                *slot = several.take().unwrap_or_default();
                continue;
            }
            let why = |fault: Diagnostic| because(fault, element, cell, port, expected, inputs);
            if let Some(bus) = self.connect(here, values, &cell.kind, port.name, port.output, signal, expected, &why) {
                *slot = bus;
            }
        }
        let pieces: usize = pins.0.iter().chain(&pins.1).map(Bus::pieces).sum();
        let open = (0..pins.1.len()).filter(|&k| pins.1[k].width() == 0).map(|k| u64::from(kind.output_width(k)));
        let more = pieces as u64 + open.sum::<u64>();
        if !self.bits(more, name.span) {
            return;
        }
        self.unnamed += more;
        let id = self.builder.cell(here.scope, name, kind, pins.0, pins.1);
        self.places.cell(id, Place { span: name.span, module: here.module, port: false, muted: false });
    }

    /// The bits that a port is connected to, if they are as many as it has.
    #[allow(clippy::too_many_arguments)]
    fn connect(
        &mut self,
        here: &Here<'_>,
        values: &Values,
        kind: &Name,
        port: &str,
        output: bool,
        signal: &Signal,
        expected: u32,
        why: &dyn Fn(Diagnostic) -> Diagnostic,
    ) -> Option<Bus> {
        let bus = self.reader(here, values).bus(signal, Some(expected));
        let Ok(bus) = bus else {
            self.mute(here, signal);
            return None;
        };
        let found = bus.width();
        if found != expected {
            let fault = Diagnostic::new(
                Code::WidthMismatch,
                format!(
                    "`{port}` of `{}` is {expected} bit{} wide, but this signal is {found}",
                    kind.value,
                    s(expected)
                ),
            );
            let fault = fault.at(signal.span(), format!("{found} bit{}", s(found)));
            let fault = self.reader(here, values).where_from(signal, fault);
            self.diagnostics.push(why(match as_wide(signal, found, expected, output) {
                Some(help) => fault.help(help),
                None => fault,
            }));
            self.mute(here, signal);
            return None;
        }
        if output && let Some(span) = constant_in(signal) {
            self.diagnostics.push(
                Diagnostic::new(
                    Code::BadSignal,
                    format!("`{port}` of `{}` is an output and cannot drive a constant", kind.value),
                )
                .at(span, "a constant"),
            );
            return None;
        }
        Some(bus)
    }

    fn instance(&mut self, here: &Here<'_>, values: &Values, name: &Name, cell: &Cell, module: ModuleId) {
        let library = self.library;
        let (module_name, Some(body)) = library.module(module) else {
            self.mute_all(here, cell);
            return;
        };
        let ports: Vec<&str> = body.ports.keys().map(|n| n.value.as_str()).collect();
        self.check_ports(here, cell, &ports);
        let Some(inner) = self.parameters(module_name, body, &cell.parameters, values) else {
            self.mute_all(here, cell);
            return;
        };
        if here.depth >= self.limits.depth {
            self.too_large("depth", "modules and blocks inside one another", self.limits.depth, name.span);
            return;
        }
        let mut bound = HashMap::new();
        for (port_name, port) in &body.ports {
            let Some(port) = port.as_ref() else { continue };
            let signal = cell.connections.get(port_name.value.as_str());
            let Some(width) = self.width(port.width.as_ref(), port_name, &inner) else {
                if let Some(signal) = signal {
                    self.mute(here, signal);
                }
                continue;
            };
            let output = port.direction.value == Direction::Output;
            let why = |fault: Diagnostic| {
                fault.also(port_name.span, format!("the port is declared here with {width} bit{}", s(width)))
            };
            let bus = signal
                .and_then(|signal| self.connect(here, values, &cell.kind, port_name, output, signal, width, &why));
            if signal.is_none() && port.direction.value == Direction::Input {
                self.open_port(name, cell, port_name, port.doc.as_deref().unwrap_or_default());
            }
            let muted = bus.is_none();
            bound.insert(port_name.value.clone(), Binding { width, bus, muted });
        }
        let scope = self.builder.scope(here.scope, name);
        self.work.push(Instance { module, scope, values: inner, ports: bound, depth: here.depth + 1 });
    }
}

/// How a signal can be made as wide as a port.
fn as_wide(signal: &Signal, found: u32, expected: u32, output: bool) -> Option<String> {
    let (more, top) = (expected.saturating_sub(found), found - 1);
    match signal {
        Signal::Name { name, .. } if found > expected => {
            let part = if expected == 1 { "0".to_owned() } else { format!("{}:0", expected - 1) };
            Some(format!("take part of it, as in \"{name}[{part}]\""))
        }
        Signal::Name { name, .. } if !output => {
            let sign = if found == 1 { name.to_string() } else { format!("{name}[{top}]") };
            Some(format!(
                "extend it: [\"{more}'d0\", \"{name}\"] with zeros, [\"{more}{{{sign}}}\", \"{name}\"] with its sign"
            ))
        }
        Signal::Concat { .. } if found < expected && !output => {
            Some(format!("extend it by zeros at the front: [\"{more}'d0\", …]"))
        }
        _ => None,
    }
}

/// Adds why a port of an element is as wide as it is.
fn because(
    fault: Diagnostic,
    element: &Element,
    cell: &Cell,
    port: &element::Port,
    expected: u32,
    inputs: u32,
) -> Diagnostic {
    let bits = format!("`{}` has {expected} bit{}", port.name, s(expected));
    let own = format!("{}_width", port.name);
    let parameter = element.parameters.iter().find(|p| {
        let named = p.doc.contains(&format!("`{}`", port.name))
            || ((port.several || port.name == "a") && p.doc.contains("each input"));
        p.name == own || (p.name == "width" && named)
    });
    let Some(parameter) = parameter else {
        return match inputs {
            0 => fault.note(bits),
            _ => fault.note(format!("{bits} for {inputs} inputs")),
        };
    };
    match cell.parameters.get(parameter.name) {
        Some(given) => fault.also(given.span, format!("{bits} because of this `{}`", parameter.name)),
        None => fault
            .note(format!("{bits} because `{}` is not given, which makes it {expected}", parameter.name))
            .help(format!("or give the cell \"parameters\": {{ \"{}\": … }}", parameter.name)),
    }
}

/// A cell's name as the file has it, without the index of its copy.
fn base(name: &Name) -> &str {
    name.value.split('[').next().unwrap_or(&name.value)
}

/// The modules of a file that no other of its modules uses.
pub(super) fn roots(library: &Library, file: usize) -> Vec<ModuleId> {
    let used: HashSet<ModuleId> = library.modules(file).flat_map(|m| library.uses(m)).map(|u| u.0).collect();
    library.modules(file).filter(|m| !used.contains(m)).collect()
}
