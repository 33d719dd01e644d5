//! The lines in space: the circuits of registers, the circuits of gates and the algorithms agree on every clock.

use crate::support::Rng;
use crate::support::bench::{Bench, circuit};
use discreta::interpolate::{DdaLine3d, EfLine3d, Interpolator, Line3dInput};

const EVALUATION: [&str; 2] = ["circuits/three_axis/line.json", "circuits/three_axis/line_gates.json"];
const INCREMENTS: [&str; 2] = ["circuits/three_axis/dda_line.json", "circuits/three_axis/dda_line_gates.json"];

/// Draws lines one after another in each circuit; the clocks compared.
fn check(
    paths: [&str; 2],
    parameters: &[(&str, i64)],
    algorithm: impl Fn(Line3dInput) -> Box<dyn Interpolator>,
    lines: &[Line3dInput],
) -> u64 {
    let bits = lines[0].bits;
    let parameters: Vec<_> = parameters.iter().copied().chain([("W", i64::from(bits))]).collect();
    let mut clocks = 0;
    for path in paths {
        let circuit = circuit(path, &parameters);
        let mut bench = Bench::new(&circuit, algorithm(lines[0]).columns());
        let [d, h] = [["dx", "dy", "dz"], ["xh", "yh", "zh"]].map(|names| names.map(|name| bench.input(name)));
        for line in lines {
            let mut inputs = Vec::new();
            for a in 0..3 {
                inputs.extend([(d[a], line.increment[a] as u64), (h[a], line.start[a] as u64)]);
            }
            bench.draw(&inputs, &mut *algorithm(*line)).unwrap_or_else(|fault| panic!("{path}: {line:?}, {fault}"));
        }
        clocks += bench.clocks;
    }
    clocks
}

fn check_all(lines: &[Line3dInput]) {
    let evaluation = check(EVALUATION, &[], |line| Box::new(EfLine3d::new(line).unwrap()), lines);
    let mut increments = 0;
    for half in [false, true] {
        let parameters = [("HALF_PRELOAD", i64::from(half))];
        increments += check(INCREMENTS, &parameters, |line| Box::new(DdaLine3d::new(line, half).unwrap()), lines);
    }
    println!("{} lines of {} bits, {evaluation} + {increments} clocks", lines.len(), lines[0].bits);
}

/// Every line of that many bits, from start points that change.
fn every(bits: u32) -> Vec<Line3dInput> {
    let (n, mut rng) = (1_u64 << bits, Rng::new(u64::from(bits)));
    let increments = (0..n * n * n).map(|k| [k / n / n, k / n % n, k % n]);
    let mut start = || rng.below(n) as i64;
    increments
        .map(|d| Line3dInput { start: [start(), start(), start()], increment: d.map(|d| d as i64), bits })
        .collect()
}

/// Lines with the ends of the range often among their increments: 0, 1, the greatest, and two alike.
fn sample(bits: u32, lines: usize) -> Vec<Line3dInput> {
    let (n, mut rng) = (1_u64 << bits, Rng::new(u64::from(bits) << 8));
    let mut number = move || match rng.below(4) {
        0 => *rng.pick(&[0, 1, n - 1, n / 2]) as i64,
        _ => rng.below(n) as i64,
    };
    (0..lines)
        .map(|k| {
            let mut increment = [number(), number(), number()];
            if k % 5 == 0 {
                increment[k % 3] = increment[(k + 1) % 3];
            }
            Line3dInput { start: [number(), number(), number()], increment, bits }
        })
        .collect()
}

#[test]
fn every_line_of_3_bits() {
    check_all(&every(3));
}

#[test]
fn every_line_of_1_and_2_bits() {
    check_all(&every(1));
    check_all(&every(2));
}

#[test]
fn every_line_of_4_bits() {
    check_all(&every(4));
}

#[test]
fn a_sample_of_lines_of_8_bits() {
    check_all(&sample(8, 60));
}

/// Of 16 bits, where a line by differential increments takes 65,536 clocks.
#[test]
fn a_sample_of_lines_of_16_bits() {
    let short = |line: &Line3dInput| Line3dInput { increment: line.increment.map(|d| d >> 6), ..*line };
    let lines: Vec<_> = sample(16, 40).iter().map(short).collect();
    check(EVALUATION, &[], |line| Box::new(EfLine3d::new(line).unwrap()), &lines);
    check(INCREMENTS, &[], |line| Box::new(DdaLine3d::new(line, false).unwrap()), &sample(16, 1));
}

/// Document B: the interval after a step along two axes 1.41 times as long, along three 1.73 times. Over every line of
/// 4 and of 5 bits: the length of the line a unit of time.
#[test]
fn longer_intervals_do_not_keep_the_speed() {
    for (bits, least, greatest) in [(4, 0.8682, 1.0030), (5, 0.8680, 1.0030)] {
        let (mut slowest, mut fastest) = (f64::MAX, 0.0_f64);
        for input in every(bits).into_iter().filter(|line| line.increment != [0; 3]) {
            let length = input.increment.iter().map(|d| (d * d) as f64).sum::<f64>().sqrt();
            let line = EfLine3d::new(input).unwrap();
            let speed = length / line.map(|clock| [0.0, 1.0, 1.41, 1.73][clock.axes()]).sum::<f64>();
            (slowest, fastest) = (slowest.min(speed), fastest.max(speed));
        }
        assert!((slowest - least).abs() < 1e-4 && (fastest - greatest).abs() < 1e-4, "{bits}: {slowest} {fastest}");
    }
}
