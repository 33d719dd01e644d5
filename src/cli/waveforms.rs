//! The waveforms that a run is to leave: where, and in which format.

use std::io;
use std::path::{Path, PathBuf};

use super::CliError;
use crate::value::Word;
use crate::wave::{self, Kind, Layout, Sink};

/// Where a waveform goes.
pub(super) struct Place {
    /// The path as it was given; `-` is standard output.
    pub path: PathBuf,
    /// The format.
    pub kind: Kind,
}

/// The places, each once.
///
/// # Errors
/// One that asks for another format, or is the circuit itself.
pub(super) fn places(paths: &[PathBuf], circuit: &Path) -> Result<Vec<Place>, CliError> {
    let mut places: Vec<Place> = Vec::new();
    let circuit = circuit.canonicalize().ok();
    for path in paths {
        if places.iter().any(|place| place.path == *path) {
            continue;
        }
        let cannot = |why: &str| CliError::usage(format!("cannot write `{}`: {why}", path.display()));
        if circuit.is_some() && path.canonicalize().ok() == circuit {
            return Err(cannot("it is the circuit itself").with_hint("name another file, ending in .vcd or .fst"));
        }
        let kind = match Kind::of(path) {
            Some(kind) => kind,
            None if is_special(path) => Kind::Vcd,
            None => {
                let kind = path.extension().unwrap_or_default().to_string_lossy().into_owned();
                return Err(cannot(&format!("waveforms are written as VCD or FST, not as {kind}"))
                    .with_hint("end the name in .vcd or .fst"));
            }
        };
        places.push(Place { path: path.clone(), kind });
    }
    Ok(places)
}

/// Whether a path leads to what is no regular file.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file())
}

/// Opens all places; none if there is none.
///
/// # Errors
/// One that cannot be written.
pub(super) fn open(places: &[Place]) -> Result<Option<Sinks>, CliError> {
    let sinks = places.iter().map(|place| wave::open(&place.path, place.kind)).collect::<Result<Vec<_>, _>>()?;
    Ok(if sinks.is_empty() { None } else { Some(Sinks(sinks)) })
}

/// Several waveforms at once.
pub(super) struct Sinks(Vec<Box<dyn Sink>>);

impl Sink for Sinks {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.begin(layout))
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.time(now))
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        self.0.iter_mut().for_each(|s| s.change(var, value));
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.0.iter_mut().try_for_each(|s| s.finish(end))
    }
}
