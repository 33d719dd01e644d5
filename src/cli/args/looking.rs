//! What may be said to the commands by which people look at a waveform: `wave`, `view`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::wave::text::Radix;

/// `discreta wave`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta wave line.vcd
        the signals of the top module
  discreta wave line.vcd --signals dt --signals '?t' --signals f --signed f --from 20ns --to 100ns
        some of them in this order, f in two's complement, a window of time
  discreta wave cpu.fst --signals 'cpu.alu.**' --ascii --width 80
        all below a scope, for a log

Names are matched in full (line.f) or from below the top module (f); `*` stays in a scope, `**` crosses them.
Exit status: 0 printed; 2 a file cannot be read, or usage.")]
pub struct WaveTextArgs {
    /// The waveform: VCD, FST or GHW
    #[arg(value_name = "WAVEFORM", value_hint = ValueHint::FilePath)]
    pub waveform: PathBuf,

    /// Show signals that match, in the order of the options; may be given several times
    #[arg(short, long, value_name = "GLOB")]
    pub signals: Vec<String>,

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

    /// Characters of a line; by default those of the terminal, or 100
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(20..))]
    pub width: Option<u16>,

    /// Draw with ASCII characters alone
    #[arg(long)]
    pub ascii: bool,
}
