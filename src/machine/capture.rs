//! Anyone's step pulses against a program: which block each belongs to, how far the path is off, and what is missing or too
//! much.
//!
//! Pulses are taken one after another along the program. In a line each has to go towards the end point; an arc goes on
//! until its end point is reached near the end of its way. Where a pulse fits in no such way, something has gone wrong
//! before or there: a step lost at the end of the block, one too many, or one counted in the wrong direction. Of these
//! explanations the one is taken with which the pulses that follow fit longest.

use super::follow::Follow;
use super::plan::{Curve, Plan, Shape};

/// A step pulse.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pulse {
    /// When it begins, ticks.
    pub time: u64,
    /// Its axis.
    pub axis: u8,
    /// Its direction: 1 or −1.
    pub step: i8,
    /// Ticks since the direction last changed, if it did after the axis' pulse before.
    pub turned: Option<u64>,
}

/// A move of the program, with the place where it stands.
#[derive(Clone, Debug)]
pub struct Block {
    /// The move.
    pub plan: Plan,
    /// Its line, from 1.
    pub line: u64,
    /// Its column, from 1.
    pub column: usize,
    /// Its text.
    pub text: Box<str>,
}

/// What is wrong with a capture.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Wrong {
    /// So many steps of an axis are missing.
    Missing(u64),
    /// So many are too many.
    Extra(u64),
    /// A step was counted in the wrong direction.
    Direction,
    /// From here on this is not the program's path.
    Elsewhere,
    /// The capture ends here, before the program does.
    Short,
    /// The program is over, and pulses go on.
    Long,
}

/// A fault of a capture, with its place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Fault {
    /// What is wrong.
    pub wrong: Wrong,
    /// The axis, where it is one.
    pub axis: Option<u8>,
    /// When, ticks.
    pub time: u64,
    /// The index of the block.
    pub block: usize,
}

/// What was measured of a block of a capture.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Seen {
    /// Its pulses.
    pub pulses: u64,
    /// The time of its last pulse.
    pub to: u64,
    /// The greatest distance from the program's curve, BLU.
    pub total: f64,
}

/// A capture against a program.
#[derive(Clone, Debug, Default)]
pub struct Aligned {
    /// What is wrong, in the order of time.
    pub faults: Vec<Fault>,
    /// Each block that was found.
    pub blocks: Vec<Seen>,
    /// The greatest distance from the program's curve, BLU, and the block that has it.
    pub total: (f64, usize),
}

/// Faults beyond this many end the comparison.
const MOST: usize = 100;
/// How far ahead explanations are tried, pulses.
const AHEAD: usize = 1 << 15;
/// An explanation holds if so many pulses fit, or all that are left.
const ENOUGH: usize = 12;
/// How far from an arc a path may be, BLU.
const NEAR: f64 = 3.0;

/// A place in the program, with the steps that the machine is off by then.
#[derive(Clone, Copy, Debug)]
struct Matcher<'a> {
    blocks: &'a [Block],
    block: usize,
    /// Steps left of each axis of a line.
    left: [u64; 3],
    follow: Option<Follow>,
    /// Where the machine is, without what it is off by.
    at: [i64; 3],
    /// The first pulse of the block.
    begun: usize,
}

