//! The circuit file as serde types: what an author wrote, with places. The comments on fields become the descriptions
//! in the JSON Schema.

use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::expr::Expr;
use super::expr_parser::is_name;
use super::reference::Signal;
use super::value_names::Written;
use crate::Timescale;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};
use crate::json::{self, Recover, Spanned};
use crate::syntax::Simulation;

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
    pub timescale: Option<Spanned<TimescaleText>>,
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
    pub simulation: Option<Spanned<Recover<Simulation>>>,
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
    /// Names that viewers show for its values: `{ "0": "idle", "4'b1zzz": "free" }`.
    #[serde(default, deserialize_with = "json::every")]
    pub values: Written,
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
    /// Names that viewers show for its values.
    pub values: Written,
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
    /// Names that viewers show for its values: `{ "0": "idle", "4'b1zzz": "free" }`.
    #[serde(default, deserialize_with = "json::every")]
    values: Written,
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    doc: Option<String>,
}

impl<'de> Deserialize<'de> for Net {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match NetForm::deserialize(deserializer)? {
            NetForm::Integer(width) | NetForm::String(width) => Net { width: Some(width), ..Net::default() },
            NetForm::Object(NetObject { width, signed, values, doc }) => Net { width, signed, values, doc },
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
#[serde(rename = "$discreta::Kind an integer, an expression, a word or an array", rename_all = "lowercase")]
#[schemars(rename = "ParameterValue", untagged)]
pub enum ParameterText {
    /// A JSON number.
    Integer(i64),
    /// A JSON number with a fraction or an exponent, for quantities: its shortest text.
    #[serde(deserialize_with = "fraction")]
    #[schemars(with = "f64")]
    Number(String),
    /// A JSON string.
    String(String),
    /// The words of a memory.
    Array(Words),
}

/// What a memory holds, word by word from address 0.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
pub struct Words(#[serde(deserialize_with = "json::every")] pub Vec<ParameterValue>);

fn fraction<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    f64::deserialize(deserializer).map(|n| n.to_string())
}

impl ParameterText {
    /// As it was written.
    #[must_use]
    pub fn as_text(&self) -> String {
        match self {
            ParameterText::Integer(n) => n.to_string(),
            ParameterText::Number(text) | ParameterText::String(text) => text.clone(),
            ParameterText::Array(_) => "an array".to_owned(),
        }
    }
}

impl Spanned<ParameterText> {
    /// The value as an expression.
    ///
    /// # Errors
    /// If the text is none.
    pub fn expr(&self) -> Result<Expr, Diagnostic> {
        match &self.value {
            ParameterText::Integer(n) => Ok(Expr::number(*n, self.span)),
            ParameterText::Number(_) => Err(Diagnostic::new(Code::WrongType, "only a quantity may have a fraction")
                .at(self.span, "this is not an integer")),
            ParameterText::Array(_) => {
                Err(Diagnostic::new(Code::WrongType, "expected one value, not an array of them")
                    .at(self.span, "only the words of a memory are an array"))
            }
            ParameterText::String(text) => Expr::parse(text, self.span),
        }
    }

    /// The text, unless it is a number.
    #[must_use]
    pub fn word(&self) -> Option<&str> {
        match &self.value {
            ParameterText::Integer(_) | ParameterText::Number(_) | ParameterText::Array(_) => None,
            ParameterText::String(text) => Some(text),
        }
    }
}

/// A timescale as it is written: `1ns`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TimescaleText(pub Timescale);

impl<'de> Deserialize<'de> for TimescaleText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = Spanned::<String>::deserialize(deserializer)?;
        text.parse().map(TimescaleText).map_err(|e: String| {
            let (message, help) = e.split_once(": ").unwrap_or((&e, ""));
            json::fault(Diagnostic::new(Code::BadTime, message).at(text.span, "").help(help))
        })
    }
}

impl JsonSchema for TimescaleText {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Timescale".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "1, 10 or 100 of a unit, e.g. `1ns`.",
            "type": "string",
            "pattern": "^(1|10|100) ?(s|ms|us|ns|ps|fs)$"
        })
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
        if let Some(simulation) = circuit.simulation.as_ref().and_then(|s| s.value.as_ref()) {
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
