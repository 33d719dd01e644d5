//! Accelerated arc by evaluation function: document B, «Кръгова интерполация по ускорения алгоритъм».
//!
//! `F(x, y) = x² + y² − R²` as in the standard arc. The quadrant is cut into two octants: where `x ≥ y` the axis y leads,
//! where `x < y` the axis x does. The leading axis steps on every clock, and the sign of `F` says whether the other one
//! steps too: outside the circle (`F ≥ 0`) the falling coordinate has to step, inside the rising one. What a diagonal
//! step adds to `F` is what its two steps add, both with the old coordinates. [`EfCircleFast`] ends exactly for every
//! input; [`EfCircleFastPrinted`] is the document's program taken at its word.

use std::iter::FusedIterator;

use super::circle::State;
use crate::{ArcInput, Clock, Columns, InputError, Interpolator, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: ArcInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(if options.as_printed {
        let printed = EfCircleFastPrinted::new(input)?;
        Box::new(Watchdog::new(printed, printed.bound()))
    } else {
        Box::new(EfCircleFast::new(input)?)
    })
}

/// Which axes step by octant and sign (points 7 to 9), x and y. The document leaves `x = y` open; it is put to the first
/// octant, in both directions.
const fn choose(s: &State) -> (bool, bool) {
    let y_leads = s.xt >= s.yt;
    let x_corrects = (s.f >= 0) != s.input.clockwise;
    (!y_leads || x_corrects, y_leads || !x_corrects)
}

/// A clock with these steps; what they add to `F` is had from the old coordinates.
const fn step(s: &mut State, (x, y): (bool, bool)) -> Clock {
    s.f += if x { s.change_x() } else { 0 } + if y { s.change_y() } else { 0 };
    if x {
        s.step_x();
    }
    if y {
        s.step_y();
    }
    s.clock(x, y)
}

/// The accelerated arc: an iterator over its clocks, up to the one that ends it.
///
/// **When the counter of an axis is 0, the other axis steps alone**, whatever octant and sign say: the rule of
/// [`EfCircle`](crate::EfCircle), by which every arc ends exactly, also one whose end point is rounded off
/// the circle. An arc with no step to make ends at START.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, EfCircleFast};
/// let arc = EfCircleFast::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "DYYDXDX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfCircleFast {
    state: State,
}

impl EfCircleFast {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// What [`ArcInput::check`] refuses. And `F₀` so great at a start point with `x = y` that the first step, which adds
    /// 2 counter-clockwise, would carry it out of its register; elsewhere no step takes `F` further from 0 than its
    /// register reaches, until steps are forced.
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        let state = State::load(input)?;
        let ArcInput { xh, yh, dx, dy, f0, clockwise, bits } = input;
        if !clockwise && xh == yh && dx > 0 && dy > 0 && f0 + 2 >= 2 << bits {
            return Err(InputError::WideF0 { value: f0 + 2, bits: bits + 2 });
        }
        Ok(EfCircleFast { state })
    }
}

impl Interpolator for EfCircleFast {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfCircleFast {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        Some(match (s.kox, s.koy) {
            (0, 0) => return None,
            (0, _) => step(s, (false, true)),
            (_, 0) => step(s, (true, false)),
            _ => step(s, choose(s)),
        })
    }
}

impl FusedIterator for EfCircleFast {}

/// Points 4 to 9 of document B's program, literally: `XT` and `YT` are changed first and the changed values stand in the
/// formulas of `F` (8.1 to 9.2), so `F` is not `x² + y² − R²`; the end is both counters at 0 (6), and an axis steps even
/// when its own counter is 0, which then passes below 0.
///
/// It misses the end of nearly every quarter arc. It has to be bounded from outside, see [`Watchdog`].
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{ArcInput, EfCircleFastPrinted};
/// let arc = EfCircleFastPrinted::new(ArcInput::between((5, 0), (0, 5), false, 8))?;
/// let steps: String = arc.take(10).map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "DYDDXXXXXX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EfCircleFastPrinted {
    state: State,
}

impl EfCircleFastPrinted {
    /// Points 1 to 3.
    ///
    /// # Errors
    /// What [`ArcInput::check`] refuses.
    pub fn new(input: ArcInput) -> Result<Self, InputError> {
        Ok(EfCircleFastPrinted { state: State::load(input)? })
    }

    /// A bound for a watchdog, `2·(KOX + KOY)` clocks: an arc that ends needs half of them at most, one for each step.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        2 * (self.state.kox + self.state.koy)
    }
}

