//! What `Stats` counts, against what one counts by hand: the circuits of `circuits/lib`, whose gates one can add up, and
//! small ones for each definition.

use crate::support::{folder, load, repository};
use discreta::cell::{CellKind, Edge, GateOp, Parts, elements};
use discreta::netlist::depth::{End, Level};
use discreta::netlist::{Builder, Netlist, Stats};
use serde_json::{Value, json};

/// A module of the library, with parameters, as the one cell of a circuit.
fn library(module: &str, parameters: &Value, inputs: &[(&str, u64)], outputs: &[(&str, u64)]) -> Netlist {
    let port = |direction: &'static str| {
        move |&(name, width): &(&str, u64)| (name.to_owned(), json!({ "direction": direction, "width": width }))
    };
    let ports: serde_json::Map<_, _> =
        inputs.iter().map(port("input")).chain(outputs.iter().map(port("output"))).collect();
    let connections: serde_json::Map<_, _> =
        inputs.iter().chain(outputs).map(|(name, _)| ((*name).to_owned(), json!(name))).collect();
    let cell = json!({ "type": module, "parameters": parameters, "connections": connections });
    let imports = ["arithmetic", "multiplexers", "storage"].map(|f| repository(&format!("circuits/lib/{f}.json")));
    let file = json!({ "import": imports, "modules": { "top": { "ports": ports, "cells": { "it": cell } } } });
    load(&folder("stats"), module, &file).unwrap().netlist
}

/// A circuit of one module.
fn circuit(name: &str, body: &Value) -> Netlist {
    load(&folder("stats"), name, &json!({ "modules": { name: body } })).unwrap().netlist
}

fn ripple_adder(width: u64) -> Netlist {
    let inputs = [("a", width), ("b", width), ("ci", 1)];
    library("ripple_adder", &json!({ "W": width }), &inputs, &[("y", width), ("co", 1)])
}

/// Two half adders of OR, AND, AND and NOT, and an OR. From a to s: OR or AND and NOT, then AND, twice.
#[test]
fn a_full_adder_is_seven_gates_and_six_levels() {
    let ports = [("a", 1), ("b", 1), ("ci", 1)];
    let s = Stats::of(&library("full_adder_gates", &json!({}), &ports, &[("s", 1), ("co", 1)]));
    assert_eq!((s.equipment.gates, s.equipment.two_input_gates, s.equipment.inverters), (7, 7, 2));
    assert_eq!((s.depth.levels, s.depth.unit), (6, Level::Gates));
    let path = s.depth.path.unwrap();
    assert_eq!(path.start, End { pin: None, net: "a".into() });
    assert_eq!(path.end, End { pin: None, net: "s".into() });
    let cells: Vec<_> = path.steps.iter().map(|s| (s.level, s.cell.as_str())).collect();
    assert_eq!(
        cells,
        [
            (1, "it.first.and1"),
            (2, "it.first.not1"),
            (3, "it.first.and2"),
            (4, "it.second.and1"),
            (5, "it.second.not1"),
            (6, "it.second.and2"),
        ]
    );
    let modules: Vec<_> = s.modules.iter().map(|m| (m.module.as_str(), m.number)).collect();
    assert_eq!(modules, [("full_adder_gates", 1), ("half_adder_gates", 2)]);
}

/// a ^ b takes 3 levels, an AND and an OR more make the first carry 5, each further carry 2 more, and the highest sum
/// 3 more than the carry into its bit: 2(W - 1) + 3 + 3. Taken net by net, rather than bit by bit, it would be a loop.
/// Yosys 0.23 counts the same gates (`stat`) and levels (`ltp -noff`) in the same adder in Verilog, at 1, 4, 8 and 16 bits.
#[test]
fn a_ripple_adder_is_as_deep_as_its_carry_is_long() {
    for width in 1..=64 {
        let s = Stats::of(&ripple_adder(width));
        assert_eq!(u64::from(s.depth.levels), 2 * width + 4, "{width} bits");
        assert_eq!(s.equipment.gates, 7 * width);
        assert_eq!(s.equipment.inverters, 2 * width);
        assert_eq!(s.equipment.buffers, 2);
        assert_eq!(
            (s.inputs, s.outputs),
            (Parts { number: 3, bits: 2 * width + 1 }, Parts { number: 2, bits: width + 1 })
        );
        assert!(s.depth.loops.is_empty());
    }
}

