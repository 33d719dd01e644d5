//! Reading a waveform, by `wellen`: VCD, FST and GHW.
//!
//! [`Waves`] holds the names and the times; values are loaded a few variables at a time. A damaged file is an error,
//! whatever the reader makes of it.

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Seek};
use std::path::{Path, PathBuf};

use wellen::{FileFormat, Hierarchy, LoadOptions, SignalRef, SignalSource, viewers};
use wellen::{Signal, SignalValueRef, States};

use super::names::{self, Names};
use super::precheck;
use crate::Timescale;
use crate::guard::caught;

/// What the values of a variable are.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum ValueKind {
    /// Bits, that many.
    Bits(u32),
    /// A real number.
    Real,
    /// Text.
    Text,
    /// Something that happens and has no value.
    Event,
}

impl fmt::Display for ValueKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValueKind::Bits(1) => f.write_str("1 bit"),
            ValueKind::Bits(n) => write!(f, "{n} bits"),
            ValueKind::Real => f.write_str("a real number"),
            ValueKind::Text => f.write_str("text"),
            ValueKind::Event => f.write_str("an event"),
        }
    }
}

/// A variable of a waveform that was read.
#[derive(Clone, Debug)]
pub struct WaveVar {
    /// Its full name: scopes and own name joined by dots, without the index of a whole vector.
    pub name: String,
    /// What its values are.
    pub kind: ValueKind,
    /// The first and the last index of its bits, if the file says: of a vector, of a part of one, or of a single bit.
    pub index: Option<(i64, i64)>,
    /// Whether its bits stand in the file one by one, which does not tell which of them is the most significant: here it
    /// is the one with the highest index.
    pub joined: bool,
    pub(super) signal: SignalRef,
    /// How much of the name is scopes, and how much is all but the index.
    pub(super) scopes: u32,
    pub(super) stem: u32,
}

impl WaveVar {
    /// Its scopes joined by dots; empty at the top.
    #[must_use]
    pub fn scope(&self) -> &str {
        self.name[..self.scopes as usize].trim_end_matches('.')
    }

    /// The full name without an index.
    #[must_use]
    pub fn stem(&self) -> &str {
        &self.name[..self.stem as usize]
    }
}

/// A waveform in a file.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub use discreta_wave as wave;
/// # }
/// use discreta::wave::read::Waves;
/// # let dir = tempfile::tempdir()?;
/// # let path = dir.path().join("a.vcd");
/// # std::fs::write(&path, "$timescale 1 ns $end $scope module top $end $var wire 2 ! q [1:0] $end $upscope $end
/// # $enddefinitions $end\n#0\nbx !\n#5\nb10 !\n#9\n")?;
/// let mut waves = Waves::open(&path)?;
/// let q = waves.find("top.q").unwrap();
/// let changes: Vec<_> = waves.load(q)?.changes().collect();
/// assert_eq!(changes, [(0, "xx".to_string()), (5, "10".to_string())]);
/// assert_eq!(waves.end(), 9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Waves {
    path: PathBuf,
    hierarchy: Hierarchy,
    source: Option<SignalSource>,
    times: Vec<u64>,
    pub(super) vars: Vec<WaveVar>,
    pub(super) scopes: Vec<String>,
    pub(super) index: HashMap<String, usize>,
    exponent: Option<i32>,
}

impl Waves {
    /// Opens a file, whose format is told from what is in it.
    ///
    /// # Errors
    /// It cannot be read, is not a waveform, or is damaged.
    pub fn open(path: &Path) -> Result<Waves, ReadError> {
        let fail = |fault| ReadError { path: path.to_owned(), fault };
        crate::files::reads(path);
        let file = File::open(path).map_err(|error| fail(Fault::Io(error)))?;
        let metadata = file.metadata().map_err(|error| fail(Fault::Io(error)))?;
        // Also: a device has no end, and a pipe cannot be read twice.
        if !metadata.is_file() {
            return Err(fail(Fault::NotAFile));
        }
        if metadata.len() == 0 {
            return Err(fail(Fault::Empty));
        }
        guarded(|| Waves::read(path, file)).map_err(fail)
    }

