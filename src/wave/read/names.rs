//! What the variables and scopes of a waveform are called: one name for each, whatever the tool that wrote it makes of
//! brackets and backslashes.
//!
//! A reader tells an [`Outline`] of scopes and variables in the order of its file. Here the index is taken off a name,
//! elements of arrays get a scope, the bits of a vector that a file has one by one are joined, and names are made unique.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};

use super::{Fault, LeftOut, ValueKind, WaveVar};
use crate::Layout;

/// Scopes inside one another.
pub(crate) const MAX_DEPTH: usize = 10_000;
/// Bytes of all full names together, and how many of them for each byte of the file: scopes inside one another repeat the
/// names around them in each of theirs, and a small file of this kind could fill any memory. Whatever declares a variable
/// takes more than ten bytes, so names of files that are meant are some ten thousand letters long before they get here.
const NAMES: u64 = 1 << 26;
const NAMES_PER_BYTE: u64 = 1000;
const ALL_NAMES: u64 = 1 << 32;

/// The names of a waveform.
#[derive(Debug, Default)]
pub(crate) struct Names {
    pub vars: Vec<WaveVar>,
    /// The variables by their full names.
    pub index: HashMap<String, usize>,
    /// The full names of the scopes.
    pub scopes: Vec<String>,
    /// What each signal of a variable is made of.
    pub signals: Vec<Made>,
    /// Variables that are not read, and why.
    pub left_out: Vec<LeftOut>,
}

/// What the signal of a variable is made of: signals of the file, numbered by its reader.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Made {
    /// One of them.
    Of(u32),
    /// Several, the most significant first, each with its width.
    Joined(VecDeque<(u32, u32)>),
}

/// A variable that is not yet named.
struct Entered {
    /// Its scopes with a dot behind them.
    scope: u32,
    name: String,
    kind: ValueKind,
    index: Option<(i64, i64)>,
    made: Made,
    joined: bool,
}

/// Takes the scopes and variables of a file.
pub(super) struct Outline {
    /// All scopes; the first is what is around all.
    scopes: Vec<Scope>,
    /// The scopes that are open, the innermost last.
    open: Vec<Open>,
    /// The scopes by what is around them and their own names.
    known: HashMap<(u32, String), u32>,
    entered: Vec<Entered>,
    /// The last thing told was this variable, and may go on.
    last: Option<usize>,
    left_out: Vec<(u32, String, String)>,
    /// How many bytes of names there may yet be.
    room: u64,
}

struct Scope {
    around: u32,
    name: String,
    /// The length of its full name with a dot behind it.
    length: u64,
}

#[derive(Clone, Copy)]
struct Open {
    scope: u32,
    array: Array,
}

/// What a scope is to the names of variables in it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Array {
    /// Nothing special.
    #[default]
    No,
    /// An array: its elements are called by their index.
    Packed,
    /// An array whose elements are no parts of one vector.
    Unpacked,
}

impl Outline {
    /// For a file that tells its names in so many bytes.
    pub fn new(length: u64) -> Outline {
        Outline {
            scopes: vec![Scope { around: 0, name: String::new(), length: 0 }],
            open: Vec::new(),
            known: HashMap::new(),
            entered: Vec::new(),
            last: None,
            left_out: Vec::new(),
            room: length.saturating_mul(NAMES_PER_BYTE).saturating_add(NAMES).min(ALL_NAMES),
        }
    }

    /// The innermost scope.
    fn here(&self) -> u32 {
        self.open.last().map_or(0, |open| open.scope)
    }

    fn array(&self) -> Array {
        self.open.last().map_or(Array::No, |open| open.array)
    }

    /// Opens a scope.
    pub fn enter(&mut self, name: &str, array: Array) -> Result<(), Fault> {
        if self.open.len() >= MAX_DEPTH {
            return Err(Fault::Malformed(format!("more than {MAX_DEPTH} scopes inside one another")));
        }
        let around = self.here();
        let name = plain(name).to_owned();
        let length = self.scopes[around as usize].length + name.len() as u64 + 1;
        let new = self.scopes.len() as u32;
        let scope = *self.known.entry((around, name.clone())).or_insert(new);
        if scope == new {
            self.scopes.push(Scope { around, name, length });
            self.count(length)?;
        }
        self.open.push(Open { scope, array });
        self.last = None;
        Ok(())
    }

    /// Closes the scope that was opened last; false if none is open.
    pub fn leave(&mut self) -> bool {
        self.last = None;
        self.open.pop().is_some()
    }

