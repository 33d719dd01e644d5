//! Yosys' cells, each lowered to cells of the netlist: `docs/yosys.md` has the table.
//!
//! Operands are extended, cut and joined by wiring; a cell of the netlist does the rest. What `x` and `z` give is what
//! Yosys' `simlib.v` and `simcells.v` and IEEE 1364 say, and `tests/oracle/yosys_cells` compares.

mod arithmetic;
mod debug;
mod gates;
mod logic;
pub(super) mod memory;
mod select;
mod storage;

use super::file::{Bit, Cell, Range, Setting, Term};
use super::import::{Here, Import};
use super::own;
use crate::cell::{CellKind, GateOp};
use crate::diag::Code;
use crate::netlist::Bus;
use crate::{Logic, Value};
use storage::Store;

/// How a cell type is lowered.
type Lower = fn(&mut Site<'_, '_, '_>) -> Result<(), Fault>;

/// What a type of cell is.
#[derive(Clone)]
pub(super) enum Type {
    /// A module of the file, by its place.
    Module(usize),
    /// A cell of Yosys.
    Cell(Lower),
    /// A flip-flop or latch of one bit, as its name says.
    Store(Box<Store>),
    /// A part of a memory, which is lowered with the others.
    MemoryPart,
    /// It has no effect here, and why.
    Ignored(&'static str),
    /// It cannot be simulated, and what to do.
    Refused(&'static str, &'static str),
    /// Nothing that is known.
    Unknown,
}

/// Why a cell cannot be taken.
pub(super) struct Fault {
    pub code: Code,
    pub message: String,
    pub help: Option<String>,
}

impl From<String> for Fault {
    fn from(message: String) -> Fault {
        Fault { code: Code::UnsupportedCell, message, help: None }
    }
}

/// What a type of Yosys' own is.
pub(super) fn builtin(name: &str) -> Type {
    let families = [logic::find, arithmetic::find, select::find, gates::find, memory::find, debug::find];
    if let Some(lower) = families.iter().find_map(|find| find(name)) {
        return Type::Cell(lower);
    }
    if let Some(store) = storage::gate(name) {
        return Type::Store(Box::new(store));
    }
    if let Some(lower) = storage::find(name) {
        return Type::Cell(lower);
    }
    if memory::is_part(name) {
        return Type::MemoryPart;
    }
    const FORMAL: &str = "it is for formal proofs, and has no meaning in a simulation";
    match name {
        "$scopeinfo" => Type::Ignored("names of scopes, which the nets have too"),
        "$input_port" => Type::Ignored("marks of inputs, which the ports are"),
        "$specify2" | "$specify3" | "$specrule" => Type::Ignored("timing"),
        "$connect" => Type::Refused("it joins nets both ways", "let Yosys connect them directly: `bufnorm -conn`"),
        "$fsm" => Type::Refused("state machines are to be made logic first", "run `fsm_map`"),
        "$live" | "$fair" | "$anyconst" | "$anyseq" | "$anyinit" | "$allconst" | "$allseq" | "$initstate"
        | "$equiv" | "$future_ff" | "$original_tag" | "$overwrite_tag" | "$get_tag" | "$set_tag" => {
            Type::Refused(FORMAL, "write the netlist without it, e.g. `delete t:$any*` or `chformal -remove`")
        }
        _ => Type::Unknown,
    }
}

/// Lowers a cell that is no instance of a module.
pub(super) fn lower<'f, 'a>(import: &mut Import<'f, 'a>, here: &Here<'f, 'a>, cell: &Cell<'a>) -> Result<(), Fault> {
    let kind = import.kind(cell.kind).clone();
    import.own_constants = false;
    match kind {
        Type::Cell(lower) => lower(&mut Site { import, here, cell }),
        Type::Store(store) => storage::lower(&mut Site { import, here, cell }, *store),
        Type::Ignored(why) => {
            let name = import.file.terms.text(cell.kind).to_string();
            import.ignored.entry(name).or_insert((0, why)).0 += 1;
            Ok(())
        }
        Type::Refused(why, help) => {
            Err(Fault { code: Code::UnsupportedCell, message: why.into(), help: Some(help.into()) })
        }
        // with all of its module
        Type::MemoryPart => Ok(()),
        Type::Module(_) | Type::Unknown => Err(Fault {
            code: Code::UnknownType,
            message: "the file has no such module, and Yosys no such cell".into(),
            help: Some("read the Verilog of the module too, or map the cell to what Yosys knows: `techmap`".into()),
        }),
    }
}

/// Makes an instance the element that its module stands for.
pub(super) fn element<'f, 'a>(
    import: &mut Import<'f, 'a>,
    here: &Here<'f, 'a>,
    cell: &Cell<'a>,
    text: Term,
) -> Result<(), Fault> {
    let says = import.file.terms.text(text);
    let Some((kind, element)) = own::parse(says) else {
        return Err(format!("its module says that it is `{says}`, but there is no such element").into());
    };
    import.own_constants = false;
    let mut site = Site { import, here, cell };
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for (pin, spec) in kind.inputs().iter().enumerate() {
        let bus = site.input(spec.name);
        if bus.width() > 0 {
            site.expect_width(spec.name, bus.width(), kind.input_width(pin))?;
        }
        inputs.push(bus);
    }
    for (pin, name) in kind.outputs().iter().enumerate() {
        let bus = site.output(name);
        if bus.width() > 0 {
            site.expect_width(name, bus.width(), kind.output_width(pin))?;
        }
        outputs.push(bus);
    }
    let known = |name: &str| kind.inputs().iter().any(|p| p.name == name) || kind.outputs().contains(&name);
    let connections = here.module.connections(cell).iter().map(|c| site.import.file.terms.text(c.0));
    if let Some(unknown) = connections.into_iter().find(|name| !known(name)) {
        let message = format!("it connects `{unknown}`, which a `{element}` does not have");
        return Err(Fault { code: Code::UnknownPort, message, help: None });
    }
    let id = site.import.builder.cell(here.scope, &cell.name, kind, inputs, outputs);
    site.import.builder.drawn_as(id, element);
    Ok(())
}

/// A cell being lowered.
pub(super) struct Site<'s, 'f, 'a> {
    pub import: &'s mut Import<'f, 'a>,
    pub here: &'s Here<'f, 'a>,
    pub cell: &'s Cell<'a>,
}

impl Site<'_, '_, '_> {
    fn range(&self, port: &str) -> Option<Range> {
        let connections = self.here.module.connections(self.cell);
        connections.iter().find(|c| *self.import.file.terms.text(c.0) == port).map(|c| c.1)
    }

    /// What a port is connected to, as the file has it.
    pub fn written(&self, port: &str) -> &[Bit] {
        self.range(port).map_or(&[], |range| self.here.module.bits(range))
    }

    /// What a port reads; a port of no bits, or that is not connected, reads nothing.
    pub fn input(&mut self, port: &str) -> Bus {
        let bits = self.range(port).map_or(&[][..], |range| self.here.module.bits(range));
        self.import.bus(self.here, bits)
    }

    /// What a port reads, at least one bit: a port of no bits reads 0.
    pub fn operand(&mut self, port: &str) -> Bus {
        let bus = self.input(port);
        if bus.width() == 0 { self.constant(Logic::Zero, 1) } else { bus }
    }

    /// What a port of one bit reads.
    pub fn bit(&mut self, port: &str) -> Result<Bus, Fault> {
        let bus = self.input(port);
        if bus.width() == 1 { Ok(bus) } else { Err(format!("`{port}` is {} bits, not one", bus.width()).into()) }
    }

    /// What a port drives. A constant there is driven in vain.
    pub fn output(&mut self, port: &str) -> Bus {
        let mut bus = Bus::default();
        for bit in self.written(port).to_vec() {
            match bit.number() {
                Some(_) => bus.append(&self.import.bus(self.here, &[bit])),
                None => bus.append(&self.import.builder.bits(1)),
            }
        }
        bus
    }

    /// Bits that nothing else has.
    pub fn spare(&mut self, width: u32) -> Bus {
        self.import.builder.bits(width)
    }

    /// A constant of one bit, repeated.
    pub fn constant(&mut self, bit: Logic, width: u32) -> Bus {
        self.import.constant(&Value::repeat(bit, width))
    }

    fn setting(&self, name: &str) -> Option<Setting> {
        let parameters = self.here.module.parameters(self.cell);
        parameters.iter().find(|p| *self.import.file.terms.text(p.0) == name).map(|p| p.1)
    }

    /// Whether the cell is said not to be as Yosys has it, but so.
    pub fn is_own(&self, says: &str) -> bool {
        self.cell.own.is_some_and(|own| *self.import.file.terms.text(own) == says)
    }

    /// A parameter as bits.
    pub fn value(&self, name: &str) -> Option<Value> {
        self.setting(name).and_then(|s| self.import.file.value(s))
    }

    /// A parameter as text.
    pub fn string(&self, name: &str) -> Option<String> {
        self.setting(name).and_then(|s| self.import.file.string(s)).map(std::borrow::Cow::into_owned)
    }

    /// A parameter as a number; 0 if it is not there.
    pub fn number(&self, name: &str) -> Result<u32, Fault> {
        let Some(value) = self.value(name) else { return Ok(0) };
        let number = value.to_u64().and_then(|n| u32::try_from(n).ok());
        number.ok_or_else(|| format!("its parameter `{name}` is {value}").into())
    }

    /// Whether a parameter is set.
    pub fn flag(&self, name: &str) -> bool {
        self.value(name).is_some_and(|v| v.bits().any(|b| b == Logic::One))
    }

    /// Whether a polarity is positive: so it is where nothing is said.
    pub fn positive(&self, name: &str) -> bool {
        self.value(name).is_none_or(|v| v.bits().any(|b| b == Logic::One))
    }

    /// A parameter cut or extended by zeros to a width.
    pub fn sized(&self, name: &str, width: u32) -> Value {
        let mut sized = Value::from_u64(0, width);
        if let Some(value) = self.value(name) {
            (0..width.min(value.width())).for_each(|i| sized.set_bit(i, value.bit(i)));
        }
        sized
    }

    /// A bus cut or extended to a width.
    pub fn extend(&mut self, bus: &Bus, signed: bool, width: u32) -> Bus {
        let have = bus.width();
        if have >= width {
            return bus.slice(0, width);
        }
        let mut wide = bus.clone();
        if signed && have > 0 {
            let sign = bus.bit(have - 1);
            (have..width).for_each(|_| wide.append(&sign));
        } else {
            wide.append(&self.constant(Logic::Zero, width - have));
        }
        wide
    }

    /// Both operands, at the width that Verilog computes with, and whether by sign: only if both have one.
    pub fn operands(&mut self, at_least: u32) -> (Bus, Bus, bool) {
        let (a, b) = (self.operand("A"), self.operand("B"));
        let signed = self.flag("A_SIGNED") && self.flag("B_SIGNED");
        let width = a.width().max(b.width()).max(at_least);
        (self.extend(&a, signed, width), self.extend(&b, signed, width), signed)
    }

    /// Adds the cell itself.
    pub fn cell(&mut self, kind: CellKind, inputs: Vec<Bus>, outputs: Vec<Bus>) {
        self.import.builder.cell(self.here.scope, &self.cell.name, kind, inputs, outputs);
    }

    /// Adds a cell that helps it.
    pub fn helper(&mut self, part: &str, kind: CellKind, inputs: Vec<Bus>, outputs: Vec<Bus>) {
        let name = format!("{}${part}", self.cell.name);
        self.import.builder.cell(self.here.scope, &name, kind, inputs, outputs);
    }

    /// Adds a helping gate and gives its output.
    pub fn gate(&mut self, part: &str, op: GateOp, width: u32, inputs: &[&Bus]) -> Bus {
        let y = self.spare(width);
        let ins = Bus::concat(inputs.iter().copied());
        let kind = CellKind::Gate { op, width, inputs: ins.width() / width };
        self.helper(part, kind, vec![ins], vec![y.clone()]);
        y
    }

    /// One bit inverted; by one gate, however many cells of the instance ask for it.
    pub fn invert(&mut self, bit: &Bus) -> Bus {
        let Some(number) = bit.bits().next() else { return bit.clone() };
        let key = (self.here.scope, number);
        if let Some(known) = self.import.inverted.get(&key) {
            return known.clone();
        }
        let y = self.gate("not", GateOp::Not, 1, &[bit]);
        self.import.inverted.insert(key, y.clone());
        y
    }

    /// Makes two buses one wire.
    pub fn wire(&mut self, to: &Bus, from: &Bus) {
        self.import.builder.join(from, to);
    }

    /// Ties wires to a constant.
    pub fn tie(&mut self, to: &Bus, value: &Value) {
        if to.width() > 0 {
            let own = self.import.builder.own_constant(value);
            self.wire(to, &own);
        }
    }

    /// The result of a cell that gives one bit: the port's lowest; the others are 0.
    pub fn one_bit(&mut self) -> Bus {
        let y = self.output("Y");
        let rest = y.width().saturating_sub(1);
        if y.width() == 0 {
            return self.spare(1);
        }
        self.tie(&y.slice(1, rest), &Value::from_u64(0, rest));
        y.bit(0)
    }

    /// The result of a cell that gives `width` bits, of which the port may take fewer.
    pub fn result(&mut self, width: u32) -> Bus {
        let mut y = self.output("Y");
        let more = width.saturating_sub(y.width());
        if more > 0 {
            y.append(&self.spare(more));
        }
        y
    }

    /// Refuses a port that is not as wide as it must be.
    pub fn expect_width(&self, port: &str, found: u32, expected: u32) -> Result<(), Fault> {
        if found == expected {
            return Ok(());
        }
        let message = format!("`{port}` is connected to {found} bits, and is {expected}");
        Err(Fault { code: Code::WidthMismatch, message, help: None })
    }
}
