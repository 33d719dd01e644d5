//! Each rule on pulses and edges placed by hand, with the bounds on both sides; the regions are those of IEEE 1364-2005,
//! 15.2 and 15.3.

use std::sync::atomic::AtomicBool;

use super::Fault::{self, *};
use super::{CheckRule, Side, Timing, TimingCheck};
use crate::Value;
use crate::diag::Span;
use crate::engine::EventEngine;
use crate::netlist::Builder;
use crate::scenario::{Control, Edge, Event, Expectation, Found, Rule, Scenario, run};

/// Runs two inputs through a history of `(tick, a, b)`, as written in a literal of one bit; `w` is `{a, b}`.
fn outcome(history: &[(u64, char, char)], end: u64, rules: &[Made<'_>], expect: &[Rule]) -> crate::scenario::Outcome {
    let mut builder = Builder::new("top");
    let inputs = [builder.input("a", 1), builder.input("b", 1), builder.input("w", 2)];
    let top = builder.top();
    for (input, name) in inputs.into_iter().zip(["ya", "yb", "yw"]) {
        let width = input.width();
        let y = builder.output(name, width);
        let kind = crate::cell::CellKind::Gate { op: crate::cell::GateOp::Buf, width, inputs: 1 };
        builder.cell(top, name, kind, vec![input], vec![y]);
    }
    let netlist = builder.finish().unwrap();
    let [a, b, w] = ["a", "b", "w"].map(|n| netlist.signal(netlist.find(n).unwrap()).drive.unwrap());
    let sets = |(_, va, vb): (u64, char, char)| {
        let value = |digits: String| {
            let width = digits.len() as u32;
            Value::for_width(&format!("{width}'b{digits}"), width).unwrap()
        };
        vec![(a, value(va.into())), (b, value(vb.into())), (w, value([va, vb].iter().collect()))]
    };
    let find = |name: &str| netlist.find(name).unwrap();
    let checks = rules.iter().map(|&(name, net, made)| TimingCheck {
        name: name.into(),
        rule: CheckRule::Width,
        net: find(net),
        timing: made(&find),
        span: Span::default(),
    });
    let scenario = Scenario {
        stimulus: history.iter().map(|&h| Event { time: h.0, sets: sets(h) }).collect(),
        limit: end,
        limit_given: true,
        checks: checks.collect(),
        expect: expect
            .iter()
            .map(|rule| Expectation { signal: find("a"), rule: rule.clone(), span: Span::default() })
            .collect(),
        ..Scenario::default()
    };
    let mut control = Control {
        interrupt: &AtomicBool::new(false),
        progress: &mut |_| {},
        message: &mut |_, _, _| {},
        unknown_control_ends: false,
        observers: Vec::new(),
    };
    run(&netlist, &scenario, &mut EventEngine::new(&netlist), None, &mut control).unwrap()
}

type Made<'t> = (&'t str, &'t str, fn(&dyn Fn(&str) -> crate::netlist::SignalId) -> Timing);

/// The violations of one rule: tick, fault, measured, required.
fn violations(history: &[(u64, char, char)], end: u64, rule: Made<'_>) -> Vec<(u64, Fault, u64, u64)> {
    let outcome = outcome(history, end, &[rule], &[]);
    let report = &outcome.checks[0];
    assert_eq!(report.count, report.first.len() as u64);
    report.first.iter().map(|v| (v.time, v.fault, v.measured, v.required)).collect()
}

#[test]
fn widths_are_measured_from_edge_to_edge() {
    // high for 3, low for 4, high for 5, low for 6, then high to the end
    let history = [(0, '0', '0'), (10, '1', '0'), (13, '0', '0'), (17, '1', '0'), (22, '0', '0'), (28, '1', '0')];
    let high: Made<'_> = ("", "a", |_| Timing::Width { level: true, min: Some(4), max: Some(4) });
    assert_eq!(violations(&history, 30, high), [(13, TooShort, 3, 4), (22, TooLong, 5, 4)]);
    // the last pulse has been too long when the run ends, though it never does
    assert_eq!(violations(&history, 33, high)[2..], [(33, TooLong, 5, 4)]);
    let low: Made<'_> = ("", "a", |_| Timing::Width { level: false, min: Some(5), max: None });
    // what the net is at first is no pulse
    assert_eq!(violations(&history, 30, low), [(17, TooShort, 4, 5)]);
}

#[test]
fn an_unknown_level_ends_a_pulse_and_a_first_value_begins_none() {
    let rule: Made<'_> = ("", "a", |_| Timing::Width { level: true, min: Some(10), max: None });
    // x → 1 → 0: the 1 is the first value
    assert_eq!(violations(&[(5, '1', '0'), (6, '0', '0')], 9, rule), []);
    // 0 → 1 → x → 1 → 0: two pulses, of 2 and of 1
    let history = [(0, '0', '0'), (5, '1', '0'), (7, 'x', '0'), (8, '1', '0'), (9, '0', '0')];
    assert_eq!(violations(&history, 20, rule), [(7, TooShort, 2, 10), (9, TooShort, 1, 10)]);
}

#[test]
fn periods_are_measured_between_edges_of_one_direction() {
    let history = [(0, '0', '0'), (10, '1', '0'), (11, '0', '0'), (15, '1', '0'), (18, '0', '0'), (30, '1', '0')];
    let rising: Made<'_> = ("", "a", |_| Timing::Period { edge: Edge::Rising, min: Some(6), max: Some(14) });
    assert_eq!(violations(&history, 40, rising), [(15, TooShort, 5, 6), (30, TooLong, 15, 14)]);
    let falling: Made<'_> = ("", "a", |_| Timing::Period { edge: Edge::Falling, min: Some(7), max: Some(20) });
    assert_eq!(violations(&history, 38, falling), []);
    assert_eq!(violations(&history, 39, falling), [(39, TooLong, 21, 20)]);
}

#[test]
fn setup_leaves_out_the_tick_of_the_edge_recovery_and_hold_take_it_in() {
    // the data a changes at 10, 20 and 30; the clock b rises at 13, 20 and 29
    let history = [
        (0, '0', '0'),
        (10, '1', '0'),
        (13, '1', '1'),
        (15, '1', '0'),
        (20, '0', '1'),
        (25, '0', '0'),
        (29, '0', '1'),
        (30, '1', '1'),
    ];
    let setup: Made<'_> = ("", "a", |find| window(find("b"), Side::Setup, 4));
    assert_eq!(violations(&history, 50, setup), [(13, TooLate, 3, 4)]);
    let recovery: Made<'_> = ("", "a", |find| window(find("b"), Side::Recovery, 3));
    assert_eq!(violations(&history, 50, recovery), [(20, TooLate, 0, 3)]);
    let hold: Made<'_> = ("", "a", |find| window(find("b"), Side::Hold, 7));
    assert_eq!(violations(&history, 50, hold), [(20, TooSoon, 0, 7), (30, TooSoon, 1, 7)]);
    let longer: Made<'_> = ("", "a", |find| window(find("b"), Side::Hold, 8));
    assert_eq!(violations(&history, 50, longer).len(), 2, "the edge at 20 has come after that at 13");
    // a bus changes when any of its bits does
    let bus: Made<'_> = ("", "w", |find| window(find("b"), Side::Setup, 5));
    assert_eq!(violations(&history, 50, bus), [(13, TooLate, 3, 5), (29, TooLate, 4, 5)]);
}

fn window(on: crate::netlist::SignalId, side: Side, min: u64) -> Timing {
    Timing::Window { side, edge: None, on, on_edge: Edge::Rising, min }
}

#[test]
fn only_the_edge_asked_for_counts() {
    let history = [(0, '0', '0'), (10, '1', '0'), (12, '1', '1'), (18, '0', '1'), (19, '0', '0'), (20, '0', '1')];
    let fell: Made<'_> = ("", "a", |find| Timing::Window {
        side: Side::Recovery,
        edge: Some(Edge::Falling),
        on: find("b"),
        on_edge: Edge::Rising,
        min: 5,
    });
    assert_eq!(violations(&history, 50, fell), [(20, TooLate, 2, 5)]);
}

