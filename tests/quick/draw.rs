//! The schematic: what is drawn is what is connected. The pictures are read back and their lines followed, without
//! asking the code that drew them.

#![cfg(feature = "draw")]

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;

use crate::support::schematic::{Picture, Thing};
use discreta::cell::CellKind;
use discreta::circuit::{Limits, Loader, load};
use discreta::draw::{MOST, Options, Refusal, svg};
use discreta::netlist::{CellId, Direction, Driver, Netlist, Slice};
use discreta::{Logic, Value};

/// A bit of a net.
type Bit = (usize, u32);

fn bits(slices: &[Slice]) -> Vec<Bit> {
    slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|b| (s.net.index(), b))).collect()
}

/// The netlist by the names that the picture has.
struct Names<'n> {
    netlist: &'n Netlist,
    cells: HashMap<String, CellId>,
    ports: HashMap<String, Vec<Bit>>,
    /// What several drive together is one.
    shared: HashMap<Bit, Bit>,
}

impl<'n> Names<'n> {
    fn new(netlist: &'n Netlist) -> Names<'n> {
        let cells = netlist.cell_ids().map(|id| (netlist.cell_path(id), id)).collect();
        let ports = netlist.signal_ids().filter(|&id| netlist.signal(id).port.is_some());
        let ports = ports.map(|id| (netlist.signal_path(id), bits(netlist.bits(id)))).collect();
        let mut shared = HashMap::new();
        for id in netlist.cell_ids() {
            if let CellKind::Resolve { width, .. } = netlist.cell(id).kind {
                let to = netlist.output(id, 0).index();
                for (i, bit) in bits(netlist.input(id, 0)).into_iter().enumerate() {
                    shared.insert(bit, (to, i as u32 % width));
                }
            }
        }
        Names { netlist, cells, ports, shared }
    }

    /// The cells that are drawn as one: `memory[0]` to `memory[7]` as `memory[7:0]`.
    fn members(&self, cell: &str) -> Option<Vec<String>> {
        let (base, range) = cell.strip_suffix("]")?.rsplit_once('[')?;
        let (hi, lo) = range.split_once(':')?;
        let (hi, lo): (u32, u32) = (hi.parse().ok()?, lo.parse().ok()?);
        Some((lo..=hi).map(|i| format!("{base}[{i}]")).collect())
    }

    /// The bits of a pin of cells drawn as one: those of all, or of any if they are all the same.
    fn of_array(&self, members: &[String], pin: &str, wire: usize) -> Vec<Bit> {
        let each: Vec<Vec<Bit>> =
            members.iter().map(|m| self.of_pin(m, pin, self.width_of(m, pin).unwrap_or(1))).collect();
        let alike = each.iter().all(|bits| bits == &each[0]);
        if alike && wire == each[0].len() { each[0].clone() } else { each.concat() }
    }

    /// The bits of a pin of a cell: `d`, or `in[2]` for the third of several inputs side by side.
    fn of_pin(&self, cell: &str, pin: &str, width: usize) -> Vec<Bit> {
        let all = |path: &str| self.ports.get(path).cloned();
        let Some(&id) = self.cells.get(cell) else {
            return all(&format!("{cell}.{pin}")).unwrap_or_else(|| panic!("no {cell}.{pin}"));
        };
        let (name, part) = match pin.split_once('[') {
            Some((name, part)) => (name, part.trim_end_matches(']').parse().expect("a number")),
            None => (pin, 0),
        };
        let kind = &self.netlist.cell(id).kind;
        let pins = match kind.inputs().iter().position(|p| p.name == name) {
            Some(index) => bits(self.netlist.input(id, index)),
            None => {
                let index = kind.outputs().iter().position(|p| *p == name).expect("a pin");
                let net = self.netlist.output(id, index);
                (0..self.netlist.net(net).width).map(|b| (net.index(), b)).collect()
            }
        };
        if !pin.contains('[') {
            return pins;
        }
        pins[part * width..(part + 1) * width].to_vec()
    }

    fn constant(&self, bit: Bit) -> Option<Logic> {
        match self.netlist.nets()[bit.0].driver {
            Driver::Cell(cell, _) => match &self.netlist.cell(cell).kind {
                CellKind::Constant(value) => Some(value.bit(bit.1)),
                _ => None,
            },
            Driver::Input(_) => None,
        }
    }

    /// How many inputs of the same width a pin is one of.
    fn width_of(&self, cell: &str, pin: &str) -> Option<usize> {
        let id = *self.cells.get(cell)?;
        let kind = &self.netlist.cell(id).kind;
        let name = pin.split('[').next().expect("a part");
        let index = kind.inputs().iter().position(|p| p.name == name)?;
        Some(match (kind, index) {
            (CellKind::Gate { width, .. } | CellKind::AndOr { width, .. } | CellKind::Mux { width, .. }, 0) => {
                *width as usize
            }
            (CellKind::OneHotMux { width, .. }, 1) => *width as usize,
            _ => 1,
        })
    }
}

/// Holds that the lines of a picture connect what the netlist connects, and nothing else.
fn check(what: &str, netlist: &Netlist, text: &str) -> Picture {
    let picture = Picture::read(text);
    picture.check_boxes(what);
    let wiring = picture.wiring(what);
    let names = Names::new(netlist);
    let (mut drawn, mut real) = (BTreeMap::<(usize, u32), Bit>::new(), BTreeMap::<Bit, (usize, u32)>::new());
    let mut open: Vec<(String, Vec<Bit>)> = Vec::new();
    let mut seen = 0;
    for (p, pin) in picture.pins.iter().enumerate() {
        let owner = &picture.things[pin.owner];
        let (path, bits) = match owner.thing {
            Thing::Bar => continue,
            Thing::Port => (
                owner.path.clone(),
                names.ports.get(&owner.path).cloned().unwrap_or_else(|| panic!("{what}: no port {}", owner.path)),
            ),
            Thing::Cell | Thing::Instance => {
                let members = names.members(&owner.path).filter(|_| !names.cells.contains_key(&owner.path));
                if let Some(members) = members {
                    let wire = wiring.width(p).max(1) as usize;
                    (format!("{}.{}", owner.path, pin.name), names.of_array(&members, &pin.name, wire))
                } else {
                    let width = names.width_of(&owner.path, &pin.name).unwrap_or(wiring.width(p).max(1) as usize);
                    (format!("{}.{}", owner.path, pin.name), names.of_pin(&owner.path, &pin.name, width))
                }
            }
        };
        let bits: Vec<Bit> = bits.into_iter().map(|b| *names.shared.get(&b).unwrap_or(&b)).collect();
        if let Some(text) = &pin.constant {
            let value: Vec<Logic> = bits
                .iter()
                .map(|&b| names.constant(b).unwrap_or_else(|| panic!("{what}: {path} is no constant")))
                .collect();
            let written = Value::for_width(text, value.len() as u32).unwrap_or_else(|_| panic!("{what}: {text}"));
            let written: Vec<Logic> = (0..written.width()).map(|i| written.bit(i)).collect();
            assert_eq!(written, value, "{what}: {path} = {text}");
            continue;
        }
        let Some(wires) = wiring.bits(p, bits.len() as u32) else {
            open.push((path, bits));
            continue;
        };
        for (wire, bit) in wires.into_iter().zip(bits) {
            seen += 1;
            // one without a name is written where it is read, others are cells that drive wires
            if let (Some(value), Some(written)) = (names.constant(bit), wiring.constants.get(&wire)) {
                assert_eq!(*written, value, "{what}: {path} reads a constant");
                continue;
            }
            let before = *drawn.entry(wire).or_insert(bit);
            assert_eq!(before, bit, "{what}: {path} is connected to another net");
            let before = *real.entry(bit).or_insert(wire);
            assert_eq!(before, wire, "{what}: {path} is not connected to the rest of its net");
        }
    }
    // what has no wire is alone, or passes on what came in elsewhere
    for (path, bits) in open {
        let instance = !names.cells.contains_key(path.rsplit_once('.').map_or("", |p| p.0));
        let alone = |b: &Bit| !real.contains_key(b);
        assert!(instance || bits.iter().all(alone), "{what}: {path} has no wire");
    }
    assert!(seen > 0, "{what}: nothing is connected");
    // every cell is there
    let closed: Vec<&str> =
        picture.things.iter().filter(|t| t.thing == Thing::Instance && !t.open).map(|t| t.path.as_str()).collect();
    let cells = picture.things.iter().filter(|t| t.thing == Thing::Cell);
    let drawn_cells: HashSet<String> = cells
        .flat_map(|t| match names.members(&t.path) {
            Some(members) if !names.cells.contains_key(&t.path) => members,
            _ => vec![t.path.clone()],
        })
        .collect();
    for (path, &id) in &names.cells {
        let inside = closed.iter().any(|c| path.strip_prefix(c).is_some_and(|rest| rest.starts_with('.')));
        let hidden = matches!(netlist.cell(id).kind, CellKind::Constant(_) | CellKind::Resolve { .. });
        let there = drawn_cells.contains(path);
        assert!(inside || hidden || there, "{what}: {path} is not drawn");
    }
    for id in netlist.ports() {
        let name = &netlist.signal(id).name;
        let port = picture.things.iter().find(|t| t.thing == Thing::Port && t.path == *name);
        assert!(port.is_some(), "{what}: no port {name}");
        assert!(text.contains(&format!(">{name}</text>")) || name.len() > 24, "{what}: {name} is not written");
        let way = match netlist.signal(id).port {
            Some(Direction::Input) => "input",
            Some(Direction::Output) => "output",
            _ => "inout",
        };
        assert_eq!(port.map(|p| p.kind.as_str()), Some(way));
    }
    picture
}

/// Every circuit file that is shipped.
fn shipped() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in std::fs::read_dir("circuits").expect("circuits").map(|e| e.expect("an entry").path()) {
        if folder.is_dir() {
            files.extend(std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()));
        }
    }
    files.retain(|f| f.extension().is_some_and(|e| e == "json"));
    files.sort();
    assert!(files.len() > 30);
    files
}

