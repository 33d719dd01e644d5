//! What is measured of one method over a whole program.

use super::clockwork::{Clockwork, NoPeriod, Rule, Times, per_blu};
use super::draw::{Choice, Drawer, Tick};
use super::follow::Follow;
use super::plan::{Plan, Shape};
use crate::interpolate::{InputError, Method};

/// Bins of the histogram of deviations, a tenth of a BLU each; the last has the rest.
pub const BINS: usize = 21;

/// The machine that is measured.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Machine {
    /// Bits of its registers.
    pub bits: u32,
    /// Seconds of a tick of its clock.
    pub tick: f64,
    /// The speed of G0, mm/min.
    pub rapid: f64,
}

/// Why a move cannot be made.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Unable {
    /// The interpolator refuses it.
    Input(InputError),
    /// The clock cannot do its speed.
    Period(NoPeriod, Rule),
    /// The interpolator stopped elsewhere, BLU.
    Missed([i64; 3]),
}

/// What was measured of a block.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Clocks.
    pub clocks: u64,
    /// The greatest distance from the curve between rounded points, BLU.
    pub interpolation: f64,
    /// The greatest distance from the program's curve, BLU.
    pub total: f64,
    /// For each rule.
    pub times: Vec<Times>,
}

/// A point of the path, as it is drawn in a picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Point {
    /// Where it is, BLU.
    pub at: [i64; 3],
    /// Its steps.
    pub step: [i8; 3],
    /// The distance from the program's curve, BLU.
    pub off: f64,
    /// The way along the block so far, BLU.
    pub along: f64,
    /// When, ticks, under each of the rules.
    pub time: [u64; 3],
}

/// One method, and what is known of it so far.
#[derive(Clone, Debug)]
pub struct Run {
    /// The method.
    pub choice: Choice,
    /// The speed block under each rule.
    pub clockworks: Vec<Clockwork>,
    /// Clocks in all.
    pub clocks: u64,
    /// Steps along each axis.
    pub steps: [u64; 3],
    /// The greatest distance from the curve between rounded points, BLU.
    pub interpolation: f64,
    /// The greatest distance from the program's curve, BLU, and the block that has it.
    pub total: (f64, u64),
    /// Clocks by their distance from the program's curve.
    pub histogram: [u64; BINS],
    /// In all, for each rule; the mean speed is the ideal time over the real one.
    pub times: Vec<Times>,
    /// Ticks of all moves at exactly the speed asked for.
    pub ideal: f64,
    at: [i64; 3],
}

impl Run {
    /// At the origin.
    #[must_use]
    pub fn new(choice: Choice, rules: &[Rule]) -> Run {
        Run {
            choice,
            clockworks: rules.iter().map(|&r| Clockwork::new(r)).collect(),
            clocks: 0,
            steps: [0; 3],
            interpolation: 0.0,
            total: (0.0, 0),
            histogram: [0; BINS],
            times: vec![Times::NONE; rules.len()],
            ideal: 0.0,
            at: [0; 3],
        }
    }

    /// Whether the clocks of a move by this method have the rule of differential increments.
    fn dda(&self, plan: &Plan) -> bool {
        Choice::dda(match plan.shape {
            Shape::Arc(_) => self.choice.arc,
            _ => self.choice.line_method(plan.to[2] != plan.from[2]),
        })
    }

    /// A drawer of the move; an arc of a few BLU that the interpolator refuses is drawn as a line.
    fn drawer(&self, plan: &Plan, bits: u32) -> Result<(Drawer, Plan), Unable> {
        match Drawer::new(plan, self.choice, bits) {
            Ok(drawer) => Ok((drawer, *plan)),
            Err(_) if small(plan) => {
                let line = plan.flatten();
                Drawer::new(&line, self.choice, bits).map(|d| (d, line)).map_err(Unable::Input)
            }
            Err(error) => Err(Unable::Input(error)),
        }
    }

    /// Whether the machine can make this move, without making it.
    ///
    /// # Errors
    /// What it cannot.
    pub fn check(&self, plan: &Plan, machine: &Machine) -> Result<(), Unable> {
        if plan.shape == Shape::Nothing {
            return Ok(());
        }
        if let Shape::Arc(arc) = plan.shape {
            // without its rise, whose clocks would have to be counted
            let mut flat = *plan;
            flat.to[arc.axes[2]] = flat.from[arc.axes[2]];
            self.drawer(&flat, machine.bits)?;
        }
        let per_blu = per_blu(plan, machine.rapid, machine.tick);
        // no block has more than three clocks a BLU, or fewer than one in three; only near the limits is it looked at exactly
        if per_blu > 8.0 && per_blu < 1e9 {
            return Ok(());
        }
        let (drawer, plan) = self.drawer(plan, machine.bits)?;
        let dda = self.dda(&plan);
        let (_, weight) = drawer.weight();
        for clockwork in &self.clockworks {
            Clockwork::period(clockwork.rule, dda, per_blu, plan.length, weight)
                .map_err(|error| Unable::Period(error, clockwork.rule))?;
        }
        Ok(())
    }

