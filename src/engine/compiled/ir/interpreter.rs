//! What nodes are by the meaning of their operations alone, and numbers by chance: what tests of optimisations and of code
//! hold these against.

use crate::engine::compiled::ir::graph::{Graph, Id, Op};
use crate::random;

/// Numbers by chance.
pub(crate) struct Random(pub u64);

impl Random {
    pub fn word(&mut self) -> u64 {
        random::next(&mut self.0)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.word() % n as u64) as usize
    }
}

/// What every node is where memory holds these halves.
pub(crate) fn values(g: &Graph, memory: &[u64]) -> Vec<u64> {
    let mut all: Vec<u64> = Vec::new();
    for n in g.ids() {
        let v = |id: Id| all[id.index()];
        let value = match g.op(n) {
            Op::Const(n) => n,
            Op::Load(half) => memory[half as usize],
            Op::And(a, b) => v(a) & v(b),
            Op::AndNot(a, b) => v(a) & !v(b),
            Op::Or(a, b) => v(a) | v(b),
            Op::Xor(a, b) => v(a) ^ v(b),
            Op::Add(a, b) => v(a).wrapping_add(v(b)),
            Op::Sub(a, b) => v(a).wrapping_sub(v(b)),
            Op::Mul(a, b) => v(a).wrapping_mul(v(b)),
            Op::Shl(a, n) => v(a) << n,
            Op::Shr(a, n) => v(a) >> n,
            Op::Eq(a, b) => u64::from(v(a) == v(b)),
            Op::Less(a, b) => u64::from(v(a) < v(b)),
            Op::Select(s, a, b) => v(if v(s) == 1 { a } else { b }),
            Op::Element { slot, index, size: 3, plane } => {
                memory[(2 * slot + u32::from(plane)) as usize + 2 * v(index) as usize]
            }
            op => unreachable!("{op:?}"),
        };
        assert_eq!(value & !g.may(n), 0, "{:?} has bits that it may not have", g.op(n));
        all.push(value);
    }
    all
}
