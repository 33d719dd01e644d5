//! The arguments of `why`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::{DontCare, ElaborationArgs, FormatArgs, ScenarioArgs};

/// `discreta why`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta why counter.v q --clock clk=10ns -s rst=0 --cycles 20
        runs as `run` does with the same options, and goes back from q at the end: the registers, their controls, lines of the
        source; for x to the register that nothing set, the net that nothing drives, or the division by zero
  discreta why circuits/evaluation/line.json f --at 95ns
        at another time
  discreta why counter.v 'q[3]' --expect golden.vcd
        driven as in a waveform that is right: goes back to the first net that differs from it, and names the lines that make it
  discreta why counter.v q --stimulus capture.vcd --at 2us
        in what another simulator recorded

Exit status: 0 told; 1 with --expect, it differs; 2 usage, input or output.")]
pub struct WhyArgs {
    /// The circuit, more files of it if it is Verilog, and the net, or bits of it, e.g. `u1.q`, `q[3]` or `q[7:4]`
    #[arg(value_name = "CIRCUIT|NET", required = true, num_args = 2.., value_hint = ValueHint::FilePath)]
    pub words: Vec<PathBuf>,

    /// Look at this time: ticks, or with a unit as in 5us; by default at the end, and with --expect where it first differs
    #[arg(long, value_name = "TIME")]
    pub at: Option<String>,

    /// Drive the inputs as in this waveform, VCD, FST or GHW, and look for the first net that differs from it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "stimulus")]
    pub expect: Option<PathBuf>,

    /// Drive each input, clocks too, as the net of its name in a waveform: VCD, FST or GHW
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub stimulus: Option<PathBuf>,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    #[arg(long, value_name = "PATH")]
    pub scope: Option<String>,

    /// Let this input, and not the clocks, change before all others of its time; may be given several times
    #[arg(long, value_name = "NET")]
    pub first: Vec<String>,

    /// Let x in A, or in B, agree with anything; otherwise x agrees only with x
    #[arg(long, value_name = "SIDE", requires = "expect")]
    pub ignore_x: Option<DontCare>,

    /// Go back this many steps at most; by default, 12 from a known value, and from x to where it comes from
    #[arg(long, value_name = "N")]
    pub steps: Option<usize>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// What happens to the circuit.
    #[command(flatten)]
    pub scenario: ScenarioArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}
