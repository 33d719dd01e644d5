//! Exact decimal numbers, as a part program writes them.

use std::fmt;
use std::ops::{Add, AddAssign, Neg, Sub};

use super::words::Cursor;

/// Digits behind the point.
const DIGITS: u32 = 16;
/// One, in units of the last place.
const ONE: i128 = 10_i128.pow(DIGITS);

/// A decimal number with 16 digits behind the point, without rounding in sums.
///
/// What is read from a program has at most 9 digits before the point and 15 behind it, so that a length in inches is
/// exact in millimetres too, and sums of billions of them stay in range.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Decimal(i128);

impl Decimal {
    /// 0.
    pub const ZERO: Decimal = Decimal(0);
    /// Digits behind the point that a program may write.
    pub const WRITTEN: u32 = DIGITS - 1;
    /// Digits before the point that a program may write.
    pub const WHOLE: u32 = 9;
    /// What values have to stay below.
    const LIMIT: i128 = 10_i128.pow(Self::WHOLE) * ONE;

    /// A whole number.
    #[must_use]
    pub const fn whole(value: i64) -> Decimal {
        Decimal(value as i128 * ONE)
    }

    /// `digits · 10^−decimals`, if that has no more digits than may be written.
    #[must_use]
    pub fn scaled(digits: i128, decimals: u32) -> Option<Decimal> {
        if decimals > Self::WRITTEN {
            return None;
        }
        let value = digits.checked_mul(10_i128.pow(DIGITS - decimals))?;
        (value.abs() < Self::LIMIT).then_some(Decimal(value))
    }

    /// The nearest to a floating-point number, rounded to 12 digits behind the point, if it is in range.
    #[must_use]
    pub fn nearest(value: f64) -> Option<Decimal> {
        (value.abs() < 1e9).then(|| Decimal((value * 1e12).round() as i128 * 10_i128.pow(DIGITS - 12)))
    }

    /// Inches as millimetres: 25.4-fold, exactly.
    #[must_use]
    pub const fn inches(self) -> Decimal {
        Decimal(self.0 / 10 * 254 + self.0 % 10 * 254 / 10)
    }

    /// The nearest floating-point number.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.0 as f64 / ONE as f64
    }

    /// The whole number that it is, if it is one.
    #[must_use]
    pub fn to_whole(self) -> Option<i64> {
        if self.0 % ONE == 0 { i64::try_from(self.0 / ONE).ok() } else { None }
    }

    /// The nearest whole number.
    #[must_use]
    pub fn round(self) -> Decimal {
        Decimal((self.0 + ONE / 2 * self.0.signum()) / ONE * ONE)
    }

    /// The greatest whole number that is not above it.
    #[must_use]
    pub const fn floor(self) -> Decimal {
        Decimal(self.0.div_euclid(ONE) * ONE)
    }

    /// Below, at or above 0: −1, 0 or 1.
    #[must_use]
    pub const fn signum(self) -> i32 {
        self.0.signum() as i32
    }

    /// Without its sign.
    #[must_use]
    pub const fn abs(self) -> Decimal {
        Decimal(self.0.abs())
    }

    /// The product, rounded to the last place, if it is in range.
    #[must_use]
    pub fn times(self, other: Decimal) -> Option<Decimal> {
        self.scale(other, Decimal(ONE))
    }

    /// The quotient, rounded to the last place, if it is in range.
    #[must_use]
    pub fn over(self, other: Decimal) -> Option<Decimal> {
        self.scale(Decimal(ONE), other)
    }

    /// `self · times / over`, rounded to the last place, halves away from 0.
    fn scale(self, times: Decimal, over: Decimal) -> Option<Decimal> {
        let (negative, d) = ((self.0 < 0) ^ (times.0 < 0) ^ (over.0 < 0), over.0.unsigned_abs());
        let quotient = multiply_divide(self.0.unsigned_abs(), times.0.unsigned_abs(), d)?;
        let value = i128::try_from(quotient).ok().filter(|&v| v < Self::LIMIT)?;
        Some(Decimal(if negative { -value } else { value }))
    }

    /// Into how many units of `unit` it divides, rounded, halves away from 0 as in `round`; none beyond 62 bits.
    #[must_use]
    pub fn in_units(self, unit: Decimal) -> Option<i64> {
        let (a, u) = (self.0.unsigned_abs(), unit.0.unsigned_abs());
        let whole = a.checked_div(u)?;
        let rest = a - whole * u;
        let count = i64::try_from(whole + u128::from(rest >= u - rest)).ok().filter(|&n| n < 1 << 62)?;
        Some(if self.0 < 0 { -count } else { count })
    }

    /// The product with `other`, rounded to a whole number, halves away from 0; none beyond 62 bits.
    #[must_use]
    pub fn times_rounded(self, other: Decimal) -> Option<i64> {
        let product = multiply_divide(self.0.unsigned_abs(), other.0.unsigned_abs(), (ONE * ONE).unsigned_abs())?;
        let count = i64::try_from(product).ok().filter(|&n| n < 1 << 62)?;
        Some(if (self.0 < 0) ^ (other.0 < 0) { -count } else { count })
    }

    /// Whether `a·d − b·c` is below, at or above 0, exactly.
    #[must_use]
    pub fn cross_sign([a, b]: [Decimal; 2], [c, d]: [Decimal; 2]) -> i32 {
        let product = |x: Decimal, y: Decimal| {
            let (high, low) = multiply(x.0.unsigned_abs(), y.0.unsigned_abs());
            if x.0.signum() * y.0.signum() < 0 { (-1, high, low) } else { (1, high, low) }
        };
        let (p, q) = (product(a, d), product(b, c));
        let order = |(s, h, l): (i8, u128, u128), (t, i, m): (i8, u128, u128)| match ((h, l), (i, m)) {
            ((0, 0), (0, 0)) => std::cmp::Ordering::Equal,
            _ if s != t && (h, l) != (0, 0) => s.cmp(&0),
            _ if s != t => 0.cmp(&t),
            (x, y) if s > 0 => x.cmp(&y),
            (x, y) => y.cmp(&x),
        };
        order(p, q) as i32
    }
}

