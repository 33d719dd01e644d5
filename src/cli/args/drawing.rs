//! The arguments of the commands that draw without a circuit: `interpolate`, `plot`, `compare`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};

use crate::interpolate::{Method, Side};
use crate::machine::program::Decimal;

/// A point in BLU.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Point {
    /// Along x.
    pub x: i64,
    /// Along y.
    pub y: i64,
    /// Along z; `None` in the plane.
    pub z: Option<i64>,
}

pub(super) fn point(text: &str) -> Result<Point, String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y]) => Ok(Point { x, y, z: None }),
        Some(&[x, y, z]) => Ok(Point { x, y, z: Some(z) }),
        _ => Err("write it as two whole numbers, X,Y, or three in space, X,Y,Z".to_owned()),
    }
}

/// A centre: the nearest point of the grid, and how far from it, BLU.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Center {
    /// The nearest point.
    pub whole: [i64; 2],
    /// The rest.
    pub rest: [f64; 2],
}

impl Center {
    /// Where it is.
    #[must_use]
    pub fn exact(&self) -> [f64; 2] {
        [0, 1].map(|a| self.whole[a] as f64 + self.rest[a])
    }
}

fn center(text: &str) -> Result<Center, String> {
    let write = || "write it as two numbers, X,Y".to_owned();
    let numbers: Vec<&str> = text.split(',').map(str::trim).collect();
    let [x, y] = numbers[..] else { return Err(write()) };
    let (mut whole, mut rest) = ([0; 2], [0.0; 2]);
    for (axis, text) in [x, y].into_iter().enumerate() {
        // whole numbers of any size as they are
        if let Ok(number) = text.parse() {
            whole[axis] = number;
            continue;
        }
        let number: Decimal = text.parse().map_err(|_| write())?;
        let near = number.round().to_whole().ok_or_else(write)?;
        (whole[axis], rest[axis]) = (near, (number - Decimal::whole(near)).to_f64());
    }
    Ok(Center { whole, rest })
}

fn conic(text: &str) -> Result<[i64; 6], String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "write it as six whole numbers, A,B,C,D,E,F".to_owned())
}

/// How an interpolation is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum StepsFormat {
    /// A table for people.
    Table,
    /// Comma-separated values with a header.
    Csv,
    /// JSON, one clock a line.
    Json,
    /// One letter a clock, on one line.
    Steps,
}

/// The options of a method: what to draw, from where to where, and how.
#[derive(Args, Debug, Clone, Default)]
pub struct DrawingArgs {
    /// Where to go, in BLU: X,Y, or X,Y,Z in space
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub to: Option<Point>,

    /// Where to begin, in BLU; lines begin at the origin by default
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub from: Option<Point>,

    /// The centre of an arc, in BLU, which may lie between the points of the grid; the origin by default
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = center)]
    pub center: Option<Center>,

    /// F at the start point of an arc, xs² + ys² − R², if it does not lie on the circle
    #[arg(long, value_name = "F0", allow_hyphen_values = true)]
    pub f0: Option<i64>,

    /// An arc goes counter-clockwise, which is the default
    #[arg(long, conflicts_with = "cw")]
    pub ccw: bool,

    /// An arc goes clockwise
    #[arg(long)]
    pub cw: bool,

    /// The curve A·x² + B·xy + C·y² + D·x + E·y + F = 0
    #[arg(long, value_name = "A,B,C,D,E,F", allow_hyphen_values = true, value_parser = conic)]
    pub conic: Option<[i64; 6]>,

    /// Draw the path of the centre of a tool with this radius, in BLU, beside the line or arc
    #[arg(long, value_name = "R", requires = "side")]
    pub offset: Option<u32>,

    /// The side of the tool, left or right, seen in the direction of its travel
    #[arg(long, value_name = "SIDE", requires = "offset")]
    pub side: Option<Side>,

    /// Bits of the registers; by default as few as the drawing needs, but at least 8
    #[arg(long, value_name = "P")]
    pub bits: Option<u32>,

    /// Preload the accumulators of a DDA with half of their range
    #[arg(long)]
    pub half_preload: bool,

    /// Let both axes of a DDA use the coordinates before the clock, as hardware does
    #[arg(long)]
    pub parallel: bool,

    /// Shift what a DDA adds to the left until a top bit is set, so that it takes fewer clocks
    #[arg(long)]
    pub normalise: bool,

    /// Begin F in the middle of its range, which halves the deviation
    #[arg(long)]
    pub centred: bool,

    /// Follow the source to the letter, misprints included
    #[arg(long)]
    pub as_printed: bool,
}

