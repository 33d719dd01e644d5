//! Writing VCD (IEEE 1364-2005, clause 18) while a run goes on.
//!
//! The `vcd` crate writes the header and the commands. It takes a vector bit by bit and passes each on to the destination,
//! so times and values, which are nearly all of a file, are formatted here, eight bits or two digits at a time: `cargo
//! bench --bench wave` measures both (docs/inside-the-compiled-engine.md). The bytes are the same everywhere: no date, no
//! version number. A file cut off at the end of any line after the header reads as the run up to there.

use std::io;

use vcd::{IdCode, ReferenceIndex, ScopeType, SimulationCommand, TimescaleUnit, VarType};

use super::layout::Declaration;
use super::output::{Destination, Piece};
use super::recorder::{Format, Recorder};
use super::{Layout, ScopeKind, VarKind};
use crate::Unit;
use crate::value::Word;

/// The destination is given whole lines, about this many bytes at a time.
const CHUNK: usize = 1 << 16;

/// A [`Sink`](super::Sink) that writes VCD.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod wave { pub use discreta_wave::*; }
/// # }
/// use discreta::value::Word;
/// use discreta::wave::{Layout, Sink, vcd::VcdWriter};
///
/// let mut layout = Layout::default();
/// let top = layout.scope("top", None);
/// let q = layout.var(top, "q", 4);
///
/// let mut bytes = Vec::new();
/// let mut vcd = VcdWriter::new(&mut bytes);
/// vcd.begin(&layout)?;
/// vcd.time(0)?;
/// vcd.time(5)?;
/// vcd.change(q, &[Word::known(9)]);
/// vcd.finish(10)?;
/// assert!(String::from_utf8_lossy(&bytes).ends_with("#0\n$dumpvars\nbxxxx !\n$end\n#5\nb1001 !\n#10\n"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub type VcdWriter<D> = Recorder<Vcd<D>>;

/// The format of VCD.
pub struct Vcd<D> {
    destination: D,
    /// What the crate writes.
    out: vcd::Writer<Vec<u8>>,
    /// Text that the destination has not been given yet: `end` bytes, and room for more.
    text: Vec<u8>,
    end: usize,
    /// What stands around the values of each slot.
    frames: Vec<Frame>,
}

/// The lines of a slot, but for the value.
#[derive(Clone, Copy)]
struct Frame {
    /// A space for a vector, the identifier, the end of the line.
    tail: [u8; TAIL],
    len: u8,
    /// Characters before the value: the `b` of a vector.
    lead: u8,
}

/// A space, an identifier of at most ten characters (64 bits to the base 94), the end of the line; rounded up to what is
/// copied at once.
const TAIL: usize = 16;
/// The most that a value of one word is written to: `b`, the digits, the rest.
const LINE: usize = 1 + 64 + TAIL;
/// The sign of a time, the digits of the longest, the end of the line, and a digit too many.
const STAMP: usize = 23;

impl<D: Destination> VcdWriter<D> {
    /// A writer into this destination; nothing is written before [`Sink::begin`](super::Sink::begin).
    pub fn new(destination: D) -> VcdWriter<D> {
        let out = vcd::Writer::new(Vec::new());
        Recorder::with(Vcd { destination, out, text: vec![0; CHUNK], end: 0, frames: Vec::new() })
    }
}

impl<D: Destination> Vcd<D> {
    /// Hands on what there is. Only called at the end of a line.
    fn drain(&mut self) -> io::Result<()> {
        let mut text = std::mem::take(&mut self.text);
        text.truncate(self.end);
        self.end = 0;
        self.text = self.destination.give(Piece::Made(text))?;
        self.text.resize(CHUNK, 0);
        Ok(())
    }

    /// Room for some bytes of text.
    #[inline(always)]
    fn room(&mut self, bytes: usize) -> io::Result<&mut [u8]> {
        if self.text.len() - self.end < bytes {
            self.drain()?;
            // one value may be wide
            if self.text.len() < bytes {
                self.text.resize(bytes, 0);
            }
        }
        Ok(&mut self.text[self.end..self.end + bytes])
    }

