//! The circuit file as serde types: what an author wrote, with places. The comments on fields become the descriptions
//! in the JSON Schema.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::expr::Expr;
use super::expr_parser::is_name;
use super::reference::Signal;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};
use crate::json::{self, Recover, Spanned};
use crate::scenario::{Simulation, Timescale};

/// A name or other word, and where it stands.
pub type Name = Spanned<String>;

/// A circuit file. [`CircuitFile::parse`] reads it; serde_json cannot, since it does not know places.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CircuitFile {
    /// Where an editor finds the schema.
    #[serde(rename = "$schema", default, deserialize_with = "json::or_default")]
    pub schema: Option<String>,
    /// Free text: what the file is about.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// One tick: `1`, `10` or `100` of `s`, `ms`, `us`, `ns`, `ps` or `fs`. Default `1ns`.
    #[serde(default, deserialize_with = "json::or_default")]
    pub timescale: Option<Spanned<Timescale>>,
    /// Other circuit files, relative to this one, whose modules can be used here.
    #[serde(default, deserialize_with = "json::every")]
    pub import: Vec<Spanned<String>>,
    /// The module that is run. Default: the only one that no other module of the file uses.
    #[serde(default, deserialize_with = "json::or_default")]
    pub top: Option<Name>,
    /// The modules by name.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub modules: IndexMap<Name, Recover<Module>>,
    /// The default scenario.
    pub simulation: Option<Recover<Simulation>>,
}

/// What names are, for the schema.
const NAME_PATTERN: &str = "^[A-Za-z_][A-Za-z0-9_$]*$";

/// A module: a circuit with ports, made of cells.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Module {
    /// Free text: what the module does.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// Codes of warnings that this module gives on purpose, e.g. `combinational-loop`.
    #[serde(default, deserialize_with = "json::every")]
    pub allow: Vec<Spanned<String>>,
    /// Integers that whoever uses the module may set.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub parameters: IndexMap<Name, Recover<Parameter>>,
    /// Where it is connected to what is outside.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub ports: IndexMap<Name, Recover<Port>>,
    /// The nets inside, by name: a width, or an object.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub nets: IndexMap<Name, Recover<Net>>,
    /// Elements and other modules that it is made of.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub cells: IndexMap<Name, Recover<Cell>>,
    /// Groups of nets, cells and blocks that are repeated or conditional.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub blocks: IndexMap<Name, Recover<Block>>,
}

/// A group of nets, cells and blocks that is repeated or conditional, and a scope in the waveform.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// Makes copies: `{ "i": 8 }` with `i` from 0 to 7, or `{ "i": [1, 8] }` from 1 to 7.
    pub repeat: Option<Repeat>,
    /// The block exists only if this is not 0; it may use the index of `repeat`.
    #[serde(rename = "if")]
    pub condition: Option<Expr>,
    /// The nets inside; their names hide those outside.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub nets: IndexMap<Name, Recover<Net>>,
    /// The cells inside.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub cells: IndexMap<Name, Recover<Cell>>,
    /// The blocks inside.
    #[serde(default)]
    #[schemars(extend("propertyNames" = { "pattern": NAME_PATTERN }))]
    pub blocks: IndexMap<Name, Recover<Block>>,
}

/// An integer with a default.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(with = "ParameterForm")]
pub struct Parameter {
    /// The value if nothing sets it; it may use the parameters before it.
    pub default: Expr,
    /// The smallest value allowed.
    pub min: Option<Expr>,
    /// The largest value allowed.
    pub max: Option<Expr>,
    /// Free text: what it means, and its unit.
    pub doc: Option<String>,
}

