//! Circuit files and the files that they import, each read once, and which modules can be seen from where.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use indexmap::IndexMap;

use super::builtin;
use super::contents::file_name;
use super::source::normal;
use super::{Block, Cell, CircuitFile, Limits, Module, Name, read_file};
use crate::cell::element;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Severity, Sources, Span};
use crate::json::Recover;

/// A module by its file and its place in it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct ModuleId {
    pub file: usize,
    pub index: usize,
}

#[derive(Debug)]
struct Loaded {
    source: FileId,
    circuit: CircuitFile,
    /// What it imports, and where it says so.
    imports: Vec<(usize, Span)>,
    /// Whether one of them cannot be read.
    misses: bool,
    /// The files that memories are filled from, by the name that it has for them.
    contents: HashMap<String, FileId>,
}

/// Every file read so far.
#[derive(Debug, Default)]
pub(super) struct Library {
    files: Vec<Loaded>,
    by_path: HashMap<PathBuf, Option<usize>>,
}

impl Library {
    /// Reads a file and all that it imports. `None` if it cannot be used at all.
    pub fn open(
        &mut self,
        path: &Path,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) -> Option<usize> {
        let first = self.files.len();
        let root = match self.read(path, limits, sources, diagnostics) {
            Ok(root) => root?,
            Err(fault) => {
                diagnostics.push(fault);
                return None;
            }
        };
        self.open_imports(first, limits, sources, diagnostics);
        Some(root)
    }

    /// The same of a text that has been read; imports are relative to its name.
    pub fn open_text(
        &mut self,
        source: FileId,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) -> Option<usize> {
        let first = self.files.len();
        let circuit = CircuitFile::parse(sources, source, diagnostics)?;
        self.files.push(Loaded { source, circuit, imports: Vec::new(), misses: false, contents: HashMap::new() });
        self.open_imports(first, limits, sources, diagnostics);
        Some(first)
    }

    /// Reads all that the files from `first` on import.
    fn open_imports(&mut self, first: usize, limits: &Limits, sources: &mut Sources, diagnostics: &mut Diagnostics) {
        let mut next = first;
        while next < self.files.len() {
            let base = PathBuf::from(sources.name(self.files[next].source));
            let base = base.parent().unwrap_or(Path::new("")).to_path_buf();
            for import in self.files[next].circuit.import.clone() {
                if import.value.trim().is_empty() {
                    self.files[next].misses = true;
                    let fault = Diagnostic::new(Code::CannotRead, "an import names no file").at(import.span, "");
                    diagnostics.push(fault.help("write the path of a circuit file, relative to this one"));
                    continue;
                }
                let path = builtin::import(&base, &import.value);
                let path = path.unwrap_or_else(|| normal(&base.join(&*import.value)));
                match self.read(&path, limits, sources, diagnostics) {
                    Ok(Some(file)) => self.files[next].imports.push((file, import.span)),
                    Ok(None) => self.files[next].misses = true,
                    Err(fault) => {
                        self.files[next].misses = true;
                        diagnostics.push(fault.at(import.span, "imported here"));
                    }
                }
            }
            self.read_contents(next, &base, limits, sources, diagnostics);
            next += 1;
        }
        self.check(first, diagnostics);
    }

    fn read(
        &mut self,
        path: &Path,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) -> Result<Option<usize>, Diagnostic> {
        let built_in = builtin::canonical(path);
        let path = built_in.as_deref().unwrap_or(path);
        let key = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(&known) = self.by_path.get(&key) {
            return Ok(known);
        }
        let source = read_file(path, limits, sources)?;
        let file = CircuitFile::parse(sources, source, diagnostics).map(|circuit| {
            self.files.push(Loaded { source, circuit, imports: Vec::new(), misses: false, contents: HashMap::new() });
            self.files.len() - 1
        });
        self.by_path.insert(key, file);
        Ok(file)
    }

