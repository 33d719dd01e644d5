//! From below: equal operations on bits that lie side by side already become one, whether or not anybody asks for the result as
//! a word: the multiplexers over the words of a register file, of which adders and comparisons take single bits.
//!
//! Sound: as for words that are asked for; a row that costs more than its bits one by one is left out.

use super::{Class, Lanes, Recovery};
use crate::compiled::ir::graph::{Id, Map, Op};
use crate::compiled::passes::word_recovery::chains::bit_of;

/// Bits that make it worth looking at.
const LEAST: usize = 4;
/// Operations that it takes to have a single bit of a word.
const TAKE_OUT: usize = 2;
const NO_ROW: u32 = u32::MAX;
/// Operations that it takes to have a bit in all lanes.
const SPREAD: usize = 2;

/// What an operand is in all lanes: bits of a row, so many lanes further up, or one bit that all have.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Side {
    Row(u32, i8),
    All(Id),
}

/// Bits that lie side by side: of a word, or computed alike of such.
struct Row {
    /// What computes them; none for a word that is there.
    class: Option<Class>,
    sides: [Side; 2],
    lanes: Lanes,
    kept: bool,
    /// The rows kept that read it.
    readers: u32,
}

struct Gather<'p, 'g> {
    p: &'p Recovery<'g>,
    rows: Vec<Row>,
    /// The row and the lane of each node.
    at: Vec<(u32, u8)>,
    /// How often a node is used by itself, not as a part of its row.
    alone: Vec<u32>,
}

impl Recovery<'_> {
    /// Makes words of what is worth it; `asked` are the nodes that words of state will be made of.
    pub(crate) fn gather(&mut self, nodes: &[Id], asked: impl Iterator<Item = Id>) {
        let mut alone = self.uses.clone();
        asked.for_each(|n| alone[n.index()] -= 1);
        let mut g = Gather { p: self, rows: Vec::new(), at: vec![(NO_ROW, 0); self.homes.len()], alone };
        g.words();
        g.rise(nodes);
        g.thin();
        let kept: Vec<(Class, Lanes)> =
            g.rows.into_iter().filter(|r| r.kept).filter_map(|r| Some((r.class?, r.lanes))).collect();
        for (class, lanes) in kept {
            let word = self.together(class, &lanes);
            for &(lane, node) in &lanes {
                if self.homes[node.index()].0 == Id::NONE {
                    self.homes[node.index()] = (word, lane);
                }
            }
        }
    }
}

impl Gather<'_, '_> {
    /// The words that are there.
    fn words(&mut self) {
        let mut rows: Map<(bool, Id), u32> = Map::default();
        for node in self.p.g.ids() {
            let (word, lane) = self.p.homes[node.index()];
            let found = match bit_of(self.p.g, node).filter(|b| self.p.g.possible_bits(b.0) > 1) {
                _ if word != Id::NONE => Some((true, word, lane)),
                Some((word, lane)) => Some((false, word, lane)),
                None => None,
            };
            if let Some((here, word, lane)) = found {
                let next = self.rows.len() as u32;
                let row = *rows.entry((here, word)).or_insert(next);
                if row == next {
                    let sides = [Side::All(Id::NONE); 2];
                    self.rows.push(Row { class: None, sides, lanes: Vec::new(), kept: true, readers: 0 });
                }
                self.rows[row as usize].lanes.push((lane, node));
                self.at[node.index()] = (row, lane);
            }
        }
    }

    /// The operands of a node, and whether they may be exchanged.
    fn operands(&self, node: Id) -> Option<(Id, Id, bool)> {
        Some(match self.p.g.op(node) {
            Op::And(a, b) | Op::Or(a, b) | Op::Xor(a, b) => (a, b, true),
            Op::AndNot(a, b) | Op::Select(_, a, b) => (a, b, false),
            _ => return None,
        })
    }

