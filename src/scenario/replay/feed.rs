//! Driving the inputs of an engine as a waveform says, tick by tick.

use super::{Driven, Lane, Replay};
use crate::engine::Engine;
use crate::netlist::Region;
use crate::value::Word;
use crate::value::word::words;
use crate::wave::play::Player;

/// What a waveform does to the inputs from its beginning on.
pub struct Feed<'r> {
    replay: &'r Replay,
    player: Player<'r>,
    inputs: Vec<Input>,
    /// Inputs that change at the present tick.
    changed: Vec<usize>,
    /// For each unit whether a clock of it changes at the present tick.
    clocked: Vec<bool>,
    /// The regions of this tick that are still to come.
    rest: Vec<Region>,
}

/// An input.
struct Input {
    /// Its value in the waveform.
    value: Vec<Word>,
    /// What the engine was given.
    given: Vec<Word>,
    /// Whether it is among those that change.
    changes: bool,
}

impl<'r> Feed<'r> {
    pub(super) fn new(replay: &'r Replay) -> Feed<'r> {
        let input = |driven: &Driven| {
            let value = vec![Word::ZERO; words(driven.width)];
            let mut input = Input { given: value.clone(), value, changes: false };
            for (i, word) in input.value.iter_mut().enumerate() {
                let mask = crate::value::word::word_mask(driven.width, i);
                *word = if driven.floats { Word::z(mask) } else { Word::x(mask) };
            }
            input.given.clone_from(&input.value);
            input
        };
        Feed {
            replay,
            player: replay.tracks.play(&replay.waves),
            inputs: replay.inputs.iter().map(input).collect(),
            changed: Vec::new(),
            clocked: vec![false; replay.units.as_ref().map_or(0, Vec::len)],
            rest: Vec::new(),
        }
    }

    /// The tick of the next changes.
    #[must_use]
    pub fn due(&self) -> Option<u64> {
        self.player.time().map(|time| self.replay.tick(time))
    }

    /// Goes on to the next changes.
    pub fn step(&mut self) {
        for input in self.changed.drain(..) {
            self.inputs[input].changes = false;
        }
        self.clocked.fill(false);
        let Feed { replay, player, inputs, changed, clocked, .. } = self;
        player.step(&mut |lane, bits| {
            let Lane { input, at, width, reversed } = replay.lanes[lane];
            bits.write(&mut inputs[input].value, at, width, reversed);
            if !std::mem::replace(&mut inputs[input].changes, true) {
                changed.push(input);
            }
        });
        if replay.units.is_some() {
            for &i in changed.iter() {
                let (driven, input) = (&replay.inputs[i], &inputs[i]);
                let words = input.given.iter().zip(&input.value).zip(&driven.clocks);
                let mut words = words.map(|((given, new), clocks)| (given.v ^ new.v | given.u ^ new.u) & clocks);
                clocked[driven.unit] |= words.any(|changes| changes != 0);
            }
        }
    }

    /// Gives the engine what comes first: the clocks, or, where none changes, what else is a clock; or `all`.
    pub fn drive_first(&mut self, engine: &mut dyn Engine, all: bool) {
        self.rest.clear();
        if all {
            for region in Region::ALL {
                self.drive(engine, region);
            }
        } else if self.drive(engine, Region::Clock) {
            self.rest.extend([Region::Strobe, Region::Data]);
        } else {
            self.drive(engine, Region::Strobe);
            self.rest.push(Region::Data);
        }
    }

    /// Gives the engine the other changes. Returns whether there are any.
    pub fn drive_rest(&mut self, engine: &mut dyn Engine) -> bool {
        let mut any = false;
        for region in std::mem::take(&mut self.rest) {
            any |= self.drive(engine, region);
        }
        any
    }

    /// Gives the engine what changes in one region. Returns whether there is anything.
    fn drive(&mut self, engine: &mut dyn Engine, region: Region) -> bool {
        let mut any = false;
        for &i in &self.changed {
            let (driven, input) = (&self.replay.inputs[i], &mut self.inputs[i]);
            // one assignment changes all bits of a vector at once
            let whole = self.replay.units.as_ref().map(|units| match self.clocked[driven.unit] {
                true => units[driven.unit].region == region,
                false => region == Region::Data,
            });
            let mut changes = false;
            for ((given, new), clocks) in input.given.iter_mut().zip(&input.value).zip(&driven.clocks) {
                let mask = match (whole, region) {
                    (Some(true), _) => u64::MAX,
                    (None, Region::Clock) => *clocks,
                    (None, Region::Data) => !clocks,
                    _ => 0,
                };
                let word = Word { v: given.v & !mask | new.v & mask, u: given.u & !mask | new.u & mask };
                changes |= std::mem::replace(given, word) != word;
            }
            if changes {
                engine.drive(driven.net, &input.given);
                any = true;
            }
        }
        any
    }
}
