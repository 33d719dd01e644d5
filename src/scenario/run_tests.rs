//! Runs on small netlists built in place, into a waveform kept in memory.

use std::sync::atomic::AtomicBool;

use super::*;
use crate::cell::{CellKind, Clock, Edge, Flop};
use crate::engine::EventEngine;
use crate::netlist::Builder;
use crate::scenario::Expectation;
use crate::wave::vcd::VcdWriter;

/// `q` toggles from 0 at the rising edges of a clock of period 10; `limit` is a constant, `open` is never driven.
fn toggle() -> Netlist {
    let mut b = Builder::new("top");
    let (clk, q, limit) = (b.net("clk", 1), b.output("q", 1), b.output("limit", 4));
    b.input("open", 1);
    let top = b.top();
    b.cell(top, "clock", CellKind::Clock(Clock { period: 10, high: 5, phase: 5 }), vec![], vec![clk.clone()]);
    b.cell(top, "constant", CellKind::Constant(Box::new(Value::from_u64(9, 4))), vec![], vec![limit]);
    let not_q = b.not("not1", &q);
    let zero = Value::from_u64(0, 1);
    let flop = Flop { edge: Edge::Rising, set_value: zero.clone(), reset_value: zero.clone(), init: zero };
    b.cell(top, "ff", CellKind::Flop(Box::new(flop)), vec![clk, not_q], vec![q]);
    b.finish().unwrap()
}

fn go(netlist: &Netlist, scenario: &Scenario) -> (Outcome, String) {
    let mut bytes = Vec::new();
    let mut sink = VcdWriter::new(&mut bytes);
    let mut control = Control {
        interrupt: &AtomicBool::new(false),
        progress: &mut |_| {},
        message: &mut |_, _, _| {},
        unknown_control_ends: false,
        observers: Vec::new(),
    };
    let outcome = run(netlist, scenario, &mut EventEngine::new(netlist), Some(&mut sink), &mut control).unwrap();
    drop(sink);
    (outcome, String::from_utf8(bytes).unwrap())
}

#[test]
fn what_has_a_value_from_the_start_is_in_the_waveform() {
    let netlist = toggle();
    let scenario =
        Scenario { limit: 20, limit_given: true, trace: netlist.signal_ids().collect(), ..Scenario::default() };
    let (outcome, vcd) = go(&netlist, &scenario);
    assert_eq!((outcome.stop, outcome.time), (Stop::Limit, 20));
    let body = vcd.split_once("$enddefinitions $end\n").unwrap().1;
    // clk, q, limit, open; q rises at 5 and falls at 15
    assert_eq!(body, "#0\n$dumpvars\n0!\n0\"\nb1001 #\nx$\n$end\n#5\n1!\n1\"\n#10\n0!\n#15\n1!\n0\"\n#20\n0!\n");
}

#[test]
fn pulses_are_counted_from_a_value_that_was_there_from_the_start() {
    let netlist = toggle();
    let q = netlist.find("q").unwrap();
    let expect = |n| vec![Expectation { signal: q, rule: Rule::Pulses(n), span: crate::diag::Span::default() }];
    let scenario = Scenario { limit: 24, limit_given: true, expect: expect(1), ..Scenario::default() };
    assert_eq!(go(&netlist, &scenario).0.failures, []);
    let scenario = Scenario { expect: expect(2), ..scenario };
    assert_eq!(go(&netlist, &scenario).0.failures, [Failure { expectation: 0, found: Found::Pulses(1) }]);
}

/// What was read before, of a wider signal, is not seen above the bits of another.
#[test]
fn a_part_of_a_net_is_that_part_alone() {
    let mut b = Builder::new("top");
    let wide = b.output("wide", 4);
    let top = b.top();
    b.cell(top, "constant", CellKind::Constant(Box::new("4'b1011".parse().unwrap())), vec![], vec![wide.clone()]);
    b.alias(top, "part", &wide.slice(1, 1), false);
    let netlist = b.finish().unwrap();
    let (wide, part) = (netlist.find("wide").unwrap(), netlist.find("part").unwrap());
    let counted = Expectation { signal: wide, rule: Rule::Pulses(0), span: crate::diag::Span::default() };
    let until = Some((part, Value::from_u64(1, 1)));
    let scenario = Scenario { limit: 100, until, expect: vec![counted], ..Scenario::default() };
    assert_eq!(go(&netlist, &scenario).0.stop, Stop::Until);
}

#[test]
fn an_engine_begins_anew_after_a_reset() {
    let netlist = toggle();
    let mut engine = EventEngine::new(&netlist);
    let q = netlist.bits(netlist.find("q").unwrap())[0].net;
    engine.observe(q);
    let record = |engine: &mut EventEngine| {
        let mut seen = Vec::new();
        while engine.advance(40).unwrap() {
            engine.clear_changes();
            seen.push((engine.now(), engine.read(q)[0]));
        }
        seen
    };
    let first = record(&mut engine);
    assert_eq!(first.iter().map(|s| s.0).collect::<Vec<_>>(), [5, 15, 25, 35]);
    engine.reset();
    assert_eq!(engine.now(), 0);
    assert_eq!(record(&mut engine), first);
}

#[test]
fn a_circuit_without_a_clock_is_held_as_long_as_asked() {
    let mut b = Builder::new("top");
    let a = b.input("a", 1);
    let y = b.output("y", 1);
    let top = b.top();
    b.cell(top, "buf1", CellKind::Gate { op: crate::cell::GateOp::Buf, width: 1, inputs: 1 }, vec![a], vec![y]);
    let netlist = b.finish().unwrap();
    let drive = netlist.signal(netlist.find("a").unwrap()).drive.unwrap();
    let scenario = Scenario { inputs: vec![(drive, Value::from_u64(1, 1))], limit: 100, ..Scenario::default() };
    let outcome = go(&netlist, &scenario).0;
    assert_eq!((outcome.stop, outcome.time, outcome.outputs[0].1.to_u64()), (Stop::Idle, 0, Some(1)));
    let outcome = go(&netlist, &Scenario { limit_given: true, ..scenario }).0;
    assert_eq!((outcome.stop, outcome.time), (Stop::Limit, 100));
}
