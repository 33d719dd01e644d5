//! Builds a netlist from named vectors of bits and cells between them, and finds what is wrong with the wiring.
//!
//! Names are hierarchical views: a port of an instance is another name for bits of its parent. [`Builder::finish`]
//! joins the bits that one output pin drives into one net, so that words stay whole.

mod storage;
mod undriven;

pub use storage::{Mem, Reg};

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::ValueNames;
use super::bus::{Bus, Part};
use super::join::{Join, NONE};
use super::wires::Wires;
use super::{
    BuildError, Cell, CellId, Content, Direction, Driver, Fault, NetId, Netlist, Scope, ScopeId, Signal, SignalId,
    Slice,
};
use crate::Value;
use crate::cell::{AddOp, CellKind, Edge, Flop, GateOp};
use crate::timescale::Timescale;

struct Named {
    signal: Signal,
    bus: Bus,
    /// Declared here rather than a name for bits declared elsewhere.
    owner: bool,
}

struct Draft {
    kind: CellKind,
    element: &'static str,
    name: String,
    scope: ScopeId,
    inputs: Vec<Bus>,
    outputs: Vec<Bus>,
}

/// Builds a [`Netlist`].
///
/// ```
/// # use discreta_core as discreta;
/// use discreta::netlist::Builder;
/// let mut b = Builder::new("toggle");
/// let clk = b.input("clk", 1);
/// let q = b.output("q", 1);
/// let not_q = b.not("inverter", &q);
/// b.dff("ff", &clk, &not_q, &q);
/// let netlist = b.finish().unwrap();
/// assert_eq!(netlist.cells().len(), 2);
/// ```
pub struct Builder {
    timescale: Timescale,
    bits: u32,
    scopes: Vec<Scope>,
    signals: Vec<Named>,
    /// The first bit of each signal that is no alias, in increasing order.
    owners: Vec<(u32, SignalId)>,
    cells: Vec<Draft>,
    constants: HashMap<Value, Bus>,
    /// Bits that are one.
    wires: Wires,
    /// Whether nets are those of Verilog.
    verilog: bool,
}

impl Builder {
    /// An empty netlist whose top scope has this name.
    #[must_use]
    pub fn new(top: &str) -> Builder {
        Builder {
            timescale: Timescale::default(),
            bits: 0,
            scopes: vec![Scope { name: top.into(), parent: None, module: Some(top.into()), parameters: vec![] }],
            signals: Vec::new(),
            owners: Vec::new(),
            cells: Vec::new(),
            constants: HashMap::new(),
            wires: Wires::default(),
            verilog: false,
        }
    }

    /// Sets what a tick is; 1 ns otherwise.
    pub fn set_timescale(&mut self, timescale: Timescale) {
        self.timescale = timescale;
    }

    /// Makes nets those of Verilog: any cells may drive one together, and it is z where nothing does.
    pub fn set_verilog(&mut self) {
        self.verilog = true;
    }

    /// The scope of the top module.
    #[must_use]
    pub fn top(&self) -> ScopeId {
        ScopeId(0)
    }

    /// The path of something within a scope below the top.
    pub fn path(&self, scope: ScopeId, name: &str) -> String {
        let mut path = name.to_owned();
        let mut scope = &self.scopes[scope.index()];
        while let Some(parent) = scope.parent {
            path = format!("{}.{path}", scope.name);
            scope = &self.scopes[parent.index()];
        }
        path
    }

    /// How many cells there are so far.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// How many bits are declared so far.
    #[must_use]
    pub fn bit_count(&self) -> u32 {
        self.bits
    }

    /// A scope within another, which is no instance of a module.
    pub fn scope(&mut self, parent: ScopeId, name: &str) -> ScopeId {
        self.scopes.push(Scope { name: name.into(), parent: Some(parent), module: None, parameters: vec![] });
        ScopeId::new(self.scopes.len() - 1)
    }

