//! The rooms of `docs/architecture.md`, as the imports of the source have them, and every file of tests in a target.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/architecture.md");

/// A row of the table of rooms.
struct Room {
    name: String,
    forbidden: Vec<String>,
}

/// The names in backticks of a text.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

fn rooms() -> Vec<Room> {
    let table = PAGE.split_once("| room | what lives there | may not know |").expect("the table of rooms").1;
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let columns: Vec<&str> = row.trim_matches('|').split('|').collect();
        let [name, _, forbidden] = columns[..] else { panic!("three columns: {row}") };
        Room { name: quoted(name).swap_remove(0), forbidden: quoted(forbidden) }
    })
    .collect()
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The room of a file below `src`, and none for those that are no room: the crates' own `lib.rs` and `main.rs`.
fn room_of(path: &Path) -> Option<String> {
    let mut parts: Vec<&str> = path.iter().map(|part| part.to_str().unwrap()).collect();
    if parts[0] == "core" {
        parts.remove(0);
    }
    match parts[..] {
        ["lib.rs" | "main.rs"] => None,
        _ => Some(parts[0].trim_end_matches(".rs").to_owned()),
    }
}

/// The source without comments and unit tests, which may use more than what they test.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Which rooms each room imports, with a file that does so.
fn imports() -> BTreeMap<String, BTreeMap<String, PathBuf>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    files(&source, &mut found);
    let mut all: BTreeMap<String, BTreeMap<String, PathBuf>> = BTreeMap::new();
    for path in found {
        let below = path.strip_prefix(&source).unwrap();
        let stem = below.file_stem().unwrap().to_str().unwrap();
        let Some(room) = room_of(below).filter(|_| !stem.ends_with("tests")) else { continue };
        let text = code(&path);
        let uses = all.entry(room.clone()).or_default();
        for crate_path in text.split("crate::").skip(1) {
            let name: String = crate_path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let name = match name.as_str() {
                "Value" | "Logic" => "value".to_owned(),
                "Timescale" | "Unit" => "timescale".to_owned(),
                _ => name,
            };
            if name != room {
                uses.entry(name).or_insert_with(|| below.to_owned());
            }
        }
    }
    all
}

#[test]
fn rooms_import_in_one_direction_and_know_what_they_may() {
    let rooms = rooms();
    let place: BTreeMap<&str, usize> = rooms.iter().enumerate().map(|(i, room)| (room.name.as_str(), i)).collect();
    let imports = imports();
    let missing: Vec<&String> = imports.keys().filter(|name| !place.contains_key(name.as_str())).collect();
    assert!(missing.is_empty(), "no row of the table for {missing:?}");
    let mut faults = BTreeSet::new();
    for room in &rooms {
        let used =
            imports.get(&room.name).unwrap_or_else(|| panic!("the table has a room `{}`, src has none", room.name));
        for (name, file) in used {
            let Some(&at) = place.get(name.as_str()) else { continue }; // an item of the room's own crate
            if at > place[room.name.as_str()] {
                faults.insert(format!("`{}` imports `{name}`, which stands below it: {}", room.name, file.display()));
            }
            if room.forbidden.contains(name) {
                faults.insert(format!("`{}` may not know `{name}`: {}", room.name, file.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.into_iter().collect::<Vec<_>>().join("\n"));
}

/// `autotests` is off: a file that no target names would be run by nobody.
#[test]
fn every_file_of_tests_is_in_a_target() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let own = ["needs", "schema", "fuzz"]; // packages of their own
    let mut found = Vec::new();
    files(&tests, &mut found);
    let mut lost = Vec::new();
    for path in found {
        let below = path.strip_prefix(&tests).unwrap();
        let first = below.iter().next().unwrap().to_str().unwrap();
        let stem = below.file_stem().unwrap().to_str().unwrap();
        if own.contains(&first) || stem == "main" {
            continue;
        }
        let (folder, name) = match stem {
            "mod" => (
                below.parent().unwrap().parent().unwrap(),
                below.parent().unwrap().file_name().unwrap().to_str().unwrap(),
            ),
            _ => (below.parent().unwrap(), stem),
        };
        let parents = ["main.rs", "mod.rs"].map(|parent| tests.join(folder).join(parent));
        let line = format!("mod {name};");
        let named =
            |parent: &PathBuf| fs::read_to_string(parent).is_ok_and(|text| text.lines().any(|l| l.ends_with(&line)));
        if !parents.iter().any(named) && below != Path::new("support/mod.rs") {
            lost.push(below.to_owned());
        }
    }
    assert!(lost.is_empty(), "in no target: {lost:?}");
}
