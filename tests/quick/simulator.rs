//! The simulator in Rust: what cannot be meant is an error that names it, never silence, a panic or an endless loop.

use discreta::cell::{CellKind, Clock, GateOp};
use discreta::netlist::{Builder, Fault, Netlist};
use discreta::{EngineKind, Lockstep, Probe, Simulator, SimulatorError, State, Trace};

/// A flip-flop, and an input for each letter.
fn netlist(name: &str, inputs: &[&str]) -> Netlist {
    let mut b = Builder::new(name);
    let clk = b.input("clk", 1);
    let d = inputs.iter().map(|n| b.input(n, 8)).collect::<Vec<_>>();
    let q = b.net("q", 8);
    b.dff("ff", &clk, &d[0], &q);
    b.finish().unwrap()
}

#[test]
fn time_does_not_go_back() {
    let n = netlist("t", &["d"]);
    let mut sim = Simulator::new(&n);
    sim.run_to(100).unwrap();
    assert_eq!(sim.run_to(99), Err(SimulatorError::Past { now: 100, asked: 99 }));
    assert_eq!(sim.run_to(100), Ok(()));
}

#[test]
fn a_clock_that_is_none_is_told() {
    let n = netlist("t", &["d"]);
    for (period, high) in [(0, 0), (0, 1), (1, 1), (10, 0), (10, 10), (10, 11), (1, u64::MAX), (u64::MAX, u64::MAX)] {
        let mut sim = Simulator::new(&n);
        let clk = sim.input("clk").unwrap();
        sim.clock(clk, Clock { period, high, phase: 0 });
        let told = sim.run_to(5).unwrap_err();
        assert!(matches!(&told, SimulatorError::BadClock { input, .. } if input == "clk"), "{told}");
        assert!(told.to_string().contains(&format!("a period of {period} ticks of which {high}")), "{told}");
    }
    let mut sim = Simulator::new(&n);
    let clk = sim.input("clk").unwrap();
    sim.clock(clk, Clock { period: 2, high: 1, phase: 0 });
    sim.run_to(5).unwrap();
}

#[test]
fn handles_of_another_netlist_are_told() {
    let (one, other) = (netlist("one", &["d", "e", "f"]), netlist("other", &["d"]));
    let from = Simulator::new(&one);
    let (input, probe) = (from.input("f").unwrap(), from.probe("f").unwrap());
    let mut sim = Simulator::new(&other);
    sim.set(input, 3);
    assert!(matches!(sim.settle(), Err(SimulatorError::Foreign(_))));
    sim.settle().unwrap();
    assert_eq!(sim.number(&probe), None);
    assert_eq!(sim.settle(), Err(SimulatorError::Foreign("`f`".into())));
    assert_eq!(sim.value(&probe).bit_string(), "xxxxxxxx");
    assert!(sim.run_to(1).is_err());
    sim.clock(input, Clock { period: 10, high: 5, phase: 0 });
    assert!(sim.run_to(1).is_err());
    assert!(matches!(sim.input("q"), Err(SimulatorError::NotAnInput(name)) if name == "q"));
    // of a clone they are its own
    let clone = one.clone();
    let mut sim = Simulator::new(&clone);
    sim.set(input, 3);
    sim.settle().unwrap();
    assert_eq!(sim.number(&probe), Some(3));
}

#[test]
fn surplus_pins_are_told() {
    let mut b = Builder::new("t");
    let (a, y, z) = (b.input("a", 1), b.net("y", 1), b.net("z", 1));
    let kind = CellKind::Gate { op: GateOp::Not, width: 1, inputs: 1 };
    let cell = b.cell(b.top(), "g", kind, vec![a.clone(), a], vec![y, z]);
    let faults = b.finish().unwrap_err();
    assert!(faults.contains(&Fault::SurplusPins { cell, inputs: true, given: 2, pins: 1 }), "{faults:?}");
    assert!(faults.contains(&Fault::SurplusPins { cell, inputs: false, given: 2, pins: 1 }), "{faults:?}");
}

