//! Steps the line interpolator by hand and prints its path: `cargo run --example line -- 7 3`.

use discreta::{Simulator, circuit};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(|a| a.parse::<u64>());
    let (dx, dy) = (arguments.next().unwrap_or(Ok(5))?, arguments.next().unwrap_or(Ok(3))?);

    let line = circuit::load("circuits/evaluation/line.json")?;
    let mut sim = Simulator::new(&line.netlist);
    let [start, dt] = ["start", "dt"].map(|name| sim.input(name).expect("the circuit has it"));
    let [xt, yt, end] = ["xt", "yt", "end"].map(|name| sim.probe(name).expect("the circuit has it"));
    for (name, value) in [("dt", 0), ("dx", dx), ("dy", dy), ("xh", 0), ("yh", 0), ("start", 1)] {
        sim.set(sim.input(name)?, value);
    }
    sim.settle()?;
    sim.set(start, 0);
    sim.settle()?;
    while sim.number(&end) == Some(0) {
        for level in [1, 0] {
            sim.set(dt, level);
            sim.settle()?;
        }
        println!("{} {}", sim.value(&xt).to_u64().unwrap_or(0), sim.value(&yt).to_u64().unwrap_or(0));
    }
    Ok(())
}
