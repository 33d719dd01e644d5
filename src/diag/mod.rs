//! Diagnostics: what is wrong, where it stands, and what to do.
//!
//! A [`Diagnostic`] has a stable [`Code`], a message, places in the files and hints; [`Diagnostics`] collects all of
//! one run, so that every fault is told at once. This room knows texts and offsets, nothing of circuits.

mod code;
mod render;
mod source;

pub use code::{Code, Severity};
use serde::{Deserialize, Serialize};
pub use source::{FileId, Sources, Span};

/// A place and what is to be said about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// A few words; may be empty.
    pub text: String,
    /// Whether the fault is here; the other labels explain it.
    pub primary: bool,
}

/// One fault.
///
/// ```
/// use discreta::diag::{Code, Diagnostic, Sources, Span};
/// let mut sources = Sources::new();
/// let file = sources.add("a.json", "{ \"y\": \"ab\" }".to_owned());
/// let fault = Diagnostic::new(Code::UnknownNet, "there is no net `ab`")
///     .at(Span::new(file, 8, 10), "not found")
///     .help("a net with a similar name exists: `abc`");
/// assert!(fault.render(&sources, false).starts_with("error[unknown-net]: there is no net `ab`\n --> a.json:1:9\n"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnostic {
    /// What kind of fault it is.
    pub code: Code,
    /// What is wrong, in one line.
    pub message: String,
    /// Where. The first primary one is *the* place.
    pub labels: Vec<Label>,
    /// Facts that help to understand it.
    pub notes: Vec<String>,
    /// What to do.
    pub helps: Vec<String>,
}

impl Diagnostic {
    /// A fault without a place yet.
    #[must_use]
    pub fn new(code: Code, message: impl Into<String>) -> Diagnostic {
        Diagnostic { code, message: message.into(), labels: Vec::new(), notes: Vec::new(), helps: Vec::new() }
    }

    /// The fault is here.
    #[must_use]
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { span, text: text.into(), primary: true });
        self
    }

    /// A further place that explains it.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { span, text: text.into(), primary: false });
        self
    }

    /// A fact that helps to understand it.
    #[must_use]
    pub fn note(mut self, text: impl Into<String>) -> Diagnostic {
        self.notes.push(text.into());
        self
    }

    /// What to do.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Diagnostic {
        self.helps.push(text.into());
        self
    }

    /// "Did you mean …" for a name that was not found, if a similar one exists.
    #[must_use]
    pub fn did_you_mean<'a>(self, name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Diagnostic {
        match nearest(name, candidates) {
            Some(found) => self.help(format!("did you mean `{found}`?")),
            None => self,
        }
    }

    /// *The* place of the fault, if it has one.
    #[must_use]
    pub fn place(&self) -> Option<Span> {
        let primary = self.labels.iter().find(|l| l.primary);
        primary.or(self.labels.first()).map(|l| l.span)
    }

    /// Error or warning.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }

    /// The fault as text for a person, as rustc writes it.
    #[must_use]
    pub fn render(&self, sources: &Sources, color: bool) -> String {
        render::render(&self.at_origins(sources), sources, color)
    }

    /// The fault for a machine.
    #[must_use]
    pub fn to_json(&self, sources: &Sources) -> serde_json::Value {
        render::to_json(&self.at_origins(sources), sources)
    }

    /// The same with every place where it comes from.
    fn at_origins(&self, sources: &Sources) -> Diagnostic {
        let mut moved = self.clone();
        moved.labels.iter_mut().for_each(|label| label.span = sources.origin(label.span));
        moved
    }
}

/// How many diagnostics are kept; more are only counted.
const MAX_KEPT: usize = 10_000;
/// How many diagnostics are written out as text.
const MAX_SHOWN: usize = 100;

/// The faults of one run.
#[derive(Debug, Default)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    errors: usize,
    warnings: usize,
}

impl Diagnostics {
    /// None yet.
    #[must_use]
    pub fn new() -> Diagnostics {
        Diagnostics::default()
    }

