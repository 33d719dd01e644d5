//! What changes the inputs of a circuit, as it stands in a scenario: a list of changes, or a waveform.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::scenario::Stimulus;
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::json::{self, Recover, Spanned};
use crate::syntax::Name;

/// What changes the inputs.
#[derive(Debug, Clone, JsonSchema)]
#[schemars(with = "StimuliForm")]
pub enum Stimuli {
    /// Changes at times and on clock edges.
    Changes(Vec<Recover<Stimulus>>),
    /// A waveform.
    Wave(Box<WaveStimulus>),
}

/// A waveform that drives the inputs, and what is compared with it.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveStimulus {
    /// Free text.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// The waveform, VCD, FST or GHW, relative to this file.
    pub wave: Spanned<String>,
    /// Where in its hierarchy the circuit stands, as in `bench.dut`. Default: where the inputs are found.
    pub scope: Option<Spanned<String>>,
    /// Inputs that change before all others of their time. Default: those that are clocks.
    #[serde(default, deserialize_with = "json::every")]
    pub first: Vec<Name>,
    /// Whether the nets of the circuit must be what they are in the waveform.
    #[serde(default)]
    pub expect: bool,
    /// Nets that are not compared: globs over `scope.net`.
    #[serde(default, deserialize_with = "json::every")]
    pub ignore: Vec<Spanned<String>>,
    /// Where x agrees with anything. Default: x agrees with x alone.
    pub ignore_x: Option<Spanned<Loose>>,
}

/// A side of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Loose {
    /// In the waveform.
    Wave,
    /// In the run.
    Run,
}

/// A list of changes, or an object that names a waveform.
#[derive(Deserialize, JsonSchema)]
#[serde(rename = "$discreta::Kind a list of changes, or an object with a `wave`", rename_all = "lowercase")]
#[schemars(rename = "Stimuli", untagged)]
enum StimuliForm {
    Array(Vec<Recover<Stimulus>>),
    Object(Box<WaveStimulus>),
}

impl<'de> Deserialize<'de> for Stimuli {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match StimuliForm::deserialize(deserializer)? {
            StimuliForm::Array(changes) => Stimuli::Changes(changes),
            StimuliForm::Object(wave) => Stimuli::Wave(wave),
        })
    }
}

impl Stimuli {
    /// The changes of a list; none of a waveform.
    pub fn changes(&self) -> &[Recover<Stimulus>] {
        match self {
            Stimuli::Changes(changes) => changes,
            Stimuli::Wave(_) => &[],
        }
    }

    /// The waveform, if it is one.
    #[must_use]
    pub fn wave(&self) -> Option<&WaveStimulus> {
        match self {
            Stimuli::Changes(_) => None,
            Stimuli::Wave(wave) => Some(wave),
        }
    }
}

impl WaveStimulus {
    /// Tells of fields that contradict each other.
    pub(super) fn check(&self, diagnostics: &mut Diagnostics) {
        let place = self.ignore.first().map(|glob| glob.span).or(self.ignore_x.as_ref().map(|side| side.span));
        if let (false, Some(place)) = (self.expect, place) {
            let fault = Diagnostic::new(Code::BadScenario, "nothing is compared with the waveform");
            diagnostics.push(fault.at(place, "this is about the comparison").help("add `\"expect\": true`"));
        }
    }
}
