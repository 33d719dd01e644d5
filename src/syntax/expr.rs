//! Integer expressions: parameters, widths, indices, counts.
//!
//! [`Expr`] keeps its syntax tree and its place; [`Expr::eval`] computes it with the parameters and indices that
//! [`Names`] gives. The grammar is in `docs/format.md`.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::expr_parser::Parser;
use crate::diag::{Code, Diagnostic, Span};
use crate::json::{self, Spanned};

/// The parameters and indices that an expression may use.
pub trait Names {
    /// The value of a name.
    fn get(&self, name: &str) -> Option<i64>;

    /// All names, for hints.
    fn all(&self) -> Vec<&str>;
}

/// No names at all.
impl Names for () {
    fn get(&self, _: &str) -> Option<i64> {
        None
    }

    fn all(&self) -> Vec<&str> {
        Vec::new()
    }
}

impl Names for IndexMap<String, i64> {
    fn get(&self, name: &str) -> Option<i64> {
        IndexMap::get(self, name).copied()
    }

    fn all(&self) -> Vec<&str> {
        self.keys().map(String::as_str).collect()
    }
}

/// An expression as it stands in a file. Small, and cheap to clone.
#[derive(Clone, PartialEq)]
pub struct Expr(Arc<Written>);

#[derive(PartialEq)]
struct Written {
    root: Node,
    /// As it was written.
    text: Box<str>,
    span: Span,
}

/// A part of an expression and where it stands in the text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) kind: Kind,
    /// Bytes of the text.
    pub(super) range: (u32, u32),
    /// How deep the tree is from here; bounded, so that walking it cannot overflow the stack.
    pub(super) depth: u16,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    Number(i64),
    Name(String),
    Negate(Box<Node>),
    Not(Box<Node>),
    Binary(Op, Box<Node>, Box<Node>),
    Choose(Box<Node>, Box<Node>, Box<Node>),
    Clog2(Box<Node>),
    Min(Box<Node>, Box<Node>),
    Max(Box<Node>, Box<Node>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Op {
    Or,
    And,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    Shl,
    Shr,
    Add,
    Sub,
    Mul,
    Div,
    Rem,
}

impl Expr {
    /// Reads `text`, which stands at `span`.
    ///
    /// # Errors
    /// A fault that points into the text.
    pub fn parse(text: &str, span: Span) -> Result<Expr, Diagnostic> {
        let mut parser = Parser::new(text, span, Code::BadExpression);
        let root = parser.expression()?;
        parser.end()?;
        Ok(Expr::new(root, text, span))
    }

    fn new(root: Node, text: &str, span: Span) -> Expr {
        Expr(Arc::new(Written { root, text: text.into(), span }))
    }

    /// A part of a longer text that stands at `span`.
    pub(super) fn part(text: &str, span: Span, mut root: Node) -> Expr {
        let (start, end) = (root.range.0 as usize, root.range.1 as usize);
        let place = span.within(text, start..end);
        root.shift(root.range.0);
        Expr::new(root, &text[start..end], place)
    }

    /// A number.
    #[must_use]
    pub fn number(value: i64, span: Span) -> Expr {
        let text = value.to_string();
        let root = Node { kind: Kind::Number(value), range: (0, text.len() as u32), depth: 0 };
        Expr::new(root, &text, span)
    }

    /// Where it stands.
    #[must_use]
    pub fn span(&self) -> Span {
        self.0.span
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.text
    }

    /// Its value if it is a mere number.
    #[must_use]
    pub fn as_number(&self) -> Option<i64> {
        match self.0.root.kind {
            Kind::Number(n) => Some(n),
            _ => None,
        }
    }

    /// The name if it is a mere name.
    #[must_use]
    pub fn as_name(&self) -> Option<&str> {
        match &self.0.root.kind {
            Kind::Name(name) => Some(name),
            _ => None,
        }
    }

    /// The names that it uses, each once.
    pub(crate) fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.0.root.names(&mut names);
        names
    }

    /// Its value.
    ///
    /// # Errors
    /// If it uses an unknown name, overflows 64 bits, divides by zero or shifts by less than 0 or more than 63; the
    /// fault points at the part that fails.
    pub fn eval(&self, names: &dyn Names) -> Result<i64, Diagnostic> {
        Evaluation { expr: &self.0, names }.node(&self.0.root)
    }
}

