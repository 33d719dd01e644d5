//! A schematic read back from its SVG: boxes, pins, lines, dots, and which pins the lines connect.

use std::collections::{BTreeMap, HashMap};

use discreta::{Logic, Value};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Thing {
    Cell,
    Instance,
    Port,
    Bar,
}

/// A node.
#[derive(Debug)]
pub struct Drawn {
    pub thing: Thing,
    pub path: String,
    /// The element, the direction of a port, the kind of a bar.
    pub kind: String,
    pub open: bool,
    /// Left, top, right, bottom.
    pub body: [f64; 4],
}

#[derive(Debug)]
pub struct Pin {
    pub owner: usize,
    pub name: String,
    pub at: [f64; 2],
    pub constant: Option<String>,
}

/// A wire: from, to, and the net in whose group it is.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub net: usize,
}

#[derive(Debug, Default)]
pub struct Net {
    pub name: String,
    pub lo: u32,
    pub width: u32,
    pub labels: usize,
}

#[derive(Default)]
pub struct Picture {
    pub things: Vec<Drawn>,
    pub pins: Vec<Pin>,
    pub lines: Vec<Line>,
    pub dots: Vec<([f64; 2], usize)>,
    pub nets: Vec<Net>,
}

fn attributes(tag: &str) -> HashMap<&str, String> {
    let mut all = HashMap::new();
    let mut rest = tag;
    while let Some((before, after)) = rest.split_once("=\"") {
        let (value, more) = after.split_once('"').expect("a closing quote");
        let plain = value.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
        all.insert(before.rsplit(' ').next().expect("a name"), plain);
        rest = more;
    }
    all
}

/// The points of a path of absolute commands; curves by their last points.
fn points(d: &str) -> Vec<(char, [f64; 2])> {
    let mut points = Vec::new();
    let mut at = [0.0, 0.0];
    let starts: Vec<usize> = d.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).map(|(i, _)| i).collect();
    for (k, &start) in starts.iter().enumerate() {
        let end = starts.get(k + 1).copied().unwrap_or(d.len());
        let letter = d[start..].chars().next().expect("a letter");
        let n: Vec<f64> = d[start + 1..end].split_whitespace().map(|n| n.parse().expect("a number")).collect();
        match letter {
            'H' => at[0] = n[0],
            'V' => at[1] = n[0],
            'Z' => continue,
            _ => at = [n[n.len() - 2], n[n.len() - 1]],
        }
        points.push((letter, at));
    }
    points
}

fn xy(text: &str) -> [f64; 2] {
    let (x, y) = text.split_once(' ').expect("two numbers");
    [x.parse().expect("x"), y.parse().expect("y")]
}

