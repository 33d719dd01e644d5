//! The one place where generated code is called. Nothing else in the crate is `unsafe`.

use std::fmt;

use cranelift_jit::JITModule;

use crate::value::Word;

/// The memory in which generated code lies.
struct Code(Option<JITModule>);

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

/// Compiled chunks.
pub(crate) struct Machine {
    _code: Code,
    functions: Vec<*const u8>,
}

impl fmt::Debug for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Machine({} functions)", self.functions.len())
    }
}

impl Machine {
    /// Takes a finished module and its functions, each of which takes the address of the memory and returns nothing.
    pub fn new(module: JITModule, functions: Vec<*const u8>) -> Machine {
        Machine { _code: Code(Some(module)), functions }
    }

    /// How many chunks there are.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Runs chunk `number` on memory of at least the size that it was compiled for.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn run(&self, number: usize, memory: &mut [Word]) {
        let function = self.functions[number];
        // SAFETY: the code behind the pointer lives as long as `self`, has this signature (`codegen::compile` declares no
        // other), and reads and writes within the slots that were given out before it was made, all of which `memory`
        // has: the engine never shortens it. `Word` is `repr(C)`, two `u64`.
        unsafe {
            let function: extern "C" fn(*mut u64) = std::mem::transmute(function);
            function(memory.as_mut_ptr().cast::<u64>());
        }
    }
}

/// Compiled ticks in a circle.
pub(crate) struct Circle {
    _code: Code,
    function: *const u8,
    /// How many ticks there are in the circle.
    pub ticks: u64,
}

impl fmt::Debug for Circle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Circle({} ticks)", self.ticks)
    }
}

impl Circle {
    /// Takes a finished module and its function, which takes the address of the memory and how often to go round (at
    /// least once), and returns how many ticks it has left.
    pub fn new(module: JITModule, function: *const u8, ticks: u64) -> Circle {
        Circle { _code: Code(Some(module)), function, ticks }
    }

    /// Goes round up to `rounds` times, at least once; returns how many ticks were made.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn run(&self, memory: &mut [Word], rounds: u64) -> u64 {
        // SAFETY: as in `Machine::run`, with the signature of `codegen::compile_circle`.
        let left = unsafe {
            let function: extern "C" fn(*mut u64, u64) -> u64 = std::mem::transmute(self.function);
            function(memory.as_mut_ptr().cast::<u64>(), rounds)
        };
        rounds * self.ticks - left
    }
}
