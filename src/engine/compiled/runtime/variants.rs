//! Variants of a circuit in machine code: the four-valued one, and those for which some or all of the state is known.

use std::sync::Arc;

use crate::Field;
use crate::compiled::CompileError;
use crate::compiled::codegen::machine::{EdgeLoop, Machine};
use crate::compiled::codegen::trace;
use crate::compiled::codegen::{self, Shared, dirty_bit};
use crate::compiled::ir::graph::Map;
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::schedule::{Root, Schedule};
use crate::compiled::lower::layout::{Kept, Part, StateLayout, StatePlaces};
use crate::compiled::lower::{Level, Lowered, lower};
use crate::compiled::passes::edge::{EdgeCode, Source, Watched, straighten};
use crate::compiled::passes::partition::partition;
use crate::compiled::runtime::cycle::Cycle;
use crate::compiled::runtime::{PATIENCE, WARM, WARM_NODES};
use crate::netlist::Netlist;

/// How many nodes go into a partition.
pub(crate) const PARTITION_SIZE: usize = 160;
/// Pieces of a long edge are so many times as long.
pub(crate) const FUNCTION_SIZE: usize = 10;

/// What is wanted of a netlist.
#[derive(Debug)]
pub(crate) struct Request<'w> {
    pub layout: &'w StateLayout,
    /// Nets whose values may have to be kept.
    pub kept: &'w [Kept],
    pub shared: Shared,
    /// Nodes in a partition, at most.
    pub partition: usize,
    /// How many shapes of records there are.
    pub shapes: usize,
}

/// The edges of one input in machine code: to 1, to 0, and the two in a loop.
#[derive(Debug)]
pub(crate) struct EdgeLoops {
    pub single: [EdgeLoop; 2],
    pub edge_loop: EdgeLoop,
    /// The most that they write down, in words.
    pub longest: usize,
    /// The fields of their records, until they are given to the log.
    pub shapes: Vec<Box<[Field]>>,
    /// The two in one step on packed state, made when a run turns out to be long.
    pub cycle: Option<Option<Box<Cycle>>>,
    /// The controls that they tell of.
    pub watched: Vec<Watched>,
    /// How many times they have bailed out before they did anything.
    pub bail_outs: u32,
    /// Edges that they sit out after that, and how many of these are to come.
    pub patience: u32,
    pub waiting: u32,
    up: EdgeCode,
    down: EdgeCode,
}

impl EdgeLoops {
    /// The cycle, if it can be made.
    pub fn cycle(&mut self, groups: &[Vec<(u8, PlaneWord)>], piece: usize, end: &mut u32) -> Option<&mut Cycle> {
        let EdgeLoops { up, down, .. } = self;
        self.cycle.get_or_insert_with(|| Cycle::new(&[up, down], groups, piece, end).map(Box::new)).as_deref_mut()
    }
}

/// One variant.
#[derive(Debug)]
pub(crate) struct Variant {
    pub machine: Machine,
    pub settling: usize,
    /// Where its dirty bits begin.
    pub dirty: PlaneWord,
    /// For each slot of state where in `wakes` the dirty words and bits begin that a change sets.
    wakes_start: Vec<u32>,
    wakes: Vec<(u32, u64)>,
    /// The same for the contents of each memory.
    pub memory_wakes: Vec<Vec<(u32, u64)>>,
    first_leaf: Slot,
    /// What is constant: where it belongs, its value, the bit that tells of a change.
    pub constants: Vec<(PlaneWord, u64, Option<u32>)>,
    /// State that controls keep at a constant, whatever is sampled.
    pub fixed: Vec<(PlaneWord, u64)>,
    /// Slots of state that may be unknown; none if that is all.
    pub unknown: Option<Vec<Slot>>,
    /// Numbers of the control bits that may be unknown.
    pub doubtful: Vec<u32>,
    /// For each net whether it is kept, by straight code too: controls that may be unknown are by partitions alone.
    pub keeps: Vec<bool>,
    /// What edges are made from, if it is small enough, and those that have been made; none where one cannot be.
    lowered: Option<Lowered>,
    edge_loops: Map<Slot, Option<EdgeLoops>>,
    /// The loop that is stepped in each settling partition, if one is.
    pub groups: Vec<Option<u32>>,
    /// How many phases have run in this variant, and after how many edges are made.
    pub phases: u64,
    pub warm: u64,
    /// When it was entered, how often it has failed soon after that, and from when on it may be entered again.
    pub entered: u64,
    pub failures: u32,
    pub barred: u64,
    /// Single bits of state that people see as words: lanes and value planes.
    pub buses: Arc<[Vec<(u8, PlaneWord)>]>,
}

