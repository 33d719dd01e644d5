//! Lane compaction: lanes that move from one block to free places of another, 64 at once.

/// Consecutive lanes of one block, and their new places in another.
#[derive(Clone, Debug)]
pub struct Compaction {
    first: usize,
    words: Vec<Places>,
    lanes: usize,
}

/// The places in a word of lanes.
#[derive(Clone, Debug)]
struct Places {
    word: usize,
    /// Where lanes are placed.
    mask: u64,
    /// Lanes that go to words before it.
    before: usize,
    /// For each power of two the places that a bit has to come up to by it.
    moves: [u64; 6],
}

impl Compaction {
    /// Moves up to `most` lanes, from lane `first` on, to places of a set, lowest first.
    #[must_use]
    pub fn new(first: usize, most: usize, places: &[u64]) -> Compaction {
        let mut compaction = Compaction { first, words: Vec::new(), lanes: 0 };
        for (word, &free) in places.iter().enumerate() {
            let mut mask = free;
            let room = most - compaction.lanes;
            while mask.count_ones() as usize > room {
                mask &= !(1 << (63 - mask.leading_zeros()));
            }
            if mask != 0 {
                compaction.words.push(Places { word, mask, before: compaction.lanes, moves: moves(mask) });
                compaction.lanes += mask.count_ones() as usize;
            }
        }
        compaction
    }

    /// How many lanes are moved.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Where they come from and where they go.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let places = self.words.iter().flat_map(|p| {
            let mut mask = p.mask;
            std::iter::from_fn(move || {
                (mask != 0).then(|| {
                    let bit = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    p.word * 64 + bit
                })
            })
        });
        (self.first..).zip(places)
    }

    /// Takes a set of lanes along: those of `from` that are moved are in `to` where they go to, the others not.
    pub fn carry(&self, from: impl Fn(usize) -> u64, mut to: impl FnMut(usize, u64, u64)) {
        for places in &self.words {
            let at = self.first + places.before;
            let (word, shift) = (at / 64, at % 64);
            let more = shift + places.mask.count_ones() as usize > 64;
            let bits = from(word) >> shift | if more { from(word + 1) << (64 - shift) } else { 0 };
            to(places.word, places.mask, spread(bits, places));
        }
    }
}

/// The lowest bits, each at its place.
fn spread(bits: u64, places: &Places) -> u64 {
    let mut bits = bits;
    for (i, &moved) in places.moves.iter().enumerate().rev() {
        let up = bits << (1 << i);
        bits = bits & !moved | up & moved;
    }
    bits & places.mask
}

/// The steps of [`spread`]: what Hacker's Delight, 7-5, has for `expand`.
fn moves(mask: u64) -> [u64; 6] {
    let mut left = mask;
    let mut zeros = !mask << 1;
    std::array::from_fn(|i| {
        let mut odd = zeros ^ zeros << 1;
        for shift in [2, 4, 8, 16, 32] {
            odd ^= odd << shift;
        }
        let moved = odd & left;
        left = (left ^ moved) | moved >> (1 << i);
        zeros &= !odd;
        moved
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_come_to_their_places_one_by_one() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state ^ state >> 29
        };
        for round in 0..500 {
            let from: Vec<u64> = (0..4).map(|_| random()).collect();
            let places: Vec<u64> = (0..3).map(|_| [random(), random() & random(), u64::MAX, 0][round % 4]).collect();
            let first = (random() % 100) as usize;
            let compaction = Compaction::new(first, (random() % 150) as usize, &places);
            let old: Vec<u64> = (0..3).map(|_| random()).collect();
            let mut to = old.clone();
            compaction.carry(|word| from[word], |word, mask, bits| to[word] = to[word] & !mask | bits);
            let mut expected = old;
            for (from_lane, lane) in compaction.pairs() {
                assert_eq!(places[lane / 64] >> (lane % 64) & 1, 1);
                let bit = from[from_lane / 64] >> (from_lane % 64) & 1;
                expected[lane / 64] = expected[lane / 64] & !(1 << (lane % 64)) | bit << (lane % 64);
            }
            assert_eq!(to, expected);
            assert_eq!(compaction.pairs().count(), compaction.lanes());
        }
    }
}
