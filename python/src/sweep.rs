//! One scenario for many values: the file's own, on all cores.

use std::sync::atomic::AtomicBool;

use discreta::diag::Diagnostics;
use discreta::netlist::{Direction, NetId, SignalId};
use discreta::scenario::Scenario;
use discreta::sweep::plan::Values;
use discreta::sweep::{Form, Over, Plan, Sweep, Table};
use pyo3::prelude::*;

use super::{Circuit, Error};

fn told(why: impl ToString) -> PyErr {
    Error::new_err(why.to_string())
}

/// The names of the columns, and the rows in order, each as JSON.
///
/// `over` has for each input its values as texts.
#[pyfunction]
pub fn sweep(
    py: Python<'_>,
    circuit: &Circuit,
    over: Vec<(String, Vec<String>)>,
    show: Vec<String>,
    threads: usize,
) -> PyResult<(Vec<String>, Vec<String>)> {
    let netlist = &circuit.inner.netlist;
    let simulation = circuit.inner.simulation.clone().ok_or_else(|| {
        told("the circuit has no `simulation` that says how it is run: it is needed to know when a run is over")
    })?;
    let mut diagnostics = Diagnostics::new();
    let mut scenario = Scenario::resolve(&circuit.inner, &simulation, &mut diagnostics);
    let find = |name: &str| netlist.find(name).ok_or_else(|| told(format!("the circuit has no signal `{name}`")));
    let (mut swept, mut axes, mut nets): (Vec<SignalId>, Vec<_>, Vec<NetId>) = Default::default();
    for (net, values) in over {
        let signal = find(&net)?;
        let of = netlist.signal(signal);
        let drive = of.drive.ok_or_else(|| told(format!("`{net}` is no input, so it cannot be swept")))?;
        let over = Over { net, values: Values::List(values) };
        let axis = over.values(of.width, of.signed).map_err(told)?;
        // what is swept is driven in every run
        if !scenario.inputs.iter().any(|(input, _)| *input == drive) {
            scenario.inputs.push((drive, discreta::Value::from_u64(0, of.width)));
        }
        axes.push(axis);
        nets.push(drive);
        swept.push(signal);
    }
    if diagnostics.has_errors() {
        return Err(told("the circuit's `simulation` has faults: run `discreta check` on the file"));
    }
    let plan = Plan::new(axes).map_err(told)?;
    let shown = |&id: &SignalId| matches!(netlist.signal(id).port, Some(Direction::Output | Direction::Inout));
    let outputs: Vec<SignalId> = match show.is_empty() {
        true => netlist.ports().filter(shown).collect(),
        false => show.iter().map(|name| find(name)).collect::<PyResult<_>>()?,
    };
    let scenario = &scenario;
    let sweep = Sweep { netlist, scenario, nets, plan, outputs, against: None, threads, lanes: 0 };
    let clock = scenario.clocks.first().map(|c| c.clock);
    let table = Table::new(netlist, &sweep.plan, swept, sweep.outputs.clone(), clock, false, Form::Json);
    let mut rows = Vec::new();
    let ran = py.detach(|| {
        sweep.run(0, &AtomicBool::new(false), &|row| table.line(row), &mut |_, line| {
            rows.push(line.to_owned());
            Ok(())
        })
    });
    ran.map_err(told)?;
    Ok((table.columns(), rows))
}
