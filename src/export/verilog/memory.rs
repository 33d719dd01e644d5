//! Memories: an array, blocks that write to it and blocks or wires that read it.
//!
//! A clocked port assigns by `<=`, so that all ports sample before any of them writes. What Verilog leaves open is said
//! by `#0`, which waits until what changes at once has changed: of ports with different clocks the later one comes
//! later, and a port that shows what another clock's port writes looks whether that clock has made its edge.

use super::text::{literal, part, range};
use super::writer::Writer;
use crate::cell::memory::{ReadPort, WritePort};
use crate::cell::pin::memory::{RD_ADDR, RD_ARST, RD_CLK, RD_EN, RD_SRST, WR_ADDR, WR_CLK, WR_DATA, WR_EN};
use crate::cell::{Edge, Memory};
use crate::netlist::hierarchy::{Cell, Piece};
use crate::{Logic, Value};

/// From so many parts of a word on that are enabled on their own, a loop writes it.
const LOOP: usize = 9;

/// What the clocked read ports give.
pub(super) fn variables(cell: &Cell, m: &Memory) -> Vec<Vec<Piece>> {
    let clocked = (0..m.reads.len()).filter(|&port| m.reads[port].clock.is_some());
    clocked.map(|port| given(cell, m, port)).collect()
}

/// What is read of its inputs: of ports that nothing reads and of bits that are never written nothing is.
pub(super) fn reads(cell: &Cell, m: &Memory) -> Vec<Vec<Piece>> {
    let mut all = Vec::new();
    if Writer::is_open(cell, 0) {
        return all;
    }
    let used = |port: usize| given(cell, m, port).iter().any(|p| !matches!(p, Piece::Open(_)));
    for port in (0..m.reads.len()).filter(|&port| used(port)) {
        all.extend([RD_CLK, RD_EN, RD_ARST, RD_SRST].map(|at| pin(cell, at, port, 1)));
        all.push(pin(cell, RD_ADDR, port, m.abits));
    }
    for port in 0..m.writes.len() {
        all.push(pin(cell, WR_CLK, port, 1));
        all.push(pin(cell, WR_ADDR, port, m.abits));
        let (enable, data) = (pin(cell, WR_EN, port, m.width), pin(cell, WR_DATA, port, m.width));
        for bit in 0..m.width {
            let on = part(&enable, bit, 1);
            if matches!(tied(&on), None | Some(Logic::One)) {
                all.extend([on, part(&data, bit, 1)]);
            }
        }
    }
    all
}

fn given(cell: &Cell, m: &Memory, port: usize) -> Vec<Piece> {
    part(&cell.outputs[0], port as u32 * m.width, m.width)
}

/// A port's part of a pin; 0 where it is open.
fn pin(cell: &Cell, pin: usize, port: usize, width: u32) -> Vec<Piece> {
    match cell.inputs[pin].as_slice() {
        [] => vec![Piece::Constant(Value::from_u64(0, width))],
        pieces => part(pieces, port as u32 * width, width),
    }
}

/// What a control of one bit is, if that never changes.
fn tied(pieces: &[Piece]) -> Option<Logic> {
    match pieces {
        [Piece::Constant(value)] => Some(value.bit(0)),
        [Piece::Open(_)] => Some(Logic::X),
        _ => None,
    }
}

/// A condition: none if it always holds.
enum When {
    Never,
    If(Vec<String>),
}

impl When {
    fn and(mut self, w: &Writer<'_>, control: &[Piece]) -> When {
        match (&mut self, tied(control)) {
            (When::If(all), None) => all.push(w.text_of(control)),
            (When::If(_), Some(Logic::One)) | (When::Never, _) => {}
            (When::If(_), Some(_)) => return When::Never,
        }
        self
    }

    /// A statement under the condition, and whether there is one.
    fn rule(&self, statement: &str) -> Option<(bool, String)> {
        let text = self.then(statement)?;
        Some((matches!(self, When::If(all) if !all.is_empty()), text))
    }

    /// A statement under the condition.
    fn then(&self, statement: &str) -> Option<String> {
        match self {
            When::Never => None,
            When::If(all) if all.is_empty() => Some(statement.to_owned()),
            When::If(all) => Some(format!("if ({}) {statement}", all.join(" && "))),
        }
    }
}

fn always() -> When {
    When::If(vec![])
}

/// A clock and its edge, in the words of an event; none if it never makes one.
fn event(w: &Writer<'_>, clock: &[Piece], edge: Edge) -> Option<String> {
    let word = if edge == Edge::Falling { "negedge" } else { "posedge" };
    tied(clock).is_none().then(|| format!("{word} {}", w.text_of(clock)))
}

