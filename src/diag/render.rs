//! A diagnostic as text for a person (by `annotate-snippets`) and as JSON for a machine.

use std::ops::Range;

use annotate_snippets::{Annotation, AnnotationKind, Element, Group, Level, Renderer, Snippet};
use serde_json::{Value, json};

use super::{Diagnostic, FileId, Label, Severity, Sources, Span};

/// A line with more bytes than this is shown only around the place.
const LONG_LINE: usize = 160;
/// Characters shown on either side of a place in a long line.
const AROUND: usize = 60;
/// Places of one file further apart than this many lines are shown apart.
const FAR_APART: usize = 200;

pub(super) fn render(diagnostic: &Diagnostic, sources: &Sources, color: bool) -> String {
    let level = match diagnostic.severity() {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(clean(&diagnostic.message)).id(diagnostic.code.as_str());
    let mut elements: Vec<Element<'_>> = Vec::new();
    let mut headers = Vec::new();
    for (file, labels) in by_file(&diagnostic.labels) {
        snippets(&mut elements, &mut headers, sources, file, &labels);
    }
    for note in &diagnostic.notes {
        elements.push(Level::NOTE.message(clean(note)).into());
    }
    for help in &diagnostic.helps {
        elements.push(Level::HELP.message(clean(help)).into());
    }
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    let mut text = renderer.render(&[Group::with_title(title).elements(elements)]);
    for (rendered, real) in headers {
        text = text.replacen(&rendered, &real, 1);
    }
    text.push('\n');
    text
}

/// The labels of each file; the file of the fault first, its primary label first.
fn by_file(labels: &[Label]) -> Vec<(FileId, Vec<&Label>)> {
    let mut files: Vec<(FileId, Vec<&Label>)> = Vec::new();
    for label in labels.iter().filter(|l| l.primary).chain(labels.iter().filter(|l| !l.primary)) {
        match files.iter_mut().find(|(file, _)| *file == label.span.file) {
            Some((_, list)) => list.push(label),
            None => files.push((label.span.file, vec![label])),
        }
    }
    files
}

/// Adds what shows `labels`, all of `file`. The renderer counts columns in what it is given, so for cut lines the place
/// that it will write and the real one go to `headers`.
fn snippets<'a>(
    elements: &mut Vec<Element<'a>>,
    headers: &mut Vec<(String, String)>,
    sources: &'a Sources,
    file: FileId,
    labels: &[&'a Label],
) {
    let name = clean(sources.name(file));
    let line_of = |l: &&Label| sources.line_col(l.span).0;
    let first = labels.iter().map(line_of).min().unwrap_or(1);
    let last = labels.iter().map(line_of).max().unwrap_or(1);
    let whole =
        last - first <= FAR_APART && labels.iter().all(|l| sources.line_range(file, line_of(l)).len() <= LONG_LINE);
    if whole {
        let start = sources.line_range(file, first).start;
        let end = sources.line_range(file, last).end;
        let annotations = labels.iter().map(|l| {
            let range = on_one_line(sources, l.span);
            annotation(l, range.start - start..range.end - start)
        });
        let snippet = Snippet::source(&sources.text(file)[start..end]);
        elements.push(snippet.path(name).line_start(first).annotations(annotations).into());
        return;
    }
    for label in labels {
        let (line, column) = sources.line_col(label.span);
        let (text, range) = cut_line(sources, label.span, line);
        let mark = format!("\u{e000}{}\u{e000}", headers.len());
        let cut_column = text[..range.start].chars().count() + 1;
        headers.push((format!("{mark}:{line}:{cut_column}"), format!("{name}:{line}:{column}")));
        elements.push(Snippet::source(text).path(mark).line_start(line).annotation(annotation(label, range)).into());
    }
}

fn annotation(label: &Label, range: Range<usize>) -> Annotation<'_> {
    let kind = if label.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
    let text = (!label.text.is_empty()).then(|| clean(&label.text));
    kind.span(range).label(text)
}

/// A place that goes over several lines is shown on its first one.
fn on_one_line(sources: &Sources, span: Span) -> Range<usize> {
    let range = sources.range(span);
    let line = sources.line_range(span.file, sources.line_col(span).0);
    range.start.min(line.end)..range.end.min(line.end)
}

/// The line of a place, cut around it if it is long, and the place in the cut line.
fn cut_line(sources: &Sources, span: Span, line: usize) -> (String, Range<usize>) {
    let text = sources.text(span.file);
    let whole = sources.line_range(span.file, line);
    let range = on_one_line(sources, span);
    let before = &text[whole.start..range.start];
    let after = &text[range.start..whole.end];
    let from = before.char_indices().rev().nth(AROUND - 1).map_or(0, |(i, _)| i);
    let to = after.char_indices().nth(AROUND).map_or(after.len(), |(i, _)| i);
    let mut cut = String::new();
    if from > 0 {
        cut.push('…');
    }
    cut.push_str(&before[from..]);
    let start = cut.len();
    cut.push_str(&after[..to]);
    let end = start + (range.end - range.start).min(to);
    if to < after.len() {
        cut.push('…');
    }
    (cut, start..end)
}

/// Text that may come from a file, made safe for a terminal: control characters are shown as escapes, and very long
/// text is cut.
fn clean(text: &str) -> String {
    const LONGEST: usize = 2000;
    let mut out = String::with_capacity(text.len().min(LONGEST));
    for c in text.chars() {
        if out.len() > LONGEST {
            out.push('…');
            break;
        }
        match c {
            '\n' => out.push('\n'),
            c if crate::safe::is_plain(c) => out.push(c),
            c => out.extend(c.escape_unicode()),
        }
    }
    out
}

