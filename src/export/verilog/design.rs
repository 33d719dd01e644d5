//! A whole design: every module, one after the other, and the modules that the cells need.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::names::{Taken, identifier};
use super::writer::Writer;
use super::{feedback, start, storage};
use crate::netlist::Netlist;
use crate::netlist::hierarchy::{Hierarchy, Piece};
use crate::scenario::Scenario;

/// A netlist as Verilog, and what is called how in it.
#[derive(Debug)]
pub struct Design<'n> {
    pub(super) netlist: &'n Netlist,
    text: String,
    pub(super) hierarchy: Hierarchy,
    /// The identifiers of the modules.
    pub(super) modules: Vec<String>,
    pub(super) names: Vec<Identifiers>,
}

impl<'n> Design<'n> {
    /// Writes a netlist, whose inputs begin with 0.
    #[must_use]
    pub fn of(netlist: &'n Netlist) -> Design<'n> {
        written(netlist, None)
    }

    /// Writes a netlist to which this will happen.
    #[must_use]
    pub fn under(netlist: &'n Netlist, scenario: &Scenario) -> Design<'n> {
        written(netlist, Some(scenario))
    }

    /// The file.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The identifiers in one module.
#[derive(Debug)]
pub(super) struct Identifiers {
    pub wires: Vec<String>,
    pub blocks: Vec<String>,
    pub instances: Vec<String>,
}

fn written<'n>(netlist: &'n Netlist, scenario: Option<&Scenario>) -> Design<'n> {
    let hierarchy = Hierarchy::of(netlist);
    let mut used = BTreeSet::new();
    let mut names = Taken::default();
    let modules: Vec<String> =
        hierarchy.modules().iter().map(|m| names.fresh(&[0], &super::names::readable(&m.name))).collect();
    let circular = feedback::wires(netlist, &hierarchy);
    let clocks = storage::clocks(netlist);
    let waiting = start::waiting(netlist, &hierarchy, scenario);
    let mut identifiers = Vec::new();
    let bodies: Vec<String> = (0..modules.len())
        .map(|m| {
            let mut writer = Writer::new(netlist, &hierarchy, &modules, &clocks, m);
            writer.circular.clone_from(&circular[m]);
            // bits of a vector that show another of its bits are a circle to Verilator, which takes vectors whole
            for (w, wire) in writer.module.wires.iter().enumerate() {
                let own = |piece: &Piece| matches!(piece, Piece::Wire { wire, .. } if *wire == w);
                writer.circular[w] |= wire.shown_of_others(w).iter().any(|(_, run)| run.iter().any(own));
            }
            writer.waits = waiting[m];
            writer.module();
            used.append(&mut writer.support);
            let Writer { wires, blocks, instances, text, .. } = writer;
            identifiers.push(Identifiers { wires, blocks, instances });
            text
        })
        .collect();
    let mut text =
        format!("// {}: written by discreta {}\n", crate::safe::name(names_of(&modules)), env!("CARGO_PKG_VERSION"));
    text += "\n/* verilator lint_off DECLFILENAME */ // all modules are in this file\n";
    let _ = writeln!(text, "`timescale {0} / {0}", bench_timescale(netlist));
    for body in bodies {
        text.push('\n');
        text += &body;
    }
    if ["discreta_register", "discreta_edge_register", "discreta_counter"].iter().any(|m| used.contains(m)) {
        used.insert(STARTED);
    }
    for module in used {
        let text_of =
            support(module).trim_end().replace("ROUNDS = 4", &format!("ROUNDS = {}", start::rounds(netlist) - 2));
        let _ = write!(text, "\n{text_of}\n");
    }
    let modules = modules.iter().map(|m| identifier(m)).collect();
    Design { netlist, text, hierarchy, modules, names: identifiers }
}

fn names_of(modules: &[String]) -> &str {
    modules.first().map_or("", String::as_str)
}

pub(super) fn bench_timescale(netlist: &Netlist) -> String {
    netlist.timescale().to_string()
}

/// The module that says when the circuit has first settled.
pub(super) const STARTED: &str = "discreta_started";

/// A module of `support.v`.
fn support(name: &str) -> &'static str {
    let all = include_str!("support.v");
    let mut parts = all.split("\n\n\n").map(str::trim_start);
    parts.find(|part| part.contains(&format!("module {name} "))).unwrap_or_default()
}
