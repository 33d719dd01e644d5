//! From a path to a netlist: reads the files, elaborates, checks.

use std::collections::{HashMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use indexmap::IndexMap;

use super::flatten::{elaborate, roots};
use super::library::{Library, ModuleId};
use super::report::{Places, Report};
use super::synthesis::{Design, Language, Synthesis};
use super::{Limits, Name, ParameterValue, not_a_circuit, read_file};
use crate::Timescale;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};
use crate::import::yosys::{self, Contents, Imported, Monitor, Origins};
use crate::netlist::{CellId, Netlist, SignalId};
use crate::syntax::Simulation;

/// A circuit ready to run.
#[derive(Debug)]
pub struct Circuit {
    /// The circuit with modules laid flat, parameters and repetition resolved.
    pub netlist: Netlist,
    /// The values of the top module's parameters.
    pub parameters: IndexMap<String, i64>,
    /// The default scenario of the file, if it has one.
    pub simulation: Option<Simulation>,
    /// Where the default scenario stands in the file.
    pub simulation_span: Option<Span>,
    /// Where the top module's name stands.
    pub span: Span,
    /// What says something while it runs: the assertions and messages of a netlist of Yosys.
    pub monitors: Vec<Monitor>,
    /// What is doubtful in the files, each as it is shown to people; a [`Loader`] has it in its diagnostics instead.
    pub warnings: Vec<String>,
    places: Places,
    /// Where a netlist of another tool comes from.
    origins: Option<Origins>,
}

impl Circuit {
    /// Takes over the timescale of a waveform, if the file does not fix one: a netlist of Yosys has a tick of 1 ns by
    /// convention only.
    pub(crate) fn adopt(&mut self, timescale: Timescale) {
        if self.origins.is_some() {
            self.netlist.set_timescale(timescale);
        }
    }

    /// Where a signal is declared.
    #[must_use]
    pub fn place(&self, signal: SignalId) -> Span {
        let origin = self.origins.as_ref().and_then(|o| o.of_signal(signal));
        self.places.of(signal).or(origin).unwrap_or(self.span)
    }

    /// Where a cell stands; none for what the netlist adds of its own, such as what resolves a bus.
    #[must_use]
    pub fn cell_place(&self, cell: CellId) -> Option<Span> {
        self.places.of_cell(cell).or_else(|| self.origins.as_ref()?.of_cell(cell))
    }

    /// Where a cell comes from in the source that another tool made the netlist of: `cpu.v:12.3-14.8`.
    #[must_use]
    pub fn cell_source<'s>(&self, cell: CellId, sources: &'s Sources) -> Option<&'s str> {
        self.origins.as_ref()?.source(cell, sources)
    }
}

/// A circuit that cannot be used: every fault, rendered with its place.
#[derive(Debug)]
pub struct LoadError {
    rendered: String,
    /// All faults, errors and warnings, in the order of the files.
    pub diagnostics: Diagnostics,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.rendered.trim_end())
    }
}

impl std::error::Error for LoadError {}

/// Loads a circuit file with its default parameters.
///
/// ```
/// let circuit = discreta::circuit::load("circuits/evaluation/line.json")?;
/// assert!(circuit.netlist.find("kox").is_some());
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
///
/// # Errors
/// With every fault of the file and of those that it imports.
pub fn load(path: impl AsRef<Path>) -> Result<Circuit, LoadError> {
    load_with(path, &[])
}

/// Loads a circuit file with some parameters of its top module set.
///
/// ```
/// let circuit = discreta::circuit::load_with("circuits/evaluation/line.json", &[("W", 4)])?;
/// let dx = circuit.netlist.find("dx").unwrap();
/// assert_eq!(circuit.netlist.signal(dx).width, 4);
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
///
/// # Errors
/// With every fault of the file and of those that it imports.
pub fn load_with(path: impl AsRef<Path>, parameters: &[(&str, i64)]) -> Result<Circuit, LoadError> {
    loaded(parameters, |loader| loader.open(path.as_ref()))
}