impl fmt::Debug for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0.text, f)
    }
}

impl fmt::Display for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.text)
    }
}

impl Node {
    fn names<'n>(&'n self, names: &mut Vec<&'n str>) {
        match &self.kind {
            Kind::Number(_) => {}
            Kind::Name(name) => {
                if !names.contains(&name.as_str()) {
                    names.push(name);
                }
            }
            Kind::Negate(a) | Kind::Not(a) | Kind::Clog2(a) => a.names(names),
            Kind::Binary(_, a, b) | Kind::Min(a, b) | Kind::Max(a, b) => {
                a.names(names);
                b.names(names);
            }
            Kind::Choose(a, b, c) => {
                a.names(names);
                b.names(names);
                c.names(names);
            }
        }
    }

    fn shift(&mut self, by: u32) {
        self.range = (self.range.0 - by, self.range.1 - by);
        match &mut self.kind {
            Kind::Number(_) | Kind::Name(_) => {}
            Kind::Negate(a) | Kind::Not(a) | Kind::Clog2(a) => a.shift(by),
            Kind::Binary(_, a, b) | Kind::Min(a, b) | Kind::Max(a, b) => {
                a.shift(by);
                b.shift(by);
            }
            Kind::Choose(a, b, c) => {
                a.shift(by);
                b.shift(by);
                c.shift(by);
            }
        }
    }
}

struct Evaluation<'a> {
    expr: &'a Written,
    names: &'a dyn Names,
}

impl Evaluation<'_> {
    fn place(&self, node: &Node) -> Span {
        self.expr.span.within(&self.expr.text, node.range.0 as usize..node.range.1 as usize)
    }

    fn fault(&self, node: &Node, message: impl Into<String>, label: impl Into<String>) -> Diagnostic {
        Diagnostic::new(Code::BadExpression, message).at(self.place(node), label)
    }

    fn overflow(&self, node: &Node, what: &str) -> Diagnostic {
        self.fault(node, "an expression overflows 64 bits", what)
    }

    fn node(&self, node: &Node) -> Result<i64, Diagnostic> {
        match &node.kind {
            Kind::Number(n) => Ok(*n),
            Kind::Name(name) => self.names.get(name).ok_or_else(|| {
                let known = self.names.all();
                let fault = Diagnostic::new(Code::UnknownParameter, format!("unknown name `{name}` in an expression"))
                    .at(self.place(node), "neither a parameter nor an index here")
                    .did_you_mean(name, known.iter().copied());
                if !fault.helps.is_empty() || known.is_empty() {
                    return fault;
                }
                let shown: Vec<String> = known.iter().take(8).map(|n| format!("`{n}`")).collect();
                fault.note(format!("the names here are {}", shown.join(", ")))
            }),
            Kind::Negate(a) => {
                let a = self.node(a)?;
                a.checked_neg().ok_or_else(|| self.overflow(node, &format!("-({a})")))
            }
            Kind::Not(a) => Ok(i64::from(self.node(a)? == 0)),
            Kind::Binary(op, a, b) => self.binary(node, *op, a, b),
            Kind::Choose(condition, a, b) => self.node(if self.node(condition)? != 0 { a } else { b }),
            Kind::Clog2(a) => match self.node(a)? {
                n if n < 0 => Err(self.fault(a, "clog2 of a negative number", format!("this is {n}"))),
                n if n <= 1 => Ok(0),
                n => Ok(i64::from(64 - (n - 1).leading_zeros())),
            },
            Kind::Min(a, b) => Ok(self.node(a)?.min(self.node(b)?)),
            Kind::Max(a, b) => Ok(self.node(a)?.max(self.node(b)?)),
        }
    }

    fn binary(&self, node: &Node, op: Op, left: &Node, right: &Node) -> Result<i64, Diagnostic> {
        let a = self.node(left)?;
        // The right side is not computed if the left one decides: `W > 0 && 8 / W > 1`.
        match op {
            Op::Or if a != 0 => return Ok(1),
            Op::And if a == 0 => return Ok(0),
            _ => {}
        }
        let b = self.node(right)?;
        if matches!(op, Op::Div | Op::Rem) && b == 0 {
            let fault = self.fault(node, "an expression divides by zero", "");
            return Err(fault.also(self.place(right), "this is 0"));
        }
        if matches!(op, Op::Shl | Op::Shr) && !(0..64).contains(&b) {
            return Err(self.fault(right, "a shift must be by 0 to 63", format!("this is {b}")));
        }
        let (result, sign) = match op {
            Op::Or | Op::And => (Some(i64::from(b != 0)), ""),
            Op::Eq => (Some(i64::from(a == b)), ""),
            Op::Ne => (Some(i64::from(a != b)), ""),
            Op::Lt => (Some(i64::from(a < b)), ""),
            Op::Le => (Some(i64::from(a <= b)), ""),
            Op::Gt => (Some(i64::from(a > b)), ""),
            Op::Ge => (Some(i64::from(a >= b)), ""),
            Op::Shl => (i64::try_from(i128::from(a) << b).ok(), "<<"),
            Op::Shr => (Some(a >> b), ""),
            Op::Add => (a.checked_add(b), "+"),
            Op::Sub => (a.checked_sub(b), "-"),
            Op::Mul => (a.checked_mul(b), "*"),
            Op::Div => (a.checked_div(b), "/"),
            Op::Rem => (a.checked_rem(b), "%"),
        };
        result.ok_or_else(|| self.overflow(node, &format!("{a} {sign} {b}")))
    }
}

