//! The equidistant: the path of a tool's centre, beside the contour by the tool's radius (document C).
//!
//! A line is moved along its normal, an arc gets another radius. The points found are rounded to BLU; what that does to
//! an arc is made good by its `F₀`.

use std::{error, fmt, str::FromStr};

use super::quadrant::ArcPath;
use super::{Ideal, InputError, MAX_BITS};

/// On which side of the contour the tool goes, seen in the direction of its travel.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum Side {
    /// `left`
    Left,
    /// `right`
    Right,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(if *self == Side::Left { "left" } else { "right" })
    }
}

impl FromStr for Side {
    type Err = UnknownSide;

    fn from_str(name: &str) -> Result<Self, UnknownSide> {
        match name {
            "left" => Ok(Side::Left),
            "right" => Ok(Side::Right),
            _ => Err(UnknownSide(name.to_owned())),
        }
    }
}

/// Neither `left` nor `right`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnknownSide(String);

impl fmt::Display for UnknownSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no side is called '{}'; there is left, right", self.0)
    }
}

impl error::Error for UnknownSide {}

/// How far beside the contour the tool goes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Offset {
    /// The tool's radius in BLU.
    pub radius: u32,
    /// On which side.
    pub side: Side,
}

impl Offset {
    /// The line beside the line from `from` to `to`: both points moved by `r` along the normal, `(−ΔY, ΔX)·r/L` on the
    /// left, to the nearest BLU. As both move alike, `ΔX` and `ΔY` stay.
    ///
    /// # Errors
    /// A line without a length, or too long for 64 bits.
    pub fn line(&self, from: [i64; 2], to: [i64; 2]) -> Result<OffsetLine, InputError> {
        let increment = |axis: usize| to[axis].checked_sub(from[axis]).ok_or(InputError::Overflow);
        let d = [increment(0)? as f64, increment(1)? as f64];
        let length = length(d);
        if length == 0.0 {
            return Err(InputError::NoSide);
        }
        let r = f64::from(self.radius) * if self.side == Side::Left { 1.0 } else { -1.0 };
        let by = [-d[1] / length * r, d[0] / length * r];
        let moved = |point: [i64; 2]| -> Result<[i64; 2], InputError> {
            let [Some(x), Some(y)] = [0, 1].map(|axis| point[axis].checked_add(by[axis].round() as i64)) else {
                return Err(InputError::Overflow);
            };
            Ok([x, y])
        };
        let exact = |[x, y]: [i64; 2]| [x as f64 + by[0], y as f64 + by[1], 0.0];
        let ideal = Ideal::Segment { from: exact(from), to: exact(to) };
        Ok(OffsetLine { from: moved(from)?, to: moved(to)?, ideal })
    }

    /// The arc beside an arc: `R' = R − r` on the side of the centre, which is left of a counter-clockwise arc and right
    /// of a clockwise one, else `R' = R + r`. Its ends are the contour's, moved along their radii to the nearest BLU;
    /// `F₀ = xs² + ys² − R'²`, a whole number too, says how far off the rounded start point is.
    ///
    /// An arc so short that both its ends come to the same point has nothing left to draw, and is not taken for a full
    /// circle.
    ///
    /// # Errors
    /// `R' ≤ 0`: the tool is too great for the arc. What [`Quadrants`](super::Quadrants) refuses of the contour.
    pub fn arc(&self, contour: ArcPath) -> Result<OffsetArc, InputError> {
        let ArcPath { center, from, to, clockwise, .. } = contour;
        let square = ArcPath { bits: MAX_BITS, ..contour }.radius_squared()?;
        let (arc, tool) = ((square as f64).sqrt(), f64::from(self.radius));
        let inside = (self.side == Side::Left) != clockwise;
        let tool_square = i128::from(self.radius) * i128::from(self.radius);
        if inside && square <= tool_square {
            return Err(InputError::TooGreatTool { radius: self.radius, square });
        }
        let radius = if inside { arc - tool } else { arc + tool };
        let between = (2.0 * arc * tool).round() as i128;
        let new_square = square + tool_square + if inside { -between } else { between };
        // each end on the radius through the contour's
        let end = |point: [i64; 2]| -> Result<[f64; 2], InputError> {
            let d = contour.relative(point)?.map(|v| v as f64);
            let length = length(d);
            if length == 0.0 { Err(InputError::ZeroRadius) } else { Ok(d.map(|v| v / length * radius)) }
        };
        let (start, stop) = (end(from)?, end(to)?);
        let rounded = |d: [f64; 2]| [0, 1].map(|axis| center[axis] + d[axis].round() as i64);
        let [x, y] = start.map(|v| v.round() as i128);
        let turned = start[0] * stop[1] - start[1] * stop[0];
        let short = if clockwise { turned < 0.0 } else { turned > 0.0 };
        let path = ArcPath {
            from: rounded(start),
            to: rounded(stop),
            f0: i64::try_from(x * x + y * y - new_square).map_err(|_| InputError::Overflow)?,
            full: contour.full && !short,
            long: None,
            ..contour
        };
        let exact = |d: [f64; 2]| [center[0] as f64 + d[0], center[1] as f64 + d[1]];
        let mut ideal = Ideal::arc(center.map(|v| v as f64), exact(start), exact(stop), clockwise);
        if let Ideal::Arc { radius: r, .. } = &mut ideal {
            *r = radius;
        }
        Ok(OffsetArc { path, ideal })
    }
}

