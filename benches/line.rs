//! Clocks and events a second of the event engine on both forms of the line interpolator, beside Icarus Verilog on the
//! same circuits (`benches/verilog`), in turns, with the same work and the checksums of all that happened compared.
//!
//!     cargo bench --bench line
//!
//! The work is that of `benches/verilog/bench.v`: random lines back to back.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use discreta::Simulator;
use discreta::circuit::{self, Circuit};

/// Runs of which the median is taken.
const RUNS: usize = 7;
/// How long Icarus shall run at least, so that its start does not count, and how long this simulator, which repeats the
/// same work until then.
const LEAST: Duration = Duration::from_millis(1300);
const LEAST_OWN: Duration = Duration::from_millis(300);

struct Form {
    name: &'static str,
    file: &'static str,
    module: &'static str,
}

const FORMS: [Form; 2] = [
    Form { name: "registers", file: "circuits/evaluation/line.json", module: "line_rtl" },
    Form { name: "gates", file: "circuits/evaluation/line_gates.json", module: "line_gates" },
];

/// What is compared.
#[derive(PartialEq, Eq, Debug)]
struct Outcome {
    clocks: u64,
    lines: u64,
    sum: u32,
    xt: u64,
    yt: u64,
}

/// As `bench.v` does it. Also returns how many net changes there were.
fn discreta(circuit: &Circuit, clocks: u64) -> (Outcome, u64) {
    let mut sim = Simulator::new(&circuit.netlist);
    let [start, dt, dx, dy, xh, yh] = ["start", "dt", "dx", "dy", "xh", "yh"].map(|n| sim.input(n).unwrap());
    let [x, y, end, xt, yt] = ["x", "y", "end", "xt", "yt"].map(|n| sim.probe(n).unwrap());
    for input in [start, dt, dx, dy, xh, yh] {
        sim.set(input, 0);
    }
    sim.settle().unwrap();
    let (mut seed, mut sum, mut lines) = (1u32, 0u32, 0);
    for _ in 0..clocks {
        if sim.number(&end) != Some(0) {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sim.set(dx, u64::from(seed >> 24));
            sim.set(dy, u64::from(seed >> 16 & 0xff));
            if lines != 0 {
                sim.set(xh, sim.number(&xt).unwrap());
                sim.set(yh, sim.number(&yt).unwrap());
            }
            lines += 1;
            sim.set(start, 1);
            sim.settle().unwrap();
            sim.set(start, 0);
            sim.settle().unwrap();
            let at = sim.number(&xt).unwrap() << 8 | sim.number(&yt).unwrap();
            sum = sum.rotate_left(1) ^ at as u32;
        }
        sim.set(dt, 1);
        sim.settle().unwrap();
        let step = sim.number(&x).unwrap() << 1 | sim.number(&y).unwrap();
        sum = sum.rotate_left(1) ^ step as u32;
        sim.set(dt, 0);
        sim.settle().unwrap();
    }
    let outcome = Outcome { clocks, lines, sum, xt: sim.number(&xt).unwrap(), yt: sim.number(&yt).unwrap() };
    (outcome, sim.events())
}

fn compile(folder: &Path, form: &Form) {
    let verilog = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/verilog");
    let status = Command::new("iverilog")
        .args(["-g2005", &format!("-DDUT={}", form.module), "-o"])
        .arg(folder.join(form.module))
        .args(["line_rtl.v", "line_gates.v", "bench.v"])
        .current_dir(verilog)
        .status();
    let status = status.unwrap_or_else(|e| panic!("iverilog: {e}; install it by `apt-get install iverilog`"));
    assert!(status.success());
}

fn icarus(folder: &Path, form: &Form, clocks: u64) -> Outcome {
    let program = folder.join(form.module);
    let output = Command::new("vvp").arg("-n").arg(program).arg(format!("+clocks={clocks}")).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find(|l| l.starts_with("clocks=")).unwrap_or_else(|| panic!("vvp says {text}"));
    let field = |name: &str| {
        let field = line.split(' ').find_map(|f| f.strip_prefix(name)?.strip_prefix('='));
        field.unwrap_or_else(|| panic!("no {name} in {line}"))
    };
    let number = |name: &str| field(name).parse().unwrap();
    let sum = u32::from_str_radix(field("sum"), 16).unwrap();
    Outcome { clocks: number("clocks"), lines: number("lines"), sum, xt: number("xt"), yt: number("yt") }
}

fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = f();
    (result, start.elapsed().as_secs_f64())
}

/// Median, least and greatest.
fn summary(mut times: Vec<f64>) -> (f64, f64, f64) {
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], times[0], times[times.len() - 1])
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    println!("line by evaluation function, 8 bits, random lines back to back; medians of {RUNS} runs in turns\n");
    println!(
        "{:10} {:9} {:>9} {:>9} {:>15} {:>12} {:>12} {:>13}",
        "form", "simulator", "clocks", "seconds", "(from, to)", "clocks/s", "events/s", "events/clock"
    );
    for form in &FORMS {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(form.file);
        let circuit = circuit::load(path).unwrap_or_else(|e| panic!("{e}"));
        compile(folder.path(), form);
        let mut clocks = 20_000;
        loop {
            let (_, seconds) = timed(|| icarus(folder.path(), form, clocks));
            if seconds >= LEAST.as_secs_f64() {
                break;
            }
            clocks = (clocks as f64 * (1.2 * LEAST.as_secs_f64() / seconds).min(20.0)) as u64;
        }
        let (mut theirs, mut ours) = (Vec::new(), Vec::new());
        let mut events = 0;
        for _ in 0..RUNS {
            let (expected, seconds) = timed(|| icarus(folder.path(), form, clocks));
            theirs.push(seconds);
            let (mut total, mut times) = (0.0, 0);
            while total < LEAST_OWN.as_secs_f64() {
                let ((outcome, changes), seconds) = timed(|| discreta(&circuit, clocks));
                assert_eq!(outcome, expected, "{}: the two did not do the same", form.name);
                (total, times, events) = (total + seconds, times + 1, changes);
            }
            ours.push(total / f64::from(times));
        }
        let ((their_time, from, to), (our_time, our_from, our_to)) = (summary(theirs), summary(ours));
        let row = |simulator: &str, (time, from, to): (f64, f64, f64), rest: String| {
            let (range, rate) = (format!("({from:.3}, {to:.3})"), clocks as f64 / time);
            println!("{:10} {simulator:9} {clocks:>9} {time:>9.3} {range:>15} {rate:>12.0} {rest}", form.name);
        };
        row("icarus", (their_time, from, to), String::new());
        let rest = format!("{:>12.0} {:>13.1}", events as f64 / our_time, events as f64 / clocks as f64);
        row("discreta", (our_time, our_from, our_to), rest);
        println!("{:10} discreta / icarus: {:.2}\n", form.name, their_time / our_time);
    }
}
