//! A loader as the options want it, and what it found wrong as it is printed.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use super::CliError;
use super::args::{Assignment, ElaborationArgs};
use super::prepare::typed;
use crate::diag::{Diagnostics, Sources};
use crate::elaborate::{Language, Loader, PROGRAMS};
use crate::syntax::Limits;

/// The limits as raised on the command line.
fn limits(changes: &[super::args::Assignment]) -> Result<Limits, CliError> {
    let mut limits = Limits::default();
    for a in changes {
        limits.set(&format!("{}={}", a.name, a.value)).map_err(CliError::usage)?;
    }
    Ok(limits)
}

/// A loader that finds Yosys and keeps what it made where the user's programs keep such.
pub(super) fn plain(limits: Limits) -> Loader {
    let mut loader = Loader::new(limits);
    let synthesis = loader.synthesis();
    let folders: Vec<PathBuf> = std::env::var_os("PATH").iter().flat_map(std::env::split_paths).collect();
    let there = |program: &&str| {
        let name = format!("{program}{}", std::env::consts::EXE_SUFFIX);
        folders.iter().map(|folder| folder.join(&name)).find(|path| path.is_file())
    };
    synthesis.program = PROGRAMS.iter().find_map(there);
    let home = |name: &str, below: &str| {
        std::env::var_os(name).filter(|v| !v.is_empty()).map(|folder| PathBuf::from(folder).join(below))
    };
    let folder = home("XDG_CACHE_HOME", "").or_else(|| home("HOME", ".cache")).or_else(|| home("LOCALAPPDATA", ""));
    synthesis.cache = folder.map(|folder| folder.join("discreta").join("yosys"));
    loader
}

/// Circuits as they are named, each with its further files: all of Verilog are one design.
pub(super) fn designs(paths: &[PathBuf]) -> Vec<(PathBuf, Vec<PathBuf>)> {
    let (sources, mut designs): (Vec<&PathBuf>, Vec<(PathBuf, Vec<PathBuf>)>) =
        (paths.iter().filter(|p| Language::of(p).is_some()).collect(), Vec::new());
    for path in paths {
        match Language::of(path) {
            None => designs.push((path.clone(), Vec::new())),
            Some(_) if path == sources[0] => {
                designs.push((path.clone(), sources[1..].iter().copied().cloned().collect()));
            }
            Some(_) => {}
        }
    }
    designs
}

/// A loader as the command line wants it; `more` are further files of a design in Verilog.
pub(super) fn loader(args: &ElaborationArgs, more: &[PathBuf]) -> Result<Loader, CliError> {
    let mut loader = plain(limits(&args.limit)?);
    let synthesis = loader.synthesis();
    synthesis.sources = more.to_vec();
    synthesis.include.clone_from(&args.include);
    synthesis.define.clone_from(&args.define);
    synthesis.black_boxes.clone_from(&args.blackbox);
    if let Some(top) = &args.top {
        loader.set_top(top);
    }
    // of several for one memory the last counts
    for Assignment { name, value } in args.memory.iter().rev() {
        let (name, place) = typed(&mut loader, "--memory", name, value);
        loader.fill_memory(name, Path::new(value), place);
    }
    Ok(loader)
}

/// What was prepared, if it may be run.
pub(super) fn faults<T>(loader: &mut Loader, prepared: Option<T>) -> Result<T, CliError> {
    match prepared {
        Some(prepared) if !loader.diagnostics.has_errors() => Ok(prepared),
        _ => {
            loader.diagnostics.drop_warnings(|_| true);
            loader.diagnostics.sort();
            Err(CliError::Input(rendered(&loader.diagnostics, loader)))
        }
    }
}

/// Diagnostics as they are printed to standard error.
pub(super) fn rendered(diagnostics: &Diagnostics, loader: &Loader) -> String {
    rendered_from(diagnostics, &loader.sources)
}

/// The same with the texts that they point into.
pub(super) fn rendered_from(diagnostics: &Diagnostics, sources: &Sources) -> String {
    let color = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    diagnostics.render(sources, color)
}
