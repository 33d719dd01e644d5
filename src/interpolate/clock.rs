//! What every interpolator shows of itself, clock by clock, and why one may stop short.

use std::{error, fmt};

use super::InputError;

/// One clock: its steps, and the registers after its trailing edge. Index 0 is x, 1 is y, 2 is z; what an interpolator
/// does not have is 0, see [`Columns`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Clock {
    /// The step along each axis in BLU: −1, 0 or 1.
    pub step: [i8; 3],
    /// `XT`, `YT`, `ZT`: the current point in BLU. A register of the circuit shows it modulo 2^bits.
    pub at: [i64; 3],
    /// `KOX`, `KOY`, `KOZ`: steps left.
    pub left: [u64; 3],
    /// The sums that decide the next step: `F`, or `SX` and `SY`, as the method's [`Columns`] name them.
    pub sum: [i64; 3],
    /// The end is reached.
    pub end: bool,
}

impl Clock {
    /// The letter of its steps, whatever their direction: `X`, `Y`, `Z`; `D` for x and y, `E` for x and z, `F` for y
    /// and z, `A` for all three; `-` for none.
    ///
    /// ```
    /// # mod discreta {
    /// #     pub mod interpolate { pub use discreta_interpolate::*; }
    /// # }
    /// use discreta::interpolate::Clock;
    /// let letter = |step| Clock { step, ..Clock::default() }.letter();
    /// assert_eq!([[1, 0, 0], [0, -1, 0], [-1, 1, 0], [0, 0, 0]].map(letter), ['X', 'Y', 'D', '-']);
    /// assert_eq!([[0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]].map(letter), ['Z', 'E', 'F', 'A']);
    /// ```
    #[must_use]
    pub const fn letter(&self) -> char {
        match (self.step[0] != 0, self.step[1] != 0, self.step[2] != 0) {
            (false, false, false) => '-',
            (true, false, false) => 'X',
            (false, true, false) => 'Y',
            (false, false, true) => 'Z',
            (true, true, false) => 'D',
            (true, false, true) => 'E',
            (false, true, true) => 'F',
            (true, true, true) => 'A',
        }
    }

    /// How many axes step.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.step.iter().filter(|&&s| s != 0).count()
    }
}

/// Which registers an interpolator has, by the names of their nets in its circuit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Columns {
    /// The coordinates: those of [`Clock::at`].
    pub at: &'static [&'static str],
    /// The counters of steps left: those of [`Clock::left`].
    pub left: &'static [&'static str],
    /// The sums: those of [`Clock::sum`].
    pub sum: &'static [&'static str],
}

impl Columns {
    /// Two coordinates, two counters and `F`, as the line by evaluation function has them.
    pub const EVALUATION: Columns = Columns { at: &["xt", "yt"], left: &["kox", "koy"], sum: &["f"] };
    /// Two coordinates, two counters and two sums, as a DDA has them.
    pub const DDA: Columns = Columns { at: &["xt", "yt"], left: &["kox", "koy"], sum: &["sx", "sy"] };
    /// The same, normalised: the third number of [`Clock::sum`] is by how many bits what the next clock adds is shifted.
    pub const DDA_NORMALISED: Columns =
        Columns { at: &["xt", "yt"], left: &["kox", "koy"], sum: &["sx", "sy", "shifts"] };
}

/// Why an interpolator stopped without its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Stopped {
    /// No end within the clocks that every drawing that ends needs.
    Watchdog {
        /// The clocks that were let run.
        clocks: u64,
    },
    /// An arc cannot go on in the next quadrant.
    Refused(InputError),
    /// A curve's path got to a point that the registers cannot go on from: a coordinate does not fit, or what an
    /// accumulator would be given is 2^bits or more, and more than one carry could come of it.
    Overflow {
        /// The point, BLU.
        at: [i64; 2],
        /// Bits of the registers.
        bits: u32,
    },
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Stopped::Watchdog { clocks } => write!(f, "stopped by the watchdog: no end within {clocks} clocks"),
            Stopped::Refused(error) => write!(f, "the next quadrant is refused: {error}"),
            Stopped::Overflow { at: [x, y], bits } => {
                write!(f, "stopped by an overflow at ({x}, {y}): a coordinate or a derivative does not fit {bits} bits")
            }
        }
    }
}

