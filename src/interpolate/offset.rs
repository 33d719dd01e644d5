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
