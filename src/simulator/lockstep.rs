//! Two simulators side by side, and where they first part.

use std::fmt;

use super::{Simulator, SimulatorError};
use crate::Value;
use crate::netlist::SignalId;

/// Where two simulators part: the first signal, in the order of the left circuit, of which they show different values.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Difference {
    /// The tick.
    pub time: u64,
    /// The signal.
    pub name: String,
    /// What the left simulator shows.
    pub left: Value,
    /// What the right simulator shows.
    pub right: Value,
    /// How many other signals differ at the same tick.
    pub others: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "at tick {} `{}` is {} on the left and {} on the right",
            self.time, self.name, self.left, self.right
        )?;
        if self.others > 0 { write!(f, ", and {} more differ", self.others) } else { Ok(()) }
    }
}

/// Two simulators that are driven alike and compared after every step, on the signals that both have by the same name and of
/// the same width: two engines on one circuit, or two circuits that are to do the same.
///
/// ```
/// use discreta::{EngineKind, Lockstep, Simulator, circuit};
///
/// let line = circuit::load("circuits/evaluation/line.json")?;
/// let mut both = Lockstep::new(Simulator::new(&line), Simulator::with(&line, EngineKind::Event)?)?;
/// both.step(|sim| {
///     for (name, value) in [("dt", 0), ("start", 1), ("dx", 5), ("dy", 3), ("xh", 0), ("yh", 0)] {
///         sim.poke(name, value)?;
///     }
///     sim.settle()
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Lockstep {
    left: Simulator,
    right: Simulator,
    /// What both have.
    pairs: Vec<(SignalId, SignalId)>,
}

impl Lockstep {
    /// Puts two simulators side by side.
    ///
    /// # Errors
    /// If they have no signal in common.
    pub fn new(left: Simulator, right: Simulator) -> Result<Lockstep, SimulatorError> {
        let (a, b) = (&left.netlist, &right.netlist);
        let of: std::collections::HashMap<String, SignalId> =
            b.signal_ids().map(|id| (b.signal_path(id), id)).collect();
        let pair = |id: SignalId| {
            let other = *of.get(&a.signal_path(id))?;
            (b.signal(other).width == a.signal(id).width).then_some((id, other))
        };
        let pairs: Vec<_> = a.signal_ids().filter_map(pair).collect();
        if pairs.is_empty() {
            return Err(SimulatorError::Engine("the two circuits have no signal in common".to_owned()));
        }
        Ok(Lockstep { left, right, pairs })
    }

    /// Does the same to both, and compares them.
    ///
    /// # Errors
    /// What `act` says, and [`SimulatorError::Differs`] where they part.
    pub fn step(&mut self, act: impl Fn(&mut Simulator) -> Result<(), SimulatorError>) -> Result<(), SimulatorError> {
        act(&mut self.left)?;
        act(&mut self.right)?;
        self.compare()
    }

    /// Runs both to a tick, from one instant to the next, and compares them at each.
    ///
    /// # Errors
    /// As [`step`](Lockstep::step), and as [`Simulator::run_to`].
    pub fn run_to(&mut self, tick: u64) -> Result<(), SimulatorError> {
        loop {
            let next = |sim: &Simulator| sim.engine.next_event().unwrap_or(tick);
            let next = next(&self.left).min(next(&self.right)).min(tick);
            self.step(|sim| sim.run_to(next))?;
            if next == tick {
                return Ok(());
            }
        }
    }

    /// Where they part at present, if they do.
    #[must_use]
    pub fn difference(&self) -> Option<Difference> {
        let values = |&(a, b): &(SignalId, SignalId)| (self.left.signal_value(a), self.right.signal_value(b));
        let mut parted = self.pairs.iter().map(|pair| (pair, values(pair))).filter(|(_, (a, b))| a != b);
        let ((id, _), (left, right)) = parted.next()?;
        let name = self.left.netlist.signal_path(*id);
        Some(Difference { time: self.left.now(), name, left, right, others: parted.count() })
    }

    fn compare(&self) -> Result<(), SimulatorError> {
        self.difference().map_or(Ok(()), |d| Err(SimulatorError::Differs(Box::new(d))))
    }

    /// The left simulator.
    pub fn left(&mut self) -> &mut Simulator {
        &mut self.left
    }

    /// The right simulator.
    pub fn right(&mut self) -> &mut Simulator {
        &mut self.right
    }
}
