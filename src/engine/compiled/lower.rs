//! From a netlist to a [`Graph`]: what every net is, and what every storage cell takes, as a function of inputs and state.
//!
//! The functions of the cell room once more, on nodes in place of words. Four-valued throughout: that an unknown plane is
//! constant 0 is for the graph to make use of.

use super::graph::{Graph, Id};
use crate::cell::{AddOp, Alu, CellKind, CompareOp, DivideOp, Flop, GateOp, Role, ShiftOp};
use crate::netlist::{CellId, Constants, Driver, NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

/// The two planes of a machine word.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Two {
    pub v: Id,
    pub u: Id,
}

/// A vector, the least significant word first.
pub(super) type Bits = Vec<Two>;

/// Where state lies and how much is known of it.
pub(super) trait Places {
    /// The first slot of a net that is an input or a state.
    fn slot(&self, net: NetId) -> u32;
    /// Whether the word of state in a slot may hold x or z.
    fn may_be_unknown(&self, slot: u32) -> bool;
}

/// State that asynchronous controls may change at once.
#[derive(Debug)]
pub(super) struct Level {
    pub net: NetId,
    /// What it becomes.
    pub value: Bits,
    /// The controls and the data on which that depends beside the state itself.
    pub needs: Vec<Id>,
    /// For a net of a loop the number of the loop.
    pub group: Option<u32>,
}

/// What a storage cell takes at its active edge.
#[derive(Debug)]
pub(super) struct Next {
    pub cell: CellId,
    pub value: Bits,
}

/// A circuit as functions of its inputs and state.
#[derive(Debug, Default)]
pub(super) struct Lowered {
    pub graph: Graph,
    /// For each net its words; empty where the netlist was not lowered up to it.
    pub nets: Vec<Bits>,
    /// State that asynchronous controls may change at once.
    pub levels: Vec<Level>,
    /// For each loop a node that is not 0 where it has not settled after the steps that are followed.
    pub unsettled: Vec<Id>,
    pub next: Vec<Next>,
}

/// Why a cell cannot be compiled.
pub(super) fn unsupported(kind: &CellKind) -> Option<&'static str> {
    let narrow = |w: u32| w <= 64;
    match kind {
        CellKind::Delay { .. } => Some("a delay"),
        CellKind::RcDelay(_) => Some("an RC delay"),
        CellKind::Power { .. } => Some("a power"),
        CellKind::Memory(_) => Some("a memory"),
        CellKind::Multiply { a_width, b_width, .. } if !narrow(*a_width) || !narrow(*b_width) => {
            Some("a multiplier of more than 64 bits")
        }
        CellKind::Divide { width, .. } if !narrow(*width) => Some("a divider of more than 64 bits"),
        CellKind::Shift { a_width, b_width, width, .. }
            if !narrow(*a_width) || !narrow(*b_width) || !narrow(*width) =>
        {
            Some("a shifter of more than 64 bits")
        }
        _ => None,
    }
}

struct Lower<'n, P> {
    netlist: &'n Netlist,
    constants: &'n Constants,
    places: &'n P,
    out: Lowered,
}

/// Cells of a loop up to which it is compiled.
pub(super) const LOOP: usize = 16;

/// Lowers a netlist, every cell of which is supported.
pub(super) fn lower(netlist: &Netlist, places: &impl Places) -> Lowered {
    let out = Lowered { nets: vec![Vec::new(); netlist.nets().len()], ..Lowered::default() };
    let mut l = Lower { netlist, constants: netlist.constants(), places, out };
    for net in netlist.net_ids() {
        let state = match netlist.net(net).driver {
            Driver::Input(_) => true,
            Driver::Cell(cell, 0) => {
                let kind = &netlist.cell(cell).kind;
                kind.init().is_some() || matches!(kind, CellKind::Clock(_))
            }
            Driver::Cell(..) => false,
        };
        if state {
            l.out.nets[net.index()] = l.state(net);
        }
    }
    let order = netlist.order();
    let mut groups = order.groups.iter().peekable();
    for (at, &cell) in order.sequence.iter().enumerate() {
        match groups.peek() {
            Some(group) if group.end == at + 1 => {
                l.feedback(&order.sequence[(*group).clone()]);
                groups.next();
            }
            Some(group) if group.start <= at => {}
            _ => l.cell(cell),
        }
    }
    for cell in netlist.cell_ids() {
        if netlist.cell(cell).kind.edge().is_some() {
            l.next(cell);
        }
    }
    l.out
}

/// Four-valued operators on nodes, as [`Word`] has them on words.
impl Graph {
    fn two(&mut self, w: Word) -> Two {
        Two { v: self.constant(w.v), u: self.constant(w.u) }
    }

    fn known(&mut self, v: Id) -> Two {
        Two { v, u: self.constant(0) }
    }

    /// The bits that are certainly 1.
    fn ones(&mut self, a: Two) -> Id {
        self.and_not(a.v, a.u)
    }

    fn read4(&mut self, a: Two) -> Two {
        Two { v: self.ones(a), u: a.u }
    }

    fn mask4(&mut self, a: Two, m: u64) -> Two {
        let m = self.constant(m);
        Two { v: self.and(a.v, m), u: self.and(a.u, m) }
    }

    fn bits4(&mut self, a: Two, lo: u32, width: u32) -> Two {
        Two { v: self.bits(a.v, lo, width), u: self.bits(a.u, lo, width) }
    }

    fn and4(&mut self, a: Two, b: Two) -> Two {
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.and(x, y);
        let either = self.or(a.u, b.u);
        let (a1, b1) = (self.or(a.u, a.v), self.or(b.u, b.v));
        let u = self.and(either, a1);
        Two { v, u: self.and(u, b1) }
    }

    fn or4(&mut self, a: Two, b: Two) -> Two {
        let (x, y) = (self.ones(a), self.ones(b));
        let v = self.or(x, y);
        let u = self.or(a.u, b.u);
        Two { v, u: self.and_not(u, v) }
    }