impl<'a> Matcher<'a> {
    fn new(blocks: &'a [Block]) -> Matcher<'a> {
        let at = blocks.first().map_or([0; 3], |b| b.plan.from);
        let mut matcher = Matcher { blocks, block: 0, left: [0; 3], follow: None, at, begun: 0 };
        matcher.enter(0);
        matcher
    }

    /// Begins the present block, or the first one behind it that has steps.
    fn enter(&mut self, pulse: usize) {
        while let Some(block) = self.blocks.get(self.block) {
            let plan = &block.plan;
            self.begun = pulse;
            match plan.shape {
                Shape::Nothing => self.block += 1,
                Shape::Line => {
                    self.left = [0, 1, 2].map(|a| plan.to[a].abs_diff(plan.from[a]));
                    self.follow = None;
                    return;
                }
                Shape::Arc(_) => {
                    self.follow = Some(Follow::new(plan.rounded, self.at.map(|v| v as f64)));
                    return;
                }
            }
        }
    }

    fn over(&self) -> bool {
        self.block >= self.blocks.len()
    }

    /// Goes on to the next block, which begins at the end point of this one.
    fn leave(&mut self, pulse: usize) {
        self.at = self.blocks[self.block].plan.to;
        self.block += 1;
        self.enter(pulse);
    }

    /// Takes the pulse with this index; false if it does not fit.
    fn take(&mut self, pulse: Pulse, index: usize) -> bool {
        let Some(block) = self.blocks.get(self.block) else { return false };
        let (plan, axis) = (&block.plan, usize::from(pulse.axis));
        match &mut self.follow {
            None => {
                let towards = (plan.to[axis] - plan.from[axis]).signum() == i64::from(pulse.step);
                if !towards || self.left[axis] == 0 {
                    return false;
                }
                self.left[axis] -= 1;
                self.at[axis] += i64::from(pulse.step);
                if self.left == [0; 3] {
                    self.leave(index + 1);
                }
                true
            }
            Some(follow) => {
                self.at[axis] += i64::from(pulse.step);
                let place = follow.to(self.at.map(|v| v as f64));
                let length = way(plan);
                let spread = match plan.exact {
                    Curve::Arc { radii, .. } => (radii[0] - radii[1]).abs(),
                    Curve::Line(..) => 0.0,
                };
                if place.off > NEAR + spread || place.along > length + NEAR {
                    return false;
                }
                if self.at == plan.to && place.along >= length - NEAR.min(length / 2.0) {
                    self.leave(index + 1);
                }
                true
            }
        }
    }

    /// How many pulses from this one on fit.
    fn fits(mut self, pulses: &[Pulse], from: usize) -> usize {
        let most = (pulses.len() - from.min(pulses.len())).min(AHEAD);
        (0..most).find(|&n| !self.take(pulses[from + n], from + n)).unwrap_or(most)
    }

    /// The block's end taken for reached before pulse `next`, though the machine is somewhere else.
    fn ended(mut self, next: usize) -> Matcher<'a> {
        self.leave(next);
        self
    }
}

/// The length of what an arc's path goes along, BLU.
fn way(plan: &Plan) -> f64 {
    match plan.rounded {
        Curve::Arc { radii, sweep, rise, .. } => (radii[0] * sweep).hypot(rise),
        Curve::Line(from, to) => (0..3).map(|a| (to[a] - from[a]).powi(2)).sum::<f64>().sqrt(),
    }
}

/// How a pulse that does not fit is explained.
struct Explained<'a> {
    matcher: Matcher<'a>,
    next: usize,
    fits: usize,
    /// Steps off, along each axis: what the machine is behind or ahead by.
    off: [i64; 3],
    /// The whole block's steps were counted, not those of one pulse.
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Skip,
    Flip,
    End,
}

/// Compares pulses with a program.
#[must_use]
pub fn align(pulses: &[Pulse], blocks: &[Block]) -> Aligned {
    let mut aligned = Aligned { blocks: vec![Seen::default(); blocks.len()], ..Aligned::default() };
    let mut matcher = Matcher::new(blocks);
    let mut real = blocks.first().map_or([0; 3], |b| b.plan.from);
    let mut exact: Option<(usize, Follow)> = None;
    let mut next = 0;
    while next < pulses.len() {
        if matcher.over() {
            behind(&mut aligned, pulses, next);
            break;
        }
        let block = matcher.block;
        let before = matcher;
        if matcher.take(pulses[next], next) {
            step(&mut real, pulses[next]);
            // what belongs to one instant is looked at as one
            let together = pulses.get(next + 1).is_some_and(|p| p.time == pulses[next].time);
            look(&mut aligned, blocks, block, &mut exact, real, pulses[next].time, !together);
            next += 1;
            continue;
        }
        let Some(found) = explain(&before, pulses, next) else {
            fault(&mut aligned, Wrong::Elsewhere, None, pulses[next].time, block);
            return aligned;
        };
        tell(&mut aligned, &found, &before, pulses, next, block);
        if aligned.faults.len() >= MOST {
            return aligned;
        }
        for pulse in &pulses[next.min(found.next)..found.next] {
            step(&mut real, *pulse);
        }
        (matcher, next) = (found.matcher, found.next);
    }
    if !matcher.over() && next >= pulses.len() {
        // the last block may be short of steps, else the capture is too short
        let last = matcher.block + 1 == blocks.len()
            || blocks[matcher.block + 1..].iter().all(|b| b.plan.shape == Shape::Nothing);
        let left: u64 = (0..3).map(|a| blocks[matcher.block].plan.to[a].abs_diff(matcher.at[a])).sum();
        let time = pulses.last().map_or(0, |p| p.time);
        let missing = (0..3).find(|&a| blocks[matcher.block].plan.to[a] != matcher.at[a]);
        match missing {
            Some(axis) if last && left <= 4 && matcher.begun < pulses.len() => {
                let off = (matcher.at[axis] - blocks[matcher.block].plan.to[axis]).signum() as i8;
                let at = sharpen(&pulses[matcher.begun..], axis as u8, off).map_or(time, |(at, _)| at);
                fault(&mut aligned, Wrong::Missing(left), Some(axis as u8), at, matcher.block);
            }
            _ => fault(&mut aligned, Wrong::Short, None, time, matcher.block),
        }
    }
    aligned
}

