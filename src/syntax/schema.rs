//! The JSON Schemas (draft 2020-12) of circuit and scenario files, made from their types.

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::CircuitFile;
use crate::syntax::ScenarioFile;

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

    /// `tests/schema` shows that the schema refuses the same.
    #[test]
    fn the_reader_refuses_what_the_schema_refuses() {
        for wrong in include_str!("../../tests/schema/refused.txt").lines() {
            let mut sources = crate::diag::Sources::new();
            let mut diagnostics = crate::diag::Diagnostics::new();
            let file = sources.add("a.json", wrong.to_owned());
            let _ = CircuitFile::parse(&sources, file, &mut diagnostics);
            assert!(diagnostics.has_errors(), "{wrong}");
        }
    }
}
