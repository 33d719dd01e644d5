//! A whole cycle of a clock in machine code, on state in recovered words while its loop runs.

use crate::compiled::codegen::machine::EdgeLoop;
use crate::compiled::codegen::{self, Shared};
use crate::compiled::ir::graph::Map;
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::record::Record;
use crate::compiled::ir::schedule::Partition;
use crate::compiled::ir::stores::Store;
use crate::compiled::passes::cycle::compose;
use crate::compiled::passes::edge::EdgeCode;
use crate::compiled::passes::word_recovery::{LEAST, Place, Recovered, TRIALS, recover};
use crate::compiled::runtime::word_of;
use crate::value::Word;

/// A cycle in machine code.
#[derive(Debug)]
pub(crate) struct Cycle {
    edge_loop: EdgeLoop,
    places: Vec<Place>,
    /// Whether each of the places changes.
    changing: Vec<bool>,
    /// Periods to sit out after it was left at once, and how many of these are to come.
    patience: u32,
    waiting: u32,
}

/// Periods up to which going in and out costs more than it gains.
pub(crate) const SHORT: u64 = 32;

impl Cycle {
    /// Makes a cycle of its edges. `groups` are the lanes that single bits of state get.
    pub fn new(edges: &[&EdgeCode], groups: &[Vec<(u8, PlaneWord)>], piece: usize, end: &mut u32) -> Option<Cycle> {
        let mut step = compose(edges)?;
        let plain = step.cost();
        let mut next = 2 * *end;
        let mut fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let Recovered { step, places, .. } = recover(&mut step, groups, LEAST, TRIALS, &mut fresh)?;
        // What does not lie in words is better left as it is. Long edges come in pieces, which share code where they are
        // alike; a cycle, which is left before anything is stored, does so less well.
        let least = if edges.iter().any(|edge| codegen::is_long(&edge.partition, piece)) { plain / 8 } else { 0 };
        if step.cost() + least >= plain {
            return None;
        }
        let nodes = step.needed();
        let changes: Map<PlaneWord, ()> = step.stores.iter().map(|s| (s.0, ())).collect();
        let changing = places.iter().map(|p| changes.contains_key(&p.word)).collect();
        let stores = step.stores.iter().map(|&(plane, node)| Store::plain(node, plane)).collect();
        let partition = Partition { nodes, stores, puts: step.puts, bail_outs: step.bail_outs, ..Partition::default() };
        let edge = EdgeCode { partition, graph: step.graph, record: Record::default() };
        let edge_loop = codegen::compile_loop(&[&edge], piece, Shared::default(), &mut fresh).ok()?;
        *end = next.div_ceil(2);
        Some(Cycle { edge_loop, places, changing, patience: 1, waiting: 0 })
    }

    /// Goes round up to `rounds` times; how many times it did.
    pub fn run(&mut self, memory: &mut [Word], rounds: u64) -> u64 {
        if self.waiting > 0 {
            self.waiting -= 1;
            return 0;
        }
        for Place { word, lanes } in &self.places {
            *word_of(memory, *word) = lanes.iter().fold(0, |all, &(lane, h)| all | (*word_of(memory, h) & 1) << lane);
        }
        let done = self.edge_loop.run(memory, rounds);
        for (Place { word, lanes }, _) in self.places.iter().zip(&self.changing).filter(|p| *p.1) {
            let value = *word_of(memory, *word);
            lanes.iter().for_each(|&(lane, h)| *word_of(memory, h) = value >> lane & 1);
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
