//! Part programs: read as LinuxCNC reads them, drawn within their bounds, and refused with their place.

use std::fmt::Write as _;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::support::program::{discreta, run as command};

use discreta::Timescale;
use discreta::machine::capture::{Block, Pulse, Wrong, align, count};
use discreta::machine::clockwork::Rule;
use discreta::machine::draw::{Choice, Drawer};
use discreta::machine::measure::Point;
use discreta::machine::plan::{Plan, Scale, Shape};
use discreta::machine::program::{self, Canon, Decimal, Faults, Move, Options};
use discreta::machine::{Drawn, Outcome, See, Settings, Survey};
use needs::needs;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        discreta::random::next(&mut self.0) % n
    }

    fn pick<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len() as u64) as usize]
    }

    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// A coordinate of up to 4 digits behind the point.
    fn number(&mut self, most: i64) -> String {
        let v = self.below(2 * most as u64 * 10_000) as i64 - most * 10_000;
        let digits = self.below(5) as usize;
        format!("{:.digits$}", v as f64 / 10_000.0)
    }
}

/// The canonical moves, as lines; a fault is one too.
fn canon(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut faults = Faults::default();
    program::read(text.as_bytes(), "t.nc", Options::default(), &mut faults, |_, canon| {
        lines.extend(canon.to_string().lines().map(str::to_owned));
        Ok(())
    })
    .unwrap();
    if faults.diagnostics.has_errors() {
        lines.push(faults.diagnostics.render(&faults.sources, false));
    }
    lines.retain(|l| compared(l));
    lines
}

/// What both readers print, but for F at 0, by which LinuxCNC clears it.
fn compared(line: &str) -> bool {
    let kinds = ["USE_LENGTH", "SELECT_PLANE", "SET_G5X", "SET_G92", "SET_FEED_RATE", "STRAIGHT", "ARC_FEED", "DWELL"];
    (kinds.iter().any(|k| line.starts_with(k)) || line.contains("error[")) && line != "SET_FEED_RATE(0.0000)"
}

/// The same by LinuxCNC's interpreter: nothing for a program that it refuses.
fn rs274(text: &str) -> Option<Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.nc"), text).unwrap();
    std::fs::write(folder.path().join("tool.tbl"), "T1 P1 D6\nT2 P2 D3\n").unwrap();
    // two at once now and then do not end: it has memory that all its instances share
    static ALONE: Mutex<()> = Mutex::new(());
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let output =
        Command::new("rs274").args(["-g", "-t", "tool.tbl", "t.nc"]).current_dir(folder.path()).output().unwrap();
    drop(alone);
    let out = String::from_utf8_lossy(&output.stdout).into_owned();
    // it goes on to its own end, whose lines are not the program's
    let all: Vec<String> = out
        .lines()
        .filter_map(|l| l.split_once(" N").and_then(|(_, rest)| rest.split_once(' ')).map(|(_, c)| c.trim().to_owned()))
        .collect();
    let begin = all.iter().position(|l| l.starts_with("ON_RESET")).map_or(0, |i| i + 1);
    let end = all.iter().rposition(|l| l.starts_with("SET_XY_ROTATION")).unwrap_or(all.len());
    let done = all.iter().any(|l| l.starts_with("PROGRAM_END"));
    // the end of a program sets its coordinate system again
    if !done {
        return None;
    }
    let mut lines: Vec<String> = all[begin..end].to_vec();
    if lines.last().is_some_and(|l| l.starts_with("SET_G5X_OFFSET")) {
        lines.pop();
    }
    lines.retain(|l| compared(l));
    Some(lines)
}

/// Numbers within 1e-4 (of the last place that is printed), all else letter by letter.
fn alike(a: &str, b: &str) -> bool {
    let parts = |s: &str| s.split([',', '(', ')']).map(|p| p.trim().to_owned()).collect::<Vec<_>>();
    let (a, b) = (parts(a), parts(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() < 1.5e-4,
            _ => a == b,
        })
}

fn same_as_rs274(text: &str) {
    let theirs = rs274(text).unwrap_or_else(|| panic!("rs274 refuses\n{text}"));
    let ours = canon(text);
    let first = ours.iter().zip(&theirs).position(|(a, b)| !alike(a, b));
    let first = first.or((ours.len() != theirs.len()).then(|| ours.len().min(theirs.len())));
    if let Some(i) = first {
        panic!("line {i}: {:?} and of rs274 {:?}\n{text}\n{ours:#?}\n{theirs:#?}", ours.get(i), theirs.get(i));
    }
}

