//! Products and sums of growing sets of bits, as in a look-ahead carry, laid in a row: each is made from the one that has one bit
//! less, so that the row looks like a chain.
//!
//! Sound: AND and OR are associative and commutative, so any order of the bits of a set gives the same node value.

use std::hash::{Hash, Hasher};

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::stores::Put;
use crate::compiled::passes::word_recovery::Step;
use crate::compiled::passes::word_recovery::chains::lane_of;

/// Bits of a product up to which it is looked at.
const MOST: usize = 40;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Product,
    Sum,
}

/// A step of the nodes that it needs, with products and sums in rows.
pub(crate) fn in_rows(step: &Step, lanes: &Map<PlaneWord, u8>) -> Step {
    let g = &step.graph;
    let nodes = step.needed();
    let mut sets: Map<(bool, u64), ()> = Map::default();
    let mut of: Map<Id, (Kind, Vec<(Id, bool)>)> = Map::default();
    for &node in nodes.iter().filter(|&&n| g.possible_bits(n) == 1) {
        let mut bits = Vec::new();
        let kind = match g.op(node) {
            Op::And(..) | Op::AndNot(..) => {
                g.factors_of(node, false, &mut bits);
                Kind::Product
            }
            Op::Or(..) => {
                sum_of(g, node, &mut bits);
                Kind::Sum
            }
            _ => continue,
        };
        // the lowest bit first
        bits.sort_by_cached_key(|&(bit, inverted)| (lane_of(g, lanes, bit, 2), bit, inverted));
        bits.dedup();
        if (2..=MOST).contains(&bits.len()) {
            sets.insert((kind == Kind::Sum, digest(&bits)), ());
            of.insert(node, (kind, bits));
        }
    }
    let mut out = Graph::default();
    let mut map: Map<Id, Id> = Map::default();
    let at = |out: &mut Graph, map: &Map<Id, Id>, node: Id| match g.op(node) {
        Op::Const(n) => out.constant(n),
        Op::Load(plane) => out.load(plane, g.possible_bits(node)),
        _ => map[&node],
    };
    for node in nodes {
        let operands: Vec<(Id, Id)> = g.op(node).operands().map(|o| (o, at(&mut out, &map, o))).collect();
        let row = of.get(&node).filter(|(kind, bits)| {
            let Some((_, but_one)) = bits.split_last() else { return false };
            bits.len() > 2 && sets.contains_key(&(*kind == Kind::Sum, digest(but_one)))
        });
        let made = match row {
            Some((kind, bits)) if bits.iter().all(|b| g.op(b.0).is_leaf() || map.contains_key(&b.0)) => {
                let mut all: Option<Id> = None;
                for &(bit, inverted) in bits {
                    let bit = at(&mut out, &map, bit);
                    let bit = if inverted { out.not(bit, 1) } else { bit };
                    all = Some(match (all, kind) {
                        (None, _) => bit,
                        (Some(all), Kind::Product) => out.and(all, bit),
                        (Some(all), Kind::Sum) => out.or(all, bit),
                    });
                }
                all.expect("there are some")
            }
            _ => out.rebuild(g.op(node), g.possible_bits(node), |o| {
                operands.iter().find(|p| p.0 == o).expect("it is an operand").1
            }),
        };
        map.insert(node, made);
    }
    let stores = step.stores.iter().map(|&(plane, node)| (plane, at(&mut out, &map, node))).collect();
    let bail_outs = step.bail_outs.iter().map(|&node| at(&mut out, &map, node)).collect();
    let puts = step.puts.iter().map(|put| Put {
        index: at(&mut out, &map, put.index),
        mask: at(&mut out, &map, put.mask),
        v: at(&mut out, &map, put.v),
        u: at(&mut out, &map, put.u),
        ..*put
    });
    let puts = puts.collect();
    Step { graph: out, stores, puts, bail_outs }
}

fn sum_of(g: &Graph, node: Id, all: &mut Vec<(Id, bool)>) {
    match g.op(node) {
        Op::Or(x, y) if all.len() <= MOST => {
            sum_of(g, x, all);
            sum_of(g, y, all);
        }
        _ => all.push((node, false)),
    }
}

fn digest(bits: &[(Id, bool)]) -> u64 {
    let mut hash = rustc_hash::FxHasher::default();
    bits.hash(&mut hash);
    hash.finish()
}
