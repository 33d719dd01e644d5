//! A netlist as a graph for Graphviz: cells with their pins as records, the hierarchy as clusters, signals from left to
//! right. The same netlist gives the same text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::cell::CellKind;
use crate::netlist::{CellId, Direction, Driver, Netlist, ScopeId, SignalId, Slice};

/// Where an edge begins or ends: a node, and a port of it.
type End = (String, String);

/// Some bits, and the pin or the port that reads them.
type Read = (Slice, Option<(CellId, usize)>, Option<SignalId>);

struct Drawing<'n> {
    netlist: &'n Netlist,
    /// For each scope the outermost instance around it that is drawn as one box.
    closed: Vec<Option<ScopeId>>,
    /// The ports of each scope that is drawn as a box.
    ports: BTreeMap<ScopeId, Vec<SignalId>>,
    /// Bits between two ends.
    edges: BTreeMap<(End, End), u32>,
    /// The nodes and clusters of each scope.
    inside: Vec<Vec<String>>,
}

/// The text of the graph. Instances that are more than `depth` deep in others are drawn as boxes.
///
/// ```
/// let circuit = discreta::circuit::load("circuits/evaluation/line.json")?;
/// let graph = discreta::export::dot::write(&circuit.netlist, 0);
/// assert!(graph.starts_with("digraph"));
/// # Ok::<(), discreta::circuit::LoadError>(())
/// ```
#[must_use]
pub fn write(netlist: &Netlist, depth: usize) -> String {
    let scopes = netlist.scopes();
    let mut closed: Vec<Option<ScopeId>> = Vec::new();
    let mut depths: Vec<usize> = Vec::new();
    for (i, scope) in scopes.iter().enumerate() {
        let (around, up) = scope.parent.map_or((None, 0), |p| (closed[p.index()], depths[p.index()]));
        let deep = up + usize::from(scope.parent.is_some() && scope.module.is_some());
        depths.push(deep);
        closed.push(around.or((deep > depth).then_some(ScopeId::new(i))));
    }
    let mut ports: BTreeMap<ScopeId, Vec<SignalId>> = BTreeMap::new();
    for id in netlist.signal_ids() {
        let signal = netlist.signal(id);
        if signal.port.is_some() && closed[signal.scope.index()] == Some(signal.scope) {
            ports.entry(signal.scope).or_default().push(id);
        }
    }
    let inside = vec![Vec::new(); scopes.len()];
    let mut drawing = Drawing { netlist, closed, ports, edges: BTreeMap::new(), inside };
    drawing.nodes();
    drawing.join();
    drawing.text()
}

/// A text within quotes or a record.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if matches!(c, '{' | '}' | '|' | '<' | '>' | '"' | '\\' | ' ') {
            out.push('\\');
        }
        out.push(if crate::safe::is_plain(c) { c } else { '?' });
    }
    out
}

/// A record: inputs, what it is, outputs.
fn record(id: &str, name: &str, kind: &str, ins: &[(String, String)], outs: &[(String, String)]) -> String {
    let column = |pins: &[(String, String)]| {
        let pins: Vec<String> = pins.iter().map(|(port, text)| format!("<{port}> {}", escaped(text))).collect();
        if pins.is_empty() { String::new() } else { format!("{{{}}}", pins.join("|")) }
    };
    let middle = if name == kind { escaped(name) } else { format!("{}\\n{}", escaped(name), escaped(kind)) };
    let parts = [column(ins), middle, column(outs)];
    let parts: Vec<&String> = parts.iter().filter(|p| !p.is_empty()).collect();
    let parts: Vec<&str> = parts.into_iter().map(String::as_str).collect();
    format!("{id} [label=\"{}\"];", parts.join("|"))
}

