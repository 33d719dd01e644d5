//! Memories as operations on nodes: what a port reads, what it takes at its edge, what it writes; the functions of
//! `cell::memory` once more.
//!
//! Contents lie in memory as [`Memory::contents`] lays them out, a slot for each of its machine words. What is loaded and
//! stored is an *element*: a word of the memory, a byte of several small ones, or 64 bits of a wide one.

use crate::Value;
use crate::cell::{Algebra, Memory};
use crate::compiled::ir::graph::{Graph, Id};
use crate::compiled::ir::places::Slot;
use crate::compiled::ir::stores::Put;
use crate::compiled::lower::four::{Bits, Two};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

/// PlaneWord an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element {
    pub slot: Slot,
    /// The binary logarithm of its bytes.
    pub size: u8,
    pub plane: u8,
    /// Its bits that may be 1.
    pub may: u64,
}

/// What reads a plane of an element, of a number that is in range.
pub(crate) type Fetch<'f> = dyn FnMut(&mut Graph, Element, Id) -> Id + 'f;

/// Contents as they stand in memory.
pub(crate) fn fetch(g: &mut Graph, e: Element, index: Id) -> Id {
    g.element(e.slot, index, e.size, e.plane, e.may)
}

/// A read port of a memory, the contents of which begin somewhere.
pub(crate) struct Read<'m> {
    pub memory: &'m Memory,
    pub contents: Slot,
    pub port: usize,
}

/// The controls of a read port with a clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Controls {
    pub en: Two,
    pub arst: Two,
    pub srst: Two,
    pub address: Two,
}

/// What a write port writes where `when` is 1.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub port: usize,
    pub when: Id,
    pub address: Two,
    pub data: Bits,
    pub enable: Bits,
}

/// Where a word lies: the element that it is or begins with, and at which bit.
struct At {
    valid: Id,
    size: u8,
    index: Id,
    shift: Id,
}

/// How the elements of a memory lie: the binary logarithm of their bytes, and of the words in one.
fn layout(m: &Memory) -> (u8, u32) {
    match Memory::stride(m.width) {
        stride @ 1..=4 => (0, 3 - stride.trailing_zeros()),
        stride => (stride.min(64).trailing_zeros() as u8 - 3, 0),
    }
}

fn at(g: &mut Graph, m: &Memory, address: Two) -> At {
    let offset = g.constant(i64::from(m.offset) as u64);
    let index = g.sub(address.v, offset);
    let all = g.constant(mask(m.abits.max(32)));
    let index = if m.offset == 0 { address.v } else { g.and(index, all) };
    let unknown = g.any(address.u);
    let end = g.constant(m.size.into());
    let inside = g.less(index, end);
    let valid = g.and_not(inside, unknown);
    // in range even where it is not valid
    let zero = g.constant(0);
    let index = g.select(inside, index, zero);
    let (size, several) = layout(m);
    if several == 0 {
        return At { valid, size, index, shift: zero };
    }
    let within = g.bits(index, 0, several);
    let shift = g.shl(within, 3 - several);
    At { valid, size, index: g.shr(index, several), shift }
}

/// The number of the element with machine word `i` of a word.
fn element(g: &mut Graph, m: &Memory, index: Id, i: usize) -> Id {
    let n = words(m.width) as u64;
    if n == 1 {
        return index;
    }
    let (n, i) = (g.constant(n), g.constant(i as u64));
    let first = g.mul(index, n);
    g.add(first, i)
}

/// What an address reads.
pub(crate) fn read(g: &mut Graph, m: &Memory, contents: Slot, address: Two, fetch: &mut Fetch<'_>) -> Bits {
    let at = at(g, m, address);
    let several = layout(m).1 > 0;
    (0..words(m.width))
        .map(|i| {
            let all = word_mask(m.width, i);
            let index = element(g, m, at.index, i);
            let may = if several { 255 } else { all };
            let mut plane = |plane| {
                let half = fetch(g, Element { slot: contents, size: at.size, plane, may }, index);
                let half = g.shr_by(half, at.shift);
                let all = g.constant(all);
                g.and(half, all)
            };
            let (v, u) = (plane(0), plane(1));
            let (zero, x) = (g.constant(0), g.constant(all));
            Two { v: g.select(at.valid, v, zero), u: g.select(at.valid, u, x) }
        })
        .collect()
}

