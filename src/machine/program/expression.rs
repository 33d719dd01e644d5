//! Parameters and expressions: `#1`, `#<name>`, `[#1 + 2]`, `SIN[30]`. Sums are exact; products and quotients are rounded
//! to 16 digits behind the point, functions to 12.

use std::collections::HashMap;
use std::ops::Range;

use super::decimal::Decimal;
use super::fault::Fault;
use super::words::Cursor;

/// How deep brackets may stand in brackets.
const DEEPEST: u32 = 64;

/// The greatest number of a parameter that a program may use; those above tell of the machine.
const LAST: i64 = 5000;

/// What a parameter is called.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Name {
    /// `#5`
    Number(u32),
    /// `#<width>`, in lower case without spaces.
    Text(String),
}

/// The parameters of a program.
#[derive(Clone, Default, Debug)]
pub struct Parameters {
    values: HashMap<Name, Decimal>,
    depth: std::cell::Cell<u32>,
}

impl Parameters {
    /// Gives a parameter a value.
    pub fn set(&mut self, name: Name, value: Decimal) {
        self.values.insert(name, value);
    }

    /// The value: 0 for a number that was never set, nothing for such a name.
    fn get(&self, name: &Name) -> Option<Decimal> {
        match self.values.get(name) {
            None if matches!(name, Name::Number(_)) => Some(Decimal::ZERO),
            value => value.copied(),
        }
    }
}

