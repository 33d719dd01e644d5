//! Reading FST, GTKWave's compressed format.
//!
//! The format is that of GTKWave's `fstapi`: its blocks of all kinds, packed by each of its methods, as a whole or not.
//! A file that is not complete can be read as far as its names are there: some writers put them first, others into a file
//! beside it (`x.fst.hier`) until they are done.

use std::ffi::OsString;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use super::fst_blocks::{self, Blocks};
use super::fst_names::{self, Hierarchy};
use super::fst_values::Values;
use super::notes::Notes;
use super::{Contents, Fault, Input, Source};

pub(super) use fst_blocks::is_fst;

/// Reads a file; its values later.
///
/// # Errors
/// It cannot be read, or its names cannot.
pub(super) fn read(mut input: Box<dyn Input>, path: &Path) -> Result<Contents, Fault> {
    let mut notes = Notes::default();
    if let Some(file) = fst_blocks::unwrapped(&mut *input, &mut notes)? {
        input = Box::new(Cursor::new(file));
    }
    let Blocks { header, geometry, hierarchy, values } = Blocks::of(&mut *input, &mut notes)?;
    let hierarchy = match hierarchy {
        Some(hierarchy) => hierarchy,
        None => std::fs::read(beside(path)).map_err(|_| {
            let why = notes.cut.clone().unwrap_or_else(|| "its end is missing".to_owned());
            Fault::Cut(format!("{why}; its names, which come last, are not there"))
        })?,
    };
    if geometry.is_none() {
        notes.cut("what wrote it did not finish");
    }
    let forms = geometry.unwrap_or_else(|| fst_names::forms(&hierarchy));
    let Hierarchy { outline, signals } = Hierarchy::read(&hierarchy, &forms, &mut notes)?;
    let names = outline.names(|_| None);
    let (values, times) = Values::new(input, header.little, values, forms, signals, &mut notes)?;
    Ok(Contents { names, exponent: Some(header.exponent), times, source: Source::Fst(values), notes })
}

/// Where a writer keeps the names until it is done.
fn beside(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".hier");
    name.into()
}