    fn read(path: &Path, file: File) -> Result<Waves, Fault> {
        let mut input = BufReader::with_capacity(1 << 16, file);
        let format = viewers::detect_file_format(&mut input);
        input.rewind().map_err(Fault::Io)?;
        let has_body = match format {
            FileFormat::Vcd => precheck::vcd(&mut input)?,
            FileFormat::Fst => precheck::fst(&mut input).map(|()| true)?,
            FileFormat::Ghw => true,
            FileFormat::Unknown => return Err(Fault::Unknown),
        };
        input.rewind().map_err(Fault::Io)?;
        // One thread: a panic in another would be out of reach.
        let options = LoadOptions { multi_thread: false, ..LoadOptions::default() };
        let header = viewers::read_header(input, &options).map_err(malformed)?;
        let hierarchy = header.hierarchy;
        let Names { vars, index, scopes } = names::names(&hierarchy)?;
        let exponent = match hierarchy.timescale() {
            Some(timescale) => exponent(timescale)?,
            None => None,
        };
        let (source, times) = if has_body {
            let body = viewers::read_body(header.body, &hierarchy, None).map_err(malformed)?;
            (Some(body.source), body.time_table)
        } else {
            (None, Vec::new())
        };
        if times.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(Fault::Malformed("time goes back".to_owned()));
        }
        Ok(Waves { path: path.to_owned(), hierarchy, source, times, vars, scopes, index, exponent })
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The variables, in the order of the file.
    #[must_use]
    pub fn vars(&self) -> &[WaveVar] {
        &self.vars
    }

    /// The full names of the scopes, in the order of the file.
    #[must_use]
    pub fn scopes(&self) -> &[String] {
        &self.scopes
    }

    /// The index of a variable by its full name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// A tick as a power of ten of a second, if the file says.
    #[must_use]
    pub fn exponent(&self) -> Option<i32> {
        self.exponent
    }

    /// How long a tick is, if the file says so in units that exist.
    #[must_use]
    pub fn timescale(&self) -> Option<Timescale> {
        self.exponent.and_then(Timescale::from_exponent)
    }

    /// The first time of the file in ticks; 0 if there is none.
    #[must_use]
    pub fn start(&self) -> u64 {
        self.times.first().copied().unwrap_or(0)
    }

    /// The last time of the file in ticks; 0 if there is none.
    #[must_use]
    pub fn end(&self) -> u64 {
        self.times.last().copied().unwrap_or(0)
    }

    /// Loads the values of one variable, given by its index.
    ///
    /// # Errors
    /// They are damaged.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load(&mut self, var: usize) -> Result<Series<'_>, ReadError> {
        let signal = self.signals(&[self.vars[var].signal])?.pop();
        Ok(Series { times: &self.times, signal })
    }

    /// Loads signals, in the order in which they are asked for; each at most once. None for a file without values.
    pub(super) fn signals(&mut self, signals: &[SignalRef]) -> Result<Vec<Signal>, ReadError> {
        let Some(source) = &mut self.source else { return Ok(Vec::new()) };
        let loaded = guarded(|| {
            let loaded = source.load_signals(signals, &self.hierarchy, false);
            loaded.iter().try_for_each(|signal| sound(signal, &self.times))?;
            Ok(loaded)
        });
        let mut loaded = loaded.map_err(|fault| ReadError { path: self.path.clone(), fault })?;
        let order: HashMap<_, _> = signals.iter().enumerate().map(|(i, signal)| (*signal, i)).collect();
        loaded.sort_by_key(|signal| order.get(&signal.signal_ref()).copied());
        Ok(loaded)
    }

    pub(super) fn times(&self) -> &[u64] {
        &self.times
    }

    /// For each variable the first one that is a name for the same thing.
    #[must_use]
    pub fn originals(&self) -> Vec<usize> {
        let mut first = HashMap::new();
        self.vars.iter().enumerate().map(|(i, var)| *first.entry(var.signal).or_insert(i)).collect()
    }

    /// Whether two variables, given by their indices, are names for one thing.
    ///
    /// # Panics
    /// If there is no such variable.
    #[must_use]
    pub fn are_one(&self, a: usize, b: usize) -> bool {
        self.vars[a].signal == self.vars[b].signal
    }
}

/// The values of one variable over time.
pub struct Series<'a> {
    times: &'a [u64],
    signal: Option<Signal>,
}

