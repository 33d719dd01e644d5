//! `discreta stats`: what circuits are made of, and how deep their logic is.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

use indexmap::IndexMap;
use serde::Serialize;

use super::args::{Format, StatsArgs};
use super::loading::{designs, loader, rendered};
use super::prepare::circuit_of;
use super::{CliError, Out, Status};
use crate::cell::{Edge, Equipment, Parts};
use crate::circuit::Loader;
use crate::netlist::depth::{End, Level, Step};
use crate::netlist::stats::{ScopeStats, Stats};

/// A longer way is shown by its beginning and its end.
const MOST_STEPS: usize = 100;

/// What is printed of one file.
#[derive(Serialize)]
struct Report {
    circuit: String,
    parameters: IndexMap<String, i64>,
    #[serde(flatten)]
    stats: Stats,
    scopes: Vec<ScopeStats>,
}

/// Runs the command.
///
/// # Errors
/// A circuit with faults; those of the others are counted first.
pub fn run(args: &StatsArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut reports = Vec::new();
    let mut faulty = String::new();
    for (path, more) in &designs(&args.circuit) {
        let mut loader = loader(&args.elaboration, more)?;
        let Some(report) = report(&mut loader, path, args) else {
            loader.diagnostics.drop_warnings(|_| true);
            loader.diagnostics.sort();
            faulty.push_str(&rendered(&loader.diagnostics, &loader));
            continue;
        };
        if args.format.format == Format::Json {
            reports.push(report);
            continue;
        }
        let gap = if reports.is_empty() { "" } else { "\n" };
        out.write_fmt(format_args!("{gap}{}", report.text()))?;
        reports.push(report);
    }
    if args.format.format == Format::Json && !reports.is_empty() {
        out.json(&reports)?;
    }
    out.flush()?;
    if faulty.is_empty() { Ok(Status::Done) } else { Err(CliError::Input(faulty)) }
}

/// The counts of what `path` names; none if it has faults.
fn report(loader: &mut Loader, path: &Path, args: &StatsArgs) -> Option<Report> {
    let circuit = circuit_of(loader, path, &args.elaboration.parameter)?;
    if loader.diagnostics.has_errors() {
        return None;
    }
    let mut stats = Stats::of(&circuit.netlist);
    let steps = stats.depth.path.iter_mut().flat_map(|p| &mut p.steps);
    let mut steps: HashMap<String, Vec<&mut Step>> = steps.fold(HashMap::new(), |mut all, step| {
        all.entry(step.cell.clone()).or_insert_with(Vec::new).push(step);
        all
    });
    for cell in circuit.netlist.cell_ids() {
        let Some(source) = circuit.cell_source(cell, &loader.sources) else { continue };
        for step in steps.get_mut(&circuit.netlist.cell_path(cell)).into_iter().flatten() {
            step.source = Some(source.to_owned());
        }
    }
    Some(Report {
        circuit: path.display().to_string(),
        parameters: circuit.parameters,
        stats,
        scopes: if args.depth == 0 { Vec::new() } else { circuit.netlist.scope_stats(args.depth) },
    })
}

impl Report {
    fn text(&self) -> String {
        let s = &self.stats;
        let parameters: Vec<String> = self.parameters.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let with = if parameters.is_empty() { String::new() } else { format!(" with {}", parameters.join(", ")) };
        let mut text = format!("{}: {}{with}\n", self.circuit, s.module);
        section(&mut text, "equipment", &equipment(s));
        section(&mut text, "netlist", &netlist(s));
        let clocks = s.clocks.iter().map(|c| {
            let edge = if c.edge == Edge::Rising { "rising" } else { "falling" };
            [format!("{} {edge}", c.net), c.flip_flops.to_string(), flip_flops(c.flip_flops).into()]
        });
        section(&mut text, "clocks", &clocks.collect::<Vec<_>>());
        let elements = s.elements.iter().map(|e| {
            let inputs = e.inputs.map_or_else(String::new, |n| format!(", {n} inputs"));
            [e.element.to_owned(), e.number.to_string(), format!("{}{inputs}", bits(e.width.into()))]
        });
        section(&mut text, "elements", &elements.collect::<Vec<_>>());
        let modules = s.modules.iter().map(|m| [m.module.clone(), m.number.to_string(), String::new()]);
        section(&mut text, "modules", &modules.collect::<Vec<_>>());
        self.depth(&mut text);
        self.scopes(&mut text);
        text
    }

