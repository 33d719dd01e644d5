//! Forms of a circuit in machine code: the four-valued one, and those for which some or all of the state is known.

use std::rc::Rc;

use crate::Field;
use crate::compiled::CompileError;
use crate::compiled::codegen::machine::{Circle, Machine};
use crate::compiled::codegen::trace;
use crate::compiled::codegen::{self, Shared, dirty_bit};
use crate::compiled::ir::graph::Map;
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::plan::{Plan, Root};
use crate::compiled::lower::layout::{Kept, StatePlaces, Wiring};
use crate::compiled::lower::{Level, Lowered, lower};
use crate::compiled::passes::cycle::Period;
use crate::compiled::passes::edge::{Source, Tick, fuse};
use crate::compiled::passes::partition::partition;
use crate::compiled::runtime::{WARM, WARM_NODES};
use crate::netlist::Netlist;

/// How many nodes go into a chunk.
pub(crate) const DEFAULT_CHUNK: usize = 160;
/// Pieces of a long tick are so many times as long.
pub(crate) const PIECE: usize = 10;

/// What is wanted of a netlist.
#[derive(Debug)]
pub(crate) struct Wanted<'w> {
    pub wiring: &'w Wiring,
    /// Nets whose values may have to be kept.
    pub kept: &'w [Kept],
    pub shared: Shared,
    /// Nodes in a chunk, at most.
    pub chunk: usize,
    /// How many shapes of records there are.
    pub shapes: usize,
}

/// The ticks of one input in machine code: to 1, to 0, and the two in a circle.
#[derive(Debug)]
pub(crate) struct Ticks {
    pub single: [Circle; 2],
    pub circle: Circle,
    /// The most that they write down, in words.
    pub longest: usize,
    /// The fields of their records, until they are given to the log.
    pub shapes: Vec<Box<[Field]>>,
    /// The two in one step on packed state, made when a run turns out to be long.
    pub period: Option<Option<Box<Period>>>,
    up: Tick,
    down: Tick,
}

impl Ticks {
    /// The period, if it can be made.
    pub fn period(&mut self, groups: &[Vec<(u8, PlaneWord)>], piece: usize, end: &mut u32) -> Option<&mut Period> {
        let Ticks { up, down, .. } = self;
        self.period.get_or_insert_with(|| Period::new(&[up, down], groups, piece, end).map(Box::new)).as_deref_mut()
    }
}

/// One form.
#[derive(Debug)]
pub(crate) struct Form {
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
    /// For each net whether it is kept.
    pub keeps: Vec<bool>,
    /// What ticks are made from, if it is small enough, and those that have been made; none where one cannot be.
    lowered: Option<Lowered>,
    ticks: Map<Slot, Option<Ticks>>,
    /// The loop that is stepped in each settling chunk, if one is.
    pub groups: Vec<Option<u32>>,
    /// How many waves have run in this form, and after how many ticks are made.
    pub waves: u64,
    pub warm: u64,
    /// Single bits of state that people see as words: lanes and value planes.
    pub buses: Rc<[Vec<(u8, PlaneWord)>]>,
}

/// Nodes up to which ticks are made in one piece.
const FUSED: usize = 400_000;

