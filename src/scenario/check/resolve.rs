//! From a check as it is written to nets and ticks.

use super::super::resolve::Resolver;
use super::{Check, CheckRule, Level, Side, Timing, TimingCheck};
use crate::diag::{Code, Diagnostic};
use crate::netlist::SignalId;
use crate::scenario::{Edge, TimeText};
use crate::syntax::Name;

impl TimingCheck {
    /// Resolves a check; what is faulty is told and left out.
    pub(in crate::scenario) fn resolve(r: &mut Resolver<'_>, name: &Name, check: &Check) -> Option<TimingCheck> {
        let rule = check.rule.value;
        let wide = matches!(rule, CheckRule::Setup | CheckRule::Hold) && check.edge.is_none();
        // every fault is told, so nothing returns early
        let net = if wide { r.signal(&check.net) } else { bit(r, &check.net, rule) };
        let on =
            check.on.as_ref().map(|on| (bit(r, &on.net, rule), on.edge.as_ref().map_or(Edge::Rising, |e| e.value)));
        let of = check.of.as_ref().map(|of| bit(r, of, rule));
        let min = check.min.as_ref().map(|min| positive(r, min, "with a `min` of 0 ticks the check can never fail"));
        let max = check.max.as_ref().map(|max| positive(r, max, "with a `max` of 0 ticks the check would always fail"));
        let depth = check.depth.as_ref().map(|depth| {
            let n = r.number(depth)?;
            let fault = |message: String| Diagnostic::new(Code::BadScenario, message).at(depth.span(), "");
            match u64::try_from(n) {
                Ok(n @ 1..) => Some(n),
                _ => r.fault(fault(format!("a store cannot hold {n} steps"))),
            }
        });
        if let (Some(Some(min)), Some(Some(max)), Some(text)) = (min, max, &check.max)
            && min > max
        {
            let fault = Diagnostic::new(Code::BadScenario, format!("`min` is {min} ticks, above `max`, {max} ticks"));
            return r.fault(fault.at(text.span(), "nothing can hold this"));
        }
        let (net, other) = (net?, on.map(|o| o.0).or(of));
        if let (Some(Some(other)), Some(name)) = (other, check.on.as_ref().map(|o| &o.net).or(check.of.as_ref()))
            && other == net
        {
            let fault = Diagnostic::new(Code::BadScenario, format!("`{}` is checked against itself", name.value));
            return r.fault(fault.at(name.span, "name another net"));
        }
        // a faulty time is not the same as none
        let time = |given: Option<Option<u64>>| match given {
            Some(None) => None,
            Some(ticks) => Some(ticks),
            None => Some(None),
        };
        let (min, max) = (time(min)?, time(max)?);
        let edge = check.edge.as_ref().map(|e| e.value);
        let timing = match rule {
            CheckRule::Width | CheckRule::Runt => {
                let level = check.level.as_ref().map_or(Level::High, |l| l.value) == Level::High;
                Timing::Width { level, min, max }
            }
            CheckRule::Period => Timing::Period { edge: edge.unwrap_or_default(), min, max },
            CheckRule::Setup | CheckRule::Hold | CheckRule::Recovery => {
                let (on, on_edge) = on?;
                let side = match rule {
                    CheckRule::Setup => Side::Setup,
                    CheckRule::Hold => Side::Hold,
                    _ => Side::Recovery,
                };
                Timing::Window { side, edge, on: on?, on_edge, min: min? }
            }
            CheckRule::Steps => Timing::Steps { of: of??, depth: time(depth)? },
        };
        Some(TimingCheck { name: name.value.clone(), rule, net, timing, span: check.rule.span })
    }
}

/// A net that has edges.
fn bit(r: &mut Resolver<'_>, name: &Name, rule: CheckRule) -> Option<SignalId> {
    let signal = r.signal(name)?;
    match r.width(signal) {
        1 => Some(signal),
        width => {
            let message = format!("`{}` has {width} bits; a `{}` check is about one", name.value, rule.name());
            r.fault(Diagnostic::new(Code::BadScenario, message).at(name.span, "its edges cannot be told"))
        }
    }
}

/// A time that is not 0; `why` it may not be.
fn positive(r: &mut Resolver<'_>, time: &TimeText, why: &str) -> Option<u64> {
    match r.ticks(time)? {
        0 => r.fault(Diagnostic::new(Code::BadScenario, why).at(time.span(), "1 tick or more")),
        ticks => Some(ticks),
    }
}