    /// Takes over what the crate has written.
    fn take(&mut self) -> io::Result<()> {
        let written = std::mem::take(self.out.writer());
        self.room(written.len())?.copy_from_slice(&written);
        self.end += written.len();
        Ok(())
    }

    fn declare(&mut self, layout: &Layout, slot_of: &[u32], ids: &[IdCode]) -> io::Result<()> {
        self.out.version("discreta")?;
        self.out.timescale(layout.timescale.count(), unit(layout.timescale.unit()))?;

        for declaration in layout.outline() {
            match declaration {
                Declaration::Open(scope) => {
                    let kind = match layout.scopes[scope].kind {
                        ScopeKind::Module => ScopeType::Module,
                        ScopeKind::Block => ScopeType::Begin,
                    };
                    self.out.scope_def(kind, &layout.scopes[scope].name)?;
                }
                Declaration::Var(i) => {
                    let var = &layout.vars[i];
                    let kind = match var.kind {
                        VarKind::Wire => VarType::Wire,
                        VarKind::Reg => VarType::Reg,
                        VarKind::Integer => VarType::Integer,
                    };
                    let index = (var.width > 1).then(|| ReferenceIndex::Range(var.width as i32 - 1, 0));
                    self.out.var_def(kind, var.width, ids[slot_of[i] as usize], &var.name, index)?;
                }
                Declaration::Close => self.out.upscope()?,
            }
            self.take()?;
        }
        self.out.enddefinitions()
    }
}

impl<D: Destination> Format for Vcd<D> {
    fn header(&mut self, layout: &Layout, slot_of: &[u32]) -> io::Result<()> {
        let mut ids = Vec::new();
        let mut id = IdCode::FIRST;
        for var in layout.vars.iter().filter(|var| var.alias_of.is_none()) {
            let text = if var.width == 1 { format!("{id}\n") } else { format!(" {id}\n") };
            let mut tail = [0; TAIL];
            tail[..text.len()].copy_from_slice(text.as_bytes());
            self.frames.push(Frame { tail, len: text.len() as u8, lead: u8::from(var.width > 1) });
            ids.push(id);
            id = following(id);
        }
        self.declare(layout, slot_of, &ids)?;
        self.take()?;
        self.drain()
    }

    fn first(&mut self, now: u64) -> io::Result<()> {
        self.out.timestamp(now)?;
        self.out.begin(SimulationCommand::Dumpvars)?;
        self.take()
    }

    fn first_done(&mut self) -> io::Result<()> {
        self.out.end()?;
        self.take()
    }

    #[inline]
    fn time(&mut self, now: u64) -> io::Result<()> {
        let out = self.room(STAMP)?;
        out[0] = b'#';
        let digits = now.checked_ilog10().unwrap_or(0) as usize + 1;
        let (mut rest, mut at) = (now, digits);
        // two at a time from the back; one too many falls on the sign, which is put there again
        while at > 0 {
            let pair = TWO_DIGITS[(rest % 100) as usize];
            rest /= 100;
            out[at] = pair[1];
            out[at - 1] = pair[0];
            at = at.saturating_sub(2);
        }
        out[0] = b'#';
        out[digits + 1] = b'\n';
        self.end += digits + 2;
        Ok(())
    }

    /// At full width: every reader takes that, and none has to extend it.
    fn value(&mut self, slot: usize, width: u32, words: &[Word]) -> io::Result<()> {
        if let [word] = words {
            return self.word(slot, width, *word);
        }
        let frame = self.frames[slot];
        let pieces = width.div_ceil(8) as usize;
        // the first bit comes first, so the last piece may be too long: what stands behind it is put over that
        let out = self.room(1 + 8 * pieces + TAIL)?;
        out[0] = b'b';
        for (i, chunk) in out[1..].as_chunks_mut::<8>().0.iter_mut().take(pieces).enumerate() {
            let (v, u) = byte(words, width as usize - 8 * i);
            *chunk = text(v, u);
        }
        let at = 1 + width as usize;
        out[at..at + TAIL].copy_from_slice(&frame.tail);
        self.end += at + usize::from(frame.len);
        Ok(())
    }

