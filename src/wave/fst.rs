//! Writing FST, GTKWave's compressed format, while a run goes on.
//!
//! The `fst-writer` crate writes what a file says of its signals, `section` packs their values, some
//! megabytes at a time, so memory does not grow with the run. The bytes are the same everywhere: no date, no version
//! number. Two numbers at the beginning are known at the end only, so the destination is one that can go back.

use std::io::{self, Cursor, Seek, SeekFrom};

use fst_writer::{
    FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType, FstVarDirection, FstVarType,
    FstWriteError,
};

use super::layout::Declaration;
use super::output::{Destination, Piece};
use super::recorder::{Format, Recorder};
use super::section::Section;
use super::{Layout, ScopeKind, VarKind};
use crate::value::Word;
use crate::value::word::word_mask;

/// How many bytes of changes are kept before they are compressed.
const SECTION: usize = 8 << 20;

/// Where the beginning of a file has its last tick, and how many sections there are.
const END: u64 = 17;
const SECTIONS: u64 = 65;
/// The type of a block with values.
const VALUES: u8 = 8;

/// The longest name that readers of the format make room for, in bytes.
const LONGEST: usize = 511;
/// What may stand behind a name: ` [16777215:0]`.
const INDEX: usize = 13;

/// A [`Sink`](super::Sink) that writes FST. A run that ends at tick 0 is shown up to tick 1: the format has no waveform
/// of a single instant.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod wave { pub use discreta_wave::*; }
/// # }
/// use discreta::value::Word;
/// use discreta::wave::{Layout, Sink, fst::FstWriter, output::Output, read::Waves};
///
/// let mut layout = Layout::default();
/// let top = layout.scope("top", None);
/// let q = layout.var(top, "q", 4);
///
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("run.fst");
/// let mut fst = FstWriter::new(Output::create(&path)?);
/// fst.begin(&layout)?;
/// fst.time(0)?;
/// fst.time(5)?;
/// fst.change(q, &[Word::known(9)]);
/// fst.finish(10)?;
///
/// let mut waves = Waves::open(&path)?;
/// let q = waves.find("top.q").unwrap();
/// let changes: Vec<_> = waves.load(q)?.changes().collect();
/// assert_eq!(changes, [(0, "xxxx".to_string()), (5, "1001".to_string())]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type FstWriter<D> = Recorder<Fst<D>>;

/// The format of FST.
pub struct Fst<D: Destination + Seek> {
    destination: D,
    /// The signals of the file by slot: they are numbered as they are declared.
    signals: Vec<u32>,
    section: Section,
    sections: u64,
    /// The last time.
    now: u64,
    /// There was no time but 0 yet.
    instant: bool,
    /// What comes now are the first values.
    first: bool,
    begun: bool,
}

impl<D: Destination + Seek> FstWriter<D> {
    /// A writer into this destination; nothing is written before [`Sink::begin`](super::Sink::begin).
    pub fn new(destination: D) -> FstWriter<D> {
        let section = Section::default();
        let signals = Vec::new();
        let (instant, first, begun) = (true, false, false);
        Recorder::with(Fst { destination, signals, section, sections: 0, now: 0, instant, first, begun })
    }
}

impl<D: Destination + Seek> Fst<D> {
    fn flush(&mut self) -> io::Result<()> {
        self.sections += 1;
        let full = self.section.take();
        self.destination.give(Piece::Later(Box::new(move || full.pack())))?;
        Ok(())
    }

