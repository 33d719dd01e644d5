//! Which inputs a waveform changes together, and which of them first. The rules are those of `docs/scenarios.md`, "What
//! changes first".

use std::collections::{BTreeSet, HashMap};

use super::Driven;
use crate::netlist::{Bit, Netlist, Region};
use crate::value::word::words;
use crate::wave::play::Tracks;
use crate::wave::read::Waves;

/// Inputs that change as one: a vector, or several inputs that are one wire in the waveform.
#[derive(Debug)]
pub(super) struct Unit {
    /// When it changes if one of its clocks does; with the data otherwise.
    pub region: Region,
}

/// What is found of the inputs.
pub(super) struct Together {
    pub units: Vec<Unit>,
    /// Gates of latches that change at times at which a clock does, without being tied to it.
    pub ambiguous: Vec<Bit>,
}

/// A value of a bit and the time from which it has it, for each change.
type Shape = Vec<(u64, u8)>;

/// Finds what changes together, and enters it into the inputs. `lanes` says what each variable of `tracks` is.
pub(super) fn together(
    netlist: &Netlist,
    inputs: &mut [Driven],
    lanes: &[super::Lane],
    waves: &Waves,
    tracks: &Tracks,
    vars: &[usize],
) -> Together {
    let mut clocks = netlist.clocks();
    let mut sets = Sets((0..inputs.len()).collect());
    // one wire in the waveform
    let mut by_var: HashMap<usize, usize> = HashMap::new();
    let originals = waves.originals();
    for (lane, &var) in lanes.iter().zip(vars) {
        let first = *by_var.entry(originals[var]).or_insert(lane.input);
        sets.join(first, lane.input);
    }
    let input_of: HashMap<_, usize> = inputs.iter().enumerate().map(|(i, driven)| (driven.net, i)).collect();
    let shape = |(net, bit): Bit| -> Option<Shape> {
        let input = *input_of.get(&net)?;
        let of_input = inputs[input].lane..lanes.len();
        let lane = of_input.take_while(|&l| lanes[l].input == input).find(|&l| lanes[l].has(bit))?;
        Some(shape(tracks, waves, lane, lanes[lane].bit(bit)))
    };
    // a gate that is what a clock is, or its inverse, is the clock
    let mut ambiguous = Vec::new();
    let gates = netlist.latch_gates();
    if gates.iter().flatten().any(|bit| !clocks.contains(bit)) {
        let shapes: Vec<(Bit, Shape)> = clocks.iter().filter_map(|&bit| Some((bit, shape(bit)?))).collect();
        let by_shape: HashMap<&Shape, Bit> = shapes.iter().map(|(bit, shape)| (shape, *bit)).collect();
        let times: BTreeSet<u64> = shapes.iter().flat_map(|(_, shape)| shape.iter().skip(1).map(|c| c.0)).collect();
        for group in &gates {
            let mut tied = !group.is_disjoint(&clocks);
            let mut open = Vec::new();
            for &gate in group.iter().filter(|gate| !clocks.contains(gate)).collect::<Vec<_>>() {
                let Some(shape) = shape(gate) else { continue };
                if let Some(clock) = by_shape.get(&shape).or_else(|| by_shape.get(&inverse(&shape))) {
                    sets.join(input_of[&gate.0], input_of[&clock.0]);
                    clocks.insert(gate);
                    tied = true;
                } else if shape.iter().skip(1).any(|(time, _)| times.contains(time)) {
                    open.push(gate);
                }
            }
            // beside a clock what leads to a gate is an enable
            if !tied {
                ambiguous.extend(open);
            }
        }
        ambiguous.sort_unstable();
        ambiguous.dedup();
    }
    let with_clock: BTreeSet<usize> =
        clocks.iter().filter_map(|clock| input_of.get(&clock.0)).map(|&input| sets.root(input)).collect();
    ambiguous.retain(|gate| !with_clock.contains(&sets.root(input_of[&gate.0])));
    let mut numbers: HashMap<usize, usize> = HashMap::new();
    let mut bits: Vec<BTreeSet<Bit>> = Vec::new();
    for (i, driven) in inputs.iter_mut().enumerate() {
        let unit = *numbers.entry(sets.root(i)).or_insert_with(|| {
            bits.push(BTreeSet::new());
            bits.len() - 1
        });
        bits[unit].extend((0..driven.width).map(|bit| (driven.net, bit)));
        driven.unit = unit;
        driven.clocks = mask(driven, |bit| clocks.contains(&bit));
    }
    let several = bits.iter().filter(|bits| !bits.is_disjoint(&clocks)).count() > 1;
    let region = |bits: &BTreeSet<Bit>| match several && !bits.is_disjoint(&clocks) && netlist.sampled_by_another(bits)
    {
        true => Region::Strobe,
        false => Region::Clock,
    };
    Together { units: bits.iter().map(|bits| Unit { region: region(bits) }).collect(), ambiguous }
}

/// Those bits of an input for which something holds, as a mask of its words.
pub(super) fn mask(driven: &Driven, holds: impl Fn(Bit) -> bool) -> Vec<u64> {
    let mut mask = vec![0; words(driven.width)];
    for bit in (0..driven.width).filter(|&bit| holds((driven.net, bit))) {
        mask[bit as usize / 64] |= 1 << (bit % 64);
    }
    mask
}

fn shape(tracks: &Tracks, waves: &Waves, lane: usize, bit: u32) -> Shape {
    let values = tracks.bit(waves, lane, bit).map(|(time, word)| (time, (word.v & 1 | (word.u & 1) << 1) as u8));
    let mut shape: Shape = values.collect();
    shape.dedup_by_key(|(_, value)| *value);
    shape
}

/// The same with 0 and 1 exchanged; what is unknown stays so.
fn inverse(shape: &Shape) -> Shape {
    shape.iter().map(|&(time, value)| (time, if value < 2 { value ^ 1 } else { value })).collect()
}

/// Disjoint sets of inputs.
struct Sets(Vec<usize>);

impl Sets {
    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