impl Interpolator for EfCircleFastPrinted {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfCircleFastPrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() {
            return None;
        }
        let (x, y) = choose(s);
        if x {
            s.step_x();
        }
        if y {
            s.step_y();
        }
        s.f += if x { s.change_x() } else { 0 } + if y { s.change_y() } else { 0 };
        Some(s.clock(x, y))
    }
}

impl FusedIterator for EfCircleFastPrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(from: (i64, i64), to: (i64, i64), clockwise: bool) -> EfCircleFast {
        EfCircleFast::new(ArcInput::between(from, to, clockwise, 8)).unwrap()
    }

    fn quarter(r: i64, clockwise: bool) -> ArcInput {
        if clockwise { ArcInput::between((0, r), (r, 0), true, 8) } else { ArcInput::between((r, 0), (0, r), false, 8) }
    }

    /// The letters of the steps.
    fn steps(arc: impl Iterator<Item = Clock>) -> String {
        arc.map(|c| c.letter()).collect()
    }

    fn square(c: &Clock) -> i64 {
        c.at[0] * c.at[0] + c.at[1] * c.at[1]
    }

    /// Distance from the circle of a radius squared.
    fn off(c: &Clock, square_radius: i64) -> f64 {
        (square(c) as f64).sqrt() - (square_radius as f64).sqrt()
    }

    /// The points of the first quadrant nearest to a circle, counter-clockwise.
    fn rounded(r: i64) -> Vec<(i64, i64)> {
        let root = |n: i64| (n as f64).sqrt().round() as i64;
        let near = |v: i64| root(r * r - v * v);
        let mut points: Vec<_> = (0..=r).flat_map(|v| [(v, near(v)), (near(v), v)]).collect();
        points.sort_by_key(|&(x, y)| (-x, y));
        points.dedup();
        points
    }

    #[test]
    fn golden_steps() {
        // by hand, points 8 and 9
        let arc = EfCircleFast::new(quarter(5, false)).unwrap();
        assert_eq!(arc.clone().map(|c| c.sum[0]).collect::<Vec<_>>(), [-8, -5, 0, 0, -5, 1, 0]);
        assert_eq!(steps(arc), "DYYDXDX");
        // the mirror image: x and y exchanged
        assert_eq!(steps(EfCircleFast::new(quarter(5, true)).unwrap()), "DXXDYDY");
        assert_eq!(steps(EfCircleFast::new(quarter(1, false)).unwrap()), "D");
    }

    #[test]
    fn every_8_bit_quarter_arc_ends_exactly() {
        for clockwise in [false, true] {
            let (mut outside, mut inside, mut clocks) = (0.0, 0.0, 0);
            for r in 1..256 {
                let mut last = None;
                clocks = 0;
                for c in EfCircleFast::new(quarter(r, clockwise)).unwrap() {
                    assert_eq!(c.sum[0], square(&c) - r * r);
                    (outside, inside) = (off(&c, r * r).max(outside), off(&c, r * r).min(inside));
                    clocks += 1;
                    last = Some(c);
                }
                let last = last.unwrap();
                assert_eq!((last.end, last.at, last.sum[0]), (true, if clockwise { [r, 0, 0] } else { [0, r, 0] }, 0));
            }
            println!("clockwise: {clockwise}; {outside:.3} outside, {inside:.3} inside, {clocks} clocks for R = 255");
            assert_eq!(((outside * 1e3_f64).round(), (inside * 1e3_f64).round()), (906.0, -998.0));
            assert_eq!(clocks, 361); // 1.416·R
        }
    }

    /// Between any two lattice points of a circle around the origin.
    #[test]
    fn arcs_between_points_on_the_circle_stay_within_a_blu() {
        let (mut arcs, mut worst, mut least, mut greatest) = (0, 0.0, 0, 0);
        let mut circles: Vec<Vec<(i64, i64)>> = vec![Vec::new(); 2 << 14];
        for (x, y) in (0..128).flat_map(|x| (0..128).map(move |y| (x, y))) {
            circles[(x * x + y * y) as usize].push((x, y));
        }
        for (r2, points) in circles.iter().enumerate().skip(1) {
            for (&from, &to) in points.iter().flat_map(|a| points.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
                let mut last = None;
                for c in arc(from, to, from.0 < to.0) {
                    worst = off(&c, r2 as i64).abs().max(worst);
                    (least, greatest) = (c.sum[0].min(least), c.sum[0].max(greatest));
                    last = Some(c);
                }
                assert_eq!(last.map(|c| (c.at, c.sum[0])), Some(([to.0, to.1, 0], 0)));
                arcs += 1;
            }
        }
        println!("{arcs} arcs, worst {worst}, F in {least}..={greatest}");
        assert!(arcs > 10_000 && worst < 0.999, "{arcs} arcs, {worst}");
        assert!((-256..256).contains(&least) && (-256..256).contains(&greatest), "two bits more than a coordinate");
    }

    /// Start and end points rounded, `F₀` as the start point has it.
    #[test]
    fn arcs_between_rounded_points_end_exactly() {
        let (mut arcs, mut missed, mut worst) = (0, 0, 0.0);
        for r in 1..64 {
            let points = rounded(r);
            for (i, &from) in points.iter().enumerate() {
                for &to in &points[i..] {
                    for (from, to, clockwise) in [(from, to, false), (to, from, true)] {
                        let f0 = from.0 * from.0 + from.1 * from.1 - r * r;
                        let input = ArcInput { f0, ..ArcInput::between(from, to, clockwise, 6) };
                        let mut last = [from.0, from.1, 0];
                        for c in EfCircleFast::new(input).unwrap() {
                            worst = off(&c, r * r).abs().max(worst);
                            last = c.at;
                        }
                        assert_eq!(last, [to.0, to.1, 0], "{input:?}");
                        // what the rule is for
                        let mut free = State::load(input).unwrap();
                        for _ in 0..input.dx + input.dy {
                            if !free.end() {
                                let free_steps = choose(&free);
                                step(&mut free, free_steps);
                            }
                        }
                        missed += usize::from(!free.end());
                        arcs += 1;
                    }
                }
            }
        }
        println!("{arcs} arcs, {missed} would miss their end without the rule, worst {worst}");
        assert_eq!((arcs, missed), (179_308, 31_055));
        assert!(worst < 1.0, "{worst}");
    }

    /// Every 4-bit arc of the quadrant from every `F₀` that its register holds: exact, in few clocks, and `F` within six
    /// bits for as long as its sign is asked.
    #[test]
    fn whatever_f0_is_the_end_is_exact_and_no_sign_is_lost() {
        let (mut arcs, mut refused) = (0, 0);
        let all = (0..16).flat_map(|x| (0..16).map(move |y| (x, y)));
        let pairs = all.clone().flat_map(|a| all.clone().map(move |b| (a, b)));
        for (from, to) in pairs.filter(|&(a, b)| a != (0, 0) && (a.0 - b.0) * (a.1 - b.1) <= 0) {
            let clockwise = from.0 < to.0 || from.1 > to.1;
            for f0 in -32..32 {
                let input = ArcInput { f0, ..ArcInput::between(from, to, clockwise, 4) };
                let Ok(arc) = EfCircleFast::new(input) else {
                    refused += 1;
                    assert!(!clockwise && from.0 == from.1 && f0 >= 30);
                    continue;
                };
                let (mut last, mut clocks) = (arc.state(), 0);
                for c in arc {
                    (last, clocks) = (c, clocks + 1);
                    let asked = c.left[0] > 0 && c.left[1] > 0;
                    assert!(!asked || (-32..32).contains(&c.sum[0]), "{input:?} at {c:?}");
                }
                assert_eq!((last.end, last.at), (true, [to.0, to.1, 0]), "{input:?}");
                assert!((input.dx.max(input.dy)..=input.dx + input.dy).contains(&clocks));
                arcs += 1;
            }
        }
        println!("{arcs} arcs, {refused} refused");
        let input = ArcInput { f0: 511, ..ArcInput::between((3, 3), (2, 4), false, 8) };
        let message = EfCircleFast::new(input).unwrap_err().to_string();
        assert!(message.contains("F = 513 is outside -512..511"), "{message}");
    }

    #[test]
    fn as_printed_nearly_every_quarter_arc_misses_its_end() {
        let missed = |bits: u32, clockwise| {
            let ends = |r: i64| {
                let printed = EfCircleFastPrinted::new(ArcInput { bits, ..quarter(r, clockwise) }).unwrap();
                let mut watched = Watchdog::new(printed, printed.bound());
                let clocks = watched.by_ref().count();
                assert!(clocks as i64 <= 4 * r && watched.stopped().is_some() != watched.state().end);
                watched.state().end
            };
            (1..1 << bits).filter(|&r| !ends(r)).count()
        };
        assert_eq!([missed(7, false), missed(8, false), missed(7, true)], [125, 253, 126]);
    }
}
