//! Code that was made before for the same functions and is still in use: simulators of one netlist share it, however many
//! there are and on whatever threads.
//!
//! What is looked for is what would be compiled, function by function, so nothing can be shared that is not the same: where
//! state lies in memory is part of it.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use cranelift_codegen::ir::Function;
use cranelift_module::FuncId;

use super::machine::Code;

/// 128 bits over all functions of a module, and over those that are called from outside.
pub(super) type Key = [u64; 2];

static MADE: Mutex<Option<HashMap<Key, Weak<Code>>>> = Mutex::new(None);

fn made() -> MutexGuard<'static, Option<HashMap<Key, Weak<Code>>>> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn key(functions: &[(FuncId, Function)], called: &[FuncId]) -> Key {
    [0u64, 1].map(|half| {
        let mut hasher = DefaultHasher::new();
        half.hash(&mut hasher);
        for (id, function) in functions {
            id.as_u32().hash(&mut hasher);
            function.stencil.hash(&mut hasher);
            function.params.user_named_funcs().iter().for_each(|(_, name)| name.hash(&mut hasher));
        }
        called.iter().for_each(|id| id.as_u32().hash(&mut hasher));
        hasher.finish()
    })
}

pub(super) fn find(key: Key) -> Option<Arc<Code>> {
    made().as_ref()?.get(&key)?.upgrade()
}

/// Keeps new code for others, or gives back what another thread has made meanwhile.
pub(super) fn keep(key: Key, code: Arc<Code>) -> Arc<Code> {
    let mut made = made();
    let all = made.get_or_insert_default();
    if let Some(known) = all.get(&key).and_then(Weak::upgrade) {
        return known;
    }
    // what nobody uses any more is gone, and so are the places of it from time to time
    if all.len().is_power_of_two() {
        all.retain(|_, code| code.strong_count() > 0);
    }
    all.insert(key, Arc::downgrade(&code));
    code
}
