//! One cell: its type, its parameters, what its ports are connected to.

use std::collections::HashMap;

use super::super::library::ModuleId;
use super::super::report::Place;
use super::super::scope::{Faulty, Nets, Reader, constant_in, nets_of, s};
use super::super::{Cell, Direction, Name, Signal, arguments};
use super::{Binding, Elaboration, Here, Instance, Values};
use crate::cell::element::{Arguments, Element, Port};
use crate::cell::{CellKind, element, elements};
use crate::diag::{Code, Diagnostic, nearest};
use crate::netlist::Bus;

impl Elaboration<'_> {
    pub(super) fn cell(&mut self, here: &Here<'_>, values: &Values, name: &Name, cell: &Cell) {
        if self.overflow {
            return;
        }
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
    pub(super) fn mute_bits(&mut self, bus: &Bus) {
        self.builder.owners(bus).into_iter().for_each(|signal| self.places.mute(signal));
    }

    /// Nor of any net that can be seen from a part that could not be made.
    pub(super) fn mute_here(&mut self, nets: &Nets<'_>) {
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
        let text = |name: &str| {
            let file = self.library.contents(here.module.file, name)?;
            Some((file, self.sources.text(file)))
        };
        let context = arguments::Context { values, limits: self.limits, text: &text };
        let arguments = arguments::read(element, name, &cell.parameters, &context, &mut self.diagnostics);
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
        let Ok(mut kind) = kind else {
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
        let mut more = pieces as u64 + open.sum::<u64>();
        if let CellKind::Memory(memory) = &kind {
            more += u64::from(memory.size) * u64::from(memory.width);
        }
        if !self.bits(more, name.span) {
            return;
        }
        self.unnamed += more;
        if matches!(kind, CellKind::Memory(_)) {
            self.memory(here, name, &mut kind, &mut pins.0);
        }
        let id = self.builder.cell(here.scope, name, kind, pins.0, pins.1);
        self.builder.drawn_as(id, element.name);
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
        let scope = self.builder.instance(here.scope, name, module_name);
        self.builder.set_parameters(scope, inner.clone());
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
fn because(fault: Diagnostic, element: &Element, cell: &Cell, port: &Port, expected: u32, inputs: u32) -> Diagnostic {
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
