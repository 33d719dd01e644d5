//! One step back: what made the value of some bits of a net.

use super::History;
use super::memory::memory_read;
use crate::cell::{self, CellKind, Edge, Role};
use crate::netlist::{CellId, Driver, Netlist, SignalId, Slice};
use crate::value::Word;
use crate::value::word::words;
use crate::{Logic, Value};

/// What made a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// An input of the circuit.
    Input(SignalId),
    /// A constant of the circuit.
    Constant(CellId),
    /// Nothing drives the net.
    Undriven,
    /// A clock of the circuit itself.
    Clock(CellId),
    /// What a cell makes of its inputs at once.
    Gate(CellId),
    /// What a storage cell took at an edge.
    Edge {
        /// The storage cell.
        cell: CellId,
        /// The pin at which the edge came.
        pin: usize,
        /// The tick of the edge.
        time: u64,
    },
    /// A control that acts as long as it is 1.
    Level {
        /// The storage cell.
        cell: CellId,
        /// The control.
        pin: usize,
    },
    /// What a storage cell holds from the start: nothing has set it.
    Start(CellId),
    /// A word of a memory that nothing has written.
    Unwritten {
        /// The memory.
        cell: CellId,
        /// The number of the word.
        word: u64,
    },
    /// What was written into a memory.
    Written {
        /// The memory.
        cell: CellId,
        /// The tick.
        time: u64,
        /// The number of the word.
        word: u64,
    },
    /// What went into a delay.
    Delayed(CellId),
}

impl Cause {
    /// The cell, if it is one.
    #[must_use]
    pub fn cell(&self) -> Option<CellId> {
        match *self {
            Cause::Input(_) | Cause::Undriven => None,
            Cause::Constant(cell)
            | Cause::Clock(cell)
            | Cause::Gate(cell)
            | Cause::Edge { cell, .. }
            | Cause::Level { cell, .. }
            | Cause::Start(cell)
            | Cause::Unwritten { cell, .. }
            | Cause::Written { cell, .. }
            | Cause::Delayed(cell) => Some(cell),
        }
    }
}

/// What a cell read.
#[derive(Clone, Debug)]
pub struct Read {
    /// The name of the pin.
    pub pin: &'static str,
    /// What is connected to it: those bits of it that may matter.
    pub slices: Vec<Slice>,
    /// Their value.
    pub value: Value,
    /// The tick at which they had it.
    pub time: u64,
    /// Whether another value of them would have given another result.
    pub matters: bool,
}

/// A pin of a storage cell that never acted.
#[derive(Clone, Debug)]
pub struct Control {
    /// The name of the pin.
    pub pin: &'static str,
    /// What is connected to it.
    pub slices: Vec<Slice>,
    /// Its value at the end.
    pub value: Value,
}

/// A value and what made it.
#[derive(Clone, Debug)]
pub struct Step {
    /// The bits.
    pub slice: Slice,
    /// Their value.
    pub value: Value,
    /// The tick at which they are looked at.
    pub time: u64,
    /// Since when they have had that value.
    pub since: u64,
    /// What made it.
    pub cause: Cause,
    /// What that read.
    pub reads: Vec<Read>,
    /// The controls that could have set what nothing has set.
    pub controls: Vec<Control>,
}

/// Bits beyond which inputs are not tried one by one.
const TRIED: u32 = 2048;

fn is_unknown(bit: Logic) -> bool {
    matches!(bit, Logic::X | Logic::Z)
}

/// The inputs of a cell as they were, pin by pin; pins that are not connected have their defaults.
pub(super) fn inputs(netlist: &Netlist, history: &History, cell: CellId, time: Option<u64>) -> Vec<Value> {
    let kind = &netlist.cell(cell).kind;
    let pins = kind.inputs().iter().enumerate();
    pins.map(|(pin, what)| {
        let slices = netlist.input(cell, pin);
        match time {
            _ if slices.is_empty() => {
                Value::repeat(if what.default { Logic::One } else { Logic::Zero }, kind.input_width(pin))
            }
            Some(time) => history.joined(slices, time),
            // before the first tick
            None => Value::unknown(kind.input_width(pin)),
        }
    })
    .collect()
}