/// A counter with a reset and a memory that its values are written into.
fn counter() -> Netlist {
    let mut b = Builder::new("top");
    let (clk, rst, q) = (b.input("clk", 1), b.input("rst", 1), b.output("q", 8));
    let one = b.number(1, 8);
    let (next, _) = b.adder("add", &q, &one);
    b.reg("count", &clk).reset(&rst, 0).drives(&next, &q);
    let mut ram = b.memory("ram", 8, 16).init([9, 8, 7]);
    ram.write(&clk, &one.bit(0), &q.slice(0, 4), &q);
    let word = ram.read(&q.slice(0, 4));
    ram.done();
    b.port("word", &word);
    b.finish().unwrap()
}

fn kinds() -> Vec<EngineKind> {
    let all = [EngineKind::Auto, EngineKind::Event, EngineKind::Compiled];
    all.into_iter().filter(|&k| k != EngineKind::Compiled || cfg!(feature = "compiled")).collect()
}

/// On each kind of engine, at zero with everything reset.
fn counters() -> Vec<Simulator> {
    let n = counter();
    let made = |kind| {
        let mut sim = Simulator::with(&n, kind).unwrap();
        for (name, value) in [("clk", 0), ("rst", 1)] {
            sim.poke(name, value).unwrap();
        }
        sim.settle().unwrap();
        sim.poke("rst", 0).unwrap();
        sim
    };
    kinds().into_iter().map(made).collect()
}

#[test]
fn a_simulator_owns_its_circuit_and_moves_to_another_thread() {
    struct Bench {
        sim: Simulator,
        q: Probe,
    }
    for sim in counters() {
        let mut bench = Bench { q: sim.probe("q").unwrap(), sim };
        let count = std::thread::spawn(move || {
            bench.sim.ticks("clk", 5).unwrap();
            bench.sim.number(&bench.q)
        });
        assert_eq!(count.join().unwrap(), Some(5));
    }
}

#[test]
fn words_of_memories_are_read_and_set() {
    for mut sim in counters() {
        assert_eq!(sim.memories().collect::<Vec<_>>(), ["ram"]);
        let ram = sim.memory("ram").unwrap();
        let word = |sim: &Simulator, at| sim.read_memory(&ram, at).unwrap().to_u64();
        assert_eq!([word(&sim, 0), word(&sim, 2), word(&sim, 3)], [Some(9), Some(7), None]);
        sim.ticks("clk", 3).unwrap();
        // 0, 1 and 2 were written to where they count
        assert_eq!([word(&sim, 0), word(&sim, 1), word(&sim, 2)], [Some(0), Some(1), Some(2)]);
        sim.write_memory(&ram, 3, 200).unwrap();
        sim.settle().unwrap();
        assert_eq!(sim.peek("word").unwrap().to_u64(), Some(200));
        sim.tick("clk").unwrap();
        assert_eq!(word(&sim, 3), Some(3));
        let told = sim.read_memory(&ram, 16).unwrap_err().to_string();
        assert_eq!(told, "memory `ram` has no word 16: its addresses are 0 to 15");
        assert!(sim.write_memory(&ram, 0, 256).is_err());
        let told = sim.memory("rom").unwrap_err().to_string();
        assert_eq!(told, "the circuit has no memory `rom`; it has ram");
    }
}