    fn xor4(&mut self, a: Two, b: Two) -> Two {
        let u = self.or(a.u, b.u);
        let v = self.xor(a.v, b.v);
        Two { v: self.and_not(v, u), u }
    }

    fn not4(&mut self, a: Two, m: u64) -> Two {
        let one = self.or(a.v, a.u);
        let all = self.constant(m);
        let v = self.and_not(all, one);
        Two { v, u: self.and(a.u, all) }
    }

    fn merge4(&mut self, a: Two, b: Two) -> Two {
        let differ = self.xor(a.v, b.v);
        let u = self.or(a.u, b.u);
        let u = self.or(u, differ);
        Two { v: self.and_not(a.v, u), u }
    }

    fn resolve4(&mut self, a: Two, b: Two, m: u64) -> Two {
        let (za, zb) = (self.and(a.v, a.u), self.and(b.v, b.u));
        let all = self.constant(m);
        let both = self.and_not(all, za);
        let both = self.and_not(both, zb);
        let differ = self.xor(a.v, b.v);
        let conflict = self.or(a.u, b.u);
        let conflict = self.or(conflict, differ);
        let conflict = self.and(both, conflict);
        let same = self.and(a.v, b.v);
        let same = self.and(both, same);
        let same = self.and_not(same, conflict);
        let (av, bv) = (self.and(zb, a.v), self.and(za, b.v));
        let (au, bu) = (self.and(zb, a.u), self.and(za, b.u));
        let v = self.or(av, bv);
        let u = self.or(au, bu);
        Two { v: self.or(v, same), u: self.or(u, conflict) }
    }

    /// `a` where `s`, a node of 0 or 1, is 1.
    fn pick4(&mut self, s: Id, a: Two, b: Two) -> Two {
        Two { v: self.select(s, a.v, b.v), u: self.select(s, a.u, b.u) }
    }

    /// A multiplexer of two with a four-valued select.
    fn mux4(&mut self, s: Two, one: Two, zero: Two) -> Two {
        let chosen = self.pick4(s.v, one, zero);
        if self.is(s.u, 0) {
            return chosen;
        }
        let merged = self.merge4(zero, one);
        self.pick4(s.u, merged, chosen)
    }

    fn join(&mut self, op: GateOp, a: Two, b: Two) -> Two {
        match op {
            GateOp::And | GateOp::Nand => self.and4(a, b),
            GateOp::Xor | GateOp::Xnor => self.xor4(a, b),
            GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => self.or4(a, b),
        }
    }

    fn finish(&mut self, op: GateOp, a: Two, m: u64) -> Two {
        if op.inverts() {
            return self.not4(a, m);
        }
        let a = self.read4(a);
        self.mask4(a, m)
    }

    /// All bits of `w` within `m` joined into one.
    fn reduce(&mut self, op: GateOp, w: Two, m: u64) -> Two {
        let w = self.mask4(w, m);
        if m == 1 {
            return self.read4(w);
        }
        let ones = self.ones(w);
        let (all, unknown) = (self.constant(m), self.any(w.u));
        match op {
            GateOp::And | GateOp::Nand => {
                let v = self.eq(ones, all);
                let one = self.or(w.v, w.u);
                let no_zero = self.eq(one, all);
                Two { v, u: self.and(no_zero, unknown) }
            }
            GateOp::Xor | GateOp::Xnor => {
                let n = self.count(ones);
                let v = self.bits(n, 0, 1);
                Two { v: self.and_not(v, unknown), u: unknown }
            }
            _ => {
                let v = self.any(ones);
                Two { v, u: self.and_not(unknown, v) }
            }
        }
    }

    /// Whether bit 0 is 1.
    fn is_one(&mut self, a: Two) -> Id {
        let one = self.ones(a);
        self.bits(one, 0, 1)
    }

    fn is_zero4(&mut self, a: Two) -> Id {
        let some = self.or(a.v, a.u);
        let some = self.bits(some, 0, 1);
        self.not(some, 1)
    }

    fn any_unknown(&mut self, a: &[Two]) -> Id {
        let zero = self.constant(0);
        let all = a.iter().fold(zero, |all, w| self.or(all, w.u));
        self.any(all)
    }

    /// `a`, or all x where `unknown`, a node of 0 or 1, is 1.
    fn unless(&mut self, unknown: Id, a: Id, m: u64) -> Two {
        let none = self.constant(0);
        Two { v: self.select(unknown, none, a), u: self.splat(unknown, m) }
    }

    /// Two's complement of `width` bits in all 64.
    fn extend(&mut self, a: Id, width: u32) -> Id {
        if width >= 64 {
            return a;
        }
        let sign = self.constant(1 << (width - 1));
        let flipped = self.xor(a, sign);
        self.sub(flipped, sign)
    }

    /// `a + b + ci`, or `a - b - ci` where `sub` is 1, modulo 2^width, and the carry or borrow.
    fn sum(&mut self, width: u32, a: &[Two], b: &[Two], ci: Two, sub: Two) -> (Bits, Two) {
        let (x, y) = (self.any_unknown(a), self.any_unknown(b));
        let controls = self.or(ci.u, sub.u);
        let unknown = self.or(x, y);
        let unknown = self.or(unknown, controls);
        let n = words(width);
        let mut out = Vec::with_capacity(n);
        let subtracts = self.is(sub.v, 1) && self.is(sub.u, 0);
        let adds = self.is(sub.v, 0) && self.is(sub.u, 0);
        let mut carry = if subtracts || adds { ci.v } else { self.xor(ci.v, sub.v) };
        for i in 0..n {
            let m = word_mask(width, i);
            let w = m.count_ones();
            if subtracts {
                let d = self.sub(a[i].v, b[i].v);
                let y = self.sub(d, carry);
                carry = if w < 64 {
                    self.bits(y, 63, 1)
                } else {
                    let (c1, c2) = (self.less(a[i].v, b[i].v), self.less(d, carry));
                    self.or(c1, c2)
                };
                let y = self.bits(y, 0, w);
                out.push(self.unless(unknown, y, m));
                continue;
            }
            let invert = self.splat(sub.v, m);
            let other = self.xor(b[i].v, invert);
            let s = self.add(a[i].v, other);
            let y = self.add(s, carry);
            carry = if w < 64 {
                self.bits(y, w, 1)
            } else {
                let (c1, c2) = (self.less(s, a[i].v), self.less(y, s));
                self.or(c1, c2)
            };
            let y = self.bits(y, 0, w);
            out.push(self.unless(unknown, y, m));
        }
        let carry = if subtracts { carry } else { self.xor(carry, sub.v) };
        (out, self.unless(unknown, carry, 1))
    }

