//! For each shipped circuit the cases of a short proof: inputs, and the algorithm that says what comes of them.

use discreta::circuit::Circuit;
use discreta::interpolate::{
    ArcInput, ArcPath, Clock, Columns, CurveInput, DdaCircle, DdaCirclePrinted, DdaCurve, DdaLine, DdaLine3d,
    DdaLinePrinted, EfCircle, EfCircleFast, EfLine, EfLine3d, EfLineFast, EfLineFastPrinted, InputError, Interpolator,
    Karibsky, Line3dInput, LineInput, Method, Options, Quadrants, Request,
};

use super::bench::Bench;

/// Inputs by name, and the algorithm that is to agree on every clock.
pub type Case = (Vec<(&'static str, u64)>, Box<dyn Interpolator>);

/// A circuit and what shows that it is right.
pub struct Proof {
    /// Its file below `circuits/`.
    pub path: &'static str,
    /// The values of its parameters that the cases are for.
    pub parameters: &'static [(&'static str, i64)],
    /// The cases: few enough for a second, and all that are possible in the width chosen.
    pub cases: fn() -> Vec<Case>,
}

impl Proof {
    /// Draws every case; the first difference, if there is one.
    pub fn run(&self, circuit: &Circuit) -> Result<(), String> {
        let mut cases = (self.cases)();
        let columns = cases[0].1.columns();
        let mut bench = Bench::new(circuit, columns);
        for (inputs, algorithm) in &mut cases {
            let set: Vec<_> = inputs.iter().map(|&(name, value)| (bench.input(name), value)).collect();
            bench.draw(&set, algorithm.as_mut()).map_err(|fault| format!("{inputs:?}, {fault}"))?;
        }
        Ok(())
    }
}

