//! Vectors of bits of a netlist under construction.

/// A vector of bits of a netlist under construction; cheap to clone, bit 0 first.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Bus {
    pub(super) parts: Vec<Part>,
}

/// `width` bits from bit number `bit` of the builder.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Part {
    pub(super) bit: u32,
    pub(super) width: u32,
}

impl Bus {
    /// Bits.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.parts.iter().map(|p| p.width).sum()
    }

    /// `width` bits from bit `lo` up.
    ///
    /// # Panics
    /// If the bus has no such bits.
    #[must_use]
    pub fn slice(&self, lo: u32, width: u32) -> Bus {
        assert!(
            lo.checked_add(width).is_some_and(|end| end <= self.width()),
            "bits {lo}+{width} of a bus of {}",
            self.width()
        );
        let mut parts = Vec::new();
        let (mut skip, mut left) = (lo, width);
        for p in &self.parts {
            if left == 0 {
                break;
            }
            if skip >= p.width {
                skip -= p.width;
                continue;
            }
            let take = (p.width - skip).min(left);
            parts.push(Part { bit: p.bit + skip, width: take });
            left -= take;
            skip = 0;
        }
        Bus { parts }
    }

    /// One bit.
    ///
    /// # Panics
    /// If the bus has no such bit.
    #[must_use]
    pub fn bit(&self, index: u32) -> Bus {
        self.slice(index, 1)
    }

    /// Adds bits above these.
    pub fn append(&mut self, high: &Bus) {
        for &p in &high.parts {
            match self.parts.last_mut() {
                Some(last) if last.bit + last.width == p.bit => last.width += p.width,
                _ => self.parts.push(p),
            }
        }
    }

    /// Buses one after another, the first in the low bits.
    #[must_use]
    pub fn concat<'a>(low_first: impl IntoIterator<Item = &'a Bus>) -> Bus {
        let mut all = Bus::default();
        for bus in low_first {
            all.append(bus);
        }
        all
    }

    /// How many runs of adjacent bits it is made of.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.parts.len()
    }

    /// One bit, by its number in the builder.
    #[must_use]
    pub fn of_bit(bit: u32) -> Bus {
        Bus { parts: vec![Part { bit, width: 1 }] }
    }

    /// Adds one bit above these, by its number in the builder.
    pub fn push(&mut self, bit: u32) {
        match self.parts.last_mut() {
            Some(last) if last.bit + last.width == bit => last.width += 1,
            _ => self.parts.push(Part { bit, width: 1 }),
        }
    }

    /// The bits, the lowest first, as the builder numbers them.
    pub fn bits(&self) -> impl Iterator<Item = u32> + '_ {
        self.parts.iter().flat_map(|p| p.bit..p.bit + p.width)
    }
}