/// Steps go in by `a` and come out by `b`.
#[test]
fn steps_are_neither_doubled_nor_lost_nor_too_many() {
    let steps: Made<'_> = ("", "b", |find| Timing::Steps { of: find("a"), depth: Some(2) });
    let pulses = |text: &str| -> Vec<(u64, char, char)> {
        let mut history = vec![(0, '0', '0')];
        for (i, c) in text.chars().enumerate() {
            let at = 10 * (i as u64 + 1);
            let (a, b) = match c {
                'i' => ('1', '0'),
                'o' => ('0', '1'),
                _ => ('1', '1'),
            };
            history.extend([(at, a, b), (at + 5, '0', '0')]);
        }
        history
    };
    assert_eq!(violations(&pulses("iioibo"), 100, steps), [(100, Lost, 3, 4)]);
    assert_eq!(violations(&pulses("iioiboo"), 100, steps), []);
    assert_eq!(violations(&pulses("iiioooi"), 100, steps), [(30, Overfull, 3, 2), (100, Lost, 3, 4)]);
    assert_eq!(violations(&pulses("iooi"), 100, steps), [(30, Doubled, 2, 1)]);
    assert_eq!(violations(&pulses("ioo"), 100, steps), [(30, Doubled, 2, 1), (100, Gained, 2, 1)]);
}

#[test]
fn what_is_kept_is_bounded_and_the_rest_is_counted() {
    let history: Vec<_> = (0..100).map(|i| (i, if i % 2 == 1 { '1' } else { '0' }, '0')).collect();
    let runt: Made<'_> = ("", "a", |_| Timing::Width { level: true, min: Some(2), max: None });
    let rules = [
        Rule::Violated { check: 0, count: None, first: None },
        Rule::Violated { check: 0, count: Some(49), first: Some(2) },
        Rule::Violated { check: 0, count: Some(48), first: None },
        Rule::Violated { check: 0, count: None, first: Some(1) },
    ];
    let outcome = outcome(&history, 100, &[runt], &rules);
    assert_eq!((outcome.checks[0].count, outcome.checks[0].first.len()), (49, super::MAX_KEPT));
    let failed: Vec<_> = outcome.failures.iter().map(|f| (f.expectation, f.found.clone())).collect();
    assert_eq!(failed, [(2, Found::Violations(49, Some(2))), (3, Found::Violations(49, Some(2)))]);
}
