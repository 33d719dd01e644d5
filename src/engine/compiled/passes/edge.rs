//! One edge of an input as straight code: from the settled state before it to the settled state after it, with the cells that
//! it clocks.
//!
//! Delta cycles are run on nodes in place of values. What the input is before and after is known here, so clock pins that
//! follow it make an edge or do not, and what cannot change is not computed. Cells behind a gated clock take their value by a
//! select.
//!
//! Sound: it is made only where the rounds of edges end by the wiring alone, whatever the values. It assumes that the circuit
//! is settled, that clock pins are known, that state is known where the variant assumes so, that combinational loops settle
//! within the unrolled steps, and that no control tells of itself by becoming unknown. Each assumption that is not certain
//! is a bail-out: a node that must be 0, looked at before anything is stored. State that becomes unknown although it is
//! assumed known fails a guard if nothing in the same edge has read it, and is a bail-out if something has.

use crate::cell::CellKind;
use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::record::{Record, Traced};
use crate::compiled::ir::schedule::Partition;
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;
use crate::compiled::lower::Lowered;
use crate::compiled::lower::four::{Bits, Two};
use crate::compiled::lower::layout::Kept;
use crate::compiled::lower::layout::{Bit, Part, StateLayout};
use crate::compiled::lower::memory::{self, Controls, Element, Read, Written};
use crate::netlist::Netlist;

/// Rounds of edges that are followed.
const ROUNDS: usize = 8;
/// Nodes above which an edge is not worth being one piece.
const LIMIT: usize = 400_000;

/// An edge: a graph, and the one partition of it.
#[derive(Debug)]
pub(crate) struct EdgeCode {
    pub graph: Graph,
    pub partition: Partition,
    /// What it writes down.
    pub record: Record,
}

/// A control bit that may be unknown, and what of it has been seen.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Watched {
    pub bit: Bit,
    /// It has been known: that it is not is told once.
    pub seen: bool,
}

/// What an edge is made from.
pub(crate) struct Source<'s> {
    pub netlist: &'s Netlist,
    pub lowered: &'s Lowered,
    pub layout: &'s StateLayout,
    /// The nets that are kept.
    pub kept: &'s [Kept],
    /// Whether a slot of state may be unknown in the variant.
    pub allows: &'s dyn Fn(Slot) -> bool,
    /// Controls that are to be told of when they become unknown or, where they have not been known yet, known.
    pub watched: &'s [Watched],
    /// The slot of the input, and what it becomes.
    pub input: Slot,
    pub level: bool,
}

struct Straighten<'s> {
    s: &'s Source<'s>,
    out: Graph,
    /// State that is not what memory has: its settled value.
    state: Map<Slot, Two>,
    /// What has been written into memories.
    puts: Vec<Put>,
    /// Unknown planes of new state that is taken to be known, and whether anything has read it.
    guards: Map<Slot, (Id, bool)>,
    /// For each node of the variant its node here, in the present round.
    memo: Vec<Id>,
    /// Nodes that may have changed in the present round.
    affected: Vec<bool>,
    /// The nodes that load state.
    loads: Map<PlaneWord, Id>,
    /// State that controls and loops have changed in the last round.
    moved: Vec<Slot>,
    /// Nodes that are to be 0.
    bail_outs: Vec<Id>,
}

/// The edge that `source` asks for, if it can be straight code.
pub(crate) fn straighten(source: &Source<'_>) -> Option<EdgeCode> {
    let n = source.lowered.graph.len();
    let mut f = Straighten {
        s: source,
        out: Graph::default(),
        state: Map::default(),
        puts: Vec::new(),
        guards: Map::default(),
        memo: vec![Id::NONE; n],
        affected: vec![false; n],
        loads: Map::default(),
        moved: Vec::new(),
        bail_outs: Vec::new(),
    };
    for node in source.lowered.graph.ids() {
        if let Op::Load(plane) = source.lowered.graph.op(node) {
            f.loads.insert(plane, node);
        }
    }
    f.run()
}

/// a plane of an element of contents after what has been written.
fn fetch_after(g: &mut Graph, puts: &[Put], e: Element, index: Id) -> Id {
    let before = memory::fetch(g, e, index);
    puts.iter().fold(before, |before, put| memory::after(g, put, e, index, before))
}