impl Series<'_> {
    /// Each change: the time in ticks and the value from then on, as text; bits the most significant first. The last
    /// one counts where there are several at one time.
    pub fn changes(&self) -> impl Iterator<Item = (u64, String)> + '_ {
        self.signal.iter().flat_map(|signal| changes(signal, self.times).map(|(t, value)| (t, value.to_string())))
    }
}

/// Looks at every value once, where a panic is caught: later ones are then safe to look at.
fn sound(signal: &Signal, times: &[u64]) -> Result<(), Fault> {
    let mut before = 0;
    for (at, value) in signal.iter_changes() {
        if at < before || at as usize >= times.len() {
            return Err(Fault::Malformed("a value has no time".to_owned()));
        }
        before = at;
        // Of nine states four bits each are kept, which can be more than there are states.
        if let SignalValueRef::BitVec(bits) = value
            && bits.states() == States::Nine
        {
            let _ = bits.bit_string();
        }
    }
    Ok(())
}

/// Each time at which a signal changes, with the value that it has when that time is over.
pub(super) fn changes<'a>(
    signal: &'a Signal,
    times: &'a [u64],
) -> impl Iterator<Item = (u64, SignalValueRef<'a>)> + 'a {
    let mut all = signal.iter_changes().peekable();
    std::iter::from_fn(move || {
        let (mut at, mut value) = all.next()?;
        while let Some((_, later)) = all.next_if(|(next, _)| *next == at) {
            (at, value) = (at, later);
        }
        Some((times[at as usize], value))
    })
}

fn exponent(timescale: wellen::Timescale) -> Result<Option<i32>, Fault> {
    let Some(unit) = timescale.unit.to_exponent() else { return Ok(None) };
    match timescale.factor {
        1 => Ok(Some(i32::from(unit))),
        10 => Ok(Some(i32::from(unit) + 1)),
        100 => Ok(Some(i32::from(unit) + 2)),
        other => Err(Fault::Malformed(format!("its timescale is {other} of a unit; it can be 1, 10 or 100"))),
    }
}

fn malformed(error: wellen::WellenError) -> Fault {
    match error {
        wellen::WellenError::FailedToLoad(_, text) => Fault::Malformed(text.trim_start_matches("[vcd] ").to_owned()),
        wellen::WellenError::UnknownFileFormat => Fault::Unknown,
        wellen::WellenError::Io(error) => Fault::Io(error),
    }
}

/// Takes a panic of the reader for what it is: a file that it cannot make sense of.
fn guarded<T>(read: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    caught(read).unwrap_or_else(|said| Err(Fault::Malformed(format!("the reader gave up ({said})"))))
}

/// A waveform that could not be read.
#[derive(Debug)]
pub struct ReadError {
    path: PathBuf,
    fault: Fault,
}

#[derive(Debug)]
pub(super) enum Fault {
    Io(io::Error),
    NotAFile,
    Empty,
    Unknown,
    Cut(String),
    Malformed(String),
}

impl ReadError {
    pub(super) fn malformed(path: &Path, text: String) -> ReadError {
        ReadError { path: path.to_owned(), fault: Fault::Malformed(text) }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What one can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<&'static str> {
        match &self.fault {
            Fault::Io(error) if error.kind() == io::ErrorKind::NotFound => Some("check the spelling of the path"),
            Fault::Io(_) => None,
            Fault::NotAFile => Some("name a file; copy what comes from a pipe into one first"),
            Fault::Empty | Fault::Cut(_) => Some("what wrote it was probably interrupted: make it again"),
            Fault::Unknown => Some("waveforms in VCD, FST and GHW can be read"),
            Fault::Malformed(_) => Some("make it again, or see whether a viewer can read it"),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Io(error) => f.write_str(&super::output::reason(error)),
            Fault::NotAFile => f.write_str("it is not a regular file"),
            Fault::Empty => f.write_str("it is empty"),
            Fault::Unknown => f.write_str("it is not a waveform"),
            Fault::Cut(text) => write!(f, "it is cut off: {text}"),
            Fault::Malformed(text) => write!(f, "it is damaged: {text}"),
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot read the waveform `{}`: {}", self.path.display(), self.fault)
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.fault {
            Fault::Io(error) => Some(error),
            _ => None,
        }
    }
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