impl Picture {
    /// Reads a picture, in which every element is on a line of its own.
    pub fn read(svg: &str) -> Picture {
        let mut picture = Picture::default();
        // for each open group: the thing, the pin or the net that it is
        let mut groups: Vec<(Option<usize>, Option<usize>, Option<usize>)> = Vec::new();
        for line in svg.lines().map(str::trim) {
            if line == "</g>" {
                groups.pop();
                continue;
            }
            let a = attributes(line.split('>').next().unwrap_or(line));
            let get = |name: &str| a.get(name).cloned().unwrap_or_default();
            let class = get("class");
            let (thing, pin, net) = groups.last().copied().unwrap_or_default();
            if line.starts_with("<g ") {
                let mut group = (thing, pin, net);
                let first = class.split(' ').next().unwrap_or_default();
                match first {
                    "cell" | "instance" | "port" | "bar" => {
                        let (kind, path, of) = match first {
                            "cell" => (Thing::Cell, get("data-cell"), get("data-kind")),
                            "instance" => (Thing::Instance, get("data-cell"), get("data-module")),
                            "port" => (Thing::Port, get("data-port"), get("data-direction")),
                            _ => (Thing::Bar, String::new(), get("data-kind")),
                        };
                        let open = class.ends_with(" open");
                        picture.things.push(Drawn { thing: kind, path, kind: of, open, body: [0.0; 4] });
                        group.0 = Some(picture.things.len() - 1);
                    }
                    "pin" => {
                        let owner = thing.expect("a pin is of something");
                        picture.pins.push(Pin {
                            owner,
                            name: get("data-pin"),
                            at: xy(&get("data-at")),
                            constant: None,
                        });
                        group.1 = Some(picture.pins.len() - 1);
                    }
                    "net" => {
                        let bits = get("data-bits");
                        let lo = bits.rsplit(':').next().and_then(|b| b.parse().ok()).unwrap_or(0);
                        let constant = a.get("data-constant").cloned();
                        if let (Some(pin), Some(constant)) = (pin, &constant) {
                            picture.pins[pin].constant = Some(constant.clone());
                        }
                        let width = get("data-width").parse().unwrap_or(1);
                        picture.nets.push(Net { name: get("data-net"), lo, width, labels: 0 });
                        group.2 = Some(picture.nets.len() - 1);
                    }
                    other => panic!("a group of class {other}"),
                }
                groups.push(group);
            } else if line.starts_with("<path") {
                let points = points(&get("d"));
                match (class.as_str(), net, thing) {
                    ("wire", Some(net), _) => {
                        for pair in points.windows(2).filter(|p| p[1].0 != 'M') {
                            let line = Line { from: pair[0].1, to: pair[1].1, net };
                            assert!(line.from[0] == line.to[0] || line.from[1] == line.to[1], "{line:?} is slanted");
                            picture.lines.push(line);
                        }
                    }
                    ("body", _, Some(thing)) => {
                        let fold =
                            |i: usize, f: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p.1[i]).fold(start, f);
                        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
                        picture.things[thing].body = [
                            fold(0, f64::min, low),
                            fold(1, f64::min, low),
                            fold(0, f64::max, high),
                            fold(1, f64::max, high),
                        ];
                    }
                    _ => {}
                }
            } else if line.starts_with("<circle") && class == "dot" {
                let at = [get("cx"), get("cy")].map(|n| n.parse().expect("a number"));
                picture.dots.push((at, net.expect("a dot is of a net")));
            } else if line.starts_with("<text") && class == "label" {
                picture.nets[net.expect("a label is of a net")].labels += 1;
            }
        }
        picture
    }

    /// No two boxes overlap, and no wire runs through one.
    pub fn check_boxes(&self, what: &str) {
        let boxes: Vec<(usize, &Drawn)> = self.things.iter().enumerate().filter(|(_, t)| !t.open).collect();
        let overlap = |a: [f64; 4], b: [f64; 4]| a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
        for (i, (_, a)) in boxes.iter().enumerate() {
            for (_, b) in &boxes[i + 1..] {
                assert!(!overlap(a.body, b.body), "{what}: {} {:?} overlaps {} {:?}", a.path, a.body, b.path, b.body);
            }
        }
        for line in &self.lines {
            let [[x1, y1], [x2, y2]] = [line.from, line.to];
            let along = [x1.min(x2), y1.min(y2), x1.max(x2), y1.max(y2)];
            for (t, thing) in &boxes {
                let through = |b: [f64; 4]| {
                    along[0] < b[2] && b[0] < along[2] && along[1] < b[3] && b[1] < along[3]
                        || along[1] == along[3]
                            && b[1] < along[1]
                            && along[1] < b[3]
                            && along[0] < b[2]
                            && b[0] < along[2]
                        || along[0] == along[2]
                            && b[0] < along[0]
                            && along[0] < b[2]
                            && along[1] < b[3]
                            && b[1] < along[3]
                };
                let ends = |p: &Pin| p.owner == *t && (p.at == line.from || p.at == line.to);
                let own = || self.pins.iter().any(ends);
                assert!(
                    !through(thing.body) || own(),
                    "{what}: a wire {line:?} runs through {} {:?}",
                    thing.path,
                    thing.body
                );
            }
        }
    }

    /// Where lines of different nets cross.
    pub fn crossings(&self) -> usize {
        let within = |v: f64, a: f64, b: f64| a.min(b) < v && v < a.max(b);
        let across = self.lines.iter().filter(|l| l.from[1] == l.to[1]);
        let crosses = |h: &Line, v: &Line| {
            v.from[0] == v.to[0]
                && h.net != v.net
                && within(v.from[0], h.from[0], h.to[0])
                && within(h.from[1], v.from[1], v.to[1])
        };
        across.map(|h| self.lines.iter().filter(|v| crosses(h, v)).count()).sum()
    }

    /// Follows the lines.
    pub fn wiring(&self, what: &str) -> Wiring {
        let key = |p: [f64; 2]| [(p[0] * 4.0).round() as i64, (p[1] * 4.0).round() as i64];
        let mut joined = Joined((0..self.lines.len()).collect());
        let dots: HashMap<[i64; 2], usize> = self.dots.iter().map(|d| (key(d.0), d.1)).collect();
        let upright = |l: &Line| l.from[0] == l.to[0];
        let span =
            |l: &Line, axis: usize| (key(l.from)[axis].min(key(l.to)[axis]), key(l.from)[axis].max(key(l.to)[axis]));
        let around: Vec<[f64; 4]> = self
            .lines
            .iter()
            .map(|l| {
                let ([x1, y1], [x2, y2]) = (l.from, l.to);
                [x1.min(x2), y1.min(y2), x1.max(x2), y1.max(y2)]
            })
            .collect();
        for (i, a) in self.lines.iter().enumerate() {
            for (j, b) in self.lines.iter().enumerate().skip(i + 1) {
                let (m, n) = (&around[i], &around[j]);
                if m[2] < n[0] || n[2] < m[0] || m[3] < n[1] || n[3] < m[1] {
                    continue;
                }
                match (upright(a), upright(b)) {
                    (x, y) if x == y => {
                        let (across, along) = if x { (0, 1) } else { (1, 0) };
                        let (s, t) = (span(a, along), span(b, along));
                        if key(a.from)[across] == key(b.from)[across] && s.0 <= t.1 && t.0 <= s.1 {
                            assert!(s.0 == t.1 || s.1 == t.0, "{what}: {a:?} lies on {b:?}");
                            joined.join(i, j);
                        }
                    }
                    (x, _) => {
                        let (v, h) = if x { (a, b) } else { (b, a) };
                        let at = [key(v.from)[0], key(h.from)[1]];
                        let (sv, sh) = (span(v, 1), span(h, 0));
                        if at[1] < sv.0 || at[1] > sv.1 || at[0] < sh.0 || at[0] > sh.1 {
                            continue;
                        }
                        let inner = |s: (i64, i64), n: i64| s.0 < n && n < s.1;
                        let dot = dots.contains_key(&at);
                        match (inner(sv, at[1]), inner(sh, at[0])) {
                            (false, false) => joined.join(i, j),
                            (true, true) if !dot => {}
                            _ => {
                                assert!(dot, "{what}: {a:?} ends on {b:?} without a dot");
                                joined.join(i, j);
                            }
                        }
                    }
                }
            }
        }
        self.name_and_follow(what, joined, key)
    }

    fn name_and_follow(&self, what: &str, mut joined: Joined, key: impl Fn([f64; 2]) -> [i64; 2]) -> Wiring {
        // the same name at both ends is a wire
        let mut by_name: HashMap<(&str, u32), usize> = HashMap::new();
        for (i, line) in self.lines.iter().enumerate() {
            let net = &self.nets[line.net];
            if net.labels > 0 {
                let first = *by_name.entry((&net.name, net.lo)).or_insert(i);
                joined.join(first, i);
            }
        }
        let mut ends: HashMap<[i64; 2], usize> = HashMap::new();
        for (i, line) in self.lines.iter().enumerate() {
            for end in [line.from, line.to] {
                ends.entry(key(end)).or_insert(i);
            }
        }
        let mut of_pin: Vec<Option<usize>> = Vec::new();
        let mut from: Vec<u32> = Vec::new();
        for pin in &self.pins {
            let owner = &self.things[pin.owner];
            let named =
                || (owner.thing == Thing::Port).then(|| by_name.get(&(owner.path.as_str(), 0)).copied()).flatten();
            let line = ends.get(&key(pin.at)).copied().or_else(named);
            of_pin.push(line);
            from.push(line.map_or(0, |line| self.nets[self.lines[line].net].lo));
        }
        // wires that meet at one point of the frame of an opened instance are one
        let mut at_point: HashMap<[i64; 2], usize> = HashMap::new();
        for (pin, line) in self.pins.iter().zip(&of_pin) {
            let Some(line) = *line else { continue };
            let owner = &self.things[pin.owner];
            if owner.open {
                at_point.insert(key(pin.at), line);
            }
        }
        // the port inside begins where the wire outside ends; its own wire begins at its other side
        for (pin, line) in self.pins.iter().zip(&of_pin) {
            let owner = &self.things[pin.owner];
            if let (Thing::Port, Some(line)) = (owner.thing, line) {
                for x in [owner.body[0], owner.body[2]] {
                    if let Some(&outer) = at_point.get(&key([x, pin.at[1]])) {
                        joined.join(outer, *line);
                    }
                }
            }
        }
        let mut widths: HashMap<usize, u32> = HashMap::new();
        for (i, line) in self.lines.iter().enumerate() {
            let net = &self.nets[line.net];
            let root = joined.root(i);
            let before = *widths.entry(root).or_insert(net.width);
            assert_eq!(before, net.width, "{what}: wires of different widths meet at {line:?}");
        }
        let roots: Vec<Option<usize>> = of_pin.iter().map(|l| l.map(|l| joined.root(l))).collect();
        let mut wiring = Wiring { roots, from, widths, bits: BTreeMap::new(), constants: BTreeMap::new() };
        wiring.bars(self);
        wiring
    }
}

