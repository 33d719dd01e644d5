//! Counters and accumulators: a register with its adder.

use super::CellKind;
use super::algebra::{Algebra, Site};
use super::arith::Sum;
use super::element::{Element, Kind, Parameter, Port};
use super::gate::is_zero;
use super::pin::{accumulator, counter as pin};
use super::storage::{ASYNC_LOAD, CLK, EDGE, Edge, INIT, Q, RESET, control, edge, load};
use crate::Value;
use crate::value::Word;

/// The parameters of a counter.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Counter {
    /// The active edge.
    pub edge: Edge,
    /// How far a count goes, as a number of the counter's width.
    pub step: Value,
    /// The state before anything has set it.
    pub init: Value,
}

/// The parameters of an accumulator.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Accumulator {
    /// The active edge.
    pub edge: Edge,
    /// The state before anything has set it.
    pub init: Value,
}

/// What the level-sensitive controls of a counter make of its state: reset before load.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn level<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let (to_d, reset) = (control(l, s, pin::ALOAD, None), control(l, s, pin::RESET, None));
    if to_d.is_none() && reset.is_none() {
        return s.hold();
    }
    let zero = l.literal(Word::ZERO);
    for i in 0..A::words(width) {
        let q = load(l, to_d, |_| s.get(pin::D, i), s.state(i));
        let q = load(l, reset, |_| zero, q);
        s.put(0, i, q);
    }
}

/// What a counter takes at its edge, where `when` is 1; `step` gives a word of how far it goes. An x or z on `down` while
/// counting gives all x; on another control it counts as inactive.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn count<A: Algebra>(
    l: &mut A,
    s: &mut impl Site<A>,
    width: u32,
    when: Option<A::Plane>,
    step: impl Fn(&mut A, usize) -> A::Word,
) {
    let en = control(l, s, pin::EN, when);
    let at_edge = control(l, s, pin::LOAD, when);
    let at_once = control(l, s, pin::ALOAD, when);
    let reset = control(l, s, pin::RESET, when);
    if en.is_none() && at_edge.is_none() && at_once.is_none() && reset.is_none() {
        return s.hold();
    }
    let mut unknown = l.constant(0);
    for i in 0..A::words(width) {
        let (q, step) = (A::planes(s.state(i)).1, step(l, i));
        unknown = l.or(unknown, q);
        unknown = l.or(unknown, A::planes(step).1);
    }
    let zero = l.literal(Word::ZERO);
    let mut sum = Sum::new(l, unknown, zero, s.get(pin::DOWN, 0));
    for i in 0..A::words(width) {
        let (q, step) = (s.state(i), step(l, i));
        let q = load(l, en, |l| sum.step(l, q, step, A::mask(width, i)), q);
        let q = load(l, at_edge, |_| s.get(pin::D, i), q);
        let q = load(l, at_once, |_| s.get(pin::D, i), q);
        let q = load(l, reset, |_| zero, q);
        s.put(0, i, q);
    }
}

/// 1 where the state is 0, as the second output.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn zero<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let y = is_zero(l, width, |_, i| s.state(i));
    s.put(1, 0, y);
}

/// What the level-sensitive reset of an accumulator makes of its state.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn clear<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let reset = control(l, s, accumulator::RESET, None);
    if reset.is_none() {
        return s.hold();
    }
    let zero = l.literal(Word::ZERO);
    for i in 0..A::words(width) {
        let q = load(l, reset, |_| zero, s.state(i));
        s.put(0, i, q);
    }
}

/// `q + d + ci`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn accumulated<A: Algebra>(l: &mut A, s: &impl Site<A>, width: u32) -> Sum<A> {
    let mut unknown = l.constant(0);
    for i in 0..A::words(width) {
        let (q, d) = (A::planes(s.state(i)).1, A::planes(s.get(accumulator::D, i)).1);
        unknown = l.or(unknown, q);
        unknown = l.or(unknown, d);
    }
    let add = l.literal(Word::ZERO);
    Sum::new(l, unknown, s.get(accumulator::CI, 0), add)
}

