//! One circuit on every engine that takes it, side by side: [`Together`] is an engine that drives the event engine, the
//! compiled engine and a lane of the batch engine alike and compares what they show after every instant. A test that
//! simulates through it has its results from all of them; [`ran`] says which did, so that none is left out unseen.

use std::cell::Cell;
use std::sync::Arc;

use discreta::cell::Clock;
use discreta::engine::batch::{BatchEngine, Program};
use discreta::engine::{Engine, EventEngine, Refused, Snapshot, SnapshotError, UnknownControl, Unsettled};
use discreta::netlist::{CellId, NetId, Netlist, Slice};
use discreta::value::Word;
use discreta::{Simulator, Value};

/// A simulator that runs on all engines.
pub type Sim = Simulator;

/// Instants after which they are compared at every 61st only (a prime, so that no clock keeps step with it), and the
/// lane of the batch engine, which computes all lanes for one, ends.
const CLOSELY: u64 = 2000;
const SELDOM: u64 = 61;

/// A simulator of a netlist on all engines.
pub fn simulator(netlist: &Netlist) -> Sim {
    Simulator::on(netlist, Together::new(netlist))
}

/// How many circuits each engine has run in the present test, and how often all of their nets were compared.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub struct Ran {
    pub event: usize,
    pub compiled: usize,
    pub batch: usize,
    pub compared: u64,
}

thread_local! {
    /// A test has a thread of its own.
    static RAN: Cell<Ran> = const { Cell::new(Ran { event: 0, compiled: 0, batch: 0, compared: 0 }) };
}

pub fn count(add: impl Fn(&mut Ran)) {
    let mut ran = RAN.get();
    add(&mut ran);
    RAN.set(ran);
}

/// What has run so far.
pub fn so_far() -> Ran {
    RAN.get()
}

/// Says which engines have run in this test; fails if the compiled or the batch engine has run fewer circuits than these.
pub fn ran(compiled: usize, batch: usize) {
    let ran = so_far();
    let Ran { event, compared, .. } = ran;
    println!("circuits: {event} event, {} compiled, {} batch; compared {compared} times", ran.compiled, ran.batch);
    assert!(event > 0 && compared > 0, "nothing was compared");
    assert!(ran.compiled >= compiled || !cfg!(feature = "compiled"), "{} of {compiled} compiled", ran.compiled);
    assert!(ran.batch >= batch, "{} of {batch} by the batch engine", ran.batch);
}

/// The same where all engines take every circuit.
pub fn all_ran() {
    let Ran { event, .. } = so_far();
    ran(event, event);
}

/// Fails where the compiled engine leaves a circuit for a reason that is none.
pub fn may_refuse(why: &str) {
    let reasons = ["delay", "memory", "feedback", "a power of more than 64 bits", "words of 64 bits"];
    assert!(reasons.iter().any(|w| why.contains(w)), "not compiled: {why}");
}

#[cfg(feature = "compiled")]
fn compiled(netlist: &Netlist) -> Vec<Box<dyn Engine>> {
    match discreta::engine::CompiledEngine::new(netlist) {
        Ok(engine) => {
            count(|ran| ran.compiled += 1);
            vec![Box::new(engine)]
        }
        Err(why) => {
            may_refuse(&why.to_string());
            Vec::new()
        }
    }
}

#[cfg(not(feature = "compiled"))]
fn compiled(_: &Netlist) -> Vec<Box<dyn Engine>> {
    Vec::new()
}

/// One lane of the batch engine, with the clocks that it has no notion of.
struct Lane {
    engine: BatchEngine,
    lane: Vec<u64>,
    clocks: Vec<(NetId, Clock)>,
    settled: bool,
    now: u64,
}

