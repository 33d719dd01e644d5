//! Runs a sweep: on all cores, rows in order.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, mpsc};
use std::{error, fmt, io, thread};

use super::against::Against;
use super::plan::Plan;
use super::worker::Worker;
use crate::Value;
use crate::engine::batch::Program;
use crate::engine::{EventEngine, Unsettled};
use crate::netlist::{CellId, NetId, Netlist, SignalId, Slice};
use crate::scenario::{Control, RunError, Scenario, Stop};

/// A sweep to be run.
pub struct Sweep<'a> {
    /// The circuit.
    pub netlist: &'a Netlist,
    /// What happens to it. Its inputs hold a value for each net that is swept. Only what drives and stops it counts:
    /// expectations, timing checks and monitors are not looked at.
    pub scenario: &'a Scenario,
    /// The nets that are swept, in the order of the plan's axes.
    pub nets: Vec<NetId>,
    /// The combinations.
    pub plan: Plan,
    /// The signals whose last values are wanted.
    pub outputs: Vec<SignalId>,
    /// The algorithm that every lane is compared with.
    pub against: Option<Against>,
    /// Threads; 0 for one a core.
    pub threads: usize,
    /// Lanes of a block; 0 for what suits the circuit.
    pub lanes: usize,
}

/// Why a run of a sweep ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Ended {
    /// The condition came true.
    Until,
    /// The last tick has been reached.
    Limit,
    /// Nothing can change any more.
    Idle,
    /// The circuit never settles.
    Unsettled,
}

/// What the comparison with an algorithm says of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// The same on every clock.
    Same,
    /// The first difference: the clock, and what differs.
    Differs(u64, String),
    /// The algorithm does not take these values, and says why.
    Refused(String),
}

/// One run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Row {
    /// Its number in the whole sweep.
    pub number: u64,
    /// Why it ended.
    pub ended: Ended,
    /// The last tick.
    pub time: u64,
    /// The last values of the outputs; none if it did not settle.
    pub outputs: Vec<Shown>,
    /// What the comparison says, if there is one.
    pub verdict: Option<Verdict>,
}

/// A value in a row.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Shown {
    /// A known number of at most 64 bits, as it stands in the register.
    Number(u64),
    /// Any other.
    Value(Value),
}

/// Why a sweep broke off.
#[derive(Debug)]
pub enum SweepError {
    /// It was asked to stop; rows up to a number have been handed on.
    Interrupted(u64),
    /// The rows cannot be taken.
    Sink(io::Error),
    /// The system gives no thread to run them on.
    Threads(io::Error),
    /// `against` is for the batch engine alone, and it does not take this cell.
    Foreign(CellId),
}

impl fmt::Display for SweepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SweepError::Interrupted(row) => write!(f, "interrupted at row {row}"),
            SweepError::Sink(error) => error.fmt(f),
            SweepError::Threads(error) => write!(f, "the system gives no thread: {error}"),
            SweepError::Foreign(_) => {
                write!(f, "a circuit with delays or memories cannot be compared with an algorithm")
            }
        }
    }
}

impl error::Error for SweepError {}

/// Bytes of a worker's stack: built without optimisation, what the batch engine inlines takes several MB.
const STACK: usize = 64 << 20;
/// Rows that a worker takes at once.
const SPAN: u64 = 512;
/// Rows that may be run before those in front of them have been handed on.
const AHEAD: u64 = 1 << 20;

/// Hands out rows to workers, not too far ahead of what has been handed on.
pub(super) struct Source<'s> {
    state: Mutex<Handed>,
    moved: Condvar,
    pub stop: &'s AtomicBool,
}

struct Handed {
    rest: Range<u64>,
    done: u64,
    over: bool,
}

