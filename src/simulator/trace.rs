//! A waveform of what a simulator does.

use std::path::{Path, PathBuf};

use super::{Simulator, SimulatorError};
use crate::netlist::SignalId;
use crate::scenario::{Recording, glob_path, glob_set};
use crate::wave::{Kind, Sink, open, output::reason};

/// What is written into a waveform: where, of which signals, and when.
///
/// ```
/// use discreta::Trace;
///
/// let trace = Trace::to("run.fst").only("core.**").except("**.tmp*").from(1000).until(2000);
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct Trace {
    path: PathBuf,
    only: Vec<String>,
    except: Vec<String>,
    from: u64,
    until: u64,
}

impl Trace {
    /// All signals, from the present tick to the end, into a file whose name ends in `.vcd` or `.fst`.
    pub fn to(path: impl AsRef<Path>) -> Trace {
        let path = path.as_ref().to_owned();
        Trace { path, only: Vec::new(), except: Vec::new(), from: 0, until: u64::MAX }
    }

    /// Only signals whose path matches one of the patterns given so: `*` and `?` stay within a scope, `**` crosses scopes.
    pub fn only(mut self, pattern: &str) -> Trace {
        self.only.push(pattern.to_owned());
        self
    }

    /// No signals whose path matches one of the patterns given so.
    pub fn except(mut self, pattern: &str) -> Trace {
        self.except.push(pattern.to_owned());
        self
    }

    /// Nothing before this tick.
    pub fn from(mut self, tick: u64) -> Trace {
        self.from = tick;
        self
    }

    /// Nothing after this tick.
    pub fn until(mut self, tick: u64) -> Trace {
        self.until = tick;
        self
    }
}

impl<P: AsRef<Path>> From<P> for Trace {
    fn from(path: P) -> Trace {
        Trace::to(path)
    }
}

/// A waveform that is being written.
pub(super) struct Tracing {
    recording: Recording,
    sink: Box<dyn Sink + Send>,
    signals: Vec<SignalId>,
    from: u64,
    until: u64,
    /// Whether the window has begun.
    begun: bool,
    path: PathBuf,
}

impl std::fmt::Debug for Tracing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Tracing to {}", self.path.display())
    }
}

impl Tracing {
    /// The next tick after `now` at which the window begins or ends.
    pub fn border(&self, now: u64) -> u64 {
        if !self.begun && self.from > now { self.from } else { self.until }
    }
}

fn failed(e: &std::io::Error) -> SimulatorError {
    SimulatorError::File(format!("the waveform cannot be written: {}", reason(e)))
}

impl Simulator {
    /// Writes a waveform from now on, until [`end_trace`](Simulator::end_trace), the end of its window, or until the simulator
    /// is dropped: `sim.trace("run.fst")?` of everything, [`Trace`] of parts. The file is there when it is complete.
    ///
    /// # Errors
    /// If the file cannot be written or its name says no format, no signal matches, or a trace is on already.
    pub fn trace(&mut self, what: impl Into<Trace>) -> Result<(), SimulatorError> {
        let what = what.into();
        if self.tracing.is_some() {
            return Err(SimulatorError::Tracing("a waveform is being written already: end it with `end_trace` first"));
        }
        if what.until < what.from.max(self.now()) {
            return Err(SimulatorError::Tracing("the window of the waveform is empty or past"));
        }
        let kind = Kind::of(&what.path).ok_or_else(|| {
            let path = what.path.display();
            SimulatorError::File(format!("`{path}` names no waveform format: let it end in `.vcd` or `.fst`"))
        })?;
        let set =
            |pattern: &String| glob_set(pattern).map_err(|why| SimulatorError::BadValue { name: pattern.clone(), why });
        let only: Vec<_> = what.only.iter().map(set).collect::<Result<_, _>>()?;
        let except: Vec<_> = what.except.iter().map(set).collect::<Result<_, _>>()?;
        let shown = |&id: &SignalId| {
            let path = glob_path(&self.netlist, id);
            // what a tool made up is shown where it is asked for
            let asked =
                if only.is_empty() { !self.netlist.signal(id).hidden } else { only.iter().any(|g| g.is_match(&path)) };
            asked && !except.iter().any(|g| g.is_match(&path))
        };
        let signals: Vec<SignalId> = self.netlist.signal_ids().filter(shown).collect();
        if signals.is_empty() {
            return Err(SimulatorError::Tracing("no signal matches the patterns of the waveform"));
        }
        let sink = open(&what.path, kind).map_err(|e| SimulatorError::File(e.to_string()))?;
        let recording = Recording::new(&self.netlist, &signals);
        let (from, until, path) = (what.from, what.until, what.path);
        self.tracing = Some(Tracing { recording, sink, signals, from, until, begun: false, path });
        if self.settled { self.record() } else { Ok(()) }
    }

    /// Ends the waveform at the present tick.
    ///
    /// # Errors
    /// If it cannot be written, or there is none.
    pub fn end_trace(&mut self) -> Result<(), SimulatorError> {
        let Some(mut tracing) = self.tracing.take() else {
            return Err(SimulatorError::Tracing("no waveform is being written"));
        };
        if !tracing.begun {
            tracing.sink.begin(tracing.recording.layout()).map_err(|e| failed(&e))?;
        }
        let (engine, sink) = (&mut *self.engine, &mut *tracing.sink);
        if tracing.begun {
            tracing.recording.finish(engine, self.broken, sink).map_err(|e| failed(&e))?;
        }
        sink.finish(self.engine.now()).map_err(|e| failed(&e))
    }

    /// Records what has changed; begins and ends with the window.
    pub(super) fn record(&mut self) -> Result<(), SimulatorError> {
        let now = self.engine.now();
        let Some(tracing) = self.tracing.as_mut().filter(|t| now >= t.from) else { return Ok(()) };
        let first = !std::mem::replace(&mut tracing.begun, true);
        let engine = &mut *self.engine;
        let mut write = || {
            if first {
                for &signal in &tracing.signals {
                    self.netlist.bits(signal).iter().for_each(|s| engine.trace(s.net));
                }
                tracing.sink.begin(tracing.recording.layout())?;
            }
            tracing.recording.record(engine, first, &mut *tracing.sink)
        };
        write().map_err(|e| failed(&e))
    }

    /// Ends the waveform if its window is over.
    pub(super) fn end_window(&mut self) -> Result<(), SimulatorError> {
        let over = self.tracing.as_ref().is_some_and(|t| self.engine.now() >= t.until);
        if over { self.end_trace() } else { Ok(()) }
    }
}