    /// A scope that is an instance of a module.
    pub fn instance(&mut self, parent: ScopeId, name: &str, module: &str) -> ScopeId {
        let id = self.scope(parent, name);
        self.scopes[id.index()].module = Some(module.into());
        id
    }

    /// Says what the parameters of a scope's module are.
    pub fn set_parameters(&mut self, scope: ScopeId, values: impl IntoIterator<Item = (String, i64)>) {
        self.scopes[scope.index()].parameters = values.into_iter().collect();
    }

    fn fresh(&mut self, width: u32) -> Bus {
        let bit = self.bits;
        self.bits = bit.checked_add(width).filter(|&b| b < NONE).expect("a netlist has fewer than 2^32 bits");
        Bus { parts: if width == 0 { vec![] } else { vec![Part { bit, width }] } }
    }

    /// New bits without a name; of a netlist as Verilog's.
    pub fn bits(&mut self, width: u32) -> Bus {
        self.fresh(width)
    }

    /// Makes two buses of one width one wire.
    pub fn join(&mut self, a: &Bus, b: &Bus) {
        self.wires.join(a, b);
    }

    /// Another name for bits of which none need be declared by a name, of the circuit's port if it is one.
    pub fn name(
        &mut self,
        scope: ScopeId,
        name: &str,
        bus: Bus,
        signed: bool,
        hidden: bool,
        port: Option<Direction>,
    ) -> SignalId {
        let id = self.push_signal(scope, name, bus, signed, port, false);
        self.signals[id.index()].signal.hidden = hidden;
        id
    }

    /// Declares a net of new bits.
    pub fn declare(
        &mut self,
        scope: ScopeId,
        name: &str,
        width: u32,
        signed: bool,
        port: Option<Direction>,
    ) -> (SignalId, Bus) {
        let bus = self.fresh(width);
        let id = self.push_signal(scope, name, bus.clone(), signed, port, true);
        self.owners.extend(bus.parts.first().map(|p| (p.bit, id)));
        (id, bus)
    }

    /// The signals that some bits were declared as.
    #[must_use]
    pub fn owners(&self, bus: &Bus) -> Vec<SignalId> {
        let mut found = Vec::new();
        for part in &bus.parts {
            let first = self.owners.partition_point(|o| o.0 <= part.bit).saturating_sub(1);
            for &(bit, signal) in
                self.owners[first.min(self.owners.len())..].iter().take_while(|o| o.0 < part.bit + part.width)
            {
                // bits between two signals are those of a constant
                let width = self.signals[signal.index()].signal.width;
                if bit + width > part.bit && found.last() != Some(&signal) {
                    found.push(signal);
                }
            }
        }
        found
    }

    /// Another name for bits that are declared elsewhere.
    pub fn alias(&mut self, scope: ScopeId, name: &str, bus: &Bus, signed: bool) -> SignalId {
        self.push_signal(scope, name, bus.clone(), signed, None, false)
    }

    /// Says that a signal is a port of the module of its scope.
    pub fn set_port(&mut self, signal: SignalId, direction: Direction) {
        self.signals[signal.index()].signal.port = Some(direction);
    }

    /// Says how a signal was declared: its lowest index, and whether indices rise towards its least significant bit, as
    /// in `[0:7]`.
    pub fn set_indices(&mut self, signal: SignalId, offset: i64, upto: bool) {
        let signal = &mut self.signals[signal.index()].signal;
        (signal.offset, signal.upto) = (offset, upto);
    }

    /// Says what people call the values of a signal.
    pub fn set_values(&mut self, signal: SignalId, names: ValueNames) {
        self.signals[signal.index()].signal.values = Some(Arc::new(names));
    }

    fn push_signal(
        &mut self,
        scope: ScopeId,
        name: &str,
        bus: Bus,
        signed: bool,
        port: Option<Direction>,
        owner: bool,
    ) -> SignalId {
        let signal = Signal {
            name: name.into(),
            scope,
            width: bus.width(),
            signed,
            offset: 0,
            upto: false,
            values: None,
            port,
            hidden: false,
            drive: None,
            first_slice: 0,
            slices: 0,
        };
        self.signals.push(Named { signal, bus, owner });
        SignalId::new(self.signals.len() - 1)
    }

