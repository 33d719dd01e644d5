//! Where in a waveform a circuit stands, and which of its variables are which nets. Knows names and widths, no values.

use std::collections::{HashMap, HashSet};

use crate::netlist::{Netlist, Signal, SignalId};
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
    /// Whether its most significant bit is the least significant of the net's.
    pub reversed: bool,
}

/// The variables that are a net, the least significant first, without a gap.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Found {
    /// The variables.
    pub parts: Vec<Part>,
    /// Their bits together: how wide the net is in the waveform.
    pub width: u32,
    /// The index of the least significant bit, if the file says.
    lsb: Option<i64>,
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
    /// It stands there in parts, with so many bits together.
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

    /// What a net is in the waveform, with the circuit's width: one variable, or several that have its bits one by one
    /// or in parts.
    pub fn parts(&self, scope: &str, path: &str, signal: &Signal) -> Result<Vec<Part>, Mismatch> {
        let found = self.net(scope, path, signal)?;
        if found.width == signal.width { Ok(found.parts) } else { Err(found.mismatch()) }
    }

    /// What a net is in the waveform, however wide it is there.
    pub fn net(&self, scope: &str, path: &str, signal: &Signal) -> Result<Found, Mismatch> {
        let full = Names::full(scope, path);
        // `a[3]` may be a name
        let exact = self.waves.find(&full);
        let vars: Vec<(usize, &WaveVar)> = match self.by_stem.get(full.as_str()) {
            Some(vars) => vars.iter().map(|&i| (i, &self.waves.vars()[i])).collect(),
            None => exact.iter().map(|&i| (i, &self.waves.vars()[i])).collect(),
        };
        let Some((_, first)) = vars.first() else { return Err(Mismatch::Missing) };
        let mut pieces = Vec::new();
        for (i, var) in &vars {
            if let ValueKind::Bits(width) = var.kind {
                let index = var.index.filter(|(msb, lsb)| msb.abs_diff(*lsb) + 1 == u64::from(width));
                pieces.push(Piece { var: *i, index, width, joined: var.joined });
            }
        }
        if pieces.is_empty() {
            return Err(Mismatch::Kind(first.kind));
        }
        let wholes = || pieces.iter().filter(|piece| pieces.iter().all(|other| piece.covers(other)));
        if let Some(whole) = wholes().find(|whole| whole.width == signal.width).or_else(|| wholes().next()) {
            let reversed = whole.joined && signal.upto;
            let lsb = whole.index.map(|(msb, lsb)| if reversed { msb } else { lsb });
            let parts = vec![Part { var: whole.var, at: 0, width: whole.width, reversed }];
            return Ok(Found { parts, width: whole.width, lsb });
        }
        assembled(&pieces, signal.upto)
    }

    /// The parts of nets that have to have the same values if two scopes show the same; none if they cannot.
    fn alike(&self, a: &str, b: &str, nets: &[SignalId], netlist: &Netlist) -> Option<Pairs> {
        let mut pairs = Vec::new();
        for &signal in nets {
            let (path, signal) = (netlist.signal_path(signal), netlist.signal(signal));
            match (self.parts(a, &path, signal), self.parts(b, &path, signal)) {
                (Ok(a), Ok(b)) => {
                    let one = |(a, b): (&Part, &Part)| {
                        (a.at, a.reversed) == (b.at, b.reversed) && self.waves.are_one(a.var, b.var)
                    };
                    if a.len() != b.len() || !a.iter().zip(&b).all(one) {
                        pairs.push((a, b));
                    }
                }
                (Err(_), Err(_)) => {}
                _ => return None,
            }
        }
        Some(pairs)
    }

    /// For each scope that has any the nets of the circuit that it has. Takes time in proportion to the names of the
    /// waveform and their depth, not to scopes times nets.
    pub fn nets_of_scopes(&self, netlist: &Netlist) -> NetsOfScopes<'w> {
        let paths: HashMap<String, SignalId> = named(netlist).map(|s| (netlist.signal_path(s), s)).collect();
        let numbers: HashMap<&str, usize> =
            std::iter::once("").chain(self.scopes()).enumerate().map(|(i, scope)| (scope, i)).collect();
        let mut nets: HashMap<&'w str, (usize, Vec<SignalId>)> = HashMap::new();
        let mut names: HashSet<&'w str> = HashSet::new();
        for var in self.waves.vars() {
            for full in [var.stem(), var.name.as_str()] {
                if !names.insert(full) {
                    continue;
                }
                let dots = full.match_indices('.').map(|(at, _)| (&full[..at], &full[at + 1..]));
                for (scope, path) in std::iter::once(("", full)).chain(dots) {
                    if let (Some(&signal), Some(&number)) = (paths.get(path), numbers.get(scope)) {
                        nets.entry(scope).or_insert_with(|| (number, Vec::new())).1.push(signal);
                    }
                }
            }
        }
        let mut list: Vec<(usize, &str, Vec<SignalId>)> =
            nets.into_iter().map(|(scope, (number, nets))| (number, scope, nets)).collect();
        list.sort_unstable_by_key(|(number, ..)| *number);
        NetsOfScopes(list.into_iter().map(|(_, scope, nets)| (scope, nets)).collect())
    }

    fn scopes(&self) -> impl Iterator<Item = &'w str> {
        self.waves.scopes().iter().map(String::as_str)
    }

    /// The scopes that have all `wanted` nets, that or those first in which most nets of the circuit are; and, if these
    /// have the same nets, what must have the same values if they show the same.
    pub fn scopes_with(&self, wanted: &[SignalId], netlist: &Netlist) -> (Vec<&'w str>, Option<Pairs>) {
        let nets = self.nets_of_scopes(netlist);
        let all = wanted.iter().copied().collect::<HashSet<_>>();
        let having = || nets.0.iter().filter(|(_, nets)| count(nets, &all) == all.len());
        let most = having().map(|(_, nets)| nets.len()).max().unwrap_or(0);
        let having: Vec<&(&str, Vec<SignalId>)> = having().filter(|(_, nets)| nets.len() == most).collect();
        let mut pairs = None;
        if let [(first, nets), others @ ..] = &having[..]
            && !others.is_empty()
        {
            let nets_of_first: HashSet<_> = nets.iter().copied().collect();
            let alike = |(scope, other): &&(&str, Vec<SignalId>)| {
                let same_nets = count(other, &nets_of_first) == nets.len();
                same_nets.then(|| self.alike(first, scope, nets, netlist))?
            };
            pairs = others.iter().map(alike).collect::<Option<Vec<_>>>().map(|lists| lists.concat());
        }
        (having.into_iter().map(|(scope, _)| *scope).collect(), pairs)
    }
}

