//! Going through some variables of a waveform in order of time.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use wellen::{BitVecRef, Signal, SignalRef, SignalValueRef};

use super::read::{ReadError, Waves};
use crate::value::Word;
use crate::value::word::{copy, words};

/// The values of some variables.
pub struct Tracks {
    signals: Vec<Signal>,
    /// For each variable that of the signals which it is; none if the file has no values.
    of: Vec<Option<usize>>,
}

impl Tracks {
    /// Loads variables, given by their indices; what several of them share once.
    ///
    /// # Errors
    /// Damaged values.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load(waves: &mut Waves, vars: &[usize]) -> Result<Tracks, ReadError> {
        let mut refs: Vec<SignalRef> = vars.iter().map(|&var| waves.vars()[var].signal).collect();
        refs.sort_unstable();
        refs.dedup();
        let signals = waves.signals(&refs)?;
        let at: HashMap<SignalRef, usize> = signals.iter().enumerate().map(|(i, s)| (s.signal_ref(), i)).collect();
        let of = vars.iter().map(|&var| at.get(&waves.vars()[var].signal).copied()).collect();
        Ok(Tracks { signals, of })
    }

    /// The times at which a variable, given by its place among those that were loaded, is said to have a value.
    pub fn times<'a>(&'a self, waves: &'a Waves, var: usize) -> impl Iterator<Item = u64> + 'a {
        let signal = self.of[var].map(|signal| &self.signals[signal]);
        signal.into_iter().flat_map(|s| s.time_indices()).map(|&at| waves.times()[at as usize])
    }

    /// A bit of a variable at each of its [times](Tracks::times).
    pub fn bit<'a>(&'a self, waves: &'a Waves, var: usize, bit: u32) -> impl Iterator<Item = (u64, Word)> + 'a {
        let signal = self.of[var].map(|signal| &self.signals[signal]);
        signal.into_iter().flat_map(|s| super::read::changes(s, waves.times())).filter_map(move |(time, value)| {
            let SignalValueRef::BitVec(bits) = value else { return None };
            let mut below = vec![Word::ZERO; words(bit + 1)];
            write(&mut below, 0, bits, bit + 1);
            let Word { v, u } = below[bit as usize / 64];
            Some((time, Word { v: v >> (bit % 64) & 1, u: u >> (bit % 64) & 1 }))
        })
    }

    /// Goes through all of them together from the beginning.
    #[must_use]
    pub fn play<'a>(&'a self, waves: &'a Waves) -> Player<'a> {
        let first = |(var, signal): (usize, &Option<usize>)| {
            Some(Reverse((*self.signals[(*signal)?].time_indices().first()?, var)))
        };
        let due = self.of.iter().enumerate().filter_map(first).collect();
        Player { tracks: self, waves, next: vec![0; self.of.len()], due }
    }
}

/// A walk through the changes of several variables; see [`Tracks::play`].
pub struct Player<'a> {
    tracks: &'a Tracks,
    waves: &'a Waves,
    /// For each variable the change to come.
    next: Vec<usize>,
    /// Times by their index, and the variables that change then.
    due: BinaryHeap<Reverse<(u32, usize)>>,
}

impl Player<'_> {
    /// The time of the next changes, in ticks of the file.
    #[must_use]
    pub fn time(&self) -> Option<u64> {
        self.due.peek().map(|Reverse((at, _))| self.waves.times()[*at as usize])
    }

    /// Makes the changes of the next time: calls `change` with the place of each variable that has one and its bits.
    pub fn step(&mut self, change: &mut dyn FnMut(usize, Bits<'_>)) {
        let Some(&Reverse((now, _))) = self.due.peek() else { return };
        while let Some(&Reverse((at, var))) = self.due.peek() {
            if at != now {
                break;
            }
            self.due.pop();
            let Some(signal) = self.tracks.of[var].map(|signal| &self.tracks.signals[signal]) else { continue };
            let times = signal.time_indices();
            let mut next = self.next[var] + 1;
            // the last one counts
            while times.get(next) == Some(&now) {
                next += 1;
            }
            self.next[var] = next;
            if let Some(&at) = times.get(next) {
                self.due.push(Reverse((at, var)));
            }
            if let SignalValueRef::BitVec(bits) = signal.data().get_value_at(next - 1) {
                change(var, Bits(bits));
            }
        }
    }
}

/// The bits of a variable.
pub struct Bits<'a>(BitVecRef<'a>);

impl Bits<'_> {
    /// Writes `width` of them over those of a vector from bit `at` up, or all, the most significant first.
    pub fn write(&self, to: &mut [Word], at: u32, width: u32, reversed: bool) {
        if !reversed {
            return write(to, at, self.0, width);
        }
        let mut whole = vec![Word::ZERO; words(self.0.width())];
        write(&mut whole, 0, self.0, self.0.width());
        for (i, from) in (at..at + width).zip((0..self.0.width()).rev()) {
            copy(to, i, &whole, from, 1);
        }
    }
}

/// Of VHDL's values, weak ones are as strong as others, and what is neither 0, 1 nor z is x.
fn write(to: &mut [Word], at: u32, bits: BitVecRef<'_>, width: u32) {
    for (i, bit) in (at..at + width).zip(bits.iter_lsb_to_msb()) {
        let (v, u) = match bit.as_ascii() {
            '0' | 'l' => (0, 0),
            '1' | 'h' => (1, 0),
            'z' => (1, 1),
            _ => (0, 1),
        };
        let (word, shift) = (&mut to[i as usize / 64], i % 64);
        word.v = word.v & !(1 << shift) | v << shift;
        word.u = word.u & !(1 << shift) | u << shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_variables_in_order_of_time() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vcd");
        let text = "$timescale 1 ns $end $scope module t $end $var wire 1 ! a $end $var wire 2 \" b $end \
                    $var wire 1 ! alias $end $upscope $end $enddefinitions $end\n\
                    #0\n0!\nb1z \"\n#5\n1!\n#7\nbx0 \"\n0!\n1!\n#9\n";
        std::fs::write(&path, text).unwrap();
        let mut waves = Waves::open(&path).unwrap();
        let vars = ["t.b", "t.a", "t.alias"].map(|name| waves.find(name).unwrap());
        let tracks = Tracks::load(&mut waves, &vars).unwrap();
        let mut player = tracks.play(&waves);
        let mut seen = Vec::new();
        while let Some(time) = player.time() {
            player.step(&mut |var, bits| {
                let mut word = [Word::known(0xff)];
                bits.write(&mut word, 1, if var == 0 { 2 } else { 1 }, false);
                seen.push((time, var, word[0].v, word[0].u));
            });
        }
        // bit 0 and those from the width on stay as they were
        let expected = [
            (0, 0, 0b1111_1111, 0b010),
            (0, 1, 0b1111_1101, 0),
            (0, 2, 0b1111_1101, 0),
            (5, 1, 0xff, 0),
            (5, 2, 0xff, 0),
            (7, 0, 0b1111_1001, 0b100),
            (7, 1, 0xff, 0),
            (7, 2, 0xff, 0),
        ];
        assert_eq!(seen, expected);
        assert_eq!(tracks.times(&waves, 0).collect::<Vec<_>>(), [0, 7]);
    }
}
