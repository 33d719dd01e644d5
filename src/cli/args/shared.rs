//! Options that several commands share.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};

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
    /// The part before the first `=`.
    pub name: String,
    /// The part after it.
    pub value: String,
}

pub(super) fn assignment(text: &str) -> Result<Assignment, String> {
    // a name as Verilog escapes it may hold anything up to white space
    let split = match text.strip_prefix('\\') {
        Some(escaped) => escaped
            .split_once(char::is_whitespace)
            .and_then(|(name, rest)| Some((name, rest.trim_start().strip_prefix('=')?))),
        None => text.split_once('='),
    };
    match split {
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

pub(super) fn condition(text: &str) -> Result<Condition, String> {
    if let Some(net) = text.strip_prefix('\\').map(str::trim_end)
        && !net.is_empty()
        && !net.contains(char::is_whitespace)
    {
        return Ok(Condition { net: net.to_owned(), value: None });
    }
    if text.contains('=') {
        let Assignment { name, value } = assignment(text).map_err(|_| "write it as NET or NET=VALUE".to_owned())?;
        return Ok(Condition { net: name, value: Some(value) });
    }
    match text.trim() {
        "" => Err("write it as NET or NET=VALUE".to_owned()),
        net => Ok(Condition { net: net.to_owned(), value: None }),
    }
}

/// A clock: `NET=PERIOD[,high=TIME][,phase=TIME]`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ClockOption {
    /// The input.
    pub net: String,
    /// Its period.
    pub period: String,
    /// The time that it is 1 in each period.
    pub high: Option<String>,
    /// The time of its first rising edge.
    pub phase: Option<String>,
}

pub(super) fn clock(text: &str) -> Result<ClockOption, String> {
    let write = || "write it as NET=PERIOD, as in clk=10ns; `,high=TIME` and `,phase=TIME` may follow".to_owned();
    let Assignment { name, value } = assignment(text).map_err(|_| write())?;
    let mut parts = value.split(',').map(str::trim);
    let period = parts.next().filter(|p| !p.is_empty()).ok_or_else(write)?.to_owned();
    let mut option = ClockOption { net: name, period, high: None, phase: None };
    for part in parts {
        let (what, value) = part.split_once('=').ok_or_else(write)?;
        let to = match what.trim() {
            "high" => &mut option.high,
            "phase" => &mut option.phase,
            _ => return Err(write()),
        };
        if value.trim().is_empty() || to.replace(value.trim().to_owned()).is_some() {
            return Err(write());
        }
    }
    Ok(option)
}

/// A reset: `NET=TIME[,low]`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ResetOption {
    /// The input.
    pub net: String,
    /// The time at which it ends.
    pub time: String,
    /// Whether it is active at 0.
    pub low: bool,
}

pub(super) fn reset(text: &str) -> Result<ResetOption, String> {
    let write = || "write it as NET=TIME, as in rst=20ns; `,low` may follow".to_owned();
    let Assignment { name, value } = assignment(text).map_err(|_| write())?;
    let (time, low) = match value.split_once(',') {
        Some((time, low)) if low.trim() == "low" => (time.trim().to_owned(), true),
        Some(_) => return Err(write()),
        None => (value, false),
    };
    if time.is_empty() { Err(write()) } else { Ok(ResetOption { net: name, time, low }) }
}

/// Options that decide which netlist a circuit file becomes.
#[derive(Args, Debug, Clone)]
pub struct ElaborationArgs {
    /// Set a parameter of the top module; may be given several times
    #[arg(short, visible_short_alias = 'G', long = "parameter", value_name = "NAME=VALUE", value_parser = assignment)]
    pub parameter: Vec<Assignment>,

    /// Take this module of the file as the top
    #[arg(long, value_name = "MODULE")]
    pub top: Option<String>,

    /// Look in this folder for files that Verilog includes; may be given several times
    #[arg(short = 'I', long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub include: Vec<PathBuf>,

