//! The whole feed system under its timing checks.

use std::sync::atomic::AtomicBool;

use discreta::Value;
use discreta::circuit::Circuit;
use discreta::diag::Diagnostics;
use discreta::engine::EventEngine;
use discreta::interpolate::feed::Margins;
use discreta::scenario::{Control, Scenario, Stop, run};
use discreta::value::Word;
use discreta::wave::{Layout, Sink};

use super::bench::circuit;

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
        let circuit = circuit("circuits/feed/system.json", &parameters);
        let mut told = Diagnostics::new();
        let mut scenario = Scenario::resolve(&circuit, circuit.simulation.as_ref().unwrap(), &mut told);
        assert!(!told.has_errors());
        scenario.expect.clear();
        scenario.trace = ["dt", "x", "y"].map(|n| circuit.netlist.find(n).unwrap()).to_vec();
        // START lasts until the RC nodes are at rest
        scenario.stimulus[1].time = 2 * m.tau + 2;
        System { circuit, scenario }
    }

    /// Draws a line; `period` has 8 bits of fraction.
    pub fn draw(&mut self, dx: u64, dy: u64, period: u64, constant: bool) -> Run {
        let netlist = &self.circuit.netlist;
        for (name, number) in [("dx", dx), ("dy", dy), ("period", period), ("constant", u64::from(constant))] {
            let signal = netlist.signal(netlist.find(name).unwrap());
            let input = self.scenario.inputs.iter_mut().find(|i| Some(i.0) == signal.drive).unwrap();
            input.1 = Value::from_u64(number, signal.width);
        }
        let mut control =
            Control { interrupt: &AtomicBool::new(false), progress: &mut |_| {}, unknown_control_ends: false };
        let mut pulses = Pulses::default();
        let mut engine = EventEngine::new(netlist);
        let outcome = run(netlist, &self.scenario, &mut engine, Some(&mut pulses), &mut control).unwrap();
        assert_eq!(outcome.stop, Stop::Until, "({dx}, {dy})");
        pulses.look();
        Run {
            pulses: pulses.found,
            violations: self
                .scenario
                .checks
                .iter()
                .zip(&outcome.checks)
                .map(|(c, r)| (c.name.clone(), r.count))
                .collect(),
        }
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
