//! The [algebra](crate::cell::Algebra) of nodes: what a cell computes becomes operations of the graph.

use super::four::{Bits, Two};
use crate::cell::{Algebra, Site};
use crate::compiled::ir::graph::{Graph, Id};

impl Algebra for Graph {
    type Plane = Id;
    type Word = Two;
    const BITS: u32 = 64;

    fn word(v: Id, u: Id) -> Two {
        Two { v, u }
    }

    fn planes(w: Two) -> (Id, Id) {
        (w.v, w.u)
    }

    fn constant(&mut self, bits: u64) -> Id {
        Graph::constant(self, bits)
    }

    fn and(&mut self, a: Id, b: Id) -> Id {
        Graph::and(self, a, b)
    }

    fn or(&mut self, a: Id, b: Id) -> Id {
        Graph::or(self, a, b)
    }

    fn xor(&mut self, a: Id, b: Id) -> Id {
        Graph::xor(self, a, b)
    }

    fn and_not(&mut self, a: Id, b: Id) -> Id {
        Graph::and_not(self, a, b)
    }

    fn shl(&mut self, a: Id, n: u32) -> Id {
        Graph::shl(self, a, n)
    }

    fn shr(&mut self, a: Id, n: u32) -> Id {
        Graph::shr(self, a, n)
    }

    fn bits(&mut self, a: Id, lo: u32, n: u32) -> Id {
        Graph::bits(self, a, lo, n)
    }

    fn shl_by(&mut self, a: Id, n: Id) -> Id {
        Graph::shl_by(self, a, n)
    }

    fn shr_by(&mut self, a: Id, n: Id) -> Id {
        Graph::shr_by(self, a, n)
    }

    fn any(&mut self, a: Id) -> Id {
        Graph::any(self, a)
    }

    fn parity(&mut self, a: Id) -> Id {
        let n = self.count(a);
        Graph::bits(self, n, 0, 1)
    }

    fn several(&mut self, a: Id) -> Id {
        if self.possible_bits(a).count_ones() < 2 {
            return Graph::constant(self, 0);
        }
        let one = Graph::constant(self, 1);
        let less = Graph::sub(self, a, one);
        let rest = Graph::and(self, a, less);
        Graph::any(self, rest)
    }

    fn equal(&mut self, a: Id, b: Id) -> Id {
        self.eq(a, b)
    }

    fn less(&mut self, a: Id, b: Id) -> Id {
        Graph::less(self, a, b)
    }

    fn select(&mut self, s: Id, a: Id, b: Id) -> Id {
        Graph::select(self, s, a, b)
    }

    fn splat(&mut self, s: Id, mask: u64) -> Id {
        Graph::splat(self, s, mask)
    }

    fn add(&mut self, a: Id, b: Id, carry: Id, bits: u32) -> (Id, Id) {
        let s = Graph::add(self, a, b);
        let y = Graph::add(self, s, carry);
        let out = if bits < 64 {
            Graph::bits(self, y, bits, 1)
        } else {
            let (c1, c2) = (Graph::less(self, s, a), Graph::less(self, y, s));
            Graph::or(self, c1, c2)
        };
        (Graph::bits(self, y, 0, bits), out)
    }

    fn sub(&mut self, a: Id, b: Id, borrow: Id, bits: u32) -> (Id, Id) {
        let d = Graph::sub(self, a, b);
        let y = Graph::sub(self, d, borrow);
        let out = if bits < 64 {
            Graph::bits(self, y, 63, 1)
        } else {
            let (c1, c2) = (Graph::less(self, a, b), Graph::less(self, d, borrow));
            Graph::or(self, c1, c2)
        };
        (Graph::bits(self, y, 0, bits), out)
    }

    fn mul_add(&mut self, a: Id, b: Id, c: Id, d: Id) -> (Id, Id) {
        if self.is(a, 0) || self.is(b, 0) {
            let none = Graph::constant(self, 0);
            return Algebra::add(self, c, d, none, 64);
        }
        let low = self.mul(a, b);
        let first = Graph::add(self, low, c);
        let second = Graph::add(self, first, d);
        // the high word of a product of numbers that together have no more bits than a word is 0
        let fits = self.possible_bits(a).leading_zeros() + self.possible_bits(b).leading_zeros() >= 64;
        let high = if fits { Graph::constant(self, 0) } else { self.mul_high(a, b, false) };
        let (c1, c2) = (Graph::less(self, first, c), Graph::less(self, second, d));
        let high = Graph::add(self, high, c1);
        (second, Graph::add(self, high, c2))
    }

    fn mul_signed(&mut self, a: Id, b: Id) -> Option<(Id, Id)> {
        Some((self.mul(a, b), self.mul_high(a, b, true)))
    }

