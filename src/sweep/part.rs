//! The parts of a sweep: what a file of results says of itself, how it is read back, and how parts are put together.
//!
//! A part is believed row by row: as many fields as columns, the swept values that the plan has for that row, a reason and
//! a time of its end, values. What its rows come to stands after them, so that no change of a part passes.

use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

use super::plan::{Over, Plan};
pub use super::table::field;
use super::table::{Form, swept};
use crate::digest::Digest;
use crate::{Value, safe};

/// What a file of results is a part of. The first line of a part.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Part {
    /// The circuit file.
    pub circuit: String,
    /// What was swept, as it was asked for.
    pub over: Vec<String>,
    /// For each swept input its bits, and whether they are read in two's complement.
    #[serde(default)]
    pub inputs: Vec<(u32, bool)>,
    /// Of a sample how many combinations were drawn, and the seed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<(u64, u64)>,
    /// What circuit and options come to, in short: parts of one sweep have the same.
    pub id: String,
    /// The form of the rows.
    pub form: Form,
    /// The first row, the one after the last, and how many the whole sweep has.
    pub rows: [u64; 3],
}

impl Part {
    /// The combinations of the whole sweep; none if a file of before does not say enough.
    fn plan(&self) -> Result<Option<Plan>, String> {
        if self.inputs.is_empty() {
            return Ok(None);
        }
        let overs: Vec<Over> = self.over.iter().map(|o| o.parse()).collect::<Result<_, _>>()?;
        if overs.len() != self.inputs.len() {
            return Err(format!("it has the widths of {} inputs for {}", self.inputs.len(), overs.len()));
        }
        let axes = overs.iter().zip(&self.inputs).map(|(over, &(width, signed))| over.values(width, signed));
        let plan = axes.collect::<Result<_, _>>().and_then(Plan::new);
        let plan = plan.and_then(|plan| match self.sample {
            Some((count, seed)) => plan.sample(count, seed),
            None => Ok(plan),
        });
        let plan = plan.map_err(|e| e.to_string())?;
        match plan.total() == self.rows[2] {
            true => Ok(Some(plan)),
            false => Err(format!("it speaks of {} rows where there are {}", self.rows[2], plan.total())),
        }
    }
}

/// What stands before the description of a part in CSV.
const MARK: &str = "# discreta sweep ";
/// What stands before that which the rows of a part come to in CSV.
const END: &str = "# end ";
/// The same in JSON.
const JSON_END: &str = "],\n\"check\":";

/// What comes before the rows. Of a part it says which.
#[must_use]
pub fn head(part: &Part, columns: &[String]) -> String {
    match part.form {
        Form::Csv => {
            let names: Vec<String> = columns.iter().map(|name| field(Form::Csv, name)).collect();
            let mark = if is_whole(part) {
                String::new()
            } else {
                format!("{MARK}{}\n", safe::json(&json!(part).to_string()))
            };
            format!("{mark}{}\n", names.join(","))
        }
        Form::Json => head_of(part, &json!(columns).to_string()),
    }
}

/// Whether a part is all of its sweep.
fn is_whole(part: &Part) -> bool {
    part.rows[0] == 0 && part.rows[1] == part.rows[2]
}

/// The same as [`head`] of JSON, the columns as they stand in it.
#[must_use]
pub fn head_of(part: &Part, columns: &str) -> String {
    format!("{{\"sweep\":{},\n\"columns\":{columns},\n\"rows\":[\n", safe::json(&json!(part).to_string()))
}

/// What comes between two rows.
#[must_use]
pub fn between(form: Form) -> &'static str {
    if form == Form::Json { ",\n" } else { "\n" }
}