    /// Reads the files that the memories of a file are filled from.
    fn read_contents(
        &mut self,
        file: usize,
        base: &Path,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) {
        let mut named = Vec::new();
        for module in self.files[file].circuit.modules.values().filter_map(Recover::as_ref) {
            each_cell(&module.cells, &module.blocks, &mut |cell| {
                let init = cell.parameters.get("init").filter(|_| cell.kind.value == "memory");
                named.extend(init.and_then(|init| Some((file_name(init)?.to_owned(), init.span))));
            });
        }
        for (name, span) in named {
            if self.files[file].contents.contains_key(&name) {
                continue;
            }
            match read_file(&normal(&base.join(&name)), limits, sources) {
                Ok(text) => {
                    self.files[file].contents.insert(name, text);
                }
                Err(fault) => diagnostics.push(fault.at(span, "the contents of the memory")),
            }
        }
    }

    /// The file that a file calls so and fills a memory from, if it could be read.
    pub fn contents(&self, file: usize, name: &str) -> Option<FileId> {
        self.files[file].contents.get(name).copied()
    }

    /// Checks what can be told without elaborating: import cycles, recursive modules, names of modules.
    fn check(&self, first: usize, diagnostics: &mut Diagnostics) {
        let imports = |file: usize| self.files[file].imports.clone();
        for path in cycles(first..self.files.len(), imports) {
            let fault = Diagnostic::new(Code::ImportCycle, "files import each other");
            let fault = path.iter().enumerate().fold(fault, |d, (i, span)| {
                if i == 0 {
                    d.at(*span, "this import leads back to its own file")
                } else {
                    d.also(*span, "through this one")
                }
            });
            diagnostics.push(fault.help("move what both need into a third file"));
        }
        let modules: Vec<ModuleId> = (first..self.files.len()).flat_map(|f| self.modules(f)).collect();
        let number: HashMap<ModuleId, usize> = modules.iter().enumerate().map(|(i, &m)| (m, i)).collect();
        let uses = |i: usize| -> Vec<(usize, Span)> {
            self.uses(modules[i]).into_iter().filter_map(|(m, span)| Some((*number.get(&m)?, span))).collect()
        };
        for path in cycles(0..modules.len(), uses) {
            let fault = Diagnostic::new(Code::RecursiveModule, "a module contains itself");
            let fault = path.iter().enumerate().fold(fault, |d, (i, span)| {
                if i == 0 {
                    d.at(*span, "this cell leads back to its own module")
                } else {
                    d.also(*span, "through this one")
                }
            });
            diagnostics.push(fault.help("structures of variable size are made by `repeat` and `blocks`"));
        }
        for file in first..self.files.len() {
            let mut seen: HashMap<&str, Span> = HashMap::new();
            for name in self.files[file].circuit.modules.keys() {
                if let Some(element) = element(name) {
                    diagnostics.push(
                        Diagnostic::new(Code::BadName, format!("`{}` is an element ({})", name.value, element.summary))
                            .at(name.span, "a module needs another name"),
                    );
                }
                seen.insert(name, name.span);
            }
            for module in self.files[file].circuit.modules.values().filter_map(Recover::as_ref) {
                module.allow.iter().filter_map(not_allowed).for_each(|fault| diagnostics.push(fault));
            }
            for &(import, span) in &self.files[file].imports {
                for name in self.files[import].circuit.modules.keys().filter(|_| import != file) {
                    match seen.get(name.value.as_str()) {
                        Some(&other) if other != name.span => diagnostics.push(
                            Diagnostic::new(
                                Code::DuplicateName,
                                format!("two modules are called `{}` here", name.value),
                            )
                            .at(span, "this import brings one")
                            .also(other, "one is here")
                            .also(name.span, "the other is here")
                            .help("rename one of them"),
                        ),
                        _ => {
                            seen.insert(name, name.span);
                        }
                    }
                }
            }
        }
    }

    pub fn file(&self, file: usize) -> &CircuitFile {
        &self.files[file].circuit
    }

    /// Whether an import of a file cannot be read, so that its modules are not known.
    pub fn misses(&self, file: usize) -> bool {
        self.files[file].misses
    }

    pub fn source(&self, file: usize) -> FileId {
        self.files[file].source
    }

