//! Cells that say something: prints and assertions.

use std::collections::HashSet;

use super::super::file::{Bit, Cell, Net};
use super::super::format;
use super::super::monitor::{Flavor, Monitor, When};
use super::{Fault, Lower, Site};
use crate::cell::{CellKind, Counter, Edge, Flop};
use crate::netlist::{Bus, SignalId};
use crate::{Logic, Value};

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$assert" => |s| simple(s, Flavor::Assert),
        "$assume" => |s| simple(s, Flavor::Assume),
        "$cover" => |s| simple(s, Flavor::Cover),
        "$print" => |s| formatted(s, Flavor::Print),
        "$check" => |s| {
            let flavor = s.string("FLAVOR").unwrap_or_default();
            match flavor.as_str() {
                "assert" => formatted(s, Flavor::Assert),
                "assume" => formatted(s, Flavor::Assume),
                "cover" => formatted(s, Flavor::Cover),
                other => Err(Fault {
                    message: format!("monitors of flavor `{other}` are for formal proofs"),
                    help: Some("write the netlist without it: `chformal -remove`".into()),
                    ..Fault::from(String::new())
                }),
            }
        },
        _ => return None,
    })
}

fn simple(s: &mut Site, flavor: Flavor) -> Result<(), Fault> {
    let (enable, condition) = (s.bit("EN")?, s.bit("A")?);
    let operands = operands(s);
    let buses: Vec<&Bus> = [&enable, &condition].into_iter().chain(operands.iter().map(|o| &o.1)).collect();
    let names = named(&operands);
    watch(s, flavor, When::Changed, &Bus::concat(buses), names, Vec::new());
    Ok(())
}

/// A hidden name for bits, so that a run can read them.
fn signal(s: &mut Site, part: &str, bus: Bus) -> SignalId {
    let name = format!("{}${part}", s.cell.name);
    let id = s.import.builder.name(s.here.scope, &name, bus, false, true, None);
    s.import.place_signal(&s.cell.name);
    id
}

/// What a condition is made of at most.
const OPERANDS: usize = 8;
/// Cells between a condition and the nets that it is made of, at most.
const MOST_CELLS: usize = 64;

fn named(operands: &[(String, Bus)]) -> Vec<(String, u32)> {
    operands.iter().map(|(name, bus)| (name.clone(), bus.width())).collect()
}

/// The nets with names of which cells make the condition of an assertion, with their bits. Where a flip-flop has sampled the
/// condition, they are sampled with it.
fn operands(s: &mut Site) -> Vec<(String, Bus)> {
    let module = s.here.module;
    let file = s.import.file;
    let bits_of = |cell: &Cell<'_>, wanted: &dyn Fn(&str) -> bool| -> Vec<Vec<Bit>> {
        let connections = module.connections(cell).iter().filter(|(term, _)| wanted(file.terms.text(*term)));
        connections.map(|&(_, range)| module.bits(range).to_vec()).collect()
    };
    let numbers = |bits: &[Bit]| bits.iter().filter_map(|bit| bit.number()).collect::<Vec<u32>>();
    let mut found: Vec<(String, Bus)> = Vec::new();
    // bits, the flip-flop that sampled what is made of them, and whether they are the condition itself, whose name is no news
    let condition = bits_of(s.cell, &|name| name == "A");
    let mut open: Vec<(Vec<u32>, Option<usize>, bool)> =
        condition.iter().map(|bits| (numbers(bits), None, true)).collect();
    let mut passed = HashSet::new();
    while let Some((bits, sampled, first)) = open.pop() {
        let all = |net: &&Net<'_>| {
            let own: HashSet<u32> = numbers(module.bits(net.bits)).into_iter().collect();
            !net.hidden && !bits.is_empty() && bits.iter().all(|bit| own.contains(bit))
        };
        if let Some(net) = module.nets.iter().find(all).filter(|_| !first) {
            if found.len() < OPERANDS && found.iter().all(|(name, _)| *name != net.name) {
                let bus = s.import.bus(s.here, module.bits(net.bits));
                found.push((net.name.to_string(), at_edge(s, bus, sampled)));
            }
            continue;
        }
        for (i, cell) in module.cells.iter().enumerate() {
            let kind: &str = file.terms.text(cell.kind);
            let (output, is_flop) = if kind == "$dff" { ("Q", true) } else { ("Y", false) };
            let makes = bits_of(cell, &|name| name == output).concat();
            if !kind.starts_with('$') || !numbers(&makes).iter().any(|bit| bits.contains(bit)) || !passed.insert(i) {
                continue;
            }
            if is_flop {
                // what is older than the last edge is too long ago
                if sampled.is_none() {
                    open.extend(bits_of(cell, &|name| name == "D").iter().map(|bits| (numbers(bits), Some(i), first)));
                }
                continue;
            }
            let inputs = bits_of(cell, &|name| name != output);
            open.extend(inputs.iter().rev().map(|bits| (numbers(bits), sampled, false)));
        }
        if passed.len() > MOST_CELLS {
            break;
        }
    }
    found
}