/// As an expression is written in JSON.
#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind an integer or an expression", rename_all = "lowercase")]
enum Form {
    Integer(i64),
    String(String),
}

impl<'de> Deserialize<'de> for Expr {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Spanned { value, span } = Spanned::<Form>::deserialize(deserializer)?;
        match value {
            Form::Integer(n) => Ok(Expr::number(n, span)),
            Form::String(text) => Expr::parse(&text, span).map_err(json::fault),
        }
    }
}

impl JsonSchema for Expr {
    fn schema_name() -> Cow<'static, str> {
        "Expression".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An integer, or an expression such as `W+1`, `clog2(N)`, `W > 1 ? 2 : 1`.",
            "type": ["integer", "string"],
            "minLength": 1
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::diag::FileId;

    fn names() -> IndexMap<String, i64> {
        [("W", 8), ("width", 4), ("zero", 0), ("big", i64::MAX)].map(|(n, v)| (n.to_owned(), v)).into()
    }

    /// The value, or `start..end: message` with the place counted from the text's start.
    fn eval(text: &str) -> String {
        let span = Span::new(FileId(0), 1000, 1000 + text.len() as u32);
        let result = Expr::parse(text, span).and_then(|e| e.eval(&names()));
        result.map_or_else(
            |d| {
                let place = d.place().unwrap();
                format!("{}..{}: {}", place.start - 1000, place.end - 1000, d.message)
            },
            |n| n.to_string(),
        )
    }

    #[test]
    fn values() {
        for (text, value) in [
            ("1", 1),
            (" W + 1 ", 9),
            ("W-1-1", 6),
            ("2*W+1", 17),
            ("1+2*W", 17),
            ("-W", -8),
            ("--W", 8),
            ("-7/2", -3),
            ("-7%2", -1),
            ("7%-2", 1),
            ("1 << W", 256),
            ("2 << W - 1", 256),
            ("-8 >> 1", -4),
            ("-1 << 63", i64::MIN),
            ("-9223372036854775808", i64::MIN),
            ("W == 8", 1),
            ("W != 8", 0),
            ("1 < 2 == 1", 1),
            ("1 << 2 < 5", 1),
            ("W >= 8 && W <= 8", 1),
            ("0 || 5", 1),
            ("1 || 0 && 0", 1),
            ("!W", 0),
            ("!0", 1),
            ("W > 4 ? 10 : 20", 10),
            ("0 ? 1 : 0 ? 2 : 3", 3),
            ("zero == 0 ? 1 : 8 / zero", 1),
            ("zero && 8 / zero", 0),
            ("1 || 8 / zero", 1),
            ("clog2(0)", 0),
            ("clog2(1)", 0),
            ("clog2(2)", 1),
            ("clog2(3)", 2),
            ("clog2(256)", 8),
            ("clog2(257)", 9),
            ("clog2(big)", 63),
            ("min(W, 3) + max(W, 3)", 11),
            ("((W))", 8),
        ] {
            assert_eq!(eval(text), value.to_string(), "{text}");
        }
    }

