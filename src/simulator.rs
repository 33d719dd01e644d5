//! A circuit under test in a few lines: poke inputs, step, peek at nets.
//!
//! Names are looked up once and become typed handles; the loop after that uses no strings.

use std::cell::RefCell;
use std::fmt;

use crate::Value;
use crate::cell::Clock;
use crate::engine::{Engine, EventEngine, Unsettled};
use crate::netlist::{NetId, Netlist, Slice};
use crate::value::Word;
use crate::value::word::{copy, extract, mask, words};

/// An input of a circuit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Input {
    /// The netlist that it is of.
    of: u64,
    net: NetId,
    width: u32,
}

/// A net, port or other named signal whose value can be read.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Probe {
    /// The netlist that it is of.
    of: u64,
    name: String,
    bits: Vec<Slice>,
    width: u32,
}

/// What can go wrong with a [`Simulator`].
#[derive(Clone, PartialEq, Eq, Debug)]
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
}

impl fmt::Display for SimulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SimulatorError::Unknown { name, nearest: Some(nearest) } => {
                write!(f, "the circuit has no signal `{name}`; did you mean `{nearest}`?")
            }
            SimulatorError::Unknown { name, nearest: None } => write!(f, "the circuit has no signal `{name}`"),
            SimulatorError::NotAnInput(name) => write!(f, "`{name}` is not an input of the circuit"),
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
        }
    }
}

impl std::error::Error for SimulatorError {}

/// Runs a netlist, on the reference engine unless it is given another.
///
/// ```
/// use discreta::{Simulator, Value};
///
/// let circuit = discreta::circuit::load("circuits/evaluation/line.json")?;
/// let mut sim = Simulator::new(&circuit.netlist);
/// let [start, dt, dx, dy, xh, yh] = ["start", "dt", "dx", "dy", "xh", "yh"].map(|n| sim.input(n).unwrap());
/// let [x, y, end] = ["x", "y", "end"].map(|n| sim.probe(n).unwrap());
///
/// for (input, value) in [(dt, 0), (dx, 5), (dy, 3), (xh, 0), (yh, 0), (start, 1)] {
///     sim.set(input, value);
/// }
/// sim.settle()?;
/// sim.set(start, 0);
/// sim.settle()?;
/// let mut steps = String::new();
/// while sim.number(&end) != Some(1) {
///     sim.set(dt, 1);
///     sim.settle()?;
///     steps.push(if sim.number(&x) == Some(1) { 'X' } else { 'Y' });
///     sim.set(dt, 0);
///     sim.settle()?;
/// }
/// assert_eq!(steps, "XYXYXXYX");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Simulator<'n, E: Engine = EventEngine> {
    netlist: &'n Netlist,
    engine: E,
    /// The first thing that could not be meant since the circuit settled last.
    fault: RefCell<Option<SimulatorError>>,
}