/// Loads a circuit from the text of a file, a circuit file or a netlist of Yosys. What is wrong with it is told as being in
/// `name`, and imports are relative to that.
///
/// ```
/// let text = r#"{ "modules": { "top": {
///     "ports": { "a": { "direction": "input" }, "y": { "direction": "output" } },
///     "cells": { "n": { "type": "not", "connections": { "a": "a", "y": "y" } } } } } }"#;
/// let circuit = discreta::circuit::load_text("top.json", text, &[])?;
/// assert!(circuit.netlist.find("y").is_some());
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
///
/// # Errors
/// With every fault of the text and of the files that it imports.
pub fn load_text(name: &str, text: &str, parameters: &[(&str, i64)]) -> Result<Circuit, LoadError> {
    loaded(parameters, |loader| loader.open_text(name, text))
}

/// Loads a circuit from sources that Yosys reads: Verilog, SystemVerilog, VHDL, libraries of cells. `synthesis` says which
/// Yosys and how; `top` is the module to run, where there are several.
///
/// # Errors
/// With every fault that Yosys finds, and every fault of what it makes.
pub fn load_sources(
    sources: &[PathBuf],
    top: Option<&str>,
    parameters: &[(&str, i64)],
    synthesis: Synthesis,
) -> Result<Circuit, LoadError> {
    loaded(parameters, |loader| {
        let (first, more) = sources.split_first()?;
        *loader.synthesis() = synthesis;
        loader.synthesis().sources.extend_from_slice(more);
        top.into_iter().for_each(|top| loader.set_top(top));
        loader.open(first)
    })
}

fn loaded(
    parameters: &[(&str, i64)],
    open: impl FnOnce(&mut Loader) -> Option<FileHandle>,
) -> Result<Circuit, LoadError> {
    let mut loader = Loader::new(Limits::default());
    let mut overrides = Vec::new();
    for (name, value) in parameters {
        overrides.push(loader.parameter(name, &value.to_string()));
    }
    let circuit = open(&mut loader).and_then(|file| loader.elaborate(file, &overrides));
    loader.diagnostics.sort();
    match circuit {
        Some(mut circuit) if !loader.diagnostics.has_errors() => {
            let warnings = loader.diagnostics.iter().map(|d| d.render(&loader.sources, false));
            circuit.warnings = warnings.map(|text| text.trim_end().to_owned()).collect();
            Ok(circuit)
        }
        _ => Err(LoadError {
            rendered: loader.diagnostics.render(&loader.sources, false),
            diagnostics: loader.diagnostics,
        }),
    }
}

/// A file that a [`Loader`] has read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FileHandle(Kind);

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// A circuit file, by its number in the library.
    Circuit(usize),
    /// A netlist of Yosys.
    Yosys(FileId),
    /// Verilog or its like, by its number among the sources.
    Source(usize),
}

/// Reads circuit files and elaborates them, gathering every fault.
#[derive(Debug)]
pub struct Loader {
    /// The texts of all files read.
    pub sources: Sources,
    /// Every fault and warning so far.
    pub diagnostics: Diagnostics,
    limits: Limits,
    library: Library,
    /// The modules that were elaborated somewhere.
    filled: HashSet<ModuleId>,
    /// Texts read by [`Loader::read`].
    texts: HashMap<PathBuf, FileId>,
    /// The module to run in place of that which a file says, and where it was asked for.
    top: Option<(String, Span)>,
    /// What memories are to hold at first: the name, and the text.
    memories: Vec<(Name, FileId)>,
    /// How Verilog is read.
    synthesis: Synthesis,
    /// Files of Verilog that were opened.
    designs: Vec<PathBuf>,
}

impl Loader {
    /// A loader that has read nothing.
    #[must_use]
    pub fn new(limits: Limits) -> Loader {
        Loader {
            sources: Sources::new(),
            diagnostics: Diagnostics::new(),
            limits: limits.possible(),
            library: Library::default(),
            filled: HashSet::new(),
            texts: HashMap::new(),
            top: None,
            memories: Vec::new(),
            synthesis: Synthesis::default(),
            designs: Vec::new(),
        }
    }

    /// How Verilog is read.
    pub fn synthesis(&mut self) -> &mut Synthesis {
        &mut self.synthesis
    }

    /// Reads a text file; the second time it is there already.
    ///
    /// # Errors
    /// A fault without a place.
    pub fn read(&mut self, path: &Path) -> Result<FileId, Diagnostic> {
        if let Some(&known) = self.texts.get(path) {
            return Ok(known);
        }
        let file = read_file(path, &self.limits, &mut self.sources)?;
        self.texts.insert(path.to_path_buf(), file);
        Ok(file)
    }

