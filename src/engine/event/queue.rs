//! What happens at later ticks: clock edges and delayed changes.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::eval::State;
use super::program::{DelayCell, Program};
use crate::cell::time::RcDelay;
use crate::cell::{CellKind, Clock};
use crate::snapshot::DelayLine;
use crate::value::Word;
use crate::value::word::{any_unknown, copy, words};

#[derive(Debug)]
struct Source {
    slot: u32,
    clock: Clock,
    high: bool,
    next: u64,
}

/// What a delay holds.
#[derive(Debug)]
struct Line {
    /// The input as last seen, and scratch for the next look.
    seen: Vec<Word>,
    scratch: Vec<Word>,
    rc: RcDelay,
    /// Ticks of the changes on their way, and their values one after another.
    times: VecDeque<u64>,
    values: VecDeque<Word>,
}

#[derive(Debug)]
pub(super) struct Queue {
    clocks: Vec<Source>,
    next_clock: u64,
    lines: Vec<Line>,
    /// Ticks at which delays have something to do.
    due: BinaryHeap<Reverse<(u64, u32)>>,
}

const NEVER: u64 = u64::MAX;

impl Queue {
    pub fn new(p: &Program) -> Queue {
        let line = |d: &DelayCell| {
            let unset = vec![Word::ZERO; words(d.width)];
            Line {
                seen: Vec::new(),
                scratch: unset,
                rc: RcDelay::default(),
                times: VecDeque::new(),
                values: VecDeque::new(),
            }
        };
        Queue {
            clocks: Vec::new(),
            next_clock: NEVER,
            lines: p.delays.iter().map(line).collect(),
            due: BinaryHeap::new(),
        }
    }

    /// Starts a clock at tick 0 and returns its level there.
    pub fn add_clock(&mut self, slot: u32, clock: Clock) -> bool {
        self.clocks.retain(|c| c.slot != slot);
        let high = clock.phase == 0;
        let next = if high { clock.high } else { clock.phase };
        self.clocks.push(Source { slot, clock, high, next });
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        high
    }

    /// The clocks there are.
    pub fn clocks(&self) -> Vec<(u32, Clock)> {
        self.clocks.iter().map(|c| (c.slot, c.clock)).collect()
    }

    /// The clocks with their levels and the ticks of their next edges.
    pub fn sources(&self) -> impl Iterator<Item = (u32, Clock, bool, u64)> + '_ {
        self.clocks.iter().map(|c| (c.slot, c.clock, c.high, c.next))
    }

    /// What delays hold.
    pub fn save(&self) -> Vec<DelayLine> {
        let mut due = vec![Vec::new(); self.lines.len()];
        self.due.iter().for_each(|&Reverse((time, number))| due[number as usize].push(time));
        due.iter_mut().for_each(|list| list.sort_unstable());
        let line = |(l, due): (&Line, Vec<u64>)| DelayLine {
            seen: l.seen.clone(),
            rc: l.rc.save(),
            times: l.times.iter().copied().collect(),
            due,
            values: l.values.iter().copied().collect(),
        };
        self.lines.iter().zip(due).map(line).collect()
    }

    /// Goes on with these clocks and with what delays held; a state of an engine that knows none has none.
    pub fn restore(&mut self, clocks: Vec<(u32, Clock, bool, u64)>, lines: &[DelayLine]) {
        let source = |(slot, clock, high, next)| Source { slot, clock, high, next };
        self.clocks = clocks.into_iter().map(source).collect();
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        self.due.clear();
        for (number, (line, saved)) in (0..).zip(self.lines.iter_mut().zip(lines)) {
            line.seen.clone_from(&saved.seen);
            line.rc = RcDelay::restore(&saved.rc);
            line.times = saved.times.iter().copied().collect();
            line.values = saved.values.iter().copied().collect();
            self.due.extend(saved.due.iter().map(|&due| Reverse((due, number))));
        }
    }

    /// The next tick at which anything happens.
    #[inline(always)]
    pub fn next(&self) -> Option<u64> {
        let next = match self.due.peek() {
            Some(Reverse((time, _))) => self.next_clock.min(*time),
            None => self.next_clock,
        };
        (next != NEVER).then_some(next)
    }

    /// Makes the clock edges and the delayed changes of tick `now`.
    #[inline(always)]
    pub fn fire(&mut self, p: &Program, state: &mut State, now: u64) {
        if self.next_clock == now {
            self.next_clock = NEVER;
            for c in &mut self.clocks {
                if c.next == now {
                    c.high = !c.high;
                    state.put(p, c.slot, Word::known(u64::from(c.high)));
                    let wait = if c.high { c.clock.high } else { c.clock.period - c.clock.high };
                    c.next = now.saturating_add(wait);
                }
                self.next_clock = self.next_clock.min(c.next);
            }
        }
        while let Some(&Reverse((time, number))) = self.due.peek() {
            if time != now {
                break;
            }
            self.due.pop();
            self.fire_delay(p, state, now, number);
        }
    }

    fn fire_delay(&mut self, p: &Program, state: &mut State, now: u64, number: u32) {
        let (line, y, n) =
            (&mut self.lines[number as usize], p.delays[number as usize].y, words(p.delays[number as usize].width));
        if let CellKind::RcDelay(rc) = p.delays[number as usize].kind {
            line.rc.cross(&rc, now);
            state.put(p, y, line.rc.output().map_or(Word::x(1), |b| Word::known(u64::from(b))));
            if let Some(due) = line.rc.due(&rc) {
                self.due.push(Reverse((due, number)));
            }
        } else if line.times.front() == Some(&now) {
            line.times.pop_front();
            for i in 0..n {
                let word = line.values.pop_front().unwrap_or_default();
                state.put(p, y + i as u32, word);
            }
        }
    }

    /// Sends the changes of delays' inputs on their way.
    #[inline(always)]
    pub fn schedule(&mut self, p: &Program, state: &mut State, now: u64) {
        if !state.delayed.is_empty() {
            self.schedule_all(p, state, now);
        }
    }

    fn schedule_all(&mut self, p: &Program, state: &mut State, now: u64) {
        for number in state.delayed.drain(..) {
            let (cell, line) = (&p.delays[number as usize], &mut self.lines[number as usize]);
            line.scratch.fill(Word::ZERO);
            let mut lo = 0;
            for &(slot, from, width) in &cell.input {
                copy(&mut line.scratch, lo, &state.slots[slot as usize..], from, width);
                lo += width;
            }
            if line.seen == line.scratch {
                continue;
            }
            line.seen.clone_from(&line.scratch);
            match cell.kind {
                CellKind::RcDelay(rc) => {
                    let input = (!any_unknown(&line.scratch)).then(|| line.scratch[0].v & 1 == 1);
                    line.rc.drive(&rc, now, input);
                    if let Some(due) = line.rc.due(&rc) {
                        self.due.push(Reverse((due.max(now + 1), number)));
                    }
                }
                CellKind::Delay { ticks, .. } => {
                    let due = now.saturating_add(ticks);
                    if line.times.back() == Some(&due) {
                        // a second phase at the same tick replaces the first
                        line.values.truncate(line.values.len() - line.scratch.len());
                    } else {
                        line.times.push_back(due);
                        self.due.push(Reverse((due, number)));
                    }
                    line.values.extend(&line.scratch);
                }
                _ => {}
            }
        }
    }
}
