//! Signals: what a port is connected to, as written in a file.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::Name;
use super::expr::Expr;
use super::expr_parser::Parser;
use crate::Value;
use crate::diag::{Code, Diagnostic, Span};
use crate::json::{self, Spanned};

/// What a port is connected to.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal {
    /// `"a"`: a whole net or port.
    Name {
        /// The net; its place is that of the signal.
        name: Name,
        /// Where the signal stands.
        span: Span,
    },
    /// `"a[3]"`: one bit.
    Select {
        /// The net.
        name: Name,
        /// Which bit.
        index: Expr,
        /// Where the signal stands.
        span: Span,
    },
    /// `"a[7:4]"`: several bits.
    Slice {
        /// The net.
        name: Name,
        /// The highest bit.
        hi: Expr,
        /// The lowest bit.
        lo: Expr,
        /// Where the signal stands.
        span: Span,
    },
    /// `"4'b10x1"`: a constant with its width.
    Constant(Constant),
    /// `"8{a}"`: a signal several times.
    Repeat {
        /// How many times.
        count: Expr,
        /// What.
        of: Box<Signal>,
        /// Where the signal stands.
        span: Span,
    },
    /// `["a", "b[0]"]`: signals side by side, the most significant first.
    Concat {
        /// The signals; none for `[]`.
        parts: Vec<Signal>,
        /// Where the signal stands.
        span: Span,
    },
    /// `5`: a constant as wide as the port.
    Number {
        /// The number; negative ones are in two's complement.
        value: i64,
        /// Where the signal stands.
        span: Span,
    },
}

/// A constant such as `4'b10x1` or `(W+1)'d3`, whose size may be an expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// The width in bits.
    pub size: Expr,
    /// The base and the digits, e.g. `b10x1`.
    pub digits: String,
    /// Where it stands.
    pub span: Span,
}

impl Constant {
    /// Its value, once `size` is known (the value of [`Constant::size`], in bits).
    ///
    /// # Errors
    /// If the size is not positive or too large, or the digits do not fit it.
    pub fn constant(&self, size: i64) -> Result<Value, Diagnostic> {
        if size <= 0 {
            return Err(Diagnostic::new(Code::BadValue, format!("a constant has a width of {size} bits"))
                .at(self.size.span(), "this must be 1 or more"));
        }
        format!("{size}'{}", self.digits)
            .parse()
            .map_err(|e| Diagnostic::new(Code::BadValue, format!("{e}")).at(self.span, "not a value"))
    }
}

impl Signal {
    /// Reads `text`, which stands at `span`.
    ///
    /// # Errors
    /// A fault that points into the text.
    pub fn parse(text: &str, span: Span) -> Result<Signal, Diagnostic> {
        let mut parser = Parser::new(text, span, Code::BadSignal);
        let signal = signal(&mut parser, 0)?;
        parser.skip_space();
        match parser.rest().chars().next() {
            None => Ok(signal),
            Some(',') => {
                Err(parser.unexpected("unexpected `,`").help("a concatenation is a JSON array: [\"a\", \"b\"]"))
            }
            Some('[') => Err(parser.unexpected("unexpected `[`").help("a selection has no further selection")),
            Some('.') => Err(parser.unexpected("unexpected `.`").help(
                "a signal is a net or port of this module; nets inside of cells are reached through their ports",
            )),
            Some(_) => Err(parser.unexpected("expected the end of the signal")),
        }
    }

    /// Where it stands.
    #[must_use]
    pub fn span(&self) -> Span {
        match self {
            Signal::Constant(c) => c.span,
            Signal::Name { span, .. }
            | Signal::Select { span, .. }
            | Signal::Slice { span, .. }
            | Signal::Repeat { span, .. }
            | Signal::Concat { span, .. }
            | Signal::Number { span, .. } => *span,
        }
    }
}

/// How many repetitions may be inside one another.
const MAX_REPEATS: usize = 32;

