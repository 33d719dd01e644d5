//! The texts that diagnostics point into.

use serde::{Deserialize, Serialize};

/// One text held by [`Sources`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct FileId(pub u32);

/// A place: bytes `start..end` of one text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Span {
    /// The text.
    pub file: FileId,
    /// The first byte.
    pub start: u32,
    /// The byte after the last one.
    pub end: u32,
}

impl Span {
    /// Bytes `start..end` of `file`.
    #[must_use]
    pub const fn new(file: FileId, start: u32, end: u32) -> Span {
        Span { file, start, end }
    }

    /// Bytes `range` counted from the start of this place, cut off at its end.
    #[must_use]
    #[allow(clippy::should_implement_trait)] // Takes a part; nothing is subtracted.
    pub fn sub(self, range: std::ops::Range<usize>) -> Span {
        let at = |offset: usize| {
            let offset = u32::try_from(offset).unwrap_or(u32::MAX);
            self.start.saturating_add(offset).min(self.end)
        };
        Span { file: self.file, start: at(range.start), end: at(range.end.max(range.start)) }
    }

    /// The place of `text[range]`, where `text` was read from this place. If it does not stand there letter by letter
    /// (it was written with escapes), the whole place.
    #[must_use]
    pub fn within(self, text: &str, range: std::ops::Range<usize>) -> Span {
        if (self.end - self.start) as usize == text.len() { self.sub(range) } else { self }
    }

    /// From the start of this place to the end of `other`, in the same text.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

#[derive(Debug)]
struct Source {
    name: String,
    text: String,
    /// The number of its first line.
    first_line: usize,
    /// The offset at which each line starts.
    lines: Vec<u32>,
    /// How many characters start before each multiple of [`STEP`] bytes, so that a column far along a gigantic line is
    /// found without counting all of it.
    characters: Vec<u32>,
}

const STEP: usize = 4096;

impl Source {
    fn characters_before(&self, at: usize) -> usize {
        let step = (at / STEP).min(self.characters.len() - 1);
        let rest = &self.text.as_bytes()[step * STEP..at];
        self.characters[step] as usize + rest.iter().filter(|&&b| starts_character(b)).count()
    }
}

/// Whether a byte of UTF-8 is the first one of a character.
fn starts_character(byte: u8) -> bool {
    byte & 0xc0 != 0x80
}

/// All texts that were read, and how they are called.
#[derive(Debug, Default)]
pub struct Sources {
    files: Vec<Source>,
    /// Texts that a tool made of others, and how to find what a place in them was made of.
    made: Vec<(FileId, Locate)>,
}

/// Finds what a place in a text that a tool made comes from: a file, and lines and columns in it, `cpu.v:12.3-14.8`.
pub type Locate = fn(text: &str, place: std::ops::Range<usize>) -> Option<&str>;

impl Sources {
    /// Nothing yet.
    #[must_use]
    pub fn new() -> Sources {
        Sources::default()
    }

    /// Takes a text in. Bytes from 4 GiB on cannot be pointed at.
    pub fn add(&mut self, name: impl Into<String>, text: String) -> FileId {
        self.add_excerpt(name, text, 1)
    }

    /// Takes in a part of a text that is too great to be kept: the lines from `first_line` (from 1) on.
    pub fn add_excerpt(&mut self, name: impl Into<String>, text: String, first_line: usize) -> FileId {
        let newlines = text.bytes().enumerate().filter(|&(_, b)| b == b'\n');
        let starts = newlines.filter_map(|(i, _)| u32::try_from(i + 1).ok());
        let lines = std::iter::once(0).chain(starts).collect();
        let mut characters = vec![0u32];
        for step in text.as_bytes().chunks_exact(STEP) {
            let before = characters[characters.len() - 1];
            characters.push(before.saturating_add(step.iter().filter(|&&b| starts_character(b)).count() as u32));
        }
        let id = FileId(u32::try_from(self.files.len()).expect("fewer than 2^32 files"));
        self.files.push(Source { name: name.into(), text, first_line, lines, characters });
        id
    }

    /// The text of this name, if it is here; of several the first.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<FileId> {
        self.files.iter().position(|file| file.name == name).map(|i| FileId(i as u32))
    }

    /// Says that a tool made a text of others: faults in it are shown where `locate` says that they come from, if that text
    /// is here too.
    pub fn made(&mut self, file: FileId, locate: Locate) {
        self.made.push((file, locate));
    }

    /// Where a place comes from; the place itself if no tool made it.
    #[must_use]
    pub fn origin(&self, span: Span) -> Span {
        let made = self.made.iter().find(|(file, _)| *file == span.file);
        let found = made.and_then(|(_, locate)| locate(self.text(span.file), self.range(span)));
        found.and_then(|source| self.place(source)).unwrap_or(span)
    }

