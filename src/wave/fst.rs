//! Writing FST, GTKWave's compressed format, while a run goes on.
//!
//! The `fst-writer` crate does the format. Changes are kept by it and compressed some megabytes at a time, so memory
//! does not grow with the run. The bytes are the same everywhere: no date, no version number. The numbers in its header
//! are known at the end only, so the destination is one that can go back.

use std::io::{self, BufWriter, Seek};

use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType, FstVarDirection,
    FstVarType, FstWriteError,
};

use super::layout::Declaration;
use super::output::Destination;
use super::recorder::{Format, Recorder};
use super::{Layout, ScopeKind, VarKind};
use crate::value::Word;

/// How many bytes of changes are kept before they are compressed.
const SECTION: usize = 32 << 20;

/// The longest name that readers of the format make room for, in bytes.
const LONGEST: usize = 511;
/// What may stand behind a name: ` [16777215:0]`.
const INDEX: usize = 13;

/// A [`Sink`](super::Sink) that writes FST. A run that ends at tick 0 is shown up to tick 1: the format has no waveform
/// of a single instant.
///
/// ```
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
    state: State<D>,
    /// The signals of the file by slot.
    ids: Vec<FstSignalId>,
    /// A value as text, for the crate.
    text: Vec<u8>,
    /// There was no time but 0 yet.
    instant: bool,
}

enum State<D: Destination + Seek> {
    New(D),
    Body(Box<FstBodyWriter<BufWriter<D>>>),
    /// It failed or is complete.
    Done,
}

impl<D: Destination + Seek> FstWriter<D> {
    /// A writer into this destination; nothing is written before [`Sink::begin`](super::Sink::begin).
    pub fn new(destination: D) -> FstWriter<D> {
        Recorder::with(Fst { state: State::New(destination), ids: Vec::new(), text: Vec::new(), instant: true })
    }
}

impl<D: Destination + Seek> Fst<D> {
    fn body(&mut self) -> io::Result<&mut FstBodyWriter<BufWriter<D>>> {
        match &mut self.state {
            State::Body(body) => Ok(body),
            _ => Err(io::Error::other("written to after it was complete or had failed")),
        }
    }

    fn declare(
        &mut self,
        header: &mut FstHeaderWriter<BufWriter<D>>,
        layout: &Layout,
        slot_of: &[u32],
    ) -> Result<(), FstWriteError> {
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
                    ids[slot] = Some(header.var(name, bits, kind, FstVarDirection::Implicit, ids[slot])?);
                }
                Declaration::Close => header.up_scope()?,
            }
        }
        self.ids = ids.into_iter().flatten().collect();
        Ok(())
    }
}

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
        let State::New(mut destination) = std::mem::replace(&mut self.state, State::Done) else {
            return Err(io::Error::other("begun twice"));
        };
        destination.stream_position()?;
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: layout.timescale.exponent() as i8,
            version: "discreta".to_owned(),
            date: String::new(),
            file_type: FstFileType::Verilog,
        };
        let mut header = FstHeaderWriter::new(BufWriter::new(destination), &info).map_err(fault)?;
        self.declare(&mut header, layout, slot_of).map_err(fault)?;
        self.state = State::Body(Box::new(header.finish().map_err(fault)?));
        Ok(())
    }

    fn first(&mut self, now: u64) -> io::Result<()> {
        self.instant = now == 0;
        self.body()?.time_change(now).map_err(fault)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.instant = false;
        let body = self.body()?;
        // a section ends between two times
        if body.size() > SECTION {
            body.flush().map_err(fault)?;
        }
        body.time_change(now).map_err(fault)
    }

    fn value(&mut self, slot: usize, width: u32, value: &[Word]) -> io::Result<()> {
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        text.extend((0..width as usize).rev().map(|bit| {
            let (word, at) = (value[bit / 64], bit % 64);
            b"01xz"[(word.v >> at & 1 | (word.u >> at & 1) << 1) as usize]
        }));
        let id = self.ids[slot];
        let told = self.body()?.signal_change(id, &text).map_err(fault);
        self.text = text;
        told
    }

    fn finish(&mut self) -> io::Result<()> {
        let State::Body(mut body) = std::mem::replace(&mut self.state, State::Done) else {
            return Err(io::Error::other("complete already"));
        };
        // a section without any time but 0 is one that readers stumble over
        if self.instant {
            body.time_change(1).map_err(fault)?;
        }
        let buffered = body.finish().map_err(fault)?;
        buffered.into_inner().map_err(io::IntoInnerError::into_error)?.complete()
    }
}

#[cfg(test)]
#[path = "fst_tests.rs"]
mod tests;
