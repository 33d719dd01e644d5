//! `--stop-on`: what ends a run before its scenario does.

use super::CliError;
use crate::diag::Span;
use crate::engine::Engine;
use crate::netlist::{NetId, Netlist, SignalId};
use crate::scenario::{Observer, glob_path, glob_set, value};
use crate::syntax::{Expr, Names};

/// Ends a run when one of its conditions comes true.
pub(super) struct Stop<'n> {
    netlist: &'n Netlist,
    conditions: Vec<Condition>,
    /// What ended the run, and the net by which it did.
    pub hit: Option<(String, Option<SignalId>)>,
}

enum Condition {
    /// One of these nets becomes x after it was known: each with whether it was.
    Unknown { text: String, signals: Vec<(SignalId, bool)> },
    /// An expression over nets is not 0.
    Holds { text: String, expr: Expr, names: Vec<(String, SignalId)> },
}

/// The numbers of nets; an x in one makes it none.
struct Values(Vec<(String, Option<i64>)>);

impl Names for Values {
    fn get(&self, name: &str) -> Option<i64> {
        self.0.iter().find(|(known, _)| known == name)?.1
    }

    fn all(&self) -> Vec<&str> {
        Vec::new()
    }
}

impl<'n> Stop<'n> {
    /// Reads conditions as they are typed.
    ///
    /// # Errors
    /// One that cannot be read, or names a net that is not there or too wide for arithmetic.
    pub fn new(netlist: &'n Netlist, texts: &[String]) -> Result<Stop<'n>, CliError> {
        let conditions = texts.iter().map(|text| condition(netlist, text)).collect::<Result<_, _>>()?;
        Ok(Stop { netlist, conditions, hit: None })
    }
}

fn condition(netlist: &Netlist, text: &str) -> Result<Condition, CliError> {
    if let Some(glob) = text.strip_prefix("x:") {
        let set =
            glob_set(glob).map_err(|why| CliError::usage(format!("`{glob}` is not a pattern for nets: {why}")))?;
        let shown = netlist.signal_ids().filter(|&s| !netlist.signal(s).hidden && set.is_match(glob_path(netlist, s)));
        let signals: Vec<(SignalId, bool)> = shown.map(|signal| (signal, false)).collect();
        if signals.is_empty() {
            return Err(CliError::usage(format!("`{glob}` matches no net")));
        }
        return Ok(Condition::Unknown { text: text.to_owned(), signals });
    }
    let (plain, paths) = plain(text);
    let expr = Expr::parse(&plain, Span::default())
        .map_err(|fault| CliError::usage(format!("`{text}` cannot be read: {}", fault.message)))?;
    let mut names = Vec::new();
    for name in expr.names() {
        let path = paths.iter().find(|(short, _)| short == name).map_or(name, |(_, path)| path);
        let Some(signal) = netlist.find(path) else {
            let all: Vec<String> = netlist.signal_ids().map(|s| netlist.signal_path(s)).collect();
            let error = CliError::usage(format!("the circuit has no net `{path}`"));
            return Err(match crate::diag::nearest(path, all.iter().map(String::as_str)) {
                Some(near) => error.with_hint(format!("did you mean `{near}`?")),
                None => error,
            });
        };
        if netlist.signal(signal).width > 63 {
            return Err(CliError::usage(format!(
                "`{path}` is wider than 63 bits, beyond which there are no expressions"
            )));
        }
        names.push((name.to_owned(), signal));
    }
    Ok(Condition::Holds { text: text.to_owned(), expr, names })
}

/// An expression in which paths (`u1.q`, `stage[3].q`) are simple names and literals (`8'hff`, `0xff`) are decimal; and what the
/// names stand for.
fn plain(text: &str) -> (String, Vec<(String, String)>) {
    let mut plain = String::new();
    let mut paths = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let is_word = |c: char| c.is_ascii_alphanumeric() || "_$.'[]".contains(c);
        if !(c.is_ascii_alphanumeric() || c == '_' || c == '$') {
            plain.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        }
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let word = &rest[..end];
        rest = &rest[end..];
        let number = match word.strip_prefix("0x") {
            Some(hex) => u64::from_str_radix(hex, 16).ok(),
            None if word.contains('\'') => word.parse::<crate::Value>().ok().and_then(|value| value.to_u64()),
            None => None,
        };
        match number {
            Some(number) => plain += &number.to_string(),
            None if word.contains(['.', '[', '$']) => {
                let name = format!("net_{}", paths.len());
                plain += &name;
                paths.push((name, word.to_owned()));
            }
            None => plain += word,
        }
    }
    (plain, paths)
}

impl Observer for Stop<'_> {
    fn nets(&self) -> Vec<NetId> {
        let of = |condition: &Condition| -> Vec<SignalId> {
            match condition {
                Condition::Unknown { signals, .. } => signals.iter().map(|s| s.0).collect(),
                Condition::Holds { names, .. } => names.iter().map(|n| n.1).collect(),
            }
        };
        let signals = self.conditions.iter().flat_map(of);
        signals.flat_map(|signal| self.netlist.bits(signal)).map(|slice| slice.net).collect()
    }

    fn look(&mut self, engine: &dyn Engine) -> bool {
        for condition in &mut self.conditions {
            match condition {
                Condition::Unknown { text, signals } => {
                    for (signal, known) in signals {
                        let now = value(self.netlist, engine, *signal);
                        if now.is_known() {
                            *known = true;
                        } else if *known {
                            self.hit = Some((text.clone(), Some(*signal)));
                            return true;
                        }
                    }
                }
                Condition::Holds { text, expr, names } => {
                    let number = |signal: SignalId| {
                        let now = value(self.netlist, engine, signal);
                        if self.netlist.signal(signal).signed { now.to_i64() } else { now.to_u64().map(|n| n as i64) }
                    };
                    let values = names.iter().map(|(name, signal)| (name.clone(), number(*signal))).collect();
                    // what is x, overflows or divides by zero does not hold
                    if expr.eval(&Values(values)).is_ok_and(|n| n != 0) {
                        self.hit = Some((text.clone(), None));
                        return true;
                    }
                }
            }
        }
        false
    }
}
