//! The period of Δt from the commanded speed.

use std::{error, fmt};

/// A commanded speed, and the clock in whose ticks intervals are measured.
///
/// Document B computes `Δt = T / Nц = L / (V·2^p)` for a line of length L that a DDA of p bits draws in 2^p clocks. With s
/// normalising shifts it takes 2^(p−s), so `Δt = L·2^s / (V·2^p)`; a circle of radius R turns by 1 / 2^(p−s) radian a
/// clock, so `Δt = R·2^s / (V·2^p)`. An interpolator with an evaluation function steps with every Δt: `Δt = 1 / V`.
/// All are *inversely* proportional to V.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::feed::Speed;
/// // 1000 BLU a second, a clock of 1 MHz
/// let speed = Speed::new(1000.0, 1e-6)?;
/// assert_eq!(speed.step()?, 1000 << 8); // one step a millisecond
/// assert_eq!(speed.line(&[30, 40], 8, 0)?, 50_000); // 50 BLU in 50 ms and 256 clocks: 195.3125 ticks
/// # Ok::<(), discreta::interpolate::feed::SpeedError>(())
/// ```
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Speed {
    velocity: f64,
    tick: f64,
    whole_bits: u32,
    fraction_bits: u32,
    least: f64,
}

impl Speed {
    /// A speed of `velocity` BLU a second, for a generator whose clock has periods of `tick` seconds, with 32 bits of
    /// whole ticks, 8 of fraction, and intervals of 2 ticks or more.
    ///
    /// # Errors
    /// If either is not a finite number above 0.
    pub fn new(velocity: f64, tick: f64) -> Result<Speed, SpeedError> {
        if !(velocity.is_finite() && velocity > 0.0) {
            return Err(SpeedError::NotPositive { what: "speed", value: velocity });
        }
        if !(tick.is_finite() && tick > 0.0) {
            return Err(SpeedError::NotPositive { what: "tick", value: tick });
        }
        Ok(Speed { velocity, tick, whole_bits: 32, fraction_bits: 8, least: 2.0 })
    }

    /// The same for a register of `whole_bits` (1 to 32) and `fraction_bits` (0 to 24) bits, and intervals of `least`
    /// ticks or more, such as [`Margins::least_ticks`](super::Margins::least_ticks).
    #[must_use]
    pub fn with_register(self, whole_bits: u32, fraction_bits: u32, least: u64) -> Speed {
        let (whole_bits, fraction_bits) = (whole_bits.clamp(1, 32), fraction_bits.min(24));
        Speed { whole_bits, fraction_bits, least: (least as f64).max(1.0), ..self }
    }

    /// Δt of a line drawn by a DDA of `bits` bits after `shifts` normalising shifts, in ticks times 2^fraction_bits, rounded.
    ///
    /// # Errors
    /// If the line has no length, it cannot be shifted so far, or Δt is shorter or longer than the generator can make.
    pub fn line(&self, increments: &[i64], bits: u32, shifts: u32) -> Result<u64, SpeedError> {
        let length = increments.iter().map(|&d| (d as f64).powi(2)).sum::<f64>().sqrt();
        self.path("length", length, bits, shifts)
    }

    /// Δt of a circle of `radius` BLU drawn by a DDA; as [`line`](Speed::line).
    ///
    /// # Errors
    /// If the radius is not above 0, it cannot be shifted so far, or Δt is shorter or longer than the generator can make.
    pub fn arc(&self, radius: f64, bits: u32, shifts: u32) -> Result<u64, SpeedError> {
        self.path("radius", radius, bits, shifts)
    }

    /// Δt of an interpolator that steps with every one: one BLU each.
    ///
    /// # Errors
    /// If Δt is shorter or longer than the generator can make.
    pub fn step(&self) -> Result<u64, SpeedError> {
        self.ticks(1.0)
    }

    fn path(&self, what: &'static str, size: f64, bits: u32, shifts: u32) -> Result<u64, SpeedError> {
        if !(size.is_finite() && size > 0.0) {
            return Err(SpeedError::NotPositive { what, value: size });
        }
        if !(1..=super::super::MAX_BITS).contains(&bits) || shifts >= bits {
            return Err(SpeedError::Shifts { bits, shifts });
        }
        self.ticks(size * 2f64.powi(shifts as i32 - bits as i32))
    }

    /// The period for `distance` BLU along the path with every Δt.
    fn ticks(&self, distance: f64) -> Result<u64, SpeedError> {
        let ticks = distance / (self.velocity * self.tick);
        let scale = (1u64 << self.fraction_bits) as f64;
        let period = (ticks * scale).round();
        if period < self.least * scale {
            let limit = distance / (self.least * self.tick);
            return Err(SpeedError::TooFast { velocity: self.velocity, limit });
        }
        let most = ((1u64 << (self.whole_bits + self.fraction_bits)) - 1) as f64;
        if period > most {
            let limit = distance / (most / scale * self.tick);
            return Err(SpeedError::TooSlow { velocity: self.velocity, limit });
        }
        Ok(period as u64)
    }
}

