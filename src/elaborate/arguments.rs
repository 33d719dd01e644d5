//! The parameters of an element's cell, read as the element wants them.

use indexmap::IndexMap;

use super::scope::eval;
use super::{Limits, Name, ParameterValue, contents};
use crate::Value;
use crate::cell::element::{Argument, Element, Kind, Parameter};
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Span};
use crate::import::readmem::Shape;

/// What the parameters of a cell may refer to.
pub(super) struct Context<'a> {
    /// Parameters and indices.
    pub values: &'a IndexMap<String, i64>,
    pub limits: &'a Limits,
    /// The text of a file that the circuit file names.
    pub text: &'a dyn Fn(&str) -> Option<(FileId, &'a str)>,
}

/// Reads the parameters of a cell. `None` if one is faulty.
pub(super) fn read(
    element: &'static Element,
    cell: &Name,
    given: &IndexMap<Name, ParameterValue>,
    context: &Context<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Vec<(&'static str, Argument)>> {
    let mut ok = true;
    for name in given.keys() {
        if !element.parameters.iter().any(|p| p.name == name.value) {
            let names: Vec<&str> = element.parameters.iter().map(|p| p.name).collect();
            let fault = Diagnostic::new(
                Code::UnknownParameter,
                format!("`{}` has no parameter `{}`", element.name, name.value),
            )
            .at(name.span, "not a parameter")
            .did_you_mean(name, names.iter().copied());
            diagnostics.push(if names.is_empty() {
                fault.note("it has none")
            } else {
                fault.note(format!("it has {}", names.join(", ")))
            });
            ok = false;
        }
    }
    let mut read: Vec<(&'static str, Argument)> = Vec::new();
    // values depend on the width, so integers come first
    let integers_first = element.parameters.iter().filter(|p| matches!(p.kind, Kind::Integer { .. }));
    for parameter in integers_first.chain(element.parameters.iter().filter(|p| !matches!(p.kind, Kind::Integer { .. })))
    {
        let integer = |name: &str| {
            read.iter().find_map(|(n, a)| match a {
                Argument::Integer(w) if *n == name => Some(*w as u32),
                _ => None,
            })
        };
        let width = integer("width");
        let argument = match (given.get(parameter.name), parameter.default) {
            (given, _) if parameter.kind == Kind::Contents => {
                let shape = Shape { width: width.unwrap_or(1), size: integer("words").unwrap_or(1), offset: 0 };
                let place = given.map_or(cell.span, |g| g.span);
                contents::read(shape, given, place, context, diagnostics).map(Argument::Contents)
            }
            (Some(value), _) => argument(parameter, value, width.unwrap_or(1), context, diagnostics),
            (None, Some(default)) => {
                Some(of_text(parameter.kind, default, width.unwrap_or(1)).expect("defaults are valid"))
            }
            (None, None) => {
                let message = format!("`{}` needs the parameter `{}`", element.name, parameter.name);
                diagnostics.push(
                    Diagnostic::new(Code::BadParameter, message)
                        .at(cell.span, format!("`{}` is missing", parameter.name))
                        .note(format!("`{}`: {}", parameter.name, parameter.doc))
                        .help(format!("add it: \"parameters\": {{ \"{}\": … }}", parameter.name)),
                );
                None
            }
        };
        match argument {
            Some(argument) => read.push((parameter.name, argument)),
            None => ok = false,
        }
    }
    ok.then_some(read)
}

fn argument(
    parameter: &Parameter,
    given: &ParameterValue,
    width: u32,
    context: &Context<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Argument> {
    let (values, most_bits) = (context.values, context.limits.width);
    let text = given.word();
    let fault = |message: String, span: Span| Diagnostic::new(Code::BadParameter, message).at(span, "");
    match parameter.kind {
        Kind::Integer { min, max } => {
            let n = match given.expr() {
                Ok(expr) => eval(&expr, values, diagnostics)?,
                Err(d) => {
                    diagnostics.push(d);
                    return None;
                }
            };
            if parameter.kind == Kind::WIDTH && u64::try_from(n).is_ok_and(|n| n > most_bits) {
                diagnostics.push(
                    Diagnostic::new(
                        Code::TooLarge,
                        format!("`{}` is {n}, the limit of a width is {most_bits}", parameter.name),
                    )
                    .at(given.span, format!("this is {n}"))
                    .help("if you need that, raise the limit: `--limit width=BITS`"),
                );
                return None;
            }
            if !(min..=max).contains(&n) {
                let bounds = if max == i64::MAX { format!("{min} or more") } else { format!("from {min} to {max}") };
                diagnostics.push(fault(format!("`{}` must be {bounds}, not {n}", parameter.name), given.span));
                return None;
            }
            Some(Argument::Integer(n))
        }
        Kind::Word(words) => {
            let word = text.unwrap_or_default();
            if words.contains(&word) {
                return Some(Argument::Word(word.to_owned()));
            }
            let words_shown: Vec<String> = words.iter().map(|w| format!("`{w}`")).collect();
            let message =
                format!("`{}` must be {}, not `{}`", parameter.name, words_shown.join(" or "), given.value.as_text());
            let fault = fault(message, given.span);
            diagnostics.push(fault.did_you_mean(word, words.iter().copied()));
            None
        }
        Kind::Value => value(parameter.name, given, width, context, diagnostics).map(Argument::Value),
        Kind::Contents => unreachable!("contents are read with the number of their words"),
        Kind::Quantity => {
            let number = given.value.as_text();
            // what names a parameter is an expression; `1k` and `2u` do not
            let mut words = number.split(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | '$')));
            let quantity = if words.any(|word| values.contains_key(word)) {
                let n = match given.expr() {
                    Ok(expr) => eval(&expr, values, diagnostics)?,
                    Err(d) => {
                        diagnostics.push(d);
                        return None;
                    }
                };
                of_text(Kind::Quantity, &n.to_string(), width)
            } else {
                of_text(Kind::Quantity, &number, width)
            };
            let help = "write a positive number, with an SI prefix if need be: 10k, 4.7n, 100p, or an expression";
            quantity
                .map_err(|e| diagnostics.push(fault(format!("`{}`: {e}", parameter.name), given.span).help(help)))
                .ok()
        }
    }
}

/// A value of `width` bits.
pub(super) fn value(
    name: &str,
    given: &ParameterValue,
    width: u32,
    context: &Context<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Value> {
    let literal = given.word().filter(|t| t.contains('\'') || matches!(*t, "x" | "z" | "all-ones"));
    let value = match literal {
        Some("all-ones") => Ok(Value::repeat(crate::Logic::One, width)),
        Some(text) => Value::for_width(text, width),
        None => {
            let n = match given.expr() {
                Ok(expr) => eval(&expr, context.values, diagnostics)?,
                Err(d) => {
                    diagnostics.push(d);
                    return None;
                }
            };
            Value::for_width(&n.to_string(), width)
        }
    };
    let fault = |e| Diagnostic::new(Code::BadParameter, format!("`{name}`: {e}")).at(given.span, "");
    value.map_err(|e| diagnostics.push(fault(e))).ok()
}

fn of_text(kind: Kind, text: &str, width: u32) -> Result<Argument, String> {
    match kind {
        Kind::Integer { .. } => text.parse().map(Argument::Integer).map_err(|e: std::num::ParseIntError| e.to_string()),
        Kind::Word(_) => Ok(Argument::Word(text.to_owned())),
        Kind::Value if text == "all-ones" => Ok(Argument::Value(Value::repeat(crate::Logic::One, width))),
        Kind::Value => Value::for_width(text, width).map(Argument::Value).map_err(|e| e.to_string()),
        Kind::Contents => unreachable!("contents have no text"),
        Kind::Quantity => {
            quantity(text).map(Argument::Quantity).ok_or_else(|| format!("`{text}` is not a positive quantity"))
        }
    }
}

/// A positive number with an SI prefix.
fn quantity(text: &str) -> Option<f64> {
    const PREFIXES: &[(char, &str)] = &[
        ('f', "e-15"),
        ('p', "e-12"),
        ('n', "e-9"),
        ('u', "e-6"),
        ('µ', "e-6"),
        ('m', "e-3"),
        ('k', "e3"),
        ('M', "e6"),
        ('G', "e9"),
    ];
    let text = text.trim();
    let scaled = PREFIXES.iter().find_map(|&(c, power)| Some(format!("{}{power}", text.strip_suffix(c)?.trim_end())));
    // the prefix goes into the text so that 100p is the number nearest to 100e-12
    let number: f64 = scaled.as_deref().unwrap_or(text).parse().ok()?;
    (number.is_finite() && number > 0.0).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::quantity;

    #[test]
    fn quantities() {
        assert_eq!(quantity("10k"), Some(10e3));
        assert_eq!(quantity("4.7 n"), Some(4.7e-9));
        assert_eq!(quantity("100p"), Some(100e-12));
        assert_eq!(quantity("0.5"), Some(0.5));
        assert_eq!(quantity("1e-9"), Some(1e-9));
        for wrong in ["", "k", "-1", "0", "nan", "inf", "1kk", "1e3k"] {
            assert_eq!(quantity(wrong), None, "{wrong}");
        }
    }
}
