//! Which algorithm a circuit is compared with, where its inputs come from and which nets show what it computes.
//!
//! The circuit has the ports of the line interpolator: `start` loads the inputs while it is 1, `dt` is the clock, steps
//! are pulses of `x`, `y` (and `z`) while `dt` is 1, and the registers change at its trailing edge.

use std::{error, fmt};

use super::model::{Model, What};
use super::plan::Plan;
use crate::elaborate::Circuit;
use crate::interpolate::request::{arc, line, line_3d};
use crate::interpolate::{
    ArcInput, ArcPath, InputError, Interpolator, Line3dInput, LineInput, Method, Options, Packing, Quadrants, Request,
    Shape,
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

/// A net that is compared.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub name: String,
    pub bits: Vec<Slice>,
    pub what: What,
    /// Where its value stands among those of a lane.
    pub word: usize,
    pub shift: u32,
    pub width: u32,
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
    pub(super) fields: Vec<Field>,
    pub(super) words: usize,
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

    /// The bits of all nets that are compared.
    pub fn compared(&self) -> impl Iterator<Item = Slice> {
        self.fields.iter().flat_map(|f| f.bits.iter().copied())
    }

    /// The algorithm for all lanes of a block at once, if there is one.
    pub(super) fn model_of(&self, lanes: usize) -> Option<Model> {
        let width = |what: What| self.fields.iter().find(|f| f.what == what).map(|f| f.width);
        let first_quadrant = !self.signed;
        first_quadrant.then(|| Model::new(self.method, self.options, self.bits, width, lanes)).flatten()
    }

    /// What the algorithm is given for a row; none if that is not known.
    pub(super) fn values(&self, row: u64, plan: &Plan) -> Option<[i64; OPERANDS]> {
        let mut v = [0; OPERANDS];
        for (v, operand) in v.iter_mut().zip(&self.inputs) {
            *v = match *operand {
                Operand::Fixed(value) => value,
                Operand::Swept(axis, width, signed) => {
                    let word = plan.value(axis, row);
                    if word.u != 0 {
                        return None;
                    }
                    number(word.v, width, signed)
                }
            };
        }
        Some(v)
    }

    /// The algorithm of a row, or why there is none.
    pub(super) fn begin(&self, row: u64, plan: &Plan) -> Result<Box<dyn Interpolator>, String> {
        let values = self.values(row, plan).ok_or("a value is not known")?;
        self.draw(&values).map_err(|e| e.to_string())
    }

    /// The algorithm for what it is given.
    fn draw(&self, v: &[i64]) -> Result<Box<dyn Interpolator>, InputError> {
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
                    long: None,
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
    pub(super) fn packings(&self) -> Vec<Packing> {
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

/// The most that an algorithm is given.
pub(super) const OPERANDS: usize = 8;
/// The most words of what a lane is to show.
pub(super) const WORDS: usize = 8;

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
