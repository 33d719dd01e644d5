//! From chunks to machine code, through Cranelift. A chunk becomes a function of one straight line that is given where
//! the memory begins.

use std::sync::OnceLock;

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{AbiParam, Function, InstBuilder, MemFlags, Signature, Value, types};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, default_libcall_names};

use super::changes;
use super::fuse::Tick;
use super::graph::{Graph, Id, Map, Op};
use super::machine::{Circle, Machine};
use super::memory::Put;
use super::plan::{Chunk, Half, Plan};
use super::segments::split;

/// Where the generated code finds what it shares with the engine, in halves of slots.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shared {
    /// Set to what is unknown of state that is taken to be known.
    pub alarm: Half,
    /// A bit for each observed net.
    pub changed: Half,
    /// A bit for each settling chunk, from a new half on one for each other chunk.
    pub dirty: Half,
    /// Where ticks write down what has changed: see `changes`.
    pub log: Half,
}

/// The half and the bit that wake a chunk.
pub(super) fn dirty_bit(settling: usize, chunk: u32) -> (u32, u64) {
    let chunk = chunk as usize;
    let (word, bit) = if chunk < settling {
        (chunk / 64, chunk % 64)
    } else {
        (settling.div_ceil(64) + (chunk - settling) / 64, (chunk - settling) % 64)
    };
    (word as u32, 1 << bit)
}

fn module() -> Result<JITModule, String> {
    let mut flags = settings::builder();
    let mut set = |name: &str, value: &str| flags.set(name, value).map_err(|e| e.to_string());
    set("opt_level", "speed")?;
    set("enable_verifier", if cfg!(debug_assertions) { "true" } else { "false" })?;
    set("is_pic", "false")?;
    set("use_colocated_libcalls", "false")?;
    set("unwind_info", "false")?;
    let isa = cranelift_native::builder()?.finish(settings::Flags::new(flags)).map_err(|e| e.to_string())?;
    Ok(JITModule::new(JITBuilder::with_isa(isa, default_libcall_names())))
}

/// Whether code can be made on this machine at all, found out once: systems may forbid memory that is executed.
pub(super) fn available() -> Result<(), String> {
    static AVAILABLE: OnceLock<Result<(), String>> = OnceLock::new();
    let attempt = || {
        let mut module = module()?;
        if module.target_config().pointer_type() != types::I64 {
            return Err("the machine does not have 64-bit addresses".into());
        }
        let mut context = module.make_context();
        context.func.signature = Signature::new(module.target_config().default_call_conv);
        let mut builders = FunctionBuilderContext::new();
        let mut builder = FunctionBuilder::new(&mut context.func, &mut builders);
        let block = builder.create_block();
        builder.switch_to_block(block);
        builder.seal_block(block);
        builder.ins().return_(&[]);
        builder.finalize();
        let signature = context.func.signature.clone();
        let id = module.declare_function("nothing", Linkage::Local, &signature).map_err(|e| e.to_string())?;
        module.define_function(id, &mut context).map_err(|e| format!("{e:?}"))?;
        module.finalize_definitions().map_err(|e| e.to_string())?;
        drop(Machine::new(module, Vec::new()));
        Ok(())
    };
    AVAILABLE.get_or_init(attempt).clone().map_err(|why| format!("machine code cannot be made here: {why}"))
}

/// Compiles the chunks of a plan.
pub(super) fn compile(graph: &Graph, plan: &Plan, shared: Shared) -> Result<Machine, String> {
    let mut module = module()?;
    let pointer = module.target_config().pointer_type();
    let mut signature = Signature::new(module.target_config().default_call_conv);
    signature.params.push(AbiParam::new(pointer));
    let mut context = module.make_context();
    let mut builders = FunctionBuilderContext::new();
    let mut ids = Vec::new();
    for (number, chunk) in plan.chunks.iter().enumerate() {
        context.func.signature = signature.clone();
        let mut builder = FunctionBuilder::new(&mut context.func, &mut builders);
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        builder.seal_block(block);
        let base = builder.block_params(block)[0];
        let mut emit = Emit::new(graph, plan, &mut builder, base);
        emit.nodes(chunk);
        emit.stores(number as u32, chunk, shared);
        builder.ins().return_(&[]);
        builder.finalize();
        let id = module
            .declare_function(&format!("chunk{number}"), Linkage::Local, &signature)
            .map_err(|e| e.to_string())?;
        module.define_function(id, &mut context).map_err(|e| format!("{e:?}"))?;
        module.clear_context(&mut context);
        ids.push(id);
    }
    module.finalize_definitions().map_err(|e| e.to_string())?;
    let functions: Vec<*const u8> = ids.iter().map(|&id| module.get_finalized_function(id)).collect();
    Ok(Machine::new(module, functions))
}

