//! A circuit under test in a few lines: poke inputs, step, peek at nets.
//!
//! Names are looked up once and become typed handles; a loop over these uses no strings. What acts by name says at once what is
//! wrong; what acts by handle, in the loop, leaves that to the next [`settle`](Simulator::settle).

mod error;
mod handle;
mod lockstep;
mod memory;
mod monitors;
mod overrides;
mod state;
mod trace;

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use crate::Value;
use crate::cell::Clock;
use crate::circuit::Circuit;
use crate::engine::{Engine, EngineKind, UnknownControl, Unsettled, read_bits};
use crate::import::yosys::Monitor;
use crate::netlist::{NetId, Netlist, SignalId, Slice};
use crate::value::Word;
use crate::value::word::{extract, mask, words};

pub use error::SimulatorError;
pub use handle::{Input, IntoValue, MemoryHandle, Probe};
pub use lockstep::{Difference, Lockstep};
pub use monitors::Message;
pub use state::State;
pub use trace::Trace;

use monitors::Monitors;
use trace::Tracing;

/// What a simulator is made of: a netlist, and what the circuit says while it runs. A [`Circuit`] has both.
#[derive(Clone, Debug)]
pub struct Model {
    netlist: Netlist,
    monitors: Arc<[Monitor]>,
}

impl From<&Netlist> for Model {
    fn from(netlist: &Netlist) -> Model {
        Model { netlist: netlist.clone(), monitors: Arc::new([]) }
    }
}

impl From<Netlist> for Model {
    fn from(netlist: Netlist) -> Model {
        Model { netlist, monitors: Arc::new([]) }
    }
}

impl From<&Circuit> for Model {
    fn from(circuit: &Circuit) -> Model {
        Model { netlist: circuit.netlist.clone(), monitors: circuit.monitors.as_slice().into() }
    }
}

impl From<Circuit> for Model {
    fn from(circuit: Circuit) -> Model {
        Model { netlist: circuit.netlist, monitors: circuit.monitors.into() }
    }
}

/// Runs a circuit. It owns what it needs, and moves between threads.
///
/// ```
/// use discreta::{Simulator, circuit};
///
/// let line = circuit::load("circuits/evaluation/line.json")?;
/// let mut sim = Simulator::new(&line);
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
pub struct Simulator {
    netlist: Netlist,
    engine: Box<dyn Engine>,
    monitors: Monitors,
    tracing: Option<Tracing>,
    /// Clocks that drive inputs.
    clocks: Vec<(NetId, Clock)>,
    /// Inputs and probes that were found by name.
    inputs: HashMap<Box<str>, Input>,
    probes: HashMap<Box<str>, Arc<Probe>>,
    /// The first thing that could not be meant since the circuit settled last.
    fault: RefCell<Option<SimulatorError>>,
    unknown_controls: Vec<UnknownControl>,
    /// The circuit has settled once, so that values can be recorded.
    settled: bool,
    /// It did not settle when it was to last.
    broken: bool,
}

/// Ticks for which [`Simulator::tick`] holds a clock at 1 and then at 0.
const HALF: u64 = 1;

impl Simulator {
    /// A simulator at tick 0 with nothing driven, of a [`Circuit`] or a [`Netlist`]; on the event engine at first, and by
    /// machine code if it turns out to run for long.
    #[must_use]
    pub fn new(model: impl Into<Model>) -> Simulator {
        let model = model.into();
        let engine = EngineKind::Auto.engine(&model.netlist).expect("it runs whatever there is");
        Simulator::made(model, engine)
    }

    /// The same on an engine of this kind.
    ///
    /// # Errors
    /// If that cannot run the circuit.
    pub fn with(model: impl Into<Model>, kind: EngineKind) -> Result<Simulator, SimulatorError> {
        let model = model.into();
        let engine = kind.engine(&model.netlist).map_err(|e| SimulatorError::Engine(e.to_string()))?;
        Ok(Simulator::made(model, engine))
    }

    /// The same on an engine that was made for its netlist.
    #[must_use]
    pub fn on(model: impl Into<Model>, engine: impl Engine + 'static) -> Simulator {
        Simulator::made(model.into(), Box::new(engine))
    }

