//! Memories, whole and in parts: random ports, addresses, enables, resets and clocks, of which several make an edge at one
//! instant.

use discreta::{Logic, Value};
use needs::needs;
use serde_json::{Map, Value as Json, json};

use super::batch::{Cell, compare};
use crate::support::Rng;

/// What is compared here.
pub const CELLS: &[&str] =
    &["$mem", "$mem_v2", "$memrd", "$memrd_v2", "$memwr", "$memwr_v2", "$meminit", "$meminit_v2"];

/// What may be random.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// `$mem_v2`, whatever it can be.
    Any,
    /// `$mem_v2` as far as the library's model is right.
    Library,
    /// `$mem`.
    Old,
    /// `$mem` as far as the library's model is right.
    OldLibrary,
    /// `$memrd_v2` and its like, with wide ports.
    Parts,
    /// `$memrd` and its like.
    OldParts,
}

fn bits(list: impl IntoIterator<Item = bool>) -> Value {
    let list: Vec<bool> = list.into_iter().collect();
    let mut value = Value::from_u64(0, list.len() as u32);
    list.iter().enumerate().filter(|b| *b.1).for_each(|(i, _)| value.set_bit(i as u32, Logic::One));
    value
}

fn bit(value: &Value, i: usize) -> bool {
    value.bit(i as u32) == Logic::One
}

/// Puts `part` at bit `lo` of `to`.
fn put(to: &mut Value, lo: u32, part: &Value) {
    (0..part.width()).for_each(|i| to.set_bit(lo + i, part.bit(i)));
}

