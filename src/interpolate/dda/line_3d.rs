//! Line in space by differential increments: document A, «Линейна интерполация», with a third accumulator.
//!
//! On every clock each of the three accumulators takes the increment of its axis, modulo 2^p; a carry is a step. After n
//! clocks an axis has made `⌊(S₀ + n·Δa)/2^p⌋` steps: from `S₀ = 0` all three end at clock 2^p, whatever the line.

use std::iter::FusedIterator;

use super::check_options;
use crate::{Clock, Columns, InputError, Interpolator, Line3dInput, Method, Options};

/// What the command line asks for.
pub(crate) fn build(input: Line3dInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    check_options(Method::DdaLine3d, options)?;
    Ok(Box::new(DdaLine3d::new(input, options.half_preload)?))
}

/// The line in space: an iterator over its clocks, up to the one that ends it.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{DdaLine3d, Line3dInput};
/// let line = DdaLine3d::new(Line3dInput { start: [0; 3], increment: [5, 4, 7], bits: 3 }, false)?;
/// let steps: String = line.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "-AZAEFEA");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DdaLine3d {
    input: Line3dInput,
    at: [i64; 3],
    left: [i64; 3],
    s: [i64; 3],
}

impl DdaLine3d {
    /// Loads the registers as START does. The accumulators begin at 0 or, preloaded, at half of their volume,
    /// 2^(bits−1), which puts the steps in the middle of where they may be.
    ///
    /// # Errors
    /// If an increment is negative, or it or a coordinate does not fit the registers, or their width is not possible.
    pub fn new(input: Line3dInput, half_preload: bool) -> Result<Self, InputError> {
        input.check()?;
        let s = if half_preload { 1 << (input.bits - 1) } else { 0 };
        Ok(DdaLine3d { input, at: input.start, left: input.increment, s: [s; 3] })
    }

    fn clock(&self, step: [i8; 3]) -> Clock {
        let end = self.left == [0; 3];
        Clock { step, at: self.at, left: self.left.map(i64::unsigned_abs), sum: self.s, end }
    }
}

impl Interpolator for DdaLine3d {
    fn state(&self) -> Clock {
        self.clock([0; 3])
    }

    fn columns(&self) -> Columns {
        Columns { at: &["xt", "yt", "zt"], left: &["kox", "koy", "koz"], sum: &["sx", "sy", "sz"] }
    }
}

impl Iterator for DdaLine3d {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        if self.left == [0; 3] {
            return None;
        }
        let mut step = [0; 3];
        for (a, step) in step.iter_mut().enumerate() {
            // points 8 to 10
            self.s[a] += self.input.increment[a];
            if self.s[a] >= 1 << self.input.bits {
                self.s[a] -= 1 << self.input.bits;
                *step = 1;
                self.at[a] += 1;
                self.left[a] -= 1;
            }
        }
        Some(self.clock(step))
    }
}

impl FusedIterator for DdaLine3d {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ideal;

    fn line(increment: [i64; 3], bits: u32, half: bool) -> DdaLine3d {
        DdaLine3d::new(Line3dInput { start: [0; 3], increment, bits }, half).unwrap()
    }

    #[test]
    fn steps_by_hand() {
        let steps = |d, half| line(d, 3, half).map(|c| c.letter()).collect::<String>();
        // the golden line (5, 4) of the plane
        assert_eq!(steps([5, 4, 0], false), "-D-DXYXD");
        assert_eq!(steps([0, 0, 0], false), "");
        assert_eq!(steps([0, 0, 1], false), "-------Z");
        assert_eq!(steps([0, 0, 1], true), "---Z");
        // from 4 by 3 modulo 8: 7 2 5 0 3 6 1 4; by 7: 3 2 1 0 7 6 5 4
        assert_eq!(steps([3, 0, 7], true), "ZEZE-ZEZ");
    }

    fn worst(bits: u32, half: bool) -> f64 {
        let n = 1_i64 << bits;
        let mut worst = 0_f64;
        for d in (0..n * n * n).map(|k| [k / n / n, k / n % n, k % n]) {
            let ideal = Ideal::segment([0; 3], d);
            let s0 = if half { n / 2 } else { 0 };
            let (mut clocks, mut last) = (0, [0; 3]);
            for c in line(d, bits, half) {
                clocks += 1;
                assert_eq!(c.at, d.map(|d| (s0 + clocks * d) / n), "{d:?}");
                assert_eq!(c.end, c.at == d);
                worst = worst.max(ideal.deviation(c.at.map(|v| v as f64)));
                last = c.at;
            }
            assert_eq!(last, d);
            let full = if d == [0; 3] { 0 } else { n };
            assert!(if half { clocks <= full } else { clocks == full }, "{d:?}: {clocks}");
        }
        worst
    }

    #[test]
    fn every_line_is_the_formula_and_ends_at_clock_2_to_the_p() {
        let round = |v: f64| (v * 1e4).round() / 1e4;
        assert_eq!([4, 5].map(|bits| round(worst(bits, false))), [1.3141, 1.3672]);
        assert_eq!([4, 5].map(|bits| round(worst(bits, true))), [0.828, 0.8475]);
    }

    #[test]
    fn the_widest_line() {
        let most = (1 << 32) - 1;
        let mut widest = line([most, 1, 0], 32, false);
        assert_eq!(widest.nth(2).unwrap().sum, [most - 2, 3, 0]);
        assert_eq!(widest.state().at, [2, 0, 0]);
    }
}
