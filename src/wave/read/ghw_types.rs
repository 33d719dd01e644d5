//! The texts and types in a GHW file.

use std::io::BufRead;
use std::rc::Rc;

use super::ValueKind;
use super::ghw::{Stop, Stream};

/// Types inside one another.
const MAX_DEPTH: u32 = 1000;

/// The texts of a file. Each begins as the one before it does, and only the rest of it is kept: what all of them are
/// together may be the square of the file.
#[derive(Default)]
pub(super) struct Texts(Vec<Text>);

struct Text {
    /// How much of it stands in others, and the last one of which a part is needed for that.
    shared: usize,
    before: Option<usize>,
    rest: Vec<u8>,
}

impl Texts {
    pub fn read(stream: &mut Stream<impl BufRead>, count: u32) -> Result<Texts, Stop> {
        let mut texts: Vec<Text> = Vec::new();
        let mut shared = 0_usize;
        for _ in 0..count {
            let mut rest = Vec::new();
            let mut next = loop {
                match stream.byte()? {
                    end @ (0..=31 | 128..=159) => break end,
                    byte => rest.push(byte),
                }
            };
            // the last text with less in common than this one has the beginning of what is in common
            let mut before = texts.len().checked_sub(1);
            while let Some(i) = before
                && texts[i].shared >= shared
                && shared > 0
            {
                before = texts[i].before;
            }
            let length = shared + rest.len();
            texts.push(Text { shared, before: before.filter(|_| shared > 0), rest });
            shared = usize::from(next & 31);
            let mut shift = 5;
            while next >= 128 {
                next = stream.byte()?;
                shared |=
                    usize::from(next & 31).checked_shl(shift).filter(|_| shift < 60).ok_or(Stop::Wrong("a text"))?;
                shift += 5;
            }
            if shared > length {
                return Err(Stop::Wrong("a text"));
            }
        }
        Ok(Texts(texts))
    }

    /// How long a text is; 0 if there is none of this number.
    fn length(&self, number: u64) -> usize {
        let i = number.checked_sub(1).and_then(|i| usize::try_from(i).ok());
        i.and_then(|i| self.0.get(i)).map_or(0, |text| text.shared + text.rest.len())
    }

    /// A text by its number, from 1; 0 is none.
    pub fn get(&self, number: u64) -> Result<String, Stop> {
        if number == 0 {
            return Ok(String::new());
        }
        let found = usize::try_from(number - 1).ok().and_then(|i| self.0.get(i));
        let Some(mut text) = found else { return Err(Stop::Wrong("a name")) };
        let mut bytes = vec![0; text.shared + text.rest.len()];
        let mut end = bytes.len();
        loop {
            bytes[text.shared..end].copy_from_slice(&text.rest[..end - text.shared]);
            end = text.shared;
            match text.before {
                Some(before) => text = &self.0[before],
                None => break,
            }
        }
        // GHDL writes Latin-1
        Ok(bytes.into_iter().map(char::from).collect())
    }
}

/// A type.
#[derive(Clone, Debug)]
pub(super) struct Type {
    pub shape: Shape,
    /// How many scalars a signal of it has; none if its bounds are open.
    pub scalars: Option<u64>,
    depth: u32,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    Scalar(Scalar),
    /// Elements, and a range for each dimension; none where they are open.
    Array(Rc<Type>, Rc<[Range]>),
    /// Names and types.
    Record(Rc<[(u64, Rc<Type>)]>),
}

/// What has no parts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Scalar {
    /// One of the nine values of `std_ulogic`.
    Logic,
    /// '0' or '1'.
    Bit,
    /// One of several names: so many bits.
    Enum(u32),
    /// A number of so many bits.
    Integer(u32),
    Real,
}

/// A value of a scalar.
pub(super) enum Scalared {
    Number(i64),
    Real(f64),
}

