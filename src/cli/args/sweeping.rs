//! The arguments of `discreta sweep`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::drawing::methods;
use super::{ElaborationArgs, ScenarioArgs};
use crate::interpolate::Method;
use crate::sweep::{Over, Shard};

/// `discreta sweep`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta sweep discreta:evaluation/line --over dx=0..255 --over dy=0..255 -o lines.csv
        the circuit's own scenario for each of the 65,536 pairs; a row for each, with the last values of the outputs
  discreta sweep discreta:evaluation/line --over dx=0..255 --over dy=0..255 --against ef-line -o lines.csv
        each run is also compared with the algorithm on every clock; for the first that differs, a command that repeats it
  discreta sweep discreta:evaluation/line -p W=16 --over dx=0..65535 --over dy=0..65535 --sample 10000
        10,000 pairs chosen at random, always the same ones for the same --seed
  discreta sweep line.json --over dx=0..255 --over dy=0..255 --shard 3/8 -o part3.csv
  discreta sweep --join part*.csv -o lines.csv
        the third of eight parts; then all parts together

The input named last changes fastest. docs/sweep.md says what the columns are.
Exit status: 0 every run stopped as asked; 1 some did not, or differ, or it was interrupted; 2 usage, input or output.")]
pub struct SweepArgs {
    /// The circuit: a circuit file, Verilog, a netlist of Yosys (write_json), or a scenario that names one
    #[arg(value_name = "CIRCUIT", value_hint = ValueHint::FilePath, required_unless_present = "join")]
    pub circuit: Option<PathBuf>,

    /// More files of the same design, if it is Verilog
    #[arg(value_name = "MORE", value_hint = ValueHint::FilePath)]
    pub more: Vec<PathBuf>,

    /// Give an input each of these values: A..B, A..B..STEP or A,B,C; with several inputs, run every combination
    #[arg(long, value_name = "NET=A..B", value_parser = over, required_unless_present = "join")]
    pub over: Vec<Over>,

    /// Compare every run with this method on every clock
    #[arg(long, value_name = "METHOD", value_parser = methods())]
    pub against: Option<Method>,

    /// Take only N, chosen at random
    ///
    /// Of the combinations of values.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub sample: Option<u64>,

    /// The seed of the sample
    #[arg(long, value_name = "S", default_value_t = 1, requires = "sample")]
    pub seed: u64,

    /// Run only part I of N, from 1/N to N/N, to be joined afterwards
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,

    /// Put the parts of a sweep together
    #[arg(long, value_name = "PART", num_args = 1.., value_hint = ValueHint::FilePath,
          conflicts_with_all = ["circuit", "over", "against", "sample", "shard", "resume", "parameter", "top", "set", "clock",
                                "cycles", "time", "until", "show", "threads"])]
    pub join: Vec<PathBuf>,

    /// Write the rows to a file, .csv or .json; without it, to standard output as CSV
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,

    /// Go on where an interrupted sweep with the same output stopped
    #[arg(long, requires = "output")]
    pub resume: bool,

    /// Show the last values of nets that match, e.g. 'adder.*' or '**.q', instead of those of the outputs
    #[arg(long, value_name = "GLOB")]
    pub show: Vec<String>,

    /// Use N threads; 0: one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// What happens to the circuit in each run.
    #[command(flatten)]
    pub scenario: ScenarioArgs,

    /// Say more: every output, warnings in full, and which engine ran
    #[arg(short, long)]
    pub verbose: bool,
}

fn over(text: &str) -> Result<Over, String> {
    text.parse()
}

fn shard(text: &str) -> Result<Shard, String> {
    text.parse()
}
