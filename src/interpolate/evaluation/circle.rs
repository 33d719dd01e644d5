//! Arc by evaluation function: document B, «Кръгова интерполация», and the circular part of document C, where it is
//! Grossman's method.
//!
//! The evaluation function of a point is `F(x, y) = x² + y² − R²`: positive outside the circle, negative inside, 0 on
//! it. In the first quadrant one coordinate falls along the arc and the other rises: counter-clockwise x falls and y
//! rises, clockwise the other way round. `F ≥ 0` calls for a step that lessens the falling coordinate `a` and adds
//! `−2a + 1` to `F`; `F < 0` for one along the rising coordinate `b`, which adds `2b + 1`; both with the coordinate
//! from before the step. [`EfCircle`] ends for every input; [`EfCirclePrinted`] is document B's program taken at its
//! word, which uses the coordinate from after the step.

use std::iter::FusedIterator;

use super::mask;
use crate::{ArcInput, Clock, Columns, InputError, Interpolator, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: ArcInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(if options.as_printed {
        let printed = EfCirclePrinted::new(input)?;
        Box::new(Watchdog::new(printed, printed.bound()))
    } else {
        Box::new(EfCircle::new(input)?)
    })
}

/// The cells of the program's memory, which are the registers of the block diagram. Shared by all arcs by evaluation
/// function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct State {
    pub(super) input: ArcInput,
    pub(super) xt: i64,
    pub(super) yt: i64,
    pub(super) kox: u64,
    pub(super) koy: u64,
    pub(super) f: i64,
}

impl State {
    /// Points 1 to 3 of the program: what START loads.
    pub(super) fn load(input: ArcInput) -> Result<State, InputError> {
        input.check()?;
        let ArcInput { xh, yh, dx, dy, f0, .. } = input;
        Ok(State { input, xt: xh, yt: yh, kox: dx.unsigned_abs(), koy: dy.unsigned_abs(), f: f0 })
    }

    pub(super) const fn end(&self) -> bool {
        self.kox == 0 && self.koy == 0
    }

    /// Which way x steps; y steps the other way.
    const fn direction_x(&self) -> i64 {
        if self.input.clockwise { 1 } else { -1 }
    }

    /// The registers after a clock with these steps.
    pub(super) const fn clock(&self, x: bool, y: bool) -> Clock {
        let direction = self.direction_x() as i8;
        Clock {
            step: [if x { direction } else { 0 }, if y { -direction } else { 0 }, 0],
            at: [self.xt, self.yt, 0],
            left: [self.kox, self.koy, 0],
            sum: [self.f, 0, 0],
            end: self.end(),
        }
    }

    /// What a step along x adds to `F`: `(x ± 1)² − x²`.
    pub(super) const fn change_x(&self) -> i64 {
        2 * self.direction_x() * self.xt + 1
    }

    /// What a step along y adds to `F`.
    pub(super) const fn change_y(&self) -> i64 {
        -2 * self.direction_x() * self.yt + 1
    }

    /// A step along x but for `F`.
    pub(super) const fn step_x(&mut self) {
        self.xt += self.direction_x();
        self.kox = self.kox.wrapping_sub(1) & mask(self.input.bits);
    }

    /// A step along y but for `F`.
    pub(super) const fn step_y(&mut self) {
        self.yt -= self.direction_x();
        self.koy = self.koy.wrapping_sub(1) & mask(self.input.bits);
    }

    /// One clock with a step along one axis, the falling one or else the rising one as `falling` says; but when the
    /// counter of an axis is 0 it is the other's turn.
    pub(super) const fn clock_along(&mut self, falling: bool) -> Clock {
        let x = if self.kox == 0 || self.koy == 0 { self.koy == 0 } else { falling != self.input.clockwise };
        self.clock_of(x)
    }

    /// The same without a look at the counters, which then may pass below 0.
    pub(super) const fn clock_unchecked(&mut self, falling: bool) -> Clock {
        self.clock_of(falling != self.input.clockwise)
    }

    /// One clock with a step along x, or else y.
    const fn clock_of(&mut self, x: bool) -> Clock {
        if x {
            self.f += self.change_x();
            self.step_x();
        } else {
            self.f += self.change_y();
            self.step_y();
        }
        self.clock(x, !x)
    }
}

