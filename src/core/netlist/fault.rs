//! What can be wrong with the wiring of a netlist.

use std::fmt;
use std::ops::Deref;

use super::{CellId, Driver, Netlist, SignalId};

/// Something wrong, or doubtful, in the wiring.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Fault {
    /// A pin is connected to a vector of another width.
    Width {
        /// The cell.
        cell: CellId,
        /// The pin's name.
        pin: &'static str,
        /// The pin's width.
        expected: u32,
        /// The width of what it is connected to.
        found: u32,
    },
    /// Bits that several cells, not all tri-state, drive.
    SeveralDrivers {
        /// The signal.
        signal: SignalId,
        /// Its lowest such bit.
        bit: u32,
        /// The drivers of that bit.
        drivers: Vec<Driver>,
    },
    /// Bits that are read and that nothing drives.
    Undriven {
        /// The signal.
        signal: SignalId,
        /// The lowest such bit.
        lo: u32,
        /// How many there are from it up.
        width: u32,
    },
    /// A signal that nothing reads (a warning).
    Unread {
        /// The signal.
        signal: SignalId,
        /// Whether anything drives it.
        driven: bool,
    },
    /// A constant that a cell drives.
    DrivenConstant {
        /// The cell.
        cell: CellId,
        /// The pin's name.
        pin: &'static str,
    },
    /// More buses than the cell has pins.
    SurplusPins {
        /// The cell.
        cell: CellId,
        /// Whether they are inputs.
        inputs: bool,
        /// How many buses were given.
        given: usize,
        /// How many pins there are.
        pins: usize,
    },
    /// A required input that is left open.
    Open {
        /// The cell.
        cell: CellId,
        /// The pin's name.
        pin: &'static str,
    },
}

impl Fault {
    /// Whether the netlist can be run in spite of it.
    #[must_use]
    pub fn is_warning(&self) -> bool {
        matches!(self, Fault::Unread { .. })
    }
}

impl Fault {
    /// The same in words, with the names of the netlist that has it.
    #[must_use]
    pub fn text(&self, netlist: &Netlist) -> String {
        let name = |cell: CellId| {
            let (path, element) = (netlist.cell_path(cell), netlist.cell(cell).element);
            format!("{element} `{path}`")
        };
        match *self {
            Fault::Width { cell, pin, expected, found } => {
                format!("pin `{pin}` of {} has {expected} bits and is connected to {found}", name(cell))
            }
            Fault::SeveralDrivers { signal, bit, ref drivers } => {
                let drivers: Vec<String> = drivers.iter().map(|&d| format!("`{}`", netlist.driver_name(d))).collect();
                let (signal, drivers) = (netlist.signal_path(signal), drivers.join(" and "));
                format!("bit {bit} of `{signal}` is driven by {drivers}: only tri-state drivers may share a net")
            }
            Fault::Undriven { signal, lo, width } => {
                let (path, high) = (netlist.signal_path(signal), lo + width - 1);
                match width == netlist.signal(signal).width {
                    true => format!("nothing drives `{path}`, which is read"),
                    false => format!("nothing drives bits {high}:{lo} of `{path}`, which are read"),
                }
            }
            Fault::Unread { signal, .. } => format!("nothing reads `{}`", netlist.signal_path(signal)),
            Fault::DrivenConstant { cell, pin } => format!("pin `{pin}` of {} drives a constant", name(cell)),
            Fault::SurplusPins { cell, inputs, given, pins } => {
                let what = if inputs { "inputs" } else { "outputs" };
                format!("{} has {pins} {what}, and {given} were given", name(cell))
            }
            Fault::Open { cell, pin } => format!("pin `{pin}` of {} must be connected", name(cell)),
        }
    }
}

/// Why a netlist cannot be built: every fault of its wiring, of which it is a slice, in words as it is shown.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BuildError {
    faults: Vec<Fault>,
    texts: Vec<String>,
}

impl BuildError {
    pub(super) fn new(faults: Vec<Fault>, netlist: &Netlist) -> BuildError {
        let texts = faults.iter().map(|fault| fault.text(netlist)).collect();
        BuildError { faults, texts }
    }
}

impl Deref for BuildError {
    type Target = [Fault];

    fn deref(&self) -> &[Fault] {
        &self.faults
    }
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.texts.join("; "))
    }
}

impl std::error::Error for BuildError {}
