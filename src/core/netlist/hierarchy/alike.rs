//! Whether an instance is one of a module that is there already.
//!
//! Two instances of one module may look different in the flat netlist, where two ports of one of them are connected to
//! the same net: nothing tells any more which of the two a cell inside reads. Instances with fewer such ports come first,
//! and another is one of the same module if the module's cells, connected as that instance is, are its cells.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use super::body::Build;
use super::{Module, Piece, Source};
use crate::netlist::{Direction, ScopeId, SignalId};

impl Build<'_, '_> {
    /// A number that instances of one module have in common.
    pub fn shape(&self, scope: ScopeId) -> u64 {
        let (netlist, home) = (self.flat.netlist, self.home(scope));
        let mut hash = DefaultHasher::new();
        netlist.scopes()[scope.index()].module.hash(&mut hash);
        for &block in &home.blocks[1..] {
            netlist.scopes()[block.index()].name.hash(&mut hash);
        }
        home.ways.hash(&mut hash);
        for &id in &home.signals {
            let signal = netlist.signal(id);
            (&signal.name, signal.width, self.block_of(signal.scope)).hash(&mut hash);
        }
        for &id in &home.cells {
            let cell = netlist.cell(id);
            (&cell.name, cell.element, self.block_of(cell.scope)).hash(&mut hash);
        }
        for &child in &home.children {
            (&netlist.scopes()[child.index()].name, self.block_around(child), self.module_of(child)).hash(&mut hash);
        }
        hash.finish()
    }

    /// Whether two instances have the same members, whatever they are connected to.
    fn is_alike(&self, a: ScopeId, b: ScopeId) -> bool {
        let (netlist, one, other) = (self.flat.netlist, self.home(a), self.home(b));
        let scope = |id: ScopeId| &netlist.scopes()[id.index()];
        let around = |id: ScopeId| scope(id).parent.map(|p| self.block_of(p));
        let same = |x: ScopeId, y: ScopeId| scope(x).name == scope(y).name && around(x) == around(y);
        scope(a).module == scope(b).module
            && one.ways == other.ways
            && one.blocks.len() == other.blocks.len()
            && one.signals.len() == other.signals.len()
            && one.cells.len() == other.cells.len()
            && one.children.len() == other.children.len()
            && one.blocks[1..].iter().zip(&other.blocks[1..]).all(|(&x, &y)| same(x, y))
            && one.signals.iter().zip(&other.signals).all(|(&x, &y)| {
                let (x, y) = (netlist.signal(x), netlist.signal(y));
                (&x.name, x.width, x.signed, x.hidden, x.port) == (&y.name, y.width, y.signed, y.hidden, y.port)
                    && self.block_of(x.scope) == self.block_of(y.scope)
            })
            && one.cells.iter().zip(&other.cells).all(|(&x, &y)| {
                let (x, y) = (netlist.cell(x), netlist.cell(y));
                (&x.name, x.element, &x.kind) == (&y.name, y.element, &y.kind)
                    && self.block_of(x.scope) == self.block_of(y.scope)
            })
            && one
                .children
                .iter()
                .zip(&other.children)
                .all(|(&x, &y)| same(x, y) && self.of_scope[x.index()] == self.of_scope[y.index()])
    }

    /// Whether an instance is one of a module. What module it would be by itself is left in `own` where that had to be made.
    pub fn is_of(&mut self, scope: ScopeId, module: usize, own: &mut Option<Module>) -> bool {
        let rep = self.modules[module].scope;
        if !self.is_alike(rep, scope) {
            return false;
        }
        if self.home(scope).crossing.is_empty() && self.home(rep).crossing.is_empty() {
            return self.fits(scope, &self.modules[module]);
        }
        let own = &*own.get_or_insert_with(|| self.module(scope));
        let there = &self.modules[module];
        let pins = |m: &Module| -> Vec<_> { m.cells.iter().map(|c| (c.inputs.clone(), c.outputs.clone())).collect() };
        let wires = |m: &Module| -> Vec<_> {
            m.wires.iter().map(|w| (w.name.clone(), w.block, w.width, w.port, w.bits.clone())).collect()
        };
        let ports = |m: &Module| -> Vec<_> { m.instances.iter().map(|i| i.ports.clone()).collect() };
        pins(own) == pins(there) && wires(own) == wires(there) && ports(own) == ports(there)
    }

