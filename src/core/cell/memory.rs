//! Memories: what is read, what is written, by ports of any number that are clocked or not.
//!
//! The meaning is that of Yosys' `$mem_v2` as its `simlib.v` has it, which is that of a Verilog array: IEEE 1364-2005,
//! 4.9.1 (an address that is x, z or outside reads x; 9.2: what is written there is lost). In particular
//!
//! - a bit whose enable is x or z is not written; a read port whose enable is x or z keeps what it has;
//! - of several ports that write a bit at one instant the last wins;
//! - a clocked read port samples what was there before any port writes at the same instant, except where it is
//!   *transparent* to a port that writes its address (it has what is written) or *collides* with it (it has x);
//! - of a read port the asynchronous reset goes before the synchronous one, and that before reading;
//! - a port without a clock acts at once: it writes while it is enabled, it reads whenever anything changes. It goes
//!   before what ports with a clock have written.
//!
//! A wide port of Yosys is several ports here, each with its own address.
//!
//! The words are not pins. Whoever runs the cell keeps them, laid out as [`Memory::contents`] are, and calls these
//! functions with them.

use std::sync::Arc;

use super::element::{Element, Kind, Parameter, Port};
use super::{CellKind, Edge};
use crate::Value;
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

/// A memory. Pins hold all ports, the first in the low bits; words have addresses from `offset` up.
#[derive(Clone, PartialEq, Debug)]
pub struct Memory {
    /// Bits of a word, at least one.
    pub width: u32,
    /// How many words.
    pub size: u32,
    /// The address of the first word.
    pub offset: i32,
    /// Bits of an address, at most 64.
    pub abits: u32,
    /// What it holds at the start, laid out as [`Memory::contents`] says.
    pub init: Arc<[Word]>,
    /// What `rd_data` is before anything has set it, for the ports with a clock.
    pub start: Value,
    /// The read ports, in the order of their bits in the pins.
    pub reads: Vec<ReadPort>,
    /// The write ports, in the order of their bits in the pins; of several that write a bit at once, the last wins.
    pub writes: Vec<WritePort>,
}

/// A read port.
#[derive(Clone, PartialEq, Debug)]
pub struct ReadPort {
    /// When it reads; at once if it has no clock.
    pub clock: Option<Edge>,
    /// Whether it is a further part of the wide port before it. It has its own address, so this says nothing of what it
    /// does.
    pub wide: bool,
    /// For each write port whether it reads what that writes at the same instant.
    pub transparent: Box<[bool]>,
    /// For each write port whether it reads x where that writes at the same instant.
    pub collides: Box<[bool]>,
    /// What the asynchronous reset gives.
    pub arst_value: Value,
    /// What the synchronous reset gives.
    pub srst_value: Value,
    /// Whether the enable decides about the synchronous reset too.
    pub enable_first: bool,
}

/// A write port.
#[derive(Clone, PartialEq, Debug)]
pub struct WritePort {
    /// When it writes; while it is enabled if it has no clock.
    pub clock: Option<Edge>,
    /// Whether it is a further part of the wide port before it.
    pub wide: bool,
    /// For each write port before it whether it is to win over it. It does so anyhow; to hardware it may be all one.
    pub priority: Box<[bool]>,
}

/// The controls of a read port as they stand.
#[derive(Clone, Copy, Debug)]
pub struct ReadControls {
    /// Bit 0: the port reads; else it keeps its value.
    pub en: Word,
    /// Bit 0: the asynchronous reset, which acts at once.
    pub arst: Word,
    /// Bit 0: the synchronous reset, which acts at the clock's edge.
    pub srst: Word,
}

/// What a write port writes at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Written<'a> {
    /// The number of the port.
    pub port: usize,
    /// The address as its pin has it, `offset` not yet subtracted.
    pub address: Word,
    /// The word to write.
    pub data: &'a [Word],
    /// A bit for each bit of `data`: 1 writes it; 0, x and z leave it.
    pub enable: &'a [Word],
}

impl Memory {
    /// How far the words of a memory are apart, in bits: a word never lies across two of the machine's unless it is wider.
    pub const fn stride(width: u32) -> u64 {
        if width <= 64 { width.next_power_of_two() as u64 } else { words(width) as u64 * 64 }
    }

