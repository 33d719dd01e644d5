//! Line by evaluation function: document B, «Линейна интерполация», and the linear part of document C.
//!
//! The evaluation function of a point is `F(x, y) = (y − YH)·ΔX − (x − XH)·ΔY`: positive above the line, negative
//! below it, 0 on it. `F ≥ 0` calls for a step along x, which takes `ΔY` from `F`; `F < 0` for one along y, which adds
//! `ΔX`. [`EfLine`] does what the document's block diagram does and ends for every input; [`EfLinePrinted`] is the
//! document's program taken at its word, which does not.

use std::iter::FusedIterator;

use super::mask;
use crate::{Clock, Columns, InputError, Interpolator, LineInput, Method, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: LineInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(match (options.as_printed, options.centred) {
        (false, false) => Box::new(EfLine::new(input)?),
        (false, true) => Box::new(EfLine::centred(input)?),
        (true, false) => {
            let printed = EfLinePrinted::new(input)?;
            Box::new(Watchdog::new(printed, printed.bound()))
        }
        (true, true) => {
            return Err(InputError::Option { method: Method::EfLine, option: "--centred with --as-printed" });
        }
    })
}

/// The cells of the program's memory, which are the registers of the block diagram. Shared by both lines in the plane
/// by evaluation function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct State {
    pub(super) input: LineInput,
    pub(super) xt: i64,
    pub(super) yt: i64,
    pub(super) kox: u64,
    pub(super) koy: u64,
    pub(super) f: i64,
}

impl State {
    /// Points 1 to 3 of the program: what START loads.
    pub(super) fn load(input: LineInput) -> Result<State, InputError> {
        input.check()?;
        let LineInput { xh, yh, dx, dy, .. } = input;
        Ok(State { input, xt: xh, yt: yh, kox: dx.unsigned_abs(), koy: dy.unsigned_abs(), f: 0 })
    }

    pub(super) const fn end(&self) -> bool {
        self.kox == 0 && self.koy == 0
    }

    /// The registers after a clock with these steps.
    pub(super) fn clock(&self, x: bool, y: bool) -> Clock {
        Clock {
            step: [i8::from(x), i8::from(y), 0],
            at: [self.xt, self.yt, 0],
            left: [self.kox, self.koy, 0],
            sum: [self.f, 0, 0],
            end: self.end(),
        }
    }

    pub(super) const fn step_x(&mut self) {
        self.xt += 1;
        self.kox = self.kox.wrapping_sub(1) & mask(self.input.bits);
    }

    pub(super) const fn step_y(&mut self) {
        self.yt += 1;
        self.koy = self.koy.wrapping_sub(1) & mask(self.input.bits);
    }
}

/// The line as the block diagram draws it: an iterator over its clocks, up to the one that ends it.
///
/// Each clock the sign of `F` picks an axis (point 7). An axis steps only while its counter is not 0: that is what the
/// two SR flip-flops of the diagram do, and the program leaves out. `F` changes on every clock, also when the axis that
/// it picked is done; otherwise `ΔX = 0` would stay at `F = 0` for ever, picking x. So a line takes `ΔX + ΔY` clocks,
/// and one more, without a step, if `ΔX = 0 < ΔY`. The line (0, 0) ends at START, with no clock.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLine, LineInput};
/// let line = EfLine::new(LineInput::new(5, 3))?;
/// let steps: String = line.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XYXYXXYX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfLine {
    state: State,
}

impl EfLine {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// If an increment is negative, or it or a coordinate does not fit the registers, or their width is not possible.
    pub fn new(input: LineInput) -> Result<Self, InputError> {
        Ok(EfLine { state: State::load(input)? })
    }

    /// The same with `F₀ = ⌊(ΔX − ΔY)/2⌋` for 0 (an extension): the middle of −ΔY … ΔX − 1, the range of `F`. The
    /// deviation is at most √½ BLU then, and `ΔX = 0` costs no clock without a step.
    ///
    /// # Errors
    /// As [`EfLine::new`].
    pub fn centred(input: LineInput) -> Result<Self, InputError> {
        let mut line = EfLine::new(input)?;
        line.state.f = (input.dx - input.dy) >> 1;
        Ok(line)
    }
}

