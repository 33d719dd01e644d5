//! Algebraic simplification of bitwise operations: what a composition of two levels of gates is, where that is less.
//!
//! Sound: each identity holds bit by bit, so on whole words and for either plane of a four-valued word. Those that take 1 as
//! "all ones" are tried only where the known-bits masks say that the operands are single bits. A test goes through all
//! compositions of three gates.

use crate::compiled::ir::graph::{Graph, Id, Op};

/// Factors of a product that are told apart.
const MOST_FACTORS: usize = 40;

impl Graph {
    /// `x` where a node is `c & !x` and no other bit of `within` is in question.
    fn inverse(&self, a: Id, within: u64) -> Option<(Id, Id)> {
        match self.op(a) {
            Op::Xor(x, c) if self.value(c).is_some_and(|c| (within | self.possible_bits(x)) & !c == 0) => Some((x, c)),
            _ => None,
        }
    }

    pub(crate) fn simplified_and(&mut self, a: Id, b: Id) -> Option<Id> {
        if self.value(a).or(self.value(b)).is_some() {
            return None;
        }
        for (a, b) in [(a, b), (b, a)] {
            match self.op(b) {
                Op::Or(x, y) if x == a || y == a => return Some(a),
                Op::And(x, y) if x == a || y == a => return Some(b),
                Op::AndNot(x, _) if x == a => return Some(b),
                Op::AndNot(_, y) if y == a => return Some(self.constant(0)),
                Op::Xor(x, y) if x == a => return Some(self.and_not(a, y)),
                Op::Xor(x, y) if y == a => return Some(self.and_not(a, x)),
                _ => {}
            }
            match (self.op(a), self.op(b)) {
                (Op::Or(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(b),
                (Op::And(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(self.constant(0)),
                _ => {}
            }
        }
        None
    }

    pub(crate) fn simplified_and_not(&mut self, a: Id, b: Id) -> Option<Id> {
        if self.value(a).or(self.value(b)).is_some() {
            return None;
        }
        match (self.op(a), self.op(b)) {
            (Op::Or(x, y), Op::And(p, q)) if (x, y) == (p, q) => return Some(self.xor(x, y)),
            (Op::Or(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(self.and(x, y)),
            (Op::Xor(x, y), Op::And(p, q)) if (x, y) == (p, q) => return Some(a),
            _ => {}
        }
        match self.op(a) {
            Op::Or(x, y) if x == b => return Some(self.and_not(y, b)),
            Op::Or(x, y) if y == b => return Some(self.and_not(x, b)),
            Op::And(x, y) if x == b || y == b => return Some(self.constant(0)),
            Op::AndNot(x, _) if x == b => return Some(self.constant(0)),
            Op::AndNot(_, y) if y == b => return Some(a),
            _ => {}
        }
        match self.op(b) {
            Op::Or(x, y) if x == a || y == a => return Some(self.constant(0)),
            Op::And(x, y) if x == a => return Some(self.and_not(a, y)),
            Op::And(x, y) if y == a => return Some(self.and_not(a, x)),
            Op::AndNot(x, y) if x == a => return Some(self.and(a, y)),
            Op::AndNot(_, y) if y == a => return Some(a),
            Op::Xor(x, y) if x == a => return Some(self.and(a, y)),
            Op::Xor(x, y) if y == a => return Some(self.and(a, x)),
            _ => {}
        }
        // neither of two
        let (x, c) = self.inverse(a, self.possible_bits(b))?;
        let either = self.or(x, b);
        Some(self.xor(either, c))
    }

    pub(crate) fn simplified_or(&mut self, a: Id, b: Id) -> Option<Id> {
        if self.value(a).or(self.value(b)).is_some() {
            return None;
        }
        for (a, b) in [(a, b), (b, a)] {
            match self.op(b) {
                Op::And(x, y) if x == a || y == a => return Some(a),
                Op::Or(x, y) if x == a || y == a => return Some(b),
                Op::AndNot(x, _) if x == a => return Some(a),
                Op::AndNot(x, y) if y == a => return Some(self.or(a, x)),
                Op::Xor(x, y) if x == a => return Some(self.or(a, y)),
                Op::Xor(x, y) if y == a => return Some(self.or(a, x)),
                _ => {}
            }
            match (self.op(a), self.op(b)) {
                (Op::And(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(self.or(x, y)),
                (Op::Or(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(a),
                (Op::AndNot(x, y), Op::AndNot(p, q)) if (x, y) == (q, p) => return Some(self.xor(x, y)),
                // one of two by a bit
                (Op::And(x, y), Op::AndNot(q, s))
                    if (s == x || s == y)
                        && (self.possible_bits(x) | self.possible_bits(y) | self.possible_bits(q)) == 1 =>
                {
                    let p = if s == x { y } else { x };
                    return Some(self.select(s, p, q));
                }
                _ => {}
            }
        }
        if let (Op::And(x, y), Op::And(p, q)) = (self.op(a), self.op(b))
            && self.possible_bits(a) | self.possible_bits(b) == 1
        {
            let (same, s, t) = match () {
                () if x == p => (x, y, q),
                () if x == q => (x, y, p),
                () if y == p => (y, x, q),
                () if y == q => (y, x, p),
                () => return None,
            };
            let either = self.or(s, t);
            return Some(self.and(either, same));
        }
        if self.factors
            && self.possible_bits(a) | self.possible_bits(b) == 1
            && let Some(less) = self.factored(a, b)
        {
            return Some(less);
        }
        // not both of two
        let (a, b) = if self.inverse(a, self.possible_bits(b)).is_some() { (b, a) } else { (a, b) };
        let (y, c) = self.inverse(b, self.possible_bits(a))?;
        let both = self.and_not(y, a);
        Some(self.xor(both, c))
    }

    /// `u | p & x | p & y & z` as `u | p & (x | y & z)`, which in an adder that looks ahead is a carry from the carry before.
    fn factored(&mut self, a: Id, b: Id) -> Option<Id> {
        for (short, long) in [(a, b), (b, a)] {
            let mut factors = Vec::new();
            self.factors_of(long, false, &mut factors);
            if (3..=MOST_FACTORS).contains(&factors.len())
                && let Some(less) = self.factored_by(short, &factors)
            {
                return Some(less);
            }
        }
        None
    }

    /// A sum and a product, where one factor after another is one of the sum's too.
    fn factored_by(&mut self, short: Id, factors: &[(Id, bool)]) -> Option<Id> {
        let mut terms = Vec::new();
        self.terms_of(short, &mut terms);
        for (i, &term) in terms.iter().enumerate() {
            let product = match self.op(term) {
                Op::And(x, y) if self.possible_bits(x) | self.possible_bits(y) == 1 => [(x, false), (y, false)],
                Op::AndNot(x, y) if self.possible_bits(x) | self.possible_bits(y) == 1 => [(x, false), (y, true)],
                _ => continue,
            };
            for (p, x) in [(product[0], product[1]), (product[1], product[0])] {
                let Some(at) = factors.iter().position(|&f| f == p) else { continue };
                let rest: Vec<(Id, bool)> =
                    factors.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, &f)| f).collect();
                let inner = if let [y, z] = rest[..] {
                    let [x, y, z] = [x, y, z].map(|l| self.upright(l));
                    let both = self.and(y, z);
                    self.or(x, both)
                } else if x.1 {
                    continue;
                } else {
                    let Some(inner) = self.factored_by(x.0, &rest) else { continue };
                    inner
                };
                let p = self.upright(p);
                let mut joined = self.and(p, inner);
                for (_, &other) in terms.iter().enumerate().filter(|(k, _)| *k != i) {
                    joined = self.or(other, joined);
                }
                return Some(joined);
            }
        }
        None
    }

    fn upright(&mut self, (node, inverted): (Id, bool)) -> Id {
        if inverted { self.not(node, 1) } else { node }
    }

    /// The factors of a bit, each with whether it is inverted.
    pub(crate) fn factors_of(&self, a: Id, inverted: bool, all: &mut Vec<(Id, bool)>) {
        match self.op(a) {
            _ if all.len() > MOST_FACTORS => {}
            Op::Xor(x, c) if self.is(c, 1) => return self.factors_of(x, !inverted, all),
            Op::And(x, y) if !inverted && self.possible_bits(x) | self.possible_bits(y) == 1 => {
                self.factors_of(x, false, all);
                return self.factors_of(y, false, all);
            }
            Op::AndNot(x, y) if !inverted && self.possible_bits(x) | self.possible_bits(y) == 1 => {
                self.factors_of(x, false, all);
                return self.factors_of(y, true, all);
            }
            Op::Or(x, y) if inverted => {
                self.factors_of(x, true, all);
                return self.factors_of(y, true, all);
            }
            _ => {}
        }
        all.push((a, inverted));
    }

    /// The terms of a sum of bits, as far as they are written as one.
    fn terms_of(&self, a: Id, all: &mut Vec<Id>) {
        match self.op(a) {
            Op::Or(x, y) if all.len() < 4 => {
                self.terms_of(x, all);
                self.terms_of(y, all);
            }
            _ => all.push(a),
        }
    }

    pub(crate) fn simplified_xor(&mut self, a: Id, b: Id) -> Option<Id> {
        if self.value(a).or(self.value(b)).is_some() {
            return None;
        }
        for (a, b) in [(a, b), (b, a)] {
            match self.op(b) {
                Op::Xor(x, y) if x == a => return Some(y),
                Op::Xor(x, y) if y == a => return Some(x),
                Op::And(x, y) if x == a => return Some(self.and_not(a, y)),
                Op::And(x, y) if y == a => return Some(self.and_not(a, x)),
                Op::Or(x, y) if x == a => return Some(self.and_not(y, a)),
                Op::Or(x, y) if y == a => return Some(self.and_not(x, a)),
                Op::AndNot(x, y) if x == a => return Some(self.and(a, y)),
                Op::AndNot(x, y) if y == a => return Some(self.or(a, x)),
                _ => {}
            }
            match (self.op(a), self.op(b)) {
                (Op::Or(x, y), Op::And(p, q)) if (x, y) == (p, q) => return Some(self.xor(x, y)),
                (Op::Or(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(self.and(x, y)),
                (Op::And(x, y), Op::Xor(p, q)) if (x, y) == (p, q) => return Some(self.or(x, y)),
                _ => {}
            }
        }
        None
    }

    pub(crate) fn simplified_add(&mut self, a: Id, b: Id) -> Option<Id> {
        match (self.op(a), self.op(b)) {
            (Op::Or(x, y), Op::And(p, q)) | (Op::And(x, y), Op::Or(p, q)) if (x, y) == (p, q) => Some(self.add(x, y)),
            _ => None,
        }
    }
}
