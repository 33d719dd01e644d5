//! `discreta check`: every fault of circuit files and scenarios.

use std::path::Path;

use serde_json::json;

use super::args::{CheckArgs, Format};
use super::loading::{designs, loader, rendered};
use super::prepare::{Changes, is_scenario, prepare};
use super::told::styled;
use super::{CliError, Out, Status};
use crate::circuit::Loader;
use crate::diag::Code;

/// Runs the command.
///
/// # Errors
/// A file that cannot be read at all; it is told with the others.
pub fn run(args: &CheckArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut errors = 0;
    let mut unreadable = false;
    let mut files = Vec::new();
    for (path, more) in &designs(&args.circuit) {
        let mut loader = loader(&args.elaboration, more)?;
        check(&mut loader, path, args);
        loader.diagnostics.sort();
        let (bad, warnings) = (loader.diagnostics.errors(), loader.diagnostics.warnings());
        errors += bad;
        // what names a file has a place; the path itself was typed
        unreadable |= loader.diagnostics.iter().any(|d| d.code == Code::CannotRead && d.labels.is_empty());
        if args.format.format == Format::Json {
            files.push(json!({ "file": path.display().to_string(), "errors": bad, "warnings": warnings, "diagnostics": loader.diagnostics.to_json(&loader.sources) }));
            continue;
        }
        styled(&rendered(&loader.diagnostics, &loader));
        let verdict = match (bad, warnings) {
            (0, 0) => "no faults".to_owned(),
            (e, w) => [(e, "error"), (w, "warning")]
                .iter()
                .filter(|(n, _)| *n > 0)
                .map(|(n, what)| format!("{n} {what}{}", if *n == 1 { "" } else { "s" }))
                .collect::<Vec<_>>()
                .join(", "),
        };
        out.write_fmt(format_args!("{}: {verdict}\n", path.display()))?;
        out.flush()?;
    }
    if args.format.format == Format::Json {
        out.json(&files)?;
    }
    out.flush()?;
    if unreadable { Err(CliError::Told) } else { Ok(Status::of(errors == 0)) }
}

fn check(loader: &mut Loader, path: &Path, args: &CheckArgs) {
    let changes = Changes { parameters: &args.elaboration.parameter, checking: true, ..Changes::default() };
    if is_scenario(loader, path) {
        prepare(loader, path, &changes);
        return;
    }
    let Some(file) = loader.open(path) else { return };
    // a file without a module to run is a library
    if loader.has_top(file) {
        prepare(loader, path, &changes);
    }
    loader.check_rest(file);
}
