//! From operations to those of the code generator: a partition as one straight line on values.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{InstBuilder, MemFlagsData, Value, types};
use cranelift_frontend::FunctionBuilder;

use crate::compiled::codegen::{Shared, dirty_bit};
use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::schedule::{Partition, Schedule};
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;
use crate::compiled::passes::merge::Data;

/// Operations after which what is in memory is brought again.
const WINDOW: u32 = 12;

pub(crate) struct Emit<'a, 'b> {
    graph: &'a Graph,
    schedule: &'a Schedule,
    pub builder: &'a mut FunctionBuilder<'b>,
    /// Where memory begins.
    pub base: Value,
    /// Where it begins for what lies elsewhere each time the code is called, and what that is.
    moved: Option<(&'a Data, &'a [Value])>,
    /// Values, and how much had been made when they were brought from memory.
    values: Map<Id, (Value, u32)>,
    made: u32,
    /// Comparisons as the machine gives them.
    flags: Map<Id, Value>,
    /// The nodes of the partition that are not there yet, and about how many registers each takes.
    pending: Map<Id, u32>,
    /// How many have still to read a plane word as it was.
    readers: Map<PlaneWord, u32>,
    /// Halves that nobody has to read any more.
    read: Vec<PlaneWord>,
    stack: Vec<Id>,
}

/// What has been found to have changed.
#[derive(Default)]
struct Marks {
    guard: Option<Value>,
    dirty: Map<u32, Value>,
    changed: Map<u32, Value>,
}

pub(crate) fn trusted() -> MemFlagsData {
    MemFlagsData::trusted()
}

/// About how many registers it takes to have each node of a partition: Sethi and Ullman's numbers, as if none was used twice.
fn registers(graph: &Graph, partition: &Partition) -> Map<Id, u32> {
    let mut all: Map<Id, u32> = Map::default();
    for &node in &partition.nodes {
        let mut below: Vec<u32> = graph.op(node).operands().map(|o| all.get(&o).copied().unwrap_or_default()).collect();
        below.sort_unstable_by_key(|&n| std::cmp::Reverse(n));
        let most = below.iter().zip(0..).map(|(n, kept)| n + kept).max();
        all.insert(node, most.unwrap_or_default().max(1));
    }
    all
}

impl<'a, 'b> Emit<'a, 'b> {
    pub fn new(
        graph: &'a Graph,
        schedule: &'a Schedule,
        builder: &'a mut FunctionBuilder<'b>,
        base: Value,
        partition: &Partition,
    ) -> Emit<'a, 'b> {
        let mut readers: Map<PlaneWord, u32> = Map::default();
        let mut reads = |node: Id| {
            if let Op::Load(plane) = graph.op(node) {
                *readers.entry(plane).or_default() += 1;
            }
        };
        partition.nodes.iter().for_each(|&n| graph.op(n).operands().for_each(&mut reads));
        partition.stores.iter().map(|s| s.node).chain(partition.puts.iter().flat_map(Put::nodes)).for_each(reads);
        Emit {
            graph,
            schedule,
            builder,
            base,
            moved: None,
            values: Map::default(),
            made: 0,
            flags: Map::default(),
            pending: registers(graph, partition),
            readers,
            read: Vec::new(),
            stack: Vec::new(),
        }
    }

    /// For code that runs on other data too: `bases` are where memory begins, as `data` tells.
    pub fn on(self, data: &'a Data, bases: &'a [Value]) -> Emit<'a, 'b> {
        Emit { moved: Some((data, bases)), ..self }
    }

    /// Where memory begins for a plane word.
    fn begin(&self, plane: PlaneWord) -> Value {
        self.moved.map_or(self.base, |(data, bases)| bases[data.base.get(&plane).copied().unwrap_or_default()])
    }

    /// Emits all operations of a partition.
    pub fn all(&mut self, partition: &Partition) {
        partition.nodes.iter().for_each(|&node| _ = self.need(node));
    }

    /// Emits what a partition must not go on for; returns what is not 0 then, if that can be.
    pub fn bail_outs(&mut self, partition: &Partition) -> Option<Value> {
        let bail_outs: Vec<Value> = partition.bail_outs.iter().map(|&a| self.need(a)).collect();
        bail_outs.into_iter().reduce(|a, b| self.builder.ins().bor(a, b))
    }

