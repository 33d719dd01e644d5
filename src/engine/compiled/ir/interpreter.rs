//! What every operation of a graph means, what a partition or an edge leaves in memory, and graphs made at random: what
//! tests of passes and of machine code are held against. It uses no pass and no code generator.

use super::graph::{Graph, Id, Op};
use super::places::{PlaneWord, Slot};
use super::schedule::{Partition, Schedule};
use super::stores::{Put, Store};
use crate::random;

/// How many seeds a test runs over, unless `DISCRETA_SEEDS` says otherwise.
pub(crate) fn seeds(usual: u64) -> u64 {
    std::env::var("DISCRETA_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(usual)
}

/// Numbers by chance.
pub(crate) struct Random(pub u64);

impl Random {
    pub fn word(&mut self) -> u64 {
        random::next(&mut self.0)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.word() % n as u64) as usize
    }

    /// One of some values.
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    /// A word of the kinds that matter: few bits, many, none, all, around a power of two.
    pub fn telling(&mut self) -> u64 {
        let n = self.word();
        match self.below(8) {
            0 => 0,
            1 => u64::MAX,
            2 => 1 << (n % 64),
            3 => (1 << (n % 64)) - 1,
            4 => (1u64 << (n % 64)).wrapping_neg(),
            5 => n & self.word() & self.word(),
            6 => n % 9,
            _ => n,
        }
    }
}

/// What an operation is, where `at` is what its operands are and memory holds these plane words.
///
/// # Panics
/// Where the operation has no meaning: whoever builds a graph sees to it that no divisor is 0, no variable shift is by 64
/// or more, what selects is 0 or 1, and elements are there.
pub(crate) fn evaluate(op: Op, memory: &[u64], at: impl Fn(Id) -> u64) -> u64 {
    let shift = |n: Id| {
        assert!(at(n) < 64, "a shift by {}", at(n));
        at(n)
    };
    match op {
        Op::Const(n) => n,
        Op::Load(word) => memory[word.index()],
        Op::And(a, b) => at(a) & at(b),
        Op::AndNot(a, b) => at(a) & !at(b),
        Op::Or(a, b) => at(a) | at(b),
        Op::Xor(a, b) => at(a) ^ at(b),
        Op::Add(a, b) => at(a).wrapping_add(at(b)),
        Op::Sub(a, b) => at(a).wrapping_sub(at(b)),
        Op::Mul(a, b) => at(a).wrapping_mul(at(b)),
        Op::MulHigh(a, b) => ((u128::from(at(a)) * u128::from(at(b))) >> 64) as u64,
        Op::MulHighSigned(a, b) => ((i128::from(at(a) as i64) * i128::from(at(b) as i64)) >> 64) as u64,
        Op::Shl(a, n) => at(a) << n,
        Op::Shr(a, n) => at(a) >> n,
        Op::ShlBy(a, n) => at(a) << shift(n),
        Op::ShrBy(a, n) => at(a) >> shift(n),
        Op::SarBy(a, n) => (at(a) as i64 >> shift(n)) as u64,
        Op::Eq(a, b) => u64::from(at(a) == at(b)),
        Op::Less(a, b) => u64::from(at(a) < at(b)),
        Op::Select(s, a, b) => match at(s) {
            0 => at(b),
            1 => at(a),
            s => panic!("a select by {s}"),
        },
        Op::Div(a, b) => at(a) / at(b),
        Op::Rem(a, b) => at(a) % at(b),
        Op::Count(a) => at(a).count_ones().into(),
        Op::Element { slot, index, size, plane } => {
            let (half, shift) = place(slot, at(index), size, plane);
            memory[half] >> shift & ones(size)
        }
    }
}

/// The plane word with an element, and at which bit it begins there: elements of less than 8 bytes lie side by side.
fn place(slot: Slot, index: u64, size: u8, plane: u8) -> (usize, u64) {
    let bytes = index << size;
    (slot.plane(plane).index() + 2 * (bytes / 8) as usize, bytes % 8 * 8)
}

/// All bits of an element of 2^`size` bytes.
fn ones(size: u8) -> u64 {
    u64::MAX >> (64 - (8u32 << size))
}

