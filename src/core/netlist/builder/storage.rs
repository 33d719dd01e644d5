//! Registers and memories as one writes them: `b.reg("q", &clk).reset(&rst, 0).d(&next)`.

use super::Builder;
use crate::Value;
use crate::cell::memory::{ReadPort, WritePort};
use crate::cell::pin::flop;
use crate::cell::{CellKind, Edge, Flop, Memory};
use crate::netlist::{Bus, Direction};

/// A register that is being described; [`d`](Reg::d) or [`drives`](Reg::drives) adds it.
#[must_use = "it is added by `d` or `drives`"]
pub struct Reg<'b> {
    builder: &'b mut Builder,
    name: String,
    edge: Edge,
    pins: [Option<Bus>; 8],
    reset: Option<u64>,
    set: bool,
    init: Option<u64>,
}

impl Builder {
    /// A register in the top scope that samples at the rising edge of `clk`. Its state is x before the first one, unless
    /// [`init`](Reg::init) says something else.
    ///
    /// ```
    /// # mod discreta { pub use discreta_core::*; }
    /// use discreta::netlist::Builder;
    ///
    /// let mut b = Builder::new("counter");
    /// let (clk, rst, q) = (b.input("clk", 1), b.input("rst", 1), b.output("q", 8));
    /// let one = b.number(1, 8);
    /// let (next, _carry) = b.adder("add", &q, &one);
    /// b.reg("count", &clk).reset(&rst, 0).drives(&next, &q);
    /// let netlist = b.finish()?;
    /// # Ok::<(), discreta::netlist::BuildError>(())
    /// ```
    pub fn reg(&mut self, name: &str, clk: &Bus) -> Reg<'_> {
        let mut pins: [Option<Bus>; 8] = Default::default();
        pins[flop::CLK] = Some(clk.clone());
        Reg { builder: self, name: name.to_owned(), edge: Edge::Rising, pins, reset: None, set: false, init: None }
    }

    /// The bits of a constant number.
    pub fn number(&mut self, value: u64, width: u32) -> Bus {
        self.constant(&Value::from_u64(value, width))
    }

    /// A memory of `size` words of `width` bits in the top scope, with addresses from 0 up, all x at first unless
    /// [`init`](Mem::init) says something else; [`done`](Mem::done) adds it.
    ///
    /// ```
    /// # mod discreta { pub use discreta_core::*; }
    /// use discreta::netlist::Builder;
    ///
    /// let mut b = Builder::new("ram");
    /// let (clk, en, addr, data) = (b.input("clk", 1), b.input("en", 1), b.input("addr", 8), b.input("data", 16));
    /// let mut ram = b.memory("ram", 16, 256);
    /// ram.write(&clk, &en, &addr, &data);
    /// let word = ram.read(&addr);
    /// ram.done();
    /// b.port("word", &word);
    /// let netlist = b.finish()?;
    /// # Ok::<(), discreta::netlist::BuildError>(())
    /// ```
    pub fn memory(&mut self, name: &str, width: u32, size: u32) -> Mem<'_> {
        Mem {
            name: name.to_owned(),
            width,
            size,
            abits: None,
            init: Memory::contents(width, size),
            reads: Vec::new(),
            writes: Vec::new(),
            builder: self,
        }
    }

    /// Shows bits as an output of the circuit.
    pub fn port(&mut self, name: &str, bus: &Bus) {
        let top = self.top();
        self.name(top, name, bus.clone(), false, false, Some(Direction::Output));
    }
}

impl Reg<'_> {
    fn pin(mut self, pin: usize, bus: &Bus) -> Self {
        self.pins[pin] = Some(bus.clone());
        self
    }

    /// Samples at the falling edge.
    pub fn falling(mut self) -> Self {
        self.edge = Edge::Falling;
        self
    }

    /// Is `value` while `rst` is 1, whatever the clock does.
    pub fn reset(mut self, rst: &Bus, value: u64) -> Self {
        self.reset = Some(value);
        self.pin(flop::RESET, rst)
    }

    /// Becomes `value` at a clock edge at which `rst` is 1.
    pub fn sync_reset(mut self, rst: &Bus, value: u64) -> Self {
        self.reset = Some(value);
        self.pin(flop::SYNC_RESET, rst)
    }

    /// Is all ones while `set` is 1, whatever the clock does.
    pub fn set(mut self, set: &Bus) -> Self {
        self.set = true;
        self.pin(flop::SET, set)
    }

    /// Samples only while `en` is 1.
    pub fn enable(self, en: &Bus) -> Self {
        self.pin(flop::EN, en)
    }

    /// Its state at the start.
    pub fn init(mut self, value: u64) -> Self {
        self.init = Some(value);
        self
    }

    /// Adds it, sampling `d`; its state is a new net of its name.
    pub fn d(self, d: &Bus) -> Bus {
        let q = self.builder.net(&self.name, d.width());
        self.drives(d, &q);
        q
    }

    /// Adds it, sampling `d` into `q`.
    pub fn drives(mut self, d: &Bus, q: &Bus) {
        self.pins[flop::D] = Some(d.clone());
        let width = q.width();
        let value = |n: Option<u64>| n.map_or_else(|| Value::unknown(width), |n| Value::from_u64(n, width));
        let ones = Value::repeat(crate::Logic::One, width);
        let flop = Flop {
            edge: self.edge,
            set_value: if self.set { ones } else { Value::unknown(width) },
            reset_value: value(self.reset),
            init: value(self.init),
        };
        let inputs = self.pins.into_iter().map(Option::unwrap_or_default).collect();
        let top = self.builder.top();
        let cell = self.builder.cell(top, &self.name, CellKind::Flop(Box::new(flop)), inputs, vec![q.clone()]);
        self.builder.drawn_as(cell, "register");
    }
}

