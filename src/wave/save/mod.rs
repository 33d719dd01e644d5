//! What viewers read beside a waveform: which signals to show, in which order, how to write and to draw them.
//!
//! A [`View`] is that for any viewer; [`gtkwave`] makes a save file of it, [`surfer`] a command file. Signals stand by
//! scope; in each, clocks come first, then what controls (one bit, driven from outside), then what has names for its
//! values, then all else as it was declared.

pub mod gtkwave;
pub mod surfer;

use std::sync::Arc;

use crate::Timescale;
use crate::value::ValueNames;

/// A signal in a viewer.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Shown {
    /// The scopes from the top on.
    pub scopes: Vec<String>,
    /// Its name in the last of them.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// What it is for.
    pub role: Role,
    /// Whether its numbers are in two's complement.
    pub signed: bool,
    /// Whether it is drawn as a curve of steps.
    pub steps: bool,
    /// What its values are called, where they have names.
    pub values: Option<Arc<ValueNames>>,
}

/// What a signal is for, in the order in which they are shown.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Role {
    /// A clock.
    Clock,
    /// One bit from outside.
    Control,
    /// Anything else.
    Data,
}

impl Shown {
    /// Its full name.
    #[must_use]
    pub fn path(&self) -> String {
        self.scopes.iter().chain([&self.name]).map(String::as_str).collect::<Vec<_>>().join(".")
    }
}

/// More signals than this are a list in which nobody finds anything: those further down in the hierarchy are left out.
pub const MOST: usize = 500;

/// What a viewer shows of a waveform.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct View {
    /// The name of the waveform's file, without folders.
    pub waveform: String,
    /// A tick.
    pub timescale: Timescale,
    /// The last tick.
    pub end: u64,
    /// The signals, in order.
    signals: Vec<Shown>,
    /// The different names of values among them, each under a name of its own.
    names: Vec<(String, Arc<ValueNames>)>,
}

impl View {
    /// Puts signals into order: as they come, but each scope's together, and by their roles in it.
    #[must_use]
    pub fn new(waveform: &str, timescale: Timescale, end: u64, mut signals: Vec<Shown>) -> View {
        // of a hierarchy that is too large, as many levels as there is room for
        let deepest = signals.iter().map(|s| s.scopes.len()).max().unwrap_or(0);
        let depth = (1..=deepest).rev().find(|&d| signals.iter().filter(|s| s.scopes.len() <= d).count() <= MOST);
        signals.retain(|s| s.scopes.len() <= depth.unwrap_or(1));
        let mut order: Vec<Vec<String>> = Vec::new();
        for signal in &signals {
            // a scope stands before those in it, and these right behind it
            for length in 1..=signal.scopes.len() {
                let scope = &signal.scopes[..length];
                if !order.iter().any(|known| known == scope) {
                    let parent = order.iter().rposition(|known| known.starts_with(&scope[..length - 1]) && length > 1);
                    order.insert(parent.map_or(order.len(), |at| at + 1), scope.to_vec());
                }
            }
        }
        let place = |s: &Shown| order.iter().position(|known| *known == s.scopes);
        // a single bit is best as a line; GTKWave has no other form for it
        signals.iter_mut().filter(|s| s.width == 1).for_each(|s| s.values = None);
        signals.sort_by_cached_key(|s| (place(s), s.role, s.values.is_none()));
        let mut names: Vec<(String, Arc<ValueNames>)> = Vec::new();
        for signal in &signals {
            let Some(values) = signal.values.as_ref().filter(|v| names.iter().all(|(_, known)| known != *v)) else {
                continue;
            };
            let same = |name: &str| names.iter().any(|(known, _)| known == name);
            // it becomes part of the name of a file
            let unfit = |c: char| matches!(c, '/' | '\\' | ':') || !crate::safe::is_plain(c);
            let base: String = signal.name.chars().map(|c| if unfit(c) { '_' } else { c }).take(100).collect();
            let numbered = (2..).map(|n| format!("{base}_{n}"));
            let name = std::iter::once(base.clone()).chain(numbered).find(|name| !same(name));
            names.push((name.unwrap_or_default(), values.clone()));
        }
        View { waveform: waveform.to_owned(), timescale, end, signals, names }
    }

    /// The signals in the order in which they are shown.
    #[must_use]
    pub fn signals(&self) -> &[Shown] {
        &self.signals
    }

    /// The name of what the values of a signal are called.
    fn names_of(&self, signal: &Shown) -> Option<&str> {
        let values = signal.values.as_ref()?;
        self.names.iter().find(|(_, known)| known == values).map(|(name, _)| name.as_str())
    }

    /// The name of the waveform's file without its extension.
    fn stem(&self) -> &str {
        self.waveform.rsplit_once('.').map_or(self.waveform.as_str(), |(stem, _)| stem)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn shown(path: &str, width: u32, role: Role) -> Shown {
        let mut scopes: Vec<String> = path.split('.').map(str::to_owned).collect();
        let name = scopes.pop().unwrap();
        Shown { scopes, name, width, role, signed: false, steps: false, values: None }
    }

    fn states() -> Arc<ValueNames> {
        let names = [("2'b00", "idle"), ("2'b01", "load it"), ("2'bzz", "free")];
        let names = names.map(|(value, name)| (value.parse().unwrap(), name.to_owned()));
        Arc::new(ValueNames::new(names.into()))
    }

    pub fn example() -> View {
        let signals = vec![
            shown("top.q", 8, Role::Data),
            shown("top.u.a", 1, Role::Data),
            shown("top.rst", 1, Role::Control),
            Shown { signed: true, ..shown("top.f", 9, Role::Data) },
            shown("top.u.v.b", 4, Role::Data),
            Shown { steps: true, ..shown("top.xt", 8, Role::Data) },
            shown("top.clk", 1, Role::Clock),
            Shown { values: Some(states()), ..shown("top.state", 2, Role::Data) },
            shown("top.wide", 32, Role::Data),
        ];
        View::new("run.vcd", Timescale::default(), 1000, signals)
    }

    #[test]
    fn clocks_and_controls_come_first() {
        let paths: Vec<String> = example().signals().iter().map(Shown::path).collect();
        assert_eq!(
            paths,
            ["top.clk", "top.rst", "top.state", "top.q", "top.f", "top.xt", "top.wide", "top.u.a", "top.u.v.b"]
        );
    }

    #[test]
    fn what_is_too_much_is_left_out_from_below() {
        let mut signals: Vec<Shown> = (0..MOST).map(|n| shown(&format!("t.u.v.s{n}"), 1, Role::Data)).collect();
        signals.extend((0..5).map(|n| shown(&format!("t.u.s{n}"), 1, Role::Data)));
        assert_eq!(View::new("", Timescale::default(), 1, signals).signals().len(), 5);
    }
}
