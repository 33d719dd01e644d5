//! Cells that say something: prints and assertions.

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
    watch(s, flavor, When::Changed, &Bus::concat([&enable, &condition]), Vec::new());
    Ok(())
}

/// A hidden name for bits, so that a run can read them.
fn signal(s: &mut Site, part: &str, bus: Bus) -> SignalId {
    let name = format!("{}${part}", s.cell.name);
    let id = s.import.builder.name(s.here.scope, &name, bus, false, true, None);
    s.import.place_signal(&s.cell.name);
    id
}

fn watch(s: &mut Site, flavor: Flavor, when: When, bus: &Bus, format: Vec<format::Piece>) {
    let signal = signal(s, "watch", bus.clone());
    let source = s.cell.source.map(|t| s.import.file.terms.text(t).to_string());
    let name = s.import.builder.path(s.here.scope, &s.cell.name);
    let priority = s.sized("PRIORITY", 32).to_u64().map_or(0, |n| i64::from(n as u32 as i32));
    let number = s.cell.name.rsplit_once('$').and_then(|(_, number)| number.parse().ok());
    let scope = s.here.scope;
    s.import.monitors.push(Monitor { flavor, name, source, when, signal, format, scope, priority, number });
}

fn formatted(s: &mut Site, flavor: Flavor) -> Result<(), Fault> {
    let format = format::parse(&s.string("FORMAT").unwrap_or_default())?;
    let enable = s.bit("EN")?;
    let condition = if flavor == Flavor::Print { s.constant(Logic::One, 1) } else { s.bit("A")? };
    let arguments = s.input("ARGS");
    let now = Bus::concat([&enable, &condition, &arguments]);
    if !s.flag("TRG_ENABLE") {
        watch(s, flavor, When::Changed, &now, format);
        return Ok(());
    }
    let triggers = s.input("TRG");
    if triggers.width() == 0 {
        watch(s, flavor, When::Start, &now, format);
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
        watch(s, flavor, When::Edge(edges), &held, format.clone());
    }
    Ok(())
}
