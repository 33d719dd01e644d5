//! What `$print`, `$check`, `$assert`, `$assume` and `$cover` do in a run.
//!
//! Each watches signals of the netlist. Those that wait for a clock edge have flip-flops that sample what they say at it,
//! as all others do, and a counter of the edges.

use std::cmp::Reverse;

use super::format::{Piece, render};
use crate::netlist::{ScopeId, SignalId};
use crate::{Logic, Value};

/// What a cell is for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Flavor {
    /// To say something.
    Print,
    /// What must hold.
    Assert,
    /// What the surroundings must keep to.
    Assume,
    /// What is to happen at least once.
    Cover,
}

/// When a cell acts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum When {
    /// Whenever what it reads changes.
    Changed,
    /// When a counter of clock edges does.
    Edge(SignalId),
    /// Once, at the start.
    Start,
}

/// A cell that says something while a circuit runs.
#[derive(Clone, Debug)]
pub struct Monitor {
    /// What it is for.
    pub flavor: Flavor,
    /// Its path.
    pub name: String,
    /// Where it comes from in the source that Yosys read.
    pub source: Option<String>,
    /// When it acts.
    pub when: When,
    /// Whether it acts, in bit 0, whether its condition holds, in bit 1, and its arguments.
    pub signal: SignalId,
    /// The named nets that its condition is made of, and how many bits each has; their values stand above the arguments.
    pub operands: Vec<(String, u32)>,
    /// What it says.
    pub format: Vec<Piece>,
    /// The scope of its module.
    pub scope: ScopeId,
    /// Its priority among these.
    pub priority: i64,
    /// The number at the end of its name, by which Yosys tells cells of one line apart.
    pub number: Option<u64>,
}

/// Monitors in the order in which they speak when they act at one tick: module by module, by descending priority, as Yosys
/// defines it. Yosys counts priorities anew in each process, so where one comes twice, process comes after process: the
/// numbers at the ends of names go up through the source, and a priority that does not go down begins the next one.
pub fn ordered(mut monitors: Vec<Monitor>) -> Vec<Monitor> {
    monitors.sort_by_key(|m| m.scope);
    for list in monitors.chunk_by_mut(|a, b| a.scope == b.scope) {
        list.sort_by_key(|m| Reverse(m.priority));
        let once = list.windows(2).all(|pair| pair[0].priority != pair[1].priority || pair[0].name == pair[1].name);
        if !once && list.iter().all(|m| m.number.is_some()) {
            list.sort_by_key(|m| m.number);
        }
    }
    monitors
}

/// What has become of a check so far.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    value: Option<Value>,
    edges: Option<Value>,
    covered: bool,
}

impl Seen {
    /// The values of what a monitor's condition is made of, as it last looked at them.
    #[must_use]
    pub fn operands(&self, monitor: &Monitor) -> Vec<(String, Value)> {
        let Some(now) = &self.value else { return Vec::new() };
        let mut at = monitor.arguments_end(now);
        let mut found = Vec::new();
        for (name, width) in &monitor.operands {
            let mut value = Value::unknown(*width);
            (0..*width).for_each(|i| value.set_bit(i, now.bit(at + i)));
            found.push((name.clone(), value));
            at += width;
        }
        found
    }
}

impl Seen {
    /// Whether what was to happen has.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.covered
    }
}

impl Monitor {
    /// What it has seen that has looked at the present values, of which `value` reads one.
    pub fn seen(&self, covered: bool, mut value: impl FnMut(SignalId) -> Value) -> Seen {
        let edges = if let When::Edge(counter) = self.when { Some(value(counter)) } else { None };
        Seen { value: Some(value(self.signal)), edges, covered }
    }

    /// Looks at the present values, of which `value` reads one; what is said, if anything is. A condition that is unknown
    /// does not hold, but that it has never been known yet is no news.
    pub fn look(&self, seen: &mut Seen, time: u64, mut value: impl FnMut(SignalId) -> Value) -> Option<String> {
        let first = seen.value.is_none();
        let now = value(self.signal);
        let news = match self.when {
            When::Changed => {
                let end = self.arguments_end(&now);
                let same = |before: &Value| (0..end).all(|bit| before.bit(bit) == now.bit(bit));
                let no_news = seen.value.as_ref().is_some_and(same) || first && now.bit(1) == Logic::X;
                !no_news
            }
            When::Start => first,
            When::Edge(counter) => {
                let edges = value(counter);
                let before = seen.edges.replace(edges.clone());
                before.map_or(edges.to_u64() != Some(0), |b| b != edges)
            }
        };
        seen.value = Some(now.clone());
        if !news || now.bit(0) != Logic::One {
            return None;
        }
        let holds = now.bit(1) == Logic::One;
        let says = match self.flavor {
            Flavor::Print => true,
            Flavor::Assert | Flavor::Assume => !holds,
            Flavor::Cover => holds && !std::mem::replace(&mut seen.covered, true),
        };
        says.then(|| {
            let end = self.arguments_end(&now);
            let mut arguments = Value::from_u64(0, end - 2);
            (2..end).for_each(|i| arguments.set_bit(i - 2, now.bit(i)));
            render(&self.format, &arguments, time)
        })
    }

    /// The bit after those of the arguments.
    fn arguments_end(&self, now: &Value) -> u32 {
        now.width() - self.operands.iter().map(|operand| operand.1).sum::<u32>()
    }

    /// Whether it was to happen and did not.
    #[must_use]
    pub fn is_uncovered(&self, seen: &Seen) -> bool {
        self.flavor == Flavor::Cover && !seen.covered
    }

    /// Whether what it says is a failure.
    #[must_use]
    pub fn fails(&self) -> bool {
        matches!(self.flavor, Flavor::Assert | Flavor::Assume)
    }
}