/// A line beside a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OffsetLine {
    /// Its start point, rounded to BLU.
    pub from: [i64; 2],
    /// Its end point, rounded to BLU.
    pub to: [i64; 2],
    /// The line that is not rounded.
    pub ideal: Ideal,
}

/// An arc beside an arc.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OffsetArc {
    /// What is to be drawn.
    pub path: ArcPath,
    /// The arc that is not rounded.
    pub ideal: Ideal,
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EfCircle, Method, Quadrants, Request};

    fn offset(radius: u32, side: Side) -> Offset {
        Offset { radius, side }
    }

    #[test]
    fn lines_by_hand() {
        // (4, 3) has the normal (-3, 4)/5 on its left
        let line = offset(10, Side::Left).line([1, 2], [5, 5]).unwrap();
        assert_eq!((line.from, line.to), ([-5, 10], [-1, 13]));
        let line = offset(10, Side::Right).line([1, 2], [5, 5]).unwrap();
        assert_eq!((line.from, line.to), ([7, -6], [11, -3]));
        // backwards the sides are exchanged
        let line = offset(10, Side::Left).line([5, 5], [1, 2]).unwrap();
        assert_eq!((line.from, line.to), ([11, -3], [7, -6]));
        // 3·(-1, 1)/√2 = (-2.12, 2.12); the ideal is not rounded
        let line = offset(3, Side::Left).line([0, 0], [7, 7]).unwrap();
        assert_eq!((line.from, line.to), ([-2, 2], [5, 9]));
        assert!((line.ideal.deviation([-2.0, 2.0, 0.0]) - (8.0_f64.sqrt() - 3.0)).abs() < 1e-12);
        assert_eq!(offset(3, Side::Left).line([2, 2], [2, 2]), Err(InputError::NoSide));
        assert_eq!(offset(3, Side::Left).line([i64::MIN, 0], [1, 0]), Err(InputError::Overflow));
        assert_eq!(offset(3, Side::Left).line([0, i64::MAX], [1, i64::MAX]), Err(InputError::Overflow));
    }

    fn circle(path: ArcPath) -> Result<Quadrants, InputError> {
        Quadrants::new(path, true, |input| Ok(Box::new(EfCircle::new(input)?)))
    }

    fn contour(from: [i64; 2], to: [i64; 2], clockwise: bool) -> ArcPath {
        ArcPath { center: [0; 2], from, to, full: true, long: None, clockwise, f0: 0, bits: 12 }
    }

    #[test]
    fn arcs_by_hand() {
        let quarter = contour([30, 40], [-40, 30], false);
        // radius 50: the tool of 10 goes inside on 40 to the left, outside on 60 to the right
        let inside = offset(10, Side::Left).arc(quarter).unwrap();
        assert_eq!((inside.path.from, inside.path.to, inside.path.f0), ([24, 32], [-32, 24], 0));
        let outside = offset(10, Side::Right).arc(quarter).unwrap();
        assert_eq!((outside.path.from, outside.path.to, outside.path.f0), ([36, 48], [-48, 36], 0));
        // clockwise the other way round
        let back = offset(10, Side::Left).arc(contour([-40, 30], [30, 40], true)).unwrap();
        assert_eq!((back.path.from, back.path.to, back.path.f0), ([-48, 36], [36, 48], 0));
        // 47 outside: (28.2, 37.6) is rounded to (28, 38), and 28² + 38² - 47² = 19
        let rounded = offset(3, Side::Left).arc(quarter).unwrap();
        assert_eq!((rounded.path.from, rounded.path.to, rounded.path.f0), ([28, 38], [-38, 28], 19));
        // R² = 50, R' = √50 + 2 = 9.071 and R'² = 82.284; (6.41, 6.41) is rounded to (6, 6): 72 - 82
        let odd = offset(2, Side::Right).arc(contour([5, 5], [-5, 5], false)).unwrap();
        assert_eq!((odd.path.from, odd.path.to, odd.path.f0), ([6, 6], [-6, 6], -10));
        let Ideal::Arc { radius, .. } = odd.ideal else { unreachable!() };
        assert!((radius - 9.0710678).abs() < 1e-6);
    }

    #[test]
    fn a_tool_that_does_not_fit_is_refused() {
        let quarter = contour([30, 40], [-40, 30], false);
        for radius in [50, 51, u32::MAX] {
            let error = offset(radius, Side::Left).arc(quarter).unwrap_err();
            let expected =
                format!("a tool of radius {radius} does not fit into an arc of radius 50.00: its path has to");
            assert!(error.to_string().starts_with(&expected), "{error}");
            assert!(offset(radius, Side::Right).arc(quarter).is_ok());
        }
        // what is left is a radius of 0.07: its start point is rounded to the centre
        let point = offset(7, Side::Left).arc(contour([5, 5], [-5, 5], false)).unwrap().path;
        assert_eq!(point.from, [0, 0]);
        assert_eq!(circle(point).err(), Some(InputError::ZeroRadius));
        // the contour itself has to be one
        assert!(matches!(offset(1, Side::Left).arc(contour([5, 0], [0, 9], false)), Err(InputError::OffCircle { .. })));
        assert_eq!(offset(1, Side::Left).arc(contour([0, 0], [0, 0], false)), Err(InputError::ZeroRadius));
    }

    /// A short arc whose two ends come to one point is nothing, a long one a full circle.
    #[test]
    fn ends_that_come_together() {
        let clocks = |from, to, clockwise| {
            let request = Request {
                from,
                clockwise,
                offset: Some(offset(45, if clockwise { Side::Right } else { Side::Left })),
                ..Request::new(Method::EfCircle, to)
            };
            request.draw().unwrap().interpolator.count()
        };
        // radius 50 to 5: (50, 0) and (50, 1) both come to (5, 0)
        assert_eq!(clocks([50, 0, 0], [50, 1, 0], false), 0);
        assert_eq!(clocks([50, 1, 0], [50, 0, 0], true), 0);
        assert_eq!(clocks([50, 1, 0], [50, 0, 0], false), 8 * 5 + 3);
        assert_eq!(clocks([50, 0, 0], [50, 0, 0], true), 8 * 5 + 3);
    }

    /// How far off the exact equidistant the path is: with `F₀`, and without it, on a circle through the rounded start point.
    #[test]
    fn f0_makes_good_the_rounding_of_the_start_point() {
        let (mut with, mut without, mut least, mut arcs) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
        let points = (-24..=24).flat_map(|x| (-24..=24).map(move |y| [x, y])).filter(|&p| p != [0_i64, 0]);
        for (n, from) in points.enumerate() {
            let contour = contour(from, [-from[1], from[0]], n % 2 == 0);
            for (radius, side) in [1, 2, 3, 5, 8].into_iter().flat_map(|r| [(r, Side::Left), (r, Side::Right)]) {
                let Ok(OffsetArc { path, ideal }) = offset(radius, side).arc(contour) else { continue };
                let worst = |f0: i64| {
                    let path = circle(ArcPath { f0, ..path }).ok()?;
                    Some(path.map(|c| ideal.deviation(c.at.map(|v| v as f64)).abs()).fold(0.0, f64::max))
                };
                let Ideal::Arc { radius, .. } = ideal else { unreachable!() };
                let (Some(a), Some(b)) = (worst(path.f0), worst(0)) else { continue };
                arcs += 1;
                match radius < 2.0 {
                    true => least = least.max(a),
                    false => (with, without) = (with.max(a), without.max(b)),
                }
            }
        }
        println!(
            "{arcs} arcs: at most {with:.4} BLU off with F₀, {without:.4} without; {least:.4} below a radius of 2"
        );
        // (5, 1), a tool of 3 inside: R' = √26 - 3 = 2.099, and the path goes over a point at 1
        assert!((with - (26.0_f64.sqrt() - 4.0)).abs() < 1e-9, "{with}");
        assert!((1.60..1.65).contains(&without), "{without}");
        // up to R'² = 1.5, which is rounded to 1, the path goes through the centre
        assert!(least * least < 1.5, "{least}");
    }
}
