//! What is looked at before `wellen` is given a file: faults that it does not report, or only by a panic.
//!
//! Time that goes back (it warns on standard output and drops the changes), a file that is cut off within a line, a
//! body without anything in it, lengths and counts in an FST file that are more than the file holds.

use std::io::{self, BufRead, Seek, SeekFrom};

use super::read::Fault;

/// Whether a VCD file has anything behind its header.
///
/// # Errors
/// No end of the header, time that goes back, an unfinished last line.
pub(super) fn vcd(input: &mut impl BufRead) -> Result<bool, Fault> {
    let mut scan = Scan { part: Part::Header, skipping: false, line: 1, time: None, values: false };
    let mut token = Token { text: [0; 64], len: 0 };
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
    text: [u8; 64],
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

    /// Understood as the reader does, which also takes `#1e3` and `#5.0`.
    fn time(&mut self, digits: &[u8]) -> Result<(), Fault> {
        let digits = String::from_utf8_lossy(digits);
        let whole = || digits.parse::<f64>().ok().filter(|time| time.fract() == 0.0).map(|time| time as u64);
        let Some(now) = digits.parse().ok().or_else(whole) else {
            return Err(Fault::Malformed(format!("line {}: `#{digits}` is no time", self.line)));
        };
        match self.time.replace(now) {
            Some(before) if before > now => {
                Err(Fault::Malformed(format!("line {}: time goes back from {before} to {now}", self.line)))
            }
            _ => Ok(()),
        }
    }
}

/// Walks over the sections of an FST file, and compares the lengths and counts in them with the bytes that are there:
/// the reader takes that much memory, and a program that cannot have it is ended by the system.
///
/// # Errors
/// A section that does not fit into the file, or a count that does not fit into its section.
pub(super) fn fst(input: &mut (impl BufRead + Seek)) -> Result<(), Fault> {
    let end = input.seek(SeekFrom::End(0)).map_err(Fault::Io)?;
    let mut at = 0;
    while at < end {
        let mut walk = || -> io::Result<u64> {
            input.seek(SeekFrom::Start(at))?;
            let kind = byte(input)?;
            if kind == 255 {
                return Err(io::Error::other("what wrote it did not finish"));
            }
            let length = number(input)?;
            if length < 8 || length > end - at - 1 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            section(input, kind, at + 1, length)?;
            Ok(1 + length)
        };
        at += walk().map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => Fault::Cut(format!("the section at byte {at} is not complete")),
            io::ErrorKind::InvalidData => Fault::Malformed(format!("a count in the section at byte {at} is wrong")),
            io::ErrorKind::Other => Fault::Cut(error.to_string()),
            _ => Fault::Io(error),
        })?;
    }
    Ok(())
}

/// More than any of the methods in use (zlib 1032, LZ4 255) can make of one byte.
const RATIO: u64 = 2048;

/// The counts of one section, which begins with its length at `start`.
fn section(input: &mut (impl BufRead + Seek), kind: u8, start: u64, length: u64) -> io::Result<()> {
    let fits = |unpacked: u64, packed: u64| {
        let fits = packed <= length && unpacked <= packed.saturating_mul(RATIO);
        if fits { Ok(()) } else { Err(io::Error::from(io::ErrorKind::InvalidData)) }
    };
    match kind {
        // What changes: the values at the start, the values of each signal, where those are, and the times.
        1 | 5 | 8 => {
            if length < 32 + 24 {
                return Err(io::ErrorKind::InvalidData.into());
            }
            input.seek(SeekFrom::Start(start + length - 24))?;
            let (unpacked, packed, times) = (number(input)?, number(input)?, number(input)?);
            fits(unpacked, packed)?;
            fits(times, unpacked)?;
            let chain = (start + length - 24).checked_sub(packed + 8).filter(|&chain| chain >= start + 32);
            input.seek(SeekFrom::Start(chain.ok_or(io::ErrorKind::InvalidData)?))?;
            let chain = number(input)?;
            fits(chain, chain)?;

            input.seek(SeekFrom::Start(start + 32))?;
            let (unpacked, packed, signals) = (variable(input)?, variable(input)?, variable(input)?);
            fits(unpacked, packed)?;
            // A signal takes no byte here only if it is text.
            fits(signals, unpacked.max(length))?;
            input.seek_relative(packed as i64)?;
            fits(variable(input)?, signals)
        }
        2 => {
            let count = variable(input)?;
            fits(count, count)
        }
        // What each signal is: a byte at least.
        3 => {
            let (unpacked, signals) = (number(input)?, number(input)?);
            fits(unpacked, length)?;
            if signals <= unpacked { Ok(()) } else { Err(io::ErrorKind::InvalidData.into()) }
        }
        // The names; the last kind is packed twice.
        4 | 6 => fits(number(input)?, length),
        7 => {
            let (unpacked, once) = (number(input)?, variable(input)?);
            fits(once, length)?;
            fits(unpacked / RATIO, once.min(length))
        }
        _ => Ok(()),
    }
}

