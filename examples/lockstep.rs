//! Two circuits that are to do the same, driven alike until they part: the line interpolator at register level, and as gates.
//! `cargo run --example lockstep`

#![allow(missing_docs)]

use std::error::Error;

use discreta::{Lockstep, Simulator, SimulatorError, circuit};

/// Draws a line on both, with a comparison of what both have after every clock.
fn draw(both: &mut Lockstep, dx: u64, dy: u64) -> Result<(), SimulatorError> {
    both.step(|sim| {
        for (name, value) in [("dt", 0), ("dx", dx), ("dy", dy), ("xh", 0), ("yh", 0), ("start", 1)] {
            sim.poke(name, value)?;
        }
        sim.settle()?;
        sim.poke("start", 0)
    })?;
    (0..dx + dy).try_for_each(|_| both.step(|sim| sim.tick("dt")))
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let registers = circuit::load_with("circuits/evaluation/line.json", &[("W", 4)])?;
    let gates = circuit::load_with("circuits/evaluation/line_gates.json", &[("W", 4)])?;
    let mut both = Lockstep::new(Simulator::new(&registers), Simulator::new(&gates))?;
    draw(&mut both, 9, 5)?;
    println!("alike at every one of 14 steps");

    // a bit of the gates that is stuck
    both.right().force("xt", 3)?;
    match draw(&mut both, 9, 5) {
        Err(SimulatorError::Differs(difference)) => println!("{difference}"),
        other => panic!("the fault is found: {other:?}"),
    }
    Ok(())
}
