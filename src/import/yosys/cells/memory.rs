//! Memories: whole as `$mem` and `$mem_v2`, or in parts, as a cell for each port and each piece of what they hold at first.
//!
//! A wide port becomes as many ports as words it has, which differ in the low bits of their address.

use std::collections::HashMap;
use std::sync::Arc;

use super::super::file::{Bit, Cell, Declared};
use super::super::import::{Here, Import};
use super::{Fault, Lower, Site};
use crate::cell::memory::{ReadPort, WritePort};
use crate::cell::{CellKind, Edge, Memory};
use crate::import::readmem::Shape;
use crate::netlist::Bus;
use crate::value::Word;
use crate::value::word::{extract, words};
use crate::{Logic, Value};

pub(super) fn find(name: &str) -> Option<Lower> {
    Some(match name {
        "$mem" => |s| packed(s, false),
        "$mem_v2" => |s| packed(s, true),
        _ => return None,
    })
}

/// Whether a cell is a part of a memory.
pub(super) fn is_part(name: &str) -> bool {
    matches!(name, "$memrd" | "$memrd_v2" | "$memwr" | "$memwr_v2" | "$meminit" | "$meminit_v2")
}

/// A memory while its ports are brought together. The pins are those of the cell.
#[derive(Default)]
struct Draft {
    width: u32,
    size: u32,
    offset: i32,
    abits: u32,
    init: Vec<Word>,
    start: Vec<Logic>,
    reads: Vec<ReadPort>,
    writes: Vec<WritePort>,
    pins: [Bus; 9],
    rd_data: Bus,
}

/// Bits of an address that the cell can have.
const ABITS: u32 = 64;

impl Draft {
    fn new(s: &mut Site, width: u32, size: u32, offset: i32) -> Result<Draft, Fault> {
        if width == 0 {
            return Err("a memory whose words have no bits".to_owned().into());
        }
        let fits = s.import.take_memory(&s.cell.name, u64::from(width) * u64::from(size));
        // what is too large is told, and ends the import
        let size = if fits { size } else { 0 };
        Ok(Draft { width, size, offset, init: Memory::contents(width, size), ..Draft::default() })
    }

    fn push(&mut self, pin: usize, bus: &Bus) {
        self.pins[pin].append(bus);
    }

    /// Adds the cell, unless nothing can see what it holds.
    fn finish(mut self, s: &mut Site, name: &str) {
        let path = s.import.builder.path(s.here.scope, name);
        let shape = Shape { width: self.width, size: self.size, offset: self.offset };
        s.import.fill_memory(path, shape, &mut self.init);
        if self.reads.is_empty() {
            return;
        }
        let mut start = Value::unknown(self.start.len() as u32);
        self.start.iter().enumerate().for_each(|(i, &b)| start.set_bit(i as u32, b));
        let memory = Memory {
            width: self.width,
            size: self.size,
            offset: self.offset,
            abits: self.abits,
            init: Arc::from(self.init),
            start,
            reads: self.reads,
            writes: self.writes,
        };
        let kind = CellKind::Memory(Box::new(memory));
        s.import.builder.cell(s.here.scope, name, kind, self.pins.to_vec(), vec![self.rd_data]);
    }
}

fn edge(clocked: bool, positive: bool) -> Option<Edge> {
    clocked.then_some(if positive { Edge::Rising } else { Edge::Falling })
}

fn part(value: &Value, lo: u32, width: u32) -> Value {
    let all: Vec<Word> = value.words().collect();
    let mut some = vec![Word::ZERO; words(width)];
    extract(&mut some, &all, lo, width);
    Value::from_words(&some, width)
}

fn flags(value: &Value, lo: u32, n: u32) -> Box<[bool]> {
    (lo..lo + n).map(|i| value.bit(i) == Logic::One).collect()
}

/// What a parameter says in so many bits; zeros where it says nothing.
fn sized(s: &Site, name: &str, width: u64) -> Result<Value, Fault> {
    let width = u32::try_from(width).map_err(|_| format!("its parameter `{name}` would have {width} bits"))?;
    Ok(s.sized(name, width))
}

fn offset(s: &Site) -> i32 {
    let value = s.sized("OFFSET", 32);
    value.to_i64().map_or(0, |n| n as i32)
}

