//! Reading VCD (IEEE 1364-2005, clause 18), as tolerantly as GTKWave does.
//!
//! What a file does wrong is noted and read as it is most likely meant: time that goes back stands still, a time between
//! two ticks is that of the first, what belongs to no variable is passed over. A variable whose values are of another
//! kind than it says is left out. Text is taken word by word, wherever lines end.

use std::collections::{HashMap, HashSet};
use std::io::Read;

use super::names::{Array, Outline};
use super::notes::Notes;
use super::signal::{Signal, logic};
use super::tokens::Tokens;
use crate::Layout;

use super::{Contents, Fault, Source, ValueKind};

/// Identifiers up to this number are looked up in a table.
const DENSE: usize = 94 * 94 * 94 + 94 * 94 + 94;

/// No entry of a table.
const NONE: u32 = u32::MAX;

/// Whether a file that begins so is VCD: its first word is one of a header.
pub(super) fn is_vcd(beginning: &[u8]) -> bool {
    const WORDS: [&[u8]; 10] = [
        b"$date",
        b"$version",
        b"$comment",
        b"$timescale",
        b"$scope",
        b"$upscope",
        b"$var",
        b"$attrbegin",
        b"$attrend",
        b"$enddefinitions",
    ];
    let text = beginning.strip_prefix(MARK).unwrap_or(beginning).trim_ascii_start();
    let word = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    WORDS.contains(&word)
}

/// What some editors put before UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads a file of `length` bytes.
///
/// # Errors
/// It cannot be read, its scopes lie too deep, its times are too great.
pub(super) fn read(input: impl Read, length: u64) -> Result<Contents, Fault> {
    let mut reader = Reader {
        tokens: Tokens::new(input),
        outline: Outline::new(length),
        notes: Notes::default(),
        ids: Ids::default(),
        signals: Vec::new(),
        exponent: None,
        factor: 1,
        times: Vec::new(),
        dump: false,
    };
    if let Some(first) = reader.header()? {
        reader.values(first)?;
    }
    if reader.tokens.unfinished && reader.notes.cut.is_none() {
        let line = reader.tokens.line;
        reader.notes.add("end", || format!("its last line ({line}) has no end; it is taken to be complete"));
    }
    let signals = reader.signals;
    let names = reader.outline.names(|signal| signals[signal as usize].bad.clone());
    let source = Source::Memory(signals.into_iter().map(|ground| ground.signal.into()).collect());
    Ok(Contents { names, exponent: reader.exponent, times: reader.times, source, notes: reader.notes })
}

struct Reader<R> {
    tokens: Tokens<R>,
    outline: Outline,
    notes: Notes,
    ids: Ids,
    signals: Vec<Ground>,
    exponent: Option<i32>,
    /// Ticks of a time in the file.
    factor: u64,
    times: Vec<u64>,
    /// Within what began with `$dumpvars` or the like, and no time since.
    dump: bool,
}

/// What one identifier of the file is.
struct Ground {
    kind: ValueKind,
    signal: Signal,
    /// Why its values cannot be read.
    bad: Option<String>,
    /// Another one of the same identifier, whose kind differs.
    next: u32,
}

/// The signals by their identifiers.
#[derive(Default)]
struct Ids {
    dense: Vec<u32>,
    others: HashMap<Box<[u8]>, u32>,
    /// Those of variables that are left out for what they are.
    passed_over: HashSet<Box<[u8]>>,
}

impl Ids {
    /// The number that a short identifier is with the 94 printable characters as digits.
    fn number(id: &[u8]) -> Option<usize> {
        if id.len() > 3 {
            return None;
        }
        id.iter().try_fold(0, |n, byte| matches!(byte, b'!'..=b'~').then(|| n * 94 + usize::from(byte - b'!') + 1))
    }

    fn find(&self, id: &[u8]) -> Option<u32> {
        match Ids::number(id) {
            Some(number) => self.dense.get(number).copied().filter(|&found| found != NONE),
            None => self.others.get(id).copied(),
        }
    }

