//! A curve of the second order as an interpolator is given it, and its motion in closed form.
//!
//! With `(x', y') = ∓(Bx + 2Cy + E, −(2Ax + By + D))` the velocity is linear in the point, and its second derivative is
//! `−δ` times the velocity, `δ = 4AC − B²`. So the point that is `τ` further along the curve is known: by cosine and sine
//! where `δ > 0` (ellipse), by e^±λτ where `δ < 0` (hyperbola), by a polynomial where `δ = 0` (parabola, lines). That tells
//! before the first clock whether the end point lies ahead, when it will be reached (`τ·2^bits` clocks), and how great
//! derivatives and coordinates get on the way. The interpolator itself knows nothing of this.

use crate::InputError;
use crate::input::{check_bits, check_signed};

/// How near the end point counts as having got there, BLU along each axis: the path then goes straight to it. The path
/// may be a few BLU off the curve, and would else pass the end point by.
pub const REACH: i64 = 3;

/// A part of the curve `A·x² + B·xy + C·y² + D·x + E·y + F = 0` between two points, and the width of the registers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CurveInput {
    /// `A` to `F`: `A` to `E` of `bits + 1` bits in two's complement. `F` is in no register.
    pub coefficients: [i64; 6],
    /// `XH`, `YH` in BLU: `−2^(bits−1) ≤ xh < 2^(bits−1)`.
    pub start: [i64; 2],
    /// `XK`, `YK`; as `start`. The start point: the whole of a closed curve.
    pub end: [i64; 2],
    /// Against the direction that is counter-clockwise on a circle `x² + y² = R²`.
    pub clockwise: bool,
    /// Bits of an accumulator and of a coordinate, `2..=32`.
    pub bits: u32,
}

/// What is known before the first clock.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Course {
    /// A bound for the watchdog, clocks: half as much again as the motion takes, and 2^(bits+1).
    pub limit: u64,
    /// The end point counts once no more clocks than these are left: after half of the motion, of a closed curve after
    /// three quarters. The path may pass near it before, and the whole of a closed curve begins there.
    pub last: u64,
}

impl CurveInput {
    /// The polynomial.
    #[must_use]
    pub fn value(&self, [x, y]: [i64; 2]) -> i128 {
        let [a, b, c, d, e, f] = self.coefficients.map(i128::from);
        let (x, y) = (i128::from(x), i128::from(y));
        a * x * x + b * x * y + c * y * y + d * x + e * y + f
    }

    /// `2Ax + By + D` and `Bx + 2Cy + E`.
    #[must_use]
    pub fn gradient(&self, [x, y]: [i64; 2]) -> [i128; 2] {
        let [a, b, c, d, e, _] = self.coefficients.map(i128::from);
        let (x, y) = (i128::from(x), i128::from(y));
        [2 * a * x + b * y + d, b * x + 2 * c * y + e]
    }

    /// Refuses what the registers cannot hold and what cannot be drawn; else what is known of the course.
    ///
    /// # Errors
    /// A width that is not possible; a coefficient or coordinate that does not fit; no curve; a start or end point that is
    /// more than about a BLU from the curve: `|F(x, y)| > max(|2Ax + By + D|, |Bx + 2Cy + E|) + (|A| + |B| + |C|)/4`,
    /// which rounding to whole BLU never gives; a start point at which the curve has no direction; an end point that does
    /// not lie ahead; derivatives or coordinates that pass what the registers hold on the way.
    pub fn course(&self) -> Result<Course, InputError> {
        check_bits(self.bits)?;
        if self.bits < 2 {
            return Err(InputError::FewBits { bits: self.bits, least: 2 });
        }
        for (name, value) in ["XH", "YH", "XK", "YK"].into_iter().zip(self.start.into_iter().chain(self.end)) {
            check_signed(name, value, self.bits)?;
        }
        for (name, value) in ["A", "B", "C", "D", "E"].into_iter().zip(self.coefficients) {
            check_signed(name, value, self.bits + 1)?;
        }
        if self.coefficients[..5] == [0; 5] {
            return Err(InputError::NoCurve);
        }
        let [start, end] = [self.near(self.start)?, self.near(self.end)?];
        let motion = Motion::new(self, start);
        let time = motion.time_to(self, end)?;
        self.check_extent(&motion, time)?;
        let full = libm::ldexp(1.0, self.bits.cast_signed());
        let limit = ((1.5 * time + 2.0).ceil() * full) as u64;
        let part = if self.determinant() > 0 { 0.75 } else { 0.5 };
        Ok(Course { limit, last: limit - (part * time * full) as u64 })
    }

