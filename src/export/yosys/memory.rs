//! Memories: `$mem_v2`, whose pins are ours.

use super::draw::Draw;
use super::model::{Bits, Setting};
use crate::cell::{Edge, Memory};
use crate::{Logic, Value};

/// Values one after another, the first in the low bits; of nothing there is still a bit, as Yosys has it.
fn joined(values: &[Value]) -> Setting {
    let width = values.iter().map(Value::width).sum::<u32>();
    let mut all = Value::from_u64(0, width.max(1));
    let mut at = 0;
    for value in values {
        (0..value.width()).for_each(|i| all.set_bit(at + i, value.bit(i)));
        at += value.width();
    }
    Setting::Value(all)
}

fn flags(list: impl Iterator<Item = bool>) -> Setting {
    joined(&list.map(|on| Value::from_u64(u64::from(on), 1)).collect::<Vec<Value>>())
}

pub fn draw(d: &mut Draw, m: &Memory, ins: &[Bits], outs: &[Bits]) {
    let words: Vec<Value> = (0..m.size).map(|i| Memory::word(m.width, &m.init, i)).collect();
    let known = words.iter().any(|w| w.bits().any(|b| b != Logic::X));
    let init = if known { joined(&words) } else { Setting::Value(Value::unknown(1)) };
    let (reads, writes) = (&m.reads, &m.writes);
    let rising = |clock: Option<Edge>| clock != Some(Edge::Falling);
    let number = |n: usize| Setting::Number(n as u32);
    let parameters = vec![
        ("MEMID", Setting::Text(format!("\\{}", d.name))),
        ("SIZE", Setting::Number(m.size)),
        ("OFFSET", Setting::Number(m.offset as u32)),
        ("ABITS", Setting::Number(m.abits)),
        ("WIDTH", Setting::Number(m.width)),
        ("INIT", init),
        ("RD_PORTS", number(reads.len())),
        ("RD_CLK_ENABLE", flags(reads.iter().map(|r| r.clock.is_some()))),
        ("RD_CLK_POLARITY", flags(reads.iter().map(|r| rising(r.clock)))),
        ("RD_TRANSPARENCY_MASK", flags(reads.iter().flat_map(|r| r.transparent.iter().copied()))),
        ("RD_COLLISION_X_MASK", flags(reads.iter().flat_map(|r| r.collides.iter().copied()))),
        ("RD_WIDE_CONTINUATION", flags(reads.iter().map(|r| r.wide))),
        ("RD_CE_OVER_SRST", flags(reads.iter().map(|r| r.enable_first))),
        ("RD_ARST_VALUE", joined(&reads.iter().map(|r| r.arst_value.clone()).collect::<Vec<Value>>())),
        ("RD_SRST_VALUE", joined(&reads.iter().map(|r| r.srst_value.clone()).collect::<Vec<Value>>())),
        ("RD_INIT_VALUE", joined(std::slice::from_ref(&m.start))),
        ("WR_PORTS", number(writes.len())),
        ("WR_CLK_ENABLE", flags(writes.iter().map(|w| w.clock.is_some()))),
        ("WR_CLK_POLARITY", flags(writes.iter().map(|w| rising(w.clock)))),
        ("WR_PRIORITY_MASK", priority(m)),
        ("WR_WIDE_CONTINUATION", flags(writes.iter().map(|w| w.wide))),
    ];
    let ports = ["RD_CLK", "RD_EN", "RD_ARST", "RD_SRST", "RD_ADDR", "WR_CLK", "WR_EN", "WR_ADDR", "WR_DATA"];
    let inputs = ports.into_iter().zip(ins.iter().cloned()).collect();
    d.put("", "$mem_v2", parameters, inputs, vec![("RD_DATA", outs[0].clone())]);
}

/// A row for each write port, of a bit for each.
fn priority(m: &Memory) -> Setting {
    let n = m.writes.len();
    flags(m.writes.iter().flat_map(|w| (0..n).map(|k| w.priority.get(k).copied().unwrap_or(false))))
}