impl<'n> Simulator<'n> {
    /// A simulator at tick 0 with nothing driven.
    #[must_use]
    pub fn new(netlist: &'n Netlist) -> Simulator<'n> {
        Simulator::on(netlist, EventEngine::new(netlist))
    }

    /// Back to the state of a new simulator; clocks stay.
    pub fn reset(&mut self) {
        self.engine.reset();
    }
}

impl<'n, E: Engine> Simulator<'n, E> {
    /// A simulator on an engine of this netlist.
    #[must_use]
    pub fn on(netlist: &'n Netlist, engine: E) -> Simulator<'n, E> {
        Simulator { netlist, engine, fault: RefCell::new(None) }
    }

    fn find(&self, name: &str) -> Result<crate::netlist::SignalId, SimulatorError> {
        self.netlist.find(name).ok_or_else(|| {
            let all: Vec<String> = self.netlist.signal_ids().map(|s| self.netlist.signal_path(s)).collect();
            let nearest = crate::diag::nearest(name, all.iter().map(String::as_str)).map(str::to_owned);
            SimulatorError::Unknown { name: name.to_owned(), nearest }
        })
    }

    /// The input of a name.
    ///
    /// # Errors
    /// If the circuit has no such signal, or it is not an input.
    pub fn input(&self, name: &str) -> Result<Input, SimulatorError> {
        let id = self.find(name)?;
        let signal = self.netlist.signal(id);
        signal
            .drive
            .map(|net| Input { of: self.netlist.identity(), net, width: signal.width })
            .ok_or_else(|| SimulatorError::NotAnInput(name.to_owned()))
    }

    /// The signal of a name, which is its path below the top module: `f`, `adder.fa[3].s`.
    ///
    /// # Errors
    /// If the circuit has no such signal.
    pub fn probe(&self, name: &str) -> Result<Probe, SimulatorError> {
        let id = self.find(name)?;
        let of = self.netlist.identity();
        Ok(Probe {
            of,
            name: name.to_owned(),
            bits: self.netlist.bits(id).to_vec(),
            width: self.netlist.signal(id).width,
        })
    }

    /// Whether a handle is of this circuit; if not, the next [`settle`](Simulator::settle) says so.
    fn owns(&self, of: u64, name: impl FnOnce() -> String) -> bool {
        let own = of == self.netlist.identity();
        if !own {
            self.fault.borrow_mut().get_or_insert_with(|| SimulatorError::Foreign(name()));
        }
        own
    }

    fn no_fault(&mut self) -> Result<(), SimulatorError> {
        self.fault.get_mut().take().map_or(Ok(()), Err)
    }

    /// Sets an input to the low bits of a number, to take effect at the next [`settle`](Simulator::settle), which also
    /// says if the input is another circuit's.
    #[inline]
    pub fn set(&mut self, input: Input, value: u64) {
        if !self.owns(input.of, || format!("the input of net {}", input.net.index())) {
            return;
        }
        if input.width <= 64 {
            self.engine.drive(input.net, &[Word::known(value & mask(input.width))]);
        } else {
            self.set_value(input, &Value::from_u64(value, input.width));
        }
    }

    /// Sets an input to a value, of which missing high bits are 0.
    pub fn set_value(&mut self, input: Input, value: &Value) {
        if !self.owns(input.of, || format!("the input of net {}", input.net.index())) {
            return;
        }
        let mut all = vec![Word::ZERO; words(input.width)];
        for (i, (to, from)) in all.iter_mut().zip(value.words()).enumerate() {
            let m = crate::value::word::word_mask(input.width, i);
            *to = Word { v: from.v & m, u: from.u & m };
        }
        self.engine.drive(input.net, &all);
    }

    /// Drives an input by a clock. The next [`settle`](Simulator::settle) or [`run_to`](Simulator::run_to) says if it
    /// cannot be one.
    pub fn clock(&mut self, input: Input, clock: Clock) {
        if !self.owns(input.of, || format!("the input of net {}", input.net.index())) {
            return;
        }
        if !(1..clock.period).contains(&clock.high) {
            let input = self.netlist.net_name(input.net);
            self.fault.get_mut().get_or_insert(SimulatorError::BadClock { input, clock });
            return;
        }
        self.engine.add_clock(input.net, clock);
    }

    /// Lets inputs that were set take effect, and everything settle, at the present tick.
    ///
    /// # Errors
    /// If something never settles, or something before could not be meant: a handle of another circuit, a clock that is
    /// none.
    #[inline]
    pub fn settle(&mut self) -> Result<(), SimulatorError> {
        self.no_fault()?;
        self.engine.settle().map_err(|e| self.error(&e))
    }

    /// Runs clocks and delays up to the given tick.
    ///
    /// # Errors
    /// If the tick is past, and as [`settle`](Simulator::settle).
    pub fn run_to(&mut self, tick: u64) -> Result<(), SimulatorError> {
        self.no_fault()?;
        if tick < self.now() {
            return Err(SimulatorError::Past { now: self.now(), asked: tick });
        }
        while self.engine.advance(tick).map_err(|e| self.error(&e))? {
            self.engine.clear_changes();
            self.engine.take_unknown_controls();
        }
        Ok(())
    }

    /// The present time in ticks of the netlist's timescale.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.engine.now()
    }

    /// The number that a signal holds; none if a bit is x or z, or it is wider than 64 bits.
    #[inline]
    #[must_use]
    pub fn number(&self, probe: &Probe) -> Option<u64> {
        if !self.owns(probe.of, || format!("`{}`", probe.name)) {
            return None;
        }
        if probe.width > 64 {
            return self.value(probe).to_u64();
        }
        let (mut number, mut at) = (0, 0);
        for s in &probe.bits {
            let from = self.engine.read(s.net);
            let w = if s.lo / 64 == (s.lo + s.width - 1) / 64 {
                let w = from[s.lo as usize / 64];
                Word { v: w.v >> (s.lo % 64) & mask(s.width), u: w.u >> (s.lo % 64) & mask(s.width) }
            } else {
                let mut w = [Word::ZERO];
                extract(&mut w, from, s.lo, s.width);
                w[0]
            };
            if w.u != 0 {
                return None;
            }
            number |= w.v << at;
            at += s.width;
        }
        Some(number)
    }

    /// The value of a signal; x for that of another circuit, as the next [`settle`](Simulator::settle) says.
    #[must_use]
    pub fn value(&self, probe: &Probe) -> Value {
        if !self.owns(probe.of, || format!("`{}`", probe.name)) {
            return Value::unknown(probe.width);
        }
        let mut all = vec![Word::ZERO; words(probe.width)];
        read_bits(&self.engine, &probe.bits, &mut all);
        Value::from_words(&all, probe.width)
    }

    /// How many net changes there have been, or 0 where the engine does not count them.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.engine.events().unwrap_or(0)
    }

    fn error(&self, e: &Unsettled) -> SimulatorError {
        SimulatorError::Unsettled { time: e.time, nets: e.names(self.netlist) }
    }
}

/// Reads the bits of a signal into words.
pub(crate) fn read_bits(engine: &dyn Engine, bits: &[Slice], to: &mut [Word]) {
    let mut at = 0;
    // what is above the signal's width counts where words are compared
    to.fill(Word::ZERO);
    for s in bits {
        let from = engine.read(s.net);
        if let ([only], true) = (bits, s.lo == 0) {
            to.copy_from_slice(&from[..words(only.width)]);
            let last = words(only.width) - 1;
            let m = crate::value::word::word_mask(only.width, last);
            to[last] = Word { v: to[last].v & m, u: to[last].u & m };
            return;
        }
        copy(to, at, from, s.lo, s.width);
        at += s.width;
    }
}
