//! What ends a command with exit status 2, and how it is printed.

use std::fmt;
use std::io;

use super::told::styled;
use crate::safe;
use crate::wave::output::OutputError;
use crate::wave::read::ReadError;

/// Usage, input or I/O: a message for the user and, where there is one, the remedy.
#[derive(Debug)]
pub enum CliError {
    /// An argument that cannot be meant.
    Usage {
        /// What is wrong with it.
        message: String,
        /// What one can do about it.
        hint: Option<String>,
    },
    /// Faults of the input that the user has been told.
    Told,
    /// Faults of the input, rendered already.
    Input(String),
    /// A waveform that cannot be read.
    Wave(ReadError),
    /// A file that cannot be written.
    Output(OutputError),
    /// Some other trouble with a file or the system; the message names it.
    Io {
        /// What was being done, e.g. ``cannot read `line.json` ``.
        message: String,
        /// Why that is not possible.
        source: io::Error,
    },
    /// Standard output cannot be written.
    Stdout(io::Error),
}

impl CliError {
    /// An argument that cannot be meant.
    pub fn usage(message: impl Into<String>) -> CliError {
        CliError::Usage { message: message.into(), hint: None }
    }

    /// The same with what to do about it.
    #[must_use]
    pub fn with_hint(self, text: impl Into<String>) -> CliError {
        match self {
            CliError::Usage { message, .. } => CliError::Usage { message, hint: Some(text.into()) },
            other => other,
        }
    }

    /// Standard output cannot be written.
    #[must_use]
    pub fn stdout(error: io::Error) -> CliError {
        CliError::Stdout(error)
    }

    /// Whether nobody reads what is written any more.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        let kind = match self {
            CliError::Output(error) => error.kind(),
            CliError::Stdout(error) => error.kind(),
            _ => return false,
        };
        kind == io::ErrorKind::BrokenPipe
    }

    /// What one can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            CliError::Usage { hint, .. } => hint.clone(),
            CliError::Wave(error) => error.hint().map(str::to_owned),
            CliError::Output(error) => error.hint(),
            CliError::Told | CliError::Input(_) | CliError::Io { .. } | CliError::Stdout(_) => None,
        }
    }

    /// Prints it to standard error. That this may fail is of no use to anyone.
    pub fn print(&self) {
        match self {
            CliError::Told => {}
            CliError::Input(rendered) => styled(rendered),
            _ => styled(&format!("\x1b[1;31merror\x1b[0m: {}\n", safe::text(&self.to_string()))),
        }
        if let Some(hint) = self.hint() {
            styled(&format!("\x1b[1;36m  help\x1b[0m: {}\n", safe::text(&hint)));
        }
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CliError::Usage { message, .. } => f.write_str(message),
            CliError::Told => f.write_str("told already"),
            CliError::Input(rendered) => f.write_str(rendered.trim_end()),
            CliError::Wave(error) => error.fmt(f),
            CliError::Output(error) => error.fmt(f),
            CliError::Io { message, source } => write!(f, "{message}: {}", crate::wave::output::reason(source)),
            CliError::Stdout(error) => {
                write!(f, "cannot write to standard output: {}", crate::wave::output::reason(error))
            }
        }
    }
}

impl std::error::Error for CliError {}

impl From<ReadError> for CliError {
    fn from(error: ReadError) -> CliError {
        CliError::Wave(error)
    }
}

impl From<OutputError> for CliError {
    fn from(error: OutputError) -> CliError {
        CliError::Output(error)
    }
}

/// From a [`Sink`](crate::wave::Sink) or an [`Output`](crate::wave::output::Output): what they say of a place that
/// cannot be written is kept.
impl From<io::Error> for CliError {
    fn from(error: io::Error) -> CliError {
        match error.downcast::<OutputError>() {
            Ok(error) => CliError::Output(error),
            Err(source) => CliError::Io { message: "cannot write the waveform".to_owned(), source },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::Path;

    use super::*;
    use crate::wave::output::Output;

    #[cfg(target_os = "linux")]
    #[test]
    fn an_output_error_is_found_within_an_io_error() {
        let error = Output::create(Path::new("/dev/full")).unwrap().write_all(b"x").unwrap_err();
        let error = CliError::from(error);
        assert!(matches!(error, CliError::Output(_)), "{error:?}");
        assert_eq!(error.hint().unwrap(), "make room, write elsewhere, or record fewer nets");
        assert!(!error.is_broken_pipe());
    }

    #[test]
    fn a_closed_pipe_is_one_wherever_it_is() {
        assert!(CliError::stdout(io::ErrorKind::BrokenPipe.into()).is_broken_pipe());
        assert!(!CliError::stdout(io::ErrorKind::StorageFull.into()).is_broken_pipe());
        assert!(!CliError::usage("no").is_broken_pipe());
    }
}