    /// The place that is written `cpu.v:12.3-14.8`, or its first line if it has several; of several places, separated by `|`,
    /// the first.
    #[must_use]
    pub fn place(&self, source: &str) -> Option<Span> {
        let first = source.split('|').next()?;
        let (name, rest) = first.rsplit_once(':')?;
        let file = self.find(name)?;
        let (from, to) = rest.split_once('-').unwrap_or((rest, rest));
        let number = |text: &str| {
            let (line, column) = text.split_once('.').unwrap_or((text, "0"));
            Some((line.parse::<usize>().ok()?, column.parse::<usize>().ok()?))
        };
        let ((line, column), (last, end)) = (number(from)?, number(to)?);
        if line == 0 || line > self.files[file.0 as usize].lines.len() {
            return None;
        }
        let range = self.line_range(file, line);
        let whole = &self.text(file)[range.clone()];
        let (indent, length) = (whole.len() - whole.trim_start().len(), whole.trim_end().len().max(1));
        let start = if column == 0 { indent } else { (column - 1).min(length) };
        let end = if last == line && end > column { (end - 1).min(length) } else { length };
        Some(Span::new(file, (range.start + start) as u32, (range.start + end.max(start)) as u32))
    }

    /// How the text is called, usually its path as the user gave it.
    ///
    /// # Panics
    /// If `id` is not of these sources; so do the other methods.
    #[must_use]
    pub fn name(&self, id: FileId) -> &str {
        &self.files[id.0 as usize].name
    }

    /// The text.
    #[must_use]
    pub fn text(&self, id: FileId) -> &str {
        &self.files[id.0 as usize].text
    }

    /// What stands at a place (moved to character boundaries).
    #[must_use]
    pub fn slice(&self, span: Span) -> &str {
        &self.text(span.file)[self.range(span)]
    }

    /// Line and column of the start of a place, both from 1; columns count characters.
    #[must_use]
    pub fn line_col(&self, span: Span) -> (usize, usize) {
        let source = &self.files[span.file.0 as usize];
        let start = self.range(span).start;
        let line = source.lines.partition_point(|&l| l as usize <= start);
        let line_start = source.lines[line - 1] as usize;
        (source.first_line + line - 1, source.characters_before(start) - source.characters_before(line_start) + 1)
    }

    /// The bytes of line `line`, counted as [`line_col`](Sources::line_col) does, without its line end.
    pub(super) fn line_range(&self, file: FileId, line: usize) -> std::ops::Range<usize> {
        let source = &self.files[file.0 as usize];
        let line = line - source.first_line;
        let start = source.lines[line] as usize;
        let end = source.lines.get(line + 1).map_or(source.text.len(), |&next| next as usize - 1);
        let end = if source.text[start..end].ends_with('\r') { end - 1 } else { end };
        start..end
    }

    /// The place as offsets that lie in the text and between characters.
    pub(super) fn range(&self, span: Span) -> std::ops::Range<usize> {
        let text = self.text(span.file);
        let mut start = (span.start as usize).min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let mut end = (span.end as usize).clamp(start, text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        start..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_and_in_characters() {
        let mut sources = Sources::new();
        let id = sources.add("a.json", "é\"x\r\nab\n".to_owned());
        let at = |start| sources.line_col(Span::new(id, start, start));
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(1), (1, 1), "inside of a character");
        assert_eq!(at(2), (1, 2));
        assert_eq!(at(6), (2, 1));
        assert_eq!(at(9), (3, 1));
        assert_eq!(at(99), (3, 1));
        assert_eq!(sources.line_range(id, 1), 0..4);
        assert_eq!(sources.line_range(id, 2), 6..8);
        assert_eq!(sources.line_range(id, 3), 9..9);
    }

    #[test]
    fn columns_of_a_gigantic_line() {
        let mut sources = Sources::new();
        let text = format!("a\n{}", "é".repeat(10_000));
        let id = sources.add("a.json", text);
        for n in [0, 1, 2046, 2047, 2048, 5000, 9999] {
            assert_eq!(sources.line_col(Span::new(id, 2 + 2 * n, 2 + 2 * n)), (2, n as usize + 1));
        }
    }

    #[test]
    fn an_excerpt_keeps_the_lines_numbers() {
        let mut sources = Sources::new();
        let id = sources.add_excerpt("a.nc", "ab\ncd".to_owned(), 1_000_001);
        assert_eq!(sources.line_col(Span::new(id, 1, 2)), (1_000_001, 2));
        assert_eq!(sources.line_col(Span::new(id, 4, 5)), (1_000_002, 2));
        assert_eq!(sources.line_range(id, 1_000_002), 3..5);
    }

    #[test]
    fn a_sub_place_stays_inside() {
        let span = Span::new(FileId(0), 10, 15);
        assert_eq!(span.sub(1..3), Span::new(FileId(0), 11, 13));
        assert_eq!(span.sub(4..100), Span::new(FileId(0), 14, 15));
        assert_eq!(span.sub(9..usize::MAX), Span::new(FileId(0), 15, 15));
        assert_eq!(span.within("abcde", 1..2), Span::new(FileId(0), 11, 12));
        assert_eq!(span.within("abc", 1..2), span);
    }
}
