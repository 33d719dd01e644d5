//! How a method draws, measured over a set of segments.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use serde::Serialize;

use super::{Set, SetKind, Variant};
use crate::interpolate::{Clock, Drawing, Method, Request};

/// Parts of a quadrant in which the speed along an arc is measured.
const PARTS: usize = 30;

/// Segments between two signs of life.
const OFTEN: u64 = 256;

/// What is measured of a method; see [`MEASURES`](super::MEASURES).
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Motion {
    /// Segments drawn.
    pub segments: u64,
    /// Those that the method refused or stopped without an end.
    pub unfinished: u64,
    /// Those whose last point is the end.
    pub exact: u64,
    /// The furthest that a last point is from the end, BLU.
    pub end_error: f64,
    /// Clocks a segment.
    pub clocks: Clocks,
    /// BLU off the ideal curve.
    pub deviation: Deviation,
    /// Of the speed commanded; none where the interval changes from segment to segment, or none was long enough.
    pub speed: Option<Speed>,
    /// The same with longer intervals after steps along several axes.
    pub speed_141: Option<Speed>,
    /// Clocks after which F is not F(x, y); none for methods without one F.
    pub f_wrong: Option<u64>,
}

/// Clocks a segment.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Clocks {
    /// The mean.
    pub mean: f64,
    /// The most.
    pub most: u64,
    /// The fewest and the most of segments whose length or radius is at least 1/16 of the range; none if there are none.
    pub of_long: Option<[u64; 2]>,
}

/// Distances from the ideal curve, BLU.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize)]
pub struct Deviation {
    /// The most outside or to the left.
    pub outside: f64,
    /// The most inside or to the right, 0 or negative.
    pub inside: f64,
    /// The most either way.
    pub most: f64,
    /// The mean without sign.
    pub mean: f64,
}

/// Speeds, of the one commanded.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Speed {
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
    /// The greatest over the least.
    pub ratio: f64,
}

impl Speed {
    fn of(values: impl Iterator<Item = f64>) -> Option<Speed> {
        let (least, greatest) =
            values.fold((f64::INFINITY, 0.0_f64), |(least, greatest), v| (least.min(v), greatest.max(v)));
        (greatest > 0.0).then(|| Speed { least, greatest, ratio: greatest / least })
    }
}

/// Who watches a measurement, and may end it.
#[derive(Clone, Copy, Debug)]
pub struct Watch<'a> {
    /// Segments done.
    pub done: &'a AtomicU64,
    /// Whether to stop.
    pub stop: &'a AtomicBool,
}

impl Motion {
    /// Draws every segment of a set; none if it was told to stop.
    #[must_use]
    pub fn of(variant: Variant, set: &Set, watch: Watch<'_>) -> Option<Motion> {
        let mut measured = Measured::new(variant, set);
        for (i, request) in (1..).zip(set.requests(variant)) {
            measured.segment(&request);
            if i % OFTEN == 0 {
                watch.done.fetch_add(OFTEN, Ordering::Relaxed);
                if watch.stop.load(Ordering::Relaxed) {
                    return None;
                }
            }
        }
        Some(measured.finish())
    }
}

/// Speeds while they are collected: of lines one by one, of arcs clocks by direction, in both kinds of interval.
#[derive(Default)]
struct Speeds {
    lines: [Option<(f64, f64)>; 2],
    /// The time that was commanded for a part of the quadrant, in clocks.
    commanded: f64,
    spent: [[f64; PARTS]; 2],
}

struct Measured {
    variant: Variant,
    kind: SetKind,
    range: f64,
    motion: Motion,
    sum: f64,
    all_clocks: u64,
    speeds: Speeds,
}

