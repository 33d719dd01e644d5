//! Trees of ANDs and ORs: those of their bits that lie in one word are compared with a pattern, all at once.
//!
//! Sound: a conjunction of literals of one word is true exactly where the masked word equals the pattern; a disjunction is the
//! inverse of one. A tree is followed only through nodes that nothing else uses.

use super::{Class, LEAST, Recovery};
use crate::compiled::ir::graph::{Id, Op};

impl Recovery<'_> {
    /// A tree of ANDs, or by inversion of ORs: bits that lie in one word are compared together.
    pub(crate) fn tree(&mut self, node: Id) -> Id {
        let is_or = matches!(self.g.op(node), Op::Or(..));
        let mut literals: Vec<(Id, bool)> = Vec::new();
        let mut stack = vec![(node, !is_or)];
        while let Some((at, holds)) = stack.pop() {
            let inside = (at == node || self.uses[at.index()] == 1)
                && self.homes[at.index()].0 == Id::NONE
                && !self.of_chain.contains_key(&at)
                && self.scalars[at.index()] == Id::NONE;
            match self.g.op(at) {
                Op::And(x, y) if inside && holds && self.g.possible_bits(x) | self.g.possible_bits(y) == 1 => {
                    stack.extend([(y, true), (x, true)]);
                }
                Op::AndNot(x, y) if inside && holds && self.g.possible_bits(x) | self.g.possible_bits(y) == 1 => {
                    stack.extend([(y, false), (x, true)]);
                }
                Op::Or(x, y) if inside && !holds => stack.extend([(y, false), (x, false)]),
                Op::Xor(x, c) if self.g.is(c, 1) => stack.push((x, !holds)),
                _ => literals.push((at, holds)),
            }
        }
        if literals.len() < LEAST {
            return self.plainly(node, self.g.op(node));
        }
        self.gather_literals(&literals);
        // literals by the words in which they lie
        let mut groups: Vec<(Id, u64, u64)> = Vec::new();
        let mut rest = Vec::new();
        for (at, holds) in literals {
            let Some((word, lane)) = self.home(at) else {
                rest.push((at, holds));
                continue;
            };
            let bit = 1u64 << lane;
            match groups.iter_mut().find(|g| g.0 == word && (g.1 & bit == 0 || (g.2 & bit != 0) == holds)) {
                Some(group) => {
                    group.1 |= bit;
                    group.2 |= if holds { bit } else { 0 };
                }
                None => groups.push((word, bit, if holds { bit } else { 0 })),
            }
        }
        let mut all: Option<Id> = None;
        let mut negative: Option<Id> = None;
        for (word, mask, pattern) in groups {
            let g = &mut self.out;
            if mask.is_power_of_two() {
                let one = g.bits(word, mask.trailing_zeros(), 1);
                let list = if pattern == 0 { &mut negative } else { &mut all };
                *list = Some(match *list {
                    None => one,
                    Some(had) if pattern == 0 => g.or(had, one),
                    Some(had) => g.and(had, one),
                });
                continue;
            }
            let (mask, pattern) = (g.constant(mask), g.constant(pattern));
            let there = g.and(word, mask);
            let same = g.eq(there, pattern);
            all = Some(all.map_or(same, |all| g.and(all, same)));
        }
        for (at, holds) in rest {
            let one = self.bit(at);
            let g = &mut self.out;
            if holds {
                all = Some(all.map_or(one, |all| g.and(all, one)));
            } else {
                negative = Some(negative.map_or(one, |had| g.or(had, one)));
            }
        }
        let g = &mut self.out;
        let result = match (all, negative) {
            (Some(a), Some(n)) => g.and_not(a, n),
            (Some(a), None) => a,
            (None, Some(n)) => g.not(n, 1),
            (None, None) => g.constant(1),
        };
        if is_or { g.not(result, 1) } else { result }
    }

    /// Makes words of literals that look alike.
    fn gather_literals(&mut self, literals: &[(Id, bool)]) {
        let mut classes: Vec<((Class, u32, u32), Vec<Id>)> = Vec::new();
        for &(at, _) in literals {
            if self.g.op(at).is_leaf() || self.home(at).is_some() {
                continue;
            }
            let Some(class) = self.class(at) else { continue };
            let class = (class, self.levels[at.index()], self.looks[at.index()]);
            match classes.iter_mut().find(|c| c.0 == class) {
                Some(found) if !found.1.contains(&at) => found.1.push(at),
                Some(_) => {}
                None => classes.push((class, vec![at])),
            }
        }
        for (_, list) in classes.into_iter().filter(|c| c.1.len() >= 4 && c.1.len() <= 64) {
            let mut lanes: Vec<(u8, Id)> = Vec::new();
            for (i, &at) in list.iter().enumerate() {
                let lane = self.hint(at, 3).unwrap_or(i as u8);
                lanes.push((lane, at));
            }
            lanes.sort_unstable();
            if lanes.windows(2).any(|w| w[0].0 == w[1].0) {
                continue;
            }
            self.word(&lanes);
        }
    }
}