fn signal(p: &mut Parser<'_>, depth: usize) -> Result<Signal, Diagnostic> {
    p.skip_space();
    let start = p.at;
    let place = |p: &Parser<'_>, start: usize| p.span.within(p.text, start..p.at);
    if p.rest().is_empty() {
        return Err(match p.text.trim().is_empty() {
            true => p.fault(0, p.text.len(), "a signal is missing").help("an output that is not used can be left out"),
            false => p.fault(p.at, p.at, "a signal ends too early"),
        });
    }
    let Some(c) = p.rest().chars().next().filter(|&c| c.is_ascii_alphanumeric() || c == '_' || c == '(') else {
        let fault = p.unexpected("a signal begins with a name, a number or `(`");
        return Err(match p.rest().chars().next() {
            Some('~' | '!' | '-') => fault.help("a `not` cell inverts; a signal only connects"),
            Some('\'') => fault.help("a constant needs a width, e.g. `4'd3`"),
            Some('{') => fault.help("a concatenation is a JSON array: [\"a\", \"b\"]"),
            _ => fault,
        });
    };
    if let Some(name) = p.name() {
        let name = Spanned::new(name.to_owned(), place(p, start));
        if p.take("[") {
            let hi = p.expression()?;
            let hi = Expr::part(p.text, p.span, hi);
            if p.take(":") {
                let lo = p.expression()?;
                let lo = Expr::part(p.text, p.span, lo);
                p.expect("]")?;
                return Ok(Signal::Slice { name, hi, lo, span: place(p, start) });
            }
            p.expect("]")?;
            return Ok(Signal::Select { name, index: hi, span: place(p, start) });
        }
        if !p.rest().starts_with(['\'', '{', '(']) {
            return Ok(Signal::Name { span: name.span, name });
        }
        p.at = start;
    }
    let size = p.primary()?;
    let size = Expr::part(p.text, p.span, size);
    if p.take("'") {
        let digits = digits(p, start)?;
        return Ok(Signal::Constant(Constant { size, digits, span: place(p, start) }));
    }
    if p.take("{") {
        if depth >= MAX_REPEATS {
            return Err(p.fault(start, p.at, format!("more than {MAX_REPEATS} repetitions inside one another")));
        }
        let of = Box::new(signal(p, depth + 1)?);
        p.skip_space();
        if p.rest().starts_with(',') {
            return Err(p.unexpected("unexpected `,`").help("a concatenation is a JSON array: [\"a\", \"b\"]"));
        }
        p.expect("}")?;
        return Ok(Signal::Repeat { count: size, of, span: place(p, start) });
    }
    let fault = p.fault(start, p.at, format!("`{}` is not a signal", &p.text[start..p.at]));
    Err(match c {
        '0'..='9' => {
            let text = &p.text[start..p.at];
            fault.help(format!("write the number without quotes, {text}, or with a width, `4'd{text}`"))
        }
        _ => fault.help("a constant is written `(W)'d0`, a repetition `(W){a}`"),
    })
}

/// The base and digits of a constant.
fn digits(p: &mut Parser<'_>, start: usize) -> Result<String, Diagnostic> {
    let rest = p.rest();
    let length =
        rest.bytes().position(|b| !(b.is_ascii_alphanumeric() || b == b'_' || b == b'?')).unwrap_or(rest.len());
    let digits = rest[..length].to_ascii_lowercase();
    p.at += length;
    let allowed = match digits.trim_start_matches('s').chars().next() {
        Some('b') => "01xz?_",
        Some('o') => "01234567xz?_",
        Some('d') => "0123456789xz?_",
        Some('h') => "0123456789abcdefxz?_",
        _ => {
            return Err(p
                .fault(start, p.at, "a constant needs a base after the quote")
                .help("`b`, `o`, `d` or `h`: `4'b10x1`, `8'hff`"));
        }
    };
    let after_base = digits.find(|c| c != 's').unwrap_or(0) + 1;
    if digits[after_base..].trim_matches('_').is_empty() {
        return Err(p.fault(start, p.at, "a constant has no digits"));
    }
    match digits[after_base..].find(|c| !allowed.contains(c)) {
        Some(wrong) => {
            let at = p.at - length + after_base + wrong;
            let c = &digits[after_base + wrong..][..1];
            Err(p.fault(at, at + 1, format!("`{c}` is not a digit of this base")))
        }
        None => Ok(digits),
    }
}

/// As a signal is written in JSON.
#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind a signal (a string, an integer or an array)", rename_all = "lowercase")]
enum Written {
    Integer(i64),
    String(String),
    Array(Parts),
}

#[derive(Deserialize)]
struct Parts(#[serde(deserialize_with = "json::every")] Vec<Signal>);

impl<'de> Deserialize<'de> for Signal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Spanned { value, span } = Spanned::<Written>::deserialize(deserializer)?;
        match value {
            Written::Integer(value) => Ok(Signal::Number { value, span }),
            Written::String(text) => Signal::parse(&text, span).map_err(json::fault),
            Written::Array(Parts(parts)) => Ok(Signal::Concat { parts, span }),
        }
    }
}

