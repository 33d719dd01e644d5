//! One worker: a block of lanes, each of which takes the next row when it is done with its own.
//!
//! Lanes run in step, each with a clock of its own that began when it did. Lanes that begin run by themselves, while the
//! others rest, until their clocks stand as those of the others do: a wave leaves alone what has no reason to change.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::against::Judge;
use super::run::{Ended, Row, Shown, Source, Statistics, Sweep};
use super::time::Clocks;
use crate::Value;
use crate::engine::EventEngine;
use crate::engine::batch::{BatchEngine, LaneSet, Program};
use crate::netlist::{NetId, SignalId};

/// New rows begin when this part of the lanes is free.
const FREE: usize = 8;
/// Rows that are handed on together.
const TOGETHER: usize = 256;

/// Lanes that began together.
struct Cohort {
    /// What is to be taken from the block's time to have theirs.
    offset: u64,
    lanes: LaneSet,
}

pub(super) struct Worker<'a> {
    sweep: &'a Sweep<'a>,
    engine: BatchEngine,
    clocks: Clocks,
    judge: Option<Judge<'a>>,
    /// The row of each lane.
    rows: Vec<u64>,
    /// The lanes that run.
    running: LaneSet,
    /// Rows to begin with.
    waiting: Range<u64>,
    done: Vec<Row>,
    /// For lanes that do not settle.
    events: Option<EventEngine>,
    statistics: Statistics,
}

fn lanes(set: &[u64]) -> impl Iterator<Item = usize> {
    set.iter().enumerate().flat_map(|(word, &bits)| {
        let mut bits = bits;
        std::iter::from_fn(move || {
            (bits != 0).then(|| {
                let lane = word * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                lane
            })
        })
    })
}

fn any(set: &[u64]) -> bool {
    set.iter().any(|&word| word != 0)
}

