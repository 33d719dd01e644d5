//! A loader as the options want it, and what it found wrong as it is printed.

use std::io::IsTerminal;
use std::path::Path;

use super::CliError;
use super::args::{Assignment, ElaborationArgs};
use super::prepare::typed;
use crate::diag::{Diagnostics, Sources};
use crate::elaborate::Loader;
use crate::syntax::Limits;

/// The limits as raised on the command line.
fn limits(changes: &[super::args::Assignment]) -> Result<Limits, CliError> {
    let mut limits = Limits::default();
    for a in changes {
        limits.set(&format!("{}={}", a.name, a.value)).map_err(CliError::usage)?;
    }
    Ok(limits)
}

/// A loader as the command line wants it.
pub(super) fn loader(args: &ElaborationArgs) -> Result<Loader, CliError> {
    let mut loader = Loader::new(limits(&args.limit)?);
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