    fn x(&mut self, width: u32) -> Bits {
        (0..words(width)).map(|i| self.two(Word::x(word_mask(width, i)))).collect()
    }

    fn literal(&mut self, value: &crate::Value) -> Bits {
        value.words().map(|w| self.two(w)).collect()
    }

    fn zeros(&mut self, width: u32) -> Bits {
        (0..words(width)).map(|_| self.two(Word::ZERO)).collect()
    }
}

/// `width` bits of a vector from bit `lo` up.
fn slice(g: &mut Graph, from: &[Two], lo: u32, width: u32) -> Bits {
    let (skip, shift) = (lo as usize / 64, lo % 64);
    (0..words(width))
        .map(|i| {
            let m = word_mask(width, i);
            let w = m.count_ones();
            let low = from[skip + i];
            if shift + w <= 64 {
                return g.bits4(low, shift, w);
            }
            let high = from[skip + i + 1];
            let mut plane = |l: Id, h: Id| {
                let (l, h) = (g.shr(l, shift), g.shl(h, 64 - shift));
                let both = g.or(l, h);
                g.bits(both, 0, w)
            };
            Two { v: plane(low.v, high.v), u: plane(low.u, high.u) }
        })
        .collect()
}

/// Puts `width` bits above the `at` bits that a vector has.
fn append(g: &mut Graph, to: &mut Bits, at: u32, from: &[Two], width: u32) {
    let none = g.two(Word::ZERO);
    to.resize(words(at + width), none);
    for (i, &w) in from.iter().enumerate().take(words(width)) {
        let (lo, n) = (at + i as u32 * 64, (width - i as u32 * 64).min(64));
        let (word, shift) = (lo as usize / 64, lo % 64);
        let (low, high) = if shift == 0 {
            (w, none)
        } else {
            let low = Two { v: g.shl(w.v, shift), u: g.shl(w.u, shift) };
            (low, Two { v: g.shr(w.v, 64 - shift), u: g.shr(w.u, 64 - shift) })
        };
        to[word] = Two { v: g.or(to[word].v, low.v), u: g.or(to[word].u, low.u) };
        if shift + n > 64 {
            to[word + 1] = Two { v: g.or(to[word + 1].v, high.v), u: g.or(to[word + 1].u, high.u) };
        }
    }
}

