//! The batch engine: every 8-bit line on registers and on gates, alone and compared with the algorithm on every clock;
//! and gate·lane evaluations a second of one core on netlists of random gates of several sizes.
//!
//! A gate·lane evaluation is a gate whose value is computed in a lane. What is counted is what is computed: an inverter that
//! is part of another gate, a gate that is the same as another and one that nothing needs do not count.
//!
//!     cargo bench --bench batch

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use discreta::Value;
use discreta::cell::{CellKind, Edge, Flop, GateOp};
use discreta::circuit::load;
use discreta::diag::Diagnostics;
use discreta::engine::batch::{BatchEngine, Program, vectors};
use discreta::interpolate::Method;
use discreta::netlist::{Builder, Direction, Netlist};
use discreta::scenario::Scenario;
use discreta::sweep::run::{Statistics, Verdict};
use discreta::sweep::{Against, Ended, Over, Plan, Sweep};

/// Runs of which the fastest counts: what others do on the machine only ever adds.
const RUNS: usize = 5;

/// Every line of 8 bits on a circuit. Each has to come to its end, and none may differ.
fn lines(path: &str, compared: bool, threads: usize) -> (Duration, Statistics) {
    let circuit = load(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap_or_else(|e| panic!("{e}"));
    let netlist = &circuit.netlist;
    let scenario = Scenario::resolve(&circuit, circuit.simulation.as_ref().unwrap(), &mut Diagnostics::new());
    let signals = ["dx", "dy"].map(|name| netlist.find(name).unwrap());
    let nets: Vec<_> = signals.iter().map(|&s| netlist.signal(s).drive.unwrap()).collect();
    let axes = ["dx=0..255", "dy=0..255"].map(|o| o.parse::<Over>().unwrap().values(8, false).unwrap());
    let against = compared.then(|| Against::new(Method::EfLine, &circuit, &scenario, &nets).unwrap());
    let outputs = netlist.ports().filter(|&s| netlist.signal(s).port == Some(Direction::Output)).collect();
    let plan = Plan::new(axes.to_vec()).unwrap();
    let sweep = Sweep { netlist, scenario: &scenario, nets, plan, outputs, against, threads, lanes: 0 };
    let mut best: Option<(Duration, Statistics)> = None;
    for _ in 0..RUNS {
        let mut rows = 0;
        let start = Instant::now();
        let statistics = sweep
            .run(
                0,
                &AtomicBool::new(false),
                &|row| {
                    assert_eq!(row.ended, Ended::Until, "row {}", row.number);
                    assert_eq!(row.verdict, compared.then_some(Verdict::Same), "row {}", row.number);
                    String::new()
                },
                &mut |_, _| {
                    rows += 1;
                    Ok(())
                },
            )
            .unwrap();
        let took = start.elapsed();
        assert_eq!(rows, 1 << 16);
        if best.is_none_or(|b| took < b.0) {
            best = Some((took, statistics));
        }
    }
    best.unwrap()
}

/// Gates of two inputs between registers, of which each clock changes nearly all.
fn gates(count: usize) -> Netlist {
    let mut state = 1u64;
    let mut below = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let mut b = Builder::new("gates");
    let clk = b.input("clk", 1);
    let seed = b.input("seed", 64);
    let load = b.input("load", 1);
    let q: Vec<_> = (0..64).map(|i| b.net(&format!("q{i}"), 1)).collect();
    let mut bits = q.clone();
    for i in 0..count {
        let near = bits.len() - 1 - below(64);
        let (x, y) = (bits[near].clone(), bits[bits.len() - 1 - below(bits.len().min(500))].clone());
        let op = [GateOp::Xor, GateOp::Nand, GateOp::Xor, GateOp::Nor][below(4)];
        bits.push(b.gate(&format!("g{i}"), op, &[&x, &y]));
    }
    for (i, q) in q.iter().enumerate() {
        let turned = b.gate(&format!("x{i}"), GateOp::Xor, &[&bits[bits.len() - 64 + i], &q.clone()]);
        let first = b.gate(&format!("a{i}"), GateOp::And, &[&seed.bit(i as u32), &load]);
        let d = b.gate(&format!("o{i}"), GateOp::Xor, &[&turned, &first]);
        let flop = Flop {
            edge: Edge::Rising,
            set_value: Value::from_u64(0, 1),
            reset_value: Value::from_u64(0, 1),
            init: Value::from_u64(i as u64 & 1, 1),
        };
        let top = b.top();
        b.cell(top, &format!("ff{i}"), CellKind::Flop(Box::new(flop)), vec![clk.clone(), d], vec![q.clone()]);
    }
    b.finish().unwrap_or_else(|faults| panic!("{faults:?}"))
}

/// Gate·lane evaluations a second, with so many lanes, of one core.
fn rate(netlist: &Netlist, lanes: usize) -> f64 {
    let shown = netlist.bits(netlist.find("q0").unwrap());
    let program = Arc::new(Program::showing(netlist, shown).unwrap());
    let mut engine = BatchEngine::new(program, lanes);
    let net = |name: &str| netlist.signal(netlist.find(name).unwrap()).drive.unwrap();
    let (clk, seed, load) = (net("clk"), net("seed"), net("load"));
    let all = vec![u64::MAX; engine.lane_words()];
    let bit = |b: u64| Value::from_u64(b, 1);
    let mut state = 1u64;
    engine.drive_each(seed, |_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        Some(discreta::value::Word::known(state))
    });
    engine.drive(load, &bit(1), &all);
    engine.drive(clk, &bit(0), &all);
    engine.settle();
    let mut clock = |n: usize| {
        for _ in 0..n {
            for level in [1, 0] {
                engine.drive(clk, &bit(level), &all);
                engine.settle();
            }
        }
        engine.evaluated() as f64 * engine.lanes() as f64
    };
    let mut best = 0.0f64;
    let mut before = clock(2);
    for _ in 0..RUNS {
        let start = Instant::now();
        let mut after = before;
        while start.elapsed() < Duration::from_millis(100) {
            after = clock(2);
        }
        best = best.max((after - before) / start.elapsed().as_secs_f64());
        before = after;
    }
    assert!(engine.is_known());
    best
}

fn main() {
    println!("vectors {}, {} threads", vectors(), std::thread::available_parallelism().map_or(1, usize::from));
    println!("\nevery 8-bit line, 65,536 of them          1 thread  all threads   gate·lane evaluations/s of one");
    for (name, path) in
        [("registers", "circuits/evaluation/line.json"), ("gates", "circuits/evaluation/line_gates.json")]
    {
        for (what, compared) in [("alone", false), ("compared on every clock", true)] {
            let ((one, statistics), (all, _)) = (lines(path, compared, 1), lines(path, compared, 0));
            println!(
                "  {:40}{:>6.3} s  {:>9.3} s  {:>12.3e}",
                format!("{name}, {what}"),
                one.as_secs_f64(),
                all.as_secs_f64(),
                statistics.evaluated as f64 / one.as_secs_f64()
            );
        }
    }
    println!("\nrandom gates: gate·lane evaluations a second of one core");
    println!("  {:>8}{:>14}{:>14}{:>14}", "gates", "512 lanes", "4096 lanes", "16384 lanes");
    for count in [1_000, 10_000, 100_000] {
        let netlist = gates(count);
        let rates = [512, 4096, 16384].map(|lanes| rate(&netlist, lanes));
        println!("  {count:>8}{:>14.3e}{:>14.3e}{:>14.3e}", rates[0], rates[1], rates[2]);
    }
}
