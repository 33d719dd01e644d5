//! When each clock comes, under each rule of the speed block, and what that makes of the drives' pulses.

use std::fmt;

use super::plan::Plan;
use crate::interpolate::feed::Generator;

/// Bits of whole ticks of a period, and of its fraction.
const BITS: [u32; 2] = [32, 24];

/// The shortest interval, ticks.
const LEAST: f64 = 2.0;

/// A step pulse is high for this long, or half of the time to the next clock if that is less, ticks. The direction of the
/// next step changes as it ends.
pub const HIGH: u64 = 10;

/// Speeds are measured over this way, BLU.
const WINDOW: f64 = 10.0;

/// How the period of the clock follows from the feed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rule {
    /// `step`: Δt = 1/V.
    Step,
    /// `constant`: the same, and after a step of two axes 1.41, of three 1.73 times as long.
    Constant,
    /// `block`: Δt = L/(V·N), with N the clocks of the block.
    Block,
}

impl Rule {
    /// All, in the order of tables.
    pub const ALL: [Rule; 3] = [Rule::Step, Rule::Constant, Rule::Block];
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Rule::Step => "step",
            Rule::Constant => "constant",
            Rule::Block => "block",
        })
    }
}

/// The period of a block is not one that the clock can make.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NoPeriod {
    /// The speed that can be: part of the one asked for.
    pub part: f64,
    /// It was too fast, else too slow.
    pub fast: bool,
}

/// What is measured of pulses in time, of a block or of all.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Times {
    /// Ticks in all.
    pub ticks: u64,
    /// The speed, as parts of the one asked for: least, mean and greatest.
    pub speed: [f64; 3],
    /// The shortest time between two pulses of an axis, ticks.
    pub gap: u64,
    /// The shortest time from a change of an axis' direction to its pulse, ticks.
    pub setup: u64,
}

impl Times {
    /// Nothing yet.
    pub const NONE: Times = Times { ticks: 0, speed: [f64::INFINITY, 0.0, 0.0], gap: u64::MAX, setup: u64::MAX };

    /// The worst of both.
    pub fn join(&mut self, other: &Times) {
        self.ticks += other.ticks;
        self.speed[0] = self.speed[0].min(other.speed[0]);
        self.speed[2] = self.speed[2].max(other.speed[2]);
        self.gap = self.gap.min(other.gap);
        self.setup = self.setup.min(other.setup);
    }
}

/// The speed block under one rule.
#[derive(Clone, Debug)]
pub struct Clockwork {
    /// The rule.
    pub rule: Rule,
    generator: Option<Generator>,
    now: u64,
    /// The clock before.
    last: u64,
    /// Axes of the step before.
    stepped: usize,
    /// When each axis stepped last, and which way.
    pulses: [Option<(u64, i8)>; 3],
    /// The present block: its begin, the begin of the window, and where that was.
    begun: u64,
    window: (u64, f64),
    /// Ticks for one BLU at the speed asked for.
    per_blu: f64,
    block: Times,
}

impl Clockwork {
    /// At rest, at 0.
    #[must_use]
    pub const fn new(rule: Rule) -> Clockwork {
        Clockwork {
            rule,
            generator: None,
            now: 0,
            last: 0,
            stepped: 0,
            pulses: [None; 3],
            begun: 0,
            window: (0, 0.0),
            per_blu: 0.0,
            block: Times::NONE,
        }
    }

    /// The ticks of the shortest clock of a block, as a number with 24 bits of fraction; `per_blu` are the ticks for a BLU at
    /// the speed asked for, `weight` is how many shortest clocks the block has.
    ///
    /// # Errors
    /// Below 2 ticks, or beyond 32 bits of them.
    pub fn period(rule: Rule, dda: bool, per_blu: f64, length: f64, weight: u64) -> Result<u64, NoPeriod> {
        let ticks = match rule {
            Rule::Step | Rule::Constant if !dda => per_blu,
            _ => per_blu * length / weight as f64,
        };
        // the limit itself, but for what rounding has taken of it
        if ticks < LEAST * (1.0 - 1e-12) {
            return Err(NoPeriod { part: ticks / LEAST, fast: true });
        }
        let most = 2f64.powi(BITS[0] as i32) - 1.0;
        if ticks > most {
            return Err(NoPeriod { part: ticks / most, fast: false });
        }
        Ok((ticks * f64::from(1 << BITS[1])).round() as u64)
    }

    /// Begins a block.
    pub fn begin(&mut self, period: u64, per_blu: f64, along: f64, dda: bool) {
        // the document's DDA has its own rule, by which no interval depends on the steps
        let constant = self.rule == Rule::Constant && !dda;
        self.generator = Generator::new(period, BITS[0], BITS[1], 1, constant).ok();
        (self.begun, self.window, self.per_blu) = (self.now, (self.now, along), per_blu);
        self.block = Times::NONE;
    }

    /// One clock: when it comes, ticks.
    #[inline]
    pub fn clock(&mut self, step: [i8; 3], shifts: u32, along: f64) -> u64 {
        let Some(generator) = &mut self.generator else { return self.now };
        let interval = generator.interval(self.stepped, shifts);
        self.now += interval;
        let since = self.now - self.last;
        self.last = self.now;
        self.stepped = 0;
        for (step, pulse) in step.into_iter().zip(&mut self.pulses) {
            if step == 0 {
                continue;
            }
            self.stepped += 1;
            if let Some((at, direction)) = *pulse {
                self.block.gap = self.block.gap.min(self.now - at);
                if direction != step {
                    self.block.setup = self.block.setup.min(since - HIGH.min(since / 2));
                }
            }
            *pulse = Some((self.now, step));
        }
        let way = along - self.window.1;
        if way >= WINDOW {
            let speed = way * self.per_blu / (self.now - self.window.0) as f64;
            self.block.speed[0] = self.block.speed[0].min(speed);
            self.block.speed[2] = self.block.speed[2].max(speed);
            self.window = (self.now, along);
        }
        self.now
    }

    /// Ends a block of this length, and tells what was measured.
    pub fn end(&mut self, length: f64) -> Times {
        let mut times = self.block;
        times.ticks = self.now - self.begun;
        if times.ticks > 0 {
            times.speed[1] = length * self.per_blu / times.ticks as f64;
            if times.speed[0] == f64::INFINITY {
                times.speed = [times.speed[1]; 3];
            }
        }
        times
    }

    /// Nothing moves for some time.
    pub fn wait(&mut self, ticks: u64) {
        self.now = self.now.saturating_add(ticks);
        self.stepped = 0;
    }

    /// The time, ticks.
    #[must_use]
    pub const fn now(&self) -> u64 {
        self.now
    }
}

/// Ticks for one BLU of a block.
#[must_use]
pub fn per_blu(plan: &Plan, rapid: f64, tick: f64) -> f64 {
    1.0 / (plan.speed(rapid) * tick)
}