fn picture(netlist: &Netlist, depth: usize) -> Result<String, Refusal> {
    svg(netlist, &Options { depth, module: None })
}

/// Draws the circuits of a folder with boxes, opened once and twice; what has gates inside only once, since what is in its
/// modules is drawn with the library.
fn check_folder(folder: &str, at_least: usize) {
    let mut drawn = 0;
    for file in shipped().into_iter().filter(|f| f.starts_with(folder)) {
        let circuit = load(&file).unwrap_or_else(|e| panic!("{}: {e:?}", file.display()));
        let deepest = if file.to_string_lossy().contains("_gates") { 1 } else { 2 };
        let mut before = String::new();
        for depth in 0..=deepest {
            let what = format!("{} --depth {depth}", file.display());
            let text = picture(&circuit.netlist, depth).unwrap_or_else(|e| panic!("{what}: {e}"));
            check(&what, &circuit.netlist, &text);
            // nothing is left to open
            if text == before {
                break;
            }
            before = text;
            drawn += 1;
        }
    }
    assert!(drawn >= at_least, "{drawn}");
}

/// The layout tries several and is to take the same one each time.
#[test]
fn the_same_circuit_gives_the_same_bytes() {
    for circuit in ["circuits/evaluation/line.json", "circuits/dda/circle.json", "circuits/feed/system.json"] {
        let draw = || picture(&load(circuit).expect("a circuit").netlist, 1);
        assert_eq!(draw(), draw(), "{circuit}");
    }
}

