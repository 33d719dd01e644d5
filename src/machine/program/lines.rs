//! A text line by line in bounded memory, whatever its size: a line has a greatest length, and a text has no control
//! characters.

use std::io::{self, BufRead};

/// The longest line, bytes. LinuxCNC takes 255; machine-made programs are wider at times.
pub const LONGEST: usize = 65_536;

/// Why reading stops.
#[derive(Debug)]
pub enum Broken {
    /// The file cannot be read.
    Io(io::Error),
    /// A line is longer than [`LONGEST`].
    Long,
    /// A control character: its column from 0, and its code.
    Binary(usize, u8),
}

/// The lines of a text that end with LF, CR LF or CR.
#[derive(Debug)]
pub struct Lines<R> {
    from: R,
    line: Vec<u8>,
    number: u64,
    bytes: u64,
    after_cr: bool,
}

impl<R: BufRead> Lines<R> {
    /// Begins at line 1.
    pub const fn new(from: R) -> Self {
        Lines { from, line: Vec::new(), number: 0, bytes: 0, after_cr: false }
    }

    /// The number of the present line, from 1.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// The present line without its end.
    pub fn text(&self) -> &[u8] {
        &self.line
    }

    /// Bytes read so far.
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Goes on to the next line; false behind the last one.
    ///
    /// # Errors
    /// What cannot be read, is too long, or is no text. The present line is then what was read of it.
    pub fn advance(&mut self) -> Result<bool, Broken> {
        self.line.clear();
        let mut any = false;
        loop {
            let chunk = match self.from.fill_buf() {
                Ok(chunk) => chunk,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(Broken::Io(error)),
            };
            if chunk.is_empty() {
                self.number += u64::from(any);
                return if any { self.check().map(|()| true) } else { Ok(false) };
            }
            let skip = usize::from(self.after_cr && chunk[0] == b'\n');
            self.after_cr = false;
            let rest = &chunk[skip..];
            let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
            let part = &rest[..end.unwrap_or(rest.len())];
            let room = LONGEST + 1 - self.line.len();
            self.line.extend_from_slice(&part[..part.len().min(room)]);
            any |= !rest.is_empty();
            let long = self.line.len() > LONGEST;
            self.after_cr = end.is_some_and(|at| rest[at] == b'\r');
            let used = skip + part.len() + usize::from(end.is_some());
            self.from.consume(used);
            self.bytes += used as u64;
            if long || end.is_some() {
                self.number += 1;
                self.check()?;
                return if long { Err(Broken::Long) } else { Ok(true) };
            }
        }
    }

    /// A mark of UTF-8 at the beginning and one of the end of a file (DOS) are left out; no other control characters but tabs
    /// are text.
    fn check(&mut self) -> Result<(), Broken> {
        if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
            self.line.drain(..3);
        }
        if self.line.last() == Some(&0x1a) {
            self.line.pop();
        }
        match self.line.iter().position(|&b| (b < 0x20 && b != b'\t') || b == 0x7f) {
            Some(at) => Err(Broken::Binary(at, self.line[at])),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8], chunk: usize) -> Vec<String> {
        let mut lines = Lines::new(io::BufReader::with_capacity(chunk, text));
        let mut all = Vec::new();
        while lines.advance().unwrap() {
            all.push(String::from_utf8_lossy(lines.text()).into_owned());
        }
        assert_eq!((lines.number(), lines.bytes()), (all.len() as u64, text.len() as u64));
        all
    }

    #[test]
    fn every_kind_of_line_end_in_chunks_of_any_size() {
        for chunk in 1..9 {
            assert_eq!(all(b"a\nb\r\n\rc\r\r\nd", chunk), ["a", "b", "", "c", "", "d"], "{chunk}");
            assert_eq!(all(b"\xef\xbb\xbfa\n\x1a", chunk), ["a", ""]);
            assert_eq!(all(b"", chunk), [""; 0]);
            assert_eq!(all(b"\r\n", chunk), [""]);
        }
    }

    #[test]
    fn a_gigantic_line_is_not_kept() {
        struct Endless;
        impl io::Read for Endless {
            fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
                to.fill(b'G');
                Ok(to.len())
            }
        }
        let mut lines = Lines::new(io::BufReader::new(Endless));
        assert!(matches!(lines.advance(), Err(Broken::Long)));
        assert!(lines.text().len() <= LONGEST + 1);
    }

    #[test]
    fn what_is_no_text_is_told_with_its_place() {
        let mut lines = Lines::new(&b"G0\nX\x001"[..]);
        assert!(lines.advance().unwrap());
        assert!(matches!(lines.advance(), Err(Broken::Binary(1, 0))));
        assert_eq!(lines.number(), 2);
    }
}