impl Source<'_> {
    /// Rows to run. Waits for some if asked to; `None` if there are none, or none now.
    pub fn take(&self, wait: bool) -> Option<Range<u64>> {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        loop {
            if state.rest.is_empty() || state.over || self.stop.load(Ordering::Relaxed) {
                return None;
            }
            if state.rest.start < state.done.saturating_add(AHEAD) {
                let end = state.rest.end.min(state.rest.start + SPAN);
                let span = state.rest.start..end;
                state.rest.start = end;
                return Some(span);
            }
            if !wait {
                return None;
            }
            let woken = self.moved.wait_timeout(state, std::time::Duration::from_millis(100));
            state = woken.unwrap_or_else(std::sync::PoisonError::into_inner).0;
        }
    }

    fn tell(&self, change: impl FnOnce(&mut Handed)) {
        change(&mut self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
        self.moved.notify_all();
    }
}

/// What was run on what.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Statistics {
    /// Clock edges and stimuli, in all lanes together.
    pub instants: u64,
    /// Bits of cells evaluated, in all lanes together.
    pub evaluated: u64,
    /// Instants of blocks of lanes in which all was known.
    pub known: u64,
    /// Runs that the event engine made.
    pub events: u64,
    /// Lanes of a block, if there were any.
    pub lanes: usize,
    /// Threads.
    pub threads: usize,
}