fn packed(s: &mut Site, v2: bool) -> Result<(), Fault> {
    let [width, size, abits] = [s.number("WIDTH")?, s.number("SIZE")?, s.number("ABITS")?];
    let [reads, writes] = [s.number("RD_PORTS")?, s.number("WR_PORTS")?];
    narrow(abits)?;
    let (r, w) = (u64::from(reads), u64::from(writes));
    let mut d = Draft::new(s, width, size, offset(s))?;
    d.abits = abits;
    let pins = ["RD_CLK", "RD_EN", "RD_ARST", "RD_SRST", "RD_ADDR", "WR_CLK", "WR_EN", "WR_ADDR", "WR_DATA"];
    let (a, n) = (u64::from(abits), u64::from(width));
    let expected = [r, r, r, r, r * a, w, w * n, w * a, w * n];
    for (pin, (port, expected)) in pins.into_iter().zip(expected).enumerate() {
        d.pins[pin] = if !v2 && matches!(port, "RD_ARST" | "RD_SRST") {
            s.constant(Logic::Zero, reads)
        } else {
            // of no port there is still a bit, as Verilog has no vectors without
            let bus = s.input(port);
            if expected == 0 { Bus::default() } else { bus }
        };
        let found = d.pins[pin].width();
        if u64::from(found) != expected {
            return Err(format!("`{port}` is connected to {found} bits, and is {expected}").into());
        }
    }
    d.rd_data = s.output("RD_DATA");
    if reads == 0 {
        d.rd_data = Bus::default();
    }
    if u64::from(d.rd_data.width()) != r * n {
        return Err(format!("`RD_DATA` is connected to {} bits, and is {}", d.rd_data.width(), r * n).into());
    }
    let [clocked, positive] = [sized(s, "RD_CLK_ENABLE", r)?, sized(s, "RD_CLK_POLARITY", r)?];
    let [wide, enable_first] = [sized(s, "RD_WIDE_CONTINUATION", r)?, sized(s, "RD_CE_OVER_SRST", r)?];
    let [arst, srst] = [sized(s, "RD_ARST_VALUE", r * n)?, sized(s, "RD_SRST_VALUE", r * n)?];
    let [transparent, collides] = [sized(s, "RD_TRANSPARENCY_MASK", r * w)?, sized(s, "RD_COLLISION_X_MASK", r * w)?];
    let [wr_clocked, wr_positive] = [sized(s, "WR_CLK_ENABLE", w)?, sized(s, "WR_CLK_POLARITY", w)?];
    let [wr_wide, priority] = [sized(s, "WR_WIDE_CONTINUATION", w)?, sized(s, "WR_PRIORITY_MASK", w * w)?];
    let [rd_clk, wr_clk] = [s.written("RD_CLK").to_vec(), s.written("WR_CLK").to_vec()];
    let old = sized(s, "RD_TRANSPARENT", r)?;
    let is = |value: &Value, i: u32| value.bit(i) == Logic::One;
    for i in 0..reads {
        let clock = edge(is(&clocked, i), is(&positive, i));
        at_once(s, "RD_SRST", i, clock)?;
        // as Yosys reads it: of the ports with the same clock
        let same = |j: u32| {
            clock.is_some()
                && is(&old, i)
                && clock == edge(is(&wr_clocked, j), is(&wr_positive, j))
                && rd_clk[i as usize] == wr_clk[j as usize]
        };
        d.reads.push(ReadPort {
            clock,
            wide: is(&wide, i),
            transparent: if v2 { flags(&transparent, i * writes, writes) } else { (0..writes).map(same).collect() },
            collides: flags(&collides, i * writes, writes),
            arst_value: part(&arst, i * width, width),
            srst_value: part(&srst, i * width, width),
            enable_first: is(&enable_first, i),
        });
    }
    for j in 0..writes {
        d.writes.push(WritePort {
            clock: edge(is(&wr_clocked, j), is(&wr_positive, j)),
            wide: is(&wr_wide, j),
            priority: if v2 { flags(&priority, j * writes, writes) } else { (0..writes).map(|k| k < j).collect() },
        });
    }
    d.start = if v2 {
        let start = sized(s, "RD_INIT_VALUE", r * n)?;
        (0..start.width()).map(|i| start.bit(i)).collect()
    } else {
        vec![Logic::X; (reads * width) as usize]
    };
    if let Some(init) = s.value("INIT").filter(|v| v.bits().any(|b| b != Logic::X)) {
        let words = (init.width() / width).min(d.size);
        let all: Vec<Word> = init.words().collect();
        let mut one = vec![Word::ZERO; crate::value::word::words(width)];
        for i in 0..words {
            extract(&mut one, &all, i * width, width);
            Memory::set_word(width, &mut d.init, i, &Value::from_words(&one, width), |_| true);
        }
    }
    let name = s.cell.name.to_string();
    d.finish(s, &name);
    Ok(())
}

