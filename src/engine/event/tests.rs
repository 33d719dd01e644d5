//! The meaning of `docs/meaning.md`, sentence by sentence, on circuits small enough to follow by hand.

use super::EventEngine;
use crate::Value;
use crate::cell::{CellKind, Clock, Counter, Edge, Flop, GateOp, Rc};
use crate::netlist::{Builder, Bus, NetId, Netlist};
use crate::value::Word;
use crate::{Engine, Unsettled};

struct Bench {
    netlist: Netlist,
    engine: EventEngine,
}

impl Bench {
    fn new(b: Builder) -> Bench {
        let netlist = b.finish().unwrap();
        let engine = EventEngine::new(&netlist);
        Bench { netlist, engine }
    }

    fn net(&self, name: &str) -> NetId {
        let signal = self.netlist.find(name).unwrap_or_else(|| panic!("no {name}"));
        match self.netlist.bits(signal) {
            [slice] => slice.net,
            other => panic!("{name} is {other:?}"),
        }
    }

    fn set(&mut self, name: &str, value: &str) -> &mut Self {
        let net = self.net(name);
        let value = Value::for_width(value, self.netlist.net(net).width).unwrap();
        self.engine.drive(net, &value.words().collect::<Vec<_>>());
        self
    }

    fn settle(&mut self) -> &mut Self {
        self.engine.settle().unwrap();
        self
    }

    fn get(&self, name: &str) -> String {
        let net = self.net(name);
        Value::from_words(self.engine.read(net), self.netlist.net(net).width).bit_string()
    }

    /// The ticks at which a net changes, and to what.
    fn record(&mut self, name: &str, until: u64) -> Vec<(u64, String)> {
        self.engine.observe(self.net(name));
        let mut seen = vec![];
        while self.engine.advance(until).unwrap() {
            self.engine.clear_changes();
            seen.push((self.engine.now(), self.get(name)));
        }
        seen
    }
}

fn flop(width: u32, edge: Edge, init: &str) -> CellKind {
    let value = |v| Value::for_width(v, width).unwrap();
    CellKind::Flop(Box::new(Flop {
        edge,
        set_value: Value::repeat(crate::Logic::One, width),
        reset_value: value("0"),
        init: value(init),
    }))
}

/// What is not connected reads 0 in all of its bits, however wide.
#[test]
fn an_open_pin_of_many_bits() {
    let mut b = Builder::new("top");
    let (clk, load, q) = (b.input("clk", 1), b.input("load", 1), b.output("q", 70));
    let (step, init) = (Value::from_u64(1, 70), Value::from_u64(5, 70));
    let kind = CellKind::Counter(Box::new(Counter { edge: Edge::Rising, step, init }));
    let open = Bus::default;
    let top = b.top();
    b.cell(top, "counter", kind, vec![clk, open(), open(), open(), open(), open(), load], vec![q]);
    let mut bench = Bench::new(b);
    bench.set("clk", "0").set("load", "1").settle();
    assert_eq!(bench.get("q"), format!("{:070b}", 5));
    bench.set("clk", "1").settle();
    assert_eq!(bench.get("q"), "0".repeat(70));
}

#[test]
fn edges_at_the_same_time_sample_together() {
    // a shift register: each takes what the one before held
    let mut b = Builder::new("top");
    let (clk, d) = (b.input("clk", 1), b.input("d", 1));
    let (q0, q1) = (b.output("q0", 1), b.output("q1", 1));
    b.dff("second", &clk, &q0, &q1);
    b.dff("first", &clk, &d, &q0);
    let mut t = Bench::new(b);
    t.set("clk", "0").set("d", "1").settle();
    t.set("clk", "1").settle();
    assert_eq!((t.get("q0"), t.get("q1")), ("1".into(), "x".into()));
    t.set("clk", "0").set("d", "0").settle();
    t.set("clk", "1").settle();
    assert_eq!((t.get("q0"), t.get("q1")), ("0".into(), "1".into()));
}

#[test]
fn a_clock_derived_from_a_flip_flop_sees_the_new_data() {
    // q toggles at clk; r samples q at the rising edge of q itself, so it sees 1
    let mut b = Builder::new("top");
    let clk = b.input("clk", 1);
    let (q, r) = (b.output("q", 1), b.output("r", 1));
    let top = b.top();
    let not_q = b.not("inv", &q);
    b.cell(top, "toggle", flop(1, Edge::Rising, "0"), vec![clk, not_q], vec![q.clone()]);
    b.dff("sampler", &q, &q, &r);
    let mut t = Bench::new(b);
    t.set("clk", "0").settle();
    assert_eq!(t.get("r"), "x");
    t.set("clk", "1").settle();
    assert_eq!((t.get("q"), t.get("r")), ("1".into(), "1".into()));
}

