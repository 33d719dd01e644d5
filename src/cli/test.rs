//! `discreta test`.

use super::args::TestArgs;
use super::{CliError, Out, Status};

/// Runs the command.
///
/// # Errors
/// Always: not written yet.
pub fn run(_args: &TestArgs, _out: &mut Out) -> Result<Status, CliError> {
    Err(CliError::usage("`test` does nothing yet"))
}