    /// Emits a node with all below it that is not there yet, first what takes most registers.
    fn need(&mut self, id: Id) -> Value {
        let graph = self.graph;
        self.stack.push(id);
        while let Some(&at) = self.stack.last() {
            let before = self.stack.len();
            let pending = &self.pending;
            if pending.contains_key(&at) {
                self.stack.extend(graph.op(at).operands().filter(|o| pending.contains_key(o)));
                self.stack[before..].sort_by_key(|o| pending[o]);
            }
            if self.stack.len() == before {
                self.stack.pop();
                if self.pending.remove(&at).is_some() {
                    self.node(at);
                    graph.op(at).operands().for_each(|o| self.has_read(o));
                }
            }
        }
        self.value(id)
    }

    /// Something that reads a node has it.
    fn has_read(&mut self, id: Id) {
        if let Op::Load(plane) = self.graph.op(id)
            && let Some(readers) = self.readers.get_mut(&plane)
        {
            *readers -= 1;
            if *readers == 0 {
                self.read.push(plane);
            }
        }
    }

    /// Emits the rest of the operations of a partition and what it stores; returns what is not 0 where an observed net has
    /// changed or the guard is raised, if either can be. State is stored as soon as all that reads what it was has it: few
    /// values are alive at a time.
    pub fn stores(&mut self, number: u32, partition: &Partition, shared: Shared) -> Option<Value> {
        let mut marks = Marks::default();
        let mut waiting: Map<PlaneWord, (usize, Value)> = Map::default();
        for (at, store) in partition.stores.iter().enumerate() {
            let value = self.need(store.node);
            self.has_read(store.node);
            waiting.insert(store.plane, (at, value));
            if self.readers.get(&store.plane).is_none_or(|&readers| readers == 0) {
                self.read.push(store.plane);
            }
            while let Some(plane) = self.read.pop() {
                if let Some((at, value)) = waiting.remove(&plane) {
                    self.store(number, &partition.stores[at], value, &mut marks);
                }
            }
        }
        partition.puts.iter().flat_map(Put::nodes).for_each(|node| _ = self.need(node));
        // elements are read before anything is written to memories
        self.all(partition);
        partition.puts.iter().for_each(|put| self.put(put));
        let mut rest: Vec<(usize, Value)> = waiting.into_values().collect();
        rest.sort_unstable();
        rest.into_iter().for_each(|(at, value)| self.store(number, &partition.stores[at], value, &mut marks));
        self.marks(marks, shared)
    }

    fn store(&mut self, number: u32, store: &Store, value: Value, marks: &mut Marks) {
        let (begin, offset) = (self.begin(store.plane), offset(store.plane));
        if store.guard {
            marks.guard = Some(marks.guard.map_or(value, |a| self.builder.ins().bor(a, value)));
        }
        if store.again {
            let (word, bit) = dirty_bit(self.schedule.settling, number);
            let none = self.builder.ins().iconst(types::I64, 0);
            let some = self.builder.ins().iconst(types::I64, bit as i64);
            let mark = self.builder.ins().select(value, some, none);
            let joined = marks.dirty.get(&word).map_or(mark, |&b| self.builder.ins().bor(b, mark));
            marks.dirty.insert(word, joined);
        }
        if !store.compared {
            self.builder.ins().store(trusted(), value, begin, offset);
            return;
        }
        let old = self.builder.ins().load(types::I64, trusted(), begin, offset);
        let differs = self.builder.ins().icmp(IntCC::NotEqual, old, value);
        self.builder.ins().store(trusted(), value, begin, offset);
        let mut bits: Vec<(u32, u64, bool)> = Vec::new();
        for &partition in &store.wakes {
            let (word, bit) = dirty_bit(self.schedule.settling, partition);
            match bits.iter_mut().find(|m| m.0 == word) {
                Some(mark) => mark.1 |= bit,
                None => bits.push((word, bit, false)),
            }
        }
        bits.extend(store.observed.map(|bit| (bit / 64, 1 << (bit % 64), true)));
        for (word, bits, observed) in bits {
            let none = self.builder.ins().iconst(types::I64, 0);
            let some = self.builder.ins().iconst(types::I64, bits as i64);
            let mark = self.builder.ins().select(differs, some, none);
            let all = if observed { &mut marks.changed } else { &mut marks.dirty };
            let before = all.get(&word).copied();
            let joined = before.map_or(mark, |b| self.builder.ins().bor(b, mark));
            all.insert(word, joined);
        }
    }

