//! The code that appends what an edge has changed to the log: see `runtime::tracing`.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{InstBuilder, Value, types};

use super::emit::{Emit, offset, trusted};
use crate::compiled::ir::graph::Id;
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::record::{Part, Record};
use crate::value::changes::{self, Written};

/// How many words of records generated code has room for.
pub(crate) const ROOM: usize = 1 << 15;

/// What lies before the records: the bytes from the beginning of the memory to the end of the records, the tick of the
/// next one, how long the input then stays 0, and how long 1.
pub(crate) const END: u32 = 0;
pub(crate) const TIME: u32 = 1;
pub(crate) const WAIT: u32 = 2;
pub(crate) const RECORDS: u32 = 4;

/// Emits the code that writes a record down, before anything is stored.
pub(crate) fn emit(emit: &mut Emit<'_, '_>, record: &Record, log: PlaneWord) {
    let base = emit.base;
    let load = |emit: &mut Emit<'_, '_>, plane| emit.builder.ins().load(types::I64, trusted(), base, offset(plane));
    let time = load(emit, log + TIME);
    let wait = load(emit, log + WAIT + u32::from(record.level));
    let next = emit.builder.ins().iadd(time, wait);
    emit.builder.ins().store(trusted(), next, base, offset(log + TIME));
    if record.fields.is_empty() {
        return;
    }
    let end = load(emit, log + END);
    let start = emit.builder.ins().iadd(base, end);
    let shape = emit.builder.ins().iconst(types::I64, record.shape as i64);
    emit.builder.ins().store(trusted(), shape, start, 0);
    emit.builder.ins().store(trusted(), time, start, 8);
    let head = changes::HEAD + record.fields.len().div_ceil(64);
    let mut at = emit.builder.ins().iadd_imm_s(start, 8 * head as i64);
    let mut any: Option<Value> = None;
    for (number, parts) in record.fields.chunks(64).enumerate() {
        let mut mask: Option<Value> = None;
        for part in parts {
            let bit = changed(emit, part, &mut at);
            mask = Some(match mask {
                None => bit,
                Some(mask) => {
                    let moved = emit.builder.ins().ishl_imm_u(mask, 1);
                    emit.builder.ins().iadd(moved, bit)
                }
            });
        }
        let Some(mask) = mask else { continue };
        let mask = emit.builder.ins().ishl_imm_u(mask, 64 - parts.len() as i64);
        emit.builder.ins().store(trusted(), mask, start, 8 * (changes::HEAD + number) as i32);
        any = Some(any.map_or(mask, |any| emit.builder.ins().bor(any, mask)));
    }
    let mut new = emit.builder.ins().isub(at, base);
    if let Some(any) = any.filter(|_| !record.fields.iter().any(|p| p.input)) {
        new = emit.builder.ins().select(any, new, end);
    }
    emit.builder.ins().store(trusted(), new, base, offset(log + END));
}

/// Puts a value at `at`, which is moved behind it if it has changed; whether it has.
fn changed(emit: &mut Emit<'_, '_>, part: &Part, at: &mut Value) -> Value {
    if part.input {
        return emit.builder.ins().iconst(types::I64, 1);
    }
    let base = emit.base;
    let mut plane = |plane: PlaneWord, node: Option<Id>| {
        let old = emit.builder.ins().load(types::I64, trusted(), base, offset(plane));
        (old, node.map_or(old, |node| emit.value(node)))
    };
    let (old, v) = plane(part.slot.value(), part.v);
    let (differs, bytes) = match part.field.written {
        Written::Toggled => return emit.builder.ins().bxor(old, v),
        Written::Known => {
            emit.builder.ins().store(trusted(), v, *at, 0);
            (emit.builder.ins().icmp(IntCC::NotEqual, old, v), 3)
        }
        Written::Both => {
            let (before, u) = plane(part.slot.unknown(), part.u);
            emit.builder.ins().store(trusted(), v, *at, 0);
            emit.builder.ins().store(trusted(), u, *at, 8);
            let (x, y) = (emit.builder.ins().bxor(old, v), emit.builder.ins().bxor(before, u));
            let either = emit.builder.ins().bor(x, y);
            (emit.builder.ins().icmp_imm_u(IntCC::NotEqual, either, 0), 4)
        }
    };
    let bit = emit.builder.ins().uextend(types::I64, differs);
    let moved = emit.builder.ins().ishl_imm_u(bit, bytes);
    *at = emit.builder.ins().iadd(*at, moved);
    bit
}
