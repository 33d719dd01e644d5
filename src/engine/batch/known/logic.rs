//! Functions of known bits as a graph: each node is one function of up to three others, equal nodes are shared.
//!
//! A function of three inputs is a table of eight bits: bit `4a + 2b + c` is its value at `a`, `b`, `c`, as the vector
//! instruction for three inputs has it. So an inverter, a constant input or an input that is there twice costs nothing:
//! it is another table.

use std::collections::HashMap;

/// A node of a [`Logic`], or its inverse.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Lit(u32);

impl Lit {
    pub const FALSE: Lit = Lit(0);
    pub const TRUE: Lit = Lit(1);

    pub fn constant(bit: bool) -> Lit {
        Lit(u32::from(bit))
    }

    pub fn node(self) -> usize {
        self.0 as usize >> 1
    }

    pub fn inverted(self) -> bool {
        self.0 & 1 == 1
    }

    pub fn invert_if(self, inverted: bool) -> Lit {
        Lit(self.0 ^ u32::from(inverted))
    }
}

impl std::ops::Not for Lit {
    type Output = Lit;

    fn not(self) -> Lit {
        self.invert_if(true)
    }
}

/// What a node is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Node {
    /// 0.
    Zero,
    /// A plane that is there.
    Source(u32),
    /// A table and the nodes that it is a table of, in its order; those that it does not depend on are 0.
    Table(u8, [u32; 3]),
}

const A: u8 = 0xf0;
const B: u8 = 0xcc;
const C: u8 = 0xaa;
const VARIABLES: [u8; 3] = [A, B, C];

/// A table with an input fixed, for all values of that input.
pub(super) fn fixed(t: u8, input: usize, bit: bool) -> u8 {
    let shift = [4, 2, 1][input];
    let half = if bit { t & VARIABLES[input] } else { t & !VARIABLES[input] };
    if bit { half | half >> shift } else { half | half << shift }
}

/// A table with an input inverted.
pub(super) fn inverted(t: u8, input: usize) -> u8 {
    fixed(t, input, true) & !VARIABLES[input] | fixed(t, input, false) & VARIABLES[input]
}

pub(super) fn depends(t: u8, input: usize) -> bool {
    fixed(t, input, false) != fixed(t, input, true)
}

/// The table over other inputs: `places[i]` is where input `i` stands now.
pub(super) fn moved(t: u8, places: [usize; 3]) -> u8 {
    (0..8u8).fold(0, |all, i| {
        let old = (0..3).fold(0, |old, k| old << 1 | i >> (2 - places[k]) & 1);
        all | (t >> old & 1) << i
    })
}

/// A graph.
pub struct Logic {
    pub(super) nodes: Vec<Node>,
    numbers: HashMap<Node, u32>,
    /// The first node of the cell that is being made: only through these are functions joined. What cells give may lie in
    /// planes that hold a state, and whoever reads that state must not come after it has been written.
    own: usize,
}

impl Default for Logic {
    fn default() -> Logic {
        Logic { nodes: vec![Node::Zero], numbers: HashMap::new(), own: usize::MAX }
    }
}

impl Logic {
    /// A cell is made from here on.
    pub(super) fn begin_cell(&mut self) {
        self.own = self.nodes.len();
    }

    fn number(&mut self, node: Node) -> u32 {
        let nodes = &mut self.nodes;
        *self.numbers.entry(node).or_insert_with(|| {
            nodes.push(node);
            nodes.len() as u32 - 1
        })
    }

    /// What stands in a plane.
    pub fn source(&mut self, plane: u32) -> Lit {
        Lit(self.number(Node::Source(plane)) << 1)
    }

    /// A function of three, by its table.
    pub fn table(&mut self, mut t: u8, ins: [Lit; 3]) -> Lit {
        for (i, lit) in ins.into_iter().enumerate() {
            if lit.inverted() {
                t = inverted(t, i);
            }
            if lit.node() == 0 {
                t = fixed(t, i, false);
            }
        }
        // of equal inputs the first is all
        for (i, k) in [(0, 1), (0, 2), (1, 2)] {
            if ins[i].node() == ins[k].node() {
                t = fixed(t, k, false) & !VARIABLES[i] | fixed(t, k, true) & VARIABLES[i];
            }
        }
        let mut used: Vec<(u32, usize)> =
            (0..3).filter(|&i| depends(t, i)).map(|i| (ins[i].node() as u32, i)).collect();
        used.sort_unstable();
        let mut places = [usize::MAX; 3];
        used.iter().enumerate().for_each(|(to, &(_, from))| places[from] = to);
        let mut free = used.len()..3;
        for place in &mut places {
            if *place == usize::MAX {
                *place = free.next().unwrap_or(2);
            }
        }
        t = moved(t, places);
        let out = t & 1 == 1;
        if out {
            t = !t;
        }
        let lit = match (used.len(), t) {
            (0, _) => Lit::FALSE,
            (1, _) => Lit(used[0].0 << 1),
            _ => {
                let node = |i: usize| used.get(i).map_or(0, |u| u.0);
                Lit(self.number(Node::Table(t, [0, 1, 2].map(node))) << 1)
            }
        };
        lit.invert_if(out)
    }

    pub fn and(&mut self, a: Lit, b: Lit) -> Lit {
        match (a, b) {
            (Lit::FALSE, _) | (_, Lit::FALSE) => Lit::FALSE,
            (Lit::TRUE, other) | (other, Lit::TRUE) => other,
            _ => self.two(A & B, a, b),
        }
    }