    /// Has an identifier be one of no variable that is known nevertheless.
    fn pass_over(&mut self, id: &[u8]) {
        if self.find(id).is_none() {
            self.passed_over.insert(id.into());
        }
    }

    fn insert(&mut self, id: &[u8], signal: u32) {
        match Ids::number(id) {
            Some(number) => {
                debug_assert!(number <= DENSE);
                if self.dense.len() <= number {
                    self.dense.resize(number + 1, NONE);
                }
                self.dense[number] = signal;
            }
            None => drop(self.others.insert(id.into(), signal)),
        }
    }
}

impl<R: Read> Reader<R> {
    /// Reads up to the values; the first word of these, if there is one.
    fn header(&mut self) -> Result<Option<Vec<u8>>, Fault> {
        while let Some(word) = self.tokens.next().map_err(Fault::Io)? {
            let word = word.strip_prefix(MARK).unwrap_or(word).to_vec();
            let line = self.tokens.line;
            match word.as_slice() {
                b"$scope" => {
                    let words = self.words()?;
                    let name = words.get(1).map_or("", String::as_str);
                    if self.notes.cut.is_none() {
                        self.outline.enter(name, Array::No)?;
                    }
                }
                b"$upscope" => {
                    self.words()?;
                    if !self.outline.leave() {
                        self.notes.add("upscope", || format!("line {line}: a scope ends that has not begun"));
                    }
                }
                b"$var" => self.variable(line)?,
                b"$timescale" => {
                    let text = self.words()?.concat();
                    self.timescale(&text, line);
                }
                b"$enddefinitions" => {
                    self.words()?;
                    return Ok(self.tokens.next().map_err(Fault::Io)?.map(<[u8]>::to_vec));
                }
                b"$end" | b"$attrend" => {}
                _ if word[0] == b'#' || word.starts_with(b"$dump") => {
                    self.notes.add("enddefinitions", || format!("line {line}: values begin before `$enddefinitions`"));
                    return Ok(Some(word));
                }
                _ if word[0] == b'$' => drop(self.words()?),
                _ => self.stray(&word, line),
            }
        }
        self.notes.cut("its header has no end (`$enddefinitions $end`)");
        Ok(None)
    }

    fn stray(&mut self, word: &[u8], line: u64) {
        self.notes.add("stray", || format!("line {line}: `{}` is passed over: it is no value", excerpt(word)));
    }

    /// The words up to `$end`.
    fn words(&mut self) -> Result<Vec<String>, Fault> {
        let mut words = Vec::new();
        while let Some(word) = self.tokens.next().map_err(Fault::Io)? {
            if word == b"$end" {
                return Ok(words);
            }
            words.push(String::from_utf8_lossy(word).into_owned());
        }
        self.notes.cut("its header has no end (`$enddefinitions $end`)");
        Ok(words)
    }

    fn variable(&mut self, line: u64) -> Result<(), Fault> {
        let words = self.words()?;
        if self.notes.cut.is_some() {
            return Ok(());
        }
        let [kind, size, id, name @ ..] = words.as_slice() else {
            self.notes.add("var", || format!("line {line}: a variable without a name is passed over"));
            return Ok(());
        };
        let name = if name.is_empty() { id.clone() } else { name.join(" ") };
        let kind = match kind.as_str() {
            "string" => ValueKind::Text,
            "real" | "real_parameter" | "realtime" | "shortreal" => ValueKind::Real,
            "event" => ValueKind::Event,
            _ => match size.parse() {
                Ok(width) => ValueKind::Bits(width),
                Err(_) => {
                    self.ids.pass_over(id.as_bytes());
                    self.outline.leave_out(name, format!("line {line}: its width `{size}` is no number up to 2^32-1"));
                    return Ok(());
                }
            },
        };
        if matches!(kind, ValueKind::Bits(width) if !(1..=Layout::MAX_WIDTH).contains(&width)) {
            // it is left out; its values are those of no variable, and not told again
            self.ids.pass_over(id.as_bytes());
            return self.outline.declare(&name, kind, NONE);
        }
        let signal = self.ground(id.as_bytes(), kind);
        self.outline.declare(&name, kind, signal)
    }

