//! The one place where generated code is called. Nothing else in the crate is `unsafe`.

use std::fmt;

use cranelift_jit::JITModule;

use crate::value::Word;

/// Compiled chunks, and the memory in which their code lies.
pub(super) struct Machine {
    module: Option<JITModule>,
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
        Machine { module: Some(module), functions }
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
        // SAFETY: the code behind the pointer lives as long as `self.module`, has this signature (`codegen::compile`
        // declares no other), and reads and writes within the slots that the plan gave out, all of which `memory` has
        // (`Forms` grows it to what a plan needs before the plan's code can run). `Word` is `repr(C)`, two `u64`.
        unsafe {
            let function: extern "C" fn(*mut u64) = std::mem::transmute(function);
            function(memory.as_mut_ptr().cast::<u64>());
        }
    }
}

impl Drop for Machine {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        if let Some(module) = self.module.take() {
            // SAFETY: `functions` is private and goes with `self`, so nothing can call the code any more.
            unsafe { module.free_memory() };
        }
    }
}