/// How a result is computed of inputs.
enum Rule<'k> {
    /// At once: the output of this number.
    Act(&'k CellKind, usize),
    /// At an edge, with this state before it.
    Edge(&'k CellKind, Value),
}

impl Rule<'_> {
    fn result(&self, ins: &[Vec<Word>], width: u32) -> Vec<Word> {
        let refs: Vec<&[Word]> = ins.iter().map(Vec::as_slice).collect();
        match self {
            Rule::Act(kind, output) => {
                let x = |pin: usize| vec![Word::x(u64::MAX); words(kind.output_width(pin).max(1))];
                let mut outs: Vec<Vec<Word>> = (0..kind.outputs().len()).map(x).collect();
                let mut refs_out: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
                cell::evaluate(kind, &refs, &mut refs_out);
                outs.swap_remove(*output)
            }
            Rule::Edge(kind, state) => {
                let state: Vec<Word> = state.words().collect();
                let mut next = state.clone();
                cell::clocked(kind, &refs, &state, &mut next);
                debug_assert_eq!(next.len(), words(width));
                next
            }
        }
    }
}

fn bit_of(words: &[Word], bit: u32) -> (u64, u64) {
    let word = words[bit as usize / 64];
    (word.v >> (bit % 64) & 1, word.u >> (bit % 64) & 1)
}

fn put(words: &mut [Word], bit: u32, (v, u): (u64, u64)) {
    let word = &mut words[bit as usize / 64];
    let m = 1 << (bit % 64);
    word.v = word.v & !m | v << (bit % 64);
    word.u = word.u & !m | u << (bit % 64);
}

/// Which bits of which pins matter for bits of a result: with another value the result is another. For what is x, only bits that
/// are x or z count; where no single one decides, all of them do.
fn mattering(
    rule: &Rule<'_>,
    pins: &[(usize, u32)],
    ins: &[Value],
    wanted: std::ops::Range<u32>,
    width: u32,
) -> Vec<Vec<bool>> {
    let mut all: Vec<Vec<Word>> = ins.iter().map(|value| value.words().collect()).collect();
    let base = rule.result(&all, width);
    let unknown = wanted.clone().any(|bit| bit_of(&base, bit).1 == 1);
    let of_interest = |bit: &u32| !unknown || bit_of(&base, *bit).1 == 1;
    let bits: Vec<u32> = wanted.filter(of_interest).collect();
    let total: u32 = pins.iter().map(|pin| pin.1).sum();
    let mut found: Vec<Vec<bool>> = ins.iter().map(|value| vec![false; value.width() as usize]).collect();
    let mut candidates = found.clone();
    let mut any = false;
    for &(pin, pin_width) in pins {
        for bit in 0..pin_width {
            if unknown && !is_unknown(ins[pin].bit(bit)) {
                continue;
            }
            candidates[pin][bit as usize] = true;
            if total > TRIED {
                continue;
            }
            let before = bit_of(&all[pin], bit);
            let others: &[(u64, u64)] = if unknown { &[(0, 0), (1, 0)] } else { &[(0, 1)] };
            for other in others {
                put(&mut all[pin], bit, *other);
                let result = rule.result(&all, width);
                if bits.iter().any(|&bit| bit_of(&result, bit) != bit_of(&base, bit)) {
                    (found[pin][bit as usize], any) = (true, true);
                }
            }
            put(&mut all[pin], bit, before);
        }
    }
    if any { found } else { candidates }
}

/// The slices of the bits of a pin that matter, neighbours joined.
pub(super) fn chosen(slices: &[Slice], matter: &[bool]) -> Vec<Slice> {
    let mut found: Vec<Slice> = Vec::new();
    let bits = slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| (s.net, lo)));
    for ((net, lo), _) in bits.zip(matter).filter(|(_, matters)| **matters) {
        match found.last_mut() {
            Some(last) if last.net == net && last.lo + last.width == lo => last.width += 1,
            _ => found.push(Slice { net, lo, width: 1 }),
        }
    }
    found
}