/// What comes after all rows, of which there are some or none: what they come to, but for a whole sweep in CSV, which is
/// for programs that know nothing of this.
#[must_use]
pub fn tail(part: &Part, any: bool, rows: &Digest) -> String {
    let line = if any { "\n" } else { "" };
    match part.form {
        Form::Json => format!("{line}{JSON_END}\"{}\"}}\n", rows.text()),
        Form::Csv if is_whole(part) => line.to_owned(),
        Form::Csv => format!("{line}{END}{}\n", rows.text()),
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

/// Why a file is no part, and its line, from 1 up, if one is to blame.
pub type Fault = (Option<usize>, String);

/// Reads a part.
///
/// # Errors
/// Why it is none.
pub fn read(text: &str) -> Result<ReadPart<'_>, Fault> {
    let none = || (None, "this is no part of a sweep: those are written with --shard".to_owned());
    let broken = |what: &str| (None, format!("it breaks off before its {what}"));
    let (description, columns, mut lines, first): (&str, &str, Vec<&str>, usize) =
        if let Some(rest) = text.strip_prefix(MARK) {
            let (part, rest) = rest.split_once('\n').ok_or_else(none)?;
            let (columns, rest) = rest.split_once('\n').ok_or_else(|| broken("columns"))?;
            if !rest.is_empty() && !rest.ends_with('\n') {
                return Err((Some(text.lines().count()), "it breaks off within a row".into()));
            }
            (part, columns, rest.lines().collect(), 3)
        } else {
            let rest = text.strip_prefix("{\"sweep\":").ok_or_else(none)?;
            let (part, rest) = rest.split_once(",\n\"columns\":").ok_or_else(none)?;
            let (columns, rest) = rest.split_once(",\n\"rows\":[\n").ok_or_else(none)?;
            let rows = rest.strip_suffix("}\n").ok_or_else(|| broken("end"))?;
            (part, columns, rows.lines().collect(), 4)
        };
    let part: Part = serde_json::from_str(description).map_err(|e| (Some(1), e.to_string()))?;
    let check = match part.form {
        Form::Csv => lines.pop_if(|last| last.starts_with(END)).map(|last| last[END.len()..].to_owned()),
        Form::Json => json_end(&mut lines).ok_or_else(|| broken("end"))?,
    };
    let count = part.rows[1].checked_sub(part.rows[0]).filter(|_| part.rows[1] <= part.rows[2]);
    let count = count.ok_or_else(|| (Some(1), format!("it cannot hold the rows {:?}", part.rows)))?;
    let rows = Rows::of(&part, columns).map_err(|why| (Some(1), why))?;
    let mut digest = Digest::default();
    let last = lines.len();
    for (i, line) in lines.iter_mut().enumerate() {
        let fault = |why: String| (Some(first + i), why);
        if part.form == Form::Json && i + 1 < last {
            *line = line.strip_suffix(',').ok_or_else(|| fault("a comma is missing after the row".into()))?;
        }
        if i as u64 >= count {
            return Err(fault(format!("a row too many: it is to have {count}")));
        }
        rows.check(part.rows[0] + i as u64, line).map_err(fault)?;
        digest.line(line);
    }
    if lines.len() as u64 != count {
        return Err((None, format!("it has {} of its {count} rows: resume it first", lines.len())));
    }
    // parts of before the check have no widths either
    if check.is_none() && !part.inputs.is_empty() {
        return Err((None, "it breaks off before its end".into()));
    }
    if check.is_some_and(|check| check != digest.text()) {
        return Err((None, "its rows are not as they were written: one of them was changed".into()));
    }
    Ok(ReadPart { part, columns, lines })
}

/// Takes off what stands after the rows in JSON; what it says the rows come to, if it does.
fn json_end(lines: &mut Vec<&str>) -> Option<Option<String>> {
    match lines.pop()? {
        "]" => Some(None),
        last => {
            let check = last.strip_prefix("\"check\":\"")?.strip_suffix('"')?;
            (lines.pop()? == "],").then(|| Some(check.to_owned()))
        }
    }
}

/// What the rows of a part have to be.
pub struct Rows {
    part: Part,
    plan: Option<Plan>,
    columns: Vec<String>,
}

impl Rows {
    /// Those of a part with these columns, as they stand in it.
    ///
    /// # Errors
    /// What is wrong with its description.
    pub fn of(part: &Part, columns: &str) -> Result<Rows, String> {
        let columns = match part.form {
            Form::Csv => fields(columns)?,
            Form::Json => serde_json::from_str(columns).map_err(|e| e.to_string())?,
        };
        if columns.len() < part.over.len() + 2 || columns[part.over.len()..][..2] != ["stop", "time"] {
            return Err("its columns are not those of a sweep".into());
        }
        Ok(Rows { part: part.clone(), plan: part.plan()?, columns })
    }

    /// Looks at row `number`.
    ///
    /// # Errors
    /// Why it cannot be that row.
    pub fn check(&self, number: u64, line: &str) -> Result<(), String> {
        let fields = match self.part.form {
            Form::Csv => fields(line)?,
            Form::Json => {
                let row: Vec<Json> = serde_json::from_str(line).map_err(|_| "this is no row".to_owned())?;
                let text = |json: Json| match json {
                    Json::String(text) => Ok(text),
                    Json::Number(n) => Ok(n.to_string()),
                    Json::Null => Ok(String::new()),
                    other => Err(format!("{other} is no value")),
                };
                row.into_iter().map(text).collect::<Result<_, _>>()?
            }
        };
        if fields.len() != self.columns.len() {
            return Err(format!("this row has {} fields, there are {} columns", fields.len(), self.columns.len()));
        }
        let (inputs, rest) = fields.split_at(self.part.over.len());
        if let Some(plan) = &self.plan {
            let expected = plan.values(number).zip(&self.part.inputs);
            for ((found, column), (value, &(width, signed))) in inputs.iter().zip(&self.columns).zip(expected) {
                // as it stands between quotes, if it does
                let expected = swept(Form::Csv, value, width, signed);
                if *found != expected {
                    return Err(format!(
                        "this row is for `{column}` {found}, row {number} of the sweep is for {expected}"
                    ));
                }
            }
        } else if let Some(bad) = inputs.iter().find(|f| !is_value(f)) {
            return Err(format!("`{bad}` is no value"));
        }
        if !["until", "limit", "idle", "unsettled"].contains(&rest[0].as_str()) {
            return Err(format!("a run does not end by `{}`", rest[0]));
        }
        if rest[1].parse::<u64>().is_err() {
            return Err(format!("`{}` is no time", rest[1]));
        }
        for (found, column) in rest[2..].iter().zip(&self.columns[inputs.len() + 2..]) {
            let right = match column.as_str() {
                "difference" if found.starts_with("clock ") || found.starts_with("refused: ") => true,
                // what never settled has no results
                _ => found.is_empty() || is_value(found),
            };
            if !right {
                return Err(format!("`{found}` is no value of `{column}`"));
            }
        }
        Ok(())
    }
}

fn is_value(text: &str) -> bool {
    text.parse::<u64>().is_ok() || text.parse::<i64>().is_ok() || text.parse::<Value>().is_ok()
}

/// The fields of a line of CSV.
fn fields(line: &str) -> Result<Vec<String>, String> {
    let mut fields = Vec::new();
    let mut rest = line;
    loop {
        let (field, after) = match rest.strip_prefix('"') {
            None => {
                let end = rest.find(',').unwrap_or(rest.len());
                (rest[..end].to_owned(), &rest[end..])
            }
            Some(quoted) => {
                let (mut field, mut left) = (String::new(), quoted);
                loop {
                    let (text, after) = left.split_once('"').ok_or("a quotation mark is not closed")?;
                    field += text;
                    match after.strip_prefix('"') {
                        Some(more) => {
                            field.push('"');
                            left = more;
                        }
                        None => break (field, after),
                    }
                }
            }
        };
        fields.push(field);
        match after.strip_prefix(',') {
            Some(more) => rest = more,
            None if after.is_empty() => return Ok(fields),
            None => return Err("something stands behind a quotation mark".into()),
        }
    }
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
            return Err((*number, "it belongs to another sweep than the first".into()));
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