/// What an accumulator takes at its edge, where `when` is 1: `q + d + ci`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn accumulate<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32, when: Option<A::Plane>) {
    let (en, reset) = (control(l, s, accumulator::EN, when), control(l, s, accumulator::RESET, when));
    if en.is_none() && reset.is_none() {
        return s.hold();
    }
    let zero = l.literal(Word::ZERO);
    let mut sum = accumulated(l, s, width);
    for i in 0..A::words(width) {
        let (q, d) = (s.state(i), s.get(accumulator::D, i));
        let q = load(l, en, |l| sum.step(l, q, d, A::mask(width, i)), q);
        let q = load(l, reset, |_| zero, q);
        s.put(0, i, q);
    }
}

/// The carry of `q + d + ci`, as the second output.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn carry<A: Algebra>(l: &mut A, s: &mut impl Site<A>, width: u32) {
    let mut sum = accumulated(l, s, width);
    for i in 0..A::words(width) {
        sum.step(l, s.state(i), s.get(accumulator::D, i), A::mask(width, i));
    }
    let y = sum.carry(l);
    s.put(1, 0, y);
}

const WIDTH: Parameter = Parameter { name: "width", kind: Kind::WIDTH, default: Some("8"), doc: "bits of `d` and `q`" };

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    Element {
        name: "counter",
        summary: "up/down counter with load and zero flag",
        ports: &[
            CLK,
            Port::optional("en", "counts while 1"),
            Port::optional("down", "1 counts down"),
            Port::optional("d", "what a load takes"),
            Port::optional("load", "takes `d` at the clock edge, whatever `en` is"),
            ASYNC_LOAD,
            RESET,
            Q,
            Port::output("zero", "1 while `q` is 0"),
        ],
        parameters: &[
            WIDTH,
            EDGE,
            Parameter {
                name: "step",
                kind: Kind::Integer { min: 1, max: i64::MAX },
                default: Some("1"),
                doc: "how far a count goes",
            },
            INIT,
        ],
        meaning: "The first line that applies:\n\n| when | q |\n|---|---|\n| `reset = 1` | 0, at once |\n| `async_load = 1` | d, at once |\n| active edge, `load = 1` | d |\n| active edge, `en = 1` | q + step, or q - step while `down = 1`, modulo 2^width |\n| otherwise | holds |\n\n`zero` is the NOR of the bits of `q`. An x or z on `down` while counting gives all x; on another control it counts as inactive. An asynchronous control that goes from inactive to x makes a count as the clock edge does.",
        source: "documents A, B, C: брояч КОХ, КОУ; регистър 3, регистър 4",
        example: r#"{ "type": "counter", "parameters": { "width": "W", "edge": "falling" }, "connections": { "clk": "x", "down": 1, "async_load": "start", "d": "dx", "q": "kox", "zero": "kox_zero" } }"#,
        build: |a| {
            let width = a.width("width");
            let step = a.integer("step");
            if width < 63 && step >> width != 0 {
                return Err(format!(
                    "a step of {step} does not fit a counter {width} bit{} wide",
                    if width == 1 { "" } else { "s" }
                ));
            }
            Ok(CellKind::Counter(Box::new(Counter {
                edge: edge(a.word("edge")),
                step: Value::from_i64(step, width),
                init: a.value("init"),
            })))
        },
    },
    Element {
        name: "accumulator",
        summary: "adder with memory",
        ports: &[
            CLK,
            Port::input("d", "what is added"),
            Port::optional("ci", "carry in"),
            Port::optional("en", "adds while 1"),
            RESET,
            Q,
            Port::output("co", "carry of `q + d + ci`, as it stands before the edge"),
        ],
        parameters: &[WIDTH, EDGE, INIT],
        meaning: "At the active edge with `en = 1`: `q = q + d + ci` modulo 2^width. `reset = 1` makes it 0 at once. `{co, sum} = q + d + ci` without a clock. Any x or z among the operands gives all x; on `en` or `reset` it counts as inactive. A `reset` that goes from inactive to x adds as the clock edge does.",
        source: "documents A, B: суматор с натрупване, SX, SY",
        example: r#"{ "type": "accumulator", "parameters": { "width": "P" }, "connections": { "clk": "dt", "d": "p1", "reset": "start", "q": "sx", "co": "carry_x" } }"#,
        build: |a| {
            Ok(CellKind::Accumulator(Box::new(Accumulator { edge: edge(a.word("edge")), init: a.value("init") })))
        },
    },
];
