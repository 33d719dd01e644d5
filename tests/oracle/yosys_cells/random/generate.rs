//! Random netlists whose result does not depend on an order that Verilog leaves open. `mod.rs` says what that excludes.

use discreta::cell::Clock;
use discreta::{Logic, Value};

use super::design::{Bit, Design, Input, Item};
use crate::support::Rng;
use crate::yosys_cells::batch::Cell;
use crate::yosys_cells::{gates, storage, word};

/// Ticks of a frame. Clocks change at its first tick, the data inputs at `DATA`, one control at each tick from `CONTROLS`
/// on.
pub const FRAME: u64 = 8;
const DATA: u64 = 2;
const CONTROLS: u64 = 3;

/// When a net may change: a bit for each tick of a frame and each round of it, in which those of later ticks stand at
/// higher bits. A round ends when all has settled and flip-flops change; the last is that and all later ones.
type When = u64;
const ROUNDS: u64 = 8;

fn at(tick: u64) -> When {
    1 << (tick % FRAME * ROUNDS)
}

/// A round later. What may change in all rounds of a tick may still: the delays that are due come in the first of two
/// waves here, and in Verilog with what flip-flops give.
fn next_round(when: When) -> When {
    let next = |tick: u64| {
        let rounds = when >> (tick * ROUNDS) & 0xff;
        let next = if rounds == 0xff { rounds } else { rounds << 1 & 0xff | rounds & 0x80 };
        next << (tick * ROUNDS)
    };
    (0..FRAME).map(next).fold(0, |w, n| w | n)
}

/// All rounds of the next tick.
fn next_tick(when: When) -> When {
    (0..FRAME).filter(|t| when >> (t * ROUNDS) & 0xff != 0).fold(0, |w, t| w | 0xff << ((t + 1) % FRAME * ROUNDS))
}

/// A bit that changes at most once in a round, so that it can be a clock or another control.
#[derive(Clone, Copy)]
struct Clean {
    bit: Bit,
    when: When,
    /// What it is at the start.
    start: bool,
    /// Whether it is that from the very beginning, before the bench has given flip-flops their state.
    steady: bool,
}

/// Pins of flip-flops that are connected when all nets are there.
struct Later {
    item: usize,
    pin: usize,
    /// The first bit, and how many.
    low: usize,
    width: u32,
    /// When what it reads must not change.
    not: When,
    /// Whether it must not depend on what a memory reads.
    early: bool,
}

struct Generator<'r> {
    rng: &'r mut Rng,
    design: Design,
    when: Vec<When>,
    /// Whether each wire depends on what a memory reads: its model gives that within the round.
    late: Vec<bool>,
    clean: Vec<Clean>,
    later: Vec<Later>,
}

/// A netlist of about so many cells, running for so many frames.
pub fn generate(seed: u64, cells: u64, frames: u64) -> Design {
    let mut rng = Rng::new(seed);
    // by a number of its own the generator's first choices would be alike for near seeds
    rng.word();
    let end = frames * FRAME;
    let design = Design { seed, wires: vec![], items: vec![], groups: vec![0], inputs: vec![], end };
    let mut g = Generator { rng: &mut rng, design, when: vec![], late: vec![], clean: vec![], later: vec![] };
    g.modules();
    g.inputs(frames);
    for _ in 0..cells / 8 {
        g.derive();
    }
    for _ in 0..cells / 4 {
        g.storage();
    }
    for _ in 0..g.rng.below(3) {
        g.memory();
    }
    for _ in 0..cells - cells / 4 - cells / 8 {
        match g.rng.below(12) {
            0 => g.latch(),
            1 => g.bus(),
            _ => g.combinational(),
        }
    }
    g.connect();
    g.design
}

