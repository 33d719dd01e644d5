//! The general curve of the second order: it gets to its end point, near the curve, and the circuit agrees with it on
//! every clock.

use crate::support::Rng;
use crate::support::bench::{Bench, circuit};
use crate::support::engines;
use discreta::interpolate::{CurveInput, DdaCurve, Ideal, Interpolator, Options, Printed, Stopped};

/// A number from −n to n.
fn around(rng: &mut Rng, n: i64) -> i64 {
    rng.below(2 * n as u64 + 1) as i64 - n
}

/// A drawing of that kind that is not refused, between points that may be half a BLU off along each axis.
fn random(rng: &mut Rng, kind: &str, bits: u32) -> CurveInput {
    let (full, half) = (1_i64 << bits, 1_i64 << (bits - 1));
    loop {
        let small = [around(rng, 3), around(rng, 3), around(rng, 3)];
        let [a, b, c] = match kind {
            "line" => [0, 0, 0],
            "circle" => [small[0], 0, small[0]],
            "parabola" => [small[0] * small[0], 2 * small[0] * small[1], small[1] * small[1]],
            _ => small,
        };
        let determinant = 4 * a * c - b * b;
        if kind == "ellipse" && determinant <= 0 || kind == "hyperbola" && determinant >= 0 {
            continue;
        }
        let (d, e) = (around(rng, full / 2), around(rng, full / 2));
        let start = [around(rng, half - 1), around(rng, half - 1)];
        let mut input =
            CurveInput { coefficients: [a, b, c, d, e, 0], start, end: start, clockwise: rng.one_in(2), bits };
        input.coefficients[5] = -input.value(start) as i64;
        if input.gradient(start).iter().all(|g| g.abs() < 8) {
            continue; // stands almost still
        }
        input.end = match end(&input, rng) {
            Some(end) => end,
            None => continue,
        };
        if input.course().is_ok() {
            return input;
        }
    }
}

/// A point of the curve ahead of the start point, or now and then the start point; by steps of a quarter BLU along the
/// tangent and back onto the curve.
fn end(input: &CurveInput, rng: &mut Rng) -> Option<[i64; 2]> {
    let [a, b, c, d, e, f] = input.coefficients.map(|v| v as f64);
    let mut p = input.start.map(|v| v as f64);
    if 4.0 * a * c > b * b && rng.one_in(4) {
        return Some(input.start);
    }
    let sign = if input.clockwise { -1.0 } else { 1.0 };
    for _ in 0..rng.below(8 << input.bits) {
        let [gx, gy] = [2.0 * a * p[0] + b * p[1] + d, b * p[0] + 2.0 * c * p[1] + e];
        let length = gx.hypot(gy);
        let [x, y] = [p[0] - sign * gy / length / 4.0, p[1] + sign * gx / length / 4.0];
        let value = a * x * x + b * x * y + c * y * y + d * x + e * y + f;
        let next = [x - value * gx / length / length, y - value * gy / length / length];
        if !next.iter().all(|v| v.abs() < f64::from(1 << (input.bits - 1)) - 2.0) {
            break;
        }
        p = next;
    }
    Some(p.map(|v| v.round() as i64))
}

const SETTINGS: [(bool, bool); 4] = [(false, false), (false, true), (true, false), (true, true)];

fn options((parallel, half_preload): (bool, bool)) -> Options {
    Options { parallel, half_preload, ..Options::default() }
}

/// The greatest deviation in BLU of the 150 curves of a kind, for each of the settings.
const WITHIN: [(&str, [f64; 4]); 6] = [
    ("line", [1.39, 0.86, 1.39, 0.86]),
    ("circle", [1.75, 1.07, 3.65, 3.53]),
    ("ellipse", [5.49, 6.19, 4.45, 3.20]),
    ("parabola", [8.35, 12.26, 8.21, 1.09]),
    ("hyperbola", [5.35, 1.66, 5.35, 1.09]),
    ("any", [3.47, 3.24, 3.97, 3.43]),
];

/// Coefficients up to 3 (of a parabola, squares of them) at 8 bits; docs/interpolators-curve.md shows the table.
#[test]
fn every_kind_of_curve_gets_to_its_end() {
    let mut stopped = Vec::new();
    for (kind, within) in WITHIN {
        let mut rng = Rng::named(kind);
        let inputs: Vec<_> = (0..150).map(|_| random(&mut rng, kind, 8)).collect();
        for (setting, within) in SETTINGS.into_iter().zip(within) {
            let mut worst = 0_f64;
            for &input in &inputs {
                let ideal = Ideal::Conic { coefficients: input.coefficients.map(|v| v as f64) };
                let mut curve = DdaCurve::new(input, &options(setting)).unwrap();
                let deviation = |at: [i64; 3]| ideal.deviation(at.map(|v| v as f64)).abs();
                let off = curve.by_ref().map(|c| if c.axes() == 0 { 0.0 } else { deviation(c.at) }).fold(0.0, f64::max);
                match curve.stopped() {
                    None => {
                        assert_eq!(curve.state().at[..2], input.end, "{input:?}");
                        worst = worst.max(off);
                    }
                    Some(why) => stopped.push((kind, setting, why)),
                }
            }
            println!("{kind} {setting:?}: within {worst:.2} BLU");
            assert!((worst - within).abs() < 0.006, "{kind} {setting:?}: within {worst:.3} BLU, not {within}");
        }
    }
    // they have drifted by the end point, and say so
    assert!(stopped.len() == 5 && stopped.iter().all(|s| s.0 != "line" && s.0 != "circle"), "{stopped:?}");
}

