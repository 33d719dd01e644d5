//! What is drawn with every method of a kind.

use std::fmt;

use serde::Serialize;

use super::Variant;
use crate::interpolate::Request;
use crate::random;

/// A part of all segments, drawn by a seed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub struct Sample {
    /// How many segments.
    pub number: u64,
    /// Where the pseudo-random sequence begins.
    pub seed: u64,
}

/// The kind of segments.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SetKind {
    /// Lines in the plane.
    Lines,
    /// Quarter circles from the x axis to the y axis.
    Quarters,
    /// Arcs that begin and end anywhere in the quadrant, with ends rounded off the circle.
    Arcs,
    /// Full circles as curves of the second order.
    Circles,
    /// Lines in space.
    Space,
}

/// Segments for all methods of a kind.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Set {
    /// Their kind.
    pub kind: SetKind,
    /// Bits of the registers, 4 at least.
    pub bits: u32,
    /// All of them, or some.
    pub sample: Option<Sample>,
}

/// From where to where.
type Segment = ([i64; 3], [i64; 3]);

impl Set {
    /// The methods that draw such segments.
    #[must_use]
    pub const fn variants(&self) -> &'static [Variant] {
        match self.kind {
            SetKind::Lines => Variant::LINES,
            SetKind::Quarters | SetKind::Arcs => Variant::ARCS,
            SetKind::Circles => Variant::CURVES,
            SetKind::Space => Variant::SPACE,
        }
    }

    /// How many segments there are, without drawing them.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.segments().count() as u64
    }

    /// Every segment as something that the method of a variant can be asked for.
    pub fn requests(&self, variant: Variant) -> impl Iterator<Item = Request> + use<> {
        let bits = self.bits;
        let curves = self.kind == SetKind::Circles;
        self.segments().map(move |(from, to)| Request {
            from,
            conic: curves.then(|| [1, 0, 1, 0, 0, -from[0] * from[0]]),
            bits: Some(bits),
            options: variant.options,
            ..Request::new(variant.method, to)
        })
    }

    fn segments(&self) -> Box<dyn Iterator<Item = Segment>> {
        let n = 1_i64 << self.bits;
        match (self.kind, self.sample) {
            (SetKind::Lines, None) => {
                Box::new((0..n).flat_map(move |x| (0..n).map(move |y| ([0; 3], [x, y, 0]))).skip(1))
            }
            (SetKind::Lines, Some(sample)) => Box::new(sample.of(move |r| ([0; 3], [r.below(n), r.below(n), 0]))),
            (SetKind::Quarters, None) => Box::new((1..n).map(quarter)),
            (SetKind::Quarters, Some(sample)) => Box::new(sample.of(move |r| quarter(1 + r.below(n - 1)))),
            (SetKind::Arcs, None) => {
                let parts = || (0..6).flat_map(|a| (a + 1..7).map(move |b| (a, b)));
                let degrees = |n: i32| f64::from(15 * n);
                Box::new(
                    (1..n)
                        .flat_map(move |r| parts().filter_map(move |(a, b)| arc(r as f64, degrees(a), degrees(b), n))),
                )
            }
            (SetKind::Arcs, Some(sample)) => Box::new(sample.of(move |r| {
                loop {
                    let (radius, a, b) = (1 + r.below(n - 1), r.below(900), r.below(901));
                    if let Some(arc) = arc(radius as f64, a.min(b) as f64 / 10.0, a.max(b) as f64 / 10.0, n) {
                        return arc;
                    }
                }
            })),
            (SetKind::Circles, None) => Box::new((2..n / 2 - 3).map(circle)),
            // a circle ends where it begins, which in other sets is refused
            (SetKind::Circles, Some(sample)) => {
                let mut random = Random(sample.seed);
                Box::new((0..sample.number).map(move |_| circle(2 + random.below(n / 2 - 5))))
            }
            (SetKind::Space, sample) => {
                let sample = sample.unwrap_or(SPACE);
                Box::new(sample.of(move |r| ([0; 3], [r.below(n), r.below(n), r.below(n)])))
            }
        }
    }
}

/// Lines in space are always a sample.
const SPACE: Sample = Sample { number: 4096, seed: 1 };

fn quarter(r: i64) -> Segment {
    ([r, 0, 0], [0, r, 0])
}

fn circle(r: i64) -> Segment {
    ([r, 0, 0], [r, 0, 0])
}

