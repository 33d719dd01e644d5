//! `discreta interpolate`.

use super::args::InterpolateArgs;
use super::{CliError, Out, Status};

/// Runs the command.
///
/// # Errors
/// Always: not written yet.
pub fn run(_args: &InterpolateArgs, _out: &mut Out) -> Result<Status, CliError> {
    Err(CliError::usage("`interpolate` does nothing yet"))
}