    /// Whether a module's cells, connected as an instance with the same members is, are that instance's cells.
    fn fits(&self, scope: ScopeId, module: &Module) -> bool {
        let (flat, home, rep) = (self.flat, self.home(scope), self.home(module.scope));
        let mut at: HashMap<SignalId, usize> = HashMap::new();
        rep.signals.iter().enumerate().for_each(|(k, &s)| {
            at.insert(s, k);
        });
        let wires: Vec<Vec<u32>> = module
            .wires
            .iter()
            .map(|wire| match (wire.signal, wire.source) {
                (Some(s), _) => flat.signal(home.signals[at[&s]]).collect(),
                (None, Some(Source::Output { cell, pin, lo })) => {
                    flat.output(home.cells[cell], pin).skip(lo as usize).take(wire.width as usize).collect()
                }
                (None, Some(Source::Instance { instance, port, lo })) => {
                    let bits = self.port_bits(home.children[instance], port);
                    bits[lo as usize..][..wire.width as usize].to_vec()
                }
                (None, _) => Vec::new(),
            })
            .collect();
        // bit by bit the same net, or the same value
        let is = |pieces: &[Piece], bits: &mut dyn Iterator<Item = u32>| {
            pieces.iter().all(|piece| match piece {
                Piece::Wire { wire, lo, width } => {
                    let own = wires[*wire].get(*lo as usize..(lo + width) as usize);
                    own.is_some_and(|own| own.iter().all(|&b| bits.next() == Some(b)))
                }
                Piece::Constant(value) => (0..value.width()).all(|i| {
                    let value = Some(value.bit(i));
                    bits.next().and_then(|b| flat.literal(b)) == value
                }),
                Piece::Open(width) => (0..*width).all(|_| bits.next().is_some()),
            }) && bits.next().is_none()
        };
        module.wires.iter().zip(&wires).all(|(w, own)| is(&w.bits, &mut own.iter().copied()))
            && module.cells.iter().zip(&home.cells).all(|(cell, &id)| {
                cell.inputs.iter().enumerate().all(|(pin, p)| is(p, &mut flat.input(id, pin)))
                    && cell.outputs.iter().enumerate().all(|(pin, p)| is(p, &mut flat.output(id, pin)))
            })
            && module.instances.iter().zip(&home.children).all(|(instance, &child)| {
                let mut driven = HashSet::new();
                instance.ports.iter().enumerate().all(|(port, pieces)| {
                    let bits = self.port_bits(child, port);
                    let output = self.modules[instance.module].wires[port].port == Some(Direction::Output);
                    // what is left open there is not to be needed here
                    let open = |bit: u32, driven: &mut HashSet<u32>| !self.comes_out(bit, child) || !driven.insert(bit);
                    let mut at = 0;
                    let as_open = pieces.iter().all(|piece| {
                        let bits = &bits[at..at + piece.width() as usize];
                        at += piece.width() as usize;
                        !output
                            || bits.iter().all(|&b| {
                                let open = open(b, &mut driven);
                                open || !matches!(piece, Piece::Open(_)) || !self.is_read(b, scope)
                            })
                    });
                    as_open && is(pieces, &mut bits.iter().copied())
                })
            })
    }

    /// Whether a bit is seen outside of a module or by a name.
    fn is_read(&self, bit: u32, scope: ScopeId) -> bool {
        self.flat.leaves(bit, scope) || self.home(scope).signals.iter().any(|&s| self.flat.signal(s).any(|b| b == bit))
    }

    /// Whether an instance drives a bit of its output from within, and something around it may need it.
    pub fn comes_out(&self, bit: u32, child: ScopeId) -> bool {
        self.flat.literal(bit).is_none() && self.flat.leaves(bit, child) && self.flat.driven(bit, child).0
    }
}
