//! Storage, and what acts by time.

use std::collections::HashSet;

use super::memory;
use super::text::{literal, range, repeat, zeros};
use super::writer::Writer;
use crate::cell::pin::{self, accumulator, counter, edge_flop, flop, latch, sr};
use crate::cell::{Accumulator, CellKind, Clock, Counter, Edge, Flop, Rc, Storage};
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
fn held(cell: &Cell, kind: Storage<'_>) -> Option<Value> {
    let (never, always) = (|pin: usize| is_never(&cell.inputs[pin]), |pin: usize| is_always(&cell.inputs[pin]));
    match kind {
        Storage::Sr { set_dominates, init } => {
            let (first, second) = if set_dominates { (sr::S, sr::R) } else { (sr::R, sr::S) };
            let value = |pin: usize| Some(Value::from_u64(u64::from(pin == sr::S), 1));
            match () {
                () if always(first) => value(first),
                () if never(first) && always(second) => value(second),
                () if never(first) && never(second) => Some(init.clone()),
                () => None,
            }
        }
        Storage::Latch(f) => match () {
            () if always(latch::RESET) => Some(f.reset_value.clone()),
            () if never(latch::RESET) && always(latch::SET) => Some(f.set_value.clone()),
            () if never(latch::RESET) && never(latch::SET) && never(latch::EN) => Some(f.init.clone()),
            () if never(latch::RESET) && never(latch::SET) && always(latch::EN) => {
                match cell.inputs[latch::D].as_slice() {
                    [Piece::Constant(value)] => Some(value.clone()),
                    _ => None,
                }
            }
            () => None,
        },
        Storage::Flop(_) | Storage::EdgeFlop(_) | Storage::Counter(_) | Storage::Accumulator(_) => None,
    }
}

fn form(cell: &Cell, kind: Storage<'_>) -> Form {
    let on = |pin: usize| !is_never(&cell.inputs[pin]);
    let (several, reset) = match kind {
        Storage::Sr { .. } | Storage::Latch(_) => {
            return if held(cell, kind).is_some() { Form::Reset } else { Form::Always };
        }
        Storage::Flop(_) => (on(flop::ALOAD) || on(flop::SET) && on(flop::RESET), flop::RESET),
        Storage::EdgeFlop(_) => (on(edge_flop::ALOAD) || on(edge_flop::SET) && on(edge_flop::RESET), usize::MAX),
        Storage::Counter(_) => (on(counter::ALOAD), counter::RESET),
        Storage::Accumulator(_) => (false, accumulator::RESET),
    };
    let always = |pin: usize| cell.inputs.get(pin).is_some_and(|p| is_always(p));
    let tied = match kind {
        Storage::Flop(_) => always(flop::SET),
        Storage::EdgeFlop(_) => always(edge_flop::SET) || always(edge_flop::RESET),
        Storage::Sr { .. } | Storage::Latch(_) | Storage::Counter(_) | Storage::Accumulator(_) => false,
    };
    match () {
        () if always(reset) => Form::Reset,
        () if several || tied => Form::Module,
        () => Form::Always,
    }
}

/// The outputs of a cell that are variables, which an `always` block of the module sets.
pub(super) fn variables(cell: &Cell, kind: &CellKind) -> Vec<Vec<Piece>> {
    if let CellKind::Memory(m) = kind {
        return memory::variables(cell, m);
    }
    let blocks = kind.storage().filter(|&kind| form(cell, kind) == Form::Always);
    blocks.map(|_| cell.outputs[0].clone()).into_iter().collect()
}

/// Writes a free-running clock.
pub(super) fn clock(w: &mut Writer<'_>, cell: &Cell, c: Clock) {
    let own = [("PERIOD", c.period), ("HIGH", c.high), ("PHASE", c.phase)];
    let mut own = own.map(|(n, v)| (n.to_owned(), format!("64'd{v}"))).to_vec();
    if !w.clocks.contains(&w.netlist.output(cell.id, 0)) {
        own.push(("LEVEL".to_owned(), "1".to_owned()));
    }
    module(w, cell, "discreta_clock", &own, &[]);
}

/// Writes a plain delay.
pub(super) fn delay(w: &mut Writer<'_>, cell: &Cell, width: u32, ticks: u64, init: Option<&Value>) {
    let init = init.cloned().unwrap_or_else(|| Value::unknown(width));
    let own = [("WIDTH", width.to_string()), ("TICKS", format!("64'd{ticks}")), ("INIT", literal(&init))];
    module(w, cell, "discreta_delay", &own.map(|(n, v)| (n.to_owned(), v)), &[("a", pin::delay::A)]);
}

/// Writes an RC delay.
pub(super) fn rc_delay(w: &mut Writer<'_>, cell: &Cell, rc: Rc) {
    let own = [("TAU_BITS", rc.tau), ("RISE_BITS", rc.rise), ("FALL_BITS", rc.fall)];
    let own = own.map(|(n, v)| (n.to_owned(), format!("64'h{:016x} /* {v} */", v.to_bits())));
    module(w, cell, "discreta_rc_delay", &own, &[("a", pin::delay::A)]);
}

