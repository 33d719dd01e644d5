//! Scenarios as serde types: what an author wrote, with places. The comments on fields become the descriptions in the
//! JSON Schema.

use std::borrow::Cow;

use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer};

use super::check::Check;
use super::stimulus::{Stimuli, WaveStimulus};
use super::time::{Percent, TimeText};
use crate::Value;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};
use crate::json::{self, Recover, Spanned};
use crate::syntax::{Expr, Name, ParameterValue};

/// A scenario file.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// Where an editor finds the schema.
    #[serde(rename = "$schema", default, deserialize_with = "json::or_default")]
    pub schema: Option<String>,
    /// Free text: what the scenario shows.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// The circuit file, relative to this one.
    pub circuit: Spanned<String>,
    /// Values of the top module's parameters.
    #[serde(default)]
    pub parameters: IndexMap<Name, Recover<ParameterValue>>,
    /// How `circuit` is read, where it is Verilog.
    pub verilog: Option<Recover<Verilog>>,
    /// Memories of a Yosys netlist, by their path, and the files that say what they hold at first, relative to this one: hex
    /// words as `$readmemh` reads them.
    #[serde(default)]
    pub memories: IndexMap<Name, Recover<Spanned<String>>>,
    /// What happens. Each field takes the place of the circuit's own; `inputs` and `clocks` name by name.
    pub simulation: Option<Recover<Simulation>>,
}

/// How Verilog is read.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Verilog {
    /// More files of the design, relative to this one.
    #[serde(default, deserialize_with = "json::every")]
    pub sources: Vec<Spanned<String>>,
    /// Folders in which `` `include `` looks, relative to this file.
    #[serde(default, deserialize_with = "json::every")]
    pub include: Vec<Spanned<String>>,
    /// Macros: `NAME` or `NAME=VALUE`.
    #[serde(default, deserialize_with = "json::every")]
    pub define: Vec<Spanned<String>>,
    /// The module to run. Default: the one that no other uses.
    pub top: Option<Spanned<String>>,
    /// Modules whose contents are left out: what they drive is x.
    #[serde(default, deserialize_with = "json::every")]
    pub black_boxes: Vec<Spanned<String>>,
}

/// What happens to a circuit.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// Inputs that are clocks.
    #[serde(default)]
    pub clocks: IndexMap<Name, Recover<Clock>>,
    /// Values of inputs, held from time 0.
    #[serde(default)]
    pub inputs: IndexMap<Name, Recover<ValueText>>,
    /// Changes of inputs; several at one time are applied in order. Or a waveform that has them, which takes the place of
    /// all that the circuit's own block says of clocks, inputs, the end and what is expected.
    pub stimulus: Option<Recover<Stimuli>>,
    /// When to stop.
    pub until: Option<Recover<Until>>,
    /// The run fails if it gets here before `until`; without `until` it ends here.
    pub limit: Option<Recover<Limit>>,
    /// Which nets the waveform holds: globs over `scope.net`; `**` crosses scopes. Default `["**"]`.
    #[serde(default, deserialize_with = "json::every")]
    pub trace: Option<Vec<Spanned<String>>>,
    /// Timing checks: what must hold at every tick.
    #[serde(default)]
    pub checks: IndexMap<Name, Recover<Check>>,
    /// What must hold at the end or at one time.
    pub expect: Option<Vec<Recover<Expect>>>,
}

/// A clock on an input.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clock {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// The time from one rising edge to the next.
    pub period: TimeText,
    /// The time it is 1 in each period. Default: half of the period.
    pub high: Option<TimeText>,
    /// The share of the period that it is 1, in percent; in place of `high`.
    pub duty: Option<Percent>,
    /// The time of the first rising edge; it is 0 before. Default: `period - high`.
    pub phase: Option<TimeText>,
}

/// Inputs that change at a time or on a clock edge.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stimulus {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// The time; or `on`.
    pub at: Option<TimeText>,
    /// The clock edge; or `at`.
    pub on: Option<EdgeOf>,
    /// The new values.
    #[serde(deserialize_with = "json::every")]
    pub set: IndexMap<Name, ValueText>,
}

/// An edge of a clock.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeOf {
    /// A clock of this scenario.
    pub clock: Name,
    /// Which edges count. Default `rising`.
    pub edge: Option<Spanned<Edge>>,
    /// Which of them, counted from 1. Default 1.
    pub count: Option<Expr>,
}

/// A direction of change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    /// From 0 to 1.
    #[default]
    Rising,
    /// From 1 to 0.
    Falling,
}

