//! The circuits and the library that travel in the program: `discreta:evaluation/line` works anywhere, as a circuit and as
//! an import.

use std::path::{Component, Path, PathBuf};

use crate::diag::{Code, Diagnostic};

/// How the names of built-in circuits begin.
pub const PREFIX: &str = "discreta:";

/// The names, in order, and the texts.
static FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/circuits.rs"));

/// The built-in circuit files: their names without `discreta:` and the ending, and their texts.
pub fn circuits() -> impl Iterator<Item = (&'static str, &'static str)> {
    FILES.iter().map(|&(name, text)| (name.trim_end_matches(".json"), text))
}

/// The one name of a built-in file, if a path is the name of one: with its ending, without detours.
pub(super) fn canonical(path: &Path) -> Option<PathBuf> {
    let name = path.to_str()?.strip_prefix(PREFIX)?;
    let mut parts: Vec<&str> = Vec::new();
    for part in Path::new(name).components() {
        match part {
            Component::ParentDir => _ = parts.pop(),
            Component::Normal(part) => parts.push(part.to_str()?),
            _ => {}
        }
    }
    let ending = if name.ends_with(".json") { "" } else { ".json" };
    Some(PathBuf::from(format!("{PREFIX}{}{ending}", parts.join("/"))))
}

/// What an import in a file of a folder means, where either is built in.
pub(crate) fn import(folder: &Path, import: &str) -> Option<PathBuf> {
    canonical(Path::new(import)).or_else(|| canonical(folder).and_then(|_| canonical(&folder.join(import))))
}

/// The text of a built-in file by its one name.
///
/// # Errors
/// That there is none, with the name that is nearest.
pub(super) fn text(path: &Path) -> Option<Result<&'static str, Diagnostic>> {
    let name = path.to_str()?.strip_prefix(PREFIX)?;
    let found = FILES.iter().find(|file| file.0 == name).map(|file| file.1);
    Some(found.ok_or_else(|| {
        let short = name.trim_end_matches(".json");
        let fault = Diagnostic::new(Code::CannotRead, format!("there is no built-in circuit `{PREFIX}{short}`"));
        match crate::diag::nearest(short, circuits().map(|c| c.0)) {
            Some(nearest) => fault.help(format!("did you mean `{PREFIX}{nearest}`?")),
            None => fault.help("`discreta circuits` lists them"),
        }
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_one_form() {
        let canonical = |name: &str| canonical(Path::new(name)).map(|p| p.display().to_string());
        for name in ["discreta:lib/storage", "discreta:lib/storage.json", "discreta:dda/../lib/./storage"] {
            assert_eq!(canonical(name).as_deref(), Some("discreta:lib/storage.json"));
        }
        assert_eq!(canonical("lib/storage.json"), None);
        let import = |folder: &str, name: &str| import(Path::new(folder), name).map(|p| p.display().to_string());
        assert_eq!(import("discreta:dda", "../lib/storage.json").as_deref(), Some("discreta:lib/storage.json"));
        assert_eq!(import("my/own", "discreta:lib/storage").as_deref(), Some("discreta:lib/storage.json"));
        assert_eq!(import("my/own", "lib/storage.json"), None);
        assert!(circuits().any(|c| c.0 == "evaluation/line"));
    }
}
