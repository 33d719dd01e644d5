//! The proofs of the feed circuits: each beside its algorithm, the first difference as an error.

use std::sync::atomic::AtomicBool;

use discreta::Value;
use discreta::circuit::Circuit;
use discreta::diag::Diagnostics;
use discreta::engine::EventEngine;
use discreta::interpolate::feed::{Feed, Generator, Margins, Stores};
use discreta::interpolate::{Clock, EfLine, Interpolator, LineInput};
use discreta::scenario::{Control, Event, Scenario, Stop, run};
use discreta::value::Word;
use discreta::wave::{Layout, Sink};

use super::Rng;
use super::bench::circuit;
use super::engines::{Sim, simulator};

/// What is to be the same, and where.
fn same<T: PartialEq + std::fmt::Debug>(found: T, expected: T, place: impl Fn() -> String) -> Result<(), String> {
    if found == expected { Ok(()) } else { Err(format!("{}: {found:?}, expected {expected:?}", place())) }
}

/// A speed block against the generator, at every edge of its clock, with pulses of the axes, shifts and waits at random:
/// also more shifts than the register of the period has room for. Returns the pulses.
pub fn speed_block(circuit: &Circuit, whole: u32, fraction: u32, high: u64) -> Result<u64, String> {
    let mut sim = simulator(&circuit.netlist);
    let input =
        ["clk", "start", "enable", "constant", "period", "shifts", "x", "y", "z"].map(|n| sim.input(n).unwrap());
    let [clk, start, enable, constant, period, shifts, x, y, z] = input;
    let shown = ["dt", "elapsed", "fraction"].map(|n| sim.probe(n).unwrap());
    let most_shifts = 1 << circuit.netlist.signal(circuit.netlist.find("shifts").unwrap()).width;
    let (mut rng, mut pulses) = (Rng::new(u64::from(whole)), 0);
    for run in 0..40 {
        let (least, most) = ((high + 1).max(2) << fraction, 1 << (whole + fraction));
        // short periods often, for many pulses
        let most = if run % 4 == 0 { most } else { most.min(8 * least) };
        let (number, rule) = (least + rng.below(most - least), rng.one_in(2));
        let mut generator = Generator::new(number, whole, fraction, high, rule).unwrap();
        for (input, value) in [(clk, 0), (constant, u64::from(rule)), (period, number), (start, 1)] {
            sim.set(input, value);
        }
        sim.settle().map_err(|e| e.to_string())?;
        sim.set(start, 0);
        sim.set(period, rng.word()); // loaded already
        for tick in 0..600 {
            let (go, axes) = (!rng.one_in(8), rng.below(8));
            for (bit, input) in [x, y, z].into_iter().enumerate() {
                sim.set(input, axes >> bit);
            }
            let shift = if run % 3 == 0 { 0 } else { rng.below(most_shifts) };
            sim.set(shifts, shift);
            sim.set(enable, u64::from(go));
            for level in [0, 1] {
                sim.set(clk, level);
                sim.settle().map_err(|e| e.to_string())?;
            }
            let was = generator.dt();
            generator.clock(go, axes.count_ones() as usize, shift as u32);
            pulses += u64::from(generator.dt() && !was);
            let found = shown.each_ref().map(|p| sim.number(p));
            let expected = [u64::from(generator.dt()), generator.elapsed(), generator.fraction()].map(Some);
            same(found, expected, || format!("period {number}, {rule}, tick {tick}"))?;
        }
    }
    Ok(pulses)
}

