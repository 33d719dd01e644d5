//! Every lane compared with an interpolation algorithm, on every clock.
//!
//! The circuit has the ports of the line interpolator: `start` loads the inputs while it is 1, `dt` is the clock, steps
//! are pulses of `x`, `y` (and `z`) while `dt` is 1, and the registers change at its trailing edge. What the algorithm
//! expects of 64 lanes is put into planes, so that one comparison is one of all lanes.

use std::{error, fmt};

use super::plan::Plan;
use super::run::Verdict;
use crate::Value;
use crate::circuit::Circuit;
use crate::engine::batch::{BatchEngine, LaneSet};
use crate::interpolate::request::{arc, line, line_3d};
use crate::interpolate::{
    ArcInput, ArcPath, Clock, InputError, Interpolator, Line3dInput, LineInput, Method, Options, Packing, Quadrants,
    Request, Shape,
};
use crate::netlist::{NetId, Netlist, Slice};
use crate::scenario::Scenario;
use crate::value::word::mask;

/// Why a circuit and its scenario cannot be compared with an algorithm.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct AgainstError {
    /// What is wrong.
    pub message: String,
    /// What is needed.
    pub help: String,
}

impl fmt::Display for AgainstError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl error::Error for AgainstError {}

/// What a net is compared with.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum What {
    At(usize),
    Left(usize),
    Sum(usize),
    End,
    Step(usize),
}

/// A net that is compared.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    bits: Vec<Slice>,
    what: What,
    /// Where its value stands among those of a lane.
    word: usize,
    shift: u32,
    width: u32,
}

/// Where an algorithm's input comes from.
#[derive(Clone, Copy, Debug)]
enum Operand {
    /// A swept input: its axis, its width, whether it is in two's complement.
    Swept(usize, u32, bool),
    Fixed(i64),
}

/// An algorithm, and which nets show what it computes.
#[derive(Clone, Debug)]
pub struct Against {
    method: Method,
    options: Options,
    clockwise: bool,
    /// The circuit draws in all quadrants.
    signed: bool,
    bits: u32,
    inputs: Vec<Operand>,
    fields: Vec<Field>,
    words: usize,
    /// The net of the clock.
    pub(super) clock: NetId,
}