    /// The point of the curve near a given one.
    fn near(&self, point: [i64; 2]) -> Result<[f64; 2], InputError> {
        let gradient = self.gradient(point);
        if gradient == [0; 2] {
            return Err(InputError::NoDirection { point });
        }
        let (value, [a, b, c, ..]) = (self.value(point), self.coefficients.map(i128::from));
        let limit = gradient[0].abs().max(gradient[1].abs()) + (a.abs() + b.abs() + c.abs()) / 4;
        let off = InputError::OffCurve { point, value, limit };
        if value.abs() > limit {
            return Err(off);
        }
        // Newton's method along the gradient
        let [a, b, c, d, e, f] = self.coefficients.map(|v| v as f64);
        let mut p = point.map(|v| v as f64);
        for _ in 0..32 {
            let [x, y] = p;
            let value = a * x * x + b * x * y + c * y * y + d * x + e * y + f;
            let [gx, gy] = [2.0 * a * x + b * y + d, b * x + 2.0 * c * y + e];
            let square = gx * gx + gy * gy;
            if square == 0.0 {
                return Err(off);
            }
            p = [x - value * gx / square, y - value * gy / square];
        }
        // an empty curve, x² + y² + 1 = 0, is near to nothing
        let far = (0..2).any(|i| (p[i] - point[i] as f64).abs() > REACH as f64);
        if far || !p[0].is_finite() || !p[1].is_finite() { Err(off) } else { Ok(p) }
    }

    /// `4AC − B²`.
    fn determinant(&self) -> i128 {
        let [a, b, c, ..] = self.coefficients.map(i128::from);
        4 * a * c - b * b
    }

    /// The start point is in reach of the end point.
    fn meets(&self) -> bool {
        (0..2).all(|i| (self.end[i] - self.start[i]).abs() <= REACH)
    }

    /// The end point is the start point, or lies in the direction that the curve comes from.
    fn behind(&self) -> bool {
        let [gx, gy] = self.gradient(self.start);
        let [dx, dy] = [0, 1].map(|i| i128::from(self.end[i] - self.start[i]));
        let ahead = gx * dy - gy * dx;
        if self.clockwise { ahead >= 0 } else { ahead <= 0 }
    }

    /// Looks along the way for what does not fit. What it does not see between the places it looks at, or on a path further
    /// off the curve, the interpolator does.
    fn check_extent(&self, motion: &Motion, time: f64) -> Result<(), InputError> {
        const PLACES: u32 = 512;
        let (mut derivative, mut coordinate) = (0_f64, 0_f64);
        for i in 0..=PLACES {
            let (point, velocity) = motion.at(time * f64::from(i) / f64::from(PLACES));
            for axis in 0..2 {
                derivative = derivative.max(velocity[axis].abs());
                coordinate = coordinate.max(point[axis].abs());
            }
        }
        // the path may be off the curve, by as much as it may miss the end point
        let [a, b, c, ..] = self.coefficients.map(|v| v.unsigned_abs() as f64);
        let off = if a + b + c > 0.0 { REACH as f64 } else { 0.0 };
        derivative += off * (2.0 * a + b).max(b + 2.0 * c);
        coordinate += off;
        let full = libm::ldexp(1.0, self.bits.cast_signed());
        if derivative >= full || coordinate >= full / 2.0 {
            let [derivative, coordinate] = [derivative, coordinate].map(|v| v.round() as u64);
            return Err(InputError::WideCurve { derivative, coordinate, bits: self.bits });
        }
        Ok(())
    }
}

/// The motion from a point of the curve: point and velocity as functions of `τ`.
struct Motion {
    point: [f64; 2],
    velocity: [f64; 2],
    /// The derivative of the velocity.
    acceleration: [f64; 2],
    /// `δ`.
    determinant: f64,
}

impl Motion {
    fn new(input: &CurveInput, point: [f64; 2]) -> Motion {
        let velocity = velocity(input, point);
        Motion { point, velocity, acceleration: acceleration(input, velocity), determinant: input.determinant() as f64 }
    }

    /// The factors of velocity and acceleration in the way, and in the velocity.
    fn factors(&self, time: f64) -> [[f64; 2]; 2] {
        let w = self.determinant.abs().sqrt();
        let (t, angle) = (time, w * time);
        if self.determinant > 0.0 {
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            [[sin / w, (1.0 - cos) / (w * w)], [cos, sin / w]]
        } else if self.determinant < 0.0 {
            let (sinh, cosh) = (libm::sinh(angle), libm::cosh(angle));
            [[sinh / w, (cosh - 1.0) / (w * w)], [cosh, sinh / w]]
        } else {
            [[t, t * t / 2.0], [1.0, t]]
        }
    }