fn narrow(abits: u32) -> Result<(), Fault> {
    if abits > ABITS {
        return Err(format!("addresses of {abits} bits; {ABITS} are the most that are taken").into());
    }
    Ok(())
}

/// Refuses a reset at a clock edge of a port that has no clock.
fn at_once(s: &Site, pin: &str, i: u32, clock: Option<Edge>) -> Result<(), Fault> {
    match s.written(pin).get(i as usize).map(|b| b.constant()) {
        Some(None | Some(Logic::One)) if clock.is_none() => {
            Err(format!("read port {i} has no clock and a synchronous reset").into())
        }
        _ => Ok(()),
    }
}

/// The cells that are one memory, by their places in the module.
#[derive(Default)]
struct Parts {
    reads: Vec<usize>,
    writes: Vec<(u32, usize)>,
    inits: Vec<(u32, usize)>,
}

/// Lowers the parts of memories; calls `told` with the faulty cells.
pub(in super::super) fn parts<'f, 'a>(
    import: &mut Import<'f, 'a>,
    here: &Here<'f, 'a>,
    cells: &[usize],
    mut told: impl FnMut(&mut Import<'f, 'a>, &'f Cell<'a>, Fault),
) {
    let module = here.module;
    let mut memories: HashMap<String, Parts> = HashMap::new();
    for &at in cells {
        let cell = &module.cells[at];
        let s = Site { import, here, cell };
        let id = s.string("MEMID").unwrap_or_default();
        let id = id.strip_prefix('\\').unwrap_or(&id);
        if !module.memories.iter().any(|m| m.name == id) {
            let message = format!("it is part of the memory `{id}`, which the module does not have");
            let fault = Fault {
                help: Some("let Yosys bring memories together: `memory_collect`, or `prep`".into()),
                ..Fault::from(message)
            };
            told(import, cell, fault);
            continue;
        }
        let parts = memories.entry(id.to_owned()).or_default();
        let kind = s.import.file.terms.text(cell.kind);
        let order = match &**kind {
            "$memwr_v2" => s.number("PORTID"),
            _ => s.number("PRIORITY"),
        };
        match (order, &**kind) {
            (Err(fault), _) => told(import, cell, fault),
            (_, "$memrd" | "$memrd_v2") => parts.reads.push(at),
            (Ok(order), "$memwr" | "$memwr_v2") => parts.writes.push((order, at)),
            (Ok(order), _) => parts.inits.push((order, at)),
        }
    }
    for memory in &module.memories {
        let Some(mut parts) = memories.remove(&*memory.name) else { continue };
        parts.writes.sort_unstable();
        parts.inits.sort_unstable();
        let cell = |at: usize| &module.cells[at];
        let Some(first) = parts.reads.first().map(|&at| cell(at)) else { continue };
        let mut faults = Vec::new();
        import.at_cell(here, parts.reads[0]);
        unpacked(import, here, memory, first, &parts, &mut faults);
        faults.into_iter().for_each(|(at, fault)| told(import, cell(at), fault));
    }
}

/// A part of a memory that reads or writes: its clock, and the words that it has at once.
struct PartPort {
    clock: Option<Edge>,
    bit: Bit,
    /// How many words it has, and how many bits of the address tell them apart.
    words: u32,
    log2: u32,
    address: Bus,
}

