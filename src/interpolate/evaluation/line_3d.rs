//! Line in space by evaluation function: the accelerated line of document B with one function an axis.
//!
//! The document knows two axes, but speaks of pulses "along three axes" («по три оси», constant speed): so a clock may
//! step all of them, as in its accelerated algorithm, where the leading axis steps on every clock. With `N` the greatest
//! increment and `n` the clocks made, axis a has
//!
//! `Fa = (a − AH)·N − n·Δa + Fa₀`,
//!
//! which is below 0 where the axis lags. `Fa < 0`: the axis steps, `Fa += N − Δa`; `Fa ≥ 0`: it does not, `Fa −= Δa`.
//! These are points 8.1 and 8.2 of the program for each axis. `Fa₀` is −1 or 0: it says whether an axis exactly on the
//! line steps. The leading one has to, and begins at −1, where it stays. Of the others those before it do (point 9.1, x
//! before y), those after it do not (8.1), and an axis without an increment never does. In the plane this is
//! the accelerated line, step by step.

use std::iter::FusedIterator;

use crate::{Clock, Columns, InputError, Interpolator, Line3dInput, Method, Options};

/// What the command line asks for.
pub(crate) fn build(input: Line3dInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    if options.as_printed {
        return Err(InputError::Option { method: Method::EfLine3d, option: "--as-printed" });
    }
    Ok(Box::new(if options.centred { EfLine3d::centred(input)? } else { EfLine3d::new(input)? }))
}

/// The line in space: an iterator over its clocks, up to the one that ends it.
///
/// It takes as many clocks as the greatest increment has BLU, and ends at its end point exactly. No axis is ever a BLU
/// from the line at its clock; the path stays nearer to it than √2 BLU.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLine3d, Line3dInput};
/// let line = EfLine3d::new(Line3dInput { start: [0; 3], increment: [7, 3, 2], bits: 8 })?;
/// let steps: String = line.map(|clock| clock.letter()).collect();
/// assert_eq!(steps, "XAXDEDX");
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EfLine3d {
    input: Line3dInput,
    /// The greatest increment.
    lead: i64,
    at: [i64; 3],
    left: [i64; 3],
    f: [i64; 3],
}

impl EfLine3d {
    /// Loads the registers as START does.
    ///
    /// # Errors
    /// If an increment is negative, or it or a coordinate does not fit the registers, or their width is not possible.
    pub fn new(input: Line3dInput) -> Result<Self, InputError> {
        let [dx, dy, dz] = input.increment;
        // Of equal increments the later axis leads, as y does where the document's program leaves ΔX = ΔY out.
        let at_or_before_the_leader = [true, dy.max(dz) >= dx, dz >= dx.max(dy)];
        let f = [0, 1, 2].map(|a| -i64::from(at_or_before_the_leader[a] && input.increment[a] > 0));
        EfLine3d::with(input, f)
    }

    /// With each function in the middle of its range, `Fa₀ = ⌊N/2⌋ − Δa`: no axis is more than half a BLU from the line
    /// at its clock. An extension.
    ///
    /// # Errors
    /// As [`EfLine3d::new`].
    pub fn centred(input: Line3dInput) -> Result<Self, InputError> {
        let [dx, dy, dz] = input.increment;
        EfLine3d::with(input, input.increment.map(|d| (dx.max(dy).max(dz) >> 1).saturating_sub(d)))
    }

    fn with(input: Line3dInput, f: [i64; 3]) -> Result<Self, InputError> {
        input.check()?;
        let [dx, dy, dz] = input.increment;
        Ok(EfLine3d { input, lead: dx.max(dy).max(dz), at: input.start, left: input.increment, f })
    }

    fn clock(&self, step: [i8; 3]) -> Clock {
        let end = self.left == [0; 3];
        Clock { step, at: self.at, left: self.left.map(i64::unsigned_abs), sum: self.f, end }
    }
}

impl Interpolator for EfLine3d {
    fn state(&self) -> Clock {
        self.clock([0; 3])
    }

    fn columns(&self) -> Columns {
        Columns { at: &["xt", "yt", "zt"], left: &["kox", "koy", "koz"], sum: &["fx", "fy", "fz"] }
    }
}

impl Iterator for EfLine3d {
    type Item = Clock;

    fn next(&mut self) -> Option<Clock> {
        if self.left == [0; 3] {
            return None;
        }
        let mut step = [0; 3];
        for (a, step) in step.iter_mut().enumerate() {
            if self.f[a] < 0 {
                *step = 1;
                self.at[a] += 1;
                self.left[a] -= 1;
                self.f[a] += self.lead;
            }
            self.f[a] -= self.input.increment[a];
        }
        Some(self.clock(step))
    }
}

impl FusedIterator for EfLine3d {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ideal;