impl Measured {
    fn new(variant: Variant, set: &Set) -> Measured {
        let motion = Motion {
            segments: 0,
            unfinished: 0,
            exact: 0,
            end_error: 0.0,
            clocks: Clocks { mean: 0.0, most: 0, of_long: None },
            deviation: Deviation::default(),
            speed: None,
            speed_141: None,
            f_wrong: evaluation(variant.method).then_some(0),
        };
        let range = (1_u64 << set.bits) as f64;
        Measured { variant, kind: set.kind, range, motion, sum: 0.0, all_clocks: 0, speeds: Speeds::default() }
    }

    fn segment(&mut self, request: &Request) {
        let m = &mut self.motion;
        m.segments += 1;
        let Ok(Drawing { mut interpolator, ideal, .. }) = request.draw() else {
            m.unfinished += 1;
            return;
        };
        let length = distance(request.from, request.to);
        let radius = distance(request.from, [0; 3]);
        let is_arc = matches!(self.kind, SetKind::Quarters | SetKind::Arcs | SetKind::Circles);
        // arcs by direction only where every direction of the quadrant is met alike
        let even = matches!(self.kind, SetKind::Lines | SetKind::Quarters | SetKind::Space);
        let even = even && !self.variant.options.normalise;
        let long = even && if is_arc { radius } else { length } >= self.range / 2.0;
        let blu_a_clock = match (self.variant.is_dda(), is_arc) {
            (false, _) => 1.0,
            (true, false) => length / self.range,
            (true, true) => radius / self.range,
        };
        let start = interpolator.state();
        let f = f_at(request, start.sum[0]);
        let check_f = m.f_wrong.is_some() && (is_arc || request.to[0] != request.from[0]);
        let mut last = start;
        let (mut clocks, mut intervals) = (0_u64, 0.0);
        for c in interpolator.by_ref() {
            clocks += 1;
            let away = ideal.deviation(c.at.map(|v| v as f64));
            let away = if self.kind == SetKind::Space { away.abs() } else { away };
            let d = &mut m.deviation;
            d.outside = d.outside.max(away);
            d.inside = d.inside.min(away);
            self.sum += away.abs();
            if check_f && c.sum[0] != f(c.at) {
                m.f_wrong = m.f_wrong.map(|n| n + 1);
            }
            let interval = [1.0, 1.0, 1.41, 1.73][c.axes()];
            intervals += interval;
            if is_arc && long {
                let part = direction(&last, &c);
                self.speeds.spent[0][part] += 1.0;
                self.speeds.spent[1][part] += interval;
            }
            last = c;
        }
        self.all_clocks += clocks;
        m.clocks.most = m.clocks.most.max(clocks);
        if if is_arc { radius } else { length } >= self.range / 16.0 {
            let [least, most] = m.clocks.of_long.unwrap_or([clocks; 2]);
            m.clocks.of_long = Some([least.min(clocks), most.max(clocks)]);
        }
        m.unfinished += u64::from(!last.end);
        let missed = distance(last.at, request.to);
        m.exact += u64::from(last.end && missed == 0.0);
        m.end_error = m.end_error.max(missed);
        if long && is_arc {
            let part = std::f64::consts::FRAC_PI_2 / PARTS as f64;
            self.speeds.commanded += radius * part / blu_a_clock;
        } else if long {
            for (range, time) in self.speeds.lines.iter_mut().zip([clocks as f64, intervals]) {
                let speed = length / (time * blu_a_clock);
                let (least, greatest) = range.unwrap_or((speed, speed));
                *range = Some((least.min(speed), greatest.max(speed)));
            }
        }
    }

    fn finish(mut self) -> Motion {
        let m = &mut self.motion;
        m.clocks.mean = self.all_clocks as f64 / m.segments.max(1) as f64;
        m.deviation.most = m.deviation.outside.max(-m.deviation.inside);
        m.deviation.mean = self.sum / self.all_clocks.max(1) as f64;
        let Speeds { lines, commanded, spent } = self.speeds;
        let speed = |i: usize| match lines[i] {
            Some((least, greatest)) => Speed::of([least, greatest].into_iter()),
            None if commanded > 0.0 => Speed::of(spent[i].iter().map(|time| commanded / time)),
            None => None,
        };
        m.speed = speed(0);
        if !self.variant.is_dda() {
            m.speed_141 = speed(1);
        }
        self.motion
    }
}