    /// Runs this module of a file, whatever the file says; faults will show it as `--top NAME`.
    pub fn set_top(&mut self, name: &str) {
        let file = self.sources.add("--top", name.to_owned());
        self.top = Some((name.to_owned(), Span::new(file, 0, name.len() as u32)));
    }

    /// Runs this module of a file unless [`set_top`](Loader::set_top) has named one; `place` is where it is named.
    pub fn set_default_top(&mut self, name: &str, place: Span) {
        self.top.get_or_insert_with(|| (name.to_owned(), place));
    }

    /// Fills a memory from a file as `$readmemh` does, unless that was asked for already; `place` is where the file is
    /// named. What is wrong with the file goes into `diagnostics`, now or when the circuit is elaborated.
    pub fn fill_memory(&mut self, name: Name, path: &Path, place: Span) {
        if self.memories.iter().any(|m| m.0.value == name.value) {
            return;
        }
        match self.read(path) {
            Ok(text) => self.memories.push((name, text)),
            Err(fault) => self.diagnostics.push(fault.at(place, "the contents of the memory")),
        }
    }

    /// Fills a memory from a text as `$readmemh` reads it; faults call the text `name`.
    pub fn fill_memory_with(&mut self, memory: &str, name: &str, text: String) {
        let file = self.sources.add(name, text);
        self.memories.push((Name::new(memory.to_owned(), Span::new(file, 0, 0)), file));
    }

    /// The limits it keeps.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Reads a file and those that it imports: a circuit file, a netlist of Yosys, or Verilog, which is read when it is
    /// elaborated. `None` if it is none of them.
    pub fn open(&mut self, path: &Path) -> Option<FileHandle> {
        if Language::of(path).is_some() {
            self.designs.push(path.to_owned());
            return Some(FileHandle(Kind::Source(self.designs.len() - 1)));
        }
        if let Some(fault) = not_a_circuit(path) {
            self.diagnostics.push(fault);
            return None;
        }
        if let Some(more) = self.synthesis.sources.first() {
            let text = format!("`{}` is a circuit of its own, but `{}` comes with it", path.display(), more.display());
            self.diagnostics.push(Diagnostic::new(Code::BadSource, text).help("only Verilog takes several files"));
            return None;
        }
        let text = self.read(path).map_err(|fault| self.diagnostics.push(fault)).ok()?;
        if yosys::is_yosys(self.sources.text(text)) {
            return Some(FileHandle(Kind::Yosys(text)));
        }
        let file = self.library.open(path, &self.limits, &mut self.sources, &mut self.diagnostics);
        file.map(|file| FileHandle(Kind::Circuit(file)))
    }

    /// The same with a text that is there already; `name` is what faults call it, and imports are relative to it.
    pub fn open_text(&mut self, name: &str, text: &str) -> Option<FileHandle> {
        let source = self.sources.add(name, text.to_owned());
        if yosys::is_yosys(text) {
            return Some(FileHandle(Kind::Yosys(source)));
        }
        let file = self.library.open_text(source, &self.limits, &mut self.sources, &mut self.diagnostics);
        file.map(|file| FileHandle(Kind::Circuit(file)))
    }

    /// A parameter given outside of any file, as on a command line; faults will show it as `-p NAME=VALUE`.
    pub fn parameter(&mut self, name: &str, value: &str) -> (Name, ParameterValue) {
        let text = format!("{name}={value}");
        let file = self.sources.add("-p", text.clone());
        let at = |start: usize, end: usize| Span::new(file, start as u32, end as u32);
        let value = super::ParameterText::String(value.to_owned());
        (Name::new(name.to_owned(), at(0, name.len())), ParameterValue::new(value, at(name.len() + 1, text.len())))
    }

