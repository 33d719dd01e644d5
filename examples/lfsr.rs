//! A shift register with linear feedback that fills a memory, built in Rust and run on each engine, many at once on a pool of
//! threads: `cargo run --example lfsr`.

#![allow(missing_docs)]

use std::error::Error;
use std::thread;

use discreta::cell::GateOp;
use discreta::netlist::{BuildError, Builder, Bus, Netlist};
use discreta::{EngineKind, Simulator, SimulatorError};

/// Taps at bits 8, 6, 5 and 4: every value but 0 comes once in 255 clocks.
fn lfsr() -> Result<Netlist, BuildError> {
    let mut b = Builder::new("lfsr");
    let (clk, rst, q) = (b.input("clk", 1), b.input("rst", 1), b.output("q", 8));
    let feedback = b.gate("taps", GateOp::Xor, &[&q.bit(7), &q.bit(5), &q.bit(4), &q.bit(3)]);
    let next = Bus::concat([&feedback, &q.slice(0, 7)]);
    b.reg("state", &clk).reset(&rst, 1).drives(&next, &q);

    let always = b.number(1, 1);
    let mut seen = b.memory("seen", 1, 256).init([0; 256]);
    seen.write(&clk, &always, &q, &always);
    let word = seen.read(&q);
    seen.done();
    b.port("again", &word);
    b.finish()
}

/// After how many clocks a value comes again, and how many have come.
fn period(mut sim: Simulator) -> Result<(u64, usize), SimulatorError> {
    for (name, value) in [("clk", 0), ("rst", 1)] {
        sim.poke(name, value)?;
    }
    sim.settle()?;
    sim.poke("rst", 0)?;
    let again = sim.probe("again")?;
    let mut clocks = 0;
    while sim.number(&again) != Some(1) {
        sim.tick("clk")?;
        clocks += 1;
    }
    let seen = sim.memory("seen")?;
    let words = seen.addresses().map(|at| sim.read_memory(&seen, at)).collect::<Result<Vec<_>, _>>()?;
    Ok((clocks, words.iter().filter(|w| w.to_u64() == Some(1)).count()))
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let netlist = lfsr()?;
    for kind in [EngineKind::Event, EngineKind::Auto, EngineKind::Compiled] {
        if kind == EngineKind::Compiled && !cfg!(feature = "compiled") {
            continue;
        }
        let sims = (0..8).map(|_| Simulator::with(&netlist, kind)).collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<_> = sims.into_iter().map(|sim| thread::spawn(|| period(sim))).collect();
        for run in runs {
            let (clocks, values) = run.join().expect("it does not panic")?;
            assert_eq!((clocks, values), (255, 255));
        }
        println!("{kind:?}: 8 runs, each of 255 clocks and 255 values");
    }
    Ok(())
}