/// `discreta interpolate`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta interpolate ef-line --to 5,3
  discreta interpolate ef-line --to 5,3 --format steps
        XYXYXXYX
  discreta interpolate ef-circle --from 5,0 --to 0,5 --format csv

A step is X, Y or Z along one axis; D along x and y, E along x and z, F along y and z; A along all three; - none.
docs/interpolators.md describes every method, docs/drawing.md what each format prints.
Exit status: 0 the end was reached; 1 it was not; 2 usage, input or output.")]
pub struct InterpolateArgs {
    /// The method
    #[arg(value_name = "METHOD", value_parser = methods())]
    pub method: Method,

    /// What to draw.
    #[command(flatten)]
    pub drawing: DrawingArgs,

    /// Print results for people or for programs
    #[arg(long, value_name = "FORMAT", default_value = "table")]
    pub format: StepsFormat,
}

/// The names of the methods, each with what it is.
pub(super) fn methods() -> impl TypedValueParser<Value = Method> {
    let names = Method::ALL.iter().map(|m| PossibleValue::new(m.name()).help(m.about()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Method>())
}

/// `discreta plot`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta plot ef-line --to 5,3 -o line.svg
  discreta plot dda-circle --from 100,0 --to 0,100 --half-preload -o circle.svg
  discreta plot traces/evaluation/line_5_3.vcd -o trace.svg
        the path of the nets xt and yt, clocked by dt, over the line from its first point to its last
  discreta plot arc.vcd --center 0,0 --cw -o arc.svg
        the same over a clockwise arc around the origin

The picture is SVG: above, the path over the ideal curve; below, the distance between them after each clock.
Exit status: 0 drawn; 1 drawn, but the end was not reached; 2 usage, input or output.")]
pub struct PlotArgs {
    /// A method, or a waveform: VCD, FST or GHW
    #[arg(value_name = "METHOD|WAVEFORM", value_hint = ValueHint::AnyPath)]
    pub what: String,

    /// What to draw, or what to compare a waveform with.
    #[command(flatten)]
    pub drawing: DrawingArgs,

    /// Write the picture to a file (.svg), or to standard output (-)
    #[arg(short, long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    #[arg(long, value_name = "PATH")]
    pub scope: Option<String>,

    /// The circuit of the waveform, for names of values and for which numbers are signed
    #[arg(long, value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: Option<PathBuf>,

    /// The nets of the path in a waveform.
    #[command(flatten)]
    pub coordinates: CoordinateArgs,
}

/// The nets of a waveform that make the path.
#[derive(Args, Debug, Clone, Default)]
pub struct CoordinateArgs {
    /// The net of the x coordinate in a waveform; xt by default
    #[arg(long, value_name = "NET")]
    pub x: Option<String>,

    /// The net of the y coordinate in a waveform; yt by default
    #[arg(long, value_name = "NET")]
    pub y: Option<String>,

    /// The net of the z coordinate in a waveform, if it has one
    #[arg(long, value_name = "NET")]
    pub z: Option<String>,

    /// The net of the feed clock in a waveform; dt by default
    #[arg(long, value_name = "NET")]
    pub dt: Option<String>,

    /// The coordinates in a waveform are two's complement; without this option, the path tells
    #[arg(long)]
    pub signed: bool,
}

/// How a comparison is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum CompareFormat {
    /// For people.
    Text,
    /// For programs: JSON.
    Json,
    /// A page of documentation, as docs/comparison.md.
    Markdown,
}

/// `discreta compare`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta compare
        every line and quarter circle of 8 bits
  discreta compare --bits 16 --sample 200
        200 segments of each kind, with 16 bits
  discreta compare --format markdown > docs/comparison.md",
    after_long_help = format!("\
Examples:
  discreta compare
        every line and quarter circle of 8 bits
  discreta compare --bits 16 --sample 200
        200 segments of each kind, with 16 bits
  discreta compare --format markdown > docs/comparison.md

Measures:
{}
Exit status: 0 measured, whatever the claims; 2 usage, input or output.", crate::cli::compare::measures()))]
pub struct CompareArgs {
    /// Bits of the registers, in the algorithms and in the circuits
    #[arg(long, value_name = "P", default_value_t = 8)]
    pub bits: u32,

    /// Take only N, chosen at random
    ///
    /// Of each kind of segment.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub sample: Option<u64>,

    /// The seed of the sample
    #[arg(long, value_name = "S", default_value_t = 1, requires = "sample")]
    pub seed: u64,

    /// The folder of the circuits
    #[arg(long, value_name = "DIR", default_value = "circuits", value_hint = ValueHint::DirPath)]
    pub circuits: PathBuf,

    /// Print results for people or for programs
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: CompareFormat,
}