/// A synchroniser against its store, with steps and pulses in any order that keeps the margins.
pub fn synchroniser(circuit: &Circuit, tau: u64) -> Result<(), String> {
    let mut sim = simulator(&circuit.netlist);
    let [start, step, dt] = ["start", "step", "dt"].map(|n| sim.input(n).unwrap());
    let [drive, stop, waiting, full] = ["drive", "stop", "waiting", "full"].map(|n| sim.probe(n).unwrap());
    for (input, value) in [(step, 0), (dt, 0), (start, 1)] {
        sim.set(input, value);
    }
    let settle = |sim: &mut Sim| sim.settle().map_err(|e| e.to_string());
    let wait = |sim: &mut Sim, ticks| sim.run_to(sim.now() + ticks).map_err(|e| e.to_string());
    settle(&mut sim)?;
    wait(&mut sim, 4 * tau)?;
    sim.set(start, 0);
    let (mut store, mut rng) = (Stores::default(), Rng::new(tau));
    for n in 0..2000 {
        let pulse = if !store.stop() && rng.one_in(2) { step } else { dt };
        sim.set(pulse, 1);
        settle(&mut sim)?;
        let driven = if pulse == dt { store.take()[0] } else { !store.put([true, false, false]) };
        same(sim.number(&drive), Some(u64::from(driven)), || format!("drive, pulse {n}"))?;
        wait(&mut sim, 1 + rng.below(tau - 1))?;
        sim.set(pulse, 0);
        settle(&mut sim)?;
        // long enough for the RC node to come to rest
        wait(&mut sim, 8 * tau + rng.below(3))?;
        let held = store.waiting()[0];
        let expected = [false, store.stop(), held > 0, held > 1].map(|level| Some(u64::from(level)));
        same([&drive, &stop, &waiting, &full].map(|p| sim.number(p)), expected, || format!("after pulse {n}"))?;
    }
    Ok(())
}

/// Draws with `circuits/feed/paced.json`, whose interpolator is at `core`, and compares it with the interpolator and the
/// generator at every rising edge of `clk`, and for some time after the end. It begins twice: the second START comes some
/// ticks after the first. Returns the ticks from START to the end.
pub fn paced(
    sim: &mut Sim,
    core: &str,
    inputs: [u64; 4],
    period: u64,
    mut interpolator: impl Interpolator,
    mut generator: Generator,
) -> Result<u64, String> {
    let [clk, start] = ["clk", "start"].map(|n| sim.input(n).unwrap());
    let shown = ["x", "y", "dt", "end", "xt", "yt", "shifts"].map(|n| sim.probe(n).unwrap());
    let registers = ["kox", "koy", "sx", "sy"].map(|n| sim.probe(&format!("{core}.{n}")).unwrap());
    let counters = ["speed.elapsed", "speed.fraction"].map(|n| sim.probe(n).unwrap());
    for (name, value) in ["xh", "yh", "dx", "dy", "period"].into_iter().zip(inputs.into_iter().chain([period])) {
        let input = sim.input(name).unwrap();
        sim.set(input, value);
    }
    let begun = (0..2 * (period % 80)).map(|n| (clk, (n + 1) % 2));
    for (input, level) in [(clk, 0), (start, 1), (start, 0)].into_iter().chain(begun).chain([(start, 1), (start, 0)]) {
        sim.set(input, level);
        sim.settle().map_err(|e| e.to_string())?;
    }
    let mut state = interpolator.state();
    // the clock that is under way while Δt is high
    let mut pending = None;
    let (mut tick, mut end) = (0, state.end.then_some(0));
    while end.is_none_or(|end| tick < end + 100) {
        tick += 1;
        let axes = pending.map_or(0, |clock: Clock| clock.axes());
        let was = generator.dt();
        generator.clock(!state.end, axes, state.sum[2] as u32);
        match (was, generator.dt()) {
            (false, true) => pending = interpolator.next(),
            (true, false) => state = pending.take().ok_or("a clock after the end")?,
            _ => {}
        }
        if state.end && end.is_none() {
            end = Some(tick);
        }
        for level in [1, 0] {
            sim.set(clk, level);
            sim.settle().map_err(|e| e.to_string())?;
            let step = pending.map_or([0; 3], |clock| clock.step).map(|s| u64::from(s != 0));
            let [dt, end] = [generator.dt(), state.end].map(u64::from);
            let expected = [step[0], step[1], dt, end, state.at[0] as u64, state.at[1] as u64, state.sum[2] as u64];
            same(shown.each_ref().map(|p| sim.number(p)), expected.map(Some), || format!("tick {tick}"))?;
            let expected = [state.left[0], state.left[1], state.sum[0] as u64, state.sum[1] as u64];
            same(registers.each_ref().map(|p| sim.number(p)), expected.map(Some), || {
                format!("registers, tick {tick}")
            })?;
            let expected = [generator.elapsed(), generator.fraction()];
            same(counters.each_ref().map(|p| sim.number(p)), expected.map(Some), || format!("counters, tick {tick}"))?;
        }
    }
    end.ok_or_else(|| "no end".to_owned())
}

