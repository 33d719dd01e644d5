//! The interpolators by differential increments: the circuits of registers, the circuits of gates and the algorithms agree
//! on every clock.

use crate::support::Rng;
use crate::support::bench::{Bench, circuit};
use crate::support::engines;
use crate::support::lanes::{Drawing, draw_all};
use discreta::circuit::Circuit;
use discreta::interpolate::{
    ArcInput, Columns, DdaCircle, DdaCirclePrinted, DdaLine, DdaLinePrinted, Interpolator, LineInput, Options,
};

const LINES: [&str; 2] = ["circuits/dda/line.json", "circuits/dda/line_gates.json"];
const CIRCLES: [&str; 2] = ["circuits/dda/circle.json", "circuits/dda/circle_gates.json"];

/// The parameters of a circuit beside its width.
#[derive(Clone, Copy, Debug)]
struct Setting {
    half: bool,
    parallel: bool,
    clockwise: bool,
    normalise: bool,
}

impl Setting {
    /// Every setting of a circle; those of a line are the first four.
    fn all() -> impl Iterator<Item = Setting> {
        (0..16).map(|n| Setting {
            half: n & 1 != 0,
            normalise: n & 2 != 0,
            parallel: n & 4 != 0,
            clockwise: n & 8 != 0,
        })
    }

    fn options(self) -> Options {
        let Setting { half, parallel, normalise, .. } = self;
        Options { half_preload: half, parallel, normalise, ..Options::default() }
    }

    fn line(self, path: &str, bits: u32) -> Circuit {
        let Setting { half, normalise, .. } = self;
        circuit(path, &[("W", i64::from(bits)), ("HALF_PRELOAD", half.into()), ("NORMALISE", normalise.into())])
    }

    fn circle(self, path: &str, bits: u32) -> Circuit {
        let Setting { half, parallel, clockwise, normalise } = self;
        let parameters = [
            ("W", i64::from(bits)),
            ("HALF_PRELOAD", half.into()),
            ("PARALLEL", parallel.into()),
            ("CLOCKWISE", clockwise.into()),
            ("NORMALISE", normalise.into()),
        ];
        circuit(path, &parameters)
    }
}

/// Draws with each of the inputs and compares every clock; the clocks compared.
fn draw<I: Copy, A: Interpolator>(
    what: &str,
    circuit: &Circuit,
    inputs: impl Iterator<Item = I>,
    ports: impl Fn(I) -> [i64; 4],
    algorithm: impl Fn(I) -> A,
) -> u64 {
    let mask = (1 << input_bits(circuit)) - 1;
    let inputs: Vec<I> = inputs.collect();
    let drawing = |&input: &I| {
        let inputs = ports(input).map(|v| (v & mask) as u64).to_vec();
        Drawing { inputs, algorithm: algorithm(input) }
    };
    let names = ["xh", "yh", "dx", "dy"];
    let drawn = draw_all(circuit, Columns::DDA_NORMALISED, &names, || inputs.iter().map(drawing));
    drawn.unwrap_or_else(|fault| panic!("{what}: {fault}"))
}

fn input_bits(circuit: &Circuit) -> u32 {
    circuit.netlist.signal(circuit.netlist.find("xh").unwrap()).width
}

fn lines(path: &str, setting: Setting, bits: u32, lines: impl Iterator<Item = LineInput>) -> u64 {
    let circuit = setting.line(path, bits);
    let algorithm = |input| DdaLine::new(input, &setting.options()).unwrap();
    draw(&format!("{path} {setting:?}"), &circuit, lines, |l| [l.xh, l.yh, l.dx, l.dy], algorithm)
}

fn arcs(path: &str, setting: Setting, bits: u32, arcs: impl Iterator<Item = ArcInput>) -> u64 {
    let circuit = setting.circle(path, bits);
    let arcs = arcs.map(|arc| turned(arc, setting.clockwise));
    let algorithm = |input| DdaCircle::new(input, &setting.options()).unwrap();
    draw(&format!("{path} {setting:?}"), &circuit, arcs, |l| [l.xh, l.yh, l.dx, l.dy], algorithm)
}

/// The mirror image of a counter-clockwise arc, if it is to be clockwise.
fn turned(arc: ArcInput, clockwise: bool) -> ArcInput {
    let ArcInput { xh, yh, dx, dy, .. } = arc;
    if clockwise { ArcInput { xh: yh, yh: xh, dx: dy, dy: dx, clockwise, ..arc } } else { arc }
}

