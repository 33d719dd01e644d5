//! From canonical moves in millimetres to what an interpolator is given, in BLU.
//!
//! Targets are rounded, never increments, so that nothing adds up. Of an arc the centre is rounded and the radius stays:
//! `F₀ = xs² + ys² − R²` says how far off its rounded start point is. Whether an arc is a full circle, a long or a short
//! one is decided before anything is rounded.

use std::f64::consts::PI;

use super::program::{Arc, Code, Decimal, Fault, Feed, Move, Path};
use crate::interpolate::MAX_BITS;

/// An arc with a sagitta below this becomes a line, BLU.
const FLAT: f64 = 0.5;

/// From this on the difference of the radii at start and end is made good by a line, BLU.
const SPIRAL: f64 = 0.5;

/// How millimetres become BLU.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Scale {
    /// So many millimetres are one.
    Blu(Decimal),
    /// So many are a millimetre, along each axis.
    Steps([Decimal; 3]),
}

impl Scale {
    /// A coordinate in whole BLU.
    fn whole(&self, axis: usize, mm: Decimal) -> Option<i64> {
        match self {
            Scale::Blu(blu) => mm.in_units(*blu),
            Scale::Steps(steps) => mm.times_rounded(steps[axis]),
        }
    }

    /// BLU in a millimetre.
    #[must_use]
    pub fn per_mm(&self, axis: usize) -> f64 {
        match self {
            Scale::Blu(blu) => 1.0 / blu.to_f64(),
            Scale::Steps(steps) => steps[axis].to_f64(),
        }
    }

    /// The coordinate without rounding.
    fn exact(&self, axis: usize, mm: Decimal) -> f64 {
        match self {
            Scale::Blu(blu) => mm.to_f64() / blu.to_f64(),
            Scale::Steps(steps) => mm.to_f64() * steps[axis].to_f64(),
        }
    }
}

/// A curve without rounding, BLU.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Curve {
    /// From one point to another.
    Line([f64; 3], [f64; 3]),
    /// Around a centre in the plane of two axes, along a third.
    Arc {
        /// The axes of the plane, and the one upright on it.
        axes: [usize; 3],
        /// The centre.
        center: [f64; 2],
        /// The radius at the start and at the end.
        radii: [f64; 2],
        /// The angle, radians, positive counter-clockwise.
        sweep: f64,
        /// The start point.
        from: [f64; 3],
        /// How far it goes along the third axis.
        rise: f64,
    },
}

/// An arc as an interpolator is given it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PlanArc {
    /// The axes of its plane, and the one upright on it.
    pub axes: [usize; 3],
    /// The rounded centre.
    pub center: [i64; 2],
    /// The start point in the plane.
    pub from: [i64; 2],
    /// The end point in the plane; that of the program, but for a spiral.
    pub to: [i64; 2],
    /// `F₀` of the start point.
    pub f0: i64,
    /// Clockwise.
    pub clockwise: bool,
    /// The last turn ends where it begins.
    pub full: bool,
    /// The last turn is longer than half of one.
    pub long: bool,
    /// Full circles before it.
    pub circles: u32,
}

/// What is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shape {
    /// Nothing: the move is less than half a BLU.
    Nothing,
    /// A line.
    Line,
    /// An arc, and a line from its end to the move's if these differ.
    Arc(PlanArc),
}

/// A move in BLU.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plan {
    /// The rounded start point.
    pub from: [i64; 3],
    /// The rounded end point.
    pub to: [i64; 3],
    /// What is drawn.
    pub shape: Shape,
    /// An arc that is drawn as a line.
    pub flattened: bool,
    /// The program's own curve.
    pub exact: Curve,
    /// The curve between the rounded points.
    pub rounded: Curve,
    /// The length of the exact curve, mm.
    pub mm: f64,
    /// The same in BLU.
    pub length: f64,
    /// The speed.
    pub feed: Feed,
    /// The fewest bits of registers that do.
    pub bits: u32,
}