/// Nodes up to which a tick that writes down what it changes can be compiled: it is one function.
const TRACED: usize = 6000;

/// Compiles ticks that follow each other in a circle. The code leaves it where an observed net has changed, or state that
/// was taken to be known is not. A tick of more than some pieces of `piece` nodes is made of several functions: the time
/// that one takes to be made grows faster than it does. `fresh` gives places in memory.
pub(super) fn compile_circle(
    ticks: &[&Tick],
    piece: usize,
    shared: Shared,
    mut fresh: impl FnMut() -> Half,
) -> Result<Circle, String> {
    let mut module = module()?;
    let mut context = module.make_context();
    let mut builders = FunctionBuilderContext::new();
    // the functions of each tick, and the one after which it may still be left
    let mut pieces: Vec<(Vec<FuncId>, Option<usize>)> = Vec::new();
    for tick in ticks {
        let (mut list, mut gate) = (Vec::new(), None);
        // what it writes down it does before it stores anything
        let whole = shared.log != 0;
        if whole && tick.chunk.nodes.len() > TRACED {
            return Err("it is too long".into());
        }
        // what is made for a long run may take longer to make
        let most = if tick.chunk.aborts.is_empty() { 2 } else { 8 };
        if !whole && tick.chunk.nodes.len() > most * piece {
            let plan = split(tick, piece, &mut fresh);
            gate = plan.chunks.iter().position(|chunk| !chunk.aborts.is_empty());
            for chunk in &plan.chunks {
                let name = format!("piece{}_{}", pieces.len(), list.len());
                context.func.signature = piece_signature(&module);
                compile_piece(&mut context.func, &mut builders, &tick.graph, &plan, chunk, shared);
                let id = module
                    .declare_function(&name, Linkage::Local, &context.func.signature)
                    .map_err(|e| e.to_string())?;
                module.define_function(id, &mut context).map_err(|e| format!("{e:?}"))?;
                module.clear_context(&mut context);
                list.push(id);
            }
        }
        pieces.push((list, gate));
    }
    let mut signature = Signature::new(module.target_config().default_call_conv);
    signature.params.extend([AbiParam::new(types::I64), AbiParam::new(types::I64)]);
    signature.returns.push(AbiParam::new(types::I64));
    context.func.signature = signature.clone();
    let mut builder = FunctionBuilder::new(&mut context.func, &mut builders);
    let (entry, header, exit) = (builder.create_block(), builder.create_block(), builder.create_block());
    builder.append_block_params_for_function_params(entry);
    let rounds = builder.append_block_param(header, types::I64);
    let left = builder.append_block_param(exit, types::I64);
    builder.switch_to_block(entry);
    builder.seal_block(entry);
    let (base, most) = (builder.block_params(entry)[0], builder.block_params(entry)[1]);
    builder.ins().jump(header, &[most.into()]);
    builder.switch_to_block(header);
    let plan = Plan::default();
    let count = ticks.len() as i64;
    for ((number, tick), (pieces, gate)) in (1..).zip(ticks).zip(&pieces) {
        let leave = |builder: &mut FunctionBuilder<'_>, flags: Option<Value>, made: i64| {
            let Some(flags) = flags else { return };
            let all = builder.ins().imul_imm(rounds, count);
            let rest = builder.ins().iadd_imm(all, -made);
            let on = builder.create_block();
            builder.ins().brif(flags, exit, &[rest.into()], on, &[]);
            builder.seal_block(on);
            builder.switch_to_block(on);
        };
        let news = if pieces.is_empty() {
            let mut emit = Emit::new(&tick.graph, &plan, &mut builder, base);
            let aborts = emit.nodes(&tick.chunk);
            leave(emit.builder, aborts, number - 1);
            changes::emit(&mut emit, &tick.record, shared.log);
            emit.stores(0, &tick.chunk, shared)
        } else {
            let mut all: Option<Value> = None;
            for (at, &id) in pieces.iter().enumerate() {
                let function = module.declare_func_in_func(id, builder.func);
                let call = builder.ins().call(function, &[base]);
                let flags = builder.inst_results(call)[0];
                if *gate == Some(at) {
                    leave(&mut builder, Some(flags), number - 1);
                    continue;
                }
                all = Some(all.map_or(flags, |all| builder.ins().bor(all, flags)));
            }
            all
        };
        leave(&mut builder, news, number);
    }
    let rest = builder.ins().iadd_imm(rounds, -1);
    builder.ins().brif(rest, header, &[rest.into()], exit, &[rest.into()]);
    builder.seal_block(header);
    builder.seal_block(exit);
    builder.switch_to_block(exit);
    builder.ins().return_(&[left]);
    builder.finalize();
    let id = module.declare_function("circle", Linkage::Local, &signature).map_err(|e| e.to_string())?;
    module.define_function(id, &mut context).map_err(|e| format!("{e:?}"))?;
    module.clear_context(&mut context);
    module.finalize_definitions().map_err(|e| e.to_string())?;
    let function = module.get_finalized_function(id);
    Ok(Circle::new(module, function, ticks.len() as u64))
}

