//! Writing VCD (IEEE 1364-2005, clause 18) while a run goes on.
//!
//! The `vcd` crate writes the header, the times and the commands; values are formatted here, eight bits at a time, into
//! the same buffer. The bytes are the same everywhere: no date, no version number. A file cut off at the end of any line
//! after the header reads as the run up to there.

use std::io;

use vcd::{IdCode, ReferenceIndex, ScopeType, SimulationCommand, TimescaleUnit, VarType};

use super::layout::Declaration;
use super::output::Destination;
use super::recorder::{Format, Recorder};
use super::{Layout, ScopeKind, VarKind};
use crate::timescale::Unit;
use crate::value::Word;

/// The destination is given whole lines, about this many bytes at a time.
const CHUNK: usize = 1 << 16;

/// A [`Sink`](super::Sink) that writes VCD.
///
/// ```
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
    out: vcd::Writer<Vec<u8>>,
    /// What stands behind the values of each slot.
    tails: Vec<Tail>,
}

/// A space for a vector, the identifier, the end of the line.
#[derive(Clone, Copy)]
struct Tail {
    text: [u8; TAIL],
    len: u8,
}

/// A space, an identifier of at most ten characters (64 bits to the base 94), the end of the line.
const TAIL: usize = 12;

impl<D: Destination> VcdWriter<D> {
    /// A writer into this destination; nothing is written before [`Sink::begin`](super::Sink::begin).
    pub fn new(destination: D) -> VcdWriter<D> {
        let out = vcd::Writer::new(Vec::with_capacity(CHUNK + CHUNK / 4));
        Recorder::with(Vcd { destination, out, tails: Vec::new() })
    }
}

impl<D: Destination> Vcd<D> {
    /// Hands the buffer on if there is enough in it. Only called at the end of a line.
    fn drain(&mut self, at_least: usize) -> io::Result<()> {
        let buffer = self.out.writer();
        if buffer.len() >= at_least {
            self.destination.write_all(buffer)?;
            buffer.clear();
        }
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
            self.drain(CHUNK)?;
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
            self.tails.push(Tail { text: tail, len: text.len() as u8 });
            ids.push(id);
            id = following(id);
        }
        self.declare(layout, slot_of, &ids)?;
        self.drain(0)
    }

    fn first(&mut self, now: u64) -> io::Result<()> {
        self.out.timestamp(now)?;
        self.out.begin(SimulationCommand::Dumpvars)
    }

    fn first_done(&mut self) -> io::Result<()> {
        self.out.end()
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.out.timestamp(now)
    }

    /// At full width: every reader takes that, and none has to extend it.
    fn value(&mut self, slot: usize, width: u32, words: &[Word]) -> io::Result<()> {
        let tail = &self.tails[slot];
        let out = self.out.writer();
        if width == 1 {
            out.push(ascii(words[0].v as u8 & 1, words[0].u as u8 & 1)[7]);
        } else {
            out.push(b'b');
            let mut bytes = width.div_ceil(8);
            // Pieces of a fixed size, shortened afterwards: a copy of unknown length costs more than it copies.
            let (first, unused) = (out.len(), (bytes * 8 - width) as usize);
            while bytes > 0 {
                bytes -= 1;
                let (word, shift) = (words[bytes as usize / 8], bytes % 8 * 8);
                let mut text = ascii((word.v >> shift) as u8, (word.u >> shift) as u8);
                if out.len() == first && unused > 0 {
                    text.rotate_left(unused);
                    out.extend_from_slice(&text);
                    out.truncate(first + 8 - unused);
                } else {
                    out.extend_from_slice(&text);
                }
            }
        }
        out.extend_from_slice(&tail.text);
        out.truncate(out.len() - (TAIL - tail.len as usize));
        // One value may be wide, and there may be many in one tick.
        self.drain(CHUNK)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.drain(0)?;
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

/// Eight bits as text, the most significant first: in each byte of a word `0`, plus 1 for v, plus the distance to `x`
/// for u, plus 1 more for both, which is `z`.
fn ascii(v: u8, u: u8) -> [u8; 8] {
    const ZEROS: u64 = u64::from_be_bytes([b'0'; 8]);
    const TO_X: u64 = (b'x' - b'0') as u64;
    let (v, u) = (SPREAD[v as usize], SPREAD[u as usize]);
    (ZEROS + v + u * TO_X + (v & u)).to_be_bytes()
}

/// Bit i of the index in byte i.
const SPREAD: [u64; 256] = {
    let mut table = [0; 256];
    let mut n = 0;
    while n < 256 {
        let mut bit = 0;
        while bit < 8 {
            table[n] |= (n as u64 >> bit & 1) << (bit * 8);
            bit += 1;
        }
        n += 1;
    }
    table
};

#[cfg(test)]
#[path = "vcd_tests.rs"]
mod tests;