/// Every word of the subset, in every mode that it depends on.
const CORPUS: &[&str] = &[
    include_str!("../../examples/part.nc"),
    "G21 G90\nG0 X1 Y2 Z3\nG1 F100 X4\nY5\nZ-6.5\nX0Y0Z0\nM2\n",
    "g 2 1 g 9 0\n g 0 x 1 . 5 y - 2\n(a comment) g1 f1 00 x+3. (another) y.5 ; and one more\n\nm 2\n",
    "N1 G20 G0 X1 Y1\nN2 G21 G0 X1\nN3 G20 G91 G0 X1\nN4 G21 G0 X1\nN5 G90 G20 G10 L2 P1 X1\nN6 G21 G0 X0\nN7 G92 X10\nN8 G20 G0 X0\nM30\n",
    "F100 G2 X10 Y0 I5\nG3 X0 Y0 I-5 J0\nG2 X0 Y10 R5\nG2 X10 Y0 R-12\nG3 X5 Y5 R20\nG2 I3\nG3 J-2 P3\nM2\n",
    "F100 G18\nG0 X5 Z2\nG2 X15 Z2 I5 K0\nG3 X5 Z2 R5.5 Y3\nG2 X5 Z2 I2 K1 Y5 P4\nG19 G2 Y15 Z2 J5\nG3 Y5 Z2 J-5 K0 X9 P2\nG3 Y6 Z4 R-3\nG17 G2 X9 Y8 R3\nM2\n",
    "F100 G90.1\nG2 X10 Y0 I5 J0\nG18 G3 X0 Z0 I5 K0\nG17 G91.1 G2 X10 Y0 I5 J0\nG91 G90.1 G3 X-10 Y0 I5 J0\nM2\n",
    "F100 G10 L2 P1 X10 Y-10\nG1 X1 Y1\nG55 X1\nG10 L2 P2 X3 Z1\nX1\nG10 L20 P2 X100 Z5\nX101\nG53 G0 X0 Z0\nG59.3 X1\nG10 L20 P0 Y7\nX0 Y0\nM2\n",
    "G92 X5 Y5\nG0 X6\nG92.2\nG0X1\nG92.3\nG0 X1\nG55 G0 X2\nG92.1\nG0X1\nG92Z5\nG0Z6\nG54 X0\nM2\n",
    "G0 X1 Y2 Z3\nG28 X5\nG28\nG0 X1 Y2 Z3\nG91 G30 Z1\nG90 G30 Y0\nM2\n",
    "F10\nG93 G1 X10 F.5\nG2 X20 I5 F2\nG0 X1\nG1 Z1 F60\nG94 F100 X0\nG4 P0.5\nG4 P2 G0 X3\nM2\n",
    "G64 P0.1 Q.1\nG61\nG61.1\nG43 H1\nG0 Z1\nG49 G40\nT1 M6\nS100 M3\nM8\nM9\nM5\nG80\nG0 X1\nM0\nM1\nM2\n",
    "G91 F50\nG1 X1.11111 Y-.33333\nX1.11111 Y-.33333\nX1.11111 Y-.33333\nG2 X1 Y1 R1\nX1 Y1 R-1\nX0 I1\nG90 X0 Y0 R9\nM2\n",
    "#1=3 #2=4 G0 X#1\nG0 X[#1+#2*2] Y-#1 Z[2**3**2]\n#<a b>=2\nG0 X#<ab> Y[5 MOD -3] Z[-5 MOD 3]\n\
     G0 X[1 EQ 1 AND 2 GT 3] Y[FIX[-2.5]] Z[ROUND[-2.5]]\nG0 X[ATAN[1]/[1]] Y[FUP[-2.5]] Z-SIN[30]\n\
     G0 X[ABS[-3]+SQRT[16]] Y[10/4] Z[7-2-1]\nG0 X[EXP[0]+LN[1]] Y[ACOS[0]+ASIN[1]] Z[COS[60]*TAN[45]]\n\
     #[1+1]=9 #3=##1\nG0 X#2 Y#3\n#1=#2\nX[#1 OR 0] Y[1 XOR 1] Z[3 NE 3]\nM2\n",
];

#[needs(rs274)]
#[test]
fn canonical_moves_are_those_of_linuxcnc() {
    for text in CORPUS {
        same_as_rs274(text);
    }
}

/// A program of the subset, right by construction.
fn random_program(random: &mut Random) -> String {
    let mut text = String::from("G21 F100\n");
    let (mut plane, mut incremental) = (0, false);
    for _ in 0..30 {
        let spaced = if random.chance(20) { " " } else { "" };
        let line = match random.below(16) {
            0 => random.pick(&["G20", "G21", "g20", "G 21"]).to_owned(),
            1 => {
                plane = random.below(3);
                format!("G{}", 17 + plane)
            }
            2 => {
                incremental = random.chance(50);
                format!("G9{}", u8::from(incremental))
            }
            3 => format!(
                "G10 L{} P{} X{} Y{}",
                random.pick(&["2", "20"]),
                random.below(4),
                random.number(9),
                random.number(9)
            ),
            4 => format!("G{}", 54 + random.below(6)),
            5 => format!("G92 X{} Z{}", random.number(9), random.number(9)),
            6 => random.pick(&["G92.1", "G92.2", "G92.3", "G28", "G30 Z1", "G28 X1 Y2"]).to_owned(),
            7 => format!("G4 P{}", random.below(3)),
            8 | 9 => format!("G0 X{spaced}{} Y{}", random.number(50), random.number(50)),
            10 => format!(
                "G1 X{} Y{}{spaced} Z{} F{}",
                random.number(50),
                random.number(50),
                random.number(9),
                1 + random.below(900)
            ),
            11 => format!("G93 G1 X{} F{}\nG94 F50", random.number(50), 1 + random.below(90)),
            // a full circle, or helical turns
            12 | 13 => {
                let [a, b] = [["I", "J"], ["I", "K"], ["J", "K"]][plane as usize];
                let up = ["Z", "Y", "X"][plane as usize];
                let rise = if random.chance(50) { format!(" {up}{}", random.number(9)) } else { String::new() };
                let turns = if random.chance(30) { format!(" P{}", 1 + random.below(4)) } else { String::new() };
                let r = random.number(20);
                if r.parse::<f64>() == Ok(0.0) {
                    continue;
                }
                format!("G{} {a}{r} {b}{}{rise}{turns}", random.pick(&["2", "3"]), random.number(20))
            }
            // from wherever it is to a point near it, by a radius that reaches
            _ => {
                let [a, b] = [["X", "Y"], ["X", "Z"], ["Y", "Z"]][plane as usize];
                let [u, v] = [random.number(5), random.number(5)];
                if u.parse::<f64>() == Ok(0.0) && v.parse::<f64>() == Ok(0.0) {
                    continue;
                }
                let (before, after) = if incremental { ("", "") } else { ("G91 ", "\nG90") };
                let sign = random.pick(&["", "-"]);
                format!("{before}G{} {a}{u} {b}{v} R{sign}{}{after}", random.pick(&["2", "3"]), 8 + random.below(30))
            }
        };
        let _ = writeln!(text, "{line}");
    }
    text + "M2\n"
}