#[test]
fn analyzers_are_drawn_as_they_are_connected() {
    check_folder("circuits/dda", 8);
}

#[test]
fn evaluation_functions_are_drawn_as_they_are_connected() {
    check_folder("circuits/evaluation", 13);
}

#[test]
fn feed_is_drawn_as_it_is_connected() {
    check_folder("circuits/feed", 5);
}

#[test]
fn quadrants_are_drawn_as_they_are_connected() {
    check_folder("circuits/quadrant", 7);
}

#[test]
fn three_axes_are_drawn_as_they_are_connected() {
    check_folder("circuits/three_axis", 4);
}

#[test]
fn every_module_of_the_library_is_drawn_as_it_is_connected() {
    let mut drawn = 0;
    for file in shipped().into_iter().filter(|f| f.starts_with("circuits/lib")) {
        let text = std::fs::read_to_string(&file).expect("a file");
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        for name in json["modules"].as_object().expect("modules").keys() {
            let mut loader = Loader::new(Limits::default());
            loader.set_top(name);
            let circuit = loader.open(&file).and_then(|handle| loader.elaborate(handle, &[]));
            // some have no default for a parameter
            let Some(circuit) = circuit else { continue };
            let what = format!("{} {name}", file.display());
            check(&what, &circuit.netlist, &picture(&circuit.netlist, 0).unwrap_or_else(|e| panic!("{what}: {e}")));
            drawn += 1;
        }
    }
    assert!(drawn > 20, "{drawn}");
}

