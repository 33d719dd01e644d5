//! The one place where generated code is called. Nothing else in the crate is `unsafe`.

use std::fmt;

use cranelift_jit::JITModule;

use crate::value::Word;

/// The memory in which generated code lies.
struct Code(Option<JITModule>);

// SAFETY: once a module is finished, the only thing that is ever done to it is to free its memory, by whoever owns it. The
// memory is mapped for the process and belongs to no thread, and nothing else has a pointer into the module.
#[allow(unsafe_code)]
unsafe impl Send for Code {}

/// Where a function begins in the code of the module beside it.
#[derive(Clone, Copy)]
struct Function(*const u8);

// SAFETY: the pointer is only ever called, together with the `Code` that it points into, which it is owned with; the code
// keeps nothing of its own, it works on the memory that the call passes.
#[allow(unsafe_code)]
unsafe impl Send for Function {}

impl Drop for Code {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        if let Some(module) = self.0.take() {
            // SAFETY: the pointers into the code are private to the types below and go with them, so nothing can call it
            // any more.
            unsafe { module.free_memory() };
        }
    }
}

/// Compiled partitions.
pub(crate) struct Machine {
    _code: Code,
    functions: Vec<Function>,
}

impl fmt::Debug for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Machine({} functions)", self.functions.len())
    }
}

impl Machine {
    /// Takes a finished module and its functions, each of which takes the address of the memory and returns nothing.
    pub fn new(module: JITModule, functions: Vec<*const u8>) -> Machine {
        Machine { _code: Code(Some(module)), functions: functions.into_iter().map(Function).collect() }
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
    _code: Code,
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
    /// Takes a finished module and its function, which takes the address of the memory and how often to go round (at
    /// least once), and returns how many edges it has left.
    pub fn new(module: JITModule, function: *const u8, edges: u64) -> EdgeLoop {
        EdgeLoop { _code: Code(Some(module)), function: Function(function), edges }
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