/// What a cell read, with what of it mattered.
fn reads(
    netlist: &Netlist,
    history: &History,
    cell: CellId,
    rule: &Rule<'_>,
    wanted: std::ops::Range<u32>,
    width: u32,
    time: u64,
) -> Vec<Read> {
    let kind = &netlist.cell(cell).kind;
    let ins = inputs(netlist, history, cell, Some(time));
    let pins: Vec<(usize, u32)> = (0..kind.inputs().len())
        .filter(|&pin| !netlist.input(cell, pin).is_empty())
        .filter(|&pin| !(matches!(rule, Rule::Edge(..)) && kind.inputs()[pin].role == Role::Clock))
        .map(|pin| (pin, kind.input_width(pin)))
        .collect();
    let matter = mattering(rule, &pins, &ins, wanted, width);
    let read = |&(pin, _): &(usize, u32)| {
        let all = netlist.input(cell, pin);
        let picked = chosen(all, &matter[pin]);
        let matters = !picked.is_empty();
        let slices = if matters { picked } else { all.to_vec() };
        Read { pin: kind.inputs()[pin].name, value: history.joined(&slices, time), slices, time, matters }
    };
    pins.iter().map(read).collect()
}

/// What made the value of some bits of a net at a tick.
#[must_use]
pub fn explain(netlist: &Netlist, history: &History, slice: Slice, time: u64) -> Step {
    let since = history.since(slice, time);
    let value = history.at(slice, time);
    let mut step = Step { slice, value, time, since, cause: Cause::Undriven, reads: Vec::new(), controls: Vec::new() };
    let (id, output) = match netlist.net(slice.net).driver {
        Driver::Input(signal) => {
            step.cause = Cause::Input(signal);
            return step;
        }
        Driver::Cell(cell, output) => (cell, usize::from(output)),
    };
    let kind = &netlist.cell(id).kind;
    let wanted = slice.lo..slice.lo + slice.width;
    match kind {
        CellKind::Constant(_) if netlist.is_undriven(slice.net) => {}
        CellKind::Constant(_) => step.cause = Cause::Constant(id),
        CellKind::Clock(_) => step.cause = Cause::Clock(id),
        CellKind::Delay { ticks, .. } => {
            step.cause = Cause::Delayed(id);
            step.reads = delayed(netlist, history, id, slice, since.checked_sub(*ticks));
        }
        CellKind::RcDelay(_) => {
            step.cause = Cause::Delayed(id);
            step.reads = delayed(netlist, history, id, slice, Some(since));
        }
        CellKind::Memory(m) => memory_read(netlist, history, id, m, &mut step),
        _ if kind.storage().is_some() && output > 0 => {
            // made of the state at once
            step.cause = Cause::Gate(id);
            let net = netlist.output(id, 0);
            let width = netlist.net(net).width;
            let same = kind.output_width(output) == width;
            let state = if same { Slice { net, ..slice } } else { Slice { net, lo: 0, width } };
            let value = history.at(state, since);
            step.reads = vec![Read { pin: "q", slices: vec![state], value, time: since, matters: true }];
        }
        _ if kind.storage().is_some() => storage(netlist, history, id, output, &mut step),
        _ => {
            step.cause = Cause::Gate(id);
            let rule = Rule::Act(kind, output);
            // a known value is explained by the change that made it, x by what is x now
            let then = if step.value.is_known() { since } else { time };
            step.reads = reads(netlist, history, id, &rule, wanted, kind.output_width(output), then);
        }
    }
    step
}

/// The input of a delay as it was then.
fn delayed(netlist: &Netlist, history: &History, cell: CellId, slice: Slice, then: Option<u64>) -> Vec<Read> {
    let Some(time) = then else { return Vec::new() };
    let width: u32 = netlist.input(cell, 0).iter().map(|s| s.width).sum();
    let matter: Vec<bool> = (0..width).map(|bit| (slice.lo..slice.lo + slice.width).contains(&bit)).collect();
    let slices = chosen(netlist.input(cell, 0), &matter);
    vec![Read { pin: "a", value: history.joined(&slices, time), slices, time, matters: true }]
}

/// Whether a bit had an active edge at a tick.
pub(super) fn is_edge(history: &History, slice: Slice, time: u64, edge: Edge) -> bool {
    if time == 0 {
        return false;
    }
    let (before, after) = (history.at(slice, time - 1).bit(0), history.at(slice, time).bit(0));
    let (from, to) = if edge == Edge::Rising { (Logic::Zero, Logic::One) } else { (Logic::One, Logic::Zero) };
    before != after && !(is_unknown(before) && is_unknown(after)) && (before == from || after == to)
}

