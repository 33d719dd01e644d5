//! What happens while a circuit first settles is no edge, and every change after that is one: every kind of storage, either
//! edge, clocks of every making, at every level that they may begin with; on all engines, and on Icarus as exported.

use std::path::Path;
use std::sync::Arc;

use discreta::Value;
use discreta::cell::memory::{ReadPort, WritePort};
use discreta::cell::{Accumulator, CellKind, Clock, Counter, Edge, Flop, GateOp, Memory};
use discreta::netlist::{Builder, Bus, Netlist};
use needs::needs;
use serde_json::json;

use crate::support;
use crate::support::tool::tool;

fn flop(edge: Edge, width: u32, init: &str) -> Box<Flop> {
    let value = |n| Value::from_u64(n, width);
    let init = Value::for_width(init, width).unwrap();
    Box::new(Flop { edge, set_value: value(5), reset_value: value(2), init })
}

/// Clocks of every making: inputs, what gates make of them, registers with and without a first value, a clock of its own.
fn clocks(b: &mut Builder) -> Vec<(&'static str, Bus)> {
    let (clk, en) = (b.input("clk", 1), b.input("en", 1));
    let mut all = vec![("clk", clk.clone()), ("inv", b.not("inv", &clk))];
    all.push(("gated", b.gate("gated", GateOp::And, &[&clk, &en])));
    for init in ["0", "1", "x"] {
        let q = b.net(&format!("div{init}"), 1);
        let inverted = b.not("n", &q);
        // one that begins as x takes a value first
        let d = if init == "x" { b.gate("or", GateOp::Or, &[&inverted, &en]) } else { inverted };
        let top = b.top();
        b.cell(
            top,
            &format!("d{init}"),
            CellKind::Flop(flop(Edge::Rising, 1, init)),
            vec![clk.clone(), d],
            vec![q.clone()],
        );
        all.push((["div0", "div1", "divx"][init.parse().unwrap_or(2)], q));
    }
    for phase in [0, 4] {
        let own = b.net(&format!("own{phase}"), 1);
        let top = b.top();
        b.cell(
            top,
            &format!("o{phase}"),
            CellKind::Clock(Clock { period: 14, high: 7, phase }),
            vec![],
            vec![own.clone()],
        );
        all.push((["own0", "own4"][usize::from(phase > 0)], own));
    }
    all
}

/// A memory that is written and read by clocks.
fn memory(edge: Edge) -> Box<Memory> {
    let mut init = Memory::contents(4, 4);
    (0..4).for_each(|i| Memory::set_word(4, &mut init, i, &Value::from_u64(u64::from(i) + 8, 4), |_| true));
    let read = ReadPort {
        clock: Some(edge),
        wide: false,
        transparent: [false].into(),
        collides: [false].into(),
        arst_value: Value::from_u64(6, 4),
        srst_value: Value::from_u64(3, 4),
        enable_first: false,
    };
    let write = WritePort { clock: Some(edge), wide: false, priority: vec![false].into() };
    let (start, init) = (Value::from_u64(1, 4), Arc::from(init));
    Box::new(Memory { width: 4, size: 4, offset: 0, abits: 2, init, start, reads: vec![read], writes: vec![write] })
}

/// Every kind of storage at every clock and edge, with controls that are tied off and ones that act.
fn storage() -> Netlist {
    let mut b = Builder::new("start");
    let clocks = clocks(&mut b);
    let (d, low, high) = (b.input("d", 4), b.input("low", 1), b.input("high", 1));
    let (zero, one) = (b.constant(&Value::from_u64(0, 1)), b.constant(&Value::from_u64(1, 1)));
    let open = Bus::default;
    let address = d.slice(0, 2);
    for (name, clk) in &clocks {
        for edge in [Edge::Rising, Edge::Falling] {
            let (step, init) = (Value::from_u64(3, 4), Value::from_u64(0, 4));
            let c = || clk.clone();
            let (d, low, high) = (|| d.clone(), || low.clone(), || high.clone());
            let counter = || CellKind::Counter(Box::new(Counter { edge, step: step.clone(), init: init.clone() }));
            let ff = |init| CellKind::Flop(flop(edge, 4, init));
            let edge_flop = || CellKind::EdgeFlop(flop(edge, 4, "1"));
            let all: Vec<(&str, CellKind, Vec<Bus>)> = vec![
                ("dff", ff("x"), vec![c(), d()]),
                ("dffe", ff("0"), vec![c(), d(), open(), open(), open(), high()]),
                ("reset_low", ff("1"), vec![c(), d(), open(), open(), low()]),
                ("reset_high", ff("1"), vec![c(), d(), open(), open(), high()]),
                ("set", ff("9"), vec![c(), d(), open(), high()]),
                ("both", ff("9"), vec![c(), d(), open(), high(), low()]),
                ("sync", ff("1"), vec![c(), d(), open(), open(), open(), open(), low(), high()]),
                ("load", ff("1"), vec![c(), d(), high()]),
                ("edge", edge_flop(), vec![c(), d(), open(), open(), open(), low()]),
                ("edge_high", edge_flop(), vec![c(), d(), open(), open(), high()]),
                ("edge_load", edge_flop(), vec![c(), d(), d(), high()]),
                ("counter", counter(), vec![c(), open(), open(), open()]),
                ("counter_reset", counter(), vec![c(), open(), open(), high()]),
                ("counter_load", counter(), vec![c(), d(), high(), low()]),
                (
                    "accumulator",
                    CellKind::Accumulator(Box::new(Accumulator { edge, init: init.clone() })),
                    vec![c(), d(), one.clone(), low()],
                ),
                (
                    "memory",
                    CellKind::Memory(memory(edge)),
                    vec![
                        c(),
                        one.clone(),
                        low(),
                        zero.clone(),
                        address.clone(),
                        c(),
                        Bus::concat([&one; 4]),
                        address.clone(),
                        d(),
                    ],
                ),
                (
                    "memory_reset",
                    CellKind::Memory(memory(edge)),
                    vec![
                        c(),
                        one.clone(),
                        high(),
                        zero.clone(),
                        address.clone(),
                        c(),
                        Bus::concat([&high(), &high(), &high(), &high()]),
                        address.clone(),
                        d(),
                    ],
                ),
            ];
            for (what, kind, inputs) in all {
                let name = format!("{what}_{name}_{}", if edge == Edge::Rising { "up" } else { "down" });
                let q = b.output(&name, 4);
                let top = b.top();
                b.cell(top, &format!("c_{name}"), kind, inputs, vec![q]);
            }
        }
    }
    b.finish().unwrap_or_else(|faults| panic!("{faults:?}"))
}

