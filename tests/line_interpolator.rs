//! The line by evaluation function: the circuit of registers, the circuit of gates and the algorithm agree on every clock.

mod support;

use discreta::circuit::{Circuit, load_with};
use discreta::interpolate::{EfLine, EfLineInput};
use discreta::{Input, Probe, Simulator, SimulatorError};
use serde_json::{Value, json};
use support::{Rng, folder, repository};

const CIRCUITS: [&str; 2] = ["circuits/evaluation/line.json", "circuits/evaluation/line_gates.json"];

fn circuit(path: &str, bits: u32) -> Circuit {
    load_with(repository(path), &[("W", i64::from(bits))]).unwrap_or_else(|e| panic!("{e}"))
}

/// A line to draw.
#[derive(Clone, Copy, Debug)]
struct Line {
    dx: u64,
    dy: u64,
    xh: u64,
    yh: u64,
    bits: u32,
}

impl Line {
    fn algorithm(self) -> EfLine {
        let [dx, dy, xh, yh] = [self.dx, self.dy, self.xh, self.yh].map(|n| n as i64);
        EfLine::new(EfLineInput { xh, yh, dx, dy, bits: self.bits }).unwrap()
    }
}

/// What the circuit shows, named as the algorithm names it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Shown {
    xt: Option<u64>,
    yt: Option<u64>,
    kox: Option<u64>,
    koy: Option<u64>,
    f: Option<i64>,
    end: Option<u64>,
    x: Option<u64>,
    y: Option<u64>,
}

/// A circuit on which lines are drawn one after another, without a reset between them.
struct Bench<'c> {
    sim: Simulator<'c>,
    inputs: [Input; 6],
    outputs: [Probe; 8],
    bits: u32,
    clocks: u64,
}

impl<'c> Bench<'c> {
    fn new(circuit: &'c Circuit, bits: u32) -> Bench<'c> {
        let sim = Simulator::new(&circuit.netlist);
        let inputs = ["start", "dt", "dx", "dy", "xh", "yh"].map(|n| sim.input(n).unwrap());
        let outputs = ["xt", "yt", "kox", "koy", "f", "end", "x", "y"].map(|n| sim.probe(n).unwrap());
        let mut bench = Bench { sim, inputs, outputs, bits, clocks: 0 };
        bench.sim.set(bench.inputs[1], 0);
        bench
    }

    fn shown(&self) -> Shown {
        let [xt, yt, kox, koy, f, end, x, y] = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| self.sim.number(&self.outputs[i]));
        let unused = 64 - (self.bits + 1);
        let f = f.map(|f| (f << unused) as i64 >> unused);
        Shown { xt, yt, kox, koy, f, end, x, y }
    }

    fn set(&mut self, input: usize, value: u64) -> Result<(), String> {
        self.sim.set(self.inputs[input], value);
        self.sim.settle().map_err(|e: SimulatorError| e.to_string())
    }

    /// Draws a line and compares each clock with the algorithm, at both levels of `dt`, and two clocks more.
    fn draw(&mut self, line: Line) -> Result<(), String> {
        for (input, value) in [(2, line.dx), (3, line.dy), (4, line.xh), (5, line.yh)] {
            self.sim.set(self.inputs[input], value);
        }
        self.set(0, 1)?;
        let mut algorithm = line.algorithm();
        let mut last = algorithm.state();
        let mut clock = 0;
        let at_rest = |c: &discreta::interpolate::ef_line::Clock| Shown {
            xt: Some(c.xt),
            yt: Some(c.yt),
            kox: Some(c.kox),
            koy: Some(c.koy),
            f: Some(c.f),
            end: Some(u64::from(c.end)),
            x: Some(0),
            y: Some(0),
        };
        let check = |bench: &Bench, expected: Shown, clock: u64, dt: u64| {
            let shown = bench.shown();
            if shown == expected {
                return Ok(());
            }
            Err(format!("{line:?}, clock {clock}, dt = {dt}:\n  shows    {shown:?}\n  expected {expected:?}"))
        };
        check(self, at_rest(&last), 0, 0)?; // already while start is 1
        self.set(0, 0)?;
        check(self, at_rest(&last), 0, 0)?;
        let mut beyond = 0;
        while beyond < 2 {
            let next = algorithm.next();
            clock += 1;
            // while dt is high: the pulses, and the registers as they were
            let (x, y) = next.map_or((false, false), |c| (c.x, c.y));
            self.set(1, 1)?;
            check(self, Shown { x: Some(x.into()), y: Some(y.into()), ..at_rest(&last) }, clock, 1)?;
            self.set(1, 0)?;
            match next {
                Some(c) => last = c,
                None => beyond += 1,
            }
            check(self, at_rest(&last), clock, 0)?;
        }
        self.clocks += clock;
        Ok(())
    }
}

