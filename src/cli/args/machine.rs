//! `discreta machine` as it is typed.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};

use crate::Timescale;
use crate::machine::clockwork::Rule;
use crate::machine::draw::Choice;
use crate::machine::program::Decimal;

/// How a program's measurement is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum MachineFormat {
    /// Tables for people.
    Table,
    /// JSON for programs.
    Json,
    /// Comma-separated values, a line for each block, method and feed.
    Csv,
    /// The program's canonical moves, as `rs274 -g` of LinuxCNC prints them.
    Canon,
}

/// `discreta machine`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta machine examples/part.nc
        all methods side by side
  discreta machine examples/part.nc --method ef-line-fast,ef-circle-fast --blu 0.005 --plot part.svg
        one of them, with steps of 5 µm, and a picture
  discreta machine examples/part.nc --format csv > blocks.csv
        every block
  discreta machine examples/part.nc --format canon
        the program as plain moves, without modes
  discreta machine examples/part.nc --method ef-line-fast,ef-circle-fast --feed block -o part.fst
        the pulses of the drives as a waveform
  discreta machine examples/part.nc --waveform capture.vcd --x STEP_X,DIR_X --y STEP_Y,!DIR_Y
        a capture of another machine or simulator, compared with the program

docs/machine.md lists the words that are read, and says what is measured.
Exit status: 0 done; 1 a capture is not what the program says; 2 usage, input or output.")]
pub struct MachineArgs {
    /// The part program (G-code), or - for standard input
    #[arg(value_name = "PROGRAM", value_hint = ValueHint::FilePath, required_unless_present = "waveform")]
    pub program: Option<PathBuf>,

    /// The methods of lines and of arcs, e.g. ef-line-fast,ef-circle-fast; may be given several times
    ///
    /// By default four pairs are compared.
    #[arg(long, value_name = "LINE,ARC")]
    pub method: Vec<Choice>,

    /// Begin F in the middle of its range, which halves the deviation
    #[arg(long)]
    pub centred: bool,

    /// The size of a step, mm
    ///
    /// By default 0.01.
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub blu: Option<Decimal>,

    /// Steps a millimetre: one number, or one for each axis
    #[arg(long, value_name = "X,Y,Z", value_parser = steps, conflicts_with = "blu")]
    pub steps_per_mm: Option<[Decimal; 3]>,

    /// How the feed sets the period of the clock: step, constant or block; may be given several times
    ///
    /// step: 1/V; constant: 1/V, and 1.41 or 1.73 times as long after a step of two or three axes; block: L/(V·N) for a
    /// block of length L that takes N clocks. By default, all three.
    #[arg(long, value_name = "RULE", value_parser = rule)]
    pub feed: Vec<Rule>,

    /// The speed of G0, mm/min
    #[arg(long, value_name = "MM_MIN", default_value = "5000", value_parser = positive)]
    pub rapid: Decimal,

    /// The tick of the clock that makes the pulses: 1, 10 or 100 of a unit
    #[arg(long, value_name = "TIME", default_value = "1us")]
    pub tick: Timescale,

    /// Bits of the registers; by default as few as the drawing needs, but at least 8
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u32).range(1..=32))]
    pub bits: Option<u32>,

    /// How different the radii at the start and at the end of an arc may be, mm (beyond 0.1 %); 0.0283 by default
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub arc_tolerance: Option<Decimal>,

    /// Leave out blocks that begin with /
    #[arg(long)]
    pub block_delete: bool,

    /// Print results for people or for programs
    #[arg(long, value_name = "FORMAT", default_value = "table")]
    pub format: MachineFormat,

    /// Draw the path, coloured by its deviation, and the speed along it (.svg), by the first method
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,

    /// Write the step and direction pulses as a waveform (.vcd, .fst), of the first method by the first rule of feed
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,

    /// Measure the step pulses in a waveform (VCD, FST or GHW), against the program if one is given
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub waveform: Option<PathBuf>,

    /// The nets of x in the waveform: step pulses and direction; ! before one inverts it; x_step,x_dir by default
    #[arg(long, value_name = "STEP,DIR", requires = "waveform", value_parser = step_dir)]
    pub x: Option<StepDir>,

    /// The nets of y
    #[arg(long, value_name = "STEP,DIR", requires = "waveform", value_parser = step_dir)]
    pub y: Option<StepDir>,

    /// The nets of z
    #[arg(long, value_name = "STEP,DIR", requires = "waveform", value_parser = step_dir)]
    pub z: Option<StepDir>,
}

/// A net, and whether it is to be inverted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Net {
    /// Its name.
    pub name: String,
    /// 0 means what 1 means elsewhere.
    pub inverted: bool,
}

/// The nets of an axis.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct StepDir {
    /// Its pulses: a step when it becomes 1.
    pub step: Net,
    /// Its direction: 1 is forwards.
    pub dir: Net,
}

fn step_dir(text: &str) -> Result<StepDir, String> {
    let net = |text: &str| {
        let name = text.trim();
        let bare = name.strip_prefix('!').unwrap_or(name).trim();
        (!bare.is_empty()).then(|| Net { name: bare.to_owned(), inverted: name.starts_with('!') })
    };
    match text.split_once(',').map(|(step, dir)| (net(step), net(dir))) {
        Some((Some(step), Some(dir))) => Ok(StepDir { step, dir }),
        _ => Err("write the net of the pulses and that of the direction: STEP,DIR".to_owned()),
    }
}

pub(super) fn positive(text: &str) -> Result<Decimal, String> {
    match text.parse::<Decimal>()? {
        value if value.signum() > 0 => Ok(value),
        _ => Err("it has to be above 0".to_owned()),
    }
}

fn steps(text: &str) -> Result<[Decimal; 3], String> {
    let all: Vec<Decimal> = text.split(',').map(positive).collect::<Result<_, _>>()?;
    match all[..] {
        [all] => Ok([all; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err("write one number, or three: X,Y,Z".to_owned()),
    }
}

fn rule(text: &str) -> Result<Rule, String> {
    Rule::ALL
        .into_iter()
        .find(|r| r.to_string() == text)
        .ok_or_else(|| format!("no feed is called '{text}'; there is step, constant, block"))
}
