//! What one edge writes down of the nets that are traced.

use super::graph::{Id, Map};
use super::places::{PlaneWord, Slot};
use super::stores::Store;
use crate::Field;
use crate::netlist::NetId;
use crate::value::changes::{self, Written};

/// A word of a traced net.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traced {
    pub net: NetId,
    pub word: u32,
    pub slot: Slot,
    /// Whether all of it is always known.
    pub known: bool,
    /// Whether the net is one bit.
    pub bit: bool,
}

/// What an edge writes down.
#[derive(Debug, Default)]
pub(crate) struct Record {
    pub shape: usize,
    /// What the input becomes.
    pub level: bool,
    pub fields: Vec<Part>,
}

#[derive(Debug)]
pub(crate) struct Part {
    pub field: Field,
    pub slot: Slot,
    /// The nodes that it becomes; where there is none, it stays.
    pub v: Option<Id>,
    pub u: Option<Id>,
    /// Whether it is the input, which always changes.
    pub input: bool,
}

impl Record {
    /// What an edge writes down that stores this.
    pub fn new(traced: Vec<Traced>, stores: &[Store], input: Slot, level: bool) -> Record {
        let stored: Map<PlaneWord, Id> = stores.iter().map(|s| (s.plane, s.node)).collect();
        let part = |t: Traced| {
            let (v, u) = (stored.get(&(t.slot.value())).copied(), stored.get(&(t.slot.unknown())).copied());
            let input = t.slot == input;
            let written = match (t.known, t.bit) {
                (true, true) => Written::Toggled,
                (true, false) => Written::Known,
                (false, _) => Written::Both,
            };
            let written = if input { Written::Toggled } else { written };
            let field = Field { net: t.net, word: t.word, written };
            (input || v.is_some() || u.is_some()).then_some(Part { field, slot: t.slot, v, u, input })
        };
        Record { shape: 0, level, fields: traced.into_iter().filter_map(part).collect() }
    }

    pub fn fields(&self) -> Box<[Field]> {
        self.fields.iter().map(|p| p.field).collect()
    }

    pub fn longest(&self) -> usize {
        changes::longest(self.fields.iter().map(|p| p.field.written))
    }
}