/// Every circuit that has one, and one for each choice of its parameters that adds to it.
pub const PROOFS: &[Proof] = &[
    Proof { path: "evaluation/line.json", parameters: &[("W", 3)], cases: ef_lines },
    Proof { path: "evaluation/line_gates.json", parameters: &[("W", 3)], cases: ef_lines },
    Proof { path: "evaluation/line.json", parameters: CENTRED, cases: centred_ef_lines },
    Proof { path: "evaluation/line_gates.json", parameters: CENTRED, cases: centred_ef_lines },
    Proof { path: "evaluation/fast_line_x.json", parameters: &[("W", 3)], cases: fast_lines_x },
    Proof { path: "evaluation/fast_line.json", parameters: &[("W", 3)], cases: fast_lines },
    Proof { path: "evaluation/fast_line_gates.json", parameters: &[("W", 3)], cases: fast_lines },
    Proof { path: "evaluation/fast_line.json", parameters: CENTRED, cases: centred_fast_lines },
    Proof { path: "evaluation/fast_line_gates.json", parameters: CENTRED, cases: centred_fast_lines },
    Proof { path: "evaluation/fast_circle.json", parameters: &[("W", 3)], cases: fast_circles },
    Proof { path: "evaluation/fast_circle_gates.json", parameters: &[("W", 3)], cases: fast_circles },
    Proof { path: "evaluation/fast_circle.json", parameters: CLOCKWISE, cases: clockwise_fast_circles },
    Proof { path: "evaluation/fast_circle_gates.json", parameters: CLOCKWISE, cases: clockwise_fast_circles },
    Proof { path: "evaluation/circle.json", parameters: COUNTER_CLOCKWISE, cases: ef_circles },
    Proof { path: "evaluation/circle.json", parameters: CLOCKWISE, cases: clockwise_ef_circles },
    Proof { path: "evaluation/circle_gates.json", parameters: COUNTER_CLOCKWISE, cases: ef_circles },
    Proof { path: "evaluation/circle_gates.json", parameters: CLOCKWISE, cases: clockwise_ef_circles },
    Proof { path: "evaluation/karibsky.json", parameters: COUNTER_CLOCKWISE, cases: karibsky },
    Proof { path: "evaluation/karibsky.json", parameters: CLOCKWISE, cases: clockwise_karibsky },
    Proof { path: "evaluation/karibsky_gates.json", parameters: COUNTER_CLOCKWISE, cases: karibsky },
    Proof { path: "evaluation/karibsky_gates.json", parameters: CLOCKWISE, cases: clockwise_karibsky },
    Proof { path: "quadrant/line.json", parameters: &[("W", 3)], cases: signed_ef_lines },
    Proof { path: "quadrant/fast_line.json", parameters: &[("W", 3)], cases: signed_fast_lines },
    Proof { path: "quadrant/dda_line.json", parameters: &[("W", 3)], cases: signed_dda_lines },
    Proof { path: "quadrant/line_3d.json", parameters: &[("W", 2)], cases: signed_lines_3d },
    Proof { path: "quadrant/circle.json", parameters: &[("W", 3)], cases: ef_quadrants },
    Proof { path: "quadrant/fast_circle.json", parameters: &[("W", 3)], cases: fast_quadrants },
    Proof { path: "quadrant/karibsky.json", parameters: &[("W", 3)], cases: karibsky_quadrants },
    Proof { path: "dda/curve.json", parameters: &[("W", 5)], cases: curves },
    Proof { path: "dda/curve_gates.json", parameters: &[("W", 5)], cases: curves },
    Proof { path: "three_axis/line.json", parameters: &[("W", 2)], cases: ef_lines_3d },
    Proof { path: "three_axis/line_gates.json", parameters: &[("W", 2)], cases: ef_lines_3d },
    Proof { path: "three_axis/dda_line.json", parameters: &[("W", 2)], cases: || dda_lines_3d(false) },
    Proof { path: "three_axis/dda_line.json", parameters: HALF_3D, cases: || dda_lines_3d(true) },
    Proof { path: "three_axis/dda_line_gates.json", parameters: &[("W", 2)], cases: || dda_lines_3d(false) },
    Proof { path: "three_axis/dda_line_gates.json", parameters: HALF_3D, cases: || dda_lines_3d(true) },
    Proof { path: "dda/line.json", parameters: &[("W", 3)], cases: || dda_lines(PLAIN) },
    Proof {
        path: "dda/line.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("NORMALISE", 1)],
        cases: || dda_lines(HALF_NORMALISED),
    },
    Proof { path: "dda/circle.json", parameters: COUNTER_CLOCKWISE, cases: || dda_circles(false, PLAIN) },
    Proof { path: "dda/circle.json", parameters: CLOCKWISE, cases: || dda_circles(true, PLAIN) },
    Proof {
        path: "dda/circle.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("PARALLEL", 1)],
        cases: || dda_circles(false, Options { half_preload: true, parallel: true, ..PLAIN }),
    },
    Proof {
        path: "dda/circle.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("NORMALISE", 1)],
        cases: || dda_circles(false, HALF_NORMALISED),
    },
    Proof {
        path: "dda/circle.json",
        parameters: &[("W", 3), ("CLOCKWISE", 1), ("NORMALISE", 1)],
        cases: || dda_circles(true, Options { normalise: true, ..PLAIN }),
    },
    Proof { path: "dda/line_as_printed.json", parameters: &[("W", 3)], cases: dda_lines_as_printed },
    Proof { path: "dda/circle_as_printed.json", parameters: &[("W", 3)], cases: || dda_circles_as_printed(PLAIN) },
    Proof {
        path: "dda/circle_as_printed.json",
        parameters: &[("W", 3), ("PARALLEL", 1)],
        cases: || dda_circles_as_printed(Options { parallel: true, ..PLAIN }),
    },
    Proof { path: "dda/line_gates.json", parameters: &[("W", 3)], cases: || dda_lines(PLAIN) },
    Proof {
        path: "dda/line_gates.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("NORMALISE", 1)],
        cases: || dda_lines(HALF_NORMALISED),
    },
    Proof { path: "dda/circle_gates.json", parameters: COUNTER_CLOCKWISE, cases: || dda_circles(false, PLAIN) },
    Proof { path: "dda/circle_gates.json", parameters: CLOCKWISE, cases: || dda_circles(true, PLAIN) },
    Proof {
        path: "dda/circle_gates.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("PARALLEL", 1)],
        cases: || dda_circles(false, Options { half_preload: true, parallel: true, ..PLAIN }),
    },
    Proof {
        path: "dda/circle_gates.json",
        parameters: &[("W", 3), ("HALF_PRELOAD", 1), ("NORMALISE", 1)],
        cases: || dda_circles(false, HALF_NORMALISED),
    },
    Proof {
        path: "dda/circle_gates.json",
        parameters: &[("W", 3), ("CLOCKWISE", 1), ("NORMALISE", 1)],
        cases: || dda_circles(true, Options { normalise: true, ..PLAIN }),
    },
];

const COUNTER_CLOCKWISE: &[(&str, i64)] = &[("W", 3), ("CLOCKWISE", 0)];
const CENTRED: &[(&str, i64)] = &[("W", 3), ("CENTRED", 1)];
const CLOCKWISE: &[(&str, i64)] = &[("W", 3), ("CLOCKWISE", 1)];