impl error::Error for Stopped {}

/// An algorithm of interpolation: an iterator over its clocks, up to the one that ends it.
///
/// When it has no more clocks, either its [`state`](Interpolator::state) is at the end, or
/// [`stopped`](Interpolator::stopped) says why not.
pub trait Interpolator: Iterator<Item = Clock> {
    /// The registers as they stand: before the first clock, what START loaded.
    fn state(&self) -> Clock;

    /// Which registers there are.
    fn columns(&self) -> Columns;

    /// Why there are no more clocks though the end is not reached.
    fn stopped(&self) -> Option<Stopped> {
        None
    }

    /// Runs some clocks ahead: into each [`Packing`]'s word of each of `to` what the registers are before a clock and
    /// which steps that clock makes. `now` is what the registers are, before and after; `over` becomes true with the clocks.
    fn ahead(&mut self, now: &mut Clock, over: &mut bool, packings: &[Packing], to: &mut [u64]) {
        for to in to.chunks_exact_mut(packings.len()) {
            let next = if *over { None } else { self.next() };
            let step = next.map_or([0; 3], |c| c.step);
            for (to, packing) in to.iter_mut().zip(packings) {
                *to = packing.word(now, step);
            }
            match next {
                Some(next) => *now = next,
                None => *over = true,
            }
        }
    }
}

/// Which registers and steps stand where in a word of 64 bits: for each a mask of its bits, 0 if it is not there, and how
/// far up they stand.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Packing {
    /// Those of [`Clock::at`].
    pub at: [(u64, u32); 3],
    /// Those of [`Clock::left`].
    pub left: [(u64, u32); 3],
    /// Those of [`Clock::sum`].
    pub sum: [(u64, u32); 3],
    /// [`Clock::end`].
    pub end: (u64, u32),
    /// Whether there is a step along each axis.
    pub step: [(u64, u32); 3],
}

impl Packing {
    /// The word of these registers and these steps.
    #[inline(always)]
    #[must_use]
    pub fn word(&self, registers: &Clock, step: [i8; 3]) -> u64 {
        let put = |value: u64, (mask, shift): (u64, u32)| (value & mask) << shift;
        let mut word = put(u64::from(registers.end), self.end);
        for (i, step) in step.into_iter().enumerate() {
            word |= put(registers.at[i] as u64, self.at[i]);
            word |= put(registers.left[i], self.left[i]);
            word |= put(registers.sum[i] as u64, self.sum[i]);
            word |= put(u64::from(step != 0), self.step[i]);
        }
        word
    }
}

impl<I: Interpolator + ?Sized> Interpolator for Box<I> {
    fn state(&self) -> Clock {
        (**self).state()
    }

    fn columns(&self) -> Columns {
        (**self).columns()
    }

    fn stopped(&self) -> Option<Stopped> {
        (**self).stopped()
    }

    fn ahead(&mut self, now: &mut Clock, over: &mut bool, packings: &[Packing], to: &mut [u64]) {
        (**self).ahead(now, over, packings, to);
    }
}

/// Lets an interpolator run for a bounded number of clocks.
#[derive(Clone, Debug)]
pub struct Watchdog<I> {
    inner: I,
    limit: u64,
    clocks: u64,
}

impl<I: Interpolator> Watchdog<I> {
    /// At most `limit` clocks of `inner`.
    pub const fn new(inner: I, limit: u64) -> Self {
        Watchdog { inner, limit, clocks: 0 }
    }
}

impl<I: Interpolator> Iterator for Watchdog<I> {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        if self.clocks == self.limit {
            return None;
        }
        let clock = self.inner.next()?;
        self.clocks += 1;
        Some(clock)
    }
}

impl<I: Interpolator> Interpolator for Watchdog<I> {
    fn state(&self) -> Clock {
        self.inner.state()
    }

    fn columns(&self) -> Columns {
        self.inner.columns()
    }

    fn stopped(&self) -> Option<Stopped> {
        let barked = self.clocks == self.limit && !self.inner.state().end;
        self.inner.stopped().or_else(|| barked.then_some(Stopped::Watchdog { clocks: self.limit }))
    }
}