    /// The signal of an identifier as this kind.
    fn ground(&mut self, id: &[u8], kind: ValueKind) -> u32 {
        let new = self.signals.len() as u32;
        let mut at = self.ids.find(id);
        match at {
            None => self.ids.insert(id, new),
            Some(mut known) => loop {
                let ground = &mut self.signals[known as usize];
                if ground.kind == kind {
                    return known;
                }
                if ground.next == NONE {
                    ground.next = new;
                    at = Some(new);
                    break;
                }
                known = ground.next;
            },
        }
        debug_assert!(at.is_none() || at == Some(new));
        self.signals.push(Ground { kind, signal: Signal::new(kind), bad: None, next: NONE });
        new
    }

    /// A number and a unit. GTKWave takes any number; 0 or none is 1.
    fn timescale(&mut self, text: &str, line: u64) {
        let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (number, unit) = text.split_at(digits);
        let exponent = match unit.trim() {
            "s" => 0,
            "ms" => -3,
            "us" => -6,
            "ns" => -9,
            "ps" => -12,
            "fs" => -15,
            "as" => -18,
            "zs" => -21,
            _ => {
                self.notes.add("timescale", || format!("line {line}: the timescale `{text}` has no known unit"));
                return;
            }
        };
        let number: u64 = number.parse().unwrap_or(0);
        if number == 0 {
            self.notes.add("timescale", || format!("line {line}: the timescale `{text}` is taken as 1{unit}"));
        }
        let mut number = number.max(1);
        self.exponent = Some(exponent);
        // 1, 10 and 100 are what there can be; a tick of 244 ns is 244 ticks of 1 ns
        for zeros in 0..3 {
            if number == 10u64.pow(zeros) {
                self.exponent = Some(exponent + zeros as i32);
                number = 1;
            }
        }
        self.factor = number;
        if number > 1 {
            self.notes.add("timescale", || {
                format!("line {line}: the timescale `{text}` is none of 1, 10 and 100 of a unit; times are in {unit}")
            });
        }
    }

    /// Reads the values, of which the first word is given.
    fn values(&mut self, first: Vec<u8>) -> Result<(), Fault> {
        let mut value = first;
        let mut at = self.now();
        loop {
            let line = self.tokens.line;
            match value[0] {
                b'#' => {
                    self.dump = false;
                    self.time(&value[1..], line)?;
                    at = self.now();
                }
                b'b' | b'B' | b'r' | b'R' | b's' | b'S' => {
                    let Some(id) = self.tokens.next().map_err(Fault::Io)? else {
                        let text = excerpt(&value);
                        self.notes.cut(format!("line {line}: the value `{text}` has no identifier"));
                        return Ok(());
                    };
                    let found = self.ids.find(id);
                    let id = if found.is_none() { id.to_vec() } else { Vec::new() };
                    let line = self.tokens.line;
                    at = self.begin(at);
                    self.change(found, &id, value[0], &value[1..], at, line);
                }
                b'p' if value.len() > 1 => {
                    let states = value[1..].to_vec();
                    at = self.begin(at);
                    if !self.port(&states, at, line)? {
                        return Ok(());
                    }
                }
                b'$' => {
                    if !self.keyword(&value, line)? {
                        return Ok(());
                    }
                }
                first if value.len() > 1 && logic(first).is_some() => {
                    let found = self.ids.find(&value[1..]);
                    at = self.begin(at);
                    self.change(found, &value[1..], b'b', &value[..1], at, line);
                }
                _ if value.len() == 1 && logic(value[0]).is_some() && self.tokens.unfinished => {
                    self.notes.cut(format!("line {line}: the value `{}` has no identifier", excerpt(&value)));
                    return Ok(());
                }
                _ => self.stray(&value, line),
            }
            match self.tokens.next().map_err(Fault::Io)? {
                Some(word) => {
                    value.clear();
                    value.extend_from_slice(word);
                }
                None => break,
            }
        }
        if self.dump {
            self.notes.cut("its first values have no end (`$end`)");
        }
        Ok(())
    }

