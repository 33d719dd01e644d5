//! How large a node is, where its pins are, and the outline of its symbol.
//!
//! Around the symbol's body a node has margins: on the left what is written at its inputs (constants, names of nets that
//! are drawn by name), on the right what is written on its outputs, above its name. So all text has room of its own,
//! whatever else is placed.

use super::scene::{End, Net, Node, Pin, Scene, Shape, Side, What};
use crate::svg::number;

/// The width of a character of 10 pixels, and of one of a header's 11; the fonts are all 0.6 em wide.
pub(super) const CHARACTER: f64 = 6.05;
const HEADER: f64 = 6.65;
/// From one pin to the next.
const PITCH: f64 = 16.0;
const BAR_PITCH: f64 = 14.0;
/// The row of a block's header.
pub(super) const HEAD: f64 = 18.0;
/// The longest text that is written; what is longer is in the titles.
pub(super) const LONGEST: usize = 24;
/// The stub of wire beside a text at a pin.
pub(super) const STUB: f64 = 10.0;
/// What the slash of a bus takes.
pub(super) const SLASH: f64 = 9.0;

/// Margins and body.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Extent {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub width: f64,
    pub height: f64,
}

impl Extent {
    pub fn size(&self) -> [f64; 2] {
        [(self.left + self.width + self.right).ceil(), (self.top + self.height + self.bottom).ceil()]
    }
}

/// A pin: where wires end, and where the symbol begins.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct PinSpot {
    pub outer: [f64; 2],
    pub body: [f64; 2],
}

/// A text as it is written.
pub(super) fn shortened(text: &str) -> String {
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    // the end of a path says more than its beginning
    let tail: Vec<char> = text.chars().rev().take(LONGEST - 1).collect();
    format!("…{}", tail.into_iter().rev().collect::<String>())
}

pub(super) fn text_width(text: &str) -> f64 {
    (shortened(text).chars().count() as f64 * CHARACTER).ceil()
}

/// What is written on the wire at an output.
pub(super) fn on_wire(scene: &Scene, node: &Node, pin: &Pin) -> Option<String> {
    let End::Net(net) = pin.end else { return None };
    let net = &scene.nets[net];
    match (&node.what, node.shape) {
        (What::Port, _) => None,
        (_, Shape::Split) => Some(pin.text.clone()),
        (What::Instance(..), _) if !net.labelled && net.label().is_some_and(|name| name == pin.text) => None,
        _ => {
            let at_port = |&(n, _): &(usize, usize)| {
                matches!(scene.nodes[n].what, What::Port) && Some(&scene.nodes[n].name) == net.name.as_ref()
            };
            let known = !net.labelled && (net.readers.iter().any(at_port) || net.name.as_ref() == Some(&node.name));
            if known { None } else { net.label() }
        }
    }
}

/// Whether a slash and a number tell the width at an output.
pub(super) fn has_slash(node: &Node, net: &Net) -> bool {
    net.width > 1 && !net.labelled && node.shape != Shape::Split
}

/// What is written beside an input: a constant, or a name in place of a wire.
pub(super) fn at_input(scene: &Scene, node: &Node, pin: &Pin) -> Option<String> {
    match &pin.end {
        End::Constant(text, _) => Some(text.clone()),
        End::Net(net) if scene.nets[*net].labelled && !matches!(node.what, What::Port) => scene.nets[*net].label(),
        _ => None,
    }
}

