//! A path and its deviation, point by point, in bounded memory.

/// More corners than this are merged: more than any picture has pixels along a path.
const CORNERS: usize = 1 << 17;

/// More spans of clocks than this are merged.
const SPANS: usize = 1 << 13;

/// The least and the greatest deviation of some clocks in succession.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Span {
    pub(super) least: f64,
    pub(super) greatest: f64,
}

/// The points of a path as they come, one a clock, and how far each is from the ideal curve.
///
/// Runs in one direction are one piece. Paths with hundreds of thousands of corners are coarsened step by step to what
/// can still be seen; ends, bounds and the greatest deviation stay exact.
#[derive(Clone, Debug)]
pub struct Recording {
    axes: usize,
    corners: Vec<[i64; 3]>,
    /// Corners closer together than this along every axis are one, BLU.
    grain: u64,
    spans: Vec<Span>,
    /// Points of each span but the last.
    per_span: u64,
    in_last: u64,
    points: u64,
    start: [i64; 3],
    last: [i64; 3],
    bounds: [[i64; 2]; 3],
    worst: Worst,
}

/// The point that is furthest off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Worst {
    /// BLU, with its sign.
    pub(super) deviation: f64,
    /// 0 for the start point.
    pub(super) clock: u64,
    pub(super) at: [i64; 3],
}

impl Recording {
    /// Begins at a start point, with `axes` axes, 2 or 3. `deviation` is in BLU.
    #[must_use]
    pub fn new(axes: usize, start: [i64; 3], deviation: f64) -> Recording {
        Recording {
            axes,
            corners: vec![start],
            grain: 1,
            spans: vec![Span { least: deviation, greatest: deviation }],
            per_span: 1,
            in_last: 1,
            points: 1,
            start,
            last: start,
            bounds: start.map(|v| [v, v]),
            worst: Worst { deviation, clock: 0, at: start },
        }
    }

    /// One clock, and where it led.
    pub fn push(&mut self, at: [i64; 3], deviation: f64) {
        if deviation.abs() > self.worst.deviation.abs() {
            self.worst = Worst { deviation, clock: self.points, at };
        }
        self.points += 1;
        self.last = at;
        for (bounds, v) in self.bounds.iter_mut().zip(at) {
            *bounds = [bounds[0].min(v), bounds[1].max(v)];
        }
        self.corner(at);
        self.span(deviation);
    }

    fn corner(&mut self, at: [i64; 3]) {
        let Some(&before) = self.corners.last() else { return };
        if apart(before, at) < self.grain {
            return;
        }
        if let [.., from, middle] = self.corners[..]
            && straight(from, middle, at)
        {
            self.corners.pop();
        }
        self.corners.push(at);
        while self.corners.len() > CORNERS {
            self.grain *= 2;
            let mut kept = self.corners[0];
            let grain = self.grain;
            self.corners.retain(|&c| {
                c == kept
                    || apart(kept, c) >= grain && {
                        kept = c;
                        true
                    }
            });
        }
    }

    fn span(&mut self, deviation: f64) {
        if self.in_last == self.per_span {
            if self.spans.len() == SPANS {
                let merged = self.spans.chunks(2).map(|pair| {
                    let all = || pair.iter();
                    Span {
                        least: all().map(|s| s.least).fold(f64::INFINITY, f64::min),
                        greatest: all().map(|s| s.greatest).fold(f64::NEG_INFINITY, f64::max),
                    }
                });
                self.spans = merged.collect();
                self.per_span *= 2;
            }
            self.spans.push(Span { least: deviation, greatest: deviation });
            self.in_last = 1;
            return;
        }
        if let Some(last) = self.spans.last_mut() {
            *last = Span { least: last.least.min(deviation), greatest: last.greatest.max(deviation) };
        }
        self.in_last += 1;
    }

    /// How many clocks there were.
    #[must_use]
    pub const fn clocks(&self) -> u64 {
        self.points - 1
    }

    /// The greatest distance from the curve in BLU with its sign, and the first clock that has it, 0 for the start.
    #[must_use]
    pub const fn worst(&self) -> (f64, u64) {
        (self.worst.deviation, self.worst.clock)
    }

    /// The last point.
    #[must_use]
    pub const fn last(&self) -> [i64; 3] {
        self.last
    }

    pub(super) const fn axes(&self) -> usize {
        self.axes
    }

    pub(super) const fn start(&self) -> [i64; 3] {
        self.start
    }

    pub(super) const fn furthest(&self) -> Worst {
        self.worst
    }

    /// The least and greatest coordinate along an axis.
    pub(super) const fn bounds(&self, axis: usize) -> [i64; 2] {
        self.bounds[axis]
    }

    /// The corners, from the start to the last point.
    pub(super) fn corners(&self) -> impl Iterator<Item = [i64; 3]> + '_ {
        let last = (self.corners.last() != Some(&self.last)).then_some(self.last);
        self.corners.iter().copied().chain(last)
    }

    /// The deviations, and how many points each span but the last has.
    pub(super) fn spans(&self) -> (&[Span], u64) {
        (&self.spans, self.per_span)
    }
}

/// The greatest difference along an axis.
fn apart(a: [i64; 3], b: [i64; 3]) -> u64 {
    (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0)
}

/// Whether the way goes on in the same direction.
fn straight(from: [i64; 3], middle: [i64; 3], to: [i64; 3]) -> bool {
    let wide = |a: [i64; 3], b: [i64; 3]| [0, 1, 2].map(|i| i128::from(b[i]) - i128::from(a[i]));
    let (u, v) = (wide(from, middle), wide(middle, to));
    let product = |i: usize, j: usize| u[i].checked_mul(v[j]);
    let parallel = [(0, 1), (0, 2), (1, 2)].iter().all(|&(i, j)| product(i, j) == product(j, i));
    parallel && (0..3).all(|i| u[i].signum() == v[i].signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_one_piece() {
        let mut r = Recording::new(2, [0; 3], 0.0);
        for (x, y) in [(1, 0), (2, 0), (3, 1), (4, 2), (4, 3), (4, 2)] {
            r.push([x, y, 0], f64::from(x as i32 - y as i32));
        }
        let corners: Vec<_> = r.corners().map(|c| (c[0], c[1])).collect();
        assert_eq!(corners, [(0, 0), (2, 0), (4, 2), (4, 3), (4, 2)]);
        assert_eq!((r.clocks(), r.worst(), r.last()), (6, (2.0, 2), [4, 2, 0]));
        assert_eq!((r.bounds(0), r.bounds(1)), ([0, 4], [0, 3]));
    }

    #[test]
    fn memory_is_bounded_and_the_ends_are_exact() {
        let mut r = Recording::new(2, [0; 3], 0.0);
        let n: i64 = 400_000;
        for i in 1..=n {
            r.push([(i + 1) / 2, i / 2, 0], if i == 300_001 { -9.0 } else { 0.5 });
        }
        assert!(r.corners.len() <= CORNERS && r.spans.len() <= SPANS);
        assert_eq!(r.corners().last(), Some([n / 2, n / 2, 0]));
        assert_eq!((r.clocks(), r.worst()), (n as u64, (-9.0, 300_001)));
        let (spans, per_span) = r.spans();
        assert_eq!(spans[(300_001 / per_span) as usize], Span { least: -9.0, greatest: 0.5 });
        assert_eq!((spans.len() as u64 - 1) * per_span + r.in_last, n as u64 + 1);
        // a way to and fro ends too
        for i in 0..n {
            r.push([n / 2 - i % 2, n / 2, 0], 0.0);
        }
        assert!(r.corners.len() <= CORNERS);
    }
}
