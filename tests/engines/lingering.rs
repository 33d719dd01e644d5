//! x that stays in a few words, comes back late, or lies in memories: the compiled engine against the event engine over
//! long runs of a clock, in which its guards learn and edges run as straight code.
#![cfg(feature = "compiled")]

use super::compiled::{Pair, add_memories, seeds};
use crate::support::Rng;
use crate::support::design::Design;
use discreta::Value;
use discreta::cell::memory::{ReadPort, WritePort};
use discreta::cell::{CellKind, Clock, Edge, Flop, GateOp, Memory};
use discreta::engine::{CompiledEngine, Engine};
use discreta::netlist::{Builder, Bus, Netlist};

/// Random netlists with memories: a clock that runs for long, and inputs of which a few bits become x now and then.
#[test]
fn random_netlists_with_lingering_x_are_the_same_on_both_engines() {
    let seeds = seeds(30);
    let first = seeds.start;
    let (mut instants, mut straight, mut mixed, mut all, mut left) = (0, 0, 0, 0, 0);
    for seed in seeds {
        let mut rng = Rng::new(seed);
        let mut design = Design::ordered(&mut rng);
        if !rng.one_in(3) {
            add_memories(&mut rng, &mut design);
        }
        let times = 1 + rng.below(2) as usize;
        let netlist = if times > 1 { design.repeated(&mut rng, times) } else { design.clone() }.build(&mut rng);
        if CompiledEngine::supports(&netlist).is_err() {
            continue;
        }
        let observed = rng.one_in(2).then(|| rng.below(netlist.nets().len() as u64) as usize);
        let chunk = *rng.pick(&[1, 2, 5, 20, 160]);
        let (mut pair, inputs) = Pair::clocked(&netlist, &design, chunk, observed);
        let mut until = 0;
        for n in 0..20u64 {
            let label = || format!("seed {seed}, {times} times, chunks of {chunk}, step {n}");
            // known for a while, then a few bits unknown, then known again
            let often = if n % 5 == 3 { 6 } else { u64::MAX };
            for &(net, width) in &inputs {
                if n == 0 || rng.one_in(3) {
                    pair.drive(net, &rng.four_valued(width, often));
                }
            }
            until += 4 * *rng.pick(&[1, 20, 150, 300]);
            if !pair.settle(&label) || !pair.run_far(until, &label) {
                break;
            }
            instants += 1;
        }
        let report = pair.compiled.report();
        straight += report.straight;
        mixed += report.mixed;
        all += report.phases();
        left += report.bail_outs + report.guards;
    }
    println!("{instants} instants, waves: {all}, {mixed} mixed, {straight} in straight code, left {left} times");
    assert!(first > 0 || instants > 300 && straight > all / 4 && mixed > 20_000 && left > 50);
}

