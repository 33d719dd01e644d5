//! Flip-flops, registers and latches. Controls are taken as Yosys' simulation library takes them: an x or z on a
//! set, reset, load or enable counts as inactive (`if (x)` is false in IEEE 1364-2005, 9.4).

use serde::Serialize;

use super::CellKind;
use super::algebra::{Algebra, Site};
use super::element::{Element, Kind, Parameter, Port};
use super::pin::{edge_flop, flop, latch, sr};
use crate::Value;
use crate::value::Word;

/// The clock edge on which a storage cell samples.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    /// 0→1, 0→x, 0→z, x→1, z→1 (IEEE 1364-2005, 9.7.2).
    Rising,
    /// 1→0, 1→x, 1→z, x→0, z→0.
    Falling,
}

impl Edge {
    /// The other one.
    #[must_use]
    pub const fn opposite(self) -> Edge {
        match self {
            Edge::Rising => Edge::Falling,
            Edge::Falling => Edge::Rising,
        }
    }
}

/// The parameters of a D flip-flop, register or latch.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Flop {
    /// The active edge (of no meaning in a latch).
    pub edge: Edge,
    /// What `set` and `sync_set` load.
    pub set_value: Value,
    /// What `reset` and `sync_reset` load.
    pub reset_value: Value,
    /// The state before anything has set it.
    pub init: Value,
}

/// Whether a control acts, where it counts; none if it certainly does not.
#[inline(always)]
pub(super) fn control<A: Algebra>(l: &mut A, s: &impl Site<A>, pin: usize, when: Option<A::Plane>) -> Option<A::Plane> {
    let mut acts = l.is_one(s.get(pin, 0));
    if let Some(when) = when {
        acts = l.and(acts, when);
    }
    if l.never(acts) { None } else { Some(acts) }
}

/// `value` where a control acts, else `q`.
#[inline(always)]
pub(super) fn load<A: Algebra>(
    l: &mut A,
    control: Option<A::Plane>,
    value: impl FnOnce(&mut A) -> A::Word,
    q: A::Word,
) -> A::Word {
    match control {
        Some(acts) => {
            let value = value(l);
            l.pick(acts, value, q)
        }
        None => q,
    }
}

/// The asynchronous pins of a flip-flop or latch.
#[derive(Clone, Copy)]
pub struct Asynchronous {
    /// The number of the pin whose value is loaded.
    pub d: usize,
    /// Loads it while it is 1.
    pub load: usize,
    /// Sets while it is 1, unless `reset` is.
    pub set: usize,
    /// Resets while it is 1; dominates `set` and `load`.
    pub reset: usize,
}

/// Those of a flip-flop.
pub const OF_FLOP: Asynchronous = Asynchronous { d: flop::D, load: flop::ALOAD, set: flop::SET, reset: flop::RESET };
/// Those of a latch.
pub const OF_LATCH: Asynchronous = Asynchronous { d: latch::D, load: latch::EN, set: latch::SET, reset: latch::RESET };

/// What the level-sensitive controls make of a state: reset before set before load. `values` gives a word of the set
/// value and of the reset value.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn level<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    pins: Asynchronous,
    width: u32,
    values: impl Fn(&mut A, usize) -> (A::Word, A::Word),
) {
    let to_d = control(l, s, pins.load, None);
    let to_set = control(l, s, pins.set, None);
    let to_reset = control(l, s, pins.reset, None);
    if to_d.is_none() && to_set.is_none() && to_reset.is_none() {
        return s.hold();
    }
    for i in 0..A::words(width) {
        let q = s.state(i);
        let q = load(l, to_d, |_| s.get(pins.d, i), q);
        let (set, reset) = values(l, i);
        let q = load(l, to_set, |_| set, q);
        let q = load(l, to_reset, |_| reset, q);
        s.put(0, i, q);
    }
}

/// What a flip-flop takes at its active edge, where `when` is 1: the first of reset, set, asynchronous load, synchronous
/// reset, synchronous set and enabled data that applies.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn flop_edge<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    width: u32,
    when: Option<A::Plane>,
    values: impl Fn(&mut A, usize) -> (A::Word, A::Word),
) {
    let en = control(l, s, flop::EN, when);
    let sync_set = control(l, s, flop::SYNC_SET, when);
    let sync_reset = control(l, s, flop::SYNC_RESET, when);
    let aload = control(l, s, flop::ALOAD, when);
    let set = control(l, s, flop::SET, when);
    let reset = control(l, s, flop::RESET, when);
    if en.is_none() && sync_set.is_none() && sync_reset.is_none() && aload.is_none() && set.is_none() && reset.is_none()
    {
        return s.hold();
    }
    for i in 0..A::words(width) {
        let q = s.state(i);
        let (set_value, reset_value) = values(l, i);
        let q = load(l, en, |_| s.get(flop::D, i), q);
        let q = load(l, sync_set, |_| set_value, q);
        let q = load(l, sync_reset, |_| reset_value, q);
        let q = load(l, aload, |_| s.get(flop::D, i), q);
        let q = load(l, set, |_| set_value, q);
        let q = load(l, reset, |_| reset_value, q);
        s.put(0, i, q);
    }
}

