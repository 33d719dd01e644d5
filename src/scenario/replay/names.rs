//! Where in a waveform a circuit stands, and which of its variables are which nets.

use std::collections::HashMap;

use crate::netlist::{Netlist, SignalId};
use crate::wave::read::{ValueKind, WaveVar, Waves};

/// A variable that is a net, or a part of one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Part {
    /// Its index in the waveform.
    pub var: usize,
    /// The lowest bit of the net that it is.
    pub at: u32,
    /// How many.
    pub width: u32,
}

/// Why no variable is a net.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Mismatch {
    /// There is none of its name.
    Missing,
    /// It is not of bits.
    Kind(ValueKind),
    /// It has another number of bits.
    Width(u32),
    /// It stands there bit by bit, with so many of them.
    Bits(u32),
}

/// The variables of a waveform by their names without indices.
pub(super) struct Names<'w> {
    waves: &'w Waves,
    by_stem: HashMap<&'w str, Vec<usize>>,
}

impl<'w> Names<'w> {
    pub fn new(waves: &'w Waves) -> Names<'w> {
        let mut by_stem: HashMap<&str, Vec<usize>> = HashMap::new();
        for (i, var) in waves.vars().iter().enumerate() {
            by_stem.entry(var.stem()).or_default().push(i);
        }
        Names { waves, by_stem }
    }

    fn full(scope: &str, path: &str) -> String {
        if scope.is_empty() { path.to_owned() } else { format!("{scope}.{path}") }
    }

    /// Whether there is anything of this name, whatever it is.
    pub fn has(&self, scope: &str, path: &str) -> bool {
        let full = Names::full(scope, path);
        self.by_stem.contains_key(full.as_str()) || self.waves.find(&full).is_some()
    }

    /// What a net of `width` bits is in the waveform: one variable, or several that have its bits one by one or in
    /// parts, without a gap.
    pub fn parts(&self, scope: &str, path: &str, width: u32) -> Result<Vec<Part>, Mismatch> {
        let full = Names::full(scope, path);
        // `a[3]` may be a name
        let exact = self.waves.find(&full);
        let vars: Vec<(usize, &WaveVar)> = match self.by_stem.get(full.as_str()) {
            Some(vars) => vars.iter().map(|&i| (i, &self.waves.vars()[i])).collect(),
            None => exact.iter().map(|&i| (i, &self.waves.vars()[i])).collect(),
        };
        if let Some(&(var, _)) = vars.iter().find(|(_, v)| v.kind == ValueKind::Bits(width)) {
            return Ok(vec![Part { var, at: 0, width }]);
        }
        let Some((_, first)) = vars.first() else { return Err(Mismatch::Missing) };
        let mut pieces = Vec::new();
        for (i, var) in &vars {
            match (var.kind, var.index) {
                (ValueKind::Bits(bits), Some((msb, lsb))) if msb.abs_diff(lsb) + 1 == u64::from(bits) => {
                    pieces.push((*i, msb, lsb, bits));
                }
                (ValueKind::Bits(bits), _) => return Err(Mismatch::Width(bits)),
                (kind, _) => return Err(Mismatch::Kind(kind)),
            }
        }
        if let [only] = pieces[..]
            && let ValueKind::Bits(bits) = first.kind
            && only.1 != only.2
        {
            return Err(Mismatch::Width(bits));
        }
        let upwards = pieces.iter().any(|(_, msb, lsb, _)| msb < lsb);
        let lowest = pieces.iter().map(|(_, msb, lsb, _)| *msb.min(lsb)).min().unwrap_or(0);
        let highest = pieces.iter().map(|(_, msb, lsb, _)| *msb.max(lsb)).max().unwrap_or(0);
        let mut parts: Vec<Part> = Vec::new();
        for (var, msb, lsb, width) in pieces {
            let at = if upwards { highest.abs_diff(msb.max(lsb)) } else { lowest.abs_diff(msb.min(lsb)) };
            parts.push(Part { var, at: u32::try_from(at).unwrap_or(u32::MAX), width });
        }
        parts.sort_by_key(|part| (part.at, part.width, part.var));
        parts.dedup_by_key(|part| (part.at, part.width));
        let mut next = 0;
        for part in &parts {
            if part.at != next {
                return Err(Mismatch::Bits(parts.iter().map(|p| p.width).sum()));
            }
            next += part.width;
        }
        if next == width { Ok(parts) } else { Err(Mismatch::Bits(next)) }
    }

    /// Whether two scopes show the same things: every net of the circuit that is in one is in the other, and the same.
    fn same(&self, a: &str, b: &str, netlist: &Netlist) -> bool {
        named(netlist).all(|signal| {
            let (path, width) = (netlist.signal_path(signal), netlist.signal(signal).width);
            match (self.parts(a, &path, width), self.parts(b, &path, width)) {
                (Ok(a), Ok(b)) => {
                    a.len() == b.len()
                        && a.iter().zip(&b).all(|(a, b)| a.at == b.at && self.waves.are_one(a.var, b.var))
                }
                (Err(_), Err(_)) => true,
                _ => false,
            }
        })
    }

    /// The scopes that have everything in `wanted`, that or those first in which most nets of the circuit are. One
    /// alone if the others have fewer or show the same.
    pub fn scopes(&self, wanted: &[&str], netlist: &Netlist) -> Vec<&'w str> {
        let all = std::iter::once("").chain(self.waves.scopes().iter().map(String::as_str));
        let mut having: Vec<&str> = all.filter(|scope| wanted.iter().all(|name| self.has(scope, name))).collect();
        having.dedup();
        if having.len() > 1 {
            let paths: Vec<String> = named(netlist).map(|s| netlist.signal_path(s)).collect();
            let count = |scope: &str| paths.iter().filter(|path| self.has(scope, path)).count();
            let counts: Vec<usize> = having.iter().map(|scope| count(scope)).collect();
            let most = counts.iter().copied().max().unwrap_or(0);
            having = having.into_iter().zip(counts).filter(|(_, n)| *n == most && most > 0).map(|(s, _)| s).collect();
        }
        if having.len() > 1 && having[1..].iter().all(|other| self.same(having[0], other, netlist)) {
            having.truncate(1);
        }
        having
    }

    /// The scope that has most of what is wanted, if any has some.
    pub fn nearest(&self, wanted: &[&str]) -> Option<&'w str> {
        let all: Vec<&str> = std::iter::once("").chain(self.waves.scopes().iter().map(String::as_str)).collect();
        let count = |scope: &str| wanted.iter().filter(|name| self.has(scope, name)).count();
        // the first of those that have as many
        all.into_iter()
            .map(|scope| (count(scope), scope))
            .filter(|(n, _)| *n > 0)
            .rev()
            .max_by_key(|(n, _)| *n)
            .map(|(_, s)| s)
    }
}

/// The nets that people named.
pub(super) fn named(netlist: &Netlist) -> impl Iterator<Item = SignalId> + '_ {
    netlist.signal_ids().filter(|&signal| !netlist.signal(signal).hidden)
}
