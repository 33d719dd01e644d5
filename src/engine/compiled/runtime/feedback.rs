//! Fixpoint iteration of a combinational loop, as the event engine does it: for loops whose unrolled iteration does not settle
//! soon, or that oscillate.

use std::ops::Range;

use crate::compiled::lower::layout::StateLayout;
use crate::compiled::runtime::on_demand::{OnDemand, StateView};
use crate::endless;
use crate::netlist::{CellId, NetId, Netlist};
use crate::value::Word;
use crate::value::word::words;

/// What stepping needs room for.
#[derive(Debug, Default)]
pub(crate) struct Fixpoint {
    values: Vec<Word>,
}

impl Fixpoint {
    /// Steps a loop until it settles.
    ///
    /// # Errors
    /// The nets that keep changing.
    pub fn run(
        &mut self,
        netlist: &Netlist,
        layout: &StateLayout,
        memory: &mut [Word],
        group: usize,
    ) -> Result<(), Vec<NetId>> {
        let cells = &layout.loops[group];
        // what the loop reads beside itself does not change
        let mut on_demand = OnDemand::new(netlist, layout);
        on_demand.fill(&StateView::state(netlist, layout, memory), cells);
        let mut old = snapshot(netlist, layout, memory, cells);
        let mut next_snapshot = 1;
        for step in 1..endless::STEPS {
            if !self.step(netlist, layout, memory, cells, &mut on_demand) {
                return Ok(());
            }
            let now = snapshot(netlist, layout, memory, cells);
            if now == old {
                break;
            }
            if step == next_snapshot {
                old = now;
                next_snapshot *= 2;
            }
        }
        Err(self.endless(netlist, layout, memory, cells, &mut on_demand))
    }

    /// The nets of an endless loop that keep changing, the bits that do made x, as in the event engine.
    fn endless(
        &mut self,
        netlist: &Netlist,
        layout: &StateLayout,
        memory: &mut [Word],
        cells: &[CellId],
        on_demand: &mut OnDemand,
    ) -> Vec<NetId> {
        let start = snapshot(netlist, layout, memory, cells);
        let changing = endless::changing(&start, || {
            self.step(netlist, layout, memory, cells, on_demand);
            snapshot(netlist, layout, memory, cells)
        });
        let (mut changing, mut nets, used) = (changing.into_iter(), Vec::new(), netlist.used());
        for (net, slots) in places(netlist, layout, cells) {
            let mut any = 0;
            for (word, bits) in memory[slots].iter_mut().zip(&mut changing) {
                *word = word.with_x(bits);
                any |= bits;
            }
            if used[net.index()] && any != 0 {
                nets.push(net);
            }
        }
        for _ in 0..endless::SPREADING {
            if !self.step(netlist, layout, memory, cells, on_demand) {
                break;
            }
        }
        nets
    }

    /// One step; all cells see the values before it. Whether anything changed.
    fn step(
        &mut self,
        netlist: &Netlist,
        layout: &StateLayout,
        memory: &mut [Word],
        cells: &[CellId],
        on_demand: &mut OnDemand,
    ) -> bool {
        self.values.clear();
        for &cell in cells {
            for value in on_demand.outputs(&StateView::state(netlist, layout, memory), cell) {
                self.values.extend(value);
            }
        }
        let (mut at, mut changed) = (0, false);
        for (_, slots) in places(netlist, layout, cells) {
            let new = &self.values[at..at + slots.len()];
            at += slots.len();
            changed |= memory[slots.clone()] != *new;
            memory[slots].copy_from_slice(new);
        }
        changed
    }
}

/// The nets of some cells' outputs, which are all state, each with its slots.
pub(crate) fn places<'a>(
    netlist: &'a Netlist,
    layout: &'a StateLayout,
    cells: &'a [CellId],
) -> impl Iterator<Item = (NetId, Range<usize>)> + 'a {
    let pins = move |&cell: &CellId| (0..netlist.cell(cell).kind.outputs().len()).map(move |pin| (cell, pin));
    cells.iter().flat_map(pins).map(move |(cell, pin)| {
        let net = netlist.output(cell, pin);
        let slot = layout.slot[net.index()].expect("what loops have has a place").index();
        (net, slot..slot + words(netlist.net(net).width))
    })
}

fn snapshot(netlist: &Netlist, layout: &StateLayout, memory: &[Word], cells: &[CellId]) -> Vec<Word> {
    places(netlist, layout, cells).flat_map(|(_, slots)| memory[slots].iter().copied()).collect()
}