    fn quotient(&mut self, a: Id, b: Id) -> Option<(Id, Id)> {
        Some((self.div(a, b), self.rem(a, b)))
    }

    fn known(&self, a: Id) -> Option<u64> {
        self.value(a)
    }

    fn exclusive(&self, truths: &[Id]) -> bool {
        Graph::exclusive(self, truths)
    }

    fn exhaustive(&self, truths: &[Id]) -> bool {
        Graph::exhaustive(self, truths)
    }
}

/// The pins of a cell as vectors; those that are not asked for may have no words.
pub(super) struct Place<'s> {
    pub ins: &'s [Bits],
    pub q: &'s [Two],
    pub outs: Vec<Bits>,
}

impl Place<'_> {
    pub fn new<'s>(ins: &'s [Bits], q: &'s [Two]) -> Place<'s> {
        Place { ins, q, outs: Vec::new() }
    }
}

impl Site<Graph> for Place<'_> {
    fn get(&self, pin: usize, i: usize) -> Two {
        self.ins[pin][i]
    }

    fn state(&self, i: usize) -> Two {
        self.q[i]
    }

    fn put(&mut self, output: usize, i: usize, w: Two) {
        if self.outs.len() <= output {
            self.outs.resize_with(output + 1, Vec::new);
        }
        debug_assert_eq!(self.outs[output].len(), i, "words come in order");
        self.outs[output].push(w);
    }

    fn hold(&mut self) {
        self.outs = vec![self.q.to_vec()];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::agree::{Case, cases};
    use crate::cell::{act, at_edge, derived, level};
    use crate::compiled::ir::interpreter::values;
    use crate::compiled::ir::places::Slot;
    use crate::value::Word;
    use crate::value::word::{word_mask, words};

    /// The vectors of a case as loads, or as constants, and what memory holds then.
    fn vectors(g: &mut Graph, case: &Case, constant: bool) -> (Vec<Bits>, Bits, Vec<u64>) {
        let mut memory = Vec::new();
        let mut vector = |words_of: &[Word], width: u32| -> Bits {
            let words = words_of.iter().enumerate().map(|(i, w)| {
                let m = if width == 0 { 0 } else { word_mask(width, i) };
                if constant {
                    return g.literal(*w);
                }
                let slot = Slot::at(memory.len() / 2);
                memory.extend([w.v, w.u]);
                // that something is known for good is as that it happens to be
                let u =
                    if w.u == 0 && slot.index().is_multiple_of(2) { g.constant(0) } else { g.load(slot.unknown(), m) };
                Two { v: g.load(slot.value(), m), u }
            });
            words.collect()
        };
        let kind = &case.kind;
        let ins = (0..kind.inputs().len()).map(|pin| vector(&case.ins[pin], kind.input_width(pin))).collect();
        let width = if case.state.is_empty() { 0 } else { kind.output_width(0) };
        let state = vector(&case.state, width);
        (ins, state, memory)
    }

    #[test]
    fn nodes_are_as_machine_words() {
        for case in cases(false, 130) {
            let kind = &case.kind;
            let expected = case.expected();
            for constant in [false, true] {
                let mut g = Graph::default();
                let (ins, q, memory) = vectors(&mut g, &case, constant);
                let mut outs = if q.is_empty() {
                    let mut place = Place::new(&ins, &q);
                    act(&mut g, kind, &mut place);
                    place.outs
                } else {
                    let mut place = Place::new(&ins, &q);
                    level(&mut g, kind, &mut place);
                    let new = place.outs.swap_remove(0);
                    let mut place = Place::new(&ins, &new);
                    derived(&mut g, kind, &mut place);
                    let second = place.outs.into_iter().nth(1);
                    std::iter::once(new).chain(second).collect()
                };
                let mut request = expected.outputs.clone();
                if !q.is_empty() {
                    let mut place = Place::new(&ins, &q);
                    at_edge(&mut g, kind, None, &mut place);
                    outs.extend(place.outs);
                    request.push(expected.next.clone());
                }
                let all = values(&g, &memory);
                let found: Vec<Vec<Word>> = outs
                    .iter()
                    .map(|words| words.iter().map(|w| Word { v: all[w.v.index()], u: all[w.u.index()] }).collect())
                    .collect();
                assert_eq!(found, request, "{kind:?} of {:?}, {:?}", case.ins, case.state);
                if constant {
                    let folded = outs.iter().flatten().all(|w| g.value(w.v).is_some() && g.value(w.u).is_some());
                    assert!(folded, "{kind:?} of constants is one");
                }
            }
            assert_eq!(words(kind.output_width(0)), expected.outputs[0].len());
        }
    }
}