#[needs(rs274)]
#[test]
fn random_programs_are_read_as_linuxcnc_reads_them() {
    for seed in 0..150 {
        same_as_rs274(&random_program(&mut Random(seed)));
    }
}

/// What is refused by both.
#[needs(rs274)]
#[test]
fn linuxcnc_refuses_the_same() {
    for text in [
        "X1",
        "G1 X1",
        "G80 X1",
        "G4",
        "G1 X1 F0",
        "G0 G1 X1 F10",
        "F1 G2 X1 Y1",
        "F1 G2 X1 I.5 P1.5",
        "F1 G2 X1 I.5 P0",
        "F1 G2 X1 I.5 K1",
        "F1 G2 X1 I1",
        "F1 G2 X1 I.7",
        "F1 G2 X1 Y1 R.7",
        "F1 G2 I0",
        "F1 G2 R5",
        "F1 G2 X10 I5 R5",
        "F1 G90.1 G2 X10 I5",
        "G93 G1 X1 F2\nX2",
        "G1 F10 X1 P2",
        "G91 G53 G0 X1",
        "G53 X1",
        "G10 L2 P10 X1",
        "G10 L2 X1",
        "G0 X1 X2",
        "G0 X1 (open",
        "G0 X1 (a (b) c)",
        "G0 X1..5",
        "G0 X",
        "G0 X[1",
        "G0 X[1/0]",
        "G0 X#<no>",
        "G10 L3 P1 X1",
        "G28 G92 X1",
        "F10 G1 X1 Q2",
        "G0 X1 ?",
        "F-5",
        "G92",
        "G4 P-1",
    ] {
        assert_eq!(rs274(&format!("{text}\nM2\n")), None, "{text}");
        let ours = canon(&format!("{text}\nM2\n"));
        assert!(ours.last().is_some_and(|l| l.contains("error[")), "{text}: {ours:?}");
    }
}

fn settings(blu: &str) -> Settings {
    Settings {
        scale: Scale::Blu(blu.parse().unwrap()),
        tick: "1us".parse::<Timescale>().unwrap(),
        rapid: Decimal::whole(5000),
        bits: None,
        choices: Choice::ALL.to_vec(),
        rules: Rule::ALL.to_vec(),
        program: Options::default(),
    }
}

fn survey(text: &str, settings: &Settings) -> Survey {
    let mut faults = Faults::default();
    let survey = discreta::machine::survey(text.as_bytes(), "t.nc", settings, &mut faults, |_| false).unwrap();
    assert!(!faults.diagnostics.has_errors(), "{}\n{text}", faults.diagnostics.render(&faults.sources, false));
    survey
}

fn run(text: &str, settings: &Settings, see: &mut impl See) -> Vec<Outcome> {
    let survey = survey(text, settings);
    let mut faults = Faults::default();
    let outcomes =
        discreta::machine::run(text.as_bytes(), "t.nc", settings, &survey, &mut faults, see, |_| false).unwrap();
    assert!(!faults.diagnostics.has_errors(), "{}\n{text}", faults.diagnostics.render(&faults.sources, false));
    outcomes
}

/// Holds every block to its bounds.
#[derive(Default)]
struct Bounds {
    at: [[i64; 3]; 4],
    blocks: u64,
    worst_line: f64,
    worst_arc: [f64; 4],
    worst_time: f64,
    constant: [f64; 2],
}

impl See for Bounds {
    fn clock(&mut self, index: usize, point: &Point) {
        self.at[index] = point.at;
    }

    fn block(&mut self, drawn: &Drawn<'_>) -> std::io::Result<()> {
        let (plan, measured) = (drawn.plan, drawn.measured);
        self.blocks += 1;
        // 2: the block ends where its target is rounded to
        assert_eq!(self.at[drawn.index], plan.to, "line {} by {}", drawn.line.number, drawn.choice);
        // 5: L/V to a tick
        let block = drawn.measured.times[2];
        let asked = plan.length / (plan.speed(5000.0) * 1e-6);
        let apart = (block.ticks as f64 - asked).abs();
        self.worst_time = self.worst_time.max(apart);
        let flat = plan.to[2] == plan.from[2];
        match plan.shape {
            Shape::Line if flat && !plan.flattened => self.worst_line = self.worst_line.max(measured.total),
            Shape::Arc(arc) if plan.from[arc.axes[2]] == plan.to[arc.axes[2]] => {
                let worst = &mut self.worst_arc[drawn.index];
                *worst = worst.max(measured.total);
            }
            _ => {}
        }
        if drawn.index == 1 && plan.shape == Shape::Line && measured.clocks > 200 {
            let mean = measured.times[1].speed[1];
            self.constant = [self.constant[0].min(mean), self.constant[1].max(mean)];
        }
        Ok(())
    }
}

/// Lines and arcs of all lengths and directions, with ends and centres off the grid.
fn random_curves(random: &mut Random, blocks: u32, plane: bool) -> String {
    let mut text = String::from("F600 G91\n");
    for _ in 0..blocks {
        let most = 1 + random.below(12) as i64;
        let [x, y, z] = [0; 3].map(|_| random.number(most).parse::<f64>().unwrap());
        let length = x.hypot(y);
        let line = match random.below(4) {
            0 if plane => format!("G1 X{x} Y{y}"),
            0 => format!("G1 X{x} Y{y} Z{z}"),
            1 => format!("G1 X{x}"),
            // radii of 1.5 BLU and more
            2 if length > 0.15 => {
                let r = length / 2.0 * (1.0 + random.below(400) as f64 / 100.0) + 0.15;
                format!("G{} X{x} Y{y} R{}{r:.4}", 2 + random.below(2), random.pick(&["", "-"]))
            }
            3 if length > 0.15 => format!("G{} I{x} J{y}", 2 + random.below(2)),
            _ => continue,
        };
        let _ = writeln!(text, "{line}");
    }
    text
}