/// A value in place of a number: a number, a parameter, an expression in brackets, a function; and how many digits behind
/// the point it was written with.
pub fn value(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<(Decimal, u32), Fault> {
    let mut ahead = c.clone();
    let negative = ahead.take(b'-');
    if !negative {
        ahead.take(b'+');
    }
    match ahead.peek() {
        Some(b'#' | b'[' | b'A'..=b'Z') => {
            let value = nested(&mut ahead, parameters)?;
            *c = ahead;
            Ok((if negative { -value } else { value }, Decimal::WRITTEN))
        }
        _ => c.number(),
    }
}

/// One level deeper: a parameter, brackets or a function.
fn nested(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<Decimal, Fault> {
    let start = c.at();
    let depth = parameters.depth.get() + 1;
    if depth > DEEPEST {
        return Err(c
            .fault(start, format!("more than {DEEPEST} brackets within each other"))
            .help("compute parts of it in lines before: #1 = [...]"));
    }
    parameters.depth.set(depth);
    let value = deeper(c, parameters);
    parameters.depth.set(depth - 1);
    value
}

fn deeper(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<Decimal, Fault> {
    if c.take(b'#') {
        let start = c.at() - 1;
        let name = name(c, parameters)?;
        return parameters.get(&name).ok_or_else(|| {
            c.fault(start, "this parameter has no value yet").help("give it one in a line above: #<name> = 2.5")
        });
    }
    if c.peek() == Some(b'[') {
        return brackets(c, parameters);
    }
    function(c, parameters)
}

/// What a parameter is called, behind its `#`.
pub fn name(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<Name, Fault> {
    c.peek();
    let start = c.at();
    if c.take(b'<') {
        let mut text = String::new();
        loop {
            match c.next() {
                Some(b'>') if !text.is_empty() => return Ok(Name::Text(text)),
                Some(b @ (b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'-')) => text.push(char::from(b.to_ascii_lowercase())),
                _ => {
                    return Err(c
                        .fault(start, "a name stands between < and >, of letters, digits, _ and -")
                        .help("such as #<depth>"));
                }
            }
        }
    }
    let (value, _) = value(c, parameters)?;
    match value.to_whole() {
        Some(n @ 1..=LAST) => Ok(Name::Number(n as u32)),
        _ => Err(c
            .fault(start, format!("there is no parameter {value}"))
            .help(format!("numbers are 1 to {LAST}; those above describe the machine, which is not simulated"))),
    }
}

/// The operators from the loosest to the tightest.
const OPERATORS: [&[&str]; 5] =
    [&["AND", "OR", "XOR"], &["EQ", "NE", "GT", "GE", "LT", "LE"], &["+", "-"], &["*", "/", "MOD"], &["**"]];

fn brackets(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<Decimal, Fault> {
    let start = c.at();
    c.take(b'[');
    let value = sum(c, parameters, 0)?;
    if c.take(b']') {
        Ok(value)
    } else {
        Err(c.fault(start, "this bracket is not closed").help("put a `]` at its end"))
    }
}

/// Operands of one strength or more, from left to right.
fn sum(c: &mut Cursor<'_>, parameters: &Parameters, strength: usize) -> Result<Decimal, Fault> {
    let Some(operators) = OPERATORS.get(strength) else { return Ok(value(c, parameters)?.0) };
    c.peek();
    let start = c.at();
    let mut left = sum(c, parameters, strength + 1)?;
    while let Some(operator) = operators.iter().find(|&&o| takes(c, o)) {
        let right = sum(c, parameters, strength + 1)?;
        left = apply(operator, left, right).ok_or_else(|| impossible(c, start..c.at()))?;
    }
    Ok(left)
}

fn takes(c: &mut Cursor<'_>, operator: &str) -> bool {
    // `**` is no `*`
    let mut ahead = c.clone();
    (operator != "*" || !ahead.word("**")) && c.word(operator)
}

fn impossible(c: &Cursor<'_>, at: Range<usize>) -> Fault {
    c.fault(at.start, "this cannot be computed").help("it divides by 0, has no real value, or has more than 9 digits")
}

fn truth(holds: bool) -> Decimal {
    Decimal::whole(i64::from(holds))
}

fn apply(operator: &str, a: Decimal, b: Decimal) -> Option<Decimal> {
    let zero = Decimal::ZERO;
    Some(match operator {
        "AND" => truth(a != zero && b != zero),
        "OR" => truth(a != zero || b != zero),
        "XOR" => truth((a != zero) != (b != zero)),
        "EQ" => truth(a == b),
        "NE" => truth(a != b),
        "GT" => truth(a > b),
        "GE" => truth(a >= b),
        "LT" => truth(a < b),
        "LE" => truth(a <= b),
        "+" => a + b,
        "-" => a - b,
        "*" => a.times(b)?,
        "/" => a.over(b)?,
        // never negative, as LinuxCNC has it
        "MOD" => {
            let rest = a - a.over(b)?.floor().times(b)?;
            if rest.signum() < 0 { rest + b.abs() } else { rest }
        }
        _ => Decimal::nearest(libm::pow(a.to_f64(), b.to_f64()))?,
    })
    .filter(|v| v.abs() < Decimal::whole(1_000_000_000))
}

/// The functions of one argument.
type Function = (&'static str, fn(Decimal) -> Option<Decimal>);
const FUNCTIONS: [Function; 12] = [
    ("ABS", |v| Some(v.abs())),
    ("ACOS", |v| degrees(libm::acos(v.to_f64()))),
    ("ASIN", |v| degrees(libm::asin(v.to_f64()))),
    ("COS", |v| Decimal::nearest(libm::cos(v.to_f64().to_radians()))),
    ("EXP", |v| Decimal::nearest(libm::exp(v.to_f64()))),
    ("FIX", |v| Some(v.floor())),
    ("FUP", |v| Some(-(-v).floor())),
    ("LN", |v| Decimal::nearest(libm::log(v.to_f64()))),
    ("ROUND", |v| Some(v.round())),
    ("SIN", |v| Decimal::nearest(libm::sin(v.to_f64().to_radians()))),
    ("SQRT", |v| Decimal::nearest(v.to_f64().sqrt())),
    ("TAN", |v| Decimal::nearest(libm::tan(v.to_f64().to_radians()))),
];

fn degrees(radians: f64) -> Option<Decimal> {
    Decimal::nearest(radians.to_degrees())
}

fn function(c: &mut Cursor<'_>, parameters: &Parameters) -> Result<Decimal, Fault> {
    c.peek();
    let start = c.at();
    let argument = |c: &mut Cursor<'_>| {
        if c.peek() == Some(b'[') {
            nested(c, parameters)
        } else {
            Err(c.fault(c.at(), "the argument of a function stands in brackets").help("such as SIN[30]"))
        }
    };
    if c.word("ATAN") {
        let y = argument(c)?;
        if !c.take(b'/') {
            return Err(c.fault(start, "ATAN has two arguments").help("write ATAN[y]/[x]"));
        }
        let x = argument(c)?;
        return degrees(libm::atan2(y.to_f64(), x.to_f64())).ok_or_else(|| impossible(c, start..c.at()));
    }
    match FUNCTIONS.iter().find(|(name, _)| c.word(name)) {
        Some((_, f)) => {
            let value = argument(c)?;
            f(value).ok_or_else(|| impossible(c, start..c.at()))
        }
        None => {
            c.next();
            Err(c
                .fault(start, "a number is missing")
                .label("here begins the next word")
                .help("a word is a letter and its number, such as X12.5"))
        }
    }
}