    /// What the file says before its values, and the slots in the order in which it numbers them.
    fn beginning(layout: &Layout, slot_of: &[u32]) -> Result<Beginning, FstWriteError> {
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: layout.timescale.exponent() as i8,
            version: "discreta".to_owned(),
            date: String::new(),
            file_type: FstFileType::Verilog,
        };
        let mut header = FstHeaderWriter::new(Cursor::new(Vec::new()), &info)?;
        let mut slots = Vec::new();
        let mut ids: Vec<Option<FstSignalId>> = vec![None; slot_of.iter().map(|&s| s as usize + 1).max().unwrap_or(0)];
        for declaration in layout.outline() {
            match declaration {
                Declaration::Open(scope) => {
                    let decl = &layout.scopes[scope];
                    let kind = match decl.kind {
                        ScopeKind::Module => FstScopeType::Module,
                        ScopeKind::Block => FstScopeType::Begin,
                    };
                    header.scope(&decl.name, "", kind)?;
                }
                Declaration::Var(i) => {
                    let (var, slot) = (&layout.vars[i], slot_of[i] as usize);
                    let kind = match var.kind {
                        VarKind::Wire => FstVarType::Wire,
                        VarKind::Reg => FstVarType::Reg,
                        VarKind::Integer => FstVarType::Integer,
                    };
                    let name = match var.width {
                        1 => var.name.clone(),
                        width => format!("{} [{}:0]", var.name, width - 1),
                    };
                    let bits = FstSignalType::bit_vec(var.width);
                    if ids[slot].is_none() {
                        slots.push(slot);
                    }
                    ids[slot] = Some(header.var(name, bits, kind, FstVarDirection::Implicit, ids[slot])?);
                }
                Declaration::Close => header.up_scope()?,
            }
        }
        let mut file = header.finish()?.finish()?.into_inner();
        // a whole file ends with values, of which there are none yet
        let mut at = 0;
        while file.get(at).is_some_and(|&kind| kind != VALUES) {
            let length = file[at + 1..].first_chunk().map_or(0, |length| u64::from_be_bytes(*length));
            at += 1 + length as usize;
        }
        file.truncate(at);
        Ok((file, slots))
    }
}

type Beginning = (Vec<u8>, Vec<usize>);

/// The destination's own fault, if it is one.
fn fault(error: FstWriteError) -> io::Error {
    match error {
        FstWriteError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<D: Destination + Seek> Format for Fst<D> {
    fn header(&mut self, layout: &Layout, slot_of: &[u32]) -> io::Result<()> {
        let mut names = layout.scopes.iter().map(|s| &s.name).chain(layout.vars.iter().map(|v| &v.name));
        if let Some(name) = names.find(|name| name.len() + INDEX > LONGEST) {
            let start: String = name.chars().take(40).collect();
            let text = format!("FST holds names of up to {} bytes; `{start}…` is longer: write VCD", LONGEST - INDEX);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        if std::mem::replace(&mut self.begun, true) {
            return Err(io::Error::other("begun twice"));
        }
        self.destination.stream_position()?;
        let (beginning, slots) = Fst::<D>::beginning(layout, slot_of).map_err(fault)?;
        let originals = layout.vars.iter().filter(|var| var.alias_of.is_none());
        let widths: Vec<u32> = originals.map(|var| var.width).collect();
        self.section = Section::new(slots.iter().map(|&slot| widths[slot]));
        self.signals = vec![0; slots.len()];
        slots.iter().zip(0..).for_each(|(&slot, signal)| self.signals[slot] = signal);
        self.destination.write_all(&beginning)
    }

    fn first(&mut self, now: u64) -> io::Result<()> {
        self.instant = now == 0;
        self.first = true;
        self.now = now;
        if !self.instant {
            self.section.time(now);
        }
        Ok(())
    }

    fn first_done(&mut self) -> io::Result<()> {
        self.first = false;
        Ok(())
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.instant = false;
        self.now = now;
        // a section ends between two times
        if self.section.size() > SECTION {
            self.flush()?;
        }
        self.section.time(now);
        Ok(())
    }

    #[inline]
    fn value(&mut self, slot: usize, width: u32, value: &[Word]) -> io::Result<()> {
        let signal = self.signals[slot] as usize;
        if !self.first {
            self.section.change(signal, value);
        } else if self.instant {
            self.section.first(signal, value);
        } else if !(0..value.len()).all(|i| value[i] == Word::x(word_mask(width, i))) {
            self.section.change(signal, value);
        }
        Ok(())
    }

    #[inline(always)]
    fn word(&mut self, slot: usize, width: u32, word: Word) -> io::Result<()> {
        if self.first {
            return self.value(slot, width, &[word]);
        }
        self.section.word(self.signals[slot] as usize, word);
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        // a section without any time but 0 is one that readers stumble over
        if self.instant {
            self.now = 1;
            self.section.time(1);
        }
        self.flush()?;
        for (at, number) in [(END, self.now), (SECTIONS, self.sections)] {
            self.destination.seek(SeekFrom::Start(at))?;
            self.destination.write_all(&number.to_be_bytes())?;
        }
        self.destination.complete()
    }
}

#[cfg(test)]
#[path = "fst_tests.rs"]
mod tests;