#[test]
fn every_block_keeps_its_bounds() {
    let mut bounds = Bounds { constant: [9.0, 0.0], ..Bounds::default() };
    let half = 0.5_f64.sqrt();
    for seed in 0..12 {
        let mut random = Random(seed);
        let text = random_curves(&mut random, 60, seed % 3 != 0);
        run(&text, &settings(["0.01", "0.0254", "0.1", "0.005"][seed as usize % 4]), &mut bounds);
    }
    println!(
        "{} blocks; lines {:.4}, arcs {:.4?}, block feed {:.2} ticks, constant {:.3?}",
        bounds.blocks, bounds.worst_line, bounds.worst_arc, bounds.worst_time, bounds.constant
    );
    assert!(bounds.blocks > 1500);
    assert!(bounds.worst_line <= 1.0 + half, "{}", bounds.worst_line);
    for (worst, bound) in bounds.worst_arc.into_iter().zip([1.0 + half, 1.0 + half, 2_f64.sqrt() + half]) {
        assert!(worst <= bound && worst > 1.0, "{worst} above {bound}");
    }
    // a tick, and what sums of floating-point numbers are off by
    assert!(bounds.worst_time <= 1.0 + 1e-6, "{}", bounds.worst_time);
    assert!(bounds.constant[0] >= 0.86 && bounds.constant[1] <= 1.03, "{:?}", bounds.constant);
}

fn moves(text: &str) -> Vec<Move> {
    let mut moves = Vec::new();
    let mut faults = Faults::default();
    program::read(text.as_bytes(), "t.nc", Options::default(), &mut faults, |_, canon| {
        if let Canon::Move(step) = canon {
            moves.push(*step);
        }
        Ok(())
    })
    .unwrap();
    assert!(!faults.diagnostics.has_errors());
    moves
}

/// The greatest distance of an arc's points from its own circle, drawn by an evaluation function.
fn drawn(plan: &Plan, center: [f64; 2], radius: f64) -> f64 {
    let mut at = plan.from;
    let mut worst = 0.0_f64;
    let mut drawer = Drawer::new(plan, Choice::ALL[0], 20).unwrap();
    while let Some(tick) = drawer.tick() {
        (0..3).for_each(|a| at[a] += i64::from(tick.step[a]));
        worst = worst.max(((at[0] as f64 - center[0]).hypot(at[1] as f64 - center[1]) - radius).abs());
    }
    worst
}

/// Without F₀ the path is a circle through the rounded start point, which is off by more.
#[test]
fn an_arc_without_its_f0_leaves_the_bound() {
    let scale = Scale::Blu("0.01".parse().unwrap());
    let (mut with, mut without) = (0.0_f64, 0.0_f64);
    let mut random = Random(1);
    for _ in 0..2000 {
        let [x, y, i, j] = [1, 1, 2, 2].map(|most| random.number(most).parse::<f64>().unwrap() / 10.0);
        let radius = i.hypot(j) * 100.0;
        if radius < 1.5 {
            continue;
        }
        let step = moves(&format!("F9 G0 X{x:.6} Y{y:.6}\nG3 I{i:.6} J{j:.6}\n"))[1];
        let plan = Plan::new(&step, &scale, 0..1).unwrap();
        let Shape::Arc(arc) = plan.shape else { panic!("no arc") };
        let center = [(x + i) * 100.0, (y + j) * 100.0];
        with = with.max(drawn(&plan, center, radius));
        let mutant = Plan { shape: Shape::Arc(discreta::machine::plan::PlanArc { f0: 0, ..arc }), ..plan };
        without = without.max(drawn(&mutant, center, radius));
    }
    println!("with F₀ {with:.4}, without {without:.4}");
    assert!(with <= 1.0 + 0.5_f64.sqrt() && without > 1.0 + 0.5_f64.sqrt());
}

