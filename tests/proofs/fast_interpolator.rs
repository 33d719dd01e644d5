//! The accelerated line by evaluation function, and the centred start of both lines: the circuit of registers, the
//! circuit of gates and the algorithm agree on every clock. (The accelerated arc is in `circle_interpolator.rs`.)

use crate::support::Rng;
use crate::support::bench::circuit;
use crate::support::engines;
use crate::support::lanes::{Drawing, draw_all};
use discreta::interpolate::{EfLine, EfLineFast, EfLineFastPrinted, Interpolator, LineInput};

/// A circuit, its parameter CENTRED if it has one, and its algorithm.
struct Method {
    circuit: &'static str,
    centred: Option<i64>,
    algorithm: fn(LineInput) -> Box<dyn Interpolator>,
}

fn fast(input: LineInput) -> Box<dyn Interpolator> {
    Box::new(EfLineFast::new(input).unwrap())
}

fn centred_fast(input: LineInput) -> Box<dyn Interpolator> {
    Box::new(EfLineFast::centred(input).unwrap())
}

fn centred(input: LineInput) -> Box<dyn Interpolator> {
    Box::new(EfLine::centred(input).unwrap())
}

fn diagram(input: LineInput) -> Box<dyn Interpolator> {
    Box::new(EfLineFastPrinted::diagram(input).unwrap())
}

const FAST: [Method; 2] = [
    Method { circuit: "circuits/evaluation/fast_line.json", centred: Some(0), algorithm: fast },
    Method { circuit: "circuits/evaluation/fast_line_gates.json", centred: Some(0), algorithm: fast },
];

const CENTRED: [Method; 4] = [
    Method { circuit: "circuits/evaluation/fast_line.json", centred: Some(1), algorithm: centred_fast },
    Method { circuit: "circuits/evaluation/fast_line_gates.json", centred: Some(1), algorithm: centred_fast },
    Method { circuit: "circuits/evaluation/line.json", centred: Some(1), algorithm: centred },
    Method { circuit: "circuits/evaluation/line_gates.json", centred: Some(1), algorithm: centred },
];

const DIAGRAM: [Method; 1] =
    [Method { circuit: "circuits/evaluation/fast_line_x.json", centred: None, algorithm: diagram }];

/// Draws the lines one after another with every method.
fn check_all(what: &str, methods: &[Method], bits: u32, lines: &[LineInput]) {
    let mut clocks = 0;
    for &Method { circuit: path, centred, algorithm } in methods {
        let mut parameters = vec![("W", i64::from(bits))];
        parameters.extend(centred.map(|centred| ("CENTRED", centred)));
        let circuit = circuit(path, &parameters);
        let drawing = |&line: &LineInput| {
            assert_eq!(line.bits, bits);
            let inputs = [line.dx, line.dy, line.xh, line.yh].map(|v| v as u64).to_vec();
            Drawing { inputs, algorithm: algorithm(line) }
        };
        let columns = algorithm(lines[0]).columns();
        let drawn = draw_all(&circuit, columns, &["dx", "dy", "xh", "yh"], || lines.iter().map(drawing));
        clocks += drawn.unwrap_or_else(|fault| panic!("{path}: {fault}"));
    }
    println!("{what}: {} lines, {clocks} clocks", lines.len());
}

/// Every line, from a start point drawn at random.
fn every(bits: u32, rng: &mut Rng) -> Vec<LineInput> {
    let all = (0..1 << bits).flat_map(|dx| (0..1 << bits).map(move |dy| (dx, dy)));
    all.map(|(dx, dy)| {
        let mut coordinate = || rng.below(1 << bits) as i64;
        LineInput { xh: coordinate(), yh: coordinate(), dx, dy, bits }
    })
    .collect()
}

/// What the text's diagram is for: `ΔX ≥ ΔY`, where a tie ends one short; and `ΔX = 0`, which ends at once.
fn for_the_diagram(lines: Vec<LineInput>) -> Vec<LineInput> {
    lines.into_iter().filter(|line| line.dx >= line.dy || line.dx == 0).collect()
}

#[test]
fn every_4_bit_line_from_the_origin_and_from_elsewhere() {
    let mut rng = Rng::new(4);
    let mut lines: Vec<_> = every(4, &mut rng).into_iter().map(|line| LineInput { xh: 0, yh: 0, ..line }).collect();
    for _ in 0..3 {
        lines.extend(every(4, &mut rng));
    }
    check_all("accelerated", &FAST, 4, &lines);
    check_all("centred", &CENTRED, 4, &lines);
    check_all("the diagram", &DIAGRAM, 4, &for_the_diagram(lines));
    engines::ran(1, 1);
}

#[test]
fn a_sample_of_lines_of_other_widths() {
    for bits in [1, 2, 3, 5, 12, 16] {
        let mut rng = Rng::new(u64::from(bits));
        let most = (1 << bits) - 1;
        let lines: Vec<_> = (0..if bits > 8 { 6 } else { 200 })
            .map(|n| {
                // the ends of the range often: 0, 1, the greatest
                let mut any = |n: u64| if n == 0 { rng.below(most + 1) } else { *rng.pick(&[0, 1, most, most - 1]) };
                let [dx, dy, xh, yh] = [n % 2, n % 3, n % 3, n % 2].map(|n| any(n) as i64);
                LineInput { xh, yh, dx, dy, bits }
            })
            .collect();
        check_all(&format!("{bits} bits, accelerated"), &FAST, bits, &lines);
        check_all(&format!("{bits} bits, centred"), &CENTRED, bits, &lines);
        check_all(&format!("{bits} bits, the diagram"), &DIAGRAM, bits, &for_the_diagram(lines));
    }
    engines::ran(1, 1);
}

#[test]
fn every_8_bit_line_in_registers() {
    check_all("accelerated, registers", &FAST[..1], 8, &every(8, &mut Rng::new(8)));
    check_all("the diagram", &DIAGRAM, 8, &for_the_diagram(every(8, &mut Rng::new(9))));
    engines::ran(1, 1);
}

#[test]
fn every_8_bit_line_in_gates() {
    check_all("accelerated, gates", &FAST[1..], 8, &every(8, &mut Rng::new(10)));
    engines::ran(1, 1);
}

#[test]
fn every_8_bit_line_from_a_centred_start() {
    let lines = every(8, &mut Rng::new(11));
    check_all("centred, registers", &[&CENTRED[0], &CENTRED[2]].map(|m| Method { ..*m }), 8, &lines);
    check_all("centred, gates", &[&CENTRED[1], &CENTRED[3]].map(|m| Method { ..*m }), 8, &lines);
    engines::ran(1, 1);
}
