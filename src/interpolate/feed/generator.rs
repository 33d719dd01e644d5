//! The programmable generator of Δt: whole ticks, a fraction carried over, longer intervals after steps of several axes
//! and for normalising shifts.

use std::{error, fmt};

/// Bits of the fraction of a [`factor`].
const FACTOR_BITS: u32 = 8;

/// What the interval after a pulse is multiplied by, times 256: 1 for a step of one axis or none, 1.41 for two axes,
/// 1.73 for three, as «следващият интервал трябва да бъде 1,41 пъти по-дълъг … 1,73 пъти» has it.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::feed::factor;
/// assert_eq!([0, 1, 2, 3].map(|axes| factor(axes) as f64 / 256.0), [1.0, 1.0, 1.41015625, 1.73046875]);
/// ```
#[must_use]
pub const fn factor(axes: usize) -> u64 {
    match axes {
        0 | 1 => 256,
        2 => 361,
        _ => 443,
    }
}

/// The generator of the speed block, one rising edge of its fast clock at a time.
///
/// Each interval is a whole number of ticks of that clock. What it falls short of the period is carried over, so pulse n
/// comes at the tick ⌊n·period⌋: the mean period is exact, the greatest jitter one tick.
///
/// A clock of a normalised DDA does the work of 2^s clocks and is due 2^s periods after the one before it: the interval is
/// `period·2^s·factor` plus what was carried over, all of it exact.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::feed::Generator;
/// // 5¼ ticks, as a number with 8 bits of fraction; pulses of 2 ticks
/// let mut generator = Generator::new(0x540, 8, 8, 2, false)?;
/// let rises: Vec<u64> = (1..=42).filter(|_| { let was = generator.dt(); generator.clock(true, 0, 0); generator.dt() && !was }).collect();
/// assert_eq!(rises, [5, 10, 15, 21, 26, 31, 36, 42]);
/// # Ok::<(), discreta::interpolate::feed::PeriodError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Generator {
    period: u64,
    /// Ones in the bits of the register that holds it.
    mask: u64,
    fraction_bits: u32,
    high: u64,
    constant: bool,
    /// Axes that stepped with the last pulse.
    stepped: usize,
    /// What the intervals so far were too short by, in 2^−(fraction_bits + 8) ticks.
    fraction: u64,
    /// Ticks since the last pulse began, counted from 1.
    elapsed: u64,
    dt: bool,
}

impl Generator {
    /// A generator as START leaves it: `period` ticks times 2^`fraction_bits`, of which the whole ticks have
    /// `whole_bits` bits; pulses `high` ticks long; `constant`: intervals after steps of several axes are longer.
    ///
    /// # Errors
    /// If the period does not fit its register, or is not above `high` and at least 2 ticks.
    pub fn new(
        period: u64,
        whole_bits: u32,
        fraction_bits: u32,
        high: u64,
        constant: bool,
    ) -> Result<Generator, PeriodError> {
        if !(2..=32).contains(&whole_bits) || !(1..=24).contains(&fraction_bits) {
            return Err(PeriodError::Bits { whole_bits, fraction_bits });
        }
        let most = (1 << (whole_bits + fraction_bits)) - 1;
        let least = (high + 1).max(2);
        if high == 0 || least > most >> fraction_bits {
            return Err(PeriodError::High { high, most: (most >> fraction_bits) - 1 });
        }
        if !(least << fraction_bits..=most).contains(&period) {
            return Err(PeriodError::Period { period, least: least << fraction_bits, most });
        }
        let (stepped, fraction, elapsed) = (0, 0, 1);
        Ok(Generator { period, mask: most, fraction_bits, high, constant, stepped, fraction, elapsed, dt: false })
    }

    /// Whether the period still fits its register after as many normalising shifts as may come.
    ///
    /// # Errors
    /// If it does not: what passes the top of the register would be lost.
    pub fn check_shifts(&self, most: u32) -> Result<(), PeriodError> {
        if most > self.period.leading_zeros() || self.period << most > self.mask {
            return Err(PeriodError::Shifted { period: self.period, shifts: most, most: self.mask });
        }
        Ok(())
    }

