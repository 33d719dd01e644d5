//! From the members of an instance to a module: which net is which wire, and what stands where.

use std::collections::HashMap;

use super::super::{Direction, Netlist, ScopeId};
use super::flat::{Flat, Home};
use super::names::Names;
use super::{Block, Cell, Hierarchy, Instance, Module, Piece, Source, Wire, names};
use crate::Value;

const NONE: u32 = u32::MAX;

pub(super) fn recover(netlist: &Netlist) -> Hierarchy {
    let flat = Flat::new(netlist);
    let mut build = Build {
        claims: vec![(NONE, 0, 0); flat.bits()],
        uses: vec![(NONE, 0, false); flat.bits()],
        of_scope: vec![None; netlist.scopes().len()],
        modules: Vec::new(),
        flat: &flat,
    };
    // children before parents, then those whose ports are connected to different nets
    let mut height = vec![0u32; netlist.scopes().len()];
    let mut order: Vec<usize> = Vec::new();
    for i in (0..netlist.scopes().len()).rev().filter(|&i| !flat.homes[i].blocks.is_empty()) {
        height[i] = flat.homes[i].children.iter().map(|c| height[c.index()] + 1).max().unwrap_or(0);
        order.push(i);
    }
    let mut seen = vec![NONE; flat.bits()];
    order.sort_by_cached_key(|&i| {
        let home = &flat.homes[i];
        let mut blurred = 0u32;
        for bit in home.signals[..home.ports].iter().flat_map(|&p| flat.signal(p)) {
            let again = std::mem::replace(&mut seen[bit as usize], i as u32) == i as u32;
            blurred += u32::from(again || flat.literal(bit).is_some());
        }
        (height[i], blurred, i)
    });
    let mut known: HashMap<u64, Vec<usize>> = HashMap::new();
    for i in order {
        let scope = ScopeId::new(i);
        let shape = build.shape(scope);
        let candidates = known.entry(shape).or_default();
        // made once at most: the second time its bits would be claimed already
        let mut own = None;
        let found = candidates.iter().copied().find(|&m| build.is_of(scope, m, &mut own));
        let module = found.unwrap_or_else(|| {
            let module = own.take().unwrap_or_else(|| build.module(scope));
            build.modules.push(module);
            candidates.push(build.modules.len() - 1);
            build.modules.len() - 1
        });
        build.of_scope[i] = Some(module as u32);
        build.modules[module].uses += 1;
    }
    let Build { modules, of_scope, .. } = build;
    let mut hierarchy = sorted(&height, modules, of_scope);
    names::name_modules(netlist, &mut hierarchy.modules);
    hierarchy
}

/// Puts the top first, and every module after those that use it, otherwise in the order of their first instances.
fn sorted(height: &[u32], modules: Vec<Module>, of_scope: Vec<Option<u32>>) -> Hierarchy {
    let mut first = vec![usize::MAX; modules.len()];
    for (i, module) in of_scope.iter().enumerate().rev() {
        module.iter().for_each(|&m| first[m as usize] = i);
    }
    let mut order: Vec<usize> = (0..modules.len()).collect();
    order.sort_by_key(|&m| (std::cmp::Reverse(height[first[m]]), first[m]));
    let mut place = vec![0u32; modules.len()];
    order.iter().enumerate().for_each(|(to, &m)| place[m] = to as u32);
    let mut modules: Vec<Option<Module>> = modules.into_iter().map(Some).collect();
    let mut modules: Vec<Module> = order.iter().filter_map(|&m| modules[m].take()).collect();
    for instance in modules.iter_mut().flat_map(|m| &mut m.instances) {
        instance.module = place[instance.module] as usize;
    }
    Hierarchy { modules, of_scope: of_scope.into_iter().map(|m| m.map(|m| place[m as usize])).collect() }
}

pub(super) struct Build<'f, 'n> {
    pub flat: &'f Flat<'n>,
    pub modules: Vec<Module>,
    pub of_scope: Vec<Option<u32>>,
    /// For each bit the wire that stands for it and which of the wire's bits it is, in the instance of the first number.
    pub claims: Vec<(u32, u32, u32)>,
    /// For each bit the innermost block around its uses and whether anybody reads it, in the instance of the first number.
    pub uses: Vec<(u32, u32, bool)>,
}