    /// Declares an input of the circuit.
    pub fn input(&mut self, name: &str, width: u32) -> Bus {
        self.declare(self.top(), name, width, false, Some(Direction::Input)).1
    }

    /// Declares an output of the circuit.
    pub fn output(&mut self, name: &str, width: u32) -> Bus {
        self.declare(self.top(), name, width, false, Some(Direction::Output)).1
    }

    /// Declares a net in the top scope.
    pub fn net(&mut self, name: &str, width: u32) -> Bus {
        self.declare(self.top(), name, width, false, None).1
    }

    /// The bits of a constant.
    pub fn constant(&mut self, value: &Value) -> Bus {
        if let Some(bus) = self.constants.get(value) {
            return bus.clone();
        }
        let bus = self.own_constant(value);
        self.constants.insert(value.clone(), bus.clone());
        bus
    }

    /// The bits of a constant that is shared with nobody, so that it may be joined with wires.
    pub fn own_constant(&mut self, value: &Value) -> Bus {
        let bus = self.fresh(value.width());
        self.cells.push(Draft {
            kind: CellKind::Constant(Box::new(value.clone())),
            element: "constant",
            name: value.to_string(),
            scope: self.top(),
            inputs: vec![],
            outputs: vec![bus.clone()],
        });
        bus
    }

    /// Adds a cell. Its pins are connected in the order of [`CellKind::inputs`] and [`CellKind::outputs`]; an empty
    /// bus, or one that is missing at the end, leaves a pin open.
    pub fn cell(&mut self, scope: ScopeId, name: &str, kind: CellKind, inputs: Vec<Bus>, outputs: Vec<Bus>) -> CellId {
        let element = kind.element();
        self.cells.push(Draft { kind, element, name: name.into(), scope, inputs, outputs });
        CellId::new(self.cells.len() - 1)
    }

    /// Says as which element a cell was drawn, where its kind has several.
    pub fn drawn_as(&mut self, cell: CellId, element: &'static str) {
        self.cells[cell.index()].element = element;
    }

    /// Adds a gate in the top scope; all inputs have the width of the first. Returns its output.
    ///
    /// # Panics
    /// If there is no input.
    pub fn gate(&mut self, name: &str, op: GateOp, inputs: &[&Bus]) -> Bus {
        let width = inputs[0].width();
        let y = self.fresh(width);
        let kind = CellKind::Gate { op, width, inputs: inputs.len() as u32 };
        self.cell(self.top(), name, kind, vec![Bus::concat(inputs.iter().copied())], vec![y.clone()]);
        y
    }

    /// Adds an inverter in the top scope and returns its output.
    pub fn not(&mut self, name: &str, a: &Bus) -> Bus {
        self.gate(name, GateOp::Not, &[a])
    }

    /// Adds an adder in the top scope and returns sum and carry.
    pub fn adder(&mut self, name: &str, a: &Bus, b: &Bus) -> (Bus, Bus) {
        let width = a.width();
        let (y, co) = (self.fresh(width), self.fresh(1));
        let kind = CellKind::Adder { op: AddOp::Add, width };
        self.cell(self.top(), name, kind, vec![a.clone(), b.clone()], vec![y.clone(), co.clone()]);
        (y, co)
    }

    /// Adds a D flip-flop in the top scope that samples `d` into `q` at the rising edge of `clk`; its state is x until
    /// the first one.
    pub fn dff(&mut self, name: &str, clk: &Bus, d: &Bus, q: &Bus) -> CellId {
        let x = Value::unknown(q.width());
        let flop = Flop { edge: Edge::Rising, set_value: x.clone(), reset_value: x.clone(), init: x };
        self.cell(self.top(), name, CellKind::Flop(Box::new(flop)), vec![clk.clone(), d.clone()], vec![q.clone()])
    }

