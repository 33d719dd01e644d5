//! `discreta export`: a circuit for other tools.

mod netlist;

use std::io::Write as _;
use std::path::Path;

use super::args::{ExportArgs, ExportFormat, ScenarioArgs};
use super::loading::{faults, loader};
use super::prepare::{Changes, Prepared, circuit_of, prepare};
use super::{CliError, Out, Status};
use crate::export::dot;
use crate::export::verilog::{self, Bench};
use crate::wave::output::{Destination, Output};

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, what the format cannot say, a file that cannot be written.
pub fn run(args: &ExportArgs, out: &mut Out) -> Result<Status, CliError> {
    match args.to {
        ExportFormat::Verilog if args.depth.is_some() => Err(CliError::usage("`--depth` is for graphs: `--to dot`")),
        ExportFormat::Verilog => verilog(args, out),
        _ if args.testbench.is_some() => Err(CliError::usage("a test bench is Verilog: `--to verilog`")),
        ExportFormat::YosysJson if args.depth.is_some() => Err(CliError::usage("`--depth` is for graphs: `--to dot`")),
        ExportFormat::YosysJson => {
            let mut loader = loader(&args.elaboration, &args.more)?;
            let text = netlist::yosys_json(&mut loader, &args.circuit, &args.elaboration.parameter);
            write(&args.output, &faults(&mut loader, text)?, out)?;
            Ok(Status::Done)
        }
        ExportFormat::Dot => {
            let mut loader = loader(&args.elaboration, &args.more)?;
            let circuit = circuit_of(&mut loader, &args.circuit, &args.elaboration.parameter);
            let circuit = faults(&mut loader, circuit)?;
            write(&args.output, &dot::write(&circuit.netlist, args.depth.unwrap_or(usize::MAX)), out)?;
            Ok(Status::Done)
        }
    }
}

fn verilog(args: &ExportArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut loader = loader(&args.elaboration, &args.more)?;
    let Some(testbench) = &args.testbench else {
        if args.scenario != ScenarioArgs::default() {
            return Err(CliError::usage("what happens to the circuit is for a test bench")
                .with_hint("add `--testbench FILE`, or leave out -s, --clock, --cycles, --time, --until"));
        }
        let circuit = circuit_of(&mut loader, &args.circuit, &args.elaboration.parameter);
        let circuit = faults(&mut loader, circuit)?;
        write(&args.output, verilog::Design::of(&circuit.netlist).text(), out)?;
        return Ok(Status::Done);
    };
    let changes = Changes::of(&args.elaboration, &args.scenario, &args.trace);
    let prepared = prepare(&mut loader, &args.circuit, &changes);
    let Prepared { circuit, scenario, replay, .. } = faults(&mut loader, prepared)?;
    if replay.is_some() {
        return Err(CliError::usage("a test bench cannot take its inputs from a waveform")
            .with_hint("write the design alone, without --testbench"));
    }
    let dump = match testbench.file_stem() {
        Some(stem) if testbench.as_os_str() != "-" => format!("{}.vcd", stem.to_string_lossy()),
        _ => format!("{}.vcd", circuit.netlist.scopes()[0].name),
    };
    let design = verilog::Design::under(&circuit.netlist, &scenario);
    let bench = Bench { design: &design, scenario: &scenario, dump: &dump };
    let bench = bench.write().map_err(|refused| CliError::usage(refused.to_string()))?;
    let design = design.text();
    if crate::files::resolved(testbench) == crate::files::resolved(&args.output) {
        write(&args.output, &format!("{design}\n{bench}"), out)?;
    } else {
        write(&args.output, design, out)?;
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
