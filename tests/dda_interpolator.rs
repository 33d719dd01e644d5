//! The interpolators by differential increments: the circuits of registers, the circuits of gates and the algorithms agree
//! on every clock.

mod support;

use discreta::circuit::Circuit;
use discreta::interpolate::{ArcInput, DdaCircle, DdaLine, Interpolator, LineInput, Options};
use support::Rng;
use support::bench::{Bench, circuit};

const LINES: [&str; 1] = ["circuits/dda/line.json"];
const CIRCLES: [&str; 1] = ["circuits/dda/circle.json"];

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
        circuit(path, &[("W", i64::from(bits)), ("HALF", half.into()), ("NORMALISE", normalise.into())])
    }

    fn circle(self, path: &str, bits: u32) -> Circuit {
        let Setting { half, parallel, clockwise, normalise } = self;
        let parameters = [
            ("W", i64::from(bits)),
            ("HALF", half.into()),
            ("PARALLEL", parallel.into()),
            ("CLOCKWISE", clockwise.into()),
            ("NORMALISE", normalise.into()),
        ];
        circuit(path, &parameters)
    }
}

/// Draws one after another and compares every clock; the clocks compared.
fn draw<I: Copy + std::fmt::Debug, A: Interpolator>(
    what: &str,
    circuit: &Circuit,
    inputs: impl Iterator<Item = I>,
    ports: impl Fn(I) -> [i64; 4],
    algorithm: impl Fn(I) -> A,
) -> u64 {
    let mut bench: Option<Bench<'_>> = None;
    for input in inputs {
        let mut algorithm = algorithm(input);
        let bench = bench.get_or_insert_with(|| Bench::new(circuit, algorithm.columns()));
        let mask = (1 << input_bits(circuit)) - 1;
        let names = ["xh", "yh", "dx", "dy"].map(|name| bench.input(name));
        let values: Vec<_> = names.into_iter().zip(ports(input).map(|v| (v & mask) as u64)).collect();
        bench.draw(&values, &mut algorithm).unwrap_or_else(|fault| panic!("{what}, {input:?}, {fault}"));
    }
    bench.map_or(0, |bench| bench.clocks)
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

#[test]
fn every_8_bit_line() {
    for setting in Setting::all().take(4) {
        let clocks = lines(LINES[0], setting, 8, every_line(8));
        println!("65536 lines of 8 bits, {setting:?}, {clocks} clocks");
    }
}

#[test]
fn every_8_bit_quarter_in_every_setting() {
    for path in CIRCLES {
        let clocks: u64 = Setting::all().map(|setting| arcs(path, setting, 8, quarters(8))).sum();
        println!("{path}: 255 quarters of 8 bits in 16 settings, {clocks} clocks");
    }
}
