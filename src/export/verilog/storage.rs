//! Storage, and what acts by time.

use std::collections::HashSet;

use super::memory;
use super::text::{literal, range, repeat, zeros};
use super::writer::Writer;
use crate::cell::{CellKind, Counter, Edge, Flop};
use crate::netlist::hierarchy::{Cell, Piece};
use crate::netlist::{NetId, Netlist};
use crate::{Logic, Value};

/// Whether a control can never be 1: it is open or tied.
pub(super) fn is_never(pieces: &[Piece]) -> bool {
    match pieces {
        [] => true,
        [Piece::Constant(value)] => value.bit(0) != Logic::One,
        _ => false,
    }
}

fn is_always(pieces: &[Piece]) -> bool {
    matches!(pieces, [Piece::Constant(value)] if value.bit(0) == Logic::One)
}

/// How a storage cell is written.
#[derive(PartialEq)]
enum Form {
    /// As an `always` block.
    Always,
    /// As an instance of a module of `support.v`.
    Module,
    /// Its reset never ends.
    Reset,
}

/// What a level-sensitive cell is held at, where its controls are tied so that nothing can change it.
fn held(cell: &Cell, kind: &CellKind) -> Option<Value> {
    let (never, always) = (|pin: usize| is_never(&cell.inputs[pin]), |pin: usize| is_always(&cell.inputs[pin]));
    match kind {
        CellKind::Sr { set_dominates, init } => {
            let (first, second) = if *set_dominates { (0, 1) } else { (1, 0) };
            let value = |pin: usize| Some(Value::from_u64(u64::from(pin == 0), 1));
            match () {
                () if always(first) => value(first),
                () if never(first) && always(second) => value(second),
                () if never(first) && never(second) => Some(init.clone()),
                () => None,
            }
        }
        CellKind::Latch(f) => match () {
            () if always(3) => Some(f.reset_value.clone()),
            () if never(3) && always(2) => Some(f.set_value.clone()),
            () if never(3) && never(2) && never(0) => Some(f.init.clone()),
            () if never(3) && never(2) && always(0) => match cell.inputs[1].as_slice() {
                [Piece::Constant(value)] => Some(value.clone()),
                _ => None,
            },
            () => None,
        },
        _ => None,
    }
}

fn form(cell: &Cell, kind: &CellKind) -> Form {
    let on = |pin: usize| !is_never(&cell.inputs[pin]);
    let (several, reset) = match kind {
        CellKind::Sr { .. } | CellKind::Latch(_) => {
            return if held(cell, kind).is_some() { Form::Reset } else { Form::Always };
        }
        CellKind::Flop(_) => (on(2) || on(3) && on(4), 4),
        CellKind::EdgeFlop(_) => (on(3) || on(4) && on(5), usize::MAX),
        CellKind::Counter(_) => (on(2), 3),
        CellKind::Accumulator(_) => (false, 3),
        _ => return Form::Module,
    };
    let always = |pin: usize| cell.inputs.get(pin).is_some_and(|p| is_always(p));
    let tied = match kind {
        CellKind::Flop(_) => always(3),
        CellKind::EdgeFlop(_) => always(4) || always(5),
        _ => false,
    };
    match () {
        () if always(reset) => Form::Reset,
        () if several || tied => Form::Module,
        () => Form::Always,
    }
}

/// The outputs of a cell that are variables, which an `always` block of the module sets.
pub(super) fn variables(cell: &Cell, kind: &CellKind) -> Vec<Vec<Piece>> {
    match kind {
        CellKind::Memory(m) => memory::variables(cell, m),
        _ if form(cell, kind) == Form::Always && kind.init().is_some() => vec![cell.outputs[0].clone()],
        _ => vec![],
    }
}