    /// Adds one. A run keeps 10,000 of them; beyond that they are only counted.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        match diagnostic.severity() {
            Severity::Error => self.errors += 1,
            Severity::Warning => self.warnings += 1,
        }
        if self.list.len() < MAX_KEPT {
            self.list.push(diagnostic);
        }
    }

    /// Adds all of another run.
    pub fn append(&mut self, other: Diagnostics) {
        self.errors += other.errors;
        self.warnings += other.warnings;
        let room = MAX_KEPT.saturating_sub(self.list.len());
        self.list.extend(other.list.into_iter().take(room));
    }

    /// Whether there is an error (warnings are none).
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// How many errors there are.
    #[must_use]
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// How many warnings there are.
    #[must_use]
    pub fn warnings(&self) -> usize {
        self.warnings
    }

    /// Whether there is nothing to tell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.errors + self.warnings == 0
    }

    /// The faults that are kept, in their present order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Removes the warnings for which `drop` holds.
    pub fn drop_warnings(&mut self, mut drop: impl FnMut(&Diagnostic) -> bool) {
        let before = self.list.len();
        self.list.retain(|d| d.severity() == Severity::Error || !drop(d));
        self.warnings -= before - self.list.len();
    }

    /// Puts the faults in the order of their places (file, then offset; those without a place first) and drops
    /// those that say the same as another.
    pub fn sort(&mut self) {
        self.list.sort_by(|a, b| (a.place(), a.code, &a.message).cmp(&(b.place(), b.code, &b.message)));
        let (errors, warnings) = self.count();
        self.list.dedup();
        let (errors_left, warnings_left) = self.count();
        self.errors -= errors - errors_left;
        self.warnings -= warnings - warnings_left;
    }

    fn count(&self) -> (usize, usize) {
        let errors = self.list.iter().filter(|d| d.severity() == Severity::Error).count();
        (errors, self.list.len() - errors)
    }

    /// All as text for a person. Of more than 100, errors go first and the rest is counted.
    #[must_use]
    pub fn render(&self, sources: &Sources, color: bool) -> String {
        let mut shown: Vec<&Diagnostic> = self.list.iter().collect();
        if shown.len() > MAX_SHOWN {
            shown.sort_by_key(|d| d.severity());
            shown.truncate(MAX_SHOWN);
        }
        let mut text = String::new();
        for diagnostic in &shown {
            text.push_str(&diagnostic.render(sources, color));
            text.push('\n');
        }
        let more = self.errors + self.warnings - shown.len();
        if more > 0 {
            text.push_str(&format!("and {more} more\n"));
        }
        text
    }

    /// All for a machine, as an array.
    #[must_use]
    pub fn to_json(&self, sources: &Sources) -> serde_json::Value {
        self.list.iter().map(|d| d.to_json(sources)).collect()
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<I: IntoIterator<Item = Diagnostic>>(&mut self, list: I) {
        list.into_iter().for_each(|d| self.push(d));
    }
}

/// Names compared with an unknown one; looking further would only take time.
const MAX_CANDIDATES: usize = 20_000;

/// The candidate that `name` was probably meant to be: equal but for case, or within a third of its letters (at least
/// one) of added, dropped, changed or swapped ones.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = name.chars().count();
    if letters > 100 {
        return None;
    }
    let allowed = (letters / 3).max(1);
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates.into_iter().take(MAX_CANDIDATES) {
        if candidate.len().abs_diff(name.len()) > 4 * allowed {
            continue;
        }
        let distance =
            if candidate.eq_ignore_ascii_case(name) { 0 } else { strsim::damerau_levenshtein(name, candidate) };
        // One letter for another one is no likeness.
        let alike = distance <= allowed && distance < letters.max(candidate.chars().count());
        if alike && best.is_none_or(|(d, c)| (distance, candidate) < (d, c)) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name() {
        let names = ["connections", "parameters", "type", "repeat", "a", "b"];
        assert_eq!(nearest("conections", names), Some("connections"));
        assert_eq!(nearest("TYPE", names), Some("type"));
        assert_eq!(nearest("tpye", names), Some("type"));
        assert_eq!(nearest("c", names), None, "one letter for another");
        assert_eq!(nearest("A", names), Some("a"));
        assert_eq!(nearest("", names), None);
        assert_eq!(nearest("zzzzzz", names), None);
        assert_eq!(nearest(&"x".repeat(1_000_000), names), None);
        assert_eq!(nearest("ad", ["ac", "ab"]), Some("ab"), "the same whatever the order");
    }

    #[test]
    fn faults_are_sorted_counted_and_told_once() {
        let mut sources = Sources::new();
        let file = sources.add("a", "0123456789".to_owned());
        let at = |code, n| Diagnostic::new(code, "m").at(Span::new(file, n, n + 1), "");
        let mut all = Diagnostics::new();
        all.extend([at(Code::UnusedNet, 5), at(Code::Undriven, 3), at(Code::UnusedNet, 5)]);
        all.push(Diagnostic::new(Code::NoTop, "m"));
        assert_eq!((all.errors(), all.warnings()), (2, 2));
        all.sort();
        assert_eq!((all.errors(), all.warnings()), (2, 1));
        let codes: Vec<Code> = all.iter().map(|d| d.code).collect();
        assert_eq!(codes, [Code::NoTop, Code::Undriven, Code::UnusedNet]);
        all.drop_warnings(|d| d.code == Code::UnusedNet);
        assert_eq!((all.errors(), all.warnings()), (2, 0));
    }

    #[test]
    fn a_flood_of_faults_is_cut_and_errors_are_not_lost_in_it() {
        let sources = Sources::new();
        let mut all = Diagnostics::new();
        for n in 0..200 {
            all.push(Diagnostic::new(Code::UnusedNet, format!("warning {n}")));
        }
        all.push(Diagnostic::new(Code::NoTop, "the error"));
        let text = all.render(&sources, false);
        assert!(text.contains("the error"), "{text}");
        assert!(text.ends_with("and 101 more\n"), "{text}");
        for n in 0..20_000 {
            all.push(Diagnostic::new(Code::NoTop, format!("{n}")));
        }
        assert_eq!(all.iter().count(), MAX_KEPT);
        assert_eq!(all.errors(), 20_001);
        let mut more = Diagnostics::new();
        more.push(Diagnostic::new(Code::NoMatch, "a warning"));
        more.append(all);
        assert_eq!((more.iter().count(), more.errors(), more.warnings()), (MAX_KEPT, 20_001, 201));
    }
}
