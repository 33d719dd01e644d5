//! What the netlist finds wrong, told in terms of the file.

use std::collections::HashMap;

use super::library::{Library, ModuleId};
use super::scope::s;
use crate::cell::CellKind;
use crate::diag::{Code, Diagnostic, Diagnostics, Severity, Span};
use crate::netlist::{CellId, Driver, Fault, Netlist, SignalId};

/// Where a net or cell stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub span: Span,
    pub module: ModuleId,
    /// Whether it is a port.
    pub port: bool,
    /// Whether faults that concern it have been told.
    pub muted: bool,
}

/// Where everything stands.
#[derive(Default, Debug)]
pub(super) struct Places {
    cells: HashMap<CellId, Place>,
    signals: HashMap<SignalId, Place>,
}

impl Places {
    pub fn cell(&mut self, id: CellId, place: Place) {
        self.cells.insert(id, place);
    }

    pub fn signal(&mut self, id: SignalId, place: Place) {
        self.signals.insert(id, place);
    }

    /// Where a signal is declared.
    pub fn of(&self, id: SignalId) -> Option<Span> {
        self.signals.get(&id).map(|p| p.span)
    }

    /// Where a cell stands.
    pub fn of_cell(&self, id: CellId) -> Option<Span> {
        self.cells.get(&id).map(|p| p.span)
    }

    pub fn mute(&mut self, id: SignalId) {
        if let Some(place) = self.signals.get_mut(&id) {
            place.muted = true;
        }
    }
}

pub(super) struct Report<'a> {
    pub library: &'a Library,
    pub netlist: &'a Netlist,
    pub places: &'a Places,
    pub diagnostics: &'a mut Diagnostics,
}