/// The product of 256 bits: its upper and its lower half.
fn multiply(a: u128, b: u128) -> (u128, u128) {
    const HALF: u128 = u64::MAX as u128;
    let (a1, a0, b1, b0) = (a >> 64, a & HALF, b >> 64, b & HALF);
    let (low, mid, mid2, high) = (a0 * b0, a1 * b0, a0 * b1, a1 * b1);
    let carry = (low >> 64) + (mid & HALF) + (mid2 & HALF);
    (high + (mid >> 64) + (mid2 >> 64) + (carry >> 64), carry << 64 | low & HALF)
}

/// `a·b/d`, rounded to the nearest, halves up; none if it has more than 127 bits, or `d` is 0 or has more than that.
fn multiply_divide(a: u128, b: u128, d: u128) -> Option<u128> {
    let (high, low) = multiply(a, b);
    if d == 0 || d >> 127 != 0 || high >= d {
        return None;
    }
    let (mut rest, mut quotient) = (high, 0_u128);
    for i in (0..128).rev() {
        rest = rest << 1 | low >> i & 1;
        let fits = rest >= d;
        if fits {
            rest -= d;
        }
        if quotient >> 126 != 0 {
            return None;
        }
        quotient = quotient << 1 | u128::from(fits);
    }
    Some(quotient + u128::from(rest >= d - rest))
}

/// Digits with a sign and a point at most.
impl std::str::FromStr for Decimal {
    type Err = String;

    fn from_str(text: &str) -> Result<Decimal, String> {
        let mut cursor = Cursor::new(text.as_bytes());
        match cursor.number() {
            Ok((value, _)) if cursor.peek().is_none() => Ok(value),
            Ok(_) => Err(format!("`{text}` is no decimal number")),
            Err(fault) => Err(fault.message),
        }
    }
}

impl Add for Decimal {
    type Output = Decimal;

    fn add(self, other: Decimal) -> Decimal {
        Decimal(self.0.saturating_add(other.0))
    }
}

impl Sub for Decimal {
    type Output = Decimal;

    fn sub(self, other: Decimal) -> Decimal {
        Decimal(self.0.saturating_sub(other.0))
    }
}

impl AddAssign for Decimal {
    fn add_assign(&mut self, other: Decimal) {
        *self = *self + other;
    }
}

impl Neg for Decimal {
    type Output = Decimal;

    fn neg(self) -> Decimal {
        Decimal(-self.0)
    }
}

