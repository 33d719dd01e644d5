//! The sections of an FST file that hold its values: changes signal by signal, compressed, and the times they happen at.
//!
//! The format is GTKWave's, block type 8. The crate that writes the rest of a file takes every value as text and keeps it
//! in lists that go backwards; nearly all of a file are values, so these are packed here (`cargo bench --bench wave` has
//! both beside each other).

use std::collections::HashMap;

use crate::value::Word;
use crate::value::word::words;

/// The type of a section, and the letter that says how values are packed.
const BLOCK: u8 = 8;
const LZ4: u8 = b'4';
/// Below this many bytes it is not worth it.
const LEAST: usize = 32;
/// Bytes for a time and a value of 64 bits, rounded up.
const ROOM: usize = 16;
/// How hard times are packed.
const ZLIB_LEVEL: u8 = 3;

/// What has changed since the last section.
#[derive(Default)]
pub(super) struct Section {
    signals: Vec<Signal>,
    /// The present values, signal after signal, and those at the first time of the section, as text.
    values: Vec<Word>,
    frame: Vec<u8>,
    /// Each time as its distance to the one before.
    times: Vec<u8>,
    count: u32,
    start: u64,
    end: u64,
    /// Bytes of changes.
    size: usize,
}

struct Signal {
    width: u32,
    /// Where its words are among the values.
    at: usize,
    /// The time of its last change, counted from the beginning of the section.
    last: u32,
    /// How a time goes together with a known value: moved by so much, with these bits of the value, and how many bytes of
    /// it behind.
    shift: u8,
    with: u8,
    bytes: u8,
    /// What has changed, and room for more behind.
    changes: Vec<u8>,
    used: usize,
}

impl Signal {
    fn new(width: u32, at: usize) -> Signal {
        let (shift, with, bytes) = if width == 1 { (2, 1, 0) } else { (1, 0, width.div_ceil(8).min(8) as u8) };
        Signal { width, at, last: 0, shift, with, bytes, changes: Vec::new(), used: 0 }
    }
}

impl Signal {
    /// Adds a change at a time with what writes it; returns how many bytes it has.
    #[cold]
    fn push(&mut self, count: u32, write: impl FnOnce(&mut Vec<u8>, u64, u32)) -> usize {
        let distance = u64::from(count - self.last);
        self.last = count;
        self.changes.truncate(self.used);
        write(&mut self.changes, distance, self.width);
        let before = std::mem::replace(&mut self.used, self.changes.len());
        self.used - before
    }
}

impl Section {
    /// The first section of signals of such widths, which are x.
    pub fn new(widths: impl Iterator<Item = u32>) -> Section {
        let mut section = Section::default();
        for width in widths {
            let signal = Signal::new(width, section.values.len());
            section.values.extend((0..words(width)).map(|i| Word::x(crate::value::word::word_mask(width, i))));
            section.signals.push(signal);
        }
        section
    }

    /// Bytes that are kept.
    pub fn size(&self) -> usize {
        self.size + self.times.len()
    }

    /// What follows happens at tick `now`, later than all before.
    pub fn time(&mut self, now: u64) {
        if self.times.is_empty() {
            // what there is now is what the section begins with
            self.frame = self.text();
            number(&mut self.times, now);
        } else {
            self.count += 1;
            number(&mut self.times, now - self.end);
        }
        self.end = now;
    }

    /// The first value of a signal, before any time.
    pub fn first(&mut self, signal: usize, value: &[Word]) {
        let at = self.signals[signal].at;
        self.values[at..at + value.len()].copy_from_slice(value);
    }

    /// A signal has another value from the last time on.
    pub fn change(&mut self, signal: usize, value: &[Word]) {
        if let [word] = value {
            return self.word(signal, *word);
        }
        let signal = &mut self.signals[signal];
        self.values[signal.at..signal.at + value.len()].copy_from_slice(value);
        self.size += signal.push(self.count, |out, distance, width| wide(out, distance, value, width));
    }

    /// The same for a signal of 64 bits at most. Which one comes next nobody can foresee, so all of them take the same
    /// steps.
    #[inline(always)]
    pub fn word(&mut self, signal: usize, word: Word) {
        let signal = &mut self.signals[signal];
        self.values[signal.at] = word;
        let distance = u64::from(self.count - signal.last);
        let code = distance << signal.shift | (word.v & u64::from(signal.with)) << 1;
        if word.u != 0 || code >> 14 != 0 {
            self.size += signal.push(self.count, |out, distance, width| match (width, word.u) {
                (1, 0) => number(out, distance << 2 | word.v << 1),
                (1, _) => number(out, distance << 4 | word.v << 1 | 1),
                _ => wide(out, distance, &[word], width),
            });
            return;
        }
        signal.last = self.count;
        if signal.changes.len() < signal.used + ROOM {
            signal.changes.resize((2 * signal.used).max(2 * ROOM), 0);
        }
        let room: &mut [u8; ROOM] = signal.changes[signal.used..].first_chunk_mut().expect("room was made");
        let long = code > 0x7f;
        room[0] = code as u8 & 0x7f | u8::from(long) << 7;
        room[1] = (code >> 7) as u8;
        let after = 1 + usize::from(long);
        room[after..after + 8].copy_from_slice(&(word.v << (64 - signal.width)).to_be_bytes());
        let bytes = after + usize::from(signal.bytes);
        signal.used += bytes;
        self.size += bytes;
    }

