//! A module being drawn: cells and the nets between them.

use super::model::{Bit, Bits, Cell, Module, Net, Setting};
use super::own::Owns;
use crate::netlist::Direction;
use crate::{Logic, Value};

/// A module being drawn.
pub struct Draw<'o> {
    pub module: Module,
    /// The modules that stand for elements of ours, which all share.
    pub owns: &'o mut Owns,
    /// The cell that is being drawn.
    pub name: String,
    /// Where it comes from.
    pub source: Option<String>,
    /// What bits hold at the start, with the cell that they are the state of.
    pub inits: Vec<(String, Bits, Value)>,
    /// How many read or show each bit of the module, by its number; what is drawn meanwhile is not counted.
    pub uses: Vec<u32>,
    /// How many may drive each.
    pub drivers: Vec<u32>,
}

/// One bit, repeated.
pub fn repeat(bit: Bit, width: usize) -> Bits {
    vec![bit; width]
}

pub const ZERO: Bit = Bit::Constant(Logic::Zero);
pub const ONE: Bit = Bit::Constant(Logic::One);

impl<'o> Draw<'o> {
    pub fn new(module: Module, owns: &'o mut Owns) -> Draw<'o> {
        Draw {
            module,
            owns,
            name: String::new(),
            source: None,
            inits: Vec::new(),
            uses: Vec::new(),
            drivers: Vec::new(),
        }
    }

    /// Counts who uses each bit of a module, and who drives it.
    pub fn count(&mut self, end: u32, shown: &[Bits], pins: &[(Vec<Bits>, Vec<Bits>)], bound: &[Vec<Bits>]) {
        let (mut uses, mut drivers) = (vec![0; end as usize], vec![0; end as usize]);
        let count = |list: &mut Vec<u32>, bits: &[Bit]| {
            for bit in bits {
                if let Bit::Net(n) = bit {
                    list[*n as usize] += 1;
                }
            }
        };
        shown.iter().for_each(|bits| count(&mut uses, bits));
        pins.iter().flat_map(|p| &p.0).for_each(|bits| count(&mut uses, bits));
        pins.iter().flat_map(|p| &p.1).for_each(|bits| count(&mut drivers, bits));
        bound.iter().flatten().for_each(|bits| {
            count(&mut uses, bits);
            count(&mut drivers, bits);
        });
        (self.uses, self.drivers) = (uses, drivers);
    }

    /// The state of a cell that begins with a value. Yosys has the value with the net, so where others drive that too the
    /// state has one of its own.
    pub fn state(&mut self, q: &[Bit], init: &Value) -> Bits {
        let known = init.bits().any(|b| b != Logic::X);
        let shared = |bit: &Bit| matches!(bit, Bit::Net(n) if self.drivers.get(*n as usize).is_some_and(|&d| d > 1));
        if !known || !q.iter().any(shared) {
            self.init(q, init);
            return q.to_vec();
        }
        let own = self.fresh("q", q.len());
        self.init(&own, init);
        self.unary("wire", "$pos", &own, q.to_vec());
        own
    }

    /// Whether anything reads or shows some of these bits.
    pub fn is_used(&self, bits: &[Bit]) -> bool {
        bits.iter().any(|bit| match bit {
            Bit::Net(n) => self.uses.get(*n as usize).is_none_or(|&n| n > 0),
            Bit::Constant(_) => false,
        })
    }

    /// New bits, named after a part of the cell.
    pub fn fresh(&mut self, part: &str, width: usize) -> Bits {
        let bits: Bits = (0..width as u32).map(|i| Bit::Net(self.module.free + i)).collect();
        self.module.free += width as u32;
        let name = self.module.unique(&format!("{}${part}$y", self.name));
        self.module.nets.push(Net {
            name,
            bits: bits.clone(),
            hidden: true,
            signed: false,
            values: None,
            attributes: vec![],
        });
        bits
    }

    /// Adds a cell: the one that is being drawn, or a part of it.
    pub fn put(
        &mut self,
        part: &str,
        kind: &str,
        parameters: Vec<(&'static str, Setting)>,
        inputs: Vec<(&str, Bits)>,
        outputs: Vec<(&str, Bits)>,
    ) -> &mut Cell {
        let name = match part {
            // a net may have the name
            "" if self.module.names.contains(&self.name) => format!("{}${}", self.name, kind.trim_matches(['$', '_'])),
            "" => self.name.clone(),
            part => format!("{}${part}", self.name),
        };
        let name = self.module.unique(&name);
        let inputs = inputs.into_iter().map(|(port, bits)| (port.to_owned(), Direction::Input, bits));
        let outputs = outputs.into_iter().map(|(port, bits)| (port.to_owned(), Direction::Output, bits));
        let attributes = self.source.iter().map(|s| ("src", s.clone())).collect();
        self.module.cells.push(Cell {
            name,
            kind: kind.to_owned(),
            hidden: !part.is_empty(),
            attributes,
            parameters,
            connections: inputs.chain(outputs).collect(),
        });
        let last = self.module.cells.len() - 1;
        &mut self.module.cells[last]
    }

    /// A cell of one operand.
    pub fn unary(&mut self, part: &str, kind: &str, a: &[Bit], y: Bits) -> &mut Cell {
        let parameters = vec![
            ("A_SIGNED", Setting::Number(0)),
            ("A_WIDTH", Setting::Number(a.len() as u32)),
            ("Y_WIDTH", Setting::Number(y.len() as u32)),
        ];
        self.put(part, kind, parameters, vec![("A", a.to_vec())], vec![("Y", y)])
    }

    /// A cell of two operands.
    pub fn binary(&mut self, part: &str, kind: &str, a: &[Bit], b: &[Bit], y: Bits) {
        self.signed(part, kind, (false, a), (false, b), y);
    }

    /// A cell of two operands that may be in two's complement.
    pub fn signed(&mut self, part: &str, kind: &str, a: (bool, &[Bit]), b: (bool, &[Bit]), y: Bits) {
        let parameters = vec![
            ("A_SIGNED", Setting::Number(u32::from(a.0))),
            ("B_SIGNED", Setting::Number(u32::from(b.0))),
            ("A_WIDTH", Setting::Number(a.1.len() as u32)),
            ("B_WIDTH", Setting::Number(b.1.len() as u32)),
            ("Y_WIDTH", Setting::Number(y.len() as u32)),
        ];
        self.put(part, kind, parameters, vec![("A", a.1.to_vec()), ("B", b.1.to_vec())], vec![("Y", y)]);
    }

    /// A gate of one kind between as many inputs of `y`'s width as there are.
    pub fn chain(&mut self, part: &str, kind: &str, inputs: &[&[Bit]], y: Bits) {
        if let [only] = inputs {
            self.unary(part, "$pos", only, y);
            return;
        }
        let mut joined = inputs[0].to_vec();
        for (i, input) in inputs.iter().enumerate().skip(1) {
            let last = i + 1 == inputs.len();
            let step = if part.is_empty() { format!("{}", i - 1) } else { format!("{part}{}", i - 1) };
            let next = if last { y.clone() } else { self.fresh(&step, y.len()) };
            self.binary(if last { part } else { &step }, kind, &joined, input, next.clone());
            joined = next;
        }
    }

    /// `b` where the select is 1, else `a`.
    pub fn mux(&mut self, part: &str, a: &[Bit], b: &[Bit], select: Bit, y: Bits) {
        let width = vec![("WIDTH", Setting::Number(y.len() as u32))];
        self.put(part, "$mux", width, vec![("A", a.to_vec()), ("B", b.to_vec()), ("S", vec![select])], vec![("Y", y)]);
    }

    /// Whether a bit is 1: 0 where it is unknown.
    pub fn is_one(&mut self, part: &str, bit: Bit) -> Bit {
        let y = self.fresh(part, 1);
        self.binary(part, "$eqx", &[bit], &[ONE], y.clone());
        y[0]
    }

    /// Gives a bit that is 1 where one of these is; none of them where there is none.
    pub fn any(&mut self, part: &str, of: &[Bit]) -> Option<Bit> {
        let mut any = *of.first()?;
        for (i, &bit) in of.iter().enumerate().skip(1) {
            let step = if i == 1 { part.to_owned() } else { format!("{part}{i}") };
            let y = self.fresh(&step, 1);
            self.binary(&step, "$or", &[any], &[bit], y.clone());
            any = y[0];
        }
        Some(any)
    }

    /// Says what the state of the cell holds at the start.
    fn init(&mut self, q: &[Bit], value: &Value) {
        if value.bits().any(|b| b != Logic::X) {
            self.inits.push((self.name.clone(), q.to_vec(), value.clone()));
        }
    }

    /// Puts the states at the start where Yosys has them: with the nets.
    pub fn finish(mut self) -> Module {
        for (name, bits, value) in std::mem::take(&mut self.inits) {
            let nets = &mut self.module.nets;
            let text = value.bit_string();
            if let Some(net) = nets.iter_mut().find(|n| n.bits == bits && n.attributes.iter().all(|a| a.0 != "init")) {
                net.attributes.push(("init", text));
                continue;
            }
            let name = self.module.unique(&format!("{name}$q"));
            let attributes = vec![("init", text)];
            self.module.nets.push(Net { name, bits, hidden: true, signed: false, values: None, attributes });
        }
        self.module
    }

    /// A pin that is not connected, or that a constant makes inactive, is none.
    pub fn active(pin: &[Bit]) -> Option<Bit> {
        pin.first().copied().filter(|&bit| bit != ZERO)
    }
}
