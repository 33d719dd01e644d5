//! `discreta run`.

use super::args::RunArgs;
use super::{CliError, Out, Status};

/// Runs the command.
///
/// # Errors
/// Always: not written yet.
pub fn run(_args: &RunArgs, _out: &mut Out) -> Result<Status, CliError> {
    Err(CliError::usage("`run` does nothing yet"))
}
