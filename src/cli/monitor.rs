//! What a circuit itself says while it runs: its prints and assertions.

use std::io::Write;

use super::report::time;
use crate::import::yosys::Monitor;
use crate::import::yosys::monitor::Flavor;
use crate::netlist::Netlist;

/// Most failed assertions that are told one by one.
pub(super) const SAID: u32 = 100;

/// Prints what the circuit itself says.
pub(super) fn say(netlist: &Netlist, check: &Monitor, now: u64, text: &str, failed: &mut u32) {
    if check.fails() {
        *failed += 1;
        if *failed > SAID {
            return;
        }
    }
    let at = time(netlist, now);
    let source = check.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
    // nothing that moves the cursor of a terminal
    let text: String = text.chars().filter(|&c| !c.is_control() || c == '\n' || c == '\t').collect();
    let text = text.trim_end_matches('\n');
    let colon = if text.is_empty() { "" } else { ": " };
    let mut to = anstream::stderr().lock();
    let _ = match check.flavor {
        Flavor::Print => writeln!(to, "print: at {at}{colon}{text}{source}"),
        Flavor::Assert => writeln!(to, "error[assertion]: at {at} `{}` fails{colon}{text}{source}", check.name),
        Flavor::Assume => writeln!(to, "error[assumption]: at {at} `{}` fails{colon}{text}{source}", check.name),
        Flavor::Cover => writeln!(to, "cover: at {at} `{}` is reached{colon}{text}{source}", check.name),
    };
}
