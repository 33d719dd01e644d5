//! `discreta completions`: a script that completes the command line as one types.

use clap::CommandFactory;

use super::args::CompletionsArgs;
use super::{Cli, CliError, Out, Status};

/// Prints the script.
///
/// # Errors
/// It cannot be written.
pub fn run(args: &CompletionsArgs, out: &mut Out) -> Result<Status, CliError> {
    // Into memory first: the generator panics on what it cannot write.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "discreta", &mut script);
    out.bytes(&script)?;
    Ok(Status::Done)
}
