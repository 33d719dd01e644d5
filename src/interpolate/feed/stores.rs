//! The synchroniser as what it is meant to be: for each axis a store of up to two steps.

use super::super::{Clock, Interpolator};

/// Steps that a synchroniser holds: one in each D flip-flop.
const DEPTH: u8 = 2;

/// The stores of the axes. Each step of the interpolator goes into that of its axis; each Δt takes one out of every
/// store that has one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Stores([u8; 3]);

impl Stores {
    /// STOP: a store is full.
    #[must_use]
    pub fn stop(&self) -> bool {
        self.0.contains(&DEPTH)
    }

    /// No step is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0 == [0; 3]
    }

    /// How many steps each axis has stored.
    #[must_use]
    pub const fn waiting(&self) -> [u8; 3] {
        self.0
    }

    /// A clock of the interpolator, which runs only while there is no STOP: a step that finds its store full is lost.
    /// Returns whether all went in.
    pub fn put(&mut self, steps: [bool; 3]) -> bool {
        let mut all = true;
        for (store, step) in self.0.iter_mut().zip(steps) {
            let full = *store == DEPTH;
            all &= !(step && full);
            *store += u8::from(step && !full);
        }
        all
    }

    /// A pulse of Δt: the axes whose drives step.
    pub fn take(&mut self) -> [bool; 3] {
        let steps = self.0.map(|n| n > 0);
        self.0 = self.0.map(|n| n.saturating_sub(1));
        steps
    }
}

/// An interpolator behind its stores: an iterator over the pulses of Δt, each with the steps of the drives, until КРАЙ
/// has come and the stores have drained.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::{EfLine, LineInput, feed::Feed};
/// let feed = Feed::new(EfLine::new(LineInput::new(5, 3))?);
/// let axes: Vec<[bool; 3]> = feed.collect();
/// let steps: String = axes.iter().map(|s| if s[0] && s[1] { 'D' } else if s[0] { 'X' } else { 'Y' }).collect();
/// assert_eq!(steps, "DDXDX"); // from XYXYXXYX
/// # Ok::<(), discreta::interpolate::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Feed<I> {
    interpolator: I,
    stores: Stores,
}

impl<I: Interpolator> Feed<I> {
    /// The interpolator as START leaves it, with empty stores.
    #[must_use]
    pub fn new(interpolator: I) -> Feed<I> {
        Feed { interpolator, stores: Stores::default() }
    }

    /// What the stores hold.
    #[must_use]
    pub const fn stores(&self) -> Stores {
        self.stores
    }

    /// The interpolator, which is ahead of the drives.
    #[must_use]
    pub const fn interpolator(&self) -> &I {
        &self.interpolator
    }
}

impl<I: Interpolator> Iterator for Feed<I> {
    type Item = [bool; 3];

    fn next(&mut self) -> Option<[bool; 3]> {
        // at its own pace, until it is stopped
        while !self.stores.stop()
            && let Some(Clock { step, .. }) = self.interpolator.next()
        {
            self.stores.put(step.map(|s| s != 0));
        }
        (!self.stores.is_empty()).then(|| self.stores.take())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EfLine, LineInput};

    #[test]
    fn a_store_holds_two_steps_of_an_axis() {
        let mut stores = Stores::default();
        assert!(stores.put([true, false, true]) && !stores.stop());
        assert!(stores.put([true, false, false]) && stores.stop());
        assert_eq!(stores.waiting(), [2, 0, 1]);
        assert!(!stores.put([true, true, false]), "the third step of x is lost");
        assert_eq!(stores.waiting(), [2, 1, 1]);
        assert_eq!(stores.take(), [true; 3]);
        assert_eq!(stores.take(), [true, false, false]);
        assert!(stores.is_empty());
        assert_eq!(stores.take(), [false; 3]);
    }

    #[test]
    fn every_step_comes_out_once_and_the_axes_are_pulled_together() {
        let mut worst: f64 = 0.0;
        for dx in 0..256 {
            for dy in 0..256 {
                let feed = Feed::new(EfLine::new(LineInput::new(dx, dy)).unwrap());
                let (mut clocks, mut at) = (0, [0, 0]);
                for steps in feed {
                    clocks += 1;
                    at = [at[0] + i64::from(steps[0]), at[1] + i64::from(steps[1])];
                    // the drive is beside the line: the cross product is |line| times the distance
                    let off = (at[1] * dx - at[0] * dy).abs() as f64 / ((dx * dx + dy * dy) as f64).sqrt();
                    worst = worst.max(if dx + dy > 0 { off } else { 0.0 });
                }
                assert_eq!(at, [dx, dy]);
                assert!(clocks >= dx.max(dy) && clocks <= dx + dy, "({dx}, {dy}) in {clocks}");
            }
        }
        assert!(worst < 1.0, "{worst}");
    }
}
