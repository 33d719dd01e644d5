//! Blocks of lanes that run in step, each lane with a clock of its own that began when it did.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::judge::{Judge, NEVER};
use super::run::{Ended, Row, Shown, Source, Sweep, Verdict};
use super::time::Clocks;
use super::worker::Work;
use crate::Value;
use crate::engine::EventEngine;
use crate::engine::batch::{BatchEngine, Compaction, LaneSet, Program};
use crate::netlist::{NetId, SignalId};

/// New rows begin when this part of the lanes is free.
pub(super) const FREE: usize = 8;

/// Lanes that began together.
pub(super) struct Cohort {
    /// What is to be taken from the block's time to have theirs.
    pub offset: u64,
    pub lanes: LaneSet,
}

/// Lanes that run in step, and what they do.
pub(super) struct Block<'a> {
    pub engine: BatchEngine,
    pub judge: Option<Judge<'a>>,
    /// The row of each lane.
    pub rows: Vec<u64>,
    /// The lanes that run.
    pub running: LaneSet,
    /// The block's time, and its clocks.
    pub now: u64,
    pub clocks: Clocks,
    pub cohorts: Vec<Cohort>,
    scratch: LaneSet,
}

/// Lanes that have begun and wait for places.
pub(super) struct Ready {
    pub lanes: Range<usize>,
    /// Their time and their clocks.
    time: u64,
    clocks: Clocks,
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

pub(super) fn any(set: &[u64]) -> bool {
    set.iter().any(|&word| word != 0)
}

impl<'a> Block<'a> {
    pub fn new(work: &Work<'a>, program: &Arc<Program>, lanes: usize) -> Block<'a> {
        let mut engine = BatchEngine::new(program.clone(), lanes);
        let all = vec![u64::MAX; engine.lane_words()];
        engine.stop(&all);
        Block {
            rows: vec![0; engine.lanes()],
            running: vec![0; engine.lane_words()],
            scratch: vec![0; engine.lane_words()],
            engine,
            judge: None,
            now: 0,
            clocks: work.clocks.clone(),
            cohorts: Vec::new(),
        }
    }

    pub fn free(&self) -> usize {
        self.rows.len() - self.running.iter().map(|w| w.count_ones() as usize).sum::<usize>()
    }

    /// Gives rows to free lanes; the lanes that got one.
    pub fn fill(&mut self, work: &mut Work<'_>, source: &Source<'_>, wait: bool) -> LaneSet {
        let mut fresh = vec![0; self.running.len()];
        let free: Vec<u64> = self.running.iter().map(|w| !w).collect();
        let mut wait = wait;
        for lane in lanes(&free) {
            if work.waiting.is_empty() {
                match source.take(wait) {
                    Some(span) => work.waiting = span,
                    None => break,
                }
                wait = false;
            }
            self.rows[lane] = work.waiting.start;
            work.waiting.start += 1;
            fresh[lane / 64] |= 1 << (lane % 64);
        }
        fresh
    }

    /// Puts lanes to the start of their rows.
    fn restart(&mut self, work: &Work<'_>, fresh: &LaneSet) {
        self.engine.restart(fresh);
        for (running, fresh) in self.running.iter_mut().zip(fresh) {
            *running |= fresh;
        }
        let one = |set: bool| Value::from_u64(u64::from(set), 1);
        for (net, level) in work.clocks.levels() {
            self.engine.drive(net, &one(level), fresh);
        }
        for (net, value) in &work.sweep.scenario.inputs {
            match work.sweep.nets.iter().position(|swept| swept == net) {
                Some(axis) => self.drive_swept(work, *net, axis, fresh),
                None => self.engine.drive(*net, value, fresh),
            }
        }
    }

    /// Begins lanes among the others, which rest: their own ticks from 0 on, until the stimulus is over and their clocks
    /// stand as `with` do at their tick. Returns the tick and the clocks then, unless all have ended.
    pub fn begin(
        &mut self,
        work: &mut Work<'_>,
        fresh: &LaneSet,
        with: Option<&(Clocks, u64)>,
        source: &Source<'_>,
    ) -> Option<(u64, Clocks)> {
        let limit = work.sweep.scenario.limit;
        let Ready { mut clocks, time: mut now, .. } = self.prepare(work, fresh, source)?;
        self.compare(fresh, with.is_none(), None);
        loop {
            self.end(work, fresh, now, &clocks, true);
            if !self.runs(fresh) || source.stop.load(Ordering::Relaxed) {
                return None;
            }
            match with {
                None => return Some((now, clocks)),
                Some((other, then)) => {
                    if let Some(at) = clocks.meets(now, other, *then).filter(|&at| at < limit) {
                        return Some((at, clocks));
                    }
                }
            }
            let next = clocks.next().unwrap_or(u64::MAX);
            now = next.min(limit);
            let edge = if next == now { self.fire(work, &mut clocks, now, fresh) } else { None };
            self.compare(fresh, false, edge);
        }
    }

    /// Whether any lane of a set runs.
    fn runs(&self, set: &LaneSet) -> bool {
        set.iter().zip(&self.running).any(|(a, b)| a & b != 0)
    }

    /// Begins lanes up to the instant at which the stimulus is over, and leaves it to who takes them in to compare them
    /// and to look for ends then. None if all have ended before.
    pub fn prepare(&mut self, work: &mut Work<'_>, fresh: &LaneSet, source: &Source<'_>) -> Option<Ready> {
        let scenario = work.sweep.scenario;
        self.restart(work, fresh);
        self.judge_rows(work, fresh);
        let mut clocks = work.clocks.clone();
        let mut stimulus = scenario.stimulus.iter().peekable();
        let mut now = 0;
        self.settle(work, fresh);
        loop {
            let mut stimulated = false;
            while let Some(event) = stimulus.next_if(|e| e.time <= now) {
                for (net, value) in &event.sets {
                    self.engine.drive(*net, value, fresh);
                }
                stimulated = true;
            }
            if stimulated {
                self.settle(work, fresh);
            }
            let Some(due) = stimulus.peek().map(|e| e.time) else { break };
            self.end(work, fresh, now, &clocks, false);
            if !self.runs(fresh) || source.stop.load(Ordering::Relaxed) {
                return None;
            }
            let next = clocks.next().unwrap_or(u64::MAX);
            now = due.min(next).min(scenario.limit);
            if next == now {
                self.fire(work, &mut clocks, now, fresh);
            }
        }
        self.lose(work, fresh);
        let count = fresh.iter().map(|w| w.count_ones() as usize).sum();
        Some(Ready { lanes: 0..count, time: now, clocks })
    }

    /// Runs lanes that cannot go to another block where they are, to their end.
    pub fn finish(&mut self, work: &mut Work<'a>, ready: Ready, source: &Source<'_>) {
        (self.now, self.clocks) = (ready.time, ready.clocks);
        let running = self.running.clone();
        if self.judge.is_none() {
            self.judge = work.judge(&self.engine, true);
            self.judge_rows(work, &running);
        }
        self.compare(&running, true, None);
        self.cohorts = vec![Cohort { offset: 0, lanes: running.clone() }];
        self.end(work, &running, self.now, &self.clocks.clone(), true);
        while any(&self.running) && !source.stop.load(Ordering::Relaxed) {
            self.instant(work);
        }
    }

    /// Tells the comparison what lanes run.
    fn judge_rows(&mut self, work: &Work<'_>, set: &LaneSet) {
        if let Some(judge) = &mut self.judge {
            lanes(set).for_each(|lane| judge.begin(lane, self.rows[lane], &work.sweep.plan));
        }
    }

    /// Compares the lanes of a set that run after an instant; with `all` no others do.
    fn compare(&mut self, set: &LaneSet, all: bool, edge: Option<bool>) {
        if let Some(judge) = &mut self.judge {
            let set: LaneSet = set.iter().zip(&self.running).map(|(a, b)| a & b).collect();
            judge.look(&self.engine, &set, all, edge);
        }
    }

    /// Takes in lanes that are ready, if enough are free and the clocks are in step; whether it has.
    pub fn take_in(&mut self, work: &mut Work<'_>, from: &Block<'_>, ready: &mut Ready) -> bool {
        let free = self.free();
        let empty = free == self.rows.len();
        let offset = match empty {
            true => 0,
            false if free < self.rows.len().div_ceil(FREE) => return false,
            false => match ready.clocks.meets(ready.time, &self.clocks, self.now) {
                Some(at) if at < work.sweep.scenario.limit => self.now.wrapping_sub(at),
                _ => return false,
            },
        };
        let places: LaneSet = self.running.iter().map(|w| !w).collect();
        let compaction = Compaction::new(ready.lanes.start, ready.lanes.len(), &places);
        if !self.engine.adopt(&from.engine, &compaction) {
            return false;
        }
        ready.lanes.start += compaction.lanes();
        if empty {
            (self.now, self.clocks) = (ready.time, ready.clocks.clone());
            self.cohorts.clear();
        }
        for (lane, to) in compaction.pairs() {
            self.rows[to] = from.rows[lane];
        }
        // those that have ended before are free again
        let mut fresh: LaneSet = vec![0; places.len()];
        let mut ended = fresh.clone();
        let runs = |word: usize| from.running.get(word).copied().unwrap_or(0);
        compaction.carry(runs, |word, mask, bits| (fresh[word], ended[word]) = (bits, mask & !bits));
        self.engine.stop(&ended);
        self.running.iter_mut().zip(&fresh).for_each(|(running, fresh)| *running |= fresh);
        self.judge_rows(work, &fresh);
        self.compare(&fresh, true, None);
        let clocks = ready.clocks.clone();
        self.end(work, &fresh, ready.time, &clocks, true);
        fresh.iter_mut().zip(&self.running).for_each(|(fresh, running)| *fresh &= running);
        self.cohorts.push(Cohort { offset, lanes: fresh });
        true
    }

    /// The next instant of all lanes that run.
    pub fn instant(&mut self, work: &mut Work<'_>) {
        let limit = work.sweep.scenario.limit;
        let ends = self.cohorts.iter().map(|c| c.offset.wrapping_add(limit).wrapping_sub(self.now)).min();
        let next = self.clocks.next().unwrap_or(u64::MAX);
        // offsets may be below 0, and limits beyond what a tick holds: only what is ahead counts
        let left = ends.unwrap_or(u64::MAX).min(next - self.now);
        self.now += left;
        let mut edge = None;
        if next == self.now {
            self.scratch.fill(u64::MAX);
            let all = std::mem::take(&mut self.scratch);
            let mut clocks = self.clocks.clone();
            edge = self.fire(work, &mut clocks, self.now, &all);
            (self.clocks, self.scratch) = (clocks, all);
        }
        if let Some(judge) = &mut self.judge {
            judge.look(&self.engine, &self.running, true, edge);
        }
        if ends != Some(left) && self.clocks.next().is_some() && !self.engine.any_unsettled() {
            let Some((signal, value)) = &work.sweep.scenario.until else { return };
            self.scratch.copy_from_slice(&self.running);
            self.engine.retain_equal(work.sweep.netlist.bits(*signal), value, &mut self.scratch);
            if !any(&self.scratch) {
                return;
            }
        }
        let mut cohorts = std::mem::take(&mut self.cohorts);
        let clocks = self.clocks.clone();
        for cohort in &cohorts {
            self.end(work, &cohort.lanes, self.now.wrapping_sub(cohort.offset), &clocks, true);
        }
        for cohort in &mut cohorts {
            cohort.lanes.iter_mut().zip(&self.running).for_each(|(lanes, running)| *lanes &= running);
        }
        cohorts.retain(|c| any(&c.lanes));
        self.cohorts = cohorts;
    }

    fn drive_swept(&mut self, work: &Work<'_>, net: NetId, axis: usize, fresh: &LaneSet) {
        let (plan, rows) = (&work.sweep.plan, &self.rows);
        self.engine.drive_each(net, |lane| {
            let begins = fresh[lane / 64] >> (lane % 64) & 1 == 1;
            begins.then(|| plan.value(axis, rows[lane]))
        });
    }

    /// Makes the clock edges of a tick in some lanes, and settles. What the clock of the comparison did.
    fn fire(&mut self, work: &mut Work<'_>, clocks: &mut Clocks, now: u64, set: &LaneSet) -> Option<bool> {
        let compared = work.sweep.against.as_ref().map(|a| a.clock);
        let mut edge = None;
        let engine = &mut self.engine;
        clocks.fire(now, |net, level| {
            engine.drive(net, &Value::from_u64(u64::from(level), 1), set);
            if Some(net) == compared {
                edge = Some(level);
            }
        });
        self.settle(work, set);
        edge
    }

    fn settle(&mut self, work: &mut Work<'_>, set: &LaneSet) {
        self.engine.settle();
        let lanes = set.iter().zip(&self.running).map(|(a, b)| u64::from((a & b).count_ones())).sum::<u64>();
        work.statistics.instants += lanes;
    }

    /// Ends the lanes of a set that have come to their end at their tick `now`.
    fn end(&mut self, work: &mut Work<'_>, set: &LaneSet, now: u64, clocks: &Clocks, over: bool) {
        let scenario = work.sweep.scenario;
        self.lose(work, set);
        let mut ended: LaneSet = set.iter().zip(&self.running).map(|(s, r)| s & r).collect();
        if let Some((signal, value)) = &scenario.until {
            let mut hit = ended.clone();
            self.engine.retain_equal(work.sweep.netlist.bits(*signal), value, &mut hit);
            if any(&hit) {
                self.report(work, &hit, Ended::Until, now);
                self.retire(&hit);
                ended.iter_mut().zip(&hit).for_each(|(ended, hit)| *ended &= !hit);
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
            self.report(work, &ended, why, at);
            self.retire(&ended);
        }
    }

    /// Leaves the lanes of a set that have not settled to the event engine.
    fn lose(&mut self, work: &mut Work<'_>, set: &LaneSet) {
        if self.engine.any_unsettled() {
            let unsettled = self.engine.unsettled();
            let lost: LaneSet = unsettled.iter().zip(&self.running).zip(set).map(|((u, r), s)| u & r & s).collect();
            if any(&lost) {
                self.alone(work, &lost);
                self.retire(&lost);
            }
        }
    }

    fn retire(&mut self, set: &LaneSet) {
        self.engine.stop(set);
        self.running.iter_mut().zip(set).for_each(|(running, set)| *running &= !set);
    }

    /// Rows for lanes as they stand.
    fn report(&mut self, work: &mut Work<'_>, set: &LaneSet, ended: Ended, time: u64) {
        let Sweep { netlist, outputs, .. } = work.sweep;
        for lane in lanes(set) {
            let shown = |signal: &SignalId| {
                let bits = netlist.bits(*signal);
                let number = self.engine.number(bits, lane);
                number.map_or_else(|| Shown::Value(self.engine.value(bits, lane)), Shown::Number)
            };
            let outputs = outputs.iter().map(shown).collect();
            let verdict = match &mut self.judge {
                Some(judge) => Some(judge.verdict(lane)),
                // it has ended before there was anything to compare
                None => work.sweep.against.as_ref().map(|against| {
                    against.begin(self.rows[lane], &work.sweep.plan).err().map_or(Verdict::Same, Verdict::Refused)
                }),
            };
            work.done.push(Row { number: self.rows[lane], ended, time, outputs, verdict });
        }
    }

    /// Runs the rows of lanes that did not settle on the event engine, which tells when that was.
    fn alone(&mut self, work: &mut Work<'_>, set: &LaneSet) {
        let engine = work.events.get_or_insert_with(|| EventEngine::new(work.sweep.netlist));
        for lane in lanes(set) {
            let never = std::sync::atomic::AtomicBool::new(false);
            work.statistics.events += 1;
            if let Some(mut row) = work.sweep.alone(engine, self.rows[lane], &never) {
                row.verdict = match &mut self.judge {
                    Some(judge) => Some(judge.unsettled(lane)),
                    None => work.sweep.against.as_ref().map(|_| Verdict::Differs(0, NEVER.into())),
                };
                work.done.push(row);
            }
        }
    }
}