/// Nodes up to which edges are made as straight code.
const MOST_NODES: usize = 400_000;

impl Variant {
    /// Compiles a variant in which `unknown` slots of state, or all, may hold x or z. `end` is how many slots of memory are
    /// taken, and is moved.
    pub fn new(
        netlist: &Netlist,
        w: &Request<'_>,
        unknown: Option<Vec<Slot>>,
        end: &mut u32,
    ) -> Result<Variant, CompileError> {
        let may = |slot: Slot| unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok());
        let lowered = lower(netlist, &StatePlaces { layout: w.layout, unknown: &may });
        let graph = &lowered.graph;
        let doubtful = w.layout.controls.iter().enumerate().filter(|(_, (bit, _))| {
            let word = lowered.nets[bit.net.index()][bit.lo as usize / 64];
            !graph.is(word.u, 0)
        });
        let doubtful: Vec<u32> = doubtful.map(|(i, _)| i as u32).collect();
        let mut keeps = vec![false; lowered.nets.len()];
        w.kept.iter().for_each(|k| keeps[k.net.index()] |= k.always);
        let mut wanted = keeps.clone();
        doubtful.iter().for_each(|&i| wanted[w.layout.controls[i as usize].0.net.index()] = true);
        let (settling, sampled) = roots(&lowered, w, &may, &wanted);
        let mut spare: Option<PlaneWord> = None;
        let fresh = || {
            spare.take().unwrap_or_else(|| {
                let plane = Slot::at(*end as usize).value();
                *end += 1;
                spare = Some(plane + 1);
                plane
            })
        };
        let schedule = partition(graph, &settling, &sampled, w.partition, fresh);
        let dirty = Slot::at(*end as usize).value();
        let late = schedule.partitions.len() - schedule.settling;
        *end += (schedule.settling.div_ceil(64) + late.div_ceil(64)) as u32 / 2 + 1;
        if *end > 1 << 26 {
            return Err(CompileError::TooLarge);
        }
        let machine = codegen::compile(graph, &schedule, Shared { dirty, ..w.shared })?;
        let (mut wakes_start, mut wakes) = (vec![0], Vec::new());
        for slot in w.layout.leaves.iter() {
            wakes.extend(woken(&schedule, slot));
            wakes_start.push(wakes.len() as u32);
        }
        let memory_wakes = w.layout.memories.iter().map(|m| woken(&schedule, m.contents)).collect();
        let first_leaf = w.layout.leaves.start;
        let constants = schedule.constants.iter().map(|(root, n)| (root.plane, *n, root.observed)).collect();
        let fixed = schedule.constants.iter().filter(|(root, _)| w.layout.leaves.contains(root.plane.slot()));
        let fixed = fixed.map(|(root, n)| (root.plane, *n)).collect();
        let warm = WARM + (graph.len() / WARM_NODES) as u64;
        // which a run soon leaves, as a rule
        let warm = if unknown.is_some() { warm } else { 4 * (warm + PATIENCE) };
        let small = graph.len() <= MOST_NODES;
        Ok(Variant {
            machine,
            settling: schedule.settling,
            dirty,
            wakes_start,
            wakes,
            memory_wakes,
            first_leaf,
            constants,
            fixed,
            unknown,
            doubtful,
            keeps,
            lowered: small.then_some(lowered),
            edge_loops: Map::default(),
            groups: schedule.partitions.iter().map(|c| c.group).collect(),
            phases: 0,
            warm,
            entered: 0,
            failures: 0,
            barred: 0,
            buses: buses(netlist, w.layout).into(),
        })
    }

    /// The dirty words and bits that a change of a slot sets.
    #[inline(always)]
    pub fn wakes(&self, slot: Slot) -> &[(u32, u64)] {
        let at = (slot - self.first_leaf) as usize;
        &self.wakes[self.wakes_start[at] as usize..self.wakes_start[at + 1] as usize]
    }

    /// Whether all slots of a list may be unknown in this variant.
    pub fn allows_all(&self, slots: &[Slot]) -> bool {
        slots.iter().all(|&slot| self.allows(slot))
    }

    /// How many slots of state may be unknown.
    pub fn breadth(&self) -> usize {
        self.unknown.as_ref().map_or(usize::MAX, Vec::len)
    }

    /// Whether a slot of state may be unknown in this variant.
    pub fn allows(&self, slot: Slot) -> bool {
        self.unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok())
    }

    /// The edges of an input, in machine code; made when they are first asked for.
    pub fn edge_loops(
        &mut self,
        netlist: &Netlist,
        w: &Request<'_>,
        input: Slot,
        watched: &dyn Fn(&[u32]) -> Vec<Watched>,
        end: &mut u32,
    ) -> Option<&mut EdgeLoops> {
        if !self.edge_loops.contains_key(&input) {
            let made = self.make_edge_loops(netlist, w, input, watched(&self.doubtful), end);
            self.edge_loops.insert(input, made);
        }
        self.edge_loops.get_mut(&input)?.as_mut()
    }

    fn make_edge_loops(
        &self,
        netlist: &Netlist,
        w: &Request<'_>,
        input: Slot,
        watched: Vec<Watched>,
        end: &mut u32,
    ) -> Option<EdgeLoops> {
        let lowered = self.lowered.as_ref()?;
        let kept: Vec<Kept> = w.kept.iter().copied().filter(|k| self.keeps[k.net.index()]).collect();
        let allows = |slot: Slot| self.allows(slot);
        let edge = |level| {
            let (kept, allows, watched) = (&kept, &allows, &watched);
            straighten(&Source { netlist, lowered, layout: w.layout, kept, allows, watched, input, level })
        };
        let (mut up, mut down) = (edge(true)?, edge(false)?);
        let mut shapes = Vec::new();
        for edge in [&mut up, &mut down] {
            edge.record.shape = w.shapes + shapes.len();
            shapes.push(edge.record.fields());
        }
        let longest = up.record.longest() + down.record.longest();
        if longest > trace::ROOM {
            return None;
        }
        let first = *end;
        let mut make = |edges: &[&EdgeCode]| {
            // what pieces leave each other lies at the same place in all: only one of them runs
            let mut next = 2 * first;
            let fresh = || {
                next += 1;
                PlaneWord::at(next - 1)
            };
            let made = codegen::compile_loop(edges, w.partition * FUNCTION_SIZE, w.shared, fresh).ok();
            *end = (*end).max(next.div_ceil(2));
            made
        };
        let (single, edge_loop) = ([make(&[&down])?, make(&[&up])?], make(&[&up, &down])?);
        Some(EdgeLoops {
            single,
            edge_loop,
            longest,
            shapes,
            cycle: None,
            watched,
            bail_outs: 0,
            waiting: 0,
            patience: 0,
            up,
            down,
        })
    }

    /// Has the straight code of an input made anew: it is to tell of other controls.
    pub fn renew_edges(&mut self, input: Slot) {
        self.edge_loops.remove(&input);
    }
}

