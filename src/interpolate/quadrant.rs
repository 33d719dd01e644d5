//! Other quadrants and directions: what document A leaves to «подходяща обработка на входните и на изходните данни».
//!
//! The methods draw in the first quadrant. Before them the signs of the increments or coordinates are taken off
//! ([`Mirrored`] knows which); behind them they are put back on the steps and on the current point. An arc that goes on
//! into other quadrants, [`Quadrants`], is one arc of the first quadrant after another. Which method draws is not known
//! here: it comes as a function that makes one.

use super::input::{check_bits, check_signed};
use super::{ArcInput, Clock, Columns, InputError, Interpolator, Stopped};

/// Post-processing: the drawing of an interpolator of the first quadrant, mirrored and moved.
#[derive(Clone, Debug)]
pub struct Mirrored<I> {
    core: I,
    swap: bool,
    negative: [bool; 3],
    origin: [i64; 3],
}

impl<I: Interpolator> Mirrored<I> {
    /// `core`'s x and y are exchanged if `swap` says so, with all that belongs to them; then the axes that are `negative`
    /// are turned round, and its origin comes to lie at `origin`, in BLU.
    pub const fn new(core: I, swap: bool, negative: [bool; 3], origin: [i64; 3]) -> Self {
        Mirrored { core, swap, negative, origin }
    }

    fn turn(&self, mut clock: Clock) -> Clock {
        if self.swap {
            clock.step.swap(0, 1);
            clock.at.swap(0, 1);
            clock.left.swap(0, 1);
            // one for each axis, or one F
            if self.columns().sum.len() > 1 {
                clock.sum.swap(0, 1);
            }
        }
        for axis in 0..3 {
            if self.negative[axis] {
                clock.step[axis] = -clock.step[axis];
                clock.at[axis] = -clock.at[axis];
            }
            clock.at[axis] += self.origin[axis];
        }
        clock
    }
}

impl<I: Interpolator> Iterator for Mirrored<I> {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        self.core.next().map(|clock| self.turn(clock))
    }
}

impl<I: Interpolator> Interpolator for Mirrored<I> {
    fn state(&self) -> Clock {
        self.turn(self.core.state())
    }

    fn columns(&self) -> Columns {
        self.core.columns()
    }

    fn stopped(&self) -> Option<Stopped> {
        self.core.stopped()
    }
}

/// An arc around any centre, of any length up to a full circle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ArcPath {
    /// The centre in BLU.
    pub center: [i64; 2],
    /// The start point in BLU: `−2^bits ≤ x, y < 2^bits`, and less than `2^bits` from the centre along each axis.
    pub from: [i64; 2],
    /// The end point; as `from`, and less than 2 BLU off the circle: it and the start point may be rounded ones.
    pub to: [i64; 2],
    /// The start point as end point means a full circle; else it means that nothing is drawn.
    pub full: bool,
    /// Whether the arc is longer than half a turn, where that is known from points that are not rounded; else the points
    /// tell.
    pub long: Option<bool>,
    /// Clockwise.
    pub clockwise: bool,
    /// `F₀ = x² + y² − R²` of the start point, from the centre: 0 if the circle goes through it.
    pub f0: i64,
    /// Bits of a first-quadrant coordinate; one from the origin of the plane has one more, its sign.
    pub bits: u32,
}

/// A quadrant of the plane, 0 to 3 counter-clockwise.
type Quadrant = u8;

/// Which axes are negative there.
const fn negative(quadrant: Quadrant) -> [bool; 3] {
    [quadrant == 1 || quadrant == 2, quadrant >= 2, false]
}

/// Whether it is y that falls: in every second quadrant, and in the others for the other direction.
const fn y_falls(quadrant: Quadrant, clockwise: bool) -> bool {
    (quadrant & 1 == 1) != clockwise
}

/// The quadrant of a point, `x, y ≠ 0, 0`; a point on an axis belongs to the quadrant counter-clockwise of it, or else
/// to the one clockwise of it.
const fn quadrant([x, y]: [i64; 2], axis_to_next: bool) -> Quadrant {
    let x_negative = if x == 0 { (y < 0) != axis_to_next } else { x < 0 };
    let y_negative = if y == 0 { (x < 0) == axis_to_next } else { y < 0 };
    (y_negative as u8) << 1 | (x_negative != y_negative) as u8
}

/// The falling and the rising coordinate of a point in a quadrant.
const fn falling_rising([x, y]: [i64; 2], quadrant: Quadrant, clockwise: bool) -> [i64; 2] {
    if y_falls(quadrant, clockwise) { [y.abs(), x.abs()] } else { [x.abs(), y.abs()] }
}

/// An arc cut at the axes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Cut {
    /// Quadrant of the start point; on an axis the one that the arc goes into.
    quadrant: Quadrant,
    /// How often it passes from quadrant to quadrant, 0 to 4.
    crossings: u8,
    /// The square of its radius.
    radius: i128,
    /// Falling and rising coordinate of the start point.
    from: [i64; 2],
    /// Falling and rising coordinate of the end point, in the last quadrant.
    to: [i64; 2],
}

