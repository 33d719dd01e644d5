//! Reads expressions, alone or as parts of signals.

use super::expr::{Kind, Node, Op};
use crate::diag::{Code, Diagnostic, Span};

/// How many operators may be inside one another, those of a chain `a + b + c` counted.
const MAX_DEPTH: u16 = 256;
/// How many parentheses, signs and choices may be inside one another.
const MAX_NESTING: u16 = 64;

/// Whether a name can be used in files: a letter or `_`, then letters, digits, `_` or `$`.
#[must_use]
pub fn is_name(text: &str) -> bool {
    name_length(text) == text.len() && !text.is_empty()
}

/// How many bytes at the start of `text` are a name.
fn name_length(text: &str) -> usize {
    match text.as_bytes().first() {
        Some(b) if b.is_ascii_alphabetic() || *b == b'_' => {}
        _ => return 0,
    }
    text.bytes().position(|b| !(b.is_ascii_alphanumeric() || b == b'_' || b == b'$')).unwrap_or(text.len())
}

/// Each level of precedence, the loosest first, with its operators (longer ones before those they begin with).
const LEVELS: [&[(&str, Op)]; 7] = [
    &[("||", Op::Or)],
    &[("&&", Op::And)],
    &[("==", Op::Eq), ("!=", Op::Ne)],
    &[("<=", Op::Le), (">=", Op::Ge), ("<", Op::Lt), (">", Op::Gt)],
    &[("<<", Op::Shl), (">>", Op::Shr)],
    &[("+", Op::Add), ("-", Op::Sub)],
    &[("*", Op::Mul), ("/", Op::Div), ("%", Op::Rem)],
];

/// A place in a text that is being read.
pub(super) struct Parser<'a> {
    pub(super) text: &'a str,
    /// Where the text stands.
    pub(super) span: Span,
    pub(super) at: usize,
    /// What faults are called.
    code: Code,
    depth: u16,
}

impl<'a> Parser<'a> {
    pub(super) fn new(text: &'a str, span: Span, code: Code) -> Parser<'a> {
        Parser { text, span, at: 0, code, depth: 0 }
    }

    pub(super) fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    pub(super) fn skip_space(&mut self) {
        self.at = self.text.len() - self.rest().trim_start_matches([' ', '\t', '\n', '\r']).len();
    }

    pub(super) fn fault(&self, start: usize, end: usize, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.code, message).at(self.span.within(self.text, start..end), "")
    }

    /// Takes `token` if it is next.
    pub(super) fn take(&mut self, token: &str) -> bool {
        self.skip_space();
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    pub(super) fn expect(&mut self, token: &str) -> Result<(), Diagnostic> {
        if self.take(token) { Ok(()) } else { Err(self.unexpected(&format!("expected `{token}`"))) }
    }

    /// A fault at the next word, number or character.
    pub(super) fn unexpected(&self, message: &str) -> Diagnostic {
        let rest = self.rest();
        let word = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let length = if word > 0 { word } else { rest.chars().next().map_or(0, char::len_utf8) };
        self.fault(self.at, self.at + length, message)
    }

    /// The next name, if there is one.
    pub(super) fn name(&mut self) -> Option<&'a str> {
        self.skip_space();
        let name = &self.rest()[..name_length(self.rest())];
        self.at += name.len();
        (!name.is_empty()).then_some(name)
    }

    pub(super) fn end(&mut self) -> Result<(), Diagnostic> {
        self.skip_space();
        match self.rest().chars().next() {
            None => Ok(()),
            Some(c) if c.is_ascii_alphanumeric() || "_()".contains(c) => {
                let fault = self.unexpected("expected an operator or the end of the expression");
                let after_zero = self.text[..self.at].ends_with('0') && "xXbBoO".contains(c);
                Err(if after_zero { fault.help("numbers are decimal") } else { fault })
            }
            Some(c) => {
                let fault = self.unexpected(&format!("unexpected `{c}`"));
                Err(match c {
                    '=' => fault.help("equality is written `==`"),
                    '&' | '|' => fault.help(format!("and, or are written `&&`, `||`, not `{c}`")),
                    _ => fault,
                })
            }
        }
    }

    pub(super) fn expression(&mut self) -> Result<Node, Diagnostic> {
        let condition = self.binary(0)?;
        if !self.take("?") {
            return Ok(condition);
        }
        self.deeper()?;
        let a = self.expression()?;
        self.expect(":")?;
        let b = self.expression()?;
        self.depth -= 1;
        let range = (condition.range.0, b.range.1);
        let depth = condition.depth.max(a.depth).max(b.depth);
        self.node(Kind::Choose(Box::new(condition), Box::new(a), Box::new(b)), range, depth)
    }

    fn deeper(&mut self) -> Result<(), Diagnostic> {
        self.depth += 1;
        if self.depth > MAX_NESTING { Err(self.too_deep(self.at)) } else { Ok(()) }
    }

