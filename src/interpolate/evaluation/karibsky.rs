//! Arc by Karibsky's rule: document C, «Один из методов построения кругового интерполятора».
//!
//! `F = x² + y² − R²` as in [`circle`](super::circle), but the step along the falling coordinate (clockwise y, as the
//! document words it; counter-clockwise x, its mirror image) is made only if `F` stays 0 or more **after** it, else the
//! one along the rising coordinate. So from a start on the circle no point lies inside, and the error is one-sided.

use std::iter::FusedIterator;

use super::circle::State;
use crate::{ArcInput, Clock, Columns, InputError, Interpolator, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: ArcInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(if options.as_printed {
        let printed = KaribskyPrinted::new(input)?;
        Box::new(Watchdog::new(printed, printed.bound()))
    } else {
        Box::new(Karibsky::new(input)?)
    })
}

/// What `F` would be after a step along the falling coordinate.
const fn trial(s: &State) -> i64 {
    s.f + if s.input.clockwise { s.change_y() } else { s.change_x() }
}

/// The arc by Karibsky's rule: an iterator over its clocks, up to the one that ends it.
///
/// When the counter of an axis is 0, the other axis steps whatever `F` is, as in [`EfCircle`](super::circle::EfCircle).
/// So every arc takes exactly `ΔX + ΔY` clocks, and one with no step to make ends at START.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, Karibsky};
/// let arc = Karibsky::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "YYYXYXYXXX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Karibsky {
    state: State,
}

impl Karibsky {
    /// Loads the registers.
    ///
    /// # Errors
    /// What [`ArcInput::check`] refuses.
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        Ok(Karibsky { state: State::load(input)? })
    }
}

impl Interpolator for Karibsky {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for Karibsky {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() { None } else { Some(s.clock_along(trial(s) >= 0)) }
    }
}

impl FusedIterator for Karibsky {}

/// Karibsky's rule to the letter: a step along the falling coordinate only if `F` stays **above** 0
/// («если в результате этого шага функция F оставалась бы больше нуля»), and nothing said of an axis that is done; the
/// end is the end point («путем сравнения координат»).
///
/// The last step to an end on the circle would make `F` 0 and is never made. It has to be bounded from outside, see
/// [`Watchdog`].
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, KaribskyPrinted};
/// let arc = KaribskyPrinted::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.take(10).map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "YYYYXYXXXY");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct KaribskyPrinted {
    state: State,
}

impl KaribskyPrinted {
    /// Loads the registers.
    ///
    /// # Errors
    /// As [`Karibsky::new`].
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        Ok(KaribskyPrinted { state: State::load(input)? })
    }

    /// A bound for a watchdog, `2·(KOX + KOY)` clocks: an arc that ends needs half of them, one step for each.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        2 * (self.state.kox + self.state.koy)
    }
}

impl Interpolator for KaribskyPrinted {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for KaribskyPrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() { None } else { Some(s.clock_unchecked(trial(s) > 0)) }
    }
}

impl FusedIterator for KaribskyPrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(from: (i64, i64), to: (i64, i64), clockwise: bool) -> String {
        Karibsky::new(ArcInput::between(from, to, clockwise, 8)).unwrap().map(|c| c.letter()).collect()
    }

    /// By hand; the document's own words are the clockwise ones.
    #[test]
    fn golden_steps() {
        assert_eq!(steps((0, 5), (5, 0), true), "XXXYXYXYYY");
        assert_eq!(steps((5, 0), (0, 5), false), "YYYXYXYXXX");
        assert_eq!(steps((1, 0), (0, 1), false), "YX");
        assert_eq!(steps((5, 0), (5, 0), false), "");
    }

    #[test]
    fn golden_values() {
        let arc = Karibsky::new(ArcInput::between((0, 5), (5, 0), true, 8)).unwrap();
        assert_eq!(arc.map(|c| c.sum[0]).collect::<Vec<_>>(), [1, 4, 9, 0, 7, 0, 9, 4, 1, 0]);
    }
}