#[test]
fn the_first_value_is_no_edge_and_later_unknowns_are() {
    let mut b = Builder::new("top");
    let (clk, d, q) = (b.input("clk", 1), b.input("d", 1), b.output("q", 1));
    b.dff("ff", &clk, &d, &q);
    let mut t = Bench::new(b);
    t.set("d", "1").set("clk", "1").settle();
    assert_eq!(t.get("q"), "x", "x to 1 at the start");
    t.set("clk", "x").settle();
    assert_eq!(t.get("q"), "x", "1 to x falls");
    t.set("clk", "1").settle();
    assert_eq!(t.get("q"), "1", "x to 1 rises, once a value has been there");
    t.set("d", "0").set("clk", "0").settle();
    t.set("clk", "z").settle();
    assert_eq!(t.get("q"), "0", "0 to z rises");
}

/// IEEE 1364-2005, 9.7.2: x to 1 is a rising edge, of an uninitialised divider and of an input that had no value alike.
#[test]
fn after_the_first_settling_every_change_from_x_is_an_edge() {
    // `div` takes `d` at each edge of `clk`; each `count` counts the edges of one kind of one net
    let mut b = Builder::new("top");
    let (clk, d, late) = (b.input("clk", 1), b.input("d", 1), b.input("late", 1));
    let div = b.output("div", 1);
    b.dff("divider", &clk, &d, &div);
    let top = b.top();
    for (net, name) in [(&div, "div"), (&late, "late")] {
        for edge in [Edge::Rising, Edge::Falling] {
            let q = b.output(&format!("{name}_{edge:?}"), 4);
            let counter = Counter { edge, step: Value::from_u64(1, 4), init: Value::from_u64(0, 4) };
            let pins = vec![net.clone(), Bus::default(), Bus::default(), Bus::default()];
            b.cell(top, &format!("c_{name}_{edge:?}"), CellKind::Counter(Box::new(counter)), pins, vec![q]);
        }
    }
    let mut t = Bench::new(b);
    let counts = |t: &Bench| ["div_Rising", "div_Falling", "late_Rising", "late_Falling"].map(|n| t.get(n)).join(" ");
    t.set("clk", "0").set("d", "1").settle();
    assert_eq!(counts(&t), "0000 0000 0000 0000");
    t.set("clk", "1").set("late", "0").settle();
    assert_eq!(counts(&t), "0001 0000 0000 0001");
    t.set("clk", "0").set("d", "0").set("late", "z").settle();
    assert_eq!(counts(&t), "0001 0000 0001 0001");
    t.set("clk", "1").set("late", "x").settle();
    assert_eq!(counts(&t), "0001 0001 0001 0001", "z to x is no edge");
}

#[test]
fn what_is_clocked_by_what_first_settles_holds() {
    // a falling clock that is low, a rising one that is high, and a state that clocks others, from the start
    let mut b = Builder::new("top");
    let (low, high) = (b.input("low", 1), b.input("high", 1));
    let top = b.top();
    let inverted = b.not("inv", &low);
    let state = b.net("state", 1);
    b.cell(top, "set", flop(1, Edge::Rising, "1"), vec![low.clone(), state.clone()], vec![state.clone()]);
    for (name, clock, edge) in [
        ("low", &low, Edge::Falling),
        ("high", &high, Edge::Rising),
        ("inv", &inverted, Edge::Rising),
        ("state", &state, Edge::Rising),
    ] {
        let q = b.output(&format!("q_{name}"), 1);
        let not_q = b.not("n", &q);
        b.cell(top, &format!("f_{name}"), flop(1, edge, "0"), vec![clock.clone(), not_q], vec![q]);
    }
    let mut t = Bench::new(b);
    t.set("low", "0").set("high", "1").settle();
    for name in ["q_low", "q_high", "q_inv", "q_state"] {
        assert_eq!(t.get(name), "0", "{name}");
    }
    t.set("low", "1").settle().set("low", "0").settle();
    assert_eq!([t.get("q_low"), t.get("q_inv"), t.get("q_high"), t.get("q_state")].join(""), "1100");
}