    pub fn or(&mut self, a: Lit, b: Lit) -> Lit {
        !self.and(!a, !b)
    }

    pub fn xor(&mut self, a: Lit, b: Lit) -> Lit {
        match (a, b) {
            (Lit::FALSE, other) | (other, Lit::FALSE) => other,
            (Lit::TRUE, other) | (other, Lit::TRUE) => !other,
            _ => self.two(A ^ B, a, b),
        }
    }

    /// A function of two, by its table over the first two of three inputs; of what those are functions of where that is
    /// no more than three.
    fn two(&mut self, t: u8, a: Lit, b: Lit) -> Lit {
        let own = |lit: Lit| ([lit.node() as u32, 0, 0], 1, if lit.inverted() { !A } else { A });
        let inner = |logic: &Logic, lit: Lit| match logic.nodes[lit.node()] {
            Node::Table(t, ins) if lit.node() >= logic.own => {
                let used = (0..3).filter(|&i| depends(t, i)).count();
                Some((ins, used, if lit.inverted() { !t } else { t }))
            }
            Node::Table(..) | Node::Zero | Node::Source(_) => None,
        };
        let (of_a, of_b) = (inner(self, a), inner(self, b));
        for (x, y) in [(of_a, of_b), (of_a, Some(own(b))), (Some(own(a)), of_b)] {
            let (Some((x, n, tx)), Some((y, m, ty))) = (x, y) else { continue };
            let (mut all, mut count) = (x, n);
            let mut places = [usize::MAX; 3];
            for (i, &node) in y[..m].iter().enumerate() {
                let at = all[..count].iter().position(|&other| other == node);
                if at.is_none() && count == 3 {
                    count = 4;
                    break;
                }
                places[i] = at.unwrap_or(count);
                if at.is_none() {
                    all[count] = node;
                    count += 1;
                }
            }
            if count > 3 {
                continue;
            }
            let mut free = (0..3).filter(|place| !places[..m].contains(place)).collect::<Vec<usize>>().into_iter();
            for place in places.iter_mut().skip(m) {
                *place = free.next().unwrap_or(2);
            }
            let ty = moved(ty, places);
            // bit by bit of both tables what `t` says of them
            let joined = (0..8u8).fold(0, |all, i| {
                let at = (tx >> i & 1) << 2 | (ty >> i & 1) << 1;
                all | (t >> at & 1) << i
            });
            let ins = [0, 1, 2].map(|i| if i < count { Lit(all[i] << 1) } else { Lit::FALSE });
            return self.table(joined, ins);
        }
        self.table(t, [a, b, Lit::FALSE])
    }

    pub fn xor3(&mut self, a: Lit, b: Lit, c: Lit) -> Lit {
        self.table(A ^ B ^ C, [a, b, c])
    }

    pub fn majority(&mut self, a: Lit, b: Lit, c: Lit) -> Lit {
        self.table(A & B | C & (A | B), [a, b, c])
    }

    /// `a` where `s` is 0, else `b`.
    pub fn choose(&mut self, s: Lit, a: Lit, b: Lit) -> Lit {
        self.table(A & C | !A & B, [s, a, b])
    }

    pub fn any(&mut self, all: &[Lit]) -> Lit {
        all.iter().fold(Lit::FALSE, |any, &bit| self.or(any, bit))
    }

    /// `a + b + carry`; the sum and what is carried out of it.
    pub fn add(&mut self, a: &[Lit], b: &[Lit], carry: Lit) -> (Vec<Lit>, Lit) {
        let mut carry = carry;
        let sum = a.iter().zip(b).map(|(&a, &b)| {
            let sum = self.xor3(a, b, carry);
            carry = self.majority(a, b, carry);
            sum
        });
        (sum.collect(), carry)
    }
}

#[cfg(test)]
impl Logic {
    /// What a literal is where these are the planes.
    pub(super) fn value(&self, lit: Lit, planes: &[bool]) -> bool {
        let mut all: Vec<bool> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes[..=lit.node()] {
            all.push(match *node {
                Node::Zero => false,
                Node::Source(plane) => planes[plane as usize],
                Node::Table(t, ins) => t >> ins.iter().fold(0, |at, &i| at << 1 | u8::from(all[i as usize])) & 1 == 1,
            });
        }
        all[lit.node()] != lit.inverted()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(logic: &Logic, lit: Lit, planes: u8) -> bool {
        logic.value(lit, &[0, 1, 2].map(|i| planes >> i & 1 == 1))
    }

    #[test]
    fn every_function_of_every_choice_of_inputs_is_what_its_table_says() {
        let mut logic = Logic::default();
        let sources: Vec<Lit> = (0..3).map(|i| logic.source(i)).collect();
        let mut all = vec![Lit::FALSE, Lit::TRUE];
        all.extend(sources.iter().flat_map(|&s| [s, !s]));
        for t in 0..=255 {
            for &a in &all {
                for &b in &all {
                    for &c in &all {
                        let y = logic.table(t, [a, b, c]);
                        for planes in 0..8 {
                            let at = [a, b, c].iter().fold(0, |at, &l| at << 1 | u8::from(value(&logic, l, planes)));
                            assert_eq!(value(&logic, y, planes), t >> at & 1 == 1, "{t:02x} {a:?} {b:?} {c:?}");
                        }
                    }
                }
            }
        }
        // 256 functions of three inputs, half of them inverses, less the constant and the inputs
        assert_eq!(logic.nodes.len() - 4, 128 - 4);
    }
}