impl<P: Places> Lower<'_, P> {
    fn state(&mut self, net: NetId) -> Bits {
        let (slot, width) = (self.places.slot(net), self.netlist.net(net).width);
        (0..words(width) as u32)
            .map(|i| {
                let m = word_mask(width, i as usize);
                let (half, g) = (2 * (slot + i), &mut self.out.graph);
                let unknown = self.places.may_be_unknown(slot + i);
                Two { v: g.load(half, m), u: if unknown { g.load(half + 1, m) } else { g.constant(0) } }
            })
            .collect()
    }

    /// Some bits of nets, one above another.
    fn signals(&mut self, slices: &[Slice]) -> Bits {
        let mut all = Vec::new();
        let mut at = 0;
        let mut rest = slices;
        while let Some((s, after)) = rest.split_first() {
            rest = after;
            // one bit many times, as an extended sign is
            let times = 1 + after.iter().take_while(|next| s.width == 1 && *next == s).count();
            if times > 1 {
                let bit = self.signals(&slices[slices.len() - rest.len() - 1..][..1])[0];
                let g = &mut self.out.graph;
                let width = times as u32;
                let part: Bits = (0..words(width))
                    .map(|i| {
                        let m = word_mask(width, i);
                        Two { v: g.splat(bit.v, m), u: g.splat(bit.u, m) }
                    })
                    .collect();
                append(g, &mut all, at, &part, width);
                at += width;
                rest = &after[times - 1..];
                continue;
            }
            let g = &mut self.out.graph;
            let part = if self.constants.covers(s) {
                let mut constant = vec![Word::ZERO; words(s.width)];
                crate::value::word::extract(&mut constant, self.constants.net(s.net), s.lo, s.width);
                constant.into_iter().map(|w| g.two(w)).collect()
            } else {
                slice(g, &self.out.nets[s.net.index()], s.lo, s.width)
            };
            append(g, &mut all, at, &part, s.width);
            at += s.width;
        }
        all
    }

    fn pin(&mut self, cell: CellId, pin: usize) -> Bits {
        let kind = &self.netlist.cell(cell).kind;
        let slices = self.netlist.input(cell, pin);
        if slices.is_empty() {
            let mut all = self.out.graph.zeros(kind.input_width(pin).max(1));
            all[0] = self.out.graph.two(Word::known(u64::from(kind.inputs()[pin].default)));
            return all;
        }
        self.signals(slices)
    }

    /// A pin of one bit.
    fn bit(&mut self, cell: CellId, pin: usize) -> Two {
        self.pin(cell, pin)[0]
    }

    fn acts(&self, cell: CellId, pin: usize) -> bool {
        !self.netlist.input(cell, pin).iter().all(|s| self.constants.is_zero(s))
    }

    fn set(&mut self, cell: CellId, pin: usize, value: Bits) {
        self.out.nets[self.netlist.output(cell, pin).index()] = value;
    }

    fn cell(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        match kind {
            CellKind::Clock(_) | CellKind::EdgeFlop(_) => return,
            CellKind::Sr { .. }
            | CellKind::Latch(_)
            | CellKind::Flop(_)
            | CellKind::Counter(_)
            | CellKind::Accumulator(_) => return self.storage(cell),
            CellKind::Gate { op, width: 1, inputs } => {
                let y = self.gate_of_bits(*op, netlist.input(cell, 0), *inputs);
                return self.set(cell, 0, vec![y]);
            }
            CellKind::IsZero { width } => {
                let y = self.gate_of_bits(GateOp::Nor, netlist.input(cell, 0), *width);
                return self.set(cell, 0, vec![y]);
            }
            _ => {}
        }
        let ins: Vec<Bits> = (0..kind.inputs().len()).map(|pin| self.pin(cell, pin)).collect();
        let outs = combinational(&mut self.out.graph, kind, &ins);
        for (pin, value) in outs.into_iter().enumerate() {
            self.set(cell, pin, value);
        }
    }

    /// Cells that read each other in a circle, stepped: in each step all compute from the values before it. What they had
    /// is state, so that the steps go on from there.
    fn feedback(&mut self, cells: &[CellId]) {
        let netlist = self.netlist;
        let outputs: Vec<NetId> = cells
            .iter()
            .flat_map(|&c| (0..netlist.cell(c).kind.outputs().len()).map(move |pin| netlist.output(c, pin)))
            .collect();
        for &net in &outputs {
            self.out.nets[net.index()] = self.state(net);
        }
        // what they hold may change at a clock edge too
        let held = outputs.iter().flat_map(|net| self.out.nets[net.index()].iter().flat_map(|two| [two.v, two.u]));
        let mut needs: Vec<Id> = held.collect();
        for &cell in cells {
            for pin in 0..netlist.cell(cell).kind.inputs().len() {
                for s in netlist.input(cell, pin).iter().filter(|s| !outputs.contains(&s.net)) {
                    needs.extend(self.out.nets[s.net.index()].iter().flat_map(|two| [two.v, two.u]));
                }
            }
        }
        let levels = self.out.levels.len();
        for _ in 0..=cells.len() {
            let new = self.step(cells, &outputs);
            outputs.iter().zip(new).for_each(|(net, value)| self.out.nets[net.index()] = value);
        }
        let beyond = self.step(cells, &outputs);
        let mut differs = self.out.graph.constant(0);
        for (net, new) in outputs.iter().zip(beyond) {
            for (i, new) in new.into_iter().enumerate() {
                let (g, old) = (&mut self.out.graph, self.out.nets[net.index()][i]);
                let (v, u) = (g.xor(old.v, new.v), g.xor(old.u, new.u));
                differs = g.or(differs, v);
                differs = g.or(differs, u);
            }
        }
        self.out.levels.truncate(levels);
        let group = Some(self.out.unsettled.len() as u32);
        let differs = self.out.graph.any(differs);
        self.out.unsettled.push(differs);
        for &net in &outputs {
            let value = self.out.nets[net.index()].clone();
            self.out.levels.push(Level { net, value, needs: needs.clone(), group });
        }
    }

    /// What the nets of a loop become in a step.
    fn step(&mut self, cells: &[CellId], outputs: &[NetId]) -> Vec<Bits> {
        let before: Vec<Bits> = outputs.iter().map(|net| self.out.nets[net.index()].clone()).collect();
        let mut new = Vec::new();
        for &cell in cells {
            self.cell(cell);
            for pin in 0..self.netlist.cell(cell).kind.outputs().len() {
                let net = self.netlist.output(cell, pin).index();
                new.push(self.out.nets[net].clone());
            }
            outputs.iter().zip(&before).for_each(|(net, old)| self.out.nets[net.index()].clone_from(old));
        }
        new
    }

    /// A gate of one bit, of inputs that may lie together in words.
    fn gate_of_bits(&mut self, op: GateOp, slices: &[Slice], inputs: u32) -> Two {
        if inputs == 1 {
            let a = self.signals(slices)[0];
            return self.out.graph.finish(op, a, 1);
        }
        let mut joined: Option<Two> = None;
        for s in slices {
            let words = self.signals(&[*s]);
            for (i, &w) in words.iter().enumerate() {
                let g = &mut self.out.graph;
                let one = g.reduce(op, w, word_mask(s.width, i));
                joined = Some(joined.map_or(one, |all| g.join(op, all, one)));
            }
        }
        let g = &mut self.out.graph;
        let joined = joined.unwrap_or_else(|| g.two(op.identity(1)));
        g.finish(op, joined, 1)
    }

    /// The outputs of a storage cell, after its asynchronous controls.
    fn storage(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let net = netlist.output(cell, 0);
        let mut q = self.out.nets[net.index()].clone();
        let before = q.clone();
        let width = kind.output_width(0);
        match kind {
            CellKind::Sr { set_dominates, .. } => {
                let (s, r) = (self.bit(cell, 0), self.bit(cell, 1));
                let g = &mut self.out.graph;
                let (s, r) = (g.is_one(s), g.is_one(r));
                let (one, zero) = (g.two(Word::known(1)), g.two(Word::ZERO));
                let first = if *set_dominates { (s, one, r, zero) } else { (r, zero, s, one) };
                let held = g.pick4(first.2, first.3, q[0]);
                q[0] = g.pick4(first.0, first.1, held);
            }
            CellKind::Latch(f) => self.level(cell, f, [2, 3, 0], true, &mut q),
            CellKind::Flop(f) => {
                let loads = self.acts(cell, 2);
                self.level(cell, f, [3, 4, 2], loads, &mut q);
            }
            CellKind::Counter(_) => {
                if self.acts(cell, 2) {
                    let (d, load) = (self.pin(cell, 1), self.bit(cell, 2));
                    self.choose(load, &d, &mut q);
                }
                let reset = self.bit(cell, 3);
                let zeros = self.out.graph.zeros(width);
                self.choose(reset, &zeros, &mut q);
            }
            CellKind::Accumulator(_) => {
                let reset = self.bit(cell, 3);
                let zeros = self.out.graph.zeros(width);
                self.choose(reset, &zeros, &mut q);
            }
            _ => {}
        }
        if q != before {
            let pins = (0..kind.inputs().len()).filter(|&pin| match (kind, pin) {
                (CellKind::Flop(_) | CellKind::Counter(_), 1) => self.acts(cell, 2),
                (CellKind::Latch(_), 1) => true,
                _ => kind.inputs()[pin].role == Role::Level,
            });
            let pins: Vec<usize> = pins.collect();
            let needs = pins.into_iter().flat_map(|pin| self.pin(cell, pin)).flat_map(|two| [two.v, two.u]).collect();
            self.out.levels.push(Level { net, value: q.clone(), needs, group: None });
        }
        let derived = match kind {
            CellKind::Counter(_) => {
                let g = &mut self.out.graph;
                let mut any = g.two(Word::ZERO);
                for (i, &w) in q.iter().enumerate() {
                    let one = g.reduce(GateOp::Or, w, word_mask(width, i));
                    any = g.or4(any, one);
                }
                vec![g.not4(any, 1)]
            }
            CellKind::Accumulator(_) => {
                let (d, ci) = (self.pin(cell, 1), self.bit(cell, 2));
                vec![self.carry(width, &q, &d, ci)]
            }
            _ => {
                let g = &mut self.out.graph;
                q.iter().enumerate().map(|(i, &w)| g.not4(w, word_mask(width, i))).collect()
            }
        };
        self.set(cell, 0, q);
        self.set(cell, 1, derived);
    }

    /// The carry of `q + d + ci`.
    fn carry(&mut self, width: u32, q: &[Two], d: &[Two], ci: Two) -> Two {
        let g = &mut self.out.graph;
        let add = g.two(Word::ZERO);
        (0..words(width)).fold(ci, |carry, i| {
            let bits = word_mask(width, i).count_ones();
            g.sum(bits, &q[i..=i], &d[i..=i], carry, add).1
        })
    }

    fn choose(&mut self, control: Two, value: &[Two], q: &mut Bits) {
        let g = &mut self.out.graph;
        let s = g.is_one(control);
        for (q, &w) in q.iter_mut().zip(value) {
            *q = g.pick4(s, w, *q);
        }
    }

    /// Set, reset and load of a flip-flop or latch, whose pins these are.
    fn level(&mut self, cell: CellId, f: &Flop, [set, reset, load]: [usize; 3], loads: bool, q: &mut Bits) {
        if loads {
            let (d, load) = (self.pin(cell, 1), self.bit(cell, load));
            self.choose(load, &d, q);
        }
        for (pin, value) in [(set, &f.set_value), (reset, &f.reset_value)] {
            let control = self.bit(cell, pin);
            let value = self.out.graph.literal(value);
            self.choose(control, &value, q);
        }
    }

    /// What a clocked cell takes at its edge.
    fn next(&mut self, cell: CellId) {
        let netlist = self.netlist;
        let kind = &netlist.cell(cell).kind;
        let mut q = self.out.nets[netlist.output(cell, 0).index()].clone();
        let d = self.pin(cell, 1);
        // from the control that yields to all others up
        match kind {
            CellKind::Flop(f) => {
                let (set, reset) = (self.out.graph.literal(&f.set_value), self.out.graph.literal(&f.reset_value));
                for (pin, value) in [(5, &d), (6, &set), (7, &reset), (2, &d), (3, &set), (4, &reset)] {
                    let control = self.bit(cell, pin);
                    self.choose(control, value, &mut q);
                }
            }
            CellKind::EdgeFlop(f) => {
                let ad = self.pin(cell, 2);
                let (set, reset) = (self.out.graph.literal(&f.set_value), self.out.graph.literal(&f.reset_value));
                for (pin, value) in [(6, &d), (3, &ad), (4, &set), (5, &reset)] {
                    let control = self.bit(cell, pin);
                    self.choose(control, value, &mut q);
                }
            }
            CellKind::Counter(c) => {
                let width = c.init.width();
                let (down, step) = (self.bit(cell, 5), self.out.graph.literal(&c.step));
                let g = &mut self.out.graph;
                let none = g.two(Word::ZERO);
                let counted = g.sum(width, &q, &step, none, down).0;
                let zeros = g.zeros(width);
                for (pin, value) in [(4, &counted), (6, &d), (2, &d), (3, &zeros)] {
                    let control = self.bit(cell, pin);
                    self.choose(control, value, &mut q);
                }
            }
            CellKind::Accumulator(a) => {
                let width = a.init.width();
                let ci = self.bit(cell, 2);
                let g = &mut self.out.graph;
                let add = g.two(Word::ZERO);
                let sum = g.sum(width, &q, &d, ci, add).0;
                let zeros = g.zeros(width);
                for (pin, value) in [(4, &sum), (3, &zeros)] {
                    let control = self.bit(cell, pin);
                    self.choose(control, value, &mut q);
                }
            }
            _ => {}
        }
        self.out.next.push(Next { cell, value: q });
    }
}

