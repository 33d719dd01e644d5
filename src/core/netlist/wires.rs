//! Which bits of a builder are one: wires that were joined after they were declared.

use super::bus::{Bus, Part};

/// Sets of bits that are one.
#[derive(Default)]
pub(super) struct Wires {
    pairs: Vec<(u32, u32)>,
}

impl Wires {
    /// Makes two buses of one width one.
    pub(super) fn join(&mut self, a: &Bus, b: &Bus) {
        debug_assert_eq!(a.width(), b.width());
        self.pairs.extend(a.bits().zip(b.bits()).filter(|(a, b)| a != b));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// For each of so many bits the one that stands for all that are one with it: the first.
    pub(super) fn roots(self, bits: u32) -> Vec<u32> {
        let mut root: Vec<u32> = (0..bits).collect();
        let find = |root: &mut [u32], mut bit: u32| {
            while root[bit as usize] != bit {
                let up = root[root[bit as usize] as usize];
                root[bit as usize] = up;
                bit = up;
            }
            bit
        };
        for (a, b) in self.pairs {
            let (a, b) = (find(&mut root, a), find(&mut root, b));
            root[a.max(b) as usize] = a.min(b);
        }
        // a root comes before what it stands for, so one pass is enough
        for bit in 0..bits as usize {
            root[bit] = root[root[bit] as usize];
        }
        root
    }
}

impl Bus {
    /// The same bits by their roots.
    pub(super) fn rooted(&mut self, root: &[u32]) {
        let moved = |p: &Part| (p.bit..p.bit + p.width).any(|bit| root[bit as usize] != bit);
        if self.parts.iter().any(moved) {
            let mut bus = Bus::default();
            self.bits().for_each(|bit| bus.push(root[bit as usize]));
            *self = bus;
        }
    }
}