impl ArcPath {
    /// A point from the centre.
    pub(super) fn relative(&self, point: [i64; 2]) -> Result<[i64; 2], InputError> {
        let [Some(x), Some(y)] = [0, 1].map(|axis| point[axis].checked_sub(self.center[axis])) else {
            return Err(InputError::Overflow);
        };
        Ok([x, y])
    }

    /// Pre-processing: where the arc begins and ends, and how many quadrants lie between.
    fn cut(&self) -> Result<Cut, InputError> {
        let ArcPath { clockwise, bits, .. } = *self;
        check_bits(bits)?;
        let names = [["XH", "YH"], ["XK", "YK"]];
        for (names, point) in names.into_iter().zip([self.from, self.to]) {
            check_signed(names[0], point[0], bits + 1)?;
            check_signed(names[1], point[1], bits + 1)?;
        }
        let (from, to) = (self.relative(self.from)?, self.relative(self.to)?);
        for point in [from, to] {
            if let Some(&value) = point.iter().find(|v| v.unsigned_abs() >= 1 << bits) {
                return Err(InputError::FarFromCenter { value, bits });
            }
        }
        let radius = square(from) - i128::from(self.f0);
        if from == [0, 0] || radius <= 0 {
            return Err(InputError::ZeroRadius);
        }
        if !less_than_2_apart(square(to), radius) {
            return Err(InputError::OffCircle { end: (to[0], to[1]), start: (from[0], from[1]) });
        }
        // the arc goes on from its start and has come up to its end
        let (first, last) = (quadrant(from, !clockwise), quadrant(to, clockwise));
        let between = if clockwise { first.wrapping_sub(last) } else { last.wrapping_sub(first) } & 3;
        let [start, end] = [falling_rising(from, first, clockwise), falling_rising(to, last, clockwise)];
        let (behind, ahead) = (end[0] >= start[0] && end[1] <= start[1], end[0] <= start[0] && end[1] >= start[1]);
        if from == to && !self.full {
            return Ok(Cut { quadrant: first, crossings: 0, radius, from: start, to: start });
        }
        let crossings = match between {
            0 if self.long == Some(true) => 4,
            0 if ahead && self.long == Some(false) => 0,
            0 if self.long == Some(false) => return Err(InputError::TooShort),
            0 if behind => 4,
            0 if ahead => 0,
            0 if start[0] * end[1] >= start[1] * end[0] => return Err(InputError::TooShort),
            0 => 4,
            n => n,
        };
        // between two quadrants the arc is on an axis, its whole radius from the centre
        if crossings > 0 && !fits(radius, bits) {
            return Err(InputError::WideRadius { square: radius, bits });
        }
        Ok(Cut { quadrant: first, crossings, radius, from: start, to: end })
    }

    /// `R²` in BLU².
    ///
    /// # Errors
    /// If there is no such arc.
    pub(super) fn radius_squared(&self) -> Result<i128, InputError> {
        self.cut().map(|cut| cut.radius)
    }
}

const fn square([x, y]: [i64; 2]) -> i128 {
    x as i128 * x as i128 + y as i128 * y as i128
}

/// `|√a − √b| < 2` for squares `a ≥ 0`, `b > 0`.
fn less_than_2_apart(a: i128, b: i128) -> bool {
    let (less, more) = if a < b { (a, b) } else { (b, a) };
    let rest = more - less - 4;
    rest < 0 || rest.checked_mul(rest).is_some_and(|square| square < 16 * less)
}

/// A coordinate of the square root, rounded up, fits `bits` bits.
const fn fits(square: i128, bits: u32) -> bool {
    let most = (1 << bits) - 1;
    square <= most * most
}

/// Makes the interpolator of one arc of the first quadrant.
type Build = Box<dyn Fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError>>;

/// What stays the same from quadrant to quadrant.
struct Plan {
    build: Build,
    path: ArcPath,
    cut: Cut,
    carries: bool,
}

impl Plan {
    /// The arc in one quadrant with `left` crossings behind it, from a falling and a rising coordinate and `F` on.
    fn arc(&self, quadrant: Quadrant, left: u8, from: [i64; 2], f0: i64) -> Result<Core, InputError> {
        let ArcPath { center: [cx, cy], bits, clockwise, .. } = self.path;
        let falling = from[0] - if left == 0 { self.cut.to[0] } else { 0 };
        let rising = match left {
            0 => self.cut.to[1],
            _ if self.carries => (1 << bits) - 1,
            // a start point off the circle may be a little beyond the axis point
            1 => self.axis().max(self.cut.to[0]).max(from[1]),
            _ => self.axis().max(from[1]),
        } - from[1];
        let [xh, yh] = from;
        let core = (self.build)(ArcInput { xh, yh, dx: falling, dy: rising, f0, clockwise: false, bits })?;
        Ok(Mirrored::new(core, y_falls(quadrant, clockwise), negative(quadrant), [cx, cy, 0]))
    }

