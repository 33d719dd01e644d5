//! Accelerated line by evaluation function: document B, «Линейна интерполация по ускорения алгоритъм».
//!
//! The axis with the longer way leads: it steps on every clock, and the sign of `F` says whether the other one steps too.
//! `F(x, y) = (y − YH)·ΔX − (x − XH)·ΔY` as in the standard line, so a diagonal step adds `ΔX − ΔY`. [`EfLineFast`] ends
//! exactly for every input; [`EfLineFastPrinted`] is the document's program, or its block diagram, taken at its word.

use std::iter::FusedIterator;

use super::line::State;
use crate::{Clock, Columns, InputError, Interpolator, LineInput, Method, Options, Watchdog};

/// What the command line asks for.
pub(crate) fn build(input: LineInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(match (options.as_printed, options.centred) {
        (false, false) => Box::new(EfLineFast::new(input)?),
        (false, true) => Box::new(EfLineFast::centred(input)?),
        (true, false) => {
            let printed = EfLineFastPrinted::program(input)?;
            Box::new(Watchdog::new(printed, printed.bound()))
        }
        (true, true) => {
            return Err(InputError::Option { method: Method::EfLineFast, option: "--centred with --as-printed" });
        }
    })
}

/// What the sign of `F` makes of a clock: whether it is diagonal, and what it adds to `F` (points 8.1 to 9.2).
const fn choose(s: &State, x_leads: bool) -> (bool, i64) {
    let LineInput { dx, dy, .. } = s.input;
    match (x_leads, s.f >= 0) {
        (true, true) => (false, -dy),
        (true, false) | (false, true) => (true, dx - dy),
        (false, false) => (false, dx),
    }
}

/// The line in both leading axes: an iterator over its clocks, up to the one that ends it.
///
/// x leads if `ΔX > ΔY`, else y: the document leaves `ΔX = ΔY` open, and with x leading such a line would end one short
/// in y. An axis steps only while its counter is not 0, which keeps back the false x step of point 9.1 at `ΔX = 0` and
/// no other. Every line takes max(ΔX, ΔY) clocks.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLineFast, LineInput};
/// let line = EfLineFast::new(LineInput::new(7, 3))?;
/// let steps: String = line.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XDXDXDX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfLineFast {
    state: State,
}

impl EfLineFast {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// As [`EfLine::new`](crate::EfLine::new).
    pub fn new(input: LineInput) -> Result<Self, InputError> {
        Ok(EfLineFast { state: State::load(input)? })
    }

    /// The same with `F₀ = ⌊ΔX/2⌋ − ΔY` where x leads and `F₀ = ΔX − ⌈ΔY/2⌉` where y does, for 0 (an extension): `F` of
    /// the point itself then lies within half of the longer increment around 0. The deviation is at most ½ BLU.
    ///
    /// # Errors
    /// As [`EfLineFast::new`].
    pub fn centred(input: LineInput) -> Result<Self, InputError> {
        let mut line = EfLineFast::new(input)?;
        let LineInput { dx, dy, .. } = input;
        line.state.f = if line.x_leads() { (dx >> 1) - dy } else { dx - dy + (dy >> 1) };
        Ok(line)
    }

    /// Point 7.
    const fn x_leads(&self) -> bool {
        self.state.input.dx > self.state.input.dy
    }
}

impl Interpolator for EfLineFast {
    fn state(&self) -> Clock {
        self.state.clock(false, false)
    }

    fn columns(&self) -> Columns {
        Columns::EVALUATION
    }
}

impl Iterator for EfLineFast {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let x_leads = self.x_leads();
        let s = &mut self.state;
        // Point 6.
        if s.end() {
            return None;
        }
        let (diagonal, change) = choose(s, x_leads);
        let (x, y) = ((x_leads || diagonal) && s.kox > 0, (!x_leads || diagonal) && s.koy > 0);
        if x {
            s.step_x();
        }
        if y {
            s.step_y();
        }
        s.f += change;
        Some(s.clock(x, y))
    }
}

impl FusedIterator for EfLineFast {}

/// The document's program or block diagram, literally. Only the counter of the leading axis is counted, and only it is
/// tested for the end.
///
/// With `ΔX = ΔY > 0`, for which the program says nothing, x leads here: such a line ends one short in y. With `ΔX = 0`
/// the program makes a false x step (9.1).
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLineFastPrinted, LineInput};
/// let steps = |dx, dy| -> Result<String, discreta::interpolate::InputError> {
///     Ok(EfLineFastPrinted::program(LineInput::new(dx, dy))?.map(|clock| clock.letter()).collect())
/// };
/// assert_eq!(steps(3, 3)?, "XDD");
/// assert_eq!(steps(0, 3)?, "DYY");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EfLineFastPrinted {
    state: State,
    x_leads: bool,
    /// The diagram: no KOY, and `F` in a register.
    diagram: bool,
}

