//! Feedback step by step, by the functions of the cell room, as the event engine does it: for loops that take long to
//! settle, or never do.

use super::peek::{Held, Peeked};
use super::wiring::Wiring;
use crate::netlist::{CellId, NetId, Netlist};
use crate::value::Word;
use crate::value::word::words;

/// Steps after which a loop counts as endless, as in the event engine.
const ENDLESS: usize = 1_000_000;
/// Steps in which the nets that keep changing are looked for.
const SHOWN: usize = 4096;
/// Steps that what is x has to get round the loop.
const STEPS: usize = 64;

/// What stepping needs room for.
#[derive(Debug, Default)]
pub(super) struct Steps {
    values: Vec<Word>,
}

impl Steps {
    /// Steps a loop until it settles.
    ///
    /// # Errors
    /// The nets that keep changing.
    pub fn run(
        &mut self,
        netlist: &Netlist,
        wiring: &Wiring,
        memory: &mut [Word],
        group: usize,
    ) -> Result<(), Vec<NetId>> {
        let cells = &wiring.loops[group];
        // what the loop reads beside itself does not change
        let mut peeked = Peeked::new(netlist, wiring);
        peeked.fill(&Held::state(netlist, wiring, memory), cells);
        let mut old = self.snapshot(netlist, wiring, memory, cells);
        let mut next_snapshot = 1;
        for step in 1..ENDLESS {
            if !self.step(netlist, wiring, memory, cells, &mut peeked) {
                return Ok(());
            }
            let now = self.snapshot(netlist, wiring, memory, cells);
            if now == old {
                break;
            }
            if step == next_snapshot {
                old = now;
                next_snapshot *= 2;
            }
        }
        Err(self.endless(netlist, wiring, memory, cells, &mut peeked))
    }

    /// The nets of an endless loop that keep changing, the bits that do made x, as in the event engine.
    fn endless(
        &mut self,
        netlist: &Netlist,
        wiring: &Wiring,
        memory: &mut [Word],
        cells: &[CellId],
        peeked: &mut Peeked,
    ) -> Vec<NetId> {
        let start = self.snapshot(netlist, wiring, memory, cells);
        let mut changing = vec![0; start.len()];
        let mut before = start.clone();
        for _ in 0..SHOWN {
            self.step(netlist, wiring, memory, cells, peeked);
            let after = self.snapshot(netlist, wiring, memory, cells);
            for (bits, (old, new)) in changing.iter_mut().zip(before.iter().zip(&after)) {
                *bits |= old.difference(*new);
            }
            if after == start {
                break;
            }
            before = after;
        }
        let (mut at, mut nets, used) = (0, Vec::new(), netlist.used());
        for net in outputs(netlist, cells) {
            let slot = wiring.slot[net.index()].expect("what loops have has a place") as usize;
            let n = words(netlist.net(net).width);
            for (word, &bits) in memory[slot..slot + n].iter_mut().zip(&changing[at..]) {
                *word = word.with_x(bits);
            }
            if used[net.index()] && changing[at..at + n].iter().any(|&bits| bits != 0) {
                nets.push(net);
            }
            at += n;
        }
        for _ in 0..STEPS {
            if !self.step(netlist, wiring, memory, cells, peeked) {
                break;
            }
        }
        nets
    }

    fn snapshot(&mut self, netlist: &Netlist, wiring: &Wiring, memory: &[Word], cells: &[CellId]) -> Vec<Word> {
        outputs(netlist, cells).into_iter().flat_map(|net| held(netlist, wiring, memory, net).to_vec()).collect()
    }

    /// One step; all cells see the values before it. Whether anything changed.
    fn step(
        &mut self,
        netlist: &Netlist,
        wiring: &Wiring,
        memory: &mut [Word],
        cells: &[CellId],
        peeked: &mut Peeked,
    ) -> bool {
        self.values.clear();
        for &cell in cells {
            for value in peeked.outputs(&Held::state(netlist, wiring, memory), cell) {
                self.values.extend(value);
            }
        }
        let (mut at, mut changed) = (0, false);
        for net in outputs(netlist, cells) {
            let slot = wiring.slot[net.index()].expect("what loops have has a place") as usize;
            let n = words(netlist.net(net).width);
            changed |= memory[slot..slot + n] != self.values[at..at + n];
            memory[slot..slot + n].copy_from_slice(&self.values[at..at + n]);
            at += n;
        }
        changed
    }
}

fn outputs(netlist: &Netlist, cells: &[CellId]) -> Vec<NetId> {
    let pins = |c: CellId| (0..netlist.cell(c).kind.outputs().len()).map(move |pin| (c, pin));
    cells.iter().flat_map(|&c| pins(c)).map(|(c, pin)| netlist.output(c, pin)).collect()
}

fn held<'m>(netlist: &Netlist, wiring: &Wiring, memory: &'m [Word], net: NetId) -> &'m [Word] {
    let slot = wiring.slot[net.index()].expect("what loops have has a place") as usize;
    &memory[slot..slot + words(netlist.net(net).width)]
}