    /// Where the circle meets an axis, to the nearest whole coordinate.
    fn axis(&self) -> i64 {
        let root = self.cut.radius.isqrt();
        // (root + ½)² = root² + root + ¼
        (root + i128::from(self.cut.radius > root * root + root)) as i64
    }
}

type Core = Mirrored<Box<dyn Interpolator>>;

/// An arc through any number of quadrants: arcs of the first quadrant, one after another.
///
/// In each quadrant one coordinate falls and the other rises (without their signs), as x and y do counter-clockwise in
/// the first; the two change places from quadrant to quadrant, and with the direction. A quadrant that is not the last goes on until the falling coordinate is 0, with the counter of
/// the rising one at its greatest, so that it does not end it. Then comes **one clock without a step**, in which the
/// next arc is loaded: the circuit needs it. `KOX` and `KOY` are those of the quadrant that is being drawn.
///
/// A method with an evaluation function carries `F` over: nothing is lost between quadrants. One without (DDA) begins
/// every quadrant with fresh accumulators, and ends the earlier ones on the point of the axis nearest to the circle, so
/// that no error goes on into the next.
///
/// Two rules keep every arc going. The circle of radius 1 goes through its centre, where the falling coordinate is 0 but
/// the rising one too: there the quadrant does not change yet. And the last quadrant does not begin before the rising
/// coordinate, which falls there, is as great as the end point's, which may lie a little outside the circle.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcPath, EfCircle, Quadrants};
/// // from (3, 4) over the y axis to (-4, 3)
/// let path = ArcPath { center: [0, 0], from: [3, 4], to: [-4, 3], full: true, long: None, clockwise: false, f0: 0, bits: 8 };
/// let arc = Quadrants::new(path, true, |input| Ok(Box::new(EfCircle::new(input)?)))?;
/// let clocks: Vec<_> = arc.collect();
/// assert_eq!(clocks.iter().map(|clock| clock.letter()).collect::<String>(), "XYXX-YXXXYX");
/// assert_eq!(clocks.last().unwrap().at, [-4, 3, 0]);
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
pub struct Quadrants {
    plan: Plan,
    quadrant: Quadrant,
    /// Crossings left.
    left: u8,
    core: Core,
    refused: Option<InputError>,
}

impl Quadrants {
    /// `build` makes the arcs of the first quadrant; `carries`: their first sum is `F` and goes on in the next one.
    ///
    /// # Errors
    /// A start point that is the centre, points too far from the circle or too wide for the registers, and what `build`
    /// refuses.
    pub fn new(
        path: ArcPath,
        carries: bool,
        build: impl Fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError> + 'static,
    ) -> Result<Self, InputError> {
        let cut = path.cut()?;
        let plan = Plan { build: Box::new(build), path, cut, carries };
        let core = plan.arc(cut.quadrant, cut.crossings, cut.from, path.f0)?;
        Ok(Quadrants { plan, quadrant: cut.quadrant, left: cut.crossings, core, refused: None })
    }

    /// The registers, as the whole arc sees them.
    fn clock(&self, clock: Clock) -> Clock {
        Clock { end: clock.end && self.left == 0, ..clock }
    }

    /// The falling and the rising coordinate.
    fn at(&self) -> [i64; 2] {
        let ArcPath { center, clockwise, .. } = self.plan.path;
        let [x, y, _] = self.core.state().at;
        falling_rising([x - center[0], y - center[1]], self.quadrant, clockwise)
    }

    /// The next clock changes the quadrant.
    fn due(&self) -> bool {
        let [falling, rising] = self.at();
        match self.left {
            0 => false,
            _ if !self.plan.carries => self.core.state().end,
            1 => falling == 0 && rising >= self.plan.cut.to[0].max(1),
            _ => falling == 0 && rising > 0,
        }
    }

    /// Changes the quadrant; what falls now is what rose.
    fn cross(&mut self) -> Result<Clock, InputError> {
        let ([_, rising], f) = (self.at(), self.core.state().sum[0]);
        let quadrant = if self.plan.path.clockwise { self.quadrant + 3 } else { self.quadrant + 1 } & 3;
        self.core = self.plan.arc(quadrant, self.left - 1, [rising, 0], if self.plan.carries { f } else { 0 })?;
        (self.quadrant, self.left) = (quadrant, self.left - 1);
        Ok(self.state())
    }
}

impl Iterator for Quadrants {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        if self.refused.is_some() {
            return None;
        }
        if self.due() {
            return self.cross().map_err(|refused| self.refused = Some(refused)).ok();
        }
        self.core.next().map(|clock| self.clock(clock))
    }
}

impl Interpolator for Quadrants {
    fn state(&self) -> Clock {
        self.clock(self.core.state())
    }

    fn columns(&self) -> Columns {
        self.core.columns()
    }

    fn stopped(&self) -> Option<Stopped> {
        self.refused.map(Stopped::Refused).or_else(|| self.core.stopped())
    }
}

#[cfg(test)]
#[path = "quadrant_tests.rs"]
mod tests;
