//! The documentation of the elements, taken at its word: the tables against `evaluate` and `clocked`, the examples by
//! loading them.

use discreta::Value;
use discreta::cell::element::Kind;
use discreta::cell::{self, Argument, Arguments, CellKind, Element, Memory, elements};
use discreta::netlist::Cell;
use discreta::value::Word;
use discreta::value::word::words;
use serde_json::{Map, json};

use crate::support::engines::simulator;
use crate::support::{folder, load};

/// The value of every name in the examples' expressions.
const PARAMETER: i64 = 8;

/// An element with some of its parameters given, the others at their defaults.
fn build(element: &Element, given: &[(&str, &str)], inputs: u32) -> CellKind {
    let text = |name: &str, default: Option<&'static str>| {
        let given = given.iter().find(|(n, _)| *n == name).map(|g| g.1.to_string());
        given.or(default.map(str::to_string)).unwrap_or_else(|| panic!("{}: {name}", element.name))
    };
    let integer = |text: String| text.parse().unwrap_or(PARAMETER);
    let width = element.parameters.iter().find(|p| p.name == "width");
    let width = width.map_or(1, |p| integer(text(p.name, p.default)) as u32);
    let argument = |name, kind, default| match (kind, text(name, default)) {
        (Kind::Integer { .. }, text) => Argument::Integer(integer(text)),
        (Kind::Word(_), text) => Argument::Word(text),
        (Kind::Value, text) if text == "all-ones" => Argument::Value(Value::repeat(discreta::Logic::One, width)),
        (Kind::Value, text) => Argument::Value(Value::for_width(&text, width).unwrap()),
        (Kind::Contents, _) => Argument::Contents(Memory::contents(width, PARAMETER as u32).into()),
        (Kind::Quantity, _) => Argument::Quantity(0.5), // no test here depends on it
    };
    let values = element.parameters.iter().map(|p| (p.name, argument(p.name, p.kind, p.default))).collect();
    (element.build)(&Arguments { values, inputs, tick: 1e-9 }).unwrap()
}

fn value(text: &str) -> Value {
    format!("{}'b{text}", text.len()).parse().unwrap()
}

/// The pins of a cell, all 0 (enables 1) until set.
struct Bench<'e> {
    element: &'e Element,
    kind: CellKind,
    pins: Vec<Value>,
}

