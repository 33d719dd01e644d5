//! `discreta test`: scenarios, what they expect, and the golden traces beside them.

mod results;

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value as Json;

use super::args::{TestArgs, TestFormat};
use super::loading::{faults, plain, rendered};
use super::prepare::{Changes, is_scenario, prepare};
use super::report::Report;
use super::simulate::simulate;
use super::told::tell;
use super::wave::width;
use super::{CliError, Out, Status, interrupt};
use crate::circuit::{Limits, Loader};
use crate::wave::Sink;
use crate::wave::diff::{Options, diff};
use crate::wave::output::{Destination, Output};
use crate::wave::read::Waves;
use crate::wave::text::Style;
use crate::wave::text::around::around;
use crate::wave::vcd::VcdWriter;
pub use results::Place;
use results::{Case, Trouble, Verdict};

/// Runs the command.
///
/// # Errors
/// A path that cannot be read, or a golden trace that cannot be written.
pub fn run(args: &TestArgs, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let mut scenarios = Vec::new();
    for path in &args.path {
        find(path, &mut scenarios)?;
    }
    let list: Vec<String> = args.path.iter().map(|p| p.display().to_string()).collect();
    if scenarios.is_empty() {
        return Err(CliError::usage(format!("there are no scenarios in {}", list.join(", ")))
            .with_hint("a scenario is a JSON file with a `circuit`"));
    }
    if !args.filter.is_empty() {
        scenarios.retain(|path| args.filter.iter().any(|text| path.display().to_string().contains(text.as_str())));
        if scenarios.is_empty() {
            let text = format!("no scenario in {} has {} in its path", list.join(", "), args.filter.join(" or "));
            return Err(CliError::usage(text).with_hint("--list shows which there are"));
        }
    }
    if args.list {
        if args.format == TestFormat::Json {
            let list: Vec<String> = scenarios.iter().map(|path| path.display().to_string()).collect();
            out.json(&list)?;
            return Ok(Status::Done);
        }
        for path in &scenarios {
            out.write_fmt(format_args!("{}\n", path.display()))?;
        }
        return Ok(Status::Done);
    }
    let mut cases: Vec<Case> = Vec::new();
    for path in &scenarios {
        if interrupt::interrupted() {
            tell!("interrupted; {} scenarios were not run\n", scenarios.len() - cases.len());
            return Ok(Status::Failed);
        }
        let started = Instant::now();
        let verdict = one(path, args)?;
        let case = Case { path: path.clone(), verdict, seconds: started.elapsed().as_secs_f64() };
        results::one(&case, args.format, args.quiet, out)?;
        let failed = case.verdict.trouble().is_some();
        cases.push(case);
        if failed && args.fail_fast {
            break;
        }
    }
    results::all(&cases, scenarios.len() - cases.len(), args.format, out)?;
    Ok(Status::of(cases.iter().all(|case| case.verdict.trouble().is_none())))
}

/// The places of faults, for services that show them there.
fn places(diagnostics: &Json) -> Vec<Place> {
    let place = |fault: &Json| {
        let message = fault["message"].as_str()?.to_owned();
        Some(Place {
            file: fault["file"].as_str()?.to_owned(),
            line: fault["line"].as_u64()?,
            column: fault["column"].as_u64()?,
            message,
        })
    };
    diagnostics.as_array().into_iter().flatten().filter_map(place).collect()
}

/// What is wrong with a scenario that cannot be run.
fn broken(text: String, loader: &Loader) -> Verdict {
    let json = loader.diagnostics.to_json(&loader.sources);
    Verdict::Broken(Trouble { text, places: places(&json), json })
}

/// The scenarios at a path: itself, or all below it, in order of their names.
fn find(path: &Path, found: &mut Vec<PathBuf>) -> Result<(), CliError> {
    let cannot = |source| CliError::Io { message: format!("cannot read `{}`", path.display()), source };
    if !std::fs::metadata(path).map_err(cannot)?.is_dir() {
        found.push(path.to_path_buf());
        return Ok(());
    }
    let mut entries: Vec<PathBuf> = std::fs::read_dir(path)
        .map_err(cannot)?
        .map(|e| e.map(|e| e.path()))
        .collect::<Result<_, _>>()
        .map_err(cannot)?;
    entries.sort();
    for entry in entries {
        let link = entry.symlink_metadata().is_ok_and(|m| m.is_symlink());
        if entry.is_dir() && !link {
            find(&entry, found)?;
        } else if entry.extension().is_some_and(|e| e == "json")
            && is_scenario(&mut Loader::new(Limits::default()), &entry)
        {
            found.push(entry);
        }
    }
    Ok(())
}