    /// Define a macro of Verilog; may be given several times
    #[arg(short = 'D', long, value_name = "NAME[=VALUE]")]
    pub define: Vec<String>,

    /// Leave out what is in this module of Verilog or of a netlist: what it drives is x; may be given several times
    #[arg(long, value_name = "MODULE")]
    pub blackbox: Vec<String>,

    /// Fill a memory from a file as $readmemh does, e.g. cpu.ram=program.hex; may be given several times
    #[arg(long, value_name = "NAME=FILE", value_parser = assignment)]
    pub memory: Vec<Assignment>,

    /// Raise a limit, e.g. width=100000; may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub limit: Vec<Assignment>,
}

/// Which engine runs the circuit: a choice of speed, never of result.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum EngineChoice {
    /// The event engine at first, then machine code if the run turns out to be long.
    Auto,
    /// The reference: computes what has changed, cell by cell.
    Event,
    /// Machine code made for the circuit; an error if it cannot be compiled (see docs/engines.md).
    #[cfg(feature = "compiled")]
    Compiled,
}

/// What to do when an x reaches the clock, set, reset or enable of a storage cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum XControl {
    /// Warn, once for each cell.
    Warn,
    /// Stop the run.
    Error,
    /// Do nothing.
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

/// The side of a comparison on which x agrees with anything.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum DontCare {
    /// The first waveform.
    A,
    /// The second waveform.
    B,
}

/// A waveform that drives the inputs.
#[derive(Args, Debug, Clone)]
pub struct WaveArgs {
    /// Drive each input, clocks too, as the net of its name in a waveform: VCD, FST or GHW
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub stimulus: Option<PathBuf>,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    ///
    /// By default, the scope that has its inputs.
    #[arg(long, value_name = "PATH", requires = "stimulus")]
    pub scope: Option<String>,

    /// Compare the outputs and every named net with the waveform
    #[arg(long, requires = "stimulus")]
    pub expect: bool,

    /// Do not compare nets that match, e.g. 'cache.**'; may be given several times
    #[arg(long, value_name = "GLOB", requires = "expect")]
    pub ignore: Vec<String>,

    /// Let x in A, or in B, agree with anything; otherwise x agrees only with x
    #[arg(long, value_name = "SIDE", requires = "expect")]
    pub ignore_x: Option<DontCare>,

    /// Let this input, and not the clocks, change before all others of its time; may be given several times
    #[arg(long, value_name = "NET", requires = "stimulus")]
    pub first: Vec<String>,
}

/// Options that change a scenario.
#[derive(Args, Debug, Clone, PartialEq, Eq, Default)]
pub struct ScenarioArgs {
    /// Hold an input at a value for the whole run, whatever the circuit's own stimulus says; may be given several times
    #[arg(short, long = "set", value_name = "NET=VALUE", value_parser = assignment)]
    pub set: Vec<Assignment>,

    /// Make an input a clock, e.g. clk=10ns or clk=20ns,high=5ns,phase=0, whatever the circuit's own stimulus says; may be
    /// given several times
    #[arg(long, value_name = "NET=PERIOD", value_parser = clock)]
    pub clock: Vec<ClockOption>,

    /// Hold an input at 1 from the start to this time, then at 0; with `,low` the other way round: rst_n=20ns,low; may be
    /// given several times
    #[arg(long, value_name = "NET=TIME", value_parser = reset)]
    pub reset: Vec<ResetOption>,

    /// Stop after this many periods of the first clock
    #[arg(long, value_name = "N", conflicts_with = "time")]
    pub cycles: Option<u64>,

    /// Stop at this time: ticks, or with a unit as in 5us
    #[arg(long, value_name = "TIME")]
    pub time: Option<String>,

    /// Stop when a net has a value; without one, when it is 1
    #[arg(long, value_name = "NET[=VALUE]", value_parser = condition)]
    pub until: Option<Condition>,
}
