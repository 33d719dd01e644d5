//! From a module's body to nodes and nets: its ports, cells and instances, and bars where bits are put together or taken
//! apart.

use std::collections::HashMap;

use super::scene::{End, Net, Node, Pin, Scene, Shape, Side, What, range};
use super::{array, pins};
use crate::cell::Edge;
use crate::netlist::hierarchy::{Hierarchy, Module, Piece};
use crate::netlist::{Direction, Netlist};

/// A net of one bit that at least so many read is drawn by its name, and a clock if so many are clocked by it.
const MANY: usize = 7;
const CLOCKED: usize = 3;

type At = (usize, usize);

/// Bits of a wire that a pin drives.
struct Source {
    lo: u32,
    width: u32,
    net: usize,
    split: Option<usize>,
}

struct Build<'a> {
    module: &'a Module,
    scene: Scene,
    /// What drives each wire, from the lowest bit up.
    sources: Vec<Vec<Source>>,
    /// Nets that carry bits which were taken apart.
    taps: HashMap<(usize, u32, u32), usize>,
    /// Nets that carry bits which were put together.
    joins: HashMap<String, usize>,
}

/// The scene of a module.
pub(super) fn scene(netlist: &Netlist, hierarchy: &Hierarchy, clocks: &[Vec<Option<bool>>], at: usize) -> Scene {
    let module = &hierarchy.modules()[at];
    let sources = module.wires.iter().map(|_| Vec::new()).collect();
    let scene = Scene::default();
    let mut build = Build { module, scene, sources, taps: HashMap::new(), joins: HashMap::new() };
    let (mut drives, mut reads) = (Vec::new(), Vec::new());
    let mut add = |build: &mut Build<'_>, (node, ends): pins::Drawn| {
        let n = build.scene.nodes.len();
        for (p, (pin, pieces)) in node.pins.iter().zip(ends).enumerate() {
            if pin.reads { &mut reads } else { &mut drives }.push(((n, p), pieces));
        }
        build.scene.nodes.push(node);
    };
    let driven = driven(module);
    for (w, port) in module.ports().iter().enumerate() {
        let way = port.port.unwrap_or(Direction::Inout);
        // one that the module drives too is drawn where that leads
        let inwards = way == Direction::Input || way == Direction::Inout && !driven[w];
        let bits = if inwards { vec![Piece::Wire { wire: w, lo: 0, width: port.width }] } else { port.bits.clone() };
        add(&mut build, (port_node(&port.name, port.width, way, inwards), vec![bits]));
    }
    for cell in array::cells(netlist, module) {
        add(&mut build, cell);
    }
    for instance in &module.instances {
        let of = &hierarchy.modules()[instance.module];
        let name = format!("{}{}", module.prefix(instance.block), instance.name);
        add(&mut build, (instance_node(name, instance.module, of, &clocks[instance.module]), instance.ports.clone()));
    }
    build.drive(drives);
    for (at, pieces) in reads {
        build.read(at, &pieces);
    }
    build.finish()
}

/// Which wires are driven from within.
fn driven(module: &Module) -> Vec<bool> {
    let mut driven = vec![false; module.wires.len()];
    let outputs = module.cells.iter().flat_map(|c| c.outputs.iter().flatten());
    for piece in outputs.chain(module.instances.iter().flat_map(|i| i.ports.iter().flatten())) {
        if let Piece::Wire { wire, .. } = piece {
            driven[*wire] = true;
        }
    }
    driven
}

fn pin(name: &str, side: Side, reads: bool) -> Pin {
    Pin { name: name.to_owned(), text: name.to_owned(), side, reads, clock: None, end: End::Open }
}

fn port_node(name: &str, width: u32, way: Direction, inwards: bool) -> Node {
    let side = if inwards { Side::East } else { Side::West };
    let word = match way {
        Direction::Input => "input",
        Direction::Output => "output",
        Direction::Inout => "inout",
    };
    let bits = if width == 1 { String::new() } else { format!(", {width} bits") };
    Node {
        what: What::Port,
        shape: Shape::Port(way),
        name: name.to_owned(),
        header: name.to_owned(),
        title: format!("{name}: {word}{bits}"),
        inverts: false,
        ordered: true,
        stores: false,
        pins: vec![pin(name, side, !inwards)],
    }
}

