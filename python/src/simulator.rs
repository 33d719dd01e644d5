//! A simulator behind a lock, and its saved states.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use discreta::cell::Clock;
use discreta::{EngineKind, SimulatorError, Trace};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::value::{Value, given};
use super::{AssertionFailed, Circuit, Error};

fn error(e: SimulatorError) -> PyErr {
    let text = e.to_string();
    match e {
        SimulatorError::Unknown { .. } | SimulatorError::NoMemory { .. } => PyKeyError::new_err(text),
        SimulatorError::BadValue { .. } | SimulatorError::BadClock { .. } => PyValueError::new_err(text),
        SimulatorError::Assertion { .. } => AssertionFailed::new_err(text),
        _ => Error::new_err(text),
    }
}

/// A circuit that runs.
#[pyclass(frozen, module = "discreta._discreta", name = "Core")]
pub struct Simulator {
    inner: Mutex<discreta::Simulator>,
}

impl Simulator {
    fn lock(&self) -> MutexGuard<'_, discreta::Simulator> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs something while other threads of Python go on.
    fn run<T: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut discreta::Simulator) -> Result<T, SimulatorError> + Send,
    ) -> PyResult<T> {
        py.detach(|| act(&mut self.lock())).map_err(error)
    }

    /// The width of a signal.
    fn width(&self, name: &str) -> PyResult<u32> {
        Ok(self.lock().probe(name).map_err(error)?.width())
    }
}

#[pymethods]
impl Simulator {
    #[new]
    fn new(circuit: &Circuit, engine: &str) -> PyResult<Simulator> {
        let kind = match engine {
            "auto" => EngineKind::Auto,
            "event" => EngineKind::Event,
            "compiled" => EngineKind::Compiled,
            other => {
                let text = format!("`{other}` is no engine: give `auto`, `event` or `compiled`");
                return Err(PyValueError::new_err(text));
            }
        };
        let inner = discreta::Simulator::with(&circuit.inner, kind).map_err(error)?;
        Ok(Simulator { inner: Mutex::new(inner) })
    }

    fn poke(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = given(value, self.width(name)?)
            .map_err(|e| PyValueError::new_err(format!("`{name}` cannot have that value: {}", e.value(value.py()))))?;
        self.lock().poke(name, value).map_err(error)
    }

    fn peek(&self, name: &str) -> PyResult<Value> {
        Ok(Value { inner: self.lock().peek(name).map_err(error)? })
    }

    fn settle(&self, py: Python<'_>) -> PyResult<()> {
        self.run(py, |sim| sim.settle())
    }

    fn tick(&self, py: Python<'_>, clock: &str, n: u64) -> PyResult<()> {
        self.run(py, |sim| sim.ticks(clock, n))
    }

    fn clock(&self, name: &str, period: u64, high: u64, phase: u64) -> PyResult<()> {
        let mut sim = self.lock();
        let input = sim.input(name).map_err(error)?;
        if !(1..period).contains(&high) {
            let clock = Clock { period, high, phase };
            return Err(error(SimulatorError::BadClock { input: name.to_owned(), clock }));
        }
        sim.clock(input, Clock { period, high, phase });
        Ok(())
    }

    fn run_to(&self, py: Python<'_>, tick: u64) -> PyResult<()> {
        self.run(py, |sim| sim.run_to(tick))
    }

    fn run_until(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>, ticks: u64) -> PyResult<u64> {
        let value = given(value, self.width(name)?)?;
        self.run(py, |sim| sim.run_until(name, value, ticks))
    }

    #[getter]
    fn now(&self) -> u64 {
        self.lock().now()
    }

    fn force(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = given(value, self.width(name)?)?;
        self.lock().force(name, value).map_err(error)
    }

    fn release(&self, name: &str) -> PyResult<()> {
        self.lock().release(name).map_err(error)
    }

    fn deposit(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = given(value, self.width(name)?)?;
        self.lock().deposit(name, value).map_err(error)
    }

    #[getter]
    fn memories(&self) -> Vec<String> {
        self.lock().memories().collect()
    }

    /// The first address of a memory, the one after its last, and the bits of a word.
    fn memory(&self, name: &str) -> PyResult<(i64, i64, u32)> {
        let memory = self.lock().memory(name).map_err(error)?;
        Ok((memory.addresses().start, memory.addresses().end, memory.width()))
    }

    fn read_memory(&self, name: &str, address: i64) -> PyResult<Value> {
        let sim = self.lock();
        let memory = sim.memory(name).map_err(error)?;
        Ok(Value { inner: sim.read_memory(&memory, address).map_err(error)? })
    }

    fn write_memory(&self, name: &str, address: i64, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut sim = self.lock();
        let memory = sim.memory(name).map_err(error)?;
        let value = given(value, memory.width())?;
        sim.write_memory(&memory, address, value).map_err(error)
    }

    fn trace(
        &self,
        path: PathBuf,
        only: Vec<String>,
        leave_out: Vec<String>,
        start: u64,
        until: Option<u64>,
    ) -> PyResult<()> {
        let mut trace = Trace::to(path).from(start);
        trace = only.iter().fold(trace, |t, pattern| t.only(pattern));
        trace = leave_out.iter().fold(trace, |t, pattern| t.except(pattern));
        trace = until.into_iter().fold(trace, |t, tick| t.until(tick));
        self.lock().trace(trace).map_err(error)
    }

    fn end_trace(&self, py: Python<'_>) -> PyResult<()> {
        self.run(py, |sim| sim.end_trace())
    }

    fn save(&self) -> State {
        State { inner: self.lock().save() }
    }

    fn restore(&self, state: &State) -> PyResult<()> {
        self.lock().restore(&state.inner).map_err(error)
    }

    /// What the circuit said since this was last asked: the tick, the cell, the text.
    fn take_messages(&self) -> Vec<(u64, String, String)> {
        self.lock().take_messages().into_iter().map(|m| (m.time, m.name, m.text)).collect()
    }

    #[getter]
    fn uncovered(&self) -> Vec<String> {
        self.lock().uncovered()
    }

    #[getter]
    fn summary(&self) -> String {
        self.lock().summary()
    }
}

/// The whole state of a simulator.
#[pyclass(frozen, module = "discreta")]
pub struct State {
    inner: discreta::State,
}

#[pymethods]
impl State {
    #[getter]
    fn now(&self) -> u64 {
        self.inner.now()
    }

    fn write(&self, path: PathBuf) -> PyResult<()> {
        self.inner.write(path).map_err(error)
    }

    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<State> {
        Ok(State { inner: discreta::State::read(path).map_err(error)? })
    }

    fn __bytes__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.inner.to_bytes())
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<State> {
        let inner = discreta::State::from_bytes(bytes).map_err(|e| Error::new_err(e.to_string()))?;
        Ok(State { inner })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let restore = py.get_type::<State>().getattr("from_bytes")?;
        Ok((restore, (self.__bytes__(py),)))
    }

    fn __eq__(&self, other: &State) -> bool {
        self.inner == other.inner
    }
}