/// Every line of 3 bits, from start points that change.
fn lines(algorithm: impl Fn(LineInput) -> Box<dyn Interpolator>) -> Vec<Case> {
    let pairs = (0..8).flat_map(|dx| (0..8).map(move |dy| (dx, dy)));
    pairs
        .map(|(dx, dy)| {
            let (xh, yh) = ((dx * 3) & 7, (dy * 5 + 1) & 7);
            let inputs = [("dx", dx), ("dy", dy), ("xh", xh), ("yh", yh)].map(|(name, v)| (name, v as u64)).to_vec();
            (inputs, algorithm(LineInput { xh, yh, dx, dy, bits: 3 }))
        })
        .collect()
}

fn ef_lines() -> Vec<Case> {
    lines(|input| Box::new(EfLine::new(input).unwrap()))
}

fn centred_ef_lines() -> Vec<Case> {
    lines(|input| Box::new(EfLine::centred(input).unwrap()))
}

fn fast_lines() -> Vec<Case> {
    lines(|input| Box::new(EfLineFast::new(input).unwrap()))
}

fn centred_fast_lines() -> Vec<Case> {
    lines(|input| Box::new(EfLineFast::centred(input).unwrap()))
}

/// Without the lines that are not for this circuit, where y leads.
fn fast_lines_x() -> Vec<Case> {
    let mut cases = lines(|input| Box::new(EfLineFastPrinted::diagram(input).unwrap()));
    cases.retain(|(inputs, _)| inputs[0].1 >= inputs[1].1);
    cases
}

/// Every arc of 3 bits between two points of the quadrant, with an `F₀` that changes.
fn arcs(clockwise: bool, algorithm: impl Fn(ArcInput) -> Box<dyn Interpolator>) -> Vec<Case> {
    let points = || (0..8).flat_map(|x| (0..8).map(move |y| (x, y))).skip(1);
    let mut cases = Vec::new();
    for (from, to) in points().flat_map(|from| points().map(move |to| (from, to))) {
        let f0 = [0, -(from.0 + to.1), from.1 + to.0][cases.len() % 3];
        let input = ArcInput { f0, ..ArcInput::between(from, to, clockwise, 3) };
        if input.check().is_ok() {
            let inputs = [("dx", input.dx), ("dy", input.dy), ("xh", input.xh), ("yh", input.yh), ("f0", f0)];
            cases.push((inputs.map(|(name, v)| (name, v as u64)).to_vec(), algorithm(input)));
        }
    }
    cases
}

fn fast_circles() -> Vec<Case> {
    arcs(false, |input| Box::new(EfCircleFast::new(input).unwrap()))
}

fn clockwise_fast_circles() -> Vec<Case> {
    arcs(true, |input| Box::new(EfCircleFast::new(input).unwrap()))
}

fn ef_circles() -> Vec<Case> {
    arcs(false, |input| Box::new(EfCircle::new(input).unwrap()))
}

fn clockwise_ef_circles() -> Vec<Case> {
    arcs(true, |input| Box::new(EfCircle::new(input).unwrap()))
}

fn karibsky() -> Vec<Case> {
    arcs(false, |input| Box::new(Karibsky::new(input).unwrap()))
}

fn clockwise_karibsky() -> Vec<Case> {
    arcs(true, |input| Box::new(Karibsky::new(input).unwrap()))
}

/// Every line of 3 bits and a sign, from start points that change.
fn signed_lines(method: Method) -> Vec<Case> {
    let pairs = (-7..8).flat_map(|dx| (-7..8).map(move |dy| (dx, dy)));
    pairs
        .map(|(dx, dy)| {
            let (xh, yh) = ((dx * 3) & 7, (dy * 5 + 1) % 8);
            let request = Request { from: [xh, yh, 0], bits: Some(3), ..Request::new(method, [xh + dx, yh + dy, 0]) };
            let inputs = [("dx", dx), ("dy", dy), ("xh", xh), ("yh", yh)].map(|(name, v)| (name, v as u64)).to_vec();
            (inputs, request.draw().unwrap().interpolator)
        })
        .collect()
}

fn signed_ef_lines() -> Vec<Case> {
    signed_lines(Method::EfLine)
}

fn signed_fast_lines() -> Vec<Case> {
    signed_lines(Method::EfLineFast)
}

fn signed_dda_lines() -> Vec<Case> {
    signed_lines(Method::DdaLine)
}