/// What every node is where memory holds these plane words. That no bit is 1 of which the graph says otherwise is
/// checked on the way.
pub(crate) fn values(g: &Graph, memory: &[u64]) -> Vec<u64> {
    let mut all: Vec<u64> = Vec::new();
    for n in g.ids() {
        let value = evaluate(g.op(n), memory, |id| all[id.index()]);
        assert_eq!(value & !g.possible_bits(n), 0, "{:?} has bits that it may not have", g.op(n));
        all.push(value);
    }
    all
}

/// What a partition leaves in memory, all of whose nodes are computed from what memory has before it. Whether anything that it
/// stores was taken to be 0 and is not; none, and memory as it was, if the partition is not to be run.
pub(crate) fn run(g: &Graph, partition: &Partition, memory: &mut [u64]) -> Option<bool> {
    let now = values(g, memory);
    let is = |node: Id| now[node.index()];
    if partition.bail_outs.iter().any(|&bail_out| is(bail_out) != 0) {
        return None;
    }
    let mut guard = false;
    for store in &partition.stores {
        memory[store.plane.index()] = is(store.node);
        guard |= store.guard && is(store.node) != 0;
    }
    for put in &partition.puts {
        for (plane, new) in [(0, put.v), (1, put.u)] {
            let (half, shift) = place(put.slot, is(put.index), put.size, plane);
            let mask = (is(put.mask) & ones(put.size)) << shift;
            memory[half] = memory[half] & !mask | is(new) << shift & mask;
        }
    }
    Some(guard)
}

/// Runs some partitions of a plan, in order: nodes of other partitions are what these have left in memory. For each of them, which
/// partitions are to run since what they read has changed is added to the list.
pub(crate) fn run_schedule(g: &Graph, schedule: &Schedule, due: &mut [bool], memory: &mut [u64]) {
    for number in 0..schedule.partitions.len() {
        if !std::mem::replace(&mut due[number], false) {
            continue;
        }
        let partition = &schedule.partitions[number];
        let mut now = vec![None; g.len()];
        let at = |now: &[Option<u64>], memory: &[u64], node: Id| match g.op(node) {
            op if op.is_leaf() => evaluate(op, memory, |_| unreachable!("a leaf has no operands")),
            _ => now[node.index()].unwrap_or_else(|| memory[schedule.place[&node].index()]),
        };
        for &node in &partition.nodes {
            now[node.index()] = Some(evaluate(g.op(node), memory, |o| at(&now, memory, o)));
        }
        let stores: Vec<u64> = partition.stores.iter().map(|s| at(&now, memory, s.node)).collect();
        for (store, new) in partition.stores.iter().zip(stores) {
            let old = std::mem::replace(&mut memory[store.plane.index()], new);
            assert!(store.compared || store.wakes.is_empty(), "only what is compared wakes anything");
            if old != new {
                store.wakes.iter().for_each(|&woken| due[woken as usize] = true);
            }
        }
    }
}

/// A graph made at random, and a program that it was made from: what nodes would be if nothing was folded.
pub(crate) struct Program {
    pub graph: Graph,
    /// Operations on each other's results, by their numbers, as nothing has simplified them.
    pub steps: Vec<Op>,
    /// The node that the graph has for each of them.
    pub nodes: Vec<Id>,
    /// The bits that may be 1 of each plane word that is loaded.
    pub masks: Vec<u64>,
}

/// Plane words of the arrays that programs read: as many bytes in each plane as the largest element number needs.
pub(crate) const ARRAY: u32 = 16;

impl Program {
    /// About `size` operations of all kinds, over plane words of all widths.
    pub fn random(r: &mut Random, size: usize) -> Program {
        let graph = if r.below(2) == 0 { Graph::default() } else { Graph::factoring() };
        let mut p = Program { graph, steps: Vec::new(), nodes: Vec::new(), masks: Vec::new() };
        let loads = 2 + r.below(8);
        for word in (0..loads as u32).map(PlaneWord::at) {
            // bits, fields, and whole words
            let mask = match r.below(4) {
                0 | 1 => 1,
                2 => u64::MAX >> r.below(64),
                _ => u64::MAX,
            };
            p.masks.push(mask);
            let node = p.graph.load(word, mask);
            p.add(Op::Load(word), node);
        }
        for n in [0, 1, u64::MAX, r.telling(), r.telling(), r.telling()] {
            p.constant(n);
        }
        while p.steps.len() < size {
            p.step(r);
        }
        p
    }