/// Every pair of numbers of some bits.
fn pairs(bits: u32) -> impl Iterator<Item = (i64, i64)> + Clone {
    (0..1 << bits).flat_map(move |a| (0..1 << bits).map(move |b| (a, b)))
}

/// Every line of some bits, each from a start point of its own.
fn every_line(bits: u32) -> impl Iterator<Item = LineInput> {
    pairs(bits).map(move |(dx, dy)| {
        let mut rng = Rng::new((dx << bits | dy) as u64);
        let mut coordinate = || rng.below(1 << bits) as i64;
        LineInput { xh: coordinate(), yh: coordinate(), dx, dy, bits }
    })
}

/// Every arc of some bits that is not refused.
fn every_arc(bits: u32) -> impl Iterator<Item = ArcInput> {
    let all = pairs(bits).flat_map(move |from| pairs(bits).map(move |to| ArcInput::between(from, to, false, bits)));
    all.filter(|&arc| DdaCircle::new(arc, &Options::default()).is_ok())
}

/// The printed program ends with every line; (0, 0) too.
#[test]
fn every_4_bit_line_as_printed() {
    let circuit = circuit("circuits/dda/line_as_printed.json", &[("W", 4)]);
    let mut bench = Bench::new(&circuit, Columns::DDA);
    let inputs = ["xh", "yh", "dx", "dy"].map(|name| bench.input(name));
    for line in every_line(4) {
        let values = [line.xh, line.yh, line.dx, line.dy].map(|v| v as u64);
        let values: Vec<_> = inputs.into_iter().zip(values).collect();
        let mut algorithm = DdaLinePrinted::new(line, &Options::default()).unwrap();
        bench.draw(&values, &mut algorithm).unwrap_or_else(|fault| panic!("{line:?}, {fault}"));
    }
    engines::ran(1, 1);
}

/// As far as the bound of the watchdog, where not all of them end.
#[test]
fn every_4_bit_arc_as_printed() {
    for parallel in [false, true] {
        let circuit = circuit("circuits/dda/circle_as_printed.json", &[("W", 4), ("PARALLEL", i64::from(parallel))]);
        let mut bench = Bench::new(&circuit, Columns::DDA);
        let inputs = ["xh", "yh", "dx", "dy"].map(|name| bench.input(name));
        let (mut arcs, mut missed) = (0, 0);
        for arc in every_arc(4) {
            let values = [arc.xh, arc.yh, arc.dx, arc.dy].map(|v| v as u64);
            let values: Vec<_> = inputs.into_iter().zip(values).collect();
            let mut algorithm = DdaCirclePrinted::new(arc, &Options { parallel, ..Options::default() }).unwrap();
            let bound = algorithm.bound();
            let last = bench.draw_for(&values, &mut algorithm, bound);
            arcs += 1;
            missed += usize::from(!last.unwrap_or_else(|fault| panic!("{arc:?}, {fault}")).end);
        }
        println!("{missed} of {arcs} arcs of 4 bits miss their end as printed, parallel: {parallel}");
        assert!(missed > 0 && missed < arcs);
    }
    engines::ran(1, 1);
}

/// The quarter arcs of every radius.
fn quarters(bits: u32) -> impl Iterator<Item = ArcInput> {
    (1..1 << bits).map(move |r| ArcInput::between((r, 0), (0, r), false, bits))
}

#[test]
fn every_4_bit_line_in_every_setting() {
    let mut clocks = 0;
    for path in LINES {
        for setting in Setting::all().take(4) {
            clocks += lines(path, setting, 4, every_line(4));
        }
    }
    println!("256 lines of 4 bits in 4 settings, {clocks} clocks");
}

#[test]
fn every_4_bit_arc_in_every_setting() {
    let (mut clocks, arcs_of_4) = (0, every_arc(4).count());
    for path in CIRCLES {
        for setting in Setting::all() {
            clocks += arcs(path, setting, 4, every_arc(4));
        }
    }
    println!("{arcs_of_4} arcs of 4 bits in 16 settings, {clocks} clocks");
}

fn every_8_bit_line(normalise: bool) {
    for setting in Setting::all().take(4).filter(|s| s.normalise == normalise) {
        for path in LINES {
            let clocks = lines(path, setting, 8, every_line(8));
            println!("{path}: every line of 8 bits, {setting:?}, {clocks} clocks");
        }
    }
}