/// Of a piece of a tick: it is given where the memory begins, and returns whether the circle is to be left.
fn piece_signature(module: &JITModule) -> Signature {
    let mut signature = Signature::new(module.target_config().default_call_conv);
    signature.params.push(AbiParam::new(types::I64));
    signature.returns.push(AbiParam::new(types::I64));
    signature
}

fn compile_piece(
    function: &mut Function,
    builders: &mut FunctionBuilderContext,
    graph: &Graph,
    plan: &Plan,
    chunk: &Chunk,
    shared: Shared,
) {
    let mut builder = FunctionBuilder::new(function, builders);
    let block = builder.create_block();
    builder.append_block_params_for_function_params(block);
    builder.switch_to_block(block);
    builder.seal_block(block);
    let base = builder.block_params(block)[0];
    let mut emit = Emit::new(graph, plan, &mut builder, base);
    // one with aborts stores nothing but what it leaves for later pieces
    let aborts = emit.nodes(chunk);
    let news = emit.stores(0, chunk, shared).or(aborts);
    let news = news.unwrap_or_else(|| builder.ins().iconst(types::I64, 0));
    builder.ins().return_(&[news]);
    builder.finalize();
}

pub(super) struct Emit<'a, 'b> {
    graph: &'a Graph,
    plan: &'a Plan,
    pub builder: &'a mut FunctionBuilder<'b>,
    pub base: Value,
    values: Map<Id, Value>,
    /// Comparisons as the machine gives them.
    flags: Map<Id, Value>,
}

pub(super) fn trusted() -> MemFlags {
    MemFlags::trusted()
}

impl<'a, 'b> Emit<'a, 'b> {
    fn new(graph: &'a Graph, plan: &'a Plan, builder: &'a mut FunctionBuilder<'b>, base: Value) -> Emit<'a, 'b> {
        Emit { graph, plan, builder, base, values: Map::default(), flags: Map::default() }
    }

    /// Emits the operations of a chunk; returns what is not 0 where it must not go on, if that can be.
    fn nodes(&mut self, chunk: &Chunk) -> Option<Value> {
        for &node in &chunk.nodes {
            self.node(node);
        }
        let aborts: Vec<Value> = chunk.aborts.iter().map(|&a| self.value(a)).collect();
        aborts.into_iter().reduce(|a, b| self.builder.ins().bor(a, b))
    }

