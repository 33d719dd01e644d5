//! Runs an element and a Verilog model of it, given by hand, on the same four-valued stimulus, and compares.
//!
//! The model is a module of its own whose inputs are registers that one assignment sets together, so no race decides
//! what it gives.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use discreta::Value;
use discreta::cell::element;
use serde_json::{Map, json};

use crate::support::engines::{self, simulator};
use crate::support::{Rng, folder, load};

/// An element with parameters, and its model.
pub struct Case {
    pub element: &'static str,
    pub parameters: Vec<(&'static str, String)>,
    /// Inputs: port and width; a port that takes several appears several times.
    pub inputs: Vec<(&'static str, u32)>,
    /// Outputs: port and width.
    pub outputs: Vec<(&'static str, u32)>,
    /// Verilog between the declarations of the inputs and the stimulus; declares the outputs. Members of a port that
    /// takes several are called `in0`, `in1`, ….
    pub model: String,
    /// The clock and the value from which its edges go; it is kept quiet in the first vector and changes often.
    pub clock: Option<(&'static str, bool)>,
    /// The cells of the circuit, where it is not the one cell that `inputs` and `outputs` are the ports of.
    pub cells: Option<serde_json::Value>,
}

pub const VECTORS: usize = 400;

impl Case {
    pub fn new(
        element: &'static str,
        inputs: &[(&'static str, u32)],
        outputs: &[(&'static str, u32)],
        model: &str,
    ) -> Case {
        Case {
            element,
            parameters: vec![],
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            model: model.into(),
            clock: None,
            cells: None,
        }
    }

    pub fn parameter(mut self, name: &'static str, value: impl ToString) -> Case {
        self.parameters.push((name, value.to_string()));
        self
    }

    pub fn clock(mut self, name: &'static str, high_first: bool) -> Case {
        self.clock = Some((name, high_first));
        self
    }

    /// A name for messages, files and seeds.
    fn name(&self) -> String {
        let mut name = self.element.to_string();
        for (_, width) in &self.inputs {
            write!(name, "_{width}").unwrap();
        }
        for (parameter, value) in self.parameters.iter().filter(|(p, _)| *p != "width") {
            write!(name, "_{parameter}_{value}").unwrap();
        }
        name.replace(|c: char| !c.is_ascii_alphanumeric(), "_")
    }

    /// The name of each input in the circuit and in the model.
    fn input_names(&self) -> Vec<String> {
        let several = |port: &str| element(self.element).unwrap().ports.iter().any(|p| p.name == port && p.several);
        let mut number = 0;
        let mut name = |port: &'static str| {
            if several(port) {
                number += 1;
                format!("{port}{}", number - 1)
            } else {
                port.to_string()
            }
        };
        self.inputs.iter().map(|(port, _)| name(port)).collect()
    }

    fn circuit(&self) -> serde_json::Value {
        let names = self.input_names();
        let (mut ports, mut connections) = (Map::new(), Map::new());
        for ((port, width), name) in self.inputs.iter().zip(&names) {
            ports.insert(name.clone(), json!({ "direction": "input", "width": width }));
            if name == port {
                connections.insert((*port).into(), json!(name));
            } else {
                let list = connections.entry(*port).or_insert(json!([])).as_array_mut().unwrap();
                list.push(json!(name));
            }
        }
        for (port, width) in &self.outputs {
            ports.insert((*port).into(), json!({ "direction": "output", "width": width }));
            connections.insert((*port).into(), json!(port));
        }
        let parameters: Map<_, _> = self.parameters.iter().map(|(n, v)| ((*n).to_string(), json!(v))).collect();
        let cell = json!({ "type": self.element, "parameters": parameters, "connections": connections });
        let cells = self.cells.clone().unwrap_or(json!({ "cell": cell }));
        json!({ "modules": { "test": { "ports": ports, "cells": cells } } })
    }

    /// Mostly known values, among them all 0 and all 1; some with a single x or z, some full of them.
    fn stimulus(&self) -> Vec<Vec<Value>> {
        let mut rng = Rng::named(&self.name());
        let quiet = |port: &str| self.clock.filter(|(clock, _)| *clock == port).map(|(_, high)| u64::from(high));
        let mut vectors: Vec<Vec<Value>> =
            vec![self.inputs.iter().map(|&(p, w)| Value::from_u64(quiet(p).unwrap_or(0), w)).collect()];
        for n in 1..VECTORS {
            let unknown = *rng.pick(&[u64::MAX, u64::MAX, u64::MAX, 60, 12, 2]);
            let before = vectors[n - 1].clone();
            let vector = self.inputs.iter().zip(before).map(|(&(port, width), before)| {
                // a control rests at 0 more often than not, or clocks would seldom do anything
                let control = self.clock.is_some() && width == 1 && !["d", "ci", "en", "load", "down"].contains(&port);
                match rng.below(12) {
                    0 => Value::from_u64(0, width),
                    1 if width > 1 => Value::repeat(discreta::Logic::One, width),
                    2 if width > 1 => before,
                    2..=6 if control && quiet(port).is_none() => Value::from_u64(0, 1),
                    _ => rng.four_valued(width, unknown),
                }
            });
            vectors.push(vector.collect());
        }
        vectors
    }

    fn verilog(&self, name: &str) -> String {
        let names = self.input_names();
        let mut text = format!("module {name};\n");
        for ((_, width), name) in self.inputs.iter().zip(&names) {
            writeln!(text, "  reg [{}:0] {name};", width - 1).unwrap();
        }
        let total: u32 = self.inputs.iter().map(|i| i.1).sum();
        let (inputs, outputs): (_, Vec<&str>) = (names.join(", "), self.outputs.iter().map(|o| o.0).collect());
        let outputs = outputs.join(", ");
        writeln!(text, "{}\n  reg [{}:0] v [0:{}];\n  integer n, f;", self.model, total.max(1) - 1, VECTORS - 1)
            .unwrap();
        writeln!(text, "  initial begin\n    $readmemb(\"{name}.in\", v);\n    f = $fopen(\"{name}.out\", \"w\");")
            .unwrap();
        writeln!(text, "    for (n = 0; n < {VECTORS}; n = n + 1) begin").unwrap();
        if total > 0 {
            writeln!(text, "      #1 {{{inputs}}} = v[n];").unwrap();
        }
        writeln!(text, "      #1 $fdisplay(f, \"%b\", {{{outputs}}});\n    end\n    $fclose(f);\n  end\nendmodule")
            .unwrap();
        text
    }

    /// The outputs after each vector.
    fn simulate(&self, folder: &Path, name: &str, vectors: &[Vec<Value>]) -> Vec<String> {
        let circuit = load(folder, name, &self.circuit()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut sim = simulator(&circuit.netlist);
        let inputs: Vec<_> = self.input_names().iter().map(|n| sim.input(n).unwrap()).collect();
        let outputs: Vec<_> = self.outputs.iter().map(|(n, _)| sim.probe(n).unwrap()).collect();
        let step = |vector: &Vec<Value>| {
            for (&input, value) in inputs.iter().zip(vector) {
                sim.set_value(input, value);
            }
            sim.settle().unwrap();
            outputs.iter().map(|o| sim.value(o).bit_string()).collect()
        };
        vectors.iter().map(step).collect()
    }
}

/// Compares all cases; the panic shows the first difference of each that differs.
pub fn compare(family: &str, cases: &[Case]) {
    let folder = folder(&format!("elements_{family}"));
    let names: Vec<String> = cases.iter().map(|c| format!("{}_{family}", c.name())).collect();
    let stimuli: Vec<Vec<Vec<Value>>> = cases.iter().map(Case::stimulus).collect();
    let mut verilog = String::from("`timescale 1ns / 1ns\n");
    for ((case, name), vectors) in cases.iter().zip(&names).zip(&stimuli) {
        verilog += &case.verilog(name);
        let line = |vector: &Vec<Value>| vector.iter().map(Value::bit_string).collect::<String>() + "\n";
        std::fs::write(folder.join(format!("{name}.in")), vectors.iter().map(line).collect::<String>()).unwrap();
        let _ = std::fs::remove_file(folder.join(format!("{name}.out")));
    }
    std::fs::write(folder.join("all.v"), verilog).unwrap();
    run(&folder, "iverilog", &["-g2005", "-o", "all.vvp", "all.v"]);
    run(&folder, "vvp", &["-n", "all.vvp"]);

    let mut faults = String::new();
    for ((case, name), vectors) in cases.iter().zip(&names).zip(&stimuli) {
        let ours = case.simulate(&folder, name, vectors);
        let theirs = std::fs::read_to_string(folder.join(format!("{name}.out"))).unwrap();
        let theirs: Vec<&str> = theirs.lines().collect();
        assert_eq!(theirs.len(), VECTORS, "{name}: Icarus did not finish");
        if let Some(n) = (0..VECTORS).find(|&n| ours[n] != theirs[n]) {
            writeln!(faults, "{name}, vector {n}:").unwrap();
            for k in n.saturating_sub(2)..=n {
                let inputs = case.input_names().into_iter().zip(&vectors[k]);
                let inputs: Vec<_> = inputs.map(|(name, v)| format!("{name}={}", v.bit_string())).collect();
                writeln!(faults, "  {}\n    here {}\n  Icarus {}", inputs.join(" "), ours[k], theirs[k]).unwrap();
            }
        }
    }
    assert!(faults.is_empty(), "{family}: what differs from Icarus\n{faults}");
    println!("{family}: {} cases of {VECTORS} vectors agree", cases.len());
    // what runs many lanes at once takes no memory
    let lanes = cases.iter().any(|case| case.element != "memory");
    engines::ran(1, usize::from(lanes));
}

fn run(folder: &Path, tool: &str, arguments: &[&str]) {
    let output = Command::new(tool).args(arguments).current_dir(folder).output();
    let output = output.unwrap_or_else(|e| {
        panic!("{tool}: {e}. This test compares with Icarus Verilog: install it by `apt-get install iverilog`")
    });
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{tool} {}: {text}", arguments.join(" "));
}
