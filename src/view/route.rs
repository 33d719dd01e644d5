//! The path that coordinates draw, with the time at which each point is reached, and the ideal curve beneath it.

use serde::Serialize;

use crate::interpolate::Ideal;
use crate::plot::Recording;

/// A path that stays so near to a curve, in BLU, is taken to follow it.
const NEAR: f64 = 1.5;

/// Points of the ideal curve.
const POINTS: u32 = 256;

/// A point and when it is reached.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Reached {
    /// The tick.
    pub time: u64,
    /// Along x, y and z, in BLU.
    pub at: [i64; 3],
}

/// A path over its ideal curve.
#[derive(Clone, Debug, Serialize)]
pub struct Route {
    /// 2 or 3.
    pub axes: usize,
    /// What a point is the end of: a `clock`, or a `step` where no clock tells them apart.
    pub unit: &'static str,
    /// The tick of each point: when the coordinates came to it, which in idle clocks is long before.
    pub times: Vec<u64>,
    /// The leading edge of each clock, where a clock tells the points apart.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<u64>,
    /// The points, along one axis after the other.
    pub points: [Vec<i64>; 3],
    /// Points of the ideal curve; none if it is not known.
    pub ideal: Vec<[f64; 3]>,
    /// How far each point is off, in thousandths of a BLU; nothing if the curve is not known.
    pub off: Vec<i64>,
}

impl Route {
    /// The path through points, the first of which is there from the start; none if it never moves.
    #[must_use]
    pub fn new(axes: usize, unit: &'static str, points: &[Reached], ideal: Option<Ideal>) -> Option<Route> {
        let first = points.first()?;
        if points.iter().all(|p| p.at == first.at) {
            return None;
        }
        let along = |axis: usize| points.iter().map(|p| p.at[axis]).collect();
        let off = |ideal: &Ideal| points.iter().map(|p| (1000.0 * away(ideal, p.at)).round() as i64).collect();
        let curve = |ideal: &Ideal| {
            let curve = ideal.points(POINTS);
            if curve.is_empty() {
                points.iter().map(|p| ideal.nearest(p.at.map(|v| v as f64))).collect()
            } else {
                curve
            }
        };
        // to a hundredth: what is drawn shows no more
        let rounded =
            |curve: Vec<[f64; 3]>| curve.into_iter().map(|p| p.map(|v| (100.0 * v).round() / 100.0)).collect();
        Some(Route {
            axes,
            unit,
            times: points.iter().map(|p| p.time).collect(),
            clocks: Vec::new(),
            points: [along(0), along(1), along(2)],
            off: ideal.as_ref().map(off).unwrap_or_default(),
            ideal: ideal.as_ref().map(curve).map(rounded).unwrap_or_default(),
        })
    }

    /// The greatest distance from the ideal curve, in BLU.
    #[must_use]
    pub fn worst(&self) -> Option<f64> {
        self.off.iter().map(|off| off.abs()).max().map(|off| off as f64 / 1000.0)
    }
}

fn away(ideal: &Ideal, at: [i64; 3]) -> f64 {
    ideal.deviation(at.map(|v| v as f64))
}

/// The curve that a path follows all the way, if it is a line from its first point to its last, or in the plane an arc
/// around the origin: that which it follows more closely.
#[must_use]
pub fn followed(axes: usize, points: &[Reached]) -> Option<Ideal> {
    let (first, last) = (points.first()?.at, points.last()?.at);
    let worst = |ideal: &Ideal| {
        let mut recording = Recording::new(axes, first, away(ideal, first));
        points[1..].iter().for_each(|p| recording.push(p.at, away(ideal, p.at)));
        recording.worst().0.abs()
    };
    let line = (first != last).then(|| Ideal::segment(first, last));
    let plane = |p: [i64; 3]| [p[0] as f64, p[1] as f64];
    // the side to which the path leaves its first point
    let turn = |p: &[i64; 3]| (first[0] * (p[1] - first[1]) - first[1] * (p[0] - first[0])).signum();
    let turn = points.iter().map(|p| turn(&p.at)).find(|&turn| turn != 0 && axes == 2);
    let arc = turn.map(|turn| Ideal::arc([0.0; 2], plane(first), plane(last), turn < 0));
    // a short arc is near its chord too
    let curves = [line, arc].into_iter().flatten().map(|curve| (worst(&curve), curve));
    curves.filter(|c| c.0 <= NEAR).min_by(|a, b| a.0.total_cmp(&b.0)).map(|c| c.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[[i64; 2]]) -> Vec<Reached> {
        points.iter().enumerate().map(|(i, p)| Reached { time: i as u64, at: [p[0], p[1], 0] }).collect()
    }

    #[test]
    fn curves_are_found_by_the_points() {
        let line = path(&[[0, 0], [1, 0], [1, 1], [2, 1], [3, 1], [3, 2]]);
        assert_eq!(followed(2, &line), Some(Ideal::segment([0; 3], [3, 2, 0])));
        // a quarter of radius 5, counter-clockwise and back
        let mut arc = [[5, 0], [5, 1], [5, 2], [4, 2], [4, 3], [3, 3], [3, 4], [2, 4], [2, 5], [1, 5], [0, 5]];
        let sweep = |points: &[[i64; 2]]| match followed(2, &path(points)) {
            Some(Ideal::Arc { sweep, radius, .. }) => (radius, (sweep.to_degrees() * 1e6).round() / 1e6),
            other => panic!("{other:?}"),
        };
        assert_eq!(sweep(&arc), (5.0, 90.0));
        arc.reverse();
        assert_eq!(sweep(&arc), (5.0, -90.0));
        assert_eq!(followed(2, &path(&[[0, 0], [5, 0], [5, 5], [9, 5]])), None);
    }

    #[test]
    fn what_does_not_move_is_no_path() {
        assert!(Route::new(2, "clock", &path(&[[1, 1], [1, 1]]), None).is_none());
        let points = path(&[[0, 0], [1, 0], [1, 1]]);
        // 1/sqrt(2) BLU to the right of the diagonal
        let route = Route::new(2, "clock", &points, followed(2, &points)).unwrap();
        assert_eq!((route.worst(), route.off.as_slice()), (Some(0.707), [0, -707, 0].as_slice()));
    }
}
