//! Waveforms of the compiled engine, whose machine code writes down what changes: the same bytes as those of the event
//! engine, and the same values as FST.
#![cfg(feature = "compiled")]

use std::io;
use std::sync::atomic::AtomicBool;

use crate::support::design::{CLOCKS, Design};
use crate::support::{Rng, repository};
use discreta::Value;
use discreta::cell::Clock;
use discreta::engine::{AutoEngine, CompiledEngine, Engine, EventEngine};
use discreta::netlist::{NetId, Netlist, SignalId};
use discreta::scenario::{Control, DrivenClock, Event, Outcome, RunError, Scenario, run};
use discreta::value::Word;
use discreta::wave::behind::Behind;
use discreta::wave::fst::FstWriter;
use discreta::wave::output::Output;
use discreta::wave::read::Waves;
use discreta::wave::vcd::VcdWriter;
use discreta::wave::{Layout, Sink};

/// Takes one change after the other only.
struct Plain<'s>(&'s mut dyn Sink);

impl Sink for Plain<'_> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        self.0.begin(layout)
    }
    fn time(&mut self, now: u64) -> io::Result<()> {
        self.0.time(now)
    }
    fn change(&mut self, var: usize, value: &[Word]) {
        self.0.change(var, value);
    }
    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.0.finish(end)
    }
}

fn go(netlist: &Netlist, scenario: &Scenario, engine: &mut dyn Engine, sink: &mut dyn Sink) -> Option<Outcome> {
    let mut control = Control {
        interrupt: &AtomicBool::new(false),
        progress: &mut |_| {},
        message: &mut |_, _, _| {},
        unknown_control_ends: false,
        observers: Vec::new(),
    };
    match run(netlist, scenario, engine, Some(sink), &mut control) {
        Ok(outcome) => Some(outcome),
        Err(RunError::Unsettled(_)) => None,
        Err(RunError::Wave(error)) => panic!("{error}: {}", engine.summary()),
    }
}

/// How a run ended, and its VCD.
fn vcd(netlist: &Netlist, scenario: &Scenario, engine: &mut dyn Engine, plain: bool) -> (String, String) {
    let mut bytes = Vec::new();
    let mut writer = VcdWriter::new(&mut bytes);
    let outcome = match plain {
        true => go(netlist, scenario, engine, &mut Plain(&mut writer)),
        false => go(netlist, scenario, engine, &mut writer),
    };
    drop(writer);
    (format!("{:?}", outcome.map(|o| (o.stop, o.time, o.outputs))), String::from_utf8(bytes).unwrap())
}

/// A random netlist with a clock, and inputs that change at random, often when the clock does.
fn random(seed: u64, totals: &mut [u64; 5]) {
    let mut rng = Rng::new(seed);
    let design = if seed.is_multiple_of(3) { Design::new(&mut rng) } else { Design::ordered(&mut rng) };
    let netlist = design.build(&mut rng);
    if CompiledEngine::supports(&netlist).is_err() {
        totals[0] += 1;
        return;
    }
    let unknown = *rng.pick(&[u64::MAX, u64::MAX, u64::MAX, 40, 6]);
    let inputs: Vec<(NetId, u32)> = (0..design.inputs)
        .map(|i| {
            let signal = netlist.find(&design.signals[i].0).unwrap();
            (netlist.bits(signal)[0].net, design.signals[i].1)
        })
        .collect();
    let clocks = 1 + usize::from(rng.one_in(3));
    let clock = |i: usize, rng: &mut Rng| DrivenClock {
        name: design.signals[i].0.clone(),
        net: inputs[i].0,
        clock: Clock { period: 4 + rng.below(3), high: 2, phase: rng.below(3) },
    };
    let clocks: Vec<DrivenClock> = (0..clocks).map(|i| clock(i, &mut rng)).collect();
    let driven = clocks.len()..design.inputs;
    let mut scenario = Scenario {
        inputs: driven.clone().map(|i| (inputs[i].0, Value::from_u64(0, inputs[i].1))).collect(),
        limit: 600,
        limit_given: true,
        clocks,
        ..Scenario::default()
    };
    let often = *rng.pick(&[2, 30, 200]);
    for time in (0..600).filter(|_| rng.one_in(often)).collect::<Vec<u64>>() {
        let mut sets = Vec::new();
        for i in driven.clone().filter(|_| rng.one_in(2)).collect::<Vec<_>>() {
            let unknown = if CLOCKS.contains(&i) { unknown.saturating_mul(10) } else { unknown };
            sets.push((inputs[i].0, rng.four_valued(inputs[i].1, unknown)));
        }
        scenario.stimulus.push(Event { time, sets });
    }
    // which of them is another choice than what is watched
    scenario.trace = match rng.below(4) {
        0 => netlist.signal_ids().filter(|_| rng.one_in(3)).collect(),
        _ => netlist.signal_ids().collect(),
    };
    if rng.one_in(2) {
        let signal = *rng.pick(&netlist.signal_ids().collect::<Vec<SignalId>>());
        scenario.until = Some((signal, rng.known(netlist.signal(signal).width)));
    }
    let expected = vcd(&netlist, &scenario, &mut EventEngine::new(&netlist), false);
    let mut compiled = CompiledEngine::with_partition_size(&netlist, *rng.pick(&[1, 30, 1000])).unwrap();
    assert_eq!(vcd(&netlist, &scenario, &mut compiled, false), expected, "seed {seed}");
    totals[1] += 1;
    totals[2] += expected.1.lines().count() as u64;
    totals[3] += u64::from(compiled.log().is_some_and(|log| log.shapes.len() > 1));
    totals[4] += u64::from(expected.0 == "None");
    let mut compiled = CompiledEngine::new(&netlist).unwrap();
    assert_eq!(vcd(&netlist, &scenario, &mut compiled, true), expected, "seed {seed}, one change after the other");
    let mut auto = AutoEngine::with_patience(&netlist, 300);
    assert_eq!(vcd(&netlist, &scenario, &mut auto, false), expected, "seed {seed}, compiled in the middle");
    if seed.is_multiple_of(4) {
        as_fst(&netlist, &scenario, &expected.1, seed);
    }
}

