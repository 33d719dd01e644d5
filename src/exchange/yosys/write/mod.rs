//! Netlists written as Yosys' `write_json` writes them, for Yosys and what reads its netlists.
//!
//! Every cell becomes cells of Yosys that give the same for all four values (`cells`, `storage`); what Yosys has no cell
//! for is an instance of a module with an attribute by which the reader next door knows it again (`own`). So a file that
//! is read back is the circuit that was written. `docs/export.md` says what it looks like.

mod body;
mod cells;
mod draw;
mod model;
mod own;
mod storage;

use indexmap::IndexMap;

use body::{Body, BodyCell, BodyNet, BodyPort};
use model::{Bit, Bits};
use own::Owns;

use crate::cell::CellKind;
use crate::netlist::{CellId, Driver, NetId, Netlist, ScopeId, Slice};
use crate::timescale::Timescale;

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
/// let text = discreta::exchange::yosys::write(&circuit.netlist, &Default::default());
/// assert!(text.contains("\"$aldff"));
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
#[must_use]
pub fn write(netlist: &Netlist, extra: &Extra<'_>) -> String {
    let mut owns = Owns::default();
    let bodies = vec![flat(netlist, extra)];
    owns.taken.extend(bodies.iter().map(|b| b.name.clone()));
    let mut modules: Vec<model::Module> = bodies.into_iter().map(|b| body::module(b, &mut owns)).collect();
    if let Some(top) = modules.first_mut() {
        top.attributes.push(("top", format!("{:032b}", 1)));
        if netlist.timescale() != Timescale::default() {
            top.attributes.push(("discreta_timescale", netlist.timescale().to_string()));
        }
        if !extra.parameters.is_empty() {
            let list: Vec<String> = extra.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
            top.attributes.push(("discreta_parameters", list.join(" ")));
        }
        if let Some(simulation) = &extra.simulation {
            top.attributes.push(("discreta_simulation", simulation.clone()));
        }
    }
    modules.extend(owns.modules.into_iter().map(|m| m.0));
    model::text(&modules)
}

/// Numbers for the bits of all nets.
struct Numbers<'n> {
    netlist: &'n Netlist,
    start: Vec<u32>,
}

impl<'n> Numbers<'n> {
    fn new(netlist: &'n Netlist) -> Numbers<'n> {
        let mut start = vec![2];
        for (i, net) in netlist.nets().iter().enumerate() {
            start.push(start[i] + net.width);
        }
        Numbers { netlist, start }
    }

    fn bits(&self, slices: &[Slice]) -> Bits {
        let mut bits = Bits::new();
        for slice in slices {
            let constant = match self.netlist.net(slice.net).driver {
                Driver::Cell(cell, _) => match &self.netlist.cell(cell).kind {
                    CellKind::Constant(value) => Some(value),
                    _ => None,
                },
                Driver::Input(_) => None,
            };
            bits.extend((slice.lo..slice.lo + slice.width).map(|i| match constant {
                Some(value) => Bit::Constant(value.bit(i)),
                None => Bit::Net(self.start[slice.net.index()] + i),
            }));
        }
        bits
    }

    fn net(&self, net: NetId) -> Bits {
        let width = self.netlist.net(net).width;
        self.bits(&[Slice { net, lo: 0, width }])
    }
}

/// The whole netlist as one module; instances are paths of names.
fn flat<'n>(netlist: &'n Netlist, extra: &Extra<'_>) -> Body<'n> {
    let numbers = Numbers::new(netlist);
    let path = |mut scope: ScopeId, name: &str| {
        let mut path = vec![name.to_owned()];
        while let Some(parent) = netlist.scopes()[scope.index()].parent {
            path.push(netlist.scopes()[scope.index()].name.clone());
            scope = parent;
        }
        path.reverse();
        path
    };
    let (mut ports, mut nets) = (Vec::new(), Vec::new());
    for id in netlist.signal_ids() {
        let signal = netlist.signal(id);
        let bits = numbers.bits(netlist.bits(id));
        match signal.port.filter(|_| signal.scope.index() == 0) {
            Some(direction) => {
                ports.push(BodyPort { name: signal.name.clone(), direction, bits, signed: signal.signed });
            }
            None => nets.push(BodyNet {
                path: path(signal.scope, &signal.name),
                bits,
                hidden: signal.hidden,
                signed: signal.signed,
            }),
        }
    }
    let cells = netlist.cell_ids().map(|id| {
        let cell = netlist.cell(id);
        BodyCell {
            path: path(cell.scope, &cell.name),
            kind: &cell.kind,
            element: cell.element,
            inputs: (0..cell.kind.inputs().len()).map(|pin| numbers.bits(netlist.input(id, pin))).collect(),
            outputs: (0..cell.kind.outputs().len()).map(|pin| numbers.net(netlist.output(id, pin))).collect(),
            source: extra.source.and_then(|source| source(id)),
        }
    });
    Body {
        name: netlist.scopes()[0].name.clone(),
        ports,
        nets,
        cells: cells.collect(),
        instances: vec![],
        end: numbers.start[netlist.nets().len()],
    }
}