    /// The netlist.
    ///
    /// # Errors
    /// With every fault of the wiring, if there is one.
    pub fn finish(self) -> Result<Netlist, BuildError> {
        let mut faults = Vec::new();
        let netlist = self.finish_with(&mut faults);
        faults.retain(|f| !f.is_warning());
        if faults.is_empty() { Ok(netlist) } else { Err(BuildError::new(faults, &netlist)) }
    }

    /// The netlist, with x for whatever nothing drives, and every fault and warning.
    pub fn finish_with(mut self, faults: &mut Vec<Fault>) -> Netlist {
        self.check_pins(faults);
        self.take_roots();
        let mut join = Join::new(self.bits);
        let outer = self.join_inputs(&mut join);
        self.join_outputs(&mut join, faults);
        self.report_conflicts(&mut join, faults);
        self.tie_undriven(&mut join, faults);
        let nets_of_cells = join.nets.len();
        let resolvers = join.resolve();

        static BUILT: AtomicU64 = AtomicU64::new(1);
        let mut netlist = Content {
            identity: BUILT.fetch_add(1, Ordering::Relaxed),
            scopes: self.scopes,
            pin_ends: vec![0],
            nets: join.nets.clone(),
            ..Content::default()
        };
        let first_cell = self.cells.len();
        for (draft, first_output) in self.cells.into_iter().zip(&join.first_outputs) {
            let first_pin = netlist.pin_ends.len() as u32 - 1;
            for pin in 0..draft.kind.inputs().len() {
                if let Some(bus) = draft.inputs.get(pin) {
                    join.slices(bus, &mut netlist.slices);
                }
                netlist.pin_ends.push(netlist.slices.len() as u32);
            }
            netlist.cells.push(Cell {
                kind: draft.kind,
                element: draft.element,
                name: draft.name,
                scope: draft.scope,
                first_pin,
                first_output: *first_output,
            });
        }
        for (i, (width, drivers)) in resolvers.into_iter().enumerate() {
            let first_pin = netlist.pin_ends.len() as u32 - 1;
            let kind = CellKind::Resolve { width, inputs: drivers.len() as u32 };
            for (net, lo) in drivers {
                netlist.slices.push(Slice { net, lo, width });
            }
            netlist.pin_ends.push(netlist.slices.len() as u32);
            netlist.cells.push(Cell {
                element: kind.element(),
                kind,
                name: format!("resolve${i}"),
                scope: ScopeId(0),
                first_pin,
                first_output: NetId::new(nets_of_cells + i),
            });
            debug_assert_eq!(netlist.nets[nets_of_cells + i].driver, Driver::Cell(CellId::new(first_cell + i), 0));
        }
        for (named, drive) in self.signals.into_iter().zip(outer) {
            let first_slice = netlist.signal_slices.len() as u32;
            join.slices(&named.bus, &mut netlist.signal_slices);
            let slices = netlist.signal_slices.len() as u32 - first_slice;
            netlist.signals.push(Signal { drive, first_slice, slices, ..named.signal });
        }
        Netlist { timescale: self.timescale, content: Arc::new(netlist) }
    }

    /// Puts for each bit the one that stands for all that it was joined with.
    fn take_roots(&mut self) {
        if self.wires.is_empty() {
            return;
        }
        let root = std::mem::take(&mut self.wires).roots(self.bits);
        let cells = self.cells.iter_mut().flat_map(|c| c.inputs.iter_mut().chain(&mut c.outputs));
        cells.chain(self.signals.iter_mut().map(|n| &mut n.bus)).for_each(|bus| bus.rooted(&root));
    }

