//! Memories in the engine. What a port does is compared with Icarus Verilog in `tests/oracle/yosys_cells`.

use std::sync::Arc;

use super::EventEngine;
use crate::Engine;
use crate::Value;
use crate::cell::memory::{ReadPort, WritePort};
use crate::cell::{CellKind, Edge, Memory};
use crate::netlist::{Builder, Bus, Netlist};
use crate::value::Word;

/// A memory of 8 words of 4 bits, of which word i is i + 1, with some read ports and a write port.
fn memory(reads: &[Option<Edge>]) -> CellKind {
    let mut init = Memory::contents(4, 8);
    (0..8).for_each(|i| Memory::set_word(4, &mut init, i, &Value::from_u64(u64::from(i) + 1, 4), |_| true));
    let x = Value::unknown(4);
    let read = |&clock| ReadPort {
        clock,
        wide: false,
        transparent: [false].into(),
        collides: [false].into(),
        arst_value: x.clone(),
        srst_value: x.clone(),
        enable_first: false,
    };
    CellKind::Memory(Box::new(Memory {
        width: 4,
        size: 8,
        offset: 0,
        abits: 3,
        init: Arc::from(init),
        start: Value::unknown(4 * reads.len() as u32),
        reads: reads.iter().map(read).collect(),
        writes: vec![WritePort { clock: Some(Edge::Rising), wide: false, priority: [false].into() }],
    }))
}

/// The memory with one clock for all, addresses of the read ports from outside, `q` what they read.
struct Bench {
    netlist: Netlist,
    engine: EventEngine,
}

impl Bench {
    fn new(reads: &[Option<Edge>], address: impl FnOnce(&Bus, &Bus) -> Bus) -> Bench {
        let n = reads.len() as u32;
        let mut b = Builder::new("top");
        let [clk, at, en, to, d] = [("clk", 1), ("at", 3), ("en", 1), ("to", 3), ("d", 4)].map(|(p, w)| b.input(p, w));
        let q = b.output("q", 4 * n);
        let (one, zero) = (b.constant(&Value::from_i64(-1, n)), b.constant(&Value::from_u64(0, n)));
        let clocks = Bus::concat(std::iter::repeat_n(&clk, n as usize));
        let enable = Bus::concat([&en; 4]);
        let pins = vec![clocks, one, zero.clone(), zero, address(&at, &q), clk, enable, to, d];
        let top = b.top();
        b.cell(top, "memory", memory(reads), pins, vec![q]);
        let netlist = b.finish().unwrap();
        let engine = EventEngine::new(&netlist);
        Bench { netlist, engine }
    }

    /// Sets inputs, lets all settle, and gives what the ports read, the last first.
    fn set(&mut self, inputs: &[(&str, u64)]) -> String {
        for &(name, value) in inputs {
            let net = self.netlist.bits(self.netlist.find(name).unwrap())[0].net;
            self.engine.drive(net, &[Word::known(value)]);
        }
        self.engine.settle().unwrap();
        let q = self.netlist.find("q").unwrap();
        let slices = self.netlist.bits(q);
        let width: u32 = slices.iter().map(|s| s.width).sum();
        let value = Value::from_words(self.engine.read(slices[0].net), width).bit_string();
        value.as_bytes().chunks(4).map(|c| std::str::from_utf8(c).unwrap()).collect::<Vec<_>>().join(" ")
    }
}

#[test]
fn contents_are_there_at_first_and_again_after_a_reset() {
    let mut t = Bench::new(&[None], |at, _| at.clone());
    let first = [("clk", 0), ("at", 3), ("en", 1), ("to", 3), ("d", 9)];
    assert_eq!(t.set(&first), "0100");
    assert_eq!(t.set(&[("clk", 1)]), "1001", "a write wakes what reads");
    assert_eq!(t.set(&[("at", 2)]), "0011");
    assert_eq!(t.set(&[("at", 3)]), "1001");
    t.engine.reset();
    assert_eq!(t.set(&first), "0100");
}

/// The second port reads where the first says, the third where the second does: no loop, and each at once.
#[test]
fn ports_may_read_where_others_say() {
    let mut t = Bench::new(&[None; 3], |at, q| Bus::concat([at, &q.slice(0, 3), &q.slice(4, 3)]));
    assert!(t.netlist.order().groups.is_empty() && t.netlist.loops().is_empty());
    assert_eq!(t.netlist.order().sequence.iter().filter(|c| c.index() == t.netlist.cells().len() - 1).count(), 3);
    assert_eq!(t.set(&[("clk", 0), ("at", 2), ("en", 1), ("to", 4), ("d", 6)]), "0101 0100 0011");
    assert_eq!(t.set(&[("at", 3)]), "0110 0101 0100");
    assert_eq!(t.set(&[("clk", 1)]), "0111 0110 0100", "word 4 is 6");
}

/// A port with a clock does not make a loop with one that reads where it says.
#[test]
fn a_clocked_port_breaks_a_loop() {
    let mut t = Bench::new(&[Some(Edge::Rising), None], |_, q| Bus::concat([&q.slice(4, 3), &q.slice(0, 3)]));
    assert!(t.netlist.order().groups.is_empty());
    assert_eq!(t.set(&[("clk", 0), ("en", 0)]), "xxxx xxxx");
}

/// A port that reads where it says itself is one.
#[test]
fn a_port_may_be_a_loop() {
    let mut t = Bench::new(&[None, None], |at, q| Bus::concat([at, &q.slice(4, 3)]));
    assert_eq!(t.netlist.order().groups.len(), 1);
    assert_eq!(t.netlist.loops()[0].cells.len(), 1);
    assert_eq!(t.set(&[("clk", 0), ("at", 1), ("en", 0)]), "xxxx 0010");
}