impl Lane {
    fn new(netlist: &Netlist) -> Option<Lane> {
        let program = Arc::new(Program::new(netlist).ok()?);
        let mut engine = BatchEngine::new(program.clone(), 1);
        let mut lane = vec![0; engine.lane_words()];
        lane[0] = 1;
        let mut others = vec![0; engine.lane_words()];
        (1..engine.lanes()).for_each(|at| others[at / 64] |= 1 << (at % 64));
        engine.stop(&others);
        let mut all = Lane { engine, lane, clocks: Vec::new(), settled: false, now: 0 };
        program.clock_cells().iter().for_each(|&(net, clock)| all.add_clock(net, clock));
        count(|ran| ran.batch += 1);
        Some(all)
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        self.clocks.retain(|c| c.0 != net);
        self.clocks.push((net, clock));
        self.drive(net, &Value::from_u64(u64::from(clock.phase == 0), 1));
    }

    fn drive(&mut self, net: NetId, value: &Value) {
        self.engine.drive(net, value, &self.lane);
    }

    /// Whether it settles.
    fn settle(&mut self) -> bool {
        self.settled = true;
        self.engine.settle();
        self.engine.unsettled()[0] & 1 == 0
    }

    /// The first wave of an instant, of which the clocks that are due are a part.
    fn advance(&mut self, now: u64) -> bool {
        let mut settles = self.settled || self.settle();
        let level = |c: &Clock| {
            let since = now.checked_sub(c.phase)? % c.period;
            if since == 0 { Some(1) } else { (since == c.high).then_some(0) }
        };
        let due: Vec<(NetId, u64)> =
            self.clocks.iter().filter_map(|(net, c)| Some((*net, level(c).filter(|_| now > self.now)?))).collect();
        for &(net, level) in &due {
            self.drive(net, &Value::from_u64(level, 1));
        }
        settles &= due.is_empty() || self.settle();
        self.now = now;
        settles
    }
}

impl std::fmt::Debug for Lane {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a lane at {}", self.now)
    }
}

/// Every engine that takes the netlist. What it shows is what the event engine does.
#[derive(Debug)]
pub struct Together {
    netlist: Netlist,
    /// The nets that signals show, which all engines compute.
    nets: Vec<NetId>,
    event: EventEngine,
    others: Vec<Box<dyn Engine>>,
    lane: Option<Lane>,
    started: bool,
    instants: u64,
}

impl Together {
    pub fn new(netlist: &Netlist) -> Together {
        let mut nets: Vec<NetId> = netlist.signal_ids().flat_map(|s| netlist.bits(s)).map(|s: &Slice| s.net).collect();
        nets.sort_unstable();
        nets.dedup();
        count(|ran| ran.event += 1);
        let (event, others, lane) = (EventEngine::new(netlist), compiled(netlist), Lane::new(netlist));
        Together { netlist: netlist.clone(), nets, event, others, lane, started: false, instants: 0 }
    }

    /// After a wave on all of them, of which the event engine told this and the lane whether it settled.
    fn compare(&mut self, told: &Result<(), Unsettled>, lane: Option<bool>) {
        let now = self.event.now();
        if let Some(settles) = lane {
            // a lane may give up where waiting takes too long; it never settles where the event engine does not
            assert!(told.is_ok() || !settles, "at {now} the batch engine settles, the event engine does not");
            self.lane.take_if(|_| !settles || self.instants >= CLOSELY);
        }
        self.instants += 1;
        if told.is_err() || self.instants > CLOSELY && !self.instants.is_multiple_of(SELDOM) {
            return;
        }
        for &net in &self.nets {
            let expected = self.event.read(net);
            for other in &self.others {
                let name = || self.netlist.net_name(net);
                assert_eq!(other.read(net), expected, "{} at {now}: {}, event engine second", name(), other.summary());
            }
            if let Some(lane) = &self.lane {
                let width = self.netlist.net(net).width;
                let found = lane.engine.value(&[Slice { net, lo: 0, width }], 0);
                let expected = Value::from_words(expected, width);
                assert_eq!(found, expected, "{} at {now}: batch, event engine second", self.netlist.net_name(net));
            }
        }
        for other in &self.others {
            assert_eq!(other.next_event(), self.event.next_event(), "the next event after {now}");
        }
        count(|ran| ran.compared += 1);
    }
}

impl Engine for Together {
    fn now(&self) -> u64 {
        self.event.now()
    }