impl Build<'_, '_> {
    pub fn home(&self, scope: ScopeId) -> &Home {
        &self.flat.homes[scope.index()]
    }

    pub fn block_of(&self, scope: ScopeId) -> usize {
        self.flat.block_of[scope.index()] as usize
    }

    /// The blocks around which a child instance stands.
    pub fn block_around(&self, child: ScopeId) -> usize {
        self.flat.netlist.scopes()[child.index()].parent.map_or(0, |p| self.block_of(p))
    }

    pub fn module_of(&self, scope: ScopeId) -> usize {
        self.of_scope[scope.index()].map_or(0, |m| m as usize)
    }

    /// The bits of a port of an instance whose module is known.
    pub fn port_bits(&self, child: ScopeId, port: usize) -> Vec<u32> {
        let home = self.home(child);
        match port.checked_sub(home.ports) {
            None => self.flat.signal(home.signals[port]).collect(),
            Some(made) => home.crossing[made].0.clone(),
        }
    }

    /// The module that an instance is of.
    pub fn module(&mut self, scope: ScopeId) -> Module {
        let flat = self.flat;
        let home = &flat.homes[scope.index()];
        let around = |s: ScopeId| flat.netlist.scopes()[s.index()].parent.map(|p| self.block_of(p));
        let block = |(i, &s): (usize, &ScopeId)| Block {
            name: flat.netlist.scopes()[s.index()].name.clone(),
            parent: if i == 0 { None } else { around(s) },
            scope: s,
        };
        let origin = flat.netlist.scopes()[scope.index()].module.clone().unwrap_or_default();
        let mut module = Module {
            name: origin.clone(),
            origin,
            scope,
            uses: 0,
            blocks: home.blocks.iter().enumerate().map(block).collect(),
            wires: Vec::new(),
            cells: Vec::new(),
            instances: Vec::new(),
        };
        self.find_uses(scope, &module.blocks);
        self.claim(scope, &mut module);
        module.cells = home.cells.iter().map(|&id| self.cell(scope, id)).collect();
        module.instances = home.children.iter().map(|&child| self.instance(scope, child)).collect();
        module
    }

    /// Finds for each bit the innermost block around all that use or drive it.
    fn find_uses(&mut self, scope: ScopeId, blocks: &[Block]) {
        let (flat, me) = (self.flat, scope.0);
        let home = &flat.homes[scope.index()];
        let mut uses = std::mem::take(&mut self.uses);
        let mut used = |bit: u32, block: usize, read: bool| {
            let at = &mut uses[bit as usize];
            *at = match *at {
                (home, other, before) if home == me => {
                    let (mut a, mut b) = (block, other as usize);
                    while a != b {
                        // a parent comes before its children
                        if a > b {
                            a = blocks[a].parent.unwrap_or(0);
                        } else {
                            b = blocks[b].parent.unwrap_or(0);
                        }
                    }
                    (me, a as u32, before | read)
                }
                _ => (me, block as u32, read),
            };
        };
        for &id in &home.cells {
            let cell = flat.netlist.cell(id);
            let block = self.block_of(cell.scope);
            (0..cell.kind.inputs().len()).for_each(|p| flat.input(id, p).for_each(|b| used(b, block, true)));
            (0..cell.kind.outputs().len()).for_each(|p| flat.output(id, p).for_each(|b| used(b, block, false)));
        }
        for &id in &home.signals {
            let block = self.block_of(flat.netlist.signal(id).scope);
            flat.signal(id).for_each(|b| used(b, block, true));
        }
        for &child in &home.children {
            let block = self.block_around(child);
            for (p, port) in self.modules[self.module_of(child)].ports().iter().enumerate() {
                let output = port.port == Some(Direction::Output);
                let bits = self.port_bits(child, p).into_iter().filter(|&b| flat.leaves(b, child));
                bits.for_each(|b| used(b, block, !output));
            }
        }
        home.crossing.iter().flat_map(|c| &c.0).for_each(|&b| used(b, 0, true));
        self.uses = uses;
    }

