//! From chunks to machine code, through Cranelift. A chunk becomes a function of one straight line that is given where
//! the memory begins.

use std::sync::OnceLock;

use cranelift_codegen::ir::{AbiParam, Function, InstBuilder, Signature, Value, types};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, default_libcall_names};

use super::changes;
use super::emit::Emit;
use super::fuse::Tick;
use super::graph::Graph;
use super::machine::{Circle, Machine};
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
    // the graph is optimised already, and what is emitted is in an order that suits registers
    set("opt_level", "none")?;
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
        let mut emit = Emit::new(graph, plan, &mut builder, base, chunk);
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
const TRACED: usize = 20000;

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
            let mut emit = Emit::new(&tick.graph, &plan, &mut builder, base, &tick.chunk);
            let aborts = emit.aborts(&tick.chunk);
            leave(emit.builder, aborts, number - 1);
            if shared.log != 0 {
                emit.all(&tick.chunk);
            }
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
    let mut emit = Emit::new(graph, plan, &mut builder, base, chunk);
    // one with aborts stores nothing but what it leaves for later pieces
    let aborts = emit.aborts(chunk);
    let news = emit.stores(0, chunk, shared).or(aborts);
    let news = news.unwrap_or_else(|| builder.ins().iconst(types::I64, 0));
    builder.ins().return_(&[news]);
    builder.finalize();
}