fn byte(input: &mut impl BufRead) -> io::Result<u8> {
    let mut byte = [0];
    input.read_exact(&mut byte)?;
    Ok(byte[0])
}

fn number(input: &mut impl BufRead) -> io::Result<u64> {
    let mut bytes = [0; 8];
    input.read_exact(&mut bytes)?;
    Ok(u64::from_be_bytes(bytes))
}

/// Seven bits a byte, the lowest first, the eighth set in all but the last.
fn variable(input: &mut impl BufRead) -> io::Result<u64> {
    let mut number = 0;
    for shift in (0..63).step_by(7) {
        let byte = byte(input)?;
        number |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(number);
        }
    }
    Err(io::ErrorKind::InvalidData.into())
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
        assert_eq!(check("#5\n1!\n#4\n"), Err("it is damaged: line 4: time goes back from 5 to 4".into()));
    }

    #[test]
    fn what_looks_like_a_time_but_is_none() {
        assert_eq!(check("#5\nb1 #4\n1#3\nr2 #1\n$comment\n#2\n$end\n#6\n"), Ok(true));
        // The identifier `#4` has a time behind it that does go back.
        assert!(check("#5\nb1 #4 #3\n").is_err());
        assert_eq!(check("#1e1\n#20.0\n"), Ok(true));
        assert_eq!(check("#5\n#.0\n"), Err("it is damaged: line 3: time goes back from 5 to 0".into()));
        assert_eq!(check("#soon\n"), Err("it is damaged: line 2: `#soon` is no time".into()));
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
        assert_eq!(check([section(0, 12, 4), section(9, 8, 0)].concat()), Ok(()));
        let fault = Err("it is cut off: the section at byte 13 is not complete".to_owned());
        assert_eq!(check([section(0, 12, 4), section(3, 9, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), section(3, 7, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), section(3, u64::MAX, 0)].concat()), fault);
        assert_eq!(check([section(0, 12, 4), vec![1, 2]].concat()), fault);
        assert_eq!(check(section(255, 8, 0)), Err("it is cut off: what wrote it did not finish".into()));
    }

    #[test]
    fn counts_must_fit() {
        let check = |section: &[u8]| fst(&mut io::Cursor::new(section)).map_err(|fault| fault.to_string());
        let geometry = |unpacked: u64, signals: u64| {
            [&[3][..], &26_u64.to_be_bytes(), &unpacked.to_be_bytes(), &signals.to_be_bytes(), &[0; 2]].concat()
        };
        let fault = Err("it is damaged: a count in the section at byte 0 is wrong".to_owned());
        assert_eq!(check(&geometry(2, 2)), Ok(()));
        assert_eq!(check(&geometry(2, 3)), fault);
        assert_eq!(check(&geometry(1 << 40, 3)), fault);
        let names = |unpacked: u64| [&[6][..], &20_u64.to_be_bytes(), &unpacked.to_be_bytes(), &[0; 4]].concat();
        assert_eq!(check(&names(100)), Ok(()));
        assert_eq!(check(&names(u64::MAX)), fault);
    }
}
