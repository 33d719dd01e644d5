//! Modules that stand for elements of ours: for us the element that their attribute names, for others the ordinary cells
//! in them, or a black box where there are none.

use super::cells::stepped;
use super::draw::{Draw, ZERO};
use super::model::{Bit, Bits, Cell, Module, Net, Port};
use super::storage::{self, Async};
use crate::Value;
use crate::cell::{CellKind, Flop, Storage};
use crate::import::yosys::own::{LEVEL, text};
use crate::netlist::Direction;

/// The modules made so far.
#[derive(Default)]
pub struct Owns {
    /// Each with what it stands for and which pins it has.
    pub modules: Vec<(Module, String, Vec<&'static str>)>,
    /// Names that are taken.
    pub taken: std::collections::HashSet<String>,
}

/// An element to be drawn as an instance of its module.
pub struct Own {
    module: String,
    pins: Vec<(&'static str, Direction)>,
}

impl Own {
    /// The module of an element with the pins that are connected, made if there is none yet.
    pub fn of(kind: &CellKind, element: &'static str, ins: &[Bits], outs: &[Bits], d: &mut Draw) -> Own {
        let used = |i: usize| i == 0 || d.is_used(&outs[i]);
        let inputs = kind.inputs().iter().zip(ins).filter(|(_, bits)| !bits.is_empty());
        let mut pins: Vec<(&'static str, Direction)> = inputs.map(|(pin, _)| (pin.name, Direction::Input)).collect();
        let outputs = kind.outputs().iter().enumerate().filter(|(i, _)| used(*i));
        pins.extend(outputs.map(|(_, &name)| (name, Direction::Output)));
        let names: Vec<&'static str> = pins.iter().map(|p| p.0).collect();
        let says = text(kind, element).unwrap_or_default();
        if let Some(known) = d.owns.modules.iter().find(|m| m.1 == says && m.2 == names) {
            return Own { module: known.0.name.clone(), pins };
        }
        let width = kind.output_width(0);
        let base = if width == 1 { element.to_owned() } else { format!("{element}_W{width}") };
        let name = (1..).map(|n| if n == 1 { base.clone() } else { format!("{base}_{n}") });
        let name = name.into_iter().find(|n| !d.owns.taken.contains(n)).unwrap_or(base);
        d.owns.taken.insert(name.clone());
        let mut module = body(kind, &name, &pins);
        module.attributes.push(("discreta", says.clone()));
        d.owns.modules.push((module, says, names));
        Own { module: name, pins }
    }

    /// Draws the instance.
    pub fn put(&self, d: &mut Draw, kind: &CellKind, ins: &[Bits], outs: &[Bits]) {
        let bits = |name: &str| {
            let input = kind.inputs().iter().position(|p| p.name == name).map(|i| ins[i].clone());
            input.or_else(|| kind.outputs().iter().position(|&p| p == name).map(|i| outs[i].clone()))
        };
        let pick = |way| self.pins.iter().filter(move |p| p.1 == way).map(|p| (p.0, bits(p.0).unwrap_or_default()));
        let (inputs, outputs) = (pick(Direction::Input).collect(), pick(Direction::Output).collect());
        d.put("", &self.module, vec![], inputs, outputs);
    }
}

/// The module, with ordinary cells where there are some that do in two values what the element does.
fn body(kind: &CellKind, name: &str, pins: &[(&'static str, Direction)]) -> Module {
    let mut module = Module::new(name, 2);
    let mut ports: Vec<(&'static str, Bits)> = Vec::new();
    for &(pin, direction) in pins {
        let input = kind.inputs().iter().position(|p| p.name == pin).filter(|_| direction == Direction::Input);
        let width = match input {
            Some(i) => kind.input_width(i),
            None => kind.output_width(kind.outputs().iter().position(|&p| p == pin).unwrap_or(0)),
        };
        let bits: Bits = (module.free..module.free + width).map(Bit::Net).collect();
        module.free += width;
        module.names.insert(pin.to_owned());
        let net = Net {
            name: pin.to_owned(),
            bits: bits.clone(),
            hidden: false,
            signed: false,
            values: None,
            attributes: vec![],
        };
        module.nets.push(net);
        module.ports.push(Port { name: pin.to_owned(), direction, bits: bits.clone(), signed: false });
        ports.push((pin, bits));
    }
    let pin = |name: &str| ports.iter().find(|p| p.0 == name).map_or(Bits::new(), |p| p.1.clone());
    let mut owns = Owns::default();
    let mut d = Draw::new(module, &mut owns);
    d.name = "state".into();
    let q = pin("q");
    match kind.storage() {
        Some(Storage::Flop(f) | Storage::EdgeFlop(f)) => {
            let ad = if matches!(kind, CellKind::Flop(_)) { pin("d") } else { pin("ad") };
            let (data, enable) =
                storage::synchronous(&mut d, f, &pin("d"), &pin("en"), &pin("sync_set"), &pin("sync_reset"));
            let controls = controls(f, &pin, (pin("aload"), ad));
            storage::with_controls(&mut d, f, pin("clk")[0], (data, enable), &controls, &q);
            complement(&mut d, &q, pin("qn"));
        }
        Some(Storage::Sr { set_dominates, .. }) => {
            let unknown = Value::unknown(1);
            storage::sr(&mut d, set_dominates, &unknown, &[pin("s"), pin("r")], &[q.clone(), pin("qn")]);
        }
        Some(Storage::Latch(f)) => {
            let controls = controls(f, &pin, (pin("en"), pin("d")));
            let (load, data) = storage::one_load(&mut d, &controls);
            storage::open_latch(&mut d, f, load.unwrap_or(ZERO), &data, &q);
            complement(&mut d, &q, pin("qn"));
        }
        Some(Storage::Counter(c)) => {
            let (load, en) = (Draw::active(&pin("load")), pin("en"));
            let mut data = stepped(&mut d, &q, &c.step, &pin("down"));
            let mut enable = en;
            if let Some(load) = load {
                let next = d.fresh("d", q.len());
                d.mux("d", &data, &data_pin(&pin("d"), q.len()), load, next.clone());
                data = next;
                if let Some(&en) = enable.first() {
                    enable = d.any("en", &[en, load]).into_iter().collect();
                }
            }
            let zero = Value::from_u64(0, c.init.width());
            let flop = Flop { edge: c.edge, set_value: zero.clone(), reset_value: zero, init: c.init.clone() };
            let controls = controls(&flop, &pin, (pin("aload"), data_pin(&pin("d"), q.len())));
            storage::with_controls(&mut d, &flop, pin("clk")[0], (data, enable), &controls, &q);
            if !pin("zero").is_empty() {
                d.unary("zero", "$logic_not", &q, pin("zero"));
            }
        }
        Some(Storage::Accumulator(a)) => {
            let mut sum = d.fresh("sum", q.len());
            sum.extend(pin("co"));
            match Draw::active(&pin("ci")) {
                None => d.binary("sum", "$add", &q, &pin("d"), sum.clone()),
                Some(ci) => {
                    let first = d.fresh("first", sum.len());
                    d.binary("first", "$add", &q, &pin("d"), first.clone());
                    d.binary("sum", "$add", &first, &[ci], sum.clone());
                }
            }
            sum.truncate(q.len());
            let zero = Value::from_u64(0, a.init.width());
            let flop = Flop { edge: a.edge, set_value: zero.clone(), reset_value: zero, init: a.init.clone() };
            let controls = controls(&flop, &pin, (Bits::new(), Bits::new()));
            storage::with_controls(&mut d, &flop, pin("clk")[0], (sum, pin("en")), &controls, &q);
        }
        // what acts by time
        None => d.module.attributes.push(("blackbox", super::flag())),
    }
    d.finish()
}

/// A data pin; what is not connected reads 0.
fn data_pin(bits: &[Bit], width: usize) -> Bits {
    if bits.is_empty() { vec![ZERO; width] } else { bits.to_vec() }
}

/// The asynchronous controls, the weakest first.
fn controls(f: &Flop, pin: &dyn Fn(&str) -> Bits, load: (Bits, Bits)) -> Vec<Async> {
    let values = |value: &Value| super::model::constant(value);
    let all = [load, (pin("set"), values(&f.set_value)), (pin("reset"), values(&f.reset_value))];
    let width = f.init.width() as usize;
    let active = all.into_iter().filter_map(|(control, data)| Some((Draw::active(&control)?, data)));
    active.map(|(control, data)| Async { control, data: data_pin(&data, width) }).collect()
}

fn complement(d: &mut Draw, q: &[Bit], qn: Bits) {
    if !qn.is_empty() {
        d.unary("qn", "$not", q, qn);
    }
}

/// Says that the asynchronous controls of a cell act by their level.
pub fn by_level(cell: &mut Cell) {
    cell.attributes.push(("discreta", LEVEL.to_owned()));
}