/// A read port: its clock, its address, what it gives.
type Read = (Option<Bus>, Bus, Bus);
/// A write port: its clock, its enable, its address, what it writes.
type Write = (Bus, Bus, Bus, Bus);

/// A memory that is being described; [`done`](Mem::done) adds it.
#[must_use = "it is added by `done`"]
pub struct Mem<'b> {
    builder: &'b mut Builder,
    name: String,
    width: u32,
    size: u32,
    abits: Option<u32>,
    init: Vec<crate::value::Word>,
    reads: Vec<Read>,
    writes: Vec<Write>,
}

impl Mem<'_> {
    /// What its first words hold at the start.
    pub fn init(mut self, words: impl IntoIterator<Item = u64>) -> Self {
        for (index, word) in (0..self.size).zip(words) {
            let value = Value::from_u64(word, self.width);
            Memory::set_word(self.width, &mut self.init, index, &value, |_| true);
        }
        self
    }

    fn addressed(&mut self, addr: &Bus) {
        self.abits = Some(self.abits.unwrap_or(0).max(addr.width()));
    }

    /// A port that reads at once.
    pub fn read(&mut self, addr: &Bus) -> Bus {
        self.addressed(addr);
        let q = self.builder.bits(self.width);
        self.reads.push((None, addr.clone(), q.clone()));
        q
    }

    /// A port that reads at the rising edge of `clk` what was there before it.
    pub fn read_at(&mut self, clk: &Bus, addr: &Bus) -> Bus {
        self.addressed(addr);
        let q = self.builder.bits(self.width);
        self.reads.push((Some(clk.clone()), addr.clone(), q.clone()));
        q
    }

    /// A port that writes at the rising edge of `clk` while `en` is 1: one bit for the whole word, or one for each bit.
    pub fn write(&mut self, clk: &Bus, en: &Bus, addr: &Bus, data: &Bus) {
        self.addressed(addr);
        self.writes.push((clk.clone(), en.clone(), addr.clone(), data.clone()));
    }

    /// Adds it.
    pub fn done(self) {
        let (b, n) = (self.builder, self.writes.len());
        let abits = self.abits.unwrap_or(1);
        let zero = b.number(0, 1);
        let one = b.number(1, 1);
        // what is narrower has zeros above
        let address = |a: &Bus| {
            let high = vec![zero.clone(); (abits - a.width()) as usize];
            Bus::concat(std::iter::once(a).chain(&high))
        };
        let enable = |en: &Bus, width: u32| match en.width() {
            1 => Bus::concat(std::iter::repeat_n(en, width as usize)),
            _ => en.clone(),
        };
        let read = |clock: &Option<Bus>| ReadPort {
            clock: clock.as_ref().map(|_| Edge::Rising),
            wide: false,
            transparent: vec![false; n].into(),
            collides: vec![false; n].into(),
            arst_value: Value::unknown(self.width),
            srst_value: Value::unknown(self.width),
            enable_first: false,
        };
        let write = |_: &Write| WritePort { clock: Some(Edge::Rising), wide: false, priority: vec![false; n].into() };
        let each = |bus: &Bus| Bus::concat(std::iter::repeat_n(bus, self.reads.len()));
        let all = |list: Vec<Bus>| Bus::concat(&list);
        let inputs = vec![
            all(self.reads.iter().map(|r| r.0.clone().unwrap_or_else(|| zero.clone())).collect()),
            each(&one),
            each(&zero),
            each(&zero),
            all(self.reads.iter().map(|r| address(&r.1)).collect()),
            all(self.writes.iter().map(|w| w.0.clone()).collect()),
            all(self.writes.iter().map(|w| enable(&w.1, self.width)).collect()),
            all(self.writes.iter().map(|w| address(&w.2)).collect()),
            all(self.writes.iter().map(|w| w.3.clone()).collect()),
        ];
        let outputs = vec![all(self.reads.iter().map(|r| r.2.clone()).collect())];
        let memory = Memory {
            width: self.width,
            size: self.size,
            offset: 0,
            abits,
            init: self.init.into(),
            start: Value::unknown(self.width * self.reads.len() as u32),
            reads: self.reads.iter().map(|r| read(&r.0)).collect(),
            writes: self.writes.iter().map(write).collect(),
        };
        let top = b.top();
        b.cell(top, &self.name, CellKind::Memory(Box::new(memory)), inputs, outputs);
    }
}