    /// Contents of `size` words of `width` bits, all x.
    #[must_use]
    pub fn contents(width: u32, size: u32) -> Vec<Word> {
        let n = (Memory::stride(width) * u64::from(size)).div_ceil(64);
        let x = match width {
            0..=64 => {
                let (one, step) = (mask(width), Memory::stride(width) as u32);
                Word::x((0..64).step_by(step as usize).fold(0, |all, lo| all | one << lo))
            }
            _ => Word::x(u64::MAX),
        };
        let mut all = vec![x; n as usize];
        if width > 64 && !width.is_multiple_of(64) {
            let n = words(width);
            all.iter_mut().skip(n - 1).step_by(n).for_each(|w| *w = Word::x(word_mask(width, n - 1)));
        }
        all
    }

    /// Where a word begins in the contents, and at which bit.
    #[inline(always)]
    fn place(width: u32, index: u32) -> (usize, u32) {
        let bit = u64::from(index) * Memory::stride(width);
        ((bit / 64) as usize, (bit % 64) as u32)
    }

    /// Word `index` of some contents.
    #[must_use]
    pub fn word(width: u32, contents: &[Word], index: u32) -> Value {
        let (at, shift) = Memory::place(width, index);
        let n = words(width);
        let list: Vec<Word> = contents[at..at + n].iter().map(|w| Word { v: w.v >> shift, u: w.u >> shift }).collect();
        Value::from_words(&list, width)
    }

    /// Puts `value`, which has `width` bits, where `enable` says into word `index` of some contents.
    pub fn set_word(width: u32, contents: &mut [Word], index: u32, value: &Value, enable: impl Fn(u32) -> bool) {
        let (at, shift) = Memory::place(width, index);
        for (i, new) in value.words().enumerate() {
            let bits = (0..64.min(width - i as u32 * 64)).filter(|&b| enable(i as u32 * 64 + b));
            let m = bits.fold(0, |m, b| m | 1 << b);
            let to = &mut contents[at + i];
            *to = merged(*to, m << shift, Word { v: new.v << shift, u: new.u << shift });
        }
    }

    /// The word that an address means, if it is known and there is one. As in Verilog an address has no sign, and the
    /// difference to the offset is one of 32 bits, or of those of the address if it has more.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, address: Word) -> Option<u32> {
        if address.u != 0 {
            return None;
        }
        let index = address.v.wrapping_sub(i64::from(self.offset) as u64) & mask(self.abits.max(32));
        (index < u64::from(self.size)).then_some(index as u32)
    }

    /// What an address reads.
    #[inline]
    pub fn read(&self, contents: &[Word], address: Word, to: &mut [Word]) {
        let Some(index) = self.index(address) else {
            to.iter_mut().enumerate().for_each(|(i, w)| *w = Word::x(word_mask(self.width, i)));
            return;
        };
        let (at, shift) = Memory::place(self.width, index);
        for (i, w) in to.iter_mut().enumerate() {
            let (from, m) = (contents[at + i], word_mask(self.width, i));
            *w = Word { v: from.v >> shift & m, u: from.u >> shift & m };
        }
    }

    /// What a read port with a clock has after its edge, in `q` what it has before. `written` is what the write ports
    /// that act at the same instant write, in their order, and `contents` what was there before.
    pub fn clocked<'a>(
        &self,
        port: usize,
        contents: &[Word],
        c: ReadControls,
        address: Word,
        written: impl Iterator<Item = Written<'a>>,
        q: &mut [Word],
    ) {
        let spec = &self.reads[port];
        if c.arst.is_one() {
            return load(q, &spec.arst_value);
        }
        if c.srst.is_one() && (c.en.is_one() || !spec.enable_first) {
            return load(q, &spec.srst_value);
        }
        if !c.en.is_one() {
            return;
        }
        self.read(contents, address, q);
        for w in written {
            let (transparent, collides) = (spec.transparent[w.port], spec.collides[w.port]);
            if !(transparent || collides) || address.u | w.address.u != 0 || address.v != w.address.v {
                continue;
            }
            for (i, q) in q.iter_mut().enumerate() {
                let new = if collides { Word::x(u64::MAX) } else { w.data[i] };
                *q = merged(*q, w.enable[i].ones(), new);
            }
        }
    }

    /// What the asynchronous reset of a read port makes of what it has.
    pub fn reset(&self, port: usize, arst: Word, q: &mut [Word]) {
        if arst.is_one() {
            load(q, &self.reads[port].arst_value);
        }
    }

    /// What a write port writes: calls `put` with each machine word of the contents that it writes to, the bits of that
    /// which it writes, and what they become.
    #[inline]
    pub fn write(&self, address: Word, data: &[Word], enable: &[Word], mut put: impl FnMut(usize, u64, Word)) {
        let Some(index) = self.index(address) else { return };
        let (at, shift) = Memory::place(self.width, index);
        for (i, (new, enable)) in data.iter().zip(enable).enumerate() {
            let m = enable.ones() << shift;
            if m != 0 {
                put(at + i, m, Word { v: new.v << shift & m, u: new.u << shift & m });
            }
        }
    }
}