    fn count(&mut self, bytes: u64) -> Result<(), Fault> {
        self.room = self.room.checked_sub(bytes).ok_or_else(|| {
            Fault::Malformed("its names are longer, scopes and all, than a thousand times the file".to_owned())
        })?;
        Ok(())
    }

    /// Tells a variable as VCD and FST write it: with its index, if it has one, behind its name. `signal` is its number
    /// in the file.
    pub fn declare(&mut self, raw: &str, kind: ValueKind, signal: u32) -> Result<(), Fault> {
        let width = match kind {
            ValueKind::Bits(width) => Some(width),
            _ => None,
        };
        let (mut name, mut index) = split(raw, width);
        let mut around = Vec::new();
        while name.ends_with(']')
            && let Some(at) = name.rfind('[').filter(|&at| at > 0)
        {
            around.push(name[at..].to_owned());
            name = name[..at].trim_end();
        }
        // the name of an array is a scope around those of its elements
        let mut own = name.to_owned();
        if let Some(first) = around.first().cloned() {
            around.remove(0);
            around.push(own);
            around.reverse();
            own = first;
        }
        let array = self.array();
        if array != Array::No {
            // Verilator says the name of the array again in those of its elements
            let name = |open: &Open| self.scopes[open.scope as usize].name.as_str();
            let ends = |said: &[String]| {
                let from = self.open.len().checked_sub(said.len());
                from.is_some_and(|from| self.open[from..].iter().map(name).eq(said))
            };
            if let Some(said) = (1..=around.len()).rev().find(|&n| ends(&around[..n])) {
                around.drain(..said);
            } else if let Some(rest) = own.strip_prefix(self.open.last().map_or("", name)).filter(|_| around.is_empty())
            {
                own = rest.to_owned();
            }
            if let (Array::Unpacked, Some((at, to))) = (array, index)
                && at == to
            {
                own = format!("{own}[{at}]");
                index = None;
            }
        }
        for scope in &around {
            self.enter(scope, Array::Packed)?;
        }
        self.add(own, kind, index, Made::Of(signal))?;
        for _ in &around {
            self.leave();
        }
        Ok(())
    }

    /// Tells a variable whose name and index are known.
    pub fn add(&mut self, name: String, kind: ValueKind, index: Option<(i64, i64)>, made: Made) -> Result<(), Fault> {
        if let ValueKind::Bits(width) = kind
            && !(1..=Layout::MAX_WIDTH).contains(&width)
        {
            let max = Layout::MAX_WIDTH;
            self.leave_out(name, format!("it is {width} bits wide; 1 to {max} are read"));
            return Ok(());
        }
        let unpacked = self.array() == Array::Unpacked;
        if let (Some(last), Some(index), ValueKind::Bits(width), Made::Of(signal)) = (self.last, index, kind, &made)
            && !unpacked
            && self.entered[last].join(&name, index, width, *signal)
        {
            return Ok(());
        }
        self.count(self.scopes[self.here() as usize].length + name.len() as u64)?;
        let joined = kind == ValueKind::Bits(1) && index.is_some();
        self.entered.push(Entered { scope: self.here(), name, kind, index, made, joined });
        self.last = Some(self.entered.len() - 1);
        Ok(())
    }

    /// Tells a variable that is not read.
    pub fn leave_out(&mut self, name: String, why: String) {
        self.last = None;
        self.left_out.push((self.here(), name, why));
    }

    /// The names; `bad` says what is wrong with the values of a signal of the file.
    pub fn names(self, bad: impl Fn(u32) -> Option<String>) -> Names {
        let mut names = Names::default();
        // what is around a scope comes before it
        let mut paths: Vec<String> = Vec::with_capacity(self.scopes.len());
        for (i, scope) in self.scopes.iter().enumerate() {
            paths.push(if i == 0 { String::new() } else { format!("{}{}.", paths[scope.around as usize], scope.name) });
        }
        let path = |scope: u32| paths[scope as usize].as_str();
        let mut again = HashMap::new();
        let mut known: HashMap<Made, u32> = HashMap::new();
        for var in self.entered {
            let (scope, own) = (path(var.scope), plain(&var.name));
            let stem = scope.len() + own.len();
            // the index of a single bit: `q[3]` where a file has some bits of a vector alone
            let name = match var.index {
                Some((msb, lsb)) if msb == lsb => format!("{scope}{own}[{msb}]"),
                _ => format!("{scope}{own}"),
            };
            let why = match &var.made {
                Made::Of(signal) => bad(*signal),
                Made::Joined(parts) => parts.iter().find_map(|(signal, _)| bad(*signal)),
            };
            if let Some(why) = why {
                names.left_out.push(LeftOut { name, why });
                continue;
            }
            let name = unique(name, var.index, &mut names.index, &mut again, names.vars.len());
            let signal = *known.entry(var.made.clone()).or_insert_with(|| {
                names.signals.push(var.made);
                names.signals.len() as u32 - 1
            });
            let joined = var.joined && var.kind != ValueKind::Bits(1);
            let (scopes, stem) = (scope.len() as u32, stem as u32);
            names.vars.push(WaveVar { name, kind: var.kind, index: var.index, joined, signal, scopes, stem });
        }
        let left_out = self.left_out.into_iter();
        names
            .left_out
            .extend(left_out.map(|(s, name, why)| LeftOut { name: format!("{}{}", path(s), plain(&name)), why }));
        names.scopes = paths.into_iter().skip(1).collect();
        for path in &mut names.scopes {
            path.pop();
        }
        names
    }
}

