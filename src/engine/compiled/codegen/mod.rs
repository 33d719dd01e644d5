//! From partitions and edges to machine code, through Cranelift: each becomes a function of one straight line that is given where
//! the memory begins.

mod cache;
mod emit;
pub(crate) mod machine;
pub(crate) mod trace;

use std::sync::{Arc, OnceLock};

use cranelift_codegen::Context;
use cranelift_codegen::ir::{AbiParam, FuncRef, Function, InstBuilder, Signature, Value, types};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, default_libcall_names};

use crate::compiled::CompileError;
use crate::compiled::codegen::emit::{Emit, offset, trusted};
use crate::compiled::codegen::machine::{Code, EdgeLoop, Machine};
use crate::compiled::ir::graph::{Graph, Map};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::schedule::{Partition, Schedule};
use crate::compiled::passes::edge::EdgeCode;
use crate::compiled::passes::merge::{Merged, merge};
use crate::compiled::passes::outline::outline;

/// Where the generated code finds what it shares with the engine, in plane words.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shared {
    /// Set to what is unknown of state that is taken to be known.
    pub guard: PlaneWord,
    /// A bit for each observed net.
    pub changed: PlaneWord,
    /// A bit for each settling partition, from a new plane word on one for each other partition.
    pub dirty: PlaneWord,
    /// Where edges write down what has changed: see `changes`.
    pub log: Option<PlaneWord>,
}

/// The plane word, from the first of all these, and the bit that wake a partition.
pub(crate) fn dirty_bit(settling: usize, partition: u32) -> (u32, u64) {
    let partition = partition as usize;
    let (word, bit) = if partition < settling {
        (partition / 64, partition % 64)
    } else {
        (settling.div_ceil(64) + (partition - settling) / 64, (partition - settling) % 64)
    };
    (word as u32, 1 << bit)
}

/// Makes functions of 64-bit integers.
struct Compiler {
    module: JITModule,
    context: Context,
    builders: FunctionBuilderContext,
    /// Functions that are compiled at the end, if there is no code for them yet.
    waiting: Vec<(FuncId, Function)>,
    /// Their instructions; none once there have been so many that they were compiled at once.
    size: Option<usize>,
}

/// Instructions that wait at most, so that memory for what waits stays bounded: of longer code each simulator has its own.
const SHARED: usize = 1 << 19;

impl Compiler {
    fn new() -> Result<Compiler, CompileError> {
        let mut flags = settings::builder();
        let mut set = |name: &str, value: &str| flags.set(name, value).map_err(CompileError::generator);
        // the graph is optimised already, and what is emitted is in an order that suits registers
        set("opt_level", "none")?;
        set("enable_verifier", if cfg!(debug_assertions) { "true" } else { "false" })?;
        set("is_pic", "false")?;
        set("use_colocated_libcalls", "false")?;
        set("unwind_info", "false")?;
        let isa = cranelift_native::builder()
            .map_err(CompileError::generator)?
            .finish(settings::Flags::new(flags))
            .map_err(CompileError::generator)?;
        let module = JITModule::new(JITBuilder::with_isa(isa, default_libcall_names()));
        let (context, builders) = (module.make_context(), FunctionBuilderContext::new());
        Ok(Compiler { module, context, builders, waiting: Vec::new(), size: Some(0) })
    }

