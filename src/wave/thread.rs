//! How a thread ends that a waveform is handed to.

use std::io;
use std::thread::JoinHandle;

/// What it ended with; `what` says what it did.
pub(super) fn ended(thread: JoinHandle<io::Result<()>>, what: &str) -> io::Result<()> {
    thread.join().unwrap_or_else(|_| Err(io::Error::other(format!("the thread that {what} panicked"))))
}

/// The fault of those who hand it anything after that.
pub(super) fn over() -> io::Error {
    io::Error::other("written to after it was complete or had failed")
}

/// The fault of a system that gives no thread.
pub(super) fn refused(why: &io::Error) -> io::Error {
    let text = format!("the system gives no thread for it ({}): allow more (`ulimit -u`)", crate::output::reason(why));
    io::Error::new(why.kind(), text)
}
