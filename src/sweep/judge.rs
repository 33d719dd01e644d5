//! Compares the lanes of a block with an algorithm, on every clock.

use super::against::{Against, Field};
use super::ahead::Ahead;
use super::model::{Model, What};
use super::plan::Plan;
use super::run::Verdict;
use crate::engine::batch::{BatchEngine, LaneSet};

/// What is said of a run that has no end.
pub(super) const NEVER: &str = "the circuit never settles";

/// How the algorithm runs.
enum Form<'a> {
    /// In all lanes at once.
    Model {
        model: Model,
        /// Bits of the circuit and planes of the algorithm; while `dt` is 0 and while it is 1.
        pairs: [Vec<(u32, u32)>; 2],
        /// Clocks of the block.
        clocks: u64,
        /// When each lane began.
        begun: Vec<u64>,
    },
    /// Lane by lane.
    Ahead(Ahead<'a>),
}

/// The comparison of the lanes of one block.
pub(super) struct Judge<'a> {
    against: &'a Against,
    form: Form<'a>,
    verdicts: Vec<Option<Verdict>>,
    /// The lanes whose drawing has begun.
    begun: LaneSet,
    /// The lanes that are still the same.
    same: LaneSet,
    differ: LaneSet,
}

impl<'a> Judge<'a> {
    /// For the lanes of an engine. `together` says that all make their clocks at once.
    pub fn new(against: &'a Against, engine: &BatchEngine, together: bool) -> Judge<'a> {
        let lanes = engine.lanes();
        let set = || vec![0u64; lanes / 64];
        let form = match against.model_of(lanes).filter(|_| together) {
            Some(model) => {
                let pairs = [false, true].map(|pulses| pairs(against, &model, engine, pulses));
                Form::Model { model, pairs, clocks: 0, begun: vec![0; lanes] }
            }
            None => Form::Ahead(Ahead::new(against, lanes)),
        };
        Judge { against, form, verdicts: vec![None; lanes], begun: set(), same: set(), differ: set() }
    }

    /// A lane begins a row.
    pub fn begin(&mut self, lane: usize, row: u64, plan: &Plan) {
        let (word, bit) = (lane / 64, 1u64 << (lane % 64));
        self.begun[word] &= !bit;
        self.same[word] &= !bit;
        self.verdicts[lane] = None;
        let begun = match &mut self.form {
            Form::Model { model, .. } => self
                .against
                .values(row, plan)
                .ok_or_else(|| "a value is not known".to_owned())
                .and_then(|values| model.load(lane, &values).map_err(|e| e.to_string())),
            Form::Ahead(ahead) => self.against.begin(row, plan).map(|algorithm| ahead.begin(lane, Some(algorithm))),
        };
        match begun {
            Ok(()) => self.same[word] |= bit,
            Err(why) => {
                self.forget(lane);
                self.verdicts[lane] = Some(Verdict::Refused(why));
            }
        }
    }

    fn forget(&mut self, lane: usize) {
        if let Form::Ahead(ahead) = &mut self.form {
            ahead.begin(lane, None);
        }
    }

    /// Compares some lanes after an instant in which `dt` rose (`Some(true)`), fell, or did neither. With `all` they are
    /// all that run; else the others rest.
    pub fn look(&mut self, engine: &BatchEngine, set: &[u64], all: bool, edge: Option<bool>) {
        let falls = edge == Some(false);
        let mut rests = false;
        for (word, &lanes) in set.iter().enumerate() {
            let compared = lanes & self.same[word];
            let fresh = compared & !self.begun[word];
            self.begun[word] |= fresh;
            rests |= fresh != 0;
            match &mut self.form {
                Form::Ahead(ahead) => ahead.advance(word, fresh, if falls { compared & !fresh } else { 0 }, all),
                Form::Model { clocks, begun, .. } => each(fresh, |lane| begun[word * 64 + lane] = *clocks),
            }
        }
        if let Form::Model { model, clocks, .. } = &mut self.form {
            if falls {
                model.registers.step();
                *clocks += 1;
            } else if rests {
                model.registers.show();
            }
        }
        if edge.is_none() && !rests {
            return;
        }
        let pulses = edge == Some(true);
        self.differ.fill(0);
        match &self.form {
            Form::Ahead(ahead) => ahead.compare(engine, pulses, &mut self.differ),
            Form::Model { model, pairs, .. } => {
                engine.differ_from(&model.registers, &pairs[usize::from(pulses)], &mut self.differ);
            }
        }
        for (word, &lanes) in set.iter().enumerate() {
            let differ = self.differ[word] & lanes & self.same[word];
            if differ != 0 {
                self.same[word] &= !differ;
                each(differ, |lane| self.blame(engine, word * 64 + lane, pulses));
            }
        }
    }

    /// Clocks that a lane has made.
    fn clocks(&self, lane: usize) -> u64 {
        match &self.form {
            Form::Ahead(ahead) => ahead.clocks(lane),
            Form::Model { clocks, begun, .. } => clocks - begun[lane],
        }
    }

    fn expected(&self, field: &Field, lane: usize) -> u64 {
        match &self.form {
            Form::Ahead(ahead) => ahead.expected(field, lane),
            Form::Model { model, .. } => (0..field.width)
                .fold(0, |all, i| all | u64::from(model.registers.lane(model.plane(field.what, i), lane)) << i),
        }
    }

    /// Says what differs first in a lane.
    fn blame(&mut self, engine: &BatchEngine, lane: usize, pulses: bool) {
        for field in &self.against.fields {
            let step = matches!(field.what, What::Step(_));
            let expected = if step && !pulses { 0 } else { self.expected(field, lane) };
            if engine.number(&field.bits, lane) == Some(expected) {
                continue;
            }
            let found = engine.value(&field.bits, lane);
            let found = found.to_u64().map_or_else(|| found.to_string(), |n| n.to_string());
            let level = u8::from(pulses);
            let why = format!("{} shows {found}, expected {expected}, while dt = {level}", field.name);
            self.verdicts[lane] = Some(Verdict::Differs(self.clocks(lane) + u64::from(pulses), why));
            return;
        }
    }

    /// What there is to say of a lane that has come to its end.
    pub fn verdict(&mut self, lane: usize) -> Verdict {
        self.forget(lane);
        self.verdicts[lane].take().unwrap_or(Verdict::Same)
    }

    /// The same of one that has not settled.
    pub fn unsettled(&mut self, lane: usize) -> Verdict {
        let clocks = self.clocks(lane);
        self.forget(lane);
        self.verdicts[lane].take().unwrap_or(Verdict::Differs(clocks, NEVER.into()))
    }
}

/// The bits that are compared, and the planes with which; steps are pulses while `dt` is 1.
fn pairs(against: &Against, model: &Model, engine: &BatchEngine, pulses: bool) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for field in &against.fields {
        let rests = matches!(field.what, What::Step(_)) && !pulses;
        let bits = field.bits.iter().flat_map(|s| (0..s.width).map(|i| engine.bit(*s, i)));
        // plane 0 is 0
        pairs.extend(bits.zip(0..).map(|(bit, i)| (bit, if rests { 0 } else { model.plane(field.what, i) })));
    }
    pairs
}

/// Each of the 64 lanes in a set.
#[inline(always)]
pub(super) fn each(mut set: u64, mut f: impl FnMut(usize)) {
    while set != 0 {
        f(set.trailing_zeros() as usize);
        set &= set - 1;
    }
}
