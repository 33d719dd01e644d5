//! What follows from a condition, a node of 0 or 1: what else holds then, and which conditions exclude each other.
//!
//! Sound, not complete: an answer holds in every memory; where it is not plain from a few levels of gates there is none.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};

impl Graph {
    /// A node of 0 or 1 that is 1 wherever `a` is not 0, if one is at hand.
    pub fn condition(&self, a: Id) -> Option<Id> {
        match self.op(a) {
            _ if self.possible_bits(a) == 1 => Some(a),
            Op::Select(s, _, none) if self.is(none, 0) => Some(s),
            Op::Shl(x, _) | Op::Shr(x, _) | Op::ShlBy(x, _) | Op::ShrBy(x, _) => self.condition(x),
            Op::And(x, y) => self.condition(x).or_else(|| self.condition(y)),
            _ => None,
        }
    }

    /// What is 1 and what is 0 wherever `when`, a node of 0 or 1, is 1.
    fn facts(&self, when: Id) -> Map<Id, bool> {
        let (mut facts, mut stack): (Map<Id, bool>, Vec<(Id, bool)>) = (Map::default(), vec![(when, true)]);
        while let Some((node, holds)) = stack.pop() {
            if self.possible_bits(node) != 1 || facts.insert(node, holds) == Some(holds) {
                continue;
            }
            match self.op(node) {
                Op::And(x, y) if holds => stack.extend([(x, true), (y, true)]),
                Op::AndNot(x, y) if holds => stack.extend([(x, true), (y, false)]),
                Op::Or(x, y) if !holds => stack.extend([(x, false), (y, false)]),
                Op::Xor(x, c) if self.is(c, 1) => stack.push((x, !holds)),
                Op::Select(s, x, none) if holds && self.is(none, 0) => stack.extend([(s, true), (x, true)]),
                _ => {}
            }
        }
        facts
    }

    /// Of what each of some nodes of 0 or 1 says, one alternative after another.
    fn alternatives(&self, node: Id) -> Vec<Map<Id, bool>> {
        let (mut out, mut stack) = (Vec::new(), vec![node]);
        while let Some(node) = stack.pop() {
            match self.op(node) {
                Op::Or(x, y) if self.possible_bits(node) == 1 && out.len() + stack.len() < 16 => stack.extend([x, y]),
                _ => out.push(self.facts(node)),
            }
        }
        out
    }

    /// Whether it is plain that no two of some nodes of 0 or 1 are 1 at once.
    pub fn exclusive(&self, list: &[Id]) -> bool {
        let mut before: Vec<Map<Id, bool>> = Vec::new();
        for &node in list.iter().filter(|&&n| !self.is(n, 0)) {
            let own = self.alternatives(node);
            for facts in &own {
                let excludes = |other: &Map<Id, bool>| facts.iter().any(|(n, holds)| other.get(n) == Some(&!holds));
                if !before.iter().all(|other| excludes(other) || self.differ(facts, other)) {
                    return false;
                }
            }
            before.extend(own);
        }
        true
    }

    /// Whether it is plain that one of some nodes of 0 or 1 is 1: they compare something with each value that it may have.
    pub fn exhaustive(&self, list: &[Id]) -> bool {
        let mut values: Map<Id, Vec<u64>> = Map::default();
        for facts in list.iter().flat_map(|&node| self.alternatives(node)) {
            if facts.len() > 1 {
                continue;
            }
            if let Some((&node, true)) = facts.iter().next()
                && let Op::Eq(x, c) = self.op(node)
                && let Some(c) = self.value(c)
            {
                let of = values.entry(x).or_default();
                of.extend((!of.contains(&c)).then_some(c));
            }
        }
        values.iter().any(|(&x, of)| {
            self.possible_bits(x).count_ones() < 8 && of.len() == 1 << self.possible_bits(x).count_ones()
        })
    }

    /// Whether what two nodes say is equal to constants cannot be.
    fn differ(&self, a: &Map<Id, bool>, b: &Map<Id, bool>) -> bool {
        let equal = |facts: &Map<Id, bool>| -> Vec<(Id, u64)> {
            let list = facts.iter().filter(|f| *f.1).filter_map(|f| match self.op(*f.0) {
                Op::Eq(x, c) => Some((x, self.value(c)?)),
                _ => None,
            });
            list.collect()
        };
        let b = equal(b);
        equal(a).iter().any(|(x, c)| b.iter().any(|(y, d)| x == y && c != d))
    }

    /// A node that is `a` wherever `when`, a node of 0 or 1, is 1.
    pub fn given(&self, when: Id, a: Id) -> Id {
        let facts = self.facts(when);
        let mut at = a;
        while let Op::Select(s, x, y) = self.op(at) {
            match facts.get(&s) {
                Some(true) => at = x,
                Some(false) => at = y,
                None => break,
            }
        }
        at
    }
}
