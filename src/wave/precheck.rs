//! What is looked at before `wellen` is given a file: faults that it does not report, or only by a panic.
//!
//! Time that goes back (it warns on standard output and drops the changes), a file that is cut off within a line, a
//! body without anything in it, sections that reach beyond the end of an FST file.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use super::read::Fault;

/// Whether a VCD file has anything behind its header.
///
/// # Errors
/// No end of the header, time that goes back, an unfinished last line.
pub(super) fn vcd(input: &mut impl BufRead) -> Result<bool, Fault> {
    let mut scan = Scan { part: Part::Header, skipping: false, line: 1, time: None, values: false };
    let mut token = Token { text: [0; 24], len: 0 };
    loop {
        let chunk = input.fill_buf().map_err(Fault::Io)?;
        if chunk.is_empty() {
            break;
        }
        for &byte in chunk {
            if !byte.is_ascii_whitespace() {
                if let Some(free) = token.text.get_mut(token.len) {
                    *free = byte;
                }
                token.len += 1;
                continue;
            }
            if token.len > 0 {
                scan.token(&token.text[..token.len.min(token.text.len())])?;
                token.len = 0;
            }
            scan.line += u64::from(byte == b'\n');
        }
        let read = chunk.len();
        input.consume(read);
    }
    if scan.part == Part::Header || scan.part == Part::HeaderEnd {
        return Err(Fault::Cut("its header has no end (`$enddefinitions $end`)".to_owned()));
    }
    if token.len > 0 {
        return Err(Fault::Cut(format!("its last line ({}) is not complete", scan.line)));
    }
    Ok(scan.values)
}

struct Token {
    text: [u8; 24],
    /// As it was read; may be more than is kept.
    len: usize,
}

struct Scan {
    part: Part,
    /// Within free text, up to `$end`.
    skipping: bool,
    line: u64,
    time: Option<u64>,
    /// Whether there was anything in the body.
    values: bool,
}

#[derive(PartialEq)]
enum Part {
    Header,
    HeaderEnd,
    Body,
    /// A vector or a number was read, its identifier follows: that may look like a time.
    Identifier,
}

impl Scan {
    fn token(&mut self, token: &[u8]) -> Result<(), Fault> {
        if self.skipping {
            self.skipping = token != b"$end";
            return Ok(());
        }
        match self.part {
            Part::Header => match token {
                b"$enddefinitions" => self.part = Part::HeaderEnd,
                b"$comment" | b"$date" | b"$version" => self.skipping = true,
                _ => {}
            },
            Part::HeaderEnd => self.part = Part::Body,
            Part::Identifier => self.part = Part::Body,
            Part::Body => {
                self.values = true;
                match token[0] {
                    b'b' | b'B' | b'r' | b'R' | b's' | b'S' => self.part = Part::Identifier,
                    b'$' => self.skipping = token == b"$comment",
                    b'#' => return self.time(&token[1..]),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn time(&mut self, digits: &[u8]) -> Result<(), Fault> {
        // What is no number is left to the reader.
        let Some(now) = std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok()) else {
            return Ok(());
        };
        match self.time.replace(now) {
            Some(before) if before > now => {
                Err(Fault::Malformed(format!("line {}: time goes back from {before} to {now}", self.line)))
            }
            _ => Ok(()),
        }
    }
}

/// Walks over the sections of an FST file: a byte that says what kind, eight that say how long (themselves included).
///
/// # Errors
/// A section that is longer than the file or too short for its length.
pub(super) fn fst(input: &mut (impl Read + Seek)) -> Result<(), Fault> {
    let end = input.seek(SeekFrom::End(0)).map_err(Fault::Io)?;
    let mut at = 0;
    while at < end {
        input.seek(SeekFrom::Start(at)).map_err(Fault::Io)?;
        let mut head = [0; 9];
        match input.read_exact(&mut head) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Err(cut(at)),
            Err(error) => return Err(Fault::Io(error)),
        }
        let [kind, length @ ..] = head;
        let length = u64::from_be_bytes(length);
        const UNFINISHED: u8 = 255;
        if kind == UNFINISHED {
            return Err(Fault::Cut("what wrote it did not finish".to_owned()));
        }
        if length < 8 || length > end - at - 1 {
            return Err(cut(at));
        }
        at += 1 + length;
    }
    Ok(())
}

fn cut(at: u64) -> Fault {
    Fault::Cut(format!("the section at byte {at} is not complete"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "$version #9 $enddefinitions $end $scope module a $end $enddefinitions $end\n";

    fn check(body: &str) -> Result<bool, String> {
        vcd(&mut format!("{HEADER}{body}").as_bytes()).map_err(|fault| fault.to_string())
    }

    #[test]
    fn time_may_stand_still_but_not_go_back() {
        assert_eq!(check("#0\n1!\n#5\n#5\n#7\n"), Ok(true));
        assert_eq!(check("#5\n1!\n#4\n"), Err("line 4: time goes back from 5 to 4".into()));
    }

    #[test]
    fn what_looks_like_a_time_but_is_none() {
        assert_eq!(check("#5\nb1 #4\n1#3\nr2 #1\n$comment\n#2\n$end\n#6\n"), Ok(true));
        // The identifier `#4` has a time behind it that does go back.
        assert!(check("#5\nb1 #4 #3\n").is_err());
    }

    #[test]
    fn an_unfinished_line_or_header_is_found() {
        assert_eq!(check("#0\n1!\n#12"), Err("it is cut off: its last line (4) is not complete".into()));
        assert_eq!(check(""), Ok(false));
        assert_eq!(check("\n \n"), Ok(false));
        assert!(vcd(&mut b"$scope module a $end\n".as_slice()).is_err());
        assert!(vcd(&mut b"$scope module a $end\n$enddefinitions".as_slice()).is_err());
    }

    #[test]
    fn tokens_of_any_length_are_taken() {
        assert_eq!(check(&format!("b{} !\n#1\n", "1".repeat(100_000))), Ok(true));
    }

    #[test]
    fn sections_must_fit() {
        let section =
            |kind: u8, length: u64, bytes: usize| [&[kind][..], &length.to_be_bytes(), &vec![0; bytes]].concat();
        let check = |bytes: Vec<u8>| fst(&mut io::Cursor::new(bytes)).map_err(|fault| fault.to_string());
        assert_eq!(check([section(0, 12, 4), section(3, 8, 0)].concat()), Ok(()));
        let fault = Err("it is cut off: the section at byte 13 is not complete".to_owned());
        assert_eq!(check([section(0, 12, 4), section(3, 9, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), section(3, 7, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), section(3, u64::MAX, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), vec![1, 2]].concat()), fault);
        assert!(check(section(255, 8, 0)).is_err());
    }
}