impl<'e> Bench<'e> {
    fn new(element: &'e Element, kind: CellKind) -> Bench<'e> {
        let rest = |(i, pin): (usize, &cell::Pin)| Value::from_u64(u64::from(pin.default), kind.input_width(i));
        let pins = kind.inputs().iter().enumerate().map(rest).collect();
        Bench { element, kind, pins }
    }

    /// Sets the pin of a port.
    fn set(&mut self, port: &str, bits: &str) {
        let pin = self.element.ports.iter().find(|p| p.name == port).unwrap_or_else(|| panic!("no port {port}")).pin;
        let index = self.kind.inputs().iter().position(|p| p.name == pin).unwrap();
        assert_eq!(self.pins[index].width() as usize, bits.len(), "{port}");
        self.pins[index] = value(bits);
    }

    fn run<T>(&self, f: impl FnOnce(&[&[Word]]) -> T) -> T {
        let pins: Vec<Vec<Word>> = self.pins.iter().map(|v| v.words().collect()).collect();
        f(&pins.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// The output of a name without a clock edge, where the state was `q`.
    fn output(&self, name: &str, q: &str) -> String {
        let index = self.kind.outputs().iter().position(|&o| o == name).unwrap_or_else(|| panic!("no output {name}"));
        let width = |i| self.kind.output_width(i);
        let mut outs: Vec<Vec<Word>> =
            (0..self.kind.outputs().len()).map(|i| vec![Word::ZERO; words(width(i))]).collect();
        if !q.is_empty() {
            outs[0] = value(q).words().collect();
        }
        let mut slices: Vec<&mut [Word]> = outs.iter_mut().map(Vec::as_mut_slice).collect();
        self.run(|pins| cell::evaluate(&self.kind, pins, &mut slices));
        Value::from_words(&outs[index], width(index)).bit_string()
    }

    /// The state after an active edge.
    fn edge(&self, q: &str) -> String {
        let old: Vec<Word> = value(q).words().collect();
        let mut next = old.clone();
        self.run(|pins| cell::clocked(&self.kind, pins, &old, &mut next));
        Value::from_words(&next, q.len() as u32).bit_string()
    }
}

/// A table of a `meaning`: its rows, the heading first, without marks.
type Table = Vec<Vec<String>>;

fn tables(meaning: &str) -> Vec<Table> {
    let mut tables: Vec<Table> = Vec::new();
    let mut inside = false;
    for line in meaning.lines() {
        let Some(cells) = line.strip_prefix('|').and_then(|l| l.strip_suffix('|')) else {
            inside = false;
            continue;
        };
        if !inside {
            tables.push(Vec::new());
            inside = true;
        }
        if cells.starts_with("---") {
            continue;
        }
        let cell = |c: &str| c.trim().replace("**", "").replace('`', "");
        tables.last_mut().unwrap().push(cells.split('|').map(cell).collect());
    }
    tables
}

/// A gate: both inputs by row and column.
fn binary(element: &Element, table: &Table) {
    let mut bench = Bench::new(element, build(element, &[], 2));
    assert_eq!((table.len(), table[0].len()), (5, 5));
    for row in &table[1..] {
        for (b, y) in table[0].iter().zip(row).skip(1) {
            for (x, z) in [(&row[0], b), (b, &row[0])] {
                bench.set("in", &format!("{z}{x}"));
                assert_eq!(&bench.output("y", ""), y, "{} of {x} and {z}", element.name);
            }
        }
    }
}

/// A heading of input pins and their bits, a row of output pins and theirs.
fn bits(element: &Element, table: &Table) {
    let (ins, outs): (Vec<&str>, Vec<&str>) = (table[0][0].split(' ').collect(), table[1][0].split(' ').collect());
    for dominant in ["reset", "set"] {
        let mut bench = Bench::new(element, build(element, &[("dominant", dominant)], 2));
        for (column, expected) in table[0].iter().zip(&table[1]).skip(1) {
            for (pin, bit) in ins.iter().zip(column.chars()) {
                bench.set(pin, &bit.to_string());
            }
            for q in ["0", "1", "x"] {
                let expected: Vec<String> = match expected.as_str() {
                    "holds" => vec![q.into()],
                    "0, or 1 where set is dominant" => vec![u8::from(dominant == "set").to_string()],
                    bits => bits.chars().map(String::from).collect(),
                };
                assert_eq!(expected.len(), outs.len());
                for (out, expected) in outs.iter().zip(&expected) {
                    assert_eq!(&bench.output(out, q), expected, "{} {column}, {out}", element.name);
                }
            }
        }
    }
}

/// A select or enable, and what comes of each value of it.
fn by_control(element: &Element, table: &Table) {
    let mut bench = Bench::new(element, build(element, &[("width", "4")], 2));
    let (a, b) = ("01xz", "0101");
    let data = if element.name == "mux" { ("in", format!("{b}{a}")) } else { ("a", a.to_string()) };
    bench.set(data.0, &data.1);
    for (control, expected) in table[0].iter().zip(&table[1]).skip(1) {
        let expected = match expected.as_str() {
            "in[0]" | "a" => a,
            "in[1]" => b,
            "in[0] where in[0] = in[1], else x" => "01xx",
            "z" => "zzzz",
            "x" => "xxxx",
            other => panic!("{}: {other}", element.name),
        };
        for control in control.split(", ") {
            bench.set(&table[0][0], control);
            assert_eq!(bench.output("y", ""), expected, "{} with {} = {control}", element.name, table[0][0]);
        }
    }
}

const Q: &str = "0101";
const D: &str = "1x10";
const RESET_VALUE: &str = "0011";
const SET_VALUE: &str = "1100";

fn stored(element: &Element) -> Bench<'_> {
    let (reset, set) = (format!("4'b{RESET_VALUE}"), format!("4'b{SET_VALUE}"));
    let given = [("width", "4"), ("reset_value", &reset), ("set_value", &set), ("step", "3")];
    let mut bench = Bench::new(element, build(element, &given, 0));
    bench.set("d", D);
    bench
}

/// A latch: controls by column, – for any.
fn by_level(element: &Element, table: &Table) {
    let mut bench = stored(element);
    for row in &table[1..] {
        let (q, controls) = row.split_last().unwrap();
        let expected = match q.as_str() {
            "reset_value" => RESET_VALUE,
            "set_value" => SET_VALUE,
            "d" => D,
            "holds" => Q,
            other => panic!("{other}"),
        };
        for choice in 0..4usize.pow(controls.len() as u32) {
            for (k, (pin, level)) in table[0].iter().zip(controls).enumerate() {
                let any = ["0", "1", "x", "z"][choice / 4usize.pow(k as u32) % 4];
                // an unknown control counts as inactive
                let level = match level.as_str() {
                    "–" => any,
                    "0" if any != "1" => any,
                    level => level,
                };
                bench.set(pin, level);
            }
            assert_eq!(bench.output("q", Q), expected, "{}: {row:?}", element.name);
        }
    }
}

/// A clocked cell: the first line that applies, for every combination of controls.
fn by_line(element: &Element, table: &Table) {
    let mut bench = stored(element);
    let controls: Vec<&str> =
        element.ports.iter().filter(|p| !p.output && !["clk", "d"].contains(&p.name)).map(|p| p.name).collect();
    let mut used = vec![0; table.len()];
    for choice in 0..4usize.pow(controls.len() as u32) {
        let level = |k: usize| ["0", "1", "x", "z"][choice / 4usize.pow(k as u32) % 4];
        let is = |pin: &str| level(controls.iter().position(|c| *c == pin).unwrap_or_else(|| panic!("no {pin}")));
        if controls.contains(&"down") && !["0", "1"].contains(&is("down")) {
            continue; // told of in the text
        }
        controls.iter().enumerate().for_each(|(k, pin)| bench.set(pin, level(k)));
        for edge in [false, true] {
            let applies = |row: &&Vec<String>| {
                row[0].split(", ").all(|condition| match condition {
                    "active edge" => edge,
                    "otherwise" => true,
                    level => is(level.strip_suffix(" = 1").unwrap()) == "1",
                })
            };
            let line = table[1..].iter().position(|row| applies(&row)).unwrap() + 1;
            used[line] += 1;
            let expected = match table[line][1].trim_end_matches(", at once") {
                "reset_value" => RESET_VALUE,
                "set_value" => SET_VALUE,
                "0" => "0000",
                "d" => D,
                "holds" => Q,
                "q + step, or q - step while down = 1, modulo 2^width" if is("down") == "1" => "0010",
                "q + step, or q - step while down = 1, modulo 2^width" => "1000",
                other => panic!("{}: {other}", element.name),
            };
            let levels: Vec<_> = controls.iter().map(|c| (c, is(c))).collect();
            // at an edge the levels act too, before it and after it
            let q = if edge { bench.edge(&bench.output("q", Q)) } else { bench.output("q", Q) };
            assert_eq!(q, expected, "{}: {levels:?}, edge {edge}: {:?}", element.name, table[line]);
        }
    }
    assert!(used[1..].iter().all(|&n| n > 0), "{}: a line that never applies", element.name);
}

#[test]
fn the_tables_are_true() {
    let mut checked = 0;
    for element in elements() {
        for table in tables(element.meaning) {
            let heading: Vec<&str> = table[0].iter().map(String::as_str).collect();
            match heading[..] {
                [gate, "0", "1", "x", "z"] if gate == element.name.to_uppercase() => binary(element, &table),
                ["a", "0", "1", "x", "z"] | ["a b" | "s r", "00", ..] | ["a b ci" | "a b c", "000", ..] => {
                    bits(element, &table)
                }
                ["s" | "en", "0", "1", "x, z"] => by_control(element, &table),
                [.., "en", "q"] => by_level(element, &table),
                ["when", "q"] => by_line(element, &table),
                _ => panic!("{}: no test reads the table {heading:?}", element.name),
            }
            checked += 1;
        }
    }
    assert!(checked >= 15, "only {checked} tables were found");
}

/// The names of the nets in a signal, and whether each is indexed.
fn nets(signal: &serde_json::Value) -> Vec<(String, bool)> {
    match signal {
        serde_json::Value::String(text) => {
            let name = text.split('[').next().unwrap();
            vec![(name.to_string(), text.contains('['))]
        }
        serde_json::Value::Array(list) => list.iter().flat_map(nets).collect(),
        _ => vec![],
    }
}

#[test]
fn the_examples_load_and_run() {
    let folder = folder("examples_of_elements");
    for element in elements() {
        let text = element.example.replace("NAME", element.name);
        let cell: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", element.name));
        assert_eq!(cell["type"], element.name);
        let connections = cell["connections"].as_object().unwrap();
        let given: Vec<(String, String)> = match cell["parameters"].as_object() {
            Some(map) => map.iter().map(|(n, v)| (n.clone(), v.to_string().trim_matches('"').into())).collect(),
            None => vec![],
        };
        let given: Vec<(&str, &str)> = given.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect();
        let several = connections.get("in").map_or(0, |list| list.as_array().unwrap().len() as u32);
        let kind = build(element, &given, several);
        // of all names of a kind `element` tells one
        assert_eq!(kind.element(), if element.name == "register" { "dff" } else { element.name });
        let (mut inputs, mut outputs) = (Map::new(), Map::new());
        for (name, signal) in connections {
            let port = element.ports.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("{text}: no {name}"));
            let width = if port.output {
                kind.output_width(kind.outputs().iter().position(|o| *o == port.pin).unwrap())
            } else {
                let width = kind.input_width(kind.inputs().iter().position(|p| p.name == port.pin).unwrap());
                // a concatenation is one of single bits
                if port.several { width / several } else { width / signal.as_array().map_or(1, |a| a.len() as u32) }
            };
            for (net, indexed) in nets(signal) {
                let width = if indexed { PARAMETER + 1 } else { i64::from(width) };
                if port.output { &mut outputs } else { &mut inputs }.insert(net, json!(width));
            }
        }
        // what is both is a ripple chain, whose first bit someone has to drive
        let chains: Vec<String> = inputs.keys().filter(|n| outputs.contains_key(*n)).cloned().collect();
        let mut cells = Map::from_iter([("example".to_string(), cell)]);
        let mut internal = Map::new();
        for chain in chains {
            inputs.remove(&chain);
            internal.insert(chain.clone(), outputs.remove(&chain).unwrap());
            let first = json!({ "type": "buf", "connections": { "a": "1'b0", "y": format!("{chain}[0]") } });
            cells.insert(format!("drive_{chain}"), first);
        }
        let port =
            |direction: &'static str| move |(name, width)| (name, json!({ "direction": direction, "width": width }));
        let partly = |(_, width): &(String, serde_json::Value)| *width == json!(PARAMETER + 1);
        // an output of which the example drives but some bits is a net, or the others would be missed
        let (partial, outputs): (Vec<_>, Vec<_>) = outputs.into_iter().partition(partly);
        internal.extend(partial);
        let ports: Map<_, _> =
            inputs.into_iter().map(port("input")).chain(outputs.into_iter().map(port("output"))).collect();
        let module = json!({ "parameters": { "W": PARAMETER, "P": PARAMETER },
                             "ports": ports, "nets": internal, "cells": cells });
        let circuit = load(&folder, element.name, &json!({ "modules": { "example": module } }))
            .unwrap_or_else(|e| panic!("the example of {}:\n{e}", element.name));
        simulator(&circuit.netlist).settle().unwrap_or_else(|e| panic!("{}: {e}", element.name));
        let same = |c: &Cell| std::mem::discriminant(&c.kind) == std::mem::discriminant(&kind);
        assert!(circuit.netlist.cells().iter().any(same), "the example of {} makes none", element.name);
    }
}