/// The same for one whose asynchronous controls act at their edges: reset, set, load of `ad`, enabled data.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn edge_flop_edge<A: Algebra>(l: &mut A, s: &mut impl Site<A>, f: &Flop, when: Option<A::Plane>) {
    let en = control(l, s, edge_flop::EN, when);
    let aload = control(l, s, edge_flop::ALOAD, when);
    let set = control(l, s, edge_flop::SET, when);
    let reset = control(l, s, edge_flop::RESET, when);
    if en.is_none() && aload.is_none() && set.is_none() && reset.is_none() {
        return s.hold();
    }
    for i in 0..A::words(f.init.width()) {
        let q = s.state(i);
        let q = load(l, en, |_| s.get(edge_flop::D, i), q);
        let q = load(l, aload, |_| s.get(edge_flop::AD, i), q);
        let q = load(l, set, |l| l.word_of(&f.set_value, i), q);
        let q = load(l, reset, |l| l.word_of(&f.reset_value, i), q);
        s.put(0, i, q);
    }
}

/// The next state of an SR flip-flop.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn sr<A: Algebra>(l: &mut A, s: &mut impl Site<A>, set_dominates: bool) {
    let (set, reset) = (control(l, s, sr::S, None), control(l, s, sr::R, None));
    if set.is_none() && reset.is_none() {
        return s.hold();
    }
    let (one, zero) = (l.literal(Word::known(1)), l.literal(Word::ZERO));
    let [first, last] = if set_dominates { [(reset, zero), (set, one)] } else { [(set, one), (reset, zero)] };
    let q = load(l, first.0, |_| first.1, s.state(0));
    let q = load(l, last.0, |_| last.1, q);
    s.put(0, 0, q);
}

/// The inverse of the state, as the second output.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn inverse<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    for i in 0..A::words(width) {
        let y = l.not4(s.state(i), A::mask(width, i));
        s.put(1, i, y);
    }
}

pub(super) const EDGE: Parameter = Parameter {
    name: "edge",
    kind: Kind::Word(&["rising", "falling"]),
    default: Some("rising"),
    doc: "the active clock edge",
};
pub(super) const INIT: Parameter =
    Parameter { name: "init", kind: Kind::Value, default: Some("x"), doc: "state before anything has set it" };
const RESET_VALUE: Parameter =
    Parameter { name: "reset_value", kind: Kind::Value, default: Some("0"), doc: "what a reset loads" };
const SET_VALUE: Parameter =
    Parameter { name: "set_value", kind: Kind::Value, default: Some("all-ones"), doc: "what a set loads" };
const BIT: Parameter = Parameter { name: "width", kind: Kind::WIDTH, default: Some("1"), doc: "bits of `d` and `q`" };
pub(super) const CLK: Port = Port::input("clk", "clock");
pub(super) const Q: Port = Port::output("q", "the state");
const QN: Port = Port::output("qn", "the state inverted");
const SET: Port = Port::optional("set", "asynchronous set, level-sensitive");
pub(super) const RESET: Port = Port::optional("reset", "asynchronous reset, level-sensitive, dominates all");
pub(super) const ASYNC_LOAD: Port = Port::optional("async_load", "takes `d` at once while it is 1").of_pin("aload");