    fn too_deep(&self, at: usize) -> Diagnostic {
        self.fault(at, at + 1, "an expression is too deep").help("compute parts of it in parameters of their own")
    }

    fn node(&self, kind: Kind, range: (u32, u32), below: u16) -> Result<Node, Diagnostic> {
        if below >= MAX_DEPTH {
            return Err(self.too_deep(range.0 as usize));
        }
        Ok(Node { kind, range, depth: below + 1 })
    }

    fn binary(&mut self, level: usize) -> Result<Node, Diagnostic> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some(op) = self.operator(operators) {
            let right = self.binary(level + 1)?;
            let (range, depth) = ((left.range.0, right.range.1), left.depth.max(right.depth));
            left = self.node(Kind::Binary(op, Box::new(left), Box::new(right)), range, depth)?;
        }
        Ok(left)
    }

    fn operator(&mut self, operators: &[(&str, Op)]) -> Option<Op> {
        self.skip_space();
        let rest = self.rest();
        // `<` is not the start of `<<`.
        let shift = rest.starts_with("<<") || rest.starts_with(">>");
        let &(token, op) = operators.iter().find(|(token, _)| rest.starts_with(token))?;
        if shift && token.len() == 1 {
            return None;
        }
        self.at += token.len();
        Some(op)
    }

    fn unary(&mut self) -> Result<Node, Diagnostic> {
        self.skip_space();
        let start = self.at;
        let rest = self.rest();
        if rest.starts_with('-') && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
            return self.primary();
        }
        let make: fn(Box<Node>) -> Kind = if rest.starts_with('-') {
            Kind::Negate
        } else if rest.starts_with('!') {
            Kind::Not
        } else {
            return self.primary();
        };
        self.at += 1;
        self.deeper()?;
        let operand = self.unary()?;
        self.depth -= 1;
        let (range, depth) = ((start as u32, operand.range.1), operand.depth);
        self.node(make(Box::new(operand)), range, depth)
    }

    /// A number, a name, a call or an expression in parentheses.
    pub(super) fn primary(&mut self) -> Result<Node, Diagnostic> {
        self.skip_space();
        let start = self.at;
        let rest = self.rest();
        if rest.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
            return self.number();
        }
        if let Some(name) = self.name() {
            let end = self.at;
            if self.take("(") {
                return self.call(name, start, end);
            }
            self.at = end;
            return self.node(Kind::Name(name.to_owned()), (start as u32, end as u32), 0);
        }
        if self.take("(") {
            self.deeper()?;
            let inner = self.expression()?;
            self.expect(")")?;
            self.depth -= 1;
            return Ok(Node { range: (start as u32, self.at as u32), ..inner });
        }
        match rest.chars().next() {
            Some(c) => {
                let fault = self.unexpected(&format!("unexpected `{c}`"));
                let power = c == '*' && self.text[..self.at].ends_with('*');
                Err(if power { fault.help("there are no powers; 2 to the n is `1 << n`") } else { fault })
            }
            None if self.text.trim().is_empty() => Err(self.fault(0, self.at, "an expression is missing")),
            None => Err(self.fault(self.at, self.at, "an expression ends too early")),
        }
    }

    fn number(&mut self) -> Result<Node, Diagnostic> {
        let start = self.at;
        let rest = self.rest();
        let sign = usize::from(rest.starts_with('-'));
        let digits = rest[sign..].bytes().position(|b| !b.is_ascii_digit()).unwrap_or(rest.len() - sign);
        self.at += sign + digits;
        let range = (start as u32, self.at as u32);
        match self.text[start..self.at].parse() {
            Ok(n) => self.node(Kind::Number(n), range, 0),
            Err(_) => Err(self.fault(start, self.at, "a number must fit 64 bits")),
        }
    }

    fn call(&mut self, name: &str, start: usize, end: usize) -> Result<Node, Diagnostic> {
        const FUNCTIONS: [&str; 3] = ["clog2", "max", "min"];
        if !FUNCTIONS.contains(&name) {
            return Err(self
                .fault(start, end, format!("unknown function `{name}`"))
                .did_you_mean(name, FUNCTIONS)
                .note("the functions are `clog2(n)`, `min(a, b)` and `max(a, b)`"));
        }
        self.deeper()?;
        let first = self.expression()?;
        let mut depth = first.depth;
        let first = Box::new(first);
        let kind = if name == "clog2" {
            Kind::Clog2(first)
        } else {
            self.expect(",")?;
            let second = self.expression()?;
            depth = depth.max(second.depth);
            let make = if name == "min" { Kind::Min } else { Kind::Max };
            make(first, Box::new(second))
        };
        self.expect(")")?;
        self.depth -= 1;
        self.node(kind, (start as u32, self.at as u32), depth)
    }
}
