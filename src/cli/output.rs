//! Standard output as the subcommands see it.

use std::fmt;
use std::io::{self, BufWriter, Write};

use serde::Serialize;

use super::CliError;

/// Where results go. Colours are kept on a terminal, unless `NO_COLOR` says otherwise, and dropped elsewhere.
///
/// An error of it is a [`CliError::Stdout`], which tells a closed pipe from a full disk.
pub struct Out {
    to: Box<dyn Write>,
    /// Whether nothing was written yet.
    untouched: bool,
    /// Whether a file was read only as far as it goes.
    incomplete: bool,
    /// Whether the command has something to say by its exit status, read or not: a closed pipe is then no error.
    outlives: bool,
    /// Whether nobody reads any more.
    closed: bool,
}

impl Out {
    /// Standard output.
    #[must_use]
    pub fn stdout() -> Out {
        Out {
            to: Box::new(BufWriter::new(anstream::stdout())),
            untouched: true,
            outlives: false,
            closed: false,
            incomplete: false,
        }
    }

    /// Any other place, for tests.
    pub fn new(to: impl Write + 'static) -> Out {
        Out { to: Box::new(to), untouched: false, outlives: false, closed: false, incomplete: false }
    }

    /// From now on a closed pipe is no error: what is written is lost, and the command goes on to its exit status.
    pub fn outlive(&mut self) {
        self.outlives = true;
    }

    /// Whether nobody reads any more.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    fn written(&mut self, result: io::Result<()>) -> Result<(), CliError> {
        match result {
            Err(e) if self.outlives && e.kind() == io::ErrorKind::BrokenPipe => {
                self.closed = true;
                Ok(())
            }
            other => other.map_err(CliError::stdout),
        }
    }

    /// What is written now must not go where the command reads.
    fn begin(&mut self) -> Result<(), CliError> {
        if std::mem::take(&mut self.untouched) {
            crate::files::writes_stdout().map_err(CliError::stdout)?;
        }
        Ok(())
    }

    /// Writes text, as `write!` and `writeln!` do. What a terminal would act on is written out: names come from files.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_fmt(&mut self, text: fmt::Arguments<'_>) -> Result<(), CliError> {
        self.bytes(crate::safe::text(&text.to_string()).as_bytes())
    }

    /// Writes text with colours, in which all else is safe for a terminal already.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn styled(&mut self, text: &str) -> Result<(), CliError> {
        self.bytes(text.as_bytes())
    }

    /// Writes bytes as they are.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<(), CliError> {
        self.begin()?;
        if self.closed {
            return Ok(());
        }
        let result = self.to.write_all(bytes);
        self.written(result)
    }

    /// Writes a value as JSON over several lines.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn json(&mut self, value: &impl Serialize) -> Result<(), CliError> {
        let text = serde_json::to_string_pretty(value).map_err(|error| CliError::stdout(error.into()))?;
        self.bytes(crate::safe::json(&text).as_bytes())?;
        self.bytes(b"\n")
    }

    /// Has the exit status say, once this holds, that a file was read only as far as it goes.
    pub fn incomplete(&mut self, cut: bool) {
        self.incomplete |= cut;
    }

    /// Whether it is to say so.
    #[must_use]
    pub fn is_incomplete(&self) -> bool {
        self.incomplete
    }

    /// Hands on what is still kept. Only then is it known that all of it has arrived.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn flush(&mut self) -> Result<(), CliError> {
        if self.closed {
            return Ok(());
        }
        let result = self.to.flush();
        self.written(result)
    }
}

impl fmt::Debug for Out {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Out")
    }
}

/// A place that keeps what is written, for tests.
#[derive(Clone, Default)]
pub struct Kept(std::rc::Rc<std::cell::RefCell<Vec<u8>>>);

impl Kept {
    /// What was written so far.
    #[must_use]
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.0.borrow()).into_owned()
    }
}

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