    pub fn modules(&self, file: usize) -> impl Iterator<Item = ModuleId> + use<> {
        (0..self.files[file].circuit.modules.len()).map(move |index| ModuleId { file, index })
    }

    pub fn module(&self, id: ModuleId) -> (&Name, Option<&Module>) {
        let (name, module) =
            self.files[id.file].circuit.modules.get_index(id.index).expect("ids are made from the map");
        (name, module.as_ref())
    }

    /// The module that a name means in a file.
    pub fn find(&self, file: usize, name: &str) -> Option<ModuleId> {
        let own = |f: usize| Some(ModuleId { file: f, index: self.files[f].circuit.modules.get_index_of(name)? });
        own(file).or_else(|| self.files[file].imports.iter().find_map(|&(f, _)| own(f)))
    }

    /// The names of all modules that can be seen in a file.
    pub fn visible(&self, file: usize) -> Vec<&str> {
        let files = std::iter::once(file).chain(self.files[file].imports.iter().map(|i| i.0));
        files.flat_map(|f| self.files[f].circuit.modules.keys().map(|n| n.value.as_str())).collect()
    }

    /// The modules that a module has cells of, and where.
    pub fn uses(&self, id: ModuleId) -> Vec<(ModuleId, Span)> {
        let mut uses = Vec::new();
        if let (_, Some(module)) = self.module(id) {
            each_cell(&module.cells, &module.blocks, &mut |cell| {
                uses.extend(self.find(id.file, &cell.kind).map(|m| (m, cell.kind.span)));
            });
        }
        uses
    }
}

/// Calls `f` with all cells of a module.
fn each_cell<'c>(
    cells: &'c IndexMap<Name, Recover<Cell>>,
    blocks: &'c IndexMap<Name, Recover<Block>>,
    f: &mut dyn FnMut(&'c Cell),
) {
    cells.values().filter_map(Recover::as_ref).for_each(&mut *f);
    for block in blocks.values().filter_map(Recover::as_ref) {
        each_cell(&block.cells, &block.blocks, f);
    }
}

/// What is wrong with an entry of `allow`.
fn not_allowed(entry: &Name) -> Option<Diagnostic> {
    let warnings = || Code::ALL.iter().filter(|c| c.severity() == Severity::Warning).map(|c| c.as_str());
    let fault = match entry.value.parse::<Code>() {
        Ok(code) if code.severity() == Severity::Warning => return None,
        Ok(_) => Diagnostic::new(Code::UnknownCode, format!("`{}` is an error, which cannot be allowed", entry.value)),
        Err(()) => Diagnostic::new(Code::UnknownCode, format!("there is no warning `{}`", entry.value)),
    };
    let fault = fault.at(entry.span, "not a warning").did_you_mean(entry, warnings());
    Some(fault.note(format!("the warnings are {}", warnings().collect::<Vec<_>>().join(", "))))
}

/// Where the edges of a node lead, and the places that make them.
type Edges = Vec<(usize, Span)>;

/// The circles of a graph, each as the places of its edges; every node that lies on one is in one of them.
fn cycles(nodes: std::ops::Range<usize>, edges: impl Fn(usize) -> Edges) -> Vec<Vec<Span>> {
    let mut done = HashSet::new();
    let mut found = Vec::new();
    for root in nodes {
        // the path from the root: each node with its edges still to follow
        let mut path: Vec<(usize, Edges, Span)> = Vec::new();
        if done.insert(root) {
            path.push((root, edges(root), Span::default()));
        }
        while let Some((_, open, _)) = path.last_mut() {
            let Some((to, span)) = (if open.is_empty() { None } else { Some(open.remove(0)) }) else {
                path.pop();
                continue;
            };
            if let Some(at) = path.iter().position(|p| p.0 == to) {
                let mut circle: Vec<Span> = path[at + 1..].iter().map(|p| p.2).collect();
                circle.push(span);
                found.push(circle);
            } else if done.insert(to) {
                path.push((to, edges(to), span));
            }
        }
    }
    found
}
