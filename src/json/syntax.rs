//! From text to a syntax tree, strictly as RFC 8259 has it.
//!
//! `jsonc-parser` makes the tree. It is made for lenient dialects; what its options do not switch off (other white
//! space, raw control characters in strings, deep nesting) is refused here before.

use jsonc_parser::ast::Value;
use jsonc_parser::common::Range;
use jsonc_parser::errors::{ParseError, ParseErrorKind};
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use crate::diag::{Code, Diagnostic, FileId, Span};

/// How deep arrays and objects may be nested.
pub const MAX_NESTING: usize = 128;

const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// Reads `text` as one JSON value.
pub(super) fn tree(text: &str, file: FileId) -> Result<Value<'_>, Diagnostic> {
    let scan = scan(text, file)?;
    match parse_to_ast(text, &CollectOptions::default(), &STRICT) {
        Ok(result) => result.value.ok_or_else(|| empty(text, file)),
        Err(error) => Err(explain(&error, text, file, scan.open)),
    }
}

fn empty(text: &str, file: FileId) -> Diagnostic {
    let end = text.len() as u32;
    let what = if text.is_empty() { "the file is empty" } else { "the file has nothing but white space" };
    Diagnostic::new(Code::JsonSyntax, what)
        .at(Span::new(file, end, end), "expected `{`")
        .help("a file holds one JSON object, `{ … }`")
}

struct Scan {
    /// The innermost bracket that is still open at the end of the text.
    open: Option<usize>,
}

/// Refuses what the parser would let through. Where it meets something that the parser refuses, it leaves it at that.
fn scan(text: &str, file: FileId) -> Result<Scan, Diagnostic> {
    let place = |at: usize| {
        let length = text[at..].chars().next().map_or(0, char::len_utf8);
        Span::new(file, at as u32, (at + length) as u32)
    };
    if text.starts_with('\u{feff}') {
        return Err(Diagnostic::new(Code::JsonSyntax, "the file begins with a byte order mark")
            .at(Span::new(file, 0, 3), "three bytes that JSON does not allow here")
            .help("save the file as UTF-8 without BOM"));
    }
    let bytes = text.as_bytes();
    let mut open: Vec<usize> = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => at = end_of_string(bytes, at).map_err(|at| control_character(text, place(at), at))?,
            b'[' | b'{' => {
                if open.len() == MAX_NESTING {
                    return Err(Diagnostic::new(
                        Code::TooLarge,
                        format!("the JSON is nested more than {MAX_NESTING} deep"),
                    )
                    .at(place(at), "one too deep")
                    .help("no circuit needs that: is a bracket missing before?"));
                }
                open.push(at);
            }
            b']' | b'}' => {
                open.pop();
            }
            b' ' | b'\t' | b'\n' | b'\r' => {}
            0..=0x1f | 0x80.. => {
                let c = text[at..].chars().next().unwrap_or_default();
                return Err(Diagnostic::new(
                    Code::JsonSyntax,
                    format!("the character U+{:04X} is not allowed outside of strings", u32::from(c)),
                )
                .at(place(at), "here"));
            }
            b'\'' | b'/' => break,
            _ => {}
        }
        at += 1;
    }
    Ok(Scan { open: open.pop() })
}

/// The closing quote of the string that begins at `start` (or the last byte), or the first raw control character.
fn end_of_string(bytes: &[u8], start: usize) -> Result<usize, usize> {
    let mut at = start + 1;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return Ok(at),
            b'\\' => at += 1,
            0..=0x1f => return Err(at),
            _ => {}
        }
        at += 1;
    }
    Ok(bytes.len())
}

fn control_character(text: &str, span: Span, at: usize) -> Diagnostic {
    let byte = text.as_bytes()[at];
    let fault = Diagnostic::new(Code::JsonSyntax, "a string may not hold a raw control character");
    match byte {
        b'\n' | b'\r' => fault.at(span, "the line ends inside of a string").help("is a closing `\"` missing?"),
        b'\t' => fault.at(span, "a tab").help("write it as `\\t`"),
        _ => fault.at(span, format!("U+{byte:04X}")).help(format!("write it as `\\u{byte:04x}`")),
    }
}

