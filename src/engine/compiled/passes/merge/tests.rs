use super::*;
use crate::compiled::codegen::{self, Shared};
use crate::compiled::ir::graph::Graph;
use crate::compiled::ir::interpreter::{Random, run};
use crate::compiled::ir::record::Record;
use crate::compiled::passes::edge::EdgeCode;
use crate::compiled::passes::outline::outline;
use crate::value::Word;

/// Halves of state of each part, where they begin, and how far it is from one part to the next.
const STATE: u32 = 14;
const FIRST: u32 = 20;
const STRIDE: u32 = 17;
/// The elements of each part's memory, its first slot and how many slots it is to the next.
const ELEMENTS: u64 = 16;
const CONTENTS: u32 = 200;
const NEXT: u32 = 23;
/// Halves that all parts read, and those of the guard.
const COMMON: std::ops::Range<u32> = 2..8;
const PARTS: usize = 6;

/// How a part of random logic is made: the same choices again for each, but for some constants.
struct Recipe {
    seed: u64,
    nodes: usize,
    /// One in how many constants is different in each part.
    varied: usize,
    puts: bool,
    bail_outs: bool,
    /// Whether the parts read a plane word of each other.
    neighbours: bool,
}

/// Part `number` of an edge. One that is `odd` has a node that the others do not have.
fn part(recipe: &Recipe, number: usize, odd: bool, edge: &mut EdgeCode) {
    let EdgeCode { graph: g, partition, .. } = edge;
    let (mut r, mut other) = (Random(recipe.seed), Random(recipe.seed ^ (number as u64 + 1) << 32));
    let at = |number: usize| PlaneWord::at(FIRST + number as u32 * STRIDE);
    let slot = Slot::at((CONTENTS + number as u32 * NEXT) as usize);
    let mut nodes: Vec<Id> = (0..STATE).map(|i| g.load(at(number) + i, u64::MAX)).collect();
    nodes.extend(COMMON.map(|word| g.load(PlaneWord::at(word), u64::MAX)));
    if recipe.neighbours {
        nodes.push(g.load(at((number + 1) % PARTS), u64::MAX));
    }
    let index = |g: &mut Graph, node: Id| {
        let mask = g.constant(ELEMENTS - 1);
        g.and(node, mask)
    };
    for _ in 0..recipe.nodes {
        let mut pick = || nodes[r.below(nodes.len())];
        let (a, b, c) = (pick(), pick(), pick());
        let (kind, bits) = (r.below(12), 1 + r.below(62) as u32);
        let (same, own) = (r.word() | 1, other.word() | 1);
        let constant = if r.below(recipe.varied) == 0 { own } else { same };
        let made = match kind {
            0 => g.and(a, b),
            1 => g.or(a, b),
            2 => g.xor(a, b),
            3 => g.add(a, b),
            4 => g.sub(a, b),
            5 => g.mul(a, b),
            6 => g.shl(a, bits),
            7 => g.shr(a, bits),
            8 => {
                let when = g.less(a, b);
                g.select(when, b, c)
            }
            9 if recipe.puts => {
                let index = index(g, a);
                g.element(slot, index, 3, 0, u64::MAX)
            }
            _ => {
                let constant = g.constant(constant);
                if kind == 10 { g.add(a, constant) } else { g.xor(a, constant) }
            }
        };
        nodes.push(made);
    }
    if odd {
        let last = *nodes.last().expect("there are some");
        nodes.push(g.mul(last, last));
    }
    let logic = &nodes[nodes.len() - recipe.nodes / 2..];
    partition.stores.extend((0..STATE).map(|i| Store::plain(logic[r.below(logic.len())], at(number) + i)));
    let rare = |r: &mut Random, g: &mut Graph| {
        let (node, n) = (logic[r.below(logic.len())], g.constant(0x7f));
        let low = g.and(node, n);
        g.eq(low, n)
    };
    let guard = rare(&mut r, g);
    partition.stores.push(Store { guard: true, ..Store::plain(guard, at(number) + STATE) });
    if recipe.puts {
        let index = index(g, logic[r.below(logic.len())]);
        let mut pick = || logic[r.below(logic.len())];
        partition.puts.push(Put { slot, size: 3, index, mask: pick(), v: pick(), u: pick() });
    }
    if recipe.bail_outs {
        partition.bail_outs.push(rare(&mut r, g));
    }
}