impl Report<'_> {
    /// Everything that can be told from the netlist.
    pub fn all(&mut self, faults: &[Fault]) {
        let clocked = self.clock_pins();
        for fault in faults {
            self.fault(fault, &clocked);
        }
        self.constant_clocks(&clocked);
        self.loops();
    }

    fn allowed(&self, module: ModuleId, code: Code) -> bool {
        let (_, module) = self.library.module(module);
        code.severity() == Severity::Warning && module.is_some_and(|m| m.allow.iter().any(|a| a.value == code.as_str()))
    }

    fn fault(&mut self, fault: &Fault, clocked: &[(CellId, CellId)]) {
        match fault {
            Fault::SeveralDrivers { signal, bit, drivers } => {
                let Some(place) = self.places.signals.get(signal) else { return };
                let signal = self.netlist.signal(*signal);
                let name = bits(&signal.name, signal.width, *bit, 1);
                let mut d = Diagnostic::new(Code::SeveralDrivers, format!("`{name}` has {} drivers", drivers.len()));
                for (i, driver) in drivers.iter().enumerate() {
                    let (span, text) = match driver {
                        Driver::Cell(cell, pin) => match self.places.cells.get(cell) {
                            Some(p) => (
                                p.span,
                                format!(
                                    "`{}` of `{}`",
                                    self.netlist.cell(*cell).kind.outputs()[*pin as usize],
                                    self.netlist.cell_path(*cell)
                                ),
                            ),
                            None => continue,
                        },
                        Driver::Input(input) => match self.places.signals.get(input) {
                            Some(p) => (p.span, format!("the input `{}`", self.netlist.signal(*input).name)),
                            None => continue,
                        },
                    };
                    d = if i == 0 { d.at(span, text) } else { d.also(span, text) };
                }
                let told = d.labels.iter().any(|l| l.span == place.span);
                let d = if told { d } else { d.also(place.span, "the net") };
                self.diagnostics.push(d.help("keep one of them; only `tristate` cells may share a net"));
            }
            Fault::Undriven { signal: id, lo, width } => {
                let Some(place) = self.places.signals.get(id).filter(|p| !p.muted) else { return };
                let signal = self.netlist.signal(*id);
                let name = bits(&signal.name, signal.width, *lo, *width);
                let clocks = clocked.iter().find(|(_, source)| self.drives(*source, *id));
                let d = match clocks {
                    Some((cell, _)) => {
                        let d = Diagnostic::new(
                            Code::UndrivenClock,
                            format!("nothing drives `{name}`, the clock of `{}`", self.netlist.cell_path(*cell)),
                        );
                        let d = d.at(place.span, "declared here, driven nowhere");
                        match self.places.cells.get(cell) {
                            Some(cell) => d.also(cell.span, "clocked by it"),
                            None => d,
                        }
                    }
                    None => Diagnostic::new(Code::Undriven, format!("nothing drives `{name}`"))
                        .at(place.span, "declared here, driven nowhere"),
                };
                let output = signal.port.is_some() || place.port;
                self.diagnostics.push(d.help(if output {
                    "connect an output of a cell to this port"
                } else {
                    "connect an output of a cell to it"
                }));
            }
            Fault::Unread { signal: id, driven } => {
                let Some(place) = self.places.signals.get(id).filter(|p| !p.muted && !p.port) else { return };
                if self.allowed(place.module, Code::UnusedNet) {
                    return;
                }
                let name = &self.netlist.signal(*id).name;
                let (what, help) = if *driven {
                    ("nothing reads", "an output that is not needed can be left open")
                } else {
                    ("nothing uses", "remove it")
                };
                self.diagnostics
                    .push(Diagnostic::new(Code::UnusedNet, format!("{what} `{name}`")).at(place.span, "").help(help));
            }
            // told already, with the place of the connection, before the netlist was built
            Fault::Width { .. } | Fault::Open { .. } | Fault::DrivenConstant { .. } | Fault::SurplusPins { .. } => {}
        }
    }

    /// Whether a cell is what ties the undriven bits of a signal.
    fn drives(&self, cell: CellId, signal: SignalId) -> bool {
        self.netlist.bits(signal).iter().any(|s| self.netlist.net(s.net).driver == Driver::Cell(cell, 0))
    }

    /// Clocked cells with the constant that, through buffers and inverters, is their clock.
    fn clock_pins(&self) -> Vec<(CellId, CellId)> {
        let source = |cell| match self.netlist.net(self.netlist.clock_sources(cell).next()?.0.net).driver {
            Driver::Cell(source, _) => Some((cell, source)),
            Driver::Input(_) => None,
        };
        let constant =
            |&(_, source): &(CellId, CellId)| matches!(self.netlist.cell(source).kind, CellKind::Constant(_));
        self.netlist.cell_ids().filter_map(source).filter(constant).collect()
    }

    fn constant_clocks(&mut self, clocked: &[(CellId, CellId)]) {
        for &(cell, source) in clocked {
            // what ties undriven bits is told as such
            let CellKind::Constant(value) = &self.netlist.cell(source).kind else { continue };
            if self.netlist.cell(source).name == "undriven" {
                continue;
            }
            if let Some(place) = self.places.cells.get(&cell) {
                let d = Diagnostic::new(
                    Code::UndrivenClock,
                    format!("the clock of `{}` is the constant {value}", self.netlist.cell_path(cell)),
                );
                self.diagnostics
                    .push(d.at(place.span, "it can never change").help("connect `clk` to a net that changes"));
            }
        }
    }

    fn loops(&mut self) {
        for found in self.netlist.loops() {
            let places: Vec<_> = found.cells.iter().map(|c| self.places.cells.get(c)).collect();
            if places.iter().flatten().any(|p| self.allowed(p.module, Code::CombinationalLoop)) {
                continue;
            }
            const SHOWN: usize = 12;
            let mut path: Vec<String> = found.cells.iter().take(SHOWN).map(|&c| self.netlist.cell_path(c)).collect();
            if found.cells.len() > SHOWN {
                path.push(format!("({} more)", found.cells.len() - SHOWN));
            }
            path.push(path[0].clone());
            let n = found.cells.len() as u32;
            let mut d = Diagnostic::new(
                Code::CombinationalLoop,
                format!(
                    "{n} cell{} feed{} back without a clock: {}",
                    s(n),
                    if n == 1 { "s" } else { "" },
                    path.join(" → ")
                ),
            );
            for (i, place) in places.iter().take(4).enumerate() {
                if let Some(place) = place {
                    let text = if i == 0 { "this cell reads itself through the others" } else { "through this one" };
                    d = if i == 0 { d.at(place.span, text) } else { d.also(place.span, text) };
                }
            }
            self.diagnostics.push(d.help("if you mean it, say so in the module: \"allow\": [\"combinational-loop\"]"));
        }
    }
}

/// `name`, `name[3]` or `name[7:4]`.
fn bits(name: &str, of: u32, lo: u32, width: u32) -> String {
    match width {
        _ if width == of => name.to_owned(),
        1 => format!("{name}[{lo}]"),
        _ => format!("{name}[{}:{lo}]", lo + width - 1),
    }
}