impl JsonSchema for Signal {
    fn schema_name() -> Cow<'static, str> {
        "Signal".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let part = generator.subschema_for::<Signal>();
        json_schema!({
            "description": "What a port is connected to: a net `a`, a bit `a[3]`, a slice `a[7:4]`, a constant \
                            `4'b10x1`, a repetition `8{a}`, a number as wide as the port, or an array of signals: a \
                            concatenation, the most significant first.",
            "anyOf": [
                { "type": "string", "minLength": 1 },
                { "type": "integer" },
                { "type": "array", "items": part }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::diag::FileId;
    use crate::syntax::expr::Names;

    fn parse(text: &str) -> Result<Signal, Diagnostic> {
        Signal::parse(text, Span::new(FileId(0), 0, text.len() as u32))
    }

    /// What was read, written out, with the place of every part.
    fn read(text: &str) -> String {
        let at = |span: Span| &text[span.start as usize..span.end as usize];
        fn show(signal: &Signal, at: &dyn Fn(Span) -> String) -> String {
            match signal {
                Signal::Name { name, span } => format!("net {} {}", at(name.span), at(*span)),
                Signal::Select { name, index, span } => {
                    format!("bit {} of {name}, {} {}", at(index.span()), at(name.span), at(*span))
                }
                Signal::Slice { name, hi, lo, span } => {
                    format!("bits {} to {} of {name}, {}", at(hi.span()), at(lo.span()), at(*span))
                }
                Signal::Constant(c) => format!("{} bits {}, {}", at(c.size.span()), c.digits, at(c.span)),
                Signal::Repeat { count, of, span } => {
                    format!("{} times ({}), {}", at(count.span()), show(of, at), at(*span))
                }
                Signal::Concat { .. } | Signal::Number { .. } => unreachable!(),
            }
        }
        match parse(text) {
            Ok(signal) => show(&signal, &|span| at(span).to_owned()),
            Err(d) => format!("`{}`: {}", at(d.place().unwrap()), d.message),
        }
    }

    #[test]
    fn what_is_written() {
        for (text, expected) in [
            ("a", "net a a"),
            (" a_1$ ", "net a_1$ a_1$"),
            ("a[3]", "bit 3 of a, a a[3]"),
            ("a[i + 1]", "bit i + 1 of a, a a[i + 1]"),
            ("a[7:4]", "bits 7 to 4 of a, a[7:4]"),
            ("a[c ? 1 : 2 : 0]", "bits c ? 1 : 2 to 0 of a, a[c ? 1 : 2 : 0]"),
            ("4'b10x1", "4 bits b10x1, 4'b10x1"),
            ("8'hFf", "8 bits hff, 8'hFf"),
            ("W'd0", "W bits d0, W'd0"),
            ("(W+1)'b1x0", "(W+1) bits b1x0, (W+1)'b1x0"),
            ("8{a}", "8 times (net a a), 8{a}"),
            ("W{a[0]}", "W times (bit 0 of a, a a[0]), W{a[0]}"),
            ("(W+1){ 2{1'b0} }", "(W+1) times (2 times (1 bits b0, 1'b0), 2{1'b0}), (W+1){ 2{1'b0} }"),
            ("clog2(W)'d0", "clog2(W) bits d0, clog2(W)'d0"),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn faults() {
        for (text, expected) in [
            ("", "``: a signal is missing"),
            ("~a", "`~`: a signal begins with a name, a number or `(`"),
            ("5", "`5`: `5` is not a signal"),
            ("(a)", "`(a)`: `(a)` is not a signal"),
            ("a[", "``: an expression ends too early"),
            ("a[1", "``: expected `]`"),
            ("a[1:]", "`]`: unexpected `]`"),
            ("a[1][0]", "`[`: unexpected `[`"),
            ("a b", "`b`: expected the end of the signal"),
            ("a.b", "`.`: unexpected `.`"),
            ("a, b", "`,`: unexpected `,`"),
            ("{a, b}", "`{`: a signal begins with a name, a number or `(`"),
            ("2{a, b}", "`,`: unexpected `,`"),
            ("2{a", "``: expected `}`"),
            ("2{}", "`}`: a signal begins with a name, a number or `(`"),
            ("4'10", "`4'10`: a constant needs a base after the quote"),
            ("4'b", "`4'b`: a constant has no digits"),
            ("4'b12", "`2`: `2` is not a digit of this base"),
            ("4'hg", "`g`: `g` is not a digit of this base"),
            ("'b1", "`'`: a signal begins with a name, a number or `(`"),
            ("é", "`é`: a signal begins with a name, a number or `(`"),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn constants_have_values() {
        let Ok(Signal::Constant(c)) = parse("W'b1x0") else { panic!() };
        assert_eq!(c.constant(4).unwrap().bit_string(), "01x0");
        assert_eq!(c.constant(2).unwrap_err().message, "'2'b1x0' has more than 2 bits");
        assert_eq!(c.constant(0).unwrap_err().message, "a constant has a width of 0 bits");
        assert_eq!(c.constant(-1).unwrap_err().code, Code::BadValue);
        assert!(c.constant(i64::MAX).is_err());
    }

    #[test]
    fn deep_signals_end_in_an_error() {
        for text in ["1{".repeat(100_000), "(".repeat(100_000), "a[".repeat(100_000)] {
            assert!(parse(&text).is_err());
        }
    }

    proptest! {
        #[test]
        fn anything_is_read_without_panic(text in r"(\[|\]|[a-z]|[0-9]|'[bodhs]|[{}():,é?~_ -]){0,24}") {
            match parse(&text) {
                Ok(Signal::Constant(c)) => {
                    if let Ok(size) = c.size.eval(&()) {
                        prop_assert!(c.constant(size).is_err() || size > 0);
                    }
                }
                Ok(Signal::Select { index, .. }) => prop_assert!(index.eval(&()).is_ok() || ().all().is_empty()),
                _ => {}
            }
        }
    }
}