    /// The slot at which the array begins that programs read, behind what they load.
    pub fn array(&self) -> Slot {
        Slot::at(self.masks.len().div_ceil(2))
    }

    /// How many plane words a program reads.
    pub fn len(&self) -> usize {
        self.array().value().index() + ARRAY as usize
    }

    /// The same with one for a guard, and room up to a whole slot.
    pub fn room(&self) -> usize {
        self.len() + 2
    }

    fn add(&mut self, step: Op, node: Id) -> Id {
        self.steps.push(step);
        self.nodes.push(node);
        Id::at(self.steps.len() - 1)
    }

    fn constant(&mut self, n: u64) -> Id {
        let node = self.graph.constant(n);
        self.add(Op::Const(n), node)
    }

    /// Adds an operation on earlier steps.
    fn make(&mut self, step: Op) -> Id {
        let may = match step {
            Op::Element { size, .. } => ones(size),
            _ => u64::MAX,
        };
        let nodes = std::mem::take(&mut self.nodes);
        let node = self.graph.rebuild(step, may, |o| nodes[o.index()]);
        self.nodes = nodes;
        self.add(step, node)
    }

    /// A step of 0 or 1.
    fn condition(&mut self, r: &mut Random) -> Id {
        let (a, b) = (self.any(r), self.any(r));
        match r.below(6) {
            0 => self.make(Op::Less(a, b)),
            1 => self.make(Op::Eq(a, b)),
            2 => {
                let c = self.constant(r.below(4) as u64);
                self.make(Op::Eq(a, c))
            }
            // one that is there already, or its inverse
            _ => {
                let is = |s: &Program, n: Id| s.graph.possible_bits(s.nodes[n.index()]) <= 1;
                let bits: Vec<Id> = (0..self.steps.len()).map(Id::at).filter(|&n| is(self, n)).collect();
                let bit = bits[r.below(bits.len())];
                if r.below(3) == 0 {
                    let one = self.constant(1);
                    return self.make(Op::Xor(bit, one));
                }
                bit
            }
        }
    }

    fn any(&self, r: &mut Random) -> Id {
        // what was made last is taken more often, so that deep compositions arise
        let n = self.steps.len();
        let near = n.min(6);
        Id::at(if r.below(2) == 0 { n - 1 - r.below(near) } else { r.below(n) })
    }

    /// Adds an operation at random, with what it takes for it to have a meaning.
    fn step(&mut self, r: &mut Random) {
        let (a, b) = (self.any(r), self.any(r));
        match r.below(27) {
            0 => _ = self.constant(r.telling()),
            1 => {
                let word = PlaneWord::at(r.below(self.masks.len()) as u32);
                let node = self.graph.load(word, self.masks[word.index()]);
                self.add(Op::Load(word), node);
            }
            2 | 3 => _ = self.make(Op::And(a, b)),
            4 => _ = self.make(Op::AndNot(a, b)),
            5 | 6 => _ = self.make(Op::Or(a, b)),
            7 => _ = self.make(Op::Xor(a, b)),
            8 => _ = self.make(Op::Add(a, b)),
            9 => _ = self.make(Op::Sub(a, b)),
            10 => _ = self.make(Op::Mul(a, b)),
            11 => _ = self.make(Op::MulHigh(a, b)),
            12 => _ = self.make(Op::MulHighSigned(a, b)),
            13 => _ = self.make(Op::Shl(a, r.below(64) as u8)),
            14 => _ = self.make(Op::Shr(a, r.below(64) as u8)),
            15..=17 => {
                let n = match r.below(3) {
                    0 => self.constant(r.below(64) as u64),
                    _ => {
                        let most = self.constant(63);
                        self.make(Op::And(b, most))
                    }
                };
                let step = [Op::ShlBy(a, n), Op::ShrBy(a, n), Op::SarBy(a, n)][r.below(3)];
                self.make(step);
            }
            18 => _ = self.make(Op::Eq(a, b)),
            19 => _ = self.make(Op::Less(a, b)),
            20 | 21 => {
                let s = self.condition(r);
                self.make(Op::Select(s, a, b));
            }
            22 | 23 => {
                let divisor = match r.below(3) {
                    0 => {
                        let n = r.telling().max(1);
                        self.constant(n)
                    }
                    _ => {
                        let one = self.constant(1);
                        self.make(Op::Or(b, one))
                    }
                };
                let step = if r.below(2) == 0 { Op::Div(a, divisor) } else { Op::Rem(a, divisor) };
                self.make(step);
            }
            24 => _ = self.make(Op::Count(a)),
            25 => {
                let (size, plane) = (r.below(4) as u8, r.below(2) as u8);
                let last = self.constant(u64::from((ARRAY / 2 * 8) >> size) - 1);
                let index = self.make(Op::And(a, last));
                self.make(Op::Element { slot: self.array(), index, size, plane });
            }
            _ => _ = self.condition(r),
        }
    }