/// What bits were at the last edge of a flip-flop's clock.
fn at_edge(s: &mut Site, bus: Bus, flop: Option<usize>) -> Bus {
    let Some(flop) = flop else { return bus };
    let mut site = Site { import: s.import, here: s.here, cell: &s.here.module.cells[flop] };
    let Ok(clock) = site.bit("CLK") else { return bus };
    let edge = if site.flag("CLK_POLARITY") { Edge::Rising } else { Edge::Falling };
    let held = site.spare(bus.width());
    let x = Value::unknown(bus.width());
    let flop = Flop { edge, set_value: x.clone(), reset_value: x.clone(), init: x };
    s.helper("operand", CellKind::Flop(Box::new(flop)), vec![clock, bus], vec![held.clone()]);
    held
}

fn watch(
    s: &mut Site,
    flavor: Flavor,
    when: When,
    bus: &Bus,
    operands: Vec<(String, u32)>,
    format: Vec<format::Piece>,
) {
    let signal = signal(s, "watch", bus.clone());
    let source = s.cell.source.map(|t| s.import.file.terms.text(t).to_string());
    let name = s.import.builder.path(s.here.scope, &s.cell.name);
    let priority = s.sized("PRIORITY", 32).to_u64().map_or(0, |n| i64::from(n as u32 as i32));
    let number = s.cell.name.rsplit_once('$').and_then(|(_, number)| number.parse().ok());
    let scope = s.here.scope;
    s.import.monitors.push(Monitor { flavor, name, source, when, signal, operands, format, scope, priority, number });
}

fn formatted(s: &mut Site, flavor: Flavor) -> Result<(), Fault> {
    let format = format::parse(&s.string("FORMAT").unwrap_or_default())?;
    let enable = s.bit("EN")?;
    let condition = if flavor == Flavor::Print { s.constant(Logic::One, 1) } else { s.bit("A")? };
    let arguments = s.input("ARGS");
    let operands = if flavor == Flavor::Print { Vec::new() } else { operands(s) };
    let buses: Vec<&Bus> = [&enable, &condition, &arguments].into_iter().chain(operands.iter().map(|o| &o.1)).collect();
    let (now, operands) = (Bus::concat(buses), named(&operands));
    if !s.flag("TRG_ENABLE") {
        watch(s, flavor, When::Changed, &now, operands, format);
        return Ok(());
    }
    let triggers = s.input("TRG");
    if triggers.width() == 0 {
        watch(s, flavor, When::Start, &now, operands, format);
        return Ok(());
    }
    let polarity = s.sized("TRG_POLARITY", triggers.width());
    for i in 0..triggers.width() {
        let edge = if polarity.bit(i) == Logic::One { Edge::Rising } else { Edge::Falling };
        let clock = triggers.bit(i);
        let (held, count) = (s.spare(now.width()), s.spare(32));
        let x = Value::unknown(now.width());
        let flop = Flop { edge, set_value: x.clone(), reset_value: x.clone(), init: x };
        s.helper("sample", CellKind::Flop(Box::new(flop)), vec![clock.clone(), now.clone()], vec![held.clone()]);
        let counter = Counter { edge, step: Value::from_u64(1, 32), init: Value::from_u64(0, 32) };
        s.helper("edges", CellKind::Counter(Box::new(counter)), vec![clock], vec![count.clone()]);
        let edges = signal(s, "edges", count);
        watch(s, flavor, When::Edge(edges), &held, operands.clone(), format.clone());
    }
    Ok(())
}
