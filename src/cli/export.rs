//! `discreta export`: a circuit for other tools.

use std::io::Write as _;
use std::path::Path;

use super::args::{ExportArgs, ExportFormat};
use super::prepare::{Changes, Prepared, circuit_of, prepare};
use super::run::{faults, loader};
use super::{CliError, Out, Status};
use crate::exchange::verilog::{self, Bench};
use crate::wave::output::{Destination, Output};

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, what the format cannot say, a file that cannot be written.
pub fn run(args: &ExportArgs, out: &mut Out) -> Result<Status, CliError> {
    match args.to {
        ExportFormat::Verilog => verilog(args, out),
    }
}

fn verilog(args: &ExportArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut loader = loader(&args.elaboration)?;
    let Some(testbench) = &args.testbench else {
        let circuit = circuit_of(&mut loader, &args.circuit, &args.elaboration.parameter);
        let circuit = faults(&mut loader, circuit)?;
        write(&args.output, &verilog::design(&circuit.netlist), out)?;
        return Ok(Status::Done);
    };
    let changes = Changes {
        parameters: &args.elaboration.parameter,
        sets: &args.set,
        clocks: &args.clock,
        cycles: args.cycles,
        time: args.time.as_deref(),
        until: args.until.as_ref(),
        trace: &args.trace,
        wave: None,
        checking: false,
    };
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let Prepared { circuit, scenario, replay, .. } = faults(&mut loader, prepared)?;
    if replay.is_some() {
        let refused = CliError::usage("a test bench cannot be driven by a waveform, as this scenario is");
        return Err(refused.with_hint("simulate the design beside what made the waveform"));
    }
    let dump = match testbench.file_stem() {
        Some(stem) if testbench.as_os_str() != "-" => format!("{}.vcd", stem.to_string_lossy()),
        _ => format!("{}.vcd", circuit.netlist.scopes()[0].name),
    };
    let bench = Bench { netlist: &circuit.netlist, scenario: &scenario, dump: &dump };
    let bench = bench.write().map_err(|refused| CliError::usage(refused.to_string()))?;
    let design = verilog::design(&circuit.netlist);
    if *testbench == args.output {
        write(&args.output, &format!("{design}\n{bench}"), out)?;
    } else {
        write(&args.output, &design, out)?;
        write(testbench, &bench, out)?;
    }
    Ok(Status::Done)
}

/// Writes a whole file, or none.
pub(super) fn write(path: &Path, text: &str, out: &mut Out) -> Result<(), CliError> {
    if path.as_os_str() == "-" {
        return out.bytes(text.as_bytes());
    }
    let mut file = Output::create(path)?;
    file.write_all(text.as_bytes())?;
    file.complete()?;
    Ok(())
}