/// Every line in space of 2 bits and a sign, from start points that change.
fn signed_lines_3d() -> Vec<Case> {
    let along = || -3..4_i64;
    let all = along().flat_map(|dx| along().flat_map(move |dy| along().map(move |dz| [dx, dy, dz])));
    all.map(|d| {
        let from = [3 * d[1] + d[2], 5 * d[2] + d[0], 3 * d[0] + d[1]].map(|v| v.rem_euclid(8) - 4);
        let to = [0, 1, 2].map(|axis| from[axis] + d[axis]);
        let request = Request { from, bits: Some(2), ..Request::new(Method::EfLine3d, to) };
        let names = [("dx", d[0]), ("dy", d[1]), ("dz", d[2]), ("xh", from[0]), ("yh", from[1]), ("zh", from[2])];
        (names.map(|(name, v)| (name, v as u64)).to_vec(), request.draw().unwrap().interpolator)
    })
    .collect()
}

/// Full circles and arcs of 3 bits and a sign, in both directions, with centres and an `F₀` that change.
fn quadrants(core: fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError>) -> Vec<Case> {
    let points = |most: i64| (-most..=most).flat_map(move |x| (-most..=most).map(move |y| [x, y]));
    let mut cases = Vec::new();
    // and the greatest circle of the width
    let pairs = points(4).flat_map(|from| points(5).map(move |to| (from, to))).chain([([7, 0], [7, 0])]);
    for (n, (from, to)) in pairs.enumerate() {
        if from != to && n % 7 != 0 {
            continue;
        }
        let clockwise = n % 2 == 1;
        let center = if from[0] == 7 { [0; 2] } else { [(n as i64 / 2) % 5 - 2, (n as i64 / 10) % 5 - 2] };
        let f0 = if from == to { 0 } else { (n as i64 / 3) % 5 - 2 };
        let [from, to] = [from, to].map(|p| [p[0] + center[0], p[1] + center[1]]);
        let path = ArcPath { center, from, to, full: true, long: None, clockwise, f0, bits: 3 };
        if let Ok(arc) = Quadrants::new(path, true, core) {
            let points = [("xh", from[0]), ("yh", from[1]), ("xk", to[0]), ("yk", to[1])];
            let rest = [("xc", center[0]), ("yc", center[1]), ("cw", i64::from(clockwise)), ("f0", f0)];
            let inputs = points.into_iter().chain(rest).map(|(name, v)| (name, v as u64)).collect();
            cases.push((inputs, Box::new(arc) as _));
        }
    }
    cases
}

fn ef_quadrants() -> Vec<Case> {
    quadrants(|input| Ok(Box::new(EfCircle::new(input)?)))
}

fn fast_quadrants() -> Vec<Case> {
    quadrants(|input| Ok(Box::new(EfCircleFast::new(input)?)))
}

fn karibsky_quadrants() -> Vec<Case> {
    quadrants(|input| Ok(Box::new(Karibsky::new(input)?)))
}

/// Every line in space of 2 bits, from start points that change.
fn lines_3d(algorithm: impl Fn(Line3dInput) -> Box<dyn Interpolator>) -> Vec<Case> {
    (0..64)
        .map(|k| {
            let increment = [k >> 4, (k >> 2) & 3, k & 3];
            let start = [(k + 1) & 3, (k / 3) & 3, (k / 5) & 3];
            let names = ["dx", "dy", "dz", "xh", "yh", "zh"].into_iter();
            let inputs = names.zip(increment.into_iter().chain(start)).map(|(name, v)| (name, v as u64)).collect();
            (inputs, algorithm(Line3dInput { start, increment, bits: 2 }))
        })
        .collect()
}

fn ef_lines_3d() -> Vec<Case> {
    lines_3d(|input| Box::new(EfLine3d::new(input).unwrap()))
}

fn dda_lines_3d(half_preload: bool) -> Vec<Case> {
    lines_3d(move |input| Box::new(DdaLine3d::new(input, half_preload).unwrap()))
}

const HALF_3D: &[(&str, i64)] = &[("W", 2), ("HALF_PRELOAD", 1)];
const PLAIN: Options =
    Options { as_printed: false, half_preload: false, parallel: false, normalise: false, centred: false };
const HALF_NORMALISED: Options = Options { half_preload: true, normalise: true, ..PLAIN };

/// An interpolator by differential increments, whose number of shifts is compared also where it is 0 throughout.
struct WithShifts<I>(I);

impl<I: Interpolator> Iterator for WithShifts<I> {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        self.0.next()
    }
}

