//! A whole part program through the interpolators: text in, steps in time out, measured against the program.
//!
//! [`program`] reads canonical moves, exact and with their places; [`plan`] makes whole BLU of them; [`draw`] gives the
//! clocks of a method, [`clockwork`] their times, [`measure`] compares with the program; [`report`] and [`picture`] tell.
//! Everything is done move by move in bounded memory. This room knows the algorithms and how pictures are drawn; it knows
//! no circuit, no engine and no waveform.

pub mod capture;
pub mod clockwork;
pub mod draw;
mod follow;
pub mod measure;
pub mod picture;
pub mod plan;
pub mod program;
pub mod report;

use std::io::{self, BufRead};

use self::clockwork::Rule;
use self::draw::Choice;
use self::measure::{Machine, Measured, Point, Run, Unable};
use self::plan::{Plan, Scale, Shape};
use self::program::{Canon, Code, Decimal, Fault, Faults, Feed, Line, Move, Path, Refusal, Summary};
use crate::Timescale;
use crate::interpolate::MAX_BITS;

/// A machine, and what is to be measured of it.
#[derive(Clone, PartialEq, Debug)]
pub struct Settings {
    /// Millimetres and BLU.
    pub scale: Scale,
    /// The tick of the speed block's clock.
    pub tick: Timescale,
    /// The speed of G0, mm/min.
    pub rapid: Decimal,
    /// Bits of the registers; the fewest that do, but 8 at least, if not given.
    pub bits: Option<u32>,
    /// The methods.
    pub choices: Vec<Choice>,
    /// The rules of feed.
    pub rules: Vec<Rule>,
    /// How the program is read.
    pub program: program::Options,
}

impl Settings {
    fn machine(&self, bits: u32) -> Machine {
        Machine { bits, tick: self.seconds(), rapid: self.rapid.to_f64() }
    }

    /// Seconds of a tick.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.tick.femtoseconds() as f64 * 1e-15
    }
}

/// What a program is, before anything is drawn.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Survey {
    /// Lines and blocks.
    pub summary: Summary,
    /// Moves that are straight, arcs in a plane, arcs that rise.
    pub moves: [u64; 3],
    /// Of them G0.
    pub rapids: u64,
    /// Of them nothing, after rounding.
    pub nothing: u64,
    /// Arcs drawn as lines.
    pub flattened: u64,
    /// Full turns of arcs.
    pub circles: u64,
    /// The length of all moves, mm.
    pub length: f64,
    /// Seconds of G4.
    pub dwell: f64,
    /// Bits of the registers.
    pub bits: u32,
    /// The least and the greatest coordinate of the ends of moves along each axis, BLU.
    pub bounds: [[i64; 2]; 3],
    /// Bytes of the program.
    pub bytes: u64,
}

/// Looks every move over: what is wrong with the program or beyond the machine goes to `faults`. `watch` is told how many
/// bytes were read, and may stop it.
///
/// # Errors
/// The program cannot be read.
pub fn survey(
    from: impl BufRead,
    name: &str,
    settings: &Settings,
    faults: &mut Faults,
    mut watch: impl FnMut(u64) -> bool,
) -> io::Result<Survey> {
    let mut survey = Survey { bits: settings.bits.unwrap_or(8), ..Survey::default() };
    let runs: Vec<Run> = settings.choices.iter().map(|&c| Run::new(c, &settings.rules)).collect();
    let machine = settings.machine(settings.bits.unwrap_or(MAX_BITS));
    let summary = program::read(from, name, settings.program, faults, |line, canon| {
        survey.bytes = line.bytes;
        if watch(line.bytes) {
            return Err(Refusal::Stop);
        }
        match canon {
            Canon::Move(step) => survey.take(step, line, settings, &runs, &machine).map_err(Refusal::Fault),
            Canon::Dwell(seconds) => {
                survey.dwell += seconds.to_f64();
                Ok(())
            }
            _ => Ok(()),
        }
    })?;
    survey.summary = summary;
    Ok(survey)
}

impl Survey {
    fn take(
        &mut self,
        step: &Move,
        line: Line<'_>,
        settings: &Settings,
        runs: &[Run],
        machine: &Machine,
    ) -> Result<(), Fault> {
        let plan = Plan::new(step, &settings.scale, line.at())?;
        plan.check(machine.bits, line.at())?;
        let kind = match step.path {
            Path::Line => 0,
            Path::Arc(arc) if step.from[arc.plane.axes()[2]] == step.to[arc.plane.axes()[2]] => 1,
            Path::Arc(_) => 2,
        };
        self.moves[kind] += 1;
        self.rapids += u64::from(step.feed == Feed::Rapid);
        self.nothing += u64::from(plan.shape == Shape::Nothing);
        self.flattened += u64::from(plan.flattened && plan.shape == Shape::Line);
        if let Shape::Arc(arc) = plan.shape {
            let whole =
                step.from[arc.axes[0]] == step.to[arc.axes[0]] && step.from[arc.axes[1]] == step.to[arc.axes[1]];
            self.circles += u64::from(arc.circles) + u64::from(whole);
        }
        self.length += plan.mm;
        if settings.bits.is_none() {
            self.bits = self.bits.max(plan.bits);
        }
        for (axis, bounds) in self.bounds.iter_mut().enumerate() {
            *bounds = [bounds[0].min(plan.to[axis]), bounds[1].max(plan.to[axis])];
        }
        // of several methods that are too slow for a feed, the one that allows least is told of
        let unable = runs.iter().filter_map(|run| Some((run.check(&plan, machine).err()?, run.choice)));
        let part = |unable: &Unable| match unable {
            Unable::Period(period, _) if period.fast => period.part,
            _ => 0.0,
        };
        match unable.min_by(|(a, _), (b, _)| part(a).total_cmp(&part(b))) {
            Some((unable, choice)) => Err(refused(unable, &plan, choice, settings, line)),
            None => Ok(()),
        }
    }
}

