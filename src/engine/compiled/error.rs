//! Why a netlist is not compiled.

use std::fmt;

/// Why the compiled engine refuses a netlist, or could not make code for it.
///
/// Printed, it completes "not compiled: …"; paths of cells are hierarchical, with dots.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum CompileError {
    /// A cell of a kind, or of a width, that has no lowering.
    Cell {
        /// The path of the first such cell.
        path: String,
        /// What it is, with its article: "a delay".
        what: &'static str,
    },
    /// A combinational loop through a memory.
    MemoryInLoop {
        /// The path of the memory.
        path: String,
    },
    /// A combinational loop of more cells than are unrolled.
    LoopTooLong {
        /// How many cells are in it.
        cells: usize,
        /// The path of one of them.
        path: String,
    },
    /// The nets of the netlist take more machine words than can be addressed.
    TooManyNetWords {
        /// The most words of 64 bits.
        limit: usize,
    },
    /// The contents of the memories take more machine words than can be addressed.
    TooManyMemoryWords {
        /// The most words of 64 bits.
        limit: usize,
    },
    /// The state and what the code keeps beside it take more memory than can be addressed.
    TooLarge,
    /// One function would be so long that making it takes longer than it saves.
    FunctionTooLong,
    /// The code generator does not run on this machine, for instance since the system forbids executable memory.
    Unavailable {
        /// What it says.
        reason: String,
    },
    /// The code generator failed.
    CodeGenerator {
        /// What it says.
        reason: String,
    },
}

impl CompileError {
    /// A failure of the code generator, in its own words.
    pub(crate) fn generator(reason: impl fmt::Display) -> CompileError {
        CompileError::CodeGenerator { reason: reason.to_string() }
    }
}

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CompileError::Cell { path, what } => write!(f, "it has {what} (`{path}`)"),
            CompileError::MemoryInLoop { path } => {
                write!(f, "it has combinational feedback through a memory (`{path}`)")
            }
            CompileError::LoopTooLong { cells, path } => {
                write!(f, "it has combinational feedback through {cells} cells (`{path}` …)")
            }
            CompileError::TooManyNetWords { limit } => write!(f, "its nets have more than {limit} words of 64 bits"),
            CompileError::TooManyMemoryWords { limit } => {
                write!(f, "its memories have more than {limit} words of 64 bits")
            }
            CompileError::TooLarge => f.write_str("it is too large"),
            CompileError::FunctionTooLong => f.write_str("it is too long"),
            CompileError::Unavailable { reason } => write!(f, "machine code cannot be made here: {reason}"),
            CompileError::CodeGenerator { reason } => f.write_str(reason),
        }
    }
}

impl std::error::Error for CompileError {}