/// The value of a net that ends a run.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Until {
    /// The net, by its path below the top module.
    pub net: Name,
    /// Its value. Default 1.
    pub value: Option<ValueText>,
}

/// How long a run may take.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Periods of the first clock.
    pub cycles: Option<Expr>,
    /// Simulated time.
    pub time: Option<TimeText>,
}

/// Something that must hold of a net, or how a timing check has to go.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// The net, by its path below the top module; or `check`.
    pub net: Option<Name>,
    /// Its value; or `pulses`.
    pub value: Option<ValueText>,
    /// The time at which it has the value, by default the end; of a check, the time of its first violation.
    pub at: Option<TimeText>,
    /// How many times bit 0 of it rose from 0 to 1, an expression in parameters and in what inputs are at the start; or
    /// `value`.
    pub pulses: Option<Expr>,
    /// A timing check that is to be violated.
    pub check: Option<Name>,
    /// How many violations there are. Default: at least one.
    pub violations: Option<Expr>,
}

impl Expect {
    /// Where what is left of it stands, if neither its net nor what must hold of it is there.
    fn place(&self) -> Option<Span> {
        self.at.as_ref().map(TimeText::span).or(self.violations.as_ref().map(Expr::span))
    }
}

/// A value as it stands in a file; the net that it is for says how wide it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ValueText {
    text: String,
    span: Span,
}

impl ValueText {
    /// The value written `text`, which stands at `span`.
    #[must_use]
    pub fn new(text: impl Into<String>, span: Span) -> ValueText {
        ValueText { text: text.into(), span }
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Where it stands.
    #[must_use]
    pub fn span(&self) -> Span {
        self.span
    }

    /// The value for an input of `width` bits, which takes negative numbers if it is `signed`.
    ///
    /// # Errors
    /// If the text is not a value, does not fit, or is negative where there is no sign.
    pub fn given(&self, width: u32, signed: bool) -> Result<Value, Diagnostic> {
        let value = self.value(width)?;
        Value::given(&self.text, width, signed).map(|_| value).map_err(|e| {
            let what = format!("for {width} bit{} without a sign", if width == 1 { "" } else { "s" });
            Diagnostic::new(Code::BadValue, e.to_string()).at(self.span, what).help(format!(
                "write a bit pattern as in {width}'b1…, or declare the port with `\"signed\": true` if it carries signed numbers"
            ))
        })
    }

    /// The value for a net of `width` bits.
    ///
    /// # Errors
    /// If the text is not a value, or does not fit.
    pub fn value(&self, width: u32) -> Result<Value, Diagnostic> {
        Value::for_width(&self.text, width).map_err(|e| {
            Diagnostic::new(Code::BadValue, e.to_string())
                .at(self.span, format!("for {width} bit{}", if width == 1 { "" } else { "s" }))
        })
    }
}

#[derive(Deserialize)]
#[serde(rename = "$discreta::Kind a value: an integer, or a string such as \"4'b10x1\"", rename_all = "lowercase")]
enum WrittenValue {
    Integer(i64),
    String(String),
}

impl<'de> Deserialize<'de> for ValueText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Spanned { value, span } = Spanned::<WrittenValue>::deserialize(deserializer)?;
        Ok(match value {
            WrittenValue::Integer(n) => ValueText::new(n.to_string(), span),
            WrittenValue::String(text) => ValueText::new(text, span),
        })
    }
}

impl JsonSchema for ValueText {
    fn schema_name() -> Cow<'static, str> {
        "Value".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or a literal such as `4'b10x1`, `8'hff`, or `x` for all bits.",
            "type": ["integer", "string"],
            "minLength": 1
        })
    }
}

impl ScenarioFile {
    /// Reads a scenario file. All faults go into `diagnostics`; parts of the file that are faulty are `None` in it.
    #[must_use]
    pub fn parse(sources: &Sources, file: FileId, diagnostics: &mut Diagnostics) -> Option<ScenarioFile> {
        let scenario: ScenarioFile = json::parse(sources, file, diagnostics)?;
        if let Some(simulation) = scenario.simulation.as_ref().and_then(Recover::as_ref) {
            simulation.check(diagnostics);
        }
        Some(scenario)
    }
}

impl Simulation {
    /// What drives the inputs, if it has no fault.
    fn stimuli(&self) -> Option<&Stimuli> {
        self.stimulus.as_ref()?.as_ref()
    }

    /// The changes of inputs that have no fault.
    pub fn changes(&self) -> impl Iterator<Item = &Stimulus> {
        self.stimuli().map_or(&[][..], Stimuli::changes).iter().filter_map(Recover::as_ref)
    }