    fn depth(&self, text: &mut String) {
        let depth = &self.stats.depth;
        let unit = match (depth.unit, depth.levels) {
            (Level::Gates, 1) => "gate",
            (Level::Gates, _) => "gates",
            (Level::Elements, 1) => "element",
            (Level::Elements, _) => "elements",
        };
        let _ = writeln!(text, "\nlogic depth: {} {unit}", depth.levels);
        if let Some(path) = &depth.path {
            let at = |end: &End, none: &str| {
                let pin = end.pin.as_ref().map_or_else(|| none.to_owned(), |pin| format!("({pin})"));
                format!("{} {pin}", end.net)
            };
            let widest = path.steps.iter().map(|s| s.net.chars().count()).max().unwrap_or(0).min(40);
            let _ = writeln!(text, "  from  {}", at(&path.start, "(input)"));
            let left_out = path.steps.len().saturating_sub(MOST_STEPS);
            let gap = MOST_STEPS / 2..MOST_STEPS / 2 + left_out;
            for (i, step) in path.steps.iter().enumerate().filter(|(i, _)| *i == gap.start || !gap.contains(i)) {
                let _ = if gap.contains(&i) {
                    writeln!(text, "     …  {left_out} more")
                } else {
                    let source = step.source.as_ref().map_or_else(String::new, |s| format!(" ({s})"));
                    writeln!(text, "  {:>4}  {:widest$}  {} {}{source}", step.level, step.net, step.element, step.cell)
                };
            }
            let _ = writeln!(text, "  to    {}", at(&path.end, "(output)"));
        }
        for cells in &depth.loops {
            const SHOWN: usize = 6;
            let more = if cells.len() > SHOWN { format!(" and {} more", cells.len() - SHOWN) } else { String::new() };
            let shown = cells.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "  a loop, taken as one level: {shown}{more}");
        }
    }

    fn scopes(&self, text: &mut String) {
        if self.scopes.is_empty() {
            return;
        }
        let mut rows = vec![["scope", "module", "cells", "gates", "inverters", "storage"].map(str::to_owned).to_vec()];
        for s in &self.scopes {
            let indent = "  ".repeat(s.level as usize);
            let name = if s.scope.is_empty() { "(top)" } else { &s.scope };
            let e = &s.equipment;
            let mut row = vec![format!("{indent}{name}"), s.module.clone().unwrap_or_default()];
            row.extend(
                [s.cells, e.gates, e.inverters, e.flip_flops + e.latches + e.sr_flip_flops].map(|n| n.to_string()),
            );
            rows.push(row);
        }
        let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0).min(MOST_WIDE);
        let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
        text.push('\n');
        for row in &rows {
            let cells = row.iter().zip(&widths).enumerate();
            let cells = cells.map(|(i, (cell, &w))| if i < 2 { format!("{cell:w$}") } else { format!("{cell:>w$}") });
            let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
        }
    }
}

/// No column is made wider for one long name.
const MOST_WIDE: usize = 200;

/// A name, a number and what is to be said of it.
type Row = [String; 3];

/// A heading and rows whose columns are aligned; nothing if there is no row.
fn section(text: &mut String, heading: &str, rows: &[Row]) {
    if rows.is_empty() {
        return;
    }
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0).min(MOST_WIDE);
    let (name, number) = (width(0), width(1));
    let _ = writeln!(text, "\n{heading}");
    for [n, count, note] in rows {
        let line = format!("  {n:name$}  {count:>number$}  {note}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

fn bits(n: u64) -> String {
    format!("{n} bit{}", if n == 1 { "" } else { "s" })
}

fn flip_flops(n: u64) -> &'static str {
    if n == 1 { "flip-flop" } else { "flip-flops" }
}

fn equipment(s: &Stats) -> Vec<Row> {
    let e: &Equipment = &s.equipment;
    let mut rows = Vec::new();
    let mut row = |name: &str, number: u64, note: String| {
        if number > 0 {
            rows.push([name.to_owned(), number.to_string(), note]);
        }
    };
    let constant = match s.constant_gates {
        0 => String::new(),
        n => format!("; {n} of them constant"),
    };
    row("gates", e.gates, format!("as drawn; {} of two inputs{constant}", e.two_input_gates));
    row("inverters", e.inverters, String::new());
    row("buffers", e.buffers, String::new());
    row("flip-flops", e.flip_flops, String::new());
    row("latches", e.latches, String::new());
    row("SR flip-flops", e.sr_flip_flops, String::new());
    row("SR of two gates", s.depth.sr_of_gates, "their gates are among the gates".into());
    row("half adders", e.half_adders, String::new());
    row("full adders", e.full_adders, String::new());
    let mut parts = |name: &str, p: Parts, note: &str| row(name, p.number, format!("{}{note}", bits(p.bits)));
    parts("memories", e.memories, "");
    parts("adders", e.adders, "");
    parts("multipliers", e.multipliers, " of product");
    parts("dividers", e.dividers, "");
    parts("shifters", e.shifters, "");
    parts("comparators", e.comparators, "");
    parts("multiplexers", e.multiplexers, "");
    parts("counters", e.counters, ", among the flip-flops");
    parts("accumulators", e.accumulators, ", among the flip-flops; each has an adder");
    parts("tri-state drivers", e.tristates, "");
    parts("delays", e.delays, "");
    row("clocks", e.clocks, String::new());
    rows
}

fn netlist(s: &Stats) -> Vec<Row> {
    let mut rows = vec![["cells".to_owned(), s.cells().to_string(), String::new()]];
    for (name, p) in [("nets", s.nets), ("inputs", s.inputs), ("outputs", s.outputs)] {
        rows.push([name.to_owned(), p.number.to_string(), bits(p.bits)]);
    }
    if let Some(f) = &s.fan_out {
        rows.push(["fan-out at most".to_owned(), f.inputs.to_string(), format!("inputs read {}", f.net)]);
    }
    rows
}