/// Why the machine cannot make a move, as a fault of its block.
fn refused(unable: Unable, plan: &Plan, choice: Choice, settings: &Settings, line: Line<'_>) -> Fault {
    let at = line.at();
    match unable {
        Unable::Input(error) => Fault::new(Code::BadMove, at, format!("{choice} cannot draw this: {error}")),
        Unable::Missed([x, y, z]) => {
            Fault::new(Code::BadMove, at, format!("{choice} stops at ({x}, {y}, {z}) BLU, not at the end point"))
        }
        Unable::Period(period, rule) => {
            let speed = if plan.length > 0.0 {
                plan.speed(settings.rapid.to_f64()) * 60.0 * plan.mm / plan.length
            } else {
                0.0
            };
            let limit = speed * period.part;
            let which = if period.fast { "greatest" } else { "least" };
            let what = format!("{speed:.3} mm/min is too {} for this clock", if period.fast { "fast" } else { "slow" });
            let rapid = plan.feed == Feed::Rapid;
            let remedy = match (period.fast, rapid) {
                (true, true) => "give a lower --rapid, a shorter --tick or a coarser --blu",
                (true, false) => "write a lower F, or give a shorter --tick or a coarser --blu",
                (false, _) => "write a higher F, or give a longer --tick",
            };
            // to the side on which it can be done, but for what rounding in between has taken
            let thousandths = limit * 1000.0;
            let near = thousandths.round();
            let told = match (thousandths - near).abs() < 1e-11 * near.max(1.0) {
                true => near,
                false if period.fast => thousandths.floor(),
                false => thousandths.ceil(),
            } / 1000.0;
            Fault::new(Code::BadMove, at, what)
                .label(format!("{which} here: {told:.3} mm/min"))
                .help(format!("{remedy} (tick {}; feed `{rule}` of {choice})", settings.tick.time(1)))
        }
    }
}

/// The block that is worst, as it stands in the program.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Place {
    /// Its line, from 1.
    pub line: u64,
    /// The column, from 1, in bytes.
    pub column: usize,
    /// The line's text.
    pub text: String,
}

/// One method over the whole program.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was measured.
    pub run: Run,
    /// The block with the greatest deviation.
    pub worst: Place,
}

/// A block that was drawn.
#[derive(Debug)]
pub struct Drawn<'a> {
    /// Its line.
    pub line: Line<'a>,
    /// The move.
    pub plan: &'a Plan,
    /// The method.
    pub choice: Choice,
    /// Its index among the methods.
    pub index: usize,
    /// What was measured.
    pub measured: &'a Measured,
}

/// What sees the program being drawn.
pub trait See {
    /// A clock of the method with this index.
    fn clock(&mut self, _index: usize, _point: &Point) {}

    /// A move begins.
    fn begin(&mut self, _plan: &Plan, _line: Line<'_>) {}

    /// The program waits for some seconds.
    fn wait(&mut self, _seconds: f64) {}

    /// A move of a method is done.
    ///
    /// # Errors
    /// What it writes cannot be written.
    fn block(&mut self, _drawn: &Drawn<'_>) -> io::Result<()> {
        Ok(())
    }
}

/// Draws and measures a program that was surveyed without a fault.
///
/// # Errors
/// The program cannot be read, or what `see` writes cannot be written.
pub fn run(
    from: impl BufRead,
    name: &str,
    settings: &Settings,
    survey: &Survey,
    faults: &mut Faults,
    see: &mut impl See,
    mut watch: impl FnMut(u64) -> bool,
) -> io::Result<Vec<Outcome>> {
    let machine = settings.machine(survey.bits);
    let mut outcomes: Vec<Outcome> = settings
        .choices
        .iter()
        .map(|&choice| Outcome { run: Run::new(choice, &settings.rules), worst: Place::default() })
        .collect();
    let mut number = 0;
    let mut failed = None;
    program::read(from, name, settings.program, faults, |line, canon| {
        if failed.is_some() || watch(line.bytes) {
            return Err(Refusal::Stop);
        }
        match canon {
            Canon::Move(step) => {
                number += 1;
                let plan = Plan::new(step, &settings.scale, line.at())?;
                see.begin(&plan, line);
                for (index, outcome) in outcomes.iter_mut().enumerate() {
                    let choice = outcome.run.choice;
                    let measured = outcome
                        .run
                        .step(&plan, number, &machine, |point| see.clock(index, point))
                        .map_err(|unable| refused(unable, &plan, choice, settings, line))?;
                    let Some(measured) = measured else { continue };
                    if outcome.run.total.1 == number {
                        outcome.worst = Place {
                            line: line.number,
                            column: line.place.0 + 1,
                            text: program::readable(line.text).trim().to_owned(),
                        };
                    }
                    if let Err(error) = see.block(&Drawn { line, plan: &plan, choice, index, measured: &measured }) {
                        failed = Some(error);
                        return Err(Refusal::Stop);
                    }
                }
                Ok(())
            }
            Canon::Dwell(seconds) => {
                see.wait(seconds.to_f64());
                for outcome in &mut outcomes {
                    outcome.run.wait(seconds.to_f64(), &machine);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    })?;
    failed.map_or(Ok(outcomes), Err)
}