/// A parameter: its default, or an object.
#[derive(Deserialize, JsonSchema)]
#[serde(rename = "$discreta::Kind an integer, an expression or an object", rename_all = "lowercase")]
#[schemars(rename = "Parameter", untagged)]
enum ParameterForm {
    Integer(Expr),
    #[schemars(skip)]
    String(Expr),
    Object(ParameterObject),
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ParameterObject {
    /// The value if nothing sets it; it may use the parameters before it.
    default: Expr,
    /// The smallest value allowed.
    min: Option<Expr>,
    /// The largest value allowed.
    max: Option<Expr>,
    /// Free text: what it means, and its unit.
    #[serde(default, deserialize_with = "json::or_default")]
    doc: Option<String>,
}

impl<'de> Deserialize<'de> for Parameter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match ParameterForm::deserialize(deserializer)? {
            ParameterForm::Integer(default) | ParameterForm::String(default) => {
                Parameter { default, min: None, max: None, doc: None }
            }
            ParameterForm::Object(ParameterObject { default, min, max, doc }) => Parameter { default, min, max, doc },
        })
    }
}

/// Which way a port's values go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Into the module.
    Input,
    /// Out of the module.
    Output,
    /// Both, as on a tri-state bus.
    Inout,
}

impl Direction {
    /// As it is written in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Direction::Input => "input",
            Direction::Output => "output",
            Direction::Inout => "inout",
        }
    }
}

/// A port of a module.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// `input`, `output` or `inout`.
    pub direction: Spanned<Direction>,
    /// How many bits. Default 1.
    pub width: Option<Expr>,
    /// Whether viewers show it in two's complement.
    #[serde(default)]
    pub signed: bool,
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
}

/// A net inside of a module or block.
#[derive(Debug, Clone, Default, JsonSchema)]
#[schemars(with = "NetForm")]
pub struct Net {
    /// How many bits. Default 1.
    pub width: Option<Expr>,
    /// Whether viewers show it in two's complement.
    pub signed: bool,
    /// Free text.
    pub doc: Option<String>,
}

/// A net: its width, or an object.
#[derive(Deserialize, JsonSchema)]
#[serde(rename = "$discreta::Kind a width (an integer or an expression) or an object", rename_all = "lowercase")]
#[schemars(rename = "Net", untagged)]
enum NetForm {
    Integer(Expr),
    #[schemars(skip)]
    String(Expr),
    Object(NetObject),
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NetObject {
    /// How many bits. Default 1.
    width: Option<Expr>,
    /// Whether viewers show it in two's complement.
    #[serde(default)]
    signed: bool,
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    doc: Option<String>,
}

impl<'de> Deserialize<'de> for Net {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match NetForm::deserialize(deserializer)? {
            NetForm::Integer(width) | NetForm::String(width) => Net { width: Some(width), signed: false, doc: None },
            NetForm::Object(NetObject { width, signed, doc }) => Net { width, signed, doc },
        })
    }
}

/// An element or another module as a part of this one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// An element, or a module of this file or of an imported one.
    #[serde(rename = "type")]
    pub kind: Name,
    /// Values of its parameters: expressions; some elements also take words.
    #[serde(default, deserialize_with = "json::every")]
    pub parameters: IndexMap<Name, ParameterValue>,
    /// What its ports are connected to.
    #[serde(default, deserialize_with = "json::every")]
    pub connections: IndexMap<Name, Signal>,
    /// Makes copies `name[0]`, `name[1]`, …: `{ "i": 8 }` with `i` from 0 to 7, or `{ "i": [1, 8] }` from 1 to 7.
    pub repeat: Option<Repeat>,
    /// The cell exists only if this is not 0; it may use the index of `repeat`.
    #[serde(rename = "if")]
    pub condition: Option<Expr>,
}

/// What a cell sets a parameter to.
pub type ParameterValue = Spanned<ParameterText>;

/// A number, or a text that is an expression or a word: which of them, the cell's type says.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename = "$discreta::Kind an integer, an expression or a word", rename_all = "lowercase")]
#[schemars(rename = "ParameterValue", untagged)]
pub enum ParameterText {
    /// A JSON number.
    Integer(i64),
    /// A JSON string.
    String(String),
}

impl Spanned<ParameterText> {
    /// The value as an expression.
    ///
    /// # Errors
    /// If the text is none.
    pub fn expr(&self) -> Result<Expr, Diagnostic> {
        match &self.value {
            ParameterText::Integer(n) => Ok(Expr::number(*n, self.span)),
            ParameterText::String(text) => Expr::parse(text, self.span),
        }
    }