    /// The next interval, in ticks: the period times the factor of `axes` axes and 2^`shifts`, and what was carried over.
    /// What it is too short by is carried over in turn.
    pub fn interval(&mut self, axes: usize, shifts: u32) -> u64 {
        let (interval, fraction) = self.ahead(axes, shifts);
        self.fraction = fraction;
        interval
    }

    fn ahead(&self, axes: usize, shifts: u32) -> (u64, u64) {
        let bits = self.fraction_bits + FACTOR_BITS;
        let factor = factor(if self.constant { axes } else { 0 });
        // in the register, see `check_shifts`
        let scaled = self.period.checked_shl(shifts).unwrap_or(0) & self.mask;
        // at most 56 bits times 9
        let total = u128::from(scaled) * u128::from(factor) + u128::from(self.fraction);
        ((total >> bits) as u64, (total & ((1 << bits) - 1)) as u64)
    }

    /// One rising edge of the fast clock: without `enable` the next pulse waits; `axes` is how many step pulses are high,
    /// `shifts` by how many bits the next pulse's addends are shifted.
    pub fn clock(&mut self, enable: bool, axes: usize, shifts: u32) {
        let due = self.elapsed >= self.ahead(self.stepped, shifts).0;
        let fire = due && enable;
        let over = self.elapsed >= self.high;
        if fire {
            self.interval(self.stepped, shifts);
        }
        if self.dt {
            self.stepped = axes;
        }
        self.elapsed = if fire { 1 } else { self.elapsed + u64::from(!due) };
        self.dt = fire || self.dt && !over;
    }

    /// Δt, the output.
    #[must_use]
    pub const fn dt(&self) -> bool {
        self.dt
    }

    /// What is carried over, in 2^−(fraction_bits + 8) ticks.
    #[must_use]
    pub const fn fraction(&self) -> u64 {
        self.fraction
    }

    /// Ticks since the last pulse began, counted from 1.
    #[must_use]
    pub const fn elapsed(&self) -> u64 {
        self.elapsed
    }
}

/// Why a [`Generator`] does not take its settings.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum PeriodError {
    /// The register of the period cannot be that wide.
    Bits {
        /// Bits of its whole ticks.
        whole_bits: u32,
        /// Bits of its fraction.
        fraction_bits: u32,
    },
    /// A pulse is 0 ticks long, or longer than any period.
    High {
        /// Its ticks.
        high: u64,
        /// The most it may have.
        most: u64,
    },
    /// The period is out of its range; all three times 2^fraction_bits.
    Period {
        /// The period.
        period: u64,
        /// The least it may be.
        least: u64,
        /// The most it may be.
        most: u64,
    },
    /// The period does not fit its register after normalising shifts; both times 2^fraction_bits.
    Shifted {
        /// The period.
        period: u64,
        /// The shifts.
        shifts: u32,
        /// The most that the register holds.
        most: u64,
    },
}

impl fmt::Display for PeriodError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            PeriodError::Bits { whole_bits, fraction_bits } => write!(
                f,
                "a period of {whole_bits} bits and {fraction_bits} of fraction: there may be 2 to 32, and 1 to 24"
            ),
            PeriodError::High { high, most } => write!(f, "pulses of {high} ticks: they may have 1 to {most}"),
            PeriodError::Period { period, least, most } => {
                write!(f, "a period of {period} is outside {least}..{most}, in parts of a tick")
            }
            PeriodError::Shifted { period, shifts, most } => {
                write!(f, "a period of {period} after {shifts} shifts is above {most}, in parts of a tick")
            }
        }
    }
}