/// The carry ripples through the bits of one word: each bit of the AND reads the one below.
#[test]
fn a_word_that_reads_its_own_lower_bits_is_no_loop() {
    let s = Stats::of(&circuit(
        "chain",
        &json!({
            "allow": ["combinational-loop"],
            "ports": { "a": { "direction": "input", "width": 8 }, "y": { "direction": "output", "width": 8 } },
            "cells": {
                "g": { "type": "and", "parameters": { "width": 8 }, "connections": { "in": ["a", ["y[6:0]", "a[0]"]], "y": "y" } }
            }
        }),
    ));
    assert_eq!((s.depth.levels, s.depth.loops.len()), (8, 0));
    assert_eq!(s.depth.path.unwrap().steps.len(), 8);
    assert_eq!(s.equipment.gates, 8);
}

/// Two NORs are one flip-flop, which begins and ends a way; a ring of an odd number is a loop and one level.
#[test]
fn feedback_is_a_flip_flop_or_a_loop() {
    let s = Stats::of(&library("sr_nor", &json!({}), &[("s", 1), ("r", 1)], &[("q", 1), ("qn", 1)]));
    assert_eq!((s.equipment.gates, s.depth.sr_of_gates, s.depth.levels), (2, 1, 0));
    assert!(s.depth.loops.is_empty());

    let s = Stats::of(&circuit(
        "ring",
        &json!({
            "allow": ["combinational-loop"],
            "ports": { "start": { "direction": "input" }, "y": { "direction": "output" } },
            "nets": { "p": 1, "q": 1, "r": 1, "go": 1 },
            "cells": {
                "not0": { "type": "not", "connections": { "a": "start", "y": "go" } },
                "nand1": { "type": "nand", "connections": { "in": ["go", "r"], "y": "p" } },
                "not1": { "type": "not", "connections": { "a": "p", "y": "q" } },
                "not2": { "type": "not", "connections": { "a": "q", "y": "r" } },
                "not3": { "type": "not", "connections": { "a": "r", "y": "y" } }
            }
        }),
    ));
    assert_eq!(s.depth.loops, [["nand1", "not1", "not2"]]);
    assert_eq!((s.depth.levels, s.depth.sr_of_gates), (3, 0));
}

/// The set input of an SR flip-flop of wide NORs is reached through one gate, and what it holds goes through another.
#[test]
fn ways_end_and_begin_at_a_flip_flop_of_gates() {
    let s = Stats::of(&circuit(
        "sr_wide",
        &json!({
            "allow": ["combinational-loop"],
            "ports": {
                "a": { "direction": "input" },
                "r": { "direction": "input", "width": 2 },
                "y": { "direction": "output", "width": 2 }
            },
            "nets": { "b": 1, "c": 1, "q": 2, "qn": 2 },
            "cells": {
                "not1": { "type": "not", "connections": { "a": "a", "y": "b" } },
                "not2": { "type": "not", "connections": { "a": "b", "y": "c" } },
                "nor1": { "type": "nor", "parameters": { "width": 2 }, "connections": { "in": ["r", "qn"], "y": "q" } },
                "nor2": { "type": "nor", "parameters": { "width": 2 }, "connections": { "in": ["2{c}", "q"], "y": "qn" } },
                "not3": { "type": "not", "parameters": { "width": 2 }, "connections": { "a": "q", "y": "y" } }
            }
        }),
    ));
    assert_eq!((s.depth.sr_of_gates, s.depth.levels), (2, 2));
    let path = s.depth.path.unwrap();
    assert_eq!(path.end, End { pin: Some("nor2.in[0]".into()), net: "c".into() });
}