/// Several statements as one.
fn block(statements: &[String]) -> String {
    match statements {
        [one] => one.clone(),
        all => format!("begin\n{}\nend", indented(&all.join("\n"))),
    }
}

fn indented(text: &str) -> String {
    text.lines().map(|l| format!("    {l}")).collect::<Vec<_>>().join("\n")
}

/// One memory as it is being written.
struct Parts<'a> {
    m: &'a Memory,
    cell: &'a Cell,
    name: String,
    comment: String,
    /// The event of each write port with a clock.
    events: Vec<Option<String>>,
    /// For each write port what says that its clock is making its edge, if anything asks.
    flags: Vec<Option<String>>,
    /// Where it begins: the first index of the array.
    first: i64,
    /// What changes when a clocked port has written, if ports without a clock have to know.
    touched: Option<String>,
    /// The places of the words that the ports mean: those that read, those that write.
    places: [Vec<Place>; 2],
}

/// Which word a port means.
struct Place {
    /// The address as it is.
    address: String,
    /// The index into the array.
    index: String,
    /// What has to hold for there to be a word, if the index does not tell.
    inside: Option<String>,
}

/// Writes a memory.
pub(super) fn write(w: &mut Writer<'_>, cell: &Cell, m: &Memory) {
    if Writer::is_open(cell, 0) {
        return;
    }
    let name = w.name_of(cell);
    let name = w.fresh(cell.block, &name);
    let comment = crate::safe::name(&w.netlist.cell(cell.id).name).into_owned();
    // a negative first address becomes 0
    let first = i64::from(m.offset.max(0));
    let clock = |w: &Writer<'_>, (at, port): (usize, &WritePort)| event(w, &pin(cell, WR_CLK, at, 1), port.clock?);
    let events: Vec<Option<String>> = m.writes.iter().enumerate().map(|p| clock(w, p)).collect();
    let mut parts = Parts {
        m,
        cell,
        name,
        comment,
        flags: vec![None; events.len()],
        events,
        first,
        touched: None,
        places: [vec![], vec![]],
    };
    let whole = m.abits < 32 && first + i64::from(m.size) == 1 << m.abits;
    // an address may mean more words than there are
    if !whole {
        w.line("/* verilator lint_off WIDTH */ // addresses have their own width");
    }
    parts.write(w);
    if !whole {
        w.line("/* verilator lint_on WIDTH */");
    }
}

