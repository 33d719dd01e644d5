//! Writing VCD (IEEE 1364-2005, clause 18) while a run goes on.
//!
//! The `vcd` crate writes the header, the times and the commands; values are formatted here, eight bits at a time, into
//! the same buffer. What is kept is two values a variable, so memory does not grow with the run. The bytes are the same
//! everywhere: no date, no version number. A file cut off at the end of any line after the header reads as the run up
//! to there.

use std::io;

use vcd::{IdCode, ReferenceIndex, ScopeType, SimulationCommand, TimescaleUnit, VarType};

use super::output::Destination;
use super::{Layout, ScopeKind, Sink, VarKind};
use crate::timescale::Unit;
use crate::value::{Word, word};

/// The destination is given whole lines, about this many bytes at a time.
const CHUNK: usize = 1 << 16;

/// A [`Sink`] that writes VCD.
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
pub struct VcdWriter<D> {
    destination: D,
    out: vcd::Writer<Vec<u8>>,
    /// What holds a value: the variables that are no alias, in the order of the layout.
    slots: Vec<Slot>,
    /// Variable to slot.
    slot_of: Vec<u32>,
    /// The values as the file has them, slot after slot, and as they are now.
    written: Vec<Word>,
    current: Vec<Word>,
    /// The slots that were changed in this tick.
    touched: Vec<u32>,
    now: Option<u64>,
    /// The last time that the file has; none before the initial values.
    stamped: Option<u64>,
}

struct Slot {
    start: usize,
    width: u32,
    touched: bool,
    /// What stands behind a value: a space for a vector, the identifier, the end of the line.
    tail: [u8; TAIL],
    tail_len: u8,
}

/// A space, an identifier of at most ten characters (64 bits to the base 94), the end of the line.
const TAIL: usize = 12;

impl Slot {
    fn words(&self) -> std::ops::Range<usize> {
        self.start..self.start + word::words(self.width)
    }
}

impl<D: Destination> VcdWriter<D> {
    /// A writer into this destination; nothing is written before [`Sink::begin`].
    pub fn new(destination: D) -> VcdWriter<D> {
        VcdWriter {
            destination,
            out: vcd::Writer::new(Vec::with_capacity(CHUNK + CHUNK / 4)),
            slots: Vec::new(),
            slot_of: Vec::new(),
            written: Vec::new(),
            current: Vec::new(),
            touched: Vec::new(),
            now: None,
            stamped: None,
        }
    }

    /// Hands the buffer on if there is enough in it. Only called at the end of a line.
    fn drain(&mut self, at_least: usize) -> io::Result<()> {
        let buffer = self.out.writer();
        if buffer.len() >= at_least {
            self.destination.write_all(buffer)?;
            buffer.clear();
        }
        Ok(())
    }

    fn header(&mut self, layout: &Layout, ids: &[IdCode]) -> io::Result<()> {
        self.out.version("discreta")?;
        self.out.timescale(layout.timescale.count(), unit(layout.timescale.unit()))?;

        // Children and variables of each scope, in order, without a list for each: indices sorted by scope.
        let mut scopes: Vec<usize> = (0..layout.scopes.len()).collect();
        scopes.sort_by_key(|&i| layout.scopes[i].parent);
        let mut vars: Vec<usize> = (0..layout.vars.len()).collect();
        vars.sort_by_key(|&i| layout.vars[i].scope);
        let children = |parent: Option<usize>| {
            let from = scopes.partition_point(|&i| layout.scopes[i].parent < parent);
            let to = scopes.partition_point(|&i| layout.scopes[i].parent <= parent);
            scopes[from..to].iter()
        };

        let mut open = vec![children(None)];
        while let Some(siblings) = open.last_mut() {
            let Some(&scope) = siblings.next() else {
                open.pop();
                if !open.is_empty() {
                    self.out.upscope()?;
                }
                continue;
            };
            let decl = &layout.scopes[scope];
            let kind = match decl.kind {
                ScopeKind::Module => ScopeType::Module,
                ScopeKind::Block => ScopeType::Begin,
            };
            self.out.scope_def(kind, &decl.name)?;
            let from = vars.partition_point(|&i| layout.vars[i].scope < scope);
            for &i in vars[from..].iter().take_while(|&&i| layout.vars[i].scope == scope) {
                let var = &layout.vars[i];
                let kind = match var.kind {
                    VarKind::Wire => VarType::Wire,
                    VarKind::Reg => VarType::Reg,
                    VarKind::Integer => VarType::Integer,
                };
                let index = (var.width > 1).then(|| ReferenceIndex::Range(var.width as i32 - 1, 0));
                self.out.var_def(kind, var.width, ids[self.slot_of[i] as usize], &var.name, index)?;
            }
            self.drain(CHUNK)?;
            open.push(children(Some(scope)));
        }
        self.out.enddefinitions()
    }