pub(super) fn to_json(diagnostic: &Diagnostic, sources: &Sources) -> Value {
    let mut object = json!({
        "code": diagnostic.code.as_str(),
        "severity": diagnostic.severity().as_str(),
        "message": diagnostic.message,
        "labels": diagnostic.labels.iter().map(|l| {
            let mut label = place(sources, l.span);
            label["text"] = json!(l.text);
            label["primary"] = json!(l.primary);
            label
        }).collect::<Vec<_>>(),
        "notes": diagnostic.notes,
        "helps": diagnostic.helps,
    });
    if let (Some(span), Value::Object(fields)) = (diagnostic.place(), &mut object)
        && let Value::Object(place) = place(sources, span)
    {
        fields.extend(place);
    }
    object
}

fn place(sources: &Sources, span: Span) -> Value {
    let (line, column) = sources.line_col(span);
    let (end_line, end_column) = sources.line_col(Span { start: span.end, ..span });
    json!({
        "file": sources.name(span.file),
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Code;
    use super::*;

    fn find(sources: &Sources, file: FileId, what: &str) -> Span {
        let start = sources.text(file).find(what).unwrap() as u32;
        Span::new(file, start, start + what.len() as u32)
    }

    #[test]
    fn looks_like_rustc() {
        let mut sources = Sources::new();
        let file = sources.add("a.json", "{\n  \"b\": 1,\n\t\"é\": 2,\n  \"b\": 3\n}\n".to_owned());
        let second = Span::new(file, 24, 27);
        let text = Diagnostic::new(Code::DuplicateKey, "`b` is given twice")
            .at(second, "again here")
            .also(find(&sources, file, "\"b\""), "first here")
            .note("one of them would be lost")
            .help("remove one of them")
            .render(&sources, false);
        let expected = "\
error[duplicate-key]: `b` is given twice
 --> a.json:4:3
  |
2 |   \"b\": 1,
  |   --- first here
3 |     \"é\": 2,
4 |   \"b\": 3
  |   ^^^ again here
  |
  = note: one of them would be lost
  = help: remove one of them
";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_gigantic_line_is_cut_around_the_place() {
        let mut sources = Sources::new();
        let long = format!("{}ab\tcd{}", "é".repeat(100_000), "x".repeat(100_000));
        let file = sources.add("min.json", long);
        let span = find(&sources, file, "cd");
        let text = Diagnostic::new(Code::BadValue, "no").at(span, "here").render(&sources, false);
        let shown = format!("…{}ab    cd{}…", "é".repeat(57), "x".repeat(58));
        let under = format!("{}^^ here", " ".repeat(64));
        assert_eq!(text, format!("error[bad-value]: no\n --> min.json:1:100004\n  |\n1 | {shown}\n  | {under}\n"));
    }

    #[test]
    fn places_far_apart_and_in_two_files() {
        let mut sources = Sources::new();
        let a = sources.add("a.json", format!("first{}second", "\n".repeat(1000)));
        let b = sources.add("b.json", "other".to_owned());
        let text = Diagnostic::new(Code::SeveralDrivers, "two")
            .at(find(&sources, a, "second"), "s")
            .also(find(&sources, a, "first"), "f")
            .also(find(&sources, b, "other"), "o")
            .render(&sources, false);
        for place in ["a.json:1001:1", "a.json:1:1", "b.json:1:1"] {
            assert!(text.contains(place), "{text}");
        }
    }

    #[test]
    fn without_a_place_there_is_still_a_message() {
        let fault = Diagnostic::new(Code::CannotRead, "cannot read `x\u{1b}[31m`").help("look");
        let text = fault.render(&Sources::new(), false);
        assert_eq!(text, "error[cannot-read]: cannot read `x\\u{1b}[31m`\n |\n = help: look\n");
    }

    #[test]
    fn for_machines() {
        let mut sources = Sources::new();
        let file = sources.add("a.json", "é\nabc".to_owned());
        let fault = Diagnostic::new(Code::UnusedNet, "m").at(Span::new(file, 3, 6), "t").help("h");
        let json = fault.to_json(&sources);
        assert_eq!(json["severity"], "warning");
        assert_eq!((&json["line"], &json["column"]), (&json!(2), &json!(1)));
        assert_eq!((&json["end_line"], &json["end_column"]), (&json!(2), &json!(4)));
        assert_eq!(json["labels"][0]["text"], "t");
    }

    proptest! {
        #[test]
        fn rendering_never_panics(
            text in "[a\u{1b}é\t\r\n\0“💥\u{200d}]{0,400}",
            places in prop::collection::vec((0u32..500, 0u32..500, any::<bool>()), 0..5),
        ) {
            let mut sources = Sources::new();
            let file = sources.add("f\u{1b}", text);
            let mut fault = Diagnostic::new(Code::BadValue, "m");
            for (start, end, primary) in places {
                fault.labels.push(Label { span: Span::new(file, start, end), text: "l".into(), primary });
            }
            let rendered = fault.render(&sources, false);
            prop_assert!(!rendered.contains(0x1b as char), "an escape character");
            prop_assert!(fault.to_json(&sources).is_object());
        }
    }
}