/// The margins and the size of a node; `inner` is what an opened instance holds, `port` the width of ports.
pub(super) fn extent(scene: &Scene, node: &Node, inner: Option<[f64; 2]>, port: f64) -> Extent {
    let on = |side: Side| node.pins.iter().filter(move |p| p.side == side);
    let (west, east) = (on(Side::West).count() as f64, on(Side::East).count() as f64);
    let most = west.max(east).max(1.0);
    let widest = |side: Side| on(side).map(|p| text_width(&p.text)).fold(0.0, f64::max);
    let [width, height] = match node.shape {
        Shape::And | Shape::Or | Shape::Xor => [40.0, if west <= 2.0 { 32.0 } else { 12.0 * west + 4.0 }],
        Shape::Triangle | Shape::Tristate => [24.0, 24.0],
        Shape::Mux => [28.0, PITCH * west + PITCH],
        Shape::Demux => [28.0, PITCH * east + PITCH],
        Shape::Join | Shape::Split => [4.0, BAR_PITCH * most + 4.0],
        Shape::Port(_) => [port, 20.0],
        Shape::Sign => {
            let sign = node.header.chars().count() as f64 * 10.0;
            let plain = west + east <= 2.0;
            let sides = if plain { 0.0 } else { widest(Side::West) + widest(Side::East) };
            [(sides + sign + 22.0).max(36.0), (PITCH * most + 8.0).max(36.0)]
        }
        Shape::Block => {
            let head = shortened(&node.header).chars().count() as f64 * HEADER + 12.0;
            let clock = if on(Side::West).any(|p| p.clock.is_some()) { 8.0 } else { 0.0 };
            let sides = widest(Side::West) + widest(Side::East) + clock + 22.0;
            [head.max(sides).max(44.0).ceil(), HEAD + PITCH * most + 4.0]
        }
        Shape::Frame => {
            let [w, h] = inner.unwrap_or_default();
            let head = text_width(&format!("{} : {}", node.name, node.header)) + 16.0;
            [w.max(head).ceil(), (h + HEAD + 10.0).ceil()]
        }
    };
    let left = on(Side::West).map(|p| {
        let text = at_input(scene, node, p).map_or(0.0, |t| text_width(&t) + STUB + 4.0);
        let bubble = if p.clock == Some(true) { 8.0 } else { 0.0 };
        let tap = if node.shape == Shape::Join { text_width(&p.text) + 8.0 } else { 0.0 };
        text + bubble + tap
    });
    let right = on(Side::East).map(|p| {
        let bubble = if node.inverts { 8.0 } else { 0.0 };
        let text = on_wire(scene, node, p).map_or(0.0, |t| text_width(&t) + 8.0);
        let slash = match p.end {
            End::Net(net) if has_slash(node, &scene.nets[net]) => {
                SLASH + text_width(&scene.nets[net].width.to_string()) + 3.0
            }
            _ => 0.0,
        };
        bubble + text + slash
    });
    let (left, mut right) = (left.fold(0.0, f64::max), right.fold(0.0, f64::max));
    if matches!(node.what, What::Port) && on(Side::East).count() > 0 {
        // as wide as those that have a number, so that all begin at one line
        right = SLASH + text_width("000") + 3.0;
    }
    let is_named = !node.name.is_empty() && !matches!(node.what, What::Port) && node.shape != Shape::Frame;
    let name = if is_named { text_width(&node.name) } else { 0.0 };
    let below = on(Side::South).map(|p| if at_input(scene, node, p).is_some() { 22.0 } else { 0.0 });
    Extent {
        left,
        // the name may be wider than the body
        right: right.max((name - width).max(0.0).ceil()),
        top: if is_named { 13.0 } else { 0.0 },
        bottom: below.fold(0.0, f64::max),
        width,
        height,
    }
}

/// Where the pins are, those of each side in the given order; relative to the node's corner.
pub(super) fn pins(node: &Node, extent: &Extent, rank: &[usize]) -> Vec<PinSpot> {
    let mut spots = vec![PinSpot::default(); node.pins.len()];
    let [outer_width, outer_height] = extent.size();
    for side in [Side::West, Side::East, Side::South] {
        let mut on: Vec<usize> = (0..node.pins.len()).filter(|&p| node.pins[p].side == side).collect();
        on.sort_by_key(|&p| rank[p]);
        let count = on.len() as f64;
        for (i, &p) in on.iter().enumerate() {
            let i = i as f64;
            let (h, w) = (extent.height, extent.width);
            let centred = |pitch: f64| h / 2.0 + pitch * (i - (count - 1.0) / 2.0);
            let y = match node.shape {
                Shape::And | Shape::Or | Shape::Xor => centred(if count > 2.0 { 12.0 } else { 16.0 }),
                Shape::Join | Shape::Split => centred(BAR_PITCH),
                Shape::Block => HEAD + 10.0 + PITCH * i,
                _ => centred(PITCH),
            };
            let (x0, y0) = (extent.left, extent.top);
            spots[p] = match side {
                Side::West => PinSpot { outer: [0.0, y0 + y], body: [x0, y0 + y] },
                Side::East => PinSpot { outer: [outer_width, y0 + y], body: [x0 + w, y0 + y] },
                Side::South => {
                    let (x, edge) = match node.shape {
                        Shape::Tristate => (10.0, 19.0),
                        _ => (w / 2.0, h - 5.0),
                    };
                    PinSpot { outer: [x0 + x, outer_height], body: [x0 + x, y0 + edge] }
                }
            };
        }
    }
    spots
}

