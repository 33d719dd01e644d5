//! Reading GHW, the format of GHDL: sections with texts, types and the hierarchy, then the values of all signals and
//! their changes cycle by cycle.
//!
//! Nothing is made room for before its bytes are there, so a count in the file may say what it will.

use std::io::{self, BufRead};

use super::ghw_types::{Scalar, Shape, Texts, Type, Types};
use super::ghw_values::Signals;
use super::names::{Array, Made, Outline};
use super::notes::Notes;
use super::{Contents, Fault, Source, ValueKind};

/// What a file begins with.
const MAGIC: &[u8] = b"GHDLwave\n";

/// Whether a file that begins so is GHW.
pub(super) fn is_ghw(beginning: &[u8]) -> bool {
    beginning.starts_with(MAGIC)
}

/// Why reading stops.
#[derive(Debug)]
pub(super) enum Stop {
    Io(io::Error),
    /// The file ends.
    End,
    /// What stands there is not what has to.
    Wrong(&'static str),
    /// It goes beyond what is read.
    Fault(Fault),
}

/// Bytes of a file in their order.
pub(super) struct Stream<R> {
    input: R,
    /// How many were read.
    pub at: u64,
    /// Whether numbers of several bytes have the highest first.
    big: bool,
}

impl<R: BufRead> Stream<R> {
    pub fn byte(&mut self) -> Result<u8, Stop> {
        let byte = match self.input.fill_buf() {
            Ok(bytes) => *bytes.first().ok_or(Stop::End)?,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return self.byte(),
            Err(error) => return Err(Stop::Io(error)),
        };
        self.input.consume(1);
        self.at += 1;
        Ok(byte)
    }

    pub fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let mut bytes = [0; N];
        for byte in &mut bytes {
            *byte = self.byte()?;
        }
        Ok(bytes)
    }