/// Why there is no period for a speed.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub enum SpeedError {
    /// A speed, tick, length or radius that is 0, negative or no number.
    NotPositive {
        /// Which of them.
        what: &'static str,
        /// What it is.
        value: f64,
    },
    /// The registers' width is not possible, or so many shifts are not.
    Shifts {
        /// Bits of the registers.
        bits: u32,
        /// The shifts asked for.
        shifts: u32,
    },
    /// The interval would be shorter than the generator can make.
    TooFast {
        /// The speed asked for, BLU a second.
        velocity: f64,
        /// The highest possible here.
        limit: f64,
    },
    /// The interval would not fit the register of the period.
    TooSlow {
        /// The speed asked for, BLU a second.
        velocity: f64,
        /// The lowest possible here.
        limit: f64,
    },
}

impl fmt::Display for SpeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            SpeedError::NotPositive { what, value } => write!(f, "a {what} of {value}: it must be above 0"),
            SpeedError::Shifts { bits, shifts } => write!(
                f,
                "{shifts} shifts in registers of {bits} bits: there may be {} bits, and less shifts than bits",
                super::super::MAX_BITS
            ),
            SpeedError::TooFast { velocity, limit } => {
                write!(f, "{velocity} BLU/s is too fast for this clock: at most {limit:.3} BLU/s")
            }
            SpeedError::TooSlow { velocity, limit } => {
                write!(f, "{velocity} BLU/s is too slow for this register: at least {limit:.3} BLU/s")
            }
        }
    }
}

impl error::Error for SpeedError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_period_is_inversely_proportional_to_the_speed() {
        // L = 5, p = 8: Δt = 5 / (V·256); at 1 BLU/s 19.53125 ms
        let ticks = |velocity| Speed::new(velocity, 1e-6).unwrap().line(&[3, -4], 8, 0).unwrap();
        assert_eq!(ticks(1.0), 19_531 * 256 + 64);
        assert_eq!(ticks(2.0), (19_531 * 256 + 64) / 2);
        assert_eq!(ticks(4.0), (19_531 * 256 + 64) / 4);
    }

    #[test]
    fn normalising_shifts_lengthen_the_interval_as_they_shorten_the_count() {
        let speed = Speed::new(1.0, 1e-6).unwrap();
        assert_eq!(speed.line(&[3, 4], 8, 5), speed.line(&[96, 128], 8, 0));
        // the time for the whole line, 2^(p - s) clocks, is L / V = 5 s
        let ticks = speed.line(&[3, 4], 8, 5).unwrap() << (8 - 5);
        assert_eq!(ticks, 5_000_000 << 8);
        // a radian of an arc takes R / V
        assert_eq!(speed.arc(100.0, 8, 1).unwrap() << 7, 100_000_000 << 8);
        // three axes
        assert_eq!(speed.line(&[2, 3, 6], 8, 0), speed.line(&[7, 0], 8, 0));
    }

    #[test]
    fn what_cannot_be_is_refused_with_the_limit() {
        let speed = |v| Speed::new(v, 1e-6).map(|s| s.with_register(16, 8, 10));
        for v in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(speed(v), Err(SpeedError::NotPositive { what: "speed", .. })), "{v}");
        }
        assert_eq!(speed(-3.0).unwrap_err().to_string(), "a speed of -3: it must be above 0");
        // 10 ticks of 1 µs a step
        assert_eq!(speed(100_000.0).unwrap().step(), Ok(10 << 8));
        let fast = speed(200_000.0).unwrap().step().unwrap_err();
        assert_eq!(fast.to_string(), "200000 BLU/s is too fast for this clock: at most 100000.000 BLU/s");
        // 65536 - 1/256 ticks of 1 µs
        let slow = speed(1.0).unwrap().step().unwrap_err();
        let SpeedError::TooSlow { limit, .. } = slow else { panic!("{slow}") };
        assert!((limit - 1e6 / (65536.0 - 1.0 / 256.0)).abs() < 1e-9, "{slow}");
        let speed = speed(1.0).unwrap();
        assert_eq!(speed.line(&[0, 0], 8, 0).unwrap_err().to_string(), "a length of 0: it must be above 0");
        assert_eq!(speed.arc(0.0, 8, 0).unwrap_err().to_string(), "a radius of 0: it must be above 0");
        assert!(matches!(speed.line(&[1, 1], 8, 8), Err(SpeedError::Shifts { bits: 8, shifts: 8 })));
        assert!(matches!(speed.arc(1.0, 40, 0), Err(SpeedError::Shifts { bits: 40, .. })));
    }
}
