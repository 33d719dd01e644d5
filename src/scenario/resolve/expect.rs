//! What is expected of a run.

use super::{Expectation, Resolver, Rule};
use crate::diag::{Code, Diagnostic};
use crate::scenario::TimingCheck;
use crate::syntax::scenario::{Expect, Simulation, ValueText};
use crate::syntax::{Expr, Name};

impl Resolver<'_> {
    /// A number of times.
    fn count(&mut self, expr: &Expr, what: &str) -> Option<u64> {
        let n = self.number(expr)?;
        let Ok(n) = u64::try_from(n) else {
            let message = format!("there cannot be {n} {what}");
            return self.fault(Diagnostic::new(Code::BadScenario, message).at(expr.span(), ""));
        };
        Some(n)
    }

    /// A violation that is expected; `checks` are those without a fault.
    fn violated(
        &mut self,
        name: &Name,
        expect: &Expect,
        simulation: &Simulation,
        checks: &[TimingCheck],
    ) -> Option<Expectation> {
        if !simulation.checks.contains_key(name.value.as_str()) {
            let names = simulation.checks.keys().map(|n| n.value.as_str());
            let message = format!("the scenario has no timing check `{}`", name.value);
            let fault = Diagnostic::new(Code::UnknownCheck, message).at(name.span, "not among its `checks`");
            return self.fault(fault.did_you_mean(name, names));
        }
        let count = match &expect.violations {
            Some(n) => Some(self.count(n, "violations")?),
            None => None,
        };
        let first = match &expect.at {
            Some(at) => Some(self.ticks(at)?),
            None => None,
        };
        if let (Some(0), Some(_), Some(violations)) = (count, first, &expect.violations) {
            let fault = Diagnostic::new(Code::BadScenario, "without a violation there is no time of the first");
            return self.fault(fault.at(violations.span(), "1 or more, or leave out `at`"));
        }
        let check = checks.iter().position(|c| c.name == name.value)?;
        let span = expect.violations.as_ref().map_or(name.span, Expr::span);
        Some(Expectation { signal: checks[check].net, rule: Rule::Violated { check, count, first }, span })
    }

    pub(super) fn expect(
        &mut self,
        expect: &Expect,
        simulation: &Simulation,
        checks: &[TimingCheck],
    ) -> Option<Expectation> {
        if let Some(name) = &expect.check {
            return self.violated(name, expect, simulation, checks);
        }
        let net = expect.net.as_ref()?;
        let signal = self.signal(net)?;
        let width = self.netlist.signal(signal).width;
        let rule = if let Some(value) = &expect.value {
            let at = match &expect.at {
                Some(at) => Some(self.ticks(at)?),
                None => None,
            };
            Rule::Value(at, self.value(value, width)?)
        } else {
            Rule::Pulses(self.count(expect.pulses.as_ref()?, "pulses")?)
        };
        let span = expect.value.as_ref().map_or(net.span, ValueText::span);
        Some(Expectation { signal, rule, span })
    }
}
