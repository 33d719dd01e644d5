//! `discreta schema`: the JSON Schema of a file that users write.

use super::args::{SchemaArgs, SchemaKind};
use super::{CliError, Out, Status};

/// Prints a schema.
///
/// # Errors
/// It cannot be written.
pub fn run(args: &SchemaArgs, out: &mut Out) -> Result<Status, CliError> {
    out.json(&schema(args.of))?;
    Ok(Status::Done)
}

fn schema(of: SchemaKind) -> serde_json::Value {
    match of {
        SchemaKind::Circuit => crate::circuit::schema::circuit_schema(),
        SchemaKind::Scenario => crate::circuit::schema::scenario_schema(),
    }
}