fn run(folder: &Path, arguments: &[&str]) -> String {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_discreta"));
    let ran = command.current_dir(folder).args(arguments).output().unwrap();
    let told = String::from_utf8_lossy(&ran.stdout).into_owned() + &String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{arguments:?}: {told}");
    told
}

#[needs(iverilog)]
#[test]
fn storage_begins_on_icarus_as_here() {
    let folder = support::folder("start");
    let netlist = storage();
    std::fs::write(folder.join("start.json"), discreta::export::yosys::write(&netlist, &Default::default())).unwrap();
    let low_or_high = |phase: u64| json!({ "period": 10, "high": 5, "phase": phase });
    // how the clock and the controls begin, and what is done about them at tick 0
    let given = |clk: u64| json!({ "clk": clk, "en": 1, "low": 0, "high": 1, "d": 6 });
    let unknown = json!({ "en": 1, "low": 0, "high": 1, "d": 6 });
    let bare = json!({ "d": 6 });
    let change = |at: u64, set: serde_json::Value| json!({ "at": at, "set": set });
    let later = vec![
        change(3, json!({ "d": 9 })),
        change(12, json!({ "high": 0, "d": 4 })),
        change(23, json!({ "d": 13 })),
        change(42, json!({ "low": 1 })),
        change(48, json!({ "low": 0, "d": 11 })),
        change(63, json!({ "high": 1 })),
        change(67, json!({ "high": 0, "d": 2 })),
    ];
    let toggles = (0..6).map(|n| change(5 + 10 * n, json!({ "clk": n % 2 }))).collect::<Vec<_>>();
    let sorted = |mut list: Vec<serde_json::Value>| {
        list.sort_by_key(|e| e["at"].as_u64());
        list
    };
    let with = |first: serde_json::Value| sorted([vec![change(0, first)], later.clone(), toggles.clone()].concat());
    let no_clk = |mut inputs: serde_json::Value| {
        inputs.as_object_mut().unwrap().remove("clk");
        inputs
    };
    let clocked =
        |phase: u64| json!({ "clocks": { "clk": low_or_high(phase) }, "inputs": no_clk(given(0)), "stimulus": later });
    let cases = [
        ("low_clock", clocked(5)),
        ("high_clock", clocked(0)),
        ("low", json!({ "inputs": given(0), "stimulus": with(json!({ "d": 7 })) })),
        ("high", json!({ "inputs": given(1), "stimulus": with(json!({ "d": 7 })) })),
        ("rises_at_0", json!({ "inputs": given(0), "stimulus": with(json!({ "clk": 1 })) })),
        ("falls_at_0", json!({ "inputs": given(1), "stimulus": with(json!({ "clk": 0 })) })),
        ("unknown", json!({ "inputs": unknown, "stimulus": with(json!({ "d": 7 })) })),
        ("x_to_0_at_0", json!({ "inputs": unknown, "stimulus": with(json!({ "clk": 0 })) })),
        ("x_to_1_at_0", json!({ "inputs": unknown, "stimulus": with(json!({ "clk": 1 })) })),
        ("bare", json!({ "inputs": bare, "stimulus": with(json!({ "clk": 0, "en": 1, "high": 0, "low": 0 })) })),
    ];
    let mut values = 0;
    for (name, mut simulation) in cases {
        simulation["limit"] = json!({ "time": 90 });
        let at = |end: &str| format!("{name}{end}");
        let scenario = json!({ "circuit": "start.json", "simulation": simulation });
        std::fs::write(folder.join(at(".json")), scenario.to_string()).unwrap();
        let file = at(".json");
        let waves: Vec<Vec<u8>> = ["event", "compiled", "auto"]
            .into_iter()
            .map(|engine| {
                let to = at(&format!(".{engine}.vcd"));
                // the compiled engine is not in every build
                let engine = if cfg!(feature = "compiled") { engine } else { "event" };
                run(&folder, &["run", &file, "--engine", engine, "-o", &to, "--x-control", "ignore"]);
                std::fs::read(folder.join(to)).unwrap()
            })
            .collect();
        assert!(waves.iter().all(|w| *w == waves[0]), "{name}: engines differ");
        let (design, bench) = (at(".v"), at("_tb.v"));
        run(&folder, &["export", &file, "--to", "verilog", "-o", &design, "--testbench", &bench]);
        tool(&folder, "iverilog", &["-g2005", "-o", &at(".vvp"), &design, &bench]);
        tool(&folder, "vvp", &["-n", &at(".vvp")]);
        let told = run(&folder, &["diff", &at(".event.vcd"), &at("_tb.vcd"), "--scope", "testbench"]);
        assert!(told.contains("The same"), "{name}: {told}");
        values += netlist.nets().len();
    }
    println!("{values} nets equal");
}
