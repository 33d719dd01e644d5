//! The modules of `circuits/lib` that are built of gates and flip-flops, each beside the element that it equals: both
//! stand in one circuit and read the same inputs.

use discreta::circuit::Circuit;
use serde_json::{Map, json};

use super::{folder, load, repository};

/// What stands side by side: a module whose ports are named as those of the element, and the element's cell.
pub struct Pair {
    pub module: &'static str,
    pub parameters: serde_json::Value,
    pub inputs: Vec<(&'static str, u32)>,
    pub outputs: Vec<(&'static str, u32)>,
    pub element: serde_json::Value,
}

impl Pair {
    /// An element whose ports are named as those of the module.
    pub fn new(
        module: &'static str,
        parameters: serde_json::Value,
        inputs: &[(&'static str, u32)],
        outputs: &[(&'static str, u32)],
        element: &str,
        element_parameters: serde_json::Value,
    ) -> Pair {
        let own: Map<_, _> = inputs.iter().map(|(n, _)| ((*n).to_string(), json!(n))).collect();
        let element = json!({ "type": element, "parameters": element_parameters, "connections": own });
        Pair { module, parameters, inputs: inputs.to_vec(), outputs: outputs.to_vec(), element }
    }

    /// With the element's inputs connected otherwise.
    pub fn connected(mut self, connections: serde_json::Value) -> Pair {
        self.element["connections"] = connections;
        self
    }

    pub fn circuit(&self) -> Circuit {
        let mut ports: Map<_, _> =
            self.inputs.iter().map(|(n, w)| ((*n).to_string(), json!({ "direction": "input", "width": w }))).collect();
        let mut connections: Map<_, _> = self.inputs.iter().map(|(n, _)| ((*n).to_string(), json!(n))).collect();
        let mut element = self.element.clone();
        for (name, width) in &self.outputs {
            for (of, cell) in
                [("gates", &mut connections), ("element", element["connections"].as_object_mut().unwrap())]
            {
                ports.insert(format!("{of}_{name}"), json!({ "direction": "output", "width": width }));
                cell.insert((*name).to_string(), json!(format!("{of}_{name}")));
            }
        }
        let gates = json!({ "type": self.module, "parameters": self.parameters, "connections": connections });
        let imports = ["arithmetic", "increments", "multiplexers", "multiplier", "storage"]
            .map(|f| repository(&format!("circuits/lib/{f}.json")));
        let module = json!({ "ports": ports, "cells": { "gates": gates, "element": element } });
        let file = json!({ "import": imports, "modules": { "pair": module } });
        let name = format!("{}_{}", self.module, self.parameters).replace(|c: char| !c.is_alphanumeric(), "_");
        load(&folder("gate_modules"), &name, &file).unwrap_or_else(|e| panic!("{}: {e}", self.module))
    }

    pub fn bits(&self) -> u32 {
        self.inputs.iter().map(|i| i.1).sum()
    }
}

pub fn half_adder() -> Pair {
    let (ins, outs) = ([("a", 1), ("b", 1)], [("s", 1), ("co", 1)]);
    Pair::new("half_adder_gates", json!({}), &ins, &outs, "half_adder", json!({}))
}

pub fn full_adder() -> Pair {
    let (ins, outs) = ([("a", 1), ("b", 1), ("ci", 1)], [("s", 1), ("co", 1)]);
    Pair::new("full_adder_gates", json!({}), &ins, &outs, "full_adder", json!({}))
}

pub fn adder(w: u32) -> Pair {
    let (ins, outs) = ([("a", w), ("b", w), ("ci", 1)], [("y", w), ("co", 1)]);
    Pair::new("ripple_adder", json!({ "W": w }), &ins, &outs, "adder", json!({ "width": w }))
}

pub fn subtractor(w: u32) -> Pair {
    let (ins, outs) = ([("a", w), ("b", w), ("bi", 1)], [("y", w), ("bo", 1)]);
    Pair::new("ripple_subtractor", json!({ "W": w }), &ins, &outs, "subtractor", json!({ "width": w }))
}

pub fn negate(w: u32) -> Pair {
    let pair = Pair::new("negate", json!({ "W": w }), &[("a", w)], &[("y", w)], "subtractor", json!({ "width": w }));
    pair.connected(json!({ "a": 0, "b": "a" }))
}

pub fn decrement(w: u32) -> Pair {
    let ins = [("a", w), ("bi", 1)];
    let pair = Pair::new("decrement", json!({ "W": w }), &ins, &[("y", w)], "subtractor", json!({ "width": w }));
    pair.connected(json!({ "a": "a", "b": 0, "bi": "bi" }))
}

pub fn zero_detect(w: u32) -> Pair {
    Pair::new("zero_detect", json!({ "W": w }), &[("a", w)], &[("y", 1)], "is_zero", json!({ "width": w }))
}

pub fn signed_multiplier(a: u32, b: u32) -> Pair {
    let element = json!({ "a_width": a, "b_width": b, "signed": 1 });
    let ins = [("a", a), ("b", b)];
    Pair::new("signed_multiplier_gates", json!({ "A": a, "B": b }), &ins, &[("y", a + b)], "multiplier", element)
}

pub fn bus_mux(w: u32) -> Pair {
    let ins = [("a", w), ("b", w), ("sel_a", 1), ("sel_b", 1)];
    let pair = Pair::new("bus_mux", json!({ "W": w }), &ins, &[("y", w)], "and_or", json!({ "width": w }));
    pair.connected(json!({ "in": ["a", "b"], "sel": ["sel_b", "sel_a"] }))
}

pub fn edge(falling: u64) -> &'static str {
    if falling == 1 { "falling" } else { "rising" }
}

pub fn register(w: u32, falling: u64) -> Pair {
    let ins = [("clk", 1), ("d", w), ("load", 1), ("async_load", 1), ("reset", 1)];
    let element = json!({ "width": w, "edge": edge(falling) });
    Pair::new("register_gates", json!({ "W": w, "FALLING": falling }), &ins, &[("q", w)], "register", element)
}

pub fn counter(w: u32, down: u64, falling: u64) -> Pair {
    let (ins, outs) = ([("clk", 1), ("en", 1), ("d", w), ("async_load", 1)], [("q", w), ("zero", 1)]);
    let element = json!({ "width": w, "edge": edge(falling) });
    let module = json!({ "W": w, "DOWN": down, "FALLING": falling });
    let pair = Pair::new("counter_gates", module, &ins, &outs, "counter", element);
    let down = format!("1'd{down}");
    pair.connected(json!({ "clk": "clk", "en": "en", "d": "d", "async_load": "async_load", "down": down }))
}

pub fn accumulator(w: u32, falling: u64) -> Pair {
    let ins = [("clk", 1), ("d", w), ("ci", 1), ("en", 1), ("reset", 1)];
    let (module, element) = (json!({ "W": w, "FALLING": falling }), json!({ "width": w, "edge": edge(falling) }));
    Pair::new("accumulator_gates", module, &ins, &[("q", w), ("co", 1)], "accumulator", element)
}

pub fn latch(w: u32) -> Pair {
    Pair::new("latch_gates", json!({ "W": w }), &[("en", 1), ("d", w)], &[("q", w)], "latch", json!({ "width": w }))
}

/// Of one bit: the element's set and reset are those of all its bits.
pub fn dff(falling: u64) -> Pair {
    let ins = [("clk", 1), ("d", 1), ("en", 1), ("set", 1), ("reset", 1)];
    let element = json!({ "edge": edge(falling) });
    Pair::new("dff_gates", json!({ "W": 1, "FALLING": falling }), &ins, &[("q", 1)], "dff", element)
}

pub fn multiplier(a: u32, b: u32) -> Pair {
    let element = json!({ "a_width": a, "b_width": b });
    Pair::new(
        "multiplier_gates",
        json!({ "A": a, "B": b }),
        &[("a", a), ("b", b)],
        &[("y", a + b)],
        "multiplier",
        element,
    )
}

pub fn sr() -> Pair {
    Pair::new("sr_nor", json!({}), &[("s", 1), ("r", 1)], &[("q", 1), ("qn", 1)], "sr", json!({}))
}

/// Without half of its volume in it.
pub fn summator(w: u32) -> Pair {
    let (ins, outs) = ([("clk", 1), ("d", w), ("reset", 1)], [("q", w), ("co", 1)]);
    let element = json!({ "width": w, "edge": "falling" });
    Pair::new("summator", json!({ "W": w }), &ins, &outs, "accumulator", element)
}