impl Scalar {
    /// What its values are to us.
    pub fn kind(self) -> ValueKind {
        match self {
            Scalar::Logic | Scalar::Bit => ValueKind::Bits(1),
            Scalar::Enum(bits) | Scalar::Integer(bits) => ValueKind::Bits(bits),
            Scalar::Real => ValueKind::Real,
        }
    }

    pub fn read(self, stream: &mut Stream<impl BufRead>) -> Result<Scalared, Stop> {
        Ok(match self {
            Scalar::Logic | Scalar::Bit | Scalar::Enum(_) => Scalared::Number(stream.byte()?.into()),
            Scalar::Integer(_) => Scalared::Number(stream.signed()?),
            Scalar::Real => Scalared::Real(stream.real()?),
        })
    }
}

/// The indices of a dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    down: bool,
    pub left: i64,
    pub right: i64,
}

impl Range {
    fn read(stream: &mut Stream<impl BufRead>) -> Result<Range, Stop> {
        let kind = stream.byte()?;
        let down = kind & 0x80 != 0;
        match kind & 0x7f {
            22 | 23 => {
                let [left, right] = stream.bytes()?;
                Ok(Range { down, left: left.into(), right: right.into() })
            }
            25 | 26 | 28 | 29 => Ok(Range { down, left: stream.signed()?, right: stream.signed()? }),
            27 => {
                stream.bytes::<16>()?;
                Ok(Range { down, left: 0, right: 0 })
            }
            _ => Err(Stop::Wrong("a range")),
        }
    }

    fn ends(&self) -> (i64, i64) {
        if self.down { (self.right, self.left) } else { (self.left, self.right) }
    }

    pub fn len(&self) -> u64 {
        let (low, high) = self.ends();
        if low > high { 0 } else { high.abs_diff(low).saturating_add(1) }
    }

    /// The indices in their order.
    pub fn indices(&self) -> Box<dyn Iterator<Item = i64>> {
        let (low, high) = self.ends();
        if self.down { Box::new((low..=high).rev()) } else { Box::new(low..=high) }
    }
}

/// The types of a file.
#[derive(Default)]
pub(super) struct Types(Vec<Rc<Type>>);

impl Types {
    pub fn read(stream: &mut Stream<impl BufRead>, count: u32, version: u8, texts: &Texts) -> Result<Types, Stop> {
        let mut types = Types::default();
        for _ in 0..count {
            let made = types.one(stream, version, texts)?;
            types.0.push(made);
        }
        if stream.byte()? == 0 { Ok(types) } else { Err(Stop::Wrong("the end of the types")) }
    }

    /// A type by its number, from 1.
    pub fn get(&self, number: u64) -> Result<Rc<Type>, Stop> {
        let found = number.checked_sub(1).and_then(|i| self.0.get(usize::try_from(i).ok()?));
        found.cloned().ok_or(Stop::Wrong("a type"))
    }

    fn one(&self, stream: &mut Stream<impl BufRead>, version: u8, texts: &Texts) -> Result<Rc<Type>, Stop> {
        let kind = stream.byte()?;
        stream.unsigned()?;
        let scalar = |scalar| Ok(Rc::new(Type { shape: Shape::Scalar(scalar), scalars: Some(1), depth: 0 }));
        match kind {
            22 | 23 => {
                let count = stream.unsigned()?;
                let mut names = Vec::new();
                for i in 0..count {
                    let name = stream.unsigned()?;
                    if i < 10 {
                        names.push(name);
                    }
                }
                scalar(enumeration(&names, count, texts)?)
            }
            25 => scalar(Scalar::Integer(32)),
            26 => scalar(Scalar::Integer(64)),
            27 => scalar(Scalar::Real),
            28 | 29 => {
                if version > 0 {
                    for _ in 0..stream.unsigned()? {
                        stream.unsigned()?;
                        stream.signed()?;
                    }
                }
                scalar(Scalar::Integer(if kind == 28 { 32 } else { 64 }))
            }
            34 => {
                let base = self.get(stream.unsigned()?)?;
                Range::read(stream)?;
                Ok(base)
            }
            31 => {
                let element = self.get(stream.unsigned()?)?;
                let dimensions = stream.unsigned()?;
                for _ in 0..dimensions {
                    stream.unsigned()?;
                }
                // as many bytes were there
                let open = Range { down: false, left: 1, right: 0 };
                array(element, vec![open; dimensions as usize].into(), true)
            }
            35 | 38 => {
                let base = self.get(stream.unsigned()?)?;
                bounded(stream, &base, kind == 35)
            }
            37 | 39 => self.get(stream.unsigned()?),
            32 => {
                let mut fields = Vec::new();
                for _ in 0..stream.unsigned()? {
                    fields.push((stream.unsigned()?, self.get(stream.unsigned()?)?));
                }
                record(fields)
            }
            _ => Err(Stop::Wrong("a type")),
        }
    }
}

