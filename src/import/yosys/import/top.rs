//! Which module is run, and that none contains itself.

use std::collections::HashSet;

use super::Import;
use crate::diag::{Code, Diagnostic, Span};
use crate::import::yosys::cells::Type;

/// What a module was made of by giving parameters: `name` of `$paramod\\name\\W=…` and `$paramod$<hash>\\name`.
pub(super) fn original(name: &str) -> Option<&str> {
    let (hash, rest) = name.strip_prefix("$paramod")?.split_once('\\')?;
    if hash.is_empty() { rest.split('\\').next() } else { Some(rest) }
}

impl Import<'_, '_> {
    /// The module to run.
    pub(super) fn top(&mut self, asked: Option<(&str, Span)>) -> Option<usize> {
        let modules = &self.file.modules;
        if let Some((name, span)) = asked {
            let found = modules.iter().position(|m| m.name == name);
            if found.is_none() {
                let fault = Diagnostic::new(Code::UnknownModule, format!("the file has no module `{name}`"));
                let names = modules.iter().map(|m| m.name.as_ref());
                self.diagnostics.push(fault.at(span, "asked for here").did_you_mean(name, names));
            }
            return found;
        }
        let mut marked = modules.iter().enumerate().filter(|m| m.1.top);
        if let (Some((number, _)), None) = (marked.next(), marked.next()) {
            return Some(number);
        }
        let mut used = vec![false; modules.len()];
        for kind in modules.iter().flat_map(|m| &m.cells).map(|c| c.kind) {
            if let Type::Module(number) = *self.kind(kind) {
                used[number] = true;
            }
        }
        // Yosys leaves the module that it made others of, which have its name and parameters
        let originals: HashSet<&str> = modules.iter().filter_map(|m| original(&m.name)).collect();
        let mut free: Vec<usize> = (0..modules.len()).filter(|&i| !used[i] && !modules[i].black_box).collect();
        if free.len() > 1 && free.iter().any(|&i| !originals.contains(modules[i].name.as_ref())) {
            free.retain(|&i| !originals.contains(modules[i].name.as_ref()));
        }
        if let [only] = free[..] {
            return Some(only);
        }
        let start = Span::new(self.source, 0, 1);
        let fault = match free.first() {
            None => Diagnostic::new(Code::NoTop, "the file has no module to run").at(start, ""),
            Some(&first) => {
                let names: Vec<&str> = free.iter().map(|&i| modules[i].name.as_ref()).collect();
                Diagnostic::new(Code::NoTop, "the file has several modules that no other uses")
                    .at(start, "which of them is to run?")
                    .note(names.join(", "))
                    .help(format!("name one: `--top {}`, or let Yosys do it: `hierarchy -top …`", modules[first].name))
            }
        };
        self.diagnostics.push(fault);
        None
    }

    /// Refuses modules that contain themselves.
    pub(super) fn cycles(&mut self, top: usize) -> Option<()> {
        // 1: on the way here, 2: done
        let mut state = vec![0u8; self.file.modules.len()];
        let mut way = vec![(top, 0)];
        state[top] = 1;
        while let Some(&mut (module, ref mut next)) = way.last_mut() {
            let Some(cell) = self.file.modules[module].cells.get(*next) else {
                state[module] = 2;
                way.pop();
                continue;
            };
            *next += 1;
            let Type::Module(inner) = *self.kind(cell.kind) else { continue };
            match state[inner] {
                0 => {
                    state[inner] = 1;
                    way.push((inner, 0));
                }
                1 => {
                    let name = &self.file.modules[inner].name;
                    let fault = Diagnostic::new(Code::RecursiveModule, format!("`{name}` contains itself"));
                    self.diagnostics.push(fault.at(self.span_of(&cell.name), "by this cell"));
                    return None;
                }
                _ => {}
            }
        }
        Some(())
    }
}
