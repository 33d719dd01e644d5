//! A whole period of a clock on packed state: the two ticks of a circle as one step, with the state in words of its own
//! while it goes round.
//!
//! It is left before the period in which an observed net would change or state would become what the form does not allow:
//! the ticks do that one.

use super::changes::Record;
use super::codegen::{self, Shared};
use super::fuse::Tick;
use super::graph::{Graph, Id, Map, Op};
use super::machine::Circle;
use super::pack::{LEAST, Packed, Place, Step, pack};
use super::plan::{Chunk, Half, Store};
use crate::value::Word;

/// A period in machine code.
#[derive(Debug)]
pub(super) struct Period {
    circle: Circle,
    places: Vec<Place>,
    /// The places that change.
    changing: Vec<u32>,
    memory: Vec<Word>,
    /// Periods to sit out after it was left at once, and how many of these are to come.
    patience: u32,
    waiting: u32,
}

/// Periods up to which going in and out costs more than it gains.
pub(super) const SHORT: u64 = 32;

impl Period {
    /// Makes a period of its ticks. `groups` are the lanes that single bits of state get.
    pub fn new(ticks: &[&Tick], groups: &[Vec<(u8, Half)>]) -> Option<Period> {
        // memories lie elsewhere
        let is_element = |t: &Tick| t.chunk.nodes.iter().any(|&n| matches!(t.graph.op(n), Op::Element { .. }));
        if ticks.iter().any(|t| !t.chunk.puts.is_empty() || is_element(t)) {
            return None;
        }
        let mut step = compose(ticks);
        let plain = step.cost();
        let Packed { step, places, .. } = pack(&mut step, groups, LEAST)?;
        // what does not lie in words is better left as it is
        if step.cost() >= plain {
            return None;
        }
        let nodes = step.needed();
        let changing = step.stores.iter().map(|s| s.0).collect();
        let store = |&(half, node): &(Half, Id)| Store {
            node,
            half,
            observed: None,
            alarm: false,
            compared: false,
            wakes: Vec::new(),
            again: false,
        };
        let stores = step.stores.iter().map(store).collect();
        let record = Record::new(Vec::new(), &[], 0, false);
        let chunk = Chunk { nodes, stores, group: None, aborts: step.aborts, puts: Vec::new() };
        let tick = Tick { chunk, graph: step.graph, record };
        let mut end = places.len() as Half;
        let fresh = || {
            end += 1;
            end - 1
        };
        let circle =
            codegen::compile_circle(&[&tick], Shared { alarm: 0, changed: 0, dirty: 0, log: 0 }, fresh).ok()?;
        let memory = vec![Word::ZERO; end as usize / 2 + 1];
        Some(Period { circle, places, changing, memory, patience: 1, waiting: 0 })
    }

    /// Goes round up to `rounds` times; how many times it did.
    pub fn run(&mut self, memory: &mut [Word], rounds: u64) -> u64 {
        if self.waiting > 0 {
            self.waiting = self.waiting.saturating_sub(1);
            return 0;
        }
        for (at, place) in (0..).zip(&self.places) {
            *half(&mut self.memory, at) = match place {
                Place::Half(h) => *half(memory, *h),
                Place::Lanes(lanes) => lanes.iter().fold(0, |all, &(lane, h)| all | (*half(memory, h) & 1) << lane),
            };
        }
        let done = self.circle.run(&mut self.memory, rounds);
        for &at in &self.changing {
            let value = *half(&mut self.memory, at);
            match &self.places[at as usize] {
                Place::Half(h) => *half(memory, *h) = value,
                Place::Lanes(lanes) => {
                    lanes.iter().for_each(|&(lane, h)| *half(memory, h) = value >> lane & 1);
                }
            }
        }
        if done < SHORT {
            self.patience = (self.patience * 2).min(1 << 12);
            self.waiting = self.patience;
        } else {
            self.patience = 1;
        }
        done
    }
}

/// Ticks one after another as one step of what they read and leave.
fn compose(ticks: &[&Tick]) -> Step {
    let mut out = Graph::factoring();
    let mut now: Map<Half, Id> = Map::default();
    let mut order: Vec<Half> = Vec::new();
    let mut aborts: Vec<Id> = Vec::new();
    for tick in ticks {
        let g = &tick.graph;
        let mut map: Map<Id, Id> = Map::default();
        let at = |out: &mut Graph, node: Id, map: &Map<Id, Id>| match g.op(node) {
            Op::Const(n) => out.constant(n),
            Op::Load(half) => match now.get(&half) {
                Some(&node) => node,
                None => out.load(half, g.may(node)),
            },
            _ => map[&node],
        };
        for &node in &tick.chunk.nodes {
            let operands: Vec<(Id, Id)> = g.op(node).operands().map(|o| (o, at(&mut out, o, &map))).collect();
            let made = out
                .rebuild(g.op(node), g.may(node), |o| operands.iter().find(|p| p.0 == o).expect("it is an operand").1);
            map.insert(node, made);
        }
        let mut abort = |out: &Graph, node: Id| {
            if !out.is(node, 0) && !aborts.contains(&node) {
                aborts.push(node);
            }
        };
        for &node in &tick.chunk.aborts {
            let node = at(&mut out, node, &map);
            abort(&out, node);
        }
        for store in tick.chunk.stores.iter().filter(|s| s.alarm) {
            let node = at(&mut out, store.node, &map);
            abort(&out, node);
        }
        let mut made = Vec::new();
        for store in tick.chunk.stores.iter().filter(|s| !s.alarm) {
            made.push((store.half, at(&mut out, store.node, &map), store.compared));
        }
        let mut compared = Vec::new();
        for (half, node, observed) in made {
            if observed {
                let old = match now.get(&half) {
                    Some(&node) => node,
                    None => out.load(half, u64::MAX),
                };
                compared.push((half, old, node));
            }
            if now.insert(half, node).is_none() {
                order.push(half);
            }
        }
        for (_, old, node) in compared {
            let differs = out.xor(old, node);
            if !out.is(differs, 0) && !aborts.contains(&differs) {
                aborts.push(differs);
            }
        }
    }
    let stores = order.into_iter().map(|half| (half, now[&half]));
    let stores = stores.filter(|&(half, node)| out.op(node) != Op::Load(half)).collect();
    Step { graph: out, stores, aborts }
}

fn half(memory: &mut [Word], half: Half) -> &mut u64 {
    let word = &mut memory[half as usize / 2];
    if half.is_multiple_of(2) { &mut word.v } else { &mut word.u }
}
