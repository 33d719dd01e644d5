//! Lines and arcs in all quadrants: the circuits around the interpolators of the first quadrant do what the algorithms do
//! on every clock.

use crate::support::Rng;
use crate::support::bench::{Bench, circuit};
use crate::support::engines;
use discreta::interpolate::{
    ArcInput, ArcPath, Columns, EfCircle, EfCircleFast, InputError, Interpolator, Karibsky, Method, Quadrants, Request,
};

/// What makes an arc of the first quadrant.
type Core = fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError>;

/// The circuits of arcs, and the algorithms that they have as their cores.
const ARCS: &[(&str, Core)] = &[
    ("circuits/quadrant/circle.json", |input| Ok(Box::new(EfCircle::new(input)?))),
    ("circuits/quadrant/fast_circle.json", |input| Ok(Box::new(EfCircleFast::new(input)?))),
    ("circuits/quadrant/karibsky.json", |input| Ok(Box::new(Karibsky::new(input)?))),
];

/// The circuits of lines, and the methods that they have as their cores.
const LINES: &[(&str, Method)] = &[
    ("circuits/quadrant/line.json", Method::EfLine),
    ("circuits/quadrant/fast_line.json", Method::EfLineFast),
    ("circuits/quadrant/dda_line.json", Method::DdaLine),
    ("circuits/quadrant/line_3d.json", Method::EfLine3d),
];

/// Draws arcs one after another with every circuit that can; the clocks compared.
fn draw(circuits: &[(&str, Core)], bits: u32, arcs: impl Iterator<Item = ArcPath> + Clone) -> u64 {
    let mut clocks = 0;
    for &(file, core) in circuits {
        let circuit = circuit(file, &[("W", i64::from(bits))]);
        let mut bench = Bench::new(&circuit, Columns::EVALUATION);
        let inputs = ["cw", "xh", "yh", "xk", "yk", "xc", "yc", "f0"].map(|name| bench.input(name));
        for arc in arcs.clone() {
            let ArcPath { clockwise, from, to, center, f0, .. } = arc;
            let mut algorithm = match Quadrants::new(arc, true, core) {
                Ok(algorithm) => algorithm,
                Err(InputError::TooShort) => continue,
                Err(e) => panic!("{file}: {arc:?}: {e}"),
            };
            let values = [i64::from(clockwise), from[0], from[1], to[0], to[1], center[0], center[1], f0];
            let set: Vec<_> = inputs.into_iter().zip(values.map(|v| v as u64)).collect();
            bench.draw(&set, &mut algorithm).unwrap_or_else(|fault| panic!("{file}: {arc:?}, {fault}"));
        }
        clocks += bench.clocks;
    }
    clocks
}

/// Points but the centre with both coordinates up to `most`.
fn points(most: i64) -> impl Iterator<Item = [i64; 2]> + Clone {
    (-most..=most).flat_map(move |x| (-most..=most).map(move |y| [x, y])).filter(|&p| p != [0, 0])
}

fn length([x, y]: [i64; 2]) -> f64 {
    ((x * x + y * y) as f64).sqrt()
}

fn path(from: [i64; 2], to: [i64; 2], clockwise: bool, bits: u32) -> ArcPath {
    ArcPath { center: [0; 2], from, to, full: true, long: None, clockwise, f0: 0, bits }
}

/// Every full circle with a radius up to 10, and every arc between points of 4 bits that no rounding forbids.
#[test]
fn every_small_circle_and_arc() {
    let circles = points(7).flat_map(|p| [path(p, p, false, 4), path(p, p, true, 4)]);
    let arcs = points(5).flat_map(|from| {
        let near = points(7).filter(move |to| (length(*to) - length(from)).abs() < 2.0);
        near.flat_map(move |to| [path(from, to, false, 4), path(from, to, true, 4)])
    });
    let arcs: Vec<_> = circles.chain(arcs).collect();
    let clocks = draw(ARCS, 4, arcs.iter().copied());
    println!("{} arcs of 4 bits, {clocks} clocks", arcs.len());
    engines::ran(1, 1);
}

