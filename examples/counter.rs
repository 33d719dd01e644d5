//! Builds a netlist in Rust, runs it by a clock, and writes its waveform.
//!
//! `cargo run --example counter` writes `counter.vcd`: a 4-bit register that an adder counts up.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use discreta::Value;
use discreta::cell::{CellKind, Clock, Edge, Flop};
use discreta::engine::EventEngine;
use discreta::netlist::Builder;
use discreta::scenario::{Control, Scenario, run};
use discreta::wave::output::Output;
use discreta::wave::vcd::VcdWriter;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut b = Builder::new("counter");
    let (clk, q) = (b.net("clk", 1), b.output("q", 4));
    let top = b.top();
    b.cell(top, "clock", CellKind::Clock(Clock { period: 10, high: 5, phase: 5 }), vec![], vec![clk.clone()]);
    let one = b.constant(&Value::from_u64(1, 4));
    let (next, _carry) = b.adder("adder", &q, &one);
    let zero = Value::from_u64(0, 4);
    let register = Flop { edge: Edge::Rising, set_value: zero.clone(), reset_value: zero.clone(), init: zero };
    b.cell(top, "register", CellKind::Flop(Box::new(register)), vec![clk, next], vec![q]);
    let netlist = b.finish().map_err(|faults| format!("{faults:?}"))?;

    let scenario = Scenario { limit: 200, trace: netlist.signal_ids().collect(), ..Scenario::default() };
    let mut waveform = VcdWriter::new(Output::create(Path::new("counter.vcd"))?);
    let mut control = Control {
        interrupt: &AtomicBool::new(false),
        progress: &mut |_| {},
        message: &mut |_, _, _| {},
        unknown_control_ends: false,
        observers: Vec::new(),
    };
    let outcome = run(&netlist, &scenario, &mut EventEngine::new(&netlist), Some(&mut waveform), &mut control)
        .map_err(|e| format!("{e:?}"))?;
    println!("after {} ticks q is {}; see counter.vcd", outcome.time, outcome.outputs[0].1);
    Ok(())
}
