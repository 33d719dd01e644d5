//! How long a tick is. Every room may know this.

use std::fmt;
use std::str::FromStr;

/// A unit of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Unit {
    /// Femtoseconds.
    Fs,
    /// Picoseconds.
    Ps,
    /// Nanoseconds.
    Ns,
    /// Microseconds.
    Us,
    /// Milliseconds.
    Ms,
    /// Seconds.
    S,
}

impl Unit {
    /// All units, the shortest first.
    pub const ALL: [Unit; 6] = [Unit::Fs, Unit::Ps, Unit::Ns, Unit::Us, Unit::Ms, Unit::S];

    /// How it is written.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Unit::Fs => "fs",
            Unit::Ps => "ps",
            Unit::Ns => "ns",
            Unit::Us => "us",
            Unit::Ms => "ms",
            Unit::S => "s",
        }
    }

    /// The power of ten of a second: -15 to 0.
    #[must_use]
    pub const fn exponent(self) -> i32 {
        self as i32 * 3 - 15
    }

    /// How many femtoseconds it has.
    #[must_use]
    pub const fn femtoseconds(self) -> u64 {
        1000u64.pow(self as u32)
    }

    /// The unit written so.
    #[must_use]
    pub fn named(text: &str) -> Option<Unit> {
        Unit::ALL.into_iter().find(|u| u.as_str() == text)
    }
}

/// The length of one tick: 1, 10 or 100 of a unit.
///
/// ```
/// # use discreta_core as discreta;
/// use discreta::Timescale;
/// let t: Timescale = "100 ps".parse().unwrap();
/// assert_eq!(t.to_string(), "100ps");
/// assert_eq!(t.femtoseconds(), 100_000);
/// assert_eq!(Timescale::default().to_string(), "1ns");
/// assert!("2ns".parse::<Timescale>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Timescale {
    count: u32,
    unit: Unit,
}

impl Timescale {
    /// 1, 10 or 100 of a unit; `None` for other counts.
    #[must_use]
    pub const fn new(count: u32, unit: Unit) -> Option<Timescale> {
        match count {
            1 | 10 | 100 => Some(Timescale { count, unit }),
            _ => None,
        }
    }

    /// How many units: 1, 10 or 100.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.count
    }

    /// The unit.
    #[must_use]
    pub const fn unit(self) -> Unit {
        self.unit
    }

    /// A tick as a power of ten of a second, -15 to 2.
    #[must_use]
    pub const fn exponent(self) -> i32 {
        self.unit.exponent() + self.count.ilog10() as i32
    }

    /// The timescale whose tick is that power of ten of a second, if there is one.
    #[must_use]
    pub fn from_exponent(exponent: i32) -> Option<Timescale> {
        let unit = Unit::ALL.into_iter().rfind(|unit| unit.exponent() <= exponent)?;
        let count = 10_u32.checked_pow(exponent.abs_diff(unit.exponent()))?;
        Timescale::new(count, unit)
    }

    /// A time in ticks with its unit.
    ///
    /// ```
    /// # use discreta_core as discreta;
    /// let t: discreta::Timescale = "10ps".parse().unwrap();
    /// assert_eq!(t.time(125), "1250 ps");
    /// ```
    #[must_use]
    pub fn time(self, ticks: u64) -> String {
        format!("{} {}", u128::from(ticks) * u128::from(self.count), self.unit.as_str())
    }

    /// The length of a tick in femtoseconds.
    #[must_use]
    pub const fn femtoseconds(self) -> u64 {
        self.count as u64 * self.unit.femtoseconds()
    }
}

impl Default for Timescale {
    fn default() -> Timescale {
        Timescale { count: 1, unit: Unit::Ns }
    }
}

impl fmt::Display for Timescale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.count, self.unit.as_str())
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl FromStr for Timescale {
    type Err = String;

    fn from_str(text: &str) -> Result<Timescale, String> {
        let trimmed = text.trim();
        let digits = trimmed.bytes().position(|b| !b.is_ascii_digit()).unwrap_or(trimmed.len());
        let (count, unit) = trimmed.split_at(digits);
        let unit = Unit::named(unit.trim_start());
        count.parse().ok().zip(unit).and_then(|(count, unit)| Timescale::new(count, unit)).ok_or_else(|| {
            format!("`{text}` is not a timescale: write 1, 10 or 100 of s, ms, us, ns, ps or fs, e.g. `1ns`")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_and_timescales_agree() {
        for exponent in -15..=2 {
            assert_eq!(Timescale::from_exponent(exponent).unwrap().exponent(), exponent);
        }
        assert_eq!(Timescale::from_exponent(-16), None);
        assert_eq!(Timescale::from_exponent(3), None);
        assert_eq!(Timescale::from_exponent(-7), Timescale::new(100, Unit::Ns));
    }
}