    fn check_pins(&self, faults: &mut Vec<Fault>) {
        for (i, draft) in self.cells.iter().enumerate() {
            let cell = CellId::new(i);
            for (given, pins, inputs) in [
                (draft.inputs.len(), draft.kind.inputs().len(), true),
                (draft.outputs.len(), draft.kind.outputs().len(), false),
            ] {
                if given > pins {
                    faults.push(Fault::SurplusPins { cell, inputs, given, pins });
                }
            }
            let ins = draft
                .kind
                .inputs()
                .iter()
                .enumerate()
                .map(|(k, p)| (p.name, draft.inputs.get(k), draft.kind.input_width(k), draft.kind.requires(k)));
            let outs = draft
                .kind
                .outputs()
                .iter()
                .enumerate()
                .map(|(k, &name)| (name, draft.outputs.get(k), draft.kind.output_width(k), false));
            for (pin, bus, expected, required) in ins.chain(outs) {
                let found = bus.map_or(0, Bus::width);
                if found == 0 && required {
                    faults.push(Fault::Open { cell, pin });
                } else if found != expected && found != 0 {
                    faults.push(Fault::Width { cell, pin, expected, found });
                }
            }
        }
    }

    /// A net for each input; for each signal the net through which it is driven from outside.
    fn join_inputs(&mut self, join: &mut Join) -> Vec<Option<NetId>> {
        let mut outer = vec![None; self.signals.len()];
        for (i, named) in self.signals.iter().enumerate() {
            let way = named.signal.port.filter(|_| named.owner && named.signal.is_top_port());
            if matches!(way, Some(Direction::Input | Direction::Inout)) {
                let tristate = self.verilog || named.signal.port == Some(Direction::Inout);
                let net = join.drive(&named.bus, named.signal.width, Driver::Input(SignalId::new(i)), tristate);
                outer[i] = Some(net);
            }
        }
        outer
    }

    fn join_outputs(&mut self, join: &mut Join, faults: &mut Vec<Fault>) {
        let constants: Vec<u32> =
            if self.verilog { vec![] } else { self.constants.values().flat_map(Bus::bits).collect() };
        let mut constant = vec![false; self.bits as usize];
        for bit in constants {
            constant[bit as usize] = true;
        }
        for (i, draft) in self.cells.iter().enumerate() {
            join.first_outputs.push(NetId::new(join.nets.len()));
            let tristate = self.verilog || matches!(draft.kind, CellKind::Tristate { .. });
            let is_constant = matches!(draft.kind, CellKind::Constant(_));
            for (pin, name) in draft.kind.outputs().iter().enumerate() {
                let open = Bus::default();
                let bus = draft.outputs.get(pin).unwrap_or(&open);
                if !is_constant && bus.bits().any(|b| constant[b as usize]) {
                    faults.push(Fault::DrivenConstant { cell: CellId::new(i), pin: name });
                    join.drive(&open, draft.kind.output_width(pin), Driver::Cell(CellId::new(i), pin as u8), false);
                    continue;
                }
                join.drive(bus, draft.kind.output_width(pin), Driver::Cell(CellId::new(i), pin as u8), tristate);
            }
        }
    }

    fn report_conflicts(&self, join: &mut Join, faults: &mut Vec<Fault>) {
        if join.conflicts.is_empty() {
            return;
        }
        // owners are declared with rising bit numbers
        let owners = self.signals.iter().enumerate().filter(|(_, n)| n.owner);
        let owners: Vec<(u32, usize)> = owners.filter_map(|(i, n)| Some((n.bus.parts.first()?.bit, i))).collect();
        let mut seen = HashSet::new();
        for (&bit, drivers) in &join.conflicts {
            let drivers: Vec<Driver> = drivers.iter().map(|&(net, _)| join.nets[net.index()].driver).collect();
            let Some(&(first, i)) = owners[..owners.partition_point(|&(first, _)| first <= bit)].last() else {
                continue;
            };
            let (signal, offset) = (SignalId::new(i), bit - first);
            if offset < self.signals[i].signal.width && seen.insert((signal, drivers.clone())) {
                faults.push(Fault::SeveralDrivers { signal, bit: offset, drivers });
            }
        }
    }
}