#[test]
fn every_8_bit_line_in_2_to_the_8_clocks() {
    every_8_bit_line(false);
}

#[test]
fn every_8_bit_line_normalised() {
    every_8_bit_line(true);
}

#[test]
fn every_8_bit_quarter_in_every_setting() {
    for path in CIRCLES {
        let clocks: u64 = Setting::all().map(|setting| arcs(path, setting, 8, quarters(8))).sum();
        println!("{path}: 255 quarters of 8 bits in 16 settings, {clocks} clocks");
    }
}

/// An arc of the circle through a point, to an end point that is rounded off the circle; a short one if told so.
fn rounded(rng: &mut Rng, bits: u32, most: i64) -> Option<ArcInput> {
    let mut coordinate = || rng.below(1 << bits) as i64;
    let (xh, yh) = (coordinate(), coordinate());
    let xk = (xh - rng.below(most as u64) as i64).max(0);
    let yk = ((xh * xh + yh * yh - xk * xk) as f64).sqrt().round() as i64;
    let arc = ArcInput::between((xh, yh), (xk, yk), false, bits);
    DdaCircle::new(arc, &Options::default()).is_ok().then_some(arc)
}

#[test]
fn a_sample_of_8_bit_arcs_in_every_setting() {
    for path in CIRCLES {
        let mut clocks = 0;
        for setting in Setting::all() {
            let mut rng = Rng::new(8);
            let sample = (0..400).filter_map(|_| rounded(&mut rng, 8, 256));
            clocks += arcs(path, setting, 8, sample);
        }
        println!("{path}: arcs of 8 bits in 16 settings, {clocks} clocks");
    }
}

#[test]
fn a_sample_of_other_widths() {
    for bits in [2, 3, 5, 6, 7, 9, 11] {
        for setting in Setting::all() {
            for path in LINES.into_iter().filter(|_| !setting.parallel && !setting.clockwise) {
                let mut rng = Rng::new(u64::from(bits));
                let sample = every_line(bits.min(7)).filter(|_| rng.one_in(1 << (2 * bits.min(7)).saturating_sub(5)));
                lines(path, setting, bits, sample.map(|line| LineInput { bits, ..line }));
            }
            for path in CIRCLES {
                let mut rng = Rng::new(u64::from(bits));
                arcs(path, setting, bits, (0..40).filter_map(|_| rounded(&mut rng, bits, 1 << bits.min(4))));
            }
        }
    }
}

#[test]
fn a_sample_of_16_bits() {
    let ends = [(65535, 65534), (1, 65535), (40000, 0), (12345, 54321)];
    let sample = ends.map(|(dx, dy)| LineInput { xh: -5, yh: 65530, dx, dy, bits: 16 });
    for path in LINES {
        for setting in Setting::all().take(4) {
            // the long ones in registers, the shorter half in gates
            let some = if path == LINES[0] { &sample[..] } else { &sample[..1] };
            let small = (1..40).map(|d| LineInput { xh: d, yh: 0, dx: d, dy: 3 * d % 41, bits: 16 });
            let small = small.filter(|_| setting.normalise);
            lines(path, setting, 16, some.iter().copied().chain(small));
        }
    }
    for path in CIRCLES {
        for setting in Setting::all() {
            let mut rng = Rng::new(16);
            let sample: Vec<_> = (0..60).filter_map(|_| rounded(&mut rng, 16, 300)).collect();
            let clocks = arcs(path, setting, 16, sample.iter().copied());
            println!("{path}: {} arcs of 16 bits, {setting:?}, {clocks} clocks", sample.len());
        }
    }
}

/// Normalised, a short line or arc is quick in wide registers too.
#[test]
fn the_widest_registers() {
    for bits in [24, 32] {
        for setting in Setting::all().filter(|s| s.normalise) {
            for path in LINES.into_iter().filter(|_| !setting.parallel && !setting.clockwise) {
                let wide = |(dx, dy)| LineInput { xh: -1, yh: (1 << bits) - 3, dx, dy, bits };
                lines(path, setting, bits, pairs(4).map(wide));
            }
            for path in CIRCLES {
                arcs(path, setting, bits, every_arc(3).map(|arc| ArcInput { bits, ..arc }).step_by(5));
            }
        }
    }
}
