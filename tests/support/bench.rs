//! A circuit and the algorithm that it implements, side by side, compared on every clock.

use discreta::circuit::{Circuit, load_with};
use discreta::interpolate::{Clock, Columns, Interpolator, Stopped};
use discreta::{Input, Probe};

use super::engines::{Sim, simulator};
use super::repository;

/// A shipped circuit with a value for some of its parameters.
pub fn circuit(path: &str, parameters: &[(&str, i64)]) -> Circuit {
    load_with(repository(path), parameters).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// A net that is compared.
struct Shown {
    name: &'static str,
    probe: Probe,
    mask: u64,
}

/// What the nets are to show, in the order of [`Bench::shown`]: coordinates, counters, sums, end, pulses.
type Values = [u64; 13];

/// A circuit on which drawings are made one after another, without a reset between them.
///
/// It has the ports of the line interpolator: `start` loads while it is 1, `dt` clocks, `x` and `y` (and `z`) are the
/// step pulses, with `x_dir` … 1 for a step in the negative direction where the circuit has such ports. One with the ports
/// `overflow` and `watchdog` may stop without its end, and says so there.
pub struct Bench {
    sim: Sim,
    start: Input,
    dt: Input,
    columns: Columns,
    shown: Vec<Shown>,
    directions: Vec<Option<Probe>>,
    stops: Option<(Probe, Probe)>,
    pub clocks: u64,
}

impl Bench {
    pub fn new(circuit: &Circuit, columns: Columns) -> Bench {
        let sim = simulator(&circuit.netlist);
        let (start, dt) = (sim.input("start").unwrap(), sim.input("dt").unwrap());
        let axes = &["x", "y", "z"][..columns.at.len()];
        let names = columns.at.iter().chain(columns.left).chain(columns.sum).chain(&["end"]).chain(axes);
        let shown = names
            .map(|&name| {
                // a register that a circuit around an interpolator does not show is the interpolator's
                let path = if circuit.netlist.find(name).is_some() { name.to_owned() } else { format!("core.{name}") };
                let probe = sim.probe(&path).unwrap_or_else(|e| panic!("{e}"));
                let width = circuit.netlist.signal(circuit.netlist.find(&path).unwrap()).width;
                Shown { name, probe, mask: if width >= 64 { u64::MAX } else { (1 << width) - 1 } }
            })
            .collect();
        let directions = axes.iter().map(|axis| sim.probe(&format!("{axis}_dir")).ok()).collect();
        let stops = sim.probe("overflow").ok().zip(sim.probe("watchdog").ok());
        let mut bench = Bench { sim, start, dt, columns, shown, directions, stops, clocks: 0 };
        bench.sim.set(bench.dt, 0);
        bench
    }

    fn set(&mut self, input: Input, value: u64) -> Result<(), String> {
        self.sim.set(input, value);
        self.sim.settle().map_err(|e| e.to_string())
    }

    /// What the nets are to show at rest (no pulses) or, with steps, while `dt` is high.
    fn values(&self, c: &Clock, step: [i8; 3]) -> Values {
        let mut values = [0; 13];
        let Columns { at, left, sum } = self.columns;
        let all = (c.at.iter().take(at.len()).map(|&v| v as u64))
            .chain(c.left.iter().take(left.len()).copied())
            .chain(c.sum.iter().take(sum.len()).map(|&v| v as u64))
            .chain([u64::from(c.end)])
            .chain(step.iter().take(at.len()).map(|&s| u64::from(s != 0)));
        for (to, from) in values.iter_mut().zip(all) {
            *to = from;
        }
        values
    }

    fn check(&self, expected: &Values) -> Result<(), String> {
        for (shown, expected) in self.shown.iter().zip(expected) {
            let value = self.sim.number(&shown.probe);
            if value != Some(expected & shown.mask) {
                let all = self.shown.iter().map(|s| format!("{} {:?}", s.name, self.sim.number(&s.probe)));
                return Err(format!(
                    "{} shows {value:?}, expected {}; all: {}",
                    shown.name,
                    expected & shown.mask,
                    all.collect::<Vec<_>>().join(", ")
                ));
            }
        }
        Ok(())
    }

    /// Draws with these inputs and compares each clock with the algorithm, at both levels of `dt`, until the end and two
    /// clocks more, but not more than `most` clocks. What the algorithm comes to.
    pub fn draw_for(
        &mut self,
        inputs: &[(Input, u64)],
        algorithm: &mut dyn Interpolator,
        most: u64,
    ) -> Result<Clock, String> {
        for &(input, value) in inputs {
            self.sim.set(input, value);
        }
        let mut last = algorithm.state();
        let mut clock = 0;
        let at = |clock: u64, dt: u64| move |fault: String| format!("clock {clock}, dt = {dt}: {fault}");
        let rest = self.values(&last, [0; 3]);
        for level in [1, 0] {
            // already while start is 1
            self.set(self.start, level)?;
            self.check(&rest).map_err(at(0, 0))?;
        }
        // after START the inputs no longer matter
        for &(input, value) in inputs {
            self.sim.set(input, !value);
        }
        let mut beyond = 0;
        while beyond < 2 && clock < most {
            let next = algorithm.next();
            clock += 1;
            // while dt is high: the pulses, and the registers as they were
            let step = next.map_or([0; 3], |c| c.step);
            self.set(self.dt, 1)?;
            self.check(&self.values(&last, step)).map_err(at(clock, 1))?;
            for (direction, step) in self.directions.iter().zip(step) {
                if let (Some(probe), true) = (direction, step != 0)
                    && self.sim.number(probe) != Some(u64::from(step < 0))
                {
                    return Err(at(clock, 1)(format!("a step {step} in the wrong direction")));
                }
            }
            self.set(self.dt, 0)?;
            match next {
                Some(c) => last = c,
                None => beyond += 1,
            }
            self.check(&self.values(&last, [0; 3])).map_err(at(clock, 0))?;
        }
        self.clocks += clock;
        Ok(last)
    }

    /// Draws with these inputs to the end, comparing as [`draw_for`](Bench::draw_for).
    pub fn draw(&mut self, inputs: &[(Input, u64)], algorithm: &mut dyn Interpolator) -> Result<(), String> {
        let last = self.draw_for(inputs, algorithm, u64::MAX)?;
        let stopped = algorithm.stopped();
        match &self.stops {
            Some((overflow, watchdog)) => {
                let shown = [overflow, watchdog].map(|probe| self.sim.number(probe));
                let expected = [
                    matches!(stopped, Some(Stopped::Overflow { .. })),
                    matches!(stopped, Some(Stopped::Watchdog { .. })),
                ];
                if shown == expected.map(|stop| Some(u64::from(stop))) {
                    Ok(())
                } else {
                    Err(format!("overflow and watchdog show {shown:?}, expected {stopped:?}"))
                }
            }
            None if last.end => Ok(()),
            None => Err(format!("the algorithm stopped without its end: {stopped:?}")),
        }
    }

    /// An input by its name.
    pub fn input(&self, name: &str) -> Input {
        self.sim.input(name).unwrap_or_else(|e| panic!("{e}"))
    }
}