    fn marks(&mut self, marks: Marks, shared: Shared) -> Option<Value> {
        let Marks { guard, dirty, changed } = marks;
        let news = changed.values().copied().chain(guard);
        let mut news: Vec<Value> = news.collect();
        news.sort_unstable();
        let news = news.into_iter().reduce(|a, b| self.builder.ins().bor(a, b));
        let mut marks: Vec<(PlaneWord, Value)> = Vec::new();
        marks.extend(guard.map(|value| (shared.guard, value)));
        marks.extend(dirty.into_iter().map(|(word, value)| (shared.dirty + word, value)));
        marks.extend(changed.into_iter().map(|(word, value)| (shared.changed + word, value)));
        marks.sort_unstable_by_key(|m| m.0);
        for (plane, value) in marks {
            let old = self.builder.ins().load(types::I64, trusted(), self.base, offset(plane));
            let new = self.builder.ins().bor(old, value);
            self.builder.ins().store(trusted(), new, self.base, offset(plane));
        }
        news
    }

    /// A node's value, brought from memory if another partition computes it. What is in memory is brought again where it was
    /// used long ago, and constants are made at each use: registers are few.
    pub fn value(&mut self, id: Id) -> Value {
        if let Some(&(value, at)) = self.values.get(&id)
            && (at == u32::MAX || self.made - at < WINDOW)
        {
            return value;
        }
        let (value, at) = if let Some(&flag) = self.flags.get(&id) {
            (self.builder.ins().uextend(types::I64, flag), u32::MAX)
        } else {
            let plane = match self.graph.op(id) {
                Op::Const(n) => match self.moved.and_then(|(data, _)| data.constants.get(&id)) {
                    Some(&plane) => plane,
                    None => return self.builder.ins().iconst(types::I64, n as i64),
                },
                Op::Load(plane) => plane,
                _ => self.schedule.place[&id],
            };
            let begin = self.begin(plane);
            (self.builder.ins().load(types::I64, trusted(), begin, offset(plane)), self.made)
        };
        self.values.insert(id, (value, at));
        value
    }

    fn node(&mut self, id: Id) {
        let graph = self.graph;
        let value = match graph.op(id) {
            Op::Const(_) | Op::Load(_) => return,
            Op::And(a, b) => self.two(a, b, |i, a, b| i.band(a, b)),
            Op::AndNot(a, b) => self.two(a, b, |i, a, b| i.band_not(a, b)),
            Op::Or(a, b) => self.two(a, b, |i, a, b| i.bor(a, b)),
            Op::Xor(a, b) => self.two(a, b, |i, a, b| i.bxor(a, b)),
            Op::Add(a, b) => self.two(a, b, |i, a, b| i.iadd(a, b)),
            Op::Sub(a, b) => self.two(a, b, |i, a, b| i.isub(a, b)),
            Op::Mul(a, b) => self.two(a, b, |i, a, b| i.imul(a, b)),
            Op::MulHigh(a, b) => self.two(a, b, |i, a, b| i.umulhi(a, b)),
            Op::MulHighSigned(a, b) => self.two(a, b, |i, a, b| i.smulhi(a, b)),
            Op::ShlBy(a, b) => self.two(a, b, |i, a, b| i.ishl(a, b)),
            Op::ShrBy(a, b) => self.two(a, b, |i, a, b| i.ushr(a, b)),
            Op::SarBy(a, b) => self.two(a, b, |i, a, b| i.sshr(a, b)),
            Op::Div(a, b) => self.two(a, b, |i, a, b| i.udiv(a, b)),
            Op::Rem(a, b) => self.two(a, b, |i, a, b| i.urem(a, b)),
            Op::Shl(a, n) => {
                let a = self.value(a);
                self.builder.ins().ishl_imm_u(a, i64::from(n))
            }
            Op::Shr(a, n) => {
                let a = self.value(a);
                self.builder.ins().ushr_imm_u(a, i64::from(n))
            }
            Op::Count(a) => {
                let a = self.value(a);
                self.builder.ins().popcnt(a)
            }
            Op::Eq(a, b) | Op::Less(a, b) => {
                let code = if matches!(graph.op(id), Op::Eq(..)) { IntCC::Equal } else { IntCC::UnsignedLessThan };
                let (a, b) = (self.value(a), self.value(b));
                let flag = self.builder.ins().icmp(code, a, b);
                self.flags.insert(id, flag);
                self.made += 1;
                return;
            }
            Op::Select(s, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                let s = match self.flags.get(&s) {
                    Some(&flag) => flag,
                    None => self.value(s),
                };
                self.builder.ins().select(s, a, b)
            }
            Op::Element { slot, index, size, plane } => {
                let at = self.element(slot, index, size);
                self.load_element(at, size, offset(slot.plane(plane)))
            }
        };
        self.values.insert(id, (value, u32::MAX));
        self.made += 1;
    }

