//! What is written: modules, ports, cells, nets and their bits, as `write_json` has them, and the text of it.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::netlist::{Direction, ValueNames};
use crate::{Logic, Value};

/// A bit of a module: one of a net, by its number, or a constant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Bit {
    /// A bit of a net.
    Net(u32),
    /// A constant.
    Constant(Logic),
}

/// Some bits, the least significant first.
pub type Bits = Vec<Bit>;

/// The bits of a value.
pub fn constant(value: &Value) -> Bits {
    (0..value.width()).map(|i| Bit::Constant(value.bit(i))).collect()
}

/// What a parameter is set to.
#[derive(Clone, PartialEq, Debug)]
pub enum Setting {
    /// A number, of 32 bits.
    Number(u32),
    /// Bits.
    Value(Value),
    /// Text.
    Text(String),
}

/// A port of a module.
pub struct Port {
    pub name: String,
    pub direction: Direction,
    pub bits: Bits,
    pub signed: bool,
}

/// A cell.
pub struct Cell {
    pub name: String,
    pub kind: String,
    pub hidden: bool,
    pub attributes: Vec<(&'static str, String)>,
    pub parameters: Vec<(&'static str, Setting)>,
    pub connections: Vec<(String, Direction, Bits)>,
}

/// A named vector of bits.
pub struct Net {
    pub name: String,
    pub bits: Bits,
    pub hidden: bool,
    pub signed: bool,
    /// What its values are called.
    pub values: Option<Arc<ValueNames>>,
    pub attributes: Vec<(&'static str, String)>,
}

/// A module.
#[derive(Default)]
pub struct Module {
    pub name: String,
    pub attributes: Vec<(&'static str, String)>,
    pub ports: Vec<Port>,
    pub cells: Vec<Cell>,
    pub nets: Vec<Net>,
    /// Names of cells and nets, which are of one kind to Yosys.
    pub names: HashSet<String>,
    /// The first number that is free.
    pub free: u32,
}

impl Module {
    /// A module whose bits have numbers from 2 on, as Yosys begins them, up to `free`.
    pub fn new(name: &str, free: u32) -> Module {
        Module { name: name.to_owned(), free: free.max(2), ..Module::default() }
    }

    /// A name that nothing has yet, made of this one.
    pub fn unique(&mut self, name: &str) -> String {
        let name: String = name.chars().map(|c| if c.is_whitespace() { '_' } else { c }).collect();
        let numbered = (2..).map(|n| format!("{name}${n}"));
        let name = std::iter::once(name.clone()).chain(numbered).find(|n| !self.names.contains(n));
        let name = name.unwrap_or_default();
        self.names.insert(name.clone());
        name
    }
}

fn quoted(text: &str) -> String {
    crate::safe::json(&serde_json::Value::from(text).to_string()).into_owned()
}

/// A string attribute or parameter; one that could be taken for bits gets a space.
fn guarded(text: &str) -> String {
    let like_bits = text.trim_end_matches(' ').bytes().all(|b| b"01xz".contains(&b));
    quoted(&if like_bits { format!("{text} ") } else { text.to_owned() })
}

fn bits(bits: &[Bit]) -> String {
    let mut text = String::from("[ ");
    for (i, bit) in bits.iter().enumerate() {
        if i > 0 {
            text += ", ";
        }
        match bit {
            Bit::Net(number) => _ = write!(text, "{number}"),
            Bit::Constant(logic) => _ = write!(text, "\"{logic}\""),
        }
    }
    text + if bits.is_empty() { "]" } else { " ]" }
}

/// An object, its members already written, indented.
fn object(indent: usize, members: impl Iterator<Item = (String, String)>) -> String {
    let (inner, outer) = (" ".repeat(indent + 2), " ".repeat(indent));
    let members: Vec<String> = members.map(|(key, value)| format!("\n{inner}{}: {value}", quoted(&key))).collect();
    if members.is_empty() { "{}".to_owned() } else { format!("{{{}\n{outer}}}", members.join(",")) }
}

fn attributes(list: &[(&'static str, String)]) -> impl Iterator<Item = (String, String)> {
    list.iter().map(|(key, value)| {
        // what Yosys has as bits
        let is_bits = matches!(*key, "top" | "blackbox" | "init");
        ((*key).to_owned(), if is_bits { quoted(value) } else { guarded(value) })
    })
}

const fn direction(way: Direction) -> &'static str {
    match way {
        Direction::Input => "\"input\"",
        Direction::Output => "\"output\"",
        Direction::Inout => "\"inout\"",
    }
}

impl Port {
    fn text(&self) -> String {
        let signed = if self.signed { ",\n          \"signed\": 1" } else { "" };
        let way = direction(self.direction);
        format!("{{\n          \"direction\": {way},\n          \"bits\": {}{signed}\n        }}", bits(&self.bits))
    }
}

impl Cell {
    fn text(&self) -> String {
        let parameters = self.parameters.iter().map(|(name, setting)| {
            let text = match setting {
                Setting::Number(n) => format!("\"{n:032b}\""),
                Setting::Text(text) => guarded(text),
                Setting::Value(value) => format!("\"{}\"", value.bit_string()),
            };
            ((*name).to_owned(), text)
        });
        let ways = self.connections.iter().map(|(name, way, _)| (name.clone(), direction(*way).to_owned()));
        let wires = self.connections.iter().map(|(name, _, to)| (name.clone(), bits(to)));
        let members = [
            ("hide_name", u8::from(self.hidden).to_string()),
            ("type", quoted(&self.kind)),
            ("parameters", object(10, parameters)),
            ("attributes", object(10, attributes(&self.attributes))),
            ("port_directions", object(10, ways)),
            ("connections", object(10, wires)),
        ];
        object(8, members.into_iter().map(|(key, value)| (key.to_owned(), value)))
    }
}

impl Net {
    fn text(&self) -> String {
        let values = self.values.iter().flat_map(|names| names.iter());
        // as Yosys has the values of an enumeration, names with their backslash
        let values = values.map(|(v, name)| (format!("enum_value_{}", v.bit_string()), quoted(&format!("\\{name}"))));
        let mut members = vec![
            ("hide_name", u8::from(self.hidden).to_string()),
            ("bits", bits(&self.bits)),
            ("attributes", object(10, attributes(&self.attributes).chain(values))),
        ];
        if self.signed {
            members.push(("signed", "1".to_owned()));
        }
        object(8, members.into_iter().map(|(key, value)| (key.to_owned(), value)))
    }
}

impl Module {
    fn text(&self) -> String {
        let members = [
            ("attributes", object(6, attributes(&self.attributes))),
            ("ports", object(6, self.ports.iter().map(|p| (p.name.clone(), p.text())))),
            ("cells", object(6, self.cells.iter().map(|c| (c.name.clone(), c.text())))),
            ("netnames", object(6, self.nets.iter().map(|n| (n.name.clone(), n.text())))),
        ];
        object(4, members.into_iter().map(|(key, value)| (key.to_owned(), value)))
    }
}

/// The text of a file.
pub fn text(modules: &[Module]) -> String {
    let modules = object(2, modules.iter().map(|m| (m.name.clone(), m.text())));
    let creator = quoted(&format!("discreta {}", env!("CARGO_PKG_VERSION")));
    object(0, [("creator".to_owned(), creator), ("modules".to_owned(), modules)].into_iter()) + "\n"
}