    /// The module that a file is run by.
    fn top(&mut self, file: usize) -> Option<ModuleId> {
        let circuit = self.library.file(file);
        if let Some((name, span)) = &self.top {
            let found = circuit.modules.get_index_of(name.as_str()).map(|index| ModuleId { file, index });
            if found.is_none() {
                let names = circuit.modules.keys().map(|n| n.value.as_str());
                let fault = Diagnostic::new(Code::UnknownModule, format!("the file has no module `{name}`"));
                self.diagnostics.push(fault.at(*span, "asked for here").did_you_mean(name, names));
            }
            return found;
        }
        if let Some(top) = &circuit.top {
            let found = circuit.modules.get_index_of(top.value.as_str()).map(|index| ModuleId { file, index });
            if found.is_none() {
                let names = circuit.modules.keys().map(|n| n.value.as_str());
                self.diagnostics.push(
                    Diagnostic::new(Code::UnknownModule, format!("the file has no module `{}`", top.value))
                        .at(top.span, "named as `top`")
                        .did_you_mean(top, names),
                );
            }
            return found;
        }
        let roots = roots(&self.library, file);
        if let [only] = roots[..] {
            return Some(only);
        }
        let start = Span::new(self.library.source(file), 0, 1);
        let names: Vec<&str> = roots.iter().map(|&m| self.library.module(m).0.value.as_str()).collect();
        let d = if names.is_empty() {
            Diagnostic::new(Code::NoTop, "the file has no module to run").at(start, "").help("add one to `modules`")
        } else {
            let d = Diagnostic::new(Code::NoTop, "the file has several modules that no other uses");
            d.at(start, "which of them is to run?")
                .note(names.join(", "))
                .help(format!("name one: \"top\": \"{}\"", names[0]))
        };
        self.diagnostics.push(d);
        None
    }

    /// The circuit of a file, with parameters of its top module set. Faults go into `diagnostics`; the circuit is not
    /// to be run if there are errors among them.
    pub fn elaborate(&mut self, file: FileHandle, parameters: &[(Name, ParameterValue)]) -> Option<Circuit> {
        let file = match file.0 {
            Kind::Circuit(file) => file,
            Kind::Yosys(text) => return self.import(text, parameters),
            Kind::Source(number) => return self.synthesize(number, parameters),
        };
        let top = self.top(file)?;
        let memories = std::mem::take(&mut self.memories);
        let (netlist, parameters, places) = self.netlist(top, parameters, &memories);
        self.memories = memories;
        let simulation = self.library.file(file).simulation.as_ref();
        let simulation_span = simulation.map(|s| s.span);
        let simulation = simulation.and_then(|s| s.value.as_ref()).cloned();
        let span = self.library.module(top).0.span;
        let monitors = Vec::new();
        Some(Circuit {
            netlist,
            parameters,
            simulation,
            simulation_span,
            span,
            monitors,
            warnings: Vec::new(),
            places,
            origins: None,
        })
    }

    /// The circuit of Verilog.
    fn synthesize(&mut self, number: usize, parameters: &[(Name, ParameterValue)]) -> Option<Circuit> {
        let parameters =
            parameters.iter().map(|(name, value)| (name.value.as_str(), value.value.as_text().trim().to_owned()));
        let path = &self.designs[number];
        let top = self.top.as_ref().map(|(top, _)| top.as_str());
        let design = Design { path, top, parameters: parameters.collect(), place: None };
        let (netlist, warnings) =
            self.synthesis.netlist(&design, &self.limits, &mut self.sources, &mut self.diagnostics)?;
        for warning in warnings {
            self.diagnostics.push(Diagnostic::new(Code::DoubtfulSource, warning));
        }
        let file = self.sources.add(format!("{} (as Yosys reads it)", path.display()), netlist);
        // faults are shown in the source; what cannot be shown there is shown in the netlist
        let texts: Vec<PathBuf> = std::iter::once(path).chain(&self.synthesis.sources).cloned().collect();
        texts.iter().for_each(|path| _ = self.read(path));
        self.sources.made(file, yosys::source_of);
        self.import(file, &[])
    }

