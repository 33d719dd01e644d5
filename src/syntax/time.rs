//! Times as they are written: ticks, expressions, or numbers with a unit.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use crate::diag::{Code, Diagnostic, Span};
use crate::json::{self, Spanned};
use crate::syntax::{Expr, Names};
use crate::{Timescale, Unit};

/// A decimal number, exactly: `mantissa / 10^places`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Decimal {
    mantissa: u64,
    places: u32,
}

impl Decimal {
    /// Reads the digits at the start of `text`; the rest comes back.
    fn take(text: &str) -> Option<(Decimal, &str)> {
        let length = text.bytes().position(|b| !(b.is_ascii_digit() || b == b'.')).unwrap_or(text.len());
        let (number, rest) = text.split_at(length);
        let (whole, fraction) = number.split_once('.').unwrap_or((number, "0"));
        if whole.is_empty() || fraction.is_empty() || fraction.contains('.') {
            return None;
        }
        let fraction = fraction.trim_end_matches('0');
        let places = u32::try_from(fraction.len()).ok().filter(|&p| p < 19)?;
        let mantissa = format!("{whole}{fraction}").parse().ok()?;
        Some((Decimal { mantissa, places }, rest))
    }
}

/// A time as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeText {
    form: TimeForm,
    span: Span,
}

#[derive(Debug, Clone, PartialEq)]
enum TimeForm {
    /// Ticks.
    Ticks(Expr),
    /// A number with a unit.
    Quantity(Decimal, Unit, String),
}

impl TimeText {
    /// Reads `text`, which stands at `span`: ticks, an expression, or a number with a unit.
    ///
    /// # Errors
    /// If it is none of them.
    pub fn parse(text: &str, span: Span) -> Result<TimeText, Diagnostic> {
        let trimmed = text.trim();
        let number = trimmed.bytes().position(|b| !(b.is_ascii_digit() || b == b'.')).unwrap_or(trimmed.len());
        let unit = trimmed[number..].trim_start();
        let quantity = number > 0 && unit.starts_with(|c: char| c.is_alphabetic() || c == 'µ');
        if !quantity && !trimmed[..number].contains('.') {
            return Ok(TimeText { form: TimeForm::Ticks(Expr::parse(text, span)?), span });
        }
        let fault = |message: String| Diagnostic::new(Code::BadTime, message).at(span, "");
        if !quantity {
            return Err(fault(format!("`{trimmed}` is not a whole number of ticks")).help("add a unit, e.g. `2.5us`"));
        }
        let Some(unit) = Unit::named(unit) else {
            return Err(fault(format!("`{unit}` is not a unit of time"))
                .help("the units are `s`, `ms`, `us`, `ns`, `ps` and `fs`"));
        };
        match Decimal::take(trimmed) {
            Some((decimal, _)) => Ok(TimeText { form: TimeForm::Quantity(decimal, unit, trimmed.to_owned()), span }),
            None => Err(fault(format!("`{trimmed}` is not a time"))),
        }
    }

    /// Where it stands.
    #[must_use]
    pub fn span(&self) -> Span {
        self.span
    }

    /// The time in ticks of `timescale`; expressions are computed with `names`.
    ///
    /// # Errors
    /// If it is not a whole number of ticks, negative, or more than 2^64-1 ticks, or the expression fails.
    pub fn ticks(&self, timescale: Timescale, names: &dyn Names) -> Result<u64, Diagnostic> {
        let fault = |message: String| Diagnostic::new(Code::BadTime, message).at(self.span, "");
        match &self.form {
            TimeForm::Ticks(expr) => {
                let n = expr.eval(names)?;
                u64::try_from(n).map_err(|_| fault(format!("a time is negative: {n} ticks")))
            }
            TimeForm::Quantity(decimal, unit, text) => {
                // At most 2^64 * 10^15, and 10^18 * 10^17: both fit.
                let femtoseconds = u128::from(decimal.mantissa) * u128::from(unit.femtoseconds());
                let tick = 10u128.pow(decimal.places) * u128::from(timescale.femtoseconds());
                if !femtoseconds.is_multiple_of(tick) {
                    return Err(fault(format!("`{text}` is not a whole number of ticks of {timescale}"))
                        .help("give the circuit a finer `timescale`, or round the time"));
                }
                u64::try_from(femtoseconds / tick)
                    .map_err(|_| fault(format!("`{text}` is more than 2^64-1 ticks of {timescale}")))
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind a time: a number of ticks, or a string such as \"5ns\"", rename_all = "lowercase")]
enum WrittenTime {
    Integer(i64),
    String(String),
}

impl<'de> Deserialize<'de> for TimeText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Spanned { value, span } = Spanned::<WrittenTime>::deserialize(deserializer)?;
        match value {
            WrittenTime::Integer(n) => Ok(TimeText { form: TimeForm::Ticks(Expr::number(n, span)), span }),
            WrittenTime::String(text) => TimeText::parse(&text, span).map_err(json::fault),
        }
    }
}

impl JsonSchema for TimeText {
    fn schema_name() -> Cow<'static, str> {
        "Time".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number of ticks, an expression in the module's parameters, or a number with a unit, \
                            `2.5us`.",
            "anyOf": [{ "type": "integer", "minimum": 0 }, { "type": "string", "minLength": 1 }]
        })
    }
}

/// A share in percent, exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percent {
    decimal: Decimal,
    span: Span,
}

impl Percent {
    /// Where it stands.
    #[must_use]
    pub fn span(&self) -> Span {
        self.span
    }