/// An AND with a constant 0 is a gate that one may count, but it carries nothing.
#[test]
fn what_constants_decide_is_counted_and_is_on_no_way() {
    let s = Stats::of(&circuit(
        "tied",
        &json!({
            "ports": { "clk": { "direction": "input" }, "a": { "direction": "input" }, "q": { "direction": "output" } },
            "nets": { "n": 1, "gated": 1, "d": 1 },
            "cells": {
                "not1": { "type": "not", "connections": { "a": "a", "y": "n" } },
                "and1": { "type": "and", "connections": { "in": ["n", "1'b0"], "y": "gated" } },
                "or1": { "type": "or", "connections": { "in": ["gated", "a"], "y": "d" } },
                "ff": { "type": "dff", "connections": { "clk": "clk", "d": "d", "q": "q" } }
            }
        }),
    ));
    assert_eq!((s.equipment.gates, s.constant_gates, s.equipment.inverters), (2, 1, 1));
    let path = s.depth.path.unwrap();
    // not a → not1 → and1 → or1
    assert_eq!((s.depth.levels, path.steps.len(), path.start.net.as_str()), (1, 1, "a"));
    assert_eq!(path.end, End { pin: Some("ff.d".into()), net: "d".into() });
}

/// Adders are one level each; the zero flag of a counter and the carry of an accumulator are logic behind their state.
#[test]
fn elements_are_levels_of_their_own() {
    let s = Stats::of(&circuit(
        "words",
        &json!({
            "ports": {
                "clk": { "direction": "input" },
                "a": { "direction": "input", "width": 4 },
                "y": { "direction": "output", "width": 4 },
                "z": { "direction": "output" }
            },
            "nets": { "s": 4, "t": 4, "c": 1, "n": 1, "zero": 1 },
            "cells": {
                "add1": { "type": "adder", "parameters": { "width": 4 }, "connections": { "a": "a", "b": "a", "y": "s" } },
                "add2": { "type": "add_sub", "parameters": { "width": 4 }, "connections": { "a": "s", "b": "a", "sub": "zero", "y": "t" } },
                "acc": { "type": "accumulator", "parameters": { "width": 4, "edge": "falling" }, "connections": { "clk": "n", "d": "t", "q": "y", "co": "c" } },
                "inv": { "type": "not", "connections": { "a": "clk", "y": "n" } },
                "count": { "type": "counter", "parameters": { "width": 3 }, "connections": { "clk": "clk", "zero": "zero" } },
                "and1": { "type": "and", "connections": { "in": ["c", "zero"], "y": "z" } }
            }
        }),
    ));
    // a → add1 → add2 → acc.co → and1
    assert_eq!((s.depth.levels, s.depth.unit), (4, Level::Elements));
    let cells: Vec<_> = s.depth.path.unwrap().steps.iter().map(|s| s.cell.clone()).collect();
    assert_eq!(cells, ["add1", "add2", "acc", "and1"]);
    let e = s.equipment;
    assert_eq!((e.adders, e.flip_flops), (Parts { number: 2, bits: 8 }, 7));
    assert_eq!((e.accumulators, e.counters), (Parts { number: 1, bits: 4 }, Parts { number: 1, bits: 3 }));
    // the accumulator falls with the inverse of clk, and so rises with clk
    let clocks: Vec<_> = s.clocks.iter().map(|c| (c.net.as_str(), c.edge, c.flip_flops)).collect();
    assert_eq!(clocks, [("clk", Edge::Rising, 7)]);
}

/// Three registers of 5 bits and four counters of 4.
#[test]
fn the_line_of_registers_has_its_counters() {
    let file = repository("circuits/evaluation/line.json");
    let stats = Stats::of(&discreta::circuit::load_with(file, &[("W", 4)]).unwrap().netlist);
    assert_eq!((stats.equipment.counters.number, stats.equipment.flip_flops), (4, 3 * 5 + 4 * 4));
}

/// Every module of line_gates by its gates: registers 6 a bit, negate 3 a bit but the lowest, the multiplexer 3, the
/// adder 7, counters 5 and a gate for zero, sr_nor 2, three gates beside them.
#[test]
fn the_line_of_gates_is_the_sum_of_its_modules() {
    for width in [1, 2, 8, 16] {
        let file = repository("circuits/evaluation/line_gates.json");
        let netlist = discreta::circuit::load_with(file, &[("W", width)]).unwrap().netlist;
        let s = Stats::of(&netlist);
        let w = width as u64;
        // for one bit, zero is a NOT
        let zero = if w == 1 { 0 } else { 4 };
        let gates = 3 * 6 * (w + 1) + 3 * w + 3 * (w + 1) + 7 * (w + 1) + 4 * 5 * w + zero + 2 * 2 + 3;
        assert_eq!(s.equipment.gates, gates, "{width} bits");
        assert_eq!(s.equipment.flip_flops, 3 * (w + 1) + 4 * w);
        assert_eq!(s.depth.sr_of_gates, 2);
        let instances = |module: &str| s.modules.iter().find(|m| m.module == module).unwrap().number;
        assert_eq!((instances("full_adder_gates"), instances("half_adder_gates")), (w + 1, 2 * (w + 1)));
        // f's sign → NOT, AND, OR → the adder, whose lowest carry is 0: one AND and OR less → AND, OR of the register
        assert_eq!(u64::from(s.depth.levels), 3 + (2 * (w + 1) + 4 - 2) + 2, "{width} bits");
        assert_eq!(s.depth.path.unwrap().start.pin.unwrap(), format!("memory.bit[{w}].ff_falling.q"));
    }
}

