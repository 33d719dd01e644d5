//! Rows as CSV and JSON, and the parts of a sweep put together.
//!
//! Every row is one line, whatever the form, so that a part of a sweep can be read back, gone on with, and joined
//! to others without a look at what is in it.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

use super::plan::Plan;
use super::run::{Ended, Row, Shown, Verdict};
use crate::Value;
use crate::cell::Clock;
use crate::netlist::{Netlist, SignalId};

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

/// What a file of results is a part of. The first line of a part.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Part {
    /// The circuit file.
    pub circuit: String,
    /// What was swept, as it was asked for.
    pub over: Vec<String>,
    /// What circuit and options come to, in short: parts of one sweep have the same.
    pub id: String,
    /// The form of the rows.
    pub form: Form,
    /// The first row, the one after the last, and how many the whole sweep has.
    pub rows: [u64; 3],
}

/// What stands before the description of a part in CSV.
const MARK: &str = "# discreta sweep ";

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
        let path = |s: &SignalId| self.netlist.signal_path(*s);
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
            let width = self.netlist.signal(*signal).width;
            let shown =
                if value.u == 0 { Shown::Number(value.v) } else { Shown::Value(Value::from_words(&[value], width)) };
            self.shown(&mut line, *signal, &shown);
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
            Shown::Number(n) if signal.signed => {
                let unused = 64 - signal.width.min(64);
                let _ = write!(line, "{},", ((n << unused) as i64) >> unused);
            }
            Shown::Number(n) => _ = write!(line, "{n},"),
            Shown::Value(ref value) => self.text(line, &value.to_string()),
        }
    }

    fn text(&self, line: &mut String, text: &str) {
        line.push_str(&field(self.form, text));
        line.push(',');
    }
}

/// A text as it stands in a row.
fn field(form: Form, text: &str) -> String {
    match form {
        Form::Json => Json::from(text).to_string(),
        Form::Csv if text.contains(['"', ',', '\n', '\r']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Form::Csv => text.to_owned(),
    }
}

/// What comes before the rows. Of a part it says which.
#[must_use]
pub fn head(part: &Part, columns: &[String]) -> String {
    let whole = part.rows[0] == 0 && part.rows[1] == part.rows[2];
    match part.form {
        Form::Csv => {
            let names: Vec<String> = columns.iter().map(|name| field(Form::Csv, name)).collect();
            let mark = if whole { String::new() } else { format!("{MARK}{}\n", json!(part)) };
            format!("{mark}{}\n", names.join(","))
        }
        Form::Json => head_of(part, &json!(columns).to_string()),
    }
}

/// The same of JSON, the columns as they stand in it.
#[must_use]
pub fn head_of(part: &Part, columns: &str) -> String {
    format!("{{\"sweep\":{},\n\"columns\":{columns},\n\"rows\":[\n", json!(part))
}

/// What comes between two rows, and after the last.
#[must_use]
pub fn between(form: Form) -> &'static str {
    if form == Form::Json { ",\n" } else { "\n" }
}

/// What comes after all rows, of which there are some or none.
#[must_use]
pub fn tail(form: Form, any: bool) -> &'static str {
    match (form, any) {
        (Form::Json, true) => "\n]}\n",
        (Form::Json, false) => "]}\n",
        (Form::Csv, true) => "\n",
        (Form::Csv, false) => "",
    }
}

/// A part as it was read back.
#[derive(Debug)]
pub struct ReadPart<'t> {
    /// What it is a part of.
    pub part: Part,
    /// The line of column names.
    pub columns: &'t str,
    /// Its rows, a line each.
    pub lines: Vec<&'t str>,
}

/// Reads a part.
///
/// # Errors
/// Why it is none.
pub fn read(text: &str) -> Result<ReadPart<'_>, String> {
    const NONE: &str = "this is no part of a sweep: those are written with --shard";
    let (part, columns, lines): (Part, &str, Vec<&str>) = if let Some(rest) = text.strip_prefix(MARK) {
        let (part, rest) = rest.split_once('\n').ok_or(NONE)?;
        let (columns, rest) = rest.split_once('\n').ok_or("it breaks off before its columns")?;
        (serde_json::from_str(part).map_err(|e| e.to_string())?, columns, rest.lines().collect())
    } else {
        let rest = text.strip_prefix("{\"sweep\":").ok_or(NONE)?;
        let (part, rest) = rest.split_once(",\n\"columns\":").ok_or(NONE)?;
        let (columns, rest) = rest.split_once(",\n\"rows\":[\n").ok_or(NONE)?;
        let rows = rest.strip_suffix("]}\n").ok_or("it breaks off before its end")?;
        let lines = rows.lines().map(|l| l.strip_suffix(',').unwrap_or(l)).collect();
        (serde_json::from_str(part).map_err(|e| e.to_string())?, columns, lines)
    };
    let count = part.rows[1].checked_sub(part.rows[0]).ok_or(NONE)?;
    if lines.len() as u64 != count {
        return Err(format!("it has {} of its {count} rows: resume it first", lines.len()));
    }
    Ok(ReadPart { part, columns, lines })
}

/// Puts parts in order.
///
/// # Errors
/// If they are not the parts of one sweep, or one is missing, or twice there. The number of the part and why.
pub fn order<'t>(parts: Vec<ReadPart<'t>>) -> Result<Vec<ReadPart<'t>>, (usize, String)> {
    let mut numbered: Vec<(usize, ReadPart<'t>)> = parts.into_iter().enumerate().collect();
    for (number, p) in &numbered {
        let first = &numbered[0].1;
        if p.part.id != first.part.id || p.part.rows[2] != first.part.rows[2] || p.columns != first.columns {
            return Err((*number, "it is of another sweep than the first".into()));
        }
        if p.part.form != first.part.form {
            return Err((*number, "it is not in the form of the first".into()));
        }
    }
    numbered.sort_by_key(|(_, p)| (p.part.rows[0], p.part.rows[1]));
    let mut next = 0;
    for (number, p) in &numbered {
        match p.part.rows[0] {
            at if at > next => return Err((*number, format!("the rows {next} to {} before it are missing", at - 1))),
            at if at < next => return Err((*number, format!("its row {at} is in another part too"))),
            _ => next = p.part.rows[1],
        }
    }
    if let Some((number, p)) = numbered.last()
        && next != p.part.rows[2]
    {
        return Err((*number, format!("the rows {next} to {} behind it are missing", p.part.rows[2] - 1)));
    }
    Ok(numbered.into_iter().map(|(_, p)| p).collect())
}