    /// Where an element lies, without the place of its array in memory.
    fn element(&mut self, slot: Slot, index: Id, size: u8) -> Value {
        let (begin, index) = (self.begin(slot.value()), self.value(index));
        if size == 3 {
            let bytes = self.builder.ins().ishl_imm_u(index, 4);
            return self.builder.ins().iadd(begin, bytes);
        }
        // between 8 bytes of a plane there are 8 of the other
        let bytes = self.builder.ins().ishl_imm_u(index, i64::from(size));
        let whole = self.builder.ins().band_imm_u(bytes, !7);
        let bytes = self.builder.ins().iadd(bytes, whole);
        self.builder.ins().iadd(begin, bytes)
    }

    fn load_element(&mut self, at: Value, size: u8, offset: i32) -> Value {
        match size {
            0 => self.builder.ins().uload8(types::I64, trusted(), at, offset),
            1 => self.builder.ins().uload16(types::I64, trusted(), at, offset),
            2 => self.builder.ins().uload32(trusted(), at, offset),
            _ => self.builder.ins().load(types::I64, trusted(), at, offset),
        }
    }

    /// Writes to a memory, where there is anything to write.
    fn put(&mut self, put: &Put) {
        let [mask, v, u] = [put.mask, put.v, put.u].map(|node| self.value(node));
        // the same in both blocks: nothing that the first has may be used in the second
        let at = self.element(put.slot, put.index, put.size);
        let (write, on) = (self.builder.create_block(), self.builder.create_block());
        self.builder.ins().brif(mask, write, &[], on, &[]);
        self.builder.seal_block(write);
        self.builder.switch_to_block(write);
        for (plane, new) in [(0, v), (1, u)] {
            let offset = offset(put.slot.value() + plane);
            let old = self.load_element(at, put.size, offset);
            let kept = self.builder.ins().band_not(old, mask);
            let new = self.builder.ins().band(new, mask);
            let new = self.builder.ins().bor(kept, new);
            match put.size {
                0 => self.builder.ins().istore8(trusted(), new, at, offset),
                1 => self.builder.ins().istore16(trusted(), new, at, offset),
                2 => self.builder.ins().istore32(trusted(), new, at, offset),
                _ => self.builder.ins().store(trusted(), new, at, offset),
            };
        }
        self.builder.ins().jump(on, &[]);
        self.builder.seal_block(on);
        self.builder.switch_to_block(on);
    }

    fn two(
        &mut self,
        a: Id,
        b: Id,
        make: impl FnOnce(cranelift_frontend::FuncInstBuilder<'_, '_>, Value, Value) -> Value,
    ) -> Value {
        let (a, b) = (self.value(a), self.value(b));
        make(self.builder.ins(), a, b)
    }
}

/// Where a plane word lies, in bytes.
pub(crate) fn offset(plane: PlaneWord) -> i32 {
    i32::try_from(plane.index() * 8).expect("memory is smaller than that: the engine sees to it")
}
