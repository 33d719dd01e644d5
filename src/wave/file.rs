//! Waveform files by their names.

use std::path::Path;

use super::Sink;
use super::background::Background;
use super::behind::Behind;
use super::fst::FstWriter;
use super::output::{Output, OutputError};
use super::vcd::VcdWriter;

/// The formats that are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Text, IEEE 1364-2005, clause 18.
    Vcd,
    /// GTKWave's compressed format.
    Fst,
}

impl Kind {
    /// The format that a path asks for by its extension; VCD if it has none.
    #[must_use]
    pub fn of(path: &Path) -> Option<Kind> {
        match path.extension() {
            None => Some(Kind::Vcd),
            Some(e) if e.eq_ignore_ascii_case("vcd") => Some(Kind::Vcd),
            Some(e) if e.eq_ignore_ascii_case("fst") => Some(Kind::Fst),
            Some(_) => None,
        }
    }
}

/// Opens a place for a waveform, which is formatted on a thread of its own, and packed and written on another.
///
/// # Errors
/// That the path cannot be written. FST needs one that can be gone back in, which is told by [`Sink::begin`].
pub fn open(path: &Path, kind: Kind) -> Result<Box<dyn Sink + Send>, OutputError> {
    let output = Behind::new(Output::create(path)?);
    Ok(match kind {
        Kind::Vcd => Box::new(Background::new(VcdWriter::new(output))),
        Kind::Fst => Box::new(Background::new(FstWriter::new(output))),
    })
}
