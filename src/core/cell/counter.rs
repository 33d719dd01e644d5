//! Counters and accumulators: a register with its adder.

use super::CellKind;
use super::arith::add;
use super::element::{Element, Kind, Parameter, Port};
use super::storage::{ASYNC_LOAD, CLK, EDGE, Edge, INIT, Q, RESET, edge};
use crate::Value;
use crate::value::Word;
use crate::value::word::{word_mask, words};

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

/// The control pins of a counter as they stand.
#[derive(Clone, Copy)]
pub struct Controls {
    /// Counts.
    pub en: Word,
    /// Counts down.
    pub down: Word,
    /// Takes `d` at the edge.
    pub load: Word,
    /// Takes `d` at once.
    pub aload: Word,
    /// To 0 at once.
    pub reset: Word,
}

/// The next state of a counter at its edge. An x or z on `down` while counting gives all x; on another control it
/// counts as inactive.
#[inline(always)]
pub fn count(width: u32, q: &[Word], d: &[Word], step: &[Word], c: &Controls, next: &mut [Word]) {
    if c.reset.is_one() {
        next.fill(Word::ZERO);
    } else if c.aload.is_one() || c.load.is_one() {
        next.copy_from_slice(d);
    } else if c.en.is_one() {
        add(width, q, step, Word::ZERO, c.down, next);
    } else {
        next.copy_from_slice(q);
    }
}

/// What the level-sensitive controls of a counter or accumulator make of its state.
#[inline(always)]
pub fn level(q: &mut [Word], d: &[Word], aload: Word, reset: Word) {
    if reset.is_one() {
        q.fill(Word::ZERO);
    } else if aload.is_one() {
        q.copy_from_slice(d);
    }
}

/// The next state of an accumulator at its edge: `q + d + ci`.
#[inline(always)]
pub fn accumulate(width: u32, q: &[Word], d: &[Word], ci: Word, en: Word, reset: Word, next: &mut [Word]) {
    if reset.is_one() {
        next.fill(Word::ZERO);
    } else if en.is_one() {
        add(width, q, d, ci, Word::ZERO, next);
    } else {
        next.copy_from_slice(q);
    }
}

/// The carry of `q + d + ci`.
#[must_use]
pub fn carry(width: u32, q: &[Word], d: &[Word], ci: Word) -> Word {
    let mut carry = ci;
    for i in 0..words(width) {
        let bits = word_mask(width, i).count_ones();
        let mut sum = [Word::ZERO];
        carry = add(bits, &q[i..=i], &d[i..=i], carry, Word::ZERO, &mut sum);
    }
    carry
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