/// Pulses behind the end of the program: a few of one axis are too many in its last block.
fn behind(aligned: &mut Aligned, pulses: &[Pulse], next: usize) {
    let last = aligned.blocks.iter().rposition(|s| s.pulses > 0).unwrap_or(0);
    let rest = &pulses[next..];
    let one = rest.iter().all(|p| (p.axis, p.step) == (rest[0].axis, rest[0].step));
    if !one || rest.len() > 4 {
        fault(aligned, Wrong::Long, None, rest[0].time, last);
        return;
    }
    let since = next - (aligned.blocks.get(last).map_or(0, |s| s.pulses) as usize).min(next);
    let at = sharpen(&pulses[since..], rest[0].axis, rest[0].step).map_or(rest[0].time, |(at, _)| at);
    fault(aligned, Wrong::Extra(rest.len() as u64), Some(rest[0].axis), at, last);
}

fn step(at: &mut [i64; 3], pulse: Pulse) {
    at[usize::from(pulse.axis)] += i64::from(pulse.step);
}

fn fault(aligned: &mut Aligned, wrong: Wrong, axis: Option<u8>, time: u64, block: usize) {
    aligned.faults.push(Fault { wrong, axis, time, block });
}

/// Measures a point of a block.
fn look(
    aligned: &mut Aligned,
    blocks: &[Block],
    block: usize,
    exact: &mut Option<(usize, Follow)>,
    at: [i64; 3],
    time: u64,
    whole: bool,
) {
    let seen = &mut aligned.blocks[block];
    seen.pulses += 1;
    seen.to = time;
    let point = at.map(|v| v as f64);
    if exact.as_ref().is_none_or(|(of, _)| *of != block) {
        let plan = &blocks[block].plan;
        let curve = if plan.flattened { plan.rounded } else { plan.exact };
        *exact = Some((block, Follow::new(curve, plan.from.map(|v| v as f64))));
    }
    let Some((_, follow)) = exact else { return };
    let place = follow.to(point);
    if whole && place.off > seen.total {
        seen.total = place.off;
        if place.off > aligned.total.0 {
            aligned.total = (place.off, block);
        }
    }
}