fn cell(kind: Kind, rng: &mut Rng) -> Cell {
    let old = matches!(kind, Kind::Old | Kind::OldLibrary | Kind::OldParts);
    let library = matches!(kind, Kind::Library | Kind::OldLibrary);
    let in_parts = matches!(kind, Kind::Parts | Kind::OldParts);
    let most = if rng.one_in(4) { 140 } else { 20 };
    let width = 1 + rng.below(most) as u32;
    let log2 = rng.below(3) as u32;
    // the words of a wide port are aligned
    let wide = kind == Kind::Parts || (kind == Kind::Any && rng.one_in(2));
    let most = if rng.one_in(3) { 30 } else { 6 };
    let size = (1 + rng.below(most)).next_multiple_of(if wide { 4 } else { 1 }) as u32;
    let offset = match rng.below(4) {
        0 => (rng.below(6) as i32 - 2) * if wide { 4 } else { 1 },
        _ => 0,
    };
    let abits = match rng.below(12) {
        0 => 32,
        1 => 33 + rng.below(31) as u32,
        _ => 2 + rng.below(4) as u32,
    };
    // the first of each wide port: how many words
    let ports = |least: u64, rng: &mut Rng| -> Vec<bool> {
        let mut continued = Vec::new();
        for _ in 0..least + rng.below(4) {
            let words = if wide && rng.one_in(2) { 1 << log2 } else { 1 };
            continued.extend((0..words).map(|word| word > 0));
        }
        continued
    };
    let (rd_wide, wr_wide) = (ports(1, rng), ports(0, rng));
    let (r, w) = (rd_wide.len(), wr_wide.len());
    // what the parts of a wide port share
    fn shared<T: Copy>(wide: &[bool], mut one: impl FnMut() -> T) -> Vec<T> {
        let mut list: Vec<T> = Vec::new();
        for &continues in wide {
            let next = if continues { *list.last().unwrap() } else { one() };
            list.push(next);
        }
        list
    }
    let clocks = 1 + rng.below(3) as u32;
    let level = !library || rng.one_in(4);
    let wr_level = !library && rng.one_in(4);
    let rd_clocked = shared(&rd_wide, || !(level && rng.one_in(3)));
    let wr_clocked = shared(&wr_wide, || !(wr_level && rng.one_in(3)));
    let rd_positive = shared(&rd_wide, || rng.one_in(2));
    let wr_positive = shared(&wr_wide, || rng.one_in(2));
    let rd_clock = shared(&rd_wide, || rng.below(clocks.into()) as u32);
    let wr_clock = shared(&wr_wide, || rng.below(clocks.into()) as u32);

    let name = if old { "$mem" } else { "$mem_v2" };
    let mut c = Cell::new(name, &[("CLOCKS", clocks)], &[("RD_DATA", r as u32 * width)])
        .number("SIZE", size.into())
        .number("ABITS", abits.into())
        .number("WIDTH", width.into())
        .number("RD_PORTS", r as u64)
        .number("WR_PORTS", w as u64)
        .with("OFFSET", Value::from_i64(offset.into(), 32));
    (c.together, c.known, c.in_parts) = (rng.one_in(2), library, in_parts);
    c.controls.push(("CLOCKS", Value::from_u64(0, clocks)));
    c.taps.push(("RD_CLK", rd_clock.iter().map(|&k| Some(("CLOCKS", k))).collect()));
    let init = match rng.below(4) {
        0 => Value::unknown(1),
        1 => rng.known(size * width),
        _ => rng.four_valued(size * width, 8),
    };
    c = c
        .with("INIT", init)
        .with("RD_CLK_ENABLE", bits(rd_clocked.iter().copied()))
        .with("RD_CLK_POLARITY", bits(rd_positive.iter().copied()));
    // addresses: a base for each port, of which a wide one has the high bits
    let address = |wide: &[bool], input: &'static str| {
        let mut taps = Vec::new();
        let (mut port, mut at) = (0, 0);
        for (i, &continues) in wide.iter().enumerate() {
            (port, at) = if continues { (port, at + 1) } else { (i, 0) };
            let words = 1 + wide[port + 1..].iter().take_while(|w| **w).count() as u32;
            let low = words.trailing_zeros();
            for b in 0..abits {
                taps.push(if b >= low {
                    Some((input, port as u32 * abits + b))
                } else if at >> b & 1 == 1 {
                    Some(("1", 0))
                } else {
                    None
                });
            }
        }
        taps
    };
    c.inputs.push(("RD_AT", r as u32 * abits));
    c.taps.push(("RD_ADDR", address(&rd_wide, "RD_AT")));
    c.inputs.push(("RD_ENABLE", r as u32));
    let one_each = |wide: &[bool], input: &'static str| -> Vec<Option<(&'static str, u32)>> {
        let mut port = 0;
        let at = |(i, &continues): (usize, &bool)| {
            port = if continues { port } else { i };
            Some((input, port as u32))
        };
        wide.iter().enumerate().map(at).collect()
    };
    c.taps.push(("RD_EN", one_each(&rd_wide, "RD_ENABLE")));
    if !old {
        c.inputs.push(("RD_RESET", r as u32));
        c.controls.push(("RD_RESET", Value::from_u64(0, r as u32)));
        // Yosys makes none for a port without a clock, and the library's model of one never ends
        let reset = one_each(&rd_wide, "RD_RESET").into_iter().zip(&rd_clocked);
        c.taps.push(("RD_ARST", reset.map(|(tap, &clocked)| tap.filter(|_| clocked || !library)).collect()));
        c.inputs.push(("RD_CLEAR", r as u32));
        let clear = one_each(&rd_wide, "RD_CLEAR").into_iter().zip(&rd_clocked);
        c.taps.push(("RD_SRST", clear.map(|(tap, &clocked)| tap.filter(|_| clocked)).collect()));
    }
    if w > 0 {
        c.taps.push(("WR_CLK", wr_clock.iter().map(|&k| Some(("CLOCKS", k))).collect()));
        c.inputs.push(("WR_AT", w as u32 * abits));
        c.taps.push(("WR_ADDR", address(&wr_wide, "WR_AT")));
        c.inputs.push(("WR_EN", w as u32 * width));
        c.inputs.push(("WR_DATA", w as u32 * width));
        c = c
            .with("WR_CLK_ENABLE", bits(wr_clocked.iter().copied()))
            .with("WR_CLK_POLARITY", bits(wr_positive.iter().copied()));
    }
    let mask = |rng: &mut Rng, other: Option<&Value>| {
        let both = |i: usize, j: usize| rd_clocked[i] && wr_clocked[j] && !other.is_some_and(|o| bit(o, i * w + j));
        let mut all: Vec<bool> = Vec::new();
        for i in 0..r {
            for j in 0..w {
                let (above, left) = (rd_wide[i], wr_wide[j]);
                let one = match () {
                    () if above => all[(i - 1) * w + j],
                    () if left => all[i * w + j - 1],
                    () => both(i, j) && rng.one_in(3),
                };
                all.push(one);
            }
        }
        if all.is_empty() { Value::from_u64(0, 1) } else { bits(all) }
    };
    let values = r as u32 * width;
    if old {
        c = c.with("RD_TRANSPARENT", bits((0..r).map(|_| kind != Kind::OldLibrary && rng.one_in(2))));
        let same = |i: usize, j: usize| {
            rd_clocked[i] && wr_clocked[j] && rd_positive[i] == wr_positive[j] && rd_clock[i] == wr_clock[j]
        };
        if w > 0 {
            c = c.with("SAME", bits((0..r).flat_map(|i| (0..w).map(move |j| (i, j))).map(|(i, j)| same(i, j))));
        }
        c.model = Some(if library { "\\$mem " } else { "own_mem_v2 V1" });
        if library {
            c.parameters.retain(|p| p.0 != "SAME");
        }
    } else {
        let transparent = mask(rng, None);
        let collides = mask(rng, Some(&transparent));
        let first = shared(&rd_wide, || rng.one_in(2));
        c = c
            .with("RD_TRANSPARENCY_MASK", transparent)
            .with("RD_COLLISION_X_MASK", collides)
            .with("RD_WIDE_CONTINUATION", bits(rd_wide.iter().copied()))
            .with("RD_CE_OVER_SRST", bits(first))
            .with("RD_ARST_VALUE", rng.four_valued(values, 8))
            .with("RD_SRST_VALUE", rng.four_valued(values, 8))
            .with("RD_INIT_VALUE", rng.four_valued(values, 8));
        if w > 0 {
            let priority = (0..w).flat_map(|j| (0..w).map(move |k| k < j));
            c = c.with("WR_PRIORITY_MASK", bits(priority)).with("WR_WIDE_CONTINUATION", bits(wr_wide.iter().copied()));
        }
        c.model = library.then_some("\\$mem_v2 ");
    }
    // addresses that are there, and the same for several ports; enables of all bits and of none
    for _ in 0..10 {
        let at = i64::from(offset) + rng.below(u64::from(size)) as i64;
        for (input, n) in [("RD_AT", r), ("WR_AT", w)].into_iter().filter(|i| i.1 > 0) {
            let mut value = Value::from_u64(0, n as u32 * abits);
            for port in 0..n as u32 {
                let own = i64::from(offset) + rng.below(u64::from(size)) as i64;
                put(&mut value, port * abits, &Value::from_i64(if rng.one_in(2) { own } else { at }, abits));
            }
            c.likely.push((input, value));
        }
        c.likely.push(("RD_ENABLE", Value::repeat(Logic::One, r as u32)));
        if w > 0 {
            let port = |rng: &mut Rng| Value::from_i64(-i64::from(!rng.one_in(4)), width);
            let mut value = Value::from_u64(0, w as u32 * width);
            (0..w as u32).for_each(|i| put(&mut value, i * width, &port(rng)));
            c.likely.push(("WR_EN", value));
        }
    }
    // those of which no port has a bit, as where all of its address is constant
    let unused = |c: &Cell, input: &str| !input.starts_with("WR_EN") && input != "WR_DATA" && c.is_port(input);
    for input in c.inputs.iter().map(|i| i.0).filter(|i| unused(&c, i)).collect::<Vec<_>>() {
        c.inputs.retain(|i| i.0 != input);
        c.controls.retain(|i| i.0 != input);
    }
    c
}

