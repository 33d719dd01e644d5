//! The arguments of `discreta draw`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::ElaborationArgs;

/// `discreta draw`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta draw discreta:evaluation/line -o line.svg
  discreta draw discreta:evaluation/line_gates --depth 1 -o line_gates.svg
        the instances of the top module are opened; those within them are boxes
  discreta draw discreta:evaluation/line_gates --module counter_gates -o counter.svg
        one module by itself
  discreta draw discreta:lib/arithmetic --top ripple_adder -p W=4 -o adder.svg

docs/drawing.md says how to read it, and what attributes it has for programs.
Exit status: 0 drawn; 2 a faulty circuit, one too large for a picture, usage, input or output.")]
pub struct DrawArgs {
    /// The circuit: a circuit file, Verilog, a netlist of Yosys (write_json), or a scenario that names one
    #[arg(value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: PathBuf,

    /// More files of the same design, if it is Verilog
    #[arg(value_name = "MORE", value_hint = ValueHint::FilePath)]
    pub more: Vec<PathBuf>,

    /// Go this many levels of modules and blocks down from the top
    ///
    /// Instances further down are boxes.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub depth: usize,

    /// Draw this module of the circuit instead of the top
    #[arg(long, value_name = "MODULE")]
    pub module: Option<String>,

    /// Write the picture to a file (.svg), or to standard output (-)
    #[arg(short, long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,
}
