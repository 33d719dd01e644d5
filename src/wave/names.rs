//! What the variables and scopes of a waveform are called: one name for each, whatever the tool that wrote it makes of
//! brackets and backslashes.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use wellen::{Hierarchy, ItemRef, SignalEncoding, SignalRef, Var};

use super::Layout;
use super::read::{Fault, ValueKind, WaveVar};

/// Scopes inside one another.
pub(super) const MAX_DEPTH: usize = 10_000;

/// The names of a waveform.
pub(super) struct Names {
    pub(super) vars: Vec<WaveVar>,
    /// The variables by their full names.
    pub(super) index: HashMap<String, usize>,
    /// The full names of the scopes.
    pub(super) scopes: Vec<String>,
}

/// The variables with their full names, which are made unique.
pub(super) fn names(hierarchy: &Hierarchy) -> Result<Names, Fault> {
    let mut vars = Vec::new();
    let mut scopes = Vec::new();
    let mut index = HashMap::new();
    let mut again = HashMap::new();
    // The items yet to come, the next one last, and at which length of the path they continue.
    let mut open: Vec<(ItemRef, usize, usize)> = Vec::new();
    let mut path = String::new();
    let push = |open: &mut Vec<_>, items: &mut dyn Iterator<Item = ItemRef>, length, depth| {
        let from = open.len();
        open.extend(items.map(|item| (item, length, depth)));
        open[from..].reverse();
    };
    push(&mut open, &mut hierarchy.items(), 0, 0);
    while let Some((item, length, depth)) = open.pop() {
        path.truncate(length);
        match item {
            ItemRef::Scope(scope) => {
                if depth >= MAX_DEPTH {
                    return Err(Fault::Malformed(format!("more than {MAX_DEPTH} scopes inside one another")));
                }
                let scope = &hierarchy[scope];
                path.push_str(plain(scope.name(hierarchy)));
                scopes.push(path.clone());
                path.push('.');
                push(&mut open, &mut scope.items(hierarchy), path.len(), depth + 1);
            }
            ItemRef::Var(var) => {
                let var = &hierarchy[var];
                let kind = match var.signal_encoding(hierarchy) {
                    SignalEncoding::BitVector(0) => ValueKind::Event,
                    SignalEncoding::BitVector(width) => ValueKind::Bits(width),
                    SignalEncoding::Real => ValueKind::Real,
                    SignalEncoding::String => ValueKind::Text,
                };
                let name = own_name(var, hierarchy, &path);
                if let ValueKind::Bits(width) = kind
                    && width > Layout::MAX_WIDTH
                {
                    let max = Layout::MAX_WIDTH;
                    return Err(Fault::Malformed(format!("`{name}` is {width} bits wide; at most {max} are read")));
                }
                let name = unique(name, var, &mut index, &mut again, vars.len());
                let stem = path.len() + plain(var.name(hierarchy)).len();
                let index = var.index().map(|range| (range.msb(), range.lsb()));
                let signal = var.signal_ref();
                let joined = joined(hierarchy, signal);
                vars.push(WaveVar { name, kind, index, joined, signal, scopes: path.len() as u32, stem: stem as u32 });
            }
        }
    }
    Ok(Names { vars, index, scopes })
}

/// The same of a whole path.
pub(super) fn plain_path(path: &str) -> String {
    path.split('.').map(plain).collect::<Vec<_>>().join(".")
}

/// Whether the reader joined single bits that stand one after the other. It takes the highest index for the most
/// significant, whatever the declaration was.
fn joined(hierarchy: &Hierarchy, signal: SignalRef) -> bool {
    let single = |&input: &SignalRef| hierarchy.get_signal_tpe(input) == Some(SignalEncoding::BitVector(1));
    hierarchy.get_derived_signal(signal).is_some_and(|derived| derived.inputs().iter().all(single))
}

/// A name without the backslash by which Verilog escapes it, and which some simulators write.
fn plain(name: &str) -> &str {
    name.strip_prefix('\\').filter(|rest| !rest.is_empty()).unwrap_or(name)
}

/// The name with the index of a single bit: `q[3]` where a file has the bits of a vector one by one.
fn own_name(var: &Var, hierarchy: &Hierarchy, path: &str) -> String {
    let name = plain(var.name(hierarchy));
    match var.index() {
        Some(index) if index.msb() == index.lsb() => format!("{path}{name}[{}]", index.msb()),
        _ => format!("{path}{name}"),
    }
}

/// Enters a name that is not there yet: parts of one vector get their range, what is still the same a number.
fn unique(
    name: String,
    var: &Var,
    index: &mut HashMap<String, usize>,
    again: &mut HashMap<String, u64>,
    at: usize,
) -> String {
    let range = var.index().map(|range| format!("{name}[{}:{}]", range.msb(), range.lsb()));
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