    /// The text, unless it is a number.
    #[must_use]
    pub fn word(&self) -> Option<&str> {
        match &self.value {
            ParameterText::Integer(_) => None,
            ParameterText::String(text) => Some(text),
        }
    }
}

/// Copies counted by an index.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeat {
    /// The name of the index.
    pub index: Name,
    /// Its first value; 0 if not given.
    pub from: Option<Expr>,
    /// The value after its last one.
    pub to: Expr,
    /// Where the whole stands.
    pub span: Span,
}

#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind a count (an integer or an expression) or [from, to]", rename_all = "lowercase")]
enum Range {
    Integer(Expr),
    String(Expr),
    Array(Ends),
}

#[derive(Deserialize)]
struct Ends(#[serde(deserialize_with = "json::every")] Vec<Expr>);

impl<'de> Deserialize<'de> for Repeat {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Indices(#[serde(deserialize_with = "json::every")] IndexMap<Name, Spanned<Range>>);

        let Spanned { value: Indices(indices), span } = Spanned::deserialize(deserializer)?;
        let fault = |message: &str, span| Diagnostic::new(Code::BadRepeat, message).at(span, "");
        let mut indices = indices.into_iter();
        let Some((index, range)) = indices.next() else {
            return Err(json::fault(
                fault("a `repeat` names no index", span).help("write the index and its count: { \"i\": 8 }"),
            ));
        };
        if let Some((second, _)) = indices.next() {
            return Err(json::fault(
                fault("a `repeat` names one index only", second.span).help("put a block with one into the other"),
            ));
        }
        let (from, to) = match range.value {
            Range::Integer(to) | Range::String(to) => (None, to),
            Range::Array(Ends(ends)) => match <[Expr; 2]>::try_from(ends) {
                Ok([from, to]) => (Some(from), to),
                Err(_) => {
                    return Err(json::fault(
                        fault("a range is [from, to]", range.span).note("it counts from the first to the last but one"),
                    ));
                }
            },
        };
        Ok(Repeat { index, from, to, span })
    }
}

impl JsonSchema for Repeat {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Repeat".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let expression = generator.subschema_for::<Expr>();
        schemars::json_schema!({
            "description": "One index and its count, `{ \"i\": 8 }`, or its range, `{ \"i\": [1, 8] }`.",
            "type": "object",
            "propertyNames": { "pattern": NAME_PATTERN },
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": {
                "anyOf": [expression.clone(), { "type": "array", "items": expression, "minItems": 2, "maxItems": 2 }]
            }
        })
    }
}

impl CircuitFile {
    /// Reads a circuit file. All faults go into `diagnostics`; parts of the file that are faulty are `None` in it.
    #[must_use]
    pub fn parse(sources: &Sources, file: FileId, diagnostics: &mut Diagnostics) -> Option<CircuitFile> {
        let circuit: CircuitFile = json::parse(sources, file, diagnostics)?;
        for (name, module) in &circuit.modules {
            check_name(name, "module", diagnostics);
            let Some(module) = module.as_ref() else { continue };
            module.parameters.keys().for_each(|n| check_name(n, "parameter", diagnostics));
            module.ports.keys().for_each(|n| check_name(n, "port", diagnostics));
            check_scope(&module.nets, &module.cells, &module.blocks, diagnostics);
        }
        if let Some(simulation) = circuit.simulation.as_ref().and_then(Recover::as_ref) {
            simulation.check(diagnostics);
        }
        Some(circuit)
    }
}

fn check_scope(
    nets: &IndexMap<Name, Recover<Net>>,
    cells: &IndexMap<Name, Recover<Cell>>,
    blocks: &IndexMap<Name, Recover<Block>>,
    diagnostics: &mut Diagnostics,
) {
    nets.keys().for_each(|n| check_name(n, "net", diagnostics));
    for (name, cell) in cells {
        check_name(name, "cell", diagnostics);
        if let Some(Cell { repeat: Some(repeat), .. }) = cell.as_ref() {
            check_name(&repeat.index, "index", diagnostics);
        }
    }
    for (name, block) in blocks {
        check_name(name, "block", diagnostics);
        let Some(block) = block.as_ref() else { continue };
        if let Some(repeat) = &block.repeat {
            check_name(&repeat.index, "index", diagnostics);
        }
        check_scope(&block.nets, &block.cells, &block.blocks, diagnostics);
    }
}