    fn input(increment: [i64; 3]) -> Line3dInput {
        Line3dInput { start: [0; 3], increment, bits: 8 }
    }

    fn steps(increment: [i64; 3]) -> String {
        EfLine3d::new(input(increment)).unwrap().map(|c| c.letter()).collect()
    }

    fn every(bits: u32) -> impl Iterator<Item = [i64; 3]> {
        let n = 1 << bits;
        (0..n * n * n).map(move |k| [k / n / n, k / n % n, k % n])
    }

    #[test]
    fn steps_by_hand() {
        assert_eq!(steps([0, 0, 0]), "");
        assert_eq!(steps([0, 0, 2]), "ZZ");
        assert_eq!(steps([2, 2, 2]), "AA");
        // N = 3; y: F = 0 −2 −1, steps at 2 and 3; z: F = 0 −1 1, steps at 2
        assert_eq!(steps([3, 2, 1]), "XAD");
        // z leads, so x and y begin at −1; x: F = −1 1 0, steps at 1; y: F = −1 0 −2, steps at 1 and 3
        assert_eq!(steps([1, 2, 3]), "AZF");
        let line = EfLine3d::new(input([1, 2, 3])).unwrap();
        assert_eq!(line.map(|c| c.sum).collect::<Vec<_>>(), [[1, 0, -1], [0, -2, -1], [-1, -1, -1]]);
    }

    /// The document's golden line of the plane.
    #[test]
    fn in_the_plane_it_is_the_accelerated_line() {
        assert_eq!(steps([7, 3, 0]), "XDXDXDX");
        // Points 8 and 9 of the program, with y leading where ΔX = ΔY and no x step where ΔX = 0.
        for [dx, dy, _] in every(5).filter(|d| d[2] == 0) {
            let (mut x, mut y, mut f, mut program) = (0, 0, 0, String::new());
            while x < dx || y < dy {
                let both = if dx > dy { f < 0 } else { f >= 0 && dx > 0 };
                program.push(if both {
                    'D'
                } else if dx > dy {
                    'X'
                } else {
                    'Y'
                });
                if both || dx > dy {
                    (x, f) = (x + 1, f - dy);
                }
                if both || dx <= dy {
                    (y, f) = (y + 1, f + dx);
                }
            }
            assert_eq!(steps([dx, dy, 0]), program, "({dx}, {dy})");
        }
    }

    /// Each clock against the line itself, for every line of 4 bits and of 5.
    fn worst(new: fn(Line3dInput) -> Result<EfLine3d, InputError>, bits: u32) -> f64 {
        let mut worst = 0_f64;
        for d in every(bits) {
            let lead = *d.iter().max().unwrap();
            let ideal = Ideal::segment([0; 3], d);
            let mut line = new(input(d)).unwrap();
            for clock in 1..=lead {
                let c = line.next().unwrap();
                for a in 0..3 {
                    // |a − n·Δa/N| < 1
                    assert!((c.at[a] * lead - clock * d[a]).abs() < lead, "{d:?}");
                    assert_eq!(c.left[a] as i64, d[a] - c.at[a]);
                }
                assert_eq!((c.end, c.at == d), (clock == lead, clock == lead), "{d:?}");
                worst = worst.max(ideal.deviation(c.at.map(|v| v as f64)));
            }
            assert_eq!(line.next(), None);
            assert!(line.state().end);
        }
        worst
    }

    #[test]
    fn every_line_ends_and_keeps_near() {
        let round = |v: f64| (v * 1e4).round() / 1e4;
        let [plain, centred] = [EfLine3d::new, EfLine3d::centred].map(|new| [4, 5].map(|bits| round(worst(new, bits))));
        assert_eq!(plain, [1.3141, 1.3672]);
        assert_eq!(centred, [0.7035, 0.7063]);
    }

    #[test]
    fn the_widest_line() {
        let most = (1 << 32) - 1;
        let mut line =
            EfLine3d::new(Line3dInput { start: [0, -1, most], increment: [most, 1, most - 1], bits: 32 }).unwrap();
        // y and z: F = 0, then below 0 and a step
        assert_eq!(line.nth(1).unwrap().at, [2, 0, most + 1]);
        assert_eq!(line.state().sum, [-1, most - 2, 2 - most]);
    }

    #[test]
    fn what_the_registers_do_not_hold_is_refused() {
        let refused = |increment| EfLine3d::new(input(increment)).unwrap_err().to_string();
        assert_eq!(refused([0, 0, 256]), "DZ = 256 is above 255, the greatest of 8 bits");
        assert_eq!(
            refused([0, i64::MIN, 0]),
            format!("DY = {} is negative: the line or arc has to lie in the first quadrant", i64::MIN)
        );
        assert!(EfLine3d::centred(input([i64::MIN, 0, i64::MAX])).is_err());
    }
}