/// Which type of named values it is.
fn enumeration(names: &[u64], count: u64, texts: &Texts) -> Result<Scalar, Stop> {
    let mut values = Vec::new();
    // a letter between quotes
    for name in names.iter().filter(|name| texts.length(**name) <= 3) {
        values.push(texts.get(*name)?);
    }
    let are = |wanted: &str| {
        let value = |text: &String| text.trim_matches('\'').to_ascii_uppercase();
        count == wanted.len() as u64 && values.iter().map(value).eq(wanted.chars().map(String::from))
    };
    Ok(if are("UX01ZWLH-") {
        Scalar::Logic
    } else if are("01") {
        Scalar::Bit
    } else {
        // a value is a byte
        Scalar::Enum((u64::BITS - count.saturating_sub(1).leading_zeros()).clamp(1, 8))
    })
}

fn deeper(depth: u32) -> Result<u32, Stop> {
    if depth < MAX_DEPTH { Ok(depth + 1) } else { Err(Stop::Wrong("the depth of a type")) }
}

fn array(element: Rc<Type>, ranges: Rc<[Range]>, open: bool) -> Result<Rc<Type>, Stop> {
    let depth = deeper(element.depth)?;
    let elements = || ranges.iter().fold(1_u64, |n, range| n.saturating_mul(range.len()));
    let scalars = element.scalars.filter(|_| !open).map(|n| n.saturating_mul(elements()));
    Ok(Rc::new(Type { shape: Shape::Array(element, ranges), scalars, depth }))
}

fn record(fields: Vec<(u64, Rc<Type>)>) -> Result<Rc<Type>, Stop> {
    let depth = deeper(fields.iter().map(|(_, kind)| kind.depth).max().unwrap_or(0))?;
    let scalars = fields.iter().try_fold(0_u64, |n, (_, kind)| Some(n.saturating_add(kind.scalars?)));
    Ok(Rc::new(Type { shape: Shape::Record(fields.into()), scalars, depth }))
}

/// A type with its bounds, where it leaves them open; those of an array that `again` asks for in any case.
fn bounded(stream: &mut Stream<impl BufRead>, base: &Rc<Type>, again: bool) -> Result<Rc<Type>, Stop> {
    match &base.shape {
        Shape::Array(element, ranges) if again || base.scalars.is_none() => {
            let mut bounds = Vec::new();
            for _ in 0..ranges.len() {
                bounds.push(Range::read(stream)?);
            }
            let element = if element.scalars.is_none() { bounded(stream, element, false)? } else { element.clone() };
            array(element, bounds.into(), false)
        }
        Shape::Record(fields) if base.scalars.is_none() => {
            let mut bounds = Vec::new();
            for (name, kind) in fields.iter() {
                let kind = if kind.scalars.is_none() { bounded(stream, kind, false)? } else { kind.clone() };
                bounds.push((*name, kind));
            }
            record(bounds)
        }
        _ => Ok(base.clone()),
    }
}