/// With as many digits behind the point as asked for, rounded (`{:.4}`), or else as few as there are.
impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = f.precision().map_or(DIGITS, |p| (p as u32).min(DIGITS));
        let last = 10_u128.pow(DIGITS - decimals);
        let digits = (self.0.unsigned_abs() + last / 2) / last;
        let sign = if self.0 < 0 && digits > 0 { "-" } else { "" };
        let one = 10_u128.pow(decimals);
        let (whole, part) = (digits / one, digits % one);
        let mut text = format!("{sign}{whole}.{part:0width$}", width = decimals as usize);
        if decimals == 0 || f.precision().is_none() {
            let kept = text.trim_end_matches('0').trim_end_matches('.').len();
            text.truncate(if decimals == 0 { text.len() - 2 } else { kept });
        }
        f.pad_integral(true, "", &text)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn decimal(text: &str) -> Decimal {
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        Decimal::scaled(format!("{whole}{part}").parse().unwrap(), part.len() as u32).unwrap()
    }

    #[test]
    fn inches_are_exact() {
        assert_eq!(decimal("1").inches(), decimal("25.4"));
        assert_eq!(decimal("0.000000000000001").inches().to_string(), "0.0000000000000254");
        assert_eq!(decimal("-123456789.123456789").inches(), -decimal("123456789.123456789").inches());
    }

    #[test]
    fn rounding_is_to_the_nearest_unit_and_halves_away_from_0() {
        let blu = decimal("0.01");
        let units = ["0.014", "0.015", "-0.015", "-0.0149999999999", "1", "0.005"].map(|t| decimal(t).in_units(blu));
        assert_eq!(units.map(Option::unwrap), [1, 2, -2, -1, 100, 1]);
        assert_eq!(decimal("999999999").in_units(decimal("0.000000000000001")), None);
        assert_eq!(decimal("1").in_units(Decimal::ZERO), None);
        let steps = ["0.005", "-0.005", "0.00499999", "3.3"].map(|t| decimal(t).times_rounded(decimal("100")));
        assert_eq!(steps.map(Option::unwrap), [1, -1, 0, 330]);
        assert_eq!(decimal("999999999").times_rounded(decimal("999999999")), Some(999_999_998_000_000_001));
    }

    #[test]
    fn printed() {
        assert_eq!(decimal("1.50").to_string(), "1.5");
        assert_eq!(decimal("-0.00004").to_string(), "-0.00004");
        assert_eq!(format!("{:.4}", decimal("-0.00004")), "0.0000");
        assert_eq!(format!("{:.4}", decimal("-0.00005")), "-0.0001");
        assert_eq!(format!("{:.2}", decimal("12.345")), "12.35");
        assert_eq!((format!("{:.0}", decimal("1.5")), Decimal::ZERO.to_string()), ("2".to_owned(), "0".to_owned()));
    }

    #[test]
    fn products_and_quotients_by_hand() {
        assert_eq!(decimal("2.5").times(decimal("-4")), Some(decimal("-10")));
        assert_eq!(decimal("1").over(decimal("3")).unwrap().to_string(), "0.3333333333333333");
        assert_eq!(decimal("2").over(decimal("3")).unwrap().to_string(), "0.6666666666666667");
        assert_eq!(decimal("99999").times(decimal("99999")), None);
        assert_eq!(decimal("1").over(Decimal::ZERO), None);
        assert_eq!(decimal("999999999").over(decimal("0.000000000000001")), None);
    }

    #[test]
    fn cross_products_have_their_sign_exactly() {
        let sign = |a: &str, b: &str, c: &str, d: &str| {
            Decimal::cross_sign([decimal(a), decimal(b)], [decimal(c), decimal(d)])
        };
        assert_eq!(sign("1", "0", "0", "1"), 1);
        assert_eq!(sign("0", "1", "1", "0"), -1);
        assert_eq!(sign("3", "4", "6", "8"), 0);
        assert_eq!(sign("-3", "4", "6", "-8"), 0);
        assert_eq!(sign("0", "0", "-6", "8"), 0);
        // the products differ by 10^−30
        assert_eq!(sign("100000000", "100000000.000000000000001", "100000000", "100000000"), -1);
    }

    proptest! {
        #[test]
        fn as_in_whole_numbers(a in -1_000_000_i64..1_000_000, b in -1_000_000_i64..1_000_000, c in 1_i64..1000) {
            let [x, y, z] = [a, b, c].map(|v| Decimal::scaled(v.into(), 3).unwrap());
            prop_assert_eq!(x.times(y), Decimal::scaled(i128::from(a) * i128::from(b), 6));
            prop_assert_eq!(Decimal::cross_sign([x, y], [z, x]), (i128::from(a) * i128::from(a) - i128::from(b) * i128::from(c)).signum() as i32);
            let units = (a as f64 / c as f64).abs().round() as i64 * a.signum();
            if a * 2 % c != 0 {
                prop_assert_eq!(x.in_units(z), Some(units));
            }
        }
    }
}
