//! The bits of an instance: which of the builder's bits each of a module's is.

use std::collections::HashMap;

use super::super::file::{Bit, Module};
use super::{Import, NONE};
use crate::netlist::{Bus, ScopeId};
use crate::{Logic, Value};

/// How the numbers of a module's bits become indices.
pub(super) enum Index {
    /// They are indices.
    Dense(u32),
    /// They are far apart.
    Sparse(HashMap<u32, u32>),
}

impl Index {
    fn new(module: &Module<'_>) -> Index {
        let used = module.all_bits().len();
        if module.bit_end as usize <= 4 * used + 64 {
            return Index::Dense(module.bit_end);
        }
        let mut map = HashMap::new();
        for number in module.all_bits().iter().filter_map(|b| b.number()) {
            let next = map.len() as u32;
            map.entry(number).or_insert(next);
        }
        Index::Sparse(map)
    }

    fn len(&self) -> u32 {
        match self {
            Index::Dense(n) => *n,
            Index::Sparse(map) => map.len() as u32,
        }
    }

    fn of(&self, number: u32) -> usize {
        match self {
            Index::Dense(_) => number as usize,
            Index::Sparse(map) => map[&number] as usize,
        }
    }
}

/// What is worked out once for each module that is used.
pub(super) struct Plan {
    index: Index,
    /// What its storage cells hold at the start, by bit; empty if nothing is said.
    init: Vec<Logic>,
    /// Its cells' first place among the origins.
    pub(super) origin: u32,
}

/// An instance of a module while it is being built.
pub(in super::super) struct Here<'f, 'a> {
    pub module: &'f Module<'a>,
    pub(super) number: usize,
    pub scope: ScopeId,
    /// The bits of the builder, by index.
    pub(super) map: Vec<u32>,
    pub(super) depth: u64,
}

impl<'f, 'a> Import<'f, 'a> {
    /// An instance without bits.
    pub(super) fn here(&mut self, number: usize, scope: ScopeId, depth: u64) -> Here<'f, 'a> {
        let file = self.file;
        let module = &file.modules[number];
        if self.plans[number].is_none() {
            self.check_ports(module);
            let index = Index::new(module);
            let mut init = Vec::new();
            for net in &module.nets {
                let Some(value) = net.init.and_then(|s| file.value(s)) else { continue };
                init.resize(index.len() as usize, Logic::X);
                for (i, bit) in module.bits(net.bits).iter().enumerate().take(value.width() as usize) {
                    if let (Some(n), known @ (Logic::Zero | Logic::One | Logic::Z)) =
                        (bit.number(), value.bit(i as u32))
                    {
                        init[index.of(n)] = known;
                    }
                }
            }
            let origin = self.origins.places();
            for cell in &module.cells {
                self.origins.add(self.span_of(&cell.name), self.term_span(cell.source));
            }
            self.plans[number] = Some(Plan { index, init, origin });
        }
        let bits = self.plan(number).index.len();
        Here { module, number, scope, map: vec![NONE; bits as usize], depth }
    }

    pub(super) fn plan(&self, number: usize) -> &Plan {
        self.plans[number].as_ref().expect("a plan is made with the first instance")
    }

    /// Makes a bit of an instance the builder's bit `to`.
    pub(super) fn bind(&mut self, here: &mut Here<'f, 'a>, bit: Bit, to: u32) {
        let Some(number) = bit.number() else {
            let constant = Value::repeat(bit.constant().unwrap_or(Logic::X), 1);
            let own = self.builder.own_constant(&constant);
            self.builder.join(&own, &Bus::of_bit(to));
            return;
        };
        let at = self.plan(here.number).index.of(number);
        match here.map[at] {
            NONE => here.map[at] = to,
            other => self.builder.join(&Bus::of_bit(other), &Bus::of_bit(to)),
        }
    }

    /// Gives every bit that has none yet one of its own.
    pub(super) fn fill(&mut self, here: &mut Here<'f, 'a>) {
        let free = here.map.iter().filter(|&&b| b == NONE).count() as u32;
        if u64::from(self.builder.bit_count()) + u64::from(free) > self.limits.bits.min(u64::from(u32::MAX) - 2) {
            here.map.iter_mut().for_each(|b| *b = 0);
            return self.too_large("bits", "bits", self.limits.bits, self.span_of(&here.module.name));
        }
        let mut fresh = self.builder.bits(free).bits().collect::<Vec<u32>>().into_iter();
        here.map.iter_mut().filter(|b| **b == NONE).for_each(|b| *b = fresh.next().unwrap_or(0));
    }

    /// The builder's bits for some of an instance.
    pub fn bus(&mut self, here: &Here<'f, 'a>, bits: &[Bit]) -> Bus {
        let mut bus = Bus::default();
        let mut at = 0;
        while at < bits.len() {
            if let Some(number) = bits[at].number() {
                bus.push(here.map[self.plan(here.number).index.of(number)]);
                at += 1;
                continue;
            }
            let constants = bits[at..].iter().map_while(|b| b.constant());
            let run: Vec<Logic> = constants.collect();
            at += run.len();
            let mut value = Value::unknown(run.len() as u32);
            run.iter().enumerate().for_each(|(i, &b)| value.set_bit(i as u32, b));
            bus.append(&self.constant(&value));
        }
        bus
    }

    /// A constant, shared with others unless it is to become part of a wire.
    pub fn constant(&mut self, value: &Value) -> Bus {
        if self.own_constants { self.builder.own_constant(value) } else { self.builder.constant(value) }
    }

    /// What a bit holds at the start.
    pub fn init(&self, here: &Here<'f, 'a>, bit: Bit) -> Logic {
        let plan = self.plan(here.number);
        bit.number().and_then(|n| plan.init.get(plan.index.of(n))).copied().unwrap_or(Logic::X)
    }
}