    /// The circuit of a netlist of Yosys.
    fn import(&mut self, text_file: FileId, parameters: &[(Name, ParameterValue)]) -> Option<Circuit> {
        for (name, _) in parameters {
            let message = format!("a netlist of Yosys has no parameter `{}` any more", name.value);
            let fault = Diagnostic::new(Code::UnknownParameter, message).at(name.span, "set here");
            self.diagnostics.push(fault.help(format!("set it in Yosys: `chparam -set {} VALUE`", name.value)));
        }
        let top = self.top.as_ref().map(|(name, span)| (name.as_str(), *span));
        let contents = self.memories.iter().map(|(name, file)| {
            let (name, span) = (name.value.as_str(), name.span);
            Contents { name, span, text: self.sources.text(*file), file: *file }
        });
        let contents: Vec<Contents<'_>> = contents.collect();
        let netlist = self.sources.text(text_file);
        let imported = yosys::import(
            netlist,
            text_file,
            top,
            &contents,
            &self.synthesis.black_boxes,
            &self.limits,
            &mut self.diagnostics,
        )?;
        let Imported { builder, origins, monitors, span, parameters, simulation } = imported;
        let simulation = simulation.and_then(|text| {
            let name = format!("{}: discreta_simulation", self.sources.name(text_file));
            let file = self.sources.add(&name, text);
            let simulation: Simulation = crate::json::parse(&self.sources, file, &mut self.diagnostics)?;
            simulation.check(&mut self.diagnostics);
            Some((simulation, Span::new(file, 0, self.sources.text(file).len() as u32)))
        });
        let (simulation, simulation_span) = simulation.unzip();
        let mut faults = Vec::new();
        let netlist = builder.finish_with(&mut faults);
        yosys::report(&netlist, &origins, &faults, &self.sources, &mut self.diagnostics);
        Some(Circuit {
            netlist,
            parameters,
            simulation,
            simulation_span,
            span,
            monitors,
            warnings: Vec::new(),
            places: Places::default(),
            origins: Some(origins),
        })
    }

    /// Elaborates, with their default parameters, the modules of a file that its top module does not reach. A file
    /// without a single top is a library, and all of its modules are checked so.
    pub fn check_rest(&mut self, file: FileHandle) {
        let Kind::Circuit(file) = file.0 else { return };
        let mut done = HashSet::new();
        let circuit = self.library.file(file);
        let top = circuit.top.as_ref().and_then(|t| circuit.modules.get_index_of(t.value.as_str()));
        let mut reached: Vec<ModuleId> = top.map(|index| ModuleId { file, index }).into_iter().collect();
        while let Some(module) = reached.pop() {
            if done.insert(module) {
                reached.extend(self.library.uses(module).into_iter().map(|u| u.0));
            }
        }
        for module in roots(&self.library, file) {
            if !done.contains(&module) && !self.filled.contains(&module) {
                self.netlist(module, &[], &[]);
            }
        }
        // those of which every cell is faulty
        if self.diagnostics.has_errors() && self.diagnostics.iter().all(|d| d.code != Code::TooLarge) {
            for module in self.library.modules(file) {
                if !self.filled.contains(&module) {
                    self.netlist(module, &[], &[]);
                }
            }
        }
    }

    /// Whether a file names or implies one module to run.
    #[must_use]
    pub fn has_top(&self, file: FileHandle) -> bool {
        match file.0 {
            Kind::Circuit(file) => {
                self.top.is_some() || self.library.file(file).top.is_some() || roots(&self.library, file).len() == 1
            }
            // what is wrong with it is to be told
            Kind::Yosys(_) | Kind::Source(_) => true,
        }
    }

    fn netlist(
        &mut self,
        top: ModuleId,
        parameters: &[(Name, ParameterValue)],
        memories: &[(Name, FileId)],
    ) -> (Netlist, IndexMap<String, i64>, Places) {
        // a circle of modules has no end
        if self.diagnostics.iter().any(|d| d.code == Code::RecursiveModule) {
            return (Netlist::default(), IndexMap::new(), Places::default());
        }
        let elaborated = elaborate(&self.library, &self.sources, &self.limits, top, parameters, memories);
        let cut_short = elaborated.diagnostics.iter().any(|d| d.code == Code::TooLarge);
        self.diagnostics.append(elaborated.diagnostics);
        self.filled.extend(elaborated.filled);
        // too large, or half of it is missing
        if cut_short {
            return (Netlist::default(), elaborated.values, Places::default());
        }
        let mut faults = Vec::new();
        let netlist = elaborated.builder.finish_with(&mut faults);
        {
            let mut report = Report {
                library: &self.library,
                netlist: &netlist,
                places: &elaborated.places,
                diagnostics: &mut self.diagnostics,
            };
            report.all(&faults);
        }
        (netlist, elaborated.values, elaborated.places)
    }
}