#[test]
fn reset_dominates_set_dominates_the_clock() {
    let mut b = Builder::new("top");
    let [clk, d, set, reset] = ["clk", "d", "set", "reset"].map(|n| b.input(n, 1));
    let (q, qn) = (b.output("q", 1), b.output("qn", 1));
    let top = b.top();
    b.cell(top, "ff", flop(1, Edge::Falling, "x"), vec![clk, d, Bus::default(), set, reset], vec![q, qn]);
    let mut t = Bench::new(b);
    t.set("clk", "1").set("d", "0").set("set", "1").set("reset", "0").settle();
    assert_eq!((t.get("q"), t.get("qn")), ("1".into(), "0".into()));
    t.set("clk", "0").settle();
    assert_eq!(t.get("q"), "1");
    t.set("reset", "1").settle();
    assert_eq!((t.get("q"), t.get("qn")), ("0".into(), "1".into()));
    t.set("set", "0").set("d", "1").settle();
    t.set("clk", "1").settle().set("clk", "0").settle();
    assert_eq!(t.get("q"), "0");
    t.set("reset", "0").set("d", "1").settle();
    assert_eq!(t.get("q"), "0", "release is no edge of the clock");
    t.set("clk", "1").settle().set("clk", "0").settle();
    assert_eq!(t.get("q"), "1");
}

#[test]
fn an_asynchronous_reset_from_its_own_count_settles() {
    // a counter that an AND of bits 3 and 1 clears: 0 … 9, never 10 after an instant
    let mut b = Builder::new("top");
    let (clk, clear) = (b.input("clk", 1), b.input("clear", 1));
    let q = b.output("q", 4);
    let top = b.top();
    let ten = b.gate("and1", GateOp::And, &[&q.bit(3), &q.bit(1)]);
    let reset = b.gate("or1", GateOp::Or, &[&ten, &clear]);
    let counter = Counter { edge: Edge::Rising, step: Value::from_u64(1, 4), init: Value::unknown(4) };
    b.cell(
        top,
        "counter",
        CellKind::Counter(Box::new(counter)),
        vec![clk, Bus::default(), Bus::default(), reset],
        vec![q],
    );
    let mut t = Bench::new(b);
    t.set("clk", "0").set("clear", "1").settle().set("clear", "0").settle();
    for n in 1..=25u64 {
        t.set("clk", "1").settle().set("clk", "0").settle();
        assert_eq!(t.get("q"), Value::from_u64(n % 10, 4).bit_string());
    }
}

fn nor_latch() -> Bench {
    let mut b = Builder::new("top");
    let (s, r) = (b.input("s", 1), b.input("r", 1));
    let (q, qn) = (b.output("q", 1), b.output("qn", 1));
    let top = b.top();
    let nor = CellKind::Gate { op: GateOp::Nor, width: 1, inputs: 2 };
    b.cell(top, "nor1", nor.clone(), vec![Bus::concat([&r, &qn])], vec![q.clone()]);
    b.cell(top, "nor2", nor, vec![Bus::concat([&s, &q])], vec![qn]);
    Bench::new(b)
}

#[test]
fn a_latch_of_two_nor_gates_holds() {
    let mut t = nor_latch();
    for (s, r, q, qn) in [
        ("0", "0", "x", "x"),
        ("1", "0", "1", "0"),
        ("0", "0", "1", "0"),
        ("0", "1", "0", "1"),
        ("0", "0", "0", "1"),
        ("1", "1", "0", "0"),
        ("1", "0", "1", "0"),
    ] {
        t.set("s", s).set("r", r).settle();
        assert_eq!((t.get("q").as_str(), t.get("qn").as_str()), (q, qn), "s={s} r={r}");
    }
}

#[test]
fn a_race_that_never_settles_is_an_error_with_its_nets() {
    let mut t = nor_latch();
    t.set("s", "1").set("r", "1").settle();
    t.set("s", "0").set("r", "0");
    let Unsettled { time, nets, clocked } = t.engine.settle().unwrap_err();
    assert_eq!((time, nets, clocked), (0, vec![t.net("q"), t.net("qn")], false));
}

#[test]
fn bringing_bits_together_takes_no_step() {
    // two NOR latches side by side, set by two nets and reset by one of two bits: both gates have to see both at once
    let mut b = Builder::new("top");
    let (s0, s1, r) = (b.input("s0", 1), b.input("s1", 1), b.input("r", 2));
    let (q, qn) = (b.output("q", 2), b.output("qn", 2));
    let top = b.top();
    let nor = CellKind::Gate { op: GateOp::Nor, width: 2, inputs: 2 };
    b.cell(top, "nor1", nor.clone(), vec![Bus::concat([&r, &qn])], vec![q.clone()]);
    b.cell(top, "nor2", nor, vec![Bus::concat([&s0, &s1, &q])], vec![qn]);
    let mut t = Bench::new(b);
    t.set("s0", "1").set("s1", "1").set("r", "3").settle();
    t.set("s0", "0").set("s1", "0").set("r", "0");
    assert!(t.engine.settle().is_err(), "a race has a winner");
}

