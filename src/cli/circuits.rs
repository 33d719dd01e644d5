//! `discreta circuits` and `discreta new`: the circuits that travel in the program, and a copy of one to start from.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::args::{CircuitsArgs, NewArgs};
use super::{CliError, Out, Status};
use crate::elaborate::{BUILT_IN, built_in};
use crate::wave::output::{Destination, Output};

/// The first sentence of what a file says of itself.
fn about(text: &str) -> String {
    let json: serde_json::Value = serde_json::from_str(text).unwrap_or_default();
    let doc = json["doc"].as_str().unwrap_or_default();
    let end = doc.find(". ").unwrap_or(doc.len());
    doc[..end].trim_end_matches('.').to_owned()
}

/// Lists the built-in circuits.
///
/// # Errors
/// The list cannot be written.
pub fn list(args: &CircuitsArgs, out: &mut Out) -> Result<Status, CliError> {
    let wanted = |name: &str| args.folder.as_ref().is_none_or(|folder| name.starts_with(&format!("{folder}/")));
    let all: Vec<_> = built_in().filter(|(name, _)| wanted(name)).collect();
    if all.is_empty() {
        let mut folders: Vec<&str> = built_in().filter_map(|(name, _)| name.split('/').next()).collect();
        folders.dedup();
        let folder = args.folder.as_deref().unwrap_or_default();
        return Err(CliError::usage(format!("there are no circuits in `{folder}`"))
            .with_hint(format!("there are some in {}", folders.join(", "))));
    }
    let width = all.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, text) in all {
        out.write_fmt(format_args!("{BUILT_IN}{name:width$}  {}\n", about(text)))?;
    }
    Ok(Status::Done)
}

/// Copies a built-in circuit, so that it works where it goes.
///
/// # Errors
/// There is no such circuit, a file is there already, or it cannot be written.
pub fn copy(args: &NewArgs, out: &mut Out) -> Result<Status, CliError> {
    let wanted = args.circuit.trim_start_matches(BUILT_IN).trim_end_matches(".json");
    let Some((name, text)) = built_in().find(|(name, _)| *name == wanted) else {
        let nearest = crate::diag::nearest(wanted, built_in().map(|c| c.0));
        let hint = match nearest {
            Some(nearest) => format!("did you mean `{nearest}`?"),
            None => "`discreta circuits` lists them".to_owned(),
        };
        return Err(CliError::usage(format!("there is no built-in circuit `{wanted}`")).with_hint(hint));
    };
    let file = name.rsplit('/').next().unwrap_or(name);
    let path = args.file.clone().unwrap_or_else(|| PathBuf::from(format!("{file}.json")));
    if path.as_os_str() != "-" && path.exists() {
        return Err(CliError::usage(format!("`{}` is there already", path.display()))
            .with_hint("name another file: `discreta new CIRCUIT FILE`"));
    }
    let folder = name.rsplit_once('/').map_or("", |n| n.0);
    let text = moved(text, folder);
    let mut output = Output::create(&path)?;
    output.write_all(text.as_bytes()).and_then(|()| output.complete())?;
    if path != Path::new("-") {
        out.write_fmt(format_args!("wrote {}; `discreta run {0}` runs it\n", path.display()))?;
    }
    Ok(Status::Done)
}

/// A circuit file for another place: what it imports is that which is built in, and the schema is left out.
fn moved(text: &str, folder: &str) -> String {
    let text: String = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("\"$schema\""))
        .flat_map(|line| [line, "\n"])
        .collect();
    // the list of the one import that a file may have, in which each text is a path
    let list = text.find("\"import\"").and_then(|at| Some((at + text[at..].find('[')?, at + text[at..].find(']')?)));
    let Some((first, last)) = list else { return text };
    let path = |part: &str| match part.strip_prefix("../") {
        Some(other) => format!("{BUILT_IN}{other}"),
        None => format!("{BUILT_IN}{folder}/{part}"),
    };
    let parts = text[first..last].split('"').enumerate();
    let parts: Vec<String> = parts.map(|(i, part)| if i % 2 == 1 { path(part) } else { part.to_owned() }).collect();
    format!("{}{}{}", &text[..first], parts.join("\""), &text[last..])
}
