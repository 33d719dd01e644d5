//! Reading a waveform: VCD, FST and GHW.
//!
//! [`Waves`] holds the names and the times; values are loaded a few variables at a time. A reader of a format gives
//! its names to `names` and its values to `signal`, and takes no length or count from a file at its word: what is
//! made room for is what bytes are there for. What is doubtful is noted ([`Waves::warnings`]), a variable that cannot be
//! read is [left out](Waves::left_out), and a file that breaks off is read up to there ([`Waves::is_cut`]).

mod bytes;
mod fst;
mod fst_blocks;
mod fst_names;
mod fst_values;
mod ghw;
mod ghw_types;
mod ghw_values;
pub(super) mod names;
mod notes;
pub(super) mod signal;
mod tokens;
mod unpack;
mod vcd;

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use names::{Made, Names};
use notes::Notes;
use signal::Signal;
pub use signal::logic;

use crate::Timescale;

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
    /// Which of [`Names::signals`] has its values.
    pub(super) signal: u32,
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
/// #     pub mod wave { pub use discreta_wave::*; }
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
    pub(crate) names: Names,
    source: Source,
    times: Vec<u64>,
    exponent: Option<i32>,
    notes: Notes,
}

/// A variable that was left out.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct LeftOut {
    /// Its full name.
    pub name: String,
    /// What is wrong with it.
    pub why: String,
}

/// What a reader makes of a file.
struct Contents {
    names: Names,
    exponent: Option<i32>,
    /// The times at which anything changes, each later than the one before.
    times: Vec<u64>,
    source: Source,
    notes: Notes,
}

/// Where the values of the signals of a file are, by their numbers.
enum Source {
    Memory(Vec<Arc<Signal>>),
    Fst(fst_values::Values),
}

/// A file, or what was packed in one.
trait Input: Read + Seek + Send {}
impl<T: Read + Seek + Send> Input for T {}

impl Waves {
    /// Opens a file, whose format is told from what is in it.
    ///
    /// # Errors
    /// It cannot be read, is not a waveform, or is damaged so that nothing can be made of it.
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
        Waves::read(path, file, metadata.len()).map_err(fail)
    }

    /// Reads a waveform that is in memory; `path` is what it is called.
    ///
    /// # Errors
    /// As [`open`](Waves::open).
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Waves, ReadError> {
        let length = bytes.len() as u64;
        let read = Waves::read(path, io::Cursor::new(bytes), length);
        read.map_err(|fault| ReadError { path: path.to_owned(), fault })
    }

    fn read(path: &Path, input: impl Input + 'static, length: u64) -> Result<Waves, Fault> {
        let mut input = BufReader::with_capacity(1 << 16, input);
        let mut beginning = Vec::new();
        input.by_ref().take(1 << 12).read_to_end(&mut beginning).map_err(Fault::Io)?;
        input.rewind().map_err(Fault::Io)?;
        let Contents { names, exponent, times, source, notes } = if vcd::is_vcd(&beginning) {
            vcd::read(input, length)?
        } else if ghw::is_ghw(&beginning) {
            ghw::read(input, length)?
        } else if fst::is_fst(&beginning) {
            fst::read(Box::new(input), path)?
        } else {
            return Err(Fault::Unknown);
        };
        Ok(Waves { path: path.to_owned(), names, source, times, exponent, notes })
    }

    /// What is doubtful about the file, in sentences without their end.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.notes.warnings()
    }

    /// The variables that are not among [`vars`](Waves::vars), because they cannot be read.
    #[must_use]
    pub fn left_out(&self) -> &[LeftOut] {
        &self.names.left_out
    }

    /// Whether the file breaks off: what wrote it was interrupted, or goes on writing.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.notes.cut.is_some()
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The variables, in the order of the file.
    #[must_use]
    pub fn vars(&self) -> &[WaveVar] {
        &self.names.vars
    }

    /// The full names of the scopes, in the order of the file.
    #[must_use]
    pub fn scopes(&self) -> &[String] {
        &self.names.scopes
    }

    /// The index of a variable by its full name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.index.get(name).copied()
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
        let signal = self.signals(&[self.names.vars[var].signal])?.remove(0);
        Ok(Series { times: &self.times, signal })
    }

    /// Loads the values of several variables, given by their indices, in one pass over the file.
    ///
    /// # Errors
    /// They are damaged.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load_all(&mut self, vars: &[usize]) -> Result<Vec<Series<'_>>, ReadError> {
        let signals: Vec<u32> = vars.iter().map(|&var| self.names.vars[var].signal).collect();
        let loaded = self.signals(&signals)?;
        Ok(loaded.into_iter().map(|signal| Series { times: &self.times, signal }).collect())
    }

    /// Loads signals of variables, in the order in which they are asked for.
    pub(super) fn signals(&mut self, signals: &[u32]) -> Result<Vec<Arc<Signal>>, ReadError> {
        let made: Vec<&Made> = signals.iter().map(|&signal| &self.names.signals[signal as usize]).collect();
        let mut wanted = Vec::new();
        for made in &made {
            match made {
                Made::Of(number) => wanted.push(*number),
                Made::Joined(parts) => wanted.extend(parts.iter().map(|(number, _)| *number)),
            }
        }
        wanted.sort_unstable();
        wanted.dedup();
        let loaded: Vec<Arc<Signal>> = match &mut self.source {
            Source::Memory(all) => wanted.iter().map(|&number| all[number as usize].clone()).collect(),
            Source::Fst(values) => {
                values.load(&wanted).map_err(|fault| ReadError { path: self.path.clone(), fault })?
            }
        };
        let at = |number: u32| &loaded[wanted.binary_search(&number).expect("it was asked for")];
        let signal = |made: &&Made| match made {
            Made::Of(number) => at(*number).clone(),
            Made::Joined(parts) => {
                let parts: Vec<(&Signal, u32)> = parts.iter().map(|&(number, width)| (&**at(number), width)).collect();
                Arc::new(signal::joined(&parts))
            }
        };
        Ok(made.iter().map(signal).collect())
    }

    pub(super) fn times(&self) -> &[u64] {
        &self.times
    }

    /// For each variable the first one that is a name for the same thing.
    #[must_use]
    pub fn originals(&self) -> Vec<usize> {
        let mut first = HashMap::new();
        self.names.vars.iter().enumerate().map(|(i, var)| *first.entry(var.signal).or_insert(i)).collect()
    }

    /// Whether two variables, given by their indices, are names for one thing.
    ///
    /// # Panics
    /// If there is no such variable.
    #[must_use]
    pub fn are_one(&self, a: usize, b: usize) -> bool {
        self.names.vars[a].signal == self.names.vars[b].signal
    }
}

/// The values of one variable over time.
pub struct Series<'a> {
    times: &'a [u64],
    signal: Arc<Signal>,
}

impl Series<'_> {
    /// Each change: the time in ticks and the value from then on, as text; bits the most significant first. The last
    /// one counts where there are several at one time.
    pub fn changes(&self) -> impl Iterator<Item = (u64, String)> + '_ {
        changes(&self.signal, self.times).map(|(time, value)| (time, value.to_string()))
    }
}

/// Each time at which a signal changes, with the value that it has when that time is over.
pub(super) fn changes<'a>(signal: &'a Signal, times: &'a [u64]) -> impl Iterator<Item = (u64, signal::Value<'a>)> + 'a {
    signal.changes().map(|(at, value)| (times[at as usize], value))
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
mod tests;