impl<I: Interpolator> Interpolator for WithShifts<I> {
    fn state(&self) -> Clock {
        self.0.state()
    }

    fn columns(&self) -> Columns {
        Columns::DDA_NORMALISED
    }
}

fn dda_lines(options: Options) -> Vec<Case> {
    lines(|input| Box::new(WithShifts(DdaLine::new(input, &options).unwrap())))
}

fn dda_lines_as_printed() -> Vec<Case> {
    lines(|input| Box::new(DdaLinePrinted::new(input, &PLAIN).unwrap()))
}

/// Every arc of 3 bits for which there is an algorithm.
fn arcs_of_3_bits(clockwise: bool, algorithm: impl Fn(ArcInput) -> Option<Box<dyn Interpolator>>) -> Vec<Case> {
    let points = || (0..8).flat_map(|x| (0..8).map(move |y| (x, y)));
    let inputs = points().flat_map(|from| points().map(move |to| ArcInput::between(from, to, clockwise, 3)));
    let cases = inputs.filter_map(|input| {
        let inputs = [("dx", input.dx), ("dy", input.dy), ("xh", input.xh), ("yh", input.yh)];
        Some((inputs.map(|(name, v)| (name, v as u64)).to_vec(), algorithm(input)?))
    });
    cases.collect()
}

/// Those that are not refused.
fn dda_circles(clockwise: bool, options: Options) -> Vec<Case> {
    arcs_of_3_bits(clockwise, |input| Some(Box::new(WithShifts(DdaCircle::new(input, &options).ok()?))))
}

/// Those that come to their end by the printed program, some of them far beyond it.
fn dda_circles_as_printed(options: Options) -> Vec<Case> {
    arcs_of_3_bits(false, |input| {
        let printed = DdaCirclePrinted::new(input, &options).ok()?;
        let ends = printed.state().end || printed.clone().take(100).any(|clock| clock.end);
        ends.then(|| Box::new(printed) as Box<dyn Interpolator>)
    })
}

/// Curves of each kind in 5 bits, counter-clockwise.
fn curves() -> Vec<Case> {
    let curves = [
        // a line, a circle, an ellipse, a parabola, hyperbolas, rotated ones, one with all coefficients, short ones
        ([0, 0, 0, 10, -14], [-7, -7], [7, 3]),
        ([0, 0, 0, -13, 0], [9, 12], [9, -15]),
        ([1, 0, 1, 0, 0], [10, 0], [10, 0]),
        ([1, 0, 2, 0, 0], [6, 0], [-6, 0]),
        ([2, 0, 1, 0, 0], [0, -6], [0, -6]),
        ([0, 0, 1, -4, 0], [9, 6], [9, -6]),
        ([0, 1, 0, 0, 0], [12, 1], [1, 12]),
        ([-1, 0, 1, 0, 0], [-5, -4], [-5, 4]),
        ([1, 1, 1, 0, 0], [5, 5], [5, 5]),
        ([-1, 1, -1, 0, 0], [5, -5], [-5, 5]),
        ([1, 1, 2, -3, 2], [4, 2], [4, 2]),
        ([1, 0, 1, 0, 0], [10, 0], [10, 2]),
        ([1, 0, 1, 0, 0], [0, 10], [-2, 9]),
        ([1, 0, 1, 0, 0], [10, 0], [10, -3]),
        // they drift by their end points: overflows of a derivative, of y, of x, and the watchdog
        ([1, -1, -2, -4, 16], [0, 7], [7, 5]),
        ([2, 0, -1, -11, -14], [5, -10], [4, -5]),
        ([-1, -3, -2, -11, -11], [3, -3], [14, -12]),
        ([1, 2, 1, 13, 14], [10, -12], [-8, 3]),
    ];
    let case = |(coefficients, start, end): ([i64; 5], [i64; 2], [i64; 2])| {
        let [a, b, c, d, e] = coefficients;
        let mut input = CurveInput { coefficients: [a, b, c, d, e, 0], start, end, clockwise: false, bits: 5 };
        input.coefficients[5] = -input.value(start) as i64;
        let course = input.course().unwrap();
        let names = ["a", "b", "c", "d", "e", "xh", "yh", "xk", "yk", "limit", "last"];
        let values = coefficients.into_iter().chain(start).chain(end).map(|v| v as u64);
        let inputs = names.into_iter().zip(values.chain([course.limit, course.last])).collect();
        let curve: Box<dyn Interpolator> = Box::new(DdaCurve::new(input, &Options::default()).unwrap());
        (inputs, curve)
    };
    curves.map(case).into()
}