/// Parts of nets, of two scopes each.
pub(super) type Pairs = Vec<(Vec<Part>, Vec<Part>)>;

/// How many of some nets are among others; each is there once.
fn count(nets: &[SignalId], among: &HashSet<SignalId>) -> usize {
    nets.iter().filter(|net| among.contains(net)).count()
}

/// The nets of the circuit that scopes of a waveform have, in the order of the file; the top first, by no name.
pub(super) struct NetsOfScopes<'w>(Vec<(&'w str, Vec<SignalId>)>);

impl<'w> NetsOfScopes<'w> {
    /// The first scope that has most of what is wanted, if any has some.
    pub fn nearest(&self, wanted: &[SignalId]) -> Option<&'w str> {
        let wanted: HashSet<SignalId> = wanted.iter().copied().collect();
        let counted = self.0.iter().map(|(scope, nets)| (count(nets, &wanted), *scope));
        // the first of those that have as many
        counted.filter(|(n, _)| *n > 0).rev().max_by_key(|(n, _)| *n).map(|(_, scope)| scope)
    }
}

/// A variable that has bits of a net.
struct Piece {
    var: usize,
    /// The first and the last index of its bits; none if the file does not say.
    index: Option<(i64, i64)>,
    width: u32,
    /// Whether it was put together from bits that stand one by one.
    joined: bool,
}

impl Piece {
    /// Whether it has all bits that another has.
    fn covers(&self, other: &Piece) -> bool {
        match (self.index, other.index) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some((a, b)), Some((c, d))) => a.min(b) <= c.min(d) && a.max(b) >= c.max(d),
        }
    }
}

/// A net of which no variable has all bits. Which way indices run is told by parts of several bits, or else by how the
/// circuit declares the net.
fn assembled(pieces: &[Piece], upto: bool) -> Result<Found, Mismatch> {
    let ranges = || pieces.iter().filter_map(|piece| piece.index);
    let mut told = pieces.iter().filter(|piece| !piece.joined).filter_map(|piece| piece.index);
    let upto = match told.find(|(msb, lsb)| msb != lsb) {
        Some((msb, lsb)) => msb < lsb,
        None => upto,
    };
    let lowest = ranges().map(|(msb, lsb)| msb.min(lsb)).min().unwrap_or(0);
    let highest = ranges().map(|(msb, lsb)| msb.max(lsb)).max().unwrap_or(0);
    let mut parts: Vec<Part> = Vec::new();
    for piece in pieces {
        let Some((msb, lsb)) = piece.index else { continue };
        let at = if upto { highest.abs_diff(msb.max(lsb)) } else { lowest.abs_diff(msb.min(lsb)) };
        let at = u32::try_from(at).unwrap_or(u32::MAX);
        parts.push(Part { var: piece.var, at, width: piece.width, reversed: piece.joined && upto });
    }
    parts.sort_by_key(|part| (part.at, part.width, part.var));
    parts.dedup_by_key(|part| (part.at, part.width));
    let mut width = 0;
    for part in &parts {
        if part.at != width {
            return Err(Mismatch::Bits(parts.iter().fold(0, |sum, p| sum.saturating_add(p.width))));
        }
        width += part.width;
    }
    Ok(Found { parts, width, lsb: Some(if upto { highest } else { lowest }) })
}

impl Found {
    /// What is wrong if the circuit's net has another width.
    pub fn mismatch(&self) -> Mismatch {
        if self.parts.len() == 1 { Mismatch::Width(self.width) } else { Mismatch::Bits(self.width) }
    }

    /// Whether what stands in the waveform can be the circuit's net after synthesis, or before it, cut its highest bits
    /// off: it has to begin at the same bit.
    pub fn begins_as(&self, signal: &Signal) -> bool {
        match self.lsb {
            _ if self.width > signal.width => true,
            None => true,
            // what is cut counts from 0 down again, whatever its indices were
            Some(lsb) => lsb == signal.lsb() || lsb == 0 && self.width > 1,
        }
    }
}

/// The nets that people named.
pub(super) fn named(netlist: &Netlist) -> impl Iterator<Item = SignalId> + '_ {
    netlist.signal_ids().filter(|&signal| !netlist.signal(signal).hidden)
}