impl Interpolator for EfLine {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfLine {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        // Point 6.
        if s.end() {
            return None;
        }
        // Point 7: 7.1 at F ≥ 0, else 7.2.
        let (x, y) = (s.f >= 0 && s.kox > 0, s.f < 0 && s.koy > 0);
        if x {
            s.step_x();
        }
        if y {
            s.step_y();
        }
        s.f += if s.f >= 0 { -s.input.dy } else { s.input.dx };
        Some(s.clock(x, y))
    }
}

impl FusedIterator for EfLine {}

/// Points 4 to 7 of document B's program, literally: the end is tested for both counters together (6), and the axis
/// that `F` picks steps even when its own counter is 0 (7.1, 7.2), which then passes below 0.
///
/// With `ΔX > 0` it equals [`EfLine`]. With `ΔX = 0 < ΔY` it never ends: `F = 0` gives a false x step, `KOX` wraps to
/// 2^bits − 1 and stays there, since `F = −ΔY` is negative from then on. Document C admits as much of its own device:
/// if the segment lies along Y, "the first step, which must always be along X, and all following ones are not made"
/// («первый шаг, который всегда должен быть по оси Х и все последующие не делаются»).
/// It has to be bounded from outside, see [`Watchdog`].
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLinePrinted, LineInput};
/// let line = EfLinePrinted::new(LineInput::new(0, 3))?;
/// let steps: String = line.take(6).map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XYYYYY");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EfLinePrinted {
    state: State,
}

impl EfLinePrinted {
    /// Points 1 to 3.
    ///
    /// # Errors
    /// As [`EfLine::new`].
    pub fn new(input: LineInput) -> Result<Self, InputError> {
        Ok(EfLinePrinted { state: State::load(input)? })
    }

    /// A bound for a watchdog, `2·(KOX + KOY)` clocks: a line that ends needs half of them, one step for each.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        2 * (self.state.kox + self.state.koy)
    }
}

impl Interpolator for EfLinePrinted {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfLinePrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        // Points 4 and 5 move and wait: the first pass has nothing to move yet, each later one moves what 7 chose. Here
        // the move belongs to the clock that chose it. Point 6.
        if s.end() {
            return None;
        }
        // Point 7.
        let x = s.f >= 0;
        if x {
            s.step_x();
            s.f -= s.input.dy;
        } else {
            s.step_y();
            s.f += s.input.dx;
        }
        Some(s.clock(x, !x))
    }
}