/// The outputs of a cell without state.
fn combinational(g: &mut Graph, kind: &CellKind, ins: &[Bits]) -> Vec<Bits> {
    let out = match kind {
        CellKind::Gate { op, width, inputs } => {
            let parts: Vec<Bits> = (0..*inputs).map(|k| slice(g, &ins[0], k * width, *width)).collect();
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let start = g.two(op.identity(m));
                    let joined = parts.iter().fold(start, |all, part| g.join(*op, all, part[i]));
                    g.finish(*op, joined, m)
                })
                .collect()
        }
        CellKind::AndOr { width, inputs } => {
            let mut all = g.zeros(*width);
            for k in 0..*inputs {
                let (part, s) = (slice(g, &ins[0], k * width, *width), slice(g, &ins[1], k, 1)[0]);
                for (i, all) in all.iter_mut().enumerate() {
                    let m = word_mask(*width, i);
                    let gate = Two { v: g.splat(s.v, m), u: g.splat(s.u, m) };
                    let one = g.and4(part[i], gate);
                    *all = g.or4(*all, one);
                }
            }
            all
        }
        CellKind::Mux { width, inputs } => mux(g, *width, *inputs, &ins[0], ins[1][0]),
        CellKind::HalfAdder | CellKind::FullAdder => {
            let (a, b) = (ins[0][0], ins[1][0]);
            let (half, both) = (g.xor4(a, b), g.and4(a, b));
            if *kind == CellKind::HalfAdder {
                return vec![vec![half], vec![both]];
            }
            let ci = ins[2][0];
            let (s, passed) = (g.xor4(half, ci), g.and4(half, ci));
            return vec![vec![s], vec![g.or4(both, passed)]];
        }
        CellKind::Adder { op, width } => {
            let sub = match op {
                AddOp::Add => g.two(Word::ZERO),
                AddOp::Sub => g.two(Word::known(1)),
                AddOp::AddSub => ins[3][0],
            };
            let (y, co) = g.sum(*width, &ins[0], &ins[1], ins[2][0], sub);
            return vec![y, vec![co]];
        }
        CellKind::Multiply { a_width, b_width, signed } => multiply(g, *a_width, *b_width, *signed, ins),
        CellKind::Compare { op, width, signed } => vec![compare(g, *op, *width, *signed, &ins[0], &ins[1])],
        CellKind::Shift { op, a_width, b_width, width } => {
            vec![shift(g, *op, (*a_width, *b_width, *width), ins[0][0], ins[1][0])]
        }
        CellKind::Divide { op, width, signed } => vec![divide(g, *op, *width, *signed, ins[0][0], ins[1][0])],
        CellKind::OneHotMux { width, inputs } => one_hot(g, *width, *inputs, ins),
        CellKind::Demux { width, select } => demux(g, *width, *select, &ins[0], ins[1][0]),
        CellKind::BitMux { width } => (0..words(*width))
            .map(|i| {
                let (a, b, s) = (ins[0][i], ins[1][i], ins[2][i]);
                let both = g.merge4(a, b);
                let one = g.ones(s);
                let any = g.or(s.v, s.u);
                let all = g.constant(word_mask(*width, i));
                let zero = g.and_not(all, any);
                let mut pick = |a: Id, b: Id, both: Id| {
                    let (x, y, z) = (g.and(a, zero), g.and(b, one), g.and(both, s.u));
                    let xy = g.or(x, y);
                    g.or(xy, z)
                };
                Two { v: pick(a.v, b.v, both.v), u: pick(a.u, b.u, both.u) }
            })
            .collect(),
        CellKind::BitSame { width } => (0..words(*width))
            .map(|i| {
                let (a, b) = (ins[0][i], ins[1][i]);
                let (v, u) = (g.xor(a.v, b.v), g.xor(a.u, b.u));
                let differ = g.or(v, u);
                let same = g.not(differ, word_mask(*width, i));
                g.known(same)
            })
            .collect(),
        CellKind::Products { width, table } => {
            let mut any = g.constant(0);
            for product in table.chunks_exact(words(*width)) {
                let mut against = g.constant(0);
                for (i, &(zero, one)) in product.iter().enumerate() {
                    let (ones, some) = (g.ones(ins[0][i]), g.or(ins[0][i].v, ins[0][i].u));
                    let (zero, one) = (g.constant(zero), g.constant(one));
                    let (a, b) = (g.and(zero, ones), g.and_not(one, some));
                    let ab = g.or(a, b);
                    against = g.or(against, ab);
                }
                let against = g.any(against);
                let holds = g.not(against, 1);
                any = g.or(any, holds);
            }
            vec![g.known(any)]
        }
        CellKind::CarrySave { width } => {
            let (mut x, mut y) = (Vec::new(), Vec::new());
            for i in 0..words(*width) {
                let (a, b, c) = (ins[0][i], ins[1][i], ins[2][i]);
                let u = g.or(a.u, b.u);
                let u = g.or(u, c.u);
                let (a, b, c) = (g.and_not(a.v, u), g.and_not(b.v, u), g.and_not(c.v, u));
                let ab = g.xor(a, b);
                y.push(Two { v: g.xor(ab, c), u });
                let (both, passed) = (g.and(a, b), g.and(c, ab));
                x.push(Two { v: g.or(both, passed), u });
            }
            return vec![x, y];
        }
        CellKind::Carry { width } => {
            let (p, q) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
            let unknown = g.or(p, q);
            let unknown = g.or(unknown, ins[2][0].u);
            let mut carry = ins[2][0].v;
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let mut all = g.constant(0);
                    for k in 0..m.count_ones() {
                        let (p, q) = (g.bits(ins[0][i].v, k, 1), g.bits(ins[1][i].v, k, 1));
                        let passed = g.and(p, carry);
                        carry = g.or(q, passed);
                        let placed = g.shl(carry, k);
                        all = g.or(all, placed);
                    }
                    g.unless(unknown, all, m)
                })
                .collect()
        }
        CellKind::Alu(alu) => return alu_of(g, alu, ins),
        CellKind::Tristate { width } => {
            let en = ins[1][0];
            let (one, zero) = (g.is_one(en), g.is_zero4(en));
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let (z, x) = (g.two(Word::z(m)), g.two(Word::x(m)));
                    let off = g.pick4(zero, z, x);
                    g.pick4(one, ins[0][i], off)
                })
                .collect()
        }
        CellKind::Resolve { width, inputs } => {
            let parts: Vec<Bits> = (0..*inputs).map(|k| slice(g, &ins[0], k * width, *width)).collect();
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let none = g.two(Word::z(m));
                    parts.iter().fold(none, |all, part| g.resolve4(all, part[i], m))
                })
                .collect()
        }
        CellKind::Constant(value) => g.literal(value),
        _ => unreachable!("storage and time are not combinational, and what is not supported does not come here"),
    };
    vec![out]
}