impl Drawing<'_> {
    /// A constant that a pin is connected to.
    fn constant(&self, slices: &[Slice]) -> Option<String> {
        let mut text = String::new();
        for slice in slices.iter().rev() {
            let Driver::Cell(cell, _) = self.netlist.net(slice.net).driver else { return None };
            let CellKind::Constant(value) = &self.netlist.cell(cell).kind else { return None };
            text.extend((slice.lo..slice.lo + slice.width).rev().map(|i| value.bit(i).char()));
        }
        (!text.is_empty()).then_some(text)
    }

    fn is_shown(&self, id: CellId) -> bool {
        let cell = self.netlist.cell(id);
        // constants are written where they are read
        !matches!(cell.kind, CellKind::Constant(_)) && self.closed[cell.scope.index()].is_none()
    }

    fn nodes(&mut self) {
        let netlist = self.netlist;
        for id in netlist.ports() {
            let signal = netlist.signal(id);
            let shape = match signal.port {
                Some(Direction::Input) => "cds",
                Some(Direction::Output) => "rarrow",
                _ => "hexagon",
            };
            let range = if signal.width > 1 { format!("[{}:0]", signal.width - 1) } else { String::new() };
            let label = escaped(&format!("{}{range}", signal.name));
            self.inside[0].push(format!("p{} [shape={shape},label=\"{label}\"];", id.index()));
        }
        for id in netlist.cell_ids() {
            if !self.is_shown(id) {
                continue;
            }
            let cell = netlist.cell(id);
            let ins = cell.kind.inputs().iter().enumerate().filter(|(pin, _)| !netlist.input(id, *pin).is_empty());
            let ins: Vec<(String, String)> = ins
                .map(|(pin, spec)| {
                    let constant = self.constant(netlist.input(id, pin));
                    (format!("i{pin}"), constant.map_or(spec.name.to_owned(), |c| format!("{} = {c}", spec.name)))
                })
                .collect();
            let outs = cell.kind.outputs().iter().enumerate();
            let outs: Vec<(String, String)> = outs.map(|(pin, name)| (format!("o{pin}"), (*name).into())).collect();
            let node = record(&format!("c{}", id.index()), &cell.name, cell.element, &ins, &outs);
            self.inside[cell.scope.index()].push(node);
        }
        for i in 0..netlist.scopes().len() {
            if self.closed[i] != Some(ScopeId::new(i)) {
                continue;
            }
            let scope = &netlist.scopes()[i];
            let (mut ins, mut outs) = (Vec::new(), Vec::new());
            for &port in self.ports.get(&ScopeId::new(i)).into_iter().flatten() {
                let signal = netlist.signal(port);
                let list = if signal.port == Some(Direction::Input) { &mut ins } else { &mut outs };
                list.push((format!("q{}", port.index()), signal.name.clone()));
            }
            let node = record(&format!("s{i}"), &scope.name, scope.module.as_deref().unwrap_or(""), &ins, &outs);
            let parent = scope.parent.map_or(0, ScopeId::index);
            self.inside[parent].push(node);
        }
    }

    /// Where something of a cell is drawn: at its pin, or at the port of the box around it through which it goes.
    fn end(&self, cell: CellId, pin: String, slice: Slice, way: Direction) -> End {
        let Some(scope) = self.closed[self.netlist.cell(cell).scope.index()] else {
            return (format!("c{}", cell.index()), pin);
        };
        let shows = |id: &&SignalId| {
            let is_input = self.netlist.signal(**id).port == Some(Direction::Input);
            is_input == (way == Direction::Input) && self.netlist.bits(**id).iter().any(|s| s.net == slice.net)
        };
        let port = self.ports.get(&scope).into_iter().flatten().find(shows);
        (format!("s{}", scope.index()), port.map_or(String::new(), |p| format!("q{}", p.index())))
    }

    fn join(&mut self) {
        let netlist = self.netlist;
        let mut reads: Vec<Read> = Vec::new();
        for id in netlist.cell_ids() {
            for pin in 0..netlist.cell(id).kind.inputs().len() {
                reads.extend(netlist.input(id, pin).iter().map(|&s| (s, Some((id, pin)), None)));
            }
        }
        for id in netlist.ports().filter(|&id| netlist.signal(id).port != Some(Direction::Input)) {
            reads.extend(netlist.bits(id).iter().map(|&s| (s, None, Some(id))));
        }
        let mut seen = std::collections::BTreeSet::new();
        for (slice, cell, port) in reads {
            let from = match netlist.net(slice.net).driver {
                Driver::Input(signal) => (format!("p{}", signal.index()), String::new()),
                Driver::Cell(by, _) if matches!(netlist.cell(by).kind, CellKind::Constant(_)) => continue,
                Driver::Cell(by, pin) => self.end(by, format!("o{pin}"), slice, Direction::Output),
            };
            let to = match (cell, port) {
                (Some((cell, pin)), _) => self.end(cell, format!("i{pin}"), slice, Direction::Input),
                (None, Some(port)) => (format!("p{}", port.index()), String::new()),
                (None, None) => continue,
            };
            let boxed = to.0.starts_with('s');
            // what several within a box read goes into it once
            if boxed && (from.0 == to.0 || !seen.insert((from.clone(), to.clone(), slice.net, slice.lo))) {
                continue;
            }
            *self.edges.entry((from, to)).or_default() += slice.width;
        }
    }

    fn cluster(&self, scope: usize, indent: usize, text: &mut String) {
        let pad = " ".repeat(indent);
        for node in &self.inside[scope] {
            let _ = writeln!(text, "{pad}{node}");
        }
        for (i, inner) in self.netlist.scopes().iter().enumerate() {
            if inner.parent.map(ScopeId::index) != Some(scope) || self.closed[i].is_some() {
                continue;
            }
            let of = inner.module.as_ref().map_or(String::new(), |m| format!(" : {m}"));
            let _ = writeln!(text, "{pad}subgraph cluster_{i} {{");
            let _ = writeln!(text, "{pad}  label=\"{}{}\";", escaped(&inner.name), escaped(&of));
            self.cluster(i, indent + 2, text);
            let _ = writeln!(text, "{pad}}}");
        }
    }

    fn text(&self) -> String {
        let name = escaped(&self.netlist.scopes()[0].name);
        let mut text = format!("digraph \"{name}\" {{\n  rankdir=LR;\n  node [shape=record];\n");
        self.cluster(0, 2, &mut text);
        for ((from, to), width) in &self.edges {
            let end = |end: &End| if end.1.is_empty() { end.0.clone() } else { format!("{}:{}", end.0, end.1) };
            let label = if *width > 1 { format!(" [label=\"{width}\",penwidth=2]") } else { String::new() };
            let _ = writeln!(text, "  {} -> {}{label};", end(from), end(to));
        }
        text + "}\n"
    }
}

#[cfg(test)]
mod tests {
    use super::write;
    use crate::netlist::Builder;

    #[test]
    fn a_small_graph() {
        let mut b = Builder::new("top");
        let (a, y) = (b.input("a", 4), b.output("y", 4));
        let not = b.not("in|verter", &a);
        let inner = b.instance(b.top(), "u", "m");
        let kind = crate::cell::CellKind::Gate { op: crate::cell::GateOp::Buf, width: 4, inputs: 1 };
        b.cell(inner, "buffer", kind, vec![not], vec![y]);
        let netlist = b.finish().unwrap();
        let whole = write(&netlist, usize::MAX);
        assert!(whole.contains("c0 [label=\"{<i0> a}|in\\|verter\\nnot|{<o0> y}\"];"), "{whole}");
        assert!(
            whole.contains("subgraph cluster_1 {\n    label=\"u\\ :\\ m\"") || whole.contains("label=\"u"),
            "{whole}"
        );
        assert!(whole.contains("c0:o0 -> c1:i0 [label=\"4\",penwidth=2];"), "{whole}");
        let boxed = write(&netlist, 0);
        assert!(boxed.contains("s1 [label=\"u\\nm\"];") && boxed.contains("c0:o0 -> s1"), "{boxed}");
    }
}
