//! The arcs by evaluation function and by Karibsky's rule: the circuit of registers, the circuit of gates and the
//! algorithm agree on every clock, in both directions.

use crate::support::Rng;
use crate::support::bench::circuit;
use crate::support::lanes::{Drawing, draw_all};
use discreta::interpolate::{ArcInput, Columns, EfCircle, EfCircleFast, InputError, Interpolator, Karibsky};

/// A method: its circuits, and its algorithm.
struct Method {
    circuits: [&'static str; 2],
    algorithm: fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError>,
}

const METHODS: [Method; 3] = [
    Method {
        circuits: ["circuits/evaluation/circle.json", "circuits/evaluation/circle_gates.json"],
        algorithm: |input| Ok(Box::new(EfCircle::new(input)?)),
    },
    Method {
        circuits: ["circuits/evaluation/fast_circle.json", "circuits/evaluation/fast_circle_gates.json"],
        algorithm: |input| Ok(Box::new(EfCircleFast::new(input)?)),
    },
    Method {
        circuits: ["circuits/evaluation/karibsky.json", "circuits/evaluation/karibsky_gates.json"],
        algorithm: |input| Ok(Box::new(Karibsky::new(input)?)),
    },
];

/// Whether an arc is for a method: the accelerated one refuses it where `F₀` is near the end of its range and the start
/// has x = y.
fn refused(arc: ArcInput) -> bool {
    arc.xh == arc.yh && arc.f0 + 2 >= 2 << arc.bits
}

/// Draws the arcs one after another with every method, each circuit for the arcs of its direction.
fn check_all(what: &str, bits: u32, arcs: &[ArcInput]) {
    let mut clocks = 0;
    for method in &METHODS {
        for path in method.circuits {
            for clockwise in [false, true] {
                let circuit = circuit(path, &[("W", i64::from(bits)), ("CLOCKWISE", i64::from(clockwise))]);
                let drawing = |&arc: &ArcInput| {
                    assert_eq!(arc.bits, bits);
                    let inputs = [arc.dx, arc.dy, arc.xh, arc.yh, arc.f0].map(|v| v as u64).to_vec();
                    match (method.algorithm)(arc) {
                        Ok(algorithm) => Some(Drawing { inputs, algorithm }),
                        Err(error) => {
                            assert!(refused(arc), "{arc:?}: {error}");
                            None
                        }
                    }
                };
                let drawings = || arcs.iter().filter(|arc| arc.clockwise == clockwise).filter_map(drawing);
                let names = ["dx", "dy", "xh", "yh", "f0"];
                let drawn = draw_all(&circuit, Columns::EVALUATION, &names, drawings);
                clocks += drawn.unwrap_or_else(|fault| panic!("{path}: {fault}"));
            }
        }
    }
    println!("{what}: {} arcs, {clocks} clocks", arcs.len());
}

/// The arc and its mirror image, x and y exchanged, which goes the other way round.
fn both(arc: ArcInput) -> [ArcInput; 2] {
    let ArcInput { xh, yh, dx, dy, clockwise, .. } = arc;
    [arc, ArcInput { xh: yh, yh: xh, dx: dy, dy: dx, clockwise: !clockwise, ..arc }]
}

/// Every start, and every end in the direction, whether or not a circle around the origin goes through both.
fn every_4_bit_arc() -> impl Iterator<Item = ArcInput> {
    let points = (0..16).flat_map(|x| (0..16).map(move |y| (x, y))).skip(1);
    points.flat_map(|(xh, yh)| {
        let ends = (0..=xh).flat_map(move |xk| (yh..16).map(move |yk| (xk, yk)));
        ends.flat_map(move |end| both(ArcInput::between((xh, yh), end, false, 4)))
    })
}

#[test]
fn every_4_bit_arc_from_a_start_on_the_circle() {
    let arcs: Vec<_> = every_4_bit_arc().collect();
    assert_eq!(arcs.len(), 2 * (136 * 136 - 16));
    check_all("F0 = 0", 4, &arcs);
}

#[test]
fn every_4_bit_arc_from_a_start_off_the_circle() {
    let mut rng = Rng::named("f0");
    let arcs: Vec<_> = every_4_bit_arc().map(|arc| ArcInput { f0: rng.below(64) as i64 - 32, ..arc }).collect();
    check_all("any F0", 4, &arcs);
    // the circle through the end instead of the start
    let through_the_end = |arc: ArcInput| {
        let (xk, yk) = arc.end();
        ArcInput { f0: arc.xh * arc.xh + arc.yh * arc.yh - xk * xk - yk * yk, ..arc }
    };
    let arcs: Vec<_> = every_4_bit_arc().map(through_the_end).filter(|arc| arc.check().is_ok()).collect();
    assert!(arcs.len() > 10_000);
    check_all("F = 0 at the end", 4, &arcs);
}

#[test]
fn every_8_bit_quarter_arc() {
    let arcs: Vec<_> = (1..256).flat_map(|r| both(ArcInput::between((r, 0), (0, r), false, 8))).collect();
    check_all("quarter arcs", 8, &arcs);
}

/// An arc between two random points near one circle of radius `2^bits − 1` at most, rounded.
fn general(rng: &mut Rng, bits: u32) -> Option<ArcInput> {
    let most = (1_u64 << bits) - 1;
    let radius = if rng.one_in(4) { most } else { 1 + rng.below(most) } as f64;
    let mut point = || {
        let x = if rng.one_in(8) { radius } else { (rng.below(most + 1) as f64).min(radius) };
        let y = (radius * radius - x * x).sqrt();
        let (x, y) = if rng.one_in(2) { (x, y) } else { (y, x) };
        (x.round() as i64, y.round() as i64)
    };
    let (from, to) = (point(), point());
    let f0 = from.0 * from.0 + from.1 * from.1 - (radius * radius) as i64;
    let arc = ArcInput { f0, ..ArcInput::between(from, to, from.0 < to.0, bits) };
    arc.check().is_ok().then_some(arc)
}

fn some(bits: u32, count: usize) -> Vec<ArcInput> {
    let mut rng = Rng::new(u64::from(bits));
    std::iter::from_fn(|| Some(general(&mut rng, bits))).flatten().take(count).collect()
}

#[test]
fn a_sample_of_general_arcs_of_other_widths() {
    for (bits, count) in [(1, 20), (2, 50), (3, 100), (5, 500), (8, 500), (12, 20)] {
        check_all(&format!("{bits} bits"), bits, &some(bits, count));
    }
}

#[test]
fn a_sample_of_general_arcs_of_16_bits() {
    let arcs = some(16, 10);
    assert!(arcs.iter().any(|a| a.clockwise) && arcs.iter().any(|a| !a.clockwise));
    check_all("16 bits", 16, &arcs);
}
