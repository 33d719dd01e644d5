//! What the fields of records are to the slots of a waveform, worked out once for each shape.
//!
//! Which kind of value changes next cannot be foreseen, so placing one has no branches: what a field of each kind does to
//! a word is a few masks.

use super::batch::{Part, Shape};
use crate::value::Word;
use crate::value::changes::Written;

/// Numbers of slots, each once: a bit for each slot, and one for each word of these that may have any.
#[derive(Default)]
pub(super) struct Touched {
    pub bits: Vec<u64>,
    pub summary: Vec<u64>,
}

impl Touched {
    pub fn new(slots: usize) -> Touched {
        let words = slots.div_ceil(64);
        Touched { bits: vec![0; words], summary: vec![0; words.div_ceil(64)] }
    }

    #[inline(always)]
    pub fn insert(&mut self, slot: usize) {
        self.bits[slot / 64] |= 1 << (slot % 64);
        self.summary[slot / 4096] |= 1 << (slot / 64 % 64);
    }
}

/// The fields of a shape.
#[derive(Default)]
pub(super) struct Fields {
    places: Vec<Place>,
    /// Parts of fields that are several, or whose bits are to be moved.
    parts: Vec<(Place, Part)>,
    /// The words of [`Touched`] that a record may have any bits of.
    summary: Vec<(u32, u64)>,
}

/// What a field does to a word among the values of all slots.
#[derive(Clone, Copy, Default)]
struct Place {
    at: u32,
    /// Where the bit of the slot is.
    word: u32,
    bit: u64,
    /// What stays of the word, what becomes the other, and what is taken of the values.
    keep: u64,
    toggle: u64,
    take: [u64; 2],
    /// How many values it has in a record.
    size: u32,
    /// What is to be done beside this: so many parts.
    first: u32,
    count: u32,
}

impl Place {
    #[inline(always)]
    fn put(&self, current: &mut [Word], touched: &mut Touched, v: u64, u: u64) {
        let word = &mut current[self.at as usize];
        word.v = (word.v & self.keep ^ self.toggle) | v & self.take[0];
        word.u = word.u & self.keep | u & self.take[1];
        touched.bits[self.word as usize] |= self.bit;
    }
}

impl Fields {
    /// `at` gives the slot of a variable and where its words begin.
    pub fn new(shape: &Shape, at: impl Fn(u32) -> (u32, u32)) -> Fields {
        let mut fields = Fields::default();
        for (number, &(written, _)) in shape.fields.iter().enumerate() {
            let parts = shape.parts(number);
            let place = |part: &Part| {
                let (mask, (slot, start)) = (part.mask() << part.to, at(part.var));
                let (keep, toggle, take) = match written {
                    Written::Toggled => (!0, 1 << part.to, [0, 0]),
                    Written::Known => (!mask, 0, [mask, 0]),
                    Written::Both => (!mask, 0, [mask, mask]),
                };
                let (at, word, bit) = (start + part.word, slot / 64, 1 << (slot % 64));
                Place { at, word, bit, keep, toggle, take, ..Place::default() }
            };
            for part in parts {
                let slot = at(part.var).0;
                let (i, mask) = (slot / 4096, 1 << (slot / 64 % 64));
                match fields.summary.iter_mut().find(|(at, _)| *at == i) {
                    Some((_, all)) => *all |= mask,
                    None => fields.summary.push((i, mask)),
                }
            }
            let mut whole = match parts {
                [part] if part.from == part.to || written == Written::Toggled => place(part),
                _ => {
                    let (first, count) = (fields.parts.len() as u32, parts.len() as u32);
                    fields.parts.extend(parts.iter().map(|part| (place(part), *part)));
                    Place { keep: !0, first, count, ..Place::default() }
                }
            };
            whole.size = written.size() as u32;
            fields.places.push(whole);
        }
        fields
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Takes over what a record has changed; returns how many values it has.
    #[inline(always)]
    pub fn put(&self, bits: &[u64], values: &[u64], current: &mut [Word], touched: &mut Touched) -> usize {
        let mut used = 0;
        for (&word, places) in bits.iter().zip(self.places.chunks(64)) {
            // the first field is the highest bit; from the lowest up is quicker
            let mut bits = word.reverse_bits();
            while bits != 0 {
                let place = &places[bits.trailing_zeros() as usize];
                bits &= bits - 1;
                // what stands there may belong to the next one, or to nobody: then nothing of it is taken
                let [v, u] = match values.get(used..).and_then(|rest| rest.first_chunk()) {
                    Some(two) => *two,
                    None => [values.get(used).copied().unwrap_or(0), 0],
                };
                place.put(current, touched, v, u);
                if place.count != 0 {
                    self.put_parts(place, [v, u], current, touched);
                }
                used += place.size as usize;
            }
        }
        for &(i, mask) in &self.summary {
            touched.summary[i as usize] |= mask;
        }
        used
    }

    #[inline(never)]
    fn put_parts(&self, place: &Place, [v, u]: [u64; 2], current: &mut [Word], touched: &mut Touched) {
        for (place, Part { from, to, .. }) in &self.parts[place.first as usize..][..place.count as usize] {
            place.put(current, touched, v >> from << to, u >> from << to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::changes;

    /// A field that is no part of anything, one that is two parts, and one behind them that comes before in the layout.
    #[test]
    fn every_part_gets_its_bits_and_no_other() {
        let part = |var, from, to, width| Part { var, word: 0, from, to, width };
        let shape = Shape {
            fields: vec![(Written::Known, 0), (Written::Both, 0), (Written::Toggled, 2), (Written::Known, 3)],
            parts: vec![part(70, 4, 0, 4), part(2, 0, 8, 8), part(0, 0, 3, 1), part(1, 0, 0, 64)],
        };
        let fields = Fields::new(&shape, |var| (var, var));
        let (mut current, mut touched) = (vec![Word::ZERO; 80], Touched::new(80));
        current[2] = Word { v: 0xff00ff, u: 0 };
        current[0] = Word::known(0b1111);
        let mut words = Vec::new();
        let (known, both) = (Word::known(u64::MAX), Word { v: 0x5a, u: 0x0f });
        let changed = [(0, known, Written::Known), (1, both, Written::Both), (2, known, Written::Toggled)];
        changes::write(&mut words, 0, 9, 4, changed.into_iter());
        assert_eq!(fields.put(&words[2..3], &words[3..], &mut current, &mut touched), 3);
        assert_eq!(current[70], Word { v: 0x5, u: 0x0 });
        assert_eq!(current[2], Word { v: 0xff5aff & !0xff00 | 0x5a00, u: 0x0f00 });
        assert_eq!(current[0], Word::known(0b0111));
        assert_eq!(current[1], Word::ZERO);
        assert_eq!(touched.bits, [0b101, 1 << 6]);
        assert_eq!(touched.summary, [0b11]);
    }
}
