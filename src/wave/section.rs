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
    changes: Vec<u8>,
}

impl Section {
    /// The first section of signals of such widths, which are x.
    pub fn new(widths: impl Iterator<Item = u32>) -> Section {
        let mut section = Section::default();
        for width in widths {
            let signal = Signal { width, at: section.values.len(), last: 0, changes: Vec::new() };
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
    #[inline]
    pub fn change(&mut self, signal: usize, value: &[Word]) {
        let signal = &mut self.signals[signal];
        let distance = u64::from(self.count - signal.last);
        signal.last = self.count;
        let out = &mut signal.changes;
        let before = out.len();
        let word = value[0];
        if signal.width > 64 {
            self.values[signal.at..signal.at + value.len()].copy_from_slice(value);
            wide(out, distance, value, signal.width);
        } else {
            self.values[signal.at] = word;
            if signal.width == 1 {
                let code = match word.u {
                    0 => distance << 2 | word.v << 1,
                    _ => distance << 4 | word.v << 1 | 1,
                };
                number(out, code);
            } else if word.u == 0 {
                number(out, distance << 1);
                let bytes = out.len() + signal.width.div_ceil(8) as usize;
                out.extend_from_slice(&(word.v << (64 - signal.width)).to_be_bytes());
                out.truncate(bytes);
            } else {
                wide(out, distance, value, signal.width);
            }
        }
        self.size += out.len() - before;
    }

    /// All values as text.
    fn text(&self) -> Vec<u8> {
        let mut text = Vec::new();
        for signal in &self.signals {
            push_text(&mut text, &self.values[signal.at..signal.at + words(signal.width)], signal.width);
        }
        text
    }

    /// The section as it is in a file. What comes next is another.
    pub fn finish(&mut self) -> Vec<u8> {
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
        for (i, signal) in self.signals.iter().enumerate() {
            let changes = &signal.changes;
            if changes.is_empty() {
                none += 1;
                continue;
            }
            if none > 0 {
                number(&mut offsets, std::mem::take(&mut none) << 1);
            }
            let alike = known.entry(key(signal)).or_default();
            if let Some(&same) = alike.iter().find(|&&other| self.signals[other].changes == *changes) {
                signed(&mut offsets, -(same as i64 + 1) << 1 | 1);
                continue;
            }
            alike.push(i);
            needed += changes.len() as u64;
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

        self.times.clear();
        (self.count, self.size, self.start) = (0, 0, self.end);
        for signal in &mut self.signals {
            signal.changes.clear();
            signal.last = 0;
        }
        out
    }
}

/// What changes that are the same have in common, without looking at all of them.
type Key<'s> = (u32, usize, &'s [u8], &'s [u8]);

fn key(signal: &Signal) -> Key<'_> {
    let all = &signal.changes;
    let some = all.len().min(64);
    (signal.width, all.len(), &all[..some], &all[all.len() - some..])
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