/// Random lines, some of them along an axis.
pub fn lines(rng: &mut Rng, n: usize, most: u64) -> Vec<(u64, u64)> {
    let mut line = || {
        let mut increment = || if rng.one_in(10) { 0 } else { 1 + rng.below(most) };
        (increment(), increment())
    };
    (0..n).map(|_| line()).collect()
}

/// `circuits/feed/system.json` with its own scenario.
pub struct System {
    circuit: Circuit,
    scenario: Scenario,
}

/// What a run did.
pub struct Run {
    /// Rising edges of Δt: the tick, and whether the drives step.
    pub pulses: Vec<(u64, bool, bool)>,
    /// Violations of each timing check.
    pub violations: Vec<(String, u64)>,
}

impl System {
    pub fn new(m: Margins, extra: impl IntoIterator<Item = (&'static str, i64)>) -> System {
        let mut parameters: Vec<(&str, i64)> = [
            ("STEP", m.step),
            ("STEP_HIGH", m.high),
            ("TAU", m.tau),
            ("HOLD", m.hold),
            ("TICK", m.tick),
            ("HIGH", m.dt_high),
        ]
        .map(|(name, n)| (name, n as i64))
        .to_vec();
        parameters.extend(extra);
        System::of(circuit("circuits/feed/system.json", &parameters), m.tau)
    }

    /// A system elaborated for a delay of `tau`.
    pub fn of(circuit: Circuit, tau: u64) -> System {
        let mut told = Diagnostics::new();
        let mut scenario = Scenario::resolve(&circuit, circuit.simulation.as_ref().unwrap(), &mut told);
        assert!(!told.has_errors());
        scenario.expect.clear();
        scenario.trace = ["dt", "x", "y"].map(|n| circuit.netlist.find(n).unwrap()).to_vec();
        // START lasts until the RC nodes are at rest
        scenario.stimulus[1].time = 2 * tau + 2;
        System { circuit, scenario }
    }

    /// Draws a line; `period` has 8 bits of fraction.
    pub fn draw(&mut self, dx: u64, dy: u64, period: u64, constant: bool) -> Run {
        self.try_draw((dx, dy), period, constant).unwrap_or_else(|fault| panic!("({dx}, {dy}): {fault}"))
    }

    /// Draws a line within the margins: no violation, and every pulse of Δt with the steps and after the interval that the
    /// algorithm has. Returns the pulses.
    pub fn prove(&mut self, m: Margins, line: (u64, u64), period: u64, constant: bool) -> Result<usize, String> {
        let told = || format!("period {period}, {constant}");
        let mut generator = Generator::new(period, 20, 8, m.dt_high, constant).unwrap();
        let input = LineInput { xh: 0, yh: 0, dx: line.0 as i64, dy: line.1 as i64, bits: 8 };
        let mut at = m.tick * generator.interval(0, 0);
        let mut expected = Vec::new();
        for [x, y, _] in Feed::new(EfLine::new(input).unwrap()) {
            expected.push((at, x, y));
            at += m.tick * generator.interval(usize::from(x) + usize::from(y), 0);
        }
        // well beyond the end, so that a pulse too many would be seen
        let longest = 4 * m.step * (m.hold + 3) + 4 * m.tick * (period >> 8);
        let until = self.scenario.until.take();
        self.scenario.limit = self.scenario.stimulus.last().map_or(0, |e| e.time) + at + longest;
        self.scenario.limit_given = true;
        let run = self.try_draw(line, period, constant);
        self.scenario.until = until;
        let run = run?;
        // a START half way cuts pulses, and the steps that were stored are gone
        let again = self.scenario.stimulus.len() > 2;
        let allowed = |name: &str| again && ["cut", "runt", "steps"].iter().any(|n| name.starts_with(n));
        same(run.violations.iter().find(|v| v.1 > 0 && !allowed(&v.0)), None, told)?;
        let started = self.scenario.stimulus[self.scenario.stimulus.len() - 2].time;
        let mut pulses: Vec<_> = run.pulses.into_iter().filter(|p| p.0 > started).collect();
        // when the first pulse comes is the filling's affair
        let first = |pulses: &[(u64, bool, bool)]| pulses.first().map_or(0, |p| p.0);
        let (found, wanted) = (first(&pulses), first(&expected));
        pulses.iter_mut().for_each(|p| p.0 = p.0 - found + wanted);
        let count = expected.len();
        same(pulses, expected, told)?;
        Ok(count)
    }

    /// From now on START comes once more, `ticks` after it has first ended.
    pub fn start_again(&mut self, ticks: u64) {
        let [on, off] = &self.scenario.stimulus[..2] else { unreachable!() };
        let (on, off, at) = (on.sets.clone(), off.sets.clone(), off.time);
        self.scenario.stimulus.truncate(2);
        self.scenario.stimulus.push(Event { time: at + ticks, sets: on });
        self.scenario.stimulus.push(Event { time: at + ticks + at, sets: off });
    }

    fn try_draw(&mut self, (dx, dy): (u64, u64), period: u64, constant: bool) -> Result<Run, String> {
        let netlist = &self.circuit.netlist;
        for (name, number) in [("dx", dx), ("dy", dy), ("period", period), ("constant", u64::from(constant))] {
            let signal = netlist.signal(netlist.find(name).unwrap());
            let input = self.scenario.inputs.iter_mut().find(|i| Some(i.0) == signal.drive).unwrap();
            input.1 = Value::from_u64(number, signal.width);
        }
        let mut control = Control {
            interrupt: &AtomicBool::new(false),
            progress: &mut |_| {},
            message: &mut |_, _, _| {},
            unknown_control_ends: false,
            observers: Vec::new(),
        };
        let mut pulses = Pulses::default();
        let mut engine = EventEngine::new(netlist);
        let outcome = run(netlist, &self.scenario, &mut engine, Some(&mut pulses), &mut control);
        let outcome = outcome.map_err(|e| format!("{e:?}"))?;
        let expected = if self.scenario.until.is_some() { Stop::Until } else { Stop::Limit };
        same(outcome.stop, expected, || "stop".into())?;
        let end = outcome.outputs.iter().find(|o| netlist.signal(o.0).name == "end").map(|o| o.1.to_u64());
        same(end, Some(Some(1)), || "end".into())?;
        pulses.look();
        Ok(Run {
            pulses: pulses.found,
            violations: self
                .scenario
                .checks
                .iter()
                .zip(&outcome.checks)
                .map(|(c, r)| (c.name.clone(), r.count))
                .collect(),
        })
    }
}

/// A waveform of which only the pulses of Δt are kept.
#[derive(Default)]
struct Pulses {
    now: u64,
    high: [bool; 3],
    was: bool,
    found: Vec<(u64, bool, bool)>,
}

impl Pulses {
    /// At the end of an instant.
    fn look(&mut self) {
        let [dt, x, y] = self.high;
        if dt && !self.was {
            self.found.push((self.now, x, y));
        }
        self.was = dt;
    }
}

impl Sink for Pulses {
    fn begin(&mut self, _: &Layout) -> std::io::Result<()> {
        Ok(())
    }

