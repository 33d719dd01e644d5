//! One worker: takes rows, and has blocks of lanes run them. A lane that is done is free for the next row.
//!
//! Rows begin in a block of their own and go over to the others when their clocks stand as those of the others do. Where
//! there is no known form they begin among the others, which rest: a phase leaves alone what has no reason to change.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::judge::Judge;
use super::lanes::{Block, Cohort, FREE, Ready, any};
use super::run::{Row, Source, Statistics, Sweep};
use super::time::Clocks;
use crate::engine::EventEngine;
use crate::engine::batch::{BatchEngine, Program};

/// Lanes in which rows begin.
const BEGINNING: usize = 512;
/// Rows that are handed on together.
const TOGETHER: usize = 256;

/// What a worker does, but for the lanes.
pub(super) struct Work<'a> {
    pub sweep: &'a Sweep<'a>,
    /// The clocks at the start.
    pub clocks: Clocks,
    /// Rows to begin with.
    pub waiting: Range<u64>,
    pub done: Vec<Row>,
    /// For lanes that do not settle.
    pub events: Option<EventEngine>,
    pub statistics: Statistics,
}

pub(super) struct Worker<'a> {
    work: Work<'a>,
    program: Arc<Program>,
    lanes: usize,
}

impl<'a> Worker<'a> {
    pub fn new(sweep: &'a Sweep<'a>, program: Arc<Program>, lanes: usize) -> Worker<'a> {
        let scenario = sweep.scenario;
        let own = program.clock_cells().to_vec();
        let driven = scenario.clocks.iter().map(|c| (c.net, c.clock));
        let clocks = Clocks::new(driven.chain(own));
        let (waiting, done, events) = (0..0, Vec::new(), None);
        let work = Work { sweep, clocks, waiting, done, events, statistics: Statistics::default() };
        Worker { work, program, lanes }
    }

    /// Runs rows until there are none, or it is asked to stop, or nobody takes them.
    pub fn run(mut self, source: &Source<'_>, done: &mut dyn FnMut(Vec<Row>) -> bool) -> Statistics {
        let mut main = Block::new(&self.work, &self.program, self.lanes);
        let goes_on = match self.program.has_known_form() {
            true => self.run_known(&mut main, source, done),
            false => self.run_mixed(&mut main, source, done),
        };
        if goes_on && !self.work.done.is_empty() {
            done(std::mem::take(&mut self.work.done));
        }
        self.work.count(&main);
        self.work.statistics
    }

    /// One block, in which free lanes begin new rows while the others rest. False if nobody takes rows.
    fn run_mixed(
        &mut self,
        block: &mut Block<'a>,
        source: &Source<'_>,
        done: &mut dyn FnMut(Vec<Row>) -> bool,
    ) -> bool {
        let work = &mut self.work;
        let lanes = block.rows.len();
        block.judge = work.judge(&block.engine, false);
        loop {
            let free = block.free();
            if free == lanes {
                block.cohorts.clear();
            }
            if free >= lanes.div_ceil(FREE) && (free == lanes || block.clocks.next().is_some()) {
                let fresh = block.fill(work, source, free == lanes);
                if any(&fresh) {
                    let with = (free < lanes).then(|| (block.clocks.clone(), block.now));
                    let begun = block.begin(work, &fresh, with.as_ref(), source);
                    // some may have ended already, and be free for others
                    let left = fresh.iter().zip(&block.running).map(|(a, b)| a & b).collect();
                    match begun {
                        Some((time, their)) if with.is_none() => {
                            (block.now, block.clocks) = (time, their);
                            block.cohorts.push(Cohort { offset: 0, lanes: left });
                        }
                        Some((time, _)) => {
                            block.cohorts.push(Cohort { offset: block.now.wrapping_sub(time), lanes: left });
                        }
                        None => {}
                    }
                } else if free == lanes {
                    return true;
                }
            }
            if !work.hand_on(done) {
                return false;
            }
            if source.stop.load(Ordering::Relaxed) {
                return true;
            }
            if any(&block.running) {
                block.instant(work);
            }
        }
    }

    /// Two blocks: in one rows begin, with all the x that there is before anything is loaded; in the other they run, in
    /// the known form, and new ones come in as soon as their clocks stand as the others' do. False if nobody takes rows.
    fn run_known(&mut self, main: &mut Block<'a>, source: &Source<'_>, done: &mut dyn FnMut(Vec<Row>) -> bool) -> bool {
        let work = &mut self.work;
        let lanes = main.rows.len();
        let mut nursery = Block::new(work, &self.program, BEGINNING.min(lanes));
        main.judge = work.judge(&main.engine, true);
        let mut ready: Option<Ready> = None;
        let mut rows_left = true;
        let goes_on = loop {
            if ready.is_none() && rows_left {
                let fresh = nursery.fill(work, source, !any(&main.running));
                rows_left = any(&fresh) || any(&main.running);
                if any(&fresh) {
                    ready = nursery.prepare(work, &fresh, source);
                }
                if let Some(r) = ready.take_if(|_| !nursery.engine.is_known()) {
                    nursery.finish(work, r, source);
                }
            }
            if let Some(r) = &mut ready
                && main.take_in(work, &nursery, r)
                && r.lanes.is_empty()
            {
                ready = None;
                nursery.running.fill(0);
            }
            if !work.hand_on(done) {
                break false;
            }
            if source.stop.load(Ordering::Relaxed) || !rows_left && ready.is_none() && !any(&main.running) {
                break true;
            }
            if any(&main.running) {
                main.instant(work);
            }
        };
        self.work.count(&nursery);
        goes_on
    }
}

impl<'a> Work<'a> {
    pub fn judge(&self, engine: &BatchEngine, together: bool) -> Option<Judge<'a>> {
        self.sweep.against.as_ref().map(|against| Judge::new(against, engine, together))
    }

    /// Hands rows on, if there are enough. False if nobody takes them.
    fn hand_on(&mut self, done: &mut dyn FnMut(Vec<Row>) -> bool) -> bool {
        self.done.len() < TOGETHER || done(std::mem::take(&mut self.done))
    }

    fn count(&mut self, block: &Block<'_>) {
        self.statistics.evaluated += block.engine.evaluated() * block.rows.len() as u64;
        self.statistics.known += block.engine.known_instants();
    }
}
