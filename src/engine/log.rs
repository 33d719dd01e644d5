//! The changes of traced nets, wave after wave, as an engine writes them down while it goes on.

use crate::netlist::NetId;
use crate::value::changes::Written;

/// A word of a net, as a field of records.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// The traced net.
    pub net: NetId,
    /// Which of its words of 64 bits, the least significant being 0.
    pub word: u32,
    /// How the word is packed in a record.
    pub written: Written,
}

/// Records in order of time, packed as [`changes`](crate::value::changes) says.
#[derive(Debug, Default)]
pub struct Log {
    /// The records. Whoever reads them clears them, or puts an empty list in their place.
    pub words: Vec<u64>,
    /// The fields of each shape. None is ever changed, there are only more.
    pub shapes: Vec<Box<[Field]>>,
}