    /// The entry of the table of times that is the last.
    fn now(&self) -> u64 {
        (self.times.len() as u64).saturating_sub(1)
    }

    /// Values before any time are those at the beginning.
    fn begin(&mut self, at: u64) -> u64 {
        if self.times.is_empty() {
            self.times.push(0);
        }
        at
    }

    /// A word of the language; false if the file ends within it.
    fn keyword(&mut self, word: &[u8], line: u64) -> Result<bool, Fault> {
        match word {
            b"$dumpvars" | b"$dumpall" | b"$dumpon" | b"$dumpoff" => self.dump = true,
            b"$dumpports" | b"$dumpportson" | b"$dumpportsoff" | b"$dumpportsall" => self.dump = true,
            b"$end" => self.dump = false,
            b"$comment" => loop {
                match self.tokens.next().map_err(Fault::Io)? {
                    Some(b"$end") => break,
                    Some(_) => {}
                    None => {
                        self.notes.cut(format!("line {line}: a comment has no end"));
                        return Ok(false);
                    }
                }
            },
            b"$vcdclose" => {}
            _ if self.tokens.unfinished => {
                self.notes.cut(format!("line {line}: `{}` is not complete", excerpt(word)));
                return Ok(false);
            }
            _ => self.stray(word, line),
        }
        Ok(true)
    }

    /// A time. GTKWave takes what digits there are, and lets time that goes back stand still.
    fn time(&mut self, text: &[u8], line: u64) -> Result<(), Fault> {
        let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let text = String::from_utf8_lossy(text);
        let number = || text.parse::<f64>().ok().filter(|time| *time >= 0.0 && *time < 1.8e19);
        let now = match text[..digits].parse::<u64>() {
            Ok(now) if digits == text.len() => Some(now),
            _ => number().map(|now| {
                if now.fract() != 0.0 {
                    self.notes.add("fraction", || {
                        format!("line {line}: the time `{text}` is between two ticks; it is taken as {}", now.floor())
                    });
                }
                now as u64
            }),
        };
        let Some(now) = now else {
            self.notes.add("time", || format!("line {line}: `#{text}` is no time; time stands still"));
            if self.times.is_empty() {
                self.times.push(0);
            }
            return Ok(());
        };
        let Some(now) = now.checked_mul(self.factor) else {
            return Err(Fault::Malformed(format!("line {line}: the time {now} is more than 2^64-1 ticks")));
        };
        match self.times.last() {
            Some(&last) if now < last && self.tokens.unfinished => {
                self.notes.cut(format!("line {line}: the last time is not complete"));
            }
            Some(&last) if now < last => {
                let back = || format!("line {line}: time goes back from {last} to {now}; it is taken to stand still");
                self.notes.add("back", back);
            }
            Some(&last) if now == last => {}
            _ => self.times.push(now),
        }
        Ok(())
    }

    /// A value of the variables of an identifier: `form` is `b`, `r` or `s`.
    fn change(&mut self, found: Option<u32>, id: &[u8], form: u8, text: &[u8], at: u64, line: u64) {
        let Some(mut next) = found else {
            if self.tokens.unfinished {
                self.notes.cut(format!("line {line}: the last value is not complete"));
            } else {
                let id = excerpt(id);
                self.notes
                    .add("id", || format!("line {line}: the value of `{id}` is passed over: no variable is called so"));
            }
            return;
        };
        while next != NONE {
            let ground = &mut self.signals[next as usize];
            next = ground.next;
            if ground.bad.is_none() {
                ground.bad = ground.change(form, text, at).err().map(|why| format!("line {line}: {why}"));
            }
        }
    }