/// The scopes of a circuit hold together what the whole does.
#[test]
fn scopes_add_up() {
    let file = repository("circuits/evaluation/line_gates.json");
    let netlist = discreta::circuit::load(file).unwrap().netlist;
    let whole = Stats::of(&netlist);
    let scopes = netlist.scope_stats(1);
    assert_eq!((scopes[0].equipment, scopes[0].cells), (whole.equipment, whole.cells()));
    let gates: u64 = scopes[1..].iter().map(|s| s.equipment.gates).sum();
    assert_eq!(gates + 3, whole.equipment.gates); // and3, and4 and end stand in the top
    let adder = scopes.iter().find(|s| s.scope == "adder").unwrap();
    assert_eq!((adder.module.as_deref(), adder.equipment.gates), (Some("ripple_adder"), 63));
    // each is followed by what stands in it
    let names: Vec<_> = netlist.scope_stats(2).into_iter().map(|s| s.scope).collect();
    let at = names.iter().position(|n| n == "adder").unwrap();
    let within: Vec<String> = (0..9).map(|i| format!("adder.fa[{i}]")).collect();
    assert_eq!(names[at + 1..at + 10], within);
}

/// The counts know every element by the name that the file gives it.
#[test]
fn cells_keep_the_names_of_their_elements() {
    let netlist = discreta::circuit::load(repository("circuits/evaluation/line.json")).unwrap().netlist;
    for cell in netlist.cells() {
        assert!(elements().any(|e| e.name == cell.element), "{}", cell.element);
        let same = cell.kind.element() == cell.element;
        assert!(same || (cell.kind.element(), cell.element) == ("dff", "register"), "{}", cell.element);
    }
    let s = Stats::of(&netlist);
    let registers = s.elements.iter().find(|e| e.element == "register").unwrap();
    assert_eq!((registers.width, registers.number), (9, 2));
}

/// Nothing of it depends on the order of cells: the way is the first by name of those that are as long.
#[test]
fn the_order_of_cells_does_not_matter() {
    let stats = |order: [usize; 4]| {
        let mut b = Builder::new("parallel");
        let (nets, top) = ((b.input("a", 1), b.input("b", 1), b.net("p", 1), b.net("q", 1)), b.top());
        let outputs = (b.output("y", 1), b.output("z", 1));
        let not = CellKind::Gate { op: GateOp::Not, width: 1, inputs: 1 };
        let cells = [
            ("n1", &nets.0, &nets.2),
            ("n2", &nets.1, &nets.3),
            ("n3", &nets.2, &outputs.0),
            ("n4", &nets.3, &outputs.1),
        ];
        for (name, a, y) in order.map(|i| cells[i]) {
            b.cell(top, name, not.clone(), vec![a.clone()], vec![y.clone()]);
        }
        Stats::of(&b.finish().unwrap())
    };
    let first = stats([0, 1, 2, 3]);
    assert_eq!(first.depth.path.as_ref().unwrap().end.net, "y");
    assert_eq!(first, stats([3, 1, 0, 2]));
    assert_eq!(first, stats([2, 3, 1, 0]));
}

#[test]
fn nothing_is_made_of_nothing() {
    for netlist in [Netlist::default(), Builder::new("empty").finish().unwrap()] {
        let s = Stats::of(&netlist);
        assert_eq!((s.cells(), s.nets.number, s.depth.levels), (0, 0, 0));
        assert_eq!((s.fan_out, s.depth.path), (None, None));
        assert_eq!(netlist.scope_stats(3).len(), netlist.scopes().len());
    }
}
