//! The command line as it is typed: what may be said, and the help for it. Nothing is resolved here.
//!
//! What means the same in several commands is one struct that they share.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};

use crate::interpolate::{Method, Side};

/// `discreta`.
#[derive(Parser, Debug)]
#[command(
    name = "discreta",
    version,
    about = "Simulate digital circuits clock by clock",
    long_about = "Simulate digital circuits clock by clock.\n\n\
        A circuit is a JSON file of gates, flip-flops, registers and adders. Run it, look at the waveform in GTKWave \
        or Surfer, and pin it with golden traces.",
    after_help = "Examples:\n  \
        discreta run circuits/evaluation/line.json -s dx=5 -s dy=3 -o line.vcd\n  \
        discreta check my-circuit.json\n  \
        discreta test traces\n\n\
        Exit status: 0 done; 1 a comparison, expectation or check failed, or a run hit its limit; \
        2 usage, input or output.",
    disable_help_subcommand = true,
    max_term_width = 100
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Run a circuit, and write its waveform
    Run(RunArgs),
    /// Find every fault of circuit files
    Check(CheckArgs),
    /// Run scenarios, and compare them with their golden traces
    Test(TestArgs),
    /// Compare two waveforms: where they differ first, and what was around
    Diff(DiffArgs),
    /// Print what an interpolation algorithm does, step by step, without any circuit
    Interpolate(InterpolateArgs),
    /// Draw the path of a method or of a waveform over the ideal curve, as SVG
    Plot(PlotArgs),
    /// Count what circuits are made of, and how deep their logic is
    Stats(StatsArgs),
    /// Measure what the documents say of their methods
    Compare(CompareArgs),
    /// Print the JSON Schema of the files that you write, for your editor
    Schema(SchemaArgs),
    /// Print a script that completes this command line in your shell
    Completions(CompletionsArgs),
    /// Print the manual page
    Man(ManArgs),
}

/// How results are printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Format {
    /// For people.
    Text,
    /// For programs: JSON.
    Json,
}

/// `--format`, the same everywhere.
#[derive(Args, Debug, Clone)]
pub struct FormatArgs {
    /// Print results for people or for programs
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: Format,
}

/// `NAME=VALUE`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Assignment {
    /// What stands before the first `=`.
    pub name: String,
    /// What stands behind it.
    pub value: String,
}

fn assignment(text: &str) -> Result<Assignment, String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok(Assignment { name: name.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err("write it as NAME=VALUE".to_owned()),
    }
}

/// `NET` or `NET=VALUE`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Condition {
    /// The net.
    pub net: String,
    /// The value, if one was given.
    pub value: Option<String>,
}

fn condition(text: &str) -> Result<Condition, String> {
    if text.contains('=') {
        let Assignment { name, value } = assignment(text).map_err(|_| "write it as NET or NET=VALUE".to_owned())?;
        return Ok(Condition { net: name, value: Some(value) });
    }
    match text.trim() {
        "" => Err("write it as NET or NET=VALUE".to_owned()),
        net => Ok(Condition { net: net.to_owned(), value: None }),
    }
}

/// A point in BLU.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Point {
    /// Along x.
    pub x: i64,
    /// Along y.
    pub y: i64,
    /// Along z, for what is drawn in space.
    pub z: Option<i64>,
}

fn point(text: &str) -> Result<Point, String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y]) => Ok(Point { x, y, z: None }),
        Some(&[x, y, z]) => Ok(Point { x, y, z: Some(z) }),
        _ => Err("write it as two whole numbers, X,Y, or three in space, X,Y,Z".to_owned()),
    }
}

fn conic(text: &str) -> Result<[i64; 6], String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "write it as six whole numbers, A,B,C,D,E,F".to_owned())
}

/// What makes a netlist of a circuit file.
#[derive(Args, Debug, Clone)]
pub struct ElaborationArgs {
    /// Set a parameter of the top module; may be given several times
    #[arg(short, long = "parameter", value_name = "NAME=VALUE", value_parser = assignment)]
    pub parameter: Vec<Assignment>,

    /// Raise a limit, e.g. width=100000; may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub limit: Vec<Assignment>,
}

/// Which engine runs the circuit: a choice of speed, never of result.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum EngineChoice {
    /// The fastest that can run the circuit.
    Auto,
    /// The reference: every event, one by one.
    Event,
}

