//! Going through some variables of a waveform in order of time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::iter::Peekable;
use std::sync::Arc;

pub use super::read::signal::Bits;
use super::read::signal::{All, Signal, Value};
use super::read::{ReadError, Waves};
use crate::value::Word;

/// The values of some variables.
pub struct Tracks(Vec<Arc<Signal>>);

impl Tracks {
    /// Loads variables, given by their indices; what several of them share once.
    ///
    /// # Errors
    /// Damaged values.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn load(waves: &mut Waves, vars: &[usize]) -> Result<Tracks, ReadError> {
        let signals: Vec<u32> = vars.iter().map(|&var| waves.vars()[var].signal).collect();
        Ok(Tracks(waves.signals(&signals)?))
    }

    /// The times at which a variable, given by its place among those that were loaded, is said to have a value.
    pub fn times<'a>(&'a self, waves: &'a Waves, var: usize) -> impl Iterator<Item = u64> + 'a {
        self.0[var].all().map(|(at, _)| waves.times()[at as usize])
    }

    /// A bit of a variable at each of its [times](Tracks::times).
    pub fn bit<'a>(&'a self, waves: &'a Waves, var: usize, bit: u32) -> impl Iterator<Item = (u64, Word)> + 'a {
        super::read::changes(&self.0[var], waves.times()).filter_map(move |(time, value)| {
            let Value::Bits(bits) = value else { return None };
            Some((time, bits.bit(bit)))
        })
    }

    /// Goes through all of them together from the beginning.
    #[must_use]
    pub fn play<'a>(&'a self, waves: &'a Waves) -> Player<'a> {
        let mut next: Vec<Peekable<All<'a>>> = self.0.iter().map(|signal| signal.all().peekable()).collect();
        let first = |(var, all): (usize, &mut Peekable<All<'a>>)| Some(Reverse((all.peek()?.0, var)));
        let due = next.iter_mut().enumerate().filter_map(first).collect();
        Player { waves, next, due }
    }
}

/// A walk through the changes of several variables; see [`Tracks::play`].
pub struct Player<'a> {
    waves: &'a Waves,
    /// For each variable the changes to come.
    next: Vec<Peekable<All<'a>>>,
    /// Times by their index, and the variables that change then.
    due: BinaryHeap<Reverse<(u64, usize)>>,
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
            let mut last = None;
            // the last one counts
            while let Some((_, value)) = self.next[var].next_if(|(at, _)| *at == now) {
                last = Some(value);
            }
            if let Some(&(at, _)) = self.next[var].peek() {
                self.due.push(Reverse((at, var)));
            }
            if let Some(Value::Bits(bits)) = last {
                change(var, bits);
            }
        }
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