    #[test]
    fn faults_point_at_the_part() {
        for (text, fault) in [
            ("1 + w", "4..5: unknown name `w` in an expression"),
            ("2 * (W / zero)", "4..14: an expression divides by zero"),
            ("1 + W % zero", "4..12: an expression divides by zero"),
            ("1 + (big + 1)", "4..13: an expression overflows 64 bits"),
            ("-(-big - 1)", "0..11: an expression overflows 64 bits"),
            ("(-big - 1) / -1", "0..15: an expression overflows 64 bits"),
            ("1 << 63", "0..7: an expression overflows 64 bits"),
            ("1 << 64", "5..7: a shift must be by 0 to 63"),
            ("1 >> -1", "5..7: a shift must be by 0 to 63"),
            ("clog2(-1)", "6..8: clog2 of a negative number"),
            ("9223372036854775808", "0..19: a number must fit 64 bits"),
            ("", "0..0: an expression is missing"),
            ("1 +", "3..3: an expression ends too early"),
            ("(1", "2..2: expected `)`"),
            ("1 2", "2..3: expected an operator or the end of the expression"),
            ("W = 8", "2..3: unexpected `=`"),
            ("é", "0..2: unexpected `é`"),
            ("8é", "1..3: unexpected `é`"),
            ("clog(2)", "0..4: unknown function `clog`"),
            ("min(2)", "5..6: expected `,`"),
            ("1 ? 2", "5..5: expected `:`"),
            ("0x10", "1..4: expected an operator or the end of the expression"),
        ] {
            assert_eq!(eval(text), fault, "{text}");
        }
    }

    #[test]
    fn hints() {
        let e = Expr::parse("widht", Span::default()).unwrap();
        assert_eq!(e.eval(&names()).unwrap_err().helps, ["did you mean `width`?"]);
        let e = Expr::parse("clog(2)", Span::default()).unwrap_err();
        assert_eq!(e.helps, ["did you mean `clog2`?"]);
    }

    #[test]
    fn deep_expressions_end_in_an_error() {
        for text in ["(".repeat(100_000), "-".repeat(100_000), "1+".repeat(100_000), "1?".repeat(100_000)] {
            assert!(eval(&text).contains("too deep"), "{}", eval(&text));
        }
        assert!(eval(&"min(1,".repeat(100_000)).contains("too deep"));
        assert_eq!(eval(&format!("{}1{}", "(".repeat(40), ")".repeat(40))), "1");
        assert_eq!(eval(&vec!["1"; 200].join("+")), "200");
    }

    proptest! {
        #[test]
        fn anything_is_read_and_computed_without_panic(text in r"([-+*/%<>=!&|?:() ]|W|zero|big|[0-9]|clog2|min|max|,|é|\$){0,30}") {
            eval(&text);
        }

        #[test]
        fn sums_and_products_are_those_of_rust(a in -99i64..99, b in -99i64..99, c in 1i64..99) {
            prop_assert_eq!(eval(&format!("{a} - {b} * {c}")), (a - b * c).to_string());
            prop_assert_eq!(eval(&format!("({a} + {b}) / {c} % 7")), ((a + b) / c % 7).to_string());
            prop_assert_eq!(eval(&format!("{a} < {b} ? {a} : {b}")), a.min(b).to_string());
        }
    }
}
