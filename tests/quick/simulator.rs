//! The simulator in Rust: what cannot be meant is an error that names it, never silence, a panic or an endless loop.

use discreta::cell::{CellKind, Clock, GateOp};
use discreta::netlist::{Builder, Fault, Netlist};
use discreta::{Simulator, SimulatorError};

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