    /// In as many steps for one bit as for half a word: which comes next nobody can foresee, and to be wrong about it costs
    /// more.
    #[inline(always)]
    fn word(&mut self, slot: usize, width: u32, word: Word) -> io::Result<()> {
        let frame = self.frames[slot];
        let room = self.room(LINE)?;
        let (out, width) = (room.first_chunk_mut::<LINE>().expect("that much was asked for"), width as usize & 127);
        let lead = usize::from(frame.lead & 1);
        out[0] = b'b';
        let (v, u) = ((word.v << (64 - width)).to_be_bytes(), word.u << (64 - width));
        let digits: &mut [u8; 64] = out[lead..].first_chunk_mut().expect("a line has room for them");
        let (digits, _) = digits.as_chunks_mut::<8>();
        (0..4).for_each(|i| digits[i] = DIGITS[v[i] as usize]);
        if width > 32 {
            (4..8).for_each(|i| digits[i] = DIGITS[v[i] as usize]);
        }
        if u != 0 {
            let u = u.to_be_bytes();
            (0..8).for_each(|i| digits[i] = text(v[i], u[i]));
        }
        let at = lead + width;
        // over what is too much of the last digits
        out[at..at + TAIL].copy_from_slice(&frame.tail);
        self.end += at + usize::from(frame.len);
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.drain()?;
        self.destination.complete()
    }
}

/// The next identifier. One that ends a declaration for readers that look for these characters wherever they stand
/// (`wellen` does) is left out; it would be that of the 56 millionth variable.
fn following(id: IdCode) -> IdCode {
    let mut next = id.next();
    while next.to_string().contains("$end") {
        next = next.next();
    }
    next
}

fn unit(unit: Unit) -> TimescaleUnit {
    match unit {
        Unit::Fs => TimescaleUnit::FS,
        Unit::Ps => TimescaleUnit::PS,
        Unit::Ns => TimescaleUnit::NS,
        Unit::Us => TimescaleUnit::US,
        Unit::Ms => TimescaleUnit::MS,
        Unit::S => TimescaleUnit::S,
    }
}

/// The eight bits below bit `high` of a vector; below bit 0 there is nothing.
fn byte(words: &[Word], high: usize) -> (u8, u8) {
    if high < 8 {
        return ((words[0].v << (8 - high)) as u8, (words[0].u << (8 - high)) as u8);
    }
    let (at, shift) = ((high - 8) / 64, (high - 8) % 64);
    let next = words.get(at + 1).copied().unwrap_or_default();
    let bits = |low: u64, high: u64| (low >> shift | (high << 1) << (63 - shift)) as u8;
    (bits(words[at].v, next.v), bits(words[at].u, next.u))
}

/// Eight bits as text, the most significant first: in each byte of a word `0`, plus 1 for v, plus the distance to `x`
/// for u, plus 1 more for both, which is `z`.
#[inline(always)]
fn text(v: u8, u: u8) -> [u8; 8] {
    const TO_X: u64 = (b'x' - b'0') as u64;
    let known = ZEROS + SPREAD[v as usize];
    if u == 0 {
        return known.to_le_bytes();
    }
    (known + SPREAD[u as usize] * TO_X + SPREAD[(v & u) as usize]).to_le_bytes()
}

/// Eight digits.
const ZEROS: u64 = u64::from_le_bytes([b'0'; 8]);

/// Bit i of the index in byte 7 - i.
const SPREAD: [u64; 256] = {
    let mut table = [0; 256];
    let mut n = 0;
    while n < 256 {
        let mut bit = 0;
        while bit < 8 {
            table[n] |= (n as u64 >> bit & 1) << ((7 - bit) * 8);
            bit += 1;
        }
        n += 1;
    }
    table
};

/// Eight known bits as text.
const DIGITS: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut n = 0;
    while n < 256 {
        table[n] = (ZEROS + SPREAD[n]).to_le_bytes();
        n += 1;
    }
    table
};

/// The numbers below 100 in two digits.
const TWO_DIGITS: [[u8; 2]; 100] = {
    let mut table = [[b'0'; 2]; 100];
    let mut n = 0;
    while n < 100 {
        table[n] = [b'0' + n as u8 / 10, b'0' + n as u8 % 10];
        n += 1;
    }
    table
};

#[cfg(test)]
#[path = "vcd_tests.rs"]
mod tests;