    /// Makes a function of what `body` emits into a block that has its arguments as parameters.
    fn define(
        &mut self,
        name: &str,
        arguments: usize,
        results: usize,
        body: impl FnOnce(&mut JITModule, &mut FunctionBuilder<'_>, &[Value]),
    ) -> Result<FuncId, CompileError> {
        let mut signature = Signature::new(self.module.target_config().default_call_conv);
        signature.params.resize(arguments, AbiParam::new(types::I64));
        signature.returns.resize(results, AbiParam::new(types::I64));
        let id = self.module.declare_function(name, Linkage::Local, &signature).map_err(CompileError::generator)?;
        self.context.func.signature = signature;
        let mut builder = FunctionBuilder::new(&mut self.context.func, &mut self.builders);
        let block = builder.create_block();
        builder.append_block_params_for_function_params(block);
        builder.switch_to_block(block);
        builder.seal_block(block);
        let arguments = builder.block_params(block).to_vec();
        body(&mut self.module, &mut builder, &arguments);
        builder.finalize(self.module.target_config());
        let function = std::mem::replace(&mut self.context.func, Function::new());
        self.module.clear_context(&mut self.context);
        self.size = self.size.map(|size| size + function.dfg.num_insts()).filter(|&size| size <= SHARED);
        self.waiting.push((id, function));
        if self.size.is_none() {
            self.compile()?;
        }
        Ok(id)
    }

    /// Compiles what waits.
    fn compile(&mut self) -> Result<(), CompileError> {
        for (id, function) in std::mem::take(&mut self.waiting) {
            self.context.func = function;
            self.module
                .define_function(id, &mut self.context)
                .map_err(|e| CompileError::generator(format!("{e:?}")))?;
            self.module.clear_context(&mut self.context);
        }
        Ok(())
    }

    /// The code, made now or before, with these functions to be called.
    fn finish(mut self, ids: &[FuncId]) -> Result<Arc<Code>, CompileError> {
        let key = self.size.map(|_| cache::key(&self.waiting, ids));
        if let Some(known) = key.and_then(cache::find) {
            drop(Code::new(self.module, Vec::new()));
            return Ok(known);
        }
        self.compile()?;
        self.module.finalize_definitions().map_err(CompileError::generator)?;
        let functions = ids.iter().map(|&id| self.module.get_finalized_function(id)).collect();
        let code = Arc::new(Code::new(self.module, functions));
        Ok(match key {
            Some(key) => cache::keep(key, code),
            None => code,
        })
    }
}

/// Whether code can be made on this machine at all, found out once: systems may forbid memory that is executed.
pub(crate) fn available() -> Result<(), CompileError> {
    static AVAILABLE: OnceLock<Result<(), CompileError>> = OnceLock::new();
    let attempt = || {
        let mut compiler = Compiler::new()?;
        if compiler.module.target_config().pointer_type() != types::I64 {
            return Err(CompileError::generator("the machine does not have 64-bit addresses"));
        }
        let nothing = compiler.define("nothing", 0, 0, |_, builder, _| _ = builder.ins().return_(&[]))?;
        compiler.finish(&[nothing]).map(drop)
    };
    AVAILABLE.get_or_init(attempt).clone().map_err(|why| CompileError::Unavailable { reason: why.to_string() })
}

/// Compiles the partitions of a plan.
pub(crate) fn compile(graph: &Graph, schedule: &Schedule, shared: Shared) -> Result<Machine, CompileError> {
    let mut compiler = Compiler::new()?;
    let mut ids = Vec::new();
    for (number, partition) in schedule.partitions.iter().enumerate() {
        let id = compiler.define(&format!("chunk{number}"), 1, 0, |_, builder, arguments| {
            let mut emit = Emit::new(graph, schedule, builder, arguments[0], partition);
            emit.stores(number as u32, partition, shared);
            builder.ins().return_(&[]);
        })?;
        ids.push(id);
    }
    Ok(Machine::new(compiler.finish(&ids)?))
}

/// Nodes up to which an edge that writes down what it changes can be compiled: it is one function.
const TRACED: usize = 20_000;

/// Nodes up to which an edge in pieces can be compiled, those of pieces that are alike counted once.
const OWN: usize = 100_000;

/// Whether an edge is too long to be one function, where pieces are of about `piece` nodes.
pub(crate) fn is_long(edge: &Partition, piece: usize) -> bool {
    // what is made for a long run may take longer to make
    let most = if edge.bail_outs.is_empty() { 2 } else { 8 };
    edge.nodes.len() > most * piece
}

/// Compiles edges that follow each other in a loop. The code leaves it where an observed net has changed, or state that
/// was taken to be known is not. An edge of more than some pieces of `piece` nodes is made of several functions: the time
/// that one takes to be made grows faster than it does. `fresh` gives places in memory.
pub(crate) fn compile_loop(
    edges: &[&EdgeCode],
    piece: usize,
    shared: Shared,
    mut fresh: impl FnMut() -> PlaneWord,
) -> Result<EdgeLoop, CompileError> {
    let mut compiler = Compiler::new()?;
    let mut made = Vec::new();
    for (number, edge) in edges.iter().enumerate() {
        // what it writes down it does before it stores anything
        let whole = shared.log.is_some();
        if whole && edge.partition.nodes.len() > TRACED {
            return Err(CompileError::FunctionTooLong);
        }
        made.push(match !whole && is_long(&edge.partition, piece) {
            true => Some(Outlined::compile(&mut compiler, edge, number, piece, shared, &mut fresh)?),
            false => None,
        });
    }
    let edge_loop = compiler.define("circle", 2, 1, |module, builder, arguments| {
        emit_loop(module, builder, edges, &made, shared, arguments[0], arguments[1]);
    })?;
    Ok(EdgeLoop::new(compiler.finish(&[edge_loop])?, edges.len() as u64))
}

/// The loop of some edges, those of pieces among them, round at most `most` times; returns how many edges are left.
fn emit_loop(
    module: &mut JITModule,
    builder: &mut FunctionBuilder<'_>,
    edges: &[&EdgeCode],
    made: &[Option<Outlined>],
    shared: Shared,
    base: Value,
    most: Value,
) {
    let (header, exit) = (builder.create_block(), builder.create_block());
    let rounds = builder.append_block_param(header, types::I64);
    let left = builder.append_block_param(exit, types::I64);
    for &(plane, n) in made.iter().flatten().flat_map(|pieces| &pieces.constants) {
        let n = builder.ins().iconst(types::I64, n as i64);
        builder.ins().store(trusted(), n, base, offset(plane));
    }
    builder.ins().jump(header, &[most.into()]);
    builder.switch_to_block(header);
    let schedule = Schedule::default();
    let count = edges.len() as i64;
    for ((number, edge), pieces) in (1..).zip(edges).zip(made) {
        let leave = |builder: &mut FunctionBuilder<'_>, flags: Option<Value>, made: i64| {
            let Some(flags) = flags else { return };
            let all = builder.ins().imul_imm_u(rounds, count);
            let rest = builder.ins().iadd_imm_s(all, -made);
            let on = builder.create_block();
            builder.ins().brif(flags, exit, &[rest.into()], on, &[]);
            builder.seal_block(on);
            builder.switch_to_block(on);
        };
        let news = if let Some(pieces) = pieces {
            pieces.emit(module, builder, base, |builder, flags| leave(builder, flags, number - 1))
        } else {
            let mut emit = Emit::new(&edge.graph, &schedule, builder, base, &edge.partition);
            let bail_outs = emit.bail_outs(&edge.partition);
            leave(emit.builder, bail_outs, number - 1);
            if shared.log.is_some() {
                emit.all(&edge.partition);
            }
            if let Some(log) = shared.log {
                trace::emit(&mut emit, &edge.record, log);
            }
            emit.stores(0, &edge.partition, shared)
        };
        leave(builder, news, number);
    }
    let rest = builder.ins().iadd_imm_s(rounds, -1);
    builder.ins().brif(rest, header, &[rest.into()], exit, &[rest.into()]);
    builder.seal_block(header);
    builder.seal_block(exit);
    builder.switch_to_block(exit);
    builder.ins().return_(&[left]);
}