/// One word of contents after bits of it have been written.
#[inline(always)]
#[must_use]
pub fn merged(old: Word, bits: u64, new: Word) -> Word {
    Word { v: old.v & !bits | new.v & bits, u: old.u & !bits | new.u & bits }
}

fn load(q: &mut [Word], value: &Value) {
    q.iter_mut().zip(value.words()).for_each(|(q, w)| *q = w);
}

/// The edge of a port's clock; none for `none`.
fn clock(word: &str) -> Option<Edge> {
    (word != "none").then(|| super::storage::edge(word))
}

/// The bits that addresses of so many words need, at least one.
fn address_bits(words: u32) -> u32 {
    (u32::BITS - words.saturating_sub(1).leading_zeros()).max(1)
}

const EDGES: Kind = Kind::Word(&["none", "rising", "falling"]);

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[Element {
    name: "memory",
    summary: "memory of words with any number of ports",
    ports: &[
        Port::optional("rd_clk", "clocks of the read ports; required if `read_edge` is not `none`"),
        Port::optional("rd_en", "read enables: a port with a clock keeps its word while this is not 1"),
        Port::input("rd_addr", "addresses of the read ports"),
        Port::output("rd_data", "the words read"),
        Port::optional("wr_clk", "clocks of the write ports; required if they have some"),
        Port::optional("wr_en", "write enables, one for each bit of `wr_data`; required if there are write ports"),
        Port::optional("wr_addr", "addresses of the write ports; required if there are some"),
        Port::optional("wr_data", "the words to write; required if there are write ports"),
    ],
    parameters: &[
        Parameter { name: "width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of a word" },
        Parameter {
            name: "words",
            kind: Kind::Integer { min: 1, max: 1 << 26 },
            default: None,
            doc: "how many words; their addresses are 0, 1, …",
        },
        Parameter {
            name: "address",
            kind: Kind::Integer { min: 0, max: 64 },
            default: Some("0"),
            doc: "bits of an address; 0 for as many as `words` need, but one at least",
        },
        Parameter { name: "reads", kind: Kind::Integer { min: 1, max: 1024 }, default: Some("1"), doc: "read ports" },
        Parameter {
            name: "writes",
            kind: Kind::Integer { min: 0, max: 1024 },
            default: Some("1"),
            doc: "write ports; 0 makes a ROM",
        },
        Parameter {
            name: "read_edge",
            kind: EDGES,
            default: Some("none"),
            doc: "when read ports read: at an edge of their clock, or always",
        },
        Parameter {
            name: "write_edge",
            kind: EDGES,
            default: Some("rising"),
            doc: "when write ports write: at an edge of their clock, or all the time that they are enabled",
        },
        Parameter {
            name: "transparent",
            kind: Kind::FLAG,
            default: Some("0"),
            doc: "1: a read port with a clock reads what is written to its address at the same instant, be there such a word or not; 0: what was there before",
        },
        Parameter {
            name: "init",
            kind: Kind::Contents,
            default: Some("x"),
            doc: "what it holds at the start; words that are not given are x",
        },
    ],
    meaning: "Each pin holds that of all ports, the first port in the low bits: `rd_data` of two ports of 8 bits is `[port 1, port 0]`. An address that is outside or has an x or z reads x, and nothing is written there; a bit is written where its enable is 1. A port without a clock acts all the time: it reads what is there, and writes while it is enabled. Of several ports that write a bit at one instant the last wins. `init` is a value for all words (`0`, `\"8'hff\"`, `\"x\"`), an array of values from address 0 on, or the name of a file, one with a dot, relative to the circuit file, in the form of `$readmemh`: hex numbers, `_`, `x`, `z`, `@` and an address, comments. `--memory NAME=FILE` puts a file in its place.",
    source: "IEEE 1364-2005, 4.9.1 and 17.2.8; Yosys `$mem_v2`",
    example: r#"{ "type": "memory", "parameters": { "width": "W", "words": 16, "init": [1, 2, "8'hff"] }, "connections": { "rd_addr": "a", "rd_data": "word", "wr_clk": "clk", "wr_en": "we", "wr_addr": "to", "wr_data": "d" } }"#,
    build: |a| {
        let (width, size) = (a.width("width"), a.width("words"));
        let (reads, writes) = (a.width("reads"), a.width("writes"));
        let abits = match a.width("address") {
            0 => address_bits(size),
            given => given,
        };
        // no pin may have more bits than a number of 32 bits counts
        if u64::from(reads.max(writes)) * u64::from(width.max(abits)) > 1 << 26 {
            return Err(format!("{} ports of {width} bits are more than a memory can have", reads.max(writes)));
        }
        let read_clock = clock(a.word("read_edge"));
        let ports = writes as usize;
        let read = ReadPort {
            clock: read_clock,
            wide: false,
            transparent: vec![a.flag("transparent") && read_clock.is_some(); ports].into(),
            collides: vec![false; ports].into(),
            arst_value: Value::unknown(width),
            srst_value: Value::unknown(width),
            enable_first: false,
        };
        let write = |port: usize| WritePort {
            clock: clock(a.word("write_edge")),
            wide: false,
            priority: vec![true; port].into(),
        };
        Ok(CellKind::Memory(Box::new(Memory {
            width,
            size,
            offset: 0,
            abits,
            init: a.contents("init"),
            start: Value::unknown(reads * width),
            reads: vec![read; reads as usize],
            writes: (0..ports).map(write).collect(),
        })))
    },
}];