/// Writes a cell with state.
pub(super) fn write(w: &mut Writer<'_>, cell: &Cell) {
    let kind = w.kind(cell);
    let name = w.netlist.cell(cell.id).name.clone();
    match (kind, form(cell, kind)) {
        (CellKind::Clock(c), _) => {
            let own = [("PERIOD", c.period), ("HIGH", c.high), ("PHASE", c.phase)];
            let mut own = own.map(|(n, v)| (n.to_owned(), format!("64'd{v}"))).to_vec();
            if !w.clocks.contains(&w.netlist.output(cell.id, 0)) {
                own.push(("LEVEL".to_owned(), "1".to_owned()));
            }
            module(w, cell, "discreta_clock", &own, &[]);
        }
        (CellKind::Delay { width, ticks, init }, _) => {
            let init = init.as_deref().cloned().unwrap_or_else(|| Value::unknown(*width));
            let own = [("WIDTH", width.to_string()), ("TICKS", format!("64'd{ticks}")), ("INIT", literal(&init))];
            module(w, cell, "discreta_delay", &own.map(|(n, v)| (n.to_owned(), v)), &[("a", 0)]);
        }
        (CellKind::RcDelay(rc), _) => {
            let own = [("TAU_BITS", rc.tau), ("RISE_BITS", rc.rise), ("FALL_BITS", rc.fall)];
            let own = own.map(|(n, v)| (n.to_owned(), format!("64'h{:016x} /* {v} */", v.to_bits())));
            module(w, cell, "discreta_rc_delay", &own, &[("a", 0)]);
        }
        (CellKind::Flop(f), Form::Module) => {
            let pins = ["clk", "d", "async_load", "async_set", "async_reset", "en", "sync_set", "sync_reset"];
            flop_module(w, cell, "discreta_register", f, &pins);
        }
        (CellKind::EdgeFlop(f), Form::Module) => {
            let pins = ["clk", "d", "load_data", "async_load", "async_set", "async_reset", "en"];
            flop_module(w, cell, "discreta_edge_register", f, &pins);
        }
        (CellKind::Counter(c), Form::Module) => {
            let mut own = vec![("WIDTH", c.init.width().to_string())];
            if c.edge == Edge::Falling {
                own.push(("FALLING", falling(c.edge)));
            }
            if c.step.to_u64() != Some(1) {
                own.push(("STEP", literal(&c.step)));
            }
            if c.init.bits().any(|b| b != Logic::X) {
                own.push(("INIT", literal(&c.init)));
            }
            let own: Vec<_> = own.into_iter().map(|(n, v)| (n.to_owned(), v)).collect();
            let pins = ["clk", "d", "async_load", "async_reset", "en", "down", "load"];
            let pins: Vec<_> = pins.into_iter().enumerate().map(|(i, n)| (n, i)).collect();
            let q = module(w, cell, "discreta_counter", &own, &pins);
            w.assign(cell, 1, &zero(c.init.width(), &q));
        }
        (_, Form::Reset) => {
            let value = match kind {
                CellKind::Flop(f) => f.reset_value.clone(),
                CellKind::Sr { .. } | CellKind::Latch(_) => held(cell, kind).unwrap_or_else(|| Value::unknown(1)),
                _ => Value::from_u64(0, kind.output_width(0)),
            };
            w.assign(cell, 0, &literal(&value));
            let q = literal(&value);
            second(w, cell, kind, &q);
        }
        (CellKind::Memory(m), _) => memory::write(w, cell, m),
        (_, Form::Module) => {}
        (_, Form::Always) => always(w, cell, kind, &name),
    }
}

/// The nets that are some cell's clock.
pub(super) fn clocks(netlist: &Netlist) -> HashSet<NetId> {
    netlist.cell_ids().flat_map(|c| netlist.clock_sources(c).map(|(bit, ..)| bit.net)).collect()
}

fn zero(width: u32, q: &str) -> String {
    format!("~{}{q}", if width == 1 { "" } else { "|" })
}

fn falling(edge: Edge) -> String {
    format!("1'b{}", u8::from(edge == Edge::Falling))
}

/// What a storage cell has beside its state.
fn second(w: &mut Writer<'_>, cell: &Cell, kind: &CellKind, q: &str) {
    if cell.outputs.len() < 2 || Writer::is_open(cell, 1) {
        return;
    }
    match kind {
        CellKind::Counter(c) => w.assign(cell, 1, &zero(c.init.width(), q)),
        CellKind::Accumulator(a) => {
            let width = a.init.width();
            let all = w.helper(cell, "all");
            let text = format!(
                "wire [{width}:0] {all} = {{1'b0, {q}}} + {{1'b0, {}}} + {{{}, {}}};",
                w.input(cell, 1),
                zeros(width),
                w.input(cell, 2)
            );
            w.unused(&text);
            w.assign(cell, 1, &format!("{all}[{width}]"));
        }
        _ => w.assign(cell, 1, &format!("~{q}")),
    }
}