#[test]
fn of_two_endless_loops_the_same_is_reported_in_any_order() {
    let report = |names: [&str; 2]| {
        let mut b = Builder::new("top");
        let on = b.input("on", 1);
        for name in names {
            let y = b.output(name, 1);
            let nand = CellKind::Gate { op: GateOp::Nand, width: 1, inputs: 2 };
            let top = b.top();
            b.cell(top, &format!("nand_{name}"), nand, vec![Bus::concat([&on, &y])], vec![y]);
        }
        let mut t = Bench::new(b);
        t.set("on", "0").settle().set("on", "1");
        t.engine.settle().unwrap_err().names(&t.netlist)
    };
    assert_eq!(report(["a", "b"]), ["a"]);
    assert_eq!(report(["b", "a"]), ["a"]);
}

/// A loop of `n` buffers that holds a 1 needs one step for each, and a last one that finds nothing to change.
#[test]
fn feedback_may_take_any_number_of_steps() {
    for n in (50..80).chain(120..140) {
        let mut b = Builder::new("top");
        let (set, q) = (b.input("set", 1), b.output("q", 1));
        let or = b.gate("or1", GateOp::Or, &[&set, &q]);
        let held = (0..n).fold(or, |from, i| b.gate(&format!("buf{i}"), GateOp::Buf, &[&from]));
        let top = b.top();
        b.cell(top, "last", CellKind::Gate { op: GateOp::Buf, width: 1, inputs: 1 }, vec![held], vec![q]);
        let mut t = Bench::new(b);
        t.set("set", "1");
        assert!(t.engine.settle().is_ok(), "{n} buffers");
        assert_eq!(t.get("q"), "1", "{n} buffers");
    }
}

#[test]
fn a_clock_that_drives_itself_is_an_error() {
    // p toggles when n rises, m when n falls, and n = p ^ m ^ kick changes with each
    let mut b = Builder::new("top");
    let (kick, p, m) = (b.input("kick", 1), b.output("p", 1), b.output("m", 1));
    let top = b.top();
    let n = b.gate("xor1", GateOp::Xor, &[&p, &m, &kick]);
    let (not_p, not_m) = (b.not("not1", &p), b.not("not2", &m));
    b.cell(top, "rises", flop(1, Edge::Rising, "0"), vec![n.clone(), not_p], vec![p]);
    b.cell(top, "falls", flop(1, Edge::Falling, "0"), vec![n, not_m], vec![m]);
    let mut t = Bench::new(b);
    t.set("kick", "0").settle();
    t.set("kick", "1");
    let Unsettled { nets, clocked, .. } = t.engine.settle().unwrap_err();
    assert_eq!((nets, clocked), (vec![t.net("p"), t.net("m")], true));
}

#[test]
fn long_chains_are_no_oscillation() {
    // a ripple counter of 24 bits: 2^23 - 1 to 2^23 ripples through 24 derived clocks in one instant
    let mut b = Builder::new("top");
    let clk = b.input("clk", 1);
    let top = b.top();
    let mut clock = clk;
    for i in 0..24 {
        let q = b.output(&format!("q{i}"), 1);
        let next = b.not("n", &q);
        b.cell(top, "ff", flop(1, Edge::Falling, if i < 23 { "1" } else { "0" }), vec![clock, next], vec![q.clone()]);
        clock = q;
    }
    let mut t = Bench::new(b);
    t.set("clk", "1").settle().set("clk", "0").settle();
    let bits: String = (0..24).rev().map(|i| t.get(&format!("q{i}"))).collect();
    assert_eq!(bits, format!("1{}", "0".repeat(23)));
}