impl Parts<'_> {
    fn write(&mut self, w: &mut Writer<'_>) {
        let m = self.m;
        let last = self.first + i64::from(m.size) - 1;
        w.line(format!("reg {}{} [{}:{last}];  // {}", range(m.width), self.name, self.first, self.comment));
        self.initial(w);
        let used = |port: usize| given(self.cell, m, port).iter().any(|p| !matches!(p, Piece::Open(_)));
        let reads: Vec<usize> = (0..m.reads.len()).filter(|&port| used(port)).collect();
        self.places[0] = (0..m.reads.len()).map(|p| self.place(w, RD_ADDR, p, used(p))).collect();
        self.places[1] = (0..m.writes.len()).map(|p| self.place(w, WR_ADDR, p, true)).collect();
        let level = m.writes.iter().any(|p| p.clock.is_none());
        if level {
            let touched = w.helper(self.cell, "touched");
            w.line(format!("reg {touched} = 1'b0;"));
            self.touched = Some(touched);
        }
        self.flags(w, &reads);
        self.clocked_writes(w);
        if level {
            self.level_writes(w);
        }
        for port in reads {
            match m.reads[port].clock {
                Some(_) => self.clocked_read(w, port, level),
                None => self.level_read(w, port),
            }
        }
    }

    /// A variable for a loop.
    fn index(&self, w: &mut Writer<'_>) -> String {
        let index = w.helper(self.cell, "i");
        w.line(format!("integer {index};"));
        index
    }

    /// What it holds at the start: equal words that follow each other by a loop.
    fn initial(&mut self, w: &mut Writer<'_>) {
        let m = self.m;
        let words: Vec<Value> = (0..m.size).map(|i| Memory::word(m.width, &m.init, i)).collect();
        let mut at = self.first;
        let mut lines = Vec::new();
        for run in words.chunk_by(|a, b| a == b) {
            let end = at + run.len() as i64;
            if run[0].bits().any(|b| b != Logic::X) {
                let value = hex(&run[0]);
                if run.len() < 4 {
                    lines.extend((at..end).map(|i| format!("{}[{i}] = {value};", self.name)));
                } else {
                    let i = self.index(w);
                    lines.push(format!("for ({i} = {at}; {i} < {end}; {i} = {i} + 1) {}[{i}] = {value};", self.name));
                }
            }
            at = end;
        }
        if !lines.is_empty() {
            w.line(format!("initial begin\n{}\nend", indented(&lines.join("\n"))));
        }
    }

    /// Which word a port means. The difference to a negative offset has 32 bits or those of the address; of an index of
    /// more than 32 bits some tools take notice of the low ones alone.
    fn place(&self, w: &mut Writer<'_>, addresses: usize, port: usize, used: bool) -> Place {
        let m = self.m;
        let pieces = pin(self.cell, addresses, port, m.abits);
        // a memory of one word may have no address at all
        let address = if m.abits == 0 { "1'd0".to_owned() } else { w.text_of(&pieces) };
        if !used {
            return Place { index: address.clone(), address, inside: None };
        }
        let what = if addresses == RD_ADDR { "from" } else { "to" };
        if m.abits <= 32 && m.offset >= 0 {
            return Place { index: address.clone(), address, inside: None };
        }
        let wide = m.abits.max(32);
        let index = w.helper(self.cell, &format!("{what}{port}"));
        let difference = match m.offset {
            0 => address.clone(),
            n if n < 0 => format!("{address} + {wide}'d{}", n.unsigned_abs()),
            n => format!("{address} - {wide}'d{n}"),
        };
        w.unused(&format!("wire [{}:0] {index} = {difference};", wide - 1));
        let inside = format!("({index} < {wide}'d{})", m.size);
        // counted from the first word, not from its address
        let index = match self.first {
            0 => format!("{index}[31:0]"),
            first => format!("{index}[31:0] + 32'd{first}"),
        };
        Place { address, index, inside: Some(inside) }
    }

    fn word(&self, place: &Place) -> String {
        format!("{}[{}]", self.name, place.index)
    }

    /// What a port reads.
    fn read(&self, port: usize) -> String {
        let place = &self.places[0][port];
        match &place.inside {
            Some(inside) => format!("{inside} === 1'b1 ? {} : {}'bx", self.word(place), self.m.width),
            None => self.word(place),
        }
    }

    /// Variables that tell which clocks are making their edges, for read ports that have other clocks.
    fn flags(&mut self, w: &mut Writer<'_>, reads: &[usize]) {
        for port in 0..self.m.writes.len() {
            let Some(event) = self.events[port].clone() else { continue };
            let asks = |&&r: &&usize| {
                let spec = &self.m.reads[r];
                (spec.transparent[port] || spec.collides[port]) && self.read_event(w, r).is_some_and(|e| e != event)
            };
            if reads.iter().any(|r| asks(&r)) {
                let flag = w.helper(self.cell, &format!("edge{port}"));
                w.line(format!("reg {flag} = 1'b0;"));
                w.line(format!("always @({event}) begin {flag} = 1'b1; {flag} <= 1'b0; end"));
                self.flags[port] = Some(flag);
            }
        }
    }

    fn read_event(&self, w: &Writer<'_>, port: usize) -> Option<String> {
        event(w, &pin(self.cell, RD_CLK, port, 1), self.m.reads[port].clock?)
    }

    /// Statements that assign what a port writes, by `how`, `to` bits that are given as a range, under `when`.
    fn each_part(
        &mut self,
        w: &mut Writer<'_>,
        port: usize,
        when: impl Fn() -> When,
        to: &str,
        how: &str,
        unknown: bool,
    ) -> Vec<String> {
        let width = self.m.width;
        let enable = pin(self.cell, WR_EN, port, width);
        let data = pin(self.cell, WR_DATA, port, width);
        let bits: Vec<Vec<Piece>> = (0..width).map(|i| part(&enable, i, 1)).collect();
        let runs: Vec<usize> = bits.chunk_by(|a, b| a == b).map(<[_]>::len).collect();
        if runs.len() >= LOOP {
            let (on, what) = (self.named(w, "enable", port, &enable), self.named(w, "data", port, &data));
            let i = self.index(w);
            let value = if unknown { "1'bx".to_owned() } else { format!("{what}[{i}]") };
            let inner =
                format!("for ({i} = 0; {i} < {width}; {i} = {i} + 1)\n    if ({on}[{i}]) {to}[{i}] {how} {value};");
            return when().then(&inner.replace('\n', "\n    ")).into_iter().collect();
        }
        let mut statements = Vec::new();
        let mut lo = 0;
        for run in runs {
            let n = run as u32;
            let select = match n {
                n if n == width => String::new(),
                1 => format!("[{lo}]"),
                n => format!("[{}:{lo}]", lo + n - 1),
            };
            let value = if unknown { format!("{n}'bx") } else { w.text_of(&part(&data, lo, n)) };
            let when = when().and(w, &bits[lo as usize]);
            statements.extend(when.then(&format!("{to}{select} {how} {value};")));
            lo += n;
        }
        statements
    }

    /// A name for what a port has of a pin.
    fn named(&self, w: &mut Writer<'_>, what: &str, port: usize, pieces: &[Piece]) -> String {
        if let Some(wire) = w.whole_wire(pieces) {
            return wire;
        }
        let name = w.helper(self.cell, &format!("{what}{port}"));
        let text = w.text_of(pieces);
        w.unused(&format!("wire {}{name} = {text};", range(super::text::width(pieces))));
        name
    }

    /// What a port writes when it does.
    fn writes(&mut self, w: &mut Writer<'_>, port: usize, how: &str) -> Vec<String> {
        let to = self.word(&self.places[1][port]);
        let inside = self.places[1][port].inside.clone();
        self.each_part(w, port, || When::If(inside.iter().cloned().collect()), &to, how, false)
    }

    fn clocked_writes(&mut self, w: &mut Writer<'_>) {
        let ports: Vec<usize> = (0..self.m.writes.len()).filter(|&p| self.events[p].is_some()).collect();
        let several = ports.iter().any(|&p| self.events[p] != self.events[ports[0]]);
        let events = self.events.clone();
        if several {
            w.line("/* verilator lint_off MULTIDRIVEN */ // ports with clocks of their own");
            w.line("/* verilator lint_off STMTDLY */");
        }
        // of several at one instant the last wins
        for (wait, ports) in ports.chunk_by(|&a, &b| events[a] == events[b]).enumerate() {
            let mut statements: Vec<String> = Vec::new();
            for &port in ports {
                statements.extend(self.writes(w, port, "<="));
            }
            if statements.is_empty() {
                continue;
            }
            if let Some(touched) = &self.touched {
                statements.push(format!("{touched} <= ~{touched};"));
            }
            let event = events[ports[0]].clone().unwrap_or_default();
            if let Some(started) = w.started() {
                statements = vec![format!("if ({started}) {}", block(&statements))];
            }
            statements.splice(0..0, (0..wait).map(|_| "#0;".to_owned()));
            w.line(format!("always @({event})\n{}", indented(&block(&statements))));
        }
        if several {
            w.line("/* verilator lint_on STMTDLY */");
            w.line("/* verilator lint_on MULTIDRIVEN */");
        }
    }

    /// Ports that write while they are enabled, again after what has been written by a clock.
    fn level_writes(&mut self, w: &mut Writer<'_>) {
        let (mut statements, mut events) = (vec!["#0;".to_owned()], Vec::new());
        let ports: Vec<usize> = (0..self.m.writes.len()).filter(|&p| self.m.writes[p].clock.is_none()).collect();
        for &port in &ports {
            let all =
                [(WR_EN, "enable", self.m.width), (WR_ADDR, "address", self.m.abits), (WR_DATA, "data", self.m.width)];
            for (at, what, width) in all {
                let pieces = pin(self.cell, at, port, width);
                if !pieces.iter().all(|p| matches!(p, Piece::Constant(_) | Piece::Open(_))) {
                    let name = self.named(w, &format!("{what}_now"), port, &pieces);
                    events.push(name);
                }
            }
            statements.extend(self.writes(w, port, "="));
        }
        events.extend(self.touched.clone());
        statements.push(format!("@({});", events.join(" or ")));
        w.line("/* verilator lint_off STMTDLY */ // what changes at once is to have changed");
        w.line(format!("always {}", block(&statements)));
        w.line("/* verilator lint_on STMTDLY */");
    }

    fn level_read(&mut self, w: &mut Writer<'_>, port: usize) {
        let m = self.m;
        let reset = pin(self.cell, RD_ARST, port, 1);
        let value = match tied(&reset) {
            Some(Logic::One) => literal(&m.reads[port].arst_value),
            Some(_) => self.read(port),
            None => {
                let read = self.read(port);
                format!("{} === 1'b1 ? {} : {read}", w.text_of(&reset), literal(&m.reads[port].arst_value))
            }
        };
        let to = given(self.cell, m, port);
        if to.iter().any(|p| matches!(p, Piece::Open(_))) {
            let all = w.helper(self.cell, &format!("read{port}"));
            w.unused(&format!("wire {}{all} = {value};", range(m.width)));
            w.connect_to(&to, &all);
        } else {
            let to = w.text_of(&to);
            w.line(format!("assign {to} = {value};"));
        }
    }

    fn clocked_read(&mut self, w: &mut Writer<'_>, port: usize, level: bool) {
        let m = self.m;
        let spec: &ReadPort = &m.reads[port];
        let to = given(self.cell, m, port);
        let own = w.state_wire(&to);
        let q = own.clone().unwrap_or_else(|| {
            let q = w.helper(self.cell, &format!("read{port}"));
            w.unused(&format!("reg {}{q};", range(m.width)));
            q
        });
        let start = bits(&m.start, port as u32 * m.width, m.width);
        if start.bits().any(|b| b != Logic::X) {
            w.line(format!("initial {q} = {};", literal(&start)));
        }
        let reset = pin(self.cell, RD_ARST, port, 1);
        let event = self.read_event(w, port);
        let mut events: Vec<String> = event.clone().into_iter().collect();
        // an unknown reset is none, and no edge either
        let is_reset = match tied(&reset) {
            None => {
                let name = w.helper(self.cell, &format!("reset{port}"));
                w.line(format!("wire {name} = {} === 1'b1;", w.text_of(&reset)));
                events.push(format!("posedge {name}"));
                Some(name)
            }
            Some(Logic::One) => {
                w.line(format!("initial {q} = {};", literal(&spec.arst_value)));
                events.clear();
                None
            }
            Some(_) => None,
        };
        // (whether it may not apply, what it does)
        let mut rules: Vec<(bool, String)> = Vec::new();
        rules.extend(is_reset.map(|name| (true, format!("if ({name}) {q} <= {};", literal(&spec.arst_value)))));
        let mut waits = 0;
        if let Some(event) = &event {
            let started = w.started();
            rules.extend(started.map(|s| (true, format!("if (!{s}) {q} <= {q};"))));
            let (enable, clear) = (pin(self.cell, RD_EN, port, 1), pin(self.cell, RD_SRST, port, 1));
            let mut when = always().and(w, &clear);
            if spec.enable_first {
                when = when.and(w, &enable);
            }
            rules.extend(when.rule(&format!("{q} <= {};", literal(&spec.srst_value))));
            let mut statements = vec![format!("{q} <= {};", self.read(port))];
            for written in 0..m.writes.len() {
                let (shows, collides) = (spec.transparent[written], spec.collides[written]);
                let Some(other) = self.events[written].clone().filter(|_| shows || collides) else { continue };
                let same = format!("{} == {}", self.places[0][port].address, self.places[1][written].address);
                let flag = self.flags[written].clone().filter(|_| other != *event);
                waits = waits.max(u32::from(flag.is_some()));
                let when: Vec<String> = flag.into_iter().chain([same]).collect();
                let part = self.each_part(w, written, || When::If(when.clone()), &q, "<=", collides);
                statements.extend(part);
            }
            let reads = always().and(w, &enable).rule(&block(&statements));
            rules.extend(reads);
        }
        // what follows a rule that always applies never does
        let end = rules.iter().position(|r| !r.0).map_or(rules.len(), |i| i + 1);
        let rules: Vec<String> = rules.drain(..end).map(|r| r.1).collect();
        if level {
            waits = 2; // after what is written without a clock
        }
        if !events.is_empty() && !rules.is_empty() {
            let rules = rules.join("\nelse ");
            let text = match waits {
                0 => rules,
                n => block(&(0..n).map(|_| "#0;".to_owned()).chain([rules]).collect::<Vec<_>>()),
            };
            if waits > 0 {
                w.line("/* verilator lint_off STMTDLY */ // which clocks make their edges is to be known");
            }
            w.line(format!("always @({})\n{}", events.join(" or "), indented(&text)));
            if waits > 0 {
                w.line("/* verilator lint_on STMTDLY */");
            }
        }
        if own.is_none() {
            w.connect_to(&to, &q);
        }
    }
}

fn bits(value: &Value, lo: u32, width: u32) -> Value {
    let mut part = Value::unknown(width);
    (0..width).for_each(|i| part.set_bit(i, value.bit(lo + i)));
    part
}

/// A word: programs and tables are read in hex.
fn hex(value: &Value) -> String {
    let width = value.width();
    match value.to_u64() {
        Some(n) if width > 3 => format!("{width}'h{n:0digits$x}", digits = width.div_ceil(4) as usize),
        _ => literal(value),
    }
}