#[test]
fn forces_deposits_and_what_cannot_be() {
    for mut sim in counters() {
        sim.ticks("clk", 4).unwrap();
        sim.force("q", 100).unwrap();
        sim.ticks("clk", 2).unwrap();
        assert_eq!(sim.peek("q").unwrap().to_u64(), Some(100));
        sim.release("q").unwrap();
        sim.ticks("clk", 2).unwrap();
        assert_eq!(sim.peek("q").unwrap().to_u64(), Some(102));
        sim.deposit("q", "8'hfe").unwrap();
        sim.ticks("clk", 3).unwrap();
        assert_eq!(sim.peek("q").unwrap().to_u64(), Some(1));
        assert!(sim.deposit("word", 1).unwrap_err().to_string().contains("neither an input nor storage"));
        assert!(sim.force("q", 256).unwrap_err().to_string().contains("256 needs more than its 8 bits"));
        assert!(sim.poke("q", 1).unwrap_err().to_string().contains("not an input"));
        assert!(sim.force("qq", 1).unwrap_err().to_string().contains("did you mean `q`?"));
        assert!(sim.tick("rst_n").is_err());
    }
}

#[test]
fn a_state_goes_into_a_file_and_into_any_engine() {
    let folder = crate::support::folder("simulator_state");
    let path = folder.join("counter.state");
    for from in &mut counters() {
        from.ticks("clk", 7).unwrap();
        from.save().write(&path).unwrap();
        from.ticks("clk", 3).unwrap();
        for mut to in counters() {
            let state = State::read(&path).unwrap();
            assert_eq!(state.now(), 14);
            to.ticks("clk", 2).unwrap();
            to.restore(&state).unwrap();
            assert_eq!((to.now(), to.peek("q").unwrap().to_u64()), (14, Some(7)));
            to.ticks("clk", 3).unwrap();
            for name in ["q", "word"] {
                assert_eq!(to.peek(name).unwrap(), from.peek(name).unwrap());
            }
            let ram = to.memory("ram").unwrap();
            assert_eq!(to.read_memory(&ram, 9).unwrap().to_u64(), Some(9));
        }
    }
    let n = netlist("t", &["d"]);
    let told = Simulator::new(&n).restore(&State::read(&path).unwrap()).unwrap_err().to_string();
    assert!(told.contains("of another circuit"), "{told}");
    std::fs::write(&path, "no state").unwrap();
    let told = State::read(&path).unwrap_err().to_string();
    assert!(told.ends_with("counter.state`: it is no saved state"), "{told}");
    assert!(State::read(folder.join("none")).unwrap_err().to_string().contains("no such file"));
}

/// The times and values of a variable of a VCD.
fn changes(path: &std::path::Path, name: &str) -> Vec<(u64, String)> {
    let text = std::fs::read_to_string(path).unwrap();
    let id = text.lines().find(|l| l.starts_with("$var") && l.split(' ').nth(4) == Some(name)).unwrap();
    let id = id.split(' ').nth(3).unwrap().to_owned();
    let (mut now, mut all) = (0, Vec::new());
    for line in text.lines() {
        if let Some(time) = line.strip_prefix('#') {
            now = time.parse().unwrap();
        } else if let Some((value, of)) = line.strip_prefix('b').and_then(|l| l.split_once(' ')) {
            all.extend((of == id).then(|| (now, value.to_owned())));
        }
    }
    all
}