fn one(path: &Path, args: &TestArgs) -> Result<Verdict, CliError> {
    // the golden trace of one may be what drives another
    crate::files::watch();
    let golden = path.with_extension("vcd");
    let mut loader = plain(Limits::default());
    let prepared = prepare(&mut loader, path, &Changes::default());
    let mut prepared = match faults(&mut loader, prepared) {
        Ok(prepared) => prepared,
        Err(CliError::Input(text)) => return Ok(broken(text, &loader)),
        Err(e) => return Err(e),
    };
    // what drives the run may stand where a golden trace would; then it is that with which the run is compared
    let stimulus = prepared.replay.as_ref().and_then(|replay| replay.path().canonicalize().ok());
    let is_golden = stimulus.is_none() || stimulus != golden.canonicalize().ok();
    let pinned = prepared.replay.as_ref().is_some_and(|replay| replay.expected().is_some());
    let mut waveform = Vec::new();
    let mut sink = VcdWriter::new(&mut waveform);
    let recorded: Option<&mut dyn Sink> = if is_golden { Some(&mut sink) } else { None };
    let (outcome, difference) =
        match simulate(&mut prepared, &loader, &args.engine, recorded, &path.display().to_string()) {
            Ok(ran) => ran,
            Err(CliError::Input(text)) => return Ok(broken(text, &loader)),
            Err(e) => return Err(e),
        };
    drop(sink);
    let difference = difference.as_ref();
    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &[], difference };
    if report.status() == Status::Failed {
        let mut text = rendered(&report.diagnostics(), &loader);
        text += &report.failed_assertions();
        text += &report.text(false);
        if let Some(difference) = difference.filter(|d| !d.same) {
            text += &format!("\n{difference}");
        }
        let mut places = places(&report.diagnostics().to_json(&loader.sources));
        places.extend(report.assertion_places());
        return Ok(Verdict::Failed(Trouble { text, json: report.json(), places }));
    }
    if !is_golden {
        return Ok(if pinned { Verdict::Passed } else { Verdict::NoGolden });
    }
    let expected = match std::fs::read(&golden) {
        Ok(expected) => expected,
        // a waveform that it is compared with is one already
        Err(e) if e.kind() == std::io::ErrorKind::NotFound && pinned => return Ok(Verdict::Passed),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound && !args.bless => return Ok(Verdict::NoGolden),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
        Err(source) => return Err(CliError::Io { message: format!("cannot read `{}`", golden.display()), source }),
    };
    if expected == waveform {
        return Ok(Verdict::Passed);
    }
    if args.bless {
        use std::io::Write;
        let mut to = Output::create(&golden)?;
        to.write_all(&waveform)?;
        to.complete()?;
        let netlist = &prepared.circuit.netlist;
        let unknown = outcome.outputs.iter().filter(|(_, value)| !value.is_known());
        return Ok(Verdict::Blessed(unknown.map(|(signal, _)| netlist.signal(*signal).name.clone()).collect()));
    }
    differing(&golden, &waveform)
}

/// Where a waveform differs from its golden trace.
fn differing(golden: &Path, waveform: &[u8]) -> Result<Verdict, CliError> {
    // the reader wants a file
    let held = || -> std::io::Result<tempfile::NamedTempFile> {
        use std::io::Write;
        let mut file = tempfile::Builder::new().suffix(".vcd").tempfile()?;
        file.write_all(waveform)?;
        file.flush()?;
        Ok(file)
    };
    let held = held()
        .map_err(|source| CliError::Io { message: "cannot keep the waveform for comparison".to_owned(), source })?;
    let mut expected = match Waves::open(golden) {
        Ok(waves) => waves,
        Err(e) => {
            return Ok(Verdict::Failed(Trouble { text: format!("{e}\n"), ..Trouble::default() }));
        }
    };
    let mut ran = Waves::open(held.path())?;
    let mut difference = diff(&mut expected, &mut ran, &Options::default())?;
    difference.a.name = format!("golden ({})", golden.display());
    difference.b.name = "this run".to_owned();
    let text = if difference.same {
        "every value is the same, but the files are not: written by another version? --bless renews it\n".to_owned()
    } else {
        // it stands indented
        let width = width(None).saturating_sub(4);
        let picture = around(&mut expected, &mut ran, &difference, ["golden", "run"], width, Style::default())?;
        format!("{difference}{}", picture.map_or_else(String::new, |picture| format!("\n{picture}")))
    };
    let json = serde_json::to_value(&difference).unwrap_or(Json::Null);
    Ok(Verdict::Failed(Trouble { text, json, places: Vec::new() }))
}
