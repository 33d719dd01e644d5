//! The modules of `circuits/lib`, built of gates and flip-flops, against the elements that they equal: both stand in one
//! circuit, read the same inputs, and have to give the same outputs.

use std::collections::HashMap;

use crate::support::Rng;
use crate::support::engines::{self, Sim, simulator};
use crate::support::pairs::*;
use discreta::circuit::Circuit;
use discreta::{Input, Logic, Probe, Value};

/// The two of a pair, running in lock-step.
struct Bench {
    sim: Sim,
    inputs: Vec<(&'static str, Input, u32)>,
    /// Output of the gates and of the element.
    outputs: Vec<(&'static str, Probe, Probe)>,
    now: HashMap<&'static str, u64>,
    compared: usize,
}

impl Bench {
    fn new(pair: &Pair, circuit: &Circuit) -> Bench {
        let sim = simulator(&circuit.netlist);
        let inputs = pair.inputs.iter().map(|&(n, w)| (n, sim.input(n).unwrap(), w)).collect();
        let output = |of: &str, n: &str| sim.probe(&format!("{of}_{n}")).unwrap();
        let outputs = pair.outputs.iter().map(|&(n, _)| (n, output("gates", n), output("element", n))).collect();
        Bench { sim, inputs, outputs, now: HashMap::new(), compared: 0 }
    }

    fn set(&mut self, values: &[(&'static str, u64)]) {
        for &(name, value) in values {
            let input = self.inputs.iter().find(|i| i.0 == name).unwrap().1;
            self.sim.set(input, value);
            self.now.insert(name, value);
        }
    }

    /// Sets several inputs at one time and compares; both sides have to be known.
    fn apply(&mut self, values: &[(&'static str, u64)]) {
        self.set(values);
        self.sim.settle().unwrap();
        self.compare();
    }

    fn compare(&mut self) {
        for (name, gates, element) in &self.outputs {
            let (gates, element) = (self.sim.value(gates), self.sim.value(element));
            assert!(gates.is_known() && gates == element, "{name}: {gates} of gates, {element}; {:?}", self.now);
        }
        self.compared += 1;
    }

    /// The inputs' values from consecutive bits of a number.
    fn split(&self, mut bits: u64) -> Vec<(&'static str, u64)> {
        let mut next = |width: u32| {
            let value = bits & ((1 << width) - 1);
            bits >>= width;
            value
        };
        self.inputs.iter().map(|&(name, _, width)| (name, next(width))).collect()
    }
}

#[test]
fn combinational_modules_equal_their_elements_for_every_input() {
    let mut pairs = vec![half_adder(), full_adder(), adder(8), subtractor(8)];
    for w in 1..=5 {
        pairs.extend([adder(w), subtractor(w), negate(w), decrement(w), zero_detect(w), bus_mux(w)]);
    }
    pairs.extend([negate(16), zero_detect(16), bus_mux(7)]);
    pairs.extend([(1, 1), (1, 4), (4, 1), (2, 3), (5, 4), (8, 8)].map(|(a, b)| multiplier(a, b)));
    pairs.extend([(1, 2), (4, 3), (6, 6)].map(|(a, b)| signed_multiplier(a, b)));
    let mut compared = 0;
    for pair in &pairs {
        let circuit = pair.circuit();
        let mut bench = Bench::new(pair, &circuit);
        for bits in 0..1 << pair.bits() {
            bench.apply(&bench.split(bits));
        }
        compared += bench.compared;
    }
    println!("{} modules, {compared} inputs", pairs.len());
    engines::ran(1, 1);
}

#[test]
fn wide_combinational_modules_equal_their_elements_for_random_inputs() {
    for pair in [
        adder(32),
        subtractor(31),
        negate(50),
        decrement(40),
        zero_detect(60),
        bus_mux(30),
        adder(20),
        multiplier(31, 9),
        signed_multiplier(17, 13),
    ] {
        let circuit = pair.circuit();
        let mut bench = Bench::new(&pair, &circuit);
        let mut rng = Rng::named(pair.module);
        for _ in 0..10_000 {
            let values: Vec<_> = pair
                .inputs
                .iter()
                .map(|&(n, w)| {
                    (n, *rng.pick(&[0, u64::MAX, 1, 1 << (w - 1)]) ^ if rng.one_in(3) { 0 } else { rng.word() })
                })
                .collect();
            bench.apply(&values);
        }
    }
    engines::ran(1, 1);
}

/// With x among the inputs the gates of these are as the elements are; an adder of gates makes x of the bits alone that
/// depend on it, where the element makes all of them x.
#[test]
fn combinational_modules_take_unknowns_as_documented() {
    for pair in
        [half_adder(), full_adder(), zero_detect(7), bus_mux(5), adder(7), subtractor(7), negate(7), multiplier(4, 3)]
    {
        let exact = ["half_adder_gates", "full_adder_gates", "zero_detect", "bus_mux"].contains(&pair.module);
        let circuit = pair.circuit();
        let mut bench = Bench::new(&pair, &circuit);
        let mut rng = Rng::named(pair.module);
        let mut more_known = 0;
        for _ in 0..5000 {
            let density = 2 + rng.below(8);
            for &(_, input, width) in &bench.inputs {
                bench.sim.set_value(input, &rng.four_valued(width, density));
            }
            bench.sim.settle().unwrap();
            for (name, gates, element) in &bench.outputs {
                let (gates, element) = (bench.sim.value(gates), bench.sim.value(element));
                if exact {
                    assert_eq!(gates, element, "{}.{name}", pair.module);
                }
                for i in 0..gates.width() {
                    let known = matches!(element.bit(i), Logic::Zero | Logic::One);
                    assert!(!known || gates.bit(i) == element.bit(i), "{}.{name}: {gates} {element}", pair.module);
                    more_known += usize::from(!known && matches!(gates.bit(i), Logic::Zero | Logic::One));
                }
            }
        }
        assert_eq!(more_known == 0, exact, "{}", pair.module);
    }
    engines::ran(1, 1);
}

/// From every state and level of the clock to every input at once, and again with the clock last.
fn every_transition(pair: &Pair, mut to_state: impl FnMut(&mut Bench, u64, u64)) -> usize {
    let circuit = pair.circuit();
    let mut bench = Bench::new(pair, &circuit);
    let width = pair.outputs[0].1;
    let others: u32 = pair.bits() - 1;
    assert_eq!(pair.inputs[0].0, "clk");
    for state in 0..1u64 << width {
        for clk in [0, 1] {
            for bits in 0..1u64 << (others + 1) {
                for clock_last in [false, true] {
                    to_state(&mut bench, state, clk);
                    assert_eq!(bench.sim.number(&bench.outputs[0].2), Some(state));
                    let values = bench.split(bits);
                    if clock_last {
                        bench.apply(&values[1..]);
                    }
                    bench.apply(&values);
                }
            }
        }
    }
    bench.compared
}

/// Through the asynchronous load, which leaves the state when it ends.
fn load_state(bench: &mut Bench, state: u64, clk: u64) {
    let quiet = ["load", "en", "reset"].into_iter().filter(|n| bench.inputs.iter().any(|i| i.0 == *n));
    let quiet: Vec<_> = quiet.map(|n| (n, 0)).collect();
    bench.apply(&[&[("clk", clk), ("d", state), ("async_load", 1)], &quiet[..]].concat());
    bench.apply(&[("async_load", 0)]);
}

#[test]
fn registers_and_counters_make_every_transition_as_their_elements_do() {
    let mut compared = 0;
    for falling in [0, 1] {
        for w in 1..=4 {
            compared += every_transition(&register(w, falling), load_state);
            compared += every_transition(&counter(w, 0, falling), load_state);
            compared += every_transition(&counter(w, 1, falling), load_state);
        }
    }
    println!("{compared} comparisons");
    engines::ran(1, 1);
}

#[test]
fn flip_flops_make_every_transition_as_their_element_does() {
    for falling in [0, 1] {
        every_transition(&dff(falling), |bench, state, clk| {
            bench.apply(&[("clk", clk), ("d", 0), ("en", 0), ("set", state), ("reset", 1 - state)]);
            bench.apply(&[("set", 0), ("reset", 0)]);
        });
    }
    engines::ran(1, 1);
}

/// From every state, open and closed, to every input at once.
#[test]
fn latches_make_every_transition_as_their_element_does() {
    for w in 1..=4 {
        let pair = latch(w);
        let circuit = pair.circuit();
        let mut bench = Bench::new(&pair, &circuit);
        for state in 0..1 << w {
            for path in 0..1u64 << (2 * (w + 1)) {
                bench.apply(&[("en", 1), ("d", state)]);
                bench.apply(&[("en", 0)]);
                bench.apply(&bench.split(path));
                bench.apply(&bench.split(path >> (w + 1)));
            }
        }
    }
    engines::ran(1, 1);
}

#[test]
fn accumulators_make_every_transition_as_their_elements_do() {
    let mut compared = 0;
    for falling in [0, 1] {
        for w in 1..=4 {
            compared += every_transition(&accumulator(w, falling), |bench, state, clk| {
                // from 0, one addition
                bench.apply(&[("reset", 1), ("en", 1), ("ci", 0), ("d", state), ("clk", falling)]);
                bench.apply(&[("reset", 0)]);
                bench.apply(&[("clk", 1 - falling)]);
                bench.apply(&[("en", 0)]);
                bench.apply(&[("clk", clk)]);
            });
        }
    }
    println!("{compared} comparisons");
    engines::ran(1, 1);
}

#[test]
fn the_flip_flop_of_nor_gates_is_the_sr_element() {
    let pair = sr();
    let circuit = pair.circuit();
    // from each state that a set or reset leaves, through every pair of moves
    let levels = [(0, 0), (0, 1), (1, 0), (1, 1)];
    for first in [(1, 0), (0, 1)] {
        for path in 0..4usize.pow(4) {
            let mut bench = Bench::new(&pair, &circuit);
            bench.apply(&[("s", first.0), ("r", first.1)]);
            bench.apply(&[("s", 0), ("r", 0)]);
            let mut before = (0, 0);
            for k in 0..4 {
                let now = levels[path / 4usize.pow(k) % 4];
                bench.set(&[("s", now.0), ("r", now.1)]);
                let settled = bench.sim.settle();
                if before == (1, 1) && now == (0, 0) {
                    // both gates let go at once: a race, not a state
                    assert!(settled.is_err(), "the race settles");
                    break;
                }
                settled.unwrap();
                if now == (1, 1) {
                    let read = |p: &Probe| bench.sim.number(p);
                    let [(_, q, q_element), (_, qn, qn_element)] = &bench.outputs[..] else { panic!() };
                    assert_eq!([q, q_element, qn, qn_element].map(read), [Some(0), Some(0), Some(0), Some(1)]);
                } else {
                    bench.compare();
                }
                before = now;
            }
        }
    }
    engines::ran(1, 1);
}

#[test]
fn sequential_modules_equal_their_elements_in_long_random_runs() {
    let pairs = |w| {
        let mut pairs = Vec::new();
        for falling in [0, 1] {
            pairs.extend([register(w, falling), accumulator(w, falling)]);
            pairs.extend([counter(w, 0, falling), counter(w, 1, falling)]);
        }
        pairs
    };
    for pair in pairs(8).into_iter().chain(pairs(16)) {
        let circuit = pair.circuit();
        let mut bench = Bench::new(&pair, &circuit);
        let mut rng = Rng::named(pair.module);
        let controls: Vec<_> = pair.inputs.iter().filter(|i| i.1 == 1).map(|i| (i.0, 0)).collect();
        let start = [&controls[..], &[("d", 0)]].concat();
        bench.set(&start);
        bench.sim.settle().unwrap();
        let clear = if pair.module == "accumulator_gates" { "reset" } else { "async_load" };
        bench.apply(&[(clear, 1)]);
        for _ in 0..20_000 {
            // mostly the clock, now and then several inputs at one time, loads and resets held for a while
            let mut values = vec![("clk", rng.word() & 1)];
            for &(name, width) in &pair.inputs[1..] {
                let rare = ["async_load", "reset"].contains(&name);
                if rng.one_in(if rare { 8 } else { 3 }) {
                    let value = if rare { u64::from(rng.one_in(3)) } else { rng.word() & ((1 << width) - 1) };
                    values.push((name, value));
                }
            }
            bench.apply(&values);
        }
    }
    engines::ran(1, 1);
}

/// With unknowns on the data, and known controls: where both give a known bit it is the same. (An x on a control counts
/// as inactive where it meets a flip-flop, which is not the same place in both, so nothing is claimed about it.)
#[test]
fn sequential_modules_do_not_contradict_their_elements_about_unknowns() {
    for pair in [register(4, 0), counter(4, 0, 0), counter(4, 1, 1), accumulator(4, 0)] {
        let circuit = pair.circuit();
        let mut bench = Bench::new(&pair, &circuit);
        let mut rng = Rng::named(pair.module);
        let mut known = 0;
        for _ in 0..20_000 {
            for &(name, input, width) in &bench.inputs {
                let value = match name {
                    "clk" => rng.known(1),
                    _ if rng.one_in(2) => continue,
                    "reset" | "async_load" if !rng.one_in(8) => Value::from_u64(0, 1),
                    "d" | "ci" => rng.four_valued(width, 12),
                    _ => rng.known(1),
                };
                bench.sim.set_value(input, &value);
            }
            bench.sim.settle().unwrap();
            for (name, gates, element) in &bench.outputs {
                let (gates, element) = (bench.sim.value(gates), bench.sim.value(element));
                for i in 0..gates.width() {
                    let (g, e) = (gates.bit(i), element.bit(i));
                    let both = [g, e].iter().all(|b| matches!(b, Logic::Zero | Logic::One));
                    assert!(!both || g == e, "{}.{name}: gates {gates}, element {element}", pair.module);
                    known += usize::from(both);
                }
            }
        }
        assert!(known > 10_000, "{}: {known} known bits test little", pair.module);
    }
    engines::ran(1, 1);
}