impl EfLineFastPrinted {
    /// The program, points 1 to 9. Its memory cells are taken to be wide enough for `F`.
    ///
    /// # Errors
    /// As [`EfLineFast::new`].
    pub fn program(input: LineInput) -> Result<Self, InputError> {
        Ok(EfLineFastPrinted { state: State::load(input)?, x_leads: input.dx >= input.dy, diagram: false })
    }

    /// The block diagram: x leads whatever the increments are, there is no KOY, and `F` is kept modulo 2^(bits + 1),
    /// which makes a difference for `ΔX < ΔY` alone. Such a line, for which the diagram is not meant, ends after `ΔX`
    /// clocks short in y.
    ///
    /// # Errors
    /// As [`EfLineFast::new`].
    pub fn diagram(input: LineInput) -> Result<Self, InputError> {
        Ok(EfLineFastPrinted { state: State { koy: 0, ..State::load(input)? }, x_leads: true, diagram: true })
    }

    /// A bound for a watchdog: twice the clocks of the leading axis.
    #[must_use]
    pub const fn bound(&self) -> u64 {
        2 * if self.x_leads { self.state.kox } else { self.state.koy }
    }

    /// Point 6, for the leading axis.
    const fn end(&self) -> bool {
        (if self.x_leads { self.state.kox } else { self.state.koy }) == 0
    }

    fn clock(&self, x: bool, y: bool) -> Clock {
        Clock { end: self.end(), ..self.state.clock(x, y) }
    }
}

impl Interpolator for EfLineFastPrinted {
    fn state(&self) -> Clock {
        self.clock(false, false)
    }

    fn columns(&self) -> Columns {
        if self.diagram { Columns { left: &["kox"], ..Columns::EVALUATION } } else { Columns::EVALUATION }
    }
}

impl Iterator for EfLineFastPrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        if self.end() {
            return None;
        }
        let s = &mut self.state;
        let (diagonal, change) = choose(s, self.x_leads);
        let (x, y, kox, koy) = (self.x_leads || diagonal, !self.x_leads || diagonal, s.kox, s.koy);
        if x {
            s.step_x();
        }
        if y {
            s.step_y();
        }
        if self.x_leads {
            s.koy = koy;
        } else {
            s.kox = kox;
        }
        s.f += change;
        if self.diagram {
            let beyond = 63 - s.input.bits;
            s.f = s.f << beyond >> beyond;
        }
        Some(self.clock(x, y))
    }
}