fn mux(g: &mut Graph, width: u32, inputs: u32, ins: &[Two], s: Two) -> Bits {
    let bits = crate::cell::select::select_width(inputs);
    let mut level: Vec<Bits> = (0..inputs).map(|k| slice(g, ins, k * width, width)).collect();
    for bit in 0..bits {
        let s = g.bits4(s, bit, 1);
        if level.len() % 2 == 1 {
            let x = g.x(width); // what lies beyond the inputs
            level.push(x);
        }
        level = level
            .chunks_exact(2)
            .map(|pair| pair[0].iter().zip(&pair[1]).map(|(&zero, &one)| g.mux4(s, one, zero)).collect())
            .collect();
    }
    level.swap_remove(0)
}

fn multiply(g: &mut Graph, a_width: u32, b_width: u32, signed: bool, ins: &[Bits]) -> Bits {
    let width = a_width + b_width;
    let (x, y) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(x, y);
    let (mut a, mut b) = (ins[0][0].v, ins[1][0].v);
    if signed {
        (a, b) = (g.extend(a, a_width), g.extend(b, b_width));
    }
    let mut parts = vec![g.mul(a, b)];
    if width > 64 {
        parts.push(g.mul_high(a, b, signed));
    }
    parts
        .into_iter()
        .enumerate()
        .map(|(i, part)| {
            let m = word_mask(width, i);
            let all = g.constant(m);
            let part = g.and(part, all);
            g.unless(unknown, part, m)
        })
        .collect()
}