    /// A partition that makes new state of what the program loads: bits of state stay bits. It writes elements of all sizes into
    /// the array, may be not to be run, and may store what is taken to be 0.
    pub fn partition(&mut self, r: &mut Random) -> Partition {
        let mut partition = Partition::default();
        for (at, mask) in self.masks.clone().into_iter().enumerate() {
            if r.below(4) > 0 {
                let (node, mask) = (self.any(r), self.constant(mask));
                let node = self.make(Op::And(node, mask));
                partition.stores.push(Store::plain(self.nodes[node.index()], PlaneWord::at(at as u32)));
            }
        }
        for _ in 0..r.below(4) {
            let size = r.below(4) as u8;
            let last = self.constant(u64::from((ARRAY / 2 * 8) >> size) - 1);
            let (node, shown) = (self.any(r), self.condition(r));
            let index = self.make(Op::And(node, last));
            let (all, none) = (self.constant(ones(size)), self.constant(0));
            let (new, unknown) = (self.any(r), self.any(r));
            let list = [
                self.make(Op::Select(shown, all, none)),
                self.make(Op::And(new, all)),
                self.make(Op::And(unknown, all)),
            ];
            let [mask, v, u] = list.map(|n| self.nodes[n.index()]);
            partition.puts.push(Put { slot: self.array(), size, index: self.nodes[index.index()], mask, v, u });
        }
        // rarely 1, so that most edges are run
        let rare = |p: &mut Program, r: &mut Random| {
            let (a, b) = (p.condition(r), p.condition(r));
            let n = p.constant(r.telling());
            let (both, c) = (p.make(Op::And(a, b)), p.any(r));
            let same = p.make(Op::Eq(c, n));
            let all = p.make(Op::And(both, same));
            p.nodes[all.index()]
        };
        if r.below(2) == 0 {
            partition.bail_outs.push(rare(self, r));
        }
        if r.below(2) == 0 {
            let node = rare(self, r);
            partition.stores.push(Store { guard: true, ..Store::plain(node, PlaneWord::at(self.len() as u32)) });
        }
        let roots = partition.stores.iter().map(|s| s.node).chain(partition.puts.iter().flat_map(Put::nodes));
        partition.nodes = self.graph.needed(roots.chain(partition.bail_outs.iter().copied()));
        partition
    }

    /// Memory for it.
    pub fn memory(&self, r: &mut Random) -> Vec<u64> {
        let mut memory: Vec<u64> = (0..self.len()).map(|_| r.telling()).collect();
        memory.resize(self.room(), 0);
        memory.iter_mut().zip(&self.masks).for_each(|(word, mask)| *word &= mask);
        memory
    }

    /// What every step is, by nothing but the meaning of the operations.
    pub fn values(&self, memory: &[u64]) -> Vec<u64> {
        let mut all: Vec<u64> = Vec::new();
        for &step in &self.steps {
            let value = evaluate(step, memory, |o| all[o.index()]);
            all.push(value);
        }
        all
    }
}
