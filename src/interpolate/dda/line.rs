//! Line by differential increments: document A, «Линейна интерполация».
//!
//! `x' = ΔX·k`, `y' = ΔY·k` with `k = 2^−p`: each clock adds the increments to the accumulators. [`DdaLine`] is the
//! document's program with its FLAG mended; [`DdaLinePrinted`] takes the program at its word.

use std::iter::FusedIterator;

use super::{State, check_options, columns, normalise};
use crate::{Clock, Columns, InputError, Interpolator, LineInput, Method, Options};

/// What the command line asks for.
pub(crate) fn build(input: LineInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    Ok(if options.as_printed {
        Box::new(DdaLinePrinted::new(input, options)?)
    } else {
        Box::new(DdaLine::new(input, options)?)
    })
}

/// The line by differential increments: an iterator over its clocks, up to the one that ends it.
///
/// After `n` clocks an axis has made `⌊n·Δ/2^p⌋` steps, so a line ends at exactly clock 2^p, whatever its length; only
/// (0, 0) ends at START. With [`Options::half_preload`] it has made `⌊n·Δ/2^p + ½⌋`: nearer to the line, and the end
/// comes with the last step, at clock 2^p or before. With [`Options::normalise`] the increments are shifted left by `s` before
/// the start, and the same points come in `2^(p−s)` clocks; `s` is [`Clock::sum`]'s third number. An axis steps only
/// while its counter is not 0.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{DdaLine, LineInput, Options};
/// let input = LineInput { bits: 3, ..LineInput::new(5, 4) };
/// let steps = |options| DdaLine::new(input, &options).map(|line| line.map(|clock| clock.letter()).collect::<String>());
/// assert_eq!(steps(Options::default())?, "-D-DXYXD");
/// assert_eq!(steps(Options { half_preload: true, ..Options::default() })?, "D-DXYXYX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaLine {
    state: State,
    /// `Р1`, `Р2`: what is added, shifted if it is normalised.
    increment: [i64; 2],
    shifts: Option<u32>,
}

impl DdaLine {
    /// Points 1 to 3: loads the registers.
    ///
    /// # Errors
    /// What [`LineInput::check`] refuses; an option that a line by differential increments does not have.
    pub fn new(input: LineInput, options: &Options) -> Result<Self, InputError> {
        check_options(Method::DdaLine, options)?;
        let state = load(input, options)?;
        let shifts = options.normalise.then(|| normalise::shifts(input.dx, input.dy, input.bits));
        let increment = [input.dx, input.dy].map(|d| d << shifts.unwrap_or(0));
        Ok(DdaLine { state, increment, shifts })
    }
}

fn load(input: LineInput, options: &Options) -> Result<State, InputError> {
    input.check()?;
    let LineInput { xh, yh, dx, dy, bits } = input;
    Ok(State::load([xh, yh], [dx, dy], bits, options.half_preload))
}

impl Interpolator for DdaLine {
    fn state(&self) -> Clock {
        self.state.clock([0; 2], self.shifts)
    }

    fn columns(&self) -> Columns {
        columns(self.shifts.is_some())
    }
}

impl Iterator for DdaLine {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        // Point 7.
        if s.end() {
            return None;
        }
        // Points 8 to 10. FLAG is the number of carries of this pass: it is cleared where 4 and 5 have seen it, and any
        // but 0 moves.
        let mut step = [0; 2];
        for (axis, step) in step.iter_mut().enumerate() {
            let carry = s.add(axis, self.increment[axis]);
            if carry && s.left[axis] > 0 {
                s.step(axis, 1);
                *step = 1;
            }
        }
        Some(s.clock(step, self.shifts))
    }
}

impl FusedIterator for DdaLine {}

/// Points 4 to 10 of the program, literally: FLAG counts every carry and is never cleared, and only FLAG = 1 moves.
///
/// The cells `XT`, `YT`, `KOX`, `KOY` go on to the end as they should, but the device is moved (point 5) at the first
/// carry alone, and not even then if both axes carry in one pass: [`Clock::step`] is what it is moved by, [`Clock::at`]
/// what the cells hold.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{DdaLinePrinted, LineInput, Options};
/// let input = LineInput { bits: 3, ..LineInput::new(5, 2) };
/// let line = DdaLinePrinted::new(input, &Options::default())?;
/// let moved: String = line.clone().map(|clock| clock.letter()).collect();
/// assert_eq!(moved, "-X------");
/// assert_eq!(line.last().map(|clock| clock.at), Some([5, 2, 0]));
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaLinePrinted {
    state: State,
    increment: [i64; 2],
    flag: u64,
}

impl DdaLinePrinted {
    /// Points 1 to 3.
    ///
    /// # Errors
    /// As [`DdaLine::new`].
    pub fn new(input: LineInput, options: &Options) -> Result<Self, InputError> {
        check_options(Method::DdaLine, &Options { as_printed: true, ..*options })?;
        Ok(DdaLinePrinted { state: load(input, options)?, increment: [input.dx, input.dy], flag: 0 })
    }
}

impl Interpolator for DdaLinePrinted {
    fn state(&self) -> Clock {
        self.state.clock([0; 2], None)
    }

    fn columns(&self) -> Columns {
        Columns::DDA
    }
}

impl Iterator for DdaLinePrinted {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        let s = &mut self.state;
        if s.end() {
            return None;
        }
        let mut step = [0; 2];
        for (axis, step) in step.iter_mut().enumerate() {
            if s.add(axis, self.increment[axis]) {
                s.step(axis, 1);
                *step = 1;
                self.flag += 1;
            }
        }
        // Points 4 and 5 of the next pass: the device has this clock's step to make, or was there before.
        if self.flag != 1 {
            step = [0; 2];
        }
        Some(s.clock(step, None))
    }
}

impl FusedIterator for DdaLinePrinted {}