/// The block diagram has two registers, the multiplexer of three gates, adder and memory, two counters and triggers; by
/// hand it is drawn with a dozen crossings.
#[test]
fn the_line_interpolator_has_few_crossings() {
    let circuit = load("circuits/evaluation/line.json").expect("a circuit");
    let text = picture(&circuit.netlist, 0).expect("a picture");
    let picture = check("line", &circuit.netlist, &text);
    let crossings = picture.crossings();
    assert!(crossings <= 16, "{crossings}");
    let at = |name: &str| picture.things.iter().find(|t| t.path == name).expect("a cell").body;
    // from left to right, as the document has it
    for (left, right) in
        [("register1", "and1"), ("and1", "or1"), ("or1", "adder"), ("adder", "memory"), ("kox", "trigger_x")]
    {
        assert!(at(left)[2] < at(right)[0], "{left} is left of {right}");
    }
}

#[test]
fn what_is_too_large_is_refused() {
    let circuit = load("circuits/evaluation/line_gates.json").expect("a circuit");
    let circuit = discreta::circuit::load_with("circuits/evaluation/line_gates.json", &[("W", 32)]).unwrap_or(circuit);
    let refused = picture(&circuit.netlist, 9);
    assert!(matches!(refused, Err(Refusal::TooLarge(count)) if count > MOST), "{:?}", refused.map(|t| t.len()));
    let unknown = svg(&circuit.netlist, &Options { depth: 0, module: Some("nothing") });
    assert!(matches!(unknown, Err(Refusal::NoModule(names)) if names.iter().any(|n| n == "full_adder_gates")));
}

/// The pictures of the documentation, and the options that draw them.
const PICTURES: [(&str, &str, usize); 2] = [
    ("line_schematic.svg", "circuits/evaluation/line.json", 0),
    ("line_gates_schematic.svg", "circuits/evaluation/line_gates.json", 0),
];

#[test]
fn the_pictures_of_the_documentation_are_current() {
    for (file, circuit, depth) in PICTURES {
        let netlist = load(circuit).expect("a circuit").netlist;
        let text = picture(&netlist, depth).expect("a picture");
        // whatever is stored, what it shows is what is connected
        check(file, &netlist, &text);
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/pictures").join(file);
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, &text).expect("the picture is written");
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == text,
            "docs/pictures/{file} is not up to date; renew it: BLESS=1 cargo test --test quick draw"
        );
    }
}
