//! What the circuit of a method is made of.

use serde::Serialize;

use crate::netlist::Stats;
use crate::netlist::depth::Level;

/// What is compared of a circuit in both forms; see [`MEASURES`](super::MEASURES).
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Equipment {
    /// The method.
    pub method: String,
    /// Cells at register level.
    pub elements: u64,
    /// Adders at register level, and their bits together.
    pub adders: u64,
    /// The bits of the adders.
    pub adder_bits: u64,
    /// None: there is no form of gates alone.
    pub gates: Option<Gates>,
}

/// What is compared of the all-gates form.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub struct Gates {
    /// Gates of two inputs.
    pub gates: u64,
    /// Inverters.
    pub inverters: u64,
    /// Flip-flops.
    pub flip_flops: u64,
    /// Logic depth in gates.
    pub depth: u32,
}

impl Gates {
    /// Gates and inverters together.
    pub(super) const fn all(&self) -> u64 {
        self.gates + self.inverters
    }
}

impl Equipment {
    /// Counts a method's circuits. What is not of gates alone is no all-gates form.
    #[must_use]
    pub fn of(method: &str, registers: &Stats, gates: Option<&Stats>) -> Equipment {
        let e = &registers.equipment;
        let gates = gates.filter(|s| s.depth.unit == Level::Gates).map(|s| Gates {
            gates: s.equipment.two_input_gates,
            inverters: s.equipment.inverters,
            flip_flops: s.equipment.flip_flops,
            depth: s.depth.levels,
        });
        Equipment {
            method: method.to_owned(),
            elements: registers.cells(),
            adders: e.adders.number + e.accumulators.number,
            adder_bits: e.adders.bits + e.accumulators.bits,
            gates,
        }
    }
}
