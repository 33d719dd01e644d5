//! discreta for Python: what is here is the compiled half of the package `discreta`; `python/discreta/__init__.py` makes
//! of it what is written about in `docs/python.md`.
//!
//! Objects are behind a lock, for Python may pass them between threads; long runs let other threads of Python go on.

#![allow(missing_docs)] // what Python shows of these has its documentation in `__init__.pyi`
#![allow(unsafe_code)] // of what the macros of `pyo3` make

mod simulator;
mod sweep;
mod value;

use discreta::circuit;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(discreta, Error, PyException, "What discreta cannot do, and why.");
pyo3::create_exception!(discreta, LoadError, Error, "A circuit that cannot be used, with every fault and its place.");
pyo3::create_exception!(discreta, AssertionFailed, Error, "An assertion of the circuit that failed.");

/// A circuit ready to run.
#[pyclass(frozen, module = "discreta")]
pub struct Circuit {
    pub inner: circuit::Circuit,
}

#[pymethods]
impl Circuit {
    /// What is doubtful in the files.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.inner.warnings.clone()
    }

    /// The values of the top module's parameters.
    #[getter]
    fn parameters(&self) -> std::collections::BTreeMap<String, i64> {
        self.inner.parameters.iter().map(|(name, &value)| (name.clone(), value)).collect()
    }

    /// (name, width) of each signal, in the order of declaration, without those that tools made up.
    #[getter]
    fn signals(&self) -> Vec<(String, u32)> {
        let n = &self.inner.netlist;
        let shown = n.signal_ids().filter(|&id| !n.signal(id).hidden);
        shown.map(|id| (n.signal_path(id), n.signal(id).width)).collect()
    }

    /// (name, width) of each input.
    #[getter]
    fn inputs(&self) -> Vec<(String, u32)> {
        let n = &self.inner.netlist;
        let driven = n.ports().filter(|&id| n.signal(id).drive.is_some());
        driven.map(|id| (n.signal_path(id), n.signal(id).width)).collect()
    }

    /// (name, width) of each output.
    #[getter]
    fn outputs(&self) -> Vec<(String, u32)> {
        let n = &self.inner.netlist;
        let driven = n.ports().filter(|&id| n.signal(id).drive.is_none());
        driven.map(|id| (n.signal_path(id), n.signal(id).width)).collect()
    }

    /// How long a tick is, as in a VCD: `1ns`.
    #[getter]
    fn timescale(&self) -> String {
        self.inner.netlist.timescale().to_string()
    }

    fn __repr__(&self) -> String {
        let n = &self.inner.netlist;
        format!("<discreta.Circuit of {} cells and {} nets>", n.cells().len(), n.nets().len())
    }
}

fn loaded(circuit: Result<circuit::Circuit, circuit::LoadError>) -> PyResult<Circuit> {
    match circuit {
        Ok(inner) => Ok(Circuit { inner }),
        Err(e) => Err(LoadError::new_err(e.to_string())),
    }
}

fn borrowed(parameters: &[(String, i64)]) -> Vec<(&str, i64)> {
    parameters.iter().map(|(name, value)| (name.as_str(), *value)).collect()
}

/// Loads a circuit file, a netlist of Yosys, or a Verilog file through Yosys.
#[pyfunction]
fn load(py: Python<'_>, path: std::path::PathBuf, parameters: Vec<(String, i64)>) -> PyResult<Circuit> {
    loaded(py.detach(|| circuit::load_with(path, &borrowed(&parameters))))
}

/// A circuit of Verilog and its like, through Yosys.
#[pyfunction]
fn load_sources(
    py: Python<'_>,
    sources: Vec<std::path::PathBuf>,
    top: Option<String>,
    parameters: Vec<(String, i64)>,
    yosys: Option<std::path::PathBuf>,
    include: Vec<std::path::PathBuf>,
    define: Vec<String>,
) -> PyResult<Circuit> {
    let synthesis = circuit::Synthesis { program: yosys, include, define, ..circuit::Synthesis::default() };
    loaded(py.detach(|| circuit::load_sources(&sources, top.as_deref(), &borrowed(&parameters), synthesis)))
}

/// The same from a text.
#[pyfunction]
fn load_text(py: Python<'_>, name: &str, text: &str, parameters: Vec<(String, i64)>) -> PyResult<Circuit> {
    loaded(py.detach(|| circuit::load_text(name, text, &borrowed(&parameters))))
}

#[pymodule]
fn _discreta(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("Error", m.py().get_type::<Error>())?;
    m.add("LoadError", m.py().get_type::<LoadError>())?;
    m.add("AssertionFailed", m.py().get_type::<AssertionFailed>())?;
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<Circuit>()?;
    m.add_class::<value::Value>()?;
    m.add_class::<simulator::Simulator>()?;
    m.add_class::<simulator::State>()?;
    m.add_function(wrap_pyfunction!(load, m)?)?;
    m.add_function(wrap_pyfunction!(load_sources, m)?)?;
    m.add_function(wrap_pyfunction!(load_text, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::sweep, m)?)
}