/// The values in FST are those in VCD.
fn as_fst(netlist: &Netlist, scenario: &Scenario, expected: &str, seed: u64) {
    let dir = tempfile::tempdir().unwrap();
    let (fst, vcd) = (dir.path().join("a.fst"), dir.path().join("a.vcd"));
    std::fs::write(&vcd, expected).unwrap();
    let mut writer = FstWriter::new(Behind::new(Output::create(&fst).unwrap()));
    go(netlist, scenario, &mut CompiledEngine::new(netlist).unwrap(), &mut writer);
    let (mut a, mut b) = (Waves::open(&vcd).unwrap(), Waves::open(&fst).unwrap());
    assert_eq!(a.vars().len(), b.vars().len(), "seed {seed}");
    for i in 0..a.vars().len() {
        let (a, b): (Vec<_>, Vec<_>) = (a.load(i).unwrap().changes().collect(), b.load(i).unwrap().changes().collect());
        assert_eq!(a, b, "seed {seed}, variable {i}");
    }
}

#[test]
fn the_bytes_are_the_same_on_all_engines() {
    let seeds = std::env::var("DISCRETA_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(50);
    let mut totals = [0; 5];
    for seed in 0..seeds {
        random(seed, &mut totals);
    }
    let [left_out, runs, lines, ticks, unsettled] = totals;
    println!("{runs} runs, {lines} lines of VCD, {ticks} of them with ticks in one piece; {unsettled} never settled");
    println!("{left_out} that are not compiled were left out");
    assert!(seeds < 50 || runs > 25 && ticks > 4 && lines > 50_000);
}

/// What no pattern asks for is not looked at: the engine is told of the nets alone that the waveform holds.
#[test]
fn what_is_left_out_is_not_traced() {
    let circuit = discreta::circuit::load(repository("circuits/evaluation/line_gates.json")).unwrap();
    let netlist = &circuit.netlist;
    let set = |name: &str, value: u64| {
        let net = netlist.bits(netlist.find(name).unwrap())[0].net;
        (net, Value::from_u64(value, netlist.net(net).width))
    };
    let (dt, _) = set("dt", 0);
    let clock = Clock { period: 20, high: 10, phase: 20 };
    let scenario = Scenario {
        clocks: vec![DrivenClock { name: "dt".into(), net: dt, clock }],
        inputs: vec![set("dx", 200), set("dy", 77), set("xh", 0), set("yh", 0), set("start", 1)],
        stimulus: vec![Event { time: 5, sets: vec![set("start", 0)] }],
        limit: 20_000,
        limit_given: true,
        ..Scenario::default()
    };
    let traced: Vec<SignalId> = ["f", "end"].map(|name| netlist.find(name).unwrap()).to_vec();
    let wanted: Vec<NetId> = traced.iter().flat_map(|&s| netlist.bits(s)).map(|slice| slice.net).collect();
    let mut engine = CompiledEngine::new(netlist).unwrap();
    let few = vcd(netlist, &Scenario { trace: traced, ..scenario.clone() }, &mut engine, false).1;
    let log = engine.log().unwrap();
    assert!(log.shapes.len() > 1);
    for field in log.shapes.iter().flatten() {
        assert!(wanted.contains(&field.net), "{}", netlist.net_name(field.net));
    }
    let all = Scenario { trace: netlist.signal_ids().collect(), ..scenario };
    let mut engine = CompiledEngine::new(netlist).unwrap();
    let all = vcd(netlist, &all, &mut engine, false).1;
    let fields: Vec<usize> = engine.log().unwrap().shapes.iter().map(|shape| shape.len()).collect();
    assert!(fields[0] > 200, "{fields:?}");
    assert!(all.len() > 10 * few.len(), "{} {}", all.len(), few.len());
}
