//! Lines and arcs in all quadrants, against the steps that a table gives for each.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::{EfCircle, EfLine, Ideal, LineInput, Method, Request, Shape};

fn path(from: [i64; 2], to: [i64; 2], clockwise: bool) -> ArcPath {
    ArcPath { center: [0, 0], from, to, full: true, long: None, clockwise, f0: 0, bits: 8 }
}

fn arc(path: ArcPath) -> Quadrants {
    Quadrants::new(path, true, |input| Ok(Box::new(EfCircle::new(input)?))).unwrap_or_else(|e| panic!("{path:?}: {e}"))
}

fn letters(arc: impl Iterator<Item = Clock>) -> String {
    arc.map(|clock| clock.letter()).collect()
}

fn off(square: i64, [x, y, _]: [i64; 3]) -> f64 {
    ((x * x + y * y) as f64).sqrt() - (square as f64).sqrt()
}

/// Points but the centre with both coordinates up to `most`.
fn points(most: i64) -> impl Iterator<Item = [i64; 2]> {
    (-most..=most).flat_map(move |x| (-most..=most).map(move |y| [x, y])).filter(|&p| p != [0, 0])
}

/// The step at a point: for each direction and quadrant the one for `F ≥ 0` and the one for `F < 0`.
fn by_table([x, y]: [i64; 2], f: i64, clockwise: bool) -> [i64; 2] {
    let [right, up, left, down] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
    // a point on an axis belongs to the quadrant that lies ahead
    let quadrant = match clockwise {
        false => [x > 0 && y >= 0, x <= 0 && y > 0, x < 0 && y <= 0, x >= 0 && y < 0],
        true => [x >= 0 && y > 0, x < 0 && y >= 0, x <= 0 && y < 0, x > 0 && y <= 0],
    };
    let steps = match clockwise {
        false => [[left, up], [down, left], [right, down], [up, right]],
        true => [[down, right], [right, up], [up, left], [left, down]],
    };
    steps[quadrant.iter().position(|&q| q).unwrap()][usize::from(f < 0)]
}

#[test]
fn every_full_circle_closes_with_the_steps_of_the_table() {
    let (mut circles, mut worst) = (0, 0.0_f64);
    for from in points(40) {
        let square = from[0] * from[0] + from[1] * from[1];
        circles += usize::from(square > 1);
        for clockwise in [false, true] {
            let (mut at, mut crossings, mut last) = (from, 0, None);
            for c in arc(path(from, from, clockwise)) {
                let step = [0, 1].map(|axis| i64::from(c.step[axis]));
                if step == [0, 0] {
                    crossings += 1;
                } else if square > 1 {
                    let f = at[0] * at[0] + at[1] * at[1] - square;
                    assert_eq!(step, by_table(at, f, clockwise), "{from:?}, clockwise {clockwise}, at {at:?}");
                    worst = worst.max(off(square, c.at).abs());
                }
                at = [at[0] + step[0], at[1] + step[1]];
                assert_eq!(c.at, [at[0], at[1], 0]);
                assert_eq!(c.sum[0], at[0] * at[0] + at[1] * at[1] - square);
                last = Some(c);
            }
            assert_eq!((at, last.unwrap().end), (from, true), "clockwise {clockwise}");
            // from an axis one less: the turn begins on one
            assert_eq!(crossings, if from.contains(&0) { 3 } else { 4 }, "{from:?}");
        }
    }
    assert_eq!(circles, 6560 - 4); // all of 81 · 81 points but the centre and the four of radius 1
    // from a point of an axis the first step is one BLU inwards
    assert_eq!(worst, 1.0);
    println!("{circles} circles in both directions, at most {worst:.4} BLU off");
}

#[test]
fn the_circle_of_radius_1_goes_through_its_centre_and_closes() {
    let circle = |from, clockwise| arc(path(from, from, clockwise));
    assert_eq!(letters(circle([1, 0], false)), "XY-YX-XY-YX");
    assert_eq!(letters(circle([0, -1], true)), "YX-XY-YX-XY");
    for from in [[1, 0], [0, 1], [-1, 0], [0, -1]] {
        for clockwise in [false, true] {
            let points: Vec<_> = circle(from, clockwise).filter(|c| c.axes() > 0).map(|c| c.at).collect();
            assert_eq!(points.len(), 8);
            // by turns the centre and a point of the circle, one of each axis, in the order of the direction
            assert!(points.iter().step_by(2).all(|&p| p == [0; 3]));
            let mut at = from;
            for to in points.iter().skip(1).step_by(2) {
                at = if clockwise { [at[1], -at[0]] } else { [-at[1], at[0]] };
                assert_eq!(*to, [at[0], at[1], 0]);
            }
            assert_eq!(at, from);
        }
    }
}

