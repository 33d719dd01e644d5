//! The whole state of a simulator: kept, gone back to, written to a file.

use std::io::Write;
use std::path::Path;

use super::{Simulator, SimulatorError};
use crate::engine::{Snapshot, SnapshotError};
use crate::wave::output::{Destination, Output, reason};

/// The whole state of a simulator: time, every net, what memories hold, clocks, delays, forces, and what was covered. Any
/// simulator of the same circuit, on any engine, goes on from it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct State {
    engine: Snapshot,
    covered: Vec<bool>,
}

/// How a file of a state begins; the last but one byte is the version.
const MAGIC: &[u8] = b"discreta checkpoint 1\n";

impl State {
    /// The tick at which it was saved.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.engine.now()
    }

    /// As bytes, the same on every machine.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut all = MAGIC.to_vec();
        all.extend((self.covered.len() as u64).to_le_bytes());
        all.extend(self.covered.iter().map(|&c| u8::from(c)));
        all.extend(self.engine.to_bytes());
        all
    }

    /// From bytes.
    ///
    /// # Errors
    /// If they are none that [`to_bytes`](State::to_bytes) gave, or not all of them, or changed ones.
    pub fn from_bytes(bytes: &[u8]) -> Result<State, SnapshotError> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            let other = bytes.starts_with(&MAGIC[..MAGIC.len() - 2]);
            return Err(if other { SnapshotError::Version } else { SnapshotError::NoSnapshot });
        };
        let (count, rest) = rest.split_first_chunk::<8>().ok_or(SnapshotError::Damaged)?;
        let count = usize::try_from(u64::from_le_bytes(*count)).map_err(|_| SnapshotError::Damaged)?;
        let (covered, rest) = rest.split_at_checked(count).ok_or(SnapshotError::Damaged)?;
        let engine = Snapshot::from_bytes(rest).map_err(|_| SnapshotError::Damaged)?;
        Ok(State { engine, covered: covered.iter().map(|&c| c != 0).collect() })
    }

    /// Writes it to a file, which is there when it is complete.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), SimulatorError> {
        let mut output = Output::create(path.as_ref()).map_err(|e| SimulatorError::File(e.to_string()))?;
        let written = output.write_all(&self.to_bytes()).and_then(|()| output.complete());
        written.map_err(|e| SimulatorError::File(e.to_string()))
    }

    /// Reads it from a file.
    ///
    /// # Errors
    /// If the file cannot be read, or holds no state.
    pub fn read(path: impl AsRef<Path>) -> Result<State, SimulatorError> {
        let path = path.as_ref();
        let cannot = |why: String| SimulatorError::File(format!("cannot read `{}`: {why}", path.display()));
        let bytes = std::fs::read(path).map_err(|e| cannot(reason(&e)))?;
        State::from_bytes(&bytes).map_err(|e| cannot(e.to_string()))
    }
}

impl Simulator {
    /// The whole state as it stands, with inputs that were set and have not taken effect yet.
    #[must_use]
    pub fn save(&self) -> State {
        State { engine: self.engine.save(), covered: self.monitors.covered() }
    }

    /// Goes back, or on, to a state that this or another simulator of the circuit saved.
    ///
    /// # Errors
    /// If it is of another circuit, or earlier than the present tick while a waveform is being written. Nothing has happened
    /// then.
    pub fn restore(&mut self, state: &State) -> Result<(), SimulatorError> {
        if self.tracing.is_some() && state.now() < self.now() {
            return Err(SimulatorError::Tracing("a waveform cannot go back in time: end it with `end_trace` first"));
        }
        self.engine.restore(&state.engine)?;
        self.broken = false;
        self.fault.get_mut().take();
        self.resume_monitors(&state.covered);
        self.record()?;
        self.engine.clear_changes();
        Ok(())
    }
}
