//! Places in the engine's memory, which is a sequence of slots.

use std::ops::{Add, Sub};

/// A slot: one machine word of four values, that is two plane words side by side.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub(crate) struct Slot(u32);

/// One plane of a slot: 64 bits of values, or 64 bits that say which of them are unknown.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub(crate) struct PlaneWord(u32);

/// Slots that lie one after another.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Slots {
    pub start: Slot,
    /// The first that is not among them.
    pub end: Slot,
}

impl Slot {
    /// The slot with a number, which is a place in the engine's memory.
    pub fn at(index: usize) -> Slot {
        Slot(u32::try_from(index).expect("memory is limited to fewer slots"))
    }

    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Its plane of values.
    pub const fn value(self) -> PlaneWord {
        PlaneWord(2 * self.0)
    }

    /// Its plane that says what is unknown.
    pub const fn unknown(self) -> PlaneWord {
        PlaneWord(2 * self.0 + 1)
    }

    /// Plane 0, of values, or plane 1.
    pub fn plane(self, plane: u8) -> PlaneWord {
        if plane == 0 { self.value() } else { self.unknown() }
    }

    /// This and all after it.
    pub fn up(self) -> impl Iterator<Item = Slot> {
        (self.0..).map(Slot)
    }
}

impl PlaneWord {
    /// The plane word with a number, of which each slot has two.
    pub const fn at(number: u32) -> PlaneWord {
        PlaneWord(number)
    }

    pub const fn index(self) -> usize {
        self.0 as usize
    }

    pub const fn slot(self) -> Slot {
        Slot(self.0 / 2)
    }

    /// Whether it is the plane of values of its slot.
    pub const fn is_value(self) -> bool {
        self.0.is_multiple_of(2)
    }

    /// How far it lies behind another, in plane words.
    pub fn distance(self, from: PlaneWord) -> i64 {
        i64::from(self.0) - i64::from(from.0)
    }
}

impl Add<u32> for Slot {
    type Output = Slot;

    fn add(self, slots: u32) -> Slot {
        Slot(self.0 + slots)
    }
}

impl Sub for Slot {
    type Output = u32;

    fn sub(self, from: Slot) -> u32 {
        self.0 - from.0
    }
}

impl Add<u32> for PlaneWord {
    type Output = PlaneWord;

    fn add(self, words: u32) -> PlaneWord {
        PlaneWord(self.0 + words)
    }
}

impl Slots {
    pub fn contains(&self, slot: Slot) -> bool {
        self.start <= slot && slot < self.end
    }

    pub fn len(&self) -> usize {
        (self.end - self.start) as usize
    }

    pub fn iter(&self) -> impl Iterator<Item = Slot> + use<> {
        (self.start.0..self.end.0).map(Slot)
    }
}