/// The parser's error in our words.
fn explain(error: &ParseError, text: &str, file: FileId, open: Option<usize>) -> Diagnostic {
    use ParseErrorKind as K;
    let Range { start, end } = error.range();
    let here = Span::new(file, start as u32, end.min(text.len()) as u32);
    let fault = |message: &str| Diagnostic::new(Code::JsonSyntax, message);
    match error.kind() {
        K::UnterminatedArray | K::UnterminatedObject => {
            let (what, bracket) = match error.kind() {
                K::UnterminatedArray => ("array", ']'),
                _ => ("object", '}'),
            };
            let end = text.trim_end().len() as u32;
            let start = open.unwrap_or(start) as u32;
            fault(&format!("the file ends inside of an {what}"))
                .at(Span::new(file, end, end), format!("expected `{bracket}`"))
                .also(Span::new(file, start, start + 1), "this is never closed")
        }
        K::ExpectedComma => fault("expected `,`").at(here, "between this and what follows"),
        K::TrailingCommasNotAllowed => {
            fault("a comma before a closing bracket").at(here, "remove this").note("JSON has no trailing commas")
        }
        K::CommentsNotAllowed => {
            let end = text[start..].find('\n').map_or(text.len(), |n| start + n);
            fault("JSON has no comments")
                .at(Span::new(file, start as u32, here.end.min(end as u32)), "remove this")
                .help("a `doc` field holds free text")
        }
        K::SingleQuotedStringsNotAllowed => fault("a string is quoted by `\"`").at(here, "not by `'`"),
        K::ExpectedStringObjectProperty => fault("a field's name must be quoted by `\"`").at(here, "here"),
        K::ExpectedColonAfterObjectKey => fault("expected `:` after the name of a field").at(here, "before this"),
        K::ExpectedObjectValue => fault("expected a value after `:`").at(here, "here"),
        K::UnexpectedTokenInObject => fault("expected the name of a field, quoted by `\"`, or `}`").at(here, "here"),
        K::HexadecimalNumbersNotAllowed => fault("JSON numbers are decimal")
            .at(here, "here")
            .help("where a value is expected, a string may hold `8'hff`"),
        K::UnexpectedWord | K::UnexpectedToken if text[..start].trim_start().is_empty() => {
            fault("the file is not JSON").at(here, "expected `{`").help("a file holds one JSON object, `{ … }`")
        }
        K::UnexpectedWord | K::UnexpectedToken => fault("expected a value")
            .at(here, "this is none")
            .help("a value is a number, a \"text\", `true`, `false`, an object or an array"),
        K::MultipleRootJsonValues => fault("expected the end of the file").at(here, "something follows"),
        kind => fault(&lower_first(&kind.to_string())).at(here, "here"),
    }
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn fault(text: &str) -> String {
        match tree(text, FileId(0)) {
            Ok(_) => "ok".to_owned(),
            Err(d) => {
                let span = d.place().unwrap();
                format!("{}..{}: {}", span.start, span.end, d.message)
            }
        }
    }

    #[test]
    fn nothing_but_json_is_read() {
        assert_eq!(fault("{\"a\": [1, -2.5e3, true, null, \"\\u00e9\"]}"), "ok");
        assert_eq!(fault(""), "0..0: the file is empty");
        assert_eq!(fault(" \n"), "2..2: the file has nothing but white space");
        assert_eq!(fault("\u{feff}{}"), "0..3: the file begins with a byte order mark");
        assert_eq!(fault("{}\u{a0}"), "2..4: the character U+00A0 is not allowed outside of strings");
        assert_eq!(fault("{\u{c}}"), "1..2: the character U+000C is not allowed outside of strings");
        assert_eq!(fault("[\"a\nb\"]"), "3..4: a string may not hold a raw control character");
        assert_eq!(fault("[1,]"), "2..3: a comma before a closing bracket");
        assert_eq!(fault("[1 2]"), "2..2: expected `,`");
        assert_eq!(fault("[01]"), "2..2: expected `,`");
        assert_eq!(fault("{\"a\" 1}"), "5..6: expected `:` after the name of a field");
        assert_eq!(fault("{\"a\": }"), "6..7: unexpected close brace");
        assert_eq!(fault("{a: 1}"), "1..2: a field's name must be quoted by `\"`");
        assert_eq!(fault("{'a': 1}"), "1..2: a string is quoted by `\"`");
        assert_eq!(fault("[0x1f]"), "1..2: JSON numbers are decimal");
        assert_eq!(fault("[// x\n]"), "1..5: JSON has no comments");
        assert_eq!(fault("[yes]"), "1..4: expected a value");
        assert_eq!(fault("{} {}"), "3..4: expected the end of the file");
        for wrong in ["[+1]", "[.5]", "[1.]", "[NaN]", "[Infinity]", "[\"\\x41\"]", "[\"\\'\"]", "[\"\\ud800\"]", "{,}"]
        {
            assert_ne!(fault(wrong), "ok", "{wrong}");
        }
    }

    #[test]
    fn an_open_bracket_is_named() {
        let d = tree("{\"a\": [1, {\"b\": 2\n", FileId(0)).unwrap_err();
        assert_eq!(d.message, "the file ends inside of an object");
        assert_eq!(d.labels[0].span, Span::new(FileId(0), 17, 17));
        assert_eq!(d.labels[1].span, Span::new(FileId(0), 10, 11));
    }

    #[test]
    fn deep_nesting_is_refused_quickly() {
        let text = "[".repeat(50 << 20);
        assert_eq!(fault(&text), "128..129: the JSON is nested more than 128 deep");
        let objects = "{\"a\":".repeat(1_000_000);
        assert_eq!(fault(&objects), "640..641: the JSON is nested more than 128 deep");
        let most = format!("{}{}", "[".repeat(128), "]".repeat(128));
        assert_eq!(fault(&most), "ok");
        assert_eq!(fault(&format!("{}1{}", "{\"a\":".repeat(128), "}".repeat(128))), "ok");
        assert_eq!(fault("[\"[[[[\\\"\"]"), "ok");
    }

    proptest! {
        #[test]
        fn agrees_with_serde_json(text in r#"([\[\]{}:,"\\/' 01.eE+-]|"a"|"\\u00e9"|true|null|\t|\n|é){0,24}"#) {
            // serde_json refuses numbers that no f64 holds and is otherwise as strict as we are.
            let theirs = serde_json::from_str::<serde_json::Value>(&text);
            let ours = tree(&text, FileId(0));
            if let Err(e) = &theirs && e.to_string().contains("out of range") {
                return Ok(());
            }
            prop_assert_eq!(ours.is_ok(), theirs.is_ok(), "{:?} {:?}", text, theirs);
        }
    }
}
