//! Rows as CSV and JSON: one line each, whatever the form.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::plan::Plan;
use super::run::{Ended, Row, Shown, Verdict};
use crate::Value;
use crate::cell::Clock;
use crate::netlist::{Netlist, SignalId};
use crate::safe;
use crate::value::Word;

/// How results are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Comma-separated values: a line of names, a line a row.
    #[default]
    Csv,
    /// One object: what the sweep is, the names of the columns, an array a row.
    Json,
}

/// Makes rows into text.
pub struct Table<'a> {
    netlist: &'a Netlist,
    plan: &'a Plan,
    swept: Vec<SignalId>,
    outputs: Vec<SignalId>,
    clock: Option<Clock>,
    compared: bool,
    form: Form,
}

impl<'a> Table<'a> {
    /// A table with a column for each swept signal, why and when a run ended, the outputs, and what a comparison says.
    /// `clock` is what cycles are counted in.
    #[must_use]
    pub fn new(
        netlist: &'a Netlist,
        plan: &'a Plan,
        swept: Vec<SignalId>,
        outputs: Vec<SignalId>,
        clock: Option<Clock>,
        compared: bool,
        form: Form,
    ) -> Table<'a> {
        Table { netlist, plan, swept, outputs, clock, compared, form }
    }

    /// The names of the columns.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let path = |s: &SignalId| safe::name(&self.netlist.signal_path(*s)).into_owned();
        let mut names: Vec<String> = self.swept.iter().map(path).collect();
        names.extend(["stop", "time"].map(String::from));
        names.extend(self.clock.map(|_| "cycles".into()));
        names.extend(self.outputs.iter().map(path));
        if self.compared {
            names.push("difference".into());
        }
        names
    }

    /// A row as one line, without its end.
    #[must_use]
    pub fn line(&self, row: &Row) -> String {
        let mut line = String::with_capacity(64);
        if self.form == Form::Json {
            line.push('[');
        }
        for (signal, value) in self.swept.iter().zip(self.plan.values(row.number)) {
            let signal = self.netlist.signal(*signal);
            line.push_str(&swept(self.form, value, signal.width, signal.signed));
            line.push(',');
        }
        self.text(
            &mut line,
            match row.ended {
                Ended::Until => "until",
                Ended::Limit => "limit",
                Ended::Idle => "idle",
                Ended::Unsettled => "unsettled",
            },
        );
        let _ = write!(line, "{},", row.time);
        if let Some(c) = self.clock {
            let cycles = if row.time < c.phase { 0 } else { (row.time - c.phase) / c.period + 1 };
            let _ = write!(line, "{cycles},");
        }
        for (i, signal) in self.outputs.iter().enumerate() {
            match row.outputs.get(i) {
                Some(value) => self.shown(&mut line, *signal, value),
                None if self.form == Form::Json => line.push_str("null,"),
                None => line.push(','),
            }
        }
        match &row.verdict {
            _ if !self.compared => {}
            Some(Verdict::Differs(clock, why)) => self.text(&mut line, &format!("clock {clock}: {why}")),
            Some(Verdict::Refused(why)) => self.text(&mut line, &format!("refused: {why}")),
            Some(Verdict::Same) | None => self.text(&mut line, ""),
        }
        line.pop();
        if self.form == Form::Json {
            line.push(']');
        }
        line
    }

    fn shown(&self, line: &mut String, signal: SignalId, value: &Shown) {
        let signal = self.netlist.signal(signal);
        match *value {
            Shown::Number(n) => _ = write!(line, "{},", number(n, signal.width, signal.signed)),
            Shown::Value(ref value) => self.text(line, &value.to_string()),
        }
    }

    fn text(&self, line: &mut String, text: &str) {
        line.push_str(&field(self.form, text));
        line.push(',');
    }
}

/// A swept value as it stands in a row.
pub(super) fn swept(form: Form, value: Word, width: u32, signed: bool) -> String {
    match value.u {
        0 => number(value.v, width, signed),
        _ => field(form, &Value::from_words(&[value], width).to_string()),
    }
}

/// A number of at most 64 bits as people read it.
fn number(n: u64, width: u32, signed: bool) -> String {
    let unused = 64 - width.min(64);
    if signed { (((n << unused) as i64) >> unused).to_string() } else { n.to_string() }
}

/// A text as it stands in a row.
#[must_use]
pub fn field(form: Form, text: &str) -> String {
    match form {
        Form::Json => Json::from(text).to_string(),
        Form::Csv if text.contains(['"', ',', '\n', '\r']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Form::Csv => text.to_owned(),
    }
}
