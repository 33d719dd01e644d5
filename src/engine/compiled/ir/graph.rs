//! The graph of operations: each written once (hash-consing), and folded as it is made.
//!
//! All operations are on words of 64 bits. A four-valued word is two nodes here, one a plane, so nothing that follows knows of
//! x and z; where an unknown plane is the constant 0, what is left of four-valued logic is the two-valued one. Every node has
//! a known-bits mask: bits outside it are 0 in every run. This file knows no netlist and no machine.
//!
//! Sound: a constructor returns a node that is equal to the operation in every memory in which the operation has a meaning
//! (no division by 0, no variable shift by 64 or more, selects by 0 or 1) and in which loads keep to their masks. Tests build
//! programs of all operations at random and compare each node with the interpreter.

use super::places::{PlaneWord, Slot};

/// The number of a node of a [`Graph`]. Operands have smaller numbers than what uses them.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Id(u32);

impl Id {
    /// No node: for dense tables in which most entries have one.
    pub const NONE: Id = Id(u32::MAX);

    /// The node of a place in a table that has an entry for each node.
    pub fn at(index: usize) -> Id {
        Id(u32::try_from(index).expect("graphs are limited to fewer nodes"))
    }

    /// Its place in a table that has an entry for each node.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a node computes, on 64 bits. Comparisons give 0 or 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Op {
    Const(u64),
    /// A plane word of state.
    Load(PlaneWord),
    And(Id, Id),
    /// `a & !b`.
    AndNot(Id, Id),
    Or(Id, Id),
    Xor(Id, Id),
    Add(Id, Id),
    Sub(Id, Id),
    Mul(Id, Id),
    /// The high half of the unsigned product.
    MulHigh(Id, Id),
    /// The high half of the product in two's complement.
    MulHighSigned(Id, Id),
    Shl(Id, u8),
    Shr(Id, u8),
    /// Shifts by a variable amount below 64.
    ShlBy(Id, Id),
    ShrBy(Id, Id),
    SarBy(Id, Id),
    Eq(Id, Id),
    /// Unsigned `a < b`.
    Less(Id, Id),
    /// `b` where `a` (0 or 1) is 1, else `c`.
    Select(Id, Id, Id),
    /// Unsigned; the divisor is never 0.
    Div(Id, Id),
    Rem(Id, Id),
    /// The number of ones.
    Count(Id),
    /// Plane 0 or 1 of an element of an array that begins at `slot`: of 2^`size` bytes, 8 of which lie in a slot.
    /// Whoever makes this sees to it that there is one of number `index`.
    Element {
        slot: Slot,
        index: Id,
        size: u8,
        plane: u8,
    },
}

/// Keys are small, and there are many.
pub(crate) type Map<K, V> = rustc_hash::FxHashMap<K, V>;

/// Nodes in an order in which each comes after its operands.
#[derive(Clone, Default, Debug)]
pub(crate) struct Graph {
    ops: Vec<Op>,
    /// For each node the bits that may be 1.
    may: Vec<u64>,
    known: Map<Op, Id>,
    /// Whether sums of products are factored, which lays carries that look ahead in a row.
    pub factors: bool,
}

impl Op {
    /// The operands.
    pub fn operands(&self) -> impl Iterator<Item = Id> {
        let mut op = *self;
        op.operands_mut().map(|o| o.copied()).into_iter().flatten()
    }

    /// The same with other operands.
    pub fn with(mut self, at: impl Fn(Id) -> Id) -> Op {
        self.operands_mut().into_iter().flatten().for_each(|o| *o = at(*o));
        self
    }

    fn operands_mut(&mut self) -> [Option<&mut Id>; 3] {
        match self {
            Op::Const(_) | Op::Load(_) => [None, None, None],
            Op::And(a, b)
            | Op::AndNot(a, b)
            | Op::Or(a, b)
            | Op::Xor(a, b)
            | Op::Add(a, b)
            | Op::Sub(a, b)
            | Op::Mul(a, b)
            | Op::MulHigh(a, b)
            | Op::MulHighSigned(a, b)
            | Op::ShlBy(a, b)
            | Op::ShrBy(a, b)
            | Op::SarBy(a, b)
            | Op::Eq(a, b)
            | Op::Less(a, b)
            | Op::Div(a, b)
            | Op::Rem(a, b) => [Some(a), Some(b), None],
            Op::Shl(a, _) | Op::Shr(a, _) | Op::Count(a) | Op::Element { index: a, .. } => [Some(a), None, None],
            Op::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        }
    }

