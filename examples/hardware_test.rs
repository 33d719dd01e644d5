//! Tests of a hardware module as one writes them in a project of one's own: `cargo test --example hardware_test`.

#![allow(dead_code, unused_imports)] // of an example only the tests are used

use discreta::{Simulator, SimulatorError, circuit};

/// The line interpolator with coordinates of `w` bits, its registers loaded.
fn line(w: i64, dx: u64, dy: u64) -> Result<Simulator, Box<dyn std::error::Error>> {
    let circuit = circuit::load_with("circuits/evaluation/line.json", &[("W", w)])?;
    let mut sim = Simulator::new(&circuit);
    for (name, value) in [("dt", 0), ("dx", dx), ("dy", dy), ("xh", 0), ("yh", 0), ("start", 1)] {
        sim.poke(name, value)?;
    }
    sim.settle()?;
    sim.poke("start", 0)?;
    sim.settle()?;
    Ok(sim)
}

#[test]
fn a_line_ends_where_it_is_to() {
    for (dx, dy) in [(5, 3), (7, 2), (15, 15)] {
        let mut sim = line(4, dx, dy).unwrap();
        sim.ticks("dt", dx + dy).unwrap();
        let [x, y, end] = ["xt", "yt", "end"].map(|name| sim.peek(name).unwrap().to_u64());
        assert_eq!((x, y, end), (Some(dx), Some(dy), Some(1)));
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut sim = line(4, 1, 1).unwrap();
    assert!(matches!(sim.poke("dx", 16), Err(SimulatorError::BadValue { .. })));
    assert!(matches!(sim.poke("dz", 1), Err(SimulatorError::Unknown { .. })));
}

// a file of tests needs none; an example does
fn main() {}
