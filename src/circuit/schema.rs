//! The JSON Schemas (draft 2020-12) of circuit and scenario files, made from their types.

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::CircuitFile;
use crate::scenario::ScenarioFile;

/// The schema of circuit files.
#[must_use]
pub fn circuit_schema() -> Value {
    schema::<CircuitFile>("discreta circuit file")
}

/// The schema of scenario files.
#[must_use]
pub fn scenario_schema() -> Value {
    schema::<ScenarioFile>("discreta scenario file")
}

fn schema<T: JsonSchema>(title: &str) -> Value {
    let settings = SchemaSettings::draft2020_12().with_transform(RecursiveTransform(without_null));
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".to_owned(), title.into());
    schema.to_value()
}

/// A field that is optional may be left out; that it may be `null` is schemars' idea.
fn without_null(schema: &mut Schema) {
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|t| t != "null");
        if let [one] = &types[..] {
            let one = one.clone();
            schema.insert("type".to_owned(), one);
        }
    }
    if let Some(Value::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|f| f.get("type") != Some(&"null".into()));
        if let [Value::Object(one)] = &forms[..] {
            let one = one.clone();
            schema.remove("anyOf");
            for (key, value) in one {
                schema.ensure_object().entry(key).or_insert(value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// `BLESS=1 cargo test schema` writes the copies anew.
    fn is_current(name: &str, schema: &Value) {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("circuits").join(name);
        let text = serde_json::to_string_pretty(schema).unwrap() + "\n";
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let shipped = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(shipped == text, "{} is not current: run BLESS=1 cargo test schema", path.display());
    }

    #[test]
    fn the_shipped_schemas_are_current() {
        is_current("circuit.schema.json", &circuit_schema());
        is_current("scenario.schema.json", &scenario_schema());
    }

    /// The JSON blocks of a page of the documentation.
    fn examples(page: &str) -> Vec<String> {
        page.split("```json\n").skip(1).map(|part| part.split("```").next().unwrap().to_owned()).collect()
    }

    #[test]
    fn the_examples_of_the_documentation_fit() {
        let circuit = jsonschema::draft202012::new(&circuit_schema()).unwrap();
        let scenario = jsonschema::draft202012::new(&scenario_schema()).unwrap();
        let format = examples(include_str!("../../docs/format.md"));
        let scenarios = examples(include_str!("../../docs/scenarios.md"));
        let inner = format!("{{ {} }}", scenarios[1]);
        for (validator, text) in [(&circuit, &format[0]), (&scenario, &scenarios[0]), (&circuit, &inner)] {
            let value = serde_json::from_str(text).unwrap();
            let faults: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
            assert_eq!(faults, [""; 0], "{text}");
        }
    }

    #[test]
    fn the_shipped_files_fit_and_name_their_schema() {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let mut folders = vec![root.join("circuits"), root.join("traces")];
        let mut seen = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).into_iter().flatten() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let name = path.file_name().unwrap().to_string_lossy();
                if !name.ends_with(".json") || name.ends_with(".schema.json") {
                    continue;
                }
                let value: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
                let schema = folder.join(value["$schema"].as_str().unwrap_or_default());
                let schema = std::fs::read_to_string(&schema)
                    .unwrap_or_else(|e| panic!("{}: its $schema, {}: {e}", path.display(), schema.display()));
                let validator = jsonschema::draft202012::new(&serde_json::from_str(&schema).unwrap()).unwrap();
                let faults: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
                assert_eq!(faults, [""; 0], "{}", path.display());
                seen += 1;
            }
        }
        assert!(seen > 0);
    }

    #[test]
    fn what_the_reader_refuses_the_schema_refuses() {
        let validator = jsonschema::draft202012::new(&circuit_schema()).unwrap();
        for wrong in [
            r#"{ "module": {} }"#,
            r#"{ "doc": null }"#,
            r#"{ "timescale": "2ns" }"#,
            r#"{ "modules": { "1a": {} } }"#,
            r#"{ "modules": { "a": { "ports": { "p": {} } } } }"#,
            r#"{ "modules": { "a": { "ports": { "p": { "direction": "in" } } } } }"#,
            r#"{ "modules": { "a": { "nets": { "n": [] } } } }"#,
            r#"{ "modules": { "a": { "nets": { "n": { "wdith": 1 } } } } }"#,
            r#"{ "modules": { "a": { "cells": { "c": {} } } } }"#,
            r#"{ "modules": { "a": { "cells": { "c": { "type": "and", "connections": { "y": {} } } } } } }"#,
            r#"{ "modules": { "a": { "blocks": { "b": { "repeat": { "i": 1, "j": 2 } } } } } }"#,
            r#"{ "modules": { "a": { "blocks": { "b": { "repeat": { "i": [1] } } } } } }"#,
            r#"{ "simulation": { "clocks": { "c": {} } } }"#,
        ] {
            let value: Value = serde_json::from_str(wrong).unwrap();
            assert!(!validator.is_valid(&value), "{wrong}");
            let mut sources = crate::diag::Sources::new();
            let mut diagnostics = crate::diag::Diagnostics::new();
            let file = sources.add("a.json", wrong.to_owned());
            let _ = CircuitFile::parse(&sources, file, &mut diagnostics);
            assert!(diagnostics.has_errors(), "{wrong}");
        }
    }
}