impl error::Error for PeriodError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks at which Δt rises.
    fn rises(mut generator: Generator, ticks: u64, axes: usize) -> Vec<u64> {
        let mut rises = Vec::new();
        for tick in 1..=ticks {
            let was = generator.dt();
            generator.clock(true, axes, 0);
            if generator.dt() && !was {
                rises.push(tick);
            }
        }
        rises
    }

    #[test]
    fn pulse_n_comes_at_the_floor_of_n_periods() {
        // every fraction of 6 bits, and far enough for all of them to come round
        for period in (3 << 6)..(5 << 6) {
            let generator = Generator::new(period, 4, 6, 1, false).unwrap();
            let rises = rises(generator, 1000, 3);
            let exact: Vec<u64> = (1..).map(|n| (n * period) >> 6).take_while(|&t| t <= 1000).collect();
            assert_eq!(rises, exact, "period {period}/64");
        }
    }

    #[test]
    fn intervals_after_steps_of_several_axes_are_longer_and_exact_on_the_average() {
        for (axes, times) in [(1, 1.0), (2, 361.0 / 256.0), (3, 443.0 / 256.0)] {
            let period = 1234_u64; // 4.8203125 ticks
            let rises = rises(Generator::new(period, 8, 8, 2, true).unwrap(), 100_000, axes);
            let interval = period as f64 / 256.0 * times;
            for (n, &at) in rises.iter().enumerate() {
                // the first interval comes before any step
                let exact = period as f64 / 256.0 + n as f64 * interval;
                assert_eq!(at, exact.floor() as u64, "{axes} axes, pulse {n}");
            }
        }
    }

    /// A pulse of s shifts is worth 2^s periods, and only those of the pulse before it that two axes stepped with are
    /// longer: pulse n comes at the floor of the sum.
    #[test]
    fn normalised_intervals_are_exact_on_the_average() {
        let period = 777_u64; // 3.03515625 ticks
        let mut generator = Generator::new(period, 8, 8, 2, true).unwrap();
        assert_eq!(generator.check_shifts(4), Ok(()));
        let (mut at, mut exact, mut axes) = (0, 0.0, 0);
        for n in 0_u32..10_000 {
            let shifts = n * n % 5;
            at += generator.interval(axes, shifts);
            exact += period as f64 / 256.0 * f64::from(1 << shifts) * [1.0, 1.0, 361.0 / 256.0][axes];
            assert_eq!(at, exact.floor() as u64, "pulse {n}");
            axes = (n % 3) as usize;
        }
    }

    #[test]
    fn a_disabled_generator_waits_and_then_goes_on() {
        let mut generator = Generator::new(5 << 8, 8, 8, 2, false).unwrap();
        for _ in 0..50 {
            generator.clock(false, 0, 0);
            assert!(!generator.dt());
        }
        let mut levels = String::new();
        for _ in 0..12 {
            generator.clock(true, 0, 0);
            levels.push(if generator.dt() { '1' } else { '0' });
        }
        assert_eq!(levels, "110001100011");
    }

    #[test]
    fn what_it_cannot_make_is_refused_with_the_limit() {
        let refused = |period, whole, fraction, high| {
            Generator::new(period, whole, fraction, high, true).unwrap_err().to_string()
        };
        assert_eq!(refused(1 << 8, 8, 8, 1), "a period of 256 is outside 512..65535, in parts of a tick");
        assert_eq!(refused(65536, 8, 8, 1), "a period of 65536 is outside 512..65535, in parts of a tick");
        assert_eq!(refused(1024, 8, 8, 4), "a period of 1024 is outside 1280..65535, in parts of a tick");
        assert_eq!(refused(1024, 8, 8, 0), "pulses of 0 ticks: they may have 1 to 254");
        assert_eq!(refused(1024, 8, 8, 255), "pulses of 255 ticks: they may have 1 to 254");
        let shifted = |most| Generator::new(1024, 8, 8, 2, true).unwrap().check_shifts(most).map_err(|e| e.to_string());
        assert_eq!(shifted(5), Ok(()));
        for most in [6, 63, 64, u32::MAX] {
            let told = format!("a period of 1024 after {most} shifts is above 65535, in parts of a tick");
            assert_eq!(shifted(most), Err(told));
        }
        assert_eq!(refused(1024, 33, 8, 1), "a period of 33 bits and 8 of fraction: there may be 2 to 32, and 1 to 24");
    }
}