/// Arcs of greater widths, with other centres; some begin off their circle, as `F₀` says.
#[test]
fn a_sample_of_arcs_of_other_widths() {
    for (bits, number) in [(2, 60), (3, 200), (8, 150), (16, 2)] {
        let mut rng = Rng::new(u64::from(bits));
        let most = (1_i64 << bits) - 1;
        let mut arcs = Vec::new();
        while arcs.len() < number {
            let reach = if bits == 16 { 1500 } else { most };
            let mut point = || [0, 1].map(|_| rng.below(2 * reach as u64 + 1) as i64 - reach);
            let (from, towards) = (point(), point());
            let radius = length(from);
            if radius < 1.0 || radius > most as f64 - 1.0 || towards == [0, 0] {
                continue;
            }
            // rounded, as real programs give them
            let to = if rng.one_in(4) {
                from
            } else {
                towards.map(|v| (v as f64 * radius / length(towards)).round() as i64)
            };
            let room = most - radius.ceil() as i64;
            let center = [0, 1].map(|_| rng.below(2 * room as u64 + 1) as i64 - room);
            let moved = |p: [i64; 2]| [p[0] + center[0], p[1] + center[1]];
            let f0 = if rng.one_in(2) { rng.below(radius as u64) as i64 - radius as i64 / 2 } else { 0 };
            let clockwise = rng.one_in(2);
            arcs.push(ArcPath { center, f0, ..path(moved(from), moved(to), clockwise, bits) });
        }
        let clocks = draw(ARCS, bits, arcs.iter().copied());
        println!("{number} arcs of {bits} bits, {clocks} clocks");
    }
    engines::ran(1, 1);
}

/// The increments of a line and its start point; z is for those in space.
type Line = [[i64; 3]; 2];

/// Draws lines one after another with every circuit; the clocks compared.
fn draw_lines(bits: u32, lines: &[Line]) -> u64 {
    let mut clocks = 0;
    // a DDA has registers of 2 bits at least
    for &(file, method) in LINES.iter().filter(|(_, method)| bits > 1 || *method != Method::DdaLine) {
        let circuit = circuit(file, &[("W", i64::from(bits))]);
        let request = |[d, h]: Line, axes: usize| {
            let mut request = Request { bits: Some(bits), ..Request::new(method, [0; 3]) };
            for axis in 0..axes {
                (request.from[axis], request.to[axis]) = (h[axis], h[axis] + d[axis]);
            }
            request.draw().unwrap_or_else(|e| panic!("{file}: {d:?} from {h:?}: {e}"))
        };
        let columns = request([[0; 3]; 2], 0).interpolator.columns();
        let axes = columns.at.len();
        let mut bench = Bench::new(&circuit, columns);
        let inputs = [["dx", "dy", "dz"], ["xh", "yh", "zh"]]
            .map(|names| names[..axes].iter().map(|name| bench.input(name)).collect::<Vec<_>>());
        for &line in lines {
            let mut algorithm = request(line, axes).interpolator;
            let set: Vec<_> = inputs.iter().zip(line).flat_map(|(inputs, v)| inputs.iter().copied().zip(v)).collect();
            let set: Vec<_> = set.into_iter().map(|(input, v)| (input, v as u64)).collect();
            bench.draw(&set, &mut algorithm).unwrap_or_else(|fault| panic!("{file}: {line:?}, {fault}"));
        }
        clocks += bench.clocks;
    }
    clocks
}

#[test]
fn every_line_up_to_8_along_each_axis() {
    let mut rng = Rng::new(8);
    let mut lines = Vec::new();
    for (dx, dy) in (-8..=8).flat_map(|dx| (-8..=8).map(move |dy| (dx, dy))) {
        for far in [0, 1] {
            let mut coordinate = || far * (rng.below(32) as i64 - 16);
            let start = [coordinate(), coordinate(), coordinate()];
            lines.push([[dx, dy, rng.below(17) as i64 - 8], start]);
        }
    }
    println!("{} lines of 4 bits, {} clocks", lines.len(), draw_lines(4, &lines));
    engines::ran(1, 1);
}

#[test]
fn a_sample_of_lines_of_other_widths() {
    for (bits, number) in [(1, 100), (2, 200), (8, 200), (16, 2)] {
        let mut rng = Rng::new(u64::from(bits));
        let most = (1_i64 << bits) - 1;
        let reach = most.min(3000);
        let lines: Vec<Line> = (0..number)
            .map(|n| {
                let mut signed = |most: i64| rng.below(2 * most as u64 + 1) as i64 - most;
                let mut d = [reach; 3].map(&mut signed);
                match n % 8 {
                    0 => d[0] = -most,
                    1 => d[1] = 0,
                    _ => {}
                }
                [d, [most; 3].map(&mut signed)]
            })
            .collect();
        println!("{number} lines of {bits} bits, {} clocks", draw_lines(bits, &lines));
    }
    engines::ran(1, 1);
}