/// What is done about an x at the clock, set, reset or enable of a storage cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum XControl {
    /// Say so, once a cell.
    Warn,
    /// Stop the run.
    Error,
    /// Nothing.
    Ignore,
}

/// How a circuit is run.
#[derive(Args, Debug, Clone)]
pub struct EngineArgs {
    /// Choose the engine; the results are the same
    #[arg(long, value_name = "ENGINE", default_value = "auto")]
    pub engine: EngineChoice,

    /// What to do when an unknown value reaches a clock, set, reset or enable
    #[arg(long, value_name = "WHAT", default_value = "warn")]
    pub x_control: XControl,
}

/// `discreta run`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta run circuits/evaluation/line.json
        as the circuit's own scenario says; prints a summary
  discreta run circuits/evaluation/line.json -s dx=5 -s dy=3 -o line.vcd
        with these inputs; the waveform goes to line.vcd
  discreta run counter.json -p W=16 --cycles 100 --trace 'q' --trace 'stage[*].*' -o -
        100 clocks of a 16-bit counter; some nets, to standard output

Values are numbers (5, -1) or literals (4'b10x1, 8'hff).
Exit status: 0 stopped as asked; 1 a limit was hit first, or an expectation failed; 2 usage, input or output.")]
pub struct RunArgs {
    /// The circuit file, or a scenario that names one
    #[arg(value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: PathBuf,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// Hold an input at a value from the start; may be given several times
    #[arg(short, long = "set", value_name = "NET=VALUE", value_parser = assignment)]
    pub set: Vec<Assignment>,

    /// Stop after this many periods of the first clock
    #[arg(long, value_name = "N", conflicts_with = "time")]
    pub cycles: Option<u64>,

    /// Stop at this time: ticks, or with a unit as in 5us
    #[arg(long, value_name = "TIME")]
    pub time: Option<String>,

    /// Stop when a net has a value; without one, when it is 1
    #[arg(long, value_name = "NET[=VALUE]", value_parser = condition)]
    pub until: Option<Condition>,

    /// Write the waveform to a file (.vcd), or to standard output (-); may be given several times
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Vec<PathBuf>,

    /// Record only nets that match, e.g. 'adder.*' or '**.q'; may be given several times
    #[arg(long, value_name = "GLOB")]
    pub trace: Vec<String>,

    /// The engine and what it does about x.
    #[command(flatten)]
    pub engine: EngineArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,

    /// Say more: every output, warnings in full, times
    #[arg(short, long)]
    pub verbose: bool,
}

/// `discreta check`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta check my-circuit.json
  discreta check circuits/**/*.json --format json

Every fault is shown with its place and what to do, not only the first.
Exit status: 0 no errors (there may be warnings); 1 errors; 2 usage, input or output.")]
pub struct CheckArgs {
    /// Circuit files and scenarios
    #[arg(value_name = "CIRCUIT", required = true, value_hint = ValueHint::FilePath)]
    pub circuit: Vec<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}

/// `discreta test`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta test
        every scenario below traces/
  discreta test traces/evaluation/line_5_3.json
  discreta test --bless
        take the waveforms of this run as the golden ones; look at what changed before you commit them

Exit status: 0 all agree; 1 some differ or fail; 2 usage, input or output.")]
pub struct TestArgs {
    /// Scenarios, or directories to look for them in
    #[arg(value_name = "PATH", default_value = "traces", value_hint = ValueHint::AnyPath)]
    pub path: Vec<PathBuf>,

    /// Replace the golden traces that differ or are missing
    #[arg(long)]
    pub bless: bool,

    /// The engine and what it does about x.
    #[command(flatten)]
    pub engine: EngineArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}

/// The side of a comparison on which x agrees with anything.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum DontCare {
    /// The first waveform.
    A,
    /// The second waveform.
    B,
}

/// `discreta diff`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta diff line.vcd traces/evaluation/line_5_3.vcd
  discreta diff mine.vcd icarus.fst --ignore-end --ignore-x b

Signals are matched by their full names, and compared by the value that each has at the end of a tick.
Exit status: 0 the same; 1 different; 2 a file cannot be read, or usage.")]
pub struct DiffArgs {
    /// The first waveform: VCD, FST or GHW
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub a: PathBuf,

    /// The second waveform
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub b: PathBuf,

    /// Let x in one of the two agree with anything; otherwise x agrees only with x
    #[arg(long, value_name = "SIDE")]
    pub ignore_x: Option<DontCare>,