/// From every start point to every end point less than 2 BLU off the circle.
#[test]
fn every_arc_ends_where_it_is_to_and_turns_as_far() {
    let (mut arcs, mut refused, mut worst) = (0, 0, [0.0_f64; 2]);
    for from in points(9) {
        let square = from[0] * from[0] + from[1] * from[1];
        for to in points(15).filter(|to| off(square, [to[0], to[1], 0]).abs() < 2.0) {
            let rounded = usize::from(to[0] * to[0] + to[1] * to[1] != square);
            for clockwise in [false, true] {
                let path = path(from, to, clockwise);
                let ideal = Ideal::arc([0.0; 2], from.map(|v| v as f64), to.map(|v| v as f64), clockwise);
                let Ideal::Arc { sweep, .. } = ideal else { unreachable!() };
                if path.cut() == Err(InputError::TooShort) {
                    // within a quadrant, and both coordinates rise or both fall
                    let [dx, dy] = [0, 1].map(|axis| to[axis].abs() - from[axis].abs());
                    assert!(dx * dy > 0 || dx * dy == 0 && rounded == 1, "{path:?}");
                    assert!(sweep.abs() < PI / 2.0 || (sweep.abs() - TAU).abs() < 1e-6, "{path:?}");
                    refused += 1;
                    continue;
                }
                let (mut turned, mut at, mut end) = (0.0, from, false);
                for c in arc(path) {
                    let next = [c.at[0], c.at[1]];
                    if at != [0, 0] && next != [0, 0] {
                        let [a, b] = [at, next].map(|p| (p[1] as f64).atan2(p[0] as f64));
                        turned += (b - a + 3.0 * PI).rem_euclid(TAU) - PI;
                    }
                    assert!(c.axes() <= 1);
                    worst[rounded] = worst[rounded].max(off(square, c.at).abs());
                    (at, end) = (next, c.end);
                }
                assert_eq!((at, end), (to, true), "{path:?}");
                if square > 1 {
                    assert!((turned - sweep).abs() < 1e-6, "{path:?} turns by {turned}, not {sweep}");
                }
                arcs += 1;
            }
        }
    }
    // to points of the circle, and to points up to 2 BLU off it
    assert_eq!(worst[0], 1.0);
    assert!(worst[1] < 2.0, "{worst:?}");
    println!("{arcs} arcs, at most {worst:.4?} BLU off; {refused} refused");
}

#[test]
fn an_arc_in_the_first_quadrant_is_what_the_method_makes_of_it() {
    for clockwise in [false, true] {
        for (from, to) in [([5, 0], [0, 5]), ([4, 3], [3, 4]), ([12, 5], [6, 11])] {
            let (from, to) = if clockwise { (to, from) } else { (from, to) };
            let input = ArcInput::between((from[0], from[1]), (to[0], to[1]), clockwise, 8);
            let core = EfCircle::new(input).unwrap();
            let whole = arc(path(from, to, clockwise));
            assert_eq!((whole.state(), whole.columns()), (core.state(), core.columns()));
            assert!(whole.eq(core));
        }
    }
}

#[test]
fn counters_and_sums_of_a_half_circle() {
    // the first quarter as B's golden one, but that KOY is not counted down from 5 but from 255
    let half = arc(path([5, 0], [-5, 0], false));
    let first = half.state();
    assert_eq!((first.left, first.sum, first.end), ([5, 255, 0], [0; 3], false));
    let clocks: Vec<_> = half.collect();
    assert_eq!(letters(clocks.iter().copied()), "XYYYXYXYXX-YXXXYXYXYY");
    assert_eq!(clocks[9], Clock { step: [-1, 0, 0], at: [0, 5, 0], left: [0, 250, 0], sum: [0; 3], end: false });
    assert_eq!(clocks[10], Clock { step: [0; 3], at: [0, 5, 0], left: [5, 5, 0], sum: [0; 3], end: false });
    assert_eq!(clocks[11], Clock { step: [0, -1, 0], at: [0, 4, 0], left: [5, 4, 0], sum: [-9, 0, 0], end: false });
    assert!(clocks[20].end);
}

#[test]
fn around_any_centre() {
    let at = |center: [i64; 2]| {
        let moved = |p: [i64; 2]| [p[0] + center[0], p[1] + center[1]];
        let path = ArcPath { center, from: moved([3, -4]), to: moved([-4, -3]), ..path([0; 2], [0; 2], true) };
        let clocks: Vec<_> = arc(path).map(|c| (c.step, [c.at[0] - center[0], c.at[1] - center[1]], c.left)).collect();
        clocks
    };
    assert_eq!(at([0, 0]), at([200, -251]));
    assert_eq!(at([0, 0]).last().unwrap().1, [-4, -3]);
}

#[test]
fn an_arc_of_nothing_is_not_a_full_circle() {
    for from in [[5, 0], [0, -5], [-3, 4]] {
        let mut nothing = arc(ArcPath { full: false, ..path(from, from, false) });
        assert_eq!((nothing.state().end, nothing.next()), (true, None));
    }
}

