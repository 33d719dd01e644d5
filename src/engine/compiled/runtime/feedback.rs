//! Fixpoint iteration of a combinational loop, as the event engine does it: for loops whose unrolled iteration does not settle
//! soon, or that oscillate. A step computes the cells one of whose inputs the step before has changed.

use std::collections::HashMap;
use std::ops::Range;

use super::on_demand::{OnDemand, StateView};
use crate::cell::evaluate;
use crate::compiled::lower::layout::StateLayout;
use crate::endless;
use crate::netlist::{CellId, NetId, Netlist};
use crate::value::Word;
use crate::value::word::{copy, word_mask, words};

/// More pins than any cell of a loop has: memories are in none.
const PINS: usize = 8;

/// The loops that have been stepped, and what is asked for outside of them.
#[derive(Debug, Default)]
pub(crate) struct Fixpoint {
    loops: Vec<Option<Box<Loop>>>,
    on_demand: Option<OnDemand>,
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
        self.loops.resize_with(layout.loops.len(), || None);
        let steps = self.loops[group].get_or_insert_with(|| Box::new(Loop::new(netlist, &layout.loops[group])));
        let on_demand = self.on_demand.get_or_insert_with(|| OnDemand::new(netlist, layout));
        on_demand.clear();
        steps.take_in(&StateView::state(netlist, layout, memory), on_demand);
        let settled = steps.run(netlist);
        for ((_, slots), (_, at)) in places(netlist, layout, &layout.loops[group]).zip(&steps.driven) {
            memory[slots].copy_from_slice(&steps.values[at.clone()]);
        }
        settled
    }
}

/// A loop as its steps need it: cells by number, and one vector of what they drive and read.
#[derive(Debug)]
struct Loop {
    /// The values of the nets that the loop drives, of those that it reads beside them, and of constants.
    values: Vec<Word>,
    /// The nets that it drives, in the order of [`places`], and where they lie.
    driven: Vec<(NetId, Range<usize>)>,
    /// The nets beside them, which do not change while it is stepped.
    beside: Vec<(NetId, Range<usize>)>,
    cells: Vec<Member>,
    /// For each driven net the cells that are to be computed when it changes.
    readers: Vec<Vec<u32>>,
    /// The cells of the next step, and whether each is among them.
    due: Vec<u32>,
    is_due: Vec<bool>,
    /// The cells of this step, and what they have come to.
    now: Vec<u32>,
    staged: Vec<Word>,
    scratch: Vec<Word>,
}

/// The machine words of an input pin, and where they come from: a place, a bit there, a width.
type Pin = (usize, Vec<(usize, u32, u32)>);

#[derive(Debug)]
struct Member {
    cell: CellId,
    pins: Vec<Pin>,
    /// The first of its outputs among those driven, and the first word of them.
    first: usize,
    at: usize,
}

impl Loop {
    fn new(netlist: &Netlist, cells: &[CellId]) -> Loop {
        let mut new = Loop {
            values: Vec::new(),
            driven: Vec::new(),
            beside: Vec::new(),
            cells: Vec::new(),
            readers: Vec::new(),
            due: Vec::new(),
            is_due: vec![false; cells.len()],
            now: Vec::new(),
            staged: Vec::new(),
            scratch: Vec::new(),
        };
        let mut driver: HashMap<NetId, usize> = HashMap::new();
        for &cell in cells {
            new.cells.push(Member { cell, pins: Vec::new(), first: new.driven.len(), at: new.values.len() });
            for pin in 0..netlist.cell(cell).kind.outputs().len() {
                let net = netlist.output(cell, pin);
                driver.insert(net, new.driven.len());
                let place = new.place(netlist, net);
                new.driven.push((net, place));
            }
        }
        new.readers = vec![Vec::new(); new.driven.len()];
        let (mut beside, mut constants): (HashMap<NetId, usize>, HashMap<NetId, usize>) = Default::default();
        for (number, &cell) in cells.iter().enumerate() {
            let kind = &netlist.cell(cell).kind;
            let mut reads = Vec::new();
            for pin in 0..kind.inputs().len() {
                let mut pieces = Vec::new();
                for s in netlist.input(cell, pin) {
                    let at = if netlist.constants().covers(s) {
                        *constants.entry(s.net).or_insert_with(|| {
                            let place = new.place(netlist, s.net);
                            new.values[place.clone()].copy_from_slice(netlist.constants().net(s.net));
                            place.start
                        })
                    } else if let Some(&net) = driver.get(&s.net) {
                        reads.push(net);
                        new.driven[net].1.start
                    } else {
                        *beside.entry(s.net).or_insert_with(|| {
                            let place = new.place(netlist, s.net);
                            new.beside.push((s.net, place.clone()));
                            place.start
                        })
                    };
                    pieces.push((at, s.lo, s.width));
                }
                if pieces.is_empty() {
                    // an unconnected pin
                    new.values.push(Word::known(u64::from(kind.inputs()[pin].default)));
                    pieces.push((new.values.len() - 1, 0, 1));
                }
                new.cells[number].pins.push((words(kind.input_width(pin).max(1)), pieces));
            }
            // a cell that stores reads what it holds
            let member = &new.cells[number];
            reads.extend(member.first..member.first + kind.outputs().len());
            reads.sort_unstable();
            reads.dedup();
            for net in reads {
                new.readers[net].push(number as u32);
            }
        }
        new
    }

