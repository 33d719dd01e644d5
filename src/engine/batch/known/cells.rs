//! What cells do to known bits: their meaning in an algebra of functions. A word is one bit, its planes are functions;
//! what comes of known operands has an unknown plane that is 0 wherever nothing is x. Where it is not, a guard says so.

use super::logic::{Lit, Logic};
use crate::batch::build::lanewise;
use crate::cell::{Algebra, CellKind, Site, act, at_edge, derived, level};

/// The most operations that a cell may take: beyond it lane by lane is no slower.
const MOST: u64 = 1 << 16;

/// Whether there is a form of a cell here; `acts` tells whether a pin may ever be other than 0. A state must not become x
/// for good.
pub(super) fn has_form(kind: &CellKind, acts: impl Fn(usize) -> bool) -> bool {
    lanewise(kind).is_some_and(|cell| cell.known && cell.steps <= MOST)
        && (kind.storage().is_none() || kind.keeps_known(acts))
}

/// One bit: its value and where that is unknown.
#[derive(Clone, Copy, Debug)]
pub struct Bit {
    v: Lit,
    u: Lit,
}

impl Algebra for Logic {
    type Plane = Lit;
    type Word = Bit;
    const BITS: u32 = 1;

    fn word(v: Lit, u: Lit) -> Bit {
        Bit { v, u }
    }

    fn planes(w: Bit) -> (Lit, Lit) {
        (w.v, w.u)
    }

    fn constant(&mut self, bits: u64) -> Lit {
        Lit::constant(bits & 1 == 1)
    }

    fn and(&mut self, a: Lit, b: Lit) -> Lit {
        Logic::and(self, a, b)
    }

    fn or(&mut self, a: Lit, b: Lit) -> Lit {
        Logic::or(self, a, b)
    }

    fn xor(&mut self, a: Lit, b: Lit) -> Lit {
        Logic::xor(self, a, b)
    }

    fn and_not(&mut self, a: Lit, b: Lit) -> Lit {
        Logic::and(self, a, !b)
    }

    fn shl(&mut self, a: Lit, _: u32) -> Lit {
        a
    }

    fn shr(&mut self, a: Lit, _: u32) -> Lit {
        a
    }

    fn shl_by(&mut self, a: Lit, _: Lit) -> Lit {
        a
    }

    fn shr_by(&mut self, a: Lit, _: Lit) -> Lit {
        a
    }

    fn any(&mut self, a: Lit) -> Lit {
        a
    }

    fn parity(&mut self, a: Lit) -> Lit {
        a
    }

    fn several(&mut self, _: Lit) -> Lit {
        Lit::FALSE
    }

    fn equal(&mut self, a: Lit, b: Lit) -> Lit {
        !Logic::xor(self, a, b)
    }

    fn less(&mut self, a: Lit, b: Lit) -> Lit {
        Logic::and(self, !a, b)
    }

    fn select(&mut self, s: Lit, a: Lit, b: Lit) -> Lit {
        self.choose(s, b, a)
    }

    fn splat(&mut self, s: Lit, mask: u64) -> Lit {
        if mask & 1 == 1 { s } else { Lit::FALSE }
    }

    fn add(&mut self, a: Lit, b: Lit, carry: Lit, _: u32) -> (Lit, Lit) {
        (self.xor3(a, b, carry), self.majority(a, b, carry))
    }

    fn mul_add(&mut self, a: Lit, b: Lit, c: Lit, d: Lit) -> (Lit, Lit) {
        let product = Logic::and(self, a, b);
        (self.xor3(product, c, d), self.majority(product, c, d))
    }

    fn known(&self, a: Lit) -> Option<u64> {
        match a {
            Lit::FALSE => Some(0),
            Lit::TRUE => Some(1),
            _ => None,
        }
    }
}

/// A cell with the functions at its pins and of its state, and what it gives.
struct Place<'s> {
    pins: &'s [Vec<Lit>],
    q: &'s [Lit],
    outs: Vec<Vec<Lit>>,
    /// What is not 0 where something that it gives is x or z.
    unknown: Vec<Lit>,
}

impl<'s> Place<'s> {
    fn new(pins: &'s [Vec<Lit>], q: &'s [Lit]) -> Place<'s> {
        Place { pins, q, outs: vec![Vec::new(); 3], unknown: Vec::new() }
    }
}