#[test]
fn a_waveform_is_written_whole_in_parts_and_in_a_window() {
    let folder = crate::support::folder("simulator_trace");
    for mut sim in counters() {
        let path = folder.join("whole.vcd");
        let _ = std::fs::remove_file(&path);
        sim.trace(&path).unwrap();
        assert!(sim.trace(&path).is_err(), "one at a time");
        sim.ticks("clk", 3).unwrap();
        assert!(!path.exists(), "it is there when it is complete");
        sim.end_trace().unwrap();
        let expected = [(0, "00000001"), (2, "00000010"), (4, "00000011")].map(|(t, v)| (t, v.to_owned()));
        // the value at the end of tick 0 counts: the first edge is there
        assert_eq!(changes(&path, "q"), expected, "{}", sim.summary());
        // by a clock, from 20 to 30, of what is asked for
        let path = folder.join("window.vcd");
        let clk = sim.input("clk").unwrap();
        sim.clock(clk, Clock { period: 4, high: 2, phase: 8 });
        sim.trace(Trace::to(&path).only("q").from(20).until(30)).unwrap();
        sim.run_to(100).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!text.contains(" word ") && text.trim_end().ends_with("#30"), "{text}");
        assert_eq!(changes(&path, "q").iter().map(|c| c.0).collect::<Vec<_>>(), [20, 24, 28]);
        assert!(sim.trace(folder.join("x.txt")).unwrap_err().to_string().contains("`.vcd` or `.fst`"));
        assert!(sim.trace(Trace::to(folder.join("x.vcd")).only("none")).is_err());
        assert!(sim.end_trace().is_err());
        // what is dropped has its waveform
        sim.trace(folder.join("dropped.fst")).unwrap();
        sim.run_to(120).unwrap();
        drop(sim);
        assert!(folder.join("dropped.fst").metadata().unwrap().len() > 100);
        std::fs::remove_file(folder.join("dropped.fst")).unwrap();
    }
}

#[test]
fn one_waits_for_a_value_and_is_told_if_it_does_not_come() {
    for mut sim in counters() {
        let clk = sim.input("clk").unwrap();
        sim.clock(clk, Clock { period: 10, high: 5, phase: 3 });
        assert_eq!(sim.run_until("q", 4, 1000), Ok(33));
        let told = sim.run_until("q", 3, 100).unwrap_err().to_string();
        assert!(told.starts_with("`q` has not become 8'd3 by tick 133"), "{told}");
        sim.tick("clk").unwrap();
    }
}

#[test]
fn two_in_lockstep_part_where_they_differ() {
    let other = |wrong: bool| {
        let mut b = Builder::new("top");
        let (clk, rst, q) = (b.input("clk", 1), b.input("rst", 1), b.output("q", 8));
        let one = b.number(1, 8);
        let (next, _) = b.adder("add", &q, &one);
        let five = b.number(5, 8);
        let at_five = b.gate("xor", GateOp::Xor, &[&q, &five]);
        // stays at 5
        let (y, zero) = (b.net("y", 8), b.net("is_five", 1));
        b.cell(b.top(), "z", CellKind::IsZero { width: 8 }, vec![at_five], vec![zero.clone()]);
        let kind = CellKind::Mux { width: 8, inputs: 2 };
        b.cell(b.top(), "mux", kind, vec![discreta::netlist::Bus::concat([&next, &q]), zero], vec![y.clone()]);
        b.reg("count", &clk).reset(&rst, 0).drives(if wrong { &y } else { &next }, &q);
        b.finish_with(&mut Vec::new())
    };
    for (wrong, parts) in [(false, None), (true, Some(10))] {
        let sims = [counter(), other(wrong)].map(Simulator::new);
        let [left, right] = sims;
        let mut both = Lockstep::new(left, right).unwrap();
        both.step(|sim| {
            sim.poke("clk", 0)?;
            sim.poke("rst", 1)?;
            sim.settle()?;
            sim.poke("rst", 0)
        })
        .unwrap();
        let done = (0..20).try_for_each(|_| both.step(|sim| sim.tick("clk")));
        match parts {
            None => done.unwrap(),
            Some(time) => {
                let Err(SimulatorError::Differs(d)) = done else { panic!("{done:?}") };
                assert_eq!((d.name.as_str(), d.left.to_u64(), d.right.to_u64()), ("q", Some(6), Some(5)));
                assert_eq!(d.time, time + 2, "after the sixth tick");
                assert_eq!(d.to_string(), "at tick 12 `q` is 8'd6 on the left and 8'd5 on the right");
            }
        }
    }
}

