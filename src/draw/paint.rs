//! The picture as SVG: what [`super`] promises to programs, and what people see.

use std::collections::HashMap;

use super::layout::{Placed, Spot};
use super::scene::{End, Net, Node, Pin, Shape, Side, What};
use super::symbol::{self, PinSpot, SLASH, STUB, shortened, text_width};
use super::wire::Lines;
use crate::netlist::hierarchy::Module;
use crate::netlist::{Direction, Netlist};
use crate::svg::{Svg, number};

/// Around the picture, and what the title takes.
const EDGE: f64 = 16.0;
const TITLE: f64 = 34.0;

/// Colours: first the plain ones for renderers that know no variables, then those that a page can set. The paper is
/// painted too, since a page may be dark where the system is not.
const STYLE: &str = "
    .schematic { color-scheme: light dark; --paper: #ffffff; --ink: #1f2328; --wire: #3d4650; --bus: #0860ca; --fill: #f6f8fa; --soft: #59636e; --accent: #9a4e00; }
    @media (prefers-color-scheme: dark) {
      .schematic { --paper: #0d1117; --ink: #f0f6fc; --wire: #b1bac4; --bus: #58a6ff; --fill: #161b22; --soft: #9198a1; --accent: #f0a33e; }
    }
    .schematic text { font-family: ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace; font-size: 10px; fill: #1f2328; fill: var(--ink); }
    .schematic .paper { fill: #ffffff; fill: var(--paper); }
    .schematic .heading { font-size: 14px; font-weight: 600; }
    .schematic .name, .schematic .at, .schematic .size { fill: #59636e; fill: var(--soft); }
    .schematic .size { font-size: 9px; }
    .schematic .header { font-size: 11px; font-weight: 600; }
    .schematic .sign { font-size: 16px; font-weight: 600; }
    .schematic .port-name { font-weight: 600; }
    .schematic .label { fill: #9a4e00; fill: var(--accent); }
    .schematic .value { fill: #0860ca; fill: var(--bus); }
    .schematic .body { fill: #f6f8fa; fill: var(--fill); stroke: #1f2328; stroke: var(--ink); stroke-width: 1.3; stroke-linejoin: round; }
    .schematic .open > .body { fill: none; stroke: #59636e; stroke: var(--soft); stroke-dasharray: 5 3; stroke-width: 1; }
    .schematic .bar > .body { fill: #1f2328; fill: var(--ink); stroke: none; }
    .schematic .detail { fill: none; stroke: #1f2328; stroke: var(--ink); stroke-width: 1.3; stroke-linejoin: round; }
    .schematic .bubble { fill: #ffffff; fill: var(--paper); stroke: #1f2328; stroke: var(--ink); stroke-width: 1.3; }
    .schematic .wire { fill: none; stroke: #3d4650; stroke: var(--wire); stroke-width: 1.2; stroke-linecap: round; }
    .schematic .dot { fill: #3d4650; fill: var(--wire); }
    .schematic .bus > .wire { stroke: #0860ca; stroke: var(--bus); stroke-width: 2; }
    .schematic .bus > .dot { fill: #0860ca; fill: var(--bus); }
    .schematic .slash { stroke: #0860ca; stroke: var(--bus); stroke-width: 1.2; }
  ";

struct Painter {
    svg: Svg,
    /// How often each `id` was given.
    ids: HashMap<String, u32>,
}

/// The SVG of a placed module.
pub(super) fn svg(netlist: &Netlist, module: &Module, placed: &Placed) -> String {
    let title = if module.name.is_empty() { "circuit" } else { &module.name };
    let text = title.chars().count() as f64 * 8.7;
    let [w, h] = [placed.size[0].max(text) + 2.0 * EDGE, placed.size[1] + 2.0 * EDGE + TITLE];
    let scope = netlist.scope_path(module.scope);
    let mut svg = Svg::new();
    let [width, height] = [w, h].map(number);
    let head = [
        ("xmlns", "http://www.w3.org/2000/svg"),
        ("class", "schematic"),
        ("viewBox", &format!("0 0 {width} {height}")),
        ("width", &width),
        ("height", &height),
        ("role", "img"),
        ("aria-labelledby", "schematic-title"),
        ("data-top", &netlist.scopes()[0].name),
        ("data-scope", &scope),
    ];
    svg.open("svg", &head);
    svg.text("title", &[("id", "schematic-title")], &format!("Schematic of {title}"));
    svg.style(STYLE);
    svg.rectangle("paper", [0.0, 0.0, w, h]);
    svg.label("heading", [EDGE, 26.0], "start", title);
    let mut painter = Painter { svg, ids: HashMap::new() };
    let prefix = if scope.is_empty() { String::new() } else { format!("{scope}.") };
    painter.body(placed, [EDGE, EDGE + TITLE], &prefix);
    painter.svg.finish()
}

/// How long the wire is between a pin and the text beside it.
fn stub_length(node: &Node, pin: &Pin) -> f64 {
    let bubble = if pin.clock == Some(true) { 8.0 } else { 0.0 };
    // a join has the number of the bits on the wire
    let tap = if node.shape == Shape::Join { text_width(&pin.text) + 2.0 } else { 0.0 };
    STUB + bubble + tap
}

fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

impl Painter {
    fn id(&mut self, id: String) -> String {
        let count = self.ids.entry(id.clone()).or_default();
        *count += 1;
        if *count == 1 { id } else { format!("{id}~{count}") }
    }

    /// What is in a module: the opened instances first, so that nothing lies beneath them.
    fn body(&mut self, placed: &Placed, at: [f64; 2], prefix: &str) {
        for (node, spot) in placed.scene.nodes.iter().zip(&placed.nodes) {
            if let Some(inner) = &spot.inner {
                self.node(node, spot, at, prefix);
                let corner = plus(plus(at, spot.at), [spot.extent.left, symbol::HEAD]);
                self.body(inner, corner, &format!("{prefix}{}.", node.name));
            }
        }
        for net in 0..placed.scene.nets.len() {
            self.net(placed, net, at, prefix);
        }
        for (node, spot) in placed.scene.nodes.iter().zip(&placed.nodes).filter(|(_, s)| s.inner.is_none()) {
            self.node(node, spot, at, prefix);
        }
    }

    fn node(&mut self, node: &Node, spot: &Spot, at: [f64; 2], prefix: &str) {
        let corner = plus(plus(at, spot.at), [spot.extent.left, spot.extent.top]);
        let size = [spot.extent.width, spot.extent.height];
        let path = format!("{prefix}{}", node.name);
        match &node.what {
            What::Cell(kind) => {
                let id = self.id(format!("cell:{path}"));
                self.svg.open("g", &[("class", "cell"), ("id", &id), ("data-cell", &path), ("data-kind", kind)]);
            }
            What::Instance(module, _) => {
                let id = self.id(format!("cell:{path}"));
                let class = if spot.inner.is_some() { "instance open" } else { "instance" };
                self.svg.open("g", &[("class", class), ("id", &id), ("data-cell", &path), ("data-module", module)]);
            }
            What::Port => {
                let id = self.id(format!("port:{path}"));
                let way = match node.shape {
                    Shape::Port(Direction::Input) => "input",
                    Shape::Port(Direction::Output) => "output",
                    _ => "inout",
                };
                let mut all = vec![("class", "port"), ("id", &id), ("data-port", &path), ("data-direction", way)];
                all.push(("data-net", &path));
                self.svg.open("g", &all);
            }
            What::Bar(kind) => self.svg.open("g", &[("class", "bar"), ("data-kind", kind)]),
        }
        let title = match &node.what {
            What::Bar(_) => node.title.clone(),
            _ => format!("{prefix}{}", node.title),
        };
        self.svg.text("title", &[], &title);
        let outline = symbol::outline(node.shape, corner, size);
        self.svg.leaf("path", &[("class", "body"), ("d", &outline)]);
        let bodies: Vec<[f64; 2]> = spot.pins.iter().map(|p| plus(p.body, at)).collect();
        let details = symbol::details(node, corner, size, &bodies);
        if !details.is_empty() {
            self.svg.leaf("path", &[("class", "detail"), ("d", &details)]);
        }
        self.words(node, corner, size);
        for (pin, &body) in node.pins.iter().zip(&bodies) {
            self.pin(node, pin, body);
        }
        self.svg.close();
    }

    /// What is written in and above a symbol.
    fn words(&mut self, node: &Node, [x, y]: [f64; 2], [w, h]: [f64; 2]) {
        let header = shortened(&node.header);
        match node.shape {
            Shape::Block => self.svg.label("header", [x + w / 2.0, y + 13.0], "middle", &header),
            Shape::Sign => self.svg.label("sign", [x + w / 2.0, y + h / 2.0 + 5.5], "middle", &header),
            Shape::Port(_) => {
                let middle = x + w / 2.0 - 4.0 * f64::from(node.shape != Shape::Port(Direction::Inout));
                self.svg.label("port-name", [middle, y + 13.5], "middle", &header);
            }
            Shape::Frame => {
                let text = format!("{} : {}", node.name, node.header);
                self.svg.label("name", [x + 8.0, y + 12.5], "start", &shortened(&text));
            }
            _ => {}
        }
        if !node.name.is_empty() && !matches!(node.what, What::Port) && node.shape != Shape::Frame {
            self.svg.label("name", [x, y - 4.0], "start", &shortened(&node.name));
        }
    }

    fn pin(&mut self, node: &Node, pin: &Pin, [x, y]: [f64; 2]) {
        let at = format!("{} {}", number(x), number(y));
        self.svg.open("g", &[("class", "pin"), ("data-pin", &pin.name), ("data-at", &at)]);
        let plain = node.shape == Shape::Sign && node.pins.len() <= 2;
        let written =
            matches!(node.shape, Shape::Block | Shape::Mux | Shape::Demux) || node.shape == Shape::Sign && !plain;
        let text = shortened(&pin.text);
        match pin.side {
            Side::West if written => {
                let clock = if pin.clock.is_some() { 8.0 } else { 0.0 };
                self.svg.label("at", [x + 4.0 + clock, y + 3.5], "start", &text);
            }
            Side::East if written && !matches!(node.shape, Shape::Mux) => {
                self.svg.label("at", [x - 4.0, y + 3.5], "end", &text);
            }
            Side::West if node.shape == Shape::Join => {
                self.svg.label("at", [x - 4.0, y - 3.0], "end", &text);
            }
            _ => {}
        }
        if let End::Constant(text, width) = &pin.end {
            self.svg.open("g", &[("class", "net"), ("data-constant", text), ("data-width", &width.to_string())]);
            self.stub(pin.side, [x, y], stub_length(node, pin), "at", text);
            self.svg.close();
        }
        // a bubble is part of the symbol, on the wire's side
        if pin.clock == Some(true) {
            self.svg.circle("bubble", [x - 3.5, y], 3.5);
        }
        if node.inverts && !pin.reads {
            self.svg.circle("bubble", [x + 3.5, y], 3.5);
        }
        self.svg.close();
    }

    /// A short wire to a pin with a text at its end.
    fn stub(&mut self, side: Side, [x, y]: [f64; 2], length: f64, class: &str, text: &str) {
        let text = shortened(text);
        let path = match side {
            Side::West => format!("M{} {}H{}", number(x - length), number(y), number(x)),
            Side::South => format!("M{} {}V{}", number(x), number(y), number(y + length)),
            Side::East => format!("M{} {}H{}", number(x), number(y), number(x + text_width(&text) + 14.0)),
        };
        self.svg.leaf("path", &[("class", "wire"), ("d", &path)]);
        match side {
            Side::West => self.svg.label(class, [x - length - 2.0, y + 3.5], "end", &text),
            Side::South => self.svg.label(class, [x, y + length + 10.0], "middle", &text),
            Side::East => self.svg.label(class, [x + 10.0, y - 3.0], "start", &text),
        }
    }

    fn net(&mut self, placed: &Placed, index: usize, at: [f64; 2], prefix: &str) {
        let net = &placed.scene.nets[index];
        let path = net.name.as_ref().map(|name| format!("{prefix}{name}"));
        let driver = format!("{prefix}{}", net.driver);
        let label = format!("{}{}", path.as_ref().unwrap_or(&driver), net.bits());
        let id = self.id(format!("net:{label}"));
        let bits = match net.width {
            1 => net.lo.to_string(),
            width => format!("{}:{}", net.lo + width - 1, net.lo),
        };
        let width = net.width.to_string();
        let class = if net.width > 1 { "net bus" } else { "net" };
        let mut all = vec![("class", class), ("id", id.as_str())];
        all.push(if let Some(path) = &path { ("data-net", path) } else { ("data-driver", &driver) });
        all.extend([("data-bits", bits.as_str()), ("data-width", width.as_str())]);
        self.svg.open("g", &all);
        let of = if path.is_some() { format!(", from {driver}") } else { String::new() };
        let size = if net.width > 1 { format!(", {} bits", net.width) } else { String::new() };
        self.svg.text("title", &[], &format!("{label}{size}{of}"));
        let moved = |p: [f64; 2]| plus(p, at);
        let pieces: Vec<_> = placed.wires[index].iter().map(|p| p.map(moved)).collect();
        let lines = Lines::of(&pieces);
        if !pieces.is_empty() {
            self.svg.leaf("path", &[("class", "wire"), ("d", &lines.path())]);
        }
        for &dot in &lines.dots {
            self.svg.circle("dot", dot, if net.width > 1 { 3.0 } else { 2.5 });
        }
        for (i, &(n, p)) in net.drivers.iter().enumerate() {
            self.driver(placed, net, (n, p), at, i == 0);
        }
        if net.labelled {
            for &(n, p) in &net.readers {
                let (node, pin) = (&placed.scene.nodes[n], &placed.scene.nodes[n].pins[p]);
                let [x, y] = moved(placed.nodes[n].pins[p].body);
                match &node.what {
                    // the port has the name written in it
                    What::Port => {}
                    _ => self.stub(pin.side, [x, y], stub_length(node, pin), "label", &net.label().unwrap_or_default()),
                }
            }
        }
        self.svg.close();
    }

    /// What is written where a net comes from.
    fn driver(&mut self, placed: &Placed, net: &Net, (n, p): (usize, usize), at: [f64; 2], first: bool) {
        let (node, pin) = (&placed.scene.nodes[n], &placed.scene.nodes[n].pins[p]);
        let spot = placed.nodes[n].pins[p];
        let spot_body = plus(spot.body, at);
        let [mut x, y] = spot_body;
        if node.inverts {
            x += 7.0;
        }
        let text = symbol::on_wire(&placed.scene, node, pin);
        if net.labelled && !matches!(node.what, What::Port) {
            self.stub(Side::East, spot_body, STUB, "label", &text.clone().unwrap_or_default());
        }
        if pin.side != Side::East {
            return;
        }
        let mut from = x + 3.0;
        if symbol::has_slash(node, net) {
            let slash = format!("M{} {}L{} {}", number(x + 4.0), number(y + 4.5), number(x + 9.0), number(y - 4.5));
            self.svg.leaf("path", &[("class", "slash"), ("d", &slash)]);
            let size = net.width.to_string();
            self.svg.label("size", [x + SLASH + 1.0, y - 3.5], "start", &size);
            from = x + SLASH + text_width(&size) + 4.0;
        }
        if let (Some(text), false) = (text, net.labelled) {
            let class = if node.shape == Shape::Split { "at" } else { "on" };
            self.svg.label(class, [from, y - 3.5], "start", &shortened(&text));
            from += text_width(&text) + 4.0;
        }
        if first {
            // below the wire, but behind its name where the next pin's name stands below
            let below =
                |p: &PinSpot| p.body[0] == spot.body[0] && (1.0..20.0).contains(&(p.body[1] - spot.body[1]).abs());
            let crowded = placed.nodes[n].pins.iter().any(below);
            let [vx, vy] = if crowded { [from, y - 3.0] } else { [x + 4.0, y + 10.5] }.map(number);
            self.svg.text("text", &[("class", "value"), ("x", &vx), ("y", &vy)], "");
        }
    }
}