fn part_port(s: &mut Site, width: u32, data: &str) -> Result<PartPort, Fault> {
    let clock = edge(s.flag("CLK_ENABLE"), s.flag("CLK_POLARITY"));
    s.bit("CLK")?;
    let address = s.input("ADDR");
    narrow(address.width())?;
    let bits = s.written(data).len() as u32;
    let words = bits / width;
    if !bits.is_multiple_of(width) || !words.is_power_of_two() || words.trailing_zeros() > address.width() {
        return Err(format!("`{data}` has {bits} bits, and a word of the memory {width}").into());
    }
    Ok(PartPort { clock, bit: s.written("CLK")[0], words, log2: words.trailing_zeros(), address })
}

impl PartPort {
    /// The address of one of its words.
    fn address(&self, s: &mut Site, word: u32, abits: u32) -> Bus {
        let low = s.import.constant(&Value::from_u64(word.into(), self.log2));
        let high = self.address.slice(self.log2, self.address.width() - self.log2);
        let zeros = s.constant(Logic::Zero, abits - self.address.width());
        Bus::concat([&low, &high, &zeros])
    }
}

fn unpacked<'f, 'a>(
    import: &mut Import<'f, 'a>,
    here: &Here<'f, 'a>,
    memory: &Declared<'a>,
    first: &'f Cell<'a>,
    parts: &Parts,
    faults: &mut Vec<(usize, Fault)>,
) {
    let width = memory.width;
    let module = here.module;
    let mut ok = |at: usize, result: Result<(), Fault>| result.map_err(|fault| faults.push((at, fault))).is_ok();
    macro_rules! site {
        ($at:expr) => {
            Site { import: &mut *import, here, cell: &module.cells[$at] }
        };
    }
    let mut d =
        match Draft::new(&mut Site { import: &mut *import, here, cell: first }, width, memory.size, memory.offset) {
            Ok(draft) => draft,
            Err(fault) => {
                ok(parts.reads[0], Err(fault));
                return;
            }
        };
    let mut ports = Vec::new();
    let all = parts.reads.iter().map(|&at| (at, "DATA")).chain(parts.writes.iter().map(|&(_, at)| (at, "DATA")));
    for (at, data) in all {
        let port = part_port(&mut site!(at), width, data);
        match port {
            Ok(port) => ports.push((at, port)),
            Err(fault) => _ = ok(at, Err(fault)),
        }
    }
    if ports.len() < parts.reads.len() + parts.writes.len() {
        return;
    }
    d.abits = ports.iter().map(|p| p.1.address.width()).max().unwrap_or(0);
    let (reads, writes) = ports.split_at(parts.reads.len());
    // for each word that is written at once the number of its port as the masks have it, and its port
    let written: Vec<(u32, usize)> = writes
        .iter()
        .zip(&parts.writes)
        .enumerate()
        .flat_map(|(k, ((_, port), &(id, _)))| (0..port.words).map(move |_| (id, k)))
        .collect();
    let marked = |mask: &Value, id: u32| id < mask.width() && mask.bit(id) == Logic::One;
    for &(at, ref port) in reads {
        let mut s = site!(at);
        let done = read_part(&mut s, &mut d, port, writes, &written, marked);
        ok(at, done);
    }
    for (k, &(at, ref port)) in writes.iter().enumerate() {
        let mut s = site!(at);
        let old = *s.import.file.terms.text(s.cell.kind) == "$memwr";
        let mask = s.value("PRIORITY_MASK").unwrap_or_else(|| Value::unknown(0));
        let (clk, en, data) = (s.input("CLK"), s.input("EN"), s.input("DATA"));
        if !ok(at, s.expect_width("EN", en.width(), data.width())) {
            continue;
        }
        for word in 0..port.words {
            let address = port.address(&mut s, word, d.abits);
            let some = |bus: &Bus| bus.slice(word * width, width);
            for (pin, bus) in [(5, &clk), (6, &some(&en)), (7, &address), (8, &some(&data))] {
                d.push(pin, bus);
            }
            let wins = |&(id, other): &(u32, usize)| {
                let (a, b) = (port, &writes[other].1);
                if old {
                    other < k && a.clock == b.clock && (a.clock.is_none() || a.bit == b.bit)
                } else {
                    marked(&mask, id)
                }
            };
            let priority = written.iter().map(wins).collect();
            d.writes.push(WritePort { clock: port.clock, wide: word > 0, priority });
        }
    }
    for &(_, at) in &parts.inits {
        let done = init_part(&mut site!(at), &mut d);
        ok(at, done);
    }
    if faults.is_empty() {
        let name = memory.name.to_string();
        d.finish(&mut Site { import, here, cell: first }, &name);
    }
}