    /// Whether it costs nothing to have it wherever it is used.
    pub fn is_leaf(&self) -> bool {
        matches!(self, Op::Const(_) | Op::Load(_))
    }
}

impl Graph {
    /// A graph that factors sums of products.
    pub fn factoring() -> Graph {
        Graph { factors: true, ..Graph::default() }
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.ops.len()
    }

    /// All nodes, operands before what uses them.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = Id> + use<> {
        (0..self.ops.len()).map(Id::at)
    }

    /// What some nodes are computed from and these themselves, leaves left out, in order.
    pub fn needed(&self, roots: impl IntoIterator<Item = Id>) -> Vec<Id> {
        let mut needed = vec![false; self.len()];
        roots.into_iter().for_each(|n| needed[n.index()] = true);
        for node in self.ids().rev() {
            if needed[node.index()] {
                self.op(node).operands().for_each(|o| needed[o.index()] = true);
            }
        }
        self.ids().filter(|&n| needed[n.index()] && !self.op(n).is_leaf()).collect()
    }

    pub fn op(&self, id: Id) -> Op {
        self.ops[id.index()]
    }

    /// The bits of a node that may be 1.
    pub fn possible_bits(&self, id: Id) -> u64 {
        self.may[id.index()]
    }

    pub fn value(&self, id: Id) -> Option<u64> {
        if let Op::Const(n) = self.op(id) { Some(n) } else { None }
    }

    pub fn is(&self, id: Id, n: u64) -> bool {
        self.op(id) == Op::Const(n)
    }

    fn push(&mut self, op: Op, may: u64) -> Id {
        if may == 0 && op != Op::Const(0) {
            return self.constant(0);
        }
        let (ops, list) = (&mut self.ops, &mut self.may);
        *self.known.entry(op).or_insert_with(|| {
            ops.push(op);
            list.push(may);
            Id::at(ops.len() - 1)
        })
    }

    pub fn constant(&mut self, n: u64) -> Id {
        self.push(Op::Const(n), n)
    }

    /// A plane word of which only the bits of `may` are ever 1.
    pub fn load(&mut self, plane: PlaneWord, may: u64) -> Id {
        self.push(Op::Load(plane), may)
    }

    pub fn element(&mut self, slot: Slot, index: Id, size: u8, plane: u8, may: u64) -> Id {
        self.push(Op::Element { slot, index, size, plane }, may)
    }

    /// Operands in order: constants last, so that equal operations look equal.
    fn ordered(&self, a: Id, b: Id) -> (Id, Id) {
        let key = |id| (self.value(id).is_some(), id);
        if key(a) <= key(b) { (a, b) } else { (b, a) }
    }

    pub fn and(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        let may = self.possible_bits(a) & self.possible_bits(b);
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x & y),
            (None, Some(m)) => {
                if self.possible_bits(a) & !m == 0 {
                    return a;
                }
                match self.op(a) {
                    Op::And(x, c) if self.value(c).is_some() => {
                        let n = self.constant(m & self.possible_bits(c));
                        return self.and(x, n);
                    }
                    // what the mask cuts off need not be made
                    Op::Select(s, x, y) if self.value(x).is_some() && self.value(y).is_some() => {
                        let (x, y) = (self.and(x, b), self.and(y, b));
                        return self.select(s, x, y);
                    }
                    Op::Or(x, y) if self.possible_bits(y) & m == 0 => return self.and(x, b),
                    Op::Or(x, y) if self.possible_bits(x) & m == 0 => return self.and(y, b),
                    _ => {}
                }
            }
            _ => {}
        }
        if a == b {
            return a;
        }
        // a bit in all places, or in none
        for (x, y) in [(a, b), (b, a)] {
            if let Op::Select(s, m, z) = self.op(y)
                && self.is(z, 0)
                && self.value(m).is_some_and(|m| self.possible_bits(x) & !m == 0)
            {
                return self.select(s, x, z);
            }
        }
        match (self.op(a), self.op(b)) {
            (Op::Select(s, x, y), Op::Select(t, p, q))
                if s == t && [x, y, p, q].iter().all(|&o| self.value(o).is_some()) =>
            {
                let (x, y) = (self.and(x, p), self.and(y, q));
                self.select(s, x, y)
            }
            (_, Op::Xor(x, c)) if self.value(c).is_some_and(|c| c & self.possible_bits(a) == self.possible_bits(a)) => {
                // a & !x
                self.and_not(a, x)
            }
            (Op::Xor(x, c), _) if self.value(c).is_some_and(|c| c & self.possible_bits(b) == self.possible_bits(b)) => {
                self.and_not(b, x)
            }
            _ => match self.simplified_and(a, b) {
                Some(less) => less,
                None => self.push(Op::And(a, b), may),
            },
        }
    }

    /// `a & !b`.
    pub fn and_not(&mut self, a: Id, b: Id) -> Id {
        let may = match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x & !y),
            (Some(x), None) if self.possible_bits(b) & !x == 0 => return self.xor(b, a),
            (None, Some(y)) => {
                let m = self.constant(self.possible_bits(a) & !y);
                return self.and(a, m);
            }
            _ => self.possible_bits(a),
        };
        if a == b {
            return self.constant(0);
        }
        if self.possible_bits(a) & self.possible_bits(b) == 0 {
            return a;
        }
        match self.op(b) {
            // a & !(x ^ all)
            Op::Xor(x, c) if self.value(c).is_some_and(|c| c & may == may) => self.and(a, x),
            _ => match self.simplified_and_not(a, b) {
                Some(less) => less,
                None => self.push(Op::AndNot(a, b), may),
            },
        }
    }

    pub fn or(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        let may = self.possible_bits(a) | self.possible_bits(b);
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x | y),
            (None, Some(0)) => return a,
            (None, Some(n)) if self.possible_bits(a) & !n == 0 => return b,
            _ => {}
        }
        if a == b {
            return a;
        }
        // what is cut in pieces and put together again is the whole
        if let (Some((x, m)), Some((y, n))) = (self.piece(a), self.piece(b))
            && x == y
        {
            let all = self.constant(m | n);
            return self.and(x, all);
        }
        if let Op::Or(x, y) = self.op(a)
            && let Some((whole, n)) = self.piece(b)
        {
            for (p, rest) in [(y, x), (x, y)] {
                if let Some((same, m)) = self.piece(p)
                    && same == whole
                {
                    let all = self.constant(m | n);
                    let joined = self.and(whole, all);
                    return self.or(rest, joined);
                }
            }
        }
        match self.simplified_or(a, b) {
            Some(less) => less,
            None => self.push(Op::Or(a, b), may),
        }
    }

    /// A node as some bits of another in their places.
    fn piece(&self, a: Id) -> Option<(Id, u64)> {
        match self.op(a) {
            Op::And(x, c) => Some((x, self.value(c)?)),
            Op::Shl(x, n) => match self.op(x) {
                Op::Shr(y, k) if k == n => Some((y, u64::MAX << n)),
                Op::And(s, c) => match (self.op(s), self.value(c)) {
                    (Op::Shr(y, k), Some(m)) if k == n => Some((y, m << n)),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        }
    }

    pub fn xor(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        let may = self.possible_bits(a) | self.possible_bits(b);
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x ^ y),
            (None, Some(0)) => return a,
            (None, Some(n)) => {
                if let Op::Xor(x, c) = self.op(a)
                    && let Some(m) = self.value(c)
                {
                    let c = self.constant(m ^ n);
                    return self.xor(x, c);
                }
            }
            _ => {}
        }
        if a == b {
            return self.constant(0);
        }
        // inversions move out to where they may meet others
        match (self.op(a), self.op(b)) {
            (Op::Xor(x, c), _) if self.value(c).is_some() && self.value(b).is_none() => {
                let inner = self.xor(x, b);
                self.xor(inner, c)
            }
            (_, Op::Xor(x, c)) if self.value(c).is_some() => {
                let inner = self.xor(a, x);
                self.xor(inner, c)
            }
            _ => match self.simplified_xor(a, b) {
                Some(less) => less,
                None => self.push(Op::Xor(a, b), may),
            },
        }
    }

    /// The bits of `mask` inverted; `a` has no others.
    pub fn not(&mut self, a: Id, mask: u64) -> Id {
        let m = self.constant(mask);
        self.xor(a, m)
    }

    pub fn add(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        let top = (self.possible_bits(a) | self.possible_bits(b)).leading_zeros();
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(x.wrapping_add(y)),
            (None, Some(0)) => a,
            _ => match self.simplified_add(a, b) {
                Some(less) => less,
                None => self.push(Op::Add(a, b), if top == 0 { u64::MAX } else { u64::MAX >> (top - 1) }),
            },
        }
    }

    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(x.wrapping_sub(y)),
            (_, Some(0)) => a,
            _ if a == b => self.constant(0),
            _ => self.push(Op::Sub(a, b), u64::MAX),
        }
    }

    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        let bits = (64 - self.possible_bits(a).leading_zeros()) + (64 - self.possible_bits(b).leading_zeros());
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(x.wrapping_mul(y)),
            (None, Some(1)) => a,
            (None, Some(n)) if n.is_power_of_two() => self.shl(a, n.trailing_zeros()),
            _ => self.push(Op::Mul(a, b), crate::value::word::mask(bits)),
        }
    }

    pub fn mul_high(&mut self, a: Id, b: Id, signed: bool) -> Id {
        let (a, b) = self.ordered(a, b);
        if let (Some(x), Some(y)) = (self.value(a), self.value(b)) {
            let product = if signed {
                i128::from(x as i64) * i128::from(y as i64)
            } else {
                (u128::from(x) * u128::from(y)) as i128
            };
            return self.constant((product >> 64) as u64);
        }
        self.push(if signed { Op::MulHighSigned(a, b) } else { Op::MulHigh(a, b) }, u64::MAX)
    }

    pub fn shl(&mut self, a: Id, n: u32) -> Id {
        if n >= 64 {
            return self.constant(0);
        }
        let may = self.possible_bits(a) << n;
        match self.op(a) {
            _ if n == 0 => a,
            Op::Const(x) => self.constant(x << n),
            Op::Shl(x, k) if n + u32::from(k) < 64 => self.shl(x, n + u32::from(k)),
            _ => self.push(Op::Shl(a, n as u8), may),
        }
    }

    pub fn shr(&mut self, a: Id, n: u32) -> Id {
        if n >= 64 {
            return self.constant(0);
        }
        let may = self.possible_bits(a) >> n;
        match self.op(a) {
            _ if n == 0 => a,
            _ if may == 0 => self.constant(0),
            Op::Const(x) => self.constant(x >> n),
            Op::Shr(x, k) => self.shr(x, n + u32::from(k)),
            Op::Shl(x, k) if self.possible_bits(x) << k >> k == self.possible_bits(x) => {
                let k = u32::from(k);
                if k >= n { self.shl(x, k - n) } else { self.shr(x, n - k) }
            }
            Op::Or(x, y) if self.falls(a, n, 16) => {
                let (x, y) = (self.shr(x, n), self.shr(y, n));
                self.or(x, y)
            }
            Op::Or(x, y) if self.possible_bits(x) >> n == 0 => self.shr(y, n),
            Op::Or(x, y) if self.possible_bits(y) >> n == 0 => self.shr(x, n),
            Op::Select(s, x, y) if self.value(x).is_some() && self.value(y).is_some() => {
                let (x, y) = (self.shr(x, n), self.shr(y, n));
                self.select(s, x, y)
            }
            _ => self.push(Op::Shr(a, n as u8), may),
        }
    }

    /// Whether a shift to the right costs nothing: of pieces each is shifted less to the left, or goes.
    fn falls(&self, a: Id, n: u32, depth: u32) -> bool {
        match self.op(a) {
            _ if self.possible_bits(a) >> n == 0 => true,
            Op::Const(_) => true,
            Op::Shl(x, k) => self.possible_bits(x) << k >> k == self.possible_bits(x) && u32::from(k) >= n,
            Op::Or(x, y) => depth > 0 && self.falls(x, n, depth - 1) && self.falls(y, n, depth - 1),
            _ => false,
        }
    }

    /// `width` bits from bit `lo` up.
    pub fn bits(&mut self, mut a: Id, mut lo: u32, width: u32) -> Id {
        let m = crate::value::word::mask(width);
        // from what they were put together of
        loop {
            (a, lo) = match self.op(a) {
                Op::Or(x, y) if lo < 64 && self.possible_bits(x) >> lo & m == 0 => (y, lo),
                Op::Or(x, y) if lo < 64 && self.possible_bits(y) >> lo & m == 0 => (x, lo),
                Op::Shl(x, k) if lo >= u32::from(k) => (x, lo - u32::from(k)),
                Op::Shr(x, k) if lo + u32::from(k) < 64 => (x, lo + u32::from(k)),
                Op::And(x, c) if lo < 64 && self.value(c).is_some_and(|c| c >> lo & m == m) => (x, lo),
                _ => break,
            };
        }
        let m = self.constant(m);
        let a = self.shr(a, lo);
        self.and(a, m)
    }

    pub fn shl_by(&mut self, a: Id, n: Id) -> Id {
        match self.value(n) {
            Some(n) => self.shl(a, n as u32 & 63),
            None if self.is(a, 0) => a,
            None => self.push(Op::ShlBy(a, n), u64::MAX),
        }
    }

    pub fn shr_by(&mut self, a: Id, n: Id) -> Id {
        let bits = 64 - self.possible_bits(a).leading_zeros();
        match self.value(n) {
            Some(n) => self.shr(a, n as u32 & 63),
            None if self.is(a, 0) => a,
            None => self.push(Op::ShrBy(a, n), crate::value::word::mask(bits)),
        }
    }

    pub fn sar_by(&mut self, a: Id, n: Id) -> Id {
        if self.possible_bits(a) >> 63 == 0 {
            return self.shr_by(a, n);
        }
        match (self.value(a), self.value(n)) {
            (Some(a), Some(n)) => self.constant((a as i64 >> (n & 63)) as u64),
            _ => self.push(Op::SarBy(a, n), u64::MAX),
        }
    }

    pub fn eq(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = self.ordered(a, b);
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(u64::from(x == y)),
            (None, Some(n)) if n & !self.possible_bits(a) != 0 => return self.constant(0),
            (None, Some(0)) if self.possible_bits(a) == 1 => return self.not(a, 1),
            (None, Some(1)) if self.possible_bits(a) == 1 => return a,
            (None, Some(n)) => match self.op(a) {
                // x ^ m == n
                Op::Xor(x, c) if self.value(c).is_some() => {
                    let c = self.constant(n ^ self.possible_bits(c));
                    return self.eq(x, c);
                }
                Op::Xor(x, y) if n == 0 => return self.eq(x, y),
                Op::Sub(x, y) if n == 0 => return self.eq(x, y),
                Op::Select(s, x, y) if self.value(x).is_some() || self.value(y).is_some() => {
                    let (x, y) = (self.eq(x, b), self.eq(y, b));
                    return self.select(s, x, y);
                }
                Op::Shl(x, k) if self.possible_bits(x) << k >> k == self.possible_bits(x) => {
                    // n has no bit below: it is among those that may be 1
                    let c = self.constant(n >> k);
                    return self.eq(x, c);
                }
                _ => {}
            },
            _ => {}
        }
        if a == b {
            return self.constant(1);
        }
        self.push(Op::Eq(a, b), 1)
    }

    /// Whether a node is not 0.
    pub fn any(&mut self, a: Id) -> Id {
        if self.possible_bits(a) & !1 == 0 {
            return a;
        }
        let zero = self.constant(0);
        let none = self.eq(a, zero);
        self.not(none, 1)
    }

    pub fn less(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(u64::from(x < y)),
            (_, Some(0)) => self.constant(0),
            (_, Some(n)) if self.possible_bits(a) < n => self.constant(1),
            (Some(0), _) => self.any(b),
            _ if a == b => self.constant(0),
            _ => self.push(Op::Less(a, b), 1),
        }
    }

    /// `a` where `s` (0 or 1) is 1, else `b`.
    pub fn select(&mut self, s: Id, a: Id, b: Id) -> Id {
        if let Some(s) = self.value(s) {
            return if s & 1 == 1 { a } else { b };
        }
        if a == b {
            return a;
        }
        match self.op(s) {
            // an inverted select
            Op::Xor(x, c) if self.is(c, 1) => return self.select(x, b, a),
            _ => {}
        }
        let (value_a, value_b) = (self.value(a), self.value(b));
        if self.possible_bits(a) | self.possible_bits(b) == 1 {
            match (value_a, value_b) {
                (Some(1), Some(0)) => return s,
                (Some(0), Some(1)) => return self.not(s, 1),
                (Some(0), _) => return self.and_not(b, s),
                (Some(1), _) => return self.or(s, b),
                (_, Some(0)) => return self.and(s, a),
                (_, Some(1)) => {
                    let n = self.not(s, 1);
                    return self.or(n, a);
                }
                _ => match (self.op(a), self.op(b)) {
                    (Op::Xor(x, c), _) if x == b && self.is(c, 1) => return self.xor(s, b),
                    (_, Op::Xor(x, c)) if x == a && self.is(c, 1) => {
                        let same = self.xor(s, a);
                        return self.not(same, 1);
                    }
                    _ => {}
                },
            }
        }
        // a select within one by the same
        if let Op::Select(t, x, _) = self.op(a)
            && t == s
        {
            return self.select(s, x, b);
        }
        if let Op::Select(t, _, y) = self.op(b)
            && t == s
        {
            return self.select(s, a, y);
        }
        // a value that several selects keep: one decides
        match (self.op(a), self.op(b)) {
            (_, Op::Select(t, x, y)) if y == a => {
                let when = self.and_not(t, s);
                return self.select(when, x, a);
            }
            (_, Op::Select(t, x, y)) if x == a => {
                let when = self.or(s, t);
                return self.select(when, a, y);
            }
            (Op::Select(t, x, y), _) if y == b => {
                let when = self.and(s, t);
                return self.select(when, x, b);
            }
            (Op::Select(t, x, y), _) if x == b => {
                let when = self.and_not(s, t);
                return self.select(when, y, b);
            }
            _ => {}
        }
        if a == s {
            let one = self.constant(1);
            return self.select(s, one, b);
        }
        if b == s {
            let zero = self.constant(0);
            return self.select(s, a, zero);
        }
        let may = self.possible_bits(a) | self.possible_bits(b);
        self.push(Op::Select(s, a, b), may)
    }

    /// Bit `s` (0 or 1) in every bit of `mask`.
    pub fn splat(&mut self, s: Id, mask: u64) -> Id {
        let (all, none) = (self.constant(mask), self.constant(0));
        if mask == 1 { s } else { self.select(s, all, none) }
    }

    pub fn div(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) if y != 0 => self.constant(x / y),
            (_, Some(y)) if y.is_power_of_two() => self.shr(a, y.trailing_zeros()),
            _ => self.push(Op::Div(a, b), u64::MAX),
        }
    }

    pub fn rem(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) if y != 0 => self.constant(x % y),
            (_, Some(y)) if y.is_power_of_two() => {
                let m = self.constant(y - 1);
                self.and(a, m)
            }
            _ => self.push(Op::Rem(a, b), u64::MAX),
        }
    }

    pub fn count(&mut self, a: Id) -> Id {
        match self.value(a) {
            Some(n) => self.constant(n.count_ones().into()),
            None if self.possible_bits(a) == 1 => a,
            None => self.push(Op::Count(a), 127),
        }
    }

    /// A node made anew, with other operands, so that what has become constant folds.
    pub fn rebuild(&mut self, op: Op, may: u64, at: impl Fn(Id) -> Id) -> Id {
        match op {
            Op::Const(n) => self.constant(n),
            Op::Load(plane) => self.load(plane, may),
            Op::And(a, b) => self.and(at(a), at(b)),
            Op::AndNot(a, b) => self.and_not(at(a), at(b)),
            Op::Or(a, b) => self.or(at(a), at(b)),
            Op::Xor(a, b) => self.xor(at(a), at(b)),
            Op::Add(a, b) => self.add(at(a), at(b)),
            Op::Sub(a, b) => self.sub(at(a), at(b)),
            Op::Mul(a, b) => self.mul(at(a), at(b)),
            Op::MulHigh(a, b) => self.mul_high(at(a), at(b), false),
            Op::MulHighSigned(a, b) => self.mul_high(at(a), at(b), true),
            Op::Shl(a, n) => self.shl(at(a), n.into()),
            Op::Shr(a, n) => self.shr(at(a), n.into()),
            Op::ShlBy(a, b) => self.shl_by(at(a), at(b)),
            Op::ShrBy(a, b) => self.shr_by(at(a), at(b)),
            Op::SarBy(a, b) => self.sar_by(at(a), at(b)),
            Op::Eq(a, b) => self.eq(at(a), at(b)),
            Op::Less(a, b) => self.less(at(a), at(b)),
            Op::Select(a, b, c) => self.select(at(a), at(b), at(c)),
            Op::Div(a, b) => self.div(at(a), at(b)),
            Op::Rem(a, b) => self.rem(at(a), at(b)),
            Op::Count(a) => self.count(at(a)),
            Op::Element { slot, index, size, plane } => self.element(slot, at(index), size, plane, may),
        }
    }
}