/// A memory of which one word is never written is read where a shift register says; what is read is summed without carry,
/// the sum is cleared now and then, and enables a counter. So x comes and goes in a few words for ever, and in a control.
fn reader() -> Netlist {
    let mut b = Builder::new("reader");
    let [clk, rst] = ["clk", "rst"].map(|name| b.input(name, 1));
    let top = b.top();
    let noise = b.net("noise", 16);
    let bit = |n: u32| noise.slice(n, 1);
    let feedback = b.gate("feedback", GateOp::Xor, &[&bit(15), &bit(13), &bit(12), &bit(10)]);
    // while it is reset, ones come in
    let low = b.gate("low", GateOp::Or, &[&feedback, &rst]);
    let shifted = Bus::concat([&low, &noise.slice(0, 15)]);
    b.dff("noise_q", &clk, &shifted, &noise);
    let mut init = Memory::contents(16, 16);
    for i in 1..16 {
        Memory::set_word(16, &mut init, i, &Value::from_u64((0x1234 * u64::from(i)) & 0xffff, 16), |_| true);
    }
    let memory = Memory {
        width: 16,
        size: 16,
        offset: 0,
        abits: 4,
        init: init.into(),
        start: Value::unknown(16),
        reads: vec![ReadPort {
            clock: Some(Edge::Rising),
            wide: false,
            transparent: vec![false].into(),
            collides: vec![false].into(),
            arst_value: Value::unknown(16),
            srst_value: Value::unknown(16),
            enable_first: false,
        }],
        writes: vec![WritePort { clock: Some(Edge::Rising), wide: false, priority: vec![false].into() }],
    };
    let (zero, one) = (b.constant(&Value::from_u64(0, 1)), b.constant(&Value::from_u64(1, 1)));
    let read = b.net("read", 16);
    // word 0 is not written: where the address may be 0 the enable is 0
    let some = b.gate("some", GateOp::Or, &[&bit(0), &bit(1), &bit(2), &bit(3)]);
    let inputs = memory_pins(&clk, &one, &zero, &noise.slice(4, 4), &noise.slice(0, 4), &noise, &some);
    b.cell(top, "memory", CellKind::Memory(Box::new(memory)), inputs, vec![read.clone()]);
    let sum = b.output("sum", 16);
    let keep = b.gate("keep", GateOp::Or, &[&bit(8), &bit(9), &bit(10)]);
    let rest = b.gate("rest", GateOp::Xor, &[&sum, &read]);
    let next = b.gate("next", GateOp::And, &[&rest, &Bus::concat([&keep; 16])]);
    b.dff("sum_q", &clk, &next, &sum);
    // the enable is unknown now and then: what is held, too, until the next time that it is known
    let held = b.output("held", 16);
    let x = Value::unknown(16);
    let flop = Flop { edge: Edge::Rising, set_value: x.clone(), reset_value: x.clone(), init: x };
    let none = Bus::default();
    let inputs = vec![clk.clone(), noise.clone(), none.clone(), none.clone(), none, sum.slice(0, 1)];
    b.cell(top, "held_q", CellKind::Flop(Box::new(flop)), inputs, vec![held]);
    b.finish().unwrap()
}

/// The pins of a memory of 16 words with a read and a write port: enable 1 for reads, `write` for all bits that are written.
fn memory_pins(clk: &Bus, one: &Bus, zero: &Bus, read: &Bus, written: &Bus, data: &Bus, write: &Bus) -> Vec<Bus> {
    let enable = Bus::concat([write; 16]);
    let ports = [clk, one, zero, zero, read, clk, &enable, written, data];
    ports.map(Bus::clone).into()
}

#[test]
fn nearly_all_clocks_are_straight_code_though_x_comes_and_goes() {
    let netlist = reader();
    let mut pair = Pair::new(&netlist, 160, |_| false);
    let [clk, rst] = ["clk", "rst"].map(|name| netlist.bits(netlist.find(name).unwrap())[0].net);
    let clock = Clock { period: 2, high: 1, phase: 1 };
    pair.event.add_clock(clk, clock);
    pair.compiled.add_clock(clk, clock);
    pair.drive(rst, &Value::from_u64(1, 1));
    let label = || "the reader".to_owned();
    assert!(pair.settle(&label) && pair.run_far(40, &label));
    pair.drive(rst, &Value::from_u64(0, 1));
    assert!(pair.settle(&label));
    let sum = netlist.bits(netlist.find("sum").unwrap())[0].net;
    let (mut unknown, mut rng) = (0, Rng::new(17));
    let mut now = 40;
    for _ in 0..200 {
        now += 1 + rng.below(800);
        assert!(pair.run_far(now, &label));
        unknown += u32::from(pair.event.read(sum)[0].u != 0);
    }
    let warm = pair.compiled.report();
    assert!(pair.run_far(now + 200_000, &label));
    let report = pair.compiled.report();
    println!("{}; unknown at {unknown} of 200 looks", pair.compiled.summary());
    assert!((5..195).contains(&unknown), "{unknown}");
    // all but one in a hundred, after some 80,000 phases
    let (all, straight) = (report.phases() - warm.phases(), report.straight - warm.straight);
    assert!(100 * straight >= 99 * all, "{straight} of {all}");
    assert!(report.variants <= 12, "{}", report.variants);
    assert!(pair.compiled.summary().contains("unknown against expectation"), "{}", pair.compiled.summary());
}