impl Against {
    /// Compares a circuit with a method.
    ///
    /// # Errors
    /// If the circuit has not the nets that this needs, or its scenario does not drive them as it needs.
    pub fn new(
        method: Method,
        circuit: &Circuit,
        scenario: &Scenario,
        swept: &[NetId],
    ) -> Result<Against, AgainstError> {
        let netlist = &circuit.netlist;
        let parameter = |name: &str| circuit.parameters.get(name).copied().unwrap_or(0) != 0;
        let options = Options {
            as_printed: false,
            half_preload: parameter("HALF_PRELOAD"),
            parallel: parameter("PARALLEL"),
            normalise: parameter("NORMALISE"),
            centred: parameter("CENTRED"),
        };
        let signed = netlist.find("x_dir").is_some();
        let names: &[&str] = match (method.shape(), signed) {
            (Shape::Line, _) => &["xh", "yh", "dx", "dy"],
            (Shape::Line3d, _) => &["xh", "yh", "zh", "dx", "dy", "dz"],
            (Shape::Arc, false) => &["xh", "yh", "dx", "dy", "f0"],
            (Shape::Arc, true) => &["xh", "yh", "xk", "yk", "xc", "yc", "cw", "f0"],
            (Shape::Curve, _) => {
                return Err(AgainstError {
                    message: format!("a sweep cannot be compared with {method}"),
                    help: "compare with a line or an arc".into(),
                });
            }
        };
        let help = || {
            format!(
                "{method} needs the inputs `start`, `dt`, {}, with `dt` a clock of the scenario, a stimulus that raises and \
                 lowers `start` before the first edge of `dt`, and the nets of `circuits/evaluation/line.json` and its like",
                names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
            )
        };
        let fault = |message: String| AgainstError { message, help: help() };
        let inputs = names
            .iter()
            .map(|&name| operand(netlist, scenario, swept, name).map_err(fault))
            .collect::<Result<_, _>>()?;
        let clock = scenario.clocks.iter().find(|c| c.name == "dt");
        let clock = clock.ok_or_else(|| fault("the scenario has no clock `dt`".into()))?;
        let start = netlist.find("start").and_then(|s| netlist.signal(s).drive);
        let start = start.ok_or_else(|| fault("the circuit has no input `start`".into()))?;
        let levels = scenario.stimulus.iter().flat_map(|e| &e.sets).filter(|s| s.0 == start).map(|s| s.1.to_u64());
        if levels.collect::<Vec<_>>() != [Some(1), Some(0)] {
            return Err(fault("the scenario's stimulus does not set `start` to 1 and then to 0".into()));
        }
        if scenario.stimulus.last().is_none_or(|last| last.time >= clock.clock.phase) {
            return Err(fault("the scenario's stimulus goes on after the first edge of `dt`".into()));
        }
        let xt = netlist.find("xt").map(|s| netlist.signal(s).width);
        let bits = xt.ok_or_else(|| fault("the circuit has no net `xt`".into()))? - u32::from(signed);
        let mut against = Against {
            method,
            options,
            clockwise: parameter("CLOCKWISE"),
            signed,
            bits,
            inputs,
            fields: Vec::new(),
            words: 0,
            clock: clock.net,
        };
        let refused = |e: InputError| AgainstError {
            message: e.to_string(),
            help: "choose another method, or other parameters".into(),
        };
        let columns = against.model().map_err(refused)?.columns();
        let mut at = 0;
        let all = (columns.at.iter().enumerate().map(|(i, name)| (*name, What::At(i))))
            .chain(columns.left.iter().enumerate().map(|(i, name)| (*name, What::Left(i))))
            .chain(columns.sum.iter().enumerate().map(|(i, name)| (*name, What::Sum(i))))
            .chain([("end", What::End)])
            .chain(
                ["x", "y", "z"].into_iter().take(columns.at.len()).enumerate().map(|(i, name)| (name, What::Step(i))),
            );
        for (name, what) in all {
            // a register that a circuit around an interpolator does not show is the interpolator's
            let within = format!("core.{name}");
            let signal = netlist.find(name).or_else(|| netlist.find(&within));
            let signal = signal.ok_or_else(|| fault(format!("the circuit has no net `{name}`")))?;
            let width = netlist.signal(signal).width;
            if width > 64 {
                return Err(fault(format!("`{name}` has {width} bits")));
            }
            if at % 64 + width > 64 {
                at = (at / 64 + 1) * 64;
            }
            against.fields.push(Field {
                name: netlist.signal_path(signal),
                bits: netlist.bits(signal).to_vec(),
                what,
                word: at as usize / 64,
                shift: at % 64,
                width,
            });
            at += width;
        }
        against.words = at.div_ceil(64) as usize;
        if against.words > WORDS {
            return Err(fault("its registers are too wide to be compared".into()));
        }
        Ok(against)
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }

    /// Some drawing of the method, with its options.
    fn model(&self) -> Result<Box<dyn Interpolator>, InputError> {
        let to = match self.method.shape() {
            Shape::Arc => [0, 5, 0],
            _ => [5, 3, 2],
        };
        let from = if self.method.shape() == Shape::Arc { [5, 0, 0] } else { [0; 3] };
        // refuses options that the method does not have
        Request { from, options: self.options, ..Request::new(self.method, to) }.draw()?;
        match self.method.shape() {
            Shape::Arc => arc(self.method, ArcInput::between((5, 0), (0, 5), false, 8), &self.options),
            Shape::Line3d => line_3d(self.method, Line3dInput { start: [0; 3], increment: to, bits: 8 }, &self.options),
            _ => line(self.method, LineInput::new(5, 3), &self.options),
        }
    }

