//! Arc by differential increments: document A, «Кръгова интерполация».
//!
//! `x' = −y·k`, `y' = x·k` with `k = 2^−p`: each clock adds `YT` to `SX` and `XT` to `SY`; the carries are the steps.
//! The document draws counter-clockwise in the first quadrant and brings every other case to that one. Clockwise is its
//! mirror image at the diagonal, x for y: below, *the falling axis* is x counter-clockwise and y clockwise.
//!
//! [`DdaCircle`] ends for every input; [`DdaCirclePrinted`] takes the program at its word, which does not.

use std::iter::FusedIterator;

use super::{State, check_options, columns, mask, normalise};
use crate::{ArcInput, Clock, Columns, InputError, Interpolator, Method, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: ArcInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(if options.as_printed {
        let printed = DdaCirclePrinted::new(input, options)?;
        let bound = printed.bound();
        Box::new(Watchdog::new(printed, bound))
    } else {
        let circle = DdaCircle::new(input, options)?;
        let bound = circle.bound();
        Box::new(Watchdog::new(circle, bound))
    })
}

/// How far from the circle through the start point an end point may be, BLU. Each of them may be a rounded one, ½·√2 off.
const REACH: f64 = 2.0;

/// Refuses an end point that no rounding explains.
fn check_end(input: ArcInput) -> Result<(), InputError> {
    let (xk, yk) = input.end();
    let radius = |x: i64, y: i64| ((x as f64) * (x as f64) + (y as f64) * (y as f64)).sqrt();
    if (radius(xk, yk) - radius(input.xh, input.yh)).abs() >= REACH {
        return Err(InputError::OffCircle { end: (xk, yk), start: (input.xh, input.yh) });
    }
    Ok(())
}

fn load(input: ArcInput, options: &Options) -> Result<State, InputError> {
    input.check()?;
    check_end(input)?;
    Ok(State::load([input.xh, input.yh], [input.dx, input.dy], input.bits, options.half_preload))
}

/// The falling and the rising axis.
const fn axes(clockwise: bool) -> (usize, usize) {
    if clockwise { (1, 0) } else { (0, 1) }
}

/// The arc by differential increments: an iterator over its clocks, up to the one that ends it.
///
/// The falling axis comes first, and the other one is given its new coordinate in the same clock, as in the document's
/// program; with [`Options::parallel`] it is given the old one, as parallel hardware would. Three rules are ours:
///
/// - An axis steps only while its counter is not 0.
/// - **The remaining axis is finished.** If what is summed for an axis is 0 and the other axis has no steps left, no clock
///   will ever change that, and there would be no more carries. Then the axis steps on every clock. So ends (2, 3) →
///   (0, 4), whose end point is rounded: the path reaches x = 0 when y is still a step short.
/// - The end point may be less than 2 BLU off the circle through the start point, which both being rounded explains.
///
/// With [`Options::normalise`] both coordinates are shifted left by `s` before every summation, `s` from the coordinates
/// before the clock. The path's direction stays, its pace is 2^s-fold: that clock stands for `2^s` clocks. `s` of the
/// next clock is [`Clock::sum`]'s third number.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, DdaCircle, Options};
/// let quarter = ArcInput::between((5, 0), (0, 5), false, 3);
/// let steps = |options| DdaCircle::new(quarter, &options).map(|arc| arc.map(|clock| clock.letter()).collect::<String>());
/// assert_eq!(steps(Options::default())?, "-Y-YY-D-D-XX-X");
/// assert_eq!(steps(Options { half_preload: true, ..Options::default() })?, "Y-YXY-D-XYX-X");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaCircle {
    state: State,
    clockwise: bool,
    parallel: bool,
    normalise: bool,
    starved: bool,
}

impl DdaCircle {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// What [`ArcInput::check`] refuses; an end point 2 BLU or more off the circle through the start point; an option
    /// that an arc by differential increments does not have.
    pub fn new(input: ArcInput, options: &Options) -> Result<Self, InputError> {
        check_options(Method::DdaCircle, options)?;
        Ok(DdaCircle {
            state: load(input, options)?,
            clockwise: input.clockwise,
            parallel: options.parallel,
            normalise: options.normalise,
            starved: false,
        })
    }

    /// Whether the remaining axis had to be finished: without that rule the arc would never have ended.
    #[must_use]
    pub const fn starved(&self) -> bool {
        self.starved
    }

