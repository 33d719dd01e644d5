//! Carry chains among the gates of a graph: runs of stages in which a bit goes from one to the next as a carry does.
//!
//! Sound: where `next = make | kill & carry` and `make` implies `kill`, the carries of a run are those of `kill + make`, whatever
//! the gates are: for a full adder `kill` is `a | b` and `make` is `a & b`, for a counter `make` is 0, for a comparison one
//! operand is inverted. A stage is found by going down from a bit through gates that do not invert it, so that `make` (the
//! carry taken as 0) implies `kill` (taken as 1) by construction.

use std::hash::{Hash, Hasher};

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;

/// Gates that a carry passes in a stage.
const DEPTH: u32 = 3;
/// Stages up to which a chain stays gates.
const FEW: u32 = 3;
/// Stages that fit a word with the carry.
const MOST: usize = 60;

/// A chain.
#[derive(Debug)]
pub(crate) struct Chain {
    /// The carry into the first stage.
    pub base: Id,
    /// For each stage what it makes of a carry of 1, what of a carry of 0, and of the one that it gets.
    pub stages: Vec<Stage>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    pub kill: Id,
    pub make: Id,
    pub out: Id,
    /// The bit of the sum, or its inverse.
    pub sum: Id,
    pub inverted: bool,
}

impl Chain {
    /// Whether it is but an AND or an OR of many bits, of which hardly anything is used before the last: a comparison does
    /// better than an addition. `uses` counts how often each node is used.
    pub fn is_tree(&self, g: &Graph, uses: &[u32]) -> bool {
        let plain = |s: &Stage| uses[s.sum.index()] == 0 || g.op(s.sum).is_leaf();
        let (last, before) = self.stages.split_last().expect("a chain has stages");
        let other = before.iter().filter(|s| !plain(s) || uses[s.out.index()] > 1).count();
        let all = |is: &dyn Fn(&Stage) -> bool| self.stages.iter().all(is);
        plain(last) && 4 * other < before.len() && (all(&|s| g.is(s.make, 0)) || all(&|s| g.is(s.kill, 1)))
    }
}

impl Stage {
    fn new(g: &mut Graph, kill: Id, make: Id, carry: Id, out: Id) -> Stage {
        let apart = g.xor(kill, make);
        let sum = g.xor(apart, carry);
        match g.op(sum) {
            Op::Xor(x, c) if g.is(c, 1) => Stage { kill, make, out, sum: x, inverted: true },
            _ => Stage { kill, make, out, sum, inverted: false },
        }
    }
}

/// What a node looks like from above: the operations down to some depth, whatever they read.
pub(crate) fn looks(g: &Graph, depth: u32) -> Vec<u32> {
    let mut now: Vec<u32> = g.ids().map(|n| kind(g, n)).collect();
    for _ in 0..depth {
        let next = g.ids().map(|n| {
            let op = g.op(n);
            if kind(g, n) <= 1 {
                return now[n.index()];
            }
            let mut operands: Vec<u32> = op.operands().map(|o| now[o.index()]).collect();
            if matches!(op, Op::And(..) | Op::Or(..) | Op::Xor(..) | Op::Add(..)) {
                operands.sort_unstable();
            }
            digest(&(kind(g, n), operands))
        });
        now = next.collect();
    }
    now
}

fn digest(what: &impl Hash) -> u32 {
    let mut hash = rustc_hash::FxHasher::default();
    what.hash(&mut hash);
    (hash.finish() >> 32) as u32 | 2
}

/// 0 for a bit of state or of a word, 1 for a constant 0, else the operation.
fn kind(g: &Graph, n: Id) -> u32 {
    match g.op(n) {
        Op::Load(_) => 0,
        _ if bit_of(g, n).is_some() => 0,
        Op::Const(0) => 1,
        Op::Const(n) => digest(&n),
        op => digest(&std::mem::discriminant(&op)),
    }
}

/// The word and the bit of it that a node is.
pub(crate) fn bit_of(g: &Graph, n: Id) -> Option<(Id, u8)> {
    if g.possible_bits(n) != 1 {
        return None;
    }
    match g.op(n) {
        Op::And(x, one) if g.is(one, 1) => match g.op(x) {
            Op::Shr(y, k) => Some((y, k)),
            _ => Some((x, 0)),
        },
        Op::Shr(y, k) => Some((y, k)),
        _ => None,
    }
}

/// The lane of a bit, or of the first bit below a node; the last if there is none.
pub(crate) fn lane_of(g: &Graph, lanes: &Map<PlaneWord, u8>, n: Id, depth: u32) -> u8 {
    match g.op(n) {
        Op::Load(plane) => lanes.get(&plane).copied().unwrap_or(u8::MAX),
        Op::Const(_) => u8::MAX,
        op => match bit_of(g, n) {
            Some((_, lane)) => lane,
            None if depth > 0 => op.operands().map(|o| lane_of(g, lanes, o, depth - 1)).min().unwrap_or(u8::MAX),
            None => u8::MAX,
        },
    }
}

/// Ways down from a node: where they lead, what the gates on them look like.
fn ways(g: &Graph, looks: &[u32], n: Id, depth: u32, so_far: u32, out: &mut Vec<(Id, u32)>) {
    if g.possible_bits(n) != 1 || depth == 0 {
        return;
    }
    let of = |o: Id| looks[o.index()];
    let mut step = |to: Id, what: (u8, u32, u32)| {
        let now = digest(&(so_far, what));
        out.push((to, now));
        ways(g, looks, to, depth - 1, now, out);
    };
    match g.op(n) {
        Op::And(x, y) => [(x, y), (y, x)].into_iter().for_each(|(to, by)| step(to, (0, of(by), 0))),
        Op::Or(x, y) => [(x, y), (y, x)].into_iter().for_each(|(to, by)| step(to, (1, of(by), 0))),
        Op::AndNot(x, y) => step(x, (2, of(y), 0)),
        Op::Select(s, x, y) => {
            step(x, (3, of(s), of(y)));
            step(y, (4, of(s), of(x)));
        }
        _ => {}
    }
}

