//! For which delays and periods the system of interpolator, synchronisers and speed block works.

use std::{error, fmt};

/// The times of `circuits/feed/system.json`, in ticks of the simulation.
///
/// A step pulse has to be over before the RC node rises (`high < tau`), the next may only come when it has risen
/// (`tau < step`), and after Δt only when it has fallen again: the interpolator's clock is stopped with Δt and starts at
/// the earliest `wait = hold·step + (step − high)` after it. Fallen below its threshold is not enough: what charge is left,
/// `v = e^(−wait/RC)`, makes the node rise sooner, in `RC·ln(2·(1 − v))`, and that has to be above `high` too. That a store
/// is filled again before the next Δt takes at most `(hold + 3)·step`.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::feed::Margins;
/// let margins = Margins { step: 20, high: 10, tau: 17, hold: 2, tick: 10, dt_high: 2 };
/// assert_eq!(margins.check(), Ok(()));
/// assert_eq!(margins.least_ticks(), 12); // 2 ticks high, 100 ns low
/// assert_eq!(
///     Margins { tau: 10, ..margins }.check().unwrap_err().to_string(),
///     "a delay of 10 is not above the step pulse, 10: one pulse may count twice"
/// );
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Margins {
    /// The period of the interpolator's clock.
    pub step: u64,
    /// How long it is high: the step pulse w.
    pub high: u64,
    /// The RC delay τ.
    pub tau: u64,
    /// Falling edges of the interpolator's clock that it stays stopped after Δt.
    pub hold: u64,
    /// The period of the speed block's clock.
    pub tick: u64,
    /// How many of these Δt is high.
    pub dt_high: u64,
}

impl Margins {
    /// The shortest time from the trailing edge of Δt to the next step.
    #[must_use]
    pub const fn least_wait(&self) -> u64 {
        self.hold.saturating_mul(self.step).saturating_add(self.step.saturating_sub(self.high))
    }

    /// The shortest period of Δt, in ticks of the speed block's clock, in which the interpolator fills a store again.
    #[must_use]
    pub const fn least_ticks(&self) -> u64 {
        let low = self.hold.saturating_add(3).saturating_mul(self.step);
        self.dt_high.saturating_add(low.div_ceil(if self.tick == 0 { 1 } else { self.tick }))
    }

    /// How long the RC node takes to rise after the shortest wait, when some charge is left.
    #[must_use]
    pub fn rise_again(&self) -> u64 {
        // the parts of the circuit: RC = 1.44 τ, so that a node at rest takes τ
        let rc = 1.44 * self.tau as f64;
        let left = libm::exp(-(self.least_wait() as f64) / rc);
        (rc * libm::log(2.0 * (1.0 - left))).ceil().max(0.0) as u64
    }

    /// Whether no step is lost or gained, at a period of Δt of [`least_ticks`](Margins::least_ticks) or more.
    ///
    /// # Errors
    /// The first margin that is not kept, with its limit.
    pub fn check(&self) -> Result<(), UnsafeMargin> {
        if self.tau <= self.high {
            Err(UnsafeMargin::Short { tau: self.tau, pulse: self.high })
        } else if self.tau >= self.step {
            Err(UnsafeMargin::Long { tau: self.tau, step: self.step })
        } else if self.least_wait() <= self.tau {
            Err(UnsafeMargin::Held { tau: self.tau, wait: self.least_wait() })
        } else if self.rise_again() <= self.high {
            Err(UnsafeMargin::Charged { rise: self.rise_again(), pulse: self.high })
        } else {
            Ok(())
        }
    }
}

/// Why a system may lose or gain steps. Times in ticks of the simulation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum UnsafeMargin {
    /// The RC node rises while the step pulse that fills the first flip-flop is still high.
    Short {
        /// The delay.
        tau: u64,
        /// The step pulse.
        pulse: u64,
    },
    /// The RC node may not have risen when the next step comes.
    Long {
        /// The delay.
        tau: u64,
        /// The period of the steps.
        step: u64,
    },
    /// The RC node may not have fallen when the first step after Δt comes.
    Held {
        /// The delay.
        tau: u64,
        /// The shortest time from Δt to a step.
        wait: u64,
    },
    /// The RC node has fallen, but still holds so much charge that it rises again within a step pulse.
    Charged {
        /// How soon it rises.
        rise: u64,
        /// The step pulse.
        pulse: u64,
    },
}

impl fmt::Display for UnsafeMargin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            UnsafeMargin::Short { tau, pulse } => {
                write!(f, "a delay of {tau} is not above the step pulse, {pulse}: one pulse may count twice")
            }
            UnsafeMargin::Long { tau, step } => {
                write!(f, "a delay of {tau} is not below the period of the steps, {step}: the second may be lost")
            }
            UnsafeMargin::Held { tau, wait } => {
                write!(f, "a step may come {wait} after Δt, not above the delay, {tau}: it may count twice")
            }
            UnsafeMargin::Charged { rise, pulse } => {
                write!(f, "charge is left after Δt: the RC node rises in {rise}, not above the step pulse, {pulse}")
            }
        }
    }
}

impl error::Error for UnsafeMargin {}