/// The steps of one move, and the turns that they make around a centre.
fn turns(text: &str, blu: &str, choice: Choice) -> Option<f64> {
    let step = *moves(text).last().unwrap();
    let plan = Plan::new(&step, &Scale::Blu(blu.parse().unwrap()), 0..1).unwrap();
    let Shape::Arc(arc) = plan.shape else { return None };
    let mut at = plan.from;
    let away = |at: [i64; 3]| [at[0] as f64 - arc.center[0] as f64, at[1] as f64 - arc.center[1] as f64];
    let mut angle = 0.0;
    let mut drawer = Drawer::new(&plan, choice, 30).unwrap();
    while let Some(tick) = drawer.tick() {
        let a = away(at);
        (0..3).for_each(|i| at[i] += i64::from(tick.step[i]));
        let b = away(at);
        angle += (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
    }
    assert_eq!(at, plan.to);
    Some(angle / std::f64::consts::TAU)
}

#[test]
fn a_full_circle_is_drawn_exactly_where_the_program_has_one() {
    for choice in Choice::ALL {
        for blu in ["0.001", "0.01", "0.1", "0.25"] {
            let turns = |text: &str| turns(text, blu, choice);
            let near = |t: Option<f64>, n: f64| t.is_some_and(|t| (t - n).abs() < 0.13);
            assert!(near(turns("F9 G0 X.003 Y.002\nG3 I2.017 J-.004"), 1.0), "{blu}");
            assert!(near(turns("F9 G0 X.003 Y.002\nG2 X.003 Y.002 I2.017"), -1.0));
            assert!(near(turns("F9 G2 I-2 J1 P3"), -3.0));
            // a thousandth of a turn short of a full one: the rounded ends are one point, and it is still nearly a turn
            assert!(near(turns("F9 G0 X2 Y0\nG3 X1.99999 Y-.00628 I-2 J0"), 1.0), "{choice} {blu}");
            assert!(near(turns("F9 G0 X2 Y0\nG2 X1.99999 Y.00628 I-2 J0"), -1.0), "{choice} {blu}");
            // and a thousandth of a turn is a line, or nothing
            assert_eq!(turns("F9 G0 X2 Y0\nG3 X1.99999 Y.00628 I-2 J0"), None);
            assert_eq!(turns("F9 G0 X2 Y0\nG2 X1.99999 Y-.00628 I-2 J0"), None);
            // short arcs of a large radius never become circles
            assert_eq!(turns("F9 G2 X.03 Y.02 R4000"), None);
        }
        // a radius of 40 m, an arc of 20 mm: 1.25 µm of sagitta are drawn as an arc with fine steps
        let fine = turns("F9 G3 X20 Y0 R40000", "0.0001", choice).unwrap();
        assert!((fine - 20.0 / (std::f64::consts::TAU * 40_000.0)).abs() < 1e-8, "{fine}");
    }
}

/// Increments of a third of a BLU add up to what they are, not to what each is rounded to.
#[test]
fn targets_are_rounded_not_increments() {
    let text = format!("G91 F100\n{}", "G1 X0.00333333 Y-0.004\n".repeat(3000));
    let outcomes = run(&text, &settings("0.01"), &mut Bounds::default());
    for outcome in outcomes {
        assert_eq!(outcome.run.at(), [1000, -1200, 0]);
        assert_eq!(outcome.run.steps, [1000, 1200, 0]);
    }
}

/// The rows of the table of errors in docs/machine.md, and more: code, line, column and a part of the message.
#[test]
fn faults_have_their_place() {
    let rows = [
        ("G1 X1", "bad-block", "1:1", "G1 without a feed"),
        ("X1 Y2", "bad-block", "1:1", "nothing says how to move there"),
        ("G93 G1 X1 F2\nG1 X2", "bad-block", "2:1", "a move in inverse time (G93) without F"),
        ("G0 X1\nG1 X2 F-5", "bad-block", "2:7", "a feed of -5"),
        ("G0 X1 Y2 X3", "bad-block", "1:10", "a second X in one block"),
        ("G0 G1 X1", "bad-block", "1:4", "G0 and G1 in one block"),
        ("F9 G2 X1 Y1", "bad-arc", "1:4", "an arc without centre or radius"),
        ("F9 G2 X1 Y1 R2 I1", "bad-arc", "1:13", "an arc with both a centre and a radius"),
        ("F9 G2 X10 R4", "bad-arc", "1:11", "a radius of 4 mm does not reach the end point"),
        ("F9 G2 R5", "bad-arc", "1:7", "an arc with a radius that ends where it begins"),
        ("F9 G2 X1 Y0 R0", "bad-arc", "1:13", "an arc of radius 0"),
        ("F9 G2 X1 I0", "bad-arc", "1:4", "the centre of this arc is its start point"),
        ("F9 G2 X1 I1", "bad-arc", "1:4", "the centre of this arc is its end point"),
        ("F9 G2 X10 I4", "bad-arc", "1:4", "the radius is 4.0000 mm at the start of this arc and 6.0000 mm at its end"),
        ("F9 G2 X1 I.5 K1", "bad-arc", "1:14", "K in an arc of the plane XY (G17)"),
        ("F9 G2 I2 P0", "bad-arc", "1:10", "an arc of 0 turns"),
        ("G0 X1 (not closed", "bad-word", "1:7", "this comment is not closed"),
        ("G0 X1e3", "bad-word", "1:6", "a number with an exponent"),
        ("G0 X1.2.3", "bad-word", "1:8", "a second point in a number"),
        ("G0 X Y1", "bad-word", "1:6", "a number is missing"),
        ("G0 A90", "bad-word", "1:4", "this machine has no axis A"),
        ("G0 W1", "bad-word", "1:4", "this machine has no axis W"),
        ("G1 X1 E0.2", "bad-word", "1:7", "E (an extruder, or an exponent) is not read"),
        ("O100 sub", "bad-word", "1:1", "O-words (subroutines, loops) are not read"),
        ("G81 X1 Z-1 R1", "bad-word", "1:1", "G81 is not read here"),
        ("G33 Z1 K1", "bad-word", "1:1", "G33 is not read here"),
        ("G38.2 Z1", "bad-word", "1:1", "G38.2 is not read here"),
        ("G41 D1", "bad-word", "1:1", "G41 is not read here"),
        ("G7.5", "bad-word", "1:1", "G7.5 is not read here"),
        ("M98 P1", "bad-word", "1:1", "M98 is not read here"),
        ("G0 X1 $5", "bad-word", "1:7", "`$` begins no word"),
        ("(ok)\nG0 é1", "bad-word", "2:4", "`é` begins no word"),
        ("G0 X1 %", "bad-word", "1:7", "`%` stands alone on its line"),
        ("G0 X12345678901", "bad-word", "1:5", "a number of 11 digits is more than this machine reads"),
        ("G0 X0.1234567890123456", "bad-word", "1:5", "a number of 17 digits"),
        ("G0 X1111111111222222222233333333334444444444", "bad-word", "1:5", "a number of 40 digits"),
        ("G0 X[1/0]", "bad-word", "1:6", "this cannot be computed"),
        ("G0 X#<none>", "bad-word", "1:5", "this parameter has no value yet"),
        ("G0 X#5220", "bad-word", "1:6", "there is no parameter 5220"),
        ("G0 X[SIN 30]", "bad-word", "1:10", "the argument of a function stands in brackets"),
        ("G1 X1 P2 F9", "bad-block", "1:7", "nothing in this block uses P"),
        ("G53 X1", "bad-block", "1:5", "nothing says how to move there"),
        ("G80 X1", "bad-block", "1:5", "G80 ends the motion mode"),
        ("G4", "bad-block", "1:1", "G4 without its time"),
        ("G10 L1 P1", "bad-block", "1:5", "G10 is read with L2 or L20"),
        ("G28 G1 X1 F1", "bad-block", "1:5", "X, Y and Z are for G28 or for G1"),
        ("G0 X999999999\nG0 X-999999999", "bad-move", "1:1", "this move needs registers of 37 bits"),
    ];
    for (text, code, place, message) in rows {
        let mut faults = Faults::default();
        let all = settings("0.01");
        discreta::machine::survey(text.as_bytes(), "t.nc", &all, &mut faults, |_| false).unwrap();
        let told = faults.diagnostics.render(&faults.sources, false);
        let begin = format!("error[{code}]: {message}");
        assert!(told.starts_with(&begin), "{text:?}: {told}");
        assert!(told.contains(&format!(" t.nc:{place}\n")), "{text:?} at {place}: {told}");
        assert!(told.contains("help: "), "{told}");
    }
}

/// Whatever is cut or changed, there is an end, an answer, and no panic.
#[test]
fn cut_and_mutated_programs_are_read_or_refused() {
    let whole = include_bytes!("../../examples/part.nc");
    let mut random = Random(7);
    let read = |text: &[u8]| {
        let mut faults = Faults::default();
        let mut moves = 0;
        let summary = program::read(text, "t.nc", Options::default(), &mut faults, |_, c| {
            moves += u32::from(matches!(c, Canon::Move(_)));
            Ok(())
        })
        .unwrap();
        let _ = faults.diagnostics.render(&faults.sources, false);
        (summary.lines, moves, faults.diagnostics.errors())
    };
    let (lines, all, errors) = read(whole);
    assert_eq!((lines, errors), (whole.iter().filter(|&&b| b == b'\n').count() as u64, 0));
    for cut in 0..whole.len() {
        let (cut_lines, moves, errors) = read(&whole[..cut]);
        // the lines before the cut are all there
        assert!(moves <= all && (errors <= 1) && cut_lines as usize >= whole[..cut].split(|&b| b == b'\n').count() - 1);
    }
    for _ in 0..3000 {
        let mut text = whole.to_vec();
        for _ in 0..=random.below(4) {
            let at = random.below(text.len() as u64) as usize;
            match random.below(3) {
                0 => text[at] = random.below(256) as u8,
                1 => drop(text.remove(at)),
                _ => text.insert(
                    at,
                    *random.pick(&["G", "#", "[", "(", "X", "9", "-", "\n", "%"]).as_bytes().first().unwrap(),
                ),
            }
        }
        read(&text);
    }
}

/// The pulses of the first method, and the blocks that they are of.
#[derive(Default)]
struct Pulses {
    all: Vec<Pulse>,
    /// The block of each pulse.
    of: Vec<usize>,
    blocks: Vec<Block>,
    last: [i8; 3],
}

impl See for Pulses {
    fn begin(&mut self, plan: &Plan, line: program::Line<'_>) {
        self.blocks.push(Block { plan: *plan, line: line.number, column: 1, text: "".into() });
    }

    fn clock(&mut self, index: usize, point: &Point) {
        for axis in 0..3 {
            let step = point.step[axis];
            if index == 0 && step != 0 {
                let turned = (self.last[axis] == -step).then_some(5);
                self.last[axis] = step;
                self.all.push(Pulse { time: point.time[0], axis: axis as u8, step, turned });
                self.of.push(self.blocks.len() - 1);
            }
        }
    }
}

fn pulses(text: &str, choice: Choice, rule: Rule) -> (Pulses, Outcome) {
    let mut see = Pulses::default();
    let settings = Settings { choices: vec![choice], rules: vec![rule], ..settings("0.01") };
    let outcome = run(text, &settings, &mut see).remove(0);
    (see, outcome)
}

#[test]
fn its_own_pulses_measure_the_same() {
    let part = include_str!("../../examples/part.nc");
    let random = random_curves(&mut Random(5), 80, false);
    for text in [part, random.as_str()] {
        for choice in Choice::ALL {
            for rule in Rule::ALL {
                let (see, outcome) = pulses(text, choice, rule);
                let aligned = align(&see.all, &see.blocks);
                assert_eq!(aligned.faults, [], "{choice} {rule}");
                let counted = count(&see.all);
                assert_eq!((counted.pulses, counted.end), (outcome.run.steps, outcome.run.at()));
                assert_eq!(counted.gap.unwrap().0, outcome.run.times[0].gap);
                for (i, seen) in aligned.blocks.iter().enumerate() {
                    assert_eq!(seen.pulses, see.of.iter().filter(|&&b| b == i).count() as u64, "block {i} by {choice}");
                }
            }
        }
    }
}

/// One step removed, one doubled, one in the wrong direction: what it was, of which axis, in which block, and when.
#[test]
fn a_step_lost_doubled_or_turned_is_named_with_its_place() {
    let part = include_str!("../../examples/part.nc");
    let mut random = Random(3);
    let (mut all, mut near, mut named) = ([0; 3], [0; 3], [0; 3]);
    for (choice, rule) in [(Choice::ALL[1], Rule::Block), (Choice::ALL[0], Rule::Step), (Choice::ALL[3], Rule::Block)] {
        let (see, _) = pulses(part, choice, rule);
        for n in 0..90 {
            let mut changed = see.all.clone();
            let at = 1 + random.below(see.all.len() as u64 - 40) as usize;
            let pulse = changed[at];
            let kind = n % 3;
            match kind {
                0 => drop(changed.remove(at)),
                1 => {
                    let time = pulse.time + 3;
                    changed.push(Pulse { time, ..pulse });
                    changed.sort_by_key(|p| (p.time, p.axis));
                }
                _ => changed[at].step = -pulse.step,
            }
            let aligned = align(&changed, &see.blocks);
            let first = *aligned.faults.first().expect("nothing is named");
            assert_eq!(
                first.axis,
                Some(pulse.axis),
                "{kind} at {} of block {}: {:?}",
                pulse.time,
                see.of[at],
                aligned.faults
            );
            all[kind] += 1;
            let right = match kind {
                0 => first.wrong == Wrong::Missing(1),
                1 => first.wrong == Wrong::Extra(1),
                _ => first.wrong == Wrong::Direction,
            };
            named[kind] += u32::from(right);
            near[kind] += u32::from(first.block == see.of[at]);
        }
    }
    println!("of {all:?}: kind {named:?}, block {near:?}");
    for kind in 0..3 {
        assert!(named[kind] * 100 >= all[kind] * 90, "{named:?} of {all:?}");
        assert!(near[kind] * 100 >= all[kind] * 75, "{near:?} of {all:?}");
    }
}

#[test]
fn another_path_is_told_apart() {
    let text = "F600\nG1 X2 Y1\nG2 X4 Y1 I1\nG1 X4 Y3\n";
    let (see, _) = pulses(text, Choice::ALL[1], Rule::Block);
    let wrong = |pulses: &[Pulse]| align(pulses, &see.blocks).faults.first().map(|f| (f.wrong, f.block));
    assert_eq!(wrong(&see.all), None);
    assert_eq!(wrong(&[]), Some((Wrong::Short, 0)));
    assert_eq!(wrong(&see.all[..250]), Some((Wrong::Short, see.of[250])));
    let twice: Vec<Pulse> = see.all.iter().chain(&see.all).copied().collect();
    assert_eq!(wrong(&twice), Some((Wrong::Long, 2)));
    let mirrored: Vec<Pulse> =
        see.all.iter().map(|p| Pulse { step: if p.axis == 1 { -p.step } else { p.step }, ..*p }).collect();
    assert_eq!(wrong(&mirrored).map(|w| w.0), Some(Wrong::Elsewhere));
    // the step that is missing at the very end
    let axis = see.all.last().unwrap().axis;
    let short = &see.all[..see.all.len() - 1];
    let faults = align(short, &see.blocks).faults;
    assert_eq!((faults.len(), faults[0].wrong, faults[0].axis), (1, Wrong::Missing(1), Some(axis)));
}

/// A file in a folder of its own, and what the command line says of it: exit status, standard output and error.
fn told(program: &[u8], options: &[&str]) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.nc");
    std::fs::write(&path, program).unwrap();
    let all = [&["machine", path.to_str().unwrap()], options].concat();
    let told = command(&all);
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(told.0 == 0 || names == ["t.nc"], "half written: {names:?}");
    told
}

