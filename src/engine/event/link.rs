//! What a change of each slot of a [`Program`] wakes: operations, clock pins, controls, delays.

use std::collections::HashMap;

use super::program::{Hook, Meta, Program, Wake, flag};

/// Fills in what a change of each slot wakes, from the (slot, operation) pairs of all that operations read.
pub(super) fn link(p: &mut Program, mut reads: Vec<(u32, u32)>) {
    p.meta = vec![Meta::default(); p.initial.len()];
    reads.sort_unstable();
    reads.dedup();
    let mut reads = reads.iter().peekable();
    for slot in 0..p.meta.len() as u32 {
        let meta = &mut p.meta[slot as usize];
        meta.more_start = p.wakes.len() as u32;
        while let Some(&&(_, op)) = reads.peek().filter(|r| r.0 == slot) {
            reads.next();
            let (word, bit) = (op / 64, 1u64 << (op % 64));
            match p.wakes[meta.more_start as usize..].last_mut() {
                _ if meta.mask == 0 => (meta.word, meta.mask) = (word, bit),
                _ if meta.word == word => meta.mask |= bit,
                Some(last) if last.word == word => last.mask |= bit,
                _ => p.wakes.push(Wake { word, mask: bit }),
            }
        }
        meta.more_end = p.wakes.len() as u32;
    }
    hook(p);
}

/// Gives slots at which clock pins, control pins or delays look a hook that lists them.
fn hook(p: &mut Program) {
    let mut hooked: HashMap<u32, [Vec<u32>; 3]> = HashMap::new();
    for (i, c) in p.clocks.iter().enumerate() {
        hooked.entry(c.slot).or_default()[0].push(i as u32);
    }
    for (i, c) in p.controls.iter().enumerate() {
        hooked.entry(c.slot).or_default()[1].push(i as u32);
    }
    for (i, d) in p.delays.iter().enumerate() {
        for &(slot, lo, width) in &d.input {
            for slot in slot + lo / 64..=slot + (lo + width - 1) / 64 {
                hooked.entry(slot).or_default()[2].push(i as u32);
            }
        }
    }
    let mut slots: Vec<_> = hooked.into_iter().collect();
    slots.sort_unstable_by_key(|s| s.0);
    for (slot, lists) in slots {
        let meta = &mut p.meta[slot as usize];
        meta.hook = p.hooks.len() as u32;
        let mut ranges = [0..0, 0..0, 0..0];
        for (k, list) in lists.into_iter().enumerate() {
            if !list.is_empty() {
                meta.flags |= [flag::CLOCK, flag::CONTROL, flag::DELAY][k];
            }
            let start = p.hooked.len();
            p.hooked.extend(list);
            ranges[k] = start..p.hooked.len();
        }
        let [clocks, controls, delays] = ranges;
        p.hooks.push(Hook { clocks, controls, delays });
    }
}