    fn time(&mut self, now: u64) -> std::io::Result<()> {
        self.look();
        self.now = now;
        Ok(())
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        self.high[var] = value[0].is_one();
    }

    fn finish(&mut self, _: u64) -> std::io::Result<()> {
        Ok(())
    }
}

/// What became of a line.
pub struct Line {
    pub line: (u64, u64),
    pub gained: bool,
    pub lost: bool,
    pub runt: bool,
    pub faulty: bool,
}

/// What became of many.
#[derive(Default)]
pub struct Found {
    pub runs: Vec<Line>,
}

impl Found {
    pub fn add(&mut self, run: &Run, line: (u64, u64)) {
        let count = |axis: fn(&(u64, bool, bool)) -> bool| run.pulses.iter().filter(|p| axis(p)).count() as u64;
        let (x, y) = (count(|p| p.1), count(|p| p.2));
        let violated = |name: &str| run.violations.iter().any(|v| v.0.starts_with(name) && v.1 > 0);
        self.runs.push(Line {
            line,
            gained: x > line.0 || y > line.1,
            lost: x < line.0 || y < line.1,
            runt: violated("runt"),
            faulty: violated(""),
        });
    }

    pub fn count(&self, which: fn(&Line) -> bool) -> usize {
        self.runs.iter().filter(|run| which(run)).count()
    }

    pub fn gained(&self) -> usize {
        self.count(|run| run.gained)
    }

    pub fn lost(&self) -> usize {
        self.count(|run| run.lost)
    }

    pub fn faulty(&self) -> usize {
        self.count(|run| run.faulty)
    }

    pub fn share(&self, runs: usize) -> f64 {
        runs as f64 / self.runs.len() as f64
    }
}
