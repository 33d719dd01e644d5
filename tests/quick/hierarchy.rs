//! The modules that a netlist is made of, put together again wire by wire, give the netlist.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use discreta::cell::CellKind;
use discreta::netlist::hierarchy::*;
use discreta::netlist::*;

/// What a pin or a signal is connected to: here and in the flat netlist.
type Connection = (Vec<Bit>, Vec<(u32, u32)>);

/// The netlist that a hierarchy describes, put together again wire by wire.
struct Whole<'n> {
    netlist: &'n Netlist,
    hierarchy: &'n Hierarchy,
    /// Which wires are one.
    root: Vec<usize>,
    /// For each wire, by its root, the bit of the flat netlist that it is.
    flat: HashMap<usize, (u32, u32)>,
    /// The other way round.
    wire: HashMap<(u32, u32), usize>,
    /// What a cell's pin must be: the pieces' wires, checked when all are joined.
    pins: Vec<Connection>,
    children: HashMap<(ScopeId, String), Vec<ScopeId>>,
    cells: HashMap<(ScopeId, String), Vec<CellId>>,
    signals: HashMap<(ScopeId, String), Vec<SignalId>>,
    shared: HashMap<(u32, u32), (u32, u32)>,
    seen: usize,
}

#[derive(Clone, Debug, PartialEq)]
enum Bit {
    Wire(usize),
    Constant(discreta::Logic),
    Open,
}

impl<'n> Whole<'n> {
    fn new(netlist: &'n Netlist, hierarchy: &'n Hierarchy) -> Whole<'n> {
        let mut whole = Whole {
            netlist,
            hierarchy,
            root: vec![],
            flat: HashMap::new(),
            wire: HashMap::new(),
            pins: vec![],
            children: HashMap::new(),
            cells: HashMap::new(),
            signals: HashMap::new(),
            shared: HashMap::new(),
            seen: 0,
        };
        for (i, scope) in netlist.scopes().iter().enumerate() {
            if let Some(parent) = scope.parent {
                whole.children.entry((parent, scope.name.clone())).or_default().push(ScopeId::new(i));
            }
        }
        for id in netlist.cell_ids() {
            let cell = netlist.cell(id);
            whole.cells.entry((cell.scope, cell.name.clone())).or_default().push(id);
            if let CellKind::Resolve { width, .. } = cell.kind {
                let to = netlist.output(id, 0);
                for (at, bit) in bits(netlist.input(id, 0)).into_iter().enumerate() {
                    whole.shared.insert(bit, (to.0, at as u32 % width));
                }
            }
        }
        for id in netlist.signal_ids() {
            let signal = netlist.signal(id);
            whole.signals.entry((signal.scope, signal.name.clone())).or_default().push(id);
        }
        whole
    }

    fn find(&self, mut at: usize) -> usize {
        while self.root[at] != at {
            at = self.root[at];
        }
        at
    }

    fn canonical(&self, slices: &[Slice]) -> Vec<(u32, u32)> {
        bits(slices).into_iter().map(|b| *self.shared.get(&b).unwrap_or(&b)).collect()
    }

    fn instance(&mut self, module: usize, scope: ScopeId) -> Vec<Vec<usize>> {
        let module = &self.hierarchy.modules()[module];
        let wires: Vec<Vec<usize>> = module
            .wires
            .iter()
            .map(|w| {
                let from = self.root.len();
                self.root.extend(from..from + w.width as usize);
                (from..from + w.width as usize).collect()
            })
            .collect();
        let here = |pieces: &[Piece]| -> Vec<Bit> {
            pieces
                .iter()
                .flat_map(|p| match p {
                    Piece::Wire { wire, lo, width } => {
                        wires[*wire][*lo as usize..][..*width as usize].iter().map(|&w| Bit::Wire(w)).collect()
                    }
                    Piece::Constant(value) => (0..value.width()).map(|i| Bit::Constant(value.bit(i))).collect(),
                    Piece::Open(width) => vec![Bit::Open; *width as usize],
                })
                .collect()
        };
        // the scopes of this instance's blocks
        let mut blocks = vec![scope];
        for block in &module.blocks[1..] {
            let within = &self.children[&(blocks[block.parent.unwrap()], block.name.clone())];
            assert_eq!(within.len(), 1);
            blocks.push(within[0]);
        }
        let mut at: HashMap<(ScopeId, &str, bool), usize> = HashMap::new();
        let mut next = |scope: ScopeId, name: &'n str, signal: bool| {
            let n = at.entry((scope, name, signal)).or_default();
            *n += 1;
            *n - 1
        };
        for (wire, own) in module.wires.iter().zip(&wires) {
            for (&bit, shown) in own.iter().zip(here(&wire.bits)) {
                match shown {
                    Bit::Wire(other) => {
                        let (a, b) = (self.find(bit), self.find(other));
                        self.root[a] = b;
                    }
                    constant => self.pins.push((vec![constant], vec![])),
                }
            }
            let Some(signal) = wire.signal else { continue };
            let (block, name) = (blocks[wire.block], self.netlist.signal(signal).name.as_str());
            let id = self.signals[&(block, name.to_owned())][next(block, name, true)];
            let shown = self.canonical(self.netlist.bits(id));
            assert_eq!(shown.len(), own.len());
            let known = own
                .iter()
                .zip(here(&wire.bits))
                .map(|(&w, b)| if matches!(b, Bit::Wire(_)) { Bit::Wire(w) } else { b });
            self.pins.push((known.collect(), shown));
        }
        for cell in &module.cells {
            let (block, name) = (blocks[cell.block], self.netlist.cell(cell.id).name.as_str());
            let id = self.cells[&(block, name.to_owned())][next(block, name, false)];
            assert_eq!(self.netlist.cell(id).kind, self.netlist.cell(cell.id).kind);
            self.seen += 1;
            for (pin, pieces) in cell.inputs.iter().enumerate() {
                self.pins.push((here(pieces), self.canonical(self.netlist.input(id, pin))));
            }
            for (pin, pieces) in cell.outputs.iter().enumerate() {
                let net = self.netlist.output(id, pin);
                let all = Slice { net, lo: 0, width: self.netlist.net(net).width };
                self.pins.push((here(pieces), self.canonical(&[all])));
            }
        }
        for instance in &module.instances {
            let inner = self.children[&(blocks[instance.block], instance.name.clone())][0];
            let ports = self.instance(instance.module, inner);
            assert_eq!(ports.len(), instance.ports.len());
            for (port, pieces) in ports.iter().zip(&instance.ports) {
                for (&inside, outside) in port.iter().zip(here(pieces)) {
                    match outside {
                        Bit::Wire(outside) => {
                            let (a, b) = (self.find(inside), self.find(outside));
                            self.root[a] = b;
                        }
                        Bit::Constant(value) => {
                            let bit = self.constant_of(inside, value);
                            self.pins.push(bit);
                        }
                        Bit::Open => {}
                    }
                }
            }
        }
        wires[..module.ports().len()].to_vec()
    }

    /// A port that is tied from outside is the constant inside too: nothing else may drive it.
    fn constant_of(&self, _inside: usize, value: discreta::Logic) -> (Vec<Bit>, Vec<(u32, u32)>) {
        (vec![Bit::Constant(value)], vec![])
    }

    fn check(mut self) -> usize {
        self.instance(0, ScopeId(0));
        let cells = self.netlist.cell_ids().filter(|&c| {
            let cell = self.netlist.cell(c);
            !matches!(cell.kind, CellKind::Resolve { .. } | CellKind::Constant(_))
        });
        assert!(self.seen >= cells.count(), "cells are missing");
        let mut bits = 0;
        let mut literal: HashMap<usize, discreta::Logic> = HashMap::new();
        for (pieces, flat) in std::mem::take(&mut self.pins) {
            assert!(flat.is_empty() || flat.len() == pieces.len());
            for (piece, &(net, lo)) in pieces.iter().zip(&flat) {
                bits += 1;
                let constant = match self.netlist.net(NetId(net)).driver {
                    Driver::Cell(c, _) => match &self.netlist.cell(c).kind {
                        CellKind::Constant(value) => Some(value.bit(lo)),
                        _ => None,
                    },
                    Driver::Input(_) => None,
                };
                match piece {
                    Bit::Wire(wire) => {
                        let root = self.find(*wire);
                        if let Some(value) = constant {
                            assert_eq!(*literal.entry(root).or_insert(value), value);
                            continue;
                        }
                        assert_eq!(*self.flat.entry(root).or_insert((net, lo)), (net, lo), "two nets are one");
                        assert_eq!(*self.wire.entry((net, lo)).or_insert(root), root, "a net is in two parts");
                    }
                    Bit::Constant(value) => assert_eq!(
                        constant,
                        Some(*value),
                        "{pieces:?} {flat:?} {:?}",
                        flat.iter().map(|f| self.netlist.net_name(NetId(f.0))).collect::<Vec<_>>()
                    ),
                    Bit::Open => {}
                }
            }
        }
        assert!(literal.keys().all(|root| !self.flat.contains_key(root)), "a net is tied");
        bits
    }
}