impl Form {
    /// Compiles a form in which `unknown` slots of state, or all, may hold x or z. `end` is how many slots of memory are
    /// taken, and is moved.
    pub fn new(
        netlist: &Netlist,
        w: &Wanted<'_>,
        unknown: Option<Vec<Slot>>,
        end: &mut u32,
    ) -> Result<Form, CompileError> {
        let may = |slot: Slot| unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok());
        let lowered = lower(netlist, &StatePlaces { wiring: w.wiring, unknown: &may });
        let graph = &lowered.graph;
        let doubtful = w.wiring.controls.iter().enumerate().filter(|(_, (bit, _))| {
            let word = lowered.nets[bit.net.index()][bit.lo as usize / 64];
            !graph.is(word.u, 0)
        });
        let doubtful: Vec<u32> = doubtful.map(|(i, _)| i as u32).collect();
        let mut keeps = vec![false; lowered.nets.len()];
        w.kept.iter().for_each(|k| keeps[k.net.index()] |= k.always);
        doubtful.iter().for_each(|&i| keeps[w.wiring.controls[i as usize].0.net.index()] = true);
        let (settling, sampled) = roots(&lowered, w, &may, &keeps);
        let mut spare: Option<PlaneWord> = None;
        let fresh = || {
            spare.take().unwrap_or_else(|| {
                let plane = Slot::at(*end as usize).value();
                *end += 1;
                spare = Some(plane + 1);
                plane
            })
        };
        let plan = partition(graph, &settling, &sampled, w.chunk, fresh);
        let dirty = Slot::at(*end as usize).value();
        let late = plan.chunks.len() - plan.settling;
        *end += (plan.settling.div_ceil(64) + late.div_ceil(64)) as u32 / 2 + 1;
        if *end > 1 << 26 {
            return Err(CompileError::TooLarge);
        }
        let machine = codegen::compile(graph, &plan, Shared { dirty, ..w.shared })?;
        let (mut wakes_start, mut wakes) = (vec![0], Vec::new());
        for slot in w.wiring.leaves.iter() {
            wakes.extend(woken(&plan, slot));
            wakes_start.push(wakes.len() as u32);
        }
        let memory_wakes = w.wiring.memories.iter().map(|m| woken(&plan, m.contents)).collect();
        let first_leaf = w.wiring.leaves.start;
        let constants = plan.constants.iter().map(|(root, n)| (root.plane, *n, root.observed)).collect();
        let fixed = plan.constants.iter().filter(|(root, _)| w.wiring.leaves.contains(root.plane.slot()));
        let fixed = fixed.map(|(root, n)| (root.plane, *n)).collect();
        let warm = WARM + (graph.len() / WARM_NODES) as u64;
        let small = unknown.is_some() && graph.len() <= FUSED;
        Ok(Form {
            machine,
            settling: plan.settling,
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
            ticks: Map::default(),
            groups: plan.chunks.iter().map(|c| c.group).collect(),
            waves: 0,
            warm,
            buses: buses(netlist, w.wiring).into(),
        })
    }

    /// The dirty words and bits that a change of a slot sets.
    #[inline(always)]
    pub fn wakes(&self, slot: Slot) -> &[(u32, u64)] {
        let at = (slot - self.first_leaf) as usize;
        &self.wakes[self.wakes_start[at] as usize..self.wakes_start[at + 1] as usize]
    }

    /// Whether a slot of state may be unknown in this form.
    pub fn allows(&self, slot: Slot) -> bool {
        self.unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok())
    }

    /// The ticks of an input, in machine code; made when they are first asked for.
    pub fn ticks(&mut self, netlist: &Netlist, w: &Wanted<'_>, input: Slot, end: &mut u32) -> Option<&mut Ticks> {
        if !self.ticks.contains_key(&input) {
            let made = self.make_ticks(netlist, w, input, end);
            self.ticks.insert(input, made);
        }
        self.ticks.get_mut(&input)?.as_mut()
    }

    fn make_ticks(&self, netlist: &Netlist, w: &Wanted<'_>, input: Slot, end: &mut u32) -> Option<Ticks> {
        let lowered = self.lowered.as_ref()?;
        let kept: Vec<Kept> = w.kept.iter().copied().filter(|k| self.keeps[k.net.index()]).collect();
        let allows = |slot: Slot| self.allows(slot);
        let tick =
            |level| fuse(&Source { netlist, lowered, wiring: w.wiring, kept: &kept, allows: &allows, input, level });
        let (mut up, mut down) = (tick(true)?, tick(false)?);
        let mut shapes = Vec::new();
        for tick in [&mut up, &mut down] {
            tick.record.shape = w.shapes + shapes.len();
            shapes.push(tick.record.fields());
        }
        let longest = up.record.longest() + down.record.longest();
        if longest > trace::ROOM {
            return None;
        }
        let first = *end;
        let mut make = |ticks: &[&Tick]| {
            // what pieces leave each other lies at the same place in all: only one of them runs
            let mut next = 2 * first;
            let fresh = || {
                next += 1;
                PlaneWord::at(next - 1)
            };
            let made = codegen::compile_circle(ticks, w.chunk * PIECE, w.shared, fresh).ok();
            *end = (*end).max(next.div_ceil(2));
            made
        };
        let (single, circle) = ([make(&[&down])?, make(&[&up])?], make(&[&up, &down])?);
        Some(Ticks { single, circle, longest, shapes, period: None, up, down })
    }

    /// Does without the ticks of an input.
    pub fn forget_ticks(&mut self, input: Slot) {
        self.ticks.insert(input, None);
    }
}