    /// Makes a move and measures it; `number` is that of the block, `see` sees every clock.
    ///
    /// # Errors
    /// A move that the machine cannot make. [`check`](Run::check) tells that before.
    pub fn step(
        &mut self,
        plan: &Plan,
        number: u64,
        machine: &Machine,
        mut see: impl FnMut(&Point),
    ) -> Result<Option<Measured>, Unable> {
        if plan.shape == Shape::Nothing {
            self.at = plan.to;
            return Ok(None);
        }
        let (mut drawer, plan) = self.drawer(plan, machine.bits)?;
        let per_blu = per_blu(&plan, machine.rapid, machine.tick);
        let dda = self.dda(&plan);
        let counted = dda || self.clockworks.iter().any(|c| c.rule == Rule::Block);
        let weight = if counted { self.weight(&plan, machine.bits)? } else { 1 };
        let start = plan.from.map(|v| v as f64);
        let (mut rounded, mut exact) = (Follow::new(plan.rounded, start), Follow::new(plan.exact, start));
        let begin = exact.to(start);
        for clockwork in &mut self.clockworks {
            let period = Clockwork::period(clockwork.rule, dda, per_blu, plan.length, weight)
                .map_err(|error| Unable::Period(error, clockwork.rule))?;
            clockwork.begin(period, per_blu, begin.along, dda);
        }
        let mut at = plan.from;
        let (mut clocks, mut interpolation, mut total) = (0, 0_f64, begin.off);
        while let Some(Tick { step, shifts }) = drawer.tick() {
            clocks += 1;
            for axis in 0..3 {
                at[axis] += i64::from(step[axis]);
                self.steps[axis] += u64::from(step[axis] != 0);
            }
            let point = at.map(|v| v as f64);
            let (inner, outer) = (rounded.to(point), exact.to(point));
            interpolation = interpolation.max(inner.off);
            total = total.max(outer.off);
            self.histogram[((outer.off * 10.0) as usize).min(BINS - 1)] += 1;
            let mut time = [0; 3];
            for (clockwork, time) in self.clockworks.iter_mut().zip(&mut time) {
                *time = clockwork.clock(step, shifts, outer.along);
            }
            see(&Point { at, step, off: outer.off, along: outer.along, time });
        }
        if at != plan.to {
            return Err(drawer.refused().map_or(Unable::Missed(at), Unable::Input));
        }
        self.at = at;
        let times: Vec<Times> = self.clockworks.iter_mut().map(|c| c.end(plan.length)).collect();
        for (all, one) in self.times.iter_mut().zip(&times) {
            all.join(one);
        }
        self.clocks += clocks;
        self.ideal += plan.length * per_blu;
        self.interpolation = self.interpolation.max(interpolation);
        if total > self.total.0 {
            self.total = (total, number);
        }
        Ok(Some(Measured { clocks, interpolation, total, times }))
    }

    /// The shortest clocks of the block together: known for lines, counted for arcs.
    fn weight(&self, plan: &Plan, bits: u32) -> Result<u64, Unable> {
        let d = [0, 1, 2].map(|a| (plan.to[a] - plan.from[a]).unsigned_abs());
        match (plan.shape, self.choice.line_method(d[2] != 0)) {
            // parallel to an axis it may have a clock without a step, in which F changes its sign
            (Shape::Line, Method::EfLine) if d[0] > 0 && d[1] > 0 => Ok(d[0] + d[1]),
            (Shape::Line, Method::EfLineFast | Method::EfLine3d) => Ok(d[0].max(d[1]).max(d[2])),
            _ => Ok(self.drawer(plan, bits)?.0.weight().1),
        }
    }

    /// Nothing moves for some time.
    pub fn wait(&mut self, seconds: f64, machine: &Machine) {
        let ticks = (seconds / machine.tick).round().max(0.0) as u64;
        for (clockwork, times) in self.clockworks.iter_mut().zip(&mut self.times) {
            clockwork.wait(ticks);
            times.ticks = times.ticks.saturating_add(ticks);
        }
        self.ideal += ticks as f64;
    }

    /// Where the machine is, BLU.
    #[must_use]
    pub const fn at(&self) -> [i64; 3] {
        self.at
    }
}

/// An arc so small that what rounding does to its points may leave none.
fn small(plan: &Plan) -> bool {
    match plan.shape {
        Shape::Arc(arc) => {
            let r = (0..2).map(|i| arc.from[i].abs_diff(arc.center[i])).max().unwrap_or(0);
            r <= 4 && arc.circles == 0
        }
        _ => false,
    }
}
