//! Waveforms for the tests of what writes them, and what must be read back.

use std::collections::BTreeMap;
use std::path::Path;

use proptest::prelude::*;

use super::read::Waves;
use super::{Layout, ScopeKind, Sink, VarKind};
use crate::value::{Logic, Value};

/// One change: distance to the time before, variable, value.
pub type Step = (u64, usize, Value);

pub fn layout(widths: &[u32]) -> Layout {
    let mut layout = Layout::default();
    let top = layout.scope("top", None);
    let block = layout.scope("stage[0]", Some(top));
    layout.scopes[block].kind = ScopeKind::Block;
    let other = layout.scope("other", None);
    for (i, &width) in widths.iter().enumerate() {
        let var = layout.var([top, block, other][i % 3], &format!("v{i}"), width);
        layout.vars[var].kind = [VarKind::Wire, VarKind::Reg, VarKind::Integer][i % 3];
    }
    layout.alias(other, "again", 0);
    layout
}

/// Gives a sink some steps, and ends it so many ticks after the last.
pub fn record(sink: &mut dyn Sink, layout: &Layout, steps: &[Step], tail: u64) {
    sink.begin(layout).unwrap();
    let mut now = 0;
    sink.time(now).unwrap();
    for (distance, var, value) in steps {
        now += distance;
        sink.time(now).unwrap();
        sink.change(*var, &value.words().collect::<Vec<_>>());
    }
    sink.finish(now + tail).unwrap();
}

/// The tick at which they end.
pub fn end(steps: &[Step], tail: u64) -> u64 {
    steps.iter().map(|(distance, ..)| distance).sum::<u64>() + tail
}

/// The value that each variable has at the end of each tick, where it is another than before.
pub fn model(widths: &[u32], steps: &[Step]) -> BTreeMap<u64, BTreeMap<usize, Value>> {
    let mut ticks: BTreeMap<u64, BTreeMap<usize, Value>> = BTreeMap::new();
    let initial = widths.iter().map(|&width| Value::unknown(width)).enumerate();
    ticks.insert(0, initial.collect());
    let mut now = 0;
    for (distance, var, value) in steps {
        now += distance;
        ticks.entry(now).or_default().insert(*var, value.clone());
    }
    let mut last: BTreeMap<usize, Value> = BTreeMap::new();
    for changes in ticks.values_mut() {
        changes.retain(|var, value| last.insert(*var, value.clone()).as_ref() != Some(value));
    }
    ticks.retain(|_, changes| !changes.is_empty());
    ticks
}

pub fn runs() -> impl Strategy<Value = (Vec<u32>, Vec<Step>, u64)> {
    let width = prop_oneof![Just(1), 2_u32..10, Just(63), Just(64), Just(65), Just(128), 129_u32..200];
    proptest::collection::vec(width, 1..8).prop_flat_map(|widths| {
        let count = widths.len();
        let bit = prop_oneof![Just(Logic::Zero), Just(Logic::One), Just(Logic::X), Just(Logic::Z)];
        let bits = proptest::collection::vec(bit, 200);
        let of = widths.clone();
        let step = (0..3_u64, 0..count, bits, 0..3).prop_map(move |(distance, var, bits, kind)| {
            // Whole values too, so that equal ones follow one another.
            let mut value = Value::repeat(bits[0], of[var]);
            if kind == 0 {
                (0..of[var]).for_each(|i| value.set_bit(i, bits[i as usize]));
            }
            (distance, var, value)
        });
        (Just(widths), proptest::collection::vec(step, 0..40), 0..3_u64)
    })
}

/// Reads every variable back and compares it with the model, up to the end of the file.
pub fn check_values(path: &Path, layout: &Layout, ticks: &BTreeMap<u64, BTreeMap<usize, Value>>) {
    let mut waves = Waves::open(path).unwrap();
    assert_eq!(waves.vars().len(), layout.vars.len());
    for (i, var) in layout.vars.iter().enumerate() {
        let name = format!("{}.{}", layout.scope_path(var.scope), var.name);
        let found = waves.find(&name).unwrap_or_else(|| panic!("{name} not in {:?}", waves.vars()));
        let changes: Vec<_> = waves.load(found).unwrap().changes().collect();
        let expected: Vec<_> = ticks
            .iter()
            .filter_map(|(&time, changes)| Some((time, changes.get(&layout.origin(i))?.bit_string())))
            .collect();
        assert_eq!(changes, expected, "{name}");
    }
}

/// `wellen`, a reader by another author, makes the same of a file.
pub fn wellen_agrees(path: &Path) {
    let mut theirs = wellen::simple::read(path).unwrap();
    let mut ours = Waves::open(path).unwrap();
    let refs: Vec<_> = theirs.hierarchy().all_vars().collect();
    assert_eq!(refs.len(), ours.vars().len());
    for at in refs {
        let var = &theirs.hierarchy()[at];
        let (name, signal) = (var.full_name(theirs.hierarchy()), var.signal_ref());
        theirs.load_signals(&[signal]);
        let mut changes: Vec<(u64, String)> = Vec::new();
        for (at, value) in theirs.get_signal(signal).unwrap().iter_changes() {
            let time = theirs.time_table()[at as usize];
            changes.pop_if(|(last, _)| *last == time);
            changes.push((time, value.to_string()));
        }
        let found = ours.find(&name).unwrap_or_else(|| panic!("{name} not in {:?}", ours.vars()));
        assert_eq!(ours.load(found).unwrap().changes().collect::<Vec<_>>(), changes, "{name}");
    }
    assert_eq!(ours.end(), theirs.time_table().last().copied().unwrap_or(0));
}

pub fn sample() -> (Vec<u32>, Vec<Step>) {
    let widths = vec![1, 8, 70];
    let steps = (0..60_u64)
        .map(|n| (n % 3, (n % 5 % 3) as usize, n))
        .map(|(distance, var, n)| (distance, var, Value::from_u64(n.wrapping_mul(0x9e37_79b9_7f4a_7c15), widths[var])));
    (widths.clone(), steps.collect())
}