fn check_name(name: &Name, what: &str, diagnostics: &mut Diagnostics) {
    if is_name(name) {
        return;
    }
    let message = match name.is_empty() {
        true => format!("a {what} has an empty name"),
        false => format!("`{}` cannot be the name of a {what}", name.value),
    };
    diagnostics.push(
        Diagnostic::new(Code::BadName, message)
            .at(name.span, "")
            .note("a name is a letter or `_`, then letters, digits, `_` or `$`"),
    );
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> (Option<CircuitFile>, Vec<String>) {
        let mut sources = Sources::new();
        let file = sources.add("t.json", text.to_owned());
        let mut diagnostics = Diagnostics::new();
        let circuit = CircuitFile::parse(&sources, file, &mut diagnostics);
        diagnostics.sort();
        let told = diagnostics.iter().map(|d| {
            let span = d.place().unwrap();
            assert!(span.start <= span.end && span.end as usize <= text.len());
            assert!(d.render(&sources, false).contains(&d.code.to_string()));
            format!("{} at {}: {}", d.code, sources.slice(span), d.message)
        });
        let told = told.collect();
        (circuit, told)
    }

    fn module(inside: &str) -> (Module, Vec<String>) {
        let (circuit, told) = read(&format!("{{\"modules\": {{\"m\": {{ {inside} }}}}}}"));
        (circuit.and_then(|mut c| c.modules.swap_remove("m")).and_then(|m| m.0).unwrap_or_default(), told)
    }

    #[test]
    fn the_example_of_the_documentation() {
        let page = include_str!("../../docs/format.md");
        let text = page.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
        let (circuit, told) = read(text);
        assert_eq!(told, [""; 0]);
        let circuit = circuit.unwrap();
        assert_eq!(circuit.timescale.unwrap().to_string(), "1ns");
        assert_eq!(circuit.import[0].value, "../lib/arithmetic.json");
        let line = circuit.modules["line"].as_ref().unwrap();
        let ports: Vec<&str> = line.ports.keys().map(|k| k.value.as_str()).collect();
        assert_eq!(ports, ["dt", "dx", "x"], "in the order of the file");
        assert_eq!(line.ports["x"].as_ref().unwrap().direction.value, Direction::Output);
        assert_eq!(line.parameters["W"].as_ref().unwrap().max.as_ref().unwrap().as_number(), Some(32));
        assert_eq!(line.nets["sum"].as_ref().unwrap().width.as_ref().unwrap().text(), "W+1");
        assert!(line.nets["f"].as_ref().unwrap().signed);
        let and1 = line.cells["and1"].as_ref().unwrap();
        assert_eq!(and1.kind.value, "and");
        assert_eq!(and1.parameters["width"].expr().unwrap().text(), "W+1");
        assert!(matches!(&and1.connections["in"], Signal::Concat { parts, .. } if parts.len() == 2));
        let fa = line.cells["fa"].as_ref().unwrap().repeat.as_ref().unwrap();
        assert_eq!((fa.index.value.as_str(), fa.from.is_some(), fa.to.text()), ("i", false, "W"));
        let stage = line.blocks["stage"].as_ref().unwrap();
        assert_eq!(stage.condition.as_ref().unwrap().text(), "W > 1");
    }

    #[test]
    fn short_and_long_forms() {
        let (m, told) = module(
            r#""parameters": { "A": 8, "B": "A*2", "C": { "default": 1, "min": 0 } },
               "nets": { "n": 1, "w": "A+1", "o": {} },
               "cells": { "c": { "type": "dff", "parameters": { "edge": "falling", "init": -1 } } },
               "blocks": { "b": { "repeat": { "i": [1, "A"] } } }"#,
        );
        assert_eq!(told, [""; 0]);
        assert_eq!(m.parameters["B"].as_ref().unwrap().default.text(), "A*2");
        assert_eq!(m.parameters["C"].as_ref().unwrap().min.as_ref().unwrap().as_number(), Some(0));
        assert!(m.nets["o"].as_ref().unwrap().width.is_none());
        let parameters = &m.cells["c"].as_ref().unwrap().parameters;
        assert_eq!(parameters["edge"].word(), Some("falling"));
        assert_eq!(parameters["init"].expr().unwrap().as_number(), Some(-1));
        let repeat = m.blocks["b"].as_ref().unwrap().repeat.as_ref().unwrap();
        assert_eq!((repeat.from.as_ref().unwrap().text(), repeat.to.text()), ("1", "A"));
    }

    #[test]
    fn faults_of_many_parts_at_once() {
        let (m, told) = module(
            r#""parameters": { "A": [], "B": { "min": 1 }, "C": "1 +" },
               "ports": { "p": { "direction": "in" }, "q": { "width": 1 } },
               "nets": { "1n": 1, "n": true, "e": "" , "": 1 },
               "cells": {
                 "c": { "type": "and", "parmeters": {}, "connections": { "a": "n[", "b": {}, "y": ["n", "~n"] } },
                 "d": { "connections": { "a": "4'b2" }, "repeat": { "i": 1, "j": 2 } },
                 "e": { "type": "and", "repeat": {} },
                 "f": { "type": "and", "repeat": { "i-": [1] }, "if": "a b" },
                 "g": { "type": "and", "parameters": { "width": true } }
               },
               "blocks": { "b": { "blocks": { "c": { "nets": { "n!": 1 }, "port": {} } } } }"#,
        );
        let expected = [
            "wrong-type at []: `A` must be an integer, an expression or an object",
            "missing-field at B: `B` has no field `default`",
            "bad-expression at : an expression ends too early",
            "bad-value at in: `direction` must be `input`, `output` or `inout`",
            "missing-field at q: `q` has no field `direction`",
            "bad-name at 1n: `1n` cannot be the name of a net",
            "wrong-type at true: `n` must be a width (an integer or an expression) or an object",
            "bad-expression at \"\": an expression is missing",
            "bad-name at \"\": a net has an empty name",
            "unknown-field at parmeters: unknown field `parmeters`",
            "bad-signal at : an expression ends too early",
            "wrong-type at {}: `b` must be a signal (a string, an integer or an array)",
            "bad-signal at ~: a signal begins with a name, a number or `(`",
            "missing-field at d: `d` has no field `type`",
            "bad-signal at 2: `2` is not a digit of this base",
            "bad-repeat at j: a `repeat` names one index only",
            "bad-repeat at {}: a `repeat` names no index",
            "bad-repeat at [1]: a range is [from, to]",
            "bad-expression at b: expected the end of the expression",
            "wrong-type at true: `width` must be an integer, an expression or a word",
            "bad-name at n!: `n!` cannot be the name of a net",
            "unknown-field at port: unknown field `port`",
        ];
        for (told, expected) in told.iter().zip(expected) {
            assert_eq!(told, expected);
        }
        assert_eq!(told.len(), expected.len());
        assert!(m.cells["e"].as_ref().is_none());
        assert!(m.blocks["b"].as_ref().unwrap().blocks["c"].as_ref().is_some());
    }

    #[test]
    fn places_inside_of_strings_with_escapes() {
        let (_, told) = module(r#""nets": { "a": "1 + *", "b": "1\u0020+ *" }"#);
        assert_eq!(
            told,
            ["bad-expression at *: unexpected `*`", "bad-expression at 1\\u0020+ *: unexpected `*`"],
            "written with escapes, the whole string is pointed at"
        );
    }

    proptest! {
        /// A circuit, damaged at random, is read without panic, and every place lies in it.
        #[test]
        fn damaged_circuits(cuts in prop::collection::vec((0.0..1.0f64, 0usize..4, "[\\[\\]{}:,\"'0-9a-z$é.~+ \n-]{0,3}"), 1..4)) {
            let page = include_str!("../../docs/format.md");
            let mut text = page.split("```json\n").nth(1).unwrap().split("```").next().unwrap().to_owned();
            for (at, length, insert) in cuts {
                let start = text.floor_char_boundary((at * text.len() as f64) as usize);
                let end = text.ceil_char_boundary((start + length).min(text.len()));
                text.replace_range(start..end, &insert);
            }
            read(&text);
        }
    }
}