    /// The lane of a node by its operands, and what these are.
    fn sides(&self, node: Id) -> Option<(u8, [Side; 2])> {
        let (a, b, free) = self.operands(node)?;
        let of = |n: Id| self.at[n.index()];
        let (_, lane) = [of(a), of(b)].into_iter().find(|at| at.0 != NO_ROW)?;
        let side = |n: Id| match of(n) {
            (NO_ROW, _) => Side::All(n),
            (row, at) => Side::Row(row, at as i8 - lane as i8),
        };
        let mut sides = [side(a), side(b)];
        if free && sides[0] > sides[1] {
            sides.swap(0, 1);
        }
        Some((lane, sides))
    }

    /// Rows of rows, from below.
    fn rise(&mut self, nodes: &[Id]) {
        let p = self.p;
        let fits = |n: &&Id| p.class(**n).is_some() && p.homes[n.index()].0 == Id::NONE && !p.of_chain.contains_key(n);
        let mut order: Vec<Id> = nodes.iter().filter(fits).copied().collect();
        order.sort_by_key(|&n| (p.levels[n.index()], n));
        for level in order.chunk_by(|&a, &b| p.levels[a.index()] == p.levels[b.index()]) {
            let mut found: Vec<Row> = Vec::new();
            let mut by_key: Map<(Class, [Side; 2]), usize> = Map::default();
            for &node in level {
                let (Some(class), Some((lane, sides))) = (p.class(node), self.sides(node)) else { continue };
                if self.at[node.index()].0 != NO_ROW {
                    continue;
                }
                let at = *by_key.entry((class, sides)).or_insert(found.len());
                if at == found.len() {
                    found.push(Row { class: Some(class), sides, lanes: Vec::new(), kept: true, readers: 0 });
                }
                if !found[at].lanes.iter().any(|l| l.0 == lane) {
                    found[at].lanes.push((lane, node));
                }
            }
            for mut row in found.into_iter().filter(|r| r.lanes.len() >= LEAST) {
                row.lanes.sort_unstable();
                let number = self.rows.len() as u32;
                for &(lane, node) in &row.lanes {
                    self.at[node.index()] = (number, lane);
                }
                self.rows.push(row);
            }
        }
    }

    /// The operands of a row's nodes that lie in rows.
    fn parts(&self, row: &Row) -> Vec<Id> {
        let nodes = row.lanes.iter().filter_map(|&(_, node)| self.operands(node));
        nodes.flat_map(|(a, b, _)| [a, b]).filter(|&n| self.at[n.index()].0 != NO_ROW).collect()
    }

    /// Leaves out rows that cost more than they save, from above: nothing that is kept reads them.
    fn thin(&mut self) {
        for number in 0..self.rows.len() {
            if self.rows[number].class.is_none() {
                continue;
            }
            self.parts(&self.rows[number]).into_iter().for_each(|n| self.alone[n.index()] -= 1);
            for side in self.rows[number].sides {
                if let Side::Row(row, _) = side {
                    self.rows[row as usize].readers += 1;
                }
            }
        }
        loop {
            let mut changed = false;
            for number in (0..self.rows.len()).rev() {
                let row = &self.rows[number];
                if row.class.is_none() || !row.kept || row.readers > 0 {
                    continue;
                }
                let parts = self.parts(row);
                let spread = |side: &&Side| matches!(side, Side::All(n) if self.p.g.value(*n).is_none());
                let out = row.lanes.iter().filter(|l| self.alone[l.1.index()] > 0).count();
                let together = 1 + SPREAD * row.sides.iter().filter(spread).count() + TAKE_OUT * out;
                let apart = row.lanes.len() + TAKE_OUT * parts.iter().filter(|&&n| self.alone[n.index()] == 0).count();
                if together <= apart {
                    continue;
                }
                let sides = row.sides;
                parts.into_iter().for_each(|n| self.alone[n.index()] += 1);
                for side in sides {
                    if let Side::Row(row, _) = side {
                        self.rows[row as usize].readers -= 1;
                    }
                }
                self.rows[number].kept = false;
                changed = true;
            }
            if !changed {
                return;
            }
        }
    }
}
