//! Line by evaluation function: document B, «Линейна интерполация», and the linear part of document C.
//!
//! The evaluation function of a point is `F(x, y) = (y − YH)·ΔX − (x − XH)·ΔY`: positive above the line, negative
//! below it, 0 on it. `F ≥ 0` calls for a step along x, which takes `ΔY` from `F`; `F < 0` for one along y, which adds
//! `ΔX`. [`EfLine`] does what the document's block diagram does and ends for every input; [`EfLinePrinted`] is the
//! document's program taken at its word, which does not.

use std::iter::FusedIterator;

use super::{InputError, MAX_BITS, Overrun, letter, mask, register};

/// A line of the first quadrant, and the width of the registers that draw it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct EfLineInput {
    /// `XH`, the start point's x in BLU: `−2^(bits−1) ≤ xh < 2^bits`. Negative ones are kept in two's complement.
    pub xh: i64,
    /// `YH`, its y; as `xh`.
    pub yh: i64,
    /// `ΔX = XK − XH` in BLU: `0 ≤ dx < 2^bits`.
    pub dx: i64,
    /// `ΔY = YK − YH`; as `dx`.
    pub dy: i64,
    /// Bits of a coordinate and of an increment, `1..=32`; `F` has one more.
    pub bits: u32,
}

impl EfLineInput {
    /// The line from the origin with increments `dx`, `dy`, in registers of 8 bits.
    #[must_use]
    pub const fn new(dx: i64, dy: i64) -> Self {
        EfLineInput { xh: 0, yh: 0, dx, dy, bits: 8 }
    }

    /// The line between two points: point 2 of the program, `DX = XK − XH`, `DY = YK − YH`.
    ///
    /// # Errors
    /// If a difference overflows. What registers of `bits` bits cannot hold is refused by [`EfLine::new`].
    pub fn between((xh, yh): (i64, i64), (xk, yk): (i64, i64), bits: u32) -> Result<Self, InputError> {
        let dx = xk.checked_sub(xh).ok_or(InputError::Overflow)?;
        let dy = yk.checked_sub(yh).ok_or(InputError::Overflow)?;
        Ok(EfLineInput { xh, yh, dx, dy, bits })
    }

    /// Points 1 to 3 of the program: what START loads.
    fn load(self) -> Result<State, InputError> {
        let EfLineInput { xh, yh, dx, dy, bits } = self;
        if !(1..=MAX_BITS).contains(&bits) {
            return Err(InputError::Bits { bits });
        }
        let increment = |name, value: i64| match u64::try_from(value) {
            Err(_) => Err(InputError::NegativeIncrement { name, value }),
            Ok(v) if v > mask(bits) => Err(InputError::WideIncrement { name, value, bits }),
            Ok(v) => Ok(v),
        };
        let coordinate = |name, value| register(value, bits).ok_or(InputError::WideCoordinate { name, value, bits });
        let (xt, yt) = (coordinate("XH", xh)?, coordinate("YH", yh)?);
        let (kox, koy) = (increment("DX", dx)?, increment("DY", dy)?);
        Ok(State { dx, dy, mask: mask(bits), xt, yt, kox, koy, f: 0 })
    }
}

/// One clock: its step pulses, and the registers after its trailing edge.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Clock {
    /// A step along x.
    pub x: bool,
    /// A step along y.
    pub y: bool,
    /// `XT`, the current x as its register shows it: unsigned, modulo 2^bits.
    pub xt: u64,
    /// `YT`, the current y.
    pub yt: u64,
    /// `KOX`, steps left along x.
    pub kox: u64,
    /// `KOY`, steps left along y.
    pub koy: u64,
    /// `F`, the evaluation function.
    pub f: i64,
    /// Both counters are 0.
    pub end: bool,
}

impl Clock {
    /// The letter of its steps, see [`letter`].
    #[must_use]
    pub const fn letter(&self) -> char {
        letter(self.x, self.y)
    }
}

/// The cells of the program's memory, which are the registers of the block diagram.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct State {
    dx: i64,
    dy: i64,
    mask: u64,
    xt: u64,
    yt: u64,
    kox: u64,
    koy: u64,
    f: i64,
}

impl State {
    const fn end(&self) -> bool {
        self.kox == 0 && self.koy == 0
    }

    const fn clock(&self, x: bool, y: bool) -> Clock {
        Clock { x, y, xt: self.xt, yt: self.yt, kox: self.kox, koy: self.koy, f: self.f, end: self.end() }
    }