fn compare(g: &mut Graph, op: CompareOp, width: u32, signed: bool, a: &[Two], b: &[Two]) -> Two {
    let n = words(width);
    if matches!(op, CompareOp::Same | CompareOp::Differs) {
        let mut differ = g.constant(0);
        for i in 0..n {
            let (v, u) = (g.xor(a[i].v, b[i].v), g.xor(a[i].u, b[i].u));
            let vu = g.or(v, u);
            differ = g.or(differ, vu);
        }
        let differ = g.any(differ);
        let y = if op == CompareOp::Differs { differ } else { g.not(differ, 1) };
        return g.known(y);
    }
    let (x, y) = (g.any_unknown(a), g.any_unknown(b));
    let unknown = g.or(x, y);
    if matches!(op, CompareOp::Eq | CompareOp::Ne) {
        let mut differ = g.constant(0);
        for i in 0..n {
            let (v, u) = (g.xor(a[i].v, b[i].v), g.or(a[i].u, b[i].u));
            let certain = g.and_not(v, u);
            differ = g.or(differ, certain);
        }
        let differ = g.any(differ);
        let y = if op == CompareOp::Ne { differ } else { g.not(differ, 1) };
        let unknown = g.and_not(unknown, differ);
        return g.unless(unknown, y, 1);
    }
    let (a, b) = if matches!(op, CompareOp::Gt | CompareOp::Le) { (b, a) } else { (a, b) };
    let mut less = g.constant(0);
    for i in 0..n {
        let sign = if signed && i == n - 1 { 1 << ((width - 1) % 64) } else { 0 };
        let sign = g.constant(sign);
        let (a, b) = (g.xor(a[i].v, sign), g.xor(b[i].v, sign));
        let (here, same) = (g.less(a, b), g.eq(a, b));
        let below = g.and(same, less);
        less = g.or(here, below);
    }
    let y = if matches!(op, CompareOp::Le | CompareOp::Ge) { g.not(less, 1) } else { less };
    g.unless(unknown, y, 1)
}

fn shift(g: &mut Graph, op: ShiftOp, (a_width, b_width, width): (u32, u32, u32), a: Two, b: Two) -> Two {
    let unknown = g.any(b.u);
    let m = mask(width);
    let limit = g.constant(64);
    let zero = g.constant(0);
    let signed = matches!(op, ShiftOp::Both | ShiftOp::PartSigned);
    let negative = if signed { g.bits(b.v, b_width - 1, 1) } else { zero };
    let number = if signed { g.extend(b.v, b_width) } else { b.v };
    let minus = g.sub(zero, number);
    // how far to the left and to the right, and whether that is within a word
    let (left_by, right_by) = if op == ShiftOp::Left { (b.v, zero) } else { (minus, number) };
    let (left_fits, right_fits) = (g.less(left_by, limit), g.less(right_by, limit));
    let moved = |g: &mut Graph, a: Id| {
        let left = |g: &mut Graph| {
            let y = g.shl_by(a, left_by);
            g.select(left_fits, y, zero)
        };
        let right = |g: &mut Graph| {
            let y = g.shr_by(a, right_by);
            g.select(right_fits, y, zero)
        };
        let y = match op {
            ShiftOp::Left => left(g),
            ShiftOp::Right | ShiftOp::Part => right(g),
            ShiftOp::RightSigned => {
                let whole = g.extend(a, a_width);
                let most = g.constant(63);
                let by = g.select(right_fits, right_by, most);
                g.sar_by(whole, by)
            }
            ShiftOp::Both | ShiftOp::PartSigned => {
                let (l, r) = (left(g), right(g));
                g.select(negative, l, r)
            }
        };
        let all = g.constant(m);
        g.and(y, all)
    };
    let (v, mut u) = (moved(g, a.v), moved(g, a.u));
    if matches!(op, ShiftOp::Part | ShiftOp::PartSigned) {
        let whole = g.constant(mask(a_width));
        let inside = moved(g, whole);
        let all = g.constant(m);
        let outside = g.and_not(all, inside);
        u = g.or(u, outside);
    }
    let all = g.splat(unknown, m);
    Two { v: g.select(unknown, zero, v), u: g.or(u, all) }
}