    fn read(&self, net: NetId) -> &[Word] {
        self.event.read(net)
    }

    fn observe(&mut self, net: NetId) {
        self.event.observe(net);
        self.others.iter_mut().for_each(|e| e.observe(net));
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        self.event.add_clock(net, clock);
        self.others.iter_mut().for_each(|e| e.add_clock(net, clock));
        self.lane.iter_mut().for_each(|lane| lane.add_clock(net, clock));
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        self.event.drive(net, value);
        self.others.iter_mut().for_each(|e| e.drive(net, value));
        let width = self.netlist.net(net).width;
        self.lane.iter_mut().for_each(|lane| lane.drive(net, &Value::from_words(value, width)));
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        let told = self.event.settle();
        for other in &mut self.others {
            assert_eq!(other.settle(), told, "{}", other.summary());
        }
        let lane = self.lane.as_mut().map(Lane::settle);
        self.started = true;
        self.compare(&told, lane);
        told
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        loop {
            let next = self.event.next_event().filter(|&t| t <= until);
            let stopped = self.event.advance(next.unwrap_or(until));
            let (told, now) = (stopped.clone().map(drop), self.event.now());
            for other in &mut self.others {
                let found = loop {
                    match other.advance(now) {
                        Ok(true) => {}
                        Ok(false) => break Ok(()),
                        Err(e) => break Err(e),
                    }
                };
                assert_eq!(found, told, "{}", other.summary());
            }
            let lane = self.lane.as_mut().map(|lane| lane.advance(now));
            // where nothing was due, what has been driven still waits
            if next.is_some() || !self.started {
                self.started = true;
                self.compare(&told, lane);
            }
            if stopped? {
                return Ok(true);
            }
            if now >= until {
                return Ok(false);
            }
        }
    }

    fn next_event(&self) -> Option<u64> {
        self.event.next_event()
    }

    fn changes(&self) -> &[NetId] {
        self.event.changes()
    }

    fn clear_changes(&mut self) {
        self.event.clear_changes();
        self.others.iter_mut().for_each(|e| e.clear_changes());
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        let told = self.event.take_unknown_controls();
        for other in &mut self.others {
            assert_eq!(other.take_unknown_controls(), told, "at {}: {}", self.event.now(), other.summary());
        }
        told
    }

    fn events(&self) -> Option<u64> {
        self.event.events()
    }

    fn force(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.lane = None; // it has no notion of it
        let told = self.event.force(bits, value);
        self.others.iter_mut().for_each(|e| assert_eq!(e.force(bits, value), told));
        told
    }

    fn release(&mut self, bits: Slice) {
        self.event.release(bits);
        self.others.iter_mut().for_each(|e| e.release(bits));
    }

    fn is_forced(&self) -> bool {
        self.event.is_forced()
    }

    fn deposit(&mut self, bits: Slice, value: &[Word]) -> Result<(), Refused> {
        self.lane = None;
        let told = self.event.deposit(bits, value);
        self.others.iter_mut().for_each(|e| assert_eq!(e.deposit(bits, value), told));
        told
    }

    fn contents(&self, cell: CellId) -> Option<&[Word]> {
        let held = self.event.contents(cell);
        self.others.iter().for_each(|e| assert!(held.is_none() || e.contents(cell) == held));
        held
    }

    fn set_contents(&mut self, cell: CellId, index: u32, value: &Value) -> bool {
        self.lane = None;
        self.others.iter_mut().for_each(|e| _ = e.set_contents(cell, index, value));
        self.event.set_contents(cell, index, value)
    }

    /// What one saves another goes on from.
    fn save(&self) -> Snapshot {
        self.others.last().map_or_else(|| self.event.save(), |e| e.save())
    }

    fn restore(&mut self, from: &Snapshot) -> Result<(), SnapshotError> {
        self.lane = None;
        let told = self.event.restore(from);
        self.others.iter_mut().for_each(|e| assert_eq!(e.restore(from), told));
        told
    }

    fn summary(&self) -> String {
        self.event.summary()
    }
}