/// From the lattice point nearest to one direction to the one nearest to another on the circle through it; none if that
/// is no arc of the quadrant, or wider than the registers.
fn arc(radius: f64, from: f64, to: f64, n: i64) -> Option<Segment> {
    let point = |radius: f64, degrees: f64| {
        let angle = degrees.to_radians();
        [(radius * libm::cos(angle)).round() as i64, (radius * libm::sin(angle)).round() as i64, 0]
    };
    let start = point(radius, from);
    let through = ((start[0] * start[0] + start[1] * start[1]) as f64).sqrt();
    let end = point(through, to);
    let there = end[0] < start[0] && end[1] >= start[1] || end[0] <= start[0] && end[1] > start[1];
    (there && end[1] < n && start[0] < n).then_some((start, end))
}

impl Sample {
    fn of(self, make: impl Fn(&mut Random) -> Segment + 'static) -> impl Iterator<Item = Segment> {
        let mut random = Random(self.seed);
        (0..self.number).map(move |_| {
            loop {
                let segment = make(&mut random);
                if segment.0 != segment.1 {
                    return segment;
                }
            }
        })
    }
}

/// The numbers of a sample.
struct Random(u64);

impl Random {
    /// A number from 0 up to but without `n`.
    fn below(&mut self, n: i64) -> i64 {
        ((u128::from(random::next(&mut self.0)) * u128::from(n.unsigned_abs())) >> 64) as i64
    }
}

impl fmt::Display for Set {
    /// Which segments these are, in words.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = self.bits;
        let most = (1_u64 << p) - 1;
        let some = |s: Sample| format!("{} of them drawn by seed {}", s.number, s.seed);
        let which = |all: &str| self.sample.map_or_else(|| all.to_owned(), some);
        match self.kind {
            SetKind::Lines => write!(f, "Lines from the origin with increments of {p} bits, {}.", which("all of them")),
            SetKind::Quarters => {
                write!(
                    f,
                    "Quarter circles counter-clockwise from (R, 0) to (0, R), R = 1…{most}, {}.",
                    which("all of them")
                )
            }
            SetKind::Circles => write!(
                f,
                "Full circles counter-clockwise from (R, 0), as the curve x² + y² = R², R = 2…{}, {}. Twice a coordinate \
                 has to fit {p} bits, also where the path is outside; R = 1 is never left far enough to come to an end.",
                (1_u64 << (p - 1)) - 4,
                which("all of them")
            ),
            SetKind::Arcs => {
                let directions = if self.sample.is_some() { "tenths of a degree" } else { "15°" };
                write!(
                    f,
                    "Arcs of the first quadrant, counter-clockwise: from the lattice point nearest to a direction on the \
                     circle R = 1…{most}, along the circle through it, to the one nearest to a further direction; \
                     directions in {directions}, {}. Most ends are not on their circle.",
                    which("all of them")
                )
            }
            SetKind::Space => {
                write!(
                    f,
                    "Lines in space from the origin with increments of {p} bits, {}.",
                    some(self.sample.unwrap_or(SPACE))
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(kind: SetKind, bits: u32, sample: Option<Sample>) -> usize {
        Set { kind, bits, sample }.segments().count()
    }

    #[test]
    fn sets_have_the_size_that_they_say() {
        assert_eq!(count(SetKind::Lines, 4, None), 255);
        assert_eq!(count(SetKind::Quarters, 8, None), 255);
        assert_eq!(count(SetKind::Circles, 8, None), 123);
        let sample = Some(Sample { number: 77, seed: 5 });
        for kind in [SetKind::Lines, SetKind::Quarters, SetKind::Arcs, SetKind::Circles, SetKind::Space] {
            assert_eq!(count(kind, 12, sample), 77);
            let set = Set { kind, bits: 12, sample };
            assert!(set.segments().eq(set.segments()));
            assert!(set.to_string().contains("77 of them drawn by seed 5"));
        }
    }

    #[test]
    fn arcs_lie_in_the_quadrant_and_fit_the_registers() {
        let set = Set { kind: SetKind::Arcs, bits: 6, sample: None };
        // (5, 0) to 45° on R = 5: (3.54, 3.54) → (4, 4)
        assert!(set.segments().any(|s| s == ([5, 0, 0], [4, 4, 0])));
        for (from, to) in set.segments() {
            assert!(0 <= to[0] && to[0] <= from[0] && from[0] < 64, "{from:?} {to:?}");
            assert!(0 <= from[1] && from[1] <= to[1] && to[1] < 64, "{from:?} {to:?}");
        }
    }
}