impl Straighten<'_> {
    fn run(&mut self) -> Option<EdgeCode> {
        let Source { lowered, layout, input, level, .. } = *self.s;
        let mut ever = vec![false; lowered.graph.len()];
        // before anything has changed
        let before = self.constant(!level);
        self.state.insert(input, before);
        let mut pins = self.pin_values();
        let after = self.constant(level);
        self.state.insert(input, after);
        let mut changed = vec![input];
        for _ in 0..ROUNDS {
            self.forget(&changed);
            ever.iter_mut().zip(&self.affected).for_each(|(e, a)| *e |= a);
            self.settle(&ever);
            let mut touched: Vec<usize> =
                (0..layout.pins.len()).filter(|&i| self.touches(layout.pins[i].bit)).collect();
            // controls at which cells sample when they become unknown only are to be known
            touched.retain(|&i| {
                let pin = &layout.pins[i];
                let clocks = !(pin.rising.is_empty() && pin.falling.is_empty());
                if !clocks {
                    self.pin(pin.bit);
                }
                clocks
            });
            if touched.is_empty() {
                return self.finish(&ever);
            }
            let mut takes: Map<u32, Id> = Map::default();
            for i in touched {
                let pin = &layout.pins[i];
                let new = self.pin(pin.bit);
                let known = Two { v: new, u: self.out.constant(0) };
                let Two { v: old, u } = std::mem::replace(&mut pins[i], known);
                self.bail_out_if(u);
                let (rises, falls) = (self.out.and_not(new, old), self.out.and_not(old, new));
                for (edge, list) in [(rises, &pin.rising), (falls, &pin.falling)] {
                    if self.out.is(edge, 0) {
                        continue;
                    }
                    for &store in list {
                        let none = self.out.constant(0);
                        let already = takes.get(&store).copied().unwrap_or(none);
                        takes.insert(store, self.out.or(already, edge));
                    }
                }
            }
            let mut takes: Vec<(u32, Id)> = takes.into_iter().collect();
            takes.sort_unstable();
            changed.clear();
            let mut taken = Vec::new();
            let written = self.written(&takes);
            for (store, when) in takes {
                let stored = layout.stored[store as usize];
                let next = match stored.part {
                    Part::Whole => self.map_all(&lowered.next[store as usize].value),
                    Part::Read(port) => self.port_reads(store, port, &written),
                    Part::Write(_) => continue,
                };
                for (slot, new) in stored.slot.up().zip(next) {
                    let old = self.held(slot);
                    let new = Two { v: self.out.select(when, new.v, old.v), u: self.out.select(when, new.u, old.u) };
                    let new = self.known(slot, new);
                    if new != old {
                        taken.push((slot, new));
                    }
                }
            }
            let puts = self.port_writes(&written);
            if taken.is_empty() && puts.is_empty() {
                return self.finish(&ever);
            }
            for (slot, new) in taken {
                self.state.insert(slot, new);
                changed.push(slot);
            }
            for put in puts {
                changed.push(put.slot);
                self.puts.push(put);
            }
        }
        None
    }

    fn map_all(&mut self, list: &[Two]) -> Bits {
        list.iter().map(|two| Two { v: self.map(two.v), u: self.map(two.u) }).collect()
    }

    /// What the write ports among those that take something write, with the numbers of their memories.
    fn written(&mut self, takes: &[(u32, Id)]) -> Vec<(usize, Written)> {
        let Source { lowered, layout, .. } = *self.s;
        let mut list = Vec::new();
        for &(store, when) in takes {
            let stored = layout.stored[store as usize];
            let Part::Write(port) = stored.part else { continue };
            let mut words = self.map_all(&lowered.next[store as usize].value);
            let enable = words.split_off(words.len() / 2 + 1);
            let data = words.split_off(1);
            list.push((
                layout.memory_of[&stored.cell],
                Written { port: port as usize, when, address: words[0], data, enable },
            ));
        }
        list
    }

    /// What a read port has after its edge.
    fn port_reads(&mut self, store: u32, port: u32, written: &[(usize, Written)]) -> Bits {
        let Source { lowered, layout, netlist, .. } = *self.s;
        let stored = layout.stored[store as usize];
        let CellKind::Memory(memory) = &netlist.cell(stored.cell).kind else {
            unreachable!("only memories have ports")
        };
        let place = layout.memory_of[&stored.cell];
        let words = self.map_all(&lowered.next[store as usize].value);
        let controls = Controls { en: words[0], arst: words[1], srst: words[2], address: words[3] };
        let held: Bits = stored.slot.up().take(stored.words as usize).map(|slot| self.held(slot)).collect();
        let written: Vec<Written> = written.iter().filter(|w| w.0 == place).map(|w| w.1.clone()).collect();
        let puts = &self.puts;
        let read = Read { memory, contents: layout.memories[place].contents, port: port as usize };
        memory::clocked(&mut self.out, &read, &controls, &written, &held, &mut |g, e, index| {
            fetch_after(g, puts, e, index)
        })
    }

    /// What is written into memories, writes to the same place at once.
    fn port_writes(&mut self, written: &[(usize, Written)]) -> Vec<Put> {
        let Source { layout, netlist, .. } = *self.s;
        let mut all: Vec<Put> = Vec::new();
        for (place, w) in written {
            let place = &layout.memories[*place];
            let CellKind::Memory(memory) = &netlist.cell(place.cell).kind else { unreachable!("it is a memory") };
            for put in memory::write(&mut self.out, memory, place.contents, w) {
                if self.out.is(put.mask, 0) {
                    continue;
                }
                match all.last().and_then(|last| memory::join(&mut self.out, last, &put)) {
                    Some(joined) => *all.last_mut().expect("it was joined to the last") = joined,
                    None => all.push(put),
                }
            }
        }
        all
    }

    fn constant(&mut self, bit: bool) -> Two {
        Two { v: self.out.constant(bit.into()), u: self.out.constant(0) }
    }

    fn word(&self, bit: Bit) -> Two {
        self.s.lowered.nets[bit.net.index()][bit.lo as usize / 64]
    }

    fn touches(&self, bit: Bit) -> bool {
        let Two { v, u } = self.word(bit);
        self.affected[v.index()] || self.affected[u.index()]
    }

    /// New state; where it is taken to be known, it is to be that, at least if anything reads it in this edge.
    fn known(&mut self, slot: Slot, new: Two) -> Two {
        if (self.s.allows)(slot) {
            return new;
        }
        if let Some((u, _)) = self.guards.remove(&slot) {
            self.bail_out_if(u);
        }
        if !self.out.is(new.u, 0) {
            self.guards.insert(slot, (new.u, false));
        }
        Two { v: new.v, u: self.out.constant(0) }
    }

    fn bail_out_if(&mut self, node: Id) {
        if !self.out.is(node, 0) && !self.bail_outs.contains(&node) {
            self.bail_outs.push(node);
        }
    }

    /// A plane word of state as it stands in this round.
    fn load(&mut self, plane: PlaneWord, may: u64) -> Id {
        match self.state.get(&plane.slot()) {
            Some(two) => {
                if let Some(guard) = self.guards.get_mut(&plane.slot()) {
                    guard.1 = true;
                }
                if plane.is_value() { two.v } else { two.u }
            }
            None => self.out.load(plane, may),
        }
    }

    /// State as it stands.
    fn held(&mut self, slot: Slot) -> Two {
        let layout = self.s.layout;
        let may = layout.leaf_mask[(slot - layout.leaves.start) as usize];
        let v = self.load(slot.value(), may);
        let u = if (self.s.allows)(slot) { self.load(slot.unknown(), may) } else { self.out.constant(0) };
        Two { v, u }
    }

    /// The clock pins before anything changes: what the level of the input decides, or what memory has.
    fn pin_values(&mut self) -> Vec<Two> {
        self.keep_levels();
        let layout = self.s.layout;
        let values = (0..layout.pins.len()).map(|i| {
            let bit = layout.pins[i].bit;
            let slot = layout.slot[bit.net.index()].expect("clock pins are kept") + bit.lo / 64;
            let two = self.word(bit);
            let mut plane = |node: Id, plane: PlaneWord| {
                let decided = self.map(node);
                let decided = self.out.bits(decided, bit.lo % 64, 1);
                if self.out.value(decided).is_some() {
                    return decided;
                }
                let may = self.s.lowered.graph.possible_bits(node);
                let word = self.load(plane, may);
                self.out.bits(word, bit.lo % 64, 1)
            };
            Two { v: plane(two.v, slot.value()), u: plane(two.u, slot.unknown()) }
        });
        let values = values.collect();
        self.memo.fill(Id::NONE);
        values
    }

    /// A clock pin, which is to be known.
    fn pin(&mut self, bit: Bit) -> Id {
        let Two { v, u } = self.word(bit);
        let (v, u) = (self.map(v), self.map(u));
        let unknown = self.out.bits(u, bit.lo % 64, 1);
        self.bail_out_if(unknown);
        self.out.bits(v, bit.lo % 64, 1)
    }

    /// The nodes that depend on some slots of state.
    fn spread(&self, changed: &[Slot]) -> Vec<bool> {
        let graph = &self.s.lowered.graph;
        let first = self.s.layout.leaves.start;
        let mut is_changed = vec![false; self.s.layout.leaves.len()];
        let (state, contents): (Vec<Slot>, Vec<Slot>) =
            changed.iter().partition(|slot| self.s.layout.leaves.contains(**slot));
        state.iter().for_each(|&slot| is_changed[(slot - first) as usize] = true);
        let mut affected = vec![false; graph.len()];
        for node in graph.ids() {
            affected[node.index()] = match graph.op(node) {
                Op::Const(_) => false,
                Op::Load(plane) => is_changed[(plane.slot() - first) as usize],
                Op::Element { slot, index, .. } => contents.contains(&slot) || affected[index.index()],
                op => op.operands().any(|o| affected[o.index()]),
            };
        }
        affected
    }

    /// Begins a round in which some slots of state have changed.
    fn forget(&mut self, changed: &[Slot]) {
        self.affected = self.spread(changed);
        let mut forgotten = self.affected.clone();
        // What controls and loops have made of the state changes no net any more: it has settled. But what has been
        // computed on the way is of the state before that, and is not to be mixed with what is computed from now on.
        if !self.moved.is_empty() {
            let moved = std::mem::take(&mut self.moved);
            forgotten.iter_mut().zip(self.spread(&moved)).for_each(|(f, m)| *f |= m);
        }
        self.memo.iter_mut().zip(forgotten).filter(|(_, f)| *f).for_each(|(m, _)| *m = Id::NONE);
    }

    /// Takes state whose controls have not changed as it stands.
    fn keep_levels(&mut self) {
        for level in &self.s.lowered.levels {
            if level.needs.iter().any(|&n| self.affected[n.index()]) {
                continue;
            }
            for (slot, two) in level.slot.up().zip(&level.value) {
                let held = self.held(slot);
                for (node, value) in [(two.v, held.v), (two.u, held.u)] {
                    if !self.s.lowered.graph.op(node).is_leaf() {
                        self.memo[node.index()] = value;
                    }
                }
            }
        }
    }

    /// What asynchronous controls and loops make of the state.
    fn settle(&mut self, ever: &[bool]) {
        self.keep_levels();
        // what is kept and has not changed need not be computed
        for &Kept { net, .. } in self.s.kept {
            let slot = self.s.layout.slot[net.index()].expect("what is kept has a place");
            if self.s.layout.leaves.contains(slot) {
                continue;
            }
            for (slot, two) in slot.up().zip(&self.s.lowered.nets[net.index()]) {
                for (plane, node) in [(slot.value(), two.v), (slot.unknown(), two.u)] {
                    let graph = &self.s.lowered.graph;
                    if !ever[node.index()] && !graph.op(node).is_leaf() && self.memo[node.index()] == Id::NONE {
                        self.memo[node.index()] = self.out.load(plane, graph.possible_bits(node));
                    }
                }
            }
        }
        let mut settled = Vec::new();
        for level in &self.s.lowered.levels {
            if !level.needs.iter().any(|&n| self.affected[n.index()]) {
                continue;
            }
            for (slot, two) in level.slot.up().zip(&level.value) {
                // all of it is of the state before
                let old = [slot.value(), slot.unknown()].map(|plane| self.loads.get(&plane).copied());
                let old = old.map(|node| node.map(|node| self.map(node)));
                settled.push((slot, Two { v: self.map(two.v), u: self.map(two.u) }, old));
            }
            if let Some(group) = level.group {
                let unsettled = self.map(self.s.lowered.unsettled[group as usize]);
                self.bail_out_if(unsettled);
            }
        }
        for (slot, new, old) in settled {
            if old[0].is_some_and(|old| old != new.v) || old[1].is_some_and(|old| old != new.u) {
                self.moved.push(slot);
            }
            let new = self.known(slot, new);
            self.state.insert(slot, new);
        }
    }

    /// The node here of one of the variant.
    fn map(&mut self, node: Id) -> Id {
        let graph = &self.s.lowered.graph;
        let mut stack = vec![node];
        while let Some(&at) = stack.last() {
            if self.memo[at.index()] != Id::NONE {
                stack.pop();
                continue;
            }
            let op = graph.op(at);
            let before = stack.len();
            stack.extend(op.operands().filter(|&o| self.memo[o.index()] == Id::NONE));
            if stack.len() > before {
                continue;
            }
            stack.pop();
            let made = match op {
                Op::Load(plane) => self.load(plane, graph.possible_bits(at)),
                Op::Element { slot, index, size, plane } => {
                    let e = Element { slot, size, plane, may: graph.possible_bits(at) };
                    fetch_after(&mut self.out, &self.puts, e, self.memo[index.index()])
                }
                op => {
                    let memo = &self.memo;
                    self.out.rebuild(op, graph.possible_bits(at), |o| memo[o.index()])
                }
            };
            self.memo[at.index()] = made;
        }
        self.memo[node.index()]
    }

    /// What is left in memory.
    fn finish(&mut self, ever: &[bool]) -> Option<EdgeCode> {
        let Source { lowered, layout, kept, input, watched, .. } = *self.s;
        for &Watched { bit, seen } in watched {
            let unknown = self.word(bit).u;
            // what has not changed was looked at before
            if ever[unknown.index()] {
                let unknown = self.map(unknown);
                let unknown = self.out.bits(unknown, bit.lo % 64, 1);
                let one = self.out.constant(1);
                let tells = if seen { unknown } else { self.out.xor(unknown, one) };
                self.bail_out_if(tells);
            }
        }
        let mut observed: Map<Slot, u32> = Map::default();
        let mut stores: Vec<Store> = Vec::new();
        let store = |node, plane, observed: Option<u32>| Store {
            observed,
            compared: observed.is_some(),
            ..Store::plain(node, plane)
        };
        let mut traced: Vec<Traced> = Vec::new();
        for k in kept {
            let (net, bit) = (k.net, k.observed.filter(|_| k.stops));
            let slot = layout.slot[net.index()].expect("what is kept has a place");
            let values = &lowered.nets[net.index()];
            let is_leaf = layout.leaves.contains(slot);
            if k.traced {
                traced.extend((0..).zip(values).map(|(word, two)| {
                    let known = if is_leaf { !(self.s.allows)(slot + word) } else { lowered.graph.is(two.u, 0) };
                    Traced { net, word, slot: slot + word, known, bit: layout.widths[net.index()] == 1 }
                }));
            }
            if is_leaf {
                if let Some(bit) = bit {
                    (0..values.len() as u32).for_each(|i| _ = observed.insert(slot + i, bit));
                }
                continue;
            }
            for (slot, two) in slot.up().zip(values) {
                for (plane, node) in [(slot.value(), two.v), (slot.unknown(), two.u)] {
                    if ever[node.index()] {
                        let node = self.map(node);
                        stores.push(store(node, plane, bit));
                    }
                }
            }
        }
        let mut state: Vec<(Slot, Two)> = self.state.iter().map(|(&slot, &two)| (slot, two)).collect();
        state.sort_unstable_by_key(|s| s.0);
        for (slot, two) in state.into_iter().filter(|s| s.0 != input) {
            let bit = observed.get(&slot).copied();
            let is_old = |node: Id, plane: PlaneWord| self.out.op(node) == Op::Load(plane);
            if !is_old(two.v, slot.value()) {
                stores.push(store(two.v, slot.value(), bit));
            }
            if !is_old(two.u, slot.unknown()) && (self.s.allows)(slot) {
                stores.push(store(two.u, slot.unknown(), bit));
            }
        }
        let mut guards: Vec<(Slot, (Id, bool))> = self.guards.drain().collect();
        guards.sort_unstable_by_key(|a| a.0);
        for (slot, (u, read)) in guards {
            // what is written down of it is its value plane alone
            if read || traced.iter().any(|t| t.slot == slot) {
                self.bail_out_if(u);
            } else {
                stores.push(Store { guard: true, ..store(u, slot.unknown(), observed.get(&slot).copied()) });
            }
        }
        let record = Record::new(traced, &stores, input, self.s.level);
        let puts = std::mem::take(&mut self.puts);
        let stored = stores.iter().map(|s| s.node).chain(puts.iter().flat_map(Put::nodes));
        let nodes = self.out.needed(stored.chain(self.bail_outs.iter().copied()));
        let partition = Partition { nodes, stores, group: None, bail_outs: std::mem::take(&mut self.bail_outs), puts };
        (partition.nodes.len() <= LIMIT).then(|| EdgeCode { graph: std::mem::take(&mut self.out), partition, record })
    }
}