    /// All values as text.
    fn text(&self) -> Vec<u8> {
        let mut text = Vec::new();
        for signal in &self.signals {
            push_text(&mut text, &self.values[signal.at..signal.at + words(signal.width)], signal.width);
        }
        text
    }

    /// Takes what there is, to be packed. What comes next is another section.
    pub fn take(&mut self) -> Full {
        let mut signals = Vec::with_capacity(self.signals.len());
        for signal in &mut self.signals {
            let mut changes = std::mem::take(&mut signal.changes);
            changes.truncate(signal.used);
            (signal.used, signal.last) = (0, 0);
            signals.push((signal.width, changes));
        }
        let (frame, times) = (std::mem::take(&mut self.frame), std::mem::take(&mut self.times));
        let full = Full { signals, frame, times, count: self.count, start: self.start, end: self.end };
        (self.count, self.size, self.start) = (0, 0, self.end);
        full
    }
}

/// A section to which nothing is added any more.
pub(super) struct Full {
    /// The width of each signal, and its changes.
    signals: Vec<(u32, Vec<u8>)>,
    frame: Vec<u8>,
    times: Vec<u8>,
    count: u32,
    start: u64,
    end: u64,
}

impl Full {
    /// The section as it is in a file.
    pub fn pack(self) -> Vec<u8> {
        let mut out = vec![BLOCK];
        out.extend([0; 8]);
        let mut needed = 0;
        for n in [self.start, self.end, 0] {
            out.extend(n.to_be_bytes());
        }
        for n in [self.frame.len(), self.frame.len(), self.signals.len()] {
            number(&mut out, n as u64);
        }
        out.extend(&self.frame);
        number(&mut out, self.signals.len() as u64);
        let base = out.len();
        out.push(LZ4);
        let (mut offsets, mut none, mut last) = (Vec::new(), 0_u64, 0);
        let mut known: HashMap<Key<'_>, Vec<usize>> = HashMap::new();
        for (i, (width, changes)) in self.signals.iter().enumerate() {
            if changes.is_empty() {
                none += 1;
                continue;
            }
            if none > 0 {
                number(&mut offsets, std::mem::take(&mut none) << 1);
            }
            // a reader unpacks those that are the same once each
            needed += changes.len() as u64;
            let alike = known.entry(key(*width, changes)).or_default();
            if let Some(&same) = alike.iter().find(|&&other| self.signals[other].1 == *changes) {
                signed(&mut offsets, -(same as i64 + 1) << 1 | 1);
                continue;
            }
            alike.push(i);
            let start = out.len() - base;
            signed(&mut offsets, ((start - last) as i64) << 1 | 1);
            last = start;
            let packed = if changes.len() < LEAST { Vec::new() } else { lz4_flex::compress(changes) };
            if packed.is_empty() || packed.len() >= changes.len() {
                number(&mut out, 0);
                out.extend(changes);
            } else {
                number(&mut out, changes.len() as u64);
                out.extend(packed);
            }
        }
        if none > 0 {
            number(&mut offsets, none << 1);
        }
        out.extend(&offsets);
        out.extend((offsets.len() as u64).to_be_bytes());
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&self.times, ZLIB_LEVEL);
        let times = if packed.len() < self.times.len() { &packed } else { &self.times };
        out.extend(times);
        for n in [self.times.len() as u64, times.len() as u64, u64::from(self.count) + 1] {
            out.extend(n.to_be_bytes());
        }
        let length = out.len() as u64 - 1;
        out[1..9].copy_from_slice(&length.to_be_bytes());
        out[25..33].copy_from_slice(&u64::to_be_bytes(needed));
        out
    }
}

/// What changes that are the same have in common, without looking at all of them.
type Key<'s> = (u32, usize, &'s [u8], &'s [u8]);

fn key(width: u32, all: &[u8]) -> Key<'_> {
    let some = all.len().min(64);
    (width, all.len(), &all[..some], &all[all.len() - some..])
}

/// A value of any width.
fn wide(out: &mut Vec<u8>, distance: u64, value: &[Word], width: u32) {
    let known = value.iter().all(|word| word.u == 0);
    number(out, distance << 1 | u64::from(!known));
    if !known {
        return push_text(out, value, width);
    }
    // the first bit is the highest of the first byte
    let bit = |i: u32| if i < width { (value[i as usize / 64].v >> (i % 64) & 1) as u8 } else { 0 };
    for i in 0..width.div_ceil(8) {
        let high = width - 8 * i;
        out.push((0..8).fold(0, |byte, k| byte << 1 | if high > k { bit(high - 1 - k) } else { 0 }));
    }
}

fn push_text(out: &mut Vec<u8>, value: &[Word], width: u32) {
    out.extend((0..width as usize).rev().map(|bit| {
        let (word, at) = (value[bit / 64], bit % 64);
        b"01xz"[(word.v >> at & 1 | (word.u >> at & 1) << 1) as usize]
    }));
}

/// Seven bits a byte, the lowest first.
#[inline]
fn number(out: &mut Vec<u8>, mut n: u64) {
    while n > 0x7f {
        out.push(n as u8 | 0x80);
        n >>= 7;
    }
    out.push(n as u8);
}

/// The same in two's complement.
fn signed(out: &mut Vec<u8>, mut n: i64) {
    while !(-64..64).contains(&n) {
        out.push(n as u8 | 0x80);
        n >>= 7;
    }
    out.push(n as u8 & 0x7f);
}
