//! Names and texts of files, made safe to show: nothing in them moves a terminal's cursor, sets its colours or title, or
//! turns the order of letters around.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character is shown as it is: no control character (C1 among them), nothing that changes the direction of
/// what stands around it.
#[must_use]
pub fn is_plain(c: char) -> bool {
    !(c.is_control()
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'))
}

/// A name on one line: each character that is not plain as its number (`\u{1b}`).
#[must_use]
pub fn name(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// A text of lines, which ends lines and has tabs as it likes.
#[must_use]
pub fn text(text: &str) -> Cow<'_, str> {
    escaped(text, |c| matches!(c, '\n' | '\t'))
}

/// JSON as it was written, on several lines or one: what is not plain as JSON escapes it.
#[must_use]
pub fn json(text: &str) -> Cow<'_, str> {
    let plain = |c: char| is_plain(c) || c == '\n';
    if text.chars().all(plain) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match plain(c) {
            true => safe.push(c),
            // all of them have one unit of UTF-16
            false => _ = write!(safe, "\\u{:04x}", u32::from(c)),
        }
    }
    Cow::Owned(safe)
}

fn escaped(text: &str, stays: fn(char) -> bool) -> Cow<'_, str> {
    let plain = |c: char| is_plain(c) || stays(c);
    if text.chars().all(plain) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match plain(c) {
            true => safe.push(c),
            false => _ = write!(safe, "{}", c.escape_unicode()),
        }
    }
    Cow::Owned(safe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_acts_on_is_written_out() {
        assert_eq!(name("a\u{1b}[31mb\u{9b}2J\u{7}\r\n\t"), "a\\u{1b}[31mb\\u{9b}2J\\u{7}\\u{d}\\u{a}\\u{9}");
        assert_eq!(name("\u{202e}txt"), "\\u{202e}txt");
        assert_eq!(json("[\"\u{9b}\",\n1]"), "[\"\\u009b\",\n1]");
        assert_eq!(text("a\n\tb\u{1b}"), "a\n\tb\\u{1b}");
        assert!(matches!(name("größe[3] 中 \u{200d}"), Cow::Borrowed(_)));
    }
}
