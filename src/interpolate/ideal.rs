//! The curve that an interpolator is to follow, and how far from it a point is.

/// An ideal curve, in BLU.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Ideal {
    /// A straight line, in the plane if no point has a z.
    Segment {
        /// The start point.
        from: [f64; 3],
        /// The end point.
        to: [f64; 3],
    },
    /// An arc of a circle.
    Arc {
        /// Its centre.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
        /// The angle of its start point, radians, counter-clockwise from the x axis.
        from: f64,
        /// The angle that it goes through, radians, positive counter-clockwise.
        sweep: f64,
    },
    /// `A·x² + B·xy + C·y² + D·x + E·y + F = 0`.
    Conic {
        /// `A` to `F`.
        coefficients: [f64; 6],
    },
}

impl Ideal {
    /// The segment between two points.
    #[must_use]
    pub fn segment(from: [i64; 3], to: [i64; 3]) -> Ideal {
        Ideal::Segment { from: from.map(|v| v as f64), to: to.map(|v| v as f64) }
    }

    /// The arc around `center` through `from` to the direction of `to`; a full circle if the two are one.
    #[must_use]
    pub fn arc(center: [f64; 2], from: [f64; 2], to: [f64; 2], clockwise: bool) -> Ideal {
        let turn = 2.0 * std::f64::consts::PI;
        let angle = |p: [f64; 2]| libm::atan2(p[1] - center[1], p[0] - center[0]);
        let start = angle(from);
        let mut sweep = angle(to) - start;
        if clockwise {
            if sweep >= 0.0 {
                sweep -= turn;
            }
        } else if sweep <= 0.0 {
            sweep += turn;
        }
        let radius = length([from[0] - center[0], from[1] - center[1], 0.0]);
        Ideal::Arc { center, radius, from: start, sweep }
    }

    /// How far a point is from the curve in BLU: in the plane positive to the left of a line, outside a circle, where a
    /// conic's polynomial is positive; in space never negative. A line is endless here, and an arc a full circle.
    #[must_use]
    pub fn deviation(&self, point: [f64; 3]) -> f64 {
        match *self {
            Ideal::Segment { from, to } => {
                let d = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
                let p = [point[0] - from[0], point[1] - from[1], point[2] - from[2]];
                let n = length(d);
                if n == 0.0 {
                    return length(p);
                }
                let cross = [d[1] * p[2] - d[2] * p[1], d[2] * p[0] - d[0] * p[2], d[0] * p[1] - d[1] * p[0]];
                let flat = d[2] == 0.0 && p[2] == 0.0;
                if flat { cross[2] / n } else { length(cross) / n }
            }
            Ideal::Arc { center, radius, .. } => length([point[0] - center[0], point[1] - center[1], 0.0]) - radius,
            Ideal::Conic { coefficients } => conic_distance(coefficients, [point[0], point[1]]),
        }
    }

    /// A point of the curve next to the given one: of a line or circle the nearest, of a conic one that is found along
    /// its gradient, and where the gradient vanishes the given one itself. The centre of an arc stays where it is.
    #[must_use]
    pub fn nearest(&self, point: [f64; 3]) -> [f64; 3] {
        match *self {
            Ideal::Segment { from, to } => {
                let d = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
                let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if square == 0.0 {
                    return from;
                }
                let along: f64 = (0..3).map(|i| (point[i] - from[i]) * d[i]).sum::<f64>() / square;
                [0, 1, 2].map(|i| from[i] + along * d[i])
            }
            Ideal::Arc { center, radius, .. } => {
                let d = [point[0] - center[0], point[1] - center[1]];
                let away = length([d[0], d[1], 0.0]);
                let part = if away == 0.0 { 0.0 } else { radius / away };
                [center[0] + d[0] * part, center[1] + d[1] * part, 0.0]
            }
            Ideal::Conic { coefficients } => {
                let [x, y] = onto_conic(coefficients, [point[0], point[1]]);
                [x, y, 0.0]
            }
        }
    }

