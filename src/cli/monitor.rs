//! What a circuit itself says while it runs: its prints and assertions.

use super::report::time;
use super::told::tell;
use crate::import::yosys::Monitor;
use crate::import::yosys::monitor::Flavor;
use crate::netlist::Netlist;

/// Most failed assertions that are told one by one.
pub(super) const SAID: u32 = 100;

/// What the circuit itself says, as it says it.
pub(super) struct Speech<'n> {
    netlist: &'n Netlist,
    failed: u32,
    /// What has been printed of a line that has not ended, and what stands before and after it.
    begun: Option<(String, String, String)>,
    /// Whether prints go to standard output as they are.
    raw: bool,
}

impl<'n> Speech<'n> {
    pub fn new(netlist: &'n Netlist, raw: bool) -> Speech<'n> {
        Speech { netlist, failed: 0, begun: None, raw }
    }

    /// Says what a monitor says. What is printed without the end of a line waits for it.
    pub fn say(&mut self, monitor: &Monitor, now: u64, text: &str) {
        if monitor.fails() {
            self.failed += 1;
            if self.failed > SAID {
                return;
            }
        }
        let at = time(self.netlist, now);
        let source = monitor.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
        if monitor.flavor == Flavor::Print && self.raw {
            use std::io::Write as _;
            // a console that nobody reads is no error
            let mut stdout = std::io::stdout().lock();
            let _ = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
            return;
        }
        if monitor.flavor == Flavor::Print {
            let (_, begun, _) = self.begun.take().unwrap_or_default();
            self.begun = Some((format!("print: at {at}"), begun + text, source));
            if text.ends_with('\n') {
                self.end_line();
            }
            return;
        }
        self.end_line();
        let text = text.trim_end_matches('\n');
        let colon = if text.is_empty() { "" } else { ": " };
        let (what, does) = match monitor.flavor {
            Flavor::Assume => ("error[assumption]", "fails"),
            Flavor::Cover => ("cover", "is reached"),
            Flavor::Assert | Flavor::Print => ("error[assertion]", "fails"),
        };
        tell!("{what}: at {at} `{}` {does}{colon}{text}{source}\n", monitor.name);
    }

    /// Ends a line that has been begun.
    pub fn end_line(&mut self) {
        let Some((head, text, source)) = self.begun.take() else { return };
        let text = text.trim_end_matches('\n');
        let colon = if text.is_empty() { "" } else { ": " };
        tell!("{head}{colon}{text}{source}\n");
    }
}