impl Entered {
    /// Takes a part of the same vector that lies above or below it. Some simulators write the bits of a vector one by one.
    fn join(&mut self, name: &str, (msb, lsb): (i64, i64), width: u32, signal: u32) -> bool {
        let (ValueKind::Bits(own), Some((high, low))) = (self.kind, self.index) else { return false };
        let whole = |(msb, lsb): (i64, i64), width: u32| msb.abs_diff(lsb).checked_add(1) == Some(width.into());
        let Some(sum) = own.checked_add(width).filter(|sum| *sum <= Layout::MAX_WIDTH) else { return false };
        if self.name != name || !whole((msb, lsb), width) || !whole((high, low), own) || msb < lsb || high < low {
            return false;
        }
        let above = lsb.checked_sub(1) == Some(high);
        if !above && low.checked_sub(1) != Some(msb) {
            return false;
        }
        let mut parts = match std::mem::replace(&mut self.made, Made::Joined(VecDeque::new())) {
            Made::Of(signal) => VecDeque::from([(signal, own)]),
            Made::Joined(parts) => parts,
        };
        if above {
            parts.push_front((signal, width));
            self.index = Some((msb, low));
        } else {
            parts.push_back((signal, width));
            self.index = Some((high, lsb));
        }
        self.made = Made::Joined(parts);
        self.kind = ValueKind::Bits(sum);
        self.joined &= width == 1;
        true
    }
}

/// The same of a whole path.
pub(crate) fn plain_path(path: &str) -> String {
    path.split('.').map(plain).collect::<Vec<_>>().join(".")
}

/// A name without the backslash by which Verilog escapes it, and which some simulators write.
fn plain(name: &str) -> &str {
    name.strip_prefix('\\').filter(|rest| !rest.is_empty()).unwrap_or(name)
}

/// A name and the index behind it, if that is one of as many bits as there are.
fn split(raw: &str, width: Option<u32>) -> (&str, Option<(i64, i64)>) {
    let raw = raw.trim_end();
    let index = || {
        let at = raw.rfind('[').filter(|&at| at > 0)?;
        let inner = raw[at + 1..].strip_suffix(']')?;
        let number = |text: &str| text.trim().parse::<i64>().ok();
        let (msb, lsb) = match inner.split_once(':') {
            Some((msb, lsb)) => (number(msb)?, number(lsb)?),
            None => (number(inner)?, number(inner)?),
        };
        let bits = msb.abs_diff(lsb).checked_add(1)?;
        (width.map(u64::from) == Some(bits)).then(|| (raw[..at].trim_end(), Some((msb, lsb))))
    };
    index().filter(|(name, _)| !name.is_empty()).unwrap_or((raw, None))
}

/// Enters a name that is not there yet: parts of one vector get their range, what is still the same a number.
fn unique(
    name: String,
    range: Option<(i64, i64)>,
    index: &mut HashMap<String, usize>,
    again: &mut HashMap<String, u64>,
    at: usize,
) -> String {
    let range = range.map(|(msb, lsb)| format!("{name}[{msb}:{lsb}]"));
    for candidate in [Some(name.clone()), range].into_iter().flatten() {
        if let Entry::Vacant(free) = index.entry(candidate.clone()) {
            free.insert(at);
            return candidate;
        }
    }
    loop {
        let count = again.entry(name.clone()).or_insert(1);
        *count += 1;
        let candidate = format!("{name}#{count}");
        if let Entry::Vacant(free) = index.entry(candidate.clone()) {
            free.insert(at);
            return candidate;
        }
    }
}