    /// A value of a port (IEEE 1364-2005, 18.4): its states, two strengths, the identifier. False if the file ends.
    fn port(&mut self, states: &[u8], at: u64, line: u64) -> Result<bool, Fault> {
        let state = |byte: &u8| match byte {
            b'D' | b'd' | b'L' | b'l' | b'0' => b'0',
            b'U' | b'u' | b'H' | b'h' | b'1' => b'1',
            b'Z' | b'T' | b'F' | b'f' => b'z',
            _ => b'x',
        };
        let states: Vec<u8> = states.iter().map(state).collect();
        for part in 0..3 {
            let word = self.tokens.next().map_err(Fault::Io)?;
            let Some(word) = word else {
                self.notes.cut(format!("line {line}: the last value is not complete"));
                return Ok(false);
            };
            if part == 2 {
                let (id, found) = (word.to_vec(), self.ids.find(word));
                self.change(found, &id, b'b', &states, at, line);
            }
        }
        Ok(true)
    }
}

impl Ground {
    /// Takes a value, or says why that is none of this variable.
    fn change(&mut self, form: u8, text: &[u8], at: u64) -> Result<(), String> {
        let other = |what: &str| Err(format!("`{}` is not {what}", excerpt(text)));
        match (self.kind, form) {
            (ValueKind::Bits(width), b'b' | b'B') => {
                let width = width as usize;
                if let [byte] = text
                    && width == 1
                    && let Some(code) = logic(*byte)
                {
                    self.signal.bit(at, code);
                    return Ok(());
                }
                let Some(first) = text.first() else { return other("a value") };
                if text.iter().any(|byte| logic(*byte).is_none()) {
                    return other("bits");
                }
                // IEEE 1364-2005, 18.2.1: 0 and 1 are extended with 0, others with themselves
                let extension = logic(*first).filter(|code| *code >= 2).unwrap_or_default();
                let code = |i: usize| text.len().checked_sub(i + 1).map_or(extension, |i| logic(text[i]).unwrap_or(2));
                let excess = &text[..text.len().saturating_sub(width)];
                if excess.iter().any(|byte| logic(*byte) != Some(extension))
                    || !excess.is_empty() && extension > 1 && code(width - 1) != extension
                {
                    let bits = if width == 1 { "bit" } else { "bits" };
                    return Err(format!("`{}` has more than {width} {bits}", excerpt(text)));
                }
                self.signal.bits(at, width as u32, code);
            }
            (ValueKind::Event, b'b' | b'B') => self.signal.event(at),
            (ValueKind::Real, b'r' | b'R') => {
                let number = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
                match number {
                    Some(number) => self.signal.real(at, number),
                    None => return other("a number"),
                }
            }
            (ValueKind::Text, b's' | b'S') => self.signal.text(at, &unescaped(text)),
            (kind, _) => return other(&kind.to_string()),
        }
        Ok(())
    }
}

/// The beginning of a word.
fn excerpt(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let mut text: String =
        String::from_utf8_lossy(&word[..word.len().min(4 * LONGEST)]).chars().take(LONGEST).collect();
    if word.len() > text.len() {
        text.push('…');
    }
    text
}

/// A text value: GTKWave's writer escapes as C does, with octal digits; others with hexadecimal ones.
fn unescaped(text: &[u8]) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text;
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'\\' {
            bytes.push(*first);
            continue;
        }
        let number = |digits: &[u8], base| {
            let text = std::str::from_utf8(digits).ok()?;
            text.bytes().all(|b| b.is_ascii_alphanumeric()).then(|| u8::from_str_radix(text, base).ok())?
        };
        let octal = rest.first_chunk::<3>().and_then(|digits| number(digits, 8));
        let hex = rest.first_chunk::<3>().filter(|c| c[0] == b'x').and_then(|digits| number(&digits[1..], 16));
        if let Some(byte) = octal.or(hex) {
            bytes.push(byte);
            rest = &rest[3..];
            continue;
        }
        let Some(escaped) = rest.first() else {
            bytes.push(b'\\');
            break;
        };
        rest = &rest[1..];
        match escaped {
            b'a' => bytes.push(7),
            b'b' => bytes.push(8),
            b'f' => bytes.push(12),
            b'n' => bytes.push(b'\n'),
            b'r' => bytes.push(b'\r'),
            b't' => bytes.push(b'\t'),
            b'v' => bytes.push(11),
            b'\\' | b'\'' | b'"' | b'?' => bytes.push(*escaped),
            other => bytes.extend([b'\\', *other]),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
