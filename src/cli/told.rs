//! Standard error as the subcommands see it: what is told there holds nothing that a terminal would act on, and that it
//! is closed or full is no fault of the command, whose exit status stays what it is.

use std::fmt;
use std::io::Write as _;

/// Tells a text, with names from files in it, as `eprint!` does.
macro_rules! tell {
    ($($text:tt)*) => { $crate::cli::told::plain(format_args!($($text)*)) };
}
pub(super) use tell;

/// Writes a text that may hold anything.
pub fn plain(text: fmt::Arguments<'_>) {
    styled(&crate::safe::text(&text.to_string()));
}

/// Writes a text that was made safe already and may hold colours, which stay on a terminal.
pub fn styled(text: &str) {
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}
