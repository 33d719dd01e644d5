//! `discreta check`.

use super::args::CheckArgs;
use super::{CliError, Out, Status};

/// Runs the command.
///
/// # Errors
/// Always: not written yet.
pub fn run(_args: &CheckArgs, _out: &mut Out) -> Result<Status, CliError> {
    Err(CliError::usage("`check` does nothing yet"))
}
