//! Forms of a circuit in machine code: the four-valued one, and those for which some or all of the state is known.

use super::codegen::{self, Shared, dirty_bit};
use super::lower::{Lowered, lower};
use super::machine::Machine;
use super::plan::{Half, Root, plan};
use super::wiring::{StatePlaces, Wiring};
use crate::netlist::{NetId, Netlist};

/// How many nodes go into a chunk.
const CHUNK: usize = 160;

/// What is wanted of a netlist.
#[derive(Debug)]
pub(super) struct Wanted<'w> {
    pub wiring: &'w Wiring,
    /// Nets whose values are kept, and the bits by which changes of those that are observed are told.
    pub kept: &'w [(NetId, Option<u32>)],
    pub shared: Shared,
    /// Nodes in a chunk, at most.
    pub chunk: usize,
}

/// One form.
#[derive(Debug)]
pub(super) struct Form {
    pub machine: Machine,
    pub settling: usize,
    /// Where its dirty bits begin.
    pub dirty: Half,
    /// For each slot of state where in `wakes` the dirty words and bits begin that a change sets.
    wakes_start: Vec<u32>,
    wakes: Vec<(u32, u64)>,
    first_leaf: u32,
    /// What is constant: where it belongs, its value, the bit that tells of a change.
    pub constants: Vec<(Half, u64, Option<u32>)>,
    /// Slots of state that may be unknown; none if that is all.
    pub unknown: Option<Vec<u32>>,
    /// Numbers of the control bits that may be unknown.
    pub doubtful: Vec<u32>,
    /// Nodes of the graph, for reports.
    pub nodes: usize,
}

impl Form {
    /// Compiles a form in which `unknown` slots of state, or all, may hold x or z. `end` is how many slots of memory are
    /// taken, and is moved.
    pub fn new(netlist: &Netlist, w: &Wanted<'_>, unknown: Option<Vec<u32>>, end: &mut u32) -> Result<Form, String> {
        let may = |slot: u32| unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok());
        let lowered = lower(netlist, &StatePlaces { wiring: w.wiring, unknown: &may });
        let graph = &lowered.graph;
        let (settling, sampled) = roots(&lowered, w, &may);
        let doubtful = w.wiring.controls.iter().enumerate().filter(|(_, (bit, _))| {
            let word = lowered.nets[bit.net.index()][bit.lo as usize / 64];
            !graph.is(word.u, 0)
        });
        let doubtful = doubtful.map(|(i, _)| i as u32).collect();
        let mut spare: Option<Half> = None;
        let fresh = || {
            spare.take().unwrap_or_else(|| {
                let half = *end * 2;
                *end += 1;
                spare = Some(half + 1);
                half
            })
        };
        let plan = plan(graph, &settling, &sampled, w.chunk, fresh);
        let dirty = *end * 2;
        let late = plan.chunks.len() - plan.settling;
        *end += (plan.settling.div_ceil(64) + late.div_ceil(64)) as u32 / 2 + 1;
        if *end > 1 << 26 {
            return Err("it is too large".into());
        }
        let machine = codegen::compile(graph, &plan, Shared { dirty, ..w.shared })?;
        let (mut wakes_start, mut wakes) = (vec![0], Vec::new());
        for slot in w.wiring.leaves.clone() {
            let first = wakes.len();
            for &chunk in plan.readers.get(&slot).map_or(&[][..], Vec::as_slice) {
                let (word, bit) = dirty_bit(plan.settling, chunk);
                match wakes[first..].iter_mut().find(|l: &&mut (u32, u64)| l.0 == word) {
                    Some(found) => found.1 |= bit,
                    None => wakes.push((word, bit)),
                }
            }
            wakes_start.push(wakes.len() as u32);
        }
        let first_leaf = w.wiring.leaves.start;
        let constants = plan.constants.iter().map(|(root, n)| (root.half, *n, root.observed)).collect();
        let nodes = plan.chunks.iter().map(|c| c.nodes.len()).sum();
        Ok(Form {
            machine,
            settling: plan.settling,
            dirty,
            wakes_start,
            wakes,
            first_leaf,
            constants,
            unknown,
            doubtful,
            nodes,
        })
    }

    /// The dirty words and bits that a change of a slot sets.
    #[inline(always)]
    pub fn wakes(&self, slot: u32) -> &[(u32, u64)] {
        let at = (slot - self.first_leaf) as usize;
        &self.wakes[self.wakes_start[at] as usize..self.wakes_start[at + 1] as usize]
    }

    /// Whether a slot of state may be unknown in this form.
    pub fn allows(&self, slot: u32) -> bool {
        self.unknown.as_ref().is_none_or(|list| list.binary_search(&slot).is_ok())
    }

    /// Whether all of the state may be unknown.
    pub fn is_general(&self) -> bool {
        self.unknown.is_none()
    }
}

pub(super) const DEFAULT_CHUNK: usize = CHUNK;

/// What is wanted in memory once settled, and before an edge.
fn roots(l: &Lowered, w: &Wanted<'_>, may: &dyn Fn(u32) -> bool) -> (Vec<Root>, Vec<Root>) {
    let (mut settling, mut sampled) = (Vec::new(), Vec::new());
    let mut observed = vec![None; l.nets.len()];
    for &(net, bit) in w.kept {
        observed[net.index()] = bit;
    }
    let mut is_level = vec![false; l.nets.len()];
    for (net, value) in &l.levels {
        is_level[net.index()] = true;
        let slot = w.wiring.slot[net.index()].expect("state has a place");
        for (i, two) in (0..).zip(value) {
            let (slot, observed) = (slot + i, observed[net.index()]);
            let root = Root { node: two.v, half: 2 * slot, observed, alarm: false, shared: false };
            settling.push(root);
            settling.push(Root { node: two.u, half: 2 * slot + 1, alarm: !may(slot), ..root });
        }
    }
    for &(net, bit) in w.kept {
        let slot = w.wiring.slot[net.index()].expect("what is kept has a place");
        if is_level[net.index()] || w.wiring.leaves.contains(&slot) {
            continue;
        }
        for (i, two) in (0..).zip(&l.nets[net.index()]) {
            let root = Root { node: two.v, half: 2 * (slot + i), observed: bit, alarm: false, shared: true };
            settling.push(root);
            settling.push(Root { node: two.u, half: 2 * (slot + i) + 1, ..root });
        }
    }
    for (next, stored) in l.next.iter().zip(&w.wiring.stored) {
        debug_assert_eq!((next.cell, next.value.len()), (stored.cell, stored.words as usize));
        for (i, two) in (0..).zip(&next.value) {
            let root = Root { node: two.v, half: 2 * (stored.stage + i), observed: None, alarm: false, shared: false };
            sampled.push(root);
            sampled.push(Root { node: two.u, half: 2 * (stored.stage + i) + 1, ..root });
        }
    }
    (settling, sampled)
}