/// A path, from its letters and numbers.
macro_rules! path {
    ($($letter:literal $($n:expr),*);* $(;)?) => {{
        let mut text = String::new();
        $(
            text.push_str($letter);
            let numbers: &[f64] = &[$($n),*];
            text.push_str(&numbers.iter().map(|n| number(*n)).collect::<Vec<_>>().join(" "));
        )*
        text
    }};
}

/// The outline of the body at a place.
pub(super) fn outline(shape: Shape, [x, y]: [f64; 2], [w, h]: [f64; 2]) -> String {
    let (r, b, m) = (x + w, y + h, y + h / 2.0);
    match shape {
        Shape::And => {
            // a half circle on the right, flattened where the gate is tall
            let c = x + 22.0;
            path!("M" x, y; "H" c; "C" c + 10.0, y, r, m - h * 0.28, r, m; "C" r, m + h * 0.28, c + 10.0, b, c, b; "H" x; "Z")
        }
        Shape::Or | Shape::Xor => {
            path!("M" x, y; "H" x + 10.0; "C" x + 24.0, y, x + 34.0, m - 10.0, r, m;
                  "C" x + 34.0, m + 10.0, x + 24.0, b, x + 10.0, b; "H" x; "Q" x + 12.0, m, x, y; "Z")
        }
        Shape::Triangle | Shape::Tristate => path!("M" x, y; "L" r, m; "L" x, b; "Z"),
        Shape::Mux => path!("M" x, y; "L" r, y + 10.0; "V" b - 10.0; "L" x, b; "Z"),
        Shape::Demux => path!("M" x, y + 10.0; "L" r, y; "V" b; "L" x, b - 10.0; "Z"),
        Shape::Port(crate::netlist::Direction::Inout) => {
            path!("M" x + 8.0, y; "H" r - 8.0; "L" r, m; "L" r - 8.0, b; "H" x + 8.0; "L" x, m; "Z")
        }
        Shape::Port(_) => path!("M" x, y; "H" r - 8.0; "L" r, m; "L" r - 8.0, b; "H" x; "Z"),
        Shape::Block | Shape::Sign | Shape::Frame | Shape::Join | Shape::Split => {
            path!("M" x, y; "H" r; "V" b; "H" x; "Z")
        }
    }
}

/// What is drawn of a symbol without being filled: the second curve of an exclusive OR, the wires up to a curved back.
pub(super) fn details(node: &Node, [x, y]: [f64; 2], [_, h]: [f64; 2], spots: &[[f64; 2]]) -> String {
    let mut text = String::new();
    if node.shape == Shape::Xor {
        text += &path!("M" x - 5.0, y; "Q" x + 7.0, y + h / 2.0, x - 5.0, y + h);
    }
    for (pin, &[px, py]) in node.pins.iter().zip(spots) {
        if matches!(node.shape, Shape::Or | Shape::Xor) && pin.reads {
            // the curve's bulge is 6 in its middle
            let t = (py - y) / h;
            let back = 24.0 * t * (1.0 - t);
            text += &path!("M" px, py; "H" px + (back * 2.0).round() / 2.0);
        }
        if pin.clock.is_some() && pin.side == Side::West {
            text += &path!("M" px, py - 5.0; "L" px + 8.0, py; "L" px, py + 5.0);
        }
    }
    text
}
