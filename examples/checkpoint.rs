//! Saves the whole state of a run, goes on, and replays from there on another engine: `cargo run --example checkpoint`.

#![allow(missing_docs)]

use std::error::Error;

use discreta::{EngineKind, Simulator, SimulatorError, State, circuit};

/// Clocks the interpolator `n` times; where it is then.
fn steps(sim: &mut Simulator, n: u64) -> Result<(u64, u64), SimulatorError> {
    sim.ticks("dt", n)?;
    let [x, y] = [sim.peek("xt")?, sim.peek("yt")?];
    Ok((x.to_u64().unwrap_or(0), y.to_u64().unwrap_or(0)))
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let line = circuit::load("circuits/evaluation/line.json")?;
    let mut sim = Simulator::new(&line);
    for (name, value) in [("dt", 0), ("dx", 100), ("dy", 60), ("xh", 0), ("yh", 0), ("start", 1)] {
        sim.poke(name, value)?;
    }
    sim.settle()?;
    sim.poke("start", 0)?;
    println!("after 80 steps at {:?}", steps(&mut sim, 80)?);

    // into a file, and on
    let path = std::env::temp_dir().join(format!("line-{}.state", std::process::id()));
    sim.save().write(&path)?;
    let first = steps(&mut sim, 50)?;

    // from the file, on the reference engine
    let mut again = Simulator::with(&line, EngineKind::Event)?;
    again.restore(&State::read(&path)?)?;
    std::fs::remove_file(&path)?;
    assert_eq!(steps(&mut again, 50)?, first);

    // and once more from there, with a fault: y is held
    let state = again.save();
    again.force("yt", 0)?;
    assert_eq!(steps(&mut again, 10)?.1, 0);
    again.restore(&state)?;
    assert_eq!((again.now(), steps(&mut again, 30)?), (260, (100, 60)));
    println!("50 steps on at {first:?}, and at (100, 60) in the end, both times");
    Ok(())
}