    const fn step_x(&mut self) {
        self.xt = self.xt.wrapping_add(1) & self.mask;
        self.kox = self.kox.wrapping_sub(1) & self.mask;
    }

    const fn step_y(&mut self) {
        self.yt = self.yt.wrapping_add(1) & self.mask;
        self.koy = self.koy.wrapping_sub(1) & self.mask;
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
/// use discreta::interpolate::{EfLine, EfLineInput};
/// let line = EfLine::new(EfLineInput::new(5, 3))?;
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
    pub fn new(input: EfLineInput) -> Result<Self, InputError> {
        Ok(EfLine { state: input.load()? })
    }

    /// The registers as they stand: before the first clock, what START loaded.
    #[must_use]
    pub const fn state(&self) -> Clock {
        self.state.clock(false, false)
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
        s.f += if s.f >= 0 { -s.dy } else { s.dx };
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
/// («первый шаг, который всегда должен быть по оси Х и все последующие не делаются»). A watchdog stops it with an
/// [`Overrun`] as the last item.
///
/// ```
/// use discreta::interpolate::{EfLineInput, EfLinePrinted};
/// let mut line = EfLinePrinted::new(EfLineInput::new(0, 3))?;
/// let steps: String = line.by_ref().map_while(Result::ok).map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XYYYYY");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfLinePrinted {
    state: State,
    limit: u64,
    clocks: u64,
    stopped: bool,
}

impl EfLinePrinted {
    /// Points 1 to 3, and a watchdog of `2·(DX + DY)` clocks: a line that ends needs half of them, one step for each.
    ///
    /// # Errors
    /// As [`EfLine::new`].
    pub fn new(input: EfLineInput) -> Result<Self, InputError> {
        let state = input.load()?;
        Ok(EfLinePrinted { state, limit: 2 * (state.kox + state.koy), clocks: 0, stopped: false })
    }

    /// The same with a watchdog of `limit` clocks.
    #[must_use]
    pub const fn with_limit(self, limit: u64) -> Self {
        EfLinePrinted { limit, ..self }
    }

    /// The cells as they stand: before the first clock, what points 1 to 3 put there.
    #[must_use]
    pub const fn state(&self) -> Clock {
        self.state.clock(false, false)
    }
}

impl Iterator for EfLinePrinted {
    type Item = Result<Clock, Overrun>;

    fn next(&mut self) -> Option<Self::Item> {
        let s = &mut self.state;
        // Points 4 and 5 move and wait: the first pass has nothing to move yet, each later one moves what 7 chose. Here
        // the move belongs to the clock that chose it. Point 6.
        if self.stopped || s.end() {
            return None;
        }
        if self.clocks == self.limit {
            self.stopped = true;
            return Some(Err(Overrun { clocks: self.limit }));
        }
        self.clocks += 1;
        // Point 7.
        let x = s.f >= 0;
        if x {
            s.step_x();
            s.f -= s.dy;
        } else {
            s.step_y();
            s.f += s.dx;
        }
        Some(Ok(s.clock(x, !x)))
    }
}

impl FusedIterator for EfLinePrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(dx: i64, dy: i64) -> EfLine {
        EfLine::new(EfLineInput::new(dx, dy)).unwrap()
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
        let f = |dx, dy| line(dx, dy).map(|c| c.f).collect::<Vec<_>>();
        assert_eq!(f(5, 3), [-3, 2, -1, 4, 1, -2, 3, 0]);
        // The idle clock makes F negative, and it stays so: adding DX = 0 changes nothing.
        assert_eq!(f(0, 3), [-3, -3, -3, -3]);
        assert_eq!(line(0, 0).state(), Clock { x: false, y: false, xt: 0, yt: 0, kox: 0, koy: 0, f: 0, end: true });
    }

    /// Against the document's own formula for F(x, y), not the recurrence that the iterator computes.
    #[test]
    fn every_8_bit_line_is_exact() {
        let (mut least, mut greatest) = (0, 0);
        for (dx, dy) in all_8_bit() {
            let (mut clocks, mut xs, mut ys, mut last) = (0, 0, 0, line(dx, dy).state());
            for c in line(dx, dy) {
                clocks += 1;
                xs += i64::from(c.x);
                ys += i64::from(c.y);
                assert_eq!((c.xt as i64, c.yt as i64), (xs, ys), "({dx}, {dy})");
                assert_eq!((c.kox as i64, c.koy as i64), (dx - xs, dy - ys), "({dx}, {dy})");
                // Distance from the line is |F(x, y)| / √(ΔX² + ΔY²).
                let f = ys * dx - xs * dy;
                assert!(f * f < dx * dx + dy * dy, "({dx}, {dy}) is a BLU off at ({xs}, {ys})");
                if dx > 0 {
                    assert_eq!(c.f, f, "({dx}, {dy})");
                }
                assert_eq!(c.end, (xs, ys) == (dx, dy));
                assert!(!(c.x && c.y));
                (least, greatest, last) = (c.f.min(least), c.f.max(greatest), c);
            }
            assert!(last.end);
            assert_eq!((xs, ys), (dx, dy));
            let idle = i64::from(dx == 0 && dy > 0);
            assert_eq!(clocks, dx + dy + idle, "({dx}, {dy})");
        }
        assert_eq!((least, greatest), (-255, 254));
    }

    #[test]
    fn coordinates_wrap_as_registers_do() {
        let line = EfLine::new(EfLineInput { xh: 254, yh: -1, dx: 5, dy: 3, bits: 8 }).unwrap();
        assert_eq!((line.state().xt, line.state().yt), (254, 255));
        let path: Vec<_> = line.map(|c| (c.xt, c.yt)).collect();
        assert_eq!(path, [(255, 255), (255, 0), (0, 0), (0, 1), (1, 1), (2, 1), (2, 2), (3, 2)]);
    }

    #[test]
    fn the_widest_line() {
        let most = (1 << 32) - 1;
        let mut line = EfLine::new(EfLineInput { xh: 0, yh: 0, dx: most, dy: most, bits: 32 }).unwrap();
        assert_eq!(line.by_ref().take(4).map(|c| c.f).collect::<Vec<_>>(), [-most, 0, -most, 0]);
        assert_eq!(line.state().kox, (1 << 32) - 3);
    }

    #[test]
    fn as_printed_equals_the_diagram_unless_dx_is_0() {
        for (dx, dy) in all_8_bit().filter(|&(dx, dy)| dx > 0 || dy == 0) {
            let printed: Result<Vec<_>, _> = EfLinePrinted::new(EfLineInput::new(dx, dy)).unwrap().collect();
            assert!(printed.unwrap().into_iter().eq(line(dx, dy)), "({dx}, {dy})");
        }
    }

    /// A state that comes back without an end comes back for ever.
    #[test]
    fn as_printed_never_stops_when_dx_is_0() {
        let mut endless = 0;
        for dy in 1..256 {
            let printed = EfLinePrinted::new(EfLineInput::new(0, dy)).unwrap().with_limit(1000);
            let states: Vec<_> = printed.map_while(Result::ok).map(|c| (c.f, c.kox, c.koy)).collect();
            assert_eq!(states.len(), 1000);
            endless += usize::from(states[1..].contains(&states[0]));
        }
        assert_eq!(endless, 255);
    }

    #[test]
    fn the_watchdog_reports_once() {
        let mut printed = EfLinePrinted::new(EfLineInput::new(0, 3)).unwrap();
        let last = printed.by_ref().last();
        assert_eq!(last, Some(Err(Overrun { clocks: 6 })));
        assert_eq!(printed.next(), None);
        assert_eq!(printed.state().kox, 255);
        assert_eq!(Overrun { clocks: 6 }.to_string(), "stopped by the watchdog: no end within 6 clocks");
    }

    #[test]
    fn input_is_refused_with_its_limit() {
        let ok = EfLineInput::new(5, 3);
        let message = |input| EfLine::new(input).unwrap_err().to_string();
        assert_eq!(
            message(EfLineInput { dx: -5, ..ok }),
            "DX = -5 is negative: the line has to lie in the first quadrant"
        );
        assert_eq!(message(EfLineInput { dy: 256, ..ok }), "DY = 256 is above 255, the greatest of 8 bits");
        assert_eq!(message(EfLineInput { xh: 256, ..ok }), "XH = 256 is outside -128..255, what 8 bits hold");
        assert_eq!(
            message(EfLineInput { yh: i64::MIN, bits: 32, ..ok }).split(" is ").next(),
            Some("YH = -9223372036854775808")
        );
        assert_eq!(message(EfLineInput { bits: 0, ..ok }), "registers of 0 bits: they may have 1 to 32");
        assert_eq!(message(EfLineInput { bits: 33, ..ok }), "registers of 33 bits: they may have 1 to 32");
        assert_eq!(EfLineInput::between((i64::MIN, 0), (1, 0), 8), Err(InputError::Overflow));
        assert_eq!(EfLineInput::between((2, 1), (7, 4), 8).map(|i| (i.dx, i.dy)), Ok((5, 3)));
    }
}