fn check_all(bits: u32, lines: impl Iterator<Item = Line> + Clone) -> u64 {
    let mut clocks = 0;
    for path in CIRCUITS {
        let circuit = circuit(path, bits);
        let mut bench = Bench::new(&circuit, bits);
        for line in lines.clone() {
            bench.draw(line).unwrap_or_else(|fault| panic!("{path}: {fault}"));
        }
        clocks += bench.clocks;
    }
    clocks
}

fn every(bits: u32) -> impl Iterator<Item = (u64, u64)> + Clone {
    (0..1 << bits).flat_map(move |dx| (0..1 << bits).map(move |dy| (dx, dy)))
}

#[test]
fn every_4_bit_line_from_the_origin_and_from_elsewhere() {
    let mut rng = Rng::new(4);
    let lines: Vec<Line> = every(4)
        .flat_map(|(dx, dy)| {
            let mut line = |far: u64| Line { dx, dy, xh: far * rng.below(16), yh: far * rng.below(16), bits: 4 };
            [line(0), line(1), line(1)]
        })
        .collect();
    let clocks = check_all(4, lines.iter().copied());
    println!("{} lines of 4 bits, {clocks} clocks", lines.len());
}

#[test]
fn a_sample_of_lines_of_other_widths() {
    for bits in [1, 2, 3, 5, 8, 12] {
        let mut rng = Rng::new(u64::from(bits));
        let most = (1 << bits) - 1;
        let mut lines = Vec::new();
        for n in 0..200 {
            // the ends of the range often: 0, 1, the greatest
            let mut increment = || *rng.pick(&[0, 1, most, most - 1, most / 2]);
            let (dx, dy) = (increment(), increment());
            let mut coordinate = |edge: u64| if n % 3 == 0 { edge } else { rng.below(most + 1) };
            let (dx, dy) = (coordinate(dx), coordinate(dy));
            lines.push(Line { dx, dy, xh: coordinate(most), yh: coordinate(0), bits });
        }
        check_all(bits, lines.into_iter());
    }
}

fn every_8_bit_line(half: u64) {
    let lines = every(8).filter(|(dx, dy)| (dx ^ dy) & 1 == half).map(|(dx, dy)| {
        let mut rng = Rng::new(dx << 8 | dy);
        Line { dx, dy, xh: rng.below(256), yh: rng.below(256), bits: 8 }
    });
    let clocks = check_all(8, lines.clone());
    println!("{} lines of 8 bits, {clocks} clocks", lines.count());
}

// in halves, for two threads: dx + dy even, and odd

#[test]
fn every_8_bit_line_with_an_even_number_of_steps() {
    every_8_bit_line(0);
}

#[test]
fn every_8_bit_line_with_an_odd_number_of_steps() {
    every_8_bit_line(1);
}