impl FusedIterator for EfLineFastPrinted {}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(dx: i64, dy: i64) -> EfLineFast {
        EfLineFast::new(LineInput::new(dx, dy)).unwrap()
    }

    fn program(dx: i64, dy: i64) -> EfLineFastPrinted {
        EfLineFastPrinted::program(LineInput::new(dx, dy)).unwrap()
    }

    fn steps(line: impl Iterator<Item = Clock>) -> String {
        line.map(|c| c.letter()).collect()
    }

    fn all_8_bit() -> impl Iterator<Item = (i64, i64)> {
        (0..256).flat_map(|dx| (0..256).map(move |dy| (dx, dy)))
    }

    #[test]
    fn golden_steps() {
        assert_eq!(steps(line(7, 3)), "XDXDXDX");
        // by hand, points 8 and 9
        assert_eq!(line(7, 3).map(|c| c.sum[0]).collect::<Vec<_>>(), [-3, 1, -2, 2, -1, 3, 0]);
        assert_eq!(steps(line(3, 7)), "DYYDYDY");
        assert_eq!(line(3, 7).map(|c| c.sum[0]).collect::<Vec<_>>(), [-4, -1, 2, -2, 1, -3, 0]);
        assert_eq!(["", "XXX", "YYY", "DDD"], [(0, 0), (3, 0), (0, 3), (3, 3)].map(|(x, y)| steps(line(x, y))));
        assert!(line(0, 0).state().end);
    }

    /// Against the document's own formula for F(x, y), and how far from the line that is.
    #[test]
    fn every_8_bit_line_is_exact_in_as_many_clocks_as_its_longer_increment() {
        for (dx, dy) in all_8_bit() {
            let (mut clocks, mut last) = (0, line(dx, dy).state());
            for c in line(dx, dy) {
                clocks += 1;
                let f = c.at[1] * dx - c.at[0] * dy;
                assert!(f * f < dx * dx + dy * dy, "({dx}, {dy}) is a BLU off at {:?}", c.at);
                if dx > 0 {
                    assert_eq!(c.sum[0], f, "({dx}, {dy})");
                }
                assert_eq!([c.left[0] as i64, c.left[1] as i64], [dx - c.at[0], dy - c.at[1]]);
                assert_eq!(if dx > dy { c.step[0] } else { c.step[1] }, 1, "the leading axis always steps");
                last = c;
            }
            assert_eq!((last.end, last.at, clocks), (true, [dx, dy, 0], dx.max(dy)), "({dx}, {dy})");
        }
    }

    #[test]
    fn centred_8_bit_lines_are_exact_and_at_most_half_a_blu_off() {
        let mut exact = 0;
        for (dx, dy) in all_8_bit().filter(|&line| line != (0, 0)) {
            let (mut clocks, mut last) = (0, None);
            let centred = EfLineFast::centred(LineInput::new(dx, dy)).unwrap();
            let f0 = centred.state().sum[0];
            for c in centred {
                clocks += 1;
                let f = c.at[1] * dx - c.at[0] * dy;
                assert!(4 * f * f <= dx * dx + dy * dy, "({dx}, {dy}) at {:?}", c.at);
                assert_eq!(c.sum[0], f + f0, "({dx}, {dy})");
                assert!((-256..256).contains(&c.sum[0]), "F in 9 bits");
                last = Some(c);
            }
            let last = last.unwrap();
            exact += usize::from((last.end, last.at, clocks) == (true, [dx, dy, 0], dx.max(dy)));
        }
        assert_eq!(exact, 65_535);
    }

    #[test]
    fn as_printed_equals_the_corrected_line_but_for_ties_and_dx_0() {
        for (dx, dy) in all_8_bit().filter(|&(dx, dy)| dx > 0 && dx != dy) {
            assert!(program(dx, dy).map(|c| (c.at, c.sum, c.end)).eq(line(dx, dy).map(|c| (c.at, c.sum, c.end))));
        }
        for (dx, dy) in all_8_bit().filter(|&(dx, dy)| dx > dy) {
            let diagram = EfLineFastPrinted::diagram(LineInput::new(dx, dy)).unwrap();
            assert!(diagram.map(|c| (c.at, c.sum, c.end)).eq(line(dx, dy).map(|c| (c.at, c.sum, c.end))));
        }
    }

    #[test]
    fn as_printed_every_line_with_dx_equal_to_dy_ends_one_short_in_y() {
        let short = |printed: fn(LineInput) -> Result<EfLineFastPrinted, InputError>| {
            let ends = |n: i64| printed(LineInput::new(n, n)).unwrap().last().is_some_and(|c| c.at == [n, n - 1, 0]);
            (1..256).filter(|&n| ends(n)).count()
        };
        assert_eq!((short(EfLineFastPrinted::program), short(EfLineFastPrinted::diagram)), (255, 255));
    }

    #[test]
    fn as_printed_dx_0_makes_a_false_x_step() {
        for n in 1..256 {
            assert_eq!(steps(program(0, n)), format!("D{}", "Y".repeat(n as usize - 1)));
            assert_eq!(program(0, n).last().map(|c| (c.at, c.left)), Some(([1, n, 0], [0; 3])));
            // the diagram does nothing at all
            assert!(EfLineFastPrinted::diagram(LineInput::new(0, n)).unwrap().state().end);
        }
    }

    #[test]
    fn the_diagram_is_short_in_y_where_y_should_lead() {
        for (dx, dy) in all_8_bit().filter(|&(dx, dy)| 0 < dx && dx < dy) {
            let last = EfLineFastPrinted::diagram(LineInput::new(dx, dy)).unwrap().last().unwrap();
            assert!(last.end && last.at[0] == dx && last.at[1] < dx, "({dx}, {dy}) ends at {:?}", last.at);
        }
    }

    #[test]
    fn options_choose() {
        let input = LineInput::new(3, 3);
        let steps = |options| build(input, &options).map(steps);
        let (printed, centred) = (true, true);
        assert_eq!(steps(Options::default()).as_deref(), Ok("DDD"));
        assert_eq!(steps(Options { as_printed: printed, ..Options::default() }).as_deref(), Ok("XDD"));
        assert_eq!(steps(Options { centred, ..Options::default() }).as_deref(), Ok("DDD"));
        assert!(steps(Options { as_printed: printed, centred, ..Options::default() }).is_err());
    }
}
