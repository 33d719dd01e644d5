//! General curve of the second order by differential increments: document A, the general part.
//!
//! The curve `A·x² + B·xy + C·y² + D·x + E·y + F = 0` is followed by `x' = −(Bx + 2Cy + E)·k`, `y' = (2Ax + By + D)·k`
//! with `k = 2^−p`, which is counter-clockwise on a circle; clockwise both signs are turned. Each clock gives the two
//! derivatives to two accumulators of p bits; a carry is a step of +1, a borrow one of −1. The document prints the pair
//! without the minus, and `By` for `Bx` in the first: [`Printed`].
//!
//! The document says nothing of an end. Counters of steps left fail where an axis turns round, so the point itself is
//! looked at, see [`DdaCurve`].

use std::iter::FusedIterator;

use super::check_options;
use super::conic::{Course, CurveInput, REACH};
use crate::{Clock, Columns, InputError, Interpolator, Method, Options, Stopped};

/// What the command line asks for.
pub(crate) fn build(input: CurveInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(Box::new(DdaCurve::new(input, options)?))
}

/// Which misprints of the document are kept.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Printed {
    /// No minus: `x'` and `y'` both with a plus, or clockwise both with a minus.
    pub signs: bool,
    /// «By + 2Cy + E» for `Bx + 2Cy + E`.
    pub by: bool,
}

/// The curve by differential increments: an iterator over its clocks, up to the one that ends it.
///
/// - x first; y is given the new x in the same clock, or with [`Options::parallel`] the old one, as for the circle.
/// - **Overflow.** Where a derivative is ±2^p or more, or a coordinate does not fit p bits in two's complement, no clock is
///   made and [`Stopped::Overflow`] says so: more than one carry could be due, and all but one would be lost.
/// - **End.** Once the point is within [`REACH`] BLU of the end point along both axes, the accumulators rest and each axis
///   steps towards the end point on every clock until it is there. That begins when the end point is about due
///   ([`Course::last`](super::conic::Course::last)): the path may pass near it before, and the whole of a closed curve
///   begins there.
/// - **Watchdog.** A counter of clocks begins at [`Course::limit`](super::conic::Course::limit); at 0 no more are made.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{CurveInput, DdaCurve, Interpolator, Options};
/// // x² + y² = 10², all of it
/// let circle = CurveInput {
///     coefficients: [1, 0, 1, 0, 0, -100],
///     start: [10, 0],
///     end: [10, 0],
///     clockwise: false,
///     bits: 6,
/// };
/// let mut curve = DdaCurve::new(circle, &Options::default())?;
/// assert!(curve.by_ref().all(|clock| (clock.at[0].pow(2) + clock.at[1].pow(2) - 100).abs() <= 30));
/// assert_eq!((curve.state().at, curve.stopped()), ([10, 0, 0], None));
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaCurve {
    input: CurveInput,
    parallel: bool,
    printed: Printed,
    at: [i64; 2],
    /// `SX`, `SY`, units of 2^−p BLU.
    sum: [i64; 2],
    course: Course,
    /// Clocks left.
    clocks: u64,
}

/// What the next clock does.
enum Next {
    End,
    Stop(Stopped),
    /// Straight to the end point.
    Finish([i64; 2]),
    /// By carry and borrow of these derivatives.
    Follow([i128; 2]),
}

impl DdaCurve {
    /// What START loads, as the document has it corrected or, with [`Options::as_printed`], with all its misprints.
    ///
    /// # Errors
    /// What [`CurveInput::course`] refuses; an option that a curve does not have.
    pub fn new(input: CurveInput, options: &Options) -> Result<Self, InputError> {
        DdaCurve::with_misprints(input, options, Printed { signs: options.as_printed, by: options.as_printed })
    }

    /// With those misprints of the document that are chosen.
    ///
    /// # Errors
    /// As [`DdaCurve::new`].
    pub fn with_misprints(input: CurveInput, options: &Options, printed: Printed) -> Result<Self, InputError> {
        check_options(Method::DdaCurve, options)?;
        let course = input.course()?;
        let sum = if options.half_preload { 1 << (input.bits - 1) } else { 0 };
        Ok(DdaCurve {
            input,
            parallel: options.parallel,
            printed,
            at: input.start,
            sum: [sum; 2],
            course,
            clocks: course.limit,
        })
    }

