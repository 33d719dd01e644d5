//! The shipped JSON Schemas, by a validator that nobody here wrote. Run it with `cargo test -p schema-check`.
#![cfg(test)]

use std::fs;
use std::path::{Path, PathBuf};

use jsonschema::Validator;
use serde_json::Value;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn validator(path: &Path) -> Validator {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    jsonschema::draft202012::new(&serde_json::from_str(&text).unwrap()).unwrap()
}

fn faults(validator: &Validator, value: &Value) -> Vec<String> {
    validator.iter_errors(value).map(|e| e.to_string()).collect()
}

/// The JSON blocks of a page of the documentation.
fn examples(page: &str) -> Vec<String> {
    let text = fs::read_to_string(repository(page)).unwrap();
    text.split("```json\n").skip(1).map(|part| part.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_examples_of_the_documentation_fit() {
    let circuit = validator(&repository("circuits/circuit.schema.json"));
    let scenario = validator(&repository("circuits/scenario.schema.json"));
    let format = examples("docs/format.md");
    let scenarios = examples("docs/scenarios.md");
    let inner = format!("{{ {} }}", scenarios[1]);
    for (validator, text) in [(&circuit, &format[0]), (&scenario, &scenarios[0]), (&circuit, &inner)] {
        let value = serde_json::from_str(text).unwrap();
        assert_eq!(faults(validator, &value), [""; 0], "{text}");
    }
}

#[test]
fn the_shipped_files_fit_and_name_their_schema() {
    let mut folders = vec![repository("circuits"), repository("traces")];
    let mut seen = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy();
            if !name.ends_with(".json") || name.ends_with(".schema.json") {
                continue;
            }
            let value: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
            let schema = value["$schema"].as_str().unwrap_or_else(|| panic!("{}: no $schema", path.display()));
            assert_eq!(faults(&validator(&folder.join(schema)), &value), [""; 0], "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen} files");
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    let validator = validator(&repository("circuits/circuit.schema.json"));
    for wrong in fs::read_to_string(repository("tests/schema/refused.txt")).unwrap().lines() {
        assert!(!validator.is_valid(&serde_json::from_str(wrong).unwrap()), "{wrong}");
    }
}