/// All state that may become unknown, directly or not, where `unknown` slots may be.
pub(crate) fn reach(netlist: &Netlist, layout: &StateLayout, mut unknown: Vec<Slot>) -> Vec<Slot> {
    loop {
        let may = |slot: Slot| unknown.binary_search(&slot).is_ok();
        let lowered = lower(netlist, &StatePlaces { layout, unknown: &may });
        let mut more: Vec<Slot> = Vec::new();
        let mut add = |slot: Slot, u| {
            if !lowered.graph.is(u, 0) && !may(slot) {
                more.push(slot);
            }
        };
        for level in &lowered.levels {
            level.slot.up().zip(&level.value).for_each(|(slot, two)| add(slot, two.u));
        }
        let mut ports = Vec::new();
        for (next, stored) in lowered.next.iter().zip(&layout.stored) {
            match stored.part {
                Part::Whole => stored.slot.up().zip(&next.value).for_each(|(slot, two)| add(slot, two.u)),
                // any word of a memory may be unknown
                Part::Read(_) => ports.extend(stored.slot.up().take(stored.words as usize).filter(|&slot| !may(slot))),
                Part::Write(_) => {}
            }
        }
        more.extend(ports);
        if more.is_empty() {
            return unknown;
        }
        unknown.extend(more);
        unknown.sort_unstable();
        unknown.dedup();
    }
}