/// The explanation with which most of the following pulses fit.
fn explain<'a>(before: &Matcher<'a>, pulses: &[Pulse], next: usize) -> Option<Explained<'a>> {
    let pulse = pulses[next];
    let mut all: Vec<Explained<'a>> = Vec::new();
    let mut consider = |matcher: Matcher<'a>, next: usize, off: [i64; 3], kind: Kind| {
        let fits = if next <= pulses.len() { matcher.fits(pulses, next) } else { 0 };
        all.push(Explained { matcher, next, fits, off, kind });
    };
    let axis = usize::from(pulse.axis);
    let along = |n: i64| {
        let mut off = [0; 3];
        off[axis] = n * i64::from(pulse.step);
        off
    };
    // too many: as if they were not there; an arc that is off may come by its end point before it is at its end
    for n in 1..=4 {
        let same = pulses.get(next + n - 1).is_some_and(|p| (p.axis, p.step) == (pulse.axis, pulse.step));
        if !same {
            break;
        }
        consider(*before, next + n, along(n as i64), Kind::Skip);
    }
    // in the wrong direction
    let mut flipped = *before;
    if flipped.take(Pulse { step: -pulse.step, ..pulse }, next) {
        consider(flipped, next + 1, along(2), Kind::Flip);
    }
    // the block has ended before with steps missing or too many
    let end = before.blocks[before.block].plan.to;
    match before.follow {
        None => {
            let missing: u64 = before.left.iter().sum();
            if (1..=8).contains(&missing) {
                consider(before.ended(next), next, [0, 1, 2].map(|a| before.at[a] - end[a]), Kind::End);
            }
        }
        Some(_) => {
            // any of the last points that is near the end
            let mut at = before.at;
            for j in (before.begun..=next).rev().take(24) {
                let off = [0, 1, 2].map(|a| at[a] - end[a]);
                if off != [0; 3] && off.iter().map(|o| o.unsigned_abs()).sum::<u64>() <= 3 {
                    consider(before.ended(j), j, off, Kind::End);
                }
                if j > before.begun {
                    let p = pulses[j - 1];
                    at[usize::from(p.axis)] -= i64::from(p.step);
                }
            }
        }
    }
    // a pulse that comes soon after another is one too many; one that comes when it is due has the wrong direction
    let doubled = soon(pulses, next);
    let weight = |e: &Explained<'_>| match e.kind {
        Kind::Flip if !doubled => 0,
        _ => e.off.iter().map(|o| o.unsigned_abs()).sum::<u64>(),
    };
    let best = all.into_iter().max_by_key(|e| {
        // how far the pulses fit; of those that fit as far as is looked, the smallest fault
        ((e.next + e.fits).min(next + AHEAD - 32), std::cmp::Reverse(weight(e)))
    })?;
    let left = pulses.len() - best.next;
    (best.fits >= ENOUGH.min(left)).then_some(best)
}

/// Whether a pulse follows the one before it of its axis sooner than the next follows it.
fn soon(pulses: &[Pulse], i: usize) -> bool {
    let time = pulses[i].time;
    let same = |p: &&Pulse| p.axis == pulses[i].axis;
    let before = pulses[..i].iter().rev().take(4096).find(same).map(|p| time - p.time);
    let after = pulses[i + 1..].iter().take(4096).find(same).map(|p| p.time - time);
    before.zip(after).is_some_and(|(before, after)| before * 2 < after)
}

/// Names the fault, and seeks the pulse that it is about by its time.
fn tell(
    aligned: &mut Aligned,
    found: &Explained<'_>,
    before: &Matcher<'_>,
    pulses: &[Pulse],
    next: usize,
    block: usize,
) {
    let time = pulses[next].time;
    // from the block before on: a fault shows where the next block turns
    let last = aligned.blocks[..block].iter().rev().find(|s| s.pulses > 0);
    let since = last.map_or(0, |s| before.begun.saturating_sub(s.pulses as usize));
    for axis in 0..3 {
        let off = found.off[axis];
        if off == 0 {
            continue;
        }
        let n = off.unsigned_abs();
        let plan = &before.blocks[before.block].plan;
        let forward = (plan.to[axis] - plan.from[axis]).signum();
        let arc = |block: usize| matches!(before.blocks[block].plan.shape, Shape::Arc(_));
        let after_arc = next - before.begun <= 2 && block > 0 && arc(block - 1);
        let window = &pulses[since..(next + 1).min(pulses.len())];
        // a step in the wrong direction makes two; in an arc it shows at the end only, or where the next block begins
        let turned = n == 2 && (arc(block) || after_arc);
        let (wrong, at) = match sharpen(window, axis as u8, off.signum() as i8) {
            _ if found.kind == Kind::Flip => (Wrong::Direction, Some(time)),
            _ if turned => (Wrong::Direction, lone(window, axis as u8, off.signum() as i8)),
            Some((at, true)) => (Wrong::Missing(n), Some(at)),
            Some((at, false)) => (Wrong::Extra(n), Some(at)),
            // by its time no pulse stands out
            None if found.kind == Kind::Skip || forward == off.signum() => (Wrong::Extra(n), None),
            None => (Wrong::Missing(n), None),
        };
        let of = at.and_then(|at| (0..=block).rev().find(|&b| aligned.blocks[b].pulses > 0 && starts(aligned, b) < at));
        let here = if found.kind != Kind::Flip && after_arc { block - 1 } else { block };
        fault(aligned, wrong, Some(axis as u8), at.unwrap_or(time), of.unwrap_or(here));
    }
}

