//! Packed state against the event engine: long runs of a clock on circuits of gates, every net compared after each, with
//! inputs and x at random between them.
#![cfg(feature = "compiled")]

use crate::support::{Rng, repository};
use discreta::Value;
use discreta::cell::Clock;
use discreta::engine::{CompiledEngine, Engine, EventEngine};
use discreta::netlist::{Driver, NetId, Netlist};
use discreta::value::Word;

fn to(engine: &mut dyn Engine, tick: u64) {
    while engine.advance(tick).unwrap() {}
}

/// How many waves ran packed; with `chunk` in pieces of some operations.
fn compare(label: &str, netlist: &Netlist, clock: &str, observes: bool, chunk: Option<usize>, bursts: usize) -> u64 {
    let mut rng = Rng::named(label);
    let engine = match chunk {
        Some(chunk) => CompiledEngine::with_partition_size(netlist, chunk),
        None => CompiledEngine::new(netlist),
    };
    let (mut event, mut compiled) = (EventEngine::new(netlist), engine.unwrap());
    let clock = netlist.bits(netlist.find(clock).unwrap())[0].net;
    netlist.net_ids().for_each(|net| event.observe(net));
    // some are looked at, among them some that hardly change
    netlist.net_ids().filter(|_| observes && rng.one_in(97)).for_each(|net| compiled.observe(net));
    let inputs: Vec<NetId> =
        netlist.net_ids().filter(|&n| matches!(netlist.net(n).driver, Driver::Input(_)) && n != clock).collect();
    let drive = |event: &mut EventEngine, compiled: &mut CompiledEngine, net: NetId, value: &Value| {
        let words: Vec<Word> = value.words().collect();
        event.drive(net, &words);
        compiled.drive(net, &words);
    };
    for &net in &inputs {
        drive(&mut event, &mut compiled, net, &Value::from_u64(0, netlist.net(net).width));
    }
    let source = Clock { period: 4, high: 2, phase: 1 };
    event.add_clock(clock, source);
    compiled.add_clock(clock, source);
    let mut now = 0;
    for burst in 0..bursts {
        event.settle().unwrap();
        compiled.settle().unwrap();
        let long = if rng.one_in(3) { 12 } else { 1500 };
        now += 1 + rng.below(long);
        to(&mut event, now);
        to(&mut compiled, now);
        // an inverted output that nothing reads and no signal shows has no value in the event engine
        for net in netlist.net_ids().filter(|&n| !netlist.net_name(n).ends_with(".qn")) {
            let (a, b) = (event.read(net), compiled.read(net));
            assert_eq!(a, b, "{label}, {burst}: {} at {now}", netlist.net_name(net));
        }
        event.clear_changes();
        compiled.clear_changes();
        for &net in &inputs {
            if rng.one_in(2) {
                let width = netlist.net(net).width;
                let value = if rng.one_in(60) { rng.four_valued(width, 4) } else { rng.known(width) };
                drive(&mut event, &mut compiled, net, &value);
            }
        }
    }
    compiled.report().packed
}

/// Circuits of gates, by people.
#[test]
fn long_runs_on_packed_state_are_the_same() {
    let bursts = std::env::var("DISCRETA_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(20);
    let mut packed = [0; 2];
    for path in [
        "evaluation/line_gates",
        "evaluation/circle_gates",
        "evaluation/karibsky_gates",
        "dda/line_gates",
        "dda/circle_gates",
        "three_axis/dda_line_gates",
    ] {
        let file = repository(&format!("circuits/{path}.json"));
        if !file.exists() {
            continue;
        }
        let circuit = discreta::circuit::load(file).unwrap();
        for (observes, chunk) in [(false, None), (true, None), (false, Some(1)), (true, Some(3))] {
            let here = compare(path, &circuit.netlist, "dt", observes, chunk, bursts);
            println!("{path}: {here} waves packed, chunks of {chunk:?}");
            packed[usize::from(chunk.is_some())] += here;
        }
    }
    assert!(bursts < 20 || packed.iter().all(|&waves| waves > 4_000), "{packed:?}");
}