    /// Let one of the two end earlier
    #[arg(long)]
    pub ignore_end: bool,

    /// Show at most this many signals in each list
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub max: usize,

    /// Show this many changes before and after the first difference
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub context: u16,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
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

/// What is drawn, from where to where, and how: the options of a method.
#[derive(Args, Debug, Clone, Default)]
pub struct DrawingArgs {
    /// Where to go, in BLU: X,Y, or X,Y,Z in space
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub to: Option<Point>,

    /// Where to begin, in BLU; lines begin at the origin by default
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub from: Option<Point>,

    /// The centre of an arc, in BLU; the origin by default
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub center: Option<Point>,

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

    /// Bits of the registers; by default the fewest that do, but 8 at least
    #[arg(long, value_name = "P")]
    pub bits: Option<u32>,

    /// Preload the accumulators of a DDA with half of their volume
    #[arg(long)]
    pub half_preload: bool,

    /// Let both axes of a DDA use the coordinates from before the clock, as hardware does
    #[arg(long)]
    pub parallel: bool,

    /// Shift what a DDA adds to the left until a top bit is set, which takes fewer clocks
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

    /// Print a table, or something for programs
    #[arg(long, value_name = "FORMAT", default_value = "table")]
    pub format: StepsFormat,
}

/// The names of the methods, each with what it is.
fn methods() -> impl TypedValueParser<Value = Method> {
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

    /// What to draw, or what a waveform is to be compared with.
    #[command(flatten)]
    pub drawing: DrawingArgs,

    /// Write the picture to a file (.svg), or to standard output (-)
    #[arg(short, long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,

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
    pub clock: Option<String>,

    /// The coordinates in a waveform are two's complement
    #[arg(long)]
    pub signed: bool,
}

/// `discreta stats`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta stats circuits/evaluation/line.json circuits/evaluation/line_gates.json
  discreta stats circuits/evaluation/line_gates.json -p W=16 --depth 1
        with 16 bits, and what each part of the circuit takes
  discreta stats my-circuit.json --format json

docs/stats.md says what counts as what.
Exit status: 0 counted; 2 a faulty circuit, usage, input or output.")]
pub struct StatsArgs {
    /// Circuit files, or scenarios that name one
    #[arg(value_name = "CIRCUIT", required = true, value_hint = ValueHint::FilePath)]
    pub circuit: Vec<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// Count each module and block too, down to so many below the top
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub depth: u32,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
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
        200 of each kind, with 16 bits
  discreta compare --format markdown > docs/comparison.md",
    after_long_help = format!("\
Examples:
  discreta compare
        every line and quarter circle of 8 bits
  discreta compare --bits 16 --sample 200
        200 of each kind, with 16 bits
  discreta compare --format markdown > docs/comparison.md

Measures:
{}
Exit status: 0 measured, whatever the claims; 2 usage, input or output.", super::compare::measures()))]
pub struct CompareArgs {
    /// Bits of the registers that draw, and of the circuits
    #[arg(long, value_name = "P", default_value_t = 8)]
    pub bits: u32,

    /// Draw only so many segments of each kind, and not all of them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    pub sample: Option<u64>,

    /// Begin the pseudo-random choice of a sample here
    #[arg(long, value_name = "S", default_value_t = 1, requires = "sample")]
    pub seed: u64,

    /// The folder of the circuits
    #[arg(long, value_name = "DIR", default_value = "circuits", value_hint = ValueHint::DirPath)]
    pub circuits: PathBuf,

    /// Print results for people or for programs
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: CompareFormat,
}

/// What a schema is of.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum SchemaKind {
    /// A circuit file.
    Circuit,
    /// A scenario in a file of its own.
    Scenario,
}

/// `discreta schema`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta schema > circuit.schema.json
        name it in the circuit file: \"$schema\": \"circuit.schema.json\"
  discreta schema scenario")]
pub struct SchemaArgs {
    /// Of what
    #[arg(value_name = "OF", default_value = "circuit")]
    pub of: SchemaKind,
}

/// `discreta completions`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta completions bash > ~/.local/share/bash-completion/completions/discreta
  discreta completions fish > ~/.config/fish/completions/discreta.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// `discreta man`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta man | man -l -
  discreta man run > discreta-run.1")]
pub struct ManArgs {
    /// The command whose page it is; without one, that of the program
    #[arg(value_name = "COMMAND")]
    pub command: Option<String>,
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