/// When an axis made its only step in this direction among others.
fn lone(pulses: &[Pulse], axis: u8, off: i8) -> Option<u64> {
    let of: Vec<&Pulse> = pulses.iter().filter(|p| p.axis == axis).collect();
    of.windows(3).find(|w| w[0].step == -off && w[1].step == off && w[2].step == -off).map(|w| w[1].time)
}

/// When a block began: the end of the one before.
fn starts(aligned: &Aligned, block: usize) -> u64 {
    aligned.blocks[..block].iter().rev().find(|s| s.pulses > 0).map_or(0, |s| s.to)
}

/// Among an axis' pulses the gap that stands out from its neighbours: a long one, where a step is missing, or a short one,
/// where one is too many; only those that make the machine end up off by one in direction `off`. When, and whether it is long.
fn sharpen(pulses: &[Pulse], axis: u8, off: i8) -> Option<(u64, bool)> {
    let of: Vec<Pulse> = pulses.iter().filter(|p| p.axis == axis).copied().collect();
    // none where the direction turns: there a circle has its longest
    let gaps: Vec<Option<u64>> =
        of.windows(2).map(|w| (w[0].step == w[1].step).then(|| w[1].time - w[0].time)).collect();
    let mut best: Option<(f64, u64, bool)> = None;
    for (i, gap) in gaps.iter().enumerate() {
        let Some(gap) = *gap else { continue };
        let near = |k: isize| i.checked_add_signed(k).and_then(|n| gaps.get(n).copied().flatten());
        let before: Vec<u64> = [-1, -2].into_iter().map_while(near).collect();
        let after: Vec<u64> = [1, 2].into_iter().map_while(near).collect();
        let all = || before.iter().chain(&after).copied();
        let (Some(least), Some(most)) = (all().min(), all().max()) else { continue };
        // with neighbours on one side only it may be the end of a run, which slows down; short ones come by themselves
        let long = of[i].step == -off;
        let enough = if long && !before.is_empty() && !after.is_empty() { 1.4 } else { 2.6 };
        let ratio = if long { gap as f64 / most.max(1) as f64 } else { least as f64 / gap.max(1) as f64 };
        if ratio > enough && best.is_none_or(|(b, ..)| ratio > b) {
            let at = if long { of[i].time.midpoint(of[i + 1].time) } else { of[i + 1].time };
            best = Some((ratio, at, long));
        }
    }
    best.map(|(_, at, long)| (at, long))
}

/// Pulses without a program: counts, the point that they lead to, and the shortest times.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Counted {
    /// Pulses of each axis.
    pub pulses: [u64; 3],
    /// The end point, from the start.
    pub end: [i64; 3],
    /// The shortest time between two pulses of an axis, ticks, and when it ends.
    pub gap: Option<(u64, u64)>,
    /// The shortest time from a change of direction to the axis' pulse, and when that is.
    pub setup: Option<(u64, u64)>,
    /// The first and the last pulse.
    pub times: Option<[u64; 2]>,
}

/// Counts pulses.
#[must_use]
pub fn count(pulses: &[Pulse]) -> Counted {
    let mut counted = Counted { pulses: [0; 3], end: [0; 3], gap: None, setup: None, times: None };
    let mut last = [None; 3];
    for pulse in pulses {
        let axis = usize::from(pulse.axis);
        counted.pulses[axis] += 1;
        counted.end[axis] += i64::from(pulse.step);
        if let Some(before) = last[axis].replace(pulse.time) {
            let gap = (pulse.time - before, pulse.time);
            counted.gap = Some(counted.gap.map_or(gap, |g| g.min(gap)));
        }
        if let Some(turned) = pulse.turned {
            counted.setup = Some(counted.setup.map_or((turned, pulse.time), |s| s.min((turned, pulse.time))));
        }
        counted.times = Some([counted.times.map_or(pulse.time, |t| t[0]), pulse.time]);
    }
    counted
}
