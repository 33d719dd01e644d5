//! The waveforms that a run is to leave: where, and in which format.

use std::path::{Path, PathBuf};

use super::CliError;
use super::args::RunArgs;
use crate::wave::{self, Kind, Sink};

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
/// One that asks for another format.
pub(super) fn places(args: &RunArgs) -> Result<Vec<Place>, CliError> {
    let mut places: Vec<Place> = Vec::new();
    for path in &args.output {
        if places.iter().any(|place| place.path == *path) {
            continue;
        }
        let cannot = |why: &str| CliError::usage(format!("cannot write `{}`: {why}", path.display()));
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

/// Opens all places.
///
/// # Errors
/// One that cannot be written.
pub(super) fn open(places: &[Place]) -> Result<Vec<Box<dyn Sink>>, CliError> {
    let open = |place: &Place| wave::open(&place.path, place.kind).map(|sink| -> Box<dyn Sink> { sink });
    Ok(places.iter().map(open).collect::<Result<_, _>>()?)
}