impl<'a> Worker<'a> {
    pub fn new(sweep: &'a Sweep<'a>, program: Arc<Program>, lanes: usize) -> Worker<'a> {
        let scenario = sweep.scenario;
        let own = program.clock_cells().to_vec();
        let driven = scenario.clocks.iter().map(|c| (c.net, c.clock));
        let clocks = Clocks::new(driven.chain(own));
        let mut engine = BatchEngine::new(program, lanes);
        let all = vec![u64::MAX; engine.lane_words()];
        engine.stop(&all);
        let judge = sweep.against.as_ref().map(|against| Judge::new(against, engine.lanes()));
        Worker {
            sweep,
            rows: vec![0; engine.lanes()],
            running: vec![0; engine.lane_words()],
            engine,
            clocks,
            judge,
            waiting: 0..0,
            done: Vec::new(),
            events: None,
            statistics: Statistics::default(),
        }
    }

    /// Runs rows until there are none, or it is asked to stop, or nobody takes them.
    pub fn run(mut self, source: &Source<'_>, done: &mut dyn FnMut(Vec<Row>) -> bool) -> Statistics {
        let lanes = self.rows.len();
        // what all lanes have in common: the block's time, and its clocks
        let (mut now, mut clocks) = (0, self.clocks.clone());
        let mut cohorts: Vec<Cohort> = Vec::new();
        loop {
            let free = lanes - self.running.iter().map(|w| w.count_ones() as usize).sum::<usize>();
            if free == lanes {
                cohorts.clear();
            }
            if free >= lanes.div_ceil(FREE) && (free == lanes || clocks.next().is_some()) {
                let fresh = self.fill(source, free == lanes);
                if any(&fresh) {
                    let with = (free < lanes).then_some((&clocks, now));
                    let begun = self.begin(&fresh, with, source);
                    // some may have ended already, and be free for others
                    let left = fresh.iter().zip(&self.running).map(|(a, b)| a & b).collect();
                    match begun {
                        Some((time, their)) if with.is_none() => {
                            (now, clocks) = (time, their);
                            cohorts.push(Cohort { offset: 0, lanes: left });
                        }
                        Some((time, _)) => cohorts.push(Cohort { offset: now.wrapping_sub(time), lanes: left }),
                        None => {}
                    }
                } else if free == lanes {
                    break;
                }
            }
            if self.done.len() >= TOGETHER && !done(std::mem::take(&mut self.done)) {
                return self.statistics;
            }
            if source.stop.load(Ordering::Relaxed) {
                break;
            }
            if any(&self.running) {
                self.instant(&mut now, &mut clocks, &mut cohorts);
            }
        }
        if !self.done.is_empty() {
            done(std::mem::take(&mut self.done));
        }
        self.statistics.evaluated = self.engine.evaluated() * lanes as u64;
        self.statistics
    }

    /// Gives rows to free lanes; the lanes that got one.
    fn fill(&mut self, source: &Source<'_>, wait: bool) -> LaneSet {
        let mut fresh = vec![0; self.running.len()];
        let free: Vec<u64> = self.running.iter().map(|w| !w).collect();
        let mut wait = wait;
        for lane in lanes(&free) {
            if self.waiting.is_empty() {
                match source.take(wait) {
                    Some(span) => self.waiting = span,
                    None => break,
                }
                wait = false;
            }
            self.rows[lane] = self.waiting.start;
            self.waiting.start += 1;
            fresh[lane / 64] |= 1 << (lane % 64);
        }
        fresh
    }

    /// Begins lanes: their own ticks from 0 on, until the stimulus is over and their clocks stand as `with` do at their
    /// tick. Returns the tick and the clocks then, unless all have ended.
    fn begin(&mut self, fresh: &LaneSet, with: Option<(&Clocks, u64)>, source: &Source<'_>) -> Option<(u64, Clocks)> {
        let scenario = self.sweep.scenario;
        let one = |set: bool| Value::from_u64(u64::from(set), 1);
        self.engine.restart(fresh);
        for (running, fresh) in self.running.iter_mut().zip(fresh) {
            *running |= fresh;
        }
        let mut clocks = self.clocks.clone();
        for (net, level) in clocks.levels() {
            self.engine.drive(net, &one(level), fresh);
        }
        for (net, value) in &scenario.inputs {
            match self.sweep.nets.iter().position(|swept| swept == net) {
                Some(axis) => self.drive_swept(*net, axis, fresh),
                None => self.engine.drive(*net, value, fresh),
            }
        }
        if let Some(judge) = &mut self.judge {
            for lane in lanes(fresh) {
                judge.begin(lane, self.rows[lane], &self.sweep.plan);
            }
        }
        let mut stimulus = scenario.stimulus.iter().peekable();
        let mut now = 0;
        self.settle(fresh);
        let mut edge = None;
        loop {
            let mut stimulated = false;
            while let Some(event) = stimulus.next_if(|e| e.time <= now) {
                for (net, value) in &event.sets {
                    self.engine.drive(*net, value, fresh);
                }
                stimulated = true;
            }
            if stimulated {
                self.settle(fresh);
            }
            let over = stimulus.peek().is_none();
            if let Some(judge) = &mut self.judge
                && over
            {
                let set: LaneSet = fresh.iter().zip(&self.running).map(|(a, b)| a & b).collect();
                judge.look(&self.engine, &set, with.is_none(), edge.take());
            }
            self.end(fresh, now, &clocks, over);
            if !fresh.iter().zip(&self.running).any(|(a, b)| a & b != 0) || source.stop.load(Ordering::Relaxed) {
                return None;
            }
            if over {
                match with {
                    None => return Some((now, clocks)),
                    Some((other, then)) => {
                        if let Some(at) = clocks.meets(now, other, then).filter(|&at| at < scenario.limit) {
                            return Some((at, clocks));
                        }
                    }
                }
            }
            let due = stimulus.peek().map_or(u64::MAX, |e| e.time);
            let next = clocks.next().unwrap_or(u64::MAX);
            now = due.min(next).min(scenario.limit);
            if next == now {
                edge = self.fire(&mut clocks, now, fresh);
            }
        }
    }

    /// The next instant of all lanes that run.
    fn instant(&mut self, now: &mut u64, clocks: &mut Clocks, cohorts: &mut Vec<Cohort>) {
        let limit = self.sweep.scenario.limit;
        let ends = cohorts.iter().map(|c| c.offset.wrapping_add(limit)).min_by_key(|end| end.wrapping_sub(*now));
        let next = clocks.next().unwrap_or(u64::MAX);
        // offsets may be below 0, and limits beyond what a tick holds: only what is ahead counts
        let left = ends.map_or(u64::MAX, |end| end.wrapping_sub(*now)).min(next - *now);
        *now += left;
        let mut edge = None;
        let all = vec![u64::MAX; self.running.len()];
        if next == *now {
            edge = self.fire(clocks, *now, &all);
        }
        let running = self.running.clone();
        if let Some(judge) = &mut self.judge {
            judge.look(&self.engine, &running, true, edge);
        }
        for cohort in &*cohorts {
            self.end(&cohort.lanes, now.wrapping_sub(cohort.offset), clocks, true);
        }
        if !running.iter().eq(&self.running) {
            for cohort in &mut *cohorts {
                cohort.lanes.iter_mut().zip(&self.running).for_each(|(lanes, running)| *lanes &= running);
            }
            cohorts.retain(|c| any(&c.lanes));
        }
    }

    fn drive_swept(&mut self, net: NetId, axis: usize, fresh: &LaneSet) {
        let (plan, rows) = (&self.sweep.plan, &self.rows);
        self.engine.drive_each(net, |lane| {
            let begins = fresh[lane / 64] >> (lane % 64) & 1 == 1;
            let index = begins.then(|| plan.indices(rows[lane]).nth(axis)).flatten()?;
            Some(plan.axes[axis].value(index))
        });
    }

    /// Makes the clock edges of a tick in some lanes, and settles. What the clock of the comparison did.
    fn fire(&mut self, clocks: &mut Clocks, now: u64, set: &LaneSet) -> Option<bool> {
        let compared = self.sweep.against.as_ref().map(|a| a.clock);
        let mut edge = None;
        let engine = &mut self.engine;
        clocks.fire(now, |net, level| {
            engine.drive(net, &Value::from_u64(u64::from(level), 1), set);
            if Some(net) == compared {
                edge = Some(level);
            }
        });
        self.settle(set);
        edge
    }

    fn settle(&mut self, set: &LaneSet) {
        self.engine.settle();
        let lanes = set.iter().zip(&self.running).map(|(a, b)| u64::from((a & b).count_ones())).sum::<u64>();
        self.statistics.instants += lanes;
    }

    /// Ends the lanes of a set that have come to their end at their tick `now`.
    fn end(&mut self, set: &LaneSet, now: u64, clocks: &Clocks, over: bool) {
        let scenario = self.sweep.scenario;
        let unsettled = self.engine.unsettled();
        let mut lost: LaneSet = unsettled.iter().zip(&self.running).zip(set).map(|((u, r), s)| u & r & s).collect();
        if any(&lost) {
            self.alone(&lost);
            self.retire(&lost);
        }
        let mut ended: LaneSet = set.iter().zip(&self.running).map(|(s, r)| s & r).collect();
        if let Some((signal, value)) = &scenario.until {
            lost.copy_from_slice(&ended);
            self.engine.retain_equal(self.sweep.netlist.bits(*signal), value, &mut lost);
            if any(&lost) {
                self.report(&lost, Ended::Until, now);
                self.retire(&lost);
                ended.iter_mut().zip(&lost).for_each(|(ended, lost)| *ended &= !lost);
            }
        }
        let why = if now >= scenario.limit {
            Some((Ended::Limit, now))
        } else if over && clocks.next().is_none() {
            let waits = scenario.limit_given && scenario.until.is_none();
            Some(if waits { (Ended::Limit, scenario.limit) } else { (Ended::Idle, now) })
        } else {
            None
        };
        if let Some((why, at)) = why
            && any(&ended)
        {
            self.report(&ended, why, at);
            self.retire(&ended);
        }
    }

    fn retire(&mut self, set: &LaneSet) {
        self.engine.stop(set);
        self.running.iter_mut().zip(set).for_each(|(running, set)| *running &= !set);
    }

    /// Rows for lanes as they stand.
    fn report(&mut self, set: &LaneSet, ended: Ended, time: u64) {
        let Sweep { netlist, outputs, .. } = self.sweep;
        for lane in lanes(set) {
            let shown = |signal: &SignalId| {
                let bits = netlist.bits(*signal);
                let number = self.engine.number(bits, lane);
                number.map_or_else(|| Shown::Value(self.engine.value(bits, lane)), Shown::Number)
            };
            let outputs = outputs.iter().map(shown).collect();
            let verdict = self.judge.as_mut().map(|judge| judge.verdict(lane));
            self.done.push(Row { number: self.rows[lane], ended, time, outputs, verdict });
        }
    }

    /// Runs the rows of lanes that did not settle on the event engine, which tells when that was.
    fn alone(&mut self, set: &LaneSet) {
        let engine = self.events.get_or_insert_with(|| EventEngine::new(self.sweep.netlist));
        for lane in lanes(set) {
            let never = std::sync::atomic::AtomicBool::new(false);
            self.statistics.events += 1;
            if let Some(mut row) = self.sweep.alone(engine, self.rows[lane], &never) {
                row.verdict = self.judge.as_mut().map(|judge| judge.unsettled(lane));
                self.done.push(row);
            }
        }
    }
}
