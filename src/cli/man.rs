//! `discreta man`: the manual, made of the help texts.

use clap::CommandFactory;

use super::args::ManArgs;
use super::{Cli, CliError, Out, Status};

/// Prints the page of the program or of one command.
///
/// # Errors
/// There is no such command, or it cannot be written.
pub fn run(args: &ManArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut program = Cli::command();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let Some(command) = program.find_subcommand(name) else {
                let names: Vec<_> = program.get_subcommands().map(clap::Command::get_name).collect();
                let message = format!("there is no command `{name}`");
                return Err(CliError::usage(message).with_hint(format!("one of {}", names.join(", "))));
            };
            // Once built it knows its full name, `discreta-diff`.
            command.clone()
        }
    };
    let mut text = Vec::new();
    // No date and no file: the page is the same wherever it is made.
    let written = clap_mangen::Man::new(page).render(&mut text);
    written.map_err(CliError::stdout)?;
    out.bytes(&text)?;
    Ok(Status::Done)
}