    fn end(&self) -> bool {
        self.near() && self.at == self.input.end
    }

    /// In reach of the end point, when that counts.
    fn near(&self) -> bool {
        self.clocks <= self.course.last && (0..2).all(|i| (self.input.end[i] - self.at[i]).abs() <= REACH)
    }

    /// `x'·2^p` at the current point.
    fn derivative_x(&self) -> i128 {
        let [x, y] = self.at;
        let [_, b, c, _, e, _] = self.input.coefficients.map(i128::from);
        let v = b * i128::from(if self.printed.by { y } else { x }) + 2 * c * i128::from(y) + e;
        if self.input.clockwise == self.printed.signs { -v } else { v }
    }

    /// `y'·2^p` at x and the current y.
    fn derivative_y(&self, x: i64) -> i128 {
        let [v, _] = self.input.gradient([x, self.at[1]]);
        if self.input.clockwise { -v } else { v }
    }

    /// The sum and the step that come of a derivative.
    fn add(&self, axis: usize, derivative: i128) -> (i64, i64) {
        let sum = self.sum[axis] + derivative as i64;
        (sum & ((1 << self.input.bits) - 1), sum >> self.input.bits)
    }

    /// The derivatives that the next clock adds, y's for the x that it is given.
    fn derivatives(&self) -> Option<[i128; 2]> {
        let half = 1_i64 << (self.input.bits - 1);
        let fits = |v: i128| v.abs() < 1 << self.input.bits;
        let x = self.derivative_x();
        if !fits(x) || self.at.iter().any(|v| !(-half..half).contains(v)) {
            return None;
        }
        let y = self.derivative_y(self.at[0] + if self.parallel { 0 } else { self.add(0, x).1 });
        fits(y).then_some([x, y])
    }

    fn next_clock(&self) -> Next {
        if self.end() {
            Next::End
        } else if self.clocks == 0 {
            Next::Stop(Stopped::Watchdog { clocks: self.course.limit })
        } else if self.near() {
            Next::Finish([0, 1].map(|i| (self.input.end[i] - self.at[i]).signum()))
        } else {
            self.derivatives()
                .map_or_else(|| Next::Stop(Stopped::Overflow { at: self.at, bits: self.input.bits }), Next::Follow)
        }
    }

    fn clock(&self, step: [i64; 2]) -> Clock {
        Clock {
            step: [step[0] as i8, step[1] as i8, 0],
            at: [self.at[0], self.at[1], 0],
            left: [self.clocks, 0, 0],
            sum: [self.sum[0], self.sum[1], 0],
            end: self.end(),
        }
    }
}

impl Interpolator for DdaCurve {
    fn state(&self) -> Clock {
        self.clock([0; 2])
    }

    fn columns(&self) -> Columns {
        Columns { at: &["xt", "yt"], left: &["clocks"], sum: &["sx", "sy"] }
    }

    fn stopped(&self) -> Option<Stopped> {
        match self.next_clock() {
            Next::Stop(why) => Some(why),
            _ => None,
        }
    }
}

impl Iterator for DdaCurve {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let step = match self.next_clock() {
            Next::End | Next::Stop(_) => return None,
            Next::Finish(step) => step,
            Next::Follow(derivatives) => [0, 1].map(|axis| {
                let (sum, step) = self.add(axis, derivatives[axis]);
                self.sum[axis] = sum;
                step
            }),
        };
        self.at = [0, 1].map(|i| self.at[i] + step[i]);
        self.clocks -= 1;
        Some(self.clock(step))
    }
}

impl FusedIterator for DdaCurve {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ideal;

    const SETTINGS: [(bool, bool); 4] = [(false, false), (false, true), (true, false), (true, true)];

    fn options((parallel, half_preload): (bool, bool)) -> Options {
        Options { parallel, half_preload, ..Options::default() }
    }