impl Plan {
    /// Plans a move; `at` is its place in the line.
    ///
    /// # Errors
    /// Coordinates beyond all registers; an arc in a plane whose axes have steps of different sizes.
    pub fn new(step: &Move, scale: &Scale, at: std::ops::Range<usize>) -> Result<Plan, Fault> {
        let (Some(from), Some(to)) = (whole(scale, step.from), whole(scale, step.to)) else {
            return Err(Fault::new(Code::BadMove, at, "this move is beyond what registers of any width hold")
                .help("choose a coarser --blu, or look at the program's unit (G20, G21)"));
        };
        let exact_point = |p: [Decimal; 3]| [0, 1, 2].map(|a| scale.exact(a, p[a]));
        let (a, b) = (exact_point(step.from), exact_point(step.to));
        let line = |exact: Curve, length: f64, flattened: bool| {
            let shape = if from == to { Shape::Nothing } else { Shape::Line };
            let float = |p: [i64; 3]| p.map(|v| v as f64);
            let bits = bits_of(from, to, 0);
            Plan {
                from,
                to,
                shape,
                flattened,
                exact,
                rounded: Curve::Line(float(from), float(to)),
                mm: step.length(),
                length,
                feed: step.feed,
                bits,
            }
        };
        match step.path {
            Path::Line => {
                let d = [0, 1, 2].map(|i| b[i] - a[i]);
                Ok(line(Curve::Line(a, b), (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt(), false))
            }
            Path::Arc(arc) => Plan::arc(step, &arc, scale, at, line),
        }
    }

    fn arc(
        step: &Move,
        arc: &Arc,
        scale: &Scale,
        at: std::ops::Range<usize>,
        line: impl Fn(Curve, f64, bool) -> Plan,
    ) -> Result<Plan, Fault> {
        let axes = arc.plane.axes();
        let [u, v, w] = axes;
        if let Scale::Steps(steps) = scale
            && steps[u] != steps[v]
        {
            let message = "an arc in a plane whose axes have steps of different sizes";
            return Err(Fault::new(Code::BadMove, at, message).help(
                "in steps it is an ellipse, which no interpolator here draws: give both axes as many a millimetre",
            ));
        }
        let per_mm = scale.per_mm(u);
        let sweep = arc.sweep(step.from, step.to);
        let radii = arc.radii.map(|r| r * per_mm);
        let center_exact = [scale.exact(u, arc.center[0]), scale.exact(v, arc.center[1])];
        let exact_point = |p: [Decimal; 3]| [0, 1, 2].map(|a| scale.exact(a, p[a]));
        let (a, b) = (exact_point(step.from), exact_point(step.to));
        let rise = b[w] - a[w];
        let exact = Curve::Arc { axes, center: center_exact, radii, sweep, from: a, rise };
        let length = (sweep * radii[0].midpoint(radii[1])).hypot(rise);
        let flat = line(exact, length, true);
        let (from, to) = (flat.from, flat.to);
        let last = sweep.abs() - 2.0 * PI * f64::from(arc.turns - 1);
        let sagitta = if last >= PI { f64::INFINITY } else { radii[0] * (1.0 - (last / 2.0).cos()) };
        let square = (radii[0] * radii[0]).round();
        if arc.turns == 1 && sagitta < FLAT || square < 1.0 {
            return Ok(flat);
        }
        let center = [scale.whole(u, arc.center[0]), scale.whole(v, arc.center[1])];
        let ([Some(cu), Some(cv)], true) = (center, square < 1e18) else {
            return Err(Fault::new(
                Code::BadMove,
                at,
                "the centre of this arc is beyond what registers of any width hold",
            )
            .help("a radius that great is a straight line at this --blu"));
        };
        let away = [from[u] - cu, from[v] - cv];
        if away == [0, 0] {
            return Ok(flat);
        }
        let f0 = i128::from(away[0]).pow(2) + i128::from(away[1]).pow(2) - square as i128;
        let Ok(f0) = i64::try_from(f0) else {
            return Err(Fault::new(
                Code::BadMove,
                at,
                "the radius of this arc is beyond what registers of any width hold",
            )
            .help("choose a coarser --blu, or look at the program's unit (G20, G21)"));
        };
        let full = step.from[u] == step.to[u] && step.from[v] == step.to[v];
        let end = if (radii[0] - radii[1]).abs() < SPIRAL {
            [to[u], to[v]]
        } else {
            let part = radii[0] / radii[1];
            [
                (cu as f64 + (b[u] - center_exact[0]) * part).round(),
                (cv as f64 + (b[v] - center_exact[1]) * part).round(),
            ]
            .map(|v| v as i64)
        };
        let plan = PlanArc {
            axes,
            center: [cu, cv],
            from: [from[u], from[v]],
            to: end,
            f0,
            clockwise: arc.clockwise,
            full: full || last > PI,
            long: last > PI,
            circles: arc.turns - 1,
        };
        let far = [cu, cv, end[0], end[1]].into_iter().map(i64::unsigned_abs).max().unwrap_or(0);
        let radius = radii[0].max(radii[1]).ceil() as u64 + 2;
        let mut bits = bits_of(from, to, far.max(radius));
        while bits < 62 && f0.unsigned_abs() + 2 >= 2 << bits {
            bits += 1;
        }
        let start = from.map(|v| v as f64);
        let rounded = Curve::Arc {
            axes,
            center: [cu as f64, cv as f64],
            radii: [square.sqrt(); 2],
            sweep,
            from: start,
            rise: (to[w] - from[w]) as f64,
        };
        Ok(Plan { shape: Shape::Arc(plan), flattened: false, rounded, bits, ..flat })
    }

    /// The same end points with a line between them, for an arc of a few BLU that no interpolator takes.
    #[must_use]
    pub fn flatten(&self) -> Plan {
        let float = |p: [i64; 3]| p.map(|v| v as f64);
        let shape = if self.from == self.to { Shape::Nothing } else { Shape::Line };
        Plan { shape, flattened: true, rounded: Curve::Line(float(self.from), float(self.to)), ..*self }
    }

    /// Refuses what registers of `bits` bits cannot hold.
    ///
    /// # Errors
    /// With the width that is needed.
    pub fn check(&self, bits: u32, at: std::ops::Range<usize>) -> Result<(), Fault> {
        if self.bits <= bits {
            return Ok(());
        }
        let message =
            format!("this move needs registers of {} bits: {bits} hold at most {}", self.bits, (1_u64 << bits) - 1);
        let help = if self.bits <= MAX_BITS {
            format!("give --bits {}, or a coarser --blu", self.bits)
        } else {
            format!("the widest have {MAX_BITS}: choose a coarser --blu, or look at the program's unit (G20, G21)")
        };
        Err(Fault::new(Code::BadMove, at, message).help(help))
    }

    /// The speed along the path, BLU a second; `rapid` is that of G0 in mm/min.
    #[must_use]
    pub fn speed(&self, rapid: f64) -> f64 {
        let mm_a_minute = match self.feed {
            Feed::Rapid => rapid,
            Feed::PerMinute(feed) => feed.to_f64(),
            Feed::Inverse(times) => self.mm * times.to_f64(),
        };
        if self.mm == 0.0 { 0.0 } else { mm_a_minute / 60.0 * self.length / self.mm }
    }
}

fn whole(scale: &Scale, p: [Decimal; 3]) -> Option<[i64; 3]> {
    match [0, 1, 2].map(|a| scale.whole(a, p[a])) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// Bits for these coordinates, with a sign, their differences and `more`, without.
fn bits_of(from: [i64; 3], to: [i64; 3], more: u64) -> u32 {
    let all = (0..3).flat_map(|a| [from[a].unsigned_abs(), to[a].unsigned_abs(), from[a].abs_diff(to[a])]);
    let most = all.chain([more]).max().unwrap_or(0);
    (u64::BITS - most.leading_zeros()).max(1)
}