/// Whether the method has one evaluation function, of the point alone.
const fn evaluation(method: Method) -> bool {
    use Method::{EfCircle, EfCircleFast, EfLine, EfLineFast, Grossman, Karibsky};
    matches!(method, EfLine | EfLineFast | EfCircle | EfCircleFast | Grossman | Karibsky)
}

/// The documents' F(x, y), from what it is at the start.
fn f_at(request: &Request, at_start: i64) -> impl Fn([i64; 3]) -> i64 {
    let Request { from, to, .. } = *request;
    let line = matches!(request.method, Method::EfLine | Method::EfLineFast);
    move |[x, y, _]| {
        at_start
            + if line {
                (y - from[1]) * (to[0] - from[0]) - (x - from[0]) * (to[1] - from[1])
            } else {
                x * x + y * y - from[0] * from[0] - from[1] * from[1]
            }
    }
}

/// The part of the quadrant in which the middle of a step lies, seen from the origin.
fn direction(before: &Clock, after: &Clock) -> usize {
    let middle = [0, 1].map(|i| (before.at[i] + after.at[i]) as f64);
    let angle = libm::atan2(middle[1], middle[0]) / std::f64::consts::FRAC_PI_2;
    ((angle * PARTS as f64) as usize).min(PARTS - 1)
}

fn distance(a: [i64; 3], b: [i64; 3]) -> f64 {
    let square = |i: usize| ((a[i] - b[i]) as f64) * ((a[i] - b[i]) as f64);
    (square(0) + square(1) + square(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(method: Method, kind: SetKind, bits: u32) -> Motion {
        let (done, stop) = (AtomicU64::new(0), AtomicBool::new(false));
        let set = Set { kind, bits, sample: None };
        Motion::of(Variant::of(method), &set, Watch { done: &done, stop: &stop }).unwrap()
    }

    /// By hand: of the 3 lines of 1 bit (0, 1) takes an idle clock and a step, (1, 0) a step, (1, 1) two.
    #[test]
    fn one_bit_by_hand() {
        let m = motion(Method::EfLine, SetKind::Lines, 1);
        assert_eq!((m.segments, m.exact, m.unfinished, m.end_error), (3, 3, 0, 0.0));
        assert_eq!((m.clocks.mean, m.clocks.most), (5.0 / 3.0, 2));
        // (1, 0) is 1/√2 to the right of (1, 1)
        assert!((m.deviation.inside + 0.5_f64.sqrt()).abs() < 1e-12 && m.deviation.outside == 0.0);
        assert!((m.deviation.mean - 0.5_f64.sqrt() / 5.0).abs() < 1e-12);
        // 1 BLU in two clocks, and one in one
        assert_eq!(m.speed.map(|s| (s.least, s.greatest)), Some((0.5, 1.0)));
        assert_eq!(m.f_wrong, Some(0));
    }

    #[test]
    fn a_wrong_f_would_be_counted() {
        let request = Request::new(Method::EfLine, [5, 3, 0]);
        let f = f_at(&request, 0);
        assert_eq!((f([2, 2, 0]), f([5, 3, 0]), f([1, 0, 0])), (4, 0, -3));
        let request = Request { from: [5, 0, 0], ..Request::new(Method::Grossman, [0, 5, 0]) };
        assert_eq!(f_at(&request, 0)([4, 1, 0]), -8);
    }

    #[test]
    fn who_watches_may_stop_it() {
        let (done, stop) = (AtomicU64::new(0), AtomicBool::new(true));
        let set = Set { kind: SetKind::Lines, bits: 8, sample: None };
        assert_eq!(Motion::of(Variant::of(Method::EfLine), &set, Watch { done: &done, stop: &stop }), None);
        assert_eq!(done.load(Ordering::Relaxed), OFTEN);
    }
}