/// Writes a cell with state.
pub(super) fn write(w: &mut Writer<'_>, cell: &Cell, kind: Storage<'_>) {
    let name = w.netlist.cell(cell.id).name.clone();
    match (form(cell, kind), kind) {
        (Form::Module, Storage::Flop(f)) => {
            let pins = ["clk", "d", "async_load", "async_set", "async_reset", "en", "sync_set", "sync_reset"];
            flop_module(w, cell, "discreta_register", kind, f, &pins);
        }
        (Form::Module, Storage::EdgeFlop(f)) => {
            let pins = ["clk", "d", "load_data", "async_load", "async_set", "async_reset", "en"];
            flop_module(w, cell, "discreta_edge_register", kind, f, &pins);
        }
        (Form::Module, Storage::Counter(c)) => {
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
        (Form::Reset, _) => {
            let value = match kind {
                Storage::Flop(f) | Storage::EdgeFlop(f) => f.reset_value.clone(),
                Storage::Sr { .. } | Storage::Latch(_) => held(cell, kind).unwrap_or_else(|| Value::unknown(1)),
                Storage::Counter(Counter { init, .. }) | Storage::Accumulator(Accumulator { init, .. }) => {
                    Value::from_u64(0, init.width())
                }
            };
            w.assign(cell, 0, &literal(&value));
            let q = literal(&value);
            second(w, cell, kind, &q);
        }
        // these are never of several asynchronous controls
        (Form::Module, Storage::Sr { .. } | Storage::Latch(_) | Storage::Accumulator(_)) | (Form::Always, _) => {
            always(w, cell, kind, &name);
        }
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
fn second(w: &mut Writer<'_>, cell: &Cell, kind: Storage<'_>, q: &str) {
    if cell.outputs.len() < 2 || Writer::is_open(cell, 1) {
        return;
    }
    match kind {
        Storage::Counter(c) => w.assign(cell, 1, &zero(c.init.width(), q)),
        Storage::Accumulator(a) => {
            let width = a.init.width();
            let all = w.helper(cell, "all");
            let text = format!(
                "wire [{width}:0] {all} = {{1'b0, {q}}} + {{1'b0, {}}} + {{{}, {}}};",
                w.input(cell, accumulator::D),
                zeros(width),
                w.input(cell, accumulator::CI)
            );
            w.unused(&text);
            w.assign(cell, 1, &format!("{all}[{width}]"));
        }
        Storage::Sr { .. } | Storage::Latch(_) | Storage::Flop(_) | Storage::EdgeFlop(_) => {
            w.assign(cell, 1, &format!("~{q}"));
        }
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

fn flop_module(w: &mut Writer<'_>, cell: &Cell, of: &'static str, kind: Storage<'_>, f: &Flop, pins: &[&'static str]) {
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
    second(w, cell, kind, &q);
}

/// The conditions under which a cell takes a value, each before those that follow; the last may have none.
type Rules = Vec<(Option<String>, String)>;

/// An `always` block, or two.
fn always(w: &mut Writer<'_>, cell: &Cell, state: Storage<'_>, name: &str) {
    let kind = w.kind(cell);
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
    match state {
        Storage::Sr { set_dominates, .. } => {
            level = true;
            let order =
                if set_dominates { [(sr::S, "1'b1"), (sr::R, "1'b0")] } else { [(sr::R, "1'b0"), (sr::S, "1'b1")] };
            order.into_iter().for_each(|(pin, value)| when(pin, value.into(), &mut rules));
        }
        Storage::Latch(f) => {
            level = true;
            when(latch::RESET, literal(&f.reset_value), &mut rules);
            when(latch::SET, literal(&f.set_value), &mut rules);
            when(latch::EN, input(latch::D), &mut rules);
        }
        Storage::Flop(f) => {
            controls = vec![flop::RESET, flop::SET];
            when(flop::RESET, literal(&f.reset_value), &mut rules);
            when(flop::SET, literal(&f.set_value), &mut rules);
            hold(&mut rules);
            when(flop::SYNC_RESET, literal(&f.reset_value), &mut rules);
            when(flop::SYNC_SET, literal(&f.set_value), &mut rules);
            when(flop::EN, input(flop::D), &mut rules);
        }
        Storage::EdgeFlop(f) => {
            controls = vec![edge_flop::RESET, edge_flop::SET];
            when(edge_flop::RESET, literal(&f.reset_value), &mut rules);
            when(edge_flop::SET, literal(&f.set_value), &mut rules);
            hold(&mut rules);
            when(edge_flop::EN, input(edge_flop::D), &mut rules);
        }
        Storage::Counter(c) => {
            controls = vec![counter::RESET];
            when(counter::RESET, zeros(width), &mut rules);
            hold(&mut rules);
            when(counter::LOAD, input(counter::D), &mut rules);
            when(
                counter::EN,
                counted(
                    width,
                    c,
                    &q,
                    &input(counter::DOWN),
                    is_never(&cell.inputs[counter::DOWN]),
                    is_always(&cell.inputs[counter::DOWN]),
                ),
                &mut rules,
            );
        }
        Storage::Accumulator(_) => {
            controls = vec![accumulator::RESET];
            when(accumulator::RESET, zeros(width), &mut rules);
            hold(&mut rules);
            let ci = if is_never(&cell.inputs[accumulator::CI]) {
                String::new()
            } else {
                format!(" + {}", extended(width, &input(accumulator::CI)))
            };
            when(accumulator::EN, format!("{q} + {}{ci}", input(accumulator::D)), &mut rules);
        }
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
    let mut lines = vec![format!("{head}  // {}", crate::safe::name(name))];
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
    second(w, cell, state, &q);
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
