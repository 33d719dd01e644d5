//! The line by evaluation function: the circuit of registers, the circuit of gates and the algorithm agree on every clock.

use crate::support;

use crate::support::bench::circuit;
use crate::support::lanes::{Drawing, draw_all};
use crate::support::{Rng, folder, repository};
use discreta::circuit::Circuit;
use discreta::interpolate::{Columns, EfLine, LineInput};
use serde_json::{Value, json};

const CIRCUITS: [&str; 2] = ["circuits/evaluation/line.json", "circuits/evaluation/line_gates.json"];

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
        EfLine::new(LineInput { xh, yh, dx, dy, bits: self.bits }).unwrap()
    }
}

/// Draws lines; the clocks compared, or the first difference.
fn draw(circuit: &Circuit, lines: impl Iterator<Item = Line> + Clone) -> Result<u64, String> {
    let drawing =
        |line: Line| Drawing { inputs: vec![line.dx, line.dy, line.xh, line.yh], algorithm: line.algorithm() };
    draw_all(circuit, Columns::EVALUATION, &["dx", "dy", "xh", "yh"], || lines.clone().map(drawing))
}

fn check_all(bits: u32, lines: impl Iterator<Item = Line> + Clone) -> u64 {
    let mut clocks = 0;
    for path in CIRCUITS {
        let circuit = circuit(path, &[("W", i64::from(bits))]);
        clocks += draw(&circuit, lines.clone()).unwrap_or_else(|fault| panic!("{path}: {fault}"));
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

#[test]
fn every_8_bit_line() {
    let lines = every(8).map(|(dx, dy)| {
        let mut rng = Rng::new(dx << 8 | dy);
        Line { dx, dy, xh: rng.below(256), yh: rng.below(256), bits: 8 }
    });
    let clocks = check_all(8, lines.clone());
    println!("{} lines of 8 bits, {clocks} clocks", lines.count());
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
        draw(&circuit, lines.iter().copied()).err()
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
