//! `discreta draw`: the schematic of a circuit.

use super::args::DrawArgs;
use super::export::write;
use super::loading::{faults, loader};
use super::prepare::circuit_of;
use super::{CliError, Out, Status};
use crate::draw::{Options, Refusal, svg};

/// Runs the command.
///
/// # Errors
/// Faults of the circuit, a module that is not there, a circuit too large for a picture, a file that cannot be written.
pub fn run(args: &DrawArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut loader = loader(&args.elaboration, &args.more)?;
    let circuit = circuit_of(&mut loader, &args.circuit, &args.elaboration.parameter);
    let circuit = faults(&mut loader, circuit)?;
    let options = Options { depth: args.depth, module: args.module.as_deref() };
    let picture = svg(&circuit.netlist, &options).map_err(|refusal| refused(&refusal, args))?;
    write(&args.output, &picture, out)?;
    Ok(Status::Done)
}

fn refused(refusal: &Refusal, args: &DrawArgs) -> CliError {
    match refusal {
        Refusal::NoModule(names) => {
            let asked = args.module.as_deref().unwrap_or_default();
            let error = CliError::usage(format!("the circuit has no module `{asked}`"));
            let near = names.iter().map(|n| (strsim::damerau_levenshtein(n, asked), n)).min();
            match near {
                Some((distance, name)) if distance <= 2 => error.with_hint(format!("did you mean `{name}`?")),
                _ => error.with_hint(format!("it has {}", names.join(", "))),
            }
        }
        Refusal::TooLarge(_) if args.depth > 0 => {
            CliError::usage(refusal.to_string()).with_hint("open fewer levels (--depth), or draw one module (--module)")
        }
        Refusal::TooLarge(_) => CliError::usage(refusal.to_string()).with_hint("draw one module of it: --module"),
        Refusal::Layout(_) => CliError::usage(refusal.to_string()),
        Refusal::NotBuilt => {
            CliError::usage(refusal.to_string()).with_hint("build it with its feature `draw`, which is on by default")
        }
    }
}
