//! Ranges and the ticks on them.

/// A closed range of numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Range {
    pub(crate) least: f64,
    pub(crate) greatest: f64,
}

impl Range {
    /// The range that holds all of these; 0 alone, if there are none.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Range {
        let mut values = values.into_iter().filter(|v| v.is_finite());
        let first = values.next().unwrap_or(0.0);
        values.fold(Range { least: first, greatest: first }, |r, v| Range {
            least: r.least.min(v),
            greatest: r.greatest.max(v),
        })
    }

    pub(crate) fn length(self) -> f64 {
        self.greatest - self.least
    }

    /// The same centre, another length.
    pub(crate) fn resized(self, length: f64) -> Range {
        let more = (length - self.length()) / 2.0;
        Range { least: self.least - more, greatest: self.greatest + more }
    }

    pub(crate) fn holds(self, value: f64) -> bool {
        (self.least..=self.greatest).contains(&value)
    }
}

/// Evenly spaced round numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Ticks {
    /// The number of the first one: it is at `first · mantissa · 10^exponent`.
    first: i64,
    last: i64,
    mantissa: i64,
    exponent: i32,
}

impl Ticks {
    /// Ticks in a range at least `gap` apart, at 1, 2 or 5 times a power of ten that is at least `10^least`.
    pub(crate) fn new(range: Range, gap: f64, least: i32) -> Ticks {
        let (mut mantissa, mut exponent) = (1, least);
        while step(mantissa, exponent) < gap && exponent < 300 {
            (mantissa, exponent) = match mantissa {
                1 => (2, exponent),
                2 => (5, exponent),
                _ => (1, exponent + 1),
            };
        }
        let step = step(mantissa, exponent);
        // a tick that rounding has put a little outside is still one
        let (first, last) = (range.least / step - 1e-9, range.greatest / step + 1e-9);
        Ticks { first: first.ceil() as i64, last: last.floor() as i64, mantissa, exponent }
    }

    /// The distance between two.
    pub(crate) fn step(&self) -> f64 {
        step(self.mantissa, self.exponent)
    }

    /// Where they are.
    pub(crate) fn values(&self) -> impl Iterator<Item = f64> + use<> {
        let step = self.step();
        (self.first..=self.last).map(move |i| i as f64 * step)
    }

    /// What is written at one of them: k, M, G for thousands, millions, thousands of millions.
    pub(crate) fn label(&self, value: f64) -> String {
        if value == 0.0 && self.exponent >= 0 {
            return "0".to_owned();
        }
        let (unit, letter) = match self.exponent {
            ..3 => (1.0, ""),
            3..6 => (1e3, "k"),
            6..9 => (1e6, "M"),
            _ => (1e9, "G"),
        };
        let decimals = usize::try_from(-self.exponent).unwrap_or(0);
        signed(value / unit, decimals) + letter
    }
}

fn step(mantissa: i64, exponent: i32) -> f64 {
    let power = (0..exponent.unsigned_abs()).fold(1.0, |p, _| p * 10.0);
    if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power }
}

/// A number with a minus sign as it is printed in books.
pub(crate) fn signed(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let zero = digits.bytes().all(|b| matches!(b, b'0' | b'.'));
    if value < 0.0 && !zero { format!("−{digits}") } else { digits }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(least: f64, greatest: f64, gap: f64, exponent: i32) -> Vec<String> {
        let ticks = Ticks::new(Range { least, greatest }, gap, exponent);
        ticks.values().map(|v| ticks.label(v)).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(-1.2, 2.5, 0.7, 0), ["−1", "0", "1", "2"]);
        assert_eq!(labels(0.0, 10.0, 3.0, 0), ["0", "5", "10"]);
        assert_eq!(labels(-0.3, 0.3, 0.15, -3), ["−0.2", "0.0", "0.2"]);
        assert_eq!(labels(0.0, 250_000.0, 60_000.0, 0), ["0", "100k", "200k"]);
        assert_eq!(labels(-2e6, 2e6, 1e6, 0), ["−2M", "−1M", "0", "1M", "2M"]);
        assert_eq!(labels(0.0, 0.3, 0.1, -3), ["0.0", "0.1", "0.2", "0.3"]);
    }

    #[test]
    fn a_range_holds_what_it_is_made_of() {
        assert_eq!(Range::of([3.0, -1.0, f64::NAN]), Range { least: -1.0, greatest: 3.0 });
        assert_eq!(Range::of([]), Range { least: 0.0, greatest: 0.0 });
        assert_eq!(Range { least: 0.0, greatest: 2.0 }.resized(4.0), Range { least: -1.0, greatest: 3.0 });
    }
}