#[test]
fn clocks_delays_and_their_ticks() {
    let mut b = Builder::new("top");
    let clk = b.output("clk", 1);
    let (late, node) = (b.output("late", 1), b.output("node", 1));
    let top = b.top();
    b.cell(top, "clock", CellKind::Clock(Clock { period: 100, high: 30, phase: 10 }), vec![], vec![clk.clone()]);
    b.cell(top, "delay", CellKind::Delay { width: 1, ticks: 7, init: None }, vec![clk.clone()], vec![late]);
    // tau 20: the rise comes after 20·ln 2 = 13.9, the fall 13.9 after the fall
    b.cell(top, "rc", CellKind::RcDelay(Rc { tau: 20.0, rise: 0.5, fall: 0.5 }), vec![clk], vec![node]);
    let mut t = Bench::new(b);
    let expect = |list: &[(u64, &str)]| list.iter().map(|&(t, v)| (t, v.to_string())).collect::<Vec<_>>();
    assert_eq!(t.record("clk", 120), expect(&[(10, "1"), (40, "0"), (110, "1")]));
    let mut t = Bench { engine: EventEngine::new(&t.netlist), netlist: t.netlist };
    assert_eq!(t.record("late", 120), expect(&[(7, "0"), (17, "1"), (47, "0"), (117, "1")]));
    let mut t = Bench { engine: EventEngine::new(&t.netlist), netlist: t.netlist };
    // Before time 0 the node held anything from 0 to 1. From 10 on it rises from between 0 and e^-0.5 = 0.607, so it is
    // surely high at 24. At 40 it stands between 1 - e^-1.5 = 0.777 and 0.912, and falls through 0.5 between
    // 20·ln 1.554 = 8.8 and 20·ln 1.825 = 12.03 later.
    assert_eq!(t.record("node", 109), expect(&[(24, "1"), (49, "x"), (53, "0")]));
}

#[test]
fn tristate_buses_resolve() {
    let mut b = Builder::new("top");
    let [a, c, ena, enc] = ["a", "c", "ena", "enc"].map(|n| b.input(n, if n.len() == 1 { 4 } else { 1 }));
    let bus = b.output("bus", 4);
    let top = b.top();
    b.cell(top, "t1", CellKind::Tristate { width: 4 }, vec![a, ena], vec![bus.clone()]);
    b.cell(top, "t2", CellKind::Tristate { width: 4 }, vec![c, enc], vec![bus]);
    let mut t = Bench::new(b);
    t.set("a", "4'b0011").set("c", "4'b0101");
    for (ena, enc, bus) in
        [("0", "0", "zzzz"), ("1", "0", "0011"), ("0", "1", "0101"), ("1", "1", "0xx1"), ("0", "x", "xxxx")]
    {
        t.set("ena", ena).set("enc", enc).settle();
        assert_eq!(t.get("bus"), bus, "{ena} {enc}");
    }
}

#[test]
fn an_unknown_control_is_reported_once_and_only_after_a_known_value() {
    let mut b = Builder::new("top");
    let [clk, d, en] = ["clk", "d", "en"].map(|n| b.input(n, 1));
    let q = b.output("q", 1);
    let top = b.top();
    let open = Bus::default;
    b.cell(top, "ff", flop(1, Edge::Rising, "x"), vec![clk, d, open(), open(), open(), en], vec![q]);
    let mut t = Bench::new(b);
    t.set("clk", "0").set("d", "x").settle();
    assert!(t.engine.take_unknown_controls().is_empty(), "en has not been known yet");
    t.set("en", "1").settle().set("en", "x").settle();
    let reports = t.engine.take_unknown_controls();
    assert_eq!(reports.iter().map(|r| r.pin).collect::<Vec<_>>(), ["en"]);
    t.set("en", "1").settle().set("en", "x").settle();
    assert!(t.engine.take_unknown_controls().is_empty());
}

#[test]
fn wide_cells_do_what_narrow_ones_do() {
    let mut b = Builder::new("top");
    let (clk, a, c) = (b.input("clk", 1), b.input("a", 100), b.input("b", 100));
    let (sum, q) = (b.output("sum", 100), b.output("q", 100));
    let top = b.top();
    let adder = CellKind::Adder { op: crate::cell::AddOp::Add, width: 100 };
    b.cell(top, "adder", adder, vec![a, c], vec![sum.clone()]);
    let high = b.output("high", 40);
    b.cell(top, "buf", CellKind::Gate { op: GateOp::Buf, width: 40, inputs: 1 }, vec![q.slice(50, 40)], vec![high]);
    b.cell(top, "ff", flop(100, Edge::Rising, "x"), vec![clk, sum], vec![q]);
    let mut t = Bench::new(b);
    t.set("a", "0xffffffffffffffff").set("b", "0x4000000000001").set("clk", "0").settle().set("clk", "1").settle();
    assert_eq!(t.get("q"), format!("{:0100b}", 0xffff_ffff_ffff_ffff_u128 + 0x4_0000_0000_0001));
    assert_eq!(
        t.get("high"),
        format!("{:040b}", (0xffff_ffff_ffff_ffff_u128 + 0x4_0000_0000_0001) >> 50 & 0xff_ffff_ffff)
    );
    t.set("a", "x").settle();
    assert_eq!(t.get("sum"), "x".repeat(100));
    assert_eq!(t.engine.read(t.net("sum"))[1], Word::x((1 << 36) - 1));
}