fn divide(g: &mut Graph, op: DivideOp, width: u32, signed: bool, a: Two, b: Two) -> Two {
    let m = mask(width);
    let either = g.or(a.u, b.u);
    let zero = g.constant(0);
    let by_zero = g.eq(b.v, zero);
    let unknown = g.any(either);
    let unknown = g.or(unknown, by_zero);
    let one = g.constant(1);
    let all = g.constant(m);
    let sign = |g: &mut Graph, a: Id| if signed { g.bits(a, width - 1, 1) } else { zero };
    let (a_negative, b_negative) = (sign(g, a.v), sign(g, b.v));
    let negated_if = |g: &mut Graph, s: Id, a: Id| {
        let minus = g.sub(zero, a);
        let minus = g.and(minus, all);
        g.select(s, minus, a)
    };
    let (x, y) = (negated_if(g, a_negative, a.v), negated_if(g, b_negative, b.v));
    let y = g.select(by_zero, one, y);
    let (q, r) = (g.div(x, y), g.rem(x, y));
    let differ = g.xor(a_negative, b_negative);
    let inexact = g.any(r);
    let down = g.and(differ, inexact);
    let result = match op {
        DivideOp::Quotient => negated_if(g, differ, q),
        DivideOp::Floor => {
            let truncated = negated_if(g, differ, q);
            let floored = g.xor(q, all);
            g.select(down, floored, truncated)
        }
        DivideOp::Remainder => negated_if(g, a_negative, r),
        DivideOp::Modulo => {
            let same = negated_if(g, a_negative, r);
            let rest = g.sub(y, r);
            let rest = negated_if(g, b_negative, rest);
            g.select(down, rest, same)
        }
    };
    let result = g.and(result, all);
    g.unless(unknown, result, m)
}

fn one_hot(g: &mut Graph, width: u32, inputs: u32, ins: &[Bits]) -> Bits {
    let mut several = g.any_unknown(&ins[2]);
    let (mut before, one) = (g.constant(0), g.constant(1));
    for i in 0..words(inputs) {
        // more than one line of this word, or one here and one before
        let s = g.ones(ins[2][i]);
        let less = g.sub(s, one);
        let rest = g.and(s, less);
        let (more, some) = (g.any(rest), g.any(s));
        let both = g.and(before, some);
        several = g.or(several, more);
        several = g.or(several, both);
        before = g.or(before, some);
    }
    let mut y = ins[0].clone();
    for k in 0..inputs {
        let (part, s) = (slice(g, &ins[1], k * width, width), slice(g, &ins[2], k, 1)[0]);
        let s = g.is_one(s);
        for (y, part) in y.iter_mut().zip(part) {
            *y = g.pick4(s, part, *y);
        }
    }
    for (i, y) in y.iter_mut().enumerate() {
        let x = g.two(Word::x(word_mask(width, i)));
        *y = g.pick4(several, x, *y);
    }
    y
}

fn demux(g: &mut Graph, width: u32, select: u32, a: &[Two], s: Two) -> Bits {
    let mut all = Vec::new();
    let unknown = g.any(s.u);
    let none = g.two(Word::ZERO);
    let passed: Bits = a
        .iter()
        .map(|&a| {
            let merged = g.merge4(a, none);
            g.pick4(unknown, merged, a)
        })
        .collect();
    for k in 0..1u64 << select {
        let number = g.constant(k);
        let differ = g.xor(s.v, number);
        let differ = g.and_not(differ, s.u);
        let differ = g.any(differ);
        let part: Bits = passed.iter().map(|&w| g.pick4(differ, none, w)).collect();
        append(g, &mut all, k as u32 * width, &part, width);
    }
    all
}

fn alu_of(g: &mut Graph, alu: &Alu, ins: &[Bits]) -> Vec<Bits> {
    let (ci, bi) = (ins[2][0], ins[3][0]);
    let (p, q) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(p, q);
    let controls = g.or(ci.u, bi.u);
    let unknown = g.or(unknown, controls);
    let operand = |g: &mut Graph, a: &[Two], from: u32, i: usize| {
        let m = word_mask(alu.width, i);
        let none = g.two(Word::ZERO);
        let own = if i < words(from) { g.mask4(a[i], m) } else { none };
        if i + 1 < words(from) || from >= alu.width || !alu.signed {
            return own;
        }
        let last = a[words(from) - 1];
        let above = m & !(if i < words(from) { word_mask(from, i) } else { 0 });
        let sign = g.bits4(last, (from - 1) % 64, 1);
        let high = Two { v: g.splat(sign.v, above), u: g.splat(sign.u, above) };
        Two { v: g.or(own.v, high.v), u: g.or(own.u, high.u) }
    };
    let (mut x, mut y, mut co) = (Vec::new(), Vec::new(), Vec::new());
    let mut carry = ci.v;
    for i in 0..words(alu.width) {
        let m = word_mask(alu.width, i);
        let (a, b) = (operand(g, &ins[0], alu.a_width, i), operand(g, &ins[1], alu.b_width, i));
        let invert = Two { v: g.splat(bi.v, m), u: g.splat(bi.u, m) };
        let b = g.xor4(b, invert);
        x.push(g.xor4(a, b));
        let s = g.add(a.v, b.v);
        let sum = g.add(s, carry);
        let (c1, c2) = (g.less(s, a.v), g.less(sum, s));
        let into = g.xor(sum, a.v);
        let into = g.xor(into, b.v);
        let (both, some) = (g.and(a.v, b.v), g.or(a.v, b.v));
        let passed = g.and(into, some);
        let out = g.or(both, passed);
        let all = g.constant(m);
        let (sum, out) = (g.and(sum, all), g.and(out, all));
        y.push(g.unless(unknown, sum, m));
        co.push(g.unless(unknown, out, m));
        carry = g.or(c1, c2);
    }
    vec![x, y, co]
}