/// An instance of a module of `support.v`; returns its output.
fn module(
    w: &mut Writer<'_>,
    cell: &Cell,
    of: &'static str,
    parameters: &[(String, String)],
    pins: &[(&str, usize)],
) -> String {
    w.support.insert(of);
    let open = cell.outputs[0].iter().any(|p| matches!(p, Piece::Open(_)));
    let width = w.kind(cell).output_width(0);
    let needed = cell.outputs.len() > 1 && !Writer::is_open(cell, 1) && of != "discreta_delay";
    let direct = !(open || needed && cell.outputs[0].len() > 1);
    let q = if direct { w.text_of(&cell.outputs[0]) } else { w.helper(cell, "q") };
    if !direct {
        w.unused(&format!("wire {}{q};", range(width)));
    }
    let own: Vec<String> = parameters.iter().map(|(n, v)| format!(".{n}({v})")).collect();
    let name = w.name_of(cell);
    let name = w.fresh(cell.block, &name);
    w.line(format!("{of} #({}) {name} (", own.join(", ")));
    let mut connections: Vec<String> =
        pins.iter().map(|&(port, pin)| format!(".{port}({})", w.input(cell, pin))).collect();
    connections.push(format!(".q({q})"));
    let mut line = String::from("   ");
    for (i, connection) in connections.iter().enumerate() {
        if line.len() + connection.len() > 108 {
            w.line(&line);
            line = String::from("   ");
        }
        let comma = if i + 1 < connections.len() { "," } else { "" };
        line += &format!(" {connection}{comma}");
    }
    w.line(line);
    w.line(");");
    if !direct {
        w.connect(cell, 0, &q);
    }
    q
}