impl Site<Logic> for Place<'_> {
    fn get(&self, pin: usize, i: usize) -> Bit {
        Bit { v: self.pins[pin][i], u: Lit::FALSE }
    }

    fn state(&self, i: usize) -> Bit {
        Bit { v: self.q[i], u: Lit::FALSE }
    }

    fn put(&mut self, output: usize, _: usize, w: Bit) {
        self.outs[output].push(w.v);
        if w.u != Lit::FALSE {
            self.unknown.push(w.u);
        }
    }

    fn hold(&mut self) {
        self.outs[0] = self.q.to_vec();
    }
}

/// The outputs of a cell without a state. What it gives where `guard` is 1 is not known.
pub(super) fn outputs(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], guard: &mut Lit) -> Vec<Vec<Lit>> {
    let mut place = Place::new(pins, &[]);
    l.begin_cell();
    act(l, kind, &mut place);
    for u in place.unknown {
        *guard = Logic::or(l, *guard, u);
    }
    place.outs
}

/// The state of a cell after its levels have acted on it. It is one that keeps what is known.
pub(super) fn after_levels(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit]) -> Vec<Lit> {
    let mut place = Place::new(pins, q);
    l.begin_cell();
    level(l, kind, &mut place);
    place.outs.swap_remove(0)
}

/// The output that is made from the state.
pub(super) fn from_state(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit]) -> Vec<Lit> {
    let mut place = Place::new(pins, q);
    l.begin_cell();
    derived(l, kind, &mut place);
    place.outs.swap_remove(1)
}

/// What a cell with a clock takes at its edge in the lanes of `when`.
pub(super) fn sampled(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit], when: Lit) -> Vec<Lit> {
    let mut place = Place::new(pins, q);
    l.begin_cell();
    at_edge(l, kind, Some(when), &mut place);
    place.outs.swap_remove(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::agree::{bit, cases};
    use crate::value::Word;

    /// Pins that are planes, and what lies in those.
    fn sources(l: &mut Logic, planes: &mut Vec<bool>, words: &[Word], width: u32) -> Vec<Lit> {
        (0..width)
            .map(|i| {
                planes.push(bit(words, i).v == 1);
                l.source(planes.len() as u32 - 1)
            })
            .collect()
    }

    #[test]
    fn functions_are_as_machine_words_and_a_guard_tells_of_x() {
        for case in cases(true, 65) {
            let kind = &case.kind;
            let expected = case.expected();
            let (mut l, mut planes) = (Logic::default(), Vec::new());
            let pins: Vec<Vec<Lit>> = (0..kind.inputs().len())
                .map(|pin| sources(&mut l, &mut planes, &case.ins[pin], kind.input_width(pin)))
                .collect();
            let check = |l: &Logic, found: &[Lit], wanted: &[Word]| {
                for (i, &lit) in found.iter().enumerate() {
                    let wanted = bit(wanted, i as u32);
                    assert_eq!(l.value(lit, &planes), wanted.v == 1, "bit {i} of {kind:?} of {:?}", case.ins);
                }
            };
            if case.state.is_empty() {
                let mut guard = Lit::FALSE;
                let outs = outputs(&mut l, kind, &pins, &mut guard);
                let unknown = expected.outputs.iter().flatten().any(|w| w.u != 0);
                assert_eq!(l.value(guard, &planes), unknown, "the guard of {kind:?} of {:?}", case.ins);
                assert!(guard == Lit::FALSE || !kind.keeps_known(|_| true), "{kind:?} needs no guard");
                if !unknown {
                    outs.iter().zip(&expected.outputs).for_each(|(found, wanted)| check(&l, found, wanted));
                }
                continue;
            }
            if !kind.keeps_known(|_| true) {
                continue;
            }
            let mut own = planes.clone();
            let q = sources(&mut l, &mut own, &case.state, kind.output_width(0));
            let check = |l: &Logic, found: &[Lit], wanted: &[Word], what: &str| {
                for (i, &lit) in found.iter().enumerate() {
                    let wanted = bit(wanted, i as u32).v == 1;
                    assert_eq!(l.value(lit, &own), wanted, "{what}, bit {i} of {kind:?} of {:?}", case.ins);
                }
            };
            let new = after_levels(&mut l, kind, &pins, &q);
            check(&l, &new, &expected.outputs[0], "levels");
            if let Some(wanted) = expected.outputs.get(1) {
                let second = from_state(&mut l, kind, &pins, &new);
                check(&l, &second, wanted, "derived");
            }
            let next = sampled(&mut l, kind, &pins, &q, Lit::TRUE);
            check(&l, &next, &expected.next, "edge");
            let kept = sampled(&mut l, kind, &pins, &q, Lit::FALSE);
            check(&l, &kept, &case.state, "no edge");
        }
    }
}
