//! What can go wrong with a simulator.

use std::fmt;

use super::lockstep::Difference;
use crate::cell::Clock;
use crate::engine::SnapshotError;

/// What can go wrong with a [`Simulator`](super::Simulator).
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum SimulatorError {
    /// There is no such signal; the name nearest to it, if one is near.
    Unknown {
        /// The name that was asked for.
        name: String,
        /// The most similar name that the circuit has, if one is similar enough.
        nearest: Option<String>,
    },
    /// The signal is not an input of the circuit.
    NotAnInput(String),
    /// A handle that another circuit gave: an input's net, or the name of a probe.
    Foreign(String),
    /// What would run back in time.
    Past {
        /// The present tick.
        now: u64,
        /// The tick that was asked for.
        asked: u64,
    },
    /// A clock that never changes or is high for longer than it takes.
    BadClock {
        /// The input.
        input: String,
        /// Its clock.
        clock: Clock,
    },
    /// The circuit does not settle; the nets that keep changing, by name.
    Unsettled {
        /// The tick in which it keeps changing.
        time: u64,
        /// The paths of the nets that keep changing.
        nets: Vec<String>,
    },
    /// A value that does not fit its signal, or is none.
    BadValue {
        /// The signal or memory.
        name: String,
        /// What is wrong with the value.
        why: String,
    },
    /// A net that cannot be forced or deposited in: which, and why.
    Refused(String),
    /// There is no such memory; the names of those that there are.
    NoMemory {
        /// The name that was asked for.
        name: String,
        /// The paths of the circuit's memories.
        memories: Vec<String>,
    },
    /// A memory has no word at an address.
    NoWord {
        /// The memory.
        memory: String,
        /// The address that was asked for.
        address: i64,
        /// Its first and its last address.
        addresses: (i64, i64),
    },
    /// A signal did not come to a value in time.
    NotReached {
        /// The signal.
        name: String,
        /// The value that was waited for.
        value: String,
        /// What it is at the end.
        found: String,
        /// The tick at which it was given up.
        time: u64,
    },
    /// An assertion or assumption of the circuit failed.
    Assertion {
        /// The tick.
        time: u64,
        /// Where the circuit asserts it.
        name: String,
        /// What it says.
        text: String,
    },
    /// The circuit cannot run on the engine that was asked for: why.
    Engine(String),
    /// A waveform or a saved state that cannot be written or read: which file, and why.
    File(String),
    /// A saved state that cannot be restored.
    State(SnapshotError),
    /// What cannot be done while a waveform is being written, or can only be then.
    Tracing(&'static str),
    /// Two simulators in lockstep part.
    Differs(Box<Difference>),
}

impl fmt::Display for SimulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SimulatorError::Unknown { name, nearest: Some(nearest) } => {
                write!(f, "the circuit has no signal `{name}`; did you mean `{nearest}`?")
            }
            SimulatorError::Unknown { name, nearest: None } => write!(f, "the circuit has no signal `{name}`"),
            SimulatorError::NotAnInput(name) => {
                write!(f, "`{name}` is not an input of the circuit: force it, or deposit in it if it is storage")
            }
            SimulatorError::Foreign(name) => {
                write!(f, "{name} is of another circuit: ask this simulator for the handle")
            }
            SimulatorError::Past { now, asked } => write!(f, "tick {asked} is past: it is tick {now} already"),
            SimulatorError::BadClock { input, clock } => write!(
                f,
                "`{input}` cannot have a clock with a period of {} ticks of which {} are high: 0 < high < period",
                clock.period, clock.high
            ),
            SimulatorError::Unsettled { time, nets } => {
                write!(f, "at tick {time} the circuit never settles: {}", nets.join(", "))
            }
            SimulatorError::BadValue { name, why } => write!(f, "`{name}` cannot have that value: {why}"),
            SimulatorError::NoMemory { name, memories } if memories.is_empty() => {
                write!(f, "the circuit has no memory `{name}`, nor any other")
            }
            SimulatorError::NoMemory { name, memories } => {
                write!(f, "the circuit has no memory `{name}`; it has {}", memories.join(", "))
            }
            SimulatorError::NoWord { memory, address, addresses: (first, last) } => {
                write!(f, "memory `{memory}` has no word {address}: its addresses are {first} to {last}")
            }
            SimulatorError::NotReached { name, value, found, time } => {
                write!(f, "`{name}` has not become {value} by tick {time}: it is {found}")
            }
            SimulatorError::Assertion { time, name, text } if text.is_empty() => {
                write!(f, "at tick {time} the assertion `{name}` failed")
            }
            SimulatorError::Assertion { time, name, text } => {
                write!(f, "at tick {time} the assertion `{name}` failed: {}", text.trim_end())
            }
            SimulatorError::Refused(why) | SimulatorError::Engine(why) | SimulatorError::File(why) => f.write_str(why),
            SimulatorError::State(why) => write!(f, "the state cannot be restored: {why}"),
            SimulatorError::Tracing(why) => f.write_str(why),
            SimulatorError::Differs(difference) => write!(f, "{difference}"),
        }
    }
}

impl std::error::Error for SimulatorError {}

impl From<SnapshotError> for SimulatorError {
    fn from(why: SnapshotError) -> Self {
        SimulatorError::State(why)
    }
}
