//! Where everything goes: ELK's layered algorithm places the nodes of each module's body and routes its wires.
//!
//! A body is laid out once, whoever has an instance of it. The instances that are opened are laid out before what is
//! around them, which sees boxes with pins at fixed places. ELK is asked twice: first for the order of the pins that may
//! be in any, then with every pin at its place.

use std::collections::HashMap;
use std::rc::Rc;

use serde_json::{Value, json};

use super::Refusal;
use super::graph;
use super::scene::{End, Scene, Shape, Side, What};
use super::symbol::{self, Extent, PinSpot};
use super::wire::Lines;
use crate::netlist::{Hierarchy, Netlist};

/// Bodies of so many nodes in all are laid out for one drawing, to have the best.
const ATTEMPTS: usize = 300;
/// In each attempt the sweep that sorts the layers begins so often.
const SWEEPS: usize = 20;
/// A body of more nodes is laid out with less care.
const LARGE: usize = 400;

/// A body with the places of all that is in it.
pub(super) struct Placed {
    pub scene: Scene,
    pub nodes: Vec<Spot>,
    /// The pieces of each net, each from one point to another along an axis.
    pub wires: Vec<Vec<[[f64; 2]; 2]>>,
    pub size: [f64; 2],
}

/// What ELK makes of a body.
struct Routed {
    nodes: Vec<Spot>,
    wires: Vec<Vec<[[f64; 2]; 2]>>,
    size: [f64; 2],
}

impl Routed {
    /// How good it is, the less the better: crossings before corners before length.
    fn cost(&self) -> f64 {
        let lines: Vec<Lines> = self.wires.iter().map(|w| Lines::of(w)).collect();
        let mut cost = 0.0;
        for (n, net) in lines.iter().enumerate() {
            cost += 2.0 * (net.across.len() + net.down.len()) as f64;
            cost += net.across.iter().chain(&net.down).map(|l| l[2] - l[1]).sum::<f64>() / 400.0;
            for h in &net.across {
                let others = lines.iter().enumerate().filter(|(m, _)| *m != n).flat_map(|(_, l)| &l.down);
                let crossed = others.filter(|v| h[1] < v[0] && v[0] < h[2] && v[1] < h[0] && h[0] < v[2]);
                cost += 10.0 * crossed.count() as f64;
            }
        }
        cost
    }
}

/// Where a node is.
pub(super) struct Spot {
    pub at: [f64; 2],
    pub extent: Extent,
    /// In the coordinates of the body.
    pub pins: Vec<PinSpot>,
    /// What an opened instance holds; its corner is below the header.
    pub inner: Option<Rc<Placed>>,
}

pub(super) struct Layout<'n> {
    pub netlist: &'n Netlist,
    pub hierarchy: &'n Hierarchy,
    heights: Vec<usize>,
    clocks: Vec<Vec<Option<bool>>>,
    done: HashMap<(usize, usize), Rc<Placed>>,
}

impl<'n> Layout<'n> {
    pub fn new(netlist: &'n Netlist, hierarchy: &'n Hierarchy) -> Layout<'n> {
        let (heights, clocks) = (super::heights(hierarchy), graph::clocks(netlist, hierarchy));
        Layout { netlist, hierarchy, heights, clocks, done: HashMap::new() }
    }

    /// A module, its instances opened so many levels deep.
    pub fn place(&mut self, module: usize, depth: usize) -> Result<Rc<Placed>, Refusal> {
        // what has nothing to open looks the same however deep
        let depth = depth.min(self.heights[module]);
        if let Some(done) = self.done.get(&(module, depth)) {
            return Ok(done.clone());
        }
        let mut scene = graph::scene(self.netlist, self.hierarchy, &self.clocks, module);
        let mut inner = Vec::new();
        for node in &mut scene.nodes {
            inner.push(match (&node.what, depth.checked_sub(1)) {
                (&What::Instance(_, of), Some(less)) => {
                    let placed = self.place(of, less)?;
                    node.shape = Shape::Frame;
                    for (pin, port) in node.pins.iter_mut().zip(&placed.scene.nodes) {
                        // the first nodes are the ports; a wire goes in where the port leads on
                        let inwards = port.pins.iter().all(|p| p.side == Side::East);
                        pin.clock = None;
                        pin.side = if inwards { Side::West } else { Side::East };
                    }
                    Some(placed)
                }
                _ => None,
            });
        }
        let placed = Rc::new(arrange(scene, inner)?);
        self.done.insert((module, depth), placed.clone());
        Ok(placed)
    }
}