#[track_caller]
fn refused(program: &[u8], options: &[&str], part: &str) {
    let (status, stdout, stderr) = told(program, options);
    // JSON is of every outcome
    let json: Option<serde_json::Value> = serde_json::from_str(&stdout).ok();
    assert!(status == 2 && (stdout.is_empty() || json.is_some_and(|json| json["ok"] == false)), "{stdout}{stderr}");
    assert!(stderr.contains(part), "{options:?} does not say {part:?} but\n{stderr}");
}

#[test]
fn bad_input_has_its_place_and_leaves_nothing() {
    refused(b"G0 X1\n\0\x01", &[], "t.nc:2:1");
    refused(b"\x7fELF\x02\x01", &["--format", "csv"], "a control character, 0x7f: this is no part program");
    refused(&[b"G1 X1 F9\n".as_slice(), &vec![b'X'; 3_000_000]].concat(), &[], "a line of more than 65536 bytes");
    refused(b"", &[], "moves nothing");
    refused(b"(only words)\nM3 S100\n", &[], "moves nothing");
    refused(b"G0 X1\nG1 X2\n", &["--format", "json"], "t.nc:2:1");
    refused(b"G0 X100\n", &["--bits", "8"], "this move needs registers of 14 bits: 8 hold at most 255");
    // 2 ticks of 1 us a step of 0.01 mm; by DDA 2^14 clocks of 2 ticks for the 10,000 steps: 100 mm in 32.768 ms
    let rapid = "G0 X100\nG0 Y1".as_bytes();
    refused(rapid, &["--method", "ef-line", "--rapid", "900000"], "greatest here: 300000.000 mm/min");
    refused(rapid, &["--rapid", "900000"], "greatest here: 183105.468 mm/min");
    refused(b"G1 X100 F0.0000001\n", &[], "too slow for this clock");
    refused(
        b"G3 I5 F9\n",
        &["--steps-per-mm", "10,20,10"],
        "an arc in a plane whose axes have steps of different sizes",
    );
    refused(b"G0 X1\n", &["--blu", "0"], "it has to be above 0");
    refused(b"G0 X1\n", &["--blu", "1e-3"], "a number with an exponent");
    refused(b"G0 X1\n", &["--blu", "0.1", "--steps-per-mm", "10"], "cannot be used with");
    refused(b"G0 X1\n", &["--format", "canon", "--method", "ef-line"], "--method has no meaning");
    refused(b"G0 X1\n", &["--method", "ef-line,dda-line"], "ef-line and dda-line are both of one kind");
    refused(b"G0 X1\n", &["--method", "dda-curve"], "draws what no part program has");
    refused(b"G0 X1\n", &["--method", "ef-line", "--method", "ef-line,ef-circle"], "is given twice");
    refused(b"G0 X1\n", &["--feed", "fast"], "there is step, constant, block");
    refused(b"G0 X1\n", &["-o", "t.txt"], "neither .vcd nor .fst");
    refused(b"G0 X1\n", &["--x", "a,b"], "--waveform");
    let (status, _, stderr) = command(&["machine", "no-such.nc"]);
    assert!(status == 2 && stderr.contains("cannot read `no-such.nc`"), "{stderr}");
    // the greatest feed is one that can be
    assert_eq!(told(rapid, &["--method", "ef-line", "--feed", "step", "--rapid", "300000"]).0, 0);
    assert_eq!(told(rapid, &["--rapid", "183105.468"]).0, 0);
}

