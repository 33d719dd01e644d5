//! The JSON Schemas (draft 2020-12) of circuit and scenario files, made from their types.

use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
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

const _: fn() = || {
    fn is_transform<T: Transform>(_: T) {}
    is_transform(RecursiveTransform(without_null));
};

#[cfg(test)]
mod tests {
    use super::*;
}