/// The active edges of a pin at a tick or before it, the latest first. A change of x to an active level is one; an
/// inactive one is none.
fn edges<'h>(
    netlist: &'h Netlist,
    history: &'h History,
    cell: CellId,
    pin: usize,
    edge: Edge,
    until: u64,
) -> impl Iterator<Item = u64> + 'h {
    let slice = netlist.input(cell, pin).first().copied();
    slice.into_iter().flat_map(move |slice| {
        let bit = Slice { width: 1, ..slice };
        let times = history.times(bit.net).rev().filter(move |time| *time <= until);
        times.filter(move |time| is_edge(history, bit, *time, edge))
    })
}

/// What made the state of a storage cell.
fn storage(netlist: &Netlist, history: &History, cell: CellId, output: usize, step: &mut Step) {
    let kind = &netlist.cell(cell).kind;
    let pins = kind.inputs();
    let time = step.time;
    let wanted = step.slice.lo..step.slice.lo + step.slice.width;
    let width = kind.output_width(output);
    let is_one = |pin: usize, time: u64| {
        let slices = netlist.input(cell, pin);
        !slices.is_empty() && history.joined(slices, time).bit(0) == Logic::One
    };
    let of_role = |role: Role| pins.iter().enumerate().filter(move |(_, pin)| pin.role == role).map(|(pin, _)| pin);
    // what acts now: of several, all are read
    if let Some(pin) = of_role(Role::Level).find(|&pin| is_one(pin, time)) {
        step.cause = Cause::Level { cell, pin };
        step.reads = reads(netlist, history, cell, &Rule::Act(kind, output), wanted, width, time);
        step.reads.retain(|read| read.matters);
        return;
    }
    // what acted last: a level that ended, or an edge that took something
    let level_end = of_role(Role::Level).flat_map(|pin| {
        let slice = netlist.input(cell, pin).first().copied();
        let times = slice.into_iter().flat_map(|s| history.times(s.net).filter(|&t| t <= time && t > 0));
        times.filter(move |&t| is_one(pin, t - 1) && !is_one(pin, t)).map(move |t| (t, pin)).collect::<Vec<_>>()
    });
    let level_end = level_end.max();
    let clock = of_role(Role::Clock).next();
    let mut edge = None;
    if let (Some(clock), Some(active)) = (clock, kind.edge()) {
        for at in edges(netlist, history, cell, clock, active, time) {
            if level_end.is_some_and(|(end, _)| end > at) {
                break;
            }
            let ins = inputs(netlist, history, cell, Some(at - 1));
            let takes = of_role(Role::Enable).any(|pin| ins[pin].bit(0) == Logic::One);
            if takes {
                edge = Some((at, clock));
                break;
            }
        }
    }
    for pin in of_role(Role::Trigger) {
        let last = edges(netlist, history, cell, pin, Edge::Rising, time).next();
        edge = edge.max(last.map(|at| (at, pin)));
    }
    match (edge, level_end) {
        (Some((at, pin)), end) if end.is_none_or(|(end, _)| at >= end) => {
            step.cause = Cause::Edge { cell, pin, time: at };
            let state_net = netlist.output(cell, 0);
            let state = Slice { net: state_net, lo: 0, width: netlist.net(state_net).width };
            let rule = |time: u64| Rule::Edge(kind, history.at(state, time));
            // data that changes with the clock is seen before it, unless an earlier part of the same tick made it
            let took = |then: u64| {
                let ins: Vec<Vec<Word>> =
                    inputs(netlist, history, cell, Some(then)).iter().map(|v| v.words().collect()).collect();
                Value::from_words(&rule(at - 1).result(&ins, state.width), state.width)
            };
            let q = history.at(state, at);
            let then = if took(at - 1) != q && took(at) == q { at } else { at - 1 };
            step.reads = reads(netlist, history, cell, &rule(at - 1), wanted, state.width, then);
        }
        (_, Some((end, pin))) => {
            step.cause = Cause::Level { cell, pin };
            step.reads = reads(netlist, history, cell, &Rule::Act(kind, output), wanted, width, end - 1);
            step.reads.retain(|read| read.matters);
        }
        _ => {
            step.cause = Cause::Start(cell);
            let control = |(pin, what): (usize, &cell::Pin)| {
                let slices = netlist.input(cell, pin);
                let acts = matches!(what.role, Role::Level | Role::Enable | Role::Trigger | Role::Clock);
                (acts && !slices.is_empty()).then(|| Control {
                    pin: what.name,
                    slices: slices.to_vec(),
                    value: history.joined(slices, time),
                })
            };
            step.controls = pins.iter().enumerate().filter_map(control).collect();
        }
    }
}