#[test]
fn what_the_circuit_says_is_heard() {
    // module top(input clk, input [3:0] a); always @(posedge clk) begin $display("a=%d", a); assert (a != 5); end
    let text = r#"{ "creator": "Yosys", "modules": { "top": { "attributes": { "top": "1" }, "ports": {
        "clk": { "direction": "input", "bits": [2] }, "a": { "direction": "input", "bits": [3, 4, 5, 6] } },
      "cells": {
        "say": { "hide_name": 0, "type": "$print", "parameters": { "ARGS_WIDTH": 4, "FORMAT": "a={4:> du}\n",
            "PRIORITY": 0, "TRG_ENABLE": 1, "TRG_POLARITY": 1, "TRG_WIDTH": 1 }, "attributes": {},
          "port_directions": { "ARGS": "input", "EN": "input", "TRG": "input" },
          "connections": { "ARGS": [3, 4, 5, 6], "EN": ["1"], "TRG": [2] } },
        "holds": { "hide_name": 0, "type": "$assert", "parameters": {}, "attributes": {},
          "port_directions": { "A": "input", "EN": "input" }, "connections": { "A": [7], "EN": ["1"] } },
        "ne": { "hide_name": 0, "type": "$ne", "parameters": { "A_SIGNED": 0, "A_WIDTH": 4, "B_SIGNED": 0,
            "B_WIDTH": 4, "Y_WIDTH": 1 }, "attributes": {},
          "port_directions": { "A": "input", "B": "input", "Y": "output" },
          "connections": { "A": [3, 4, 5, 6], "B": ["1", "0", "1", "0"], "Y": [7] } } },
      "netnames": { "clk": { "hide_name": 0, "bits": [2], "attributes": {} },
        "a": { "hide_name": 0, "bits": [3, 4, 5, 6], "attributes": {} } } } } }"#;
    let circuit = discreta::circuit::load_text("top.json", text, &[]).unwrap();
    for kind in kinds() {
        let mut sim = Simulator::with(&circuit, kind).unwrap();
        sim.poke("clk", 0).unwrap();
        for a in [3, 4] {
            sim.poke("a", a).unwrap();
            sim.settle().unwrap();
            sim.tick("clk").unwrap();
        }
        let said: Vec<String> = sim.take_messages().into_iter().map(|m| m.text).collect();
        assert_eq!(said, ["a=3\n", "a=4\n"]);
        sim.poke("a", 5).unwrap();
        let told = sim.settle().unwrap_err();
        assert!(matches!(&told, SimulatorError::Assertion { name, time: 4, .. } if name == "holds"), "{told:?}");
        sim.poke("a", 6).unwrap();
        sim.settle().unwrap();
    }
}

#[test]
fn a_text_is_loaded_with_its_warnings_and_its_faults() {
    let text = r#"{ "modules": { "top": { "ports": { "a": { "direction": "input" }, "b": { "direction": "input" },
        "y": { "direction": "output" } }, "nets": { "idle": {} },
        "cells": { "m": { "type": "not", "connections": { "a": "b", "y": "idle" } }, "n": { "type": "not", "connections": { "a": "a", "y": "y" } } } } } }"#;
    let circuit = discreta::circuit::load_text("mem.json", text, &[]).unwrap();
    assert!(circuit.warnings.iter().any(|w| w.contains("mem.json") && w.contains("idle")), "{:?}", circuit.warnings);
    let wrong = discreta::circuit::load_text("mem.json", &text.replace("not", "nott"), &[]).unwrap_err();
    assert!(wrong.to_string().contains("mem.json") && wrong.to_string().contains("nott"), "{wrong}");
}

#[test]
fn faults_of_wiring_have_names() {
    let mut b = Builder::new("t");
    let (clk, d) = (b.input("clk", 1), b.input("d", 8));
    let q = b.net("q", 4);
    b.reg("store", &clk).drives(&d, &q);
    let told: Box<dyn std::error::Error + Send + Sync> = b.finish().unwrap_err().into();
    assert_eq!(told.to_string(), "pin `d` of register `store` has 4 bits and is connected to 8");
}