/// Single bits of state that have names as bits of a word, each bit once.
fn buses(netlist: &Netlist, layout: &StateLayout) -> Vec<Vec<(u8, PlaneWord)>> {
    let mut all: Vec<Vec<(u8, PlaneWord)>> = Vec::new();
    for signal in netlist.signal_ids().filter(|&s| netlist.signal(s).width > 1) {
        let (mut lane, mut bits) = (0u32, Vec::new());
        for slice in netlist.bits(signal) {
            let slot = layout.slot[slice.net.index()].filter(|slot| layout.leaves.contains(*slot));
            if let Some(slot) = slot
                && netlist.net(slice.net).width == 1
            {
                bits.push((lane, slot.value()));
            }
            lane += slice.width;
        }
        for first in (0..lane).step_by(64) {
            let part = bits.iter().filter(|b| (first..first + 64).contains(&b.0)).map(|b| ((b.0 - first) as u8, b.1));
            let part: Vec<(u8, PlaneWord)> = part.collect();
            if part.len() > 1 {
                all.push(part);
            }
        }
    }
    all.sort_by_key(|bits| std::cmp::Reverse(bits.len()));
    let mut taken = Map::default();
    all.retain_mut(|bits| {
        bits.retain(|b| !taken.contains_key(&b.1));
        bits.iter().for_each(|b| _ = taken.insert(b.1, ()));
        bits.len() > 1
    });
    all
}

/// The dirty words and bits that a change of a slot sets.
fn woken(schedule: &Schedule, slot: Slot) -> Vec<(u32, u64)> {
    let mut wakes: Vec<(u32, u64)> = Vec::new();
    for &partition in schedule.readers.get(&slot).map_or(&[][..], Vec::as_slice) {
        let (word, bit) = dirty_bit(schedule.settling, partition);
        match wakes.iter_mut().find(|l| l.0 == word) {
            Some(found) => found.1 |= bit,
            None => wakes.push((word, bit)),
        }
    }
    wakes
}

/// What is wanted in memory once settled, and before an edge.
fn roots(l: &Lowered, w: &Request<'_>, may: &dyn Fn(Slot) -> bool, keeps: &[bool]) -> (Vec<Root>, Vec<Root>) {
    let (mut settling, mut sampled) = (Vec::new(), Vec::new());
    let mut observed = vec![None; l.nets.len()];
    for k in w.kept {
        observed[k.net.index()] = k.observed;
    }
    let mut is_level = vec![false; l.nets.len()];
    for (number, Level { slot, net, value, group, .. }) in l.levels.iter().enumerate() {
        net.iter().for_each(|net| is_level[net.index()] = true);
        for (i, two) in (0..).zip(value) {
            let (slot, observed) = (*slot + i, net.and_then(|net| observed[net.index()]));
            let root = Root {
                node: two.v,
                plane: slot.value(),
                observed,
                guard: false,
                shared: false,
                group: *group,
                again: false,
                state: true,
            };
            settling.push(root);
            settling.push(Root { node: two.u, plane: slot.unknown(), guard: !may(slot), ..root });
        }
        if let Some(group) = group.filter(|_| l.levels.get(number + 1).is_none_or(|next| next.group != *group)) {
            let (node, plane) = (l.unsettled[group as usize], w.layout.unsettled[group as usize].value());
            let (observed, group) = (None, Some(group));
            settling.push(Root {
                node,
                plane,
                observed,
                guard: false,
                shared: false,
                group,
                again: true,
                state: false,
            });
        }
    }
    for &Kept { net, observed: bit, .. } in w.kept.iter().filter(|k| keeps[k.net.index()]) {
        let slot = w.layout.slot[net.index()].expect("what is kept has a place");
        if is_level[net.index()] || w.layout.leaves.contains(slot) {
            continue;
        }
        for (i, two) in (0..).zip(&l.nets[net.index()]) {
            let root = Root {
                node: two.v,
                plane: (slot + i).value(),
                observed: bit,
                guard: false,
                shared: true,
                group: None,
                again: false,
                state: false,
            };
            settling.push(root);
            settling.push(Root { node: two.u, plane: (slot + i).unknown(), ..root });
        }
    }
    for (next, stored) in l.next.iter().zip(&w.layout.stored) {
        debug_assert_eq!((next.cell, next.value.len()), (stored.cell, stored.sampled as usize));
        for (i, two) in (0..).zip(&next.value) {
            let root = Root {
                node: two.v,
                plane: (stored.stage + i).value(),
                observed: None,
                guard: false,
                shared: false,
                group: None,
                again: false,
                state: false,
            };
            sampled.push(root);
            sampled.push(Root { node: two.u, plane: (stored.stage + i).unknown(), ..root });
        }
    }
    (settling, sampled)
}
