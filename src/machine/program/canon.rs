//! What a program says, without modes: canonical moves, and what they are counted from.

use std::fmt;

use super::arc::Arc;
use super::decimal::Decimal;

/// The unit of length of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Units {
    /// G21.
    Millimetres,
    /// G20.
    Inches,
}

impl Units {
    /// A length in this unit, in millimetres.
    #[must_use]
    pub const fn to_mm(self, length: Decimal) -> Decimal {
        match self {
            Units::Millimetres => length,
            Units::Inches => length.inches(),
        }
    }

    /// Millimetres in this unit.
    #[must_use]
    pub fn from_mm(self, length: f64) -> f64 {
        if self == Units::Inches { length / 25.4 } else { length }
    }
}

/// The plane of arcs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Plane {
    /// G17.
    Xy,
    /// G18.
    Xz,
    /// G19.
    Yz,
}

impl Plane {
    /// The axes: counter-clockwise goes from the first to the second; the third is upright on both.
    #[must_use]
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Xz => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// How fast a move is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Feed {
    /// G0: as fast as the machine may.
    Rapid,
    /// G94: millimetres a minute along the path.
    PerMinute(Decimal),
    /// G93: so many of these moves a minute.
    Inverse(Decimal),
}

/// The way of a move.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Path {
    /// Straight.
    Line,
    /// An arc in a plane, a helix where the axis upright on it moves too.
    Arc(Arc),
}

/// One move, in millimetres of the machine.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Move {
    /// The start point.
    pub from: [Decimal; 3],
    /// The end point.
    pub to: [Decimal; 3],
    /// The way.
    pub path: Path,
    /// The speed.
    pub feed: Feed,
    /// Where the program's own origin is.
    pub origin: [Decimal; 3],
    /// The program's unit.
    pub units: Units,
}

impl Move {
    /// The length of the way, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        let d = [0, 1, 2].map(|a| (self.to[a] - self.from[a]).to_f64());
        match self.path {
            Path::Line => (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt(),
            Path::Arc(arc) => {
                let around = arc.mean_radius() * arc.sweep(self.from, self.to).abs();
                around.hypot(d[arc.plane.axes()[2]])
            }
        }
    }
}

/// What happens, in the order in which it happens.
#[derive(Clone, PartialEq, Debug)]
pub enum Canon {
    /// The unit of what follows.
    Units(Units),
    /// The plane of what follows.
    Plane(Plane),
    /// A coordinate system, from 1, and its origin in the program's unit.
    System(usize, [Decimal; 3], Units),
    /// The offset of G92.
    Offset([Decimal; 3], Units),
    /// F in G94, as written.
    Feed(Decimal),
    /// A move.
    Move(Move),
    /// G4, seconds.
    Dwell(Decimal),
    /// M0 to M9, M30: not simulated.
    Recorded(i64),
}

/// As `rs274 -g` of LinuxCNC prints it; what that has no line for is empty.
impl fmt::Display for Canon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let zero = "0.0000, 0.0000, 0.0000";
        let point = |p: [Decimal; 3], units: Units| {
            let [x, y, z] = p.map(|v| number(units.from_mm(v.to_f64())));
            format!("{x}, {y}, {z}")
        };
        match self {
            Canon::Units(Units::Inches) => write!(f, "USE_LENGTH_UNITS(CANON_UNITS_INCHES)"),
            Canon::Units(Units::Millimetres) => write!(f, "USE_LENGTH_UNITS(CANON_UNITS_MM)"),
            Canon::Plane(plane) => {
                let name = match plane {
                    Plane::Xy => "XY",
                    Plane::Xz => "XZ",
                    Plane::Yz => "YZ",
                };
                write!(f, "SELECT_PLANE(CANON_PLANE_{name})")
            }
            Canon::System(n, origin, units) => write!(f, "SET_G5X_OFFSET({n}, {}, {zero})", point(*origin, *units)),
            Canon::Offset(offset, units) => write!(f, "SET_G92_OFFSET({}, {zero})", point(*offset, *units)),
            Canon::Feed(feed) => write!(f, "SET_FEED_RATE({feed:.4})"),
            Canon::Dwell(seconds) => write!(f, "DWELL({seconds:.4})"),
            Canon::Recorded(code) => write!(f, "M{code}"),
            Canon::Move(step) => {
                if let Feed::Inverse(times) = step.feed {
                    // it gives a move without a length this speed
                    let rate = step.units.from_mm(step.length()) * times.to_f64();
                    writeln!(f, "SET_FEED_RATE({})", number(rate.max(0.1)))?;
                }
                let end = [0, 1, 2].map(|a| step.to[a] - step.origin[a]);
                match (step.path, step.feed) {
                    (Path::Line, Feed::Rapid) => write!(f, "STRAIGHT_TRAVERSE({}, {zero})", point(end, step.units)),
                    (Path::Line, _) => write!(f, "STRAIGHT_FEED({}, {zero})", point(end, step.units)),
                    (Path::Arc(arc), _) => {
                        let [first, second, third] = arc.plane.axes();
                        let center = [arc.center[0] - step.origin[first], arc.center[1] - step.origin[second]];
                        let all = [end[first], end[second], center[0], center[1], end[third]];
                        let [a, b, c, d, e] = all.map(|v| number(step.units.from_mm(v.to_f64())));
                        let turns = i64::from(arc.turns) * if arc.clockwise { -1 } else { 1 };
                        write!(f, "ARC_FEED({a}, {b}, {c}, {d}, {turns}, {e}, {zero})")
                    }
                }
            }
        }
    }
}

/// Four digits behind the point, and no zero below 0.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    if text == "-0.0000" { "0.0000".to_owned() } else { text }
}