#[test]
fn every_format_tells_the_same() {
    let part = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/part.nc");
    let (status, table, _) = command(&["machine", part]);
    assert_eq!(status, 0);
    let (_, json, _) = command(&["machine", part, "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let (_, csv, _) = command(&["machine", part, "--format", "csv"]);
    for method in json["methods"].as_array().unwrap() {
        let name = format!("{},{}", method["line"].as_str().unwrap(), method["arc"].as_str().unwrap());
        let row = table.lines().find(|l| l.starts_with(&name)).unwrap();
        let clocks = row.split_whitespace().nth(1).unwrap().replace(',', "");
        assert_eq!(clocks, method["clocks"].to_string());
        // 13 columns before the clocks, the method's own comma among them
        let sum: u64 = csv
            .lines()
            .filter(|l| l.contains(&format!("\"{name}\"")) && l.contains(",block,"))
            .map(|l| l.split(',').nth(13).unwrap().parse::<u64>().unwrap())
            .sum();
        assert_eq!(sum.to_string(), clocks, "{name}");
        assert_eq!(method["end"], serde_json::json!([0, 0, 0]));
    }
    let (_, canon, _) = command(&["machine", part, "--format", "canon"]);
    assert!(
        canon.contains("    27 ARC_FEED(40.0000, 20.0000, 38.0000, 20.0000, 2, -3.0000, 0.0000, 0.0000, 0.0000)\n")
    );
    let mut piped = discreta(&["machine", "-", "--format", "canon"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::io::Write::write_all(&mut piped.stdin.take().unwrap(), include_bytes!("../../examples/part.nc")).unwrap();
    assert_eq!(String::from_utf8(piped.wait_with_output().unwrap().stdout).unwrap(), canon);
}

/// What `-o` writes is what `--waveform` measures; a step that is taken out of it is missed.
#[test]
fn a_waveform_of_its_own_is_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("t.nc"), "G1 X1 Y0.5 F600\nG2 X2 Y0.5 I0.5 J0\nG1 X0 Y0 Z0.2\n").unwrap();
    let draw = ["--method", "ef-line-fast,ef-circle-fast", "--feed", "block"];
    let (program, vcd, svg) = (path("t.nc"), path("t.vcd"), path("t.svg"));
    let (status, ..) = command(&[&["machine", &program, "-o", &vcd, "--plot", &svg], &draw[..]].concat());
    assert_eq!(status, 0);
    assert!(std::fs::read_to_string(svg).unwrap().ends_with("</svg>\n"));
    let (status, text, _) = command(&["machine", &program, "--waveform", &vcd]);
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("3 of 3 moves found") && text.contains("every step is there, none is too many"), "{text}");
    // y's rising edges 20 to 22: the second one is taken out
    let wave = std::fs::read_to_string(&vcd).unwrap();
    let id = wave.lines().find(|l| l.ends_with(" y_step $end")).unwrap().split_whitespace().nth(3).unwrap();
    let edge = format!("1{id}");
    let mut n = 0;
    let cut: Vec<&str> = wave
        .lines()
        .filter(|l| {
            n += u32::from(*l == edge);
            *l != edge || n != 21
        })
        .collect();
    std::fs::write(path("cut.vcd"), cut.join("\n") + "\n").unwrap();
    let (status, json, _) = command(&["machine", &program, "--waveform", &path("cut.vcd"), "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((status, json["faults"].as_array().unwrap().len()), (1, 1), "{json}");
    let fault = &json["faults"][0];
    assert_eq!((&fault["kind"], &fault["axis"], &fault["line"]), (&"missing".into(), &"y".into(), &1.into()), "{json}");
    // without a program it is counted; a net that is not there is named
    let (status, text, _) = command(&["machine", "--waveform", &vcd]);
    assert!(status == 0 && text.contains("it ends 0, 0, 20 BLU from its start"), "{text}");
    let (status, _, text) = command(&["machine", "--waveform", &vcd, "--x", "STEP_X,DIR_X"]);
    assert!(status == 2 && text.contains("has no net `STEP_X`"), "{text}");
}

/// By hand: 2 ticks of 10 ns high, and (2 + 3)·20 ns to fill a store again, are 12 ticks.
#[test]
fn the_greatest_feed_of_the_system() {
    let (status, text, _) = command(&["feed", "--blu", "0.01"]);
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("12 ticks, 120 ns\ngreatest feed: 8333333.333 BLU/s, 5000000.000 mm/min\n"), "{text}");
    let (status, text, _) = command(&["feed", "--tau", "8"]);
    assert!(status == 1 && text.contains("a delay of 8 is not above the step pulse, 10"), "{text}");
    let (status, _, text) = command(&["feed", "--step-high", "20"]);
    assert!(status == 2 && text.contains("--step-high has to be below --step"), "{text}");
}