    /// Points along the curve, `n + 1` of them from its start to its end; of a conic, which has neither, none.
    #[must_use]
    pub fn points(&self, n: u32) -> Vec<[f64; 3]> {
        let part = |i: u32| f64::from(i) / f64::from(n.max(1));
        match *self {
            Ideal::Segment { from, to } => {
                (0..=n).map(|i| [0, 1, 2].map(|a| from[a] + (to[a] - from[a]) * part(i))).collect()
            }
            Ideal::Arc { center, radius, from, sweep } => (0..=n)
                .map(|i| {
                    let angle = from + sweep * part(i);
                    [center[0] + radius * libm::cos(angle), center[1] + radius * libm::sin(angle), 0.0]
                })
                .collect(),
            Ideal::Conic { .. } => Vec::new(),
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// The polynomial of a conic.
fn polynomial([a, b, c, d, e, f]: [f64; 6], [x, y]: [f64; 2]) -> f64 {
    a * x * x + b * x * y + c * y * y + d * x + e * y + f
}

/// A point of a conic, sought by Newton's method from the given one.
fn onto_conic(conic: [f64; 6], point: [f64; 2]) -> [f64; 2] {
    let [a, b, c, d, e, _] = conic;
    let gradient = |[x, y]: [f64; 2]| [2.0 * a * x + b * y + d, b * x + 2.0 * c * y + e];
    let mut p = point;
    for _ in 0..16 {
        let (v, g) = (polynomial(conic, p), gradient(p));
        let square = g[0] * g[0] + g[1] * g[1];
        if square == 0.0 {
            break;
        }
        p = [p[0] - v * g[0] / square, p[1] - v * g[1] / square];
    }
    p
}

/// The distance to a conic along its gradient.
fn conic_distance(conic: [f64; 6], point: [f64; 2]) -> f64 {
    let p = onto_conic(conic, point);
    let distance = length([point[0] - p[0], point[1] - p[1], 0.0]);
    if polynomial(conic, point) < 0.0 { -distance } else { distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_by_hand() {
        // the line (4, 3): (0, 5) is 4 to its left, (5, 0) is 3 to its right
        let line = Ideal::segment([0, 0, 0], [4, 3, 0]);
        assert_eq!([[0.0, 5.0, 0.0], [5.0, 0.0, 0.0], [8.0, 6.0, 0.0]].map(|p| line.deviation(p)), [4.0, -3.0, 0.0]);
        let space = Ideal::segment([1, 1, 1], [1, 1, 9]);
        assert_eq!(space.deviation([4.0, 5.0, 2.0]), 5.0);
        assert_eq!(Ideal::segment([1, 1, 0], [1, 1, 0]).deviation([4.0, 5.0, 0.0]), 5.0);
        let circle = Ideal::arc([1.0, 0.0], [6.0, 0.0], [1.0, 5.0], false);
        assert_eq!([[5.0, 3.0, 0.0], [1.0, -7.0, 0.0]].map(|p| circle.deviation(p)), [0.0, 2.0]);
        // the same circle as a conic: (x - 1)² + y² = 25
        let conic = Ideal::Conic { coefficients: [1.0, 0.0, 1.0, -2.0, 0.0, -24.0] };
        assert!((conic.deviation([1.0, -7.0, 0.0]) - 2.0).abs() < 1e-9);
        assert!((conic.deviation([4.0, 0.0, 0.0]) + 2.0).abs() < 1e-9);
    }

    #[test]
    fn nearest_points_by_hand() {
        // (1, 7) − (4, 3)·25/25 = (−3, 4), which is upright on (4, 3)
        assert_eq!(Ideal::segment([0, 0, 0], [4, 3, 0]).nearest([1.0, 7.0, 0.0]), [4.0, 3.0, 0.0]);
        assert_eq!(Ideal::segment([1, 2, 3], [1, 2, 3]).nearest([4.0, 6.0, 3.0]), [1.0, 2.0, 3.0]);
        let circle = Ideal::arc([1.0, 0.0], [6.0, 0.0], [1.0, 5.0], false);
        assert_eq!(circle.nearest([7.0, 8.0, 0.0]), [4.0, 4.0, 0.0]);
        assert_eq!(circle.nearest([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        let conic = Ideal::Conic { coefficients: [1.0, 0.0, 1.0, -2.0, 0.0, -24.0] };
        let [x, y, _] = conic.nearest([7.0, 8.0, 0.0]);
        assert!((x - 4.0).abs() < 1e-9 && (y - 4.0).abs() < 1e-9, "({x}, {y})");
    }

    #[test]
    fn an_arc_turns_the_way_it_is_told() {
        let sweep = |to, clockwise| match Ideal::arc([0.0; 2], [5.0, 0.0], to, clockwise) {
            Ideal::Arc { sweep, .. } => (sweep / std::f64::consts::FRAC_PI_2 * 1e9).round() / 1e9,
            _ => unreachable!(),
        };
        assert_eq!([sweep([0.0, 5.0], false), sweep([0.0, 5.0], true)], [1.0, -3.0]);
        assert_eq!([sweep([5.0, 0.0], false), sweep([5.0, 0.0], true)], [4.0, -4.0]);
    }
}
