//! `discreta feed` as it is typed.

use clap::Args;

use super::FormatArgs;
use crate::machine::program::Decimal;

/// `discreta feed`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta feed
        the system as circuits/feed/system.json has it
  discreta feed --tau 8
        a delay that is shorter than the step pulse
  discreta feed --hold 4 --blu 0.01
        the greatest feed in mm/min too

docs/feed.md tells what the margins are. Times are in ns, as those of the circuit.
Exit status: 0 no step is lost or gained; 1 one may be; 2 usage, input or output.")]
pub struct FeedArgs {
    /// The period of the interpolator's clock (STEP)
    #[arg(long, value_name = "NS", default_value_t = 20, value_parser = time())]
    pub step: u64,

    /// How long it is high: the step pulse (STEP_HIGH)
    #[arg(long, value_name = "NS", default_value_t = 10, value_parser = time())]
    pub step_high: u64,

    /// The RC delay (TAU)
    #[arg(long, value_name = "NS", default_value_t = 17, value_parser = time())]
    pub tau: u64,

    /// Falling edges of the interpolator's clock that it stays stopped after dt (HOLD)
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    pub hold: u64,

    /// The period of the speed block's clock (TICK)
    #[arg(long, value_name = "NS", default_value_t = 10, value_parser = time())]
    pub tick: u64,

    /// Ticks of that clock that dt is high (HIGH)
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub high: u64,

    /// The size of a step, mm
    #[arg(long, value_name = "MM", value_parser = super::machine::positive)]
    pub blu: Option<Decimal>,

    /// How it is printed.
    #[command(flatten)]
    pub format: FormatArgs,
}

fn time() -> clap::builder::RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=1_000_000_000_000)
}
