//! The one place where generated code is called. Nothing else in the crate is `unsafe`.

use std::fmt;
use std::sync::Arc;

use cranelift_jit::JITModule;

use crate::value::Word;

/// A finished module: the memory in which generated code lies, and where its functions begin.
pub(crate) struct Code {
    module: Option<JITModule>,
    functions: Vec<Function>,
}

// SAFETY: once a module is finished, the only thing that is ever done to it is to free its memory, by the last that owns it.
// The memory is mapped for the process and belongs to no thread, and nothing else has a pointer into the module. Nothing can be
// done to it through a shared reference.
#[allow(unsafe_code)]
unsafe impl Send for Code {}
#[allow(unsafe_code)]
unsafe impl Sync for Code {}

impl Code {
    /// Takes a finished module and some of its functions.
    pub fn new(module: JITModule, functions: Vec<*const u8>) -> Code {
        Code { module: Some(module), functions: functions.into_iter().map(Function).collect() }
    }
}

/// Where a function begins in the code of the module beside it.
#[derive(Clone, Copy)]
struct Function(*const u8);

// SAFETY: the pointer is only ever called, together with the `Code` that it points into, which it is owned with; the code
// keeps nothing of its own, it works on the memory that the call passes, so any number of threads may run it at once.
#[allow(unsafe_code)]
unsafe impl Send for Function {}
#[allow(unsafe_code)]
unsafe impl Sync for Function {}

impl Drop for Code {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        if let Some(module) = self.module.take() {
            // SAFETY: the pointers into the code are private to the types below, which own it as long as they have them, so
            // nothing can call it any more.
            unsafe { module.free_memory() };
        }
    }
}

/// Compiled partitions.
pub(crate) struct Machine {
    /// What the functions lie in; others may have it too.
    _code: Arc<Code>,
    functions: Vec<Function>,
}

impl fmt::Debug for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Machine({} functions)", self.functions.len())
    }
}

impl Machine {
    /// Takes code whose functions each take the address of the memory and return nothing.
    pub fn new(code: Arc<Code>) -> Machine {
        Machine { functions: code.functions.clone(), _code: code }
    }

    /// Whether two run the same code, in the same place.
    #[cfg(test)]
    pub fn shares(&self, other: &Machine) -> bool {
        Arc::ptr_eq(&self._code, &other._code)
    }

    /// How many partitions there are.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Runs partition `number` on memory of at least the size that it was compiled for.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn run(&self, number: usize, memory: &mut [Word]) {
        let Function(function) = self.functions[number];
        // SAFETY: the code behind the pointer lives as long as `self`, has this signature (`codegen::compile` declares no
        // other), and reads and writes within the slots that were given out before it was made, all of which `memory`
        // has: the engine never shortens it. `Word` is `repr(C)`, two `u64`.
        unsafe {
            let function: extern "C" fn(*mut u64) = std::mem::transmute(function);
            function(memory.as_mut_ptr().cast::<u64>());
        }
    }
}

/// Compiled edges in a loop.
pub(crate) struct EdgeLoop {
    _code: Arc<Code>,
    function: Function,
    /// How many edges there are in the loop.
    pub edges: u64,
}

impl fmt::Debug for EdgeLoop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Circle({} ticks)", self.edges)
    }
}

impl EdgeLoop {
    /// Takes code whose function takes the address of the memory and how often to go round (at least once), and returns how
    /// many edges it has left.
    pub fn new(code: Arc<Code>, edges: u64) -> EdgeLoop {
        EdgeLoop { function: code.functions[0], _code: code, edges }
    }

    /// Goes round up to `rounds` times, at least once; returns how many edges were made.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn run(&self, memory: &mut [Word], rounds: u64) -> u64 {
        // SAFETY: as in `Machine::run`, with the signature of `codegen::compile_circle`.
        let left = unsafe {
            let function: extern "C" fn(*mut u64, u64) -> u64 = std::mem::transmute(self.function.0);
            function(memory.as_mut_ptr().cast::<u64>(), rounds)
        };
        rounds * self.edges - left
    }
}
