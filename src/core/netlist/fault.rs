//! What can be wrong with the wiring of a netlist.

use super::{CellId, Driver, SignalId};

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