    fn made(model: Model, mut engine: Box<dyn Engine>) -> Simulator {
        let Model { netlist, monitors } = model;
        Simulator {
            monitors: Monitors::new(&monitors, &mut *engine, &netlist),
            netlist,
            engine,
            tracing: None,
            clocks: Vec::new(),
            inputs: HashMap::new(),
            probes: HashMap::new(),
            fault: RefCell::new(None),
            unknown_controls: Vec::new(),
            settled: false,
            broken: false,
        }
    }

    /// The circuit.
    #[must_use]
    pub fn netlist(&self) -> &Netlist {
        &self.netlist
    }

    fn find(&self, name: &str) -> Result<SignalId, SimulatorError> {
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
        let (bits, width) = (self.netlist.bits(id).to_vec(), self.netlist.signal(id).width);
        Ok(Probe { of, name: name.to_owned(), bits, width })
    }

    fn known_input(&mut self, name: &str) -> Result<Input, SimulatorError> {
        if let Some(&known) = self.inputs.get(name) {
            return Ok(known);
        }
        let input = self.input(name)?;
        self.inputs.insert(name.into(), input);
        Ok(input)
    }

    fn known_probe(&mut self, name: &str) -> Result<Arc<Probe>, SimulatorError> {
        if let Some(known) = self.probes.get(name) {
            return Ok(known.clone());
        }
        let probe = Arc::new(self.probe(name)?);
        self.probes.insert(name.into(), probe.clone());
        Ok(probe)
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

    /// Sets an input by its name: `sim.poke("d", 5)?`, `sim.poke("d", "4'b10x1")?`. It takes effect at the next
    /// [`settle`](Simulator::settle) or [`tick`](Simulator::tick).
    ///
    /// # Errors
    /// If there is no such input, or the value does not fit it.
    pub fn poke(&mut self, name: &str, value: impl IntoValue) -> Result<(), SimulatorError> {
        let input = self.known_input(name)?;
        let value = value.into_value(input.width);
        let value = value.map_err(|why| SimulatorError::BadValue { name: name.to_owned(), why })?;
        self.set_value(input, &value);
        Ok(())
    }

    /// The value of a signal by its name.
    ///
    /// # Errors
    /// If there is no such signal.
    pub fn peek(&mut self, name: &str) -> Result<Value, SimulatorError> {
        let probe = self.known_probe(name)?;
        Ok(self.value(&probe))
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
        self.clocks.retain(|c| c.0 != input.net);
        self.clocks.push((input.net, clock));
        self.engine.add_clock(input.net, clock);
    }

    /// Lets inputs that were set take effect, and everything settle, at the present tick.
    ///
    /// # Errors
    /// If something never settles, an assertion of the circuit fails, or something before could not be meant: a handle of
    /// another circuit, a clock that is none.
    #[inline]
    pub fn settle(&mut self) -> Result<(), SimulatorError> {
        self.no_fault()?;
        self.settled = true;
        let settled = self.engine.settle();
        self.after(settled)
    }

    /// What there is to do after a phase.
    #[inline]
    fn after(&mut self, settled: Result<(), Unsettled>) -> Result<(), SimulatorError> {
        self.broken = settled.is_err();
        settled.map_err(|e| SimulatorError::Unsettled { time: e.time, nets: e.names(&self.netlist) })?;
        if self.monitors.is_empty() && self.tracing.is_none() {
            return Ok(());
        }
        self.told()
    }

    /// Lets everything that looks at the circuit do so.
    fn told(&mut self) -> Result<(), SimulatorError> {
        let said = if self.monitors.is_empty() { Ok(()) } else { self.look() };
        self.record()?;
        self.engine.clear_changes();
        said
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
        self.settled = true;
        loop {
            // a waveform may begin or end on the way
            let border = self.tracing.as_ref().map_or(u64::MAX, |t| t.border(self.engine.now()));
            let to = tick.min(border);
            let stopped = self.engine.advance(to);
            let more = stopped.as_ref().is_ok_and(|&more| more);
            self.after(stopped.map(drop))?;
            self.unknown_controls.append(&mut self.engine.take_unknown_controls());
            self.engine.clear_changes();
            if !more {
                self.end_window()?;
                if to == tick {
                    return Ok(());
                }
            }
        }
    }

    /// One period of the clock at an input: 1 and then 0, for a tick of time each, starting with what was set before. Before
    /// the circuit has ever settled, the input is 0 first. Where [`clock`](Simulator::clock) drives the input, its whole period
    /// goes by.
    ///
    /// # Errors
    /// If there is no such input, and as [`settle`](Simulator::settle).
    pub fn tick(&mut self, clock: &str) -> Result<(), SimulatorError> {
        self.ticks(clock, 1)
    }

    /// As many periods of the clock at an input as `n`; see [`tick`](Simulator::tick).
    ///
    /// # Errors
    /// As [`tick`](Simulator::tick).
    pub fn ticks(&mut self, clock: &str, n: u64) -> Result<(), SimulatorError> {
        let input = self.known_input(clock)?;
        if let Some(&(_, driven)) = self.clocks.iter().find(|c| c.0 == input.net) {
            self.settle()?;
            return self.run_to(self.now().saturating_add(driven.period.saturating_mul(n)));
        }
        if input.width != 1 {
            let why = format!("a clock has one bit, it has {}", input.width);
            return Err(SimulatorError::BadValue { name: clock.to_owned(), why });
        }
        if !self.settled {
            // what nets become when the circuit first settles is no edge
            self.set(input, 0);
            self.settle()?;
        }
        for _ in 0..n {
            for level in [1, 0] {
                self.set(input, level);
                self.settle()?;
                self.run_to(self.now().saturating_add(HALF))?;
            }
        }
        Ok(())
    }

    /// Runs clocks and delays until a signal has a value, for at most so many ticks; returns the tick at which it has.
    ///
    /// # Errors
    /// If there is no such signal, the value does not fit it or does not come in time, and as
    /// [`settle`](Simulator::settle).
    pub fn run_until(&mut self, name: &str, value: impl IntoValue, ticks: u64) -> Result<u64, SimulatorError> {
        let probe = self.known_probe(name)?;
        let value = value.into_value(probe.width);
        let value = value.map_err(|why| SimulatorError::BadValue { name: name.to_owned(), why })?;
        let last = self.now().saturating_add(ticks);
        self.settle()?;
        loop {
            let found = self.value(&probe);
            if found == value {
                return Ok(self.now());
            }
            let next = self.engine.next_event().filter(|&next| next <= last);
            let Some(next) = next else {
                let (name, value, found) = (name.to_owned(), value.to_string(), found.to_string());
                return Err(SimulatorError::NotReached { name, value, found, time: self.now() });
            };
            self.run_to(next)?;
        }
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
        self.bits_value(&probe.bits, probe.width)
    }

    fn signal_value(&self, signal: SignalId) -> Value {
        self.bits_value(self.netlist.bits(signal), self.netlist.signal(signal).width)
    }

    fn bits_value(&self, bits: &[Slice], width: u32) -> Value {
        let mut all = vec![Word::ZERO; words(width)];
        read_bits(&*self.engine, bits, &mut all);
        Value::from_words(&all, width)
    }

    /// Where an x or z reached a clock or control of a storage cell since this was last asked, each cell once.
    pub fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        self.unknown_controls.append(&mut self.engine.take_unknown_controls());
        std::mem::take(&mut self.unknown_controls)
    }

    /// How many net changes there have been, or 0 where the engine does not count them.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.engine.events().unwrap_or(0)
    }

    /// Which engine it is and how it has gone, in a line for people.
    #[must_use]
    pub fn summary(&self) -> String {
        self.engine.summary()
    }
}

/// A waveform that nobody ended ends here: what failed in between is to be seen in it.
impl Drop for Simulator {
    fn drop(&mut self) {
        if self.tracing.is_some() {
            // there is nobody to tell that it could not be written
            let _ = self.end_trace();
        }
    }
}

/// It can be made in one thread and run in another.
const _: fn() = || {
    fn moves<T: Send>() {}
    moves::<Simulator>();
    moves::<Lockstep>();
    moves::<SimulatorError>();
};