/// What a port writes.
pub(crate) fn write(g: &mut Graph, m: &Memory, contents: Slot, w: &Written) -> Vec<Put> {
    let at = at(g, m, w.address);
    let valid = g.and(at.valid, w.when);
    (0..words(m.width))
        .map(|i| {
            let (enable, zero) = (g.ones(w.enable[i]), g.constant(0));
            let bits = g.select(valid, enable, zero);
            let index = element(g, m, at.index, i);
            let put = Put {
                slot: contents,
                size: at.size,
                index,
                mask: g.shl_by(bits, at.shift),
                v: g.shl_by(w.data[i].v, at.shift),
                u: g.shl_by(w.data[i].u, at.shift),
            };
            assume_written(g, put)
        })
        .collect()
}

/// What only the bits that are written decide need not be right where none is.
fn assume_written(g: &Graph, put: Put) -> Put {
    let Some(when) = g.condition(put.mask) else { return put };
    Put { index: g.given(when, put.index), v: g.given(when, put.v), u: g.given(when, put.u), ..put }
}

/// Two writes as one, if they meet the same element whatever happens.
pub(crate) fn join(g: &mut Graph, first: &Put, then: &Put) -> Option<Put> {
    if (first.slot, first.index) != (then.slot, then.index) {
        return None;
    }
    let mut merge = |a: Id, b: Id| {
        if a == b {
            return a;
        }
        let (a, b) = (g.and_not(a, then.mask), g.and(b, then.mask));
        g.or(a, b)
    };
    let (v, u) = (merge(first.v, then.v), merge(first.u, then.u));
    Some(Put { v, u, mask: g.or(first.mask, then.mask), ..*first })
}

/// PlaneWord an element after a write.
pub(crate) fn after(g: &mut Graph, put: &Put, e: Element, index: Id, before: Id) -> Id {
    if put.slot != e.slot {
        return before;
    }
    let (hit, zero) = (g.eq(index, put.index), g.constant(0));
    let bits = g.select(hit, put.mask, zero);
    let (old, new) = (g.and_not(before, bits), g.and(if e.plane == 0 { put.v } else { put.u }, bits));
    g.or(old, new)
}

/// What a read port with a clock has after its edge, in `q` what it has before; `written` is what the write ports write
/// that may act at the same instant.
pub(crate) fn clocked(
    g: &mut Graph,
    r: &Read<'_>,
    c: &Controls,
    written: &[Written],
    q: &[Two],
    fetch: &mut Fetch<'_>,
) -> Bits {
    let (m, spec) = (r.memory, &r.memory.reads[r.port]);
    let mut new = read(g, m, r.contents, c.address, fetch);
    for w in written {
        let (transparent, collides) = (spec.transparent[w.port], spec.collides[w.port]);
        if !(transparent || collides) {
            continue;
        }
        let unknown = g.or(c.address.u, w.address.u);
        let unknown = g.any(unknown);
        let same = g.eq(c.address.v, w.address.v);
        let same = g.and_not(same, unknown);
        let same = g.and(same, w.when);
        for (i, q) in new.iter_mut().enumerate() {
            let (enable, zero) = (g.ones(w.enable[i]), g.constant(0));
            let bits = g.select(same, enable, zero);
            let x = g.literal(Word::x(word_mask(m.width, i)));
            let to = if collides { x } else { w.data[i] };
            let mut merge = |old: Id, new: Id| {
                let (old, new) = (g.and_not(old, bits), g.and(new, bits));
                g.or(old, new)
            };
            *q = Two { v: merge(q.v, to.v), u: merge(q.u, to.u) };
        }
    }
    let (en, arst, srst) = (g.is_one(c.en), g.is_one(c.arst), g.is_one(c.srst));
    let resets = if spec.enable_first { g.and(srst, en) } else { srst };
    let list = new.into_iter().zip(q).enumerate();
    list.map(|(i, (new, &q))| {
        let q = g.pick(en, new, q);
        let mut load = |s: Id, value: &Value, q: Two| {
            let value = g.literal(value.words().nth(i).unwrap_or_default());
            g.pick(s, value, q)
        };
        let q = load(resets, &spec.srst_value, q);
        load(arst, &spec.arst_value, q)
    })
    .collect()
}

/// What the asynchronous reset of a read port makes of what it has.
pub(crate) fn reset(g: &mut Graph, m: &Memory, port: usize, arst: Two, q: &[Two]) -> Bits {
    let s = g.is_one(arst);
    let value = g.literals(&m.reads[port].arst_value);
    q.iter().zip(value).map(|(&q, value)| g.pick(s, value, q)).collect()
}