    /// Emits what a chunk stores; returns what is not 0 where an observed net has changed or the alarm is raised, if
    /// either can be.
    fn stores(&mut self, number: u32, chunk: &Chunk, shared: Shared) -> Option<Value> {
        // all that is read is read before anything is stored
        let values: Vec<Value> = chunk.stores.iter().map(|s| self.value(s.node)).collect();
        for put in &chunk.puts {
            for node in [put.index, put.mask, put.v, put.u] {
                self.value(node);
            }
        }
        chunk.puts.iter().for_each(|put| self.put(put));
        let mut alarm: Option<Value> = None;
        let mut dirty: Map<u32, Value> = Map::default();
        let mut changed: Map<u32, Value> = Map::default();
        for (store, value) in chunk.stores.iter().zip(values) {
            let offset = offset(store.half);
            if store.alarm {
                alarm = Some(alarm.map_or(value, |a| self.builder.ins().bor(a, value)));
            }
            if store.again {
                let (word, bit) = dirty_bit(self.plan.settling, number);
                let none = self.builder.ins().iconst(types::I64, 0);
                let some = self.builder.ins().iconst(types::I64, bit as i64);
                let mark = self.builder.ins().select(value, some, none);
                let joined = dirty.get(&word).map_or(mark, |&b| self.builder.ins().bor(b, mark));
                dirty.insert(word, joined);
            }
            if !store.compared {
                self.builder.ins().store(trusted(), value, self.base, offset);
                continue;
            }
            let old = self.builder.ins().load(types::I64, trusted(), self.base, offset);
            let differs = self.builder.ins().icmp(IntCC::NotEqual, old, value);
            self.builder.ins().store(trusted(), value, self.base, offset);
            let mut marks: Vec<(u32, u64, bool)> = Vec::new();
            for &chunk in &store.wakes {
                let (word, bit) = dirty_bit(self.plan.settling, chunk);
                match marks.iter_mut().find(|m| m.0 == word) {
                    Some(mark) => mark.1 |= bit,
                    None => marks.push((word, bit, false)),
                }
            }
            marks.extend(store.observed.map(|bit| (bit / 64, 1 << (bit % 64), true)));
            for (word, bits, observed) in marks {
                let none = self.builder.ins().iconst(types::I64, 0);
                let some = self.builder.ins().iconst(types::I64, bits as i64);
                let mark = self.builder.ins().select(differs, some, none);
                let all = if observed { &mut changed } else { &mut dirty };
                let before = all.get(&word).copied();
                let joined = before.map_or(mark, |b| self.builder.ins().bor(b, mark));
                all.insert(word, joined);
            }
        }
        let news = changed.values().copied().chain(alarm);
        let mut news: Vec<Value> = news.collect();
        news.sort_unstable();
        let news = news.into_iter().reduce(|a, b| self.builder.ins().bor(a, b));
        let mut marks: Vec<(Half, Value)> = Vec::new();
        marks.extend(alarm.map(|value| (shared.alarm, value)));
        marks.extend(dirty.into_iter().map(|(word, value)| (shared.dirty + word, value)));
        marks.extend(changed.into_iter().map(|(word, value)| (shared.changed + word, value)));
        marks.sort_unstable_by_key(|m| m.0);
        for (half, value) in marks {
            let old = self.builder.ins().load(types::I64, trusted(), self.base, offset(half));
            let new = self.builder.ins().bor(old, value);
            self.builder.ins().store(trusted(), new, self.base, offset(half));
        }
        news
    }

    /// A node's value, brought from memory if another chunk computes it.
    pub fn value(&mut self, id: Id) -> Value {
        if let Some(&value) = self.values.get(&id) {
            return value;
        }
        let value = if let Some(&flag) = self.flags.get(&id) {
            self.builder.ins().uextend(types::I64, flag)
        } else {
            match self.graph.op(id) {
                Op::Const(n) => self.builder.ins().iconst(types::I64, n as i64),
                Op::Load(half) => self.builder.ins().load(types::I64, trusted(), self.base, offset(half)),
                _ => {
                    let half = self.plan.place[&id];
                    self.builder.ins().load(types::I64, trusted(), self.base, offset(half))
                }
            }
        };
        self.values.insert(id, value);
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
                self.builder.ins().ishl_imm(a, i64::from(n))
            }
            Op::Shr(a, n) => {
                let a = self.value(a);
                self.builder.ins().ushr_imm(a, i64::from(n))
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
                let at = self.element(index, size);
                self.load_element(at, size, offset(2 * slot + u32::from(plane)))
            }
        };
        self.values.insert(id, value);
    }

    /// Where an element lies after the beginning of its array.
    fn element(&mut self, index: Id, size: u8) -> Value {
        let index = self.value(index);
        if size == 3 {
            let bytes = self.builder.ins().ishl_imm(index, 4);
            return self.builder.ins().iadd(self.base, bytes);
        }
        // between 8 bytes of a plane there are 8 of the other
        let bytes = self.builder.ins().ishl_imm(index, i64::from(size));
        let whole = self.builder.ins().band_imm(bytes, !7);
        let bytes = self.builder.ins().iadd(bytes, whole);
        self.builder.ins().iadd(self.base, bytes)
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
        let at = self.element(put.index, put.size);
        let (write, on) = (self.builder.create_block(), self.builder.create_block());
        self.builder.ins().brif(mask, write, &[], on, &[]);
        self.builder.seal_block(write);
        self.builder.switch_to_block(write);
        for (plane, new) in [(0, v), (1, u)] {
            let offset = offset(2 * put.slot + plane);
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

/// Where half a slot lies, in bytes.
pub(super) fn offset(half: Half) -> i32 {
    i32::try_from(u64::from(half) * 8).expect("memory is smaller than that: the engine sees to it")
}