    fn at(&self, time: f64) -> ([f64; 2], [f64; 2]) {
        let [way, speed] = self.factors(time);
        let sum = |f: [f64; 2], i: usize| f[0] * self.velocity[i] + f[1] * self.acceleration[i];
        ([0, 1].map(|i| self.point[i] + sum(way, i)), [0, 1].map(|i| sum(speed, i)))
    }

    /// When a point of the curve is reached.
    fn time_to(&self, input: &CurveInput, end: [f64; 2]) -> Result<f64, InputError> {
        let not_ahead = Err(InputError::NotAhead { point: input.end });
        let w = self.determinant.abs().sqrt();
        let (v, a) = (self.velocity, self.acceleration);
        let then = velocity(input, end);
        if self.determinant > 0.0 {
            // then = v·cos + a/w·sin
            let area = cross(v, a) / w;
            let angle = libm::atan2(cross(v, then) / area, cross(then, a) / w / area);
            let turn = 2.0 * std::f64::consts::PI;
            let angle = match (input.meets(), input.behind()) {
                (true, true) if angle <= 0.0 => angle + turn,
                (true, true) => turn,
                (true, false) => angle.max(0.0),
                (false, _) if angle < 0.0 => angle + turn,
                (false, _) => angle,
            };
            return Ok(angle / w);
        }
        let time = if self.determinant < 0.0 {
            // a ± w·v grows as e^±wτ
            let part = |sign: f64| {
                let [now, then] = [(v, a), (then, acceleration(input, then))]
                    .map(|(v, a)| [a[0] + sign * w * v[0], a[1] + sign * w * v[1]]);
                (dot(now, then), dot(now, now))
            };
            let (grown, shrunk) = (part(1.0), part(-1.0));
            let use_grown = grown.0.abs() >= shrunk.0.abs();
            let (product, square) = if use_grown { grown } else { shrunk };
            let growth = libm::log(product / square) / w;
            if use_grown { growth } else { -growth }
        } else if a == [0.0; 2] {
            dot([0, 1].map(|i| end[i] - self.point[i]), v) / dot(v, v)
        } else {
            dot([0, 1].map(|i| then[i] - v[i]), a) / dot(a, a)
        };
        if input.meets() && !input.behind() || input.start == input.end {
            return Ok(if time > 0.0 { time } else { 0.0 });
        }
        // of no number too: the logarithm of a negative one
        if !(time > 0.0 && time.is_finite()) {
            return not_ahead;
        }
        // not on a parallel line, nor on the other of two that cross
        let (arrived, _) = self.at(time);
        if (0..2).any(|i| (arrived[i] - end[i]).abs() > REACH as f64) { not_ahead } else { Ok(time) }
    }
}

fn velocity(input: &CurveInput, [x, y]: [f64; 2]) -> [f64; 2] {
    let [a, b, c, d, e, _] = input.coefficients.map(|v| v as f64);
    let sign = if input.clockwise { -1.0 } else { 1.0 };
    [-sign * (b * x + 2.0 * c * y + e), sign * (2.0 * a * x + b * y + d)]
}

fn acceleration(input: &CurveInput, [vx, vy]: [f64; 2]) -> [f64; 2] {
    let [a, b, c, ..] = input.coefficients.map(|v| v as f64);
    let sign = if input.clockwise { -1.0 } else { 1.0 };
    [-sign * (b * vx + 2.0 * c * vy), sign * (2.0 * a * vx + b * vy)]
}

fn cross(p: [f64; 2], q: [f64; 2]) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