/// Which ports of each module clock something in it; true at falling edges.
pub(super) fn clocks(netlist: &Netlist, hierarchy: &Hierarchy) -> Vec<Vec<Option<bool>>> {
    let modules = hierarchy.modules();
    let mut clocks: Vec<Vec<Option<bool>>> = modules.iter().map(|m| vec![None; m.ports().len()]).collect();
    // a module comes before those that it has instances of
    for (m, module) in modules.iter().enumerate().rev() {
        let mut found = Vec::new();
        for cell in &module.cells {
            let kind = &netlist.cell(cell.id).kind;
            for (pin, pieces) in cell.inputs.iter().enumerate() {
                if let ([Piece::Wire { wire, width: 1, .. }], Some(edge)) = (&pieces[..], kind.edge_at(pin, 0)) {
                    found.push((*wire, edge == Edge::Falling));
                }
            }
        }
        for instance in &module.instances {
            for (pieces, clock) in instance.ports.iter().zip(&clocks[instance.module]) {
                if let ([Piece::Wire { wire, width: 1, .. }], Some(falling)) = (&pieces[..], clock) {
                    found.push((*wire, *falling));
                }
            }
        }
        for (wire, falling) in found {
            let is_input = module.wires[wire].port == Some(Direction::Input) && module.wires[wire].width == 1;
            if is_input {
                clocks[m][wire].get_or_insert(falling);
            }
        }
    }
    clocks
}

fn instance_node(name: String, module: usize, of: &Module, clocks: &[Option<bool>]) -> Node {
    let pins = of.ports().iter().zip(clocks).map(|(port, &clock)| {
        let text = &port.name;
        match port.port {
            Some(Direction::Input) => Pin { clock, ..pin(text, Side::West, true) },
            _ => pin(text, Side::East, false),
        }
    });
    Node {
        shape: Shape::Block,
        header: of.origin.clone(),
        title: format!("{name}: {}", of.name),
        name,
        what: What::Instance(of.name.clone(), module),
        inverts: false,
        ordered: false,
        stores: false,
        pins: pins.collect(),
    }
}

fn bar(kind: &'static str, shape: Shape, title: String, pins: Vec<Pin>) -> Node {
    Node {
        what: What::Bar(kind),
        shape,
        name: String::new(),
        header: String::new(),
        title,
        inverts: false,
        ordered: true,
        stores: false,
        pins,
    }
}