impl Generator<'_> {
    fn wire(&mut self, width: u32, when: When) -> usize {
        self.design.wires.push(width);
        self.when.push(when);
        self.late.push(false);
        self.design.wires.len() - 1
    }

    fn modules(&mut self) {
        for i in 1..=self.rng.below(6) {
            let parent = self.rng.below(i) as usize;
            self.design.groups.push(parent);
        }
    }

    fn inputs(&mut self, frames: u64) {
        let scale = 1 + self.rng.below(3);
        for i in 0..2 + self.rng.below(3) {
            // the first two are related, the others anyhow
            let half = if i < 2 { scale * (i + 1) } else { 1 + self.rng.below(7) };
            let low = if self.rng.one_in(3) { half + self.rng.below(3) } else { half };
            let phase = 1 + self.rng.below(half + low);
            let clock = Clock { period: (half + low) * FRAME, high: half * FRAME, phase: phase * FRAME };
            let wire = self.wire(1, at(0));
            self.design.inputs.push(Input { wire, clock: Some(clock), values: vec![] });
            self.clean.push(Clean { bit: Bit::Wire(wire, 0), when: at(0), start: false, steady: true });
        }
        for i in CONTROLS..CONTROLS + 2 + self.rng.below(FRAME - CONTROLS - 1) {
            let wire = self.wire(1, at(i));
            let start = self.rng.one_in(2);
            let level = |on: bool| Value::from_u64(on.into(), 1);
            let mut values = vec![(0, level(start))];
            let often = 2 + self.rng.below(12);
            for frame in 1..frames {
                if self.rng.one_in(often) {
                    let value = match self.rng.below(24) {
                        0 => Value::repeat(Logic::X, 1),
                        1 => Value::repeat(Logic::Z, 1),
                        n => level(n % 2 == 0),
                    };
                    values.push((frame * FRAME + i, value));
                }
            }
            self.design.inputs.push(Input { wire, clock: None, values });
            self.clean.push(Clean { bit: Bit::Wire(wire, 0), when: at(i), start, steady: true });
        }
        for _ in 0..2 + self.rng.below(5) {
            let width = self.width();
            let wire = self.wire(width, at(DATA));
            let mut values = vec![(0, self.rng.known(width))];
            for frame in 1..frames {
                if self.rng.one_in(2) {
                    let value = match self.rng.below(40) {
                        0 => self.rng.four_valued(width, 3),
                        1 => self.rng.four_valued(width, u64::from(width)),
                        2 => Value::from_i64(-(self.rng.below(4) as i64), width),
                        3 | 4 => Value::from_u64(self.rng.below(4), width),
                        _ => self.rng.known(width),
                    };
                    values.push((frame * FRAME + DATA, value));
                }
            }
            self.design.inputs.push(Input { wire, clock: None, values });
        }
    }

    /// 1 to 70, mostly small.
    fn width(&mut self) -> u32 {
        let most = *self.rng.pick(&[1, 4, 9, 70]);
        1 + self.rng.below(most) as u32
    }

    fn group(&mut self) -> usize {
        self.rng.below(self.design.groups.len() as u64) as usize
    }

    /// A cell whose outputs are new wires; of an output of many bits now and then two.
    fn place(&mut self, cell: Cell, inputs: Vec<Vec<Bit>>, when: When, preset: bool) -> usize {
        let sampled = cell.kind.to_lowercase().contains("ff");
        let late = !sampled && inputs.iter().any(|bits| self.is_late(bits));
        let mut outputs = Vec::new();
        for &(_, width) in &cell.outputs {
            let low =
                if width > 1 && self.rng.one_in(5) { 1 + self.rng.below(u64::from(width) - 1) as u32 } else { width };
            let mut wires = vec![self.wire(low, when)];
            if low < width {
                wires.push(self.wire(width - low, when));
            }
            wires.iter().for_each(|w| self.late[*w] = late);
            outputs.push(wires);
        }
        let group = self.group();
        self.design.items.push(Item { cell, inputs, outputs, group, preset });
        self.design.items.len() - 1
    }

    /// Some bits that do not change when they must not, and when they do.
    fn gather(&mut self, width: u32, not: When) -> (Vec<Bit>, When) {
        let (mut bits, mut when) = (Vec::new(), 0);
        let constant = |rng: &mut Rng| {
            Bit::Constant(match rng.below(40) {
                0 => Logic::X,
                1 => Logic::Z,
                n => {
                    if n % 2 == 0 {
                        Logic::Zero
                    } else {
                        Logic::One
                    }
                }
            })
        };
        while (bits.len() as u32) < width {
            let left = width - bits.len() as u32;
            let mut wire = None;
            for _ in 0..12 {
                let n = self.rng.below(self.design.wires.len() as u64) as usize;
                // what is late sees more of the netlist
                let n =
                    if self.rng.one_in(2) { n.max(self.rng.below(self.design.wires.len() as u64) as usize) } else { n };
                if self.when[n] & not == 0 {
                    wire = Some(n);
                    break;
                }
            }
            match wire {
                Some(wire) if !self.rng.one_in(25) => {
                    let all = self.design.wires[wire];
                    let low = if self.rng.one_in(3) { self.rng.below(all.into()) as u32 } else { 0 };
                    let count = (all - low).min(left);
                    bits.extend((low..low + count).map(|i| Bit::Wire(wire, i)));
                    when |= self.when[wire];
                }
                _ => {
                    let count = 1 + self.rng.below(left.into());
                    let bit = constant(self.rng);
                    bits.extend((0..count).map(|_| bit));
                }
            }
        }
        (bits, when)
    }

    /// A clean bit that changes at other times, and is at the start as wanted.
    fn control(&mut self, not: When, start: Option<bool>, primary: bool) -> Option<Clean> {
        let fits = |c: &&Clean| c.when & not == 0 && start.is_none_or(|s| s == c.start);
        let most = if primary && self.rng.one_in(2) { 6 } else { self.clean.len() };
        let all: Vec<Clean> = self.clean[..most.min(self.clean.len())].iter().filter(fits).copied().collect();
        if all.is_empty() { None } else { Some(*self.rng.pick(&all)) }
    }

    /// One more clean bit: a gate of some, one of them a tick later, or a flip-flop with one bit.
    fn derive(&mut self) {
        let kind = *self.rng.pick(&["not", "gate", "gate", "later", "toggle", "toggle", "bit", "bit"]);
        match kind {
            "not" | "gate" => {
                let kinds = [
                    ("$_NOT_", 1),
                    ("$_AND_", 2),
                    ("$_OR_", 2),
                    ("$_XOR_", 2),
                    ("$_ANDNOT_", 2),
                    ("$_AOI3_", 3),
                    ("$_NAND_", 2),
                    ("$_XNOR_", 2),
                ];
                let (name, inputs) = if kind == "not" { kinds[0] } else { *self.rng.pick(&kinds[1..]) };
                let mut pins: Vec<Clean> = Vec::new();
                for _ in 0..inputs {
                    let used = pins.iter().fold(0, |w, p| w | p.when);
                    let Some(pin) = self.control(used, None, false) else { return };
                    pins.push(pin);
                }
                let s: Vec<bool> = pins.iter().map(|p| p.start).collect();
                let start = match name {
                    "$_NOT_" => !s[0],
                    "$_AND_" => s[0] && s[1],
                    "$_OR_" => s[0] || s[1],
                    "$_XOR_" => s[0] != s[1],
                    "$_ANDNOT_" => s[0] && !s[1],
                    "$_AOI3_" => !(s[0] && s[1] || s[2]),
                    "$_NAND_" => !(s[0] && s[1]),
                    _ => s[0] == s[1],
                };
                let when = pins.iter().fold(0, |w, p| w | p.when);
                let inputs = pins.iter().map(|p| vec![p.bit]).collect();
                let item = self.place(gates::combinational(name), inputs, when, false);
                self.now_clean(item, when, start, pins.iter().all(|p| p.steady));
            }
            "later" => {
                let Some(pin) = self.control(0, None, false) else { return };
                let when = next_tick(pin.when);
                let cell = gates::storage("$_FF_", None);
                // data and no clock: its first value, a tick after all has settled, is an edge that the bench hides
                self.place(cell, vec![vec![pin.bit]], when, false);
            }
            _ => {
                let name = *self.rng.pick(&[
                    "$_DFF_P_",
                    "$_DFF_N_",
                    "$_DFF_PP0_",
                    "$_DFF_NN1_",
                    "$_DFF_PN0_",
                    "$_DFFE_PP_",
                    "$_SDFF_PN0_",
                ]);
                let start = self.rng.one_in(2);
                let cell = gates::storage(name, Some(Value::from_u64(start.into(), 1)));
                let Some((item, when, once)) = self.flip_flop(cell) else { return };
                if once {
                    self.now_clean(item, when, start, false);
                }
                if kind == "toggle" {
                    // halves its clock
                    let q = self.design.items[item].outputs[0][0];
                    let inverter = self.place(gates::combinational("$_NOT_"), vec![vec![Bit::Wire(q, 0)]], when, false);
                    let inverted = self.design.items[inverter].outputs[0][0];
                    let d = self.design.items[item].cell.inputs.iter().position(|p| p.0 == "D").unwrap();
                    if self.later.iter().any(|l| (l.item, l.pin) == (item, d) && l.not & when == 0) {
                        self.later.retain(|l| (l.item, l.pin) != (item, d));
                        self.design.items[item].inputs[d] = vec![Bit::Wire(inverted, 0)];
                    }
                }
            }
        }
    }

    fn now_clean(&mut self, item: usize, when: When, start: bool, steady: bool) {
        let wire = self.design.items[item].outputs[0][0];
        self.clean.push(Clean { bit: Bit::Wire(wire, 0), when, start, steady });
    }

    /// What a cell's controls read: clean bits of which no two change together, those that act by level inactive at the
    /// start. With it when each changes.
    fn controls(&mut self, cell: &Cell, all_inactive: bool) -> Vec<(&'static str, Vec<Bit>, When)> {
        let mut chosen: Vec<(&'static str, Vec<Bit>, When)> = Vec::new();
        let mut each: Vec<Vec<When>> = Vec::new();
        for (port, inactive) in &cell.controls {
            let clock = matches!(*port, "CLK" | "C");
            // an enabled latch and a reset one are known as a whole; where single bits are set the others would not be
            let whole = !all_inactive && matches!(*port, "EN" | "E" | "ARST");
            let (mut bits, mut times, mut when) = (Vec::new(), Vec::new(), 0);
            for i in 0..inactive.width() as usize {
                // of other vectors only the bit beside it matters
                let not = each.iter().map(|t| if t.len() == 1 { t[0] } else { *t.get(i).unwrap_or(&0) });
                let not = not.fold(0, |w, t| w | t);
                let level = inactive.bit(i as u32) == Logic::One;
                let start = (!clock && !whole).then_some(level);
                match self.control(not, start, true) {
                    Some(c) => {
                        bits.push(c.bit);
                        times.push(c.when);
                        when |= c.when;
                    }
                    None => {
                        bits.push(Bit::Constant(if level { Logic::One } else { Logic::Zero }));
                        times.push(0);
                    }
                }
            }
            // a scalar that comes after a vector must fit to all of it
            each.push(if times.len() == 1 { vec![when] } else { times });
            chosen.push((port, bits, when));
        }
        chosen
    }

    /// A flip-flop, its data to be connected later; with when it changes, and whether only once in a round.
    fn flip_flop(&mut self, mut cell: Cell) -> Option<(usize, When, bool)> {
        // what is sampled with the data is data
        let with_reset = cell.kind.starts_with("$_SDFF");
        cell.controls.retain(|c| c.0 != "E" && (c.0 != "R" || !with_reset));
        let controls = self.controls(&cell, true);
        let all = controls.iter().fold(0, |w, c| w | c.2);
        if controls.iter().any(|c| matches!(c.0, "CLK" | "C") && c.2 == 0) {
            return None;
        }
        // what acts by level changes it at once here, and a round later in Verilog
        let levels = controls.iter().filter(|c| !matches!(c.0, "CLK" | "C")).fold(0, |w, c| w | c.2);
        let when = levels | next_round(all);
        // a reset that comes when a clock has just set it leaves a pulse that one of both does not see
        let once = levels & next_round(all) == 0;
        let (mut inputs, mut open) = (Vec::new(), Vec::new());
        for (pin, &(port, width)) in cell.inputs.iter().enumerate() {
            match controls.iter().find(|c| c.0 == port) {
                Some(c) => inputs.push(c.1.clone()),
                None => {
                    open.push(pin);
                    inputs.push(vec![Bit::Constant(Logic::Zero); width as usize]);
                }
            }
        }
        let item = self.place(cell, inputs, when, true);
        for pin in open {
            self.later(item, pin, 0, all);
        }
        Some((item, when, once))
    }

    fn storage(&mut self) {
        let cell = if self.rng.one_in(2) {
            let names = gates::storage_names();
            let name = self.rng.pick(&names).clone();
            let init = (!self.rng.one_in(3)).then(|| self.rng.known(1));
            gates::storage(&name, init)
        } else {
            let kind = *self.rng.pick(storage::CELLS);
            storage::cell(kind, self.rng)
        };
        match cell.kind.as_str() {
            "$ff" | "$_FF_" => {
                // of some ticks alone, so that no ring comes to be whose phase the start decides
                let inputs = vec![vec![Bit::Constant(Logic::Zero); cell.inputs[0].1 as usize]];
                let reads = next_tick(at(FRAME - 1)) | next_tick(at(DATA - 1));
                let item = self.place(cell, inputs, next_tick(reads), false);
                self.later(item, 0, 0, !reads);
            }
            kind if kind.contains("latch") || kind.contains("LATCH") || kind == "$sr" || kind.starts_with("$_SR_") => {
                self.hold(cell);
            }
            _ => {
                self.flip_flop(cell);
            }
        }
    }

    fn latch(&mut self) {
        let kind = *self.rng.pick(&["$dlatch", "$adlatch", "$dlatchsr", "$dlatch"]);
        let cell = storage::cell(kind, self.rng);
        self.hold(cell);
    }

    /// A latch. What it reads is there already, so that no loop comes to be.
    fn hold(&mut self, cell: Cell) {
        let controls = self.controls(&cell, false);
        let all = controls.iter().fold(0, |w, c| w | c.2);
        let active = |c: &(&str, Vec<Bit>, When)| {
            let inactive = &cell.controls.iter().find(|p| p.0 == c.0).unwrap().1;
            let level = |b: &Bit| self.clean.iter().find(|c| c.bit == *b).map(|c| c.start);
            c.1.iter().zip(inactive.bits()).any(|(b, i)| level(b).is_some_and(|l| l != (i == Logic::One)))
        };
        // the bench must not overwrite what passes from the start on
        let preset = !controls.iter().any(active);
        if !preset && cell.init.is_some() {
            return;
        }
        let (mut inputs, mut when) = (Vec::new(), all);
        for &(port, width) in &cell.inputs {
            match controls.iter().find(|c| c.0 == port) {
                Some(c) => inputs.push(c.1.clone()),
                None => {
                    let (bits, changes) = self.gather(width, all);
                    when |= changes;
                    inputs.push(bits);
                }
            }
        }
        self.place(cell, inputs, when | next_round(when), preset);
    }

    fn combinational(&mut self) {
        let cell = if self.rng.one_in(3) {
            let kind = *self.rng.pick(gates::COMBINATIONAL);
            gates::combinational(kind)
        } else {
            let kind = *self.rng.pick(word::CELLS);
            word::cell(kind, self.rng)
        };
        let mut when = 0;
        let mut inputs = Vec::new();
        for &(_, width) in &cell.inputs {
            let (bits, changes) = self.gather(width, 0);
            when |= changes;
            inputs.push(bits);
        }
        self.place(cell, inputs, when, false);
    }

    /// A net with several tri-state drivers.
    fn bus(&mut self) {
        let width = self.width();
        let wire = self.wire(width, 0);
        for _ in 0..2 + self.rng.below(3) {
            let group = self.group();
            let cell = Cell::new("$tribuf", &[("A", width), ("EN", 1)], &[("Y", width)]).number("WIDTH", width.into());
            let before = self.when[wire];
            // not itself: that would be a loop
            self.when[wire] = When::MAX;
            let (a, changes) = self.data(width, wire);
            let (en, enables) = self.data(1, wire);
            self.when[wire] = before | changes | enables;
            self.late[wire] |= self.is_late(&a) || self.is_late(&en);
            self.design.items.push(Item { cell, inputs: vec![a, en], outputs: vec![vec![wire]], group, preset: false });
        }
    }

    /// Some bits, none of this wire.
    fn data(&mut self, width: u32, but: usize) -> (Vec<Bit>, When) {
        loop {
            let (bits, when) = self.gather(width, 0);
            if !bits.iter().any(|b| matches!(b, Bit::Wire(w, _) if *w == but)) {
                return (bits, when);
            }
        }
    }

    /// Connects the data of flip-flops.
    fn connect(&mut self) {
        for Later { item, pin, low, width, not, early } in std::mem::take(&mut self.later) {
            let bits = loop {
                let bits = self.gather(width, not).0;
                if !early || !self.is_late(&bits) {
                    break bits;
                }
            };
            self.design.items[item].inputs[pin][low..low + width as usize].copy_from_slice(&bits);
        }
    }

    fn later(&mut self, item: usize, pin: usize, low: usize, not: When) {
        let width = self.design.items[item].inputs[pin].len() as u32;
        self.later.push(Later { item, pin, low, width, not, early: false });
    }

    fn is_late(&self, bits: &[Bit]) -> bool {
        bits.iter().any(|b| matches!(b, Bit::Wire(wire, _) if self.late[*wire]))
    }

    /// A memory. Its ports with a clock may share one or not; the others read all the time.
    fn memory(&mut self) {
        let (r, w) = (1 + self.rng.below(3) as usize, 1 + self.rng.below(2) as usize);
        let (width, abits) = (self.width(), 2 + self.rng.below(3) as u32);
        let size = 3 + self.rng.below((1 << abits) - 2) as u32;
        let clocks: Vec<Clean> = self.clean.iter().filter(|c| c.steady).copied().collect();
        let main = *self.rng.pick(&clocks);
        let clock = |rng: &mut Rng| if rng.one_in(2) { main } else { *rng.pick(&clocks) };
        let reads: Vec<Option<Clean>> = (0..r).map(|_| (!self.rng.one_in(4)).then(|| clock(self.rng))).collect();
        let writes: Vec<Clean> = (0..w).map(|_| clock(self.rng)).collect();
        let edges = reads.iter().flatten().chain(&writes).fold(0, |when, c| when | c.when);
        let (mut resets, mut levels) = (Vec::new(), 0);
        for read in &reads {
            let fits = |c: &&Clean| read.is_some() && !c.start && c.when & (edges | levels) == 0;
            let fitting: Vec<Clean> = clocks.iter().filter(fits).copied().collect();
            let reset = (!fitting.is_empty() && self.rng.one_in(3)).then(|| *self.rng.pick(&fitting));
            levels |= reset.map_or(0, |c| c.when);
            resets.push(reset.map_or(Bit::Constant(Logic::Zero), |c| c.bit));
        }
        let all = edges | levels;
        let bits = |rng: &mut Rng, n: usize, each: &dyn Fn(&mut Rng, usize) -> bool| {
            let mut value = Value::from_u64(0, n as u32);
            for i in 0..n {
                if each(rng, i) {
                    value.set_bit(i as u32, Logic::One);
                }
            }
            value
        };
        let clocked = |i: usize| reads[i].is_some();
        let transparent = bits(self.rng, r * w, &|rng, i| clocked(i / w) && rng.one_in(3));
        let collides = bits(self.rng, r * w, &|rng, i| {
            clocked(i / w) && transparent.bit(i as u32) == Logic::Zero && rng.one_in(3)
        });
        let half = |rng: &mut Rng, n: usize| bits(rng, n, &|rng, _| rng.one_in(2));
        let (ru, wu, data) = (r as u32, w as u32, r as u32 * width);
        let inputs = [
            ("RD_CLK", ru),
            ("RD_EN", ru),
            ("RD_ARST", ru),
            ("RD_SRST", ru),
            ("RD_ADDR", ru * abits),
            ("WR_CLK", wu),
            ("WR_EN", wu * width),
            ("WR_ADDR", wu * abits),
            ("WR_DATA", wu * width),
        ];
        let cell = Cell::new("$mem_v2", &inputs, &[("RD_DATA", data)])
            .number("SIZE", size.into())
            .number("ABITS", abits.into())
            .number("WIDTH", width.into())
            .number("RD_PORTS", r as u64)
            .number("WR_PORTS", w as u64)
            .number("OFFSET", 0)
            .with("INIT", self.rng.four_valued(size * width, 20))
            .with("RD_CLK_ENABLE", bits(self.rng, r, &|_, i| clocked(i)))
            .with("RD_CLK_POLARITY", half(self.rng, r))
            .with("RD_TRANSPARENCY_MASK", transparent)
            .with("RD_COLLISION_X_MASK", collides)
            .with("RD_WIDE_CONTINUATION", Value::from_u64(0, ru))
            .with("RD_CE_OVER_SRST", half(self.rng, r))
            .with("RD_ARST_VALUE", self.rng.known(data))
            .with("RD_SRST_VALUE", self.rng.known(data))
            .with("RD_INIT_VALUE", self.rng.known(data))
            .with("WR_CLK_ENABLE", bits(self.rng, w, &|_, _| true))
            .with("WR_CLK_POLARITY", half(self.rng, w))
            .with("WR_PRIORITY_MASK", bits(self.rng, w * w, &|_, i| i % w < i / w))
            .with("WR_WIDE_CONTINUATION", Value::from_u64(0, wu));
        let mut pins: Vec<Vec<Bit>> = inputs.iter().map(|p| vec![Bit::Constant(Logic::Zero); p.1 as usize]).collect();
        pins[0] = reads.iter().map(|c| c.map_or(Bit::Constant(Logic::Zero), |c| c.bit)).collect();
        pins[1].fill(Bit::Constant(Logic::One));
        pins[2] = resets;
        pins[5] = writes.iter().map(|c| c.bit).collect();
        let (mut when, mut open) = (levels | next_round(all), Vec::new());
        for i in 0..r {
            let low = i * abits as usize;
            if clocked(i) {
                open.extend([(1, i, 1), (3, i, 1), (4, low, abits)]);
            } else {
                // what it reads is there already, so that no loop comes to be
                let (bits, changes) = self.gather(abits, 0);
                pins[4][low..low + abits as usize].copy_from_slice(&bits);
                when |= changes;
            }
        }
        open.extend([(6, 0, wu * width), (7, 0, wu * abits), (8, 0, wu * width)]);
        let item = self.place(cell, pins, when, false);
        for wire in self.design.items[item].outputs[0].clone() {
            self.late[wire] = true;
        }
        self.later.extend(open.into_iter().map(|(pin, low, width)| Later {
            item,
            pin,
            low,
            width,
            not: all,
            early: true,
        }));
    }
}
