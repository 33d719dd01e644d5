//! What the circuit itself says: `$print`, `$assert`, `$assume`, `$check` and `$cover` of a netlist of Yosys.

use std::sync::Arc;

use super::{Simulator, SimulatorError};
use crate::engine::Engine;
use crate::import::yosys::Monitor;
use crate::import::yosys::monitor::{Flavor, Seen, When};

/// Something that the circuit said.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Message {
    /// The tick.
    pub time: u64,
    /// The cell that said it, by its path.
    pub name: String,
    /// What it said, with the line's end if it has one.
    pub text: String,
}

/// Messages that are kept for who asks for them; of more, the oldest go.
const MOST: usize = 10_000;

/// The monitors of a circuit, and what they have seen.
#[derive(Debug, Default)]
pub(super) struct Monitors {
    all: Arc<[Monitor]>,
    seen: Vec<Seen>,
    messages: std::collections::VecDeque<Message>,
}

impl Monitors {
    pub fn new(all: &Arc<[Monitor]>, engine: &mut dyn Engine, netlist: &crate::netlist::Netlist) -> Monitors {
        for monitor in &**all {
            let counter = if let When::Edge(counter) = monitor.when { Some(counter) } else { None };
            for signal in std::iter::once(monitor.signal).chain(counter) {
                netlist.bits(signal).iter().for_each(|s| engine.observe(s.net));
            }
        }
        Monitors { all: all.clone(), seen: vec![Seen::default(); all.len()], messages: Default::default() }
    }

    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// What has been covered so far, for a saved state.
    pub fn covered(&self) -> Vec<bool> {
        self.seen.iter().map(Seen::is_covered).collect()
    }
}

impl Simulator {
    /// Lets the monitors look at the present values.
    pub(super) fn look(&mut self) -> Result<(), SimulatorError> {
        let mut failed = None;
        for i in 0..self.monitors.all.len() {
            let all = Arc::clone(&self.monitors.all);
            let mut seen = std::mem::take(&mut self.monitors.seen[i]);
            let time = self.engine.now();
            let said = all[i].look(&mut seen, time, |signal| self.signal_value(signal));
            self.monitors.seen[i] = seen;
            let Some(text) = said else { continue };
            let name = all[i].source.clone().unwrap_or_else(|| all[i].name.clone());
            if all[i].fails() {
                failed.get_or_insert(SimulatorError::Assertion { time, name, text });
            } else if all[i].flavor == Flavor::Print {
                if self.monitors.messages.len() == MOST {
                    self.monitors.messages.pop_front();
                }
                self.monitors.messages.push_back(Message { time, name, text });
            }
        }
        failed.map_or(Ok(()), Err)
    }

    /// What the circuit has said since this was last asked: the last 10,000 messages at most.
    pub fn take_messages(&mut self) -> Vec<Message> {
        self.monitors.messages.drain(..).collect()
    }

    /// What was to happen at least once (`$cover`) and has not, by its place in the source or its path.
    #[must_use]
    pub fn uncovered(&self) -> Vec<String> {
        let all = self.monitors.all.iter().zip(&self.monitors.seen).filter(|(m, seen)| m.is_uncovered(seen));
        all.map(|(m, _)| m.source.clone().unwrap_or_else(|| m.name.clone())).collect()
    }

    /// Has the monitors take the present values for seen.
    pub(super) fn resume_monitors(&mut self, covered: &[bool]) {
        for i in 0..self.monitors.all.len() {
            let all = Arc::clone(&self.monitors.all);
            let covered = covered.get(i).copied().unwrap_or(false);
            self.monitors.seen[i] = all[i].seen(covered, |signal| self.signal_value(signal));
        }
    }
}