/// A node with a bit below it taken as 0 and as 1; none where it is not there or is inverted.
fn taken(g: &mut Graph, n: Id, bit: Id, depth: u32, way: &mut Vec<Id>) -> Option<[Id; 2]> {
    if n == bit {
        return Some([g.constant(0), g.constant(1)]);
    }
    if depth == 0 || g.possible_bits(n) != 1 {
        return None;
    }
    let op = g.op(n);
    type Join = fn(&mut Graph, Id, Id) -> Id;
    let (a, b, join): (Id, Id, Join) = match op {
        Op::And(a, b) => (a, b, Graph::and),
        Op::Or(a, b) => (a, b, Graph::or),
        Op::AndNot(a, b) => {
            let x = taken(g, a, bit, depth - 1, way)?;
            way.push(n);
            return Some(x.map(|x| g.and_not(x, b)));
        }
        Op::Select(s, a, b) => {
            let (x, y) = (taken(g, a, bit, depth - 1, way), taken(g, b, bit, depth - 1, way));
            if x.is_none() && y.is_none() {
                return None;
            }
            way.push(n);
            let (x, y) = (x.unwrap_or([a; 2]), y.unwrap_or([b; 2]));
            return Some([0, 1].map(|i| g.select(s, x[i], y[i])));
        }
        _ => return None,
    };
    let (x, y) = (taken(g, a, bit, depth - 1, way), taken(g, b, bit, depth - 1, way));
    if x.is_none() && y.is_none() {
        return None;
    }
    way.push(n);
    let (x, y) = (x.unwrap_or([a; 2]), y.unwrap_or([b; 2]));
    Some([0, 1].map(|i| join(g, x[i], y[i])))
}

/// The chains of a graph, no two of which have a carry in common. Adds to the graph what the stages make.
pub(crate) fn find(g: &mut Graph, lanes: &Map<PlaneWord, u8>) -> Vec<Chain> {
    let lane = |g: &Graph, n: Id| lane_of(g, lanes, n, 0);
    let shapes = looks(g, 1);
    // for each node and way how far it goes on like that, and where it leads
    let mut runs: Map<(Id, u32), (u32, Id)> = Map::default();
    let mut found = Vec::new();
    for n in g.ids() {
        found.clear();
        ways(g, &shapes, n, DEPTH, 0, &mut found);
        for &(to, way) in found.iter().filter(|f| g.possible_bits(f.0) == 1) {
            let goes_on = runs.get(&(to, way)).map_or(0, |r| r.0);
            let run = runs.entry((n, way)).or_insert((0, to));
            if goes_on + 1 > run.0 || goes_on + 1 == run.0 && lane(g, to) < lane(g, run.1) {
                *run = (goes_on + 1, to);
            }
        }
    }
    let mut ends: Vec<(u32, Id, u32)> =
        runs.iter().filter(|(_, run)| run.0 >= FEW).map(|(&(n, way), run)| (run.0, n, way)).collect();
    ends.sort_unstable_by_key(|&(length, n, way)| (std::cmp::Reverse(length), n, way));
    let mut is_carry: Map<Id, ()> = Map::default();
    let mut chains = Vec::new();
    for (_, end, way) in ends {
        let (mut at, mut list) = (end, Vec::new());
        while let Some(&(_, to)) = runs.get(&(at, way)) {
            if is_carry.contains_key(&at) || list.len() == MOST {
                break;
            }
            list.push((to, at));
            at = to;
        }
        if list.len() < FEW as usize {
            continue;
        }
        list.reverse();
        let (mut stages, mut passed) = (Vec::new(), Vec::new());
        for &(from, out) in &list {
            let Some([make, kill]) = taken(g, out, from, DEPTH + 1, &mut passed) else { break };
            debug_assert!(
                (g.possible_bits(kill) | g.possible_bits(make)) & !1 == 0,
                "{:?} {:?} of {:?}",
                g.op(kill),
                g.op(make),
                g.op(out)
            );
            stages.push(Stage::new(g, kill, make, from, out));
        }
        if stages.len() < list.len() {
            continue;
        }
        passed.into_iter().for_each(|n| _ = is_carry.insert(n, ()));
        let mut chain = Chain { base: list[0].0, stages };
        widen(g, &mut chain);
        chains.push(chain);
    }
    chains
}

/// Takes a base that is the carry of a stage without one into the chain.
fn widen(g: &mut Graph, chain: &mut Chain) {
    let base = chain.base;
    let stages = &chain.stages;
    let (zero, one) = (g.constant(0), g.constant(1));
    let (kill, make, base) = match g.op(base) {
        _ if g.value(base).is_some() => return,
        // a counter's lowest bit
        _ if stages.iter().all(|s| g.is(s.make, 0)) => (base, zero, one),
        _ if stages.iter().all(|s| g.is(s.kill, 1)) => (one, base, zero),
        // a plane word adder
        Op::And(x, y) | Op::AndNot(x, y) if g.possible_bits(x) | g.possible_bits(y) != 1 => return,
        Op::And(x, y) if matches!(g.op(stages[0].make), Op::And(..)) => (g.or(x, y), base, zero),
        Op::AndNot(x, y) if matches!(g.op(stages[0].make), Op::AndNot(..)) => {
            let n = g.not(y, 1);
            (g.or(x, n), base, zero)
        }
        _ => return,
    };
    chain.stages.insert(0, Stage::new(g, kill, make, base, chain.base));
    chain.base = base;
}
