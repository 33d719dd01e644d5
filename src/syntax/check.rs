//! Timing checks as serde types. The comments on fields become the descriptions in the JSON Schema.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::scenario::Edge;
use super::time::TimeText;
use crate::diag::{Code, Diagnostic, Diagnostics, Span};
use crate::json::{self, Spanned};
use crate::syntax::{Expr, Name};

/// A timing check: what must hold of a net at every tick.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Free text: what it guards against.
    #[serde(default, deserialize_with = "json::or_default")]
    pub doc: Option<String>,
    /// What is checked.
    pub rule: Spanned<CheckRule>,
    /// The net, by its path below the top module: one bit, for `setup` and `hold` of any width.
    pub net: Name,
    /// `width`, `runt`: the level whose pulses are measured. Default `high`.
    pub level: Option<Spanned<Level>>,
    /// `period`, `setup`, `hold`, `recovery`: which changes of the net count. Default: `rising` for `period`, all for the
    /// others.
    pub edge: Option<Spanned<Edge>>,
    /// `setup`, `hold`, `recovery`: the edge from which the time is measured.
    pub on: Option<NetEdge>,
    /// `steps`: the net whose pulses are the steps that go in.
    pub of: Option<Name>,
    /// `steps`: how many steps the store between the nets holds. Default: any number.
    pub depth: Option<Expr>,
    /// The shortest time allowed.
    pub min: Option<TimeText>,
    /// `width`, `period`: the longest time allowed.
    pub max: Option<TimeText>,
}

/// What a timing check measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CheckRule {
    /// How long a pulse of the net lasts.
    Width,
    /// The same, at least: a pulse that something cut short.
    Runt,
    /// How long it is from one edge to the next of the same direction.
    Period,
    /// How long the net is at rest before an edge of another.
    Setup,
    /// How long the net is at rest after an edge of another.
    Hold,
    /// How long before an edge of another a control is released.
    Recovery,
    /// Whether every pulse of another net gives one pulse of the net.
    Steps,
}

/// A level of a net.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// 1.
    #[default]
    High,
    /// 0.
    Low,
}

/// The edges of a net.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NetEdge {
    /// The net, of one bit.
    pub net: Name,
    /// Which edges count. Default `rising`.
    pub edge: Option<Spanned<Edge>>,
}

impl CheckRule {
    /// The name in the file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            CheckRule::Width => "width",
            CheckRule::Runt => "runt",
            CheckRule::Period => "period",
            CheckRule::Setup => "setup",
            CheckRule::Hold => "hold",
            CheckRule::Recovery => "recovery",
            CheckRule::Steps => "steps",
        }
    }

    /// The fields that belong to the rule, besides `net`; those it cannot do without come first.
    const fn fields(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            CheckRule::Width => (&[], &["level", "min", "max"]),
            CheckRule::Runt => (&["min"], &["level"]),
            CheckRule::Period => (&[], &["edge", "min", "max"]),
            CheckRule::Setup | CheckRule::Hold | CheckRule::Recovery => (&["on", "min"], &["edge"]),
            CheckRule::Steps => (&["of"], &["depth"]),
        }
    }
}

impl Check {
    /// Tells of fields that the rule does not have, or lacks.
    pub(crate) fn check(&self, diagnostics: &mut Diagnostics) {
        let rule = self.rule.value;
        let fault = |message: String, span: Span, label: &str| {
            Diagnostic::new(Code::BadScenario, message).at(span, label.to_owned())
        };
        let given: [(&str, Option<Span>); 7] = [
            ("level", self.level.as_ref().map(|l| l.span)),
            ("edge", self.edge.as_ref().map(|e| e.span)),
            ("on", self.on.as_ref().map(|o| o.net.span)),
            ("of", self.of.as_ref().map(|o| o.span)),
            ("depth", self.depth.as_ref().map(Expr::span)),
            ("min", self.min.as_ref().map(TimeText::span)),
            ("max", self.max.as_ref().map(TimeText::span)),
        ];
        let (needed, possible) = rule.fields();
        for (name, span) in given {
            match span {
                Some(span) if !needed.contains(&name) && !possible.contains(&name) => {
                    diagnostics.push(fault(
                        format!("a `{}` check has no `{name}`", rule.name()),
                        span,
                        "leave this out",
                    ));
                }
                None if needed.contains(&name) => {
                    let message = format!("a `{}` check needs `{name}`", rule.name());
                    diagnostics.push(fault(message, self.rule.span, ""));
                }
                _ => {}
            }
        }
        if possible.contains(&"min") && self.min.is_none() && self.max.is_none() {
            let message = format!("a `{}` check needs `min` or `max`", rule.name());
            diagnostics.push(fault(message, self.rule.span, ""));
        }
    }
}