    fn claimed(&self, bit: u32, scope: ScopeId) -> Option<(u32, u32)> {
        let (home, wire, at) = self.claims[bit as usize];
        (home == scope.0).then_some((wire, at))
    }

    fn is_used(&self, bit: u32, scope: ScopeId) -> bool {
        matches!(self.uses[bit as usize], (home, _, true) if home == scope.0)
    }

    /// Makes the wires, and gives each bit the one that stands for it.
    fn claim(&mut self, scope: ScopeId, module: &mut Module) {
        let flat = self.flat;
        let home = &flat.homes[scope.index()];
        let mut names = Names::new(flat, home);
        for (k, &id) in home.signals.iter().enumerate() {
            let signal = flat.netlist.signal(id);
            module.wires.push(Wire {
                name: signal.name.clone(),
                block: self.block_of(signal.scope),
                width: signal.width,
                signed: signal.signed,
                hidden: signal.hidden,
                port: home.ways.get(k).copied(),
                bits: Vec::new(),
                signal: Some(id),
                source: None,
            });
        }
        let mut made = Vec::new();
        for (k, (bits, inwards)) in home.crossing.iter().enumerate() {
            let way = if *inwards { Direction::Input } else { Direction::Output };
            let way = if flat.driven(bits[0], scope) == (true, true) { Direction::Inout } else { way };
            made.push((made_wire(names.of_bit(bits[0]), 0, bits.len(), Some(way), Source::Port(k)), bits.clone()));
        }
        // made ports come after the others
        let ports = home.ports;
        let mut wires: Vec<(Wire, Vec<u32>)> = std::mem::take(&mut module.wires)
            .into_iter()
            .zip(&home.signals)
            .map(|(w, &s)| (w, flat.signal(s).collect()))
            .collect();
        let rest = wires.split_off(ports);
        wires.extend(made);
        wires.extend(rest);

        let rank = |w: &Wire| match w.port {
            Some(Direction::Input) => 0,
            Some(Direction::Inout) => 1,
            Some(Direction::Output) => 2,
            None => 3 + u8::from(w.hidden),
        };
        let mut order: Vec<usize> = (0..wires.len()).collect();
        order.sort_by_key(|&k| rank(&wires[k].0));
        for k in order {
            let (wire, bits) = &wires[k];
            for (at, &bit) in bits.iter().enumerate() {
                let free = self.claimed(bit, scope).is_none();
                let stands = match wire.port {
                    Some(Direction::Input) => !flat.driven(bit, scope).0 || flat.literal(bit).is_some(),
                    Some(Direction::Inout) => true,
                    Some(Direction::Output) => flat.literal(bit).is_none() && flat.driven(bit, scope).0,
                    None => flat.literal(bit).is_none() && self.uses[bit as usize].1 as usize == wire.block,
                };
                if free && stands {
                    self.claims[bit as usize] = (scope.0, k as u32, at as u32);
                }
            }
        }
        // what is used and has no name yet
        let mut more = |build: &mut Self, bits: &[u32], source: &dyn Fn(u32) -> Source| {
            let needs = |build: &Self, bit: u32| {
                build.is_used(bit, scope) && build.claimed(bit, scope).is_none() && flat.literal(bit).is_none()
            };
            let mut at = 0;
            while at < bits.len() {
                if !needs(build, bits[at]) {
                    at += 1;
                    continue;
                }
                let block = build.uses[bits[at] as usize].1;
                let (from, wire) = (at, wires.len());
                while at < bits.len() && needs(build, bits[at]) && build.uses[bits[at] as usize].1 == block {
                    build.claims[bits[at] as usize] = (scope.0, wire as u32, (at - from) as u32);
                    at += 1;
                }
                let name = names.of_bit(bits[from]);
                let wire = made_wire(name, block as usize, at - from, None, source(from as u32));
                wires.push((wire, bits[from..at].to_vec()));
            }
        };
        for (c, &id) in home.cells.iter().enumerate() {
            for pin in 0..flat.netlist.cell(id).kind.outputs().len() {
                let bits: Vec<u32> = flat.output(id, pin).collect();
                more(self, &bits, &|lo| Source::Output { cell: c, pin, lo });
            }
        }
        for (i, &child) in home.children.iter().enumerate() {
            for p in 0..self.modules[self.module_of(child)].ports().len() {
                let bits = self.port_bits(child, p);
                more(self, &bits, &|lo| Source::Instance { instance: i, port: p, lo });
            }
        }
        module.wires = wires
            .into_iter()
            .enumerate()
            .map(|(k, (mut wire, bits))| {
                let own = matches!(wire.port, Some(Direction::Input | Direction::Inout));
                wire.bits = match own {
                    true => vec![Piece::Wire { wire: k, lo: 0, width: wire.width }],
                    false => self.pieces(scope, bits.into_iter()),
                };
                wire
            })
            .collect();
    }