fn bits(slices: &[Slice]) -> Vec<(u32, u32)> {
    slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|b| (s.net.0, b))).collect()
}

fn check(netlist: &Netlist) -> Hierarchy {
    let hierarchy = Hierarchy::of(netlist);
    assert!(Whole::new(netlist, &hierarchy).check() > 0);
    // a module comes after one that uses it, and names are unique
    let mut names = std::collections::HashSet::new();
    for (i, module) in hierarchy.modules().iter().enumerate() {
        assert!(names.insert(module.name.clone()), "{}", module.name);
        assert!(module.instances.iter().all(|x| x.module > i));
        let ports = module.ports().len();
        assert!(module.wires[ports..].iter().all(|w| w.port.is_none()));
    }
    hierarchy
}

fn circuits() -> Vec<std::path::PathBuf> {
    let mut found = vec![];
    for folder in ["evaluation", "dda", "feed", "quadrant", "three_axis"] {
        for entry in std::fs::read_dir(Path::new("circuits").join(folder)).unwrap() {
            found.push(entry.unwrap().path());
        }
    }
    found.sort();
    found
}

#[test]
fn every_circuit_is_what_its_modules_say() {
    let mut sizes = BTreeMap::new();
    for path in circuits() {
        let circuit = discreta::circuit::load(&path).unwrap();
        let hierarchy = check(&circuit.netlist);
        let origins: std::collections::HashSet<&str> = hierarchy.modules().iter().map(|m| m.origin.as_str()).collect();
        assert!(hierarchy.modules().iter().all(|m| m.wires.iter().all(|w| w.port.is_none() || !w.is_made())));
        sizes.insert(path, (origins.len(), hierarchy.modules().len()));
    }
    for (path, (origins, modules)) in sizes {
        println!("{}: {modules} modules of {origins}", path.display());
    }
}

#[test]
fn a_module_that_is_used_often_is_one() {
    let circuit = discreta::circuit::load("circuits/evaluation/line_gates.json").unwrap();
    let hierarchy = Hierarchy::of(&circuit.netlist);
    assert_eq!(hierarchy.modules().iter().filter(|m| m.origin == "full_adder_gates").count(), 1);
}
