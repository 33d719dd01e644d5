//! The blocks of an FST file: which there are, where they lie, and what stands in those that are small.

use std::io::{Read, SeekFrom};

use super::bytes::Bytes;
use super::notes::Notes;
use super::{Fault, Input, unpack};

/// The length of the block with the header.
const HEADER: u64 = 329;
/// A number by which the order of bytes in numbers can be told.
const E: f64 = std::f64::consts::E;

/// A block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// What is in it.
    pub kind: u8,
    /// Where its contents begin, behind its length.
    pub at: u64,
    /// How long they are.
    pub length: u64,
}

/// What a file says of itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    /// A tick as a power of ten of a second.
    pub exponent: i32,
    /// Whether real numbers have their lowest byte first.
    pub little: bool,
}

/// What the values of a signal are in the file.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Form {
    /// So many characters.
    Bits(u32),
    Real,
    Text,
}

/// The blocks of a file.
pub(super) struct Blocks {
    pub header: Header,
    /// What the signals are.
    pub geometry: Option<Vec<Form>>,
    /// The names.
    pub hierarchy: Option<Vec<u8>>,
    /// The blocks with values, in the order of time.
    pub values: Vec<Block>,
}

/// Whether a file that begins so is FST.
pub(super) fn is_fst(beginning: &[u8]) -> bool {
    let mut bytes = Bytes(beginning);
    match (bytes.byte(), bytes.number()) {
        (Some(0), Some(length)) => {
            let e = beginning.get(25..33).and_then(|bytes| bytes.first_chunk());
            length == HEADER || e.is_some_and(|e| f64::from_le_bytes(*e) == E || f64::from_be_bytes(*e) == E)
        }
        (Some(254), Some(_)) => beginning.get(17..19) == Some(&[0x1f, 0x8b]),
        _ => false,
    }
}

/// Reads a part of a file.
pub(super) fn part(input: &mut dyn Input, at: u64, length: u64) -> Result<Vec<u8>, Fault> {
    let mut read = || {
        input.seek(SeekFrom::Start(at))?;
        let mut bytes = Vec::new();
        (&mut *input).take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().map_err(Fault::Io)?;
    if bytes.len() as u64 == length {
        Ok(bytes)
    } else {
        Err(Fault::Cut(format!("what begins at byte {at} is not complete")))
    }
}

/// A file that is packed as a whole, as it was before.
pub(super) fn unwrapped(input: &mut dyn Input, notes: &mut Notes) -> Result<Option<Vec<u8>>, Fault> {
    let end = input.seek(SeekFrom::End(0)).map_err(Fault::Io)?;
    let beginning = part(input, 0, end.min(17))?;
    let mut bytes = Bytes(&beginning);
    if bytes.byte() != Some(254) {
        return Ok(None);
    }
    let (length, unpacked) = (bytes.number(), bytes.number());
    let Some(unpacked) = unpacked else { return Err(Fault::Cut("it has nothing in it".to_owned())) };
    let packed = part(input, 17, end - 17)?;
    if length.is_none_or(|length| length > end - 1) || length == Some(0) {
        notes.cut("what is packed in it is not complete");
    }
    let file = unpack::gzip(&packed, unpacked);
    let file = file.ok_or_else(|| Fault::Malformed("what is packed in it cannot be unpacked".to_owned()))?;
    if file.len() as u64 != unpacked {
        notes.cut("what is packed in it is not complete");
    }
    Ok(Some(file))
}

impl Blocks {
    /// Looks through a file.
    pub fn of(input: &mut dyn Input, notes: &mut Notes) -> Result<Blocks, Fault> {
        let end = input.seek(SeekFrom::End(0)).map_err(Fault::Io)?;
        let mut header = None;
        let mut blocks = Blocks {
            header: Header { exponent: 0, little: true },
            geometry: None,
            hierarchy: None,
            values: Vec::new(),
        };
        let mut at = 0;
        while at < end {
            let beginning = part(input, at, (end - at).min(9))?;
            let mut bytes = Bytes(&beginning);
            let (Some(kind), Some(length)) = (bytes.byte(), bytes.number()) else {
                notes.cut(format!("the block at byte {at} is not complete"));
                break;
            };
            // a writer that goes on has not said yet how long its last block is
            if kind == 255 && length == 0 {
                notes.cut("what wrote it did not finish");
                break;
            }
            if length < 8 || length > end - at - 1 {
                notes.cut(format!("the block at byte {at} is not complete"));
                break;
            }
            let block = Block { kind, at: at + 9, length: length - 8 };
            let wrong = |what: &str| Fault::Malformed(format!("{what} at byte {at}"));
            match kind {
                0 => {
                    header = Some(Header::of(&part(input, block.at, block.length)?).ok_or_else(|| wrong("its header"))?)
                }
                1 | 5 | 8 => blocks.values.push(block),
                3 => {
                    let geometry = geometry(&part(input, block.at, block.length)?);
                    blocks.geometry = Some(geometry.ok_or_else(|| wrong("what it says of its signals"))?);
                }
                4 | 6 | 7 => {
                    let names = hierarchy(kind, &part(input, block.at, block.length)?);
                    blocks.hierarchy = Some(names.ok_or_else(|| wrong("what it says of its names"))?);
                }
                // times at which nothing was recorded; what is to be passed over
                2 | 255 => {}
                _ => notes
                    .add("block", || format!("the block at byte {at} is passed over: its kind {kind} is not known")),
            }
            at += 1 + length;
        }
        blocks.header = header.ok_or_else(|| Fault::Cut("its header is not complete".to_owned()))?;
        Ok(blocks)
    }
}

impl Header {
    fn of(bytes: &[u8]) -> Option<Header> {
        let e: &[u8; 8] = bytes.get(16..24)?.first_chunk()?;
        let little = if f64::from_le_bytes(*e) == E {
            true
        } else if f64::from_be_bytes(*e) == E {
            false
        } else {
            return None;
        };
        Some(Header { exponent: i32::from(bytes.get(64)?.cast_signed()), little })
    }
}

/// What each signal is: a number of at least a byte.
fn geometry(bytes: &[u8]) -> Option<Vec<Form>> {
    let mut bytes = Bytes(bytes);
    let (unpacked, count) = (bytes.number()?, bytes.number()?);
    let unpacked = unpack::zlib_or_plain(bytes.0, unpacked)?;
    let mut bytes = Bytes(&unpacked);
    if count > unpacked.len() as u64 {
        return None;
    }
    let form = |number: u64| match u32::try_from(number).ok()? {
        0 => Some(Form::Real),
        u32::MAX => Some(Form::Text),
        width => Some(Form::Bits(width)),
    };
    (0..count).map(|_| form(bytes.variable()?)).collect()
}

/// The names; the last kind is packed twice.
fn hierarchy(kind: u8, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Bytes(bytes);
    let unpacked = bytes.number()?;
    match kind {
        4 => unpack::gzip(bytes.0, unpacked).filter(|names| names.len() as u64 == unpacked),
        6 => unpack::lz4(bytes.0, unpacked),
        _ => {
            let once = bytes.variable()?;
            unpack::lz4(&unpack::lz4(bytes.0, once)?, unpacked)
        }
    }
}