    /// The algorithm for a row.
    fn draw(&self, row: u64, plan: &Plan) -> Result<Box<dyn Interpolator>, InputError> {
        let values: Vec<u64> = plan.values(row).map(|w| w.v).collect();
        let value = |operand: &Operand| match *operand {
            Operand::Fixed(value) => value,
            Operand::Swept(axis, width, signed) => number(values[axis], width, signed),
        };
        let v: Vec<i64> = self.inputs.iter().map(value).collect();
        let Against { method, options, bits, clockwise, .. } = *self;
        match (method.shape(), self.signed) {
            (Shape::Line, false) => line(method, LineInput { xh: v[0], yh: v[1], dx: v[2], dy: v[3], bits }, &options),
            (Shape::Line3d, false) => {
                let input = Line3dInput { start: [v[0], v[1], v[2]], increment: [v[3], v[4], v[5]], bits };
                line_3d(method, input, &options)
            }
            (Shape::Arc, false) => {
                let input = ArcInput { xh: v[0], yh: v[1], dx: v[2], dy: v[3], f0: v[4], clockwise, bits };
                arc(method, input, &options)
            }
            (Shape::Arc, true) => {
                let path = ArcPath {
                    center: [v[4], v[5]],
                    from: [v[0], v[1]],
                    to: [v[2], v[3]],
                    full: true,
                    clockwise: v[6] != 0,
                    f0: v[7],
                    bits,
                };
                let carries = method != Method::DdaCircle;
                Ok(Box::new(Quadrants::new(path, carries, move |input| arc(method, input, &options))?))
            }
            (Shape::Line | Shape::Line3d | Shape::Curve, _) => {
                let z = method.shape() == Shape::Line3d;
                let (from, d) =
                    if z { ([v[0], v[1], v[2]], [v[3], v[4], v[5]]) } else { ([v[0], v[1], 0], [v[2], v[3], 0]) };
                let to = [0, 1, 2].map(|axis| from[axis] + d[axis]);
                let request = Request { from, bits: Some(bits), options, ..Request::new(method, to) };
                Ok(request.draw()?.interpolator)
            }
        }
    }

    /// What stands where in the words of a lane: the registers, and the pulses of the clock that comes next.
    fn packings(&self) -> Vec<Packing> {
        let mut packings = vec![Packing::default(); self.words];
        for field in &self.fields {
            let (p, place) = (&mut packings[field.word], (mask(field.width), field.shift));
            match field.what {
                What::At(i) => p.at[i] = place,
                What::Left(i) => p.left[i] = place,
                What::Sum(i) => p.sum[i] = place,
                What::End => p.end = place,
                What::Step(i) => p.step[i] = place,
            }
        }
        packings
    }
}

/// A number of so many bits.
fn number(value: u64, width: u32, signed: bool) -> i64 {
    if signed && width < 64 { ((value << (64 - width)) as i64) >> (64 - width) } else { value as i64 }
}

/// Where the value of an input comes from.
fn operand(netlist: &Netlist, scenario: &Scenario, swept: &[NetId], name: &str) -> Result<Operand, String> {
    let Some(signal) = netlist.find(name) else {
        // what an interpolator does not have is 0: `f0` of one by increments
        return if name == "f0" { Ok(Operand::Fixed(0)) } else { Err(format!("the circuit has no input `{name}`")) };
    };
    let signal = netlist.signal(signal);
    let net = signal.drive.ok_or_else(|| format!("`{name}` is not an input of the circuit"))?;
    if scenario.stimulus.iter().flat_map(|e| &e.sets).any(|s| s.0 == net) {
        return Err(format!("the scenario's stimulus changes `{name}`"));
    }
    if let Some(axis) = swept.iter().position(|&n| n == net) {
        return Ok(Operand::Swept(axis, signal.width, signal.signed));
    }
    let value = scenario.inputs.iter().find(|i| i.0 == net).and_then(|i| i.1.to_u64());
    let value = value.ok_or_else(|| format!("`{name}` has no known value"))?;
    Ok(Operand::Fixed(number(value, signal.width, signal.signed)))
}

/// Clocks that an algorithm runs ahead of its lane.
const AHEAD: usize = 16;
/// The most words of what a lane is to show.
const WORDS: usize = 8;

/// One lane's algorithm.
struct Course {
    algorithm: Box<dyn Interpolator>,
    /// Its registers after the clocks that it has run ahead, and whether there are no more.
    registers: Clock,
    over: bool,
    /// Clocks of the lane.
    clocks: u64,
}

