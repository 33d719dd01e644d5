//! The words of a text file one by one, with the lines on which they stand.

use std::io::{self, Read};
use std::ops::Range;

/// How much is read at a time.
const CHUNK: usize = 1 << 16;

/// Words parted by white space. None is longer than the file, and no more is kept than a word and a chunk.
pub(super) struct Tokens<R> {
    input: R,
    buffer: Vec<u8>,
    /// What of the buffer is yet to come.
    rest: Range<usize>,
    /// The line of the last word, from 1.
    pub line: u64,
    /// The file ended right behind the last word, without the end of a line.
    pub unfinished: bool,
}

impl<R: Read> Tokens<R> {
    pub fn new(input: R) -> Tokens<R> {
        Tokens { input, buffer: vec![0; CHUNK], rest: 0..0, line: 1, unfinished: false }
    }

    /// Reads more behind what is yet to come; false at the end of the file.
    fn more(&mut self) -> io::Result<bool> {
        if self.rest.start > 0 {
            self.buffer.copy_within(self.rest.clone(), 0);
            self.rest = 0..self.rest.len();
        }
        if self.buffer.len() < self.rest.end + CHUNK {
            self.buffer.resize(2 * self.rest.end + CHUNK, 0);
        }
        loop {
            match self.input.read(&mut self.buffer[self.rest.end..]) {
                Ok(n) => {
                    self.rest.end += n;
                    return Ok(n > 0);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The next word, if there is one.
    pub fn next(&mut self) -> io::Result<Option<&[u8]>> {
        loop {
            let rest = &self.buffer[self.rest.clone()];
            let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
            let (mut skipped, mut lines) = (0, 0);
            for byte in blank {
                skipped += 1;
                lines += u64::from(*byte == b'\n');
            }
            self.line += lines;
            self.rest.start += skipped;
            if !self.rest.is_empty() {
                break;
            }
            if !self.more()? {
                return Ok(None);
            }
        }
        let mut length = 0;
        loop {
            let word = &self.buffer[self.rest.clone()];
            match word[length..].iter().position(u8::is_ascii_whitespace) {
                Some(end) => {
                    length += end;
                    break;
                }
                None => length = word.len(),
            }
            if !self.more()? {
                self.unfinished = true;
                break;
            }
        }
        let start = self.rest.start;
        self.rest.start += length;
        Ok(Some(&self.buffer[start..start + length]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a few bytes at a time.
    struct Slow<'a>(&'a [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            let n = self.1.min(self.0.len()).min(to.len());
            to[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    #[test]
    fn words_and_their_lines() {
        let long = "x".repeat(3 * CHUNK);
        let text = format!("\n one\ttwo\r\n\n{long} three\n\n\nlast");
        for pace in [1, 2, 3, 1000, 1 << 20] {
            let mut tokens = Tokens::new(Slow(text.as_bytes(), pace));
            let mut words = Vec::new();
            while let Some(word) = tokens.next().unwrap() {
                let word = String::from_utf8(word.to_vec()).unwrap();
                words.push((tokens.line, word, tokens.unfinished));
            }
            let word = |line, text: &str, unfinished| (line, text.to_owned(), unfinished);
            let expected = [
                word(2, "one", false),
                word(2, "two", false),
                word(4, &long, false),
                word(4, "three", false),
                word(7, "last", true),
            ];
            assert_eq!(words, expected, "{pace}");
        }
        let mut tokens = Tokens::new(&b"end\n"[..]);
        assert_eq!(tokens.next().unwrap(), Some(&b"end"[..]));
        assert_eq!(tokens.next().unwrap(), None);
        assert!(!tokens.unfinished);
    }
}