/// Single bits of state that have names as bits of a word, each bit once.
fn buses(netlist: &Netlist, wiring: &Wiring) -> Vec<Vec<(u8, PlaneWord)>> {
    let mut all: Vec<Vec<(u8, PlaneWord)>> = Vec::new();
    for signal in netlist.signal_ids().filter(|&s| netlist.signal(s).width > 1) {
        let (mut lane, mut bits) = (0u32, Vec::new());
        for slice in netlist.bits(signal) {
            let slot = wiring.slot[slice.net.index()].filter(|slot| wiring.leaves.contains(*slot));
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
fn woken(plan: &Plan, slot: Slot) -> Vec<(u32, u64)> {
    let mut wakes: Vec<(u32, u64)> = Vec::new();
    for &chunk in plan.readers.get(&slot).map_or(&[][..], Vec::as_slice) {
        let (word, bit) = dirty_bit(plan.settling, chunk);
        match wakes.iter_mut().find(|l| l.0 == word) {
            Some(found) => found.1 |= bit,
            None => wakes.push((word, bit)),
        }
    }
    wakes
}

/// What is wanted in memory once settled, and before an edge.
fn roots(l: &Lowered, w: &Wanted<'_>, may: &dyn Fn(Slot) -> bool, keeps: &[bool]) -> (Vec<Root>, Vec<Root>) {
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
                alarm: false,
                shared: false,
                group: *group,
                again: false,
                state: true,
            };
            settling.push(root);
            settling.push(Root { node: two.u, plane: slot.unknown(), alarm: !may(slot), ..root });
        }
        if let Some(group) = group.filter(|_| l.levels.get(number + 1).is_none_or(|next| next.group != *group)) {
            let (node, plane) = (l.unsettled[group as usize], w.wiring.unsettled[group as usize].value());
            let (observed, group) = (None, Some(group));
            settling.push(Root {
                node,
                plane,
                observed,
                alarm: false,
                shared: false,
                group,
                again: true,
                state: false,
            });
        }
    }
    for &Kept { net, observed: bit, .. } in w.kept.iter().filter(|k| keeps[k.net.index()]) {
        let slot = w.wiring.slot[net.index()].expect("what is kept has a place");
        if is_level[net.index()] || w.wiring.leaves.contains(slot) {
            continue;
        }
        for (i, two) in (0..).zip(&l.nets[net.index()]) {
            let root = Root {
                node: two.v,
                plane: (slot + i).value(),
                observed: bit,
                alarm: false,
                shared: true,
                group: None,
                again: false,
                state: false,
            };
            settling.push(root);
            settling.push(Root { node: two.u, plane: (slot + i).unknown(), ..root });
        }
    }
    for (next, stored) in l.next.iter().zip(&w.wiring.stored) {
        debug_assert_eq!((next.cell, next.value.len()), (stored.cell, stored.sampled as usize));
        for (i, two) in (0..).zip(&next.value) {
            let root = Root {
                node: two.v,
                plane: (stored.stage + i).value(),
                observed: None,
                alarm: false,
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