struct Joined(Vec<usize>);

impl Joined {
    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}

/// Which wire each pin is at, bit by bit.
pub struct Wiring {
    roots: Vec<Option<usize>>,
    /// The lowest bit of the signal that the wire at each pin shows: within an instance it is another's than around it.
    from: Vec<u32>,
    /// How wide each wire is.
    widths: HashMap<usize, u32>,
    /// Bits that are those of another wire, through bars.
    bits: BTreeMap<(usize, u32), (usize, u32)>,
    pub constants: BTreeMap<(usize, u32), Logic>,
}

impl Wiring {
    fn root(&self, mut bit: (usize, u32)) -> (usize, u32) {
        while let Some(&up) = self.bits.get(&bit) {
            bit = up;
        }
        bit
    }

    fn unite(&mut self, a: (usize, u32), b: (usize, u32)) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            self.bits.insert(a, b);
        }
    }

    pub fn width(&self, pin: usize) -> u32 {
        self.roots[pin].map_or(1, |root| self.widths[&root])
    }

    /// The bits at a pin of so many; none if there is no wire.
    pub fn bits(&self, pin: usize, width: u32) -> Option<Vec<(usize, u32)>> {
        let root = self.roots[pin]?;
        assert_eq!(self.widths[&root], width, "a pin of {width} bits at a wire of others");
        Some((0..width).map(|i| self.root((root, i))).collect())
    }

    fn bars(&mut self, picture: &Picture) {
        let mut constants = Vec::new();
        for (t, thing) in picture.things.iter().enumerate().filter(|(_, t)| t.thing == Thing::Bar) {
            let of: Vec<usize> = (0..picture.pins.len()).filter(|&p| picture.pins[p].owner == t).collect();
            let common = of.iter().copied().find(|&p| matches!(picture.pins[p].name.as_str(), "in" | "out"));
            let Some((common, whole)) = common.and_then(|p| Some((p, self.roots[p]?))) else { continue };
            let base = if thing.kind == "split" { self.from[common] } else { 0 };
            for p in of.into_iter().filter(|&p| p != common) {
                let name = picture.pins[p].name.trim_matches(['[', ']']);
                let (hi, lo) = name.split_once(':').unwrap_or((name, name));
                let (hi, lo): (u32, u32) = (hi.parse().expect("a bit"), lo.parse().expect("a bit"));
                if let Some(text) = &picture.pins[p].constant {
                    constants.push((whole, lo, hi, text.clone()));
                    continue;
                }
                let Some(part) = self.roots[p] else { continue };
                let width = self.widths[&part];
                for bit in lo..=hi {
                    self.unite((part, (bit - lo) % width), (whole, bit - base));
                }
            }
        }
        for (pin, root) in picture.pins.iter().zip(self.roots.clone()) {
            if let (Some(text), Some(root)) = (&pin.constant, root) {
                let value = Value::for_width(text, self.widths[&root]).expect("a constant");
                (0..value.width()).for_each(|i| {
                    self.constants.insert(self.root((root, i)), value.bit(i));
                });
            }
        }
        for (whole, lo, hi, text) in constants {
            let width = hi - lo + 1;
            let digits = text.split('\'').next().and_then(|w| w.parse::<u32>().ok()).filter(|_| text.contains('\''));
            let one = digits.unwrap_or(1).min(width);
            let value = Value::for_width(&text, one).expect("a constant");
            for bit in lo..=hi {
                let root = self.root((whole, bit));
                self.constants.insert(root, value.bit((bit - lo) % one));
            }
        }
    }
}