    fn whole(coefficients: [i64; 6], start: [i64; 2], bits: u32) -> CurveInput {
        CurveInput { coefficients, start, end: start, clockwise: false, bits }
    }

    fn circle(radius: i64, bits: u32) -> CurveInput {
        whole([1, 0, 1, 0, 0, -radius * radius], [radius, 0], bits)
    }

    /// The least and the greatest deviation, in hundredths of a BLU.
    fn range(input: CurveInput, points: impl Iterator<Item = Clock>) -> (i64, i64) {
        let ideal = Ideal::Conic { coefficients: input.coefficients.map(|v| v as f64) };
        points.fold((0, 0), |(least, greatest), c| {
            let d = (ideal.deviation([c.at[0] as f64, c.at[1] as f64, 0.0]) * 100.0).round() as i64;
            (least.min(d), greatest.max(d))
        })
    }

    /// An interpolator without an end.
    fn endless(input: CurveInput, options: &Options, printed: Printed) -> DdaCurve {
        let mut curve = DdaCurve::with_misprints(input, options, printed).unwrap();
        (curve.input.end, curve.clocks) = ([1 << 40; 2], u64::MAX);
        curve
    }

    #[test]
    fn steps_by_hand() {
        // p = 4, x² + y² = 4 from (2, 0): x' = −2y, y' = 2x, y given the new x
        let mut curve = DdaCurve::new(circle(2, 4), &Options::default()).unwrap();
        let clocks: Vec<_> = curve.by_ref().take(7).map(|c| (c.at[0], c.at[1], c.sum[0], c.sum[1])).collect();
        assert_eq!(
            clocks,
            [(2, 0, 0, 4), (2, 0, 0, 8), (2, 0, 0, 12), (2, 1, 0, 0), (1, 1, 14, 2), (1, 1, 12, 4), (1, 1, 10, 6)]
        );
    }

    #[test]
    fn a_full_circle_stays_near_or_spirals_out() {
        // one turn of R = 100 at p = 8 takes 2π·2^8/2 clocks
        let turn = |setting, n: usize| {
            let points = endless(circle(100, 8), &options(setting), Printed::default());
            range(circle(100, 8), points.skip(n * 804).take(804))
        };
        let sequential = [0, 1, 2].map(|n| SETTINGS.map(|s| turn(s, n))[..2].to_vec());
        assert!(sequential.iter().flatten().all(|&(least, greatest)| least >= -130 && greatest <= 130));
        assert_eq!(sequential[0], [(-128, 26), (-84, 80)]);
        let parallel = |setting| [0, 1, 2].map(|n| turn(setting, n).1);
        assert_eq!(parallel((true, false)), [240, 502, 756]);
        assert_eq!(parallel((true, true)), [296, 548, 817]);
    }

    #[test]
    fn as_printed() {
        // without the minus x² − y² stays: a hyperbola, up to the overflow of the derivatives
        let printed = Options { as_printed: true, ..Options::default() };
        let input = circle(100, 8);
        let mut curve = DdaCurve::new(input, &printed).unwrap();
        let hyperbola = CurveInput { coefficients: [1, 0, -1, 0, 0, -10000], ..input };
        let (least, greatest) = range(hyperbola, curve.by_ref());
        assert!(least > -200 && greatest < 200, "{least} {greatest}");
        assert_eq!(curve.stopped(), Some(Stopped::Overflow { at: [127, 80], bits: 8 }));
        // with By for Bx alone, an ellipse winds outwards
        let ellipse = whole([1, 1, 1, 0, 0, -3600], [60, 0], 8);
        let turn = |bits: u32, setting, by| {
            let curve = endless(CurveInput { bits, ..ellipse }, &options(setting), Printed { signs: false, by });
            // 2π·2^p/√3
            range(ellipse, curve.take((3.6276 * f64::from(1 << bits)) as usize))
        };
        let right = SETTINGS.map(|setting| turn(8, setting, false));
        assert_eq!(right, [(-248, 1), (-138, 57), (-119, 102), (-57, 213)]);
        let wrong = [8, 9, 10].map(|bits| turn(bits, (false, false), true).1);
        assert_eq!(wrong, [6106, 16411, 29675]);
    }
}