    fn count(&mut self) -> Result<u32, Stop> {
        let bytes = self.bytes()?;
        Ok(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// Seven bits a byte, the lowest first.
    pub fn unsigned(&mut self) -> Result<u64, Stop> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(Stop::Wrong("a number"))
    }

    /// The same in two's complement.
    pub fn signed(&mut self) -> Result<i64, Stop> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= i64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                let extension = if byte & 0x40 != 0 && shift + 7 < 64 { -1 << (shift + 7) } else { 0 };
                return Ok(number | extension);
            }
        }
        Err(Stop::Wrong("a number"))
    }

    pub fn real(&mut self) -> Result<f64, Stop> {
        let bytes = self.bytes()?;
        Ok(if self.big { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }

    fn zeros(&mut self) -> Result<(), Stop> {
        if self.bytes()? == [0; 4] { Ok(()) } else { Err(Stop::Wrong("the beginning of a section")) }
    }

    fn marked(&mut self, mark: &[u8; 4]) -> Result<(), Stop> {
        if self.bytes()? == *mark { Ok(()) } else { Err(Stop::Wrong("the end of a section")) }
    }

    pub fn time(&mut self) -> Result<i64, Stop> {
        let bytes = self.bytes()?;
        Ok(if self.big { i64::from_be_bytes(bytes) } else { i64::from_le_bytes(bytes) })
    }
}

/// Reads a file of `length` bytes.
///
/// # Errors
/// It cannot be read, or its names cannot.
pub(super) fn read(input: impl BufRead, length: u64) -> Result<Contents, Fault> {
    let mut stream = Stream { input, at: 0, big: false };
    let mut reader = Reader {
        texts: Texts::default(),
        types: Types::default(),
        version: 0,
        outline: Outline::new(length),
        signals: Signals::default(),
        notes: Notes::default(),
        times: Vec::new(),
    };
    let done = reader.header(&mut stream);
    let at = stream.at;
    done.map_err(|stop| match stop {
        Stop::Io(error) => Fault::Io(error),
        Stop::End => Fault::Cut("its names are not complete".to_owned()),
        Stop::Wrong(what) => Fault::Malformed(format!("{what} before byte {at} is wrong")),
        Stop::Fault(fault) => fault,
    })?;
    match reader.values(&mut stream) {
        Ok(()) => {}
        Err(Stop::Io(error)) => return Err(Fault::Io(error)),
        Err(Stop::Fault(fault)) => return Err(fault),
        Err(Stop::End) => reader.notes.cut("its values are not complete"),
        Err(Stop::Wrong(what)) => reader.notes.cut(format!("{what} before byte {} is wrong", stream.at)),
    }
    let Reader { outline, signals, notes, times, .. } = reader;
    let names = outline.names(|_| None);
    // a tick of GHDL is a femtosecond
    Ok(Contents { names, exponent: Some(-15), times, source: Source::Memory(signals.done()), notes })
}

struct Reader {
    texts: Texts,
    types: Types,
    version: u8,
    outline: Outline,
    signals: Signals,
    notes: Notes,
    times: Vec<u64>,
}

impl Reader {
    fn header(&mut self, stream: &mut Stream<impl BufRead>) -> Result<(), Stop> {
        const WRONG: Stop = Stop::Wrong("the header");
        if stream.bytes()? != *MAGIC.first_chunk::<9>().expect("it has nine") {
            return Err(WRONG);
        }
        let [length, major, minor, order, _, _, _] = stream.bytes()?;
        if length != 16 || major != 0 || minor > 1 || !matches!(order, 1 | 2) {
            return Err(WRONG);
        }
        self.version = minor;
        stream.big = order == 2;
        loop {
            match &stream.bytes()? {
                b"STR\0" => {
                    stream.zeros()?;
                    let count = stream.count()?;
                    stream.count()?;
                    self.texts = Texts::read(stream, count)?;
                    stream.marked(b"EOS\0")?;
                }
                b"TYP\0" => {
                    stream.zeros()?;
                    let count = stream.count()?;
                    self.types = Types::read(stream, count, self.version, &self.texts)?;
                }
                b"WKT\0" => {
                    stream.zeros()?;
                    while stream.byte()? != 0 {
                        stream.unsigned()?;
                    }
                }
                b"HIE\0" => {
                    stream.zeros()?;
                    // how many scopes, variables and signals: these are counted as they come
                    stream.bytes::<12>()?;
                    self.hierarchy(stream)?;
                }
                b"EOH\0" => return Ok(()),
                _ => return Err(Stop::Wrong("the beginning of a section")),
            }
        }
    }

    fn hierarchy(&mut self, stream: &mut Stream<impl BufRead>) -> Result<(), Stop> {
        loop {
            match stream.byte()? {
                0 => return Ok(()),
                15 => drop(self.outline.leave()),
                // processes have no signals
                13 => drop(stream.unsigned()?),
                3 | 4 | 6 | 7 | 14 => {
                    let name = self.text(stream)?;
                    self.outline.enter(&name, Array::No).map_err(Stop::Fault)?;
                }
                5 => {
                    let name = self.text(stream)?;
                    let kind = self.types.get(stream.unsigned()?)?;
                    let Shape::Scalar(scalar) = kind.shape else { return Err(Stop::Wrong("a generate statement")) };
                    let name = match scalar.read(stream)? {
                        super::ghw_types::Scalared::Number(number) => format!("{name}({number})"),
                        super::ghw_types::Scalared::Real(number) => format!("{name}({number})"),
                    };
                    self.outline.enter(&name, Array::No).map_err(Stop::Fault)?;
                }
                16..=21 => {
                    let name = self.text(stream)?;
                    let kind = self.types.get(stream.unsigned()?)?;
                    self.variable(stream, name, &kind)?;
                }
                _ => return Err(Stop::Wrong("the hierarchy")),
            }
        }
    }

    fn text(&mut self, stream: &mut Stream<impl BufRead>) -> Result<String, Stop> {
        self.texts.get(stream.unsigned()?)
    }

    /// A variable, or a part of one: after it stand the numbers of its signals.
    fn variable(&mut self, stream: &mut Stream<impl BufRead>, name: String, kind: &Type) -> Result<(), Stop> {
        let Some(scalars) = kind.scalars else { return Err(Stop::Wrong("the type of a signal")) };
        let fault = Stop::Fault;
        match &kind.shape {
            Shape::Scalar(scalar) => {
                let number = stream.unsigned()?;
                match self.signals.scalar(number, *scalar) {
                    Some(signal) => self.outline.add(name, scalar.kind(), None, Made::Of(signal)).map_err(fault)?,
                    None => self.outline.leave_out(name, "it shares a signal with one of another type".to_owned()),
                }
            }
            Shape::Array(_, ranges) if scalars == 0 || ranges.len() != 1 => {
                self.pass_over(stream, kind)?;
                let why = match scalars {
                    0 => "it has no elements".to_owned(),
                    _ => format!("it is an array of {} dimensions; one is read", ranges.len()),
                };
                self.outline.leave_out(name, why);
            }
            Shape::Array(element, ranges) => {
                let range = ranges[0];
                if let Shape::Scalar(scalar @ (Scalar::Logic | Scalar::Bit)) = element.shape {
                    let mut numbers = Vec::new();
                    for _ in 0..scalars {
                        numbers.push(stream.unsigned()?);
                    }
                    match self.signals.vector(&numbers, scalar) {
                        Some(signal) => {
                            let width = u32::try_from(scalars).unwrap_or(u32::MAX);
                            let index = Some((range.left, range.right));
                            self.outline.add(name, ValueKind::Bits(width), index, Made::Of(signal)).map_err(fault)?;
                        }
                        None => self.outline.leave_out(name, "it shares a signal with one of another type".to_owned()),
                    }
                    return Ok(());
                }
                self.outline.enter(&name, Array::Packed).map_err(fault)?;
                for index in range.indices() {
                    self.variable(stream, format!("[{index}]"), element)?;
                }
                self.outline.leave();
            }
            Shape::Record(fields) => {
                self.outline.enter(&name, Array::No).map_err(fault)?;
                for (name, kind) in fields.iter() {
                    let name = self.texts.get(*name)?;
                    self.variable(stream, name, kind)?;
                }
                self.outline.leave();
            }
        }
        Ok(())
    }

    /// The signals of what is left out: their values stand in the file nevertheless.
    fn pass_over(&mut self, stream: &mut Stream<impl BufRead>, kind: &Type) -> Result<(), Stop> {
        if kind.scalars == Some(0) {
            return Ok(());
        }
        match &kind.shape {
            Shape::Scalar(scalar) => self.signals.declare(stream.unsigned()?, *scalar),
            Shape::Array(element, ranges) => {
                let count = ranges.iter().fold(1_u64, |n, range| n.saturating_mul(range.len()));
                for _ in 0..count {
                    self.pass_over(stream, element)?;
                }
            }
            Shape::Record(fields) => {
                for (_, kind) in fields.iter() {
                    self.pass_over(stream, kind)?;
                }
            }
        }
        Ok(())
    }

    /// The entry for a time, which is none before the last.
    fn enter(&mut self, time: i64) -> u64 {
        let time = u64::try_from(time).unwrap_or(0);
        match self.times.last() {
            Some(&last) if time < last => {
                self.notes
                    .add("back", || format!("time goes back from {last} fs to {time} fs; it is taken to stand still"));
            }
            Some(&last) if time == last => {}
            _ => self.times.push(time),
        }
        self.times.len() as u64 - 1
    }

    fn values(&mut self, stream: &mut Stream<impl BufRead>) -> Result<(), Stop> {
        self.signals.order();
        loop {
            match &stream.bytes()? {
                b"SNP\0" => {
                    stream.zeros()?;
                    let time = stream.time()?;
                    let at = self.enter(time);
                    let read = self.signals.all(stream);
                    self.signals.settle(at);
                    read?;
                    stream.marked(b"ESN\0")?;
                }
                b"CYC\0" => {
                    let mut time = stream.time()?;
                    loop {
                        let at = self.enter(time);
                        let read = self.signals.some(stream);
                        self.signals.settle(at);
                        read?;
                        match stream.signed()? {
                            ..0 => break,
                            gap => time = time.checked_add(gap).ok_or(Stop::Wrong("a time"))?,
                        }
                    }
                    stream.marked(b"ECY\0")?;
                }
                // where the sections are, and the end
                b"DIR\0" | b"TAI\0" => return Ok(()),
                _ => return Err(Stop::Wrong("the beginning of a section")),
            }
        }
    }
}