    /// Leaves out what changes an input, and with it instants at which nothing else changes.
    pub fn without_changes_of(&mut self, net: &str) {
        let Some(Recover(Some(Stimuli::Changes(changes)))) = &mut self.stimulus else { return };
        changes.retain_mut(|change| match change {
            Recover(Some(change)) => change.set.shift_remove(net).is_none() || !change.set.is_empty(),
            Recover(None) => true,
        });
    }

    /// The waveform that drives the inputs, if one does.
    #[must_use]
    pub fn wave(&self) -> Option<&WaveStimulus> {
        self.stimuli()?.wave()
    }

    /// Tells of fields that contradict each other.
    pub(crate) fn check(&self, diagnostics: &mut Diagnostics) {
        let mut tell = |message: &str, span: Span, label: &str| {
            diagnostics.push(Diagnostic::new(Code::BadScenario, message).at(span, label));
        };
        for clock in self.clocks.values().filter_map(Recover::as_ref) {
            if let (Some(_), Some(duty)) = (&clock.high, &clock.duty) {
                tell("a clock has both `high` and `duty`", duty.span(), "leave one of them out");
            }
        }
        for stimulus in self.changes() {
            match (&stimulus.at, &stimulus.on) {
                (Some(at), Some(_)) => tell("a stimulus has both `at` and `on`", at.span(), "leave one of them out"),
                (None, None) => {
                    let place = stimulus.set.keys().next().map(|n| n.span);
                    tell("a stimulus has neither `at` nor `on`", place.unwrap_or_default(), "when is this set?");
                }
                _ => {}
            }
        }
        for expect in self.expect.iter().flatten().filter_map(Recover::as_ref) {
            let (value, pulses) = (expect.value.as_ref(), expect.pulses.as_ref());
            match (&expect.net, &expect.check) {
                (Some(_), Some(check)) => tell("an expectation has both `net` and `check`", check.span, "make it two"),
                (None, None) => {
                    let place = value.map(ValueText::span).or(pulses.map(Expr::span)).or(expect.place());
                    tell("an expectation has neither `net` nor `check`", place.unwrap_or_default(), "of what?");
                }
                (None, Some(_)) => {
                    if let Some(place) = value.map(ValueText::span).or(pulses.map(Expr::span)) {
                        tell("a timing check has `violations`, not `value` or `pulses`", place, "leave this out");
                    }
                }
                (Some(net), None) => {
                    if let Some(violations) = &expect.violations {
                        tell("a net has no `violations`; a timing check has", violations.span(), "name a `check`");
                    }
                    match (value, pulses, &expect.at) {
                        (Some(_), Some(pulses), _) => {
                            tell("an expectation has both `value` and `pulses`", pulses.span(), "make it two");
                        }
                        (None, None, _) if expect.violations.is_none() => {
                            tell(
                                "an expectation has neither `value` nor `pulses`",
                                net.span,
                                "what must hold of this?",
                            );
                        }
                        (None, Some(_), Some(at)) => {
                            tell("pulses are counted up to the end, not at a time", at.span(), "leave this out");
                        }
                        _ => {}
                    }
                }
            }
        }
        if let Some(wave) = self.wave() {
            wave.check(diagnostics);
        }
        for check in self.checks.values().filter_map(Recover::as_ref) {
            check.check(diagnostics);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Timescale;

    fn read(text: &str) -> (Option<ScenarioFile>, Vec<String>) {
        let mut sources = Sources::new();
        let file = sources.add("t.json", text.to_owned());
        let mut diagnostics = Diagnostics::new();
        let scenario = ScenarioFile::parse(&sources, file, &mut diagnostics);
        diagnostics.sort();
        let told =
            diagnostics.iter().map(|d| format!("{} at {}: {}", d.code, sources.slice(d.place().unwrap()), d.message));
        (scenario, told.collect())
    }

    fn simulation(inside: &str) -> (Simulation, Vec<String>) {
        let (file, told) = read(&format!("{{\"circuit\": \"c.json\", \"simulation\": {{ {inside} }}}}"));
        (file.and_then(|f| f.simulation).and_then(|s| s.0).unwrap_or_default(), told)
    }

    #[test]
    fn the_examples_of_the_documentation() {
        let page = include_str!("../../docs/scenarios.md");
        let mut examples = page.split("```json\n").skip(1).map(|part| part.split("```").next().unwrap());
        let (file, told) = read(examples.next().unwrap());
        assert_eq!(told, [""; 0]);
        let file = file.unwrap();
        assert_eq!(file.circuit.value, "../circuits/evaluation/line.json");
        assert_eq!(file.parameters["W"].as_ref().unwrap().expr().unwrap().as_number(), Some(8));

        let (file, told) = read(&format!("{{ \"circuit\": \"c\", {} }}", examples.next().unwrap()));
        assert_eq!(told, [""; 0]);
        let s = file.unwrap().simulation.unwrap().0.unwrap();
        let clock = s.clocks["dt"].as_ref().unwrap();
        assert_eq!(clock.period.ticks(Timescale::default(), &()), Ok(20));
        assert_eq!(clock.phase.as_ref().unwrap().ticks(Timescale::default(), &()), Ok(10));
        assert_eq!(s.inputs["xh"].as_ref().unwrap().value(8).unwrap().to_u64(), Some(0));
        let stimulus: Vec<_> = s.changes().collect();
        assert_eq!(stimulus.len(), 3);
        let on = stimulus[2].on.as_ref().unwrap();
        assert_eq!((on.clock.value.as_str(), on.edge.unwrap().value), ("dt", Edge::Falling));
        assert_eq!(s.until.unwrap().as_ref().unwrap().net.value, "end");
        assert_eq!(s.limit.unwrap().as_ref().unwrap().cycles.as_ref().unwrap().text(), "2 << W");
        assert_eq!(s.trace.unwrap()[0].value, "**");
        assert_eq!(s.expect.unwrap()[2].as_ref().unwrap().pulses.as_ref().unwrap().as_number(), Some(5));

        let (file, told) = read(&format!("{{ \"circuit\": \"c\", {} }}", examples.next().unwrap()));
        assert_eq!(told, [""; 0]);
        let s = file.unwrap().simulation.unwrap().0.unwrap();
        let wave = s.wave().unwrap();
        assert_eq!((wave.wave.as_str(), wave.expect, wave.ignore.len()), ("icarus.vcd", true, 1));
    }

    #[test]
    fn faults() {
        let (_, told) = simulation(
            r#""clocks": { "c": { "period": "5x" }, "d": { "period": 10, "high": 5, "duty": 50 }, "e": { "duty": 101 } },
               "inputs": { "a": 1.5, "b": null },
               "stimulus": [ { "at": 0, "on": { "clock": "c" }, "set": {} }, { "set": { "a": 1 } },
                             { "on": { "clock": "c", "edge": "up" }, "set": {} } ],
               "expect": [ { "net": "x" }, { "net": "y", "value": 1, "pulses": 1 }, { "net": "z", "pulses": 1, "at": 3 } ],
               "trace": "**""#,
        );
        // `trace` is faulty, so the whole is; its contradictions are found once it can be read.
        let expected = [
            "bad-time at 5x: `x` is not a unit of time",
            "missing-field at e: `e` has no field `period`",
            "bad-value at 101: a percentage must be a number from 0 to 100",
            "wrong-type at 1.5: `a` must be a value: an integer, or a string such as \"4'b10x1\"",
            "wrong-type at null: `b` must be a value: an integer, or a string such as \"4'b10x1\"",
            "bad-value at up: `edge` must be `rising` or `falling`",
            "wrong-type at **: `trace` must be an array",
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn contradictions() {
        let (s, told) = simulation(
            r#""clocks": { "d": { "period": 10, "high": 5, "duty": 50 } },
               "stimulus": [ { "at": 0, "on": { "clock": "c" }, "set": {} }, { "set": { "a": 1 } } ],
               "expect": [ { "net": "x" }, { "net": "y", "value": 1, "pulses": 2 }, { "net": "z", "pulses": 1, "at": 3 } ]"#,
        );
        let expected = [
            "bad-scenario at 50: a clock has both `high` and `duty`",
            "bad-scenario at 0: a stimulus has both `at` and `on`",
            "bad-scenario at a: a stimulus has neither `at` nor `on`",
            "bad-scenario at x: an expectation has neither `value` nor `pulses`",
            "bad-scenario at 2: an expectation has both `value` and `pulses`",
            "bad-scenario at 3: pulses are counted up to the end, not at a time",
        ];
        assert_eq!(told, expected);
        assert_eq!(s.clocks.len(), 1);
    }

    #[test]
    fn values() {
        let at = Span::default();
        assert_eq!(ValueText::new("4'b10x1", at).value(4).unwrap().bit_string(), "10x1");
        assert_eq!(ValueText::new("-1", at).value(4).unwrap().bit_string(), "1111");
        assert_eq!(ValueText::new("16", at).value(4).unwrap_err().code, Code::BadValue);
    }
}