#[test]
fn arcs_are_refused_with_their_limit() {
    let refused = |path: ArcPath| path.cut().unwrap_err().to_string();
    let ok = path([5, 0], [0, 5], false);
    assert_eq!(refused(ArcPath { from: [0, 0], ..ok }), "the start point is the centre: the radius is 0");
    assert_eq!(
        refused(ArcPath { to: [0, 7], ..ok }),
        "the end point (0, 7) is off the circle: it is 7.00 from the centre, the start point 5.00, and they may differ \
         by less than 2"
    );
    assert!(ArcPath { to: [0, 3], ..ok }.cut().is_err());
    assert!(ArcPath { to: [0, 6], ..ok }.cut().is_ok() && ArcPath { to: [0, 4], ..ok }.cut().is_ok());
    // √45 = 6.71 is less than 2 off 5, √52 = 7.21 is not
    assert!(ArcPath { to: [3, 6], ..ok }.cut().is_ok() && ArcPath { to: [4, 6], ..ok }.cut().is_err());
    assert_eq!(
        refused(ArcPath { from: [256, 0], ..ok }),
        "XH = 256 is outside -256..255, what 9 bits hold in two's complement"
    );
    assert_eq!(
        refused(ArcPath { center: [-251, 0], ..ok }),
        "a point is 256 from the centre, above 255, the greatest of 8 bits"
    );
    // (200, 200) fits, and so does the arc to its mirror image; but not the whole circle, which meets the axis at 282.84
    assert!(path([200, 190], [190, 200], false).cut().is_ok());
    assert_eq!(refused(path([200, 200], [200, 200], false)), "the radius 282.84 is above 255, the greatest of 8 bits");
    assert_eq!(path([255, 0], [255, 0], false).cut().map(|c| c.crossings), Ok(3));
    assert_eq!(refused(ArcPath { bits: 33, ..ok }), "registers of 33 bits: they may have 1 to 32");
    assert_eq!(refused(ArcPath { center: [i64::MIN, 0], ..ok }), "the end point is too far from the start point");
    // √18 = 4.24 and √8 = 2.83: on one ray from the centre, so neither comes before the other
    assert_eq!(path([3, 3], [2, 2], false).cut(), Err(InputError::TooShort));
}

/// The circle of radius 255 fits 8 bits, and that of 2³² − 1 fits 32.
#[test]
fn the_widest_circles() {
    for clockwise in [false, true] {
        let circle: Vec<_> = arc(path([0, 255], [0, 255], clockwise)).collect();
        assert_eq!(circle.len(), 8 * 255 + 3);
        assert_eq!(circle.last().unwrap().at, [0, 255, 0]);
    }
    let most = (1 << 30) - 1;
    let mut wide = arc(ArcPath { bits: 30, ..path([most, 0], [most, 0], true) });
    assert_eq!(wide.by_ref().take(3).map(|c| c.sum[0]).collect::<Vec<_>>(), [1 - 2 * most, 2 - 2 * most, 5 - 2 * most]);
}

/// The signs of a line's increments are taken off and put on again.
#[test]
fn lines_in_all_quadrants_are_mirror_images() {
    for (dx, dy) in (0..9).flat_map(|dx| (0..9).map(move |dy| (dx, dy))) {
        let first: Vec<_> = EfLine::new(LineInput::new(dx, dy)).unwrap().collect();
        for (sx, sy) in [(1, 1), (-1, 1), (-1, -1), (1, -1)] {
            let request = Request { from: [-7, 3, 0], ..Request::new(Method::EfLine, [-7 + sx * dx, 3 + sy * dy, 0]) };
            let drawn: Vec<_> = request.draw().unwrap().interpolator.collect();
            let expected = first.iter().map(|c| Clock {
                step: [c.step[0] * sx as i8, c.step[1] * sy as i8, 0],
                at: [-7 + sx * c.at[0], 3 + sy * c.at[1], 0],
                ..*c
            });
            assert!(drawn.into_iter().eq(expected), "({dx}, {dy}), signs {sx} {sy}");
        }
    }
}

/// Through the front door: every method for arcs closes full circles and ends its arcs, in both directions.
#[test]
fn every_method_for_arcs_goes_through_the_quadrants() {
    for &method in Method::ALL.iter().filter(|m| m.shape() == Shape::Arc) {
        let mut worst = 0.0_f64;
        for from in points(12) {
            let square = from[0] * from[0] + from[1] * from[1];
            for to in [from, [-from[1], from[0]], [from[0], -from[1]], [-from[0], -from[1]]] {
                for clockwise in [false, true] {
                    let space = |[x, y]: [i64; 2]| [x + 20, y - 30, 0];
                    let request =
                        Request { from: space(from), center: [20, -30], clockwise, ..Request::new(method, space(to)) };
                    let mut drawing = request.draw().unwrap_or_else(|e| panic!("{request:?}: {e}"));
                    let mut at = space(from);
                    for c in &mut drawing.interpolator {
                        at = [0, 1, 2].map(|axis| at[axis] + i64::from(c.step[axis]));
                        assert_eq!(c.at, at, "{request:?}");
                        worst = worst.max(off(square, [at[0] - 20, at[1] + 30, 0]).abs());
                    }
                    assert_eq!(at, space(to), "{request:?}");
                    assert!(drawing.interpolator.state().end && drawing.interpolator.stopped().is_none());
                }
            }
        }
        println!("{method}: at most {worst:.4} BLU off");
        assert!(worst < 2.0, "{method}: {worst}");
    }
}