fn edge(recipe: &Recipe, odd: usize) -> EdgeCode {
    let mut edge = EdgeCode { graph: Graph::default(), partition: Partition::default(), record: Record::default() };
    (0..PARTS).for_each(|number| part(recipe, number, number == odd, &mut edge));
    let roots = edge.partition.stores.iter().map(|s| s.node).chain(edge.partition.puts.iter().flat_map(Put::nodes));
    edge.partition.nodes = edge.graph.needed(roots.chain(edge.partition.bail_outs.iter().copied()));
    edge
}

/// What an edge leaves in memory, and whether it may be followed by another; none if it is left.
fn made(edge: &EdgeCode, memory: &mut [u64]) -> Option<bool> {
    let guards: Vec<PlaneWord> = edge.partition.stores.iter().filter(|s| s.guard).map(|s| s.plane).collect();
    let guard = run(&edge.graph, &edge.partition, memory)?;
    // the code leaves all of them joined there
    memory[0] |= guards.iter().fold(0, |all, &plane| all | memory[plane.index()]);
    Some(!guard)
}

/// Random parts, several times the same with other data and constants, one of them perhaps not: code that is shared does
/// what the operations mean, as does code that is not in pieces.
#[test]
fn parts_that_are_alike_share_code() {
    let (mut shared, mut constants, mut edges, mut left) = (0, 0, 0, 0);
    for seed in 0..200 {
        let mut r = Random(seed);
        let recipe = Recipe {
            seed: r.word(),
            nodes: 30 + r.below(120),
            varied: if r.below(3) == 0 { usize::MAX } else { 12 },
            puts: r.below(2) == 0,
            bail_outs: r.below(2) == 0,
            neighbours: r.below(3) == 0,
        };
        let odd = if r.below(3) == 0 { r.below(PARTS) } else { PARTS };
        let edge = edge(&recipe, odd);
        let piece = [10, 60, 300][r.below(3)];
        let end = 2 * (CONTENTS + PARTS as u32 * NEXT);
        let mut next = end;
        let mut fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let schedule = outline(&edge, piece, &mut fresh);
        let alike = merge(&edge.graph, &schedule, &mut fresh);
        shared += (0..).zip(&alike.calls).filter(|(number, call)| call.code != *number).count();
        constants += alike.constants.len();
        let mut edge_loop = |piece| codegen::compile_loop(&[&edge], piece, Shared::default(), &mut fresh).unwrap();
        let edge_loops = [edge_loop(piece), edge_loop(1 << 20)];
        for edge_loop in &edge_loops {
            let mut memory: Vec<u64> = (0..end).map(|_| r.word()).collect();
            memory[0] = 0;
            let words = memory.chunks(2).map(|plane| Word { v: plane[0], u: plane[1] });
            let mut words: Vec<Word> = words.chain((end..next + 200).step_by(2).map(|_| Word::ZERO)).collect();
            for _ in 0..20 {
                let rounds = 1 + r.below(9) as u64;
                let done = edge_loop.run(&mut words, rounds);
                let mut expected = 0;
                while expected < rounds {
                    let on = made(&edge, &mut memory);
                    expected += u64::from(on.is_some());
                    if on != Some(true) {
                        break;
                    }
                }
                assert_eq!(done, expected, "seed {seed}");
                let here: Vec<u64> = words.iter().flat_map(|w| [w.v, w.u]).take(end as usize).collect();
                assert_eq!(here, memory, "seed {seed}");
                edges += done;
                left += u64::from(done < rounds);
                if done < rounds {
                    // it would be left again
                    memory[FIRST as usize..][..STATE as usize].iter_mut().for_each(|plane| *plane = r.word());
                    memory[0] = 0;
                    for (word, plane) in words.iter_mut().zip(memory.chunks(2)) {
                        *word = Word { v: plane[0], u: plane[1] };
                    }
                }
            }
        }
    }
    println!("{shared} pieces share code, {constants} constants; {edges} edges, left {left} times");
    assert!(shared > 1000 && constants > 100 && edges > 20_000 && left > 1000);
}