/// An edge as several functions. Each is given where the memory begins, for each of its bases, and returns what is not 0
/// where the loop is to be left.
struct Outlined {
    /// The function of each piece, and by how many plane words its bases are moved.
    calls: Vec<(FuncId, Vec<i64>)>,
    /// The last piece after which the edge may bail out as if it had not begun.
    gate: Option<usize>,
    /// What the functions want in memory.
    constants: Vec<(PlaneWord, u64)>,
}

impl Outlined {
    fn compile(
        compiler: &mut Compiler,
        edge: &EdgeCode,
        number: usize,
        piece: usize,
        shared: Shared,
        mut fresh: impl FnMut() -> PlaneWord,
    ) -> Result<Outlined, CompileError> {
        let schedule = outline(edge, piece, &mut fresh);
        let Merged { calls, data, constants } = merge(&edge.graph, &schedule, fresh);
        let own = (0..).zip(&calls).zip(&schedule.partitions).filter(|((at, call), _)| call.code == *at);
        if own.map(|(_, partition)| partition.nodes.len()).sum::<usize>() > OWN {
            return Err(CompileError::FunctionTooLong);
        }
        let mut made: Vec<(FuncId, Vec<i64>)> = Vec::new();
        for (at, (call, partition)) in calls.into_iter().zip(&schedule.partitions).enumerate() {
            let id = if call.code < at {
                made[call.code].0
            } else {
                let name = format!("tick{number}_{at}");
                compiler.define(&name, call.moved.len(), 1, |_, builder, bases| {
                    let mut emit = Emit::new(&edge.graph, &schedule, builder, bases[0], partition).on(&data[at], bases);
                    // one with aborts stores nothing but what it leaves for later pieces
                    let bail_outs = emit.bail_outs(partition);
                    let news = emit.stores(0, partition, shared).or(bail_outs);
                    let news = news.unwrap_or_else(|| builder.ins().iconst(types::I64, 0));
                    builder.ins().return_(&[news]);
                })?
            };
            made.push((id, call.moved));
        }
        let gate = schedule.partitions.iter().rposition(|partition| !partition.bail_outs.is_empty());
        Ok(Outlined { calls: made, gate, constants })
    }

    /// Emits the calls of the pieces, and what is to be done after the last that may bail out.
    fn emit(
        &self,
        module: &mut JITModule,
        builder: &mut FunctionBuilder<'_>,
        base: Value,
        leave: impl Fn(&mut FunctionBuilder<'_>, Option<Value>),
    ) -> Option<Value> {
        let mut functions: Map<FuncId, FuncRef> = Map::default();
        let mut all: Option<Value> = None;
        for (at, (id, moved)) in self.calls.iter().enumerate() {
            let function = *functions.entry(*id).or_insert_with(|| module.declare_func_in_func(*id, builder.func));
            let bases: Vec<Value> = moved.iter().map(|planes| builder.ins().iadd_imm_s(base, 8 * planes)).collect();
            let call = builder.ins().call(function, &bases);
            let flags = builder.inst_results(call)[0];
            all = Some(all.map_or(flags, |all| builder.ins().bor(all, flags)));
            if self.gate == Some(at) {
                leave(builder, all.take());
            }
        }
        all
    }
}

#[cfg(test)]
mod tests;