/// Compares the lanes of one block.
pub(super) struct Judge<'a> {
    against: &'a Against,
    packings: Vec<Packing>,
    courses: Vec<Option<Course>>,
    verdicts: Vec<Option<Verdict>>,
    /// The lanes whose drawing has begun.
    begun: LaneSet,
    /// The lanes that are still the same.
    same: LaneSet,
    /// What the lanes are to show for some clocks ahead: for each 64 lanes, each clock and each word of it.
    ahead: Vec<[u64; 64]>,
    /// At which of these clocks each 64 lanes are.
    at: Vec<usize>,
    /// What they are to show now as planes, by word and bit.
    planes: Vec<LaneSet>,
    zeros: LaneSet,
    differ: LaneSet,
}

impl<'a> Judge<'a> {
    pub fn new(against: &'a Against, lanes: usize) -> Judge<'a> {
        let set = || vec![0u64; lanes / 64];
        Judge {
            against,
            packings: against.packings(),
            courses: (0..lanes).map(|_| None).collect(),
            verdicts: vec![None; lanes],
            begun: set(),
            same: set(),
            ahead: vec![[0; 64]; lanes / 64 * AHEAD * against.words],
            at: vec![0; lanes / 64],
            planes: vec![set(); against.words * 64],
            zeros: set(),
            differ: set(),
        }
    }

    /// A lane begins a row.
    pub fn begin(&mut self, lane: usize, row: u64, plan: &Plan) {
        let (word, bit) = (lane / 64, 1u64 << (lane % 64));
        self.begun[word] &= !bit;
        (self.courses[lane], self.verdicts[lane]) = (None, None);
        if plan.values(row).any(|value| value.u != 0) {
            self.verdicts[lane] = Some(Verdict::Refused("a value is not known".into()));
            self.same[word] &= !bit;
            return;
        }
        match self.against.draw(row, plan) {
            Ok(algorithm) => {
                let registers = algorithm.state();
                self.courses[lane] = Some(Course { algorithm, registers, over: false, clocks: 0 });
                self.same[word] |= bit;
            }
            Err(refused) => {
                self.verdicts[lane] = Some(Verdict::Refused(refused.to_string()));
                self.same[word] &= !bit;
            }
        }
    }

    /// Compares some lanes after an instant in which `dt` rose (`Some(true)`), fell, or did neither. With `all` they are
    /// all that run; else the others rest.
    pub fn look(&mut self, engine: &BatchEngine, set: &[u64], all: bool, edge: Option<bool>) {
        let mut rests = false;
        for (word, &lanes) in set.iter().enumerate() {
            let compared = lanes & self.same[word];
            let fresh = compared & !self.begun[word];
            if fresh != 0 {
                rests = true;
                self.begun[word] |= fresh;
                self.run_ahead(word, fresh, self.at[word], AHEAD);
            }
            let old = compared & !fresh;
            if edge == Some(false) && old != 0 {
                if all {
                    self.at[word] += 1;
                    if self.at[word] == AHEAD {
                        self.at[word] = 0;
                        self.run_ahead(word, old, 0, AHEAD);
                    }
                    each(old, |lane| {
                        if let Some(course) = &mut self.courses[word * 64 + lane] {
                            course.clocks += 1;
                        }
                    });
                } else {
                    self.step_alone(word, old);
                }
            }
            if fresh != 0 || edge == Some(false) && old != 0 {
                self.turn(word);
            }
        }
        if edge.is_none() && !rests {
            return;
        }
        let pulses = edge == Some(true);
        self.differ.fill(0);
        for field in &self.against.fields {
            let step = matches!(field.what, What::Step(_));
            let mut at = field.word * 64 + field.shift as usize;
            for slice in &field.bits {
                for i in 0..slice.width {
                    let bit = Slice { lo: slice.lo + i, width: 1, ..*slice };
                    let expected = if step && !pulses { &self.zeros } else { &self.planes[at] };
                    engine.differ(bit, expected, &mut self.differ);
                    at += 1;
                }
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

    /// The place of a clock and a word in `ahead`.
    fn place(&self, group: usize, clock: usize, word: usize) -> usize {
        (group * AHEAD + clock) * self.against.words + word
    }

    /// Lets the algorithms of some of 64 lanes fill their clocks ahead, of these numbers.
    fn run_ahead(&mut self, group: usize, set: u64, from: usize, to: usize) {
        let words = self.against.words;
        let mut buffer = [0u64; AHEAD * WORDS];
        let buffer = &mut buffer[..(to - from) * words];
        each(set, |lane| {
            let Some(course) = &mut self.courses[group * 64 + lane] else { return };
            course.algorithm.ahead(&mut course.registers, &mut course.over, &self.packings, buffer);
            let first = (group * AHEAD + from) * words;
            for (to, value) in self.ahead[first..].iter_mut().zip(&*buffer) {
                to[lane] = *value;
            }
        });
    }

    /// A clock of some of 64 lanes while the others rest.
    fn step_alone(&mut self, group: usize, set: u64) {
        let words = self.against.words;
        for clock in self.at[group] + 1..AHEAD {
            for word in 0..words {
                let (from, to) = (self.place(group, clock, word), self.place(group, clock - 1, word));
                each(set, |lane| self.ahead[to][lane] = self.ahead[from][lane]);
            }
        }
        self.run_ahead(group, set, AHEAD - 1, AHEAD);
        each(set, |lane| {
            if let Some(course) = &mut self.courses[group * 64 + lane] {
                course.clocks += 1;
            }
        });
    }

    /// Puts what 64 lanes are to show now into the planes.
    fn turn(&mut self, group: usize) {
        for word in 0..self.against.words {
            let mut square = self.ahead[self.place(group, self.at[group], word)];
            transpose(&mut square);
            for (plane, bits) in self.planes[word * 64..].iter_mut().zip(square) {
                plane[group] = bits;
            }
        }
    }

    /// Says what differs first in a lane.
    fn blame(&mut self, engine: &BatchEngine, lane: usize, pulses: bool) {
        let Some(course) = &self.courses[lane] else { return };
        for field in &self.against.fields {
            let step = matches!(field.what, What::Step(_));
            let all = self.ahead[self.place(lane / 64, self.at[lane / 64], field.word)][lane % 64];
            let expected = if step && !pulses { 0 } else { all >> field.shift & mask(field.width) };
            if engine.number(&field.bits, lane) == Some(expected) {
                continue;
            }
            let found: Value = engine.value(&field.bits, lane);
            let found = found.to_u64().map_or_else(|| found.to_string(), |n| n.to_string());
            let level = u8::from(pulses);
            let why = format!("{} shows {found}, expected {expected}, while dt = {level}", field.name);
            self.verdicts[lane] = Some(Verdict::Differs(course.clocks + u64::from(pulses), why));
            return;
        }
    }

    /// What there is to say of a lane that has come to its end.
    pub fn verdict(&mut self, lane: usize) -> Verdict {
        self.courses[lane] = None;
        self.verdicts[lane].take().unwrap_or(Verdict::Same)
    }

    /// The same of one that has not settled.
    pub fn unsettled(&mut self, lane: usize) -> Verdict {
        let clocks = self.courses[lane].as_ref().map_or(0, |c| c.clocks);
        self.courses[lane] = None;
        self.verdicts[lane].take().unwrap_or(Verdict::Differs(clocks, "the circuit never settles".into()))
    }
}

/// Each of the 64 lanes in a set.
#[inline(always)]
fn each(mut set: u64, mut f: impl FnMut(usize)) {
    while set != 0 {
        f(set.trailing_zeros() as usize);
        set &= set - 1;
    }
}

/// Bit `i` of word `k` becomes bit `k` of word `i`.
fn transpose(a: &mut [u64; 64]) {
    let mut width = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while width != 0 {
        let mut k = 0;
        while k < 64 {
            let t = (a[k] >> width ^ a[k + width]) & mask;
            a[k] ^= t << width;
            a[k + width] ^= t;
            k = (k + width + 1) & !width;
        }
        width >>= 1;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_bits_is_turned() {
        let mut state = 1u64;
        let original: [u64; 64] = std::array::from_fn(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state ^ state >> 29
        });
        let mut turned = original;
        transpose(&mut turned);
        for (i, row) in turned.iter().enumerate() {
            for (k, old) in original.iter().enumerate() {
                assert_eq!(row >> k & 1, old >> i & 1);
            }
        }
    }
}
