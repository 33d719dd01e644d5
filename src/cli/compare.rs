//! `discreta compare`: the documents' comparison of methods, measured.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use super::args::{Assignment, CompareArgs, CompareFormat};
use super::loading::rendered;
use super::prepare::circuit_of;
use super::progress::Progress;
use super::{CliError, Out, Status, interrupt};
use crate::circuit::Limits;
use crate::compare::{self, Comparison, Equipment, MEASURES, Sample, Set, SetKind, Variant, Watch};
use crate::netlist::Stats;

/// With fewer there is no full circle.
const LEAST_BITS: u32 = 4;

/// More bits than this are too many for every segment: they would take minutes.
const ALL_BITS: u32 = 9;

/// More bits than this are too many for a sample.
const MOST_BITS: u32 = 20;

/// What the measures mean, for `--help`.
pub fn measures() -> String {
    MEASURES.iter().map(|(name, meaning)| format!("  {name}: {meaning}\n")).collect()
}

/// Runs the command.
///
/// # Errors
/// A circuit that is missing or has faults, bits that are too many, output that cannot be written.
pub fn run(args: &CompareArgs, out: &mut Out) -> Result<Status, CliError> {
    let most = if args.sample.is_some() { MOST_BITS } else { ALL_BITS };
    if !(LEAST_BITS..=most).contains(&args.bits) {
        let fault =
            CliError::usage(format!("cannot compare with {} bits: they may be {LEAST_BITS} to {most}", args.bits));
        let sample = "draw a sample: --sample 2000";
        return Err(if args.sample.is_none() { fault.with_hint(sample) } else { fault });
    }
    let sample = args.sample.map(|number| Sample { number, seed: args.seed });
    let kinds = [SetKind::Lines, SetKind::Quarters, SetKind::Arcs, SetKind::Circles, SetKind::Space];
    let sets = kinds.map(|kind| Set { kind, bits: args.bits, sample });
    let equipment = equipment(&args.circuits, args.bits)?;
    let groups = draw(&sets)?;
    let claims = compare::claims(&groups, &equipment, args.bits);
    let comparison = Comparison { bits: args.bits, sample, equipment, groups, claims };
    match args.format {
        CompareFormat::Text => out.write_fmt(format_args!("{comparison}"))?,
        CompareFormat::Json => out.json(&comparison)?,
        CompareFormat::Markdown => out.bytes(comparison.markdown().as_bytes())?,
    }
    out.flush()?;
    Ok(Status::Done)
}

/// Draws everything, while the terminal shows how far it is.
fn draw(sets: &[Set]) -> Result<Vec<compare::Group>, CliError> {
    interrupt::watch();
    let total: u64 = sets.iter().map(|set| set.size() * set.variants().len() as u64).sum();
    let done = AtomicU64::new(0);
    let mut progress = Progress::new("comparing", "segments", Some(total));
    let groups = thread::scope(|scope| {
        let watch = Watch { done: &done, stop: interrupt::flag() };
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let measure = move || compare::measure(sets, watch, threads);
        let Ok(measuring) = thread::Builder::new().spawn_scoped(scope, measure) else {
            // nobody is left to show how far it is
            return measure();
        };
        while !measuring.is_finished() {
            progress.set(done.load(Ordering::Relaxed));
            thread::sleep(Duration::from_millis(20));
        }
        measuring.join().ok().flatten()
    });
    progress.clear();
    groups.ok_or_else(|| CliError::usage("interrupted; nothing was compared"))
}

/// Counts the circuits of every method that is compared.
fn equipment(folder: &Path, bits: u32) -> Result<Vec<Equipment>, CliError> {
    let all = [Variant::LINES, Variant::ARCS, Variant::CURVES, Variant::SPACE].concat();
    let plain = all.into_iter().filter(|v| *v == Variant::of(v.method));
    plain
        .map(|variant| {
            let [registers, gates] = compare::circuits(folder, variant.method);
            if !registers.exists() {
                let fault = format!("there is no circuit `{}` of {}", registers.display(), variant.method);
                return Err(CliError::usage(fault)
                    .with_hint("name the folder that holds evaluation, dda and three_axis: --circuits DIR"));
            }
            let registers = stats(&registers, bits)?;
            let gates = if gates.exists() { Some(stats(&gates, bits)?) } else { None };
            Ok(Equipment::of(&variant.name(), &registers, gates.as_ref()))
        })
        .collect()
}

/// The counts of one circuit.
fn stats(path: &Path, bits: u32) -> Result<Stats, CliError> {
    let mut loader = super::loading::plain(Limits::default());
    let width = Assignment { name: "W".to_owned(), value: bits.to_string() };
    match circuit_of(&mut loader, path, &[width]) {
        Some(circuit) if !loader.diagnostics.has_errors() => Ok(Stats::of(&circuit.netlist)),
        _ => Err(CliError::Input(rendered(&loader.diagnostics, &loader))),
    }
}