#[test]
fn the_line_of_the_document() {
    for path in CIRCUITS {
        let circuit = circuit(path, 8);
        let mut bench = Bench::new(&circuit, 8);
        bench.draw(Line { dx: 5, dy: 3, xh: 0, yh: 0, bits: 8 }).unwrap();
        // again, read as letters alone
        let mut steps = String::new();
        bench.set(0, 1).unwrap();
        bench.set(0, 0).unwrap();
        while bench.shown().end == Some(0) {
            bench.set(1, 1).unwrap();
            steps.push(match (bench.shown().x, bench.shown().y) {
                (Some(1), Some(0)) => 'X',
                (Some(0), Some(1)) => 'Y',
                other => panic!("{other:?}"),
            });
            bench.set(1, 0).unwrap();
        }
        assert_eq!(steps, "XYXYXXYX", "{path}");
    }
}

/// The comparison above notices a fault: each of these changes one thing in a circuit, and has to be caught.
#[test]
fn faults_in_the_circuits_are_caught() {
    let cell = |name: &str, field: &str| format!("/modules/line/cells/{name}{field}");
    let faults: Vec<(String, Value)> = vec![
        (cell("and1", "/type"), json!("or")),
        (cell("and2", "/connections/in"), json!(["(W+1){f[W]}", "minus_dy"])),
        (cell("or1", "/type"), json!("and")),
        (cell("or1", "/type"), json!("nor")),
        (cell("and3", "/connections/in"), json!(["not_sign", "allow_y", "dt"])),
        (cell("and3", "/connections/in"), json!(["not_sign", "allow_x"])),
        (cell("and4", "/connections/in"), json!(["f[W]", "dt", "dt"])),
        (cell("not1", "/connections/a"), json!("f[W-1]")),
        (cell("not1", "/type"), json!("buf")),
        (cell("negative", "/connections/b"), json!(["1'b0", "dx"])),
        (cell("adder", "/type"), json!("subtractor")),
        (cell("memory", "/parameters/edge"), json!("rising")),
        (cell("memory", "/connections/en"), json!("1'b1")),
        (cell("memory", "/connections/reset"), json!("1'b0")),
        (cell("memory", "/connections/clk"), json!("x")),
        (cell("trigger_x", "/connections/r"), json!("koy_zero")),
        (cell("trigger_x", "/parameters"), json!({ "dominant": "set" })),
        (cell("trigger_y", "/connections/s"), json!("1'b0")),
        (cell("kox", "/connections/clk"), json!("y")),
        (cell("kox", "/parameters/edge"), json!("rising")),
        (cell("koy", "/connections/down"), json!("1'b0")),
        (cell("koy", "/connections/d"), json!("dx")),
        (cell("register3", "/connections/clk"), json!("dt")),
        (cell("register4", "/connections/d"), json!("xh")),
        (cell("end", "/type"), json!("nand")),
    ];
    let text = std::fs::read_to_string(repository(CIRCUITS[0])).unwrap();
    let correct: Value = serde_json::from_str(&text).unwrap();
    let lines: Vec<Line> =
        every(3).map(|(dx, dy)| Line { dx, dy, xh: (dx * 3) & 7, yh: (dy * 5 + 1) & 7, bits: 3 }).collect();
    let caught = |file: &Value, name: &str| {
        let mut file = file.clone();
        file["modules"]["line"]["parameters"]["W"]["default"] = json!(3);
        let circuit = support::load(&folder("line_faults"), name, &file).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut bench = Bench::new(&circuit, 3);
        lines.iter().find_map(|&line| bench.draw(line).err())
    };
    assert_eq!(caught(&correct, "correct"), None);
    for (n, (place, wrong)) in faults.iter().enumerate() {
        let mut file = correct.clone();
        match file.pointer_mut(place) {
            Some(value) => {
                assert_ne!(value, wrong, "{place} is no fault");
                *value = wrong.clone();
            }
            None => {
                let (parent, field) = place.rsplit_once('/').unwrap();
                file.pointer_mut(parent).unwrap()[field] = wrong.clone();
            }
        }
        assert!(caught(&file, &format!("fault_{n}")).is_some(), "{place} = {wrong} goes unnoticed");
    }
    println!("{} faults caught", faults.len());
}
