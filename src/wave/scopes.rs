//! Scopes of a waveform: the one that somebody names, and the one that has the same names as another.

use std::collections::{HashMap, HashSet};

use super::read::Waves;
use super::read::names::plain_path;

/// How many scopes a message names.
const SHOWN: usize = 10;

impl Waves {
    /// The scope of a path such as `bench.dut`, from the top down, escaped names with or without their backslash; empty for
    /// the top; none if there is no such scope.
    #[must_use]
    pub fn scope(&self, path: &str) -> Option<String> {
        let wanted = plain_path(path.trim());
        (wanted.is_empty() || self.scopes().contains(&wanted)).then_some(wanted)
    }

    /// The first scopes, as a message tells them.
    #[must_use]
    pub fn scopes_there(&self) -> String {
        match self.scopes() {
            [] => "it has none".to_owned(),
            all => format!("it has {}", some(all.iter().map(String::as_str))),
        }
    }

    /// Leaves only what is below a scope, which is the top from then on, by its own name.
    pub fn narrow(&mut self, scope: &str) {
        if scope.is_empty() {
            return;
        }
        let above = self.names.scopes.iter().filter(|other| is_below(scope, other)).map(|other| other.len() + 1).max();
        let cut = above.unwrap_or(0);
        self.names.scopes.retain(|other| other == scope || is_below(other, scope));
        self.names.scopes.iter_mut().for_each(|other| _ = other.drain(..cut));
        self.names.vars.retain(|var| is_below(&var.name, scope));
        self.names.left_out.retain(|out| is_below(&out.name, scope));
        self.names.left_out.iter_mut().for_each(|out| _ = out.name.drain(..cut));
        for var in &mut self.names.vars {
            var.name.drain(..cut);
            var.scopes -= cut as u32;
            var.stem -= cut as u32;
        }
        self.names.index = self.names.vars.iter().enumerate().map(|(i, var)| (var.name.clone(), i)).collect();
    }

    /// Gives variables other names: the full one, and how much of it is scopes.
    pub fn rename(&mut self, name: impl Fn(&str) -> Option<(String, usize)>) {
        for var in &mut self.names.vars {
            if let Some((name, scopes)) = name(&var.name) {
                var.scopes = if scopes == 0 { 0 } else { scopes as u32 + 1 };
                var.stem = name.len() as u32;
                var.name = name;
            }
        }
        self.names.index = self.names.vars.iter().enumerate().rev().map(|(i, var)| (var.name.clone(), i)).collect();
    }

    /// The scope below which most variables have the names that another waveform has below `scope`, the top among them;
    /// none if none has any. Takes time in proportion to the names and their depth.
    #[must_use]
    pub fn counterpart(&self, other: &Waves, scope: &str) -> Option<String> {
        let names: HashSet<&str> = other.vars().iter().filter_map(|var| below(&var.name, scope)).collect();
        let scopes: HashMap<&str, usize> = std::iter::once("")
            .chain(self.scopes().iter().map(String::as_str))
            .enumerate()
            .map(|(i, s)| (s, i))
            .collect();
        let mut found = vec![0_usize; self.scopes().len() + 1];
        for var in self.vars() {
            let dots = var.name.match_indices('.').map(|(at, _)| (&var.name[..at], &var.name[at + 1..]));
            for (scope, path) in std::iter::once(("", var.name.as_str())).chain(dots) {
                if let Some(&at) = scopes.get(scope).filter(|_| names.contains(path)) {
                    found[at] += 1;
                }
            }
        }
        let most = *found.iter().max()?;
        let first = found.iter().position(|&n| n == most && n > 0)?;
        Some(if first == 0 { String::new() } else { self.scopes()[first - 1].clone() })
    }
}

fn is_below(name: &str, scope: &str) -> bool {
    name.strip_prefix(scope).is_some_and(|rest| rest.starts_with('.'))
}

/// The name of what is below a scope, from there on.
pub(super) fn below<'n>(name: &'n str, scope: &str) -> Option<&'n str> {
    if scope.is_empty() { Some(name) } else { name.strip_prefix(scope)?.strip_prefix('.') }
}

/// The first names of a list.
#[must_use]
pub fn some<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut list: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    let more = list.len().saturating_sub(SHOWN);
    list.truncate(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", list.join(", ")).replace("``", "the top")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(text: &str) -> Waves {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("w.vcd");
        std::fs::write(&path, format!("$timescale 1 ns $end {text} $enddefinitions $end\n#0\n0a\n0b\n#5\n")).unwrap();
        Waves::open(&path).unwrap()
    }

    const BENCH: &str = "$scope module bench $end $var wire 1 c x $end $scope module dut $end $var wire 1 a x $end \
        $scope module sub $end $var wire 1 b y $end $upscope $end $upscope $end $upscope $end";

    #[test]
    fn a_scope_is_the_whole_of_what_is_left() {
        let mut narrowed = waves(BENCH);
        let scope = narrowed.scope(" bench.\\dut ").unwrap();
        narrowed.narrow(&scope);
        let names: Vec<&str> = narrowed.vars().iter().map(|var| var.name.as_str()).collect();
        assert_eq!(
            (names.as_slice(), narrowed.scopes()),
            (&["dut.x", "dut.sub.y"][..], &["dut".into(), "dut.sub".into()][..])
        );
        assert_eq!((narrowed.vars()[1].scope(), narrowed.vars()[1].stem()), ("dut.sub", "dut.sub.y"));
        assert_eq!((narrowed.find("dut.sub.y"), narrowed.find("bench.x")), (Some(1), None));
        assert_eq!(waves(BENCH).scope("bench.du"), None);
        assert_eq!(waves(BENCH).scopes_there(), "it has `bench`, `bench.dut`, `bench.dut.sub`");
    }

    #[test]
    fn the_same_names_are_found_elsewhere() {
        let own = waves(
            "$scope module other $end $var wire 1 c y $end $upscope $end \
             $scope module spi $end $var wire 1 a x $end $scope module sub $end $var wire 1 b y $end $upscope $end $upscope $end",
        );
        assert_eq!(own.counterpart(&waves(BENCH), "bench.dut").as_deref(), Some("spi"));
        assert_eq!(own.counterpart(&waves(BENCH), "bench.dut.sub").as_deref(), Some("other"));
        assert_eq!(waves(BENCH).counterpart(&own, "spi.sub").as_deref(), Some("bench.dut.sub"));
        let flat = waves("$var wire 1 a x $end $var wire 1 b sub.y $end");
        assert_eq!(flat.counterpart(&waves(BENCH), "bench.dut").as_deref(), Some(""));
        assert_eq!(waves("$var wire 1 a z $end").counterpart(&own, "spi"), None);
    }
}