    /// A bound for a watchdog: `(KOX + KOY)·2^p` clocks. While steps are left, one is made in any 2^p clocks: if an axis
    /// with steps left is given 1 or more it carries within 2^p; else it is given 0, and either it is being finished or
    /// the other axis has steps left and is itself given 1 or more.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        (self.state.left[0] + self.state.left[1]).saturating_mul(1 << self.state.bits)
    }

    fn shifts(&self) -> Option<u32> {
        let State { at, bits, .. } = self.state;
        self.normalise.then(|| normalise::shifts(at[0], at[1], bits))
    }
}

impl Interpolator for DdaCircle {
    fn state(&self) -> Clock {
        self.state.clock([0; 2], self.shifts())
    }

    fn columns(&self) -> Columns {
        columns(self.normalise)
    }
}

impl Iterator for DdaCircle {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let shifts = self.shifts().unwrap_or(0);
        let s = &mut self.state;
        // Point 7.
        if s.end() {
            return None;
        }
        let (falling, rising) = axes(self.clockwise);
        let finish = |axis: usize| s.at[1 - axis] == 0 && s.left[1 - axis] == 0 && s.left[axis] > 0;
        let finishing = [finish(0), finish(1)];
        self.starved |= finishing[0] || finishing[1];
        let mut step = [0; 2];
        // Points 8 and 9. Neither addend passes 2^p: what falls fits when what it falls from did.
        let before = s.at[falling];
        let carry = s.add(falling, s.at[rising] << shifts);
        if (carry || finishing[falling]) && s.left[falling] > 0 {
            s.step(falling, -1);
            step[falling] = -1;
        }
        // Point 10.
        let given = if self.parallel { before } else { s.at[falling] };
        let carry = s.add(rising, given << shifts);
        if (carry || finishing[rising]) && s.left[rising] > 0 {
            s.step(rising, 1);
            step[rising] = 1;
        }
        Some(self.state.clock(step, self.shifts()))
    }
}

impl FusedIterator for DdaCircle {}

/// Points 4 to 10 of the program, literally: the end is tested for both counters together (7), and an axis steps on
/// whether or not it has steps left; FLAG as in [`DdaLinePrinted`](super::line::DdaLinePrinted).
///
/// A counter that passes below 0 holds 2^p − 1 then, and so does a coordinate; [`Clock::at`] shows the coordinate as if
/// it had passed below 0. The end is met only if both counters are 0 in the same pass. It has to be bounded from outside,
/// see [`Watchdog`].
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, DdaCirclePrinted, Interpolator, Options, Watchdog};
/// let quarter = ArcInput::between((4, 0), (0, 4), false, 3);
/// let printed = DdaCirclePrinted::new(quarter, &Options { parallel: true, ..Options::default() })?;
/// let bound = printed.bound();
/// let mut watched = Watchdog::new(printed, bound);
/// assert_eq!(watched.by_ref().count(), 24);
/// assert_eq!(watched.stopped().unwrap().to_string(), "stopped by the watchdog: no end within 24 clocks");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaCirclePrinted {
    state: State,
    clockwise: bool,
    parallel: bool,
    flag: u64,
}

impl DdaCirclePrinted {
    /// Points 1 to 3.
    ///
    /// # Errors
    /// As [`DdaCircle::new`].
    pub fn new(input: ArcInput, options: &Options) -> Result<Self, InputError> {
        check_options(Method::DdaCircle, &Options { as_printed: true, ..*options })?;
        let state = load(input, options)?;
        Ok(DdaCirclePrinted { state, clockwise: input.clockwise, parallel: options.parallel, flag: 0 })
    }

    /// A bound for a watchdog, 3·2^p clocks. A quarter takes about (π/2)·2^p, that of radius 1 takes 2·2^p.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        3 << self.state.bits
    }
}

impl Interpolator for DdaCirclePrinted {
    fn state(&self) -> Clock {
        self.state.clock([0; 2], None)
    }

    fn columns(&self) -> Columns {
        Columns::DDA
    }
}

impl Iterator for DdaCirclePrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() {
            return None;
        }
        let (falling, rising) = axes(self.clockwise);
        let cells = mask(s.bits);
        let mut step = [0; 2];
        let before = s.at[falling];
        if s.add(falling, s.at[rising] & cells) {
            s.step(falling, -1);
            step[falling] = -1;
            self.flag += 1;
        }
        let given = if self.parallel { before } else { s.at[falling] };
        if s.add(rising, given & cells) {
            s.step(rising, 1);
            step[rising] = 1;
            self.flag += 1;
        }
        if self.flag != 1 {
            step = [0; 2];
        }
        Some(s.clock(step, None))
    }
}

impl FusedIterator for DdaCirclePrinted {}
