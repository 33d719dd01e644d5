//! Netlists written as Yosys' `write_json` writes them, for Yosys and what reads its netlists.
//!
//! Every cell becomes cells of Yosys that give the same for all four values (`cells`, `storage`); what Yosys has no cell
//! for is an instance of a module with an attribute by which the reader next door knows it again (`own`). So a file that
//! is read back is the circuit that was written. `docs/export.md` says what it looks like.

mod body;
mod cells;
mod draw;
mod memory;
mod model;
mod own;
mod storage;

use indexmap::IndexMap;

use own::Owns;

use crate::Timescale;
use crate::netlist::{CellId, Hierarchy, Netlist};

/// What goes into the file beside the netlist.
#[derive(Default)]
pub struct Extra<'a> {
    /// Where cells come from: `line.json:12.3-12.40`.
    pub source: Option<&'a dyn Fn(CellId) -> Option<String>>,
    /// The parameters that the circuit was made with.
    pub parameters: IndexMap<String, i64>,
    /// The circuit's default scenario, as JSON.
    pub simulation: Option<String>,
}

/// The text of a Yosys netlist.
///
/// ```
/// let circuit = discreta::circuit::load("circuits/evaluation/line.json")?;
/// let text = discreta::export::yosys::write(&circuit.netlist, &Default::default());
/// assert!(text.contains("\"$aldff"));
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
#[must_use]
pub fn write(netlist: &Netlist, extra: &Extra<'_>) -> String {
    let hierarchy = Hierarchy::of(netlist);
    let mut owns = Owns::default();
    owns.taken.extend(hierarchy.modules().iter().map(|m| m.name.clone()));
    let places = 0..hierarchy.modules().len();
    let draw = |at| body::module(netlist, &hierarchy, at, &mut owns, extra);
    let mut modules: Vec<model::Module> = places.map(draw).collect();
    let top = &mut modules[0].attributes;
    if netlist.timescale() != Timescale::default() {
        top.push(("discreta_timescale", netlist.timescale().to_string()));
    }
    if !extra.parameters.is_empty() {
        let list: Vec<String> = extra.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        top.push(("discreta_parameters", list.join(" ")));
    }
    if let Some(simulation) = &extra.simulation {
        top.push(("discreta_simulation", simulation.clone()));
    }
    modules.extend(owns.modules.into_iter().map(|m| m.0));
    model::text(&modules)
}

/// What Yosys has for an attribute that is set.
fn flag() -> String {
    format!("{:032b}", 1)
}
