//! `discreta export --to yosys-json` and `--to dot`: what goes with a netlist into a file.

use std::path::Path;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use crate::circuit::{Circuit, Loader};
use crate::cli::args::Assignment;
use crate::cli::prepare::{circuit_of, is_scenario};
use crate::diag::Sources;
use crate::export::yosys::{self, Extra};
use crate::netlist::CellId;

type Names = IndexMap<String, Json>;

/// The Yosys netlist of what `path` names, with its default scenario or that of the scenario file.
pub(super) fn yosys_json(loader: &mut Loader, path: &Path, parameters: &[Assignment]) -> Option<String> {
    // of a faulty circuit only a part may be there
    let circuit = circuit_of(loader, path, parameters).filter(|_| !loader.diagnostics.has_errors())?;
    let base = circuit.simulation_span.map(|span| loader.sources.slice(span).to_owned());
    let own = if is_scenario(loader, path) {
        loader.read(path).ok().and_then(|file| own_scenario(loader.sources.text(file)))
    } else {
        None
    };
    let simulation = merged(base.as_deref(), own);
    let source = |cell: CellId| source(&circuit, &loader.sources, cell);
    let extra = Extra { source: Some(&source), parameters: circuit.parameters.clone(), simulation };
    Some(yosys::write(&circuit.netlist, &extra))
}

/// Where a cell comes from: in the source that another tool read, or in the circuit file.
fn source(circuit: &Circuit, sources: &Sources, cell: CellId) -> Option<String> {
    if let Some(known) = circuit.cell_source(cell, sources) {
        return Some(known.to_owned());
    }
    let place = circuit.cell_place(cell)?;
    let (line, column) = sources.line_col(place);
    Some(format!("{}:{line}.{column}", sources.name(place.file)))
}

/// A scenario as it is written. Of what is in order, as clocks are, the order is kept.
#[derive(Deserialize, Serialize, Default)]
struct Written {
    #[serde(default, skip_serializing_if = "Names::is_empty")]
    clocks: Names,
    #[serde(default, skip_serializing_if = "Names::is_empty")]
    inputs: Names,
    #[serde(default, skip_serializing_if = "Names::is_empty")]
    checks: Names,
    #[serde(flatten)]
    rest: Names,
}

/// What a scenario file says happens.
fn own_scenario(text: &str) -> Option<Written> {
    #[derive(Deserialize)]
    struct File {
        simulation: Option<Written>,
    }
    serde_json::from_str::<File>(text).ok()?.simulation
}

/// One scenario over another, as `run` puts them: field by field, `inputs`, `clocks` and `checks` name by name.
fn merged(base: Option<&str>, own: Option<Written>) -> Option<String> {
    if base.is_none() && own.is_none() {
        return None;
    }
    let mut all: Written = base.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    if let Some(own) = own {
        all.clocks.retain(|name, _| !own.inputs.contains_key(name));
        all.inputs.retain(|name, _| !own.clocks.contains_key(name));
        all.clocks.extend(own.clocks);
        all.inputs.extend(own.inputs);
        all.checks.extend(own.checks);
        all.rest.extend(own.rest);
    }
    all.rest.shift_remove("doc");
    serde_json::to_string(&all).ok()
}