/// Places one body.
fn arrange(scene: Scene, inner: Vec<Option<Rc<Placed>>>) -> Result<Placed, Refusal> {
    let ports = scene.nodes.iter().filter(|n| matches!(n.what, What::Port));
    let widest = ports.map(|n| symbol::text_width(&n.header) + 20.0).fold(0.0, f64::max);
    let extents: Vec<Extent> = scene
        .nodes
        .iter()
        .zip(&inner)
        .map(|(node, inner)| symbol::extent(&scene, node, inner.as_ref().map(|i| i.size), widest))
        .collect();
    // the sweep that sorts the layers begins at random: the best of some, the same each time
    let attempts = (ATTEMPTS / scene.nodes.len().max(1)).clamp(1, 8);
    let mut best: Result<(f64, Routed), Refusal> = Err(Refusal::Layout("there is none".to_owned()));
    for seed in 1..=attempts {
        // one that breaks off is no loss where another does not
        match (route(&scene, &inner, &extents, seed), &best) {
            (Ok(routed), _) => {
                let cost = routed.cost();
                if best.as_ref().map_or(true, |b| cost < b.0) {
                    best = Ok((cost, routed));
                }
            }
            (Err(why), Err(_)) => best = Err(why),
            (Err(_), Ok(_)) => {}
        }
    }
    let (_, Routed { nodes, wires, size }) = best?;
    Ok(Placed { scene, nodes, wires, size })
}

/// One layout of a body.
fn route(scene: &Scene, inner: &[Option<Rc<Placed>>], extents: &[Extent], seed: usize) -> Result<Routed, Refusal> {
    let mut spots: Vec<Vec<PinSpot>> = Vec::new();
    for (i, node) in scene.nodes.iter().enumerate() {
        let order: Vec<usize> = (0..node.pins.len()).collect();
        spots.push(match &inner[i] {
            Some(inner) => framed(inner, &extents[i]),
            None => symbol::pins(node, &extents[i], &order),
        });
    }
    let free = |i: usize| !scene.nodes[i].ordered && inner[i].is_none();
    let some_free = (0..scene.nodes.len()).any(|i| free(i) && scene.nodes[i].pins.len() > 2);
    if some_free {
        let first = run(&graph_of(scene, extents, &spots, &free, seed, "BRANDES_KOEPF"))?;
        for i in (0..scene.nodes.len()).filter(|&i| free(i)) {
            let mut heights = vec![0.0; scene.nodes[i].pins.len()];
            for (p, port) in list(&first["children"][i], "ports").iter().enumerate() {
                heights[p] = port["y"].as_f64().unwrap_or_default();
            }
            let mut order: Vec<usize> = (0..heights.len()).collect();
            order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
            let mut rank = vec![0; order.len()];
            order.iter().enumerate().for_each(|(to, &p)| rank[p] = to);
            spots[i] = symbol::pins(&scene.nodes[i], &extents[i], &rank);
        }
    }
    // the straighter one takes long where there is much
    let places = if scene.nodes.len() > LARGE { "BRANDES_KOEPF" } else { "NETWORK_SIMPLEX" };
    let out = run(&graph_of(scene, extents, &spots, &|_| false, seed, places))?;
    Ok(read(scene, inner, extents, spots, &out))
}