    /// Makes room for a net.
    fn place(&mut self, netlist: &Netlist, net: NetId) -> Range<usize> {
        let start = self.values.len();
        self.values.resize(start + words(netlist.net(net).width), Word::ZERO);
        start..self.values.len()
    }

    /// Takes in the values of all nets that it drives or reads.
    fn take_in(&mut self, state: &StateView<'_>, on_demand: &OnDemand) {
        for (net, at) in self.driven.iter().chain(&self.beside) {
            self.values[at.clone()].copy_from_slice(on_demand.read(state, *net));
        }
    }

    fn held(&self) -> &[Word] {
        &self.values[..self.driven.last().map_or(0, |(_, at)| at.end)]
    }

    fn all_due(&mut self) {
        self.is_due.fill(true);
        self.due.clear();
        self.due.extend(0..self.cells.len() as u32);
    }

    fn run(&mut self, netlist: &Netlist) -> Result<(), Vec<NetId>> {
        self.all_due();
        let mut back = endless::Return::new();
        let mut came_back = false;
        for _ in 1..endless::steps(self.held().len()) {
            if !self.step(netlist) {
                return Ok(());
            }
            came_back = back.has(|kept: &Vec<Word>| self.held() == *kept, || self.held().to_vec());
            if came_back {
                break;
            }
        }
        Err(self.endless(netlist, came_back))
    }

    /// The nets of an endless loop that keep changing, the bits that do made x, all if it has only taken too many steps,
    /// as in the event engine.
    fn endless(&mut self, netlist: &Netlist, came_back: bool) -> Vec<NetId> {
        let start = self.held().to_vec();
        let changing: Vec<u64> = if came_back {
            endless::changing(&start, || {
                self.step(netlist);
                self.held().to_vec()
            })
        } else {
            let all = |net| (0..words(netlist.net(net).width)).map(move |i| word_mask(netlist.net(net).width, i));
            self.driven.iter().flat_map(|(net, _)| all(*net)).collect()
        };
        let (mut nets, used) = (Vec::new(), netlist.used());
        for (net, at) in &self.driven {
            let mut any = 0;
            for (word, &bits) in self.values[at.clone()].iter_mut().zip(&changing[at.clone()]) {
                *word = word.with_x(bits);
                any |= bits;
            }
            if used[net.index()] && any != 0 {
                nets.push(*net);
            }
        }
        self.all_due();
        for _ in 0..endless::SPREADING {
            if !self.step(netlist) {
                break;
            }
        }
        nets
    }

    /// One step; all cells see the values before it. Whether anything changed.
    fn step(&mut self, netlist: &Netlist) -> bool {
        let mut now = std::mem::take(&mut self.now);
        now.clear();
        std::mem::swap(&mut now, &mut self.due);
        self.staged.clear();
        for &number in &now {
            self.is_due[number as usize] = false;
            self.compute(netlist, number as usize);
        }
        let (mut from, mut changed) = (0, false);
        for &number in &now {
            let first = self.cells[number as usize].first;
            for net in first..first + self.outputs(netlist, number as usize) {
                let at = self.driven[net].1.clone();
                let new = &self.staged[from..from + at.len()];
                from += at.len();
                if self.values[at.clone()] == *new {
                    continue;
                }
                changed = true;
                self.values[at].copy_from_slice(new);
                for &reader in &self.readers[net] {
                    if !std::mem::replace(&mut self.is_due[reader as usize], true) {
                        self.due.push(reader);
                    }
                }
            }
        }
        self.now = now;
        changed
    }

    fn outputs(&self, netlist: &Netlist, number: usize) -> usize {
        netlist.cell(self.cells[number].cell).kind.outputs().len()
    }

    /// Adds what a cell comes to to what is staged.
    fn compute(&mut self, netlist: &Netlist, number: usize) {
        let Loop { cells, values, driven, staged, scratch, .. } = self;
        let Member { cell, pins, first, at } = &cells[number];
        let kind = &netlist.cell(*cell).kind;
        scratch.clear();
        for (words, pieces) in pins {
            let start = scratch.len();
            scratch.resize(start + words, Word::ZERO);
            let mut bit = 0;
            for &(from, lo, width) in pieces {
                copy(&mut scratch[start..], bit, &values[from..], lo, width);
                bit += width;
            }
        }
        let (mut ins, mut rest): ([&[Word]; PINS], &[Word]) = ([&[]; PINS], scratch);
        for (to, (words, _)) in ins.iter_mut().zip(pins) {
            (*to, rest) = rest.split_at(*words);
        }
        let outputs = kind.outputs().len();
        let end = driven[first + outputs - 1].1.end;
        let start = staged.len();
        staged.extend_from_slice(&values[*at..end]);
        let (mut outs, mut rest): ([&mut [Word]; PINS], &mut [Word]) = (Default::default(), &mut staged[start..]);
        for (to, (_, at)) in outs.iter_mut().zip(&driven[*first..first + outputs]) {
            (*to, rest) = rest.split_at_mut(at.len());
        }
        evaluate(kind, &ins[..pins.len()], &mut outs[..outputs]);
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
