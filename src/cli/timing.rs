//! What is told of the timing checks of a run: in the summary, as diagnostics, for programs.

use serde_json::{Value as Json, json};

use super::prepare::Prepared;
use super::report::time;
use crate::diag::{Code, Diagnostic};
use crate::scenario::{CheckReport, CheckRule, Edge, Fault, Outcome, Rule, Timing, TimingCheck, Violation};

/// Each check with its number and how it went.
fn reports<'a>(
    prepared: &'a Prepared,
    outcome: &'a Outcome,
) -> impl Iterator<Item = (usize, &'a TimingCheck, &'a CheckReport)> {
    prepared.scenario.checks.iter().zip(&outcome.checks).enumerate().map(|(i, (check, report))| (i, check, report))
}

/// Whether nothing was violated that was not to be.
pub(super) fn hold(prepared: &Prepared, outcome: &Outcome) -> bool {
    reports(prepared, outcome).all(|(i, _, report)| report.count == 0 || prepared.scenario.expects(i))
}

/// A line for the summary, if there are checks.
pub(super) fn summary(prepared: &Prepared, outcome: &Outcome) -> Option<String> {
    let n = prepared.scenario.checks.len();
    let violated: Vec<String> = reports(prepared, outcome)
        .filter(|(_, _, report)| report.count > 0)
        .map(|(i, check, report)| {
            let failed = outcome.failures.iter().any(|f| is_about(prepared, f.expectation, i));
            let expected = if prepared.scenario.expects(i) && !failed { " as expected" } else { "" };
            format!("{} violated {}{expected}", check.name, times(report.count))
        })
        .collect();
    let checks = format!("{n} timing check{}", if n == 1 { "" } else { "s" });
    match (n, violated.is_empty()) {
        (0, _) => None,
        (1, true) => Some(format!("{checks} holds")),
        (_, true) => Some(format!("{checks} hold")),
        (_, false) => Some(format!("{checks}: {}", violated.join(", "))),
    }
}

/// Whether an expectation is about a check.
fn is_about(prepared: &Prepared, expectation: usize, check: usize) -> bool {
    matches!(prepared.scenario.expect[expectation].rule, Rule::Violated { check: c, .. } if c == check)
}

/// A number of times.
pub(super) fn times(n: u64) -> String {
    match n {
        1 => "once".to_owned(),
        n => format!("{n} times"),
    }
}

/// The violations that were not expected, one diagnostic a check.
pub(super) fn diagnostics(prepared: &Prepared, outcome: &Outcome) -> Vec<Diagnostic> {
    let unexpected = reports(prepared, outcome).filter(|(i, _, _)| !prepared.scenario.expects(*i));
    unexpected
        .filter_map(|(_, check, report)| {
            let (first, others) = report.first.split_first()?;
            let tell = |v: &Violation| {
                format!("at {} {}", time(&prepared.circuit.netlist, v.time), sentence(prepared, check, v))
            };
            let fault =
                Diagnostic::new(Code::Timing, tell(first)).at(check.span, format!("timing check `{}`", check.name));
            let fault = others.iter().fold(fault, |d, v| d.note(tell(v)));
            let more = report.count - report.first.len() as u64;
            Some(if more > 0 { fault.note(format!("and {} more", times(more))) } else { fault })
        })
        .collect()
}

/// What was wrong, as a sentence.
fn sentence(prepared: &Prepared, check: &TimingCheck, v: &Violation) -> String {
    let netlist = &prepared.circuit.netlist;
    let net = netlist.signal_path(check.net);
    let (measured, required) = (time(netlist, v.measured), time(netlist, v.required));
    let bound = match v.fault {
        Fault::TooLong => format!("more than {required}"),
        _ => format!("less than {required}"),
    };
    let did = |edge: Option<Edge>| match edge {
        Some(Edge::Rising) => "rose",
        Some(Edge::Falling) => "fell",
        None => "changed",
    };
    match check.timing {
        Timing::Width { level, .. } => {
            let runt = if check.rule == CheckRule::Runt { "a runt pulse: " } else { "" };
            format!("{runt}`{net}` was {} for {measured}, {bound}", if level { "high" } else { "low" })
        }
        Timing::Period { edge, .. } => {
            let did = did(Some(edge));
            format!("`{net}` {did} {measured} after it last {did}, {bound}")
        }
        Timing::Window { edge, on, on_edge, .. } => {
            let side = if v.fault == Fault::TooSoon { "after" } else { "before" };
            let on = netlist.signal_path(on);
            format!("`{net}` {} {measured} {side} `{on}` {}, {bound}", did(edge), did(Some(on_edge)))
        }
        Timing::Steps { of, .. } => {
            let of = netlist.signal_path(of);
            let s = |n: u64| if n == 1 { "" } else { "s" };
            let (n, m) = (v.measured, v.required);
            match v.fault {
                Fault::Overfull => format!("{n} pulses of `{of}` wait for `{net}`, more than the {m} that are stored"),
                Fault::Lost => format!("`{net}` has had {n} pulse{} of the {m} of `{of}`: steps lost", s(n)),
                _ => format!("`{net}` has had {n} pulse{}, `{of}` {m}: steps gained", s(n)),
            }
        }
    }
}

/// The checks for programs. Times are in ticks.
pub(super) fn to_json(prepared: &Prepared, outcome: &Outcome, places: &crate::diag::Sources) -> Vec<Json> {
    let netlist = &prepared.circuit.netlist;
    let list = reports(prepared, outcome).map(|(i, check, report)| {
        let (line, column) = places.line_col(check.span);
        let first = report.first.iter().map(|v| {
            json!({
                "time": v.time, "fault": v.fault, "measured": v.measured, "required": v.required,
                "message": sentence(prepared, check, v),
            })
        });
        json!({
            "check": check.name,
            "rule": check.rule,
            "net": netlist.signal_path(check.net),
            "file": places.name(check.span.file),
            "line": line,
            "column": column,
            "count": report.count,
            "expected": prepared.scenario.expects(i),
            "violations": first.collect::<Vec<_>>(),
        })
    });
    list.collect()
}
