//! The arguments of the commands that show a waveform: `wave`, `view`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::drawing::{CoordinateArgs, Point, point};
use super::{ElaborationArgs, EngineArgs, ScenarioArgs};
use crate::wave::text::Radix;

/// `discreta wave`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta wave line.vcd
        the signals of the top module
  discreta wave line.vcd --signals dt --signals '?t' --signals f --signed f --from 20ns --to 100ns
        some of them in this order, f in two's complement, between two times
  discreta wave circle.vcd --circuit circuits/quadrant/circle.json --signals '**.quadrant'
        with the circuit's names of values
  discreta wave cpu.fst --signals 'cpu.alu.**' --ascii --width 80
        everything below a scope, for a log

Names are matched in full (line.f) or from below the top module (f); `*` stays in a scope, `**` crosses them.
Exit status: 0 printed; 2 a file cannot be read, or only as far as it goes, or usage.")]
pub struct WaveTextArgs {
    /// The waveform: VCD, FST or GHW
    #[arg(value_name = "WAVEFORM", value_hint = ValueHint::FilePath)]
    pub waveform: PathBuf,

    /// Show signals that match, in the order of the options; may be given several times
    #[arg(short, long, value_name = "GLOB")]
    pub signals: Vec<String>,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    #[arg(long, value_name = "PATH")]
    pub scope: Option<String>,

    /// Begin at this time: ticks, or with a unit as in 5us
    #[arg(long, value_name = "TIME")]
    pub from: Option<String>,

    /// End at this time
    #[arg(long, value_name = "TIME")]
    pub to: Option<String>,

    /// Write numbers as bin, dec, signed or hex; auto is dec up to 16 bits, and hex above
    #[arg(long, value_name = "RADIX", default_value = "auto")]
    pub radix: Radix,

    /// Write signals that match as signed numbers; may be given several times
    #[arg(long, value_name = "GLOB")]
    pub signed: Vec<String>,

    /// The circuit of the waveform, for names of values and for which numbers are signed
    #[arg(long, value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: Option<PathBuf>,

    /// Characters of a line; by default those of the terminal, or 100
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(20..))]
    pub width: Option<u16>,

    /// Draw with ASCII characters only
    #[arg(long)]
    pub ascii: bool,
}

/// `discreta view`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta view discreta:evaluation/line -s dx=9 -s dy=5 -o line.html
        runs it as `run` does; open line.html in a browser
  discreta view discreta:feed/system --depth 1 -o system.html
        with the modules of the schematic opened one level down
  discreta view cpu.fst -o cpu.html
        a waveform of any simulator

The page is one file and needs no network. In it, `?` lists the keys.
If the nets xt and yt (and zt) are coordinates that dt clocks, the page also shows their path.
Exit status: 0 made; 1 made, but the run hit its limit or an expectation failed; 2 usage, input or output.")]
pub struct ViewArgs {
    /// A circuit file, Verilog, a scenario or a netlist of Yosys to run, or a waveform: VCD, FST or GHW
    #[arg(value_name = "CIRCUIT|WAVEFORM", value_hint = ValueHint::FilePath)]
    pub what: PathBuf,

    /// More files of the same design, if it is Verilog
    #[arg(value_name = "MORE", value_hint = ValueHint::FilePath)]
    pub more: Vec<PathBuf>,

    /// Write the page to a file (.html), or to standard output (-)
    #[arg(short, long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    #[arg(long, value_name = "PATH")]
    pub scope: Option<String>,

    /// Go this many levels of modules and blocks down from the top
    ///
    /// In the schematic, instances further down are boxes.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub depth: usize,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// What happens to the circuit.
    #[command(flatten)]
    pub scenario: ScenarioArgs,

    /// Show only nets that match, e.g. 'adder.*' or '**.q'; may be given several times
    #[arg(long, value_name = "GLOB")]
    pub trace: Vec<String>,

    /// The engine and what it does about x.
    #[command(flatten)]
    pub engine: EngineArgs,

    /// The nets of the path.
    #[command(flatten)]
    pub coordinates: CoordinateArgs,

    /// Compare the path with an arc around this point, in BLU; without it, with the line or arc that fits its points
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub center: Option<Point>,

    /// The arc goes clockwise
    #[arg(long, requires = "center")]
    pub cw: bool,
}