fn dot(p: [f64; 2], q: [f64; 2]) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(coefficients: [i64; 6], start: [i64; 2], end: [i64; 2]) -> CurveInput {
        CurveInput { coefficients, start, end, clockwise: false, bits: 8 }
    }

    #[test]
    fn the_time_by_hand() {
        // a quarter of x² + y² = 100 takes (π/2)/2, a whole turn π, three quarters the other way 3π/4
        let quarter = input([1, 0, 1, 0, 0, -10000], [100, 0], [0, 100]);
        let limit = |input: CurveInput| input.course().unwrap().limit;
        let bound = |time: f64| (1.5 * time + 2.0).ceil() as u64 * 256;
        let pi = std::f64::consts::PI;
        assert_eq!(limit(quarter), bound(pi / 4.0));
        assert_eq!(limit(CurveInput { end: [100, 0], ..quarter }), bound(pi));
        assert_eq!(limit(CurveInput { clockwise: true, ..quarter }), bound(pi * 0.75));
        // the line (5, 3): x' = 5, y' = 3, so at time 10 it is at (50, 30)
        assert_eq!(limit(input([0, 0, 0, 3, -5, 0], [0, 0], [50, 30])), bound(10.0));
        // y² = 4x: x' = −2y, y' = −4, from (25, 10) to (25, −10) in 5
        assert_eq!(limit(input([0, 0, 1, -4, 0, 0], [25, 10], [25, -10])), bound(5.0));
        // xy = 64, from (64, 1) to (1, 64): x' = −x
        assert_eq!(limit(input([0, 1, 0, 0, 0, -64], [64, 1], [1, 64])), bound(f64::ln(64.0)));
    }

    #[test]
    fn the_end_point_counts_when_it_is_due() {
        let waits = |end, clockwise| {
            let circle = input([1, 0, 1, 0, 0, -10000], [100, 0], end);
            let course = CurveInput { clockwise, ..circle }.course().unwrap();
            course.limit - course.last
        };
        // three quarters of π·256 clocks; from (100, 0) to (100, 2) it is 2 BLU, or all but 2
        let turn = (0.75 * std::f64::consts::PI * 256.0) as u64;
        assert_eq!([waits([100, 0], false), waits([100, 0], true)], [turn; 2]);
        assert!(waits([100, 2], false) < 4 && waits([100, -2], true) < 4);
        assert!(waits([100, -2], false) > turn - 8 && waits([100, 2], true) > turn - 8);
        // half of the line's 256
        let line = input([0, 0, 0, 3, -5, 0], [0, 0], [5, 3]).course().unwrap();
        assert_eq!(line.limit - line.last, 128);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_with_its_limit() {
        let message = |input: CurveInput| input.course().unwrap_err().to_string();
        let circle = input([1, 0, 1, 0, 0, -100], [10, 0], [0, 10]);
        assert!(circle.course().is_ok());
        assert_eq!(message(input([0, 0, 0, 0, 0, 0], [0, 0], [1, 1])), "A, B, C, D and E are all 0: there is no curve");
        assert_eq!(
            message(CurveInput { start: [12, 0], ..circle }),
            "(12, 0) is not near the curve: Ax² + Bxy + Cy² + Dx + Ey + F is 44 there, and may be -24 to 24"
        );
        assert_eq!(
            message(CurveInput { start: [0, 0], ..circle }),
            "the curve has no direction at (0, 0): 2Ax + By + D and Bx + 2Cy + E are both 0"
        );
        assert_eq!(
            message(CurveInput { coefficients: [300, 0, 1, 0, 0, -100], ..circle }),
            "A = 300 is outside -256..255, what 9 bits hold in two's complement"
        );
        assert_eq!(
            message(CurveInput { end: [0, 128], ..circle }),
            "YK = 128 is outside -128..127, what 8 bits hold in two's complement"
        );
        // 20² + 20² = 28.3²: on the way x gets to 28, and 2·A·x to 20·28
        assert_eq!(
            message(input([10, 0, 10, 0, 0, -8000], [20, 20], [-20, 20])),
            "on the way 2Ax + By + D or Bx + 2Cy + E gets to ±626 and a coordinate to ±31: \
             with 8 bits they have to be below 256 and 128"
        );
        let behind = "the end point (-5, -3) does not lie ahead of the start point in the direction asked for: \
                      it is behind it or on another branch";
        assert_eq!(message(input([0, 0, 0, 3, -5, 0], [0, 0], [-5, -3])), behind);
        // the other branch of xy = 15, and the other of two parallel lines, and of two that cross
        assert_eq!(message(input([0, 1, 0, 0, 0, -15], [5, 3], [-5, -3])), behind);
        assert!(message(input([1, 0, 0, 0, 0, -100], [10, 0], [-10, 20])).contains("another branch"));
        assert!(message(input([1, 0, -1, 0, 0, 0], [10, 10], [20, -20])).contains("another branch"));
        assert!(message(input([1, 0, 1, 0, 0, 1], [1, 0], [1, 0])).contains("not near the curve"));
        assert!(message(CurveInput { bits: 1, ..circle }).starts_with("registers of 1 bits"));
    }

    #[test]
    fn the_widest() {
        let most = (1 << 31) - 1;
        let line = CurveInput { bits: 32, ..input([0, 0, 0, 1, -1, 0], [-most, -most], [most, most]) };
        assert_eq!(line.course().unwrap().limit, u64::MAX);
        let far = [i64::MAX, i64::MIN, i64::MAX, i64::MIN, i64::MAX, i64::MIN];
        assert!(CurveInput { bits: 32, ..input(far, [most, -most], [-most, most]) }.course().is_err());
    }
}
