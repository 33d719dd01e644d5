//! How far a path of steps is from a curve, and how far along it has come.

use super::plan::Curve;

/// Follows a path along a curve, point by point.
#[derive(Clone, Copy, Debug)]
pub struct Follow {
    curve: Curve,
    /// A line's direction; an arc's angle so far.
    unit: [f64; 3],
    angle: f64,
    /// BLU of way a radian, with the rise.
    per_radian: f64,
    /// The last point from the centre.
    last: [f64; 2],
}

/// Where a point is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Where {
    /// The distance from the curve, BLU.
    pub off: f64,
    /// The way along the curve from its start, BLU.
    pub along: f64,
}

impl Follow {
    /// Begins at the start of the curve, with the point where the path begins.
    #[must_use]
    pub fn new(curve: Curve, start: [f64; 3]) -> Follow {
        let mut follow = Follow { curve, unit: [0.0; 3], angle: 0.0, per_radian: 0.0, last: [0.0; 2] };
        match curve {
            Curve::Line(from, to) => {
                let d = [0, 1, 2].map(|i| to[i] - from[i]);
                let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                if length > 0.0 {
                    follow.unit = d.map(|v| v / length);
                }
            }
            Curve::Arc { axes, center, radii, sweep, rise, from } => {
                follow.per_radian = (radii[0].midpoint(radii[1])).hypot(rise / sweep) * sweep.signum();
                let point = |p: [f64; 3]| [p[axes[0]] - center[0], p[axes[1]] - center[1]];
                let (ideal, real) = (point(from), point(start));
                follow.angle = turned(ideal, real);
                follow.last = real;
            }
        }
        follow
    }

    /// Goes on to a point next to the last one.
    #[inline]
    pub fn to(&mut self, point: [f64; 3]) -> Where {
        match self.curve {
            Curve::Line(from, _) => {
                let p = [0, 1, 2].map(|i| point[i] - from[i]);
                let u = self.unit;
                let along = p[0] * u[0] + p[1] * u[1] + p[2] * u[2];
                let cross = [p[1] * u[2] - p[2] * u[1], p[2] * u[0] - p[0] * u[2], p[0] * u[1] - p[1] * u[0]];
                let square = cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2];
                Where { off: square.sqrt(), along }
            }
            Curve::Arc { axes, center, radii, sweep, from, rise } => {
                let p = [point[axes[0]] - center[0], point[axes[1]] - center[1]];
                self.angle += turned(self.last, p);
                self.last = p;
                let part = self.angle / sweep;
                let radius = if radii[0] == radii[1] {
                    radii[0]
                } else {
                    radii[0] + (radii[1] - radii[0]) * part.clamp(0.0, 1.0)
                };
                let across = (p[0] * p[0] + p[1] * p[1]).sqrt() - radius;
                let off = if rise == 0.0 {
                    across.abs().max((point[axes[2]] - from[axes[2]]).abs())
                } else {
                    // the rise is steep where the arc is short: what lies between two points of the helix
                    let up = point[axes[2]] - from[axes[2]] - rise * part;
                    across.hypot(up * (radii[0] * sweep).abs() / (radii[0] * sweep).hypot(rise))
                };
                Where { off, along: self.angle * self.per_radian }
            }
        }
    }
}

/// The angle from one direction to another near it.
#[inline]
fn turned(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (cross, dot) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
    // a step is at most √2 long: beyond 100 BLU the tangent is small, and two terms of its series are exact to 10^−11
    if dot > 1e4 && cross.abs() < dot * 0.02 {
        let t = cross / dot;
        t * (1.0 - t * t / 3.0)
    } else {
        libm::atan2(cross, dot)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn distances_by_hand() {
        let mut line = Follow::new(Curve::Line([0.0; 3], [4.0, 3.0, 0.0]), [0.0; 3]);
        assert_eq!(line.to([0.0, 5.0, 0.0]), Where { off: 4.0, along: 3.0 });
        let mut space = Follow::new(Curve::Line([1.0; 3], [1.0, 1.0, 9.0]), [1.0; 3]);
        assert_eq!(space.to([4.0, 5.0, 2.0]), Where { off: 5.0, along: 1.0 });
    }

    /// Two and a half turns in small steps, in the plane XZ: first z, then x.
    #[test]
    fn angles_add_up_over_turns() {
        for radius in [5.0, 500.0] {
            let curve = Curve::Arc {
                axes: [2, 0, 1],
                center: [10.0, 20.0],
                radii: [radius; 2],
                sweep: -5.0 * PI,
                from: [20.0, 7.0, 10.0 + radius],
                rise: 0.0,
            };
            let mut follow = Follow::new(curve, [20.0, 7.0, 10.0 + radius]);
            let mut last = Where { off: 9.0, along: 9.0 };
            for i in 1..=50_000 {
                let angle = -5.0 * PI * f64::from(i) / 50_000.0;
                last = follow.to([20.0 + radius * angle.sin(), 7.0, 10.0 + radius * angle.cos()]);
                assert!(last.off < 1e-9);
            }
            assert!((last.along - 5.0 * PI * radius).abs() < 1e-6, "{last:?}");
        }
    }

    #[test]
    fn a_helix_rises() {
        let curve = Curve::Arc {
            axes: [0, 1, 2],
            center: [0.0; 2],
            radii: [10.0; 2],
            sweep: FRAC_PI_2,
            from: [10.0, 0.0, 0.0],
            rise: 10.0 * FRAC_PI_2,
        };
        let mut follow = Follow::new(curve, [10.0, 0.0, 0.0]);
        let end = follow.to([0.0, 10.0, 5.0 * PI]);
        assert!(end.off < 1e-12 && (end.along - 5.0 * PI * 2f64.sqrt()).abs() < 1e-9, "{end:?}");
        // 1 BLU too high is 1/√2 from a helix of 45°
        let above = follow.to([0.0, 10.0, 5.0 * PI + 1.0]);
        assert!((above.off - 0.5f64.sqrt()).abs() < 1e-12);
    }
}
