//! Many changes at once, as whoever runs has them: packed, and not yet cut into variables.

use std::io;
use std::sync::Arc;

use crate::value::changes::Written;

/// Some bits of a field that are some bits of a word of a variable.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Part {
    /// The variable, which is no alias.
    pub var: u32,
    /// Which of its words of 64 bits.
    pub word: u32,
    /// The lowest bit in the field, and in the word of the variable.
    pub from: u8,
    /// The lowest bit in the word of the variable.
    pub to: u8,
    /// How many bits, 1 to 64.
    pub width: u8,
}

impl Part {
    /// So many bits, from bit 0 up.
    #[must_use]
    pub fn mask(&self) -> u64 {
        crate::value::word::mask(self.width.into())
    }
}

/// What the fields of a shape of records are to a waveform.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Shape {
    /// How each field is written, and the first of its parts.
    pub fields: Vec<(Written, u32)>,
    /// The parts of all fields, in order.
    pub parts: Vec<Part>,
}

impl Shape {
    /// The parts of a field.
    #[must_use]
    pub fn parts(&self, field: usize) -> &[Part] {
        let end = self.fields.get(field + 1).map_or(self.parts.len(), |next| next.1 as usize);
        &self.parts[self.fields[field].1 as usize..end]
    }
}

/// Changes in order of time: [records](crate::value::changes), and what their shapes mean. A number of a shape means the
/// same in all batches of a waveform.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// The records.
    pub words: Vec<u64>,
    /// The shapes.
    pub shapes: Arc<Vec<Arc<Shape>>>,
}

/// What takes changes by the batch, in turn with times and changes one by one.
pub trait Batches {
    /// Takes a batch, and gives back a list that can be used again for another.
    ///
    /// # Errors
    /// What the destination says; [`InvalidInput`](io::ErrorKind::InvalidInput) if time goes back.
    fn batch(&mut self, batch: Batch) -> io::Result<Vec<u64>>;
}