fn read_part(
    s: &mut Site,
    d: &mut Draft,
    port: &PartPort,
    writes: &[(usize, PartPort)],
    written: &[(u32, usize)],
    marked: impl Fn(&Value, u32) -> bool,
) -> Result<(), Fault> {
    let old = *s.import.file.terms.text(s.cell.kind) == "$memrd";
    let transparent = s.flag("TRANSPARENT") && port.clock.is_some();
    let none = || Value::unknown(0);
    let masks = ["TRANSPARENCY_MASK", "COLLISION_X_MASK"].map(|m| s.value(m).unwrap_or_else(none));
    let clk = s.bit("CLK")?;
    let en = s.bit("EN")?;
    let off = s.constant(Logic::Zero, 1);
    let (arst, srst) = if old { (off.clone(), off) } else { (s.bit("ARST")?, s.bit("SRST")?) };
    at_once(s, "SRST", 0, port.clock)?;
    let width = d.width;
    let all = port.words * width;
    // the ports of old have x where the others have values
    let value = |name: &str| if old { Value::unknown(all) } else { s.sized(name, all) };
    let [start, arst_value, srst_value] = ["INIT_VALUE", "ARST_VALUE", "SRST_VALUE"].map(value);
    let enable_first = s.flag("CE_OVER_SRST");
    let data = s.output("DATA");
    for word in 0..port.words {
        let address = port.address(s, word, d.abits);
        for (pin, bus) in [(0, &clk), (1, &en), (2, &arst), (3, &srst), (4, &address)] {
            d.push(pin, bus);
        }
        d.rd_data.append(&data.slice(word * width, width));
        d.start.extend((0..width).map(|i| start.bit(word * width + i)));
        let seen = |&(id, other): &(u32, usize)| {
            let b = &writes[other].1;
            if old { transparent && port.clock == b.clock && port.bit == b.bit } else { marked(&masks[0], id) }
        };
        d.reads.push(ReadPort {
            clock: port.clock,
            wide: word > 0,
            transparent: written.iter().map(seen).collect(),
            collides: written.iter().map(|&(id, _)| marked(&masks[1], id)).collect(),
            arst_value: part(&arst_value, word * width, width),
            srst_value: part(&srst_value, word * width, width),
            enable_first,
        });
    }
    Ok(())
}

fn init_part(s: &mut Site, d: &mut Draft) -> Result<(), Fault> {
    let constant = |s: &Site, port: &str| -> Result<Value, Fault> {
        let bits = s.written(port);
        let mut value = Value::unknown(bits.len() as u32);
        for (i, bit) in bits.iter().enumerate() {
            let constant = bit.constant().ok_or_else(|| format!("`{port}` is not constant"))?;
            value.set_bit(i as u32, constant);
        }
        Ok(value)
    };
    let (address, data) = (constant(s, "ADDR")?, constant(s, "DATA")?);
    let old = *s.import.file.terms.text(s.cell.kind) == "$meminit";
    let enable = if old { Value::repeat(Logic::One, d.width) } else { constant(s, "EN")? };
    s.expect_width("EN", enable.width(), d.width)?;
    if !data.width().is_multiple_of(d.width) {
        return Err(format!("`DATA` has {} bits, and a word of the memory {}", data.width(), d.width).into());
    }
    // as a number of 32 bits with a sign, which it is where the offset is
    let Some(address) = address.to_u64() else { return Err(format!("its address is {address}").into()) };
    let first = i64::from(address as u32 as i32) - i64::from(d.offset);
    for word in 0..data.width() / d.width {
        let Some(index) = u32::try_from(first + i64::from(word)).ok().filter(|&i| i < d.size) else { continue };
        let value = part(&data, word * d.width, d.width);
        Memory::set_word(d.width, &mut d.init, index, &value, |i| enable.bit(i) == Logic::One);
    }
    Ok(())
}
