//! Which netlists the compiler takes. Every kind of cell is named, so one that is added does not compile here until
//! somebody has decided about it.

use crate::cell::CellKind;
use crate::compiled::CompileError;
use crate::netlist::Netlist;
use crate::value::word::words;

/// The most cells of a combinational loop whose fixpoint iteration is unrolled.
const LONGEST_LOOP: usize = 16;
/// The most machine words that the nets of a netlist may take: slots are numbered in 32 bits.
const MOST_WORDS: usize = 1 << 22;
/// The same for the contents of its memories.
const MOST_CONTENTS: usize = 1 << 24;

/// Bits of a shifter, and of the product of a multiplier, up to which it is lowered.
const MOST_BITS: u32 = 1024;
/// Bits of a divider up to which it is lowered: each is a step.
const MOST_DIVIDED: u32 = 128;

/// Why a cell cannot be lowered; none if it can.
fn refused(kind: &CellKind) -> Option<&'static str> {
    let wide = |wide: bool, what| wide.then_some(what);
    match kind {
        CellKind::Gate { .. }
        | CellKind::AndOr { .. }
        | CellKind::Majority { .. }
        | CellKind::Mux { .. }
        | CellKind::HalfAdder
        | CellKind::FullAdder
        | CellKind::Adder { .. }
        | CellKind::Compare { .. }
        | CellKind::OneHotMux { .. }
        | CellKind::Demux { .. }
        | CellKind::BitMux { .. }
        | CellKind::BitSame { .. }
        | CellKind::Products { .. }
        | CellKind::CarrySave { .. }
        | CellKind::Carry { .. }
        | CellKind::Alu(_)
        | CellKind::IsZero { .. }
        | CellKind::Tristate { .. }
        | CellKind::Resolve { .. }
        | CellKind::Constant(_)
        | CellKind::Sr { .. }
        | CellKind::Latch(_)
        | CellKind::Flop(_)
        | CellKind::EdgeFlop(_)
        | CellKind::Counter(_)
        | CellKind::Accumulator(_)
        | CellKind::Clock(_) => None,
        CellKind::Multiply { a_width, b_width, .. } => {
            wide(a_width + b_width > MOST_BITS, "a multiplier of more than 1024 bits")
        }
        CellKind::Divide { width, .. } => wide(*width > MOST_DIVIDED, "a divider of more than 128 bits"),
        CellKind::Power { width, b_width, .. } => wide(*width.max(b_width) > 64, "a power of more than 64 bits"),
        CellKind::Shift { a_width, width, .. } => {
            wide(*a_width.max(width) > MOST_BITS, "a shifter of more than 1024 bits")
        }
        CellKind::Memory(m) => wide(m.writes.iter().any(|w| w.clock.is_none()), "a memory that is written by level"),
        CellKind::Delay { .. } => Some("a delay"),
        CellKind::RcDelay(_) => Some("an RC delay"),
    }
}

/// Whether a netlist can be lowered.
///
/// # Errors
/// The first thing that it has and that cannot.
pub(crate) fn check(netlist: &Netlist) -> Result<(), CompileError> {
    let order = netlist.order();
    let in_loops = order.groups.iter().flat_map(|g| &order.sequence[g.clone()]);
    if let Some(cell) = in_loops.copied().find(|&c| matches!(netlist.cell(c).kind, CellKind::Memory(_))) {
        return Err(CompileError::MemoryInLoop { path: netlist.cell_path(cell) });
    }
    if let Some(group) = order.groups.iter().find(|g| g.len() > LONGEST_LOOP) {
        let path = netlist.cell_path(order.sequence[group.start]);
        return Err(CompileError::LoopTooLong { cells: group.len(), path });
    }
    for id in netlist.cell_ids() {
        if let Some(what) = refused(&netlist.cell(id).kind) {
            return Err(CompileError::Cell { path: netlist.cell_path(id), what });
        }
    }
    if netlist.nets().iter().map(|net| words(net.width)).sum::<usize>() > MOST_WORDS {
        return Err(CompileError::TooManyNetWords { limit: MOST_WORDS });
    }
    let contents = netlist.cells().iter().map(|cell| match &cell.kind {
        CellKind::Memory(memory) => memory.init.len(),
        _ => 0,
    });
    if contents.sum::<usize>() > MOST_CONTENTS {
        return Err(CompileError::TooManyMemoryWords { limit: MOST_CONTENTS });
    }
    Ok(())
}