/// The pins of an opened instance: where its ports are.
fn framed(inner: &Placed, extent: &Extent) -> Vec<PinSpot> {
    let ports = inner.nodes.iter().zip(&inner.scene.nodes).take_while(|(_, n)| matches!(n.what, What::Port));
    let [width, _] = extent.size();
    ports
        .map(|(spot, node)| {
            let y = spot.pins[0].outer[1] + symbol::HEAD;
            let west = node.pins[0].side == Side::East;
            let (outer, body) = if west { (0.0, extent.left) } else { (width, extent.left + extent.width) };
            PinSpot { outer: [outer, y], body: [body, y] }
        })
        .collect()
}

/// The graph in ELK's JSON; `places` is how it places nodes within their layers.
fn graph_of(
    scene: &Scene,
    extents: &[Extent],
    spots: &[Vec<PinSpot>],
    free: &dyn Fn(usize) -> bool,
    seed: usize,
    places: &str,
) -> Value {
    let nodes = scene.nodes.iter().enumerate().map(|(n, node)| {
        let pins = node.pins.iter().enumerate().map(|(p, pin)| {
            let [x, y] = spots[n][p].outer;
            let side = match pin.side {
                Side::West => "WEST",
                Side::East => "EAST",
                Side::South => "SOUTH",
            };
            json!({"id": format!("{n}.{p}"), "x": x, "y": y, "width": 0, "height": 0,
                   "layoutOptions": {"elk.port.side": side}})
        });
        let [width, height] = extents[n].size();
        let mut options = json!({"elk.portConstraints": if free(n) { "FIXED_SIDE" } else { "FIXED_POS" }});
        if let (What::Port, Some(pin)) = (&node.what, node.pins.first()) {
            let layer = if pin.side == Side::East { "FIRST_SEPARATE" } else { "LAST_SEPARATE" };
            options["elk.layered.layering.layerConstraint"] = json!(layer);
        }
        json!({"id": n.to_string(), "width": width, "height": height, "ports": pins.collect::<Vec<_>>(),
               "layoutOptions": options})
    });
    let nodes: Vec<Value> = nodes.collect();
    let mut edges = Vec::new();
    for (i, net) in scene.nets.iter().enumerate().filter(|(_, net)| !net.labelled) {
        for (d, by) in net.drivers.iter().enumerate() {
            for (r, to) in net.readers.iter().enumerate() {
                // what holds a state is where a circle is cut, so that its feedback runs back
                let forward = if scene.nodes[by.0].stores { 0 } else { 10 };
                edges.push(json!({
                    "id": format!("{i}.{d}.{r}"),
                    "sources": [format!("{}.{}", by.0, by.1)],
                    "targets": [format!("{}.{}", to.0, to.1)],
                    "layoutOptions": {
                        "elk.layered.priority.direction": forward,
                        "elk.layered.priority.straightness": if net.width > 1 { 5 } else { 1 },
                    }
                }));
            }
        }
    }
    json!({
        "id": "root",
        "layoutOptions": {
            "elk.algorithm": "layered",
            "elk.direction": "RIGHT",
            "elk.edgeRouting": "ORTHOGONAL",
            "elk.padding": "[top=0,left=0,bottom=0,right=0]",
            "elk.randomSeed": seed,
            "elk.separateConnectedComponents": false,
            "elk.layered.thoroughness": if scene.nodes.len() > LARGE { 7 } else { SWEEPS },
            "elk.layered.nodePlacement.strategy": places,
            "elk.spacing.nodeNode": 14,
            "elk.spacing.edgeNode": 10,
            "elk.spacing.edgeEdge": 10,
            "elk.spacing.portPort": 12,
            "elk.layered.spacing.nodeNodeBetweenLayers": 22,
            "elk.layered.spacing.edgeNodeBetweenLayers": 11,
            "elk.layered.spacing.edgeEdgeBetweenLayers": 10,
        },
        "children": nodes,
        "edges": edges,
    })
}

fn list<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

/// A coordinate in halves of a pixel: what is at one place stays at one place.
fn halves(value: &Value) -> f64 {
    (value.as_f64().unwrap_or_default() * 2.0).round() / 2.0
}