    /// Writes what this tick has changed.
    fn settle(&mut self) -> io::Result<()> {
        let Some(now) = self.now else { return Ok(()) };
        if self.stamped.is_none() {
            self.out.timestamp(now)?;
            self.out.begin(SimulationCommand::Dumpvars)?;
            for i in 0..self.slots.len() {
                self.value(i)?;
                self.slots[i].touched = false;
            }
            self.out.end()?;
            self.stamped = Some(now);
            self.touched.clear();
            return self.drain(CHUNK);
        }
        // In the order of the layout, whatever the order in which the engine came to them.
        self.touched.sort_unstable();
        for i in 0..self.touched.len() {
            let i = self.touched[i] as usize;
            let slot = &mut self.slots[i];
            slot.touched = false;
            let unchanged = match slot.width {
                ..=64 => self.written[slot.start] == self.current[slot.start],
                _ => self.written[slot.words()] == self.current[slot.words()],
            };
            if unchanged {
                continue;
            }
            if self.stamped != Some(now) {
                self.out.timestamp(now)?;
                self.stamped = Some(now);
            }
            self.value(i)?;
        }
        self.touched.clear();
        self.drain(CHUNK)
    }

    /// Writes the current value of a slot, at full width: every reader takes that, and none has to extend it.
    fn value(&mut self, slot: usize) -> io::Result<()> {
        let slot = &self.slots[slot];
        let range = slot.words();
        let words = &self.current[range.clone()];
        let out = self.out.writer();
        if slot.width == 1 {
            out.push(ascii(words[0].v as u8 & 1, words[0].u as u8 & 1)[7]);
        } else {
            out.push(b'b');
            let mut bytes = slot.width.div_ceil(8);
            // Pieces of a fixed size, shortened afterwards: a copy of unknown length costs more than it copies.
            let (first, unused) = (out.len(), (bytes * 8 - slot.width) as usize);
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
        out.extend_from_slice(&slot.tail);
        out.truncate(out.len() - (TAIL - slot.tail_len as usize));
        if slot.width <= 64 {
            self.written[slot.start] = self.current[slot.start];
        } else {
            self.written[range.clone()].copy_from_slice(&self.current[range]);
        }
        // One value may be wide, and there may be many in one tick.
        self.drain(CHUNK)
    }
}

impl<D: Destination> Sink for VcdWriter<D> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        layout.check().map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        let mut ids = Vec::new();
        let mut id = IdCode::FIRST;
        for var in &layout.vars {
            if let Some(of) = var.alias_of {
                self.slot_of.push(self.slot_of[of]);
                continue;
            }
            let text = if var.width == 1 { format!("{id}\n") } else { format!(" {id}\n") };
            let mut tail = [0; TAIL];
            tail[..text.len()].copy_from_slice(text.as_bytes());
            let start = self.current.len();
            self.slot_of.push(self.slots.len() as u32);
            self.slots.push(Slot { start, width: var.width, touched: false, tail, tail_len: text.len() as u8 });
            self.current.extend((0..word::words(var.width)).map(|i| Word::x(word::word_mask(var.width, i))));
            ids.push(id);
            id = following(id);
        }
        self.written = self.current.clone();
        self.header(layout, &ids)?;
        self.drain(0)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        match self.now {
            Some(before) if before == now => return Ok(()),
            Some(before) if before > now => return Err(backwards(before, now)),
            _ => {}
        }
        self.settle()?;
        self.now = Some(now);
        Ok(())
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        assert!(self.now.is_some(), "a change before any time");
        let index = self.slot_of[var];
        let slot = &mut self.slots[index as usize];
        if slot.width <= 64 {
            self.current[slot.start] = value[0];
        } else {
            self.current[slot.words()].copy_from_slice(&value[..word::words(slot.width)]);
        }
        if !slot.touched {
            slot.touched = true;
            self.touched.push(index);
        }
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        match self.now {
            None => self.now = Some(0),
            Some(before) if before > end => return Err(backwards(before, end)),
            Some(_) => {}
        }
        self.settle()?;
        if self.stamped != Some(end) {
            self.out.timestamp(end)?;
        }
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

fn backwards(before: u64, now: u64) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("time goes back from {before} to {now}"))
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