impl Sweep<'_> {
    /// The first cell for which the batch engine cannot run the circuit.
    #[must_use]
    pub fn foreign(&self) -> Option<CellId> {
        Program::foreign(self.netlist)
    }

    /// The bits that anybody looks at.
    fn looked_at(&self) -> Vec<Slice> {
        let until = self.scenario.until.iter().map(|until| &until.0);
        let signals = self.outputs.iter().chain(until).flat_map(|&s| self.netlist.bits(s).iter().copied());
        signals.chain(self.against.iter().flat_map(Against::compared)).collect()
    }

    /// Runs it from a row on, and hands every row on in order, as the text that `text` makes of it.
    ///
    /// # Errors
    /// If it was interrupted, or a row cannot be taken.
    pub fn run(
        &self,
        from: u64,
        stop: &AtomicBool,
        text: &(dyn Fn(&Row) -> String + Sync),
        sink: &mut dyn FnMut(u64, &str) -> io::Result<()>,
    ) -> Result<Statistics, SweepError> {
        let rows = from.max(self.plan.rows.start)..self.plan.rows.end;
        let program = match Program::showing(self.netlist, &self.looked_at()) {
            Ok(program) => Some(Arc::new(program)),
            Err(cell) if self.against.is_some() => return Err(SweepError::Foreign(cell)),
            Err(_) => None,
        };
        let threads = match self.threads {
            0 => thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let count = rows.end.saturating_sub(rows.start);
        let threads = threads.min(usize::try_from(count.div_ceil(SPAN)).unwrap_or(usize::MAX)).max(1);
        let lanes = match (self.lanes, &program) {
            (0, Some(program)) => suitable(program, count.div_ceil(threads as u64), self.against.is_some()),
            (lanes, _) => lanes.max(1),
        };
        let source = Source {
            state: Mutex::new(Handed { rest: rows.clone(), done: rows.start, over: false }),
            moved: Condvar::new(),
            stop,
        };
        let (send, receive) = mpsc::channel::<Vec<(u64, String)>>();
        thread::scope(|scope| {
            // of the threads that the system gives, be they fewer
            let mut refused = None;
            let workers: Vec<_> = (0..threads)
                .map_while(|_| {
                    let (send, source, program) = (send.clone(), &source, program.clone());
                    let worker = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, move || {
                        let mut done = |rows: Vec<Row>| {
                            send.send(rows.iter().map(|row| (row.number, text(row))).collect()).is_ok()
                        };
                        match program {
                            Some(program) => Worker::new(self, program, lanes).run(source, &mut done),
                            None => self.one_by_one(source, &mut done),
                        }
                    });
                    worker.map_err(|e| refused = Some(e)).ok()
                })
                .collect();
            drop(send);
            if let (true, Some(e)) = (workers.is_empty(), refused) {
                return Err(SweepError::Threads(e));
            }
            let threads = workers.len();
            let mut next = rows.start;
            // from row `next` on, as far as any has come
            let mut early: VecDeque<Option<String>> = VecDeque::new();
            let mut result = Ok(());
            'all: for batch in receive {
                for (number, text) in batch {
                    let at = (number - next) as usize;
                    early.resize(early.len().max(at + 1), None);
                    early[at] = Some(text);
                }
                while let Some(Some(text)) = early.front() {
                    if let Err(e) = sink(next, text) {
                        result = Err(SweepError::Sink(e));
                        break 'all;
                    }
                    early.pop_front();
                    next += 1;
                }
                source.tell(|s| s.done = next);
            }
            source.tell(|s| s.over = true);
            let lanes = if program.is_some() { lanes.div_ceil(512) * 512 } else { 0 };
            let mut all = Statistics { lanes, threads, ..Statistics::default() };
            for worker in workers {
                let one = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                all.instants += one.instants;
                all.evaluated += one.evaluated;
                all.known += one.known;
                all.events += one.events;
            }
            result?;
            if next < rows.end { Err(SweepError::Interrupted(next)) } else { Ok(all) }
        })
    }

    /// What is left of the scenario in a sweep, with the values of a row.
    pub(super) fn scenario_of(&self, row: u64) -> Scenario {
        let mut scenario = self.scenario.clone();
        for (net, value) in self.nets.iter().zip(self.plan.values(row)) {
            for input in scenario.inputs.iter_mut().filter(|i| i.0 == *net) {
                input.1 = Value::from_words(&[value], input.1.width());
            }
        }
        scenario.expect.clear();
        scenario.checks.clear();
        scenario.monitors.clear();
        scenario
    }

    /// Runs one row on the event engine.
    pub(super) fn alone(&self, engine: &mut EventEngine, row: u64, stop: &AtomicBool) -> Option<Row> {
        let scenario = self.scenario_of(row);
        engine.reset();
        let mut control = Control {
            interrupt: stop,
            progress: &mut |_| {},
            message: &mut |_, _, _| {},
            unknown_control_ends: false,
            observers: Vec::new(),
        };
        let verdict = None;
        match crate::scenario::run(self.netlist, &scenario, engine, None, &mut control) {
            Ok(outcome) => {
                let ended = match outcome.stop {
                    Stop::Until | Stop::Observed => Ended::Until,
                    Stop::Limit | Stop::UnknownControl => Ended::Limit,
                    Stop::Idle => Ended::Idle,
                    Stop::Interrupted => return None,
                };
                let shown = |signal: &SignalId| Shown::of(crate::scenario::value(self.netlist, engine, *signal));
                let outputs = self.outputs.iter().map(shown).collect();
                Some(Row { number: row, ended, time: outcome.time, outputs, verdict })
            }
            Err(RunError::Unsettled(Unsettled { time, .. })) => {
                Some(Row { number: row, ended: Ended::Unsettled, time, outputs: Vec::new(), verdict })
            }
            Err(RunError::Wave(_)) => None,
        }
    }

    /// Runs rows on the event engine, for a circuit that the batch engine cannot take.
    fn one_by_one(&self, source: &Source<'_>, done: &mut dyn FnMut(Vec<Row>) -> bool) -> Statistics {
        let mut engine = EventEngine::new(self.netlist);
        let mut events = 0;
        while let Some(span) = source.take(true) {
            for number in span {
                let Some(row) = self.alone(&mut engine, number, source.stop) else { return Statistics::default() };
                events += 1;
                if !done(vec![row]) {
                    return Statistics::default();
                }
            }
        }
        Statistics { events, ..Statistics::default() }
    }
}

impl Shown {
    /// A value.
    #[must_use]
    pub fn of(value: Value) -> Shown {
        value.to_u64().filter(|_| value.width() <= 64).map_or(Shown::Value(value), Shown::Number)
    }
}

/// Lanes of a block: as many as keep the values of all nets in a second-level cache, but not more than there is to do.
/// Algorithms beside them take more room than the nets do.
fn suitable(program: &Program, rows: u64, compared: bool) -> usize {
    const CACHE: usize = 1 << 20;
    let most = if compared { 8 } else { 32 };
    let lanes = (CACHE * 8 / program.bits().max(1) / 512).clamp(1, most) * 512;
    lanes.min(usize::try_from(rows).unwrap_or(usize::MAX)).max(1)
}