    /// Bits as pieces of the wires that stand for them.
    fn pieces(&self, scope: ScopeId, bits: impl Iterator<Item = u32>) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        for bit in bits {
            let piece = match (self.claimed(bit, scope), self.flat.literal(bit)) {
                (Some((wire, at)), _) => Piece::Wire { wire: wire as usize, lo: at, width: 1 },
                (None, Some(value)) => Piece::Constant(Value::repeat(value, 1)),
                (None, None) => Piece::Open(1),
            };
            push(&mut pieces, piece);
        }
        pieces
    }

    fn cell(&self, scope: ScopeId, id: super::CellId) -> Cell {
        let (flat, cell) = (self.flat, self.flat.netlist.cell(id));
        let inputs = (0..cell.kind.inputs().len()).map(|p| self.pieces(scope, flat.input(id, p)));
        let outputs = (0..cell.kind.outputs().len()).map(|p| self.pieces(scope, flat.output(id, p)));
        Cell { id, block: self.block_of(cell.scope), inputs: inputs.collect(), outputs: outputs.collect() }
    }

    fn instance(&self, scope: ScopeId, child: ScopeId) -> Instance {
        let module = self.module_of(child);
        let mut driven = std::collections::HashSet::new();
        let ports = self.modules[module].ports().iter().enumerate().map(|(p, port)| {
            let bits = self.port_bits(child, p);
            let leaves = |&b: &u32| self.flat.leaves(b, child) || self.flat.literal(b).is_some();
            let mut pieces = Vec::new();
            for bit in bits {
                let connected = match port.port {
                    Some(Direction::Output) => self.comes_out(bit, child) && driven.insert(bit),
                    _ => leaves(&bit),
                };
                let piece = if connected { self.pieces(scope, std::iter::once(bit)).remove(0) } else { Piece::Open(1) };
                push(&mut pieces, piece);
            }
            pieces
        });
        Instance {
            name: self.flat.netlist.scopes()[child.index()].name.clone(),
            block: self.block_around(child),
            module,
            scope: child,
            ports: ports.collect(),
        }
    }
}

fn made_wire(name: String, block: usize, width: usize, port: Option<Direction>, source: Source) -> Wire {
    Wire {
        name,
        block,
        width: width as u32,
        signed: false,
        hidden: true,
        port,
        bits: Vec::new(),
        signal: None,
        source: Some(source),
    }
}

/// Adds a piece of one bit above others.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match (pieces.last_mut(), &piece) {
        (Some(Piece::Wire { wire, lo, width }), Piece::Wire { wire: w, lo: at, .. })
            if wire == w && *lo + *width == *at =>
        {
            *width += 1;
        }
        (Some(Piece::Open(width)), Piece::Open(_)) => *width += 1,
        (Some(Piece::Constant(value)), Piece::Constant(bit)) => {
            let mut more = Value::unknown(value.width() + 1);
            (0..value.width()).for_each(|i| more.set_bit(i, value.bit(i)));
            more.set_bit(value.width(), bit.bit(0));
            *value = more;
        }
        _ => pieces.push(piece),
    }
}