/// The netlist of a memory in parts, from what it is as a whole.
pub fn parts(
    name: &str,
    cell: &Cell,
    pins: &Map<String, Json>,
    cells: &mut Map<String, Json>,
    memories: &mut Map<String, Json>,
) {
    let old = cell.kind == "$mem";
    let value = |n: &str| cell.parameters.iter().find(|p| p.0 == n).map(|p| p.1.clone());
    let number = |n: &str| value(n).and_then(|v| v.to_i64()).unwrap_or(0);
    let [width, size, abits, r, w] = ["WIDTH", "SIZE", "ABITS", "RD_PORTS", "WR_PORTS"].map(|n| number(n) as usize);
    let offset = number("OFFSET");
    memories.insert(
        name.into(),
        json!({ "hide_name": 0, "attributes": {}, "width": width, "start_offset": offset, "size": size }),
    );
    let pin = |n: &str, lo: usize, n_bits: usize| -> Json { pins[n].as_array().unwrap()[lo..lo + n_bits].into() };
    let slice = |n: &str, lo: usize, n_bits: usize| -> String {
        let all = value(n).map_or_else(|| "0".repeat(lo + n_bits), |v| v.bit_string());
        let all = format!("{}{all}", "0".repeat((lo + n_bits).saturating_sub(all.len())));
        all[all.len() - lo - n_bits..all.len() - lo].into()
    };
    let groups = |n: &str, count: usize| -> Vec<(usize, usize)> {
        let mut list: Vec<(usize, usize)> = Vec::new();
        for i in 0..count {
            match list.last_mut() {
                Some(last) if value(n).is_some_and(|v| bit(&v, i)) => last.1 += 1,
                _ => list.push((i, 1)),
            }
        }
        list
    };
    let id = format!("\\{name}");
    let (reads, writes) = (groups("RD_WIDE_CONTINUATION", r), groups("WR_WIDE_CONTINUATION", w));
    let number = |n: usize| format!("{n:032b}");
    // numbers of ports need not follow each other
    let port_id = |j: usize| 2 * j + 1;
    let mask = |n: &str, row: usize| -> String {
        let mut list = vec!['0'; port_id(writes.len())];
        for (j, &(first, _)) in writes.iter().enumerate() {
            list[port_id(j)] = slice(n, row * w + first, 1).chars().next().unwrap();
        }
        list.iter().rev().collect()
    };
    // the cells stand in an order that is not theirs
    for (j, &(first, words)) in writes.iter().enumerate().rev() {
        let mut parameters = json!({ "MEMID": id, "ABITS": number(abits), "WIDTH": number(words * width),
            "CLK_ENABLE": slice("WR_CLK_ENABLE", first, 1), "CLK_POLARITY": slice("WR_CLK_POLARITY", first, 1) });
        let more = if old {
            json!({ "PRIORITY": number(port_id(j)) })
        } else {
            json!({ "PORTID": number(port_id(j)), "PRIORITY_MASK": mask("WR_PRIORITY_MASK", first) })
        };
        parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let connections = json!({ "CLK": pin("WR_CLK", first, 1), "ADDR": pin("WR_ADDR", first * abits, abits),
            "EN": pin("WR_EN", first * width, words * width), "DATA": pin("WR_DATA", first * width, words * width) });
        let kind = if old { "$memwr" } else { "$memwr_v2" };
        cells.insert(
            format!("{name}_w{j}"),
            json!({ "type": kind, "parameters": parameters, "attributes": {}, "connections": connections }),
        );
    }
    for (i, &(first, words)) in reads.iter().enumerate() {
        let all = words * width;
        let mut parameters = json!({ "MEMID": id, "ABITS": number(abits), "WIDTH": number(all),
            "CLK_ENABLE": slice("RD_CLK_ENABLE", first, 1), "CLK_POLARITY": slice("RD_CLK_POLARITY", first, 1) });
        let mut connections = json!({ "CLK": pin("RD_CLK", first, 1), "EN": pin("RD_EN", first, 1),
            "ADDR": pin("RD_ADDR", first * abits, abits), "DATA": pin("RD_DATA", first * width, all) });
        let more = if old {
            json!({ "TRANSPARENT": slice("RD_TRANSPARENT", first, 1) })
        } else {
            let more = connections.as_object_mut().unwrap();
            more.insert("ARST".into(), pin("RD_ARST", first, 1));
            more.insert("SRST".into(), pin("RD_SRST", first, 1));
            json!({ "TRANSPARENCY_MASK": mask("RD_TRANSPARENCY_MASK", first),
                "COLLISION_X_MASK": mask("RD_COLLISION_X_MASK", first),
                "ARST_VALUE": slice("RD_ARST_VALUE", first * width, all),
                "SRST_VALUE": slice("RD_SRST_VALUE", first * width, all),
                "INIT_VALUE": slice("RD_INIT_VALUE", first * width, all),
                "CE_OVER_SRST": slice("RD_CE_OVER_SRST", first, 1) })
        };
        parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let kind = if old { "$memrd" } else { "$memrd_v2" };
        cells.insert(
            format!("{name}_r{i}"),
            json!({ "type": kind, "parameters": parameters, "attributes": {}, "connections": connections }),
        );
    }
    let init = value("INIT").unwrap();
    if init.width() as usize != size * width {
        return;
    }
    // all at once of something else, then each word, of which the x are left as they were made x
    let constant = |text: String| -> Json { text.chars().rev().map(|c| json!(c.to_string())).collect() };
    let pieces = (0..size).map(|i| (1 + i, i, 1, slice("INIT", i * width, width)));
    for (priority, index, words, data) in
        [(0, 0, size, "10".repeat(size * width)[..size * width].into())].into_iter().chain(pieces)
    {
        let address = format!("{:032b}", (offset + index as i64) as u32);
        let mut connections = json!({ "ADDR": constant(address), "DATA": constant(data.clone()) });
        let kind = if old { "$meminit" } else { "$meminit_v2" };
        if !old {
            connections.as_object_mut().unwrap().insert("EN".into(), constant("1".repeat(width)));
        }
        let parameters = json!({ "MEMID": id, "ABITS": number(32), "WIDTH": number(width), "WORDS": number(words),
            "PRIORITY": number(priority) });
        cells.insert(
            format!("{name}_i{priority}"),
            json!({ "type": kind, "parameters": parameters, "attributes": {}, "connections": connections }),
        );
    }
}

fn run(name: &str, kinds: &[(Kind, usize)]) {
    let mut rng = Rng::named(name);
    let mut cells = Vec::new();
    for &(kind, n) in kinds {
        cells.extend((0..n).map(|_| cell(kind, &mut rng)));
    }
    compare(name, &cells, 200);
}

#[needs(iverilog, yosys)]
#[test]
fn memories_of_any_ports() {
    run("memory", &[(Kind::Any, 60), (Kind::Library, 40)]);
}

#[needs(iverilog, yosys)]
#[test]
fn memories_as_they_were() {
    run("memory_v1", &[(Kind::Old, 30), (Kind::OldLibrary, 20)]);
}

#[needs(iverilog, yosys)]
#[test]
fn memories_in_parts() {
    run("memory_parts", &[(Kind::Parts, 40), (Kind::OldParts, 30)]);
}