#[cfg(test)]
mod tests {
    use super::*;

    fn memory(width: u32, size: u32, offset: i32, abits: u32) -> Memory {
        Memory {
            width,
            size,
            offset,
            abits,
            init: Memory::contents(width, size).into(),
            start: Value::unknown(0),
            reads: vec![],
            writes: vec![],
        }
    }

    #[test]
    fn contents_are_x_and_words_do_not_overlap() {
        for width in [1, 3, 8, 31, 32, 64, 65, 128, 130] {
            let mut contents = Memory::contents(width, 5);
            for i in 0..5 {
                assert_eq!(Memory::word(width, &contents, i), Value::unknown(width));
            }
            let value = |i: u32| Value::from_i64(-1 - i64::from(i), width);
            (0..5).for_each(|i| Memory::set_word(width, &mut contents, i, &value(i), |_| true));
            (0..5).for_each(|i| assert_eq!(Memory::word(width, &contents, i), value(i), "{width} {i}"));
        }
        assert_eq!(Memory::contents(1, 65).len(), 2, "a bit takes a bit");
    }

    #[test]
    fn addresses() {
        let m = memory(8, 20, 3, 5);
        let at = |m: &Memory, a: u64| m.index(Word::known(a));
        assert_eq!([2, 3, 22, 23].map(|a| at(&m, a)), [None, Some(0), Some(19), None]);
        assert_eq!(m.index(Word { v: 3, u: 8 }), None);
        let signed = memory(8, 8, -4, 32);
        assert_eq!([0, 3, 4, 0xffff_fffc].map(|a| at(&signed, a)), [Some(4), Some(7), None, Some(0)]);
        let wide = memory(8, 8, 1, 40);
        assert_eq!([0, 1, 1 << 33].map(|a| at(&wide, a)), [None, Some(0), None]);
    }
}