pub(super) fn edge(word: &str) -> Edge {
    if word == "falling" { Edge::Falling } else { Edge::Rising }
}

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    Element {
        name: "sr",
        summary: "SR flip-flop",
        ports: &[Port::input("s", "set"), Port::input("r", "reset"), Q, QN],
        parameters: &[
            Parameter {
                name: "dominant",
                kind: Kind::Word(&["reset", "set"]),
                default: Some("reset"),
                doc: "what happens while both are 1",
            },
            INIT,
        ],
        meaning: "Level-sensitive.\n\n| s r | 00 | 01 | 10 | 11 |\n|---|---|---|---|---|\n| **q** | holds | 0 | 1 | 0, or 1 where set is dominant |\n\n`qn` is the inverse of `q`. An x or z on `s` or `r` counts as 0. The flip-flop of two NOR gates (`sr_nor` of `circuits/lib/storage.json`) differs while both are 1, when its `qn` is 0 too, and gives x for x.",
        source: "documents B, C: SR тригер; Yosys `$sr`",
        example: r#"{ "type": "sr", "connections": { "s": "start", "r": "kox_zero", "q": "run_x" } }"#,
        build: |a| Ok(CellKind::Sr { set_dominates: a.word("dominant") == "set", init: a.value("init") }),
    },
    Element {
        name: "dff",
        summary: "D flip-flop",
        ports: &[
            CLK,
            Port::input("d", "data"),
            Port::optional("en", "clock enable for `d`"),
            SET,
            RESET,
            Port::optional("sync_set", "set at the clock edge, whatever `en` is"),
            Port::optional("sync_reset", "reset at the clock edge, whatever `en` is; dominates `sync_set`"),
            Q,
            QN,
        ],
        parameters: &[BIT, EDGE, RESET_VALUE, SET_VALUE, INIT],
        meaning: "The first line that applies:\n\n| when | q |\n|---|---|\n| `reset = 1` | reset_value, at once |\n| `set = 1` | set_value, at once |\n| active edge, `sync_reset = 1` | reset_value |\n| active edge, `sync_set = 1` | set_value |\n| active edge, `en = 1` | d |\n| otherwise | holds |\n\nAn x or z on a control counts as inactive; an asynchronous control that goes from inactive to x samples as the clock edge does.",
        source: "documents B: D тригер; Yosys `$dff` `$dffe` `$adff` `$sdff` `$dffsr`",
        example: r#"{ "type": "dff", "parameters": { "width": "W", "edge": "falling" }, "connections": { "clk": "dt", "d": "sum", "reset": "start", "q": "f" } }"#,
        build: |a| {
            Ok(CellKind::Flop(Box::new(Flop {
                edge: edge(a.word("edge")),
                set_value: a.value("set_value"),
                reset_value: a.value("reset_value"),
                init: a.value("init"),
            })))
        },
    },
    Element {
        name: "latch",
        summary: "transparent latch",
        ports: &[Port::input("en", "open while 1"), Port::input("d", "data"), SET, RESET, Q, QN],
        parameters: &[BIT, RESET_VALUE, SET_VALUE, INIT],
        meaning: "| reset | set | en | q |\n|---|---|---|---|\n| 1 | – | – | reset_value |\n| 0 | 1 | – | set_value |\n| 0 | 0 | 1 | d |\n| 0 | 0 | 0 | holds |\n\nAn x or z on a control counts as inactive.",
        source: "Yosys `$dlatch` `$adlatch` `$dlatchsr`",
        example: r#"{ "type": "latch", "parameters": { "width": 4 }, "connections": { "en": "open", "d": "d", "q": "q" } }"#,
        build: |a| {
            Ok(CellKind::Latch(Box::new(Flop {
                edge: Edge::Rising,
                set_value: a.value("set_value"),
                reset_value: a.value("reset_value"),
                init: a.value("init"),
            })))
        },
    },
    Element {
        name: "register",
        summary: "register with load",
        ports: &[
            CLK,
            Port::input("d", "data"),
            Port::optional("load", "takes `d` at the clock edge while it is 1").of_pin("en"),
            ASYNC_LOAD,
            RESET,
            Q,
        ],
        parameters: &[Parameter { default: Some("8"), ..BIT }, EDGE, RESET_VALUE, INIT],
        meaning: "The first line that applies:\n\n| when | q |\n|---|---|\n| `reset = 1` | reset_value, at once |\n| `async_load = 1` | d, at once |\n| active edge, `load = 1` | d |\n| otherwise | holds |\n\nAn x or z on a control counts as inactive; an asynchronous control that goes from inactive to x samples as the clock edge does.",
        source: "documents A, B, C: регистър, Р1…Р6; Yosys `$adffe` `$aldff`",
        example: r#"{ "type": "register", "parameters": { "width": "W" }, "connections": { "clk": "dt", "d": "dx", "load": "start", "q": "p1" } }"#,
        build: |a| {
            let set_value = Value::unknown(a.width("width")); // there is no set pin
            Ok(CellKind::Flop(Box::new(Flop {
                edge: edge(a.word("edge")),
                set_value,
                reset_value: a.value("reset_value"),
                init: a.value("init"),
            })))
        },
    },
];
