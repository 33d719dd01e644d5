//! The modules of `circuits/lib` that the interpolators by differential increments are made of, against arithmetic and
//! against elements.

use crate::support::engines::{self, simulator};
use crate::support::{Rng, folder, load, repository};
use discreta::Input;
use discreta::circuit::Circuit;
use serde_json::{Value, json};

/// A circuit of these cells, with ports for the nets that are named.
fn circuit(name: &str, inputs: &[(&str, u32)], outputs: &[(&str, u32)], cells: &Value) -> Circuit {
    let ports = |list: &[(&str, u32)], direction: &str| {
        let port = |&(name, width): &(&str, u32)| (name.to_owned(), json!({ "direction": direction, "width": width }));
        list.iter().map(port).collect::<Vec<_>>()
    };
    let ports: serde_json::Map<_, _> = ports(inputs, "input").into_iter().chain(ports(outputs, "output")).collect();
    let imports = ["increments", "normalise"].map(|file| repository(&format!("circuits/lib/{file}.json")));
    let file = json!({ "import": imports, "modules": { "module": { "ports": ports, "cells": cells } } });
    load(&folder("dda_modules"), name, &file).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Zeros above the highest 1 of two numbers, doubled as the text doubles them.
fn doublings(mut a: u64, mut b: u64, width: u32) -> u64 {
    let mut n = 0;
    while a >> (width - 1) == 0 && b >> (width - 1) == 0 {
        (a, b, n) = (2 * a, 2 * b, n + 1);
    }
    n
}

#[test]
fn numbers_are_shifted_until_one_has_a_top_bit() {
    let mut compared = 0;
    for width in [2, 3, 4, 5, 6, 7, 8, 9, 16, 17, 31, 32] {
        let n = 32 - (width - 1_u32).leading_zeros();
        let parameters = json!({ "W": width });
        let shift = |a: &str, y: &str| json!({ "type": "shift_left", "parameters": parameters, "connections": { "a": a, "s": "s", "y": y } });
        let cells = json!({
            "normalise": { "type": "normalise", "parameters": parameters, "connections": { "a": "a", "b": "b", "s": "s" } },
            "shift_a": shift("a", "y"),
            "shift_b": shift("b", "z"),
        });
        let circuit = circuit(
            &format!("normalise_{width}"),
            &[("a", width), ("b", width)],
            &[("s", n), ("y", width), ("z", width)],
            &cells,
        );
        let mut sim = simulator(&circuit.netlist);
        let [a, b] = ["a", "b"].map(|name| sim.input(name).unwrap());
        let shown = ["s", "y", "z"].map(|name| sim.probe(name).unwrap());
        let mask = (1_u64 << width) - 1;
        let mut rng = Rng::new(u64::from(width));
        let all = width < 7;
        for k in 0..if all { 1 << (2 * width) } else { 4000 } {
            // else numbers of every length
            let mut number = || rng.word() & mask & (mask >> rng.below(u64::from(width)));
            let values = if all { (k & mask, k >> width) } else { (number(), number()) };
            sim.set(a, values.0);
            sim.set(b, values.1);
            sim.settle().unwrap();
            let s = if values == (0, 0) { (1 << n) - 1 } else { doublings(values.0, values.1, width) };
            let shifted = |v: u64| if v == 0 { 0 } else { (v << s) & mask };
            let expected = [s, shifted(values.0), shifted(values.1)].map(Some);
            assert_eq!(shown.each_ref().map(|p| sim.number(p)), expected, "{values:?} in {width} bits");
            compared += 1;
        }
    }
    println!("{compared} pairs");
    engines::all_ran();
}

#[test]
fn a_summator_is_an_adder_and_a_register() {
    for (width, half) in [(2, 0), (2, 1), (5, 0), (5, 1), (16, 1)] {
        let cells = json!({
            "gates": { "type": "summator", "parameters": { "W": width, "HALF_PRELOAD": half },
                       "connections": { "clk": "clk", "d": "d", "reset": "reset", "q": "q", "co": "co" } },
            "adder": { "type": "adder", "parameters": { "width": width },
                       "connections": { "a": "memory", "b": "d", "y": "sum", "co": "carry" } },
            "memory": { "type": "dff",
                        "parameters": { "width": width, "edge": "falling", "reset_value": half << (width - 1) },
                        "connections": { "clk": "clk", "d": "sum", "reset": "reset", "q": "memory" } },
        });
        let inputs = [("clk", 1), ("d", width), ("reset", 1)];
        let outputs = [("q", width), ("co", 1), ("memory", width), ("sum", width), ("carry", 1)];
        let circuit = circuit(&format!("summator_{width}_{half}"), &inputs, &outputs, &cells);
        let mut sim = simulator(&circuit.netlist);
        let [clk, d, reset]: [Input; 3] = ["clk", "d", "reset"].map(|name| sim.input(name).unwrap());
        let shown = ["q", "memory", "co", "carry"].map(|name| sim.probe(name).unwrap());
        let mut rng = Rng::new(u64::from(width));
        sim.set(clk, 0);
        sim.set(d, 0);
        sim.set(reset, 1);
        for _ in 0..5000 {
            sim.settle().unwrap();
            let [q, memory, co, carry] = shown.each_ref().map(|p| sim.number(p));
            assert!(q.is_some() && (q, co) == (memory, carry), "{width} bits: {q:?} {memory:?} {co:?} {carry:?}");
            sim.set(clk, rng.below(2));
            sim.set(d, rng.below(1 << width));
            sim.set(reset, u64::from(rng.one_in(20)));
        }
    }
    engines::all_ran();
}
