//! What is expected of a run.

use super::{Expectation, Resolver, Rule, Scenario};
use crate::Value;
use crate::diag::{Code, Diagnostic};
use crate::netlist::NetId;
use crate::scenario::TimingCheck;
use crate::syntax::scenario::{Expect, Simulation, ValueText};
use crate::syntax::{Expr, Name};

impl Resolver<'_> {
    /// A number of times.
    fn count(&mut self, expr: &Expr, what: &str) -> Option<u64> {
        let n = self.number(expr)?;
        self.times(n, expr, what)
    }

    /// A number of times that may depend on what the inputs are at the start.
    fn count_of(&mut self, expr: &Expr, simulation: &Simulation, inputs: &[(NetId, Value)], what: &str) -> Option<u64> {
        let mut names = self.circuit.parameters.clone();
        for name in expr.names() {
            let Some(signal) = self.netlist.find(name).filter(|_| !names.contains_key(name)) else { continue };
            let signal = self.netlist.signal(signal);
            let Some(drive) = signal.drive else { continue };
            let Some(value) = inputs.iter().find(|i| i.0 == drive).map(|i| &i.1) else {
                if simulation.inputs.contains_key(name) {
                    return None; // its fault has been told
                }
                let message = format!("the input `{name}` has no value at the start");
                return self.fault(Diagnostic::new(Code::BadScenario, message).at(expr.span(), "depends on it"));
            };
            let number = if signal.signed { value.to_i64() } else { value.to_u64().and_then(|n| n.try_into().ok()) };
            let Some(number) = number else {
                let message = format!("`{name}` is {value} at the start, which is no number here");
                return self.fault(Diagnostic::new(Code::BadScenario, message).at(expr.span(), "depends on it"));
            };
            names.insert(name.to_owned(), number);
        }
        let n = self.ok(expr.eval(&names))?;
        self.times(n, expr, what)
    }

    fn times(&mut self, n: i64, expr: &Expr, what: &str) -> Option<u64> {
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
            let fault = Diagnostic::new(Code::BadScenario, "with `violations` 0 there is no first one, and so no time");
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
        scenario: &Scenario,
    ) -> Option<Expectation> {
        if let Some(name) = &expect.check {
            return self.violated(name, expect, simulation, &scenario.checks);
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
            Rule::Pulses(self.count_of(expect.pulses.as_ref()?, simulation, &scenario.inputs, "pulses")?)
        };
        let span = expect.value.as_ref().map_or(net.span, ValueText::span);
        Some(Expectation { signal, rule, span })
    }
}
