//! What is wrong or doubtful in the netlist that a file makes.

use super::Origins;
use crate::cell::CellKind;
use crate::diag::{Code, Diagnostic, Diagnostics, Sources};
use crate::netlist::{CellId, Direction, Driver, Fault, Netlist, SignalId};

/// How many loops and floating nets are told.
const TOLD: usize = 100;

/// Tells all that the netlist shows.
pub(crate) fn report(
    netlist: &Netlist,
    origins: &Origins,
    faults: &[Fault],
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) {
    let report = Report { netlist, origins, sources };
    for fault in faults {
        diagnostics.extend(report.fault(fault));
    }
    diagnostics.extend(report.shorted());
    diagnostics.extend(report.floating());
    diagnostics.extend(report.loops());
}

struct Report<'r> {
    netlist: &'r Netlist,
    origins: &'r Origins,
    sources: &'r Sources,
}

impl Report<'_> {
    /// A place in the file, and what it comes from.
    fn at(&self, diagnostic: Diagnostic, cell: CellId, text: &str) -> Diagnostic {
        let Some(span) = self.origins.of_cell(cell) else { return diagnostic };
        let diagnostic = diagnostic.at(span, text);
        match self.origins.source(cell, self.sources) {
            Some(source) => diagnostic.note(format!("`{}` comes from {source}", self.netlist.cell(cell).name)),
            None => diagnostic,
        }
    }

    fn fault(&self, fault: &Fault) -> Option<Diagnostic> {
        let (cell, message) = match *fault {
            Fault::Width { cell, pin, expected, found } => (cell, format!("`{pin}` has {found} bits, not {expected}")),
            Fault::Open { cell, pin } => (cell, format!("`{pin}` is not connected")),
            // several drivers resolve, and what nothing drives floats
            _ => return None,
        };
        let message = format!("`{}` does not fit together: {message}", self.netlist.cell_path(cell));
        Some(self.at(Diagnostic::new(Code::UnsupportedCell, message), cell, "this cell"))
    }

    /// Inputs of the circuit that are one net: a module between them hands its input through, and the file, in which a
    /// bit is one wire whatever its direction, no longer tells them apart.
    fn shorted(&self) -> Vec<Diagnostic> {
        let netlist = self.netlist;
        let mut list: Vec<Diagnostic> = Vec::new();
        for cell in netlist.cell_ids().filter(|&c| matches!(netlist.cell(c).kind, CellKind::Resolve { .. })) {
            let inputs = netlist.input(cell, 0).iter().filter_map(|s| match netlist.net(s.net).driver {
                Driver::Input(signal) if netlist.signal(signal).port == Some(Direction::Input) => Some(signal),
                _ => None,
            });
            let inputs: Vec<SignalId> = inputs.collect();
            let [first, .., last] = inputs[..] else { continue };
            if list.len() >= TOLD {
                break;
            }
            let [a, b] = [first, last].map(|s| &netlist.signal(s).name);
            let message = if a == b {
                format!("bits of the input `{a}` are one net: something hands one of them through to the other")
            } else {
                format!("the inputs `{a}` and `{b}` are one net: something hands one of them through to the other")
            };
            let fault = Diagnostic::new(Code::SeveralDrivers, message);
            let fault = self.origins.of_signal(last).map_or(fault.clone(), |span| fault.at(span, "this input"));
            list.push(fault.help(
                "drive the net that both reach by one of them, or keep them apart by a cell: `(* keep *)` a buffer, or `a & 1'b1`",
            ));
        }
        list
    }

    /// Nets that are read and that nothing drives.
    fn floating(&self) -> Vec<Diagnostic> {
        let netlist = self.netlist;
        let is_tie =
            |c: &CellId| netlist.cell(*c).name == "undriven" && matches!(netlist.cell(*c).kind, CellKind::Constant(_));
        let ties: Vec<CellId> = netlist.cell_ids().filter(is_tie).collect();
        if ties.is_empty() {
            return Vec::new();
        }
        let mut floats = vec![false; netlist.nets().len()];
        ties.iter().for_each(|&c| floats[netlist.output(c, 0).index()] = true);
        // the bits of such nets that something reads
        let mut read = std::collections::HashSet::new();
        for cell in netlist.cell_ids() {
            for pin in 0..netlist.cell(cell).kind.inputs().len() {
                for s in netlist.input(cell, pin).iter().filter(|s| floats[s.net.index()]) {
                    read.extend((s.lo..s.lo + s.width).map(|bit| (s.net, bit)));
                }
            }
        }
        let is_read = |s: &crate::netlist::Slice| (s.lo..s.lo + s.width).any(|bit| read.contains(&(s.net, bit)));
        let mut told = std::collections::HashSet::new();
        let mut list = Vec::new();
        for id in netlist.signal_ids().filter(|&id| !netlist.signal(id).hidden) {
            let floating: Vec<_> = netlist.bits(id).iter().filter(|s| floats[s.net.index()] && is_read(s)).collect();
            if floating.is_empty() || !told.insert(netlist.bits(id)) || list.len() >= TOLD {
                continue;
            }
            let whole = floating.len() == netlist.bits(id).len();
            let what = if whole { "nothing drives" } else { "nothing drives some bits of" };
            let fault =
                Diagnostic::new(Code::FloatingNet, format!("{what} `{}`, which is read", netlist.signal_path(id)));
            list.extend(self.origins.of_signal(id).map(|span| fault.at(span, "it is z")));
        }
        list
    }

    fn loops(&self) -> Vec<Diagnostic> {
        const SHOWN: usize = 12;
        let mut list = Vec::new();
        for found in self.netlist.loops().iter().take(TOLD) {
            let mut path: Vec<String> = found.cells.iter().take(SHOWN).map(|&c| self.netlist.cell_path(c)).collect();
            if found.cells.len() > SHOWN {
                path.push(format!("({} more)", found.cells.len() - SHOWN));
            }
            path.push(path[0].clone());
            let message = format!("cells feed back without a clock: {}", path.join(" → "));
            list.push(self.at(
                Diagnostic::new(Code::CombinationalLoop, message),
                found.cells[0],
                "this cell reads itself",
            ));
        }
        list
    }
}
