//! The command line: one file a subcommand, and what they share.
//!
//! [`args`] is what was typed. A subcommand takes its part of it and an [`Out`], and returns a [`Status`] or a
//! [`CliError`]; [`main`] is the one place that prints an error and decides the exit status. Results go to standard
//! output, everything else to standard error. Nothing below this room knows of it.

pub mod args;
pub mod check;
mod circuits;
pub mod compare;
pub mod completions;
mod contents;
pub mod diff;
pub mod draw;
mod drawing;
pub mod error;
pub mod export;
pub mod feed;
pub mod interpolate;
pub mod interrupt;
mod loading;
pub mod machine;
pub mod man;
mod monitor;
pub mod output;
pub mod plot;
mod prepare;
pub mod progress;
mod replay;
mod report;
pub mod run;
mod sample;
mod save;
pub mod schema;
mod simulate;
pub mod stats;
mod stop;
pub mod sweep;
pub mod test;
mod timing;
mod told;
pub mod view;
pub mod wave;
mod waveforms;
pub mod why;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;

pub use args::{Cli, Command, Format};
pub use error::CliError;
pub use output::Out;

/// How a command ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// It did what was asked: exit status 0.
    Done,
    /// A comparison, expectation or check failed, or a run hit its limit: exit status 1.
    Failed,
}

impl Status {
    /// [`Done`](Status::Done) if this holds.
    #[must_use]
    pub fn of(done: bool) -> Status {
        if done { Status::Done } else { Status::Failed }
    }
}

/// The exit status for usage, input and I/O.
const TROUBLE: u8 = 2;

/// Runs the command as it was typed.
pub fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    let json = asks_json(&words);
    let cli = match Cli::try_parse_from(asked(words)) {
        Ok(cli) => cli,
        // Also help and version, which are printed to standard output and are no error.
        Err(error) => {
            let status = error.exit_code() as u8;
            if json && status == TROUBLE {
                let text = error.render().to_string();
                tell_json(&CliError::usage(text.trim_end().trim_start_matches("error: ")));
            }
            return match error.print() {
                Ok(()) => ExitCode::from(status),
                Err(error) => report(&CliError::stdout(error)),
            };
        }
    };
    crate::files::watch();
    let mut out = Out::stdout();
    // those whose exit status says more than that they ran
    if let Command::Run(_)
    | Command::Check(_)
    | Command::Test(_)
    | Command::Diff(_)
    | Command::Sweep(_)
    | Command::Why(_) = cli.command
    {
        out.outlive();
    }
    let result = dispatch(&cli.command, &mut out).and_then(|status| {
        out.flush()?;
        Ok(status)
    });
    match result {
        Ok(_) if out.is_incomplete() => ExitCode::from(TROUBLE),
        Ok(Status::Done) => ExitCode::SUCCESS,
        Ok(Status::Failed) => ExitCode::FAILURE,
        Err(error) => {
            if json {
                tell_json(&error);
            }
            report(&error)
        }
    }
}

/// Whether a command line asks for JSON.
fn asks_json(words: &[OsString]) -> bool {
    words.iter().any(|word| word == "--format=json")
        || words.windows(2).any(|pair| pair[0] == "--format" && pair[1] == "json")
}

/// Tells a program what a person reads on standard error.
fn tell_json(error: &CliError) {
    if error.is_broken_pipe() || matches!(error, CliError::Told | CliError::Stdout(_)) {
        return;
    }
    let message = anstream::adapter::strip_str(&error.to_string()).to_string();
    let mut out = Out::stdout();
    // that nobody reads it is no further error
    let _ = out.json(&serde_json::json!({ "ok": false, "error": { "message": message, "help": error.hint() } }));
    let _ = out.flush();
}

/// The command line with `help COMMAND`, as many programs have it, in place of which this one has `COMMAND --help`.
fn asked(mut words: Vec<OsString>) -> Vec<OsString> {
    if words.get(1).is_some_and(|word| word == "help") {
        words.remove(1);
        words.push("--help".into());
    }
    words
}

fn dispatch(command: &Command, out: &mut Out) -> Result<Status, CliError> {
    match command {
        Command::Run(args) => run::run(args, out),
        Command::Check(args) => check::run(args, out),
        Command::Test(args) => test::run(args, out),
        Command::Diff(args) => diff::run(args, out),
        Command::Why(args) => why::run(args, out),
        Command::Wave(args) => wave::run(args, out),
        Command::View(args) => view::run(args, out),
        Command::Sweep(args) => sweep::run(args, out),
        Command::Interpolate(args) => interpolate::run(args, out),
        Command::Plot(args) => plot::run(args, out),
        Command::Machine(args) => machine::run(args, out),
        Command::Feed(args) => feed::run(args, out),
        Command::Draw(args) => draw::run(args, out),
        Command::Stats(args) => stats::run(args, out),
        Command::Export(args) => export::run(args, out),
        Command::Compare(args) => compare::run(args, out),
        Command::Circuits(args) => circuits::list(args, out),
        Command::New(args) => circuits::copy(args, out),
        Command::Schema(args) => schema::run(args, out),
        Command::Completions(args) => completions::run(args, out),
        Command::Man(args) => man::run(args, out),
    }
}

/// Prints an error. A closed pipe is none: who reads has enough (`discreta … | head`).
fn report(error: &CliError) -> ExitCode {
    if error.is_broken_pipe() {
        return ExitCode::SUCCESS;
    }
    error.print();
    ExitCode::from(TROUBLE)
}