impl FusedIterator for EfLinePrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(dx: i64, dy: i64) -> EfLine {
        EfLine::new(LineInput::new(dx, dy)).unwrap()
    }

    fn steps(dx: i64, dy: i64) -> String {
        line(dx, dy).map(|c| c.letter()).collect()
    }

    fn all_8_bit() -> impl Iterator<Item = (i64, i64)> {
        (0..256).flat_map(|dx| (0..256).map(move |dy| (dx, dy)))
    }

    #[test]
    fn golden_steps() {
        assert_eq!(steps(5, 3), "XYXYXXYX");
        assert_eq!(steps(0, 0), "");
        assert_eq!(steps(0, 3), "-YYY");
        assert_eq!(steps(3, 0), "XXX");
        assert_eq!(steps(3, 3), "XYXYXY");
    }

    #[test]
    fn golden_values() {
        let f = |dx, dy| line(dx, dy).map(|c| c.sum[0]).collect::<Vec<_>>();
        assert_eq!(f(5, 3), [-3, 2, -1, 4, 1, -2, 3, 0]);
        // The idle clock makes F negative, and it stays so: adding DX = 0 changes nothing.
        assert_eq!(f(0, 3), [-3, -3, -3, -3]);
        assert_eq!(line(0, 0).state(), Clock { end: true, ..Clock::default() });
    }

    /// Against the document's own formula for F(x, y), not the recurrence that the iterator computes.
    #[test]
    fn every_8_bit_line_is_exact() {
        let (mut least, mut greatest) = (0, 0);
        for (dx, dy) in all_8_bit() {
            let (mut clocks, mut xs, mut ys, mut last) = (0, 0, 0, line(dx, dy).state());
            for c in line(dx, dy) {
                clocks += 1;
                xs += i64::from(c.step[0]);
                ys += i64::from(c.step[1]);
                assert_eq!(c.at, [xs, ys, 0], "({dx}, {dy})");
                assert_eq!((c.left[0] as i64, c.left[1] as i64), (dx - xs, dy - ys), "({dx}, {dy})");
                // Distance from the line is |F(x, y)| / √(ΔX² + ΔY²).
                let f = ys * dx - xs * dy;
                assert!(f * f < dx * dx + dy * dy, "({dx}, {dy}) is a BLU off at ({xs}, {ys})");
                if dx > 0 {
                    assert_eq!(c.sum[0], f, "({dx}, {dy})");
                }
                assert_eq!(c.end, (xs, ys) == (dx, dy));
                assert!(c.axes() < 2);
                (least, greatest, last) = (c.sum[0].min(least), c.sum[0].max(greatest), c);
            }
            assert!(last.end);
            assert_eq!((xs, ys), (dx, dy));
            let idle = i64::from(dx == 0 && dy > 0);
            assert_eq!(clocks, dx + dy + idle, "({dx}, {dy})");
        }
        assert_eq!((least, greatest), (-255, 254));
    }

    #[test]
    fn centred_8_bit_lines_are_exact_and_at_most_root_half_off() {
        let mut worst = 0.0;
        for (dx, dy) in all_8_bit() {
            let (mut clocks, mut last) = (0, line(dx, dy).state());
            for c in EfLine::centred(LineInput::new(dx, dy)).unwrap() {
                clocks += 1;
                let f = c.at[1] * dx - c.at[0] * dy;
                // |F| / √(ΔX² + ΔY²) ≤ √½
                assert!(2 * f * f <= dx * dx + dy * dy, "({dx}, {dy}) at {:?}", c.at);
                worst = f64::max(worst, (f * f) as f64 / (dx * dx + dy * dy) as f64);
                assert_eq!(c.sum[0], f + ((dx - dy) >> 1), "({dx}, {dy})");
                last = c;
            }
            assert_eq!((last.end, last.at, clocks), (true, [dx, dy, 0], dx + dy), "({dx}, {dy})");
        }
        println!("worst {}", worst.sqrt());
        assert_eq!((worst.sqrt() * 1e4).round(), 7071.0);
    }

    #[test]
    fn the_widest_line() {
        let most = (1 << 32) - 1;
        let mut line = EfLine::new(LineInput { xh: 0, yh: 0, dx: most, dy: most, bits: 32 }).unwrap();
        assert_eq!(line.by_ref().take(4).map(|c| c.sum[0]).collect::<Vec<_>>(), [-most, 0, -most, 0]);
        assert_eq!(line.state().left[0], (1 << 32) - 3);
    }

    #[test]
    fn as_printed_equals_the_diagram_unless_dx_is_0() {
        for (dx, dy) in all_8_bit().filter(|&(dx, dy)| dx > 0 || dy == 0) {
            assert!(EfLinePrinted::new(LineInput::new(dx, dy)).unwrap().eq(line(dx, dy)), "({dx}, {dy})");
        }
    }

    /// A state that comes back without an end comes back for ever.
    #[test]
    fn as_printed_never_stops_when_dx_is_0() {
        let mut endless = 0;
        for dy in 1..256 {
            let printed = EfLinePrinted::new(LineInput::new(0, dy)).unwrap();
            let states: Vec<_> = printed.take(1000).map(|c| (c.sum, c.left)).collect();
            assert_eq!(states.len(), 1000);
            endless += usize::from(states[1..].contains(&states[0]));
        }
        assert_eq!(endless, 255);
    }

    #[test]
    fn the_watchdog_reports() {
        let printed = EfLinePrinted::new(LineInput::new(0, 3)).unwrap();
        let mut watched = Watchdog::new(printed, printed.bound());
        assert_eq!(watched.stopped(), None);
        assert_eq!(watched.by_ref().count(), 6);
        assert_eq!(watched.next(), None);
        assert_eq!(watched.state().left[0], 255);
        let stopped = watched.stopped().unwrap();
        assert_eq!(stopped.to_string(), "stopped by the watchdog: no end within 6 clocks");
        let ends = EfLinePrinted::new(LineInput::new(2, 1)).unwrap();
        let mut watched = Watchdog::new(ends, 3);
        assert_eq!((watched.by_ref().count(), watched.stopped()), (3, None));
    }
}