    /// This share of `ticks`.
    ///
    /// # Errors
    /// If that is not a whole number of ticks.
    pub fn of(&self, ticks: u64) -> Result<u64, Diagnostic> {
        let hundred = 100 * 10u128.pow(self.decimal.places);
        let product = u128::from(self.decimal.mantissa) * u128::from(ticks);
        match u64::try_from(product / hundred) {
            Ok(share) if product.is_multiple_of(hundred) => Ok(share),
            _ => Err(Diagnostic::new(
                Code::BadTime,
                format!("this share of {ticks} ticks is not a whole number of ticks"),
            )
            .at(self.span, "")
            .help("give the circuit a finer `timescale`, or choose another share")),
        }
    }
}

#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind a percentage: a number from 0 to 100", rename_all = "lowercase")]
enum WrittenPercent {
    Integer(i64),
    Number(f64),
}

impl<'de> Deserialize<'de> for Percent {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Spanned { value, span } = Spanned::<WrittenPercent>::deserialize(deserializer)?;
        // An f64 is displayed by the shortest digits that give it back, which are those that were written.
        let (text, allowed) = match value {
            WrittenPercent::Integer(n) => (n.to_string(), (0..=100).contains(&n)),
            WrittenPercent::Number(n) => (n.to_string(), (0.0..=100.0).contains(&n)),
        };
        let decimal = Decimal::take(&text).filter(|(_, rest)| rest.is_empty() && allowed);
        match decimal {
            Some((decimal, _)) => Ok(Percent { decimal, span }),
            None => Err(json::fault(
                Diagnostic::new(Code::BadValue, "a percentage must be a number from 0 to 100").at(span, ""),
            )),
        }
    }
}

impl JsonSchema for Percent {
    fn schema_name() -> Cow<'static, str> {
        "Percent".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "number", "minimum": 0, "maximum": 100 })
    }
}

#[cfg(test)]
mod tests {
    use indexmap::IndexMap;
    use proptest::prelude::*;

    use super::*;

    fn ticks(text: &str, timescale: &str) -> Result<u64, String> {
        let names = IndexMap::from([("W".to_owned(), 4)]);
        let time = TimeText::parse(text, Span::default()).map_err(|d| d.message)?;
        time.ticks(timescale.parse().unwrap(), &names).map_err(|d| d.message)
    }

    #[test]
    fn times_in_ticks() {
        assert_eq!(ticks("5", "1ns"), Ok(5));
        assert_eq!(ticks("2 << W", "1ns"), Ok(32));
        assert_eq!(ticks("5ns", "1ns"), Ok(5));
        assert_eq!(ticks("2.5us", "1ns"), Ok(2500));
        assert_eq!(ticks(" 2.50 us ", "10ns"), Ok(250));
        assert_eq!(ticks("1s", "1fs"), Ok(1_000_000_000_000_000));
        assert_eq!(ticks("0ns", "100s"), Ok(0));
        assert_eq!(ticks("300s", "100s"), Ok(3));
        assert_eq!(ticks("0.000000000000001s", "1fs"), Ok(1));
        assert_eq!(ticks("2.5ns", "1ns"), Err("`2.5ns` is not a whole number of ticks of 1ns".into()));
        assert_eq!(ticks("5ns", "10ns"), Err("`5ns` is not a whole number of ticks of 10ns".into()));
        assert_eq!(ticks("2.5", "1ns"), Err("`2.5` is not a whole number of ticks".into()));
        assert_eq!(ticks("5m", "1ns"), Err("`m` is not a unit of time".into()));
        assert_eq!(ticks("5µs", "1ns"), Err("`µs` is not a unit of time".into()));
        assert_eq!(ticks("1.2.3ns", "1ns"), Err("`1.2.3ns` is not a time".into()));
        assert_eq!(ticks("5 - 6", "1ns"), Err("a time is negative: -1 ticks".into()));
        assert_eq!(ticks("99999s", "1fs"), Err("`99999s` is more than 2^64-1 ticks of 1fs".into()));
        assert_eq!(ticks("99999999999999999999ns", "1ns"), Err("`99999999999999999999ns` is not a time".into()));
        assert_eq!(ticks("5 5", "1ns"), Err("expected an operator or the end of the expression".into()));
        assert_eq!(ticks("", "1ns"), Err("an expression is missing".into()));
    }

    #[test]
    fn timescales() {
        for good in ["1s", "10ms", "100 us", "1ns", "10ps", "100fs"] {
            assert_eq!(good.parse::<Timescale>().unwrap().to_string(), good.replace(' ', ""));
        }
        for bad in ["", "1", "ns", "2ns", "1000ns", "1 n s", "-1ns", "1µs", "01ns ns"] {
            assert!(bad.parse::<Timescale>().is_err(), "{bad}");
        }
    }

    #[test]
    fn shares() {
        let percent = |text: &str| {
            let (decimal, rest) = Decimal::take(text).unwrap();
            assert_eq!(rest, "");
            Percent { decimal, span: Span::default() }
        };
        assert_eq!(percent("50").of(20), Ok(10));
        assert_eq!(percent("12.5").of(40), Ok(5));
        assert_eq!(percent("100").of(u64::MAX), Ok(u64::MAX));
        assert_eq!(percent("0").of(7), Ok(0));
        assert!(percent("33.3").of(100).is_err());
    }

    proptest! {
        #[test]
        fn anything_is_read_without_panic(text in r"([0-9]|\.|[munpf]?s| |W|[-+*/(]|é){0,24}") {
            let _ = ticks(&text, "1ns");
        }

        #[test]
        fn a_decimal_is_what_it_says(ns in 0u64..1_000_000, ps in 0u64..1000) {
            prop_assert_eq!(ticks(&format!("{ns}.{ps:03}ns"), "1ps"), Ok(ns * 1000 + ps));
        }
    }
}
