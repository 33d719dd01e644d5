//! The results of `test` as people, programs and services that run tests read them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use crate::cli::args::TestFormat;
use crate::cli::{CliError, Out};

/// A place in a file, and what is wrong there.
#[derive(Clone, Debug)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Its line, from 1.
    pub line: u64,
    /// The column, from 1.
    pub column: u64,
    /// What is wrong.
    pub message: String,
}

/// What went wrong with a scenario.
#[derive(Debug, Default)]
pub struct Trouble {
    /// For people.
    pub text: String,
    /// For programs.
    pub json: Json,
    /// Where it was seen, as far as that is known.
    pub places: Vec<Place>,
}

/// How one scenario went.
#[derive(Debug)]
pub enum Verdict {
    /// As expected, and the same as its golden trace.
    Passed,
    /// As expected; it has no golden trace.
    NoGolden,
    /// Its golden trace was written; the outputs that are x in it at the end.
    Blessed(Vec<String>),
    /// It does not do what it should.
    Failed(Trouble),
    /// It could not be run.
    Broken(Trouble),
}

impl Verdict {
    fn word(&self) -> &'static str {
        match self {
            Verdict::Passed => "ok",
            Verdict::NoGolden => "ok (no golden trace; --bless makes one)",
            Verdict::Blessed(_) => "blessed",
            Verdict::Failed(_) => "FAILED",
            Verdict::Broken(_) => "BROKEN",
        }
    }

    /// What went wrong, if something did.
    pub fn trouble(&self) -> Option<&Trouble> {
        match self {
            Verdict::Failed(trouble) | Verdict::Broken(trouble) => Some(trouble),
            _ => None,
        }
    }
}

/// A scenario that was run.
#[derive(Debug)]
pub struct Case {
    /// Its file.
    pub path: PathBuf,
    /// How it went.
    pub verdict: Verdict,
    /// How long it took.
    pub seconds: f64,
}

impl Case {
    fn name(&self) -> String {
        self.path.display().to_string()
    }
}

/// Prints a case as soon as it is known, in formats in which that can be.
pub fn one(case: &Case, format: TestFormat, quiet: bool, out: &mut Out) -> Result<(), CliError> {
    let trouble = case.verdict.trouble();
    if quiet && trouble.is_none() {
        return Ok(());
    }
    match format {
        TestFormat::Text | TestFormat::Github => {
            out.write_fmt(format_args!("{}: {}\n", case.name(), case.verdict.word()))?;
            if let Verdict::Blessed(unknown) = &case.verdict
                && !unknown.is_empty()
            {
                let outputs = unknown.join(", ");
                out.write_fmt(format_args!("    warning: the golden trace ends with x on outputs: {outputs}\n"))?;
            }
            let Some(trouble) = trouble else { return Ok(()) };
            for line in trouble.text.trim_end().lines() {
                out.write_fmt(format_args!("{}\n", format!("    {line}").trim_end()))?;
            }
            if format == TestFormat::Github {
                out.write_fmt(format_args!("{}", annotations(&case.path, trouble)))?;
            }
            Ok(())
        }
        TestFormat::Json | TestFormat::Junit => Ok(()),
    }
}

/// Prints what comes after all of them.
pub fn all(cases: &[Case], left: usize, format: TestFormat, out: &mut Out) -> Result<(), CliError> {
    let count = |wanted: fn(&Verdict) -> bool| cases.iter().filter(|case| wanted(&case.verdict)).count();
    let broken = count(|v| matches!(v, Verdict::Broken(_)));
    let failed = count(|v| matches!(v, Verdict::Failed(_)));
    let passed = cases.len() - failed - broken;
    match format {
        TestFormat::Text | TestFormat::Github => {
            let not_run = if left > 0 { format!(", {left} not run") } else { String::new() };
            out.write_fmt(format_args!("\n{passed} passed, {} failed{not_run}\n", failed + broken))
        }
        TestFormat::Json => {
            let list: Vec<Json> = cases.iter().map(json_of).collect();
            out.json(&json!({ "passed": passed, "failed": failed + broken, "not_run": left, "scenarios": list }))
        }
        TestFormat::Junit => out.bytes(junit(cases, failed, broken).as_bytes()),
    }
}

fn json_of(case: &Case) -> Json {
    let trouble = case.verdict.trouble();
    let places: Vec<Json> = trouble
        .into_iter()
        .flat_map(|t| &t.places)
        .map(|p| json!({ "file": p.file, "line": p.line, "column": p.column, "message": p.message }))
        .collect();
    let unknown = if let Verdict::Blessed(unknown) = &case.verdict { &unknown[..] } else { &[] };
    json!({ "scenario": case.name(), "verdict": case.verdict.word().split(' ').next(), "seconds": case.seconds,
            "message": trouble.map(|t| t.text.clone()), "difference": trouble.map_or(&Json::Null, |t| &t.json),
            "places": places, "unknown_outputs": unknown })
}

/// Commands of GitHub's workflows that show failures at their lines.
fn annotations(path: &Path, trouble: &Trouble) -> String {
    let data = |text: &str| text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
    let property = |text: &str| data(text).replace(':', "%3A").replace(',', "%2C");
    let title = property(&path.display().to_string());
    let first =
        Place { file: path.display().to_string(), line: 1, column: 1, message: trouble.text.trim_end().to_owned() };
    let places = if trouble.places.is_empty() { std::slice::from_ref(&first) } else { &trouble.places };
    let mut text = String::new();
    for place in places {
        let (file, message) = (property(&place.file), data(&place.message));
        let _ = writeln!(text, "::error file={file},line={},col={},title={title}::{message}", place.line, place.column);
    }
    text
}

/// The results in JUnit's XML: a scenario that failed is a `failure`, one that could not be run an `error`.
fn junit(cases: &[Case], failed: usize, broken: usize) -> String {
    let escape = crate::svg::escape;
    let time: f64 = cases.iter().map(|case| case.seconds).sum();
    let counts = format!("tests=\"{}\" failures=\"{failed}\" errors=\"{broken}\" time=\"{time:.3}\"", cases.len());
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(text, "<testsuites name=\"discreta\" {counts}>\n  <testsuite name=\"discreta test\" {counts}>");
    for case in cases {
        let folder = case.path.parent().unwrap_or(Path::new("")).display().to_string().replace(['/', '\\'], ".");
        let stem = case.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let _ = write!(
            text,
            "    <testcase classname=\"{}\" name=\"{}\" file=\"{}\" time=\"{:.3}\"",
            escape(folder.trim_matches('.')),
            escape(&stem),
            escape(&case.name()),
            case.seconds
        );
        let Some(trouble) = case.verdict.trouble() else {
            text.push_str("/>\n");
            continue;
        };
        let element = if matches!(case.verdict, Verdict::Failed(_)) { "failure" } else { "error" };
        let first = trouble.places.first().map_or_else(
            || trouble.text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().to_owned(),
            |place| place.message.clone(),
        );
        let (first, all) = (escape(&first), text_escape(&trouble.text));
        let _ = writeln!(text, ">\n      <{element} message=\"{first}\">{all}</{element}>\n    </testcase>");
    }
    text.push_str("  </testsuite>\n</testsuites>\n");
    text
}

/// Text of several lines between tags.
fn text_escape(text: &str) -> String {
    text.split('\n').map(crate::svg::escape).collect::<Vec<_>>().join("\n")
}