fn flop_module(w: &mut Writer<'_>, cell: &Cell, of: &'static str, f: &Flop, pins: &[&'static str]) {
    // what is so anyway need not be said
    let never = |pin: &str| pins.iter().position(|p| *p == pin).is_none_or(|i| is_never(&cell.inputs[i]));
    let mut own = vec![("WIDTH", f.init.width().to_string())];
    if f.edge == Edge::Falling {
        own.push(("FALLING", falling(f.edge)));
    }
    if !(never("async_set") && never("sync_set")) {
        own.push(("SET_VALUE", literal(&f.set_value)));
    }
    if !(never("async_reset") && never("sync_reset")) {
        own.push(("RESET_VALUE", literal(&f.reset_value)));
    }
    if f.init.bits().any(|b| b != Logic::X) {
        own.push(("INIT", literal(&f.init)));
    }
    let own: Vec<_> = own.into_iter().map(|(n, v)| (n.to_owned(), v)).collect();
    let pins: Vec<_> = pins.iter().enumerate().map(|(i, &n)| (n, i)).collect();
    let q = module(w, cell, of, &own, &pins);
    let kind = w.kind(cell);
    second(w, cell, kind, &q);
}

/// The conditions under which a cell takes a value, each before those that follow; the last may have none.
type Rules = Vec<(Option<String>, String)>;

/// An `always` block, or two.
fn always(w: &mut Writer<'_>, cell: &Cell, kind: &CellKind, name: &str) {
    let width = kind.output_width(0);
    let own = w.state_wire(&cell.outputs[0]);
    let q = match &own {
        Some(wire) => wire.clone(),
        None => {
            let q = w.helper(cell, "q");
            w.unused(&format!("reg {}{q};", range(width)));
            q
        }
    };
    if let Some(init) = kind.init()
        && init.bits().any(|b| b != Logic::X)
    {
        w.line(format!("initial {q} = {};", literal(init)));
    }
    let started = if kind.edge().is_some() { w.started() } else { None };
    let input = |pin: usize| w.input(cell, pin);
    let on = |pin: usize| !is_never(&cell.inputs[pin]);
    // of a control that is always on, no condition
    let when = |pin: usize, to: String, rules: &mut Rules| {
        let open_on = cell.inputs[pin].is_empty() && kind.inputs()[pin].default;
        if is_always(&cell.inputs[pin]) || open_on {
            rules.push((None, to));
        } else if on(pin) {
            rules.push((Some(input(pin)), to));
        }
    };
    // until the circuit has first settled its clock makes no edge
    let hold = |rules: &mut Rules| rules.extend(started.iter().map(|s| (Some(format!("!{s}")), q.clone())));
    let mut rules = Rules::new();
    let mut controls = Vec::new();
    let mut level = false;
    match kind {
        CellKind::Sr { set_dominates, .. } => {
            level = true;
            let order = if *set_dominates { [(0, "1'b1"), (1, "1'b0")] } else { [(1, "1'b0"), (0, "1'b1")] };
            order.into_iter().for_each(|(pin, value)| when(pin, value.into(), &mut rules));
        }
        CellKind::Latch(f) => {
            level = true;
            when(3, literal(&f.reset_value), &mut rules);
            when(2, literal(&f.set_value), &mut rules);
            when(0, input(1), &mut rules);
        }
        CellKind::Flop(f) => {
            controls = vec![4, 3];
            when(4, literal(&f.reset_value), &mut rules);
            when(3, literal(&f.set_value), &mut rules);
            hold(&mut rules);
            when(7, literal(&f.reset_value), &mut rules);
            when(6, literal(&f.set_value), &mut rules);
            when(5, input(1), &mut rules);
        }
        CellKind::EdgeFlop(f) => {
            controls = vec![5, 4];
            when(5, literal(&f.reset_value), &mut rules);
            when(4, literal(&f.set_value), &mut rules);
            hold(&mut rules);
            when(6, input(1), &mut rules);
        }
        CellKind::Counter(c) => {
            controls = vec![3];
            when(3, zeros(width), &mut rules);
            hold(&mut rules);
            when(6, input(1), &mut rules);
            when(
                4,
                counted(width, c, &q, &input(5), is_never(&cell.inputs[5]), is_always(&cell.inputs[5])),
                &mut rules,
            );
        }
        CellKind::Accumulator(_) => {
            controls = vec![3];
            when(3, zeros(width), &mut rules);
            hold(&mut rules);
            let ci =
                if is_never(&cell.inputs[2]) { String::new() } else { format!(" + {}", extended(width, &input(2))) };
            when(4, format!("{q} + {}{ci}", input(1)), &mut rules);
        }
        _ => {}
    }
    // what follows a rule without a condition never applies
    let end = rules.iter().position(|r| r.0.is_none()).map_or(rules.len(), |i| i + 1);
    rules.truncate(end);
    let assign = if level { "=" } else { "<=" };
    let head = if level {
        "always @*".to_owned()
    } else {
        let edge = if kind.edge() == Some(Edge::Falling) { "negedge" } else { "posedge" };
        let controls = controls.into_iter().filter(|&p| on(p)).map(|p| format!(" or posedge {}", input(p)));
        format!("always @({edge} {}{})", input(0), controls.collect::<String>())
    };
    let mut lines = vec![format!("{head}  // {}", name.replace(['\n', '\r'], " "))];
    for (i, (condition, to)) in rules.iter().enumerate() {
        let otherwise = if i > 0 { "else " } else { "" };
        lines.push(match condition {
            Some(condition) => format!("    {otherwise}if ({condition}) {q} {assign} {to};"),
            None => format!("    {otherwise}{q} {assign} {to};"),
        });
    }
    if rules.is_empty() {
        lines.clear();
    }
    if level && !lines.is_empty() {
        w.line("/* verilator lint_off LATCH */ // it is one");
        w.line(lines.join("\n"));
        w.line("/* verilator lint_on LATCH */");
    } else {
        w.line(lines.join("\n"));
    }
    if own.is_none() {
        w.connect(cell, 0, &q);
    }
    second(w, cell, kind, &q);
}

/// The state of a counter after a count.
fn counted(width: u32, c: &Counter, q: &str, down: &str, up: bool, always_down: bool) -> String {
    let step = literal(&c.step);
    match () {
        () if up => format!("{q} + {step}"),
        () if always_down => format!("{q} - {step}"),
        // an unknown direction makes all of it unknown
        () => format!("{q} + ({} ^ {step}) + {}", repeat(width, down), extended(width, down)),
    }
}

fn extended(width: u32, bit: &str) -> String {
    if width == 1 { bit.to_owned() } else { format!("{{{}, {bit}}}", zeros(width - 1)) }
}