/// The arc by evaluation function: an iterator over its clocks, up to the one that ends it. Document C calls it
/// Grossman's method.
///
/// Each clock the sign of `F` picks an axis (point 7), with the coordinates from before the step in the formulas. **When
/// the counter of an axis is 0, the other axis steps whatever the sign**: without this, end points that are not exactly
/// on the circle (rounded ones, as real programs give) may be passed by. So every arc takes exactly `ΔX + ΔY` clocks,
/// and one with no step to make ends at START.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, EfCircle};
/// let arc = EfCircle::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XYYYXYXYXX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfCircle {
    state: State,
}

impl EfCircle {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// What [`ArcInput::check`] refuses.
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        Ok(EfCircle { state: State::load(input)? })
    }
}

impl Interpolator for EfCircle {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfCircle {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        // Point 6, then point 7: 7.1 at F ≥ 0, else 7.2.
        if s.end() { None } else { Some(s.clock_along(s.f >= 0)) }
    }
}

impl FusedIterator for EfCircle {}

/// Points 4 to 7 of document B's program, literally: `XT` (or `YT`) is changed first and the changed value stands in the
/// formula of `F` (7.1, 7.2), so `F` is not `x² + y² − R²`; the end is tested for both counters together (6), and the
/// axis that `F` picks steps even when its own counter is 0, which then passes below 0.
///
/// It misses the end of every quarter arc. It has to be bounded from outside, see [`Watchdog`].
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, EfCirclePrinted};
/// let arc = EfCirclePrinted::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.take(10).map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XYYXYXXYXX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EfCirclePrinted {
    state: State,
}

impl EfCirclePrinted {
    /// Points 1 to 3.
    ///
    /// # Errors
    /// As [`EfCircle::new`].
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        Ok(EfCirclePrinted { state: State::load(input)? })
    }

    /// A bound for a watchdog, `2·(KOX + KOY)` clocks: an arc that ends needs half of them, one step for each.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        2 * (self.state.kox + self.state.koy)
    }
}

impl Interpolator for EfCirclePrinted {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfCirclePrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() {
            return None;
        }
        let x = (s.f >= 0) != s.input.clockwise;
        if x {
            s.step_x();
            s.f += s.change_x();
        } else {
            s.step_y();
            s.f += s.change_y();
        }
        Some(s.clock(x, !x))
    }
}

impl FusedIterator for EfCirclePrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(from: (i64, i64), to: (i64, i64), clockwise: bool) -> EfCircle {
        EfCircle::new(ArcInput::between(from, to, clockwise, 8)).unwrap()
    }

    fn steps(arc: impl Iterator<Item = Clock>) -> String {
        arc.map(|c| c.letter()).collect()
    }

    #[test]
    fn golden_steps() {
        assert_eq!(steps(between((5, 0), (0, 5), false)), "XYYYXYXYXX");
        // the mirror image: x and y exchanged
        assert_eq!(steps(between((0, 5), (5, 0), true)), "YXXXYXYXYY");
        assert_eq!(steps(between((4, 3), (3, 4), false)), "XY");
        // through the centre
        assert_eq!(steps(between((1, 0), (0, 1), false)), "XY");
        assert_eq!(steps(between((5, 0), (5, 0), false)), "");
        assert!(between((5, 0), (5, 0), false).state().end);
    }

    #[test]
    fn golden_values() {
        let f: Vec<_> = between((5, 0), (0, 5), false).map(|c| c.sum[0]).collect();
        assert_eq!(f, [-9, -8, -5, 0, -7, 0, -5, 4, 1, 0]);
        let last = between((5, 0), (0, 5), false).last().unwrap();
        assert_eq!(last, Clock { step: [-1, 0, 0], at: [0, 5, 0], left: [0; 3], sum: [0; 3], end: true });
    }

    /// By hand: F alone would go from (5, 0) by (4, 0), and from (4, 5) by (4, 6), past the last two ends.
    #[test]
    fn the_last_steps_are_forced() {
        assert_eq!(steps(between((5, 0), (2, 5), false)), "XYYYXYXY");
        assert_eq!(steps(between((5, 0), (3, 3), false)), "XYYYX");
        assert_eq!(steps(between((5, 0), (5, 2), false)), "YY");
        assert_eq!(steps(between((5, 5), (3, 5), false)), "XX");
    }

    #[test]
    fn f_may_begin_off_the_circle() {
        // R² = 24, so F(5, 0) = 1
        let input = ArcInput { f0: 1, ..ArcInput::between((5, 0), (0, 5), false, 8) };
        let arc = EfCircle::new(input).unwrap();
        assert_eq!(arc.state().sum[0], 1);
        for c in arc {
            assert_eq!(c.sum[0], c.at[0] * c.at[0] + c.at[1] * c.at[1] - 24);
        }
    }
}