fn point(value: &Value) -> [f64; 2] {
    [halves(&value["x"]), halves(&value["y"])]
}

fn read(
    scene: &Scene,
    inner: &[Option<Rc<Placed>>],
    extents: &[Extent],
    spots: Vec<Vec<PinSpot>>,
    out: &Value,
) -> Routed {
    let mut nodes = Vec::new();
    for (n, (pins, inner)) in spots.into_iter().zip(inner).enumerate() {
        let at = point(&out["children"][n]);
        let moved = |[x, y]: [f64; 2]| [x + at[0], y + at[1]];
        let pins = pins.iter().map(|p| PinSpot { outer: moved(p.outer), body: moved(p.body) }).collect();
        nodes.push(Spot { at, extent: extents[n], pins, inner: inner.clone() });
    }
    let mut wires: Vec<Vec<[[f64; 2]; 2]>> = scene.nets.iter().map(|_| Vec::new()).collect();
    for edge in list(out, "edges") {
        let net = edge["id"].as_str().and_then(|id| id.split('.').next()?.parse::<usize>().ok());
        let (Some(net), Some(section)) = (net, list(edge, "sections").first()) else { continue };
        let mut points = vec![point(&section["startPoint"])];
        points.extend(list(section, "bendPoints").iter().map(point));
        points.push(point(&section["endPoint"]));
        wires[net].extend(points.windows(2).filter(|w| w[0] != w[1]).map(|w| [w[0], w[1]]));
    }
    // from where wires end to the symbols
    for (node, spot) in scene.nodes.iter().zip(&nodes) {
        for (pin, at) in node.pins.iter().zip(&spot.pins) {
            let End::Net(net) = pin.end else { continue };
            if at.outer != at.body && !scene.nets[net].labelled {
                wires[net].push([at.outer, at.body]);
            }
        }
    }
    let size = [halves(&out["width"]).ceil(), halves(&out["height"]).ceil()];
    Routed { nodes, wires, size }
}

/// Has ELK lay out a graph.
#[cfg(not(feature = "draw"))]
fn run(_: &Value) -> Result<Value, Refusal> {
    Err(Refusal::NotBuilt)
}

/// Has ELK lay out a graph.
#[cfg(feature = "draw")]
fn run(graph: &Value) -> Result<Value, Refusal> {
    let text = graph.to_string();
    // it recurses along the longest path
    let thread = std::thread::Builder::new().name("layout".to_owned()).stack_size(256 << 20);
    let thread = thread.spawn(move || crate::guard::caught(|| elkrs::create_elk().layout_json(&text)));
    let done = thread.map_err(|e| Refusal::Layout(e.to_string()))?.join();
    let done = done.unwrap_or_else(|_| Err("no further detail".to_owned()));
    done.map_err(|said| Refusal::Layout(format!("it broke off ({said})")))?.map_err(Refusal::Layout)
}

#[cfg(all(test, feature = "draw"))]
mod tests {
    use super::*;

    #[test]
    fn a_layout_that_breaks_off_is_an_error() {
        let missing = json!({"id": "g", "edges": [{"id": "e", "sources": ["n"], "targets": ["m"]}]});
        assert_eq!(run(&missing), Err(Refusal::Layout("Referenced shape does not exist: n".to_owned())));
        // it panics at this one
        let section = json!({"startPoint": {"x": 0, "y": 0}, "endPoint": {"x": 1, "y": 1}});
        let mut sections = [section.clone(), section];
        sections.iter_mut().enumerate().for_each(|(i, s)| s["id"] = json!(format!("s{i}")));
        let loose = json!({"id": "g", "layoutOptions": {"elk.algorithm": "random"}, "children": [{"id": "n"}, {"id": "m"}],
                           "edges": [{"id": "e", "sources": ["n"], "targets": ["m"], "sections": sections}]});
        let said = "it broke off (RandomLayoutProvider: edge with multiple sections)";
        assert_eq!(run(&loose), Err(Refusal::Layout(said.to_owned())));
    }
}