impl Build<'_> {
    fn driver_of(&self, (node, pin): At) -> String {
        let node = &self.scene.nodes[node];
        match node.what {
            What::Port => node.name.clone(),
            _ => format!("{}.{}", node.name, node.pins[pin].name),
        }
    }

    fn net(&mut self, by: At, name: Option<String>, lo: u32, width: u32, whole: u32) -> usize {
        let net = self.scene.nets.len();
        let driver = self.driver_of(by);
        self.scene.nets.push(Net {
            name,
            driver,
            lo,
            width,
            whole,
            drivers: Vec::new(),
            readers: Vec::new(),
            labelled: false,
        });
        self.driven_by(net, by);
        net
    }

    fn driven_by(&mut self, net: usize, (node, pin): At) {
        self.scene.nets[net].drivers.push((node, pin));
        self.scene.nodes[node].pins[pin].end = End::Net(net);
    }

    fn read_by(&mut self, net: usize, (node, pin): At) {
        self.scene.nets[net].readers.push((node, pin));
        self.scene.nodes[node].pins[pin].end = End::Net(net);
    }

    /// A net of some bits of a wire.
    fn net_of(&mut self, by: At, wire: usize, lo: u32, width: u32) -> usize {
        let of = &self.module.wires[wire];
        let name = (!of.is_made()).then(|| format!("{}{}", self.module.prefix(of.block), of.name));
        let whole = of.width;
        self.net(by, name, lo, width, whole)
    }

    /// Where the bits of each wire come from.
    fn drive(&mut self, drives: Vec<(At, Vec<Piece>)>) {
        // where several drive some bits together, their parts are to be the same
        let mut ranges: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.module.wires.len()];
        for piece in drives.iter().flat_map(|d| &d.1) {
            if let Piece::Wire { wire, lo, width } = piece {
                ranges[*wire].push((*lo, lo + width));
            }
        }
        let cuts = ranges.into_iter().map(|mut ranges| {
            ranges.sort_unstable();
            ranges.dedup();
            if ranges.windows(2).all(|r| r[0].1 <= r[1].0) {
                return Vec::new();
            }
            let mut cuts: Vec<u32> = ranges.iter().flat_map(|r| [r.0, r.1]).collect();
            cuts.sort_unstable();
            cuts.dedup();
            cuts
        });
        let cuts: Vec<Vec<u32>> = cuts.collect();
        for (at, pieces) in drives {
            let mut parts = Vec::new();
            let mut bit = 0;
            for piece in &pieces {
                if let Piece::Wire { wire, lo, width } = *piece {
                    let inner = cuts[wire].iter().copied().filter(|c| (lo + 1..lo + width).contains(c));
                    let mut from = lo;
                    for to in inner.chain([lo + width]) {
                        parts.push((bit + from - lo, wire, from, to - from));
                        from = to;
                    }
                }
                bit += piece.width();
            }
            match parts[..] {
                [] => {}
                [(_, wire, lo, width)] if width == bit => self.source(at, wire, lo, width),
                _ => {
                    let whole = self.net(at, None, 0, bit, bit);
                    let mut pins = vec![pin("in", Side::West, true)];
                    // the highest bits on top
                    for &(at, _, _, width) in parts.iter().rev() {
                        pins.push(pin(&range(at, width), Side::East, false));
                    }
                    let title = format!("{} taken apart", self.scene.nets[whole].driver);
                    self.scene.nodes.push(bar("split", Shape::Split, title, pins));
                    let node = self.scene.nodes.len() - 1;
                    self.read_by(whole, (node, 0));
                    for (pin, &(_, wire, lo, width)) in parts.iter().rev().enumerate() {
                        self.source((node, pin + 1), wire, lo, width);
                    }
                }
            }
        }
        for sources in &mut self.sources {
            sources.sort_by_key(|s| s.lo);
        }
    }

    fn source(&mut self, at: At, wire: usize, lo: u32, width: u32) {
        match self.sources[wire].iter().find(|s| s.lo == lo && s.width == width) {
            Some(source) => self.driven_by(source.net, at),
            None => {
                let net = self.net_of(at, wire, lo, width);
                self.sources[wire].push(Source { lo, width, net, split: None });
            }
        }
    }

    /// Connects a pin that reads these bits.
    fn read(&mut self, at: At, pieces: &[Piece]) {
        let end = match pieces {
            [] | [Piece::Open(_)] => End::Open,
            [Piece::Constant(value)] => End::Constant(pins::constant(value), value.width()),
            [Piece::Wire { wire, lo, width }] => self.want(*wire, *lo, *width).map_or(End::Open, End::Net),
            several => self.join(several, None).map_or(End::Open, End::Net),
        };
        match end {
            End::Net(net) => self.read_by(net, at),
            end => self.scene.nodes[at.0].pins[at.1].end = end,
        }
    }

    /// The net that carries these bits of a wire; none if nothing drives them.
    fn want(&mut self, wire: usize, lo: u32, width: u32) -> Option<usize> {
        let end = lo + width;
        let over: Vec<usize> = (0..self.sources[wire].len())
            .filter(|&s| {
                let s = &self.sources[wire][s];
                s.lo < end && lo < s.lo + s.width
            })
            .collect();
        if let [one] = over[..] {
            let source = &self.sources[wire][one];
            if (source.lo, source.width) == (lo, width) {
                return Some(source.net);
            }
            if source.lo <= lo && end <= source.lo + source.width {
                return Some(self.tap(wire, one, lo, width));
            }
        }
        let (&first, _) = over.split_first()?;
        let mut parts = Vec::new();
        let mut at = lo;
        for s in first..first + over.len() {
            let source = &self.sources[wire][s];
            let (from, to) = (source.lo.max(lo), end.min(source.lo + source.width));
            if from > at {
                parts.push(Piece::Open(from - at));
            }
            parts.push(Piece::Wire { wire, lo: from, width: to - from });
            at = to;
        }
        if at < end {
            parts.push(Piece::Open(end - at));
        }
        self.join(&parts, Some((wire, lo, width)))
    }

    /// Some bits of what one pin drives.
    fn tap(&mut self, wire: usize, source: usize, lo: u32, width: u32) -> usize {
        if let Some(&net) = self.taps.get(&(wire, lo, width)) {
            return net;
        }
        let of = &self.sources[wire][source];
        let (from, split) = (of.net, of.split);
        let node = split.unwrap_or_else(|| {
            let net = &self.scene.nets[from];
            let title = format!("{} taken apart", net.label().unwrap_or_else(|| net.driver.clone()));
            self.scene.nodes.push(bar("split", Shape::Split, title, vec![pin("in", Side::West, true)]));
            let node = self.scene.nodes.len() - 1;
            self.read_by(from, (node, 0));
            self.sources[wire][source].split = Some(node);
            node
        });
        // by the bits of the wire, as it is read
        self.scene.nodes[node].pins.push(pin(&range(lo, width), Side::East, false));
        let at = (node, self.scene.nodes[node].pins.len() - 1);
        let net = self.net_of(at, wire, lo, width);
        self.scene.nets[net].driver = self.scene.nets[from].driver.clone();
        self.taps.insert((wire, lo, width), net);
        net
    }

    /// Bits put together, the lowest first: those of a wire, or only what one pin reads.
    fn join(&mut self, pieces: &[Piece], of: Option<(usize, u32, u32)>) -> Option<usize> {
        let key = format!("{pieces:?}");
        if let Some(&net) = self.joins.get(&key) {
            return Some(net);
        }
        let total: u32 = pieces.iter().map(Piece::width).sum();
        // one piece again and again goes in once
        let mut runs: Vec<(u32, &Piece, u32)> = Vec::new();
        let mut at = 0;
        for piece in pieces {
            match runs.last_mut() {
                Some((_, last, times)) if *last == piece && !matches!(piece, Piece::Open(_)) => *times += 1,
                _ => runs.push((at, piece, 1)),
            }
            at += piece.width();
        }
        let repeat = matches!(runs[..], [(_, Piece::Wire { .. }, 2..)]);
        let mut pins = Vec::new();
        let mut inputs = Vec::new();
        for &(lo, piece, times) in runs.iter().rev().filter(|r| !matches!(r.1, Piece::Open(_))) {
            let mut one = pin(&range(lo, piece.width() * times), Side::West, true);
            if repeat {
                one.text = format!("×{times}");
            } else if times > 1 {
                one.text = format!("{} ×{times}", one.text);
            }
            pins.push(one);
            inputs.push(piece.clone());
        }
        if pins.is_empty() {
            return None;
        }
        pins.push(pin("out", Side::East, false));
        let title = if repeat { "one repeated" } else { "bits put together" };
        let kind = if repeat { "repeat" } else { "join" };
        self.scene.nodes.push(bar(kind, Shape::Join, title.to_owned(), pins));
        let node = self.scene.nodes.len() - 1;
        let out = (node, inputs.len());
        let net = match of {
            Some((wire, lo, width)) => self.net_of(out, wire, lo, width),
            None => self.net(out, None, 0, total, total),
        };
        self.joins.insert(key, net);
        for (pin, piece) in inputs.iter().enumerate() {
            self.read((node, pin), std::slice::from_ref(piece));
        }
        Some(net)
    }

    fn finish(mut self) -> Scene {
        let scene = &mut self.scene;
        for node in scene.nodes.iter_mut().filter(|n| n.shape == Shape::Split) {
            sort_taps(node);
        }
        // the pins of splits have moved
        for net in &mut scene.nets {
            net.drivers.retain(|d| scene.nodes[d.0].shape != Shape::Split);
        }
        for (n, node) in scene.nodes.iter().enumerate().filter(|(_, n)| n.shape == Shape::Split) {
            for (p, pin) in node.pins.iter().enumerate().skip(1) {
                if let End::Net(net) = pin.end {
                    scene.nets[net].drivers.push((n, p));
                }
            }
        }
        for net in &mut scene.nets {
            let pin = |&(n, p): &At| &scene.nodes[n].pins[p];
            let clocked = net.readers.iter().filter(|r| pin(r).clock.is_some()).count();
            let single = net.width == 1 && net.drivers.iter().all(|d| scene.nodes[d.0].shape != Shape::Split);
            let many = single && (net.readers.len() >= MANY || clocked >= CLOCKED);
            net.labelled = net.name.is_some() && (many || net.drivers.len() > 1 && net.readers.is_empty());
        }
        self.scene
    }
}

/// Puts the taps of a split in order, the highest bits on top.
fn sort_taps(node: &mut Node) {
    let key = |pin: &Pin| {
        let numbers = pin.name.trim_matches(['[', ']']);
        let (hi, lo) = numbers.split_once(':').unwrap_or((numbers, numbers));
        (hi.parse().unwrap_or(0u32), lo.parse().unwrap_or(0u32))
    };
    node.pins[1..].sort_by_key(|pin| std::cmp::Reverse(key(pin)));
}
