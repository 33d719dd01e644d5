//! Patterns for the nets of a circuit.

use globset::{GlobBuilder, GlobSet, GlobSetBuilder};

use crate::netlist::{Netlist, SignalId};

/// What stands for a dot that is part of a name.
pub(super) const DOT: char = '\u{1}';

/// The path of a signal with `/` between scopes, so that a dot within a name (of Verilog's `\a.b `) is told from them.
pub(crate) fn glob_path(netlist: &Netlist, id: SignalId) -> String {
    let signal = netlist.signal(id);
    let mut names = vec![signal.name.as_str()];
    let mut scope = &netlist.scopes()[signal.scope.index()];
    while let Some(parent) = scope.parent {
        names.push(&scope.name);
        scope = &netlist.scopes()[parent.index()];
    }
    let names: Vec<String> = names.iter().rev().map(|n| n.replace('.', DOT.encode_utf8(&mut [0; 4]))).collect();
    names.join("/")
}

/// A glob over paths whose scopes are separated by `/`: `*` and `?` stay inside a scope, `**` crosses them. A dot is a
/// separator or a dot within a name.
pub(crate) fn glob_set(glob: &str) -> Result<GlobSet, String> {
    let mut pattern = String::new();
    let mut chars = glob.chars();
    while let Some(c) = chars.next() {
        match c {
            // only a separator is beside `**`
            '.' if pattern.ends_with("**") || chars.as_str().starts_with("**") => pattern.push('/'),
            '.' => pattern.extend(['{', '/', ',', DOT, '}']),
            '[' | ']' | '{' | '}' => pattern.extend(['\\', c]),
            '\\' => pattern.extend(['\\', chars.next().ok_or("it ends in `\\`")?]),
            c => pattern.push(c),
        }
    }
    let glob = GlobBuilder::new(&pattern).literal_separator(true).backslash_escape(true).build();
    let mut set = GlobSetBuilder::new();
    set.add(glob.map_err(|e| e.kind().to_string())?);
    set.build().map_err(|e| e.kind().to_string())
}

#[cfg(test)]
mod tests {
    use super::glob_set;

    #[test]
    fn globs_respect_scopes_and_take_brackets_as_they_are() {
        let is = |glob: &str, path: &str| glob_set(glob).unwrap().is_match(path.replace('.', "/"));
        assert!(is("*", "f") && !is("*", "adder.s"));
        assert!(is("**", "f") && is("**", "adder.fa[3].s"));
        assert!(is("adder.*", "adder.s") && !is("adder.*", "adder.fa[3].s"));
        assert!(is("adder.**", "adder.fa[3].s"));
        assert!(is("**.s", "adder.fa[3].s") && is("**.s", "s"));
        assert!(is("adder.fa[3].s", "adder.fa[3].s") && !is("adder.fa[3].s", "adder.fa3.s"));
        assert!(is("ko?", "kox") && !is("ko?", "ko.x"));
        assert!(is(r"\*", "*") && !is(r"\*", "f"));
        assert!(glob_set("a\\").is_err());
        // `a.b` in `u`, where the dot is part of the name
        let dotted = |glob: &str| glob_set(glob).unwrap().is_match(format!("u/a{}b", super::DOT));
        assert!(
            dotted("u.*") && dotted("u.a.b") && dotted("**.a.b") && dotted("u.**") && dotted("u.a?b") && dotted("**")
        );
        assert!(!dotted("u.a.*.b") && !dotted("*"));
    }
}