const REGISTERS: &str = "circuits/dda/curve.json";
const GATES: &str = "circuits/dda/curve_gates.json";

/// How often the circuit did what.
#[derive(Debug, Default, PartialEq, Eq)]
struct Count {
    ended: usize,
    overflows: usize,
    watchdogs: usize,
    clocks: u64,
}

/// Draws curves one after another, all clockwise or none, in a circuit and by the algorithm.
fn follow(path: &str, inputs: &[CurveInput], setting: (bool, bool), printed: Printed, count: &mut Count) {
    let parameters = [
        ("W", i64::from(inputs[0].bits)),
        ("CLOCKWISE", i64::from(inputs[0].clockwise)),
        ("PARALLEL", i64::from(setting.0)),
        ("HALF_PRELOAD", i64::from(setting.1)),
        ("PRINTED_SIGNS", i64::from(printed.signs)),
        ("PRINTED_BY", i64::from(printed.by)),
    ];
    let circuit = circuit(path, &parameters);
    let algorithm = |input| DdaCurve::with_misprints(input, &options(setting), printed).unwrap();
    let mut bench = Bench::new(&circuit, algorithm(inputs[0]).columns());
    let names = ["a", "b", "c", "d", "e", "xh", "yh", "xk", "yk", "limit", "last"];
    let ports = names.map(|name| bench.input(name));
    for &input in inputs {
        let course = input.course().unwrap();
        let values = input.coefficients[..5].iter().chain(&input.start).chain(&input.end).map(|&v| v as u64);
        let values = values.chain([course.limit, course.last]);
        let set: Vec<_> = ports.into_iter().zip(values).collect();
        let mut curve = algorithm(input);
        bench.draw(&set, &mut curve).unwrap_or_else(|fault| panic!("{path} {parameters:?}: {input:?}, {fault}"));
        *match curve.stopped() {
            None => &mut count.ended,
            Some(Stopped::Overflow { .. }) => &mut count.overflows,
            Some(_) => &mut count.watchdogs,
        } += 1;
    }
    count.clocks += bench.clocks;
}

/// Both directions, sequential and parallel, with and without half preload.
fn follow_all(path: &str, bits: u32, curves: usize) -> Count {
    let mut count = Count::default();
    let mut rng = Rng::new(u64::from(bits));
    let inputs: Vec<_> = WITHIN
        .iter()
        .flat_map(|(kind, _)| (0..curves).map(|_| random(&mut rng, kind, bits)).collect::<Vec<_>>())
        .collect();
    for clockwise in [false, true] {
        let inputs: Vec<_> = inputs.iter().copied().filter(|i| i.clockwise == clockwise).collect();
        for setting in SETTINGS {
            follow(path, &inputs, setting, Printed::default(), &mut count);
        }
    }
    println!("{path}, {bits} bits: {count:?}");
    count
}

#[test]
fn the_circuit_agrees_on_every_clock() {
    for (bits, curves) in [(4, 40), (5, 40), (6, 30), (8, 12)] {
        assert!(follow_all(REGISTERS, bits, curves).ended >= 6 * 4 * curves * 9 / 10);
    }
    engines::ran(1, 1);
}

#[test]
fn the_circuit_of_gates_agrees_on_every_clock() {
    for (bits, curves) in [(4, 12), (6, 3)] {
        assert!(follow_all(GATES, bits, curves).ended >= 6 * 4 * curves * 9 / 10);
    }
    engines::ran(1, 1);
}

#[test]
fn the_circuit_agrees_in_other_widths() {
    follow_all(REGISTERS, 11, 1);
    engines::ran(1, 1);
}

/// With the misprints the paths run off, up to an overflow or the watchdog.
#[test]
fn the_circuit_agrees_as_printed() {
    let (mut count, mut rng) = (Count::default(), Rng::new(0));
    let mut inputs = Vec::new();
    for (kind, _) in WITHIN {
        inputs.extend((0..20).map(|_| random(&mut rng, kind, 6)));
    }
    for printed in
        [Printed { signs: true, by: true }, Printed { signs: true, by: false }, Printed { signs: false, by: true }]
    {
        for clockwise in [false, true] {
            let inputs: Vec<_> = inputs.iter().copied().filter(|i| i.clockwise == clockwise).collect();
            follow(REGISTERS, &inputs, (false, false), printed, &mut count);
            follow(GATES, &inputs[..8], (true, true), printed, &mut count);
        }
    }
    println!("{count:?}");
    assert!(count.overflows > 100 && count.watchdogs > 0, "{count:?}");
    engines::ran(1, 1);
}
