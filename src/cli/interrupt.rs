//! Ctrl-C: the first asks the command to stop in good order, the second stops it.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The exit status of a program that a signal ended: 128 and the number of the signal.
const KILLED: i32 = 130;

/// From now on Ctrl-C (and a request to terminate) only sets [`interrupted`]; a second one ends the program at once. To
/// be called by a command that looks at it, and so leaves in good order.
pub fn watch() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        // Without it the system's own way of stopping stays, which is not worth an error.
        let _ = ctrlc::set_handler(|| {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                std::process::exit(KILLED);
            }
        });
    });
}

/// Whether the command should stop. Cheap enough to ask for on every clock.
#[inline]
#[must_use]
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// What [`interrupted`] reads, for those who may not know of this room.
#[must_use]
pub fn flag() -> &'static AtomicBool {
    &INTERRUPTED
}
